//! A painting as it grows: the sheet, and wash after wash laid over it from the top down.

use girtin_grid::Raster;

use crate::develop::Development;
use crate::document::{Document, Stock};
use crate::maps::Maps;
use crate::paint::Painted;
use crate::resolve::ResolveError;

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
pub struct Timelapse {
    /// The sheet, and the picture after each wash, sRGB.
    washes: Vec<Raster<[u8; 3]>>,
}

impl Timelapse {
    /// Of a painted document, as long as `goes_on` says so. The long edge has at most so many pixels, if the document has
    /// cells of their own.
    ///
    /// # Errors
    /// The document's sheet cannot be resolved again.
    pub fn new(
        document: &Document,
        painted: &Painted,
        stock: &Stock,
        maps: &dyn Maps,
        longest: usize,
        goes_on: impl Fn(f64) -> bool,
    ) -> Result<Option<Self>, ResolveError> {
        let [width, height] = painted.sheet.picture;
        let mut document = document.clone();
        let smaller = (longest as f64 / width.max(height).max(1) as f64).min(1.0);
        // Where samples are cells, no other picture can be made of them.
        let smaller = document.sheet.cells_per_mm.map_or(1.0, |_| smaller);
        document.sheet.pixels_per_mm *= smaller;
        // As many samples to a cell as before: grain below a pixel is averaged.
        let samples = libm::ceil(f64::from(document.sheet.cells_per_pixel) / smaller);
        let cells = libm::ceil(document.cells_per_mm() / document.sheet.pixels_per_mm);
        document.sheet.cells_per_pixel = samples.min(cells).clamp(1.0, 8.0) as u32;
        let sheet = document.resolve_sheet(stock, maps)?;
        let count = painted.glazes.len() + 1;
        let washes = (0..count).map(|wash| {
            let glazes = painted.glazes[..wash].iter().map(|glaze| (&glaze.dried, &glaze.plan));
            let goes_on = |part| goes_on((wash as f64 + part) / count as f64);
            Development::new(&sheet, glazes).encoded_while(|color| color.to_srgb().to_bytes(), goes_on)
        });
        Ok(washes.collect::<Option<Vec<_>>>().map(|washes| Self { washes }))
    }

    /// Columns and rows of a frame.
    pub fn size(&self) -> (usize, usize) {
        (self.washes[0].width(), self.washes[0].height())
    }

    /// How many frames there are.
    pub fn frames(&self) -> u32 {
        BARE + WASH * (self.washes.len() - 1) as u32 + FINISHED
    }

    /// A frame in sRGB, from 0.
    pub fn frame(&self, number: u32) -> Raster<[u8; 3]> {
        let last = self.washes.len() - 1;
        let laying = number.saturating_sub(BARE - 1).min(WASH * last as u32);
        let (whole, part) = ((laying / WASH) as usize, laying % WASH);
        let (before, after) = (&self.washes[whole], &self.washes[(whole + 1).min(last)]);
        let front = part as f32 / WASH as f32 * (1.0 + LAG + SOFT);
        let (width, height) = (before.width(), before.height());
        Raster::from_fn(width, height, |x, y| {
            let place = y as f32 / height as f32 + LAG * x as f32 / width as f32;
            let laid = ((front - place) / SOFT).clamp(0.0, 1.0);
            let (before, after) = (before.at(x, y), after.at(x, y));
            // Of encoded values: between light, which adds, and thickness of pigment, which multiplies.
            [0, 1, 2].map(|c| {
                let (before, after) = (f32::from(before[c]), f32::from(after[c]));
                (before + laid * (after - before) + 0.5) as u8
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maps::MapChest;
    use crate::paint::PaintConfig;

    #[test]
    fn a_film_begins_with_the_sheet_and_ends_with_the_picture() {
        let text = "format = 1\n[sheet]\nsize = [12, 8]\ncells_per_mm = 4\n[[glaze]]\npigments = ['burnt-umber']\n\
                    [[glaze.events]]\ndo = 'wet'\n[[glaze.events]]\ndo = 'water'\namount = 0.5\n\
                    [[glaze.events]]\ndo = 'pigment'\namounts = [0.5]\n[[glaze.events]]\ndo = 'run'\nsteps = 4\n";
        let stock = Stock::builtin();
        let document = Document::from_toml("film.toml", text, &stock).unwrap();
        let painted = document.paint(&stock, &MapChest::default(), &PaintConfig::default()).unwrap();
        let film = |longest| {
            let film = Timelapse::new(&document, &painted, &stock, &MapChest::default(), longest, |_| true);
            film.unwrap().unwrap()
        };
        let (film, small) = (film(1000), film(24));
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
        assert_eq!(small.size(), (24, 16));
    }
}
