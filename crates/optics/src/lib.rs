//! Kubelka-Munk optics: what color paint shows on what lies below it.
//!
//! In the order data flows:
//! - [`color`]: colors that say what they hold, linear or encoded, and how different two of them look;
//! - [`kubelka_munk`]: a pigment's absorption and scattering, layers of it, stacks and mixtures;
//! - [`pigment`]: a named paint, its optics and how it handles in water, from a TOML file;
//! - [`library`]: the paints that come with Girtin, found by any of their names;
//! - [`palette`]: some of them, and a painter's own, from a file.
//!
//! ```
//! use girtin_optics::{Library, LinearRgb, glaze};
//!
//! let library = Library::builtin();
//! let blue = library.get("French Ultramarine")?;
//! let brown = library.get("PBr7 burnt umber")?;
//! // A thin brown wash, left to dry, then a mixture of both over it.
//! let wash = brown.coefficients.layer(0.2).over_ground(LinearRgb::WHITE);
//! let shadow = glaze([(&blue.coefficients, 0.6), (&brown.coefficients, 0.3)], wash);
//! assert!(shadow.luminance() < wash.luminance());
//! assert_eq!(shadow.to_srgb().to_string().len(), "#rrggbb".len());
//! # Ok::<(), girtin_optics::UnknownPigment>(())
//! ```
#![forbid(unsafe_code)]

pub mod color;
pub mod kubelka_munk;
pub mod library;
pub mod palette;
pub mod pigment;

pub use color::{BadHex, Lab, LinearRgb, Srgb};
pub use kubelka_munk::{Coefficients, ImpossibleAppearance, Layer, Published, glaze, glaze_row, mixture};
pub use library::{Library, UnknownPigment};
pub use palette::Palette;
pub use pigment::{Character, Handling, Pigment};
