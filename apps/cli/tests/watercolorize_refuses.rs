//! Photographs that are not painted, and why; and what happens to the others.

mod common;

use std::fs;

use common::{Folder, Ran, photo, picture_file, png_size, read_only_folder, skip};
use image::ImageFormat;

const QUICK: &str = "--set plan-cells=64 --palette sepia --washes 1";

fn studio() -> Folder {
    let folder = Folder::new();
    folder.write("photo.png", picture_file(photo(24, 16), ImageFormat::Png));
    folder
}

fn paint(folder: &Folder, line: &str) -> Ran {
    folder.run(&format!("watercolorize {line} {QUICK}"))
}

#[test]
fn the_command_line_is_checked_before_the_work() {
    let folder = studio();
    folder.write("there.png", b"mine");
    for (line, code, said) in [
        ("photo.png out.gif", 2, "gif is no format"),
        ("photo.png out", 2, "does not say which format"),
        ("photo.png out.jpg --bits 16", 2, "16 bits"),
        ("photo.png out.png --bits 12", 2, "8 or 16 bits"),
        ("photo.png out.png --quality 80", 2, "JPEG's"),
        ("photo.png out.png --preset lose", 2, "no preset is called `lose`"),
        ("photo.png out.png --set inkk=1", 2, "no parameter is called `inkk`"),
        ("photo.png out.png --set ink", 2, "has no value"),
        ("photo.png out.png --set ink=99", 2, "outside 0 to 3"),
        ("photo.png out.png --paper cold-pres", 2, "no paper is called"),
        ("photo.png out.png --sheet 3", 2, "with its unit"),
        ("photo.png out.png --size 3", 2, "16..=30000"),
        ("photo.png out.png --margin 2", 2, "from 0 to 0.5"),
        ("photo.png out.png --layers out.zip", 2, "does not end in .ora"),
        ("photo.png out.png --save out.png", 2, "does not end in .girtin"),
        ("photo.png out.png --timelapse out.avi", 2, "no film"),
        ("photo.png out.png --contact-sheet --layers out.ora", 2, "cannot be used with"),
        ("photo.png - --json", 2, "both go to the standard output"),
        ("photo.png photo.png", 2, "is an input"),
        ("photo.png there.png", 5, "exists"),
        ("photo.png missing/out.png", 1, "cannot write"),
        ("photo.png out.png --stages missing/stages", 1, "cannot write"),
        ("photo.png missing/", 1, "there is no folder"),
        ("photo.png out.png --memory 1MB", 1, "are needed"),
        ("photo.png out.png --sheet 10mm --size 5000 --save out.girtin", 2, "pixels a mm"),
        ("nowhere.png out.png", 4, "cannot read"),
        ("*.jpg out.png", 4, "no file matches"),
        ("photo.png out.png --reserve nowhere.png", 4, "cannot read"),
        ("photo.png {name}.png", 2, "`{name}` in `{name}.png` stands for nothing"),
        ("photo.png out.png --save {stem}/{seed}.girtin", 2, "`{seed}`"),
        ("photo.png out.png --reserve {photo}.png", 2, "`{photo}`"),
        ("photo.png deep/out/{stem}.png", 1, "cannot write"),
        ("- out.png --reserve -", 2, "only once"),
        ("photo.png out.png --reserve - --detail-map -", 2, "only once"),
        ("- out.png --pigment-file -", 2, "only once"),
    ] {
        let (cause, _) = folder.fails(&format!("watercolorize {line} {QUICK}"), code);
        assert!(cause.contains(said), "{line}: {cause}");
    }
    let (_, hint) = folder.fails("watercolorize photo.png out.png --palette sepai", 2);
    assert!(hint.contains("sepia"), "{hint}");
    let (cause, _) = folder.fails("watercolorize photo.png out.png --palette sepia,sepia", 2);
    assert!(cause.contains("twice"), "{cause}");
}

#[test]
fn a_colored_picture_is_no_mask() {
    let folder = studio();
    let (cause, hint) =
        folder.fails(&format!("watercolorize photo.png out.png --reserve photo.png {QUICK}"), 4);
    assert!(cause.contains("not a mask") && hint.contains("gray"), "{cause}: {hint}");
    // Gray that is stored as color is a mask.
    let gray = image::DynamicImage::from(photo(24, 16)).grayscale().to_rgb8();
    folder.write("gray.png", picture_file(gray, ImageFormat::Png));
    paint(&folder, "photo.png out.png --detail-map gray.png").fine();
}

/// A PNG's head that claims so many pixels a side, and nothing behind it.
fn only_a_head(side: u32) -> Vec<u8> {
    let mut bytes = b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR".to_vec();
    bytes.extend(side.to_be_bytes());
    bytes.extend(side.to_be_bytes());
    bytes.extend([8, 2, 0, 0, 0, 0, 0, 0, 0]);
    bytes
}

#[test]
fn claims_are_refused_with_an_option_that_helps() {
    let folder = studio();
    folder.write("large.png", only_a_head(12_000)).write("huge.png", only_a_head(0x7fff_ffff));
    for line in [
        "watercolorize large.png out.png",
        "mattes large.png out",
        "watercolorize large.png out.png --dry-run",
    ] {
        let (cause, hint) = folder.fails(line, 4);
        assert!(
            cause.contains("12000 × 12000") && hint.contains("--max-pixels 144000000"),
            "{cause}: {hint}"
        );
    }
    let (cause, _) = folder.fails("watercolorize large.png out.png --max-pixels 144000000", 4);
    assert!(!cause.contains("at most are read"), "{cause}");
    for line in ["watercolorize huge.png out.png", "mattes huge.png out"] {
        let (_, hint) = folder.fails(line, 4);
        assert!(!hint.contains("--max-pixels") && hint.contains("memory"), "{hint}");
    }
}

#[test]
fn half_a_photograph_does_not_look_fine_in_a_plan() {
    let folder = studio();
    let png = folder.read("photo.png");
    folder.write("cut.png", &png[..png.len() / 2]);
    let (cause, _) = folder.fails("watercolorize cut.png out.png --dry-run", 4);
    assert!(cause.contains("ends early"), "{cause}");
    let mut changed = png;
    changed[60] ^= 0xff;
    folder.write("changed.png", changed);
    let (cause, _) = folder.fails("watercolorize changed.png out.png", 4);
    assert!(!cause.contains("ChunkType") && !cause.contains("0x"), "{cause}");
    folder.fails(&format!("watercolorize photo.png out.png --dry-run --reserve photo.png {QUICK}"), 4);
    let sizes = "--sheet 10mm --size 5000 --save out.girtin --dry-run";
    folder.fails(&format!("watercolorize photo.png out.png {sizes}"), 2);
}

#[cfg(unix)]
#[test]
fn a_photograph_is_never_written_to() {
    let folder = studio();
    std::os::unix::fs::symlink("photo.png", folder.path("link.png")).unwrap();
    fs::hard_link(folder.path("photo.png"), folder.path("hard.png")).unwrap();
    for output in ["photo.png", "link.png", "hard.png", "./photo.png"] {
        let (cause, _) = folder.fails(&format!("watercolorize photo.png {output} --overwrite {QUICK}"), 2);
        assert!(cause.contains("is an input"), "{cause}");
    }
    let (cause, _) = folder.fails(&format!("watercolorize photo.png a.png --timelapse photo.png {QUICK}"), 2);
    assert!(cause.contains("is an input"), "{cause}");
}

#[test]
fn outputs_that_cannot_be_written_leave_nothing() {
    let folder = studio();
    if std::path::Path::new("/dev/full").exists() {
        for line in
            ["photo.png /dev/full", "photo.png a.png --layers /dev/full", "photo.png a.png --save /dev/full"]
        {
            let (cause, _) = folder.fails(&format!("watercolorize {line} {QUICK}"), 1);
            assert!(cause.contains("/dev/full"), "{cause}");
        }
    } else {
        skip("there is no /dev/full");
    }
    match read_only_folder(&folder) {
        Some(locked) => {
            let line = format!("watercolorize photo.png {}/out.png {QUICK}", locked.display());
            let ran = folder.run(&line);
            assert_eq!(ran.code, 1, "{}", ran.stderr);
        }
        None => skip("every folder can be written to"),
    }
}

#[test]
fn what_is_no_photograph_is_refused() {
    let folder = studio();
    let png = folder.read("photo.png");
    let jpeg = picture_file(photo(64, 64), ImageFormat::Jpeg);
    folder.write("empty.jpg", b"");
    folder.write("text.jpg", b"not a picture at all, but a letter");
    folder.write("cut.jpg", &jpeg[..jpeg.len() / 2]);
    folder.write("cut.png", &png[..png.len() - 20]);
    folder.write("photo.heic", b"\0\0\0\x18ftypheic\0\0\0\0mif1heic");
    fs::create_dir(folder.path("nothing")).unwrap();
    for (name, said) in [
        ("empty.jpg", "empty"),
        ("text.jpg", "no picture"),
        ("cut.jpg", "ends early"),
        ("cut.png", "ends early"),
        ("photo.heic", "HEIC"),
        ("nothing", "has no photographs"),
    ] {
        let (cause, _) = folder.fails(&format!("watercolorize {name} out.png {QUICK}"), 4);
        assert!(cause.contains(said), "{name}: {cause}");
    }
    let (cause, hint) = folder.fails(&format!("watercolorize photo.png out.png --max-pixels 100 {QUICK}"), 4);
    assert!(cause.contains("24 × 16") && hint.contains("--max-pixels 384"), "{cause} {hint}");
    paint(&folder, "photo.png out.png --max-pixels 384").fine();
}

#[test]
fn masks_fit_the_photograph() {
    let folder = studio();
    let grey = |width, height, value| {
        picture_file(image::GrayImage::from_pixel(width, height, image::Luma([value])), ImageFormat::Png)
    };
    folder.write("square.png", grey(24, 24, 255));
    folder.write("empty.png", grey(24, 16, 20));
    folder.write("small.png", grey(6, 4, 255));
    for (mask, said) in [("square.png", "24 × 24 pixels"), ("empty.png", "is empty")] {
        let (cause, _) =
            folder.fails(&format!("watercolorize photo.png out.png --reserve {mask} {QUICK}"), 4);
        assert!(cause.contains(said), "{cause}");
    }
    let (cause, _) =
        folder.fails(&format!("watercolorize photo.png out.png --detail-map square.png {QUICK}"), 4);
    assert!(cause.contains("proportions"), "{cause}");
    // Nothing is left to paint, and that is a painting too.
    paint(&folder, "photo.png out.png --reserve small.png --stages st --layers out.ora -q").fine();
}

#[test]
fn names_in_files_are_said_with_their_place() {
    let folder = studio();
    folder.write("preset.toml", "washes = 2\npalette = [\n  \"sepia\",\n  \"sepai\",\n]\n");
    folder.write("paper.toml", "paper = \"cold-pres\"\n");
    folder.write("key.toml", "wash = 2\n");
    folder.write("palette.toml", "pigments = [\"viridian\",\n\"virdian\"]\n");
    for (option, said) in [
        ("--preset preset.toml", "preset.toml:4:3: no pigment is called `sepai`"),
        ("--preset paper.toml", "paper.toml:1:9: no paper is called `cold-pres`"),
        ("--preset key.toml", "key.toml:1:1: unknown key `wash`"),
        ("--palette palette.toml", "palette.toml:2:1: no pigment is called `virdian`"),
    ] {
        let (cause, _) = folder.fails(&format!("watercolorize photo.png out.png {option}"), 4);
        assert!(cause.starts_with(said), "{cause}");
    }
}

#[test]
fn many_photographs_are_painted_and_failures_come_last() {
    let folder = Folder::new();
    fs::create_dir(folder.path("in")).unwrap();
    fs::create_dir(folder.path("out")).unwrap();
    for name in ["a.png", "c.png"] {
        folder.write(&format!("in/{name}"), picture_file(photo(24, 16), ImageFormat::Png));
    }
    folder.write("in/b.png", b"broken");
    folder.write("in/notes.txt", b"no photograph");
    let ran = paint(&folder, "in out");
    assert_eq!(ran.code, 3, "{}", ran.stderr);
    assert!(folder.has("out/a.png") && folder.has("out/c.png") && !folder.has("out/b.png"));
    assert!(ran.stderr.contains("1 of 3 photographs failed: in/b.png"), "{}", ran.stderr);
    // What is there is left, what failed is tried again.
    let before = folder.read("out/a.png");
    folder.fails(&format!("watercolorize in out {QUICK}"), 5);
    folder.write("in/b.png", picture_file(photo(16, 24), ImageFormat::Png));
    folder.write("out/a.png", b"mine");
    paint(&folder, "in out --skip-existing").fine();
    assert!(folder.read("out/a.png") == b"mine" && png_size(&folder.read("out/b.png")).1 > 24);
    paint(&folder, "in/a.png out/{stem}.png --overwrite").fine();
    assert!(folder.read("out/a.png") == before);
    let ran = paint(&folder, "in/*.png out/{stem}.jpg --json --seed 3").fine();
    let lines: Vec<serde_json::Value> =
        ran.text().lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let outputs: Vec<&str> = lines.iter().map(|line| line["output"].as_str().unwrap()).collect();
    assert_eq!(outputs, ["out/a.jpg", "out/b.jpg", "out/c.jpg"]);
}

#[test]
fn many_photographs_need_many_names() {
    let folder = studio();
    fs::create_dir(folder.path("other")).unwrap();
    folder.write("other/photo.png", folder.read("photo.png"));
    folder.write("b.png", folder.read("photo.png"));
    for (line, said) in [
        ("photo.png b.png out.png", "cannot all be"),
        ("photo.png other/photo.png out-{stem}.png", "two outputs are"),
        ("photo.png b.png out-{stem}.png --layers one.ora", "cannot all be"),
        ("photo.png - out-{stem}.png", "standard input"),
    ] {
        let (cause, _) = folder.fails(&format!("watercolorize {line} {QUICK}"), 2);
        assert!(cause.contains(said), "{line}: {cause}");
    }
    let ran = paint(&folder, "nowhere.png neither.png other");
    assert!(ran.code == 1 && ran.stderr.contains("2 of 2 photographs failed"), "{}", ran.stderr);
}
