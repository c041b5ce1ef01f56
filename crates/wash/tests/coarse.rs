//! What must hold of a wash whose water is coarse and whose pigment is fine, and how like it is to one that is fine
//! throughout.

use girtin_grid::Raster;
use girtin_wash::{
    CoarseWash, Ledger, LivingParams, Patch, PigmentHandling, RunConfig, StateError, Wash, WashModel,
    WashState,
};
use proptest::prelude::*;

mod common;
use common::{random, same};

const ULTRAMARINE: PigmentHandling =
    PigmentHandling { density: 0.01, staining_power: 3.1, granulation: 0.91 };
const UMBER: PigmentHandling = PigmentHandling { density: 0.09, staining_power: 9.3, granulation: 0.9 };
const ROSE: PigmentHandling = PigmentHandling { density: 0.02, staining_power: 5.5, granulation: 0.81 };

/// A random wash: blobs of film on paper that is dry, damp or full.
#[derive(Clone, Debug)]
struct Case {
    width: usize,
    height: usize,
    seed: u64,
    factor: usize,
    wetness: f32,
    film: f32,
    damp: f32,
    pigments: usize,
}

impl Case {
    fn wash(&self) -> CoarseWash {
        let &Case { width, height, seed, .. } = self;
        let paper = Raster::from_fn(width, height, |x, y| random(seed, x, y));
        let mut state = WashState::dry(&paper, self.pigments);
        let size = 4 * self.factor;
        for y in 0..height {
            for x in 0..width {
                let blob = random(seed + 1, x / size, y / size) + 0.1 * random(seed + 2, x, y);
                let is_wet = blob < 1.1 * self.wetness;
                state.wet_mask.cells_mut(y)[x] = u8::from(is_wet);
                state.saturation.cells_mut(y)[x] =
                    if blob < 1.3 * self.wetness { self.damp * (0.3 + 0.6 * paper.at(x, y)) } else { 0.0 };
                if is_wet {
                    state.pressure.cells_mut(y)[x] = self.film * random(seed + 3, x / size, y / size);
                }
                for k in 0..self.pigments {
                    let amount = random(seed + 5 + k as u64, x, y) * f32::from(u8::from(is_wet));
                    state.suspended[k].cells_mut(y)[x] = 0.6 * amount;
                    state.deposited[k].cells_mut(y)[x] = 0.2 * random(seed + 9 + k as u64, x, y);
                }
            }
        }
        let handlings = [ULTRAMARINE, UMBER].into_iter().take(self.pigments).collect();
        CoarseWash::new(state, LivingParams::default(), handlings, self.factor).unwrap()
    }
}

fn cases() -> impl Strategy<Value = Case> {
    let size = prop_oneof![1usize..9, 1usize..120];
    let film = prop_oneof![0.0f32..1.0, 0.0f32..8.0];
    (size.clone(), size, any::<u32>(), 2usize..9, 0.2f32..1.2, film, 0.0f32..1.1, 0usize..3).prop_map(
        |(width, height, seed, factor, wetness, film, damp, pigments)| Case {
            width,
            height,
            seed: u64::from(seed),
            factor,
            wetness,
            film,
            damp,
            pigments,
        },
    )
}

#[test]
fn a_state_that_is_kept_has_the_pore_water() {
    let case =
        Case { width: 50, height: 37, seed: 3, factor: 4, wetness: 0.8, film: 0.6, damp: 0.9, pigments: 1 };
    let mut wash = case.wash();
    wash.run(20, &threads(1)).unwrap();
    let water = wash.water().clone();
    let state = wash.into_state();
    for y in 0..37 {
        for x in 0..50 {
            assert_eq!(state.saturation.cells(y)[x], water.saturation.cells(y / 4)[x / 4], "{x}, {y}");
        }
    }
    assert!(water.saturation.cells(4).iter().any(|&saturation| saturation > 0.0));
}

fn threads(threads: usize) -> RunConfig<'static> {
    RunConfig { threads, ..RunConfig::default() }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Whatever the size, pigment and water are neither made nor lost, and every value is allowed.
    #[test]
    fn pigment_and_water_are_kept(case in cases()) {
        let mut wash = case.wash();
        let (pigment, water) = (wash.pigment_totals(), wash.water_total());
        prop_assert_eq!(wash.run(40, &threads(1)).unwrap().steps, 40);
        wash.state().check().unwrap();
        for (before, after) in pigment.iter().zip(wash.pigment_totals()) {
            prop_assert!((after - before).abs() <= 2e-6 * before.max(1.0), "{} became {}", before, after);
        }
        let ledger = wash.state().ledger.unwrap();
        let after = wash.water_total() + ledger.evaporated;
        prop_assert!((after - water).abs() <= 1e-5 * water.max(1.0), "{} became {}", water, after);
    }

    /// A run cut in two gives the bits of the whole.
    #[test]
    fn a_cut_run_gives_the_same_bits(case in cases(), cut in 0u64..9) {
        let (mut whole, mut parts) = (case.wash(), case.wash());
        whole.run(9, &threads(1)).unwrap();
        parts.run(cut, &threads(1)).unwrap();
        parts.run(9 - cut, &threads(1)).unwrap();
        same(parts.state(), whole.state(), "cut in two");
        same(parts.water(), whole.water(), "water of one cut in two");
    }
}

#[test]
fn threads_change_no_bit() {
    let case =
        Case { width: 310, height: 250, seed: 4, factor: 4, wetness: 0.7, film: 1.5, damp: 0.7, pigments: 2 };
    let mut one = case.wash();
    one.run(40, &threads(1)).unwrap();
    assert!(one.state().suspended[0].cells(100).iter().any(|&g| g > 0.0), "some of it is still wet");
    for count in [2, 3, 8] {
        let mut several = case.wash();
        several.run(15, &threads(count)).unwrap();
        several.run(25, &threads(count)).unwrap();
        same(several.state(), one.state(), "several threads");
        same(several.water(), one.water(), "several threads");
    }
}

#[test]
fn pigment_is_kept_over_a_thousand_steps() {
    let case =
        Case { width: 90, height: 70, seed: 8, factor: 4, wetness: 0.8, film: 1.5, damp: 0.9, pigments: 2 };
    let mut wash = case.wash();
    let before = wash.pigment_totals();
    wash.run(1000, &threads(1)).unwrap();
    for (before, after) in before.iter().zip(wash.pigment_totals()) {
        assert!((after / before - 1.0).abs() < 1e-6, "{before} became {after}");
    }
    let dry = (0..70).all(|y| wash.state().suspended[0].cells(y).iter().all(|&g| g == 0.0));
    assert!(dry && (0..70).all(|y| wash.state().wet_mask.cells(y).iter().all(|&wet| wet == 0)), "it dried");
}

#[test]
fn a_factor_that_cannot_be_is_refused() {
    for factor in [0, 1, 9] {
        let state = WashState::dry(&Raster::new(9, 9, 0.5), 0);
        let refused = CoarseWash::new(state, LivingParams::default(), Vec::new(), factor);
        assert!(matches!(refused, Err(StateError::Number { name: "factor", .. })), "{factor}");
    }
}

#[test]
fn water_is_accounted_for_whatever_is_done() {
    let state = WashState::dry(&Raster::from_fn(90, 71, |x, y| 0.3 + 0.4 * random(1, x, y)), 1);
    let mut wash = CoarseWash::new(state, LivingParams::default(), vec![ROSE], 4).unwrap();
    let stroke = Raster::new(21, 14, 1.0);
    let stroke = Patch { x: 15, y: 15, amounts: &stroke };
    let mut poured = wash.moisten(Patch { x: 10, y: 10, amounts: &Raster::new(42, 30, 0.6) });
    wash.wet(stroke);
    poured += wash.add_water(stroke);
    assert!((wash.water_total() / poured - 1.0).abs() < 1e-6);
    let mut pigment = wash.add_pigment(0, stroke);
    let balance = |wash: &CoarseWash, poured: f64, pigment: f64, after: &str| {
        let ledger = wash.state().ledger.unwrap();
        let found = wash.water_total() + ledger.evaporated + ledger.blotted;
        assert!((found / poured - 1.0).abs() < 1e-5, "after {after}: {found} of {poured}");
        let found = wash.pigment_totals()[0];
        assert!((found / pigment - 1.0).abs() < 1e-5, "after {after}: {found} of {pigment} pigment");
    };
    wash.run(20, &threads(1)).unwrap();
    balance(&wash, poured, pigment, "running");
    let blotted = wash.blot(Patch { x: 18, y: 0, amounts: &Raster::new(6, 40, 0.7) });
    assert!(blotted.water > 0.0 && blotted.pigments[0] > 0.0);
    pigment -= blotted.pigments[0];
    pigment -= wash.lift(Patch { x: 25, y: 0, amounts: &Raster::new(6, 40, 0.3) })[0];
    balance(&wash, poured, pigment, "blotting and lifting");
    poured += wash.moisten(Patch { x: 60, y: 20, amounts: &Raster::new(50, 60, 1.4) });
    assert_eq!(wash.state().wet_mask.cells(40)[75], 1, "what the pores do not hold is film");
    balance(&wash, poured, pigment, "moistening");
    wash.tilt(20.0, 0.0);
    wash.run(20, &threads(1)).unwrap();
    wash.dry_within(Patch { x: 0, y: 0, amounts: &Raster::new(30, 30, 0.1) });
    wash.dry_within(Patch { x: 29, y: 0, amounts: &Raster::new(9, 70, 1.0) });
    assert!(wash.state().wet_mask.cells(20)[29..38].iter().all(|&wet| wet == 0));
    balance(&wash, poured, pigment, "drying");
    wash.run(20, &threads(1)).unwrap();
    poured += wash.soak(Patch { x: 0, y: 60, amounts: &Raster::new(90, 10, 0.3) });
    balance(&wash, poured, pigment, "soaking");
    wash.dry();
    wash.run(20, &threads(1)).unwrap();
    balance(&wash, poured, pigment, "drying it all");
}

#[test]
fn a_drawn_edge_stays_where_it_was_drawn_on_dry_paper() {
    // A slanted edge, which coarse cells would show as stairs.
    let (width, height) = (160, 120);
    let state =
        WashState::dry(&Raster::from_fn(width, height, |x, y| 0.3 + 0.4 * random(1, x / 2, y / 2)), 1);
    let mut wash = CoarseWash::new(state, LivingParams::default(), vec![ROSE], 4).unwrap();
    let inside = |x: usize, y: usize| 10 * y > 200 + 3 * x && 10 * y < 700 + 3 * x && (16..144).contains(&x);
    let mask = Raster::from_fn(width, height, |x, y| f32::from(u8::from(inside(x, y))));
    wash.wet(Patch::whole(&mask));
    wash.add_water(Patch::whole(&mask.map(|wet| 0.6 * wet)));
    wash.add_pigment(0, Patch::whole(&mask.map(|wet| 0.4 * wet)));
    wash.run(300, &threads(1)).unwrap();
    for y in 0..height {
        for (x, &d) in wash.state().deposited[0].cells(y).iter().enumerate() {
            assert_eq!(d > 0.0, inside(x, y), "column {x}, row {y}");
        }
    }
}

/// A wash of either kind.
enum Either {
    Full(Box<Wash>),
    Coarse(Box<CoarseWash>),
}

impl Either {
    fn state(&self) -> &WashState {
        match self {
            Self::Full(wash) => wash.state(),
            Self::Coarse(wash) => wash.state(),
        }
    }

    fn soak(&mut self, patch: Patch<'_>) {
        match self {
            Self::Full(wash) => wash.soak(patch),
            Self::Coarse(wash) => wash.soak(patch),
        };
    }

    /// Draws what is nearer than 0 to a shape, with water that tapers over half a millimetre.
    fn draw(&mut self, mm: &Sheet, film: f32, pigment: f32, shape: impl Fn(f32, f32) -> f32) {
        let mask = mm.raster(|x, y| f32::from(u8::from(shape(x, y) > 0.0)));
        let water = mm.raster(|x, y| {
            let t = (shape(x, y) / 0.5).clamp(0.0, 1.0);
            film * t * t * (3.0 - 2.0 * t)
        });
        let pigment = mask.map(|wet| pigment * wet);
        let [mask, water, pigment] = [&mask, &water, &pigment].map(Patch::whole);
        match self {
            Self::Full(wash) => {
                wash.wet(mask);
                wash.add_water(water);
                wash.add_pigment(0, pigment);
            }
            Self::Coarse(wash) => {
                wash.wet(mask);
                wash.add_water(water);
                wash.add_pigment(0, pigment);
            }
        }
    }

    fn run(&mut self, steps: u64) {
        match self {
            Self::Full(wash) => wash.run(steps, &threads(0)),
            Self::Coarse(wash) => wash.run(steps, &threads(0)),
        }
        .unwrap();
    }
}

/// A square sheet.
struct Sheet {
    side: usize,
    cells_per_mm: usize,
}

impl Sheet {
    /// A value of every cell, from millimetres from the sheet's middle.
    fn raster(&self, value: impl Fn(f32, f32) -> f32) -> Raster<f32> {
        let cells = self.side * self.cells_per_mm;
        let mm = |at: usize| (at as f32 + 0.5) / self.cells_per_mm as f32 - self.side as f32 / 2.0;
        Raster::from_fn(cells, cells, |x, y| value(mm(x), mm(y)))
    }
}

/// Paper whose grain is a quarter of a millimetre and more.
fn grain(x: f32, y: f32) -> f32 {
    let wave = |a: f32, b: f32, phase: f32| (a * x + b * y + phase).sin();
    let rough = wave(5.1, 3.7, 0.3) * wave(-4.3, 6.1, 1.1) + wave(9.7, -7.9, 2.0) * wave(8.3, 10.1, 0.7);
    (0.5 + 0.14 * rough + 0.06 * wave(1.1, 0.8, 0.0)).clamp(0.05, 0.95)
}

/// How much the pigment of water coarse and pigment fine differs from that of a wash with `scale` cells a reference cell
/// throughout: relative L1 after a blur of about half a millimetre.
fn difference(factor: usize, scale: usize, paint: impl Fn(&mut Either, &Sheet)) -> f64 {
    let [full, coarse] = [amounts(scale, None, &paint), amounts(factor, Some(factor), &paint)];
    let off: f64 = full.as_slice().iter().zip(coarse.as_slice()).map(|(a, b)| (a - b).abs()).sum();
    off / full.as_slice().iter().sum::<f64>()
}

/// Pigment after a blur, on reference cells.
fn amounts(scale: usize, coarse: Option<usize>, paint: impl Fn(&mut Either, &Sheet)) -> Raster<f64> {
    let sheet = Sheet { side: 12, cells_per_mm: 4 * scale };
    let mut state = WashState::dry(&sheet.raster(grain), 1);
    state.ledger = Some(Ledger::new(sheet.cells_per_mm as f64));
    let params = LivingParams::default();
    let mut wash = match coarse {
        Some(factor) => Either::Coarse(Box::new(CoarseWash::new(state, params, vec![ROSE], factor).unwrap())),
        None => Either::Full(Box::new(Wash::new(state, WashModel::Living(params), vec![ROSE]).unwrap())),
    };
    paint(&mut wash, &sheet);
    let state = wash.state();
    let mean = Raster::from_fn(4 * sheet.side, 4 * sheet.side, |x, y| {
        let cells = (0..scale * scale).map(|i| (scale * x + i % scale, scale * y + i / scale));
        let amount = |(x, y): (usize, usize)| state.suspended[0].cells(y)[x] + state.deposited[0].cells(y)[x];
        cells.map(|cell| f64::from(amount(cell))).sum::<f64>() / (scale * scale) as f64
    });
    blur(blur(mean))
}

/// Weighs cells along the rows by 1 : 2 : 1, and turns the raster.
fn blur(amounts: Raster<f64>) -> Raster<f64> {
    Raster::from_fn(amounts.height(), amounts.width(), |y, x| {
        let row = amounts.row(y);
        (row[x.saturating_sub(1)] + 2.0 * row[x] + row[(x + 1).min(row.len() - 1)]) / 4.0
    })
}

fn stroke(x: f32, y: f32) -> f32 {
    let (along, aside) = (0.94 * x + 0.34 * y, 0.94 * y - 0.34 * x);
    (1.5 + 0.4 * (0.6 * along).sin() - (aside - 0.4 * (0.8 * along).sin()).abs()).min(4.0 - along.abs())
}

fn soak(wash: &mut Either, sheet: &Sheet, part: f32) {
    wash.soak(Patch::whole(&sheet.raster(|x, y| part * (0.3 + 0.6 * grain(x, y)))));
}

#[test]
fn it_is_like_a_wash_that_is_fine_throughout_and_like_one_that_is_coarse() {
    type Paint = fn(&mut Either, &Sheet);
    let dry: Paint = |wash, sheet| {
        wash.draw(sheet, 0.7, 0.5, stroke);
        wash.run(200);
    };
    let damp: Paint = |wash, sheet| {
        soak(wash, sheet, 0.6);
        wash.draw(sheet, 0.7, 0.5, stroke);
        wash.run(200);
    };
    let wet_in_wet: Paint = |wash, sheet| {
        soak(wash, sheet, 1.0);
        wash.draw(sheet, 0.3, 0.0, |_, _| 1.0);
        wash.draw(sheet, 1.0, 0.8, |x, y| stroke(x, y) - 0.8);
        wash.run(40);
    };
    let backrun: Paint = |wash, sheet| {
        wash.draw(sheet, 0.7, 0.4, |x, y| 5.2 - x.hypot(y));
        wash.run(110);
        wash.draw(sheet, 1.5, 0.0, |x, y| 1.8 - x.hypot(y));
        wash.run(150);
    };
    // Name, and at most so much to fine and to coarse.
    let cases = [
        ("stroke on dry paper", dry, 0.06, 0.13),
        ("stroke on damp paper", damp, 0.15, 0.2),
        ("wet-in-wet", wet_in_wet, 0.2, 0.07),
        ("backrun", backrun, 0.07, 0.1),
    ];
    for factor in [2, 4] {
        for (name, paint, to_fine, to_coarse) in cases {
            let found = [factor, 1].map(|scale| difference(factor, scale, paint));
            println!("{factor} {name}: {found:.3?}");
            assert!(found[0] < to_fine, "{name} at {factor}, to fine: {} is not below {to_fine}", found[0]);
            assert!(
                found[1] < to_coarse,
                "{name} at {factor}, to coarse: {} is not below {to_coarse}",
                found[1]
            );
        }
    }
}
