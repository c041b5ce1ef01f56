//! What each routine of a step costs, beside what copying the step's fields costs.
//!
//! `cargo bench -p girtin-wash -- --quick` takes a minute or two; `carry/640x480` behind it picks one. Each routine
//! runs on one thread over a canvas that is wet throughout, where its kernel needs no mask, and over one of ragged
//! blobs, where only the runs of wet cells are visited. Throughput counts the bytes that a routine cannot avoid to
//! read and to write, so that all can be held against `copy`: a routine as fast as that is bound by memory.

use std::hint::black_box;
use std::time::Instant;

use criterion::measurement::WallTime;
use criterion::{
    BenchmarkGroup, BenchmarkId, Criterion, SamplingMode, Throughput, criterion_group, criterion_main,
};
use girtin_grid::random::{hash, stage, unit_f32};
use girtin_grid::{Field, Raster};
use girtin_wash::flow_outward::{Edge, Outflow, draw_off};
use girtin_wash::move_pigment::{SuspendedRows, carry, outflow_speeds};
use girtin_wash::pigment::Exchange;
use girtin_wash::region::{Region, Run};
use girtin_wash::relax_divergence::{AroundRows, FlowRows, WaterRows, divergence, relax};
use girtin_wash::simulate_capillary_flow::{PoreRows, Pores, absorb, diffuse, spread};
use girtin_wash::transfer_pigment::transfer;
use girtin_wash::update_velocities::{
    Momentum, SlopeRows, VelocityRows, add_slope, advance, corner_products,
};
use girtin_wash::{C97Params, Capillary, PigmentHandling, RunConfig, Wash, WashModel, WashState};

const SIZES: [(usize, usize); 2] = [(640, 480), (2048, 2048)];
/// Bytes of a value.
const VALUE: usize = size_of::<f32>();
/// Bytes of a cell in the fields that a step with one pigment visits: u, v, p, g, d, h and the wet mask.
const LIVE: usize = 6 * VALUE + 1;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Cover {
    AllWet,
    Ragged,
}

impl Cover {
    const ALL: [Self; 2] = [Self::AllWet, Self::Ragged];

    fn name(self) -> &'static str {
        match self {
            Self::AllWet => "all wet",
            Self::Ragged => "ragged",
        }
    }

    fn is_wet(self, x: usize, y: usize) -> bool {
        // Coarse cells make blobs that cover about half the canvas, fine ones fray them.
        let blob = random("blob", x / 37, y / 29) + 0.15 * random("fray", x, y);
        self == Self::AllWet || blob < 0.55
    }
}

fn random(name: &'static str, x: usize, y: usize) -> f32 {
    unit_f32(hash(1, stage(name), [x as i64, y as i64], 0))
}

/// A wash and what the engines would keep of it.
struct Scene {
    name: String,
    cover: Cover,
    state: WashState,
    region: Region,
    /// Cells that are visited.
    cells: usize,
}

impl Scene {
    fn new((width, height): (usize, usize), cover: Cover) -> Self {
        let paper = Raster::from_fn(width, height, |x, y| 0.3 + 0.4 * random("paper", x, y));
        let mut state = WashState::dry(&paper, 1);
        for y in 0..height {
            for x in (0..width).filter(|&x| cover.is_wet(x, y)) {
                state.wet_mask.cells_mut(y)[x] = 1;
                state.pressure.cells_mut(y)[x] = 0.4 + 0.1 * random("pressure", x, y);
                state.saturation.cells_mut(y)[x] = 0.2 + 0.3 * random("pores", x, y);
                state.suspended[0].cells_mut(y)[x] = 0.3 + 0.3 * random("pigment", x, y);
                // Slow water, so that a step is one sub-step and every step costs the same.
                state.u.cells_mut(y)[x] = 0.1 * (x as f32 * 0.13).sin() * (y as f32 * 0.17).cos();
                state.v.cells_mut(y)[x] = 0.1 * (y as f32 * 0.13).sin() * (x as f32 * 0.17).cos();
            }
        }
        let region = Region::of(&state.wet_mask, |wet| wet != 0);
        let cells = region.cells();
        Self { name: format!("{width}x{height}/{}", cover.name()), cover, state, region, cells }
    }

    /// Calls `work` with each row and run.
    fn walk(&self, mut work: impl FnMut(usize, Run)) {
        for row in self.region.active() {
            for &run in self.region.runs(row) {
                work(row, run);
            }
        }
    }

    /// Bytes of a routine that reads and writes so many values a cell; only ragged runs need the mask.
    fn bytes(&self, values: usize) -> usize {
        self.cells * (values * VALUE + usize::from(self.cover == Cover::Ragged))
    }

    fn flow(&self, row: usize) -> FlowRows<'_> {
        let WashState { wet_mask, u, v, .. } = &self.state;
        FlowRows { u: u.row(row), v: v.row(row), v_below: v.row(row + 1), mask: wet_mask.row(row) }
    }
}

/// A group of both sizes and covers of one routine.
fn each_scene(c: &mut Criterion, routine: &str, mut bench: impl FnMut(&mut Bencher<'_, '_>, Scene)) {
    let mut group = c.benchmark_group(routine);
    // Few samples of many iterations: a step of the large canvas takes a quarter of a second.
    group.sampling_mode(SamplingMode::Flat).sample_size(10);
    for size in SIZES {
        for cover in Cover::ALL {
            bench(&mut Bencher { group: &mut group }, Scene::new(size, cover));
        }
    }
    group.finish();
}

/// A criterion group that is told bytes and work at once.
struct Bencher<'a, 'b> {
    group: &'a mut BenchmarkGroup<'b, WallTime>,
}

impl Bencher<'_, '_> {
    fn run(&mut self, name: &str, bytes: usize, mut work: impl FnMut()) {
        self.group.throughput(Throughput::Bytes(bytes as u64));
        self.group.bench_function(BenchmarkId::from_parameter(name), |b| b.iter(&mut work));
    }
}

/// The floor: every live field read and written once.
fn copy(c: &mut Criterion) {
    let mut group = c.benchmark_group("copy");
    group.sampling_mode(SamplingMode::Flat).sample_size(10);
    for (width, height) in SIZES {
        let cells = width * height;
        let (from, mut to) = (vec![1u8; cells * LIVE], vec![0u8; cells * LIVE]);
        Bencher { group: &mut group }.run(&format!("{width}x{height}"), 2 * cells * LIVE, || {
            to.copy_from_slice(black_box(&from));
            black_box(&mut to);
        });
    }
    group.finish();
}

fn update_velocities(c: &mut Criterion) {
    each_scene(c, "add_slope", |bencher, scene| {
        let WashState { wet_mask, height, .. } = &scene.state;
        let (mut u, mut v) = (scene.state.u.clone(), scene.state.v.clone());
        let mut scale = 0.15;
        // u, v, h in; u, v out.
        bencher.run(&scene.name, scene.bytes(5), || {
            scene.walk(|row, run| {
                let paper = SlopeRows {
                    height_above: height.row(row - 1),
                    height: height.row(row),
                    mask_above: wet_mask.row(row - 1),
                    mask: wet_mask.row(row),
                };
                black_box(add_slope(u.row_mut(row), v.row_mut(row), &paper, scale, run));
            });
            scale = -scale; // up and down, so that velocities stay in bounds
        });
    });
    each_scene(c, "corner_products and advance", |bencher, scene| {
        let WashState { wet_mask, u, v, pressure, .. } = &scene.state;
        let (mut u_new, mut v_new) = (u.clone(), v.clone());
        let stride = u.layout().stride();
        let (mut corner, mut corner_below) = (vec![0.0; stride], vec![0.0; stride]);
        let momentum = Momentum { dt: 1.0, viscosity: 0.1, viscous_drag: 0.01 };
        // u, v, p in; u, v out; a row of corners stays in the cache.
        bencher.run(&scene.name, scene.bytes(5), || {
            scene.walk(|row, run| {
                corner_products(&mut corner, u.row(row - 1), u.row(row), v.row(row), run);
                corner_products(&mut corner_below, u.row(row), u.row(row + 1), v.row(row + 1), run);
                let old = VelocityRows {
                    u_above: u.row(row - 1),
                    u: u.row(row),
                    u_below: u.row(row + 1),
                    v_above: v.row(row - 1),
                    v: v.row(row),
                    v_below: v.row(row + 1),
                    corner: &corner,
                    corner_below: &corner_below,
                    pressure_above: pressure.row(row - 1),
                    pressure: pressure.row(row),
                    mask_above: wet_mask.row(row - 1),
                    mask: wet_mask.row(row),
                };
                advance(u_new.row_mut(row), v_new.row_mut(row), &old, momentum, run);
            });
        });
    });
}

fn relax_divergence(c: &mut Criterion) {
    each_scene(c, "divergence", |bencher, scene| {
        let mut delta = Field::<f32>::zeroed(scene.state.layout());
        // u, v in; δ out.
        bencher.run(&scene.name, scene.bytes(3), || {
            scene.walk(|row, run| {
                black_box(divergence(delta.row_mut(row), &scene.flow(row), 0.1, run));
            });
        });
    });
    each_scene(c, "relax", |bencher, scene| {
        let (mut u, mut v, mut p) =
            (scene.state.u.clone(), scene.state.v.clone(), scene.state.pressure.clone());
        let layout = scene.state.layout();
        let (above, mut delta) = (Field::<f32>::zeroed(layout), Field::<f32>::zeroed(layout));
        let wet_mask = &scene.state.wet_mask;
        // u, v, p in; u, v, p, δ out. Little is corrected, or pressure would leave its usual range.
        bencher.run(&scene.name, scene.bytes(7), || {
            scene.walk(|row, run| {
                let around = AroundRows {
                    v_below: scene.state.v.row(row + 1),
                    delta_above: above.row(row - 1),
                    mask_above: wet_mask.row(row - 1),
                    mask: wet_mask.row(row),
                };
                let (u, v, pressure) = (u.row_mut(row), v.row_mut(row), p.row_mut(row));
                black_box(relax(WaterRows { u, v, pressure }, delta.row_mut(row), &around, 1e-5, run));
            });
        });
    });
}

fn flow_outward(c: &mut Criterion) {
    each_scene(c, "draw_off", |bencher, scene| {
        let layout = scene.state.layout();
        let mut outflow = Outflow::new(layout, 0.02, 10.0);
        outflow.renew(Edge { mask: &scene.state.wet_mask, cover: None }, layout.rows(), layout.columns(), 1);
        let mut pressure = scene.state.pressure.clone();
        // Only near edges is anything drawn off. p and the amount in; p out.
        let cells: usize = layout.rows().flat_map(|row| outflow.spans(row)).map(|span| span.len()).sum();
        bencher.run(&scene.name, cells * 3 * VALUE, || {
            for row in layout.rows() {
                for span in outflow.spans(row) {
                    draw_off(&mut pressure.row_mut(row)[span.clone()], &outflow.row(row)[span.clone()]);
                }
            }
        });
    });
}

fn move_pigment(c: &mut Criterion) {
    each_scene(c, "outflow_speeds", |bencher, scene| {
        // u, v in; no mask in either case.
        bencher.run(&scene.name, scene.cells * 2 * VALUE, || {
            let mut fastest = 0;
            scene.walk(|row, run| fastest = fastest.max(outflow_speeds(&scene.flow(row), run)));
            black_box(fastest);
        });
    });
    each_scene(c, "carry", |bencher, scene| {
        let old = &scene.state.suspended[0];
        let mut suspended = old.clone();
        // u, v, g in; g out.
        bencher.run(&scene.name, scene.bytes(4), || {
            scene.walk(|row, run| {
                let rows =
                    SuspendedRows { above: old.row(row - 1), here: old.row(row), below: old.row(row + 1) };
                carry(suspended.row_mut(row), &rows, &scene.flow(row), 1.0, run);
            });
        });
    });
}

fn transfer_pigment(c: &mut Criterion) {
    each_scene(c, "transfer", |bencher, scene| {
        let (mut g, mut d) = (scene.state.suspended[0].clone(), scene.state.deposited[0].clone());
        let WashState { wet_mask, height, .. } = &scene.state;
        let exchange = Exchange { settling: 0.01, lifting: 0.01 / 3.1, granulation: 0.91 };
        // g, d, h in; g, d out.
        bencher.run(&scene.name, scene.bytes(5), || {
            scene.walk(|row, run| {
                transfer(g.row_mut(row), d.row_mut(row), height.row(row), wet_mask.row(row), exchange, run);
            });
        });
    });
}

fn simulate_capillary_flow(c: &mut Criterion) {
    let pores = Pores::from(&Capillary::default());
    each_scene(c, "absorb", |bencher, scene| {
        let WashState { wet_mask, height, .. } = &scene.state;
        let mut saturation = scene.state.saturation.clone();
        // s, h and the mask in; s out.
        bencher.run(&scene.name, scene.cells * (3 * VALUE + 1), || {
            scene.walk(|row, run| {
                absorb(saturation.row_mut(row), height.row(row), wet_mask.row(row), &pores, run);
            });
        });
    });
    each_scene(c, "diffuse", |bencher, scene| {
        let WashState { height, saturation: old, .. } = &scene.state;
        let mut saturation = old.clone();
        // s, h in; s out.
        bencher.run(&scene.name, scene.cells * 3 * VALUE, || {
            scene.walk(|row, run| {
                let rows = PoreRows {
                    above: old.row(row - 1),
                    here: old.row(row),
                    below: old.row(row + 1),
                    height_above: height.row(row - 1),
                    height: height.row(row),
                    height_below: height.row(row + 1),
                };
                diffuse(saturation.row_mut(row), &rows, &pores, run);
            });
        });
    });
    each_scene(c, "spread", |bencher, scene| {
        let mut wet_mask = scene.state.wet_mask.clone();
        // s and the mask in; the mask out.
        bencher.run(&scene.name, scene.cells * (VALUE + 2), || {
            scene.walk(|row, run| {
                black_box(spread(wet_mask.row_mut(row), scene.state.saturation.row(row), &pores, run));
            });
        });
    });
}

/// The fast engine's step on one thread, whose fused passes are to beat the sum of the routines.
fn step(c: &mut Criterion) {
    for sweeps in [2, 50] {
        each_scene(c, &format!("step of {sweeps} sweeps"), |bencher, scene| {
            // Tolerance 0: every step takes all its sweeps.
            let params = C97Params { relax_max_sweeps: sweeps, relax_tolerance: 0.0, ..C97Params::default() };
            let ultramarine = PigmentHandling { density: 0.01, staining_power: 3.1, granulation: 0.91 };
            let model = WashModel::C97 { params, capillary: None };
            let mut wash =
                Wash::new(scene.state, model, vec![ultramarine]).expect("the scene is a valid state");
            let config = RunConfig { threads: 1, ..RunConfig::default() };
            // Once through memory, however many sweeps: every live field in; all but height and mask out.
            bencher.group.throughput(Throughput::Bytes((scene.cells * (LIVE + 5 * VALUE)) as u64));
            bencher.group.bench_function(BenchmarkId::from_parameter(&scene.name), |b| {
                // One run of many steps, as a painting does it: a run may begin by taking stock.
                b.iter_custom(|steps| {
                    let start = Instant::now();
                    wash.run(steps, &config).expect("slow water does not run away");
                    start.elapsed()
                });
            });
        });
    }
}

criterion_group!(
    benches,
    copy,
    update_velocities,
    relax_divergence,
    flow_outward,
    move_pigment,
    transfer_pigment,
    simulate_capillary_flow,
    step,
);
criterion_main!(benches);
