//! How large a picture is, from its header alone.

use std::io::{BufReader, Read, Seek, SeekFrom};

use image::codecs::bmp::BmpDecoder;
use image::codecs::gif::GifDecoder;
use image::codecs::png::PngDecoder;
use image::codecs::tiff::TiffDecoder;
use image::codecs::webp::WebPDecoder;
use image::metadata::Orientation;
use image::{ImageDecoder, ImageResult};
use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::claim::refuse_large;
use super::decode::{HEAD, head_error, of_header, picture_error};
use super::kind::{self, Kind};
use super::{PictureError, PictureLimits, jpeg};

/// Columns and rows of a picture as [`read_photo`](super::read_photo) would give it, upright, without decoding it.
///
/// # Errors
/// The format is not read, the header is damaged, or the picture is larger than `limits`.
pub fn read_size(
    mut reader: impl Read + Seek,
    ending: Option<&str>,
    limits: &PictureLimits,
) -> Result<(u32, u32), PictureError> {
    let mut head = Vec::new();
    reader.by_ref().take(HEAD).read_to_end(&mut head).map_err(PictureError::Read)?;
    let kind = kind::of(&head, ending)?;
    refuse_large(kind, &head, limits)?;
    if kind == Kind::Tiff {
        kind::refuse_raw(&mut reader)?;
    }
    reader.seek(SeekFrom::Start(0)).map_err(PictureError::Read)?;
    let reader = BufReader::new(reader);
    let measured = match kind {
        Kind::Jpeg => return of_jpeg(reader, limits),
        Kind::Png => {
            let decoder = PngDecoder::with_limits(reader, of_header(limits));
            return within(decoder.and_then(upright).map_err(|error| head_error(error, limits))?, limits);
        }
        Kind::WebP => WebPDecoder::new(reader).and_then(upright),
        Kind::Tiff => TiffDecoder::new(reader).and_then(upright),
        Kind::Gif => GifDecoder::new(reader).and_then(upright),
        Kind::Bmp => BmpDecoder::new(reader).and_then(upright),
    };
    within(measured.map_err(|error| picture_error(error, limits))?, limits)
}

fn upright(mut decoder: impl ImageDecoder) -> ImageResult<(u32, u32)> {
    let orientation = decoder.orientation()?;
    Ok(turned(decoder.dimensions(), orientation))
}

fn turned((width, height): (u32, u32), orientation: Orientation) -> (u32, u32) {
    use Orientation::{Rotate90, Rotate90FlipH, Rotate270, Rotate270FlipH};
    match orientation {
        Rotate90 | Rotate270 | Rotate90FlipH | Rotate270FlipH => (height, width),
        _ => (width, height),
    }
}

fn of_jpeg(reader: impl Read, limits: &PictureLimits) -> Result<(u32, u32), PictureError> {
    let mut bytes = Vec::new();
    reader.take(limits.decoder_bytes).read_to_end(&mut bytes).map_err(PictureError::Read)?;
    let options =
        DecoderOptions::default().set_strict_mode(false).set_max_width(usize::MAX).set_max_height(usize::MAX);
    jpeg::refuse_large(&bytes, limits)?;
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes.as_slice()), options);
    decoder.decode_headers().map_err(jpeg::fault)?;
    let Some((width, height)) = decoder.dimensions() else {
        return Err(PictureError::Damaged("it has no header".to_owned()));
    };
    let orientation = decoder.exif().and_then(|exif| Orientation::from_exif_chunk(exif));
    let size = (width as u32, height as u32);
    within(turned(size, orientation.unwrap_or(Orientation::NoTransforms)), limits)
}

fn within((width, height): (u32, u32), limits: &PictureLimits) -> Result<(u32, u32), PictureError> {
    if width == 0 || height == 0 {
        return Err(PictureError::Empty);
    }
    if u64::from(width) * u64::from(height) > limits.pixels {
        return Err(PictureError::TooLarge { width, height, most: limits.pixels });
    }
    Ok((width, height))
}
