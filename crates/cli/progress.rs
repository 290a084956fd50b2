//! How far a render is, and what it took.

use crate::console::Console;
use reflet_frame::Summary;
use std::fmt::Write as _;
use std::time::{Duration, Instant};

/// The bar of a render: frame, rate, time left. Shown on a terminal only.
pub struct Progress {
    console: Console,
    frames: usize,
    done: usize,
    begin: Instant,
    shown: Option<Instant>,
}

/// The bar is drawn no more often than this.
const PAUSE: Duration = Duration::from_millis(50);

impl Progress {
    /// A render of `frames` frames begins.
    pub fn begin(console: &Console, frames: usize) -> Self {
        let progress =
            Self { console: console.clone(), frames, done: 0, begin: Instant::now(), shown: None };
        progress.console.show(&progress.line(Duration::ZERO));
        progress
    }

    /// So many frames are on disk.
    pub fn frame(&mut self, done: usize) {
        self.done = done;
        if self.shown.is_none_or(|shown| shown.elapsed() >= PAUSE) {
            self.shown = Some(Instant::now());
            self.console.show(&self.line(self.begin.elapsed()));
        }
    }

    /// The bar goes away.
    pub fn end(&self) {
        self.console.show("");
    }

    fn line(&self, elapsed: Duration) -> String {
        const WIDTH: usize = 24;
        let full = WIDTH * self.done / self.frames.max(1);
        let bar = self.console.coloured(&"=".repeat(full), "36");
        let rest = " ".repeat(WIDTH - full.min(WIDTH));
        let mut line = format!("frame {}/{} [{bar}{rest}]", self.done, self.frames);
        if self.done > 0 && elapsed > Duration::ZERO {
            let rate = self.done as f64 / elapsed.as_secs_f64();
            let left = (self.frames - self.done.min(self.frames)) as f64 / rate;
            let _ = write!(line, " {}, {} left", frames_per_second(rate), seconds(left));
        }
        line
    }
}

/// The closing summary of a render.
pub fn summary(summary: &Summary, place: &str) -> String {
    let s = summary;
    let wall = s.elapsed_ns as f64 / 1e9;
    let frames = if s.frames == 1 { "1 frame".into() } else { format!("{} frames", s.frames) };
    let rate = match s.frames {
        0 | 1 => String::new(),
        n => format!(" ({})", frames_per_second(n as f64 / wall.max(1e-9))),
    };
    let threads = if s.threads == 1 { "1 thread".into() } else { format!("{} threads", s.threads) };
    // Of a render that casts few rays, how many it casts a second says nothing.
    let speed = match s.rays_saved {
        0 => format!(", {:.1} Mrays/s", mrays_per_second(s)),
        _ => " cast".into(),
    };
    let mut text = format!(
        "{frames} in {}{rate}, {} to {place}\n\
         {} camera, {} mirror and {} shadow rays{speed} with {} on {threads}",
        seconds(wall),
        bytes(s.bytes),
        count(s.rays.camera),
        count(s.rays.mirror),
        count(s.rays.shadow),
        s.isa,
    );
    if s.rays_saved > 0 {
        let all = s.rays.total() + s.rays_saved;
        let _ = write!(
            text,
            "\nre-use saved {} of {} rays ({}), {} of the tiles and {} of the bands; {} of {frames} \
             cast no ray from the eye",
            count(s.rays_saved),
            count(all),
            share([s.rays_saved, all]),
            share(s.tiles_copied),
            share(s.bands_kept),
            s.frames_without_retrace,
        );
    }
    text
}

/// A part of a whole, in percent.
fn share([part, whole]: [u64; 2]) -> String {
    format!("{:.0} %", 100.0 * part as f64 / whole.max(1) as f64)
}

/// Millions of rays of all kinds a second of tracing and shading; 0 if none was cast.
pub fn mrays_per_second(summary: &Summary) -> f64 {
    match (summary.rays.total(), summary.trace_ns) {
        (0, _) | (_, 0) => 0.0,
        (rays, ns) => rays as f64 * 1e3 / ns as f64,
    }
}

fn frames_per_second(rate: f64) -> String {
    if rate >= 1.0 || rate <= 0.0 {
        format!("{rate:.1} frames/s")
    } else {
        format!("{} a frame", seconds(1.0 / rate))
    }
}

/// A duration for people.
pub fn seconds(s: f64) -> String {
    match s {
        s if s < 0.9995 => format!("{:.0} ms", s * 1e3),
        s if s < 59.95 => format!("{s:.1} s"),
        s if s < 3599.5 => format!("{} min {} s", s.round() as u64 / 60, s.round() as u64 % 60),
        s => format!("{} h {} min", (s / 60.0).round() as u64 / 60, (s / 60.0).round() as u64 % 60),
    }
}

/// A number of bytes for people.
pub fn bytes(n: u64) -> String {
    scaled(n, &[" bytes", " kB", " MB", " GB", " TB"])
}

/// A number of things for people.
pub fn count(n: u64) -> String {
    scaled(n, &["", " k", " M", " G", " T"])
}

fn scaled(n: u64, units: &[&str]) -> String {
    let mut value = n as f64;
    let mut unit = 0;
    while value >= 999.95 && unit + 1 < units.len() {
        value /= 1000.0;
        unit += 1;
    }
    if unit == 0 { format!("{n}{}", units[0]) } else { format!("{value:.1}{}", units[unit]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_for_people() {
        assert_eq!(bytes(0), "0 bytes");
        assert_eq!(bytes(999), "999 bytes");
        assert_eq!(bytes(1000), "1.0 kB");
        assert_eq!(bytes(999_949), "999.9 kB");
        assert_eq!(bytes(999_951), "1.0 MB");
        assert_eq!(count(12), "12");
        assert_eq!(count(1_230_000), "1.2 M");
        assert_eq!(seconds(0.0123), "12 ms");
        assert_eq!(seconds(0.9996), "1.0 s");
        assert_eq!(seconds(59.96), "1 min 0 s");
        assert_eq!(seconds(7384.0), "2 h 3 min");
        assert_eq!(frames_per_second(0.25), "4.0 s a frame");
    }

    #[test]
    fn the_summary_says_all() {
        let mut s = Summary {
            frames: 24,
            elapsed_ns: 2_000_000_000,
            trace_ns: 1_000_000_000,
            ..Default::default()
        };
        s.rays.camera = 4_000_000;
        s.rays.shadow = 2_000_000;
        s.bytes = 5_000_000;
        s.isa = "avx2";
        s.threads = 2;
        assert_eq!(
            summary(&s, "out/frame-####.png"),
            "24 frames in 2.0 s (12.0 frames/s), 5.0 MB to out/frame-####.png\n\
             4.0 M camera, 0 mirror and 2.0 M shadow rays, 6.0 Mrays/s with avx2 on 2 threads"
        );
        s.rays_saved = 18_000_000;
        s.tiles_copied = [1, 4];
        s.bands_kept = [1, 2];
        s.frames_without_retrace = 23;
        assert_eq!(
            summary(&s, "out/frame-####.png"),
            "24 frames in 2.0 s (12.0 frames/s), 5.0 MB to out/frame-####.png\n\
             4.0 M camera, 0 mirror and 2.0 M shadow rays cast with avx2 on 2 threads\n\
             re-use saved 18.0 M of 24.0 M rays (75 %), 25 % of the tiles and 50 % of the bands; 23 \
             of 24 frames cast no ray from the eye"
        );
    }
}
