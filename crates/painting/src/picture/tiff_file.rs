//! TIFF: strips of rows, deflated.

use std::borrow::Cow;
use std::io::{self, Cursor, Write};
use std::ops::Range;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use tiff::TiffError;
use tiff::encoder::{Rational, TiffEncoder, TiffValue};
use tiff::tags::{CompressionMethod, PhotometricInterpretation, Predictor, ResolutionUnit, Tag, Type};

use super::meta::{dots_per_inch, sides, srgb_profile};
use super::write::{Rows, deep_row, flat_row};
use super::{PictureMeta, WriteError};

impl From<TiffError> for WriteError {
    fn from(error: TiffError) -> Self {
        match error {
            TiffError::IoError(error) => Self::Write(error),
            other => Self::Encode(other.to_string()),
        }
    }
}

/// Bytes of a strip, about.
const STRIP: usize = 1 << 20;

/// Writes a TIFF of 8 or 16 bits.
///
/// # Errors
/// The writer fails; size or resolution is none that a TIFF can hold, or the file grows beyond 4 GB.
///
/// # Cost
/// The packed file is held in memory: a TIFF is not written front to back.
pub(super) fn write(
    mut writer: impl Write,
    picture: &impl Rows,
    is_deep: bool,
    meta: &PictureMeta,
) -> Result<(), WriteError> {
    let (width, height) = picture.size();
    let (columns, rows) = sides((width, height), "a TIFF", i32::MAX as u32)?;
    let mut file = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut file)?;
    let mut tags = encoder.image_directory()?;
    let rows_per_strip = (STRIP / (width * if is_deep { 6 } else { 3 })).clamp(1, height);
    let (mut offsets, mut lengths) = (Vec::new(), Vec::new());
    for top in (0..height).step_by(rows_per_strip) {
        let strip =
            packed(picture, top..(top + rows_per_strip).min(height), is_deep).map_err(WriteError::Write)?;
        let offset = u32::try_from(tags.write_data(strip.as_slice())?);
        offsets.push(offset.map_err(|_| WriteError::Encode("a TIFF ends at 4 GB".to_owned()))?);
        lengths.push(strip.len() as u32);
    }
    tags.write_tag(Tag::ImageWidth, columns)?;
    tags.write_tag(Tag::ImageLength, rows)?;
    tags.write_tag(Tag::BitsPerSample, &[if is_deep { 16u16 } else { 8 }; 3][..])?;
    tags.write_tag(Tag::SamplesPerPixel, 3u16)?;
    tags.write_tag(Tag::PhotometricInterpretation, PhotometricInterpretation::RGB.to_u16())?;
    tags.write_tag(Tag::Compression, CompressionMethod::Deflate.to_u16())?;
    tags.write_tag(Tag::Predictor, Predictor::Horizontal.to_u16())?;
    tags.write_tag(Tag::RowsPerStrip, rows_per_strip as u32)?;
    tags.write_tag(Tag::StripOffsets, offsets.as_slice())?;
    tags.write_tag(Tag::StripByteCounts, lengths.as_slice())?;
    tags.write_tag(Tag::IccProfile, Profile(srgb_profile()?))?;
    if let Some(pixels_per_mm) = meta.pixels_per_mm {
        let dots = (dots_per_inch(pixels_per_mm)? * 1000.0).round() as u32;
        tags.write_tag(Tag::XResolution, Rational { n: dots, d: 1000 })?;
        tags.write_tag(Tag::YResolution, Rational { n: dots, d: 1000 })?;
        tags.write_tag(Tag::ResolutionUnit, ResolutionUnit::Inch.to_u16())?;
    }
    if let Some(software) = meta.software() {
        tags.write_tag(Tag::Software, Text::of(software))?;
    }
    if let Some(lines) = meta.lines() {
        tags.write_tag(Tag::ImageDescription, Text::of(&lines))?;
    }
    tags.finish()?;
    writer.write_all(file.get_ref()).and_then(|()| writer.flush()).map_err(WriteError::Write)
}

/// Rows as differences of neighbors, in the byte order of the machine as the encoder's header says, deflated.
fn packed(picture: &impl Rows, rows: Range<usize>, is_deep: bool) -> io::Result<Vec<u8>> {
    let mut strip = ZlibEncoder::new(Vec::new(), Compression::new(6));
    for y in rows {
        if is_deep {
            let steps = steps(&deep_row(picture, y), |value, before: u16| value.wrapping_sub(before));
            let bytes: Vec<u8> = steps.as_flattened().iter().flat_map(|step| step.to_ne_bytes()).collect();
            strip.write_all(&bytes)?;
        } else {
            let steps = steps(&flat_row(picture, y), |value, before: u8| value.wrapping_sub(before));
            strip.write_all(steps.as_flattened())?;
        }
    }
    strip.finish()
}

/// What each pixel is more than the one before it.
fn steps<T: Copy + Default>(row: &[[T; 3]], step: impl Fn(T, T) -> T) -> Vec<[T; 3]> {
    let mut before = [T::default(); 3];
    row.iter()
        .map(|pixel| {
            let steps = std::array::from_fn(|i| step(pixel[i], before[i]));
            before = *pixel;
            steps
        })
        .collect()
}

/// A text with a zero byte at its end, and none before. UTF-8, though TIFF knows ASCII only.
struct Text(Vec<u8>);

impl Text {
    fn of(text: &str) -> Self {
        let mut bytes = text.replace('\0', " ").into_bytes();
        bytes.push(0);
        Self(bytes)
    }
}

impl TiffValue for Text {
    const BYTE_LEN: u8 = 1;
    const FIELD_TYPE: Type = Type::ASCII;

    fn count(&self) -> usize {
        self.0.len()
    }

    fn data(&self) -> Cow<'_, [u8]> {
        Cow::Borrowed(&self.0)
    }
}

/// A color profile, bytes that mean nothing to TIFF.
struct Profile(Vec<u8>);

impl TiffValue for Profile {
    const BYTE_LEN: u8 = 1;
    const FIELD_TYPE: Type = Type::UNDEFINED;

    fn count(&self) -> usize {
        self.0.len()
    }

    fn data(&self) -> Cow<'_, [u8]> {
        Cow::Borrowed(&self.0)
    }
}
