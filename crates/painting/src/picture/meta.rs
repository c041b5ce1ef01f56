//! What a picture's file says besides its pixels.

use std::io::{self, Cursor};

use exif::experimental::Writer;
use exif::{Field, In, Rational, Tag, Value};
use moxcms::{CmsError, ColorProfile};

/// What a picture's file says besides its pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PictureMeta {
    /// Pixels per mm of paper, from which programs take the size of a print.
    pub pixels_per_mm: Option<f64>,
    /// Keywords and texts, in the order in which they are written.
    ///
    /// A PNG holds them as they are; elsewhere `Software` has its own place, and the others are lines of one text.
    pub text: Vec<(String, String)>,
}

/// Why a picture cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The medium failed.
    #[error("the picture cannot be written: {0}")]
    Write(#[source] io::Error),
    /// A format has from 1 pixel a side to as many as its numbers hold.
    #[error("a picture of {width} × {height} pixels cannot be {format}, which has {most} a side at most")]
    Size {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// The format, with its article.
        format: &'static str,
        /// Most pixels a side.
        most: u32,
    },
    /// A keyword has from 1 to 79 characters of Latin-1.
    #[error("`{keyword}` cannot be a keyword of a picture")]
    Keyword {
        /// The keyword.
        keyword: String,
    },
    /// The resolution is no number that the format can hold.
    #[error("{pixels_per_mm} pixels per mm cannot be the resolution of a picture")]
    Resolution {
        /// The resolution.
        pixels_per_mm: f64,
    },
    /// A film's frame or a layer has another size than was announced, or a film another number of frames.
    #[error("there are {found}, not {wanted}")]
    Parts {
        /// What came.
        found: String,
        /// What was announced.
        wanted: String,
    },
    /// The encoder refused.
    #[error("the picture cannot be encoded: {0}")]
    Encode(String),
}

impl From<image::ImageError> for WriteError {
    fn from(error: image::ImageError) -> Self {
        match error {
            image::ImageError::IoError(error) => Self::Write(error),
            other => Self::Encode(other.to_string()),
        }
    }
}

impl From<CmsError> for WriteError {
    fn from(error: CmsError) -> Self {
        Self::Encode(error.to_string())
    }
}

/// Sides as a format counts them.
///
/// # Errors
/// They are 0 or too many.
pub(crate) fn sides(
    (width, height): (usize, usize),
    format: &'static str,
    most: u32,
) -> Result<(u32, u32), WriteError> {
    let side = |pixels: usize| u32::try_from(pixels).ok().filter(|&side| side > 0 && side <= most);
    side(width).zip(side(height)).ok_or(WriteError::Size { width, height, format, most })
}

/// Dots per inch, if it is a number that every format can hold.
///
/// # Errors
/// It is none from 0.01 to 65535.
pub(super) fn dots_per_inch(pixels_per_mm: f64) -> Result<f64, WriteError> {
    let dots = pixels_per_mm * 25.4;
    if (0.01..=65535.0).contains(&dots) { Ok(dots) } else { Err(WriteError::Resolution { pixels_per_mm }) }
}

/// The profile of sRGB, the same bytes at any time.
///
/// # Errors
/// It cannot be encoded, which is not expected.
pub(super) fn srgb_profile() -> Result<Vec<u8>, WriteError> {
    let mut profile = ColorProfile::new_srgb().encode()?;
    // Bytes 24 to 35 of the header are the time at which it was encoded.
    if let Some(time) = profile.get_mut(24..36) {
        time.copy_from_slice(&PROFILE_TIME);
    }
    Ok(profile)
}

/// 2020-01-01 00:00:00.
const PROFILE_TIME: [u8; 12] = [0x07, 0xe4, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0];

impl PictureMeta {
    /// The text of `Software`.
    pub(super) fn software(&self) -> Option<&str> {
        self.text.iter().find(|(keyword, _)| keyword == SOFTWARE).map(|(_, text)| text.as_str())
    }

    /// Every other keyword, a line each.
    pub(super) fn lines(&self) -> Option<String> {
        let rest = self.text.iter().filter(|(keyword, _)| keyword != SOFTWARE);
        let lines: Vec<String> = rest.map(|(keyword, text)| format!("{keyword}: {text}")).collect();
        (!lines.is_empty()).then(|| lines.join("\n"))
    }

    /// An EXIF block that says all of it; `None` if there is nothing to say.
    ///
    /// # Errors
    /// The resolution is none that it can hold.
    pub(super) fn exif(&self) -> Result<Option<Vec<u8>>, WriteError> {
        let mut fields = Vec::new();
        let mut push = |tag, value| fields.push(Field { tag, ifd_num: In::PRIMARY, value });
        let text = |text: &str| Value::Ascii(vec![text.replace('\0', " ").into_bytes()]);
        if let Some(lines) = self.lines() {
            push(Tag::ImageDescription, text(&lines));
        }
        if let Some(pixels_per_mm) = self.pixels_per_mm {
            let dots = Rational { num: (dots_per_inch(pixels_per_mm)? * 1000.0).round() as u32, denom: 1000 };
            push(Tag::XResolution, Value::Rational(vec![dots]));
            push(Tag::YResolution, Value::Rational(vec![dots]));
            push(Tag::ResolutionUnit, Value::Short(vec![2]));
        }
        if let Some(software) = self.software() {
            push(Tag::Software, text(software));
        }
        if fields.is_empty() {
            return Ok(None);
        }
        let mut writer = Writer::new();
        fields.iter().for_each(|field| writer.push_field(field));
        let mut bytes = Cursor::new(Vec::new());
        writer.write(&mut bytes, false).map_err(|error| WriteError::Encode(error.to_string()))?;
        Ok(Some(bytes.into_inner()))
    }
}

const SOFTWARE: &str = "Software";
