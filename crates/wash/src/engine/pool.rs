//! One pool of water: a state, and the passes of row stages over its runs of wet cells, in bands of rows.

mod contact;
mod fine;

use std::ops::Range;

use girtin_grid::{Field, Layout};
use multiversion::multiversion;
use rayon::prelude::*;

use super::Task;
use super::crew::Crew;
use super::facts::RowFacts;
use super::ground::Ground;
use super::pipeline::{depth, descend};
use super::rows::{Halo, Rows, share};
use super::scratch::Scratch;
use super::stage::Stage;
use super::stages::refine::CoarseWater;
use super::world::{Changes, Found, LivingRows, Place, World};
use crate::flow_outward::{Edge, Outflow};
use crate::region::{Region, Run};
use crate::state::WashState;

/// Cells below which a second band costs more than it saves.
const CELLS_WORTH_A_BAND: usize = 16384;
/// Bands for each thread: more even out a load that rows share unevenly.
const BANDS_PER_THREAD: usize = 1;

/// A pool: a state, and what is kept of it from step to step.
#[derive(Debug)]
pub struct Pool {
    state: WashState,
    /// How rows lie in the state's fields.
    ground: Ground,
    outflow: Outflow,
    /// Bands at most.
    bands: usize,
    wet: Region,
    wet_cuts: Vec<usize>,
    /// Where there is pore water or will be; empty when the capillary layer is off.
    damp: Region,
    damp_cuts: Vec<usize>,
    scratch: Vec<Scratch>,
    halos: Halos,
    crew: Crew,
    /// What only the living wash needs.
    living: Option<LivingFields>,
    /// The water of pigment that is finer.
    water: Option<CoarseWater>,
    /// No slope term of a wet face is larger.
    steepest: f32,
    /// Whether stages visit the whole canvas whatever is wet.
    is_reference: bool,
    /// Cells of the pool's own canvas that have become wet.
    joined: Vec<(usize, usize)>,
}

/// What the living wash keeps of each cell and face.
#[derive(Debug)]
struct LivingFields {
    mobility_u: Field<f32>,
    mobility_v: Field<f32>,
    /// What faces keep in a sub-step; made for the first step of several.
    keep: Option<[Field<f32>; 2]>,
    cover: Field<f32>,
    /// What the slope term sees, if not the height itself.
    slope_height: Option<Field<f32>>,
    facts: RowFacts,
    /// [`DAMP`] where there is water, [`EVER_DAMP`] where there was any since the pool was made.
    damp: Field<u8>,
    /// Rows whose cells became wet or dry since the regions were last looked at.
    changed_rows: Vec<usize>,
    /// Field rows and columns in which water may come and go.
    within: (Range<usize>, Range<usize>),
    /// Whether water has left them.
    needs_room: bool,
    steps: u32,
}

/// Film or pore water is there.
const DAMP: u8 = 1;
/// It was there once.
const EVER_DAMP: u8 = 2;
/// Steps after which dry paper is looked for again.
const STEPS_TO_SHRINK: u32 = 32;

/// Copies of rows beside each band, for every field that a pass may change.
#[derive(Debug, Default)]
struct Halos {
    mask: Vec<Halo<u8>>,
    u: Vec<Halo<f32>>,
    v: Vec<Halo<f32>>,
    pressure: Vec<Halo<f32>>,
    saturation: Vec<Halo<f32>>,
    suspended: Vec<Vec<Halo<f32>>>,
    deposited: Vec<Vec<Halo<f32>>>,
    mobility: [Vec<Halo<f32>>; 2],
    keep: [Vec<Halo<f32>>; 2],
    cover: Vec<Halo<f32>>,
}

/// Where water is or, with the capillary layer on, may come: pore water reaches only cells that have some.
pub fn reach(state: &WashState, task: &Task) -> Region {
    if task.pores.is_none() {
        return Region::of(&state.wet_mask, |wet| wet != 0);
    }
    region_of_damp(&damp_cells(state))
}

fn region_of_damp(damp: &Field<u8>) -> Region {
    Region::of(damp, |damp| damp & DAMP != 0)
}

/// [`DAMP`] and [`EVER_DAMP`] where there is film or pore water.
fn damp_cells(state: &WashState) -> Field<u8> {
    let mut damp = Field::<u8>::zeroed(state.layout());
    for row in state.layout().rows() {
        let (wet, pores) = (state.wet_mask.row(row), state.saturation.row(row));
        // Pages of dry paper stay untouched.
        if wet.iter().all(|&wet| wet == 0) && pores.iter().all(|&s| s == 0.0) {
            continue;
        }
        put_damp(damp.row_mut(row), wet, pores);
    }
    damp
}

#[multiversion(targets("x86_64+avx512bw+avx512dq+avx512vl", "x86_64+avx2"))]
fn put_damp(damp: &mut [u8], wet: &[u8], pores: &[f32]) {
    let n = damp.len();
    let (wet, pores) = (&wet[..n], &pores[..n]);
    for i in 0..n {
        damp[i] = if (wet[i] != 0) | (pores[i] != 0.0) { DAMP | EVER_DAMP } else { 0 };
    }
}

impl Pool {
    /// Finds where in the pool the water is; `slope_height` is what the slope term sees, if not the height.
    pub fn new(state: WashState, slope_height: Option<Field<f32>>, task: &Task, threads: usize) -> Self {
        // Pigment over coarser water has no pores, but is living all the same.
        let cells = (task.pores.is_some() || task.living.is_some()).then(|| damp_cells(&state));
        let damp = cells.as_ref().filter(|_| task.pores.is_some()).map_or_else(Region::empty, region_of_damp);
        let wet = Region::of(&state.wet_mask, |wet| wet != 0);
        let outflow = outflow_of(&state, task, threads);
        let ground = Ground::canvas(state.layout());
        let living = task.living.is_some().then_some(cells).flatten();
        let living = living.map(|damp| LivingFields::new(damp, slope_height));
        Self::over(state, ground, outflow, living, task, threads, [wet, damp])
    }

    /// All water of a canvas without dry paper between it; its edge must stay as it is.
    pub fn packed(canvas: &WashState, task: &Task, threads: usize) -> Self {
        let wet = Region::of(&canvas.wet_mask, |wet| wet != 0).tightened(&canvas.wet_mask, |wet| wet != 0);
        let ground = Ground::packed(&wet, canvas.layout());
        let mut state = WashState::empty(ground.layout(), canvas.suspended.len());
        ground.gather(&canvas.height, &mut state.height);
        ground.gather(&canvas.wet_mask, &mut state.wet_mask);
        let outflow = outflow_of(canvas, task, threads).packed(&ground);
        let mut pool = Self::over(state, ground, outflow, None, task, threads, [wet, Region::empty()]);
        pool.gather(canvas);
        pool
    }

    /// Takes the water of the canvas.
    pub fn gather(&mut self, canvas: &WashState) {
        let (ground, state) = (&self.ground, &mut self.state);
        let fields: Vec<_> = water(canvas).zip(water_mut(state)).collect();
        let gather = |(canvas, packed): (&Field<f32>, &mut Field<f32>)| ground.gather(canvas, packed);
        if self.bands == 1 {
            fields.into_iter().for_each(gather);
        } else {
            fields.into_par_iter().for_each(gather);
        }
    }

    /// Gives it back.
    pub fn scatter(&self, canvas: &mut WashState) {
        let fields: Vec<_> = water_mut(canvas).zip(water(&self.state)).collect();
        let scatter = |(canvas, packed): (&mut Field<f32>, &Field<f32>)| self.ground.scatter(packed, canvas);
        if self.bands == 1 {
            fields.into_iter().for_each(scatter);
        } else {
            fields.into_par_iter().for_each(scatter);
        }
    }

    /// A pool whose stages visit the whole canvas, wet or dry, in one band.
    pub fn reference(state: WashState, slope_height: Option<Field<f32>>, task: &Task) -> Self {
        let canvas = Region::whole(state.layout());
        let outflow = outflow_of(&state, task, 1);
        let ground = Ground::canvas(state.layout());
        let living = task.living.as_ref().map(|_| LivingFields::new(damp_cells(&state), slope_height));
        let regions = [canvas.clone(), canvas];
        Self { is_reference: true, ..Self::over(state, ground, outflow, living, task, 1, regions) }
    }

    fn over(
        state: WashState,
        ground: Ground,
        outflow: Outflow,
        living: Option<LivingFields>,
        task: &Task,
        threads: usize,
        [wet, damp]: [Region; 2],
    ) -> Self {
        let bands = bands(threads);
        let (wet_cuts, damp_cuts, scratch) = (Vec::new(), Vec::new(), Vec::new());
        let halos = Halos::default();
        let mut pool = Self {
            state,
            ground,
            outflow,
            bands,
            wet,
            wet_cuts,
            damp,
            damp_cuts,
            scratch,
            halos,
            crew: Crew::default(),
            living,
            water: None,
            steepest: 0.0,
            is_reference: false,
            joined: Vec::new(),
        };
        for row in pool.wet.active() {
            pool.note_slope(task, row);
        }
        pool.note_full(pool.damp.active());
        pool.cut(task);
        pool
    }

    /// The state.
    pub fn state(&mut self) -> &mut WashState {
        &mut self.state
    }

    /// The runs of cells with film, and of those with film or pore water: field row, and field columns.
    pub fn runs(&self) -> [impl Iterator<Item = (usize, Run)> + '_; 2] {
        [&self.wet, &self.damp]
            .map(|region| region.active().flat_map(|row| region.runs(row).iter().map(move |&run| (row, run))))
    }

    /// A bound on the slope term of every wet face.
    pub fn steepest(&self) -> f32 {
        self.steepest
    }

    /// Shares the rows among bands.
    fn cut(&mut self, task: &Task) {
        let bands = |region: &Region| (region.cells() / CELLS_WORTH_A_BAND).clamp(1, self.bands);
        self.wet_cuts = self.wet.cuts(bands(&self.wet));
        self.damp_cuts = self.damp.cuts(bands(&self.damp));
        let needed = self.wet_cuts.len().max(self.damp_cuts.len()) - 1;
        while self.scratch.len() < needed {
            self.scratch.push(Scratch::new(self.ground.longest(), task.exchanges.len()));
        }
    }

    /// Raises the bound on the slope term to that of the row's faces; the living wash needs none.
    fn note_slope(&mut self, task: &Task, row: usize) {
        if task.living.is_some() {
            return;
        }
        let height = [row - 1, row].map(|row| self.ground.row(&self.state.height, row));
        for window in self.ground.windows(&self.wet, row) {
            let (above, here) = (window.above(height[0]), window.here(height[1]));
            for x in window.run.first..window.run.end {
                let slope = (here[x] - here[x - 1]).abs().max((here[x] - above[x]).abs());
                self.steepest = self.steepest.max(task.slope_scale * slope);
            }
        }
    }

    /// Runs a pass of stages, each as many rows behind the one before as it must be.
    pub fn pass(&mut self, task: &Task, stages: &[Stage]) -> Found {
        let of_pores = stages.iter().any(|stage| stage.is_of_pores());
        let (region, cuts) =
            if of_pores { (&self.damp, &self.damp_cuts) } else { (&self.wet, &self.wet_cuts) };
        if region.active().is_empty() {
            return Found::default();
        }
        let changes = stages.iter().fold(Changes::NOTHING, |all, stage| all | stage.changes());
        let depth = depth(stages);
        let halo = |what| changes.contain(what).then_some(depth);
        let (state, ground, halos) = (&mut self.state, &self.ground, &mut self.halos);
        let mut mask =
            share(&mut state.wet_mask, ground, cuts, &mut halos.mask, halo(Changes::MASK)).into_iter();
        let mut u = share(&mut state.u, ground, cuts, &mut halos.u, halo(Changes::FLOW)).into_iter();
        let mut v = share(&mut state.v, ground, cuts, &mut halos.v, halo(Changes::FLOW)).into_iter();
        let mut pressure =
            share(&mut state.pressure, ground, cuts, &mut halos.pressure, halo(Changes::PRESSURE))
                .into_iter();
        let mut saturation =
            share(&mut state.saturation, ground, cuts, &mut halos.saturation, halo(Changes::SATURATION))
                .into_iter();
        let mut suspended =
            share_all(&mut state.suspended, ground, cuts, &mut halos.suspended, halo(Changes::SUSPENDED));
        let mut deposited =
            share_all(&mut state.deposited, ground, cuts, &mut halos.deposited, halo(Changes::DEPOSITED));
        let mut slope_height = None;
        let mut living_rows = self.living.as_mut().zip(task.living.as_ref()).map(|(fields, task)| {
            let [mobility_u, mobility_v] = &mut halos.mobility;
            let [keep_u, keep_v] = &mut halos.keep;
            let (mobility, keep) = (halo(Changes::MOBILITY), halo(Changes::KEEP));
            slope_height = fields.slope_height.as_ref();
            let facts = &fields.facts;
            if keep.is_some() {
                let layout = fields.cover.layout();
                fields.keep.get_or_insert_with(|| [(); 2].map(|()| Field::zeroed(layout)));
            }
            let mobility_u = share(&mut fields.mobility_u, ground, cuts, mobility_u, mobility);
            let mobility_v = share(&mut fields.mobility_v, ground, cuts, mobility_v, mobility);
            let mut kept = fields.keep.as_mut().map(|[u, v]| {
                let kept_v = share(v, ground, cuts, keep_v, keep);
                share(u, ground, cuts, keep_u, keep).into_iter().zip(kept_v)
            });
            let cover = share(&mut fields.cover, ground, cuts, &mut halos.cover, halo(Changes::COVER));
            let bands = mobility_u.into_iter().zip(mobility_v).zip(cover);
            bands.map(move |((mobility_u, mobility_v), cover)| LivingRows {
                task,
                mobility_u,
                mobility_v,
                keep: kept.as_mut().and_then(Iterator::next).map(|(u, v)| [u, v]),
                cover,
                facts,
            })
        });
        let bands = cuts.windows(2).zip(&mut self.scratch);
        let worlds = bands.filter_map(|(cut, scratch)| {
            let living = living_rows.as_mut().and_then(|rows| rows.next());
            Some(World {
                task,
                own: cut[0]..cut[1],
                active: region.active(),
                ground,
                wet: &self.wet,
                damp: &self.damp,
                outflow: &self.outflow,
                height: &state.height,
                slope_height: slope_height.unwrap_or(&state.height),
                mask: mask.next()?,
                u: u.next()?,
                v: v.next()?,
                pressure: pressure.next()?,
                saturation: saturation.next()?,
                suspended: suspended.iter_mut().filter_map(Iterator::next).collect(),
                deposited: deposited.iter_mut().filter_map(Iterator::next).collect(),
                living,
                water: self.water.as_ref(),
                scratch,
                found: Found::default(),
            })
        });
        let worlds: Vec<World<'_>> = worlds.collect();
        let iterations = stages.iter().filter(|stage| matches!(stage, Stage::Iterate { .. })).count();
        let widenings = stages.iter().filter(|stage| matches!(stage, Stage::WidenShare(..))).count();
        let work = |mut world: World<'_>| {
            world.scratch.begin();
            world.scratch.make_room(iterations, widenings);
            descend(stages, &mut world);
            world.found
        };
        self.crew.share(worlds, work).into_iter().fold(Found::default(), Found::with)
    }

    /// Takes back the guarded sweep of the last pass, and what followed it.
    pub fn take_back(&mut self) {
        let WashState { u, v, pressure, .. } = &mut self.state;
        let bands = self.wet_cuts.len() - 1;
        for scratch in &self.scratch[..bands] {
            let mut values = &scratch.saved.values[..];
            for place in &scratch.saved.places {
                for field in [&mut *u, v, pressure] {
                    let (row, after) = values.split_at(place.len());
                    field.values_mut()[place.clone()].copy_from_slice(row);
                    values = after;
                }
            }
        }
    }

    /// Looks again at where cells became wet (C97).
    pub fn grow(&mut self, task: &Task, rows: &[usize], place: Option<&Place>) {
        let Some(place) = place else { return };
        for &row in rows {
            self.look_at_row(task, row);
        }
        self.cut(task);
        let edge = Edge { mask: &self.state.wet_mask, cover: None };
        self.outflow.renew(edge, place.rows.clone(), place.columns.clone(), self.wet_cuts.len() - 1);
    }

    /// Finds the runs of wet cells of a row anew.
    fn look_at_row(&mut self, task: &Task, row: usize) {
        // The row below asks whether this one is wet throughout.
        for row in row..=(row + 1).min(self.state.layout().rows().end - 1) {
            if !self.is_reference {
                self.wet.rescan(&self.state.wet_mask, row, |wet| wet != 0);
            }
            self.note_slope(task, row);
        }
    }
}

impl LivingFields {
    fn new(damp: Field<u8>, slope_height: Option<Field<f32>>) -> Self {
        let layout: Layout = damp.layout();
        let field = || Field::<f32>::zeroed(layout);
        Self {
            mobility_u: field(),
            mobility_v: field(),
            keep: None,
            cover: field(),
            slope_height,
            facts: RowFacts::new(layout.rows().end + 2),
            damp,
            changed_rows: Vec::new(),
            within: (layout.rows(), layout.columns()),
            needs_room: false,
            steps: 0,
        }
    }
}

fn bands(threads: usize) -> usize {
    if threads == 1 { 1 } else { threads * BANDS_PER_THREAD }
}

/// What C97 draws off at the edges of a state's water; the living wash finds it anew in each step.
fn outflow_of(state: &WashState, task: &Task, threads: usize) -> Outflow {
    let layout = state.layout();
    let mut outflow = Outflow::new(layout, task.edge_darkening, task.edge_kernel);
    if task.living.is_none() {
        let edge = Edge { mask: &state.wet_mask, cover: None };
        outflow.renew(edge, layout.rows(), layout.columns(), bands(threads));
    }
    outflow
}

/// The fields that a wash without capillary layer changes.
fn water(state: &WashState) -> impl Iterator<Item = &Field<f32>> {
    [&state.u, &state.v, &state.pressure].into_iter().chain(&state.suspended).chain(&state.deposited)
}

/// The same, to change.
fn water_mut(state: &mut WashState) -> impl Iterator<Item = &mut Field<f32>> {
    let WashState { u, v, pressure, suspended, deposited, .. } = state;
    [u, v, pressure].into_iter().chain(suspended).chain(deposited)
}

/// [`share`] for a field of every pigment.
fn share_all<'a>(
    fields: &'a mut [Field<f32>],
    ground: &'a Ground,
    cuts: &[usize],
    halos: &'a mut Vec<Vec<Halo<f32>>>,
    depth: Option<usize>,
) -> Vec<std::vec::IntoIter<Rows<'a, f32>>> {
    halos.resize_with(fields.len(), Vec::new);
    let pairs = fields.iter_mut().zip(halos);
    pairs.map(|(field, halos)| share(field, ground, cuts, halos, depth).into_iter()).collect()
}
