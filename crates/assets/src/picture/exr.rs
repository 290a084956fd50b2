//! OpenEXR: the display window as a picture, black where there is no data.

use super::{Curve, Orientation, Raster, Room, Samples, zeros};
use crate::error::Fault;
use exr::error::Error;
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use exr::prelude::*;
use std::io::Cursor;

/// The picture while it is filled: where the first column and row of the data lie in it.
struct Filling {
    values: Vec<f32>,
    size: [i64; 2],
    offset: [i64; 2],
}

impl Filling {
    fn set<const N: usize>(&mut self, at: Vec2<usize>, pixel: [f32; N]) {
        let at = [at.x() as i64 + self.offset[0], at.y() as i64 + self.offset[1]];
        if (0..2).all(|axis| (0..self.size[axis]).contains(&at[axis])) {
            let first = (at[1] * self.size[0] + at[0]) as usize * N;
            self.values[first..first + N].copy_from_slice(&pixel);
        }
    }
}

pub(super) fn decode(bytes: &[u8], room: Room) -> std::result::Result<Raster, Fault> {
    let wrong = |error: Error| match error {
        Error::NotSupported(what) => unread(&what),
        error => Fault::file(format!("the EXR is broken: {error}")),
    };
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), true).map_err(wrong)?;
    if meta.headers.iter().any(|header| header.deep) {
        return Err(unread("deep data"));
    }
    let has = |header: &&Header, name: &str| header.channels.list.iter().any(|c| c.name == *name);
    let coloured = meta.headers.iter().find(|h| ["R", "G", "B"].iter().all(|name| has(h, name)));
    let grey = meta.headers.iter().find(|header| has(header, "Y"));
    let header = coloured.or(grey).ok_or_else(|| {
        let all = names(meta.headers.iter().flat_map(|h| &h.channels.list));
        Fault::file(format!("the EXR has no part with channels R, G and B, or Y; it has {all}"))
    })?;
    if coloured.is_none() && (has(&header, "RY") || has(&header, "BY")) {
        return Err(unread("luminance and chroma (channels Y, RY and BY)"));
    }
    if header.channels.list.iter().any(|c| c.sampling != Vec2(1, 1)) {
        return Err(unread("channels that are not sampled in every pixel"));
    }
    let (display, data) = (header.shared_attributes.display_window, header.layer_size);
    let size = display.size;
    let opaque = has(&header, "A");
    let channels = if coloured.is_some() { 3 } else { 1 } + usize::from(opaque);
    let count = room.pixels(size.width() as u64, size.height() as u64, 4 * channels as u64)?;
    blocks_fit(header, room)?;

    let place = header.own_attributes.layer_position;
    let offset = [(place.x(), display.position.x()), (place.y(), display.position.y())]
        .map(|(data, display)| i64::from(data) - i64::from(display));
    let values = zeros(count * channels)?;
    let extent = [size.width() as i64, size.height() as i64];
    // Handed to whichever closure makes the picture; there is one picture.
    let blank = std::cell::RefCell::new(Some(Filling { values, size: extent, offset }));
    let made = || match blank.take() {
        Some(filling) => filling,
        None => Filling { values: Vec::new(), size: [0; 2], offset },
    };
    // What is optional and absent is 1, and not stored.
    let read = read().no_deep_data().largest_resolution_level().specific_channels();
    macro_rules! filled {
        ($channels:expr, $set:expr) => {{
            let pixels = $channels.collect_pixels(|_, _| made(), $set);
            let layer = pixels.first_valid_layer().all_attributes().non_parallel();
            layer.from_buffered(Cursor::new(bytes)).map_err(wrong)?.layer_data.channel_data.pixels
        }};
    }
    let filling: Filling = match channels {
        4 => filled!(
            read.required("R").required("G").required("B").required("A"),
            |f: &mut Filling, at, (r, g, b, a): (f32, f32, f32, f32)| f.set(at, [r, g, b, a])
        ),
        3 => {
            filled!(
                read.required("R").required("G").required("B"),
                |f: &mut Filling, at, (r, g, b): (f32, f32, f32)| f.set(at, [r, g, b])
            )
        }
        2 => {
            filled!(read.required("Y").required("A"), |f: &mut Filling, at, (y, a): (f32, f32)| f
                .set(at, [y, a]))
        }
        _ => filled!(read.required("Y"), |f: &mut Filling, at, (y,): (f32,)| f.set(at, [y])),
    };
    if filling.values.len() != count * channels {
        return Err(Fault::file("the EXR is broken: its parts contradict each other"));
    }
    Ok(Raster {
        width: size.width() as u32,
        height: size.height() as u32,
        channels,
        samples: Samples::F32(filling.values),
        curve: Curve::Linear,
        orientation: Orientation::NoTransforms,
        notes: notes(&meta, header, offset, [data.width() as i64, data.height() as i64], extent),
    })
}

fn unread(what: &str) -> Fault {
    let what = what.replace(char::is_control, " ");
    Fault::file(format!(
        "the EXR has {what}, which is not read: save it with channels R, G and B, ZIP"
    ))
}

/// Refuses data of too many pixels, or in blocks too large: one is unpacked as a whole.
fn blocks_fit(header: &Header, room: Room) -> std::result::Result<(), Fault> {
    let (width, height) = (header.layer_size.width() as u64, header.layer_size.height() as u64);
    let bytes: u64 =
        header.channels.list.iter().map(|c| c.sample_type.bytes_per_sample() as u64).sum();
    room.pixels(width, height, 4)?;
    let lines = header.compression.scan_lines_per_block() as u64;
    let [across, down] = match header.blocks {
        BlockDescription::ScanLines => [width, height.min(lines)],
        BlockDescription::Tiles(tiles) => {
            let tile = tiles.tile_size;
            [width.min(tile.width() as u64), height.min(tile.height() as u64)]
        }
    };
    // Packed, unpacked, and with its bytes in order.
    let made = Room { made: 0, ..room };
    made.pixels(across, down, bytes.saturating_mul(3)).map(|_| ())
}

fn names<'a>(channels: impl Iterator<Item = &'a ChannelDescription>) -> String {
    const SHOWN: usize = 6;
    let all: Vec<String> =
        channels.map(|c| c.name.to_string().replace(char::is_control, "\u{fffd}")).collect();
    let rest = match all.len().saturating_sub(SHOWN) {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!("{}{rest}", all[..all.len().min(SHOWN)].join(", "))
}

/// What of the file is left out.
fn notes(
    meta: &MetaData,
    header: &Header,
    offset: [i64; 2],
    data: [i64; 2],
    size: [i64; 2],
) -> Vec<String> {
    let mut notes = Vec::new();
    let used = |c: &&ChannelDescription| {
        ["R", "G", "B", "A"].iter().any(|name| c.name == **name)
            || !header.channels.list.iter().any(|c| c.name == *"R") && c.name == *"Y"
    };
    let mut others: Vec<&ChannelDescription> = Vec::new();
    for other in &meta.headers {
        let own = std::ptr::eq(other, header);
        others.extend(other.channels.list.iter().filter(|c| !own || !used(c)));
    }
    if !others.is_empty() {
        notes.push(format!("its channels {} are left out", names(others.into_iter())));
    }
    if (0..2).any(|axis| offset[axis] < 0 || offset[axis] + data[axis] > size[axis]) {
        notes.push("what lies outside of its display window is left out".to_owned());
    }
    if let Some(own) = header.shared_attributes.chromaticities {
        // Those of ITU-R BT.709, and room for values rounded to three places.
        let theirs = [own.red, own.green, own.blue, own.white];
        let srgb = [(0.64, 0.33), (0.3, 0.6), (0.15, 0.06), (0.3127, 0.329)];
        let far = |(a, (x, y)): (&Vec2<f32>, (f32, f32))| {
            (a.x() - x).abs() > 0.002 || (a.y() - y).abs() > 0.002
        };
        if theirs.iter().zip(srgb).any(far) {
            notes.push(
                "its chromaticities are left out: its colours are taken as those of sRGB"
                    .to_owned(),
            );
        }
    }
    notes
}
