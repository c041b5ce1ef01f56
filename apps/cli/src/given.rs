//! The document that a verb is given: TOML, JSON or a `.girtin`, told apart by what is in it.

use std::io;
use std::path::{Path, PathBuf};

use girtin::painting::girtin_file::{GirtinFile, Limits};
use girtin::painting::map_file::MapError;
use girtin::painting::picture::PictureError;
use girtin::painting::{Document, GirtinFileError, MapChest, PaintedRecord, ResolveError, Stock};
use girtin::paper::Paper;
use girtin::params::Place;

use crate::arguments::PigmentFiles;
use crate::failure::{Failure, Kind, plain};
use crate::input::{self, Source};
use crate::output::Target;

/// The painter's own pigments and papers.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct StockFiles {
    #[command(flatten)]
    pub pigments: PigmentFiles,
    /// Add a paper from a TOML file; may be repeated
    #[arg(long = "paper-file", value_name = "FILE")]
    pub papers: Vec<PathBuf>,
}

impl StockFiles {
    /// A stock and these, in the place of its own of the same id.
    ///
    /// # Errors
    /// A file cannot be read, or is no pigment or paper.
    pub fn over(&self, mut stock: Stock) -> Result<Stock, Failure> {
        stock.pigments = self.pigments.over(stock.pigments)?;
        for path in &self.papers {
            stock.papers.insert(Paper::from_toml(&path.display().to_string(), &input::read_text(path)?)?);
        }
        Ok(stock)
    }

    /// Every file.
    pub fn paths(&self) -> impl Iterator<Item = &Path> {
        self.pigments.files.iter().chain(&self.papers).map(PathBuf::as_path)
    }
}

/// A document with what it names, but for the maps of one that is text: those lie in its folder.
pub struct Given {
    /// The document.
    pub document: Document,
    /// What it may name.
    pub stock: Stock,
    /// What became of it when it was painted, if it says so.
    pub painted: Option<PaintedRecord>,
    /// In which form it is.
    pub form: Form,
    maps: Maps,
}

/// A form that a document can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    Toml,
    Json,
    Girtin,
}

enum Maps {
    Here(MapChest),
    Beside {
        /// The document's file, for messages.
        name: String,
        text: String,
        folder: Option<PathBuf>,
    },
}

impl Given {
    /// Reads a document; `-` is the standard input.
    ///
    /// # Errors
    /// There is no such file, or it or one of the stock is wrong.
    pub fn read(path: &Path, files: &StockFiles) -> Result<Self, Failure> {
        Self::of_source(path, input::open(path)?, files)
    }

    /// The same of an input that is open.
    ///
    /// # Errors
    /// As [`Given::read`].
    pub fn of_source(path: &Path, mut source: Box<dyn Source>, files: &StockFiles) -> Result<Self, Failure> {
        let start = input::beginning(path, &mut *source, 2)?;
        if start.starts_with(b"PK") {
            return Self::of_archive(path, source, files);
        }
        let text = input::text_of(path, &mut *source)?;
        let name = path.display().to_string();
        let stock = files.over(Stock::builtin())?;
        let is_json = text.trim_start_matches('\u{feff}').trim_start().starts_with('{');
        let (form, document) = if is_json {
            (Form::Json, Document::from_json(&name, &text, &stock)?)
        } else {
            (Form::Toml, Document::from_toml(&name, &text, &stock)?)
        };
        let maps = Maps::Beside { name, text, folder: path.parent().map(Path::to_owned) };
        Ok(Self { document, stock, painted: None, form, maps })
    }

    fn of_archive(path: &Path, source: Box<dyn Source>, files: &StockFiles) -> Result<Self, Failure> {
        let file = GirtinFile::read(source, &Limits::default()).map_err(|error| unread(path, error))?;
        let GirtinFile { document, maps, stock, painted } = file;
        let stock = files.over(stock)?;
        Ok(Self { document, stock, painted, form: Form::Girtin, maps: Maps::Here(maps) })
    }

    /// The document, what it may name, and its maps; none of them may be what is written to.
    ///
    /// # Errors
    /// A map is not there, cannot be read or is an output as well.
    pub fn gather(self, outputs: &[&Target]) -> Result<GirtinFile, Failure> {
        let Self { mut document, stock, painted, maps, .. } = self;
        let maps = match maps {
            Maps::Here(maps) => maps,
            Maps::Beside { name, text, folder } => {
                let open = |map: &str| -> io::Result<Vec<u8>> {
                    let folder = folder.as_deref().ok_or(io::ErrorKind::NotFound)?;
                    let path = folder.join(map);
                    if outputs.iter().any(|output| output.is(&path)) {
                        return Err(io::Error::other("it is the output as well"));
                    }
                    std::fs::read(path)
                };
                let gathered = MapChest::gather(&mut document, &open);
                gathered.map_err(|error| no_map(&error, &name, &text))?
            }
        };
        Ok(GirtinFile { document, maps, stock, painted })
    }
}

/// What to do about a map that is too large for the memory.
const LESS_MAP: &str = "reduce the map first";

fn no_map(error: &ResolveError, name: &str, text: &str) -> Failure {
    let said_at =
        |place: &Place, message: &str, hint: &str| Failure::from(place.problem(name, text, message, hint));
    match error {
        ResolveError::NoRoom(_)
        | ResolveError::Map {
            source: MapError::NoRoom(_) | MapError::Picture(PictureError::NoRoom(_)),
            ..
        } => Failure::failed(error).hint(LESS_MAP),
        ResolveError::Open { file, place, source } => {
            let said = format!("cannot read map `{file}`: {}", plain(source));
            said_at(place, &said, "maps lie in the document's folder")
        }
        ResolveError::Map { place, source, .. } => {
            said_at(place, &error.to_string(), source.hint().unwrap_or("save the map again"))
        }
        _ => Failure::input(error).hint("mend the document"),
    }
}

/// Why a `.girtin` cannot be read.
fn unread(path: &Path, error: GirtinFileError) -> Failure {
    if let GirtinFileError::Text(mut problem) = error {
        problem.origin = format!("{}/{}", path.display(), problem.origin);
        return Failure::from(*problem);
    }
    let is_outside = matches!(
        error,
        GirtinFileError::Read(_)
            | GirtinFileError::Map {
                source: MapError::NoRoom(_) | MapError::Picture(PictureError::NoRoom(_)),
                ..
            }
    );
    let kind = if is_outside { Kind::Failed } else { Kind::Input };
    let hint = error.hint().unwrap_or_else(|| "copy the file again".to_owned());
    Failure::new(kind, format!("{}: {error}", input::name_of(path))).hint(hint)
}
