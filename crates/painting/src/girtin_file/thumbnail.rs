//! A picture made small.

use std::sync::LazyLock;

use girtin_grid::Raster;
use girtin_optics::{LinearRgb, Srgb};

use super::THUMBNAIL_SIDE;

/// The picture with a long edge of at most [`THUMBNAIL_SIDE`]: each pixel the mean light of the pixels that it covers.
pub fn thumbnail(picture: &Raster<[u8; 3]>) -> Raster<[u8; 3]> {
    static LIGHT: LazyLock<Vec<f64>> =
        LazyLock::new(|| (0..=255).map(|byte| Srgb::from_bytes([byte; 3]).to_linear().0[0]).collect());
    let (width, height) = (picture.width(), picture.height());
    let long = width.max(height);
    if long <= THUMBNAIL_SIDE {
        return picture.clone();
    }
    let small = |side: usize| ((side * THUMBNAIL_SIDE + long / 2) / long).max(1);
    let [columns, rows] = [shares(width, small(width)), shares(height, small(height))];
    Raster::from_fn(columns.len(), rows.len(), |x, y| {
        let mut light = [0.0; 3];
        for &(row, share_of_row) in &rows[y] {
            for &(column, share) in &columns[x] {
                let pixel = picture.at(column, row);
                for (light, byte) in light.iter_mut().zip(pixel) {
                    *light += share_of_row * share * LIGHT[usize::from(byte)];
                }
            }
        }
        LinearRgb(light).to_srgb().to_bytes()
    })
}

/// Which of `from` pixels each of `to` covers, and how much of it each makes.
fn shares(from: usize, to: usize) -> Vec<Vec<(usize, f64)>> {
    // In `to`ths of a pixel every border is whole.
    let covered = |at: usize| {
        let (begin, end) = (at * from, (at + 1) * from);
        let pixels = begin / to..end.div_ceil(to);
        let share = |pixel: usize| end.min((pixel + 1) * to) - begin.max(pixel * to);
        pixels.map(|pixel| (pixel, share(pixel) as f64 / from as f64)).collect()
    };
    (0..to).map(covered).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_a_pixel_add_up_to_it() {
        for (from, to) in [(1000, 256), (257, 256), (7, 3), (9, 1)] {
            for covered in shares(from, to) {
                let sum: f64 = covered.iter().map(|(_, share)| share).sum();
                assert!((sum - 1.0).abs() < 1e-12);
                assert!(covered.iter().all(|&(pixel, share)| pixel < from && share > 0.0));
            }
        }
    }

    #[test]
    fn light_is_kept_and_small_pictures_stay_as_they_are() {
        let small = Raster::from_fn(256, 3, |x, y| [x as u8, y as u8, 7]);
        assert_eq!(thumbnail(&small), small);
        let grey = thumbnail(&Raster::new(1000, 10, [90, 20, 255]));
        assert_eq!((grey.width(), grey.height()), (256, 3));
        assert!(grey.as_slice().iter().all(|pixel| *pixel == [90, 20, 255]));
        // Half of the light of white, not half of its number.
        let stripes = thumbnail(&Raster::from_fn(512, 512, |x, _| [if x % 2 == 0 { 255 } else { 0 }; 3]));
        assert!(stripes.as_slice().iter().all(|pixel| *pixel == [188; 3]));
    }
}
