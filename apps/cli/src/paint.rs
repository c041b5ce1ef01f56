//! `girtin paint`: carries out a document of glazes.

use std::io::Write;
use std::path::PathBuf;
use std::time::Instant;

use girtin::grid::Raster;
use girtin::painting::girtin_file::thumbnail_png;
use girtin::painting::map_file::MapError;
use girtin::painting::picture::{PictureError, WriteError, write_png};
use girtin::painting::{
    Document, MapChest, PaintConfig, PaintError, Painted, PaintedRecord, ResolveError, Stock, WaterDetail,
    effort, memory,
};

use crate::arguments::{MeansArgs, WaterArgs, megabytes, millimetres, real_within};
use crate::failure::Failure;
use crate::given::{Given, StockFiles};
use crate::input;
use crate::interrupt::Interrupt;
use crate::output::{Outputs, Staged, Target, print};
use crate::wash;

/// Paints a document of glazes
///
/// A document is TOML or JSON, or a painting that was saved as a .girtin, which has all that it needs in itself. Maps that
/// a document of text names are looked for in its folder.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  girtin paint still-life.toml still-life.png --save still-life.girtin
  girtin paint still-life.girtin print.png --scale 4 --water coarse"
)]
pub struct PaintArgs {
    /// Document: TOML, JSON or .girtin; `-` is the standard input
    #[arg(value_name = "DOC")]
    document: PathBuf,
    /// Picture to write, PNG; `-` is the standard output
    #[arg(value_name = "OUT", required_unless_present = "save")]
    out: Option<PathBuf>,
    /// Write the painting too, as a .girtin: document, maps, pigments, paper and picture in one file
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
    #[command(flatten)]
    water: WaterArgs,
    /// Times as many pixels to a millimetre as the document says
    #[arg(long, value_name = "X", default_value = "1", value_parser = real_within(0.01, 100.0))]
    scale: f64,
    /// Another sheet of the same paper
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    #[command(flatten)]
    stock_files: StockFiles,
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
    args.means.write.threads.install()?;
    input::check_stdin(args.stock_files.paths().chain([args.document.as_path()]))?;
    let mut given = Given::read(&args.document, &args.stock_files)?;
    given.document.sheet.pixels_per_mm *= args.scale;
    given.document.sheet.seed = args.seed.unwrap_or(given.document.sheet.seed);
    let inputs = [args.document.as_path()].into_iter().chain(args.stock_files.paths());
    let mut outputs = Outputs::new(args.means.write.output, inputs);
    let picture = args.out.as_ref().map(|out| outputs.claim(out, "png")).transpose()?.flatten();
    let save = args.save.as_ref().map(|save| outputs.claim(save, "girtin")).transpose()?.flatten();
    let targets: Vec<&Target> = picture.iter().chain(&save).collect();
    if targets.is_empty() {
        return Ok(());
    }
    given.document.cells().map_err(|error| Failure::input(&error).hint(TOO_LARGE))?;
    let unsaid = given.painted.as_ref().map(|painted| painted.water).unwrap_or_default();
    let water = args.water.detail(unsaid);
    if args.dry_run {
        return print(&plan(&given.document, water));
    }
    check_memory(args.means, &given.document, TOO_LARGE)?;
    let mut file = given.gather(&targets)?;
    if save.is_some() {
        file.check().map_err(|error| {
            let hint = error.hint().unwrap_or_else(|| TOO_LARGE.to_owned());
            Failure::input(format!("the painting cannot be saved: {error}")).hint(hint)
        })?;
    }
    let job = Job {
        stock: &file.stock,
        document: &file.document,
        maps: &file.maps,
        water,
        means: args.means,
        interrupt,
    };
    let painted = job.paint()?;
    let developed = job.develop(&painted);
    let mut staged = Vec::new();
    if let Some(target) = &picture {
        staged.push(job.stage(target, &developed)?);
    }
    if let Some(target) = &save {
        file.painted = Some(job.record(&painted, &developed)?);
        staged.push(target.stage(|writer| Ok(file.write(writer)?))?);
    }
    interrupt.check()?;
    staged.into_iter().try_for_each(Staged::commit)
}

/// What would be done.
fn plan(document: &Document, water: WaterDetail) -> String {
    let [width, height] = document.picture_size();
    let cells = width * height * f64::from(document.sheet.cells_per_pixel).powi(2);
    let names: Vec<&str> = document.glazes.iter().map(|glaze| glaze.name.as_str()).collect();
    let threads = rayon::current_num_threads();
    let time = effort::of_document(document).map_or_else(
        || "too many cells".to_owned(),
        |[least, most]| {
            let [least, most] = [least, most].map(|seconds| seconds / threads as f64);
            let coarse = if water == WaterDetail::Full { "" } else { " were its water not coarse" };
            format!("about {least:.1} to {most:.1} s{coarse}")
        },
    );
    format!(
        "picture: {width} × {height} pixels\nsheet: {} × {} mm of {}, seed {}\nglazes: {} ({})\nwork: {} steps on \
         {cells} cells at most, {threads} threads, {time}\nmemory: about {}\n",
        millimetres(document.sheet.size_mm[0]),
        millimetres(document.sheet.size_mm[1]),
        document.sheet.paper,
        document.sheet.seed,
        names.len(),
        names.join(", "),
        document.steps(),
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
    /// Its maps.
    pub maps: &'a MapChest,
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
    /// The document cannot be painted, its picture not be written, or it was interrupted.
    pub fn deliver(&self, target: &Target) -> Result<(), Failure> {
        let developed = self.develop(&self.paint()?);
        let staged = self.stage(target, &developed)?;
        self.interrupt.check()?;
        staged.commit()
    }

    /// Paints the document.
    fn paint(&self) -> Result<Painted, Failure> {
        self.means.talk.detail(&plan(self.document, self.water));
        let start = Instant::now();
        let progress = self.means.talk.start(self.document.steps(), "steps");
        let tell = |done, _| progress.at(done);
        let config = PaintConfig {
            water: self.water,
            cancel: Some(self.interrupt.flag()),
            progress: Some(&tell),
            ..PaintConfig::default()
        };
        let painted = self.document.paint(self.stock, self.maps, &config);
        progress.end();
        let painted = painted.map_err(|error| self.failed(&error))?;
        self.interrupt.check()?;
        self.means.talk.detail(&format!("painted in {:.2} s", start.elapsed().as_secs_f64()));
        Ok(painted)
    }

    /// The picture in bytes of sRGB.
    fn develop(&self, painted: &Painted) -> Raster<[u8; 3]> {
        painted.development().encoded(|color| color.to_srgb().to_bytes())
    }

    /// Writes the picture, which does not have its name yet.
    fn stage(&self, target: &Target, developed: &Raster<[u8; 3]>) -> Result<Staged, Failure> {
        let start = Instant::now();
        let staged = target.stage(|writer| Ok(self.encode(writer, developed)?))?;
        self.means.talk.detail(&format!("encoded and written in {:.2} s", start.elapsed().as_secs_f64()));
        Ok(staged)
    }

    fn encode(&self, writer: impl Write, developed: &Raster<[u8; 3]>) -> Result<(), WriteError> {
        let seed = self.document.sheet.seed.to_string();
        let fingerprint = format!("{:016x}", self.document.fingerprint(self.maps));
        let words = [("Seed", seed), ("Document", fingerprint)];
        let meta = self.means.write.picture.meta(Some(self.document.sheet.pixels_per_mm), &words);
        write_png(writer, developed, &meta)
    }

    /// What a file tells of the painting.
    fn record(&self, painted: &Painted, developed: &Raster<[u8; 3]>) -> Result<PaintedRecord, Failure> {
        let mut merged = Vec::new();
        let pictures = self.encode(&mut merged, developed).and_then(|()| thumbnail_png(developed));
        let thumbnail = pictures.map_err(Failure::failed)?;
        let balances = painted.glazes.iter().map(|glaze| glaze.pigments.clone()).collect();
        Ok(PaintedRecord { water: self.water, balances, merged, thumbnail })
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
            _ => Failure::input(error).hint("mend the document"),
        }
    }
}

/// What to do about too many cells.
const TOO_LARGE: &str = "change `--scale`, `pixels_per_mm` or `cells_per_pixel`";
