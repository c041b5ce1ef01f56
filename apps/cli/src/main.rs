//! The `girtin` command.
//!
//! A module for every verb; none of them computes anything that the library does not. What verbs share:
//! - `arguments`: arguments of several verbs;
//! - `given`: the document that a verb is given, in any of its forms;
//! - `input`: files, pipes and the standard input;
//! - `output`: outputs, checked before the work and renamed when they are whole;
//! - `progress`: how far the work is;
//! - `interrupt`: Ctrl-C;
//! - `failure`: what goes wrong, in one line with a hint, and exit codes.
#![forbid(unsafe_code)]

mod arguments;
mod given;
mod input;
mod output;
mod progress;
mod interrupt;
mod failure;

mod watercolorize;
mod paint;
mod effects;
mod swatches;
mod wash;
mod pigments;
mod mix;
mod paper;
mod mattes;
mod inspect;
mod bench;
mod shell;

use std::process::ExitCode;

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand};

use crate::failure::Failure;
use crate::interrupt::Interrupt;

/// Paints watercolors with simulated water and pigment
#[derive(Debug, Parser)]
#[command(
    name = "girtin",
    version,
    arg_required_else_help = true,
    after_help = "Examples:
  girtin watercolorize photo.jpg painting.png
  girtin wash --state in.npz --pigments cobalt-blue --steps 200 --save out.npz --image out.png
  girtin mix hansa-yellow:0.4 cerulean-blue:0.3 --then quinacridone-rose:0.2

Exit codes: 0 done, 1 failed, 2 wrong command line, 3 some of many failed, 4 bad input, 5 output exists, 130 and 143 \
                  interrupted."
)]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    Watercolorize(Box<watercolorize::WatercolorizeArgs>),
    Paint(paint::PaintArgs),
    Effects(effects::EffectsArgs),
    Swatches(swatches::SwatchesArgs),
    Wash(Box<wash::WashArgs>),
    Pigments(pigments::PigmentsArgs),
    Mix(mix::MixArgs),
    Paper(paper::PaperArgs),
    Mattes(mattes::MattesArgs),
    Inspect(inspect::InspectArgs),
    Bench(bench::BenchArgs),
    Completions(shell::CompletionsArgs),
    Man(shell::ManArgs),
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}

fn run() -> Result<(), Failure> {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(talk) => return parser_talk(&talk),
    };
    let interrupt = Interrupt::listen()?;
    match &cli.verb {
        Verb::Watercolorize(args) => watercolorize::run(args, &interrupt),
        Verb::Paint(args) => paint::run(args, &interrupt),
        Verb::Effects(args) => effects::run(args, &interrupt),
        Verb::Swatches(args) => swatches::run(args, &interrupt),
        Verb::Wash(args) => wash::run(args, &interrupt),
        Verb::Pigments(args) => pigments::run(args, &interrupt),
        Verb::Mix(args) => mix::run(args),
        Verb::Paper(args) => paper::run(args, &interrupt),
        Verb::Mattes(args) => mattes::run(args, &interrupt),
        Verb::Inspect(args) => inspect::run(args),
        Verb::Bench(args) => bench::run(args, &interrupt),
        Verb::Completions(args) => shell::completions(args, &mut Cli::command()),
        Verb::Man(args) => shell::man(args, Cli::command(), &interrupt),
    }
}

/// Help, the version, or what is wrong with the command line.
fn parser_talk(talk: &clap::Error) -> Result<(), Failure> {
    if !talk.use_stderr() {
        // Help and version are data that was asked for.
        return output::print(&talk.render().to_string());
    }
    let command = Cli::command();
    let verb = std::env::args().nth(1);
    let verb = verb.as_deref().filter(|verb| command.find_subcommand(verb).is_some());
    if talk.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        eprint!("{}", talk.render());
        return Err(Failure::usage("a verb is missing").hint("such as `girtin wash --help`"));
    }
    Err(failure::from_parser(talk, verb))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parser_is_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_verb_has_two_examples_that_it_understands() {
        let mut verbs = vec![Cli::command()];
        while let Some(verb) = verbs.pop() {
            verbs.extend(verb.get_subcommands().cloned());
            let help = verb.get_after_help().map(ToString::to_string).unwrap_or_default();
            let examples: Vec<&str> = help.lines().filter(|line| line.starts_with("  girtin ")).collect();
            assert!(examples.len() >= 2, "{} has {} examples", verb.get_name(), examples.len());
            for example in examples {
                // What the shell would do: quotes and redirections.
                let words = example.split_whitespace().take_while(|word| *word != ">");
                let words = words.map(|word| word.trim_matches('\''));
                let parsed = Cli::try_parse_from(words);
                assert!(parsed.is_ok(), "{example}: {}", parsed.unwrap_err());
            }
        }
    }
}
