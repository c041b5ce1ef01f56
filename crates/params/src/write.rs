//! What a file says, as a tree that is written as TOML or as JSON: one description serves both.
//!
//! ```
//! use girtin_params::write::{Node, Tree};
//!
//! let glaze = Tree::new().with("name", "sky").with("amounts", vec![Node::from(0.5), Node::from(2.0)]);
//! let file = Tree::new().with("format", 1u64).with("glaze", Node::Sections(vec![glaze]));
//! assert_eq!(file.to_toml(), "format = 1\n\n[[glaze]]\nname = \"sky\"\namounts = [0.5, 2]\n");
//! let json = file.to_json();
//! assert_eq!(json, "{\n  \"format\": 1,\n  \"glaze\": [\n    {\n      \"name\": \"sky\",\n      \"amounts\": [0.5, 2]\n    }\n  ]\n}\n");
//! ```

use std::fmt::Write;

use crate::row::{Parameters, Value};

/// Keys and values in the order in which they are written.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tree(pub Vec<(String, Node)>);

/// A value.
#[derive(Clone, Debug, PartialEq)]
pub enum Node {
    /// Text.
    Text(String),
    /// A number, written so that reading gives the same bits; finite, or no reader takes it.
    Real(f64),
    /// A whole number.
    Count(u64),
    /// A list on one line.
    List(Vec<Node>),
    /// A table on one line.
    Inline(Tree),
    /// A table under its own heading.
    Section(Tree),
    /// Tables under a heading each.
    Sections(Vec<Tree>),
}

impl From<&str> for Node {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<f64> for Node {
    fn from(number: f64) -> Self {
        Self::Real(number)
    }
}

impl From<u64> for Node {
    fn from(number: u64) -> Self {
        Self::Count(number)
    }
}

impl From<u32> for Node {
    fn from(number: u32) -> Self {
        Self::Count(u64::from(number))
    }
}

impl<T: Into<Self>> From<Vec<T>> for Node {
    fn from(list: Vec<T>) -> Self {
        Self::List(list.into_iter().map(Into::into).collect())
    }
}

impl<T: Into<Self>, const N: usize> From<[T; N]> for Node {
    fn from(list: [T; N]) -> Self {
        Self::List(list.into_iter().map(Into::into).collect())
    }
}

impl From<Value> for Node {
    fn from(value: Value) -> Self {
        match value {
            Value::Real(x) => x.into(),
            Value::Count(n) => n.into(),
            Value::Span(span) => span.into(),
        }
    }
}

impl Tree {
    /// Nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// The value of every row of the parameters.
    pub fn of_parameters<P: Parameters>(parameters: &P) -> Self {
        let row = |row: &crate::Row| Some((row.id.to_owned(), parameters.get(row.id)?.into()));
        Self(P::ROWS.iter().filter_map(row).collect())
    }

    /// The same and one more value.
    #[must_use]
    pub fn with(mut self, key: &str, value: impl Into<Node>) -> Self {
        self.0.push((key.to_owned(), value.into()));
        self
    }

    /// The same and one more value, if there is one.
    #[must_use]
    pub fn with_some(self, key: &str, value: Option<impl Into<Node>>) -> Self {
        match value {
            Some(value) => self.with(key, value),
            None => self,
        }
    }

    /// The same and what another says.
    #[must_use]
    pub fn and(mut self, other: Self) -> Self {
        self.0.extend(other.0);
        self
    }

    /// As TOML. Keys are bare words.
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        self.toml_under("", &mut text);
        text
    }

    /// As JSON, a line for every value that is not within another.
    pub fn to_json(&self) -> String {
        let mut text = String::new();
        self.json_lines(1, &mut text);
        text.push('\n');
        text
    }

    fn toml_under(&self, path: &str, text: &mut String) {
        // TOML's rule: what comes behind a heading belongs to it, so plain values come first.
        for (key, node) in &self.0 {
            if !matches!(node, Node::Section(_) | Node::Sections(_)) {
                *text += key;
                *text += " = ";
                node.on_one_line(Notation::Toml, text);
                text.push('\n');
            }
        }
        for (key, node) in &self.0 {
            let path = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
            let (tables, [open, close]) = match node {
                Node::Section(table) => (std::slice::from_ref(table), ["[", "]"]),
                Node::Sections(tables) => (tables.as_slice(), ["[[", "]]"]),
                _ => continue,
            };
            for table in tables {
                if !text.is_empty() {
                    text.push('\n');
                }
                *text += open;
                *text += &path;
                *text += close;
                text.push('\n');
                table.toml_under(&path, text);
            }
        }
    }

    fn json_lines(&self, depth: usize, text: &mut String) {
        let indent = |text: &mut String, depth: usize| *text += &"  ".repeat(depth);
        text.push('{');
        for (at, (key, node)) in self.0.iter().enumerate() {
            *text += if at > 0 { ",\n" } else { "\n" };
            indent(text, depth);
            quoted(key, text);
            *text += ": ";
            match node {
                Node::Section(table) => table.json_lines(depth + 1, text),
                Node::Sections(tables) => {
                    text.push('[');
                    for (at, table) in tables.iter().enumerate() {
                        *text += if at > 0 { ",\n" } else { "\n" };
                        indent(text, depth + 1);
                        table.json_lines(depth + 2, text);
                    }
                    if !tables.is_empty() {
                        text.push('\n');
                        indent(text, depth);
                    }
                    text.push(']');
                }
                _ => node.on_one_line(Notation::Json, text),
            }
        }
        if !self.0.is_empty() {
            text.push('\n');
            indent(text, depth - 1);
        }
        text.push('}');
    }
}

#[derive(Clone, Copy)]
enum Notation {
    Toml,
    Json,
}

impl Node {
    fn on_one_line(&self, notation: Notation, text: &mut String) {
        match self {
            Self::Text(words) => quoted(words, text),
            Self::Count(number) => *text += &number.to_string(),
            Self::Real(number) => real(*number, text),
            Self::List(list) => {
                text.push('[');
                for (at, item) in list.iter().enumerate() {
                    *text += if at > 0 { ", " } else { "" };
                    item.on_one_line(notation, text);
                }
                text.push(']');
            }
            Self::Inline(table) | Self::Section(table) => table.on_one_line(notation, text),
            Self::Sections(tables) => {
                text.push('[');
                for (at, table) in tables.iter().enumerate() {
                    *text += if at > 0 { ", " } else { "" };
                    table.on_one_line(notation, text);
                }
                text.push(']');
            }
        }
    }
}

impl Tree {
    fn on_one_line(&self, notation: Notation, text: &mut String) {
        for (at, (key, node)) in self.0.iter().enumerate() {
            *text += if at > 0 { ", " } else { "{ " };
            match notation {
                Notation::Toml => {
                    *text += key;
                    *text += " = ";
                }
                Notation::Json => {
                    quoted(key, text);
                    *text += ": ";
                }
            }
            node.on_one_line(notation, text);
        }
        *text += if self.0.is_empty() { "{}" } else { " }" };
    }
}

/// The shortest digits that give the same number again.
fn real(number: f64, text: &mut String) {
    // Whole numbers without a point, but not so large ones that a reader of integers refuses them; nor −0, which no
    // integer is.
    let is_whole =
        number.fract() == 0.0 && number.abs() < 1e15 && (number != 0.0 || number.is_sign_positive());
    let written = if is_whole { write!(text, "{number}") } else { write!(text, "{number:?}") };
    // A string takes everything.
    debug_assert!(written.is_ok());
}

/// Text in double quotes with escapes that TOML and JSON both know.
fn quoted(words: &str, text: &mut String) {
    text.push('"');
    for c in words.chars() {
        match c {
            '"' => *text += "\\\"",
            '\\' => *text += "\\\\",
            '\n' => *text += "\\n",
            '\t' => *text += "\\t",
            c if u32::from(c) < 0x20 || c == '\u{7f}' => *text += &format!("\\u{:04x}", u32::from(c)),
            c => text.push(c),
        }
    }
    text.push('"');
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::read::Problem;
    use crate::{Table, parse, parse_json};

    type Told = (String, f64, u64, Vec<f64>, Option<(String, f64)>);

    fn read(table: &Table<'_>) -> Result<Told, crate::read::Fault> {
        let inner = table.table("inner", |inner| {
            Ok((inner.need_text("text")?, inner.need_real("real", f64::MIN..=f64::MAX)?))
        })?;
        Ok((
            table.need_text("text")?,
            table.need_real("real", f64::MIN..=f64::MAX)?,
            table.whole("whole")?.unwrap_or_default(),
            table.real_list("list", f64::MIN..=f64::MAX)?.unwrap_or_default(),
            inner,
        ))
    }

    fn both(tree: &Tree) -> [Result<Told, Problem>; 2] {
        [parse("t.toml", &tree.to_toml(), read), parse_json("t.json", &tree.to_json(), read)]
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(
            text in "\\PC{0,8}|[\\x00-\\x7f]{0,8}",
            real in any::<f64>().prop_filter("finite", |x| x.is_finite()),
            whole in any::<u64>(),
            list in prop::collection::vec(-1e6f64..1e6, 0..4),
            is_inline in any::<bool>(),
        ) {
            let inner = Tree::new().with("text", text.as_str()).with("real", real);
            let inner = if is_inline { Node::Inline(inner) } else { Node::Section(inner) };
            let tree = Tree::new().with("inner", inner).with("text", text.as_str()).with("real", real);
            let tree = tree.with("whole", whole).with("list", list.clone());
            for told in both(&tree) {
                let (text2, real2, whole2, list2, inner) = told.unwrap();
                prop_assert_eq!((&text2, real2.to_bits(), whole2), (&text, real.to_bits(), whole));
                prop_assert_eq!(list2, list.clone());
                let (text2, real2) = inner.unwrap();
                prop_assert_eq!((text2, real2.to_bits()), (text.clone(), real.to_bits()));
            }
        }
    }

    #[test]
    fn what_is_not_finite_is_refused_by_the_reader() {
        for real in [f64::NAN, f64::INFINITY] {
            let tree = Tree::new().with("text", "").with("real", real);
            assert!(both(&tree).iter().all(Result::is_err));
        }
    }
}
