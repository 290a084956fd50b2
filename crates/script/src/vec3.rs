//! `vec3`, the vector and the colour of scripts, with its operators.

use crate::trouble::{Fallible, trouble};
use crate::{symbolic, value};
use glam::DVec3;
use rhai::{Array, Dynamic, Engine};

/// Three numbers: a point, a direction, or a linear colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Vec3(pub DVec3);

impl std::fmt::Display for Vec3 {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let DVec3 { x, y, z } = self.0;
        write!(f, "vec3({x}, {y}, {z})")
    }
}

impl From<DVec3> for Vec3 {
    fn from(v: DVec3) -> Self {
        Vec3(v)
    }
}

/// What stands on one side of an operator.
trait Operand: Clone + Send + Sync + 'static {
    fn vector(self, sign: &str) -> Fallible<DVec3>;
}

impl Operand for Vec3 {
    fn vector(self, _: &str) -> Fallible<DVec3> {
        Ok(self.0)
    }
}

impl Operand for f64 {
    fn vector(self, _: &str) -> Fallible<DVec3> {
        Ok(DVec3::splat(self))
    }
}

impl Operand for i64 {
    fn vector(self, _: &str) -> Fallible<DVec3> {
        Ok(DVec3::splat(self as f64))
    }
}

impl Operand for Array {
    fn vector(self, sign: &str) -> Fallible<DVec3> {
        value::array_vector(&self).ok_or_else(|| {
            trouble(format!(
                "`{sign}` with an array takes three numbers, got {}",
                value::describe(&Dynamic::from_array(self))
            ))
        })
    }
}

macro_rules! binary {
    ($engine:ident, $sign:literal, $left:ty, $right:ty) => {
        $engine.register_fn($sign, |a: $left, b: $right| -> Fallible<Vec3> {
            let (a, b) = (a.vector($sign)?, b.vector($sign)?);
            Ok(Vec3(apply($sign, a, b)))
        });
    };
}

/// One operator, component by component.
fn apply(sign: &str, a: DVec3, b: DVec3) -> DVec3 {
    match sign {
        "+" => a + b,
        "-" => a - b,
        "*" => a * b,
        _ => a / b,
    }
}

macro_rules! assign {
    ($engine:ident, $sign:literal, $base:literal, $right:ty) => {
        $engine.register_fn($sign, |a: &mut Vec3, b: $right| -> Fallible<()> {
            a.0 = apply($base, a.0, b.vector($base)?);
            Ok(())
        });
    };
}

/// What `array + array` and `array += x` say.
const ARRAY_SUM: &str = "arrays do not add: write vec3(...) for a sum of vectors, `push` or `append` to make an array longer";

/// Registers the type and its operators.
pub(crate) fn register(engine: &mut Engine) {
    engine.register_type_with_name::<Vec3>("vec3");
    engine.register_fn("vec3", |x: Dynamic, y: Dynamic, z: Dynamic| -> Fallible<Dynamic> {
        if symbolic::any_symbolic(&[&x, &y, &z]) {
            return symbolic::three([&x, &y, &z]);
        }
        let at = |v: &Dynamic| value::need_number("vec3", v);
        Ok(Dynamic::from(Vec3(DVec3::new(at(&x)?, at(&y)?, at(&z)?))))
    });
    engine.register_fn("vec3", |v: Dynamic| -> Fallible<Vec3> {
        value::need_colour("vec3", &v).map(Vec3)
    });
    macro_rules! all {
        ($($sign:literal $assign:literal),+) => {$(
            binary!(engine, $sign, Vec3, Vec3);
            binary!(engine, $sign, Vec3, f64);
            binary!(engine, $sign, Vec3, i64);
            binary!(engine, $sign, Vec3, Array);
            binary!(engine, $sign, f64, Vec3);
            binary!(engine, $sign, i64, Vec3);
            binary!(engine, $sign, Array, Vec3);
            assign!(engine, $assign, $sign, Vec3);
            assign!(engine, $assign, $sign, f64);
            assign!(engine, $assign, $sign, i64);
            assign!(engine, $assign, $sign, Array);
        )+};
    }
    all!("+" "+=", "-" "-=", "*" "*=", "/" "/=");
    binary!(engine, "-", Array, Array);
    binary!(engine, "*", Array, Array);
    binary!(engine, "/", Array, Array);
    binary!(engine, "*", Array, f64);
    binary!(engine, "*", Array, i64);
    binary!(engine, "*", f64, Array);
    binary!(engine, "*", i64, Array);
    binary!(engine, "/", Array, f64);
    binary!(engine, "/", Array, i64);
    engine.register_fn("-", |v: Vec3| Vec3(-v.0));
    engine.register_fn("+", |v: Vec3| v);
    engine.register_fn("-", |v: Array| -> Fallible<Vec3> { Ok(Vec3(-v.vector("-")?)) });
    engine.register_fn("+", |_: Array, _: Array| -> Fallible<Vec3> { Err(trouble(ARRAY_SUM)) });
    engine.register_fn("+=", |_: &mut Array, _: Array| -> Fallible<()> { Err(trouble(ARRAY_SUM)) });
    engine.register_fn("+=", |_: &mut Array, _: Vec3| -> Fallible<()> { Err(trouble(ARRAY_SUM)) });
    engine.register_fn("+=", |_: &mut Array, _: f64| -> Fallible<()> { Err(trouble(ARRAY_SUM)) });
    engine.register_fn("+=", |_: &mut Array, _: i64| -> Fallible<()> { Err(trouble(ARRAY_SUM)) });
    engine
        .register_fn("+=", |_: &mut Array, _: Dynamic| -> Fallible<()> { Err(trouble(ARRAY_SUM)) });
    engine.register_fn("==", |a: Vec3, b: Vec3| a == b);
    engine.register_fn("!=", |a: Vec3, b: Vec3| a != b);
    engine.register_fn("==", |a: Vec3, b: Array| value::array_vector(&b) == Some(a.0));
    engine.register_fn("!=", |a: Vec3, b: Array| value::array_vector(&b) != Some(a.0));
    engine.register_fn("==", |a: Array, b: Vec3| value::array_vector(&a) == Some(b.0));
    engine.register_fn("!=", |a: Array, b: Vec3| value::array_vector(&a) != Some(b.0));
    for (name, axis) in [("x", 0usize), ("y", 1), ("z", 2), ("r", 0), ("g", 1), ("b", 2)] {
        engine.register_get(name, move |v: &mut Vec3| v.0[axis]);
        engine.register_set(name, move |v: &mut Vec3, to: Dynamic| -> Fallible<()> {
            v.0[axis] = value::need_number(name, &to)?;
            Ok(())
        });
    }
    let outside = |index: i64| trouble(format!("a vec3 has the numbers 0, 1 and 2, no {index}"));
    engine.register_indexer_get(move |v: &mut Vec3, index: i64| -> Fallible<f64> {
        usize::try_from(index).ok().filter(|i| *i < 3).map(|i| v.0[i]).ok_or_else(|| outside(index))
    });
    engine.register_indexer_set(move |v: &mut Vec3, index: i64, to: Dynamic| -> Fallible<()> {
        let axis = usize::try_from(index).ok().filter(|i| *i < 3).ok_or_else(|| outside(index))?;
        v.0[axis] = value::need_number("vec3", &to)?;
        Ok(())
    });
    let unknown =
        |name: &str| trouble(format!("a vec3 has no `{name}`; it has x, y, z and r, g, b"));
    engine.register_indexer_get(move |_: &mut Vec3, name: &str| -> Fallible<f64> {
        Err(unknown(name))
    });
    engine.register_indexer_set(move |_: &mut Vec3, name: &str, _: Dynamic| -> Fallible<()> {
        Err(unknown(name))
    });
    engine.register_fn("to_string", |v: &mut Vec3| v.to_string());
    engine.register_fn("to_debug", |v: &mut Vec3| v.to_string());
}
