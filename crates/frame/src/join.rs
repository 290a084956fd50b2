//! Frames that are on disk already, to a film. One frame at a time is in memory.

use crate::guard::Inputs;
use crate::memory;
use crate::output::FilmInfo;
use crate::provenance::{FilmHasher, FilmSettings, Provenance};
use reflet_film::{
    Compression, Dither, FilmSink, FilmWriter, Fps, Picture, Sample, SampleKind, Target, Transfer,
    TransferTable, Unsealed, VideoQuality, decode_still, read_sealed, still_head,
};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// Why frames could not be joined.
#[derive(Debug)]
pub enum JoinError {
    /// A frame is missing, bad, or of another size: which, and what to do.
    Input(String),
    /// The film is one of the frames, or it would take the place of another program's file.
    Refused(crate::guard::Refusal),
    /// The film could not be written.
    Output(io::Error),
    /// The job was told to stop.
    Cancelled,
}

impl std::fmt::Display for JoinError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            JoinError::Input(message) => f.write_str(message),
            JoinError::Refused(refusal) => write!(f, "{refusal}"),
            JoinError::Output(error) => write!(f, "{error}"),
            JoinError::Cancelled => f.write_str("stopped"),
        }
    }
}

impl std::error::Error for JoinError {}

/// How frames are joined.
#[derive(Clone, Copy, Debug)]
pub struct JoinOptions {
    /// Frames a second.
    pub fps: Fps,
    /// How a GIF stands for colours that its palette lacks.
    pub dither: Dither,
    /// How well ffmpeg encodes the film.
    pub quality: VideoQuality,
}

/// What is told while frames are joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JoinEvent<'a> {
    /// So many frames are in.
    Joined(usize),
    /// Something that the user may want to mend.
    Warning(&'a str),
}

/// Joins the frames at `paths`, in their order, to the film that `target` names. Gives the film's
/// length in bytes.
///
/// # Errors
/// A frame that is not there, damaged, no still of the formats that a render writes, or of another
/// size or transfer; the film; `cancel` was set.
pub fn join(
    paths: &[PathBuf],
    target: &Target,
    options: JoinOptions,
    cancel: &AtomicBool,
    tell: &mut dyn FnMut(JoinEvent<'_>),
) -> Result<u64, JoinError> {
    let Some(path) = paths.first() else {
        return Err(JoinError::Input("there are no frames to join".to_owned()));
    };
    Inputs::of(paths).spare_by(target, &[0]).map_err(JoinError::Refused)?;
    let first = frame(path, None)?;
    let (size, transfer) = (first.size(), first.transfer);
    let settings = FilmSettings {
        size,
        fps: options.fps,
        format: target.format(),
        compression: Compression::default(),
        dither: options.dither,
        quality: options.quality,
    };
    let frames = u32::try_from(paths.len())
        .map_err(|_| JoinError::Input("there are too many frames".to_owned()))?;
    let spec = FilmInfo { settings, frames, transfer }.spec(target);
    spec.warnings().iter().for_each(|warning| tell(JoinEvent::Warning(warning)));
    let output = JoinError::Output;
    crate::resume::sweep(target, &[0]).map_err(|(_, error)| output(error))?;
    let sink = FilmSink::open(target, options.quality, transfer).map_err(output)?;
    let mut film = FilmWriter::new(sink, spec).map_err(output)?;
    let mut hasher = FilmHasher::default();
    let mut told_by_all = true;
    let mut next = Some(first);
    for (index, path) in paths.iter().enumerate() {
        if cancel.load(Ordering::Relaxed) {
            return Err(JoinError::Cancelled);
        }
        let still = match next.take() {
            Some(still) => still,
            None => frame(path, Some((size, transfer)))?,
        };
        match &still.made_from {
            Some(made_from) => hasher.push(made_from),
            None => told_by_all = false,
        }
        film.push(&still.picture).map_err(output)?;
        tell(JoinEvent::Joined(index + 1));
    }
    // Frames that do not all say what they were made from make a film that does not, either.
    let wanted = (told_by_all && !target.is_stdout()).then(|| hasher.film(settings));
    film.commit(&wanted.as_ref().map(Provenance::texts).unwrap_or_default()).map_err(output)
}

fn wrong(path: &Path, what: impl std::fmt::Display) -> JoinError {
    JoinError::Input(format!("{}: {what}", path.display()))
}

/// A frame on disk.
struct Still {
    /// Samples of 8 bits.
    picture: Picture,
    /// What they went through.
    transfer: Transfer,
    /// What its file says that it was made from.
    made_from: Option<Provenance>,
}

impl Still {
    fn size(&self) -> [u32; 2] {
        [self.picture.layout().width(), self.picture.layout().height()]
    }
}

/// Reads a frame, which is to be `like` the first one in size and transfer.
fn frame(path: &Path, like: Option<([u32; 2], Transfer)>) -> Result<Still, JoinError> {
    if !path.is_file() {
        return Err(wrong(path, "there is no such frame"));
    }
    // A frame of ours knows whether it is whole.
    let texts = match read_sealed(path) {
        Err(error @ Unsealed::Damaged(_)) => {
            return Err(wrong(path, format!("{error}; render it again with --resume")));
        }
        texts => texts.unwrap_or_default(),
    };
    let bytes = std::fs::read(path).map_err(|error| wrong(path, error))?;
    let head = still_head(&bytes).map_err(|error| wrong(path, error))?;
    let transfer = Provenance::transfer_of(&texts).or(head.transfer).unwrap_or_default();
    let [width, height] = head.size;
    if let Some(([w, h], first)) = like {
        if head.size != [w, h] {
            let what = format!("it has {width}x{height} pixels, and the first frame {w}x{h}");
            return Err(wrong(path, what));
        }
        if transfer != first {
            let name = |transfer| if transfer == Transfer::Linear { "linear" } else { "sRGB" };
            let (transfer, first) = (name(transfer), name(first));
            return Err(wrong(path, format!("it is {transfer}, and the first frame {first}")));
        }
    }
    // As floats and as 8 bits, once more as rows, and in the film.
    let needed = u64::from(width) * u64::from(height) * 24;
    if let Some(free) = memory::available().filter(|free| needed > *free) {
        let (needed, free) = (needed >> 20, free >> 20);
        return Err(wrong(
            path,
            format!(
                "it has {width}x{height} pixels, which take {needed} MiB, and {free} MiB are free"
            ),
        ));
    }
    let picture = decode_still(&bytes).map_err(|error| wrong(path, error))?;
    let picture = match picture.kind() {
        SampleKind::F32 => encoded(&picture, transfer).map_err(|error| wrong(path, error))?,
        _ => picture,
    };
    Ok(Still { picture, transfer, made_from: Provenance::of_frame(&texts) })
}

/// Intensities to 8 bits.
fn encoded(floats: &Picture, transfer: Transfer) -> Result<Picture, reflet_film::OutOfMemory> {
    let mut picture = Picture::try_new(floats.layout(), SampleKind::U8)?;
    let table = TransferTable::new(transfer, SampleKind::U8);
    encode_picture(floats, &table, &mut picture);
    Ok(picture)
}

/// Intensities to samples, tile by tile.
pub(crate) fn encode_picture(floats: &Picture, table: &TransferTable, picture: &mut Picture) {
    let chunk = floats.layout().chunk_len();
    let Some(samples) = <f32 as Sample>::of(floats.samples()) else { return };
    let mut colours = Vec::with_capacity(chunk / 3);
    for mut tile in picture.tiles_mut() {
        colours.clear();
        let triples = samples[tile.index * chunk..][..chunk].as_chunks::<3>().0;
        colours.extend(triples.iter().map(|[r, g, b]| [*r, *g, *b, 0.0]));
        table.encode_tile(&colours, &mut tile.samples);
    }
}
