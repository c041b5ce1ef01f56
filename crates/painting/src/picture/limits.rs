//! How much is read, and why a picture is not.

use std::io;

use girtin_grid::memory::NoRoom;

/// How large a picture may be that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureLimits {
    /// Pixels.
    pub pixels: u64,
    /// Memory of the decoder, its result included, bytes.
    pub decoder_bytes: u64,
}

impl PictureLimits {
    /// Pixels of a photograph that is read unless more are allowed: 2^27, twice what the largest cameras make.
    pub const PHOTO_PIXELS: u64 = 1 << 27;

    /// Limits of a photograph: 16 bytes for each pixel, which holds 16 bits of four channels twice.
    pub fn of_photo(pixels: u64) -> Self {
        Self { pixels, decoder_bytes: pixels.saturating_mul(16).max(64 << 20) }
    }
}

impl Default for PictureLimits {
    /// 2^28 pixels, 512 MiB: a map or a scan of one channel.
    fn default() -> Self {
        Self { pixels: 1 << 28, decoder_bytes: 512 << 20 }
    }
}

/// Why a picture cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PictureError {
    /// The medium failed.
    #[error("the picture cannot be read: {0}")]
    Read(#[source] io::Error),
    /// There are no bytes.
    #[error("the file is empty")]
    NoBytes,
    /// The bytes begin as no format that is known.
    #[error("the file is no picture of a known format")]
    Unknown,
    /// The format is known, but none of those that are read.
    #[error("the file is {found}, which is not read")]
    Format {
        /// Name of the format with its article.
        found: &'static str,
        /// How to make a picture of it that is read.
        hint: &'static str,
    },
    /// The picture uses a part of its format that is not read.
    #[error("the picture cannot be decoded: {0}")]
    Unsupported(String),
    /// The file ends before the picture does.
    #[error("the picture's file ends early")]
    Truncated,
    /// The file is damaged.
    #[error("the picture is damaged: {0}")]
    Damaged(String),
    /// There are no pixels.
    #[error("the picture has no pixels")]
    Empty,
    /// There are more pixels than the limits allow.
    #[error("the picture has {width} × {height} pixels; {most} pixels at most are read")]
    TooLarge {
        /// Columns.
        width: u32,
        /// Rows.
        height: u32,
        /// Most pixels.
        most: u64,
    },
    /// Decoding takes more memory than the limits allow.
    #[error("decoding the picture takes more than {most} bytes of memory")]
    Memory {
        /// Most bytes.
        most: u64,
    },
    /// There is no memory for it.
    #[error(transparent)]
    NoRoom(#[from] NoRoom),
    /// It is a picture in color where a mask is wanted.
    #[error("it is a picture in color, not a mask: {percent} % of it are colored")]
    Colored {
        /// How much of it is.
        percent: u64,
    },
    /// A pixel is no number.
    #[error("the picture's pixel {x}, {y} is not a finite number")]
    NotFinite {
        /// Column, from 0.
        x: usize,
        /// Row, from 0.
        y: usize,
    },
}

impl PictureError {
    /// What to try.
    ///
    /// Where the limits can be raised, see [`PictureError::is_of_limits`], the caller says how.
    pub fn hint(&self) -> Option<&'static str> {
        match self {
            Self::Format { hint, .. } => Some(hint),
            Self::Unknown => Some("open it in a picture viewer and save it as JPEG or PNG"),
            Self::Unsupported(_) => Some("save it as a PNG of 8 or 16 bits"),
            Self::NoBytes | Self::Truncated | Self::Damaged(_) => {
                Some("the file may be incomplete: save or copy it again")
            }
            Self::TooLarge { .. } | Self::Memory { .. } | Self::NoRoom(_) => Some("reduce the picture first"),
            Self::Colored { .. } => {
                Some("save it in shades of gray: white where it is meant, black elsewhere")
            }
            Self::NotFinite { .. } => Some("fill holes before saving, or save it as a PNG of 16 bits"),
            Self::Read(_) | Self::Empty => None,
        }
    }

    /// Whether [`PictureLimits`] with more pixels would let it be read.
    pub fn is_of_limits(&self) -> bool {
        matches!(self, Self::TooLarge { .. } | Self::Memory { .. })
    }
}
