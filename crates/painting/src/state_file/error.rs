use std::io;

use girtin_grid::memory::NoRoom;
use girtin_params::hint_for;
use girtin_wash::StateError;

use super::{Key, LedgerKey};

/// Why a state file cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StateFileError {
    /// The medium failed.
    #[error("the state cannot be read: {0}")]
    Read(#[source] io::Error),
    /// The medium failed.
    #[error("the state cannot be written: {0}")]
    Write(#[source] io::Error),
    /// The file is a single array.
    #[error("the file is one array (.npy), not the arrays of a state (.npz)")]
    OneArray,
    /// The file is no archive, or an incomplete one.
    #[error("the file is not a whole .npz archive: {why}")]
    NotNpz {
        /// What the archive lacks.
        why: String,
    },
    /// Two arrays have one name.
    #[error("the file holds two arrays of the same name")]
    Duplicate,
    /// An array is none of a state's.
    #[error("unknown array `{name}`")]
    UnknownKey {
        /// Its name in the file.
        name: String,
    },
    /// There is no wet mask.
    #[error("the file lacks `wet_mask`")]
    NoWetMask,
    /// An array cannot be taken out of the archive.
    #[error("`{key}` cannot be unpacked: {why}")]
    Unpack {
        /// The array.
        key: &'static str,
        /// What stopped it.
        why: String,
    },
    /// An array does not begin as NumPy's do.
    #[error("`{key}` has no valid .npy header: {why}")]
    Header {
        /// The array.
        key: &'static str,
        /// What is wrong with it.
        why: String,
    },
    /// An array holds values of another type.
    #[error("`{key}` is {found}, not {wanted}")]
    Type {
        /// The array.
        key: &'static str,
        /// NumPy's name of the type.
        found: String,
        /// The types that are read.
        wanted: &'static str,
        /// The NumPy expression to save instead.
        fix: String,
    },
    /// An array has another shape than the wet mask asks for.
    #[error("`{key}` has the shape {}, not {wanted}", tuple(found))]
    Shape {
        /// The array.
        key: &'static str,
        /// Its shape.
        found: Vec<u64>,
        /// The shape it must have.
        wanted: String,
        /// What to do, if the cause is likely.
        fix: Option<String>,
    },
    /// An array has no values.
    #[error("`{key}` is empty: its shape is {}", tuple(found))]
    Empty {
        /// The array.
        key: &'static str,
        /// Its shape.
        found: Vec<u64>,
    },
    /// `suspended` and `deposited` are of different numbers of pigments.
    #[error("`suspended` holds {suspended} pigments, `deposited` {deposited}")]
    Pigments {
        /// Pigments of `suspended`.
        suspended: u64,
        /// Pigments of `deposited`.
        deposited: u64,
    },
    /// The state is larger than the [`Limits`](super::Limits).
    #[error("the state has {found} {quantity}; at most {most} are read")]
    TooLarge {
        /// What there is too much of.
        quantity: &'static str,
        /// How much there is.
        found: u64,
        /// How much is allowed.
        most: u64,
    },
    /// What is not 0 takes more memory than the [`Limits`](super::Limits) allow.
    #[error("the state takes more than {most} bytes of memory")]
    Memory {
        /// Most bytes.
        most: u64,
    },
    /// There is no memory for it.
    #[error(transparent)]
    NoRoom(#[from] NoRoom),
    /// An array has more or fewer bytes than its shape asks for.
    #[error("`{key}` has {found} bytes, its shape asks for {wanted}")]
    Length {
        /// The array.
        key: &'static str,
        /// Bytes in the archive.
        found: u64,
        /// Bytes of header and values.
        wanted: u64,
    },
    /// A value is not allowed.
    #[error(transparent)]
    State(#[from] StateError),
}

impl StateFileError {
    /// What to try.
    pub fn hint(&self) -> Option<String> {
        let hint = match self {
            Self::OneArray => "save it by name: `np.savez('state.npz', wet_mask=...)`".to_owned(),
            Self::NotNpz { .. } | Self::Unpack { .. } | Self::Header { .. } | Self::Length { .. } => {
                "save the state again with `np.savez` or `np.savez_compressed`".to_owned()
            }
            Self::Duplicate => "save every array once".to_owned(),
            Self::UnknownKey { name } => {
                let arrays = Key::ALL.map(Key::name);
                let known = [&arrays[..], &LedgerKey::ALL.map(LedgerKey::name)].concat();
                hint_for(name.strip_suffix(".npy").unwrap_or(name), &known)
            }
            Self::NoWetMask => "add `wet_mask`, bool, of the shape (rows, columns)".to_owned(),
            Self::Type { fix, .. } => format!("save it as `{fix}`"),
            Self::Shape { fix, .. } => return fix.clone(),
            Self::Empty { key, .. } if *key != Key::WetMask.name() => format!("leave `{key}` out"),
            Self::Empty { .. } => "a state has at least one cell".to_owned(),
            Self::Pigments { .. } => "both hold the same pigments; a missing one is 0".to_owned(),
            Self::TooLarge { .. } | Self::Memory { .. } | Self::NoRoom(_) => {
                "use fewer cells or pigments".to_owned()
            }
            Self::State(StateError::Value { field: "wet_mask", .. }) => {
                "save it as `wet_mask > 0`".to_owned()
            }
            Self::State(StateError::Value { field, .. }) => {
                format!("look at `{field}` with `np.isfinite`, `.min()` and `.max()` before saving")
            }
            Self::State(StateError::Number { name, allowed, .. }) => {
                format!("save `{name}` as one number, {allowed}")
            }
            Self::Read(_) | Self::Write(_) | Self::State(_) => return None,
        };
        Some(hint)
    }
}

/// A shape as Python prints it.
fn tuple(shape: &[u64]) -> String {
    match shape {
        [one] => format!("({one},)"),
        _ => format!("({})", shape.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")),
    }
}
