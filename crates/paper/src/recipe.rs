//! What kind of paper it is: a recipe of layers, read from TOML.

use girtin_params::read::{Fault, Table};
use girtin_params::row::Parameters;
use girtin_params::write::{Node, Tree};
use girtin_params::{Problem, parse};

use crate::layers::Layer;

girtin_params::parameters! {
    /// How far a paper's surface goes up and down.
    pub struct Surface {
        relief: f64 {
            symbol: "", label: "Relief", unit: "", default: 0.17, hard: (0.005, 0.5), soft: (0.02, 0.25),
            acts: Simulation,
            doc: "Standard deviation of the height, which runs from 0 to 1. Smooth papers stay near the middle.",
            source: "Curtis et al. 1997, §4.1: 0 < h < 1",
        }
        depth_mm: f64 {
            symbol: "", label: "Depth", unit: "mm", default: 0.15, hard: (0.001, 2.0), soft: (0.02, 0.5),
            acts: Appearance, doc: "How much higher a point of height 1 is than one of height 0.",
            source: "custom",
        }
    }
}

/// Layers of a recipe, at most: a hand-written one has five.
const MOST_LAYERS: usize = 16;

/// Millimetres of fiber to a square millimetre, at most.
const MOST_FIBER: f64 = 40.0;

/// A kind of paper.
#[derive(Clone, Debug, PartialEq)]
pub struct Paper {
    /// Name in files and on the command line: lower case, with hyphens.
    pub id: String,
    /// Name for people.
    pub label: String,
    /// What it is and what it is good for, in a sentence.
    pub about: String,
    /// Other names that find it.
    pub aliases: Vec<String>,
    /// How far the surface goes up and down.
    pub surface: Surface,
    layers: Vec<Layer>,
}

impl Paper {
    /// Reads a recipe; `origin` is the name of its file, for messages.
    ///
    /// # Errors
    /// The text is not TOML, a key is unknown or missing, a value is outside its range, or no layer is left.
    pub fn from_toml(origin: &str, text: &str) -> Result<Self, Problem> {
        parse(origin, text, |table| {
            let paper = Self {
                id: name(table, "id", &table.need_text("id")?)?,
                label: table.need_text("label")?,
                about: table.text("about")?.unwrap_or_default(),
                aliases: table
                    .texts("aliases")?
                    .unwrap_or_default()
                    .iter()
                    .map(|alias| name(table, "aliases", alias))
                    .collect::<Result<_, _>>()?,
                surface: table.parameters()?,
                layers: layers(table)?,
            };
            match paper.layers.len() {
                0 => Err(table
                    .fault("label", "the paper has no layers")
                    .hint("add `[[tooth]]` with an amount")),
                1..=MOST_LAYERS => Ok(paper),
                many => {
                    Err(table
                        .fault("label", format!("the paper has {many} layers; {MOST_LAYERS} are allowed")))
                }
            }
        })
    }

    /// The recipe as a file of its own, with every value.
    pub fn to_toml(&self) -> String {
        let aliases: Vec<&str> = self.aliases.iter().map(String::as_str).collect();
        let file = Tree::new()
            .with("id", self.id.as_str())
            .with("label", self.label.as_str())
            .with("about", self.about.as_str())
            .with("aliases", aliases)
            .and(Tree::of_parameters(&self.surface));
        let of_kind = |file: Tree, kind: &str| {
            let layers = self.layers.iter().map(said).filter(|(key, _)| *key == kind);
            file.with(kind, Node::Sections(layers.map(|(_, tree)| tree).collect()))
        };
        KINDS.into_iter().fold(file, of_kind).to_toml()
    }

    /// What the relief is a sum of; never empty.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }
}

/// Keys of the layers, in the order in which [`layers`] reads them.
const KINDS: [&str; 5] = ["tooth", "pebbles", "laid", "weave", "fibers"];

/// The key of a layer, and what stands under it.
fn said(layer: &Layer) -> (&'static str, Tree) {
    match layer {
        Layer::Tooth(tooth) => ("tooth", Tree::of_parameters(tooth)),
        Layer::Pebbles(pebbles) => ("pebbles", Tree::of_parameters(pebbles)),
        Layer::Laid(laid) => ("laid", Tree::of_parameters(laid)),
        Layer::Weave(weave) => ("weave", Tree::of_parameters(weave)),
        Layer::Fibers(fibers) => ("fibers", Tree::of_parameters(fibers)),
    }
}

/// A name as papers are found by: lower case, with hyphens for spaces and underscores.
pub(crate) fn plain(name: &str) -> String {
    name.trim().to_lowercase().replace(['_', ' '], "-")
}

fn name(table: &Table<'_>, key: &str, text: &str) -> Result<String, Fault> {
    let allowed = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    if !text.is_empty() && text.chars().all(allowed) {
        return Ok(text.to_owned());
    }
    let better: String = plain(text).chars().filter(|&c| allowed(c)).collect();
    let better = if better.is_empty() { "my-paper" } else { &better };
    Err(table
        .fault(key, format!("`{text}` is no name for a paper: lower-case letters, digits and hyphens only"))
        .hint(format!("for example `{better}`")))
}

fn layers(table: &Table<'_>) -> Result<Vec<Layer>, Fault> {
    let mut layers = Vec::new();
    read(table, "tooth", &mut layers, Layer::Tooth)?;
    read(table, "pebbles", &mut layers, Layer::Pebbles)?;
    read(table, "laid", &mut layers, Layer::Laid)?;
    read(table, "weave", &mut layers, Layer::Weave)?;
    let before = layers.len();
    read(table, "fibers", &mut layers, Layer::Fibers)?;
    for layer in &layers[before..] {
        let Layer::Fibers(fibers) = layer else { continue };
        let length = fibers.per_mm2 * fibers.length_mm[1];
        if length > MOST_FIBER {
            return Err(table
                .fault(
                    "fibers",
                    format!("{length:.0} mm of fiber to a square millimetre; {MOST_FIBER} at most"),
                )
                .hint("lower `per_mm2` or `length_mm`"));
        }
    }
    Ok(layers)
}

/// The layers of one kind; those of amount 0 are left out.
fn read<P: Parameters>(
    table: &Table<'_>,
    key: &str,
    layers: &mut Vec<Layer>,
    layer: impl Fn(P) -> Layer,
) -> Result<(), Fault> {
    let read = table.tables(key, |table| table.parameters().map(&layer))?.unwrap_or_default();
    layers.extend(read.into_iter().filter(|layer| layer.amount() != 0.0));
    Ok(())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const PLAIN: &str = "id = \"felt\"\nlabel = \"Felt\"\n[[tooth]]\nwavelength_mm = 0.8\n";

    #[test]
    fn what_is_left_out_has_its_default() {
        let paper = Paper::from_toml("felt.toml", PLAIN).unwrap();
        assert_eq!(paper.surface, Surface::default());
        let [Layer::Tooth(tooth)] = paper.layers() else { panic!("one tooth") };
        assert_eq!((tooth.wavelength_mm, tooth.octaves), (0.8, 3));
    }

    #[test]
    fn a_recipe_is_written_and_read_again() {
        let every = "id = \"x\"\nlabel = \"é\"\naliases = [\"y\"]\n[[fibers]]\namount = 0.3\n[[weave]]\n[[laid]]\n\
            [[pebbles]]\n[[pebbles]]\namount = -0.1\n[[tooth]]\n";
        let every = Paper::from_toml("x.toml", every).unwrap();
        assert_eq!(every.layers().len(), 6);
        for paper in crate::Papers::builtin().iter().chain([&every]) {
            assert_eq!(Paper::from_toml("again.toml", &paper.to_toml()).unwrap(), *paper);
        }
    }

    #[track_caller]
    fn fails(text: &str, line: usize, message: &str, hint: &str) {
        let problem = Paper::from_toml("felt.toml", text).unwrap_err();
        assert_eq!(problem.line, line, "{problem}");
        assert!(problem.message.contains(message), "{problem}");
        assert!(problem.hint.as_deref().unwrap_or("").contains(hint), "{problem}, {:?}", problem.hint);
    }

    #[test]
    fn mistakes_are_named_with_their_place_and_a_hint() {
        fails(
            &PLAIN.replace("wavelength_mm", "wave_length"),
            4,
            "unknown key `tooth[1].wave_length`",
            "wavelength_mm",
        );
        fails(&PLAIN.replace("0.8", "80"), 4, "is 80, outside 0.13 to 50", "");
        fails(&PLAIN.replace("\"felt\"", "\"My Felt\""), 1, "no name for a paper", "my-felt");
        fails(&format!("{PLAIN}[[toth]]\n"), 5, "unknown key `toth`", "tooth");
        fails("id = \"felt\"\nlabel = \"Felt\"\n", 2, "no layers", "[[tooth]]");
        fails(&PLAIN.replace("wavelength_mm = 0.8", "amount = 0"), 2, "no layers", "[[tooth]]");
        fails(
            "id = \"felt\"\nlabel = \"Felt\"\n[[fibers]]\nper_mm2 = 20\nlength_mm = [2, 30]\n",
            3,
            "600 mm of fiber",
            "lower `per_mm2`",
        );
        fails("label = 3\n", 1, "lacks `id`", "add `id`");
    }

    proptest! {
        #[test]
        fn no_text_panics(text in "\\PC{0,80}") {
            let _ = Paper::from_toml("any", &text);
        }

        #[test]
        fn no_value_panics(
            kind in "tooth|pebbles|laid|weave|fibers",
            key in "amount|wavelength_mm|octaves|size_mm|line_mm|thread_mm|length_mm|width_mm|per_mm2|relief",
            value in "-?[0-9]{1,3}(\\.[0-9]{1,3})?|\\[[0-9.]{1,4}, [0-9.]{1,4}\\]|nan|-inf|true|\"x\"|\\{\\}",
        ) {
            let text = format!("id = \"x\"\nlabel = \"\"\n[[{kind}]]\n{key} = {value}\n");
            if let Ok(paper) = Paper::from_toml("any", &text) {
                use crate::HeightSource;
                let heights = crate::Sheet::new(&paper, 1).height_field(3, 2, 4.0, [0.0, 0.0]);
                prop_assert!(heights.as_slice().iter().all(|&h| 0.0 < h && h < 1.0));
            }
        }
    }
}
