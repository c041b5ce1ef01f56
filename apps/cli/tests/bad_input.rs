//! Everything that may be wrong: one line of cause, a hint, the exit code of its kind, and nothing written.

mod common;

use common::{Array, Folder, bytes_of, npz, puddle, read_only_folder, skip, studio};

const RUN: &str =
    "wash --state bad.npz --steps 3 --pigments french-ultramarine --save out.npz --image out.png";
const CELLS: [usize; 2] = [6, 8];
const PIGMENT: [usize; 3] = [1, 6, 8];

/// Cause and hint for a state of these arrays; a wet mask and suspended pigment are added if there are none.
fn of(arrays: Vec<Array>) -> (String, String) {
    let folder = Folder::new();
    let mut all = arrays;
    if !all.iter().any(|array| array.name == "wet_mask") {
        all.push(Array::u8("wet_mask", &CELLS, |_| 1));
    }
    if !all.iter().any(|array| ["suspended", "deposited"].contains(&array.name)) {
        all.push(Array::f32("suspended", &PIGMENT, |_| 0.3));
    }
    folder.write("bad.npz", npz(&all));
    folder.fails(RUN, 4)
}

#[test]
fn a_state_made_by_hand_is_fine() {
    let folder = Folder::new();
    let arrays = [Array::u8("wet_mask", &CELLS, |_| 1), Array::f32("suspended", &PIGMENT, |_| 0.3)];
    folder.write("bad.npz", npz(&arrays));
    folder.run(&format!("{RUN} -q")).fine();
}

#[test]
fn values_that_no_state_has() {
    for (name, shape, value, word) in [
        ("height", &CELLS[..], f32::NAN, "NaN"),
        ("u", &[6, 9], f32::INFINITY, "inf"),
        ("v", &[7, 8], f32::NEG_INFINITY, "-inf"),
        ("pressure", &CELLS, f32::NAN, "NaN"),
        ("saturation", &CELLS, f32::INFINITY, "inf"),
        ("saturation", &CELLS, -0.5, "-0.5"),
        ("suspended", &PIGMENT, -0.25, "-0.25"),
        ("suspended", &PIGMENT, f32::NAN, "NaN"),
        ("deposited", &PIGMENT, -1.0, "-1"),
        ("deposited", &PIGMENT, f32::INFINITY, "inf"),
        ("height", &CELLS, 1.5, "1.5"),
        ("height", &CELLS, -0.1, "-0.1"),
    ] {
        let (cause, _) = of(vec![Array::f32(name, shape, |i| if i == 11 { value } else { 0.5 })]);
        assert!(cause.contains(&format!("`{name}` is {word}")), "{cause}");
        assert!(cause.contains("column") && cause.contains("bad.npz"), "{cause}");
    }
    let (cause, hint) = of(vec![Array::u8("wet_mask", &CELLS, |i| if i == 9 { 2 } else { 1 })]);
    assert!(cause.contains("`wet_mask` is 2 at column 1, row 1"), "{cause}");
    assert!(hint.contains("wet_mask > 0"), "{hint}");
}

#[test]
fn arrays_of_another_type_or_shape() {
    let (cause, hint) = of(vec![Array { descr: "<i4", ..Array::f32("pressure", &CELLS, |_| 0.0) }]);
    assert!(cause.contains("`pressure` is int32"), "{cause}");
    assert!(hint.contains(".astype"), "{hint}");
    let (cause, _) = of(vec![Array::f32("wet_mask", &CELLS, |_| 1.0)]);
    assert!(cause.contains("`wet_mask` is float32"), "{cause}");
    let (cause, _) = of(vec![Array::f32("u", &CELLS, |_| 0.0)]);
    assert!(cause.contains("`u` has the shape (6, 8), not (6, 9)"), "{cause}");
    let (cause, _) = of(vec![Array::u8("wet_mask", &[8, 6], |_| 1)]);
    assert!(cause.contains("`suspended` has the shape"), "{cause}");
    let (cause, _) = of(vec![Array::f32("suspended", &CELLS, |_| 0.1)]);
    assert!(cause.contains("`suspended` has the shape"), "{cause}");
    let (cause, hint) = of(vec![Array::f32("presure", &CELLS, |_| 0.0)]);
    assert!(cause.contains("unknown array `presure`") && hint.contains("`pressure`"), "{cause} {hint}");
}

#[test]
fn sizes_beyond_reason() {
    let huge = || Array { shape: vec![4_000_000_000, 4_000_000_000], ..Array::u8("wet_mask", &CELLS, |_| 1) };
    let (cause, _) = of(vec![huge()]);
    assert!(cause.contains("cells"), "{cause}");
    let (cause, _) = of(vec![Array { shape: vec![0, 8], bytes: Vec::new(), ..huge() }]);
    assert!(cause.contains("empty"), "{cause}");
    let folder = studio();
    folder.fails("wash --state in.npz --steps 99999999999999999999", 2);
    folder.fails("wash --state in.npz --steps 9999999999", 2);
    folder.fails("wash --state in.npz --steps 900000000 --every 1 --image ##.png", 2);
    folder.fails("wash --state in.npz --steps 3 --threads 0", 2);
    folder.fails("wash --state in.npz --steps 3 --threads 1000000", 2);
    folder.fails("paper rough out.png --size-mm 99999x99999", 2);
    folder.fails("paper rough out.png --size-mm 1e99x1", 2);
    folder.fails("swatches out.png --size 1000000", 2);
}

#[test]
fn files_that_are_cut_or_none() {
    let folder = studio();
    let whole = folder.read("in.npz");
    for length in [0, 1, 30, 200, whole.len() / 2, whole.len() - 1] {
        folder.write("bad.npz", &whole[..length]);
        let (cause, _) = folder.fails(RUN, 4);
        assert!(cause.starts_with("`bad.npz`: "), "{cause}");
    }
    folder.write("bad.npz", "not an archive at all");
    folder.fails(RUN, 4);
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 0x40;
    folder.write("bad.npz", flipped);
    folder.fails(RUN, 4);
    std::fs::create_dir(folder.path("folder.npz")).unwrap();
    folder.fails("wash --state folder.npz --steps 1", 4);
    let (cause, hint) = folder.fails("wash --state inn.npz --steps 1", 4);
    assert!(cause.contains("inn.npz") && hint.contains("`in.npz`"), "{cause} {hint}");
    folder.fails("wash --state - --steps 1", 4);
}

#[test]
fn pigments_that_are_not_there() {
    let folder = Folder::new();
    folder.write("in.npz", bytes_of(&puddle(20, 20, 2)));
    let (cause, hint) = folder.fails("wash --state in.npz --steps 1", 4);
    assert!(cause.contains("2 suspended") && cause.contains("0 named"), "{cause}");
    assert!(hint.contains("pigments = ["), "{hint}");
    let (cause, _) = folder.fails("wash --state in.npz --steps 1 --pigments burnt-umber", 4);
    assert!(cause.contains("2 suspended") && cause.contains("1 named"), "{cause}");
    let (cause, hint) = folder.fails("wash --state in.npz --steps 1 --pigments burnt-umber,ultramarin", 2);
    assert!(cause.contains("`ultramarin`") && hint.contains("ultramarine"), "{cause} {hint}");
    folder.write("wash.toml", "pigments = [\"burnt-umbre\", \"viridian\"]\n");
    let (cause, hint) = folder.fails("wash --state in.npz --steps 1", 4);
    assert!(cause.starts_with("wash.toml:1:13: `pigments[1]`: "), "{cause}");
    assert!(cause.contains("`burnt-umbre`") && hint.contains("`burnt-umber`"), "{cause} {hint}");
    folder.write("wash.toml", "viscosity = 0.1\npigments = [\n  \"viridian\",\n  \"viridiann\",\n]\n");
    let (cause, _) = folder.fails("wash --state in.npz --steps 1", 4);
    assert!(cause.starts_with("wash.toml:4:3: `pigments[2]`: "), "{cause}");
    folder.fails("mix burnt-umbre:0.3", 2);
    folder.fails("mix burnt-umber:-1", 2);
    folder.fails("mix burnt-umber:inf", 2);
    folder.fails("mix burnt-umber --over whit", 2);
    folder.fails("pigments nothing-like-it", 2);
}

#[test]
fn parameters_that_are_not_there_or_out_of_range() {
    let folder = studio();
    folder.write("p.toml", "viscosity = 0.1\nviscosty = 0.2\n");
    let (cause, hint) = folder.fails("wash --state in.npz --steps 1 --params p.toml", 4);
    assert_eq!(cause, "p.toml:2:1: unknown key `viscosty`");
    assert_eq!(hint, "did you mean `viscosity`?");
    folder.write("p.toml", "viscosity = 3\n");
    folder.fails("wash --state in.npz --steps 1 --params p.toml", 4);
    folder.write("p.toml", "viscosity = \n");
    folder.fails("wash --state in.npz --steps 1 --params p.toml", 4);
    folder.write("p.toml", [0xff, 0xfe, 0x00]);
    folder.fails("wash --state in.npz --steps 1 --params p.toml", 4);
    folder.fails("wash --state in.npz --steps 1 --params none.toml", 4);
    let (cause, hint) = folder.fails("wash --state in.npz --steps 1 --viscosty 0.1", 2);
    assert!(cause.contains("--viscosty") && hint.contains("--viscosity"), "{cause} {hint}");
    let (cause, _) = folder.fails("wash --state in.npz --steps 1 --viscosity 3", 2);
    assert!(cause.contains("outside 0 to 1"), "{cause}");
    folder.fails("wash --state in.npz --steps 1 --viscosity -0.1", 2);
    folder.fails("wash --state in.npz --steps 1 --capillary-capacity 0.9,0.3", 2);
    folder.fails("wash --state in.npz --steps 1 --model c98", 2);
    folder.fails("wash --state in.npz --steps -1", 2);
    folder.fails("wash --state in.npz --steps 1 --every 0 --image ##.png", 2);
    let (_, hint) = folder.fails("wash --state in.npz --steps 4 --every 2 --image out.png", 2);
    assert!(hint.contains("####"), "{hint}");
    folder.fails("wash --state in.npz --steps 4 --every 2", 2);
    folder.fails("wash --state in.npz --steps 4 --every 2 --image -", 2);
}

#[test]
fn water_that_runs_away() {
    let folder = studio();
    let mut state = puddle(24, 24, 1);
    state.pressure.cells_mut(12)[12] = 1e9;
    folder.write("bad.npz", bytes_of(&state));
    let (cause, hint) = folder.fails(RUN, 1);
    assert!(cause.contains("ran away in step 1"), "{cause}");
    assert!(hint.contains("pressure"), "{hint}");
}

#[test]
fn places_that_cannot_be_written() {
    let folder = studio();
    let run = "wash --state in.npz --steps 1";
    let (cause, hint) = folder.fails(&format!("{run} --save none/out.npz"), 1);
    assert!(cause.contains("none/out.npz") && hint.contains("mkdir"), "{cause} {hint}");
    folder.fails(&format!("{run} --image none/##.png --every 1"), 1);
    folder.fails("paper rough none/out.png", 1);
    folder.fails("effects none/out", 1);
    folder.fails(&format!("{run} --save ."), 1);
    let (cause, hint) = folder.fails(&format!("{run} --image out.jpg"), 2);
    assert!(cause.contains("writes png") && hint.contains(".png"), "{cause} {hint}");
    folder.fails(&format!("{run} --save out.png"), 2);
    let (cause, _) = folder.fails("wash --state in.npz --steps -1", 2);
    assert!(cause.contains("-1"), "{cause}");
    folder.write("vast.toml", "format = 1\n[sheet]\nsize = [2000, 2000]\npixels_per_mm = 100\n");
    let (cause, hint) = folder.fails("paint vast.toml vast.png --dry-run", 4);
    assert!(cause.contains("cells") && hint.contains("pixels_per_mm"), "{cause} {hint}");
    folder.fails(&format!("{run} --save wash.toml/out.npz"), 1);
    match read_only_folder(&folder) {
        Some(locked) => {
            folder.fails(&format!("{run} --save {}", locked.join("out.npz").display()), 1);
            folder.fails(&format!("swatches {}", locked.join("out.png").display()), 1);
        }
        None => skip("no folder here is read-only for this user"),
    }
    folder.write("out.npz", "old");
    let (cause, hint) = folder.fails(&format!("{run} --save out.npz"), 5);
    assert!(cause.contains("out.npz") && hint.contains("--overwrite"), "{cause} {hint}");
    // The second output stands in the way of the first.
    folder.write("out.png", "old");
    folder.fails(&format!("{run} --save new.npz --image out.png"), 5);
    folder.fails(&format!("{run} --save a --image ./a"), 2);
    folder.fails("effects wash.toml", 1);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk() {
    let folder = studio();
    let (cause, hint) = folder.fails("wash -q --state in.npz --steps 1 --save /dev/full --image out.png", 1);
    assert!(cause.contains("/dev/full") && hint.contains("room"), "{cause} {hint}");
    folder.run("wash -q --state in.npz --steps 1 --save /dev/null").fine();
    assert!(!std::fs::metadata("/dev/null").unwrap().is_file());
}

#[test]
fn more_memory_than_is_allowed() {
    let folder = studio();
    folder.write("doc.toml", "format = 1\n[sheet]\nsize = [100, 100]\npixels_per_mm = 8\n");
    for (line, lower) in [
        ("wash --state in.npz --steps 1 --image out.png --memory 60kB", "fewer cells"),
        ("paint doc.toml out.png --memory 10MB", "--scale"),
        ("swatches out.png --memory 1MiB", "--size"),
        ("effects fx --memory 1MB", "--size"),
    ] {
        let (cause, hint) = folder.fails(line, 1);
        assert!(cause.contains("MB") && cause.contains("`--memory` allows"), "{cause}");
        assert!(hint.contains(lower) && hint.contains("allow more"), "{hint}");
    }
    assert!(!folder.has("fx"));
    // What does not even fit while it is read.
    let (cause, _) = folder.fails("wash --state in.npz --steps 1 --memory 2kB", 1);
    assert!(cause.contains("`in.npz` alone"), "{cause}");
    folder.fails("wash --state in.npz --steps 1 --memory 500", 2);
    folder.run("wash -q --state in.npz --steps 1 --image out.png --memory 1MB").fine();
    folder.run("paint doc.toml fine.png -q --memory 1GB").fine();
}

#[cfg(target_os = "linux")]
#[test]
fn more_memory_than_there_is() {
    let folder = studio();
    let huge = |height: usize| {
        let mask = Array { shape: vec![height, 8192], ..Array::u8("wet_mask", &[height * 8192], |_| 0) };
        npz(&[mask])
    };
    folder.write("huge.npz", huge(4096));
    folder.write("doc.toml", "format = 1\n[sheet]\nsize = [1000, 1000]\npixels_per_mm = 8\n");
    let map = Array { shape: vec![4096, 8192], ..Array::u8("map", &[4096 * 8192], |_| 0) };
    folder.write("map.npz", npz(&[map]));
    let area = "area = { shape = \"map\", file = \"map.npz\" }";
    let sheet = "format = 1\n[sheet]\nsize = [10, 10]\n";
    folder.write("map.toml", format!("{sheet}[[glaze]]\n[[glaze.events]]\ndo = \"wet\"\n{area}\n"));
    folder.run("paper rough scan.png --size-mm 20.48x20.48 --cells-per-mm 200").fine();
    let before = folder.files();
    for (line, said) in [
        ("wash --state huge.npz --steps 1 --save out.npz", "not enough memory"),
        ("paint doc.toml out.png", "not enough memory"),
        ("paint map.toml out.png", "not enough memory"),
        ("paper scan.png out.png --pixels-per-mm 200 --size-mm 1x1", "not enough memory"),
        ("paper rough out.png --size-mm 40.96x40.96 --cells-per-mm 200", "not enough memory"),
    ] {
        let command = format!("ulimit -v 300000; exec {} {line} --threads 1", env!("CARGO_BIN_EXE_girtin"));
        let mut shell = std::process::Command::new("sh");
        let ran = shell.args(["-c", &command]).current_dir(folder.path("")).output().unwrap();
        let stderr = String::from_utf8(ran.stderr).unwrap();
        assert_eq!(ran.status.code(), Some(1), "{line}: {stderr}");
        assert!(stderr.contains(said) && stderr.contains("\nhint: "), "{line}: {stderr}");
    }
    assert!(folder.files() == before);
}

#[test]
fn pictures_that_a_wash_cannot_lie_on() {
    let folder = studio();
    let run = "wash --state in.npz --steps 1 --image out.png --over";
    folder.run("paper rough small.png --size-mm 8x8 --cells-per-mm 2").fine();
    let (cause, hint) = folder.fails(&format!("{run} small.png"), 4);
    assert!(cause.contains("16 × 16 pixels") && cause.contains("48 × 40 cells"), "{cause}");
    assert!(hint.contains("scale"), "{hint}");
    folder.write("bad.png", "no picture");
    let (cause, _) = folder.fails(&format!("{run} bad.png"), 4);
    assert!(cause.starts_with("`bad.png`: "), "{cause}");
    let (cause, _) = folder.fails(&format!("{run} none.png"), 4);
    assert!(cause.contains("none.png"), "{cause}");
    let (cause, _) = folder.fails(&format!("{run} whit"), 2);
    assert!(cause.contains("a picture's file"), "{cause}");
    folder.fails(&format!("{run} small.png --overwrite --image small.png"), 2);
    folder.fails("wash --state - --steps 1 --image out.png --over -", 2);
}

#[test]
fn inputs_are_never_written_to() {
    let folder = studio();
    let run = "wash --state in.npz --steps 1 --overwrite --save";
    std::fs::create_dir(folder.path("sub")).unwrap();
    for spelling in ["in.npz", "./in.npz", "sub/../in.npz", "wash.toml"] {
        let (cause, _) = folder.fails(&format!("{run} {spelling}"), 2);
        assert!(cause.contains("is an input"), "{cause}");
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("in.npz", folder.path("link.npz")).unwrap();
        std::fs::hard_link(folder.path("in.npz"), folder.path("hard.npz")).unwrap();
        folder.fails(&format!("{run} link.npz"), 2);
        folder.fails(&format!("{run} hard.npz"), 2);
        folder.fails("wash --state link.npz --steps 1 --overwrite --save in.npz", 2);
    }
}

#[test]
fn papers_and_scans() {
    let folder = Folder::new();
    let (_, hint) = folder.fails("paper cold-pres out.png", 2);
    assert!(hint.contains("`cold-press`"), "{hint}");
    folder.fails("paper none.toml out.png", 4);
    folder.write("mine.toml", "id = \"mine\"\nlabel = \"Mine\"\n[[toth]]\n");
    let (cause, _) = folder.fails("paper mine.toml out.png", 4);
    assert!(cause.starts_with("mine.toml:"), "{cause}");
    folder.write("scan.png", "no picture");
    let (_, hint) = folder.fails("paper scan.png out.png", 2);
    assert!(hint.contains("--pixels-per-mm"), "{hint}");
    folder.fails("paper scan.png out.png --pixels-per-mm 12", 4);
    folder.fails("paper scan.png scan.png --pixels-per-mm 12 --overwrite", 2);
    folder.fails("paper rough out.png --dark-is-high", 2);
    // A paper's own resolution is that of its cells; a slip of the finger in its name is said first.
    let (cause, hint) = folder.fails("paper rough out.png --pixels-per-mm 12", 2);
    assert!(cause.contains("`rough` is none") && hint.contains("--cells-per-mm"), "{cause} {hint}");
    let (cause, _) = folder.fails("paper rouhg out.png --pixels-per-mm 12", 2);
    assert!(cause.contains("no paper is called `rouhg`"), "{cause}");
    folder.write("scan", "no picture either");
    let (cause, _) = folder.fails("paper scan out.png --pixels-per-mm 12", 4);
    assert!(cause.starts_with("`scan`: "), "{cause}");
    let (cause, _) = folder.fails("paper - out.png", 2);
    assert!(cause.contains("the standard input is a scan of unknown size"), "{cause}");
    folder.fails("paper scan.png out.png --pixels-per-mm 12 --seed 3", 2);
    folder.fails("paper scan.png out.png --pixels-per-mm 12 --tile-mm 3x3", 2);
    folder.fails("paper rough", 2);
}

#[test]
fn documents() {
    let folder = Folder::new();
    let run = "paint doc.toml out.png";
    folder.fails(run, 4);
    folder.write("doc.toml", "format = 1\n");
    folder.fails(run, 4);
    folder.write("doc.toml", "format = 99\n[sheet]\nsize = [10, 10]\n");
    folder.fails(run, 4);
    folder.write("doc.toml", "format = 1\n[sheet]\nsize = [10, 10]\npaper = \"cold-pres\"\n");
    let (cause, hint) = folder.fails(run, 4);
    assert!(cause.starts_with("doc.toml:4:") && hint.contains("`cold-press`"), "{cause} {hint}");
    let map = |file: &str| {
        let area = format!("area = {{ shape = \"map\", file = \"{file}\" }}");
        format!("format = 1\n[sheet]\nsize = [10, 10]\n[[glaze]]\n[[glaze.events]]\ndo = \"wet\"\n{area}\n")
    };
    folder.write("doc.toml", map("none.png"));
    let (cause, hint) = folder.fails(run, 4);
    assert!(
        cause.starts_with("doc.toml:7:32: `glaze[1].events[1].area.file`: cannot read map `none.png`"),
        "{cause}"
    );
    assert!(hint.contains("folder"), "{hint}");
    folder.write("bad.png", "no picture").write("doc.toml", map("bad.png"));
    let (cause, _) = folder.fails(run, 4);
    assert!(cause.starts_with("doc.toml:7:32: `glaze[1].events[1].area.file`: map `bad.png`: "), "{cause}");
    folder.write("doc.toml", "format = 1\n[sheet]\nsize = [1000, 1000]\n");
    folder.fails("paint doc.toml out.png --scale 100", 4);
    folder.fails("paint doc.toml doc.toml --overwrite", 2);
}

#[test]
fn command_lines_that_make_no_sense() {
    let folder = Folder::new();
    let (cause, hint) = folder.fails("wsh --state in.npz", 2);
    assert!(cause.contains("'wsh'") && hint.contains("'wash'"), "{cause} {hint}");
    folder.fails("wash", 2);
    folder.fails("mix", 2);
    folder.fails("completions tcsh", 2);
    folder.fails("effects", 2);
    assert_eq!(folder.run("").code, 2);
    assert!(folder.run("").stderr.contains("hint: "));
}

#[test]
fn nothing_is_colored_or_wrapped_off_a_terminal() {
    let folder = Folder::new();
    let name = "a-very-long-folder-name/".repeat(9) + "in.npz";
    let (cause, _) = folder.fails(&format!("wash --state {name} --steps 1"), 4);
    assert!(cause.contains(&name) && !cause.contains('\u{1b}'), "{cause}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_terminal_shows_the_place_in_a_file() {
    let folder = studio();
    folder.write("p.toml", "viscosity = 0.1\nviscosty = 0.2\n");
    let line = format!("{} wash --state in.npz --steps 1 --params p.toml", env!("CARGO_BIN_EXE_girtin"));
    let show = |no_color: &str| {
        let mut script = std::process::Command::new("script");
        script.args(["-qec", &line, "/dev/null"]).current_dir(folder.path(""));
        script.env("NO_COLOR", no_color).env("TERM", "xterm").stdin(std::process::Stdio::null()).output()
    };
    let Ok(shown) = show("1") else {
        return skip("`script`, which makes a terminal, is not installed");
    };
    assert_eq!(shown.status.code(), Some(4));
    let plain = String::from_utf8(shown.stdout).unwrap();
    for part in ["unknown key `viscosty`", "viscosty = 0.2", "here", "did you mean `viscosity`?"] {
        assert!(plain.contains(part), "{part}: {plain}");
    }
    assert!(!plain.contains("\u{1b}["), "{plain}");
    let colored = String::from_utf8(show("").unwrap().stdout).unwrap();
    assert!(colored.contains("\u{1b}["), "{colored}");
}
