//! Maps: pictures and arrays of `.npz`.
#![no_main]

use girtin::painting::map_file;
use girtin::painting::picture::PictureLimits;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(map) = map_file::read(bytes, &PictureLimits::of_photo(1 << 20)) {
        assert!(map.as_slice().iter().all(|value| value.is_finite()));
    }
});
