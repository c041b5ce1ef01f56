//! `girtin paint`: carries out a document of glazes.

use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;

use girtin::grid::random::fold;
use girtin::painting::map_file::MapError;
use girtin::painting::picture::{PictureError, write_png};
use girtin::painting::{Document, PaintConfig, PaintError, ResolveError, Stock, WaterDetail, memory};
use girtin::paper::Paper;
use girtin::params::Place;

use crate::arguments::{MeansArgs, PigmentFiles, WaterArgs, megabytes, real_within};
use crate::failure::{Failure, plain};
use crate::input;
use crate::interrupt::Interrupt;
use crate::output::{Outputs, Staged, Target, print};
use crate::wash;

/// Paints a document of glazes
///
/// Maps that the document names are looked for in its folder.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  girtin paint still-life.toml still-life.png
  girtin paint still-life.toml print.png --scale 4 --water coarse"
)]
pub struct PaintArgs {
    /// Document, TOML
    #[arg(value_name = "DOC")]
    document: PathBuf,
    /// Picture to write, PNG; `-` is the standard output
    #[arg(value_name = "OUT")]
    out: PathBuf,
    #[command(flatten)]
    water: WaterArgs,
    /// Times as many pixels to a millimetre as the document says
    #[arg(long, value_name = "X", default_value = "1", value_parser = real_within(0.01, 100.0))]
    scale: f64,
    /// Another sheet of the same paper
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    #[command(flatten)]
    pigment_files: PigmentFiles,
    /// Add a paper from a TOML file; may be repeated
    #[arg(long = "paper-file", value_name = "FILE")]
    paper_files: Vec<PathBuf>,
    /// Read and check the document, say what would be done, and do nothing
    #[arg(long)]
    dry_run: bool,
    #[command(flatten)]
    means: MeansArgs,
}

/// Runs the verb.
///
/// # Errors
/// The document or a map of it is bad, or the picture cannot be written.
pub fn run(args: &PaintArgs, interrupt: &Interrupt) -> Result<(), Failure> {
    args.means.threads.install()?;
    let mut stock = Stock { pigments: args.pigment_files.library()?, ..Stock::builtin() };
    for path in &args.paper_files {
        stock.papers.insert(Paper::from_toml(&path.display().to_string(), &input::read_text(path)?)?);
    }
    let text = input::read_text(&args.document)?;
    let name = args.document.display().to_string();
    let mut document = Document::from_toml(&name, &text, &stock)?;
    document.sheet.pixels_per_mm *= args.scale;
    document.sheet.seed = args.seed.unwrap_or(document.sheet.seed);
    let inputs = [&args.document].into_iter().chain(&args.pigment_files.files).chain(&args.paper_files);
    let mut outputs = Outputs::new(args.means.output, inputs.map(PathBuf::as_path));
    let Some(target) = outputs.claim(&args.out, "png")? else { return Ok(()) };
    document.cells().map_err(|error| Failure::input(&error).hint(TOO_LARGE))?;
    if args.dry_run {
        return print(&plan(&document));
    }
    check_memory(args.means, &document, TOO_LARGE)?;
    let job = Job {
        stock: &stock,
        document: &document,
        name: &name,
        text: &text,
        folder: args.document.parent(),
        water: args.water.detail(),
        means: args.means,
        interrupt,
    };
    job.deliver(&target)
}

/// What would be done.
fn plan(document: &Document) -> String {
    let [width, height] = document.picture_size();
    let cells = width * height * f64::from(document.sheet.cells_per_pixel).powi(2);
    let names: Vec<&str> = document.glazes.iter().map(|glaze| glaze.name.as_str()).collect();
    format!(
        "picture: {width} × {height} pixels\nsheet: {} × {} mm of {}, seed {}\nglazes: {} ({})\nwork: {} steps on \
         {cells} cells at most, {} threads\nmemory: about {}\n",
        document.sheet.size_mm[0],
        document.sheet.size_mm[1],
        document.sheet.paper,
        document.sheet.seed,
        names.len(),
        names.join(", "),
        document.steps(),
        rayon::current_num_threads(),
        megabytes(memory::of_document(document).unwrap_or(u64::MAX)),
    )
}

/// Refuses a document that takes more memory than it may; `lower` says what to lower.
///
/// # Errors
/// It does.
pub fn check_memory(means: MeansArgs, document: &Document, lower: &str) -> Result<(), Failure> {
    means.check_memory(memory::of_document(document).unwrap_or(u64::MAX), lower)
}

/// A document to be painted.
pub struct Job<'a> {
    /// What it may name.
    pub stock: &'a Stock,
    /// The document.
    pub document: &'a Document,
    /// Its file's name, for messages.
    pub name: &'a str,
    /// Its text, of which the picture tells a fingerprint.
    pub text: &'a str,
    /// Where its maps are; without a folder there are none.
    pub folder: Option<&'a Path>,
    /// How finely the water of its living washes is simulated.
    pub water: WaterDetail,
    /// How it is painted and written.
    pub means: MeansArgs,
    /// Ctrl-C.
    pub interrupt: &'a Interrupt,
}

impl Job<'_> {
    /// Paints the document and gives the picture its name, unless a signal came meanwhile.
    ///
    /// # Errors
    /// As [`Job::paint`], or it was interrupted.
    pub fn deliver(&self, target: &Target) -> Result<(), Failure> {
        let staged = self.paint(target)?;
        self.interrupt.check()?;
        staged.commit()
    }

    /// Paints the document; the picture does not have its name yet.
    ///
    /// # Errors
    /// The document cannot be painted, or its picture not be written.
    fn paint(&self, target: &Target) -> Result<Staged, Failure> {
        self.means.talk.detail(&plan(self.document));
        let start = Instant::now();
        let progress = self.means.talk.start(self.document.steps(), "steps");
        let tell = |done, _| progress.at(done);
        let config = PaintConfig {
            water: self.water,
            cancel: Some(self.interrupt.flag()),
            progress: Some(&tell),
            ..PaintConfig::default()
        };
        let open = |name: &str| -> io::Result<Vec<u8>> {
            let folder = self.folder.ok_or(io::ErrorKind::NotFound)?;
            let path = folder.join(name);
            if target.is(&path) {
                return Err(io::Error::other("it is the output as well"));
            }
            std::fs::read(path)
        };
        let painted = self.document.paint(self.stock, &open, &config);
        progress.end();
        let painted = painted.map_err(|error| self.failed(&error))?;
        self.interrupt.check()?;
        let (seconds, start) = (start.elapsed().as_secs_f64(), Instant::now());
        let picture = painted.development().encoded(|color| color.to_srgb().to_bytes());
        let seed = self.document.sheet.seed.to_string();
        let words = [("Seed", seed), ("Document", format!("{:016x}", fingerprint(self.text)))];
        let meta = self.means.picture.meta(Some(painted.sheet.pixels_per_mm), &words);
        let staged = target.stage(|writer| Ok(write_png(writer, &picture, &meta)?))?;
        self.means.talk.detail(&format!(
            "painted in {seconds:.2} s; encoded and written in {:.2} s",
            start.elapsed().as_secs_f64()
        ));
        Ok(staged)
    }

    fn failed(&self, error: &PaintError) -> Failure {
        match error {
            PaintError::Run { source, .. } => wash::stopped(source, error, self.interrupt),
            PaintError::Resolve(ResolveError::TooLarge { .. } | ResolveError::Scale { .. }) => {
                Failure::input(error).hint(TOO_LARGE)
            }
            PaintError::Resolve(
                ResolveError::NoRoom(_)
                | ResolveError::Map {
                    source: MapError::NoRoom(_) | MapError::Picture(PictureError::NoRoom(_)),
                    ..
                },
            ) => Failure::failed(error).hint(TOO_LARGE),
            PaintError::Resolve(ResolveError::Open { file, place, source }) => {
                let said = format!("cannot read map `{file}`: {}", plain(source));
                self.said_at(place, &said, "maps lie in the document's folder")
            }
            PaintError::Resolve(ResolveError::Map { place, source, .. }) => {
                self.said_at(place, &error.to_string(), source.hint().unwrap_or("save the map again"))
            }
            _ => Failure::input(error).hint("mend the document"),
        }
    }

    /// What is wrong with something that the document names.
    fn said_at(&self, place: &Place, message: &str, hint: &str) -> Failure {
        place.problem(self.name, self.text, message, hint).into()
    }
}

/// What to do about too many cells.
const TOO_LARGE: &str = "change `--scale`, `pixels_per_mm` or `cells_per_pixel`";

/// A number that tells documents apart.
fn fingerprint(text: &str) -> u64 {
    text.bytes().fold(0, |sum, byte| fold(sum, u64::from(byte)))
}
