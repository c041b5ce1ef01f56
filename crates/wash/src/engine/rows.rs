//! The rows of a field as one band sees them.

use girtin_grid::Field;

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
    /// Saves `depth` rows on both sides of the rows `start..end`, or as many as the field has.
    fn save(&mut self, field: &Field<T>, start: usize, end: usize, depth: usize) {
        let copy = |into: &mut Vec<T>, rows: std::ops::Range<usize>| {
            into.clear();
            for row in rows {
                into.extend_from_slice(field.row(row));
            }
        };
        copy(&mut self.above, start.saturating_sub(depth)..start);
        copy(&mut self.below, end..(end + depth).min(field.row_count()));
    }
}

/// A field as one band sees it: rows by their number in the field.
#[derive(Debug)]
pub enum Rows<'a, T> {
    /// A field that nobody changes meanwhile.
    Shared(&'a Field<T>),
    /// The band's own rows, in place, between copies of its neighbours'.
    Banded {
        /// Values from one row to the next.
        stride: usize,
        /// Number of the first own row.
        first: usize,
        /// Rows above the band's.
        above: &'a mut [T],
        /// The band's rows.
        own: &'a mut [T],
        /// Rows below the band's.
        below: &'a mut [T],
    },
}

impl<T: Copy> Rows<'_, T> {
    /// One row.
    pub fn row(&self, row: usize) -> &[T] {
        match self {
            Self::Shared(field) => field.row(row),
            Self::Banded { stride, first, above, own, below } => {
                let stride = *stride;
                if row < *first {
                    let from_end = *first - row;
                    &above[above.len() - from_end * stride..][..stride]
                } else {
                    let at = (row - first) * stride;
                    if at < own.len() { &own[at..][..stride] } else { &below[at - own.len()..][..stride] }
                }
            }
        }
    }

    /// One row, to change.
    ///
    /// # Panics
    /// The field is shared: its pass said it would not change it.
    pub fn row_mut(&mut self, row: usize) -> &mut [T] {
        self.row_mut_and_below(row).0
    }

    /// One row to change, and the one below it.
    ///
    /// # Panics
    /// As [`Rows::row_mut`].
    pub fn row_mut_and_below(&mut self, row: usize) -> (&mut [T], &[T]) {
        match self {
            Self::Shared(_) => panic!("a pass changes a field that it did not name"),
            Self::Banded { stride, first, above, own, below } => {
                let stride = *stride;
                if row < *first {
                    let at = above.len() - (*first - row) * stride;
                    let (here, after) = above[at..].split_at_mut(stride);
                    (here, if after.is_empty() { &own[..stride] } else { &after[..stride] })
                } else {
                    let at = (row - *first) * stride;
                    if at < own.len() {
                        let (here, after) = own[at..].split_at_mut(stride);
                        let after: &[T] = if after.is_empty() { below } else { after };
                        (here, &after[..stride.min(after.len())])
                    } else {
                        let (here, after) = below[at - own.len()..].split_at_mut(stride);
                        (here, &after[..stride.min(after.len())])
                    }
                }
            }
        }
    }
}

/// A field for every band: cut at `cuts`, with `depth` rows of halo, if it is to be changed; else shared.
pub fn share<'a, T: Copy>(
    field: &'a mut Field<T>,
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
        halo.save(field, cut[0], cut[1], depth);
    }
    let stride = field.layout().stride();
    let banded = field.bands_mut(cuts).into_iter().zip(halos.iter_mut()).zip(cuts);
    banded
        .map(|((band, halo), &first)| Rows::Banded {
            stride,
            first,
            above: &mut halo.above,
            own: band.into_rows(),
            below: &mut halo.below,
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
        for mut rows in share(&mut field, &cuts, &mut halos, Some(2)) {
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
