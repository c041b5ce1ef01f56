//! Which photographs are painted, and where the paintings go.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use girtin::painting::picture::PictureFormat;

use crate::failure::{Failure, plain};
use crate::output::MadeFolder;

/// What an output's name has in place of the photograph's.
const STEM: &str = "{stem}";

/// Endings of photographs that are looked for in folders.
const PHOTOS: [&str; 8] = ["png", "jpg", "jpeg", "tif", "tiff", "webp", "gif", "bmp"];

/// Endings of photographs that are not read; a folder that has some must not look done without them.
const OTHERS: [&str; 14] =
    ["heic", "heif", "avif", "jxl", "dng", "cr2", "cr3", "nef", "arw", "raf", "orf", "rw2", "pef", "psd"];

fn is_photo(ending: &str) -> bool {
    PHOTOS.contains(&ending) || OTHERS.contains(&ending)
}

/// The photographs that are meant: files, all of a folder, what a pattern matches, and `-`; in the order given, those
/// of a folder or pattern by name, none twice.
///
/// # Errors
/// A folder cannot be listed or has none, or a pattern is wrong or matches nothing.
pub fn photographs(given: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut found: Vec<PathBuf> = Vec::new();
    for path in given {
        let some = if path.is_dir() {
            of_folder(path)?
        } else if is_pattern(path) {
            of_pattern(path)?
        } else {
            vec![path.clone()]
        };
        for path in some {
            if !found.contains(&path) {
                found.push(path);
            }
        }
    }
    Ok(found)
}

fn of_folder(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let cannot = |error: std::io::Error| {
        Failure::input(format!("cannot list `{}`: {}", folder.display(), plain(&error)))
            .hint("its rights may not let you read it")
    };
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(cannot)? {
        let path = entry.map_err(cannot)?.path();
        let is_hidden = path.file_name().is_some_and(|name| name.as_encoded_bytes().starts_with(b"."));
        let ending = ending_of(&path);
        if !is_hidden && path.is_file() && ending.is_some_and(|ending| is_photo(&ending)) {
            found.push(path);
        }
    }
    if found.is_empty() {
        return Err(Failure::input(format!("`{}` has no photographs", folder.display()))
            .hint(format!("their names end in {}", PHOTOS.join(", "))));
    }
    found.sort();
    Ok(found)
}

/// Whether a name is to be expanded: a file that is really called so is itself.
fn is_pattern(path: &Path) -> bool {
    let has_wildcard = path.to_str().is_some_and(|text| text.contains(['*', '?', '[']));
    has_wildcard && fs::symlink_metadata(path).is_err()
}

fn of_pattern(path: &Path) -> Result<Vec<PathBuf>, Failure> {
    let text = path.to_str().unwrap_or_default();
    // As shells do it: a name that begins with a dot is hidden.
    let manner = glob::MatchOptions { require_literal_leading_dot: true, ..glob::MatchOptions::default() };
    let matches = glob::glob_with(text, manner).map_err(|error| {
        Failure::usage(format!("`{text}` is no pattern: {}", error.msg)).hint("such as `photos/*.jpg`")
    })?;
    // What cannot be listed matches nothing.
    let found: Vec<PathBuf> = matches.filter_map(Result::ok).filter(|path| path.is_file()).collect();
    if found.is_empty() {
        return Err(
            Failure::input(format!("no file matches `{text}`")).hint("look at the spelling and the folder")
        );
    }
    Ok(found)
}

/// What a file's name ends with, in small letters and without the dot.
pub fn ending_of(path: &Path) -> Option<String> {
    path.extension().map(|ending| ending.to_string_lossy().to_lowercase())
}

/// Refuses a name with a place in braces that is not the photograph's: it would be taken as it is, every time.
///
/// # Errors
/// It has one.
pub fn check_places(text: &str) -> Result<(), Failure> {
    let is_word =
        |word: &str| !word.is_empty() && word.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    let mut places = text.split('{').skip(1).filter_map(|rest| Some(rest.split_once('}')?.0));
    match places.find(|place| is_word(place) && *place != &STEM[1..STEM.len() - 1]) {
        Some(place) => Err(Failure::usage(format!("`{{{place}}}` in `{text}` stands for nothing"))
            .hint("`{stem}` stands for the photograph's name without folder and ending")),
        None => Ok(()),
    }
}

/// The names of outputs for one photograph of `count`.
#[derive(Clone, Copy, Debug)]
pub struct Naming<'a> {
    /// The photograph.
    pub photo: &'a Path,
    /// How many photographs there are.
    pub count: usize,
}

impl Naming<'_> {
    fn stem(&self) -> &OsStr {
        if self.photo == Path::new("-") {
            return OsStr::new("painting");
        }
        self.photo.file_stem().unwrap_or(OsStr::new("painting"))
    }

    /// The file of an output: a name with the photograph's in it, or any name if there is one photograph only. `what`
    /// is what it is called on the command line.
    ///
    /// # Errors
    /// There are several photographs and one name.
    pub fn file(&self, template: &Path, what: &str) -> Result<PathBuf, Failure> {
        let text = template.as_os_str().to_string_lossy();
        check_places(&text)?;
        if !text.contains(STEM) {
            if self.count > 1 {
                let message = format!("{} photographs cannot all be {what} `{text}`", self.count);
                return Err(Failure::usage(message).hint(
                    "put `{stem}` into its name, such as `out/{stem}.png`, or name a folder that is there",
                ));
            }
            return Ok(template.to_owned());
        }
        match self.stem().to_str() {
            Some(stem) => Ok(PathBuf::from(text.replace(STEM, stem))),
            None => Err(Failure::usage(format!("the name of `{}` is no text", self.photo.display()))
                .hint("give the painting a name without `{stem}`")),
        }
    }

    /// Makes the folder of a file whose name has the photograph's in it, if it is not there: so many are not named one by
    /// one, and nothing else is meant.
    ///
    /// # Errors
    /// The folder that it is to lie in is missing or read-only.
    pub fn folder_of(&self, template: &Path, file: &Path) -> Result<Option<MadeFolder>, Failure> {
        let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
        let is_template = template.as_os_str().to_string_lossy().contains(STEM);
        folder.filter(|_| is_template).map(MadeFolder::new).transpose()
    }

    /// A mask, whose name may have the photograph's in it.
    pub fn mask(&self, template: &Path) -> PathBuf {
        match (template.to_str(), self.stem().to_str()) {
            (Some(text), Some(stem)) => PathBuf::from(text.replace(STEM, stem)),
            _ => template.to_owned(),
        }
    }

    /// The picture: as [`Naming::file`], or in a folder under the photograph's name.
    ///
    /// # Errors
    /// As [`Naming::file`], or the folder is not there.
    pub fn picture(&self, given: &Path, ending: &str) -> Result<PathBuf, Failure> {
        if given.is_dir() {
            let mut name = self.stem().to_owned();
            name.push(".");
            name.push(ending);
            return Ok(given.join(name));
        }
        if given.as_os_str().as_encoded_bytes().ends_with(b"/") {
            let message = format!("there is no folder `{}`", given.display());
            return Err(Failure::failed(message).hint("make it first, with `mkdir -p`"));
        }
        self.file(given, "the output")
    }
}

/// How a picture is to be written, whatever its name.
#[derive(Clone, Copy, Debug)]
pub struct Writing<'a> {
    /// The format's ending, if it is said.
    pub format: Option<&'a str>,
    /// Bits of a channel.
    pub bits: u8,
    /// Quality of a JPEG.
    pub quality: Option<u8>,
}

impl Writing<'_> {
    /// The ending of pictures in a folder.
    pub fn ending(&self) -> &str {
        self.format.unwrap_or("png")
    }

    /// The format of a picture, from what is said, else its name.
    ///
    /// # Errors
    /// The name tells none, or it has not so many bits, or no quality.
    pub fn format(&self, path: &Path) -> Result<PictureFormat, Failure> {
        let name = path.display();
        let is_nameless = path == Path::new("-") || (path.exists() && !path.is_file());
        let told = ending_of(path).filter(|_| !is_nameless);
        let ending = match (self.format, told) {
            (Some(format), _) => format.to_owned(),
            (None, None) if is_nameless => "png".to_owned(),
            (None, told) => told.unwrap_or_default(),
        };
        let format = PictureFormat::of_extension(&ending, self.bits == 16);
        let format = format.ok_or_else(|| match PictureFormat::of_extension(&ending, false) {
            Some(_) => Failure::usage(format!("`{name}` cannot have 16 bits: {ending} has 8"))
                .hint("write PNG or TIFF, or leave `--bits` out"),
            None if ending.is_empty() => Failure::usage(format!(
                "`{name}` does not say which format it is to be"
            ))
            .hint(format!("end it in one of {}, or give `--format`", PictureFormat::ENDINGS.join(", "))),
            None => {
                Failure::usage(format!("`{name}` cannot be written: {ending} is no format of pictures here"))
                    .hint(format!("end it in one of {}", PictureFormat::ENDINGS.join(", ")))
            }
        })?;
        match (format, self.quality) {
            (PictureFormat::Jpeg { .. }, Some(quality)) => Ok(PictureFormat::Jpeg { quality }),
            (_, Some(_)) => Err(Failure::usage(format!("`--quality` is JPEG's, and `{name}` is none"))
                .hint("leave `--quality` out, or end the name in .jpg")),
            (format, None) => Ok(format),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_are_named_for_their_photograph() {
        let naming = |count| Naming { photo: Path::new("photos/cat.b.jpg"), count };
        let file = |count, text: &str| naming(count).file(Path::new(text), "the output");
        assert_eq!(file(2, "out/{stem}.png").unwrap(), Path::new("out/cat.b.png"));
        assert_eq!(file(1, "out.png").unwrap(), Path::new("out.png"));
        assert!(file(2, "out.png").is_err());
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(naming(2).picture(folder.path(), "tif").unwrap(), folder.path().join("cat.b.tif"));
        for text in ["out/{name}.png", "{stem}-{n}.png", "{}/{STEM}.png"] {
            assert!(file(1, text).is_err() && file(2, text).is_err(), "{text}");
        }
        assert_eq!(file(1, "{a b}{}.png").unwrap(), Path::new("{a b}{}.png"));
        let piped = Naming { photo: Path::new("-"), count: 1 };
        assert_eq!(piped.file(Path::new("{stem}.png"), "the output").unwrap(), Path::new("painting.png"));
    }

    #[test]
    fn formats_come_from_names() {
        let plain = Writing { format: None, bits: 8, quality: None };
        let deep = Writing { bits: 16, ..plain };
        assert_eq!(
            plain.format(Path::new("A.JPEG")).unwrap(),
            PictureFormat::Jpeg { quality: PictureFormat::QUALITY }
        );
        assert_eq!(deep.format(Path::new("a.tif")).unwrap(), PictureFormat::Tiff16);
        assert_eq!(plain.format(Path::new("-")).unwrap(), PictureFormat::Png8);
        let jpeg = Writing { format: Some("jpg"), quality: Some(50), ..plain };
        assert_eq!(jpeg.format(Path::new("-")).unwrap(), PictureFormat::Jpeg { quality: 50 });
        for (writing, bad) in
            [(plain, "a"), (plain, "a.gif"), (deep, "a.jpg"), (deep, "a.webp"), (plain, "a.png/")]
        {
            assert!(writing.format(Path::new(bad)).is_err() || bad.ends_with('/'), "{bad}");
        }
        assert!(Writing { quality: Some(3), ..plain }.format(Path::new("a.png")).is_err());
    }

    #[test]
    fn patterns_and_folders_are_expanded_in_order_and_once() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b.jpg", "a.png", "c[1].jpg", "notes.txt", ".hidden.jpg"] {
            fs::write(folder.path().join(name), b"x").unwrap();
        }
        let path = |name: &str| folder.path().join(name);
        let all = photographs(&[folder.path().to_owned()]).unwrap();
        assert_eq!(all, [path("a.png"), path("b.jpg"), path("c[1].jpg")]);
        assert_eq!(photographs(&[path("*.jpg"), path("b.jpg")]).unwrap(), [path("b.jpg"), path("c[1].jpg")]);
        assert_eq!(photographs(&[path("c[1].jpg")]).unwrap(), [path("c[1].jpg")]);
        assert_eq!(photographs(&[path("none.jpg")]).unwrap(), [path("none.jpg")], "said when it is opened");
        assert!(photographs(&[path("*.gif")]).is_err());
        assert!(photographs(&[path("[")]).is_err());
    }
}
