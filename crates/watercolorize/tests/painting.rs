//! A photograph's painting is a painting: rims where edges are hard, bare paper where it is reserved, pigment kept to the
//! grain, and the same from its document.

use std::io::Cursor;

use girtin_grid::Raster;
use girtin_optics::LinearRgb;
use girtin_painting::picture::{PictureLimits, read_photo};
use girtin_painting::{PaintConfig, Stock};
use girtin_watercolorize::{Mounting, Painting, PhotoParams, Request, Watch, watercolorize};

const COLLAR: &[u8] = include_bytes!("photos/astronaut-collar.png");

fn collar() -> Raster<[f32; 3]> {
    read_photo(Cursor::new(COLLAR), None, &PictureLimits::default(), LinearRgb::WHITE).unwrap().pixels
}

/// Small, so that it is quick.
fn params() -> PhotoParams {
    PhotoParams { plan_cells: 240, ..PhotoParams::default() }
}

fn request<'a>(photo: &'a Raster<[f32; 3]>, params: &'a PhotoParams) -> Request<'a> {
    Request {
        photo,
        pixels: [photo.width(), photo.height()],
        params,
        palette: None,
        paper: "fine-grain",
        mounting: Mounting { long_edge_mm: 60.0, margin: 0.0, ..Mounting::default() },
        seed: 5,
        long_edge: 300,
        reserve: None,
        detail_map: None,
        title: "",
    }
}

fn paint(request: &Request<'_>) -> Painting {
    watercolorize(request, &Stock::builtin(), &Watch::default()).unwrap()
}

fn bytes(painting: &Painting) -> Vec<[u8; 3]> {
    painting.painted.development().encoded(|color| color.to_srgb().to_bytes()).into_vec()
}

#[test]
fn its_document_paints_the_same_picture_on_any_number_of_threads() {
    let (photo, params) = (collar(), params());
    let painting = paint(&request(&photo, &params));
    let picture = bytes(&painting);
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert!(pool.install(|| bytes(&paint(&request(&photo, &params)))) == picture, "{threads} threads");
    }
    let again = painting.document.paint(&Stock::builtin(), &painting.maps, &PaintConfig::default()).unwrap();
    assert!(again.development().encoded(|color| color.to_srgb().to_bytes()).into_vec() == picture);
}

#[test]
fn every_pigment_is_where_it_was_laid() {
    let (photo, params) = (collar(), params());
    let painting = paint(&request(&photo, &params));
    assert_eq!(painting.painted.glazes.len(), 4);
    for glaze in &painting.painted.glazes {
        for pigment in &glaze.pigments {
            let kept = pigment.laid - pigment.lifted;
            assert!((pigment.total - kept).abs() <= 1e-5 * kept, "{pigment:?}");
        }
    }
}

#[test]
fn what_is_reserved_stays_bare() {
    let (photo, params) = (collar(), PhotoParams { relief: 0.0, ..params() });
    let reserve =
        Raster::from_fn(
            40,
            40,
            |x, y| if (12..28).contains(&x) && (12..28).contains(&y) { 1.0 } else { 0.0 },
        );
    let painting = paint(&Request { reserve: Some(&reserve), ..request(&photo, &params) });
    let picture = painting.painted.picture();
    let (width, height) = (picture.width(), picture.height());
    for y in height * 14 / 40..height * 26 / 40 {
        for x in width * 14 / 40..width * 26 / 40 {
            assert_eq!(picture.at(x, y), painting.document.sheet.ground, "{x} {y}");
        }
    }
}

/// A dark half whose border is so many pixels wide.
fn halves(wide: f32) -> Raster<[f32; 3]> {
    Raster::from_fn(300, 300, |x, _| {
        let light = ((x as f32 - 150.0) / wide + 0.5).clamp(0.0, 1.0);
        [0.03 + 0.6 * light, 0.08 + 0.62 * light, 0.3 + 0.5 * light]
    })
}

/// Pigment of all washes at the border of the dark half, over what lies inside it.
fn rim(photo: &Raster<[f32; 3]>) -> f64 {
    let params = PhotoParams {
        detail: 0.0,
        charging: 0.0,
        turbulence: 0.0,
        granulation: 0.0,
        wobble: 0.0,
        slivers: 0.0,
        ..params()
    };
    let painting = paint(&request(photo, &params));
    let cells = painting.painted.sheet.height.width();
    let amount = |columns: std::ops::Range<usize>| {
        let mut sum = 0.0;
        for glaze in &painting.painted.glazes {
            for amounts in &glaze.dried.amounts {
                for y in cells / 4..cells * 3 / 4 {
                    sum += amounts.row(y)[columns.clone()].iter().map(|a| f64::from(*a)).sum::<f64>();
                }
            }
        }
        sum / columns.len() as f64
    };
    let middle = cells / 2;
    let near = (middle - 5..middle).map(|x| amount(x..x + 1)).fold(0.0, f64::max);
    near / amount(middle - 30..middle - 15)
}

#[test]
fn rims_are_dark_where_edges_are_hard_and_nowhere_else() {
    let (hard, soft) = (rim(&halves(1.0)), rim(&halves(160.0)));
    assert!(hard > 1.15, "hard: {hard}");
    assert!(soft < 1.02, "soft: {soft}");
}

#[test]
fn a_light_surface_is_bare_or_painted_as_a_whole() {
    // Two panels on a dark wall, both white for the most part; the gray corner of the first belongs to it.
    let photo = Raster::from_fn(240, 160, |x, y| {
        let [first, second] =
            [20..100, 140..220].map(|columns| columns.contains(&x) && (40..120).contains(&y));
        let light = match (first, second) {
            (true, _) if x < 45 => 0.78,
            (true, _) | (_, true) => 0.96,
            _ => 0.06,
        };
        [light; 3]
    });
    let params = PhotoParams { slivers: 0.0, ..params() };
    let painting = paint(&request(&photo, &params));
    let picture = painting.painted.development().picture();
    let scale = picture.width() as f64 / 240.0;
    let at = |x: f64, y: f64| picture.at((x * scale) as usize, (y * scale) as usize).0[1];
    for y in [60.0, 80.0, 100.0] {
        let [corner, white, other] = [32.0, 75.0, 180.0].map(|x| at(x, y));
        assert!((corner - white).abs() < 0.06 && (white - other).abs() < 0.06, "{corner} {white} {other}");
        assert!(white > 0.88, "{white}");
    }
}
