//! One command a line.

use super::{CHUNK, FarmJob, Work, line};
use reflet_frame::resume::ranges;

/// The tasks of a job, one a line.
pub fn lines(job: &FarmJob) -> String {
    let mut lines = String::new();
    let mut add = |output: String, more: &[String]| {
        let words = [&["reflet".into()], &job.scene()[..], &[output], &job.options(), more];
        lines += &line(&words.concat());
        lines.push('\n');
    };
    match &job.work {
        Work::Frames { frames, chunk, .. } => {
            for chunk in frames.chunks(chunk.unwrap_or(CHUNK)) {
                add(job.output.clone(), &["--frames".into(), ranges(chunk)]);
            }
        }
        Work::Tiles { tiles, frame } => {
            for row in 1..=tiles.rows {
                for column in 1..=tiles.columns {
                    let tile = format!("{column},{row}/{}x{}", tiles.columns, tiles.rows);
                    let part = format!("{}/{column}-{row}.exr", job.parts());
                    add(part, &["--frames".into(), frame.to_string(), "--tile".into(), tile]);
                }
            }
        }
    }
    lines
}
