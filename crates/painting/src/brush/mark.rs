//! One gesture of a brush: how far each place lies inside it, how much of the paper it touches there, and how much paint it
//! leaves.

use girtin_grid::noise::{Fractal, Noise};
use girtin_grid::random;

use super::smoothstep;
use crate::document::Mark;

/// Points of the curve to a point of the path.
const STEPS: usize = 8;
/// How far a mark's edge strays, mm, over which length, mm, and how far the paper's tooth moves it.
const WOBBLE: f64 = 0.10;
const WOBBLE_MM: f64 = 9.0;
const PINNED: [f32; 2] = [0.012, 0.10];
/// Length over which a restless contour becomes a calm one, mm.
const CALM_MM: f64 = 14.0;
/// How deep into the paint the rim reaches, mm.
const RIM_MM: f32 = 0.42;
/// How much less paint there is at the end than at the beginning, as the brush empties.
const FADE: f32 = 0.12;
/// How softly a dry brush stops to touch, in ranks of the tooth.
const TOUCH: f32 = 0.09;

/// What a mark leaves at a place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Touch {
    /// How much of the place is touched, 0 to 1.
    pub covered: f32,
    /// How much paint is there, of what the brush holds.
    pub load: f32,
    /// How much of it is of the second color, 0 to 1.
    pub end: f32,
}

/// A mark ready to be laid.
#[derive(Clone, Debug)]
pub struct PlannedMark {
    /// Points of the curve, mm, how far along each is, and the width there.
    curve: Vec<([f64; 2], f64, f64)>,
    /// Least and most x and y that it may reach, mm.
    bounds: [[f64; 2]; 2],
    mark: Mark,
    rim: f32,
    /// Where in the noise its accidents are.
    place: f64,
    noise: Noise,
}

impl PlannedMark {
    /// Of a mark, the `number`th of its glaze, whose paint gathers so strongly at the edges.
    pub fn new(mark: &Mark, rim: f64, number: usize, seed: u64) -> Self {
        let curve = curve_of(mark);
        let widest = mark.widths.iter().fold(0.0f64, |most, &width| most.max(width));
        let reach = widest + 1.0;
        let bound = |pick: fn(f64, f64) -> f64, start: f64| {
            [0, 1].map(|axis| curve.iter().map(|(point, ..)| point[axis]).fold(start, pick))
        };
        let low = bound(f64::min, f64::INFINITY).map(|mm| mm - reach);
        let high = bound(f64::max, f64::NEG_INFINITY).map(|mm| mm + reach);
        Self {
            bounds: [low, high],
            curve,
            mark: mark.clone(),
            rim: rim as f32,
            place: 61.7 * number as f64,
            noise: Noise::new(seed, random::stage("marks")),
        }
    }

    /// Least and most x and y that it may reach, mm.
    pub fn bounds(&self) -> [[f64; 2]; 2] {
        self.bounds
    }

    /// How much a knife scrapes off, 0 to 1; 0 for a brush.
    pub fn scraped(&self) -> f32 {
        self.mark.scraped as f32
    }

    /// How much of each pigment it leaves where it leaves all that the brush holds.
    pub fn amounts(&self, touch: &Touch, pigment: usize) -> f32 {
        let begin = self.mark.amounts[pigment] as f32;
        let end = self.mark.end_amounts.as_ref().map_or(begin, |end| end[pigment] as f32);
        touch.load * (begin + touch.end * (end - begin))
    }

    fn noise2(&self, x: f64, y: f64) -> f32 {
        2.2 * self.noise.fbm([x + self.place, y], Fractal { octaves: 2, gain: 0.55 }) as f32
    }

    fn noise1(&self, x: f64, lane: f64) -> f32 {
        self.noise2(x, 0.37 + lane)
    }

    /// Signed distance to the right of the path, mm; millimetres along it, beyond the ends too; width there; and the part of
    /// the length.
    fn place_of(&self, [x, y]: [f64; 2]) -> (f64, f64, f64, bool) {
        if let [(only, _, width)] = self.curve[..] {
            return (libm::hypot(x - only[0], y - only[1]), 0.0, width, true);
        }
        let mut best = (f64::INFINITY, 0usize, 0.0);
        for (at, pair) in self.curve.windows(2).enumerate() {
            let ([ax, ay], [bx, by]) = (pair[0].0, pair[1].0);
            let (dx, dy) = (bx - ax, by - ay);
            let square = (dx * dx + dy * dy).max(1e-12);
            let part = ((x - ax) * dx + (y - ay) * dy) / square;
            let held = part.clamp(0.0, 1.0);
            let (ox, oy) = (x - ax - held * dx, y - ay - held * dy);
            let distance = ox * ox + oy * oy;
            if distance < best.0 {
                best = (distance, at, part);
            }
        }
        let (_, at, part) = best;
        let ([ax, ay], from, w0) = self.curve[at];
        let ([bx, by], to, w1) = self.curve[at + 1];
        let (dx, dy) = (bx - ax, by - ay);
        let length = libm::hypot(dx, dy).max(1e-9);
        let is_end = (at == 0 && part < 0.0) || (at + 2 == self.curve.len() && part > 1.0);
        let held = part.clamp(0.0, 1.0);
        let along = if is_end { from + part * (to - from) } else { from + held * (to - from) };
        let (ox, oy) = (x - ax, y - ay);
        let side = (dx * oy - dy * ox) / length;
        let away = if is_end { side } else { libm::sqrt(best.0).copysign(side) };
        (away, along, w0 + held * (w1 - w0), is_end)
    }

    /// What it leaves at a place, mm, on paper of this tooth and pull; `per_mm` samples a millimetre.
    pub fn at(&self, at: [f64; 2], tooth: f32, pin: f32, per_mm: f32) -> Option<Touch> {
        let mark = &self.mark;
        let (away, along, width, is_end) = self.place_of(at);
        let length = self.curve.last().map_or(0.0, |last| last.1);
        let is_left = away < 0.0;
        let share = if is_left { 0.5 + mark.side } else { 0.5 - mark.side };
        let (half, off) = ((width * share) as f32, libm::fabs(away) as f32);
        if off > half + 0.8 {
            return None;
        }
        let lane = if is_left { 0.0 } else { 40.0 };
        // Thin strokes stray less: hairs would come apart.
        let firm = (half / 0.8).min(1.0);
        let calm = smoothstep(0.1, 1.1, self.noise1(along / CALM_MM, lane + 7.0));
        let strays = firm
            * (WOBBLE as f32 * self.noise1(along / WOBBLE_MM, lane) + (PINNED[0] + PINNED[1] * calm) * pin);
        let mut inside = half + strays - off;
        let (from_begin, to_end) = (along as f32, (length - along) as f32);
        if let Some(chisel) = mark.chisel_degrees {
            let slant = (libm::tan(chisel.to_radians()) * away) as f32;
            let ragged = 0.2 * self.noise1(away / 1.3, 80.0);
            inside = inside.min(from_begin - slant + ragged).min(to_end + slant - 0.5 * ragged);
        } else if is_end || length == 0.0 {
            let beyond = if from_begin < 0.0 { -from_begin } else { (-to_end).max(0.0) };
            inside = half - libm::hypotf(off, beyond);
        }
        let crisp = (0.5 + inside * per_mm).clamp(0.0, 1.0);
        if crisp <= 0.0 {
            return None;
        }
        let s = (along / length.max(1e-9)).clamp(0.0, 1.0) as f32;
        let [begin, end, from] = mark.dry.map(|x| x as f32);
        let [streak_mm, streak_length, strength] = mark.bristles;
        let is_streaked = strength > 0.0;
        let streaks = if is_streaked {
            self.noise2(away / streak_mm.max(0.05), along / streak_length.max(0.5))
        } else {
            0.0
        };
        let strength = strength as f32;
        // Where bristles part, the paper has less of a say.
        let tooth = 0.5 + (tooth - 0.5) * (1.0 - 0.65 * strength.min(1.0));
        let mut dryness = begin + (end - begin) * libm::powf(smoothstep(from.min(0.999), 1.0, s), 1.2);
        dryness += strength * streaks * smoothstep(0.0, 0.35, dryness + 0.12);
        let [drag, drag_mm] = mark.drag.map(|x| x as f32);
        if drag > 0.0 && is_left {
            let waver = (1.0 + 0.8 * self.noise1(along / 9.0, 120.0)).clamp(0.0, 1.6);
            dryness += drag * waver * smoothstep(drag_mm.max(0.01), 0.0, inside);
        }
        dryness += 0.25 * dryness.max(0.0) * smoothstep(1.2, 0.0, inside);
        let touched = if dryness < 0.01 { 1.0 } else { smoothstep(-TOUCH, TOUCH, tooth - dryness) };
        if touched <= 0.0 {
            return None;
        }
        let mut load = 1.0 - FADE * s + 0.09 * self.noise2(away / 5.0, along / 9.0) + 0.06 * streaks;
        let gathers = (0.05 + 1.1 * self.noise1(along / 8.0, lane + 160.0)).clamp(0.0, 2.0)
            * smoothstep(0.25, 0.0, dryness);
        load *= 1.0 + 1.4 * self.rim * gathers * libm::expf(-inside.max(0.0) / RIM_MM);
        let (bead, width) = (mark.bead as f32, width as f32);
        let near = |mm: f32, over: f32| libm::expf(-(mm.max(0.0) / over) * (mm.max(0.0) / over));
        load += bead * smoothstep(0.3, 0.0, dryness) * near(to_end, 0.6 * width + 0.8)
            + 0.4 * bead * near(from_begin, 0.45 * width + 0.5);
        if dryness > 0.05 {
            load *= 0.8 + 0.35 * ((tooth - dryness) / 0.4).clamp(0.0, 1.0);
        }
        let end = if mark.end_amounts.is_some() {
            (s + 0.35 * self.noise2(at[0] / 9.0, at[1] / 9.0)).clamp(0.0, 1.0)
        } else {
            0.0
        };
        Some(Touch { covered: crisp * touched, load: load.max(0.0), end })
    }
}

/// A Catmull–Rom curve through the path: points, how far along, width.
fn curve_of(mark: &Mark) -> Vec<([f64; 2], f64, f64)> {
    let path: Vec<([f64; 2], f64)> = mark.path.iter().copied().zip(mark.widths.iter().copied()).collect();
    if path.len() < 2 {
        return path.first().map(|&(point, width)| (point, 0.0, width)).into_iter().collect();
    }
    let at = |index: isize| path[index.clamp(0, path.len() as isize - 1) as usize];
    let mut curve: Vec<([f64; 2], f64, f64)> = Vec::with_capacity(path.len() * STEPS);
    let mut along = 0.0;
    for segment in 0..path.len() - 1 {
        let [(a, _), (b, w0), (c, w1), (d, _)] = [-1, 0, 1, 2].map(|k| at(segment as isize + k));
        let last = usize::from(segment + 2 == path.len());
        for step in 0..STEPS + last {
            let t = step as f64 / STEPS as f64;
            let point = [0, 1].map(|k: usize| {
                0.5 * (2.0 * b[k]
                    + (c[k] - a[k]) * t
                    + (2.0 * a[k] - 5.0 * b[k] + 4.0 * c[k] - d[k]) * t * t
                    + (3.0 * b[k] - a[k] - 3.0 * c[k] + d[k]) * t * t * t)
            });
            if let Some((before, ..)) = curve.last() {
                along += libm::hypot(point[0] - before[0], point[1] - before[1]);
            }
            // A belly is round.
            let eased = t * t * (3.0 - 2.0 * t);
            curve.push((point, along, w0 + eased * (w1 - w0)));
        }
    }
    curve
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mark() -> Mark {
        Mark {
            path: vec![[0.0, 0.0], [10.0, 0.0], [20.0, 0.0]],
            widths: vec![4.0; 3],
            amounts: vec![1.0],
            ..Mark::default()
        }
    }

    #[test]
    fn paint_lies_within_the_width_and_round_ends() {
        let planned = PlannedMark::new(&mark(), 0.0, 0, 1);
        let covered = |at| planned.at(at, 0.5, 0.0, 8.0).map_or(0.0, |touch| touch.covered);
        assert_eq!([[10.0, 1.6], [10.0, -1.6], [-1.5, 0.0], [21.5, 0.0]].map(covered), [1.0; 4]);
        assert_eq!([[10.0, 2.5], [10.0, -2.5], [-2.3, 0.0], [21.0, 2.0]].map(covered), [0.0; 4]);
    }

    #[test]
    fn a_flat_brush_has_corners() {
        let planned = PlannedMark::new(&Mark { chisel_degrees: Some(0.0), ..mark() }, 0.0, 0, 1);
        let covered = |at| planned.at(at, 0.5, 0.0, 8.0).map_or(0.0, |touch| touch.covered);
        assert_eq!([[0.5, 1.6], [0.5, -1.6], [-0.5, 0.0]].map(covered), [1.0, 1.0, 0.0]);
    }

    #[test]
    fn the_belly_is_on_the_side_it_is_asked_for() {
        let planned = PlannedMark::new(&Mark { side: 0.4, ..mark() }, 0.0, 0, 1);
        let covered = |at| planned.at(at, 0.5, 0.0, 8.0).map_or(0.0, |touch| touch.covered);
        // Left of a path that goes right is up, where y is less.
        assert_eq!([[10.0, -3.0], [10.0, 1.0]].map(covered), [1.0, 0.0]);
    }

    #[test]
    fn a_brush_that_runs_dry_touches_the_peaks_only_at_its_end() {
        let planned = PlannedMark::new(&Mark { dry: [0.0, 0.9, 0.3], ..mark() }, 0.0, 0, 1);
        let touched = |x: f64, tooth| planned.at([x, 0.3], tooth, 0.0, 8.0).is_some();
        assert!(touched(2.0, 0.1) && touched(18.0, 0.98) && !touched(18.0, 0.4));
    }

    #[test]
    fn one_point_is_a_dot() {
        let dot = Mark { path: vec![[5.0, 5.0]], widths: vec![2.0], amounts: vec![1.0], ..Mark::default() };
        let planned = PlannedMark::new(&dot, 0.0, 0, 1);
        assert!(planned.at([5.0, 5.7], 0.5, 0.0, 8.0).is_some());
        assert!(planned.at([5.0, 6.4], 0.5, 0.0, 8.0).is_none());
    }
}
