//! Everything that is written of a painting, checked before the work.

use std::path::{Path, PathBuf};

use girtin::painting::film::FilmFormat;
use girtin::painting::picture::PictureFormat;

use crate::failure::Failure;
use crate::output::{MadeFolder, Outputs, Target};
use crate::progress::TalkArgs;

use super::batch::{Naming, Writing, ending_of};
use super::c97::{Mattes, Targets};
use super::ffmpeg;

/// What is written besides the picture. Names may have `{stem}` in them, the photograph's own.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "More to write")]
pub struct MoreArgs {
    /// Write the glazes as layers that multiply, OpenRaster: Krita, GIMP and MyPaint open it
    #[arg(long, value_name = "X.ora")]
    layers: Option<PathBuf>,
    /// Write the painting itself, a document that `girtin paint` paints again at any size
    #[arg(long, value_name = "X.girtin")]
    save: Option<PathBuf>,
    /// Write a film of the washes being laid: mp4 if ffmpeg is installed, gif, or animated png
    #[arg(long, value_name = "X.mp4")]
    timelapse: Option<PathBuf>,
    /// Write a PNG after each wash and the palette into this folder, which is made if it is not there
    #[arg(long, value_name = "DIR")]
    stages: Option<PathBuf>,
}

/// How a film is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilmKind {
    /// By an installed ffmpeg.
    Ffmpeg,
    /// By Girtin.
    Own(FilmFormat),
}

/// The stages' folder.
#[derive(Debug)]
pub struct Stages {
    /// A picture after each wash.
    pub washes: Vec<Option<Target>>,
    /// The pigments.
    pub palette: Option<Target>,
    _folder: MadeFolder,
}

/// What is written of one photograph.
#[derive(Debug)]
pub struct Errand {
    /// The photograph.
    pub photo: PathBuf,
    /// How many there are.
    pub count: usize,
    /// The picture.
    pub picture: Option<(Target, PictureFormat)>,
    /// Layers.
    pub layers: Option<Target>,
    /// Document.
    pub save: Option<Target>,
    /// Film.
    pub film: Option<(Target, FilmKind)>,
    /// Stages.
    pub stages: Option<Stages>,
    /// Mattes that it is painted from.
    pub mattes: Option<Mattes>,
    /// Target glazes.
    pub targets: Option<Targets>,
    /// Folders that were made for these; after them, so that they are empty first if nothing comes of it.
    _folders: Vec<MadeFolder>,
}

impl Errand {
    /// Whether there is nothing to write.
    pub fn is_done(&self) -> bool {
        let stages = self.stages.iter().flat_map(|stages| stages.washes.iter().chain([&stages.palette]));
        let more = [&self.layers, &self.save].into_iter().chain(stages);
        let has_targets = self.targets.as_ref().is_some_and(|targets| !targets.is_done());
        let is_picture_done = self.picture.is_none() && self.film.is_none();
        is_picture_done && !has_targets && more.flatten().next().is_none()
    }

    /// Name of the picture.
    pub fn output(&self) -> Option<&str> {
        self.picture.as_ref().map(|(target, _)| target.name())
    }

    /// What is written besides the picture: what it is and its files, in the order they are asked for.
    pub fn more(&self) -> Vec<(&'static str, Vec<&str>)> {
        let stages = self.stages.iter().flat_map(|stages| stages.washes.iter().chain([&stages.palette]));
        let film = self.film.as_ref().map(|(target, _)| target.name());
        let all = [
            ("layers", Vec::from_iter(self.layers.as_ref().map(Target::name))),
            ("save", Vec::from_iter(self.save.as_ref().map(Target::name))),
            ("timelapse", Vec::from_iter(film)),
            ("stages", stages.flatten().map(Target::name).collect()),
            ("targets", self.targets.iter().flat_map(Targets::names).collect()),
        ];
        all.into_iter().filter(|(_, files)| !files.is_empty()).collect()
    }

    /// Names for it.
    pub fn naming(&self) -> Naming<'_> {
        Naming { photo: &self.photo, count: self.count }
    }
}

impl MoreArgs {
    /// Claims every output of a photograph; `washes` are laid at most.
    ///
    /// # Errors
    /// One cannot be written, or its name says another format.
    pub fn claim(
        &self,
        outputs: &mut Outputs,
        naming: &Naming<'_>,
        output: &Path,
        writing: &Writing<'_>,
        (washes, talk): (u32, TalkArgs),
    ) -> Result<Errand, Failure> {
        let path = naming.picture(output, writing.ending())?;
        let mut folders = Vec::from_iter(naming.folder_of(output, &path)?);
        let format = writing.format(&path)?;
        // What was said of the format counts for more than the name.
        let ending = ending_of(&path)
            .filter(|_| writing.format.is_none())
            .unwrap_or_else(|| name_of(format).to_owned());
        let picture = outputs.claim(&path, &ending)?.map(|target| (target, format));
        let mut claim =
            |given: &Option<PathBuf>, format: &str, what: &str| -> Result<Option<Target>, Failure> {
                let Some(given) = given else { return Ok(None) };
                let path = naming.file(given, what)?;
                folders.extend(naming.folder_of(given, &path)?);
                let ending = ending_of(&path).unwrap_or_default();
                if ending != format && !is_special(&path) {
                    return Err(Failure::usage(format!("`{}` does not end in .{format}", path.display()))
                        .hint(format!("{what} are written as .{format}")));
                }
                outputs.claim(&path, format)
            };
        let layers = claim(&self.layers, "ora", "layers")?;
        let save = claim(&self.save, "girtin", "paintings")?;
        let film = match &self.timelapse {
            Some(given) => {
                let path = naming.file(given, "the film")?;
                folders.extend(naming.folder_of(given, &path)?);
                film(outputs, &path, talk)?
            }
            None => None,
        };
        let stages = match &self.stages {
            Some(given) => {
                let folder = naming.file(given, "the stages' folder")?;
                folders.extend(naming.folder_of(given, &folder)?);
                Some(stages(outputs, &folder, washes)?)
            }
            None => None,
        };
        Ok(Errand {
            photo: naming.photo.to_owned(),
            count: naming.count,
            picture,
            layers,
            save,
            film,
            stages,
            mattes: None,
            targets: None,
            _folders: folders,
        })
    }
}

/// Whether it is the standard output or a device, whose name says nothing.
fn is_special(path: &Path) -> bool {
    path == Path::new("-") || (path.exists() && !path.is_file() && !path.is_dir())
}

fn name_of(format: PictureFormat) -> &'static str {
    match format {
        PictureFormat::Png8 | PictureFormat::Png16 => "png",
        PictureFormat::Jpeg { .. } => "jpg",
        PictureFormat::Tiff8 | PictureFormat::Tiff16 => "tif",
        PictureFormat::WebP => "webp",
    }
}

fn film(outputs: &mut Outputs, path: &Path, talk: TalkArgs) -> Result<Option<(Target, FilmKind)>, Failure> {
    let ending = ending_of(path).unwrap_or_default();
    if ending == "mp4" {
        if ffmpeg::is_there() {
            return Ok(outputs.claim(path, "mp4")?.map(|target| (target, FilmKind::Ffmpeg)));
        }
        // Not the picture's own name, which a film may share.
        let other = path.with_extension("timelapse.png");
        talk.say(&format!(
            "girtin: ffmpeg is not installed: the film is written as an animated PNG, `{}`",
            other.display()
        ));
        let target = outputs.claim(&other, "png")?;
        return Ok(target.map(|target| (target, FilmKind::Own(FilmFormat::Apng))));
    }
    let Some(format) = FilmFormat::of_extension(&ending) else {
        return Err(Failure::usage(format!("`{}` is no film that is written here", path.display()))
            .hint("end its name in .mp4, .gif or .png"));
    };
    Ok(outputs.claim(path, &ending)?.map(|target| (target, FilmKind::Own(format))))
}

fn stages(outputs: &mut Outputs, folder: &Path, washes: u32) -> Result<Stages, Failure> {
    let made = MadeFolder::new(folder)?;
    let mut claim = |name: String| outputs.claim(&folder.join(name), "png");
    let numbers = 1..=washes;
    let washes = numbers.map(|number| claim(format!("{number:02}-wash.png"))).collect::<Result<_, _>>()?;
    Ok(Stages { washes, palette: claim("palette.png".to_owned())?, _folder: made })
}
