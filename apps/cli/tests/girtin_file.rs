//! `girtin paint --save`, what reads its file, and `girtin inspect`.

mod common;

use common::{Array, Folder, bytes_of, holds, npz, png_size, puddle};
use girtin::grid::Raster;
use girtin::painting::picture::{PictureMeta, write_grey_png};
use girtin::wash::{Ledger, WashState};

const DOCUMENT: &str = "format = 1\ntitle = \"Shapes\"\n[sheet]\nsize = [12, 9]\npaper = 'felt'\nseed = 5\n\
    pixels_per_mm = 6\ncells_per_mm = 4\n[[glaze]]\nname = 'two'\npigments = ['mud', 'cobalt-blue']\n\
    [glaze.outline]\nregions = 'maps/regions.png'\n[[glaze.events]]\ndo = 'brush'\nwater = 0.6\n\
    amounts = [0.4, 0.2]\n[[glaze.events]]\ndo = 'run'\nsteps = 50\n[[glaze.events]]\ndo = 'lift'\nfraction = 0.5\n\
    area = { shape = 'map', file = 'lifted.npz' }\n[[glaze]]\npigments = ['burnt-umber']\n";

const OWN: &str = "--pigment-file mud.toml --paper-file felt.toml";

/// A folder with a document, its maps, and a pigment and a paper of its own.
fn studio() -> Folder {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("maps")).unwrap();
    let mut regions = Vec::new();
    let raster = Raster::from_fn(24, 18, |x, _| if x < 12 { 1 } else { 2 });
    write_grey_png(&mut regions, &raster, &PictureMeta::default()).unwrap();
    folder
        .write("doc.toml", DOCUMENT)
        .write("maps/regions.png", regions)
        .write("lifted.npz", npz(&[Array::f32("map", &[9, 12], |i| i as f32 / 333.0)]))
        .write(
            "mud.toml",
            "id = \"mud\"\nlabel = \"Mud\"\ndensity = 0.05\nstaining_power = 2\ngranulation = 0.5\n\
            [appearance]\nover_white = \"#996633\"\nover_black = \"#110c08\"\n",
        )
        .write("felt.toml", "id = \"felt\"\nlabel = \"Felt\"\n[[tooth]]\nwavelength_mm = 0.8\n");
    folder
}

/// A folder with nothing but the painting, saved.
fn saved(more: &str) -> (Folder, Vec<u8>) {
    let folder = studio();
    folder.run(&format!("paint -q doc.toml out.png --save x.girtin {OWN} {more}")).fine();
    let alone = Folder::new();
    alone.write("x.girtin", folder.read("x.girtin"));
    (alone, folder.read("out.png"))
}

#[test]
fn a_saved_painting_stands_alone_and_paints_the_same_bytes() {
    for more in ["", "--scale 2 --seed 99", "--water coarse", "--seed 18446744073709551615"] {
        let (alone, picture) = saved(more);
        assert!(holds(&picture, "Document") && holds(&picture, "Seed"));
        alone.run("paint -q x.girtin again.png").fine();
        assert!(alone.read("again.png") == picture, "{more}");
        // Saved again it is the same file, too.
        alone.run("paint -q x.girtin --save y.girtin").fine();
        assert!(alone.read("x.girtin") == alone.read("y.girtin"), "{more}");
    }
}

#[test]
fn saving_changes_no_picture_and_every_form_has_the_same() {
    let folder = studio();
    folder.run(&format!("paint -q doc.toml plain.png {OWN}")).fine();
    folder.run(&format!("paint -q doc.toml saved.png --save x.girtin {OWN} --threads 1")).fine();
    assert!(folder.read("plain.png") == folder.read("saved.png"));
    let json = folder.run("inspect x.girtin --json").fine().json();
    let fingerprint = json["document"].as_str().unwrap();
    assert!(holds(&folder.read("plain.png"), fingerprint), "{fingerprint}");
    // From a pipe.
    let piped = folder.run_with("paint -q - -", &folder.read("x.girtin")).fine();
    assert!(piped.stdout == folder.read("plain.png"));
    let piped = folder.run_with(&format!("paint -q - - {OWN}"), DOCUMENT.as_bytes()).fine();
    assert!(piped.stdout == folder.read("plain.png"));
    // What it is, not what it is called.
    folder.write("odd.toml", folder.read("x.girtin"));
    folder.run("paint -q odd.toml odd.png").fine();
    assert!(folder.read("odd.png") == folder.read("plain.png"));
}

#[test]
fn a_painting_is_painted_larger_and_with_other_paint() {
    let (alone, picture) = saved("");
    alone.run("paint -q x.girtin twice.png --scale 2").fine();
    assert_eq!(png_size(&alone.read("twice.png")), (144, 108));
    let mud = "id = \"mud\"\nlabel = \"Mud\"\ndensity = 0.05\nstaining_power = 2\ngranulation = 0.5\n\
        [appearance]\nover_white = \"#339966\"\nover_black = \"#110c08\"\n";
    alone.write("green.toml", mud);
    alone.run("paint -q x.girtin green.png --pigment-file green.toml").fine();
    assert!(alone.read("green.png") != picture);
}

#[test]
fn documents_may_be_json() {
    let folder = Folder::new();
    let json = "{ \"format\": 1, \"sheet\": { \"size\": [10, 6], \"pixels_per_mm\": 4 } }";
    folder.write("doc.json", json);
    folder.write("doc.toml", "format = 1\n[sheet]\nsize = [10, 6]\npixels_per_mm = 4\n");
    folder.run("paint doc.json a.png -q").fine();
    folder.run("paint doc.toml b.png -q").fine();
    assert!(folder.read("a.png") == folder.read("b.png"));
    folder.write("doc.json", json.replace("pixels_per", "pixel_per"));
    let (cause, hint) = folder.fails("paint doc.json c.png", 4);
    assert!(cause.starts_with("doc.json:1:") && hint.contains("`pixels_per_mm`"), "{cause} {hint}");
}

#[test]
fn outputs_of_a_saved_painting_are_guarded_like_any_other() {
    let folder = studio();
    let paint = |line: &str, code: i32| folder.fails(&format!("paint doc.toml {line} {OWN}"), code);
    paint("", 2);
    paint("x.girtin", 2);
    paint("out.png --save x.png", 2);
    paint("out.png --save out.png", 2);
    paint("- --save -", 2);
    paint("out.png --save doc.toml --overwrite", 2);
    paint("out.png --save none/x.girtin", 1);
    paint("out.png --save x.girtin --scale 100 --memory 1MB", 1);
    folder.write("x.girtin", "mine");
    paint("out.png --save x.girtin", 5);
    assert!(!folder.has("out.png"));
    folder.run(&format!("paint -q doc.toml out.png --save x.girtin {OWN} --skip-existing")).fine();
    assert!(folder.has("out.png") && folder.read("x.girtin") == b"mine");
    folder.run(&format!("paint -q doc.toml out.png --save x.girtin {OWN} --overwrite")).fine();
    assert!(folder.read("x.girtin").starts_with(b"PK"));
    // What no file can hold is said before the work.
    folder.write("small.toml", "format = 1\n[sheet]\nsize = [0.1, 0.1]\npixels_per_mm = 50\n");
    let (cause, _) = folder.fails("paint small.toml --save s.girtin --scale 4", 4);
    assert!(cause.contains("cannot be saved"), "{cause}");
    // A map is not written over.
    folder.write("self.toml", DOCUMENT.replace("lifted.npz", "x.girtin"));
    let (cause, _) = folder.fails(&format!("paint self.toml --save x.girtin {OWN} --overwrite"), 4);
    assert!(cause.contains("it is the output as well"), "{cause}");
}

#[test]
fn paintings_that_are_damaged_or_none() {
    let (alone, _) = saved("");
    let whole = alone.read("x.girtin");
    alone.write("cut.girtin", &whole[..whole.len() / 2]).write("state.girtin", bytes_of(&puddle(8, 6, 1)));
    for (file, said) in [("cut.girtin", "not a whole .girtin"), ("state.girtin", "state of a wash")] {
        let (cause, _) = alone.fails(&format!("paint {file} out.png"), 4);
        assert!(cause.contains(said), "{cause}");
    }
    let (cause, _) = alone.fails("inspect cut.girtin", 4);
    assert!(cause.contains("not a whole .girtin"), "{cause}");
    alone.fails("inspect none.girtin", 4);
    alone.write("picture.png", b"\x89PNG\r\n\x1a\n").write("words.txt", "some words");
    alone.fails("inspect picture.png", 4);
    alone.fails("inspect words.txt", 4);
    // A flipped byte in a map's picture.
    let mut bytes = whole;
    let at = bytes.windows(16).position(|window| window == b"maps/regions.png").unwrap() + 60;
    bytes[at] ^= 1;
    alone.write("bent.girtin", bytes);
    let (cause, _) = alone.fails("paint bent.girtin out.png", 4);
    assert!(cause.contains("maps/regions.png"), "{cause}");
}

#[test]
fn a_painting_is_described() {
    let (alone, _) = saved("");
    let told = alone.run("inspect x.girtin --json").fine().json();
    assert_eq!((&told["format"], &told["title"]), (&"girtin".into(), &"Shapes".into()));
    assert_eq!(told["sheet"]["paper"], "felt");
    assert_eq!(told["sheet"]["picture"], serde_json::json!([72, 54]));
    let glazes = told["glazes"].as_array().unwrap();
    assert_eq!((glazes.len(), &glazes[0]["steps"], &glazes[0]["events"]), (2, &50.into(), &3.into()));
    let mud = &glazes[0]["pigments"][0];
    let number = |key: &str| mud[key].as_f64().unwrap();
    assert_eq!(mud["name"], "mud");
    assert!(number("lifted") > 0.0 && (number("laid") - number("lifted") - number("total")).abs() < 0.01);
    assert_eq!(told["maps"][1]["bits"], 8, "{told}");
    assert_eq!(told["maps"][0]["bits"], 16, "a float map is rounded");
    let page = alone.run("inspect x.girtin").fine().text();
    for word in
        ["Shapes", "12 × 9 mm of felt, seed 5", "glaze 1, two: living, 3 events, 50 steps", "mud", "lifted"]
    {
        assert!(page.contains(word), "{word} in {page}");
    }
    let piped = alone.run_with("inspect - --json", &alone.read("x.girtin")).fine();
    assert!(piped.json() == told);
}

#[test]
fn a_document_that_was_not_painted_knows_no_amounts() {
    let folder = studio();
    let told = folder.run(&format!("inspect doc.toml --json {OWN}")).fine().json();
    let pigment = &told["glazes"][0]["pigments"][1];
    assert_eq!(pigment["name"], "cobalt-blue");
    assert!(["laid", "lifted", "total"].iter().all(|key| pigment[*key].is_null()));
    assert_eq!(told["format"], "toml");
    let page = folder.run(&format!("inspect doc.toml {OWN}")).fine().text();
    assert!(page.contains("cobalt-blue") && !page.contains("laid"), "{page}");
}

#[test]
fn a_state_is_described() {
    let folder = Folder::new();
    let state = WashState { ledger: Some(Ledger::new(8.0)), ..puddle(16, 12, 2) };
    folder.write("living.npz", bytes_of(&state)).write("c97.npz", bytes_of(&puddle(16, 12, 1)));
    let told = folder.run("inspect living.npz --json").fine().json();
    assert_eq!((&told["model"], &told["wet_cells"]), (&"living".into(), &48.into()));
    assert!((told["water"].as_f64().unwrap() - state.water_total()).abs() < 1e-9);
    assert_eq!(told["fields"].as_array().unwrap().len(), 8);
    assert_eq!(told["fields"][7]["shape"], serde_json::json!([2, 12, 16]));
    let page = folder.run("inspect c97.npz").fine().text();
    assert!(page.contains("state of a c97 wash, 16 × 12 cells\n") && page.contains("(12, 17)"), "{page}");
}

#[test]
fn lengths_are_rounded_for_people_and_exact_for_programs() {
    let folder = Folder::new();
    folder.write(
        "doc.toml",
        "format = 1\n[sheet]\nsize = [114.66666666666666, 20]\ntrim = 1.23456\ncells_per_mm = 4\n",
    );
    let page = folder.run("inspect doc.toml").fine().text();
    assert!(page.contains("114.67 × 20 mm of") && page.contains("1.23 mm cut off"), "{page}");
    let told = folder.run("inspect doc.toml --json").fine().json();
    assert_eq!(told["sheet"]["size_mm"][0], 114.66666666666666);
    assert!(folder.run("paint doc.toml out.png --dry-run").fine().text().contains("114.67 × 20 mm"));
}

#[test]
fn the_standard_input_is_read_once() {
    let folder = studio();
    for line in ["paint - out.png --paper-file -", "inspect - --pigment-file -"] {
        let (cause, _) = folder.fails(line, 2);
        assert!(cause.contains("only once"), "{cause}");
    }
}
