//! Shader functions: called once with coordinates that stand for any hit point, they leave behind the
//! expression that they are.

use crate::trouble::{Fallible, Trouble, trouble};
use crate::value::{describe, number, takes_one, vector};
use crate::vec3::Vec3;
use reflet_scene::Program;
use reflet_scene::program::{Binary, Coordinate, Op, Unary};
use rhai::{Array, Dynamic, Engine, FnPtr, NativeCallContext};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// The steps recorded so far, each once.
#[derive(Default)]
struct Tape {
    ops: Vec<Op>,
    known: HashMap<[u32; 5], u32>,
}

/// A number that depends on the hit point: a step of a tape.
#[derive(Clone)]
pub(crate) struct Symbol {
    tape: Arc<Mutex<Tape>>,
    step: u32,
}

/// Three numbers, at least one of them symbolic.
#[derive(Clone)]
pub(crate) struct SymbolVector([Number; 3]);

/// The hit point, as a shader function sees it.
#[derive(Clone)]
pub(crate) struct HitPoint(Arc<Mutex<Tape>>);

/// What a shader function recorded.
#[derive(Clone)]
pub(crate) struct Recorded(pub Arc<Program>);

/// A number, symbolic or not.
#[derive(Clone)]
enum Number {
    Plain(f64),
    Symbol(Symbol),
}

/// One number or three.
#[derive(Clone)]
enum Numbers {
    One(Number),
    Three([Number; 3]),
}

impl Symbol {
    fn record(tape: &Arc<Mutex<Tape>>, op: Op) -> Fallible<Symbol> {
        let mut t = tape.lock().unwrap_or_else(PoisonError::into_inner);
        let key = match op {
            Op::Constant(x) => [0, x.to_bits(), 0, 0, 0],
            Op::Coordinate(c) => [1, c as u32, 0, 0, 0],
            Op::Unary(f, a) => [2, f as u32, a, 0, 0],
            Op::Binary(f, a, b) => [3, f as u32, a, b, 0],
            Op::Noise([x, y, z]) => [4, x, y, z, 0],
        };
        if let Some(step) = t.known.get(&key) {
            return Ok(Symbol { tape: tape.clone(), step: *step });
        }
        if t.ops.len() >= Program::LONGEST {
            return Err(trouble(format!(
                "a shader function is longer than {} steps: a loop in it is written out",
                Program::LONGEST
            )));
        }
        let step = t.ops.len() as u32;
        t.ops.push(op);
        t.known.insert(key, step);
        Ok(Symbol { tape: tape.clone(), step })
    }
}

impl Number {
    fn tape(&self) -> Option<&Arc<Mutex<Tape>>> {
        match self {
            Number::Plain(_) => None,
            Number::Symbol(s) => Some(&s.tape),
        }
    }

    fn on(&self, tape: &Arc<Mutex<Tape>>) -> Fallible<u32> {
        match self {
            Number::Plain(x) => Symbol::record(tape, Op::Constant(*x as f32)).map(|s| s.step),
            Number::Symbol(s) if Arc::ptr_eq(&s.tape, tape) => Ok(s.step),
            Number::Symbol(_) => {
                Err(trouble("a symbolic value cannot leave the shader function that it came with"))
            }
        }
    }

    fn unary(&self, f: Unary, plain: fn(f64) -> f64) -> Fallible<Number> {
        Ok(match self {
            Number::Plain(x) => Number::Plain(plain(*x)),
            Number::Symbol(s) => Number::Symbol(Symbol::record(&s.tape, Op::Unary(f, s.step))?),
        })
    }

    fn binary(&self, f: Binary, other: &Number) -> Fallible<Number> {
        let Some(tape) = self.tape().or(other.tape()).cloned() else {
            return Ok(Number::Plain(plain(f, self.value(), other.value())));
        };
        let (a, b) = (self.on(&tape)?, other.on(&tape)?);
        Symbol::record(&tape, Op::Binary(f, a, b)).map(Number::Symbol)
    }

    fn value(&self) -> f64 {
        match self {
            Number::Plain(x) => *x,
            Number::Symbol(_) => f64::NAN,
        }
    }

    fn dynamic(self) -> Dynamic {
        match self {
            Number::Plain(x) => x.into(),
            Number::Symbol(s) => Dynamic::from(s),
        }
    }
}

fn plain(f: Binary, a: f64, b: f64) -> f64 {
    match f {
        Binary::Add => a + b,
        Binary::Subtract => a - b,
        Binary::Multiply => a * b,
        Binary::Divide => a / b,
        Binary::Min => {
            if a < b {
                a
            } else {
                b
            }
        }
        Binary::Max => {
            if a > b {
                a
            } else {
                b
            }
        }
        Binary::Step => f64::from(u8::from(b >= a)),
    }
}

impl Numbers {
    /// Any value that is one number or three.
    fn of(value: &Dynamic) -> Option<Numbers> {
        if let Some(x) = one(value) {
            return Some(Numbers::One(x));
        }
        if let Some(v) = value.read_lock::<SymbolVector>() {
            return Some(Numbers::Three(v.0.clone()));
        }
        if let Some(v) = value.read_lock::<Vec3>() {
            return Some(Numbers::Three(v.0.to_array().map(Number::Plain)));
        }
        let array = value.as_array_ref().ok()?;
        match array.as_slice() {
            [x, y, z] => Some(Numbers::Three([one(x)?, one(y)?, one(z)?])),
            _ => None,
        }
    }

    fn need(who: &str, value: &Dynamic) -> Fallible<Numbers> {
        Numbers::of(value).ok_or_else(|| {
            trouble(format!("`{who}` takes a number or three, got {}", describe(value)))
        })
    }

    fn three(&self) -> [Number; 3] {
        match self {
            Numbers::One(x) => [x.clone(), x.clone(), x.clone()],
            Numbers::Three(v) => v.clone(),
        }
    }

    fn map(&self, f: impl Fn(&Number) -> Fallible<Number>) -> Fallible<Numbers> {
        Ok(match self {
            Numbers::One(x) => Numbers::One(f(x)?),
            Numbers::Three([x, y, z]) => Numbers::Three([f(x)?, f(y)?, f(z)?]),
        })
    }

    fn with(&self, f: Binary, other: &Numbers) -> Fallible<Numbers> {
        if let (Numbers::One(a), Numbers::One(b)) = (self, other) {
            return a.binary(f, b).map(Numbers::One);
        }
        let ([a, b, c], [x, y, z]) = (self.three(), other.three());
        Ok(Numbers::Three([a.binary(f, &x)?, b.binary(f, &y)?, c.binary(f, &z)?]))
    }

    /// The sum of the products, component by component.
    fn dot(&self, other: &Numbers) -> Fallible<Numbers> {
        let [x, y, z] = self.with(Binary::Multiply, other)?.three();
        let sum = x.binary(Binary::Add, &y)?.binary(Binary::Add, &z)?;
        Ok(Numbers::One(sum))
    }

    fn dynamic(self) -> Dynamic {
        match self {
            Numbers::One(x) => x.dynamic(),
            Numbers::Three(v) => match &v {
                [Number::Plain(x), Number::Plain(y), Number::Plain(z)] => {
                    Dynamic::from(Vec3(glam::DVec3::new(*x, *y, *z)))
                }
                _ => Dynamic::from(SymbolVector(v)),
            },
        }
    }
}

/// A number or a symbol.
fn one(value: &Dynamic) -> Option<Number> {
    if let Some(s) = value.read_lock::<Symbol>() {
        return Some(Number::Symbol(s.clone()));
    }
    number(value).map(Number::Plain)
}

/// Whether any of some values depends on the hit point.
pub(crate) fn any_symbolic(values: &[&Dynamic]) -> bool {
    let in_array = |v: &Dynamic| {
        v.as_array_ref().is_ok_and(|a| a.iter().any(|x| x.read_lock::<Symbol>().is_some()))
    };
    values.iter().any(|v| {
        v.read_lock::<Symbol>().is_some() || v.read_lock::<SymbolVector>().is_some() || in_array(v)
    })
}

/// The vector of three numbers.
pub(crate) fn three(numbers: [&Dynamic; 3]) -> Fallible<Dynamic> {
    let number = |v: &Dynamic| {
        one(v).ok_or_else(|| trouble(format!("`vec3` takes a number, got {}", describe(v))))
    };
    let [x, y, z] = numbers;
    Ok(Numbers::Three([number(x)?, number(y)?, number(z)?]).dynamic())
}

/// a (1 - t) + b t.
pub(crate) fn mix(a: &Dynamic, b: &Dynamic, t: &Dynamic) -> Fallible<Dynamic> {
    let [a, b, t] = [a, b, t].map(|v| Numbers::need("mix", v));
    let (a, b, t) = (a?, b?, t?);
    let rest = Numbers::One(Number::Plain(1.0)).with(Binary::Subtract, &t)?;
    let sum = a.with(Binary::Multiply, &rest)?.with(Binary::Add, &b.with(Binary::Multiply, &t)?)?;
    Ok(sum.dynamic())
}

/// x, or the bound that it passes.
pub(crate) fn clamp(x: &Dynamic, low: &Dynamic, high: &Dynamic) -> Fallible<Dynamic> {
    let [x, low, high] = [x, low, high].map(|v| Numbers::need("clamp", v));
    Ok(x?.with(Binary::Max, &low?)?.with(Binary::Min, &high?)?.dynamic())
}

/// 0 below e0, 1 above e1, smooth between.
pub(crate) fn smoothstep(e0: &Dynamic, e1: &Dynamic, x: &Dynamic) -> Fallible<Dynamic> {
    let [e0, e1, x] = [e0, e1, x].map(|v| Numbers::need("smoothstep", v));
    let (e0, e1, x) = (e0?, e1?, x?);
    let plain = |x: f64| Numbers::One(Number::Plain(x));
    let width = e1.with(Binary::Subtract, &e0)?;
    let t = x.with(Binary::Subtract, &e0)?.with(Binary::Divide, &width)?;
    let t = t.with(Binary::Max, &plain(0.0))?.with(Binary::Min, &plain(1.0))?;
    let slope = plain(3.0).with(Binary::Subtract, &t.with(Binary::Multiply, &plain(2.0))?)?;
    Ok(t.with(Binary::Multiply, &t)?.with(Binary::Multiply, &slope)?.dynamic())
}

pub(crate) fn dot(a: &Dynamic, b: &Dynamic) -> Fallible<Dynamic> {
    Ok(Numbers::need("dot", a)?.dot(&Numbers::need("dot", b)?)?.dynamic())
}

pub(crate) fn length(v: &Dynamic) -> Fallible<Dynamic> {
    let v = Numbers::need("length", v)?;
    Ok(v.dot(&v)?.map(|x| x.unary(Unary::Sqrt, f64::sqrt))?.dynamic())
}

/// What is left of a division, with the sign of `a`, as `%` of plain numbers has it.
fn remainder(a: &Numbers, b: &Numbers) -> Fallible<Numbers> {
    let [length, of] = [a, b].map(|v| v.map(|x| x.unary(Unary::Abs, f64::abs)));
    let plain = |x: f64| Numbers::One(Number::Plain(x));
    let sign = plain(0.0).with(Binary::Step, a)?.with(Binary::Multiply, &plain(2.0))?;
    let sign = sign.with(Binary::Subtract, &plain(1.0))?;
    modulo(&length?, &of?)?.with(Binary::Multiply, &sign)
}

/// a - b floor(a / b).
fn modulo(a: &Numbers, b: &Numbers) -> Fallible<Numbers> {
    let whole = a.with(Binary::Divide, b)?.map(|x| x.unary(Unary::Floor, f64::floor))?;
    a.with(Binary::Subtract, &b.with(Binary::Multiply, &whole)?)
}

fn noise(at: [&Dynamic; 3]) -> Fallible<Dynamic> {
    let mut numbers = Vec::with_capacity(3);
    for value in at {
        numbers.push(one(value).ok_or_else(|| {
            trouble(format!("`noise` takes three numbers, got {}", describe(value)))
        })?);
    }
    let Some(tape) = numbers.iter().find_map(Number::tape).cloned() else {
        return Err(trouble(
            "`noise` works on a shader function's coordinates only: noise(p.x, p.y, p.z)",
        ));
    };
    let steps = [numbers[0].on(&tape)?, numbers[1].on(&tape)?, numbers[2].on(&tape)?];
    Ok(Dynamic::from(Symbol::record(&tape, Op::Noise(steps))?))
}

/// Calls the shader function that is the value of a key, and gives what it recorded.
pub(crate) fn record(
    ctx: &NativeCallContext,
    key: &'static str,
    function: &FnPtr,
) -> Fallible<Recorded> {
    if !takes_one(ctx, function) {
        let message =
            format!("`{key}` takes a function with one parameter, the hit point: write |p| ...");
        return Err(Trouble::with_key(key, message).into());
    }
    let tape = Arc::new(Mutex::new(Tape::default()));
    let result: Dynamic = function.call_within_context(ctx, (HitPoint(tape.clone()),))?;
    recorded(&tape, &result).map_err(|trouble| trouble.inside(key).into())
}

/// A colour that is the same everywhere.
pub(crate) fn constant(value: &Dynamic) -> Option<Recorded> {
    let tape = Arc::new(Mutex::new(Tape::default()));
    let known = number(value).is_some() || vector(value).is_some();
    known.then(|| recorded(&tape, value).ok()).flatten()
}

fn recorded(tape: &Arc<Mutex<Tape>>, result: &Dynamic) -> Result<Recorded, Trouble> {
    let colour = Numbers::of(result).ok_or_else(|| {
        Trouble::new(format!(
            "a shader function returns a number or three of them, got {}",
            describe(result)
        ))
    })?;
    let mut steps = [0; 3];
    for (step, x) in steps.iter_mut().zip(colour.three()) {
        *step = x.on(tape).map_err(|_| {
            Trouble::new("a symbolic value cannot leave the shader function that it came with")
        })?;
    }
    let ops = tape.lock().unwrap_or_else(PoisonError::into_inner).ops.clone();
    Ok(Recorded(Arc::new(Program { ops, colour: steps })))
}

/// Registers a function of two values for all pairs of types of which one is symbolic.
macro_rules! pairs {
    ($engine:ident, $name:literal, $f:expr, [$($other:ty),+]) => {
        pairs!(@one $engine, $name, $f, Symbol, Symbol);
        pairs!(@one $engine, $name, $f, Symbol, SymbolVector);
        pairs!(@one $engine, $name, $f, SymbolVector, Symbol);
        pairs!(@one $engine, $name, $f, SymbolVector, SymbolVector);
        $(
            pairs!(@one $engine, $name, $f, Symbol, $other);
            pairs!(@one $engine, $name, $f, $other, Symbol);
            pairs!(@one $engine, $name, $f, SymbolVector, $other);
            pairs!(@one $engine, $name, $f, $other, SymbolVector);
        )+
    };
    (@one $engine:ident, $name:literal, $f:expr, $a:ty, $b:ty) => {
        $engine.register_fn($name, |a: $a, b: $b| -> Fallible<Dynamic> {
            let (a, b) = (Dynamic::from(a), Dynamic::from(b));
            let (a, b) = (Numbers::need($name, &a)?, Numbers::need($name, &b)?);
            let f: fn(&Numbers, &Numbers) -> Fallible<Numbers> = $f;
            f(&a, &b).map(Numbers::dynamic)
        });
    };
}

macro_rules! refused {
    ($engine:ident, $($name:literal),+) => {
        $(pairs!($engine, $name, |_, _| Err(trouble(concat!(
            "`", $name, "` cannot compare symbolic values, which stand for all points at once: write step(edge, x) for 0 or 1, and mix(a, b, t) to choose"
        ))), [f64, i64, Vec3, Array]);)+
    };
}

macro_rules! unary {
    ($engine:ident, $($name:literal: $op:ident, $plain:expr;)+) => {
        $(
            $engine.register_fn($name, |x: Symbol| -> Fallible<Dynamic> {
                Number::Symbol(x).unary(Unary::$op, $plain).map(Number::dynamic)
            });
            $engine.register_fn($name, |v: SymbolVector| -> Fallible<Dynamic> {
                let v = Numbers::Three(v.0);
                v.map(|x| x.unary(Unary::$op, $plain)).map(Numbers::dynamic)
            });
        )+
    };
}

/// Registers the types, their coordinates, operators and functions.
pub(crate) fn register(engine: &mut Engine) {
    engine.register_type_with_name::<Symbol>("symbolic number");
    engine.register_type_with_name::<SymbolVector>("symbolic vector");
    engine.register_type_with_name::<HitPoint>("hit point");
    let names = ["x", "y", "z", "u", "v"];
    for (name, coordinate) in names.into_iter().zip(Coordinate::ALL) {
        engine.register_get(name, move |p: &mut HitPoint| -> Fallible<Symbol> {
            Symbol::record(&p.0, Op::Coordinate(coordinate))
        });
    }
    engine.register_get("normal", |p: &mut HitPoint| -> Fallible<SymbolVector> {
        let at = |c| Symbol::record(&p.0, Op::Coordinate(c)).map(Number::Symbol);
        let [x, y, z] = [Coordinate::NormalX, Coordinate::NormalY, Coordinate::NormalZ].map(at);
        Ok(SymbolVector([x?, y?, z?]))
    });
    for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
        engine.register_get(name, move |v: &mut SymbolVector| v.0[k].clone().dynamic());
    }
    pairs!(engine, "+", |a, b| a.with(Binary::Add, b), [f64, i64, Vec3, Array]);
    pairs!(engine, "-", |a, b| a.with(Binary::Subtract, b), [f64, i64, Vec3, Array]);
    pairs!(engine, "*", |a, b| a.with(Binary::Multiply, b), [f64, i64, Vec3, Array]);
    pairs!(engine, "/", |a, b| a.with(Binary::Divide, b), [f64, i64, Vec3, Array]);
    pairs!(engine, "%", remainder, [f64, i64, Vec3, Array]);
    pairs!(engine, "min", |a, b| a.with(Binary::Min, b), [f64, i64, Vec3, Array]);
    pairs!(engine, "max", |a, b| a.with(Binary::Max, b), [f64, i64, Vec3, Array]);
    refused!(engine, "<", "<=", ">", ">=", "==", "!=");
    unary!(engine,
        "-": Negate, |x| -x;
        "abs": Abs, f64::abs;
        "sqrt": Sqrt, f64::sqrt;
        "floor": Floor, f64::floor;
        "sin": Sin, libm::sin;
        "cos": Cos, libm::cos;
        "acos": Acos, libm::acos;
    );
    engine.register_fn("mod", |a: Dynamic, b: Dynamic| -> Fallible<Dynamic> {
        let (a, b) = (Numbers::need("mod", &a)?, Numbers::need("mod", &b)?);
        modulo(&a, &b).map(Numbers::dynamic)
    });
    engine.register_fn("step", |edge: Dynamic, x: Dynamic| -> Fallible<Dynamic> {
        let (edge, x) = (Numbers::need("step", &edge)?, Numbers::need("step", &x)?);
        edge.with(Binary::Step, &x).map(Numbers::dynamic)
    });
    engine.register_fn("mix", |a: Dynamic, b: Dynamic, t: Dynamic| mix(&a, &b, &t));
    engine.register_fn("noise", |x: Dynamic, y: Dynamic, z: Dynamic| noise([&x, &y, &z]));
}
