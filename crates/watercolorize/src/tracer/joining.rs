//! Branches that continue each other become one line again: across forks, and over short gaps.

use girtin_grid::Raster;

use super::skeleton::{Branch, Branches};
use super::{Line, difference, length, point, turn};

/// A branch with a free end is a spur of the outline, no line, up to so many half widths and cells long.
const SPUR: [f32; 2] = [1.5, 1.0];
/// Two forks are one crossing when so many half widths and cells apart.
const CROSSING: [f32; 2] = [1.6, 3.0];
/// The same where two lines at each fork go on along the branch between, up to so much aslant, radians: lines that cross at a
/// slant share their middle.
const SLANTING: [f32; 2] = [4.0, 6.0];
const ASLANT: f32 = 0.55;
/// How far a branch is followed to see where it points, half widths, and at least and at most cells.
const AIM: [f32; 3] = [3.0, 6.0, 14.0];
/// How far two lines may turn to be one, radians: at a fork, and where nothing else goes on from it.
const STRAIGHT: f32 = 0.56;
const ALONE: f32 = 1.3;
/// The same over a gap, between each line and the gap.
const OVER_GAP: f32 = 0.5;
/// Longest gap, a part of what the two lines measure together: rows of dots stay dots.
const GAP: f32 = 0.6;
/// Least contrast in a gap, a part of the weaker line's.
const CONTRAST_IN_GAP: f32 = 0.3;
/// Most of two widths over the least: a twig does not continue a trunk.
const ALIKE: f32 = 3.0;

/// Lines as long as they go on: branches joined at their forks.
pub(super) fn joined(found: Branches, half_widths: &Raster<f32>) -> Vec<Vec<[u32; 2]>> {
    let forks = Forks::of(&found, half_widths);
    let (same, is_kept) = forks.cleared();
    let partner = forks.partners(&same, &is_kept);
    let cells = |end: usize| {
        let cells = found.branches[end / 2].cells.iter().copied();
        if end.is_multiple_of(2) { cells.collect::<Vec<_>>() } else { cells.rev().collect() }
    };
    chains(&partner, &is_kept).into_iter().map(|chain| chain.into_iter().flat_map(cells).collect()).collect()
}

/// Where branches meet. An end is twice its branch's number, and one more where the branch ends.
struct Forks<'a> {
    branches: &'a [Branch],
    /// Half width of the mask at each fork, cells.
    thickness: Vec<f32>,
    ends_at: Vec<Vec<usize>>,
}

impl<'a> Forks<'a> {
    fn of(found: &'a Branches, half_widths: &Raster<f32>) -> Self {
        let mut thickness = vec![0.0f32; found.forks];
        let mut ends_at = vec![Vec::new(); found.forks];
        for (number, branch) in found.branches.iter().enumerate() {
            for (side, cell) in [branch.cells.first(), branch.cells.last()].into_iter().enumerate() {
                if let (Some(fork), Some(&[x, y])) = (branch.forks[side], cell) {
                    thickness[fork] = thickness[fork].max(half_widths.at(x as usize, y as usize));
                    ends_at[fork].push(2 * number + side);
                }
            }
        }
        Self { branches: &found.branches, thickness, ends_at }
    }

    /// How far a branch is followed from a fork, cells.
    fn reach(&self, fork: usize) -> usize {
        (AIM[0] * self.thickness[fork]).clamp(AIM[1], AIM[2]) as usize
    }

    fn is_short(&self, branch: &Branch, [widths, cells]: [f32; 2], fork: usize) -> bool {
        (branch.cells.len() as f32) < widths * self.thickness[fork] + cells
    }

    /// Whether two lines go on from a fork along the branch that comes there.
    fn is_shared(&self, end: usize, fork: usize) -> bool {
        let aim = |end: usize| aim(&self.branches[end / 2], end % 2, 0, self.reach(fork))[1];
        let into = aim(end);
        let goes_on =
            |&&other: &&usize| other / 2 != end / 2 && turn(into, aim(other).map(|part| -part)) < ASLANT;
        self.ends_at[fork].iter().filter(goes_on).count() > 1
    }

    /// The forks that are one crossing, each with one before it or itself, and which branches are lines.
    fn cleared(&self) -> (Vec<usize>, Vec<bool>) {
        let mut same: Vec<usize> = (0..self.ends_at.len()).collect();
        let mut is_kept = vec![true; self.branches.len()];
        for (number, branch) in self.branches.iter().enumerate() {
            match branch.forks {
                [Some(a), Some(b)] => {
                    let is_crossing = self.is_short(branch, CROSSING, a)
                        || self.is_short(branch, SLANTING, a)
                            && self.is_shared(2 * number, a)
                            && self.is_shared(2 * number + 1, b);
                    if is_crossing {
                        let (a, b) = (root(&same, a), root(&same, b));
                        same[a.max(b)] = a.min(b);
                        is_kept[number] = false;
                    }
                }
                [Some(fork), None] | [None, Some(fork)] => {
                    is_kept[number] = !self.is_short(branch, SPUR, fork);
                }
                [None, None] => {}
            }
        }
        (same, is_kept)
    }

    /// The end that each end goes on from, the straightest first.
    fn partners(&self, same: &[usize], is_kept: &[bool]) -> Vec<Option<usize>> {
        let mut meeting = vec![Vec::new(); same.len()];
        for (fork, ends) in self.ends_at.iter().enumerate() {
            meeting[root(same, fork)].extend(ends.iter().copied().filter(|end| is_kept[end / 2]));
        }
        let mut pairs = Vec::new();
        for (fork, ends) in meeting.iter().enumerate() {
            let most = if ends.len() == 2 { ALONE } else { STRAIGHT };
            for (k, &a) in ends.iter().enumerate() {
                for &b in &ends[k + 1..] {
                    let bend = self.bend(a, b, fork);
                    if bend < most && a / 2 != b / 2 {
                        pairs.push((bend, a, b));
                    }
                }
            }
        }
        paired(pairs, 2 * self.branches.len())
    }

    /// How far a line turns that comes to a fork at one end and goes on at another, radians.
    fn bend(&self, a: usize, b: usize, fork: usize) -> f32 {
        let skipped = (0.7 * self.thickness[fork]) as usize;
        let [[from, into], [to, out]] =
            [a, b].map(|end| aim(&self.branches[end / 2], end % 2, skipped, self.reach(fork)));
        let away = out.map(|part| -part);
        let (bend, across) = (turn(into, away), difference(to, from));
        // Two lines side by side do not continue each other, though they point the same way.
        if length(across) > 2.0 { bend.max(0.5 * (turn(into, across) + turn(across, away))) } else { bend }
    }
}

/// Partners among so many ends, from pairs and what each costs: the cheapest first.
fn paired(mut pairs: Vec<(f32, usize, usize)>, ends: usize) -> Vec<Option<usize>> {
    pairs.sort_by(|p, q| p.0.total_cmp(&q.0).then((p.1, p.2).cmp(&(q.1, q.2))));
    let mut partner = vec![None; ends];
    for (_, a, b) in pairs {
        if partner[a].is_none() && partner[b].is_none() {
            (partner[a], partner[b]) = (Some(b), Some(a));
        }
    }
    partner
}

fn root(same: &[usize], mut fork: usize) -> usize {
    while same[fork] != fork {
        fork = same[fork];
    }
    fork
}

/// Where a branch comes to a fork, and where it points there.
fn aim(branch: &Branch, side: usize, skipped: usize, reach: usize) -> [[f32; 2]; 2] {
    let last = branch.cells.len() - 1;
    let at = |steps: usize| {
        let steps = steps.min(last);
        point(branch.cells[if side == 0 { steps } else { last - steps }])
    };
    let near = at(skipped.min(last / 3));
    [near, difference(near, at(skipped + reach))]
}

/// Sequences of parts whose ends are partners, each as the ends where its parts are entered.
fn chains(partner: &[Option<usize>], is_kept: &[bool]) -> Vec<Vec<usize>> {
    let mut is_done = vec![false; is_kept.len()];
    let mut chains = Vec::new();
    for number in 0..is_kept.len() {
        if is_done[number] || !is_kept[number] {
            continue;
        }
        let mut first = 2 * number;
        while let Some(before) = partner[first] {
            first = before ^ 1;
            if first / 2 == number {
                break;
            }
        }
        let mut chain = Vec::new();
        let mut entered = Some(first);
        while let Some(end) = entered.filter(|&end| !is_done[end / 2]) {
            is_done[end / 2] = true;
            chain.push(end);
            entered = partner[end ^ 1];
        }
        chains.push(chain);
    }
    chains
}

/// Lines that go on after a gap of up to `reach` cells made one, where there is some contrast in the gap.
pub(super) fn bridged(lines: Vec<Line>, field: &Raster<f32>, reach: f32) -> Vec<Line> {
    /// An end of a line: its place, and where the line points there.
    struct End {
        place: [f32; 2],
        into: [f32; 2],
    }
    let lengths: Vec<f32> = lines.iter().map(Line::length).collect();
    let contrasts: Vec<f32> = lines.iter().map(|line| line.contrast(field)).collect();
    let mean_widths: Vec<f32> = lines.iter().map(Line::mean_width).collect();
    let end = |number: usize| {
        let points = &lines[number / 2].points;
        let last = points.len() - 1;
        let at = |steps: usize| points[if number.is_multiple_of(2) { steps } else { last - steps }];
        End { place: at(0), into: difference(at(0), at(last.min(AIM[2] as usize))) }
    };
    let ends: Vec<End> = (0..2 * lines.len()).map(end).collect();
    // Ends by their column, so that only near ones are compared.
    let mut by_column: Vec<usize> =
        (0..ends.len()).filter(|&end| !lines[end / 2].closed && lines[end / 2].points.len() > 3).collect();
    by_column.sort_by(|&a, &b| ends[a].place[0].total_cmp(&ends[b].place[0]).then(a.cmp(&b)));
    let mut pairs = Vec::new();
    for (k, &a) in by_column.iter().enumerate() {
        for &b in &by_column[k + 1..] {
            let gap = difference(ends[b].place, ends[a].place);
            if gap[0] > reach {
                break;
            }
            let across = length(gap);
            if a / 2 == b / 2 || across > reach || across > GAP * (lengths[a / 2] + lengths[b / 2]) {
                continue;
            }
            let away = ends[b].into.map(|part| -part);
            // Over a gap of a cell or two the gap itself points anywhere.
            let loose = OVER_GAP * if across < 3.0 { 2.0 } else { 1.0 };
            let bend = turn(ends[a].into, gap).max(turn(gap, away));
            let (thin, thick) =
                (mean_widths[a / 2].min(mean_widths[b / 2]), mean_widths[a / 2].max(mean_widths[b / 2]));
            if bend > loose || turn(ends[a].into, away) > OVER_GAP || thick > ALIKE * thin {
                continue;
            }
            let weaker = contrasts[a / 2].min(contrasts[b / 2]);
            let steps = across.max(1.0) as usize;
            let at = |step: usize| {
                // Its ends are the lines' own.
                let part = 0.25 + 0.5 * (step as f32 + 0.5) / steps as f32;
                field.sample(ends[a].place[0] + part * gap[0], ends[a].place[1] + part * gap[1])
            };
            if (0..steps).map(at).sum::<f32>() < CONTRAST_IN_GAP * weaker * steps as f32 {
                continue;
            }
            pairs.push((across * (1.0 + bend), a, b));
        }
    }
    let partner = paired(pairs, ends.len());
    let parts = |chain: Vec<usize>| {
        let mut all = Line { closed: chain.len() == 1 && lines[chain[0] / 2].closed, ..Line::default() };
        for end in chain {
            let line = &lines[end / 2];
            if end.is_multiple_of(2) {
                all.points.extend(&line.points);
                all.widths.extend(&line.widths);
            } else {
                all.points.extend(line.points.iter().rev());
                all.widths.extend(line.widths.iter().rev());
            }
        }
        all
    };
    chains(&partner, &vec![true; lines.len()]).into_iter().map(parts).collect()
}
