//! From a script's map to the values of a form.

use crate::handle::Handle;
use crate::names;
use crate::nouns::{FORMS, MATERIAL};
use crate::state::State;
use crate::symbolic::{self, Recorded};
use crate::table::{AnyForm, KeyInfo, Kind, Role, Takes, Value};
use crate::trouble::{Blame, Trouble};
use crate::value::{colour, describe, number, vector};
use crate::wardrobe;
use glam::DVec3;
use reflet_scene::{Key, Tiles};
use rhai::{Dynamic, Map, Position};
use std::sync::Arc;

/// The form of a maker that a map is meant for: the one that knows most of its keys.
pub(crate) fn choose(maker: &'static str, map: &Map) -> Result<&'static dyn AnyForm, Trouble> {
    let known = |form: &&dyn AnyForm| map.keys().filter(|k| form.find(k).is_some()).count();
    let mut best: Option<&'static dyn AnyForm> = None;
    for form in FORMS.iter().filter(|f| f.maker() == maker) {
        if best.is_none_or(|b| known(form) > known(&b)) {
            best = Some(*form);
        }
    }
    best.ok_or_else(|| Trouble::new(format!("there is no maker `{maker}`")))
}

/// All values of a form that a map gives, each fit for its key.
pub(crate) fn values(
    state: &mut State,
    form: &'static dyn AnyForm,
    map: &Map,
    call: Position,
) -> Result<Vec<(usize, Value)>, Trouble> {
    let mut values = Vec::with_capacity(map.len());
    for (name, given) in map {
        let Some((at, info)) = form.find(name) else {
            return Err(unknown_key(form, name, map));
        };
        values.push((at, value(state, Kind(form), info, given, call)?));
    }
    let solid = |value: &(usize, Value)| matches!(value.1, Value::Tiles(Tiles::Solid(_)));
    if map.contains_key("xdir") && values.iter().any(solid) {
        return Err(Trouble::with_key(
            "xdir",
            "`xdir` does not go with a `size` of three numbers: blocks lie along the scene's axes",
        ));
    }
    if let Some(missing) =
        form.keys().iter().find(|info| info.default.is_none() && !map.contains_key(info.name))
    {
        return Err(Trouble::new(format!(
            "`{}` needs the key `{}`, {}",
            form.maker(),
            missing.name,
            missing.takes.words()
        )));
    }
    Ok(values)
}

fn unknown_key(form: &'static dyn AnyForm, name: &str, map: &Map) -> Trouble {
    let keys = form.keys();
    let known: Vec<&str> = keys.iter().map(|k| k.name).collect();
    let other = FORMS.iter().find(|f| {
        f.maker() == form.maker() && !std::ptr::addr_eq(**f, form) && f.find(name).is_some()
    });
    let unknown = Some(name.to_owned());
    let Some(other) = other else {
        let moved = ["rotate", "scale", "translate", "rotation", "translation", "transform"];
        let hint = match form.role() {
            Role::Surface if moved.contains(&name) => {
                format!("; to move it, write group([...], #{{ {name}: ... }})")
            }
            _ => String::new(),
        };
        let message = format!(
            "`{}` has no key `{name}`{}{hint}",
            form.maker(),
            names::offer(name, "takes", &known)
        );
        return Trouble { unknown, ..Trouble::new(message) };
    };
    // There is one, or the other form would know more of the keys.
    let clashes = |key: &&str| form.find(key).is_some() && other.find(key).is_none();
    let rival = map.keys().map(|key| key.as_str()).find(clashes).unwrap_or_default();
    let theirs: Vec<&str> = other.keys().iter().map(|k| k.name).collect();
    let message = |wrong: &str, right: &str, of_right: &[&str], of_wrong: &[&str]| {
        format!(
            "`{wrong}` does not go with `{right}`: a {} takes {}, or {}",
            form.maker(),
            names::listed(of_right),
            names::listed(of_wrong)
        )
    };
    Trouble {
        unknown,
        rival: Some(Box::new((rival.to_owned(), message(rival, name, &theirs, &known)))),
        ..Trouble::new(message(name, rival, &known, &theirs))
    }
}

/// One value, fit for its key.
pub(crate) fn value(
    state: &mut State,
    kind: Kind,
    info: &'static KeyInfo,
    given: &Dynamic,
    call: Position,
) -> Result<Value, Trouble> {
    if let Takes::Wear | Takes::Paint = info.takes {
        return paint(state, kind, info, given, call);
    }
    if let Takes::Wardrobe = info.takes {
        return wardrobe::given(state, kind, given, call)
            .unwrap_or_else(|| Err(refused(info, given)));
    }
    if let Takes::File = info.takes
        && let Ok(file) = given.as_immutable_string_ref()
    {
        let meter = state.meter.clone();
        let data = meter.file(|| state.assets.mesh(&file)).map_err(|error| Trouble {
            blame: Blame::File,
            ..Trouble::with_key(info.name, error.to_string())
        })?;
        state.note_file(Arc::as_ptr(&data) as usize, &file);
        return Ok(Value::Mesh(data));
    }
    if let Takes::Image = info.takes
        && let Ok(file) = given.as_immutable_string_ref()
    {
        let meter = state.meter.clone();
        let image = meter.file(|| state.assets.texture(&file)).map_err(|error| Trouble {
            blame: Blame::File,
            ..Trouble::with_key(info.name, error.to_string())
        })?;
        state.note_file(Arc::as_ptr(&image) as usize, &file);
        return Ok(Value::Image(image));
    }
    plain(info.takes, given).ok_or_else(|| refused(info, given))
}

fn refused(info: &'static KeyInfo, given: &Dynamic) -> Trouble {
    let finite = components(given).all(|x| (x as f32).is_finite());
    let lost = components(given).any(|x| x != 0.0 && x as f32 == 0.0);
    let why = match (finite, lost) {
        (false, _) => ", which is not finite in f32",
        (true, true) => ", which rounds to 0 in f32",
        (true, false) => "",
    };
    Trouble::with_key(
        info.name,
        format!("`{}` takes {}, got {}{why}", info.name, info.takes.words(), describe(given)),
    )
}

/// The numbers in a value.
fn components(given: &Dynamic) -> impl Iterator<Item = f64> {
    let vector = colour(given).map(|v| v.to_array().to_vec());
    let array = || given.as_array_ref().ok().map(|a| a.iter().filter_map(number).collect());
    vector.or_else(array).unwrap_or_default().into_iter()
}

/// The value, if it is one that `takes` allows, also after rounding to `f32`.
fn plain(takes: Takes, given: &Dynamic) -> Option<Value> {
    let finite = |x: f64| (x as f32).is_finite();
    let positive = |x: f64| finite(x) && (x as f32) > 0.0;
    let all_finite = |v: &DVec3| v.to_array().into_iter().all(finite);
    match takes {
        Takes::Point | Takes::Angles => vector(given).filter(all_finite).map(Value::Vector),
        Takes::Direction => vector(given)
            .filter(|v| all_finite(v) && (v.length() as f32).is_normal())
            .map(Value::Vector),
        Takes::Colour => colour(given).filter(all_finite).map(Value::Vector),
        Takes::Factor => number(given).filter(|x| (*x as f32).is_normal()).map(Value::Number),
        Takes::Positive => number(given).filter(|x| positive(*x)).map(Value::Number),
        Takes::NotNegative => number(given).filter(|x| finite(*x) && *x >= 0.0).map(Value::Number),
        Takes::Degrees(below) => {
            number(given).filter(|x| positive(*x) && *x < below).map(Value::Number)
        }
        Takes::Whole(low, high) => {
            // 640.0 is a whole number too; 640.5 is not.
            let whole = match given.as_int() {
                Ok(i) => i,
                Err(_) => given.as_float().ok().filter(|x| x.fract() == 0.0)? as i64,
            };
            u32::try_from(whole).ok().filter(|n| (low..=high).contains(n)).map(Value::Whole)
        }
        Takes::Sizes => {
            let array = given.as_array_ref().ok()?;
            let [x, y] = array.as_slice() else { return None };
            let (x, y) = (number(x)?, number(y)?);
            (positive(x) && positive(y)).then_some(Value::Pair([x, y]))
        }
        Takes::TileSizes => {
            let array = given.as_array_ref().ok()?;
            let sizes: Option<Vec<f64>> = array.iter().map(number).collect();
            let sizes = sizes.filter(|s| s.iter().all(|x| positive(*x)))?;
            match sizes[..] {
                [x, y] => Some(Value::Tiles(Tiles::Flat([x, y]))),
                [x, y, z] => Some(Value::Tiles(Tiles::Solid([x, y, z]))),
                _ => None,
            }
        }
        Takes::Lengths => {
            vector(given).filter(|v| v.to_array().into_iter().all(positive)).map(Value::Vector)
        }
        Takes::Scale => colour(given)
            .filter(|v| v.to_array().into_iter().all(|x| (x as f32).is_normal()))
            .map(Value::Vector),
        Takes::Word(words) => {
            let text = given.as_immutable_string_ref().ok()?;
            words.iter().position(|w| *w == text.as_str()).map(Value::Word)
        }
        Takes::Flag => given.as_bool().ok().map(Value::Flag),
        Takes::Expression => {
            let recorded = given.read_lock::<Recorded>().map(|r| r.clone());
            let recorded = recorded.or_else(|| symbolic::constant(given));
            recorded.map(|Recorded(program)| Value::Expression(Some(program)))
        }
        Takes::Wear | Takes::Paint | Takes::Wardrobe | Takes::File | Takes::Image => None,
    }
}

/// A material or a pattern, by its handle, or a new material from a map.
fn paint(
    state: &mut State,
    kind: Kind,
    info: &'static KeyInfo,
    given: &Dynamic,
    call: Position,
) -> Result<Value, Trouble> {
    if let Some(handle) = given.read_lock::<Handle>().map(|h| *h) {
        state.alive(handle.key, handle.epoch, &handle.kind.with_article()).map_err(gone)?;
        return match (handle.kind.0.role(), info.takes) {
            (Role::Material, _) => Ok(Value::Wear(Some(handle.key))),
            (Role::Pattern, Takes::Wear) => match state.suits(handle.key, kind) {
                Ok(()) => Ok(Value::Wear(Some(handle.key))),
                Err(why) => Err(Trouble::with_key(info.name, why)),
            },
            _ => Err(refused(info, given)),
        };
    }
    if let Ok(map) = given.as_map_ref() {
        let key: Key =
            state.make_form(&MATERIAL, &map, call).map_err(|trouble| trouble.inside(info.name))?;
        return Ok(Value::Wear(Some(key)));
    }
    Err(refused(info, given))
}

/// A material to be worn in the place of one of a mesh's file.
pub(crate) fn one_worn(
    state: &mut State,
    kind: Kind,
    given: &Dynamic,
    call: Position,
) -> Result<Key, Trouble> {
    static INFO: KeyInfo =
        KeyInfo { name: "materials", takes: Takes::Paint, default: None, doc: "" };
    match paint(state, kind, &INFO, given, call)? {
        Value::Wear(Some(material)) => Ok(material),
        _ => Err(refused(&INFO, given)),
    }
}

/// The trouble inside a Rhai error that we made ourselves.
#[allow(clippy::boxed_local)] // That is how Rhai's errors come.
fn gone(error: Box<rhai::EvalAltResult>) -> Trouble {
    match *error {
        rhai::EvalAltResult::ErrorRuntime(value, _) => value
            .try_cast::<Trouble>()
            .unwrap_or_else(|| Trouble::new("this handle is of an earlier frame")),
        other => Trouble::new(other.to_string()),
    }
}
