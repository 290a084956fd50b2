//! What a native function says is wrong; `locate` later finds the place.

use rhai::{Dynamic, Engine, EvalAltResult, Position};

/// The result of a function that scripts call.
pub(crate) type Fallible<T> = Result<T, Box<EvalAltResult>>;

/// What is to blame besides the script itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Blame {
    /// The script.
    Script,
    /// A value given from outside, by `--set`.
    Set,
    /// A file that the script reads.
    File,
}

/// One thing that is wrong, carried through Rhai as the value of a run-time error.
#[derive(Clone, Debug)]
pub(crate) struct Trouble {
    /// What is wrong and what would be right, without the place.
    pub message: String,
    /// The keys that lead to the culprit in the map given to a maker; empty: the call itself.
    pub path: Vec<&'static str>,
    /// An unknown key, as the script spells it, at the end of `path`.
    pub unknown: Option<String>,
    /// Another key that clashes with `unknown`, and what is wrong if it is the later of the two.
    pub rival: Option<Box<(String, String)>>,
    /// Who is to blame.
    pub blame: Blame,
    /// A place that is known already, before the place of the call.
    pub place: Position,
}

impl Trouble {
    /// Trouble with a call as a whole.
    pub fn new(message: impl Into<String>) -> Self {
        Self {
            message: message.into(),
            path: Vec::new(),
            unknown: None,
            rival: None,
            blame: Blame::Script,
            place: Position::NONE,
        }
    }

    /// Trouble with the value of `key`.
    pub fn with_key(key: &'static str, message: impl Into<String>) -> Self {
        Self { path: vec![key], ..Self::new(message) }
    }

    /// The same trouble, inside the map that is the value of `key`.
    pub fn inside(mut self, key: &'static str) -> Self {
        self.path.insert(0, key);
        self
    }

    /// The same trouble, with its place known.
    pub fn at(mut self, place: Position) -> Self {
        self.place = place;
        self
    }
}

impl From<Trouble> for Box<EvalAltResult> {
    fn from(trouble: Trouble) -> Self {
        let place = trouble.place;
        EvalAltResult::ErrorRuntime(Dynamic::from(trouble), place).into()
    }
}

/// An error with a message only; Rhai adds the position of the call.
pub(crate) fn trouble(message: impl Into<String>) -> Box<EvalAltResult> {
    Trouble::new(message).into()
}

/// An error that a script cannot catch: a limit was reached.
pub(crate) fn limit(message: impl Into<String>) -> Box<EvalAltResult> {
    ended(Trouble::new(message))
}

/// An error that a script cannot catch.
pub(crate) fn ended(trouble: Trouble) -> Box<EvalAltResult> {
    EvalAltResult::ErrorTerminated(Dynamic::from(trouble), Position::NONE).into()
}

/// Registers the type, so that a script's `catch` can print what it caught.
pub(crate) fn register(engine: &mut Engine) {
    engine.register_type_with_name::<Trouble>("error");
    engine.register_fn("to_string", |t: &mut Trouble| t.message.clone());
    engine.register_fn("to_debug", |t: &mut Trouble| t.message.clone());
    engine.register_get("message", |t: &mut Trouble| t.message.clone());
}
