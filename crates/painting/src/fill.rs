//! A wash that fills figures of the drawing: on cells for the water, and at any resolution for the picture.

use std::collections::VecDeque;

use girtin_grid::distance::signed_distance;
use girtin_grid::noise::{Fractal, Noise};
use girtin_grid::{Raster, random};

use crate::area::Coverage;
use crate::brush::smoothstep;
use crate::document::{EdgeStretch, Fill, FilledFigure};
use crate::drawing::{BARE, Drawing};
use crate::resolve::Deed;
use crate::spline::{Blend, around, spline};
use crate::surface::Surface;

/// Samples of the drawing along a cell.
const SAMPLES: usize = 2;
/// Cells that paint is carried on beyond a wash, so that the picture finds it under its whole edge.
const BEYOND: usize = 3;
/// Water that a place holds where the paint fades into it, volumes of the pores.
const MOIST: f32 = 1.6;
/// Fades from which on a contour is lost altogether, mm; below they are partly crisp.
const LOST_MM: [f32; 2] = [0.3, 1.2];
/// How far a fade strays, parts of it, and over which lengths, mm.
const STRAYS: [(f32, f64); 2] = [(0.38, 7.0), (0.05, 1.6)];
/// Unevenness goes so many deviations at most: what dries first would draw a star into the rest.
const MOST_UNEVEN: f32 = 1.5;

/// Cosine and sine of the direction that washes are laid in, and how many times as far they are even along it.
const BRUSHED: [f64; 3] = [0.97, -0.24, 2.8];
/// How uneven paint is as against water.
const PAINT_UNEVEN: f32 = 0.5;
/// Over how many times the length of unevenness pigments part.
const CHARGED: f64 = 1.8;

/// Depth of the rim, mm; how strong it is for its own sake, on the lower side of a shape, and by chance.
const RIM_MM: f32 = 0.5;
const RIM: [f32; 3] = [0.05, 0.55, 1.15];
/// Length over which chance changes along a contour, mm.
const RIM_CHANGES_MM: f64 = 9.0;

/// Where a contour within a family holds and where it is lost: deviations of a noise, over so many mm.
const HELD: [f32; 2] = [-0.9, 0.7];
const HELD_MM: f64 = 14.0;
/// How much more and less paint the hairs of a brush leave, how long and wide their traces are, mm, and over what lengths they
/// are seen more and less.
const HAIRS: f32 = 0.08;
const HAIRS_MM: [f64; 2] = [16.0, 1.7];
const HAIRS_SEEN_MM: f64 = 26.0;

/// A figure's paint.
#[derive(Clone, Debug)]
struct Paint {
    family: u16,
    /// Cosine and sine of the direction it is laid in.
    laid: [f64; 2],
    /// How crisp its contour stays within its family.
    held: f32,
    amounts: Vec<f32>,
    /// Where a steady change begins, its direction over its length squared, and what it ends in.
    graded: Option<([f64; 2], [f64; 2], Vec<f32>)>,
}

impl Paint {
    fn new(filled: &FilledFigure) -> Self {
        let single = |amounts: &[f64]| amounts.iter().map(|&amount| amount as f32).collect::<Vec<_>>();
        let graded = filled.graded.as_ref().map(|graded| {
            let [[ax, ay], [bx, by]] = graded.line;
            let square = ((bx - ax) * (bx - ax) + (by - ay) * (by - ay)).max(1e-9);
            ([ax, ay], [(bx - ax) / square, (by - ay) / square], single(&graded.amounts))
        });
        let laid = filled.laid_degrees.map_or([BRUSHED[0], BRUSHED[1]], |degrees| {
            [libm::cos(degrees.to_radians()), libm::sin(degrees.to_radians())]
        });
        Self {
            laid,
            held: filled.held as f32,
            family: u16::try_from(filled.family).unwrap_or(u16::MAX - 1) + 1,
            amounts: single(&filled.amounts),
            graded,
        }
    }

    /// How much of a pigment is meant to be at a place, mm.
    fn at(&self, place: [f64; 2], pigment: usize) -> f32 {
        let begin = self.amounts[pigment];
        let Some((from, direction, end)) = &self.graded else { return begin };
        let part = (place[0] - from[0]) * direction[0] + (place[1] - from[1]) * direction[1];
        begin + (part.clamp(0.0, 1.0) as f32) * (end[pigment] - begin)
    }
}

/// A fill ready to be laid and to be seen.
#[derive(Clone, Debug)]
pub struct PlannedFill {
    paints: Vec<Option<Paint>>,
    /// Figure of every cell and some around the wash, from 1, and its family; 0 is none.
    figures: Raster<u16>,
    families: Raster<u16>,
    /// Whether water comes to a cell.
    wet: Raster<bool>,
    /// How far inside the wash the middle of a cell is, mm.
    inside: Raster<f32>,
    /// How far paint fades, mm, and how far it breaks up, where it does anywhere.
    lost: Option<Raster<f32>>,
    dry: Option<Raster<f32>>,
    rim: f32,
    noise: Noise,
}

/// A row of samples that a fill is laid on.
pub struct SampleRow<'a> {
    /// Where the row is, mm, and its first sample.
    pub origin: [f64; 2],
    /// Samples a millimetre.
    pub per_mm: f64,
    /// Cells a millimetre.
    pub cells_per_mm: f64,
    /// Labels of the drawing, so many to each side of a sample.
    pub labels: &'a Raster<u16>,
    /// How many.
    pub labels_a_side: usize,
    /// Fine structure of the sheet.
    pub surface: &'a Surface,
    /// The row in `labels`, in samples, and in `surface`.
    pub y: usize,
}

impl PlannedFill {
    /// Resolves the fills of a glaze; `name` seeds its unevenness.
    pub fn new(
        fills: &[&Fill],
        drawing: &Drawing,
        size: [usize; 2],
        cells_per_mm: f64,
        seed: u64,
        name: &str,
        deeds: &mut Vec<Deed>,
    ) -> Self {
        let [width, height] = size;
        let per_mm = cells_per_mm * SAMPLES as f64;
        let labels = drawing.labels(width * SAMPLES, height * SAMPLES, per_mm, [0.0, 0.0]);
        let mut paints: Vec<Option<Paint>> = vec![None; drawing.len()];
        for filled in fills.iter().flat_map(|fill| &fill.figures) {
            paints[filled.figure] = Some(Paint::new(filled));
        }
        let is_painted = |label: u16| label != BARE && paints[usize::from(label) - 1].is_some();
        let mask = Raster::by_rows(labels.width(), labels.height(), |x, y| is_painted(labels.row(y)[x]));
        let far = signed_distance(&mask);
        let inside = Raster::by_rows(width, height, |x, y| {
            let corner: f32 = (0..SAMPLES * SAMPLES)
                .map(|k| far.row(y * SAMPLES + k / SAMPLES)[x * SAMPLES + k % SAMPLES])
                .sum();
            (corner / (SAMPLES * SAMPLES) as f32 / per_mm as f32).clamp(-1e3, 1e3)
        });
        let edges: Vec<&EdgeStretch> = fills.iter().flat_map(|fill| &fill.edges).collect();
        let lost = field(&edges, |edge| edge.lost_mm, size, cells_per_mm);
        let dry = field(&edges, |edge| edge.dry_mm, size, cells_per_mm);
        let noise = Noise::new(seed, random::stage(&format!("fill {name}")));
        let place = |x: usize, y: usize| [x, y].map(|at| (at as f64 + 0.5) / cells_per_mm);
        // How much of the paint comes to a cell, all but where it fades; and whether that is reached by water.
        let fading = lost.as_ref().map(|lost| {
            Raster::by_rows(width, height, |x, y| {
                let (fade, d) = (lost.row(y)[x], inside.row(y)[x]);
                if fade < 0.1 {
                    return (0.0, 1.0);
                }
                let [x, y] = place(x, y);
                let strays: f32 = STRAYS
                    .iter()
                    .enumerate()
                    .map(|(k, &(part, mm))| {
                        let at = [x / mm + 31.0 * k as f64, y / mm];
                        part * fade * 2.2 * noise.fbm(at, Fractal { octaves: 2, gain: 0.5 }) as f32
                    })
                    .sum();
                let soft = smoothstep(-1.1, 1.1, (d + strays) / fade);
                (smoothstep(LOST_MM[0], LOST_MM[1], fade), libm::powf(soft, 1.25))
            })
        });
        let of_cell = Raster::by_rows(width, height, |x, y| {
            let label = |k: usize| labels.row(y * SAMPLES + k / SAMPLES)[x * SAMPLES + k % SAMPLES];
            let painted = (0..SAMPLES * SAMPLES).map(label).filter(|&label| is_painted(label));
            painted.max().unwrap_or(BARE)
        });
        // A seam of dry cells parts two families.
        let family = |x: usize, y: usize| match of_cell.row(y)[x].checked_sub(1) {
            Some(figure) => paints[usize::from(figure)].as_ref().map_or(0, |paint| paint.family),
            None => 0,
        };
        let is_seam = |x: usize, y: usize| {
            let own = family(x, y);
            let parts = |other: u16| own != 0 && other != 0 && own != other;
            (x + 1 < width && parts(family(x + 1, y))) || (y + 1 < height && parts(family(x, y + 1)))
        };
        let wet = Raster::by_rows(width, height, |x, y| {
            let fades = fading.as_ref().map_or((0.0, 0.0), |fading| fading.row(y)[x]);
            (of_cell.row(y)[x] != BARE || (fades.0 > 0.3 && fades.1 > 0.01)) && !is_seam(x, y)
        });
        let carried = carried_on(&of_cell, &wet, BEYOND);
        let cell = |x: usize, y: usize| {
            let label = carried.row(y)[x];
            (label != BARE && wet.row(y)[x]).then(|| paints[usize::from(label) - 1].as_ref()).flatten()
        };
        let fill = fills[0];
        let (uneven, scale) = (fill.uneven as f32, fill.uneven_scale_mm);
        let varied = Raster::by_rows(width, height, |x, y| {
            if uneven <= 0.0 || !wet.row(y)[x] {
                return 0.0;
            }
            let at = brushed(place(x, y)).map(|mm| mm / scale);
            (3.2 * noise.fbm(at, Fractal { octaves: 3, gain: 0.45 }) as f32).clamp(-MOST_UNEVEN, MOST_UNEVEN)
        });
        let whole = |amount: Raster<f32>| Coverage { x: 0, y: 0, amount };
        if let Some(fading) = &fading {
            deeds.push(Deed::Moisten(whole(fading.map(|(lost, _)| MOIST * lost))));
        }
        deeds.push(Deed::Wet(whole(wet.map(|wet| f32::from(u8::from(wet))))));
        let water = fill.water as f32;
        deeds.push(Deed::Water(whole(Raster::by_rows(width, height, |x, y| {
            if wet.row(y)[x] { water * (1.0 + uneven * varied.row(y)[x]).max(0.1) } else { 0.0 }
        }))));
        let pigments = fill.figures.first().map_or(0, |filled| filled.amounts.len());
        let charged = fill.charged as f32;
        for pigment in 0..pigments {
            // Each pigment goes its own way.
            let apart = |[x, y]: [f64; 2]| {
                if charged <= 0.0 {
                    return 1.0;
                }
                let [x, y] = brushed([x, y]);
                let at = [x / (CHARGED * scale) + 17.3 * pigment as f64, y / (CHARGED * scale)];
                let n = 2.6 * noise.fbm(at, Fractal { octaves: 4, gain: 0.62 }) as f32;
                (1.0 + charged * n.clamp(-MOST_UNEVEN, MOST_UNEVEN)).max(0.15)
            };
            let amount = Raster::by_rows(width, height, |x, y| {
                let Some(paint) = cell(x, y) else { return 0.0 };
                let (lost, soft) = fading.as_ref().map_or((0.0, 1.0), |fading| fading.row(y)[x]);
                let thinned = 1.0 - lost + lost * soft;
                let uneven = (1.0 + PAINT_UNEVEN * uneven * varied.row(y)[x]).max(0.2);
                paint.at(place(x, y), pigment) * thinned * uneven * apart(place(x, y))
            });
            if amount.as_slice().iter().all(|&amount| amount == 0.0) {
                continue;
            }
            let only = (0..pigments).map(|k| f64::from(u8::from(k == pigment))).collect();
            deeds.push(Deed::Pigment(whole(amount), only));
        }
        let families = carried.map(|label| match label.checked_sub(1) {
            Some(figure) => paints[usize::from(figure)].as_ref().map_or(0, |paint| paint.family),
            None => 0,
        });
        let rim = fill.rim as f32;
        Self { figures: carried, families, wet, inside, lost, dry, rim, noise, paints }
    }

    /// Carries what dried on into cells around the wash.
    pub fn complete(&self, amounts: &mut [Raster<f32>]) {
        let (width, height) = (self.wet.width(), self.wet.height());
        let mut known = self.wet.clone();
        for _ in 0..BEYOND {
            let mut found = Vec::new();
            for y in 0..height {
                for x in 0..width {
                    let family = self.families.row(y)[x];
                    if family == 0 || known.row(y)[x] {
                        continue;
                    }
                    let (xs, ys) =
                        (x.saturating_sub(1)..(x + 2).min(width), y.saturating_sub(1)..(y + 2).min(height));
                    let around: Vec<(usize, usize)> = ys
                        .flat_map(|y| xs.clone().map(move |x| (x, y)))
                        .filter(|&(x, y)| known.row(y)[x] && self.families.row(y)[x] == family)
                        .collect();
                    if !around.is_empty() {
                        found.push((x, y, around));
                    }
                }
            }
            for (x, y, around) in &found {
                for amounts in amounts.iter_mut() {
                    let sum: f32 = around.iter().map(|&(x, y)| amounts.at(x, y)).sum();
                    amounts.row_mut(*y)[*x] = sum / around.len() as f32;
                }
            }
            found.iter().for_each(|&(x, y, _)| known.row_mut(y)[x] = true);
        }
    }

    /// Lays what dried on a row of samples: how much of each is covered, and how much of each pigment is there.
    pub fn row(
        &self,
        dried: &[Raster<f32>],
        grain: &[f32],
        row: &SampleRow<'_>,
        covered: &mut [f32],
        amounts: &mut [Vec<f32>],
    ) {
        let scale = row.cells_per_mm;
        let y = (row.origin[1] * scale - 0.5).clamp(0.0, (self.inside.height() - 1) as f64) as f32;
        let blend = Blend::at(y + 0.5, self.inside.height());
        let ys = blend.rows;
        let blended: Vec<Vec<f32>> = dried.iter().map(|cells| blend.of(cells)).collect();
        let lines: [&[u16]; 4] = ys.map(|y| self.families.row(y));
        // The same family in all four rows, or a mark that they differ.
        const DIFFER: u16 = u16::MAX;
        let column: Vec<u16> = (0..self.families.width())
            .map(|x| {
                let first = lines[0][x];
                if lines.iter().all(|line| line[x] == first) { first } else { DIFFER }
            })
            .collect();
        let n = row.labels_a_side;
        let labels: Vec<&[u16]> = (0..n).map(|k| row.labels.row(row.y * n + k)).collect();
        for (at, covered) in covered.iter_mut().enumerate() {
            let mm = [row.origin[0] + (at as f64 + 0.5) / row.per_mm, row.origin[1]];
            let x = (mm[0] * scale - 0.5).clamp(0.0, (self.inside.width() - 1) as f64) as f32;
            let cell = [x + 0.5, y + 0.5];
            let mut count = 0;
            let mut label = BARE;
            for line in &labels {
                for &sample in &line[at * n..(at + 1) * n] {
                    if sample != BARE && self.paints[usize::from(sample) - 1].is_some() {
                        count += 1;
                        label = label.max(sample);
                    }
                }
            }
            let mut cover = count as f32 / (n * n) as f32;
            let fade = self.lost.as_ref().map_or(0.0, |lost| lost.sample(cell[0], cell[1]));
            let lost = smoothstep(LOST_MM[0], LOST_MM[1], fade);
            let xs = around(x as usize, self.inside.width());
            let paint = label.checked_sub(1).and_then(|figure| self.paints[usize::from(figure)].as_ref());
            let family = match paint {
                Some(paint) => paint.family,
                None if lost > 0.0 => self.families.row(ys[1])[xs[1]],
                None => continue,
            };
            if lost > 0.0 {
                cover += lost * (1.0 - cover);
            }
            if cover <= 0.0 || family == 0 {
                continue;
            }
            let d = self.inside.sample(cell[0], cell[1]);
            let dragged = self.dry.as_ref().map_or(0.0, |dry| dry.sample(cell[0], cell[1]));
            if dragged > 0.15 {
                let laid = paint.map_or([BRUSHED[0], BRUSHED[1]], |paint| paint.laid);
                let tooth = row.surface.tooth.row(row.y)[at];
                cover *= self.breaks_up(mm, laid, d.max(0.0), dragged, tooth);
                if cover <= 0.0 {
                    continue;
                }
            }
            *covered = cover;
            let gathers = self.rim * (1.0 - lost) * smoothstep(0.6, 0.1, dragged);
            let rim = if gathers > 0.0 && d < 4.0 * RIM_MM { self.rim_at(mm, cell, d, gathers) } else { 1.0 };
            let fx = x.fract();
            let one = xs.iter().all(|&x| column[x] == family);
            let weights = spline(fx);
            let near = (!one).then(|| self.within(family, x, y));
            let held = paint.and_then(|paint| self.held(paint, label, mm, [x, y]));
            let streak = paint.map_or(1.0, |paint| self.streak(paint, mm));
            for (pigment, (row_out, grain)) in amounts.iter_mut().zip(grain).enumerate() {
                let amount = match &near {
                    None => xs.iter().zip(weights).map(|(&x, w)| w * blended[pigment][x]).sum(),
                    Some(Some(near)) => near.iter().map(|&(x, y, w)| w * dried[pigment].row(y)[x]).sum(),
                    Some(None) => paint.map_or(0.0, |paint| paint.at(mm, pigment)),
                };
                let held = held.as_ref().map_or(1.0, |held| held[pigment]);
                row_out[at] = amount * held * streak * rim * row.surface.grain(at, row.y, *grain);
            }
        }
    }

    /// The four cells around a place, and how near it is to each, 1 in all.
    fn cells_around(&self, x: f32, y: f32) -> [(usize, usize, f32); 4] {
        let (x0, y0) = (x as usize, y as usize);
        let (x1, y1) = ((x0 + 1).min(self.families.width() - 1), (y0 + 1).min(self.families.height() - 1));
        let (fx, fy) = (x.fract(), y.fract());
        [
            (x0, y0, (1.0 - fx) * (1.0 - fy)),
            (x1, y0, fx * (1.0 - fy)),
            (x0, y1, (1.0 - fx) * fy),
            (x1, y1, fx * fy),
        ]
    }

    /// The four cells around a place as far as they are of a family, with shares of 1 in all; `None` if none is.
    fn within(&self, family: u16, x: f32, y: f32) -> Option<[(usize, usize, f32); 4]> {
        let mut cells = self.cells_around(x, y);
        for (x, y, share) in &mut cells {
            if self.families.row(*y)[*x] != family {
                *share = 0.0;
            }
        }
        let sum: f32 = cells.iter().map(|cell| cell.2).sum();
        cells.iter_mut().for_each(|cell| cell.2 /= sum);
        (sum > 0.02).then_some(cells)
    }

    /// What a figure's own contour, exact, makes of amounts of its family that ran on cells: where it was nearly dry it holds.
    fn held(&self, paint: &Paint, label: u16, mm: [f64; 2], [x, y]: [f32; 2]) -> Option<Vec<f32>> {
        let cells = self.cells_around(x, y).map(|(x, y, share)| (self.figures.row(y)[x], share));
        if cells.iter().all(|cell| cell.0 == label) {
            return None;
        }
        let at = mm.map(|mm| mm / HELD_MM);
        let chance = 2.4 * self.noise.fbm([at[0] + 91.0, at[1]], Fractal { octaves: 2, gain: 0.5 }) as f32;
        let held = paint.held * smoothstep(HELD[0], HELD[1], chance);
        let of = |pigment: usize| {
            let (mut sum, mut all) = (0.0, 0.0);
            for (label, share) in cells {
                let Some(other) = label.checked_sub(1).and_then(|at| self.paints[usize::from(at)].as_ref())
                else {
                    continue;
                };
                if other.family == paint.family {
                    sum += share * other.at(mm, pigment);
                    all += share;
                }
            }
            let (own, mean) = (paint.at(mm, pigment), sum / all.max(1e-6));
            if mean < 1e-4 { 1.0 } else { (1.0 + held * (own / mean - 1.0)).clamp(0.3, 3.0) }
        };
        Some((0..paint.amounts.len()).map(of).collect())
    }

    /// What the hairs of a brush make of the amount at a place.
    fn streak(&self, paint: &Paint, [x, y]: [f64; 2]) -> f32 {
        let [cos, sin] = paint.laid;
        let (along, across) = (cos * x + sin * y, cos * y - sin * x);
        let lane = 2.4
            * self.noise.fbm(
                [along / HAIRS_MM[0] + 3.1 * f64::from(paint.family), across / HAIRS_MM[1]],
                Fractal { octaves: 2, gain: 0.6 },
            ) as f32;
        let place = 2.4
            * self.noise.fbm([x / HAIRS_SEEN_MM + 41.0, y / HAIRS_SEEN_MM], Fractal { octaves: 2, gain: 0.5 })
                as f32;
        1.0 + HAIRS * smoothstep(-0.1, 1.5, place) * lane.clamp(-2.0, 2.0)
    }

    /// How much of a place a brush touches that runs dry towards an edge `inside` mm away.
    fn breaks_up(&self, [x, y]: [f64; 2], [cos, sin]: [f64; 2], inside: f32, over: f32, tooth: f32) -> f32 {
        let (along, across) = (cos * x + sin * y, cos * y - sin * x);
        let noise = |x: f64, y: f64| 2.2 * self.noise.fbm([x, y], Fractal { octaves: 2, gain: 0.55 }) as f32;
        let over = over * (1.0 + 0.55 * noise(x / 5.0 + 11.0, y / 5.0)).clamp(0.2, 2.0);
        let part = inside / over.max(0.2);
        if part > 1.3 {
            return 1.0;
        }
        // Streaks, fjords and islands: a belt of even dots is a seam.
        let fjords = noise(x / 4.2 + 23.0, y / 3.2) + 0.8 * noise(x / 1.9 + 37.0, y / 1.5);
        let ragged = 0.36 * noise(along / 11.0, across / 0.9 + 53.0) + 0.12 * fjords;
        // What is wider than the tooth decides, or an edge is a belt of dots.
        let tooth = 0.5 + 0.5 * (tooth - 0.5);
        let dryness = libm::powf((1.0 - part).clamp(0.0, 1.0), 0.9) + ragged * smoothstep(1.3, 0.3, part);
        smoothstep(-0.06, 0.06, tooth - dryness)
    }

    /// What the rim makes of the amount at a place `d` mm inside.
    fn rim_at(&self, mm: [f64; 2], [x, y]: [f32; 2], d: f32, gathers: f32) -> f32 {
        let below = self.inside.sample(x, y + 0.7) - self.inside.sample(x, y - 0.7);
        let right = self.inside.sample(x + 0.7, y) - self.inside.sample(x - 0.7, y);
        let lee = -below / libm::hypotf(below, right).max(1e-6);
        let at = mm.map(|mm| mm / RIM_CHANGES_MM);
        let chance = 2.4 * self.noise.fbm([at[0] + 71.0, at[1]], Fractal { octaves: 2, gain: 0.6 }) as f32;
        let strong = gathers * (RIM[0] + RIM[1] * lee + RIM[2] * chance).clamp(0.0, 2.0);
        let d = d.max(0.0);
        // What gathers comes from behind.
        let behind =
            0.16 * strong.min(0.5) * smoothstep(4.0 * RIM_MM, RIM_MM, d) * smoothstep(0.0, RIM_MM, d);
        1.0 + strong * libm::expf(-d / RIM_MM) - behind
    }
}

/// Where a place is to unevenness: a wash is laid in strokes across the sheet, and is even along them.
fn brushed([x, y]: [f64; 2]) -> [f64; 2] {
    [(BRUSHED[0] * x + BRUSHED[1] * y) / BRUSHED[2], BRUSHED[0] * y - BRUSHED[1] * x]
}

/// The labels of a wash carried on into cells that water reaches, and so many beyond.
fn carried_on(labels: &Raster<u16>, wet: &Raster<bool>, beyond: usize) -> Raster<u16> {
    let (width, height) = (labels.width(), labels.height());
    let mut carried = labels.clone();
    let painted = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let mut queue: VecDeque<(usize, usize, usize)> =
        painted.filter(|&(x, y)| labels.row(y)[x] != BARE).map(|(x, y)| (x, y, beyond)).collect();
    while let Some((x, y, left)) = queue.pop_front() {
        let label = carried.row(y)[x];
        let steps = [(1, 0), (-1, 0), (0, 1), (0, -1)];
        for (dx, dy) in steps {
            let (u, v) = (x as isize + dx, y as isize + dy);
            if !(0..width as isize).contains(&u) || !(0..height as isize).contains(&v) {
                continue;
            }
            let (u, v) = (u as usize, v as usize);
            if carried.row(v)[u] != BARE {
                continue;
            }
            let left = if wet.row(v)[u] { left } else { left.saturating_sub(1) };
            if left > 0 {
                carried.row_mut(v)[u] = label;
                queue.push_back((u, v, left));
            }
        }
    }
    carried
}

/// Where stretches of contours say a length, mm, and how much of it further away; `None` if none says any.
fn field(
    edges: &[&EdgeStretch],
    length: impl Fn(&EdgeStretch) -> f64,
    [width, height]: [usize; 2],
    cells_per_mm: f64,
) -> Option<Raster<f32>> {
    if edges.iter().all(|edge| length(edge) <= 0.0) {
        return None;
    }
    let mut field = Raster::new(width, height, 0.0f32);
    for edge in edges {
        let mm = length(edge);
        if mm <= 0.0 {
            continue;
        }
        let reach = 1.6 * mm + 0.5;
        let segments = edge.path.windows(2).map(|pair| [pair[0], pair[1]]);
        let dot = (edge.path.len() == 1).then(|| [edge.path[0]; 2]);
        for [a, b] in segments.chain(dot) {
            let range = |axis: usize, cells: usize| {
                let (low, high) = (a[axis].min(b[axis]) - reach, a[axis].max(b[axis]) + reach);
                let cell = |mm: f64| (mm * cells_per_mm).clamp(0.0, cells as f64) as usize;
                cell(low)..cell(high + 1.0 / cells_per_mm)
            };
            for y in range(1, height) {
                for x in range(0, width) {
                    let at = [x, y].map(|at| (at as f64 + 0.5) / cells_per_mm);
                    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
                    let square = (dx * dx + dy * dy).max(1e-12);
                    let part = (((at[0] - a[0]) * dx + (at[1] - a[1]) * dy) / square).clamp(0.0, 1.0);
                    let away = libm::hypot(at[0] - a[0] - part * dx, at[1] - a[1] - part * dy);
                    let here = mm as f32 * smoothstep(reach as f32, 0.8 * mm as f32, away as f32);
                    let cell = &mut field.row_mut(y)[x];
                    *cell = cell.max(here);
                }
            }
        }
    }
    Some(field)
}
