//! `param`: numbers that the command line or a slider may set.

use crate::messages;
use crate::names;
use crate::state::Shared;
use crate::trouble::{Blame, Fallible, Trouble, trouble};
use crate::value::{describe, number};
use rhai::{Dynamic, Engine, NativeCallContext, Position};

/// One parameter of a script.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name, as `--set` takes it.
    pub name: String,
    /// Its value if nobody sets it, from `low` to `high`.
    pub default: f64,
    /// The lowest value allowed.
    pub low: f64,
    /// The highest value allowed.
    pub high: f64,
    /// The value of this run.
    pub value: f64,
    /// Whether it takes whole numbers only.
    pub whole: bool,
    /// The line of its `param` call, counted from 1.
    pub line: usize,
}

/// The most parameters: more than a person can set, and each name is looked up among all.
const MOST: usize = 4096;

/// The parameters seen so far, and the values asked for.
#[derive(Debug, Default)]
pub(crate) struct Parameters {
    pub sets: Vec<(String, String)>,
    pub seen: Vec<Parameter>,
}

impl Parameters {
    fn add(&mut self, name: &str, numbers: [&Dynamic; 3], place: Position) -> Fallible<Dynamic> {
        if self.seen.len() >= MOST {
            return Err(trouble(format!("a scene has at most {MOST} parameters")));
        }
        if messages::printable(name) != name {
            return Err(trouble("the name of a parameter takes no control characters"));
        }
        let mut values = [0.0; 3];
        for (value, (given, what)) in
            values.iter_mut().zip(numbers.into_iter().zip(["default", "low", "high"]))
        {
            *value = number(given).filter(|x| x.is_finite()).ok_or_else(|| {
                trouble(format!(
                    "the {what} of parameter `{name}` takes a finite number, got {}",
                    describe(given)
                ))
            })?;
        }
        let [default, low, high] = values;
        let whole = numbers.iter().all(|n| n.is_int());
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
        if let Some(first) = self.seen.iter().find(|p| p.name == name) {
            return Err(trouble(format!(
                "there is one parameter `{name}` in a scene, and the first is on line {}",
                first.line
            )));
        }
        let mut value = default;
        // The last of several settings of one name counts, as on most command lines.
        if let Some((_, text)) = self.sets.iter().rev().find(|(set, _)| set == name) {
            value = read(text, whole).filter(|v| (low..=high).contains(v)).ok_or_else(|| {
                let kind = if whole { "a whole number" } else { "a number" };
                Trouble {
                    blame: Blame::Set,
                    ..Trouble::new(format!(
                        "`--set {name}={text}`: `{name}` takes {kind} from {low} to {high}"
                    ))
                }
            })?;
        }
        let line = place.line().unwrap_or(0);
        self.seen.push(Parameter { name: name.into(), default, low, high, value, whole, line });
        Ok(if whole { (value as i64).into() } else { value.into() })
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

/// A number as the command line writes it.
fn read(text: &str, whole: bool) -> Option<f64> {
    let text = text.trim();
    if whole {
        // Above 2^53 a float is no longer every whole number; no range reaches so far.
        return text.parse::<i64>().ok().map(|i| i as f64);
    }
    text.parse::<f64>().ok().filter(|x| x.is_finite())
}

/// Registers `param`.
pub(crate) fn register(engine: &mut Engine, state: &Shared) {
    let shared = state.clone();
    engine.register_fn(
        "param",
        move |ctx: NativeCallContext,
              name: &str,
              default: Dynamic,
              low: Dynamic,
              high: Dynamic|
              -> Fallible<Dynamic> {
            let mut state = shared.lock();
            state.script_only("param")?;
            state.parameters.add(name, [&default, &low, &high], ctx.call_position())
        },
    );
}
