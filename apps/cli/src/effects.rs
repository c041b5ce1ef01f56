//! `girtin effects`: the six effects of figures 1 and 2 of Curtis et al. 1997, by either model.

use std::path::PathBuf;

use girtin::painting::gallery::{EFFECTS, Example, LIVING};
use girtin::painting::{Document, MapChest, Stock, WaterDetail};

use crate::arguments::{MeansArgs, WaterArgs};
use crate::failure::{Failure, Kind};
use crate::interrupt::Interrupt;
use crate::output::{MadeFolder, Outputs};
use crate::paint::{self, Job};

/// Paints the six effects of Curtis et al. 1997, a picture each
///
/// Drybrush, edge darkening, backrun, granulation, flow and glazing. By the living wash there are two sheets more: one
/// stroke over paper at twelve wetnesses, and a puddle dropped into a drying wash at six moments.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  girtin effects effects
  girtin effects effects --model living --size 1024 --seed 3 --overwrite"
)]
pub struct EffectsArgs {
    /// Folder to write to; it is made if it is not there
    #[arg(value_name = "OUT_DIR")]
    folder: PathBuf,
    /// Physics of the washes
    #[arg(long, value_name = "MODEL", value_enum, default_value_t = Model::C97)]
    model: Model,
    #[command(flatten)]
    water: WaterArgs,
    #[command(flatten)]
    gallery: GalleryArgs,
    #[command(flatten)]
    means: MeansArgs,
}

/// By which physics the effects are painted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Model {
    /// Curtis et al. 1997, exactly: the paper's figures
    C97,
    /// Girtin's own: in millimetres, drying by itself
    Living,
}

impl Model {
    fn examples(self) -> &'static [Example] {
        match self {
            Self::C97 => &EFFECTS,
            Self::Living => &LIVING,
        }
    }
}

/// How a document that comes with Girtin is changed.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct GalleryArgs {
    /// Long edge of a picture, pixels
    #[arg(long, value_name = "PX", value_parser = clap::value_parser!(u32).range(16..=16384))]
    size: Option<u32>,
    /// Another sheet of the same paper
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
}

impl GalleryArgs {
    /// The document as asked for.
    ///
    /// # Errors
    /// It is none, which the library's tests rule out.
    pub fn document(self, name: &str, text: &str, stock: &Stock) -> Result<Document, Failure> {
        let mut document = Document::from_toml(name, text, stock)?;
        if let Some(size) = self.size {
            document = document.with_long_edge(size);
        }
        document.sheet.seed = self.seed.unwrap_or(document.sheet.seed);
        Ok(document)
    }
}

/// What to do about too little memory.
pub const GALLERY_MEMORY: &str = "lower `--size`";

/// Runs the verb.
///
/// # Errors
/// A picture exists or cannot be written.
pub fn run(args: &EffectsArgs, interrupt: &Interrupt) -> Result<(), Failure> {
    args.means.write.threads.install()?;
    let _folder = MadeFolder::new(&args.folder)?;
    let mut outputs = Outputs::new(args.means.write.output, []);
    let stock = Stock::builtin();
    let mut tasks = Vec::new();
    for example in args.model.examples() {
        let document = args.gallery.document(example.name, example.text, &stock)?;
        document.cells().map_err(|error| Failure::usage(error).hint("choose another `--size`"))?;
        paint::check_memory(args.means, &document, GALLERY_MEMORY)?;
        if let Some(target) = outputs.claim(&args.folder.join(format!("{}.png", example.name)), "png")? {
            tasks.push((example, document, target));
        }
    }
    let (count, mut failed) = (tasks.len(), 0);
    for (example, document, target) in tasks {
        args.means.talk.say(&format!("girtin: {}", example.name));
        let job = Job {
            stock: &stock,
            document: &document,
            maps: &MapChest::default(),
            water: args.water.detail(WaterDetail::Full),
            means: args.means,
            interrupt,
        };
        match job.deliver(&target) {
            Ok(()) => {}
            Err(failure) if matches!(failure.kind(), Kind::Interrupted(_)) => return Err(failure),
            Err(failure) => {
                let _ = failure.report();
                failed += 1;
            }
        }
    }
    match failed {
        0 => Ok(()),
        _ if failed == count => Err(Failure::failed("no picture could be painted").hint("see above")),
        _ => Err(Failure::new(Kind::SomeOfMany, format!("{failed} of {count} pictures failed"))
            .hint("mend what is said above and run it again with `--skip-existing`")),
    }
}
