//! What is wrong with a noun.

/// A property with a value that the model has no picture for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The property's name as a script writes it, for example `radius`.
    pub property: &'static str,
    /// What is wrong and what it takes, for example `must be above 0 (also after rounding to f32)`.
    pub message: String,
}

impl Fault {
    /// A fault of `property`.
    pub fn new(property: &'static str, message: impl Into<String>) -> Self {
        Self { property, message: message.into() }
    }
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "`{}` {}", self.property, self.message)
    }
}

impl std::error::Error for Fault {}

/// `Ok` if all of `v` is finite as an `f32`.
pub(crate) fn finite(property: &'static str, v: &[f64]) -> Result<(), Fault> {
    if v.iter().all(|x| (*x as f32).is_finite()) {
        Ok(())
    } else {
        Err(Fault::new(property, "must be finite, and within the range of f32"))
    }
}

/// `Ok` if `x` is finite and above 0, also after rounding to `f32`.
pub(crate) fn positive(property: &'static str, x: f64) -> Result<(), Fault> {
    finite(property, &[x])?;
    if (x as f32) > 0.0 {
        Ok(())
    } else {
        Err(Fault::new(property, "must be above 0 (also after rounding to f32)"))
    }
}

/// `Ok` if `v` is finite and has a direction: its length is a normal `f32`.
pub(crate) fn direction(property: &'static str, v: glam::DVec3) -> Result<(), Fault> {
    finite(property, &v.to_array())?;
    if (v.length() as f32).is_normal() {
        Ok(())
    } else {
        Err(Fault::new(property, "must not be zero (also after rounding to f32)"))
    }
}

/// Whether two vectors are parallel as far as `f32` can tell (also when one is zero).
pub(crate) fn parallel(a: glam::DVec3, b: glam::DVec3) -> bool {
    let (la, lb) = (a.length(), b.length());
    // The sine of the angle between them, against an ulp of f32: below it no frame can be built.
    !(la > 0.0 && lb > 0.0 && (a / la).cross(b / lb).length() > f64::from(f32::EPSILON))
}
