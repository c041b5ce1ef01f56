use super::*;

/// A disc with a soft edge, brighter or darker than what is around it.
fn disc(radius: f64, inside: f32, outside: f32) -> Raster<f32> {
    Raster::from_fn(100, 100, |x, y| {
        let covered = (radius + 0.5 - libm::hypot(x as f64 - 50.0, y as f64 - 50.0)).clamp(0.0, 1.0) as f32;
        outside + covered * (inside - outside)
    })
}

fn off_circle([x, y]: [usize; 2], radius: f64) -> f64 {
    (libm::hypot(x as f64 - 50.0, y as f64 - 50.0) - radius).abs()
}

fn are_neighbours(path: &[[usize; 2]]) -> bool {
    path.windows(2).all(|pair| {
        let [[x0, y0], [x1, y1]] = [pair[0], pair[1]];
        pair[0] != pair[1] && x0.abs_diff(x1) <= 1 && y0.abs_diff(y1) <= 1
    })
}

#[test]
fn the_wire_keeps_to_a_disc() {
    for (radius, inside, outside) in [(30.0, 1.0, 0.0), (30.0, 0.3, 0.5), (12.0, 0.0, 1.0), (41.0, 0.6, 0.5)]
    {
        let mut scissors = Scissors::of_grey(&disc(radius, inside, outside), ScissorsParams::default());
        let side = radius as usize;
        scissors.seed([50 - side, 50]);
        for goal in [[50, 50 - side], [50, 50 + side], [50 + side, 50]] {
            let wire = scissors.path_to(goal);
            assert_eq!((wire[0], *wire.last().unwrap()), ([50 - side, 50], goal));
            assert!(are_neighbours(&wire));
            let worst = wire.iter().map(|&point| off_circle(point, radius)).fold(0.0, f64::max);
            assert!(worst <= 1.0, "radius {radius}, {inside} on {outside}: {worst} off");
        }
    }
}

#[test]
fn two_seeds_make_a_loop_and_its_matte_is_the_disc() {
    let picture = disc(30.0, 0.8, 0.2);
    let scissors = Scissors::of_grey(&picture, ScissorsParams::default());
    for seeds in [vec![[20, 50], [80, 50]], vec![[20, 50], [50, 20], [80, 50], [50, 80]]] {
        let path = scissors.boundary(&seeds);
        assert!(are_neighbours(&path) && are_neighbours(&[path[path.len() - 1], path[0]]));
        let worst = path.iter().map(|&point| off_circle(point, 30.0)).fold(0.0, f64::max);
        assert!(worst <= 1.5, "{worst} off with {} seeds", seeds.len());
        let matte = outline::matte(&path, 100, 100);
        let area: f32 = matte.as_slice().iter().sum();
        assert!((area / (std::f32::consts::PI * 900.0) - 1.0).abs() < 0.03, "area {area}");
        let off: f32 =
            matte.as_slice().iter().zip(picture.as_slice()).map(|(m, p)| (m - (p - 0.2) / 0.6).abs()).sum();
        assert!(off < 0.5 * 188.0, "{off} pixels of 188 along the circle");
    }
}

#[test]
fn the_wire_is_the_cheapest_one() {
    // Dijkstra by another way: relax every link until nothing changes.
    let noise = girtin_grid::noise::Noise::new(1, girtin_grid::random::stage("test"));
    let picture = Raster::from_fn(17, 13, |x, y| {
        noise.fbm([x as f64 / 4.0, y as f64 / 4.0], girtin_grid::noise::Fractal { octaves: 2, gain: 0.5 })
            as f32
    });
    let params = ScissorsParams::default();
    let edges = Edges::of_grey(&picture, params.smoothing);
    let mut wire = LiveWire::new(&edges, [3, 4]);
    wire.path_to(&edges, &params, None, &[], [16, 12]);
    for y in 0..13 {
        for x in 0..17 {
            wire.path_to(&edges, &params, None, &[], [x, y]);
        }
    }
    assert_eq!(live_wire::costs(&wire), live_wire::relaxed_costs(&edges, &params, [3, 4]));
}

#[test]
fn training_prefers_the_outline_it_was_trained_on() {
    // Two rings, the inner one much stronger; the goal lies on the outer one, across from the seed.
    let picture = Raster::from_fn(100, 100, |x, y| {
        let r = libm::hypot(x as f64 - 50.0, y as f64 - 50.0);
        let step = |radius: f64| (radius + 0.5 - r).clamp(0.0, 1.0);
        (0.2 * step(40.0) + 0.8 * step(34.0)) as f32
    });
    let mut scissors = Scissors::of_grey(
        &picture,
        ScissorsParams {
            crossing_weight: 0.1,
            direction_weight: 0.1,
            magnitude_weight: 0.8,
            ..ScissorsParams::default()
        },
    );
    let outer: Vec<[usize; 2]> = (0..64)
        .map(|at| {
            let angle = std::f64::consts::PI + f64::from(at) / 40.0;
            [(50.5 + 40.0 * libm::cos(angle)) as usize, (50.5 + 40.0 * libm::sin(angle)) as usize]
        })
        .collect();
    let share = |scissors: &mut Scissors| {
        scissors.seed([10, 50]);
        let wire = scissors.path_to([90, 50]);
        wire.iter().filter(|&&point| off_circle(point, 40.0) < 2.0).count() as f64 / wire.len() as f64
    };
    let untrained = share(&mut scissors);
    scissors.train(&outer);
    let trained = share(&mut scissors);
    assert!(untrained < 0.5 && trained > 0.95, "{untrained} untrained, {trained} trained");
    scissors.forget();
    assert_eq!(share(&mut scissors), untrained);
}

#[test]
fn snapping_finds_the_edge() {
    let scissors = Scissors::of_grey(&disc(30.0, 1.0, 0.0), ScissorsParams::default());
    for point in [[24, 50], [17, 50], [50, 76]] {
        let found = scissors.snap(point, 6);
        assert!(off_circle(found, 30.0) <= 1.0, "{point:?} to {found:?}");
    }
    assert_eq!(scissors.snap([50, 50], 5), [50, 50], "nothing is near");
}

#[test]
fn a_matte_has_the_area_of_its_outline() {
    let square: Vec<[usize; 2]> = vec![[2, 3], [12, 3], [12, 8], [2, 8]];
    let matte = outline::matte(&square, 20, 12);
    let sum: f32 = matte.as_slice().iter().sum();
    assert!((sum - 50.0).abs() < 0.01, "{sum}");
    assert_eq!((matte.at(5, 5), matte.at(2, 5), matte.at(1, 5)), (1.0, 0.5, 0.0));
    for odd in [vec![], vec![[1, 1]], vec![[1, 1], [5, 9]], vec![[90, 90], [100, 90], [90, 100]]] {
        let sum: f32 = outline::matte(&odd, 10, 10).as_slice().iter().sum();
        assert!(sum.abs() < 1e-6, "{odd:?}");
    }
}

#[test]
fn tiny_and_flat_pictures_are_no_trouble() {
    let mut one = Scissors::of_grey(&Raster::new(1, 1, 0.5), ScissorsParams::default());
    one.seed([7, 7]);
    assert_eq!(one.path_to([9, 0]), [[0, 0]]);
    assert_eq!(one.boundary(&[[3, 3]]), [[0, 0]]);
    let mut none = Scissors::of_grey(&Raster::new(0, 0, 0.5), ScissorsParams::default());
    none.seed([0, 0]);
    assert!(none.path_to([1, 1]).is_empty() && none.boundary(&[[0, 0]]).is_empty());
    assert_eq!(none.snap([0, 0], 3), [0, 0]);
    let mut flat = Scissors::new(&Raster::new(20, 10, LinearRgb::WHITE), ScissorsParams::default());
    assert_eq!(flat.path_to([3, 3]), [[3, 3]], "no seed");
    flat.seed([0, 0]);
    assert_eq!(flat.path_to([19, 9]).len(), 20);
    assert!(flat.boundary(&[]).is_empty());
    let odd = Raster::from_fn(8, 8, |x, _| if x == 3 { f32::NAN } else { 0.0 });
    let mut odd = Scissors::of_grey(&odd, ScissorsParams::default());
    odd.seed([0, 0]);
    assert_eq!(odd.path_to([7, 7]).len(), 8);
}
