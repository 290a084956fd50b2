//! Three f64s: a point, a direction or a colour.

use std::ops::{Add, AddAssign, Div, Index, Mul, Neg, Sub};

/// A point, a direction or a colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vec3(pub [f64; 3]);

/// Short for [`Vec3`].
pub const fn v3(x: f64, y: f64, z: f64) -> Vec3 {
    Vec3([x, y, z])
}

impl Vec3 {
    pub const ZERO: Vec3 = v3(0.0, 0.0, 0.0);

    pub const fn splat(x: f64) -> Vec3 {
        v3(x, x, x)
    }

    pub fn map(self, f: impl Fn(f64) -> f64) -> Vec3 {
        v3(f(self[0]), f(self[1]), f(self[2]))
    }

    pub fn zip(self, o: Vec3, f: impl Fn(f64, f64) -> f64) -> Vec3 {
        v3(f(self[0], o[0]), f(self[1], o[1]), f(self[2], o[2]))
    }

    pub fn dot(self, o: Vec3) -> f64 {
        self[0] * o[0] + self[1] * o[1] + self[2] * o[2]
    }

    pub fn cross(self, o: Vec3) -> Vec3 {
        v3(
            self[1] * o[2] - self[2] * o[1],
            self[2] * o[0] - self[0] * o[2],
            self[0] * o[1] - self[1] * o[0],
        )
    }

    pub fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    pub fn unit(self) -> Vec3 {
        self / self.length()
    }

    /// The largest of the absolute values.
    pub fn largest(self) -> f64 {
        self.0.iter().fold(0.0, |m, x| if x.is_nan() { f64::NAN } else { x.abs().max(m) })
    }

    pub fn is_finite(self) -> bool {
        self.0.iter().all(|x| x.is_finite())
    }
}

impl Index<usize> for Vec3 {
    type Output = f64;
    fn index(&self, i: usize) -> &f64 {
        &self.0[i]
    }
}

impl Add for Vec3 {
    type Output = Vec3;
    fn add(self, o: Vec3) -> Vec3 {
        self.zip(o, |a, b| a + b)
    }
}

impl AddAssign for Vec3 {
    fn add_assign(&mut self, o: Vec3) {
        *self = *self + o;
    }
}

impl Sub for Vec3 {
    type Output = Vec3;
    fn sub(self, o: Vec3) -> Vec3 {
        self.zip(o, |a, b| a - b)
    }
}

impl Mul<f64> for Vec3 {
    type Output = Vec3;
    fn mul(self, s: f64) -> Vec3 {
        self.map(|a| a * s)
    }
}

impl Div<f64> for Vec3 {
    type Output = Vec3;
    fn div(self, s: f64) -> Vec3 {
        self.map(|a| a / s)
    }
}

impl Neg for Vec3 {
    type Output = Vec3;
    fn neg(self) -> Vec3 {
        self.map(|a| -a)
    }
}
