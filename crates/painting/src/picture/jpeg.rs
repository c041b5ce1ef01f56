//! JPEG: upright is for the caller; inks stay inks.

use std::io::Read;

use image::DynamicImage;
use image::metadata::Orientation;
use zune_jpeg::JpegDecoder;
use zune_jpeg::errors::DecodeErrors;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::decode::{Decoded, one_line, plain, roomy};
use super::{PictureError, PictureLimits};

/// Decodes a JPEG of gray, color or four inks.
///
/// A file whose data end early or are damaged is refused: the decoder would fill up with gray.
///
/// # Errors
/// The file is damaged, too large, or of a kind that is not read (lossless, arithmetic, 12 bits).
pub(super) fn decode(
    reader: impl Read,
    limits: &PictureLimits,
    value_bytes: usize,
) -> Result<Decoded, PictureError> {
    let mut bytes = Vec::new();
    let most = limits.decoder_bytes;
    reader.take(most.saturating_add(1)).read_to_end(&mut bytes).map_err(PictureError::Read)?;
    if bytes.len() as u64 > most {
        return Err(PictureError::Memory { most });
    }
    let options =
        DecoderOptions::default().set_strict_mode(false).set_max_width(usize::MAX).set_max_height(usize::MAX);
    refuse_large(&bytes, limits)?;
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes.as_slice()), options);
    decoder.decode_headers().map_err(fault)?;
    let (Some((width, height)), Some(stored)) = (decoder.dimensions(), decoder.input_colorspace()) else {
        return Err(PictureError::Damaged("it has no header".to_owned()));
    };
    let (space, channels) = match stored {
        ColorSpace::Luma => (ColorSpace::Luma, 1),
        ColorSpace::CMYK | ColorSpace::YCCK => (stored, 4),
        _ => (ColorSpace::RGB, 3),
    };
    let size = (width as u32, height as u32);
    // Progressive files are gathered as 16-bit coefficients before they become pixels.
    let is_progressive = decoder.info().is_some_and(|info| info.sof.is_progressive());
    let sample_bytes = if is_progressive { 3 } else { 1 };
    let decoding = bytes.len() as u64 + sample_bytes * (channels * width * height) as u64;
    roomy(size, limits, decoding, value_bytes)?;
    if !is_complete(&bytes) {
        return Err(PictureError::Truncated);
    }
    decoder.set_options(options.jpeg_set_out_colorspace(space).set_strict_mode(true));
    let mut pixels = vec![0; width * height * channels];
    decoder.decode_into(&mut pixels).map_err(fault)?;
    let orientation = decoder.exif().and_then(|exif| Orientation::from_exif_chunk(exif));
    let profile = decoder.icc_profile();
    drop(decoder);
    drop(bytes);
    if stored == ColorSpace::YCCK {
        pixels.as_chunks_mut().0.iter_mut().for_each(separate);
    }
    let (width, height) = size;
    let picture = match channels {
        1 => image::GrayImage::from_raw(width, height, pixels).map(DynamicImage::from),
        3 => image::RgbImage::from_raw(width, height, pixels).map(DynamicImage::from),
        _ => image::RgbaImage::from_raw(width, height, pixels).map(DynamicImage::from),
    };
    let mut picture = picture.ok_or_else(|| PictureError::Damaged("it has another size".to_owned()))?;
    picture.apply_orientation(orientation.unwrap_or(Orientation::NoTransforms));
    Ok(Decoded { picture, are_inks: channels == 4, profile, encoding: None, size, notes: Vec::new() })
}

/// Y, Cb and Cr of four inks become cyan, magenta and yellow, all stored as 255 for no ink.
///
/// # Source
/// Adobe Technical Note 5116, transform 2, as every program writes it: luma and chroma are of the inks' complement,
/// and all four are stored inverted.
fn separate([y, cb, cr, _]: &mut [u8; 4]) {
    let (luma, blue, red) = (f32::from(*y), f32::from(*cb) - 128.0, f32::from(*cr) - 128.0);
    let inks = [luma + 1.402 * red, luma - 0.344_136 * blue - 0.714_136 * red, luma + 1.772 * blue];
    [*y, *cb, *cr] = inks.map(|ink| 255 - ink.round().clamp(0.0, 255.0) as u8);
}

pub(super) fn fault(error: DecodeErrors) -> PictureError {
    match error {
        DecodeErrors::Unsupported(scheme) => PictureError::Unsupported(one_line(&format!("{scheme:?}"))),
        DecodeErrors::ExhaustedData | DecodeErrors::IoErrors(_) => PictureError::Truncated,
        DecodeErrors::ZeroError => PictureError::Empty,
        DecodeErrors::Format(why) => PictureError::Damaged(plain(&why)),
        DecodeErrors::FormatStatic(why) => PictureError::Damaged(plain(why)),
        other => PictureError::Damaged(plain(&format!("{other:?}"))),
    }
}

/// Refuses a file whose frame claims more pixels than the limits allow, even if the file ends there.
///
/// # Errors
/// It does.
pub(super) fn refuse_large(bytes: &[u8], limits: &PictureLimits) -> Result<(), PictureError> {
    // Frames of every kind, but not tables of Huffman and arithmetic codes.
    let is_frame = |code| matches!(code, 0xc0..=0xcf) && !matches!(code, 0xc4 | 0xc8 | 0xcc);
    let Some(&[_, _, _, h0, h1, w0, w1, ..]) = segment(bytes, is_frame) else { return Ok(()) };
    let [width, height] = [[w0, w1], [h0, h1]].map(|side| u32::from(u16::from_be_bytes(side)));
    if u64::from(width) * u64::from(height) > limits.pixels {
        return Err(PictureError::TooLarge { width, height, most: limits.pixels });
    }
    Ok(())
}

/// Whether the end marker comes, that of a preview within a segment not counted.
fn is_complete(bytes: &[u8]) -> bool {
    segment(bytes, |code| code == 0xd9).is_some()
}

/// What follows the first marker that is looked for, those within segments not counted.
fn segment(bytes: &[u8], is_wanted: impl Fn(u8) -> bool) -> Option<&[u8]> {
    let mut at = 2;
    while let Some(&[marker, code]) = bytes.get(at..at + 2) {
        match (marker, code) {
            (0xff, code) if is_wanted(code) => return bytes.get(at + 2..),
            // Fill bytes.
            (0xff, 0xff) => at += 1,
            // Markers without a length: stuffing, restarts.
            (0xff, 0x00 | 0x01 | 0xd0..=0xd8) => at += 2,
            (0xff, _) => {
                let Some(&[high, low]) = bytes.get(at + 2..at + 4) else { return None };
                at += 2 + usize::from(u16::from_be_bytes([high, low])).max(2);
            }
            // Coded data, and stray bytes between segments.
            _ => at += 1,
        }
    }
    None
}
