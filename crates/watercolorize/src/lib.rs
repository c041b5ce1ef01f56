//! A picture becomes a painting: few transparent washes of real pigments, light to dark, planned on what dried.
//!
//! In the order data flows:
//! - [`settings`]: what is asked for, and presets of it;
//! - [`mount`]: the photograph on its sheet; [`attention`]: what of it is drawn exactly, and `faces`;
//! - [`abstraction`]: fewer, flatter shapes; [`regions`]: shapes whose borders are hard edges; [`lines`]: ink and masking
//!   fluid;
//! - [`tone`]: a watercolor's tones; [`palette`]: pigments that mix its colors; [`separate`]: how much of each;
//! - [`study`]: all that is known of the photograph before the first wash; `reserves`: what of the sheet stays bare;
//! - `washes`: what is asked of the first wash, and of the last; `walls`: where its shapes keep apart; `intent`: what
//!   it is to look like; `load`: what of that is missing on the sheet as the washes below dried, and how much water and
//!   pigment are laid for it;
//! - [`painter`]: wash by wash, until the painting is done.
//!
//! And for whoever has pigments in order and regions, or wants to cut them out:
//! - [`superpixels`](mod@superpixels): pixels gathered into small patches of one color;
//! - [`mattes`](mod@mattes): patches gathered into regions, a matte each;
//! - [`scissors`]: a matte cut out by hand, along the outlines of the picture;
//! - [`c97`]: mattes and an ordered list of pigments become a document, as in Curtis et al. 1997, §6.2.
#![forbid(unsafe_code)]

pub mod settings;
pub mod mount;
pub mod attention;
mod faces;
pub mod abstraction;
pub mod regions;
pub mod lines;
pub mod tone;
pub mod palette;
pub mod separate;
pub mod study;
mod reserves;
mod washes;
mod walls;
mod intent;
mod load;
pub mod painter;

mod accidents;

pub mod superpixels;
pub mod mattes;
pub mod scissors;
pub mod c97;

pub use mount::{Border, Mounting, PAPER};
pub use painter::{Painting, PhotoError, Request, Stage, Watch, watercolorize};
pub use settings::{PRESETS, PhotoParams, Preset};
