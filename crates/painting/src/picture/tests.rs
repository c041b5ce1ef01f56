use std::io::Cursor;

use image::{GrayImage, ImageEncoder, Rgb, RgbImage, Rgba, RgbaImage};
use proptest::prelude::*;

use super::*;

fn encoded(picture: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    picture.into().write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn read(bytes: &[u8]) -> Result<Raster<f32>, PictureError> {
    read_grey(Cursor::new(bytes), &PictureLimits::default())
}

#[test]
fn grays_are_as_stored_in_every_format_and_depth() {
    let ramp = GrayImage::from_fn(16, 16, |x, y| image::Luma([(x + 16 * y) as u8]));
    for format in [ImageFormat::Png, ImageFormat::Tiff] {
        let gray = read(&encoded(ramp.clone(), format)).unwrap();
        let rgb = read(&encoded(DynamicImage::ImageLuma8(ramp.clone()).to_rgb8(), format)).unwrap();
        let deep = read(&encoded(DynamicImage::ImageLuma8(ramp.clone()).to_rgb16(), format)).unwrap();
        for (i, &value) in gray.as_slice().iter().enumerate() {
            assert_eq!(value, (i as f64 / 255.0) as f32);
        }
        assert_eq!(gray, rgb);
        assert_eq!(gray, deep);
    }
    let jpeg = read(&encoded(ramp, ImageFormat::Jpeg)).unwrap();
    for (i, &value) in jpeg.as_slice().iter().enumerate() {
        assert!((value - i as f32 / 255.0).abs() < 0.03, "{i}: {value}");
    }
}

#[test]
fn colors_become_luma_and_holes_paper() {
    let mut picture = RgbaImage::from_pixel(3, 1, Rgba([0, 0, 0, 0]));
    picture.put_pixel(1, 0, Rgba([0, 255, 0, 255]));
    picture.put_pixel(2, 0, Rgba([0, 0, 0, 51]));
    let grey = read(&encoded(picture, ImageFormat::Png)).unwrap();
    assert_eq!(grey.at(0, 0), 1.0);
    assert!((grey.at(1, 0) - 0.7152).abs() < 1e-4);
    assert!((grey.at(2, 0) - 0.8).abs() < 1e-6);
}

#[test]
fn colors_are_light_and_holes_paper() {
    let read = |picture: DynamicImage| {
        read_color(Cursor::new(encoded(picture, ImageFormat::Png)), &PictureLimits::default()).unwrap()
    };
    let mut picture = RgbaImage::from_pixel(3, 1, Rgba([0, 0, 0, 0]));
    picture.put_pixel(1, 0, Rgba([255, 188, 0, 255]));
    picture.put_pixel(2, 0, Rgba([0, 0, 0, 51]));
    let color = read(picture.into());
    assert_eq!(color.at(0, 0), LinearRgb::WHITE);
    let expected = Srgb([1.0, 188.0 / 255.0, 0.0]).to_linear();
    assert!(color.at(1, 0).0.iter().zip(expected.0).all(|(a, b)| (a - b).abs() < 1e-12));
    assert!((color.at(2, 0).0[1] - 0.8).abs() < 1e-12);
    // Gray and 16 bits alike; what is shown is what was read.
    let gray = GrayImage::from_fn(16, 16, |x, y| image::Luma([(x + 16 * y) as u8]));
    let eight = read(gray.clone().into());
    let sixteen = read(DynamicImage::ImageLuma8(gray.clone()).to_rgb16().into());
    for (i, (a, b)) in eight.as_slice().iter().zip(sixteen.as_slice()).enumerate() {
        assert_eq!(a.to_srgb().to_bytes(), [i as u8; 3]);
        assert_eq!(b.to_srgb().to_bytes(), [i as u8; 3]);
    }
}

#[test]
fn palettes_and_single_bits_are_read() {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::One);
    encoder.set_palette(vec![51, 51, 51, 255, 255, 255]);
    encoder.write_header().unwrap().write_image_data(&[0b0100_0000]).unwrap();
    assert_eq!(read(&bytes).unwrap().as_slice(), [0.2, 1.0]);
}

#[test]
fn a_picture_is_turned_as_it_says() {
    let picture = RgbImage::from_fn(2, 1, |x, _| Rgb([255 * x as u8; 3]));
    let mut bytes = Vec::new();
    let mut encoder = image::codecs::png::PngEncoder::new(&mut bytes);
    // Big-endian TIFF, one tag: orientation 6, to be turned right.
    let exif = b"MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0".to_vec();
    encoder.set_exif_metadata(exif).unwrap();
    encoder.write_image(picture.as_raw(), 2, 1, image::ExtendedColorType::Rgb8).unwrap();
    let turned = read(&bytes).unwrap();
    assert_eq!((turned.width(), turned.height()), (1, 2));
    assert_eq!(turned.as_slice(), [0.0, 1.0]);
}

#[test]
fn values_that_are_no_numbers_are_refused() {
    let pixels = vec![0.5, 0.5, 0.5, 2.0, f32::NAN, 0.0];
    let picture = image::Rgb32FImage::from_raw(2, 1, pixels).unwrap();
    let error = read(&encoded(picture, ImageFormat::Tiff)).unwrap_err();
    assert!(matches!(error, PictureError::NotFinite { x: 1, y: 0 }), "{error}");
    let picture = image::Rgb32FImage::from_raw(2, 1, vec![0.25, 0.25, 0.25, 7.0, 7.0, 7.0]).unwrap();
    assert_eq!(read(&encoded(picture, ImageFormat::Tiff)).unwrap().as_slice(), [0.25, 1.0]);
}

#[test]
fn limits_hold_before_anything_is_decoded() {
    let bytes = encoded(GrayImage::new(64, 64), ImageFormat::Png);
    let few = PictureLimits { pixels: 4095, ..PictureLimits::default() };
    let error = read_grey(Cursor::new(&bytes), &few).unwrap_err();
    assert!(matches!(error, PictureError::TooLarge { width: 64, height: 64, most: 4095 }), "{error}");
    let small = PictureLimits { decoder_bytes: 4000, ..PictureLimits::default() };
    assert!(matches!(read_grey(Cursor::new(&bytes), &small), Err(PictureError::Memory { most: 4000 })));
    // A header that claims 2^31 − 1 pixels each way.
    let mut claim = bytes.clone();
    claim[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
    let mut crc = crc(&claim[12..29]).to_be_bytes();
    claim[29..33].swap_with_slice(&mut crc);
    let error = read(&claim).unwrap_err();
    assert!(matches!(error, PictureError::TooLarge { .. } | PictureError::Memory { .. }), "{error}");
}

fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg()))
    })
}

#[test]
fn other_files_are_refused_with_a_hint() {
    for bytes in [&b""[..], b"hello", b"GIF89a\x01\0\x01\0\0\0\0", b"RIFF\0\0\0\0WEBPVP8 "] {
        let error = read(bytes).unwrap_err();
        assert!(matches!(error, PictureError::Format { .. }), "{error}");
        assert!(error.hint().is_some());
    }
    assert_eq!(read(b"GIF89a").unwrap_err().to_string(), "the picture is GIF, not PNG, JPEG or TIFF");
}

#[test]
fn truncated_files_never_panic() {
    let picture = RgbImage::from_fn(7, 5, |x, y| Rgb([(x * 30) as u8, (y * 40) as u8, 9]));
    for format in [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Tiff] {
        let bytes = encoded(picture.clone(), format);
        for cut in 0..bytes.len() {
            let _ = read(&bytes[..cut]);
        }
    }
}

fn meta() -> PngMeta {
    let text = [("Software", "girtin 0.1.0"), ("girtin:seed", "7"), ("Title", "Kirkstall — œuvre")];
    PngMeta {
        pixels_per_mm: Some(11.811),
        text: text.map(|(keyword, text)| (keyword.to_owned(), text.to_owned())).to_vec(),
    }
}

fn decoded(bytes: &[u8]) -> (png::Info<'static>, Vec<u8>) {
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
    write_png_16(&mut bytes, &picture, &PngMeta::default()).unwrap();
    let (info, pixels) = decoded(&bytes);
    assert_eq!(info.bit_depth, BitDepth::Sixteen);
    assert!(info.pixel_dims.is_none());
    let values: Vec<u16> = pixels.as_chunks().0.iter().map(|&bytes| u16::from_be_bytes(bytes)).collect();
    assert_eq!(values, picture.as_slice().as_flattened());
}

#[test]
fn what_a_png_cannot_hold_is_refused() {
    let refused =
        |picture: &Raster<u8>, meta: &PngMeta| write_grey_png(io::sink(), picture, meta).unwrap_err();
    let plain = PngMeta::default();
    assert!(matches!(refused(&Raster::new(0, 3, 0), &plain), PngError::Size { width: 0, height: 3 }));
    for bad in ["", "naïve—", &"k".repeat(80)] {
        let meta = PngMeta { text: vec![(bad.to_owned(), String::new())], ..plain.clone() };
        assert!(matches!(refused(&Raster::new(1, 1, 0), &meta), PngError::Keyword { .. }), "{bad}");
    }
    for bad in [0.0, -1.0, f64::NAN, 1e9] {
        let meta = PngMeta { pixels_per_mm: Some(bad), ..plain.clone() };
        assert!(matches!(refused(&Raster::new(1, 1, 0), &meta), PngError::Resolution { .. }), "{bad}");
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
        assert!(matches!(result, Err(PngError::Write(_))), "{room}: {result:?}");
    }
}

proptest! {
    #[test]
    fn damaged_files_never_panic(at in any::<prop::sample::Index>(), byte in any::<u8>(), which in 0..3usize) {
        let picture = RgbImage::from_fn(7, 5, |x, y| Rgb([(x * 30) as u8, (y * 40) as u8, 9]));
        let format = [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::Tiff][which];
        let mut bytes = encoded(picture, format);
        let at = at.index(bytes.len());
        bytes[at] = byte;
        let _ = read(&bytes);
    }

    #[test]
    fn masks_come_back_as_gray(width in 1..20usize, values in prop::collection::vec(any::<u8>(), 1..200)) {
        let height = values.len().div_ceil(width);
        let mask = Raster::from_fn(width, height, |x, y| values.get(y * width + x).copied().unwrap_or(0));
        let mut bytes = Vec::new();
        write_grey_png(&mut bytes, &mask, &PngMeta::default()).unwrap();
        let read = read_grey(Cursor::new(&bytes), &PictureLimits::default()).unwrap();
        prop_assert_eq!(read, mask.map(|value| (f64::from(value) / 255.0) as f32));
    }
}
