//! `girtin wash`, when all is well.

mod common;

use common::{Folder, bytes_of, holds, png_size, puddle, studio};
use girtin::painting::state_file;
use serde_json::Value;

#[test]
fn a_state_runs_and_is_saved_pictured_and_told() {
    let folder = studio();
    let ran = folder.run("wash --state in.npz --steps 12 --save out.npz --image out.png --json").fine();
    let told = ran.json();
    let keys: Vec<&String> = told.as_object().unwrap().keys().collect();
    assert_eq!(keys, ["max_speed", "pigment", "seconds", "steps", "sweeps_total", "water"]);
    assert_eq!(told["steps"], 12);
    assert!(told["sweeps_total"].as_u64().unwrap() >= 12);
    assert!(told["max_speed"].as_f64().unwrap() > 0.0);
    let before = puddle(48, 40, 1).pigment_totals()[0];
    assert!((told["pigment"][0].as_f64().unwrap() - before).abs() < 1e-3 * before);
    assert_eq!(png_size(&folder.read("out.png")), (48, 40));
    let state = state_file::read(std::io::Cursor::new(folder.read("out.npz"))).unwrap();
    assert_eq!(f64::from(state.max_speed()) as f32, told["max_speed"].as_f64().unwrap() as f32);
}

#[test]
fn the_number_of_threads_changes_no_byte() {
    let folder = studio();
    for threads in [1, 2, 7] {
        let out = format!("--save {threads}.npz --image {threads}.png");
        folder.run(&format!("wash -q --state in.npz --steps 15 --threads {threads} {out}")).fine();
    }
    for threads in [2, 7] {
        assert!(folder.read("1.npz") == folder.read(&format!("{threads}.npz")));
        assert!(folder.read("1.png") == folder.read(&format!("{threads}.png")));
    }
}

#[test]
fn a_run_cut_in_two_is_the_whole_run() {
    let folder = studio();
    for layer in ["", "--capillary --capillary-wetting-threshold 0.3"] {
        folder.run(&format!("wash -q --state in.npz --steps 20 --save whole.npz {layer} --overwrite")).fine();
        folder.run(&format!("wash -q --state in.npz --steps 7 --save part.npz {layer} --overwrite")).fine();
        folder
            .run(&format!("wash -q --state part.npz --steps 13 --save rest.npz {layer} --overwrite"))
            .fine();
        assert!(folder.read("whole.npz") == folder.read("rest.npz"), "{layer}");
        // Pictures on the way do not change the way.
        folder
            .run(&format!(
                "wash -q --state in.npz --steps 20 --save seen.npz --image ##.png --every 6 {layer} --overwrite"
            ))
            .fine();
        assert!(folder.read("whole.npz") == folder.read("seen.npz"), "{layer}");
    }
}

#[test]
fn frames_are_numbered_by_step_and_the_last_is_there() {
    let folder = studio();
    std::fs::create_dir(folder.path("frames")).unwrap();
    let line = "wash -q --state in.npz --steps 10 --image frames/####.png --every 4";
    folder.run(line).fine();
    let mut names: Vec<String> = std::fs::read_dir(folder.path("frames"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["0004.png", "0008.png", "0010.png"]);
    assert!(folder.read("frames/0004.png") != folder.read("frames/0010.png"));
    folder.run("wash -q --state in.npz --steps 10 --image single.png").fine();
    assert!(folder.read("single.png") == folder.read("frames/0010.png"));
    // One name already taken is enough, before the first step; skipping fills what is missing.
    std::fs::remove_file(folder.path("frames/0008.png")).unwrap();
    let (cause, _) = folder.fails(line, 5);
    assert!(cause.contains("0004.png"), "{cause}");
    folder.run(&format!("{line} --skip-existing")).fine();
    assert!(folder.has("frames/0008.png"));
    // Without --every, the template is for the last picture.
    folder.run("wash -q --state in.npz --steps 3 --image frames/####.png").fine();
    assert!(folder.has("frames/0003.png"));
}

#[test]
fn no_steps_are_steps_too() {
    let folder = studio();
    folder.run("wash -q --state in.npz --steps 0 --save out.npz --image ##.png").fine();
    assert!(folder.read("in.npz") == folder.read("out.npz"));
    assert_eq!(png_size(&folder.read("00.png")), (48, 40));
}

#[test]
fn pipes_go_both_ways() {
    let folder = studio();
    folder.run("wash -q --state in.npz --steps 5 --save out.npz --image out.png").fine();
    let state = folder.read("in.npz");
    // There is no folder with a wash.toml beside the standard input.
    let names = "--pigments french-ultramarine";
    let ran = folder.run_with(&format!("wash --state - --steps 5 --save - {names} --json"), &state);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    assert!(ran.stdout == folder.read("out.npz"));
    let told: Value = serde_json::from_str(&ran.stderr).unwrap();
    assert_eq!(told["steps"], 5);
    let ran = folder.run_with(&format!("wash -q --state - --steps 5 --image - {names}"), &state).fine();
    assert!(ran.stdout == folder.read("out.png"));
    folder.fails("wash --state in.npz --steps 5 --save - --image -", 2);
}

#[test]
fn flags_go_over_the_file_and_the_file_over_the_model() {
    let folder = studio();
    folder.write(
        "thick.toml",
        "pigments = [\"french-ultramarine\"]\nviscosity = 0.2\n[capillary]\nabsorption = 0.1\n",
    );
    let run = |extra: &str, out: &str| {
        folder.run(&format!("wash -q --state in.npz --steps 8 --save {out} {extra}")).fine();
        folder.read(out)
    };
    let plain = run("", "plain.npz");
    let by_file = run("--params thick.toml", "file.npz");
    assert!(plain != by_file);
    assert!(by_file == run("--viscosity 0.2 --capillary-absorption 0.1", "flags.npz"));
    let back = "--params thick.toml --viscosity 0.1 --no-capillary --model c97";
    assert!(plain == run(back, "back.npz"));
    assert!(run("--capillary", "on.npz") == run("--capillary-capacity 0.3,0.9", "same.npz"));
}

#[test]
fn pigments_may_be_the_painters_own() {
    let folder = Folder::new();
    folder.write("in.npz", bytes_of(&puddle(32, 32, 2)));
    folder.write(
        "mine.toml",
        "id = \"my-blue\"\nlabel = \"My blue\"\ndensity = 0.02\nstaining_power = 1.0\ngranulation = 0.4\n\
         [appearance]\nover_white = \"#2040c0\"\nover_black = \"#101830\"\n",
    );
    let line = "wash -q --state in.npz --steps 4 --pigments my-blue,Burnt_Umber --image out.png";
    folder.fails(line, 2);
    folder.run(&format!("{line} --pigment-file mine.toml")).fine();
    assert_eq!(png_size(&folder.read("out.png")), (32, 32));
}

#[test]
fn the_ground_of_a_picture_can_be_chosen() {
    let folder = studio();
    for (name, ground) in [("w", "white"), ("k", "black"), ("c", "#ffeecc")] {
        folder.run(&format!("wash -q --state in.npz --steps 1 --image {name}.png --over {ground}")).fine();
    }
    assert!(folder.read("w.png") != folder.read("k.png"));
    assert!(folder.read("w.png") != folder.read("c.png"));
}

#[test]
fn a_wash_may_lie_on_a_picture() {
    let folder = studio();
    let run = "wash -q --state in.npz --steps 3";
    folder.run(&format!("{run} --image white.png")).fine();
    // Bare paper of the same color as a picture: what comes out is the same; and a second wash lies on the first.
    folder.run(&format!("{run} --image k.png --over black")).fine();
    folder.write("dry.npz", bytes_of(&puddle(48, 40, 0)));
    folder.write("none.toml", "");
    folder.run("wash -q --state dry.npz --params none.toml --steps 0 --image bare.png --over black").fine();
    folder.run(&format!("{run} --image on.png --over bare.png")).fine();
    assert!(folder.read("on.png") == folder.read("k.png"));
    folder.run(&format!("{run} --image twice.png --over white.png")).fine();
    assert!(folder.read("twice.png") != folder.read("white.png"));
    let ran = folder.run_with(&format!("{run} --image - --over -"), &folder.read("bare.png")).fine();
    assert!(ran.stdout == folder.read("k.png"));
}

#[test]
fn more_is_said_when_asked() {
    let folder = studio();
    let ran = folder.run("wash -v --state in.npz --steps 3 --save out.npz --threads 2");
    assert_eq!((ran.code, ran.text().as_str()), (0, ""));
    for word in ["read in", "48 × 40", "2 threads", "memory: about", "3 steps", "written in"] {
        assert!(ran.stderr.contains(word), "{word}: {}", ran.stderr);
    }
    assert!(ran.stderr.lines().all(|line| line.starts_with("girtin: ")), "{}", ran.stderr);
    folder.write("doc.toml", "format = 1\n[sheet]\nsize = [10, 6]\npixels_per_mm = 4\n");
    let said = folder.run("paint doc.toml out.png --verbose").stderr;
    for word in ["40 × 24 pixels", "painted in", "written in"] {
        assert!(said.contains(word), "{word}: {said}");
    }
    folder.fails("wash -v -q --state in.npz --steps 3", 2);
}

#[test]
fn dry_paper_is_told_to_take_little_memory() {
    let folder = Folder::new();
    let told = |name: &str, state| {
        folder.write(name, bytes_of(&state));
        let text =
            folder.run(&format!("wash --state {name} --pigments PB60 --steps 9 --dry-run")).fine().text();
        let (_, after) = text.split_once("memory: about ").unwrap();
        after.split(' ').next().unwrap().parse::<u64>().unwrap()
    };
    let mut dry = puddle(1500, 1000, 1);
    let wet = told("wet.npz", dry.clone());
    for y in 0..1000 {
        dry.wet_mask.cells_mut(y).fill(0);
        dry.pressure.cells_mut(y).fill(0.0);
        dry.suspended[0].cells_mut(y).fill(0.0);
    }
    let dry = told("dry.npz", dry);
    assert!((6..9).contains(&dry) && wet > 4 * dry, "{dry} {wet}");
}

#[test]
fn pictures_say_who_made_them_and_not_where() {
    let folder = studio();
    folder.run("wash -q --state in.npz --steps 1 --image a.png").fine();
    folder.run("wash -q --state in.npz --steps 1 --image b.png --strip").fine();
    let told = folder.read("a.png");
    assert!(holds(&told, concat!("girtin ", env!("CARGO_PKG_VERSION"))));
    assert!(!holds(&told, "in.npz") && !holds(&told, folder.path("").to_str().unwrap()));
    assert!(!holds(&folder.read("b.png"), "girtin"));
}

#[test]
fn a_dry_run_tells_and_does_nothing() {
    let folder = studio();
    let before = folder.files();
    let told = folder.run("wash --state in.npz --steps 9 --save out.npz --dry-run").fine().text();
    for word in ["48 × 40", "french-ultramarine", "wash.toml", "9 steps", "memory"] {
        assert!(told.contains(word), "{word}: {told}");
    }
    let told = folder.run("wash --state in.npz --steps 9 --save out.npz --dry-run --json").fine().json();
    assert_eq!((&told["width"], &told["steps"]), (&48.into(), &9.into()));
    assert!(told["seconds_least"].as_f64() <= told["seconds_most"].as_f64() && told["memory_bytes"].is_u64());
    assert!(folder.files() == before);
}

#[test]
fn talk_is_on_the_standard_error_and_can_be_turned_off() {
    let folder = studio();
    let ran = folder.run("wash --state in.npz --steps 3");
    assert_eq!((ran.code, ran.text().as_str()), (0, ""));
    assert!(ran.stderr.starts_with("girtin: 3 steps"), "{}", ran.stderr);
    folder.run("wash -q --state in.npz --steps 3").fine();
    let ran = folder.run("wash -q --state in.npz --steps 3 --progress json");
    let last: Value = serde_json::from_str(ran.stderr.lines().last().unwrap()).unwrap();
    assert_eq!((&last["done"], &last["total"]), (&Value::from(3), &Value::from(3)));
}

#[test]
fn existing_outputs_are_replaced_or_left_as_asked() {
    let folder = studio();
    folder.write("out.npz", "old");
    folder.run("wash -q --state in.npz --steps 1 --save out.npz --skip-existing").fine();
    assert_eq!(folder.read("out.npz"), b"old");
    folder.run("wash -q --state in.npz --steps 1 --save out.npz --overwrite").fine();
    assert!(folder.read("out.npz") != b"old");
    folder.fails("wash --state in.npz --steps 1 --save out.npz --overwrite --skip-existing", 2);
}

#[cfg(unix)]
#[test]
fn outputs_have_the_rights_of_new_files() {
    use std::os::unix::fs::PermissionsExt;
    let folder = studio();
    folder.write("plain", "");
    folder.run("wash -q --state in.npz --steps 0 --save out.npz").fine();
    let mode = |name: &str| std::fs::metadata(folder.path(name)).unwrap().permissions().mode();
    assert_eq!(mode("out.npz"), mode("plain"));
}
