//! A picture becomes a painting: few transparent washes of real pigments, light to dark, planned on what dried.
//!
//! In the order data flows:
//! - [`settings`]: what is asked for, in a painter's words, and presets of it;
//! - [`mount`]: the photograph on its sheet;
//! - looking: [`attention`] and `faces`, [`texture`], [`simplify`], all of it in [`study`];
//! - deciding: [`values`], few and in a light key; [`masses`] of one tone, and their [`contours`]; [`shapes`], a mix with a
//!   gradient each; `edges`, crisp, lost or dragged; `border`, where the painting ends;
//! - marking: [`tracer`] finds strokes, [`accents`] which of them are darks and lights, [`rules`] put them for texture;
//!   `strokes` are all the marks of a picture;
//! - mixing: [`palette`], pigments that mix its colors; [`separate`] and `mixing`, how much of each in every wash;
//! - [`painter`]: all of it as a document, and the document painted.
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
pub mod texture;
mod crisp;
pub mod simplify;
pub mod study;
pub mod values;
mod segments;
pub mod masses;
pub mod contours;
pub mod shapes;
mod border;
mod edges;
mod brushwork;
pub mod tracer;
pub mod accents;
pub mod rules;
mod strokes;
mod pencil;
pub mod palette;
pub mod separate;
mod mixing;
pub mod painter;

mod accidents;

pub mod superpixels;
pub mod mattes;
pub mod scissors;
pub mod c97;

pub use mount::{Border, Mounting, PAPER};
pub use painter::{Painting, PhotoError, Request, Stage, Watch, watercolorize};
pub use settings::{PRESETS, PhotoParams, Preset};
