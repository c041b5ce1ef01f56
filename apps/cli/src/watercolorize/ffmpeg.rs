//! Films by an installed ffmpeg.

use std::io::{self, Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use girtin::grid::Raster;

/// Whether it is installed.
pub fn is_there() -> bool {
    let mut command = Command::new("ffmpeg");
    let command = command.arg("-version").stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

/// A film on its way.
#[derive(Debug)]
pub struct Mp4 {
    child: Child,
}

impl Mp4 {
    /// Begins a film of frames of this size, into a file that it may replace.
    ///
    /// # Errors
    /// The program cannot be started.
    pub fn begin(path: &Path, (width, height): (usize, usize), rate: u16) -> io::Result<Self> {
        let mut command = Command::new("ffmpeg");
        command.args(["-hide_banner", "-loglevel", "error", "-f", "rawvideo", "-pixel_format", "rgb24"]);
        command.arg("-video_size").arg(format!("{width}x{height}")).arg("-framerate").arg(rate.to_string());
        // Most players want halved color and so even sides.
        command.args(["-i", "-", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white", "-pix_fmt", "yuv420p"]);
        command.args(["-map_metadata", "-1", "-movflags", "+faststart", "-f", "mp4", "-y"]).arg(path);
        let command = command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        Ok(Self { child: command.spawn()? })
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// The program has ended.
    pub fn frame(&mut self, frame: &Raster<[u8; 3]>) -> io::Result<()> {
        let pipe = self.child.stdin.as_mut().ok_or(io::ErrorKind::BrokenPipe)?;
        pipe.write_all(frame.as_slice().as_flattened())
    }

    /// Ends the film.
    ///
    /// # Errors
    /// The program complains; what it says is the error.
    pub fn end(mut self) -> io::Result<()> {
        drop(self.child.stdin.take());
        let mut said = String::new();
        if let Some(stderr) = &mut self.child.stderr {
            // A page is plenty.
            let _ = stderr.take(4096).read_to_string(&mut said);
        }
        if self.child.wait()?.success() {
            return Ok(());
        }
        let last = said.lines().last().unwrap_or("it ended early").to_owned();
        Err(io::Error::other(format!("ffmpeg says: {last}")))
    }
}

impl Drop for Mp4 {
    fn drop(&mut self) {
        // It has ended already unless something else went wrong.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
