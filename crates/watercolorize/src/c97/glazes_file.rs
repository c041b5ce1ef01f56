//! Which pigments each matte has, and every number of the method, as TOML.
//!
//! ```
//! use girtin_painting::Stock;
//! use girtin_watercolorize::c97::GlazesFile;
//!
//! let text = r#"
//! format = 1
//! steps = 20
//! [[matte]]
//! name = "pears"
//! pigments = ["hansa-yellow", "quinacridone-rose", "burnt-umber"]
//! max_thickness = [2, 1.5, 0.5]
//! [matte.planning]
//! interval = 50
//! delta_g = 0.1
//! [matte.wash]
//! edge_darkening = 0.03
//! [[lift]]
//! name = "highlights"
//! "#;
//! let glazes = GlazesFile::from_toml("glazes.toml", text, &Stock::builtin())?;
//! assert_eq!(glazes.mattes[0].planning.phi_g, -0.1);
//! assert_eq!(glazes.matte_names(), ["pears", "highlights"]);
//! # Ok::<(), girtin_params::Problem>(())
//! ```

use girtin_painting::Stock;
use girtin_painting::wash_settings::read_model;
use girtin_params::read::Fault;
use girtin_params::row::Parameters;
use girtin_params::{Problem, Table, parse};
use girtin_wash::{C97Params, WashModel};

use super::separation::{MAX_PIGMENTS, SeparationParams};
use super::{PlanningParams, separation};

/// Version of the format that is read.
pub const FORMAT: u32 = 1;

/// Part of the paint that a lift takes when nothing is said.
const LIFTED: f64 = 0.8;

/// What to paint each matte with.
#[derive(Clone, Debug, PartialEq)]
pub struct GlazesFile {
    /// How colors are separated; its greatest thickness is that of mattes that give none.
    pub separation: SeparationParams,
    /// Mattes in the order in which they are painted.
    pub mattes: Vec<MatteGlazes>,
    /// Highlights that are lifted at the end.
    pub lifts: Vec<Lift>,
}

/// The glazes of one matte.
#[derive(Clone, Debug, PartialEq)]
pub struct MatteGlazes {
    /// Name of the matte.
    pub name: String,
    /// Ids of the pigments from the paper up, one a glaze.
    pub pigments: Vec<String>,
    /// Greatest thickness of each of them.
    pub max_thickness: Vec<f64>,
    /// How the glazes are painted.
    pub planning: PlanningParams,
    /// Their physics.
    pub model: WashModel,
}

/// A highlight.
#[derive(Clone, Debug, PartialEq)]
pub struct Lift {
    /// Name of its matte.
    pub name: String,
    /// How much of the paint is taken where the matte is 1.
    pub fraction: f64,
}

impl GlazesFile {
    /// Reads the file; pigments are looked up in `stock`.
    ///
    /// # Errors
    /// The text is not TOML, a key or name is unknown, a value is not allowed, or there are more stacks than can be tried.
    pub fn from_toml(origin: &str, text: &str, stock: &Stock) -> Result<Self, Problem> {
        parse(origin, text, |table| read(table, stock))
    }

    /// The mattes that it names, each once, in its order.
    pub fn matte_names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        let mattes = self.mattes.iter().map(|matte| &matte.name);
        for name in mattes.chain(self.lifts.iter().map(|lift| &lift.name)) {
            if !names.contains(&name.as_str()) {
                names.push(name);
            }
        }
        names
    }
}

fn read(table: &Table<'_>, stock: &Stock) -> Result<GlazesFile, Fault> {
    table.need_format(FORMAT)?;
    let separation: SeparationParams = table.parameters()?;
    let mattes = table.tables("matte", |matte| read_matte(matte, &separation, stock))?.unwrap_or_default();
    if mattes.is_empty() {
        let hint = "add `[[matte]]` with the `name` of a matte and its `pigments`";
        return Err(table.fault("matte", "the file names no matte to paint").hint(hint));
    }
    let lifts = table.tables("lift", |lift| {
        let fraction = lift.real("fraction", 0.0..=1.0)?.unwrap_or(LIFTED);
        Ok(Lift { name: read_name(lift)?, fraction })
    })?;
    Ok(GlazesFile { separation, mattes, lifts: lifts.unwrap_or_default() })
}

/// The name of a matte. It becomes part of the names of maps, so it may not lead out of their folder.
fn read_name(table: &Table<'_>) -> Result<String, Fault> {
    let name = table.need_text("name")?;
    let is_odd = |letter: char| letter.is_control() || matches!(letter, '/' | '\\' | ':');
    if name.is_empty() || name.starts_with('.') || name.contains(is_odd) {
        let message = format!("`{name}` cannot be the name of a matte");
        return Err(table
            .fault("name", message)
            .hint("give the matte's file name without folder and ending"));
    }
    Ok(name)
}

fn read_matte(table: &Table<'_>, separation: &SeparationParams, stock: &Stock) -> Result<MatteGlazes, Fault> {
    let name = read_name(table)?;
    let mut pigments = Vec::new();
    for pigment in table.texts("pigments")?.unwrap_or_default() {
        match stock.pigments.get(&pigment) {
            Ok(pigment) => pigments.push(pigment.id.clone()),
            Err(error) => return Err(table.fault("pigments", error.to_string()).hint(error.hint())),
        }
    }
    if pigments.is_empty() {
        let hint = "add `pigments`, a list of names from the paper up";
        return Err(table.fault("pigments", format!("matte `{name}` has no pigments")).hint(hint));
    }
    let steps = separation.steps as usize;
    let stacks = steps.checked_pow(pigments.len() as u32);
    if pigments.len() > MAX_PIGMENTS || stacks.is_none_or(|stacks| stacks > separation::MAX_STACKS) {
        let message = separation::TooManyStacks { steps, pigments: pigments.len() }.to_string();
        return Err(table.fault("pigments", message).hint("name fewer pigments or lower `steps`"));
    }
    let planning = table.table("planning", |planning| {
        let has_phi_g = planning.has("phi_g");
        let mut params: PlanningParams = planning.parameters()?;
        if !has_phi_g {
            params.phi_g = -params.delta_g;
        }
        Ok(params)
    })?;
    let model = table.table("wash", |wash| {
        let has_edges = wash.has("edge_darkening");
        Ok(if has_edges {
            read_model(wash, WashModel::c97())?
        } else {
            with_few_rims(read_model(wash, WashModel::c97())?)
        })
    })?;
    Ok(MatteGlazes {
        max_thickness: read_max_thickness(table, separation, pigments.len())?,
        planning: planning.unwrap_or_default(),
        model: model.unwrap_or_else(|| with_few_rims(WashModel::c97())),
        name,
        pigments,
    })
}

/// Edge darkening of a wash that says none: a glaze runs four times as long as the washes whose default is 0.02, so that it
/// would pile up four times the rim, and mattes that lie side by side show it twice.
const EDGE_DARKENING: f64 = 0.005;

/// W7: the model with less edge darkening.
fn with_few_rims(model: WashModel) -> WashModel {
    match model {
        WashModel::C97 { params, capillary } => {
            WashModel::C97 { params: C97Params { edge_darkening: EDGE_DARKENING, ..params }, capillary }
        }
        WashModel::Living(_) => model,
    }
}

/// One number for all pigments, or one for each.
fn read_max_thickness(
    table: &Table<'_>,
    separation: &SeparationParams,
    pigments: usize,
) -> Result<Vec<f64>, Fault> {
    const KEY: &str = "max_thickness";
    let row = SeparationParams::ROWS.iter().find(|row| row.id == KEY);
    let (low, high) = row.map_or((0.0, 1.0), |row| row.hard);
    // A number is one even where it is not allowed; only what is none may be a list.
    match table.real(KEY, f64::MIN..=f64::MAX) {
        Ok(None) => return Ok(vec![separation.max_thickness; pigments]),
        Ok(Some(_)) => return Ok(vec![table.need_real(KEY, low..=high)?; pigments]),
        Err(_) => {}
    }
    let each = table.real_list(KEY, low..=high)?.unwrap_or_default();
    if each.len() == pigments {
        return Ok(each);
    }
    let message = format!("`{KEY}` has {} numbers for {pigments} pigments", each.len());
    Err(table.fault(KEY, message).hint("give one number, or one for each pigment"))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn from_toml(text: &str) -> Result<GlazesFile, Problem> {
        GlazesFile::from_toml("glazes.toml", text, &Stock::builtin())
    }

    const ONE: &str = "format = 1\n[[matte]]\nname = 'a'\npigments = ['umber', 'rose']\n";

    #[test]
    fn what_is_not_said_is_as_printed_but_for_rims() {
        let file =
            from_toml(&ONE.replace("umber", "burnt umber").replace("rose", "quinacridone rose")).unwrap();
        let matte = &file.mattes[0];
        assert_eq!(matte.pigments, ["burnt-umber", "quinacridone-rose"]);
        assert_eq!(matte.max_thickness, [2.0, 2.0]);
        assert_eq!((file.separation.steps, matte.planning), (20, PlanningParams::default()));
        let rims = |model| match model {
            WashModel::C97 { params, .. } => params.edge_darkening,
            WashModel::Living(_) => 0.0,
        };
        assert_eq!((with_few_rims(WashModel::c97()), rims(matte.model)), (matte.model, EDGE_DARKENING));
        let told = |text: &str| {
            rims(
                from_toml(&format!("{}[matte.wash]\n{text}\n", ONE.replace("'umber', 'rose'", "'sepia'")))
                    .unwrap()
                    .mattes[0]
                    .model,
            )
        };
        let (said, unsaid) = (told("edge_darkening = 0.03"), told("viscosity = 0.2"));
        assert_eq!((said, unsaid), (0.03, EDGE_DARKENING));
        assert_eq!(matte.planning.phi_g, -matte.planning.delta_g);
    }

    #[test]
    fn a_thickness_is_for_all_pigments_or_for_each() {
        let read = |line: &str| {
            let text = format!(
                "format = 1\nmax_thickness = 3\n[[matte]]\nname = 'a'\npigments = ['hansa-yellow', 'burnt-umber']\n{line}\n"
            );
            from_toml(&text).map(|file| file.mattes[0].max_thickness.clone())
        };
        assert_eq!(read("").unwrap(), [3.0, 3.0]);
        assert_eq!(read("max_thickness = 1").unwrap(), [1.0, 1.0]);
        assert_eq!(read("max_thickness = [1, 0.5]").unwrap(), [1.0, 0.5]);
        for (line, reason) in [
            ("max_thickness = [1]", "1 numbers for 2 pigments"),
            ("max_thickness = -1", "outside"),
            ("max_thickness = [1, 0]", "outside"),
            ("max_thickness = 'much'", "must be a list of numbers"),
        ] {
            let problem = read(line).unwrap_err();
            assert!(problem.message.contains(reason), "{problem}");
            assert_eq!(problem.line, 6, "{problem}");
        }
    }

    #[test]
    fn what_cannot_be_is_refused_with_its_place() {
        let good = "name = 'a'\npigments = ['hansa-yellow']\n";
        for (text, line, reason) in [
            ("steps = 20\n".to_owned(), 1, "lacks `format`"),
            ("format = 2\n".to_owned(), 1, "format 2"),
            ("format = 1\n".to_owned(), 1, "no matte"),
            (format!("format = 1\nstep = 20\n[[matte]]\n{good}"), 2, "unknown key `step`"),
            (
                format!("format = 1\n[[matte]]\n{good}[matte.planning]\ndelta = 1\n"),
                6,
                "matte[1].planning.delta",
            ),
            (format!("format = 1\n[[matte]]\n{good}[matte.wash]\nviscosty = 1\n"), 6, "viscosty"),
            ("format = 1\n[[matte]]\nname = 'a'\n".to_owned(), 2, "no pigments"),
            ("format = 1\n[[matte]]\nname = '../a'\npigments = ['hansa-yellow']\n".to_owned(), 3, "`../a`"),
            ("format = 1\n[[matte]]\nname = 'a'\npigments = ['hansa-yelow']\n".to_owned(), 4, "hansa-yelow"),
            (
                format!(
                    "format = 1\nsteps = 200\n[[matte]]\nname = 'a'\npigments = {:?}\n",
                    ["hansa-yellow"; 3]
                ),
                5,
                "stacks",
            ),
            (
                format!("format = 1\n[[matte]]\nname = 'a'\npigments = {:?}\n", ["hansa-yellow"; 5]),
                4,
                "stacks",
            ),
            (format!("format = 1\n[[matte]]\n{good}[[lift]]\nname = 'h'\nfraction = 2\n"), 7, "outside"),
        ] {
            let problem = from_toml(&text).unwrap_err();
            assert!(problem.message.contains(reason), "{problem} for {reason}");
            assert_eq!(problem.line, line, "{problem}");
        }
    }

    #[test]
    fn the_living_wash_may_be_asked_for() {
        let text = "format = 1\n[[matte]]\nname = 'a'\npigments = ['hansa-yellow']\n[matte.wash]\nmodel = 'living'\n";
        assert_eq!(from_toml(text).unwrap().mattes[0].model, WashModel::living());
    }

    proptest! {
        #[test]
        fn no_file_of_known_words_makes_the_reader_panic(
            text in "((format|steps|max_thickness|name|pigments|interval|\\[\\[matte\\]\\]|\\[matte.planning\\]|\\[matte.wash\\]|\\[\\[lift\\]\\]) ?=? ?(-?[0-9e.]{0,4}|'[a-z./]*'|\\[[0-9,.']*\\])\n){0,8}"
        ) {
            let _ = from_toml(&text);
        }
    }
}
