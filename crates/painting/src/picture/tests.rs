use std::io::Cursor;

use girtin_grid::Raster;
use image::{DynamicImage, GrayImage, ImageFormat, RgbImage, Rgba, RgbaImage};

use super::*;

mod damaged;
mod formats;
mod photo;
mod png_files;

fn encoded(picture: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    picture.into().write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// As a map.
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
fn a_mask_is_gray_however_it_is_stored() {
    let mask = |bytes: &[u8]| read_mask(Cursor::new(bytes), &PictureLimits::default());
    let ramp = GrayImage::from_fn(16, 16, |x, y| image::Luma([(x + 16 * y) as u8]));
    for format in [ImageFormat::Png, ImageFormat::Jpeg] {
        let stored = encoded(DynamicImage::from(ramp.clone()).to_rgb8(), format);
        assert_eq!(mask(&stored).unwrap(), read(&stored).unwrap());
    }
    // A stray pixel, and colors that are not seen.
    let mut few = DynamicImage::from(ramp).to_rgba8();
    few.put_pixel(3, 3, Rgba([255, 0, 0, 255]));
    few.put_pixel(4, 4, Rgba([255, 0, 0, 0]));
    few.put_pixel(5, 4, Rgba([255, 0, 0, 0]));
    few.put_pixel(6, 4, Rgba([255, 0, 0, 0]));
    assert!(mask(&encoded(few, ImageFormat::Png)).is_ok());
    let error = mask(&encoded(colors(9, 7), ImageFormat::Png)).unwrap_err();
    assert!(matches!(error, PictureError::Colored { .. }), "{error}");
    assert!(error.hint().is_some());
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
fn values_that_are_no_numbers_are_refused() {
    let pixels = vec![0.5, 0.5, 0.5, 2.0, f32::NAN, 0.0];
    let picture = image::Rgb32FImage::from_raw(2, 1, pixels).unwrap();
    let error = read(&encoded(picture, ImageFormat::Tiff)).unwrap_err();
    assert!(matches!(error, PictureError::NotFinite { x: 1, y: 0 }), "{error}");
    let picture = image::Rgb32FImage::from_raw(2, 1, vec![0.25, 0.25, 0.25, 7.0, 7.0, 7.0]).unwrap();
    assert_eq!(read(&encoded(picture, ImageFormat::Tiff)).unwrap().as_slice(), [0.25, 1.0]);
}

/// As a photograph on white paper.
fn seen(bytes: &[u8]) -> Result<Photo, PictureError> {
    let limits = PictureLimits::of_photo(PictureLimits::PHOTO_PIXELS);
    read_photo(Cursor::new(bytes), None, &limits, girtin_optics::LinearRgb::WHITE)
}

/// Something of color in every pixel.
fn colors(width: u32, height: u32) -> RgbImage {
    RgbImage::from_fn(width, height, |x, y| image::Rgb([(x * 30) as u8, (y * 40) as u8, (x * y) as u8]))
}
