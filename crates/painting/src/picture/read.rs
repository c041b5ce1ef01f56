//! Pictures as numbers and as light.

use std::io::{Read, Seek};

use girtin_grid::Raster;
use girtin_optics::LinearRgb;
use image::{DynamicImage, GenericImageView, ImageBuffer, Pixel};
use rayon::prelude::*;

use super::decode::{Decoded, decoded};
use super::light::{Channels, ToLight};
use super::png_head::Encoding;
use super::{PictureError, PictureLimits};

/// A picture as light.
#[derive(Clone, Debug, PartialEq)]
pub struct Photo {
    /// Linear light of sRGB's primaries, 0 to 1, upright.
    pub pixels: Raster<[f32; 3]>,
    /// Columns and rows as the file stores them, before the picture was turned.
    pub stored_size: (u32, u32),
    /// What the user should know: which of several pictures was read, or that colors are a guess.
    pub notes: Vec<String>,
}

/// Reads a picture as gray values from 0 to 1.
///
/// Values are as stored: no gamma, no color profile. Colors become their luma, with the weights of Rec. 709.
/// Transparent pixels lie on white paper. A picture that says how it is to be turned is turned.
///
/// # Errors
/// The format is not read, the file is damaged, or the picture is larger than `limits`.
pub fn read_grey(reader: impl Read + Seek, limits: &PictureLimits) -> Result<Raster<f32>, PictureError> {
    gray(reader, limits, false)
}

/// Reads a mask as [`read_grey`] does, and refuses a picture in color: somebody has taken the wrong file.
///
/// Gray pictures may be stored as color, and a hundredth of one may be colored.
///
/// # Errors
/// As [`read_grey`], or it is a picture in color.
pub fn read_mask(reader: impl Read + Seek, limits: &PictureLimits) -> Result<Raster<f32>, PictureError> {
    gray(reader, limits, true)
}

fn gray(
    reader: impl Read + Seek,
    limits: &PictureLimits,
    is_mask: bool,
) -> Result<Raster<f32>, PictureError> {
    let Decoded { mut picture, are_inks, .. } = decoded(reader, None, limits, size_of::<f32>())?;
    if are_inks {
        picture = unseparated(picture);
    }
    if is_mask {
        refuse_colored(&picture)?;
    }
    match &picture {
        DynamicImage::ImageLuma8(pixels) => grey(pixels, 255.0),
        DynamicImage::ImageLumaA8(pixels) => grey(pixels, 255.0),
        DynamicImage::ImageRgb8(pixels) => grey(pixels, 255.0),
        DynamicImage::ImageRgba8(pixels) => grey(pixels, 255.0),
        DynamicImage::ImageLuma16(pixels) => grey(pixels, 65535.0),
        DynamicImage::ImageLumaA16(pixels) => grey(pixels, 65535.0),
        DynamicImage::ImageRgb16(pixels) => grey(pixels, 65535.0),
        DynamicImage::ImageRgba16(pixels) => grey(pixels, 65535.0),
        DynamicImage::ImageRgb32F(pixels) => grey(pixels, 1.0),
        DynamicImage::ImageRgba32F(pixels) => grey(pixels, 1.0),
        other => Err(unsupported(other)),
    }
}

/// Reads a picture of 8 or 16 bits as light, upright.
///
/// PNG, JPEG, TIFF, WebP, GIF and BMP are read, the first picture of several. A color profile is converted to
/// sRGB, a picture without is sRGB; colors outside of sRGB are cut off. Transparent pixels lie on `paper`. `ending`
/// is what the file's name ends with, without the dot: some cameras' raw files cannot be told from TIFF otherwise.
///
/// # Errors
/// The format is not read, the file is damaged or ends early, or the picture is larger than `limits`.
///
/// # Cost
/// 12 bytes a pixel besides the decoded file; twice the decoded file while a picture is turned.
pub fn read_photo(
    reader: impl Read + Seek,
    ending: Option<&str>,
    limits: &PictureLimits,
    paper: LinearRgb,
) -> Result<Photo, PictureError> {
    let Decoded { picture, are_inks, profile, encoding, size, mut notes } =
        decoded(reader, ending, limits, size_of::<[f32; 3]>())?;
    let told =
        Told { profile: profile.as_deref(), encoding, are_inks, paper: paper.0.map(|light| light as f32) };
    let (pixels, note) = match &picture {
        DynamicImage::ImageLuma8(pixels) => told.light(pixels, 255),
        DynamicImage::ImageLumaA8(pixels) => told.light(pixels, 255),
        DynamicImage::ImageRgb8(pixels) => told.light(pixels, 255),
        DynamicImage::ImageRgba8(pixels) => told.light(pixels, 255),
        DynamicImage::ImageLuma16(pixels) => told.light(pixels, 65535),
        DynamicImage::ImageLumaA16(pixels) => told.light(pixels, 65535),
        DynamicImage::ImageRgb16(pixels) => told.light(pixels, 65535),
        DynamicImage::ImageRgba16(pixels) => told.light(pixels, 65535),
        other => return Err(unsupported(other)),
    };
    notes.extend(note);
    Ok(Photo { pixels, stored_size: size, notes })
}

fn unsupported(picture: &DynamicImage) -> PictureError {
    PictureError::Unsupported(format!("its pixels are {:?}", picture.color()))
}

/// What a file tells of its pixels, and what they lie on.
struct Told<'a> {
    profile: Option<&'a [u8]>,
    encoding: Option<Encoding>,
    are_inks: bool,
    paper: [f32; 3],
}

impl Told<'_> {
    /// Light of pixels with `white` as full scale, and a note if the profile was of no use.
    fn light<P>(
        &self,
        pixels: &ImageBuffer<P, Vec<P::Subpixel>>,
        white: usize,
    ) -> (Raster<[f32; 3]>, Option<String>)
    where
        P: Pixel,
        P::Subpixel: Into<usize> + Sync,
    {
        let channels = match P::CHANNEL_COUNT {
            _ if self.are_inks => Channels::Inks,
            1 | 2 => Channels::Gray,
            _ => Channels::Color,
        };
        let (way, note) = ToLight::of(self.profile, self.encoding.as_ref(), channels, white);
        let pixel = |stored: &[P::Subpixel]| {
            let (stored, alpha) = match *stored {
                [l] => ([l.into(); 4], white),
                [l, a] => ([l.into(); 4], a.into()),
                [r, g, b] => ([r.into(), g.into(), b.into(), 0], white),
                [r, g, b, a] if self.are_inks => ([r, g, b, a].map(Into::into), white),
                [r, g, b, a] => ([r.into(), g.into(), b.into(), 0], a.into()),
                _ => ([0; 4], 0),
            };
            let light = way.light(stored, white);
            if alpha == white {
                return light;
            }
            let alpha = alpha as f32 / white as f32;
            std::array::from_fn(|i| self.paper[i] + alpha * (light[i] - self.paper[i]))
        };
        let (width, height) = (pixels.width() as usize, pixels.height() as usize);
        let channels = usize::from(P::CHANNEL_COUNT);
        let mut raster = Raster::new(width, height, [0.0; 3]);
        let rows = raster.as_mut_slice().par_chunks_mut(width.max(1));
        rows.zip(pixels.as_raw().par_chunks((width * channels).max(1))).for_each(|(light, stored)| {
            for (light, stored) in light.iter_mut().zip(stored.chunks_exact(channels)) {
                *light = pixel(stored);
            }
        });
        (raster, note)
    }
}

/// Least difference of channels that is color, as bytes: less is a tint, or a lossy format's doing.
const COLORED: u8 = 32;

/// # Errors
/// More than a hundredth of the pixels is colored.
fn refuse_colored(picture: &DynamicImage) -> Result<(), PictureError> {
    if !picture.color().has_color() {
        return Ok(());
    }
    let is_colored = |[r, g, b, a]: [u8; 4]| a >= COLORED && r.max(g).max(b) - r.min(g).min(b) >= COLORED;
    let colored = picture.pixels().filter(|(_, _, pixel)| is_colored(pixel.0)).count() as u64;
    let percent = 100 * colored / (u64::from(picture.width()) * u64::from(picture.height())).max(1);
    if percent > 0 { Err(PictureError::Colored { percent }) } else { Ok(()) }
}

/// Colors of four inks as if each took its part of red, green or blue, and black of all.
fn unseparated(picture: DynamicImage) -> DynamicImage {
    let mut picture = picture.into_rgba8();
    for pixel in picture.pixels_mut() {
        let [inks @ .., black] = pixel.0;
        let [r, g, b] = inks.map(|ink| ((u16::from(ink) * u16::from(black) + 127) / 255) as u8);
        pixel.0 = [r, g, b, 255];
    }
    picture.into()
}

/// Weights of red, green and blue in luma, Rec. 709, in 65536ths: exact in sum, so that gray colors stay the gray
/// they are.
const LUMA: [f64; 3] = [13933.0, 46871.0, 4732.0];

/// Pixels with `white` as full scale.
fn grey<P>(pixels: &ImageBuffer<P, Vec<P::Subpixel>>, white: f64) -> Result<Raster<f32>, PictureError>
where
    P: Pixel,
    P::Subpixel: Into<f64>,
{
    let (width, height) = (pixels.width() as usize, pixels.height() as usize);
    let channels = usize::from(P::CHANNEL_COUNT);
    let mut not_finite = None;
    let mut values = pixels.as_raw().chunks_exact(channels);
    let raster = Raster::from_fn(width, height, |x, y| {
        let channel = |at: &P::Subpixel| -> f64 { (*at).into() };
        let (value, alpha) = match values.next().unwrap_or_default() {
            [l] => (channel(l), white),
            [l, a] => (channel(l), channel(a)),
            [r, g, b] => (luma([r, g, b].map(channel)), white),
            [r, g, b, a] => (luma([r, g, b].map(channel)), channel(a)),
            _ => (0.0, 0.0),
        };
        let value = value / white;
        // Not `1 − alpha·(1 − value)`, which rounds opaque values.
        let covered = if alpha == white { value } else { 1.0 - alpha / white * (1.0 - value) };
        if !covered.is_finite() && not_finite.is_none() {
            not_finite = Some(PictureError::NotFinite { x, y });
        }
        // Floating-point pictures may go beyond.
        covered.clamp(0.0, 1.0) as f32
    });
    not_finite.map_or(Ok(raster), Err)
}

fn luma(rgb: [f64; 3]) -> f64 {
    (LUMA[0] * rgb[0] + LUMA[1] * rgb[1] + LUMA[2] * rgb[2]) / 65536.0
}
