//! Pictures to files, while the next frame is traced.

use crate::engine::nanoseconds;
use crate::event::{FrameReport, RenderError};
use crate::provenance::{FilmHasher, FilmSettings, Provenance};
use crate::resume::{self, Standing};
use rayon::ThreadPool;
use reflet_film::{
    FileId, FilmSink, FilmSpec, FilmWriter, Folders, KeptBands, PendingFolders, Picture, SafeFile,
    Sealed, StillOptions, Target, Transfer, encode_sealed, encode_still, manifest_path,
};
use std::collections::HashMap;
use std::io::Write;
use std::path::{Path, PathBuf};
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
    /// What its samples went through.
    pub transfer: Transfer,
}

/// What a film needs to know before its first frame.
#[derive(Clone, Copy, Debug)]
pub struct FilmInfo {
    /// Its size, its rate, and how it is encoded.
    pub settings: FilmSettings,
    /// Frames in all.
    pub frames: u32,
    /// What the samples of the first frame go through.
    pub transfer: Transfer,
}

impl FilmInfo {
    /// The film that `target` names.
    pub(crate) fn spec(self, target: &Target) -> FilmSpec {
        let FilmInfo { settings, frames, transfer } = self;
        FilmSpec {
            format: settings.format,
            width: settings.size[0],
            height: settings.size[1],
            fps: settings.fps,
            frames,
            transfer,
            compression: settings.compression,
            dither: settings.dither,
            spool: spool(target),
        }
    }
}

/// Where frames go, in order.
pub struct Output<'a> {
    target: Target,
    info: FilmInfo,
    pool: &'a ThreadPool,
    sink: Sink,
}

enum Sink {
    Stills { kept: KeptBands, folders: PendingFolders, place: Folders, written: Written },
    Film { writer: Box<FilmWriter<FilmSink>>, bytes: Arc<AtomicU64>, made_from: FilmHasher },
    Done,
}

impl<'a> Output<'a> {
    /// Opens what is written to over all frames. Files of single frames are opened one by one.
    pub fn open(
        target: Target,
        info: FilmInfo,
        pool: &'a ThreadPool,
    ) -> Result<Self, (PathBuf, std::io::Error)> {
        let sink = if target.format().is_film() {
            let fail = |e| (target.path_for(0), e);
            // A film that ffmpeg was to finish may have been left by a killed process.
            crate::resume::sweep(&target, &[0])?;
            let quality = info.settings.quality;
            let file = FilmSink::open(&target, quality, info.transfer).map_err(fail)?;
            let bytes = file.counter();
            let writer = FilmWriter::new(file, info.spec(&target)).map_err(fail)?;
            let writer = Box::new(writer);
            Sink::Film { writer, bytes, made_from: FilmHasher::default() }
        } else {
            Sink::Stills {
                kept: KeptBands::new(),
                folders: PendingFolders::new(),
                place: Folders::Make,
                written: Written::default(),
            }
        };
        Ok(Output { target, info, pool, sink })
    }

    /// What of the frames the format cannot do.
    pub fn warnings(&self) -> Vec<String> {
        match &self.sink {
            Sink::Film { writer, .. } => writer.spec().warnings(),
            _ => self.target.format().cannot_say(self.info.transfer).into_iter().collect(),
        }
    }

    /// Encodes and writes the next frame; the report gets what that took.
    pub fn write(&mut self, frame: &mut Finished) -> Result<(), RenderError> {
        let start = Instant::now();
        let index = frame.report.frame;
        let path = self.target.path_for(index);
        let result = match &mut self.sink {
            Sink::Stills { kept, folders, place, written } => {
                let provenance = frame.provenance.as_ref();
                let text = provenance.map(Provenance::texts).unwrap_or_default();
                let options = StillOptions {
                    compression: self.info.settings.compression,
                    transfer: frame.transfer,
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
                let result = sealed.and_then(|sealed| {
                    report.bytes = sealed.encoded.len() as u64;
                    report.bands_encoded = sealed.encoded.bands_encoded as u64;
                    report.bands_kept = sealed.encoded.bands_kept as u64;
                    still(&self.target, index, &sealed, (folders, *place))
                });
                *place = Folders::Expect;
                result.map(|file| written.add(index, &path, file))
            }
            Sink::Film { writer, bytes, made_from } => {
                if let Some(provenance) = &frame.provenance {
                    made_from.push(provenance);
                }
                let before = bytes.load(Ordering::Relaxed);
                let pushed = match frame.transfer == writer.spec().transfer {
                    true => self.pool.install(|| writer.push(&frame.picture)),
                    false => Err(std::io::Error::other(
                        "the scene's transfer changes at this frame, and a film has one",
                    )),
                };
                frame.report.bytes = bytes.load(Ordering::Relaxed) - before;
                pushed.map(|_| ())
            }
            Sink::Done => Ok(()),
        };
        frame.report.encode_ns = nanoseconds(start);
        frame.report.path = (!self.target.is_stdout()).then(|| path.clone());
        result.map_err(|error| RenderError::Output { frame: index, path, error })
    }

    /// Ends the film, or syncs the folders and makes sure that the files of `frames`, those that the
    /// job made or kept, are there.
    pub fn finish(&mut self, frames: &[u32]) -> Result<Ended, RenderError> {
        let last = frames.last().copied().unwrap_or(0);
        let path = self.target.path_for(last);
        let result = match std::mem::replace(&mut self.sink, Sink::Done) {
            Sink::Stills { mut folders, written, .. } => {
                written.all(&self.target, frames)?;
                folders.sync().map(|()| Ended::default())
            }
            Sink::Film { writer, made_from, .. } => {
                let wanted = made_from.film(self.info.settings);
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
fn spool(target: &Target) -> Option<PathBuf> {
    let path = target.path_for(0);
    // Next to a device there may be no place.
    let beside = !target.is_stdout() && (path.is_file() || !path.exists());
    let path = path.canonicalize().unwrap_or(path);
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    beside.then(|| folder.map_or_else(|| PathBuf::from("."), PathBuf::from))
}

/// The files that were written, and the folder that they went to.
#[derive(Default)]
struct Written {
    /// `None` for what was written through.
    files: HashMap<u32, Option<FileId>>,
    /// Held open, so that no other folder gets its number.
    folder: Option<(std::fs::File, FileId)>,
}

impl Written {
    fn add(&mut self, frame: u32, path: &Path, file: Option<FileId>) {
        if file.is_some() && self.folder.is_none() {
            let folder = folder_of(path);
            self.folder = std::fs::File::open(folder).ok().zip(FileId::of(folder).ok());
        }
        self.files.insert(frame, file);
    }

    /// Makes sure that the files of all `frames` are there. In a folder that has come in the place
    /// of the one that was written to, they must be those that were written.
    fn all(&self, target: &Target, frames: &[u32]) -> Result<(), RenderError> {
        let folder = folder_of(&target.path_for(0)).to_owned();
        let now = FileId::of(&folder).ok();
        let replaced = self.folder.as_ref().is_some_and(|(_, then)| Some(then) != now.as_ref());
        let missing = |frame: &&u32| {
            let there = FileId::of(&target.path_for(**frame));
            match (self.files.get(frame), there) {
                // Written through.
                (Some(None), _) => false,
                (_, Err(_)) => true,
                (Some(Some(then)), Ok(now)) => replaced && *then != now,
                (None, Ok(_)) => false,
            }
        };
        let missing: Vec<u32> = match target.is_stdout() {
            true => Vec::new(),
            false => frames.iter().filter(missing).copied().collect(),
        };
        let Some(frame) = missing.first().copied() else { return Ok(()) };
        let what = if replaced { "the folder was replaced" } else { "files were removed" };
        let error = std::io::Error::other(format!(
            "{} of {} frames are missing in {}: {}; {what} during the run; --resume makes them",
            missing.len(),
            frames.len(),
            folder.display(),
            resume::ranges(&missing),
        ));
        Err(RenderError::Output { frame, path: target.path_for(frame), error })
    }
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Writes a frame's file, and tells its identity unless it was written through.
fn still(
    target: &Target,
    frame: u32,
    sealed: &Sealed,
    (folders, place): (&mut PendingFolders, Folders),
) -> std::io::Result<Option<FileId>> {
    let mut file = target.open_in(frame, place)?;
    let device = file.temporary().is_none();
    sealed.encoded.write_to(&mut file)?;
    let written = file.commit_in(folders)?;
    if device {
        return Ok(None);
    }
    // A kill in between leaves a manifest that does not fit: the frame is then made again.
    if let Some(manifest) = &sealed.manifest {
        let path = manifest_path(&target.path_for(frame));
        let mut file = SafeFile::create_in(&path, Folders::Expect)?;
        file.write_all(manifest.as_bytes())?;
        file.commit_in(folders)?;
    }
    Ok(written)
}
