//! `girtin watercolorize`: photographs become paintings.
//!
//! In the order of the work:
//! - `asked`: how they are painted; `batch`: which, and under which names;
//! - `outputs`: everything that is written of one, checked before the work;
//! - `plan`: what would be done;
//! - `photo`: the photograph and its masks; `c97`: mattes and their glazes; `work`: one after another is
//!   painted;
//! - `deliver`: each in all its forms, films also through `ffmpeg`; `told`: what is said of it.

mod asked;
mod batch;
mod outputs;
mod plan;
mod photo;
mod c97;
mod work;
mod deliver;
mod ffmpeg;
mod told;

use std::path::{Path, PathBuf};

use clap::builder::PossibleValuesParser;
use girtin::painting::Stock;
use girtin::painting::picture::{PictureFormat, PictureLimits};

use crate::arguments::MeansArgs;
use crate::failure::{Failure, Kind};
use crate::given::StockFiles;
use crate::input;
use crate::interrupt::Interrupt;
use crate::output::Outputs;

use asked::{AskedArgs, Recipe};
use batch::{Naming, Writing};
use c97::C97Args;
use outputs::{Errand, MoreArgs};
use photo::{MaskArgs, Reading};
use work::Work;

/// Paints photographs: light washes to dark, of real pigments, on rough paper
///
/// Nothing need be said but where the painting goes. The palette is chosen for the photograph; a painting is as large
/// as its photograph, up to 6000 pixels, with a margin of bare sheet around it. Equal photographs, options and seeds
/// give equal bytes.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    override_usage = "girtin watercolorize [OPTIONS] <INPUT>... <OUTPUT>",
    after_help = "Examples:
  girtin watercolorize photo.jpg painting.png
  girtin watercolorize photo.jpg painting.png --detail high --save painting.girtin
  girtin watercolorize photos/ 'out/{stem}.jpg' --preset loose --skip-existing"
)]
pub struct WatercolorizeArgs {
    /// Photographs, and last the painting
    ///
    /// Photographs are files, folders, patterns such as 'photos/*.jpg', or `-`, the standard input. The painting is PNG, JPEG,
    /// TIFF or WebP by its ending; of many photographs a folder, or a name with {stem} in it; `-` is the standard output.
    // One list, so that options may stand between them.
    #[arg(value_name = "INPUT... OUTPUT", required = true, num_args = 1..)]
    paths: Vec<PathBuf>,
    #[command(flatten)]
    means: MeansArgs,
    #[command(flatten)]
    asked: AskedArgs,
    #[command(flatten)]
    stock: StockFiles,
    #[command(flatten)]
    masks: MaskArgs,
    #[command(flatten)]
    size: SizeArgs,
    #[command(flatten)]
    more: MoreArgs,
    #[command(flatten)]
    c97: C97Args,
    /// Print a line of JSON for every painting: its size, palette, and where its pigments went
    #[arg(long, help_heading = "Output")]
    json: bool,
    /// Say what would be done, how much memory it takes and how long, and do nothing
    #[arg(long, help_heading = "Output")]
    dry_run: bool,
}

/// How large the picture is, and in which format.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Picture")]
struct SizeArgs {
    /// Long edge of the picture without its margin, pixels; the photograph's, 6000 at most, if not given
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(16..=30000))]
    size: Option<u32>,
    /// The same painting, small and quickly: its long edge has 640 pixels
    #[arg(long, conflicts_with = "size")]
    preview: bool,
    /// Paint by every preset, small, on one sheet with their names
    #[arg(long, conflicts_with_all = ["layers", "save", "timelapse", "stages", "preview"])]
    contact_sheet: bool,
    /// Format of the picture, whatever its name
    #[arg(long, value_name = "FORMAT", value_parser = PossibleValuesParser::new(PictureFormat::ENDINGS))]
    format: Option<String>,
    /// Bits of each channel: 16 for PNG and TIFF
    #[arg(long, value_name = "N", default_value = "8", value_parser = bits)]
    bits: u8,
    /// Quality of a JPEG, 1 to 100 [default: 92]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=100))]
    quality: Option<u8>,
    /// Refuse photographs of more pixels, which may be made to fill the memory
    #[arg(long, value_name = "N", default_value_t = PictureLimits::PHOTO_PIXELS)]
    max_pixels: u64,
}

/// Long edge of a painting on a contact sheet, pixels.
const CONTACT: u32 = 480;

fn bits(text: &str) -> Result<u8, String> {
    match text {
        "8" => Ok(8),
        "16" => Ok(16),
        _ => Err("a channel has 8 or 16 bits".to_owned()),
    }
}

impl WatercolorizeArgs {
    /// Refuses to read the standard input twice, and names with places that stand for nothing.
    ///
    /// # Errors
    /// There is such a name.
    fn check_names(&self) -> Result<(), Failure> {
        let masks = [&self.masks.reserve, &self.masks.detail_map, &self.c97.mattes].into_iter().flatten();
        let masks = masks.chain(&self.c97.lift);
        masks.clone().try_for_each(|path| batch::check_places(&path.to_string_lossy()))?;
        // The last of the paths is the painting.
        let inputs = self.paths.split_last().map_or(&[][..], |(_, inputs)| inputs);
        let files = inputs.iter().chain(masks).chain(&self.c97.glazes).map(PathBuf::as_path);
        input::check_stdin(files.chain(self.stock.paths()))
    }
}

/// Runs the verb.
///
/// # Errors
/// The command line is wrong, an output cannot be written, or a photograph cannot be painted.
pub fn run(args: &WatercolorizeArgs, interrupt: &Interrupt) -> Result<(), Failure> {
    args.means.write.threads.install()?;
    args.check_names()?;
    let mut stock = args.stock.over(Stock::builtin())?;
    let recipes = args.asked.recipes(
        &mut stock,
        args.size.contact_sheet,
        args.size.contact_sheet || args.size.preview,
        args.c97.mattes.is_some(),
    )?;
    let Some((output, inputs)) = args.paths.split_last().filter(|(_, inputs)| !inputs.is_empty()) else {
        return Err(Failure::usage("the painting's name is missing")
            .hint("such as `girtin watercolorize photo.jpg painting.png`"));
    };
    let photos = batch::photographs(inputs)?;
    let errands = claimed(args, output, &recipes, &photos, &stock)?;
    let work = Work {
        recipes: &recipes,
        is_contact_sheet: args.size.contact_sheet,
        stock: &stock,
        masks: &args.masks,
        reading: reading(&args.size, &recipes),
        json: args.json,
        means: args.means,
        interrupt,
    };
    let mut failed: Vec<(String, Failure)> = Vec::new();
    let (count, mut done) = (errands.len(), 0);
    for (at, errand) in errands.iter().enumerate() {
        interrupt.check()?;
        let title = if count > 1 { format!("{} of {count}: ", at + 1) } else { String::new() };
        let result = if args.dry_run { work.plan(errand) } else { work.paint(errand, &title) };
        match result {
            Ok(()) => done += 1,
            Err(failure)
                if count == 1 || matches!(failure.kind(), Kind::Interrupted(_) | Kind::ReaderLeft) =>
            {
                return Err(failure);
            }
            Err(failure) => failed.push((errand.photo.display().to_string(), failure)),
        }
    }
    // What was there already is no failure.
    told_of(&failed, done, photos.len() - count)
}

/// What failed of many, at the end.
fn told_of(failed: &[(String, Failure)], done: usize, skipped: usize) -> Result<(), Failure> {
    if failed.is_empty() {
        return Ok(());
    }
    for (_, failure) in failed {
        let _ = failure.report();
    }
    let names: Vec<&str> = failed.iter().map(|(name, _)| name.as_str()).collect();
    let cause = format!(
        "{} of {} photographs failed: {}",
        names.len(),
        names.len() + done + skipped,
        names.join(", ")
    );
    let failure =
        if done + skipped == 0 { Failure::failed(cause) } else { Failure::new(Kind::SomeOfMany, cause) };
    Err(failure.hint("mend what is said above, and run it again with `--skip-existing`"))
}

fn reading(size: &SizeArgs, recipes: &[Recipe]) -> Reading {
    Reading {
        most: size.max_pixels,
        size: size.size.or(size.contact_sheet.then_some(CONTACT)),
        is_preview: size.preview,
        plan: recipes.iter().map(|recipe| recipe.params.plan_cells).max().unwrap_or(0),
    }
}

/// If the painting's name is that of a file, the painting's name may have been forgotten, and the file may be a photograph:
/// nobody is told to replace it without that being said.
fn last_is_output(failure: Failure, output: &Path) -> Failure {
    if failure.kind() != Kind::Exists || !output.is_file() {
        return failure;
    }
    failure.hint(
        "the last name is where the painting goes: give it one of its own after the photographs, \
         `--skip-existing` to leave this file, or `--overwrite` to replace it",
    )
}

/// Every output of every photograph; those that are all there already and to be left are left out.
fn claimed(
    args: &WatercolorizeArgs,
    output: &Path,
    recipes: &[Recipe],
    photos: &[PathBuf],
    stock: &Stock,
) -> Result<Vec<Errand>, Failure> {
    let writing =
        Writing { format: args.size.format.as_deref(), bits: args.size.bits, quality: args.size.quality };
    if photos.len() > 1 && photos.iter().any(|photo| photo == Path::new("-")) {
        return Err(Failure::usage("the standard input is one photograph among others")
            .hint("paint it by itself, or save it to a file"));
    }
    if args.json && output == Path::new("-") {
        return Err(Failure::usage("`--json` and the picture would both go to the standard output")
            .hint("name a file for the picture"));
    }
    let of_photo = |photo| Naming { photo, count: photos.len() };
    let masks = photos.iter().flat_map(|photo| {
        let naming = of_photo(photo);
        args.masks.files(&naming).into_iter().chain(args.c97.files(&naming))
    });
    let own = args.stock.paths().map(Path::to_owned);
    let files: Vec<PathBuf> = args.asked.files().chain(masks).chain(own).chain(photos.to_vec()).collect();
    let mut outputs = Outputs::new(args.means.write.output, files.iter().map(PathBuf::as_path));
    let washes = recipes.iter().map(|recipe| recipe.params.glazes()).max().unwrap_or(0);
    let mut errands = Vec::new();
    for photo in photos {
        let extra = (washes, args.means.talk);
        let naming = of_photo(photo);
        let mut errand = args
            .more
            .claim(&mut outputs, &naming, output, &writing, extra)
            .map_err(|failure| last_is_output(failure, output))?;
        errand.mattes = args.c97.read(&naming, stock)?;
        errand.targets = args.c97.claim(&mut outputs, &naming, errand.mattes.as_ref())?;
        if errand.is_done() {
            args.means.talk.detail(&format!("{}: its outputs are there and are left", input::name_of(photo)));
        } else {
            errands.push(errand);
        }
    }
    Ok(errands)
}
