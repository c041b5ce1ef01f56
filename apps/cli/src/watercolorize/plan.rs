//! What would be done, how much memory it takes and how long.

use girtin::params::row::Parameters;
use girtin::watercolorize::PhotoParams;
use girtin::watercolorize::mount::Mount;
use serde_json::{Value, json};

use crate::arguments::megabytes;

use super::asked::Recipe;
use super::outputs::Errand;

/// Bytes of a photograph's pixel, as light, and besides while it is decoded.
const LIGHT: u64 = 12;
const DECODED: u64 = 6;
/// Bytes of a cell that a photograph is planned on; those painted on are fewer.
const PLANNED: u64 = 205;
/// Bytes of a cell that mattes are painted on, and of one for each pigment and wash.
const CELL: u64 = 520;
const PIGMENT: u64 = 12;
/// Percent of that which are kept until the picture is developed, of a photograph's and of mattes'.
const KEPT: u64 = 90;
const MATTE_KEPT: u64 = 40;
/// Bytes of a picture's pixel, while it is developed and written; of the picture after each wash; and besides of what
/// layers are made of.
const PIXEL: u64 = 6;
const WASHED: u64 = 3;
const LAYERED: u64 = 30;
/// What the program takes before it has done anything.
const BASE: u64 = 46_000_000;

/// Seconds of one thread to plan and paint a photograph however small, for a cell that is looked at, and for one and each wash.
const PHOTO_SECONDS: f64 = 2.3;
const LOOK_SECONDS: f64 = 3.0e-6;
const CELL_SECONDS: f64 = 0.53e-6;
/// The same for a cell and glaze of a matte.
const MATTE_SECONDS: f64 = 3.7e-6;
/// Seconds of one thread to choose a palette.
const PALETTE_SECONDS: f64 = 1.3;
/// Seconds of one thread for a pixel and wash of a drawing, and of mattes, to develop it.
const PIXEL_SECONDS: f64 = 0.19e-6;
const MATTE_PIXEL_SECONDS: f64 = 0.085e-6;
/// How much longer threads take together than each its part.
const TOGETHER: f64 = 1.15;
/// Seconds for a pixel, which no number of threads shortens: to read a photograph, to write a picture, to write a layer.
const READ_SECONDS: f64 = 0.07e-6;
const WRITE_SECONDS: f64 = 0.1e-6;
const LAYER_SECONDS: f64 = 0.5e-6;

/// The plan of one painting.
#[derive(Clone, Copy, Debug)]
pub struct Plan<'a> {
    /// How it is painted.
    pub recipe: &'a Recipe,
    /// Columns and rows of the photograph.
    pub photo: [usize; 2],
    /// Long edge of the picture without its margin.
    pub long_edge: u32,
    /// What is written of it.
    pub errand: &'a Errand,
}

impl Plan<'_> {
    fn mount(&self) -> Mount {
        Mount::new(self.photo, self.recipe.params.cells_for(self.photo), &self.recipe.mounting)
    }

    /// Pixels a millimetre.
    pub fn pixels_per_mm(&self) -> f64 {
        f64::from(self.long_edge) / self.recipe.mounting.long_edge_mm
    }

    /// Columns and rows of the picture.
    pub fn picture(&self) -> [usize; 2] {
        let mount = self.mount();
        let trim_mm = mount.trim_mm_at(self.pixels_per_mm());
        let seen = |mm: f64| (mm - 2.0 * trim_mm) * self.pixels_per_mm();
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
        let mattes = self.errand.mattes.as_ref();
        mattes.map_or(u64::from(self.recipe.params.glazes()), |mattes| mattes.glazes() as u64)
    }

    /// Bytes of memory, about.
    pub fn memory(&self) -> u64 {
        let glazes = self.glazes();
        let has_mattes = self.errand.mattes.is_some();
        let (each, kept) = if has_mattes {
            (CELL + PIGMENT * glazes * self.pigments(), MATTE_KEPT)
        } else {
            (PLANNED, KEPT)
        };
        let painting = self.cells() * each;
        let layered = if self.errand.layers.is_some() { LAYERED } else { 0 };
        let washed = if self.writes_washes() { WASHED * (glazes + 2) + layered } else { 0 };
        // What is painted from is no larger than lines are looked for on.
        let looked_at = self.photographed().min(4 * self.cells());
        // One after another: the photograph is read, painted from, and gone when the picture is developed.
        let [reading, planning] = [self.photographed() * (LIGHT + DECODED), looked_at * LIGHT + painting];
        BASE + reading.max(planning).max(painting * kept / 100 + PIXEL.max(washed) * self.pixels())
    }

    fn photographed(&self) -> u64 {
        self.photo.iter().map(|&side| side as u64).product()
    }

    /// Whether the picture after each wash is written.
    fn writes_washes(&self) -> bool {
        self.errand.layers.is_some() || self.errand.stages.is_some()
    }

    /// Seconds to paint it and to develop it, about.
    pub fn seconds(&self) -> [f64; 2] {
        let threads = rayon::current_num_threads() as f64;
        let (glazes, has_mattes) = (self.glazes() as f64, self.errand.mattes.is_some());
        let palette = if self.recipe.palette.is_some() || has_mattes { 0.0 } else { PALETTE_SECONDS };
        let (whole, look, each, pixel) = if has_mattes {
            (0.0, 0.0, MATTE_SECONDS, MATTE_PIXEL_SECONDS)
        } else {
            (PHOTO_SECONDS, LOOK_SECONDS, CELL_SECONDS, PIXEL_SECONDS)
        };
        let painting = whole + palette + self.cells() as f64 * (look + each * glazes);
        let threads = threads / if threads > 1.0 { TOGETHER } else { 1.0 };
        // Washes of every picture that is developed, bare paper as one: of the first ones 0, 1, 2 and so on.
        let before = if self.writes_washes() { 0.5 * glazes * (glazes + 1.0) } else { 0.0 };
        let stages = if self.errand.stages.is_some() { glazes } else { 0.0 };
        let layers = if self.errand.layers.is_some() { glazes + 2.0 } else { 0.0 };
        let written = WRITE_SECONDS * (1.0 + stages) + LAYER_SECONDS * layers;
        let developing = pixel * (1.0 + glazes + before) / threads + written;
        let reading = self.photographed() as f64 * READ_SECONDS;
        [reading + painting / threads, self.pixels() as f64 * developing]
    }

    /// For people.
    pub fn text(&self) -> String {
        let errand = self.errand;
        let ([width, height], mount) = (self.picture(), self.mount());
        let recipe = self.recipe;
        let cells = format!("on {} × {} cells", mount.size[0], mount.size[1]);
        let washes = match (&errand.mattes, &recipe.palette) {
            (Some(mattes), _) => format!("glazes: {cells}; {}", mattes.text()),
            (None, Some(palette)) => {
                format!("washes: {} at most, {cells}\npigments: {}", recipe.params.washes, palette.join(", "))
            }
            (None, None) => format!(
                "washes: {} at most, {cells}\npigments: chosen for the photograph, {} at most",
                recipe.params.washes, recipe.params.colors
            ),
        };
        let more = errand.more().into_iter().map(|(what, files)| format!("{what}: {}\n", files.join(", ")));
        let seen = self.picture().map(|side| side as f64 / self.pixels_per_mm());
        let [painting, developing] = self.seconds();
        format!(
            "photograph: {}, {} × {} pixels\npicture: {}, {width} × {height} pixels\n{}sheet: {:.1} × {:.1} mm of \
             {}, seed {}\npreset: {}\n{washes}\nmemory: about {}\n\
             time: about {:.0} s on {} threads\n",
            errand.photo.display(),
            self.photo[0],
            self.photo[1],
            errand.output().unwrap_or("none"),
            more.collect::<String>(),
            seen[0],
            seen[1],
            recipe.paper,
            recipe.seed(),
            recipe.preset,
            megabytes(self.memory()),
            (painting + developing).max(1.0),
            rayon::current_num_threads(),
        )
    }

    /// For programs.
    pub fn json(&self) -> Value {
        let errand = self.errand;
        let more = errand.more().into_iter().map(|(what, files)| (what.to_owned(), json!(files)));
        let ([width, height], [painting, developing]) = (self.picture(), self.seconds());
        let value = |id| match self.recipe.params.get(id) {
            Some(girtin::params::Value::Real(value)) => json!(value),
            Some(girtin::params::Value::Count(value)) => json!(value),
            Some(girtin::params::Value::Span(value)) => json!(value),
            None => Value::Null,
        };
        let params = PhotoParams::ROWS.iter().map(|row| (row.id.to_owned(), value(row.id)));
        json!({
            "input": errand.photo.display().to_string(),
            "output": errand.output().unwrap_or("none"),
            "more": Value::Object(more.collect()),
            "photo": self.photo,
            "width": width,
            "height": height,
            "preset": self.recipe.preset,
            "seed": self.recipe.seed(),
            "paper": self.recipe.paper,
            "palette": self.recipe.palette,
            "parameters": Value::Object(params.collect()),
            "memory_bytes": self.memory(),
            "seconds": painting + developing,
        })
    }
}
