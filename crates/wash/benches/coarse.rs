//! What a step costs with water coarse and pigment fine, beside a step that is fine throughout.
//!
//! `cargo bench -p girtin-wash --bench coarse -- --quick`. A stroke on dry paper and wet-in-wet, 12 mm square at 16 cells
//! a millimetre, on one thread; each sample is the first sixty steps of a fresh wash.

use std::time::Duration;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use girtin_grid::Raster;
use girtin_grid::random::{hash, stage, unit_f32};
use girtin_wash::{
    CoarseWash, Ledger, LivingParams, Patch, PigmentHandling, RunConfig, Wash, WashModel, WashState,
};

const SIDE: usize = 192;
const FACTOR: usize = 4;
const STEPS: u64 = 60;

/// A sheet with a stroke over it: film where it is wet, and pigment in the stroke.
struct Scene {
    name: &'static str,
    film: Raster<f32>,
    pigment: Raster<f32>,
}

impl Scene {
    fn all() -> [Self; 2] {
        let stroke = |x: usize, y: usize| (60..132).contains(&(y + x / 8)) && (16..176).contains(&x);
        let raster = |value: &dyn Fn(usize, usize) -> f32| Raster::from_fn(SIDE, SIDE, value);
        let pigment = raster(&|x, y| if stroke(x, y) { 0.5 } else { 0.0 });
        [
            Self { name: "stroke", film: pigment.map(|g| 1.4 * g), pigment: pigment.clone() },
            Self { name: "wet-in-wet", film: pigment.map(|g| 0.3 + 1.5 * g), pigment },
        ]
    }

    fn paper() -> WashState {
        let grain = |x: usize, y: usize| unit_f32(hash(1, stage("paper"), [x as i64 / 4, y as i64 / 4], 0));
        let mut state = WashState::dry(&Raster::from_fn(SIDE, SIDE, |x, y| 0.3 + 0.4 * grain(x, y)), 1);
        state.ledger = Some(Ledger::new(16.0));
        state
    }
}

fn step(c: &mut Criterion) {
    let rose = PigmentHandling { density: 0.02, staining_power: 5.5, granulation: 0.81 };
    let params = LivingParams::default();
    let config = RunConfig { threads: 1, ..RunConfig::default() };
    let mut group = c.benchmark_group("sixty steps");
    group.sample_size(10).measurement_time(Duration::from_secs(2));
    for Scene { name, film, pigment } in Scene::all() {
        let [film, pigment] = [&film, &pigment].map(Patch::whole);
        group.bench_function(format!("{name}/fine"), |b| {
            let begin = || {
                let mut wash =
                    Wash::new(Scene::paper(), WashModel::Living(params), vec![rose]).expect("valid");
                wash.wet(film);
                wash.add_water(film);
                wash.add_pigment(0, pigment);
                wash
            };
            b.iter_batched(begin, |mut wash| wash.run(STEPS, &config).map(|_| wash), BatchSize::LargeInput);
        });
        group.bench_function(format!("{name}/water coarse"), |b| {
            let begin = || {
                let mut wash = CoarseWash::new(Scene::paper(), params, vec![rose], FACTOR).expect("valid");
                wash.wet(film);
                wash.add_water(film);
                wash.add_pigment(0, pigment);
                wash
            };
            b.iter_batched(begin, |mut wash| wash.run(STEPS, &config).map(|_| wash), BatchSize::LargeInput);
        });
    }
    group.finish();
}

criterion_group!(benches, step);
criterion_main!(benches);
