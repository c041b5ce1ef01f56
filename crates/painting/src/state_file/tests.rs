use std::io::{self, Cursor, Write};

use girtin_grid::{Field, Layout};
use girtin_wash::WashState;
use proptest::prelude::*;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::*;

/// Bytes of an array with any header.
fn npy(descr: &str, fortran_order: bool, shape: &str, values: &[u8]) -> Vec<u8> {
    let order = if fortran_order { "True" } else { "False" };
    let text = format!("{{'descr': {descr}, 'fortran_order': {order}, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\0".to_vec();
    bytes.extend((text.len() as u16).to_le_bytes());
    bytes.extend(text.as_bytes());
    bytes.extend(values);
    bytes
}

/// Bytes of a float32 array.
fn floats(shape: &str, values: &[f32]) -> Vec<u8> {
    npy("'<f4'", false, shape, &values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>())
}

/// A wet mask of 2 rows and 3 columns.
fn mask() -> Vec<u8> {
    npy("'|b1'", false, "(2, 3)", &[0, 1, 1, 0, 0, 1])
}

fn npz_packed(arrays: &[(&str, Vec<u8>)], method: CompressionMethod) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in arrays {
        let options = SimpleFileOptions::default().compression_method(method);
        zip.start_file(format!("{name}.npy"), options).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

fn npz(arrays: &[(&str, Vec<u8>)]) -> Vec<u8> {
    npz_packed(arrays, CompressionMethod::Stored)
}

/// The mask and one array more.
fn with(name: &str, bytes: Vec<u8>) -> Result<WashState, StateFileError> {
    read_bytes(&npz(&[("wet_mask", mask()), (name, bytes)]))
}

fn read_bytes(bytes: &[u8]) -> Result<WashState, StateFileError> {
    read(Cursor::new(bytes))
}

fn written(state: &WashState) -> Vec<u8> {
    let mut bytes = Vec::new();
    write(state, &mut bytes).unwrap();
    bytes
}

/// A state without two equal values near each other.
fn state(columns: usize, rows: usize, pigments: usize) -> WashState {
    let mut state = WashState::empty(Layout::new(columns, rows), pigments);
    let mut next = 0.0;
    let mut fill = |row: &mut [f32], low: f32| {
        for value in row {
            next = (next + 0.381_966) % 1.0;
            *value = low + next;
        }
    };
    for y in 0..rows {
        fill(state.height.cells_mut(y), 0.0);
        fill(state.u.faces_mut(y), -0.5);
        fill(state.pressure.cells_mut(y), -0.5);
        fill(state.saturation.cells_mut(y), 0.0);
        for field in state.suspended.iter_mut().chain(&mut state.deposited) {
            fill(field.cells_mut(y), 0.0);
        }
        for (x, wet) in state.wet_mask.cells_mut(y).iter_mut().enumerate() {
            *wet = u8::from((x * 7 + y * 3) % 5 < 2);
        }
    }
    for y in 0..=rows {
        fill(state.v.cells_mut(y), -0.5);
    }
    state
}

/// A field's values of that many rows and columns.
fn values(field: &Field<f32>, [rows, columns]: [usize; 2]) -> Vec<f32> {
    (0..rows).flat_map(|y| field.row(Layout::TOP + y)[Layout::LEFT..][..columns].to_vec()).collect()
}

#[test]
fn what_is_written_is_read_bit_for_bit() {
    for (columns, rows, pigments) in [(1, 1, 0), (3, 2, 1), (1, 40, 2), (70, 3, 3), (1500, 20, 1)] {
        let mut state = state(columns, rows, pigments);
        state.u.faces_mut(0)[0] = -0.0;
        state.pressure.cells_mut(0)[0] = f32::MIN_POSITIVE / 2.0;
        let bytes = written(&state);
        let read = read_bytes(&bytes).unwrap();
        assert_eq!(read, state);
        assert_eq!(read.u.faces(0)[0].to_bits(), (-0.0f32).to_bits());
        assert_eq!(written(&read), bytes);
    }
}

#[test]
fn the_mask_alone_is_a_dry_sheet() {
    let state = read_bytes(&npz(&[("wet_mask", mask())])).unwrap();
    assert_eq!((state.layout().width(), state.layout().height()), (3, 2));
    assert_eq!(state.wet_mask.cells(1), [0, 0, 1]);
    assert_eq!(state.height.cells(1), [0.5; 3]);
    assert_eq!(state.u.faces(0), [0.0; 4]);
    assert!(state.suspended.is_empty() && state.deposited.is_empty());
}

#[test]
fn one_pigment_array_makes_the_other() {
    for key in ["suspended", "deposited"] {
        let values: Vec<f32> = (0..12).map(|i| i as f32 / 4.0).collect();
        let state = with(key, floats("(2, 2, 3)", &values)).unwrap();
        let (given, made) = match key {
            "suspended" => (&state.suspended, &state.deposited),
            _ => (&state.deposited, &state.suspended),
        };
        assert_eq!(given[1].cells(0), [1.5, 1.75, 2.0]);
        assert_eq!(made.len(), 2);
        assert_eq!(made[1].cells(0), [0.0; 3]);
    }
}

#[test]
fn every_type_order_and_packing_gives_the_same_state() {
    let state = state(70, 90, 2);
    let plain = |fields: &[Field<f32>], shape: [usize; 2]| -> Vec<f32> {
        fields.iter().flat_map(|field| values(field, shape)).collect()
    };
    let arrays: [(&str, Vec<f32>, [usize; 3]); 7] = [
        ("height", values(&state.height, [90, 70]), [1, 90, 70]),
        ("u", values(&state.u, [90, 71]), [1, 90, 71]),
        ("v", values(&state.v, [91, 70]), [1, 91, 70]),
        ("pressure", values(&state.pressure, [90, 70]), [1, 90, 70]),
        ("saturation", values(&state.saturation, [90, 70]), [1, 90, 70]),
        ("suspended", plain(&state.suspended, [90, 70]), [2, 90, 70]),
        ("deposited", plain(&state.deposited, [90, 70]), [2, 90, 70]),
    ];
    let wet: Vec<u8> = (0..90).flat_map(|y| state.wet_mask.cells(y).to_vec()).collect();
    let in_order = |fortran: bool, [planes, rows, columns]: [usize; 3]| -> Vec<usize> {
        let place = |i: usize| {
            let (plane, y, x) = (i % planes, i / planes % rows, i / planes / rows);
            (plane * rows + y) * columns + x
        };
        (0..planes * rows * columns).map(|i| if fortran { place(i) } else { i }).collect()
    };
    for (descr, encode) in [
        ("'<f4'", (|value: f32| value.to_le_bytes().to_vec()) as fn(f32) -> Vec<u8>),
        ("'>f4'", |value| value.to_be_bytes().to_vec()),
        ("'<f8'", |value| f64::from(value).to_le_bytes().to_vec()),
        ("'>f8'", |value| f64::from(value).to_be_bytes().to_vec()),
    ] {
        for fortran in [false, true] {
            let mut file = vec![(
                "wet_mask",
                npy(
                    if fortran { "'|u1'" } else { "'|b1'" },
                    fortran,
                    "(90, 70)",
                    &in_order(fortran, [1, 90, 70]).iter().map(|&i| wet[i]).collect::<Vec<_>>(),
                ),
            )];
            for (name, values, shape) in &arrays {
                let bytes: Vec<u8> =
                    in_order(fortran, *shape).iter().flat_map(|&i| encode(values[i])).collect();
                let shape = if shape[0] == 2 {
                    format!("(2, {}, {})", shape[1], shape[2])
                } else {
                    format!("({}, {})", shape[1], shape[2])
                };
                file.push((name, npy(descr, fortran, &shape, &bytes)));
            }
            for method in [CompressionMethod::Stored, CompressionMethod::Deflated] {
                let read = read_bytes(&npz_packed(&file, method)).unwrap();
                assert_eq!(read, state, "{descr} {fortran} {method}");
            }
        }
    }
}

#[test]
fn other_types_are_refused_with_the_expression_to_save() {
    for (key, descr, found, fix) in [
        ("suspended", "'<i8'", "int64", "suspended.astype('float32')"),
        ("u", "'<f2'", "float16", "u.astype('float32')"),
        ("u", "'<f16'", "float128", "u.astype('float32')"),
        ("pressure", "'<c8'", "complex64", "pressure.real.astype('float32')"),
        ("height", "'|b1'", "bool", "height.astype('float32')"),
        ("height", "'|u1'", "uint8", "height.astype('float32')"),
        ("deposited", "'|O'", "object", "np.array(deposited.tolist(), dtype='float32')"),
        ("height", "[('z', '<f4')]", "a structure", "height['...'].astype('float32')"),
        ("height", "'q'", "of the unknown type `q`", "height.astype('float32')"),
    ] {
        let error = with(key, npy(descr, false, "(2, 3)", &[0; 48])).unwrap_err();
        assert_eq!(error.to_string(), format!("`{key}` is {found}, not float32 or float64"));
        assert_eq!(error.hint(), Some(format!("save it as `{fix}`")));
    }
    for (descr, found, fix) in [
        ("'<i8'", "int64", "wet_mask.astype(bool)"),
        ("'<f8'", "float64", "(wet_mask > 0.5).astype(bool)"),
        ("'|O'", "object", "np.array(wet_mask.tolist(), dtype=bool)"),
    ] {
        let error = read_bytes(&npz(&[("wet_mask", npy(descr, false, "(2, 3)", &[0; 48]))])).unwrap_err();
        assert_eq!(error.to_string(), format!("`wet_mask` is {found}, not bool or uint8"));
        assert_eq!(error.hint(), Some(format!("save it as `{fix}`")));
    }
}

#[test]
fn shapes_are_compared_with_the_wet_mask() {
    for (key, shape, wanted, fix) in [
        ("suspended", "(2, 3)", "(pigments, 2, 3)", Some("a single pigment is `suspended[None]`")),
        (
            "deposited",
            "(2, 3, 1)",
            "(pigments, 2, 3)",
            Some("the pigments are the first axis: `np.moveaxis(deposited, -1, 0)`"),
        ),
        ("height", "(3, 2)", "(2, 3)", Some("rows come first: `height.T`")),
        ("u", "(2, 3)", "(2, 4)", Some("u is on the faces between columns, one more than cells")),
        ("v", "(2, 3)", "(3, 3)", Some("v is on the faces between rows, one more than cells")),
        ("pressure", "(6,)", "(2, 3)", None),
        ("pressure", "()", "(2, 3)", None),
        ("pressure", "(1000000, 1000000)", "(2, 3)", None),
    ] {
        let error = with(key, floats(shape, &[0.0; 6])).unwrap_err();
        assert_eq!(error.to_string(), format!("`{key}` has the shape {shape}, not {wanted}"));
        assert_eq!(error.hint().as_deref(), fix);
    }
    let error = read_bytes(&npz(&[("wet_mask", npy("'|b1'", false, "(6,)", &[0; 6]))])).unwrap_err();
    assert_eq!(error.to_string(), "`wet_mask` has the shape (6,), not (rows, columns)");
    let error = read_bytes(&npz(&[
        ("wet_mask", mask()),
        ("suspended", floats("(1, 2, 3)", &[0.0; 6])),
        ("deposited", floats("(2, 2, 3)", &[0.0; 12])),
    ]));
    assert!(matches!(error, Err(StateFileError::Pigments { suspended: 1, deposited: 2 })));
}

#[test]
fn names_are_those_of_a_state() {
    let error = with("presure", floats("(2, 3)", &[0.0; 6])).unwrap_err();
    assert_eq!(error.to_string(), "unknown array `presure`");
    assert_eq!(error.hint().as_deref(), Some("did you mean `pressure`?"));
    let error = with("../\n\u{1b}[31m", Vec::new()).unwrap_err();
    assert_eq!(error.to_string().lines().count(), 1);
    let error = with("evaporated", npy("'<f8'", false, "(2,)", &[0; 16])).unwrap_err();
    assert!(matches!(error, StateFileError::Shape { key: "evaporated", .. }), "{error}");
    let error = with("cells_per_mm", npy("'<i8'", false, "()", &[4, 0, 0, 0, 0, 0, 0, 0])).unwrap_err();
    assert!(matches!(error, StateFileError::Type { key: "cells_per_mm", .. }), "{error}");
    let error = with("contact_carry", npy("'<f8'", false, "()", &1.5f64.to_le_bytes())).unwrap_err();
    assert!(error.to_string().contains("from 0 to below 1"), "{error}");
    let error = read_bytes(&npz(&[("height", floats("(2, 3)", &[0.5; 6]))])).unwrap_err();
    assert!(matches!(error, StateFileError::NoWetMask));
    assert!(matches!(read_bytes(&npz(&[])), Err(StateFileError::NoWetMask)));
    assert!(matches!(read_bytes(&mask()), Err(StateFileError::OneArray)));
    assert!(matches!(read_bytes(b"PK, but no archive"), Err(StateFileError::NotNpz { .. })));
    assert!(matches!(read_bytes(b""), Err(StateFileError::NotNpz { .. })));
}

#[test]
fn an_array_twice_is_refused() {
    let mut bytes = npz(&[("wet_mask", mask()), ("u", floats("(2, 4)", &[0.0; 8])), ("v", mask())]);
    for at in 0..bytes.len() - 5 {
        if &bytes[at..at + 5] == b"v.npy" {
            bytes[at] = b'u';
        }
    }
    assert!(matches!(read_bytes(&bytes), Err(StateFileError::Duplicate)));
}

#[test]
fn values_are_checked_with_their_place() {
    let mut bad = [0.0; 12];
    bad[10] = -0.25;
    let error = with("suspended", floats("(2, 2, 3)", &bad)).unwrap_err();
    assert_eq!(
        error.to_string(),
        "`suspended` is -0.25 at column 1, row 1 of pigment 2; it must be a finite number, 0 or more"
    );
    let mut bad = [0.0; 8];
    bad[7] = f32::NAN;
    let error = with("u", floats("(2, 4)", &bad)).unwrap_err();
    assert!(error.to_string().starts_with("`u` is NaN at column 3, row 1;"), "{error}");
    let too_large = npy("'<f8'", false, "(2, 3)", &1e60f64.to_le_bytes().repeat(6));
    assert!(with("pressure", too_large).unwrap_err().to_string().starts_with("`pressure` is inf at"));
    assert!(with("height", floats("(2, 3)", &[1.5; 6])).is_err());
    let error = read_bytes(&npz(&[("wet_mask", npy("'|u1'", false, "(1, 2)", &[1, 255]))])).unwrap_err();
    assert!(error.to_string().starts_with("`wet_mask` is 255 at column 1, row 0;"), "{error}");
    assert_eq!(error.hint().as_deref(), Some("save it as `wet_mask > 0`"));
}

#[test]
fn claims_are_not_believed() {
    let claim =
        |shape: &str| read_bytes(&npz(&[("wet_mask", npy("'|b1'", false, shape, &[0; 6]))])).unwrap_err();
    assert!(matches!(
        claim("(1000000, 1000000)"),
        StateFileError::TooLarge { quantity: "cells", found: 1_000_000_000_000, .. }
    ));
    assert!(matches!(claim("(18446744073709551615, 2)"), StateFileError::TooLarge { quantity: "cells", .. }));
    assert!(matches!(claim("(9999, 9999)"), StateFileError::Length { found: _, wanted: _, .. }));
    assert!(matches!(claim("(1, 5)"), StateFileError::Length { .. }));
    for shape in ["(0, 3)", "(3, 0)", "(0, 0)", "(0, 18446744073709551615)"] {
        assert!(matches!(claim(shape), StateFileError::Empty { key: "wet_mask", .. }));
    }
    assert!(matches!(with("deposited", floats("(0, 2, 3)", &[])), Err(StateFileError::Empty { .. })));
    let error = with("deposited", floats("(65, 2, 3)", &[0.0; 390])).unwrap_err();
    assert!(matches!(error, StateFileError::TooLarge { quantity: "pigments", found: 65, most: 64 }));

    let limits = Limits { cells: 5, ..Limits::default() };
    let file = npz(&[("wet_mask", mask())]);
    assert!(matches!(
        read_within(Cursor::new(&file), &limits),
        Err(StateFileError::TooLarge { most: 5, .. })
    ));
    let limits = Limits { bytes: 2000, ..Limits::default() };
    let error = read_within(Cursor::new(&file), &limits).unwrap_err();
    assert!(matches!(error, StateFileError::TooLarge { quantity: "bytes in memory", most: 2000, .. }));
    // No limits at all still do not overflow.
    let none = Limits { cells: u64::MAX, pigments: u64::MAX, bytes: u64::MAX, ..Limits::default() };
    assert!(read_within(Cursor::new(&file), &none).is_ok());
    let huge = npz(&[("wet_mask", npy("'|b1'", false, "(1, 1099511627776)", &[0; 6]))]);
    assert!(read_within(Cursor::new(&huge), &none).is_err());
}

#[test]
fn a_narrow_canvas_is_measured_with_its_border() {
    // 2^24 cells are few, but 2^24 rows with their borders are not.
    let limits = Limits { bytes: 1 << 30, ..Limits::default() };
    let mask = npy("'|b1'", false, "(16777216, 1)", &vec![0; 1 << 24]);
    let file = npz_packed(&[("wet_mask", mask)], CompressionMethod::Deflated);
    let error = read_within(Cursor::new(&file), &limits).unwrap_err();
    assert!(matches!(error, StateFileError::TooLarge { quantity: "bytes in memory", .. }), "{error}");
}

/// Changes all places of `from` in the archive's directories to `to`.
fn replaced(bytes: &[u8], from: [u8; 4], to: [u8; 4]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for at in 0..bytes.len() - 3 {
        if bytes[at..at + 4] == from {
            bytes[at..at + 4].copy_from_slice(&to);
        }
    }
    bytes
}

#[test]
fn a_packed_size_that_cannot_be_is_refused() {
    let array = npy("'|b1'", false, "(16384, 16384)", &[0; 600]);
    let claimed = (array.len() - 600 + (1 << 28)) as u32;
    for method in [CompressionMethod::Stored, CompressionMethod::Deflated] {
        let file = npz_packed(&[("wet_mask", array.clone())], method);
        let file = replaced(&file, (array.len() as u32).to_le_bytes(), claimed.to_le_bytes());
        let error = read_bytes(&file).unwrap_err();
        assert!(matches!(error, StateFileError::Unpack { key: "wet_mask", .. }), "{error}");
    }
}

#[test]
fn more_or_other_bytes_than_the_directory_says_are_refused() {
    // Deflated data goes on after its claimed size.
    let long = npy("'|b1'", false, "(2, 3)", &[0; 9]);
    let file = npz_packed(&[("wet_mask", long.clone())], CompressionMethod::Deflated);
    let file = replaced(&file, (long.len() as u32).to_le_bytes(), (long.len() as u32 - 3).to_le_bytes());
    assert!(matches!(read_bytes(&file), Err(StateFileError::Unpack { .. })));
    // A changed value has another checksum.
    let mut file = npz(&[("wet_mask", mask())]);
    let at = file.windows(6).position(|bytes| bytes == [0, 1, 1, 0, 0, 1]).unwrap();
    file[at] = 1;
    let error = read_bytes(&file).unwrap_err();
    assert_eq!(error.to_string(), "`wet_mask` cannot be unpacked: Invalid checksum");
}

#[test]
fn a_file_cut_anywhere_is_refused() {
    for bytes in [
        written(&state(3, 2, 1)),
        npz_packed(
            &[("wet_mask", mask()), ("pressure", floats("(2, 3)", &[0.25; 6]))],
            CompressionMethod::Deflated,
        ),
    ] {
        for cut in 0..bytes.len() {
            assert!(read_bytes(&bytes[..cut]).is_err(), "{cut} of {}", bytes.len());
        }
        assert!(read_bytes(&bytes).is_ok());
    }
}

#[test]
fn what_could_not_be_read_is_not_written() {
    let refused = |state: &WashState| write(state, io::sink()).unwrap_err();
    let mut bad = state(3, 2, 1);
    bad.suspended[0].cells_mut(1)[2] = f32::INFINITY;
    assert!(matches!(refused(&bad), StateFileError::State(_)));
    let mut bad = state(3, 2, 1);
    bad.deposited.clear();
    assert!(matches!(refused(&bad), StateFileError::Pigments { suspended: 1, deposited: 0 }));
    let mut bad = state(3, 2, 1);
    bad.u = Field::<f32>::zeroed(Layout::new(2, 2));
    assert!(matches!(refused(&bad), StateFileError::State(_)));
    assert!(matches!(refused(&state(0, 0, 0)), StateFileError::Empty { .. }));
}

#[test]
fn a_full_disk_is_an_error() {
    let state = state(200, 100, 1);
    let whole = written(&state).len();
    for room in [0, 10, 500, 300_000, 400_000, whole - 100, whole - 1] {
        let mut disk = vec![0; room];
        assert!(matches!(write(&state, disk.as_mut_slice()), Err(StateFileError::Write(_))), "{room}");
    }
}

proptest! {
    #[test]
    fn any_size_comes_back(columns in 1..40usize, rows in 1..40usize, pigments in 0..3usize) {
        let state = state(columns, rows, pigments);
        prop_assert_eq!(read_bytes(&written(&state)).unwrap(), state);
    }

    #[test]
    fn no_change_of_bytes_makes_the_reader_panic(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        deflated in any::<bool>(),
    ) {
        let mut bytes = if deflated {
            let arrays = [("wet_mask", mask()), ("suspended", floats("(1, 2, 3)", &[0.25; 6]))];
            npz_packed(&arrays, CompressionMethod::Deflated)
        } else {
            written(&state(3, 2, 1))
        };
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if let Err(error) = read_bytes(&bytes) {
            prop_assert_eq!(error.to_string().lines().count(), 1);
            let _ = error.hint();
        }
    }

    #[test]
    fn no_header_makes_the_reader_panic(
        descr in prop::sample::select(vec!["'<f4'", "'>f8'", "'|b1'", "'|u1'", "'|O'", "'<i4'", "[]", "''"]),
        fortran in any::<bool>(),
        shape in "\\(([0-9]{1,3}|[0-9]{18,20})?(, ?[0-9]{1,12}){0,3},?\\)",
        key in prop::sample::select(Key::ALL.to_vec()),
        values in 0..40usize,
    ) {
        let array = npy(descr, fortran, &shape, &vec![0; values]);
        let file = if key == Key::WetMask {
            npz(&[("wet_mask", array)])
        } else {
            npz(&[("wet_mask", mask()), (key.name(), array)])
        };
        if let Ok(state) = read_bytes(&file) {
            prop_assert!(state.layout().width() * state.layout().height() <= 40);
        }
    }
}

#[test]
fn what_is_not_zero_is_limited_apart() {
    let mut state = state(60, 40, 1);
    let most = |touched_bytes| Limits { touched_bytes, ..Limits::default() };
    let read = |state: &WashState, most| read_within(Cursor::new(written(state)), &most);
    let values = 60 * 40;
    assert_eq!(read(&state, most(8 * 4 * values as u64)).unwrap(), state);
    let error = read(&state, most(5 * 4 * values as u64)).unwrap_err();
    assert!(matches!(error, StateFileError::Memory { .. }), "{error}");
    assert!(error.hint().is_some());
    // Zeros are free.
    state.suspended[0] = Field::<f32>::zeroed(state.layout());
    state.u = Field::<f32>::zeroed(state.layout());
    assert_eq!(read(&state, most(6 * 4 * values as u64)).unwrap(), state);
}
