//! Before anything runs: millimetres become cells, names become pigments, areas become amounts.

use std::io;

use girtin_grid::Raster;
use girtin_grid::memory::{NoRoom, probe};
use girtin_optics::{Coefficients, LinearRgb, Pigment};
use girtin_paper::{HeightSource, Sheet};
use girtin_params::Place;
use girtin_wash::{Ledger, PigmentHandling, WashModel};
use rayon::prelude::*;

use crate::area::{Area, Canvas, Coverage, Shape, TAPER_MM};
use crate::brush::PlannedMark;
use crate::document::{Document, Event, Glaze, MapName, Outline, Stock};
use crate::drawing::Drawing;
use crate::fill::PlannedFill;
use crate::map_file::MapError;
use crate::maps::{MapFault, Maps};
use crate::memory;
use crate::wash_settings::handling_of;

/// Most cells of a canvas.
pub const MAX_CELLS: u64 = 1 << 28;

/// Steps of the edge map's distances to a cell.
pub const EDGE_STEPS: f32 = 16.0;

/// A document as the simulator needs it.
#[derive(Debug)]
pub struct Plan {
    /// The sheet.
    pub sheet: PlannedSheet,
    /// Glazes from the paper up.
    pub glazes: Vec<PlannedGlaze>,
}

/// A sheet as the simulator and the picture need it.
#[derive(Debug)]
pub struct PlannedSheet {
    /// Paper height in every cell.
    pub height: Raster<f32>,
    /// Cells a millimetre.
    pub cells_per_mm: f64,
    /// Seed of the paper's grain and of ragged edges.
    pub seed: u64,
    /// The paper itself, for its height at the picture's resolution.
    pub paper: Sheet,
    /// Color of the bare sheet.
    pub ground: LinearRgb,
    /// What is printed on it, in order, with the raster of an area that is a map.
    pub printed: Vec<(LinearRgb, Area, Option<Raster<f32>>)>,
    /// Columns and rows of the picture.
    pub picture: [usize; 2],
    /// Resolution of the picture.
    pub pixels_per_mm: f64,
    /// Samples along each side of a pixel.
    pub samples: usize,
    /// How much is cut off on every side, mm.
    pub trim_mm: f64,
    /// Depth of the relief, mm.
    pub relief_mm: f64,
    /// What is drawn on it.
    pub drawing: Drawing,
    /// Whether a sample is a cell.
    pub samples_are_cells: bool,
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
    /// What it is confined to.
    pub outline: Option<PlannedOutline>,
    /// Figures that it fills and marks that are made in it.
    pub figures: Option<PlannedFigures>,
    /// What happens, in order.
    pub deeds: Vec<Deed>,
}

/// What of a glaze is drawn: exact at any resolution.
#[derive(Clone, Debug)]
pub struct PlannedFigures {
    /// What it fills.
    pub fill: Option<PlannedFill>,
    /// Marks of a brush.
    pub marks: Vec<PlannedMark>,
    /// How strongly each pigment granulates: grain comes as the wash dries, from the paper at the picture's resolution.
    pub grain: Vec<f32>,
}

impl PlannedFigures {
    /// How much of each pigment its marks leave, in amounts of a cell, so many a millimetre, on paper of middling tooth.
    pub fn marked(&self, cells_per_mm: f64) -> Vec<f64> {
        let pigments = self.grain.len();
        let of_mark = |mark: &PlannedMark| {
            let mut sums = vec![0.0f64; pigments];
            let [low, high] = mark.bounds();
            let range =
                |axis: usize| (low[axis] * cells_per_mm) as i64..(high[axis] * cells_per_mm) as i64 + 1;
            for [x, y] in range(1).flat_map(|y| range(0).map(move |x| [x, y])) {
                let at = [x, y].map(|cell| (cell as f64 + 0.5) / cells_per_mm);
                let Some(touch) = mark.at(at, 0.5, 0.0, cells_per_mm as f32) else { continue };
                for (pigment, sum) in sums.iter_mut().enumerate() {
                    *sum += f64::from(touch.covered * mark.amounts(&touch, pigment));
                }
            }
            sums
        };
        // Summed in their order, whatever threads do.
        let each: Vec<Vec<f64>> = self.marks.par_iter().map(of_mark).collect();
        (0..pigments).map(|pigment| each.iter().map(|sums| sums[pigment]).sum()).collect()
    }
}

/// Distance from an edge, cells of its map, from which on two shapes that abut all the same have no edge there.
const NO_EDGE: f32 = 4.0;

/// The shapes of a glaze, a value a cell.
#[derive(Clone, Debug)]
pub struct PlannedOutline {
    /// Which shape a cell belongs to; 0 is none.
    pub regions: Raster<u8>,
    /// Distance of its middle from the edge of its shape, cells.
    pub edges: Raster<f32>,
    /// Where the edge is so far, cells, that a shape which abuts has none there: water passes.
    pub far: f32,
    /// Masking fluid, at any resolution over the whole sheet; 1 stays bare.
    pub masked: Option<Raster<f32>>,
    /// Where water may stand: not outside, not under masking fluid, and not on the seam between two shapes.
    pub open: Raster<u8>,
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
        let seen = |mm: f64| (mm - 2.0 * self.sheet.trim_mm) * self.sheet.pixels_per_mm;
        self.sheet.size_mm.map(|mm| seen(mm).round().max(1.0))
    }

    /// Cells a millimetre that are simulated.
    pub fn cells_per_mm(&self) -> f64 {
        let samples = self.sheet.pixels_per_mm * f64::from(self.sheet.cells_per_pixel);
        self.sheet.cells_per_mm.unwrap_or(samples)
    }

    /// Columns and rows that are simulated.
    ///
    /// # Errors
    /// There are more than [`MAX_CELLS`], or as many samples of the picture, or too few or too many a millimetre for a
    /// living wash.
    pub fn cells(&self) -> Result<[usize; 2], ResolveError> {
        let samples = self.picture_size().map(|pixels| pixels * f64::from(self.sheet.cells_per_pixel));
        let cells = match self.sheet.cells_per_mm {
            Some(cells_per_mm) => self.sheet.size_mm.map(|mm| (mm * cells_per_mm).round().max(1.0)),
            None => samples,
        };
        for [width, height] in [samples, cells] {
            if width * height > MAX_CELLS as f64 {
                return Err(ResolveError::TooLarge { width, height });
            }
        }
        let cells_per_mm = self.cells_per_mm();
        let is_living = |glaze: &Glaze| matches!(glaze.model, WashModel::Living(_));
        if self.glazes.iter().any(is_living) && !Ledger::CELLS_PER_MM.contains(&cells_per_mm) {
            return Err(ResolveError::Scale { cells_per_mm });
        }
        Ok(cells.map(|cells| cells as usize))
    }

    /// Makes a plan.
    ///
    /// # Errors
    /// The sheet is too large, or a map cannot be read.
    pub fn resolve(&self, stock: &Stock, maps: &dyn Maps) -> Result<Plan, ResolveError> {
        let sheet = self.resolve_sheet(stock, maps)?;
        let glazes = self.glazes.iter().map(|glaze| glaze.resolve(&sheet, stock, maps));
        Ok(Plan { glazes: glazes.collect::<Result<_, _>>()?, sheet })
    }

    /// Makes a plan of the sheet alone.
    ///
    /// # Errors
    /// As [`Document::resolve`].
    pub fn resolve_sheet(&self, stock: &Stock, maps: &dyn Maps) -> Result<PlannedSheet, ResolveError> {
        let sheet = &self.sheet;
        let [width, height] = self.cells()?;
        probe(memory::pieces_of_document(self, [width, height]))?;
        let paper =
            stock.papers.get(&sheet.paper).map_err(|error| ResolveError::Unknown(error.to_string()))?;
        let (paper, cells_per_mm) = (Sheet::new(paper, sheet.seed), self.cells_per_mm());
        let printed = sheet.printed.iter();
        let printed = printed.map(|(color, area)| Ok((*color, area.clone(), map_of(area, maps)?)));
        Ok(PlannedSheet {
            height: paper.height_field(width, height, cells_per_mm, [0.0, 0.0]),
            cells_per_mm,
            seed: sheet.seed,
            paper,
            ground: sheet.ground,
            printed: printed.collect::<Result<_, ResolveError>>()?,
            picture: self.picture_size().map(|pixels| pixels as usize),
            pixels_per_mm: sheet.pixels_per_mm,
            samples: sheet.cells_per_pixel as usize,
            trim_mm: sheet.trim_mm,
            relief_mm: sheet.relief_mm,
            drawing: Drawing::new(&self.drawing, sheet.seed),
            samples_are_cells: sheet.cells_per_mm.is_none(),
        })
    }
}

impl Glaze {
    /// Makes a plan of the glaze on a sheet.
    ///
    /// # Errors
    /// A pigment is not in the stock, or a map cannot be read.
    pub fn resolve(
        &self,
        sheet: &PlannedSheet,
        stock: &Stock,
        maps: &dyn Maps,
    ) -> Result<PlannedGlaze, ResolveError> {
        let canvas = Canvas::whole(&sheet.height, sheet.cells_per_mm, sheet.seed);
        let pigments = self.pigments.iter().map(|name| stock.pigments.get(name));
        let pigments: Vec<_> =
            pigments.collect::<Result<_, _>>().map_err(|error| ResolveError::Unknown(error.to_string()))?;
        let size = [sheet.height.width(), sheet.height.height()];
        let outline = self.outline.as_ref().map(|outline| outline.resolve(size, maps)).transpose()?;
        let mut deeds = Vec::new();
        let figures = self.resolve_figures(sheet, &pigments, size, &mut deeds);
        for event in &self.events {
            event.resolve(&canvas, maps, &mut deeds)?;
        }
        if let Some(outline) = &outline {
            deeds.iter_mut().for_each(|deed| outline.confine(deed));
        }
        Ok(PlannedGlaze {
            paints: pigments.iter().map(|pigment| pigment.coefficients).collect(),
            handlings: pigments.iter().map(|pigment| self.handling_of(pigment)).collect(),
            model: self.model,
            outline,
            figures,
            deeds,
        })
    }
}

impl Glaze {
    /// Whether it fills figures or has marks.
    fn is_drawn(&self) -> bool {
        self.events.iter().any(|event| matches!(event, Event::Fill(_) | Event::Marks { .. }))
    }

    fn handling_of(&self, pigment: &Pigment) -> PigmentHandling {
        let own = handling_of(pigment);
        let granulation = (own.granulation * self.granulation).min(1.0);
        // What is drawn gets its grain as it dries: settling while water moves would emboss it.
        PigmentHandling { granulation: if self.is_drawn() { 0.0 } else { granulation }, ..own }
    }

    fn resolve_figures(
        &self,
        sheet: &PlannedSheet,
        pigments: &[&Pigment],
        size: [usize; 2],
        deeds: &mut Vec<Deed>,
    ) -> Option<PlannedFigures> {
        if !self.is_drawn() {
            return None;
        }
        let fills = self.events.iter().filter_map(|event| match event {
            Event::Fill(fill) if !fill.figures.is_empty() => Some(fill),
            _ => None,
        });
        let fills: Vec<_> = fills.collect();
        let fill = (!fills.is_empty()).then(|| {
            PlannedFill::new(&fills, &sheet.drawing, size, sheet.cells_per_mm, sheet.seed, &self.name, deeds)
        });
        let marks = self.events.iter().filter_map(|event| match event {
            Event::Marks { marks, rim } => Some(marks.iter().map(move |mark| (mark, *rim))),
            _ => None,
        });
        let marks = marks.flatten().enumerate();
        let marks =
            marks.map(|(number, (mark, rim))| PlannedMark::new(mark, rim, number, sheet.seed)).collect();
        let grain = |pigment: &&Pigment| (handling_of(pigment).granulation * self.granulation) as f32;
        Some(PlannedFigures { fill, marks, grain: pigments.iter().map(grain).collect() })
    }
}

impl Outline {
    fn resolve(&self, size: [usize; 2], maps: &dyn Maps) -> Result<PlannedOutline, ResolveError> {
        let [width, height] = size;
        let regions = load(&self.regions, maps)?;
        let [wide, high] = [regions.width(), regions.height()];
        // Shapes have no values between them: the nearest counts.
        let near = |x: usize, y: usize| {
            let (x, y) = ((2 * x + 1) * wide / (2 * width), (2 * y + 1) * high / (2 * height));
            (regions.at(x, y) * 255.0 + 0.5) as u8
        };
        let regions = Raster::by_rows(width, height, near);
        let edges = self.edges.as_ref().map(|edges| load(edges, maps)).transpose()?;
        let scale = width as f32 / wide as f32;
        let to_cells = |value: f32| value * 255.0 / EDGE_STEPS * scale;
        let far = NO_EDGE * scale;
        let edges = edges.map_or_else(
            || Raster::new(width, height, 0.5),
            |edges| {
                Raster::by_rows(width, height, |x, y| {
                    let at = [(x, wide, width), (y, high, height)];
                    let [x, y] = at.map(|(at, of, cells)| (at as f32 + 0.5) * of as f32 / cells as f32);
                    to_cells(edges.sample(x, y))
                })
            },
        );
        let masked = self.masked.as_ref().map(|masked| load(masked, maps)).transpose()?;
        let open = Raster::by_rows(width, height, |x, y| {
            let own = regions.at(x, y);
            let abuts = |x1: usize, y1: usize| {
                x1 < width
                    && y1 < height
                    && ![0, own].contains(&regions.at(x1, y1))
                    && edges.at(x, y).min(edges.at(x1, y1)) < far
            };
            let is_masked = masked.as_ref().is_some_and(|masked| {
                let [x, y] = [(x, width, masked.width()), (y, height, masked.height())]
                    .map(|(at, cells, of)| (at as f32 + 0.5) * of as f32 / cells as f32);
                masked.sample(x, y) >= 0.5
            });
            u8::from(own != 0 && !is_masked && !abuts(x + 1, y) && !abuts(x, y + 1))
        });
        Ok(PlannedOutline { regions, edges, far, masked, open })
    }
}

impl PlannedOutline {
    /// Whether a cell is of a shape and far from its edge, or beside a shape that has no edge there either.
    pub fn has_no_edge(&self, x: usize, y: usize) -> bool {
        self.regions.at(x, y) != 0 && self.edges.at(x, y) >= self.far
    }

    /// Keeps water off what is not open; pigment follows the water.
    fn confine(&self, deed: &mut Deed) {
        let (Deed::Wet(coverage) | Deed::Water(coverage) | Deed::Moisten(coverage)) = deed else { return };
        let (x, y, amount) = (coverage.x, coverage.y, &mut coverage.amount);
        for row in 0..amount.height() {
            let open = &self.open.row(y + row)[x..];
            amount.row_mut(row).iter_mut().zip(open).for_each(|(amount, &open)| *amount *= f32::from(open));
        }
    }
}

impl Event {
    fn resolve(
        &self,
        canvas: &Canvas<'_>,
        maps: &dyn Maps,
        deeds: &mut Vec<Deed>,
    ) -> Result<(), ResolveError> {
        let cover = |area: &Area| cover(area, canvas, maps);
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
                let map = map_of(area, maps)?;
                deeds.push(Deed::Water(times(area.cover_tapered(canvas, map.as_ref(), TAPER_MM), *water)));
                Deed::Pigment(cover(area)?, amounts.clone())
            }
            // What is drawn is resolved for the glaze as a whole, and lies there first.
            Self::Fill(_) | Self::Marks { .. } => return Ok(()),
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

fn cover(area: &Area, canvas: &Canvas<'_>, maps: &dyn Maps) -> Result<Coverage, ResolveError> {
    Ok(area.cover(canvas, map_of(area, maps)?.as_ref()))
}

/// The raster of an area that is a map.
fn map_of(area: &Area, maps: &dyn Maps) -> Result<Option<Raster<f32>>, ResolveError> {
    match &area.shape {
        Shape::Map(name) => load(name, maps).map(Some),
        _ => Ok(None),
    }
}

pub(crate) fn load(name: &MapName, maps: &dyn Maps) -> Result<Raster<f32>, ResolveError> {
    let MapName { file, place } = name;
    let (file, place) = (|| file.clone(), || place.clone());
    maps.map(&name.file).map_err(|fault| match fault {
        MapFault::Open(source) => ResolveError::Open { file: file(), place: place(), source },
        MapFault::Read(source) => ResolveError::Map { file: file(), place: place(), source },
    })
}
