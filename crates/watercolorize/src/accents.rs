//! What a pointed brush sets at the end: the darkest darks, and lights that stay bare.
//!
//! Both are lines and spots that differ from both of their sides. A hat finds them: the lightness closed by a disc less
//! the lightness itself is how much darker a place is than all around; the same with an opening for lights. Differences of
//! Gaussians would put a light band beside every dark edge.

use girtin_grid::Raster;
use girtin_grid::blur::gaussian_plane;
use girtin_grid::morphology::{closed_by_disc, opened_by_disc};
use rayon::prelude::*;

use crate::accidents::smoothstep;
use crate::attention::quantiles;
use crate::tracer::{Line, Trace, Tracing, lines, mean};

/// Lengths here are parts of the long edge, steps of lightness are Lab L.
///
/// Radius of the disc that darks are narrower than.
const DARK_RADIUS: f64 = 0.007;
/// The same for lights.
const LIGHT_RADIUS: f64 = 0.009;
/// Shortest dark and light, their width included.
const LEAST_LENGTHS: [f64; 2] = [0.007, 0.006];
/// Widths of darks: a dark may be a hair.
const DARK_WIDTHS: [f64; 2] = [0.0018, 0.012];
/// Widths of lights: a brush leaves out less finely than it draws.
const LIGHT_WIDTHS: [f64; 2] = [0.0024, 0.012];
/// How far a hand smooths over lines.
const SMOOTHING: f64 = 0.0025;
/// Contrasts from which on something is drawn: the next one where the last left too few candidates.
const DARK_STEPS: [f32; 4] = [11.0, 9.0, 7.5, 6.0];
const LIGHT_STEPS: [f32; 4] = [9.0, 7.5, 6.0, 5.0];
/// Enough candidates, parts of the most that are drawn.
const ENOUGH: [f32; 2] = [0.7, 0.85];
/// How much more contrast it takes where nobody looks, and in foliage there.
const DARK_UNSEEN: [f32; 2] = [8.0, 16.0];
const LIGHT_UNSEEN: [f32; 2] = [5.0, 9.0];
/// Foliage is as good as unseen by this much at least: its marks come from a rule, and lines in it cross at random.
const FOLIAGE_LOOSE: f32 = 0.5;
/// How much more it takes for each step of contrast that is mean around: one of many alike is texture.
const TEXTURE: f32 = 0.75;
/// How far around that is.
const TEXTURE_REACH: f64 = 0.02;
/// How much less it takes for a dark of a face.
const FACE: f32 = 2.0;
/// Lightest dark.
const DARK_BELOW: f32 = 72.0;
/// Lights are in the lightest 40 % of the picture, and at least so light; spots in the lightest 20 %. The lightest 3 % are
/// white.
const LIGHT_SHARES: [f64; 3] = [0.6, 0.8, 0.97];
const LIGHT_ABOVE: f32 = 48.0;
/// Least part of the way from the mass around to the picture's white that a light goes: bare paper goes all of it, and of
/// half lights it makes chips. A long line may do with less.
const LIGHT_WAY: [f32; 2] = [0.42, 0.3];
/// A light shorter than so many widths, and than this, is a spot.
const SPOT: [f32; 2] = [2.2, 0.012];
/// Length over width of a long line.
const LONG: f32 = 9.0;
/// A light in more foliage than this, no lighter than a light mass so near but for a step of this, is a gap in it.
const GAP_FOLIAGE: f32 = 0.2;
const GAP_REACH: [f64; 3] = [0.014, 0.028, 0.05];
const GAP_STEP: f32 = 8.0;
/// Strongest color of a light: bare paper has none.
const LIGHT_CHROMA: f32 = 34.0;
/// Half of the length over which a line must go on to count as one, and the part of the usual contrast it then needs.
const LINE_REACH: f64 = 0.011;
const LINE_STEP: f32 = 0.7;
/// The part of the unseen contrast that a line needs: rigging is seen although nobody looks at it.
const LINE_UNSEEN: f32 = 0.4;
/// The part of what texture takes: whiskers stand out from fur, but any texture has rows in it.
const LINE_TEXTURE: f32 = 0.65;
/// Least contrast of a line's single cells, as a part of the line's.
const LINE_CELLS: f32 = 0.45;
/// One cell counts so much at most towards a line: a spot is no line.
const LINE_CAP: f32 = 24.0;
/// How many strokes there may be within how far.
const ROOM: f32 = 0.03;
const CROWDS: [usize; 2] = [6, 4];
/// How far beside its edge a light is compared with what is around.
const BESIDE: [f64; 2] = [0.0030, 0.0055];

/// Dark accents, the most important first: at most `most`.
///
/// # Source
/// `accents` of the planner's second prototype; lines are its own.
///
/// # Shapes and units
/// `lightness`: Lab L, blurred by no more than a thousandth of `long_edge`. `attention`, `foliage`, `face`: 0 to 1. All of one
/// size. `long_edge`: cells.
///
/// # Guarantees
/// No more than 6 within 0.03 of the long edge (`accents_do_not_crowd`); none in an even gradient (`a_gradient_has_none`).
///
/// # Panics
/// The sizes differ.
pub fn darks(
    lightness: &Raster<f32>,
    attention: &Raster<f32>,
    foliage: &Raster<f32>,
    face: &Raster<f32>,
    long_edge: f64,
    most: usize,
) -> Vec<Trace> {
    let closed = closed_by_disc(lightness, (DARK_RADIUS * long_edge) as f32);
    let hat = Hat::of(between(&closed, lightness), long_edge);
    let over = hat.over(|x, y| {
        let loose = loose(attention, x, y);
        [
            DARK_UNSEEN[0] * loose * loose.sqrt().sqrt() - FACE * face.at(x, y),
            DARK_UNSEEN[1] * foliage.at(x, y) * loose.max(FOLIAGE_LOOSE)
                - TEXTURE * face.at(x, y) * hat.around.at(x, y),
        ]
    });
    let tracing = tracing(LEAST_LENGTHS[0], DARK_WIDTHS, long_edge);
    let s = long_edge as f32;
    let mut found = Vec::new();
    for step in DARK_STEPS {
        let mask = Raster::by_rows(lightness.width(), lightness.height(), |x, y| {
            over.at(x, y) > step && lightness.at(x, y) < DARK_BELOW
        });
        found = lines(&mask, &hat.contrast, &tracing)
            .iter()
            .flat_map(|line| in_faces(line, face, &tracing))
            .filter_map(|line| line.stroke(&hat.contrast, &tracing))
            .filter(|dark| dark.length > (0.006 + 0.016 * (1.0 - along(dark, attention))) * s)
            .collect();
        if found.len() as f32 > ENOUGH[0] * most as f32 {
            break;
        }
    }
    let rank = |dark: &Trace| {
        let seen = along(dark, attention);
        dark.score * (0.2 + 1.2 * seen * seen)
    };
    spaced(found, rank, CROWDS[0], long_edge, most)
}

/// Lights, the most important first: at most `most`.
///
/// # Source
/// `lights` of the planner's second prototype; lines, and the comparison with both sides, are its own.
///
/// # Shapes and units
/// As [`darks`]. `chroma`: Lab C. `plain`: Lab L of the mass that the light is left out of. `sky`: 0 to 1.
///
/// # Guarantees
/// Each is in the lightest 40 % of the picture and lighter than both of its sides along most of its length
/// (`the_light_side_of_an_edge_is_none`).
///
/// # Panics
/// The sizes differ.
#[expect(clippy::too_many_arguments, reason = "one plane each, and none without the others")]
pub fn lights(
    lightness: &Raster<f32>,
    chroma: &Raster<f32>,
    attention: &Raster<f32>,
    foliage: &Raster<f32>,
    face: &Raster<f32>,
    plain: &Raster<f32>,
    sky: &Raster<f32>,
    long_edge: f64,
    most: usize,
) -> Vec<Trace> {
    let s = long_edge as f32;
    // A wider disc takes away more.
    let masses = opened_by_disc(lightness, (LIGHT_RADIUS * long_edge) as f32);
    let hat = Hat::of(between(lightness, &masses), long_edge);
    let over = hat.over(|x, y| {
        let loose = loose(attention, x, y);
        [LIGHT_UNSEEN[0] * loose, LIGHT_UNSEEN[1] * foliage.at(x, y) * loose]
    });
    let sample = lightness.as_slice().iter().copied().step_by(5);
    let [light, lightest, white] = quantiles(sample, LIGHT_SHARES);
    let light = light.max(LIGHT_ABOVE);
    let near_sky = gaussian_plane(sky, 0.004 * long_edge);
    // The part of the way to white.
    let way = |light: &Trace| {
        let plain = along(light, plain);
        (along(light, lightness) - plain) / (white - plain).max(10.0)
    };
    let tracing = tracing(LEAST_LENGTHS[1], LIGHT_WIDTHS, long_edge);
    let beside = BESIDE.map(|by| (by * long_edge) as f32);
    let mut found = Vec::new();
    for step in LIGHT_STEPS {
        let mask = Raster::by_rows(lightness.width(), lightness.height(), |x, y| {
            over.at(x, y) > step && lightness.at(x, y) > light && chroma.at(x, y) < LIGHT_CHROMA
        });
        found = lines(&mask, &hat.contrast, &tracing)
            .iter()
            .flat_map(|line| lighter_parts(line, lightness, beside, 0.6 * step, &tracing))
            .filter_map(|line| line.stroke(&hat.contrast, &tracing))
            .filter(|light| {
                let seen = along(light, attention);
                let width = light.widths.iter().fold(0.0f32, |most, &width| most.max(width));
                let is_spot = light.length < (SPOT[0] * width).max(SPOT[1] * s);
                let is_long = light.length > LONG * width;
                let is_gap = along(light, foliage) > GAP_FOLIAGE
                    && lightest_near(light, &masses, long_edge) > along(light, lightness) - GAP_STEP;
                let is_bright =
                    along(light, lightness) > lightest && light.contrast > 15.0 + 8.0 * (1.0 - seen);
                (!is_spot || is_bright)
                    && (seen > 0.3 || light.contrast > 13.0 || is_long)
                    && way(light) > LIGHT_WAY[usize::from(is_long)]
                    && !is_gap
                    && light.length > (0.006 + 0.008 * (1.0 - seen)) * s
                    && along(light, plain) < 85.0
                    && along(light, sky) < 0.3
                    && along(light, &near_sky) < 0.25
                    && along(light, face) < 0.3
            })
            .collect();
        if found.len() as f32 > ENOUGH[1] * most as f32 {
            break;
        }
    }
    let rank = |light: &Trace| {
        light.score
            * way(light)
            * (0.35 + along(light, attention))
            * (0.4 + smoothstep(-along(light, plain), -95.0, -60.0))
    };
    spaced(found, rank, CROWDS[1], long_edge, most)
}

fn tracing(least_length: f64, widths: [f64; 2], long_edge: f64) -> Tracing {
    let cells = |part: f64| (part * long_edge) as f32;
    Tracing { least_length: cells(least_length), widths: widths.map(cells), smoothing: cells(SMOOTHING) }
}

fn loose(attention: &Raster<f32>, x: usize, y: usize) -> f32 {
    1.0 - attention.at(x, y).clamp(0.0, 1.0)
}

fn between(more: &Raster<f32>, less: &Raster<f32>) -> Raster<f32> {
    Raster::by_rows(more.width(), more.height(), |x, y| more.at(x, y) - less.at(x, y))
}

/// Mean of a plane along a stroke.
fn along(stroke: &Trace, plane: &Raster<f32>) -> f32 {
    mean(stroke.points.iter().map(|&[x, y]| plane.sample(x, y)))
}

/// The lightest mass around the middle of a stroke.
fn lightest_near(light: &Trace, masses: &Raster<f32>, long_edge: f64) -> f32 {
    const LOOKS: usize = 12;
    let [x, y] = light.points[light.points.len() / 2];
    let looks = (0..LOOKS).flat_map(|k| GAP_REACH.map(|reach| (k as f32, (reach * long_edge) as f32)));
    looks.fold(0.0, |most, (k, reach)| {
        let angle = core::f32::consts::TAU * k / LOOKS as f32;
        most.max(masses.sample(x + reach * libm::cosf(angle), y + reach * libm::sinf(angle)))
    })
}

/// How much each cell differs from what is around it, and how much the straight line through it does.
struct Hat {
    contrast: Raster<f32>,
    line: Raster<f32>,
    /// Mean contrast around.
    around: Raster<f32>,
}

impl Hat {
    /// Directions in which lines are sought: between them a line of 25 cells is missed by 1.6 cells at its ends.
    const DIRECTIONS: usize = 12;
    /// Cells between two looks along a line.
    const STRIDE: f32 = 1.5;
    /// Contrast from which on a cell is looked at.
    const LEAST: f32 = 2.0;

    fn of(contrast: Raster<f32>, long_edge: f64) -> Self {
        let (width, height) = (contrast.width(), contrast.height());
        let reach = (LINE_REACH * long_edge) as f32;
        let border = reach as usize + 1;
        let stride = width + 2 * border;
        let mut capped = vec![0.0f32; stride * (height + 2 * border)];
        for y in 0..height {
            let row = &mut capped[(y + border) * stride + border..][..width];
            row.iter_mut().zip(contrast.row(y)).for_each(|(capped, value)| *capped = value.min(LINE_CAP));
        }
        let looks = (reach / Self::STRIDE) as isize;
        let ways: Vec<Vec<isize>> = (0..Self::DIRECTIONS)
            .map(|k| {
                let angle = core::f32::consts::PI * k as f32 / Self::DIRECTIONS as f32;
                let (cos, sin) = (libm::cosf(angle), libm::sinf(angle));
                let look = |t: isize| {
                    let t = t as f32 * Self::STRIDE;
                    (t * sin).round() as isize * stride as isize + (t * cos).round() as isize
                };
                (-looks..=looks).map(look).collect()
            })
            .collect();
        let mut line = contrast.clone();
        line.as_mut_slice().par_chunks_mut(width.max(1)).enumerate().for_each(|(y, row)| {
            for (x, value) in row.iter_mut().enumerate() {
                if *value < Self::LEAST {
                    *value = 0.0;
                    continue;
                }
                let here = ((y + border) * stride + x + border) as isize;
                let sum = |way: &Vec<isize>| way.iter().map(|by| capped[(here + by) as usize]).sum::<f32>();
                *value = ways.iter().map(sum).fold(0.0, f32::max) / (2 * looks + 1) as f32;
            }
        });
        let around = gaussian_plane(&contrast, TEXTURE_REACH * long_edge);
        Self { contrast, line, around }
    }

    /// By how much each cell has more contrast than it `takes` as nobody looks there, and as it is foliage: its own, or with
    /// less asked for its line's.
    fn over(&self, takes: impl Fn(usize, usize) -> [f32; 2] + Sync) -> Raster<f32> {
        Raster::by_rows(self.contrast.width(), self.contrast.height(), |x, y| {
            let (own, line) = (self.contrast.at(x, y), self.line.at(x, y));
            let [unseen, foliage] = takes(x, y);
            let texture = TEXTURE * self.around.at(x, y);
            let as_line = line - LINE_UNSEEN * unseen - LINE_TEXTURE * texture - foliage;
            let as_line = if own > LINE_CELLS * line { as_line / LINE_STEP } else { 0.0 };
            (own - unseen - texture - foliage).max(as_line)
        })
    }
}

/// The parts of a dark line that a face may have: features lie across, and what runs down from them is a drip.
fn in_faces(line: &Line, face: &Raster<f32>, tracing: &Tracing) -> Vec<Line> {
    if line.contrast(face) < 0.5 {
        return vec![line.clone()];
    }
    let lies = |at: usize| {
        let [dx, dy] = line.direction(at);
        dy.abs() < 1.4 * dx.abs()
    };
    runs(line, lies, tracing)
}

/// The parts of a line where it is lighter than what is on both sides of it.
fn lighter_parts(
    line: &Line,
    lightness: &Raster<f32>,
    beside: [f32; 2],
    by: f32,
    tracing: &Tracing,
) -> Vec<Line> {
    let is_lighter = |at: usize| {
        let ([x, y], [dx, dy]) = (line.points[at], line.direction(at));
        let here = lightness.sample(x, y);
        // The darker of a place near and one further off: an edge that is blurred, and one line beside another.
        [1.0, -1.0].into_iter().all(|side| {
            beside.into_iter().any(|off| {
                let off = side * (0.5 * line.widths[at] + off);
                here - lightness.sample(x - off * dy, y + off * dx) > by
            })
        })
    };
    runs(line, is_lighter, tracing)
}

/// The parts of a line that mostly hold; a hand does not stop for a cell or two.
fn runs(line: &Line, holds: impl Fn(usize) -> bool, tracing: &Tracing) -> Vec<Line> {
    let count = line.points.len();
    let single: Vec<bool> = (0..count).map(holds).collect();
    let reach = tracing.least_length as usize / 2;
    let mostly = |at: usize| {
        let around = &single[at.saturating_sub(reach)..(at + reach + 1).min(count)];
        2 * around.iter().filter(|&&holds| holds).count() > around.len()
    };
    let mostly: Vec<bool> = (0..count).map(mostly).collect();
    let mut parts = Vec::new();
    let mut first = 0;
    while first < count {
        let end = (first..count).find(|&at| mostly[at] != mostly[first]).unwrap_or(count);
        if mostly[first] {
            if end - first == count {
                return vec![line.clone()];
            }
            let part = line.part(first, end - 1);
            if part.length() + part.widths[0] >= tracing.least_length {
                parts.push(part);
            }
        }
        first = end;
    }
    parts
}

/// The highest in rank, not too many of them in one place.
fn spaced(
    strokes: Vec<Trace>,
    rank: impl Fn(&Trace) -> f32,
    crowd: usize,
    long_edge: f64,
    most: usize,
) -> Vec<Trace> {
    let mut ranked: Vec<(f32, Trace)> = strokes.into_iter().map(|stroke| (rank(&stroke), stroke)).collect();
    // Stable, so that equals stay in the order of their places.
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    let room = ROOM * long_edge as f32;
    let mut chosen: Vec<Trace> = Vec::new();
    for (_, stroke) in ranked {
        if chosen.len() >= most {
            break;
        }
        let [x, y] = stroke.points[stroke.points.len() / 2];
        let is_near = |other: &&Trace| {
            let [u, v] = other.points[other.points.len() / 2];
            (u - x) * (u - x) + (v - y) * (v - y) < room * room
        };
        if chosen.iter().filter(is_near).count() < crowd {
            chosen.push(stroke);
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 400;
    const EDGE: f64 = 400.0;

    fn plane(value: impl Fn(f32, f32) -> f32) -> Raster<f32> {
        Raster::from_fn(SIDE, SIDE, |x, y| value(x as f32 + 0.5, y as f32 + 0.5))
    }

    fn darks_of(lightness: &Raster<f32>, face: f32) -> Vec<Trace> {
        let (seen, none) = (plane(|_, _| 0.8), plane(|_, _| 0.0));
        darks(lightness, &seen, &none, &plane(|_, _| face), EDGE, 110)
    }

    fn lights_of(lightness: &Raster<f32>, chroma: f32) -> Vec<Trace> {
        let (seen, none) = (plane(|_, _| 0.8), plane(|_, _| 0.0));
        let plain = gaussian_plane(lightness, 0.02 * EDGE);
        lights(lightness, &plane(|_, _| chroma), &seen, &none, &none, &plain, &none, EDGE, 75)
    }

    /// A curved hair 320 cells long and two wide.
    fn whisker(x: f32, y: f32) -> bool {
        (40.0..350.0).contains(&x) && (y - 200.0 - 60.0 * libm::sinf(x / 150.0)).abs() < 1.2
    }

    #[test]
    fn a_whisker_is_one_stroke_over_its_length() {
        // Fainter in places, as whiskers are.
        let faint = |x: f32| if (x as usize / 40).is_multiple_of(3) { 14.0 } else { 34.0 };
        for sign in [1.0, -1.0] {
            let lightness = plane(|x, y| 50.0 + sign * if whisker(x, y) { faint(x) } else { -10.0 });
            let found = if sign > 0.0 { lights_of(&lightness, 5.0) } else { darks_of(&lightness, 0.0) };
            assert_eq!(found.len(), 1, "{found:?}");
            assert!(found[0].length > 300.0, "{}", found[0].length);
        }
    }

    #[test]
    fn a_gradient_has_none() {
        for slope in [0.02, 0.15, 0.2] {
            let lightness = plane(|x, y| 20.0 + slope * (0.8 * x + 0.2 * y));
            assert_eq!(darks_of(&lightness, 0.0), []);
            assert_eq!(lights_of(&lightness, 5.0), []);
        }
    }

    #[test]
    fn the_light_side_of_an_edge_is_none() {
        // With the overshoot that cameras sharpen edges by.
        let edge = |x: f32| match x {
            x if x < 196.0 => 25.0,
            x if x < 200.0 => 21.0,
            x if x < 204.0 => 82.0,
            _ => 78.0,
        };
        let lightness = plane(|x, y| edge(x + 10.0 * libm::sinf(y / 60.0)));
        assert_eq!(lights_of(&lightness, 5.0), []);
    }

    #[test]
    fn glints_are_short_strokes_and_colors_and_half_lights_are_none() {
        let glint = |light: f32| {
            plane(move |x, y| {
                let is_glint = (x - 200.0) * (x - 200.0) + (y - 150.0) * (y - 150.0) < 9.0;
                if is_glint {
                    light
                } else if x < 30.0 {
                    95.0
                } else {
                    30.0 + 0.05 * y
                }
            })
        };
        let found = lights_of(&glint(95.0), 5.0);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].length < 20.0 && found[0].length > found[0].widths[0], "{found:?}");
        assert_eq!(lights_of(&glint(95.0), 50.0), [], "a color is not white");
        assert_eq!(lights_of(&glint(52.0), 5.0), [], "half the way to white");
    }

    #[test]
    fn rows_on_what_is_light_already_are_no_lights() {
        let lightness = plane(|x, _| if (x as usize).is_multiple_of(16) { 98.0 } else { 86.0 });
        assert_eq!(lights_of(&lightness, 5.0), []);
    }

    #[test]
    fn accents_do_not_crowd() {
        let lightness =
            plane(|x, y| if (x as usize % 14 < 3) && (y as usize % 40 < 24) { 20.0 } else { 60.0 });
        let found = darks_of(&lightness, 0.0);
        assert!(found.len() > 20, "{}", found.len());
        let room = ROOM * EDGE as f32;
        for one in &found {
            let [x, y] = one.points[one.points.len() / 2];
            let is_near = |other: &&Trace| {
                let [u, v] = other.points[other.points.len() / 2];
                (u - x) * (u - x) + (v - y) * (v - y) < room * room
            };
            // Those before it in rank were there when it came.
            let rank = found.iter().position(|other| other == one).unwrap_or(0);
            assert!(found[..rank].iter().filter(is_near).count() < CROWDS[0]);
        }
    }

    #[test]
    fn a_face_has_no_drips() {
        let lightness = plane(|x, y| {
            let mouth = (y - 200.0).abs() < 1.6 && (160.0..240.0).contains(&x);
            let drip = (x - 240.0).abs() < 1.6 && (198.0..250.0).contains(&y);
            if mouth || drip { 25.0 } else { 65.0 }
        });
        assert_eq!(darks_of(&lightness, 0.0).len(), 2);
        let found = darks_of(&lightness, 1.0);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].points.iter().all(|point| point[1] < 212.0), "{found:?}");
    }

    #[test]
    fn any_number_of_threads_gives_the_same() {
        let key = girtin_grid::random::key(1, girtin_grid::random::stage("threads"));
        let noise =
            plane(|x, y| girtin_grid::random::unit_f32(girtin_grid::random::at(key, [x as i64, y as i64])));
        let noise = gaussian_plane(&noise, 2.5).map(|value| 55.0 + 220.0 * (value - 0.5));
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.unwrap_or_else(|error| panic!("{error}"))
                .install(|| (darks_of(&noise, 0.0), lights_of(&noise, 5.0)))
        };
        let one = on(1);
        assert!(one.0.len() > 5 && one.1.len() > 1, "{} {}", one.0.len(), one.1.len());
        assert_eq!(one, on(3));
    }

    #[test]
    fn any_size_is_fine() {
        for (width, height) in [(0, 0), (1, 1), (3, 40)] {
            let one = Raster::new(width, height, 50.0f32);
            let none = Raster::new(width, height, 0.0f32);
            assert_eq!(darks(&one, &none, &none, &none, 40.0, 9), []);
            assert_eq!(lights(&one, &none, &none, &none, &none, &one, &none, 40.0, 9), []);
        }
    }
}
