//! The `.girtin` file: a painting that stands alone.
//!
//! A zip archive: `mimetype`; `document.json`, the [`Document`]; `maps/NAME.png`, the maps it names, in grey of 8 or 16
//! bits, where a name that ends in `.png` already is the entry's; `pigments/ID.toml` and `papers/ID.toml`, every one that it uses, so that a later library paints it no
//! differently; and of a painting that was painted `painted.json`, where its pigments went, with `merged.png` and
//! `thumbnail.png`.
//!
//! ```
//! use girtin_painting::girtin_file::{GirtinFile, Limits};
//! use girtin_painting::{Document, MapChest, Stock};
//!
//! let stock = Stock::builtin();
//! let document = Document::from_toml("bare.toml", "format = 1\n[sheet]\nsize = [30, 20]\n", &stock)?;
//! let file = GirtinFile { document, maps: MapChest::default(), stock, painted: None };
//! let mut bytes = Vec::new();
//! file.write(&mut bytes)?;
//! let again = GirtinFile::read(std::io::Cursor::new(bytes), &Limits::default())?;
//! assert_eq!(again.document, file.document);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::BTreeSet;
use std::io::{BufReader, Read, Seek, SeekFrom};

use girtin_grid::Raster;

use crate::document::{Document, Stock};
use crate::maps::MapChest;
use crate::paint::{PigmentBalance, WaterDetail};
use crate::picture::{PictureLimits, PictureMeta, WriteError, write_png};

mod error;
mod read;
mod thumbnail;
mod write;

pub use error::GirtinFileError;
pub use thumbnail::thumbnail;

/// What the file says it is.
pub const MIME_TYPE: &str = "application/x-girtin";

/// Version of `painted.json`.
const PAINTED_FORMAT: u32 = 1;

const MIMETYPE: &str = "mimetype";
const DOCUMENT: &str = "document.json";
const PAINTED: &str = "painted.json";
const THUMBNAIL: &str = "thumbnail.png";
const MERGED: &str = "merged.png";
const MAPS: [&str; 2] = ["maps/", ".png"];
const PIGMENTS: [&str; 2] = ["pigments/", ".toml"];
const PAPERS: [&str; 2] = ["papers/", ".toml"];

/// A painting that stands alone.
#[derive(Clone, Debug)]
pub struct GirtinFile {
    /// The document.
    pub document: Document,
    /// The maps that it names.
    pub maps: MapChest,
    /// Where its pigments and papers are. As read: the built-in ones, and over them those of the file.
    pub stock: Stock,
    /// What became of it when it was painted.
    pub painted: Option<PaintedRecord>,
}

/// What became of a document when it was painted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PaintedRecord {
    /// How finely water was simulated.
    pub water: WaterDetail,
    /// Where the pigments of each glaze went, from the paper up.
    pub balances: Vec<Vec<PigmentBalance>>,
    /// The finished picture, a PNG in sRGB.
    pub merged: Vec<u8>,
    /// The same, small: a PNG of at most [`THUMBNAIL_SIDE`] a side.
    pub thumbnail: Vec<u8>,
}

/// Long edge of a thumbnail, pixels.
pub const THUMBNAIL_SIDE: usize = 256;

/// How large a file may be that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Entries of the archive.
    pub entries: usize,
    /// Bytes of all entries, unpacked from the archive.
    pub bytes: u64,
    /// Size of each map, and of the memory that decoding it takes.
    pub maps: PictureLimits,
    /// Memory of all maps, bytes.
    pub map_bytes: u64,
}

impl Default for Limits {
    /// 4096 entries, 4 GiB of them, 4 GiB of maps.
    fn default() -> Self {
        Self { entries: 4096, bytes: 4 << 30, maps: PictureLimits::default(), map_bytes: 4 << 30 }
    }
}

/// Whether this is an archive with a painting in it, sound or not; the reader is back at its start afterwards.
///
/// # Errors
/// The medium fails.
pub fn is_girtin_file(mut reader: impl Read + Seek) -> std::io::Result<bool> {
    // The first entry is stored: what the file is can be seen even if its end is missing.
    let mut start = Vec::new();
    reader.by_ref().take(FIRST_ENTRY).read_to_end(&mut start)?;
    let says_so = start.starts_with(b"PK") && start.ends_with(format!("{MIMETYPE}{MIME_TYPE}").as_bytes());
    reader.seek(SeekFrom::Start(0))?;
    // An archive that was packed by hand may have another order.
    let is_one = says_so
        || zip::ZipArchive::new(BufReader::new(&mut reader))
            .is_ok_and(|zip| zip.file_names_raw().any(|name| name == DOCUMENT.as_bytes()));
    reader.seek(SeekFrom::Start(0))?;
    Ok(is_one)
}

/// Bytes of the first entry: its header, name and content.
const FIRST_ENTRY: u64 = (30 + MIMETYPE.len() + MIME_TYPE.len()) as u64;

/// The name between a folder and an ending.
fn inner<'a>(entry: &'a str, [folder, ending]: [&str; 2]) -> Option<&'a str> {
    entry.strip_prefix(folder)?.strip_suffix(ending)
}

fn entry_of(name: &str, [folder, ending]: [&str; 2]) -> String {
    format!("{folder}{name}{ending}")
}

/// The entry of a map. One that the document calls `NAME.png` needs no second ending, unless another is called `NAME`.
fn entry_of_map(name: &str, named: &BTreeSet<String>, maps: &MapChest) -> String {
    let stem = name.strip_suffix(MAPS[1]);
    match stem.filter(|stem| named.contains(name) && !maps.0.contains_key(*stem)) {
        Some(stem) => entry_of(stem, MAPS),
        None => entry_of(name, MAPS),
    }
}

/// What the document calls the map of an entry: the name without the ending, or with it if only that is named and has no
/// entry of its own, as it had in older files.
fn map_of_entry(called: &str, named: &BTreeSet<String>, entries: &[(String, String)]) -> String {
    let whole = entry_of(called, ["", MAPS[1]]);
    let is_whole =
        !named.contains(called) && named.contains(&whole) && entries.iter().all(|(_, other)| *other != whole);
    if is_whole { whole } else { called.to_owned() }
}

/// Whether a map's name can be one in the archive: plain words with nothing that leads out of a folder.
fn is_plain(name: &str) -> bool {
    let allowed = |c: char| c.is_ascii_alphanumeric() || " _-.".contains(c);
    let is_word = |word: &str| !word.is_empty() && !word.starts_with(['.', ' ']) && word.chars().all(allowed);
    name.len() <= 200 && name.split('/').all(is_word)
}

/// The picture, small, as bytes of a PNG.
///
/// # Errors
/// The picture is empty.
pub fn thumbnail_png(picture: &Raster<[u8; 3]>) -> Result<Vec<u8>, WriteError> {
    let mut bytes = Vec::new();
    write_png(&mut bytes, &thumbnail(picture), &PictureMeta::default())?;
    Ok(bytes)
}

#[cfg(test)]
mod tests;
