//! Functions of angles in radians, and calls of them that look like degrees.

use crate::maths::Unary;
use crate::state::Shared;
use rhai::{Engine, INT, NativeCallContext, Position};
use std::collections::BTreeMap;

/// The functions that take an angle in radians.
pub(crate) const TAKE_RADIANS: &[&str] = &["sin", "cos", "tan"];

/// What the calls in one place were given.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Seen {
    /// Whole numbers only, each 0 or beyond a full turn: the first of the latter.
    Degrees(f64),
    /// Whole numbers only, all of them 0.
    Zero,
    /// Something that no one would write in degrees.
    Radians,
}

/// The places in which angles were given: the function, and what it got there.
#[derive(Debug, Default)]
pub(crate) struct Angles(BTreeMap<Position, (&'static str, Seen)>);

impl Angles {
    fn note(&mut self, name: &'static str, x: f64, at: Position) {
        let (_, seen) = self.0.entry(at).or_insert((name, Seen::Zero));
        *seen = match *seen {
            Seen::Radians => Seen::Radians,
            before if x == 0.0 => before,
            _ if x.fract() != 0.0 || x.abs() <= std::f64::consts::TAU => Seen::Radians,
            Seen::Zero => Seen::Degrees(x),
            before @ Seen::Degrees(_) => before,
        };
    }

    /// What to warn of, in the order of the script.
    pub fn warnings(&self) -> impl Iterator<Item = String> {
        self.0.iter().filter_map(|(at, (name, seen))| {
            let Seen::Degrees(x) = seen else { return None };
            let line = at.line().unwrap_or(0);
            Some(format!(
                "line {line}: `{name}` takes radians, and {x} looks like degrees: write {name}(to_radians({x}))"
            ))
        })
    }
}

/// Registers one of the functions, which notes what it is given.
pub(crate) fn register(engine: &mut Engine, state: &Shared, name: &'static str, f: Unary) {
    let shared = state.clone();
    engine.register_fn(name, move |ctx: NativeCallContext, x: f64| {
        shared.lock().angles.note(name, x, ctx.call_position());
        f(x)
    });
    let shared = state.clone();
    engine.register_fn(name, move |ctx: NativeCallContext, x: INT| {
        let x = x as f64;
        shared.lock().angles.note(name, x, ctx.call_position());
        f(x)
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_places_that_see_nothing_but_whole_numbers_beyond_a_turn_are_warned_of() {
        let warned = |values: &[f64]| {
            let mut angles = Angles::default();
            values.iter().for_each(|x| angles.note("sin", *x, Position::new(3, 1)));
            angles.warnings().next()
        };
        assert_eq!(
            warned(&[0.0, 90.0, 180.0]).as_deref(),
            Some(
                "line 3: `sin` takes radians, and 90 looks like degrees: write sin(to_radians(90))"
            )
        );
        assert!(warned(&[-45.0]).is_some());
        assert_eq!(warned(&[0.0]), None);
        assert_eq!(warned(&[6.0, 7.0]), None, "counts from small numbers");
        assert_eq!(warned(&[90.0, 90.5]), None);
        assert_eq!(warned(&[f64::NAN, 90.0]), None);
    }
}
