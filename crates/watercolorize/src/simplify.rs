//! Fewer details where nobody looks, edges kept.

use girtin_grid::Raster;
use girtin_grid::resize::resized;
use rayon::prelude::*;

/// Reach of the mean shift, a part of the long edge, and the step of color it goes over, Lab.
const REACH: f64 = 0.012;
const SHIFT_STEP: f32 = 4.0;
/// Rounds of the mean shift; and how little it moves when it has arrived, cells and Lab together, squared.
const ROUNDS: usize = 4;
const ARRIVED: f32 = 0.3;
/// Cells that are summed side by side.
const LANES: usize = 8;

/// The medians: where little is drawn, and the wider one where nobody looks; radii, parts of the long edge.
const MEDIAN: f64 = 0.004;
const WIDE_MEDIAN: f64 = 0.008;

/// The bilateral filter at the focus: radius in cells, its spread as part of the long edge and in Lab.
const BILATERAL: isize = 3;
const BILATERAL_SPREAD: f64 = 0.003;
const BILATERAL_STEP: f32 = 4.0;

/// How simple foliage is painted less than other things, of two levels.
const FOLIAGE: f32 = 0.9;

/// The Lab photograph in flat colors, on half as many cells each way, by mean shift.
///
/// # Source
/// Comaniciu and Meer, *Mean Shift: A Robust Approach Toward Feature Space Analysis*, 2002.
pub fn flattened(lab: &Raster<[f32; 3]>, long_edge: f64) -> Raster<[f32; 3]> {
    let half = resized(lab, lab.width().div_ceil(2), lab.height().div_ceil(2));
    shifted(&half, libm::round(REACH * long_edge / 2.0).max(1.0) as usize)
}

/// The photograph simplified: nearly as it is where `attention` is, in flat shapes elsewhere, the flatter the less it is
/// looked at; `flat` is its [`flattened`].
pub fn simplified(
    lab: &Raster<[f32; 3]>,
    flat: &Raster<[f32; 3]>,
    attention: &Raster<f32>,
    foliage: &Raster<f32>,
    long_edge: f64,
) -> Raster<[f32; 3]> {
    let (width, height) = (lab.width(), lab.height());
    // On half as many cells.
    let radius = |part: f64| libm::round(part * long_edge / 2.0).max(1.0) as usize;
    let middle = median(flat, radius(MEDIAN));
    let far = median(&median(&middle, radius(WIDE_MEDIAN)), radius(WIDE_MEDIAN));
    let level = Raster::by_rows(width, height, |x, y| {
        ((1.0 - attention.at(x, y)) * (2.0 - FOLIAGE * foliage.at(x, y))).clamp(0.0, 2.0)
    });
    let once = bilateral(lab, &level, long_edge);
    let fine = bilateral(&once, &level, long_edge);
    Raster::by_rows(width, height, |x, y| {
        let level = level.at(x, y);
        let guide = once.at(x, y);
        let likest = |coarse: &Raster<[f32; 3]>| likest(coarse, x, y, guide);
        let mix = |a: [f32; 3], b: [f32; 3], part: f32| [0, 1, 2].map(|c: usize| a[c] + part * (b[c] - a[c]));
        if level < 1.0 {
            mix(fine.at(x, y), likest(&middle), level)
        } else {
            mix(likest(&middle), likest(&far), level - 1.0)
        }
    })
}

/// The color of half as many cells that is most like the photograph's, of the four around a cell: edges stay where the
/// photograph has them, and between colors there are none.
fn likest(coarse: &Raster<[f32; 3]>, x: usize, y: usize, guide: [f32; 3]) -> [f32; 3] {
    let near = |at: usize, count: usize| {
        let first = at.div_ceil(2);
        [first.saturating_sub(1).min(count - 1), first.min(count - 1)]
    };
    let (columns, rows) = (near(x, coarse.width()), near(y, coarse.height()));
    let mut best = (f32::INFINITY, guide);
    for y in rows {
        for x in columns {
            let color = coarse.at(x, y);
            let apart = square(color, guide);
            if apart < best.0 {
                best = (apart, color);
            }
        }
    }
    best.1
}

fn square(a: [f32; 3], b: [f32; 3]) -> f32 {
    let [l, u, v] = [0, 1, 2].map(|c: usize| a[c] - b[c]);
    l * l + u * u + v * v
}

/// Mean shift: each cell goes to where cells around it of like color are many, and takes their color.
fn shifted(lab: &Raster<[f32; 3]>, radius: usize) -> Raster<[f32; 3]> {
    let (width, height) = (lab.width(), lab.height());
    // A plane for each channel, the border continued, so that a window is rows of whole numbers of cells.
    let wide = width + 2 * radius + LANES;
    let planes: [Vec<f32>; 3] = [0, 1, 2].map(|c: usize| {
        let row = |y: usize| lab.row(y.saturating_sub(radius).min(height - 1));
        let padded = |y: usize| {
            (0..wide).map(move |x| row(y)[x.saturating_sub(radius).min(width - 1)][c]).collect::<Vec<_>>()
        };
        (0..height + 2 * radius).flat_map(padded).collect()
    });
    // Windows in whole lanes; what is beyond them does not count.
    let window = (2 * radius + 1).next_multiple_of(LANES);
    let places: Vec<f32> = (0..window).map(|k| k as f32 - radius as f32).collect();
    let counts: Vec<f32> = (0..window).map(|k| f32::from(u8::from(k <= 2 * radius))).collect();
    Raster::by_rows(width, height, |x, y| {
        let (mut color, mut at) = (lab.at(x, y), [x, y]);
        for _ in 0..ROUNDS {
            // Sums in lanes are made in one order on every machine.
            let mut sums = [[0.0f32; LANES]; 6];
            for row in 0..=2 * radius {
                let start = (at[1] + row) * wide + at[0];
                let [l, a, b] =
                    [0, 1, 2].map(|c: usize| planes[c][start..start + window].chunks_exact(LANES));
                let down = places[row];
                let masks = counts.chunks_exact(LANES).zip(places.chunks_exact(LANES));
                for (((l, a), b), (counts, places)) in l.zip(a).zip(b).zip(masks) {
                    for k in 0..LANES {
                        let (dl, da, db) = (l[k] - color[0], a[k] - color[1], b[k] - color[2]);
                        let near = dl * dl + da * da + db * db <= SHIFT_STEP * SHIFT_STEP;
                        let weight = if near { counts[k] } else { 0.0 };
                        sums[0][k] += weight;
                        sums[1][k] += weight * l[k];
                        sums[2][k] += weight * a[k];
                        sums[3][k] += weight * b[k];
                        sums[4][k] += weight * places[k];
                        sums[5][k] += weight * down;
                    }
                }
            }
            let [count, l, a, b, dx, dy] = sums.map(|lanes| lanes.iter().sum::<f32>());
            if count < 1.0 {
                break;
            }
            let next = [l / count, a / count, b / count];
            let (dx, dy) = (libm::roundf(dx / count), libm::roundf(dy / count));
            let moved = dx * dx + dy * dy + square(next, color);
            color = next;
            at[0] = at[0].saturating_add_signed(dx as isize).min(width - 1);
            at[1] = at[1].saturating_add_signed(dy as isize).min(height - 1);
            if moved < ARRIVED {
                break;
            }
        }
        color
    })
}

/// Values that are told apart by the median.
const LEVELS: usize = 512;

/// The median of each channel over a square.
///
/// # Source
/// Huang, Yang, Tang, *A Fast Two-Dimensional Median Filtering Algorithm*, 1979.
fn median(lab: &Raster<[f32; 3]>, radius: usize) -> Raster<[f32; 3]> {
    let (width, height) = (lab.width(), lab.height());
    if width == 0 || height == 0 {
        return lab.clone();
    }
    // L of 0 to 100, a and b of −128 to 128.
    let scale = [(0.0, LEVELS as f32 / 101.0), (-128.0, 2.0), (-128.0, 2.0)];
    let levels = lab.map(|color| {
        [0, 1, 2].map(|c: usize| {
            let (least, per_unit) = scale[c];
            (((color[c] - least) * per_unit) as usize).min(LEVELS - 1) as u16
        })
    });
    let mut medians = Raster::new(width, height, [0.0f32; 3]);
    medians.as_mut_slice().par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        let rows: Vec<&[[u16; 3]]> = (y + height..=y + height + 2 * radius)
            .map(|row| levels.row(row.saturating_sub(height + radius).min(height - 1)))
            .collect();
        let column = |x: isize| x.clamp(0, width as isize - 1) as usize;
        let half = (2 * radius + 1) * (2 * radius + 1) / 2;
        for (c, (least, per_unit)) in scale.into_iter().enumerate() {
            let mut counts = [0u16; LEVELS];
            for x in -(radius as isize)..=radius as isize {
                rows.iter().for_each(|row| counts[row[column(x)][c] as usize] += 1);
            }
            // `below` values are less than `middle`.
            let (mut middle, mut below) = (0usize, 0usize);
            for (x, out) in out.iter_mut().enumerate() {
                while below > half {
                    middle -= 1;
                    below -= counts[middle] as usize;
                }
                while below + counts[middle] as usize <= half {
                    below += counts[middle] as usize;
                    middle += 1;
                }
                out[c] = least + (middle as f32 + 0.5) / per_unit;
                let (gone, come) =
                    (column(x as isize - radius as isize), column(x as isize + 1 + radius as isize));
                for row in &rows {
                    let (gone, come) = (row[gone][c] as usize, row[come][c] as usize);
                    counts[gone] -= 1;
                    counts[come] += 1;
                    below -= usize::from(gone < middle);
                    below += usize::from(come < middle);
                }
            }
        }
    });
    medians
}

/// Level of simplification from which on nothing of the bilateral filter is seen but where edges run.
const NOT_SEEN: f32 = 1.0;

/// Weights of the bilateral filter: steps of color in so many parts, up to so many spreads squared.
const WEIGHTS: usize = 256;
const FARTHEST: f32 = 9.0;

/// Averages of cells of like color, where they are seen.
fn bilateral(lab: &Raster<[f32; 3]>, level: &Raster<f32>, long_edge: f64) -> Raster<[f32; 3]> {
    let (width, height) = (lab.width(), lab.height());
    let spread = BILATERAL_SPREAD * long_edge;
    let mut taps = Vec::new();
    for dy in -BILATERAL..=BILATERAL {
        for dx in -BILATERAL..=BILATERAL {
            let apart = (dx * dx + dy * dy) as f64;
            if apart <= (BILATERAL * BILATERAL) as f64 {
                taps.push((dx, dy, libm::exp(-apart / (2.0 * spread * spread)) as f32));
            }
        }
    }
    let by_step: Vec<f32> = (0..=WEIGHTS)
        .map(|k| if k == WEIGHTS { 0.0 } else { libm::expf(-0.5 * FARTHEST * k as f32 / WEIGHTS as f32) })
        .collect();
    let per_square = WEIGHTS as f32 / (FARTHEST * BILATERAL_STEP * BILATERAL_STEP);
    Raster::by_rows(width, height, |x, y| {
        let own = lab.at(x, y);
        if level.at(x, y) >= NOT_SEEN {
            return own;
        }
        let (mut all, mut sum) = (0.0f32, [0.0f32; 3]);
        for &(dx, dy, near) in &taps {
            let x = (x as isize + dx).clamp(0, width as isize - 1) as usize;
            let y = (y as isize + dy).clamp(0, height as isize - 1) as usize;
            let color = lab.row(y)[x];
            let weight = near * by_step[((square(color, own) * per_square) as usize).min(WEIGHTS)];
            all += weight;
            sum.iter_mut().zip(color).for_each(|(sum, value)| *sum += weight * value);
        }
        sum.map(|sum| sum / all)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noisy(width: usize, height: usize) -> Raster<[f32; 3]> {
        Raster::from_fn(width, height, |x, y| {
            let noise = ((x * 7919 + y * 104_729) % 13) as f32 / 4.0 - 1.5;
            [if x < width / 2 { 30.0 } else { 75.0 } + noise, noise, 0.0]
        })
    }

    fn simple(lab: &Raster<[f32; 3]>, attention: f32) -> Raster<[f32; 3]> {
        let plane = |value: f32| Raster::new(lab.width(), lab.height(), value);
        simplified(lab, &flattened(lab, 400.0), &plane(attention), &plane(0.0), 400.0)
    }

    #[test]
    fn noise_goes_and_the_edge_stays() {
        let lab = noisy(120, 80);
        for attention in [0.0, 0.5, 1.0] {
            let calm = simple(&lab, attention);
            for y in 5..75 {
                assert!((calm.at(59, y)[0] - 30.0).abs() < 2.5, "{attention}: {:?}", calm.at(59, y));
                assert!((calm.at(60, y)[0] - 75.0).abs() < 2.5, "{attention}: {:?}", calm.at(60, y));
            }
        }
    }

    #[test]
    fn a_speck_stays_where_the_eye_rests() {
        let lab = Raster::from_fn(120, 80, |x, y| {
            [if x.abs_diff(60) < 2 && y.abs_diff(40) < 2 { 20.0 } else { 80.0 }, 0.0, 0.0]
        });
        assert!(simple(&lab, 1.0).at(60, 40)[0] < 40.0);
        assert!(simple(&lab, 0.0).at(60, 40)[0] > 70.0);
    }

    #[test]
    fn any_size_is_simplified() {
        for (width, height) in [(1, 1), (1, 7), (9, 2), (33, 17)] {
            let lab = Raster::new(width, height, [50.0, 10.0, -10.0]);
            for color in simple(&lab, 0.3).as_slice() {
                assert!(square(*color, [50.0, 10.0, -10.0]) < 0.5, "{color:?}");
            }
        }
    }
}
