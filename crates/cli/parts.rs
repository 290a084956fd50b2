//! What of a render is asked for: all of it, what is missing, a shard of its frames, or a tile of
//! one picture.

use clap::Args;
use reflet_frame::TileChoice;
use std::fmt;
use std::str::FromStr;

/// What `render` takes for long runs.
#[derive(Debug, Args)]
pub struct PartArgs {
    /// Keep frames that are whole and what they would be now; make the others, and name them
    #[arg(long)]
    pub resume: bool,
    /// Render one of so many equal parts of the frames, as in 2/5
    #[arg(long, value_name = "I/N", allow_hyphen_values = true)]
    pub shard: Option<Shard>,
    /// Render one tile of a picture into an EXR part for `reflet merge`: column,row/columns x rows,
    /// as in 3,2/8x6
    #[arg(long, value_name = "C,R/CxR", allow_hyphen_values = true)]
    pub tile: Option<TileChoice>,
}

/// One of so many parts of the frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which, from 1.
    index: u32,
    /// How many there are.
    count: u32,
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const FORM: &str = "write which of how many, as in 2/5, counted from 1";
        let number = |text: &str| {
            let digits = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
            text.parse().ok().filter(|n: &u32| digits && *n >= 1)
        };
        let (index, count) = text.split_once('/').ok_or(FORM)?;
        let (Some(index), Some(count)) = (number(index), number(count)) else {
            return Err(FORM.to_owned());
        };
        if index > count {
            return Err(format!("there is no part {index} of {count}; {FORM}"));
        }
        Ok(Shard { index, count })
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl Shard {
    /// Its frames: neighbours, so that they have much to take over from one another.
    pub fn of(self, frames: &[u32]) -> Vec<u32> {
        let cut = |i: u32| (frames.len() as u128 * u128::from(i) / u128::from(self.count)) as usize;
        frames[cut(self.index - 1)..cut(self.index)].to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_all_frames_once() {
        for frames in [0_u32, 1, 5, 120] {
            let all: Vec<u32> = (0..frames).collect();
            for count in [1, 2, 5, 7, 200] {
                let shards = (1..=count).flat_map(|index| Shard { index, count }.of(&all));
                assert_eq!(shards.collect::<Vec<_>>(), all, "{frames} in {count}");
            }
        }
        assert_eq!(Shard { index: u32::MAX, count: u32::MAX }.of(&[7]), [7]);
    }

    #[test]
    fn what_is_no_shard_is_refused() {
        assert_eq!("2/5".parse(), Ok(Shard { index: 2, count: 5 }));
        for bad in ["", "1", "0/5", "6/5", "1/0", "a/5", "1/5/5", "-1/5", "+1/5"] {
            assert!(bad.parse::<Shard>().is_err(), "{bad}");
        }
    }
}
