//! What must hold of a wash whichever engine runs it, on how many threads, and however the run is cut.

use girtin_grid::Raster;
use girtin_wash::{
    C97Params, Capillary, Engine, Patch, PigmentHandling, RunConfig, RunError, Wash, WashModel, WashState,
};
use proptest::prelude::*;

mod common;
use common::{random, same};

const ULTRAMARINE: PigmentHandling =
    PigmentHandling { density: 0.01, staining_power: 3.1, granulation: 0.91 };
const UMBER: PigmentHandling = PigmentHandling { density: 0.09, staining_power: 9.3, granulation: 0.9 };

/// Smooth flow between −1 and 1: noise as fast as that would rightly run away.
fn eddy(x: usize, y: usize) -> f32 {
    (x as f32 * 0.13).sin() * (y as f32 * 0.17).cos()
}

#[derive(Clone, Debug)]
struct Case {
    width: usize,
    height: usize,
    seed: u64,
    /// Share of wet cells in the blobs of the mask.
    wetness: f32,
    /// Largest velocity.
    speed: f32,
    pigments: usize,
    capillary: bool,
    sweeps: u32,
}

impl Case {
    fn wash(&self) -> Wash {
        let &Case { width, height, seed, .. } = self;
        let paper = Raster::from_fn(width, height, |x, y| 0.05 + 0.9 * random(seed, x, y));
        let mut state = WashState::dry(&paper, self.pigments);
        for y in 0..height {
            for x in 0..width {
                // Blobs with ragged rims: coarse cells decide, fine ones fray.
                let coarse = random(seed + 1, x / 9, y / 7);
                let wet = coarse + 0.1 * random(seed + 2, x, y) < 1.1 * self.wetness;
                state.wet_mask.cells_mut(y)[x] = u8::from(wet);
                state.pressure.cells_mut(y)[x] = random(seed + 3, x, y) - 0.2;
                if self.capillary {
                    state.saturation.cells_mut(y)[x] =
                        0.6 * random(seed + 4, x / 3, y / 3) * f32::from(u8::from(coarse < 0.6));
                }
                for k in 0..self.pigments {
                    state.suspended[k].cells_mut(y)[x] = random(seed + 5 + k as u64, x, y);
                    state.deposited[k].cells_mut(y)[x] = 0.5 * random(seed + 9 + k as u64, x, y);
                }
            }
            for x in 0..=width {
                state.u.faces_mut(y)[x] = self.speed * eddy(x, y);
            }
        }
        for y in 0..=height {
            for x in 0..width {
                state.v.cells_mut(y)[x] = self.speed * eddy(y + 40, x);
            }
        }
        let params =
            C97Params { relax_max_sweeps: self.sweeps, edge_darkening: 0.04, ..C97Params::default() };
        let capillary = self.capillary.then(Capillary::default);
        let handlings = [ULTRAMARINE, UMBER, ULTRAMARINE].into_iter().take(self.pigments).collect();
        Wash::new(state, WashModel::C97 { params, capillary }, handlings).unwrap()
    }
}

fn cases() -> impl Strategy<Value = Case> {
    let size = prop_oneof![1usize..6, 1usize..90];
    (size.clone(), size, any::<u32>(), 0.2f32..1.2, 0.0f32..0.8, 1usize..4, any::<bool>(), 1u32..12).prop_map(
        |(width, height, seed, wetness, speed, pigments, capillary, sweeps)| Case {
            width,
            height,
            seed: u64::from(seed),
            wetness,
            speed: speed * speed,
            pigments,
            capillary,
            sweeps,
        },
    )
}

fn run(case: &Case, steps: u64, engine: Engine, threads: usize) -> WashState {
    try_run(case, steps, engine, threads).unwrap()
}

/// Few sweeps and fast water may rightly run away; then there is no state to compare.
fn try_run(case: &Case, steps: u64, engine: Engine, threads: usize) -> Result<WashState, RunError> {
    let mut wash = case.wash();
    wash.run(steps, &RunConfig { engine, threads, ..RunConfig::default() })?;
    Ok(wash.into_state())
}

/// Where runs lie close, the gaps before their cache lines take more than the dry cells between them did.
#[test]
fn rows_longer_than_on_the_canvas_give_the_same_bits() {
    let close = Case {
        width: 81,
        height: 22,
        seed: 2_625_334_190,
        wetness: 0.266_735_3,
        speed: 0.0,
        pigments: 1,
        capillary: false,
        sweeps: 1,
    };
    same(&run(&close, 3, Engine::Fast, 2), &run(&close, 3, Engine::Reference, 1), "packed against canvas");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// The fast engine gives the reference's bits.
    #[test]
    fn engines_give_the_same_bits(case in cases()) {
        match (try_run(&case, 6, Engine::Fast, 1), try_run(&case, 6, Engine::Reference, 1)) {
            (Ok(fast), Ok(reference)) => same(&fast, &reference, "fast against reference"),
            (Err(_), Err(_)) => return Err(TestCaseError::reject("both ran away")),
            (fast, reference) => panic!("fast: {:?}, reference: {:?}", fast.err(), reference.err()),
        }
    }

    /// A run cut in two gives the bits of the whole.
    #[test]
    fn two_sweeps_at_most_stop_as_early_as_more(case in cases(), tolerance in prop_oneof![Just(0.0), Just(0.02), Just(1.0)]) {
        // Of two sweeps the second may go before it is known whether it should; of three it does not.
        let wash = |sweeps: u32| {
            let mut wash = case.wash();
            let WashModel::C97 { params, capillary } = *wash.model() else { unreachable!() };
            let params = C97Params { relax_max_sweeps: sweeps, relax_tolerance: tolerance, ..params };
            wash.set_model(WashModel::C97 { params, capillary });
            wash
        };
        let (mut two, mut three) = (wash(2), wash(3));
        for _ in 0..10 {
            let step = |wash: &mut Wash, threads| wash.run(1, &RunConfig { threads, ..RunConfig::default() });
            let (Ok(of_two), Ok(of_three)) = (step(&mut two, 3), step(&mut three, 1)) else { break };
            if of_three.sweeps_total == 3 {
                break;
            }
            prop_assert_eq!(of_two.sweeps_total, of_three.sweeps_total);
            same(two.state(), three.state(), "at most two against at most three");
        }
    }

    #[test]
    fn a_cut_run_gives_the_same_bits(case in cases(), cut in 0u64..7) {
        let whole = try_run(&case, 7, Engine::Fast, 2);
        prop_assume!(whole.is_ok(), "ran away");
        let mut wash = case.wash();
        wash.run(cut, &RunConfig::default()).unwrap();
        let model = *wash.model();
        let handlings = wash.handlings().to_vec();
        let mut rest = Wash::new(wash.into_state(), model, handlings).unwrap();
        rest.run(7 - cut, &RunConfig::default()).unwrap();
        same(rest.state(), &whole.unwrap(), "cut in two");
    }

    /// Pigment is neither made nor lost, and no amount is negative.
    #[test]
    fn pigment_is_kept(case in cases()) {
        let mut wash = case.wash();
        let before = wash.state().pigment_totals();
        prop_assume!(wash.run(10, &RunConfig::default()).is_ok(), "ran away");
        for (before, after) in before.iter().zip(wash.state().pigment_totals()) {
            prop_assert!((after - before).abs() <= 2e-6 * before.max(1.0), "{before} became {after}");
        }
        wash.state().check().unwrap();
    }
}

/// Strokes far apart on a large canvas, one of them bent around another, run apart; the bits are those of the whole.
#[test]
fn pools_far_apart_give_the_bits_of_the_whole() {
    let (width, height) = (700, 500);
    let paper = Raster::from_fn(width, height, |x, y| 0.05 + 0.9 * random(1, x, y));
    let blobs = [(30, 40, 25), (600, 60, 40), (350, 250, 20), (640, 470, 35), (2, 490, 12)];
    let ring = |x: usize, y: usize| (70.0..90.0).contains(&(x as f32 - 350.0).hypot(y as f32 - 250.0));
    for capillary in [None, Some(Capillary { wetting_threshold: 0.4, ..Capillary::default() })] {
        let mut state = WashState::dry(&paper, 2);
        for y in 0..height {
            for x in 0..width {
                let near = |&(bx, by, r): &(usize, usize, usize)| {
                    x.abs_diff(bx).pow(2) + y.abs_diff(by).pow(2) < r * r
                };
                // Pigment lies on dry paper, too, and pores are damp around the blobs.
                state.deposited[0].cells_mut(y)[x] = 0.1;
                if ring(x, y) || blobs.iter().any(near) {
                    state.wet_mask.cells_mut(y)[x] = 1;
                    state.pressure.cells_mut(y)[x] = random(2, x, y);
                    state.suspended[1].cells_mut(y)[x] = random(3, x, y);
                }
                if x.abs_diff(600) < 60 && y.abs_diff(60) < 55 {
                    state.saturation.cells_mut(y)[x] = 0.35;
                }
            }
        }
        let run = |config: RunConfig<'_>| {
            let model = WashModel::C97 { params: C97Params::default(), capillary };
            let mut wash = Wash::new(state.clone(), model, vec![ULTRAMARINE, UMBER]).unwrap();
            let mut report = wash.run(4, &config).unwrap();
            // Between runs the state is whole, and can be changed.
            wash.add_water(Patch { x: 340, y: 240, amounts: &Raster::new(20, 20, 0.3) });
            report.sweeps_total += wash.run(5, &config).unwrap().sweeps_total;
            (wash.into_state(), report.sweeps_total)
        };
        let (whole, sweeps) = run(RunConfig { engine: Engine::Reference, ..RunConfig::default() });
        for threads in [1, 2] {
            let (apart, its_sweeps) = run(RunConfig { threads, ..RunConfig::default() });
            same(&apart, &whole, "pools");
            assert_eq!(its_sweeps, sweeps);
        }
    }
}

/// Crossing strokes, slanted and ragged, on a sheet that is mostly dry, in many bands: also where sweeps are taken back.
#[test]
fn scattered_strokes_give_the_bits_of_the_whole() {
    let (width, height) = (890, 640);
    let paper = Raster::from_fn(width, height, |x, y| 0.05 + 0.9 * random(1, x, y));
    let mut state = WashState::dry(&paper, 1);
    for y in 0..height {
        for x in 0..width {
            let (fx, fy) = (x as f32, y as f32);
            // Distance from lines of all slopes; one lies along the canvas's edge.
            let lines = [fx - 0.6 * fy - 50.0, fx + 1.4 * fy - 760.0, fy - 0.05 * fx - 300.0, fx - 885.0];
            let nearest = lines.map(f32::abs).into_iter().fold(f32::INFINITY, f32::min);
            if nearest < 25.0 + 6.0 * random(2, x / 5, y / 3) {
                state.wet_mask.cells_mut(y)[x] = 1;
                state.pressure.cells_mut(y)[x] = 0.5 + 0.5 * eddy(x, y);
                state.suspended[0].cells_mut(y)[x] = random(3, x, y);
            }
            state.deposited[0].cells_mut(y)[x] = 0.1;
        }
    }
    for relax_tolerance in [0.0, 0.002, 0.01] {
        let run = |config: RunConfig<'_>| {
            let params = C97Params { relax_tolerance, relax_max_sweeps: 7, ..C97Params::default() };
            let model = WashModel::C97 { params, capillary: None };
            let mut wash = Wash::new(state.clone(), model, vec![ULTRAMARINE]).unwrap();
            let report = wash.run(9, &config).unwrap();
            (wash.into_state(), report.sweeps_total)
        };
        let (whole, sweeps) = run(RunConfig { engine: Engine::Reference, ..RunConfig::default() });
        for threads in [1, 2, 3, 7] {
            let (packed, its_sweeps) = run(RunConfig { threads, ..RunConfig::default() });
            same(&packed, &whole, &format!("{threads} threads, tolerance {relax_tolerance}"));
            assert_eq!(its_sweeps, sweeps);
        }
    }
}

#[test]
fn threads_change_no_bit() {
    let case = Case {
        width: 301,
        height: 211,
        seed: 7,
        wetness: 0.8,
        speed: 0.9,
        pigments: 2,
        capillary: true,
        sweeps: 40,
    };
    let one = run(&case, 9, Engine::Fast, 1);
    for threads in [2, 3, 7] {
        same(&one, &run(&case, 9, Engine::Fast, threads), &format!("{threads} threads"));
    }
    same(&one, &run(&case, 9, Engine::Reference, 1), "reference");
}

#[test]
fn dry_faces_stay_still() {
    let case = Case {
        width: 70,
        height: 50,
        seed: 3,
        wetness: 0.6,
        speed: 1.0,
        pigments: 1,
        capillary: true,
        sweeps: 5,
    };
    let state = run(&case, 5, Engine::Fast, 2);
    let wet = |x: isize, y: isize| {
        let inside = (0..70).contains(&x) && (0..50).contains(&y);
        inside && state.wet_mask.cells(y as usize)[x as usize] != 0
    };
    for y in 0..50isize {
        for x in 0..=70isize {
            if !(wet(x - 1, y) && wet(x, y)) {
                assert_eq!(state.u.faces(y as usize)[x as usize].to_bits(), 0);
            }
        }
    }
    for y in 0..=50isize {
        for x in 0..70isize {
            if !(wet(x, y - 1) && wet(x, y)) {
                assert_eq!(state.v.cells(y as usize)[x as usize].to_bits(), 0);
            }
        }
    }
}

/// A wash mirrored, or with rows and columns exchanged, runs mirrored bit for bit; but exchanged only without
/// outflow, whose blur goes along rows first.
#[test]
fn symmetry_is_kept() {
    let (width, height) = (57, 57);
    let paper = |x: usize, y: usize| 0.1 + 0.8 * random(1, x, y);
    let wet = |x: usize, y: usize| {
        (x as f32 - 30.0).hypot(y as f32 - 25.0) < 20.0 && !(x + 3 * y).is_multiple_of(17)
    };
    let turned = |edge_darkening: f64, turn: &dyn Fn(usize, usize) -> (usize, usize)| {
        let mut state = WashState::dry(
            &Raster::from_fn(width, height, |x, y| {
                let (x, y) = turn(x, y);
                paper(x, y)
            }),
            1,
        );
        for y in 0..height {
            for x in 0..width {
                let (from_x, from_y) = turn(x, y);
                state.wet_mask.cells_mut(y)[x] = u8::from(wet(from_x, from_y));
                state.pressure.cells_mut(y)[x] = random(2, from_x, from_y);
                state.suspended[0].cells_mut(y)[x] = random(3, from_x, from_y);
                state.saturation.cells_mut(y)[x] = 0.5 * random(4, from_x, from_y);
            }
        }
        let params = C97Params { edge_darkening, ..C97Params::default() };
        let model = WashModel::C97 { params, capillary: Some(Capillary::default()) };
        let mut wash = Wash::new(state, model, vec![ULTRAMARINE]).unwrap();
        wash.run(12, &RunConfig::default()).unwrap();
        wash.into_state()
    };
    for (name, edge_darkening, turn) in [
        ("mirrored", 0.02, &(|x, y| (width - 1 - x, y)) as &dyn Fn(usize, usize) -> (usize, usize)),
        ("upside down", 0.02, &|x, y| (x, height - 1 - y)),
        ("transposed", 0.0, &|x, y| (y, x)),
    ] {
        let (plain, other) = (turned(edge_darkening, &|x, y| (x, y)), turned(edge_darkening, turn));
        for y in 0..height {
            for x in 0..width {
                let (from_x, from_y) = turn(x, y);
                for (field, a, b) in [
                    ("deposited", &other.deposited[0], &plain.deposited[0]),
                    ("pressure", &other.pressure, &plain.pressure),
                    ("saturation", &other.saturation, &plain.saturation),
                ] {
                    let (a, b) = (a.cells(y)[x], b.cells(from_y)[from_x]);
                    assert_eq!(a.to_bits(), b.to_bits(), "{name}: `{field}` at {x}, {y}: {a} and {b}");
                }
            }
        }
    }
}

#[test]
fn pore_water_is_kept() {
    let mut state = WashState::dry(&Raster::from_fn(40, 40, |x, y| random(1, x, y)), 0);
    for y in 10..30 {
        state.saturation.cells_mut(y)[10..30].fill(0.5);
    }
    let before = state.water_total();
    let capillary = Capillary { absorption: 0.0, wetting_threshold: 2.0, ..Capillary::default() };
    let model = WashModel::C97 { params: C97Params::default(), capillary: Some(capillary) };
    let mut wash = Wash::new(state, model, Vec::new()).unwrap();
    wash.run(50, &RunConfig::default()).unwrap();
    assert!((wash.state().water_total() / before - 1.0).abs() < 1e-5);
}

#[test]
fn a_runaway_wash_ends_with_its_place_and_cause() {
    let mut state = WashState::dry(&Raster::new(8, 8, 0.5), 1);
    (0..8).for_each(|y| state.wet_mask.cells_mut(y).fill(1));
    state.pressure.cells_mut(4)[3] = 1e9;
    for (threads, engine) in [(1, Engine::Fast), (2, Engine::Fast), (1, Engine::Reference)] {
        let mut wash = Wash::new(state.clone(), WashModel::c97(), vec![UMBER]).unwrap();
        let error = wash.run(5, &RunConfig { engine, threads, ..RunConfig::default() }).unwrap_err();
        assert!(error.to_string().contains("see `pressure`"), "{error}");
    }
}

#[test]
fn a_cancelled_run_says_how_far_it_came() {
    use std::sync::atomic::{AtomicBool, Ordering};
    let case = Case {
        width: 30,
        height: 30,
        seed: 3,
        wetness: 1.2,
        speed: 0.1,
        pigments: 1,
        capillary: false,
        sweeps: 5,
    };
    let cancel = AtomicBool::new(false);
    let progress = |steps| cancel.store(steps == 3, Ordering::Relaxed);
    let config = RunConfig { cancel: Some(&cancel), progress: Some(&progress), ..RunConfig::default() };
    assert_eq!(case.wash().run(9, &config), Err(girtin_wash::RunError::Cancelled { steps: 3 }));
}

#[test]
fn no_steps_change_nothing() {
    let case = Case {
        width: 9,
        height: 5,
        seed: 3,
        wetness: 0.5,
        speed: 1.0,
        pigments: 2,
        capillary: true,
        sweeps: 5,
    };
    same(&run(&case, 0, Engine::Fast, 2), case.wash().state(), "no steps");
}

#[test]
fn denser_pigment_settles_first_and_granulating_pigment_seeks_the_valleys() {
    let mut state = WashState::dry(&Raster::from_fn(40, 40, |x, _| if x % 4 < 2 { 0.2 } else { 0.8 }), 2);
    for y in 5..35 {
        state.wet_mask.cells_mut(y)[5..35].fill(1);
        state.suspended.iter_mut().for_each(|g| g.cells_mut(y)[5..35].fill(0.4));
    }
    let light = PigmentHandling { density: 0.01, staining_power: 3.0, granulation: 0.0 };
    let dense = PigmentHandling { density: 0.09, staining_power: 3.0, granulation: 0.9 };
    let model =
        WashModel::C97 { params: C97Params { slope_scale: 0.0, ..C97Params::default() }, capillary: None };
    let mut wash = Wash::new(state, model, vec![light, dense]).unwrap();
    wash.run(10, &RunConfig::default()).unwrap();
    let [light, dense] = &wash.state().deposited[..] else { unreachable!("two pigments were given") };
    let valley_over_peak = |d: &girtin_grid::Field<f32>| d.cells(20)[20] / d.cells(20)[22];
    assert!(dense.cells(20)[20] > 3.0 * light.cells(20)[20]);
    assert!(valley_over_peak(dense) > 1.5, "{}", valley_over_peak(dense));
    assert!((valley_over_peak(light) - 1.0).abs() < 0.02, "{}", valley_over_peak(light));
}
