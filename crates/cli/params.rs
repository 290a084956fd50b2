//! `reflet params SCRIPT`: what `--set` can set.

use crate::check::shapes::number;
use reflet_script::{Domain, Parameter, Setting};
use serde::Serialize;
use serde_json::Value;

/// A parameter as `--json` prints it. Numbers of a whole parameter are whole.
#[derive(Serialize)]
struct Row<'a> {
    name: &'a str,
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    whole: Option<bool>,
    default: Value,
    #[serde(skip_serializing_if = "Option::is_none")]
    low: Option<Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    high: Option<Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    choices: Option<&'a [String]>,
    value: Value,
    line: usize,
}

impl<'a> Row<'a> {
    fn of(p: &'a Parameter) -> Self {
        let data = |setting: &Setting| match (setting, &p.domain) {
            (Setting::Number(x), Domain::Whole(..)) => (*x as i64).into(),
            (Setting::Number(x), _) => (*x).into(),
            (Setting::Bool(flag), _) => (*flag).into(),
            (Setting::Colour(c), _) => c.to_vec().into(),
            (Setting::Choice(text), _) => text.as_str().into(),
        };
        let bound = |x: f64| Some(data(&Setting::Number(x)));
        let (kind, whole, low, high, choices) = match &p.domain {
            Domain::Whole(low, high) => ("whole", Some(true), bound(*low), bound(*high), None),
            Domain::Float(low, high) => ("float", Some(false), bound(*low), bound(*high), None),
            Domain::Bool => ("bool", None, None, None, None),
            Domain::Colour => ("colour", None, None, None, None),
            Domain::Choice(choices) => ("choice", None, None, None, Some(choices.as_slice())),
        };
        let (default, value) = (data(&p.default), data(&p.value));
        Row { name: &p.name, kind, whole, default, low, high, choices, value, line: p.line }
    }
}

/// One JSON array on one line.
pub fn json(parameters: &[Parameter]) -> String {
    let rows: Vec<Row<'_>> = parameters.iter().map(Row::of).collect();
    let mut text = serde_json::to_string(&rows).expect("strings and numbers have a JSON form");
    text.push('\n');
    text
}

/// A value as `--set` takes it.
pub fn setting(setting: &Setting) -> String {
    match setting {
        Setting::Number(x) => number(*x),
        Setting::Bool(flag) => flag.to_string(),
        Setting::Colour(c) => c.map(number).join(","),
        Setting::Choice(text) => text.clone(),
    }
}

/// What a parameter takes, in words.
pub fn domain(domain: &Domain) -> String {
    match domain {
        Domain::Whole(low, high) => format!("whole, {} to {}", number(*low), number(*high)),
        Domain::Float(low, high) => format!("{} to {}", number(*low), number(*high)),
        Domain::Bool => "true or false".into(),
        Domain::Colour => "colour".into(),
        Domain::Choice(choices) => format!("one of {}", choices.join(", ")),
    }
}

/// A table.
pub fn table(parameters: &[Parameter]) -> String {
    if parameters.is_empty() {
        return "the script has no parameters\n".into();
    }
    let width = parameters.iter().map(|p| p.name.chars().count()).max().unwrap_or(0);
    let mut text = String::new();
    for p in parameters {
        let set = match p.value == p.default {
            true => String::new(),
            false => format!(" (default {})", setting(&p.default)),
        };
        let (value, takes) = (setting(&p.value), domain(&p.domain));
        text += &format!("{:width$}  {value}{set}, {takes}\n", p.name);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameters() -> [Parameter; 5] {
        let of = |name: &str, domain, [default, value]: [Setting; 2], line| Parameter {
            name: name.into(),
            domain,
            default,
            value,
            line,
        };
        let choice = |text: &str| Setting::Choice(text.into());
        [
            of("gloss", Domain::Float(0.0, 1.0), [0.4, 0.7].map(Setting::Number), 3),
            of("n", Domain::Whole(1.0, 9.0), [5.0, 5.0].map(Setting::Number), 4),
            of("shiny", Domain::Bool, [true, false].map(Setting::Bool), 5),
            of("tint", Domain::Colour, [[1.0, 0.5, 0.0]; 2].map(Setting::Colour), 6),
            of(
                "finish",
                Domain::Choice(vec!["chrome".into(), "matt".into()]),
                ["chrome", "matt"].map(choice),
                7,
            ),
        ]
    }

    #[test]
    fn json_keeps_whole_numbers_whole() {
        assert_eq!(
            json(&parameters()),
            concat!(
                r#"[{"name":"gloss","kind":"float","whole":false,"default":0.4,"low":0.0,"high":1.0,"value":0.7,"line":3},"#,
                r#"{"name":"n","kind":"whole","whole":true,"default":5,"low":1,"high":9,"value":5,"line":4},"#,
                r#"{"name":"shiny","kind":"bool","default":true,"value":false,"line":5},"#,
                r#"{"name":"tint","kind":"colour","default":[1.0,0.5,0.0],"value":[1.0,0.5,0.0],"line":6},"#,
                r#"{"name":"finish","kind":"choice","default":"chrome","choices":["chrome","matt"],"value":"matt","line":7}]"#,
                "\n"
            )
        );
        assert_eq!(json(&[]), "[]\n");
    }

    #[test]
    fn the_table_lines_up() {
        assert_eq!(
            table(&parameters()),
            concat!(
                "gloss   0.7 (default 0.4), 0 to 1\n",
                "n       5, whole, 1 to 9\n",
                "shiny   false (default true), true or false\n",
                "tint    1,0.5,0, colour\n",
                "finish  matt (default chrome), one of chrome, matt\n"
            )
        );
    }
}
