//! The wash against its independent truth: runs made in f64 by `fidelity/wash/make_goldens.py` (C97) and
//! `make_living_goldens.py` (the living wash), which share no code with the engines.
//!
//! The engines hold their state in f32, so a field that is the sum of some thousand rounded terms is off by about
//! 1e-6 of its size after forty steps, and somewhat more where water is fast. [`FIELD_TOLERANCE`] leaves that room and
//! no more: a parameter that is slightly wrong is seen (`every_parameter_shows`, `every_living_parameter_shows`).

use std::collections::BTreeMap;
use std::fmt;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

use girtin::grid::{Field, Layout};
use girtin::optics::Library;
use girtin::painting::{WashSettings, handling_of, state_file};
use girtin::params::row::Parameters;
use girtin::wash::{
    C97Params, Capillary, Engine, LivingParams, PigmentHandling, RunConfig, Wash, WashModel, WashState,
};

/// Steps after which the truth is stored.
const STEPS: [u64; 3] = [1, 10, 40];
/// Relative error in the L2 norm.
const FIELD_TOLERANCE: f64 = 1e-4;
/// Fields smaller than this are compared as if they were as large: still water moves by rounding only.
const LEAST_NORM: f64 = 1e-6;
/// Relative error of a pigment's total, which is kept exactly but for rounding, and of the water that evaporated.
const TOTAL_TOLERANCE: f64 = 1e-5;

struct Case {
    name: String,
    start: WashState,
    settings: WashSettings,
    handlings: Vec<PigmentHandling>,
    truth: Vec<(u64, WashState)>,
}

fn folders() -> Vec<PathBuf> {
    let all = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fidelity/wash");
    let entries = fs::read_dir(&all).unwrap_or_else(|error| panic!("{}: {error}", all.display()));
    // Python leaves a folder of its own there.
    let is_case = |path: &PathBuf| path.is_dir() && !name(path).starts_with('_');
    let mut folders: Vec<_> = entries.map(|entry| entry.unwrap().path()).filter(is_case).collect();
    folders.sort();
    folders
}

fn name(folder: &Path) -> String {
    folder.file_name().unwrap().to_string_lossy().into_owned()
}

fn state(path: &Path) -> WashState {
    let file = File::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    state_file::read(file).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn settings(folder: &Path) -> WashSettings {
    let path = folder.join("wash.toml");
    let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    WashSettings::from_toml(&path.to_string_lossy(), &text, WashModel::default())
        .unwrap_or_else(|problem| panic!("{problem}"))
}

fn cases() -> Vec<Case> {
    let pigments = Library::builtin();
    let load = |folder: &PathBuf| {
        let settings = settings(folder);
        let handling = |pigment: &String| handling_of(pigments.get(pigment).unwrap());
        Case {
            name: name(folder),
            start: state(&folder.join("start.npz")),
            handlings: settings.pigments.iter().map(handling).collect(),
            settings,
            truth: STEPS.map(|steps| (steps, state(&folder.join(format!("after-{steps}.npz"))))).into(),
        }
    };
    folders().iter().map(load).collect()
}

/// Every value of a field: a row and a column more than there are cells, for faces; elsewhere they are 0.
fn values(field: &Field<f32>) -> impl Iterator<Item = f64> {
    let faces = field.layout().width() + 1;
    let row = move |y| &field.row(Layout::TOP + y)[Layout::LEFT..][..faces];
    (0..=field.layout().height()).flat_map(row).map(|&value| f64::from(value))
}

/// The fields by name, those of pigments numbered.
fn fields(state: &WashState) -> Vec<(String, &Field<f32>)> {
    let WashState { wet_mask: _, height, u, v, pressure, saturation, suspended, deposited, ledger: _ } =
        state;
    let mut fields: Vec<(String, _)> = vec![
        ("height".into(), height),
        ("u".into(), u),
        ("v".into(), v),
        ("pressure".into(), pressure),
        ("saturation".into(), saturation),
    ];
    for (name, pigments) in [("suspended", suspended), ("deposited", deposited)] {
        fields.extend(pigments.iter().enumerate().map(|(k, field)| (format!("{name}[{k}]"), field)));
    }
    fields
}

/// Error of one quantity of a case after some steps.
struct Deviation {
    case: String,
    steps: u64,
    quantity: String,
    error: f64,
    tolerance: f64,
}

impl Deviation {
    fn is_too_large(&self) -> bool {
        // Nothing is larger than an error that is not a number.
        self.error > self.tolerance || self.error.is_nan()
    }
}

impl fmt::Display for Deviation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { case, steps, quantity, error, tolerance } = self;
        write!(f, "{case}: `{quantity}` after {steps} steps is {error:.2e} off, allowed are {tolerance:.0e}")
    }
}

/// How far a state is from the truth, a deviation per quantity.
fn deviations(case: &Case, steps: u64, found: &WashState, truth: &WashState) -> Vec<Deviation> {
    let deviation = |quantity: String, error, tolerance| {
        let case = case.name.clone();
        Deviation { case, steps, quantity, error, tolerance }
    };
    let rows = 0..truth.layout().height();
    let wet = |state: &WashState| rows.clone().flat_map(|y| state.wet_mask.cells(y).to_vec()).collect();
    let (found_wet, true_wet): (Vec<u8>, Vec<u8>) = (wet(found), wet(truth));
    let differing = found_wet.iter().zip(&true_wet).filter(|(found, truth)| found != truth).count();
    // A cell is wet or it is not: no tolerance.
    let mut all = vec![deviation("wet_mask".into(), differing as f64, 0.0)];
    for ((name, found), (_, truth)) in fields(found).into_iter().zip(fields(truth)) {
        let squares: f64 =
            values(found).zip(values(truth)).map(|(found, truth)| (found - truth).powi(2)).sum();
        let norm = values(truth).map(|truth| truth * truth).sum::<f64>().sqrt();
        all.push(deviation(name, squares.sqrt() / norm.max(LEAST_NORM), FIELD_TOLERANCE));
    }
    let totals = found.pigment_totals().into_iter().zip(truth.pigment_totals());
    for (k, (found, truth)) in totals.enumerate() {
        let error = (found - truth).abs() / truth.max(LEAST_NORM);
        all.push(deviation(format!("total of pigment {k}"), error, TOTAL_TOLERANCE));
    }
    if let (Some(found), Some(truth)) = (found.ledger, truth.ledger) {
        let error = (found.evaporated - truth.evaporated).abs() / truth.evaporated.max(LEAST_NORM);
        all.push(deviation("evaporated".into(), error, TOTAL_TOLERANCE));
        // Whole parts of a sum that is taken in f64 by both.
        all.push(deviation("contact_carry".into(), (found.contact_carry - truth.contact_carry).abs(), 1e-9));
    }
    all
}

/// Runs a case by a model and compares it wherever the truth is stored.
fn run(case: &Case, model: WashModel, config: &RunConfig<'_>) -> Vec<Deviation> {
    let mut wash = Wash::new(case.start.clone(), model, case.handlings.clone()).unwrap();
    let mut all = Vec::new();
    let mut done = 0;
    for (steps, truth) in &case.truth {
        wash.run(steps - done, config).unwrap_or_else(|error| panic!("{}: {error}", case.name));
        done = *steps;
        all.extend(deviations(case, done, wash.state(), truth));
    }
    all
}

/// Holds an engine to the truth; prints the largest error of each quantity for whoever asks with `--nocapture`.
fn hold(engine: Engine, threads: usize) {
    let config = RunConfig { engine, threads, ..RunConfig::default() };
    let all: Vec<_> = cases().iter().flat_map(|case| run(case, case.settings.model, &config)).collect();
    let mut worst: BTreeMap<&str, &Deviation> = BTreeMap::new();
    for deviation in &all {
        let quantity = deviation.quantity.split('[').next().unwrap_or_default();
        let most = worst.entry(quantity).or_insert(deviation);
        if deviation.error > most.error {
            *most = deviation;
        }
    }
    for deviation in worst.values() {
        println!("{engine:?}: {deviation}");
    }
    let failed: Vec<_> =
        all.iter().filter(|deviation| deviation.is_too_large()).map(ToString::to_string).collect();
    assert!(failed.is_empty(), "{engine:?}:\n{}", failed.join("\n"));
}

#[test]
fn the_fast_engine_agrees_with_f64() {
    hold(Engine::Fast, 2);
}

#[test]
fn the_reference_engine_agrees_with_f64() {
    hold(Engine::Reference, 1);
}

#[test]
fn no_case_lacks_a_file() {
    let folders = folders();
    let is_living = |folder: &&PathBuf| name(folder).starts_with("living-");
    let living = folders.iter().filter(is_living).count();
    assert!(living > 0 && living < folders.len(), "both models have cases in fidelity/wash");
    for folder in &folders {
        let mut wanted: Vec<_> = STEPS.iter().map(|steps| format!("after-{steps}.npz")).collect();
        wanted.extend(["start.npz", "wash.toml"].map(String::from));
        let missing: Vec<_> = wanted.iter().filter(|file| !folder.join(file).is_file()).collect();
        assert!(missing.is_empty(), "{} lacks {missing:?}", name(folder));
    }
}

#[test]
fn pigments_resolve_by_name() {
    let library = Library::builtin();
    for case in cases() {
        let names = &case.settings.pigments;
        assert!(!names.is_empty(), "{}: no pigments are named", case.name);
        assert_eq!(names.len(), case.start.suspended.len(), "{}: pigments named and held", case.name);
        for name in names {
            let pigment = library.get(name).unwrap_or_else(|error| panic!("{}: {error}", case.name));
            assert_eq!(&pigment.id, name, "{}: pigments go by their id", case.name);
            let handling = handling_of(pigment);
            assert_eq!(handling.density, pigment.handling.density);
            assert_eq!(handling.staining_power, pigment.handling.staining_power);
            assert_eq!(handling.granulation, pigment.handling.granulation);
        }
    }
}

/// Whether a case is out of tolerance by some other model.
fn shows(case: &Case, changed: WashModel) -> bool {
    run(case, changed, &RunConfig { threads: 1, ..RunConfig::default() }).iter().any(Deviation::is_too_large)
}

/// A parameter to change, named.
type Change<P> = (&'static str, fn(&mut P));

/// The goldens see every parameter: with one of them slightly wrong, at least one case is out of tolerance.
#[test]
fn every_parameter_shows() {
    let changes: [Change<(C97Params, Capillary)>; 13] = [
        ("viscosity", |(params, _)| params.viscosity *= 1.01),
        ("viscous_drag", |(params, _)| params.viscous_drag *= 1.01),
        ("edge_darkening", |(params, _)| params.edge_darkening *= 1.01),
        ("edge_kernel", |(params, _)| params.edge_kernel += 1),
        ("relax_max_sweeps", |(params, _)| params.relax_max_sweeps -= 1),
        ("relax_tolerance", |(params, _)| params.relax_tolerance *= 1.05),
        ("relax_rate", |(params, _)| params.relax_rate *= 1.01),
        ("slope_scale", |(params, _)| params.slope_scale *= 1.01),
        ("absorption", |(_, capillary)| capillary.absorption *= 1.01),
        ("min_diffusing", |(_, capillary)| capillary.min_diffusing *= 1.05),
        ("min_receiving", |(_, capillary)| capillary.min_receiving *= 1.05),
        ("wetting_threshold", |(_, capillary)| capillary.wetting_threshold *= 1.01),
        ("capacity", |(_, capillary)| capillary.capacity[1] *= 1.01),
    ];
    let cases = cases();
    for (parameter, change) in changes {
        let shows = |case: &Case| {
            let WashModel::C97 { params, capillary } = case.settings.model else { return false };
            let mut both = (params, capillary.unwrap_or_default());
            change(&mut both);
            shows(case, WashModel::C97 { params: both.0, capillary: capillary.map(|_| both.1) })
        };
        assert!(cases.iter().any(shows), "`{parameter}` can be wrong and no case shows it");
    }
}

/// The same of the living wash, and no parameter is left out.
#[test]
fn every_living_parameter_shows() {
    let changes: [Change<LivingParams>; 31] = [
        ("compressibility", |params| params.compressibility *= 1.01),
        ("viscosity", |params| params.viscosity *= 1.01),
        ("viscous_drag", |params| params.viscous_drag *= 1.01),
        ("slope_scale", |params| params.slope_scale *= 1.01),
        ("slope_band", |params| params.slope_band *= 1.01),
        ("speed_limit", |params| params.speed_limit *= 1.01),
        ("flowing_film", |params| params.flowing_film *= 1.01),
        ("least_mobility", |params| params.least_mobility *= 1.01),
        ("pigment_diffusion", |params| params.pigment_diffusion *= 1.01),
        ("pigment_dispersion", |params| params.pigment_dispersion *= 1.01),
        ("packing_limit", |params| params.packing_limit *= 1.01),
        ("edge_darkening", |params| params.edge_darkening *= 1.01),
        ("edge_width", |params| params.edge_width *= 1.01),
        ("evaporation", |params| params.evaporation *= 1.01),
        ("pore_evaporation", |params| params.pore_evaporation *= 1.01),
        ("pore_depth", |params| params.pore_depth *= 1.01),
        ("rim_exponent", |params| params.rim_exponent += 1),
        ("settling", |params| params.settling *= 1.01),
        ("lifting", |params| params.lifting *= 1.01),
        ("absorption", |params| params.absorption *= 1.01),
        ("min_diffusing", |params| params.min_diffusing *= 1.05),
        ("min_receiving", |params| params.min_receiving *= 1.05),
        ("capacity", |params| params.capacity[1] *= 1.01),
        ("wetting_film", |params| params.wetting_film *= 1.01),
        ("drying_film", |params| params.drying_film *= 1.01),
        ("pinning", |params| params.pinning *= 1.01),
        ("pin_roughness", |params| params.pin_roughness *= 1.05),
        ("creep_speed", |params| params.creep_speed *= 1.05),
        ("creep_share", |params| params.creep_share *= 1.01),
        ("tilt", |params| params.tilt *= 1.01),
        ("tilt_toward", |params| params.tilt_toward *= 1.01),
    ];
    let named: Vec<_> = changes.iter().map(|(parameter, _)| *parameter).collect();
    let known: Vec<_> = LivingParams::ROWS.iter().map(|row| row.id).collect();
    assert_eq!(named, known);
    let cases = cases();
    for (parameter, change) in changes {
        let shows = |case: &Case| {
            let WashModel::Living(mut params) = case.settings.model else { return false };
            change(&mut params);
            shows(case, WashModel::Living(params))
        };
        assert!(cases.iter().any(shows), "`{parameter}` can be wrong and no case shows it");
    }
}

/// Cases that change nothing were made with the defaults that the engines have.
#[test]
fn the_truth_has_the_same_defaults() {
    let cases = cases();
    let of = |name: &str| cases.iter().find(|case| case.name == name).unwrap().settings.model;
    assert_eq!(of("living-damp-paper"), WashModel::living());
    assert_eq!(of("ragged-edge"), WashModel::c97());
}
