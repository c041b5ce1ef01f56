//! Pigments.
#![no_main]

use girtin::optics::Pigment;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let _ = Pigment::from_toml("fuzz", text);
});
