//! From a Rhai error to its message and its place in the script.
//!
//! The tree is compiled without optimisation, so that map literals still stand in it with the
//! positions of their keys.

use crate::engine::known;
use crate::error::{ErrorKind, Note, Place, ScriptError, place};
use crate::trouble::{Blame, Trouble};
use crate::{habits, messages, names, operators, reference};
use rhai::{
    AST, ASTNode, Engine, EvalAltResult, Expr, FnPtr, LexError, ParseErrorType, Position, Stmt,
};
use std::path::Path;

/// What is needed to find places.
#[derive(Clone, Copy)]
pub(crate) struct Script<'a> {
    pub path: &'a Path,
    pub text: &'a str,
    pub ast: Option<&'a AST>,
    pub engine: &'a Engine,
}

impl Script<'_> {
    /// An error at a position.
    pub fn error(&self, kind: ErrorKind, message: String, at: Position) -> ScriptError {
        ScriptError {
            kind,
            message: messages::message(&message),
            path: self.path.into(),
            place: place(self.text, at),
            notes: Vec::new(),
            frame: None,
        }
    }

    /// What is wrong with the script's grammar.
    pub fn parse_error(&self, error: &rhai::ParseError) -> ScriptError {
        let at = error.position();
        self.error(ErrorKind::Script, parse_message(error.err_type(), self.text, at), at)
    }

    /// Our own trouble, at the place that it names or at `call`.
    pub fn trouble(&self, trouble: &Trouble, call: Position) -> ScriptError {
        let kind = match trouble.blame {
            Blame::Script => ErrorKind::Script,
            Blame::Set => ErrorKind::Set,
            Blame::File => ErrorKind::Input,
        };
        let call = known(trouble.place).unwrap_or(call);
        let place = |trouble: &Trouble| self.ast.and_then(|ast| key_place(ast, call, trouble));
        let at = place(trouble);
        if let Some((rival, message)) = trouble.rival.as_deref() {
            let rival = Trouble { unknown: Some(rival.clone()), ..trouble.clone() };
            let later = place(&rival).filter(|later| at.is_some_and(|at| before(at, Some(*later))));
            if let Some(later) = later {
                return self.error(kind, message.clone(), later);
            }
        }
        self.error(kind, trouble.message.clone(), at.unwrap_or(call))
    }

    /// A run-time error, with all the places on the way to it.
    pub fn run_error(&self, error: &EvalAltResult) -> ScriptError {
        let mut calls: Vec<(String, Position)> = Vec::new();
        let mut inner = error;
        while let EvalAltResult::ErrorInFunctionCall(name, _, next, at) = inner {
            calls.push((name.clone(), *at));
            inner = next;
        }
        // Some errors ("data race") have no position: the nearest call has.
        let call = calls.last().map_or(Position::NONE, |c| c.1);
        let raced = || match (inner, self.ast) {
            (EvalAltResult::ErrorDataRace(what, _), Some(ast)) => known(function_place(ast, what)),
            _ => None,
        };
        let at = known(inner.position())
            .or(known(call))
            .or_else(raced)
            .or_else(|| self.ast.and_then(likely_place))
            .unwrap_or(Position::NONE);
        let mut made = match inner {
            EvalAltResult::ErrorRuntime(value, _) | EvalAltResult::ErrorTerminated(value, _) => {
                match value.read_lock::<Trouble>() {
                    Some(trouble) => self.trouble(&trouble, at),
                    None => {
                        let said = crate::guard::text(value).unwrap_or_default();
                        let said =
                            if said.is_empty() { "the script threw an error".into() } else { said };
                        self.error(ErrorKind::Script, said, at)
                    }
                }
            }
            EvalAltResult::ErrorParsing(kind, _) => {
                self.error(ErrorKind::Script, parse_message(kind, self.text, at), at)
            }
            other => self.error(ErrorKind::Script, run_message(other, self), at),
        };
        let anonymous = |name: &str| name.starts_with("anon$");
        // The innermost call is where the failing function was called; a deep recursion shows both
        // of its ends.
        let mut notes: Vec<&(String, Position)> = calls.iter().rev().collect();
        if notes.len() > 4 {
            notes.drain(2..notes.len() - 1);
        }
        for (name, at) in notes {
            let Some(where_) = place(self.text, *at) else { continue };
            let message = if anonymous(name) {
                "in the function that was passed here".to_owned()
            } else {
                messages::message(&format!("`{name}` was called here"))
            };
            if made.place.as_ref().is_some_and(|p: &Place| p == &where_) {
                continue;
            }
            made.notes.push(Note { message, place: where_ });
        }
        made
    }
}

/// The place of the culprit in the map literal of the call or assignment at `call`.
fn key_place(ast: &AST, call: Position, trouble: &Trouble) -> Option<Position> {
    if trouble.path.is_empty() && trouble.unknown.is_none() {
        return None;
    }
    let mut found = None;
    ast.walk(&mut |path: &[ASTNode]| {
        match path.last() {
            Some(ASTNode::Expr(Expr::FnCall(x, at)) | ASTNode::Stmt(Stmt::FnCall(x, at)))
                if *at == call =>
            {
                let steps = &trouble.path;
                // Makers take one map; `group` and `instance` take it last.
                if let Some(map) = x.args.last() {
                    let map = literal(ast, map);
                    found = in_map(map, steps, trouble.unknown.as_deref());
                }
            }
            Some(ASTNode::Expr(Expr::Property(_, at))) if *at == call => {
                // `ball.material = #{...}`: the first step is the property itself.
                let right = path.iter().rev().find_map(|node| match node {
                    ASTNode::Stmt(Stmt::Assignment(x)) => Some(&x.1.rhs),
                    _ => None,
                });
                if let (Some(right), Some((_, steps))) = (right, trouble.path.split_first()) {
                    found = in_map(right, steps, trouble.unknown.as_deref());
                }
            }
            _ => {}
        }
        found.is_none()
    });
    found
}

/// The map literal itself, or the one that a variable of the script was defined with.
fn literal<'a>(ast: &'a AST, map: &'a Expr) -> &'a Expr {
    let Expr::Variable(x, ..) = map else { return map };
    let mut definitions = ast.statements().iter().filter_map(|stmt| match stmt {
        Stmt::Var(var, ..) if var.0.name == x.1 => Some(&var.1),
        _ => None,
    });
    // With several of one name it is not known which is meant.
    match (definitions.next(), definitions.next()) {
        (Some(only), None) => only,
        _ => map,
    }
}

/// Follows keys into nested map literals, as far as they are literals.
fn in_map(map: &Expr, steps: &[&str], unknown: Option<&str>) -> Option<Position> {
    let Expr::Map(literal, _) = map else { return None };
    let (step, rest) = match steps.split_first() {
        Some((step, rest)) => (*step, rest),
        None => (unknown?, [].as_slice()),
    };
    let (name, value) = literal.0.iter().find(|(name, _)| name.name == step)?;
    if steps.is_empty() || (rest.is_empty() && unknown.is_none()) {
        return Some(name.pos);
    }
    in_map(value, rest, unknown).or(Some(name.pos))
}

/// Where the function stands that a message of Rhai's names in quotes.
fn function_place(ast: &AST, what: &str) -> Position {
    let Some(name) = what.split('\'').nth(1) else { return Position::NONE };
    let mut found = Position::NONE;
    ast.walk(&mut |path: &[ASTNode]| {
        match path.last() {
            Some(ASTNode::Expr(Expr::FnCall(x, at)) | ASTNode::Stmt(Stmt::FnCall(x, at)))
                if x.name == name =>
            {
                found = *at;
            }
            Some(ASTNode::Expr(Expr::DynamicConstant(value, at)))
                if value.read_lock::<FnPtr>().is_some_and(|f| f.fn_name() == name) =>
            {
                found = *at;
            }
            _ => {}
        }
        found.is_none()
    });
    found
}

/// Where an error that Rhai gives no place most likely came up: in the first loop, or else in the
/// first statement.
fn likely_place(ast: &AST) -> Option<Position> {
    let mut found = None;
    ast.walk(&mut |path: &[ASTNode]| {
        if let Some(ASTNode::Stmt(stmt @ (Stmt::While(..) | Stmt::Do(..) | Stmt::For(..)))) =
            path.last()
        {
            found = known(stmt.position());
        }
        found.is_none()
    });
    found.or_else(|| ast.statements().iter().find_map(|stmt| known(stmt.position())))
}

/// Where a variable of the script itself was defined last.
pub(crate) fn definition(ast: &AST, name: &str) -> Position {
    let mut found = Position::NONE;
    for stmt in ast.statements() {
        if let Stmt::Var(x, _, at) = stmt
            && x.0.name == name
        {
            found = *at;
        }
    }
    found
}

/// Whether one position comes before another; before none at all, each does.
pub(crate) fn before(a: Position, b: Option<Position>) -> bool {
    let key = |p: Position| (p.line(), p.position());
    b.is_none_or(|b| key(a) < key(b))
}

/// What a `fn` sees.
const FN_SEES: &str =
    "a `fn` sees its parameters, the makers, helpers, TAU, PI and global::NAME constants only";

/// The text before a position, and from it on.
fn around(text: &str, at: Position) -> (&str, &str) {
    let Some(line) = at.line() else { return (text, "") };
    let start: usize = text.split_inclusive('\n').take(line - 1).map(str::len).sum();
    let column = at.position().unwrap_or(1) - 1;
    let offset = text[start..].char_indices().nth(column).map_or(text.len(), |(i, _)| start + i);
    text.split_at(offset)
}

/// A grammar error in words.
fn parse_message(kind: &ParseErrorType, text: &str, at: Position) -> String {
    let (before, rest) = around(text, at);
    match kind {
        ParseErrorType::VariableUndefined(name) => {
            if rest[name.len().min(rest.len())..].trim_start().starts_with(':')
                && habits::map_without_hash(before)
            {
                return format!("a map is written #{{ ... }}: put # before the {{ of `{name}`");
            }
            let named = rest[name.len().min(rest.len())..].trim_start().starts_with(':');
            if named && before.trim_end().ends_with(['(', ',']) {
                return format!("makers take a map: write #{{ {name}: ... }}");
            }
            unknown_variable(name, text, at)
        }
        ParseErrorType::UnknownOperator(name) => {
            let after = rest.strip_prefix(name.as_str()).unwrap_or("");
            habits::symbol(name, before, after)
                .unwrap_or_else(|| format!("there is no operator `{name}`"))
        }
        ParseErrorType::Reserved(name)
            if ["eval", "curry", "import", "export"].contains(&&**name) =>
        {
            format!("`{name}` is not part of scene scripts")
        }
        ParseErrorType::Reserved(name) => {
            let after = rest.strip_prefix(name.as_str()).unwrap_or("");
            habits::word(name, after)
                .or_else(|| habits::symbol(name, before, after))
                .unwrap_or_else(|| format!("`{name}` is kept for Rhai itself: take another name"))
        }
        ParseErrorType::BadInput(LexError::MalformedChar(text)) => {
            format!("a string stands in double quotes: write \"{text}\"")
        }
        ParseErrorType::ExprTooDeep => "the expression nests too deep: split it with `let`".into(),
        other => {
            let said = other.to_string();
            match said
                .strip_prefix("reserved keyword '")
                .and_then(|s| s.split_once("' is disabled"))
            {
                Some((name, _)) => format!("`{name}` is not part of scene scripts"),
                None => habits::broken(before, rest).unwrap_or_else(|| lower(&said)),
            }
        }
    }
}

fn unknown_variable(name: &str, text: &str, at: Position) -> String {
    let defined = |word: &str| {
        text.match_indices(&format!("{word} {name}")).any(|(i, hit)| {
            !text[i + hit.len()..].starts_with(|c: char| c.is_alphanumeric() || c == '_')
        })
    };
    if defined("let") || defined("const") {
        let constant =
            if defined("const") { format!("; write global::{name} there") } else { String::new() };
        return format!(
            "`{name}` is not known here: a variable is known after its `let` and in its block, and {FN_SEES}{constant}"
        );
    }
    let mut words: Vec<&str> = text
        .split(|c: char| !(c.is_alphanumeric() || c == '_'))
        .collect::<Vec<_>>()
        .windows(2)
        .filter(|w| w[0] == "let" || w[0] == "const")
        .map(|w| w[1])
        .collect();
    words.extend(["TAU", "PI"]);
    let functions = reference::function_names();
    let rest = around(text, at).1;
    let rest = rest.strip_prefix(name).unwrap_or("");
    if let Some(said) = habits::word(name, rest) {
        return format!("`{name}` is not known: {said}");
    }
    if functions.contains(&name) {
        let usage = reference::usage(name).unwrap_or_else(|| format!("{name}(...)"));
        return format!("`{name}` is a function: write {usage}");
    }
    words.extend(functions);
    format!("`{name}` is not known{}", names::did_you_mean(name, words.into_iter()))
}

/// A run-time error of Rhai's own in words.
fn run_message(error: &EvalAltResult, script: &Script<'_>) -> String {
    match error {
        EvalAltResult::ErrorVariableNotFound(name, at) => unknown_variable(name, script.text, *at),
        EvalAltResult::ErrorFunctionNotFound(signature, at) => {
            unknown_function(signature, script, *at)
        }
        EvalAltResult::ErrorDotExpr(name, _) if name.starts_with("Unknown property '") => {
            let lengths = ["length", "size", "count"];
            let property = name.split('\'').nth(1).unwrap_or("");
            let of = name.rsplit('\'').nth(1).map_or(String::new(), type_words);
            match property {
                p if lengths.contains(&p) => format!("{of} has no `{p}`: write x.len()"),
                "x" | "y" | "z" | "r" | "g" | "b" if of == "an array" => {
                    format!("an array has no `{property}`: write vec3(list).{property}, or list[0]")
                }
                p => format!("{of} has no `{p}`"),
            }
        }
        EvalAltResult::ErrorStackOverflow(_) => format!(
            "calls nest deeper than {}: a recursion without an end?",
            crate::engine::CALL_LEVELS
        ),
        EvalAltResult::ErrorAssignmentToConstant(name, _) => {
            format!("`{name}` is a constant and cannot be written")
        }
        EvalAltResult::ErrorDataRace(_, _) => {
            "a variable is read while the same statement writes it: take a copy with `let` first"
                .into()
        }
        EvalAltResult::ErrorUnboundThis(_) => {
            "`this` is known only in a function that is called as a method".into()
        }
        EvalAltResult::ErrorFor(_) => {
            "`for` takes a range such as 0..10, an array or a string; of a map m write m.keys() or m.values()".into()
        }
        EvalAltResult::ErrorMismatchDataType(wanted, got, _) if !wanted.is_empty() => {
            format!("expected {}, got {}", type_words(wanted), type_words(got))
        }
        other => {
            // Rhai ends its text with the position, which stands in front of ours.
            let said = other.to_string();
            let cut = said.rfind(" (line ").unwrap_or(said.len());
            lower(&said[..cut])
        }
    }
}

/// `sphere (i64)` in words.
fn unknown_function(signature: &str, script: &Script<'_>, at: Position) -> String {
    let (name, types) = signature.split_once(" (").unwrap_or((signature, ""));
    let types = types.trim_end_matches(')');
    let words: Vec<String> = types
        .split(", ")
        .filter(|t| !t.is_empty())
        .map(|t| type_words(t.trim_start_matches("&mut ")))
        .collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    if !name.starts_with(|c: char| c.is_alphabetic() || c == '_') {
        let instead = operators::instead(name).map(|w| format!(": {w}")).unwrap_or_default();
        return match words.as_slice() {
            ["true or false", b] if *b != "true or false" && name.starts_with(['<', '>']) => {
                format!("`{name}` does not go between true or false and {b}: write a < b && b < c")
            }
            [a, b] if operators::COMPARISONS.contains(&name) && a != b => {
                format!("`{name}` does not go between {a} and {b}: compare values of one kind")
            }
            [a, b] => format!("`{name}` does not go between {a} and {b}{instead}"),
            _ => format!("`{name}` does not go with {}{instead}", names::listed(&words)),
        };
    }
    let given = if words.is_empty() { "nothing".into() } else { names::listed(&words) };
    if name == "print" || name == "debug" {
        return format!(
            "`{name}` takes one value: write {name}([a, b]) or {name}(`${{a}} ${{b}}`)"
        );
    }
    if name == "range" && !words.iter().any(|w| w.contains("stream")) {
        return "`range` is a method of random streams: a range of whole numbers is 0..10".into();
    }
    if let Some(usage) = reference::usage(name) {
        let map = if words == ["nothing, ()"] && usage.contains("#{") {
            "; a map is written #{ ... }"
        } else {
            ""
        };
        return format!("`{name}` is called as {usage}, got {given}{map}");
    }
    let called = around(script.text, at).1.strip_prefix(name).unwrap_or("");
    if is_variable(script.text, name) {
        let call: String = called.chars().take_while(|c| *c != ')' && *c != '\n').collect();
        return format!(
            "`{name}` is a variable: a function in it is called with `call`: write {name}.call{call})"
        );
    }
    let own: Vec<&str> = script
        .text
        .split("fn ")
        .skip(1)
        .filter_map(|rest| rest.split('(').next())
        .map(str::trim)
        .filter(|own| own.chars().all(|c| c.is_alphanumeric() || c == '_'))
        .collect();
    if own.contains(&name) {
        return format!("the function `{name}` does not take {given}: count its parameters");
    }
    if ["eval", "sleep", "timestamp", "exit", "open_file", "import"].contains(&name) {
        return format!("`{name}` is not part of scene scripts");
    }
    let registered = reference::registered(script.engine);
    if let Some(said) = habits::word(name, called).filter(|_| !registered.contains(name)) {
        return format!("there is no function `{name}`: {said}");
    }
    let known = own.into_iter().chain(registered.iter().map(String::as_str));
    if registered.contains(name) {
        return format!("`{name}` does not take {given}");
    }
    format!("there is no function `{name}` that takes {given}{}", names::did_you_mean(name, known))
}

/// Whether a script defines a variable or a parameter of this name.
fn is_variable(text: &str, name: &str) -> bool {
    let starts = [format!("let {name}"), format!("|{name}"), format!("const {name}")];
    starts.iter().any(|start| {
        text.match_indices(start).any(|(i, hit)| {
            !text[i + hit.len()..].starts_with(|c: char| c.is_alphanumeric() || c == '_')
        })
    })
}

/// Rhai's names of types in words.
fn type_words(name: &str) -> String {
    match name {
        "i64" => "a whole number",
        "f64" => "a float",
        "string" | "&str | ImmutableString | String" => "a string",
        "char" => "a character",
        "bool" => "true or false",
        "array" => "an array",
        "map" => "a map",
        "Fn" => "a function",
        "()" => "nothing, ()",
        "vec3" => "a vec3",
        "handle" => "a handle",
        "random" => "a random stream",
        "frame" => "a frame",
        "hit point" => "a hit point",
        other => return other.to_owned(),
    }
    .to_owned()
}

fn lower(said: &str) -> String {
    let mut chars = said.chars();
    match chars.next() {
        Some(first) => first.to_lowercase().chain(chars).collect(),
        None => String::new(),
    }
}
