//! Where a film's bytes go.

use super::Patch;
use crate::ffmpeg::Ffmpeg;
use crate::format::Format;
use crate::safe::SafeFile;
use crate::target::Target;
use std::io::{self, BufWriter, ErrorKind, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// A file, or ffmpeg, which writes one. Nothing of it stays unless it is committed.
#[derive(Debug)]
pub struct FilmSink {
    to: To,
    bytes: Arc<AtomicU64>,
}

#[derive(Debug)]
enum To {
    File(BufWriter<SafeFile>),
    Ffmpeg(BufWriter<Ffmpeg>),
}

impl FilmSink {
    /// Opens the film that `target` names.
    ///
    /// # Errors
    /// It cannot be written; its format needs a file or ffmpeg, and there is none.
    pub fn open(target: &Target) -> io::Result<Self> {
        let format = target.format();
        let to = if matches!(format, Format::Mp4 | Format::Mkv) && !target.is_stdout() {
            To::Ffmpeg(BufWriter::new(Ffmpeg::start(&target.path_for(0), format)?))
        } else {
            let file = target.open(0)?;
            let through = file.temporary().is_none();
            if through && matches!(format, Format::Webp | Format::Mp4 | Format::Mkv) {
                return Err(io::Error::new(
                    ErrorKind::InvalidInput,
                    format!(
                        "cannot write {format} to {}: its head is written last, so it needs a \
                             file",
                        target.path_for(0).display()
                    ),
                ));
            }
            To::File(BufWriter::new(file))
        };
        Ok(Self { to, bytes: Arc::default() })
    }

    /// How many bytes were written so far, now and later; 0 where ffmpeg writes them.
    pub fn counter(&self) -> Arc<AtomicU64> {
        self.bytes.clone()
    }

    /// Writes what the head lacks, gives the file its name, and tells its length in bytes.
    ///
    /// # Errors
    /// What the system says, or ffmpeg.
    pub fn commit(self, patch: Option<Patch>) -> io::Result<u64> {
        match self.to {
            To::File(file) => {
                let mut file = file.into_inner().map_err(|error| error.into_error())?;
                if let Some(patch) = patch {
                    file.overwrite(patch.offset, &patch.bytes)?;
                }
                file.commit()?;
                Ok(self.bytes.load(Ordering::Relaxed))
            }
            To::Ffmpeg(pipe) => pipe.into_inner().map_err(|error| error.into_error())?.commit(),
        }
    }
}

impl Write for FilmSink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.to {
            To::File(file) => {
                let n = file.write(bytes)?;
                self.bytes.fetch_add(n as u64, Ordering::Relaxed);
                Ok(n)
            }
            To::Ffmpeg(pipe) => pipe.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.to {
            To::File(file) => file.flush(),
            To::Ffmpeg(pipe) => pipe.flush(),
        }
    }
}
