//! Scissors on photographs: the wire between points of an outline that a person sees stays on it.
//!
//! The outlines were drawn by eye over the enlarged pictures, to about a pixel. Hair and iris were drawn with the wire to be
//! seen, so these two hold what was looked at and found right rather than a drawing made apart; the collar's was drawn
//! without it.

use std::io::Cursor;

use girtin_grid::Raster;
use girtin_optics::LinearRgb;
use girtin_painting::picture::{PictureLimits, read_photo};
use girtin_watercolorize::scissors::{Scissors, ScissorsParams, outline};

/// How far from the drawn outline a wire may lie, pixels: what the eye is unsure of, and a soft edge's width.
const NEAR: f64 = 2.5;

fn scissors(bytes: &[u8]) -> (Scissors, Raster<LinearRgb>) {
    let photo = read_photo(Cursor::new(bytes), None, &PictureLimits::default(), LinearRgb::WHITE)
        .unwrap()
        .pixels
        .map(|color| LinearRgb(color.map(f64::from)));
    (Scissors::new(&photo, ScissorsParams::default()), photo)
}

fn distance([x, y]: [usize; 2], outline: &[[f64; 2]]) -> f64 {
    let to = |pair: &[[f64; 2]]| {
        let ([x0, y0], [x1, y1]) = (pair[0], pair[1]);
        let (x, y, dx, dy) = (x as f64 + 0.5 - x0, y as f64 + 0.5 - y0, x1 - x0, y1 - y0);
        let along = ((x * dx + y * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
        (x - along * dx).hypot(y - along * dy)
    };
    outline.windows(2).map(to).fold(f64::INFINITY, f64::min)
}

fn farthest(wire: &[[usize; 2]], outline: &[[f64; 2]]) -> f64 {
    wire.iter().map(|&point| distance(point, outline)).fold(0.0, f64::max)
}

const COLLAR: &[u8] = include_bytes!("photos/astronaut-collar.png");
const EYE: &[u8] = include_bytes!("photos/chelsea-eye.png");

const IRIS: [[f64; 2]; 20] = [
    [20.0, 41.0],
    [22.8, 50.5],
    [27.8, 59.4],
    [35.5, 67.0],
    [44.4, 72.0],
    [55.5, 73.1],
    [66.7, 68.9],
    [75.5, 61.1],
    [80.5, 52.2],
    [82.2, 45.5],
    [79.4, 34.4],
    [74.4, 27.2],
    [66.7, 20.0],
    [55.5, 16.7],
    [44.4, 16.1],
    [33.3, 16.5],
    [30.0, 17.6],
    [25.5, 22.8],
    [21.1, 31.0],
    [20.0, 41.0],
];

#[test]
fn the_wire_follows_a_collar_from_a_hasty_seed() {
    let ring = [
        [69.6, 146.7],
        [73.3, 142.0],
        [78.3, 137.9],
        [85.8, 133.8],
        [93.3, 130.8],
        [101.7, 129.0],
        [108.3, 128.2],
        [123.3, 128.2],
    ];
    let (mut scissors, _) = scissors(COLLAR);
    scissors.seed(scissors.snap([74, 144], 3));
    let wire = scissors.path_to(scissors.snap([120, 128], 4));
    assert!(wire.len() > 40);
    assert!(farthest(&wire, &ring) < NEAR, "{} off: {wire:?}", farthest(&wire, &ring));
}

#[test]
fn the_wire_follows_hair_before_a_mottled_ground() {
    let hair = [
        [130.5, 14.2],
        [112.4, 23.3],
        [96.9, 37.6],
        [93.8, 49.2],
        [94.8, 66.0],
        [95.6, 79.8],
        [103.3, 92.0],
        [111.0, 98.5],
    ];
    let (mut scissors, _) = scissors(COLLAR);
    scissors.seed(scissors.snap([130, 15], 4));
    let wire = scissors.path_to(scissors.snap([110, 96], 4));
    assert!(wire.len() > 80);
    assert!(farthest(&wire, &hair) < NEAR, "{} off: {wire:?}", farthest(&wire, &hair));
}

#[test]
fn four_seeds_cut_out_an_iris() {
    let (scissors, photo) = scissors(EYE);
    let seeds = [[20, 40], [47, 17], [83, 48], [52, 72]].map(|seed| scissors.snap(seed, 1));
    let path = scissors.boundary(&seeds);
    assert!(farthest(&path, &IRIS) < NEAR, "{} off: {path:?}", farthest(&path, &IRIS));
    let matte = outline::matte(&path, photo.width(), photo.height());
    // Green and gold inside, fur outside.
    let mean = |inside: bool| {
        let (mut sum, mut all) = ([0.0; 2], 0.0);
        for (color, &covered) in photo.as_slice().iter().zip(matte.as_slice()) {
            let weight = f64::from(if inside { covered } else { 1.0 - covered });
            let lab = color.to_lab();
            sum = [sum[0] + weight * lab.a, sum[1] + weight * lab.b];
            all += weight;
        }
        sum.map(|sum| sum / all)
    };
    assert!(mean(true)[0] + 5.0 < mean(false)[0], "{:?} and {:?}", mean(true), mean(false));
    let area: f32 = matte.as_slice().iter().sum();
    assert!((2400.0..3200.0).contains(&area), "{area}");
}

#[test]
fn all_the_way_round_the_path_is_closed_and_meets_itself_nowhere() {
    let (scissors, _) = scissors(EYE);
    let path = scissors.boundary(&[[20, 40], [47, 17], [83, 48], [52, 72]]);
    let mut sorted = path.clone();
    sorted.sort_unstable();
    sorted.dedup();
    assert_eq!(sorted.len(), path.len());
    for (at, &[x, y]) in path.iter().enumerate() {
        let [nx, ny] = path[(at + 1) % path.len()];
        assert!(x.abs_diff(nx) <= 1 && y.abs_diff(ny) <= 1, "{at}");
    }
}
