//! A convex mesh shadows none of its own lit points: the start of a shadow ray is moved off its
//! triangle by a bound on its rounding ([`reflet_trace::interact`]), and that suffices.

use fearless_simd::Fallback;
use reflet_accel::{Accel, HitCode, Hits, Isa, RayCounts, Rays, Scratch, Structure};
use reflet_pack::Geometry;
use reflet_pack::lights::{LightPlace, Reach};
use reflet_scene::Falloff;
use reflet_trace::interact::Interactions;
use reflet_trace::lighting::{Shadows, aim};
use std::collections::HashMap;

/// A small generator of its own: the same rays on every machine.
struct Dice(u64);

impl Dice {
    /// -1..1.
    fn float(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / f64::from(1 << 23) - 1.0
    }

    fn below(&mut self, n: usize) -> usize {
        ((self.float() + 1.0) * 0.5 * n as f64) as usize
    }

    fn unit(&mut self) -> P {
        loop {
            let v = [self.float(), self.float(), self.float()];
            let length = dot(v, v).sqrt();
            if (0.1..1.0).contains(&length) {
                return v.map(|x| x / length);
            }
        }
    }
}

type P = [f64; 3];
type Face = [[f32; 3]; 3];

fn dot(a: P, b: P) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn sub(a: P, b: P) -> P {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn wide(p: [f32; 3]) -> P {
    p.map(f64::from)
}

/// Twice the area times the outward unit normal.
fn normal([a, b, c]: &Face, center: f64) -> P {
    let (u, v) = (sub(wide(*b), wide(*a)), sub(wide(*c), wide(*a)));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    if dot(n, sub(wide(*a), [center; 3])) < 0.0 { n.map(|x| -x) } else { n }
}

/// An octahedron whose faces are split `depth` times and pushed out to a sphere.
fn ball(center: f64, radius: f64, depth: u32) -> Vec<Face> {
    let mut faces: Vec<[P; 3]> = Vec::new();
    for s in 0..8 {
        let sign = |bit: u32| if s >> bit & 1 == 0 { 1.0 } else { -1.0 };
        faces.push([[sign(0), 0.0, 0.0], [0.0, sign(1), 0.0], [0.0, 0.0, sign(2)]]);
    }
    let middle = |a: P, b: P| {
        let m = [0, 1, 2].map(|k| a[k] + b[k]);
        let length = dot(m, m).sqrt();
        m.map(|x| x / length)
    };
    for _ in 0..depth {
        let split = |[a, b, c]: [P; 3]| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        faces = faces.into_iter().flat_map(split).collect();
    }
    let place = |p: P| p.map(|x| (center + radius * x) as f32);
    faces.into_iter().map(|face| face.map(place)).collect()
}

/// Whether no face's neighbour rises above it, in exact arithmetic but for the rounding of `f64`.
fn is_convex(faces: &[Face], center: f64) -> bool {
    let bits = |p: [f32; 3]| p.map(f32::to_bits);
    let mut edges = HashMap::new();
    for (i, face) in faces.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (bits(face[k]), bits(face[(k + 1) % 3]));
            edges.entry((a.min(b), a.max(b))).or_insert_with(Vec::new).push((i, face[(k + 2) % 3]));
        }
    }
    edges.values().all(|sides| {
        let [(i, p), (j, q)] = sides[..] else { return false };
        let under =
            |face: &Face, p: [f32; 3]| dot(normal(face, center), sub(wide(p), wide(face[0]))) < 0.0;
        under(&faces[i], q) && under(&faces[j], p)
    })
}

/// Lit points, and those of them that something shadows.
fn shadowed(
    (center, radius): (f64, f64),
    faces: &[Face],
    (count, slope): (usize, f64),
) -> (usize, usize) {
    const BATCH: usize = 4096;
    let simd = Fallback::new();
    let mut g = Geometry::default();
    for face in faces {
        g.push_triangle(*face);
    }
    let accel = Accel::build(&g, Isa::Auto.level().expect("always"), Structure::Auto);
    let (mut hits, mut scratch) = (Hits::default(), Scratch::default());
    let (mut dice, mut counts) = (Dice(5), RayCounts::default());
    let (mut lit, mut dark) = (0, 0);
    for batch in 0..count.div_ceil(BATCH) {
        let mut rays = Rays::default();
        for _ in 0..BATCH {
            let from = dice.unit();
            let from = from.map(|x| (center + x * radius * 3.0) as f32);
            // At faces, edges and corners.
            let face = faces[dice.below(faces.len())].map(wide);
            let weights = match dice.below(4) {
                0 => [1.0, 0.0, 0.0],
                1 => [0.5, 0.5, 0.0],
                _ => [(); 3].map(|()| dice.float().abs()),
            };
            let sum: f64 = weights.iter().sum();
            let to = [0, 1, 2].map(|k| (0..3).map(|i| weights[i] * face[i][k]).sum::<f64>() / sum);
            let way = sub(to, wide(from));
            let length = dot(way, way).sqrt();
            rays.push(from, way.map(|x| (x / length) as f32), f32::INFINITY, HitCode::NONE);
        }
        rays.pad();
        accel.closest(&rays, &mut hits, &mut scratch, &mut counts);
        let mut points = Interactions::default();
        points.find(simd, &g, &rays, &hits);
        let far = [1.1, 2.0, 30.0][batch % 3];
        let place = dice.unit().map(|x| (center + x * radius * far) as f32);
        let light = LightPlace {
            at: place,
            axis: [0.0; 3],
            cos_angle: -2.0,
            reach: Reach::Near(Falloff::None),
            slide: None,
        };
        let (mut term, mut shadows) = (vec![0.0; BATCH], Shadows::default());
        aim(simd, &light, &points, &hits.code[..BATCH], &mut term, &mut shadows);
        let mut occluded = Vec::new();
        accel.any(&shadows.rays, &mut occluded, &mut scratch, &mut counts);
        for (row, is_dark) in shadows.rows.iter().zip(occluded) {
            let prim = hits.code[usize::from(*row)].prim().expect("a hit");
            let face = &faces[prim.index()];
            let n = normal(face, center);
            // Lit by more than the rounding of its own plane.
            let way = sub(wide(place), wide(face[0]));
            let height = dot(n, way) / dot(n, n).sqrt();
            if height > slope * dot(way, way).sqrt() + 1e-6 * (center + radius * far) {
                lit += 1;
                dark += usize::from(is_dark);
            }
        }
    }
    (lit, dark)
}

fn check(cases: &[(f64, f64, u32)], count: usize, slope: f64) {
    for (center, radius, depth) in cases.iter().copied() {
        let faces = ball(center, radius, depth);
        assert!(slope > 0.0 || is_convex(&faces, center), "center {center}, {} faces", faces.len());
        let (lit, dark) = shadowed((center, radius), &faces, (count, slope));
        let what = format!("center {center}, radius {radius}, {} faces", faces.len());
        println!("{what}: {lit} lit, {dark} shadowed");
        assert!(lit > count / 8, "{what}: {lit} lit");
        assert_eq!(dark, 0, "{what}: of {lit} lit points");
    }
}

/// As many faces as stay convex when their corners are rounded to `f32`.
#[test]
fn no_lit_point_of_a_convex_mesh_is_shadowed() {
    let cases = [
        (0.0, 1.0, 0),
        (0.0, 1.0, 5),
        (1.0, 1.0, 5),
        (100.0, 1.0, 4),
        (1000.0, 1.0, 3),
        (1e4, 1.0, 1),
        (1e4, 100.0, 4),
    ];
    check(&cases, 60_000, 0.0);
}

/// The rounded corners of so many faces are no longer quite convex: their neighbours rise above them
/// by some 1e-4 of their edges, so only lights that are higher than that count.
#[test]
#[ignore = "up to two million faces, and a million points on each mesh"]
fn no_lit_point_of_a_large_convex_mesh_is_shadowed() {
    let cases = [(0.0, 1.0, 7), (0.0, 1.0, 8), (0.0, 1.0, 9), (1e4, 1e4, 8), (1e3, 1e3, 9)];
    check(&cases, 1_000_000, 1e-3);
}
