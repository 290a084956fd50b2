//! A folder with scripts, and the binary run in it.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A small scene: one lit ball, a still.
pub const STILL: &str = "
image(#{ width: 16, height: 9 });
camera(#{ eye: [0, 0, 5], look_at: [0, 0, 0] });
light(#{ at: [3, 4, 5], emissivity: 40 });
let paint = material(#{ diffuse: [0.8, 0.4, 0.2] });
sphere(#{ center: [0, 0, 0], radius: 1, material: paint });
";

/// What makes an animation of five frames of [`STILL`].
pub const FIVE: &str = "
animation(#{ frames: 5, fps: 10 });
on_frame(|f| { paint.diffuse = [f.phase, 0.4, 0.2]; });
";

/// A folder of its own for a test, removed at the end.
pub struct Room(tempfile::TempDir);

/// How a run ended.
pub struct Ran {
    pub code: Option<i32>,
    pub out: Vec<u8>,
    pub err: String,
}

impl Room {
    /// A folder with these scripts.
    pub fn with(files: &[(&str, &str)]) -> Self {
        let room = Self(tempfile::tempdir().unwrap());
        for (name, text) in files {
            room.write(name, text);
        }
        room
    }

    /// A folder with `still.rhai`, and `five.rhai`, an animation of five frames.
    pub fn furnished() -> Self {
        Self::with(&[("still.rhai", STILL), ("five.rhai", &format!("{STILL}{FIVE}"))])
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), text).unwrap();
    }

    /// The names of all files and folders directly in `folder`, hidden ones too, sorted.
    pub fn names_in(&self, folder: &str) -> Vec<String> {
        let entries = std::fs::read_dir(self.path(folder)).unwrap();
        let mut names: Vec<_> =
            entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// The names beside the scripts.
    pub fn made(&self) -> Vec<String> {
        self.names_in(".").into_iter().filter(|n| !n.ends_with(".rhai")).collect()
    }

    pub fn command(&self, args: &[impl AsRef<OsStr>]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_reflet"));
        command.args(args).current_dir(self.0.path()).stdin(Stdio::null());
        command
    }

    /// Runs the binary in the folder.
    pub fn run(&self, args: &[&str]) -> Ran {
        self.command(args).output().unwrap().into()
    }

    /// Runs it; it must end well.
    pub fn good(&self, args: &[&str]) -> Ran {
        let ran = self.run(args);
        assert_eq!(ran.code, Some(0), "{args:?}: {}", ran.err);
        ran
    }

    /// Runs it; it must end with `code`, say all of `words` on stderr, and not have panicked.
    pub fn bad(&self, args: &[&str], code: i32, words: &[&str]) -> Ran {
        let ran = self.run(args);
        assert_eq!(ran.code, Some(code), "{args:?}: {}", ran.err);
        assert!(ran.err.starts_with("error: "), "{args:?}: {}", ran.err);
        assert!(!ran.err.contains("panicked"), "{args:?}: {}", ran.err);
        for word in words {
            assert!(ran.err.contains(word), "{args:?}: no {word:?} in: {}", ran.err);
        }
        ran
    }
}

impl From<Output> for Ran {
    fn from(output: Output) -> Self {
        let err = String::from_utf8_lossy(&output.stderr).into_owned();
        Self { code: output.status.code(), out: output.stdout, err }
    }
}

impl Ran {
    pub fn text(&self) -> &str {
        std::str::from_utf8(&self.out).unwrap()
    }
}

/// Width, height and pixels of a PNG file, which must be whole.
pub fn png(path: &Path) -> (u32, u32, Vec<u8>) {
    let file = std::fs::File::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let decoder = png::Decoder::new(std::io::BufReader::new(file));
    let mut reader = decoder.read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    pixels.truncate(info.buffer_size());
    (info.width, info.height, pixels)
}
