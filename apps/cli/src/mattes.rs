//! `girtin mattes`: the regions of a photograph, a gray picture each.

use std::path::PathBuf;

use girtin::optics::LinearRgb;
use girtin::painting::picture::{PictureLimits, read_photo, write_grey_png};
use girtin::watercolorize::mattes::{MattePlan, MattesParams};

use crate::arguments::{PictureArgs, ThreadArgs, set, set_help};
use crate::failure::{Failure, Kind};
use crate::input;
use crate::interrupt::Interrupt;
use crate::output::{MadeFolder, OutputArgs, Outputs, print};
use crate::progress::TalkArgs;

/// Finds the regions of a photograph and writes a matte of each, largest first
///
/// A matte is a gray picture of the photograph's size, white where its region is. Edit them in any program, and paint from
/// them by `girtin watercolorize --mattes DIR --glazes FILE`.
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
    output: OutputArgs,
    #[command(flatten)]
    picture: PictureArgs,
    #[command(flatten)]
    threads: ThreadArgs,
    #[command(flatten)]
    talk: TalkArgs,
}

/// Runs the verb.
///
/// # Errors
/// The photograph cannot be read, or a matte exists or cannot be written.
pub fn run(args: &MattesArgs, interrupt: &Interrupt) -> Result<(), Failure> {
    args.threads.install()?;
    let mut params = MattesParams::default();
    params.regions = args.regions.unwrap_or(params.regions);
    args.set.iter().try_for_each(|word| set(&mut params, word))?;
    let _folder = MadeFolder::new(&args.folder)?;
    let limits = PictureLimits::of_photo(args.max_pixels);
    let ending = args.photo.extension().and_then(|ending| ending.to_str());
    let photo =
        read_photo(input::open(&args.photo)?, ending, &limits, LinearRgb::WHITE).map_err(|error| {
            let kind =
                if error.is_of_limits() || error.hint().is_some() { Kind::Input } else { Kind::Failed };
            let hint = if error.is_of_limits() {
                "if it is to be trusted, allow more with `--max-pixels`"
            } else {
                error.hint().unwrap_or("try another picture")
            };
            Failure::new(kind, format!("{}: {error}", input::name_of(&args.photo))).hint(hint)
        })?;
    for note in &photo.notes {
        args.talk.say(&format!("girtin: {}: {note}", input::name_of(&args.photo)));
    }
    let picture = photo.pixels.map(|light| LinearRgb(light.map(f64::from)));
    interrupt.check()?;
    let plan = MattePlan::new(&picture, &params);
    let mut outputs = Outputs::new(args.output, [args.photo.as_path()]);
    let mut claimed = Vec::new();
    for name in plan.names() {
        claimed.push(outputs.claim(&args.folder.join(format!("{name}.png")), "png")?);
    }
    let progress = args.talk.start(claimed.len() as u64, "mattes");
    for (region, target) in claimed.iter().enumerate() {
        if let Some(target) = target {
            let matte = plan.matte(&picture, region);
            let bytes = matte.coverage.map(|covered| (covered.clamp(0.0, 1.0) * 255.0 + 0.5) as u8);
            let meta = args.picture.meta(None, &[]);
            target.write(interrupt, |writer| Ok(write_grey_png(writer, &bytes, &meta)?))?;
        }
        progress.at(region as u64 + 1);
    }
    progress.end();
    if args.json { print(&format!("{}\n", serde_json::json!(plan.names()))) } else { Ok(()) }
}
