//! `random(seed)`: streams of numbers that live in the scene.

use crate::state::{Shared, State};
use crate::trouble::{Fallible, trouble};
use crate::value::{describe, need_number};
use reflet_scene::{Key, RandomStream};
use rhai::{Array, Dynamic, Engine};

/// What a script holds of a stream. Copies share the one stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Random {
    key: Key,
    epoch: u64,
}

/// Draws from a stream, and keeps its new state in the scene.
fn draw<T>(
    state: &mut State,
    random: Random,
    from: impl FnOnce(&mut RandomStream) -> T,
) -> Fallible<T> {
    state.alive(random.key, random.epoch, "this random stream")?;
    let mut stream = state
        .scene
        .get::<RandomStream>(random.key)
        .ok_or_else(|| trouble("this random stream is no more"))?;
    let drawn = from(&mut stream);
    state.scene.set(random.key, stream);
    Ok(drawn)
}

/// A float in `a..b`; the rounding of a long range must not reach `b`.
fn in_range(state: &mut State, random: Random, a: f64, b: f64) -> Fallible<f64> {
    if !(a < b && (b - a).is_finite()) {
        return Err(trouble(format!("`range` takes a low and a higher number, got {a} and {b}")));
    }
    let x = a + (b - a) * draw(state, random, RandomStream::float)?;
    Ok(if x < b { x } else { b.next_down() })
}

/// Registers the type and its methods.
pub(crate) fn register(engine: &mut Engine, state: &Shared) {
    engine.register_type_with_name::<Random>("random");
    let shared = state.clone();
    engine.register_fn("random", move |seed: Dynamic| -> Fallible<Random> {
        let whole = seed.as_int().map_err(|_| {
            trouble(format!("`random` takes a whole number as its seed, got {}", describe(&seed)))
        })?;
        let mut state = shared.lock();
        let key = state.scene.spawn((RandomStream::new(whole as u64),));
        let epoch = state.epoch;
        Ok(Random { key, epoch })
    });
    let shared = state.clone();
    engine.register_fn("float", move |r: &mut Random| -> Fallible<f64> {
        draw(&mut shared.lock(), *r, RandomStream::float)
    });
    let shared = state.clone();
    engine.register_fn("range", move |r: &mut Random, a: Dynamic, b: Dynamic| -> Fallible<f64> {
        let (a, b) = (need_number("range", &a)?, need_number("range", &b)?);
        in_range(&mut shared.lock(), *r, a, b)
    });
    let shared = state.clone();
    engine.register_fn("int", move |r: &mut Random, a: Dynamic, b: Dynamic| -> Fallible<i64> {
        let whole = |x: &Dynamic| {
            x.as_int()
                .map_err(|_| trouble(format!("`int` takes two whole numbers, got {}", describe(x))))
        };
        let (a, b) = (whole(&a)?, whole(&b)?);
        if a >= b {
            return Err(trouble(format!(
                "`int` takes a low and a higher whole number, got {a} and {b}"
            )));
        }
        let n = draw(&mut shared.lock(), *r, |s| s.below(b.wrapping_sub(a) as u64))?;
        Ok(a.wrapping_add(n as i64))
    });
    let shared = state.clone();
    engine.register_fn("pick", move |r: &mut Random, array: Array| -> Fallible<Dynamic> {
        if array.is_empty() {
            return Err(trouble("`pick` takes an array with something in it, got an empty one"));
        }
        let at = draw(&mut shared.lock(), *r, |s| s.below(array.len() as u64))?;
        Ok(array.into_iter().nth(at as usize).unwrap_or(Dynamic::UNIT))
    });
    engine.register_fn("==", |a: Random, b: Random| a == b);
    engine.register_fn("!=", |a: Random, b: Random| a != b);
    engine.register_fn("to_string", |_: &mut Random| "a random stream");
    engine.register_fn("to_debug", |_: &mut Random| "a random stream");
}
