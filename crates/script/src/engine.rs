//! The Rhai engine: what of it scripts can reach, and its limits.

use crate::meter::Meter;
use crate::state::Shared;
use crate::{
    guard, handle, helpers, maths, operators, params, placed, random, state, symbolic, time,
    trouble, vec3, wardrobe,
};
use rhai::packages::{
    ArithmeticPackage, BasicArrayPackage, BasicFnPackage, BasicIteratorPackage, BasicMapPackage,
    BasicMathPackage, BasicStringPackage, LogicPackage, MoreStringPackage, Package,
};
use rhai::{
    AST, Dynamic, Engine, FnPtr, LexError, Module, OptimizationLevel, Position, Scope, Token,
};
use std::sync::{Arc, Mutex, PoisonError};

/// How deep calls may nest: about 10 KB of stack each.
pub(crate) const CALL_LEVELS: usize = 256;
/// How deep expressions may nest.
const EXPRESSION_DEPTH: usize = 128;

/// Where `print` and `debug` go: the text and its line.
pub type Printer = Arc<dyn Fn(&str, usize) + Send + Sync>;

/// What is known of a script while its tokens are read.
///
/// Rhai looks every name up in a list of all variables in scope, and every key of a map literal in
/// a list of those before it, so a script of many takes time in the square of their number. The
/// steps are estimated, and bounded.
#[derive(Default)]
struct Reading {
    /// The variables in scope.
    variables: u64,
    /// The open blocks and map literals.
    open: Vec<Open>,
    /// The functions so far, closures among them; each is looked up among all.
    functions: u64,
    steps: u64,
    /// Whether a minus stands before the operand that is being read, and before those around each
    /// open bracket.
    negated: bool,
    around: Vec<bool>,
    /// Whether the last token was a minus that negates.
    minus: bool,
}

/// What a brace opened.
enum Open {
    /// A block, and how many variables there were where it began.
    Block(u64),
    /// A map literal, and its keys so far.
    Map(u64),
}

impl Reading {
    /// The most steps: some seconds.
    const STEPS: u64 = 400_000_000;

    /// Follows the tokens of operands; whether this one raises to a power what a minus stands
    /// before without brackets.
    fn power_of_negated(&mut self, token: &Token) -> bool {
        let minus = std::mem::replace(&mut self.minus, matches!(token, Token::UnaryMinus));
        match token {
            Token::PowerOf => return std::mem::take(&mut self.negated),
            Token::IntegerConstant(x) => self.negated = minus || *x < 0,
            Token::FloatConstant(x) => self.negated = minus || x.1.starts_with('-'),
            Token::LeftParen | Token::LeftBracket | Token::LeftBrace | Token::MapStart => {
                self.around.push(self.negated || minus);
                self.negated = false;
            }
            Token::RightParen | Token::RightBracket | Token::RightBrace => {
                self.negated = self.around.pop().unwrap_or(false);
            }
            Token::Identifier(_) => self.negated |= minus,
            Token::Period | Token::Unit => {}
            _ => self.negated = false,
        }
        false
    }

    fn token(&mut self, token: Token, at: Position) -> Token {
        if at.line() == Some(1) && at.position() == Some(1) {
            *self = Self::default();
        }
        if self.power_of_negated(&token) {
            let ask = "`-` comes before `**` here, so that -2 ** 2 would be 4: write -(2 ** 2), or (-2) ** 2";
            return Token::LexError(Box::new(LexError::ImproperSymbol("**".into(), ask.into())));
        }
        match token {
            Token::Let | Token::Const => self.variables += 1,
            Token::LeftBrace => self.open.push(Open::Block(self.variables)),
            Token::MapStart => self.open.push(Open::Map(0)),
            Token::RightBrace => match self.open.pop() {
                Some(Open::Block(variables)) => self.variables = variables,
                Some(Open::Map(_)) => {}
                None => self.variables = 0,
            },
            Token::Fn | Token::Pipe | Token::Or => {
                self.functions += 1;
                self.steps += 4 * self.functions;
                if self.steps > Self::STEPS {
                    let many = format!(
                        "{} functions are too many for a script: call one in a loop",
                        self.functions
                    );
                    return refused("fn", many);
                }
            }
            Token::Colon => {
                if let Some(Open::Map(keys)) = self.open.last_mut() {
                    *keys += 1;
                    self.steps += 4 * *keys;
                    if self.steps > Self::STEPS {
                        let many = format!(
                            "{keys} keys are too many for a map that is written out: fill it in a loop, or use arrays"
                        );
                        return refused(":", many);
                    }
                }
            }
            Token::Identifier(name) => {
                self.steps += self.variables;
                if self.steps > Self::STEPS {
                    let many = format!(
                        "{} variables are too many for a script of this length: keep values in arrays or maps",
                        self.variables
                    );
                    return refused(&name, many);
                }
                return match name.as_str() {
                    "TAU" => constant("TAU", std::f64::consts::TAU),
                    "PI" => constant("PI", std::f64::consts::PI),
                    _ => Token::Identifier(name),
                };
            }
            _ => {}
        }
        token
    }
}

/// A token that is an error.
fn refused(token: &str, why: String) -> Token {
    Token::LexError(Box::new(LexError::ImproperSymbol(token.to_owned(), why)))
}

/// A number with a name.
fn constant(name: &str, value: f64) -> Token {
    Token::FloatConstant(Box::new((value.into(), name.into())))
}

/// Builds the engine around a state.
#[allow(deprecated)] // The token mapper is "volatile", says Rhai; its version is pinned.
pub(crate) fn build(state: &Shared, meter: &Arc<Meter>, print: Printer) -> Engine {
    let mut engine = Engine::new_raw();
    // LanguageCore (sleep, exit), BasicTime, BasicBlob and BitField stay out.
    ArithmeticPackage::new().register_into_engine(&mut engine);
    LogicPackage::new().register_into_engine(&mut engine);
    BasicStringPackage::new().register_into_engine(&mut engine);
    MoreStringPackage::new().register_into_engine(&mut engine);
    BasicIteratorPackage::new().register_into_engine(&mut engine);
    BasicArrayPackage::new().register_into_engine(&mut engine);
    BasicMapPackage::new().register_into_engine(&mut engine);
    BasicFnPackage::new().register_into_engine(&mut engine);
    BasicMathPackage::new().register_into_engine(&mut engine);
    for symbol in ["eval", "curry", "import", "export"] {
        engine.disable_symbol(symbol);
    }
    // The optimiser folds maps into constants, which lose the positions of their keys, and
    // operators with the platform's `pow`; fast operators would pass by ours.
    engine.set_optimization_level(OptimizationLevel::None);
    engine.set_fast_operators(false);
    engine.set_strict_variables(true);
    engine.set_max_call_levels(CALL_LEVELS);
    engine.set_max_expr_depths(EXPRESSION_DEPTH, EXPRESSION_DEPTH);
    engine.set_max_operations(0);
    let metered = meter.clone();
    engine.on_progress(move |_| metered.step());
    let metered = meter.clone();
    let reading = Mutex::new(Reading::default());
    engine.on_parse_token(move |token, at, _| {
        if metered.is_full() {
            return refused("", "the script takes too long to read, or too much memory".into());
        }
        reading.lock().unwrap_or_else(PoisonError::into_inner).token(token, at)
    });
    engine.on_print(|_| {});
    engine.on_debug(|_, _, _| {});
    guard::register(&mut engine, meter, print);
    trouble::register(&mut engine);
    vec3::register(&mut engine);
    handle::register(&mut engine, state);
    wardrobe::register(&mut engine, state);
    state::register(&mut engine, state);
    placed::register(&mut engine, state);
    operators::register(&mut engine);
    maths::register(&mut engine, state);
    helpers::register(&mut engine);
    symbolic::register(&mut engine);
    random::register(&mut engine, state);
    params::register(&mut engine, state);
    time::register(&mut engine, state);
    let mut values = Module::new();
    for &(name, _) in helpers::EASINGS {
        if let Ok(function) = FnPtr::new(name) {
            values.set_var(name, function);
        }
    }
    engine.register_global_module(values.into());
    engine
}

/// What a script sees before its first line: the easing functions as values.
pub(crate) fn scope() -> Scope<'static> {
    let mut scope = Scope::new();
    for &(name, _) in helpers::EASINGS {
        if let Ok(function) = FnPtr::new(name) {
            scope.push_constant_dynamic(name, Dynamic::from(function));
        }
    }
    scope
}

/// The place of an error that Rhai reports, if it has one.
pub(crate) fn known(place: Position) -> Option<Position> {
    (!place.is_none()).then_some(place)
}

/// Compiles a script.
pub(crate) fn compile(engine: &Engine, text: &str) -> Result<AST, rhai::ParseError> {
    engine.compile_with_scope(&scope(), crate::source::for_rhai(text))
}
