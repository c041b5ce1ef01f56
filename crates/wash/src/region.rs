//! Where the water is: runs of wet cells, row by row.
//!
//! Work is done only on runs, so dry paper costs nothing. A run that is wet throughout, as is the row above it, needs
//! no mask at all; any other run is widened to whole vectors and its kernels choose by the mask.

use std::ops::Range;

use girtin_grid::{Field, Layout};

/// Neighbouring cells of one row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// First field column.
    pub first: usize,
    /// Field column after the last.
    pub end: usize,
    /// Every cell of the run is wet and so is every cell above it, while the cells before and after it are dry.
    pub all_wet: bool,
}

impl Run {
    /// Whether this run and the row above it are wet wherever the other run, in the row above, has cells.
    pub fn covers(self, above: Self) -> bool {
        self.all_wet && self.first <= above.first && above.end <= self.end
    }

    /// Number of cells.
    pub fn len(self) -> usize {
        self.end - self.first
    }

    /// Number of cells of the whole vectors that hold the run.
    ///
    /// Kernels work on whole vectors: the cells of one that is not would be done one by one, and that is most of the time a
    /// short run takes. For the same reason kernels cut all their rows to the same length: a loop whose bounds have to be
    /// looked at does its last cells one by one.
    #[inline(always)]
    pub fn padded(self) -> usize {
        self.len().next_multiple_of(VECTOR)
    }

    /// The values behind the run that its last vector may reach, to be put back.
    #[inline(always)]
    pub fn beyond(self, row: &[f32]) -> Beyond {
        Beyond { end: self.end, values: row[self.end..][..VECTOR].as_chunks().0[0] }
    }
}

/// Values behind a run.
#[derive(Clone, Copy, Debug)]
pub struct Beyond {
    end: usize,
    values: [f32; VECTOR],
}

impl Beyond {
    /// Puts them back.
    #[inline(always)]
    pub fn put_back(self, row: &mut [f32]) {
        row[self.end..][..VECTOR].as_chunks_mut().0[0] = self.values;
    }
}

/// Kernels work on vectors of this many cells.
pub const VECTOR: usize = 16;
/// Runs with fewer dry cells between them are one: starting a kernel costs more than that.
const WORTH_A_GAP: usize = VECTOR;

/// Cells of a run from which on it pays to have kernels without masks.
const WORTH_NO_MASK: usize = VECTOR;

/// The first of these columns whose value is such, or their end.
///
/// Looks at many values at once before it looks for the one: a search that may end at any value is no loop of vectors.
pub fn first_where<T: Copy>(row: &[T], columns: Range<usize>, is_such: impl Fn(T) -> bool) -> usize {
    let values = &row[columns.clone()];
    let is_none = |block: &&[T]| !block.iter().fold(false, |any, &value| any | is_such(value));
    let skipped: usize = values.chunks(4 * VECTOR).take_while(is_none).map(<[T]>::len).sum();
    let found = values[skipped..].iter().position(|&value| is_such(value));
    found.map_or(columns.end, |at| columns.start + skipped + at)
}

/// The runs of all rows.
#[derive(Clone, Debug)]
pub struct Region {
    rows: Vec<Vec<Run>>,
    /// Rows outside have no runs.
    active: Range<usize>,
}

impl Region {
    /// One run a row, over the whole canvas, whatever is wet.
    pub fn whole(layout: Layout) -> Self {
        let mut rows = vec![Vec::new(); layout.rows().end + 2];
        for row in layout.rows() {
            rows[row].push(Run { first: layout.columns().start, end: layout.columns().end, all_wet: false });
        }
        Self { rows, active: layout.rows() }
    }

    /// No runs at all.
    pub fn empty() -> Self {
        Self { rows: vec![Vec::new(); Layout::TOP + 2], active: Layout::TOP..Layout::TOP }
    }

    /// The runs of cells for which `holds` is true of the field's value.
    pub fn of<T: Copy>(field: &Field<T>, holds: impl Fn(T) -> bool) -> Self {
        let layout = field.layout();
        let mut region =
            Self { rows: vec![Vec::new(); layout.rows().end + 2], active: Layout::TOP..Layout::TOP };
        for row in layout.rows() {
            region.rescan(field, row, &holds);
        }
        region
    }

    /// Looks at one row again.
    pub fn rescan<T: Copy>(&mut self, field: &Field<T>, row: usize, holds: impl Fn(T) -> bool) {
        let (here, above) = (field.row(row), field.row(row - 1));
        let runs = &mut self.rows[row];
        runs.clear();
        let columns = field.layout().columns();
        let mut x = columns.start;
        loop {
            let start = first_where(here, x..columns.end, &holds);
            if start == columns.end {
                break;
            }
            let end = first_where(here, start..columns.end, |value| !holds(value));
            let all_wet = first_where(above, start..end, |value| !holds(value)) == end;
            x = end;
            match runs.last_mut() {
                Some(last) if start < last.end + WORTH_A_GAP => {
                    *last = Run { first: last.first, end, all_wet: false };
                }
                _ => runs.push(Run { first: start, end, all_wet }),
            }
        }
        for run in runs.iter_mut() {
            // What a short run saves without a mask it would lose at its ends, which are no whole vectors.
            run.all_wet &= run.len() >= WORTH_NO_MASK;
            if run.all_wet {
                continue;
            }
            run.first -= run.first % VECTOR;
            run.end = run.end.next_multiple_of(VECTOR);
        }
        if !runs.is_empty() {
            self.active = if self.active.is_empty() {
                row..row + 1
            } else {
                self.active.start.min(row)..self.active.end.max(row + 1)
            };
        }
    }

    /// Runs that need masks begin at their first wet cell, and not at a whole vector, where they are a vector shorter then.
    pub fn tightened<T: Copy>(mut self, field: &Field<T>, holds: impl Fn(T) -> bool) -> Self {
        for row in self.active() {
            let cells = field.row(row);
            for run in self.rows[row].iter_mut().filter(|run| !run.all_wet) {
                let first = first_where(cells, run.first..run.end, &holds);
                let last = cells[first..run.end].iter().rposition(|&value| holds(value));
                let tight = Run { first, end: last.map_or(run.end, |last| first + last + 1), all_wet: false };
                if tight.padded() < run.len() {
                    *run = Run { end: first + tight.padded(), ..tight };
                }
            }
        }
        self
    }

    /// Looks at all active rows again and forgets those without runs at the ends.
    pub fn shrink<T: Copy>(&mut self, field: &Field<T>, holds: impl Fn(T) -> bool) {
        let active = std::mem::replace(&mut self.active, Layout::TOP..Layout::TOP);
        for row in active {
            self.rescan(field, row, &holds);
        }
    }

    /// The runs of a row.
    pub fn runs(&self, row: usize) -> &[Run] {
        &self.rows[row]
    }

    /// Whether a run of the row above has all columns of a run of this row.
    pub fn is_below_one(&self, row: usize, run: Run) -> bool {
        let above = &self.rows[row - 1];
        let at = above.partition_point(|above| above.end < run.end);
        above.get(at).is_some_and(|above| above.first <= run.first)
    }

    /// The rows that may have runs.
    pub fn active(&self) -> Range<usize> {
        self.active.clone()
    }

    /// Cells in all runs.
    pub fn cells(&self) -> usize {
        self.rows[self.active()].iter().flatten().map(|run| run.len()).sum()
    }

    /// Cuts the active rows into at most `bands` bands of about equal work, no band without rows.
    pub fn cuts(&self, bands: usize) -> Vec<usize> {
        let cells = self.cells();
        let mut cuts = vec![self.active.start];
        let mut before = 0;
        for row in self.active() {
            before += self.rows[row].iter().map(|run| run.len()).sum::<usize>();
            // The band ends here when it has its share of the work.
            if before * bands >= cells * cuts.len() && row + 1 < self.active.end && cuts.len() < bands {
                cuts.push(row + 1);
            }
        }
        cuts.push(self.active.end);
        cuts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mask(rows: &[&str]) -> Field<u8> {
        let mut field = Field::<u8>::zeroed(Layout::new(rows[0].len(), rows.len()));
        for (y, row) in rows.iter().enumerate() {
            for (cell, letter) in field.cells_mut(y).iter_mut().zip(row.bytes()) {
                *cell = u8::from(letter == b'#');
            }
        }
        field
    }

    #[test]
    fn every_wet_cell_is_in_exactly_one_run() {
        let ragged = format!("#..##{}#", ".".repeat(150));
        let (full, dry) = ("#".repeat(156), ".".repeat(156));
        let field = mask(&[&ragged, &full, &full, &dry]);
        let region = Region::of(&field, |cell| cell != 0);
        for row in field.layout().rows() {
            for x in field.layout().columns().filter(|&x| field.row(row)[x] != 0) {
                let holding = region.runs(row).iter().filter(|run| (run.first..run.end).contains(&x)).count();
                assert_eq!(holding, 1, "row {row} column {x}");
            }
        }
        assert_eq!(region.active(), 1..4);
        assert!(!region.runs(2)[0].all_wet, "the row above is ragged");
        assert!(region.runs(3)[0].all_wet);
    }

    #[test]
    fn bands_cover_the_active_rows_and_share_the_work() {
        let field = mask(&[
            "................",
            "################",
            "################",
            "################",
            "#...............",
        ]);
        let region = Region::of(&field, |cell| cell != 0);
        assert_eq!(region.cuts(1), [2, 6]);
        assert_eq!(region.cuts(2), [2, 4, 6]);
        assert!(region.cuts(99).windows(2).all(|cut| cut[0] < cut[1]));
    }
}
