//! `girtin pigments`: lists pigments and shows them.

use std::path::PathBuf;

use girtin::grid::Raster;
use girtin::optics::{LinearRgb, Pigment, glaze_row};
use girtin::painting::picture::write_png;
use girtin::painting::{composite, lettering};
use serde_json::{Value, json};

use crate::arguments::{PictureArgs, PigmentFiles, unknown_pigment};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::{OutputArgs, Outputs, print};

/// Lists pigments and shows them
///
/// A swatch chart shows each pigment from clear on the left to twice a swatch on the right, over white and over a
/// black stripe, with its id below, in the order of the list, row by row.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  girtin pigments
  girtin pigments french-ultramarine viridian --json --swatch swatch.png"
)]
pub struct PigmentsArgs {
    /// Pigments by any of their names; all if none is given
    #[arg(value_name = "NAME")]
    names: Vec<String>,
    /// Print everything that is known of them as JSON
    #[arg(long)]
    json: bool,
    /// Write a swatch chart, PNG
    #[arg(long, value_name = "FILE")]
    swatch: Option<PathBuf>,
    #[command(flatten)]
    pigment_files: PigmentFiles,
    #[command(flatten)]
    output: OutputArgs,
    #[command(flatten)]
    picture: PictureArgs,
}

/// Runs the verb.
///
/// # Errors
/// A pigment is unknown or its file bad, or the chart cannot be written.
pub fn run(args: &PigmentsArgs, interrupt: &Interrupt) -> Result<(), Failure> {
    let library = args.pigment_files.library()?;
    let pigments: Vec<&Pigment> = if args.names.is_empty() {
        library.iter().collect()
    } else {
        let found = args.names.iter().map(|name| library.get(name));
        found.collect::<Result<_, _>>().map_err(|unknown| unknown_pigment(&unknown))?
    };
    if let Some(path) = &args.swatch {
        let mut outputs = Outputs::new(args.output, args.pigment_files.files.iter().map(PathBuf::as_path));
        if let Some(target) = outputs.claim(path, "png")? {
            let chart = labelled(&pigments);
            target
                .write(interrupt, |writer| Ok(write_png(writer, &chart, &args.picture.meta(None, &[]))?))?;
            if target.is_stdout() {
                return Ok(());
            }
        }
    }
    if args.json {
        let list: Vec<Value> = pigments.iter().map(|pigment| described(pigment)).collect();
        return print(&format!("{:#}\n", Value::from(list)));
    }
    if args.names.is_empty() {
        // With a chart, the list is its legend.
        return print(&pigments.iter().map(|pigment| line(pigment)).collect::<String>());
    }
    print(&pigments.iter().map(|pigment| page(pigment)).collect::<Vec<_>>().join("\n"))
}

fn words(pigment: &Pigment) -> Vec<String> {
    pigment.character.iter().map(ToString::to_string).collect()
}

fn line(pigment: &Pigment) -> String {
    let swatch = pigment.coefficients.layer(1.0).over_ground(LinearRgb::WHITE).to_srgb();
    format!("{swatch}  {:<24}  {:<12}  {}\n", pigment.id, pigment.color_index, words(pigment).join(", "))
}

fn page(pigment: &Pigment) -> String {
    let swatch = pigment.coefficients.layer(1.0);
    let (white, black) = (swatch.over_ground(LinearRgb::WHITE), swatch.over_ground(LinearRgb::BLACK));
    let rows = [
        ("id", pigment.id.clone()),
        ("color index", pigment.color_index.clone()),
        ("also called", pigment.aliases.join(", ")),
        ("character", words(pigment).join(", ")),
        ("over white", white.to_srgb().to_string()),
        ("over black", black.to_srgb().to_string()),
        ("density", pigment.handling.density.to_string()),
        ("staining power", pigment.handling.staining_power.to_string()),
        ("granulation", pigment.handling.granulation.to_string()),
        ("source", pigment.source.clone()),
    ];
    let rows = rows.iter().filter(|(_, value)| !value.is_empty());
    let rows: String = rows.map(|(key, value)| format!("  {key:<14}  {value}\n")).collect();
    format!("{}\n{rows}", pigment.label)
}

fn described(pigment: &Pigment) -> Value {
    let swatch = pigment.coefficients.layer(1.0);
    let seen = |ground| {
        let seen = swatch.over_ground(ground);
        json!({ "srgb": seen.to_srgb().0, "linear": seen.0 })
    };
    json!({
        "id": pigment.id,
        "label": pigment.label,
        "color_index": pigment.color_index,
        "aliases": pigment.aliases,
        "character": words(pigment),
        "source": pigment.source,
        "density": pigment.handling.density,
        "staining_power": pigment.handling.staining_power,
        "granulation": pigment.handling.granulation,
        "absorption": pigment.coefficients.absorption,
        "scattering": pigment.coefficients.scattering,
        "over_white": seen(LinearRgb::WHITE),
        "over_black": seen(LinearRgb::BLACK),
    })
}

/// One swatch with its name and margin, pixels.
const CELL: [usize; 2] = [240, 114];
const MARGIN: usize = 12;
/// Rows of a swatch.
const SWATCH: usize = 84;
/// Rows between it and its name, and the name's color.
const GAP: usize = 6;
const TEXT: [u8; 3] = [64, 60, 58];
/// Rows of a cell on which the ground is black.
const STRIPE: std::ops::Range<usize> = 44..66;
/// Thickness at the right end of a ramp.
const THICKEST: f32 = 2.0;

/// Where the swatch of so many a pigment begins.
fn place(number: usize, columns: usize) -> [usize; 2] {
    [MARGIN + number % columns * CELL[0], MARGIN + number / columns * CELL[1]]
}

/// How many swatches are beside each other.
fn columns(pigments: usize) -> usize {
    (1..=4).find(|n| n * n * 2 >= pigments).unwrap_or(4)
}

/// The chart with the id of each pigment below its swatch.
pub fn labelled(pigments: &[&Pigment]) -> Raster<[u8; 3]> {
    let mut picture = composite::encode(&chart(pigments));
    for (number, pigment) in pigments.iter().enumerate() {
        let [left, top] = place(number, columns(pigments.len()));
        lettering::write(&mut picture, [left, top + SWATCH + GAP], 1, TEXT, &pigment.id);
    }
    picture
}

/// A swatch of each pigment, row by row.
pub fn chart(pigments: &[&Pigment]) -> Raster<LinearRgb> {
    let columns = columns(pigments.len());
    let rows = pigments.len().div_ceil(columns);
    let mut chart = Raster::new(columns * CELL[0] + MARGIN, rows * CELL[1] + MARGIN, LinearRgb::WHITE);
    let length = CELL[0] - MARGIN;
    let ramp: Vec<f32> = (0..length).map(|x| THICKEST * x as f32 / (length - 1) as f32).collect();
    for (number, pigment) in pigments.iter().enumerate() {
        let [left, top] = place(number, columns);
        for y in 0..SWATCH {
            let row = &mut chart.row_mut(top + y)[left..left + length];
            if STRIPE.contains(&y) {
                row.fill(LinearRgb::BLACK);
            }
            glaze_row(&[pigment.coefficients], &[&ramp], row);
        }
    }
    chart
}
