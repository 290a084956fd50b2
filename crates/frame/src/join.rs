//! Frames that are on disk already, to a film. One frame at a time is in memory.

use crate::output::spool;
use crate::provenance::{FilmHasher, FilmSettings, Provenance};
use reflet_film::{
    Compression, FilmSink, FilmSpec, FilmWriter, Fps, Picture, Sample, SampleKind, Target,
    Transfer, TransferTable, Unsealed, decode_still, texts,
};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// Why frames could not be joined.
#[derive(Debug)]
pub enum JoinError {
    /// A frame is missing, bad, or of another size: which, and what to do.
    Input(String),
    /// The film could not be written.
    Output(io::Error),
    /// The job was told to stop.
    Cancelled,
}

impl std::fmt::Display for JoinError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            JoinError::Input(message) => f.write_str(message),
            JoinError::Output(error) => write!(f, "{error}"),
            JoinError::Cancelled => f.write_str("stopped"),
        }
    }
}

impl std::error::Error for JoinError {}

/// Joins the frames at `paths`, in their order, to the film that `target` names. `joined` is told
/// how many are in. Gives the film's length in bytes.
///
/// # Errors
/// A frame that is not there, damaged, no PNG, EXR or PPM, or of another size; the film; `cancel`
/// was set.
pub fn join(
    paths: &[PathBuf],
    target: &Target,
    fps: Fps,
    cancel: &AtomicBool,
    joined: &mut dyn FnMut(usize),
) -> Result<u64, JoinError> {
    let Some(path) = paths.first() else {
        return Err(JoinError::Input("there are no frames to join".to_owned()));
    };
    let (first, mut made_from) = frame(path)?;
    let mut hasher = FilmHasher::default();
    let size = |picture: &Picture| (picture.layout().width(), picture.layout().height());
    let (width, height) = size(&first);
    let spec = FilmSpec {
        format: target.format(),
        width,
        height,
        fps,
        frames: u32::try_from(paths.len())
            .map_err(|_| JoinError::Input("there are too many frames".to_owned()))?,
        compression: Compression::default(),
        spool: spool(target),
    };
    let output = JoinError::Output;
    crate::resume::sweep(target, &[0]).map_err(|(_, error)| output(error))?;
    let sink = FilmSink::open(target).map_err(output)?;
    let mut film = FilmWriter::new(sink, spec).map_err(output)?;
    let mut next = Some(first);
    for (index, path) in paths.iter().enumerate() {
        if cancel.load(Ordering::Relaxed) {
            return Err(JoinError::Cancelled);
        }
        let picture = match next.take() {
            Some(picture) => picture,
            None => {
                let (picture, of_frame) = frame(path)?;
                made_from = made_from.and(of_frame);
                picture
            }
        };
        if let Some(frame) = &made_from {
            hasher.push(frame);
        }
        if size(&picture) != (width, height) {
            let (w, h) = size(&picture);
            return Err(wrong(
                path,
                format!("it has {w}x{h} pixels, and the first frame {width}x{height}"),
            ));
        }
        film.push(&picture).map_err(output)?;
        joined(index + 1);
    }
    let settings = FilmSettings {
        size: [width, height],
        fps,
        format: target.format(),
        compression: Compression::default(),
    };
    // Frames that do not all say what they were made from make a film that does not, either.
    let wanted = made_from.filter(|_| !target.is_stdout()).map(|_| hasher.film(settings));
    film.commit(&wanted.as_ref().map(Provenance::texts).unwrap_or_default()).map_err(output)
}

fn wrong(path: &Path, what: impl std::fmt::Display) -> JoinError {
    JoinError::Input(format!("{}: {what}", path.display()))
}

/// A frame's picture, and what its file says that it was made from.
fn frame(path: &Path) -> Result<(Picture, Option<Provenance>), JoinError> {
    if !path.is_file() {
        return Err(wrong(path, "there is no such frame"));
    }
    let bytes = std::fs::read(path).map_err(|error| wrong(path, error))?;
    // A frame of ours knows whether it is whole.
    let texts = match texts(&bytes) {
        Err(error @ Unsealed::Damaged(_)) => {
            return Err(wrong(path, format!("{error}; render it again with --resume")));
        }
        texts => texts.unwrap_or_default(),
    };
    let picture = decode_still(&bytes).map_err(|error| wrong(path, error))?;
    let picture = match picture.kind() {
        SampleKind::F32 => encoded(&picture).map_err(|error| wrong(path, error))?,
        _ => picture,
    };
    Ok((picture, Provenance::of_frame(&texts)))
}

/// Intensities to 8 bits.
fn encoded(floats: &Picture) -> Result<Picture, reflet_film::OutOfMemory> {
    let mut picture = Picture::try_new(floats.layout(), SampleKind::U8)?;
    let table = TransferTable::new(Transfer::Srgb, SampleKind::U8);
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
