//! The picture is developed from what dried: edges and grain as fine as it shows them, however coarse the cells.

use girtin_grid::Raster;
use girtin_optics::kubelka_munk::glaze_row;
use girtin_optics::{Coefficients, LinearRgb};
use girtin_paper::{HeightSource, RakingLight, raking_light};
use rayon::prelude::*;

use crate::area::Canvas;
use crate::brush::{PlannedMark, Touch};
use crate::composite::print;
use crate::drawing::BARE;
use crate::dried::Dried;
use crate::fill::SampleRow;
use crate::resolve::{PlannedFigures, PlannedGlaze, PlannedOutline, PlannedSheet};
use crate::spline::{Blend, around, spline};
use crate::surface::{Level, Surface};

/// Rows of pixels that are developed at a time.
const BAND: usize = 32;
/// Bands between two looks at whether to go on: enough for many threads.
const BANDS: usize = 32;

/// Samples to each side of the part of the paper that its mean height is taken from.
const LEVEL_SAMPLES: usize = 64;
/// Fewest of them a millimetre.
const LEVEL_PER_MM: f64 = 1.5;

/// Samples of the drawing along a sample of the picture, if that is a pixel: what makes contours smooth.
const LABELS: usize = 3;

/// Least and most that grain makes of an amount.
const GRAIN: [f32; 2] = [0.15, 2.5];

/// A sheet and the glazes on it, to be seen.
#[derive(Clone, Debug)]
pub struct Development<'a> {
    sheet: &'a PlannedSheet,
    glazes: Vec<(&'a Dried, &'a PlannedGlaze)>,
    /// Of the paper, at the picture's resolution; where something is drawn.
    level: Option<Level>,
}

/// Cells that a sample takes pigment from, and how much of each.
enum Shares {
    /// Sixteen inside a shape, of which each four in a column are one: a [`Blend`]'s cells.
    Inside([(usize, f32); 4]),
    /// Four where shapes meet.
    Beside([(usize, usize, f32); 4]),
}

impl Shares {
    /// What is taken of a field of cells, and of the same blended over the row's four.
    fn of(&self, cells: &Raster<f32>, blended: &[f32]) -> f32 {
        match self {
            Self::Inside(shares) => shares.iter().map(|&(x, share)| share * blended[x]).sum(),
            Self::Beside(shares) => shares.iter().map(|&(x, y, share)| share * cells.at(x, y)).sum(),
        }
    }
}

/// Samples to a cell from which a sample takes from sixteen cells: linear between four, cells would show.
const SMOOTH_FROM: f32 = 1.5;

impl<'a> Development<'a> {
    /// Of these glazes, from the paper up.
    pub fn new(
        sheet: &'a PlannedSheet,
        glazes: impl IntoIterator<Item = (&'a Dried, &'a PlannedGlaze)>,
    ) -> Self {
        let glazes: Vec<(&Dried, &PlannedGlaze)> = glazes.into_iter().collect();
        let is_drawn = glazes.iter().any(|(_, glaze)| glaze.figures.is_some());
        let level = is_drawn.then(|| {
            // So few samples a millimetre that paper is flat need no exact deviation, and metres of it would take minutes.
            let per_mm = (sheet.pixels_per_mm * sheet.samples as f64).max(LEVEL_PER_MM);
            Level::of(&sheet.paper.height_field(LEVEL_SAMPLES, LEVEL_SAMPLES, per_mm, [0.0; 2]))
        });
        Self { sheet, glazes, level }
    }

    /// The picture, in linear light.
    pub fn picture(&self) -> Raster<LinearRgb> {
        self.encoded(|color| color)
    }

    /// The picture with every color given another form; it never exists as a whole in linear light.
    pub fn encoded<T: Copy + Send>(&self, encode: impl Fn(LinearRgb) -> T + Sync) -> Raster<T> {
        self.encoded_while(encode, |_| true).unwrap_or_else(|| unreachable!("nobody ends it"))
    }

    /// [`Development::encoded`], as long as `goes_on` says so, which is told now and then how much is done, 0 to 1;
    /// `None` once it does not.
    pub fn encoded_while<T: Copy + Send>(
        &self,
        encode: impl Fn(LinearRgb) -> T + Sync,
        goes_on: impl Fn(f64) -> bool,
    ) -> Option<Raster<T>> {
        let [width, height] = self.sheet.picture;
        let mut pixels: Vec<T> = Vec::with_capacity(width * height);
        let bands: Vec<usize> = (0..height.div_ceil(BAND)).collect();
        for some in bands.chunks(BANDS) {
            let developed: Vec<Vec<T>> = some
                .par_iter()
                .map(|band| {
                    let first = band * BAND;
                    let rows = first..(first + BAND).min(height);
                    self.band(rows).into_iter().map(&encode).collect()
                })
                .collect();
            developed.iter().for_each(|band| pixels.extend_from_slice(band));
            if !goes_on(pixels.len() as f64 / (width * height) as f64) {
                return None;
            }
        }
        Raster::from_vec(width, height, pixels)
    }

    /// Pixels of some rows.
    fn band(&self, rows: std::ops::Range<usize>) -> Vec<LinearRgb> {
        let sheet = self.sheet;
        let (factor, count) = (sheet.samples, rows.len() * sheet.samples);
        let width = sheet.picture[0] * factor;
        let per_mm = sheet.pixels_per_mm * factor as f64;
        let first = rows.start * factor;
        let is_fine = !sheet.samples_are_cells || sheet.relief_mm > 0.0 || self.level.is_some();
        let above = usize::from(is_fine && first > 0);
        // With a row above and below, for slopes.
        let height = if is_fine {
            let origin = [sheet.trim_mm, sheet.trim_mm + (first - above) as f64 / per_mm];
            sheet.paper.height_field(width, count + above + 1, per_mm, origin)
        } else {
            Raster::from_fn(width, count, |x, y| sheet.height.at(x, first + y))
        };
        let mut samples = Raster::new(width, height.height(), sheet.ground);
        if !sheet.printed.is_empty() {
            let cell = [sheet.trim_mm * per_mm, sheet.trim_mm * per_mm + (first - above) as f64];
            let whole = if sheet.samples_are_cells {
                [width, sheet.picture[1] * factor].map(|samples| samples as f64)
            } else {
                [sheet.height.width(), sheet.height.height()].map(|n| n as f64 / sheet.cells_per_mm * per_mm)
            };
            let canvas = Canvas {
                height: &height,
                cells_per_mm: per_mm,
                seed: sheet.seed,
                origin: cell,
                sheet: whole,
            };
            for (color, area, map) in &sheet.printed {
                print(&mut samples, *color, &area.cover(&canvas, map.as_ref()));
            }
        }
        let drawn = self.level.map(|level| Drawn::new(sheet, level, &height, first - above, per_mm));
        for y in 0..count {
            let mut row = Row { y: first + y, width, per_mm, height: height.row(y + above) };
            for (dried, glaze) in &self.glazes {
                let ground = samples.row_mut(y + above);
                match (&glaze.figures, &drawn) {
                    (Some(figures), Some(drawn)) => drawn.lay(y + above, dried, glaze, figures, ground),
                    _ => row.lay(sheet, dried, glaze, ground),
                }
            }
        }
        if sheet.relief_mm > 0.0 {
            let light = RakingLight { depth_mm: sheet.relief_mm, ..RakingLight::default() };
            let lit = raking_light(&height, per_mm, &light);
            for y in above..above + count {
                let white = light.white as f32;
                for (sample, &lit) in samples.row_mut(y).iter_mut().zip(lit.row(y)) {
                    sample.0.iter_mut().for_each(|channel| *channel *= f64::from(lit / white));
                }
            }
        }
        reduced(&samples, above, rows.len(), factor)
    }
}

/// Some rows of samples with the drawing and the sheet's surface on them.
struct Drawn<'a> {
    sheet: &'a PlannedSheet,
    labels: Raster<u16>,
    labels_a_side: usize,
    surface: Surface,
    /// Where the first row and its first sample are, mm.
    origin: [f64; 2],
    per_mm: f64,
}

impl<'a> Drawn<'a> {
    fn new(sheet: &'a PlannedSheet, level: Level, height: &Raster<f32>, first: usize, per_mm: f64) -> Self {
        let origin = [sheet.trim_mm, sheet.trim_mm + first as f64 / per_mm];
        let n = LABELS.div_ceil(sheet.samples);
        let (width, rows) = (height.width() * n, height.height() * n);
        let labels = if sheet.drawing.is_empty() {
            Raster::new(width, rows, BARE)
        } else {
            sheet.drawing.labels(width, rows, per_mm * n as f64, origin)
        };
        let surface = Surface::new(height, level, per_mm, origin, sheet.seed);
        Self { sheet, labels, labels_a_side: n, surface, origin, per_mm }
    }

    /// Lays a glaze over a row: its fill, and its marks over that.
    fn lay(
        &self,
        y: usize,
        dried: &Dried,
        glaze: &PlannedGlaze,
        figures: &PlannedFigures,
        ground: &mut [LinearRgb],
    ) {
        let width = ground.len();
        let at_y = self.origin[1] + (y as f64 + 0.5) / self.per_mm;
        let row = SampleRow {
            origin: [self.origin[0], at_y],
            per_mm: self.per_mm,
            cells_per_mm: self.sheet.cells_per_mm,
            labels: &self.labels,
            labels_a_side: self.labels_a_side,
            surface: &self.surface,
            y,
        };
        let mut covered = vec![0.0f32; width];
        let mut amounts = vec![vec![0.0f32; width]; glaze.paints.len()];
        if let Some(fill) = &figures.fill {
            fill.row(&dried.amounts, &figures.grain, &row, &mut covered, &mut amounts);
        }
        let touches = |mark: &PlannedMark, each: &mut dyn FnMut(usize, &Touch)| {
            let [[x0, y0], [x1, y1]] = mark.bounds();
            if at_y < y0 || at_y > y1 {
                return;
            }
            let column = |mm: f64| ((mm - self.origin[0]) * self.per_mm).clamp(0.0, width as f64) as usize;
            for x in column(x0)..column(x1 + 1.0 / self.per_mm) {
                let place = [self.origin[0] + (x as f64 + 0.5) / self.per_mm, at_y];
                let (tooth, pin) = (self.surface.tooth.row(y)[x], self.surface.pins.row(y)[x]);
                if let Some(touch) = mark.at(place, tooth, pin, self.per_mm as f32) {
                    each(x, &touch);
                }
            }
        };
        let (knives, brushes): (Vec<_>, Vec<_>) = figures.marks.iter().partition(|mark| mark.scraped() > 0.0);
        for mark in brushes {
            touches(mark, &mut |x, touch| {
                // United: where two lie over each other paint lies once, the more of it.
                let before = covered[x];
                let all = before.max(touch.covered);
                for (pigment, (row, grain)) in amounts.iter_mut().zip(&figures.grain).enumerate() {
                    let own = mark.amounts(touch, pigment) * self.surface.grain(x, y, *grain);
                    let both = (row[x] * before).max(own * touch.covered);
                    row[x] = if all > 0.0 { both / all } else { 0.0 };
                }
                covered[x] = all;
            });
        }
        // Paper that is not covered shows as it was: a part of the light, not less paint.
        let mut painted = 0;
        while painted < width {
            let begin = painted + covered[painted..].iter().take_while(|&&covered| covered <= 0.0).count();
            let end = begin + covered[begin..].iter().take_while(|&&covered| covered > 0.0).count();
            if begin < end {
                let mut over: Vec<LinearRgb> = ground[begin..end].to_vec();
                let parts: Vec<&[f32]> = amounts.iter().map(|row| &row[begin..end]).collect();
                glaze_row(&glaze.paints, &parts, &mut over);
                for ((ground, over), covered) in
                    ground[begin..end].iter_mut().zip(&over).zip(&covered[begin..end])
                {
                    let covered = f64::from(*covered);
                    for (below, above) in ground.0.iter_mut().zip(over.0) {
                        *below += covered * (above - *below);
                    }
                }
            }
            painted = end.max(begin);
        }
        // A knife goes through all that is dry.
        for mark in knives {
            touches(mark, &mut |x, touch| {
                let part = f64::from(mark.scraped() * touch.covered);
                for (channel, bare) in ground[x].0.iter_mut().zip(self.sheet.ground.0) {
                    *channel += part * (bare - *channel);
                }
            });
        }
    }
}

/// A row of samples.
struct Row<'a> {
    y: usize,
    width: usize,
    per_mm: f64,
    height: &'a [f32],
}

impl Row<'_> {
    /// Lays a glaze over the row.
    fn lay(&mut self, sheet: &PlannedSheet, dried: &Dried, glaze: &PlannedGlaze, ground: &mut [LinearRgb]) {
        if sheet.samples_are_cells && glaze.outline.is_none() {
            let amounts: Vec<&[f32]> = dried.amounts.iter().map(|amounts| amounts.row(self.y)).collect();
            lay_row(&glaze.paints, &amounts, ground);
            return;
        }
        let mut amounts = vec![vec![0.0f32; self.width]; dried.amounts.len()];
        let cell = |at: usize| (sheet.trim_mm + (at as f64 + 0.5) / self.per_mm) * sheet.cells_per_mm;
        let to_samples = (self.per_mm / sheet.cells_per_mm) as f32;
        let y = cell(self.y) as f32;
        let blend = Blend::at(y, sheet.height.height());
        let blended: Vec<Vec<f32>> = dried.amounts.iter().map(|amounts| blend.of(amounts)).collect();
        let levels = blend.of(&sheet.height);
        for x in 0..self.width {
            let at = [cell(x) as f32, y];
            let shares = shares_of(at, &sheet.height, &levels, glaze.outline.as_ref(), to_samples);
            let Some((shares, level)) = shares else { continue };
            let finer = if sheet.samples_are_cells { 0.0 } else { self.height[x] - level };
            let fields = dried.amounts.iter().zip(&blended).zip(&dried.grain);
            for (row, ((cells, blended), grain)) in amounts.iter_mut().zip(fields) {
                row[x] = shares.of(cells, blended) * (1.0 + grain * finer).clamp(GRAIN[0], GRAIN[1]);
            }
        }
        let amounts: Vec<&[f32]> = amounts.iter().map(Vec::as_slice).collect();
        lay_row(&glaze.paints, &amounts, ground);
    }
}

/// Lays amounts over a row unless they are all nothing.
fn lay_row(paints: &[Coefficients], amounts: &[&[f32]], ground: &mut [LinearRgb]) {
    if amounts.iter().any(|row| row.iter().any(|&amount| amount > 0.0)) {
        glaze_row(paints, amounts, ground);
    }
}

/// Which cells a sample at a place, in cells, takes how much from, and the height between their middles; `None`: nothing.
/// `levels` is the height blended over the row.
///
/// Inside a shape the weights are a cubic B-spline's. Where shapes meet a sample takes from each as much as that covers of
/// it, and of its cells only.
fn shares_of(
    [x, y]: [f32; 2],
    height: &Raster<f32>,
    levels: &[f32],
    outline: Option<&PlannedOutline>,
    samples_per_cell: f32,
) -> Option<(Shares, f32)> {
    let (width, rows) = (height.width(), height.height());
    let (x, y) = ((x - 0.5).clamp(0.0, (width - 1) as f32), (y - 0.5).clamp(0.0, (rows - 1) as f32));
    let (x0, y0) = (x as usize, y as usize);
    let (fx, fy) = (x - x0 as f32, y - y0 as f32);
    let (xs, ys) = (around(x0, width), around(y0, rows));
    let inner = [(xs[1], ys[1]), (xs[2], ys[1]), (xs[1], ys[2]), (xs[2], ys[2])];
    let regions = inner.map(|(x, y)| outline.map_or(1, |outline| outline.regions.at(x, y)));
    let is_inside = |outline: &PlannedOutline| {
        ys.iter().all(|&y| {
            let row = outline.regions.row(y);
            xs.iter().all(|&x| row[x] == regions[0])
        }) || ys.iter().all(|&y| xs.iter().all(|&x| outline.has_no_edge(x, y)))
    };
    if regions == [0; 4] {
        return None;
    }
    let bare = outline.and_then(|outline| outline.masked.as_ref()).map_or(0.0, |masked| {
        let [x, y] = [(x + 0.5, width, masked.width()), (y + 0.5, rows, masked.height())]
            .map(|(at, cells, of)| at * of as f32 / cells as f32);
        masked.sample(x, y)
    });
    if samples_per_cell >= SMOOTH_FROM && outline.is_none_or(is_inside) {
        let weights = spline(fx);
        let level = xs.iter().zip(weights).map(|(&x, weight)| weight * levels[x]).sum();
        let shares = core::array::from_fn(|k| (xs[k], (1.0 - bare) * weights[k]));
        return Some((Shares::Inside(shares), level));
    }
    let weights = [(1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy];
    let level = inner.iter().zip(weights).map(|(&(x, y), weight)| weight * height.at(x, y)).sum();
    let mut shares = core::array::from_fn(|k| (inner[k].0, inner[k].1, weights[k]));
    let has_edge = |outline: &PlannedOutline| {
        regions != [regions[0]; 4] && !inner.iter().all(|&(x, y)| outline.has_no_edge(x, y))
    };
    if let Some(outline) = outline.filter(|outline| has_edge(outline)) {
        confine(&mut shares, regions, outline, samples_per_cell);
    }
    shares.iter_mut().for_each(|share| share.2 *= 1.0 - bare);
    Some((Shares::Beside(shares), level))
}

/// Gives the cells of every shape together what the shape covers of the sample.
fn confine(
    shares: &mut [(usize, usize, f32); 4],
    regions: [u8; 4],
    outline: &PlannedOutline,
    samples_per_cell: f32,
) {
    let between = *shares;
    let inside = between.map(|(x, y, _)| outline.edges.at(x, y));
    // How far a sample lies in the shape of each cell, from what its four cells say.
    let covered = regions.map(|region| {
        let signed = (0..4).map(|k| between[k].2 * if regions[k] == region { inside[k] } else { -inside[k] });
        (0.5 + signed.sum::<f32>() * samples_per_cell.max(1.0)).clamp(0.0, 1.0)
    });
    let is_first = |k: usize| !regions[..k].contains(&regions[k]);
    let all: f32 = (0..4).filter(|&k| is_first(k)).map(|k| covered[k]).sum();
    if all <= 0.0 {
        // Where three meet each may think it lies in another: none of it stays bare for that.
        (0..4).filter(|&k| regions[k] == 0).for_each(|k| shares[k].2 = 0.0);
        return;
    }
    for k in 0..4 {
        let own: f32 = (0..4).filter(|&j| regions[j] == regions[k]).map(|j| between[j].2).sum();
        let part = if own > 0.0 { between[k].2 / own } else { 0.0 };
        shares[k].2 = if regions[k] == 0 { 0.0 } else { part * covered[k] / all };
    }
}

/// The mean color of every block of `factor` × `factor` samples, in linear light.
fn reduced(samples: &Raster<LinearRgb>, skipped: usize, rows: usize, factor: usize) -> Vec<LinearRgb> {
    let width = samples.width() / factor;
    let weight = 1.0 / (factor * factor) as f64;
    let mut pixels = Vec::with_capacity(width * rows);
    for y in 0..rows {
        if factor == 1 {
            pixels.extend_from_slice(samples.row(y + skipped));
            continue;
        }
        for x in 0..width {
            let mut sum = [0.0; 3];
            for row in skipped + y * factor..skipped + (y + 1) * factor {
                for color in &samples.row(row)[x * factor..(x + 1) * factor] {
                    sum.iter_mut().zip(color.0).for_each(|(sum, channel)| *sum += channel);
                }
            }
            pixels.push(LinearRgb(sum.map(|sum| sum * weight)));
        }
    }
    pixels
}

#[cfg(test)]
mod tests {
    use crate::{Document, MapChest, PaintConfig, Stock};

    /// A dark mark with a knife's scrape across it, in glazes of their own; `%` is how much it scrapes.
    const SCRAPED: &str = "format = 1
[sheet]
size = [30, 20]
pixels_per_mm = 4
[[glaze]]
pigments = ['sepia']
[[glaze.events]]
do = 'marks'
rim = 0
marks = [{ path = [[2, 10], [28, 10]], widths = [8, 8], amounts = [1.5] }]
[[glaze]]
pigments = ['sepia']
[[glaze.events]]
do = 'marks'
rim = 0
marks = [{ path = [[15, 2], [15, 18]], widths = [2, 2], amounts = [0], scraped = % }]
";

    #[test]
    fn a_knife_shows_as_much_of_the_paper_as_it_scrapes() {
        let light = |scraped: &str| {
            let text = SCRAPED.replace('%', scraped);
            let document = Document::from_toml("test", &text, &Stock::builtin()).unwrap();
            let painted =
                document.paint(&Stock::builtin(), &MapChest::default(), &PaintConfig::default()).unwrap();
            let picture = painted.picture();
            let at = |mm: [f64; 2]| picture.at((4.0 * mm[0]) as usize, (4.0 * mm[1]) as usize).0[1];
            assert_eq!(picture.at(60, 12), document.sheet.ground, "paper stays paper");
            (at([15.0, 10.0]), at([8.0, 10.0]), document.sheet.ground.0[1])
        };
        let (whole, dark, paper) = light("1");
        assert!(dark < 0.3 && (whole - paper).abs() < 1e-6, "{whole} {dark} {paper}");
        let (half, dark, _) = light("0.5");
        assert!((half - 0.5 * (dark + paper)).abs() < 0.1, "{half}");
    }
}
