//! A painting into an archive.

use std::collections::BTreeMap;
use std::io::{self, Cursor, Write};

use girtin_params::write::{Node, Tree};
use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, System, ZipWriter};

use super::{
    DOCUMENT, GirtinFile, GirtinFileError, MERGED, MIME_TYPE, MIMETYPE, PAINTED, PAINTED_FORMAT, PAPERS,
    PIGMENTS, PaintedRecord, THUMBNAIL, entry_of, entry_of_map,
};
use crate::document::Document;
use crate::map_file;
use crate::paint::{PigmentBalance, WaterDetail};
use crate::picture::WriteError;

impl GirtinFile {
    /// Writes the painting; equal paintings give equal bytes on every system.
    ///
    /// # Errors
    /// The file could not be read again, a pigment, paper or map of the document is not there, or the writer fails.
    ///
    /// # Cost
    /// The archive is packed in memory: its first header then tells what it is, whatever it is written to.
    pub fn write(&self, mut writer: impl Write) -> Result<(), GirtinFileError> {
        let text = self.document.to_json();
        self.check_text(&text)?;
        let mut archive = Archive(ZipWriter::new(Cursor::new(Vec::new())));
        archive.add(MIMETYPE, MIME_TYPE.as_bytes(), CompressionMethod::Stored)?;
        archive.add(DOCUMENT, text.as_bytes(), CompressionMethod::Deflated)?;
        for (name, text) in self.texts()? {
            archive.add(&name, text.as_bytes(), CompressionMethod::Deflated)?;
        }
        let named = self.document.map_names();
        for (name, map) in &self.maps.0 {
            let mut bytes = Vec::new();
            map_file::write_stored(&mut bytes, map).map_err(pack_picture)?;
            archive.add(&entry_of_map(name, &named, &self.maps), &bytes, CompressionMethod::Stored)?;
        }
        if let Some(painted) = &self.painted {
            archive.add(PAINTED, painted.to_json().as_bytes(), CompressionMethod::Deflated)?;
            // Pictures are packed already.
            archive.add(THUMBNAIL, &painted.thumbnail, CompressionMethod::Stored)?;
            archive.add(MERGED, &painted.merged, CompressionMethod::Stored)?;
        }
        let bytes = archive.0.finish().map_err(pack)?.into_inner();
        writer.write_all(&bytes).and_then(|()| writer.flush()).map_err(GirtinFileError::Write)
    }

    /// Refuses what could not be written: better before the work than after it.
    ///
    /// # Errors
    /// As [`GirtinFile::write`], but for those of the writer.
    pub fn check(&self) -> Result<(), GirtinFileError> {
        self.check_text(&self.document.to_json())?;
        self.texts().map(drop)
    }

    fn check_text(&self, text: &str) -> Result<(), GirtinFileError> {
        let mut again = Document::from_json(DOCUMENT, text, &self.stock).map_err(Box::new)?;
        if again != self.document {
            return Err(GirtinFileError::Lossy);
        }
        self.maps.0.keys().try_for_each(|name| GirtinFileError::check_map_name(name))?;
        match again.map_names_mut().find(|name| !self.maps.0.contains_key(&name.file)) {
            Some(name) => Err(GirtinFileError::NoMap { file: name.file.clone() }),
            None => Ok(()),
        }
    }

    /// The file of every pigment and paper that the document uses.
    fn texts(&self) -> Result<BTreeMap<String, String>, GirtinFileError> {
        let unknown = |error: &dyn std::fmt::Display| GirtinFileError::Unknown(error.to_string());
        let mut texts = BTreeMap::new();
        for name in self.document.glazes.iter().flat_map(|glaze| &glaze.pigments) {
            let pigment = self.stock.pigments.get(name).map_err(|error| unknown(&error))?;
            texts.entry(entry_of(&pigment.id, PIGMENTS)).or_insert_with(|| pigment.to_toml());
        }
        let paper = self.stock.papers.get(&self.document.sheet.paper).map_err(|error| unknown(&error))?;
        texts.insert(entry_of(&paper.id, PAPERS), paper.to_toml());
        Ok(texts)
    }
}

impl PaintedRecord {
    fn to_json(&self) -> String {
        let water = match self.water {
            WaterDetail::Full => "full",
            WaterDetail::Coarse => "coarse",
        };
        let balance = |balance: &PigmentBalance| {
            Tree::new()
                .with("name", balance.name.as_str())
                .with("laid", balance.laid)
                .with("lifted", balance.lifted)
                .with("total", balance.total)
        };
        let glaze = |balances: &Vec<PigmentBalance>| {
            let pigments = balances.iter().map(|of_pigment| Node::Inline(balance(of_pigment)));
            Tree::new().with("pigments", Node::List(pigments.collect()))
        };
        Tree::new()
            .with("format", PAINTED_FORMAT)
            .with("water", water)
            .with("glaze", Node::Sections(self.balances.iter().map(glaze).collect()))
            .to_json()
    }
}

struct Archive(ZipWriter<Cursor<Vec<u8>>>);

impl Archive {
    /// Time, rights and system are fixed, so that only the painting decides the bytes.
    fn add(&mut self, name: &str, bytes: &[u8], method: CompressionMethod) -> Result<(), GirtinFileError> {
        let options = SimpleFileOptions::default()
            .compression_method(method)
            .last_modified_time(DateTime::default())
            .unix_permissions(0o644)
            .system(System::Unix)
            .large_file(bytes.len() as u64 >= u64::from(u32::MAX));
        self.0.start_file(name, options).map_err(pack)?;
        self.0.write_all(bytes).map_err(|error| pack(error.into()))
    }
}

fn pack(error: ZipError) -> GirtinFileError {
    GirtinFileError::Pack(error.to_string())
}

fn pack_picture(error: WriteError) -> GirtinFileError {
    match error {
        WriteError::Write(error) => pack(ZipError::Io(io::Error::other(error))),
        other => GirtinFileError::Pack(other.to_string()),
    }
}
