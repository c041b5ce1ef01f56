use girtin_grid::noise::{Fractal, Noise};
use girtin_grid::random::stage;
use girtin_optics::Srgb;

use super::*;

fn quarters(width: usize, height: usize) -> Raster<LinearRgb> {
    let noise = Noise::new(1, stage("test"));
    Raster::from_fn(width, height, |x, y| {
        let color = match (2 * x < width, 2 * y < height) {
            (true, true) => [0.5, 0.7, 0.95],
            (false, true) => [0.9, 0.8, 0.2],
            (true, false) => [0.2, 0.5, 0.2],
            (false, false) => [0.6, 0.1, 0.1],
        };
        let ripple = 0.03 * noise.fbm([x as f64 / 9.0, y as f64 / 9.0], Fractal { octaves: 2, gain: 0.5 });
        Srgb(color.map(|channel| channel + ripple)).to_linear()
    })
}

fn worst_sum(mattes: &[Matte]) -> f32 {
    let pixels = mattes[0].coverage.as_slice().len();
    let sum = |at: usize| mattes.iter().map(|matte| matte.coverage.as_slice()[at]).sum::<f32>();
    (0..pixels).map(|at| (sum(at) - 1.0).abs()).fold(0.0, f32::max)
}

#[test]
fn four_quarters_are_four_mattes() {
    let found = mattes(&quarters(120, 80), &MattesParams::default());
    let mut names: Vec<&str> = found.iter().map(|matte| &matte.name[3..]).collect();
    names.sort_unstable();
    assert_eq!(names, ["bottom-left-green", "bottom-right-red", "top-left-light-blue", "top-right-yellow"]);
    for matte in &found {
        let area: f32 = matte.coverage.as_slice().iter().sum();
        assert!((area - 2400.0).abs() < 60.0, "{}: {area}", matte.name);
    }
}

#[test]
fn mattes_add_up_to_one() {
    for (width, height, plan_edge) in [(120, 80, 1000), (200, 150, 60), (41, 97, 16), (3, 500, 100)] {
        let params = MattesParams { plan_edge, regions: 20, min_difference: 2.0, ..MattesParams::default() };
        let found = mattes(&quarters(width, height), &params);
        assert!(worst_sum(&found) < 1e-6, "{}", worst_sum(&found));
        assert!(found.iter().flat_map(|matte| matte.coverage.as_slice()).all(|c| (0.0..=1.0).contains(c)));
    }
}

#[test]
fn edges_of_a_large_picture_are_where_its_colors_change() {
    // Sixteen pixels to one of the plan, whose pixels do not line up with the edge.
    let disc = |x: usize, y: usize| libm::hypot(x as f64 - 310.0, y as f64 - 200.0) - 120.0;
    let picture = Raster::from_fn(640, 400, |x, y| {
        let covered = (0.5 - disc(x, y)).clamp(0.0, 1.0);
        LinearRgb([0.7 - 0.6 * covered, 0.6 - 0.2 * covered, 0.2 + 0.5 * covered])
    });
    let found =
        mattes(&picture, &MattesParams { plan_edge: 160, superpixels: 600, ..MattesParams::default() });
    assert_eq!(found.len(), 2);
    let mut wrong = 0.0;
    for y in 0..400 {
        for x in 0..640 {
            let covered = (0.5 - disc(x, y)).clamp(0.0, 1.0);
            wrong += (f64::from(found[1].coverage.at(x, y)) - covered).abs();
        }
    }
    let around = 2.0 * std::f64::consts::PI * 120.0;
    assert!(wrong < 0.5 * around, "{} pixels off along the edge", wrong / around);
}

#[test]
fn every_size_and_any_color_works() {
    for (width, height) in [(1, 1), (1, 9), (2, 2), (400, 1)] {
        let found = mattes(&quarters(width, height), &MattesParams::default());
        assert!(!found.is_empty() && worst_sum(&found) < 1e-6);
    }
    assert!(mattes(&Raster::new(0, 0, LinearRgb::WHITE), &MattesParams::default()).is_empty());
    let flat = mattes(&Raster::new(50, 40, LinearRgb::WHITE), &MattesParams::default());
    assert_eq!((flat.len(), flat[0].name.as_str()), (1, "01-middle-white"));
    let odd = Raster::from_fn(30, 30, |x, _| LinearRgb([f64::NAN, x as f64, -3.0]));
    assert!(worst_sum(&mattes(&odd, &MattesParams::default())) < 1e-6);
}

#[test]
fn no_more_regions_than_asked_for_and_none_too_small() {
    let noise = Noise::new(2, stage("test"));
    let picture = Raster::from_fn(150, 100, |x, y| {
        let at = [x as f64 / 14.0, y as f64 / 14.0];
        let channel = |shift: f64| 0.5 + 0.5 * noise.gradient([at[0] + shift, at[1]]);
        Srgb([channel(0.0), channel(40.0), channel(80.0)]).to_linear()
    });
    for regions in [1, 2, 7, 25] {
        let params = MattesParams { regions, min_share: 0.01, ..MattesParams::default() };
        let plan = MattePlan::new(&picture, &params);
        assert!(plan.names().len() <= regions as usize);
        for region in 0..plan.names().len() {
            let area: f32 = plan.matte(&picture, region).coverage.as_slice().iter().sum();
            assert!(area > 0.008 * 15_000.0, "{area}");
        }
    }
}

#[test]
fn threads_change_nothing() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            mattes(&quarters(130, 90), &MattesParams { plan_edge: 70, ..MattesParams::default() })
        })
    };
    assert!(run(1) == run(2) && run(1) == run(7));
}
