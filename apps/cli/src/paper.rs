//! `girtin paper`: shows a sheet of paper under raking light.

use std::path::{Path, PathBuf};

use girtin::grid::memory::probe;
use girtin::painting::picture::{read_grey, write_grey_png_16, write_png};
use girtin::paper::{
    HeightSource, Paper, Papers, RakingLight, ScanError, ScanOptions, ScannedSheet, Sheet, raking_light,
};
use serde_json::{Value, json};

use crate::arguments::{WriteArgs, parse_sides, real_within};
use crate::failure::Failure;
use crate::input;
use crate::interrupt::Interrupt;
use crate::output::{Outputs, print};

/// Shows a sheet of paper under raking light
///
/// NAME is a paper that comes with Girtin, a recipe in a .toml file, or a scan of real paper: a PNG, JPEG or TIFF,
/// with --pixels-per-mm to say how large it is.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  girtin paper cold-press sheet.png --size-mm 60x40
  girtin paper scan.png relief.png --pixels-per-mm 12 --height height.png"
)]
pub struct PaperArgs {
    /// Paper by name, recipe or scan
    #[arg(required_unless_present = "list")]
    name: Option<String>,
    /// Picture to write, PNG; `-` is the standard output
    #[arg(value_name = "OUT", required_unless_present = "list")]
    out: Option<PathBuf>,
    /// List the papers there are
    #[arg(long, conflicts_with_all = ["name", "out"])]
    list: bool,
    /// Print the list as JSON
    #[arg(long, requires = "list")]
    json: bool,
    /// Size of the sheet, mm: 60x40 or a scan's own, if not given
    #[arg(long, value_name = "WxH", value_parser = parse_sides)]
    size_mm: Option<[f64; 2]>,
    /// Cells, and so pixels, to a millimetre
    #[arg(long, value_name = "N", default_value = "8", value_parser = real_within(0.1, 200.0))]
    cells_per_mm: f64,
    /// Which sheet of the paper; 0 if not given
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Make the sheet a tile that continues itself, mm
    #[arg(long, value_name = "WxH", value_parser = parse_sides)]
    tile_mm: Option<[f64; 2]>,
    /// Write the heights too, PNG of 16 bits
    #[arg(long, value_name = "FILE")]
    height: Option<PathBuf>,
    /// Pixels of the scan to a millimetre of paper: 11.8 for 300 dpi. Every scan needs it
    #[arg(long, value_name = "N", help_heading = SCAN, value_parser = real_within(0.01, 1000.0))]
    pixels_per_mm: Option<f64>,
    /// Changes of light over more than this are the lamp's, mm
    #[arg(long, value_name = "MM", help_heading = SCAN, value_parser = real_within(0.1, 1e6))]
    flatten_mm: Option<f64>,
    /// Dark is high, as on a picture of the back
    #[arg(long, help_heading = SCAN)]
    dark_is_high: bool,
    #[command(flatten)]
    write: WriteArgs,
}

const SCAN: &str = "Scans";

/// Size of a sheet when nothing is said, mm.
const SIZE_MM: [f64; 2] = [60.0, 40.0];

/// Pixels of a picture, at most: 1 GiB of heights.
const MOST_PIXELS: f64 = (1 << 28) as f64;

/// Runs the verb.
///
/// # Errors
/// A name is unknown, an input bad, or an output cannot be written.
pub fn run(args: &PaperArgs, interrupt: &Interrupt) -> Result<(), Failure> {
    let (Some(name), Some(out)) = (&args.name, &args.out) else { return list(args) };
    args.write.threads.install()?;
    let file = Path::new(name);
    let kind = Kind::of(args, name);
    let mut outputs = Outputs::new(args.write.output, (kind != Kind::Known).then_some(file));
    let relief = outputs.claim(out, "png")?;
    let height = args.height.as_ref().map(|path| outputs.claim(path, "png")).transpose()?.flatten();
    let (source, own_size_mm, depth_mm) = source(args, name, kind)?;

    let size_mm = args.size_mm.or(own_size_mm).unwrap_or(SIZE_MM);
    let [columns, rows] = size_mm.map(|mm| (mm * args.cells_per_mm).round().max(1.0));
    if columns * rows > MOST_PIXELS {
        return Err(Failure::usage(format!("a sheet of {columns} × {rows} pixels is too large"))
            .hint(format!("lower `--size-mm` or `--cells-per-mm`: {MOST_PIXELS} pixels at most")));
    }
    // Heights, luminance, and bytes of what is written.
    let no_room = |error| Failure::failed(error).hint("lower `--size-mm` or `--cells-per-mm`");
    probe([13 * (columns * rows) as u64]).map_err(no_room)?;
    let field = source.height_field(columns as usize, rows as usize, args.cells_per_mm, [0.0, 0.0]);
    interrupt.check()?;
    let seed = (kind != Kind::Scan).then(|| ("Seed", args.seed.unwrap_or(0).to_string()));
    let meta = args.write.picture.meta(Some(args.cells_per_mm), seed.as_slice());
    let mut staged = Vec::new();
    if let Some(target) = relief {
        let light = RakingLight { depth_mm, ..RakingLight::default() };
        // Luminance for display: bytes as they are.
        let seen = raking_light(&field, args.cells_per_mm, &light).map(|l| [(l * 255.0 + 0.5) as u8; 3]);
        staged.push(target.stage(|writer| Ok(write_png(writer, &seen, &meta)?))?);
    }
    if let Some(target) = height {
        let values = field.map(|h| (h * 65535.0 + 0.5) as u16);
        staged.push(target.stage(|writer| Ok(write_grey_png_16(writer, &values, &meta)?))?);
    }
    interrupt.check()?;
    staged.into_iter().try_for_each(|output| output.commit())
}

fn has_extension(file: &Path, known: &[&str]) -> bool {
    let extension = file.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
    known.iter().any(|known| extension.eq_ignore_ascii_case(known))
}

/// What the name of a paper names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// A paper that comes with Girtin.
    Known,
    /// A file that says how to make a paper.
    Recipe,
    /// A picture of paper.
    Scan,
}

impl Kind {
    fn of(args: &PaperArgs, name: &str) -> Self {
        let file = Path::new(name);
        // A picture of any name is a scan if its resolution is given; but a paper does not become one by that.
        let is_picture = || args.pixels_per_mm.is_some() && file.exists() && !file.is_dir();
        match file {
            _ if has_extension(file, &["toml"]) => Self::Recipe,
            _ if name == "-" || has_extension(file, &["png", "jpg", "jpeg", "tif", "tiff"]) => Self::Scan,
            _ if is_picture() => Self::Scan,
            _ => Self::Known,
        }
    }
}

type Source = (Box<dyn HeightSource>, Option<[f64; 2]>, f64);

/// The sheet, its own size if it has one, and the depth of its relief, mm.
fn source(args: &PaperArgs, name: &str, kind: Kind) -> Result<Source, Failure> {
    let file = Path::new(name);
    if kind == Kind::Scan {
        let sheet = scan(args, file)?;
        let size_mm = sheet.size_mm();
        return Ok((Box::new(sheet), Some(size_mm), RakingLight::default().depth_mm));
    }
    // Before the flags: with a slip of the finger in the name, that is what to mend first.
    let papers = Papers::builtin();
    let known = match kind {
        Kind::Recipe => None,
        _ => Some(papers.get(name).map_err(|unknown| Failure::usage(&unknown).hint(&unknown.hint))?),
    };
    for (flag, is_given, instead) in [
        ("--pixels-per-mm", args.pixels_per_mm.is_some(), "`--cells-per-mm` is how finely a paper is drawn"),
        ("--flatten-mm", args.flatten_mm.is_some(), "leave it out, or give a picture and `--pixels-per-mm`"),
        ("--dark-is-high", args.dark_is_high, "leave it out, or give a picture and `--pixels-per-mm`"),
    ] {
        if is_given {
            return Err(Failure::usage(format!("`{flag}` is for scans, and `{name}` is none")).hint(instead));
        }
    }
    let paper = match known {
        Some(paper) => paper.clone(),
        None => Paper::from_toml(&file.display().to_string(), &input::read_text(file)?)?,
    };
    let seed = args.seed.unwrap_or(0);
    let sheet = match args.tile_mm {
        Some(tile_mm) => Sheet::tiled(&paper, seed, tile_mm),
        None => Sheet::new(&paper, seed),
    };
    Ok((Box::new(sheet), args.tile_mm, paper.surface.depth_mm))
}

fn scan(args: &PaperArgs, file: &Path) -> Result<ScannedSheet, Failure> {
    let Some(pixels_per_mm) = args.pixels_per_mm else {
        return Err(Failure::usage(format!("{} is a scan of unknown size", input::name_of(file)))
            .hint("add `--pixels-per-mm`; 300 dpi is 11.8"));
    };
    for (flag, is_given, why) in [
        ("--tile-mm", args.tile_mm.is_some(), "a scan goes on mirrored beyond its border"),
        ("--seed", args.seed.is_some(), "a scan is one sheet; leave it out"),
    ] {
        if is_given {
            return Err(Failure::usage(format!("`{flag}` is for papers, not for scans")).hint(why));
        }
    }
    let name = input::name_of(file);
    let pixels = input::picture(file, read_grey)?;
    let mut options = ScanOptions::new(pixels_per_mm);
    options.dark_is_high = args.dark_is_high;
    options.flatten_mm = args.flatten_mm.unwrap_or(options.flatten_mm);
    ScannedSheet::from_scan(&pixels, &options).map_err(|error| match error {
        ScanError::NoRoom(_) => Failure::failed(error).hint("reduce the scan first"),
        ScanError::Option { .. } => Failure::usage(error).hint("give a value inside"),
        _ => Failure::input(format!("{name}: {error}")).hint("use a sharp picture lit from the side"),
    })
}

fn list(args: &PaperArgs) -> Result<(), Failure> {
    let papers = Papers::builtin();
    if args.json {
        let described = papers.iter().map(|paper| {
            json!({
                "id": paper.id, "label": paper.label, "about": paper.about, "aliases": paper.aliases,
                "relief": paper.surface.relief, "depth_mm": paper.surface.depth_mm,
            })
        });
        return print(&format!("{:#}\n", Value::from(described.collect::<Vec<_>>())));
    }
    print(&papers.iter().map(|paper| format!("{:<12}  {}\n", paper.id, paper.about)).collect::<String>())
}
