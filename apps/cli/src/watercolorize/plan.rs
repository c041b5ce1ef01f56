//! What would be done, how much memory it takes and how long.

use std::path::Path;

use girtin::params::row::Parameters;
use girtin::watercolorize::PhotoParams;
use girtin::watercolorize::mount::Mount;
use serde_json::{Value, json};

use crate::arguments::megabytes;

use super::asked::Recipe;
use super::c97::Mattes;

/// Bytes of a photograph's pixel, as light, and besides while it is decoded.
const LIGHT: u64 = 12;
const DECODED: u64 = 6;
/// Bytes of a cell that is planned and painted on, and of one for each pigment and wash.
const CELL: u64 = 700;
const PIGMENT: u64 = 8;
/// Bytes of a picture's pixel, while it is developed and written.
const PIXEL: u64 = 8;
/// What the program takes before it has done anything.
const BASE: u64 = 30_000_000;

/// Seconds of one thread for a cell and wash, to plan and paint it.
const CELL_SECONDS: f64 = 3.2e-6;
/// Seconds of one thread to look at a cell, and to choose a palette.
const LOOK_SECONDS: f64 = 4e-6;
const PALETTE_SECONDS: f64 = 1.0;
/// Seconds of one thread for a pixel and wash, to develop it.
const PIXEL_SECONDS: f64 = 0.15e-6;

/// The plan of one painting.
#[derive(Clone, Copy, Debug)]
pub struct Plan<'a> {
    /// How it is painted.
    pub recipe: &'a Recipe,
    /// Columns and rows of the photograph.
    pub photo: [usize; 2],
    /// Long edge of the picture without its margin.
    pub long_edge: u32,
    /// Mattes that it is painted from.
    pub mattes: Option<&'a Mattes>,
}

impl Plan<'_> {
    fn mount(&self) -> Mount {
        Mount::new(self.photo, f64::from(self.recipe.params.plan_cells), &self.recipe.mounting)
    }

    /// Pixels a millimetre.
    pub fn pixels_per_mm(&self) -> f64 {
        f64::from(self.long_edge) / self.recipe.mounting.long_edge_mm
    }

    /// Columns and rows of the picture.
    pub fn picture(&self) -> [usize; 2] {
        let mount = self.mount();
        let seen = |mm: f64| (mm - 2.0 * mount.trim_mm) * self.pixels_per_mm();
        mount.size_mm.map(|mm| seen(mm).round().max(1.0) as usize)
    }

    fn cells(&self) -> u64 {
        self.mount().size.iter().map(|&side| side as u64).product()
    }

    fn pixels(&self) -> u64 {
        self.picture().iter().map(|&side| side as u64).product()
    }

    fn pigments(&self) -> u64 {
        self.recipe
            .palette
            .as_ref()
            .map_or(u64::from(self.recipe.params.colors), |palette| palette.len() as u64)
    }

    fn glazes(&self) -> u64 {
        self.mattes.map_or(u64::from(self.recipe.params.washes), |mattes| mattes.glazes() as u64)
    }

    /// Bytes of memory, about.
    pub fn memory(&self) -> u64 {
        let photo: u64 = self.photo.iter().map(|&side| side as u64).product();
        let washes = self.glazes();
        let painting = self.cells() * (CELL + PIGMENT * washes * self.pigments());
        // One after another: the photograph is read, painted from, and gone when the picture is developed.
        let [reading, planning] = [photo * (LIGHT + DECODED), photo * LIGHT + painting];
        BASE + reading.max(planning).max(painting + PIXEL * self.pixels())
    }

    /// Seconds to paint it and to develop it, about.
    pub fn seconds(&self) -> [f64; 2] {
        let threads = rayon::current_num_threads() as f64;
        let washes = self.glazes() as f64;
        let palette = if self.recipe.palette.is_some() { 0.0 } else { PALETTE_SECONDS };
        let painting = self.cells() as f64 * (LOOK_SECONDS + CELL_SECONDS * washes) + palette;
        [painting / threads, self.pixels() as f64 * PIXEL_SECONDS * (1.0 + washes) / threads]
    }

    /// For people.
    pub fn text(&self, photo: &Path, output: &str) -> String {
        let ([width, height], mount) = (self.picture(), self.mount());
        let recipe = self.recipe;
        let cells = format!("on {} × {} cells", mount.size[0], mount.size[1]);
        let washes = match (self.mattes, &recipe.palette) {
            (Some(mattes), _) => format!("glazes: {cells}; {}", mattes.text()),
            (None, Some(palette)) => {
                format!("washes: {} at most, {cells}\npigments: {}", recipe.params.washes, palette.join(", "))
            }
            (None, None) => format!(
                "washes: {} at most, {cells}\npigments: chosen for the photograph, {} at most",
                recipe.params.washes, recipe.params.colors
            ),
        };
        let seen = mount.size_mm.map(|mm| mm - 2.0 * mount.trim_mm);
        let [painting, developing] = self.seconds();
        format!(
            "photograph: {}, {} × {} pixels\npicture: {output}, {width} × {height} pixels\nsheet: {:.1} × {:.1} mm of \
             {}, seed {}\npreset: {}\n{washes}\nmemory: about {}\n\
             time: about {:.0} s on {} threads\n",
            photo.display(),
            self.photo[0],
            self.photo[1],
            seen[0],
            seen[1],
            recipe.paper,
            recipe.seed,
            recipe.preset,
            megabytes(self.memory()),
            (painting + developing).max(1.0),
            rayon::current_num_threads(),
        )
    }

    /// For programs.
    pub fn json(&self, photo: &Path, output: &str) -> Value {
        let ([width, height], [painting, developing]) = (self.picture(), self.seconds());
        let value = |id| match self.recipe.params.get(id) {
            Some(girtin::params::Value::Real(value)) => json!(value),
            Some(girtin::params::Value::Count(value)) => json!(value),
            Some(girtin::params::Value::Span(value)) => json!(value),
            None => Value::Null,
        };
        let params = PhotoParams::ROWS.iter().map(|row| (row.id.to_owned(), value(row.id)));
        json!({
            "input": photo.display().to_string(),
            "output": output,
            "photo": self.photo,
            "width": width,
            "height": height,
            "preset": self.recipe.preset,
            "seed": self.recipe.seed,
            "paper": self.recipe.paper,
            "palette": self.recipe.palette,
            "parameters": Value::Object(params.collect()),
            "memory_bytes": self.memory(),
            "seconds": painting + developing,
        })
    }
}
