//! Before anything runs: millimetres become cells, names become pigments, areas become amounts.

use std::io;

use girtin_grid::Raster;
use girtin_grid::memory::{NoRoom, probe};
use girtin_optics::{Coefficients, LinearRgb};
use girtin_paper::{HeightSource, Sheet};
use girtin_params::Place;
use girtin_wash::{Ledger, PigmentHandling, WashModel};

use crate::area::{Area, Canvas, Coverage, Shape, TAPER_MM};
use crate::document::{Document, Event, Glaze, Stock};
use crate::map_file::{self, MapError};
use crate::memory;
use crate::picture::PictureLimits;
use crate::wash_settings::handling_of;

/// Most cells of a canvas.
pub const MAX_CELLS: u64 = 1 << 28;

/// A document as the simulator needs it.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Paper height in every cell.
    pub height: Raster<f32>,
    /// Cells a millimetre.
    pub cells_per_mm: f64,
    /// The sheet before anything is painted.
    pub ground: Raster<LinearRgb>,
    /// Glazes from the paper up.
    pub glazes: Vec<PlannedGlaze>,
}

/// A glaze as the simulator needs it.
#[derive(Clone, Debug)]
pub struct PlannedGlaze {
    /// Optics of the pigments.
    pub paints: Vec<Coefficients>,
    /// Handling of the pigments.
    pub handlings: Vec<PigmentHandling>,
    /// Physics.
    pub model: WashModel,
    /// What happens, in order.
    pub deeds: Vec<Deed>,
}

/// An event on cells.
#[derive(Clone, Debug)]
pub enum Deed {
    /// Wets cells whose amount is above 0.
    Wet(Coverage),
    /// Adds water.
    Water(Coverage),
    /// Adds amounts of each pigment where covered.
    Pigment(Coverage, Vec<f64>),
    /// Moistens, in volumes of the pores.
    Moisten(Coverage),
    /// Blots a fraction.
    Blot(Coverage),
    /// Leans the board: how steeply, and where down is, degrees.
    Tilt(f64, f64),
    /// Runs so many steps.
    Run(PlannedRun),
    /// Lifts a fraction.
    Lift(Coverage),
    /// Dries all; water stays in the pores where it was wet.
    Dry([f64; 2]),
    /// Dries a fraction.
    DryWithin(Coverage),
}

/// A run on cells.
#[derive(Clone, Debug)]
pub struct PlannedRun {
    /// Steps at most.
    pub steps: u32,
    /// Ends once no film is left.
    pub until_dry: bool,
    /// Water added before every step where the pressure is below a level.
    pub feed: Option<(Coverage, f32)>,
}

/// Why a document cannot be resolved.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ResolveError {
    /// The sheet has too many cells.
    #[error("the sheet is {width} × {height} cells; {MAX_CELLS} in all at most are simulated")]
    TooLarge {
        /// Columns.
        width: f64,
        /// Rows.
        height: f64,
    },
    /// A living wash has too few or too many cells a millimetre.
    #[error("the sheet has {cells_per_mm} cells a mm; living washes are simulated with {} to {}",
        Ledger::CELLS_PER_MM.start(), Ledger::CELLS_PER_MM.end())]
    Scale {
        /// Cells a millimetre.
        cells_per_mm: f64,
    },
    /// There is no memory for it.
    #[error(transparent)]
    NoRoom(#[from] NoRoom),
    /// A name that the stock does not have.
    #[error("{0}")]
    Unknown(String),
    /// A map's file cannot be opened.
    #[error("map `{file}`: {source}")]
    Open {
        /// Its name.
        file: String,
        /// Where the document names it.
        place: Place,
        /// Why.
        source: io::Error,
    },
    /// A map cannot be read.
    #[error("map `{file}`: {source}")]
    Map {
        /// Its name.
        file: String,
        /// Where the document names it.
        place: Place,
        /// Why.
        source: MapError,
    },
}

impl Document {
    /// Columns and rows of the picture, pixels.
    pub fn picture_size(&self) -> [f64; 2] {
        self.sheet.size_mm.map(|mm| (mm * self.sheet.pixels_per_mm).round().max(1.0))
    }

    /// Cells a millimetre that are simulated.
    pub fn cells_per_mm(&self) -> f64 {
        self.sheet.pixels_per_mm * f64::from(self.sheet.cells_per_pixel)
    }

    /// Columns and rows that are simulated.
    ///
    /// # Errors
    /// There are more than [`MAX_CELLS`], or too few or too many a millimetre for a living wash.
    pub fn cells(&self) -> Result<[usize; 2], ResolveError> {
        let [width, height] =
            self.picture_size().map(|pixels| pixels * f64::from(self.sheet.cells_per_pixel));
        if width * height > MAX_CELLS as f64 {
            return Err(ResolveError::TooLarge { width, height });
        }
        let cells_per_mm = self.cells_per_mm();
        let is_living = |glaze: &Glaze| matches!(glaze.model, WashModel::Living(_));
        if self.glazes.iter().any(is_living) && !Ledger::CELLS_PER_MM.contains(&cells_per_mm) {
            return Err(ResolveError::Scale { cells_per_mm });
        }
        Ok([width as usize, height as usize])
    }

    /// Makes a plan; `open` gives the bytes of a map's file.
    ///
    /// # Errors
    /// The sheet is too large, or a map cannot be read.
    pub fn resolve(
        &self,
        stock: &Stock,
        open: &dyn Fn(&str) -> io::Result<Vec<u8>>,
    ) -> Result<Plan, ResolveError> {
        let sheet = &self.sheet;
        let [width, height] = self.cells()?;
        probe(memory::pieces_of_document(self, [width, height]))?;
        let paper =
            stock.papers.get(&sheet.paper).map_err(|error| ResolveError::Unknown(error.to_string()))?;
        let cells_per_mm = self.cells_per_mm();
        let height = Sheet::new(paper, sheet.seed).height_field(width, height, cells_per_mm, [0.0, 0.0]);
        let canvas = Canvas { height: &height, cells_per_mm, seed: sheet.seed };
        let glazes = self.glazes.iter().map(|glaze| {
            let pigments = glaze.pigments.iter().map(|name| stock.pigments.get(name));
            let pigments: Vec<_> = pigments
                .collect::<Result<_, _>>()
                .map_err(|error| ResolveError::Unknown(error.to_string()))?;
            Ok(PlannedGlaze {
                paints: pigments.iter().map(|pigment| pigment.coefficients).collect(),
                handlings: pigments.iter().map(|pigment| handling_of(pigment)).collect(),
                model: glaze.model,
                deeds: glaze.deeds(&canvas, open)?,
            })
        });
        let glazes = glazes.collect::<Result<_, ResolveError>>()?;
        let mut ground = Raster::new(width, height.height(), sheet.ground);
        for (color, area) in &sheet.printed {
            print(&mut ground, *color, &cover(area, &canvas, open)?);
        }
        Ok(Plan { cells_per_mm, ground, glazes, height })
    }
}

impl Glaze {
    fn deeds(
        &self,
        canvas: &Canvas<'_>,
        open: &dyn Fn(&str) -> io::Result<Vec<u8>>,
    ) -> Result<Vec<Deed>, ResolveError> {
        let mut deeds = Vec::new();
        for event in &self.events {
            event.resolve(canvas, open, &mut deeds)?;
        }
        Ok(deeds)
    }
}

impl Event {
    fn resolve(
        &self,
        canvas: &Canvas<'_>,
        open: &dyn Fn(&str) -> io::Result<Vec<u8>>,
        deeds: &mut Vec<Deed>,
    ) -> Result<(), ResolveError> {
        let cover = |area: &Area| cover(area, canvas, open);
        let scaled = |area: &Area, by: f64| Ok::<_, ResolveError>(times(cover(area)?, by));
        let wet = |area: &Area| {
            let mut coverage = cover(area)?;
            let wet = |amount: &mut f32| *amount = f32::from(u8::from(*amount >= 0.5));
            coverage.amount.as_mut_slice().iter_mut().for_each(wet);
            Ok::<_, ResolveError>(coverage)
        };
        let last = match self {
            Self::Wet { area } => Deed::Wet(wet(area)?),
            Self::Water { area, amount } => Deed::Water(scaled(area, *amount)?),
            Self::Pigment { area, amounts } => Deed::Pigment(cover(area)?, amounts.clone()),
            Self::Brush { area, water, amounts } => {
                deeds.push(Deed::Wet(wet(area)?));
                let map = map_of(area, open)?;
                deeds.push(Deed::Water(times(area.cover_tapered(canvas, map.as_ref(), TAPER_MM), *water)));
                Deed::Pigment(cover(area)?, amounts.clone())
            }
            Self::Moisten { area, volumes } => Deed::Moisten(scaled(area, *volumes)?),
            Self::Blot { area, fraction } => Deed::Blot(scaled(area, *fraction)?),
            Self::Tilt { degrees, toward } => Deed::Tilt(*degrees, *toward),
            Self::Run { steps, until_dry, feed } => {
                let feed = feed
                    .as_ref()
                    .map(|feed| Ok::<_, ResolveError>((scaled(&feed.area, feed.amount)?, feed.level as f32)));
                Deed::Run(PlannedRun { steps: *steps, until_dry: *until_dry, feed: feed.transpose()? })
            }
            Self::Lift { area, fraction } => Deed::Lift(scaled(area, *fraction)?),
            Self::Dry { area: Some(area), .. } => Deed::DryWithin(cover(area)?),
            Self::Dry { area: None, damp } => Deed::Dry(*damp),
        };
        deeds.push(last);
        Ok(())
    }
}

/// A coverage with all amounts so many times as large.
fn times(mut coverage: Coverage, by: f64) -> Coverage {
    coverage.amount.as_mut_slice().iter_mut().for_each(|amount| *amount *= by as f32);
    coverage
}

fn cover(
    area: &Area,
    canvas: &Canvas<'_>,
    open: &dyn Fn(&str) -> io::Result<Vec<u8>>,
) -> Result<Coverage, ResolveError> {
    Ok(area.cover(canvas, map_of(area, open)?.as_ref()))
}

/// The raster of an area that is a map.
fn map_of(
    area: &Area,
    open: &dyn Fn(&str) -> io::Result<Vec<u8>>,
) -> Result<Option<Raster<f32>>, ResolveError> {
    match &area.shape {
        Shape::Map { file, place } => load(file, place, open).map(Some),
        _ => Ok(None),
    }
}

/// Covers the ground with opaque color.
fn print(ground: &mut Raster<LinearRgb>, color: LinearRgb, coverage: &Coverage) {
    for y in 0..coverage.amount.height() {
        let cells = &mut ground.row_mut(coverage.y + y)[coverage.x..];
        for (cell, &covered) in cells.iter_mut().zip(coverage.amount.row(y)) {
            let below = cell.0;
            *cell = LinearRgb([0, 1, 2].map(|c| below[c] + f64::from(covered) * (color.0[c] - below[c])));
        }
    }
}

fn load(
    file: &str,
    place: &Place,
    open: &dyn Fn(&str) -> io::Result<Vec<u8>>,
) -> Result<Raster<f32>, ResolveError> {
    let (name, place) = (|| file.to_owned(), || place.clone());
    let bytes = open(file).map_err(|source| ResolveError::Open { file: name(), place: place(), source })?;
    map_file::read(&bytes, &PictureLimits::default()).map_err(|source| ResolveError::Map {
        file: name(),
        place: place(),
        source,
    })
}
