//! `param`: what the command line or a slider may set.

use crate::helpers::hex;
use crate::messages;
use crate::names;
use crate::state::Shared;
use crate::trouble::{Blame, Fallible, Trouble, trouble};
use crate::value::{describe, number, vector};
use crate::vec3::Vec3;
use glam::DVec3;
use rhai::{Dynamic, Engine, NativeCallContext, Position};

/// One parameter of a script.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name, as `--set` takes it.
    pub name: String,
    /// What it may be set to.
    pub domain: Domain,
    /// Its value if nobody sets it.
    pub default: Setting,
    /// The value of this run.
    pub value: Setting,
    /// The line of its `param` call, counted from 1.
    pub line: usize,
}

/// What a parameter may be set to.
#[derive(Clone, Debug, PartialEq)]
pub enum Domain {
    /// Whole numbers from the lowest to the highest.
    Whole(f64, f64),
    /// Numbers from the lowest to the highest.
    Float(f64, f64),
    /// `true` or `false`.
    Bool,
    /// A colour.
    Colour,
    /// One of these texts.
    Choice(Vec<String>),
}

/// The value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Setting {
    /// A number.
    Number(f64),
    /// A truth value.
    Bool(bool),
    /// A linear colour: red, green and blue.
    Colour([f64; 3]),
    /// One of the choices.
    Choice(String),
}

impl Domain {
    /// The value that a text on the command line stands for, if it is one of this domain.
    fn read(&self, text: &str) -> Option<Setting> {
        let text = text.trim();
        match self {
            Domain::Whole(low, high) => {
                // Above 2^53 a float is no longer every whole number; no range reaches so far.
                let value = text.parse::<i64>().ok()? as f64;
                (*low..=*high).contains(&value).then_some(Setting::Number(value))
            }
            Domain::Float(low, high) => {
                let value = text.parse::<f64>().ok()?;
                (*low..=*high).contains(&value).then_some(Setting::Number(value))
            }
            Domain::Bool => text.parse().ok().map(Setting::Bool),
            Domain::Colour => match text.strip_prefix('#') {
                Some(_) => hex(text).map(|c| Setting::Colour(c.to_array())),
                None => {
                    let parts: Option<Vec<f64>> =
                        text.split(',').map(|x| x.trim().parse().ok()).collect();
                    linear(parts?.try_into().ok()?)
                }
            },
            Domain::Choice(choices) => {
                choices.iter().find(|c| *c == text).cloned().map(Setting::Choice)
            }
        }
    }

    /// What it takes in words, and after `wrong` what may have been meant.
    fn takes(&self, wrong: &str) -> String {
        match self {
            Domain::Whole(low, high) => format!("a whole number from {low} to {high}"),
            Domain::Float(low, high) => format!("a number from {low} to {high}"),
            Domain::Bool => {
                let near = names::did_you_mean(wrong, ["true", "false"].into_iter());
                format!("true or false{near}")
            }
            Domain::Colour => {
                "a colour: #rrggbb, #rgb, or three linear numbers of at least 0, as in 0.2,0.4,0.9"
                    .into()
            }
            Domain::Choice(choices) => {
                let near = names::did_you_mean(wrong, choices.iter().map(String::as_str));
                format!("one of {}{near}", quoted(choices))
            }
        }
    }
}

impl Setting {
    /// As scripts see it.
    fn given(&self, domain: &Domain) -> Dynamic {
        match self {
            Setting::Number(x) if matches!(domain, Domain::Whole(..)) => (*x as i64).into(),
            Setting::Number(x) => (*x).into(),
            Setting::Bool(flag) => (*flag).into(),
            Setting::Colour(c) => Dynamic::from(Vec3(DVec3::from_array(*c))),
            Setting::Choice(text) => text.clone().into(),
        }
    }
}

/// A colour of finite numbers of at least 0.
fn linear(colour: [f64; 3]) -> Option<Setting> {
    colour.iter().all(|x| x.is_finite() && *x >= 0.0).then_some(Setting::Colour(colour))
}

/// `"a", "b"`, as scripts write them.
fn quoted(texts: &[String]) -> String {
    let texts: Vec<String> = texts.iter().map(|text| format!("{text:?}")).collect();
    texts.join(", ")
}

/// The most parameters: more than a person can set, and each name is looked up among all.
const MOST: usize = 4096;

/// The most choices of one parameter: each is compared with all before it.
const CHOICES: usize = 1024;

/// The parameters seen so far, and the values asked for.
#[derive(Debug, Default)]
pub(crate) struct Parameters {
    pub sets: Vec<(String, String)>,
    pub seen: Vec<Parameter>,
}

impl Parameters {
    /// Takes a parameter and gives its value of this run.
    fn add(&mut self, name: &str, kind: Kind, place: Position) -> Fallible<Dynamic> {
        if self.seen.len() >= MOST {
            return Err(trouble(format!("a scene has at most {MOST} parameters")));
        }
        if messages::printable(name) != name {
            return Err(trouble("the name of a parameter takes no control characters"));
        }
        let (domain, default) = match &kind {
            Kind::Number(numbers) => range(name, numbers)?,
            Kind::Value(default) => plain(name, default)?,
            Kind::Choice(default, choices) => choice(name, default, choices)?,
        };
        if let Some(first) = self.seen.iter().find(|p| p.name == name) {
            return Err(trouble(format!(
                "there is one parameter `{name}` in a scene, and the first is on line {}",
                first.line
            )));
        }
        let mut value = default.clone();
        // The last of several settings of one name counts, as on most command lines.
        if let Some((_, text)) = self.sets.iter().rev().find(|(set, _)| set == name) {
            value = domain.read(text).ok_or_else(|| Trouble {
                blame: Blame::Set,
                ..Trouble::new(format!(
                    "`--set {name}={text}`: `{name}` takes {}",
                    domain.takes(text)
                ))
            })?;
        }
        let given = value.given(&domain);
        let line = place.line().unwrap_or(0);
        self.seen.push(Parameter { name: name.into(), domain, default, value, line });
        Ok(given)
    }

    /// What was set and no `param` took.
    pub fn unknown_set(&self) -> Option<String> {
        let (name, text) =
            self.sets.iter().find(|(set, _)| self.seen.iter().all(|p| p.name != *set))?;
        let known: Vec<&str> = self.seen.iter().map(|p| p.name.as_str()).collect();
        let offer = if known.is_empty() {
            "; it has no parameters".to_owned()
        } else {
            names::offer(name, "has", &known)
        };
        Some(format!("`--set {name}={text}`: the script has no parameter `{name}`{offer}"))
    }
}

/// How `param` was called, without the name.
enum Kind {
    /// A default, the lowest and the highest.
    Number([Dynamic; 3]),
    /// A default alone: a truth value or a colour.
    Value(Dynamic),
    /// A default and what may be chosen.
    Choice(Dynamic, Dynamic),
}

/// A number between two others.
fn range(name: &str, numbers: &[Dynamic; 3]) -> Fallible<(Domain, Setting)> {
    let mut values = [0.0; 3];
    for (value, (given, what)) in
        values.iter_mut().zip(numbers.iter().zip(["default", "low", "high"]))
    {
        *value = number(given).filter(|x| x.is_finite()).ok_or_else(|| {
            trouble(format!(
                "the {what} of parameter `{name}` takes a finite number, got {}",
                describe(given)
            ))
        })?;
    }
    let [default, low, high] = values;
    if low > high {
        return Err(trouble(format!(
            "parameter `{name}` has a low of {low}, above its high of {high}"
        )));
    }
    if !(low..=high).contains(&default) {
        return Err(trouble(format!(
            "parameter `{name}` has a default of {default}, outside {low} to {high}"
        )));
    }
    let whole = numbers.iter().all(Dynamic::is_int);
    let domain = if whole { Domain::Whole(low, high) } else { Domain::Float(low, high) };
    Ok((domain, Setting::Number(default)))
}

/// What its default alone describes: a truth value or a colour.
fn plain(name: &str, default: &Dynamic) -> Fallible<(Domain, Setting)> {
    if let Ok(flag) = default.as_bool() {
        return Ok((Domain::Bool, Setting::Bool(flag)));
    }
    let colour = match default.as_immutable_string_ref() {
        Ok(text) => hex(&text),
        Err(_) => vector(default),
    };
    if let Some(setting) = colour.and_then(|c| linear(c.to_array())) {
        return Ok((Domain::Colour, setting));
    }
    let instead = if number(default).is_some() {
        "a number needs its bounds: param(\"name\", default, low, high)"
    } else if default.is_string() {
        "a text needs its choices: param(\"name\", \"a\", [\"a\", \"b\"])"
    } else {
        "a colour has three numbers of at least 0"
    };
    Err(trouble(format!(
        "parameter `{name}` with a default alone takes true, false or a colour, as \"#ff8800\", got {}; {instead}",
        describe(default)
    )))
}

/// One of several texts.
fn choice(name: &str, default: &Dynamic, choices: &Dynamic) -> Fallible<(Domain, Setting)> {
    let texts = choices.as_array_ref().map_err(|_| {
        trouble(format!(
            "the choices of parameter `{name}` are an array of strings, got {}; a number needs both its bounds: param(\"name\", default, low, high)",
            describe(choices)
        ))
    })?;
    if texts.len() > CHOICES {
        return Err(trouble(format!("parameter `{name}` has more than {CHOICES} choices")));
    }
    let mut known: Vec<String> = Vec::with_capacity(texts.len());
    for text in texts.iter() {
        let Ok(text) = text.as_immutable_string_ref() else {
            return Err(trouble(format!(
                "the choices of parameter `{name}` are strings, got {}",
                describe(text)
            )));
        };
        let text = text.as_str();
        // The command line trims what it is given, and an empty value is none.
        if text.is_empty() || text.trim() != text || messages::printable(text) != text {
            return Err(trouble(format!(
                "a choice of parameter `{name}` takes text without blanks around it and without control characters, got {text:?}"
            )));
        }
        if known.iter().any(|k| k == text) {
            return Err(trouble(format!("parameter `{name}` has the choice {text:?} twice")));
        }
        known.push(text.to_string());
    }
    if known.is_empty() {
        return Err(trouble(format!("parameter `{name}` has no choices: name at least one")));
    }
    let Ok(text) = default.as_immutable_string_ref() else {
        return Err(trouble(format!(
            "the default of parameter `{name}` is one of its choices, {}, got {}",
            quoted(&known),
            describe(default)
        )));
    };
    let text = text.as_str();
    if !known.iter().any(|k| k == text) {
        let near = names::did_you_mean(text, known.iter().map(String::as_str));
        return Err(trouble(format!(
            "the default {text:?} of parameter `{name}` is none of its choices, {}{near}",
            quoted(&known)
        )));
    }
    let default = Setting::Choice(text.to_string());
    Ok((Domain::Choice(known), default))
}

/// Registers `param`.
pub(crate) fn register(engine: &mut Engine, state: &Shared) {
    let shared = state.clone();
    let add = move |ctx: &NativeCallContext<'_>, name: &str, kind: Kind| -> Fallible<Dynamic> {
        let mut state = shared.lock();
        state.script_only("param")?;
        state.parameters.add(name, kind, ctx.call_position())
    };
    let (one, two) = (add.clone(), add.clone());
    engine.register_fn("param", move |ctx: NativeCallContext, name: &str, default: Dynamic| {
        one(&ctx, name, Kind::Value(default))
    });
    engine.register_fn(
        "param",
        move |ctx: NativeCallContext, name: &str, default: Dynamic, choices: Dynamic| {
            two(&ctx, name, Kind::Choice(default, choices))
        },
    );
    engine.register_fn(
        "param",
        move |ctx: NativeCallContext, name: &str, default: Dynamic, low: Dynamic, high: Dynamic| {
            add(&ctx, name, Kind::Number([default, low, high]))
        },
    );
}
