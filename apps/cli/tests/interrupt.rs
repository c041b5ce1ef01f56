//! Ctrl-C in the middle: a clean end, and no partial file.
#![cfg(unix)]

mod common;

use std::fs;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use common::{Folder, bytes_of, png_size, puddle};

/// A wash that would run for long.
fn begin() -> (Folder, Child) {
    let folder = Folder::new();
    folder.write("in.npz", bytes_of(&puddle(512, 512, 1)));
    fs::create_dir(folder.path("frames")).unwrap();
    let line = "wash --state in.npz --pigments viridian --steps 100000 --save out.npz --image frames/####.png \
                --every 2";
    let mut child = folder.command(line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let start = Instant::now();
    while !folder.has("frames/0004.png") {
        if start.elapsed() > Duration::from_secs(120) {
            child.kill().unwrap();
            panic!("no frame yet");
        }
        sleep(Duration::from_millis(5));
    }
    (folder, child)
}

fn signal(child: &Child, name: &str) {
    let status = Command::new("kill").args([name, &child.id().to_string()]).status().unwrap();
    assert!(status.success());
}

fn ends(name: &str, code: i32) {
    let (folder, child) = begin();
    signal(&child, name);
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(code), "{said}");
    assert!(said.starts_with("girtin: error: interrupted\nhint: "), "{said}");
    let files = folder.files();
    assert!(!folder.has("out.npz"));
    for (path, bytes) in files {
        let name = path.file_name().unwrap().to_str().unwrap();
        assert!(!name.starts_with('.'), "{name} was left");
        // Finished frames stay, and are whole.
        if name != "in.npz" {
            assert_eq!(png_size(&bytes), (512, 512), "{name}");
        }
    }
}

#[test]
fn ctrl_c_ends_cleanly() {
    ends("-INT", 130);
}

#[test]
fn a_polite_kill_ends_cleanly() {
    ends("-TERM", 143);
}

#[test]
fn a_folder_that_was_made_for_nothing_goes_again() {
    let interrupted = |there: bool| {
        let folder = Folder::new();
        if there {
            fs::create_dir(folder.path("out")).unwrap();
        }
        let line = "effects out --size 640 --progress json";
        let mut child = folder.command(line).stderr(Stdio::piped()).spawn().unwrap();
        // The first line is said when the folder is there and nothing is painted yet.
        let mut said = std::io::BufReader::new(child.stderr.take().unwrap());
        std::io::BufRead::read_line(&mut said, &mut String::new()).unwrap();
        assert!(folder.has("out"));
        signal(&child, "-INT");
        std::io::Read::read_to_end(&mut said, &mut Vec::new()).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(130));
        folder.has("out")
    };
    assert!(!interrupted(false));
    // Somebody else's folder stays.
    assert!(interrupted(true));
}

#[test]
fn a_second_ctrl_c_ends_at_once() {
    use std::os::unix::process::ExitStatusExt;
    let folder = Folder::new();
    // A minute of work between two looks at the first one.
    let line = "paper japanese out.png --size-mm 9000x9000 --cells-per-mm 0.2 --threads 1";
    let mut child = folder.command(line).spawn().unwrap();
    for _ in 0..2 {
        sleep(Duration::from_millis(500));
        signal(&child, "-INT");
    }
    let start = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if start.elapsed() > Duration::from_secs(10) {
            child.kill().unwrap();
            panic!("it goes on");
        }
        sleep(Duration::from_millis(5));
    };
    assert_eq!(status.signal(), Some(2));
    assert!(folder.files().is_empty());
}
