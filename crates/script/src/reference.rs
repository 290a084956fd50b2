//! What the language has, as data: the manual is held against it.

use crate::engine;
use crate::meter::Meter;
use crate::nouns::FORMS;
use crate::params::Parameters;
use crate::state::{Shared, State};
use crate::{maths, time};
use rhai::Engine;
use std::collections::BTreeSet;
use std::sync::Arc;

/// One maker, or one of its forms.
#[derive(Clone, Debug, PartialEq)]
pub struct MakerEntry {
    /// Its name, for example `sphere`.
    pub name: &'static str,
    /// What it makes.
    pub doc: &'static str,
    /// Its keys, which are its handle's properties.
    pub keys: Vec<KeyEntry>,
}

/// One key of a maker.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyEntry {
    /// Its name, for example `radius`.
    pub name: &'static str,
    /// What it takes, in words.
    pub takes: String,
    /// What it is if it is not given; `None`: it must be given.
    pub default: Option<&'static str>,
    /// What it is.
    pub doc: &'static str,
}

/// One helper.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HelperEntry {
    /// Its name.
    pub name: &'static str,
    /// How it is called, for example `lerp(a, b, t)`.
    pub usage: &'static str,
    /// What it gives.
    pub doc: &'static str,
}

/// The language: every maker with its keys, and every helper.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// The makers, in the order of the manual.
    pub makers: Vec<MakerEntry>,
    /// The helpers, in the order of the manual.
    pub helpers: Vec<HelperEntry>,
    /// The functions of numbers, in the order of the manual.
    pub maths: Vec<HelperEntry>,
    /// The functions and methods that come from Rhai itself: of arrays, maps, strings, numbers.
    pub rhai: Vec<String>,
    /// The properties of a frame function's argument, with what they are.
    pub frame: &'static [(&'static str, &'static str)],
}

/// The language as it stands.
pub fn reference() -> Reference {
    let makers = FORMS
        .iter()
        .map(|form| MakerEntry {
            name: form.maker(),
            doc: form.doc(),
            keys: form
                .keys()
                .iter()
                .map(|key| KeyEntry {
                    name: key.name,
                    takes: key.takes.words(),
                    default: key.default,
                    doc: key.doc,
                })
                .collect(),
        })
        .collect();
    Reference {
        makers,
        helpers: HELPERS.to_vec(),
        maths: maths::ENTRIES.to_vec(),
        rhai: from_rhai(&bare_engine()),
        frame: time::PROPERTIES,
    }
}

/// An engine as scripts get it, around an empty scene.
fn bare_engine() -> Engine {
    let assets = reflet_assets::Assets::new(Default::default());
    let meter = Arc::new(Meter::new(1, u64::MAX, None));
    let state = Shared::new(State::new(assets, Parameters::default(), meter.clone()));
    engine::build(&state, &meter, Arc::new(|_, _| {}))
}

/// The names of all functions that an engine has, without operators and properties.
pub(crate) fn registered(engine: &Engine) -> BTreeSet<String> {
    identifiers(engine.collect_fn_metadata(None, |f| Some(f.metadata.name.to_string()), true))
}

fn identifiers(names: Vec<String>) -> BTreeSet<String> {
    let plain = |name: &String| name.starts_with(char::is_alphabetic) && !name.contains('$');
    names.into_iter().filter(plain).collect()
}

fn from_rhai(engine: &Engine) -> Vec<String> {
    let own = function_names();
    let mut names = registered(engine);
    // One name is only registered to say that it is not there.
    names.retain(|name| !own.contains(&name.as_str()) && name != "to_json");
    names.into_iter().collect()
}

const fn helper(name: &'static str, usage: &'static str, doc: &'static str) -> HelperEntry {
    HelperEntry { name, usage, doc }
}

/// The helpers with their usage.
pub(crate) const HELPERS: &[HelperEntry] = &[
    helper("on_frame", "on_frame(|f| { ... })", "calls the function for every frame"),
    helper(
        "param",
        "param(\"name\", default, low, high), param(name, default) or param(name, default, choices)",
        "a number, a bool or colour, or one of an array of strings, that `--set name=value` changes",
    ),
    helper("vec3", "vec3(x, y, z)", "a vector or colour; vec3(v) of an array or one number"),
    helper("length", "length(v)", "the length of a vector"),
    helper("normalize", "normalize(v)", "the vector of length 1"),
    helper("dot", "dot(a, b)", "the scalar product"),
    helper("cross", "cross(a, b)", "the vector product"),
    helper(
        "rotate",
        "rotate(v, axis, degrees)",
        "the vector turned, counter-clockwise seen from the axis' tip",
    ),
    helper("lerp", "lerp(a, b, t)", "a at t = 0, b at t = 1, numbers or vectors"),
    helper("clamp", "clamp(x, low, high)", "x, or the bound that it passes"),
    helper("smoothstep", "smoothstep(e0, e1, x)", "0 below e0, 1 above e1, smooth between"),
    helper("mix", "mix(a, b, t)", "as lerp; in a shader's function also of symbolic values"),
    helper("step", "step(edge, x)", "1 where x >= edge, else 0"),
    helper("mod", "mod(a, b)", "a - b floor(a / b), with the sign of b; a % b has that of a"),
    helper(
        "noise",
        "noise(x, y, z)",
        "gradient noise from -1 to 1, smooth and without a period; in a shader's function only",
    ),
    helper("ease_in", "ease_in(t)", "t^3"),
    helper("ease_out", "ease_out(t)", "1 - (1 - t)^3"),
    helper("ease_in_out", "ease_in_out(t)", "ease_in, then ease_out"),
    helper(
        "keys",
        "keys([[time, value], ...], t) or keys(list, t, easing)",
        "the value at t, linear between the times, held outside",
    ),
    helper("hsv", "hsv(degrees, s, v)", "linear colour of hue, saturation and value"),
    helper("srgb", "srgb(\"#ff8800\")", "linear colour of a web colour"),
    helper("rgb", "rgb(r, g, b)", "linear colour of sRGB numbers from 0 to 255"),
    helper("random", "random(seed)", "a stream of numbers, shared by its copies"),
    helper("float", "r.float()", "the stream's next float in [0, 1)"),
    helper("range", "r.range(a, b)", "the stream's next float in [a, b)"),
    helper("pick", "r.pick(array)", "one of the array's values"),
    helper("int", "int(x) or r.int(a, b)", "x cut to a whole number; of a stream, one in a..b-1"),
    helper("print", "print(x)", "writes to stderr, with the script's line"),
    helper("debug", "debug(x)", "as print"),
];

/// How a maker or a helper is called.
pub(crate) fn usage(name: &str) -> Option<String> {
    if let Some(helper) = HELPERS.iter().chain(maths::ENTRIES).find(|h| h.name == name) {
        return Some(helper.usage.to_owned());
    }
    match name {
        "group" => return Some("group([a, b, ...]) or group([a, b, ...], #{ ... })".to_owned()),
        "instance" => return Some("instance(thing) or instance(thing, #{ ... })".to_owned()),
        _ => {}
    }
    let forms: Vec<String> = FORMS
        .iter()
        .filter(|form| form.maker() == name)
        .map(|form| {
            let keys = form.keys();
            let mut needed: Vec<String> = keys
                .iter()
                .filter(|k| k.default.is_none())
                .map(|k| format!("{}: ...", k.name))
                .collect();
            if needed.len() < keys.len() {
                needed.push("...".into());
            }
            format!("{name}(#{{ {} }})", needed.join(", "))
        })
        .collect();
    (!forms.is_empty()).then(|| forms.join(" or "))
}

/// The names of all makers and helpers.
pub(crate) fn function_names() -> Vec<&'static str> {
    let mut names: Vec<&'static str> = FORMS.iter().map(|f| f.maker()).collect();
    names.extend(HELPERS.iter().map(|h| h.name));
    names.extend(maths::ENTRIES.iter().map(|m| m.name));
    names.sort_unstable();
    names.dedup();
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_registered_is_documented_and_the_other_way_round() {
        let engine = bare_engine();
        let name = |f: rhai::FuncInfo| Some(f.metadata.name.to_string());
        let own = identifiers(engine.collect_fn_metadata(None, name, false));
        let all = registered(&engine);
        let documented: BTreeSet<String> =
            function_names().into_iter().map(str::to_owned).collect();
        let missing: Vec<_> = documented.difference(&all).collect();
        assert!(missing.is_empty(), "documented, but not registered: {missing:?}");
        // Guards stand before functions of the same names in Rhai's packages.
        let guards =
            ["pad", "replace", "split", "to_chars", "to_debug", "to_int", "to_json", "to_string"];
        // The materials of a mesh are listed as Rhai's maps are.
        let as_of_maps = ["len", "values"];
        let known =
            |name: &&String| guards.contains(&name.as_str()) || as_of_maps.contains(&name.as_str());
        let unknown: Vec<_> = own.difference(&documented).filter(|name| !known(name)).collect();
        assert!(unknown.is_empty(), "registered, but not documented: {unknown:?}");
        let out = ["eval", "sleep", "exit", "timestamp", "parse_json", "blob", "curry"];
        assert!(out.iter().all(|name| !all.contains(*name)), "{all:?}");
    }
}
