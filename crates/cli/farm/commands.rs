//! One command a line.

use super::{FarmJob, Work, line};
use reflet_frame::resume::ranges;

/// The tasks of a job, one a line.
pub fn lines(job: &FarmJob) -> String {
    let mut lines = String::new();
    let mut add = |mut words: Vec<String>, more: [String; 2]| {
        words.insert(0, "reflet".into());
        words.extend(more);
        lines += &line(&words);
        lines.push('\n');
    };
    match &job.work {
        Work::Frames { frames, chunk, .. } => {
            let output = super::text(&job.output);
            for chunk in frames.chunks(*chunk) {
                add(job.render(&output), ["--frames".into(), ranges(chunk)]);
            }
        }
        Work::Tiles { tiles, frame } => {
            for row in 1..=tiles.rows {
                for column in 1..=tiles.columns {
                    let mut words = job.render(&format!("{}/{column}-{row}.exr", job.parts()));
                    words.extend(["--frames".into(), frame.to_string()]);
                    let tile = format!("{column},{row}/{}x{}", tiles.columns, tiles.rows);
                    add(words, ["--tile".into(), tile]);
                }
            }
        }
    }
    lines
}
