//! `reflet params SCRIPT`: what `--set` can set.

use crate::check::shapes::number;
use reflet_script::Parameter;
use serde::Serialize;

/// A parameter as `--json` prints it. Numbers of a whole parameter are whole.
#[derive(Serialize)]
struct Row<'a> {
    name: &'a str,
    whole: bool,
    default: serde_json::Number,
    low: serde_json::Number,
    high: serde_json::Number,
    value: serde_json::Number,
    line: usize,
}

/// One JSON array on one line.
pub fn json(parameters: &[Parameter]) -> String {
    let rows: Vec<Row<'_>> = parameters
        .iter()
        .map(|p| {
            let number = |x: f64| match serde_json::Number::from_f64(x) {
                Some(float) if !p.whole => float,
                _ => (x as i64).into(),
            };
            Row {
                name: &p.name,
                whole: p.whole,
                default: number(p.default),
                low: number(p.low),
                high: number(p.high),
                value: number(p.value),
                line: p.line,
            }
        })
        .collect();
    let mut text = serde_json::to_string(&rows).expect("strings and numbers have a JSON form");
    text.push('\n');
    text
}

/// A table.
pub fn table(parameters: &[Parameter]) -> String {
    if parameters.is_empty() {
        return "the script has no parameters\n".into();
    }
    let width = parameters.iter().map(|p| p.name.chars().count()).max().unwrap_or(0);
    let mut text = String::new();
    for p in parameters {
        let kind = if p.whole { "whole, " } else { "" };
        let set = match p.value == p.default {
            true => String::new(),
            false => format!(" (default {})", number(p.default)),
        };
        text += &format!(
            "{:width$}  {}{set}, {kind}{} to {}\n",
            p.name,
            number(p.value),
            number(p.low),
            number(p.high)
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameters() -> [Parameter; 2] {
        let gloss = Parameter {
            name: "gloss".into(),
            default: 0.4,
            low: 0.0,
            high: 1.0,
            value: 0.7,
            whole: false,
            line: 3,
        };
        let balls = Parameter {
            name: "n".into(),
            default: 5.0,
            low: 1.0,
            high: 9.0,
            value: 5.0,
            whole: true,
            line: 4,
        };
        [gloss, balls]
    }

    #[test]
    fn json_keeps_whole_numbers_whole() {
        assert_eq!(
            json(&parameters()),
            concat!(
                r#"[{"name":"gloss","whole":false,"default":0.4,"low":0.0,"high":1.0,"value":0.7,"line":3},"#,
                r#"{"name":"n","whole":true,"default":5,"low":1,"high":9,"value":5,"line":4}]"#,
                "\n"
            )
        );
        assert_eq!(json(&[]), "[]\n");
    }

    #[test]
    fn the_table_lines_up() {
        assert_eq!(
            table(&parameters()),
            "gloss  0.7 (default 0.4), 0 to 1\nn      5, whole, 1 to 9\n"
        );
    }
}
