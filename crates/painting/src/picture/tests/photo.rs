//! Photographs as light.

use girtin_optics::{LinearRgb, Srgb};
use image::codecs::{jpeg::JpegEncoder, png::PngEncoder, webp::WebPEncoder};
use image::{ExtendedColorType, ImageEncoder};
use moxcms::ColorProfile;

use super::*;

fn light(encoded: [f64; 3]) -> [f64; 3] {
    Srgb(encoded).to_linear().0
}

#[track_caller]
fn assert_near(found: [f32; 3], wanted: [f64; 3], most: f64) {
    let is_near = found.iter().zip(wanted).all(|(&a, b)| (f64::from(a) - b).abs() <= most);
    assert!(is_near, "{found:?} is not {wanted:?}");
}

#[test]
fn every_format_and_depth_is_the_same_light() {
    let picture = colors(8, 6);
    let wanted = picture.pixels().map(|pixel| light(pixel.0.map(|value| f64::from(value) / 255.0)));
    let wanted: Vec<_> = wanted.collect();
    for format in [ImageFormat::Png, ImageFormat::Tiff, ImageFormat::WebP, ImageFormat::Bmp] {
        let photo = seen(&encoded(picture.clone(), format)).unwrap();
        assert_eq!((photo.pixels.width(), photo.pixels.height(), photo.stored_size), (8, 6, (8, 6)));
        assert!(photo.notes.is_empty(), "{format:?}: {:?}", photo.notes);
        for (&found, &wanted) in photo.pixels.as_slice().iter().zip(&wanted) {
            assert_near(found, wanted, 1e-6);
        }
    }
    for format in [ImageFormat::Png, ImageFormat::Tiff] {
        let deep = DynamicImage::from(picture.clone()).to_rgb16();
        let photo = seen(&encoded(deep, format)).unwrap();
        for (&found, &wanted) in photo.pixels.as_slice().iter().zip(&wanted) {
            assert_near(found, wanted, 1e-6);
        }
    }
    let jpeg = seen(&encoded(GrayImage::from_pixel(9, 7, image::Luma([188])), ImageFormat::Jpeg)).unwrap();
    assert_near(jpeg.pixels.at(4, 4), light([188.0 / 255.0; 3]), 0.005);
    let gif =
        seen(&encoded(RgbImage::from_pixel(3, 2, image::Rgb([255, 0, 188])), ImageFormat::Gif)).unwrap();
    assert_near(gif.pixels.at(2, 1), light([1.0, 0.0, 188.0 / 255.0]), 1e-6);
}

#[test]
fn a_progressive_jpeg_and_a_lossy_webp_are_near() {
    let jpeg = seen(include_bytes!("fixtures/progressive.jpg")).unwrap();
    let webp = seen(include_bytes!("fixtures/lossy.webp")).unwrap();
    for photo in [jpeg, webp] {
        let wanted = |x: usize, y: usize| [(x * 10) as f64, (y * 15) as f64, (x * y % 256) as f64];
        for (x, y) in [(2, 2), (12, 8), (20, 4)] {
            assert_near(photo.pixels.at(x, y), light(wanted(x, y).map(|value| value / 255.0)), 0.06);
        }
    }
}

/// A PNG of one pixel that says how its values mean light.
fn png_that_says(pixel: [u8; 3], say: impl Fn(&mut png::Encoder<&mut Vec<u8>>)) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    say(&mut encoder);
    encoder.write_header().unwrap().write_image_data(&pixel).unwrap();
    bytes
}

#[test]
fn a_png_s_own_numbers_are_honored_unless_it_names_a_space() {
    let scaled = png::ScaledFloat::new;
    let pixel = [128, 64, 200];
    let values = pixel.map(|value| f64::from(value) / 255.0);
    let photo = |say: &dyn Fn(&mut png::Encoder<&mut Vec<u8>>)| {
        let photo = seen(&png_that_says(pixel, say)).unwrap();
        assert!(photo.notes.is_empty(), "{:?}", photo.notes);
        photo.pixels.at(0, 0)
    };
    assert_near(photo(&|png| png.set_source_gamma(scaled(1.0))), values, 1e-6);
    assert_near(photo(&|png| png.set_source_gamma(scaled(0.5))), values.map(|value| value * value), 1e-6);
    // What those write who mean sRGB.
    assert_near(photo(&|png| png.set_source_gamma(scaled(0.45455))), light(values), 1e-6);
    let named = photo(&|png| {
        png.set_source_gamma(scaled(1.0));
        png.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    });
    assert_near(named, light(values), 1e-6);
    let primaries = |white, red, green, blue| png::SourceChromaticities::new(white, red, green, blue);
    let srgb = primaries((0.3127, 0.329), (0.64, 0.33), (0.3, 0.6), (0.15, 0.06));
    assert_near(photo(&|png| png.set_source_chromaticities(srgb)), light(values), 1e-6);
    // Of P3 as its profile says, whose matrix is rounded.
    let wide = primaries((0.3127, 0.329), (0.68, 0.32), (0.265, 0.69), (0.15, 0.06));
    let [r, g, b] = light(values);
    let wanted = [1.2249 * r - 0.2247 * g, -0.0420 * r + 1.0419 * g, -0.0197 * r - 0.0786 * g + 1.0979 * b];
    assert_near(photo(&|png| png.set_source_chromaticities(wide)), wanted, 2e-3);
    let senseless = primaries((0.0, 0.0), (0.0, 0.0), (0.0, 0.0), (0.0, 0.0));
    assert_near(photo(&|png| png.set_source_chromaticities(senseless)), light(values), 1e-6);
}

#[test]
fn sixteen_bits_stay_sixteen() {
    let picture = image::ImageBuffer::from_fn(2, 1, |x, _| image::Rgb([0x1234 + x as u16, 0x8000, 0xffff]));
    for format in [ImageFormat::Png, ImageFormat::Tiff] {
        let photo = seen(&encoded(DynamicImage::ImageRgb16(picture.clone()), format)).unwrap();
        let [first, second] = [photo.pixels.at(0, 0), photo.pixels.at(1, 0)];
        assert!(second[0] > first[0]);
        assert_near(first, light([f64::from(0x1234) / 65535.0, f64::from(0x8000) / 65535.0, 1.0]), 1e-7);
    }
}

#[test]
fn what_is_transparent_shows_the_paper_in_linear_light() {
    let paper = LinearRgb([0.9, 0.8, 0.6]);
    let on_paper = |bytes: &[u8]| {
        let limits = PictureLimits::of_photo(1000);
        read_photo(Cursor::new(bytes), None, &limits, paper).unwrap().pixels
    };
    let mut picture = RgbaImage::from_pixel(3, 1, Rgba([255, 0, 0, 0]));
    picture.put_pixel(1, 0, Rgba([188, 188, 188, 51]));
    picture.put_pixel(2, 0, Rgba([0, 255, 0, 255]));
    for format in [ImageFormat::Png, ImageFormat::Tiff, ImageFormat::WebP] {
        let seen = on_paper(&encoded(picture.clone(), format));
        assert_near(seen.at(0, 0), paper.0, 1e-6);
        let [gray, ..] = light([188.0 / 255.0; 3]);
        assert_near(seen.at(1, 0), paper.0.map(|paper| 0.8 * paper + 0.2 * gray), 1e-6);
        assert_near(seen.at(2, 0), [0.0, 1.0, 0.0], 0.0);
    }
    let gray = image::ImageBuffer::from_pixel(1, 1, image::LumaA([0u8, 102]));
    let seen = on_paper(&encoded(gray, ImageFormat::Png));
    assert_near(seen.at(0, 0), paper.0.map(|paper| 0.6 * paper), 1e-6);
}

#[test]
fn palettes_are_read() {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 2, 1);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Two);
    encoder.set_palette(vec![51, 0, 0, 0, 51, 255]);
    encoder.set_trns(vec![255, 0]);
    encoder.write_header().unwrap().write_image_data(&[0b0001_0000]).unwrap();
    let photo = seen(&bytes).unwrap();
    assert_near(photo.pixels.at(0, 0), light([0.2, 0.0, 0.0]), 1e-6);
    assert_near(photo.pixels.at(1, 0), [1.0; 3], 0.0);
}

/// A picture of six gray squares that says how it is to be turned, in four formats.
fn turned(orientation: u8) -> Vec<Vec<u8>> {
    const SIDE: u32 = 8;
    let picture = RgbImage::from_fn(3 * SIDE, 2 * SIDE, |x, y| {
        image::Rgb([(40 * (x / SIDE + 3 * (y / SIDE))) as u8; 3])
    });
    // Big-endian TIFF of one tag.
    let mut exif = b"MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\0\0\0\0\0\0\0".to_vec();
    exif[19] = orientation;
    let (width, height, kind) = (picture.width(), picture.height(), ExtendedColorType::Rgb8);
    let (mut png, mut jpeg, mut webp) = (Vec::new(), Vec::new(), Vec::new());
    let mut encoder = PngEncoder::new(&mut png);
    encoder.set_exif_metadata(exif.clone()).unwrap();
    encoder.write_image(&picture, width, height, kind).unwrap();
    let mut encoder = JpegEncoder::new_with_quality(&mut jpeg, 100);
    encoder.set_exif_metadata(exif.clone()).unwrap();
    encoder.write_image(&picture, width, height, kind).unwrap();
    let mut encoder = WebPEncoder::new_lossless(&mut webp);
    encoder.set_exif_metadata(exif).unwrap();
    encoder.write_image(&picture, width, height, kind).unwrap();
    let mut tiff = Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut tiff).unwrap();
    let mut image = encoder.new_image::<tiff::encoder::colortype::RGB8>(width, height).unwrap();
    image.encoder().write_tag(tiff::tags::Tag::Orientation, u16::from(orientation)).unwrap();
    image.write_data(&picture).unwrap();
    vec![png, jpeg, webp, tiff.into_inner()]
}

#[test]
fn every_orientation_becomes_upright() {
    for (orientation, upright) in [
        (1, "abc/def"),
        (2, "cba/fed"),
        (3, "fed/cba"),
        (4, "def/abc"),
        (5, "ad/be/cf"),
        (6, "da/eb/fc"),
        (7, "fc/eb/da"),
        (8, "cf/be/ad"),
        // No orientation there is: as stored.
        (9, "abc/def"),
    ] {
        for (format, bytes) in turned(orientation).iter().enumerate() {
            let photo = seen(bytes).unwrap();
            assert_eq!(photo.stored_size, (24, 16));
            let size = read_size(Cursor::new(bytes), None, &PictureLimits::default()).unwrap();
            assert_eq!(size, (photo.pixels.width() as u32, photo.pixels.height() as u32));
            for (y, row) in upright.split('/').enumerate() {
                assert_eq!(photo.pixels.width(), 8 * row.len());
                for (x, square) in row.bytes().enumerate() {
                    let wanted = light([f64::from(40 * (square - b'a')) / 255.0; 3]);
                    assert_near(photo.pixels.at(8 * x + 4, 8 * y + 4), wanted, 0.01);
                }
            }
            let map = read(bytes).unwrap();
            assert_eq!(
                (map.width(), map.height()),
                (photo.pixels.width(), photo.pixels.height()),
                "{format}"
            );
        }
    }
}

fn with_profile(color: [u8; 3], profile: Vec<u8>) -> Photo {
    let mut bytes = Vec::new();
    let mut encoder = PngEncoder::new(&mut bytes);
    encoder.set_icc_profile(profile).unwrap();
    encoder.write_image(&color, 1, 1, ExtendedColorType::Rgb8).unwrap();
    seen(&bytes).unwrap()
}

#[test]
fn display_p3_and_adobe_rgb_become_srgb() {
    let [r, g, b] = light([200.0 / 255.0, 120.0 / 255.0, 80.0 / 255.0]);
    let photo = with_profile([200, 120, 80], ColorProfile::new_display_p3().encode().unwrap());
    // SMPTE EG 432-1 primaries at D65 to those of sRGB.
    let wanted = [
        1.224_940_2 * r - 0.224_940_2 * g,
        -0.042_057_0 * r + 1.042_057_0 * g,
        -0.019_637_6 * r - 0.078_636_0 * g + 1.098_273_6 * b,
    ];
    assert_near(photo.pixels.at(0, 0), wanted, 1e-3);
    assert!(photo.notes.is_empty());

    let photo = with_profile([200, 120, 80], ColorProfile::new_adobe_rgb().encode().unwrap());
    let [r, g, b] = [200.0f64, 120.0, 80.0].map(|value| (value / 255.0).powf(563.0 / 256.0));
    let wanted = [1.398_355_7 * r - 0.398_355_7 * g, g, -0.042_932_9 * g + 1.042_932_9 * b];
    assert_near(photo.pixels.at(0, 0), wanted, 1e-3);

    // What sRGB cannot show is cut off, and white is white.
    let photo = with_profile([0, 255, 0], ColorProfile::new_display_p3().encode().unwrap());
    assert_eq!(photo.pixels.at(0, 0)[0], 0.0);
    let photo = with_profile([255; 3], ColorProfile::new_display_p3().encode().unwrap());
    assert_near(photo.pixels.at(0, 0), [1.0; 3], 1e-6);
}

#[test]
fn profiles_are_found_in_every_format_that_has_them() {
    let profile = ColorProfile::new_display_p3().encode().unwrap();
    let color = [200, 120, 80];
    let mut files: Vec<Vec<u8>> = vec![Vec::new(); 3];
    let [png, jpeg, webp] = &mut files[..] else { unreachable!() };
    fn write(mut encoder: impl ImageEncoder, profile: &[u8], color: [u8; 3]) {
        encoder.set_icc_profile(profile.to_vec()).unwrap();
        encoder.write_image(&color, 1, 1, ExtendedColorType::Rgb8).unwrap();
    }
    write(PngEncoder::new(png), &profile, color);
    write(JpegEncoder::new_with_quality(jpeg, 100), &profile, color);
    write(WebPEncoder::new_lossless(webp), &profile, color);
    let mut tiff = Cursor::new(Vec::new());
    write(image::codecs::tiff::TiffEncoder::new(&mut tiff), &profile, color);
    files.push(tiff.into_inner());
    let wanted = with_profile(color, profile);
    for bytes in files {
        let photo = seen(&bytes).unwrap();
        assert_near(photo.pixels.at(0, 0), wanted.pixels.at(0, 0).map(f64::from), 0.01);
        assert_ne!(
            photo,
            seen(&encoded(RgbImage::from_pixel(1, 1, image::Rgb(color)), ImageFormat::Png)).unwrap()
        );
    }
}

#[test]
fn a_profile_of_srgb_changes_nothing() {
    let mut profile = ColorProfile::new_srgb();
    profile.cicp = None;
    let photo = with_profile([200, 120, 80], profile.encode().unwrap());
    let plain =
        seen(&encoded(RgbImage::from_pixel(1, 1, image::Rgb([200, 120, 80])), ImageFormat::Png)).unwrap();
    assert_eq!(photo, plain);
}

#[test]
fn a_gray_profile_is_its_curve() {
    let mut bytes = Vec::new();
    let mut encoder = PngEncoder::new(&mut bytes);
    encoder.set_icc_profile(ColorProfile::new_gray_with_gamma(1.8).encode().unwrap()).unwrap();
    encoder.write_image(&[128], 1, 1, ExtendedColorType::L8).unwrap();
    let photo = seen(&bytes).unwrap();
    assert!(photo.notes.is_empty(), "{:?}", photo.notes);
    assert_near(photo.pixels.at(0, 0), [(128.0f64 / 255.0).powf(1.8); 3], 2e-3);
}

#[test]
fn a_damaged_profile_is_none_and_is_said() {
    let whole = ColorProfile::new_display_p3().encode().unwrap();
    let cut = whole[..150].to_vec();
    let gray = ColorProfile::new_gray_with_gamma(1.8).encode().unwrap();
    for profile in [b"no profile".to_vec(), cut, gray] {
        let photo = with_profile([200, 120, 80], profile);
        let wanted = light([200.0 / 255.0, 120.0 / 255.0, 80.0 / 255.0]);
        assert_near(photo.pixels.at(0, 0), wanted, 1e-6);
        assert!(photo.notes[0].contains("taken for sRGB"), "{:?}", photo.notes);
    }
}

/// A profile of four inks with colors at the corners only: gray from 100 down to 0 with black, whatever the rest.
fn inks_profile() -> Vec<u8> {
    let mut table = b"mft1\0\0\0\0\x04\x03\x02\0".to_vec();
    for row in 0..3 {
        table.extend((0..3).flat_map(|column| if row == column { [0, 1, 0, 0] } else { [0; 4] }));
    }
    let ramp: Vec<u8> = (0..=255).collect();
    table.extend(ramp.repeat(4));
    // The last channel varies fastest.
    table.extend((0..16).flat_map(|corner| [if corner & 1 == 1 { 0 } else { 255 }, 128, 128]));
    table.extend(ramp.repeat(3));
    let mut profile = vec![0; 128];
    profile[8] = 2;
    profile[12..24].copy_from_slice(b"prtrCMYKLab ");
    profile[36..40].copy_from_slice(b"acsp");
    profile[68..80].copy_from_slice(&[0, 0, 0xf6, 0xd6, 0, 1, 0, 0, 0, 0, 0xd3, 0x2d]);
    profile.extend(1u32.to_be_bytes());
    profile.extend(b"A2B0");
    profile.extend(144u32.to_be_bytes());
    profile.extend((table.len() as u32).to_be_bytes());
    profile.extend(table);
    let length = profile.len() as u32;
    profile[..4].copy_from_slice(&length.to_be_bytes());
    profile
}

const INKS: &[u8] = include_bytes!("fixtures/cmyk.jpg");

#[test]
fn inks_are_guessed_and_it_is_said() {
    let photo = seen(INKS).unwrap();
    assert!(photo.notes[0].contains("CMYK"), "{:?}", photo.notes);
    assert_near(photo.pixels.at(8, 8), [0.0, 1.0, 1.0], 0.01);
    assert_near(photo.pixels.at(24, 8), [1.0; 3], 0.01);
    assert_near(photo.pixels.at(40, 8), light([128.0 / 255.0; 3]), 0.01);
    assert!((read(INKS).unwrap().at(40, 8) - 0.5).abs() < 0.01);
}

#[test]
fn inks_of_a_tiff_are_guessed_as_well() {
    let mut file = Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut file).unwrap();
    encoder.write_image::<tiff::encoder::colortype::CMYK8>(1, 1, &[255, 0, 0, 0]).unwrap();
    let photo = seen(file.get_ref()).unwrap();
    assert!(photo.notes[0].contains("CMYK"), "{:?}", photo.notes);
    assert_near(photo.pixels.at(0, 0), [0.0, 1.0, 1.0], 0.0);
}

#[test]
fn inks_as_luma_and_chroma_are_separated() {
    // The same numbers, said to be luma and chroma: 0, 255, 255 for cyan, 255 thrice for white.
    let mut bytes = INKS.to_vec();
    let adobe = bytes.windows(5).position(|window| window == b"Adobe").unwrap();
    bytes[adobe + 11] = 2;
    let photo = seen(&bytes).unwrap();
    let red = 255.0 - 1.402 * 127.0;
    let blue = 255.0 - 1.772 * 127.0;
    assert_near(photo.pixels.at(8, 8), light([red / 255.0, 1.0, blue / 255.0]), 0.02);
}

#[test]
fn inks_go_through_their_profile() {
    let mut bytes = INKS[..2].to_vec();
    let profile = inks_profile();
    bytes.extend([0xff, 0xe2]);
    bytes.extend((profile.len() as u16 + 16).to_be_bytes());
    bytes.extend(b"ICC_PROFILE\0\x01\x01");
    bytes.extend(profile);
    bytes.extend(&INKS[2..]);
    let photo = seen(&bytes).unwrap();
    assert!(photo.notes.is_empty(), "{:?}", photo.notes);
    assert_near(photo.pixels.at(8, 8), [1.0; 3], 0.01);
    // L* of 50.2: black covers 127 of 255.
    assert_near(photo.pixels.at(40, 8), [((128.0 / 255.0 * 100.0 + 16.0) / 116.0f64).powi(3); 3], 0.01);
}

#[test]
fn of_several_pictures_the_first_is_read_and_it_is_said() {
    let frame = |gray| RgbaImage::from_pixel(2, 2, Rgba([gray, gray, gray, 255]));
    let mut gif = Vec::new();
    {
        let mut encoder = image::codecs::gif::GifEncoder::new(&mut gif);
        let frames = [frame(255), frame(0)].map(image::Frame::new);
        encoder.encode_frames(frames).unwrap();
    }
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, 1, 1);
    encoder.set_animated(2, 0).unwrap();
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&[255]).unwrap();
    writer.write_image_data(&[0]).unwrap();
    writer.finish().unwrap();
    let mut tiff = Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut tiff).unwrap();
    for gray in [255, 0] {
        encoder.write_image::<tiff::encoder::colortype::Gray8>(1, 1, &[gray]).unwrap();
    }
    for (bytes, said) in [(&gif, "animation"), (&png, "animation"), (tiff.get_ref(), "several pages")] {
        let photo = seen(bytes).unwrap();
        assert_near(photo.pixels.at(0, 0), [1.0; 3], 0.0);
        assert!(photo.notes.len() == 1 && photo.notes[0].contains(said), "{:?}", photo.notes);
    }
    let still = seen(&encoded(frame(255), ImageFormat::Gif)).unwrap();
    assert!(still.notes.is_empty());
}
