//! A named paint: its optics, how it handles in water, and the TOML file it comes from.

use core::fmt;

use girtin_params::read::Fault;
use girtin_params::write::{Node, Tree};
use girtin_params::{Problem, Table, parse};

use crate::color::Srgb;
use crate::kubelka_munk::{Coefficients, ImpossibleAppearance, Published};

/// Largest K or S that a file may give; beyond it a layer of a millionth of a swatch would be opaque.
const MAX_COEFFICIENT: f64 = 1e6;

/// Largest staining power that a file may give; the paper's go to 9.3.
const MAX_STAINING_POWER: f64 = 100.0;

/// Smallest staining power: the rate of lifting is divided by it.
const MIN_STAINING_POWER: f64 = 1e-3;

/// A paint.
#[derive(Clone, Debug, PartialEq)]
pub struct Pigment {
    /// Name in files and on the command line: lower-case letters, digits and dashes.
    pub id: String,
    /// Name for people.
    pub label: String,
    /// Color Index name, such as `PB29`, or several joined by ` + `; empty where there is none.
    pub color_index: String,
    /// Further names.
    pub aliases: Vec<String>,
    /// What painters say of it.
    pub character: Vec<Character>,
    /// Where its numbers come from.
    pub source: String,
    /// K and S for linear light.
    pub coefficients: Coefficients,
    /// K and S as printed, if the file gives them so.
    pub published: Option<Published>,
    /// How it moves between water and paper.
    pub handling: Handling,
}

/// How a pigment moves between water and paper: the coefficients of C97's `TransferPigment`.
///
/// # Source
/// Curtis et al. 1997, §4.5 and figure 5.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Handling {
    /// ρ, fraction that settles per step, 0..=1.
    pub density: f64,
    /// ω, how much harder it is to lift than to settle; at least ρ, so that no more is lifted than lies there.
    pub staining_power: f64,
    /// γ, how much it prefers the paper's hollows, 0..=1.
    pub granulation: f64,
}

/// What painters say of a paint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Character {
    /// The ground shines through; nearly black over black.
    Transparent,
    /// Veils the ground slightly.
    SemiTransparent,
    /// Veils the ground clearly.
    SemiOpaque,
    /// Covers the ground.
    Opaque,
    /// Settles in the hollows of the paper.
    Granulating,
    /// Cannot be lifted once dry.
    Staining,
    /// Lifts easily.
    Lifting,
    /// A little colors much water.
    StrongTinting,
    /// Much colors little water.
    WeakTinting,
    /// Shows its color over dark grounds.
    Interference,
    /// A mixture of several pigments.
    Mixed,
}

impl Character {
    /// All words, as files spell them.
    pub const WORDS: &'static [(&'static str, Self)] = &[
        ("transparent", Self::Transparent),
        ("semi-transparent", Self::SemiTransparent),
        ("semi-opaque", Self::SemiOpaque),
        ("opaque", Self::Opaque),
        ("granulating", Self::Granulating),
        ("staining", Self::Staining),
        ("lifting", Self::Lifting),
        ("strong-tinting", Self::StrongTinting),
        ("weak-tinting", Self::WeakTinting),
        ("interference", Self::Interference),
        ("mixed", Self::Mixed),
    ];
}

impl fmt::Display for Character {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = Self::WORDS.iter().find(|(_, character)| character == self).map(|(word, _)| *word);
        f.pad(word.unwrap_or_default())
    }
}

impl Pigment {
    /// Reads a pigment's file. `origin` is the file's name, for messages.
    ///
    /// # Errors
    /// The text is not TOML, a key is unknown, missing or out of range, or no paint can look as it says.
    pub fn from_toml(origin: &str, text: &str) -> Result<Self, Problem> {
        parse(origin, text, Self::read)
    }

    /// Reads a pigment from a table of a larger file, such as a palette.
    ///
    /// # Errors
    /// As [`Pigment::from_toml`].
    pub fn read(table: &Table<'_>) -> Result<Self, Fault> {
        let id = table.need_text("id")?;
        let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        if !id.chars().all(plain) || !id.contains(|c: char| c.is_ascii_alphanumeric()) {
            return Err(table
                .fault("id", format!("`id` cannot be `{id}`"))
                .hint("use lower-case letters, digits and dashes, such as `burnt-sienna`"));
        }
        let label = table.need_text("label")?;
        let color_index = table.text("color_index")?.unwrap_or_default();
        let aliases = table.texts("aliases")?.unwrap_or_default();
        let character = read_character(table)?;
        let source = table.text("source")?.unwrap_or_default();
        let handling = Handling::read(table)?;
        let (coefficients, published) = read_optics(table)?;
        Ok(Self { id, label, color_index, aliases, character, source, coefficients, published, handling })
    }

    /// The pigment as a file of its own. Its optics are the K and S that light meets, exactly, whichever way they were
    /// once given: a painting that keeps them looks the same even if the ways are read otherwise one day.
    pub fn to_toml(&self) -> String {
        let aliases: Vec<&str> = self.aliases.iter().map(String::as_str).collect();
        let words = self.character.iter().map(|word| Node::Text(word.to_string()));
        let Handling { density, staining_power, granulation } = self.handling;
        let Coefficients { absorption, scattering } = self.coefficients;
        let linear = Tree::new().with("absorption", absorption).with("scattering", scattering);
        Tree::new()
            .with("id", self.id.as_str())
            .with("label", self.label.as_str())
            .with("color_index", self.color_index.as_str())
            .with("aliases", aliases)
            .with("character", Node::List(words.collect()))
            .with("source", self.source.as_str())
            .with("density", density)
            .with("staining_power", staining_power)
            .with("granulation", granulation)
            .with("linear", Node::Section(linear))
            .to_toml()
    }

    /// Whether painters say so of it.
    pub fn is(&self, character: Character) -> bool {
        self.character.contains(&character)
    }
}

impl Handling {
    fn read(table: &Table<'_>) -> Result<Self, Fault> {
        let hint = |fault: Fault, advice: &str| fault.hint(advice);
        let density = table
            .need_real("density", 0.0..=1.0)
            .map_err(|fault| hint(fault, "`density` is a fraction a step; the paper's are 0.01 to 0.09"))?;
        let staining_power = table
            .need_real("staining_power", 0.0..=MAX_STAINING_POWER)
            .map_err(|fault| hint(fault, "`staining_power` is 1 for paint that lifts, up to 9 for stains"))?;
        let granulation = table
            .need_real("granulation", 0.0..=1.0)
            .map_err(|fault| hint(fault, "`granulation` is 0 for smooth paint, up to 1 for grainy"))?;
        let least = density.max(MIN_STAINING_POWER);
        if staining_power < least {
            let message = format!("`staining_power` is {staining_power}, below {least}");
            return Err(table.fault("staining_power", message).hint(
                "give at least `density` and at least 0.001: else a step lifts more paint than lies there",
            ));
        }
        Ok(Self { density, staining_power, granulation })
    }
}

fn read_character(table: &Table<'_>) -> Result<Vec<Character>, Fault> {
    let words = table.texts("character")?.unwrap_or_default();
    words
        .iter()
        .map(|text| match Character::WORDS.iter().find(|(word, _)| word == text) {
            Some(&(_, character)) => Ok(character),
            None => {
                let known: Vec<&str> = Character::WORDS.iter().map(|(word, _)| *word).collect();
                Err(table
                    .fault("character", format!("`character` cannot be `{text}`"))
                    .hint(girtin_params::hint_for(text, &known)))
            }
        })
        .collect()
}

/// K and S from whichever of the three tables the file has.
fn read_optics(table: &Table<'_>) -> Result<(Coefficients, Option<Published>), Fault> {
    const WAYS: [&str; 3] = ["published", "appearance", "linear"];
    let published = table.table("published", |inner| {
        let (absorption, scattering) = read_coefficients(inner)?;
        Ok(Published { absorption, scattering })
    })?;
    let appearance = table.table("appearance", read_appearance)?;
    let linear = table.table("linear", |inner| {
        let (absorption, scattering) = read_coefficients(inner)?;
        Ok(Coefficients { absorption, scattering })
    })?;
    match (published, appearance, linear) {
        (Some(published), None, None) => {
            Ok((Coefficients::linear_from_published(&published), Some(published)))
        }
        (None, Some(coefficients), None) | (None, None, Some(coefficients)) => Ok((coefficients, None)),
        (None, None, None) => Err(table
            .fault("", "the pigment has no optics")
            .hint("add [appearance] with over_white = \"#rrggbb\" and over_black = \"#rrggbb\"")),
        _ => {
            let present: Vec<&str> = WAYS.into_iter().filter(|way| table.has(way)).collect();
            let last = present.last().copied().unwrap_or_default();
            Err(table
                .fault(last, format!("the pigment's optics are given twice: {}", present.join(" and ")))
                .hint("keep one of [published], [appearance], [linear]"))
        }
    }
}

fn read_coefficients(table: &Table<'_>) -> Result<([f64; 3], [f64; 3]), Fault> {
    let need = |key: &str| {
        table.reals::<3>(key, 0.0..=MAX_COEFFICIENT)?.ok_or_else(|| {
            table.fault(key, format!("`{key}` is missing")).hint(format!("add {key} = [red, green, blue]"))
        })
    };
    Ok((need("absorption")?, need("scattering")?))
}

fn read_appearance(table: &Table<'_>) -> Result<Coefficients, Fault> {
    let (over_white, over_black) = (read_swatch(table, "over_white")?, read_swatch(table, "over_black")?);
    Coefficients::from_swatch(over_white, over_black).map_err(|error: ImpossibleAppearance| {
        // Whichever color is at the end of its range is the one to change; else it is the one over black.
        let key = if error.over_white <= 0.0 { "over_white" } else { "over_black" };
        table.fault(key, error.to_string()).hint(error.hint())
    })
}

/// A color as `"#rrggbb"` or `[r, g, b]`.
fn read_swatch(table: &Table<'_>, key: &str) -> Result<Srgb, Fault> {
    const FORMS: &str = "a color is \"#rrggbb\", or [r, g, b] with numbers 0 to 1";
    match table.text(key) {
        Ok(Some(text)) => text
            .parse()
            .map_err(|error: crate::color::BadHex| table.fault(key, error.to_string()).hint(FORMS)),
        Ok(None) => Err(table.fault(key, format!("`appearance` lacks `{key}`")).hint(FORMS)),
        Err(_) => match table.reals::<3>(key, 0.0..=1.0) {
            Ok(Some(channels)) => Ok(Srgb(channels)),
            Ok(None) => Err(table.fault(key, format!("`appearance` lacks `{key}`")).hint(FORMS)),
            Err(fault) => Err(fault.hint(FORMS)),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::LinearRgb;
    use proptest::prelude::*;

    const HEAD: &str =
        "id = \"mud\"\nlabel = \"Mud\"\ndensity = 0.05\nstaining_power = 2.0\ngranulation = 0.5\n";

    fn mud(more: &str) -> Result<Pigment, Problem> {
        Pigment::from_toml("mud.toml", &format!("{HEAD}{more}"))
    }

    #[test]
    fn the_three_ways_to_give_optics() {
        let linear = mud("[linear]\nabsorption = [1, 2, 3.5]\nscattering = [0.5, 0.25, 0]\n").unwrap();
        assert_eq!(linear.coefficients.absorption, [1.0, 2.0, 3.5]);
        let published = mud("[published]\nabsorption = [1, 2, 3]\nscattering = [0.5, 0.2, 0.1]\n").unwrap();
        assert!(published.published.is_some() && linear.published.is_none());
        let hex = mud("[appearance]\nover_white = \"#996633\"\nover_black = \"#110c08\"\n").unwrap();
        let shown = hex.coefficients.layer(1.0).over_ground(LinearRgb::WHITE).to_srgb();
        assert_eq!(shown.to_string(), "#996633");
        let floats = mud("[appearance]\nover_white = [0.6, 0.4, 0.2]\nover_black = \"#110c08\"\n").unwrap();
        let off = floats.coefficients.absorption[0] - hex.coefficients.absorption[0];
        assert!(off.abs() < 1e-12);
    }

    #[test]
    fn problems_name_place_and_cure() {
        let optics = "[linear]\nabsorption = [1, 2, 3]\nscattering = [1, 1, 1]\n";
        for (text, line, message, hint) in [
            (
                format!("{HEAD}stainin = 3\n{optics}"),
                6,
                "unknown key `stainin`",
                "did you mean `staining_power`?",
            ),
            (HEAD.to_owned(), 1, "no optics", "[appearance]"),
            (
                format!("{HEAD}{optics}[appearance]\nover_white = \"#fff\"\nover_black = \"#000\""),
                6,
                "given twice",
                "keep one",
            ),
            (format!("{HEAD}{}", optics.replace("2, 3", "-2, 3")), 7, "outside 0", ""),
            (
                format!("{HEAD}[linear]\nabsorption = [1, 2, 3]"),
                6,
                "`scattering` is missing",
                "scattering = [",
            ),
            (
                format!("{HEAD}character = [\"granulatin\"]\n{optics}"),
                6,
                "cannot be `granulatin`",
                "`granulating`",
            ),
            (HEAD.replace("2.0", "0.04") + optics, 4, "0.04, below 0.05", "at least `density`"),
            (HEAD.replace("0.05", "1.5") + optics, 3, "outside 0 to 1", "fraction"),
            (HEAD.replace("0.5", "nan") + optics, 5, "outside 0 to 1", "grainy"),
            (HEAD.replace("\"mud\"", "\"My mud\"") + optics, 1, "cannot be `My mud`", "burnt-sienna"),
            (
                format!("{HEAD}[appearance]\nover_white = \"#996\"\nover_black = \"#99a\""),
                8,
                "red is 0.6",
                "brighter",
            ),
            (
                format!("{HEAD}[appearance]\nover_white = \"#9966\"\nover_black = \"#99a\""),
                7,
                "`#9966` is not",
                "#rrggbb",
            ),
            (
                format!("{HEAD}[appearance]\nover_white = [1, 2, 3]\nover_black = \"#99a\""),
                7,
                "outside 0 to 1",
                "#rrggbb",
            ),
            (
                format!("{HEAD}[appearance]\nover_white = true\nover_black = \"#99a\""),
                7,
                "list of 3",
                "#rrggbb",
            ),
            (format!("{HEAD}[appearance]\nover_white = \"#99a\""), 6, "lacks `over_black`", "#rrggbb"),
        ] {
            let problem = Pigment::from_toml("mud.toml", &text).unwrap_err();
            assert!(problem.message.contains(message), "{problem}");
            assert_eq!(problem.line, line, "{problem}");
            assert!(problem.hint.clone().unwrap_or_default().contains(hint), "{:?}", problem.hint);
        }
    }

    #[test]
    fn words_are_written_as_read() {
        for (word, character) in Character::WORDS {
            assert_eq!(character.to_string(), *word);
        }
    }

    proptest! {
        #[test]
        fn no_text_makes_the_reader_panic(text in "\\PC{0,200}") {
            let _ = Pigment::from_toml("mud.toml", &text);
        }

        #[test]
        fn no_optics_makes_the_reader_panic(
            way in "linear|published|appearance",
            keys in prop::array::uniform2("absorption|scattering|over_white|over_black"),
            values in prop::array::uniform2(
                "\\[[0-9]{1,3}(\\.[0-9]{1,3})?, [0-9]e-?[0-9]{1,3}, (nan|inf|-?[0-9])\\]|\"#?[0-9a-gé]{0,7}\"|[a-z0-9]{1,3}"
            ),
        ) {
            let text = format!("[{way}]\n{} = {}\n{} = {}\n", keys[0], values[0], keys[1], values[1]);
            if let Ok(pigment) = mud(&text) {
                let seen = pigment.coefficients.layer(1.0).over_ground(LinearRgb::WHITE);
                prop_assert!(seen.0.iter().all(|channel| (0.0..=1.0 + 1e-12).contains(channel)));
            }
        }
    }
}
