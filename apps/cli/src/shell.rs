//! `girtin completions` and `girtin man`: what shells and `man` read, made from the parser itself.

use std::path::PathBuf;

use clap::Command;
use clap_complete::Shell;
use clap_mangen::Man;

use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::{MadeFolder, OutputArgs, Outputs, print};

/// Prints completions for a shell
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  girtin completions bash > ~/.local/share/bash-completion/completions/girtin
  girtin completions fish > ~/.config/fish/completions/girtin.fish"
)]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

/// Writes man pages, one a verb, into a folder
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  girtin man ~/.local/share/man/man1
  girtin man pages --overwrite"
)]
pub struct ManArgs {
    /// The folder; it is made if it is not there
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    #[command(flatten)]
    output: OutputArgs,
}

/// Prints completions.
///
/// # Errors
/// Nobody reads them.
pub fn completions(args: &CompletionsArgs, command: &mut Command) -> Result<(), Failure> {
    // Not to the standard output itself: the generator panics if it is closed.
    let mut text = Vec::new();
    clap_complete::generate(args.shell, command, "girtin", &mut text);
    print(&String::from_utf8_lossy(&text))
}

/// Writes man pages.
///
/// # Errors
/// A page exists or cannot be written.
pub fn man(args: &ManArgs, mut command: Command, interrupt: &Interrupt) -> Result<(), Failure> {
    command = command.disable_help_subcommand(true);
    command.build();
    let _folder = MadeFolder::new(&args.folder)?;
    let mut outputs = Outputs::new(args.output, []);
    let mut pages = Vec::new();
    let mut rest = vec![command];
    while let Some(mut command) = rest.pop() {
        rest.extend(command.get_subcommands().filter(|verb| !verb.is_hide_set()).cloned());
        // The page's own synopsis would list every option, and in no order that help has.
        let usage = command.render_usage().to_string();
        let command = command.override_usage(usage.trim_start_matches("Usage: ").to_owned());
        let man = Man::new(command).source(crate::arguments::SOFTWARE).manual("Girtin");
        let target = outputs.claim(&args.folder.join(man.get_filename()), "1")?;
        pages.extend(target.map(|target| (man, target)));
    }
    for (man, target) in pages {
        target.write(interrupt, |mut writer| Ok(man.render(&mut writer)?))?;
    }
    Ok(())
}
