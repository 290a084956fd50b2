//! What looks wrong: warnings by kind, with an end to each list.

use std::collections::HashSet;

/// The kinds of warning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Kind {
    /// Two surfaces in one place.
    Coincident,
    /// A light on a surface.
    LightOnSurface,
    /// The camera inside a solid, or on a surface.
    Camera,
    /// A light in a surface that nothing of it leaves.
    Enclosed,
    /// A colour that seems to be meant in 0..255.
    Colour,
    /// A light or a material that is 0.
    Dark,
    /// Nothing to be seen.
    View,
    /// Frames that are one picture.
    Frames,
}

const KINDS: [Kind; 8] = [
    Kind::Coincident,
    Kind::LightOnSurface,
    Kind::Camera,
    Kind::Enclosed,
    Kind::Colour,
    Kind::Dark,
    Kind::View,
    Kind::Frames,
];

/// Warnings of a kind that are kept; of the others only the number is.
const KEPT: usize = 1000;

/// Warnings, each once.
#[derive(Default)]
pub struct Findings {
    found: Vec<(Kind, String)>,
    kept: [usize; KINDS.len()],
    more: [u64; KINDS.len()],
    seen: HashSet<String>,
    /// Put behind every text that is new from now on, for example ` (in frame 47)`.
    pub suffix: String,
}

impl Findings {
    /// Adds a warning, unless it is there already.
    pub fn add(&mut self, kind: Kind, text: impl FnOnce() -> String) {
        if self.kept[kind as usize] >= KEPT {
            self.more[kind as usize] += 1;
            return;
        }
        let text = text();
        if !self.seen.contains(&text) {
            self.kept[kind as usize] += 1;
            self.found.push((kind, format!("{text}{}", self.suffix)));
            self.seen.insert(text);
        }
    }

    /// All warnings, in the order in which they were found.
    #[cfg(test)]
    pub fn texts(&self) -> Vec<String> {
        self.found.iter().map(|(_, text)| text.clone()).collect()
    }

    /// How many there are.
    pub fn len(&self) -> u64 {
        self.found.len() as u64 + self.more.iter().sum::<u64>()
    }

    /// The lines to print: at most `most` of a kind, and how many more there are.
    pub fn lines(&self, most: usize) -> Vec<String> {
        let mut lines = Vec::new();
        for kind in KINDS {
            let of_kind = || self.found.iter().filter(|(k, _)| *k == kind);
            lines.extend(of_kind().take(most).map(|(_, text)| text.clone()));
            let kept = of_kind().count().saturating_sub(most) as u64;
            let more = kept + self.more[kind as usize];
            if more > 0 {
                let what = match kind {
                    Kind::Coincident => "coincident surfaces",
                    Kind::LightOnSurface => "lights on surfaces",
                    Kind::Camera => "surfaces around the camera",
                    Kind::Enclosed => "enclosed lights",
                    Kind::Colour => "colours beyond 1",
                    Kind::Dark => "lights and materials of 0",
                    Kind::View | Kind::Frames => "of this kind",
                };
                lines.push(format!("and {more} more {what}"));
            }
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_once_and_lists_have_an_end() {
        let mut findings = Findings::default();
        for i in 0..5 {
            findings.add(Kind::Coincident, || format!("pair {i}"));
        }
        findings.suffix = " (in frame 9)".into();
        findings.add(Kind::Coincident, || "pair 0".into());
        findings.add(Kind::Camera, || "inside".into());
        let lines = ["pair 0", "pair 1", "and 3 more coincident surfaces", "inside (in frame 9)"];
        assert_eq!(findings.lines(2), lines);
        assert_eq!(findings.len(), 6);
    }

    #[test]
    fn a_million_of_a_kind_are_counted() {
        let mut findings = Findings::default();
        for i in 0..1_000_000 {
            findings.add(Kind::Coincident, || format!("pair {i}"));
        }
        assert_eq!(findings.len(), 1_000_000);
        assert_eq!(findings.lines(1), ["pair 0", "and 999999 more coincident surfaces"]);
    }
}
