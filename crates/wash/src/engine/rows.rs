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

/// A field as one band sees it: windows by their place in the field, or rows by their number.
///
/// Where the ground is packed there are no whole rows.
#[derive(Debug)]
pub enum Rows<'a, T> {
    /// A field that nobody changes meanwhile.
    Shared(&'a Field<T>),
    /// The band's own rows, in place, between copies of its neighbours'.
    Banded {
        /// Values from one row to the next.
        stride: usize,
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
            Self::Shared(field) => &field.values()[place..][..len],
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
            Self::Shared(_) => panic!("a pass changes a field that it did not name"),
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

    /// The values from one place on to change, and those from a place in the row below.
    ///
    /// # Panics
    /// As [`Rows::at_mut`].
    #[inline]
    pub fn at_mut_and_below(&mut self, place: usize, place_below: usize, len: usize) -> (&mut [T], &[T]) {
        match self {
            Self::Shared(_) => panic!("a pass changes a field that it did not name"),
            Self::Banded { start, above, own, below, .. } => {
                let (own_start, own_end) = (*start, *start + own.len());
                let (rows, start, next) = if place < own_start {
                    let start = own_start - above.len();
                    (&mut **above, start, &**own)
                } else if place < own_end {
                    (&mut **own, own_start, &**below)
                } else {
                    (&mut **below, own_end, &[][..])
                };
                let end = start + rows.len();
                if place_below < end {
                    let (here, after) = rows[place - start..].split_at_mut(place_below - place);
                    (&mut here[..len], &after[..len])
                } else {
                    (&mut rows[place - start..][..len], &next[place_below - end..][..len])
                }
            }
        }
    }

    fn stride(&self) -> usize {
        match self {
            Self::Shared(field) => field.layout().stride(),
            Self::Banded { stride, .. } => *stride,
        }
    }

    /// One row.
    pub fn row(&self, row: usize) -> &[T] {
        self.at(row * self.stride(), self.stride())
    }

    /// One row, to change.
    ///
    /// # Panics
    /// As [`Rows::at_mut`].
    pub fn row_mut(&mut self, row: usize) -> &mut [T] {
        self.at_mut(row * self.stride(), self.stride())
    }

    /// One row to change, and the two below it.
    ///
    /// # Panics
    /// As [`Rows::at_mut`].
    pub fn row_mut_and_two_below(&mut self, row: usize) -> [&mut [T]; 3] {
        let Self::Banded { stride, start, above, own, below } = self else {
            panic!("a pass changes a field that it did not name");
        };
        let mut before = row * *stride - (*start - above.len());
        let mut pieces = [&mut **above, own, below].map(|piece| {
            let skipped = before.min(piece.len());
            before -= skipped;
            &mut piece[skipped..]
        });
        [(); 3].map(|()| {
            let last = pieces.len() - 1;
            let at = pieces.iter().position(|piece| !piece.is_empty()).unwrap_or(last);
            let (row, rest) = std::mem::take(&mut pieces[at]).split_at_mut(*stride);
            pieces[at] = rest;
            row
        })
    }

    /// One row to change, and the one below it.
    ///
    /// # Panics
    /// As [`Rows::at_mut`].
    pub fn row_mut_and_below(&mut self, row: usize) -> (&mut [T], &[T]) {
        self.at_mut_and_below(row * self.stride(), (row + 1) * self.stride(), self.stride())
    }
}

/// A field for every band: cut at the rows `cuts`, with `depth` rows of halo, if it is to be changed; else shared.
pub fn share<'a, T: Copy>(
    field: &'a mut Field<T>,
    ground: &Ground,
    cuts: &[usize],
    halos: &'a mut Vec<Halo<T>>,
    depth: Option<usize>,
) -> Vec<Rows<'a, T>> {
    let bands = cuts.len() - 1;
    let Some(depth) = depth else {
        let field: &'a Field<T> = field;
        return (0..bands).map(|_| Rows::Shared(field)).collect();
    };
    halos.resize_with(halos.len().max(bands), Halo::default);
    for (halo, cut) in halos.iter_mut().zip(cuts.windows(2)) {
        halo.save(field, ground, cut[0], cut[1], depth);
    }
    let stride = field.layout().stride();
    let mut rest = &mut field.values_mut()[ground.start(cuts[0])..];
    let banded = cuts.windows(2).zip(halos.iter_mut());
    banded
        .map(|(cut, halo)| {
            let [start, end] = [cut[0], cut[1]].map(|row| ground.start(row));
            let (own, after) = std::mem::take(&mut rest).split_at_mut(end - start);
            rest = after;
            Rows::Banded { stride, start, above: &mut halo.above, own, below: &mut halo.below }
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
        for mut rows in share(&mut field, &Ground::canvas(layout), &cuts, &mut halos, Some(2)) {
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
