//! Which fine cells are wet over coarse water: as drawn at first, then as the water creeps and dries, without its stairs.

use girtin_grid::{Field, Layout};
use rayon::prelude::*;

use crate::creep::Edge;
use crate::interpolate::Taps;
use crate::region::Region;
use crate::simulate_capillary_flow::Pores;
use crate::state::WashState;

/// Under film.
const WET: u8 = 1;
/// First wetted by creep, not by drawing.
const CREPT: u8 = 2;
/// It dried while fine cells in it were still wet: its film is 0, where that of paper that was never wet is unknown.
const DRIED: u8 = 4;
/// Fine cells in it are wet.
const HOLDS: u8 = 8;
/// Its film is known.
const KNOWN: u8 = WET | DRIED;

/// So much crept water a fine cell must see for the front to reach it.
const LEAST_CREPT: f32 = 0.1;
/// So much of a fine cell's surroundings must be wet for the front to reach it: less than a half, so that tongues one
/// coarse cell wide are not smoothed away.
const FRONT: f32 = 0.45;
/// What grain adds to that.
const RAGGEDNESS: f32 = 1.5;

/// A coarse cell among its neighbours.
type Around = [[f32; 3]; 3];
/// What each of five cells in a row adds to the middle three, smoothed.
const SMOOTHING: [[f32; 3]; 5] =
    [[0.25, 0.0, 0.0], [0.5, 0.25, 0.0], [0.25, 0.5, 0.25], [0.0, 0.25, 0.5], [0.0, 0.0, 0.25]];

/// What is known of each coarse cell besides its water.
#[derive(Debug)]
pub struct Shore {
    layout: Layout,
    marks: Field<u8>,
    /// Fine cells that are wet.
    count: Field<u8>,
    /// Part of it that was drawn wet; 1 where water crept.
    coverage: Field<f32>,
    /// Fine cells that have been wet.
    ever: Vec<u64>,
    region: Region,
    spline: Taps,
}

/// What decides whether a fine cell becomes wet.
#[derive(Clone, Copy, Debug)]
pub struct Front<'a> {
    /// The water, coarse.
    pub water: &'a WashState,
    /// Its film, carried on beyond the wet cells.
    pub film: &'a Field<f32>,
    /// From centres to centres.
    pub centers: &'a Taps,
    /// Fine wet mask.
    pub mask: &'a Field<u8>,
    /// Fine paper height.
    pub height: &'a Field<f32>,
    /// What holds an edge.
    pub contact: &'a Edge,
    /// What pores hold.
    pub pores: &'a Pores,
}

impl Shore {
    /// Coarse dry paper.
    pub fn new(layout: Layout, factor: usize) -> Self {
        Self {
            layout,
            marks: Field::<u8>::zeroed(layout),
            count: Field::<u8>::zeroed(layout),
            coverage: Field::<f32>::zeroed(layout),
            ever: vec![0; layout.width() * layout.height()],
            region: Region::empty(),
            spline: Taps::spline(factor),
        }
    }

    fn factor(&self) -> usize {
        self.spline.factor()
    }

    /// Where a fine cell's coarse one is, and its bit there.
    fn coarse(&self, [row, x]: [usize; 2]) -> ([usize; 2], u64) {
        let (y, x, factor) = (row - Layout::TOP, x - Layout::LEFT, self.factor());
        ([y / factor, x / factor], 1 << (y % factor * factor + x % factor))
    }

    /// The fine wet mask was drawn on.
    pub fn look(&mut self, fine_mask: &Field<u8>) {
        for row in self.layout.rows() {
            self.count.row_mut(row).fill(0);
        }
        let fine = fine_mask.layout();
        for row in fine.rows().filter(|&row| fine_mask.row(row).iter().any(|&wet| wet != 0)) {
            for x in fine.columns().filter(|&x| fine_mask.row(row)[x] != 0) {
                let ([cy, cx], bit) = self.coarse([row, x]);
                self.count.cells_mut(cy)[cx] += 1;
                self.ever[cy * self.layout.width() + cx] |= bit;
            }
        }
        let area = (self.factor() * self.factor()) as f32;
        for y in 0..self.layout.height() {
            for x in 0..self.layout.width() {
                let count = self.count.cells(y)[x];
                let marks = &mut self.marks.cells_mut(y)[x];
                *marks = if count > 0 { *marks | HOLDS } else { *marks & !HOLDS };
                // What was drawn and dried since counts still.
                let count = self.ever[y * self.layout.width() + x].count_ones();
                if *marks & CREPT == 0 {
                    self.coverage.cells_mut(y)[x] = count as f32 / area;
                }
            }
        }
    }

    /// Column and row of every coarse cell that holds wet fine cells.
    pub fn holding(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        (0..self.layout.height()).flat_map(move |y| {
            let count = self.count.cells(y);
            (0..count.len()).filter(move |&x| count[x] > 0).map(move |x| [x, y])
        })
    }

    /// The coarse wet mask was drawn on: what became wet is no creep.
    pub fn draw(&mut self, mask: &Field<u8>) {
        for row in self.layout.rows() {
            for (marks, &wet) in self.marks.row_mut(row).iter_mut().zip(mask.row(row)) {
                *marks = *marks & !(WET | if wet != 0 { DRIED } else { 0 }) | if wet != 0 { WET } else { 0 };
            }
        }
        self.find_region();
    }

    /// Whether any coarse cell is wet.
    pub fn is_wet(&self) -> bool {
        self.region.active().any(|row| self.marks.row(row).iter().any(|marks| marks & WET != 0))
    }

    fn find_region(&mut self) {
        self.region = Region::of(&self.marks, |marks| marks & (KNOWN | HOLDS) != 0);
    }

    /// Follows the coarse wet mask after a step of the water.
    pub fn follow(&mut self, mask: &Field<u8>) {
        let (mut changed, mut crept) = (Vec::new(), Vec::new());
        for row in self.layout.rows() {
            let (marks, wet) = (self.marks.row(row), mask.row(row));
            let same = marks.iter().zip(wet).fold(0, |any, (marks, wet)| any | (marks & WET) ^ wet) == 0;
            if same {
                continue;
            }
            for x in self.layout.columns() {
                let marks = &mut self.marks.row_mut(row)[x];
                if *marks & WET == wet[x] {
                    continue;
                }
                let kept = *marks & (HOLDS | CREPT);
                *marks = kept
                    | match (wet[x] != 0, kept & HOLDS != 0) {
                        (true, _) => WET,
                        (false, true) => DRIED,
                        (false, false) => 0,
                    };
                // Where it was drawn once it stays within that.
                let coverage = &mut self.coverage.row_mut(row)[x];
                if wet[x] != 0 && *coverage == 0.0 {
                    *marks |= CREPT;
                    *coverage = 1.0;
                    crept.push([row, x]);
                }
            }
            changed.push(row);
        }
        // The front went through what was drawn in part beside it.
        for [row, x] in crept {
            for row in row - 1..=row + 1 {
                let columns = x - 1..x + 2;
                let drawn =
                    self.coverage.row_mut(row)[columns.clone()].iter_mut().zip(&self.marks.row(row)[columns]);
                drawn.filter(|(_, marks)| *marks & WET != 0).for_each(|(coverage, _)| *coverage = 1.0);
            }
        }
        for row in changed {
            self.region.rescan(&self.marks, row, |marks| marks & (KNOWN | HOLDS) != 0);
        }
    }

    /// Carries the film on beyond the wet cells; returns the thinnest.
    pub fn carry_on(&self, water: &WashState, film: &mut Field<f32>) -> f32 {
        let mut thinnest = f32::INFINITY;
        for row in self.rows_around() {
            let columns = self.columns_around(row);
            let (above, here, below) = (row.saturating_sub(1), row, row + 1);
            let marks = [above, here, below].map(|row| self.marks.row(row));
            let depth = |row: usize, x: usize, marks: u8| {
                if marks & WET != 0 { water.pressure.row(row)[x] } else { 0.0 }
            };
            for x in columns.into_iter().flatten() {
                let known = marks[1][x] & KNOWN;
                let value = if known != 0 {
                    depth(row, x, known)
                } else {
                    let (mut sum, mut count) = (0.0, 0.0);
                    for (row, marks) in [above, here, below].into_iter().zip(marks) {
                        for (x, &marks) in (x - 1..).zip(&marks[x - 1..=x + 1]) {
                            if marks & KNOWN != 0 {
                                sum += depth(row, x, marks);
                                count += 1.0;
                            }
                        }
                    }
                    if count > 0.0 { sum / count } else { 0.0 }
                };
                film.row_mut(row)[x] = value;
                thinnest = if value < thinnest { value } else { thinnest };
            }
        }
        thinnest
    }

    /// The largest |u| or |v| of the water.
    pub fn fastest(&self, water: &WashState) -> f32 {
        let mut fastest = 0;
        for row in self.region.active() {
            for run in self.region.runs(row) {
                for field in [&water.u, &water.v] {
                    let faces = &field.row(row)[run.first..run.end];
                    fastest =
                        faces.iter().fold(fastest, |most: i32, face| most.max(face.abs().to_bits() as i32));
                }
            }
        }
        f32::from_bits(fastest as u32)
    }

    /// Rows with something in them, one more at both ends: beyond the canvas too, whose border is dry.
    fn rows_around(&self) -> std::ops::Range<usize> {
        let active = self.region.active();
        if active.is_empty() { active } else { active.start - 1..active.end + 1 }
    }

    /// The columns within a cell of the runs of a row and its neighbours, each once.
    fn columns_around(&self, row: usize) -> Vec<std::ops::Range<usize>> {
        let rows = self.region.active();
        let near = (row.saturating_sub(1)..=row + 1).filter(|row| rows.contains(row));
        let mut columns: Vec<_> =
            near.flat_map(|row| self.region.runs(row)).map(|run| run.first - 1..run.end + 1).collect();
        columns.sort_unstable_by_key(|columns| columns.start);
        let mut apart: Vec<std::ops::Range<usize>> = Vec::new();
        for columns in columns {
            match apart.last_mut() {
                Some(last) if columns.start <= last.end => last.end = last.end.max(columns.end),
                _ => apart.push(columns),
            }
        }
        apart
    }

    /// The fine cells that become wet now.
    pub fn reached(&self, front: &Front<'_>, in_parallel: bool) -> Vec<[usize; 2]> {
        let canvas = self.layout.rows();
        let around = self.rows_around();
        let rows = around.start.max(canvas.start)..around.end.min(canvas.end);
        let look = |row: usize| {
            let mut reached = Vec::new();
            for x in self.columns_around(row).into_iter().flatten() {
                if self.layout.columns().contains(&x) {
                    self.look_into(row, x, front, &mut reached);
                }
            }
            // Cells of one coarse row lie in several fine ones.
            reached.sort_unstable();
            reached
        };
        if in_parallel {
            rows.into_par_iter().flat_map_iter(look).collect()
        } else {
            rows.flat_map(look).collect()
        }
    }

    /// Looks for fine cells of one coarse cell that become wet.
    fn look_into(&self, row: usize, x: usize, front: &Front<'_>, reached: &mut Vec<[usize; 2]>) {
        let factor = self.factor();
        let (cy, cx) = (row - Layout::TOP, x - Layout::LEFT);
        let count = u32::from(self.count.row(row)[x]);
        if count == (factor * factor) as u32 {
            return;
        }
        let ever = self.ever[cy * self.layout.width() + cx];
        let mut near = 0;
        for row in row - 1..=row + 1 {
            near |= self.marks.row(row)[x - 1..=x + 1]
                .iter()
                .fold(0, |near, &marks| near | if marks & WET != 0 { marks } else { marks & HOLDS });
        }
        let may_rewet = ever.count_ones() > count && near & WET != 0;
        if near & HOLDS == 0 || !(may_rewet || near & CREPT != 0) {
            return;
        }
        let fine = front.mask.layout();
        let mut smoothed = None;
        for i in 0..factor {
            let fine_row = Layout::TOP + cy * factor + i;
            if !fine.rows().contains(&fine_row) {
                break;
            }
            let [above, here, below] = [fine_row - 1, fine_row, fine_row + 1].map(|row| front.mask.row(row));
            for j in 0..factor {
                let fine_x = Layout::LEFT + cx * factor + j;
                let beside = above[fine_x] | below[fine_x] | here[fine_x - 1] | here[fine_x + 1];
                if here[fine_x] != 0 || beside == 0 || !fine.columns().contains(&fine_x) {
                    continue;
                }
                let h = front.height.row(fine_row)[fine_x];
                let joins = if ever & 1 << (i * factor + j) != 0 {
                    may_rewet && self.is_rewet([row, x], [i, j], h, front)
                } else {
                    near & CREPT != 0
                        && self.is_at_front(
                            smoothed.get_or_insert_with(|| self.smoothed([row, x])),
                            [i, j],
                            h,
                        )
                };
                if joins {
                    reached.push([fine_row, fine_x]);
                }
            }
        }
    }

    /// A sum over a coarse cell and its neighbours, weighed for one of its fine cells.
    fn seen(
        &self,
        [row, x]: [usize; 2],
        [i, j]: [usize; 2],
        taps: &Taps,
        value: impl Fn(usize, usize) -> f32,
    ) -> f32 {
        let (down, across) = (taps.of(i), taps.of(j));
        let mut sum = 0.0;
        for (row, down) in (row - 1..).zip(down) {
            for (x, across) in (x - 1..).zip(across) {
                sum += down * across * value(row, x);
            }
        }
        sum
    }

    /// A fine cell that was wet and dried is wet again by the rule of creep, from what it sees of the film and pores.
    fn is_rewet(&self, coarse: [usize; 2], place: [usize; 2], height: f32, front: &Front<'_>) -> bool {
        let film = self.seen(coarse, place, front.centers, |row, x| front.film.row(row)[x]);
        let fill = self.seen(coarse, place, front.centers, |row, x| {
            front.water.saturation.row(row)[x] / front.pores.capacity(front.water.height.row(row)[x])
        });
        // The water's cells wetted each other by that rule, and then shared.
        film > front.contact.share * front.contact.need(height, fill)
    }

    /// A fine cell that was never wet becomes so when the smoothed edge of crept water has passed it.
    fn is_at_front(&self, [crept, covered]: &[Around; 2], [i, j]: [usize; 2], height: f32) -> bool {
        let (down, across) = (self.spline.of(i), self.spline.of(j));
        let seen = |around: &Around| {
            let row =
                |row: &[f32; 3]| row.iter().zip(across).map(|(value, weight)| value * weight).sum::<f32>();
            around.iter().zip(down).map(|(values, weight)| row(values) * weight).sum::<f32>()
        };
        seen(crept) > LEAST_CREPT && seen(covered) > FRONT + RAGGEDNESS * (height - 0.5)
    }

    /// Where water crept and what is covered, in a coarse cell and around it, each smoothed with its neighbours.
    fn smoothed(&self, [row, x]: [usize; 2]) -> [Around; 2] {
        let border = [self.layout.rows(), self.layout.columns()];
        let mut sums = [[[0.0; 3]; 3]; 2];
        for (i, row) in
            (row.saturating_sub(2)..=row + 2).enumerate().filter(|(_, row)| border[0].contains(row))
        {
            let (marks, coverage) = (self.marks.row(row), self.coverage.row(row));
            for (j, x) in (x - 2..=x + 2).enumerate().filter(|(_, x)| border[1].contains(x)) {
                if marks[x] & WET == 0 {
                    continue;
                }
                let crept = if marks[x] & CREPT != 0 { 1.0 } else { 0.0 };
                for (sum, value) in sums.iter_mut().zip([crept, coverage[x]]) {
                    for (sums, down) in sum.iter_mut().zip(SMOOTHING[i]) {
                        for (sum, across) in sums.iter_mut().zip(SMOOTHING[j]) {
                            *sum += down * across * value;
                        }
                    }
                }
            }
        }
        sums
    }

    /// Fine cells became wet.
    pub fn join(&mut self, cells: &[[usize; 2]]) {
        for &cell in cells {
            let ([y, x], bit) = self.coarse(cell);
            self.count.cells_mut(y)[x] += 1;
            self.ever[y * self.layout.width() + x] |= bit;
            let marks = &mut self.marks.cells_mut(y)[x];
            if *marks & HOLDS == 0 {
                *marks |= HOLDS;
                let row = y + Layout::TOP;
                self.region.rescan(&self.marks, row, |marks| marks & (KNOWN | HOLDS) != 0);
            }
        }
    }

    /// Fine cells dried.
    pub fn leave(&mut self, cells: &[[usize; 2]]) {
        let mut changed = Vec::new();
        for &cell in cells {
            let ([y, x], _) = self.coarse(cell);
            let count = &mut self.count.cells_mut(y)[x];
            *count -= 1;
            if *count == 0 {
                let marks = &mut self.marks.cells_mut(y)[x];
                *marks &= !(HOLDS | DRIED);
                if *marks & WET == 0 {
                    changed.push(y + Layout::TOP);
                }
            }
        }
        changed.sort_unstable();
        changed.dedup();
        for row in changed {
            self.region.rescan(&self.marks, row, |marks| marks & (KNOWN | HOLDS) != 0);
        }
    }
}
