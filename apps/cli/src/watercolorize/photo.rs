//! The photograph and the masks that lie over it.

use std::ffi::OsStr;
use std::io::{ErrorKind, SeekFrom};
use std::path::{Path, PathBuf};

use girtin::grid::Raster;
use girtin::grid::resize::resized;
use girtin::painting::picture::{PictureError, PictureLimits, read_mask, read_photo, read_size};
use girtin::watercolorize::PAPER;

use crate::failure::Failure;
use crate::input::{self, Source};
use crate::progress::TalkArgs;

use super::batch::Naming;

/// Longest side of a painting whose size nobody asked for, pixels.
pub const LONGEST: u32 = 6000;

/// Masks over the photograph.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Masks")]
pub struct MaskArgs {
    /// Keep paper bare where this picture is white, over the photograph and of its proportions
    #[arg(long, value_name = "MASK")]
    pub reserve: Option<PathBuf>,
    /// Draw exactly where this picture is white and freely where it is black, instead of where the eye rests
    #[arg(long, value_name = "MASK")]
    pub detail_map: Option<PathBuf>,
}

impl MaskArgs {
    /// The files that are read for a photograph.
    pub fn files(&self, naming: &Naming<'_>) -> Vec<PathBuf> {
        let given = [&self.reserve, &self.detail_map].into_iter().flatten();
        given.map(|path| naming.mask(path)).collect()
    }

    /// The masks of a photograph of this size: what is reserved, and where detail is.
    ///
    /// # Errors
    /// One cannot be read, has other proportions, or reserves nothing.
    pub fn read(&self, naming: &Naming<'_>, size: [usize; 2]) -> Result<[Option<Raster<f32>>; 2], Failure> {
        let read = |path: &Option<PathBuf>| -> Result<Option<Raster<f32>>, Failure> {
            path.as_ref().map(|path| mask(&naming.mask(path), size)).transpose()
        };
        let [reserve, detail] = [read(&self.reserve)?, read(&self.detail_map)?];
        if let (Some(mask), Some(path)) = (&reserve, &self.reserve)
            && mask.as_slice().iter().all(|value| *value < 0.5)
        {
            let name = input::name_of(&naming.mask(path));
            return Err(Failure::input(format!(
                "{name} is empty: nothing of it is white, so nothing is reserved"
            ))
            .hint("paint white what is to stay bare, or leave `--reserve` out"));
        }
        Ok([reserve, detail])
    }
}

/// Reads a mask, which is of the photograph's proportions.
///
/// # Errors
/// It cannot be read, or has other proportions.
pub fn mask(path: &Path, [width, height]: [usize; 2]) -> Result<Raster<f32>, Failure> {
    let mask = input::picture(path, read_mask)?;
    // As large as the photograph, a pixel more or less, once its long edge is.
    let found = [mask.width(), mask.height()].map(|side| side as f64);
    let wanted = [width, height].map(|side| side as f64);
    let scale = wanted[0].max(wanted[1]) / found[0].max(found[1]);
    let is_alike = (0..2).all(|side| (found[side] * scale - wanted[side]).abs() <= scale.max(1.0));
    if !is_alike {
        let message = format!(
            "{} has {} × {} pixels, which are not the proportions of the photograph's {width} × {height}",
            input::name_of(path),
            mask.width(),
            mask.height()
        );
        return Err(Failure::input(message).hint("make it as large as the photograph, upright"));
    }
    Ok(mask)
}

/// How a photograph is read.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// Most pixels.
    pub most: u64,
    /// Long edge of the painting that is asked for.
    pub size: Option<u32>,
    /// Whether it is only a preview.
    pub is_preview: bool,
    /// Long edge that is looked at in planning.
    pub plan: u32,
}

/// Long edge of a preview, pixels.
pub const PREVIEW: u32 = 640;

/// A photograph that is open.
pub struct Opened {
    source: Box<dyn Source>,
    path: PathBuf,
    /// Columns and rows, upright.
    pub size: [usize; 2],
    /// Long edge of its painting.
    pub long_edge: u32,
    /// A number that tells photographs apart.
    pub fingerprint: u32,
    reading: Reading,
}

impl std::fmt::Debug for Opened {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Opened").field("path", &self.path).field("size", &self.size).finish_non_exhaustive()
    }
}

impl Reading {
    fn limits(&self) -> PictureLimits {
        PictureLimits::of_photo(self.most)
    }

    /// Opens a photograph and looks how large it is.
    ///
    /// # Errors
    /// There is no such file, or it is no picture that is read.
    pub fn open(self, path: &Path) -> Result<Opened, Failure> {
        let mut source = input::open(path)?;
        let size = read_size(&mut *source, ending(path), &self.limits());
        let (width, height) = size.map_err(|error| input::no_photo(path, &error))?;
        let fingerprint = fingerprint(&mut source);
        let fingerprint = fingerprint.map_err(|error| input::no_photo(path, &PictureError::Read(error)))?;
        let longest = width.max(height);
        let long_edge = match self.size {
            Some(size) => size,
            None if self.is_preview => longest.min(PREVIEW),
            None => longest.min(LONGEST),
        };
        let size = [width as usize, height as usize];
        Ok(Opened { source, path: path.to_owned(), size, long_edge, fingerprint, reading: self })
    }
}

/// A number made of all bytes, which are to be read again.
fn fingerprint(source: &mut dyn Source) -> std::io::Result<u32> {
    let mut bytes = vec![0; 1 << 16];
    // Fowler, Noll and Vo's hash.
    let mut folded = 0x811c_9dc5_u32;
    source.seek(SeekFrom::Start(0))?;
    loop {
        match source.read(&mut bytes) {
            Ok(0) => break,
            Ok(read) => {
                let fold = |folded: u32, &byte: &u8| (folded ^ u32::from(byte)).wrapping_mul(0x0100_0193);
                folded = bytes[..read].iter().fold(folded, fold);
            }
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    source.seek(SeekFrom::Start(0))?;
    Ok(folded)
}

impl Opened {
    /// The photograph as light, no larger than its planning needs.
    ///
    /// # Errors
    /// It is damaged, or there is no memory.
    pub fn read(self, talk: TalkArgs) -> Result<Raster<[f32; 3]>, Failure> {
        let limits = self.reading.limits();
        let paper = PAPER.to_linear();
        let photo = read_photo(self.source, ending(&self.path), &limits, paper);
        let photo = photo.map_err(|error| input::no_photo(&self.path, &error))?;
        for note in &photo.notes {
            talk.say(&format!("girtin: {}: {note}", input::name_of(&self.path)));
        }
        // Lines are looked for at twice the planning size.
        let most = 2 * self.reading.plan as usize;
        let (width, height) = (photo.pixels.width(), photo.pixels.height());
        let longest = width.max(height);
        if longest <= most {
            return Ok(photo.pixels);
        }
        let small = |side: usize| (side as f64 * most as f64 / longest as f64).round().max(1.0) as usize;
        Ok(resized(&photo.pixels, small(width), small(height)))
    }
}

fn ending(path: &Path) -> Option<&str> {
    path.extension().and_then(OsStr::to_str)
}
