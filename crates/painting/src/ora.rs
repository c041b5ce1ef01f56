//! OpenRaster: glazes as layers that Krita, GIMP and MyPaint open.
//!
//! A glaze of transparent pigment is nearly what painting programs call a layer that multiplies. [`GlazeLayers`] makes
//! such layers of the pictures after each glaze, and says how far the layers, put together as those programs do it,
//! are from the painting.

use std::io::{BufWriter, Seek, Write};

use girtin_grid::Raster;
use girtin_optics::color::{decode_srgb, encode_srgb};
use rayon::prelude::*;
use zip::ZipWriter;

use crate::archive::{self, Guarded};
use crate::picture::{PictureMeta, WriteError, write_png, write_png_rgba};

/// How a layer is laid over what is below it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Composite {
    /// It covers: `svg:src-over`.
    Over,
    /// Encoded values are multiplied: `svg:multiply`.
    Multiply,
}

impl Composite {
    /// Its name in the file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Over => "svg:src-over",
            Self::Multiply => "svg:multiply",
        }
    }
}

/// A layer of the size of the picture.
#[derive(Clone, Copy, Debug)]
pub struct OraLayer<'a> {
    /// What a program shows in its list.
    pub name: &'a str,
    /// sRGB and coverage, not multiplied in.
    pub pixels: &'a Raster<[u8; 4]>,
    /// How it is laid over what is below.
    pub composite: Composite,
    /// 0 to 1.
    pub opacity: f64,
}

/// An OpenRaster file on its way, one layer in memory at a time; equal layers give equal bytes.
///
/// # Source
/// OpenRaster 0.0.6, baseline.
pub struct OraFile<W: Write + Seek> {
    zip: ZipWriter<Guarded<BufWriter<W>>>,
    size: (usize, usize),
    meta: PictureMeta,
    /// Elements of the stack, the lowest first.
    layers: Vec<String>,
}

/// Longest side of the small picture that file managers show, pixels.
const THUMBNAIL: usize = 256;

impl<W: Write + Seek> OraFile<W> {
    /// Begins a file of `size` columns and rows.
    ///
    /// # Errors
    /// The writer fails.
    pub fn begin(writer: W, size: (usize, usize), pixels_per_mm: Option<f64>) -> Result<Self, WriteError> {
        let zip = ZipWriter::new(Guarded::new(BufWriter::new(writer)));
        let meta = PictureMeta { pixels_per_mm, text: Vec::new() };
        let mut file = Self { zip, size, meta, layers: Vec::new() };
        file.entry("mimetype", 0)?;
        file.zip.write_all(b"image/openraster").map_err(WriteError::Write)?;
        Ok(file)
    }

    /// Adds a layer above the others.
    ///
    /// # Errors
    /// The writer fails, or the layer has another size.
    pub fn layer(&mut self, layer: &OraLayer<'_>) -> Result<(), WriteError> {
        self.check((layer.pixels.width(), layer.pixels.height()))?;
        let source = format!("data/layer{:03}.png", self.layers.len());
        self.entry(&source, layer.pixels.as_slice().len())?;
        write_png_rgba(&mut self.zip, layer.pixels, &self.meta)?;
        self.layers.push(format!(
            "  <layer name=\"{}\" src=\"{source}\" x=\"0\" y=\"0\" opacity=\"{:.3}\" visibility=\"visible\" \
             composite-op=\"{}\"/>\n",
            escaped(layer.name),
            layer.opacity.clamp(0.0, 1.0),
            layer.composite.name(),
        ));
        Ok(())
    }

    /// Ends the file with the picture that the layers make together.
    ///
    /// # Errors
    /// The writer fails, or the picture has another size.
    pub fn end(mut self, merged: &Raster<[u8; 3]>) -> Result<(), WriteError> {
        self.check((merged.width(), merged.height()))?;
        self.entry("mergedimage.png", merged.as_slice().len())?;
        write_png(&mut self.zip, merged, &self.meta)?;
        self.entry("Thumbnails/thumbnail.png", 0)?;
        write_png(&mut self.zip, &thumbnail(merged), &PictureMeta::default())?;
        let stack = self.stack();
        self.entry("stack.xml", 0)?;
        self.zip.write_all(stack.as_bytes()).map_err(WriteError::Write)?;
        let mut writer = self.zip.finish().map_err(|error| WriteError::Write(archive::fault(error)))?;
        writer.flush().map_err(WriteError::Write)
    }

    /// Begins an entry of that many pixels.
    fn entry(&mut self, name: &str, pixels: usize) -> Result<(), WriteError> {
        // Packing makes noise a little larger than it is.
        let options = archive::stored(pixels as u64 * 4 / 100 * 101);
        self.zip.start_file(name, options).map_err(|error| WriteError::Write(archive::fault(error)))
    }

    fn check(&self, found: (usize, usize)) -> Result<(), WriteError> {
        let said = |(width, height)| format!("{width} × {height} pixels");
        let wrong = || WriteError::Parts { found: said(found), wanted: said(self.size) };
        if found == self.size { Ok(()) } else { Err(wrong()) }
    }

    /// The list of layers, the highest first.
    fn stack(&self) -> String {
        let (width, height) = self.size;
        let resolution = self.meta.pixels_per_mm.map_or(String::new(), |pixels_per_mm| {
            let dots = (pixels_per_mm * 25.4).round().max(1.0);
            format!(" xres=\"{dots}\" yres=\"{dots}\"")
        });
        let layers: String = self.layers.iter().rev().map(String::as_str).collect();
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<image version=\"0.0.6\" w=\"{width}\" h=\"{height}\"\
             {resolution}>\n <stack>\n{layers} </stack>\n</image>\n"
        )
    }
}

/// A text between the quotation marks of XML.
fn escaped(text: &str) -> String {
    let mut escaped = String::new();
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            // XML 1.0 has no way to hold them.
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => escaped.push(' '),
            c => escaped.push(c),
        }
    }
    escaped
}

/// The picture with its longest side at [`THUMBNAIL`] pixels at most, means of light.
fn thumbnail(picture: &Raster<[u8; 3]>) -> Raster<[u8; 3]> {
    let (width, height) = (picture.width(), picture.height());
    let longest = width.max(height);
    if longest <= THUMBNAIL {
        return picture.clone();
    }
    let light: Vec<f64> = (0..=255).map(|value| decode_srgb(f64::from(value) / 255.0)).collect();
    let small = |side: usize| (side * THUMBNAIL / longest).max(1);
    let (columns, rows) = (small(width), small(height));
    // What a small pixel covers, one pixel at least.
    let span = |at: usize, small: usize, side: usize| {
        let from = at * side / small;
        from..((at + 1) * side / small).max(from + 1)
    };
    Raster::from_fn(columns, rows, |x, y| {
        let (xs, ys) = (span(x, columns, width), span(y, rows, height));
        let count = (xs.len() * ys.len()) as f64;
        let mut sums = [0.0; 3];
        for pixel in ys.flat_map(|y| &picture.row(y)[xs.clone()]) {
            for (sum, &value) in sums.iter_mut().zip(pixel) {
                *sum += light[usize::from(value)];
            }
        }
        sums.map(|sum| (encode_srgb(sum / count) * 255.0).round() as u8)
    })
}

/// Makes a multiplying layer of each glaze, from the paper up.
#[derive(Clone, Debug)]
pub struct GlazeLayers {
    /// What paper and layers make so far, where a program rounds after every layer.
    below: Raster<[u8; 3]>,
    /// The same where it rounds at the end only.
    exact: Raster<[f32; 3]>,
}

/// How far two pictures are apart, in levels of 8 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Difference {
    /// Mean over pixels and channels.
    pub mean: f64,
    /// Largest.
    pub max: u8,
}

impl GlazeLayers {
    /// Begins with the bare paper, sRGB.
    pub fn new(paper: Raster<[u8; 3]>) -> Self {
        Self { exact: paper.map(|color| color.map(f32::from)), below: paper }
    }

    /// Lightens the pictures after each glaze, the bare paper first, where a later one is lighter: multiplying cannot, so
    /// that what a glaze hides is not to be there at all. The last picture stays as it is.
    ///
    /// # Panics
    /// They are of different sizes.
    pub fn lighten(pictures: &mut [Raster<[u8; 3]>]) {
        for last in (1..pictures.len()).rev() {
            let (below, above) = pictures.split_at_mut(last);
            let (below, above) = (&mut below[last - 1], &above[0]);
            assert_eq!((below.width(), below.height()), (above.width(), above.height()), "sizes of pictures");
            let channels = below.as_mut_slice().as_flattened_mut().par_iter_mut();
            channels
                .zip(above.as_slice().as_flattened())
                .for_each(|(below, above)| *below = (*below).max(*above));
        }
    }

    /// The layer that makes of everything below the picture after the glaze, where that is darker.
    ///
    /// What is below is what the layers so far make as they are written, so that rounding does not add up. Programs that
    /// round after every layer and those that round once both come to the picture, a level more or less.
    ///
    /// Multiplying cannot lighten: what a glaze lightens stays as it is, and shows in
    /// [`GlazeLayers::difference`]. Where nothing changes, the layer is transparent.
    ///
    /// # Panics
    /// The picture has another size than the paper.
    pub fn lay(&mut self, after: &Raster<[u8; 3]>) -> Raster<[u8; 4]> {
        let size = (after.width(), after.height());
        assert_eq!(size, (self.below.width(), self.below.height()), "sizes of glaze and paper");
        let mut layer = Raster::new(size.0, size.1, [0; 4]);
        let below = self.below.as_mut_slice().par_iter_mut().zip(self.exact.as_mut_slice());
        layer.as_mut_slice().par_iter_mut().zip(below).zip(after.as_slice()).for_each(
            |((layer, (below, exact)), after)| {
                let part: [u8; 3] = std::array::from_fn(|i| part(below[i], exact[i], after[i]));
                *below = std::array::from_fn(|i| multiplied(below[i], part[i]));
                *exact = std::array::from_fn(|i| exact[i] * f32::from(part[i]) / 255.0);
                let [r, g, b] = part;
                *layer = [r, g, b, if part == [255; 3] { 0 } else { 255 }];
            },
        );
        layer
    }

    /// What paper and layers make together.
    pub fn flattened(&self) -> &Raster<[u8; 3]> {
        &self.below
    }

    /// How far paper and layers as they are written are from the painting, whichever way of rounding is farther.
    ///
    /// # Panics
    /// The painting has another size than the paper.
    pub fn difference(&self, painting: &Raster<[u8; 3]>) -> Difference {
        let size = (painting.width(), painting.height());
        assert_eq!(size, (self.below.width(), self.below.height()), "sizes of painting and paper");
        let made = self.below.as_slice().as_flattened().iter().zip(self.exact.as_slice().as_flattened());
        let pairs = made.zip(painting.as_slice().as_flattened());
        let (mut sum, mut max) = (0u64, 0);
        for difference in pairs.map(|((a, exact), b)| a.abs_diff(*b).max((exact.round() as u8).abs_diff(*b)))
        {
            sum += u64::from(difference);
            max = max.max(difference);
        }
        let values = (3 * size.0 * size.1).max(1);
        Difference { mean: sum as f64 / values as f64, max }
    }
}

/// Two encoded values of 8 bits multiplied, as painting programs do it: to the nearest.
fn multiplied(below: u8, layer: u8) -> u8 {
    ((u32::from(below) * u32::from(layer) + 127) / 255) as u8
}

/// What multiplies both `below` and `exact` to `after`, or as near as can be. A step of the layer is less than a level
/// of the result, so that nearly every darker value is met.
fn part(below: u8, exact: f32, after: u8) -> u8 {
    let off = |part: u8| {
        let rounded = f32::from(multiplied(below, part).abs_diff(after));
        rounded.max((exact * f32::from(part) / 255.0 - f32::from(after)).abs())
    };
    // Half a level is what any picture is rounded by.
    if off(255) <= 0.5 {
        return 255;
    }
    let middle = (f32::from(after) * 255.0 / exact.max(1.0)).round().min(255.0) as u8;
    let near = (middle.saturating_sub(1)..=middle.saturating_add(1)).rev();
    near.min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap_or(middle)
}

#[cfg(test)]
mod tests;
