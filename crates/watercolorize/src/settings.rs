//! What a painter may be asked for: a row per parameter, and presets of them.

use girtin_params::read::Fault;
use girtin_params::{Problem, Table, parameters, parse};

parameters! {
    /// How a picture is turned into washes and marks, in a painter's words.
    pub struct PhotoParams {
        washes: u32 {
            symbol: "", label: "Washes", unit: "1", default: 4, hard: (1.0, 4.0), soft: (2.0, 4.0),
            acts: Simulation, doc: "How many washes are laid over each other, light to dark: with bare paper that is one value more.", source: "custom",
        }
        masses: f64 {
            symbol: "", label: "Masses", unit: "1", default: 1.0, hard: (0.2, 5.0), soft: (0.6, 2.5),
            acts: Simulation, doc: "How large the shapes are that things of one tone are joined to.", source: "custom",
        }
        detail: f64 {
            symbol: "D", label: "Detail", unit: "1", default: 1.0, hard: (0.0, 2.0), soft: (0.3, 1.6),
            acts: Simulation, doc: "How much is drawn exactly where the eye rests.", source: "custom",
        }
        looseness: f64 {
            symbol: "", label: "Looseness", unit: "1", default: 1.0, hard: (0.0, 4.0), soft: (0.5, 2.0),
            acts: Simulation, doc: "How freely contours are drawn: long straight runs and few corners.", source: "custom",
        }
        key: f64 {
            symbol: "", label: "Key", unit: "1", default: 1.0, hard: (-2.0, 3.0), soft: (-1.0, 1.5),
            acts: Simulation, doc: "How far tones are lifted toward a light key; 0 keeps the photograph's, less than 0 lowers them toward night.", source: "custom",
        }
        chroma: f64 {
            symbol: "", label: "Chroma", unit: "1", default: 1.0, hard: (0.0, 3.0), soft: (0.5, 1.5),
            acts: Simulation, doc: "How colorful the painting is; 1 is calmer than a photograph.", source: "custom",
        }
        cool_darks: f64 {
            symbol: "", label: "Cool darks", unit: "1", default: 1.0, hard: (-3.0, 6.0), soft: (0.0, 3.0),
            acts: Simulation, doc: "How far neutral darks lean to blue.", source: "custom",
        }
        lights: f64 {
            symbol: "", label: "Lights", unit: "1", default: 1.0, hard: (0.0, 4.0), soft: (0.3, 2.0),
            acts: Simulation, doc: "How many small lights are kept bare, under masking fluid.", source: "custom",
        }
        accents: f64 {
            symbol: "", label: "Accents", unit: "1", default: 1.0, hard: (0.0, 4.0), soft: (0.3, 2.0),
            acts: Simulation, doc: "How many dark marks a pointed brush makes.", source: "custom",
        }
        texture: f64 {
            symbol: "", label: "Texture", unit: "1", default: 1.0, hard: (0.0, 4.0), soft: (0.0, 2.0),
            acts: Simulation, doc: "How many marks stand for leaves, grass, water and masonry.", source: "custom",
        }
        drybrush: f64 {
            symbol: "", label: "Drybrush", unit: "1", default: 1.0, hard: (0.0, 4.0), soft: (0.0, 2.0),
            acts: Simulation, doc: "How often a brush runs dry and breaks up on the paper.", source: "custom; C97 §4.7",
        }
        lost_edges: f64 {
            symbol: "", label: "Lost edges", unit: "1", default: 1.0, hard: (0.0, 5.0), soft: (0.0, 2.0),
            acts: Simulation, doc: "How many contours run into wet paper.", source: "custom",
        }
        wetness: f64 {
            symbol: "", label: "Wetness", unit: "1", default: 1.0, hard: (0.0, 4.0), soft: (0.3, 2.5),
            acts: Simulation, doc: "How far colors run into each other within a wash.", source: "custom",
        }
        rims: f64 {
            symbol: "η", label: "Rims", unit: "1", default: 1.0, hard: (0.0, 4.0), soft: (0.0, 2.0),
            acts: Simulation, doc: "How dark the rims of washes dry.", source: "custom; C97 §4.3.3",
        }
        granulation: f64 {
            symbol: "γ", label: "Granulation", unit: "1", default: 1.0, hard: (0.0, 5.0), soft: (0.0, 2.0),
            acts: Simulation, doc: "How much pigment gathers in the paper's hollows.", source: "custom; C97 §4.5",
        }
        background: f64 {
            symbol: "", label: "Background", unit: "1", default: 1.0, hard: (0.0, 1.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "How much is painted of what the subject stands before; 0 leaves it bare.", source: "custom",
        }
        ink: f64 {
            symbol: "", label: "Ink", unit: "1", default: 0.0, hard: (0.0, 3.0), soft: (0.0, 1.5),
            acts: Simulation, doc: "How much is drawn in ink before any wash.", source: "custom",
        }
        spatter: f64 {
            symbol: "", label: "Spatter", unit: "1", default: 0.0, hard: (0.0, 4.0), soft: (0.0, 2.0),
            acts: Simulation, doc: "How much paint is flicked off the brush where nobody looks.", source: "custom",
        }
        scraped: f64 {
            symbol: "", label: "Scraped lights", unit: "1", default: 1.0, hard: (0.0, 4.0), soft: (0.0, 2.0),
            acts: Simulation, doc: "How many lights a knife scrapes out of dry darks.", source: "custom",
        }
        pencil: f64 {
            symbol: "", label: "Pencil", unit: "1", default: 1.0, hard: (0.0, 4.0), soft: (0.0, 2.0),
            acts: Simulation, doc: "How much of the drawing under the washes is seen.", source: "custom",
        }
        colors: u32 {
            symbol: "", label: "Colors", unit: "1", default: 6, hard: (1.0, 8.0), soft: (3.0, 8.0),
            acts: Simulation, doc: "How many pigments at most are chosen for the palette.", source: "custom",
        }
        plan_cells: u32 {
            symbol: "S", label: "Planning size", unit: "cells", default: 900, hard: (64.0, 3000.0), soft: (700.0, 1600.0),
            acts: Simulation, doc: "Cells along the long edge that the painting is planned on.", source: "custom",
        }
    }
}

/// Cells of the plan to a pixel of the photograph, at most.
const CELLS_PER_PIXEL: f64 = 1.25;
/// Cells along the long edge that even the smallest photograph is planned on, if the parameters allow.
const LEAST_CELLS: f64 = 320.0;

/// A preset: parameters, and what it takes besides.
#[derive(Clone, Debug, PartialEq)]
pub struct Preset {
    /// Its parameters.
    pub params: PhotoParams,
    /// Pigments, in place of a chosen palette.
    pub palette: Option<Vec<String>>,
    /// Paper.
    pub paper: String,
}

/// A preset that comes with Girtin: its name, and its file.
#[derive(Clone, Copy, Debug)]
pub struct BuiltIn {
    /// Name.
    pub name: &'static str,
    /// TOML.
    pub text: &'static str,
}

/// Parameters of formats before, and what to say instead.
const REPLACED: &[(&str, &str)] = &[
    ("fidelity", "give `masses` and `looseness`"),
    ("simplification", "give `masses`"),
    ("edge_threshold", "give `lost_edges`"),
    ("wobble", "give `looseness`"),
    ("darkest", "give `key`"),
    ("economy", "give `masses`"),
    ("charging", "give `wetness`"),
    ("flatness", "shapes are always flat; leave it out"),
    ("stepping", "give `washes`"),
    ("turbulence", "give `wetness`"),
    ("slivers", "give `lights`"),
    ("drops", "give `wetness`"),
    ("vignette", "paint with `--border vignette`"),
    ("relief", "paintings have no relief; leave it out"),
];

macro_rules! built_in {
    ($($name:literal),*) => {
        /// The presets that come with Girtin; the first is the default.
        pub const PRESETS: &[BuiltIn] =
            &[$(BuiltIn { name: $name, text: include_str!(concat!("../assets/", $name, ".toml")) }),*];
    };
}

built_in!("classic", "loose", "wet-in-wet", "detailed", "urban", "botanical", "monochrome", "nocturne");

impl Preset {
    /// A preset of a built-in name.
    pub fn built_in(name: &str) -> Option<Self> {
        let found = PRESETS.iter().find(|preset| preset.name == name)?;
        Self::from_toml(found.name, found.text).ok()
    }

    /// Reads a preset; what it does not say is as `classic` has it.
    ///
    /// # Errors
    /// The text is not TOML, a key is unknown, or a value not allowed.
    pub fn from_toml(origin: &str, text: &str) -> Result<Self, Problem> {
        parse(origin, text, Self::from_table)
    }

    /// The same of a file that is being read, for those who look up its names while their places are known.
    ///
    /// # Errors
    /// A value is not allowed.
    pub fn from_table(table: &Table<'_>) -> Result<Self, Fault> {
        if let Some((old, instead)) = REPLACED.iter().find(|(old, _)| table.has(old)) {
            let message =
                format!("`{old}` was of a planner that followed the photograph, and means nothing now");
            return Err(table.fault(old, message).hint(*instead));
        }
        let palette = table.texts("palette")?;
        let paper = table.text("paper")?.unwrap_or_else(|| "cold-press".to_owned());
        Ok(Self { palette, paper, params: table.parameters()? })
    }
}

impl PhotoParams {
    /// Glazes of a painting at most: its washes, and layers of marks on them.
    pub fn glazes(&self) -> u32 {
        self.washes
            + 2
            + u32::from(self.pencil > 0.0)
            + u32::from(self.scraped > 0.0 || self.spatter > 0.0)
            + u32::from(self.ink > 0.0)
    }

    /// Cells along the long edge that a photograph of so many pixels is planned on: a small one needs fewer.
    pub fn cells_for(&self, pixels: [usize; 2]) -> f64 {
        let longest = pixels[0].max(pixels[1]) as f64;
        f64::from(self.plan_cells).min((CELLS_PER_PIXEL * longest).max(LEAST_CELLS))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_presets_can_be_read_and_differ() {
        let presets: Vec<Preset> =
            PRESETS.iter().map(|p| Preset::from_toml(p.name, p.text).unwrap()).collect();
        for (at, preset) in presets.iter().enumerate() {
            assert!(!presets[..at].contains(preset), "{}", PRESETS[at].name);
        }
        assert_eq!(presets[0].params, PhotoParams::default(), "classic is the default");
    }
}
