//! Pictures to files, while the next frame is traced.

use crate::engine::nanoseconds;
use crate::event::{FrameReport, RenderError};
use crate::provenance::{FilmHasher, FilmSettings, Provenance};
use crate::resume::{self, Standing};
use rayon::ThreadPool;
use reflet_film::{
    Compression, FilmSink, FilmSpec, FilmWriter, Folders, Fps, KeptBands, PendingFolders, Picture,
    SafeFile, Sealed, StillOptions, Target, encode_sealed, encode_still, manifest_path,
};
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// A frame that was shaded and is to be written.
pub struct Finished {
    /// Its pixels.
    pub picture: Arc<Picture>,
    /// What it took so far.
    pub report: FrameReport,
    /// What its file says that it was made from.
    pub provenance: Option<Provenance>,
}

/// What a film needs to know before its first frame.
#[derive(Clone, Copy, Debug)]
pub struct FilmInfo {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Frames a second.
    pub fps: Fps,
    /// Frames in all.
    pub frames: u32,
}

/// Where frames go, in order.
pub struct Output<'a> {
    target: Target,
    compression: Compression,
    pool: &'a ThreadPool,
    sink: Sink,
}

enum Sink {
    Stills { kept: KeptBands, folders: PendingFolders, place: Folders },
    Film { writer: Box<FilmWriter<FilmSink>>, bytes: Arc<AtomicU64>, made_from: FilmHasher },
    Done,
}

impl<'a> Output<'a> {
    /// Opens what is written to over all frames. Files of single frames are opened one by one.
    pub fn open(
        target: Target,
        compression: Compression,
        info: FilmInfo,
        pool: &'a ThreadPool,
    ) -> Result<Self, (PathBuf, std::io::Error)> {
        let sink = if target.format().is_film() {
            let fail = |e| (target.path_for(0), e);
            // A film that ffmpeg was to finish may have been left by a killed process.
            crate::resume::sweep(&target, &[0])?;
            let file = FilmSink::open(&target).map_err(fail)?;
            let bytes = file.counter();
            let spec = FilmSpec {
                format: target.format(),
                width: info.size[0],
                height: info.size[1],
                fps: info.fps,
                frames: info.frames,
                compression,
                spool: spool(&target),
            };
            let writer = Box::new(FilmWriter::new(file, spec).map_err(fail)?);
            Sink::Film { writer, bytes, made_from: FilmHasher::default() }
        } else {
            Sink::Stills {
                kept: KeptBands::new(),
                folders: PendingFolders::new(),
                place: Folders::Make,
            }
        };
        Ok(Output { target, compression, pool, sink })
    }

    /// Encodes and writes the next frame; the report gets what that took.
    pub fn write(&mut self, frame: &mut Finished) -> Result<(), RenderError> {
        let start = Instant::now();
        let index = frame.report.frame;
        let path = self.target.path_for(index);
        let result = match &mut self.sink {
            Sink::Stills { kept, folders, place } => {
                let provenance = frame.provenance.as_ref();
                let text = provenance.map(Provenance::texts).unwrap_or_default();
                let options = StillOptions {
                    compression: self.compression,
                    text: &text,
                    ..StillOptions::default()
                };
                let format = self.target.format();
                let picture = &frame.picture;
                let encode = || match provenance {
                    Some(_) => encode_sealed(picture, format, &options, Some(kept)),
                    None => encode_still(picture, format, &options, Some(kept))
                        .map(|encoded| Sealed { encoded, manifest: None }),
                };
                let sealed = self.pool.install(encode);
                let report = &mut frame.report;
                report.stood = provenance
                    .is_some_and(|wanted| resume::standing(&path, wanted) == Standing::Stands);
                let written = sealed.and_then(|sealed| {
                    report.bytes = sealed.encoded.len() as u64;
                    report.bands_encoded = sealed.encoded.bands_encoded as u64;
                    report.bands_kept = sealed.encoded.bands_kept as u64;
                    still(&self.target, index, &sealed, (folders, *place))
                });
                *place = Folders::Expect;
                written
            }
            Sink::Film { writer, bytes, made_from } => {
                if let Some(provenance) = &frame.provenance {
                    made_from.push(provenance);
                }
                let before = bytes.load(Ordering::Relaxed);
                let pushed = self.pool.install(|| writer.push(&frame.picture));
                frame.report.bytes = bytes.load(Ordering::Relaxed) - before;
                pushed.map(|_| ())
            }
            Sink::Done => Ok(()),
        };
        frame.report.encode_ns = nanoseconds(start);
        frame.report.path = (!self.target.is_stdout()).then(|| path.clone());
        result.map_err(|error| RenderError::Output { frame: index, path, error })
    }

    /// Ends the film, or syncs the folders; `last` is the last frame, for a message.
    pub fn finish(&mut self, last: u32) -> Result<Ended, RenderError> {
        let path = self.target.path_for(last);
        let result = match std::mem::replace(&mut self.sink, Sink::Done) {
            Sink::Stills { mut folders, .. } => folders.sync().map(|()| Ended::default()),
            Sink::Film { writer, made_from, .. } => {
                let spec = writer.spec();
                let wanted = made_from.film(FilmSettings {
                    size: [spec.width, spec.height],
                    fps: spec.fps,
                    format: spec.format,
                    compression: self.compression,
                });
                let stdout = self.target.is_stdout();
                let stood = !stdout && resume::standing(&path, &wanted) == Standing::Stands;
                let texts = if stdout { Vec::new() } else { wanted.texts() };
                (*writer).commit(&texts).map(|length| Ended { film: Some(length), stood })
            }
            Sink::Done => Ok(Ended::default()),
        };
        result.map_err(|error| RenderError::Output { frame: last, path, error })
    }
}

/// How an output ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ended {
    /// The film's length in bytes, if it is one.
    pub film: Option<u64>,
    /// Whether the film that it took the place of was the same already.
    pub stood: bool,
}

/// The folder of a film, for what waits until all frames are known.
pub(crate) fn spool(target: &Target) -> Option<PathBuf> {
    let path = target.path_for(0);
    // Next to a device there may be no place.
    let beside = !target.is_stdout() && (path.is_file() || !path.exists());
    let path = path.canonicalize().unwrap_or(path);
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    beside.then(|| folder.map_or_else(|| PathBuf::from("."), PathBuf::from))
}

fn still(
    target: &Target,
    frame: u32,
    sealed: &Sealed,
    (folders, place): (&mut PendingFolders, Folders),
) -> std::io::Result<()> {
    let mut file = target.open_in(frame, place)?;
    let device = file.temporary().is_none();
    sealed.encoded.write_to(&mut file)?;
    file.commit_in(folders)?;
    if device {
        return Ok(());
    }
    // A kill in between leaves a manifest that does not fit: the frame is then made again.
    if let Some(manifest) = &sealed.manifest {
        let path = manifest_path(&target.path_for(frame));
        let mut file = SafeFile::create_in(&path, Folders::Expect)?;
        file.write_all(manifest.as_bytes())?;
        file.commit_in(folders)?;
    }
    Ok(())
}
