//! `--verbose`: what changed in a frame, what was redone for it, and why.

use crate::progress::{count, seconds};
use reflet_frame::FrameReport;
use std::fmt::Write as _;

/// A frame in a few words.
pub fn frame(r: &FrameReport) -> String {
    let mut text = format!("frame {}: ", r.frame);
    let things: Vec<String> =
        r.changed.things.iter().map(|thing| format!("{} {}", thing.name, thing.how)).collect();
    match (things.as_slice(), r.fresh) {
        ([], Some(_)) => {}
        ([], None) => text += "nothing changed; ",
        (things, _) => text += &format!("changed: {}", things.join(", ")),
    }
    if r.changed.count > things.len() {
        let _ = write!(text, " and {} more", r.changed.count - things.len());
    }
    if !things.is_empty() {
        text += "; ";
    }
    text += &match r.fresh {
        Some(why) => format!("traced anew ({why})"),
        None => redone(r),
    };
    let _ = write!(
        text,
        "; {} of {} tiles shaded, {} of {} bands encoded, {}",
        r.shaded_tiles,
        r.tiles,
        r.bands_encoded,
        r.bands_encoded + r.bands_kept,
        seconds(r.elapsed_ns() as f64 / 1e9),
    );
    text
}

/// What of kept trees was done again.
fn redone(r: &FrameReport) -> String {
    let rays = r.rays.total();
    if rays == 0 && r.tested_segments == 0 {
        return "no ray cast".into();
    }
    let mut parts = Vec::new();
    if r.tested_segments > 0 {
        let (pixels, segments) = (count(r.retraced_pixels), count(r.tested_segments));
        parts.push(format!("{pixels} pixels retraced after a look at {segments} segments"));
    }
    if r.replayed_nodes > 0 {
        parts.push(format!("{} hits found again", count(r.replayed_nodes)));
    }
    if r.deepened_nodes > 0 {
        parts.push(format!("{} mirrored rays added", count(r.deepened_nodes)));
    }
    let kinds = [(r.rays.camera, "camera"), (r.rays.mirror, "mirror"), (r.rays.shadow, "shadow")];
    let cast =
        kinds.iter().filter(|(n, _)| *n > 0).map(|(n, kind)| format!("{} {kind}", count(*n)));
    let cast: Vec<String> = cast.collect();
    parts.push(if cast.is_empty() {
        "no ray cast".into()
    } else {
        format!("{} rays", cast.join(", "))
    });
    parts.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use reflet_frame::{Changed, Thing};

    #[test]
    fn a_frame_is_told_with_its_causes() {
        let thing = Thing { name: "material (line 7)".into(), how: "colours" };
        let mut report = FrameReport {
            frame: 4,
            changed: Changed { things: vec![thing], count: 3 },
            shaded_tiles: 5,
            tiles: 920,
            bands_encoded: 1,
            bands_kept: 11,
            encode_ns: 2_000_000,
            ..FrameReport::default()
        };
        assert_eq!(
            frame(&report),
            "frame 4: changed: material (line 7) colours and 2 more; no ray cast; \
             5 of 920 tiles shaded, 1 of 12 bands encoded, 2 ms"
        );
        report.changed = Changed::default();
        report.fresh = Some("the camera moved");
        assert!(frame(&report).starts_with("frame 4: traced anew (the camera moved);"));
        report.fresh = None;
        report.tested_segments = 2000;
        report.retraced_pixels = 7;
        report.rays.camera = 7;
        let text = frame(&report);
        let redone = "; 7 pixels retraced after a look at 2.0 k segments, 7 camera rays;";
        assert!(text.contains(redone), "{text}");
    }
}
