//! Every way to a hit against the definition: the same t, by bits, and the same primitive.

use glam::DVec3;
use proptest::prelude::*;
use reflet_accel::{Accel, HitCode, Hits, Isa, RayCounts, Rays, Scratch, Structure, brute};
use reflet_pack::{Columns, Overrides, Packer, ShapeKind};
use reflet_scene::{Camera, Plane, Quad, Scene, Sphere, Surface, Triangle};

/// A small generator of its own: the same scenes on every machine.
struct Dice(u64);

impl Dice {
    fn float(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / f64::from(1 << 24)
    }

    fn range(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * self.float()
    }

    fn below(&mut self, n: u32) -> u32 {
        (self.float() * f64::from(n)) as u32
    }

    fn point(&mut self, r: f64) -> DVec3 {
        DVec3::new(self.range(-r, r), self.range(-r, r), self.range(-r, r))
    }

    /// Half of the time on a lattice: faces in axis planes, shared corners, ties.
    fn place(&mut self, r: f64) -> DVec3 {
        let p = self.point(r);
        if self.below(2) == 0 { p.round() } else { p }
    }

    fn direction(&mut self) -> DVec3 {
        loop {
            let d = if self.below(4) == 0 { self.point(1.0).round() } else { self.point(1.0) };
            if d.length() > 0.1 {
                return d.normalize();
            }
        }
    }
}

fn scene(dice: &mut Dice, count: u32) -> Columns {
    let mut scene = Scene::new();
    let camera =
        Camera::LookAt { eye: DVec3::Z, look_at: DVec3::ZERO, up: DVec3::Y, fov_degrees: 45.0 };
    scene.singletons.camera = Some(scene.spawn((camera,)));
    for _ in 0..count {
        let surface = Surface { material: None, visible: dice.below(20) > 0 };
        match dice.below(24) {
            0 => {
                let plane = Plane { point: dice.place(4.0), normal: dice.direction() };
                scene.spawn((plane, surface));
            }
            1..5 => {
                // Small faces in axis planes, each many times over: ties between leaves.
                let [u, v] = [[DVec3::X, DVec3::Y], [DVec3::Y, DVec3::Z]][dice.below(2) as usize];
                let corner = dice.place(4.0);
                for _ in 0..1 + dice.below(12) {
                    let size = dice.range(0.01, 0.02);
                    scene.spawn((Quad { corner, u: u * size, v: v * size }, surface));
                }
            }
            5..12 => {
                let sphere = Sphere { center: dice.place(4.0), radius: dice.range(0.1, 1.5) };
                scene.spawn((sphere, surface));
                if dice.below(10) == 0 {
                    scene.spawn((sphere, surface)); // every root a tie
                }
            }
            12..18 => {
                let (corner, u, v) = (dice.place(4.0), dice.direction(), dice.direction());
                let quad = Quad { corner, u: u * 2.0, v };
                if quad.check().is_ok() {
                    scene.spawn((quad, surface));
                }
            }
            _ => {
                let triangle =
                    Triangle { a: dice.place(4.0), b: dice.place(4.0), c: dice.place(4.0) };
                if triangle.check().is_ok() {
                    scene.spawn((triangle, surface));
                }
            }
        }
    }
    scene.seal();
    Packer::new(&scene, Overrides::default()).expect("a camera").columns().clone()
}

fn f32s(v: DVec3) -> [f32; 3] {
    v.to_array().map(|x| x as f32)
}

/// Rays at what random rays never meet: faces and corners of boxes, poles and tangents of spheres,
/// edges and corners of flat shapes, and rays that leave surfaces.
fn aimed_rays(dice: &mut Dice, columns: &Columns, count: usize) -> Rays {
    let g = &columns.geometry;
    let mut rays = Rays::default();
    for _ in 0..count {
        // From afar a box's border and its contents round to the same distance.
        let origin = dice.place(6.0) * if dice.below(3) == 0 { 2000.0 } else { 1.0 };
        let mut last = HitCode::NONE;
        let mut from = f32s(origin);
        let mut at = dice.place(4.0);
        if !g.is_empty() {
            let prim = reflet_accel::PrimId(dice.below(g.len() as u32));
            let (kind, row) = g.shape[prim.index()];
            let row = row as usize;
            let wide = |p: [f32; 3]| DVec3::from_array(p.map(f64::from));
            at = match (kind, dice.below(4)) {
                (ShapeKind::Plane, _) => dice.place(4.0),
                (ShapeKind::Sphere, 0) => {
                    // A pole: where the sphere touches its box.
                    let axis = [DVec3::X, DVec3::Y, DVec3::Z][dice.below(3) as usize];
                    let side = if dice.below(2) == 0 { 1.0 } else { -1.0 };
                    wide(g.spheres.center.get(row)) + axis * side * f64::from(g.spheres.radius[row])
                }
                (ShapeKind::Sphere, 1) => {
                    // A tangent.
                    let c = wide(g.spheres.center.get(row));
                    let across = (c - origin).cross(dice.direction()).normalize_or(DVec3::X);
                    c + across * f64::from(g.spheres.radius[row])
                }
                (ShapeKind::Sphere, _) => wide(g.spheres.center.get(row)) + dice.point(0.7),
                (ShapeKind::Quad, k) => {
                    let p = g.quads.points(row).map(wide);
                    let t = [0.0, 0.25, 0.5, 1.0][dice.below(4) as usize];
                    p[k as usize].lerp(p[(k as usize + 1) % 4], t)
                }
                (ShapeKind::Triangle, k) => {
                    let p = g.triangles.points(row).map(wide);
                    let t = [0.0, 0.25, 0.5, 1.0][dice.below(4) as usize];
                    p[k as usize % 3].lerp(p[(k as usize + 1) % 3], t)
                }
            };
            if dice.below(4) == 0 {
                // A ray that leaves the surface it is aimed at.
                from = f32s(at);
                at = dice.place(4.0);
                last = HitCode::outside(prim);
                if kind == ShapeKind::Sphere && dice.below(2) == 0 {
                    last = last.inward();
                }
            }
        }
        let way = at - DVec3::from_array(from.map(f64::from));
        let d = if way.length() > 1e-6 { way.normalize() } else { dice.direction() };
        let t_max = if dice.below(6) == 0 { dice.range(0.1, 8.0) as f32 } else { f32::INFINITY };
        rays.push(from, f32s(d), t_max, last);
    }
    rays.pad();
    rays
}

fn assert_equal(columns: &Columns, rays: &Rays) {
    let g = &columns.geometry;
    let want: Vec<(f32, HitCode)> = (0..rays.len())
        .map(|i| {
            let o = [0, 1, 2].map(|k| rays.origin[k][i]);
            let d = [0, 1, 2].map(|k| rays.dir[k][i]);
            brute::closest(g, (o, d), (rays.t_min[i], rays.t_max[i]), rays.last[i])
        })
        .collect();
    for isa in Isa::available() {
        for structure in [Structure::List, Structure::Tree] {
            let accel = Accel::build(g, isa.level().expect("available"), structure);
            let (mut hits, mut occluded) = (Hits::default(), Vec::new());
            let (mut scratch, mut counts) = (Scratch::default(), RayCounts::default());
            accel.closest(rays, &mut hits, &mut scratch, &mut counts);
            accel.any(rays, &mut occluded, &mut scratch, &mut counts);
            for (i, (t, code)) in want.iter().enumerate() {
                let got = (hits.t[i].to_bits(), hits.code[i]);
                assert_eq!(got, (t.to_bits(), *code), "closest of ray {i}, {isa:?} {structure:?}");
                assert_eq!(occluded[i], !code.is_none(), "any of ray {i}, {isa:?} {structure:?}");
            }
            assert_eq!((counts.closest, counts.any), (want.len() as u64, want.len() as u64));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, max_shrink_iters: 0, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_level_and_structure_gives_the_bits_of_the_definition(seed: u64, count in 0u32..120) {
        let mut dice = Dice(seed);
        let columns = scene(&mut dice, count);
        assert_equal(&columns, &aimed_rays(&mut dice, &columns, 700));
    }
}

#[test]
fn rays_that_are_none_hit_nothing() {
    let mut dice = Dice(5);
    let columns = scene(&mut dice, 60);
    let mut rays = Rays::default();
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, 1e-40];
    for x in bad {
        rays.push([0.0; 3], [x, 0.0, 0.0], f32::INFINITY, HitCode::NONE);
        rays.push([0.0; 3], [x; 3], f32::INFINITY, HitCode::NONE);
        rays.push([x, 0.0, 0.0], [0.0, 0.0, 1.0], f32::INFINITY, HitCode::NONE);
        rays.push([0.0; 3], [0.0, 0.6, 0.8], x, HitCode::NONE);
        rays.push([0.0, 0.0, -20.0], [x, x, 1.0], f32::INFINITY, HitCode::NONE);
    }
    rays.pad();
    assert_equal(&columns, &rays);
    let level = Isa::Auto.level().expect("always");
    let accel = Accel::build(&columns.geometry, level, Structure::Auto);
    let mut hits = Hits::default();
    accel.closest(&rays, &mut hits, &mut Scratch::default(), &mut RayCounts::default());
    for i in 0..rays.len() {
        let numbers = [0, 1, 2].map(|k| rays.origin[k][i] + rays.dir[k][i]);
        let zero = [0, 1, 2].iter().all(|k| rays.dir[*k][i] * rays.dir[*k][i] == 0.0);
        if zero || numbers.iter().any(|x| !x.is_finite()) || rays.t_max[i].is_nan() {
            assert!(hits.code[i].is_none(), "ray {i} hit {:?}", hits.code[i]);
        }
    }
}

#[test]
fn coincident_surfaces_give_the_hit_to_the_one_made_first() {
    let mut scene = Scene::new();
    let camera =
        Camera::LookAt { eye: DVec3::Z, look_at: DVec3::ZERO, up: DVec3::Y, fov_degrees: 45.0 };
    scene.singletons.camera = Some(scene.spawn((camera,)));
    let surface = Surface { material: None, visible: true };
    for _ in 0..40 {
        scene.spawn((Sphere { center: DVec3::ZERO, radius: 1.0 }, surface));
    }
    scene.seal();
    let columns = Packer::new(&scene, Overrides::default()).expect("a camera").columns().clone();
    let mut rays = Rays::default();
    let mut dice = Dice(7);
    for _ in 0..500 {
        let from = dice.direction() * 5.0;
        let d = (dice.point(0.5) - from).normalize();
        rays.push(f32s(from), f32s(d), f32::INFINITY, HitCode::NONE);
    }
    rays.pad();
    assert_equal(&columns, &rays);
    let accel =
        Accel::build(&columns.geometry, Isa::Auto.level().expect("always"), Structure::Tree);
    let mut hits = Hits::default();
    accel.closest(&rays, &mut hits, &mut Scratch::default(), &mut RayCounts::default());
    let prims: Vec<_> = hits.code[..rays.len()].iter().filter_map(|c| c.prim()).collect();
    assert!(prims.len() > 400 && prims.iter().all(|p| p.0 == 0));
}
