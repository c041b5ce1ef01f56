//! Dilation and erosion of rasters, by squares and by discs.

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

/// The most of the cells whose middles are up to `radius` cells from each cell's; cells outside the raster do not count.
///
/// # Cost
/// Linear in the cells and in the radius: `2 radius` comparisons along each row and as many between rows.
pub fn dilated_by_disc(plane: &Raster<f32>, radius: f32) -> Raster<f32> {
    disc_extremes(plane, radius, |a, b| if b > a { b } else { a })
}

/// The least of the cells whose middles are up to `radius` cells from each cell's; cells outside the raster do not count.
///
/// # Cost
/// As [`dilated_by_disc`].
pub fn eroded_by_disc(plane: &Raster<f32>, radius: f32) -> Raster<f32> {
    disc_extremes(plane, radius, |a, b| if b < a { b } else { a })
}

/// The plane without what is light and narrower than a disc: eroded, then dilated.
pub fn opened_by_disc(plane: &Raster<f32>, radius: f32) -> Raster<f32> {
    dilated_by_disc(&eroded_by_disc(plane, radius), radius)
}

/// The plane without what is dark and narrower than a disc: dilated, then eroded.
pub fn closed_by_disc(plane: &Raster<f32>, radius: f32) -> Raster<f32> {
    eroded_by_disc(&dilated_by_disc(plane, radius), radius)
}

/// Rows that one thread gathers at a time: they stay in its cache, and the rows around them are few beside them.
const BAND: usize = 64;

fn disc_extremes(plane: &Raster<f32>, radius: f32, of: impl Fn(f32, f32) -> f32 + Sync) -> Raster<f32> {
    let (width, height) = (plane.width(), plane.height());
    let mut all = plane.clone();
    if width == 0 || height == 0 || radius < 1.0 {
        return all;
    }
    let reach = radius as usize;
    // A disc is a run of cells in each row; the run of a row is as long as those below and above it and a bit more.
    let half_run = |off: usize| (radius * radius - (off * off) as f32).max(0.0).sqrt() as usize;
    let gather = |row: &mut [f32], other: &[f32]| {
        row.iter_mut().zip(other).for_each(|(value, &other)| *value = of(*value, other));
    };
    all.as_mut_slice().par_chunks_mut(width * BAND).enumerate().for_each_init(
        Vec::new,
        |run, (band, out)| {
            let first = band * BAND;
            let rows = out.len() / width;
            for source in first.saturating_sub(reach)..(first + rows + reach).min(height) {
                let row = plane.row(source);
                run.clear();
                run.extend_from_slice(row);
                let mut half = 0;
                for off in (0..=reach).rev() {
                    while half < half_run(off) {
                        half += 1;
                        if half < width {
                            gather(&mut run[half..], row);
                            gather(run, &row[half..]);
                        }
                    }
                    let targets = [source.checked_sub(off), (off > 0).then_some(source + off)];
                    for target in targets.into_iter().flatten().filter_map(|row| row.checked_sub(first)) {
                        if target < rows {
                            gather(&mut out[target * width..][..width], run);
                        }
                    }
                }
            }
        },
    );
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

    #[test]
    fn discs_are_those_of_trying_every_cell() {
        let key = crate::random::key(3, crate::random::stage("disc test"));
        for (width, height) in [(0, 0), (1, 1), (1, 9), (31, 17), (20, 140)] {
            let plane = Raster::from_fn(width, height, |x, y| {
                crate::random::unit_f32(crate::random::at(key, [x as i64, y as i64]))
            });
            for radius in [0.0, 0.9, 1.0, 1.5, 2.0, 3.3, 7.0, 12.4] {
                let most = |x: usize, y: usize| {
                    let reach = radius as usize;
                    let mut most = f32::NEG_INFINITY;
                    for v in y.saturating_sub(reach)..(y + reach + 1).min(height) {
                        for u in x.saturating_sub(reach)..(x + reach + 1).min(width) {
                            let (dx, dy) = (u.abs_diff(x) as f32, v.abs_diff(y) as f32);
                            if dx * dx + dy * dy <= radius * radius {
                                most = most.max(plane.at(u, v));
                            }
                        }
                    }
                    most
                };
                assert_eq!(dilated_by_disc(&plane, radius), Raster::from_fn(width, height, most), "{radius}");
                let least = eroded_by_disc(&plane.map(|value| -value), radius).map(|value| -value);
                assert_eq!(least, dilated_by_disc(&plane, radius));
            }
        }
    }

    #[test]
    fn opening_takes_narrow_lights_and_keeps_wide_ones() {
        let wide = |x: usize, y: usize| (5..20).contains(&x) && (5..20).contains(&y);
        let plane = Raster::from_fn(40, 25, |x, y| if wide(x, y) || x == 30 { 90.0f32 } else { 20.0 });
        let opened = opened_by_disc(&plane, 4.0);
        assert_eq!((opened.at(30, 12), opened.at(12, 12), opened.at(2, 2)), (20.0, 90.0, 20.0));
        assert!(opened.as_slice().iter().zip(plane.as_slice()).all(|(opened, value)| opened <= value));
        let closed = closed_by_disc(&plane.map(|value| -value), 4.0).map(|value| -value);
        assert_eq!(closed, opened);
    }
}
