//! TOML or JSON into structs: what is read is what is known, so an unknown key is refused and the nearest name offered.
//!
//! A reader asks a [`Table`] for its keys one by one; whatever has not been asked for when the reader is done is
//! unknown. Nothing else lists the keys of a file.
//!
//! ```
//! let text = "name = \"felt\"\ngrain = 0.5\n";
//! let (name, grain) = girtin_params::parse("paper.toml", text, |table| {
//!     Ok((table.need_text("name")?, table.real("grain", 0.0..=1.0)?.unwrap_or(0.3)))
//! })?;
//! assert_eq!((name.as_str(), grain), ("felt", 0.5));
//! # Ok::<(), girtin_params::Problem>(())
//! ```

use std::cell::RefCell;
use std::ops::{Range, RangeInclusive};

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::row::{Parameters, Value};
use crate::{hint_for, json};

/// Largest TOML text that is read, bytes: a hand-written file of this size would be a mistake.
pub const MAX_TEXT: usize = 16 << 20;

/// What is wrong in a file, where, and what to do.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{origin}:{line}:{column}: {message}")]
pub struct Problem {
    /// Name of the file, as it was given.
    pub origin: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// What is wrong, with the key.
    pub message: String,
    /// What to do about it.
    pub hint: Option<String>,
    /// The whole text, to show the place.
    pub text: String,
    /// The place, bytes of `text`.
    pub span: Range<usize>,
}

/// A fault inside a table before the file's name and text are known to it.
#[derive(Debug)]
pub struct Fault {
    message: String,
    hint: Option<String>,
    span: Range<usize>,
}

impl Fault {
    /// The same fault with advice.
    #[must_use]
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }
}

/// Where a value stands in a file, for what turns out to be wrong with it once the file has been read.
///
/// ```
/// let text = "scan = \"felt.png\"\n";
/// let place = girtin_params::parse("paper.toml", text, |table| {
///     table.need_text("scan")?;
///     Ok(table.place("scan"))
/// })?;
/// let problem = place.problem("paper.toml", text, "no such file", "look at the spelling");
/// assert_eq!(problem.to_string(), "paper.toml:1:8: `scan`: no such file");
/// # Ok::<(), girtin_params::Problem>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Dotted path of the key; empty if no file said it.
    pub key: String,
    /// Bytes of the file's text.
    pub span: Range<usize>,
}

impl Place {
    /// What is wrong there; `text` is that of the file.
    pub fn problem(
        &self,
        origin: &str,
        text: &str,
        message: impl std::fmt::Display,
        hint: impl Into<String>,
    ) -> Problem {
        let message = format!("`{}`: {message}", self.key);
        located(origin, text, Fault { message, hint: Some(hint.into()), span: self.span.clone() })
    }
}

/// A fault with its line and column.
fn located(origin: &str, text: &str, fault: Fault) -> Problem {
    let start = floor_boundary(text, fault.span.start.min(text.len()));
    let end = floor_boundary(text, fault.span.end.min(text.len())).max(start);
    let before = &text[..start];
    let line_start = before.rfind('\n').map_or(0, |at| at + 1);
    Problem {
        origin: origin.to_owned(),
        line: before.matches('\n').count() + 1,
        column: before[line_start..].chars().count() + 1,
        message: fault.message,
        hint: fault.hint,
        text: text.to_owned(),
        span: start..end,
    }
}

/// Reads `text` and hands its root table to `read`; keys that `read` did not ask for are refused.
///
/// # Errors
/// The text is not TOML, `read` found a fault, or a key is unknown.
pub fn parse<T>(
    origin: &str,
    text: &str,
    read: impl FnOnce(&Table<'_>) -> Result<T, Fault>,
) -> Result<T, Problem> {
    let root = |text| {
        let root = DeTable::parse(text).map_err(|error| Fault {
            message: format!("not TOML: {}", error.message()),
            hint: None,
            span: error.span().unwrap_or(0..0),
        })?;
        Ok(root.into_inner())
    };
    parse_as(origin, text, root, read)
}

/// The same of JSON, an object as the root table.
///
/// # Errors
/// The text is not JSON, `read` found a fault, or a key is unknown.
pub fn parse_json<T>(
    origin: &str,
    text: &str,
    read: impl FnOnce(&Table<'_>) -> Result<T, Fault>,
) -> Result<T, Problem> {
    let root = |text| {
        json::object(text).map_err(|flaw| Fault {
            message: format!("not JSON: {}", flaw.message),
            hint: None,
            span: flaw.span,
        })
    };
    parse_as(origin, text, root, read)
}

fn parse_as<'a, T>(
    origin: &str,
    text: &'a str,
    root: impl FnOnce(&'a str) -> Result<DeTable<'a>, Fault>,
    read: impl FnOnce(&Table<'_>) -> Result<T, Fault>,
) -> Result<T, Problem> {
    let locate = |fault| located(origin, text, fault);
    if text.len() > MAX_TEXT {
        return Err(locate(Fault {
            message: format!("the file has {} bytes; {MAX_TEXT} at most are read", text.len()),
            hint: None,
            span: 0..0,
        }));
    }
    let root = root(text).map_err(locate)?;
    let table = Table::new(&root, 0..0, String::new());
    read(&table).and_then(|value| table.finish().map(|()| value)).map_err(locate)
}

fn floor_boundary(text: &str, mut at: usize) -> usize {
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

/// One table of a file, being read.
#[derive(Debug)]
pub struct Table<'a> {
    entries: &'a DeTable<'a>,
    /// Where the table stands, for faults that no key of it can bear.
    span: Range<usize>,
    /// Dotted path of the table, with its dot.
    path: String,
    asked: RefCell<Vec<String>>,
}

impl<'a> Table<'a> {
    fn new(entries: &'a DeTable<'a>, span: Range<usize>, path: String) -> Self {
        Self { entries, span, path, asked: RefCell::default() }
    }

    fn ask(&self, key: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        let mut asked = self.asked.borrow_mut();
        if !asked.iter().any(|known| known == key) {
            asked.push(key.to_owned());
        }
        self.entries.get(key)
    }

    /// Where the value of `key` stands, or the table if it has no such key.
    pub fn place(&self, key: &str) -> Place {
        let span = self.entries.get(key).map_or_else(|| self.span.clone(), Spanned::span);
        Place { key: format!("{}{key}", self.path), span }
    }

    /// Where each item of the list at `key` stands; nowhere if there is no list.
    pub fn places(&self, key: &str) -> Vec<Place> {
        match self.entries.get(key).map(Spanned::get_ref) {
            Some(DeValue::Array(items)) => {
                let items = items.iter().enumerate();
                let key = |at| format!("{}{key}[{}]", self.path, at + 1);
                items.map(|(at, item)| Place { key: key(at), span: item.span() }).collect()
            }
            _ => Vec::new(),
        }
    }

    /// A fault at the value of `key`, or at the table if it has no such key.
    pub fn fault(&self, key: &str, message: impl Into<String>) -> Fault {
        let span = self.entries.get(key).map_or_else(|| self.span.clone(), Spanned::span);
        Fault { message: message.into(), hint: None, span }
    }

    /// A fault at a place of this file, such as an item of a list.
    pub fn fault_at(&self, place: &Place, message: impl Into<String>) -> Fault {
        Fault { message: message.into(), hint: None, span: place.span.clone() }
    }

    fn wrong(&self, key: &str, wanted: &str, found: &DeValue<'_>) -> Fault {
        self.fault(key, format!("`{}{key}` must be {wanted}, not {}", self.path, article(found)))
    }

    fn missing(&self, key: &str, wanted: &str) -> Fault {
        let place = if self.path.is_empty() {
            "the file".to_owned()
        } else {
            format!("`{}`", self.path.trim_end_matches('.'))
        };
        self.fault(key, format!("{place} lacks `{key}`")).hint(format!("add `{key}`, {wanted}"))
    }

    /// Refuses a file of another format than `known`, or of none.
    ///
    /// # Errors
    /// It is.
    pub fn need_format(&self, known: u32) -> Result<(), Fault> {
        match self.count("format", 0..=u32::MAX)? {
            Some(format) if format == known => Ok(()),
            Some(other) => {
                let hint = format!("this Girtin reads format {known}; a newer one may read this file");
                Err(self.fault("format", format!("format {other} is not known")).hint(hint))
            }
            None => {
                let hint = format!("begin the file with `format = {known}`");
                Err(self.fault("format", "the file lacks `format`").hint(hint))
            }
        }
    }

    /// Whether the table has `key`; counts as asking for it.
    pub fn has(&self, key: &str) -> bool {
        self.ask(key).is_some()
    }

    /// Whether the value of `key` is a table; counts as asking for it.
    pub fn is_table(&self, key: &str) -> bool {
        self.ask(key).is_some_and(|value| value.get_ref().is_table())
    }

    /// A text, if the key is there.
    ///
    /// # Errors
    /// The value is not text.
    pub fn text(&self, key: &str) -> Result<Option<String>, Fault> {
        match self.ask(key) {
            None => Ok(None),
            Some(value) => match value.get_ref() {
                DeValue::String(text) => Ok(Some(text.clone().into_owned())),
                other => Err(self.wrong(key, "text in quotes", other)),
            },
        }
    }

    /// A text that must be there.
    ///
    /// # Errors
    /// The key is missing or its value is not text.
    pub fn need_text(&self, key: &str) -> Result<String, Fault> {
        self.text(key)?.ok_or_else(|| self.missing(key, "text in quotes"))
    }

    /// One of a few words, if the key is there.
    ///
    /// # Errors
    /// The value is not one of them.
    pub fn word<T: Copy>(&self, key: &str, words: &[(&str, T)]) -> Result<Option<T>, Fault> {
        let Some(text) = self.text(key)? else { return Ok(None) };
        match words.iter().find(|(word, _)| *word == text) {
            Some(&(_, value)) => Ok(Some(value)),
            None => {
                let known: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
                Err(self
                    .fault(key, format!("`{}{key}` cannot be `{text}`", self.path))
                    .hint(hint_for(&text, &known)))
            }
        }
    }

    /// A truth value, if the key is there.
    ///
    /// # Errors
    /// The value is neither true nor false.
    pub fn flag(&self, key: &str) -> Result<Option<bool>, Fault> {
        match self.ask(key) {
            None => Ok(None),
            Some(value) => match value.get_ref() {
                DeValue::Boolean(flag) => Ok(Some(*flag)),
                other => Err(self.wrong(key, "true or false", other)),
            },
        }
    }

    /// A number within `range`, if the key is there.
    ///
    /// # Errors
    /// The value is not a number or outside the range.
    pub fn real(&self, key: &str, range: RangeInclusive<f64>) -> Result<Option<f64>, Fault> {
        self.ask(key).map(|value| self.number(key, value.get_ref(), &range)).transpose()
    }

    /// A number within `range` that must be there.
    ///
    /// # Errors
    /// The key is missing, its value is not a number or outside the range.
    pub fn need_real(&self, key: &str, range: RangeInclusive<f64>) -> Result<f64, Fault> {
        self.real(key, range)?.ok_or_else(|| self.missing(key, "a number"))
    }

    /// `N` numbers within `range`, if the key is there.
    ///
    /// # Errors
    /// The value is not a list of `N` numbers, or one is outside the range.
    pub fn reals<const N: usize>(
        &self,
        key: &str,
        range: RangeInclusive<f64>,
    ) -> Result<Option<[f64; N]>, Fault> {
        let Some(value) = self.ask(key) else { return Ok(None) };
        let wanted = format!("a list of {N} numbers");
        let DeValue::Array(items) = value.get_ref() else {
            return Err(self.wrong(key, &wanted, value.get_ref()));
        };
        if items.len() != N {
            return Err(
                self.fault(key, format!("`{}{key}` must be {wanted}, not of {}", self.path, items.len()))
            );
        }
        let mut numbers = [0.0; N];
        for (number, item) in numbers.iter_mut().zip(items.iter()) {
            *number = self.number(key, item.get_ref(), &range)?;
        }
        Ok(Some(numbers))
    }

    /// A list of numbers within `range`, if the key is there.
    ///
    /// # Errors
    /// The value is not a list of numbers, or one is outside the range.
    pub fn real_list(&self, key: &str, range: RangeInclusive<f64>) -> Result<Option<Vec<f64>>, Fault> {
        let Some(value) = self.ask(key) else { return Ok(None) };
        let DeValue::Array(items) = value.get_ref() else {
            return Err(self.wrong(key, "a list of numbers", value.get_ref()));
        };
        items.iter().map(|item| self.number(key, item.get_ref(), &range)).collect::<Result<_, _>>().map(Some)
    }

    /// A list of points `[x, y]`, if the key is there.
    ///
    /// # Errors
    /// The value is not a list of pairs of numbers.
    pub fn points(&self, key: &str, range: RangeInclusive<f64>) -> Result<Option<Vec<[f64; 2]>>, Fault> {
        let Some(value) = self.ask(key) else { return Ok(None) };
        let DeValue::Array(items) = value.get_ref() else {
            return Err(self.wrong(key, "a list of points [x, y]", value.get_ref()));
        };
        let mut points = Vec::with_capacity(items.len());
        for item in items.iter() {
            match item.get_ref() {
                DeValue::Array(pair) if pair.len() == 2 => points.push([
                    self.number(key, pair[0].get_ref(), &range)?,
                    self.number(key, pair[1].get_ref(), &range)?,
                ]),
                other => return Err(self.wrong(key, "a list of points [x, y]", other)),
            }
        }
        Ok(Some(points))
    }

    fn number(&self, key: &str, value: &DeValue<'_>, range: &RangeInclusive<f64>) -> Result<f64, Fault> {
        let number: f64 = match value {
            DeValue::Float(float) => float.as_str().parse().unwrap_or(f64::NAN),
            DeValue::Integer(whole) => {
                i64::from_str_radix(whole.as_str(), whole.radix()).map_or(f64::NAN, |n| n as f64)
            }
            other => return Err(self.wrong(key, "a number", other)),
        };
        if number.is_finite() && range.contains(&number) {
            Ok(number)
        } else {
            let message =
                format!("`{}{key}` is {number}, outside {} to {}", self.path, range.start(), range.end());
            Err(self.fault(key, message))
        }
    }

    /// A whole number within `range`, if the key is there.
    ///
    /// # Errors
    /// The value is not a whole number or outside the range.
    pub fn count(&self, key: &str, range: RangeInclusive<u32>) -> Result<Option<u32>, Fault> {
        let limits = f64::from(*range.start())..=f64::from(*range.end());
        match self.real(key, limits)? {
            None => Ok(None),
            Some(number) if number.fract() == 0.0 => Ok(Some(number as u32)),
            Some(number) => {
                Err(self.fault(key, format!("`{}{key}` must be a whole number, not {number}", self.path)))
            }
        }
    }

    /// A whole number of 64 bits, if the key is there.
    ///
    /// # Errors
    /// The value is not a whole number, negative or too large.
    pub fn whole(&self, key: &str) -> Result<Option<u64>, Fault> {
        let Some(value) = self.ask(key) else { return Ok(None) };
        let whole = match value.get_ref() {
            // Not through a real number, which has 53 bits.
            DeValue::Integer(whole) => u64::from_str_radix(whole.as_str(), whole.radix()).ok(),
            _ => None,
        };
        let wanted = "a whole number from 0 to 2^64 − 1";
        whole.map_or_else(
            || Err(self.fault(key, format!("`{}{key}` must be {wanted}", self.path))),
            |n| Ok(Some(n)),
        )
    }

    /// A list of texts, if the key is there.
    ///
    /// # Errors
    /// The value is not a list of texts.
    pub fn texts(&self, key: &str) -> Result<Option<Vec<String>>, Fault> {
        let Some(value) = self.ask(key) else { return Ok(None) };
        let DeValue::Array(items) = value.get_ref() else {
            return Err(self.wrong(key, "a list of texts", value.get_ref()));
        };
        items
            .iter()
            .map(|item| match item.get_ref() {
                DeValue::String(text) => Ok(text.clone().into_owned()),
                other => Err(self.wrong(key, "a list of texts", other)),
            })
            .collect::<Result<_, _>>()
            .map(Some)
    }

    /// A table inside this one, if the key is there; keys that `read` did not ask for are refused.
    ///
    /// # Errors
    /// The value is not a table, `read` found a fault, or a key is unknown.
    pub fn table<T>(
        &self,
        key: &str,
        read: impl FnOnce(&Table<'_>) -> Result<T, Fault>,
    ) -> Result<Option<T>, Fault> {
        let Some(value) = self.ask(key) else { return Ok(None) };
        self.inner(key, value, format!("{}{key}.", self.path), read).map(Some)
    }

    /// A list of tables, if the key is there; keys that `read` did not ask for are refused.
    ///
    /// # Errors
    /// The value is not a list of tables, `read` found a fault, or a key is unknown.
    pub fn tables<T>(
        &self,
        key: &str,
        mut read: impl FnMut(&Table<'_>) -> Result<T, Fault>,
    ) -> Result<Option<Vec<T>>, Fault> {
        let Some(value) = self.ask(key) else { return Ok(None) };
        let DeValue::Array(items) = value.get_ref() else {
            return Err(self.wrong(key, "a list of tables", value.get_ref()));
        };
        items
            .iter()
            .enumerate()
            .map(|(at, item)| {
                self.inner(key, item, format!("{}{key}[{}].", self.path, at + 1), |table| read(table))
            })
            .collect::<Result<_, _>>()
            .map(Some)
    }

    fn inner<T>(
        &self,
        key: &str,
        value: &'a Spanned<DeValue<'a>>,
        path: String,
        read: impl FnOnce(&Table<'_>) -> Result<T, Fault>,
    ) -> Result<T, Fault> {
        let DeValue::Table(entries) = value.get_ref() else {
            return Err(self.wrong(key, "a table", value.get_ref()));
        };
        let table = Table::new(entries, value.span(), path);
        let read = read(&table)?;
        table.finish()?;
        Ok(read)
    }

    /// The parameters that the table names, the rest at their defaults.
    ///
    /// # Errors
    /// A value is of the wrong kind or outside its row's hard range.
    pub fn parameters<P: Parameters>(&self) -> Result<P, Fault> {
        self.parameters_over(P::default())
    }

    /// The same over other values than the defaults.
    ///
    /// # Errors
    /// A value is of the wrong kind or outside its row's hard range.
    pub fn parameters_over<P: Parameters>(&self, mut parameters: P) -> Result<P, Fault> {
        for row in P::ROWS {
            let (low, high) = row.hard;
            let value = match row.default {
                Value::Real(_) => self.real(row.id, low..=high)?.map(Value::Real),
                Value::Count(_) => self.count(row.id, low as u32..=high as u32)?.map(Value::Count),
                Value::Span(_) => self.reals::<2>(row.id, low..=high)?.map(Value::Span),
            };
            if let Some(value) = value {
                parameters.set(row.id, value).map_err(|message| self.fault(row.id, message))?;
            }
        }
        Ok(parameters)
    }

    /// Refuses keys that were not asked for. It is done at the end by itself; sooner, an unknown key is said rather than what
    /// is missing for it.
    ///
    /// # Errors
    /// There is one.
    pub fn finish(&self) -> Result<(), Fault> {
        let asked = self.asked.borrow();
        let unknown = self
            .entries
            .iter()
            .map(|(key, _)| key)
            .filter(|key| !asked.iter().any(|known| known == key.get_ref().as_ref()))
            .min_by_key(|key| key.span().start);
        match unknown {
            None => Ok(()),
            Some(key) => {
                let name = key.get_ref().as_ref();
                let known: Vec<&str> = asked.iter().map(String::as_str).collect();
                Err(Fault {
                    message: format!("unknown key `{}{name}`", self.path),
                    hint: Some(hint_for(name, &known)),
                    span: key.span(),
                })
            }
        }
    }
}

fn article(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "text",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "a list",
        DeValue::Table(_) => "a table",
    }
}

#[cfg(test)]
mod tests;
