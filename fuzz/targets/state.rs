//! A wash's state.
#![no_main]

use std::io::Cursor;

use girtin::painting::state_file::{Limits, read_within, write};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = Limits { cells: 1 << 16, pigments: 8, bytes: 64 << 20, touched_bytes: 64 << 20 };
    if let Ok(state) = read_within(Cursor::new(bytes), &limits) {
        let mut again = Vec::new();
        write(&state, &mut again).expect("what was read can be written");
    }
});
