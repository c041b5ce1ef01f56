//! Papers.
#![no_main]

use girtin::paper::Paper;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let _ = Paper::from_toml("fuzz", text);
});
