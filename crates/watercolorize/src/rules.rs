//! Texture by a rule of marks instead of the thing: what a painter puts down for leaves, grass, water and stone.
//!
//! Pure geometry: where strokes lie, how wide they are, and of what kind. Each rule takes a density that says where its
//! texture is, and places few groups of marks there, no two too near each other. What a mark's color is says whoever
//! paints it; whether it is to be lighter or darker than its ground it knows itself.

use core::f32::consts::{FRAC_PI_2, PI};

use girtin_grid::blur::gaussian_plane;
use girtin_grid::{Raster, random};

use crate::accidents::smoothstep;

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
const LEAF_LENGTHS: [f32; 2] = [0.005, 0.022];
const LEAF_SHAPE: [f64; 2] = [0.32, 0.5];
/// Leaves shorter than this are drops of the brush's tip.
const DROP_BELOW: f32 = 0.008;
/// Leaves in a group, and how far they turn from the way out.
const LEAVES: [u64; 2] = [3, 7];
const LEAF_TURN: f64 = 0.7;
/// Sigmas of the blurs whose differences are fine, middle and coarse texture.
const GRAINS: [f64; 4] = [0.0012, 0.0028, 0.0065, 0.015];
/// Sigma over which a plant mass is smooth, and the Lab L a length of it by which it turns from light to dark.
const TURN_REACH: f64 = 0.010;
const TURN_STEPS: [f32; 2] = [2.5, 9.0];

/// Hairs in a tuft, their lengths and widths, how far the outer ones lean, and how wide a tuft is at its foot.
const HAIRS: [u64; 2] = [4, 8];
const HAIR_LENGTHS: [f64; 2] = [0.014, 0.034];
const HAIR_WIDTHS: [f64; 2] = [0.0014, 0.0028];
const HAIR_LEAN: f32 = 0.45;
const TUFT: f32 = 0.35;
/// Grass whose structure lies flatter than this stands up anyway.
const LYING: f32 = 0.5;

/// Length of a ripple at the bottom of the water and its length over its width.
const RIPPLE_LENGTHS: [f64; 2] = [0.045, 0.095];
const RIPPLE_SHAPE: [f64; 2] = [5.0, 9.0];
/// Size at the top of the water over that at its bottom.
const FAR: f32 = 0.14;
/// Thinnest ripple.
const RIPPLE_LEAST: f64 = 0.0012;
/// How much denser ripples are at the bottom, as against the top.
const NEARER: f32 = 3.0;
/// Standard deviations of the surrounding tone and of a ripple, across and along.
const RIPPLE_TONE: f64 = 0.022;
const RIPPLE_FINE: f64 = 0.0016;
/// Least step of lightness of a ripple, Lab L.
const RIPPLE_STEP: f32 = 1.5;

/// Strokes of a hatch, their lengths, widths, distance over width, and turn against the structure.
const HATCHES: [u64; 2] = [2, 4];
const HATCH_LENGTHS: [f64; 2] = [0.012, 0.032];
const HATCH_WIDTHS: [f64; 2] = [0.0026, 0.0052];
const HATCH_PITCH: [f64; 2] = [1.7, 2.6];
const HATCH_TURN: f64 = 0.22;

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
                // The group is strung along the edge, a bit in and out of it.
                let along = (k as f32 - 0.5 * (count - 1) as f32) * 0.55 * length;
                let (off, turn) = (chance.spread(0.45) * length, chance.spread(LEAF_TURN));
                let foot = moved(moved(at, out + FRAC_PI_2, along), out, off - 0.35 * length);
                let length = length * chance.between([0.7, 1.25]);
                let points = bent(foot, out + turn + 0.25 * along / length, length, chance.spread(0.35));
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
    let length_of = |chance: &mut Chance| ground.scale * chance.between(HAIR_LENGTHS) * s as f32;
    let mut marks = Marks::of(ground, "grass");
    let room = |_: [f32; 2]| ground.scale * (1.1 * HAIR_LENGTHS[1] * s) as f32;
    marks.place(|_| 1.0, room, |chance, at| {
        let up = upright(ground.direction.at(cell(at[0], ground.direction.width()), cell(at[1], ground.direction.height())));
        let length = length_of(chance);
        let step = ground.lightness.sample(at[0], at[1]) - tone.sample(at[0], at[1]);
        let step = if step > 0.0 { 7.0 } else { -9.0 };
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
                let width = ground.scale * (chance.between(HAIR_WIDTHS) * s as f32);
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
    let Some([top, bottom]) = extent(ground.density) else { return Vec::new() };
    let (fine, tone) =
        (gaussian_plane(ground.lightness, RIPPLE_FINE * s), gaussian_plane(ground.lightness, RIPPLE_TONE * s));
    let nearness = |y: f32| ((y - top) / (bottom - top).max(1.0)).clamp(0.0, 1.0);
    let usual = |y: f32| ground.scale * s as f32 * (FAR + (1.0 - FAR) * nearness(y));
    // Mean step of lightness along a level stroke.
    let step_at = |[x, y]: [f32; 2], length: f32| {
        const LOOKS: i8 = 4;
        let step = |k: i8| {
            let x = x + 0.4 * length * f32::from(k) / f32::from(LOOKS);
            fine.sample(x, y) - tone.sample(x, y)
        };
        (-LOOKS..=LOOKS).map(step).sum::<f32>() / f32::from(2 * LOOKS + 1)
    };
    let mean_length = 0.5 * (RIPPLE_LENGTHS[0] + RIPPLE_LENGTHS[1]) as f32;
    let weight = |at: [f32; 2]| {
        let step = step_at(at, mean_length * usual(at[1])).abs();
        (1.0 + (NEARER - 1.0) * nearness(at[1])) * smoothstep(step, 0.5 * RIPPLE_STEP, 4.0 * RIPPLE_STEP)
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
        let Some((step, at)) = best.filter(|best| best.0.abs() > 0.5 * RIPPLE_STEP) else { return Vec::new() };
        let slope = chance.spread(0.05);
        let way = if chance.unit() < 0.5 { slope } else { PI + slope };
        let foot = moved(at, way, -0.5 * length);
        // A hand swings a little about its wrist: down in the middle, and up again with the tip.
        let sag = (0.05 + 0.05 * chance.unit()) * length;
        let points = [(0.0, 0.0), (0.25, 0.7), (0.5, 0.9), (0.75, 0.35), (1.0, -0.25)]
            .map(|(along, down)| {
                let [x, y] = moved(foot, way, along * length);
                [x, y + down * sag]
            })
            .to_vec();
        let kind = if length > RIPPLE_LENGTHS[0] as f32 * s as f32 && chance.unit() < 0.25 { Kind::Tail } else { Kind::Leaf };
        vec![Stroke { points, width, kind, step }]
    })
}

/// The rows between which lies nearly all of a density.
fn extent(density: &Raster<f32>) -> Option<[f32; 2]> {
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
    Some([up_to(0.01)? as f32, up_to(0.985)? as f32])
}

/// Groups of parallel short strokes along the structure, as tiles, planks and strata have them.
pub fn hatch(ground: &Ground) -> Vec<Stroke> {
    let s = ground.long_edge;
    let tone = gaussian_plane(ground.lightness, TURN_REACH * s);
    let room = |_: [f32; 2]| ground.scale * (1.15 * HATCH_LENGTHS[1] * s) as f32;
    Marks::of(ground, "hatch").place(|_| 1.0, room, |chance, at| {
        let along = ground.direction.at(cell(at[0], ground.direction.width()), cell(at[1], ground.direction.height()));
        let along = along + if chance.unit() < 0.5 { 0.0 } else { PI } + chance.spread(HATCH_TURN);
        let width = ground.scale * chance.between(HATCH_WIDTHS) * s as f32;
        let pitch = width * chance.between(HATCH_PITCH);
        let step = ground.lightness.sample(at[0], at[1]) - tone.sample(at[0], at[1]);
        let step = if step > 3.0 { 6.0 } else { -chance.between([9.0, 17.0]) };
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

/// The cell that a place lies in.
fn cell(place: f32, cells: usize) -> usize {
    (place.max(0.0) as usize).min(cells.saturating_sub(1))
}

/// The accidents of one group of marks.
struct Chance {
    key: u64,
    drawn: u64,
}

impl Chance {
    fn next(&mut self) -> u64 {
        self.drawn += 1;
        random::fold(self.key, self.drawn)
    }

    /// From 0 to 1.
    fn unit(&mut self) -> f32 {
        random::unit_f32(self.next())
    }

    fn between(&mut self, [least, most]: [f64; 2]) -> f32 {
        random::between(self.next(), least, most) as f32
    }

    /// About 0, most of it up to `deviation` to either side, never beyond 1.7 of it: the sum of three even ones.
    fn spread(&mut self, deviation: f64) -> f32 {
        let sum: f64 = (0..3).map(|_| random::between(self.next(), -1.0, 1.0)).sum();
        (deviation * sum * 0.57) as f32
    }

    fn count(&mut self, [least, most]: [u64; 2]) -> u64 {
        least + random::below(self.next(), most - least + 1)
    }
}

/// Groups of marks over a ground, no two too near each other.
struct Marks<'a> {
    ground: &'a Ground<'a>,
    key: u64,
    /// How much nearer groups may be up and down than to the sides.
    flatness: f32,
}

impl<'a> Marks<'a> {
    /// # Panics
    /// The planes differ in size.
    fn of(ground: &'a Ground, stage: &str) -> Self {
        let size = |plane: &Raster<f32>| (plane.width(), plane.height());
        let same = size(ground.density);
        assert!(same == size(ground.direction) && same == size(ground.lightness), "planes of one size");
        Self { ground, key: random::key(ground.seed, random::stage(stage)), flatness: 1.0 }
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
                let at = [(column as f64 + jitter(1)) * pitch, (row as f64 + jitter(2)) * pitch].map(|at| at as f32);
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
            let marks = group(&mut Chance { key, drawn: 0 }, at);
            let is_there = |stroke: &Stroke| {
                let inside = |&&[x, y]: &&[f32; 2]| density.sample(x, y) >= THERE[1];
                // One point may be outside: leaves reach over the silhouette.
                stroke.points.iter().filter(inside).count() + 1 >= stroke.points.len()
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
