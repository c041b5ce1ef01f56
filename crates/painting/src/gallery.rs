//! Documents that come with Girtin: the figures of Curtis et al. 1997, and the living wash's own.

/// A document that comes with Girtin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Example {
    /// Its name, and that of its picture's file without the ending.
    pub name: &'static str,
    /// Its TOML.
    pub text: &'static str,
}

macro_rules! examples {
    ($($name:literal),* $(,)?) => { examples![in "": $($name),*] };
    (in $folder:literal: $($name:literal),* $(,)?) => {
        [$(Example { name: $name, text: include_str!(concat!("../assets/", $folder, $name, ".toml")) }),*]
    };
}

/// The six effects of figures 1 and 2, in the order of the paper.
pub const EFFECTS: [Example; 6] =
    examples!["drybrush", "edge-darkening", "backrun", "granulation", "flow", "glazing"];

/// The same effects by the living wash, and its two sheets: one stroke over paper at twelve wetnesses, and a puddle dropped
/// into a drying wash at six moments.
pub const LIVING: [Example; 8] = examples![
    in "living/": "drybrush", "edge-darkening", "backrun", "granulation", "flow", "glazing", "wetness-strip",
    "drying-puddle"
];

/// The twelve swatches of figure 5.
pub const SWATCHES: Example = examples!["swatches"][0];
