//! What a script's values are, and what they can serve as.

use crate::handle::Handle;
use crate::trouble::{Fallible, trouble};
use crate::vec3::Vec3;
use glam::DVec3;
use rhai::{Array, Dynamic, FnPtr, NativeCallContext};

/// A value in words, for messages: `the number 3`, `the string "a"`, `an array of 2`, `a sphere`.
pub(crate) fn describe(value: &Dynamic) -> String {
    if value.is_unit() {
        return "nothing, ()".into();
    }
    if let Ok(flag) = value.as_bool() {
        return flag.to_string();
    }
    if let Ok(whole) = value.as_int() {
        return format!("the number {whole}");
    }
    if let Ok(float) = value.as_float() {
        return format!("the number {}", short(float));
    }
    if let Ok(text) = value.as_immutable_string_ref() {
        let short: String = text.chars().take(40).collect();
        let dots = if short.len() < text.len() { "..." } else { "" };
        return format!("the string \"{short}{dots}\"");
    }
    if let Ok(array) = value.as_array_ref() {
        if array.len() == 3
            && let Some(odd) = array.iter().position(|x| number(x).is_none())
        {
            return format!("an array with {} at {odd}", describe_flat(&array[odd]));
        }
        let numbers: Option<Vec<String>> = array.iter().map(|x| number(x).map(short)).collect();
        return match numbers {
            Some(numbers) if (1..=4).contains(&numbers.len()) => {
                format!("[{}]", numbers.join(", "))
            }
            _ => format!("an array of {}", array.len()),
        };
    }
    if let Some(handle) = value.read_lock::<Handle>() {
        return handle.kind.with_article();
    }
    if let Some(v) = value.read_lock::<Vec3>() {
        return v.to_string();
    }
    describe_flat(value)
}

/// A number without a long tail of zeros.
fn short(x: f64) -> String {
    let size = x.abs();
    if size != 0.0 && size.is_finite() && !(1e-4..1e15).contains(&size) {
        format!("{x:e}")
    } else {
        x.to_string()
    }
}

/// A value in words, without looking inside.
pub(crate) fn describe_flat(value: &Dynamic) -> String {
    if value.is_array() {
        "an array".into()
    } else if value.is_map() {
        "a map".into()
    } else if value.is_fnptr() {
        "a function".into()
    } else if value.is_char() {
        "a character".into()
    } else if value.is_string() || value.is_int() || value.is_float() || value.is_bool() {
        describe(value)
    } else if value.is_unit() {
        "nothing, ()".into()
    } else if value.read_lock::<Vec3>().is_some() {
        "a vec3".into()
    } else if let Some(handle) = value.read_lock::<Handle>() {
        handle.kind.with_article()
    } else {
        format!(
            "a {}",
            value.type_name().rsplit("::").next().unwrap_or("value").trim_end_matches('>')
        )
    }
}

/// A whole number or a float as a float.
pub(crate) fn number(value: &Dynamic) -> Option<f64> {
    value.as_float().ok().or_else(|| value.as_int().ok().map(|i| i as f64))
}

/// Three numbers as a vector.
pub(crate) fn array_vector(array: &[Dynamic]) -> Option<DVec3> {
    match array {
        [x, y, z] => Some(DVec3::new(number(x)?, number(y)?, number(z)?)),
        _ => None,
    }
}

/// A `vec3` or an array of three numbers.
pub(crate) fn vector(value: &Dynamic) -> Option<DVec3> {
    if let Some(v) = value.read_lock::<Vec3>() {
        return Some(v.0);
    }
    value.as_array_ref().ok().and_then(|a| array_vector(&a))
}

/// A vector, or one number for all three components.
pub(crate) fn colour(value: &Dynamic) -> Option<DVec3> {
    number(value).map(DVec3::splat).or_else(|| vector(value))
}

/// A number, or an error in the name of `who`.
pub(crate) fn need_number(who: &str, value: &Dynamic) -> Fallible<f64> {
    number(value).ok_or_else(|| trouble(format!("`{who}` takes a number, got {}", describe(value))))
}

/// A vector, or an error in the name of `who`.
pub(crate) fn need_vector(who: &str, value: &Dynamic) -> Fallible<DVec3> {
    vector(value).ok_or_else(|| {
        trouble(format!("`{who}` takes a vector [x, y, z] or vec3, got {}", describe(value)))
    })
}

/// A vector or one number, or an error in the name of `who`.
pub(crate) fn need_colour(who: &str, value: &Dynamic) -> Fallible<DVec3> {
    colour(value).ok_or_else(|| {
        trouble(format!("`{who}` takes three numbers or one, got {}", describe(value)))
    })
}

/// A list, or an error in the name of `who`.
pub(crate) fn need_array(who: &str, value: Dynamic) -> Fallible<Array> {
    let words = describe(&value);
    value.into_array().map_err(|_| trouble(format!("`{who}` takes an array, got {words}")))
}

/// Whether a function of the script takes one value beside those that it captured.
pub(crate) fn takes_one(ctx: &NativeCallContext, function: &FnPtr) -> bool {
    let parameters = function.curry().len() + 1;
    ctx.iter_namespaces()
        .any(|module| module.get_script_fn(function.fn_name(), parameters).is_some())
}
