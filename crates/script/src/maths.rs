//! Deterministic mathematics: `libm` instead of the platform's C library, and whole numbers
//! wherever floats do.

use crate::angles;
use crate::operators::divide;
use crate::reference::HelperEntry;
use crate::state::Shared;
use crate::trouble::{Fallible, trouble};
use crate::value::describe;
use rhai::{Dynamic, Engine, INT};

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

const fn entry(name: &'static str, usage: &'static str, doc: &'static str) -> HelperEntry {
    HelperEntry { name, usage, doc }
}

/// All functions here, in the order of the manual.
pub(crate) const ENTRIES: &[HelperEntry] = &[
    entry("sin", "sin(x)", "the sine of x in radians; of degrees sin(to_radians(30))"),
    entry("cos", "cos(x)", "the cosine of x in radians; of degrees cos(to_radians(60))"),
    entry("tan", "tan(x)", "the tangent of x in radians"),
    entry("asin", "asin(x)", "the angle in radians whose sine is x"),
    entry("acos", "acos(x)", "the angle in radians whose cosine is x"),
    entry("atan", "atan(x) or atan(y, x)", "the angle in radians whose tangent is x, or y / x"),
    entry("atan2", "atan2(y, x)", "the angle in radians of the point (x, y)"),
    entry("to_radians", "to_radians(degrees)", "degrees as radians"),
    entry("to_degrees", "to_degrees(radians)", "radians as degrees"),
    entry("sinh", "sinh(x)", "the hyperbolic sine"),
    entry("cosh", "cosh(x)", "the hyperbolic cosine"),
    entry("tanh", "tanh(x)", "the hyperbolic tangent"),
    entry("asinh", "asinh(x)", "the inverse of sinh"),
    entry("acosh", "acosh(x)", "the inverse of cosh"),
    entry("atanh", "atanh(x)", "the inverse of tanh"),
    entry("sqrt", "sqrt(x)", "the square root"),
    entry("cbrt", "cbrt(x)", "the cube root"),
    entry("hypot", "hypot(x, y)", "sqrt(x * x + y * y)"),
    entry("pow", "pow(x, y)", "x to the power y, a float; x ** y of whole numbers is whole"),
    entry("exp", "exp(x)", "E() to the power x"),
    entry("ln", "ln(x)", "the natural logarithm"),
    entry("log", "log(x) or log(x, base)", "the logarithm to the base 10, or another"),
    entry("log10", "log10(x)", "the logarithm to the base 10"),
    entry("log2", "log2(x)", "the logarithm to the base 2"),
    entry("abs", "abs(x)", "x without its sign"),
    entry("sign", "sign(x)", "-1, 0 or 1"),
    entry("min", "min(a, b)", "the lesser"),
    entry("max", "max(a, b)", "the greater"),
    entry("floor", "floor(x)", "the greatest whole number that is not above x, as a float"),
    entry("ceiling", "ceiling(x)", "the least whole number that is not below x, as a float"),
    entry("round", "round(x)", "the nearest whole number, as a float"),
    entry("fraction", "fraction(x)", "what follows the point"),
    entry("div", "div(a, b)", "division of whole numbers, towards zero"),
    entry("int", "int(x)", "x cut to a whole number; of a random stream r.int(a, b) in a..b-1"),
];

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
pub(crate) fn register(engine: &mut Engine, state: &Shared) {
    for &(name, f) in UNARY {
        if angles::TAKE_RADIANS.contains(&name) {
            angles::register(engine, state, name, f);
            continue;
        }
        engine.register_fn(name, f);
        engine.register_fn(name, move |x: INT| f(x as f64));
    }
    for &(name, f) in BINARY {
        engine.register_fn(name, f);
        engine.register_fn(name, move |x: INT, y: f64| f(x as f64, y));
        engine.register_fn(name, move |x: f64, y: INT| f(x, y as f64));
        engine.register_fn(name, move |x: INT, y: INT| f(x as f64, y as f64));
    }
    engine.register_fn("div", divide);
    engine.register_fn("int", whole);
    engine.register_fn("int", |x: INT| x);
    engine.register_fn("int", |x: Dynamic| -> Fallible<INT> {
        let of_text = if x.is_string() { "; of a string write parse_int(text)" } else { "" };
        Err(trouble(format!("`int` takes a number, got {}{of_text}", describe(&x))))
    });
    engine.register_get("int", |x: &mut f64| whole(*x));
    engine.register_fn("to_int", whole);
}
