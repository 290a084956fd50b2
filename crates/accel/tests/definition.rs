//! Every way to a hit against the definition: the same t, by bits, and the same primitive.

use glam::DVec3;
use proptest::prelude::*;
use reflet_accel::{
    Accel, HitCode, Hits, Isa, PrimId, RayCounts, Rays, Refit, Scratch, Structure, Way, brute,
};
use reflet_pack::{Aabb, Columns, Geometry, Overrides, Packer, ShapeKind, Sharing, Slot};
use reflet_scene::{
    Camera, Caps, Cone, Cuboid, Cylinder, Disc, Ellipsoid, Hyperboloid, Instance, Mesh, MeshData,
    Paraboloid, Place, Plane, Quad, Scene, Sphere, Surface, Torus, Triangle,
};
use std::sync::Arc;

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
    packed(&world(dice, count), Sharing::Always)
}

fn packed(scene: &Scene, sharing: Sharing) -> Columns {
    let packer = Packer::sharing(scene, Overrides::default(), sharing).expect("a camera");
    packer.columns().clone()
}

fn world(dice: &mut Dice, count: u32) -> Scene {
    let mut scene = Scene::new();
    let camera =
        Camera::LookAt { eye: DVec3::Z, look_at: DVec3::ZERO, up: DVec3::Y, fov_degrees: 45.0 };
    scene.singletons.camera = Some(scene.spawn((camera,)));
    let file = file(dice);
    for _ in 0..count {
        let surface = Surface { material: None, visible: dice.below(20) > 0 };
        match dice.below(27) {
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
            12..15 => {
                solid(dice, &mut scene, surface);
            }
            15..19 => {
                let (corner, u, v) = (dice.place(4.0), dice.direction(), dice.direction());
                let quad = Quad { corner, u: u * 2.0, v };
                if quad.check().is_ok() {
                    scene.spawn((quad, surface));
                }
            }
            19..24 => {
                let triangle =
                    Triangle { a: dice.place(4.0), b: dice.place(4.0), c: dice.place(4.0) };
                if triangle.check().is_ok() {
                    scene.spawn((triangle, surface));
                }
            }
            _ => mesh(dice, &mut scene, (&file, surface)),
        }
    }
    scene.seal();
    scene
}

/// A mesh of triangles that share corners, some of them on a lattice, some without an area.
fn file(dice: &mut Dice) -> Arc<MeshData> {
    let positions: Vec<[f32; 3]> = (0..12).map(|_| f32s(dice.place(1.0))).collect();
    let corner = |dice: &mut Dice| dice.below(12);
    let count = 2 + dice.below(60);
    let triangles = (0..count).map(|_| [corner(dice), corner(dice), corner(dice)]).collect();
    Arc::new(MeshData { positions, triangles, ..MeshData::default() })
}

/// The mesh once more, by itself or through an instance that turns, draws out or mirrors it.
fn mesh(dice: &mut Dice, scene: &mut Scene, (data, surface): (&Arc<MeshData>, Surface)) {
    let turn = |dice: &mut Dice| {
        let quarters = f64::from(dice.below(4)) * 90.0;
        let any = dice.range(0.0, 360.0);
        DVec3::new(quarters, [0.0, any][dice.below(2) as usize], quarters)
    };
    let own = Mesh {
        data: data.clone(),
        scale: [1.0, 0.5, -1.5][dice.below(3) as usize],
        rotate: turn(dice),
        translate: dice.place(4.0),
        shading: reflet_scene::Shading::Smooth,
        worn: [].into(),
    };
    let key = scene.spawn((own, surface));
    if dice.below(2) == 0 {
        let scale = DVec3::ONE + dice.point(0.9).round() * 0.5 + dice.point(0.3);
        // Now and then flat, as far as f32 can tell.
        let scale = if dice.below(8) == 0 { scale * DVec3::new(1.0, 1e-9, 1.0) } else { scale };
        let (rotate, translate) = (turn(dice), dice.place(4.0));
        let place = Place { scale, rotate, translate, visible: dice.below(20) > 0 };
        scene.spawn((place, Instance { of: key }));
    }
}

/// A curved shape, some of them through an instance that draws it out.
fn solid(dice: &mut Dice, scene: &mut Scene, surface: Surface) {
    let (at, axis) = (dice.place(4.0), dice.direction());
    let (radius, height) = (dice.range(0.1, 1.0), dice.range(0.1, 2.0));
    let caps = if dice.below(2) == 0 { Caps::Open } else { Caps::Closed };
    let key = match dice.below(8) {
        0 => scene.spawn((Cylinder { base: at, axis, radius, height, caps }, surface)),
        1 => scene.spawn((Cone { apex: at, axis, radius, height, caps }, surface)),
        2 => scene.spawn((Paraboloid { vertex: at, axis, radius, height, caps }, surface)),
        3 => {
            let waist = radius * dice.range(0.1, 0.9);
            scene.spawn((Hyperboloid { center: at, axis, radius, waist, height, caps }, surface))
        }
        4 => {
            let radii = DVec3::new(radius, height, dice.range(0.1, 1.0));
            scene.spawn((Ellipsoid { center: at, radii }, surface))
        }
        5 => scene.spawn((Disc { center: at, normal: axis, radius }, surface)),
        6 => {
            let size = DVec3::new(radius, height, radius);
            scene.spawn((Cuboid::Centered { center: at, size }, surface))
        }
        _ => {
            let minor = radius * dice.range(0.1, 0.9);
            scene.spawn((Torus { center: at, axis, major: radius, minor }, surface))
        }
    };
    if dice.below(3) == 0 {
        let scale = DVec3::new(dice.range(0.5, 2.0), dice.range(-2.0, -0.5), 1.0);
        let (rotate, translate) = (dice.point(180.0), dice.place(2.0));
        let place = Place { scale, rotate, translate, visible: true };
        scene.spawn((place, Instance { of: key }));
    }
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
            let prim = PrimId(dice.below(g.prims()));
            let (slot, which) = g.slot_of(prim);
            let (kind, row) = g.shape[slot.index()];
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
                (ShapeKind::Solid, k) => {
                    // Where a box is touched: the middle of a face, an edge, a corner.
                    let b = g.bounds[slot.index()];
                    let (lo, hi) = (wide(b.lo), wide(b.hi));
                    let (middle, half) = ((lo + hi) * 0.5, (hi - lo) * 0.5);
                    let to = match k {
                        0 => [DVec3::X, DVec3::Y, DVec3::Z][dice.below(3) as usize],
                        1 => dice.point(1.0).round(),
                        _ => dice.point(1.0),
                    };
                    if g.is_visible(slot) { middle + half * to } else { dice.place(4.0) }
                }
                (ShapeKind::Triangle | ShapeKind::Copy, k) => {
                    let p = match kind {
                        ShapeKind::Copy => g.copies[row].triangle(which).map(wide),
                        _ => g.triangles.points(row).map(wide),
                    };
                    let t = [0.0, 0.25, 0.5, 1.0][dice.below(4) as usize];
                    p[k as usize % 3].lerp(p[(k as usize + 1) % 3], t)
                }
            };
            if dice.below(4) == 0 {
                // A ray that leaves the surface it is aimed at.
                from = f32s(at);
                at = dice.place(4.0);
                last = HitCode::outside(prim);
                let closed = matches!(kind, ShapeKind::Sphere | ShapeKind::Solid);
                if closed && dice.below(2) == 0 {
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

/// Streams as a renderer makes them: tiles of rays from one eye or from neighbouring points, and
/// of rays that end at one light; whole, cut short, and with strangers among them.
fn tiled_rays(dice: &mut Dice, tiles: usize) -> Rays {
    let mut rays = Rays::default();
    for _ in 0..tiles {
        let kind = dice.below(4);
        let width = [0.001, 0.05, 0.5][dice.below(3) as usize];
        let (eye, at) = (dice.place(6.0), dice.place(4.0));
        let afar = if dice.below(4) == 0 { 500.0 } else { 1.0 };
        for _ in 0..[64, 64, 64, 40, 9][dice.below(5) as usize] {
            let near = at + dice.point(width * (at - eye).length().max(0.1));
            let (from, to) = match kind {
                0 => (eye * afar, near),
                1 => (eye + dice.point(width), near),
                2 => (near, eye * afar),
                // A point on a lattice, through whose corner all go.
                _ => (eye * afar, near.round()),
            };
            let from = f32s(from);
            let way = to - DVec3::from_array(from.map(f64::from));
            let d = if way.length() > 1e-6 { way.normalize() } else { dice.direction() };
            let end = if kind == 2 { way.length() as f32 } else { f32::INFINITY };
            rays.push(from, f32s(d), end, HitCode::NONE);
            if dice.below(200) == 0 {
                rays.push(f32s(dice.place(4.0)), f32s(dice.direction()), 9.0, HitCode::NONE);
            }
            if dice.below(8) == 0 {
                let i = rays.len() - 1;
                rays.t_min[i] = dice.range(0.0, 6.0) as f32;
            }
        }
    }
    rays.pad();
    rays
}

/// Puts half of the primitives elsewhere, or takes them away.
fn moved(dice: &mut Dice, g: &Geometry) -> (Geometry, Vec<Slot>) {
    let (mut to, mut moved) = (g.clone(), Vec::new());
    for slot in g.slots() {
        if dice.below(2) == 0 {
            continue;
        }
        let (kind, row) = g.shape[slot.index()];
        let (row, way) = (row as usize, f32s(dice.point(0.3)));
        let shift = |c: &mut reflet_pack::geometry::Columns3| {
            c.x[row] += way[0];
            c.y[row] += way[1];
            c.z[row] += way[2];
        };
        let bounds = match kind {
            ShapeKind::Sphere => {
                shift(&mut to.spheres.center);
                let (c, r) = (to.spheres.center.get(row), to.spheres.radius[row]);
                let (c, r) = (c.map(f64::from), f64::from(r));
                Aabb::outward(c.map(|x| x - r), c.map(|x| x + r))
            }
            ShapeKind::Plane => {
                shift(&mut to.planes.point);
                Aabb::INFINITE
            }
            ShapeKind::Quad => {
                to.quads.corners.iter_mut().for_each(shift);
                Aabb::of_points(&to.quads.points(row))
            }
            ShapeKind::Triangle => {
                to.triangles.corners.iter_mut().for_each(shift);
                Aabb::of_points(&to.triangles.points(row))
            }
            ShapeKind::Solid => {
                let way = way.map(f64::from);
                for r in &mut to.solids.rows[row].local {
                    r[3] -= r[0] * way[0] + r[1] * way[1] + r[2] * way[2];
                }
                let b = g.bounds[slot.index()];
                let moved = |x: [f32; 3]| [0, 1, 2].map(|k| f64::from(x[k]) + way[k]);
                Aabb::outward(moved(b.lo), moved(b.hi))
            }
            ShapeKind::Copy => {
                let copy = &mut to.copies[row];
                for (w, way) in copy.world.iter_mut().zip(way) {
                    w[3] += f64::from(way);
                }
                copy.bounds()
            }
        };
        if g.is_visible(slot) {
            to.bounds[slot.index()] = if dice.below(8) == 0 { Aabb::EMPTY } else { bounds };
            moved.push(slot);
        }
    }
    (to, moved)
}

const WAYS: [Way; 3] = [Way::Auto, Way::Bundles, Way::Singly];
const STRUCTURES: [Structure; 2] = [Structure::List, Structure::Tree];

fn assert_equal(columns: &Columns, rays: &Rays) {
    let g = &columns.geometry;
    let want = defined(g, rays);
    for isa in Isa::available() {
        for structure in STRUCTURES {
            let mut accel = Accel::build(g, isa.level().expect("available"), structure);
            for way in WAYS {
                accel.cast_by(way);
                assert_gives(&accel, rays, &want, &format!("{isa:?} {structure:?} {way:?}"));
            }
        }
    }
}

fn defined(g: &Geometry, rays: &Rays) -> Vec<(f32, HitCode)> {
    let ray = |i: usize| {
        let o = [0, 1, 2].map(|k| rays.origin[k][i]);
        let d = [0, 1, 2].map(|k| rays.dir[k][i]);
        brute::closest(g, (o, d), (rays.t_min[i], rays.t_max[i]), rays.last[i])
    };
    (0..rays.len()).map(ray).collect()
}

fn assert_gives(accel: &Accel, rays: &Rays, want: &[(f32, HitCode)], how: &str) {
    let (mut hits, mut occluded) = (Hits::default(), Vec::new());
    let (mut scratch, mut counts) = (Scratch::default(), RayCounts::default());
    accel.closest(rays, &mut hits, &mut scratch, &mut counts);
    accel.any(rays, &mut occluded, &mut scratch, &mut counts);
    for (i, (t, code)) in want.iter().enumerate() {
        let got = (hits.t[i].to_bits(), hits.code[i]);
        assert_eq!(got, (t.to_bits(), *code), "closest of ray {i}, {how}");
        assert_eq!(occluded[i], !code.is_none(), "any of ray {i}, {how}");
    }
    assert_eq!((counts.closest, counts.any), (want.len() as u64, want.len() as u64));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, max_shrink_iters: 0, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_level_and_structure_gives_the_bits_of_the_definition(seed: u64, count in 0u32..120) {
        let mut dice = Dice(seed);
        let columns = scene(&mut dice, count);
        assert_equal(&columns, &aimed_rays(&mut dice, &columns, 700));
    }

    #[test]
    fn every_stream_gives_the_bits_of_the_definition(seed: u64, count in 1u32..120) {
        let mut dice = Dice(seed);
        let columns = scene(&mut dice, count);
        assert_equal(&columns, &tiled_rays(&mut dice, 16));
    }

    #[test]
    fn a_copy_is_hit_as_if_its_triangles_were_stored(seed: u64, count in 1u32..60) {
        let mut dice = Dice(seed);
        let world = world(&mut dice, count);
        let copied = packed(&world, Sharing::Always);
        let stored = packed(&world, Sharing::Never);
        prop_assert_eq!(copied.geometry.prims(), stored.geometry.len() as u32);
        let rays = aimed_rays(&mut dice, &copied, 300);
        prop_assert_eq!(defined(&copied.geometry, &rays), defined(&stored.geometry, &rays));
    }

    #[test]
    fn what_is_refitted_hits_as_what_is_built(seed: u64, count in 1u32..120) {
        let mut dice = Dice(seed);
        let columns = scene(&mut dice, count);
        let (to, changed) = moved(&mut dice, &columns.geometry);
        let mut rays = aimed_rays(&mut dice, &columns, 300);
        let tiles = tiled_rays(&mut dice, 6);
        (0..tiles.len()).for_each(|i| rays.push_from(&tiles, i));
        rays.pad();
        let want = defined(&to, &rays);
        for structure in STRUCTURES {
            let level = Isa::Auto.level().expect("always");
            let mut accel = Accel::build(&columns.geometry, level, structure);
            let done = accel.refit(&to, &changed);
            assert_gives(&accel, &rays, &want, &format!("{structure:?} {done:?}"));
            // And back.
            let done = accel.refit(&columns.geometry, &changed);
            let want = defined(&columns.geometry, &rays);
            assert_gives(&accel, &rays, &want, &format!("{structure:?} {done:?}, back"));
        }
    }
}

#[test]
fn a_small_way_is_refitted_and_a_long_one_built_anew() {
    let mut g = Geometry::default();
    for i in 0..1000 {
        g.push_sphere([(i % 10) as f32, (i / 10 % 10) as f32, (i / 100) as f32], 0.4);
    }
    let level = Isa::Auto.level().expect("always");
    let mut accel = Accel::build(&g, level, Structure::Auto);
    let cost = accel.sah_cost();
    let placed = |way: f32| {
        let mut g = Geometry::default();
        for i in 0..1000 {
            let x = (i % 10) as f32 + if i == 500 { way } else { 0.0 };
            g.push_sphere([x, (i / 10 % 10) as f32, (i / 100) as f32], 0.4);
        }
        g
    };
    assert_eq!(accel.refit(&placed(0.1), &[Slot(500)]), Refit::Refitted);
    assert!((accel.sah_cost() / cost - 1.0).abs() < 0.1);
    assert_eq!(accel.refit(&placed(100.0), &[Slot(500)]), Refit::Rebuilt);
    assert_eq!(accel.refit(&g, &[Slot(500)]), Refit::Refitted);
    let mut fewer = Geometry::default();
    fewer.push_sphere([0.0; 3], 1.0);
    assert_eq!(accel.refit(&fewer, &[]), Refit::Rebuilt);
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
