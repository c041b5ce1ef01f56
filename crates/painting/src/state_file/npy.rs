//! An `.npy` array: its header, which is type, order and shape, and how its values are decoded.

use std::io::{self, Read};

/// What every array begins with.
pub(crate) const MAGIC: &[u8; 6] = b"\x93NUMPY";

/// Longest text of a header that is read, bytes. NumPy's own for plain arrays have about 120.
const MAX_TEXT: usize = 64 << 10;

/// Most axes that are read: NumPy's own limit was 32 for twenty years.
const MAX_AXES: usize = 32;

/// The header of an array.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Header {
    /// NumPy's code of the type, such as `<f4`; `None` if the type is a structure, whose shape is not read then.
    pub descr: Option<String>,
    /// Whether the first axis runs fastest.
    pub fortran_order: bool,
    /// Lengths of the axes.
    pub shape: Vec<u64>,
    /// Bytes from the magic to the first value.
    pub bytes: u64,
}

/// Why there is no header.
#[derive(Debug)]
pub(crate) enum HeaderFault {
    Read(io::Error),
    Malformed(String),
}

impl From<io::Error> for HeaderFault {
    fn from(error: io::Error) -> Self {
        Self::Read(error)
    }
}

fn malformed<T>(why: impl Into<String>) -> Result<T, HeaderFault> {
    Err(HeaderFault::Malformed(why.into()))
}

/// Reads a header of version 1, 2 or 3 up to the first value.
pub(crate) fn read_header(reader: &mut impl Read) -> Result<Header, HeaderFault> {
    let mut start = [0; 8];
    reader.read_exact(&mut start)?;
    if &start[..6] != MAGIC {
        return malformed("it does not begin as an array of NumPy");
    }
    let (length, length_bytes) = match start[6..] {
        [1, 0] => {
            let mut length = [0; 2];
            reader.read_exact(&mut length)?;
            (usize::from(u16::from_le_bytes(length)), 2)
        }
        [2 | 3, 0] => {
            let mut length = [0; 4];
            reader.read_exact(&mut length)?;
            (usize::try_from(u32::from_le_bytes(length)).unwrap_or(usize::MAX), 4)
        }
        [major, minor] => return malformed(format!("its version {major}.{minor} is not known")),
        _ => return malformed("it has no version"),
    };
    if length > MAX_TEXT {
        return malformed(format!("it has {length} bytes; {MAX_TEXT} at most are read"));
    }
    let mut text = vec![0; length];
    reader.read_exact(&mut text)?;
    let (descr, fortran_order, shape) = Text { rest: &text }.dictionary()?;
    Ok(Header { descr, fortran_order, shape, bytes: (start.len() + length_bytes + length) as u64 })
}

/// The text of a header: a Python dictionary of three known keys. What is not read is an error; nothing nests.
struct Text<'a> {
    rest: &'a [u8],
}

impl Text<'_> {
    fn dictionary(mut self) -> Result<(Option<String>, bool, Vec<u64>), HeaderFault> {
        let (mut descr, mut order, mut shape) = (None, None, None);
        self.expect(b'{')?;
        while !self.take(b'}') {
            let key = self.string()?;
            self.expect(b':')?;
            let twice = match key.as_str() {
                "descr" => {
                    if matches!(self.peek(), Some(b'[' | b'(')) {
                        return Ok((None, false, Vec::new()));
                    }
                    descr.replace(self.string()?).is_some()
                }
                "fortran_order" => order.replace(self.truth()?).is_some(),
                "shape" => shape.replace(self.shape()?).is_some(),
                other => return malformed(format!("it has the unknown key `{other}`")),
            };
            if twice {
                return malformed(format!("it has `{key}` twice"));
            }
            if !self.take(b',') {
                self.expect(b'}')?;
                break;
            }
        }
        if self.peek().is_some() {
            return malformed("it goes on after its end");
        }
        match (descr, order, shape) {
            (Some(descr), Some(order), Some(shape)) => Ok((Some(descr), order, shape)),
            _ => malformed("it lacks `descr`, `fortran_order` or `shape`"),
        }
    }

    /// The next byte that is not space.
    fn peek(&mut self) -> Option<u8> {
        self.rest = self.rest.trim_ascii_start();
        self.rest.first().copied()
    }

    fn take(&mut self, byte: u8) -> bool {
        let found = self.peek() == Some(byte);
        if found {
            self.rest = &self.rest[1..];
        }
        found
    }

    fn expect(&mut self, byte: u8) -> Result<(), HeaderFault> {
        if self.take(byte) { Ok(()) } else { malformed(format!("it lacks a `{}`", char::from(byte))) }
    }

    /// A short text in quotes, without escapes: NumPy writes none.
    fn string(&mut self) -> Result<String, HeaderFault> {
        let Some(quote @ (b'\'' | b'"')) = self.peek() else {
            return malformed("it lacks a text in quotes");
        };
        let inside = &self.rest[1..];
        match inside.iter().position(|&byte| byte == quote) {
            Some(end) if end <= 64 && inside[..end].iter().all(|&byte| is_plain(byte)) => {
                self.rest = &inside[end + 1..];
                Ok(inside[..end].iter().copied().map(char::from).collect())
            }
            _ => malformed("it has a text that is not plain"),
        }
    }

    fn truth(&mut self) -> Result<bool, HeaderFault> {
        self.peek();
        for (word, truth) in [(b"True".as_slice(), true), (b"False", false)] {
            if let Some(rest) = self.rest.strip_prefix(word) {
                self.rest = rest;
                return Ok(truth);
            }
        }
        malformed("its `fortran_order` is neither True nor False")
    }

    fn shape(&mut self) -> Result<Vec<u64>, HeaderFault> {
        let mut shape = Vec::new();
        self.expect(b'(')?;
        while !self.take(b')') {
            if shape.len() == MAX_AXES {
                return malformed(format!("it has more than {MAX_AXES} axes"));
            }
            shape.push(self.whole_number()?);
            if !self.take(b',') {
                self.expect(b')')?;
                if shape.len() == 1 {
                    return malformed("its `shape` is a number, not a tuple");
                }
                break;
            }
        }
        Ok(shape)
    }

    fn whole_number(&mut self) -> Result<u64, HeaderFault> {
        self.peek();
        let digits = self.rest.iter().take_while(|byte| byte.is_ascii_digit()).count();
        let (number, rest) = self.rest.split_at(digits);
        let number = number
            .iter()
            .try_fold(0u64, |number, digit| number.checked_mul(10)?.checked_add(u64::from(digit - b'0')));
        // Python 2 wrote long numbers with an L.
        self.rest = rest.strip_prefix(b"L").unwrap_or(rest);
        match number {
            Some(number) if digits > 0 => Ok(number),
            _ => malformed("its `shape` has an axis that is no length"),
        }
    }
}

fn is_plain(byte: u8) -> bool {
    (byte == b' ' || byte.is_ascii_graphic()) && byte != b'\\'
}

/// How a value is stored, of the types that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Element {
    /// A truth value or a small whole number.
    Byte,
    F32 {
        big_endian: bool,
    },
    F64 {
        big_endian: bool,
    },
}

impl Element {
    /// By NumPy's code of the type; `None` if values of that type are not read.
    pub fn of(descr: &str) -> Option<Self> {
        // A plain `=` is the writer's own order; NumPy resolves it, and of the rest most are little-endian.
        Some(match descr {
            "|b1" | "b1" | "|u1" | "<u1" | ">u1" | "=u1" | "u1" => Self::Byte,
            "<f4" | "=f4" | "f4" => Self::F32 { big_endian: false },
            ">f4" => Self::F32 { big_endian: true },
            "<f8" | "=f8" | "f8" => Self::F64 { big_endian: false },
            ">f8" => Self::F64 { big_endian: true },
            _ => return None,
        })
    }

    /// Bytes of a value.
    pub fn bytes(self) -> usize {
        match self {
            Self::Byte => 1,
            Self::F32 { .. } => 4,
            Self::F64 { .. } => 8,
        }
    }

    /// Appends the values of a whole number of elements.
    pub fn decode(self, bytes: &[u8], values: &mut Vec<f32>) {
        fn each<const N: usize>(bytes: &[u8], values: &mut Vec<f32>, value: impl Fn([u8; N]) -> f32) {
            values.extend(bytes.as_chunks::<N>().0.iter().map(|&bytes| value(bytes)));
        }
        match self {
            Self::Byte => each(bytes, values, |[byte]| f32::from(byte)),
            Self::F32 { big_endian: false } => each(bytes, values, f32::from_le_bytes),
            Self::F32 { big_endian: true } => each(bytes, values, f32::from_be_bytes),
            Self::F64 { big_endian: false } => each(bytes, values, |b| f64::from_le_bytes(b) as f32),
            Self::F64 { big_endian: true } => each(bytes, values, |b| f64::from_be_bytes(b) as f32),
        }
    }

    /// The value of one element, in full; 0 if it is none.
    pub fn number(self, bytes: &[u8]) -> f64 {
        fn of<const N: usize>(bytes: &[u8], number: impl Fn([u8; N]) -> f64) -> f64 {
            bytes.first_chunk().map_or(0.0, |&bytes| number(bytes))
        }
        match self {
            Self::Byte => of(bytes, |[byte]| f64::from(byte)),
            Self::F32 { big_endian: false } => of(bytes, |b| f64::from(f32::from_le_bytes(b))),
            Self::F32 { big_endian: true } => of(bytes, |b| f64::from(f32::from_be_bytes(b))),
            Self::F64 { big_endian: false } => of(bytes, f64::from_le_bytes),
            Self::F64 { big_endian: true } => of(bytes, f64::from_be_bytes),
        }
    }
}

/// The header of an array in C order, version 1, padded so that the values begin at a multiple of 64 bytes.
pub(crate) fn header(descr: &str, shape: &[usize]) -> Vec<u8> {
    /// Magic, version and length.
    const BEFORE: usize = 10;
    let axes: String = shape.iter().map(|axis| format!("{axis}, ")).collect();
    let mut text =
        format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({}), }}", axes.trim_end());
    let padding = (BEFORE + text.len() + 1).next_multiple_of(64) - (BEFORE + text.len() + 1);
    text.extend(std::iter::repeat_n(' ', padding));
    text.push('\n');
    let mut bytes = MAGIC.to_vec();
    bytes.extend([1, 0]);
    // At most three axes of 20 digits: never near 64 KiB.
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes
}

/// NumPy's name of a type, from its code.
pub(crate) fn type_name(descr: &str) -> String {
    let code = descr.trim_start_matches(['<', '>', '|', '=']);
    let size = code.get(1..).and_then(|size| size.parse::<u32>().ok()).filter(|&size| size <= 64);
    match (code.as_bytes().first(), size) {
        (Some(b'b'), Some(1)) => "bool".to_owned(),
        (Some(b'i'), Some(size)) => format!("int{}", 8 * size),
        (Some(b'u'), Some(size)) => format!("uint{}", 8 * size),
        (Some(b'f'), Some(size)) => format!("float{}", 8 * size),
        (Some(b'c'), Some(size)) => format!("complex{}", 8 * size),
        (Some(b'O'), _) => "object".to_owned(),
        (Some(b'S' | b'U' | b'a'), _) => "text".to_owned(),
        (Some(b'M'), _) => "datetime64".to_owned(),
        (Some(b'm'), _) => "timedelta64".to_owned(),
        (Some(b'V'), _) => "void".to_owned(),
        _ => format!("of the unknown type `{descr}`"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn with_text(major: u8, text: &str) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend([major, 0]);
        match major {
            1 => bytes.extend((text.len() as u16).to_le_bytes()),
            _ => bytes.extend((text.len() as u32).to_le_bytes()),
        }
        bytes.extend(text.as_bytes());
        bytes
    }

    fn parse(text: &str) -> Result<Header, String> {
        read_header(&mut with_text(1, text).as_slice()).map_err(|fault| match fault {
            HeaderFault::Read(error) => error.to_string(),
            HeaderFault::Malformed(why) => why,
        })
    }

    #[test]
    fn what_is_written_is_read() {
        for shape in [vec![], vec![7], vec![2, 3], vec![12, 2048, 2049]] {
            let bytes = header("<f4", &shape);
            assert_eq!(bytes.len() % 64, 0);
            let read = read_header(&mut bytes.as_slice()).unwrap();
            assert_eq!(read.descr.as_deref(), Some("<f4"));
            assert!(!read.fortran_order);
            assert_eq!(read.shape, shape.iter().map(|&axis| axis as u64).collect::<Vec<_>>());
            assert_eq!(read.bytes, bytes.len() as u64);
        }
    }

    #[test]
    fn all_versions_and_any_order_of_keys_are_read() {
        let text = "{\"shape\":(2L,3),'fortran_order' : True,\n 'descr':'>f8'}  \n";
        for major in [1, 2, 3] {
            let header = read_header(&mut with_text(major, text).as_slice()).unwrap();
            assert_eq!((header.descr.as_deref(), header.fortran_order), (Some(">f8"), true));
            assert_eq!(header.shape, [2, 3]);
        }
        assert!(read_header(&mut with_text(4, text).as_slice()).is_err());
    }

    #[test]
    fn structures_are_told_apart_without_reading_them() {
        let header =
            parse("{'descr': [('a', [('b', '<f4')])], 'fortran_order': False, 'shape': (3,), }").unwrap();
        assert_eq!(header.descr, None);
    }

    #[test]
    fn values_are_decoded_in_either_order_of_bytes() {
        let decoded = |descr: &str, bytes: &[u8]| {
            let mut values = Vec::new();
            Element::of(descr).unwrap().decode(bytes, &mut values);
            values
        };
        assert_eq!(decoded("|b1", &[0, 1]), [0.0, 1.0]);
        assert_eq!(decoded("<f4", &0.3f32.to_le_bytes()), [0.3]);
        assert_eq!(decoded(">f4", &0.3f32.to_be_bytes()), [0.3]);
        assert_eq!(decoded("f8", &0.3f64.to_le_bytes()), [0.3]);
        assert_eq!(decoded(">f8", &0.3f64.to_be_bytes()), [0.3]);
        assert_eq!(Element::of(">f8").unwrap().number(&0.3f64.to_be_bytes()), 0.3);
        assert_eq!(Element::of("<f4").unwrap().number(&0.5f32.to_le_bytes()), 0.5);
        for other in ["<i4", "<f2", "<c8", "|O", "<U3", ""] {
            assert_eq!(Element::of(other), None, "{other}");
        }
    }

    #[test]
    fn malformed_texts_are_refused() {
        let full = "{'descr': '<f4', 'fortran_order': False, 'shape': (3, 4), }";
        assert!(parse(full).is_ok());
        for cut in 0..full.len() {
            assert!(parse(&full[..cut]).is_err(), "{}", &full[..cut]);
        }
        for bad in [
            "{'descr': '<f4', 'fortran_order': False, 'shape': (3), }",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (-3, 4), }",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (3.0, 4), }",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (18446744073709551616, 4), }",
            "{'descr': '<f4', 'fortran_order': 0, 'shape': (3, 4), }",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (3, 4), 'shape': (3, 4), }",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (3, 4), 'more': 1}",
            "{'descr': '<f\\x34', 'fortran_order': False, 'shape': (3, 4), }",
            "{'descr': '<f4', 'fortran_order': False, 'shape': (3, 4), } + 1",
        ] {
            assert!(parse(bad).is_err(), "{bad}");
        }
        let deep = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {}", "(".repeat(60_000));
        assert!(parse(&deep).is_err());
    }

    #[test]
    fn a_claimed_length_is_not_believed() {
        let mut bytes = MAGIC.to_vec();
        bytes.extend([2, 0]);
        bytes.extend(u32::MAX.to_le_bytes());
        assert!(matches!(read_header(&mut bytes.as_slice()), Err(HeaderFault::Malformed(_))));
    }

    proptest! {
        #[test]
        fn no_text_makes_the_parser_panic(
            text in "\\{?('(descr|shape|fortran_order|x)' ?: ?('[<>|=]?[a-zO][0-9]{0,3}'|True|\\([0-9L, ]{0,30}\\)|\\[),? ?){0,4}\\}?\\PC{0,8}"
        ) {
            let _ = parse(&text);
            let _ = type_name(&text);
        }
    }
}
