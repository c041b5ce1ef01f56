//! What must hold of a living wash whichever engine runs it, on how many threads, however it is cut, and whatever is
//! poured on it.

use girtin_grid::Raster;
use girtin_wash::{
    Engine, Ledger, LivingParams, PigmentHandling, RunConfig, RunError, Wash, WashModel, WashState,
};
use proptest::prelude::*;

mod common;
use common::{random, same};

const ULTRAMARINE: PigmentHandling =
    PigmentHandling { density: 0.01, staining_power: 3.1, granulation: 0.91 };
const UMBER: PigmentHandling = PigmentHandling { density: 0.09, staining_power: 9.3, granulation: 0.9 };
const GREEN: PigmentHandling = PigmentHandling { density: 0.02, staining_power: 1.0, granulation: 0.12 };

/// A random wash: blobs of film on paper that is dry, damp or full, with water that already moves.
#[derive(Clone, Debug)]
struct Case {
    width: usize,
    height: usize,
    seed: u64,
    /// Cells a reference cell.
    scale: f64,
    /// Share of wet cells in the blobs of the mask.
    wetness: f32,
    /// Film of the blobs.
    film: f32,
    /// Pore water, in parts of the capacity.
    damp: f32,
    pigments: usize,
}

impl Case {
    fn state(&self) -> WashState {
        let &Case { width, height, seed, .. } = self;
        // Grain and blobs have a size in millimetres.
        let coarse = |length: f64| (length * self.scale).max(1.0) as usize;
        let grain = |x: usize, y: usize| random(seed, x / coarse(1.0), y / coarse(1.0));
        let paper = Raster::from_fn(width, height, |x, y| 0.05 + 0.9 * grain(x, y));
        let mut state = WashState::dry(&paper, self.pigments);
        state.ledger = Some(Ledger::new(4.0 * self.scale));
        for y in 0..height {
            for x in 0..width {
                let blob = random(seed + 1, x / coarse(12.0), y / coarse(9.0)) + 0.1 * random(seed + 2, x, y);
                let capacity = 0.3 + 0.6 * paper.at(x, y);
                let is_wet = blob < 1.1 * self.wetness;
                state.wet_mask.cells_mut(y)[x] = u8::from(is_wet);
                state.saturation.cells_mut(y)[x] =
                    if blob < 1.3 * self.wetness { self.damp * capacity } else { 0.0 };
                if is_wet {
                    let film = random(seed + 3, x / coarse(6.0), y / coarse(6.0));
                    state.pressure.cells_mut(y)[x] = self.film * film * film;
                }
                for k in 0..self.pigments {
                    let amount = random(seed + 5 + k as u64, x, y) * f32::from(u8::from(is_wet));
                    state.suspended[k].cells_mut(y)[x] = 0.6 * amount;
                    state.deposited[k].cells_mut(y)[x] = 0.2 * random(seed + 9 + k as u64, x, y);
                }
            }
        }
        state
    }

    fn wash_by(&self, params: LivingParams) -> Wash {
        let handlings = [ULTRAMARINE, UMBER, GREEN].into_iter().take(self.pigments).collect();
        Wash::new(self.state(), WashModel::Living(params), handlings).unwrap()
    }

    fn wash(&self) -> Wash {
        self.wash_by(LivingParams::default())
    }

    fn run(&self, steps: u64, engine: Engine, threads: usize) -> Result<WashState, RunError> {
        let mut wash = self.wash();
        wash.run(steps, &RunConfig { engine, threads, ..RunConfig::default() })?;
        Ok(wash.into_state())
    }
}

fn cases() -> impl Strategy<Value = Case> {
    let size = prop_oneof![1usize..6, 1usize..90];
    let scale = prop_oneof![Just(1.0), Just(2.0), Just(3.0), Just(1.5), Just(0.5)];
    (size.clone(), size, any::<u32>(), scale, 0.1f32..1.2, 0.02f32..1.5, 0.0f32..1.2, 1usize..4).prop_map(
        |(width, height, seed, scale, wetness, film, damp, pigments)| Case {
            width,
            height,
            seed: u64::from(seed),
            scale,
            wetness,
            film,
            damp: damp.min(1.0),
            pigments,
        },
    )
}

/// Strokes far apart on a sheet that is mostly dry, so that they are simulated apart and come to meet.
fn strokes() -> Case {
    Case { width: 400, height: 300, seed: 3, scale: 1.0, wetness: 0.06, film: 3.0, damp: 0.9, pigments: 2 }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn engines_give_the_same_bits(case in cases()) {
        let reference = case.run(12, Engine::Reference, 1).unwrap();
        same(&case.run(12, Engine::Fast, 1).unwrap(), &reference, "fast against reference");
        same(&case.run(12, Engine::Fast, 3).unwrap(), &reference, "three threads against reference");
    }

    #[test]
    fn a_cut_run_gives_the_same_bits(case in cases(), cut in 1u64..40) {
        let whole = case.run(40, Engine::Fast, 1).unwrap();
        let mut first = case.wash();
        first.run(cut, &RunConfig { threads: 1, ..RunConfig::default() }).unwrap();
        let handlings = first.handlings().to_vec();
        // As after saving and loading: nothing but the state is kept.
        let mut second = Wash::new(first.into_state(), WashModel::living(), handlings).unwrap();
        second.run(40 - cut, &RunConfig { threads: 2, ..RunConfig::default() }).unwrap();
        same(second.state(), &whole, "cut in two");
    }
}

#[test]
fn a_cell_that_creeps_back_over_full_pores_dries_as_if_it_had_just_been_loaded() {
    let case = Case {
        width: 38,
        height: 37,
        seed: 1812503888,
        scale: 2.0,
        wetness: 1.0121084,
        film: 1.4399915,
        damp: 0.9753173,
        pigments: 1,
    };
    let mut first = case.wash();
    first.run(1, &RunConfig { threads: 1, ..RunConfig::default() }).unwrap();
    let mut second =
        Wash::new(first.into_state(), WashModel::living(), case.wash().handlings().to_vec()).unwrap();
    second.run(39, &RunConfig { threads: 1, ..RunConfig::default() }).unwrap();
    same(second.state(), &case.run(40, Engine::Fast, 1).unwrap(), "cut in two");
}

#[test]
fn threads_change_no_bit() {
    for case in [
        Case {
            width: 300,
            height: 220,
            seed: 8,
            scale: 1.0,
            wetness: 0.7,
            film: 0.9,
            damp: 0.5,
            pigments: 2,
        },
        Case {
            width: 260,
            height: 300,
            seed: 9,
            scale: 2.0,
            wetness: 0.9,
            film: 0.5,
            damp: 0.2,
            pigments: 1,
        },
        strokes(),
    ] {
        let one = case.run(60, Engine::Fast, 1).unwrap();
        for threads in [2, 7] {
            same(&one, &case.run(60, Engine::Fast, threads).unwrap(), &format!("{threads} threads"));
        }
        same(&one, &case.run(60, Engine::Reference, 1).unwrap(), "reference engine");
    }
}

#[test]
fn balances_are_kept_over_a_thousand_steps() {
    for scale in [1.0, 2.0] {
        let case =
            Case { width: 90, height: 70, seed: 4, scale, wetness: 0.8, film: 1.2, damp: 0.4, pigments: 2 };
        let mut wash = case.wash();
        let (pigment, water) = (wash.state().pigment_totals(), wash.water_total());
        wash.run(1000, &RunConfig::default()).unwrap();
        for (before, after) in pigment.iter().zip(wash.state().pigment_totals()) {
            assert!((after / before - 1.0).abs() < 1e-6, "pigment {before} became {after}");
        }
        let ledger = wash.state().ledger.unwrap();
        let accounted = wash.water_total() + ledger.evaporated;
        assert!((accounted / water - 1.0).abs() < 1e-5, "water {water} became {accounted}");
        assert!(ledger.evaporated > 0.5 * water, "most of it is gone");
    }
}

#[test]
fn a_wash_dries_by_itself_and_then_costs_nothing() {
    let case =
        Case { width: 80, height: 60, seed: 2, scale: 1.0, wetness: 0.6, film: 0.7, damp: 0.0, pigments: 1 };
    let mut wash = case.wash();
    let wet = |wash: &Wash| (0..60).any(|y| wash.state().wet_mask.cells(y).contains(&1));
    let mut steps = 0;
    while wet(&wash) {
        wash.run(10, &RunConfig::default()).unwrap();
        steps += 10;
        assert!(steps < 1000, "still wet after {steps} steps");
    }
    assert!(wash.state().suspended[0].cells(30).iter().all(|&g| g == 0.0), "all pigment has settled");
    // The pores dry too; then there is nothing left to do.
    wash.run(4000, &RunConfig::default()).unwrap();
    assert_eq!(wash.water_total(), 0.0);
    let start = std::time::Instant::now();
    wash.run(1_000_000, &RunConfig::default()).unwrap();
    assert!(start.elapsed().as_secs() < 10, "a million steps of dry paper");
}

#[test]
fn whatever_is_poured_on_all_stays_finite() {
    for scale in [1.0, 2.0, 4.0] {
        for damp in [0.0, 0.6, 1.0] {
            for tilt in [0.0, 90.0] {
                let case = Case {
                    width: 70,
                    height: 60,
                    seed: 5,
                    scale,
                    wetness: 0.7,
                    film: 8.0,
                    damp,
                    pigments: 1,
                };
                let params = LivingParams { slope_scale: 0.6, tilt, ..LivingParams::default() };
                let mut wash = case.wash_by(params);
                let (pigment, water) = (wash.state().pigment_totals()[0], wash.water_total());
                wash.run(if scale > 2.0 { 25 } else { 120 }, &RunConfig::default()).unwrap();
                wash.state().check().unwrap();
                let film = &wash.state().pressure;
                assert!((0..60).all(|y| film.cells(y).iter().all(|&p| p >= 0.0)), "no film is below 0");
                let evaporated = wash.state().ledger.unwrap().evaporated;
                assert!(((wash.water_total() + evaporated) / water - 1.0).abs() < 1e-5);
                assert!((wash.state().pigment_totals()[0] / pigment - 1.0).abs() < 1e-6);
            }
        }
    }
}

#[test]
fn symmetry_is_kept() {
    let case =
        Case { width: 61, height: 48, seed: 6, scale: 1.0, wetness: 0.6, film: 1.5, damp: 0.7, pigments: 1 };
    let mut state = case.state();
    // The left half, and the same mirrored.
    for y in 0..48 {
        let mirror = |row: &mut [f32]| (0..30).for_each(|x| row[60 - x] = row[x]);
        let WashState { height, pressure, saturation, suspended, deposited, wet_mask, .. } = &mut state;
        for field in [height, pressure, saturation, &mut suspended[0], &mut deposited[0]] {
            mirror(field.cells_mut(y));
        }
        (0..30).for_each(|x| wet_mask.cells_mut(y)[60 - x] = wet_mask.cells(y)[x]);
    }
    let mut wash = Wash::new(state, WashModel::living(), vec![ULTRAMARINE]).unwrap();
    wash.run(80, &RunConfig::default()).unwrap();
    let state = wash.state();
    for y in 0..48 {
        for x in 0..30 {
            assert_eq!(state.wet_mask.cells(y)[x], state.wet_mask.cells(y)[60 - x], "mask at {x}, {y}");
            for field in [&state.pressure, &state.saturation, &state.suspended[0], &state.deposited[0]] {
                assert_eq!(field.cells(y)[x].to_bits(), field.cells(y)[60 - x].to_bits(), "at {x}, {y}");
            }
        }
    }
}
