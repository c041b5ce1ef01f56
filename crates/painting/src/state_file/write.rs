//! A state into an archive of arrays, as a stream.

use std::io::{self, BufWriter, Write};
use std::slice::from_ref;

use girtin_grid::{Field, Layout};
use girtin_wash::{StateError, WashState};
use zip::ZipWriter;

use crate::archive::{self, Guarded};

use super::{Key, LedgerKey, StateFileError, npy};

/// Bytes that are handed on at once.
const BUFFER: usize = 256 << 10;

/// Writes a state; equal states give equal bytes on every system.
///
/// # Errors
/// The state would be refused on reading, or the writer fails. On failure the file is not complete.
pub fn write(state: &WashState, writer: impl Write) -> Result<(), StateFileError> {
    check(state)?;
    let mut zip = ZipWriter::new_stream(Guarded::new(BufWriter::with_capacity(BUFFER, writer)));
    let packed = |error| StateFileError::Write(archive::fault(error));
    let layout = state.layout();
    let pigments = state.suspended.len();
    for key in Key::ALL {
        if key.is_of_pigments() && pigments == 0 {
            continue;
        }
        let [rows, columns] = key.rows_and_columns(layout.height(), layout.width());
        let shape = if key.is_of_pigments() { &[pigments, rows, columns][..] } else { &[rows, columns] };
        let (descr, value_bytes) = if key == Key::WetMask { ("|u1", 1) } else { ("<f4", 4) };
        let header = npy::header(descr, shape);
        let values = shape.iter().map(|&axis| axis as u64).product::<u64>();
        let bytes = header.len() as u64 + value_bytes * values;
        zip.start_file(format!("{}.npy", key.name()), archive::stored(bytes)).map_err(packed)?;
        zip.write_all(&header)
            .and_then(|()| match key {
                Key::WetMask => {
                    write_rows(&mut zip, from_ref(&state.wet_mask), [rows, columns], |&wet| [wet])
                }
                Key::Height => write_floats(&mut zip, from_ref(&state.height), [rows, columns]),
                Key::U => write_floats(&mut zip, from_ref(&state.u), [rows, columns]),
                Key::V => write_floats(&mut zip, from_ref(&state.v), [rows, columns]),
                Key::Pressure => write_floats(&mut zip, from_ref(&state.pressure), [rows, columns]),
                Key::Saturation => write_floats(&mut zip, from_ref(&state.saturation), [rows, columns]),
                Key::Suspended => write_floats(&mut zip, &state.suspended, [rows, columns]),
                Key::Deposited => write_floats(&mut zip, &state.deposited, [rows, columns]),
            })
            .map_err(StateFileError::Write)?;
    }
    if let Some(mut ledger) = state.ledger {
        for key in LedgerKey::ALL {
            let header = npy::header("<f8", &[]);
            let number = key.of(&mut ledger).to_le_bytes();
            zip.start_file(format!("{}.npy", key.name()), archive::stored(header.len() as u64 + 8))
                .map_err(packed)?;
            zip.write_all(&header).and_then(|()| zip.write_all(&number)).map_err(StateFileError::Write)?;
        }
    }
    zip.finish().map_err(packed)?.into_inner().flush().map_err(StateFileError::Write)
}

/// Refuses what could not be read again.
fn check(state: &WashState) -> Result<(), StateFileError> {
    let layout = state.layout();
    if layout.width() == 0 || layout.height() == 0 {
        let found = vec![layout.height() as u64, layout.width() as u64];
        return Err(StateFileError::Empty { key: Key::WetMask.name(), found });
    }
    let (suspended, deposited) = (state.suspended.len() as u64, state.deposited.len() as u64);
    if suspended != deposited {
        return Err(StateFileError::Pigments { suspended, deposited });
    }
    state.check().map_err(|error: StateError| error.into())
}

fn write_floats(writer: &mut impl Write, fields: &[Field<f32>], shape: [usize; 2]) -> io::Result<()> {
    write_rows(writer, fields, shape, |value| value.to_le_bytes())
}

fn write_rows<T: Copy, const N: usize>(
    writer: &mut impl Write,
    fields: &[Field<T>],
    [rows, columns]: [usize; 2],
    encode: impl Fn(&T) -> [u8; N],
) -> io::Result<()> {
    let mut bytes = Vec::with_capacity(BUFFER);
    for field in fields {
        for y in 0..rows {
            let row = &field.row(Layout::TOP + y)[Layout::LEFT..][..columns];
            // Narrow rows are gathered, wide ones cut: the archive's checksum likes pieces of one size.
            for piece in row.chunks(BUFFER / 8) {
                if bytes.len() + piece.len() * N > BUFFER {
                    writer.write_all(&bytes)?;
                    bytes.clear();
                }
                bytes.extend(piece.iter().flat_map(&encode));
            }
        }
    }
    writer.write_all(&bytes)
}
