//! A painting out of an archive: all names first, then texts, then pictures, nothing beyond the limits.

use std::collections::BTreeSet;
use std::io::{self, BufReader, Read, Seek};

use girtin_optics::Pigment;
use girtin_paper::Paper;
use girtin_params::read::{Fault, MAX_TEXT};
use girtin_params::{Problem, Table, parse_json};
use zip::ZipArchive;
use zip::result::ZipError;

use super::{
    DOCUMENT, GirtinFile, GirtinFileError, Limits, MAPS, MERGED, MIME_TYPE, MIMETYPE, PAINTED,
    PAINTED_FORMAT, PAPERS, PIGMENTS, PaintedRecord, THUMBNAIL, inner, is_plain, map_of_entry,
};
use crate::document::{Document, Stock};
use crate::map_file;
use crate::maps::MapChest;
use crate::paint::{PigmentBalance, WaterDetail};
use crate::picture::PictureError;

/// Largest text of a pigment or a paper, bytes.
const MAX_RECIPE: u64 = 1 << 20;

/// What every PNG begins with.
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";

impl GirtinFile {
    /// Reads a painting; names in it lead to its own pigments and papers first, then to the built-in ones.
    ///
    /// # Errors
    /// The file is no painting, is damaged or larger than `limits`, or one of its texts is wrong.
    pub fn read(reader: impl Read + Seek, limits: &Limits) -> Result<Self, GirtinFileError> {
        let mut archive = Archive::open(reader, limits)?;
        let stock = archive.stock()?;
        let text = archive.text(DOCUMENT, MAX_TEXT as u64)?;
        let mut document = Document::from_json(DOCUMENT, &text, &stock).map_err(Box::new)?;
        let painted = archive.painted()?;
        let maps = archive.maps(limits, &document.map_names())?;
        if let Some(name) = document.map_names_mut().find(|name| !maps.0.contains_key(&name.file)) {
            return Err(GirtinFileError::NoMap { file: name.file.clone() });
        }
        Ok(Self { document, maps, stock, painted })
    }
}

/// An archive of which every name is one that a painting has.
struct Archive<R> {
    zip: ZipArchive<BufReader<R>>,
    /// Names of the entries, in the order of the archive.
    names: Vec<String>,
    /// Bytes that may still be unpacked.
    room: u64,
    limits: Limits,
}

impl<R: Read + Seek> Archive<R> {
    fn open(reader: R, limits: &Limits) -> Result<Self, GirtinFileError> {
        let zip = ZipArchive::new(BufReader::new(reader)).map_err(|error| match error {
            ZipError::Io(error) if !is_damage(&error) => GirtinFileError::Read(error),
            // What the zip reader says of its own blocks helps no painter.
            _ => GirtinFileError::NotGirtin { why: "it is damaged, cut short or something else".to_owned() },
        })?;
        if zip.len() > limits.entries {
            let (found, most) = (zip.len() as u64, limits.entries as u64);
            return Err(GirtinFileError::TooLarge { quantity: "entries", found, most });
        }
        if zip.has_duplicate_names() {
            return Err(GirtinFileError::Duplicate);
        }
        let names: Vec<Vec<u8>> = zip.file_names_raw().map(<[u8]>::to_vec).collect();
        if !names.iter().any(|name| name == MIMETYPE.as_bytes() || name == DOCUMENT.as_bytes()) {
            let is_state = names.iter().any(|name| name.ends_with(b".npy"));
            let what = if is_state { "the state of a wash" } else { "another archive" };
            return Err(GirtinFileError::Other { what });
        }
        let names = names.into_iter().map(|name| {
            let unknown = GirtinFileError::unknown(&name);
            String::from_utf8(name).ok().filter(|name| is_known(name)).ok_or(unknown)
        });
        let names = names.collect::<Result<_, _>>()?;
        let mut archive = Self { zip, names, room: limits.bytes, limits: *limits };
        if archive.text(MIMETYPE, 1 << 10)?.trim_end() != MIME_TYPE {
            return Err(GirtinFileError::Other { what: "an archive of another type" });
        }
        Ok(archive)
    }

    fn bytes(&mut self, name: &str, most: u64) -> Result<Vec<u8>, GirtinFileError> {
        let limits = self.limits;
        let Some(index) = self.names.iter().position(|entry| entry == name) else {
            return Err(GirtinFileError::Missing { name: name.to_owned() });
        };
        let unpack = |why: &str| GirtinFileError::Unpack { name: name.to_owned(), why: why.to_owned() };
        let unread = |error: io::Error| match error.kind() {
            io::ErrorKind::UnexpectedEof => unpack("it ends early"),
            _ if is_damage(&error) => unpack(&error.to_string()),
            _ => GirtinFileError::Read(error),
        };
        let mut file = self.zip.by_index(index).map_err(|error| match error {
            ZipError::Io(error) => unread(error),
            other => unpack(&other.to_string()),
        })?;
        let declared = file.size();
        if declared > most.min(self.room) {
            let (quantity, most) =
                if declared > most { ("bytes in a text", most) } else { ("bytes", limits.bytes) };
            return Err(GirtinFileError::TooLarge { quantity, found: declared, most });
        }
        let mut bytes = Vec::new();
        // Read as it comes, so that a header alone makes nothing large.
        file.by_ref().take(declared + 1).read_to_end(&mut bytes).map_err(unread)?;
        if bytes.len() as u64 != declared {
            return Err(unpack("it is not as long as it says"));
        }
        self.room -= declared;
        Ok(bytes)
    }

    fn text(&mut self, name: &str, most: u64) -> Result<String, GirtinFileError> {
        let bytes = self.bytes(name, most)?;
        let unpack = |_| GirtinFileError::Unpack { name: name.to_owned(), why: "it is not text".to_owned() };
        String::from_utf8(bytes).map_err(unpack)
    }

    /// Entries of a folder, and what they are called in it.
    fn entries(&self, place: [&str; 2]) -> Vec<(String, String)> {
        let names = self.names.iter();
        names.filter_map(|name| Some((name.clone(), inner(name, place)?.to_owned()))).collect()
    }

    /// The built-in stock, and over it the file's own.
    fn stock(&mut self) -> Result<Stock, GirtinFileError> {
        let mut stock = Stock::builtin();
        let same = |name: String, called: String, id: &str| {
            let other = GirtinFileError::OtherName { name, id: id.to_owned() };
            if called == id { Ok(()) } else { Err(other) }
        };
        for (name, called) in self.entries(PIGMENTS) {
            let pigment = Pigment::from_toml(&name, &self.text(&name, MAX_RECIPE)?).map_err(Box::new)?;
            same(name, called, &pigment.id)?;
            stock.pigments = stock.pigments.with(pigment);
        }
        for (name, called) in self.entries(PAPERS) {
            let paper = Paper::from_toml(&name, &self.text(&name, MAX_RECIPE)?).map_err(Box::new)?;
            same(name, called, &paper.id)?;
            stock.papers.insert(paper);
        }
        Ok(stock)
    }

    fn painted(&mut self) -> Result<Option<PaintedRecord>, GirtinFileError> {
        if !self.names.iter().any(|name| name == PAINTED) {
            return Ok(None);
        }
        let text = self.text(PAINTED, MAX_TEXT as u64)?;
        let mut painted = read_painted(&text).map_err(Box::new)?;
        painted.thumbnail = self.png(THUMBNAIL)?;
        painted.merged = self.png(MERGED)?;
        Ok(Some(painted))
    }

    fn png(&mut self, name: &str) -> Result<Vec<u8>, GirtinFileError> {
        let bytes = self.bytes(name, u64::MAX)?;
        if bytes.starts_with(PNG) {
            return Ok(bytes);
        }
        Err(GirtinFileError::Unpack { name: name.to_owned(), why: "it is no PNG".to_owned() })
    }

    fn maps(&mut self, limits: &Limits, named: &BTreeSet<String>) -> Result<MapChest, GirtinFileError> {
        let mut chest = MapChest::default();
        let mut room = limits.map_bytes;
        let entries = self.entries(MAPS);
        for (name, called) in &entries {
            let bytes = self.bytes(name, u64::MAX)?;
            let within = crate::picture::PictureLimits {
                decoder_bytes: limits.maps.decoder_bytes.min(room),
                ..limits.maps
            };
            let map = map_file::read_stored(&bytes, &within).map_err(|source| match source {
                map_file::MapError::Picture(PictureError::Memory { .. })
                    if room < limits.maps.decoder_bytes =>
                {
                    let (found, most) = (limits.map_bytes - room, limits.map_bytes);
                    GirtinFileError::TooLarge { quantity: "bytes of maps and more", found, most }
                }
                source => GirtinFileError::Map { name: name.clone(), source },
            })?;
            let [width, height] = map.size();
            room = room.saturating_sub(width as u64 * height as u64 * u64::from(map.bits() / 8));
            chest.0.insert(map_of_entry(called, named, &entries), map);
        }
        Ok(chest)
    }
}

/// Whether an error tells of the file's content and not of its medium.
fn is_damage(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::UnexpectedEof | io::ErrorKind::InvalidData | io::ErrorKind::InvalidInput
    )
}

/// Whether a painting has entries of this name.
fn is_known(name: &str) -> bool {
    let is_id = |id: &str| is_plain(id) && !id.contains('/');
    // Archives that were packed by hand have folders too, which hold nothing themselves.
    let folders = [MAPS, PIGMENTS, PAPERS].map(|[folder, _]| folder);
    [MIMETYPE, DOCUMENT, PAINTED, THUMBNAIL, MERGED].contains(&name)
        || folders.contains(&name)
        || inner(name, MAPS).is_some_and(is_plain)
        || inner(name, PIGMENTS).is_some_and(is_id)
        || inner(name, PAPERS).is_some_and(is_id)
}

fn read_painted(text: &str) -> Result<PaintedRecord, Problem> {
    let any = f64::MIN..=f64::MAX;
    let balance = |table: &Table<'_>| {
        Ok(PigmentBalance {
            name: table.need_text("name")?,
            laid: table.need_real("laid", any.clone())?,
            lifted: table.need_real("lifted", any.clone())?,
            total: table.need_real("total", any.clone())?,
        })
    };
    parse_json(PAINTED, text, |table| {
        if table.count("format", 0..=u32::MAX)? != Some(PAINTED_FORMAT) {
            let fault: Fault = table.fault("format", "`format` is not known");
            return Err(fault.hint("a newer Girtin may read this file"));
        }
        let words = [("full", WaterDetail::Full), ("coarse", WaterDetail::Coarse)];
        let glaze = |glaze: &Table<'_>| Ok(glaze.tables("pigments", balance)?.unwrap_or_default());
        Ok(PaintedRecord {
            water: table.word("water", &words)?.unwrap_or_default(),
            balances: table.tables("glaze", glaze)?.unwrap_or_default(),
            ..PaintedRecord::default()
        })
    })
}
