//! Mattes, pigments and a picture become a document.

use std::sync::atomic::AtomicBool;

use girtin_grid::Raster;
use girtin_grid::memory::{NoRoom, probe};
use girtin_optics::LinearRgb;
use girtin_painting::area::Canvas;
use girtin_painting::document::{Glaze, SheetSettings};
use girtin_painting::{Document, MapChest, ResolveError, Stock, StoredMap, handling_of, memory};
use girtin_paper::{HeightSource, Sheet};
use girtin_wash::{RunConfig, RunError, StateError};

use super::brushstrokes::{GlazeTask, Look, NamedMap, PlanError, paint_glaze};
use super::seams::Seams;
use super::stretch::stretched;
use super::target_glaze::WETTED;
use super::{ColorSeparation, GlazesFile, MatteGlazes, TooManyStacks, target_glazes};
use crate::mattes::Matte;

/// What is to be painted.
#[derive(Clone, Copy, Debug)]
pub struct C97Request<'a> {
    /// Title of the painting.
    pub title: &'a str,
    /// The wanted picture.
    pub picture: &'a Raster<LinearRgb>,
    /// Mattes of its size, found by name; highlights among them.
    pub mattes: &'a [Matte],
    /// What each is painted with.
    pub glazes: &'a GlazesFile,
    /// Paper, its size, and how finely the wash is simulated. A finer sheet of the same document is painted with the same
    /// brushstrokes.
    pub sheet: &'a SheetSettings,
    /// Pigments and papers.
    pub stock: &'a Stock,
}

/// How it is done; nothing here changes the painting.
#[derive(Clone, Copy, Default)]
pub struct C97Config<'a> {
    /// Number of threads; 0 takes those of the rayon pool this is called in.
    pub threads: usize,
    /// Set it to end early.
    pub cancel: Option<&'a AtomicBool>,
    /// Called with steps done and steps in all.
    pub progress: Option<&'a (dyn Fn(u64, u64) + Sync)>,
}

impl std::fmt::Debug for C97Config<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("C97Config").field("threads", &self.threads).finish_non_exhaustive()
    }
}

/// A painting, planned and painted once.
#[derive(Clone, Debug)]
pub struct C97Painting {
    /// The document, of ordinary events on maps.
    pub document: Document,
    /// Its maps by the names of their files.
    pub maps: MapChest,
    /// What was wanted and what was painted, of every pigment of every matte in the order of the file.
    pub glazes: Vec<C97Glaze>,
}

/// One pigment of one matte.
#[derive(Clone, Debug)]
pub struct C97Glaze {
    /// Name of the matte.
    pub matte: String,
    /// Id of the pigment.
    pub pigment: String,
    /// The target glaze: wanted thickness in every pixel of the picture.
    pub target: Raster<f32>,
    /// Number of its glaze in the document, from 0; none where nothing of the pigment is wanted.
    pub glaze: Option<usize>,
    /// How far it was off after every interval.
    pub looks: Vec<Look>,
    /// What was left of it in every cell.
    pub left: Raster<f32>,
}

/// Why there is no painting.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum C97Error {
    /// The picture has no pixels.
    #[error("the picture is empty")]
    NoPicture,
    /// A matte that the file names is not there.
    #[error("there is no matte `{name}`")]
    NoMatte {
        /// Its name.
        name: String,
        /// What to do.
        hint: String,
    },
    /// A matte has another size than the picture.
    #[error("matte `{name}` is {width} × {height} pixels, and the picture is {} × {}", wanted[0], wanted[1])]
    MatteSize {
        /// Its name.
        name: String,
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// Columns and rows of the picture.
        wanted: [usize; 2],
    },
    /// There is nothing in a matte.
    #[error("matte `{name}` is empty")]
    EmptyMatte {
        /// Its name.
        name: String,
    },
    /// A name that the stock does not have.
    #[error("{0}")]
    Unknown(String),
    /// There are more stacks than can be tried.
    #[error("matte `{matte}`: {source}")]
    Stacks {
        /// The matte.
        matte: String,
        /// Why.
        source: TooManyStacks,
    },
    /// The sheet cannot be simulated.
    #[error(transparent)]
    Sheet(#[from] ResolveError),
    /// There is no memory for it.
    #[error(transparent)]
    NoRoom(#[from] NoRoom),
    /// A glaze's state is not allowed.
    #[error("matte `{matte}`, {pigment}: {source}")]
    State {
        /// The matte.
        matte: String,
        /// The pigment.
        pigment: String,
        /// What is wrong.
        source: StateError,
    },
    /// A glaze did not run to its end.
    #[error("matte `{matte}`, {pigment}: {source}")]
    Run {
        /// The matte.
        matte: String,
        /// The pigment.
        pigment: String,
        /// Why.
        source: RunError,
    },
    /// The caller asked for it.
    #[error("cancelled")]
    Cancelled,
    /// No threads could be had.
    #[error("cannot start {threads} threads: {message}")]
    Threads {
        /// How many were asked for.
        threads: usize,
        /// Why not.
        message: String,
    },
}

impl C97Error {
    /// What to do about it.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::NoMatte { hint, .. } => Some(hint.clone()),
            Self::MatteSize { wanted: [width, height], .. } => {
                Some(format!("save the matte at {width} × {height} pixels"))
            }
            Self::EmptyMatte { .. } => Some(
                "paint the region white in the matte, not only grey, or leave it out of the file".to_owned(),
            ),
            Self::Stacks { .. } => Some("name fewer pigments or lower `steps`".to_owned()),
            Self::NoRoom(_) => Some("simulate fewer cells a millimetre, or use a smaller sheet".to_owned()),
            Self::Run { source: RunError::RanAway { .. }, .. } => {
                Some("lower `phi_p` of the matte's `planning`: it pours that much water at once".to_owned())
            }
            _ => None,
        }
    }
}

/// Paints a picture from mattes and ordered pigments.
///
/// Each matte's colors are separated into its pigments ([`target_glazes`]); each pigment is painted as a glaze of its own
/// ([`paint_glaze`]), mattes in the order of the file, pigments from the paper up; highlights are lifted from every glaze
/// that they meet.
///
/// # Source
/// Curtis et al. 1997, §6.2.
///
/// # Shapes and units
/// The picture and the mattes are stretched over the whole sheet, what is trimmed included. W6: colors are separated over the sheet's bare ground, since a matte
/// does not know of other mattes' paint below it.
///
/// # Guarantees
/// The same document and maps for any number of threads (`any_number_of_threads_plans_the_same`).
///
/// # Errors
/// A matte is missing, empty or of another size; a name is unknown; the water ran away; there is no room; the caller
/// cancelled.
pub fn watercolorize_c97(request: &C97Request<'_>, config: &C97Config<'_>) -> Result<C97Painting, C97Error> {
    if config.threads == 0 {
        return watercolorize_here(request, config);
    }
    let threads = config.threads;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| C97Error::Threads { threads, message: error.to_string() })?;
    pool.install(|| watercolorize_here(request, config))
}

fn watercolorize_here(request: &C97Request<'_>, config: &C97Config<'_>) -> Result<C97Painting, C97Error> {
    let C97Request { picture, glazes, sheet, stock, .. } = *request;
    if picture.width() == 0 || picture.height() == 0 {
        return Err(C97Error::NoPicture);
    }
    let mattes: Vec<&Matte> =
        glazes.mattes.iter().map(|glazes| request.matte(&glazes.name, WETTED)).collect::<Result<_, _>>()?;
    let lifts: Vec<(NamedMap, f64)> = glazes
        .lifts
        .iter()
        .map(|lift| {
            let map = StoredMap::words(&request.matte(&lift.name, f32::MIN_POSITIVE)?.coverage);
            Ok(((format!("lift-{}.png", lift.name), map), lift.fraction))
        })
        .collect::<Result<_, C97Error>>()?;
    let mut document = request.empty_document();
    let [width, height] = document.cells()?;
    probe(memory::of_document(&document))?;
    document.glazes.clear();
    let unknown = |error: girtin_paper::UnknownPaper| C97Error::Unknown(error.to_string());
    let paper = stock.papers.get(&sheet.paper).map_err(unknown)?;
    let cells_per_mm = document.cells_per_mm();
    let paper_height = Sheet::new(paper, sheet.seed).height_field(width, height, cells_per_mm, [0.0, 0.0]);
    let canvas = Canvas::whole(&paper_height, cells_per_mm, sheet.seed);
    let seams = Seams::new(&glazes.mattes, &mattes, width, height);
    let mut work = Work {
        request,
        seams: &seams,
        config,
        canvas,
        done: 0,
        total: glazes.mattes.iter().map(|matte| matte.planning.steps() * matte.pigments.len() as u64).sum(),
        painting: C97Painting { document, maps: MapChest::default(), glazes: Vec::new() },
    };
    for (at, (glazes, matte)) in glazes.mattes.iter().zip(mattes).enumerate() {
        let met: Vec<(NamedMap, f64)> =
            lifts.iter().filter(|((_, map), _)| meets(&map.amounts(), &matte.coverage)).cloned().collect();
        work.paint_matte(at, glazes, matte, &met)?;
    }
    Ok(work.painting)
}

impl C97Request<'_> {
    /// The matte of this name, if it is of the picture's size and covers a pixel at least that much.
    fn matte(&self, name: &str, least: f32) -> Result<&Matte, C97Error> {
        let matte = self.mattes.iter().find(|matte| matte.name == name).ok_or_else(|| {
            let known: Vec<&str> = self.mattes.iter().map(|matte| matte.name.as_str()).collect();
            C97Error::NoMatte { name: name.to_owned(), hint: girtin_params::hint_for(name, &known) }
        })?;
        let (width, height) = (matte.coverage.width(), matte.coverage.height());
        let wanted = [self.picture.width(), self.picture.height()];
        if [width, height] != wanted {
            return Err(C97Error::MatteSize { name: name.to_owned(), width, height, wanted });
        }
        if !matte.coverage.as_slice().iter().any(|&covered| covered >= least) {
            return Err(C97Error::EmptyMatte { name: name.to_owned() });
        }
        Ok(matte)
    }

    /// The document with its glazes' physics but without their events, to see whether it can be simulated.
    fn empty_document(&self) -> Document {
        let glaze = |matte: &MatteGlazes| Glaze {
            name: String::new(),
            pigments: matte.pigments.first().cloned().into_iter().collect(),
            model: matte.model,
            granulation: 1.0,
            outline: None,
            events: Vec::new(),
        };
        Document {
            drawing: Vec::new(),
            title: self.title.to_owned(),
            sheet: self.sheet.clone(),
            glazes: self.glazes.mattes.iter().map(glaze).collect(),
        }
    }
}

/// Whether a highlight lies somewhere within a matte.
fn meets(highlight: &Raster<f32>, matte: &Raster<f32>) -> bool {
    highlight
        .as_slice()
        .iter()
        .zip(matte.as_slice())
        .any(|(&highlight, &matte)| highlight > 0.0 && matte >= WETTED)
}

/// A painting in the making.
struct Work<'a> {
    request: &'a C97Request<'a>,
    seams: &'a Seams,
    config: &'a C97Config<'a>,
    canvas: Canvas<'a>,
    done: u64,
    total: u64,
    painting: C97Painting,
}

impl Work<'_> {
    /// Paints the glazes of one matte.
    fn paint_matte(
        &mut self,
        at: usize,
        glazes: &MatteGlazes,
        matte: &Matte,
        lifts: &[(NamedMap, f64)],
    ) -> Result<(), C97Error> {
        let stock = &self.request.stock.pigments;
        let pigments: Vec<_> = glazes
            .pigments
            .iter()
            .map(|name| stock.get(name).map_err(|error| C97Error::Unknown(error.to_string())))
            .collect::<Result<_, _>>()?;
        let paints: Vec<_> = pigments
            .iter()
            .zip(&glazes.max_thickness)
            .map(|(pigment, &max)| (pigment.coefficients, max))
            .collect();
        let steps = self.request.glazes.separation.steps as usize;
        let separation = ColorSeparation::new(&paints, steps, self.request.sheet.ground)
            .map_err(|source| C97Error::Stacks { matte: matte.name.clone(), source })?;
        let targets = target_glazes(
            self.request.picture,
            &matte.coverage,
            &separation,
            paints.len(),
            self.config.cancel,
        )
        .ok_or(C97Error::Cancelled)?;
        let map = (format!("{:02}-{}-wet.png", at + 1, matte.name), StoredMap::words(&matte.coverage));
        let seam = self.seams.of(at);
        for (layer, (pigment, target)) in pigments.iter().zip(targets).enumerate() {
            let prefix = format!("{:02}-{}-{}-{}", at + 1, matte.name, layer + 1, pigment.id);
            let height = self.canvas.height;
            let on_canvas = stretched(&target, height.width(), height.height());
            let task = GlazeTask {
                canvas: self.canvas,
                matte: &map,
                lifts,
                target: &on_canvas,
                seam: &seam,
                handling: handling_of(pigment),
                model: glazes.model,
                planning: glazes.planning,
                prefix: &prefix,
            };
            let is_wanted = target.as_slice().iter().any(|&thickness| thickness > 0.0);
            self.paint_pigment(
                &task,
                is_wanted,
                C97Glaze {
                    matte: matte.name.clone(),
                    pigment: pigment.id.clone(),
                    glaze: is_wanted.then_some(self.painting.document.glazes.len()),
                    looks: Vec::new(),
                    left: Raster::new(height.width(), height.height(), 0.0),
                    target,
                },
            )?;
        }
        Ok(())
    }

    /// Paints one glaze, unless nothing is wanted of it.
    fn paint_pigment(
        &mut self,
        task: &GlazeTask<'_>,
        is_wanted: bool,
        mut glaze: C97Glaze,
    ) -> Result<(), C97Error> {
        if is_wanted {
            let (done, total) = (self.done, self.total);
            let report = |steps| {
                if let Some(progress) = self.config.progress {
                    progress(done + steps, total);
                }
            };
            let run =
                RunConfig { cancel: self.config.cancel, progress: Some(&report), ..RunConfig::default() };
            let painted = paint_glaze(task, &run).map_err(|error| match error {
                PlanError::State(source) => {
                    C97Error::State { matte: glaze.matte.clone(), pigment: glaze.pigment.clone(), source }
                }
                PlanError::Run(RunError::Cancelled { .. }) => C97Error::Cancelled,
                PlanError::Run(source) => {
                    C97Error::Run { matte: glaze.matte.clone(), pigment: glaze.pigment.clone(), source }
                }
            })?;
            let shared = task.lifts.iter().map(|(map, _)| map).chain([task.matte]).cloned();
            self.painting.maps.0.extend(painted.maps.into_iter().chain(shared));
            self.painting.document.glazes.push(Glaze {
                name: format!("{}, {}", glaze.matte, glaze.pigment),
                pigments: vec![glaze.pigment.clone()],
                model: task.model,
                granulation: 1.0,
                outline: None,
                events: painted.events,
            });
            (glaze.looks, glaze.left) = (painted.looks, painted.left);
        }
        self.done += task.planning.steps();
        self.painting.glazes.push(glaze);
        Ok(())
    }
}

#[cfg(test)]
mod tests;
