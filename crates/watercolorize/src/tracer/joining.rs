//! Branches that continue each other become one line again: across forks, and over short gaps.

use girtin_grid::Raster;

use super::skeleton::{Branch, Branches};
use super::{Line, difference, length, point, turn};

/// A branch with a free end is a spur of the outline, no line, up to so many half widths and cells long.
const SPUR: [f32; 2] = [1.5, 1.0];
/// Two forks are one crossing when so many half widths and cells apart: lines that cross at a slant share their middle.
const CROSSING: [f32; 2] = [1.6, 3.0];
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
    let Branches { branches, forks } = found;
    let thick = |cell: &[u32; 2]| half_widths.at(cell[0] as usize, cell[1] as usize);
    let mut thickness = vec![0.0f32; forks];
    for branch in &branches {
        for (fork, cell) in branch.forks.iter().zip([branch.cells.first(), branch.cells.last()]) {
            if let (Some(fork), Some(cell)) = (fork, cell) {
                thickness[*fork] = thickness[*fork].max(thick(cell));
            }
        }
    }
    // Short branches between two forks make them one.
    let mut same: Vec<usize> = (0..forks).collect();
    let is_short = |branch: &Branch, [widths, cells]: [f32; 2], fork: usize| {
        (branch.cells.len() as f32) < widths * thickness[fork] + cells
    };
    let mut is_kept = vec![true; branches.len()];
    for (branch, kept) in branches.iter().zip(&mut is_kept) {
        match branch.forks {
            [Some(a), Some(b)] if is_short(branch, CROSSING, a) => {
                let (a, b) = (root(&same, a), root(&same, b));
                same[a.max(b)] = a.min(b);
                *kept = false;
            }
            [Some(fork), None] | [None, Some(fork)] if is_short(branch, SPUR, fork) => *kept = false,
            _ => {}
        }
    }
    // An end is twice its branch's number, and one more where the branch ends.
    let mut ends_at = vec![Vec::new(); forks];
    for (number, branch) in branches.iter().enumerate().filter(|&(number, _)| is_kept[number]) {
        for (side, fork) in branch.forks.iter().enumerate() {
            if let Some(fork) = fork {
                ends_at[root(&same, *fork)].push(2 * number + side);
            }
        }
    }
    let mut partner: Vec<Option<usize>> = vec![None; 2 * branches.len()];
    for (fork, ends) in ends_at.iter().enumerate() {
        let reach = (AIM[0] * thickness[fork]).clamp(AIM[1], AIM[2]) as usize;
        let skipped = (0.7 * thickness[fork]) as usize;
        let most = if ends.len() == 2 { ALONE } else { STRAIGHT };
        let mut pairs = Vec::new();
        for (k, &a) in ends.iter().enumerate() {
            for &b in &ends[k + 1..] {
                let [from, into] = aim(&branches[a / 2], a % 2, skipped, reach);
                let [to, out] = aim(&branches[b / 2], b % 2, skipped, reach);
                let away = [-out[0], -out[1]];
                let mut bend = turn(into, away);
                let across = difference(to, from);
                if length(across) > 2.0 {
                    bend = bend.max(0.5 * (turn(into, across) + turn(across, away)));
                }
                if bend < most && a / 2 != b / 2 {
                    pairs.push((bend, a, b));
                }
            }
        }
        pairs.sort_by(|p, q| p.0.total_cmp(&q.0).then((p.1, p.2).cmp(&(q.1, q.2))));
        for (_, a, b) in pairs {
            if partner[a].is_none() && partner[b].is_none() {
                (partner[a], partner[b]) = (Some(b), Some(a));
            }
        }
    }
    let cells = |end: usize| {
        let cells = branches[end / 2].cells.iter().copied();
        if end.is_multiple_of(2) { cells.collect::<Vec<_>>() } else { cells.rev().collect() }
    };
    chains(&partner, &is_kept).into_iter().map(|chain| chain.into_iter().flat_map(cells).collect()).collect()
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
            let (thin, thick) = (mean_widths[a / 2].min(mean_widths[b / 2]), mean_widths[a / 2].max(mean_widths[b / 2]));
            if bend > loose || turn(ends[a].into, away) > OVER_GAP || thick > ALIKE * thin {
                continue;
            }
            let weaker = contrasts[a / 2].min(contrasts[b / 2]);
            let steps = across.max(1.0) as usize;
            let at = |step: usize| {
                let part = (step as f32 + 0.5) / steps as f32;
                field.sample(ends[a].place[0] + part * gap[0], ends[a].place[1] + part * gap[1])
            };
            if (0..steps).map(at).sum::<f32>() < CONTRAST_IN_GAP * weaker * steps as f32 {
                continue;
            }
            pairs.push((across * (1.0 + bend), a, b));
        }
    }
    pairs.sort_by(|p, q| p.0.total_cmp(&q.0).then((p.1, p.2).cmp(&(q.1, q.2))));
    let mut partner = vec![None; ends.len()];
    for (_, a, b) in pairs {
        if partner[a].is_none() && partner[b].is_none() {
            (partner[a], partner[b]) = (Some(b), Some(a));
        }
    }
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
