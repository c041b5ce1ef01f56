//! Maps that a document names: pictures, or one array of an `.npz`.

use std::io::{Cursor, Read};

use girtin_grid::Raster;
use zip::ZipArchive;

use crate::picture::{PictureError, PictureLimits, read_grey};
use crate::state_file::npy;

/// Why a map cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// The picture cannot be read.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// The archive or its array cannot be read.
    #[error("{0}")]
    Array(String),
}

impl MapError {
    /// What to do about it.
    pub fn hint(&self) -> Option<&'static str> {
        match self {
            Self::Picture(error) => error.hint(),
            Self::Array(_) => Some("save one array of two axes: np.savez(file, map.astype('float32'))"),
        }
    }
}

/// Reads a map, 0 to 1: a picture's grey, or the one array of an `.npz` with two axes.
///
/// # Errors
/// The bytes are neither, are damaged, too large, or hold a value that is not finite.
pub fn read(bytes: &[u8], limits: &PictureLimits) -> Result<Raster<f32>, MapError> {
    if bytes.starts_with(b"PK") {
        read_npz(bytes, limits)
    } else {
        Ok(read_grey(Cursor::new(bytes), limits)?)
    }
}

fn read_npz(bytes: &[u8], limits: &PictureLimits) -> Result<Raster<f32>, MapError> {
    let fault = |why: String| MapError::Array(why);
    let mut archive =
        ZipArchive::new(Cursor::new(bytes)).map_err(|error| fault(format!("not an npz: {error}")))?;
    if archive.len() != 1 {
        return Err(fault(format!("the npz holds {} arrays, not one", archive.len())));
    }
    let mut file = archive.by_index(0).map_err(|error| fault(error.to_string()))?;
    let header =
        npy::read_header(&mut file).map_err(|_| fault("the array's header is damaged".to_owned()))?;
    let &[height, width] = header.shape.as_slice() else {
        return Err(fault(format!("the array has {} axes, not two", header.shape.len())));
    };
    let cells = height.checked_mul(width).filter(|&cells| cells > 0 && cells <= limits.pixels);
    let cells = cells.ok_or_else(|| fault(format!("the array is {width} × {height}")))?;
    let descr = header.descr.as_deref().unwrap_or("a structure");
    let (size, decode): (usize, fn(&[u8]) -> f32) = match descr {
        "|b1" | "|u1" => (1, |b| if b[0] == 0 { 0.0 } else { 1.0 }),
        "<f4" => (4, |b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])),
        "<f8" => (8, |b| f64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]]) as f32),
        other => return Err(fault(format!("the array is of {}", npy::type_name(other)))),
    };
    // Read as it comes, so that a header alone makes nothing large.
    let mut data = Vec::new();
    let wanted = cells * size as u64;
    file.by_ref().take(wanted).read_to_end(&mut data).map_err(|error| fault(error.to_string()))?;
    if data.len() as u64 != wanted {
        return Err(fault("the array ends early".to_owned()));
    }
    let values: Vec<f32> = data.chunks_exact(size).map(decode).collect();
    if values.iter().any(|value| !value.is_finite()) {
        return Err(fault("the array holds a value that is not finite".to_owned()));
    }
    let (width, height) = (width as usize, height as usize);
    Ok(Raster::from_fn(width, height, |x, y| {
        values[if header.fortran_order { x * height + y } else { y * width + x }]
    }))
}
