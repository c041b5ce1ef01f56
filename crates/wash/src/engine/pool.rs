//! One pool of water: a state, and the passes of row stages over its runs of wet cells, in bands of rows.

use girtin_grid::Field;
use rayon::prelude::*;

use super::Task;
use super::pipeline::{depth, descend};
use super::rows::{Halo, Rows, share};
use super::scratch::Scratch;
use super::stage::Stage;
use super::world::{Changes, Found, World};
use crate::flow_outward::Outflow;
use crate::region::Region;
use crate::state::WashState;

/// Cells below which a second band costs more than it saves.
const CELLS_WORTH_A_BAND: usize = 16384;
/// Bands for each thread: more even out a load that rows share unevenly.
const BANDS_PER_THREAD: usize = 2;

/// A pool: a state, and what is kept of it from step to step.
#[derive(Debug)]
pub struct Pool {
    state: WashState,
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
    /// No slope term of a wet face is larger.
    steepest: f32,
    /// Whether stages visit the whole canvas whatever is wet.
    is_plain: bool,
}

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
}

/// Where water is or, with the capillary layer on, may come: pore water reaches only cells that have some.
pub fn reach(state: &WashState, task: &Task) -> Region {
    if task.pores.is_none() {
        return Region::of(&state.wet_mask, |wet| wet != 0);
    }
    let mut damp = Field::<u8>::zeroed(state.layout());
    for row in state.layout().rows() {
        let (wet, pores) = (state.wet_mask.row(row), state.saturation.row(row));
        if wet.iter().all(|&wet| wet == 0) && pores.iter().all(|&s| s == 0.0) {
            continue;
        }
        for ((damp, &wet), &s) in damp.row_mut(row).iter_mut().zip(wet).zip(pores) {
            *damp = u8::from(wet != 0 || s != 0.0);
        }
    }
    Region::of(&damp, |damp| damp != 0)
}

impl Pool {
    /// Finds where in the pool the water is.
    pub fn new(state: WashState, task: &Task, threads: usize) -> Self {
        let damp = if task.pores.is_some() { reach(&state, task) } else { Region::empty() };
        let wet = Region::of(&state.wet_mask, |wet| wet != 0);
        Self::over(state, task, threads, [wet, damp], false)
    }

    /// A pool whose stages visit the whole canvas, wet or dry, in one band.
    pub fn plain(state: WashState, task: &Task) -> Self {
        let canvas = Region::whole(state.layout());
        Self::over(state, task, 1, [canvas.clone(), canvas], true)
    }

    fn over(state: WashState, task: &Task, threads: usize, [wet, damp]: [Region; 2], is_plain: bool) -> Self {
        let layout = state.layout();
        let bands = if threads == 1 { 1 } else { threads * BANDS_PER_THREAD };
        let mut outflow = Outflow::new(layout, task.edge_darkening, task.edge_kernel);
        outflow.renew(&state.wet_mask, layout.rows(), layout.columns(), bands);
        let (wet_cuts, damp_cuts, scratch) = (Vec::new(), Vec::new(), Vec::new());
        let halos = Halos::default();
        let mut pool = Self {
            state,
            outflow,
            bands,
            wet,
            wet_cuts,
            damp,
            damp_cuts,
            scratch,
            halos,
            steepest: 0.0,
            is_plain,
        };
        for row in pool.wet.active() {
            pool.note_slope(task, row);
        }
        pool.cut(task);
        pool
    }

    /// The state.
    pub fn state(&mut self) -> &mut WashState {
        &mut self.state
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
        let stride = self.state.layout().stride();
        while self.scratch.len() < needed {
            self.scratch.push(Scratch::new(stride, task.exchanges.len()));
        }
    }

    /// Raises the bound on the slope term to that of the row's faces.
    fn note_slope(&mut self, task: &Task, row: usize) {
        let (above, here) = (self.state.height.row(row - 1), self.state.height.row(row));
        for run in self.wet.runs(row) {
            for x in run.first..run.end {
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
        let (state, halos) = (&mut self.state, &mut self.halos);
        let mut mask = share(&mut state.wet_mask, cuts, &mut halos.mask, halo(Changes::MASK)).into_iter();
        let mut u = share(&mut state.u, cuts, &mut halos.u, halo(Changes::FLOW)).into_iter();
        let mut v = share(&mut state.v, cuts, &mut halos.v, halo(Changes::FLOW)).into_iter();
        let mut pressure =
            share(&mut state.pressure, cuts, &mut halos.pressure, halo(Changes::PRESSURE)).into_iter();
        let mut saturation =
            share(&mut state.saturation, cuts, &mut halos.saturation, halo(Changes::SATURATION)).into_iter();
        let mut suspended =
            share_all(&mut state.suspended, cuts, &mut halos.suspended, halo(Changes::SUSPENDED));
        let mut deposited =
            share_all(&mut state.deposited, cuts, &mut halos.deposited, halo(Changes::DEPOSITED));
        let bands = cuts.windows(2).zip(&mut self.scratch);
        let worlds = bands.filter_map(|(cut, scratch)| {
            Some(World {
                task,
                own: cut[0]..cut[1],
                active: region.active(),
                wet: &self.wet,
                damp: &self.damp,
                outflow: &self.outflow,
                height: &state.height,
                mask: mask.next()?,
                u: u.next()?,
                v: v.next()?,
                pressure: pressure.next()?,
                saturation: saturation.next()?,
                suspended: suspended.iter_mut().filter_map(Iterator::next).collect(),
                deposited: deposited.iter_mut().filter_map(Iterator::next).collect(),
                scratch,
                found: Found::default(),
            })
        });
        let worlds: Vec<World<'_>> = worlds.collect();
        let work = |mut world: World<'_>| {
            world.scratch.begin();
            descend(stages, &mut world);
            world.found
        };
        if worlds.len() == 1 {
            worlds.into_iter().map(work).fold(Found::default(), Found::with)
        } else {
            worlds.into_par_iter().map(work).reduce(Found::default, Found::with)
        }
    }

    /// Looks again at what became wet.
    pub fn grow(&mut self, task: &Task, grown: &[(usize, usize, usize)]) {
        let Some(&(mut first_row, mut first, mut end)) = grown.first() else { return };
        let mut last_row = first_row;
        for &(row, from, to) in grown {
            (first_row, last_row) = (first_row.min(row), last_row.max(row));
            (first, end) = (first.min(from), end.max(to));
            // The row below asks whether this one is wet throughout.
            for row in row..=(row + 1).min(self.state.layout().rows().end - 1) {
                if !self.is_plain {
                    self.wet.rescan(&self.state.wet_mask, row, |wet| wet != 0);
                }
                self.note_slope(task, row);
            }
        }
        self.cut(task);
        self.outflow.renew(
            &self.state.wet_mask,
            first_row..last_row + 1,
            first..end,
            self.wet_cuts.len() - 1,
        );
    }
}

/// [`share`] for a field of every pigment.
fn share_all<'a>(
    fields: &'a mut [Field<f32>],
    cuts: &[usize],
    halos: &'a mut Vec<Vec<Halo<f32>>>,
    depth: Option<usize>,
) -> Vec<std::vec::IntoIter<Rows<'a, f32>>> {
    halos.resize_with(fields.len(), Vec::new);
    let pairs = fields.iter_mut().zip(halos);
    pairs.map(|(field, halos)| share(field, cuts, halos, depth).into_iter()).collect()
}
