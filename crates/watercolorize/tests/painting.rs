//! A photograph's painting is a painting: rims where edges are hard, bare paper where it is reserved, pigment kept to the
//! grain, and the same from its document.

use std::io::Cursor;

use girtin_grid::Raster;
use girtin_optics::LinearRgb;
use girtin_painting::document::Event;
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
        focus: None,
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
    let washes = painting.document.glazes.iter().filter(|glaze| glaze.name.starts_with("wash"));
    assert_eq!(washes.count(), 4);
    assert!(painting.document.glazes.iter().any(|glaze| glaze.name == "accents"));
    for glaze in &painting.painted.glazes {
        for pigment in &glaze.pigments {
            let kept = pigment.laid - pigment.lifted;
            assert!((pigment.total - kept).abs() <= 1e-5 * kept, "{pigment:?}");
        }
        assert!(glaze.pigments.iter().map(|pigment| pigment.total).sum::<f64>() > 0.0);
    }
}

#[test]
fn what_is_reserved_stays_bare() {
    let (photo, params) = (collar(), params());
    let reserve =
        Raster::from_fn(
            40,
            40,
            |x, y| {
                if (12..28).contains(&x) && (12..28).contains(&y) { 1.0 } else { 0.0 }
            },
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

/// A plan is free of resolution, and small.
#[test]
fn the_same_document_is_the_same_painting_finer() {
    let (photo, params) = (collar(), params());
    let painting = paint(&request(&photo, &params));
    let document = &painting.document;
    let marks: usize = document
        .glazes
        .iter()
        .flat_map(|glaze| &glaze.events)
        .map(|event| if let Event::Marks { marks, .. } = event { marks.len() } else { 0 })
        .sum();
    assert!(document.drawing.len() + marks <= 2000 && marks > 0, "{} {marks}", document.drawing.len());
    assert!(painting.maps.0.is_empty() && document.to_json().len() < 2_000_000);
    let mut finer = document.clone();
    finer.sheet.pixels_per_mm *= 3.0;
    let fine = finer.paint(&Stock::builtin(), &painting.maps, &PaintConfig::default()).unwrap().picture();
    let coarse = painting.painted.picture();
    let (mut off, mut crisp) = (0.0f64, 0.0f64);
    for y in 0..coarse.height() {
        for x in 0..coarse.width() {
            let mut mean = [0.0f64; 3];
            for k in 0..9 {
                let color = fine.at(3 * x + k % 3, 3 * y + k / 3).0;
                mean.iter_mut().zip(color).for_each(|(mean, channel)| *mean += channel / 9.0);
            }
            let color = coarse.at(x, y);
            off += LinearRgb(mean).to_lab().ciede2000(color.to_lab());
            if x + 1 < coarse.width() {
                // How much of a step between two pixels the finer picture makes between two of its own.
                let step = |a: LinearRgb, b: LinearRgb| (a.to_lab().l - b.to_lab().l).abs();
                if step(color, coarse.at(x + 1, y)) > 25.0 {
                    let steps = (0..5)
                        .map(|k| step(fine.at(3 * x + k, 3 * y + 1), fine.at(3 * x + k + 1, 3 * y + 1)));
                    let sharpest = steps.fold(0.0, f64::max) / step(color, coarse.at(x + 1, y));
                    crisp = crisp.max(sharpest);
                }
            }
        }
    }
    let off = off / (coarse.width() * coarse.height()) as f64;
    assert!(off < 1.5, "{off}");
    assert!(crisp > 0.7, "contours are crisp at three times the size: {crisp}");
}

/// A dark disc on a light ground.
fn disc() -> Raster<[f32; 3]> {
    Raster::from_fn(240, 200, |x, y| {
        let inside = (x as f32 - 120.0).hypot(y as f32 - 100.0) < 55.0;
        if inside { [0.05, 0.08, 0.25] } else { [0.75, 0.72, 0.6] }
    })
}

#[test]
fn contours_are_hard_and_their_rims_vary() {
    let photo = disc();
    let params = PhotoParams { granulation: 0.0, lost_edges: 0.0, drybrush: 0.0, pencil: 0.0, ..params() };
    let painting = paint(&Request { long_edge: 480, ..request(&photo, &params) });
    let picture = painting.painted.picture().map(|color| color.to_lab().l);
    let at = |angle: f64, radius: f64| {
        let (x, y) = (240.0 + 2.0 * radius * angle.cos(), 200.0 + 2.0 * radius * angle.sin());
        picture.at(x as usize, y as usize)
    };
    let mut rims = Vec::new();
    for k in 0..72 {
        let angle = f64::from(k) * core::f64::consts::TAU / 72.0;
        // Across the contour, from the outside in.
        let across: Vec<f64> = (0..60).map(|k| at(angle, 62.0 - 0.25 * f64::from(k))).collect();
        let step = across.windows(5).map(|pair| pair[0] - pair[4]).fold(0.0, f64::max);
        let (outside, inside) = (across[0], at(angle, 40.0));
        assert!(step > 0.6 * (outside - inside), "soft at {k}: {across:?}");
        let darkest = across.iter().copied().fold(f64::INFINITY, f64::min);
        rims.push((inside - darkest) / (outside - inside));
    }
    let mean = rims.iter().sum::<f64>() / rims.len() as f64;
    let deviation = (rims.iter().map(|rim| (rim - mean).powi(2)).sum::<f64>() / rims.len() as f64).sqrt();
    assert!(deviation > 0.5 * mean.abs(), "{mean} ± {deviation}");
}

#[test]
fn a_light_surface_is_bare_or_painted_as_a_whole() {
    // Two panels on a dark wall, both white for the most part; the gray corner of the first belongs to it.
    let photo = Raster::from_fn(240, 160, |x, y| {
        let [first, second] =
            [20..100, 140..220].map(|columns| columns.contains(&x) && (40..120).contains(&y));
        let light = match (first, second) {
            (true, _) if x < 45 => 0.9,
            (true, _) | (_, true) => 0.96,
            _ => 0.06,
        };
        [light; 3]
    });
    let params = params();
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
