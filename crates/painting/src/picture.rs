//! Pictures: photographs read as light, maps and scans read as gray, results written in the usual formats.
//!
//! In the order data flows:
//! - [`PictureLimits`], [`PictureError`]: what is read, and why something is not;
//! - `kind`: which format a file is of; `claim`: how large its first bytes say it is; `decode`, `jpeg`: its pixels as they
//!   are stored, upright;
//! - [`read_grey`]: numbers from 0 to 1, as stored; a map's 128 is 0.502 whatever color space the file claims;
//! - [`read_photo`]: light, through the file's color profile (`light`), over a ground where it is transparent;
//! - [`read_size`]: how large a photograph is, without decoding it; [`read_png_word`]: what a PNG says of itself;
//! - [`read_mask`]: gray values again, of what is no colored picture;
//! - [`write_picture`]: sRGB into a [`PictureFormat`], with the resolution that follows from the millimetres of
//!   paper; [`write_png`] and [`write_grey_png`] for rasters of bytes.

mod kind;
mod claim;
mod limits;
mod decode;
mod jpeg;
mod light;
mod read;
mod size;
mod meta;
mod png_head;
mod png_file;
mod tiff_file;
mod write;

pub(crate) use decode::plain;
pub use limits::{PictureError, PictureLimits};
pub(crate) use meta::sides;
pub use meta::{PictureMeta, WriteError};
pub(crate) use png_file::{encoder, write_png_rgba};
pub use png_file::{write_grey_png, write_grey_png_16, write_png};
pub use png_head::read_png_word;
pub use read::{Photo, read_grey, read_mask, read_photo};
pub use size::read_size;
pub use write::{PictureFormat, Rows, write_picture};

#[cfg(test)]
mod tests;
