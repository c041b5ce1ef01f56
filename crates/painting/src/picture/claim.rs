//! How many pixels the first bytes of a file claim, before any decoder has a say.

use super::kind::Kind;
use super::{PictureError, PictureLimits};

/// Refuses a file whose head claims more pixels than the limits allow, even if that is all there is of it.
///
/// # Errors
/// It does.
pub(super) fn refuse_large(kind: Kind, head: &[u8], limits: &PictureLimits) -> Result<(), PictureError> {
    match claimed(kind, head) {
        Some((width, height)) if u64::from(width) * u64::from(height) > limits.pixels => {
            Err(PictureError::TooLarge { width, height, most: limits.pixels })
        }
        _ => Ok(()),
    }
}

/// Columns and rows at the place where the format has them; JPEG and TIFF have none.
fn claimed(kind: Kind, head: &[u8]) -> Option<(u32, u32)> {
    let long = |at: usize| head.get(at..)?.first_chunk::<4>().copied();
    let short = |at: usize| Some(u32::from(u16::from_le_bytes(*head.get(at..)?.first_chunk()?)));
    let three = |at: usize| Some(1 + (u32::from_le_bytes(long(at)?) & 0xff_ffff));
    match kind {
        Kind::Png if head.get(12..16) == Some(b"IHDR") => {
            Some((u32::from_be_bytes(long(16)?), u32::from_be_bytes(long(20)?)))
        }
        Kind::Gif => Some((short(6)?, short(8)?)),
        Kind::Bmp => {
            let side = |at| Some(i32::from_le_bytes(long(at)?).unsigned_abs());
            // Files of OS/2 have sides of two bytes.
            if long(14)? == 12u32.to_le_bytes() {
                Some((short(18)?, short(20)?))
            } else {
                Some((side(18)?, side(22)?))
            }
        }
        Kind::WebP if head.get(12..16) == Some(b"VP8X") => Some((three(24)?, three(27)?)),
        Kind::Png | Kind::WebP | Kind::Jpeg | Kind::Tiff => None,
    }
}
