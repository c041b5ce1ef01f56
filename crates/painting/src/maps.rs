//! Where the maps are that a document names: in its folder, in its file, or in memory.

use std::collections::BTreeMap;
use std::io;

use girtin_grid::Raster;
use girtin_grid::memory::probe;
use girtin_grid::random::fold;

use crate::document::Document;
use crate::map_file::{self, MapError};
use crate::picture::PictureLimits;
use crate::resolve::{ResolveError, load};

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

    /// A number that tells maps apart.
    pub fn fingerprint(&self) -> u64 {
        self.folded_into(0)
    }

    /// Amounts from 0 to 1, rounded to 255ths.
    pub fn bytes(amounts: &Raster<f32>) -> Self {
        Self::Bytes(amounts.map(|amount| (amount.clamp(0.0, 1.0) * 255.0 + 0.5) as u8))
    }

    /// Amounts from 0 to 1, in 255ths if they are such, else rounded to 65535ths.
    pub fn nearest(amounts: &Raster<f32>) -> Self {
        let is_byte =
            |&amount: &f32| amount <= 1.0 && (f64::from((amount * 255.0).round()) / 255.0) as f32 == amount;
        let are_bytes = amounts.as_slice().iter().all(is_byte);
        if are_bytes { Self::bytes(amounts) } else { Self::words(amounts) }
    }

    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        match self {
            Self::Bytes(raster) => [raster.width(), raster.height()],
            Self::Words(raster) => [raster.width(), raster.height()],
        }
    }

    /// Bits of a value.
    pub fn bits(&self) -> u32 {
        match self {
            Self::Bytes(_) => u8::BITS,
            Self::Words(_) => u16::BITS,
        }
    }

    /// `key` with size, bits and values in it.
    fn folded_into(&self, key: u64) -> u64 {
        let [width, height] = self.size().map(|side| side as u64);
        let key = [width, height, u64::from(self.bits())].into_iter().fold(key, fold);
        match self {
            Self::Bytes(raster) => raster.as_slice().iter().fold(key, |key, &value| fold(key, value.into())),
            Self::Words(raster) => raster.as_slice().iter().fold(key, |key, &value| fold(key, value.into())),
        }
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
        let [width, height] = map.size();
        probe([(width * height * size_of::<f32>()) as u64]).map_err(MapError::from)?;
        Ok(map.amounts())
    }
}

impl MapChest {
    /// Every map of the document, each read once; the document then names them by the short names they have here.
    ///
    /// # Errors
    /// One cannot be read.
    pub fn gather(document: &mut Document, maps: &dyn Maps) -> Result<Self, ResolveError> {
        let mut chest = Self::default();
        let mut named: BTreeMap<String, String> = BTreeMap::new();
        for name in document.map_names_mut() {
            if !named.contains_key(&name.file) {
                let short = chest.free_name(&name.file);
                let map = load(name, maps)?;
                probe([(map.width() * map.height() * size_of::<u16>()) as u64])?;
                chest.0.insert(short.clone(), StoredMap::nearest(&map));
                named.insert(name.file.clone(), short);
            }
            name.file.clone_from(&named[&name.file]);
        }
        Ok(chest)
    }

    /// The stem of a file's name in plain letters, numbered if another map has it.
    fn free_name(&self, file: &str) -> String {
        let name = file.rsplit(['/', '\\']).next().unwrap_or_default();
        let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
        let plain = |c: char| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' };
        let stem: String = stem.chars().take(60).map(plain).collect();
        let stem = if stem.is_empty() { "map".to_owned() } else { stem };
        let numbered = (2u32..).map(|number| format!("{stem}-{number}"));
        let mut names = std::iter::once(stem.clone()).chain(numbered);
        names.find(|name| !self.0.contains_key(name)).unwrap_or(stem)
    }
}

impl Document {
    /// A number that tells documents apart: made of all that the document says and of its maps.
    pub fn fingerprint(&self, maps: &MapChest) -> u64 {
        let text = |key, text: &str| text.bytes().fold(key, |key, byte| fold(key, u64::from(byte)));
        let maps = maps.0.iter();
        maps.fold(text(0, &self.to_json()), |key, (name, map)| map.folded_into(text(key, name)))
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::document::Stock;
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
    #[test]
    fn maps_are_gathered_once_under_names_of_their_own() {
        let text = "format = 1\n[sheet]\nsize = [3, 2]\n[[glaze]]\n[glaze.outline]\nregions = 'a/sky.png'\n\
            edges = '../b/sky.npz'\nmasked = '.png'\n[[glaze.events]]\ndo = 'wet'\n\
            area = { shape = 'map', file = 'a/sky.png' }\n";
        let mut document = Document::from_toml("", text, &Stock::builtin()).unwrap();
        let mut chest = MapChest::default();
        for (number, name) in ["a/sky.png", "../b/sky.npz", ".png"].into_iter().enumerate() {
            chest.0.insert(name.to_owned(), StoredMap::Words(Raster::new(2, 1, 257 * number as u16)));
        }
        let gathered = MapChest::gather(&mut document, &chest).unwrap();
        let names: Vec<String> = document.map_names_mut().map(|name| name.file.clone()).collect();
        assert_eq!(names, ["sky", "sky-2", "map", "sky"]);
        let wanted = [("map", 2), ("sky", 0), ("sky-2", 1)];
        let wanted =
            wanted.map(|(name, value)| (name.to_owned(), StoredMap::Bytes(Raster::new(2, 1, value))));
        assert_eq!(gathered.0, BTreeMap::from(wanted));
        // Gathered again nothing changes.
        let before = document.clone();
        assert_eq!(MapChest::gather(&mut document, &gathered).unwrap(), gathered);
        assert_eq!(document, before);
        assert_eq!(document.fingerprint(&gathered), before.fingerprint(&gathered));
        assert_ne!(document.fingerprint(&gathered), document.fingerprint(&MapChest::default()));
        document.sheet.seed += 1;
        assert_ne!(document.fingerprint(&gathered), before.fingerprint(&gathered));
        assert!(MapChest::gather(&mut document, &MapChest::default()).is_err());
    }

    #[test]
    fn amounts_are_kept_in_as_few_bits_as_hold_them() {
        let of = |value: f32| StoredMap::nearest(&Raster::new(1, 1, value));
        assert_eq!(of((77.0 / 255.0) as f32), StoredMap::Bytes(Raster::new(1, 1, 77)));
        assert_eq!(of((12345.0 / 65535.0) as f32), StoredMap::Words(Raster::new(1, 1, 12345)));
        assert_eq!(of(1.0), StoredMap::Bytes(Raster::new(1, 1, 255)));
        assert_eq!(of(2.0), StoredMap::Words(Raster::new(1, 1, 65535)));
    }
}
