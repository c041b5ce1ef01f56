//! A picture into any of the formats that are written.

use std::cell::RefCell;
use std::io::Write;

use girtin_grid::Raster;
use girtin_optics::LinearRgb;
use image::codecs::jpeg::{JpegEncoder, PixelDensity};
use image::codecs::webp::WebPEncoder;
use image::{ExtendedColorType, GenericImageView, ImageEncoder, Rgb};
use png::{BitDepth, ColorType};
use rayon::prelude::*;

use super::meta::{dots_per_inch, sides, srgb_profile};
use super::{PictureMeta, WriteError, png_file, tiff_file};

/// What a picture is written as. All are sRGB and say so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// PNG of 8 bits.
    Png8,
    /// PNG of 16 bits.
    Png16,
    /// JPEG, all of its color kept (4:4:4).
    Jpeg {
        /// 1 to 100.
        quality: u8,
    },
    /// TIFF of 8 bits, deflated.
    Tiff8,
    /// TIFF of 16 bits, deflated.
    Tiff16,
    /// WebP of 8 bits, without loss.
    WebP,
}

impl PictureFormat {
    /// Endings of names that tell a format.
    pub const ENDINGS: [&'static str; 6] = ["png", "jpg", "jpeg", "tif", "tiff", "webp"];

    /// Quality of a JPEG unless another is wanted: grain survives it.
    pub const QUALITY: u8 = 92;

    /// The format that the ending of a name tells, in any case and without the dot; `sixteen` bits where there is a
    /// choice. `None` for other endings, and for 16 bits of a format that has but 8.
    pub fn of_extension(ending: &str, sixteen: bool) -> Option<Self> {
        match (ending.to_ascii_lowercase().as_str(), sixteen) {
            ("png", false) => Some(Self::Png8),
            ("png", true) => Some(Self::Png16),
            ("tif" | "tiff", false) => Some(Self::Tiff8),
            ("tif" | "tiff", true) => Some(Self::Tiff16),
            ("jpg" | "jpeg", false) => Some(Self::Jpeg { quality: Self::QUALITY }),
            ("webp", false) => Some(Self::WebP),
            _ => None,
        }
    }
}

/// A picture whose rows are asked for from top to bottom, as sRGB.
pub trait Rows {
    /// Columns and rows.
    fn size(&self) -> (usize, usize);

    /// Fills in one row of 8 bits.
    fn row_8(&self, y: usize, row: &mut [[u8; 3]]);

    /// Fills in one row of 16 bits.
    fn row_16(&self, y: usize, row: &mut [[u16; 3]]);
}

impl Rows for Raster<[u8; 3]> {
    fn size(&self) -> (usize, usize) {
        (self.width(), self.height())
    }

    fn row_8(&self, y: usize, row: &mut [[u8; 3]]) {
        row.copy_from_slice(self.row(y));
    }

    fn row_16(&self, y: usize, row: &mut [[u16; 3]]) {
        for (deep, pixel) in row.iter_mut().zip(self.row(y)) {
            *deep = pixel.map(|value| u16::from(value) * 257);
        }
    }
}

impl Rows for Raster<[u16; 3]> {
    fn size(&self) -> (usize, usize) {
        (self.width(), self.height())
    }

    fn row_8(&self, y: usize, row: &mut [[u8; 3]]) {
        for (flat, pixel) in row.iter_mut().zip(self.row(y)) {
            *flat = pixel.map(|value| ((u32::from(value) + 128) / 257) as u8);
        }
    }

    fn row_16(&self, y: usize, row: &mut [[u16; 3]]) {
        row.copy_from_slice(self.row(y));
    }
}

/// Light, encoded row by row: 8 bits are those of [`crate::composite::encode`].
impl Rows for Raster<LinearRgb> {
    fn size(&self) -> (usize, usize) {
        (self.width(), self.height())
    }

    fn row_8(&self, y: usize, row: &mut [[u8; 3]]) {
        let light = self.row(y).par_iter();
        row.par_iter_mut().zip(light).for_each(|(pixel, light)| *pixel = light.to_srgb().to_bytes());
    }

    fn row_16(&self, y: usize, row: &mut [[u16; 3]]) {
        let light = self.row(y).par_iter();
        row.par_iter_mut().zip(light).for_each(|(pixel, light)| {
            *pixel = light.to_srgb().0.map(|value| (value.clamp(0.0, 1.0) * 65535.0).round() as u16);
        });
    }
}

/// One row of 8 bits, by itself.
pub(super) fn flat_row(picture: &impl Rows, y: usize) -> Vec<[u8; 3]> {
    let mut row = vec![[0; 3]; picture.size().0];
    picture.row_8(y, &mut row);
    row
}

/// One row of 16 bits, by itself.
pub(super) fn deep_row(picture: &impl Rows, y: usize) -> Vec<[u16; 3]> {
    let mut row = vec![[0; 3]; picture.size().0];
    picture.row_16(y, &mut row);
    row
}

/// Writes a picture; equal pictures give equal bytes.
///
/// # Errors
/// The writer fails; the format cannot hold the size, the resolution or a keyword.
///
/// # Cost
/// PNG and JPEG are written as rows come. The packed file of a TIFF is held in memory, and for WebP the picture
/// once more.
pub fn write_picture(
    writer: impl Write,
    picture: &impl Rows,
    format: PictureFormat,
    meta: &PictureMeta,
) -> Result<(), WriteError> {
    match format {
        PictureFormat::Png8 => {
            let kind = (ColorType::Rgb, BitDepth::Eight);
            png_file::encode(writer, picture.size(), kind, meta, |y, bytes| {
                bytes.extend_from_slice(flat_row(picture, y).as_flattened());
            })
        }
        PictureFormat::Png16 => {
            let kind = (ColorType::Rgb, BitDepth::Sixteen);
            png_file::encode(writer, picture.size(), kind, meta, |y, bytes| {
                let row = deep_row(picture, y);
                bytes.extend(row.as_flattened().iter().flat_map(|value| value.to_be_bytes()));
            })
        }
        PictureFormat::Jpeg { quality } => jpeg(writer, picture, quality, meta),
        PictureFormat::Tiff8 => tiff_file::write(writer, picture, false, meta),
        PictureFormat::Tiff16 => tiff_file::write(writer, picture, true, meta),
        PictureFormat::WebP => webp(writer, picture, meta),
    }
}

fn jpeg(
    mut writer: impl Write,
    picture: &impl Rows,
    quality: u8,
    meta: &PictureMeta,
) -> Result<(), WriteError> {
    let (columns, rows) = sides(picture.size(), "a JPEG", u32::from(u16::MAX))?;
    let mut encoder = JpegEncoder::new_with_quality(&mut writer, quality);
    if let Some(pixels_per_mm) = meta.pixels_per_mm {
        encoder.set_pixel_density(PixelDensity::dpi(dots_per_inch(pixels_per_mm)?.round().max(1.0) as u16));
    }
    let unsupported = |error: image::error::UnsupportedError| WriteError::Encode(error.to_string());
    encoder.set_icc_profile(srgb_profile()?).map_err(unsupported)?;
    if let Some(exif) = meta.exif()? {
        encoder.set_exif_metadata(exif).map_err(unsupported)?;
    }
    let blocks = Blocks { picture, size: (columns, rows), strip: RefCell::new((u32::MAX, Vec::new())) };
    encoder.encode_image(&blocks)?;
    writer.flush().map_err(WriteError::Write)
}

/// Rows of a JPEG's block.
const BLOCK: u32 = 8;

/// A picture that is looked at block by block, with one strip of blocks in memory.
struct Blocks<'a, P> {
    picture: &'a P,
    size: (u32, u32),
    /// Number of the strip, and its pixels.
    strip: RefCell<(u32, Vec<[u8; 3]>)>,
}

impl<P: Rows> GenericImageView for Blocks<'_, P> {
    type Pixel = Rgb<u8>;

    fn dimensions(&self) -> (u32, u32) {
        self.size
    }

    fn get_pixel(&self, x: u32, y: u32) -> Rgb<u8> {
        let mut strip = self.strip.borrow_mut();
        let (held, pixels) = &mut *strip;
        let (width, height) = self.size;
        if *held != y / BLOCK {
            *held = y / BLOCK;
            pixels.clear();
            for y in *held * BLOCK..height.min((*held + 1) * BLOCK) {
                pixels.extend(flat_row(self.picture, y as usize));
            }
        }
        Rgb(pixels[(y % BLOCK * width + x) as usize])
    }
}

fn webp(mut writer: impl Write, picture: &impl Rows, meta: &PictureMeta) -> Result<(), WriteError> {
    let (columns, rows) = sides(picture.size(), "a WebP", 1 << 14)?;
    let mut encoder = WebPEncoder::new_lossless(&mut writer);
    let unsupported = |error: image::error::UnsupportedError| WriteError::Encode(error.to_string());
    encoder.set_icc_profile(srgb_profile()?).map_err(unsupported)?;
    if let Some(exif) = meta.exif()? {
        encoder.set_exif_metadata(exif).map_err(unsupported)?;
    }
    let mut bytes = Vec::with_capacity(picture.size().0 * picture.size().1 * 3);
    for y in 0..picture.size().1 {
        bytes.extend_from_slice(flat_row(picture, y).as_flattened());
    }
    encoder.encode(&bytes, columns, rows, ExtendedColorType::Rgb8)?;
    writer.flush().map_err(WriteError::Write)
}
