//! Wash by wash: what is missing is found on the sheet as the washes below dried, and just that is laid.

use std::sync::atomic::{AtomicBool, Ordering};

use girtin_grid::resize::resized;
use girtin_grid::{Raster, random};
use girtin_optics::kubelka_munk::glaze_row;
use girtin_optics::{LinearRgb, Pigment, Srgb, UnknownPigment};
use girtin_painting::area::{Area, Canvas, Shape};
use girtin_painting::composite::print;
use girtin_painting::document::{Event, Glaze, MapName, Outline, SheetSettings};
use girtin_painting::paint::paint_glaze;
use girtin_painting::resolve::{EDGE_STEPS, PlannedSheet};
use girtin_painting::{
    Document, MapChest, PaintConfig, PaintError, Painted, PaintedGlaze, ResolveError, Stock, StoredMap,
};
use girtin_wash::{LivingParams, WashModel};
use rayon::prelude::*;

use crate::accidents::plane;
use crate::intent::Intent;
use crate::load::{Load, Planner};
use crate::mount::{Mount, Mounting, PAPER, stored};
use crate::palette::{choose, clusters};
use crate::separate::{MOST, Paints, lab};
use crate::settings::PhotoParams;
use crate::study::Study;
use crate::tone::Tones;
use crate::washes::WashPlan;

/// Color of ink.
const INK: Srgb = Srgb([38.0 / 255.0, 34.0 / 255.0, 36.0 / 255.0]);

/// Cells of the photograph that a palette is chosen for.
const PALETTE_CELLS: f64 = 24_000.0;

/// Name of the map of masking fluid; all washes go around it.
const MASKED: &str = "masked.png";

/// Steps after which drops fall into the first wash: it shines no more, and is not dry yet.
const STEPS_BEFORE_DROPS: u32 = 56;

/// How far inside the photograph's border drops fall at most, a part of the long edge.
const NEAR_BORDER: f64 = 0.014;

/// What is to be painted, and how.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// The photograph: linear light, sRGB's primaries.
    pub photo: &'a Raster<[f32; 3]>,
    /// Columns and rows of the photograph as it was, if `photo` is a reduced copy; they give the picture its proportions.
    pub pixels: [usize; 2],
    /// How it is painted.
    pub params: &'a PhotoParams,
    /// Names of pigments; `None`: they are chosen.
    pub palette: Option<&'a [String]>,
    /// Name of the paper.
    pub paper: &'a str,
    /// How it lies on the sheet.
    pub mounting: Mounting,
    /// Seed of all accidents.
    pub seed: u64,
    /// Long edge of the picture without its margin, pixels.
    pub long_edge: u32,
    /// What stays bare paper, 1, over the photograph; any size.
    pub reserve: Option<&'a Raster<f32>>,
    /// How exactly things are drawn, 0 to 1, over the photograph; any size. `None`: it is found.
    pub detail_map: Option<&'a Raster<f32>>,
    /// Title.
    pub title: &'a str,
}

/// What is being done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The photograph is looked at.
    Looking,
    /// Pigments are chosen.
    Palette,
    /// A wash is planned, from 0.
    Planning(usize),
    /// A wash is laid and dries, from 0.
    Washing(usize),
}

/// Who watches the work.
#[derive(Clone, Copy, Default)]
pub struct Watch<'a> {
    /// Set it to end early.
    pub cancel: Option<&'a AtomicBool>,
    /// Called with what is done now, and how much of the whole is done, 0 to 1.
    pub progress: Option<&'a (dyn Fn(Stage, f64) + Sync)>,
}

impl std::fmt::Debug for Watch<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Watch").finish_non_exhaustive()
    }
}

/// A finished painting: its document, the maps that the document names, and what was simulated.
#[derive(Debug)]
pub struct Painting {
    /// The document.
    pub document: Document,
    /// Its maps.
    pub maps: MapChest,
    /// What every glaze left, as painting the document leaves it again.
    pub painted: Painted,
}

/// Why a photograph is not painted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PhotoError {
    /// A pigment is not in the stock.
    #[error(transparent)]
    Pigment(#[from] UnknownPigment),
    /// The palette has no pigment, or too many.
    #[error("the palette has {0} pigments; 1 to {MOST} are mixed")]
    Palette(usize),
    /// The document cannot be resolved.
    #[error(transparent)]
    Resolve(#[from] ResolveError),
    /// A wash did not run to its end.
    #[error(transparent)]
    Paint(#[from] PaintError),
    /// The caller cancelled.
    #[error("cancelled")]
    Cancelled,
}

/// Paints a photograph.
///
/// # Errors
/// A pigment or the paper is unknown, there is no memory, or the caller cancelled.
pub fn watercolorize(
    request: &Request<'_>,
    stock: &Stock,
    watch: &Watch<'_>,
) -> Result<Painting, PhotoError> {
    let painter = Painter::new(request, stock, watch)?;
    painter.paint()
}

struct Painter<'a> {
    request: &'a Request<'a>,
    stock: &'a Stock,
    watch: &'a Watch<'a>,
    study: Study<'a>,
    pigments: Vec<&'a Pigment>,
    paints: Paints,
    document: Document,
    maps: MapChest,
    sheet: PlannedSheet,
    /// The sheet as it is now.
    current: Raster<LinearRgb>,
    glazes: Vec<PaintedGlaze>,
}

impl<'a> Painter<'a> {
    fn new(request: &'a Request<'a>, stock: &'a Stock, watch: &'a Watch<'a>) -> Result<Self, PhotoError> {
        report(watch, Stage::Looking, 0.0)?;
        let (photo, params) = (request.photo, request.params);
        let mount = Mount::new(request.pixels, params.cells_for(request.pixels), &request.mounting);
        let mut document = document(request, &mount);
        let mut maps = MapChest::default();
        let mut sheet = document.resolve_sheet(stock, &maps)?;
        let study = Study::new(request, mount, &sheet.height);
        if params.ink > 0.0 {
            maps.0.insert("ink.png".to_owned(), StoredMap::bytes(&study.ink(photo)));
            document.sheet.printed.push((stored(INK), map_area("ink.png")));
            sheet = document.resolve_sheet(stock, &maps)?;
        }
        if let Some(masked) = &study.masked {
            maps.0.insert(MASKED.to_owned(), StoredMap::bytes(masked));
        }
        report(watch, Stage::Palette, 0.1)?;
        let pigments = palette(request, &study.tones, stock)?;
        Ok(Self {
            paints: Paints::new(pigments.iter().map(|pigment| &pigment.coefficients)),
            current: ground_of(&sheet),
            request,
            stock,
            watch,
            study,
            pigments,
            document,
            maps,
            sheet,
            glazes: Vec::new(),
        })
    }

    fn say(&self, stage: Stage, part: f64) -> Result<(), PhotoError> {
        report(self.watch, stage, part)
    }

    fn paint(mut self) -> Result<Painting, PhotoError> {
        let count = self.request.params.washes as usize;
        let tones = self.study.tones;
        let plans: Vec<WashPlan> = (0..count).map(|index| WashPlan::of(index, count)).collect();
        // None of this waits for a sheet to dry, and much of it goes one cell after the other: all washes at once.
        let intents: Vec<Intent> = (0..count)
            .into_par_iter()
            .map(|index| {
                let lightest = |plan: &WashPlan| tones.darks + tones.range * plan.level;
                let before = index.checked_sub(1).map_or(100.0, |before| lightest(&plans[before]));
                Intent::new(&self.study, &plans[index], index, lightest(&plans[index]), before)
            })
            .collect();
        for (index, (plan, intent)) in plans.iter().zip(intents).enumerate() {
            let part = |of: f64| 0.25 + 0.75 * (index as f64 + of) / count as f64;
            self.say(Stage::Planning(index), part(0.0))?;
            let planner = Planner {
                study: &self.study,
                paper: &self.sheet.height,
                current: &self.current,
                paints: &self.paints,
            };
            let load = planner.plan(plan, index, &intent);
            self.say(Stage::Washing(index), part(0.4))?;
            if let Some(load) = load {
                self.lay(plan, index, &load, part(0.4), 0.45 / count as f64)?;
            }
        }
        Ok(Painting {
            document: self.document,
            maps: self.maps,
            painted: Painted { sheet: self.sheet, glazes: self.glazes },
        })
    }

    /// Writes a wash into the document, and lets it run and dry.
    fn lay(
        &mut self,
        plan: &WashPlan,
        index: usize,
        load: &Load,
        done: f64,
        share: f64,
    ) -> Result<(), PhotoError> {
        let name = |of: &str| format!("wash-{}-{of}.png", index + 1);
        let mut keep = |file: String, map: StoredMap| {
            let area = map_area(&file);
            self.maps.0.insert(file, map);
            area
        };
        let steps = load.edges.map(|edge| (edge * EDGE_STEPS + 0.5).min(255.0) as u8);
        keep(name("shapes"), StoredMap::Bytes(load.shapes.clone()));
        keep(name("edges"), StoredMap::Bytes(steps));
        let turbulence =
            plan.turbulence * (self.request.params.turbulence * self.request.params.freedom()) as f32;
        // Wide, as a brush is refilled and a sheet leans; what is as small as a blotch would be dirt.
        let [long, short] = [0.11, 0.012].map(|sigma| {
            let stage = format!("load {sigma} {index}");
            plane(self.request.seed, &stage, self.study.mount.size, self.study.mount.cells(sigma))
        });
        let mut events = vec![
            Event::Moisten {
                area: keep(name("moist"), StoredMap::bytes(&load.moist.map(|m| m / 2.0))),
                volumes: 2.0,
            },
            Event::Wet { area: Area::default() },
            Event::Water { area: keep(name("water"), StoredMap::bytes(&load.water)), amount: 1.0 },
        ];
        let mut pigments = Vec::new();
        for k in 0..self.pigments.len() {
            let mut amounts = Raster::by_rows(self.study.mount.size[0], self.study.mount.size[1], |x, y| {
                let uneven = 1.0 + turbulence * (0.7 * long.at(x, y) + 0.25 * short.at(x, y));
                let there = f32::from(u8::from(load.shapes.at(x, y) != 0));
                load.amounts.at(x, y)[k] * uneven.clamp(0.4, 1.7) * there
            });
            let most = amounts.as_slice().iter().fold(0.0f32, |most, &amount| most.max(amount));
            if most < 0.004 {
                continue;
            }
            amounts.as_mut_slice().iter_mut().for_each(|amount| *amount /= most);
            let area = keep(name(&self.pigments[k].id), StoredMap::words(&amounts));
            pigments.push((k, area, f64::from(most)));
        }
        for (at, (_, area, most)) in pigments.iter().enumerate() {
            let mut amounts = vec![0.0; pigments.len()];
            amounts[at] = *most;
            events.push(Event::Pigment { area: area.clone(), amounts });
        }
        if index == 0 && self.request.params.drops > 0 {
            events.push(Event::Run { steps: STEPS_BEFORE_DROPS, until_dry: false, feed: None });
            events.extend(self.drops());
        }
        events.push(Event::Run { steps: 400, until_dry: true, feed: None });
        events.push(Event::Dry { area: None, damp: [0.0, 0.0] });
        let glaze = Glaze {
            name: format!("wash {}", index + 1),
            pigments: pigments.iter().map(|(k, ..)| self.pigments[*k].id.clone()).collect(),
            model: WashModel::Living(self.physics(plan)),
            granulation: plan.granulation * self.request.params.granulation,
            outline: Some(Outline {
                regions: map_name(&name("shapes")),
                edges: Some(map_name(&name("edges"))),
                masked: self.study.masked.as_ref().map(|_| map_name(MASKED)),
            }),
            events,
        };
        let planned = glaze.resolve(&self.sheet, self.stock, &self.maps)?;
        let progress = |steps: u64, of: u64| {
            if let Some(progress) = self.watch.progress {
                // A wash is mostly dry long before its last step.
                let part = (2.0 * steps as f64 / of.max(1) as f64).min(1.0);
                progress(Stage::Washing(index), done + share * part);
            }
        };
        let config =
            PaintConfig { cancel: self.watch.cancel, progress: Some(&progress), ..PaintConfig::default() };
        let painted = paint_glaze(&self.sheet, &glaze, planned, index, &config)?;
        lay_over(&painted, &mut self.current);
        self.document.glazes.push(glaze);
        self.glazes.push(painted);
        Ok(())
    }

    /// Drops of water that gather at the border where nothing is exact, run back and push the paint aside.
    fn drops(&self) -> Vec<Event> {
        let key = random::key(self.request.seed, random::stage("drops"));
        let cells_per_mm = self.study.mount.cells_per_mm;
        let near_border = -self.study.cells(NEAR_BORDER) as f32;
        // Places are tried in order; a picture that is exact everywhere gets fewer.
        let places = (0..200 * self.request.params.drops).filter(|&at| {
            let [x, y] = place_of_drop(key, at, self.study.mount.size);
            let distance = self.study.distance.at(x, y);
            self.study.exact.at(x, y) < 0.25
                && self.study.bare.at(x, y) == 0
                && (near_border..0.0).contains(&distance)
        });
        let splash = |at: u32| {
            let center =
                place_of_drop(key, at, self.study.mount.size).map(|at| (at as f64 + 0.5) / cells_per_mm);
            let between = move |axis: i64, low: f64, high: f64| {
                random::between(random::at(key, [i64::from(at), axis]), low, high)
            };
            let radius = self.study.cells(between(2, 0.008, 0.02)) / cells_per_mm;
            // A drop splashes: one disc dries as a moon.
            (0..3).map(move |part| {
                let (sin, cos) = libm::sincos(between(3 + 3 * part, 0.0, std::f64::consts::TAU));
                let off = if part == 0 { 0.0 } else { radius * between(4 + 3 * part, 0.7, 1.5) };
                let radius = if part == 0 { radius } else { radius * between(5 + 3 * part, 0.3, 0.8) };
                let area = Area {
                    shape: Shape::Disc { center: [center[0] + off * cos, center[1] + off * sin], radius },
                    soft_mm: 0.3 * radius,
                    ragged_mm: 0.5 * radius,
                    ragged_scale_mm: radius,
                    ..Area::default()
                };
                Event::Water { area, amount: 0.9 }
            })
        };
        places.take(self.request.params.drops as usize).flat_map(splash).collect()
    }

    fn physics(&self, plan: &WashPlan) -> LivingParams {
        let params = self.request.params;
        LivingParams {
            edge_darkening: 8.0 * plan.edge_darkening * params.rims,
            // Narrow, so that the seam between two shapes, a cell wide, counts as an edge.
            edge_width: 1.2,
            evaporation: 0.008,
            creep_speed: 0.0,
            slope_scale: plan.slope,
            ..LivingParams::default()
        }
    }
}

/// Tells the watcher, unless it has had enough.
fn report(watch: &Watch<'_>, stage: Stage, part: f64) -> Result<(), PhotoError> {
    if watch.cancel.is_some_and(|cancel| cancel.load(Ordering::SeqCst)) {
        return Err(PhotoError::Cancelled);
    }
    if let Some(progress) = watch.progress {
        progress(stage, part);
    }
    Ok(())
}

/// The pigments that are asked for, or that suit the picture.
fn palette<'a>(
    request: &Request<'_>,
    tones: &Tones,
    stock: &'a Stock,
) -> Result<Vec<&'a Pigment>, PhotoError> {
    if let Some(names) = request.palette {
        if names.is_empty() || names.len() > MOST {
            return Err(PhotoError::Palette(names.len()));
        }
        return Ok(names.iter().map(|name| stock.pigments.get(name)).collect::<Result<_, _>>()?);
    }
    // The photograph alone, so that no margin has a say.
    let pixels = request.pixels.map(|side| side as f64);
    let shrink = libm::sqrt(PALETTE_CELLS / (pixels[0] * pixels[1])).min(1.0);
    let [width, height] = pixels.map(|side| libm::round(side * shrink).max(1.0) as usize);
    let small = resized(request.photo, width, height).map(|color| tones.of(lab(color)));
    let clusters = clusters(&small, request.seed);
    let paper = PAPER.to_linear().0.map(|channel| channel as f32);
    Ok(choose(stock.pigments.iter(), &clusters, paper, request.params.colors as usize))
}

/// The document before any glaze.
fn document(request: &Request<'_>, mount: &Mount) -> Document {
    let Request { mounting, paper, seed, long_edge, params, .. } = request;
    let sheet = mount.sheet(mounting, paper, *seed, *long_edge);
    Document {
        title: request.title.to_owned(),
        sheet: SheetSettings { relief_mm: params.relief, ..sheet },
        glazes: Vec::new(),
    }
}

fn map_name(file: &str) -> MapName {
    MapName { file: file.to_owned(), place: Default::default() }
}

fn map_area(file: &str) -> Area {
    Area { shape: Shape::Map(map_name(file)), ..Area::default() }
}

/// The bare sheet at its cells, ink included.
fn ground_of(sheet: &PlannedSheet) -> Raster<LinearRgb> {
    let [width, height] = [sheet.height.width(), sheet.height.height()];
    let mut ground = Raster::new(width, height, sheet.ground);
    let canvas = Canvas::whole(&sheet.height, sheet.cells_per_mm, sheet.seed);
    for (color, area, map) in &sheet.printed {
        print(&mut ground, *color, &area.cover(&canvas, map.as_ref()));
    }
    ground
}

/// Lays what a glaze left over the sheet, cell by cell.
fn lay_over(glaze: &PaintedGlaze, ground: &mut Raster<LinearRgb>) {
    let width = ground.width();
    let (amounts, paints) = (&glaze.dried.amounts, &glaze.plan.paints);
    ground.as_mut_slice().par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        let mut rows: Vec<Vec<f32>> = amounts.iter().map(|amounts| amounts.row(y).to_vec()).collect();
        if let Some(outline) = &glaze.plan.outline {
            let shapes = outline.regions.row(y);
            for row in &mut rows {
                row.iter_mut()
                    .zip(shapes)
                    .for_each(|(amount, &shape)| *amount *= f32::from(u8::from(shape != 0)));
            }
        }
        let rows: Vec<&[f32]> = rows.iter().map(Vec::as_slice).collect();
        glaze_row(paints, &rows, row);
    });
}

/// The cell that a drop may fall on.
fn place_of_drop(key: u64, at: u32, size: [usize; 2]) -> [usize; 2] {
    [0, 1].map(|axis: usize| {
        let part = random::unit_f64(random::at(key, [i64::from(at), axis as i64]));
        (part * size[axis] as f64) as usize
    })
}
