//! What the head of a PNG says besides its size.

use std::io::{BufReader, Read, Seek, SeekFrom};

use png::{Decoder, Info, Limits};

use super::PictureLimits;
use super::decode::of_header;

/// How stored values mean light, where a file has no color profile but says so in numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Encoding {
    /// Power of light that is stored.
    pub gamma: Option<f64>,
    /// Chromaticities of white, red, green and blue.
    pub primaries: Option<[[f64; 2]; 4]>,
}

/// The encoding that a PNG's `gAMA` and `cHRM` say; none if the file names a color space, which counts for more.
///
/// The reader is wherever it stopped.
pub(super) fn encoding(reader: &mut (impl Read + Seek), limits: &PictureLimits) -> Option<Encoding> {
    with_info(reader, limits, |info| {
        let is_named = info.srgb.is_some()
            || info.icc_profile.is_some()
            || info.coding_independent_code_points.is_some();
        let gamma = info.gama_chunk.map(|gamma| f64::from(gamma.into_scaled()) / 1e5);
        let primaries = info.chrm_chunk.map(|said| {
            let [white, red, green, blue] = [said.white, said.red, said.green, said.blue];
            [white, red, green, blue].map(|(x, y)| [x, y].map(|value| f64::from(value.into_scaled()) / 1e5))
        });
        let is_said = !is_named && (gamma.is_some() || primaries.is_some());
        is_said.then_some(Encoding { gamma, primaries })
    })
    .flatten()
}

/// A text that a PNG says of itself, such as its `Software`; none if it is no PNG, or does not say it before its pixels.
pub fn read_png_word(mut reader: impl Read + Seek, keyword: &str) -> Option<String> {
    with_info(&mut reader, &PictureLimits::default(), |info| {
        let mut words = info.uncompressed_latin1_text.iter();
        words.find(|word| word.keyword == keyword).map(|word| word.text.clone())
    })
    .flatten()
}

fn with_info<T>(
    reader: &mut (impl Read + Seek),
    limits: &PictureLimits,
    tell: impl FnOnce(&Info<'_>) -> T,
) -> Option<T> {
    reader.seek(SeekFrom::Start(0)).ok()?;
    let bytes = of_header(limits).max_alloc.unwrap_or(u64::MAX);
    let limits = Limits { bytes: usize::try_from(bytes).unwrap_or(usize::MAX) };
    // What is wrong with it, the decoder says.
    let reader = Decoder::new_with_limits(BufReader::new(reader), limits).read_info().ok()?;
    Some(tell(reader.info()))
}
