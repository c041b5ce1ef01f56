//! `girtin wash`: runs one wash from a state file.

use std::ffi::OsStr;
use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::time::Instant;

use girtin::grid::memory::probe;
use girtin::grid::{Layout, Raster};
use girtin::optics::{Coefficients, LinearRgb, Pigment};
use girtin::painting::picture::{read_photo, write_png};
use girtin::painting::state_file::{self, Limits, StateFileError};
use girtin::painting::{WashSettings, composite, effort, handling_of, memory};
use girtin::params::Place;
use girtin::wash::{Ledger, RunConfig, RunError, RunReport, StateError, Wash, WashModel, WashState};
use serde_json::{Value, json};

use crate::arguments::{
    Ground, MeansArgs, ModelArgs, PigmentFiles, megabytes, parse_ground_or_picture, pigment_hint,
    real_within, unknown_pigment,
};
use crate::failure::{Failure, Kind};
use crate::input;
use crate::interrupt::Interrupt;
use crate::output::{Outputs, Staged, Target, print};
use crate::progress::Progress;

/// Runs one wash from a state file
///
/// Parameters come from --params, else from `wash.toml` in the state's folder, else from the model; flags go over
/// them. A state is an .npz file with `wet_mask` and any of `height`, `u`, `v`, `pressure`, `saturation`,
/// `suspended`, `deposited`; one of a living wash has numbers besides: `cells_per_mm`, `contact_carry`, `evaporated`,
/// `blotted`.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  girtin wash --state in.npz --pigments cobalt-blue --steps 200 --save out.npz --image out.png
  girtin wash --state in.npz --pigments viridian --steps 240 --image frames/####.png --every 8"
)]
pub struct WashArgs {
    /// State to begin with, .npz; `-` is the standard input
    #[arg(long, value_name = "FILE")]
    state: PathBuf,
    /// Steps to run
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(0..=MOST_STEPS))]
    steps: u64,
    /// Parameters and names of pigments, TOML
    #[arg(long, value_name = "FILE")]
    params: Option<PathBuf>,
    /// Pigments in the order of the state's first axis, by any of their names
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    pigments: Option<Vec<String>>,
    #[command(flatten)]
    pigment_files: PigmentFiles,
    /// Cells a millimetre of paper, for a living wash whose state does not say; 4 if not given
    #[arg(long, value_name = "N", value_parser = real_within(0.1, 256.0))]
    cells_per_mm: Option<f64>,
    /// Where to save the state; `-` is the standard output
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    save: Option<PathBuf>,
    /// Where to write the picture, PNG; `-` is the standard output, `####` becomes the number of the step
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    image: Option<PathBuf>,
    /// Write a picture every N steps and one of the last; needs `####` in --image
    #[arg(long, value_name = "N", requires = "image", help_heading = OUTPUT,
          value_parser = clap::value_parser!(u64).range(1..))]
    every: Option<u64>,
    /// What the picture is painted on: white, black, #rrggbb or a picture of the wash's size
    #[arg(long, value_name = "COLOR|FILE", default_value = "white", value_parser = parse_ground_or_picture,
          help_heading = OUTPUT)]
    over: Ground,
    /// Print what was done, or with --dry-run would be, as JSON; on the standard error if the standard output is taken
    #[arg(long, help_heading = OUTPUT)]
    json: bool,
    /// Read and check everything, say what would be done, and do nothing
    #[arg(long)]
    dry_run: bool,
    #[command(flatten)]
    means: MeansArgs,
    #[command(flatten)]
    model: ModelArgs,
}

const OUTPUT: &str = "Output";

/// More would run for years; a slip of the finger.
const MOST_STEPS: u64 = 1_000_000_000;

/// More pictures than any folder is good for.
const MOST_FRAMES: u64 = 100_000;

/// File of parameters that is found without being named.
const SETTINGS: &str = "wash.toml";

/// Runs the verb.
///
/// # Errors
/// As the contract of the command line says.
pub fn run(args: &WashArgs, interrupt: &Interrupt) -> Result<(), Failure> {
    args.means.write.threads.install()?;
    let frames = Frames::new(args)?;
    let settings_file = args.params.clone().or_else(|| found_settings(&args.state));
    let ground_file = match &args.over {
        Ground::Picture(path) => Some(path),
        Ground::Color(_) => None,
    };
    let stdin = Path::new("-");
    if args.state == stdin && ground_file.is_some_and(|path| path == stdin) {
        return Err(Failure::usage("two inputs are `-`").hint("read one of them from a file"));
    }
    let inputs = [&args.state].into_iter().chain(&settings_file).chain(&args.pigment_files.files);
    let inputs = inputs.chain(ground_file);
    let mut outputs = Outputs::new(args.means.write.output, inputs.map(PathBuf::as_path));
    let mut claim =
        |path: &Option<PathBuf>, format| path.as_ref().map(|path| outputs.claim(path, format)).transpose();
    let save = claim(&args.save, "npz")?;
    let image = if frames.is_some() { None } else { claim(&args.image, "png")? };
    // `Some(None)` is an output that is there already and to be left.
    let wanted = [&save, &image].into_iter().flatten().count();
    let left = [&save, &image].into_iter().filter(|target| matches!(target, Some(None))).count();
    let (save, image) = (save.flatten(), image.flatten());
    let frames = frames.map(|frames| frames.claim(&mut outputs, interrupt)).transpose()?;
    if wanted > 0 && left == wanted && frames.is_none() {
        args.means.talk.say("girtin: every output exists; nothing to do");
        return Ok(());
    }
    if [&save, &image].into_iter().flatten().filter(|target| target.is_stdout()).count() > 1 {
        return Err(Failure::usage("two outputs are `-`").hint("write one of them to a file"));
    }

    let start = Instant::now();
    let mut state = read_state(args)?;
    let layout = state.layout();
    let ground = ground(&args.over, layout, args.image.is_some())?;
    args.means.talk.detail(&format!("read in {:.2} s", start.elapsed().as_secs_f64()));
    let name = input::name_of(&args.state);
    // A scale is the living wash's: C97 knows only cells.
    let has_scale = state.ledger.is_some() || args.cells_per_mm.is_some();
    let default = args.model.default_model(if has_scale { WashModel::living() } else { WashModel::c97() });
    let settings_text = settings_file.as_deref().map(input::read_text).transpose()?.unwrap_or_default();
    let origin = settings_file.as_deref().map_or_else(String::new, |path| path.display().to_string());
    let settings = WashSettings::from_toml(&origin, &settings_text, default)?;
    let model = args.model.over(settings.model)?;
    set_scale(&mut state, args, &model, &name)?;
    let pigments = pigments(args, &settings, &origin, &settings_text)?;

    let handlings = pigments.iter().map(handling_of).collect();
    let wash = Wash::new(state, model, handlings).map_err(|error| refused(&name, &error, &pigments, args))?;
    interrupt.check()?;
    let pictures = ground.iter().count() as u64 + u64::from(args.image.is_some());
    let cells = (layout.width() * layout.height()) as u64;
    let bytes = memory::of_wash(wash.state(), &model) + pictures * memory::of_picture(cells);
    let plan = Plan::new(args, wash.state(), &model, &pigments, settings_file.as_deref(), bytes);
    if args.dry_run {
        return print(&if args.json { format!("{:#}\n", plan.to_json()) } else { plan.text() });
    }
    args.means.talk.detail(&plan.text());
    args.means.check_memory(bytes, FEWER)?;
    let paints = pigments.iter().map(|p| p.coefficients).collect();
    let mut job = Job { args, interrupt, wash, paints, ground };
    let (report, seconds) = job.run(frames.as_deref())?;

    let start = Instant::now();
    let mut staged = Vec::new();
    if let Some(target) = &save {
        staged.push(target.stage(|writer| Ok(state_file::write(job.wash.state(), writer)?))?);
    }
    if let Some(target) = &image {
        staged.push(job.stage_picture(target)?);
    }
    interrupt.check()?;
    for output in staged {
        output.commit()?;
    }
    args.means.talk.detail(&format!("written in {:.2} s", start.elapsed().as_secs_f64()));
    let is_stdout_taken = [&save, &image].into_iter().flatten().any(Target::is_stdout);
    job.tell(&report, seconds, is_stdout_taken)
}

/// Puts `--cells-per-mm` into a living wash's state.
fn set_scale(state: &mut WashState, args: &WashArgs, model: &WashModel, name: &str) -> Result<(), Failure> {
    let is_living = matches!(model, WashModel::Living(_));
    if !is_living {
        // A state of C97 has no scale, and what C97 makes of another is one of its own.
        state.ledger = None;
    }
    let Some(cells_per_mm) = args.cells_per_mm else { return Ok(()) };
    if !is_living {
        return Err(Failure::usage("`--cells-per-mm` is of the living wash; C97 knows only cells")
            .hint("give `--model living`, or leave it out"));
    }
    match state.ledger {
        Some(ledger) if ledger.cells_per_mm != cells_per_mm => Err(Failure::usage(format!(
            "`--cells-per-mm {cells_per_mm}`, and {name} has {} cells a millimetre",
            ledger.cells_per_mm
        ))
        .hint("leave it out: a state keeps its scale")),
        _ => {
            state.ledger.get_or_insert(Ledger::new(cells_per_mm));
            Ok(())
        }
    }
}

/// `wash.toml` beside the state.
fn found_settings(state: &Path) -> Option<PathBuf> {
    let path = (state != Path::new("-")).then(|| state.with_file_name(SETTINGS))?;
    path.is_file().then_some(path)
}

/// The pigments that the command line names, or else the file of that name and text.
fn pigments(
    args: &WashArgs,
    settings: &WashSettings,
    origin: &str,
    text: &str,
) -> Result<Vec<Pigment>, Failure> {
    let library = args.pigment_files.library()?;
    if let Some(names) = &args.pigments {
        let pigment = |name: &String| library.get(name).cloned();
        return names
            .iter()
            .map(pigment)
            .collect::<Result<_, _>>()
            .map_err(|unknown| unknown_pigment(&unknown));
    }
    let pigment = |(name, place): (&String, &Place)| {
        let found = library.get(name).cloned();
        found.map_err(|unknown| place.problem(origin, text, &unknown, pigment_hint(&unknown)).into())
    };
    settings.pigments.iter().zip(&settings.pigment_places).map(pigment).collect()
}

/// What to do about too little memory.
const FEWER: &str = "use fewer cells or pigments";

fn read_state(args: &WashArgs) -> Result<WashState, Failure> {
    let touched_bytes = args.means.memory.unwrap_or(u64::MAX);
    let limits = Limits { touched_bytes, ..Limits::default() };
    let name = input::name_of(&args.state);
    state_file::read_within(input::open(&args.state)?, &limits).map_err(|error| {
        if let StateFileError::Memory { most } = error {
            let said = format!("{name} alone takes more memory than `--memory` allows: {}", megabytes(most));
            return Failure::failed(said).hint(format!("{FEWER}, or allow more"));
        }
        unread(&name, &error)
    })
}

/// Why a state cannot be read.
pub fn unread(name: &str, error: &StateFileError) -> Failure {
    let is_outside = matches!(error, StateFileError::Read(_) | StateFileError::NoRoom(_));
    let kind = if is_outside { Kind::Failed } else { Kind::Input };
    let hint = error.hint().unwrap_or_else(|| "every array must fit `wet_mask`".to_owned());
    Failure::new(kind, format!("{name}: {error}")).hint(hint)
}

/// The picture that is painted on, if it is one.
fn ground(over: &Ground, layout: Layout, is_painted: bool) -> Result<Option<Raster<LinearRgb>>, Failure> {
    let (width, height) = (layout.width(), layout.height());
    if is_painted {
        let bytes = memory::of_picture((width * height) as u64);
        probe([bytes]).map_err(|error| Failure::failed(error).hint(FEWER))?;
    }
    let Ground::Picture(path) = over else { return Ok(None) };
    let name = input::name_of(path);
    let ending = path.extension().and_then(OsStr::to_str);
    let read = |reader, limits: &_| read_photo(reader, ending, limits, LinearRgb::WHITE);
    let picture = input::picture(path, read)?.pixels.map(|light| LinearRgb(light.map(f64::from)));
    if (picture.width(), picture.height()) != (width, height) {
        let found = format!("{} × {} pixels", picture.width(), picture.height());
        return Err(Failure::input(format!("{name} has {found}, the wash {width} × {height} cells"))
            .hint("a picture to paint on has a pixel for each cell: scale it first"));
    }
    Ok(Some(picture))
}

/// Why a state that could be read cannot run.
fn refused(name: &str, error: &StateError, pigments: &[Pigment], args: &WashArgs) -> Failure {
    let hint = match error {
        StateError::Pigments { .. } if pigments.is_empty() => {
            format!(
                "add `pigments = [\"french-ultramarine\", …]` to {SETTINGS}, or `--pigments`; one for each"
            )
        }
        StateError::Pigments { .. } => {
            let named: Vec<&str> = pigments.iter().map(|pigment| pigment.id.as_str()).collect();
            let place = if args.pigments.is_some() { "--pigments" } else { "the parameter file" };
            format!("{place} names {}; name one for each of the state's", named.join(", "))
        }
        _ => "mend the state or the pigment".to_owned(),
    };
    Failure::input(format!("{name}: {error}")).hint(hint)
}

/// Pictures on the way: a name with a place for the number of the step.
#[derive(Debug)]
struct Frames {
    before: String,
    digits: usize,
    after: String,
    steps: u64,
    every: u64,
}

impl Frames {
    /// The frames that the arguments ask for, if any.
    fn new(args: &WashArgs) -> Result<Option<Self>, Failure> {
        let Some(image) = &args.image else { return Ok(None) };
        let file = image.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let Some((before, digits, after)) = template(file) else {
            return match args.every {
                None => Ok(None),
                Some(_) => Err(Failure::usage(format!(
                    "`--every` writes many pictures, and `{}` is one name",
                    image.display()
                ))
                .hint("put `####` where the number of the step goes: `--image frames/####.png`")),
            };
        };
        let every = args.every.unwrap_or(args.steps.max(1));
        if args.steps / every > MOST_FRAMES {
            return Err(Failure::usage(format!("{} pictures are too many", args.steps / every))
                .hint(format!("`--every` more steps; {MOST_FRAMES} pictures at most are written")));
        }
        let whole = |part: &str| image.with_file_name(part).display().to_string();
        // `with_file_name` of an empty name would be the folder.
        let before = whole(&format!("{before}#")).trim_end_matches('#').to_owned();
        Ok(Some(Self { before, digits, after: after.to_owned(), steps: args.steps, every }))
    }

    /// The steps after which there is a picture: every so many, and the last.
    fn steps(&self) -> impl Iterator<Item = u64> + use<> {
        let (steps, every) = (self.steps, self.every);
        (1..=steps / every).map(move |k| k * every).chain((steps == 0 || steps % every != 0).then_some(steps))
    }

    fn path(&self, step: u64) -> PathBuf {
        PathBuf::from(format!("{}{step:0digits$}{}", self.before, self.after, digits = self.digits))
    }

    /// Checks all of them before the first step.
    fn claim(
        &self,
        outputs: &mut Outputs,
        interrupt: &Interrupt,
    ) -> Result<Vec<(u64, Option<Target>)>, Failure> {
        let claim = |step| {
            interrupt.check()?;
            Ok((step, outputs.claim(&self.path(step), "png")?))
        };
        self.steps().map(claim).collect()
    }
}

/// A file's name around its last run of two or more `#`.
fn template(file: &str) -> Option<(&str, usize, &str)> {
    let end = file.rfind("##")? + 2;
    let before = file[..end].trim_end_matches('#');
    Some((before, end - before.len(), &file[end..]))
}

/// A wash on its way to its outputs.
struct Job<'a> {
    args: &'a WashArgs,
    interrupt: &'a Interrupt,
    wash: Wash,
    paints: Vec<Coefficients>,
    /// A picture below; without one there is a color.
    ground: Option<Raster<LinearRgb>>,
}

impl Job<'_> {
    /// Runs all steps, writing frames as they come; returns what was done and the seconds of simulation.
    fn run(&mut self, frames: Option<&[(u64, Option<Target>)]>) -> Result<(RunReport, f64), Failure> {
        let progress = self.args.means.talk.start(self.args.steps, "steps");
        let last = [(self.args.steps, None)];
        let outcome = self.run_to(frames.unwrap_or(&last), &progress);
        progress.end();
        outcome
    }

    fn run_to(
        &mut self,
        stops: &[(u64, Option<Target>)],
        progress: &Progress,
    ) -> Result<(RunReport, f64), Failure> {
        let (mut report, mut seconds) = (RunReport::default(), 0.0);
        for (step, target) in stops {
            let before = report.steps;
            let tell = |done| progress.at(before + done);
            let config = RunConfig {
                cancel: Some(self.interrupt.flag()),
                progress: Some(&tell),
                ..RunConfig::default()
            };
            let start = Instant::now();
            let done = self.wash.run(step - before, &config).map_err(|error| self.stopped(&error, before))?;
            seconds += start.elapsed().as_secs_f64();
            report.steps += done.steps;
            report.sweeps_total += done.sweeps_total;
            if let Some(target) = target {
                let staged = self.stage_picture(target)?;
                self.interrupt.check()?;
                staged.commit()?;
            }
        }
        Ok((report, seconds))
    }

    fn stopped(&self, error: &RunError, before: u64) -> Failure {
        let mut error = error.clone();
        if let RunError::RanAway { step, .. } = &mut error {
            *step += before;
        }
        stopped(&error, &error, self.interrupt)
    }

    fn stage_picture(&self, target: &Target) -> Result<Staged, Failure> {
        let layout = self.wash.state().layout();
        let mut picture = match (&self.ground, &self.args.over) {
            (Some(ground), _) => ground.clone(),
            (None, Ground::Color(color)) => Raster::new(layout.width(), layout.height(), *color),
            (None, Ground::Picture(_)) => unreachable!("a picture that is painted on has been read"),
        };
        composite::lay_over(self.wash.state(), &self.paints, &mut picture);
        let picture = composite::encode(&picture);
        target
            .stage(|writer| Ok(write_png(writer, &picture, &self.args.means.write.picture.meta(None, &[]))?))
    }

    /// Says what was done.
    fn tell(&self, report: &RunReport, seconds: f64, is_stdout_taken: bool) -> Result<(), Failure> {
        let state = self.wash.state();
        let (speed, water, pigment) = (state.max_speed(), self.wash.water_total(), state.pigment_totals());
        let RunReport { steps, sweeps_total } = *report;
        if self.args.json {
            let mut text = json!({
                "steps": steps, "sweeps_total": sweeps_total, "max_speed": speed,
                "pigment": pigment, "water": water, "seconds": seconds,
            });
            if let Some(ledger) = state.ledger {
                text["evaporated"] = json!(ledger.evaporated);
                text["blotted"] = json!(ledger.blotted);
            }
            if !is_stdout_taken {
                return print(&format!("{text}\n"));
            }
            eprintln!("{text}");
            return Ok(());
        }
        self.args.means.talk.say(&format!(
            "girtin: {steps} steps, {sweeps_total} sweeps in {seconds:.2} s; in the end the fastest water has {speed:.3} cells a step"
        ));
        Ok(())
    }
}

/// Why a run ended early; `said` is the error as its caller words it.
pub fn stopped(error: &RunError, said: &dyn Display, interrupt: &Interrupt) -> Failure {
    match error {
        RunError::Cancelled { .. } => interrupt.failure(),
        RunError::Threads { .. } => Failure::failed(said).hint("use fewer `--threads`"),
        RunError::RanAway { likely, .. } => {
            let advice = match *likely {
                "viscosity" | "relax_rate" => "lower it to 0.25 or less",
                "slope_scale" => "lower it to 1 or less",
                _ => "pour less water: a puddle is 0.3 to 1.5",
            };
            Failure::failed(said).hint(format!("look at `{likely}`: {advice}"))
        }
    }
}

/// What would be done, on what, and what it takes.
struct Plan<'a> {
    size: [usize; 2],
    wet_cells: usize,
    pigments: &'a [Pigment],
    /// File of the parameters.
    source: Option<String>,
    model: &'a WashModel,
    cells_per_mm: f64,
    steps: u64,
    threads: usize,
    /// The least and the most that are likely.
    seconds: [f64; 2],
    bytes: u64,
}

impl<'a> Plan<'a> {
    fn new(
        args: &WashArgs,
        state: &WashState,
        model: &'a WashModel,
        pigments: &'a [Pigment],
        settings_file: Option<&Path>,
        bytes: u64,
    ) -> Self {
        let layout = state.layout();
        let wet = |y| state.wet_mask.cells(y).iter().filter(|&&wet| wet != 0).count();
        let wet_cells: usize = (0..layout.height()).map(wet).sum();
        let cells_per_mm = state.ledger.map_or(4.0, |ledger| ledger.cells_per_mm);
        let threads = rayon::current_num_threads();
        let work = wet_cells as f64 * args.steps as f64 / threads as f64;
        Self {
            size: [layout.width(), layout.height()],
            wet_cells,
            pigments,
            source: settings_file.map(input::name_of),
            model,
            cells_per_mm,
            steps: args.steps,
            threads,
            seconds: effort::of_step(model, cells_per_mm, pigments.len()).map(|step| step * work),
            bytes,
        }
    }

    fn names(&self) -> Vec<&str> {
        self.pigments.iter().map(|pigment| pigment.id.as_str()).collect()
    }

    fn text(&self) -> String {
        let names = self.names();
        let names = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        let physics = match self.model {
            WashModel::C97 { capillary, .. } => {
                format!("c97; the capillary layer is {}", if capillary.is_some() { "on" } else { "off" })
            }
            WashModel::Living(_) => format!("living, {} cells a mm", self.cells_per_mm),
        };
        let ([width, height], [least, most]) = (self.size, self.seconds);
        format!(
            "state: {width} × {height} cells, {wet} of them wet\npigments: {names}\nparameters: {source}; model: \
             {physics}\nwork: {steps} steps on {threads} threads, about {least:.1} to {most:.1} s\nmemory: about \
             {memory}\n",
            wet = self.wet_cells,
            source = self.source.as_deref().unwrap_or("the model's defaults"),
            steps = self.steps,
            threads = self.threads,
            memory = megabytes(self.bytes),
        )
    }

    fn to_json(&self) -> Value {
        let (model, cells_per_mm) = match self.model {
            WashModel::C97 { .. } => ("c97", None),
            WashModel::Living(_) => ("living", Some(self.cells_per_mm)),
        };
        let [width, height] = self.size;
        let [least, most] = self.seconds;
        json!({
            "width": width, "height": height, "wet_cells": self.wet_cells, "pigments": self.names(),
            "parameters": self.source, "model": model, "cells_per_mm": cells_per_mm, "steps": self.steps,
            "threads": self.threads, "seconds_least": least, "seconds_most": most, "memory_bytes": self.bytes,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_run_of_hashes_is_the_number() {
        assert_eq!(template("####.png"), Some(("", 4, ".png")));
        assert_eq!(template("a##b###.png"), Some(("a##b", 3, ".png")));
        assert_eq!(template("sheet#2.png"), None);
    }

    #[test]
    fn frames_are_every_so_many_and_the_last() {
        let steps = |steps, every| {
            let (before, after) = (String::new(), String::new());
            Frames { before, digits: 4, after, steps, every }.steps().collect::<Vec<_>>()
        };
        assert_eq!(steps(10, 4), [4, 8, 10]);
        assert_eq!(steps(8, 4), [4, 8]);
        assert_eq!(steps(3, 4), [3]);
        assert_eq!(steps(0, 4), [0]);
    }
}
