//! The plan of a photograph becomes a document: a drawing, washes that fill it light to dark, and marks on top.

use std::sync::atomic::{AtomicBool, Ordering};

use girtin_grid::Raster;
use girtin_grid::resize::resized_plane;
use girtin_optics::{Pigment, UnknownPigment};
use girtin_painting::document::{
    Event, Figure, Fill, FilledFigure, Glaze, Graded, MAX_FIGURES, Mark, SheetSettings,
};
use girtin_painting::drawing::Drawing;
use girtin_painting::{Document, MapChest, PaintConfig, PaintError, Painted, ResolveError, Stock};
use girtin_wash::{LivingParams, WashModel};
use rayon::prelude::*;

use crate::accents::lights;
use crate::accidents::smoothstep;
use crate::border::border;
use crate::brushwork::brushwork;
use crate::contours::around;
use crate::edges::Edges;
use crate::mixing::{glazed, glazed_over, linear, over, stored as stored_amounts};
use crate::mount::{Mount, Mounting, PAPER};
use crate::palette::{Cluster, choose};
use crate::segments::Sets;
use crate::separate::{MOST, Paints};
use crate::settings::PhotoParams;
use crate::shapes::{Shape, Shapes};
use crate::strokes::{Gesture, Sheet, outline};
use crate::study::{Study, hundredths};
use crate::values::MOST_WASHES;

/// Share of the whole that planning takes.
const PLANNED: f64 = 0.4;

/// Cells along the long edge that washes are simulated on, and how many a millimetre at most: water shows no more.
const WASH_CELLS: f64 = 680.0;
const WASH_CELLS_PER_MM: f64 = 3.0;
/// The same as a part of the plan's cells: a small photograph has no more.
const WASH_CELLS_OF_PLAN: f64 = 0.62;

/// Most small lights.
const MOST_LIGHTS: f64 = 72.0;

/// Difference of two colors, Lab, up to which they run into each other where they meet, by wash.
const RUN_TOGETHER: [f32; MOST_WASHES] = [24.0, 22.0, 18.0, 15.0];

/// Film of each wash, how uneven it is, and over how much of the long edge.
const WATER: [f64; MOST_WASHES] = [0.60, 0.45, 0.42, 0.40];
const UNEVEN: [f64; MOST_WASHES] = [0.12, 0.18, 0.18, 0.16];
const UNEVEN_OVER: f64 = 0.07;
/// How far the pigments of each wash part.
const CHARGED: [f64; MOST_WASHES] = [0.20, 0.28, 0.32, 0.34];
/// Steps that each wash has to dry in.
const STEPS: [u32; MOST_WASHES] = [420, 300, 280, 240];
/// Rims of each wash, and of marks.
const RIMS: [f64; MOST_WASHES] = [0.8, 1.1, 1.1, 0.9];
const MARK_RIMS: f64 = 0.6;
/// How far paint flows in each wash, times the living wash's own diffusion; and how far at most, its own measure.
const FLOWS: [f64; MOST_WASHES] = [1.6, 0.9, 0.4, 0.15];
const MOST_DIFFUSION: f64 = 0.02;
/// How crisp contours within a family are where nobody looks; and between which attentions they become quite so.
const HELD: f32 = 0.15;
const HELD_SEEN: [f32; 2] = [0.15, 0.6];
/// Difference of two finished colors, Lab, from which on they are kept apart in every wash.
const APART: f32 = 34.0;
/// How much more colors run into each other where nobody looks.
const RUN_ASIDE: f32 = 0.7;
/// Granulation of every wash, by a pigment's own.
const GRAIN: f64 = 0.58;

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
    /// Where the eye is drawn to, parts of the photograph's width and height. `None`: it is found.
    pub focus: Option<[f64; 2]>,
    /// Title.
    pub title: &'a str,
}

/// What is being done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// The photograph is looked at.
    Looking,
    /// Values, masses and marks are decided on.
    Planning,
    /// Pigments are chosen and mixed.
    Palette,
    /// The planned washes are laid and dry.
    Washing,
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
    let (document, maps) = plan(request, stock, watch)?;
    let progress = |steps: u64, of: u64| {
        if let Some(progress) = watch.progress {
            // A wash is mostly dry long before its last step.
            let part = (2.0 * steps as f64 / of.max(1) as f64).min(1.0);
            progress(Stage::Washing, PLANNED + (1.0 - PLANNED) * part);
        }
    };
    let config = PaintConfig { cancel: watch.cancel, progress: Some(&progress), ..PaintConfig::default() };
    let painted = document.paint(stock, &maps, &config)?;
    Ok(Painting { document, maps, painted })
}

/// Plans a painting of a photograph, and lays nothing yet: its document.
///
/// # Errors
/// As [`watercolorize`].
pub fn plan(
    request: &Request<'_>,
    stock: &Stock,
    watch: &Watch<'_>,
) -> Result<(Document, MapChest), PhotoError> {
    report(watch, Stage::Looking, 0.0)?;
    let mount = Mount::new(request.pixels, request.params.cells_for(request.pixels), &request.mounting);
    let study = Study::new(request, mount);
    report(watch, Stage::Planning, 0.4 * PLANNED)?;
    let planner = Planner::new(request, &study);
    report(watch, Stage::Palette, 0.7 * PLANNED)?;
    let pigments = palette(request, &planner.shapes, stock)?;
    let paints = Paints::new(pigments.iter().map(|pigment| &pigment.coefficients));
    let mut document = planner.document(&pigments, &paints);
    document.title = request.title.to_owned();
    report(watch, Stage::Washing, PLANNED)?;
    Ok((document, MapChest::default()))
}

/// How the washes behave: the first is wet and flows, later ones lie where they are laid but for their rims.
fn physics(wash: usize, params: &PhotoParams) -> LivingParams {
    let wet = params.wetness;
    let default = LivingParams::default();
    if wash == 0 {
        return LivingParams {
            edge_darkening: 0.005,
            edge_width: 1.8,
            evaporation: 0.005,
            slope_scale: 0.03,
            creep_speed: 0.0,
            pigment_diffusion: (FLOWS[0] * wet * default.pigment_diffusion).min(MOST_DIFFUSION),
            pigment_dispersion: default.pigment_dispersion * wet,
            ..default
        };
    }
    LivingParams {
        edge_darkening: 0.005,
        edge_width: 1.2,
        evaporation: 0.008,
        slope_scale: 0.0,
        creep_speed: 0.0,
        pigment_diffusion: (FLOWS[wash.min(MOST_WASHES - 1)] * wet * default.pigment_diffusion)
            .min(MOST_DIFFUSION),
        pigment_dispersion: 0.0,
        lifting: 0.0,
        settling: 0.3,
        ..default
    }
}

/// All that is decided, before colors are mixed.
struct Planner<'a> {
    request: &'a Request<'a>,
    study: &'a Study,
    shapes: Vec<Shape>,
    /// Which of them each cell belongs to, from 1.
    labels: Raster<u16>,
    edges: Edges,
    /// Marks of each layer, from the first.
    layers: Vec<(&'static str, Vec<Gesture>)>,
}

impl<'a> Planner<'a> {
    fn new(request: &'a Request<'a>, study: &'a Study) -> Self {
        let (params, seed) = (request.params, request.seed);
        let found = Shapes::new(study, params, seed);
        let mut shapes = found.shapes;
        let s = study.mount.long_edge;
        let masses = labels(&shapes, study);
        let strokes = brushwork(study, &shapes, &masses, params, seed);
        shapes.extend(strokes);
        let labels = labels(&shapes, study);
        // Small lights lie over all, and no wash fills them.
        let fine = girtin_grid::blur::gaussian_plane(&study.lab.map(|color| color[0]), 0.0009 * s);
        let chroma = study.lab.map(|[_, a, b]| libm::hypotf(a, b));
        let plain = Raster::by_rows(labels.width(), labels.height(), |x, y| {
            let shape = labels.at(x, y).checked_sub(1).map(|shape| &shapes[usize::from(shape)]);
            shape.map_or(
                97.0,
                |shape| if shape.washes == 0 { 97.0 } else { shape.color_at([x as f32, y as f32])[0] },
            )
        });
        let texture = &study.texture;
        let most = (MOST_LIGHTS * params.lights) as usize;
        let found_lights = lights(
            &fine,
            &chroma,
            &study.attention,
            &texture.foliage,
            &study.face,
            &plain,
            &found.sky,
            s,
            2 * most,
        );
        // The most important are kept bare; a knife finds some of the rest again.
        let (kept, left) = found_lights.split_at(most.min(found_lights.len()));
        shapes.extend(kept.iter().map(|light| Shape::bare(vec![outline(light)])));
        if let Some(reserve) = request.reserve {
            let size = study.mount.photo;
            let reserve = resized_plane(reserve, size[0], size[1]);
            let mask = study.mount.place(&reserve.map(|value| [value])).map(|[value]| value >= 0.5);
            let rings = around(&mask, s, 0.3);
            if !rings.is_empty() {
                shapes.push(Shape::bare(rings));
            }
        }
        let rings = border(study, &labels, &request.mounting, seed);
        if !rings.is_empty() {
            shapes.push(Shape { is_border: true, ..Shape::bare(rings) });
        }
        shapes.truncate(MAX_FIGURES);
        let labels = self::labels(&shapes, study);
        let edges = Edges::new(study, &shapes, &labels, params, seed);
        let sheet = Sheet { study, shapes: &shapes, labels: &labels, seed };
        let mut layers = vec![
            ("pencil", sheet.pencil(&edges.inked, params)),
            ("tones and texture", [sheet.inner_tones(params), sheet.texture(params)].concat()),
            ("accents", sheet.accents(params)),
            ("knife and spatter", [sheet.spatter(params), sheet.scraped(left, params)].concat()),
            ("ink", sheet.ink(&edges.inked, params)),
        ];
        for (_, layer) in &mut layers {
            layer.retain(|gesture| sheet.is_free(gesture));
        }
        Self { request, study, shapes, labels, edges, layers }
    }

    fn document(&self, pigments: &[&Pigment], paints: &Paints) -> Document {
        let (study, params) = (self.study, self.request.params);
        let paper = PAPER.to_linear().0.map(|channel| channel as f32);
        // Amounts of each shape, at both ends, in each wash.
        let mixes: Vec<[Vec<Vec<f32>>; 2]> = self
            .shapes
            .par_iter()
            .map(|shape| {
                [0, 1].map(|end: usize| match shape.over {
                    Some((first, of_first)) => {
                        let first = (first[end], of_first);
                        glazed_over(paints, shape.colors[end], first, paper, shape.washes)
                    }
                    None => glazed(paints, shape.colors[end], paper, shape.washes),
                })
            })
            .collect();
        let names: Vec<String> = pigments.iter().map(|pigment| pigment.id.clone()).collect();
        let glaze = |name: String, physics: LivingParams, events: Vec<Event>| Glaze {
            name,
            pigments: names.clone(),
            model: WashModel::Living(physics),
            granulation: GRAIN * params.granulation,
            outline: None,
            events,
        };
        let mut glazes = Vec::new();
        for wash in 0..MOST_WASHES {
            let families =
                families(&self.shapes, &mixes, &self.labels, wash, paints, paper, params.wetness as f32);
            let figures: Vec<FilledFigure> = self
                .shapes
                .iter()
                .enumerate()
                .filter(|(_, shape)| shape.washes > wash)
                .map(|(figure, shape)| {
                    let [begin, end] = [0, 1].map(|end: usize| stored_amounts(&mixes[figure][end][wash]));
                    let graded = (begin != end)
                        .then(|| Graded { line: shape.line.map(|end| study.mm(end)), amounts: end });
                    let laid_degrees = shape.laid.map(|angle| libm::round(f64::from(angle.to_degrees())));
                    FilledFigure {
                        figure,
                        amounts: begin,
                        graded,
                        family: families[figure],
                        laid_degrees,
                        held: held(shape, params.wetness),
                    }
                })
                .collect();
            if figures.is_empty() {
                continue;
            }
            let fill = Fill {
                figures,
                water: WATER[wash],
                uneven: UNEVEN[wash],
                charged: CHARGED[wash],
                uneven_scale_mm: hundredths(UNEVEN_OVER * self.request.mounting.long_edge_mm),
                rim: hundredths(RIMS[wash] * params.rims).min(2.0),
                edges: self.edges.soft[wash].clone(),
            };
            let events = vec![
                Event::Fill(fill),
                Event::Run { steps: STEPS[wash], until_dry: true, feed: None },
                Event::Dry { area: None, damp: [0.0; 2] },
            ];
            glazes.push(glaze(format!("wash {}", wash + 1), physics(wash, params), events));
        }
        let sheet = Sheet { study, shapes: &self.shapes, labels: &self.labels, seed: self.request.seed };
        for (name, gestures) in self.layers.iter().filter(|(_, gestures)| !gestures.is_empty()) {
            let marks = gestures.par_iter().map(|gesture| mark(gesture, &sheet, paints)).collect();
            let events = vec![Event::Marks { marks, rim: hundredths(MARK_RIMS * params.rims).min(2.0) }];
            glazes.push(glaze((*name).to_owned(), physics(1, params), events));
        }
        let Request { mounting, paper, seed, long_edge, .. } = self.request;
        let settings = study.mount.sheet(mounting, paper, *seed, *long_edge);
        let cells = WASH_CELLS.min(WASH_CELLS_OF_PLAN * study.mount.long_edge);
        let per_mm = (cells / mounting.long_edge_mm).min(WASH_CELLS_PER_MM);
        let drawing = self.shapes.iter().map(|shape| Figure {
            rings: shape
                .rings
                .iter()
                .map(|ring| ring.iter().map(|&point| study.mm(point)).collect())
                .collect(),
        });
        Document {
            title: String::new(),
            drawing: drawing.collect(),
            sheet: SheetSettings { cells_per_pixel: 1, cells_per_mm: Some(per_mm), ..settings },
            glazes,
        }
    }
}

/// How crisp a shape's contour stays within its family: what nobody looks at runs.
fn held(shape: &Shape, wetness: f64) -> f64 {
    let seen = smoothstep(shape.attention, HELD_SEEN[0], HELD_SEEN[1]);
    hundredths(f64::from(HELD + (1.0 - HELD) * seen) / wetness.max(1.0))
}

/// Which shape each cell of the plan belongs to, from 1.
fn labels(shapes: &[Shape], study: &Study) -> Raster<u16> {
    let figures: Vec<Figure> = shapes
        .iter()
        .map(|shape| Figure {
            rings: shape
                .rings
                .iter()
                .map(|ring| ring.iter().map(|&[x, y]| [f64::from(x), f64::from(y)]).collect())
                .collect(),
        })
        .collect();
    let [width, height] = study.mount.size;
    Drawing::exact(&figures).labels(width, height, 1.0, [0.0, 0.0])
}

/// Which shapes of a wash run into each other: those that meet and differ little are of one family.
fn families(
    shapes: &[Shape],
    mixes: &[[Vec<Vec<f32>>; 2]],
    labels: &Raster<u16>,
    wash: usize,
    paints: &Paints,
    paper: [f32; 3],
    wetness: f32,
) -> Vec<u32> {
    let colors: Vec<Option<[f32; 3]>> = shapes
        .iter()
        .zip(mixes)
        .map(|(shape, mix)| {
            (shape.washes > wash).then(|| crate::separate::lab(paints.over(&mix[0][wash], paper)))
        })
        .collect();
    let mut of = Sets::new(shapes.len());
    let limit = RUN_TOGETHER[wash] * (0.5 + 0.5 * wetness);
    for y in 0..labels.height() {
        for x in 0..labels.width() {
            let own = labels.row(y)[x];
            let right = if x + 1 < labels.width() { labels.row(y)[x + 1] } else { own };
            let below = if y + 1 < labels.height() { labels.row(y + 1)[x] } else { own };
            for other in [right, below] {
                if own == other || own == 0 || other == 0 {
                    continue;
                }
                let (a, b) = (u32::from(own) - 1, u32::from(other) - 1);
                let (Some(one), Some(two)) = (colors[a as usize], colors[b as usize]) else { continue };
                let square: f32 = one.iter().zip(two).map(|(a, b)| (a - b) * (a - b)).sum();
                let seen = shapes[a as usize].attention.max(shapes[b as usize].attention);
                let limit = limit * (1.0 + RUN_ASIDE * (1.0 - seen));
                // Things that differ when they are finished are kept apart from the first.
                let finished: f32 = (0..3)
                    .map(|c| shapes[a as usize].colors[0][c] - shapes[b as usize].colors[0][c])
                    .map(|off| off * off)
                    .sum();
                if square < limit * limit && finished < APART * APART {
                    let (a, b) = (of.of(a), of.of(b));
                    if a != b {
                        of.join(a, b);
                    }
                }
            }
        }
    }
    (0..shapes.len() as u32).map(|at| of.of(at)).collect()
}

/// A gesture with its color mixed for what it lies on.
fn mark(gesture: &Gesture, sheet: &Sheet<'_>, paints: &Paints) -> Mark {
    let study = sheet.study;
    let ground = linear(sheet.below(&gesture.points));
    let amounts = |color| stored_amounts(&over(paints, color, ground));
    let mm = |cells: f32| hundredths(f64::from(cells) / study.mount.cells_per_mm);
    let three = |values: [f32; 3]| values.map(|value| hundredths(f64::from(value)));
    Mark {
        path: gesture.points.iter().map(|&point| study.mm(point)).collect(),
        widths: gesture.widths.iter().map(|&width| mm(width).max(0.05)).collect(),
        side: hundredths(f64::from(gesture.side)).clamp(-0.5, 0.5),
        chisel_degrees: gesture.chisel.map(|degrees| libm::round(f64::from(degrees))),
        dry: three(gesture.dry),
        bristles: three(gesture.bristles),
        drag: gesture.drag.map(|value| hundredths(f64::from(value))),
        scraped: hundredths(f64::from(gesture.scraped)),
        amounts: amounts(gesture.color),
        end_amounts: gesture.end_color.map(amounts),
        bead: 0.4,
    }
}

/// The pigments: those asked for, or some that mix the planned colors.
fn palette<'a>(
    request: &Request<'_>,
    shapes: &[Shape],
    stock: &'a Stock,
) -> Result<Vec<&'a Pigment>, PhotoError> {
    if let Some(names) = request.palette {
        if !(1..=MOST).contains(&names.len()) {
            return Err(PhotoError::Palette(names.len()));
        }
        return Ok(names.iter().map(|name| stock.pigments.get(name)).collect::<Result<_, _>>()?);
    }
    // Small shapes at the focus count for more than their area.
    let mut clusters: Vec<Cluster> = shapes
        .iter()
        .filter(|shape| shape.washes > 0)
        .map(|shape| {
            let [a, b] = shape.colors;
            let middle = [0, 1, 2].map(|c: usize| 0.5 * (a[c] + b[c]));
            (middle, libm::sqrt(shape.area) * f64::from(0.3 + shape.attention))
        })
        .collect();
    crate::palette::gather(&mut clusters);
    let paper = PAPER.to_linear().0.map(|channel| channel as f32);
    Ok(choose(stock.pigments.iter(), &clusters, paper, request.params.colors as usize))
}

fn report(watch: &Watch<'_>, stage: Stage, part: f64) -> Result<(), PhotoError> {
    if watch.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed)) {
        return Err(PhotoError::Cancelled);
    }
    if let Some(progress) = watch.progress {
        progress(stage, part);
    }
    Ok(())
}
