//! Deterministic mathematics: `libm` instead of the platform's C library, and whole numbers
//! wherever floats do.

use crate::trouble::{Fallible, trouble};
use rhai::{Engine, INT};

/// A function of one number.
pub(crate) type Unary = fn(f64) -> f64;
/// A function of two numbers.
type Binary = fn(f64, f64) -> f64;

/// The functions of one number.
const UNARY: &[(&str, Unary)] = &[
    ("sin", libm::sin),
    ("cos", libm::cos),
    ("tan", libm::tan),
    ("asin", libm::asin),
    ("acos", libm::acos),
    ("atan", libm::atan),
    ("sinh", libm::sinh),
    ("cosh", libm::cosh),
    ("tanh", libm::tanh),
    ("asinh", libm::asinh),
    ("acosh", libm::acosh),
    ("atanh", libm::atanh),
    ("exp", libm::exp),
    ("ln", libm::log),
    ("log", libm::log10),
    ("log10", libm::log10),
    ("log2", libm::log2),
    ("cbrt", libm::cbrt),
    // IEEE defines these to the last bit.
    ("sqrt", f64::sqrt),
    ("floor", f64::floor),
    ("ceiling", f64::ceil),
    ("round", f64::round),
    ("fraction", f64::fract),
    ("to_radians", |x| x * (std::f64::consts::PI / 180.0)),
    ("to_degrees", |x| x * (180.0 / std::f64::consts::PI)),
];

/// The functions of two numbers.
const BINARY: &[(&str, Binary)] = &[
    ("atan", libm::atan2),
    ("atan2", libm::atan2),
    ("hypot", libm::hypot),
    ("pow", libm::pow),
    ("log", |x, base| libm::log(x) / libm::log(base)),
];

/// The names of all functions here, for the reference.
pub(crate) fn names() -> Vec<&'static str> {
    let mut names: Vec<_> = UNARY.iter().map(|f| f.0).chain(BINARY.iter().map(|f| f.0)).collect();
    names.extend(["**", "/", "div", "int", "abs", "sign", "min", "max"]);
    names.sort_unstable();
    names.dedup();
    names
}

fn divide(a: INT, b: INT) -> Fallible<INT> {
    if b == 0 {
        return Err(trouble(format!("division by zero: {a} / {b}")));
    }
    a.checked_div(b).ok_or_else(|| trouble(format!("{a} / {b} is too large for a whole number")))
}

/// A float cut to a whole number.
fn whole(x: f64) -> Fallible<INT> {
    let cut = x.trunc();
    // The bounds are powers of two, so they are exact as floats.
    if (-9_223_372_036_854_775_808.0..9_223_372_036_854_775_808.0).contains(&cut) {
        Ok(cut as INT)
    } else {
        Err(trouble(format!("`int` takes a number within 64 bits, got {x}")))
    }
}

/// Registers everything.
pub(crate) fn register(engine: &mut Engine) {
    for &(name, f) in UNARY {
        engine.register_fn(name, f);
        engine.register_fn(name, move |x: INT| f(x as f64));
    }
    for &(name, f) in BINARY {
        engine.register_fn(name, f);
        engine.register_fn(name, move |x: INT, y: f64| f(x as f64, y));
        engine.register_fn(name, move |x: f64, y: INT| f(x, y as f64));
        engine.register_fn(name, move |x: INT, y: INT| f(x as f64, y as f64));
    }
    let power = |name: &str, engine: &mut Engine| {
        engine.register_fn(name, libm::pow);
        engine.register_fn(name, |x: INT, y: f64| libm::pow(x as f64, y));
        engine.register_fn(name, |x: f64, y: INT| libm::pow(x, y as f64));
    };
    power("**", engine);
    engine.register_fn("**", |x: INT, y: INT| -> Fallible<INT> {
        u32::try_from(y)
            .map_err(|_| trouble(format!("{x} ** {y} is no whole number: write {x}.0 ** {y}")))
            .and_then(|y| {
                x.checked_pow(y).ok_or_else(|| {
                    trouble(format!(
                        "{x} ** {y} is too large for a whole number: write {x}.0 ** {y}"
                    ))
                })
            })
    });
    engine.register_fn("**=", |x: &mut f64, y: f64| *x = libm::pow(*x, y));
    engine.register_fn("**=", |x: &mut f64, y: INT| *x = libm::pow(*x, y as f64));
    engine.register_fn("/", |a: INT, b: INT| -> Fallible<INT> {
        let quotient = divide(a, b)?;
        if a % b != 0 {
            return Err(trouble(format!(
                "{a} / {b} is no whole number: write {a}.0 / {b}, or div({a}, {b})"
            )));
        }
        Ok(quotient)
    });
    engine.register_fn("div", divide);
    engine.register_fn("int", whole);
    engine.register_fn("int", |x: INT| x);
    engine.register_get("int", |x: &mut f64| whole(*x));
    engine.register_fn("to_int", whole);
}
