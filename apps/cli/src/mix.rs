//! `girtin mix`: the color of a mixture, and of glazes over it.

use clap::{Arg, ArgMatches, Command, FromArgMatches};
use girtin::optics::{LinearRgb, glaze};
use serde_json::json;

use crate::arguments::{PigmentFiles, parse_ground, unknown_pigment};
use crate::failure::Failure;
use crate::output::print;

/// Tells the color of a mixture of pigments, and of glazes over it
///
/// Amounts are thicknesses: 1 is the swatch, and the amounts of a mixture add up. Each --then is another glaze, laid
/// over what is dry below it.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  girtin mix hansa-yellow:0.4 cerulean-blue:0.3 --then quinacridone-rose:0.2
  girtin mix french-ultramarine:0.5 burnt-umber:0.4 --over '#f4efe1' --json"
)]
pub struct MixArgs {
    #[command(flatten)]
    glazes: Glazes,
    /// What the paint lies on: white, black or #rrggbb
    #[arg(long, value_name = "COLOR", default_value = "white", value_parser = parse_ground)]
    over: LinearRgb,
    #[command(flatten)]
    pigment_files: PigmentFiles,
    /// Print {"srgb": [r, g, b], "linear": [r, g, b]}, from 0 to 1, unrounded
    #[arg(long)]
    json: bool,
}

/// So much of a pigment.
#[derive(Clone, Debug)]
struct Part {
    name: String,
    amount: f64,
}

fn parse_part(text: &str) -> Result<Part, String> {
    let (name, amount) = text.rsplit_once(':').unwrap_or((text, "1"));
    let amount: Option<f64> = amount.trim().parse().ok();
    match amount.filter(|amount| amount.is_finite() && *amount >= 0.0) {
        Some(amount) if !name.trim().is_empty() => Ok(Part { name: name.to_owned(), amount }),
        _ => Err("give a pigment and its amount such as `burnt-umber:0.4`".to_owned()),
    }
}

/// Mixtures from the ground up: the first, and one for each `--then`.
///
/// By hand, since the parser's derived code forgets which parts stood behind which `--then`.
#[derive(Clone, Debug)]
struct Glazes(Vec<Vec<Part>>);

impl clap::Args for Glazes {
    fn augment_args(command: Command) -> Command {
        let parts = |id| Arg::new(id).value_name("NAME:AMOUNT").num_args(1..).value_parser(parse_part);
        command
            .arg(parts("parts").required(true).help("Pigments of the mixture; an amount left out is 1"))
            .arg(
                parts("then")
                    .long("then")
                    .action(clap::ArgAction::Append)
                    .help("Pigments of a glaze over it; may be repeated"),
            )
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Glazes {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let first = matches.get_many::<Part>("parts").into_iter().flatten().cloned().collect();
        let then = matches.get_occurrences::<Part>("then").into_iter().flatten();
        Ok(Self(std::iter::once(first).chain(then.map(|parts| parts.cloned().collect())).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// Runs the verb.
///
/// # Errors
/// A pigment is unknown or its file bad.
pub fn run(args: &MixArgs) -> Result<(), Failure> {
    let library = args.pigment_files.library()?;
    let mut seen = args.over;
    for parts in &args.glazes.0 {
        let parts: Vec<_> = parts
            .iter()
            .map(|part| Ok((&library.get(&part.name)?.coefficients, part.amount)))
            .collect::<Result<_, _>>()
            .map_err(|unknown| unknown_pigment(&unknown))?;
        seen = glaze(parts, seen);
    }
    let srgb = seen.to_srgb();
    if args.json {
        return print(&format!("{}\n", json!({ "srgb": srgb.0, "linear": seen.0 })));
    }
    let [r, g, b] = srgb.0;
    let [lr, lg, lb] = seen.0;
    print(&format!("{srgb}\nsRGB    {r:.4} {g:.4} {b:.4}\nlinear  {lr:.4} {lg:.4} {lb:.4}\n"))
}
