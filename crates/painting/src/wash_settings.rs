//! The TOML that says how a wash is run: its model, its parameters and its pigments.

use girtin_optics::Pigment;
use girtin_params::read::Fault;
use girtin_params::{Place, Problem, Table, parse};
use girtin_wash::{C97Params, Capillary, LivingParams, PigmentHandling, WashModel};

/// What a `wash.toml` says; every key may be left out.
///
/// ```
/// use girtin_painting::WashSettings;
/// use girtin_wash::WashModel;
///
/// let text = "model = 'c97'\npigments = ['french-ultramarine']\nviscosity = 0.2\n[capillary]\n";
/// let settings = WashSettings::from_toml("wash.toml", text, WashModel::default())?;
/// assert_eq!(settings.pigments, ["french-ultramarine"]);
/// # Ok::<(), girtin_params::Problem>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WashSettings {
    /// The physics and its parameters.
    pub model: WashModel,
    /// Names of the pigments, in the order of the state's first axis.
    pub pigments: Vec<String>,
    /// Where the file names each of them.
    pub pigment_places: Vec<Place>,
}

impl WashSettings {
    /// Reads a whole file; `default` says which model is meant if it names none.
    ///
    /// # Errors
    /// The text is not TOML, a key is unknown or a value not allowed.
    pub fn from_toml(origin: &str, text: &str, default: WashModel) -> Result<Self, Problem> {
        let read = |table: &Table<'_>| {
            Ok(Self {
                model: read_model(table, default)?,
                pigments: table.texts("pigments")?.unwrap_or_default(),
                pigment_places: table.places("pigments"),
            })
        };
        parse(origin, text, read)
    }
}

/// Which physics a file names.
#[derive(Clone, Copy, PartialEq)]
enum Named {
    C97,
    Living,
}

/// Reads the model and its parameters from the keys of a table; `default` says which model is meant if none is named.
///
/// C97's parameters are keys of the table itself and of its `[capillary]`; those of the living wash are under `[living]`.
///
/// # Errors
/// A key is of the other model, or a value not allowed.
pub fn read_model(table: &Table<'_>, default: WashModel) -> Result<WashModel, Fault> {
    let named = table.word("model", &[("c97", Named::C97), ("living", Named::Living)])?;
    let is_living = match named {
        Some(named) => named == Named::Living,
        // A table of the one model names it as well.
        None if table.has("living") => true,
        None if table.has("capillary") => false,
        None => matches!(default, WashModel::Living(_)),
    };
    if is_living {
        let params = table.table("living", |table| table.parameters::<LivingParams>())?;
        return Ok(WashModel::Living(params.unwrap_or_default()));
    }
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
            let _ = WashSettings::from_toml("wash.toml", &text, WashModel::c97());
        }
    }

    #[test]
    fn an_empty_file_is_the_model_s_defaults() {
        assert_eq!(
            WashSettings::from_toml("wash.toml", "", WashModel::default()).unwrap(),
            WashSettings::default()
        );
    }

    #[test]
    fn the_capillary_layer_is_on_when_its_table_is_there() {
        let text = "[capillary]\nabsorption = 0.1\n";
        let settings = WashSettings::from_toml("wash.toml", text, WashModel::default()).unwrap();
        let WashModel::C97 { capillary, .. } = settings.model else { panic!("the table is C97's") };
        assert_eq!(capillary, Some(Capillary { absorption: 0.1, ..Capillary::default() }));
    }

    #[test]
    fn the_living_wash_has_a_table_of_its_own() {
        let read = |text| WashSettings::from_toml("wash.toml", text, WashModel::c97());
        let living = LivingParams { evaporation: 0.0, ..LivingParams::default() };
        let wanted = WashModel::Living(living);
        assert_eq!(read("[living]\nevaporation = 0\n").unwrap().model, wanted);
        assert_eq!(read("model = 'living'\n[living]\nevaporation = 0\n").unwrap().model, wanted);
        assert_eq!(read("model = 'living'\n").unwrap().model, WashModel::living());
        assert!(read("model = 'living'\nviscosity = 0.1\n").is_err(), "a key of C97");
        assert!(read("model = 'c97'\n[living]\n").is_err(), "a table of the living wash");
    }

    #[test]
    fn unknown_keys_and_models_are_refused() {
        let hint =
            |text: &str| WashSettings::from_toml("wash.toml", text, WashModel::c97()).unwrap_err().hint;
        assert_eq!(hint("viscosty = 0.1").as_deref(), Some("did you mean `viscosity`?"));
        assert_eq!(hint("[capillary]\nabsorbtion = 0.1").as_deref(), Some("did you mean `absorption`?"));
        assert!(hint("model = 'c98'").is_some());
    }
}
