//! One glaze is painted step by step and corrected on the way, by brushstrokes of pigment and of clear water.

use girtin_grid::Raster;
use girtin_painting::StoredMap;
use girtin_painting::area::{Area, Canvas, Shape};
use girtin_painting::document::{Event, MapName};
use girtin_params::{Place, parameters};
use girtin_wash::{
    Ledger, Patch, PigmentHandling, RunConfig, RunError, StateError, Wash, WashModel, WashState,
};

use super::low_pass::low_pass;

parameters! {
    /// The parameters of brushstroke planning.
    pub struct PlanningParams {
        interval: u32 {
            symbol: "", label: "Interval", unit: "steps", default: 50, hard: (1.0, 10000.0), soft: (30.0, 100.0),
            acts: Simulation, doc: "How long the wash runs before it is looked at and corrected, and again after the last correction.", source: "C97 §6.2, 30 to 100",
        }
        repeats: u32 {
            symbol: "", label: "Corrections", unit: "1", default: 4, hard: (0.0, 100.0), soft: (2.0, 5.0),
            acts: Simulation, doc: "How often the wash is corrected. Four of them at every 50 steps are 250 steps a glaze, as many as in the paper's figure 10.", source: "C97 §6.2, 2 to 5",
        }
        delta_g: f64 {
            symbol: "δ_g", label: "Pigment step", unit: "pigment", default: 0.05, hard: (0.0001, 10.0), soft: (0.01, 0.2),
            acts: Simulation, doc: "How much pigment a brushstroke adds. Nothing is done where less than that is lacking or too much.", source: "C97 §6.2, 0.01 to 0.2",
        }
        phi_g: f64 {
            symbol: "φ_g", label: "Water with pigment", unit: "pressure", default: -0.05, hard: (-10.0, 10.0), soft: (-0.2, 0.2),
            acts: Simulation, doc: "How much water comes with a brushstroke of pigment. Below 0 it draws water and pigment there. Left out of a file it is −δ_g.", source: "C97 §6.2, −δ_g",
        }
        phi_p: f64 {
            symbol: "φ_p", label: "Thinning water", unit: "pressure", default: 1.0, hard: (0.0, 10.0), soft: (0.0, 2.0),
            acts: Simulation, doc: "How much clear water a brushstroke adds where there is too much pigment.", source: "C97 §6.2",
        }
        low_pass_mm: f64 {
            symbol: "σ", label: "Low-pass", unit: "mm", default: 1.0, hard: (0.0, 100.0), soft: (0.25, 5.0),
            acts: Simulation, doc: "Detail finer than this is not painted for. It is the standard deviation of a Gaussian.", source: "C97 §6.2; value custom",
        }
        first_water: f64 {
            symbol: "", label: "First water", unit: "pressure", default: 0.5, hard: (0.0, 10.0), soft: (0.1, 1.5),
            acts: Simulation, doc: "How much water the matte is wetted with before anything else.", source: "custom",
        }
        first_share: f64 {
            symbol: "", label: "First wash", unit: "1", default: 1.0, hard: (0.0, 1.0), soft: (0.0, 1.0),
            acts: Simulation, doc: "How much of the wanted pigment the first wash lays, without fine detail. At 0 the glaze begins as clear water and is built of brushstrokes alone.", source: "custom",
        }
    }
}

impl PlanningParams {
    /// Steps of a whole glaze.
    pub fn steps(&self) -> u64 {
        u64::from(self.interval) * (u64::from(self.repeats) + 1)
    }
}

/// A map that events of a glaze name: its file's name and what the file holds.
pub type NamedMap = (String, StoredMap);

/// A glaze to be painted.
#[derive(Clone, Copy, Debug)]
pub struct GlazeTask<'a> {
    /// The cells it is painted on.
    pub canvas: Canvas<'a>,
    /// Where the paper is wetted, stretched over the sheet.
    pub matte: &'a NamedMap,
    /// What is lifted at the end: a map, and the fraction.
    pub lifts: &'a [(NamedMap, f64)],
    /// Wanted pigment in each cell.
    pub target: &'a Raster<f32>,
    /// Where another matte's paint lies beside this one's.
    pub seam: &'a Raster<bool>,
    /// How the pigment behaves.
    pub handling: PigmentHandling,
    /// Physics.
    pub model: WashModel,
    /// The numbers.
    pub planning: PlanningParams,
    /// What the names of its maps begin with.
    pub prefix: &'a str,
}

/// A glaze that has been painted.
#[derive(Clone, Debug)]
pub struct PaintedPlan {
    /// What was done.
    pub events: Vec<Event>,
    /// The maps that only these events name.
    pub maps: Vec<NamedMap>,
    /// Pigment left in each cell.
    pub left: Raster<f32>,
    /// How far it was off at each look: after every interval, the last one before it dries.
    pub looks: Vec<Look>,
}

/// How far a glaze is off its target: means of |glaze − target| over the wet cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// Of single cells, grain and fine detail included.
    pub off: f64,
    /// Of the low-passed difference, which is what is painted for.
    pub off_low_passed: f64,
}

/// Why a glaze cannot be painted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// Its state is not allowed.
    #[error(transparent)]
    State(#[from] StateError),
    /// The water ran away, or the caller cancelled.
    #[error(transparent)]
    Run(#[from] RunError),
}

/// Paints a glaze, looking at it every few steps and correcting what is off, and writes down what it did.
///
/// # Source
/// Curtis et al. 1997, §6.2, brushstroke planning: where the low-passed difference says that pigment lacks by more than δ_g,
/// g += δ_g and p += φ_g; where there is too much by more than δ_g, p += φ_p.
///
/// # Shapes and units
/// `task.target`: the canvas's cells.
///
/// # Guarantees
/// The same for any number of threads, and painting the events again gives the same pigment in every cell, because maps
/// hold what a grey picture stores before they are used (`painting_the_document_again_is_the_same`).
///
/// # Deviations
/// W7: where mattes lie side by side, pigment that piled up along the seam is picked up once it is dry.
/// W4, W5: the paper does not say what a glaze begins with. Here the matte is wetted, and a first wash laid of the low-passed
/// target; `first_share` 0 begins with clear water.
///
/// # Errors
/// A value of model or pigment is not allowed, the water ran away, or the caller cancelled.
pub fn paint_glaze(task: &GlazeTask<'_>, config: &RunConfig<'_>) -> Result<PaintedPlan, PlanError> {
    let params = task.planning;
    let mut brush = Brush::new(task)?;
    let matte = brush.map(task.matte.0.clone(), &task.matte.1);
    brush.wet(&matte);
    brush.water(&matte, params.first_water);
    let wet = brush.wet_cells();
    let sigma = params.low_pass_mm * task.canvas.cells_per_mm;
    if params.first_share > 0.0 {
        let wanted = low_pass(task.target, &wet, sigma).map(|amount| amount * params.first_share as f32);
        brush.first_wash(&wanted);
    }
    let mut looks = Vec::new();
    let mut done = 0;
    for look in 0..=params.repeats {
        brush.run(params.interval, done, config)?;
        done += u64::from(params.interval);
        let difference = brush.difference(task.target);
        let low_passed = low_pass(&difference, &wet, sigma);
        looks.push(Look { off: mean_size(&difference, &wet), off_low_passed: mean_size(&low_passed, &wet) });
        if look < params.repeats {
            brush.correct(&low_passed, &params, look + 1);
        }
    }
    brush.dry();
    brush.pick_up_bead(&low_pass(task.target, &wet, sigma));
    for ((name, map), fraction) in task.lifts {
        let highlight = brush.map(name.clone(), map);
        brush.lift(&highlight, *fraction);
    }
    Ok(PaintedPlan { left: brush.pigment(), events: brush.events, maps: brush.maps, looks })
}

/// Times as much pigment as is wanted that may stay along a seam.
const RIM: f32 = 1.2;

/// Mean size of the values where the mask is 1; 0 of none.
fn mean_size(values: &Raster<f32>, mask: &Raster<f32>) -> f64 {
    let cells = values.as_slice().iter().zip(mask.as_slice()).filter(|(_, mask)| **mask > 0.0);
    let (sum, count) =
        cells.fold((0.0, 0u64), |(sum, count), (value, _)| (sum + f64::from(value.abs()), count + 1));
    sum / count.max(1) as f64
}

/// An area that is a map, and what it covers on the canvas.
struct MapArea {
    area: Area,
    covered: Raster<f32>,
}

/// A wash, and the log of what is done to it. Every deed is done as the document's painting does it.
struct Brush<'a> {
    task: &'a GlazeTask<'a>,
    wash: Wash,
    events: Vec<Event>,
    maps: Vec<NamedMap>,
}

impl<'a> Brush<'a> {
    fn new(task: &'a GlazeTask<'a>) -> Result<Self, StateError> {
        let mut state = WashState::dry(task.canvas.height, 1);
        if matches!(task.model, WashModel::Living(_)) {
            state.ledger = Some(Ledger::new(task.canvas.cells_per_mm));
        }
        let wash = Wash::new(state, task.model, vec![task.handling])?;
        Ok(Self { task, wash, events: Vec::new(), maps: Vec::new() })
    }

    /// The area of a map.
    fn map(&self, file: String, map: &StoredMap) -> MapArea {
        let name = MapName { file, place: Place::default() };
        let area = Area { shape: Shape::Map(name), ..Area::default() };
        let covered = area.cover(&self.task.canvas, Some(&map.amounts())).amount;
        MapArea { area, covered }
    }

    /// The area of a map of this glaze alone, which is kept.
    fn own_map(&mut self, what: &str, map: StoredMap) -> MapArea {
        let file = format!("{}-{what}.png", self.task.prefix);
        let area = self.map(file.clone(), &map);
        self.maps.push((file, map));
        area
    }

    fn wet(&mut self, at: &MapArea) {
        let mask = at.covered.map(|covered| f32::from(u8::from(covered >= 0.5)));
        self.wash.wet(Patch::whole(&mask));
        self.events.push(Event::Wet { area: at.area.clone() });
    }

    fn water(&mut self, at: &MapArea, amount: f64) {
        if amount != 0.0 {
            self.wash.add_water(Patch::whole(&at.covered.map(|covered| covered * amount as f32)));
            self.events.push(Event::Water { area: at.area.clone(), amount });
        }
    }

    fn lay_pigment(&mut self, at: &MapArea, amount: f64) {
        self.wash.add_pigment(0, Patch::whole(&at.covered.map(|covered| covered * amount as f32)));
        self.events.push(Event::Pigment { area: at.area.clone(), amounts: vec![amount] });
    }

    fn lift(&mut self, at: &MapArea, fraction: f64) {
        self.wash.lift(Patch::whole(&at.covered.map(|covered| covered * fraction as f32)));
        self.events.push(Event::Lift { area: at.area.clone(), fraction });
    }

    fn run(&mut self, steps: u32, before: u64, config: &RunConfig<'_>) -> Result<(), RunError> {
        let report = |step| {
            if let Some(progress) = config.progress {
                progress(before + step);
            }
        };
        self.wash.run(u64::from(steps), &RunConfig { progress: Some(&report), ..*config })?;
        self.events.push(Event::Run { steps, until_dry: false, feed: None });
        Ok(())
    }

    fn dry(&mut self) {
        self.wash.dry();
        self.events.push(Event::Dry { area: None, damp: [0.0, 0.0] });
    }

    /// 1 where the paper is wet.
    fn wet_cells(&self) -> Raster<f32> {
        let mask = &self.wash.state().wet_mask;
        let height = self.task.canvas.height;
        Raster::from_fn(height.width(), height.height(), |x, y| f32::from(mask.cells(y)[x]))
    }

    /// Pigment in the water and on the paper.
    fn pigment(&self) -> Raster<f32> {
        let state = self.wash.state();
        let height = self.task.canvas.height;
        Raster::from_fn(height.width(), height.height(), |x, y| {
            state.suspended[0].cells(y)[x] + state.deposited[0].cells(y)[x]
        })
    }

    /// How much more pigment there is than wanted.
    fn difference(&self, target: &Raster<f32>) -> Raster<f32> {
        let mut difference = self.pigment();
        difference
            .as_mut_slice()
            .iter_mut()
            .zip(target.as_slice())
            .for_each(|(found, wanted)| *found -= wanted);
        difference
    }

    fn first_wash(&mut self, wanted: &Raster<f32>) {
        let most = wanted.as_slice().iter().copied().fold(0.0, f32::max);
        if most > 0.0 {
            // Thousandths, so that the document is readable.
            let amount = (f64::from(most) * 1000.0).ceil() / 1000.0;
            let part = wanted.map(|wanted| (f64::from(wanted) / amount) as f32);
            let at = self.own_map("first", StoredMap::words(&part));
            self.lay_pigment(&at, amount);
        }
    }

    /// Picks up what the seam has of pigment beyond a rim: two beads side by side would be a dark line that is in no picture.
    fn pick_up_bead(&mut self, wanted: &Raster<f32>) {
        let mut part = self.pigment();
        let cells = part.as_mut_slice().iter_mut().zip(wanted.as_slice()).zip(self.task.seam.as_slice());
        for ((part, wanted), is_seam) in cells {
            let most = RIM * wanted;
            *part = if *is_seam && *part > most { 1.0 - most / *part } else { 0.0 };
        }
        if part.as_slice().iter().any(|part| *part > 0.0) {
            let at = self.own_map("bead", StoredMap::words(&part));
            self.lift(&at, 1.0);
        }
    }

    /// Adds pigment where the low-passed difference says that it lacks, and water where there is too much.
    fn correct(&mut self, difference: &Raster<f32>, params: &PlanningParams, look: u32) {
        let limit = params.delta_g as f32;
        let lacking = difference.map(|more| if more < -limit { u8::MAX } else { 0 });
        if lacking.as_slice().contains(&u8::MAX) {
            let at = self.own_map(&format!("lacking-{look}"), StoredMap::Bytes(lacking));
            self.lay_pigment(&at, params.delta_g);
            self.water(&at, params.phi_g);
        }
        let excess = difference.map(|more| if more > limit { u8::MAX } else { 0 });
        if params.phi_p > 0.0 && excess.as_slice().contains(&u8::MAX) {
            let at = self.own_map(&format!("excess-{look}"), StoredMap::Bytes(excess));
            self.water(&at, params.phi_p);
        }
    }
}
