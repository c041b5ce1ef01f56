//! Pictures, as light and as gray.
#![no_main]

use std::io::Cursor;

use girtin::optics::LinearRgb;
use girtin::painting::picture::{PictureLimits, read_grey, read_photo};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = PictureLimits::of_photo(1 << 20);
    if let Ok(photo) = read_photo(Cursor::new(bytes), None, &limits, LinearRgb::WHITE) {
        let is_light = |light: &f32| (0.0..=1.0).contains(light);
        assert!(photo.pixels.as_slice().as_flattened().iter().all(is_light));
    }
    let _ = read_grey(Cursor::new(bytes), &limits);
});
