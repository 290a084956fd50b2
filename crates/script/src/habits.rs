//! What other languages write, and what to write here instead.

/// What to write in place of a word that scripts do not have; `rest` is the text after it.
pub(crate) fn word(word: &str, rest: &str) -> Option<String> {
    let rest = rest.trim_start();
    let next: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    if ["var", "mut", "auto", "local", "float", "double", "bool", "string", "vec"].contains(&word)
        || (word == "int" && !next.is_empty())
    {
        let name = if next.is_empty() { "name" } else { &next };
        return Some(format!("a variable is made with `let`: write let {name} = ..."));
    }
    Some(match word {
        "function" | "func" | "def" | "fun" | "sub" | "proc" if rest.starts_with('(') => {
            "a function without a name is written |x| ...".to_owned()
        }
        "function" | "func" | "def" | "fun" | "sub" | "proc" => {
            let name = if next.is_empty() { "name" } else { &next };
            format!("a function is made with `fn`: write fn {name}(...) {{ ... }}")
        }
        "lambda" => "a function without a name is written |x| ...".into(),
        "elif" | "elsif" | "elseif" => "write else if ... { ... }".into(),
        "then" | "begin" | "end" | "fi" | "endif" => "blocks are written { ... }".into(),
        "and" => "`and` is written &&".into(),
        "or" => "`or` is written ||".into(),
        "not" => "`not` is written !".into(),
        "is" => "`is` is written ==".into(),
        "null" | "nil" | "None" | "undefined" | "NULL" | "nullptr" | "void" | "Null" => {
            "nothing is written ()".into()
        }
        "True" | "TRUE" | "yes" => "write true".into(),
        "False" | "FALSE" | "no" => "write false".into(),
        "Math" | "math" | "np" | "numpy" => {
            "functions stand alone: write sin(x), sqrt(x), PI".into()
        }
        "print" | "println" | "printf" | "echo" | "puts" | "console" | "log" | "alert" | "cout" => {
            "write print(value)".into()
        }
        "self" => "write this".into(),
        "foreach" | "forall" => "write for x in list { ... }".into(),
        "range" => "a range is written 0..10; a random stream has r.range(a, b)".into(),
        "size" | "count" => "the length of an array or string is x.len()".into(),
        "case" | "match" => "write switch x { 1 => ..., 2 => ..., _ => ... }".into(),
        "class" | "struct" | "new" => {
            "there are no classes: keep values in a map, #{ name: value }".into()
        }
        "rand" | "randint" | "rnd" => {
            "write let r = random(1), and r.float() or r.int(a, b)".into()
        }
        "ceil" => "write ceiling(x)".into(),
        "fract" | "frac" => "write fraction(x)".into(),
        "radians" | "deg2rad" => "write to_radians(x)".into(),
        "degrees" | "rad2deg" => "write to_degrees(x)".into(),
        "E" => "Euler's number is a function: write E()".into(),
        "box" | "cube" | "block" => "write cuboid(#{ min: ..., max: ... })".into(),
        "ball" | "orb" => "write sphere(#{ center: ..., radius: ... })".into(),
        "circle" | "disk" => "write disc(#{ center: ..., normal: ..., radius: ... })".into(),
        "rectangle" | "rect" | "square" => "write quad(#{ corner: ..., u: ..., v: ... })".into(),
        "light_source" | "point_light" | "pointlight" | "lamp" => {
            "write light(#{ at: ..., emissivity: ... })".into()
        }
        "color" | "colour" => "write rgb(255, 136, 0), srgb(\"#ff8800\") or [1, 0.5, 0]".into(),
        _ => {
            let (_, hex, rgb) = COLOURS.iter().find(|(name, ..)| *name == word)?;
            return Some(format!(
                "a colour is written in numbers: rgb({rgb}), srgb(\"{hex}\") or hsv(degrees, s, v)"
            ));
        }
    })
}

/// Colours by the names that the web gives them.
const COLOURS: &[(&str, &str, &str)] = &[
    ("red", "#ff0000", "255, 0, 0"),
    ("green", "#00ff00", "0, 255, 0"),
    ("blue", "#0000ff", "0, 0, 255"),
    ("yellow", "#ffff00", "255, 255, 0"),
    ("cyan", "#00ffff", "0, 255, 255"),
    ("magenta", "#ff00ff", "255, 0, 255"),
    ("orange", "#ffa500", "255, 165, 0"),
    ("purple", "#800080", "128, 0, 128"),
    ("pink", "#ffc0cb", "255, 192, 203"),
    ("brown", "#a52a2a", "165, 42, 42"),
    ("white", "#ffffff", "255, 255, 255"),
    ("black", "#000000", "0, 0, 0"),
    ("grey", "#808080", "128, 128, 128"),
    ("gray", "#808080", "128, 128, 128"),
];

/// What to write in place of a symbol; `before` and `rest` are the text around it.
pub(crate) fn symbol(symbol: &str, before: &str, rest: &str) -> Option<String> {
    let name: String = {
        let back: Vec<char> = before
            .trim_end()
            .chars()
            .rev()
            .take_while(|c| c.is_alphanumeric() || "_.[]".contains(*c))
            .collect();
        let forth = || rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        if back.is_empty() { forth() } else { back.into_iter().rev().collect() }
    };
    let name = if name.is_empty() { "i" } else { &name };
    Some(match symbol {
        "++" => format!("there is no `++`: write {name} += 1"),
        "--" => format!("there is no `--`: write {name} -= 1"),
        "?" => "there is no `? :`: write if a { b } else { c }".into(),
        "#" if rest.chars().take_while(char::is_ascii_hexdigit).count() >= 3 => {
            "a web colour is a string: write srgb(\"#ff8800\")".into()
        }
        "#" | "#!" => "a comment begins with //, a map with #{".into(),
        "# {" => "write #{ without a blank".into(),
        "===" => "write ==".into(),
        "!==" => "write !=".into(),
        ":=" => "write let x = ... for a new variable, x = ... for one that is there".into(),
        "->" | "<-" => format!("there is no `{symbol}`: a function names no types"),
        "$" | "@" => format!("there is no `{symbol}`: names stand alone"),
        "~" => "write !x for `not`".into(),
        "..." => "a range is written 0..10, or 0..=9".into(),
        _ => return None,
    })
}

/// What to write where the grammar breaks; `before` is the text up to there, `rest` from there on.
pub(crate) fn broken(before: &str, rest: &str) -> Option<String> {
    let before = before.trim_end();
    let head: String = rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    if !head.is_empty()
        && let Some(said) = word(&head, &rest[head.len()..])
    {
        return Some(said);
    }
    let last = before.rsplit(|c: char| !(c.is_alphanumeric() || c == '_')).next().unwrap_or("");
    let line = before.rsplit(['\n', ';', '}']).next().unwrap_or("").trim_start();
    if line.starts_with("for (") || line.starts_with("for(") {
        return Some("write for x in 0..10 { ... }, without ( )".into());
    }
    if line.starts_with("for ") && rest.starts_with('=') {
        return Some("write for i in 0..10 { ... }".into());
    }
    if ["print", "return print"].contains(&line) && !rest.is_empty() {
        return Some("write print(value)".into());
    }
    if rest.starts_with("=>") {
        return Some("a function without a name is written |x| ...".into());
    }
    if rest.starts_with('=') && !rest.starts_with("==") {
        if ["if ", "while ", "} else if ", "else if "].iter().any(|w| line.starts_with(w)) {
            return Some("`=` writes a value: to compare, write ==".into());
        }
        if before.rfind("#{") > before.rfind(['}', ';']) {
            return Some(format!("a key and its value are written with `:`: {last}: ..."));
        }
        if before.rfind('(') > before.rfind([')', ';']) {
            return Some(format!("makers take a map: write #{{ {last}: ... }}"));
        }
    }
    if rest.starts_with(':') {
        if line.starts_with("let ") || line.starts_with("const ") || line.starts_with("fn ") {
            return Some("names have no types here: leave out the `:` and what follows it".into());
        }
        if ["if ", "while ", "for ", "else"].iter().any(|w| line.starts_with(w)) {
            return Some("a block is written { ... }".into());
        }
        if before.rfind('(') > before.rfind([')', ';', '{']) {
            return Some(format!("makers take a map: write #{{ {last}: ... }}"));
        }
    }
    // The word before may be what does not belong.
    word(last, rest)
}

/// Whether the innermost bracket that is open before a place is a `{` where a map must stand.
pub(crate) fn map_without_hash(before: &str) -> bool {
    let mut depth = 0;
    for (at, c) in before.char_indices().rev().take(10_000) {
        match c {
            '}' | ')' | ']' => depth += 1,
            '{' | '(' | '[' if depth > 0 => depth -= 1,
            '{' => return before[..at].trim_end().ends_with(['(', ',', ':', '=', '[']),
            '(' | '[' => return false,
            _ => {}
        }
    }
    false
}
