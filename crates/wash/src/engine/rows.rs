//! The rows of a field as one band sees them.

use std::ops::Range;

use girtin_grid::Field;

use super::ground::Ground;

/// Copies of the rows just outside a band, which the band may change for itself.
#[derive(Debug)]
pub struct Halo<T> {
    above: Vec<T>,
    below: Vec<T>,
}

impl<T> Default for Halo<T> {
    fn default() -> Self {
        Self { above: Vec::new(), below: Vec::new() }
    }
}

impl<T: Copy> Halo<T> {
    /// Saves `depth` rows on both sides of the rows `start..end`, or as many as there are.
    fn save(&mut self, field: &Field<T>, ground: &Ground, start: usize, end: usize, depth: usize) {
        let copy = |into: &mut Vec<T>, rows: Range<usize>| {
            into.clear();
            into.extend_from_slice(&field.values()[ground.start(rows.start)..ground.start(rows.end)]);
        };
        copy(&mut self.above, start.saturating_sub(depth)..start);
        copy(&mut self.below, end..end + depth);
    }
}

/// A field as one band sees it.
#[derive(Debug)]
pub enum Rows<'a, T> {
    /// A field that nobody changes meanwhile.
    Shared {
        /// How its rows lie.
        ground: &'a Ground,
        /// The field.
        field: &'a Field<T>,
    },
    /// The band's own rows, in place, between copies of its neighbours'.
    Banded {
        /// How the field's rows lie.
        ground: &'a Ground,
        /// Where the first own row begins in the field.
        start: usize,
        /// Rows above the band's.
        above: &'a mut [T],
        /// The band's rows.
        own: &'a mut [T],
        /// Rows below the band's.
        below: &'a mut [T],
    },
}

impl<T: Copy> Rows<'_, T> {
    /// The values from one place on, within a row.
    #[inline]
    pub fn at(&self, place: usize, len: usize) -> &[T] {
        match self {
            Self::Shared { field, .. } => &field.values()[place..][..len],
            Self::Banded { start, above, own, below, .. } => match place.checked_sub(*start) {
                None => &above[above.len() - (start - place)..][..len],
                Some(place) if place < own.len() => &own[place..][..len],
                Some(place) => &below[place - own.len()..][..len],
            },
        }
    }

    /// The same, to change.
    ///
    /// # Panics
    /// The field is shared: its pass said it would not change it.
    #[inline]
    pub fn at_mut(&mut self, place: usize, len: usize) -> &mut [T] {
        match self {
            Self::Shared { .. } => panic!("a pass changes a field that it did not name"),
            Self::Banded { start, above, own, below, .. } => match place.checked_sub(*start) {
                None => {
                    let place = above.len() - (*start - place);
                    &mut above[place..][..len]
                }
                Some(place) if place < own.len() => &mut own[place..][..len],
                Some(place) => &mut below[place - own.len()..][..len],
            },
        }
    }

    #[inline]
    fn span(&self, row: usize) -> Range<usize> {
        match self {
            Self::Shared { ground, .. } | Self::Banded { ground, .. } => ground.span(row),
        }
    }

    /// One row.
    #[inline]
    pub fn row(&self, row: usize) -> &[T] {
        let span = self.span(row);
        self.at(span.start, span.len())
    }

    /// One row, to change.
    ///
    /// # Panics
    /// As [`Rows::at_mut`].
    #[inline]
    pub fn row_mut(&mut self, row: usize) -> &mut [T] {
        let span = self.span(row);
        self.at_mut(span.start, span.len())
    }

    /// One row to change, and the one below it.
    ///
    /// # Panics
    /// As [`Rows::at_mut`].
    #[inline]
    pub fn row_mut_and_below(&mut self, row: usize) -> (&mut [T], &[T]) {
        let (here, below) = (self.span(row), self.span(row + 1));
        match self {
            Self::Shared { .. } => panic!("a pass changes a field that it did not name"),
            Self::Banded { start, above, own, below: rows_below, .. } => {
                let (own_start, own_end) = (*start, *start + own.len());
                let (rows, start, next) = if here.start < own_start {
                    let start = own_start - above.len();
                    (&mut **above, start, &**own)
                } else if here.start < own_end {
                    (&mut **own, own_start, &**rows_below)
                } else {
                    (&mut **rows_below, own_end, &[][..])
                };
                let (first, is_apart) = (here.start - start, below.start == start + rows.len());
                if is_apart {
                    (&mut rows[first..], &next[..below.len()])
                } else {
                    let (here, after) = rows[first..].split_at_mut(here.len());
                    (here, &after[..below.len()])
                }
            }
        }
    }

    /// One row to change, and the two below it.
    ///
    /// # Panics
    /// As [`Rows::at_mut`].
    pub fn row_mut_and_two_below(&mut self, row: usize) -> [&mut [T]; 3] {
        let [here, below, far] = [row, row + 1, row + 2].map(|row| self.span(row).len());
        let mut pieces = self.pieces_from(row);
        [next_row(&mut pieces, here), next_row(&mut pieces, below), next_row(&mut pieces, far)]
    }

    /// A row and all below it, in pieces.
    #[inline]
    fn pieces_from(&mut self, row: usize) -> [&mut [T]; 3] {
        let place = self.span(row).start;
        match self {
            Self::Shared { .. } => panic!("a pass changes a field that it did not name"),
            Self::Banded { start, above, own, below, .. } => match place.checked_sub(*start) {
                None => {
                    let place = above.len() - (*start - place);
                    [&mut above[place..], own, below]
                }
                Some(place) if place < own.len() => [&mut own[place..], below, &mut []],
                Some(place) => [&mut below[place - own.len()..], &mut [], &mut []],
            },
        }
    }
}

/// Cuts a row off the pieces of a field.
#[inline]
fn next_row<'a, T>(pieces: &mut [&'a mut [T]; 3], len: usize) -> &'a mut [T] {
    let [first, second, third] = pieces;
    let piece = if !first.is_empty() {
        first
    } else if !second.is_empty() {
        second
    } else {
        third
    };
    let (row, rest) = std::mem::take(piece).split_at_mut(len);
    *piece = rest;
    row
}

/// A field for every band: cut at the rows `cuts`, with `depth` rows of halo, if it is to be changed; else shared.
pub fn share<'a, T: Copy>(
    field: &'a mut Field<T>,
    ground: &'a Ground,
    cuts: &[usize],
    halos: &'a mut Vec<Halo<T>>,
    depth: Option<usize>,
) -> Vec<Rows<'a, T>> {
    let bands = cuts.len() - 1;
    let Some(depth) = depth else {
        let field: &'a Field<T> = field;
        return (0..bands).map(|_| Rows::Shared { ground, field }).collect();
    };
    halos.resize_with(halos.len().max(bands), Halo::default);
    for (halo, cut) in halos.iter_mut().zip(cuts.windows(2)) {
        halo.save(field, ground, cut[0], cut[1], depth);
    }
    let mut rest = &mut field.values_mut()[ground.start(cuts[0])..];
    let banded = cuts.windows(2).zip(halos.iter_mut());
    banded
        .map(|(cut, halo)| {
            let [start, end] = [cut[0], cut[1]].map(|row| ground.start(row));
            let (own, after) = std::mem::take(&mut rest).split_at_mut(end - start);
            rest = after;
            Rows::Banded { ground, start, above: &mut halo.above, own, below: &mut halo.below }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use girtin_grid::{Field, Layout};

    use super::*;

    #[test]
    fn a_band_sees_its_neighbours_rows_and_changes_only_its_own() {
        let layout = Layout::new(4, 9);
        let mut field = Field::<f32>::zeroed(layout);
        for row in 0..field.row_count() {
            field.row_mut(row).fill(row as f32);
        }
        let cuts = [1, 4, 10];
        let mut halos = Vec::new();
        let ground = Ground::canvas(layout);
        for mut rows in share(&mut field, &ground, &cuts, &mut halos, Some(2)) {
            for row in 3..=4 {
                assert_eq!(rows.row(row)[0], row as f32);
                let (here, below) = rows.row_mut_and_below(row);
                assert_eq!(below[0], (row + 1) as f32);
                here[0] += 100.0;
                here[0] -= 100.0;
            }
            rows.row_mut(3)[1] += 0.5;
        }
        assert_eq!(field.row(3)[1], 3.5, "changed once, by its owner");
    }
}
