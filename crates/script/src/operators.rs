//! Operators: whole numbers divide evenly or not at all, and what would be wrong without a word is
//! an error.
//!
//! Rhai's own operators serve where none is registered, so each that must not pass is registered
//! with its assignment.

use crate::handle::Handle;
use crate::random::Random;
use crate::symbolic::{HitPoint, Symbol, SymbolVector};
use crate::time::Moment;
use crate::trouble::{Fallible, trouble};
use crate::value;
use crate::vec3::Vec3;
use rhai::{Array, Dynamic, Engine, EvalAltResult, FnPtr, INT, ImmutableString, Map, Position};

/// Whole division, towards zero.
pub(crate) fn divide(a: INT, b: INT) -> Fallible<INT> {
    if b == 0 {
        return Err(trouble(format!("division by zero: {a} / {b}")));
    }
    a.checked_div(b).ok_or_else(|| trouble(format!("{a} / {b} is too large for a whole number")))
}

/// A division that comes out even; `advice` says what to write where it does not.
fn even(a: INT, b: INT, advice: impl FnOnce() -> String) -> Fallible<INT> {
    let quotient = divide(a, b)?;
    // i64::MIN % -1 overflows, but `divide` has refused it.
    if a % b != 0 {
        return Err(trouble(format!("{a} / {b} is no whole number: {}", advice())));
    }
    Ok(quotient)
}

fn power(x: INT, y: INT) -> Fallible<INT> {
    let Ok(exponent) = u32::try_from(y) else {
        return Err(trouble(format!("{x} ** {y} is no whole number: write {x}.0 ** {y}")));
    };
    x.checked_pow(exponent).ok_or_else(|| {
        trouble(format!("{x} ** {y} is too large for a whole number: write {x}.0 ** {y}"))
    })
}

/// What to write in place of an operator that scripts do not have.
pub(crate) fn instead(sign: &str) -> Option<&'static str> {
    Some(
        match sign.strip_suffix('=').filter(|s| !["<", ">", "=", "!"].contains(s)).unwrap_or(sign) {
            "^" => "a power is written 2 ** 3",
            "&" => "`and` is written &&",
            "|" => "`or` is written ||",
            "<<" => "write n * 2 ** k",
            ">>" => "write div(n, 2 ** k)",
            "!" => "write n == 0 to ask for zero",
            _ => return None,
        },
    )
}

fn refused(sign: &str) -> Box<EvalAltResult> {
    let instead = instead(sign).map(|words| format!(": {words}")).unwrap_or_default();
    trouble(format!("`{sign}` does not go between whole numbers{instead}"))
}

/// The kind of a value, in words without a comma.
fn kind(value: &Dynamic) -> String {
    if value.is_int() {
        "a whole number".into()
    } else if value.is_float() {
        "a float".into()
    } else if value.is_bool() {
        "true or false".into()
    } else if value.is_string() {
        "a string".into()
    } else {
        value::describe_flat(value)
    }
}

/// A comparison of two kinds of values that are never the same. Nothing, (), is a kind that any
/// value may be compared with.
///
/// The error is that of a missing function, which methods such as `contains` take for `false`.
fn mismatched(sign: &str, a: &Dynamic, b: &Dynamic) -> Fallible<bool> {
    if a.is_unit() || b.is_unit() {
        return Ok(sign == "!=");
    }
    let signature = format!("{sign} ({}, {})", kind(a), kind(b));
    Err(EvalAltResult::ErrorFunctionNotFound(signature, Position::NONE).into())
}

/// The comparisons.
pub(crate) const COMPARISONS: [&str; 6] = ["==", "!=", "<", "<=", ">", ">="];

/// Registers everything.
pub(crate) fn register(engine: &mut Engine) {
    engine.register_fn("/", |a: INT, b: INT| {
        even(a, b, || format!("write {a}.0 / {b}, or div({a}, {b})"))
    });
    engine.register_fn("/=", |a: &mut INT, b: INT| -> Fallible<()> {
        let before = *a;
        *a = even(before, b, || {
            format!("let the variable begin as a float, {before}.0, or write x = div(x, {b})")
        })?;
        Ok(())
    });
    engine.register_fn("**", libm::pow);
    engine.register_fn("**", |x: INT, y: f64| libm::pow(x as f64, y));
    engine.register_fn("**", |x: f64, y: INT| libm::pow(x, y as f64));
    engine.register_fn("**", power);
    engine.register_fn("**=", |x: &mut f64, y: f64| *x = libm::pow(*x, y));
    engine.register_fn("**=", |x: &mut f64, y: INT| *x = libm::pow(*x, y as f64));
    engine.register_fn("**=", |x: &mut INT, y: INT| -> Fallible<()> {
        *x = power(*x, y)?;
        Ok(())
    });
    for sign in ["^", "&", "|", "<<", ">>"] {
        engine.register_fn(sign, move |_: INT, _: INT| -> Fallible<INT> { Err(refused(sign)) });
        let assign = format!("{sign}=");
        let said = assign.clone();
        engine.register_fn(assign, move |_: &mut INT, _: INT| -> Fallible<()> {
            Err(refused(&said))
        });
    }
    for sign in COMPARISONS {
        macro_rules! pair {
            ($a:ty, $b:ty) => {
                engine.register_fn(sign, move |a: $a, b: $b| {
                    mismatched(sign, &Dynamic::from(a), &Dynamic::from(b))
                });
                engine.register_fn(sign, move |a: $b, b: $a| {
                    mismatched(sign, &Dynamic::from(a), &Dynamic::from(b))
                });
            };
        }
        pair!(INT, bool);
        pair!(INT, char);
        pair!(INT, ImmutableString);
        pair!(f64, bool);
        pair!(f64, char);
        pair!(f64, ImmutableString);
        pair!(bool, char);
        pair!(bool, ImmutableString);
        // Pairs of these types that can be compared are registered as such, and found first.
        macro_rules! with_any {
            ($($a:ty),+) => {$(
                engine.register_fn(sign, move |a: $a, b: Dynamic| {
                    mismatched(sign, &Dynamic::from(a), &b)
                });
                engine.register_fn(sign, move |a: Dynamic, b: $a| {
                    mismatched(sign, &a, &Dynamic::from(b))
                });
            )+};
        }
        with_any!(Array, Map, FnPtr, Vec3, Handle, Random, Moment, Symbol, SymbolVector, HitPoint);
    }
}
