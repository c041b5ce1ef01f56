//! Which format a file is of, by its first bytes.

use std::io::{Read, Seek, SeekFrom};

use super::PictureError;

/// A format that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Png,
    Jpeg,
    Tiff,
    WebP,
    Gif,
    Bmp,
}

const SAVE: &str = "save it as JPEG or PNG";
const HEIC: &str = "save it as JPEG or PNG, for instance with `heif-convert photo.heic photo.jpg`";
const RAW: &str = "develop it first, for instance with `darktable-cli photo.raw photo.tif`";
const DRAWING: &str = "export it as a PNG of the size that is wanted";
const FILM: &str = "take one frame of it, for instance with `ffmpeg -i film.mp4 -frames:v 1 frame.png`";
const LAYERS: &str = "flatten its layers and save it as PNG or TIFF";
const CAMERA: &str = "a camera's raw file";

/// Formats that are known by their first bytes and not read.
const FOREIGN: [(&[u8], &str, &str); 22] = [
    (b"\xff\x0a", "a JPEG XL picture", SAVE),
    (b"\0\0\0\x0cJXL \r\n\x87\n", "a JPEG XL picture", SAVE),
    (b"\0\0\0\x0cjP  \r\n\x87\n", "a JPEG 2000 picture", SAVE),
    (b"\xff\x4f\xff\x51", "a JPEG 2000 picture", SAVE),
    (b"FUJIFILMCCD-RAW", CAMERA, RAW),
    (b"IIRO", CAMERA, RAW),
    (b"IIRS", CAMERA, RAW),
    (b"MMOR", CAMERA, RAW),
    (b"IIU\0", CAMERA, RAW),
    (b"FOVb", CAMERA, RAW),
    (b"8BPS", "a Photoshop file", LAYERS),
    (b"gimp xcf", "a GIMP file", LAYERS),
    (b"PK\x03\x04", "an archive", "name a picture that it holds"),
    (b"%PDF", "a PDF document", DRAWING),
    (b"%!PS", "a PostScript document", DRAWING),
    (b"\x76\x2f\x31\x01", "an OpenEXR picture", "save it as a PNG or TIFF of 16 bits"),
    (b"#?RADIANCE", "a Radiance picture", "save it as a PNG or TIFF of 16 bits"),
    (b"\0\0\x01\0", "an icon", "save it as PNG"),
    (b"DDS ", "a DDS texture", "save it as PNG"),
    (b"qoif", "a QOI picture", "save it as PNG"),
    (b"\x1a\x45\xdf\xa3", "a film", FILM),
    (b"BPG\xfb", "a BPG picture", SAVE),
];

/// Raw files that are TIFFs as well, and others that begin as nothing known, by the endings of their names.
const RAW_ENDINGS: [&str; 17] = [
    "3fr", "arw", "cr2", "cr3", "crw", "dcr", "dng", "erf", "iiq", "mrw", "nef", "nrw", "orf", "pef", "raf",
    "rw2", "srw",
];

/// The format of a file that begins with `head`; `ending` is what its name ends with, without the dot.
///
/// # Errors
/// It is none that is read.
pub(super) fn of(head: &[u8], ending: Option<&str>) -> Result<Kind, PictureError> {
    if head.is_empty() {
        return Err(PictureError::NoBytes);
    }
    let is_tiff = [&b"II*\0"[..], b"MM\0*", b"II+\0", b"MM\0+"].iter().any(|magic| head.starts_with(magic));
    let is_raw = ending.is_some_and(|ending| RAW_ENDINGS.iter().any(|raw| ending.eq_ignore_ascii_case(raw)));
    if head.starts_with(b"\x89PNG\r\n\x1a\n") {
        Ok(Kind::Png)
    } else if head.starts_with(b"\xff\xd8\xff") {
        Ok(Kind::Jpeg)
    } else if is_tiff && !is_raw && head.get(8..10) != Some(b"CR") {
        Ok(Kind::Tiff)
    } else if head.starts_with(b"RIFF") && head.get(8..12) == Some(b"WEBP") {
        Ok(Kind::WebP)
    } else if head.starts_with(b"GIF87a") || head.starts_with(b"GIF89a") {
        Ok(Kind::Gif)
    } else if head.starts_with(b"BM") && head.get(6..10) == Some(&[0; 4]) {
        Ok(Kind::Bmp)
    } else if let Some((found, hint)) = foreign(head) {
        Err(PictureError::Format { found, hint })
    } else if is_tiff || is_raw {
        Err(PictureError::Format { found: CAMERA, hint: RAW })
    } else if is_cut(head) {
        Err(PictureError::Truncated)
    } else {
        Err(PictureError::Unknown)
    }
}

/// Whether a file ends within the signature of a format that is read.
fn is_cut(head: &[u8]) -> bool {
    let is_riff = head.len() < 12 && head.starts_with(b"RIFF");
    let signatures: [&[u8]; 8] =
        [b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"II*\0", b"MM\0*", b"RIFF", b"GIF87a", b"GIF89a", b"BM"];
    is_riff
        || (head.len() < 10 && head.starts_with(b"BM"))
        || signatures.iter().any(|signature| signature.starts_with(head))
}

fn foreign(head: &[u8]) -> Option<(&'static str, &'static str)> {
    if let Some(&(_, found, hint)) = FOREIGN.iter().find(|(magic, ..)| head.starts_with(magic)) {
        return Some((found, hint));
    }
    if head.get(4..8) == Some(b"ftyp") {
        return Some(match head.get(8..12).unwrap_or_default() {
            b"avif" | b"avis" => ("an AVIF picture", SAVE),
            b"heic" | b"heix" | b"heim" | b"heis" | b"hevc" | b"hevx" | b"mif1" | b"msf1" => {
                ("a HEIC picture", HEIC)
            }
            b"crx " => (CAMERA, RAW),
            _ => ("a film", FILM),
        });
    }
    if head.starts_with(b"RIFF") && head.get(8..12) == Some(b"AVI ") {
        return Some(("a film", FILM));
    }
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    let text = text.trim_ascii_start().to_ascii_lowercase();
    let has = |tag: &[u8]| text.windows(tag.len()).any(|window| window == tag);
    if text.starts_with(b"<svg") || (text.starts_with(b"<?xml") && has(b"<svg")) {
        return Some(("an SVG drawing", DRAWING));
    }
    (text.starts_with(b"<!doctype html") || text.starts_with(b"<html"))
        .then_some(("a web page", "download the picture itself"))
}

/// Entries of a TIFF's first directory that are looked at.
const MOST_ENTRIES: u16 = 512;

/// Refuses raw files of cameras that are TIFFs as well: what would be read is their small preview.
///
/// They say so with a version of DNG, with a compression of their own, or by calling their first page a reduced one
/// and keeping others below it.
///
/// # Errors
/// It is one. What is no TIFF, or cannot be read, is left to the decoder.
pub(super) fn refuse_raw(reader: &mut (impl Read + Seek)) -> Result<(), PictureError> {
    let raw = PictureError::Format { found: CAMERA, hint: RAW };
    if is_raw(reader).unwrap_or(false) { Err(raw) } else { Ok(()) }
}

fn is_raw(reader: &mut (impl Read + Seek)) -> Option<bool> {
    let mut header = [0; 8];
    reader.seek(SeekFrom::Start(0)).ok()?;
    reader.read_exact(&mut header).ok()?;
    let is_big_endian = header[0] == b'M';
    let short =
        |bytes: [u8; 2]| if is_big_endian { u16::from_be_bytes(bytes) } else { u16::from_le_bytes(bytes) };
    let [.., a, b, c, d] = header;
    let offset =
        if is_big_endian { u32::from_be_bytes([a, b, c, d]) } else { u32::from_le_bytes([a, b, c, d]) };
    reader.seek(SeekFrom::Start(u64::from(offset))).ok()?;
    let mut count = [0; 2];
    reader.read_exact(&mut count).ok()?;
    let (mut is_reduced, mut has_pages_below) = (false, false);
    for _ in 0..short(count).min(MOST_ENTRIES) {
        let mut entry = [0; 12];
        reader.read_exact(&mut entry).ok()?;
        let [t0, t1, _, _, _, _, _, _, v0, v1, v2, v3] = entry;
        let long = if is_big_endian { [v3, v2, v1, v0] } else { [v0, v1, v2, v3] };
        match short([t0, t1]) {
            NEW_SUBFILE_TYPE => is_reduced = u32::from_le_bytes(long) & 1 == 1,
            COMPRESSION if OWN_COMPRESSIONS.contains(&short([v0, v1])) => return Some(true),
            SUB_IFDS => has_pages_below = true,
            DNG_VERSION => return Some(true),
            _ => {}
        }
    }
    Some(is_reduced && has_pages_below)
}

const NEW_SUBFILE_TYPE: u16 = 254;
const COMPRESSION: u16 = 259;
const SUB_IFDS: u16 = 330;
const DNG_VERSION: u16 = 50706;
/// Of Sony, Samsung, Nikon, Kodak and Pentax.
const OWN_COMPRESSIONS: [u16; 5] = [32767, 32770, 34713, 65000, 65535];
