//! What can go wrong, said in one line with a hint, and the exit code of its kind.

use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use std::process::ExitCode;

use girtin::params::Problem;
use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, NamedSource, Report};

/// The kind of a failure, which decides the exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Folder missing, read-only, disk full; the water ran away.
    Failed,
    /// The command line itself, names on it included.
    Usage,
    /// Some outputs of many; what failed has been said.
    SomeOfMany,
    /// A file's content.
    Input,
    /// An output is there already.
    Exists,
    /// A signal, by its number.
    Interrupted(u8),
    /// Whoever read the standard output has left; nothing is said, as nobody asked for more.
    ReaderLeft,
}

/// A failure: its kind, its cause and what to try.
#[derive(Debug)]
pub struct Failure {
    kind: Kind,
    cause: String,
    hint: Option<String>,
    problem: Option<Box<Problem>>,
}

impl Failure {
    /// A failure of any kind.
    pub fn new(kind: Kind, cause: impl Display) -> Self {
        Self { kind, cause: cause.to_string(), hint: None, problem: None }
    }

    /// Something outside the command failed.
    pub fn failed(cause: impl Display) -> Self {
        Self::new(Kind::Failed, cause)
    }

    /// The command line is wrong.
    pub fn usage(cause: impl Display) -> Self {
        Self::new(Kind::Usage, cause)
    }

    /// An input is wrong.
    pub fn input(cause: impl Display) -> Self {
        Self::new(Kind::Input, cause)
    }

    /// The same with what to try.
    #[must_use]
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// The standard output cannot be written.
    pub fn stdout(error: &io::Error) -> Self {
        if error.kind() == io::ErrorKind::BrokenPipe {
            return Self::new(Kind::ReaderLeft, "");
        }
        Self::failed(format!("cannot write to the standard output: {}", plain(error)))
    }

    /// Its kind.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// Says it on stderr and gives the exit code.
    pub fn report(&self) -> ExitCode {
        let code = match self.kind {
            Kind::ReaderLeft => return ExitCode::SUCCESS,
            Kind::Failed => 1,
            Kind::Usage => 2,
            Kind::SomeOfMany => 3,
            Kind::Input => 4,
            Kind::Exists => 5,
            Kind::Interrupted(signal) => 128 + signal,
        };
        let mut stderr = io::stderr().lock();
        let mut text = format!("girtin: error: {}\n", one_line(&self.cause));
        if let Some(problem) = self.problem.as_deref().filter(|_| stderr.is_terminal()) {
            text = self.picture_of(problem).unwrap_or(text);
        } else if let Some(hint) = &self.hint {
            text += &format!("hint: {}\n", one_line(hint));
        }
        // Nobody is left to tell if this fails.
        let _ = stderr.write_all(text.as_bytes());
        ExitCode::from(code)
    }

    /// The place in the file, for a terminal.
    fn picture_of(&self, problem: &Problem) -> Option<String> {
        let mut diagnostic = MietteDiagnostic::new(format!("girtin: error: {}", one_line(&self.cause)))
            .with_label(LabeledSpan::new(Some("here".to_owned()), problem.span.start, problem.span.len()));
        if let Some(hint) = &self.hint {
            diagnostic = diagnostic.with_help(format!("hint: {}", one_line(hint)));
        }
        let has_color = std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty());
        let theme = if has_color { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
        let handler = GraphicalReportHandler::new_themed(theme).with_links(false);
        let report = Report::new(diagnostic)
            .with_source_code(NamedSource::new(one_line(&problem.origin), problem.text.clone()));
        let mut text = String::new();
        handler.render_report(&mut text, report.as_ref()).ok()?;
        Some(text)
    }
}

/// A problem in a TOML file: bad input, shown with its place on a terminal.
impl From<Problem> for Failure {
    fn from(problem: Problem) -> Self {
        Self {
            kind: Kind::Input,
            cause: problem.to_string(),
            hint: Some(problem.hint.clone().unwrap_or_else(|| "mend the file there".to_owned())),
            problem: Some(Box::new(problem)),
        }
    }
}

/// What the command line's parser says, as one line and a hint; `verb` is what was asked for.
pub fn from_parser(error: &clap::Error, verb: Option<&str>) -> Failure {
    let rendered = error.render().to_string();
    let text = rendered.strip_prefix("error: ").unwrap_or(&rendered);
    let (cause, rest) = text.split_once("\n\n").unwrap_or((text, ""));
    let tip = rest.lines().find_map(|line| line.trim().strip_prefix("tip: "));
    // A list of values is more use than where to look for it.
    let is_list = |line: &&str| line.trim().starts_with("[possible values: ");
    let values = cause.lines().find(is_list).map(|line| line.trim().trim_matches(['[', ']']).to_owned());
    let cause: Vec<&str> = cause.lines().filter(|line| !is_list(line)).map(str::trim).collect();
    let help = || format!("see `girtin {}--help`", verb.map_or(String::new(), |verb| format!("{verb} ")));
    let hint = tip.map(str::to_owned).or(values).unwrap_or_else(help);
    Failure::usage(cause.join(" ")).hint(hint)
}

/// A system's error without its number, which says nothing to a painter.
pub fn plain(error: &io::Error) -> String {
    let text = error.to_string();
    match text.rfind(" (os error ") {
        Some(at) => text[..at].to_owned(),
        None => text,
    }
}

/// Names and messages may hold anything; a cause is one line.
fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cause_is_one_line_whatever_a_file_is_called() {
        assert_eq!(one_line("a\nb\u{1b}[31mc"), "a b [31mc");
    }

    #[test]
    fn system_errors_lose_their_number() {
        let error = io::Error::from_raw_os_error(2);
        assert!(!plain(&error).contains("os error"));
    }
}
