//! Six photographs painted small, against their pictures in `fidelity/golden/photos`, and what painters' statistics say of
//! them: a change of looks is to be seen.
//!
//! With `GIRTIN_WRITE_GOLDENS=1` the pictures are written instead, and the test fails, so that nobody forgets to look.

use std::fs::File;
use std::io::Cursor;
use std::path::Path;

use girtin_grid::Raster;
use girtin_optics::{LinearRgb, Srgb};
use girtin_painting::Stock;
use girtin_painting::composite;
use girtin_painting::picture::{PictureLimits, PictureMeta, read_photo, write_png};
use girtin_watercolorize::{Mounting, PhotoParams, Request, Watch, watercolorize};

const PHOTOS: [(&str, &[u8]); 6] = [
    ("astronaut", include_bytes!("photos/astronaut.jpg")),
    ("chelsea", include_bytes!("photos/chelsea.jpg")),
    ("china", include_bytes!("photos/china.jpg")),
    ("cove", include_bytes!("photos/cove.jpg")),
    ("mountains", include_bytes!("photos/mountains.jpg")),
    ("tulips", include_bytes!("photos/tulips.jpg")),
];

/// Cells of the plan, and pixels of the picture, along the long edge.
const SIZE: u32 = 240;
/// Mean difference from a golden picture that is rounding, CIEDE2000.
const ROUNDING: f64 = 0.3;

fn painted(bytes: &[u8]) -> Raster<[u8; 3]> {
    let photo =
        read_photo(Cursor::new(bytes), None, &PictureLimits::default(), LinearRgb::WHITE).unwrap().pixels;
    let params = PhotoParams { plan_cells: SIZE, ..PhotoParams::default() };
    let request = Request {
        photo: &photo,
        pixels: [photo.width(), photo.height()],
        params: &params,
        palette: None,
        paper: "cold-press",
        mounting: Mounting { long_edge_mm: 120.0, margin: 0.0, ..Mounting::default() },
        seed: 1,
        long_edge: SIZE,
        reserve: None,
        detail_map: None,
        focus: None,
        title: "",
    };
    let painting = watercolorize(&request, &Stock::builtin(), &Watch::default()).unwrap();
    composite::encode(&painting.painted.picture())
}

fn lab(color: [u8; 3]) -> girtin_optics::Lab {
    Srgb::from_bytes(color).to_linear().to_lab()
}

/// Shares of a picture that real sheets keep within bounds.
#[derive(Debug)]
struct Statistics {
    /// Median lightness, Lab L.
    key: f64,
    /// Part that is darker than L 30.
    darks: f64,
    /// Part that is bare or nearly so, L above 92.
    whites: f64,
    /// Part of neighbors that differ by more than 12, Lab L: hard contours.
    contours: f64,
    /// Of places where tone changes, over two pixels, by more than 12, those where nearly all of it is between two neighbors.
    hard: f64,
}

fn statistics(picture: &Raster<[u8; 3]>) -> Statistics {
    let tones = picture.map(|color| lab(color).l);
    let all = tones.as_slice().len() as f64;
    let mut sorted: Vec<f64> = tones.as_slice().to_vec();
    sorted.sort_by(f64::total_cmp);
    let share = |is: &dyn Fn(f64) -> bool| sorted.iter().filter(|&&tone| is(tone)).count() as f64 / all;
    let (mut contours, mut steps, mut hard) = (0.0, 0.0, 0.0);
    for y in 0..tones.height() {
        for x in 0..tones.width() - 3 {
            let four = [0, 1, 2, 3].map(|k| tones.at(x + k, y));
            let step = (four[2] - four[1]).abs();
            let over = (four[3] - four[0]).abs();
            contours += f64::from(u8::from(step > 12.0));
            let is_steepest = step >= (four[1] - four[0]).abs() && step >= (four[3] - four[2]).abs();
            if over > 12.0 && is_steepest {
                steps += 1.0;
                hard += f64::from(u8::from(step > 0.55 * over));
            }
        }
    }
    Statistics {
        key: sorted[sorted.len() / 2],
        darks: share(&|tone| tone < 30.0),
        whites: share(&|tone| tone > 92.0),
        contours: contours / all,
        hard: hard / f64::max(steps, 1.0),
    }
}

#[test]
fn photographs_are_painted_as_they_were() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fidelity/golden/photos");
    let writing = std::env::var_os("GIRTIN_WRITE_GOLDENS").is_some();
    let mut changed = Vec::new();
    for (name, bytes) in PHOTOS {
        let picture = painted(bytes);
        let found = statistics(&picture);
        println!("{name}: {found:.3?}");
        let is_painting = found.key > 45.0
            && found.darks < 0.35
            && found.whites < 0.5
            && (0.008..0.15).contains(&found.contours)
            && found.hard > 0.55;
        assert!(is_painting, "{name}: {found:?}");
        let path = folder.join(format!("{name}.png"));
        if writing {
            write_png(File::create(&path).unwrap(), &picture, &PictureMeta::default()).unwrap();
            continue;
        }
        let expected = File::open(&path).unwrap();
        let expected =
            read_photo(std::io::BufReader::new(expected), None, &PictureLimits::default(), LinearRgb::WHITE)
                .unwrap()
                .pixels
                .map(|color| LinearRgb(color.map(f64::from)));
        assert_eq!(
            [expected.width(), expected.height()],
            [picture.width(), picture.height()],
            "{name}: size"
        );
        let pairs = expected.as_slice().iter().zip(picture.as_slice());
        let off: f64 = pairs.map(|(a, b)| a.to_lab().ciede2000(lab(*b))).sum();
        let off = off / picture.as_slice().len() as f64;
        if off > ROUNDING {
            changed.push(format!("{name} by {off:.2}"));
            let file =
                File::create(Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.png"))).unwrap();
            write_png(file, &picture, &PictureMeta::default()).unwrap();
        }
    }
    assert!(!writing, "goldens written: look at them, then run the tests without GIRTIN_WRITE_GOLDENS");
    assert!(changed.is_empty(), "changed: {changed:?}; see {}", env!("CARGO_TARGET_TMPDIR"));
}
