//! Parts of one huge picture to the whole, byte for byte as if made in one piece.

use crate::guard::{Inputs, Refusal};
use crate::join::encode_picture;
use crate::provenance::{FileSettings, Part, Provenance};
use reflet_film::{
    Compression, Layout, Picture, SafeFile, SampleKind, StillOptions, Target, TransferTable,
    decode_still, encode_sealed, manifest_path, texts,
};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Why parts could not be merged.
#[derive(Debug)]
pub enum MergeError {
    /// A part is missing, bad, or of another picture: what, and what to do.
    Input(String),
    /// The whole is one of the parts, or would take the place of another program's file.
    Refused(Refusal),
    /// The whole could not be written.
    Output(std::io::Error),
    /// The whole is too large for this machine.
    Memory(String),
}

impl std::fmt::Display for MergeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            MergeError::Input(message) | MergeError::Memory(message) => f.write_str(message),
            MergeError::Refused(refusal) => write!(f, "{refusal}"),
            MergeError::Output(error) => write!(f, "{error}"),
        }
    }
}

impl std::error::Error for MergeError {}

/// What was merged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Merged {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Parts.
    pub parts: usize,
    /// Bytes of the file.
    pub bytes: u64,
}

/// Merges the parts at `paths` into the file that `target` names.
///
/// # Errors
/// A part that is damaged, no part, or of another picture; a gap or an overlap; the output.
pub fn merge(
    paths: &[PathBuf],
    target: &Target,
    compression: Compression,
) -> Result<Merged, MergeError> {
    Inputs::of(paths).spare_by(target, &[0]).map_err(MergeError::Refused)?;
    let (out, format) = (&target.path_for(0), target.format());
    let mut parts = Vec::new();
    for path in paths {
        parts.push((path, part(path)?));
    }
    let Some((first_path, first)) = parts.first().cloned() else {
        return Err(MergeError::Input("there are no parts to merge".to_owned()));
    };
    let [width, height] = first.settings.size;
    for (path, part) in &parts {
        if (&part.scene, part.settings) != (&first.scene, first.settings)
            || part.tile.transfer != first.tile.transfer
        {
            let difference =
                if part.scene != first.scene { "of another scene" } else { "of another picture" };
            return Err(MergeError::Input(format!(
                "{}: it is a part {difference} than {}; merge the parts of one render",
                path.display(),
                first_path.display()
            )));
        }
    }
    cover(&parts, [width, height]).map_err(MergeError::Input)?;

    let memory = |e: &dyn std::fmt::Display| MergeError::Memory(e.to_string());
    let layout = Layout::try_new(width, height, 16).map_err(|e| memory(&e))?;
    let mut floats = Picture::try_new(layout, SampleKind::F32).map_err(|e| memory(&e))?;
    for (path, part) in &parts {
        paste(path, part, &mut floats)?;
    }
    let transfer = crate::run::curve(first.tile.transfer);
    let kind = format.sample_kind();
    let picture = if kind == SampleKind::F32 {
        floats
    } else {
        let mut picture = Picture::try_new(layout, kind).map_err(|e| memory(&e))?;
        encode_picture(&floats, &TransferTable::new(transfer, kind), &mut picture);
        picture
    };
    let settings = FileSettings { format, compression, ..first.settings };
    let provenance = Provenance::of_merged(&first.scene, settings);
    let text = provenance.texts();
    let options = StillOptions { compression, transfer, text: &text, ..StillOptions::default() };
    let write = || -> std::io::Result<u64> {
        let sealed = encode_sealed(&picture, format, &options, None)?;
        let mut file = SafeFile::create(out)?;
        sealed.encoded.write_to(&mut file)?;
        file.commit()?;
        if let Some(manifest) = sealed.manifest {
            let mut file = SafeFile::create(&manifest_path(out))?;
            file.write_all(manifest.as_bytes())?;
            file.commit()?;
        }
        Ok(sealed.encoded.len() as u64)
    };
    let bytes = write().map_err(MergeError::Output)?;
    Ok(Merged { size: [width, height], parts: parts.len(), bytes })
}

fn wrong(path: &Path, what: impl std::fmt::Display) -> MergeError {
    MergeError::Input(format!("{}: {what}", path.display()))
}

fn read(path: &Path) -> Result<Vec<u8>, MergeError> {
    if !path.is_file() {
        return Err(wrong(path, "there is no such file"));
    }
    std::fs::read(path).map_err(|error| wrong(path, format!("it cannot be read: {error}")))
}

fn part(path: &Path) -> Result<Part, MergeError> {
    let texts = texts(&read(path)?).map_err(|error| wrong(path, error))?;
    Provenance::of_part(&texts).map_err(|error| wrong(path, error))
}

/// Checks that the parts cover every pixel once.
fn cover(parts: &[(&PathBuf, Part)], [width, height]: [u32; 2]) -> Result<(), String> {
    let end = |part: &Part, axis: usize| {
        u64::from(part.tile.origin[axis]) + u64::from(part.tile.size[axis])
    };
    for (i, (path, part)) in parts.iter().enumerate() {
        if end(part, 0) > u64::from(width) || end(part, 1) > u64::from(height) {
            return Err(format!("{}: it reaches beyond the picture", path.display()));
        }
        let over = parts[..i].iter().find(|(_, other)| {
            (0..2).all(|axis| {
                u64::from(part.tile.origin[axis]) < end(other, axis)
                    && u64::from(other.tile.origin[axis]) < end(part, axis)
            })
        });
        if let Some((other, _)) = over {
            return Err(format!(
                "{} and {} overlap; name each part once, of one grid of tiles",
                other.display(),
                path.display()
            ));
        }
    }
    // What does not overlap and lies inside covers all if its pixels are as many.
    let area = |part: &Part| u64::from(part.tile.size[0]) * u64::from(part.tile.size[1]);
    let have: u64 = parts.iter().map(|(_, part)| area(part)).sum();
    if have == u64::from(width) * u64::from(height) {
        return Ok(());
    }
    let covered = |x: u32, y: u32| {
        parts.iter().any(|(_, part)| {
            let inside = |at: u32, axis: usize| {
                at >= part.tile.origin[axis] && u64::from(at) < end(part, axis)
            };
            inside(x, 0) && inside(y, 1)
        })
    };
    // A gap begins at the picture's corner or where some part ends.
    let edges = |axis: usize| {
        let mut edges: Vec<u32> = parts.iter().map(|(_, part)| end(part, axis) as u32).collect();
        edges.push(0);
        edges.sort_unstable();
        edges
    };
    let (columns, rows) = (edges(0), edges(1));
    let gap = rows
        .iter()
        .flat_map(|y| columns.iter().map(move |x| (*x, *y)))
        .find(|(x, y)| *x < width && *y < height && !covered(*x, *y));
    let at = gap.map_or(String::new(), |(x, y)| format!(", first at pixel {x},{y}"));
    Err(format!("a part of the {width}x{height} picture is missing{at}; render and name it too"))
}

fn paste(path: &Path, part: &Part, whole: &mut Picture) -> Result<(), MergeError> {
    let bytes = read(path)?;
    // It may have been written since it was looked at.
    texts(&bytes).map_err(|error| wrong(path, error))?;
    let picture = decode_still(&bytes).map_err(|error| wrong(path, error))?;
    let layout = picture.layout();
    if [layout.width(), layout.height()] != part.tile.size || picture.kind() != SampleKind::F32 {
        return Err(wrong(path, "its pixels are not those that it tells of"));
    }
    let [x, y] = part.tile.origin;
    let mut row = vec![0.0_f32; layout.width() as usize * 3];
    for line in 0..layout.height() {
        picture.row(line, &mut row);
        whole.set_row(x, y + line, &row);
    }
    Ok(())
}
