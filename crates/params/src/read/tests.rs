use super::*;
use proptest::prelude::*;

crate::parameters! {
    /// Parameters to test with.
    pub struct Flow {
        viscosity: f64 {
            symbol: "μ", label: "Viscosity", unit: "1", default: 0.1, hard: (0.0, 1.0), soft: (0.0, 0.2),
            acts: Simulation, doc: "Thickness.", source: "C97 §4",
        }
        sweeps: u32 {
            symbol: "N", label: "Sweeps", unit: "1", default: 50, hard: (0.0, 100.0), soft: (0.0, 50.0),
            acts: Simulation, doc: "At most.", source: "C97 §4",
        }
    }
}

fn flow(text: &str) -> Result<Flow, Problem> {
    parse("wash.toml", text, |table| table.parameters())
}

#[test]
fn missing_keys_are_defaults() {
    assert_eq!(flow("sweeps = 3").unwrap(), Flow { sweeps: 3, ..Flow::default() });
    assert_eq!(flow("viscosity = 1").unwrap().viscosity, 1.0);
}

#[test]
fn unknown_keys_name_place_and_nearest() {
    let problem = flow("sweeps = 3\nviscosty = 0.2\n").unwrap_err();
    assert_eq!((problem.line, problem.column), (2, 1));
    assert_eq!(problem.to_string(), "wash.toml:2:1: unknown key `viscosty`");
    assert_eq!(problem.hint.as_deref(), Some("did you mean `viscosity`?"));
}

#[test]
fn a_hint_says_every_key_once() {
    let read = |table: &Table<'_>| Ok((table.has("a"), table.text("a")?, table.text("b")?));
    let problem = parse("t.toml", "zzzzzz = 1", read).unwrap_err();
    assert_eq!(problem.hint.as_deref(), Some("known here: a, b"));
}

#[test]
fn wrong_kinds_and_ranges_are_refused_at_the_value() {
    for bad in ["viscosity = \"thick\"", "viscosity = 2", "viscosity = nan", "sweeps = 1.5", "sweeps = -1"] {
        let problem = flow(bad).unwrap_err();
        assert_eq!(problem.line, 1, "{problem}");
        assert!(problem.column > 1, "{problem}");
    }
    assert!(flow("viscosity = ").unwrap_err().message.starts_with("not TOML"));
}

#[test]
fn inner_tables_say_their_path() {
    let read = |text| parse("d.toml", text, |root| root.tables("glaze", |glaze| glaze.need_text("name")));
    assert_eq!(read("[[glaze]]\nname = \"a\"").unwrap(), Some(vec!["a".to_owned()]));
    let problem = read("[[glaze]]\nname = \"a\"\n[[glaze]]\nnam = \"b\"").unwrap_err();
    assert_eq!(problem.message, "`glaze[2]` lacks `name`");
}

proptest! {
    #[test]
    fn no_text_makes_the_reader_panic(text in "\\PC{0,200}") {
        let _ = flow(&text);
    }

    #[test]
    fn no_document_of_known_words_makes_the_reader_panic(
        text in "((viscosity|sweeps|x|é|\\[a\\]|\\[\\[a\\]\\]) ?=? ?([0-9e.+-]{0,6}|\"[a-z]*\"|\\[[0-9,]*\\]|\\{\\})\n){0,6}"
    ) {
        let _ = flow(&text);
    }
}
