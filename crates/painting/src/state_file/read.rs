//! A state out of an archive of arrays: all headers first, then room for the state, then the values.

use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::slice::from_mut;

use girtin_grid::memory::probe;
use girtin_grid::{Field, Layout};
use girtin_wash::{Ledger, WashState};
use zip::ZipArchive;
use zip::read::ZipFile;
use zip::result::ZipError;

use super::npy::{self, Element, Header, HeaderFault};
use super::{Key, LedgerKey, StateFileError};

/// How large a state may be that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Cells of the canvas.
    pub cells: u64,
    /// Pigments.
    pub pigments: u64,
    /// Memory of all fields, bytes. Of paper that nothing touched it is only reserved.
    pub bytes: u64,
    /// Memory of what is not 0, bytes: about what the state really takes.
    pub touched_bytes: u64,
}

impl Default for Limits {
    /// 2^28 cells, 64 pigments, 16 GiB, all of them.
    fn default() -> Self {
        Self { cells: 1 << 28, pigments: 64, bytes: 16 << 30, touched_bytes: u64::MAX }
    }
}

/// Values that are decoded at once, bytes: a multiple of every value's size.
const CHUNK: usize = 64 << 10;

/// Values of a page of memory; as many zeros in a row are not written, so that their page stays untouched.
const PAGE: usize = 1024;

/// Deflate packs at most 1032 bytes into one; the rest is for the smallest arrays.
const MOST_PACKED: (u64, u64) = (1032, 1024);

/// Paper where a state does not say its height.
const HEIGHT: f32 = 0.5;

/// Cells a millimetre where a living wash does not say.
const CELLS_PER_MM: f64 = 4.0;

/// Reads a state, within the default [`Limits`].
///
/// # Errors
/// The file is no `.npz` archive of a state's arrays, is damaged or too large, or a value is not allowed.
pub fn read(reader: impl Read + Seek) -> Result<WashState, StateFileError> {
    read_within(reader, &Limits::default())
}

/// Reads a state no larger than `limits`.
///
/// # Errors
/// As [`read`].
///
/// # Cost
/// No memory is reserved before all headers are seen to agree with each other, with the limits and with the bytes
/// that are there.
pub fn read_within(reader: impl Read + Seek, limits: &Limits) -> Result<WashState, StateFileError> {
    let mut archive = open(reader)?;
    let (arrays, ledger) = arrays(&mut archive)?;
    let of = |key: Key| arrays.iter().find(|array| array.key == key);
    let mask = of(Key::WetMask).ok_or(StateFileError::NoWetMask)?;
    let [rows, columns] = canvas(mask, limits)?;
    let pigments = pigments(of(Key::Suspended), of(Key::Deposited), [rows, columns], limits)?;
    for array in &arrays {
        array.check_shape(pigments, [rows, columns])?;
        array.check_length()?;
    }
    let layout = Layout::new(columns, rows);
    // Every row with its border, and two or three rows more.
    let field_values = (rows as u64 + 3) * layout.stride() as u64;
    // The mask's bytes count like the other fields' values.
    let bytes = field_values * 4 * (6 + 2 * pigments as u64);
    let most = limits.bytes.min(isize::MAX as u64);
    if bytes > most {
        return Err(StateFileError::TooLarge { quantity: "bytes in memory", found: bytes, most });
    }

    let fields = std::iter::repeat_n(4 * field_values, 5 + 2 * pigments);
    probe(fields.chain([field_values]))?;
    let mut state = WashState::empty(layout, pigments);
    state.ledger = ledger;
    let mut room = Room(limits.touched_bytes);
    if of(Key::Height).is_none() {
        room.take(4 * rows as u64 * columns as u64).map_err(|_| memory(limits))?;
        for y in 0..rows {
            state.height.cells_mut(y).fill(HEIGHT);
        }
    }
    for array in &arrays {
        array.pour(&mut archive, &mut state, &mut room).map_err(|error| match error {
            StateFileError::Read(error) if error.kind() == io::ErrorKind::OutOfMemory => memory(limits),
            other => other,
        })?;
    }
    state.check()?;
    Ok(state)
}

fn memory(limits: &Limits) -> StateFileError {
    StateFileError::Memory { most: limits.touched_bytes }
}

/// Bytes that may still be written.
struct Room(u64);

impl Room {
    fn take(&mut self, bytes: u64) -> io::Result<()> {
        self.0 = self.0.checked_sub(bytes).ok_or(io::ErrorKind::OutOfMemory)?;
        Ok(())
    }
}

type Archive<R> = ZipArchive<BufReader<R>>;

fn open<R: Read + Seek>(reader: R) -> Result<Archive<R>, StateFileError> {
    let mut reader = BufReader::new(reader);
    let mut start = Vec::new();
    reader.by_ref().take(npy::MAGIC.len() as u64).read_to_end(&mut start).map_err(StateFileError::Read)?;
    if start == npy::MAGIC {
        return Err(StateFileError::OneArray);
    }
    if start.starts_with(b"\x89PNG") || start.starts_with(b"\xff\xd8") {
        return Err(StateFileError::NotNpz { why: "it is a picture".to_owned() });
    }
    reader.seek(SeekFrom::Start(0)).map_err(StateFileError::Read)?;
    let archive = ZipArchive::new(reader).map_err(|error| match error {
        ZipError::Io(error) if !is_damage(&error) => StateFileError::Read(error),
        // What the zip reader says of its own blocks helps no painter.
        ZipError::InvalidArchive(_) | ZipError::Io(_) => {
            StateFileError::NotNpz { why: "it is damaged, cut short or something else".to_owned() }
        }
        other => StateFileError::NotNpz { why: other.to_string() },
    })?;
    if archive.has_duplicate_names() {
        return Err(StateFileError::Duplicate);
    }
    Ok(archive)
}

/// Whether an error tells of the file's content and not of its medium.
fn is_damage(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::UnexpectedEof | io::ErrorKind::InvalidData | io::ErrorKind::InvalidInput
    )
}

fn unpack(key: &'static str) -> impl Fn(ZipError) -> StateFileError {
    move |error| match error {
        ZipError::Io(error) => unread(key, error),
        ZipError::InvalidArchive(why) => StateFileError::Unpack { key, why: why.into_owned() },
        other => StateFileError::Unpack { key, why: other.to_string() },
    }
}

fn unread(key: &'static str, error: io::Error) -> StateFileError {
    if error.kind() == io::ErrorKind::UnexpectedEof {
        StateFileError::Unpack { key, why: "it ends early".to_owned() }
    } else if is_damage(&error) {
        StateFileError::Unpack { key, why: error.to_string() }
    } else {
        StateFileError::Read(error)
    }
}

/// How an array's values are stored, if its type is one that `key` may have.
fn element_of(key: Key, descr: Option<&str>) -> Result<Element, StateFileError> {
    let is_mask = key == Key::WetMask;
    if let Some(element) =
        descr.and_then(Element::of).filter(|&element| (element == Element::Byte) == is_mask)
    {
        return Ok(element);
    }
    let name = key.name();
    let found = descr.map_or_else(|| "a structure".to_owned(), npy::type_name);
    let (wanted, kind) =
        if is_mask { ("bool or uint8", "bool") } else { ("float32 or float64", "'float32'") };
    let fix = match descr {
        None => format!("{name}['...'].astype({kind})"),
        _ if found == "object" => format!("np.array({name}.tolist(), dtype={kind})"),
        _ if is_mask && found.starts_with("float") => format!("({name} > 0.5).astype(bool)"),
        _ if !is_mask && found.starts_with("complex") => format!("{name}.real.astype('float32')"),
        _ => format!("{name}.astype({kind})"),
    };
    Err(StateFileError::Type { key: name, found, wanted, fix })
}

/// An array of the file, of which the header has been read.
struct Array {
    key: Key,
    /// Its place in the archive.
    index: usize,
    header: Header,
    element: Element,
    /// Bytes that the archive claims for it, header included.
    size: u64,
}

/// Reads the headers of all arrays, and the numbers of a living wash if there are any.
fn arrays<R: Read + Seek>(archive: &mut Archive<R>) -> Result<(Vec<Array>, Option<Ledger>), StateFileError> {
    let entries = archive.file_names_raw().map(Entry::named).collect::<Result<Vec<_>, _>>()?;
    let mut arrays = Vec::new();
    let mut ledger = None;
    for (index, entry) in entries.into_iter().enumerate() {
        let key = match entry {
            Entry::Array(key) => key,
            Entry::Number(key) => {
                let number = number(archive, index, key.name())?;
                *key.of(ledger.get_or_insert(Ledger::new(CELLS_PER_MM))) = number;
                continue;
            }
        };
        let name = key.name();
        let mut file = archive.by_index(index).map_err(unpack(name))?;
        let header = npy::read_header(&mut file).map_err(header_fault(name))?;
        let element = element_of(key, header.descr.as_deref())?;
        let (size, packed) = (file.size(), file.compressed_size());
        // A later read would fail on the size; but room is made before that.
        if size > packed.saturating_mul(MOST_PACKED.0).saturating_add(MOST_PACKED.1) {
            let why = format!("{packed} packed bytes cannot hold {size}");
            return Err(StateFileError::Unpack { key: name, why });
        }
        arrays.push(Array { key, index, header, element, size });
    }
    Ok((arrays, ledger))
}

/// Reads an array that is one number.
fn number<R: Read + Seek>(
    archive: &mut Archive<R>,
    index: usize,
    name: &'static str,
) -> Result<f64, StateFileError> {
    let mut file = archive.by_index(index).map_err(unpack(name))?;
    let header = npy::read_header(&mut file).map_err(header_fault(name))?;
    if header.shape.iter().any(|&axis| axis != 1) {
        let found = header.shape.clone();
        return Err(StateFileError::Shape {
            key: name,
            found,
            wanted: "(), one number".to_owned(),
            fix: None,
        });
    }
    let descr = header.descr.as_deref();
    let element = descr.and_then(Element::of).filter(|&element| element != Element::Byte);
    let element = element.ok_or_else(|| {
        let found = descr.map_or_else(|| "a structure".to_owned(), npy::type_name);
        StateFileError::Type { key: name, found, wanted: "float64", fix: format!("np.float64({name})") }
    })?;
    let mut bytes = [0; 8];
    let bytes = &mut bytes[..element.bytes()];
    file.read_exact(bytes).map_err(|error| unread(name, error))?;
    let number = element.number(bytes);
    end(&mut file).map_err(|error| unread(name, error))?;
    Ok(number)
}

fn header_fault(name: &'static str) -> impl Fn(HeaderFault) -> StateFileError {
    move |fault| match fault {
        HeaderFault::Read(error) => unread(name, error),
        HeaderFault::Malformed(why) => StateFileError::Header { key: name, why },
    }
}

/// An entry of the archive.
#[derive(Clone, Copy)]
enum Entry {
    Array(Key),
    Number(LedgerKey),
}

impl Entry {
    fn named(entry: &[u8]) -> Result<Self, StateFileError> {
        let stem = entry.strip_suffix(b".npy");
        let is_called = |name: &str| stem == Some(name.as_bytes());
        let array = Key::ALL.into_iter().find(|key| is_called(key.name())).map(Self::Array);
        let number = LedgerKey::ALL.into_iter().find(|key| is_called(key.name())).map(Self::Number);
        array.or(number).ok_or_else(|| {
            // Printable and short, whatever the file says.
            let name = stem.unwrap_or(entry);
            StateFileError::UnknownKey { name: name[..name.len().min(60)].escape_ascii().to_string() }
        })
    }
}

/// Rows and columns of the canvas, from the wet mask.
fn canvas(mask: &Array, limits: &Limits) -> Result<[usize; 2], StateFileError> {
    let key = mask.key.name();
    let found = mask.header.shape.clone();
    let &[rows, columns] = found.as_slice() else {
        return Err(StateFileError::Shape { key, found, wanted: "(rows, columns)".to_owned(), fix: None });
    };
    if rows == 0 || columns == 0 {
        return Err(StateFileError::Empty { key, found });
    }
    // Whatever the limits say, what is computed from rows and columns below must not overflow.
    let most = limits.cells.min(1 << 40).min(isize::MAX as u64 / 1024);
    let cells = rows.saturating_mul(columns);
    if cells > most {
        return Err(StateFileError::TooLarge { quantity: "cells", found: cells, most });
    }
    // Lossless: both are at most `most`.
    Ok([rows as usize, columns as usize])
}

/// The number of pigments, from whichever pigment array there is.
fn pigments(
    suspended: Option<&Array>,
    deposited: Option<&Array>,
    canvas: [usize; 2],
    limits: &Limits,
) -> Result<usize, StateFileError> {
    let count = |array: Option<&Array>| match array {
        None => Ok(None),
        Some(array) => match *array.header.shape.as_slice() {
            // An array of another canvas has the pigments on another axis, perhaps: its shape is what is wrong.
            [pigments, rows, columns] if [rows, columns] == canvas.map(|axis| axis as u64) => {
                Ok(Some(pigments))
            }
            _ => Err(array.wrong_shape(None, canvas)),
        },
    };
    let pigments = match (count(suspended)?, count(deposited)?) {
        (Some(suspended), Some(deposited)) if suspended != deposited => {
            return Err(StateFileError::Pigments { suspended, deposited });
        }
        (one, other) => one.or(other).unwrap_or(0),
    };
    if let Some(array) = suspended.or(deposited).filter(|_| pigments == 0) {
        return Err(StateFileError::Empty { key: array.key.name(), found: array.header.shape.clone() });
    }
    let most = limits.pigments.min(1 << 16);
    if pigments > most {
        return Err(StateFileError::TooLarge { quantity: "pigments", found: pigments, most });
    }
    Ok(pigments as usize)
}

impl Array {
    /// Pigments, rows and columns that the array must have; one plane if it is not of pigments.
    fn planes_rows_columns(&self, pigments: usize, [rows, columns]: [usize; 2]) -> [usize; 3] {
        let [rows, columns] = self.key.rows_and_columns(rows, columns);
        [if self.key.is_of_pigments() { pigments } else { 1 }, rows, columns]
    }

    fn check_shape(&self, pigments: usize, canvas: [usize; 2]) -> Result<(), StateFileError> {
        let wanted = self.planes_rows_columns(pigments, canvas).map(|axis| axis as u64);
        let wanted = if self.key.is_of_pigments() { &wanted[..] } else { &wanted[1..] };
        if self.header.shape == wanted { Ok(()) } else { Err(self.wrong_shape(Some(pigments), canvas)) }
    }

    fn wrong_shape(&self, pigments: Option<usize>, canvas: [usize; 2]) -> StateFileError {
        let key = self.key.name();
        let found = self.header.shape.clone();
        let [rows, columns] = self.key.rows_and_columns(canvas[0], canvas[1]).map(|axis| axis as u64);
        let cells = canvas.map(|axis| axis as u64);
        let pigments = pigments.map_or_else(|| "pigments".to_owned(), |pigments| pigments.to_string());
        let wanted = match self.key.is_of_pigments() {
            true => format!("({pigments}, {rows}, {columns})"),
            false => format!("({rows}, {columns})"),
        };
        let fix = match (self.key, found.as_slice()) {
            (Key::Suspended | Key::Deposited, &[y, x]) if [y, x] == cells => {
                Some(format!("a single pigment is `{key}[None]`"))
            }
            (Key::Suspended | Key::Deposited, &[y, x, _]) if [y, x] == cells => {
                Some(format!("the pigments are the first axis: `np.moveaxis({key}, -1, 0)`"))
            }
            (Key::U, &[y, x]) if [y, x] == cells => {
                Some("u is on the faces between columns, one more than cells".to_owned())
            }
            (Key::V, &[y, x]) if [y, x] == cells => {
                Some("v is on the faces between rows, one more than cells".to_owned())
            }
            (_, &[x, y]) if [y, x] == [rows, columns] => Some(format!("rows come first: `{key}.T`")),
            _ => None,
        };
        StateFileError::Shape { key, found, wanted, fix }
    }

    /// Compares the bytes that are there with those that the shape asks for.
    fn check_length(&self) -> Result<(), StateFileError> {
        let values = self.header.shape.iter().try_fold(1u64, |all, &axis| all.checked_mul(axis));
        let wanted = values
            .and_then(|values| values.checked_mul(self.element.bytes() as u64))
            .and_then(|bytes| bytes.checked_add(self.header.bytes))
            .unwrap_or(u64::MAX);
        if self.size == wanted {
            Ok(())
        } else {
            Err(StateFileError::Length { key: self.key.name(), found: self.size, wanted })
        }
    }

    /// Reads the values into the state's field.
    fn pour<R: Read + Seek>(
        &self,
        archive: &mut Archive<R>,
        state: &mut WashState,
        room: &mut Room,
    ) -> Result<(), StateFileError> {
        let name = self.key.name();
        let mut file = archive.by_index(self.index).map_err(unpack(name))?;
        self.pour_file(&mut file, state, room).map_err(|error| unread(name, error))
    }

    fn pour_file<R: Read>(
        &self,
        file: &mut ZipFile<'_, R>,
        state: &mut WashState,
        room: &mut Room,
    ) -> io::Result<()> {
        io::copy(&mut file.take(self.header.bytes), &mut io::sink())?;
        let layout = state.layout();
        let mut pour = Pour {
            room,
            fortran_order: self.header.fortran_order,
            shape: self.planes_rows_columns(state.suspended.len(), [layout.height(), layout.width()]),
        };
        let fields = match self.key {
            Key::WetMask => {
                let copy = |bytes: &[u8], values: &mut Vec<u8>| values.extend(bytes);
                pour.values(file, from_mut(&mut state.wet_mask), self.element.bytes(), copy)?;
                return end(file);
            }
            Key::Height => from_mut(&mut state.height),
            Key::U => from_mut(&mut state.u),
            Key::V => from_mut(&mut state.v),
            Key::Pressure => from_mut(&mut state.pressure),
            Key::Saturation => from_mut(&mut state.saturation),
            Key::Suspended => &mut state.suspended,
            Key::Deposited => &mut state.deposited,
        };
        let decode = |bytes: &[u8], values: &mut Vec<f32>| self.element.decode(bytes, values);
        pour.values(file, fields, self.element.bytes(), decode)?;
        end(file)
    }
}

/// Reads past the last value, where the archive's checksum is compared.
fn end(file: &mut impl Read) -> io::Result<()> {
    if file.read(&mut [0])? == 0 { Ok(()) } else { Err(io::ErrorKind::InvalidData.into()) }
}

/// A value of a field.
trait Value: Copy {
    /// Whether all bits are 0, as in a fresh field; −0 is not.
    fn is_blank(self) -> bool;
}

impl Value for f32 {
    fn is_blank(self) -> bool {
        self.to_bits() == 0
    }
}

impl Value for u8 {
    fn is_blank(self) -> bool {
        self == 0
    }
}

/// Values on their way into fields.
struct Pour<'a> {
    room: &'a mut Room,
    fortran_order: bool,
    /// Planes, rows, columns.
    shape: [usize; 3],
}

impl Pour<'_> {
    /// `decode` appends the values of a whole number of elements of `size` bytes.
    fn values<T: Value>(
        &mut self,
        reader: &mut impl Read,
        fields: &mut [Field<T>],
        size: usize,
        decode: impl Fn(&[u8], &mut Vec<T>),
    ) -> io::Result<()> {
        let mut left: usize = self.shape.iter().product();
        let mut at = [0; 3];
        let mut bytes = vec![0; CHUNK.min(left * size)];
        let mut values = Vec::with_capacity(bytes.len() / size);
        while left > 0 {
            let count = left.min(CHUNK / size);
            reader.read_exact(&mut bytes[..count * size])?;
            values.clear();
            decode(&bytes[..count * size], &mut values);
            at = if self.fortran_order {
                self.scatter(&values, fields, at)?
            } else {
                self.copy(&values, fields, at)?
            };
            left -= count;
        }
        Ok(())
    }

    /// Columns run fastest. Returns the place after the last value.
    fn copy<T: Value>(
        &mut self,
        values: &[T],
        fields: &mut [Field<T>],
        at: [usize; 3],
    ) -> io::Result<[usize; 3]> {
        let [_, rows, columns] = self.shape;
        let [mut plane, mut y, mut x] = at;
        let mut rest = values;
        while !rest.is_empty() {
            let (run, after) = rest.split_at(rest.len().min(columns - x).min(PAGE));
            if !run.iter().fold(true, |blank, value| blank & value.is_blank()) {
                self.room.take(size_of_val(run) as u64)?;
                fields[plane].row_mut(Layout::TOP + y)[Layout::LEFT + x..][..run.len()].copy_from_slice(run);
            }
            x += run.len();
            if x == columns {
                (x, y) = (0, y + 1);
            }
            if y == rows {
                (y, plane) = (0, plane + 1);
            }
            rest = after;
        }
        Ok([plane, y, x])
    }

    /// Planes run fastest, columns slowest. Returns the place after the last value.
    fn scatter<T: Value>(
        &mut self,
        values: &[T],
        fields: &mut [Field<T>],
        at: [usize; 3],
    ) -> io::Result<[usize; 3]> {
        let [planes, rows, _] = self.shape;
        let [mut plane, mut y, mut x] = at;
        for &value in values {
            if !value.is_blank() {
                self.room.take(size_of::<T>() as u64)?;
                fields[plane].row_mut(Layout::TOP + y)[Layout::LEFT + x] = value;
            }
            plane += 1;
            if plane == planes {
                (plane, y) = (0, y + 1);
            }
            if y == rows {
                (y, x) = (0, x + 1);
            }
        }
        Ok([plane, y, x])
    }
}
