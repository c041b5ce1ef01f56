use super::*;
use proptest::prelude::*;

fn read(text: &str) -> Result<Document, Problem> {
    Document::from_toml("test.toml", text, &Stock::builtin())
}

const SHEET: &str = "format = 1\n[sheet]\nsize = [30, 20]\n";

#[test]
fn names_become_ids_and_unknown_ones_get_the_nearest() {
    let glaze = |pigment: &str| read(&format!("{SHEET}[[glaze]]\npigments = ['{pigment}']\n"));
    assert_eq!(glaze("French Ultramarine").unwrap().glazes[0].pigments, ["french-ultramarine"]);
    let problem = glaze("french-ultramarin").unwrap_err();
    assert_eq!(problem.line, 5);
    assert!(problem.hint.unwrap().contains("french-ultramarine"));
    let problem = read("format = 1\n[sheet]\nsize = [3, 2]\npaper = 'cold-pres'\n").unwrap_err();
    assert!(problem.hint.unwrap().contains("cold-press"));
}

#[test]
fn what_a_file_lacks_is_said() {
    for (text, message) in [
        ("", "the file lacks `format`"),
        ("format = 2", "format 2 is not known"),
        ("format = 1", "the file lacks `[sheet]`"),
        ("format = 1\n[sheet]", "`sheet` lacks `size`"),
        (&format!("{SHEET}[[glaze]]\n[[glaze.events]]\n"), "an event lacks `do`"),
        (&format!("{SHEET}[[glaze]]\n[[glaze.events]]\ndo = 'run'\n"), "`run` lacks `steps`"),
        (
            &format!(
                "{SHEET}[[glaze]]\npigments = ['PB60']\n[[glaze.events]]\ndo = 'pigment'\namounts = []\n"
            ),
            "`amounts` has 0 numbers for 1 pigments",
        ),
    ] {
        assert_eq!(read(text).unwrap_err().message, message);
    }
}

#[test]
fn events_of_the_living_wash_are_no_c97_glaze_s() {
    let other = "[[glaze.events]]\ndo = 'run'\nsteps = 3\n";
    for (event, line) in [("do = 'tilt'\ndegrees = 20\n", 11), ("do = 'run'\nsteps = 3\nuntil = 'dry'\n", 13)]
    {
        let glaze = |model: &str| {
            let wash = format!("[glaze.wash]\nmodel = '{model}'\n");
            read(&format!("{SHEET}[[glaze]]\n{wash}{other}[[glaze.events]]\n{event}{other}"))
        };
        assert!(glaze("living").is_ok());
        let problem = glaze("c97").unwrap_err();
        assert!(problem.message.contains("of the living wash"));
        assert_eq!(problem.line, line, "not that of the first event");
    }
    let dry = "[[glaze]]\n[[glaze.events]]\ndo = 'dry'\ndamp = [0.1, 0]\narea = { shape = 'everywhere' }\n";
    assert_eq!(read(&format!("{SHEET}{dry}")).unwrap_err().message, "`dry` has an `area` and `damp`");
}

#[test]
fn a_brush_lays_less_water_along_its_edge_but_as_much_pigment() {
    use crate::area::Canvas;
    let area =
        Area { shape: crate::area::Shape::Disc { center: [5.0, 5.0], radius: 3.0 }, ..Area::default() };
    let height = girtin_grid::Raster::new(80, 80, 0.5);
    let canvas = Canvas::whole(&height, 8.0, 0);
    let water = area.cover_tapered(&canvas, None, crate::area::TAPER_MM).amount;
    let pigment = area.cover(&canvas, None).amount;
    let middle = water.width() / 2;
    assert_eq!((water.at(middle, middle), pigment.at(middle, middle)), (1.0, 1.0));
    assert_eq!(pigment.at(middle, 1), 1.0, "an eighth of a mm from the edge");
    assert!(water.at(middle, 1) < 0.5 && water.at(middle, 5) == 1.0, "it tapers over half a mm");
}

#[test]
fn keys_of_another_event_are_unknown() {
    let text = format!("{SHEET}[[glaze]]\n[[glaze.events]]\ndo = 'dry'\nsteps = 3\n");
    assert_eq!(read(&text).unwrap_err().message, "unknown key `glaze[1].events[1].steps`");
}

proptest! {
    #[test]
    fn no_text_makes_the_reader_panic(text in "\\PC{0,200}") {
        let _ = read(&text);
    }

    #[test]
    fn no_document_of_known_words_makes_the_reader_panic(
        body in "((do|area|steps|size|amounts|damp|pigments|\\[sheet\\]|\\[\\[glaze\\]\\]|\\[\\[glaze.events\\]\\]) ?=? ?(-?[0-9e.]{0,5}|'(wet|run|disc|stroke)'|\\[[0-9.,]*\\]|\\{ shape = '[a-z]{0,6}', radius = -?[0-9]{0,3} \\})\n){0,8}"
    ) {
        let _ = read(&format!("{SHEET}{body}"));
    }
}
