//! What the tests of the command share: running it, folders, states, and broken ones made by hand.
#![allow(dead_code, reason = "each test binary uses a part of it")]

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use girtin::grid::Raster;
use girtin::painting::state_file;
use girtin::wash::WashState;
use image::{DynamicImage, ImageFormat, RgbImage};
use tempfile::TempDir;

/// What a run of the command gave.
#[derive(Debug)]
pub struct Ran {
    pub code: i32,
    pub stdout: Vec<u8>,
    pub stderr: String,
}

impl Ran {
    /// The standard output as text.
    pub fn text(&self) -> String {
        String::from_utf8(self.stdout.clone()).unwrap()
    }

    /// The standard output as JSON.
    pub fn json(&self) -> serde_json::Value {
        serde_json::from_slice(&self.stdout).unwrap_or_else(|error| panic!("{error}: {self:?}"))
    }

    /// Asserts that it went well and said nothing.
    pub fn fine(self) -> Self {
        assert_eq!((self.code, self.stderr.as_str()), (0, ""), "{}", self.text());
        self
    }
}

/// A folder to run the command in.
pub struct Folder(TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> &Self {
        fs::write(self.path(name), bytes).unwrap();
        self
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn has(&self, name: &str) -> bool {
        self.path(name).exists()
    }

    /// Every file below, with its content.
    pub fn files(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let mut files = BTreeMap::new();
        let mut folders = vec![self.0.path().to_owned()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path);
                } else if let Ok(bytes) = fs::read(&path) {
                    files.insert(path, bytes);
                }
            }
        }
        files
    }

    /// The command, to be run here.
    pub fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_girtin"));
        command.args(line.split_whitespace()).current_dir(self.0.path()).stdin(Stdio::null());
        command
    }

    /// Runs the command here; words of the line are separated by spaces.
    pub fn run(&self, line: &str) -> Ran {
        let output = self.command(line).output().unwrap();
        Ran {
            code: output.status.code().unwrap_or(-1),
            stdout: output.stdout,
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Runs the command here with bytes on its standard input.
    pub fn run_with(&self, line: &str, stdin: &[u8]) -> Ran {
        let mut command = self.command(line);
        let command = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut pipe = child.stdin.take().unwrap();
        let bytes = stdin.to_vec();
        let feeder = std::thread::spawn(move || drop(pipe.write_all(&bytes)));
        let output = child.wait_with_output().unwrap();
        feeder.join().unwrap();
        Ran {
            code: output.status.code().unwrap_or(-1),
            stdout: output.stdout,
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Runs the command and asserts that it fails with this code, one line of cause, one of hint, and no change to
    /// any file. Returns cause and hint.
    pub fn fails(&self, line: &str, code: i32) -> (String, String) {
        let before = self.files();
        let ran = self.run(line);
        assert_eq!(ran.code, code, "`{line}` said {}", ran.stderr);
        assert!(ran.stdout.is_empty(), "`{line}` wrote {}", ran.text());
        let lines: Vec<&str> = ran.stderr.lines().collect();
        let [cause, hint] = lines[..] else { panic!("`{line}` said {}", ran.stderr) };
        let cause = cause.strip_prefix("girtin: error: ").unwrap_or_else(|| panic!("{cause}"));
        let hint = hint.strip_prefix("hint: ").unwrap_or_else(|| panic!("{hint}"));
        assert!(!cause.is_empty() && !hint.is_empty(), "{}", ran.stderr);
        assert!(self.files() == before, "`{line}` changed files");
        (cause.to_owned(), hint.to_owned())
    }
}

/// A photograph of a hill under a sky with a red disc in it.
pub fn photo(width: u32, height: u32) -> RgbImage {
    RgbImage::from_fn(width, height, |x, y| {
        let (u, v) = (f64::from(x) / f64::from(width), f64::from(y) / f64::from(height));
        let hill = 0.6 + 0.15 * (6.0 * u).sin();
        let disc = (u - 0.7).hypot(v - 0.3) < 0.15;
        let color = match (disc, v > hill) {
            (true, _) => [190.0, 60.0, 40.0],
            (_, true) => [70.0 + 60.0 * u, 90.0 - 20.0 * v, 50.0],
            _ => [150.0 + 90.0 * v, 180.0 + 60.0 * v, 235.0],
        };
        image::Rgb(color.map(|value| value as u8))
    })
}

/// A picture as a file's bytes.
pub fn picture_file(picture: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.into().write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// A puddle of pigments on bumpy paper.
pub fn puddle(width: usize, height: usize, pigments: usize) -> WashState {
    let paper = Raster::from_fn(width, height, |x, y| 0.5 + 0.3 * ((x * 7 + y * 13) % 11) as f32 / 11.0);
    let mut state = WashState::dry(&paper, pigments);
    for y in height / 4..height - height / 4 {
        let run = width / 4..width - width / 4;
        state.wet_mask.cells_mut(y)[run.clone()].fill(1);
        state.pressure.cells_mut(y)[run.clone()].fill(0.6);
        for (k, suspended) in state.suspended.iter_mut().enumerate() {
            suspended.cells_mut(y)[run.clone()].fill(0.4 / (k + 1) as f32);
        }
    }
    state
}

/// A state as a file's bytes.
pub fn bytes_of(state: &WashState) -> Vec<u8> {
    let mut bytes = Vec::new();
    state_file::write(state, &mut bytes).unwrap();
    bytes
}

/// A folder with a state of one pigment and the `wash.toml` that names it.
pub fn studio() -> Folder {
    let folder = Folder::new();
    folder.write("in.npz", bytes_of(&puddle(48, 40, 1)));
    folder.write("wash.toml", "pigments = [\"french-ultramarine\"]\n");
    folder
}

/// An array as NumPy writes it.
pub struct Array {
    pub name: &'static str,
    pub descr: &'static str,
    pub shape: Vec<usize>,
    pub bytes: Vec<u8>,
}

impl Array {
    pub fn f32(name: &'static str, shape: &[usize], values: impl Fn(usize) -> f32) -> Self {
        let count = shape.iter().product();
        let bytes = (0..count).flat_map(|i| values(i).to_le_bytes()).collect();
        Self { name, descr: "<f4", shape: shape.to_vec(), bytes }
    }

    pub fn u8(name: &'static str, shape: &[usize], values: impl Fn(usize) -> u8) -> Self {
        Self {
            name,
            descr: "|u1",
            shape: shape.to_vec(),
            bytes: (0..shape.iter().product()).map(values).collect(),
        }
    }
}

/// An archive as `np.savez` writes it: stored, nothing checked, so that it may be as wrong as a test likes.
pub fn npz(arrays: &[Array]) -> Vec<u8> {
    let (mut file, mut directory) = (Vec::new(), Vec::new());
    for array in arrays {
        let shape: String = array.shape.iter().map(|axis| format!("{axis}, ")).collect();
        let mut header =
            format!("{{'descr': '{}', 'fortran_order': False, 'shape': ({shape}), }}", array.descr);
        header += &" ".repeat((64 - (10 + header.len() + 1) % 64) % 64);
        header += "\n";
        let mut data = b"\x93NUMPY\x01\x00".to_vec();
        data.extend((header.len() as u16).to_le_bytes());
        data.extend(header.bytes());
        data.extend(&array.bytes);

        let name = format!("{}.npy", array.name);
        let mut common = vec![20, 0, 0, 0, 0, 0, 0, 0, 0x21, 0];
        common.extend(crc32(&data).to_le_bytes());
        common.extend((data.len() as u32).to_le_bytes());
        common.extend((data.len() as u32).to_le_bytes());
        common.extend((name.len() as u16).to_le_bytes());
        common.extend([0, 0]);
        directory.extend(b"PK\x01\x02\x14\x00");
        directory.extend(&common);
        directory.extend([0; 10]);
        directory.extend((file.len() as u32).to_le_bytes());
        directory.extend(name.bytes());
        file.extend(b"PK\x03\x04");
        file.extend(&common);
        file.extend(name.bytes());
        file.extend(&data);
    }
    let start = file.len() as u32;
    file.extend(&directory);
    file.extend(b"PK\x05\x06\0\0\0\0");
    file.extend((arrays.len() as u16).to_le_bytes());
    file.extend((arrays.len() as u16).to_le_bytes());
    file.extend((directory.len() as u32).to_le_bytes());
    file.extend(start.to_le_bytes());
    file.extend([0, 0]);
    file
}

fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, &byte| {
        (0..8)
            .fold(crc ^ u32::from(byte), |crc: u32, _| (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg()))
    })
}

/// Width and height of a PNG.
pub fn png_size(bytes: &[u8]) -> (u32, u32) {
    assert!(bytes.starts_with(b"\x89PNG\r\n\x1a\n"), "not a PNG");
    assert!(bytes.ends_with(b"IEND\xaeB`\x82"), "a PNG cut short");
    let side = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().unwrap());
    (side(16), side(20))
}

/// Whether bytes hold a text.
pub fn holds(bytes: &[u8], text: &str) -> bool {
    bytes.windows(text.len()).any(|window| window == text.as_bytes())
}

/// A folder in which nobody may write, if the system has one.
pub fn read_only_folder(folder: &Folder) -> Option<PathBuf> {
    let locked = folder.path("locked");
    fs::create_dir(&locked).unwrap();
    let mut rights = fs::metadata(&locked).unwrap().permissions();
    rights.set_readonly(true);
    fs::set_permissions(&locked, rights).unwrap();
    // A superuser writes wherever rights are all that is in the way.
    [locked.as_path(), Path::new("/sys"), Path::new("/proc")]
        .into_iter()
        .find(|place| place.is_dir() && fs::write(place.join("girtin-probe"), "").is_err())
        .map(Path::to_owned)
}

/// Says that a check was left out; where everything must be checked, that is a failure.
pub fn skip(why: &str) {
    assert!(std::env::var_os("GIRTIN_NO_SKIPS").is_none(), "not checked: {why}");
    eprintln!("skipped: {why}");
}
