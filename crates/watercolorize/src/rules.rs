//! Texture by a rule of marks instead of the thing: what a painter puts down for leaves, grass, water and stone.
//!
//! Pure geometry: where strokes lie, how wide they are, and of what kind. Each rule takes a density that says where its
//! texture is, and places few groups of marks there, no two too near each other. What a mark's color is says whoever
//! paints it; whether it is to be lighter or darker than its ground it knows itself.

use core::f32::consts::{FRAC_PI_2, PI};

use girtin_grid::blur::{gaussian, gaussian_plane};
use girtin_grid::{Raster, random};

use crate::accidents::{Chance, smoothstep};

/// What of a brush touches the paper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// The belly of a pointed brush: a lens, widest after a quarter.
    Leaf,
    /// Its tip, set down and lifted at once.
    Drop,
    /// Flat at first, running out in a point.
    Tail,
    /// Pressed at the root and drawn to nothing.
    Hair,
    /// The side of a flat brush: one width, two cut ends.
    Flat,
}

/// One gesture.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// Points of its path, cells, the heavy end first. A Catmull-Rom spline goes through them.
    pub points: Vec<[f32; 2]>,
    /// Most width, cells.
    pub width: f32,
    /// How the width runs along it.
    pub kind: Kind,
    /// How much lighter than its ground it is to be, Lab L; negative for darker.
    pub step: f32,
}

/// Where a rule lays its marks.
#[derive(Clone, Copy, Debug)]
pub struct Ground<'a> {
    /// How much there is of the texture, 0 to 1.
    pub density: &'a Raster<f32>,
    /// Along the structure, radians, half a turn either way being the same; of the density's size.
    pub direction: &'a Raster<f32>,
    /// Lab L of the photograph; of the density's size.
    pub lightness: &'a Raster<f32>,
    /// Size of the marks over their usual size.
    pub scale: f32,
    /// From which the accidents come.
    pub seed: u64,
    /// Most strokes.
    pub most: usize,
    /// Cells along the picture's long edge.
    pub long_edge: f64,
}

/// Lengths here are parts of the long edge; a pair is the least and the most, angles are radians.
///
/// Step between places that a mark may have. Finer ones cost time, coarser ones show as a grid.
const PLACES: f64 = 0.005;
/// Least density at a place, and of all points of a stroke.
const THERE: [f32; 2] = [0.2, 0.12];
/// Full density on so much of the picture carries as many strokes as are asked for.
const FULL: f64 = 0.05;

/// Sizes of leaves, far and near, and their width over their length.
const LEAF_LENGTHS: [f32; 2] = [0.006, 0.024];
const LEAF_SHAPE: [f32; 2] = [0.26, 0.42];
/// Leaves shorter than this are drops of the brush's tip.
const DROP_BELOW: f32 = 0.008;
/// Leaves in a group; how far apart their feet are, over their length, and by what angle they part; how far each turns besides.
const LEAVES: [u64; 2] = [3, 7];
const LEAF_FAN: [f32; 2] = [0.26, 0.24];
const LEAF_TURN: f32 = 0.4;
/// Sigmas of the blurs whose differences are fine, middle and coarse texture.
const GRAINS: [f64; 4] = [0.0012, 0.0028, 0.0065, 0.015];
/// Sigma over which a plant mass is smooth, and the Lab L a length of it by which it turns from light to dark.
const TURN_REACH: f64 = 0.010;
const TURN_STEPS: [f32; 2] = [2.5, 9.0];

/// Hairs in a tuft, their lengths and widths, how far the outer ones lean, and how wide a tuft is at its foot.
const HAIRS: [u64; 2] = [4, 8];
const HAIR_LENGTHS: [f32; 2] = [0.014, 0.034];
const HAIR_WIDTHS: [f32; 2] = [0.0014, 0.0028];
const HAIR_LEAN: f32 = 0.45;
const TUFT: f32 = 0.35;
/// Size of the furthest tufts over that of the nearest.
const GRASS_FAR: f32 = 0.35;
/// Grass whose structure lies flatter than this stands up anyway.
const LYING: f32 = 0.5;

/// Length of a ripple at the bottom of the water and its length over its width.
const RIPPLE_LENGTHS: [f32; 2] = [0.045, 0.095];
const RIPPLE_SHAPE: [f32; 2] = [5.0, 9.0];
/// Size at the top of the water over that at its bottom.
const FAR: f32 = 0.14;
/// How far a ripple sags in its middle, over its length; some arch instead.
const RIPPLE_SAG: [f32; 2] = [-0.03, 0.07];
/// Thinnest ripple.
const RIPPLE_LEAST: f64 = 0.0012;
/// How much denser ripples are at the bottom, as against the top.
const NEARER: f32 = 3.0;
/// Standard deviations of the surrounding tone and of a ripple, across and along.
const RIPPLE_TONE: f64 = 0.022;
const RIPPLE_FINE: f64 = 0.0016;
/// Least step of lightness of a ripple, Lab L.
const RIPPLE_STEP: f32 = 1.5;

/// Steps of lightness against the tone around, Lab L, from which on and up to which texture is seen.
const SEEN: [f32; 2] = [1.0, 7.0];
/// Strokes of a hatch, their lengths, widths, distance over width, and turn against the structure.
const HATCHES: [u64; 2] = [2, 4];
const HATCH_LENGTHS: [f32; 2] = [0.012, 0.032];
const HATCH_WIDTHS: [f32; 2] = [0.0026, 0.0052];
const HATCH_PITCH: [f32; 2] = [1.7, 2.6];
const HATCH_TURN: f32 = 0.22;

/// Leaves where plants end and where they turn from light to dark, in groups, each group pointing outward.
///
/// Their size follows the photograph's grain there: near leaves are large, far trees have small ones.
pub fn foliage(ground: &Ground) -> Vec<Stroke> {
    let s = ground.long_edge;
    let mass = gaussian_plane(ground.density, 0.5 * TURN_REACH * s);
    let tone = gaussian_plane(ground.lightness, TURN_REACH * s);
    let reach = (0.6 * TURN_REACH * s) as f32;
    let sizes = leaf_lengths(ground);
    // How fast something changes there, per reach, and which way it falls.
    let fall = |plane: &Raster<f32>, [x, y]: [f32; 2]| {
        let across = |dx: f32, dy: f32| plane.sample(x - dx, y - dy) - plane.sample(x + dx, y + dy);
        [0.5 * across(reach, 0.0), 0.5 * across(0.0, reach)]
    };
    let weight = |at: [f32; 2]| {
        let end = smoothstep(size(fall(&mass, at)), 0.06, 0.25);
        let turn = smoothstep(size(fall(&tone, at)), TURN_STEPS[0], TURN_STEPS[1]);
        0.04 + end.max(0.7 * turn)
    };
    let mut marks = Marks::of(ground, "leaves");
    // They reach over the silhouette.
    marks.outside = 2;
    let room = |at: [f32; 2]| 2.4 * sizes.sample(at[0], at[1]);
    marks.place(weight, room, |chance, at| {
        let [ex, ey] = fall(&mass, at);
        let [tx, ty] = fall(&tone, at);
        // At the silhouette off the mass; inside from the light into the dark, as lit leaves hang over what is behind.
        let out = if size([ex, ey]) > 0.06 { libm::atan2f(ey, ex) } else { libm::atan2f(ty, tx) };
        let step = ground.lightness.sample(at[0], at[1]) - tone.sample(at[0], at[1]);
        let step = if step > 0.0 { 6.0 + step.min(8.0) } else { -6.0 + step.max(-8.0) };
        let length = sizes.sample(at[0], at[1]);
        let count = chance.count(LEAVES);
        (0..count)
            .map(|k| {
                // A fan whose leaves touch at their feet, the outer ones turned further and set back a bit.
                let side = k as f32 - 0.5 * (count - 1) as f32;
                let length = length * chance.between([0.65, 1.25]);
                let foot = moved(at, out + FRAC_PI_2, (LEAF_FAN[0] * side + chance.spread(0.2)) * length);
                let foot = moved(foot, out, (chance.spread(0.3) - 0.35 - 0.06 * side * side) * length);
                let out = out + LEAF_FAN[1] * side + chance.spread(LEAF_TURN);
                let points = bent(foot, out, length, chance.spread(0.45));
                let width = length * chance.between(LEAF_SHAPE);
                let kind = if length < DROP_BELOW * s as f32 { Kind::Drop } else { Kind::Leaf };
                Stroke { points, width, kind, step }
            })
            .collect()
    })
}

/// Length of the leaves that the photograph's texture suggests at each cell, cells.
///
/// The part of its energy at three scales tells how coarse the texture is: fine grain is far away.
fn leaf_lengths(ground: &Ground) -> Raster<f32> {
    let s = ground.long_edge;
    let blurs = GRAINS.map(|sigma| gaussian_plane(ground.lightness, sigma * s));
    let energy = [0, 1, 2].map(|k| {
        let (fine, coarse) = (&blurs[k], &blurs[k + 1]);
        let square = Raster::by_rows(fine.width(), fine.height(), |x, y| {
            let step = fine.at(x, y) - coarse.at(x, y);
            step * step
        });
        gaussian_plane(&square, 1.2 * GRAINS[3] * s)
    });
    Raster::by_rows(ground.lightness.width(), ground.lightness.height(), |x, y| {
        let [fine, middle, coarse] = [0, 1, 2].map(|k| energy[k].at(x, y).max(0.0));
        let coarseness = (0.5 * middle + coarse) / (fine + middle + coarse + 0.1);
        // Of natural textures nearly all have between a quarter and four fifths of it.
        let near = ((coarseness - 0.35) / 0.45).clamp(0.0, 1.0);
        ground.scale * s as f32 * (LEAF_LENGTHS[0] + near * (LEAF_LENGTHS[1] - LEAF_LENGTHS[0]))
    })
}

/// Tufts of hairs along the structure, upward.
pub fn grass(ground: &Ground) -> Vec<Stroke> {
    let s = ground.long_edge;
    let tone = gaussian_plane(ground.lightness, TURN_REACH * s);
    let Some(nearness) = Nearness::of(ground.density) else { return Vec::new() };
    let usual = |y: f32| ground.scale * s as f32 * nearness.size(y, GRASS_FAR);
    let step_at = |[x, y]: [f32; 2]| ground.lightness.sample(x, y) - tone.sample(x, y);
    let mut marks = Marks::of(ground, "grass");
    marks.outside = 1;
    let room = |at: [f32; 2]| 1.1 * HAIR_LENGTHS[1] * usual(at[1]);
    let weight = |at: [f32; 2]| 0.25 + smoothstep(step_at(at).abs(), SEEN[0], SEEN[1]);
    marks.place(weight, room, |chance, at| {
        let up = upright(along(ground, at));
        let length = chance.between(HAIR_LENGTHS) * usual(at[1]);
        let step = if step_at(at) > 0.0 { 7.0 } else { -9.0 };
        let count = chance.count(HAIRS);
        (0..count)
            .map(|k| {
                let side = if count > 1 { 2.0 * k as f32 / (count - 1) as f32 - 1.0 } else { 0.0 };
                let foot = moved(at, up + FRAC_PI_2, (0.5 * TUFT * side + chance.spread(0.06)) * length);
                let foot = moved(foot, up, chance.spread(0.10) * length);
                let lean = side * HAIR_LEAN + chance.spread(0.14);
                // The outer hairs are shorter and bend further over.
                let length = length * (1.0 - 0.3 * side.abs()) * chance.between([0.75, 1.15]);
                let points = bent(foot, up + 0.5 * lean, length, lean + chance.spread(0.1));
                let width = chance.between(HAIR_WIDTHS) * usual(at[1]);
                Stroke { points, width, kind: Kind::Hair, step }
            })
            .collect()
    })
}

/// The way up along a structure.
fn upright(direction: f32) -> f32 {
    let direction = if libm::sinf(direction) > 0.0 { direction + PI } else { direction };
    if libm::sinf(direction) > -LYING { -FRAC_PI_2 } else { direction }
}

/// Level strokes of water, each a lens with its belly at a quarter, where the photograph is lighter or darker than the smooth
/// tone around; long at the bottom of the water and short at its top.
pub fn ripples(ground: &Ground) -> Vec<Stroke> {
    let s = ground.long_edge;
    let Some(nearness) = Nearness::of(ground.density) else { return Vec::new() };
    let (fine, tone) = (gaussian_plane(ground.lightness, RIPPLE_FINE * s), tone_within(ground, RIPPLE_TONE));
    let usual = |y: f32| ground.scale * s as f32 * nearness.size(y, FAR);
    // Mean step of lightness along a level stroke.
    let step_at = |[x, y]: [f32; 2], length: f32| {
        const LOOKS: i8 = 4;
        let step = |k: i8| {
            let x = x + 0.4 * length * f32::from(k) / f32::from(LOOKS);
            fine.sample(x, y) - tone.sample(x, y)
        };
        (-LOOKS..=LOOKS).map(step).sum::<f32>() / f32::from(2 * LOOKS + 1)
    };
    let mean_length = 0.5 * (RIPPLE_LENGTHS[0] + RIPPLE_LENGTHS[1]);
    let weight = |at: [f32; 2]| {
        let step = step_at(at, mean_length * usual(at[1])).abs();
        (1.0 + (NEARER - 1.0) * nearness.at(at[1])) * smoothstep(step, 0.5 * RIPPLE_STEP, 4.0 * RIPPLE_STEP)
    };
    let room = |at: [f32; 2]| 0.5 * mean_length * usual(at[1]);
    let mut marks = Marks::of(ground, "ripples");
    // Ripples lie side by side, not in a row: between rows there is less room than along them.
    marks.flatness = 3.0;
    marks.place(weight, room, |chance, at| {
        let length = chance.between(RIPPLE_LENGTHS) * usual(at[1]);
        let width = (length / chance.between(RIPPLE_SHAPE)).max((RIPPLE_LEAST * s) as f32);
        // On the ripple itself: the row where it is clearest.
        let reach = (0.8 * width) as i32;
        let rows = (-reach..=reach).map(|row| [at[0], at[1] + row as f32]);
        let best = rows.map(|at| (step_at(at, length), at)).max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
        let Some((step, at)) = best.filter(|best| best.0.abs() > 0.5 * RIPPLE_STEP) else {
            return Vec::new();
        };
        let slope = chance.spread(0.05);
        let way = if chance.unit() < 0.5 { slope } else { PI + slope };
        let foot = moved(at, way, -0.5 * length);
        // A hand swings a little about its wrist: mostly down in the middle, and up again with the tip.
        let sag = chance.between(RIPPLE_SAG) * length;
        let points = [(0.0, 0.0), (0.25, 0.7), (0.5, 0.9), (0.75, 0.35), (1.0, -0.25)]
            .map(|(along, down)| {
                let [x, y] = moved(foot, way, along * length);
                [x, y + down * sag]
            })
            .to_vec();
        let kind = if length > RIPPLE_LENGTHS[0] * s as f32 && chance.unit() < 0.25 {
            Kind::Tail
        } else {
            Kind::Leaf
        };
        vec![Stroke { points, width, kind, step }]
    })
}

/// How near the ground is at each row, 0 at the top of a texture that lies flat and 1 at its bottom.
struct Nearness {
    top: f32,
    bottom: f32,
}

impl Nearness {
    /// Between the rows that nearly all of a density lies between; none where there is no density.
    fn of(density: &Raster<f32>) -> Option<Self> {
        let row = |y: usize| density.row(y).iter().map(|&value| f64::from(value.max(0.0))).sum::<f64>();
        let rows: Vec<f64> = (0..density.height()).map(row).collect();
        let all: f64 = rows.iter().sum();
        let up_to = |part: f64| {
            let mut sum = 0.0;
            rows.iter().position(|row| {
                sum += row;
                sum > part * all
            })
        };
        Some(Self { top: up_to(0.01)? as f32, bottom: up_to(0.985)? as f32 })
    }

    fn at(&self, y: f32) -> f32 {
        ((y - self.top) / (self.bottom - self.top).max(1.0)).clamp(0.0, 1.0)
    }

    /// Size at a row over that at the bottom, when it is `far` at the top.
    fn size(&self, y: f32, far: f32) -> f32 {
        far + (1.0 - far) * self.at(y)
    }
}

/// The lightness around each cell, of the texture's own ground only: a dark bank does not make the water beside it light.
fn tone_within(ground: &Ground, sigma: f64) -> Raster<f32> {
    let (width, height) = (ground.lightness.width(), ground.lightness.height());
    let both = Raster::by_rows(width, height, |x, y| {
        let there = ground.density.at(x, y) + 1e-4;
        [there * ground.lightness.at(x, y), there]
    });
    gaussian(&both, sigma * ground.long_edge).map(|[sum, there]| sum / there)
}

/// Groups of parallel short strokes along the structure, as tiles, planks and strata have them.
pub fn hatch(ground: &Ground) -> Vec<Stroke> {
    let s = ground.long_edge;
    let tone = gaussian_plane(ground.lightness, TURN_REACH * s);
    let room = |_: [f32; 2]| ground.scale * 1.15 * HATCH_LENGTHS[1] * s as f32;
    let step_at = |[x, y]: [f32; 2]| ground.lightness.sample(x, y) - tone.sample(x, y);
    let weight = |at: [f32; 2]| 0.4 + smoothstep(step_at(at).abs(), SEEN[0], SEEN[1]);
    Marks::of(ground, "hatch").place(weight, room, |chance, at| {
        let turned = if chance.unit() < 0.5 { 0.0 } else { PI };
        let along = along(ground, at) + turned + chance.spread(HATCH_TURN);
        let width = ground.scale * chance.between(HATCH_WIDTHS) * s as f32;
        let pitch = width * chance.between(HATCH_PITCH);
        let step = if step_at(at) > 3.0 { 6.0 } else { -chance.between([9.0, 17.0]) };
        let length = ground.scale * chance.between(HATCH_LENGTHS) * s as f32;
        let bend = chance.spread(0.25);
        let count = chance.count(HATCHES);
        (0..count)
            .map(|k| {
                let middle = moved(at, along + FRAC_PI_2, pitch * (k as f32 - 0.5 * (count - 1) as f32));
                let length = length * chance.between([0.7, 1.2]);
                let foot = moved(middle, along, (chance.spread(0.22) - 0.5) * length);
                let points = bent(foot, along + chance.spread(0.08), length, bend + chance.spread(0.08));
                let kind = if chance.unit() < 0.6 { Kind::Tail } else { Kind::Flat };
                Stroke { points, width: width * chance.between([0.75, 1.1]), kind, step }
            })
            .collect()
    })
}

/// Four points of an arc that begins at a foot and bends by an angle until its end.
fn bent(foot: [f32; 2], from: f32, length: f32, bend: f32) -> Vec<[f32; 2]> {
    let mut points = vec![foot];
    for k in 0..3 {
        let angle = from + bend * (k as f32 - 1.0) / 3.0;
        points.push(moved(points[points.len() - 1], angle, length / 3.0));
    }
    points
}

fn moved([x, y]: [f32; 2], angle: f32, by: f32) -> [f32; 2] {
    [x + by * libm::cosf(angle), y + by * libm::sinf(angle)]
}

fn size([x, y]: [f32; 2]) -> f32 {
    (x * x + y * y).sqrt()
}

/// The structure's direction at a place.
fn along(ground: &Ground, [x, y]: [f32; 2]) -> f32 {
    let cell = |place: f32, cells: usize| (place.max(0.0) as usize).min(cells.saturating_sub(1));
    ground.direction.at(cell(x, ground.direction.width()), cell(y, ground.direction.height()))
}

/// Groups of marks over a ground, no two too near each other.
struct Marks<'a> {
    ground: &'a Ground<'a>,
    key: u64,
    /// How much nearer groups may be up and down than to the sides.
    flatness: f32,
    /// How many points of a stroke may lie outside of the density.
    outside: usize,
}

impl<'a> Marks<'a> {
    /// # Panics
    /// The planes differ in size.
    fn of(ground: &'a Ground, stage: &str) -> Self {
        let size = |plane: &Raster<f32>| (plane.width(), plane.height());
        let same = size(ground.density);
        assert!(same == size(ground.direction) && same == size(ground.lightness), "planes of one size");
        Self { ground, key: random::key(ground.seed, random::stage(stage)), flatness: 1.0, outside: 0 }
    }

    /// Lays groups until there are enough strokes: where density times `weight` is high rather than where it is low, and
    /// no nearer to each other than both their `room`s' mean. Strokes that leave the density are left out.
    fn place(
        &mut self,
        weight: impl Fn([f32; 2]) -> f32,
        room: impl Fn([f32; 2]) -> f32,
        group: impl Fn(&mut Chance, [f32; 2]) -> Vec<Stroke>,
    ) -> Vec<Stroke> {
        let density = self.ground.density;
        let pitch = (PLACES * self.ground.long_edge).max(1.0);
        let (columns, rows) = (density.width() as f64 / pitch, density.height() as f64 / pitch);
        // Waiting times: the place whose turn comes first is drawn first, and turns come faster where there is more.
        let mut places = Vec::new();
        let mut total = 0.0;
        for row in 0..libm::ceil(rows) as i64 {
            for column in 0..libm::ceil(columns) as i64 {
                let key = random::at(self.key, [column, row]);
                let jitter = |word: u64| random::unit_f64(random::fold(key, word));
                let at = [(column as f64 + jitter(1)) * pitch, (row as f64 + jitter(2)) * pitch]
                    .map(|at| at as f32);
                if at[0] >= density.width() as f32 || at[1] >= density.height() as f32 {
                    continue;
                }
                let there = density.sample(at[0], at[1]);
                if there < THERE[0] {
                    continue;
                }
                total += f64::from(there);
                let weight = f64::from(there * weight(at));
                if weight > 1e-6 {
                    places.push((-libm::log(1.0 - jitter(3)) / weight, at, random::fold(key, 4)));
                }
            }
        }
        // Fewer strokes where there is little of the texture.
        let part = total * pitch * pitch / (FULL * self.ground.long_edge * self.ground.long_edge);
        let most = (self.ground.most as f64 * part.min(1.0)).round() as usize;
        places.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
        let mut taken: Vec<([f32; 2], f32)> = Vec::new();
        let mut strokes = Vec::new();
        for (_, at, key) in places {
            if strokes.len() >= most {
                break;
            }
            let here = room(at);
            let is_near = |&(other, room): &([f32; 2], f32)| {
                size([at[0] - other[0], self.flatness * (at[1] - other[1])]) < 0.5 * (here + room)
            };
            if taken.iter().any(is_near) {
                continue;
            }
            let marks = group(&mut Chance::of(key), at);
            let is_there = |stroke: &Stroke| {
                let inside = |&&[x, y]: &&[f32; 2]| density.sample(x, y) >= THERE[1];
                stroke.points.iter().filter(inside).count() + self.outside >= stroke.points.len()
            };
            let before = strokes.len();
            strokes.extend(marks.into_iter().filter(is_there).take(most - before));
            if strokes.len() > before {
                taken.push((at, here));
            }
        }
        strokes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIDE: usize = 300;

    fn ground<'a>(
        density: &'a Raster<f32>,
        direction: &'a Raster<f32>,
        lightness: &'a Raster<f32>,
    ) -> Ground<'a> {
        Ground { density, direction, lightness, scale: 1.0, seed: 4, most: 60, long_edge: SIDE as f64 }
    }

    fn plane(value: impl Fn(f32, f32) -> f32) -> Raster<f32> {
        Raster::from_fn(SIDE, SIDE, |x, y| value(x as f32 + 0.5, y as f32 + 0.5))
    }

    /// Texture of a grain some cells wide.
    fn grain(cells: i64) -> Raster<f32> {
        let key = random::key(1, random::stage("grain"));
        let at = |x: f32, y: f32| random::at(key, [x as i64 / cells, y as i64 / cells]);
        gaussian_plane(&plane(|x, y| 30.0 + 40.0 * random::unit_f32(at(x, y))), 0.3 * cells as f64)
    }

    fn stroke_length(stroke: &Stroke) -> f32 {
        stroke.points.windows(2).map(|pair| size([pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]])).sum()
    }

    fn mean(values: impl Iterator<Item = f32>) -> f32 {
        let values: Vec<f32> = values.collect();
        values.iter().sum::<f32>() / values.len() as f32
    }

    #[test]
    fn ripples_are_level_and_shrink_towards_the_horizon() {
        let water = plane(|_, y| f32::from(u8::from(y > 100.0)));
        let waves = plane(|x, y| 60.0 + 12.0 * libm::sinf(y * 0.9 + 0.02 * x));
        let found = ripples(&ground(&water, &plane(|_, _| 1.0), &waves));
        assert!(found.len() > 30, "{}", found.len());
        let of = |rows: core::ops::Range<f32>| {
            let here: Vec<&Stroke> =
                found.iter().filter(|stroke| rows.contains(&stroke.points[2][1])).collect();
            (here.len(), mean(here.iter().map(|stroke| stroke_length(stroke))))
        };
        let (far, near) = (of(100.0..160.0), of(240.0..300.0));
        assert!(far.0 > 2 && near.0 > 2 && near.1 > 2.0 * far.1, "{far:?} {near:?}");
        for stroke in &found {
            let [first, last] = [stroke.points[0], stroke.points[4]];
            assert!((last[1] - first[1]).abs() < 0.4 * (last[0] - first[0]).abs(), "{:?}", stroke.points);
            assert!(stroke.points.iter().all(|point| point[1] > 99.0), "none ashore");
            let shape = stroke_length(stroke) / stroke.width;
            assert!((2.5..9.5).contains(&shape), "{shape}");
            let here = waves.sample(stroke.points[2][0], stroke.points[2][1]) - 60.0;
            assert!(
                here.abs() < 6.0 || (here > 0.0) == (stroke.step > 0.0) || stroke.width > 3.5,
                "{here} {}",
                stroke.step
            );
        }
    }

    #[test]
    fn still_water_has_no_ripples() {
        let still = plane(|_, y| 60.0 + 0.05 * y);
        assert_eq!(ripples(&ground(&plane(|_, _| 1.0), &plane(|_, _| 0.0), &still)), []);
        assert_eq!(ripples(&ground(&plane(|_, _| 0.0), &plane(|_, _| 0.0), &still)), []);
    }

    #[test]
    fn leaves_lie_at_the_silhouette_and_point_outward() {
        let from_middle = |x: f32, y: f32| size([x - 150.0, y - 150.0]);
        let bush = plane(|x, y| f32::from(u8::from(from_middle(x, y) < 90.0)));
        let found = foliage(&ground(&bush, &plane(|_, _| 0.0), &plane(|_, _| 50.0)));
        assert!(found.len() > 30, "{}", found.len());
        let is_near =
            |stroke: &&Stroke| (from_middle(stroke.points[0][0], stroke.points[0][1]) - 90.0).abs() < 14.0;
        let near = found.iter().filter(is_near).count();
        assert!(near * 10 > found.len() * 7, "{near} of {}", found.len());
        let outward = |stroke: &Stroke| {
            let [foot, tip] = [stroke.points[0], stroke.points[3]];
            (from_middle(tip[0], tip[1]) - from_middle(foot[0], foot[1])) / stroke_length(stroke)
        };
        let outward = mean(found.iter().filter(is_near).map(outward));
        assert!(outward > 0.45, "{outward}");
    }

    #[test]
    fn fine_grain_has_small_leaves() {
        let all = plane(|_, _| 1.0);
        let lengths = [2, 8].map(|cells| {
            let lightness = grain(cells);
            let found = foliage(&ground(&all, &all, &lightness));
            assert!(found.len() > 20, "{}", found.len());
            mean(found.iter().map(stroke_length))
        });
        assert!(lengths[1] > 1.5 * lengths[0], "{lengths:?}");
    }

    #[test]
    fn grass_stands_up_and_hatches_follow_the_structure() {
        let (all, lightness) = (plane(|_, _| 1.0), grain(4));
        for direction in [0.1, 1.2, 1.9, 3.0] {
            let along = plane(|_, _| direction);
            let tufts = grass(&ground(&all, &along, &lightness));
            assert!(tufts.len() > 30);
            assert!(
                tufts.iter().all(|hair| hair.points[3][1] < hair.points[0][1] && hair.kind == Kind::Hair)
            );
            let strokes = hatch(&ground(&all, &along, &lightness));
            assert!(strokes.len() > 30);
            for stroke in &strokes {
                let [foot, tip] = [stroke.points[0], stroke.points[3]];
                let turned = libm::atan2f(tip[1] - foot[1], tip[0] - foot[0]) - direction;
                assert!(libm::sinf(turned).abs() < 0.65, "{turned}");
            }
        }
    }

    #[test]
    fn one_seed_gives_one_picture_and_most_is_kept() {
        let (all, lightness) = (plane(|_, _| 1.0), grain(4));
        let rules = [foliage, grass, ripples, hatch];
        for rule in rules {
            let one = ground(&all, &all, &lightness);
            let found = rule(&one);
            assert!(found.len() <= one.most);
            assert_eq!(found, rule(&one));
            assert_ne!(found, rule(&Ground { seed: 5, ..one }));
            let few = rule(&Ground { most: 7, ..one });
            assert!(few.len() <= 7);
        }
    }

    #[test]
    fn any_size_is_fine() {
        for (width, height) in [(0, 0), (1, 1), (1, 7)] {
            let one = Raster::new(width, height, 1.0f32);
            let tiny = Ground {
                density: &one,
                direction: &one,
                lightness: &one,
                scale: 1.0,
                seed: 0,
                most: 9,
                long_edge: 7.0,
            };
            for rule in [foliage, grass, ripples, hatch] {
                assert!(rule(&tiny).len() <= 9);
            }
        }
    }
}
