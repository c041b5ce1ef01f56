//! A file's pixels as they are stored, upright.

use std::io::{self, BufReader, Read, Seek, SeekFrom};

use girtin_grid::memory::probe;
use image::codecs::bmp::BmpDecoder;
use image::codecs::gif::GifDecoder;
use image::codecs::png::PngDecoder;
use image::codecs::tiff::TiffDecoder;
use image::codecs::webp::WebPDecoder;
use image::error::ImageError;
use image::{DynamicImage, ExtendedColorType, ImageDecoder, ImageResult};

use super::claim::refuse_large;
use super::kind::{self, Kind};
use super::png_head::{Encoding, encoding};
use super::{PictureError, PictureLimits, jpeg};

/// What a file holds.
pub(super) struct Decoded {
    /// Upright pixels, as stored.
    pub picture: DynamicImage,
    /// Whether the four channels are cyan, magenta, yellow and black, full scale for no ink.
    pub are_inks: bool,
    /// The color profile.
    pub profile: Option<Vec<u8>>,
    /// What the file says of its colors without one.
    pub encoding: Option<Encoding>,
    /// Columns and rows before it was turned.
    pub size: (u32, u32),
    /// What somebody should know who sees what became of it.
    pub notes: Vec<String>,
}

/// Bytes that tell a format: SVG comes late in its file.
pub(super) const HEAD: u64 = 1024;

/// Decodes a picture; there is room for a raster of values of `value_bytes` besides.
///
/// `ending` is what the file's name ends with, without the dot.
///
/// # Errors
/// The format is not read, the file is damaged, or the picture is larger than `limits`.
pub(super) fn decoded(
    mut reader: impl Read + Seek,
    ending: Option<&str>,
    limits: &PictureLimits,
    value_bytes: usize,
) -> Result<Decoded, PictureError> {
    let mut head = Vec::new();
    reader.by_ref().take(HEAD).read_to_end(&mut head).map_err(PictureError::Read)?;
    let kind = kind::of(&head, ending)?;
    refuse_large(kind, &head, limits)?;
    let mut notes = Vec::new();
    match kind {
        Kind::Tiff => {
            kind::refuse_raw(&mut reader)?;
            if has_pages(&mut reader)? {
                notes.push("the file has several pages: the first is read".to_owned());
            }
        }
        Kind::Gif if is_animated_gif(&mut reader)? => notes.push(ANIMATION.to_owned()),
        _ => {}
    }
    // WebP's decoder calls a missing end corrupt, if it misses it at all.
    let is_cut = kind == Kind::WebP && is_cut_riff(&mut reader, &head)?;
    let encoding = if kind == Kind::Png { encoding(&mut reader, limits) } else { None };
    reader.seek(SeekFrom::Start(0)).map_err(PictureError::Read)?;
    let reader = BufReader::new(reader);
    let fault = |error| picture_error(error, limits);
    let mut decoded = match kind {
        Kind::Jpeg => jpeg::decode(reader, limits, value_bytes),
        Kind::Png => {
            let decoder = PngDecoder::with_limits(reader, of_header(limits))
                .map_err(|error| head_error(error, limits))?;
            if decoder.is_apng().map_err(fault)? {
                notes.push(ANIMATION.to_owned());
            }
            through(decoder, limits, value_bytes)
        }
        Kind::WebP => {
            if is_cut {
                return Err(PictureError::Truncated);
            }
            let decoder = WebPDecoder::new(reader).map_err(fault)?;
            if decoder.has_animation() {
                notes.push(ANIMATION.to_owned());
            }
            through(decoder, limits, value_bytes)
        }
        Kind::Tiff => through(TiffDecoder::new(reader).map_err(fault)?, limits, value_bytes),
        Kind::Gif => through(GifDecoder::new(reader).map_err(fault)?, limits, value_bytes),
        Kind::Bmp => through(BmpDecoder::new(reader).map_err(fault)?, limits, value_bytes),
    }?;
    decoded.notes.append(&mut notes);
    decoded.encoding = encoding;
    Ok(decoded)
}

const ANIMATION: &str = "the file is an animation: its first picture is read";

fn has_pages(reader: &mut (impl Read + Seek)) -> Result<bool, PictureError> {
    reader.seek(SeekFrom::Start(0)).map_err(PictureError::Read)?;
    // What is wrong with it, the decoder says.
    Ok(tiff::decoder::Decoder::new(reader).is_ok_and(|decoder| decoder.more_images()))
}

fn is_animated_gif(reader: &mut (impl Read + Seek)) -> Result<bool, PictureError> {
    reader.seek(SeekFrom::Start(0)).map_err(PictureError::Read)?;
    let mut options = gif::DecodeOptions::new();
    options.skip_frame_decoding(true);
    let Ok(mut decoder) = options.read_info(BufReader::new(reader)) else { return Ok(false) };
    let mut has_next = || decoder.next_frame_info().is_ok_and(|frame| frame.is_some());
    Ok(has_next() && has_next())
}

/// Whether the file is shorter than its first chunk says.
fn is_cut_riff(reader: &mut impl Seek, head: &[u8]) -> Result<bool, PictureError> {
    let length = reader.seek(SeekFrom::End(0)).map_err(PictureError::Read)?;
    Ok(match head {
        &[_, _, _, _, a, b, c, d, ..] => length < 8 + u64::from(u32::from_le_bytes([a, b, c, d])),
        _ => true,
    })
}

/// Most that what is packed in the head of a PNG may unpack to.
const HEADER_BYTES: u64 = 64 << 20;

/// What the head of a PNG may take: a packed profile or text may be a bomb, and those of any honest picture fit.
pub(super) fn of_header(limits: &PictureLimits) -> image::Limits {
    let mut header = memory(limits);
    header.max_alloc = Some(limits.decoder_bytes.min(HEADER_BYTES));
    header
}

fn memory(limits: &PictureLimits) -> image::Limits {
    let mut memory = image::Limits::no_limits();
    memory.max_alloc = Some(limits.decoder_bytes);
    memory
}

/// Refuses what is larger than the limits or the memory.
///
/// # Errors
/// It is.
pub(super) fn roomy(
    (width, height): (u32, u32),
    limits: &PictureLimits,
    decoder_bytes: u64,
    value_bytes: usize,
) -> Result<(), PictureError> {
    if width == 0 || height == 0 {
        return Err(PictureError::Empty);
    }
    let pixels = u64::from(width) * u64::from(height);
    if pixels > limits.pixels {
        return Err(PictureError::TooLarge { width, height, most: limits.pixels });
    }
    if decoder_bytes > limits.decoder_bytes {
        return Err(PictureError::Memory { most: limits.decoder_bytes });
    }
    Ok(probe([decoder_bytes, pixels.saturating_mul(value_bytes as u64)])?)
}

fn through(
    mut decoder: impl ImageDecoder,
    limits: &PictureLimits,
    value_bytes: usize,
) -> Result<Decoded, PictureError> {
    let size = decoder.dimensions();
    let bytes = decoder.total_bytes();
    roomy(size, limits, bytes, value_bytes)?;
    let fault = |error| picture_error(error, limits);
    let were_inks =
        matches!(decoder.original_color_type(), ExtendedColorType::Cmyk8 | ExtendedColorType::Cmyk16);
    // Before the limits are set: after, a TIFF's profile may take no more memory than its pixels. One that cannot be
    // had is none.
    let profile = decoder.icc_profile().unwrap_or_default();
    let orientation = decoder.orientation().map_err(fault)?;
    // The result is allocated outside the decoder and counts with what the decoder needs.
    let mut memory = memory(limits);
    memory.reserve(bytes).map_err(fault)?;
    decoder.set_limits(memory).map_err(fault)?;
    let read: ImageResult<_> = DynamicImage::from_decoder(decoder);
    let mut picture = read.map_err(fault)?;
    picture.apply_orientation(orientation);
    let mut notes = Vec::new();
    if were_inks {
        notes.push(INKS.to_owned());
    }
    Ok(Decoded {
        picture,
        are_inks: false,
        profile: profile.filter(|_| !were_inks),
        encoding: None,
        size,
        notes,
    })
}

/// What is said of inks that were converted without their profile.
pub(super) const INKS: &str =
    "the picture is made of printing inks (CMYK), and its colors are a guess: save it as sRGB for exact ones";

/// Why the head of a PNG is not read: a limit that nobody can raise is the file's fault.
pub(super) fn head_error(error: ImageError, limits: &PictureLimits) -> PictureError {
    match error {
        ImageError::Limits(_) if limits.decoder_bytes >= HEADER_BYTES => {
            PictureError::Damaged("what is packed in its head unpacks to more than 64 MB".to_owned())
        }
        other => picture_error(other, limits),
    }
}

pub(super) fn picture_error(error: ImageError, limits: &PictureLimits) -> PictureError {
    match error {
        ImageError::IoError(error) => io_error(error),
        ImageError::Limits(_) => PictureError::Memory { most: limits.decoder_bytes },
        ImageError::Unsupported(error) => PictureError::Unsupported(one_line(&error.to_string())),
        other if is_cut(&other) => PictureError::Truncated,
        other => PictureError::Damaged(plain(&other.to_string())),
    }
}

fn io_error(error: io::Error) -> PictureError {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => PictureError::Truncated,
        io::ErrorKind::InvalidData | io::ErrorKind::InvalidInput => {
            PictureError::Damaged(plain(&error.to_string()))
        }
        _ => PictureError::Read(error),
    }
}

/// Whether the end of the file is at the bottom of it.
fn is_cut(error: &ImageError) -> bool {
    let mut below = std::error::Error::source(error);
    while let Some(error) = below {
        let is_eof = |error: &io::Error| error.kind() == io::ErrorKind::UnexpectedEof;
        let is_gif_eof = |error: &gif::DecodingError| matches!(error, gif::DecodingError::UnexpectedEof);
        if error.downcast_ref().is_some_and(is_eof) || error.downcast_ref().is_some_and(is_gif_eof) {
            return true;
        }
        below = error.source();
    }
    false
}

/// What a decoder says of damage, in plain language where it speaks of its own insides.
pub(crate) fn plain(message: &str) -> String {
    let message = one_line(message);
    // Of PNG, whose parts each have one.
    if message.contains("CRC error") || message.contains("checksum") {
        return "a checksum does not fit, so bytes of the file were changed".to_owned();
    }
    let is_of_insides = |c: char| matches!(c, '{' | '}' | '(' | ')' | '[' | ']' | '"');
    if message.contains(is_of_insides) || message.contains("0x") {
        return "a part of it is not as its format has it".to_owned();
    }
    message
}

/// Decoders' messages may quote the file.
pub(super) fn one_line(message: &str) -> String {
    message.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
