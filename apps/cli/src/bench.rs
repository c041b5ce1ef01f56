//! `girtin bench`: how fast this machine paints.
//!
//! A step is compared with copying the fields that it has to touch, on the same machine in the same moment: the ratio
//! says more than milliseconds of an unknown processor.

use std::fmt::{self, Display};
use std::hint::black_box;
use std::time::Instant;

use clap::Subcommand;
use girtin::grid::random::{at, below, key};
use girtin::grid::{Layout, Raster};
use girtin::optics::Library;
use girtin::painting::handling_of;
use girtin::paper::{HeightSource, Papers, Sheet};
use girtin::wash::{C97Params, Engine, LivingParams, RunConfig, Wash, WashModel, WashState};
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::output::print;
use crate::progress::TalkArgs;

/// Measures how fast this machine paints
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  girtin bench wash
  girtin bench wash --quick --json"
)]
pub struct BenchArgs {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    Wash(WashBenchArgs),
}

/// Measures a step of the wash against copying its fields
///
/// C97: one pigment, no capillary layer. Living: 4 cells a mm, film 0.7, full pores, no evaporation, the first 50 steps
/// but for the very first, which sets things up. All wet but in the sparse cases. A copy is that of the fields which a step
/// cannot avoid, 25 bytes a cell, on one thread, measured in turns with the steps. In the sparse cases a step is what a
/// long run takes more than a short one: copying water to where it is simulated, and back, is done once a run. Figures are
/// medians of several rounds; `best` is the ratio of the fastest, for machines that do other work as well.
#[derive(Debug, clap::Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  girtin bench wash
  girtin bench wash --quick --json"
)]
struct WashBenchArgs {
    /// Fewer rounds, and no sparse cases
    #[arg(long)]
    quick: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    talk: TalkArgs,
}

/// Runs the verb.
///
/// # Errors
/// It is interrupted, or a wash fails.
pub fn run(args: &BenchArgs, interrupt: &Interrupt) -> Result<(), Failure> {
    let What::Wash(args) = &args.what;
    let bench = Bench { args, interrupt, patch: patch(), min_seconds: if args.quick { 0.02 } else { 0.1 } };
    let pools = [threads(2)?, threads(1)?];
    let subjects = [
        Subject::C97 { sweeps: 2 },
        Subject::C97 { sweeps: 50 },
        Subject::Living { pigments: 1 },
        Subject::Living { pigments: 2 },
    ];
    let mut dense = Vec::new();
    for (width, height) in [(640, 480), (2048, 2048)] {
        for subject in subjects {
            for pool in &pools {
                let threads = pool.current_num_threads();
                let plural = if threads == 1 { "" } else { "s" };
                args.talk.say(&format!("girtin: {width} × {height}, {subject}, {threads} thread{plural}"));
                let row = bench.dense(width, height, subject, pool)?;
                args.talk.detail(&format!("{:.2} ms a step, {:.2} copies", 1e3 * row.step_s, row.ratio()));
                dense.push(row);
            }
        }
    }
    let sparse = if args.quick { Vec::new() } else { bench.sparse(&pools[0])? };
    if args.json {
        let dense: Vec<Value> = dense.iter().map(Dense::to_json).collect();
        let sparse: Vec<Value> = sparse.iter().map(Sparse::to_json).collect();
        return print(&format!("{:#}\n", json!({ "dense": dense, "sparse": sparse })));
    }
    print(&table(&dense, &sparse))
}

/// The means of measuring.
struct Bench<'a> {
    args: &'a WashBenchArgs,
    interrupt: &'a Interrupt,
    /// Paper, repeated over any canvas.
    patch: Raster<f32>,
    /// What is timed at once takes at least so long.
    min_seconds: f64,
}

/// Side of the piece of paper that is repeated, cells.
const PATCH: usize = 512;

fn patch() -> Raster<f32> {
    let papers = Papers::builtin();
    let paper = papers.iter().find(|paper| paper.id == "cold-press").or_else(|| papers.iter().next());
    let side = PATCH as f64 / 4.0;
    paper.map_or(Raster::new(PATCH, PATCH, 0.5), |paper| {
        Sheet::tiled(paper, 7, [side; 2]).height_field(PATCH, PATCH, 4.0, [0.0, 0.0])
    })
}

/// So many threads. They serve all rounds: new ones may share a processor for as long as a round takes.
fn threads(number: usize) -> Result<ThreadPool, Failure> {
    ThreadPoolBuilder::new().num_threads(number).build().map_err(Failure::failed)
}

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Subject {
    C97 { sweeps: u32 },
    Living { pigments: usize },
}

impl Display for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::C97 { sweeps } => write!(f, "c97, {sweeps} sweeps"),
            Self::Living { pigments: 1 } => write!(f, "living, 1 pigment"),
            Self::Living { pigments } => write!(f, "living, {pigments} pigments"),
        }
    }
}

impl Subject {
    fn pigments(self) -> usize {
        match self {
            Self::C97 { .. } => 1,
            Self::Living { pigments } => pigments,
        }
    }

    fn model(self) -> WashModel {
        match self {
            // A tolerance of 0 is never reached: every step takes all its sweeps.
            Self::C97 { sweeps } => WashModel::C97 {
                params: C97Params { relax_max_sweeps: sweeps, relax_tolerance: 0.0, ..C97Params::default() },
                capillary: None,
            },
            Self::Living { .. } => {
                WashModel::Living(LivingParams { evaporation: 0.0, ..LivingParams::default() })
            }
        }
    }
}

/// Steps of a living wash that are measured: later its edge has dried too far to be called all wet.
const LIVING_STEPS: u64 = 50;
/// The first of them, which sets things up.
const LIVING_SETTING_UP: u64 = 1;

/// A rectangle of cells: column, row, columns, rows.
type Rect = [usize; 4];

impl Bench<'_> {
    /// A wash on a canvas, wet in these rectangles.
    fn wash(&self, width: usize, height: usize, wet: &[Rect], subject: Subject) -> Result<Wash, Failure> {
        let mut state = WashState::empty(Layout::new(width, height), subject.pigments());
        let film = if matches!(subject, Subject::Living { .. }) { 0.7 } else { 0.5 };
        for &[x, y, columns, rows] in wet {
            for y in y..y + rows {
                let run = x..x + columns;
                let ground = self.patch.row(y % PATCH);
                for x in run.clone() {
                    state.height.cells_mut(y)[x] = ground[x % PATCH];
                }
                if let WashModel::Living(params) = subject.model() {
                    let [least, most] = params.capacity;
                    for x in run.clone() {
                        let capacity = f64::from(ground[x % PATCH]) * (most - least) + least;
                        state.saturation.cells_mut(y)[x] = capacity as f32;
                    }
                }
                state.wet_mask.cells_mut(y)[run.clone()].fill(1);
                state.pressure.cells_mut(y)[run.clone()].fill(film);
                for suspended in &mut state.suspended {
                    suspended.cells_mut(y)[run.clone()].fill(0.4);
                }
            }
        }
        let handling = Library::builtin().get("french-ultramarine").map(handling_of);
        let handling = handling.map_err(Failure::failed)?;
        Wash::new(state, subject.model(), vec![handling; subject.pigments()]).map_err(Failure::failed)
    }

    /// Seconds a step.
    fn steps(&self, wash: &mut Wash, steps: u64, pool: &ThreadPool) -> Result<f64, Failure> {
        let config = RunConfig {
            engine: Engine::Fast,
            threads: 0,
            cancel: Some(self.interrupt.flag()),
            ..RunConfig::default()
        };
        let start = Instant::now();
        let run = pool.install(|| wash.run(steps, &config));
        let seconds = start.elapsed().as_secs_f64() / steps as f64;
        self.interrupt.check()?;
        run.map_err(Failure::failed)?;
        Ok(seconds)
    }

    /// How many times to do what takes so many seconds.
    fn repeats(&self, seconds: f64) -> u64 {
        (self.min_seconds / seconds.max(1e-9)).ceil().clamp(1.0, 1e6) as u64
    }

    fn rounds(&self) -> usize {
        if self.args.quick { 3 } else { 9 }
    }

    /// A canvas that is wet all over.
    fn dense(
        &self,
        width: usize,
        height: usize,
        subject: Subject,
        pool: &ThreadPool,
    ) -> Result<Dense, Failure> {
        let whole = [[0, 0, width, height]];
        let mut wash = self.wash(width, height, &whole, subject)?;
        let mut fields = Fields::new(width * height);
        // The first steps set things up, and meet paper and water at rest.
        self.steps(&mut wash, 4, pool)?;
        fields.copy(1);
        let is_living = matches!(subject, Subject::Living { .. });
        let steps = if is_living {
            LIVING_STEPS - LIVING_SETTING_UP
        } else {
            self.repeats(self.steps(&mut wash, 2, pool)?)
        };
        let copies = self.repeats(fields.copy(2));
        let (mut step_s, mut copy_s) = (Vec::new(), Vec::new());
        for _ in 0..self.rounds() {
            if is_living {
                wash = self.wash(width, height, &whole, subject)?;
                self.steps(&mut wash, LIVING_SETTING_UP, pool)?;
            }
            step_s.push(self.steps(&mut wash, steps, pool)?);
            copy_s.push(fields.copy(copies));
        }
        let best_ratio = least(&step_s) / least(&copy_s);
        let (step_s, copy_s) = (median(step_s), median(copy_s));
        let max_speed = wash.state().max_speed();
        let threads = pool.current_num_threads();
        Ok(Dense { width, height, subject, threads, step_s, copy_s, best_ratio, max_speed })
    }

    /// Canvases that are mostly dry, each against one that is not.
    fn sparse(&self, pool: &ThreadPool) -> Result<Vec<Sparse>, Failure> {
        self.args.talk.say("girtin: a wash of 512 × 512 on a canvas of 8192 × 8192");
        let side = 512;
        let island = [4096, 4096, side, side];
        let subject = Subject::C97 { sweeps: 2 };
        let small = self.wash(side, side, &[[0, 0, side, side]], subject)?;
        let large = self.wash(8192, 8192, &[island], subject)?;
        let mut list = vec![self.compare("512 × 512 on 8192 × 8192 / alone", large, small, pool)?];
        self.args.talk.say("girtin: strokes on a tenth of 4096 × 4096");
        let strokes = self.wash(SHEET, SHEET, &strokes(), subject)?;
        let dense = self.wash(2048, 2048, &[[0, 0, 2048, 2048]], subject)?;
        list.push(self.compare(
            "strokes on 10 % of 4096 × 4096 / 2048 × 2048 all wet",
            strokes,
            dense,
            pool,
        )?);
        Ok(list)
    }

    fn compare(
        &self,
        name: &'static str,
        mut sparse: Wash,
        mut dense: Wash,
        pool: &ThreadPool,
    ) -> Result<Sparse, Failure> {
        let mut repeats = [0; 2];
        for (wash, repeats) in [&mut sparse, &mut dense].into_iter().zip(&mut repeats) {
            self.steps(wash, 4, pool)?;
            *repeats = self.repeats(self.steps(wash, 2, pool)?);
        }
        let (mut sparse_s, mut dense_s) = (Vec::new(), Vec::new());
        for _ in 0..self.rounds() {
            sparse_s.push(self.steps_alone(&mut sparse, repeats[0], pool)?);
            dense_s.push(self.steps_alone(&mut dense, repeats[1], pool)?);
        }
        let ns = |seconds, wash: &Wash| median(seconds) * 1e9 / wet_cells(wash.state()) as f64;
        Ok(Sparse { name, sparse_ns: ns(sparse_s, &sparse), dense_ns: ns(dense_s, &dense) })
    }

    /// Seconds a step, without what a run costs however many steps it has: those that a long run takes more than a short one.
    fn steps_alone(&self, wash: &mut Wash, steps: u64, pool: &ThreadPool) -> Result<f64, Failure> {
        const SHORT: u64 = 2;
        let short = self.steps(wash, SHORT, pool)? * SHORT as f64;
        let long = self.steps(wash, SHORT + steps, pool)? * (SHORT + steps) as f64;
        Ok((long - short) / steps as f64)
    }
}

/// Side of the canvas that strokes lie on, cells.
const SHEET: usize = 4096;

/// Round-ended strokes of a brush in all directions, 16 to 120 cells wide and 200 to 1200 long, until a tenth of the sheet is
/// wet; row by row.
fn strokes() -> Vec<Rect> {
    let key = key(7, 1);
    let mut is_wet = vec![false; SHEET * SHEET];
    let (mut wet, mut rows) = (0, Vec::new());
    for number in 0.. {
        if wet * 10 >= SHEET * SHEET {
            break;
        }
        let draw = |which, least: u64, most: u64| {
            let drawn = below(at(key, [number, which]), most - least + 1);
            (least + drawn) as f64
        };
        let radius = draw(0, 16, 120) / 2.0;
        let length = draw(1, 200, 1200);
        let [from_x, from_y] = [draw(2, 0, SHEET as u64 - 1), draw(3, 0, SHEET as u64 - 1)];
        // Anywhere but straight to where it began.
        let [across, down] = [draw(4, 0, 2000) - 1000.5, draw(5, 0, 2000) - 1000.5];
        let along = (across * across + down * down).sqrt();
        let [across, down] = [across / along, down / along];
        let reach = |from: f64, to: f64| {
            let first = (from.min(to) - radius).max(0.0) as usize;
            first..((from.max(to) + radius) as usize + 1).min(SHEET)
        };
        for y in reach(from_y, from_y + length * down) {
            let covers = |&x: &usize| {
                let [x, y] = [x as f64 - from_x, y as f64 - from_y];
                let nearest = (x * across + y * down).clamp(0.0, length);
                let [x, y] = [x - nearest * across, y - nearest * down];
                x * x + y * y < radius * radius
            };
            let columns = reach(from_x, from_x + length * across);
            let Some(first) = columns.clone().find(covers) else { continue };
            // A stroke is convex.
            let run = first..(first..columns.end).find(|x| !covers(x)).unwrap_or(columns.end);
            wet += is_wet[y * SHEET..][run.clone()].iter().filter(|wet| !**wet).count();
            is_wet[y * SHEET..][run.clone()].fill(true);
            rows.push([first, y, run.len(), 1]);
        }
    }
    rows
}

fn wet_cells(state: &WashState) -> usize {
    (0..state.layout().height())
        .map(|y| state.wet_mask.cells(y).iter().filter(|wet| **wet != 0).count())
        .sum()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

/// The fields that a step cannot avoid, twice: u, v, p, g, d, h and M.
struct Fields {
    from: (Vec<Vec<f32>>, Vec<u8>),
    to: (Vec<Vec<f32>>, Vec<u8>),
}

impl Fields {
    fn new(cells: usize) -> Self {
        // Not 0: untouched pages are all the same one, and copy too fast.
        let fields = |value: u8| (vec![vec![f32::from(value); cells]; 6], vec![value; cells]);
        Self { from: fields(1), to: fields(2) }
    }

    /// Seconds to copy all of them once, on this thread.
    fn copy(&mut self, times: u64) -> f64 {
        let start = Instant::now();
        for _ in 0..times {
            let (from, to) = (black_box(&self.from), black_box(&mut self.to));
            for (from, to) in from.0.iter().zip(&mut to.0) {
                to.copy_from_slice(from);
            }
            to.1.copy_from_slice(&from.1);
        }
        start.elapsed().as_secs_f64() / times as f64
    }
}

/// A canvas that is wet all over, measured.
struct Dense {
    width: usize,
    height: usize,
    subject: Subject,
    threads: usize,
    step_s: f64,
    copy_s: f64,
    /// The same of the fastest rounds: what is left of the ratio when nothing else runs on the machine.
    best_ratio: f64,
    /// Above 1, steps have sub-steps and the figures are not comparable.
    max_speed: f32,
}

impl Dense {
    fn ratio(&self) -> f64 {
        self.step_s / self.copy_s
    }

    fn to_json(&self) -> Value {
        let (model, sweeps) = match self.subject {
            Subject::C97 { sweeps } => ("c97", Some(sweeps)),
            Subject::Living { .. } => ("living", None),
        };
        json!({
            "width": self.width, "height": self.height, "model": model, "sweeps": sweeps,
            "pigments": self.subject.pigments(), "threads": self.threads, "step_ms": self.step_s * 1e3, "copy_ms": self.copy_s * 1e3, "ratio": self.ratio(),
            "best_ratio": self.best_ratio, "max_speed": self.max_speed,
        })
    }
}

/// A mostly dry canvas against another, ns a step and wet cell.
struct Sparse {
    name: &'static str,
    sparse_ns: f64,
    dense_ns: f64,
}

impl Sparse {
    fn to_json(&self) -> Value {
        let ratio = self.sparse_ns / self.dense_ns;
        json!({ "case": self.name, "sparse_ns": self.sparse_ns, "dense_ns": self.dense_ns, "ratio": ratio })
    }
}

fn table(dense: &[Dense], sparse: &[Sparse]) -> String {
    let mut page =
        String::from("size         model               threads  ms/step  ms/copy   ratio    best\n");
    for row in dense {
        page += &format!(
            "{:<11}  {:<18}  {:>7}  {:>7.3}  {:>7.3}  {:>6.2}  {:>6.2}\n",
            format!("{} × {}", row.width, row.height),
            row.subject.to_string(),
            row.threads,
            row.step_s * 1e3,
            row.copy_s * 1e3,
            row.ratio(),
            row.best_ratio
        );
    }
    page += "\nspeed-up from 1 thread to 2\n";
    for two in dense.iter().filter(|row| row.threads == 2) {
        let is_same = |row: &&Dense| {
            (row.width, row.height, row.subject, row.threads) == (two.width, two.height, two.subject, 1)
        };
        if let Some(one) = dense.iter().find(is_same) {
            let size = format!("{} × {}", two.width, two.height);
            let subject = two.subject.to_string();
            page += &format!("{size:<11}  {subject:<18}  {:.2}\n", one.step_s / two.step_s);
        }
    }
    if !sparse.is_empty() {
        page += "\nns a step and wet cell, c97, 2 sweeps, 2 threads\n";
    }
    for row in sparse {
        let ratio = row.sparse_ns / row.dense_ns;
        page += &format!("{}: {:.2} / {:.2} = {ratio:.2}\n", row.name, row.sparse_ns, row.dense_ns);
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strokes_cover_a_tenth_and_stay_on_the_canvas() {
        let strokes = strokes();
        let mut is_wet = vec![false; SHEET * SHEET];
        for [x, y, columns, rows] in strokes {
            assert!(x + columns <= SHEET && y + rows <= SHEET);
            is_wet[y * SHEET + x..][..columns].fill(true);
        }
        let share = is_wet.iter().filter(|wet| **wet).count() as f64 / is_wet.len() as f64;
        assert!((0.1..0.11).contains(&share), "{share}");
    }
}
