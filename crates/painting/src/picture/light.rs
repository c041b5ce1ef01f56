//! Stored values become light: sRGB, or through a color profile.
//!
//! Curves and matrices of a profile are evaluated here, in the order of ICC.1; tables of colors are sampled through
//! moxcms at their nodes and interpolated here, since its own interpolation depends on the processor.

use girtin_optics::color::decode_srgb;
use moxcms::{
    Chromaticity, CmsError, ColorPrimaries, ColorProfile, DataColorSpace, Layout, Matrix3d, ToneReprCurve,
    TransformOptions,
};

use super::decode::INKS;
use super::png_head::Encoding;

/// A way from stored values, 0 to 1, to linear sRGB.
pub(super) enum ToLight {
    /// A table for each channel, then a matrix unless they are sRGB's already.
    Curves { curves: [Vec<f32>; 3], matrix: Option<[[f32; 3]; 3]> },
    /// A table of colors for three channels or four.
    Grid(Grid),
    /// Four inks of which nothing is known: each takes its part of red, green or blue, and black of all.
    Inks { curve: Vec<f32> },
}

/// What the channels of a picture mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Channels {
    Gray,
    Color,
    Inks,
}

/// Entries of the table with which encoded values of the grid are decoded.
const DECODED: usize = 4096;

impl ToLight {
    /// The way for a picture of values from 0 to `white`, and a note if the profile was of no use.
    pub(super) fn of(
        profile: Option<&[u8]>,
        encoding: Option<&Encoding>,
        channels: Channels,
        white: usize,
    ) -> (Self, Option<String>) {
        let fallback = || match channels {
            Channels::Inks => Self::Inks { curve: table(white, |value| decode_srgb(value) as f32) },
            Channels::Gray | Channels::Color => {
                encoding.map_or_else(|| Self::srgb(white), |encoding| Self::encoded(encoding, white))
            }
        };
        let Some(profile) = profile else {
            return (fallback(), (channels == Channels::Inks).then(|| INKS.to_owned()));
        };
        match Self::through(profile, channels, white) {
            Ok(way) => (way, None),
            Err(why) if channels == Channels::Inks => (fallback(), Some(format!("{why}; {INKS}"))),
            Err(why) => (fallback(), Some(format!("{why}, so the picture is taken for sRGB"))),
        }
    }

    fn srgb(white: usize) -> Self {
        let curve = table(white, |value| decode_srgb(value) as f32);
        Self::Curves { curves: [curve.clone(), curve.clone(), curve], matrix: None }
    }

    /// Through the numbers that a file gives. Numbers that make no sense count for nothing.
    fn encoded(encoding: &Encoding, white: usize) -> Self {
        // Most who write 1/2.2 mean sRGB, whose curve it is about.
        let gamma =
            encoding.gamma.filter(|gamma| (0.1..=10.0).contains(gamma) && (gamma * 2.2 - 1.0).abs() > 0.01);
        let curve = table(white, |value| match gamma {
            Some(gamma) => libm::pow(value, 1.0 / gamma) as f32,
            None => decode_srgb(value) as f32,
        });
        let matrix = encoding.primaries.filter(are_colors).and_then(|primaries| {
            let [white, red, green, blue] = primaries.map(|[x, y]| Chromaticity::new(x as f32, y as f32));
            let mut profile = ColorProfile::new_srgb();
            profile.update_rgb_colorimetry(white.to_xyyb(), ColorPrimaries { red, green, blue });
            white_kept(&profile.transform_matrix(&ColorProfile::new_srgb()))
        });
        Self::Curves {
            curves: [curve.clone(), curve.clone(), curve],
            matrix: matrix.filter(|rows| !is_unit(rows)),
        }
    }

    fn through(profile: &[u8], channels: Channels, white: usize) -> Result<Self, String> {
        let damaged = |_: CmsError| "the color profile is damaged".to_owned();
        let profile = ColorProfile::new_from_slice(profile).map_err(damaged)?;
        let has_table = profile.lut_a_to_b_perceptual.is_some() || profile.lut_a_to_b_colorimetric.is_some();
        match (profile.color_space, channels) {
            (DataColorSpace::Gray, Channels::Gray) => {
                let curve = curve(profile.gray_trc.as_ref(), white).map_err(damaged)?;
                Ok(Self::Curves { curves: [curve.clone(), curve.clone(), curve], matrix: None })
            }
            (DataColorSpace::Rgb, Channels::Gray | Channels::Color)
                if !has_table && profile.is_matrix_shaper() =>
            {
                Self::of_curves(&profile, white).map_err(damaged)
            }
            (DataColorSpace::Rgb, Channels::Gray | Channels::Color) if has_table => {
                Grid::sampled(&profile, 3).map(Self::Grid).map_err(damaged)
            }
            (DataColorSpace::Cmyk, Channels::Inks) if has_table => {
                Grid::sampled(&profile, 4).map(Self::Grid).map_err(damaged)
            }
            (space, _) => Err(format!("the color profile is of {space:?}, which the picture is not")),
        }
    }

    fn of_curves(profile: &ColorProfile, white: usize) -> Result<Self, CmsError> {
        let curves = [&profile.red_trc, &profile.green_trc, &profile.blue_trc];
        let [red, green, blue] = curves.map(|trc| curve(trc.as_ref(), white));
        let curves = [red?, green?, blue?];
        let matrix = profile.transform_matrix(&ColorProfile::new_srgb());
        let rows = white_kept(&matrix).ok_or(CmsError::InvalidProfile)?;
        // Most profiles are sRGB's own, and then a picture with it is the picture without.
        let srgb = table(white, |value| decode_srgb(value) as f32);
        let is_near = |a: f32, b: f32| (a - b).abs() < NEAR;
        let is_srgb =
            curves.iter().flatten().zip(srgb.iter().cycle()).all(|(&a, &b)| is_near(a, b)) && is_unit(&rows);
        Ok(if is_srgb { Self::srgb(white) } else { Self::Curves { curves, matrix: Some(rows) } })
    }

    /// Linear sRGB of one pixel, from 0 to 1: what lies outside is cut off.
    pub(super) fn light(&self, stored: [usize; 4], white: usize) -> [f32; 3] {
        match self {
            Self::Curves { curves, matrix } => {
                let linear = [0, 1, 2].map(|i| curves[i][stored[i]]);
                let Some(rows) = matrix else { return linear };
                rows.map(|[r, g, b]| within_unit(r * linear[0] + g * linear[1] + b * linear[2]))
            }
            Self::Grid(grid) => grid.light(stored.map(|value| value as f32 / white as f32)),
            Self::Inks { curve } => {
                let [inks @ .., black] = stored;
                inks.map(|ink| curve[(ink * black + white / 2) / white])
            }
        }
    }
}

/// Whether white, red, green and blue are colors, and the last three not on one line.
fn are_colors(primaries: &[[f64; 2]; 4]) -> bool {
    let [_, [rx, ry], [gx, gy], [bx, by]] = *primaries;
    let area = (gx - rx) * (by - ry) - (bx - rx) * (gy - ry);
    primaries.iter().all(|[_, y]| *y > 0.0) && area.abs() > 0.01
}

/// Whether colors stay what they are.
fn is_unit(rows: &[[f32; 3]; 3]) -> bool {
    (0..9).all(|i| (rows[i / 3][i % 3] - f32::from(u8::from(i / 3 == i % 3))).abs() < NEAR)
}

/// Least difference of light or of a matrix's number that matters: half a level of 8 bits in middle gray.
const NEAR: f32 = 2e-3;

fn table(white: usize, value: impl Fn(f64) -> f32) -> Vec<f32> {
    (0..=white).map(|stored| value(stored as f64 / white as f64)).collect()
}

fn curve(trc: Option<&ToneReprCurve>, white: usize) -> Result<Vec<f32>, CmsError> {
    let curve = trc.ok_or(CmsError::BuildTransferFunction)?.make_linear_evaluator()?;
    Ok(table(white, |value| within_unit(curve.evaluate_value(value as f32))))
}

/// The nearest from 0 to 1; 0 for what is no number, as damaged profiles make it.
fn within_unit(value: f32) -> f32 {
    if value > 0.0 { value.min(1.0) } else { 0.0 }
}

/// The rows of a matrix, each with sum 1: profiles round, and white is to stay white.
fn white_kept(matrix: &Matrix3d) -> Option<[[f32; 3]; 3]> {
    let sums = matrix.v.map(|row| row.iter().sum::<f64>());
    let is_white = sums.iter().all(|sum| (sum - 1.0).abs() < 0.05);
    let mut sums = sums.into_iter();
    is_white.then(|| {
        matrix.v.map(|row| {
            let sum = sums.next().unwrap_or(1.0);
            row.map(|value| (value / sum) as f32)
        })
    })
}

/// Colors at the nodes of a grid over three or four channels, sRGB encoded.
pub(super) struct Grid {
    channels: usize,
    nodes: usize,
    colors: Vec<[f32; 3]>,
    decoded: Vec<f32>,
}

impl Grid {
    /// As many nodes as moxcms has itself, so that it interpolates nothing.
    fn sampled(profile: &ColorProfile, channels: usize) -> Result<Self, CmsError> {
        let (nodes, layout) = if channels == 4 { (17usize, Layout::Rgba) } else { (33, Layout::Rgb) };
        let transform = profile.create_transform_f32(
            layout,
            &ColorProfile::new_srgb(),
            Layout::Rgb,
            TransformOptions::default(),
        )?;
        let count = nodes.pow(channels as u32);
        // The first channel varies slowest.
        let at = |node: usize, channel: usize| {
            let digit = node / nodes.pow((channels - 1 - channel) as u32) % nodes;
            digit as f32 / (nodes - 1) as f32
        };
        let stored: Vec<f32> =
            (0..count).flat_map(|node| (0..channels).map(move |channel| at(node, channel))).collect();
        let mut colors = vec![[0.0f32; 3]; count];
        transform.transform(&stored, colors.as_flattened_mut())?;
        for value in colors.as_flattened_mut() {
            // To 16 bits: the last bit of a float may differ between processors.
            *value = (within_unit(*value) * 65535.0).round() / 65535.0;
        }
        let decoded = table(DECODED, |value| decode_srgb(value) as f32);
        Ok(Self { channels, nodes, colors, decoded })
    }

    fn light(&self, values: [f32; 4]) -> [f32; 3] {
        let last = (self.nodes - 1) as f32;
        let mut corners = [(0usize, 1.0f32); 16];
        let mut count = 1;
        for &value in &values[..self.channels] {
            // Inks are stored as their complement, profiles count them.
            let value = if self.channels == 4 { 1.0 - value } else { value };
            let below = (value * last).floor().min(last - 1.0);
            let part = value * last - below;
            for i in 0..count {
                let (node, weight) = corners[i];
                let node = node * self.nodes + below as usize;
                corners[i] = (node, weight * (1.0 - part));
                corners[i + count] = (node + 1, weight * part);
            }
            count *= 2;
        }
        let mut encoded = [0.0f32; 3];
        for &(node, weight) in &corners[..count] {
            for (sum, color) in encoded.iter_mut().zip(self.colors[node]) {
                *sum += weight * color;
            }
        }
        encoded.map(|value| {
            let at = value.clamp(0.0, 1.0) * DECODED as f32;
            let below = (at as usize).min(DECODED - 1);
            let part = at - below as f32;
            self.decoded[below] + part * (self.decoded[below + 1] - self.decoded[below])
        })
    }
}
