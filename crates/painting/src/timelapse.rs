//! A painting as it grows: the sheet, and wash after wash laid over it from the top down.

use girtin_grid::Raster;

use crate::develop::Development;
use crate::document::{Document, Stock};
use crate::dried::Dried;
use crate::maps::Maps;
use crate::paint::{Painted, PaintedGlaze};
use crate::resolve::{PlannedSheet, ResolveError};

/// Frames a second.
pub const FRAMES_PER_SECOND: u16 = 12;

/// Frames of the bare sheet, of a wash, and of the finished painting.
const BARE: u32 = 6;
const WASH: u32 = 14;
const FINISHED: u32 = 24;

/// How much of the way down the brush is wet at a time.
const SOFT: f32 = 0.25;
/// How far the brush lags behind at the right, a part of the way down: washes are laid from the left.
const LAG: f32 = 0.15;

/// The frames of a painting's film.
#[derive(Debug)]
pub struct Timelapse<'a> {
    glazes: &'a [PaintedGlaze],
    sheet: PlannedSheet,
}

impl<'a> Timelapse<'a> {
    /// Of a painted document, with the picture's long edge at most so many pixels.
    ///
    /// # Errors
    /// The document's sheet cannot be resolved again.
    pub fn new(
        document: &Document,
        painted: &'a Painted,
        stock: &Stock,
        maps: &dyn Maps,
        longest: usize,
    ) -> Result<Self, ResolveError> {
        let [width, height] = painted.sheet.picture;
        let mut document = document.clone();
        let smaller = (longest as f64 / width.max(height).max(1) as f64).min(1.0);
        document.sheet.pixels_per_mm *= smaller;
        // As many samples to a cell as before: grain below a pixel is averaged.
        let samples = libm::ceil(f64::from(document.sheet.cells_per_pixel) / smaller);
        let cells = libm::ceil(document.cells_per_mm() / document.sheet.pixels_per_mm);
        document.sheet.cells_per_pixel = samples.min(cells).clamp(1.0, 8.0) as u32;
        Ok(Self { glazes: &painted.glazes, sheet: document.resolve_sheet(stock, maps)? })
    }

    /// Columns and rows of a frame.
    pub fn size(&self) -> (usize, usize) {
        (self.sheet.picture[0], self.sheet.picture[1])
    }

    /// How many frames there are.
    pub fn frames(&self) -> u32 {
        BARE + WASH * self.glazes.len() as u32 + FINISHED
    }

    /// How much is laid in a frame; frames of the same number are alike.
    pub fn laid_at(&self, number: u32) -> u32 {
        number.saturating_sub(BARE - 1).min(WASH * self.glazes.len() as u32)
    }

    /// A frame in sRGB, from 0.
    pub fn frame(&self, number: u32) -> Raster<[u8; 3]> {
        let laying = self.laid_at(number);
        let (whole, part) = ((laying / WASH) as usize, laying % WASH);
        let wet = self.glazes.get(whole).filter(|_| part > 0);
        let wet = wet.map(|glaze| (laid_down_to(&glaze.dried, part as f32 / WASH as f32), &glaze.plan));
        let dry = self.glazes[..whole].iter().map(|glaze| (&glaze.dried, &glaze.plan));
        let glazes = dry.chain(wet.iter().map(|(dried, plan)| (dried, *plan)));
        Development::new(&self.sheet, glazes).encoded(|color| color.to_srgb().to_bytes())
    }
}

/// A wash of which so much is laid, 0 to 1.
fn laid_down_to(dried: &Dried, part: f32) -> Dried {
    let mut dried = dried.clone();
    for amounts in &mut dried.amounts {
        let (width, height) = (amounts.width() as f32, amounts.height() as f32);
        let front = part * (1.0 + LAG + SOFT);
        for y in 0..amounts.height() {
            for (x, amount) in amounts.row_mut(y).iter_mut().enumerate() {
                let place = y as f32 / height + LAG * x as f32 / width;
                *amount *= ((front - place) / SOFT).clamp(0.0, 1.0);
            }
        }
    }
    dried
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maps::MapChest;
    use crate::paint::PaintConfig;

    #[test]
    fn a_film_begins_with_the_sheet_and_ends_with_the_picture() {
        let text = "format = 1\n[sheet]\nsize = [12, 8]\n[[glaze]]\npigments = ['burnt-umber']\n\
                    [[glaze.events]]\ndo = 'wet'\n[[glaze.events]]\ndo = 'water'\namount = 0.5\n\
                    [[glaze.events]]\ndo = 'pigment'\namounts = [0.5]\n[[glaze.events]]\ndo = 'run'\nsteps = 4\n";
        let stock = Stock::builtin();
        let document = Document::from_toml("film.toml", text, &stock).unwrap();
        let painted = document.paint(&stock, &MapChest::default(), &PaintConfig::default()).unwrap();
        let film = Timelapse::new(&document, &painted, &stock, &MapChest::default(), 1000).unwrap();
        let bytes = |development: Development<'_>| development.encoded(|color| color.to_srgb().to_bytes());
        assert_eq!(film.frame(0), bytes(painted.development_of(0)));
        assert_eq!(film.frame(film.frames() - 1), bytes(painted.development()));
        assert_eq!(film.frame(film.frames() - FINISHED), film.frame(film.frames() - 1));
        // Halfway down, the top is painted and the bottom bare.
        let (half, end) = (film.frame(BARE - 1 + WASH / 2), film.frame(film.frames() - 1));
        let bare = film.frame(0);
        let (width, height) = film.size();
        assert_eq!(
            (half.at(1, 1), half.at(width - 1, height - 1)),
            (end.at(1, 1), bare.at(width - 1, height - 1))
        );
        let small = Timelapse::new(&document, &painted, &stock, &MapChest::default(), 24).unwrap();
        assert_eq!(small.size(), (24, 16));
    }
}
