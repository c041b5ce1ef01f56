//! Girtin's document: what is painted, how it is simulated, what it looks like, and every file.
//!
//! In the order data flows:
//! - [`document`]: a sheet and glazes of events, as TOML or JSON; [`area`]: where something is done; [`wash_settings`]: the
//!   TOML of a single wash;
//! - [`gallery`]: the paper's figures as documents;
//! - [`drawing`]: contours at any resolution; [`brush`]: marks; `fill`: washes that fill contours; [`surface`]: what a sheet
//!   shows below a millimetre;
//! - [`resolve`]: millimetres become cells, names become pigments;
//! - [`maps`]: where the maps are that it names;
//! - [`memory`]: how much memory it will take; [`effort`]: how long;
//! - [`paint`]: every glaze is simulated; [`dried`]: what it left, cell by cell;
//! - [`develop`]: the picture, at its own resolution; [`composite`]: pigment becomes color;
//! - [`timelapse`]: the picture as it grows; [`contact_sheet`]: many pictures in one, with their names in
//!   [`lettering`];
//! - files: [`girtin_file`], a painting that stands alone; [`state_file`], a wash's state as NumPy reads it;
//!   [`map_file`]; [`picture`], pictures in and out; [`ora`], glazes as layers; [`film`], a painting as it grows.
#![forbid(unsafe_code)]

pub mod document;
pub mod area;
pub mod wash_settings;
pub mod gallery;
pub mod drawing;
pub mod brush;
pub mod fill;
pub mod surface;
mod spline;
pub mod resolve;
pub mod maps;
pub mod memory;
pub mod effort;
pub mod paint;
mod easel;
pub mod dried;
pub mod develop;
pub mod composite;
pub mod timelapse;
pub mod contact_sheet;
pub mod lettering;

mod archive;
pub mod girtin_file;
pub mod state_file;
pub mod map_file;
pub mod picture;
pub mod ora;
pub mod film;

pub use contact_sheet::ContactSheet;
pub use develop::Development;
pub use document::{Document, Stock};
pub use girtin_file::{GirtinFile, GirtinFileError, PaintedRecord};
pub use maps::{MapChest, Maps, StoredMap};
pub use paint::{PaintConfig, PaintError, Painted, PaintedGlaze, PigmentBalance, WaterDetail};
pub use resolve::ResolveError;
pub use timelapse::Timelapse;
pub use wash_settings::{WashSettings, handling_of};
