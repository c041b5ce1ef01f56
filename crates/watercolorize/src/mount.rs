//! The photograph on its sheet: where it lies, in millimetres and in cells, and how the painting ends around it.

use girtin_grid::Raster;
use girtin_grid::resize::resized;
use girtin_optics::{LinearRgb, Srgb};
use girtin_painting::document::SheetSettings;

use crate::separate::in_lab;

/// Color of the bare sheet.
pub const PAPER: Srgb = Srgb([251.0 / 255.0, 249.0 / 255.0, 244.0 / 255.0]);

/// A color as a document stores it.
pub(crate) fn stored(color: Srgb) -> LinearRgb {
    Srgb::from_bytes(color.to_bytes()).to_linear()
}

/// How the painting ends on the sheet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Border {
    /// Shapes stop at different distances, in marks of the brush.
    #[default]
    Vignette,
    /// Along masking tape, with corners left open.
    Taped,
    /// At a sheet's torn edge.
    Deckle,
}

/// The sheet that is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mounting {
    /// Long edge of the picture on paper, mm.
    pub long_edge_mm: f64,
    /// Bare sheet on each side, a part of the long edge.
    pub margin: f64,
    /// How the painting ends.
    pub border: Border,
}

impl Default for Mounting {
    fn default() -> Self {
        Self { long_edge_mm: 360.0, margin: 0.05, border: Border::default() }
    }
}

/// What is painted beyond a picture that has no margin, a part of the long edge; it is cut off.
const BLEED: f64 = 0.025;

/// A photograph on a sheet of cells.
#[derive(Clone, Debug)]
pub struct Mount {
    /// Cells along the photograph's long edge, S.
    pub long_edge: f64,
    /// Cells a millimetre.
    pub cells_per_mm: f64,
    /// Columns and rows of the sheet.
    pub size: [usize; 2],
    /// First column and row of the photograph.
    pub origin: usize,
    /// Columns and rows of the photograph.
    pub photo: [usize; 2],
    /// Width and height of the sheet, mm.
    pub size_mm: [f64; 2],
    /// How much is cut off on each side, mm, if a pixel were as small as can be; see [`Mount::trim_mm_at`].
    pub trim_mm: f64,
}

impl Mount {
    /// Lays a picture of `pixels` columns and rows on a sheet, `cells` along its long edge.
    pub fn new(pixels: [usize; 2], cells: f64, mounting: &Mounting) -> Self {
        let longest = pixels[0].max(pixels[1]) as f64;
        let photo_mm = pixels.map(|side| side as f64 / longest * mounting.long_edge_mm);
        let cells_per_mm = cells / mounting.long_edge_mm;
        let around = if mounting.margin > 0.0 { mounting.margin } else { BLEED };
        let origin = libm::round(around * cells).max(1.0) as usize;
        let around_mm = origin as f64 / cells_per_mm;
        let size_mm = photo_mm.map(|mm| mm + 2.0 * around_mm);
        let photo = photo_mm.map(|mm| libm::round(mm * cells_per_mm).max(1.0) as usize);
        Self {
            long_edge: cells,
            cells_per_mm,
            size: size_mm.map(|mm| libm::round(mm * cells_per_mm).max(1.0) as usize),
            origin,
            photo,
            size_mm,
            trim_mm: if mounting.margin > 0.0 { 0.0 } else { around_mm },
        }
    }

    /// How much is cut off on each side, mm, of a picture of so many pixels a millimetre: a margin is whole pixels, so that
    /// it is as wide on every side and the photograph's border lies between pixels.
    pub fn trim_mm_at(&self, pixels_per_mm: f64) -> f64 {
        let margin_mm = self.origin as f64 / self.cells_per_mm - self.trim_mm;
        // A hair more, as products of whole pixels are rounded.
        let pixels = (margin_mm * pixels_per_mm + 1e-6).floor();
        (self.trim_mm + margin_mm - pixels / pixels_per_mm).max(0.0)
    }

    /// The sheet of a document, its picture so many pixels along the photograph's long edge.
    pub fn sheet(&self, mounting: &Mounting, paper: &str, seed: u64, long_edge: u32) -> SheetSettings {
        let pixels_per_mm = f64::from(long_edge) / mounting.long_edge_mm;
        // Shapes have smooth edges of their own; grain below a pixel is averaged.
        let samples = libm::ceil(0.9 * self.cells_per_mm / pixels_per_mm).clamp(1.0, 8.0);
        SheetSettings {
            size_mm: self.size_mm,
            paper: paper.to_owned(),
            seed,
            ground: stored(PAPER),
            printed: Vec::new(),
            pixels_per_mm,
            cells_per_pixel: samples as u32,
            cells_per_mm: Some(self.cells_per_mm),
            trim_mm: self.trim_mm_at(pixels_per_mm),
            relief_mm: 0.0,
        }
    }

    /// A part of the long edge, cells.
    pub fn cells(&self, part: f64) -> f64 {
        part * self.long_edge
    }

    /// The photograph on the sheet, mirrored outward beyond its border.
    pub fn place<const N: usize>(&self, photo: &Raster<[f32; N]>) -> Raster<[f32; N]> {
        let photo = resized(photo, self.photo[0], self.photo[1]);
        let at = |cell: usize, of: usize| {
            let cell = cell as isize - self.origin as isize;
            let period = 2 * of as isize;
            let cell = cell.rem_euclid(period);
            (if cell < of as isize { cell } else { period - 1 - cell }) as usize
        };
        Raster::by_rows(self.size[0], self.size[1], |x, y| {
            photo.at(at(x, self.photo[0]), at(y, self.photo[1]))
        })
    }

    /// The photograph on the sheet in Lab, from linear light.
    pub fn place_lab(&self, photo: &Raster<[f32; 3]>) -> Raster<[f32; 3]> {
        in_lab(&self.place(photo))
    }

    /// Distance of each cell from the photograph's border, cells, negative inside.
    pub fn distance(&self) -> Raster<f32> {
        let beyond = |cell: usize, of: usize| {
            let (first, last) = (self.origin as f32, (self.origin + of) as f32 - 1.0);
            (first - cell as f32).max(cell as f32 - last)
        };
        Raster::by_rows(self.size[0], self.size[1], |x, y| {
            beyond(x, self.photo[0]).max(beyond(y, self.photo[1]))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_margin_the_picture_is_the_photograph_s_size() {
        let mounting = Mounting { margin: 0.0, ..Mounting::default() };
        for pixels in [[640, 427], [427, 640], [1, 1], [1, 5000], [6000, 4000], [3264, 2448], [64, 64]] {
            let mount = Mount::new(pixels, 720.0, &mounting);
            let per_mm = pixels[0].max(pixels[1]) as f64 / mounting.long_edge_mm;
            let seen = mount.size_mm.map(|mm| ((mm - 2.0 * mount.trim_mm) * per_mm).round() as usize);
            assert_eq!(seen, pixels);
        }
    }

    #[test]
    fn a_margin_is_as_many_whole_pixels_on_every_side() {
        for (pixels, margin) in [
            ([640, 427], 0.05),
            ([1011, 763], 0.05),
            ([48, 32], 0.1),
            ([3264, 2448], 0.033),
            ([16, 16], 0.05),
        ] {
            let mounting = Mounting { margin, ..Mounting::default() };
            let mount = Mount::new(pixels, 640.0, &mounting);
            let longest = pixels[0].max(pixels[1]);
            let sheet = mount.sheet(&mounting, "fine-grain", 0, longest as u32);
            let size =
                sheet.size_mm.map(|mm| ((mm - 2.0 * sheet.trim_mm) * sheet.pixels_per_mm).round() as usize);
            let around = [0, 1].map(|side: usize| size[side] - pixels[side]);
            assert!(around[0] == around[1] && around[0] % 2 == 0, "{pixels:?}: {around:?}");
            let first = (mount.origin as f64 / mount.cells_per_mm - sheet.trim_mm) * sheet.pixels_per_mm;
            assert!((first - around[0] as f64 / 2.0).abs() < 1e-3, "{pixels:?}: begins at {first}");
            let wanted = margin * longest as f64;
            assert!(
                (first - wanted).abs() < 1.0 + 0.5 * longest as f64 / 640.0,
                "{pixels:?}: {first} for {wanted}"
            );
        }
    }
}
