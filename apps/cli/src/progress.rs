//! How far the work is, for people on a terminal or for programs.

use std::io::{self, IsTerminal, Write};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// How progress is told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum Manner {
    /// A bar, on a terminal only
    #[default]
    Auto,
    /// Lines of JSON on the standard error: {"done": 3, "total": 10}, or of work in stages {"stage": "…", "fraction": 0.3}
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

/// Tells how far work of several stages is.
#[derive(Debug)]
pub struct Stages {
    told: Told,
    /// What is worked on, for programs.
    name: String,
    last: Mutex<(String, Option<Instant>)>,
}

#[derive(Debug)]
enum Told {
    Bar(ProgressBar),
    Lines,
    Silent,
}

/// Parts of a bar that tells of stages.
const PARTS: u64 = 1000;

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

    /// Begins to tell of work of several stages on something; `title` goes before a stage's name.
    pub fn stages(self, name: &str, title: &str) -> Stages {
        let told = match self.progress {
            Manner::Json => Told::Lines,
            Manner::Auto if !self.quiet && io::stderr().is_terminal() => {
                let bar = ProgressBar::with_draw_target(Some(PARTS), ProgressDrawTarget::stderr());
                if let Ok(style) =
                    ProgressStyle::with_template("{bar:30} {percent}% {prefix}{msg}, {eta} left")
                {
                    bar.set_style(style);
                }
                bar.set_prefix(title.to_owned());
                Told::Bar(bar)
            }
            _ => Told::Silent,
        };
        Stages { told, name: name.to_owned(), last: Mutex::default() }
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

impl Stages {
    /// This is being done, and so much of the whole is done, 0 to 1.
    pub fn at(&self, stage: &str, part: f64) {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let is_new = last.0 != stage;
        if is_new {
            stage.clone_into(&mut last.0);
        }
        match &self.told {
            Told::Bar(bar) => {
                if is_new {
                    bar.set_message(stage.to_owned());
                }
                bar.set_position((part * PARTS as f64) as u64);
            }
            Told::Lines if is_new || last.1.is_none_or(|last| last.elapsed() >= LEAST_PAUSE) => {
                last.1 = Some(Instant::now());
                let part = (part * 1e3).round() / 1e3;
                let line = serde_json::json!({ "input": self.name, "stage": stage, "fraction": part });
                let _ = writeln!(io::stderr(), "{line}");
            }
            Told::Lines | Told::Silent => {}
        }
    }

    /// The work is over, for good or ill: a bar goes away.
    pub fn end(&self) {
        if let Told::Bar(bar) = &self.told {
            bar.finish_and_clear();
        }
    }
}

impl Progress {
    /// So many parts are done.
    pub fn at(&self, done: u64) {
        match self {
            Self::Bar(bar) => bar.set_position(done),
            Self::Lines(total, last) => {
                let mut last = last.lock().unwrap_or_else(PoisonError::into_inner);
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
