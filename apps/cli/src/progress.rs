//! How far the work is, for people on a terminal or for programs.

use std::io::{self, IsTerminal, Write};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// How progress is told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Manner {
    /// A bar, on a terminal only
    #[default]
    Auto,
    /// Lines of JSON on the standard error: {"done": 3, "total": 10}
    Json,
    /// Not at all
    None,
}

/// What is said while the work goes on.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub struct TalkArgs {
    /// Say nothing but errors
    #[arg(short, long)]
    pub quiet: bool,
    /// Say more: what is done, with what, and how long it takes
    #[arg(short, long, conflicts_with = "quiet")]
    pub verbose: bool,
    /// How to tell how far the work is
    #[arg(long, value_enum, value_name = "HOW", default_value = "auto")]
    progress: Manner,
}

/// Tells how far the work is.
#[derive(Debug)]
pub enum Progress {
    /// A bar.
    Bar(ProgressBar),
    /// Lines of JSON, and when the last was written.
    Lines(u64, Mutex<Option<Instant>>),
    /// Silence.
    Silent,
}

/// Between two lines of JSON.
const LEAST_PAUSE: Duration = Duration::from_millis(100);

impl TalkArgs {
    /// Begins to tell of work of so many parts.
    pub fn start(self, total: u64, unit: &str) -> Progress {
        match self.progress {
            Manner::Json => Progress::Lines(total, Mutex::new(None)),
            Manner::Auto if !self.quiet && io::stderr().is_terminal() => {
                let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::stderr());
                let template = format!("{{bar:30}} {{pos}} of {{len}} {unit}, {{eta}} left");
                // The template is a constant but for the unit; the default bar will do if it is ever wrong.
                if let Ok(style) = ProgressStyle::with_template(&template) {
                    bar.set_style(style);
                }
                Progress::Bar(bar)
            }
            _ => Progress::Silent,
        }
    }

    /// Says something to people who want to know more, line by line.
    pub fn detail(self, text: &str) {
        if self.verbose {
            text.lines().for_each(|line| self.say(&format!("girtin: {line}")));
        }
    }

    /// Says something to people, unless they want quiet.
    pub fn say(self, text: &str) {
        if !self.quiet {
            // Talk is lost if nobody is there to hear it.
            let _ = writeln!(io::stderr(), "{text}");
        }
    }
}

impl Progress {
    /// So many parts are done.
    pub fn at(&self, done: u64) {
        match self {
            Self::Bar(bar) => bar.set_position(done),
            Self::Lines(total, last) => {
                let mut last = last.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
                if done == *total || last.is_none_or(|last| last.elapsed() >= LEAST_PAUSE) {
                    *last = Some(Instant::now());
                    let line = serde_json::json!({ "done": done, "total": total });
                    let _ = writeln!(io::stderr(), "{line}");
                }
            }
            Self::Silent => {}
        }
    }

    /// The work is over, for good or ill: a bar goes away.
    pub fn end(&self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}
