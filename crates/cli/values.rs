//! What the values of options are: read, with a message that says what is allowed.

use clap::builder::{PossibleValue, TypedValueParser};
use clap::error::Error;
use clap::{Arg, Command};
use reflet_accel::{Isa, Quality};
use reflet_film::{Compression, Format};
use std::ffi::OsStr;
use std::num::{NonZeroU32, NonZeroU64, NonZeroUsize};

/// One of some words: completions know them, and the message is ours.
#[derive(Clone)]
pub struct OneOf<T> {
    names: fn() -> Vec<&'static str>,
    read: fn(&str) -> Result<T, String>,
}

impl<T: Clone + Send + Sync + 'static> TypedValueParser for OneOf<T> {
    type Value = T;

    fn parse_ref(&self, command: &Command, arg: Option<&Arg>, value: &OsStr) -> Result<T, Error> {
        self.read.parse_ref(command, arg, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        Some(Box::new((self.names)().into_iter().map(PossibleValue::new)))
    }
}

fn isa_names() -> Vec<&'static str> {
    Isa::ALL.iter().map(|isa| isa.name()).collect()
}

/// A SIMD level.
pub fn isa() -> OneOf<Isa> {
    OneOf { names: isa_names, read: |text| text.parse::<Isa>().map_err(|e| e.to_string()) }
}

/// Levels to measure.
#[derive(Clone, Debug)]
pub struct Isas(pub Vec<Isa>);

/// One SIMD level, or all that there are.
pub fn isas() -> OneOf<Isas> {
    OneOf {
        names: || [isa_names(), vec!["all"]].concat(),
        read: |text| match text {
            "all" => Ok(Isas(Isa::available().collect())),
            _ => {
                let isa = text.parse::<Isa>().map_err(|e| format!("{e}, or all"))?;
                Ok(Isas(vec![isa]))
            }
        },
    }
}

/// The name of a format; whether it is one is told together with the output.
pub fn format() -> OneOf<String> {
    OneOf { names: || Format::NAMES.to_vec(), read: |text| Ok(text.to_owned()) }
}

/// The commands, as they are declared.
pub const COMMANDS: [&str; 11] = [
    "render",
    "verify",
    "merge",
    "film",
    "farm",
    "check",
    "profile",
    "new",
    "params",
    "completions",
    "man",
];

/// The name of a command; whether it is one is told with those that are.
pub fn command() -> OneOf<String> {
    OneOf { names: || COMMANDS.to_vec(), read: |text| Ok(text.to_owned()) }
}

/// How much time a smaller file is worth.
pub fn compression() -> OneOf<Compression> {
    OneOf {
        names: || vec!["fast", "balanced", "small"],
        read: |text| match text {
            "fast" => Ok(Compression::Fast),
            "balanced" => Ok(Compression::Balanced),
            "small" => Ok(Compression::Small),
            _ => Err("one of fast, balanced and small".into()),
        },
    }
}

/// How much the tree of boxes is worth.
pub fn quality() -> OneOf<Quality> {
    OneOf { names: || vec!["fast", "balanced", "high"], read: |text| text.parse() }
}

/// Width and height.
pub fn size(text: &str) -> Result<(u32, u32), String> {
    let edge = |text: &str| {
        let digits = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
        text.parse().ok().filter(|n| digits && (1..=65_535).contains(n))
    };
    let edges = text.split_once(['x', 'X']).map(|(w, h)| (edge(w), edge(h)));
    match edges {
        Some((Some(w), Some(h))) => Ok((w, h)),
        _ => Err("width and height are whole numbers from 1 to 65535, as in 1280x720".into()),
    }
}

/// A number of bytes.
pub fn bytes(text: &str) -> Result<u64, String> {
    let number = text.trim_end_matches(['K', 'M', 'G']);
    let unit = match &text[number.len()..] {
        "" => Some(1),
        "K" => Some(1 << 10),
        "M" => Some(1 << 20),
        "G" => Some(1 << 30),
        _ => None,
    };
    let digits = !number.is_empty() && number.bytes().all(|b| b.is_ascii_digit());
    let bytes = || number.parse::<u64>().ok()?.checked_mul(unit?);
    bytes().filter(|_| digits).ok_or_else(|| "a whole number of bytes, as in 512M or 4G".into())
}

/// A whole number, digits only.
fn whole<T: std::str::FromStr>(text: &str) -> Option<T> {
    let digits = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    text.parse().ok().filter(|_| digits)
}

/// A number of things, of which there is at least one.
pub fn count(text: &str) -> Result<NonZeroU32, String> {
    whole(text).ok_or_else(|| format!("a whole number from 1 to {}", u32::MAX))
}

/// A number of operations.
pub fn operations(text: &str) -> Result<NonZeroU64, String> {
    whole(text).ok_or_else(|| format!("a whole number from 1 to {}", u64::MAX))
}

/// The number of a frame.
pub fn frame(text: &str) -> Result<u32, String> {
    whole(text).ok_or_else(|| "the number of a frame, counted from 0".into())
}

/// A number of threads.
pub fn threads(text: &str) -> Result<NonZeroUsize, String> {
    let n = whole(text).filter(|n: &NonZeroUsize| n.get() <= 1024);
    n.ok_or_else(|| "a whole number from 1 to 1024".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!(size("1x1"), Ok((1, 1)));
        assert_eq!(size("65535X65535"), Ok((65_535, 65_535)));
        for bad in [
            "",
            "x",
            "0",
            "0x5",
            "5x0",
            "65536x1",
            "+1x1",
            "1x1x1",
            "1 x1",
            "-1x5",
            "1.5x2",
            "99999999999x1",
        ] {
            assert!(size(bad).is_err(), "{bad:?}");
        }
    }

    #[test]
    fn memory() {
        assert_eq!(bytes("0"), Ok(0));
        assert_eq!(bytes("123"), Ok(123));
        assert_eq!(bytes("3K"), Ok(3 << 10));
        assert_eq!(bytes("512M"), Ok(512 << 20));
        assert_eq!(bytes("4G"), Ok(4 << 30));
        for bad in [
            "",
            "G",
            "-1",
            "+1",
            "1.5G",
            "1KK",
            "1T",
            "1 G",
            "18446744073709551616",
            "17179869184G",
        ] {
            assert!(bytes(bad).is_err(), "{bad:?}");
        }
    }
}
