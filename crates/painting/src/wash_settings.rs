//! The TOML that says how a wash is run: its model, its parameters and its pigments.

use girtin_optics::Pigment;
use girtin_params::read::Fault;
use girtin_params::{Problem, Table, parse};
use girtin_wash::{C97Params, Capillary, PigmentHandling, WashModel};

/// What a `wash.toml` says; every key may be left out.
///
/// ```
/// use girtin_painting::WashSettings;
///
/// let text = "model = 'c97'\npigments = ['french-ultramarine']\nviscosity = 0.2\n[capillary]\n";
/// let settings = WashSettings::from_toml("wash.toml", text)?;
/// assert_eq!(settings.pigments, ["french-ultramarine"]);
/// # Ok::<(), girtin_params::Problem>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WashSettings {
    /// The physics and its parameters.
    pub model: WashModel,
    /// Names of the pigments, in the order of the state's first axis.
    pub pigments: Vec<String>,
}

impl WashSettings {
    /// Reads a whole file.
    ///
    /// # Errors
    /// The text is not TOML, a key is unknown or a value not allowed.
    pub fn from_toml(origin: &str, text: &str) -> Result<Self, Problem> {
        let read = |table: &Table<'_>| {
            Ok(Self { model: read_model(table)?, pigments: table.texts("pigments")?.unwrap_or_default() })
        };
        parse(origin, text, read)
    }
}

/// Reads the model and its parameters from the keys of a table.
pub(crate) fn read_model(table: &Table<'_>) -> Result<WashModel, Fault> {
    table.word("model", &[("c97", ())])?;
    let params = table.parameters::<C97Params>()?;
    let capillary = table.table("capillary", |table| table.parameters::<Capillary>())?;
    Ok(WashModel::C97 { params, capillary })
}

/// How a pigment of the library behaves in water.
pub fn handling_of(pigment: &Pigment) -> PigmentHandling {
    let handling = pigment.handling;
    PigmentHandling {
        density: handling.density,
        staining_power: handling.staining_power,
        granulation: handling.granulation,
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn no_file_of_known_words_makes_the_reader_panic(
            text in "((model|pigments|viscosity|edge_kernel|capacity|\\[capillary\\]) ?=? ?(-?[0-9e.]{0,6}|'(c97|living)'|\\[[0-9.,']*\\])\n){0,6}"
        ) {
            let _ = WashSettings::from_toml("wash.toml", &text);
        }
    }

    #[test]
    fn an_empty_file_is_the_model_s_defaults() {
        assert_eq!(WashSettings::from_toml("wash.toml", "").unwrap(), WashSettings::default());
    }

    #[test]
    fn the_capillary_layer_is_on_when_its_table_is_there() {
        let settings = WashSettings::from_toml("wash.toml", "[capillary]\nabsorption = 0.1\n").unwrap();
        let WashModel::C97 { capillary, .. } = settings.model;
        assert_eq!(capillary, Some(Capillary { absorption: 0.1, ..Capillary::default() }));
    }

    #[test]
    fn unknown_keys_and_models_are_refused() {
        let hint = |text: &str| WashSettings::from_toml("wash.toml", text).unwrap_err().hint;
        assert_eq!(hint("viscosty = 0.1").as_deref(), Some("did you mean `viscosity`?"));
        assert_eq!(hint("[capillary]\nabsorbtion = 0.1").as_deref(), Some("did you mean `absorption`?"));
        assert!(hint("model = 'c98'").is_some());
    }
}
