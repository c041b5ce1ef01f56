//! What a painter may be asked for: a row per parameter, and presets of them.

use girtin_params::read::Fault;
use girtin_params::{Problem, Table, parameters, parse};

parameters! {
    /// How a picture is turned into washes.
    ///
    /// Lengths that say "of the long edge" are parts of the photograph's long edge.
    pub struct PhotoParams {
        washes: u32 {
            symbol: "", label: "Washes", unit: "1", default: 4, hard: (1.0, 6.0), soft: (2.0, 5.0),
            acts: Simulation, doc: "How many washes are laid over each other, light to dark.", source: "custom",
        }
        fidelity: f64 {
            symbol: "", label: "Fidelity", unit: "1", default: 0.5, hard: (0.0, 1.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "How closely the painting follows the photograph: turbulence, economy and how far later washes mend earlier ones move together.", source: "custom",
        }
        detail: f64 {
            symbol: "D", label: "Detail", unit: "1", default: 1.1, hard: (0.0, 2.0), soft: (0.0, 1.5),
            acts: Simulation, doc: "How much is drawn exactly where the eye rests.", source: "custom",
        }
        plan_cells: u32 {
            symbol: "S", label: "Planning size", unit: "cells", default: 640, hard: (64.0, 2000.0), soft: (480.0, 1200.0),
            acts: Simulation, doc: "Cells along the long edge that the painting is planned and its water simulated on.", source: "custom",
        }
        wetness: f64 {
            symbol: "", label: "Wetness", unit: "1", default: 1.0, hard: (0.0, 3.0), soft: (0.3, 2.0),
            acts: Simulation, doc: "How wet washes are, and how far they run where the photograph is soft; beyond 2 no masking fluid is taken.", source: "custom",
        }
        simplification: f64 {
            symbol: "", label: "Simplification", unit: "1", default: 1.3, hard: (0.0, 5.0), soft: (0.5, 2.5),
            acts: Simulation, doc: "How large the shapes are that small things melt into.", source: "custom",
        }
        edge_threshold: f64 {
            symbol: "τ", label: "Edge threshold", unit: "1", default: 1.0, hard: (0.1, 10.0), soft: (0.5, 2.0),
            acts: Simulation, doc: "How hard an edge of the photograph must be to stop the water.", source: "custom",
        }
        rims: f64 {
            symbol: "η", label: "Rims", unit: "1", default: 1.0, hard: (0.0, 5.0), soft: (0.0, 2.0),
            acts: Simulation, doc: "How dark the rims of washes dry.", source: "custom; C97 §4.3.3",
        }
        wobble: f64 {
            symbol: "", label: "Wobble", unit: "1", default: 1.0, hard: (0.0, 10.0), soft: (0.0, 3.0),
            acts: Simulation, doc: "How far the hand strays: washes do not quite register.", source: "custom",
        }
        key: f64 {
            symbol: "", label: "Key", unit: "Lab L", default: 3.0, hard: (-20.0, 20.0), soft: (0.0, 8.0),
            acts: Simulation, doc: "How much lighter than the photograph the middle tones are painted.", source: "custom",
        }
        chroma: f64 {
            symbol: "", label: "Chroma", unit: "1", default: 1.08, hard: (0.0, 3.0), soft: (0.8, 1.4),
            acts: Simulation, doc: "How much more colorful than the photograph.", source: "custom",
        }
        darkest: f64 {
            symbol: "", label: "Darkest", unit: "Lab L", default: 9.0, hard: (0.0, 60.0), soft: (6.0, 25.0),
            acts: Simulation, doc: "The darkest tone; below it washes look dead.", source: "custom",
        }
        economy: f64 {
            symbol: "", label: "Economy", unit: "1", default: 0.06, hard: (0.0, 1.0), soft: (0.0, 0.4),
            acts: Simulation, doc: "How much of what is missing later washes leave as it is, away from detail.", source: "custom",
        }
        charging: f64 {
            symbol: "", label: "Charging", unit: "1", default: 1.1, hard: (0.0, 5.0), soft: (0.0, 2.0),
            acts: Simulation, doc: "How far the hue drifts inside a wash, as when other colors are dropped in.", source: "custom",
        }
        flatness: f64 {
            symbol: "", label: "Flatness", unit: "1", default: 1.0, hard: (0.0, 1.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "How flat a wash is within its shapes.", source: "custom",
        }
        stepping: f64 {
            symbol: "", label: "Stepping", unit: "1", default: 0.75, hard: (0.0, 1.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "How far tones step, at the edges of later washes and where the photograph is soft, rather than fade.", source: "custom",
        }
        turbulence: f64 {
            symbol: "", label: "Turbulence", unit: "1", default: 1.0, hard: (0.0, 5.0), soft: (0.0, 2.0),
            acts: Simulation, doc: "How unevenly water and pigment are laid, and how much darker soft parts dry where water pools.", source: "custom",
        }
        granulation: f64 {
            symbol: "γ", label: "Granulation", unit: "1", default: 0.45, hard: (0.0, 5.0), soft: (0.0, 2.0),
            acts: Simulation, doc: "How much pigment gathers in the paper's hollows.", source: "custom; C97 §4.5",
        }
        slivers: f64 {
            symbol: "", label: "White slivers", unit: "1", default: 0.5, hard: (0.0, 5.0), soft: (0.0, 2.0),
            acts: Simulation, doc: "How much bare paper is left between shapes here and there.", source: "custom",
        }
        drybrush: f64 {
            symbol: "", label: "Drybrush", unit: "1", default: 1.0, hard: (0.0, 5.0), soft: (0.0, 2.0),
            acts: Simulation, doc: "How much of the rough parts is brushed on dry, over the paper's peaks only.", source: "custom; C97 §4.7",
        }
        drops: u32 {
            symbol: "", label: "Drops", unit: "1", default: 0, hard: (0.0, 40.0), soft: (0.0, 8.0),
            acts: Simulation, doc: "How many drops of water fall into the first wash as it dries, and run back.", source: "custom",
        }
        vignette: f64 {
            symbol: "", label: "Vignette", unit: "1", default: 0.0, hard: (0.0, 3.0), soft: (0.0, 1.5),
            acts: Simulation, doc: "How far the painting dissolves into the sheet before its border.", source: "custom",
        }
        ink: f64 {
            symbol: "", label: "Ink", unit: "1", default: 0.0, hard: (0.0, 3.0), soft: (0.0, 1.5),
            acts: Appearance, doc: "How strongly outlines are drawn in ink before any wash.", source: "custom",
        }
        relief: f64 {
            symbol: "", label: "Relief", unit: "mm", default: 0.03, hard: (0.0, 0.5), soft: (0.0, 0.1),
            acts: Appearance, doc: "How deep the paper's grain shows under raking light.", source: "custom",
        }
        colors: u32 {
            symbol: "", label: "Colors", unit: "1", default: 6, hard: (1.0, 8.0), soft: (3.0, 8.0),
            acts: Simulation, doc: "How many pigments at most are chosen for the palette.", source: "custom",
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

macro_rules! built_in {
    ($($name:literal),*) => {
        /// The presets that come with Girtin; the first is the default.
        pub const PRESETS: &[BuiltIn] =
            &[$(BuiltIn { name: $name, text: include_str!(concat!("../assets/", $name, ".toml")) }),*];
    };
}

built_in!("classic", "loose", "wet-in-wet", "detailed", "pen", "monochrome");

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
        let palette = table.texts("palette")?;
        let paper = table.text("paper")?.unwrap_or_else(|| "fine-grain".to_owned());
        Ok(Self { palette, paper, params: table.parameters()? })
    }
}

impl PhotoParams {
    /// Cells along the long edge that a photograph of so many pixels is planned on: a small one needs fewer.
    pub fn cells_for(&self, pixels: [usize; 2]) -> f64 {
        let longest = pixels[0].max(pixels[1]) as f64;
        f64::from(self.plan_cells).min((CELLS_PER_PIXEL * longest).max(LEAST_CELLS))
    }

    /// What fidelity makes of turbulence, economy and the like: 1 at its default, 0 at most, 2 at least.
    pub fn freedom(&self) -> f64 {
        2.0 * (1.0 - self.fidelity)
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
