use std::sync::atomic::Ordering;

use girtin_grid::noise::{Fractal, Noise};
use girtin_grid::random::stage;
use girtin_optics::Srgb;
use girtin_painting::PaintConfig;
use girtin_painting::area::Shape;
use girtin_painting::document::Event;

use super::*;

const WIDTH: usize = 64;
const HEIGHT: usize = 48;

/// A yellow disc that darkens to the right, before a mottled blue.
fn picture() -> Raster<LinearRgb> {
    let noise = Noise::new(3, stage("test"));
    Raster::from_fn(WIDTH, HEIGHT, |x, y| {
        let (x, y) = (x as f64, y as f64);
        if is_disc(x, y) {
            Srgb([0.9, 0.8 - 0.008 * x, 0.3]).to_linear()
        } else {
            let light = 0.75 + 0.15 * noise.fbm([x / 12.0, y / 12.0], Fractal { octaves: 2, gain: 0.5 });
            Srgb([light * 0.7, light * 0.85, light]).to_linear()
        }
    })
}

fn is_disc(x: f64, y: f64) -> bool {
    libm::hypot(x - 30.0, y - 24.0) < 15.0
}

fn mattes() -> Vec<Matte> {
    let disc = Raster::from_fn(WIDTH, HEIGHT, |x, y| f32::from(u8::from(is_disc(x as f64, y as f64))));
    let light = Raster::from_fn(WIDTH, HEIGHT, |x, y| {
        (1.0 - libm::hypot(x as f64 - 25.0, y as f64 - 18.0) / 5.0).max(0.0) as f32
    });
    vec![
        Matte { name: "ground".to_owned(), coverage: disc.map(|covered| 1.0 - covered) },
        Matte { name: "disc".to_owned(), coverage: disc },
        Matte { name: "light".to_owned(), coverage: light },
    ]
}

const FILE: &str = r#"
format = 1
steps = 12
[[matte]]
name = "ground"
pigments = ["cerulean-blue"]
[matte.planning]
interval = 20
repeats = 3
delta_g = 0.03
[[matte]]
name = "disc"
pigments = ["hansa-yellow", "quinacridone-rose"]
[matte.planning]
interval = 20
repeats = 3
delta_g = 0.05
[[lift]]
name = "light"
fraction = 0.7
"#;

fn sheet() -> SheetSettings {
    SheetSettings {
        size_mm: [16.0, 12.0],
        paper: "cold-press".to_owned(),
        seed: 5,
        ground: LinearRgb::WHITE,
        printed: Vec::new(),
        pixels_per_mm: 4.0,
        cells_per_pixel: 1,
        cells_per_mm: None,
        trim_mm: 0.0,
        relief_mm: 0.0,
    }
}

fn painted_from(
    text: &str,
    picture: &Raster<LinearRgb>,
    mattes: &[Matte],
    config: &C97Config<'_>,
) -> Result<C97Painting, C97Error> {
    let (stock, sheet) = (Stock::builtin(), sheet());
    let glazes = GlazesFile::from_toml("glazes.toml", text, &stock).unwrap();
    let request =
        C97Request { title: "Disc", picture, mattes, glazes: &glazes, sheet: &sheet, stock: &stock };
    watercolorize_c97(&request, config)
}

fn painted(text: &str) -> C97Painting {
    painted_from(text, &picture(), &mattes(), &C97Config::default()).unwrap()
}

/// The map that an event names.
fn map_of(event: &Event) -> Option<&str> {
    match event {
        Event::Wet { area }
        | Event::Water { area, .. }
        | Event::Pigment { area, .. }
        | Event::Lift { area, .. } => match &area.shape {
            Shape::Map(name) => Some(&name.file),
            _ => None,
        },
        _ => None,
    }
}

#[test]
fn painting_the_document_again_is_the_same() {
    for text in [FILE.to_owned(), FILE.replace("[[lift]]", "[matte.wash]\nmodel = \"living\"\n[[lift]]")] {
        let painting = painted(&text);
        let again =
            painting.document.paint(&Stock::builtin(), &painting.maps, &PaintConfig::default()).unwrap();
        assert_eq!(again.glazes.len(), 3);
        for glaze in &painting.glazes {
            let state = &again.glazes[glaze.glaze.unwrap()].state;
            for y in 0..HEIGHT {
                for x in 0..WIDTH {
                    let found = state.suspended[0].cells(y)[x] + state.deposited[0].cells(y)[x];
                    assert_eq!(
                        found.to_bits(),
                        glaze.left.at(x, y).to_bits(),
                        "{} at {x}, {y}",
                        glaze.pigment
                    );
                }
            }
        }
    }
}

#[test]
fn every_map_is_used_and_every_pigment_is_accounted_for() {
    let painting = painted(FILE);
    let again = painting.document.paint(&Stock::builtin(), &painting.maps, &PaintConfig::default()).unwrap();
    let used: Vec<&str> =
        painting.document.glazes.iter().flat_map(|glaze| &glaze.events).filter_map(map_of).collect();
    for name in painting.maps.0.keys() {
        assert!(used.contains(&name.as_str()), "{name}");
    }
    for pigment in again.glazes.iter().flat_map(|glaze| &glaze.pigments) {
        assert!(pigment.laid > 1.0, "{pigment:?}");
        assert!((pigment.laid - pigment.lifted - pigment.total).abs() < 1e-3 * pigment.laid, "{pigment:?}");
    }
    let has_light =
        |glaze: &Glaze| glaze.events.iter().filter_map(map_of).any(|name| name == "lift-light.png");
    let lifted: Vec<bool> = painting.document.glazes.iter().map(has_light).collect();
    assert_eq!(lifted, [false, true, true], "the light lies in the disc alone");
}

#[test]
fn planning_brings_the_glaze_nearer_to_its_target() {
    // With rims as strong as the paper's, so that there is something to mend.
    let rims = "[matte.wash]\nedge_darkening = 0.02\n";
    let file = FILE.replace("delta_g = 0.03\n", &format!("delta_g = 0.03\n{rims}"));
    let file = file.replace("delta_g = 0.05\n", &format!("delta_g = 0.05\n{rims}"));
    let planned = painted(&file);
    // As many steps in one go.
    let unplanned = painted(&file.replace("interval = 20\nrepeats = 3", "interval = 80\nrepeats = 0"));
    for (planned, unplanned) in planned.glazes.iter().zip(&unplanned.glazes) {
        let (with, without) = (planned.looks.last().unwrap(), unplanned.looks.last().unwrap());
        assert!(with.off < 0.9 * without.off, "{}: {with:?}, without planning {without:?}", planned.pigment);
        assert!(
            with.off_low_passed < 0.85 * without.off_low_passed,
            "{}: {with:?}, {without:?}",
            planned.pigment
        );
    }
    // Brushstrokes alone get there as well, step by step.
    let strokes = painted(&file.replace("repeats = 3", "repeats = 5\nfirst_share = 0.0"));
    for glaze in &strokes.glazes {
        let (first, last) = (glaze.looks[0], glaze.looks[5]);
        assert!(
            last.off < 0.8 * first.off && last.off_low_passed < 0.8 * first.off_low_passed,
            "{first:?}, {last:?}"
        );
    }
}

#[test]
fn any_number_of_threads_plans_the_same() {
    let run = |threads| {
        painted_from(FILE, &picture(), &mattes(), &C97Config { threads, ..C97Config::default() }).unwrap()
    };
    let one = run(1);
    for threads in [2, 7] {
        let other = run(threads);
        assert_eq!(one.document, other.document);
        assert!(one.maps == other.maps);
        for (one, other) in one.glazes.iter().zip(&other.glazes) {
            assert!(one.target == other.target && one.left == other.left && one.looks == other.looks);
        }
    }
}

#[test]
fn a_picture_of_another_size_than_the_sheet_is_stretched() {
    let double = |x: usize| x / 2;
    let large = picture();
    let large = Raster::from_fn(2 * WIDTH, 2 * HEIGHT, |x, y| large.at(double(x), double(y)));
    let mattes: Vec<Matte> = mattes()
        .into_iter()
        .map(|matte| {
            let coverage =
                Raster::from_fn(2 * WIDTH, 2 * HEIGHT, |x, y| matte.coverage.at(double(x), double(y)));
            Matte { coverage, ..matte }
        })
        .collect();
    let found = painted_from(FILE, &large, &mattes, &C97Config::default()).unwrap();
    for (found, same) in found.glazes.iter().zip(&painted(FILE).glazes) {
        let difference: f32 =
            found.left.as_slice().iter().zip(same.left.as_slice()).map(|(a, b)| (a - b).abs()).sum();
        let all: f32 = same.left.as_slice().iter().sum();
        assert!(difference < 0.15 * all, "{}: {difference} of {all}", found.pigment);
    }
}

#[test]
fn a_pigment_that_is_not_wanted_has_no_glaze() {
    let white = Raster::new(WIDTH, HEIGHT, LinearRgb::WHITE);
    let painting = painted_from(FILE, &white, &mattes(), &C97Config::default()).unwrap();
    assert!(painting.document.glazes.is_empty() && painting.maps.0.is_empty());
    assert!(painting.glazes.iter().all(|glaze| glaze.glaze.is_none()));
}

#[test]
fn what_is_wrong_with_a_matte_is_said() {
    let run = |change: &dyn Fn(&mut Vec<Matte>)| {
        let mut mattes = mattes();
        change(&mut mattes);
        painted_from(FILE, &picture(), &mattes, &C97Config::default()).unwrap_err()
    };
    let missing = run(&|mattes| mattes[1].name = "disk".to_owned());
    assert_eq!(missing.to_string(), "there is no matte `disc`");
    assert_eq!(missing.hint().as_deref(), Some("did you mean `disk`?"));
    let small = run(&|mattes| mattes[1].coverage = Raster::new(3, 2, 1.0));
    assert_eq!(small.to_string(), "matte `disc` is 3 × 2 pixels, and the picture is 64 × 48");
    for name in ["ground", "light"] {
        let empty = run(&|mattes| {
            mattes.iter_mut().filter(|matte| matte.name == name).for_each(|matte| {
                matte.coverage = Raster::new(WIDTH, HEIGHT, 0.0);
            });
        });
        assert_eq!(empty.to_string(), format!("matte `{name}` is empty"));
    }
    let empty = painted_from(FILE, &Raster::new(0, 0, LinearRgb::WHITE), &mattes(), &C97Config::default());
    assert!(matches!(empty, Err(C97Error::NoPicture)));
}

#[test]
fn progress_reaches_its_end_and_cancelling_ends_it() {
    use std::sync::atomic::AtomicU64;

    let (last, all) = (AtomicU64::new(0), AtomicU64::new(0));
    let report = |done, total| {
        assert!(last.swap(done, Ordering::Relaxed) <= done);
        all.store(total, Ordering::Relaxed);
    };
    let config = C97Config { progress: Some(&report), ..C97Config::default() };
    painted_from(FILE, &picture(), &mattes(), &config).unwrap();
    assert_eq!((last.load(Ordering::Relaxed), all.load(Ordering::Relaxed)), (240, 240));
    let cancel = AtomicBool::new(true);
    let config = C97Config { cancel: Some(&cancel), ..C97Config::default() };
    assert!(matches!(painted_from(FILE, &picture(), &mattes(), &config), Err(C97Error::Cancelled)));
}

#[test]
fn a_seam_between_mattes_is_no_line() {
    let gray = Raster::new(WIDTH, HEIGHT, Srgb([0.55, 0.5, 0.45]).to_linear());
    let half = |name: &str, from: usize| Matte {
        name: name.to_owned(),
        coverage: Raster::from_fn(WIDTH, HEIGHT, |x, _| {
            f32::from(u8::from((from..from + WIDTH / 2).contains(&x)))
        }),
    };
    let halves = [half("left", 0), half("right", WIDTH / 2)];
    let text = "format = 1\n[[matte]]\nname = 'left'\npigments = ['burnt-umber']\n\
        [[matte]]\nname = 'right'\npigments = ['burnt-umber']\n";
    let painting = painted_from(text, &gray, &halves, &C97Config::default()).unwrap();
    let mean = |x: usize| -> f32 {
        let rows = 8..HEIGHT - 8;
        let all = painting.glazes.iter().flat_map(|glaze| rows.clone().map(|y| glaze.left.at(x, y)));
        all.sum::<f32>() / rows.len() as f32
    };
    let middle: f32 = (12..20).map(mean).sum::<f32>() / 8.0;
    let seam = (WIDTH / 2 - 3..WIDTH / 2 + 3).map(mean).fold(0.0, f32::max);
    assert!(seam < 1.35 * middle, "{seam} along the seam, {middle} inside");
    assert!(painting.maps.0.keys().any(|name| name.ends_with("-bead.png")), "held by what is lifted");
    let again = painting.document.paint(&Stock::builtin(), &painting.maps, &PaintConfig::default()).unwrap();
    assert_eq!(again.glazes.len(), 2);
}
