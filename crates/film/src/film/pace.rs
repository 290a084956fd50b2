//! How long the frames of a GIF stay, in hundredths of a second.
//!
//! Viewers show a delay below 2 hundredths as 10, so above 50 frames a second time is cut into slots
//! of 2 hundredths, each of which shows the frame that is under way when it begins; frames that no
//! slot begins in are left out. Slots are counted from the film's beginning, so that nothing drifts,
//! and the last one takes up what is left.

use super::Fps;
use crate::format::Format;

/// The least delay that viewers take as it is.
const LEAST: u64 = 2;

/// The fastest rate whose frames all stay long enough.
const FASTEST: u64 = 50;

fn is_fast(fps: Fps) -> bool {
    u64::from(fps.numerator()) > FASTEST * u64::from(fps.denominator())
}

/// Slots of a film of `frames` frames.
fn slots(fps: Fps, frames: u32) -> u64 {
    (fps.end_of(frames.saturating_sub(1), 100) / LEAST).max(1)
}

/// How many of the frames are shown.
pub(super) fn shown(format: Format, fps: Fps, frames: u32) -> u64 {
    match format == Format::Gif && is_fast(fps) {
        true => slots(fps, frames),
        false => frames.into(),
    }
}

/// How long frame `index` of `frames` stays in a GIF; `None` if it is left out.
pub(super) fn hundredths(fps: Fps, frames: u32, index: u32) -> Option<u64> {
    if !is_fast(fps) {
        return Some(fps.delay_of(index, 100));
    }
    let (rate, per) = (u64::from(fps.numerator()), 100 * u64::from(fps.denominator()));
    // The first slot that begins in the frame or after it, and the frame that it begins in.
    let slot = (u64::from(index) * per).div_ceil(LEAST * rate);
    let begun = LEAST * slot * rate / per;
    let slots = slots(fps, frames);
    if begun != u64::from(index) || slot >= slots {
        return None;
    }
    let length = fps.end_of(frames - 1, 100);
    Some(if slot + 1 == slots { length.saturating_sub(LEAST * slot).max(LEAST) } else { LEAST })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_delay_is_shorter_than_viewers_take_and_nothing_drifts() {
        let rates = [(1, 1), (24, 1), (24000, 1001), (30, 1), (100, 3), (333, 10), (48, 1)];
        let fast = [(50, 1), (5001, 100), (60000, 1001), (60, 1), (75, 1), (99, 1), (100, 1)];
        let faster = [(101, 1), (120, 1), (120_000, 1001), (144, 1), (1000, 1), (1_000_000, 1)];
        for (numerator, denominator) in rates.into_iter().chain(fast).chain(faster) {
            let fps = Fps::new(numerator, denominator).unwrap();
            for frames in [1, 2, 3, 7, 59, 60, 61, 1000] {
                let delays: Vec<u64> =
                    (0..frames).filter_map(|index| hundredths(fps, frames, index)).collect();
                assert!(hundredths(fps, frames, 0).is_some());
                assert_eq!(delays.len() as u64, shown(Format::Gif, fps, frames), "{fps:?}");
                assert!(delays.iter().all(|delay| *delay >= LEAST), "{fps:?} {delays:?}");
                // The film's length, rounded to hundredths; the least is one delay.
                let exact = 100.0 * f64::from(frames) * f64::from(denominator);
                let exact = (exact / f64::from(numerator)).max(2.0);
                let length = delays.iter().sum::<u64>() as f64;
                assert!((length - exact).abs() <= 0.5, "{fps:?} {frames}: {length} {exact}");
            }
        }
    }

    #[test]
    fn of_sixty_frames_a_second_fifty_are_shown() {
        let fps = Fps::new(60, 1).unwrap();
        let shown: Vec<u32> =
            (0..12).filter(|index| hundredths(fps, 60, *index).is_some()).collect();
        assert_eq!(shown, [0, 1, 2, 3, 4, 6, 7, 8, 9, 10]);
    }
}
