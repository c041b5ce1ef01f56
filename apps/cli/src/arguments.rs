//! Arguments that several verbs share.

use std::path::{Path, PathBuf};

use clap::builder::PossibleValue;
use clap::{Arg, ArgAction, ArgMatches, Command, FromArgMatches};
use girtin::optics::{Library, LinearRgb, Pigment, Srgb, UnknownPigment};
use girtin::painting::WaterDetail;
use girtin::painting::picture::PictureMeta;
use girtin::params::row::Parameters;
use girtin::params::{Row, Value, hint_for};
use girtin::wash::{C97Params, Capillary, LivingParams, WashModel};

use crate::failure::Failure;
use crate::input;
use crate::output::OutputArgs;
use crate::progress::TalkArgs;

/// Who wrote a picture.
pub const SOFTWARE: &str = concat!("girtin ", env!("CARGO_PKG_VERSION"));

/// The painter's own pigments.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct PigmentFiles {
    /// Add a pigment from a TOML file; may be repeated
    #[arg(long = "pigment-file", value_name = "FILE")]
    pub files: Vec<PathBuf>,
}

impl PigmentFiles {
    /// The built-in pigments and these.
    ///
    /// # Errors
    /// A file cannot be read or is no pigment.
    pub fn library(&self) -> Result<Library, Failure> {
        self.over(Library::builtin())
    }

    /// A library and these, in the place of its own of the same id.
    ///
    /// # Errors
    /// As [`PigmentFiles::library`].
    pub fn over(&self, mut library: Library) -> Result<Library, Failure> {
        for path in &self.files {
            let text = input::read_text(path)?;
            library = library.with(Pigment::from_toml(&path.display().to_string(), &text)?);
        }
        Ok(library)
    }
}

/// A name on the command line that is not in the library.
pub fn unknown_pigment(unknown: &UnknownPigment) -> Failure {
    Failure::usage(unknown).hint(pigment_hint(unknown))
}

/// What to do about a name that is not in the library.
pub fn pigment_hint(unknown: &UnknownPigment) -> String {
    match unknown {
        UnknownPigment::NoSuch { nearest: None, .. } => "`girtin pigments` lists them all".to_owned(),
        _ => unknown.hint(),
    }
}

/// How many threads work.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct ThreadArgs {
    /// Threads to work on; as many as there are processors if not given. Results are the same
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024))]
    threads: Option<u32>,
}

impl ThreadArgs {
    /// Makes everything that follows run on them.
    ///
    /// # Errors
    /// The system gives none.
    pub fn install(self) -> Result<(), Failure> {
        let Some(threads) = self.threads else { return Ok(()) };
        rayon::ThreadPoolBuilder::new().num_threads(threads as usize).build_global().map_err(|error| {
            Failure::failed(format!("cannot start {threads} threads: {error}")).hint("use fewer `--threads`")
        })
    }
}

/// What pictures say of themselves.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct PictureArgs {
    /// Write pictures without a word about their making
    #[arg(long, help_heading = "Output")]
    pub strip: bool,
}

impl PictureArgs {
    /// The words for a picture: its maker, and what else there is to say.
    pub fn meta(self, pixels_per_mm: Option<f64>, words: &[(&str, String)]) -> PictureMeta {
        let mut text = Vec::new();
        if !self.strip {
            text.push(("Software".to_owned(), SOFTWARE.to_owned()));
            text.extend(words.iter().map(|(keyword, word)| ((*keyword).to_owned(), word.clone())));
        }
        PictureMeta { pixels_per_mm, text }
    }
}

/// How pictures are written, and on how many threads they are made.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct WriteArgs {
    #[command(flatten)]
    pub output: OutputArgs,
    #[command(flatten)]
    pub picture: PictureArgs,
    #[command(flatten)]
    pub threads: ThreadArgs,
}

/// How pictures are made and where they go: the same for every verb that paints.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct MeansArgs {
    #[command(flatten)]
    pub write: WriteArgs,
    /// Do nothing if it would take more memory than this, such as 500MB or 2GiB
    #[arg(long, value_name = "SIZE", value_parser = parse_size)]
    pub memory: Option<u64>,
    #[command(flatten)]
    pub talk: TalkArgs,
}

/// How finely the water of living washes is simulated.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct WaterArgs {
    /// How finely the water of living washes is simulated; full, but a .girtin file's as it was painted
    #[arg(long, value_name = "DETAIL", value_enum)]
    water: Option<Water>,
}

/// See [`WaterDetail`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Water {
    /// As finely as pigment
    Full,
    /// At about 4 cells a mm, many times as fast: for previews and large prints
    Coarse,
}

impl WaterArgs {
    /// As the library says it.
    pub fn detail(self, unsaid: WaterDetail) -> WaterDetail {
        match self.water {
            Some(Water::Full) => WaterDetail::Full,
            Some(Water::Coarse) => WaterDetail::Coarse,
            None => unsaid,
        }
    }
}

impl MeansArgs {
    /// Refuses what would take more memory than it may; `lower` says what to lower.
    ///
    /// # Errors
    /// It would.
    pub fn check_memory(&self, estimate: u64, lower: &str) -> Result<(), Failure> {
        match self.memory {
            Some(most) if estimate > most => Err(Failure::failed(format!(
                "about {} of memory are needed, and `--memory` allows {}",
                megabytes(estimate),
                megabytes(most)
            ))
            .hint(format!("{lower}, or allow more"))),
            _ => Ok(()),
        }
    }
}

/// Lengths of paper for people: to a hundredth.
pub fn millimetres(mm: f64) -> f64 {
    (mm * 100.0).round() / 100.0
}

/// Bytes for people.
pub fn megabytes(bytes: u64) -> String {
    format!("{} MB", bytes.div_ceil(1_000_000))
}

/// An amount of memory: `500MB`, `2GiB`, `1.5G`.
///
/// # Errors
/// It is no number with a unit, or none that a machine has.
pub fn parse_size(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let unit = text.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
    let number: Option<f64> = text[..text.len() - unit.len()].parse().ok();
    let factor = match unit.trim().to_ascii_lowercase().as_str() {
        "k" | "kb" => Some(1e3),
        "m" | "mb" => Some(1e6),
        "g" | "gb" => Some(1e9),
        "t" | "tb" => Some(1e12),
        "kib" => Some(1024.0),
        "mib" => Some(1_048_576.0),
        "gib" => Some(1_073_741_824.0),
        "tib" => Some(1_099_511_627_776.0),
        _ => None,
    };
    let bytes = number.zip(factor).map(|(number, factor)| number * factor);
    bytes
        .filter(|bytes| (1.0..=1e18).contains(bytes))
        .map(|bytes| bytes as u64)
        .ok_or_else(|| "give a number with its unit such as `500MB` or `2GiB`".to_owned())
}

/// What a wash is painted on.
#[derive(Clone, Debug, PartialEq)]
pub enum Ground {
    /// One color everywhere.
    Color(LinearRgb),
    /// A picture of the wash's size.
    Picture(PathBuf),
}

/// A color as [`parse_ground`] reads it, or the name of a picture.
///
/// # Errors
/// It is neither.
pub fn parse_ground_or_picture(text: &str) -> Result<Ground, String> {
    if let Ok(color) = parse_ground(text) {
        return Ok(Ground::Color(color));
    }
    let path = Path::new(text);
    // A misspelled color is not a picture that cannot be found.
    let is_path = text == "-" || path.extension().is_some() || path.components().count() > 1 || path.exists();
    if is_path && !text.starts_with('#') {
        return Ok(Ground::Picture(path.to_owned()));
    }
    Err("give `white`, `black`, a color such as `#c0392b`, or a picture's file".to_owned())
}

/// A ground: `white`, `black` or `#rrggbb`.
///
/// # Errors
/// It is none of these.
pub fn parse_ground(text: &str) -> Result<LinearRgb, String> {
    match text {
        "white" => Ok(LinearRgb::WHITE),
        "black" => Ok(LinearRgb::BLACK),
        _ => text
            .parse::<Srgb>()
            .map(Srgb::to_linear)
            .map_err(|_| "give `white`, `black` or a color such as `#c0392b`".to_owned()),
    }
}

/// Two sides: `60x40`.
///
/// # Errors
/// It is not two numbers from 0.1 to 100,000.
pub fn parse_sides(text: &str) -> Result<[f64; 2], String> {
    let sides = text.split_once(['x', '×', 'X']).and_then(|(width, height)| {
        Some([width.trim().parse::<f64>().ok()?, height.trim().parse::<f64>().ok()?])
    });
    sides
        .filter(|sides| sides.iter().all(|side| (0.1..=1e5).contains(side)))
        .ok_or_else(|| "give width and height such as `60x40`, from 0.1 to 100000".to_owned())
}

/// The help of `--set`: a line for each row.
pub fn set_help<P: Parameters>() -> String {
    let line = |row: &Row| {
        let (low, high) = row.hard;
        format!("  {}={}  {} From {low} to {high}.\n", row.id, row.default, row.tooltip())
    };
    let lines: String = P::ROWS.iter().map(line).collect();
    format!("Any parameter; may be repeated. Those there are, with their defaults:\n{lines}")
}

/// Sets a parameter from `key=value`.
///
/// # Errors
/// It is none, or its value is not allowed.
pub fn set<P: Parameters>(parameters: &mut P, word: &str) -> Result<(), Failure> {
    let Some((key, value)) = word.split_once('=') else {
        return Err(Failure::usage(format!("`--set {word}` has no value")).hint("write `--set key=value`"));
    };
    let id = key.trim().replace('-', "_");
    let Some(row) = P::ROWS.iter().find(|row| row.id == id) else {
        let ids: Vec<&str> = P::ROWS.iter().map(|row| row.id).collect();
        return Err(Failure::usage(format!("no parameter is called `{key}`")).hint(hint_for(&id, &ids)));
    };
    let (low, high) = row.hard;
    let wrong =
        |error| Failure::usage(format!("`--set {word}`: {error}")).hint(format!("from {low} to {high}"));
    let value = row.parse(value).map_err(wrong)?;
    parameters.set(row.id, value).map_err(wrong)
}

/// A number within limits.
pub fn real_within(low: f64, high: f64) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync {
    move |text| {
        let value: Option<f64> = text.trim().parse().ok();
        value
            .filter(|value| (low..=high).contains(value))
            .ok_or_else(|| format!("give a number from {low} to {high}"))
    }
}

/// A flag for every row of the wash's parameters: the same rows as the TOML file's.
#[derive(Clone, Debug, Default)]
pub struct ModelArgs {
    named: Option<WashModel>,
    living: Vec<(&'static str, Value)>,
    wash: Vec<(&'static str, Value)>,
    /// Whether the capillary layer is turned on or off, if a flag says so.
    layer: Option<bool>,
    capillary: Vec<(&'static str, Value)>,
}

/// What the flags of a struct of parameters begin with.
const WASH: &str = "";
const CAPILLARY: &str = "capillary-";
const LIVING: &str = "living-";

fn flag(prefix: &str, row: &Row) -> String {
    format!("{prefix}{}", row.id.replace('_', "-"))
}

fn arg(prefix: &str, heading: &'static str, row: &'static Row) -> Arg {
    let (low, high) = row.hard;
    let (kind, default) = match row.default {
        Value::Real(x) => ("X", format!("{x}")),
        Value::Count(n) => ("N", format!("{n}")),
        Value::Span([a, b]) => ("LOW,HIGH", format!("{a},{b}")),
    };
    let name = flag(prefix, row);
    let unit = if row.unit == "1" { String::new() } else { format!(" {}", row.unit) };
    Arg::new(name.clone())
        .long(name)
        .value_name(kind)
        .help_heading(heading)
        // A negative number is then out of range, and not an unknown flag.
        .allow_negative_numbers(true)
        .value_parser(move |text: &str| row.parse(text))
        .help(format!("{} [{default}; {low} to {high}{unit}]", row.tooltip()))
        .long_help(format!("{}\n\nDefault {default}, from {low} to {high}{unit}.", row.doc))
}

fn values<P: Parameters>(prefix: &str, matches: &ArgMatches) -> Vec<(&'static str, Value)> {
    let value = |row: &'static Row| Some((row.id, *matches.get_one::<Value>(&flag(prefix, row))?));
    P::ROWS.iter().filter_map(value).collect()
}

fn apply<P: Parameters>(parameters: &mut P, values: &[(&'static str, Value)]) -> Result<(), Failure> {
    values.iter().try_for_each(|&(id, value)| parameters.set(id, value).map_err(Failure::usage))
}

impl clap::Args for ModelArgs {
    fn augment_args(command: Command) -> Command {
        const PHYSICS: &str = "Physics of Curtis et al. 1997, over what the parameter file says";
        const OWN: &str = "Physics of the living wash, over what the parameter file says";
        const LAYER: &str = "Capillary layer of Curtis et al. 1997; any of these turns it on";
        let switch = |id: &'static str, help: &'static str| {
            Arg::new(id).long(id).action(ArgAction::SetTrue).help(help).help_heading(LAYER)
        };
        command
            .arg(
                Arg::new("model")
                    .long("model")
                    .value_name("MODEL")
                    .value_parser([
                        PossibleValue::new("c97").help("Curtis et al. 1997, exactly"),
                        PossibleValue::new("living").help("Girtin's own: in millimetres, drying by itself"),
                    ])
                    .help("Physics of the wash: the parameter file's, else what the state was made with"),
            )
            .args(C97Params::ROWS.iter().map(|row| arg(WASH, PHYSICS, row)))
            .arg(switch("capillary", "Turn the layer on, with its defaults where nothing else is said"))
            .arg(
                switch("no-capillary", "Turn the layer off, whatever the parameter file says")
                    .conflicts_with("capillary")
                    .conflicts_with_all(Capillary::ROWS.iter().map(|row| flag(CAPILLARY, row))),
            )
            .args(Capillary::ROWS.iter().map(|row| arg(CAPILLARY, LAYER, row)))
            .args(LivingParams::ROWS.iter().map(|row| arg(LIVING, OWN, row)))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for ModelArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let capillary = values::<Capillary>(CAPILLARY, matches);
        let layer = match (matches.get_flag("capillary"), matches.get_flag("no-capillary")) {
            (_, true) => Some(false),
            (on, false) => (on || !capillary.is_empty()).then_some(true),
        };
        let named = matches.get_one::<String>("model").map(|name| match name.as_str() {
            "living" => WashModel::living(),
            _ => WashModel::c97(),
        });
        Ok(Self {
            named,
            living: values::<LivingParams>(LIVING, matches),
            wash: values::<C97Params>(WASH, matches),
            layer,
            capillary,
        })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl ModelArgs {
    /// The model that is meant where a parameter file names none: that of the flags, else `otherwise`.
    pub fn default_model(&self, otherwise: WashModel) -> WashModel {
        let of_flags = (!self.living.is_empty()).then(WashModel::living);
        self.named.or(of_flags).unwrap_or(otherwise)
    }

    /// The model of a file with the flags over it.
    ///
    /// # Errors
    /// A value is not allowed, or a flag belongs to the other model.
    pub fn over(&self, model: WashModel) -> Result<WashModel, Failure> {
        let is_living = |model: &WashModel| matches!(model, WashModel::Living(_));
        let model = match self.named {
            Some(named) if is_living(&named) != is_living(&model) => named,
            _ => model,
        };
        match model {
            WashModel::C97 { mut params, mut capillary } => {
                if let Some((id, _)) = self.living.first() {
                    return Err(foreign(&format!("--{LIVING}{}", id.replace('_', "-")), "c97", "living"));
                }
                apply(&mut params, &self.wash)?;
                match self.layer {
                    Some(false) => capillary = None,
                    Some(true) => apply(capillary.get_or_insert_default(), &self.capillary)?,
                    None => {}
                }
                Ok(WashModel::C97 { params, capillary })
            }
            WashModel::Living(mut params) => {
                if let Some((id, _)) = self.wash.first() {
                    return Err(foreign(&format!("--{}", id.replace('_', "-")), "living", "c97"));
                }
                if self.layer.is_some() {
                    return Err(foreign("--capillary", "living", "c97"));
                }
                apply(&mut params, &self.living)?;
                Ok(WashModel::Living(params))
            }
        }
    }
}

/// A flag of the other model.
fn foreign(flag: &str, model: &str, other: &str) -> Failure {
    Failure::usage(format!("`{flag}` is a parameter of the model `{other}`, and the wash runs by `{model}`"))
        .hint(format!("give `--model {other}`, or a parameter of `{model}`"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grounds_are_words_or_colors() {
        assert_eq!(parse_ground("white"), Ok(LinearRgb::WHITE));
        assert_eq!(parse_ground("#000000"), Ok(LinearRgb::BLACK));
        assert!(parse_ground("whit").is_err());
    }

    #[test]
    fn grounds_of_a_wash_may_be_pictures() {
        let picture = |name: &str| Ok(Ground::Picture(PathBuf::from(name)));
        assert_eq!(parse_ground_or_picture("black"), Ok(Ground::Color(LinearRgb::BLACK)));
        for name in ["sheet.png", "scans/sheet", "-"] {
            assert_eq!(parse_ground_or_picture(name), picture(name));
        }
        for bad in ["whit", "#12", "#a.png", ""] {
            assert!(parse_ground_or_picture(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn sizes_have_a_unit() {
        assert_eq!(parse_size("500MB"), Ok(500_000_000));
        assert_eq!(parse_size("1.5 GiB"), Ok(3 << 29));
        assert_eq!(parse_size("2g"), Ok(2_000_000_000));
        for bad in ["", "500", "MB", "-1GB", "1..5GB", "0GB", "1e99GB", "9999999999999TB", "2 G B"] {
            assert!(parse_size(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn sides_are_two_sensible_numbers() {
        assert_eq!(parse_sides("60x40"), Ok([60.0, 40.0]));
        for bad in ["60", "60x", "0x4", "nanx4", "1e9x1", "-1x4"] {
            assert!(parse_sides(bad).is_err(), "{bad}");
        }
    }
}
