//! Guards: what would grow without bound in one step, or recurse without bound.

use crate::engine::Printer;
use crate::handle::Handle;
use crate::trouble::{Fallible, Trouble, limit, trouble};
use crate::value;
use crate::vec3::Vec3;
use rhai::{Array, Dynamic, Engine, FnPtr, INT, ImmutableString, Map, NativeCallContext};
use std::fmt::Write;

/// The longest string and array that one call may make.
pub(crate) const LONGEST: usize = 1 << 24;
/// How deep arrays and maps may stand in each other.
pub(crate) const NESTING: usize = 256;

/// What ends a script that runs on and on.
pub(crate) fn too_many_operations(max: u64) -> Dynamic {
    Dynamic::from(Trouble::new(format!(
        "more than {max} operations: a loop without an end? --max-operations allows more"
    )))
}

/// What ends a script that fills the memory.
pub(crate) fn too_much_memory() -> Dynamic {
    Dynamic::from(Trouble::new(
        "the script holds too much memory: a string, array or map that grows without an end?",
    ))
}

fn too_long(what: &str) -> Box<rhai::EvalAltResult> {
    limit(format!("{what} would be longer than {LONGEST}"))
}

fn too_deep() -> Box<rhai::EvalAltResult> {
    limit(format!("arrays and maps stand in each other deeper than {NESTING}"))
}

/// Writes a value as scripts print it.
fn show(value: &Dynamic, out: &mut String, depth: usize) -> Fallible<()> {
    if depth > NESTING {
        return Err(too_deep());
    }
    if out.len() > LONGEST {
        return Err(too_long("the text"));
    }
    if let Ok(array) = value.as_array_ref() {
        out.push('[');
        for (i, item) in array.iter().enumerate() {
            out.push_str(if i > 0 { ", " } else { "" });
            show(item, out, depth + 1)?;
        }
        out.push(']');
    } else if let Ok(map) = value.as_map_ref() {
        out.push_str("#{");
        for (i, (name, item)) in map.iter().enumerate() {
            let _ = write!(out, "{}{name:?}: ", if i > 0 { ", " } else { "" });
            show(item, out, depth + 1)?;
        }
        out.push('}');
    } else if let Some(v) = value.read_lock::<Vec3>() {
        let _ = write!(out, "{}", *v);
    } else if let Some(handle) = value.read_lock::<Handle>() {
        out.push_str(&handle.kind.with_article());
    } else if let Ok(float) = value.as_float() {
        // As Rhai prints floats: a whole one keeps its point.
        let _ = write!(out, "{float:?}");
    } else if let Ok(text) = value.as_immutable_string_ref() {
        if depth == 0 {
            out.push_str(&text);
        } else {
            let _ = write!(out, "{:?}", text.as_str());
        }
    } else if value.is_unit() {
        out.push_str(if depth == 0 { "" } else { "()" });
    } else if let Some(function) = value.read_lock::<FnPtr>() {
        let _ = write!(
            out,
            "{}",
            if function.is_anonymous() { "a function" } else { function.fn_name() }
        );
    } else if let Some(trouble) = value.read_lock::<Trouble>() {
        out.push_str(&trouble.message);
    } else {
        let _ = write!(out, "{value}");
    }
    Ok(())
}

/// A value as text.
pub(crate) fn text(value: &Dynamic) -> Fallible<String> {
    let mut out = String::new();
    show(value, &mut out, 0)?;
    Ok(out)
}

/// Whether two values are equal, as `==` says.
fn equal(a: &Dynamic, b: &Dynamic, depth: usize) -> Fallible<bool> {
    if depth > NESTING {
        return Err(too_deep());
    }
    if let (Ok(a), Ok(b)) = (a.as_array_ref(), b.as_array_ref()) {
        if a.len() != b.len() {
            return Ok(false);
        }
        for (a, b) in a.iter().zip(b.iter()) {
            if !equal(a, b, depth + 1)? {
                return Ok(false);
            }
        }
        return Ok(true);
    }
    if let (Ok(a), Ok(b)) = (a.as_map_ref(), b.as_map_ref()) {
        if a.len() != b.len() {
            return Ok(false);
        }
        for ((name, a), (other, b)) in a.iter().zip(b.iter()) {
            if name != other || !equal(a, b, depth + 1)? {
                return Ok(false);
            }
        }
        return Ok(true);
    }
    if let (Ok(a), Ok(b)) = (a.as_int(), b.as_int()) {
        return Ok(a == b);
    }
    if let (Some(a), Some(b)) = (value::number(a), value::number(b)) {
        return Ok(a == b);
    }
    if let (Some(a), Some(b)) = (a.read_lock::<Handle>(), b.read_lock::<Handle>()) {
        return Ok(*a == *b);
    }
    if let (Some(a), Some(b)) = (value::vector(a), value::vector(b)) {
        return Ok(a == b);
    }
    if let (Ok(a), Ok(b)) = (a.as_immutable_string_ref(), b.as_immutable_string_ref()) {
        return Ok(*a == *b);
    }
    Ok(match (a.as_bool(), b.as_bool(), a.as_char(), b.as_char()) {
        (Ok(a), Ok(b), _, _) => a == b,
        (_, _, Ok(a), Ok(b)) => a == b,
        _ => a.is_unit() && b.is_unit(),
    })
}

fn count(n: INT) -> usize {
    usize::try_from(n).unwrap_or(0)
}

/// The size of `text` with `from` replaced by `to`, checked before it is made.
fn replaced(text: &str, from: &str, to: &str) -> Fallible<ImmutableString> {
    if from.is_empty() {
        return Err(trouble("`replace` takes a string to replace that is not empty"));
    }
    let hits = text.matches(from).count();
    let size = hits
        .checked_mul(to.len())
        .and_then(|added| added.checked_add(text.len() - hits * from.len()));
    if size.is_none_or(|size| size > LONGEST) {
        return Err(too_long("the string"));
    }
    Ok(text.replace(from, to).into())
}

fn padded(text: &mut ImmutableString, len: INT, with: &str) -> Fallible<()> {
    let len = count(len);
    if len > LONGEST {
        return Err(too_long("the string"));
    }
    let have = text.chars().count();
    if have < len && !with.is_empty() {
        let mut longer = text.to_string();
        longer.extend(with.chars().cycle().take(len - have));
        *text = longer.into();
    }
    Ok(())
}

/// Cuts a string into an array, if it is short enough.
fn pieces<'a, I: Iterator<Item = &'a str>>(
    text: &'a str,
    cut: impl Fn(&'a str) -> I,
) -> Fallible<Array> {
    if text.len() > LONGEST / 16 {
        return Err(limit(format!("`split` takes strings of at most {} bytes", LONGEST / 16)));
    }
    Ok(cut(text).map(|piece| ImmutableString::from(piece).into()).collect())
}

/// Registers the guards over what the packages brought, and `print` and `debug`.
pub(crate) fn register(engine: &mut Engine, print: Printer) {
    // The packages have `print` for these types, which would win over one for any value.
    macro_rules! printers {
        ($name:literal: $($type:ty),+) => {$({
            let print = print.clone();
            engine.register_fn(
                $name,
                move |ctx: NativeCallContext, value: $type| -> Fallible<ImmutableString> {
                    let line = ctx.call_position().line().unwrap_or(0);
                    print(&text(&Dynamic::from(value))?, line);
                    Ok("".into())
                },
            );
        })+};
    }
    printers!("print": Dynamic, ImmutableString, INT, f64, bool, char, (), Array, Map, FnPtr);
    printers!("debug": Dynamic, ImmutableString, INT, f64, bool, char, (), Array, Map, FnPtr);
    for name in ["to_string", "to_debug"] {
        engine.register_fn(name, |array: &mut Array| text(&array.clone().into()));
        engine.register_fn(name, |map: &mut Map| text(&map.clone().into()));
    }
    macro_rules! equality {
        ($type:ty) => {
            engine.register_fn("==", |a: $type, b: $type| equal(&a.into(), &b.into(), 0));
            engine
                .register_fn("!=", |a: $type, b: $type| equal(&a.into(), &b.into(), 0).map(|e| !e));
        };
    }
    equality!(Array);
    equality!(Map);
    engine.register_fn("to_json", |_: &mut Map| -> Fallible<ImmutableString> {
        Err(trouble("`to_json` is not part of scene scripts"))
    });
    engine.register_fn("pad", |array: &mut Array, len: INT, with: Dynamic| -> Fallible<()> {
        let len = count(len);
        if len > LONGEST || len.saturating_mul(weight(&with)) > 4 * LONGEST {
            return Err(too_long("the array"));
        }
        if len > array.len() {
            array.resize(len, with);
        }
        Ok(())
    });
    engine.register_fn("pad", |text: &mut ImmutableString, len: INT, with: char| {
        padded(text, len, with.encode_utf8(&mut [0; 4]))
    });
    engine.register_fn("pad", |text: &mut ImmutableString, len: INT, with: ImmutableString| {
        padded(text, len, &with)
    });
    macro_rules! replace {
        ($from:ty, $to:ty) => {
            engine.register_fn(
                "replace",
                |text: &mut ImmutableString, from: $from, to: $to| -> Fallible<()> {
                    *text = replaced(text, &from.to_string(), &to.to_string())?;
                    Ok(())
                },
            );
        };
    }
    replace!(ImmutableString, ImmutableString);
    replace!(ImmutableString, char);
    replace!(char, ImmutableString);
    replace!(char, char);
    engine.register_fn("split", |text: &mut ImmutableString| {
        pieces(text.as_str(), str::split_whitespace)
    });
    engine.register_fn("split", |text: &mut ImmutableString, at: ImmutableString| {
        pieces(text.as_str(), |t| t.split(at.as_str()))
    });
    engine.register_fn("split", |text: &mut ImmutableString, at: char| {
        pieces(text.as_str(), |t| t.split(at))
    });
    engine.register_fn("to_chars", |text: &mut ImmutableString| -> Fallible<Array> {
        if text.len() > LONGEST / 16 {
            return Err(too_long("the array"));
        }
        Ok(text.chars().map(Dynamic::from).collect())
    });
}

/// How many values stand in a value, counted until it is too many.
fn weight(value: &Dynamic) -> usize {
    fn add(value: &Dynamic, sum: &mut usize, depth: usize) {
        *sum += 1;
        if *sum > LONGEST || depth > NESTING {
            *sum = LONGEST + 1;
        } else if let Ok(array) = value.as_array_ref() {
            array.iter().for_each(|item| add(item, sum, depth + 1));
        } else if let Ok(map) = value.as_map_ref() {
            map.values().for_each(|item| add(item, sum, depth + 1));
        } else if let Ok(text) = value.as_immutable_string_ref() {
            // Strings are shared, not copied.
            *sum += usize::from(!text.is_empty());
        }
    }
    let mut sum = 0;
    add(value, &mut sum, 0);
    sum
}
