//! A painter's palette from a file: names of paints, and paints of the painter's own.

use girtin_params::read::Fault;
use girtin_params::{Problem, Table, parse};

use crate::library::{Library, UnknownPigment};
use crate::pigment::Pigment;

/// A palette.
///
/// ```
/// use girtin_optics::{Library, Palette};
///
/// let text = "pigments = ['French Ultramarine', 'burnt sienna']";
/// let palette = Palette::from_toml("two.toml", text, &Library::builtin())?;
/// assert_eq!(palette.pigments, ["french-ultramarine", "burnt-sienna"]);
/// # Ok::<(), girtin_params::Problem>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Palette {
    /// Ids of its pigments.
    pub pigments: Vec<String>,
    /// The library that it was read with, and the painter's own paints.
    pub library: Library,
}

impl Palette {
    /// Reads a palette: `pigments`, names of the library's or of the file's own; and `[[pigment]]`, each as in a
    /// pigment's file. Without `pigments` all of its own are the palette.
    ///
    /// # Errors
    /// The text is not TOML, a key or a name is unknown, there is no pigment, or one of its own is wrong.
    pub fn from_toml(origin: &str, text: &str, library: &Library) -> Result<Self, Problem> {
        parse(origin, text, |table| Self::read(table, library.clone()))
    }

    fn read(table: &Table<'_>, library: Library) -> Result<Self, Fault> {
        let own = table.tables("pigment", Pigment::read)?.unwrap_or_default();
        let ids: Vec<String> = own.iter().map(|pigment| pigment.id.clone()).collect();
        let library = own.into_iter().fold(library, Library::with);
        let names = table.texts("pigments")?.unwrap_or(ids);
        if names.is_empty() {
            table.finish()?;
            let fault = table.fault("pigments", "the palette has no pigments");
            return Err(fault.hint("add `pigments`, a list of names"));
        }
        let places = table.places("pigments");
        let mut pigments: Vec<String> = Vec::new();
        for (at, name) in names.iter().enumerate() {
            let wrong = |message: String, hint: String| match places.get(at) {
                Some(place) => table.fault_at(place, message).hint(hint),
                None => table.fault("pigments", message).hint(hint),
            };
            let unknown = |error: UnknownPigment| wrong(error.to_string(), error.hint());
            let id = library.get(name).map_err(unknown)?.id.clone();
            if pigments.contains(&id) {
                return Err(wrong(format!("`{id}` is there twice"), "name each pigment once".to_owned()));
            }
            pigments.push(id);
        }
        Ok(Self { pigments, library })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Palette, Problem> {
        Palette::from_toml("p.toml", text, &Library::builtin())
    }

    #[test]
    fn own_paints_are_a_palette_and_may_be_named_beside_others() {
        let umber = Library::builtin().get("burnt-umber").unwrap().to_toml().replace("burnt-umber", "mud");
        let umber = umber.replace("[linear]", "[pigment.linear]");
        let own = format!("[[pigment]]\n{umber}");
        assert_eq!(read(&own).unwrap().pigments, ["mud"]);
        let both = read(&format!("pigments = ['viridian', 'mud']\n{own}")).unwrap();
        assert_eq!(both.pigments, ["viridian", "mud"]);
        assert!(both.library.get("mud").is_ok());
    }

    #[test]
    fn what_is_wrong_is_said_with_its_place() {
        for (text, line, message) in [
            ("pigments = [\n 'viridian',\n 'virdian']", 3, "no pigment is called `virdian`"),
            ("pigments = []", 1, "the palette has no pigments"),
            ("", 1, "the palette has no pigments"),
            (
                "pigments = ['French Ultramarine',\n'french-ultramarine']",
                2,
                "`french-ultramarine` is there twice",
            ),
            ("pigment = 3", 1, "`pigment` must be"),
            ("colors = ['red']", 1, "unknown key `colors`"),
        ] {
            let problem = read(text).unwrap_err();
            assert!(problem.message.starts_with(message), "{}", problem.message);
            assert_eq!(problem.line, line, "{text}");
        }
    }
}
