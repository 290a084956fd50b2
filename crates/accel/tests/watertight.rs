//! Closed meshes let no ray through, and no lit point of a convex one shadows itself.

use reflet_accel::{Accel, HitCode, Hits, Isa, RayCounts, Rays, Scratch, Structure};
use reflet_pack::Geometry;

/// A small generator of its own: the same rays on every machine.
struct Dice(u64);

impl Dice {
    fn float(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / f64::from(1 << 24)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.float() * n as f64) as usize
    }
}

type Point = [f32; 3];

/// An octahedron whose faces are split `depth` times and pushed out to a sphere about `center`:
/// corners, and triangles that share them.
fn ball(center: f64, depth: u32) -> Vec<[Point; 3]> {
    let mut faces: Vec<[[f64; 3]; 3]> = Vec::new();
    for s in 0..8 {
        let sign = |bit: u32| if s >> bit & 1 == 0 { 1.0 } else { -1.0 };
        faces.push([[sign(0), 0.0, 0.0], [0.0, sign(1), 0.0], [0.0, 0.0, sign(2)]]);
    }
    // The same corners give the same bits whichever way round an edge is seen.
    let middle = |a: [f64; 3], b: [f64; 3]| {
        let m = [0, 1, 2].map(|k| a[k] + b[k]);
        let length = m.iter().map(|x| x * x).sum::<f64>().sqrt();
        m.map(|x| x / length)
    };
    for _ in 0..depth {
        let split = |[a, b, c]: [[f64; 3]; 3]| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        faces = faces.into_iter().flat_map(split).collect();
    }
    let place = |p: [f64; 3]| p.map(|x| (x + center) as f32);
    faces.into_iter().map(|face| face.map(place)).collect()
}

fn geometry(faces: &[[Point; 3]]) -> Geometry {
    let mut g = Geometry::default();
    for face in faces {
        g.push_triangle(*face);
    }
    g
}

/// Rays from within the ball at corners, along edges and into faces' edges.
fn rays(dice: &mut Dice, faces: &[[Point; 3]], center: f64, count: usize) -> Rays {
    let mut rays = Rays::default();
    for _ in 0..count {
        let face = faces[dice.below(faces.len())];
        let (a, b) = (face[dice.below(3)], face[dice.below(3)]);
        let along = dice.float();
        let at = [0, 1, 2].map(|k| f64::from(a[k]) + along * (f64::from(b[k]) - f64::from(a[k])));
        let from = [(); 3].map(|()| (center + (dice.float() - 0.5) * 0.8) as f32);
        let way = [0, 1, 2].map(|k| at[k] - f64::from(from[k]));
        let length = way.iter().map(|x| x * x).sum::<f64>().sqrt();
        rays.push(from, way.map(|x| (x / length) as f32), f32::INFINITY, HitCode::NONE);
    }
    rays.pad();
    rays
}

fn leaks(isa: Isa, count: usize, batch: usize) -> usize {
    let mut dice = Dice(11);
    let mut leaks = 0;
    for (center, depth) in [(0.0, 2), (0.0, 5), (100.0, 3)] {
        let faces = ball(center, depth);
        let level = isa.level().expect("available");
        let accel = Accel::build(&geometry(&faces), level, Structure::Tree);
        let (mut hits, mut scratch) = (Hits::default(), Scratch::default());
        for _ in 0..count.div_ceil(3 * batch) {
            let rays = rays(&mut dice, &faces, center, batch);
            accel.closest(&rays, &mut hits, &mut scratch, &mut RayCounts::default());
            leaks += hits.code[..batch].iter().filter(|code| code.is_none()).count();
        }
    }
    leaks
}

#[test]
fn no_ray_leaves_a_closed_mesh_through_an_edge_or_a_corner() {
    for isa in Isa::available() {
        // Ten million on the best level; the hits of the others are the same bits.
        let count = if isa == Isa::Auto.resolved() { 10_000_000 } else { 300_000 };
        assert_eq!(leaks(isa, count, 100_000), 0, "{}", isa.name());
    }
}

#[test]
#[ignore = "a thousand million rays take minutes"]
fn no_ray_of_a_thousand_million_leaves() {
    assert_eq!(leaks(Isa::Auto, 1_000_000_000, 1_000_000), 0);
}

/// The edge functions with a fused multiply-add: no longer exact negatives of each other.
fn is_inside_fused(o: Point, d: Point, face: &[Point; 3]) -> bool {
    let size = d.map(f32::abs);
    let z = (0..3).max_by(|a, b| size[*a].total_cmp(&size[*b])).unwrap_or(2);
    let (x, y) = ((z + 1) % 3, (z + 2) % 3);
    let (sx, sy) = (d[x] / d[z], d[y] / d[z]);
    let ahead = |p: &Point| (0..3).map(|k| (p[k] - o[k]) * d[k]).sum::<f32>();
    if face.iter().map(ahead).sum::<f32>() <= 0.0 {
        return false;
    }
    let p = face.map(|p| {
        let p = [p[x] - o[x], p[y] - o[y], p[z] - o[z]];
        [p[0] - sx * p[2], p[1] - sy * p[2]]
    });
    let edge = |p: [f32; 2], q: [f32; 2]| p[0].mul_add(q[1], -(p[1] * q[0]));
    let e = [edge(p[2], p[1]), edge(p[0], p[2]), edge(p[1], p[0])];
    !(e.iter().any(|e| *e < 0.0) && e.iter().any(|e| *e > 0.0))
}

/// The control: what the test above would find if the kernels fused.
#[test]
fn fused_edge_functions_leak() {
    let (mut dice, faces) = (Dice(11), ball(0.0, 2));
    let rays = rays(&mut dice, &faces, 0.0, 20_000);
    let mut leaks = 0;
    for i in 0..rays.len() {
        let o = [0, 1, 2].map(|k| rays.origin[k][i]);
        let d = [0, 1, 2].map(|k| rays.dir[k][i]);
        leaks += usize::from(!faces.iter().any(|face| is_inside_fused(o, d, face)));
    }
    assert!(leaks > 0, "the rays are aimed too badly to tell");
}
