//! Pixels gathered into small patches of one color.

use girtin_grid::Raster;
use rayon::prelude::*;

/// A pixel's color as superpixels see it: L\*, a\*, b\*, each perhaps weighted.
pub type LabPixel = [f32; 3];

/// A picture in patches.
#[derive(Clone, Debug, PartialEq)]
pub struct Superpixels {
    /// Number of the patch that each pixel belongs to. Patches are connected, and numbered in reading order.
    pub labels: Raster<u32>,
    /// How many there are.
    pub count: usize,
}

/// How patches are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SuperpixelConfig {
    /// About how many.
    pub count: u32,
    /// How much a patch keeps together rather than to one color: the difference of color that weighs as much as a patch's
    /// width.
    pub compactness: f64,
    /// How often patches and colors are fitted to each other.
    pub iterations: u32,
}

/// A patch's mean.
#[derive(Clone, Copy, Default)]
struct Center {
    color: [f32; 3],
    at: [f32; 2],
}

/// Gathers pixels into patches.
///
/// # Source
/// Achanta, Shaji, Smith, Lucchi, Fua, Süsstrunk, *SLIC Superpixels Compared to State-of-the-Art Superpixel Methods*, 2012:
/// means of color and place in turn with the nearest of them. SLIC, because it is linear in the pixels, its patches are of
/// one size whatever the picture, and it has no random start.
///
/// # Guarantees
/// The same for any number of threads: sums are taken in reading order.
///
/// # Deviations
/// A pixel looks at the nine centers that began around it, instead of a center at all pixels near: rows can then be done
/// apart. Disconnected parts become patches of their own, however small; who merges patches takes them first.
pub fn superpixels(picture: &Raster<LabPixel>, config: &SuperpixelConfig) -> Superpixels {
    let (width, height) = (picture.width(), picture.height());
    if width == 0 || height == 0 {
        return Superpixels { labels: Raster::new(width, height, 0), count: 0 };
    }
    let spacing = ((width * height) as f64 / f64::from(config.count.max(1))).sqrt().max(1.0);
    let across = |cells: usize| ((cells as f64 / spacing).round() as usize).clamp(1, cells);
    let grid = Grid { columns: across(width), rows: across(height), width, height };
    let mut centers = grid.centers(picture);
    let pull = (config.compactness / spacing) as f32;
    let mut labels = Raster::new(width, height, 0u32);
    for _ in 0..config.iterations.max(1) {
        labels.as_mut_slice().par_chunks_mut(width).enumerate().for_each(|(y, labels)| {
            for (x, label) in labels.iter_mut().enumerate() {
                *label = grid.nearest(&centers, pull * pull, picture.at(x, y), [x, y]);
            }
        });
        refit(&mut centers, picture, &labels);
    }
    connected(&labels)
}

/// The lattice that centers begin on.
struct Grid {
    columns: usize,
    rows: usize,
    width: usize,
    height: usize,
}

impl Grid {
    fn centers(&self, picture: &Raster<LabPixel>) -> Vec<Center> {
        let middle = |at: usize, cells: usize, of: usize| (2 * at + 1) * of / (2 * cells);
        (0..self.rows * self.columns)
            .map(|number| {
                let (column, row) = (number % self.columns, number / self.columns);
                let (x, y) = (middle(column, self.columns, self.width), middle(row, self.rows, self.height));
                Center { color: picture.at(x, y), at: [x as f32, y as f32] }
            })
            .collect()
    }

    /// The nearest in color and place of the nine centers that began around a pixel; of equals the first.
    fn nearest(&self, centers: &[Center], pull: f32, color: LabPixel, [x, y]: [usize; 2]) -> u32 {
        let (column, row) = (x * self.columns / self.width, y * self.rows / self.height);
        let mut best = (0, f32::INFINITY);
        for row in row.saturating_sub(1)..(row + 2).min(self.rows) {
            for column in column.saturating_sub(1)..(column + 2).min(self.columns) {
                let number = row * self.columns + column;
                let center = &centers[number];
                let place = square(center.at[0] - x as f32) + square(center.at[1] - y as f32);
                let distance = color_square(center.color, color) + pull * place;
                if distance < best.1 {
                    best = (number, distance);
                }
            }
        }
        best.0 as u32
    }
}

fn square(x: f32) -> f32 {
    x * x
}

fn color_square(a: LabPixel, b: LabPixel) -> f32 {
    square(a[0] - b[0]) + square(a[1] - b[1]) + square(a[2] - b[2])
}

/// Makes each center the mean of its pixels; one without pixels stays.
fn refit(centers: &mut [Center], picture: &Raster<LabPixel>, labels: &Raster<u32>) {
    let mut sums = vec![([0.0f64; 5], 0u32); centers.len()];
    for y in 0..picture.height() {
        for (x, (color, &label)) in picture.row(y).iter().zip(labels.row(y)).enumerate() {
            let (sum, count) = &mut sums[label as usize];
            let values = [color[0].into(), color[1].into(), color[2].into(), x as f64, y as f64];
            sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
            *count += 1;
        }
    }
    for (center, (sum, count)) in centers.iter_mut().zip(sums) {
        if count > 0 {
            let [l, a, b, x, y] = sum.map(|sum| (sum / f64::from(count)) as f32);
            *center = Center { color: [l, a, b], at: [x, y] };
        }
    }
}

/// Connected parts of one label, by sides, numbered in reading order.
fn connected(labels: &Raster<u32>) -> Superpixels {
    const NONE: u32 = u32::MAX;
    let (width, height) = (labels.width(), labels.height());
    let mut parts = Raster::new(width, height, NONE);
    let mut count = 0;
    let mut open = Vec::new();
    for start in 0..width * height {
        if parts.as_slice()[start] != NONE {
            continue;
        }
        let label = labels.as_slice()[start];
        parts.as_mut_slice()[start] = count;
        open.push(start);
        while let Some(pixel) = open.pop() {
            let (x, y) = (pixel % width, pixel / width);
            let sides = [
                (x > 0).then(|| pixel - 1),
                (x + 1 < width).then(|| pixel + 1),
                (y > 0).then(|| pixel - width),
                (y + 1 < height).then(|| pixel + width),
            ];
            for side in sides.into_iter().flatten() {
                if labels.as_slice()[side] == label && parts.as_slice()[side] == NONE {
                    parts.as_mut_slice()[side] = count;
                    open.push(side);
                }
            }
        }
        count += 1;
    }
    Superpixels { labels: parts, count: count as usize }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONFIG: SuperpixelConfig = SuperpixelConfig { count: 60, compactness: 10.0, iterations: 10 };

    fn halves() -> Raster<LabPixel> {
        Raster::from_fn(63, 47, |x, y| {
            let ripple = ((x * 7 + y * 13) % 5) as f32 * 0.5;
            if 2 * x + y < 80 { [30.0 + ripple, 0.0, 40.0] } else { [60.0 + ripple, 10.0, -30.0] }
        })
    }

    #[test]
    fn patches_do_not_cross_a_strong_edge() {
        let picture = halves();
        let found = superpixels(&picture, &CONFIG);
        assert!((40..100).contains(&found.count), "{}", found.count);
        let mut first = vec![None; found.count];
        for (color, &label) in picture.as_slice().iter().zip(found.labels.as_slice()) {
            let side = color[2] > 0.0;
            assert_eq!(*first[label as usize].get_or_insert(side), side);
        }
    }

    #[test]
    fn threads_change_nothing() {
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| superpixels(&halves(), &CONFIG))
        };
        assert!(run(1) == run(2) && run(1) == run(7));
    }

    #[test]
    fn every_size_works() {
        for (width, height) in [(0, 0), (1, 1), (1, 50), (70, 1), (2, 3)] {
            let found = superpixels(&Raster::new(width, height, [50.0, 0.0, 0.0]), &CONFIG);
            assert!(found.labels.as_slice().iter().all(|&label| (label as usize) < found.count));
            assert!(found.count <= width * height);
        }
    }
}
