//! Where a film's bytes go.

use super::{Patch, VideoQuality, closing};
use crate::ffmpeg::Ffmpeg;
use crate::format::Format;
use crate::safe::{Folders, SafeFile};
use crate::seal::manifest_path;
use crate::target::Target;
use crate::transfer::Transfer;
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// A file, or ffmpeg, which writes one. Nothing of it stays unless it is committed.
#[derive(Debug)]
pub struct FilmSink {
    to: To,
    bytes: Arc<AtomicU64>,
    /// Has seen all that was written to a file of our own.
    hasher: Box<blake3::Hasher>,
    /// Where a manifest may stand: beside a file. What is written through says nothing of itself.
    manifest: Option<PathBuf>,
}

#[derive(Debug)]
enum To {
    File(BufWriter<SafeFile>),
    Ffmpeg(BufWriter<Ffmpeg>),
}

impl FilmSink {
    /// Opens the film that `target` names. Of `quality` and `transfer`, only ffmpeg needs to know.
    ///
    /// # Errors
    /// It cannot be written; its format needs a file or ffmpeg, and there is none.
    pub fn open(target: &Target, quality: VideoQuality, transfer: Transfer) -> io::Result<Self> {
        let format = target.format();
        let path = target.path_for(0);
        let mut manifest = (!target.is_stdout()).then(|| manifest_path(&path));
        let to = if matches!(format, Format::Mp4 | Format::Mkv) && !target.is_stdout() {
            To::Ffmpeg(BufWriter::new(Ffmpeg::start(&path, format, quality, transfer)?))
        } else {
            let file = target.open(0)?;
            let through = file.temporary().is_none();
            if through {
                manifest = None;
            }
            if through && matches!(format, Format::Webp | Format::Mp4 | Format::Mkv) {
                return Err(io::Error::new(
                    ErrorKind::InvalidInput,
                    format!(
                        "cannot write {format} to {}: its head is written last, so it needs a \
                             file",
                        path.display()
                    ),
                ));
            }
            To::File(BufWriter::new(file))
        };
        Ok(Self { to, bytes: Arc::default(), hasher: Box::default(), manifest })
    }

    /// How many bytes were written so far, now and later; 0 where ffmpeg writes them.
    pub fn counter(&self) -> Arc<AtomicU64> {
        self.bytes.clone()
    }

    /// Writes what the film ends with and what its head lacks (`patch` is told how long the end is),
    /// gives the file its name, and tells its length in bytes.
    pub(super) fn commit(
        mut self,
        format: Format,
        texts: &[(&str, &str)],
        patch: impl FnOnce(usize) -> io::Result<Option<Patch>>,
    ) -> io::Result<u64> {
        let manifest = self.manifest.take();
        let texts = if manifest.is_some() { texts } else { &[] };
        let length = match self.to {
            To::Ffmpeg(pipe) => {
                let ffmpeg = pipe.into_inner().map_err(|error| error.into_error())?;
                return ffmpeg.commit(format, texts);
            }
            To::File(mut file) => {
                let hasher = std::mem::take(&mut *self.hasher);
                let beside = closing::needs_manifest(format);
                let lines = match texts {
                    [] => None,
                    texts => Some(closing::lines(format, texts, hasher)),
                };
                let end = match &lines {
                    Some(lines) if !beside => closing::sealed(format, lines)?,
                    _ => closing::bare(format),
                };
                file.write_all(&end)?;
                let mut file = file.into_inner().map_err(|error| error.into_error())?;
                if let Some(patch) = patch(end.len())? {
                    file.overwrite(patch.offset, &patch.bytes)?;
                }
                file.commit()?;
                if let (Some(path), true) = (manifest, beside) {
                    write_manifest(&path, lines.as_deref())?;
                }
                self.bytes.load(Ordering::Relaxed) + end.len() as u64
            }
        };
        self.bytes.store(length, Ordering::Relaxed);
        Ok(length)
    }
}

/// Writes the lines beside a film, or removes those of the film that it took the place of.
fn write_manifest(path: &Path, lines: Option<&str>) -> io::Result<()> {
    let Some(lines) = lines else {
        return match std::fs::remove_file(path) {
            Err(error) if error.kind() != ErrorKind::NotFound => Err(error),
            _ => Ok(()),
        };
    };
    let mut file = SafeFile::create_in(path, Folders::Expect)?;
    file.write_all(lines.as_bytes())?;
    file.commit()
}

impl Write for FilmSink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.to {
            To::File(file) => {
                let n = file.write(bytes)?;
                if self.manifest.is_some() {
                    self.hasher.update(&bytes[..n]);
                }
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
