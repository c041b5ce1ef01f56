//! Files that are no picture, too large a picture, or half of one.

use proptest::prelude::*;

use super::*;

/// One small file of every format.
fn files() -> Vec<(&'static str, Vec<u8>)> {
    let picture = colors(7, 5);
    vec![
        ("png", encoded(picture.clone(), ImageFormat::Png)),
        ("jpeg", encoded(picture.clone(), ImageFormat::Jpeg)),
        ("progressive jpeg", include_bytes!("fixtures/progressive.jpg").to_vec()),
        ("cmyk jpeg", include_bytes!("fixtures/cmyk.jpg").to_vec()),
        ("tiff", encoded(picture.clone(), ImageFormat::Tiff)),
        ("webp", encoded(picture.clone(), ImageFormat::WebP)),
        ("lossy webp", include_bytes!("fixtures/lossy.webp").to_vec()),
        ("gif", encoded(picture.clone(), ImageFormat::Gif)),
        ("bmp", encoded(picture, ImageFormat::Bmp)),
    ]
}

#[test]
fn a_file_that_ends_early_is_refused_wherever_it_ends() {
    for (format, bytes) in files() {
        let whole = seen(&bytes).unwrap();
        for cut in 0..bytes.len() {
            let _ = read(&bytes[..cut]);
            match seen(&bytes[..cut]) {
                // Behind the pixels there are checksums and trailers.
                Ok(photo) => {
                    assert_eq!(photo, whole, "{format} of {cut} bytes");
                    assert!(bytes.len() - cut <= 16, "{format} of {cut} bytes, not {}", bytes.len());
                }
                Err(error) => {
                    assert!(error.hint().is_some(), "{format} of {cut} bytes: {error}");
                    assert!(
                        !matches!(error, PictureError::Unknown | PictureError::Unsupported(_)),
                        "{format} of {cut} bytes: {error}"
                    );
                }
            }
        }
        let error = seen(&bytes[..bytes.len() / 2]).unwrap_err();
        assert!(matches!(error, PictureError::Truncated), "{format}: {error:?}");
    }
}

#[test]
fn half_a_jpeg_is_no_gray_picture() {
    let whole = encoded(colors(64, 64), ImageFormat::Jpeg);
    // Its preview has an end marker of its own.
    let mut bytes = whole[..2].to_vec();
    bytes.extend([0xff, 0xe1, 0, 6, 0xff, 0xd8, 0xff, 0xd9]);
    bytes.extend(&whole[2..whole.len() - 200]);
    assert!(matches!(seen(&bytes), Err(PictureError::Truncated)));
}

fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg()))
    })
}

/// Files whose headers claim pixels that would take gigabytes.
fn bombs() -> Vec<(&'static str, Vec<u8>)> {
    files()
        .into_iter()
        .map(|(format, mut bytes)| {
            match format {
                "png" => {
                    bytes[16..24].copy_from_slice(&[0, 1, 0x86, 0xa0, 0, 1, 0x86, 0xa0]);
                    let sum = crc(&bytes[12..29]).to_be_bytes();
                    bytes[29..33].copy_from_slice(&sum);
                }
                "webp" | "lossy webp" => {
                    bytes = b"RIFF\x1e\0\0\0WEBPVP8X\x0a\0\0\0\0\0\0\0\xff\xff\xff\x0f\0\0".to_vec();
                    bytes.extend(b"VP8L\0\0\0\0");
                }
                "gif" => bytes[6..10].fill(0xff),
                "bmp" => {
                    bytes[18..22].copy_from_slice(&60_000i32.to_le_bytes());
                    bytes[22..26].copy_from_slice(&60_000i32.to_le_bytes());
                }
                "tiff" => {
                    let bytes = &mut bytes[..];
                    // Columns, rows, and rows of a strip.
                    for tag in [256u16, 257, 278] {
                        let entry = [&tag.to_le_bytes()[..], &[4, 0, 1, 0, 0, 0]].concat();
                        let at = bytes.windows(8).position(|window| window == entry).unwrap();
                        bytes[at + 8..at + 12].copy_from_slice(&90_000u32.to_le_bytes());
                    }
                }
                _ => {
                    let is_frame = |window: &[u8]| window[0] == 0xff && matches!(window[1], 0xc0 | 0xc2);
                    let frame = bytes.windows(2).position(is_frame).unwrap();
                    bytes[frame + 5..frame + 9].fill(0xff);
                }
            }
            (format, bytes)
        })
        .collect()
}

#[test]
fn a_bomb_is_refused_before_anything_is_decoded() {
    for (format, bytes) in bombs() {
        let error = seen(&bytes).unwrap_err();
        if format.ends_with("webp") {
            // Its pixels are smaller than its canvas, which the decoder refuses by itself.
            assert!(
                matches!(
                    error,
                    PictureError::TooLarge { .. } | PictureError::Damaged(_) | PictureError::Truncated
                ),
                "{error}"
            );
            continue;
        }
        let PictureError::TooLarge { width, height, most } = error else { panic!("{format}: {error}") };
        assert!(u64::from(width) * u64::from(height) > most && most == PictureLimits::PHOTO_PIXELS);
        assert!(error.is_of_limits() && error.hint().is_some());
        let said = error.to_string();
        assert!(said.contains(&width.to_string()) && said.contains(&most.to_string()), "{said}");
        assert!(read(&bytes).unwrap_err().is_of_limits());
    }
}

#[test]
fn a_bomb_that_is_only_a_head_is_a_bomb() {
    for (format, bytes) in bombs() {
        // A frame of a JPEG comes after its tables; the head of a TIFF is at its end.
        let end = match format {
            "png" | "bmp" | "webp" | "lossy webp" => 33,
            "gif" => 13,
            "tiff" => bytes.len(),
            _ => bytes.windows(2).position(|window| matches!(window, [0xff, 0xc0 | 0xc2])).unwrap() + 12,
        };
        let bytes = &bytes[..end.min(bytes.len())];
        let limits = PictureLimits::of_photo(PictureLimits::PHOTO_PIXELS);
        let size = read_size(Cursor::new(bytes), None, &limits).unwrap_err();
        for error in [seen(bytes).unwrap_err(), size] {
            assert!(matches!(error, PictureError::TooLarge { .. }), "{format}: {error}");
        }
    }
}

#[test]
fn damage_is_said_in_plain_language() {
    for (format, bytes) in files() {
        for at in 8..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x55;
            let Err(PictureError::Damaged(said)) = seen(&damaged) else { continue };
            let insides = ["CRC", "ChunkType", "0x", "{", "(", "\""];
            assert!(!insides.iter().any(|word| said.contains(word)), "{format}: {said}");
        }
    }
}

#[test]
fn limits_are_exact() {
    let bytes = encoded(GrayImage::new(64, 64), ImageFormat::Png);
    let limits = |pixels| PictureLimits { pixels, ..PictureLimits::default() };
    let error = read_grey(Cursor::new(&bytes), &limits(4095)).unwrap_err();
    assert!(matches!(error, PictureError::TooLarge { width: 64, height: 64, most: 4095 }), "{error}");
    assert!(read_grey(Cursor::new(&bytes), &limits(4096)).is_ok());
    let small = PictureLimits { decoder_bytes: 4000, ..PictureLimits::default() };
    assert!(matches!(read_grey(Cursor::new(&bytes), &small), Err(PictureError::Memory { most: 4000 })));
    let jpeg = encoded(GrayImage::new(64, 64), ImageFormat::Jpeg);
    assert!(matches!(read_grey(Cursor::new(&jpeg), &small), Err(PictureError::Memory { most: 4000 })));
}

#[test]
fn other_formats_are_named_with_what_to_do() {
    let of_type = |brand: &[u8]| [b"\0\0\0\x18ftyp", brand, b"\0\0\0\0mif1heic"].concat();
    for (bytes, name, hint) in [
        (of_type(b"heic"), "HEIC", "heif-convert"),
        (of_type(b"mif1"), "HEIC", "heif-convert"),
        (of_type(b"avif"), "AVIF", "JPEG or PNG"),
        (of_type(b"crx "), "raw file", "darktable-cli"),
        (of_type(b"isom"), "film", "ffmpeg"),
        (of_type(b"qt  "), "film", "ffmpeg"),
        (b"\0\0\0\x0cJXL \r\n\x87\n\0\0".to_vec(), "JPEG XL", "JPEG or PNG"),
        (b"\xff\x0a\xfa\x1f".to_vec(), "JPEG XL", "JPEG or PNG"),
        (b"II*\0\x10\0\0\0CR\x02\0".to_vec(), "raw file", "darktable-cli"),
        (b"FUJIFILMCCD-RAW 0201".to_vec(), "raw file", "darktable-cli"),
        (b"IIRO\x08\0\0\0".to_vec(), "raw file", "darktable-cli"),
        (b"IIU\0\x18\0\0\0".to_vec(), "raw file", "darktable-cli"),
        (b"8BPS\0\x01".to_vec(), "Photoshop", "flatten"),
        (b"%PDF-1.7".to_vec(), "PDF", "export"),
        (b"<svg xmlns=".to_vec(), "SVG", "export"),
        (b"\xef\xbb\xbf<?xml version='1.0'?>\n<!-- x --><svg/>".to_vec(), "SVG", "export"),
        (b"<!DOCTYPE html><html>".to_vec(), "web page", "download"),
    ] {
        let error = seen(&bytes).unwrap_err();
        assert!(error.to_string().contains(name), "{error} for {name}");
        assert!(error.hint().unwrap().contains(hint), "{:?} for {name}", error.hint());
    }
    assert!(matches!(seen(b""), Err(PictureError::NoBytes)));
    for bytes in [&b"hello"[..], b"[glaze]\nname = 1\n", &[0; 100]] {
        assert!(matches!(seen(bytes), Err(PictureError::Unknown)));
    }
}

/// A TIFF of one gray pixel with tags besides.
fn tiff_with(tags: &[(u16, u32)]) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut file).unwrap();
    let mut image = encoder.new_image::<tiff::encoder::colortype::Gray8>(1, 1).unwrap();
    for &(tag, value) in tags {
        image.encoder().write_tag(tiff::tags::Tag::from_u16_exhaustive(tag), value).unwrap();
    }
    image.write_data(&[255]).unwrap();
    file.into_inner()
}

#[test]
fn raw_files_that_are_tiffs_are_told_by_their_tags() {
    let is_raw = |bytes: &[u8], ending| {
        let limits = PictureLimits::default();
        match read_photo(Cursor::new(bytes), ending, &limits, girtin_optics::LinearRgb::WHITE) {
            Ok(_) => false,
            Err(PictureError::Format { found, .. }) => found.contains("raw"),
            Err(error) => panic!("{error}"),
        }
    };
    assert!(!is_raw(&tiff_with(&[]), None));
    assert!(!is_raw(&tiff_with(&[(330, 8)]), Some("tif")));
    assert!(is_raw(&tiff_with(&[(254, 1), (330, 8)]), None), "Nikon, Sony");
    assert!(is_raw(&tiff_with(&[(50706, 0x0104)]), Some("tif")), "DNG");
    assert!(is_raw(&tiff_with(&[]), Some("NEF")));
    assert!(is_raw(b"no known magic", Some("mrw")));
}

proptest! {
    #[test]
    fn damaged_files_never_panic(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in any::<prop::sample::Index>(),
        which in any::<prop::sample::Index>(),
    ) {
        let files = files();
        let (_, mut bytes) = which.get(&files).clone();
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        let limits = PictureLimits::of_photo(1 << 16);
        for bytes in [&bytes[..], &bytes[..cut.index(bytes.len())]] {
            let _ = read_photo(Cursor::new(bytes), None, &limits, girtin_optics::LinearRgb::WHITE);
            let _ = read_grey(Cursor::new(bytes), &limits);
        }
    }

    #[test]
    fn random_bytes_never_panic(
        bytes in prop::collection::vec(any::<u8>(), 0..300),
        magic in prop::sample::select(vec![
            &b""[..], b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"II*\0", b"MM\0*", b"RIFF\0\0\0\0WEBPVP8X", b"GIF89a", b"BM",
        ]),
    ) {
        let bytes = [magic, &bytes].concat();
        let limits = PictureLimits::of_photo(1 << 16);
        let _ = read_photo(Cursor::new(&bytes), None, &limits, girtin_optics::LinearRgb::WHITE);
        let _ = read_grey(Cursor::new(&bytes), &limits);
    }
}
