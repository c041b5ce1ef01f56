//! `girtin mattes`: the regions of a photograph, a gray picture each.

use std::fs;
use std::path::{Path, PathBuf};

use girtin::optics::LinearRgb;
use girtin::painting::StoredMap;
use girtin::painting::map_file::{read_stored, write_stored_with};
use girtin::painting::picture::{PictureLimits, read_photo, read_png_word};
use girtin::watercolorize::mattes::{MattePlan, MattesParams};

use crate::arguments::{WriteArgs, set, set_help};
use crate::failure::{Failure, Kind};
use crate::input;
use crate::interrupt::Interrupt;
use crate::output::{MadeFolder, Outputs, Staged, cannot_write, print};
use crate::progress::TalkArgs;

/// Finds the regions of a photograph and writes a matte of each, largest first
///
/// A matte is a gray picture of the photograph's size, white where its region is, named for its number, place and color.
/// Edit them in any program, and paint from them by `girtin watercolorize --mattes DIR --glazes FILE`. With --overwrite
/// mattes of another run go, but for those that were edited.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  girtin mattes photo.jpg mattes
  girtin mattes photo.jpg mattes --regions 6 --set edge-weight=0.8 --overwrite"
)]
pub struct MattesArgs {
    /// Photograph; `-` is the standard input
    #[arg(value_name = "INPUT")]
    photo: PathBuf,
    /// Folder to write to; it is made if it is not there
    #[arg(value_name = "OUT_DIR")]
    folder: PathBuf,
    /// How many regions at most, 1 to 200
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=200))]
    regions: Option<u32>,
    /// Any parameter, such as `edge-weight=0.8`; may be repeated; `--help` lists them
    #[arg(long = "set", value_name = "KEY=VALUE", long_help = set_help::<MattesParams>())]
    set: Vec<String>,
    /// Refuse photographs of more pixels, which may be made to fill the memory
    #[arg(long, value_name = "N", default_value_t = PictureLimits::PHOTO_PIXELS)]
    max_pixels: u64,
    /// Print the mattes' names as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    write: WriteArgs,
    #[command(flatten)]
    talk: TalkArgs,
}

/// What a matte says of itself: a number that its pixels give, so that it can be told whether somebody has worked on it.
const WORD: &str = "Matte";

/// Runs the verb.
///
/// # Errors
/// The photograph cannot be read, or a matte exists or cannot be written.
pub fn run(args: &MattesArgs, interrupt: &Interrupt) -> Result<(), Failure> {
    args.write.threads.install()?;
    let mut params = MattesParams::default();
    params.regions = args.regions.unwrap_or(params.regions);
    args.set.iter().try_for_each(|word| set(&mut params, word))?;
    let _folder = MadeFolder::new(&args.folder)?;
    let limits = PictureLimits::of_photo(args.max_pixels);
    let ending = args.photo.extension().and_then(|ending| ending.to_str());
    let photo = read_photo(input::open(&args.photo)?, ending, &limits, LinearRgb::WHITE)
        .map_err(|error| input::no_photo(&args.photo, &error))?;
    for note in &photo.notes {
        args.talk.say(&format!("girtin: {}: {note}", input::name_of(&args.photo)));
    }
    let picture = photo.pixels.map(|light| LinearRgb(light.map(f64::from)));
    interrupt.check()?;
    let plan = MattePlan::new(&picture, &params);
    let mut outputs = Outputs::new(args.write.output, [args.photo.as_path()]);
    let mut claimed = Vec::new();
    for name in plan.names() {
        claimed.push(outputs.claim(&args.folder.join(format!("{name}.png")), "png")?);
    }
    let others = others(args, plan.names())?;
    let progress = args.talk.start(claimed.len() as u64, "mattes");
    let mut staged = Vec::new();
    for (region, target) in claimed.iter().enumerate() {
        interrupt.check()?;
        if let Some(target) = target {
            let matte = StoredMap::bytes(&plan.matte(&picture, region).coverage);
            let meta = args.write.picture.meta(None, &[(WORD, word_of(&matte))]);
            staged.push(target.stage(|writer| Ok(write_stored_with(writer, &matte, &meta)?))?);
        }
        progress.at(region as u64 + 1);
    }
    progress.end();
    interrupt.check()?;
    staged.into_iter().try_for_each(Staged::commit)?;
    for path in others {
        fs::remove_file(&path).map_err(|error| cannot_write(&path.display().to_string(), &error))?;
        args.talk.detail(&format!("`{}` is gone: it was of another run", path.display()));
    }
    if args.json { print(&format!("{}\n", serde_json::json!(plan.names()))) } else { Ok(()) }
}

/// Mattes of other runs that are to go, as they would be painted from with these. Those that somebody has worked on stay.
///
/// # Errors
/// There are some, and nobody said that they may be replaced.
fn others(args: &MattesArgs, names: &[String]) -> Result<Vec<PathBuf>, Failure> {
    let entries =
        fs::read_dir(&args.folder).into_iter().flatten().filter_map(|entry| Some(entry.ok()?.path()));
    let mut others: Vec<PathBuf> = entries.filter(|path| is_other(path, names)).collect();
    others.sort();
    let (ours, worked_on): (Vec<_>, Vec<_>) = others.into_iter().partition(|path| is_as_written(path));
    let first = ours.first().map(|path| path.display().to_string());
    match first {
        Some(first) if !args.write.output.overwrite && !args.write.output.skip_existing => {
            let message = format!("`{first}` is a matte of another run, and would be among these");
            return Err(Failure::new(Kind::Exists, message)
                .hint("add `--overwrite` to replace all of them, or name another folder"));
        }
        _ => {}
    }
    let is_to_go = args.write.output.overwrite;
    for path in worked_on.iter().chain(ours.iter().filter(|_| !is_to_go)) {
        args.talk.say(&format!("girtin: `{}` is of another run, and is left", path.display()));
    }
    Ok(if is_to_go { ours } else { Vec::new() })
}

/// Whether a file is called as mattes are, and none of these is called so.
fn is_other(path: &Path, names: &[String]) -> bool {
    let is_png = path.extension().is_some_and(|ending| ending == "png") && path.is_file();
    let Some(stem) = path.file_stem().and_then(|stem| stem.to_str()).filter(|_| is_png) else { return false };
    let (number, words) = stem.split_once('-').unwrap_or_default();
    let is_number = number.len() >= 2 && number.bytes().all(|byte| byte.is_ascii_digit());
    let is_word = !words.is_empty() && words.bytes().all(|byte| byte.is_ascii_lowercase() || byte == b'-');
    is_number && is_word && !names.iter().any(|name| name == stem)
}

/// Whether a matte is still as it was written.
fn is_as_written(path: &Path) -> bool {
    let said = fs::File::open(path).ok().and_then(|file| read_png_word(file, WORD));
    let matte = || read_stored(&fs::read(path).ok()?, &PictureLimits::default()).ok();
    said.is_some_and(|said| matte().is_some_and(|matte| word_of(&matte) == said))
}

fn word_of(matte: &StoredMap) -> String {
    format!("{:016x}", matte.fingerprint())
}
