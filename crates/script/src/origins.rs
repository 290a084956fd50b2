//! Where each thing was made, so that it can be named.

use reflet_scene::Key;
use std::collections::HashMap;

/// The line of each entity's maker, and how many were made there before.
#[derive(Default)]
pub(crate) struct Origins {
    made: Vec<(u16, u32)>,
    counts: HashMap<u16, u32>,
}

impl Origins {
    /// `key`, the next one, was made on `line`; on none known if 0.
    pub fn note(&mut self, key: Key, line: usize) {
        let line = line as u16; // as Rhai counts them
        self.made.resize(key.index(), (0, 0));
        let count = self.counts.entry(line).or_default();
        self.made.push((line, *count));
        *count += 1;
    }

    /// Forgets the entities from `key` on.
    pub fn truncate(&mut self, key: Key) {
        while self.made.len() > key.index() {
            if let Some((line, nth)) = self.made.pop() {
                self.counts.insert(line, nth);
            }
        }
    }

    /// Where an entity was made, as in `line 7` or `line 7, no. 3`.
    pub fn place(&self, key: Key) -> Option<String> {
        let (line, nth) = *self.made.get(key.index())?;
        match (line, self.counts.get(&line)) {
            (0, _) => None,
            (_, Some(1)) => Some(format!("line {line}")),
            _ => Some(format!("line {line}, no. {}", nth + 1)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn things_of_a_loop_are_numbered() {
        let mut origins = Origins::default();
        for (key, line) in [(0, 3), (1, 5), (2, 5)] {
            origins.note(Key(key), line);
        }
        let place = |o: &Origins, key| o.place(Key(key));
        assert_eq!(place(&origins, 0).as_deref(), Some("line 3"));
        assert_eq!(place(&origins, 2).as_deref(), Some("line 5, no. 2"));
        assert_eq!(place(&origins, 3), None);
        origins.truncate(Key(2));
        assert_eq!(place(&origins, 1).as_deref(), Some("line 5"));
        origins.note(Key(2), 5);
        assert_eq!(place(&origins, 2).as_deref(), Some("line 5, no. 2"));
    }
}
