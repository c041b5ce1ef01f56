//! A sheet from a picture of real paper.

use girtin_grid::Raster;
use girtin_grid::memory::{NoRoom, probe};

use crate::HeightSource;
use crate::sheet::{MARGIN, into_unit};

/// How a picture of paper is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanOptions {
    /// Pixels of the picture per mm of paper.
    pub pixels_per_mm: f64,
    /// Changes of light over more than this are the lamp's, not the paper's, and are taken out, mm.
    pub flatten_mm: f64,
    /// The share of pixels at each end that the normalisation does not look at: dust and holes.
    pub ignore: f64,
    /// Standard deviation of the resulting height, about; as
    /// [`Surface::relief`](crate::recipe::Surface::relief).
    pub relief: f64,
    /// Whether dark is high, as in a picture of the back.
    pub dark_is_high: bool,
}

impl ScanOptions {
    /// The usual ones for a picture of that many pixels per mm.
    pub fn new(pixels_per_mm: f64) -> Self {
        Self { pixels_per_mm, flatten_mm: 8.0, ignore: 0.02, relief: 0.17, dark_is_high: false }
    }
}

/// Why a picture cannot become a sheet.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ScanError {
    /// There are no pixels.
    #[error("the picture of the paper is empty")]
    Empty,
    /// A pixel is no number.
    #[error("the picture's pixel {x}, {y} is not a finite number")]
    NotFinite {
        /// Column.
        x: usize,
        /// Row.
        y: usize,
    },
    /// All pixels are (almost) equal once slow changes of light are out.
    #[error(
        "the picture shows no relief (contrast {contrast:e}): photograph the sheet under light from the side"
    )]
    Flat {
        /// What is left between dark and light.
        contrast: f64,
    },
    /// There is no memory for it.
    #[error(transparent)]
    NoRoom(#[from] NoRoom),
    /// An option is outside its range.
    #[error("`{option}` is {value}, outside {low} to {high}")]
    Option {
        /// Its name.
        option: &'static str,
        /// Its value.
        value: f64,
        /// Least that is allowed.
        low: f64,
        /// Most that is allowed.
        high: f64,
    },
}

/// A sheet from a picture; beyond the picture's border it goes on mirrored.
#[derive(Clone, Debug, PartialEq)]
pub struct ScannedSheet {
    pixels_per_mm: f64,
    height: Raster<f32>,
}

/// Contrast below this is the noise of rounding.
const LEAST_CONTRAST: f64 = 1e-5;

/// The normal distribution has this many deviations between its 2nd and 98th hundredth, and near it for
/// others.
const DEVIATIONS: f64 = 4.1;

impl ScannedSheet {
    /// Reads height from luminance: light is high, slow changes of light taken out, contrast normalised by
    /// percentiles.
    ///
    /// # Errors
    /// The picture is empty, flat or has pixels that are no numbers, or an option is outside its range.
    pub fn from_scan(luminance: &Raster<f32>, options: &ScanOptions) -> Result<Self, ScanError> {
        for (option, value, low, high) in [
            ("pixels_per_mm", options.pixels_per_mm, 0.01, 1000.0),
            ("flatten_mm", options.flatten_mm, 0.1, 1e6),
            ("ignore", options.ignore, 0.0, 0.4),
            ("relief", options.relief, 0.005, 0.5),
        ] {
            if !(low..=high).contains(&value) {
                return Err(ScanError::Option { option, value, low, high });
            }
        }
        let (width, rows) = (luminance.width(), luminance.height());
        if width == 0 || rows == 0 {
            return Err(ScanError::Empty);
        }
        if let Some(at) = luminance.as_slice().iter().position(|value| !value.is_finite()) {
            return Err(ScanError::NotFinite { x: at % width, y: at / width });
        }
        // Its level, its slow changes with two means on their way, and its detail twice.
        probe([4 * (width * rows) as u64; 6])?;
        // The plane first: near the border, where a window is cut, a mean lags behind a slope.
        let level = without_plane(luminance);
        // Three means over a window are near enough a Gaussian.
        let radius = (0.5 * options.flatten_mm * options.pixels_per_mm).clamp(1.0, 1e7) as usize;
        let mut slow = level.clone();
        for _ in 0..3 {
            slow = window_mean(&slow, radius);
        }
        let sign = if options.dark_is_high { -1.0 } else { 1.0 };
        let mut detail: Vec<f32> =
            level.as_slice().iter().zip(slow.as_slice()).map(|(value, slow)| sign * (value - slow)).collect();
        let mut sorted = detail.clone();
        sorted.sort_unstable_by(f32::total_cmp);
        let percentile = |share: f64| f64::from(sorted[(share * (sorted.len() - 1) as f64) as usize]);
        let (low, high) = (percentile(options.ignore), percentile(1.0 - options.ignore));
        let contrast = high - low;
        // Not `<`: what overflowed to infinity on the way is refused, too.
        if !(contrast >= LEAST_CONTRAST && contrast.is_finite()) {
            return Err(ScanError::Flat { contrast });
        }
        let middle = percentile(0.5) as f32;
        let scale = (2.0 * options.relief * DEVIATIONS / contrast) as f32;
        for value in &mut detail {
            *value = (0.5 + 0.5 * into_unit(scale * (*value - middle))).clamp(MARGIN, 1.0 - MARGIN);
        }
        let mut detail = detail.into_iter();
        let height = Raster::from_fn(width, rows, |_, _| detail.next().unwrap_or(0.5));
        Ok(Self { pixels_per_mm: options.pixels_per_mm, height })
    }

    /// The size of the picture, mm of paper.
    pub fn size_mm(&self) -> [f64; 2] {
        [self.height.width(), self.height.height()].map(|pixels| pixels as f64 / self.pixels_per_mm)
    }
}

impl HeightSource for ScannedSheet {
    /// Cells larger than a pixel are means over as many points as pixels; smaller ones are linear between
    /// pixels.
    fn height_field(
        &self,
        width: usize,
        height: usize,
        cells_per_mm: f64,
        origin_mm: [f64; 2],
    ) -> Raster<f32> {
        crate::check_place(cells_per_mm, origin_mm);
        let pixels_in_cell = self.pixels_per_mm / cells_per_mm;
        let points = libm::ceil(pixels_in_cell - 1e-6).clamp(1.0, 256.0) as usize;
        // Each point as the two pixels it lies between and its share of the second.
        let axis = |count: usize, origin: f64, size: usize| -> Vec<(usize, usize, f32)> {
            let point = |k: usize| {
                let cells = (k as f64 + 0.5) / points as f64;
                let pixel = origin * self.pixels_per_mm + cells * pixels_in_cell - 0.5;
                let low = libm::floor(pixel);
                (mirrored(low, size), mirrored(low + 1.0, size), (pixel - low) as f32)
            };
            (0..count * points).map(point).collect()
        };
        let across = axis(width, origin_mm[0], self.height.width());
        let down = axis(height, origin_mm[1], self.height.height());
        let share = 1.0 / (points * points) as f32;
        Raster::from_fn(width, height, |x, y| {
            let mut sum = 0.0;
            for &(y0, y1, fy) in &down[y * points..(y + 1) * points] {
                let (top, bottom) = (self.height.row(y0), self.height.row(y1));
                for &(x0, x1, fx) in &across[x * points..(x + 1) * points] {
                    let top = top[x0] + fx * (top[x1] - top[x0]);
                    let bottom = bottom[x0] + fx * (bottom[x1] - bottom[x0]);
                    sum += top + fy * (bottom - top);
                }
            }
            (sum * share).clamp(MARGIN, 1.0 - MARGIN)
        })
    }
}

/// The pixel that stands at `at` when the picture goes on mirrored at its borders.
fn mirrored(at: f64, size: usize) -> usize {
    let period = 2.0 * size as f64;
    let within = at - period * libm::floor(at / period);
    let within = if within >= size as f64 { period - 1.0 - within } else { within };
    (within.max(0.0) as usize).min(size - 1)
}

/// The picture less the plane that fits it best.
fn without_plane(raster: &Raster<f32>) -> Raster<f32> {
    let (width, rows) = (raster.width(), raster.height());
    // About the middle of the picture, x, y and 1 are orthogonal: each coefficient stands alone.
    let (middle_x, middle_y) = (0.5 * (width as f64 - 1.0), 0.5 * (rows as f64 - 1.0));
    let (mut sum, mut along, mut down) = (0.0, 0.0, 0.0);
    for y in 0..rows {
        for (x, &value) in raster.row(y).iter().enumerate() {
            let value = f64::from(value);
            sum += value;
            along += (x as f64 - middle_x) * value;
            down += (y as f64 - middle_y) * value;
        }
    }
    // Σ(x − middle)² over n pixels is n(n² − 1)/12; a single column has no slope.
    let count = (width * rows) as f64;
    let slope = |moment: f64, n: usize| {
        let square = count * ((n * n) as f64 - 1.0) / 12.0;
        if square > 0.0 { moment / square } else { 0.0 }
    };
    let (mean, along, down) = (sum / count, slope(along, width), slope(down, rows));
    Raster::from_fn(width, rows, |x, y| {
        let plane = mean + along * (x as f64 - middle_x) + down * (y as f64 - middle_y);
        (f64::from(raster.at(x, y)) - plane) as f32
    })
}

/// Mean over a square window, cut at the border, in time that does not depend on the window.
fn window_mean(raster: &Raster<f32>, radius: usize) -> Raster<f32> {
    let (width, rows) = (raster.width(), raster.height());
    let mut across = Raster::new(width, rows, 0.0);
    let mut sums = vec![0.0; width + 1];
    for y in 0..rows {
        for (x, &value) in raster.row(y).iter().enumerate() {
            sums[x + 1] = sums[x] + f64::from(value);
        }
        for (x, value) in across.row_mut(y).iter_mut().enumerate() {
            let (from, to) = (x.saturating_sub(radius), (x + radius + 1).min(width));
            *value = ((sums[to] - sums[from]) / (to - from) as f64) as f32;
        }
    }
    let mut down = Raster::new(width, rows, 0.0);
    // The running sums of all columns at once, so that memory is read along its rows.
    let mut sums = vec![0.0; width];
    let (mut from, mut to) = (0, 0);
    for y in 0..rows {
        while to < (y + radius + 1).min(rows) {
            sums.iter_mut().zip(across.row(to)).for_each(|(sum, &value)| *sum += f64::from(value));
            to += 1;
        }
        while from < y.saturating_sub(radius) {
            sums.iter_mut().zip(across.row(from)).for_each(|(sum, &value)| *sum -= f64::from(value));
            from += 1;
        }
        let share = 1.0 / (to - from) as f64;
        down.row_mut(y).iter_mut().zip(&sums).for_each(|(value, &sum)| *value = (sum * share) as f32);
    }
    down
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::{Papers, Sheet};

    const PIXELS_PER_MM: f64 = 8.0;

    /// 30 mm × 20 mm of cold press, unevenly lit.
    fn picture() -> (Raster<f32>, Raster<f32>) {
        let sheet = Sheet::new(Papers::builtin().get("cold-press").unwrap(), 2);
        let height = sheet.height_field(240, 160, PIXELS_PER_MM, [0.0, 0.0]);
        let lit = Raster::from_fn(240, 160, |x, y| {
            0.3 + 0.1 * height.at(x, y) + 0.5 * (x as f32 / 240.0) + 0.2 * (y as f32 / 160.0)
        });
        (height, lit)
    }

    fn correlation(a: &Raster<f32>, b: &Raster<f32>) -> f64 {
        let count = a.as_slice().len() as f64;
        let mean = |r: &Raster<f32>| r.as_slice().iter().map(|&v| f64::from(v)).sum::<f64>() / count;
        let (ma, mb) = (mean(a), mean(b));
        let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
        for (&x, &y) in a.as_slice().iter().zip(b.as_slice()) {
            let (x, y) = (f64::from(x) - ma, f64::from(y) - mb);
            ab += x * y;
            aa += x * x;
            bb += y * y;
        }
        ab / libm::sqrt(aa * bb)
    }

    #[test]
    fn the_relief_comes_back_and_the_lamp_is_taken_out() {
        let (height, lit) = picture();
        let scan = ScannedSheet::from_scan(&lit, &ScanOptions::new(PIXELS_PER_MM)).unwrap();
        let read = scan.height_field(240, 160, PIXELS_PER_MM, [0.0, 0.0]);
        assert!(correlation(&lit, &height) < 0.25);
        assert!(correlation(&read, &height) > 0.9, "{}", correlation(&read, &height));
        let middle = read.as_slice().iter().sum::<f32>() / read.as_slice().len() as f32;
        assert!((middle - 0.5).abs() < 0.03, "{middle}");
        let left = Raster::from_fn(60, 160, |x, y| read.at(x, y));
        let left = left.as_slice().iter().sum::<f32>() / left.as_slice().len() as f32;
        assert!((left - middle).abs() < 0.06, "left {left} of {middle}");
        assert_eq!(scan.size_mm(), [30.0, 20.0]);
    }

    #[test]
    fn dark_can_be_high() {
        let (_, lit) = picture();
        let options = ScanOptions::new(PIXELS_PER_MM);
        let up = ScannedSheet::from_scan(&lit, &options).unwrap();
        let down = ScannedSheet::from_scan(&lit, &ScanOptions { dark_is_high: true, ..options }).unwrap();
        for (a, b) in up.height.as_slice().iter().zip(down.height.as_slice()) {
            assert!((a + b - 1.0).abs() < 0.02, "{a} {b}");
        }
    }

    #[test]
    fn resolutions_agree() {
        let (_, lit) = picture();
        let scan = ScannedSheet::from_scan(&lit, &ScanOptions::new(PIXELS_PER_MM)).unwrap();
        let four = scan.height_field(100, 60, 4.0, [1.0, 2.0]);
        let eight = scan.height_field(200, 120, 8.0, [1.0, 2.0]).box_reduced(2);
        for (a, b) in four.as_slice().iter().zip(eight.as_slice()) {
            assert!((a - b).abs() < 1e-6);
        }
    }

    #[test]
    fn beyond_its_border_the_picture_goes_on_mirrored() {
        let (_, lit) = picture();
        let scan = ScannedSheet::from_scan(&lit, &ScanOptions::new(PIXELS_PER_MM)).unwrap();
        let wide = scan.height_field(480, 4, PIXELS_PER_MM, [0.0, 0.0]);
        for x in 0..240 {
            assert_eq!(wide.at(x, 1), wide.at(479 - x, 1));
        }
        assert_eq!(
            scan.height_field(5, 4, PIXELS_PER_MM, [-60.0, 40.0]),
            scan.height_field(5, 4, PIXELS_PER_MM, [0.0, 0.0])
        );
    }

    #[test]
    fn pictures_without_relief_are_refused() {
        let options = ScanOptions::new(4.0);
        let read = |raster: &Raster<f32>| ScannedSheet::from_scan(raster, &options).unwrap_err();
        assert_eq!(read(&Raster::new(0, 5, 0.5)), ScanError::Empty);
        assert!(matches!(read(&Raster::new(9, 7, 0.5)), ScanError::Flat { .. }));
        assert!(matches!(read(&Raster::new(1, 1, 0.5)), ScanError::Flat { .. }));
        let mut holed = Raster::from_fn(9, 7, |x, y| (x * y) as f32);
        holed.as_mut_slice()[2 * 9 + 4] = f32::NAN;
        assert_eq!(read(&holed), ScanError::NotFinite { x: 4, y: 2 });
        let huge = Raster::from_fn(9, 7, |x, _| if x % 2 == 0 { f32::MAX } else { f32::MIN });
        assert!(matches!(read(&huge), ScanError::Flat { .. }));
        let bad = ScanOptions { flatten_mm: f64::NAN, ..options };
        let error = ScannedSheet::from_scan(&holed, &bad).unwrap_err();
        assert!(matches!(error, ScanError::Option { option: "flatten_mm", .. }));
    }

    proptest! {
        #[test]
        fn heights_are_inside_zero_and_one(
            pixels in prop::collection::vec(-1e3..1e3f32, 35),
            cells_per_mm in 0.5..20.0f64,
            x in -1e3..1e3f64,
        ) {
            let picture = Raster::from_vec(7, 5, pixels).unwrap();
            let scan = ScannedSheet::from_scan(&picture, &ScanOptions::new(4.0)).unwrap();
            let field = scan.height_field(6, 3, cells_per_mm, [x, -x]);
            prop_assert!(field.as_slice().iter().all(|&h| 0.0 < h && h < 1.0));
        }
    }
}
