//! Maps that a document names: pictures, or one array of an `.npz`.

use std::io::{self, Cursor, Read, Write};

use girtin_grid::Raster;
use girtin_grid::memory::{NoRoom, probe};
use png::{BitDepth, ColorType, Decoder, DecodingError};
use zip::ZipArchive;

use crate::maps::StoredMap;
use crate::picture::{
    PictureError, PictureLimits, PictureMeta, WriteError, plain, read_grey, write_grey_png, write_grey_png_16,
};
use crate::state_file::npy::{self, Element};

/// Why a map cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// The picture cannot be read.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// There is no memory for it.
    #[error(transparent)]
    NoRoom(#[from] NoRoom),
    /// The archive or its array cannot be read.
    #[error("{0}")]
    Array(String),
}

impl MapError {
    /// What to do about it.
    pub fn hint(&self) -> Option<&'static str> {
        match self {
            Self::Picture(error) => error.hint(),
            Self::NoRoom(_) => Some("reduce the map first"),
            Self::Array(_) => Some("save one array of two axes: np.savez(file, map.astype('float32'))"),
        }
    }
}

/// Reads a map, 0 to 1: a picture's grey, or the one array of an `.npz` with two axes.
///
/// # Errors
/// The bytes are neither, are damaged, too large, or hold a value that is not finite.
pub fn read(bytes: &[u8], limits: &PictureLimits) -> Result<Raster<f32>, MapError> {
    if bytes.starts_with(b"PK") {
        read_npz(bytes, limits)
    } else {
        Ok(read_grey(Cursor::new(bytes), limits)?)
    }
}

/// Writes a stored map as the grey PNG that [`read_stored`] reads.
///
/// # Errors
/// The writer fails, or the map is larger than a PNG can be.
pub fn write_stored(writer: impl Write, map: &StoredMap) -> Result<(), WriteError> {
    write_stored_with(writer, map, &PictureMeta::default())
}

/// The same with what the picture is to say of itself.
///
/// # Errors
/// As [`write_stored`], or it cannot say that.
pub fn write_stored_with(writer: impl Write, map: &StoredMap, meta: &PictureMeta) -> Result<(), WriteError> {
    match map {
        StoredMap::Bytes(raster) => write_grey_png(writer, raster, meta),
        StoredMap::Words(raster) => write_grey_png_16(writer, raster, meta),
    }
}

/// Reads a grey PNG of 8 or 16 bits as it is stored.
///
/// # Errors
/// The bytes are none, are damaged, or the map is larger than `limits`.
pub fn read_stored(bytes: &[u8], limits: &PictureLimits) -> Result<StoredMap, MapError> {
    let fault = |error: DecodingError| match error {
        DecodingError::IoError(error) if error.kind() != io::ErrorKind::UnexpectedEof => {
            PictureError::Read(error)
        }
        DecodingError::LimitsExceeded => PictureError::Memory { most: limits.decoder_bytes },
        other => PictureError::Damaged(plain(&other.to_string())),
    };
    let most = usize::try_from(limits.decoder_bytes).unwrap_or(usize::MAX);
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: most });
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let mut reader = decoder.read_info().map_err(fault)?;
    let (width, height) = reader.info().size();
    if u64::from(width) * u64::from(height) > limits.pixels {
        return Err(PictureError::TooLarge { width, height, most: limits.pixels }.into());
    }
    let depth = reader.info().bit_depth;
    if reader.info().color_type != ColorType::Grayscale
        || !matches!(depth, BitDepth::Eight | BitDepth::Sixteen)
    {
        return Err(PictureError::Unsupported("it is not grey of 8 or 16 bits".to_owned()).into());
    }
    let (width, height) = (width as usize, height as usize);
    let bytes = width * height * if depth == BitDepth::Eight { 1 } else { 2 };
    if bytes as u64 > limits.decoder_bytes {
        return Err(PictureError::Memory { most: limits.decoder_bytes }.into());
    }
    probe([bytes as u64; 2])?;
    let mut values = vec![0; bytes];
    reader.next_frame(&mut values).map_err(fault)?;
    reader.finish().map_err(fault)?;
    Ok(match depth {
        BitDepth::Eight => StoredMap::Bytes(Raster::from_fn(width, height, |x, y| values[y * width + x])),
        _ => StoredMap::Words(Raster::from_fn(width, height, |x, y| {
            let at = 2 * (y * width + x);
            u16::from_be_bytes([values[at], values[at + 1]])
        })),
    })
}

fn read_npz(bytes: &[u8], limits: &PictureLimits) -> Result<Raster<f32>, MapError> {
    let fault = |why: String| MapError::Array(why);
    let mut archive =
        ZipArchive::new(Cursor::new(bytes)).map_err(|error| fault(format!("not an npz: {error}")))?;
    if archive.len() != 1 {
        return Err(fault(format!("the npz holds {} arrays, not one", archive.len())));
    }
    let mut file = archive.by_index(0).map_err(|error| fault(error.to_string()))?;
    let header =
        npy::read_header(&mut file).map_err(|_| fault("the array's header is damaged".to_owned()))?;
    let &[height, width] = header.shape.as_slice() else {
        return Err(fault(format!("the array has {} axes, not two", header.shape.len())));
    };
    let cells = height.checked_mul(width).filter(|&cells| cells > 0 && cells <= limits.pixels);
    let cells = cells.ok_or_else(|| fault(format!("the array is {width} × {height}")))?;
    let descr = header.descr.as_deref();
    let element = descr.and_then(Element::of).ok_or_else(|| {
        fault(format!("the array is of {}", descr.map_or("a structure".to_owned(), npy::type_name)))
    })?;
    // Read as it comes, so that a header alone makes nothing large.
    let mut data = Vec::new();
    let wanted = cells * element.bytes() as u64;
    file.by_ref().take(wanted).read_to_end(&mut data).map_err(|error| fault(error.to_string()))?;
    if data.len() as u64 != wanted {
        return Err(fault("the array ends early".to_owned()));
    }
    probe([4 * cells; 2])?;
    let mut values = Vec::with_capacity(cells as usize);
    element.decode(&data, &mut values);
    if values.iter().any(|value| !value.is_finite()) {
        return Err(fault("the array holds a value that is not finite".to_owned()));
    }
    let (width, height) = (width as usize, height as usize);
    Ok(Raster::from_fn(width, height, |x, y| {
        values[if header.fortran_order { x * height + y } else { y * width + x }]
    }))
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use proptest::prelude::*;
    use zip::ZipWriter;
    use zip::write::SimpleFileOptions;

    use super::*;
    use crate::picture::{PictureMeta, write_grey_png};

    fn npz(arrays: &[(&str, Vec<u8>)]) -> Vec<u8> {
        let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
        for (name, bytes) in arrays {
            zip.start_file(*name, SimpleFileOptions::default()).unwrap();
            zip.write_all(bytes).unwrap();
        }
        zip.finish().unwrap().into_inner()
    }

    fn array(descr: &str, shape: &[usize], values: &[u8]) -> Vec<u8> {
        let mut bytes = npy::header(descr, shape);
        bytes.extend_from_slice(values);
        bytes
    }

    fn floats(values: &[f32]) -> Vec<u8> {
        values.iter().flat_map(|value| value.to_le_bytes()).collect()
    }

    fn read(bytes: &[u8]) -> Result<Raster<f32>, MapError> {
        super::read(bytes, &PictureLimits::default())
    }

    #[test]
    fn a_picture_and_an_array_are_the_same_map() {
        let mut png = Vec::new();
        let grey = Raster::from_fn(3, 2, |x, y| (100 * x + 20 * y) as u8);
        write_grey_png(&mut png, &grey, &PictureMeta::default()).unwrap();
        let wanted = grey.map(|grey| f32::from(grey) / 255.0);
        assert_eq!(read(&png).unwrap(), wanted);
        let npz = npz(&[("map.npy", array("<f4", &[2, 3], &floats(wanted.as_slice())))]);
        assert_eq!(read(&npz).unwrap(), wanted);
    }

    #[test]
    fn every_type_that_a_state_may_have_is_read() {
        let wanted = Raster::from_fn(2, 1, |x, _| x as f32);
        let values = [0.0f64, 1.0];
        for (descr, bytes) in [
            ("|b1", vec![0, 1]),
            ("<f8", values.iter().flat_map(|value| value.to_le_bytes()).collect()),
            (">f8", values.iter().flat_map(|value| value.to_be_bytes()).collect()),
            (">f4", values.iter().flat_map(|&value| (value as f32).to_be_bytes()).collect()),
        ] {
            let npz = npz(&[("map.npy", array(descr, &[1, 2], &bytes))]);
            assert_eq!(read(&npz).unwrap(), wanted, "{descr}");
        }
    }

    #[test]
    fn what_is_no_map_is_refused_with_its_reason() {
        let one = array("<f4", &[1, 1], &floats(&[0.5]));
        for (bytes, reason) in [
            (npz(&[("a.npy", one.clone()), ("b.npy", one)]), "2 arrays, not one"),
            (npz(&[("a.npy", array("<f4", &[2], &floats(&[0.5, 0.5])))]), "1 axes, not two"),
            (npz(&[("a.npy", array("<i8", &[1, 1], &[0; 8]))]), "the array is of"),
            (npz(&[("a.npy", array("<f4", &[1, 2], &floats(&[0.5])))]), "ends early"),
            (npz(&[("a.npy", array("<f4", &[1, 1], &floats(&[f32::NAN])))]), "not finite"),
            (npz(&[("a.npy", array("<f4", &[1 << 40, 1 << 40], &[]))]), "the array is 1099511627776"),
        ] {
            let error = read(&bytes).unwrap_err();
            assert!(error.to_string().contains(reason), "{error} for {reason}");
            assert!(error.hint().is_some());
        }
    }

    #[test]
    fn stored_maps_are_read_as_they_were_stored() {
        let words = StoredMap::Words(Raster::from_fn(300, 220, |x, y| (257 * x + y) as u16));
        let bytes = StoredMap::Bytes(Raster::from_fn(300, 220, |x, y| (x ^ y) as u8));
        // Of words that bytes could hold, too.
        let plain = StoredMap::Words(Raster::new(2, 1, 257));
        for map in [words, bytes, plain] {
            let mut file = Vec::new();
            write_stored(&mut file, &map).unwrap();
            assert_eq!(read_stored(&file, &PictureLimits::default()).unwrap(), map);
            let small = PictureLimits { pixels: 1, ..PictureLimits::default() };
            assert!(matches!(
                read_stored(&file, &small),
                Err(MapError::Picture(PictureError::TooLarge { .. }))
            ));
            let small = PictureLimits { decoder_bytes: 1, ..PictureLimits::default() };
            assert!(matches!(
                read_stored(&file, &small),
                Err(MapError::Picture(PictureError::Memory { .. }))
            ));
            for end in [0, 20, 50, file.len() - 20] {
                let error = read_stored(&file[..end], &PictureLimits::default()).unwrap_err();
                assert!(matches!(error, MapError::Picture(PictureError::Damaged(_))), "{error}");
            }
        }
    }

    proptest! {
        #[test]
        fn no_stored_bytes_make_the_reader_panic(change in any::<u8>(), at in any::<prop::sample::Index>()) {
            let mut file = Vec::new();
            write_stored(&mut file, &StoredMap::Words(Raster::from_fn(9, 7, |x, y| (x * y) as u16))).unwrap();
            let at = at.index(file.len());
            file[at] ^= change;
            let _ = read_stored(&file, &PictureLimits::default());
        }

        #[test]
        fn no_bytes_make_the_reader_panic(change in any::<u8>(), at in any::<prop::sample::Index>(), cut in any::<prop::sample::Index>()) {
            let mut bytes = npz(&[("map.npy", array("<f8", &[2, 2], &[1; 32]))]);
            let end = cut.index(bytes.len()) + 1;
            let at = at.index(bytes.len());
            bytes[at] ^= change;
            let _ = read(&bytes);
            let _ = read(&bytes[..end]);
        }
    }
}
