//! The paints that come with Girtin, and the painter's own beside them, found by any of their names.

use std::sync::LazyLock;

use crate::pigment::Pigment;

/// The id and text of each pigment's file.
macro_rules! files {
    ($($id:literal),* $(,)?) => {
        &[$(($id, include_str!(concat!("../assets/", $id, ".toml")))),*]
    };
}

/// The files in `assets/pigments`: those of C97's figure 5 in its order, then the others round the color circle, then
/// earths, darks and whites.
const FILES: &[(&str, &str)] = files![
    "quinacridone-rose",
    "indian-red",
    "cadmium-yellow",
    "hookers-green",
    "cerulean-blue",
    "burnt-umber",
    "cadmium-red",
    "brilliant-orange",
    "hansa-yellow",
    "phthalo-green",
    "french-ultramarine",
    "interference-lilac",
    "lemon-yellow",
    "aureolin",
    "nickel-azo-yellow",
    "new-gamboge",
    "hansa-yellow-deep",
    "naples-yellow",
    "quinacridone-gold",
    "yellow-ochre",
    "raw-sienna",
    "cadmium-yellow-light",
    "cadmium-orange",
    "pyrrol-orange",
    "quinacridone-burnt-orange",
    "pyrrol-scarlet",
    "pyrrol-red",
    "rose-madder",
    "alizarin-crimson",
    "perylene-maroon",
    "quinacridone-magenta",
    "cobalt-violet",
    "manganese-violet",
    "ultramarine-violet",
    "dioxazine-violet",
    "indanthrone-blue",
    "ultramarine-deep",
    "cobalt-blue",
    "phthalo-blue",
    "prussian-blue",
    "manganese-blue",
    "cerulean-chromium",
    "phthalo-turquoise",
    "cobalt-turquoise",
    "viridian",
    "cobalt-green",
    "chromium-oxide",
    "terre-verte",
    "perylene-green",
    "sap-green",
    "green-gold",
    "transparent-red-oxide",
    "venetian-red",
    "caput-mortuum",
    "potters-pink",
    "burnt-sienna",
    "raw-umber",
    "van-dyke-brown",
    "sepia",
    "indigo",
    "paynes-grey",
    "neutral-tint",
    "davys-grey",
    "lunar-black",
    "ivory-black",
    "lamp-black",
    "zinc-white",
    "titanium-white",
];

/// Paints by name.
#[derive(Clone, Debug, PartialEq)]
pub struct Library {
    pigments: Vec<Pigment>,
}

/// A name that no pigment has, or that several have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum UnknownPigment {
    /// No pigment has the name.
    #[error("no pigment is called `{name}`")]
    NoSuch {
        /// The name.
        name: String,
        /// Id of the pigment whose name is nearest, if any is near.
        nearest: Option<String>,
    },
    /// Several pigments have the name.
    #[error("several pigments are called `{name}`: {}", ids.join(", "))]
    Several {
        /// The name.
        name: String,
        /// Ids of the pigments.
        ids: Vec<String>,
    },
}

impl UnknownPigment {
    /// What to write instead.
    pub fn hint(&self) -> String {
        match self {
            Self::NoSuch { nearest: Some(id), .. } => format!("did you mean `{id}`?"),
            Self::NoSuch { nearest: None, .. } => "see the list of pigments for every name".to_owned(),
            Self::Several { ids, .. } => format!("choose one of {}", ids.join(", ")),
        }
    }
}

impl Library {
    /// The paints that come with Girtin: the twelve of C97's figure 5 first, in its order.
    pub fn builtin() -> Self {
        static BUILTIN: LazyLock<Library> = LazyLock::new(|| {
            let read = |&(id, text): &(&str, &str)| {
                Pigment::from_toml(&format!("{id}.toml"), text)
                    // `builtin_files_are_sound` reads the same texts.
                    .unwrap_or_else(|problem| panic!("built-in pigment: {problem}"))
            };
            Library { pigments: FILES.iter().map(read).collect() }
        });
        BUILTIN.clone()
    }

    /// This library and one more pigment; one with the same id is replaced in its place.
    #[must_use]
    pub fn with(mut self, pigment: Pigment) -> Self {
        match self.pigments.iter_mut().find(|known| known.id == pigment.id) {
            Some(known) => *known = pigment,
            None => self.pigments.push(pigment),
        }
        self
    }

    /// All pigments: the built-in first, then the painter's own as they were added.
    pub fn iter(&self) -> core::slice::Iter<'_, Pigment> {
        self.pigments.iter()
    }

    /// The pigment of a name: its id, label, an alias or Color Index name, or a Color Index name and one of the
    /// others. Case, spaces, dashes, underscores and apostrophes do not matter.
    ///
    /// # Errors
    /// No pigment has the name, or several have it and none as its id.
    pub fn get(&self, name: &str) -> Result<&Pigment, UnknownPigment> {
        let wanted = folded(name);
        let having = |has: &dyn Fn(&Pigment) -> bool| -> Vec<&Pigment> {
            self.pigments.iter().filter(|pigment| has(pigment)).collect()
        };
        let by_name = |pigment: &Pigment| names(pigment).any(|name| folded(name) == wanted);
        let by_index = |pigment: &Pigment| {
            let index = folded(&pigment.color_index);
            // `PBr7 burnt umber` and `burnt umber PBr7`, as tubes are labelled.
            !index.is_empty()
                && (index == wanted
                    || names(pigment).map(folded).any(|name| {
                        let label = [index.clone() + &name, name + &index];
                        label.contains(&wanted)
                    }))
        };
        // Ids come first: they are unique, so that every pigment can be named whatever others are called.
        let tiers: [&dyn Fn(&Pigment) -> bool; 3] =
            [&|pigment| folded(&pigment.id) == wanted, &by_name, &by_index];
        for tier in tiers {
            match having(tier)[..] {
                [] => {}
                [pigment] => return Ok(pigment),
                ref several => {
                    let ids = several.iter().map(|pigment| pigment.id.clone()).collect();
                    return Err(UnknownPigment::Several { name: name.to_owned(), ids });
                }
            }
        }
        let known =
            || self.pigments.iter().flat_map(|pigment| names(pigment).map(move |name| (name, pigment)));
        let nearest = girtin_params::nearest(name, known().map(|(name, _)| name));
        let nearest = nearest
            .and_then(|near| known().find(|&(name, _)| name == near))
            .map(|(_, pigment)| pigment.id.clone());
        Err(UnknownPigment::NoSuch { name: name.to_owned(), nearest })
    }
}

impl<'a> IntoIterator for &'a Library {
    type Item = &'a Pigment;
    type IntoIter = core::slice::Iter<'a, Pigment>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

fn names(pigment: &Pigment) -> impl Iterator<Item = &str> {
    [pigment.id.as_str(), pigment.label.as_str()]
        .into_iter()
        .chain(pigment.aliases.iter().map(String::as_str))
}

/// A name without what does not matter in it.
fn folded(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};

    use super::*;
    use crate::color::LinearRgb;
    use crate::pigment::Character;

    #[test]
    fn every_file_is_in_the_table() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/assets");
        let on_disk: BTreeSet<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .filter_map(|name| name.strip_suffix(".toml").map(str::to_owned))
            .collect();
        let in_table: BTreeSet<String> = FILES.iter().map(|(id, _)| (*id).to_owned()).collect();
        assert_eq!(on_disk, in_table);
        assert_eq!(in_table.len(), FILES.len(), "a file is in the table twice");
    }

    #[test]
    fn builtin_files_are_sound() {
        for (file, text) in FILES {
            let pigment = Pigment::from_toml(&format!("{file}.toml"), text)
                .unwrap_or_else(|problem| panic!("{problem}\n{}", problem.hint.clone().unwrap_or_default()));
            assert_eq!(pigment.id, *file);
            assert!(!pigment.label.is_empty() && !pigment.source.is_empty(), "{file}");
            assert!(!pigment.character.is_empty(), "{file}");
        }
    }

    /// K, S, ρ, ω, γ as the table under C97's figure 5 prints them.
    #[rustfmt::skip]
    const FIGURE_5: [(&str, [f64; 9]); 12] = [
        ("quinacridone-rose", [0.22, 1.47, 0.57, 0.05, 0.003, 0.03, 0.02, 5.5, 0.81]),
        ("indian-red", [0.46, 1.07, 1.50, 1.28, 0.38, 0.21, 0.05, 7.0, 0.40]),
        ("cadmium-yellow", [0.10, 0.36, 3.45, 0.97, 0.65, 0.007, 0.05, 3.4, 0.81]),
        ("hookers-green", [1.62, 0.61, 1.64, 0.01, 0.012, 0.003, 0.09, 1.0, 0.41]),
        ("cerulean-blue", [1.52, 0.32, 0.25, 0.06, 0.26, 0.40, 0.01, 1.0, 0.31]),
        ("burnt-umber", [0.74, 1.54, 2.10, 0.09, 0.09, 0.004, 0.09, 9.3, 0.90]),
        ("cadmium-red", [0.14, 1.08, 1.68, 0.77, 0.015, 0.018, 0.02, 1.0, 0.63]),
        ("brilliant-orange", [0.13, 0.81, 3.45, 0.005, 0.009, 0.007, 0.01, 1.0, 0.14]),
        ("hansa-yellow", [0.06, 0.21, 1.78, 0.50, 0.88, 0.009, 0.06, 1.0, 0.08]),
        ("phthalo-green", [1.55, 0.47, 0.63, 0.01, 0.05, 0.035, 0.02, 1.0, 0.12]),
        ("french-ultramarine", [0.86, 0.86, 0.06, 0.005, 0.005, 0.09, 0.01, 3.1, 0.91]),
        ("interference-lilac", [0.08, 0.11, 0.07, 1.25, 0.42, 1.43, 0.06, 1.0, 0.08]),
    ];

    #[test]
    fn the_twelve_come_first_as_printed() {
        let library = Library::builtin();
        for (pigment, (id, [kr, kg, kb, sr, sg, sb, rho, omega, gamma])) in library.iter().zip(FIGURE_5) {
            let published = pigment.published.unwrap_or_else(|| panic!("{id} has no published K and S"));
            assert_eq!(pigment.id, id);
            assert_eq!((published.absorption, published.scattering), ([kr, kg, kb], [sr, sg, sb]), "{id}");
            let handling = pigment.handling;
            let values = (handling.density, handling.staining_power, handling.granulation);
            assert_eq!(values, (rho, omega, gamma), "{id}");
        }
        assert!(library.iter().skip(12).all(|pigment| pigment.published.is_none()));
    }

    #[test]
    fn every_name_finds_its_pigment() {
        let library = Library::builtin();
        let mut owner: BTreeMap<String, &str> = BTreeMap::new();
        for pigment in &library {
            for name in names(pigment) {
                assert_eq!(
                    library.get(name).map(|found| found.id.as_str()),
                    Ok(pigment.id.as_str()),
                    "{name}"
                );
                let before = owner.insert(folded(name), &pigment.id);
                assert!(before.is_none_or(|before| before == pigment.id), "{name} is also {before:?}");
            }
        }
    }

    #[test]
    fn spelling_of_names_is_free() {
        let library = Library::builtin();
        for name in ["FRENCH ULTRAMARINE", "french_ultramarine", "ultramarine", "pb 29 Ultramarine"] {
            assert_eq!(library.get(name).unwrap().id, "french-ultramarine", "{name}");
        }
        assert_eq!(library.get("Hooker's Green").unwrap().id, "hookers-green");
        assert_eq!(library.get("pb28").unwrap().id, "cobalt-blue");
        assert_eq!(library.get("PG7 + PY150").unwrap().id, "sap-green");
    }

    #[test]
    fn unknown_and_ambiguous_names_are_helped() {
        let library = Library::builtin();
        let error = library.get("burnt siena").unwrap_err();
        assert_eq!(error.hint(), "did you mean `burnt-sienna`?");
        let error = library.get("pbr7").unwrap_err();
        assert!(matches!(&error, UnknownPigment::Several { ids, .. } if ids.len() >= 4), "{error}");
        assert!(error.hint().contains("burnt-umber"));
        for name in ["", "  ", "xyzzyxyzzy", "é"] {
            assert!(matches!(library.get(name), Err(UnknownPigment::NoSuch { .. })), "{name}");
        }
    }

    #[test]
    fn every_pigment_is_written_as_it_is_met() {
        for pigment in &Library::builtin() {
            let again = Pigment::from_toml("again.toml", &pigment.to_toml()).unwrap();
            assert_eq!(again, Pigment { published: None, ..pigment.clone() });
        }
    }

    #[test]
    fn own_pigments_are_added_or_replace() {
        let library = Library::builtin();
        let count = library.iter().count();
        let mut mine = library.get("viridian").unwrap().clone();
        mine.label = "My Viridian".to_owned();
        let library = library.with(mine.clone());
        assert_eq!((library.iter().count(), library.get("my viridian")), (count, Ok(&mine)));
        mine.id = "my-green".to_owned();
        let library = library.with(mine);
        assert_eq!(library.iter().last().unwrap().id, "my-green");
        assert!(matches!(library.get("My Viridian"), Err(UnknownPigment::Several { .. })));
    }

    /// How light a full wash over black is: the veil that painters judge opacity by.
    #[test]
    fn words_about_opacity_agree_with_the_optics() {
        for pigment in &Library::builtin() {
            let veil = pigment.coefficients.layer(1.0).over_ground(LinearRgb::BLACK).to_lab().l;
            let bands = [
                (Character::Transparent, 0.0..7.5),
                (Character::SemiTransparent, 4.0..25.0),
                (Character::SemiOpaque, 10.0..60.0),
                (Character::Opaque, 22.0..100.0),
            ];
            let said: Vec<_> = bands.into_iter().filter(|&(word, _)| pigment.is(word)).collect();
            assert_eq!(said.len(), 1, "{}: one word for opacity", pigment.id);
            assert!(said[0].1.contains(&veil), "{}: {veil:.1} is not {}", pigment.id, said[0].0);
        }
    }

    #[test]
    fn thin_washes_are_light_tints() {
        for pigment in &Library::builtin() {
            let tint = pigment.coefficients.layer(0.05).over_ground(LinearRgb::WHITE).to_lab();
            assert!(tint.l > 85.0, "{}: {tint:?}", pigment.id);
        }
    }
}
