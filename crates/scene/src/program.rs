//! Reflectivities as expressions of where a ray hit: what a script's shader function recorded.

use crate::key::Key;
use std::sync::Arc;

/// What an expression can start from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coordinate {
    /// The hit point, before groups and instances move it.
    X,
    /// See [`Coordinate::X`].
    Y,
    /// See [`Coordinate::X`].
    Z,
    /// The surface's own coordinates.
    U,
    /// See [`Coordinate::U`].
    V,
    /// The unit normal there, turned to face the incoming ray.
    NormalX,
    /// See [`Coordinate::NormalX`].
    NormalY,
    /// See [`Coordinate::NormalX`].
    NormalZ,
}

impl Coordinate {
    /// All of them, each at the index that it is as a number.
    pub const ALL: [Coordinate; 8] = [
        Coordinate::X,
        Coordinate::Y,
        Coordinate::Z,
        Coordinate::U,
        Coordinate::V,
        Coordinate::NormalX,
        Coordinate::NormalY,
        Coordinate::NormalZ,
    ];
}

/// A function of one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unary {
    /// -x.
    Negate,
    /// The absolute value.
    Abs,
    /// The square root.
    Sqrt,
    /// The greatest whole number not above x.
    Floor,
    /// Of radians.
    Sin,
    /// Of radians.
    Cos,
    /// In radians.
    Acos,
}

/// A function of two numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Binary {
    /// a + b.
    Add,
    /// a - b.
    Subtract,
    /// a b.
    Multiply,
    /// a / b.
    Divide,
    /// a if it is less, else b.
    Min,
    /// a if it is greater, else b.
    Max,
    /// 1 where b >= a, else 0.
    Step,
}

/// One step of a program; numbers that it takes are those of earlier steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Op {
    /// A number.
    Constant(f32),
    /// Where the ray hit.
    Coordinate(Coordinate),
    /// A function of one number.
    Unary(Unary, u32),
    /// A function of two numbers.
    Binary(Binary, u32, u32),
    /// Gradient noise at three coordinates, from -1 to 1.
    Noise([u32; 3]),
}

/// Steps in order, and which of them are red, green and blue.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    /// The steps.
    pub ops: Vec<Op>,
    /// The results.
    pub colour: [u32; 3],
}

impl Program {
    /// The most steps.
    pub const LONGEST: usize = 65_536;

    /// All of it as bits.
    pub fn bits(&self) -> Vec<u32> {
        let mut bits = self.colour.to_vec();
        for op in &self.ops {
            bits.extend(match *op {
                Op::Constant(x) => [0, x.to_bits(), 0, 0],
                Op::Coordinate(c) => [1, c as u32, 0, 0],
                Op::Unary(f, a) => [2, f as u32, a, 0],
                Op::Binary(f, a, b) => [3 + f as u32, a, b, 0],
                Op::Noise([x, y, z]) => [100, x, y, z],
            });
        }
        bits
    }
}

/// A material some of whose reflectivities are expressions.
#[derive(Clone, Debug, PartialEq)]
pub struct Shader {
    /// The material, for what is not given here.
    pub base: Key,
    /// Light given off.
    pub ambient: Option<Arc<Program>>,
    /// The share of a light that is scattered.
    pub diffuse: Option<Arc<Program>>,
    /// The share of the mirrored ray.
    pub specular: Option<Arc<Program>>,
}
