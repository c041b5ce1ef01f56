use std::io;

use png::{BitDepth, SrgbRenderingIntent};
use proptest::prelude::*;

use super::*;

#[test]
fn words_of_a_png_are_found() {
    let mut bytes = Vec::new();
    let meta = PictureMeta { pixels_per_mm: None, text: vec![("Seed".to_owned(), "7".to_owned())] };
    write_grey_png(&mut bytes, &Raster::new(2, 2, 9), &meta).unwrap();
    let word = |keyword| read_png_word(Cursor::new(&bytes), keyword);
    assert_eq!((word("Seed").as_deref(), word("Sead")), (Some("7"), None));
    assert_eq!(read_png_word(Cursor::new(b"no picture"), "Seed"), None);
}

pub(super) fn meta() -> PictureMeta {
    let text = [("Software", "girtin 0.1.0"), ("girtin:seed", "7"), ("Title", "Kirkstall — œuvre")];
    PictureMeta {
        pixels_per_mm: Some(11.811),
        text: text.map(|(keyword, text)| (keyword.to_owned(), text.to_owned())).to_vec(),
    }
}

pub(super) fn decoded(bytes: &[u8]) -> (png::Info<'static>, Vec<u8>) {
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    (reader.info().clone(), pixels)
}

#[test]
fn pixels_and_meta_come_back() {
    let picture = Raster::from_fn(37, 19, |x, y| [x as u8, y as u8, (x * y) as u8]);
    let mut bytes = Vec::new();
    write_png(&mut bytes, &picture, &meta()).unwrap();
    let (info, pixels) = decoded(&bytes);
    assert_eq!(pixels, picture.as_slice().as_flattened());
    assert_eq!(info.srgb, Some(SrgbRenderingIntent::Perceptual));
    assert_eq!(info.pixel_dims.unwrap().xppu, 11811);
    let latin: Vec<_> = info.uncompressed_latin1_text.iter().map(|t| (&*t.keyword, &*t.text)).collect();
    assert_eq!(latin, [("Software", "girtin 0.1.0"), ("girtin:seed", "7")]);
    assert_eq!(info.utf8_text[0].get_text().unwrap(), "Kirkstall — œuvre");

    let mut again = Vec::new();
    write_png(&mut again, &picture, &meta()).unwrap();
    assert_eq!(bytes, again);
}

#[test]
fn sixteen_bits_come_back() {
    let picture = Raster::from_fn(5, 3, |x, y| [(x * 9001) as u16, (y * 21000) as u16, 258]);
    let mut bytes = Vec::new();
    write_picture(&mut bytes, &picture, PictureFormat::Png16, &PictureMeta::default()).unwrap();
    let (info, pixels) = decoded(&bytes);
    assert_eq!(info.bit_depth, BitDepth::Sixteen);
    assert!(info.pixel_dims.is_none());
    let values: Vec<u16> = pixels.as_chunks().0.iter().map(|&bytes| u16::from_be_bytes(bytes)).collect();
    assert_eq!(values, picture.as_slice().as_flattened());
}

#[test]
fn what_a_png_cannot_hold_is_refused() {
    let refused =
        |picture: &Raster<u8>, meta: &PictureMeta| write_grey_png(io::sink(), picture, meta).unwrap_err();
    let plain = PictureMeta::default();
    assert!(matches!(refused(&Raster::new(0, 3, 0), &plain), WriteError::Size { width: 0, height: 3, .. }));
    for bad in ["", "naïve—", &"k".repeat(80)] {
        let meta = PictureMeta { text: vec![(bad.to_owned(), String::new())], ..plain.clone() };
        assert!(matches!(refused(&Raster::new(1, 1, 0), &meta), WriteError::Keyword { .. }), "{bad}");
    }
    for bad in [0.0, -1.0, f64::NAN, 1e9] {
        let meta = PictureMeta { pixels_per_mm: Some(bad), ..plain.clone() };
        assert!(matches!(refused(&Raster::new(1, 1, 0), &meta), WriteError::Resolution { .. }), "{bad}");
    }
}

#[test]
fn a_full_disk_is_an_error() {
    let picture = Raster::from_fn(64, 64, |x, y| [x as u8, y as u8, (x * y) as u8]);
    let mut whole = Vec::new();
    write_png(&mut whole, &picture, &meta()).unwrap();
    for room in 0..whole.len() {
        let mut disk = vec![0; room];
        let result = write_png(disk.as_mut_slice(), &picture, &meta());
        assert!(matches!(result, Err(WriteError::Write(_))), "{room}: {result:?}");
    }
}

proptest! {
    #[test]
    fn masks_come_back_as_gray(width in 1..20usize, values in prop::collection::vec(any::<u8>(), 1..200)) {
        let height = values.len().div_ceil(width);
        let mask = Raster::from_fn(width, height, |x, y| values.get(y * width + x).copied().unwrap_or(0));
        let mut bytes = Vec::new();
        write_grey_png(&mut bytes, &mask, &PictureMeta::default()).unwrap();
        let read = read_grey(Cursor::new(&bytes), &PictureLimits::default()).unwrap();
        prop_assert_eq!(read, mask.map(|value| (f64::from(value) / 255.0) as f32));
    }
}
