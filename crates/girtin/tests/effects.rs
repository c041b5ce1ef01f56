//! The gallery shows what the paper's figures show: judged by measures of the pigment on the paper, then by goldens.

use std::path::Path;

use girtin::grid::{Field, Raster};
use girtin::optics::{Layer, LinearRgb};
use girtin::painting::gallery::{EFFECTS, Example, LIVING, SWATCHES};
use girtin::painting::picture::{PictureMeta, write_png};
use girtin::painting::{Document, MapChest, PaintConfig, Painted, Stock, composite, handling_of};
use girtin::wash::{C97Params, Patch, PigmentHandling, RunConfig, Wash, WashModel, WashState};

fn example(name: &str) -> Example {
    *EFFECTS.iter().find(|example| example.name == name).unwrap()
}

fn paint(example: Example, long_edge: u32) -> Painted {
    let stock = Stock::builtin();
    let document = Document::from_toml(example.name, example.text, &stock).unwrap().with_long_edge(long_edge);
    document.paint(&stock, &MapChest::default(), &PaintConfig::default()).unwrap()
}

/// The cells of a field as a raster.
fn cells<T: Copy>(field: &Field<T>) -> Raster<T> {
    let layout = field.layout();
    Raster::from_fn(layout.width(), layout.height(), |x, y| field.cells(y)[x])
}

/// How many cells every cell is away from the nearest that is not set, up to `most`, counting the sheet's end.
fn depth(mask: &Raster<u8>, most: u32) -> Raster<u32> {
    let mut depth = mask.map(|set| if set != 0 { most } else { 0 });
    for round in 1..most {
        let before = depth.clone();
        let below = |x: Option<usize>, y: Option<usize>| match (x, y) {
            (Some(x), Some(y)) if x < before.width() && y < before.height() => before.at(x, y) < round,
            _ => true,
        };
        for y in 0..depth.height() {
            for x in 0..depth.width() {
                let near = below(x.checked_sub(1), Some(y))
                    || below(Some(x + 1), Some(y))
                    || below(Some(x), y.checked_sub(1))
                    || below(Some(x), Some(y + 1));
                if near && before.at(x, y) > round {
                    depth.row_mut(y)[x] = round;
                }
            }
        }
    }
    depth
}

fn mean(values: impl Iterator<Item = f32>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, n), value| (sum + f64::from(value), n + 1));
    assert!(count > 0, "nothing to measure");
    sum / count as f64
}

fn correlation(a: &[f32], b: &[f32]) -> f64 {
    let (mean_a, mean_b) = (mean(a.iter().copied()), mean(b.iter().copied()));
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for (&a, &b) in a.iter().zip(b) {
        let (a, b) = (f64::from(a) - mean_a, f64::from(b) - mean_b);
        (ab, aa, bb) = (ab + a * b, aa + a * a, bb + b * b);
    }
    ab / (aa * bb).sqrt()
}

#[test]
fn edges_dry_darker_than_the_inside() {
    let painted = paint(example("edge-darkening"), 240);
    let state = &painted.glazes[0].state;
    let (deposited, depth) = (cells(&state.deposited[0]), depth(&cells(&state.wet_mask), 14));
    let at = |wanted: u32| {
        let both = deposited.as_slice().iter().zip(depth.as_slice());
        mean(both.filter(move |(_, depth)| **depth == wanted).map(|(deposited, _)| *deposited))
    };
    let ratio = at(1) / at(14);
    assert!(ratio >= 1.3, "rim over interior is {ratio}");
}

#[test]
fn pigment_granulates_in_the_valleys_the_more_the_higher_its_granulation() {
    let painted = paint(example("granulation"), 240);
    let state = &painted.glazes[0].state;
    let inside = depth(&cells(&state.wet_mask), 12);
    let valleys_and = |pigment: usize| {
        let (mut valley, mut amount) = (Vec::new(), Vec::new());
        let deposited = cells(&state.deposited[pigment]);
        for (i, _) in inside.as_slice().iter().enumerate().filter(|(_, depth)| **depth == 12) {
            valley.push(1.0 - painted.sheet.height.as_slice()[i]);
            amount.push(deposited.as_slice()[i]);
        }
        correlation(&valley, &amount)
    };
    assert!(valleys_and(0) > 0.3, "ultramarine correlates {} with the valleys", valleys_and(0));

    let contrast = |granulation: f64| {
        let mut state = WashState::dry(&painted.sheet.height, 1);
        for y in 0..painted.sheet.height.height() {
            state.wet_mask.cells_mut(y).fill(1);
        }
        let model = WashModel::C97 {
            params: C97Params { slope_scale: 0.0, ..C97Params::default() },
            capillary: None,
        };
        let handling = PigmentHandling { density: 0.05, staining_power: 3.0, granulation };
        let mut wash = Wash::new(state, model, vec![handling]).unwrap();
        let (width, height) = (painted.sheet.height.width(), painted.sheet.height.height());
        wash.add_pigment(0, Patch::whole(&Raster::new(width, height, 0.4)));
        wash.run(20, &RunConfig::default()).unwrap();
        let amount = cells(&wash.state().deposited[0]);
        let middle = mean(amount.as_slice().iter().copied());
        (mean(amount.as_slice().iter().map(|a| (a - middle as f32).powi(2))).sqrt()) / middle
    };
    let contrasts = [0.1, 0.4, 0.7, 1.0].map(contrast);
    assert!(contrasts.is_sorted(), "contrast by granulation: {contrasts:?}");
    assert!(contrasts[3] > 4.0 * contrasts[0]);
}

#[test]
fn a_dry_brush_touches_only_the_peaks() {
    let painted = paint(example("drybrush"), 320);
    for glaze in &painted.glazes {
        let (wet, pigment) = (cells(&glaze.state.wet_mask), cells(&glaze.state.deposited[0]));
        let dry_pigment = wet.as_slice().iter().zip(pigment.as_slice()).filter(|(wet, _)| **wet == 0);
        assert!(dry_pigment.clone().all(|(_, amount)| *amount == 0.0), "pigment on paper that stayed dry");
        let heights = |wanted: u8| {
            let both = wet.as_slice().iter().zip(painted.sheet.height.as_slice());
            mean(both.filter(move |(wet, _)| **wet == wanted).map(|(_, height)| *height))
        };
        assert!(heights(1) > heights(0) + 0.08, "touched {} of untouched {}", heights(1), heights(0));
    }
}

#[test]
fn a_backrun_has_a_branched_dark_front_and_a_lighter_inside() {
    let painted = paint(example("backrun"), 320);
    let state = &painted.glazes[0].state;
    let wet = cells(&state.wet_mask);
    let set = |x: usize, y: usize| x < wet.width() && y < wet.height() && wet.at(x, y) != 0;
    let (mut area, mut perimeter) = (0.0, 0.0);
    for y in 0..wet.height() {
        for x in 0..wet.width() {
            if set(x, y) {
                area += 1.0;
                let open =
                    [set(x + 1, y), set(x.wrapping_sub(1), y), set(x, y + 1), set(x, y.wrapping_sub(1))];
                perimeter += open.iter().filter(|neighbour| !**neighbour).count() as f64;
            }
        }
    }
    // Counted along cell edges, a disc has 16.
    let branching = perimeter * perimeter / area;
    assert!(branching > 5.0 * 16.0, "perimeter² over area is {branching}");

    let depth_in = depth(&wet, 12);
    let pigment = |i: usize| {
        let (x, y) = (i % wet.width(), i / wet.width());
        state.deposited[0].cells(y)[x] + state.suspended[0].cells(y)[x]
    };
    let mean_where =
        |holds: &dyn Fn(usize) -> bool| mean((0..wet.as_slice().len()).filter(|&i| holds(i)).map(pigment));
    let wash = mean_where(&|i| wet.as_slice()[i] == 0 && pigment(i) > 0.05);
    let front = mean_where(&|i| depth_in.as_slice()[i] == 1);
    let inside = mean_where(&|i| depth_in.as_slice()[i] == 12);
    assert!(front > 1.15 * wash, "front {front} of wash {wash}");
    assert!(inside < 0.75 * wash, "inside {inside} of wash {wash}");
}

#[test]
fn wet_in_wet_color_streaks_along_the_flow() {
    let painted = paint(example("flow"), 480);
    let state = &painted.glazes[0].state;
    let amount = cells(&state.suspended[0]);
    let (mut along, mut across) = (0.0, 0.0);
    for y in 4..amount.height() - 4 {
        for x in 4..amount.width() - 4 {
            let u = 0.5 * (state.u.faces(y)[x] + state.u.faces(y)[x + 1]);
            let v = 0.5 * (state.v.cells(y)[x] + state.v.cells(y + 1)[x]);
            let speed = u.hypot(v);
            // The fringe, where the color feathers out; farther in all is even.
            if speed < 0.02 || !(0.02..0.3).contains(&amount.at(x, y)) {
                continue;
            }
            let (dx, dy) = (1.5 * u / speed, 1.5 * v / speed);
            let (px, py) = (x as f32 + 0.5, y as f32 + 0.5);
            let bend = |dx: f32, dy: f32| {
                let ends = amount.sample(px + dx, py + dy) + amount.sample(px - dx, py - dy);
                f64::from((ends - 2.0 * amount.at(x, y)).abs())
            };
            along += bend(dx, dy);
            across += bend(-dy, dx);
        }
    }
    let ratio = across / along;
    assert!(ratio > 1.5, "the pigment bends {ratio} times as much across the flow as along it");
}

#[test]
fn a_glaze_over_a_glaze_is_kubelka_s_composition() {
    let stock = Stock::builtin();
    let example = example("glazing");
    let mut document = Document::from_toml(example.name, example.text, &stock).unwrap().with_long_edge(160);
    document.sheet.cells_per_pixel = 1;
    let painted = document.paint(&stock, &MapChest::default(), &PaintConfig::default()).unwrap();
    let (mut overlaps, picture) = (0, painted.picture());
    for y in 0..picture.height() {
        for x in 0..picture.width() {
            let mut stack = Layer::CLEAR;
            let mut layers = 0;
            for (glaze, planned) in painted.glazes.iter().zip(&document.glazes) {
                let amount = glaze.state.suspended[0].cells(y)[x] + glaze.state.deposited[0].cells(y)[x];
                layers += usize::from(amount > 0.0);
                let paint = stock.pigments.get(&planned.pigments[0]).unwrap().coefficients;
                stack = paint.layer(f64::from(amount)).over(stack);
            }
            let LinearRgb(wanted) = stack.over_ground(document.sheet.ground);
            overlaps += usize::from(layers == 3);
            for (wanted, found) in wanted.iter().zip(picture.at(x, y).0) {
                assert!((wanted - found).abs() < 1e-6, "{wanted} and {found} at {x}, {y}");
            }
        }
    }
    assert!(overlaps > 100, "all three glazes overlap");
}

#[test]
fn the_denser_pigment_settles_first() {
    let stock = Stock::builtin();
    let handlings =
        ["burnt-umber", "french-ultramarine"].map(|name| handling_of(stock.pigments.get(name).unwrap()));
    let mut wash =
        Wash::new(WashState::dry(&Raster::new(20, 20, 0.5), 2), WashModel::c97(), handlings.to_vec())
            .unwrap();
    let everywhere = Raster::new(20, 20, 1.0);
    wash.wet(Patch::whole(&everywhere));
    (0..2).for_each(|pigment| {
        wash.add_pigment(pigment, Patch::whole(&everywhere.map(|_| 0.4)));
    });
    wash.run(8, &RunConfig::default()).unwrap();
    let settled = |pigment: usize| wash.state().deposited[pigment].cells(10)[10];
    assert!(settled(0) > 4.0 * settled(1), "umber {}, ultramarine {}", settled(0), settled(1));
}

/// Other sheets and sizes must not make the water of a recipe run away.
#[test]
fn recipes_hold_on_other_sheets_and_at_other_sizes() {
    let stock = Stock::builtin();
    for example in EFFECTS {
        for (seed, long_edge) in [(4, 200), (7, 310), (5, 440)] {
            let mut document =
                Document::from_toml(example.name, example.text, &stock).unwrap().with_long_edge(long_edge);
            document.sheet.seed = seed;
            let painted = document.paint(&stock, &MapChest::default(), &PaintConfig::default());
            assert!(painted.is_ok(), "{} with seed {seed} at {long_edge}: {:?}", example.name, painted.err());
        }
    }
}

/// Every document of the gallery, small, against its picture in `fidelity/golden/gallery`.
///
/// With `GIRTIN_WRITE_GOLDENS=1` the pictures are written instead, and the test fails, so that nobody forgets to look.
#[test]
fn the_gallery_looks_as_it_did() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fidelity/golden/gallery");
    let writing = std::env::var_os("GIRTIN_WRITE_GOLDENS").is_some();
    let mut changed = Vec::new();
    let of_paper = EFFECTS.into_iter().chain([SWATCHES]).map(|example| (example, "", 96));
    let of_living = LIVING.into_iter().map(|example| (example, "living/", 128));
    for (example, model, size) in of_paper.chain(of_living) {
        let picture = composite::encode(&paint(example, size).picture());
        let path = folder.join(format!("{model}{}.png", example.name));
        if writing {
            let file = std::fs::File::create(&path).unwrap();
            write_png(file, &picture, &PictureMeta::default()).unwrap();
            continue;
        }
        let mut decoder = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap()))
            .read_info()
            .unwrap();
        let mut expected = vec![0; decoder.output_buffer_size().unwrap()];
        decoder.next_frame(&mut expected).unwrap();
        let found: Vec<u8> = picture.as_slice().concat();
        assert_eq!(found.len(), expected.len(), "{}: size", example.name);
        // Not 0: another processor's compiler may round one float differently somewhere in thousands of steps.
        let worst = found.iter().zip(&expected).map(|(a, b)| a.abs_diff(*b)).max();
        if worst > Some(1) {
            changed.push(format!("{} by {}", example.name, worst.unwrap_or(0)));
            // Expected, difference times eight, and actual, side by side.
            let (width, height) = (picture.width(), picture.height());
            let pixel = |bytes: &[u8], i: usize| [bytes[3 * i], bytes[3 * i + 1], bytes[3 * i + 2]];
            let sides = Raster::from_fn(3 * width, height, |x, y| {
                let i = y * width + x % width;
                let (a, b) = (pixel(&expected, i), pixel(&found, i));
                match x / width {
                    0 => a,
                    1 => [0, 1, 2].map(|c| a[c].abs_diff(b[c]).saturating_mul(8)),
                    _ => b,
                }
            });
            let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{}.png", example.name));
            write_png(std::fs::File::create(path).unwrap(), &sides, &PictureMeta::default()).unwrap();
        }
    }
    assert!(!writing, "goldens written: look at them, then run the tests without GIRTIN_WRITE_GOLDENS");
    assert!(changed.is_empty(), "changed: {changed:?}; see {}", env!("CARGO_TARGET_TMPDIR"));
}
