//! `girtin inspect`: tells what is in a painting, a document or a state.

use std::path::PathBuf;

use girtin::grid::{Field, Layout};
use girtin::optics::Srgb;
use girtin::painting::girtin_file::{GirtinFile, is_girtin_file};
use girtin::painting::{PigmentBalance, WaterDetail, state_file};
use girtin::wash::{WashModel, WashState};
use serde_json::{Value, json};

use crate::arguments::millimetres;
use crate::failure::{Failure, plain};
use crate::given::{Form, Given, StockFiles};
use crate::input;
use crate::output::print;
use crate::wash;

/// Tells what is in a painting, a document or the state of a wash
///
/// Of a painting that was saved as a .girtin it also tells where its pigments went: how much of each was laid and lifted,
/// and how much is there.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  girtin inspect still-life.girtin
  girtin inspect out.npz --json"
)]
pub struct InspectArgs {
    /// Painting (.girtin), document (TOML, JSON) or state of a wash (.npz); `-` is the standard input
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Print it as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    stock_files: StockFiles,
}

/// Runs the verb.
///
/// # Errors
/// The file is none of these, or damaged.
pub fn run(args: &InspectArgs) -> Result<(), Failure> {
    input::check_stdin(args.stock_files.paths().chain([args.file.as_path()]))?;
    let mut source = input::open(&args.file)?;
    let start = input::beginning(&args.file, &mut *source, 16)?;
    if start.starts_with(b"\x89PNG") || start.starts_with(b"\xff\xd8") {
        return Err(Failure::input(format!("{} is a picture", input::name_of(&args.file)))
            .hint("give a .girtin, a document or a state"));
    }
    if start.starts_with(b"PK") {
        let is_painting = is_girtin_file(&mut source);
        let is_painting =
            is_painting.map_err(|error| Failure::failed(plain(&error)).hint("copy the file again"))?;
        if !is_painting {
            let unread = |error| wash::unread(&input::name_of(&args.file), &error);
            let state = state_file::read(source).map_err(unread)?;
            return tell(args.json, &of_state(&state), page_of_state);
        }
    }
    let given = Given::of_source(&args.file, source, &args.stock_files)?;
    let form = given.form;
    let file = given.gather(&[])?;
    tell(args.json, &of_painting(&file, form), page_of_painting)
}

fn tell(as_json: bool, told: &Value, page: impl Fn(&Value) -> String) -> Result<(), Failure> {
    print(&if as_json { format!("{told:#}\n") } else { page(told) })
}

/// What there is to say of a painting.
fn of_painting(file: &GirtinFile, form: Form) -> Value {
    let GirtinFile { document, maps, painted, .. } = file;
    let sheet = &document.sheet;
    let [width, height] = document.picture_size().map(|pixels| pixels as u64);
    let balances = |at: usize| painted.as_ref().and_then(|painted| painted.balances.get(at));
    let glazes = document.glazes.iter().enumerate().map(|(at, glaze)| {
        let of = |name: &String| balances(at)?.iter().find(|balance| balance.name == *name);
        let pigments = glaze.pigments.iter().map(|name| {
            let number = |pick: fn(&PigmentBalance) -> f64| of(name).map(pick);
            json!({
                "name": name,
                "laid": number(|balance| balance.laid),
                "lifted": number(|balance| balance.lifted),
                "total": number(|balance| balance.total),
            })
        });
        json!({
            "name": glaze.name,
            "model": match glaze.model { WashModel::C97 { .. } => "c97", WashModel::Living(_) => "living" },
            "outlined": glaze.outline.is_some(),
            "pigments": pigments.collect::<Vec<_>>(),
            "steps": glaze.steps(),
            "events": glaze.events.len(),
        })
    });
    let maps_told = maps.0.iter().map(|(name, map)| {
        let [width, height] = map.size();
        json!({ "name": name, "width": width, "height": height, "bits": map.bits() })
    });
    json!({
        "format": match form { Form::Toml => "toml", Form::Json => "json", Form::Girtin => "girtin" },
        "title": document.title,
        "document": format!("{:016x}", document.fingerprint(maps)),
        "sheet": {
            "size_mm": sheet.size_mm,
            "trim_mm": sheet.trim_mm,
            "paper": sheet.paper,
            "seed": sheet.seed,
            "ground": Srgb::from(sheet.ground).to_string(),
            "relief_mm": sheet.relief_mm,
            "pixels_per_mm": sheet.pixels_per_mm,
            "cells_per_mm": document.cells_per_mm(),
            "picture": [width, height],
        },
        "steps": document.steps(),
        "water": painted.as_ref().map(|painted| match painted.water {
            WaterDetail::Full => "full",
            WaterDetail::Coarse => "coarse",
        }),
        "glazes": glazes.collect::<Vec<_>>(),
        "maps": maps_told.collect::<Vec<_>>(),
    })
}

/// The same for people.
fn page_of_painting(told: &Value) -> String {
    let sheet = &told["sheet"];
    let title = text(&told["title"]);
    let trim = match real(&sheet["trim_mm"]) {
        0.0 => String::new(),
        mm => format!(", {} mm cut off on every side", millimetres(mm)),
    };
    let mut page = format!(
        "{}\n  sheet    {} × {} mm of {}, seed {}{trim}\n  picture  {} × {} pixels, {} a mm; {} cells a mm\n  steps    {}\n",
        if title.is_empty() { "untitled" } else { title },
        millimetres(real(&sheet["size_mm"][0])),
        millimetres(real(&sheet["size_mm"][1])),
        text(&sheet["paper"]),
        sheet["seed"],
        sheet["picture"][0],
        sheet["picture"][1],
        rounded(&sheet["pixels_per_mm"]),
        rounded(&sheet["cells_per_mm"]),
        told["steps"],
    );
    if !told["water"].is_null() {
        page += &format!("  painted  with {} water\n", text(&told["water"]));
    }
    for (at, glaze) in list(&told["glazes"]).iter().enumerate() {
        let name = text(&glaze["name"]);
        let name = if name.is_empty() { String::new() } else { format!(", {name}") };
        page += &format!(
            "\nglaze {}{name}: {}, {} events, {} steps\n",
            at + 1,
            text(&glaze["model"]),
            glaze["events"],
            glaze["steps"]
        );
        for pigment in list(&glaze["pigments"]) {
            let name = text(&pigment["name"]);
            page += &match pigment["laid"].as_f64() {
                Some(laid) => format!(
                    "  {name:<24}  laid {laid:>12.2}  lifted {:>12.2}  there {:>12.2}\n",
                    real(&pigment["lifted"]),
                    real(&pigment["total"])
                ),
                None => format!("  {name}\n"),
            };
        }
    }
    let maps = list(&told["maps"]);
    if !maps.is_empty() {
        page += "\nmaps\n";
    }
    for map in maps {
        let name = text(&map["name"]);
        page += &format!("  {name:<24}  {} × {}, {} bits\n", map["width"], map["height"], map["bits"]);
    }
    page
}

/// What there is to say of a state.
fn of_state(state: &WashState) -> Value {
    let layout = state.layout();
    let (width, height) = (layout.width(), layout.height());
    let wet: u64 = (0..height).flat_map(|y| state.wet_mask.cells(y)).map(|&wet| u64::from(wet != 0)).sum();
    let plane = |name: &str, field: &Field<f32>, [rows, columns]: [usize; 2]| json!({ "name": name, "shape": [rows, columns], "sum": sum(field, [rows, columns]) });
    let planes = |name: &str, fields: &[Field<f32>]| {
        let sums: Vec<f64> = fields.iter().map(|field| sum(field, [height, width])).collect();
        json!({ "name": name, "shape": [fields.len(), height, width], "sum": sums })
    };
    let cells = [height, width];
    let mut fields = vec![
        json!({ "name": "wet_mask", "shape": cells, "sum": wet }),
        plane("height", &state.height, cells),
        plane("u", &state.u, [height, width + 1]),
        plane("v", &state.v, [height + 1, width]),
        plane("pressure", &state.pressure, cells),
        plane("saturation", &state.saturation, cells),
    ];
    if !state.suspended.is_empty() {
        fields.push(planes("suspended", &state.suspended));
        fields.push(planes("deposited", &state.deposited));
    }
    json!({
        "format": "npz",
        "model": if state.ledger.is_some() { "living" } else { "c97" },
        "width": width,
        "height": height,
        "cells_per_mm": state.ledger.map(|ledger| ledger.cells_per_mm),
        "wet_cells": wet,
        "water": state.water_total(),
        "evaporated": state.ledger.map(|ledger| ledger.evaporated),
        "blotted": state.ledger.map(|ledger| ledger.blotted),
        "max_speed": state.max_speed(),
        "pigment": state.pigment_totals(),
        "fields": fields,
    })
}

fn sum(field: &Field<f32>, [rows, columns]: [usize; 2]) -> f64 {
    let row = |y: usize| &field.row(Layout::TOP + y)[Layout::LEFT..][..columns];
    (0..rows).flat_map(row).map(|&value| f64::from(value)).sum()
}

/// The same for people.
fn page_of_state(told: &Value) -> String {
    let cells_per_mm = &told["cells_per_mm"];
    let scale =
        if cells_per_mm.is_null() { String::new() } else { format!(", {} a mm", rounded(cells_per_mm)) };
    let mut page = format!(
        "state of a {} wash, {} × {} cells{scale}\n  wet      {} cells\n  water    {:.4}\n  fastest  {:.4} cells a step\n",
        text(&told["model"]),
        told["width"],
        told["height"],
        told["wet_cells"],
        real(&told["water"]),
        real(&told["max_speed"]),
    );
    for (at, total) in list(&told["pigment"]).iter().enumerate() {
        page += &format!("  pigment {}  {:.4}\n", at + 1, real(total));
    }
    page += "\narrays\n";
    for field in list(&told["fields"]) {
        let shape: Vec<String> = list(&field["shape"]).iter().map(ToString::to_string).collect();
        let sums = match &field["sum"] {
            Value::Array(sums) => sums.clone(),
            sum => vec![sum.clone()],
        };
        let sums: Vec<String> = sums.iter().map(|sum| format!("{:.4}", real(sum))).collect();
        let (name, shape) = (text(&field["name"]), format!("({})", shape.join(", ")));
        page += &format!("  {name:<10}  {shape:<18}  sum {}\n", sums.join(", "));
    }
    page
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

fn real(value: &Value) -> f64 {
    value.as_f64().unwrap_or_default()
}

/// A number for people.
fn rounded(value: &Value) -> f64 {
    (real(value) * 1000.0).round() / 1000.0
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map(Vec::as_slice).unwrap_or_default()
}
