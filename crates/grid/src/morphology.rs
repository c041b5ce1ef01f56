//! Dilation and erosion of rasters, by squares.

use rayon::prelude::*;

use crate::Raster;

/// The most of each cell and those up to `radius` from it, to the sides and up and down.
pub fn dilated<T: Copy + PartialOrd + Send + Sync>(raster: &Raster<T>, radius: usize) -> Raster<T> {
    extremes(raster, radius, |a, b| if b > a { b } else { a })
}

/// The least of each cell and those up to `radius` from it, to the sides and up and down.
pub fn eroded<T: Copy + PartialOrd + Send + Sync>(raster: &Raster<T>, radius: usize) -> Raster<T> {
    extremes(raster, radius, |a, b| if b < a { b } else { a })
}

fn extremes<T: Copy + Send + Sync>(
    raster: &Raster<T>,
    radius: usize,
    of: impl Fn(T, T) -> T + Sync,
) -> Raster<T> {
    let (width, height) = (raster.width(), raster.height());
    if width == 0 || height == 0 {
        return raster.clone();
    }
    let gather = |row: &mut [T], other: &[T]| {
        row.iter_mut().zip(other).for_each(|(value, &other)| *value = of(*value, other));
    };
    let mut along = raster.clone();
    along.as_mut_slice().par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        let row = raster.row(y);
        for by in 1..=radius.min(width - 1) {
            gather(&mut out[by..], row);
            gather(out, &row[by..]);
        }
    });
    let mut all = along.clone();
    all.as_mut_slice().par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        for other in y.saturating_sub(radius)..(y + radius + 1).min(height) {
            gather(out, along.row(other));
        }
    });
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_grows_to_a_square_and_shrinks_back() {
        let raster = Raster::from_fn(9, 7, |x, y| u8::from((x, y) == (4, 1)));
        let grown = dilated(&raster, 2);
        assert_eq!(grown, Raster::from_fn(9, 7, |x, y| u8::from((2..=6).contains(&x) && y <= 3)));
        assert_eq!(eroded(&grown, 2), Raster::from_fn(9, 7, |x, y| u8::from(x == 4 && y <= 1)));
    }

    #[test]
    fn any_size_and_radius() {
        for (width, height) in [(0, 0), (1, 1), (1, 5), (7, 2)] {
            let raster = Raster::from_fn(width, height, |x, y| (x + 2 * y) as f32);
            for radius in [0, 1, 3, 20] {
                let most = |x: usize, y: usize| {
                    ((x + radius).min(width - 1) + 2 * (y + radius).min(height - 1)) as f32
                };
                assert_eq!(dilated(&raster, radius), Raster::from_fn(width, height, most));
            }
        }
    }
}
