//! Every verb but the wash, when all is well.

mod common;

use std::process::Stdio;

use common::{Folder, Ran, holds, png_size};
use serde_json::Value;

const VERBS: [&str; 13] = [
    "watercolorize",
    "paint",
    "effects",
    "swatches",
    "wash",
    "pigments",
    "mix",
    "paper",
    "mattes",
    "inspect",
    "bench",
    "completions",
    "man",
];

fn run(line: &str) -> Ran {
    Folder::new().run(line).fine()
}

fn color(value: &Value) -> [f64; 3] {
    let channels: Vec<f64> = value.as_array().unwrap().iter().map(|c| c.as_f64().unwrap()).collect();
    channels.try_into().unwrap()
}

#[test]
fn a_mixture_has_a_color_encoded_and_linear() {
    let line = "mix hansa-yellow:0.4 cerulean-blue:0.3 --then quinacridone-rose:0.2 --over white --json";
    let told = run(line).json();
    assert_eq!(told.as_object().unwrap().len(), 2);
    let (srgb, linear) = (color(&told["srgb"]), color(&told["linear"]));
    for (encoded, linear) in srgb.into_iter().zip(linear) {
        assert!((0.0..=1.0).contains(&encoded) && (0.0..=1.0).contains(&linear));
        let decoded =
            if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) };
        assert!((decoded - linear).abs() < 1e-9);
    }
    let text = run("mix hansa-yellow:0.4 cerulean-blue:0.3").text();
    assert!(text.starts_with('#') && text.contains("linear"), "{text}");
}

#[test]
fn amounts_add_up_and_glazes_lie_over_each_other() {
    let json = |line: &str| run(&format!("mix {line} --json")).json();
    let near = |a: &Value, b: &Value| {
        color(&a["linear"]).iter().zip(color(&b["linear"])).all(|(a, b)| (a - b).abs() < 1e-12)
    };
    assert!(near(&json("burnt-umber:0.2 burnt-umber:0.3"), &json("burnt-umber:0.5")));
    assert!(near(&json("burnt-umber"), &json("burnt-umber:1")));
    // Layers of one paint are one layer; those of two depend on their order, and on which belong together.
    assert!(near(&json("burnt-umber:0.2 --then burnt-umber:0.3"), &json("burnt-umber:0.5")));
    let (blue, yellow, red) = ("cerulean-blue:0.5", "hansa-yellow:0.5", "indian-red:0.5");
    assert!(!near(&json(&format!("{blue} --then {yellow}")), &json(&format!("{yellow} --then {blue}"))));
    let stirred = json(&format!("{blue} --then {yellow} {red}"));
    assert!(!near(&stirred, &json(&format!("{blue} --then {yellow} --then {red}"))));
    assert_eq!(color(&json("burnt-umber:0 --over black")["srgb"]), [0.0; 3]);
    assert_eq!(color(&json("burnt-umber:0 --over white")["linear"]), [1.0; 3]);
    assert_eq!(color(&json("burnt-umber:0 --over #808080")["srgb"])[0], 128.0 / 255.0);
}

#[test]
fn pigments_are_listed_described_and_drawn() {
    let list = run("pigments").text();
    assert!(list.lines().count() >= 12);
    for name in ["quinacridone-rose", "french-ultramarine", "interference-lilac"] {
        assert!(list.contains(name), "{name}");
    }
    let told = run("pigments --json").json();
    assert_eq!(told.as_array().unwrap().len(), list.lines().count());
    let folder = Folder::new();
    let told = folder.run("pigments FRENCH_ultramarine --json --swatch s.png").fine().json();
    assert_eq!(told[0]["id"], "french-ultramarine");
    for key in ["density", "staining_power", "granulation"] {
        assert!(told[0][key].is_number(), "{key}");
    }
    let _ = color(&told[0]["over_white"]["srgb"]);
    let (width, height) = png_size(&folder.read("s.png"));
    assert!(width > 100 && height > 50);
    folder.fails("pigments --swatch s.png", 5);
    let page = run("pigments burnt-umber").text();
    assert!(page.contains("granulation"), "{page}");
    let ran = folder.run("pigments viridian --swatch -").fine();
    let _ = png_size(&ran.stdout);
}

#[test]
fn papers_are_listed_shown_and_scanned() {
    let list = run("paper --list").text();
    for name in ["cold-press", "hot-press", "rough", "laid", "canvas"] {
        assert!(list.contains(name), "{name}");
        assert!(
            run("paper --list --json").json().as_array().unwrap().iter().any(|paper| paper["id"] == name)
        );
    }
    let folder = Folder::new();
    let sheet = "paper cold-press";
    folder.run(&format!("{sheet} a.png --size-mm 10x5 --cells-per-mm 6 --height h.png")).fine();
    assert_eq!(png_size(&folder.read("a.png")), (60, 30));
    assert_eq!(png_size(&folder.read("h.png")), (60, 30));
    assert_eq!(folder.read("h.png")[24], 16, "bits of a channel");
    assert!(holds(&folder.read("a.png"), "pHYs"));
    folder.run(&format!("{sheet} b.png --size-mm 10x5 --cells-per-mm 6 --seed 1")).fine();
    assert!(folder.read("a.png") != folder.read("b.png"));
    folder.run(&format!("{sheet} c.png --size-mm 10x5 --cells-per-mm 6 --threads 1")).fine();
    assert!(folder.read("a.png") == folder.read("c.png"));
    folder.run(&format!("{sheet} tile.png --tile-mm 8x8 --cells-per-mm 4")).fine();
    assert_eq!(png_size(&folder.read("tile.png")), (32, 32));
    folder.run("paper a.png scanned.png --pixels-per-mm 6").fine();
    assert_eq!(png_size(&folder.read("scanned.png")), (80, 40));
    folder.write("mine.toml", "id = \"mine\"\nlabel = \"Mine\"\n[[tooth]]\n");
    folder.run("paper mine.toml d.png --size-mm 4x4").fine();
    assert!(
        folder.run("paper rough - --size-mm 4x4").fine().stdout == {
            folder.run("paper rough e.png --size-mm 4x4").fine();
            folder.read("e.png")
        }
    );
}

#[test]
fn the_gallery_is_painted() {
    let folder = Folder::new();
    folder.run("effects fx -q --size 48").fine();
    for name in ["drybrush", "edge-darkening", "backrun", "granulation", "flow", "glazing"] {
        let (width, height) = png_size(&folder.read(&format!("fx/{name}.png")));
        assert_eq!(width.max(height), 48, "{name}");
    }
    folder.fails("effects fx -q --size 48", 5);
    folder.run("effects fx -q --size 48 --skip-existing").fine();
    folder.run("swatches s.png -q --size 96").fine();
    let (width, height) = png_size(&folder.read("s.png"));
    assert_eq!(width.max(height), 96);
    assert!(holds(&folder.read("s.png"), "Document") && holds(&folder.read("s.png"), "Seed"));
    folder.run("swatches t.png -q --size 96 --seed 99 --strip").fine();
    assert!(folder.read("s.png") != folder.read("t.png"));
    assert!(!holds(&folder.read("t.png"), "Document"));
}

#[test]
fn a_document_is_painted_at_any_scale() {
    let folder = Folder::new();
    folder.write("doc.toml", "format = 1\ntitle = \"Bare\"\n[sheet]\nsize = [10, 6]\npixels_per_mm = 4\n");
    folder.run("paint doc.toml out.png -q").fine();
    assert_eq!(png_size(&folder.read("out.png")), (40, 24));
    folder.run("paint doc.toml twice.png -q --scale 2").fine();
    assert_eq!(png_size(&folder.read("twice.png")), (80, 48));
    let plan = folder.run("paint doc.toml none.png --dry-run").fine().text();
    assert!(plan.contains("40 × 24") && plan.contains(" s\n") && !folder.has("none.png"), "{plan}");
}

#[test]
fn completions_know_every_verb() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let text = run(&format!("completions {shell}")).text();
        for verb in VERBS {
            assert!(text.contains(verb), "{shell}: {verb}");
        }
        assert!(text.contains("viscosity"), "{shell}");
    }
}

#[test]
fn every_verb_has_a_man_page() {
    let folder = Folder::new();
    folder.run("man pages").fine();
    let page = |name: &str| String::from_utf8(folder.read(&format!("pages/{name}.1"))).unwrap();
    for verb in VERBS {
        let text = page(&format!("girtin-{verb}"));
        assert!(text.starts_with(".ie") || text.contains(".TH"), "{verb}");
        assert!(text.contains("Examples"), "{verb}");
        // roff writes a dash as `\-`.
        assert!(page("girtin").contains(&format!("girtin\\-{verb}(1)")), "{verb}");
    }
    // As in the help: options, then inputs and outputs in their order.
    for (verb, usage) in [
        ("girtin", "girtin <COMMAND>"),
        ("girtin-paint", "girtin paint [OPTIONS] <DOC> [OUT]"),
        ("girtin-effects", "girtin effects [OPTIONS] <OUT_DIR>"),
        ("girtin-wash", "girtin wash [OPTIONS] --state <FILE> --steps <N>"),
        ("girtin-bench-wash", "girtin bench wash [OPTIONS]"),
    ] {
        let text = page(verb).replace("\\fB", "").replace("\\fR", "").replace("\\-", "-");
        let after = text.split_once(".SH SYNOPSIS\n").unwrap().1;
        assert_eq!(after.lines().next().unwrap(), usage, "{verb}");
    }
    folder.fails("man pages", 5);
    folder.run("man pages --overwrite").fine();
}

#[test]
fn every_help_has_two_examples() {
    let help = run("--help").text();
    for verb in VERBS {
        assert!(help.contains(&format!("\n  {verb} ")), "{verb}");
        let text = run(&format!("{verb} --help")).text();
        let examples = text.lines().filter(|line| line.starts_with(&format!("  girtin {verb}"))).count();
        assert!(text.contains("Examples:") && examples >= 2, "{text}");
    }
    assert_eq!(run("--version").text(), concat!("girtin ", env!("CARGO_PKG_VERSION"), "\n"));
}

#[test]
fn the_wash_is_measured() {
    let told = run("bench wash --quick --json -q").json();
    let dense = told["dense"].as_array().unwrap();
    assert_eq!(dense.len(), 16, "two sizes, four washes, one thread and two");
    for row in dense {
        let (step, copy) = (row["step_ms"].as_f64().unwrap(), row["copy_ms"].as_f64().unwrap());
        assert!((row["ratio"].as_f64().unwrap() - step / copy).abs() < 1e-9);
        assert!(row["max_speed"].as_f64().unwrap() <= 1.0, "one sub-step a step");
    }
}

#[test]
fn a_reader_that_leaves_is_no_failure() {
    let folder = Folder::new();
    let mut command = folder.command("pigments --json");
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(output.stderr.is_empty());
}
