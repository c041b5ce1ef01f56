//! The papers there are: those built in, and those of the user beside them.

use girtin_params::hint_for;

use crate::recipe::{Paper, plain};

/// The built-in recipes, from smooth to rough, then those with a pattern: file name and text.
const BUILTIN: [(&str, &str); 8] = [
    ("smooth.toml", include_str!("../assets/smooth.toml")),
    ("hot-press.toml", include_str!("../assets/hot-press.toml")),
    ("fine-grain.toml", include_str!("../assets/fine-grain.toml")),
    ("cold-press.toml", include_str!("../assets/cold-press.toml")),
    ("rough.toml", include_str!("../assets/rough.toml")),
    ("laid.toml", include_str!("../assets/laid.toml")),
    ("canvas.toml", include_str!("../assets/canvas.toml")),
    ("japanese.toml", include_str!("../assets/japanese.toml")),
];

/// Papers by name.
#[derive(Clone, Debug, PartialEq)]
pub struct Papers(Vec<Paper>);

/// No paper has this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no paper is called `{name}`")]
pub struct UnknownPaper {
    /// The name, as it was given.
    pub name: String,
    /// The nearest name there is, or all of them.
    pub hint: String,
}

impl Papers {
    /// The papers that come with Girtin.
    ///
    /// # Panics
    /// Never: that each built-in recipe is sound is tested (`every_file_of_the_folder_is_built_in`).
    #[must_use]
    pub fn builtin() -> Self {
        let read =
            |&(file, text): &(&str, &str)| Paper::from_toml(file, text).expect("built-in recipes are sound");
        Self(BUILTIN.iter().map(read).collect())
    }

    /// The paper with this id or alias; case does not matter, nor whether words are joined by `-`, `_` or a
    /// space.
    ///
    /// # Errors
    /// There is none; the nearest name is offered.
    pub fn get(&self, name: &str) -> Result<&Paper, UnknownPaper> {
        let wanted = plain(name);
        // Ids before aliases: a user's `linen` is not hidden by the canvas that is also known as linen.
        let by_id = self.0.iter().find(|paper| paper.id == wanted);
        by_id.or_else(|| self.0.iter().find(|paper| paper.aliases.contains(&wanted))).ok_or_else(|| {
            let names = |paper: &'_ Paper| -> Vec<String> {
                std::iter::once(paper.id.clone()).chain(paper.aliases.iter().cloned()).collect()
            };
            let all: Vec<String> = self.0.iter().flat_map(names).collect();
            let ids: Vec<&str> = self.0.iter().map(|paper| paper.id.as_str()).collect();
            let all: Vec<&str> = all.iter().map(String::as_str).collect();
            let hint = match girtin_params::nearest(&wanted, all) {
                Some(near) => format!("did you mean `{near}`?"),
                None => hint_for(&wanted, &ids),
            };
            UnknownPaper { name: name.to_owned(), hint }
        })
    }

    /// All papers, built-in ones first.
    pub fn iter(&self) -> impl Iterator<Item = &Paper> {
        self.0.iter()
    }

    /// Adds a paper, in the place of the one with the same id if there is one; that one is given back.
    pub fn insert(&mut self, paper: Paper) -> Option<Paper> {
        match self.0.iter_mut().find(|known| known.id == paper.id) {
            Some(known) => Some(std::mem::replace(known, paper)),
            None => {
                self.0.push(paper);
                None
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_of_the_folder_is_built_in() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/assets");
        let mut files: Vec<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .filter(|name| name.ends_with(".toml"))
            .collect();
        files.sort();
        let mut known: Vec<&str> = BUILTIN.iter().map(|&(file, _)| file).collect();
        known.sort_unstable();
        assert_eq!(files, known);
        for (paper, (file, _)) in Papers::builtin().iter().zip(BUILTIN) {
            assert_eq!(format!("{}.toml", paper.id), file);
            assert!(!paper.about.is_empty(), "{file} says nothing about itself");
        }
    }

    #[test]
    fn no_name_means_two_papers() {
        let papers = Papers::builtin();
        let mut names: Vec<&String> = papers.iter().flat_map(|p| p.aliases.iter().chain([&p.id])).collect();
        let count = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), count);
    }

    #[test]
    fn names_are_found_however_they_are_written() {
        let papers = Papers::builtin();
        for name in ["cold-press", "Cold Press", "cold_press", " COLD-PRESS ", "not"] {
            assert_eq!(papers.get(name).unwrap().id, "cold-press", "{name}");
        }
        assert_eq!(papers.get("washi").unwrap().id, "japanese");
        assert_eq!(papers.get("Linen").unwrap().id, "canvas");
    }

    #[test]
    fn an_unknown_name_gets_the_nearest() {
        let papers = Papers::builtin();
        let unknown = papers.get("cold-pres").unwrap_err();
        assert_eq!(unknown.to_string(), "no paper is called `cold-pres`");
        assert_eq!(unknown.hint, "did you mean `cold-press`?");
        assert!(papers.get("zzzzzzzzz").unwrap_err().hint.starts_with("known here: smooth, hot-press"));
        assert!(papers.get("").is_err());
    }

    #[test]
    fn a_users_paper_takes_the_place_of_its_namesake() {
        let mut papers = Papers::builtin();
        let count = papers.iter().count();
        let mine = Paper::from_toml("mine", "id = \"linen\"\nlabel = \"Mine\"\n[[tooth]]\n").unwrap();
        assert_eq!(papers.insert(mine.clone()), None);
        assert_eq!(papers.get("linen").unwrap().label, "Mine");
        assert_eq!(papers.insert(mine.clone()), Some(mine));
        assert_eq!(papers.iter().count(), count + 1);
    }
}
