//! A finished painting is written in every form that was asked for.

use std::cell::Cell;
use std::fs::File;
use std::io;

use girtin::grid::Raster;
use girtin::optics::LinearRgb;
use girtin::painting::film::{Film, FilmFormat, FilmPlan};
use girtin::painting::girtin_file::{GirtinFile, PaintedRecord, thumbnail_png};
use girtin::painting::ora::{Composite, Difference, GlazeLayers, OraFile, OraLayer};
use girtin::painting::picture::{PictureFormat, PictureMeta, write_picture, write_png};
use girtin::painting::timelapse::FRAMES_PER_SECOND;
use girtin::painting::{Stock, Timelapse, WaterDetail, composite};
use girtin::watercolorize::Painting;

use crate::arguments::PictureArgs;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::{Staged, Target, WriteFault};
use crate::pigments::chart;
use crate::progress::Stages as Progress;

use super::ffmpeg::Mp4;
use super::outputs::{Errand, FilmKind, Stages};

/// Long edge of a film, pixels.
const FILM: usize = 960;

/// A painting, and what is needed to write it.
pub struct Delivery<'a> {
    pub painting: &'a Painting,
    pub stock: &'a Stock,
    pub picture: PictureArgs,
    pub interrupt: &'a Interrupt,
    pub progress: &'a Progress,
    /// How much of the whole is done before it is developed.
    pub done: f64,
    /// How many pictures were developed, and how many will be.
    pub developed: Cell<usize>,
    pub developments: usize,
}

/// What was written, not yet under its name.
#[derive(Debug, Default)]
pub struct Delivered {
    pub staged: Vec<Staged>,
    /// How far layers are from the painting.
    pub difference: Option<Difference>,
}

impl Delivery<'_> {
    /// How many pictures are developed for an errand, of a painting of so many glazes.
    pub fn developments_for(errand: &Errand, glazes: usize) -> usize {
        let washes = if errand.layers.is_some() || errand.stages.is_some() { glazes } else { 0 };
        let has_two = errand.picture.as_ref().is_some_and(|(_, format)| is_deep(*format))
            && (washes > 0 || errand.save.is_some());
        1 + washes + usize::from(has_two) + usize::from(errand.film.is_some())
    }

    /// Writes all of it but the document.
    ///
    /// # Errors
    /// An output cannot be written, or it was interrupted.
    pub fn write(&self, errand: &Errand) -> Result<Delivered, Failure> {
        let mut delivered = Delivered::default();
        let glazes = self.painting.painted.glazes.len();
        let deep = errand.picture.as_ref().filter(|(_, format)| is_deep(*format));
        if let Some((target, format)) = deep {
            let picture = self.developed(glazes, |color| {
                color.to_srgb().0.map(|value| (value.clamp(0.0, 1.0) * 65535.0 + 0.5) as u16)
            })?;
            self.say("writing the picture");
            delivered
                .staged
                .push(target.stage(|writer| Ok(write_picture(writer, &picture, *format, &self.meta())?))?);
        }
        let shallow = errand.picture.as_ref().filter(|(_, format)| !is_deep(*format));
        if shallow.is_some() || errand.layers.is_some() || errand.save.is_some() || errand.stages.is_some() {
            let picture = self.developed(glazes, bytes)?;
            if let Some((target, format)) = shallow {
                self.say("writing the picture");
                delivered.staged.push(
                    target.stage(|writer| Ok(write_picture(writer, &picture, *format, &self.meta())?))?,
                );
            }
            self.write_washes(errand, &picture, &mut delivered)?;
            if let Some(target) = &errand.save {
                self.say("writing the document");
                delivered.staged.push(self.save(target, &picture)?);
            }
        }
        if let Some((target, kind)) = &errand.film {
            delivered.staged.push(self.film(target, *kind)?);
        }
        self.interrupt.check()?;
        Ok(delivered)
    }

    /// The picture after so many glazes.
    ///
    /// # Errors
    /// It was interrupted.
    pub fn developed<T: Copy + Send>(
        &self,
        glazes: usize,
        encode: impl Fn(LinearRgb) -> T + Sync,
    ) -> Result<Raster<T>, Failure> {
        let goes_on = |part: f64| self.goes_on("developing the picture", part);
        let developed = self.painting.painted.development_of(glazes).encoded_while(encode, goes_on);
        self.developed.set(self.developed.get() + 1);
        developed.ok_or_else(|| self.interrupt.failure())
    }

    /// Tells that so much of the next picture is developed, and whether it is to go on.
    fn goes_on(&self, stage: &str, part: f64) -> bool {
        self.progress.at(stage, self.part(part));
        self.interrupt.check().is_ok()
    }

    fn part(&self, next: f64) -> f64 {
        let part = (self.developed.get() as f64 + next) / self.developments.max(1) as f64;
        self.done + (1.0 - self.done) * part.min(1.0)
    }

    fn say(&self, stage: &str) {
        self.progress.at(stage, self.part(0.0));
    }

    /// What the picture says of itself.
    pub fn meta(&self) -> PictureMeta {
        let document = &self.painting.document;
        let words = [
            ("Seed", document.sheet.seed.to_string()),
            ("Document", format!("{:016x}", document.fingerprint(&self.painting.maps))),
        ];
        self.picture.meta(Some(document.sheet.pixels_per_mm), &words)
    }

    /// Stages and layers: the picture after each wash.
    fn write_washes(
        &self,
        errand: &Errand,
        picture: &Raster<[u8; 3]>,
        delivered: &mut Delivered,
    ) -> Result<(), Failure> {
        let count = self.painting.painted.glazes.len();
        let mut washes = Vec::new();
        if errand.layers.is_some() || errand.stages.is_some() {
            for glazes in 0..count {
                washes.push(self.developed(glazes, bytes)?);
            }
            washes.push(picture.clone());
        }
        if let Some(stages) = &errand.stages {
            self.say("writing the stages");
            self.write_stages(stages, &washes, delivered)?;
        }
        if let Some(target) = &errand.layers {
            self.say("writing the layers");
            let mut difference = Difference::default();
            let staged = target.stage_file(|file| {
                difference = self.write_layers(file, &mut washes)?;
                Ok(())
            })?;
            delivered.staged.push(staged);
            delivered.difference = Some(difference);
        }
        Ok(())
    }

    fn write_stages(
        &self,
        stages: &Stages,
        washes: &[Raster<[u8; 3]>],
        delivered: &mut Delivered,
    ) -> Result<(), Failure> {
        for (target, picture) in stages.washes.iter().zip(washes.iter().skip(1)) {
            let Some(target) = target else { continue };
            delivered.staged.push(target.stage(|writer| Ok(write_png(writer, picture, &self.meta())?))?);
            self.interrupt.check()?;
        }
        if let Some(target) = &stages.palette {
            let glazes = self.painting.document.glazes.iter();
            let mut names: Vec<&String> = Vec::new();
            for name in glazes.flat_map(|glaze| &glaze.pigments) {
                if !names.contains(&name) {
                    names.push(name);
                }
            }
            let pigments = names.iter().filter_map(|name| self.stock.pigments.get(name).ok());
            let swatches = composite::encode(&chart(&pigments.collect::<Vec<_>>()));
            let meta = self.picture.meta(None, &[]);
            delivered.staged.push(target.stage(|writer| Ok(write_png(writer, &swatches, &meta)?))?);
        }
        Ok(())
    }

    fn write_layers(
        &self,
        file: &mut File,
        washes: &mut [Raster<[u8; 3]>],
    ) -> Result<Difference, WriteFault> {
        GlazeLayers::lighten(washes);
        let [Some(paper), Some(merged)] = [washes.first(), washes.last()] else {
            return Ok(Difference::default());
        };
        let size = (paper.width(), paper.height());
        let mut ora = OraFile::begin(file, size, Some(self.painting.document.sheet.pixels_per_mm))?;
        let opaque = paper.map(|[r, g, b]| [r, g, b, 255]);
        ora.layer(&OraLayer { name: "paper", pixels: &opaque, composite: Composite::Over, opacity: 1.0 })?;
        let mut layers = GlazeLayers::new(paper.clone());
        for (glaze, after) in self.painting.document.glazes.iter().zip(&washes[1..]) {
            let name = format!("{}: {}", glaze.name, glaze.pigments.join(", "));
            let (name, pixels) = (name.as_str(), &layers.lay(after));
            ora.layer(&OraLayer { name, pixels, composite: Composite::Multiply, opacity: 1.0 })?;
        }
        ora.end(merged)?;
        Ok(layers.difference(merged))
    }

    /// The painting as a file that stands alone.
    fn save(&self, target: &Target, picture: &Raster<[u8; 3]>) -> Result<Staged, Failure> {
        let mut merged = Vec::new();
        let pictures = write_png(&mut merged, picture, &self.meta()).and_then(|()| thumbnail_png(picture));
        let thumbnail = pictures.map_err(Failure::failed)?;
        let glazes = self.painting.painted.glazes.iter();
        let balances = glazes.map(|glaze| glaze.pigments.clone()).collect();
        let file = GirtinFile {
            document: self.painting.document.clone(),
            maps: self.painting.maps.clone(),
            stock: self.stock.clone(),
            painted: Some(PaintedRecord { water: WaterDetail::Full, balances, merged, thumbnail }),
        };
        target.stage(|writer| Ok(file.write(writer)?))
    }

    fn film(&self, target: &Target, kind: FilmKind) -> Result<Staged, Failure> {
        let Painting { document, maps, painted } = self.painting;
        let goes_on = |part: f64| self.goes_on("developing the film", part);
        let film = Timelapse::new(document, painted, self.stock, maps, FILM, goes_on);
        let film = film.map_err(|error| Failure::failed(error).hint("leave `--timelapse` out"))?;
        let film = film.ok_or_else(|| self.interrupt.failure())?;
        self.developed.set(self.developed.get() + 1);
        self.say("writing the film");
        let staged = match kind {
            FilmKind::Own(format) => target.stage(|writer| self.write_film(writer, &film, format)),
            FilmKind::Ffmpeg => target.stage(|writer| {
                let file = tempfile::Builder::new().prefix("girtin-").suffix(".mp4").tempfile()?;
                let mut mp4 = Mp4::begin(file.path(), film.size(), FRAMES_PER_SECOND)?;
                // What it complains of is said at its end.
                let _ = self.frames(&film, |frame| Ok(mp4.frame(frame)?));
                mp4.end().map_err(|error| WriteFault::Content(error.to_string()))?;
                Ok(io::copy(&mut file.reopen()?, writer).map(drop)?)
            }),
        };
        self.interrupt.check()?;
        staged
    }

    fn write_film(
        &self,
        writer: &mut dyn io::Write,
        film: &Timelapse,
        format: FilmFormat,
    ) -> Result<(), WriteFault> {
        let document = &self.painting.document;
        let words = [("Seed", document.sheet.seed.to_string())];
        let meta = self.picture.meta(None, &words);
        let (size, frames) = (film.size(), film.frames());
        let plan = FilmPlan { size, frames, frames_per_second: FRAMES_PER_SECOND, format, meta };
        let mut file = Film::begin(writer, plan)?;
        self.frames(film, |frame| Ok(file.frame(frame)?))?;
        Ok(file.end()?)
    }

    fn frames(
        &self,
        film: &Timelapse,
        mut write: impl FnMut(&Raster<[u8; 3]>) -> Result<(), WriteFault>,
    ) -> Result<(), WriteFault> {
        for number in 0..film.frames() {
            if self.interrupt.check().is_err() {
                return Err(WriteFault::Content("interrupted".to_owned()));
            }
            write(&film.frame(number))?;
        }
        Ok(())
    }
}

fn is_deep(format: PictureFormat) -> bool {
    matches!(format, PictureFormat::Png16 | PictureFormat::Tiff16)
}

/// A color as it is shown.
pub fn bytes(color: LinearRgb) -> [u8; 3] {
    color.to_srgb().to_bytes()
}
