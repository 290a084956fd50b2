//! Guards: what would grow without bound in one step, or recurse without bound.

use crate::engine::Printer;
use crate::handle::Handle;
use crate::meter::Meter;
use crate::trouble::{Fallible, Trouble, limit, trouble};
use crate::value;
use crate::vec3::Vec3;
use rhai::{Array, Dynamic, Engine, FnPtr, INT, ImmutableString, Map, NativeCallContext};
use std::fmt::Write;
use std::sync::Arc;

/// The longest string and array that one call may make.
pub(crate) const LONGEST: usize = 1 << 24;
/// How many bytes are compared, searched or copied in one step of work.
const STEP: usize = 16;
/// Strings up to this length are compared at no price.
const LONG: usize = 512;
/// The bytes of a short string in an array.
const PIECE: usize = 80;
/// How deep arrays and maps may stand in each other.
pub(crate) const NESTING: usize = 256;

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

/// Whether two values are equal, as `==` says; `steps` counts what was compared.
fn equal(a: &Dynamic, b: &Dynamic, depth: usize, steps: &mut usize) -> Fallible<bool> {
    *steps += 1;
    if depth > NESTING {
        return Err(too_deep());
    }
    if let (Ok(a), Ok(b)) = (a.as_array_ref(), b.as_array_ref()) {
        if a.len() != b.len() {
            return Ok(false);
        }
        for (a, b) in a.iter().zip(b.iter()) {
            if !equal(a, b, depth + 1, steps)? {
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
            if name != other || !equal(a, b, depth + 1, steps)? {
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
        *steps += a.len().min(b.len()) / STEP;
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
fn replaced(meter: &Meter, text: &str, from: &str, to: &str) -> Fallible<ImmutableString> {
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
    meter.work(text.len() + size.unwrap_or(0) / STEP)?;
    meter.room(size.unwrap_or(0))?;
    Ok(text.replace(from, to).into())
}

fn padded(meter: &Meter, text: &mut ImmutableString, len: INT, with: &str) -> Fallible<()> {
    let len = count(len);
    if len > LONGEST {
        return Err(too_long("the string"));
    }
    meter.work((len + text.len()) / STEP)?;
    meter.room(len * 4 + text.len())?;
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
    meter: &Meter,
    text: &'a str,
    cut: impl Fn(&'a str) -> I,
) -> Fallible<Array> {
    if text.len() > LONGEST / 16 {
        return Err(limit(format!("`split` takes strings of at most {} bytes", LONGEST / 16)));
    }
    let count = cut(text).count();
    meter.work(text.len() / STEP + count * 8)?;
    meter.room(text.len() + count * PIECE)?;
    Ok(cut(text).map(|piece| ImmutableString::from(piece).into()).collect())
}

/// Registers the guards over what the packages brought, and `print` and `debug`.
pub(crate) fn register(engine: &mut Engine, meter: &Arc<Meter>, print: Printer) {
    // The packages have `print` for these types, which would win over one for any value.
    macro_rules! printers {
        ($name:literal: $($type:ty),+) => {$({
            let (print, meter) = (print.clone(), meter.clone());
            engine.register_fn(
                $name,
                move |ctx: NativeCallContext, value: $type| -> Fallible<ImmutableString> {
                    let line = ctx.call_position().line().unwrap_or(0);
                    let said = text(&Dynamic::from(value))?;
                    meter.work(said.len())?;
                    print(&said, line);
                    Ok("".into())
                },
            );
        })+};
    }
    printers!("print": Dynamic, ImmutableString, INT, f64, bool, char, (), Array, Map, FnPtr);
    printers!("debug": Dynamic, ImmutableString, INT, f64, bool, char, (), Array, Map, FnPtr);
    for name in ["to_string", "to_debug"] {
        let shown = |meter: &Arc<Meter>| {
            let meter = meter.clone();
            move |value: Dynamic| -> Fallible<String> {
                let said = text(&value)?;
                meter.work(said.len())?;
                Ok(said)
            }
        };
        let (of_array, of_map) = (shown(meter), shown(meter));
        engine.register_fn(name, move |array: &mut Array| of_array(array.clone().into()));
        engine.register_fn(name, move |map: &mut Map| of_map(map.clone().into()));
    }
    macro_rules! equality {
        ($type:ty) => {
            let same = compared(meter);
            engine.register_fn("==", move |a: $type, b: $type| same(a.into(), b.into()));
            let same = compared(meter);
            engine.register_fn("!=", move |a: $type, b: $type| {
                same(a.into(), b.into()).map(|equal| !equal)
            });
        };
    }
    fn compared(meter: &Arc<Meter>) -> impl Fn(Dynamic, Dynamic) -> Fallible<bool> + 'static {
        let meter = meter.clone();
        move |a, b| {
            let mut steps = 0;
            let equal = equal(&a, &b, 0, &mut steps)?;
            meter.work(steps)?;
            Ok(equal)
        }
    }
    macro_rules! order {
        ($($name:literal $holds:expr),+) => {$({
            let meter = meter.clone();
            engine.register_fn($name, move |a: ImmutableString, b: ImmutableString| {
                let bytes = a.len().min(b.len());
                if bytes > LONG {
                    meter.work(bytes / STEP)?;
                }
                let holds: fn(&str, &str) -> bool = $holds;
                Ok::<_, Box<rhai::EvalAltResult>>(holds(&a, &b))
            });
        })+};
    }
    order!(
        "==" | a,
        b | a == b,
        "!=" | a,
        b | a != b,
        "<" | a,
        b | a < b,
        "<=" | a,
        b | a <= b,
        ">" | a,
        b | a > b,
        ">=" | a,
        b | a >= b
    );
    equality!(Array);
    equality!(Map);
    engine.register_fn("to_json", |_: &mut Map| -> Fallible<ImmutableString> {
        Err(trouble("`to_json` is not part of scene scripts"))
    });
    let metered = meter.clone();
    engine.register_fn("pad", move |array: &mut Array, len: INT, with: Dynamic| -> Fallible<()> {
        let len = count(len);
        if len > LONGEST {
            return Err(too_long("the array"));
        }
        let added = len.saturating_sub(array.len()).saturating_mul(size(&with));
        metered.room(added)?;
        metered.work(added / STEP)?;
        if len > array.len() {
            array.resize(len, with);
        }
        Ok(())
    });
    let metered = meter.clone();
    engine.register_fn("pad", move |text: &mut ImmutableString, len: INT, with: char| {
        padded(&metered, text, len, with.encode_utf8(&mut [0; 4]))
    });
    let metered = meter.clone();
    engine.register_fn(
        "pad",
        move |text: &mut ImmutableString, len: INT, with: ImmutableString| {
            padded(&metered, text, len, &with)
        },
    );
    macro_rules! replace {
        ($from:ty, $to:ty) => {
            let metered = meter.clone();
            engine.register_fn(
                "replace",
                move |text: &mut ImmutableString, from: $from, to: $to| -> Fallible<()> {
                    *text = replaced(&metered, text, &from.to_string(), &to.to_string())?;
                    Ok(())
                },
            );
        };
    }
    replace!(ImmutableString, ImmutableString);
    replace!(ImmutableString, char);
    replace!(char, ImmutableString);
    replace!(char, char);
    let metered = meter.clone();
    engine.register_fn("split", move |text: &mut ImmutableString| {
        pieces(&metered, text.as_str(), str::split_whitespace)
    });
    let metered = meter.clone();
    engine.register_fn("split", move |text: &mut ImmutableString, at: ImmutableString| {
        pieces(&metered, text.as_str(), |t| t.split(at.as_str()))
    });
    let metered = meter.clone();
    engine.register_fn("split", move |text: &mut ImmutableString, at: char| {
        pieces(&metered, text.as_str(), |t| t.split(at))
    });
    let metered = meter.clone();
    engine.register_fn("to_chars", move |text: &mut ImmutableString| -> Fallible<Array> {
        metered.work(text.len())?;
        metered.room(text.len() * size_of::<Dynamic>())?;
        if text.len() > LONGEST / 16 {
            return Err(too_long("the array"));
        }
        Ok(text.chars().map(Dynamic::from).collect())
    });
}

/// The bytes that a copy of a value takes, counted until they are too many.
fn size(value: &Dynamic) -> usize {
    /// What an array or a map takes beside its values.
    const EMPTY: usize = 64;
    /// The places of a map are taken some at a time, and each has a name.
    const NODE: usize = 512;
    fn add(value: &Dynamic, sum: &mut usize, depth: usize) {
        *sum += size_of::<Dynamic>();
        if *sum > 1 << 40 || depth > NESTING {
            *sum = usize::MAX >> 1;
        } else if let Ok(array) = value.as_array_ref() {
            *sum += EMPTY;
            array.iter().for_each(|item| add(item, sum, depth + 1));
        } else if let Ok(map) = value.as_map_ref() {
            *sum += EMPTY + NODE * map.len().div_ceil(5);
            map.values().for_each(|item| add(item, sum, depth + 1));
        } else if let Ok(bytes) = value.as_blob_ref() {
            *sum += EMPTY + bytes.len();
        } else if value.read_lock::<FnPtr>().is_some()
            || value.read_lock::<Vec3>().is_some()
            || value.read_lock::<Handle>().is_some()
        {
            *sum += 2 * EMPTY;
        }
        // Strings are shared, not copied.
    }
    let mut sum = 0;
    add(value, &mut sum, 0);
    sum
}
