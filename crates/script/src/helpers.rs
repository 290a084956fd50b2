//! The small functions of animation, vectors and colours.

use crate::maths::Unary;
use crate::symbolic::{self, any_symbolic};
use crate::trouble::{Fallible, trouble};
use crate::value::{colour, describe, need_array, need_number, need_vector, number, vector};
use crate::vec3::Vec3;
use glam::DVec3;
use rhai::{Dynamic, Engine, FnPtr, NativeCallContext};

/// A number or a vector, to mix.
enum Mixed {
    Number(f64),
    Vector(DVec3),
}

fn mixed(who: &str, value: &Dynamic) -> Fallible<Mixed> {
    if let Some(x) = number(value) {
        return Ok(Mixed::Number(x));
    }
    vector(value).map(Mixed::Vector).ok_or_else(|| {
        trouble(format!("`{who}` takes numbers or vectors, got {}", describe(value)))
    })
}

/// `a` at t = 0, `b` at t = 1; both ends are met exactly.
fn lerp(a: &Dynamic, b: &Dynamic, t: f64) -> Fallible<Dynamic> {
    Ok(match (mixed("lerp", a)?, mixed("lerp", b)?) {
        (Mixed::Number(a), Mixed::Number(b)) => (a * (1.0 - t) + b * t).into(),
        _ => {
            let ends = [a, b].map(|end| colour(end).unwrap_or(DVec3::ZERO));
            Dynamic::from(Vec3(ends[0] * (1.0 - t) + ends[1] * t))
        }
    })
}

fn clamp(x: &Dynamic, low: &Dynamic, high: &Dynamic) -> Fallible<Dynamic> {
    if let (Ok(x), Ok(low), Ok(high)) = (x.as_int(), low.as_int(), high.as_int())
        && low <= high
    {
        return Ok(x.clamp(low, high).into());
    }
    let (low, high) = (need_number("clamp", low)?, need_number("clamp", high)?);
    if low > high || low.is_nan() || high.is_nan() {
        return Err(trouble(format!(
            "`clamp` takes a low that is not above its high, got {low} and {high}"
        )));
    }
    Ok(match mixed("clamp", x)? {
        Mixed::Number(x) => x.clamp(low, high).into(),
        Mixed::Vector(v) => {
            Dynamic::from(Vec3(DVec3::from_array(v.to_array().map(|x| x.clamp(low, high)))))
        }
    })
}

fn smoothstep(e0: f64, e1: f64, x: f64) -> Fallible<f64> {
    if e0 == e1 {
        return Err(trouble("`smoothstep` takes two different edges"));
    }
    let t = ((x - e0) / (e1 - e0)).clamp(0.0, 1.0);
    Ok(t * t * (3.0 - 2.0 * t))
}

/// The easing functions, each from 0 at 0 to 1 at 1.
pub(crate) const EASINGS: &[(&str, Unary)] =
    &[("ease_in", ease_in), ("ease_out", ease_out), ("ease_in_out", ease_in_out)];

fn ease_in(t: f64) -> f64 {
    t * t * t
}

fn ease_out(t: f64) -> f64 {
    let s = 1.0 - t;
    1.0 - s * s * s
}

fn ease_in_out(t: f64) -> f64 {
    if t < 0.5 { 0.5 * ease_in(2.0 * t) } else { 0.5 + 0.5 * ease_out(2.0 * t - 1.0) }
}

/// The value at `t` between times that ascend; `ease` bends the way from one to the next.
fn keys(list: Dynamic, t: &Dynamic, ease: impl Fn(f64) -> Fallible<f64>) -> Fallible<Dynamic> {
    let t = need_number("keys", t)?;
    let list = need_array("keys", list)?;
    let mut pairs = Vec::with_capacity(list.len());
    for (i, entry) in list.into_iter().enumerate() {
        let words = describe(&entry);
        let pair = entry.into_array().ok().and_then(|pair| <[Dynamic; 2]>::try_from(pair).ok());
        let Some([time, value]) = pair else {
            return Err(trouble(format!(
                "`keys` takes a list of pairs [time, value], got {words} at {i}"
            )));
        };
        pairs.push((need_number("keys", &time)?, value));
    }
    if pairs.is_empty() {
        return Err(trouble("`keys` takes at least one pair [time, value]"));
    }
    if let Some(i) = (1..pairs.len())
        .find(|&i| pairs[i].0.partial_cmp(&pairs[i - 1].0) != Some(std::cmp::Ordering::Greater))
    {
        return Err(trouble(format!(
            "`keys` takes times that ascend, got {} after {}",
            pairs[i].0,
            pairs[i - 1].0
        )));
    }
    let after = pairs.partition_point(|(time, _)| *time <= t);
    let end = |value: &Dynamic| lerp(value, value, 0.0);
    match (after.checked_sub(1).map(|i| &pairs[i]), pairs.get(after)) {
        (Some((t0, a)), Some((t1, b))) => lerp(a, b, ease((t - t0) / (t1 - t0))?),
        (Some((_, only)), None) | (None, Some((_, only))) => end(only),
        (None, None) => Err(trouble("`keys` takes at least one pair [time, value]")),
    }
}

fn normalize(v: DVec3) -> Fallible<DVec3> {
    let length = v.length();
    if !(length > 0.0 && length.is_finite()) {
        return Err(trouble("`normalize` takes a finite vector other than zero"));
    }
    Ok(v / length)
}

/// Rodrigues' rotation, counter-clockwise seen from the axis' tip.
fn rotate(v: DVec3, axis: DVec3, degrees: f64) -> Fallible<DVec3> {
    let length = axis.length();
    if !(length > 0.0 && length.is_finite()) {
        return Err(trouble("`rotate` takes a finite axis other than zero"));
    }
    let k = axis / length;
    let angle = degrees * (std::f64::consts::PI / 180.0);
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    Ok(v * cos + k.cross(v) * sin + k * (k.dot(v) * (1.0 - cos)))
}

/// IEC 61966-2-1: one encoded component to linear light.
fn decode(c: f64) -> f64 {
    if c <= 0.04045 { c / 12.92 } else { libm::pow((c + 0.055) / 1.055, 2.4) }
}

/// A web colour, `#rrggbb` or `#rgb`, as a linear one.
pub(crate) fn hex(text: &str) -> Option<DVec3> {
    let digits = text.strip_prefix('#')?;
    if !digits.bytes().all(|b| b.is_ascii_hexdigit()) {
        return None;
    }
    let component = |i: usize| -> Option<f64> {
        let n = match digits.len() {
            6 => u8::from_str_radix(digits.get(2 * i..2 * i + 2)?, 16).ok()?,
            3 => 17 * u8::from_str_radix(digits.get(i..=i)?, 16).ok()?,
            _ => return None,
        };
        Some(decode(f64::from(n) / 255.0))
    };
    Some(DVec3::new(component(0)?, component(1)?, component(2)?))
}

fn hsv(h: f64, s: f64, v: f64) -> Fallible<DVec3> {
    let unit = 0.0..=1.0;
    if !h.is_finite() || !unit.contains(&s) || !unit.contains(&v) {
        return Err(trouble(format!(
            "`hsv` takes a hue in degrees, and saturation and value from 0 to 1, got {h}, {s}, {v}"
        )));
    }
    // The form of A. R. Smith's hexcone without cases: each component by its distance in hue.
    let component = |n: f64| {
        let k = (n + h / 60.0).rem_euclid(6.0);
        v - v * s * k.min(4.0 - k).clamp(0.0, 1.0)
    };
    Ok(DVec3::new(component(5.0), component(3.0), component(1.0)))
}

/// Registers everything.
pub(crate) fn register(engine: &mut Engine) {
    engine.register_fn("lerp", |a: Dynamic, b: Dynamic, t: Dynamic| -> Fallible<Dynamic> {
        if any_symbolic(&[&a, &b, &t]) {
            return symbolic::mix(&a, &b, &t);
        }
        lerp(&a, &b, need_number("lerp", &t)?)
    });
    engine.register_fn("clamp", |x: Dynamic, low: Dynamic, high: Dynamic| {
        if any_symbolic(&[&x, &low, &high]) {
            return symbolic::clamp(&x, &low, &high);
        }
        clamp(&x, &low, &high)
    });
    engine.register_fn("smoothstep", |e0: Dynamic, e1: Dynamic, x: Dynamic| -> Fallible<Dynamic> {
        if any_symbolic(&[&e0, &e1, &x]) {
            return symbolic::smoothstep(&e0, &e1, &x);
        }
        let [e0, e1, x] = [e0, e1, x].map(|n| need_number("smoothstep", &n));
        smoothstep(e0?, e1?, x?).map(Dynamic::from)
    });
    for &(name, ease) in EASINGS {
        engine.register_fn(name, move |t: Dynamic| -> Fallible<f64> {
            need_number(name, &t).map(ease)
        });
    }
    engine.register_fn("keys", |list: Dynamic, t: Dynamic| keys(list, &t, Ok));
    engine.register_fn("keys", |ctx: NativeCallContext, list: Dynamic, t: Dynamic, ease: FnPtr| {
        keys(list, &t, |t| {
            let eased = ease.call_raw(&ctx, None, [t.into()])?;
            need_number("keys", &eased)
        })
    });
    engine.register_fn("length", |v: Dynamic| -> Fallible<Dynamic> {
        if any_symbolic(&[&v]) {
            return symbolic::length(&v);
        }
        need_vector("length", &v).map(|v| v.length().into())
    });
    engine.register_fn("normalize", |v: Dynamic| -> Fallible<Vec3> {
        normalize(need_vector("normalize", &v)?).map(Vec3)
    });
    engine.register_fn("dot", |a: Dynamic, b: Dynamic| -> Fallible<Dynamic> {
        if any_symbolic(&[&a, &b]) {
            return symbolic::dot(&a, &b);
        }
        Ok(need_vector("dot", &a)?.dot(need_vector("dot", &b)?).into())
    });
    engine.register_fn("cross", |a: Dynamic, b: Dynamic| -> Fallible<Vec3> {
        Ok(Vec3(need_vector("cross", &a)?.cross(need_vector("cross", &b)?)))
    });
    engine.register_fn("rotate", |v: Dynamic, axis: Dynamic, degrees: Dynamic| -> Fallible<Vec3> {
        let degrees = need_number("rotate", &degrees)?;
        rotate(need_vector("rotate", &v)?, need_vector("rotate", &axis)?, degrees).map(Vec3)
    });
    engine.register_fn("hsv", |h: Dynamic, s: Dynamic, v: Dynamic| -> Fallible<Vec3> {
        let [h, s, v] = [h, s, v].map(|n| need_number("hsv", &n));
        let encoded = hsv(h?, s?, v?)?;
        Ok(Vec3(DVec3::from_array(encoded.to_array().map(decode))))
    });
    engine.register_fn("srgb", |text: &str| -> Fallible<Vec3> {
        hex(text)
            .map(Vec3)
            .ok_or_else(|| trouble(format!("`srgb` takes \"#rrggbb\" or \"#rgb\", got \"{text}\"")))
    });
    engine.register_fn("rgb", |r: Dynamic, g: Dynamic, b: Dynamic| -> Fallible<Vec3> {
        let mut linear = [0.0; 3];
        for (to, given) in linear.iter_mut().zip([r, g, b]) {
            let n = need_number("rgb", &given)?;
            if !(0.0..=255.0).contains(&n) {
                return Err(trouble(format!("`rgb` takes numbers from 0 to 255, got {n}")));
            }
            *to = decode(n / 255.0);
        }
        Ok(Vec3(DVec3::from_array(linear)))
    });
}
