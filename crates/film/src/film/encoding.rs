//! What of a film can be chosen, and what its format cannot do.

use super::{FilmSpec, pace};
use crate::format::Format;
use crate::transfer::Transfer;

/// How a GIF stands for colours that its palette lacks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum Dither {
    /// By the palette's nearest.
    #[default]
    None,
    /// By a pattern of near ones that depends on the pixel's place alone (Bayer 1973), so that what
    /// does not move does not flicker.
    Ordered,
}

impl Dither {
    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Ordered => "ordered",
        }
    }
}

/// How well ffmpeg encodes a film: 0 to 100, where 2 are one step of H.264's constant rate factor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct VideoQuality(u8);

impl VideoQuality {
    /// A quality of 0, the least, to 100.
    pub fn new(quality: u8) -> Option<Self> {
        (quality <= 100).then_some(Self(quality))
    }

    /// 0 to 100.
    pub fn get(self) -> u8 {
        self.0
    }

    /// H.264's constant rate factor; 0, which is lossless in a profile that few players read, is
    /// left out.
    pub(crate) fn crf(self) -> u8 {
        (100 - self.0).div_ceil(2).max(1)
    }
}

impl Default for VideoQuality {
    fn default() -> Self {
        Self(68)
    }
}

impl FilmSpec {
    /// What of the film its format cannot do, for warnings.
    pub fn warnings(&self) -> Vec<String> {
        let Self { format, fps, frames, .. } = *self;
        let mut warnings = Vec::new();
        let rate = match fps.denominator() {
            1 => fps.numerator().to_string(),
            per => format!("{}/{per}", fps.numerator()),
        };
        let left_out = u64::from(frames).saturating_sub(pace::shown(format, fps, frames));
        if left_out > 0 {
            warnings.push(format!(
                "a GIF at {rate} frames a second: browsers show delays below 2 hundredths of a \
                 second as 10, so {left_out} of {frames} frames are left out to keep its pace; \
                 choose 50 frames a second or fewer, or mp4"
            ));
        }
        let short = u64::from(fps.numerator()) >= 100 * u64::from(fps.denominator());
        if matches!(format, Format::Apng | Format::Webp) && frames > 1 && short {
            warnings.push(format!(
                "{format} at {rate} frames a second: browsers show delays of 10 ms and less as \
                 100 ms; choose fewer than 100 frames a second, or mp4"
            ));
        }
        warnings.extend(format.cannot_say(self.transfer));
        warnings
    }
}

impl Format {
    /// A warning, if files of this format have no place to say that their samples went through
    /// `transfer`, and are taken for others.
    pub fn cannot_say(self, transfer: Transfer) -> Option<String> {
        let silent = matches!(self, Self::Jpeg | Self::Ppm | Self::Gif | Self::Webp | Self::Y4m);
        (silent && transfer == Transfer::Linear).then(|| {
            format!(
                "{self} cannot say that its samples are linear (transfer: \"linear\"), and viewers \
                 show them too dark; png, apng, exr, qoi, mp4 and mkv say it"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn qualities_are_rate_factors() {
        let crf = |quality| VideoQuality::new(quality).unwrap().crf();
        assert_eq!([0, 50, 68, 98, 100].map(crf), [50, 25, 16, 1, 1]);
        assert_eq!(VideoQuality::default().crf(), 16);
        assert_eq!(VideoQuality::new(101), None);
    }
}
