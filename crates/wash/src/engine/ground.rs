//! Where the runs of wet cells lie in memory.
//!
//! Usually a row of a field is a row of the canvas, dry cells and all. Of a large sheet with strokes on it every row of every
//! field then lies on a page of its own, of which a few cells are wet. A *packed* ground keeps of each row only what its runs
//! and those above and below them see, one stretch after the other, so that strokes stream through the processor like a
//! wash that is wet all over. Kernels do not know: they see a window around a run.

use std::ops::Range;

use girtin_grid::{Field, Layout};

use crate::region::{Region, Run, VECTOR};

/// Cells of a window before its run.
pub const BEFORE: usize = 2;
/// Cells of a window behind its run: as far as the run's last vector reaches, and a cell more.
const BEHIND: usize = VECTOR;

/// Where each row's cells lie in the values of a field.
#[derive(Clone, Debug)]
pub struct Ground {
    canvas: Layout,
    packing: Option<Packing>,
}

#[derive(Clone, Debug)]
struct Packing {
    layout: Layout,
    /// Where each row begins, and where the last one ends.
    starts: Vec<usize>,
    stretches: Vec<Vec<Stretch>>,
    /// Where the window of each run begins in the row above, its own and the one below, from where the row begins.
    windows: Vec<Vec<[usize; 3]>>,
}

/// Neighbouring cells of a row that are kept, from a whole vector on.
#[derive(Clone, Copy, Debug)]
struct Stretch {
    /// First field column.
    first: usize,
    /// Field column after the last.
    end: usize,
    /// Where the first one lies.
    start: usize,
}

/// A run and the cells beside it, in its row and the rows above and below.
#[derive(Clone, Copy, Debug)]
pub struct Window {
    /// The run, by columns of the window.
    pub run: Run,
    /// Field column of the window's first cell, for rows that lie as on the canvas.
    pub column: usize,
    /// Number of cells.
    len: usize,
    /// Where the window begins in the row above, its own and the one below.
    starts: [usize; 3],
}

impl Window {
    fn new(run: Run, starts: [usize; 3]) -> Self {
        let len = run.len();
        let relative = Run { first: BEFORE, end: BEFORE + len, all_wet: run.all_wet };
        Self { run: relative, column: run.first - BEFORE, len: BEFORE + len + BEHIND, starts }
    }

    /// Its part of the row above.
    #[inline]
    pub fn above<'a, T>(&self, row: &'a [T]) -> &'a [T] {
        &row[self.starts[0]..][..self.len]
    }

    /// The same, to change.
    #[inline]
    pub fn above_mut<'a, T>(&self, row: &'a mut [T]) -> &'a mut [T] {
        &mut row[self.starts[0]..][..self.len]
    }

    /// Its part of its own row.
    #[inline]
    pub fn here<'a, T>(&self, row: &'a [T]) -> &'a [T] {
        &row[self.starts[1]..][..self.len]
    }

    /// The same, to change.
    #[inline]
    pub fn here_mut<'a, T>(&self, row: &'a mut [T]) -> &'a mut [T] {
        &mut row[self.starts[1]..][..self.len]
    }

    /// Its part of the row below.
    #[inline]
    pub fn below<'a, T>(&self, row: &'a [T]) -> &'a [T] {
        &row[self.starts[2]..][..self.len]
    }

    /// The window of a row that lies as on the canvas.
    #[inline]
    pub fn of<'a, T>(&self, row: &'a [T]) -> &'a [T] {
        &row[self.column..][..self.len]
    }

    /// The same, to change.
    #[inline]
    pub fn of_mut<'a, T>(&self, row: &'a mut [T]) -> &'a mut [T] {
        &mut row[self.column..][..self.len]
    }
}

impl Packing {
    /// Where a cell lies that is kept.
    fn place(&self, row: usize, column: usize) -> usize {
        let stretches = &self.stretches[row];
        let holding = &stretches[stretches.partition_point(|stretch| stretch.end <= column)];
        holding.start + column - holding.first
    }
}

impl Ground {
    /// Rows lie as on the canvas.
    pub fn canvas(canvas: Layout) -> Self {
        Self { canvas, packing: None }
    }

    /// Of each row only what the runs of the region see.
    pub fn packed(region: &Region, canvas: Layout) -> Self {
        let active = region.active();
        let rows = active.start.saturating_sub(1)..active.end + 1;
        let mut stretches = vec![Vec::new(); rows.end];
        let mut starts = vec![0; rows.end + 1];
        let mut total = 0;
        for row in rows.clone() {
            starts[row] = total;
            let near = row.saturating_sub(1)..(row + 2).min(active.end);
            let mut seen: Vec<Run> = near.flat_map(|row| region.runs(row)).copied().collect();
            seen.sort_unstable_by_key(|run| run.first);
            let stretches: &mut Vec<Stretch> = &mut stretches[row];
            for run in seen {
                let (first, end) = (run.first - BEFORE, run.end + BEHIND);
                match stretches.last_mut() {
                    Some(last) if first <= last.end => last.end = last.end.max(end),
                    _ => stretches.push(Stretch { first, end, start: 0 }),
                }
            }
            for stretch in stretches {
                // The row's own run begins at a cache line, for it is read and written most.
                let own = region.runs(row).iter().find(|run| run.first >= stretch.first);
                let before = own.map_or(0, |run| run.first - stretch.first);
                stretch.start = (total + before).next_multiple_of(VECTOR) - before;
                total = stretch.start + (stretch.end - stretch.first);
            }
            total = total.next_multiple_of(VECTOR);
        }
        starts[rows.end] = total;
        // They are one row of a field.
        let layout = Layout::new(total, 1);
        let offset = layout.stride() + Layout::LEFT;
        starts.iter_mut().for_each(|start| *start += offset);
        stretches.iter_mut().flatten().for_each(|stretch| stretch.start += offset);
        let mut packing = Packing { layout, starts, stretches, windows: vec![Vec::new(); rows.end] };
        for row in active {
            let of_run = |run: &Run| {
                [row - 1, row, row + 1]
                    .map(|row| packing.place(row, run.first - BEFORE) - packing.starts[row])
            };
            packing.windows[row] = region.runs(row).iter().map(of_run).collect();
        }
        Self { canvas, packing: Some(packing) }
    }

    /// The layout of fields whose rows lie so.
    pub fn layout(&self) -> Layout {
        self.packing.as_ref().map_or(self.canvas, |packing| packing.layout)
    }

    /// The most values that a row has, packed or as on the canvas. Where a row's runs lie close, the gaps before their cache
    /// lines may take more than the dry cells between them did.
    pub fn longest(&self) -> usize {
        let packed = self.packing.iter().flat_map(|packing| packing.starts.windows(2));
        let packed = packed.map(|starts| starts[1] - starts[0]).max();
        self.canvas.stride().max(packed.unwrap_or(0))
    }

    /// Where a row begins, if there is such a row, or where the last one ends.
    pub fn start(&self, row: usize) -> usize {
        match &self.packing {
            None => row.min(self.canvas.row_count()) * self.canvas.stride(),
            Some(packing) => packing.starts[row.min(packing.starts.len() - 1)],
        }
    }

    /// A row of a field.
    pub fn row<'a, T: Copy>(&self, field: &'a Field<T>, row: usize) -> &'a [T] {
        &field.values()[self.span(row)]
    }

    /// Where a row lies that a run sees.
    #[inline]
    pub fn span(&self, row: usize) -> Range<usize> {
        match &self.packing {
            None => row * self.canvas.stride()..(row + 1) * self.canvas.stride(),
            Some(packing) => packing.starts[row]..packing.starts[row + 1],
        }
    }

    /// Whether rows hold nothing but what runs see.
    pub fn is_packed(&self) -> bool {
        self.packing.is_some()
    }

    /// Where a cell lies; it must be kept.
    pub fn place(&self, row: usize, column: usize) -> usize {
        match &self.packing {
            None => row * self.canvas.stride() + column,
            Some(packing) => packing.place(row, column),
        }
    }

    /// The windows of a row's runs.
    pub fn windows<'a>(&'a self, region: &'a Region, row: usize) -> impl Iterator<Item = Window> + use<'a> {
        let windows = self.packing.as_ref().map(|packing| &packing.windows[row]);
        region.runs(row).iter().enumerate().map(move |(number, &run)| {
            Window::new(run, windows.map_or([run.first - BEFORE; 3], |windows| windows[number]))
        })
    }

    /// Copies what is kept of a field of the canvas.
    pub fn gather<T: Copy>(&self, canvas: &Field<T>, packed: &mut Field<T>) {
        self.stretches(|row, columns, start| {
            let canvas = &canvas.row(row)[columns];
            packed.values_mut()[start..][..canvas.len()].copy_from_slice(canvas);
        });
    }

    /// Copies it back.
    pub fn scatter<T: Copy>(&self, packed: &Field<T>, canvas: &mut Field<T>) {
        self.stretches(|row, columns, start| {
            let canvas = &mut canvas.row_mut(row)[columns];
            canvas.copy_from_slice(&packed.values()[start..][..canvas.len()]);
        });
    }

    /// Row, field columns and place of whatever is kept.
    fn stretches(&self, mut each: impl FnMut(usize, Range<usize>, usize)) {
        let Some(packing) = &self.packing else { return };
        for (row, stretches) in packing.stretches.iter().enumerate() {
            for stretch in stretches {
                each(row, stretch.first..stretch.end, stretch.start);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_packed_window_holds_what_the_canvas_has_there() {
        let canvas = Layout::new(900, 40);
        let mut mask = Field::<u8>::zeroed(canvas);
        let mut values = Field::<f32>::zeroed(canvas);
        for y in 0..40usize {
            for x in 0..900usize {
                let is_wet = x.abs_diff(3 * y + 20) < 17 || x.abs_diff(290 - 5 * y) < 9 || x > 897;
                mask.cells_mut(y)[x] = u8::from(is_wet && y != 12);
                values.cells_mut(y)[x] = (1000 * y + x) as f32;
            }
        }
        let region = Region::of(&mask, |wet| wet != 0);
        let ground = Ground::packed(&region, canvas);
        let mut packed = Field::<f32>::zeroed(ground.layout());
        ground.gather(&values, &mut packed);
        assert!(ground.layout().width() < 900 * 40 / 2, "it is smaller");
        for row in region.active() {
            for window in ground.windows(&region, row) {
                let seen = [row - 1, row, row + 1].map(|row| ground.row(&packed, row));
                let seen = [window.above(seen[0]), window.here(seen[1]), window.below(seen[2])];
                for (row, seen) in (row - 1..).zip(seen) {
                    assert_eq!(seen, window.of(values.row(row)), "row {row}");
                }
            }
        }
        let mut back = Field::<f32>::zeroed(canvas);
        ground.scatter(&packed, &mut back);
        for row in region.active() {
            for run in region.runs(row) {
                assert_eq!(back.row(row)[run.first..run.end], values.row(row)[run.first..run.end]);
            }
        }
    }
}
