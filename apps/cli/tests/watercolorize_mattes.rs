//! The method of Curtis et al. 1997, §6.2, from the command line: mattes, and pigments in order.

mod common;

use std::fs;

use common::{Folder, photo, picture_file};
use image::{GrayImage, ImageFormat, Luma};

const GLAZES: &str = "format = 1
steps = 6
[[matte]]
name = \"sky\"
pigments = [\"cerulean-blue\"]
[matte.planning]
interval = 10
repeats = 1
[[matte]]
name = \"hill\"
pigments = [\"raw-sienna\", \"viridian\"]
[matte.planning]
interval = 10
repeats = 1
";

const LINE: &str = "watercolorize photo.png out.png --mattes mattes --glazes glazes.toml --set plan-cells=64";

fn gray(width: u32, height: u32, is_white: impl Fn(u32, u32) -> bool) -> Vec<u8> {
    let picture = GrayImage::from_fn(width, height, |x, y| Luma([255 * u8::from(is_white(x, y))]));
    picture_file(picture, ImageFormat::Png)
}

fn studio() -> Folder {
    let folder = Folder::new();
    fs::create_dir(folder.path("mattes")).unwrap();
    folder.write("photo.png", picture_file(photo(48, 32), ImageFormat::Png));
    folder.write("mattes/sky.png", gray(48, 32, |_, y| y < 20));
    folder.write("mattes/hill.png", gray(48, 32, |_, y| y >= 20));
    folder.write("light.png", gray(48, 32, |x, y| x < 10 && y < 10));
    folder.write("glazes.toml", GLAZES);
    folder
}

#[test]
fn each_matte_is_painted_with_its_pigments() {
    let folder = studio();
    let line = format!("{LINE} --margin 0 --json --targets targets --save out.girtin");
    let told = folder.run(&line).fine().json();
    let glazes = told["glazes"].as_array().unwrap();
    let pigments = glazes.iter().map(|glaze| glaze["pigments"][0]["name"].as_str().unwrap());
    let pigments: Vec<&str> = pigments.collect();
    assert_eq!(pigments, ["cerulean-blue", "raw-sienna", "viridian"]);
    let picture = image::load_from_memory(&folder.read("out.png")).unwrap().to_rgb8();
    assert_eq!(picture.dimensions(), (48, 32));
    let (sky, hill) = (picture.get_pixel(8, 8).0, picture.get_pixel(24, 28).0);
    assert!(sky[2] > sky[0] && hill[2] < hill[1], "{sky:?} {hill:?}");
    for name in ["sky-cerulean-blue", "hill-raw-sienna", "hill-viridian"] {
        let target = image::load_from_memory(&folder.read(&format!("targets/{name}.png"))).unwrap();
        assert!(matches!(target, image::DynamicImage::ImageLuma16(_)), "{name}");
    }
    folder.run("paint out.girtin again.png -q").fine();
    assert!(folder.read("again.png") == folder.read("out.png"));
    // Highlights are lifted.
    folder.run(&format!("{LINE} --margin 0 --lift light.png --overwrite")).fine();
    let lifted = image::load_from_memory(&folder.read("out.png")).unwrap().to_rgb8();
    let light =
        |picture: &image::RgbImage, x, y| picture.get_pixel(x, y).0.map(u32::from).iter().sum::<u32>();
    assert!(light(&lifted, 4, 4) > light(&picture, 4, 4) + 10);
    assert!(light(&lifted, 40, 28).abs_diff(light(&picture, 40, 28)) < 10);
    let plan = folder.run(&format!("{LINE} --overwrite --dry-run")).fine().text();
    assert!(plan.contains("hill: raw-sienna, viridian"), "{plan}");
}

#[test]
fn what_is_wrong_with_mattes_is_said() {
    let folder = studio();
    folder.write("unknown.toml", GLAZES.replace("\"hill\"", "\"hil\""));
    folder.write("pigment.toml", GLAZES.replace("viridian", "virdian"));
    for (line, code, said) in [
        (LINE.replace("glazes.toml", "unknown.toml"), 4, "has no matte `hil`"),
        (LINE.replace("glazes.toml", "pigment.toml"), 4, "no pigment is called `virdian`"),
        (LINE.replace("--mattes mattes", "--mattes nowhere"), 4, "cannot read `nowhere`"),
        (LINE.replace(" --glazes glazes.toml", ""), 2, "--glazes"),
        (format!("{LINE} --palette sepia"), 2, "cannot be used with"),
        (format!("{LINE} --lift nowhere.png"), 4, "nowhere.png"),
        (LINE.replace("out.png", "mattes/sky.png"), 2, "is an input"),
    ] {
        let (cause, _) = folder.fails(&line, code);
        assert!(cause.contains(said), "{line}: {cause}");
    }
    folder.write("mattes/hill.png", gray(32, 32, |_, _| true));
    let (cause, _) = folder.fails(LINE, 4);
    assert!(cause.contains("32 × 32"), "{cause}");
    folder.write("mattes/hill.png", gray(48, 32, |_, _| false));
    let (cause, _) = folder.fails(LINE, 4);
    assert!(cause.contains("matte `hill` is empty"), "{cause}");
}

#[test]
fn mattes_of_a_photograph_are_its_parts() {
    let folder = studio();
    let told = folder.run("mattes photo.png found --json --regions 4").fine().json();
    let names: Vec<&str> = told.as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect();
    assert!((2..=4).contains(&names.len()), "{names:?}");
    let mattes = names
        .iter()
        .map(|name| image::load_from_memory(&folder.read(&format!("found/{name}.png"))).unwrap().to_luma8());
    let mattes: Vec<GrayImage> = mattes.collect();
    for (x, y) in [(3, 3), (24, 28), (34, 10), (47, 31)] {
        let sum: u32 = mattes.iter().map(|matte| u32::from(matte.get_pixel(x, y).0[0])).sum();
        assert!(sum.abs_diff(255) <= 4, "{x}, {y}: {sum}");
    }
    folder.fails("mattes photo.png found --regions 4", 5);
    folder.run("mattes photo.png found --regions 4 --skip-existing").fine();
    folder.fails("mattes photo.png out --set regins=3", 2);
    folder.fails("mattes nowhere.png out", 4);
    folder.fails("mattes glazes.toml out", 4);
    assert!(!folder.has("out"));
}

#[test]
fn mattes_of_another_run_do_not_stay_among_these() {
    let folder = studio();
    let names = |line: &str| -> Vec<String> {
        let told = folder.run(line).fine().json();
        told.as_array().unwrap().iter().map(|name| name.as_str().unwrap().to_owned()).collect()
    };
    let many = names("mattes photo.png found --json --regions 4");
    assert!(many[0].starts_with("01-") && many[0].matches('-').count() >= 2, "{many:?}");
    folder.write("found/notes.png", "mine").write("found/07-mine.png", "mine");
    // What somebody worked on is not of the run any more.
    let edited = format!("found/{}.png", many[1]);
    let matte = image::load_from_memory(&folder.read(&edited)).unwrap();
    folder.write(&edited, picture_file(matte, ImageFormat::Png));
    let line = "mattes photo.png found --json --regions 1";
    if many[0] != "01-middle-white" {
        let ran = folder.run(line);
        assert_eq!(ran.code, 5, "{}", ran.stderr);
    }
    let ran = folder.run(&format!("{line} --overwrite"));
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    assert!(ran.stderr.contains("07-mine.png") && ran.stderr.contains(&many[1]), "{}", ran.stderr);
    assert!(!ran.stderr.contains("notes"), "{}", ran.stderr);
    let left = |name: &str| folder.has(&format!("found/{name}.png"));
    assert!(left("notes") && left("07-mine") && left(&many[1]), "nothing of the user's is lost");
    let fresh = ran.json();
    assert!(many[2..].iter().all(|name| !left(name)), "{many:?}");
    assert!(left(fresh[0].as_str().unwrap()));
}

#[test]
fn mattes_that_nothing_is_painted_from_are_said() {
    let folder = studio();
    folder.write("mattes/spare.png", gray(48, 32, |_, _| true));
    folder.write("mattes/light.png", gray(48, 32, |x, y| x < 10 && y < 10));
    let ran = folder.run(&format!("{LINE} --margin 0 --json --lift mattes/light.png"));
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let said: Vec<&str> = ran.stderr.lines().filter(|line| line.contains("is not painted")).collect();
    assert!(said.len() == 1 && said[0].contains("spare.png"), "{said:?}");
    assert_eq!(ran.json()["unused_mattes"].as_array().unwrap().len(), 1);
    assert!(
        folder.run(&format!("{LINE} -q --overwrite --dry-run --lift mattes/light.png")).stderr.is_empty()
    );
    // A colored picture is no matte, and a plan says so.
    folder.write("mattes/hill.png", picture_file(photo(48, 32), ImageFormat::Png));
    for options in ["", "--dry-run"] {
        let ran = folder.run(&format!("{LINE} --overwrite {options}"));
        assert!(ran.code == 4 && ran.stderr.contains("not a mask"), "{}", ran.stderr);
    }
}
