//! Films that ffmpeg encodes: it reads YUV4MPEG2 from a pipe and writes the file that then gets its
//! name, with options under which the same frames give the same bytes.

use crate::film::{VideoQuality, closing};
use crate::format::Format;
use crate::safe::SafeFile;
use crate::transfer::Transfer;
use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::thread::JoinHandle;

/// An ffmpeg at work on a file. Dropping it ends it, and no file stays.
#[derive(Debug)]
pub struct Ffmpeg {
    /// As the caller wrote it, for messages.
    path: PathBuf,
    child: Child,
    pipe: Option<ChildStdin>,
    told: Option<JoinHandle<String>>,
    /// Dropped last: its temporary file may be removed when nobody writes to it.
    file: Option<SafeFile>,
}

/// H.264 with a number of threads that does not depend on the machine (its bytes do on theirs), in
/// the colours of HD video, padded to even sizes.
const OPTIONS: &str = "-c:v libx264 -preset medium -threads 4 -pix_fmt yuv420p \
    -color_range tv -colorspace bt709 -color_primaries bt709 \
    -map_metadata -1 -fflags +bitexact -flags:v +bitexact";
const FILTER: &str = "scale=in_range=full:in_color_matrix=bt601:out_range=tv:out_color_matrix=bt709\
    :flags=bitexact+accurate_rnd+full_chroma_int,pad=ceil(iw/2)*2:ceil(ih/2)*2";

impl Ffmpeg {
    /// Starts ffmpeg for a film at `path`.
    ///
    /// # Errors
    /// There is no ffmpeg, or the place cannot be written to.
    pub fn start(
        path: &Path,
        format: Format,
        quality: VideoQuality,
        transfer: Transfer,
    ) -> io::Result<Self> {
        let file = SafeFile::create(path)?;
        let Some(temporary) = file.temporary() else {
            return Err(io::Error::new(
                ErrorKind::InvalidInput,
                format!("cannot write {}: a film of this kind needs a file", path.display()),
            ));
        };
        let container = if format == Format::Mkv { "matroska" } else { "mp4" };
        let mut command = Command::new("ffmpeg");
        command.args([
            "-v",
            "error",
            "-xerror",
            "-y",
            "-f",
            "yuv4mpegpipe",
            "-i",
            "-",
            "-vf",
            FILTER,
        ]);
        command.args(OPTIONS.split_whitespace());
        let curve = match transfer {
            Transfer::Srgb => "iec61966-2-1",
            Transfer::Linear => "linear",
        };
        command.args(["-crf", &quality.crf().to_string(), "-color_trc", curve]);
        if format == Format::Mp4 {
            command.args(["-movflags", "+faststart"]);
        }
        // As a URL, so that no name is taken for an option or a protocol.
        let mut url = std::ffi::OsString::from("file:");
        url.push(temporary);
        command.args(["-f", container]).arg(url);
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = command.spawn().map_err(|error| {
            let message = match error.kind() {
                ErrorKind::NotFound => format!(
                    "cannot write {}: {format} is encoded by ffmpeg, which is not there; install \
                     it, or let the output end in .webp, .apng, .gif or .y4m",
                    path.display()
                ),
                _ => format!("cannot start ffmpeg: {error}"),
            };
            io::Error::new(ErrorKind::Unsupported, message)
        })?;
        let pipe = child.stdin.take();
        let told = child.stderr.take().map(|mut stderr| {
            std::thread::spawn(move || {
                let mut text = String::new();
                let _ = stderr.read_to_string(&mut text);
                text
            })
        });
        Ok(Self { path: path.to_owned(), child, pipe, told, file: Some(file) })
    }

    /// Waits until ffmpeg is done, adds `texts` that say what the film was made from, gives the file
    /// its name, and tells its length in bytes.
    ///
    /// # Errors
    /// What ffmpeg says; what the system says.
    pub fn commit(mut self, format: Format, texts: &[(&str, &str)]) -> io::Result<u64> {
        drop(self.pipe.take());
        let status = self.child.wait()?;
        // On a full disk it may say so and yet end as if all were well.
        let told = self.told();
        if !status.success() || !told.trim().is_empty() {
            return Err(self.failure(&told));
        }
        let Some(mut file) = self.file.take() else { return Ok(0) };
        if let (Some(path), false) = (file.temporary(), texts.is_empty()) {
            let mut written = File::open(path)?;
            closing::append(&mut file, &mut written, format, texts)?;
        }
        let length = file.temporary().map(std::fs::metadata).transpose()?;
        file.commit()?;
        Ok(length.map_or(0, |about| about.len()))
    }

    /// What ffmpeg has said, once it has ended; it is asked to speak of errors only.
    fn told(&mut self) -> String {
        let _ = self.child.wait();
        self.told.take().and_then(|told| told.join().ok()).unwrap_or_default()
    }

    /// Why ffmpeg has ended.
    fn failure(&self, told: &str) -> io::Error {
        let last = told.lines().rfind(|line| !line.trim().is_empty()).unwrap_or("it says nothing");
        let path = self.path.display();
        io::Error::other(format!("cannot write {path}: ffmpeg failed: {}", last.trim()))
    }
}

impl Drop for Ffmpeg {
    fn drop(&mut self) {
        drop(self.pipe.take());
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Write for Ffmpeg {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let Some(pipe) = &mut self.pipe else { return Ok(0) };
        match pipe.write(bytes) {
            // The reader of our pipe is ffmpeg, whose reason is worth more than ours.
            Err(error) if error.kind() == ErrorKind::BrokenPipe => {
                let told = self.told();
                Err(self.failure(&told))
            }
            written => written,
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.pipe.as_mut().map_or(Ok(()), ChildStdin::flush)
    }
}
