//! JSON into the tables that TOML becomes, each value with its place: one reader serves both.
//!
//! Not through a general JSON value: that has no places, and its numbers have been rounded before the reader sees them.

use std::borrow::Cow;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

/// Deepest nesting: a document's is about seven.
const MAX_DEPTH: usize = 64;

/// What is wrong and where, bytes of the text.
#[derive(Debug)]
pub(crate) struct Flaw {
    pub message: String,
    pub span: Range<usize>,
}

/// Reads one object.
pub(crate) fn object(text: &str) -> Result<DeTable<'_>, Flaw> {
    let mut reader = Reader { text, at: 0 };
    reader.blank();
    let value = reader.value(0)?;
    reader.blank();
    if reader.at < text.len() {
        return Err(reader.flaw("something follows the closing `}`"));
    }
    match value.into_inner() {
        DeValue::Table(table) => Ok(table),
        _ => Err(Flaw { message: "the file must be an object `{ … }`".to_owned(), span: 0..0 }),
    }
}

struct Reader<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Reader<'a> {
    fn rest(&self) -> &'a [u8] {
        &self.text.as_bytes()[self.at..]
    }

    fn peek(&self) -> Option<u8> {
        self.rest().first().copied()
    }

    fn flaw(&self, message: impl Into<String>) -> Flaw {
        // A whole character, so that the place can be shown.
        let end = self.text[self.at..].chars().next().map_or(0, char::len_utf8);
        Flaw { message: message.into(), span: self.at..self.at + end }
    }

    fn blank(&mut self) {
        self.at += self.rest().iter().take_while(|byte| b" \t\r\n".contains(byte)).count();
    }

    /// Takes a byte if it comes next.
    fn take(&mut self, byte: u8) -> bool {
        let comes = self.peek() == Some(byte);
        self.at += usize::from(comes);
        comes
    }

    fn value(&mut self, depth: usize) -> Result<Spanned<DeValue<'a>>, Flaw> {
        let start = self.at;
        if depth > MAX_DEPTH {
            return Err(self.flaw(format!("values are nested deeper than {MAX_DEPTH}")));
        }
        let value = match self.peek() {
            Some(b'{') => DeValue::Table(self.table(depth)?),
            Some(b'[') => DeValue::Array(self.list(depth)?),
            Some(b'"') => DeValue::String(self.string()?),
            Some(b'-' | b'0'..=b'9') => self.number()?,
            Some(_) => self.word()?,
            None => return Err(self.flaw("the text ends where a value should be")),
        };
        Ok(Spanned::new(start..self.at, value))
    }

    fn word(&mut self) -> Result<DeValue<'a>, Flaw> {
        for (word, value) in [("true", true), ("false", false)] {
            if self.rest().starts_with(word.as_bytes()) {
                self.at += word.len();
                return Ok(DeValue::Boolean(value));
            }
        }
        if self.rest().starts_with(b"null") {
            return Err(self.flaw("`null` is no value here: leave its key out"));
        }
        Err(self.flaw("a value should be here"))
    }

    fn table(&mut self, depth: usize) -> Result<DeTable<'a>, Flaw> {
        let mut table = DeTable::new();
        self.at += 1;
        self.blank();
        if self.take(b'}') {
            return Ok(table);
        }
        loop {
            let start = self.at;
            if self.peek() != Some(b'"') {
                return Err(self.flaw("a key in double quotes should be here"));
            }
            let key = self.string()?;
            let key = Spanned::new(start..self.at, key);
            self.blank();
            if !self.take(b':') {
                return Err(self.flaw("a `:` should be here"));
            }
            self.blank();
            let value = self.value(depth + 1)?;
            if table.contains_key(key.get_ref().as_ref()) {
                let message = format!("`{}` is there twice", key.get_ref());
                return Err(Flaw { message, span: key.span() });
            }
            table.insert(key, value);
            self.blank();
            if self.take(b'}') {
                return Ok(table);
            }
            if !self.take(b',') {
                return Err(self.flaw("a `,` or `}` should be here"));
            }
            self.blank();
        }
    }

    fn list(&mut self, depth: usize) -> Result<DeArray<'a>, Flaw> {
        let mut list = DeArray::new();
        self.at += 1;
        self.blank();
        if self.take(b']') {
            return Ok(list);
        }
        loop {
            list.push(self.value(depth + 1)?);
            self.blank();
            if self.take(b']') {
                return Ok(list);
            }
            if !self.take(b',') {
                return Err(self.flaw("a `,` or `]` should be here"));
            }
            self.blank();
        }
    }

    /// A number: JSON's are a part of TOML's.
    fn number(&mut self) -> Result<DeValue<'a>, Flaw> {
        let start = self.at;
        let digits = |reader: &mut Self| {
            let count = reader.rest().iter().take_while(|byte| byte.is_ascii_digit()).count();
            reader.at += count;
            count
        };
        self.take(b'-');
        let whole = self.at;
        let count = digits(self);
        let mut sound = count > 0 && (count == 1 || self.text.as_bytes()[whole] != b'0');
        if self.take(b'.') {
            sound &= digits(self) > 0;
        }
        if self.take(b'e') || self.take(b'E') {
            let _ = self.take(b'+') || self.take(b'-');
            sound &= digits(self) > 0;
        }
        let span = start..self.at;
        let number = &self.text[span.clone()];
        let flaw = || Flaw { message: format!("`{number}` is no number"), span: span.clone() };
        if !sound {
            return Err(flaw());
        }
        Ok(DeValue::parse(number).map_err(|_| flaw())?.into_inner())
    }

    fn string(&mut self) -> Result<Cow<'a, str>, Flaw> {
        self.at += 1;
        let mut start = self.at;
        let mut text = Cow::Borrowed("");
        loop {
            match self.peek() {
                Some(b'"') => {
                    text += &self.text[start..self.at];
                    self.at += 1;
                    return Ok(text);
                }
                Some(b'\\') => {
                    text += &self.text[start..self.at];
                    text.to_mut().push(self.escape()?);
                    start = self.at;
                }
                Some(0..0x20) => return Err(self.flaw("a control character must be escaped in text")),
                Some(_) => self.at += 1,
                None => return Err(self.flaw("the text ends inside quotes")),
            }
        }
    }

    /// A character behind a backslash.
    fn escape(&mut self) -> Result<char, Flaw> {
        let start = self.at;
        let escaped = self.rest().get(1).copied();
        self.at = (start + 2).min(self.text.len());
        let plain = match escaped {
            Some(byte @ (b'"' | b'\\' | b'/')) => Some(char::from(byte)),
            Some(b'b') => Some('\u{8}'),
            Some(b'f') => Some('\u{c}'),
            Some(b'n') => Some('\n'),
            Some(b'r') => Some('\r'),
            Some(b't') => Some('\t'),
            Some(b'u') => self.unicode(),
            _ => None,
        };
        plain.ok_or_else(|| {
            self.at = start;
            self.flaw("this escape means no character")
        })
    }

    /// The character of four hexadecimal digits, or of a pair of them beyond the first plane.
    fn unicode(&mut self) -> Option<char> {
        let first = self.four_digits()?;
        if !(0xd800..0xdc00).contains(&first) {
            return char::from_u32(first);
        }
        if !self.rest().starts_with(b"\\u") {
            return None;
        }
        self.at += 2;
        let second = self.four_digits()?.checked_sub(0xdc00).filter(|low| *low < 0x400)?;
        char::from_u32(0x10000 + ((first - 0xd800) << 10) + second)
    }

    fn four_digits(&mut self) -> Option<u32> {
        let digits = self.rest().get(..4)?;
        let value =
            digits.iter().try_fold(0, |value, digit| Some(value * 16 + char::from(*digit).to_digit(16)?))?;
        self.at += 4;
        Some(value)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The value as another library sees it.
    fn told(value: &DeValue<'_>) -> serde_json::Value {
        match value {
            DeValue::String(text) => text.as_ref().into(),
            DeValue::Integer(whole) => serde_json::from_str(whole.as_str()).unwrap(),
            DeValue::Float(real) => real.as_str().parse::<f64>().unwrap().into(),
            DeValue::Boolean(is) => (*is).into(),
            DeValue::Datetime(_) => unreachable!("JSON has no dates"),
            DeValue::Array(list) => list.iter().map(|item| told(item.get_ref())).collect(),
            DeValue::Table(table) => serde_json::Value::Object(
                table.iter().map(|(k, v)| (k.get_ref().to_string(), told(v.get_ref()))).collect(),
            ),
        }
    }

    #[track_caller]
    fn flawed(text: &str, at: usize, said: &str) {
        let flaw = object(text).unwrap_err();
        assert!(flaw.message.contains(said) && flaw.span.start == at, "{text}: {flaw:?}");
    }

    #[test]
    fn values_are_read_with_their_place() {
        let text = r#"{ "a" : [1, -2.5e-3, "x\u00e9\ud83c\udfa8\n"], "b": {"c": true} }"#;
        let table = object(text).unwrap();
        let a = table.get("a").unwrap();
        assert_eq!(a.span(), 8..text.find(", \"b\"").unwrap());
        assert_eq!(told(a.get_ref()), serde_json::json!([1, -0.0025, "xé🎨\n"]));
        assert_eq!(told(table.get("b").unwrap().get_ref()), serde_json::json!({ "c": true }));
    }

    #[test]
    fn what_is_no_json_is_said_where_it_is() {
        flawed("", 0, "ends where a value");
        flawed("[1]", 0, "must be an object");
        flawed("{\"a\": 1} x", 9, "follows");
        flawed("{\"a\": 1, \"a\": 2}", 9, "`a` is there twice");
        flawed("{\"a\": null}", 6, "leave its key out");
        flawed("{\"a\": 01}", 6, "`01` is no number");
        flawed("{\"a\": 1.}", 6, "`1.` is no number");
        flawed("{\"a\": \"\\x\"}", 7, "escape");
        flawed("{\"a\": \"\\ud800x\"}", 7, "escape");
        flawed("{\"a\": \"é", 9, "inside quotes");
        flawed("{\"a\": [1 2]}", 9, "`,` or `]`");
        flawed("{a: 1}", 1, "double quotes");
        flawed(&"{\"a\":".repeat(1000), 5 * (MAX_DEPTH + 1), "nested deeper");
    }

    fn any_json() -> impl Strategy<Value = serde_json::Value> {
        let leaf = prop_oneof![
            any::<bool>().prop_map(Into::into),
            any::<i64>().prop_map(Into::into),
            any::<f64>().prop_filter("finite", |x| x.is_finite()).prop_map(Into::into),
            "\\PC{0,8}|[\\x00-\\x1f\"\\\\]{0,4}".prop_map(Into::into),
        ];
        leaf.prop_recursive(4, 32, 4, |inner| {
            prop_oneof![
                prop::collection::vec(inner.clone(), 0..4).prop_map(Into::into),
                prop::collection::btree_map("\\PC{0,4}", inner, 0..4)
                    .prop_map(|map| serde_json::Value::Object(map.into_iter().collect())),
            ]
        })
    }

    proptest! {
        #[test]
        fn what_another_library_writes_is_read(value in any_json(), pretty in any::<bool>()) {
            let value = serde_json::json!({ "value": value });
            let text = if pretty { format!("{value:#}") } else { value.to_string() };
            let table = object(&text).unwrap();
            prop_assert_eq!(told(&DeValue::Table(table)), value);
        }

        #[test]
        fn what_it_takes_is_json(text in "\\{\"a\":([\\[\\]{},:\"\\\\ue0-9+.tfn-]|true|\"b\":){0,12}\\}") {
            let is_null = text.contains('n') && !text.contains("true");
            if object(&text).is_ok() {
                prop_assert!(is_null || serde_json::from_str::<serde_json::Value>(&text).is_ok(), "{}", text);
            }
        }

        #[test]
        fn no_text_makes_it_panic(text in "\\PC{0,60}") {
            let _ = object(&text);
            let _ = object(&format!("{{\"{text}"));
        }
    }
}
