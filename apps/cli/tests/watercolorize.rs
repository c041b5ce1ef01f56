//! What comes out when a photograph is painted.

mod common;

use std::fs;
use std::io::{BufRead, BufReader, Cursor, Read};
use std::process::Stdio;

use common::{Folder, Ran, holds, photo, picture_file, png_size};
use image::{AnimationDecoder, DynamicImage, ImageFormat, RgbImage};

/// Two small washes: all that a test of outputs needs.
const QUICK: &str = "--set plan-cells=72 --palette sepia,cerulean-blue,quinacridone-rose --washes 2";

fn studio() -> Folder {
    let folder = Folder::new();
    folder.write("photo.png", picture_file(photo(48, 32), ImageFormat::Png));
    folder
}

fn paint(folder: &Folder, line: &str) -> Ran {
    folder.run(&format!("watercolorize {line} {QUICK}"))
}

fn decoded(bytes: &[u8]) -> DynamicImage {
    image::load_from_memory(bytes).unwrap()
}

#[test]
fn nothing_need_be_said() {
    let folder = studio();
    let before = folder.read("photo.png");
    folder.run("watercolorize photo.png painting.png").fine();
    let painting = folder.read("painting.png");
    // A margin of a twentieth of the long edge on each side.
    let (width, height) = png_size(&painting);
    assert!((52..=54).contains(&width) && (36..=38).contains(&height), "{width} × {height}");
    for word in ["Software", "girtin ", "Seed", "Document", "pHYs", "sRGB"] {
        assert!(holds(&painting, word), "{word}");
    }
    assert!(!holds(&painting, "photo"), "no name of a file");
    assert!(folder.read("photo.png") == before);
    let picture = decoded(&painting).to_rgb8();
    let corner = picture.get_pixel(0, 0).0;
    assert!(corner.iter().all(|&value| value > 225), "bare paper: {corner:?}");
    let sky = picture.get_pixel(10, 8).0;
    assert!(sky[2] > sky[0], "{sky:?}");
    let seen: std::collections::BTreeSet<_> = picture.pixels().map(|pixel| pixel.0).collect();
    assert!(seen.len() > 300, "grain");
}

#[test]
fn without_a_margin_it_is_exactly_the_photograph_s_size() {
    for (width, height) in [(48, 32), (31, 64), (1, 1), (3, 90)] {
        let folder = Folder::new();
        folder.write("p.png", picture_file(photo(width, height), ImageFormat::Png));
        paint(&folder, "p.png out.png --margin 0").fine();
        assert_eq!(png_size(&folder.read("out.png")), (width, height));
    }
    let folder = studio();
    paint(&folder, "photo.png out.png --margin 0 --size 100").fine();
    assert_eq!(png_size(&folder.read("out.png")), (100, 67));
    paint(&folder, "photo.png taped.png --border taped --margin 0.25 --sheet 12in").fine();
    let picture = decoded(&folder.read("taped.png")).to_rgb8();
    assert_eq!(picture.dimensions(), (72, 56));
    assert!(picture.get_pixel(10, 28).0[0] > 225 && picture.get_pixel(15, 50).0[0] > 225);
}

#[test]
fn threads_and_seeds() {
    let folder = studio();
    for threads in [1, 2, 7] {
        paint(&folder, &format!("photo.png {threads}.png --threads {threads}")).fine();
        assert!(folder.read("1.png") == folder.read(&format!("{threads}.png")), "{threads} threads");
    }
    paint(&folder, "photo.png other.png --seed 2").fine();
    assert!(folder.read("1.png") != folder.read("other.png"));
    paint(&folder, "photo.png plain.png --strip").fine();
    assert!(!holds(&folder.read("plain.png"), "Seed"));
}

#[test]
fn what_is_saved_paints_the_same_bytes() {
    let folder = studio();
    folder.write("mud.toml", {
        let umber = girtin::optics::Library::builtin().get("burnt-umber").unwrap().to_toml();
        umber.replace("burnt-umber", "mud")
    });
    let line = "photo.png a.png --save a.girtin --pigment-file mud.toml --set ink=1 --seed 7 --sheet 30cm";
    folder.run(&format!("watercolorize {line} --set plan-cells=72 --palette mud,cerulean-blue")).fine();
    folder.run("paint a.girtin b.png -q").fine();
    assert!(folder.read("a.png") == folder.read("b.png"));
    let told = folder.run("inspect a.girtin --json").fine().json();
    assert!(told.to_string().contains("\"mud\""), "{told}");
    folder.run("paint a.girtin twice.png -q --scale 2").fine();
    let ((width, height), twice) = (png_size(&folder.read("a.png")), png_size(&folder.read("twice.png")));
    assert!(twice.0.abs_diff(2 * width) <= 1 && twice.1.abs_diff(2 * height) <= 1, "{twice:?}");
}

#[test]
fn every_format_holds_the_same_picture() {
    let folder = studio();
    paint(&folder, "photo.png a.png").fine();
    let wanted = decoded(&folder.read("a.png")).to_rgb8();
    let apart = |picture: &RgbImage| {
        let pairs = picture.as_raw().iter().zip(wanted.as_raw());
        pairs.map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / wanted.as_raw().len() as f64
    };
    for (name, options, most) in [
        ("a.jpg", "--quality 95", 4.0),
        ("a.TIFF", "", 0.0),
        ("a.webp", "", 0.0),
        ("deep.png", "--bits 16", 0.5),
        ("deep.tif", "--bits 16", 0.5),
    ] {
        paint(&folder, &format!("photo.png {name} {options}")).fine();
        let picture = decoded(&folder.read(name));
        let is_deep = matches!(picture, DynamicImage::ImageRgb16(_));
        assert_eq!(is_deep, options.contains("16"), "{name}");
        let far = apart(&picture.to_rgb8());
        assert!(far <= most, "{name}: {far}");
    }
    let small = |quality: u32| {
        paint(&folder, &format!("photo.png {quality}.jpg --quality {quality}")).fine();
        folder.read(&format!("{quality}.jpg")).len()
    };
    assert!(small(20) < small(90));
}

#[test]
fn pipes_go_in_and_out() {
    let folder = studio();
    paint(&folder, "photo.png a.png").fine();
    let piped = folder.run_with(&format!("watercolorize - - {QUICK}"), &folder.read("photo.png")).fine();
    assert!(piped.stdout == folder.read("a.png"));
    let piped = paint(&folder, "photo.png - --format webp").fine();
    assert_eq!(image::guess_format(&piped.stdout).unwrap(), ImageFormat::WebP);
    folder.run_with(&format!("watercolorize - {{stem}}.png {QUICK}"), &folder.read("photo.png")).fine();
    assert!(folder.has("painting.png"));
}

#[test]
fn json_tells_where_pigments_went() {
    let folder = studio();
    let told = paint(&folder, "photo.png a.png --json --seed 5").fine().json();
    assert_eq!((told["input"].as_str(), told["output"].as_str()), (Some("photo.png"), Some("a.png")));
    let (width, height) = png_size(&folder.read("a.png"));
    assert_eq!((told["width"].as_u64(), told["height"].as_u64()), (Some(width.into()), Some(height.into())));
    assert_eq!((told["preset"].as_str(), told["seed"].as_u64()), (Some("classic"), Some(5)));
    assert!(told["seconds"].as_f64().unwrap() > 0.0);
    let palette = told["palette"].as_array().unwrap();
    assert!(!palette.is_empty() && palette.iter().all(|id| QUICK.contains(id.as_str().unwrap())));
    for glaze in told["glazes"].as_array().unwrap() {
        let name = glaze["name"].as_str().unwrap();
        assert!(
            name.starts_with("wash")
                || ["pencil", "tones and texture", "accents", "knife and spatter"].contains(&name),
            "{name}"
        );
        for pigment in glaze["pigments"].as_array().unwrap() {
            let amount = |key: &str| pigment[key].as_f64().unwrap();
            let left = amount("laid") - amount("lifted");
            assert!((amount("total") - left).abs() <= 1e-5 * amount("laid").max(1.0), "{pigment}");
        }
    }
}

#[test]
fn a_dry_run_tells_and_does_nothing() {
    let folder = studio();
    let before = folder.files();
    let plan = paint(&folder, "photo.png a.png --dry-run --layers a.ora --stages st").fine().text();
    for word in ["48 × 32", "52 × 36", "a.png", "sepia, cerulean-blue", "memory", "time"] {
        assert!(plan.contains(word), "{word}: {plan}");
    }
    let told = paint(&folder, "photo.png a.png --dry-run --json").fine().json();
    assert_eq!(told["parameters"]["plan_cells"], 72);
    assert!(told["memory_bytes"].as_u64().unwrap() > 1_000_000);
    assert!(folder.files() == before && !folder.has("st"));
}

#[test]
fn stages_are_the_painting_after_each_wash() {
    let folder = studio();
    paint(&folder, "photo.png a.png --stages st").fine();
    let first = decoded(&folder.read("st/01-wash.png")).to_rgb8();
    let second = decoded(&folder.read("st/02-wash.png")).to_rgb8();
    let count = fs::read_dir(folder.path("st")).unwrap().count();
    // Two washes, the marks on them, and the palette.
    assert!((3..=5).contains(&count), "{count}");
    let last = decoded(&folder.read(&format!("st/{:02}-wash.png", count - 1))).to_rgb8();
    assert!(last == decoded(&folder.read("a.png")).to_rgb8());
    let light = |picture: &RgbImage| picture.as_raw().iter().map(|&value| u64::from(value)).sum::<u64>();
    assert!(light(&first) > light(&second), "washes darken");
    assert!(png_size(&folder.read("st/palette.png")).0 > 100);
}

/// Pixels of an entry of an archive.
fn entry(archive: &[u8], name: &str) -> DynamicImage {
    let mut archive = zip::ZipArchive::new(Cursor::new(archive)).unwrap();
    let mut bytes = Vec::new();
    archive.by_name(name).unwrap().read_to_end(&mut bytes).unwrap();
    decoded(&bytes)
}

#[test]
fn layers_put_together_are_the_painting() {
    let folder = studio();
    let ran = paint(&folder, "photo.png a.png --layers a.ora");
    assert_eq!(ran.code, 0);
    assert!(ran.stderr.contains("differ from the painting by"), "{}", ran.stderr);
    let ora = folder.read("a.ora");
    let mut archive = zip::ZipArchive::new(Cursor::new(&ora)).unwrap();
    let mut stack = String::new();
    archive.by_name("stack.xml").unwrap().read_to_string(&mut stack).unwrap();
    let layers: Vec<&str> = stack.lines().filter(|line| line.contains("<layer ")).collect();
    assert!((3..=5).contains(&layers.len()), "{stack}");
    let mut flat: Option<Vec<f64>> = None;
    // The highest layer is the first.
    for layer in layers.iter().rev() {
        let source = layer.split("src=\"").nth(1).unwrap().split('"').next().unwrap();
        let pixels = entry(&ora, source).to_rgba8();
        let is_multiply = layer.contains("svg:multiply");
        assert_eq!(is_multiply, flat.is_some(), "{layer}");
        let below = flat.unwrap_or_else(|| vec![1.0; 3 * pixels.pixels().len()]);
        let laid = pixels.pixels().zip(below.chunks(3)).flat_map(|(pixel, below)| {
            let alpha = f64::from(pixel.0[3]) / 255.0;
            let laid = |c: usize| {
                let own = f64::from(pixel.0[c]) / 255.0;
                let own = if is_multiply { own * below[c] } else { own };
                below[c] + alpha * (own - below[c])
            };
            [laid(0), laid(1), laid(2)]
        });
        flat = Some(laid.collect());
    }
    let painting = decoded(&folder.read("a.png")).to_rgb8();
    assert!(entry(&ora, "mergedimage.png").to_rgb8() == painting);
    let (flat, mut sum) = (flat.unwrap(), 0.0);
    for (laid, wanted) in flat.iter().zip(painting.as_raw()) {
        sum += (laid * 255.0 - f64::from(*wanted)).abs();
    }
    let mean = sum / flat.len() as f64;
    assert!(mean < 0.5, "{mean}");
}

#[test]
fn films_begin_with_the_sheet_and_end_with_the_painting() {
    let folder = studio();
    paint(&folder, "photo.png a.png --timelapse film.gif").fine();
    paint(&folder, "photo.png b.png --timelapse film.png").fine();
    let painting = decoded(&folder.read("a.png")).to_rgba8();
    let film = folder.read("film.png");
    let decoder = image::codecs::png::PngDecoder::new(Cursor::new(&film)).unwrap();
    let frames = decoder.apng().unwrap().into_frames().collect_frames().unwrap();
    assert!(frames.len() > 20, "{}", frames.len());
    assert!(frames.last().unwrap().buffer() == &painting);
    let bare = frames[0].buffer();
    assert!(bare.pixels().all(|pixel| pixel.0[..3].iter().all(|&value| value > 200)), "bare paper");
    let film = folder.read("film.gif");
    let decoder = image::codecs::gif::GifDecoder::new(Cursor::new(&film)).unwrap();
    let gif = decoder.into_frames().collect_frames().unwrap();
    assert_eq!(gif.len(), frames.len());
    let last = gif.last().unwrap().buffer();
    let far = last.pixels().zip(painting.pixels()).map(|(a, b)| f64::from(a.0[0].abs_diff(b.0[0])));
    assert!(far.sum::<f64>() / f64::from(last.width() * last.height()) < 6.0);
}

#[cfg(unix)]
#[test]
fn mp4_goes_through_ffmpeg_or_says_what_it_is_instead() {
    use std::os::unix::fs::PermissionsExt;
    let folder = studio();
    fs::create_dir(folder.path("bin")).unwrap();
    let run = |line: &str| {
        let mut command = folder.command(&format!("watercolorize {line} {QUICK}"));
        let output = command.env("PATH", folder.path("bin")).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let (code, said) = run("photo.png a.png --timelapse a.mp4");
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("ffmpeg is not installed") && said.contains("a.timelapse.png"), "{said}");
    assert!(!folder.has("a.mp4") && folder.read("a.timelapse.png").starts_with(b"\x89PNG"));
    // One that keeps what it is sent: the last word is the file.
    let program = "#!/bin/sh\n[ \"$1\" = -version ] && exit 0\nfor last; do :; done\n/bin/cat > \"$last\"\n";
    folder.write("bin/ffmpeg", program);
    fs::set_permissions(folder.path("bin/ffmpeg"), fs::Permissions::from_mode(0o755)).unwrap();
    let (code, said) = run("photo.png b.png --timelapse b.mp4");
    assert_eq!((code, said.as_str()), (Some(0), ""));
    let (width, height) = png_size(&folder.read("b.png"));
    let frame = 3 * (width * height) as usize;
    let film = folder.read("b.mp4");
    assert!(film.len() > 20 * frame && film.len().is_multiple_of(frame));
    let painting = decoded(&folder.read("b.png")).to_rgb8();
    assert!(film[film.len() - frame..] == painting.as_raw()[..]);
    folder
        .write("bin/ffmpeg", "#!/bin/sh\n[ \"$1\" = -version ] && exit 0\necho no such codec >&2\nexit 1\n");
    let (code, said) = run("photo.png c.png --timelapse c.mp4");
    assert_eq!(code, Some(1));
    assert!(said.contains("no such codec") && !folder.has("c.mp4") && !folder.has("c.png"), "{said}");
}

#[test]
fn presets_palettes_and_parameters() {
    let folder = studio();
    folder.write("own.toml", "palette = [\"sepia\"]\npaper = \"rough\"\nwashes = 1\nplan_cells = 64\n");
    let told = folder.run("watercolorize photo.png a.png --preset own.toml --json").fine().json();
    assert_eq!((&told["palette"], &told["preset"]), (&serde_json::json!(["sepia"]), &"own.toml".into()));
    let washes = told["glazes"].as_array().unwrap().iter().filter(|glaze| glaze["name"] == "wash 1");
    assert_eq!(washes.count(), 1);
    assert!(!told["glazes"].as_array().unwrap().iter().any(|glaze| glaze["name"] == "wash 2"));
    let mud = girtin::optics::Library::builtin().get("burnt-umber").unwrap().to_toml();
    let mud = mud.replace("burnt-umber", "mud").replace("[linear]", "[pigment.linear]");
    folder.write("two.toml", format!("pigments = [\"mud\", \"viridian\"]\n[[pigment]]\n{mud}"));
    let line = "watercolorize photo.png b.png --palette two.toml --set plan-cells=64 --washes 1 --json";
    let told = folder.run(line).fine().json();
    assert!(told["palette"].as_array().unwrap().contains(&"mud".into()), "{told}");
    let plan = |options: &str| {
        let line = format!("watercolorize photo.png no.png --dry-run --json {options}");
        folder.run(&line).fine().json()["parameters"].clone()
    };
    assert_eq!(plan("--preset loose --washes 2 --wetness 2")["washes"], 2);
    assert_eq!(plan("--set lost-edges=2 --set ink=0.5")["lost_edges"], 2.0);
    let cells = |options: &str| plan(options)["plan_cells"].as_u64().unwrap();
    assert!(cells("--detail low") < cells("") && cells("") < cells("--detail high"));
}

#[test]
fn every_preset_is_on_a_contact_sheet() {
    let folder = studio();
    let line = "watercolorize photo.png sheet.png --contact-sheet --set plan-cells=64 --size 40 --json";
    let told = folder.run(line).fine().json();
    let paintings = told["paintings"].as_array().unwrap();
    let presets: Vec<&str> = paintings.iter().map(|painting| painting["preset"].as_str().unwrap()).collect();
    assert_eq!(
        presets,
        ["classic", "loose", "wet-in-wet", "detailed", "urban", "botanical", "monochrome", "nocturne"]
    );
    let (width, height) = png_size(&folder.read("sheet.png"));
    assert!(width > 2 * 40 && height > 2 * 27, "{width} × {height}");
    paint(&folder, "photo.png small.png --preview").fine();
    assert!(png_size(&folder.read("small.png")).0 <= 54);
}

#[test]
fn masks_keep_paper_and_detail() {
    let folder = studio();
    let left = |width: u32, height: u32| {
        image::GrayImage::from_fn(width, height, |x, _| image::Luma([255 * u8::from(x < width / 2)]))
    };
    folder.write("left.png", picture_file(left(96, 64), ImageFormat::Png));
    paint(&folder, "photo.png a.png --margin 0 --reserve left.png").fine();
    let picture = decoded(&folder.read("a.png")).to_rgb8();
    let mean = |from: u32| {
        let pixels = (from..from + 16).flat_map(|x| (0..32).map(move |y| (x, y)));
        pixels.map(|(x, y)| f64::from(picture.get_pixel(x, y).0[0])).sum::<f64>() / (16.0 * 32.0)
    };
    assert!(mean(2) > 230.0 && mean(30) < 220.0, "{} {}", mean(2), mean(30));
    paint(&folder, "photo.png b.png --margin 0 --detail-map left.png").fine();
    paint(&folder, "photo.png c.png --margin 0").fine();
    assert!(folder.read("b.png") != folder.read("c.png"));
}

#[test]
fn progress_names_its_stages() {
    let folder = studio();
    let ran = paint(&folder, "photo.png a.png --stages st --timelapse a.gif --save a.girtin --progress json");
    assert_eq!(ran.code, 0);
    let lines: Vec<serde_json::Value> =
        ran.stderr.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let stages: Vec<&str> = lines.iter().map(|line| line["stage"].as_str().unwrap()).collect();
    assert!(stages.contains(&"washes run and dry") && stages.contains(&"writing the picture"), "{stages:?}");
    let parts: Vec<f64> = lines.iter().map(|line| line["fraction"].as_f64().unwrap()).collect();
    assert!(parts.iter().all(|part| (0.0..=1.0).contains(part)) && parts.is_sorted(), "{parts:?}");
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_nothing() {
    let folder = studio();
    let line =
        "watercolorize photo.png a.png --stages st --save a.girtin --set plan-cells=900 --progress json";
    let mut child = folder.command(line).stderr(Stdio::piped()).spawn().unwrap();
    let mut said = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    while !line.contains("choosing pigments") && said.read_line(&mut line).unwrap() > 0 {}
    let status = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(status.unwrap().success());
    let mut rest = String::new();
    said.read_to_string(&mut rest).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{rest}");
    assert!(rest.contains("girtin: error: interrupted"), "{rest}");
    assert_eq!(folder.files().len(), 1);
    assert!(!folder.has("st"));
}

#[test]
fn a_plan_lists_all_that_is_written_and_a_named_folder_is_made() {
    let folder = studio();
    let before = folder.files();
    let line = "photo.png new/{stem}.png --save new/{stem}.girtin --layers a.ora --timelapse a.gif --stages new/{stem}";
    let plan = paint(&folder, &format!("{line} --dry-run")).fine().text();
    for said in [
        "picture: new/photo.png",
        "save: new/photo.girtin",
        "layers: a.ora",
        "timelapse: a.gif",
        "stages: new/photo/01-wash.png, new/photo/02-wash.png, new/photo/03-wash.png, new/photo/04-wash.png, new/photo/05-wash.png, new/photo/06-wash.png, new/photo/palette.png",
    ] {
        assert!(plan.contains(said), "{said} in {plan}");
    }
    let told = paint(&folder, &format!("{line} --dry-run --json")).fine().json();
    assert_eq!(told["more"]["layers"][0], "a.ora");
    assert!(folder.files() == before && !folder.has("new"), "a plan makes nothing");
    let ran = paint(&folder, line);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    for name in ["new/photo.png", "new/photo.girtin", "new/photo/palette.png", "a.ora", "a.gif"] {
        assert!(folder.has(name), "{name}");
    }
}

#[test]
fn a_forgotten_output_is_no_advice_to_replace_a_photograph() {
    let folder = studio();
    folder.write("second.png", picture_file(photo(48, 32), ImageFormat::Png));
    let before = folder.read("second.png");
    let (said, hint) = folder.fails("watercolorize photo.png second.png", 5);
    let told = format!("{said} {hint}");
    assert!(told.contains("the last name is where the painting goes"), "{told}");
    assert!(folder.read("second.png") == before);
}
