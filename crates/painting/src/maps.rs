//! Where the maps are that a document names: in its folder, in its file, or in memory.

use std::collections::BTreeMap;
use std::io;

use girtin_grid::Raster;

use crate::map_file::{self, MapError};
use crate::picture::PictureLimits;

/// Why there is no map of a name.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MapFault {
    /// Its file cannot be opened.
    #[error(transparent)]
    Open(#[from] io::Error),
    /// Its file cannot be read.
    #[error(transparent)]
    Read(#[from] MapError),
}

/// The maps that a document may name.
pub trait Maps: Sync {
    /// The map of this name, values 0 to 1.
    ///
    /// # Errors
    /// There is none, or it cannot be read.
    fn map(&self, name: &str) -> Result<Raster<f32>, MapFault>;
}

/// Maps in files; the function gives the bytes of a name's file.
impl<F: Fn(&str) -> io::Result<Vec<u8>> + Sync> Maps for F {
    fn map(&self, name: &str) -> Result<Raster<f32>, MapFault> {
        Ok(map_file::read(&self(name)?, &PictureLimits::default())?)
    }
}

/// A map as a grey picture stores it, so that it is the same before it was ever written and after it was read.
#[derive(Clone, Debug, PartialEq)]
pub enum StoredMap {
    /// In 255ths.
    Bytes(Raster<u8>),
    /// In 65535ths.
    Words(Raster<u16>),
}

impl StoredMap {
    /// Amounts from 0 to 1, rounded to 65535ths.
    pub fn words(amounts: &Raster<f32>) -> Self {
        Self::Words(amounts.map(|amount| (amount.clamp(0.0, 1.0) * 65535.0 + 0.5) as u16))
    }

    /// Amounts from 0 to 1, rounded to 255ths.
    pub fn bytes(amounts: &Raster<f32>) -> Self {
        Self::Bytes(amounts.map(|amount| (amount.clamp(0.0, 1.0) * 255.0 + 0.5) as u8))
    }

    /// The amounts, as they are read from a file.
    pub fn amounts(&self) -> Raster<f32> {
        match self {
            Self::Bytes(raster) => raster.map(|value| (f64::from(value) / 255.0) as f32),
            Self::Words(raster) => raster.map(|value| (f64::from(value) / 65535.0) as f32),
        }
    }
}

/// Maps in memory, by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MapChest(pub BTreeMap<String, StoredMap>);

impl Maps for MapChest {
    fn map(&self, name: &str) -> Result<Raster<f32>, MapFault> {
        let map = self.0.get(name).ok_or(io::ErrorKind::NotFound).map_err(io::Error::from)?;
        Ok(map.amounts())
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::picture::{PictureLimits, PictureMeta, read_grey, write_grey_png, write_grey_png_16};

    #[test]
    fn a_map_in_memory_is_what_its_file_would_be() {
        let words = StoredMap::Words(Raster::from_fn(256, 256, |x, y| (256 * y + x) as u16));
        let bytes = StoredMap::Bytes(Raster::from_fn(256, 1, |x, _| x as u8));
        for map in [words, bytes] {
            let mut file = Vec::new();
            match &map {
                StoredMap::Words(raster) => write_grey_png_16(&mut file, raster, &PictureMeta::default()),
                StoredMap::Bytes(raster) => write_grey_png(&mut file, raster, &PictureMeta::default()),
            }
            .unwrap();
            assert_eq!(read_grey(Cursor::new(file), &PictureLimits::default()).unwrap(), map.amounts());
        }
    }
}
