//! The grammar of `--frames`: `7`, `0-119`, `0-119:10`, and lists of them with commas.
//!
//! It is the range expression of Open Job Description and of Slurm's arrays: ends are inclusive, `:`
//! is the step, a negative step counts down, blanks are allowed around numbers.

/// Which frames of an animation are asked for; not yet held against the animation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FrameRanges(Vec<Range>);

/// First and last frame, and the way from one to the next (its absolute value).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Range {
    first: u32,
    last: u32,
    step: u32,
}

impl std::str::FromStr for FrameRanges {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        text.split(',').map(|part| range(part.trim())).collect::<Result<_, _>>().map(Self)
    }
}

fn range(part: &str) -> Result<Range, String> {
    const FORMS: &str = "write 7, 0-119, 0-119:10, or several with commas between";
    if part.is_empty() {
        return Err(format!("a range is empty; {FORMS}"));
    }
    let (ends, step) = match part.split_once(':') {
        Some((ends, step)) => (ends, Some(step.trim())),
        None => (part, None),
    };
    let number = |text: &str| {
        let text = text.trim();
        if text.is_empty() || !text.bytes().all(|b| b.is_ascii_digit()) {
            return Err(format!("`{text}` in `{part}` is no frame number; {FORMS}"));
        }
        text.parse::<u32>().map_err(|_| format!("frame {text} is beyond every animation"))
    };
    let Some((first, last)) = ends.split_once('-') else {
        let frame = number(ends)?;
        if step.is_some() {
            return Err(format!("`{part}` has a step and no end; write {frame}-LAST:STEP"));
        }
        return Ok(Range { first: frame, last: frame, step: 1 });
    };
    let (from, to) = (number(first)?, number(last)?);
    let down = step.is_some_and(|s| s.starts_with('-'));
    let step = match step {
        Some(step) => number(step.strip_prefix('-').unwrap_or(step))?,
        None => 1,
    };
    if step == 0 {
        return Err(format!("the step of `{part}` is 0; the least is 1"));
    }
    match (from <= to, down) {
        (true, false) => Ok(Range { first: from, last: to, step }),
        // Counting down names the frames first, first - step, ...: the lowest is not always `to`.
        (_, true) if from >= to => {
            Ok(Range { first: from - (from - to) / step * step, last: from, step })
        }
        (true, _) => Err(format!(
            "`{part}` counts down from {from}, which is before {to}; write {from}-{to}:{step}"
        )),
        (false, _) => Err(format!("`{part}` ends before it starts; write {to}-{from}")),
    }
}

/// What to say of a frame that an animation of `frames` does not have.
pub fn outside_of(frame: u32, frames: u32) -> String {
    let has = match frames {
        1 => "the scene has one frame, 0".to_owned(),
        n => format!("the animation has {n} frames, 0 to {}", n - 1),
    };
    format!("there is no frame {frame}: {has}")
}

impl FrameRanges {
    /// The frames, ascending, each once, of an animation of `frames` frames.
    ///
    /// # Errors
    /// A frame outside the animation.
    pub fn within(&self, frames: u32) -> Result<Vec<u32>, String> {
        if let Some(outside) = self.0.iter().find(|r| r.last >= frames) {
            return Err(format!("--frames: {}", outside_of(outside.last, frames)));
        }
        let mut picked: Vec<u32> =
            self.0.iter().flat_map(|r| (r.first..=r.last).step_by(r.step as usize)).collect();
        picked.sort_unstable();
        picked.dedup();
        Ok(picked)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picked(text: &str) -> Vec<u32> {
        text.parse::<FrameRanges>().unwrap().within(120).unwrap()
    }

    #[test]
    fn every_form() {
        assert_eq!(picked("7"), [7]);
        assert_eq!(picked("0-3"), [0, 1, 2, 3]);
        assert_eq!(picked("0-119:50"), [0, 50, 100]);
        assert_eq!(picked("5-5:9"), [5]);
        assert_eq!(picked("119-0:-50"), [19, 69, 119]);
        assert_eq!(picked("3-3:-2"), [3]);
        assert_eq!(picked(" 1 - 3 : 2 , 119"), [1, 3, 119]);
        assert_eq!(picked("0-119").len(), 120);
    }

    #[test]
    fn what_is_printed_can_be_typed() {
        for bits in 0_u32..1 << 12 {
            let frames: Vec<u32> = (0..12).filter(|i| bits & (1 << i) != 0).collect();
            let text = reflet_frame::resume::ranges(&frames);
            if !frames.is_empty() {
                assert_eq!(picked(&text), frames, "{text}");
            }
        }
    }

    #[test]
    fn lists_are_sorted_and_each_frame_comes_once() {
        assert_eq!(picked("9,1-3,2,0-4:2"), [0, 1, 2, 3, 4, 9]);
    }

    #[test]
    fn frames_outside_are_named() {
        let all: FrameRanges = "3,0-4294967295".parse().unwrap();
        assert_eq!(
            all.within(120).unwrap_err(),
            "--frames: there is no frame 4294967295: the animation has 120 frames, 0 to 119"
        );
        let one: FrameRanges = "1".parse().unwrap();
        assert_eq!(
            one.within(1).unwrap_err(),
            "--frames: there is no frame 1: the scene has one frame, 0"
        );
        assert!("0-119:7".parse::<FrameRanges>().unwrap().within(119).is_err());
    }

    #[test]
    fn what_is_no_range_says_what_is() {
        for (text, message) in [
            ("", "a range is empty"),
            ("1,,2", "a range is empty"),
            ("x", "`x` in `x` is no frame number"),
            ("-3", "`` in `-3` is no frame number"),
            ("1-", "`` in `1-` is no frame number"),
            ("1--3", "`-3` in `1--3` is no frame number"),
            ("1.5", "`1.5` in `1.5` is no frame number"),
            ("0-9:", "`` in `0-9:` is no frame number"),
            ("0-9:0", "the step of `0-9:0` is 0"),
            ("0-9:2:3", "`2:3` in `0-9:2:3` is no frame number"),
            ("0-9%4", "`9%4` in `0-9%4` is no frame number"),
            ("7:2", "`7:2` has a step and no end; write 7-LAST:STEP"),
            ("9-0", "`9-0` ends before it starts; write 0-9"),
            ("0-9:-2", "`0-9:-2` counts down from 0, which is before 9; write 0-9:2"),
            ("4294967296", "frame 4294967296 is beyond every animation"),
        ] {
            let error = text.parse::<FrameRanges>().unwrap_err();
            assert!(error.starts_with(message), "{text:?}: {error}");
        }
    }
}
