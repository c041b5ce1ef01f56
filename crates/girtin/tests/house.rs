//! The house stands as ARCHITECTURE.md says: arrows point down only, and heavy things stay out of the lower rooms.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

/// What each crate may depend on among Girtin's own, from the ground up.
const HOUSE: [(&str, &[&str]); 9] = [
    ("girtin-grid", &[]),
    ("girtin-params", &[]),
    ("girtin-optics", &["girtin-grid", "girtin-params"]),
    ("girtin-paper", &["girtin-grid", "girtin-params"]),
    ("girtin-wash", &["girtin-grid", "girtin-params"]),
    ("girtin-painting", &["girtin-grid", "girtin-params", "girtin-optics", "girtin-paper", "girtin-wash"]),
    (
        "girtin-watercolorize",
        &["girtin-grid", "girtin-params", "girtin-optics", "girtin-paper", "girtin-wash", "girtin-painting"],
    ),
    (
        "girtin",
        &[
            "girtin-grid",
            "girtin-params",
            "girtin-optics",
            "girtin-paper",
            "girtin-wash",
            "girtin-painting",
            "girtin-watercolorize",
        ],
    ),
    ("girtin-cli", &["girtin"]),
];

/// Crates that may read and write files, and so know codecs.
const MAY_KNOW_FILES: [&str; 3] = ["girtin-painting", "girtin", "girtin-cli"];

/// Codecs, servers, graphics drivers and command lines, which the lower rooms must not know.
const HEAVY: [&str; 19] = [
    "image",
    "png",
    "zip",
    "exr",
    "tiff",
    "gif",
    "flate2",
    "zune-jpeg",
    "moxcms",
    "kamadak-exif",
    "gltf",
    "wgpu",
    "axum",
    "tokio",
    "clap",
    "miette",
    "indicatif",
    "serde_json",
    "tempfile",
];

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// The direct dependencies of every crate of the workspace, those for tests apart.
fn dependencies() -> BTreeMap<String, Vec<String>> {
    let output = Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--no-deps", "--offline"])
        .current_dir(root())
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    let of = |package: &serde_json::Value| {
        let all = package["dependencies"].as_array().unwrap().iter();
        all.filter(|d| d["kind"] != "dev").map(|d| d["name"].as_str().unwrap().to_owned()).collect()
    };
    packages.iter().map(|package| (package["name"].as_str().unwrap().to_owned(), of(package))).collect()
}

#[test]
fn arrows_point_down_only() {
    let found = dependencies();
    let known: Vec<&str> = HOUSE.iter().map(|(name, _)| *name).collect();
    assert!(
        found.keys().map(String::as_str).all(|name| known.contains(&name)),
        "a crate is not in the table"
    );
    for (name, allowed) in HOUSE {
        let own = found[name].iter().filter(|dependency| dependency.starts_with("girtin"));
        for dependency in own {
            assert!(allowed.contains(&dependency.as_str()), "{name} depends on {dependency}");
        }
    }
}

#[test]
fn lower_rooms_know_no_codec_and_no_driver() {
    for (name, dependencies) in dependencies() {
        if !MAY_KNOW_FILES.contains(&name.as_str()) {
            for dependency in dependencies {
                assert!(!HEAVY.contains(&dependency.as_str()), "{name} depends on {dependency}");
            }
        }
    }
}

#[test]
fn unsafe_code_is_forbidden_in_every_crate() {
    for (name, _) in HOUSE {
        let folder = match name {
            "girtin" => "crates/girtin".to_owned(),
            "girtin-cli" => "apps/cli".to_owned(),
            other => format!("crates/{}", other.trim_start_matches("girtin-")),
        };
        let main = ["src/lib.rs", "src/main.rs"].map(|file| root().join(&folder).join(file));
        let main = main.iter().find(|path| path.exists()).unwrap();
        assert!(std::fs::read_to_string(main).unwrap().contains("#![forbid(unsafe_code)]"), "{name}");
    }
}

#[test]
fn every_crate_can_be_packed_alone() {
    // What is embedded lies in the crate's own folder, if only by a link: packing follows links, but not `../..`.
    let mut folders = vec![root().join("crates"), root().join("apps")];
    let mut seen = 0;
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() && !path.is_symlink() && !path.ends_with("tests") {
                folders.push(path);
            } else if path.extension().is_some_and(|ending| ending == "rs") {
                let text = std::fs::read_to_string(&path).unwrap();
                let includes = text.split("include_").skip(1).map(|after| after.lines().next().unwrap());
                for include in includes.filter(|line| line.starts_with("str!") || line.starts_with("bytes!"))
                {
                    assert!(!include.contains("../.."), "{}: {include}", path.display());
                    seen += 1;
                }
            }
        }
    }
    assert!(seen > 0);
    for (link, folder) in [("optics", "pigments"), ("paper", "papers"), ("painting", "gallery")] {
        let link = root().join("crates").join(link).join("assets");
        let folder = root().join("assets").join(folder);
        assert_eq!(link.canonicalize().unwrap(), folder.canonicalize().unwrap());
    }
}

#[test]
fn the_table_of_parameters_is_current() {
    use girtin::params::manual::markdown;
    use girtin::params::row::Parameters;
    use girtin::wash::{C97Params, Capillary, LivingParams};
    use girtin::watercolorize::PhotoParams;
    use girtin::watercolorize::c97::{PlanningParams, SeparationParams};
    use girtin::watercolorize::mattes::MattesParams;

    let page = format!(
        "# Parameters\n\nGenerated from the rows in the code; `GIRTIN_WRITE_GOLDENS=1 cargo test -p girtin --test house` \
         writes it anew.\n\n## Wash, model `living`\n\nKeys of `[living]` in `wash.toml`, of `[glaze.wash.living]` in \
         documents, and with `--living-` before them of `girtin wash`. Lengths are millimetres of paper, times reference \
         steps, film is the depth of water that C97 calls pressure; the symbol is the name in \
         `fidelity/wash/living.py`.\n\n{}\n## Wash, model `c97`\n\nKeys of `wash.toml` and of `[glaze.wash]`.\n\n{}\n\
         ## Capillary layer\n\nKeys of `[capillary]`; the layer is on when the table is there.\n\n{}\n\
         ## Photographs\n\nKeys of a preset's file, and of `--set` of `girtin watercolorize`.\n\n{}\n\
         ## Mattes\n\nKeys of `--set` of `girtin mattes`.\n\n{}\n\
         ## Glazes from mattes\n\nKeys of a file of glazes, and of `[matte.planning]` in it.\n\n{}\n{}",
        markdown(LivingParams::ROWS),
        markdown(C97Params::ROWS),
        markdown(Capillary::ROWS),
        markdown(PhotoParams::ROWS),
        markdown(MattesParams::ROWS),
        markdown(SeparationParams::ROWS),
        markdown(PlanningParams::ROWS),
    );
    let path = root().join("docs/parameters.md");
    if std::env::var_os("GIRTIN_WRITE_GOLDENS").is_some() {
        std::fs::write(&path, &page).unwrap();
    }
    assert!(std::fs::read_to_string(path).unwrap() == page, "docs/parameters.md is not what the rows say");
}
