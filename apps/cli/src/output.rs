//! Outputs: checked before the work, written beside their place, and renamed when they are whole.

use std::collections::HashSet;
use std::fs::{self, File};
use std::io::{self, BufWriter, IsTerminal, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use girtin::painting::GirtinFileError;
use tempfile::NamedTempFile;

use crate::failure::{Failure, Kind, plain};
use crate::interrupt::Interrupt;

/// What happens to outputs that are there already.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct OutputArgs {
    /// Replace outputs that exist
    #[arg(long, conflicts_with = "skip_existing", help_heading = "Output")]
    pub overwrite: bool,
    /// Leave outputs that exist as they are
    #[arg(long, help_heading = "Output")]
    pub skip_existing: bool,
}

/// Where an output goes.
#[derive(Clone, Debug)]
enum Place {
    Stdout,
    /// A device or a pipe, which cannot be renamed onto.
    Device(PathBuf),
    File(PathBuf),
}

/// An output that may be written.
#[derive(Clone, Debug)]
pub struct Target {
    place: Place,
    /// As it was given, for messages.
    name: String,
    overwrite: bool,
}

/// The outputs of one command, and the inputs that they must not touch.
#[derive(Debug)]
pub struct Outputs {
    args: OutputArgs,
    inputs: Vec<PathBuf>,
    claimed: HashSet<PathBuf>,
    /// The folder that was last found to be one that can be written to.
    writable: Option<PathBuf>,
}

/// Endings that promise a format; another ending is the user's own affair.
const OTHER_FORMATS: [&str; 14] =
    ["girtin", "png", "jpg", "jpeg", "tif", "tiff", "webp", "gif", "bmp", "exr", "svg", "pdf", "npz", "npy"];

impl Outputs {
    /// Outputs of a command that reads these files.
    pub fn new<'a>(args: OutputArgs, inputs: impl IntoIterator<Item = &'a Path>) -> Self {
        let inputs = inputs.into_iter().filter_map(|input| fs::canonicalize(input).ok()).collect();
        Self { args, inputs, claimed: HashSet::new(), writable: None }
    }

    /// Checks that an output can be written; `None` if it is there and is to be left.
    ///
    /// # Errors
    /// It is an input or claimed already, it exists, or its folder is missing or read-only.
    pub fn claim(&mut self, path: &Path, format: &str) -> Result<Option<Target>, Failure> {
        let name = path.display().to_string();
        let overwrite = self.args.overwrite;
        let target = |place| Some(Target { place, name: name.clone(), overwrite });
        if path == Path::new("-") {
            if io::stdout().is_terminal() {
                return Err(Failure::usage("`-` would write binary data to the terminal")
                    .hint("send it on: `| other` or `> file`"));
            }
            return self.claim_once(PathBuf::from("-"), &name).map(|()| target(Place::Stdout));
        }
        // Through links: what is renamed onto a link would only replace the link.
        let found = fs::canonicalize(path);
        if let Ok(real) = &found {
            if self.inputs.iter().any(|input| is_same_file(input, real)) {
                return Err(Failure::usage(format!("`{name}` is an input; it is never written to"))
                    .hint("give the output another name"));
            }
            let kind = fs::metadata(real).map_err(|error| cannot_write(&name, &error))?.file_type();
            if kind.is_dir() {
                return Err(Failure::failed(format!("`{name}` is a folder")).hint("name a file in it"));
            }
            if !kind.is_file() {
                return Ok(target(Place::Device(real.clone())));
            }
        }
        let ending =
            path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default();
        if ending != format && OTHER_FORMATS.contains(&ending.as_str()) {
            return Err(Failure::usage(format!("`{name}` would not be {ending}: this writes {format}"))
                .hint(format!("give the output a name that ends in .{format}")));
        }
        let place = match found {
            Ok(real) => real,
            Err(_) => {
                let file = path.file_name().ok_or_else(|| {
                    Failure::failed(format!("`{name}` is not the name of a file")).hint("name a file in it")
                })?;
                let folder =
                    fs::canonicalize(folder_of(path)).map_err(|error| cannot_write(&name, &error))?;
                folder.join(file)
            }
        };
        self.claim_once(place.clone(), &name)?;
        // Not `exists`, which a link to nowhere does not.
        if fs::symlink_metadata(&place).is_ok() {
            if self.args.skip_existing {
                return Ok(None);
            }
            if !self.args.overwrite {
                return Err(exists(&name));
            }
        }
        // Tried now: hours of work should not end at a folder that cannot be written to.
        if self.writable.as_deref() != Some(folder_of(&place)) {
            beside(&place).map_err(|error| cannot_write(&name, &error))?;
            self.writable = Some(folder_of(&place).to_owned());
        }
        Ok(target(Place::File(place)))
    }

    fn claim_once(&mut self, place: PathBuf, name: &str) -> Result<(), Failure> {
        if !self.claimed.insert(place) {
            return Err(
                Failure::usage(format!("two outputs are `{name}`")).hint("give each output its own name")
            );
        }
        Ok(())
    }
}

/// The folder that outputs go into. If it was made for them and none came, it goes again.
#[derive(Debug)]
pub struct MadeFolder(Option<PathBuf>);

impl MadeFolder {
    /// Makes the folder, if it is not there.
    ///
    /// # Errors
    /// The folder it is to lie in is missing or read-only.
    pub fn new(path: &Path) -> Result<Self, Failure> {
        match fs::create_dir(path) {
            Ok(()) => Ok(Self(Some(path.to_owned()))),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && path.is_dir() => Ok(Self(None)),
            Err(error) => Err(cannot_write(&path.display().to_string(), &error)),
        }
    }
}

impl Drop for MadeFolder {
    fn drop(&mut self) {
        if let Some(path) = &self.0 {
            // Only an empty one can be removed so.
            let _ = fs::remove_dir(path);
        }
    }
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A file with no name yet in the folder where `place` will be, so that renaming never crosses a file system.
fn beside(place: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".girtin-").suffix(".part");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // What any new file gets, less the umask: not the private rights of a temporary one.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder_of(place))
}

/// Whether two names are of one file.
pub fn is_same_file(a: &Path, b: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        // Hard links, and file systems on which upper case does not matter.
        if let (Ok(a), Ok(b)) = (fs::metadata(a), fs::metadata(b)) {
            return (a.dev(), a.ino()) == (b.dev(), b.ino());
        }
    }
    a == b
}

fn exists(name: &str) -> Failure {
    Failure::new(Kind::Exists, format!("`{name}` exists"))
        .hint("add `--overwrite` to replace it, or `--skip-existing` to leave it")
}

/// What to say of a file that cannot be written.
pub fn cannot_write(name: &str, error: &io::Error) -> Failure {
    let hint = match error.kind() {
        io::ErrorKind::NotFound => "make its folder first, with `mkdir -p`",
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
            "choose a folder that you may write to"
        }
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge => {
            "make room on the disk or choose another"
        }
        io::ErrorKind::NotADirectory => "a file stands where its folder should be",
        _ => "choose another place",
    };
    Failure::failed(format!("cannot write `{name}`: {}", plain(error))).hint(hint)
}

/// What a writer of some format reports: the medium failed, or it refuses the content.
#[derive(Debug)]
pub enum WriteFault {
    /// The medium failed.
    Medium(io::Error),
    /// The content cannot be written in this format.
    Content(String),
}

impl From<io::Error> for WriteFault {
    fn from(error: io::Error) -> Self {
        Self::Medium(error)
    }
}

impl From<girtin::painting::picture::WriteError> for WriteFault {
    fn from(error: girtin::painting::picture::WriteError) -> Self {
        match error {
            girtin::painting::picture::WriteError::Write(error) => Self::Medium(error),
            other => Self::Content(other.to_string()),
        }
    }
}

impl From<girtin::painting::state_file::StateFileError> for WriteFault {
    fn from(error: girtin::painting::state_file::StateFileError) -> Self {
        match error {
            girtin::painting::state_file::StateFileError::Write(error) => Self::Medium(error),
            other => Self::Content(other.to_string()),
        }
    }
}

impl From<GirtinFileError> for WriteFault {
    fn from(error: GirtinFileError) -> Self {
        match error {
            GirtinFileError::Write(error) => Self::Medium(error),
            other => Self::Content(other.to_string()),
        }
    }
}

/// An output that is whole but does not have its name yet. Dropped, it is gone.
#[derive(Debug)]
pub struct Staged {
    file: Option<(NamedTempFile, PathBuf)>,
    name: String,
    overwrite: bool,
}

impl Target {
    /// Whether it would replace this file.
    pub fn is(&self, file: &Path) -> bool {
        matches!(&self.place, Place::File(place) if is_same_file(place, file))
    }

    /// Its name as it was given.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether it goes to the standard output.
    pub fn is_stdout(&self) -> bool {
        matches!(self.place, Place::Stdout)
    }

    /// Writes the output, not yet under its name; what goes to the standard output or a device is gone with this.
    ///
    /// # Errors
    /// The medium fails, or the content cannot be written.
    pub fn stage(
        &self,
        write: impl FnOnce(&mut dyn Write) -> Result<(), WriteFault>,
    ) -> Result<Staged, Failure> {
        let (staged, fault) = (|file| self.staged(file), |fault| self.fault(fault));
        let through = |inner: &mut dyn Write| -> Result<(), WriteFault> {
            let mut buffer = BufWriter::with_capacity(1 << 18, inner);
            write(&mut buffer)?;
            Ok(buffer.flush()?)
        };
        match &self.place {
            Place::Stdout => through(&mut io::stdout().lock()).map_err(fault).map(|()| staged(None)),
            Place::Device(path) => File::options()
                .write(true)
                .open(path)
                .map_err(WriteFault::Medium)
                .and_then(|mut file| through(&mut file))
                .map_err(fault)
                .map(|()| staged(None)),
            Place::File(path) => beside(path)
                .map_err(WriteFault::Medium)
                .and_then(|mut file| {
                    through(file.as_file_mut())?;
                    // Some file systems say only now that they are full.
                    file.as_file().sync_all()?;
                    Ok(file)
                })
                .map_err(fault)
                .map(|file| staged(Some((file, path.clone())))),
        }
    }

    /// As [`Target::stage`], for formats that are not written from front to back.
    ///
    /// # Errors
    /// As [`Target::stage`].
    pub fn stage_file(
        &self,
        write: impl FnOnce(&mut File) -> Result<(), WriteFault>,
    ) -> Result<Staged, Failure> {
        if let Place::File(path) = &self.place {
            let written = beside(path).map_err(WriteFault::Medium).and_then(|mut file| {
                write(file.as_file_mut())?;
                file.as_file().sync_all()?;
                Ok(file)
            });
            let file = written.map_err(|fault| self.fault(fault))?;
            return Ok(self.staged(Some((file, path.clone()))));
        }
        self.stage(|writer| {
            let mut file = tempfile::tempfile()?;
            write(&mut file)?;
            file.seek(SeekFrom::Start(0))?;
            Ok(io::copy(&mut file, writer).map(drop)?)
        })
    }

    fn staged(&self, file: Option<(NamedTempFile, PathBuf)>) -> Staged {
        Staged { file, name: self.name.clone(), overwrite: self.overwrite }
    }

    fn fault(&self, fault: WriteFault) -> Failure {
        match fault {
            WriteFault::Medium(error) if self.is_stdout() => Failure::stdout(&error),
            WriteFault::Medium(error) => cannot_write(&self.name, &error),
            WriteFault::Content(cause) => Failure::failed(format!("cannot write `{}`: {cause}", self.name)),
        }
    }

    /// Writes the output under its name.
    ///
    /// # Errors
    /// As [`Target::stage`] and [`Staged::commit`].
    pub fn write(
        &self,
        interrupt: &Interrupt,
        write: impl FnOnce(&mut dyn Write) -> Result<(), WriteFault>,
    ) -> Result<(), Failure> {
        let staged = self.stage(write)?;
        interrupt.check()?;
        staged.commit()
    }
}

impl Staged {
    /// Gives the output its name.
    ///
    /// # Errors
    /// Something has that name by now, or the medium fails.
    pub fn commit(self) -> Result<(), Failure> {
        let Some((file, path)) = self.file else { return Ok(()) };
        let kept = if self.overwrite { file.persist(&path) } else { file.persist_noclobber(&path) };
        match kept {
            Ok(_) => Ok(()),
            Err(fault) if fault.error.kind() == io::ErrorKind::AlreadyExists => Err(exists(&self.name)),
            Err(fault) => Err(cannot_write(&self.name, &fault.error)),
        }
    }
}

/// Writes text to the standard output.
///
/// # Errors
/// Nobody reads it, or the medium fails.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()).map_err(|error| Failure::stdout(&error))
}
