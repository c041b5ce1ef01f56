//! `girtin wash --model living`, and what else knows the living wash.

mod common;

use common::{Folder, bytes_of, png_size, puddle};
use girtin::painting::state_file;
use girtin::wash::{Ledger, WashState};

/// A folder with a state of the living wash, 8 cells a millimetre, and its parameters.
fn studio() -> Folder {
    let folder = Folder::new();
    let state = WashState { ledger: Some(Ledger::new(8.0)), ..puddle(48, 40, 1) };
    folder.write("in.npz", bytes_of(&state)).write("plain.npz", bytes_of(&puddle(48, 40, 1)));
    folder.write(
        "params.toml",
        "model = 'living'\npigments = ['cobalt-blue']\n[living]\nevaporation = 0.004\n",
    );
    folder
}

fn state(folder: &Folder, name: &str) -> WashState {
    state_file::read(std::io::Cursor::new(folder.read(name))).unwrap()
}

#[test]
fn a_state_of_the_living_wash_goes_on_as_one() {
    let folder = studio();
    let told = folder
        .run("wash --state in.npz --pigments cobalt-blue --steps 9 --save out.npz --json")
        .fine()
        .json();
    let ledger = state(&folder, "out.npz").ledger.unwrap();
    assert_eq!(ledger.cells_per_mm, 8.0);
    assert_eq!(ledger.contact_carry, 0.5, "nine steps of half a cell");
    assert!(ledger.evaporated > 0.0);
    assert_eq!(told["evaporated"].as_f64(), Some(ledger.evaporated));
    // The same asked for in other ways.
    let asked = "--model living --cells-per-mm 8";
    folder
        .run(&format!("wash -q --state plain.npz --pigments cobalt-blue --steps 9 {asked} --save asked.npz"))
        .fine();
    assert!(folder.read("out.npz") == folder.read("asked.npz"));
}

#[test]
fn a_run_cut_in_two_and_any_number_of_threads_give_the_same_bytes() {
    let folder = studio();
    let wash = "wash -q --params params.toml --overwrite";
    folder.run(&format!("{wash} --state in.npz --steps 33 --save whole.npz --threads 1")).fine();
    folder.run(&format!("{wash} --state in.npz --steps 14 --save part.npz --threads 2")).fine();
    folder.run(&format!("{wash} --state part.npz --steps 19 --save rest.npz --threads 7")).fine();
    assert!(folder.read("whole.npz") == folder.read("rest.npz"));
}

#[test]
fn a_state_without_a_scale_has_four_cells_a_millimetre() {
    let folder = studio();
    let run = |more: &str| {
        let line = format!("wash -q --state plain.npz --params params.toml --steps 5 --overwrite {more}");
        folder.run(&line).fine();
    };
    run("--save four.npz");
    run("--save said.npz --cells-per-mm 4");
    assert!(folder.read("four.npz") == folder.read("said.npz"));
    run("--save other.npz --cells-per-mm 6");
    assert!(folder.read("four.npz") != folder.read("other.npz"));
}

#[test]
fn flags_go_over_the_file_and_the_file_over_defaults() {
    let folder = studio();
    let run = |name: &str, more: &str| {
        let line = format!("wash -q --state in.npz --pigments cobalt-blue --steps 8 --save {name} {more}");
        folder.run(&line).fine();
        folder.read(name)
    };
    let of_file = run("file.npz", "--params params.toml");
    assert!(of_file == run("flag.npz", "--living-evaporation 0.004"));
    assert!(of_file != run("default.npz", ""));
    assert!(run("over.npz", "--params params.toml --living-evaporation 0.002") == folder.read("default.npz"));
}

#[test]
fn what_belongs_to_the_other_model_is_refused() {
    let folder = studio();
    let usage = |more: &str, said: &str| {
        let line = format!("wash --state in.npz --pigments cobalt-blue --steps 1 {more}");
        let (message, hint) = folder.fails(&line, 2);
        assert!(message.contains(said), "{message}");
        assert!(!hint.is_empty(), "{message}");
    };
    usage("--viscosity 0.2", "is a parameter of the model `c97`");
    usage("--capillary", "is a parameter of the model `c97`");
    usage("--model c97 --living-evaporation 0.1", "is a parameter of the model `living`");
    usage("--model c97 --cells-per-mm 8", "C97 knows only cells");
    usage("--cells-per-mm 6", "has 8 cells a millimetre");
    for (text, said) in [
        ("model = 'living'\nviscosity = 0.1", "viscosity"),
        ("model = 'c97'\n[living]", "living"),
        ("[living]\nevaporaton = 0", "evaporaton"),
        ("[living]\nevaporation = 7", "outside"),
    ] {
        folder.write("bad.toml", text);
        let line = "wash --state in.npz --params bad.toml --pigments cobalt-blue --steps 1";
        let (message, hint) = folder.fails(line, 4);
        assert!(message.contains(said) || hint.contains(said), "{message} {hint}");
    }
}

#[test]
fn a_document_is_painted_with_coarse_water_too() {
    let folder = studio();
    let document = "format = 1\n[sheet]\nsize = [12, 9]\npixels_per_mm = 8\n[[glaze]]\npigments = ['cobalt-blue']\n\
        [[glaze.events]]\ndo = 'moisten'\nvolumes = 0.5\narea = { shape = 'rectangle', from = [1, 1], to = [11, 8] }\n\
        [[glaze.events]]\ndo = 'brush'\nwater = 0.7\namounts = [0.5]\n\
        area = { shape = 'disc', center = [6, 4.5], radius = 2.5 }\n\
        [[glaze.events]]\ndo = 'run'\nsteps = 10\n\
        [[glaze.events]]\ndo = 'tilt'\ndegrees = 30\n\
        [[glaze.events]]\ndo = 'blot'\nfraction = 0.5\narea = { shape = 'disc', center = [8, 5], radius = 1 }\n\
        [[glaze.events]]\ndo = 'dry'\narea = { shape = 'rectangle', from = [0, 0], to = [3, 9] }\n\
        [[glaze.events]]\ndo = 'run'\nsteps = 500\nuntil = 'dry'\n";
    folder
        .write("leaning.toml", document)
        .write("flat.toml", document.replace("degrees = 30", "degrees = 0"));
    let paint = |name: &str, water: &str| {
        let out = format!("{name}-{water}.png");
        folder.run(&format!("paint -q {name}.toml {out} --water {water}")).fine();
        folder.read(&out)
    };
    let coarse = paint("flat", "coarse");
    assert_eq!(png_size(&coarse), (96, 72));
    assert!(coarse != paint("flat", "full"));
    // A board that leans keeps its water fine.
    assert!(paint("leaning", "coarse") == paint("leaning", "full"));
    folder.write(
        "c97.toml",
        document.replace(
            "[[glaze.events]]\ndo = 'moisten'",
            "[glaze.wash]\nmodel = 'c97'\n[[glaze.events]]\ndo = 'moisten'",
        ),
    );
    let (message, _) = folder.fails("paint c97.toml no.png", 4);
    assert!(message.contains("living wash"), "{message}");
}

#[test]
fn sizes_that_a_living_wash_cannot_have_are_refused_before_work() {
    let folder = studio();
    let document =
        "format = 1\n[sheet]\nsize = [12, 9]\npixels_per_mm = 8\n[[glaze]]\npigments = ['cobalt-blue']\n";
    folder.write("doc.toml", document);
    for more in ["--scale 40", "--scale 40 --dry-run", "--scale 0.01"] {
        let (message, hint) = folder.fails(&format!("paint doc.toml out.png {more}"), 4);
        assert!(message.contains("cells a mm"), "{more}: {message}");
        assert!(hint.contains("pixels_per_mm"), "{more}: {hint}");
    }
    assert!(!folder.has("out.png"));
    let (message, hint) = folder.fails("effects out --model living --size 16384", 2);
    assert!(message.contains("cells") && hint.contains("--size"), "{message} {hint}");
    folder.run("effects out --model living --size 24 -q").fine();
    assert_eq!(png_size(&folder.read("out/wetness-strip.png")).0, 24);
}

#[test]
fn numbers_of_a_state_are_named_when_they_are_wrong() {
    let folder = studio();
    let bad =
        WashState { ledger: Some(Ledger { contact_carry: 0.5, ..Ledger::new(4.0) }), ..puddle(8, 6, 1) };
    let mut bytes = bytes_of(&bad);
    // The name of a number misspelt, in the archive's entry and in its directory.
    for at in 0..bytes.len() - 12 {
        if bytes[at..].starts_with(b"cells_per_mm") {
            bytes[at + 11] = b'n';
        }
    }
    folder.write("bad.npz", bytes);
    let (message, hint) = folder.fails("wash --state bad.npz --pigments cobalt-blue --steps 1", 4);
    assert!(message.contains("cells_per_mn") && hint.contains("`cells_per_mm`"), "{message} {hint}");
}
