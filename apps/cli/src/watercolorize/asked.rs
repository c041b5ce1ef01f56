//! How photographs are painted: preset, palette, paper, sheet and every parameter.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use girtin::optics::{Library, Palette};
use girtin::painting::Stock;
use girtin::params::{Table, hint_for, parse};
use girtin::watercolorize::separate::MOST;
use girtin::watercolorize::{Border, Mounting, PRESETS, PhotoParams, Preset};

use super::photo::Opened;
use crate::arguments::{real_within, set, set_help, unknown_pigment};
use crate::failure::Failure;
use crate::input;

/// Options of how it is painted.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Painting")]
pub struct AskedArgs {
    /// Manner of painting: classic, loose, wet-in-wet, detailed, urban, botanical, monochrome or nocturne, or a TOML file of your own
    #[arg(long, value_name = "NAME|FILE", default_value = "classic", conflicts_with = "contact_sheet")]
    preset: String,
    /// Pigments to paint with, by name or from a TOML file with `pigments = [...]`; chosen for the photograph if not given
    #[arg(long, value_name = "A,B,C|FILE")]
    palette: Option<String>,
    /// How much is drawn exactly where the eye rests
    #[arg(long, value_name = "HOW", value_enum, default_value_t = Detail::Normal)]
    detail: Detail,
    /// Where the eye is drawn to, parts of the photograph's width and height, such as 0.3,0.6; found if not given
    #[arg(long, value_name = "X,Y", value_parser = parse_focus, conflicts_with = "detail_map")]
    focus: Option<[f64; 2]>,
    /// How far colors run into each other: 1 is usual, 0 to 4
    #[arg(long, value_name = "X", value_parser = real_within(0.0, 4.0))]
    wetness: Option<f64>,
    /// How many washes are laid over each other, 1 to 4
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4))]
    washes: Option<u32>,
    /// Any parameter of a preset, such as `ink=0.8`; may be repeated; `--help` lists them
    #[arg(long = "set", value_name = "KEY=VALUE", long_help = set_help::<PhotoParams>())]
    set: Vec<String>,
    /// Seed of all accidents: another one is another painting of the same photograph; made of the photograph if not given
    // As large as a document can say.
    #[arg(long, value_name = "N")]
    seed: Option<u32>,
    /// Long edge of the picture on paper, such as 160mm, 30cm or 12in; 360mm if not given, from mattes 160mm
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
    sheet: Option<f64>,
    /// Bare sheet on each side, a part of the long edge; 0 is exactly the photograph's size, painted edge to edge
    #[arg(long, value_name = "FRACTION", default_value_t = 0.05, value_parser = real_within(0.0, 0.5))]
    margin: f64,
    /// How the painting ends before the margin
    #[arg(long, value_name = "HOW", value_enum, default_value_t = Edge::Vignette)]
    border: Edge,
    /// Paper, see `girtin paper --list`; else the preset's
    #[arg(long, value_name = "NAME")]
    paper: Option<String>,
}

/// How much is drawn exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Detail {
    /// Large shapes only, and quickly
    Low,
    /// As the preset has it
    Normal,
    /// Faces and lettering can be read
    High,
}

impl Detail {
    /// What it makes of a preset's detail, and its planning size.
    fn apply(self, params: &mut PhotoParams) {
        match self {
            Self::Low => {
                params.detail = params.detail.min(0.5);
                params.masses *= 1.5;
                params.plan_cells = params.plan_cells.min(760);
            }
            Self::Normal => {}
            Self::High => {
                params.detail = (1.3 * params.detail).min(2.0);
                params.masses *= 0.7;
                params.plan_cells = params.plan_cells.max(1500);
            }
        }
    }
}

/// See [`Border`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Edge {
    /// Shapes stop at different distances, in marks of the brush
    Vignette,
    /// Along masking tape, with corners left open
    Taped,
    /// At the sheet's torn edge
    Deckle,
}

/// A recipe for any photograph.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// Name of the preset, or of its file.
    pub preset: String,
    /// Parameters.
    pub params: PhotoParams,
    /// Ids of pigments, if they are not to be chosen.
    pub palette: Option<Vec<String>>,
    /// Id of the paper.
    pub paper: String,
    /// How it lies on the sheet.
    pub mounting: Mounting,
    /// Seed, if it is not to be made of the photograph.
    pub seed: Option<u32>,
    /// Where the eye is drawn to, if that is not to be found.
    pub focus: Option<[f64; 2]>,
}

impl Recipe {
    /// The recipe for a photograph.
    pub fn for_photo(&self, photo: &Opened) -> Self {
        Self { seed: self.seed.or(Some(photo.fingerprint)), ..self.clone() }
    }

    /// The seed that is painted with.
    pub fn seed(&self) -> u64 {
        self.seed.map_or(0, u64::from)
    }
}

/// Sheet, cells and paper of paintings from mattes.
const MATTES_MM: f64 = 160.0;
const MATTES_CELLS: u32 = 640;
const MATTES_PAPER: &str = "fine-grain";

/// Cells of a quick painting's plan to one of a full one's: the same shapes, a little rounder.
const QUICK_CELLS: f64 = 0.55;

impl AskedArgs {
    /// The files that are read.
    pub fn files(&self) -> impl Iterator<Item = PathBuf> {
        let given = [Some(&self.preset), self.palette.as_ref()].into_iter().flatten();
        given.filter(|name| is_file(name)).map(PathBuf::from).collect::<Vec<_>>().into_iter()
    }

    /// The recipe that is asked for, or one of each preset, planned on fewer cells if it is to be quick; own pigments join the
    /// stock. From mattes it is planned as in the paper, on the sheet and cells that it was tried on.
    ///
    /// # Errors
    /// A name is unknown, a file is wrong, or a value not allowed.
    pub fn recipes(
        &self,
        stock: &mut Stock,
        all: bool,
        is_quick: bool,
        from_mattes: bool,
    ) -> Result<Vec<Recipe>, Failure> {
        let palette = self.palette(&mut stock.pigments)?;
        let named =
            if all { PRESETS.iter().map(|p| p.name.to_owned()).collect() } else { vec![self.preset.clone()] };
        named
            .into_iter()
            .map(|name| {
                let mut recipe = self.recipe(name, palette.as_ref(), stock, is_quick)?;
                if from_mattes {
                    recipe.mounting.long_edge_mm = self.sheet.unwrap_or(MATTES_MM);
                    recipe.params.plan_cells = MATTES_CELLS;
                    if self.paper.is_none() {
                        recipe.paper = MATTES_PAPER.to_owned();
                    }
                }
                Ok(recipe)
            })
            .collect()
    }

    fn recipe(
        &self,
        name: String,
        palette: Option<&Vec<String>>,
        stock: &Stock,
        is_quick: bool,
    ) -> Result<Recipe, Failure> {
        let preset = preset(&name, stock)?;
        let mut params = preset.params;
        self.detail.apply(&mut params);
        if is_quick {
            params.plan_cells = (f64::from(params.plan_cells) * QUICK_CELLS) as u32;
        }
        params.wetness = self.wetness.unwrap_or(params.wetness);
        params.washes = self.washes.unwrap_or(params.washes);
        self.set.iter().try_for_each(|word| set(&mut params, word))?;
        let paper = match &self.paper {
            Some(name) => {
                stock.papers.get(name).map_err(|error| Failure::usage(&error).hint(error.hint.clone()))?
            }
            None => stock.papers.get(&preset.paper).map_err(Failure::input)?,
        };
        let border = match self.border {
            Edge::Vignette => Border::Vignette,
            Edge::Taped => Border::Taped,
            Edge::Deckle => Border::Deckle,
        };
        Ok(Recipe {
            preset: name,
            params,
            palette: palette.cloned().or(preset.palette),
            paper: paper.id.clone(),
            mounting: Mounting {
                long_edge_mm: self.sheet.unwrap_or(Mounting::default().long_edge_mm),
                margin: self.margin,
                border,
            },
            seed: self.seed,
            focus: self.focus,
        })
    }

    /// Ids of the pigments that are asked for.
    fn palette(&self, library: &mut Library) -> Result<Option<Vec<String>>, Failure> {
        let Some(given) = &self.palette else { return Ok(None) };
        let ids = if is_file(given) {
            let palette = Palette::from_toml(given, &input::read_text(Path::new(given))?, library)?;
            *library = palette.library;
            if palette.pigments.len() > MOST {
                return Err(too_many(palette.pigments.len(), Failure::input));
            }
            palette.pigments
        } else {
            let mut ids: Vec<String> = Vec::new();
            for name in given.split(',').map(str::trim) {
                let pigment = library.get(name).map_err(|error| unknown_pigment(&error))?;
                if ids.contains(&pigment.id) {
                    return Err(Failure::usage(format!("`--palette` has `{}` twice", pigment.id))
                        .hint("name each pigment once"));
                }
                ids.push(pigment.id.clone());
            }
            ids
        };
        if ids.len() > MOST {
            return Err(too_many(ids.len(), Failure::usage));
        }
        Ok(Some(ids))
    }
}

fn too_many(count: usize, kind: fn(String) -> Failure) -> Failure {
    kind(format!("the palette has {count} pigments; at most {MOST} are mixed")).hint("leave some out")
}

/// Whether a name means a file.
fn is_file(name: &str) -> bool {
    name.ends_with(".toml") || name.contains('/')
}

/// A built-in preset or one from a file, all of whose names are known.
fn preset(name: &str, stock: &Stock) -> Result<Preset, Failure> {
    if !is_file(name) {
        let known: Vec<&str> = PRESETS.iter().map(|preset| preset.name).collect();
        return Preset::built_in(name).ok_or_else(|| {
            let hint = if name == "pen" { "`urban` replaces it".to_owned() } else { hint_for(name, &known) };
            Failure::usage(format!("no preset is called `{name}`")).hint(hint)
        });
    }
    let text = input::read_text(Path::new(name))?;
    // Names are looked up while their places are known.
    let read = |table: &Table<'_>| {
        let mut preset = Preset::from_table(table)?;
        for (place, name) in table.places("palette").iter().zip(preset.palette.iter_mut().flatten()) {
            let unknown = |error: girtin::optics::UnknownPigment| {
                table.fault_at(place, error.to_string()).hint(error.hint())
            };
            *name = stock.pigments.get(name).map_err(unknown)?.id.clone();
        }
        if let Some(ids) = preset.palette.as_ref().filter(|ids| !(1..=MOST).contains(&ids.len())) {
            let fault = table.fault("palette", format!("the palette has {} pigments", ids.len()));
            return Err(fault.hint(format!("name 1 to {MOST}")));
        }
        stock
            .papers
            .get(&preset.paper)
            .map_err(|error| table.fault("paper", error.to_string()).hint(error.hint))?;
        Ok(preset)
    };
    Ok(parse(name, &text, read)?)
}

/// A point of the photograph: `0.3,0.6`.
///
/// # Errors
/// It is not two numbers from 0 to 1.
fn parse_focus(text: &str) -> Result<[f64; 2], String> {
    let parts: Vec<Option<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    match parts[..] {
        [Some(x), Some(y)] if (0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y) => Ok([x, y]),
        _ => Err("give two numbers from 0 to 1, such as 0.3,0.6".to_owned()),
    }
}

/// Lengths of paper that can be asked for, mm.
const LENGTHS: std::ops::RangeInclusive<f64> = 10.0..=1500.0;

/// A length in millimetres: `160mm`, `30cm`, `12in`.
///
/// # Errors
/// It is no number with a unit, or no sheet's.
fn parse_length(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let unit = text.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
    let number: Option<f64> = text[..text.len() - unit.len()].parse().ok();
    let factor = match unit.trim().to_ascii_lowercase().as_str() {
        "mm" => Some(1.0),
        "cm" => Some(10.0),
        "in" | "\"" => Some(25.4),
        _ => None,
    };
    let mm = number.zip(factor).map(|(number, factor)| number * factor);
    let told =
        || "give a number with its unit, from 10mm to 150cm, such as `160mm`, `30cm` or `12in`".to_owned();
    mm.filter(|mm| LENGTHS.contains(mm)).ok_or_else(told)
}

#[cfg(test)]
mod tests {
    use girtin::params::row::Parameters;

    use super::*;

    #[test]
    fn lengths_have_a_unit() {
        assert_eq!(parse_length("160mm"), Ok(160.0));
        assert_eq!(parse_length("30 cm"), Ok(300.0));
        assert_eq!(parse_length("12in"), Ok(12.0 * 25.4));
        for bad in ["", "160", "mm", "-3cm", "9mm", "2000mm", "1..2cm"] {
            assert!(parse_length(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn any_parameter_can_be_set() {
        let mut params = PhotoParams::default();
        for row in PhotoParams::ROWS {
            set(&mut params, &format!("{}={}", row.id.replace('_', "-"), row.hard.0)).unwrap();
            assert!(set(&mut params, &format!("{}={}", row.id, row.hard.1 + 1.0)).is_err(), "{}", row.id);
        }
        for bad in ["ink", "inc=1", "ink=much", "=1"] {
            assert!(set(&mut params, bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn levels_of_detail_stay_within_the_rows() {
        for name in PRESETS.iter().map(|preset| preset.name) {
            for detail in [Detail::Low, Detail::High] {
                let mut params = Preset::built_in(name).unwrap().params;
                detail.apply(&mut params);
                for row in PhotoParams::ROWS {
                    row.check(params.get(row.id).unwrap()).unwrap();
                }
            }
        }
    }
}
