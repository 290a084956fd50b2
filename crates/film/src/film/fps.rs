//! Frames a second, as a fraction.

use std::fmt;

/// Frames a second: a fraction in lowest terms, both parts 1 to 1,000,000.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Fps {
    numerator: u32,
    denominator: u32,
}

/// A rate that is not above zero, or not within the range of [`Fps`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FpsError {
    rate: String,
}

impl fmt::Display for FpsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} frames a second: the rate must be from 0.001 to 1000000, as in 24, 29.97 or 24000/1001",
            self.rate
        )
    }
}

impl std::error::Error for FpsError {}

const LIMIT: u32 = 1_000_000;

impl Fps {
    /// `numerator` / `denominator` frames a second, in lowest terms each 1 to 1,000,000.
    pub fn new(numerator: u32, denominator: u32) -> Result<Self, FpsError> {
        let (mut a, mut b) = (numerator, denominator);
        while b != 0 {
            (a, b) = (b, a % b);
        }
        let divisor = a.max(1);
        let fps = Self { numerator: numerator / divisor, denominator: denominator / divisor };
        let range = 1..=LIMIT;
        if range.contains(&fps.numerator) && range.contains(&fps.denominator) {
            Ok(fps)
        } else {
            Err(FpsError { rate: format!("{numerator}/{denominator}") })
        }
    }

    /// The rate as a fraction: exact for a multiple of 1/1000, n * 1000/1001 for the rates of
    /// television written in decimals (23.976, 29.97, 59.94), else rounded to 1/1000 (or to a whole
    /// number above 1000).
    pub fn from_f64(rate: f64) -> Result<Self, FpsError> {
        let error = || FpsError { rate: rate.to_string() };
        if !(0.001..=f64::from(LIMIT)).contains(&rate) {
            return Err(error());
        }
        let whole = (rate * 1.001).round();
        let television = whole * 1000.0 / 1001.0;
        if [24.0, 30.0, 48.0, 60.0, 120.0].contains(&whole) && (television - rate).abs() < 0.005 {
            return Self::new(whole as u32 * 1000, 1001);
        }
        if rate.fract() == 0.0 || rate >= 1000.0 {
            return Self::new(rate.round() as u32, 1);
        }
        Self::new((rate * 1000.0).round() as u32, 1000)
    }

    /// The rate in `text`: a decimal number as [`Fps::from_f64`] takes it, or a fraction of two whole
    /// numbers, as in 24000/1001.
    pub fn from_text(text: &str) -> Result<Self, FpsError> {
        let error = || FpsError { rate: text.to_owned() };
        let Some((numerator, denominator)) = text.split_once('/') else {
            return Self::from_f64(text.parse().map_err(|_| error())?);
        };
        let whole = |text: &str| {
            let digits = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
            text.parse::<u32>().ok().filter(|_| digits).ok_or_else(error)
        };
        Self::new(whole(numerator)?, whole(denominator)?)
    }

    /// The fraction's upper part.
    pub fn numerator(self) -> u32 {
        self.numerator
    }

    /// The fraction's lower part.
    pub fn denominator(self) -> u32 {
        self.denominator
    }

    /// When frame `index` ends, in whole units of which `units` make a second: rounded, so that
    /// delays add up to the film's length however long it is.
    pub(crate) fn end_of(self, index: u32, units: u32) -> u64 {
        let frames = u128::from(index) + 1;
        let exact = frames * u128::from(units) * u128::from(self.denominator);
        let fps = u128::from(self.numerator);
        ((2 * exact + fps) / (2 * fps)) as u64
    }

    /// How long frame `index` lasts, in such units.
    pub(crate) fn delay_of(self, index: u32, units: u32) -> u64 {
        let start = index.checked_sub(1).map_or(0, |i| self.end_of(i, units));
        self.end_of(index, units) - start
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates() {
        let rate = |rate| Fps::from_f64(rate).map(|fps| (fps.numerator(), fps.denominator()));
        assert_eq!(rate(24.0), Ok((24, 1)));
        assert_eq!(rate(23.976), Ok((24000, 1001)));
        assert_eq!(rate(29.97), Ok((30000, 1001)));
        assert_eq!(rate(12.5), Ok((25, 2)));
        assert_eq!(rate(0.1), Ok((1, 10)));
        for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e7, 1e-9] {
            assert!(rate(wrong).is_err(), "{wrong}");
        }
        assert!(Fps::new(0, 1).is_err());
        assert!(Fps::new(1, 0).is_err());
        assert_eq!(Fps::new(48, 2), Fps::new(24, 1));
        assert_eq!(Fps::from_text("24000/1001"), Fps::new(24000, 1001));
        assert_eq!(Fps::from_text("29.97"), Fps::new(30000, 1001));
        assert_eq!(Fps::from_text("60"), Fps::new(60, 1));
        for wrong in ["", "x", "1/0", "0/1", "+1/1", "1/", "1/2/3", "-24", "1.5/2", "inf"] {
            assert!(Fps::from_text(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn delays_add_up() {
        for (numerator, denominator) in [(24, 1), (30000, 1001), (7, 1), (60, 1), (1, 3), (200, 1)]
        {
            let fps = Fps::new(numerator, denominator).unwrap();
            let mut sum = 0;
            for index in 0..1000 {
                sum += fps.delay_of(index, 100);
                let exact =
                    100.0 * f64::from(index + 1) * f64::from(denominator) / f64::from(numerator);
                assert!((sum as f64 - exact).abs() <= 0.5, "{fps:?} {index}");
            }
        }
    }
}
