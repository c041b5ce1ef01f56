//! Pictures in every format that is written.

use std::io;

use exif::{In, Tag, Value};
use moxcms::{ColorProfile, DataColorSpace};
use proptest::prelude::*;

use super::png_files::{decoded, meta};
use super::*;

const ALL: [PictureFormat; 6] = [
    PictureFormat::Png8,
    PictureFormat::Png16,
    PictureFormat::Jpeg { quality: 95 },
    PictureFormat::Tiff8,
    PictureFormat::Tiff16,
    PictureFormat::WebP,
];

fn ramp(width: usize, height: usize) -> Raster<[u16; 3]> {
    Raster::from_fn(width, height, |x, y| [(x * 1500) as u16, (y * 2003) as u16, (x * y * 40) as u16])
}

fn written(picture: &impl Rows, format: PictureFormat, meta: &PictureMeta) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_picture(&mut bytes, picture, format, meta).unwrap();
    bytes
}

fn linear(value: f64) -> f64 {
    girtin_optics::color::decode_srgb(value)
}

#[test]
fn pixels_come_back_from_every_format() {
    // Wider than one strip of blocks, and no multiple of a block.
    let picture = ramp(37, 29);
    for format in ALL {
        let photo = seen(&written(&picture, format, &PictureMeta::default())).unwrap();
        assert!(photo.notes.is_empty(), "{format:?}: {:?}", photo.notes);
        assert_eq!((photo.pixels.width(), photo.pixels.height()), (37, 29));
        let most = match format {
            PictureFormat::Png16 | PictureFormat::Tiff16 => 1e-6,
            PictureFormat::Jpeg { .. } => 0.05,
            _ => 0.0045,
        };
        for (found, wanted) in photo.pixels.as_slice().iter().zip(picture.as_slice()) {
            for (&found, &wanted) in found.iter().zip(wanted) {
                let wanted = linear(f64::from(wanted) / 65535.0);
                assert!((f64::from(found) - wanted).abs() < most, "{format:?}: {found} is not {wanted}");
            }
        }
    }
}

#[test]
fn eight_bits_are_written_as_they_are() {
    let picture = Raster::from_fn(256, 3, |x, y| [x as u8, 255 - x as u8, (x * y) as u8]);
    let mut png = Vec::new();
    write_png(&mut png, &picture, &meta()).unwrap();
    assert_eq!(png, written(&picture, PictureFormat::Png8, &meta()));
    for format in [PictureFormat::Tiff8, PictureFormat::WebP] {
        let found = image::load_from_memory(&written(&picture, format, &meta())).unwrap().into_rgb8();
        assert_eq!(found.as_raw(), picture.as_slice().as_flattened());
    }
}

#[test]
fn light_is_written_as_it_is_encoded() {
    let light = Raster::from_fn(300, 4, |x, y| {
        let value = |i: usize| (x as f64 / 299.0).powi(1 + y as i32 + i as i32) * 1.02 - 0.01;
        girtin_optics::LinearRgb([0, 1, 2].map(value))
    });
    let bytes = crate::composite::encode(&light);
    assert_eq!(written(&light, PictureFormat::Png8, &meta()), written(&bytes, PictureFormat::Png8, &meta()));
    let deep = seen(&written(&light, PictureFormat::Tiff16, &meta())).unwrap().pixels;
    for (found, wanted) in deep.as_slice().iter().zip(light.as_slice()) {
        for (&found, wanted) in found.iter().zip(wanted.0) {
            assert!((f64::from(found) - wanted.clamp(0.0, 1.0)).abs() < 4e-5, "{found} is not {wanted}");
        }
    }
}

#[test]
fn equal_pictures_give_equal_bytes() {
    for format in ALL {
        assert_eq!(written(&ramp(20, 9), format, &meta()), written(&ramp(20, 9), format, &meta()));
    }
}

#[test]
fn every_file_says_that_it_is_srgb() {
    for format in ALL {
        let bytes = written(&ramp(9, 9), format, &PictureMeta::default());
        let profile = match format {
            PictureFormat::Png8 | PictureFormat::Png16 => {
                assert!(decoded(&bytes).0.srgb.is_some());
                continue;
            }
            _ => {
                let read = decode::decoded(Cursor::new(&bytes), None, &PictureLimits::default(), 0).unwrap();
                read.profile.unwrap_or_else(|| panic!("{format:?}"))
            }
        };
        assert_eq!(profile[24..36], [7, 0xe4, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0], "made at no time");
        let profile = ColorProfile::new_from_slice(&profile).unwrap();
        assert!(profile.color_space == DataColorSpace::Rgb && profile.is_matrix_shaper());
        let own = profile.transform_matrix(&ColorProfile::new_srgb());
        assert!((own.v[0][0] - 1.0).abs() < 1e-3 && own.v[0][1].abs() < 1e-3, "{own:?}");
    }
}

#[test]
fn resolution_and_texts_are_told() {
    for format in [
        PictureFormat::Jpeg { quality: 80 },
        PictureFormat::Tiff8,
        PictureFormat::Tiff16,
        PictureFormat::WebP,
    ] {
        let bytes = written(&ramp(9, 9), format, &meta());
        let exif = exif::Reader::new().read_from_container(&mut Cursor::new(&bytes)).unwrap();
        let field = |tag| exif.get_field(tag, In::PRIMARY).map(|field| field.value.clone());
        let Some(Value::Rational(dots)) = field(Tag::XResolution) else { panic!("{format:?}") };
        assert!((dots[0].to_f64() - 300.0).abs() < 0.01, "{format:?}: {}", dots[0].to_f64());
        let Some(Value::Short(unit)) = field(Tag::ResolutionUnit) else { panic!("{format:?}") };
        assert_eq!(unit, [2]);
        let Some(Value::Ascii(software)) = field(Tag::Software) else { panic!("{format:?}") };
        assert_eq!(software, [b"girtin 0.1.0"]);
        let Some(Value::Ascii(lines)) = field(Tag::ImageDescription) else { panic!("{format:?}") };
        assert_eq!(lines, ["girtin:seed: 7\nTitle: Kirkstall — œuvre".as_bytes()]);
        let plain = written(&ramp(9, 9), format, &PictureMeta::default());
        let exif = exif::Reader::new().read_from_container(&mut Cursor::new(&plain));
        assert!(!exif.is_ok_and(|exif| exif.get_field(Tag::Software, In::PRIMARY).is_some()));
    }
    let jpeg = written(&ramp(9, 9), PictureFormat::Jpeg { quality: 80 }, &meta());
    // JFIF: dots per inch, twice 300.
    assert_eq!(jpeg[6..18], *b"JFIF\0\x01\x02\x01\x01\x2c\x01\x2c");
}

#[test]
fn endings_tell_formats() {
    for ending in PictureFormat::ENDINGS {
        assert!(PictureFormat::of_extension(ending, false).is_some(), "{ending}");
    }
    assert_eq!(PictureFormat::of_extension("PNG", true), Some(PictureFormat::Png16));
    assert_eq!(PictureFormat::of_extension("tiff", true), Some(PictureFormat::Tiff16));
    for (ending, sixteen) in [("jpg", true), ("webp", true), ("gif", false), ("", false), (".png", false)] {
        assert_eq!(PictureFormat::of_extension(ending, sixteen), None, "{ending}");
    }
}

#[test]
fn what_a_format_cannot_hold_is_refused() {
    for format in ALL {
        let empty = Raster::<[u8; 3]>::new(0, 3, [0; 3]);
        let error = write_picture(io::sink(), &empty, format, &PictureMeta::default()).unwrap_err();
        assert!(matches!(error, WriteError::Size { width: 0, height: 3, .. }), "{error}");
        for bad in [0.0, -1.0, f64::NAN, 1e9] {
            let meta = PictureMeta { pixels_per_mm: Some(bad), ..PictureMeta::default() };
            let error = write_picture(io::sink(), &ramp(1, 1), format, &meta);
            // WebP has no resolution but in its EXIF.
            assert!(matches!(error, Err(WriteError::Resolution { .. })), "{format:?} of {bad}: {error:?}");
        }
    }
    let wide = Raster::new(70_000, 1, [0u8; 3]);
    for format in [PictureFormat::Jpeg { quality: 80 }, PictureFormat::WebP] {
        let error = write_picture(io::sink(), &wide, format, &PictureMeta::default()).unwrap_err();
        assert!(matches!(error, WriteError::Size { width: 70_000, .. }), "{error}");
    }
}

#[test]
fn a_full_disk_is_an_error_in_every_format() {
    for format in ALL {
        let whole = written(&ramp(20, 20), format, &meta());
        for room in 0..whole.len() {
            let mut disk = vec![0; room];
            let result = write_picture(disk.as_mut_slice(), &ramp(20, 20), format, &meta());
            assert!(matches!(result, Err(WriteError::Write(_))), "{format:?}, {room}: {result:?}");
        }
    }
}

proptest! {
    #[test]
    fn any_picture_comes_back_from_tiff(
        width in 1..20usize,
        values in prop::collection::vec(any::<[u16; 3]>(), 1..100),
    ) {
        let height = values.len().div_ceil(width);
        let picture =
            Raster::from_fn(width, height, |x, y| values.get(y * width + x).copied().unwrap_or_default());
        let bytes = written(&picture, PictureFormat::Tiff16, &PictureMeta::default());
        let found = image::load_from_memory(&bytes).unwrap().into_rgb16();
        prop_assert_eq!(found.as_raw().as_slice(), picture.as_slice().as_flattened());
    }
}
