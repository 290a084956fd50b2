//! What a surface wears at a point.

use super::scene::{Checker, Material, Pattern, Scene, Shape, Wears};
use super::shader::Spot;
use super::shape::{Part, is_flat, origin, own_normal, put_onto};
use super::texture::Edge;
use super::uv::uv;
use super::vec3::Vec3;

/// A point of a surface, in the coordinates before all motions.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    pub p: Vec3,
    pub part: Part,
    /// Turned to face the incoming ray.
    pub facing: Vec3,
}

/// The reflectivities of a surface at a point of it.
pub fn material(scene: &Scene, surface: usize, at: Point) -> Material {
    let surface = &scene.surfaces[surface];
    let shape = &surface.shape;
    let at = Point { p: put_onto(shape, at.part, at.p), ..at };
    match surface.wears {
        Wears::Material(i) => scene.materials[i],
        Wears::Checker(i) => scene.materials[tile(shape, &scene.checkers[i], at.p)],
        Wears::File => match (shape, at.part) {
            (Shape::Mesh { mesh }, Part::Flat(i)) => mesh.material(i),
            _ => unreachable!("only meshes wear what a file says"),
        },
        Wears::Pattern(i) => patterned(scene, shape, &scene.patterns[i], at),
    }
}

fn patterned(scene: &Scene, shape: &Shape, pattern: &Pattern, at: Point) -> Material {
    let q = at.p - origin(shape);
    match *pattern {
        Pattern::Solid { even, odd, size } => {
            let cells = (0..3).map(|i| (q[i] / size[i]).floor()).sum::<f64>();
            scene.materials[if cells.rem_euclid(2.0) == 0.0 { even } else { odd }]
        }
        Pattern::Stripes { even, odd, width, xdir } => {
            let x = if is_flat(shape) { flat_frame(shape, xdir).0 } else { xdir.unit() };
            let stripe = (q.dot(x) / width).floor();
            scene.materials[if stripe.rem_euclid(2.0) == 0.0 { even } else { odd }]
        }
        Pattern::Fit { base, texture, filter } => {
            let (u, v) = uv(shape, at.part, at.p);
            // A mesh's own places may lie beyond the picture, which then repeats.
            let repeats = matches!(shape, Shape::Mesh { .. });
            let (u, v) = if repeats { (u - u.floor(), v - v.floor()) } else { (u, v) };
            let edge = if repeats { Edge::Wrap } else { Edge::Clamp };
            let texel = scene.textures[texture].at(u, v, filter, edge);
            tinted(&scene.materials[base], texel)
        }
        Pattern::Tile { base, texture, filter, size, xdir } => {
            let (x, y) = flat_frame(shape, xdir);
            let (s, t) = (q.dot(x) / size[0], q.dot(y) / size[1]);
            let (s, t) = (s - s.floor(), t - t.floor());
            tinted(&scene.materials[base], scene.textures[texture].at(s, t, filter, Edge::Wrap))
        }
        Pattern::Shader { base, shader } => {
            let (u, v) = uv(shape, at.part, at.p);
            shader.of(&scene.materials[base], &Spot { p: at.p, u, v, normal: at.facing })
        }
    }
}

fn tinted(base: &Material, texel: Vec3) -> Material {
    let by = |v: Vec3| v.zip(texel, |a, b| a * b);
    Material { ambient: by(base.ambient), diffuse: by(base.diffuse), specular: by(base.specular) }
}

/// x along a flat shape, and y across x.
fn flat_frame(shape: &Shape, xdir: Vec3) -> (Vec3, Vec3) {
    let normal = own_normal(shape, Part::Flat(0), Vec3::ZERO);
    let x = (xdir - normal * xdir.dot(normal)).unit();
    (x, normal.cross(x))
}

/// Which of the two materials a checker shows at `p` on a flat `shape`.
pub fn tile(shape: &Shape, checker: &Checker, p: Vec3) -> usize {
    assert!(is_flat(shape), "a checker of tiles lies on flat surfaces only");
    let (x, y) = flat_frame(shape, checker.xdir);
    let d = p - origin(shape);
    let sum = (d.dot(x) / checker.size[0]).floor() + (d.dot(y) / checker.size[1]).floor();
    if sum.rem_euclid(2.0) == 0.0 { checker.even } else { checker.odd }
}
