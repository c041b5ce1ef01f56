//! Inputs: files, pipes and the standard input.

use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;

use girtin::grid::memory::probe;
use girtin::painting::picture::{PictureError, PictureLimits};

use crate::failure::{Failure, Kind, plain};

/// What can be read in any order.
pub trait Source: Read + Seek {}

impl<T: Read + Seek> Source for T {}

/// A pipe's bytes beyond this go to a temporary file.
const SPOOLED: usize = 64 << 20;

/// The name of an input, for messages.
pub fn name_of(path: &Path) -> String {
    if path == Path::new("-") { "the standard input".to_owned() } else { format!("`{}`", path.display()) }
}

/// Opens a file; `-` is the standard input.
///
/// # Errors
/// There is no such file, or it cannot be read.
pub fn open(path: &Path) -> Result<Box<dyn Source>, Failure> {
    if path == Path::new("-") {
        return spool(io::stdin().lock()).map_err(|error| cannot_read(path, &error));
    }
    let file = File::open(path).map_err(|error| cannot_read(path, &error))?;
    let kind = file.metadata().map_err(|error| cannot_read(path, &error))?.file_type();
    if kind.is_dir() {
        return Err(Failure::input(format!("`{}` is a folder", path.display())).hint("name a file in it"));
    }
    if kind.is_file() { Ok(Box::new(file)) } else { spool(file).map_err(|error| cannot_read(path, &error)) }
}

/// Archives and pictures are read in any order; a pipe only forwards.
fn spool(mut pipe: impl Read) -> io::Result<Box<dyn Source>> {
    let mut file = tempfile::spooled_tempfile(SPOOLED);
    io::copy(&mut pipe, &mut file)?;
    file.flush()?;
    file.seek(SeekFrom::Start(0))?;
    Ok(Box::new(file))
}

/// The first bytes of an input, at most so many; what follows reads from its start again.
///
/// # Errors
/// It cannot be read.
pub fn beginning(path: &Path, source: &mut dyn Source, most: u64) -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    let read = source.take(most).read_to_end(&mut bytes).and_then(|_| source.seek(SeekFrom::Start(0)));
    read.map_err(|error| cannot_read(path, &error))?;
    Ok(bytes)
}

/// The text of a TOML file.
///
/// # Errors
/// There is no such file, it cannot be read or is not text.
pub fn read_text(path: &Path) -> Result<String, Failure> {
    text_of(path, &mut *open(path)?)
}

/// The text of an input that is open.
///
/// # Errors
/// It cannot be read or is not text.
pub fn text_of(path: &Path, source: &mut dyn Source) -> Result<String, Failure> {
    let mut bytes = Vec::new();
    // One byte more than is read as TOML, which then says so.
    let most = girtin::params::read::MAX_TEXT as u64 + 1;
    source.take(most).read_to_end(&mut bytes).map_err(|error| cannot_read(path, &error))?;
    String::from_utf8(bytes).map_err(|error| {
        Failure::input(format!(
            "{} is not text: byte {} is not UTF-8",
            name_of(path),
            error.utf8_error().valid_up_to()
        ))
        .hint("save it as UTF-8")
    })
}

/// A picture, through one of the library's readers.
///
/// # Errors
/// There is no such file, it is no picture or too large.
pub fn picture<T>(
    path: &Path,
    read: impl FnOnce(Box<dyn Source>, &PictureLimits) -> Result<T, PictureError>,
) -> Result<T, Failure> {
    read(open(path)?, &PictureLimits::default()).map_err(|error| {
        let is_outside = matches!(error, PictureError::Read(_) | PictureError::NoRoom(_));
        let kind = if is_outside { Kind::Failed } else { Kind::Input };
        let hint = error.hint().unwrap_or("try another picture");
        Failure::new(kind, format!("{}: {error}", name_of(path))).hint(hint)
    })
}

/// Why a photograph is not read; `--max-pixels` raises its limits.
pub fn no_photo(path: &Path, error: &PictureError) -> Failure {
    let is_outside = matches!(error, PictureError::NoRoom(_))
        || matches!(error, PictureError::Read(error) if error.kind() != io::ErrorKind::UnexpectedEof);
    let kind = if is_outside { Kind::Failed } else { Kind::Input };
    let hint = match error {
        PictureError::TooLarge { width, height, .. } => {
            let pixels = u64::from(*width) * u64::from(*height);
            if probe([pixels.saturating_mul(LEAST_BYTES)]).is_ok() {
                format!("if it is to be trusted, allow it with `--max-pixels {pixels}`; or reduce it first")
            } else {
                "this machine has not the memory for it: reduce it first, if it is a picture at all"
                    .to_owned()
            }
        }
        PictureError::Memory { .. } => "if it is to be trusted, allow more with `--max-pixels`".to_owned(),
        _ => error.hint().unwrap_or("try another picture").to_owned(),
    };
    Failure::new(kind, format!("{}: {error}", name_of(path))).hint(hint)
}

/// Bytes that a pixel of a photograph takes at least, as light and while it is decoded.
const LEAST_BYTES: u64 = 15;

/// Refuses to read the standard input twice.
///
/// # Errors
/// `-` is named more than once.
pub fn check_stdin<'a>(paths: impl IntoIterator<Item = &'a Path>) -> Result<(), Failure> {
    if paths.into_iter().filter(|path| *path == Path::new("-")).count() > 1 {
        return Err(Failure::usage(
            "`-` is given for two inputs, and the standard input can be read only once",
        )
        .hint("save one of them to a file and name that"));
    }
    Ok(())
}

fn cannot_read(path: &Path, error: &io::Error) -> Failure {
    let hint = match error.kind() {
        io::ErrorKind::NotFound => match nearest_file(path) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "look at the spelling and the folder".to_owned(),
        },
        io::ErrorKind::PermissionDenied => "its rights do not let you read it".to_owned(),
        _ => "copy the file again".to_owned(),
    };
    Failure::input(format!("cannot read {}: {}", name_of(path), plain(error))).hint(hint)
}

/// The file in the same folder whose name is nearest.
fn nearest_file(path: &Path) -> Option<String> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    let entries = fs::read_dir(folder.unwrap_or(Path::new("."))).ok()?;
    // A folder may be huge, and this is only a hint.
    let names: Vec<String> =
        entries.take(1000).filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect();
    let near = girtin::params::nearest(path.file_name()?.to_str()?, names.iter().map(String::as_str))?;
    Some(folder.map_or(near.to_owned(), |folder| folder.join(near).display().to_string()))
}
