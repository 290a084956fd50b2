//! What a file holds and a reader leaves out: counted by kind, with the line of the first.

/// A kind of it, in the words of a warning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Kind {
    one: &'static str,
    many: &'static str,
}

impl Kind {
    /// By what is said of one and of several.
    pub const fn new(one: &'static str, many: &'static str) -> Self {
        Self { one, many }
    }
}

/// Triangles without area.
pub(crate) const WITHOUT_AREA: Kind =
    Kind::new("triangle without area skipped", "triangles without area skipped");
/// Faces that are none.
pub(crate) const FEW_CORNERS: Kind = Kind::new(
    "face of fewer than three corners skipped",
    "faces of fewer than three corners skipped",
);
/// Faces with a corner at no place.
pub(crate) const NOT_FINITE: Kind = Kind::new(
    "face with a corner whose position is not finite skipped",
    "faces with a corner whose position is not finite skipped",
);
/// Polygons that could not be covered.
pub(crate) const CROSSED: Kind = Kind::new(
    "polygon whose edges cross one another is shown in part",
    "polygons whose edges cross one another are shown in part",
);

/// What one file holds and a reader leaves out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct LeftOut {
    kinds: Vec<(Kind, u64, Option<u64>)>,
}

impl LeftOut {
    /// One more of a kind, perhaps in a line.
    pub fn add(&mut self, kind: Kind, line: Option<u64>) {
        self.add_all(kind, 1, line);
    }

    /// So many more of a kind, the first of them perhaps in a line.
    pub fn add_all(&mut self, kind: Kind, count: u64, line: Option<u64>) {
        if count == 0 {
            return;
        }
        match self.kinds.iter_mut().find(|(known, ..)| *known == kind) {
            Some((_, n, _)) => *n += count,
            None => self.kinds.push((kind, count, line)),
        }
    }

    /// All kinds in words, in the order in which they were first seen.
    pub fn told(&self) -> Vec<String> {
        let one = |(kind, n, line): &(Kind, u64, Option<u64>)| {
            let place = match (line, n) {
                (None, _) => String::new(),
                (Some(line), 1) => format!(" (line {line})"),
                (Some(line), _) => format!(" (the first in line {line})"),
            };
            format!("{n} {}{place}", if *n == 1 { kind.one } else { kind.many })
        };
        self.kinds.iter().map(one).collect()
    }
}
