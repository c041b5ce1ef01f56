//! The figures of Curtis et al. 1997 as documents.

/// A document that comes with Girtin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Example {
    /// Its name, and that of its picture's file without the ending.
    pub name: &'static str,
    /// Its TOML.
    pub text: &'static str,
}

macro_rules! examples {
    ($($name:literal),* $(,)?) => {
        [$(Example { name: $name, text: include_str!(concat!("../assets/", $name, ".toml")) }),*]
    };
}

/// The six effects of figures 1 and 2, in the order of the paper.
pub const EFFECTS: [Example; 6] =
    examples!["drybrush", "edge-darkening", "backrun", "granulation", "flow", "glazing"];

/// The twelve swatches of figure 5.
pub const SWATCHES: Example = examples!["swatches"][0];
