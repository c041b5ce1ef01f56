//! Regions of a reduced picture become mattes of the whole one, with edges that follow its colors.

use girtin_grid::Raster;
use girtin_optics::LinearRgb;
use rayon::prelude::*;

use super::lab_pixel;
use crate::superpixels::LabPixel;

/// How far a pixel looks for regions, pixels of the reduced picture.
const REACH: f64 = 1.5;

/// The picture with its long edge at most that long: means of light over what each pixel covers.
pub(super) fn reduced(picture: &Raster<LinearRgb>, long_edge: usize) -> Raster<LinearRgb> {
    let (width, height) = (picture.width(), picture.height());
    let longest = width.max(height);
    if longest <= long_edge {
        return picture.clone();
    }
    let shrunk = |side: usize| (side * long_edge).div_ceil(longest).max(1);
    let (columns, rows) = (shrunk(width), shrunk(height));
    let mut small = Raster::new(columns, rows, LinearRgb::BLACK);
    small.as_mut_slice().par_chunks_mut(columns).enumerate().for_each(|(row, out)| {
        for (column, out) in out.iter_mut().enumerate() {
            let span = |at: usize, of: usize, cells: usize| at * cells / of..((at + 1) * cells / of);
            let (xs, ys) = (span(column, columns, width), span(row, rows, height));
            let weight = 1.0 / (xs.len() * ys.len()) as f64;
            let mut sum = [0.0; 3];
            for y in ys {
                for color in &picture.row(y)[xs.clone()] {
                    sum.iter_mut().zip(color.0).for_each(|(sum, channel)| *sum += channel);
                }
            }
            *out = LinearRgb(sum.map(|sum| sum * weight));
        }
    });
    small
}

/// How much of each pixel a region covers.
///
/// Where all the reduced picture around a pixel is of one region, so is the pixel; elsewhere each of the pixels around votes
/// for its region, the more the nearer it is in place and color.
///
/// # Source
/// Kopf, Cohen, Lischinski, Uyttendaele, *Joint Bilateral Upsampling*, 2007, with a tent instead of a Gaussian of place, so
/// that nothing jumps where the window moves on.
///
/// # Guarantees
/// Over all regions the sum is 1 to rounding (`mattes_add_up_to_one`).
pub(super) fn coverage(
    picture: &Raster<LinearRgb>,
    colors: &Raster<LabPixel>,
    regions: &Raster<u32>,
    region: u32,
    edge_color: f64,
) -> Raster<f32> {
    let (width, height) = (picture.width(), picture.height());
    let mut matte = Raster::new(width, height, 0.0f32);
    if width == 0 || height == 0 {
        return matte;
    }
    let narrowness = 1.0 / (2.0 * edge_color * edge_color);
    matte.as_mut_slice().par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        let v = (y as f64 + 0.5) * regions.height() as f64 / height as f64;
        let rows = around(v, regions.height());
        for (x, out) in out.iter_mut().enumerate() {
            let u = (x as f64 + 0.5) * regions.width() as f64 / width as f64;
            let columns = around(u, regions.width());
            let mut found = rows.clone().flat_map(|row| &regions.row(row)[columns.clone()]);
            if found.clone().all(|&found| found != region) {
                continue;
            }
            if found.all(|&found| found == region) {
                *out = 1.0;
                continue;
            }
            let color = lab_pixel(picture.at(x, y));
            let (mut ours, mut all) = (0.0, 0.0);
            for row in rows.clone() {
                for column in columns.clone() {
                    let square: f32 =
                        colors.at(column, row).iter().zip(color).map(|(a, b)| (a - b) * (a - b)).sum();
                    // Above 0 for any color: a pixel unlike all around it goes by place.
                    let alike = libm::exp(-f64::from(square) * narrowness) + 1e-6;
                    let vote = tent(column, u) * tent(row, v) * alike;
                    all += vote;
                    if regions.at(column, row) == region {
                        ours += vote;
                    }
                }
            }
            *out = (ours / all) as f32;
        }
    });
    matte
}

/// Pixels with a say at a place, of so many.
fn around(place: f64, cells: usize) -> std::ops::Range<usize> {
    let first = (place - 0.5 - REACH).floor().max(-1.0) as isize + 1;
    let first = (first.max(0) as usize).min(cells - 1);
    let end = ((place - 0.5 + REACH).ceil().max(0.0) as usize).clamp(first + 1, cells);
    first..end
}

/// Weight of a pixel at a place; above 0 for those around it.
fn tent(pixel: usize, place: f64) -> f64 {
    (1.0 - (pixel as f64 + 0.5 - place).abs() / REACH).max(1e-9)
}
