//! `girtin swatches`: figure 5 of Curtis et al. 1997.

use std::path::PathBuf;

use girtin::painting::gallery::SWATCHES;
use girtin::painting::{MapChest, Stock, WaterDetail};

use crate::arguments::MeansArgs;
use crate::effects::{GALLERY_MEMORY, GalleryArgs};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::Outputs;
use crate::paint::{self, Job};

/// Paints the twelve swatches of Curtis et al. 1997, figure 5
///
/// Simulated washes, thick and thin, over white and a black stripe; for plain ramps see `girtin pigments --swatch`.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  girtin swatches swatches.png
  girtin swatches large.png --size 2400 --seed 3"
)]
pub struct SwatchesArgs {
    /// Picture to write, PNG; `-` is the standard output
    #[arg(value_name = "OUT")]
    out: PathBuf,
    #[command(flatten)]
    gallery: GalleryArgs,
    #[command(flatten)]
    means: MeansArgs,
}

/// Runs the verb.
///
/// # Errors
/// The picture exists or cannot be written.
pub fn run(args: &SwatchesArgs, interrupt: &Interrupt) -> Result<(), Failure> {
    args.means.write.threads.install()?;
    let stock = Stock::builtin();
    let document = args.gallery.document(SWATCHES.name, SWATCHES.text, &stock)?;
    let Some(target) = Outputs::new(args.means.write.output, []).claim(&args.out, "png")? else {
        return Ok(());
    };
    paint::check_memory(args.means, &document, GALLERY_MEMORY)?;
    let job = Job {
        stock: &stock,
        document: &document,
        maps: &MapChest::default(),
        water: WaterDetail::Full,
        means: args.means,
        interrupt,
    };
    job.deliver(&target)
}
