//! Masses become shapes: a contour, one value, one mix with a gradient.

use girtin_grid::Raster;
use girtin_grid::blur::gaussian_plane;

use crate::accidents::{Chance, plane, smoothstep};
use crate::contours::{around, contours};
use crate::masses::{Masses, Planes, masses};
use crate::settings::PhotoParams;
use crate::study::{Plane, Study};
use crate::values::LEVELS;

/// How large masses are by default, over those that follow a tone closely: what they leave flat is modelled with strokes.
const MASSES: f32 = 1.3;
/// How far a gradient may go from a shape's middle, Lab L; how much of it hue follows, and how far, Lab a and b.
const GRADIENT: f32 = 15.0;
const HUE_GRADIENT: (f32, f32) = (0.7, 10.0);
/// Spread that a shape has at least for its gradient, a part of the long edge: a slope over a sliver means nothing.
const LEAST_SPREAD: f64 = 0.010;
/// How far neutral shapes lean, to blue or to brown, Lab b in lights and in darks; below which chroma they do; and what of
/// that is red.
const LEAN: ([f32; 2], [f32; 2], f32) = ([1.8, 4.5], [16.0, 5.0], 0.35);
/// How much darker paint pools at one end of a shape than it is at the other, Lab L and parts of its chroma, and how far its
/// hue goes to the warm or the cool on the way, Lab b. Small shapes do less of it than those of this area, a part of the long
/// edge squared.
const POOL: (f32, f32) = (4.5, 0.10);
const POOL_HUE: f32 = 3.5;
const POOL_AREA: f64 = 4e-3;
/// How far colors drift over the sheet, Lab, and how much further the more chroma they have.
const DRIFT: (f64, f32, f32) = (0.09, 2.2, 0.05);

/// Attention from which on a shape keeps its own value; shapes that are looked at less take that of a neighbor which is
/// larger, no further away in tone than this, Lab L, and beside it for this part of their border.
const JOINED: (f32, f32, f64) = (0.55, 14.0, 0.2);
/// Area, parts of the long edge squared, and attention below which a white shape is no light but a chip.
const CHIP: (f64, f32) = (9e-4, 0.45);

/// Sky: how light, how calm, how high up and how much of the upper edge it has.
const SKY_LIGHTNESS: f32 = 50.0;
const SKY_BUSY: f32 = 0.14;
const SKY_ABOVE: f32 = 0.55;
/// Part of the sheet from which on it is painted as a sky.
const LEAST_SKY: f64 = 0.04;
/// Part of the sheet that is no sky but the ground of a drawing, and its tone, Lab L.
const GROUND: (f64, f64) = (0.7, 88.0);
/// A second wash of the sky: part of it, how much darker, Lab L, and how much more colorful.
const SECOND: (f64, f32, f32) = (0.36, 5.5, 1.15);

/// Shapes so many times as long as wide are laid along their length.
const LONG: f32 = 2.5;

/// Attention below which a shape is background.
const BACKGROUND: f32 = 0.5;

/// A shape as it is drawn and painted.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Its contour and those of its holes, cells.
    pub rings: Vec<Vec<[f32; 2]>>,
    /// Wanted colors at the two ends of its gradient, Lab.
    pub colors: [[f32; 3]; 2],
    /// Where those are, cells.
    pub line: [[f32; 2]; 2],
    /// How many washes cover it; 0 is paper.
    pub washes: usize,
    /// What it is a glaze over, if it is one: colors at the two ends, Lab, and how many washes make them. Those lie below it as
    /// they lie beside it.
    pub over: Option<([[f32; 3]; 2], usize)>,
    /// Area, cells.
    pub area: f64,
    /// How exactly it is drawn.
    pub attention: f32,
    /// Hue of the photograph there, Lab a and b.
    pub seen: [f32; 2],
    /// Direction that it is laid in, radians from the rows downward, if it has one of its own.
    pub laid: Option<f32>,
    /// Whether it is of the sky.
    pub is_sky: bool,
    /// Whether it is where the painting ends.
    pub is_border: bool,
}

impl Shape {
    /// Its color where its gradient has come so far.
    pub fn color_at(&self, place: [f32; 2]) -> [f32; 3] {
        let [[ax, ay], [bx, by]] = self.line;
        let (dx, dy) = (bx - ax, by - ay);
        let square = (dx * dx + dy * dy).max(1e-6);
        let part = (((place[0] - ax) * dx + (place[1] - ay) * dy) / square).clamp(0.0, 1.0);
        [0, 1, 2].map(|c: usize| self.colors[0][c] + part * (self.colors[1][c] - self.colors[0][c]))
    }

    /// Something bare.
    pub fn bare(rings: Vec<Vec<[f32; 2]>>) -> Self {
        let paper = [97.0, 0.0, 2.0];
        Self {
            rings,
            colors: [paper; 2],
            line: [[0.0; 2], [1.0, 0.0]],
            washes: 0,
            over: None,
            area: 0.0,
            attention: 1.0,
            seen: [0.0, 2.0],
            laid: None,
            is_sky: false,
            is_border: false,
        }
    }
}

/// The shapes of a picture in the order in which they are drawn over each other.
#[derive(Clone, Debug)]
pub struct Shapes {
    /// The shapes.
    pub shapes: Vec<Shape>,
    /// How much of each cell is sky, 0 or 1.
    pub sky: Plane,
}

/// Means and slopes over the cells of a mass.
struct Sums {
    cells: f64,
    slope: [[f64; 2]; 3],
    spread: [f64; 2],
}

impl Shapes {
    /// Decides on them.
    pub fn new(study: &Study, params: &PhotoParams, seed: u64) -> Self {
        let s = study.mount.long_edge;
        let found = masses(&Planes {
            features: &study.planned,
            steps: &study.steps,
            attention: &study.attention,
            foliage: &study.texture.foliage,
            busy: &study.texture.busy,
            long_edge: s,
            coarseness: MASSES * params.masses as f32,
        });
        let sums = sums(&found, study);
        let mut washes = washes_of(&found, study, params);
        let is_sky = skies(&found, study);
        for (washes, _) in washes.iter_mut().zip(&is_sky).filter(|(_, is_sky)| **is_sky) {
            *washes = usize::from(params.background >= 0.5);
        }
        let mut chance = Chance::new(seed, "shapes");
        let drift = [0, 1].map(|k| plane(seed, &format!("drift {k}"), study.mount.size, DRIFT.0 * s));
        let drawn = contours(&found, s, params.looseness as f32);
        let mut shapes: Vec<Shape> = drawn
            .into_iter()
            .map(|contour| {
                let (mass, sums) = (&found.masses[contour.mass], &sums[contour.mass]);
                let dark = smoothstep(mass.mean[0], 75.0, 35.0);
                let lean = chance.spread(LEAN.0[0] + dark * (LEAN.0[1] - LEAN.0[0]));
                let lean = [LEAN.2 * lean.abs(), lean];
                let (line, steps) = gradient(sums, mass.middle, LEAST_SPREAD * s);
                let large = libm::sqrt((mass.area / (POOL_AREA * s * s)).min(1.0)) as f32;
                // Paint runs down, unless the sheet is turned.
                let down = if (line[1][1] >= line[0][1]) == (chance.unit() < 0.8) { 1.0 } else { -1.0 };
                let pools = large * chance.between([0.4, 1.0]) * (1.0 - 0.5 * mass.attention) * down;
                let turns = large * chance.spread(POOL_HUE) * params.chroma.min(1.0) as f32;
                let colors = [-1.0f32, 1.0].map(|way| {
                    let tone = (mass.mean[0] + way * (steps[0] - POOL.0 * pools)).clamp(10.0, 99.0);
                    let own = [mass.mean[1] + way * steps[1], mass.mean[2] + way * steps[2]];
                    let tint = study.values.tint(own, tone, mass.attention);
                    let richer = 1.0 + way * POOL.1 * pools;
                    let tint = [richer * tint[0], richer * tint[1] + way * turns];
                    let chroma = libm::hypotf(tint[0], tint[1]);
                    let neutral = smoothstep(chroma, LEAN.1[0], LEAN.1[1]);
                    let at = line[usize::from(way > 0.0)];
                    let calm = (1.0 - 0.6 * mass.attention)
                        * (0.4 + 0.6 * smoothstep(tone, 35.0, 72.0))
                        * if is_sky[contour.mass] { 0.4 } else { 1.0 };
                    let far = calm * (DRIFT.1 + DRIFT.2 * chroma) * params.chroma.min(1.0) as f32;
                    let lean = [0, 1].map(|k: usize| {
                        params.chroma.min(1.0) as f32 * neutral * lean[k]
                            + far * drift[k].sample(at[0], at[1])
                    });
                    [tone, tint[0] + lean[0], tint[1] + lean[1]]
                });
                let rings = contour.rings;
                let is_cloud = is_sky[contour.mass] && rings.len() == 1 && rings[0].len() > 4;
                Shape {
                    rings: if is_cloud { rings.iter().map(|ring| rounded(ring)).collect() } else { rings },
                    colors,
                    line,
                    washes: washes[contour.mass],
                    over: None,
                    area: mass.area,
                    attention: mass.attention,
                    seen: [mass.mean[1], mass.mean[2]],
                    laid: (mass.elongation > LONG).then_some(mass.direction),
                    is_sky: is_sky[contour.mass],
                    is_border: false,
                }
            })
            .collect();
        let sky = found.labels.map(|label| f32::from(u8::from(is_sky[label as usize])));
        // Over the sky, under all that stands before it.
        if params.washes > 1 && params.background >= 0.5 {
            let above = shapes.iter().rposition(|shape| shape.is_sky).map_or(0, |last| last + 1);
            let second = second_sky(&shapes, &found, &is_sky, study, seed);
            shapes.splice(above..above, second);
        }
        Self { shapes, sky }
    }
}

/// Sums over masses for their gradients, by least squares.
fn sums(found: &Masses, study: &Study) -> Vec<Sums> {
    let count = found.masses.len();
    let mut both = vec![[[0.0f64; 2]; 3]; count];
    let mut square = vec![[0.0f64; 3]; count];
    let mut cells = vec![0.0f64; count];
    for y in 0..found.labels.height() {
        for (x, &label) in found.labels.row(y).iter().enumerate() {
            let mass = &found.masses[label as usize];
            let (dx, dy) =
                (f64::from(x as f32 + 0.5 - mass.middle[0]), f64::from(y as f32 + 0.5 - mass.middle[1]));
            let color = study.planned.row(y)[x];
            let at = label as usize;
            cells[at] += 1.0;
            square[at][0] += dx * dx;
            square[at][1] += dy * dy;
            square[at][2] += dx * dy;
            for c in 0..3 {
                both[at][c][0] += f64::from(color[c]) * dx;
                both[at][c][1] += f64::from(color[c]) * dy;
            }
        }
    }
    let least = LEAST_SPREAD * study.mount.long_edge;
    (0..count)
        .map(|at| {
            let n = cells[at].max(1.0);
            let (xx, yy) = (square[at][0] + n * least * least, square[at][1] + n * least * least);
            let xy = square[at][2];
            let det = (xx * yy - xy * xy).max(1e-9);
            let slope = both[at].map(|[x, y]| [(x * yy - y * xy) / det, (y * xx - x * xy) / det]);
            Sums { cells: n, slope, spread: [square[at][0] / n, square[at][1] / n].map(libm::sqrt) }
        })
        .collect()
}

/// The line of a mass's gradient, and how far its color goes to either side of the middle.
fn gradient(sums: &Sums, middle: [f32; 2], least: f64) -> ([[f32; 2]; 2], [f32; 3]) {
    let [gx, gy] = sums.slope[0];
    let size = libm::hypot(gx, gy);
    let direction = if size > 1e-6 { [gx / size, gy / size] } else { [0.0, 1.0] };
    // From the middle of one half to the middle of the other and somewhat further.
    let half = 1.6 * libm::hypot(sums.spread[0] * direction[0], sums.spread[1] * direction[1]);
    let half = half.max(least * libm::sqrt(sums.cells).min(1.0));
    let along =
        |c: usize| (half * (sums.slope[c][0] * direction[0] + sums.slope[c][1] * direction[1])) as f32;
    let steps = [
        along(0).clamp(-GRADIENT, GRADIENT),
        (HUE_GRADIENT.0 * along(1)).clamp(-HUE_GRADIENT.1, HUE_GRADIENT.1),
        (HUE_GRADIENT.0 * along(2)).clamp(-HUE_GRADIENT.1, HUE_GRADIENT.1),
    ];
    let end = |way: f64| {
        [middle[0] + (way * half * direction[0]) as f32, middle[1] + (way * half * direction[1]) as f32]
    };
    ([end(-1.0), end(1.0)], steps)
}

/// How many washes each mass takes: its own value, joined to neighbors of nearly the same where nobody looks.
fn washes_of(found: &Masses, study: &Study, params: &PhotoParams) -> Vec<usize> {
    let s = study.mount.long_edge;
    let most = params.washes as usize;
    let mut faces = vec![0.0f32; found.masses.len()];
    for (label, face) in found.labels.as_slice().iter().zip(study.face.as_slice()) {
        faces[*label as usize] += face;
    }
    let mut washes: Vec<usize> = found
        .masses
        .iter()
        .zip(&faces)
        .map(|(mass, face)| study.values.washes(mass.mean, face / mass.area.max(1.0) as f32))
        .collect();
    let mut order: Vec<usize> = (0..washes.len()).collect();
    order.sort_by(|&a, &b| found.masses[a].area.total_cmp(&found.masses[b].area).then(a.cmp(&b)));
    for at in order {
        let mass = &found.masses[at];
        if mass.attention > JOINED.0 {
            continue;
        }
        let border: f64 = found.neighbours[at].iter().map(|neighbour| neighbour.length).sum();
        let joins = found.neighbours[at].iter().filter(|neighbour| {
            let other = &found.masses[neighbour.mass];
            other.area > mass.area
                && washes[neighbour.mass].abs_diff(washes[at]) == 1
                && (other.mean[0] - mass.mean[0]).abs() < JOINED.1 * (1.0 - mass.attention) + 2.0
                && neighbour.length > JOINED.2 * border
        });
        let largest = joins.max_by(|a, b| {
            found.masses[a.mass].area.total_cmp(&found.masses[b.mass].area).then(b.mass.cmp(&a.mass))
        });
        if let Some(neighbour) = largest {
            washes[at] = washes[neighbour.mass];
        }
    }
    for (washes, mass) in washes.iter_mut().zip(&found.masses) {
        if *washes == 0 && mass.area < CHIP.0 * s * s && mass.attention < CHIP.1 {
            *washes = 1;
        }
        if params.background < 1.0 && mass.attention < BACKGROUND {
            // Lighter first, bare in the end.
            let kept = libm::round(params.background * *washes as f64) as usize;
            *washes = (*washes).min(kept);
        }
        *washes = fewer(*washes, most);
    }
    washes
}

/// What so many of all washes are of fewer.
fn fewer(washes: usize, most: usize) -> usize {
    let all = LEVELS.len();
    if most >= all || washes == 0 { washes.min(most) } else { (washes * most).div_ceil(all).max(1) }
}

/// Which masses are sky.
fn skies(found: &Masses, study: &Study) -> Vec<bool> {
    let mount = &study.mount;
    let (height, origin) = (mount.photo[1] as f32, mount.origin);
    let mut touches = vec![0u32; found.masses.len()];
    for y in origin..origin + (mount.photo[1] / 50).max(3) {
        for &label in &found.labels.row(y)[origin..origin + mount.photo[0]] {
            touches[label as usize] += 1;
        }
    }
    let is_sky: Vec<bool> = found
        .masses
        .iter()
        .zip(&touches)
        .map(|(mass, &touches)| {
            f64::from(touches) > 0.04 * mount.long_edge
                && mass.busy < SKY_BUSY
                && mass.mean[0] > SKY_LIGHTNESS
                && mass.middle[1] - origin as f32 <= SKY_ABOVE * height
        })
        .collect();
    let area: f64 =
        found.masses.iter().zip(&is_sky).filter(|(_, sky)| **sky).map(|(mass, _)| mass.area).sum();
    let all = (mount.size[0] * mount.size[1]) as f64;
    let lightness: f64 = found
        .masses
        .iter()
        .zip(&is_sky)
        .filter(|(_, sky)| **sky)
        .map(|(mass, _)| mass.area * f64::from(mass.mean[0]))
        .sum();
    let is_ground = area > GROUND.0 * all && lightness > GROUND.1 * area;
    if area < LEAST_SKY * all || is_ground { vec![false; is_sky.len()] } else { is_sky }
}

/// A second, darker wash over a part of the sky, with a scalloped edge on the dry first one.
fn second_sky(shapes: &[Shape], found: &Masses, is_sky: &[bool], study: &Study, seed: u64) -> Vec<Shape> {
    if !is_sky.contains(&true) {
        return Vec::new();
    }
    let (s, size) = (study.mount.long_edge, study.mount.size);
    let [wide, fine] = [0.08, 0.02].map(|sigma| plane(seed, &format!("sky {sigma}"), size, sigma * s));
    let sky = found.labels.map(|label| is_sky[label as usize]);
    let tone = study.planned.map(|color| color[0]);
    let smooth = gaussian_plane(&tone, 0.02 * s);
    let mean = {
        let of = sky.as_slice().iter().zip(smooth.as_slice()).filter(|(sky, _)| **sky);
        let (sum, count) =
            of.fold((0.0f64, 0u32), |(sum, count), (_, tone)| (sum + f64::from(*tone), count + 1));
        (sum / f64::from(count.max(1))) as f32
    };
    let level = Raster::by_rows(size[0], size[1], |x, y| {
        // Clouds lie: noise three times as wide as high.
        let (u, v) = ((x / 3 + size[0] / 3).min(size[0] - 1), y);
        let high = smoothstep(y as f32, 0.0, 0.6 * size[1] as f32);
        wide.at(u, v) + 0.4 * fine.at(x, y) - 0.09 * (smooth.at(x, y) - mean) - 0.5 * high
    });
    let mut values: Vec<f32> = level
        .as_slice()
        .iter()
        .zip(sky.as_slice())
        .filter(|(_, sky)| **sky)
        .map(|(level, _)| *level)
        .step_by(5)
        .collect();
    values.sort_by(f32::total_cmp);
    let Some(&least) = values.get(((1.0 - SECOND.0) * values.len() as f64) as usize) else {
        return Vec::new();
    };
    let mask = Raster::by_rows(size[0], size[1], |x, y| sky.at(x, y) && level.at(x, y) > least);
    let largest = shapes.iter().filter(|shape| shape.is_sky).max_by(|a, b| a.area.total_cmp(&b.area));
    let Some(largest) = largest else { return Vec::new() };
    let rings = around(&mask, s, 1.6).into_iter().filter(|ring| ring_area(ring) > 6e-3 * s * s);
    let rings: Vec<_> = rings.map(|ring| rounded(&ring)).collect();
    if rings.is_empty() {
        return Vec::new();
    }
    let colors = largest.colors.map(|[l, a, b]| [l - SECOND.1, a * SECOND.2, b * SECOND.2 - 1.5]);
    let over = Some((largest.colors, largest.washes));
    vec![Shape { rings, colors, washes: largest.washes + 1, over, ..largest.clone() }]
}

/// A ring with its corners cut twice: clouds have none.
///
/// # Source
/// Chaikin, *An algorithm for high-speed curve generation*, 1974.
fn rounded(ring: &[[f32; 2]]) -> Vec<[f32; 2]> {
    let cut = |ring: &[[f32; 2]]| -> Vec<[f32; 2]> {
        let sides = ring.iter().zip(ring.iter().cycle().skip(1));
        let part = |a: [f32; 2], b: [f32; 2], part: f32| {
            [0, 1].map(|k: usize| libm::roundf(100.0 * (a[k] + part * (b[k] - a[k]))) / 100.0)
        };
        sides.flat_map(|(&a, &b)| [part(a, b, 0.25), part(a, b, 0.75)]).collect()
    };
    cut(&cut(ring))
}

fn ring_area(ring: &[[f32; 2]]) -> f64 {
    let pairs = ring.iter().zip(ring.iter().cycle().skip(1));
    let twice: f64 = pairs.map(|(a, b)| f64::from(a[0] * b[1] - a[1] * b[0])).sum();
    libm::fabs(twice) / 2.0
}
