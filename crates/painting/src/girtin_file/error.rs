use std::io;

use girtin_params::Problem;

use super::is_plain;
use crate::map_file::MapError;

/// Why a painting's file cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GirtinFileError {
    /// The medium failed.
    #[error("the painting cannot be read: {0}")]
    Read(#[source] io::Error),
    /// The medium failed.
    #[error("the painting cannot be written: {0}")]
    Write(#[source] io::Error),
    /// The file is no archive, an incomplete one, or one of something else.
    #[error("the file is not a whole .girtin: {why}")]
    NotGirtin {
        /// What it is or lacks.
        why: String,
    },
    /// The file is an archive of something else.
    #[error("the file is {what}, not a painting")]
    Other {
        /// What it is.
        what: &'static str,
    },
    /// Two entries have one name.
    #[error("the file holds two entries of the same name")]
    Duplicate,
    /// An entry is none of a painting's.
    #[error("unknown entry `{name}`")]
    UnknownEntry {
        /// Its name, in plain letters.
        name: String,
    },
    /// An entry is missing.
    #[error("the file lacks `{name}`")]
    Missing {
        /// Its name.
        name: String,
    },
    /// There is more of something than the limits allow.
    #[error("the file has {found} {quantity}; {most} at most are read")]
    TooLarge {
        /// Of what.
        quantity: &'static str,
        /// How many.
        found: u64,
        /// How many at most.
        most: u64,
    },
    /// An entry cannot be taken out of the archive.
    #[error("`{name}` cannot be unpacked: {why}")]
    Unpack {
        /// Its name.
        name: String,
        /// What stopped it.
        why: String,
    },
    /// A text of the file is wrong.
    #[error(transparent)]
    Text(#[from] Box<Problem>),
    /// A pigment's or paper's entry is called otherwise than it calls itself.
    #[error("`{name}` holds `{id}`")]
    OtherName {
        /// Name of the entry.
        name: String,
        /// Id in its text.
        id: String,
    },
    /// A map cannot be read.
    #[error("`{name}`: {source}")]
    Map {
        /// Name of the entry.
        name: String,
        /// Why.
        source: MapError,
    },
    /// The document names a map that is not there.
    #[error("the document names a map `{file}` that is not there")]
    NoMap {
        /// Its name.
        file: String,
    },
    /// A map's name cannot be one in an archive.
    #[error("`{file}` cannot be the name of a map in a .girtin")]
    MapName {
        /// The name.
        file: String,
    },
    /// A pigment or paper is in no stock.
    #[error("{0}")]
    Unknown(String),
    /// The document says what no file can.
    #[error("the document would be another one when it is read again")]
    Lossy,
    /// The archive cannot be made.
    #[error("the painting cannot be packed: {0}")]
    Pack(String),
}

impl GirtinFileError {
    /// What to try.
    pub fn hint(&self) -> Option<String> {
        let again = "the file may be incomplete: save or copy it again";
        let said = match self {
            Self::NotGirtin { .. } | Self::Duplicate | Self::Unpack { .. } | Self::Missing { .. } => again,
            Self::Other { .. } => "give a .girtin, or a document as TOML or JSON",
            Self::UnknownEntry { .. } | Self::OtherName { .. } => {
                "a newer Girtin may have written it; or save the painting again"
            }
            Self::TooLarge { .. } => "save it with fewer or smaller maps",
            Self::Text(problem) => return problem.hint.clone(),
            Self::Map { source, .. } => source.hint()?,
            Self::NoMap { .. } => "put it into the file's `maps` as a grey PNG",
            Self::MapName { .. } => "use letters, digits and dashes, such as `sky`",
            Self::Unknown(_) => "name one of the stock",
            Self::Lossy => "keep every value within its range",
            Self::Read(_) | Self::Write(_) | Self::Pack(_) => return None,
        };
        Some(said.to_owned())
    }

    /// An entry that nothing of a painting is called like.
    pub(super) fn unknown(name: &[u8]) -> Self {
        // Printable and short, whatever the file says.
        Self::UnknownEntry { name: name[..name.len().min(60)].escape_ascii().to_string() }
    }

    /// Unless the name can be a map's.
    pub(super) fn check_map_name(file: &str) -> Result<(), Self> {
        if is_plain(file) { Ok(()) } else { Err(Self::MapName { file: file.to_owned() }) }
    }
}
