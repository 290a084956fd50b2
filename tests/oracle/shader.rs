//! Shaders: expressions of a point, each as a closure and as the same expression in the script.

use super::scene::Material;
use super::vec3::{Vec3, v3};

/// What an expression sees.
#[derive(Clone, Copy, Debug)]
pub struct Spot {
    pub p: Vec3,
    pub u: f64,
    pub v: f64,
    pub normal: Vec3,
}

/// An expression with four numbers, in the script `k0` to `k3`.
pub struct Code {
    pub script: &'static str,
    pub value: fn(&Spot, [f64; 4]) -> Vec3,
}

impl std::fmt::Debug for Code {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.script)
    }
}

#[derive(Clone, Copy, Debug)]
pub struct Function {
    pub code: &'static Code,
    pub k: [f64; 4],
}

/// What replaces the reflectivities of a base.
#[derive(Clone, Copy, Debug, Default)]
pub struct Shader {
    pub ambient: Option<Function>,
    pub diffuse: Option<Function>,
    pub specular: Option<Function>,
}

impl Shader {
    /// The material at a spot.
    pub fn of(&self, base: &Material, spot: &Spot) -> Material {
        let or = |f: Option<Function>, v: Vec3| f.map_or(v, |f| (f.code.value)(spot, f.k));
        Material {
            ambient: or(self.ambient, base.ambient),
            diffuse: or(self.diffuse, base.diffuse),
            specular: or(self.specular, base.specular),
        }
    }
}

fn clamp(x: f64, low: f64, high: f64) -> f64 {
    x.max(low).min(high)
}

fn modulo(a: f64, b: f64) -> f64 {
    a - b * (a / b).floor()
}

fn mix(a: f64, b: f64, t: f64) -> f64 {
    a + (b - a) * t
}

fn step(edge: f64, x: f64) -> f64 {
    if x >= edge { 1.0 } else { 0.0 }
}

fn smoothstep(e0: f64, e1: f64, x: f64) -> f64 {
    let t = clamp((x - e0) / (e1 - e0), 0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// All of the words at least once. Values stay in about [0, 1] for a k of [0.2, 1] and points of a
/// few units.
pub const CODES: &[Code] = &[
    Code {
        script: "0.5 + 0.5 * sin(p.x * k0 * 3 + p.z * k1 * 2 - p.y)",
        value: |s, k| {
            Vec3::splat(0.5 + 0.5 * (s.p[0] * k[0] * 3.0 + s.p[2] * k[1] * 2.0 - s.p[1]).sin())
        },
    },
    Code { script: "[p.u, p.v, k0]", value: |s, k| v3(s.u, s.v, k[0]) },
    Code {
        script: "0.5 + p.normal * k0 * 0.5",
        value: |s, k| (s.normal * k[0] * 0.5).map(|x| 0.5 + x),
    },
    Code {
        script: "mix(k0, k1, smoothstep(-1, 1 + k2, p.y))",
        value: |s, k| Vec3::splat(mix(k[0], k[1], smoothstep(-1.0, 1.0 + k[2], s.p[1]))),
    },
    Code {
        script: "step(0.5, mod(p.x / k0 + p.y, 1.0)) * k1",
        value: |s, k| Vec3::splat(step(0.5, modulo(s.p[0] / k[0] + s.p[1], 1.0)) * k[1]),
    },
    Code {
        script: "{ let f = p.z * k0 - floor(p.z * k0); [f * k1, abs(f - 0.5), 1 - f] }",
        value: |s, k| {
            let f = s.p[2] * k[0] - (s.p[2] * k[0]).floor();
            v3(f * k[1], (f - 0.5).abs(), 1.0 - f)
        },
    },
    Code {
        script: "min(1, max(k0 * 0.1, sqrt(abs(p.x * p.y)) - k1))",
        value: |s, k| Vec3::splat(((s.p[0] * s.p[1]).abs().sqrt() - k[1]).max(k[0] * 0.1).min(1.0)),
    },
    Code {
        script: "acos(clamp(p.normal.y * k0, -0.9, 0.9)) / PI",
        value: |s, k| {
            Vec3::splat(clamp(s.normal[1] * k[0], -0.9, 0.9).acos() / std::f64::consts::PI)
        },
    },
    Code {
        script: "vec3(0.5 + 0.5 * cos(length(p.normal + [p.x, 0, k0]) * 3), k1, k2) * k3",
        value: |s, k| {
            let d = (s.normal + v3(s.p[0], 0.0, k[0])).length();
            v3(0.5 + 0.5 * (d * 3.0).cos(), k[1], k[2]) * k[3]
        },
    },
    Code {
        script: "lerp([k0, k1, 0], [0, k2, k3], 0.5 + 0.5 * dot(p.normal, [0.6, 0.0, 0.8]))",
        value: |s, k| {
            let t = 0.5 + 0.5 * s.normal.dot(v3(0.6, 0.0, 0.8));
            v3(mix(k[0], 0.0, t), mix(k[1], k[2], t), mix(0.0, k[3], t))
        },
    },
    Code {
        // `%` has the sign of what is divided, `mod` that of the divisor.
        script: "0.5 + (p.x + 0.25) % k0 * 0.4 + p.z % -k1 * 0.2 + mod(p.y, -k2) * 0.1",
        value: |s, k| {
            let (x, z) = ((s.p[0] + 0.25) % k[0], s.p[2] % -k[1]);
            Vec3::splat(0.5 + x * 0.4 + z * 0.2 + modulo(s.p[1], -k[2]) * 0.1)
        },
    },
    Code {
        script: "if k0 > 0.5 { k1 } else { clamp(p.u * 2 - p.v, 0, k2) }",
        value: |s, k| {
            Vec3::splat(if k[0] > 0.5 { k[1] } else { clamp(s.u * 2.0 - s.v, 0.0, k[2]) })
        },
    },
];
