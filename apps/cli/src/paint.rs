//! `girtin paint`: carries out a document of glazes.

use std::io;
use std::path::{Path, PathBuf};

use girtin::grid::random::fold;
use girtin::painting::picture::write_png;
use girtin::painting::{Document, PaintConfig, PaintError, ResolveError, Stock, composite};
use girtin::paper::Paper;
use girtin::params::Place;

use crate::arguments::{PictureArgs, PigmentFiles, ThreadArgs, real_within};
use crate::failure::{Failure, plain};
use crate::input;
use crate::interrupt::Interrupt;
use crate::output::{OutputArgs, Outputs, Staged, Target, print};
use crate::progress::TalkArgs;
use crate::wash;

/// Paints a document of glazes
///
/// Maps that the document names are looked for in its folder.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  girtin paint still-life.toml still-life.png
  girtin paint still-life.toml print.png --scale 2 --threads 4"
)]
pub struct PaintArgs {
    /// Document, TOML
    #[arg(value_name = "DOC")]
    document: PathBuf,
    /// Picture to write, PNG; `-` is the standard output
    #[arg(value_name = "OUT")]
    out: PathBuf,
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
/// The document or a map of it is bad, or the picture cannot be written.
pub fn run(args: &PaintArgs, interrupt: &Interrupt) -> Result<(), Failure> {
    args.threads.install()?;
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
    let mut outputs = Outputs::new(args.output, inputs.map(PathBuf::as_path));
    let Some(target) = outputs.claim(&args.out, "png")? else { return Ok(()) };
    document.cells().map_err(|error| Failure::input(&error).hint(TOO_LARGE))?;
    if args.dry_run {
        return print(&plan(&document));
    }
    let job = Job {
        stock: &stock,
        document: &document,
        name: &name,
        text: &text,
        folder: args.document.parent(),
        picture: args.picture,
        talk: args.talk,
        interrupt,
    };
    job.deliver(&target)
}

/// What would be done.
fn plan(document: &Document) -> String {
    let [width, height] = document.picture_size();
    let cells = width * height * f64::from(document.sheet.cells_per_pixel).powi(2);
    let names: Vec<&str> = document.glazes.iter().map(|glaze| glaze.name.as_str()).collect();
    // Six fields and the mask, two for each pigment, and the picture; each glaze is kept.
    let glaze = |pigments: usize| 4.0 * (6 + 2 * pigments) as f64 + 1.0;
    let bytes: f64 = document.glazes.iter().map(|each| glaze(each.pigments.len())).sum::<f64>() + 52.0;
    format!(
        "picture: {width} × {height} pixels\nsheet: {} × {} mm of {}, seed {}\nglazes: {} ({})\nwork: {} steps on \
         {cells} cells at most\nmemory: about {:.0} MB at most\n",
        document.sheet.size_mm[0],
        document.sheet.size_mm[1],
        document.sheet.paper,
        document.sheet.seed,
        names.len(),
        names.join(", "),
        document.steps(),
        bytes * cells / 1e6,
    )
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
    /// What the picture says of itself.
    pub picture: PictureArgs,
    /// What is said meanwhile.
    pub talk: TalkArgs,
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
        let progress = self.talk.start(self.document.steps(), "steps");
        let tell = |done, _| progress.at(done);
        let config = PaintConfig {
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
        let picture = composite::encode(&painted.picture);
        let seed = self.document.sheet.seed.to_string();
        let words = [("Seed", seed), ("Document", format!("{:016x}", fingerprint(self.text)))];
        let meta = self.picture.meta(Some(painted.pixels_per_mm), &words);
        target.stage(|writer| Ok(write_png(writer, &picture, &meta)?))
    }

    fn failed(&self, error: &PaintError) -> Failure {
        match error {
            PaintError::Run { source, .. } => wash::stopped(source, error, self.interrupt),
            PaintError::Resolve(ResolveError::TooLarge { .. }) => Failure::input(error).hint(TOO_LARGE),
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
const TOO_LARGE: &str = "lower `--scale`, `pixels_per_mm` or `cells_per_pixel`";

/// A number that tells documents apart.
fn fingerprint(text: &str) -> u64 {
    text.bytes().fold(0, |sum, byte| fold(sum, u64::from(byte)))
}
