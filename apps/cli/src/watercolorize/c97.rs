//! The method of Curtis et al. 1997, §6.2: mattes, and an ordered list of pigments for each.

use std::fs;
use std::path::{Path, PathBuf};

use girtin::grid::Raster;
use girtin::optics::LinearRgb;
use girtin::painting::document::SheetSettings;
use girtin::painting::map_file::write_stored;
use girtin::painting::{PaintConfig, PaintError, StoredMap};
use girtin::params::hint_for;
use girtin::wash::RunError;
use girtin::watercolorize::Painting;
use girtin::watercolorize::c97::{
    C97Config, C97Error, C97Painting, C97Request, GlazesFile, Lift, watercolorize_c97,
};
use girtin::watercolorize::mattes::Matte;
use girtin::watercolorize::mount::Mount;

use crate::failure::Failure;
use crate::input;
use crate::output::{MadeFolder, Outputs, Staged, Target, is_same_file};
use crate::progress::Stages as Progress;

use super::asked::Recipe;
use super::batch::{Naming, ending_of};
use super::photo::mask;
use super::work::{Material, Work};

/// Options of the method.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "From mattes, as in Curtis et al. 1997")]
pub struct C97Args {
    /// Folder of mattes: gray pictures, white where the region is, of the photograph's proportions; see `girtin mattes`
    #[arg(long, value_name = "DIR", requires = "glazes", conflicts_with_all = ["preset", "palette", "contact_sheet", "stages", "reserve", "detail_map", "wetness", "washes"])]
    pub mattes: Option<PathBuf>,
    /// What each matte is painted with, from the paper up: TOML with `format = 1`, and `[[matte]]` with `name` and `pigments`
    #[arg(long, value_name = "FILE", requires = "mattes")]
    pub glazes: Option<PathBuf>,
    /// Lift paint where this matte is white, in the end; may be repeated
    #[arg(long, value_name = "MATTE", requires = "mattes")]
    pub lift: Vec<PathBuf>,
    /// Write how much of each pigment was wanted where, as gray pictures of 16 bits, into this folder
    #[arg(long, value_name = "DIR", requires = "mattes")]
    targets: Option<PathBuf>,
}

/// Part of the paint that is lifted where a matte is white.
const LIFTED: f64 = 0.8;

/// Thickness that is white in the picture of a target.
const THICKEST: f32 = 4.0;

/// What a matte's file may end in.
const ENDINGS: [&str; 4] = ["png", "tif", "tiff", "webp"];

/// Mattes, and what they are painted with.
#[derive(Clone, Debug)]
pub struct Mattes {
    glazes: GlazesFile,
    /// Name and file of each.
    files: Vec<(String, PathBuf)>,
    /// Files of its folder that nothing is painted from.
    unused: Vec<PathBuf>,
}

/// Where targets go.
#[derive(Debug)]
pub struct Targets {
    targets: Vec<(String, Option<Target>)>,
    // In this order: the inner one is to go first.
    _folder: MadeFolder,
    _around: Option<MadeFolder>,
}

impl C97Args {
    /// Files that are read for a photograph.
    pub fn files(&self, naming: &Naming<'_>) -> Vec<PathBuf> {
        let folder = self.mattes.as_ref().and_then(|folder| fs::read_dir(naming.mask(folder)).ok());
        let mattes = folder.into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()));
        mattes.chain(self.glazes.clone()).chain(self.lift.iter().map(|path| naming.mask(path))).collect()
    }

    /// What is asked for, if anything; pictures are not read yet.
    ///
    /// # Errors
    /// The file of glazes is wrong, or a matte that it names is not there.
    pub fn read(
        &self,
        naming: &Naming<'_>,
        stock: &girtin::painting::Stock,
    ) -> Result<Option<Mattes>, Failure> {
        let (Some(folder), Some(file)) = (&self.mattes, &self.glazes) else { return Ok(None) };
        let mut glazes = GlazesFile::from_toml(&file.display().to_string(), &input::read_text(file)?, stock)?;
        let folder = naming.mask(folder);
        let known = mattes_of(&folder)?;
        let mut files = Vec::new();
        for name in glazes.matte_names() {
            let found = known.iter().find(|(known, _)| known == name);
            files.push(found.cloned().ok_or_else(|| {
                let names: Vec<&str> = known.iter().map(|(name, _)| name.as_str()).collect();
                Failure::input(format!("`{}` has no matte `{name}`", folder.display()))
                    .hint(hint_for(name, &names))
            })?);
        }
        for path in &self.lift {
            let path = naming.mask(path);
            let name = format!("lift-{}-{}", glazes.lifts.len() + 1, stem(&path));
            glazes.lifts.push(Lift { name: name.clone(), fraction: LIFTED });
            files.push((name, path));
        }
        let is_used = |path: &Path| files.iter().any(|(_, used)| is_same_file(used, path));
        let unused = known.into_iter().map(|(_, path)| path).filter(|path| !is_used(path)).collect();
        Ok(Some(Mattes { glazes, files, unused }))
    }

    /// Claims a picture for every target.
    ///
    /// # Errors
    /// One cannot be written.
    pub fn claim(
        &self,
        outputs: &mut Outputs,
        naming: &Naming<'_>,
        mattes: Option<&Mattes>,
    ) -> Result<Option<Targets>, Failure> {
        let (Some(folder), Some(mattes)) = (&self.targets, mattes) else { return Ok(None) };
        let given = folder;
        let folder = naming.file(given, "the targets' folder")?;
        let around = naming.folder_of(given, &folder)?;
        let made = MadeFolder::new(&folder)?;
        let mut targets = Vec::new();
        for matte in &mattes.glazes.mattes {
            for pigment in &matte.pigments {
                let name = format!("{}-{pigment}", matte.name);
                let target = outputs.claim(&folder.join(format!("{name}.png")), "png")?;
                targets.push((name, target));
            }
        }
        Ok(Some(Targets { targets, _folder: made, _around: around }))
    }
}

fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Names and files of a folder's mattes.
fn mattes_of(folder: &Path) -> Result<Vec<(String, PathBuf)>, Failure> {
    let entries = fs::read_dir(folder).map_err(|error| {
        Failure::input(format!("cannot read `{}`: {}", folder.display(), crate::failure::plain(&error)))
            .hint("name a folder of mattes, as `girtin mattes` writes it")
    })?;
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let is_matte = |path: &PathBuf| ending_of(path).is_some_and(|ending| ENDINGS.contains(&ending.as_str()));
    let mut found: Vec<(String, PathBuf)> = paths.filter(is_matte).map(|path| (stem(&path), path)).collect();
    found.sort();
    Ok(found)
}

impl Mattes {
    /// How many glazes it has at most.
    pub fn glazes(&self) -> usize {
        self.glazes.mattes.iter().map(|matte| matte.pigments.len()).sum()
    }

    /// Files of its folder that nothing is painted from.
    pub fn unused(&self) -> &[PathBuf] {
        &self.unused
    }

    /// Refuses mattes that cannot be read or are of other proportions than the photograph.
    ///
    /// # Errors
    /// One is.
    pub fn check(&self, photo: [usize; 2]) -> Result<(), Failure> {
        self.files.iter().try_for_each(|(_, path)| mask(path, photo).map(drop))
    }

    /// Its mattes and pigments, for people.
    pub fn text(&self) -> String {
        let mattes = self.glazes.mattes.iter();
        mattes
            .map(|matte| format!("{}: {}", matte.name, matte.pigments.join(", ")))
            .collect::<Vec<_>>()
            .join("; ")
    }

    /// Paints a photograph from them.
    ///
    /// # Errors
    /// A matte cannot be read or is empty, or the painting failed.
    pub fn paint(
        &self,
        work: &Work<'_>,
        recipe: &Recipe,
        material: &Material,
        progress: &Progress,
        share: f64,
    ) -> Result<(Painting, C97Painting), Failure> {
        let mount = Mount::new(material.size, recipe.params.cells_for(material.size), &recipe.mounting);
        let mattes = self.files.iter().map(|(name, path)| {
            let coverage = mask(path, material.size)?;
            Ok(Matte { name: name.clone(), coverage: placed(&mount, recipe, &coverage) })
        });
        let mattes = mattes.collect::<Result<Vec<_>, Failure>>()?;
        let picture = mount.place(&material.photo).map(|light| LinearRgb(light.map(f64::from)));
        let sheet = sheet(&mount, recipe, material.long_edge);
        let request = C97Request {
            title: "",
            picture: &picture,
            mattes: &mattes,
            glazes: &self.glazes,
            sheet: &sheet,
            stock: work.stock,
        };
        // The plan is made by painting it, and then painted once more.
        let said = |stage: &'static str, from: f64| {
            move |done: u64, of: u64| {
                progress.at(stage, share * (from + 0.5 * done as f64 / of.max(1) as f64))
            }
        };
        let planning = said("planning glazes", 0.0);
        let config = C97Config {
            cancel: Some(work.interrupt.flag()),
            progress: Some(&planning),
            ..C97Config::default()
        };
        let planned = watercolorize_c97(&request, &config).map_err(|error| failed(work, &error))?;
        let painting = said("painting glazes", 0.5);
        let config = PaintConfig {
            cancel: Some(work.interrupt.flag()),
            progress: Some(&painting),
            ..PaintConfig::default()
        };
        let painted = planned.document.paint(work.stock, &planned.maps, &config);
        let painted = painted.map_err(|error| interrupted(work).unwrap_or_else(|| stopped(&error)))?;
        let (document, maps) = (planned.document.clone(), planned.maps.clone());
        Ok((Painting { document, maps, painted }, planned))
    }
}

impl Targets {
    /// Writes what was wanted.
    ///
    /// # Errors
    /// A picture cannot be written.
    pub fn write(&self, planned: &C97Painting) -> Result<Vec<Staged>, Failure> {
        let mut staged = Vec::new();
        for (glaze, (_, target)) in planned.glazes.iter().zip(&self.targets) {
            let Some(target) = target else { continue };
            let map = StoredMap::words(&glaze.target.map(|thickness| thickness / THICKEST));
            staged.push(target.stage(|writer| Ok(write_stored(writer, &map)?))?);
        }
        Ok(staged)
    }

    /// The files that it writes.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.targets.iter().filter_map(|(_, target)| target.as_ref().map(Target::name))
    }

    /// Whether there is nothing to write.
    pub fn is_done(&self) -> bool {
        self.targets.iter().all(|(_, target)| target.is_none())
    }
}

/// A matte on its sheet, whose margin stays bare.
fn placed(mount: &Mount, recipe: &Recipe, coverage: &Raster<f32>) -> Raster<f32> {
    let placed = mount.place(&coverage.map(|covered| [covered]));
    let distance = mount.distance();
    let has_margin = recipe.mounting.margin > 0.0;
    Raster::from_fn(placed.width(), placed.height(), |x, y| {
        let is_margin = has_margin && distance.at(x, y) > 0.0;
        if is_margin { 0.0 } else { placed.at(x, y)[0] }
    })
}

/// Depth of the paper's grain under raking light, mm.
const RELIEF_MM: f64 = 0.03;

fn sheet(mount: &Mount, recipe: &Recipe, long_edge: u32) -> SheetSettings {
    let sheet = mount.sheet(&recipe.mounting, &recipe.paper, recipe.seed(), long_edge);
    SheetSettings { relief_mm: RELIEF_MM, ..sheet }
}

fn interrupted(work: &Work<'_>) -> Option<Failure> {
    work.interrupt.check().err()
}

fn failed(work: &Work<'_>, error: &C97Error) -> Failure {
    if let Some(interrupted) = interrupted(work) {
        return interrupted;
    }
    let hint = error.hint().unwrap_or_else(|| "try fewer pigments, or another `--seed`".to_owned());
    match error {
        C97Error::EmptyMatte { .. } | C97Error::NoMatte { .. } | C97Error::MatteSize { .. } => {
            Failure::input(error).hint(hint)
        }
        _ => Failure::failed(error).hint(hint),
    }
}

fn stopped(error: &PaintError) -> Failure {
    let hint = match error {
        PaintError::Run { source: RunError::RanAway { .. }, .. } => "lower `phi_p` of the matte's `planning`",
        _ => "try fewer pigments",
    };
    Failure::failed(error).hint(hint)
}
