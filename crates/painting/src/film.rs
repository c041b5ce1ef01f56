//! A painting as it grows: animated PNG and GIF, frame by frame.
//!
//! A frame holds what changed since the one before. Equal frames give equal bytes.

use std::io::Write;
use std::ops::Range;

use girtin_grid::Raster;
use png::{BitDepth, ColorType};

use crate::picture::{PictureMeta, WriteError, encoder, sides};

/// What a film is written as. Both are shown over and over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FilmFormat {
    /// Animated PNG, exact.
    Apng,
    /// GIF, 256 colors to a change; time in hundredths of a second.
    Gif,
}

impl FilmFormat {
    /// The format that the ending of a name tells, in any case and without the dot.
    pub fn of_extension(ending: &str) -> Option<Self> {
        match ending.to_ascii_lowercase().as_str() {
            "png" | "apng" => Some(Self::Apng),
            "gif" => Some(Self::Gif),
            _ => None,
        }
    }
}

/// What a film is announced to be.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmPlan {
    /// Columns and rows.
    pub size: (usize, usize),
    /// Frames.
    pub frames: u32,
    /// Frames per second, 1 to 50: no program shows more of a GIF.
    pub frames_per_second: u16,
    /// What it is written as.
    pub format: FilmFormat,
    /// What an animated PNG says besides; a GIF says nothing.
    pub meta: PictureMeta,
}

/// A film on its way, two frames in memory.
pub struct Film<W: Write> {
    file: File<W>,
    plan: FilmPlan,
    /// How many frames were written, and the last of them.
    done: u32,
    before: Option<Raster<[u8; 3]>>,
}

enum File<W: Write> {
    Apng(png::Writer<W>),
    Gif(gif::Encoder<W>),
}

/// How much of a GIF's colors its palette is made of: 1 for all, 30 for the fewest.
const SPARSE: i32 = 10;

const FASTEST: u16 = 50;

impl From<gif::EncodingError> for WriteError {
    fn from(error: gif::EncodingError) -> Self {
        match error {
            gif::EncodingError::Io(error) => Self::Write(error),
            other => Self::Encode(other.to_string()),
        }
    }
}

impl<W: Write> Film<W> {
    /// Begins a film.
    ///
    /// # Errors
    /// The writer fails; the format cannot hold the size, there are no frames, or too many a second.
    pub fn begin(writer: W, plan: FilmPlan) -> Result<Self, WriteError> {
        let rate = plan.frames_per_second;
        if rate == 0 || rate > FASTEST || plan.frames == 0 {
            return Err(WriteError::Parts {
                found: format!("{} frames at {rate} a second", plan.frames),
                wanted: format!("1 frame or more at 1 to {FASTEST} a second"),
            });
        }
        let file = match plan.format {
            FilmFormat::Apng => {
                let kind = (ColorType::Rgb, BitDepth::Eight);
                let mut encoder = encoder(writer, plan.size, kind, &plan.meta)?;
                encoder.set_animated(plan.frames, 0)?;
                encoder.set_frame_delay(1, rate)?;
                File::Apng(encoder.write_header()?)
            }
            FilmFormat::Gif => {
                let (columns, rows) = sides(plan.size, "a GIF", u32::from(u16::MAX))?;
                let mut encoder = gif::Encoder::new(writer, columns as u16, rows as u16, &[])?;
                encoder.set_repeat(gif::Repeat::Infinite)?;
                File::Gif(encoder)
            }
        };
        Ok(Self { file, plan, done: 0, before: None })
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// The writer fails, the frame has another size, or it is one more than were announced.
    pub fn frame(&mut self, frame: &Raster<[u8; 3]>) -> Result<(), WriteError> {
        let size = (frame.width(), frame.height());
        if size != self.plan.size {
            let said = |(width, height)| format!("{width} × {height} pixels");
            return Err(WriteError::Parts { found: said(size), wanted: said(self.plan.size) });
        }
        if self.done == self.plan.frames {
            return Err(self.miscounted(self.done + 1));
        }
        let [xs, ys] = match &self.before {
            Some(before) => changed(before, frame),
            None => [0..size.0, 0..size.1],
        };
        let mut pixels = Vec::with_capacity(3 * xs.len() * ys.len());
        for y in ys.clone() {
            pixels.extend_from_slice(frame.row(y)[xs.clone()].as_flattened());
        }
        match &mut self.file {
            File::Apng(writer) => {
                // The new size has to fit at the old place and the new place to the old size.
                writer.set_frame_position(0, 0)?;
                writer.set_frame_dimension(xs.len() as u32, ys.len() as u32)?;
                writer.set_frame_position(xs.start as u32, ys.start as u32)?;
                writer.write_image_data(&pixels)?;
            }
            File::Gif(encoder) => {
                let (width, height) = (xs.len() as u16, ys.len() as u16);
                let mut part = gif::Frame::from_rgb_speed(width, height, &pixels, SPARSE);
                (part.left, part.top) = (xs.start as u16, ys.start as u16);
                part.delay = hundredths(self.done, self.plan.frames_per_second);
                part.dispose = gif::DisposalMethod::Keep;
                encoder.write_frame(&part)?;
            }
        }
        self.before = Some(frame.clone());
        self.done += 1;
        Ok(())
    }

    /// Ends the film.
    ///
    /// # Errors
    /// The writer fails, or there were fewer frames than announced.
    pub fn end(self) -> Result<(), WriteError> {
        if self.done != self.plan.frames {
            return Err(self.miscounted(self.done));
        }
        match self.file {
            File::Apng(writer) => Ok(writer.finish()?),
            File::Gif(encoder) => encoder.into_inner()?.flush().map_err(WriteError::Write),
        }
    }

    fn miscounted(&self, found: u32) -> WriteError {
        let said = |frames| format!("{frames} frames");
        WriteError::Parts { found: said(found), wanted: said(self.plan.frames) }
    }
}

/// Columns and rows in which two frames differ, one of each at least.
fn changed(before: &Raster<[u8; 3]>, frame: &Raster<[u8; 3]>) -> [Range<usize>; 2] {
    let mut found: Option<[Range<usize>; 2]> = None;
    for y in 0..frame.height() {
        let (old, new) = (before.row(y), frame.row(y));
        let differs = |x: &usize| old[*x] != new[*x];
        let Some(first) = (0..new.len()).find(differs) else { continue };
        let last = (first..new.len()).rev().find(differs).unwrap_or(first);
        let [xs, ys] = found.unwrap_or([first..last + 1, y..y + 1]);
        found = Some([xs.start.min(first)..xs.end.max(last + 1), ys.start..y + 1]);
    }
    found.unwrap_or([0..1, 0..1])
}

/// How long a frame is shown, so that frame `n` ends as near to its time as hundredths of a second can tell.
fn hundredths(frame: u32, frames_per_second: u16) -> u16 {
    let rate = u64::from(frames_per_second);
    let end = |frames: u64| (200 * frames + rate) / (2 * rate);
    (end(u64::from(frame) + 1) - end(u64::from(frame))) as u16
}

#[cfg(test)]
mod tests;
