//! Watercolorization as in Curtis et al. 1997, §6.2: mattes and an ordered list of pigments, one pigment a glaze.
//!
//! In the order data flows:
//! - [`glazes_file`]: which pigments each matte has, and every number of the method, as TOML;
//! - [`mod@thickness_steps`]: a few thicknesses of each pigment, evenly far apart in what they do to light;
//! - [`separation`]: the colors of all stacks of them, in a tree;
//! - [`target_glaze`]: for each pixel the stack that comes nearest, hence how much of each pigment is wanted where;
//! - [`brushstrokes`]: one glaze is painted step by step and corrected on the way;
//! - [`painter`]: all of it, and the document that comes of it.

pub mod glazes_file;
pub mod thickness_steps;
pub mod separation;
pub mod target_glaze;
mod seams;
mod stretch;
mod low_pass;
pub mod brushstrokes;
pub mod painter;

pub use brushstrokes::{Look, NamedMap, PlanningParams};
pub use glazes_file::{GlazesFile, Lift, MatteGlazes};
pub use painter::{C97Config, C97Error, C97Glaze, C97Painting, C97Request, watercolorize_c97};
pub use separation::{ColorSeparation, SeparationParams, TooManyStacks};
pub use target_glaze::target_glazes;
pub use thickness_steps::thickness_steps;
