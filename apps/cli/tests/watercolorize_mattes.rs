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
