//! How far each cell is from the edge of a shape, exactly.

use rayon::prelude::*;

use crate::Raster;

/// Distance of the middle of each cell from the middle of the nearest one where `mask` holds, cells; infinite where it
/// holds nowhere.
///
/// # Source
/// Felzenszwalb, Huttenlocher, *Distance Transforms of Sampled Functions*, 2012.
///
/// # Cost
/// Linear in the cells.
pub fn distance_to(mask: &Raster<bool>) -> Raster<f32> {
    let (width, height) = (mask.width(), mask.height());
    if width == 0 || height == 0 {
        return Raster::new(width, height, 0.0);
    }
    // Along rows, as whole cells; squares of them are exact up to rasters of 2^12 cells, and close beyond.
    let mut along = mask.map(|there| if there { 0.0f32 } else { f32::INFINITY });
    along.as_mut_slice().par_chunks_mut(width).for_each(|row| {
        let mut near = f32::INFINITY;
        for value in row.iter_mut() {
            near = if *value == 0.0 { 0.0 } else { near + 1.0 };
            *value = near;
        }
        near = f32::INFINITY;
        for value in row.iter_mut().rev() {
            near = (near + 1.0).min(*value);
            *value = near * near;
        }
    });
    // Down columns: the lower envelope of parabolas. Columns are rows of the transposed raster.
    let mut turned = transposed(&along);
    turned.as_mut_slice().par_chunks_mut(height).for_each_init(Envelope::default, |envelope, column| {
        envelope.lower(column);
    });
    transposed(&turned).map(f32::sqrt)
}

/// Distance of the middle of each cell from the edge of a shape, which runs between cells: positive inside.
pub fn signed_distance(mask: &Raster<bool>) -> Raster<f32> {
    let outside = distance_to(mask);
    let mut inside = distance_to(&mask.map(|there| !there));
    for ((inside, outside), there) in
        inside.as_mut_slice().iter_mut().zip(outside.as_slice()).zip(mask.as_slice())
    {
        *inside = if *there { *inside - 0.5 } else { 0.5 - outside };
    }
    inside
}

fn transposed(raster: &Raster<f32>) -> Raster<f32> {
    Raster::by_rows(raster.height(), raster.width(), |x, y| raster.row(x)[y])
}

/// Parabolas that no other lies below somewhere: where they stand, how high, and from where on each is the lowest.
#[derive(Default)]
struct Envelope {
    feet: Vec<(f32, f32)>,
    from: Vec<f32>,
}

impl Envelope {
    fn lower(&mut self, column: &mut [f32]) {
        self.feet.clear();
        self.from.clear();
        for (at, &height) in column.iter().enumerate().filter(|(_, height)| height.is_finite()) {
            let at = at as f32;
            let mut begin = f32::NEG_INFINITY;
            while let Some(&(foot, low)) = self.feet.last() {
                begin = ((height + at * at) - (low + foot * foot)) / (2.0 * (at - foot));
                if self.from.last().is_some_and(|&from| begin <= from) {
                    self.feet.pop();
                    self.from.pop();
                    begin = f32::NEG_INFINITY;
                } else {
                    break;
                }
            }
            self.feet.push((at, height));
            self.from.push(begin);
        }
        let mut lowest = 0;
        for (at, value) in column.iter_mut().enumerate() {
            let at = at as f32;
            while lowest + 1 < self.feet.len() && self.from[lowest + 1] <= at {
                lowest += 1;
            }
            *value = match self.feet.get(lowest) {
                Some(&(foot, low)) => low + (at - foot) * (at - foot),
                None => f32::INFINITY,
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;

    #[test]
    fn distances_are_those_of_trying_every_cell() {
        let key = random::key(7, random::stage("distance test"));
        for (width, height, share) in [(1, 1, 0.5), (17, 9, 0.1), (9, 23, 0.02), (30, 30, 0.6)] {
            let mask = Raster::from_fn(width, height, |x, y| {
                random::unit_f64(random::at(key, [x as i64, (y * 100 + width) as i64])) < share
            });
            let found = distance_to(&mask);
            for y in 0..height {
                for x in 0..width {
                    let mut nearest = f32::INFINITY;
                    for v in 0..height {
                        for u in (0..width).filter(|&u| mask.at(u, v)) {
                            let (dx, dy) = (x as f32 - u as f32, y as f32 - v as f32);
                            nearest = nearest.min((dx * dx + dy * dy).sqrt());
                        }
                    }
                    assert!(
                        found.at(x, y) == nearest || (found.at(x, y) - nearest).abs() < 1e-4,
                        "({x}, {y}) of {width} × {height}: {} for {nearest}",
                        found.at(x, y)
                    );
                }
            }
        }
    }

    #[test]
    fn signed_distances_are_half_a_cell_on_both_sides_of_an_edge() {
        let mask = Raster::from_fn(6, 1, |x, _| x >= 3);
        assert_eq!(signed_distance(&mask).as_slice(), [-2.5, -1.5, -0.5, 0.5, 1.5, 2.5]);
        assert_eq!(signed_distance(&Raster::new(2, 1, true)).as_slice(), [f32::INFINITY; 2]);
        assert_eq!(signed_distance(&Raster::new(2, 1, false)).as_slice(), [f32::NEG_INFINITY; 2]);
    }
}
