//! Random scenes of the later words, by kind: each word alone, then all of them mixed.

use super::draw::Draw;
use super::families::{Family, HIGH, LOW, draw_of, floor, key_light, staged};
use super::place::Motion;
use super::scene::{Camera, Handle, Of, Pattern, Scene, Shape, Wears};
use super::vec3::{Vec3, v3};

pub const FLAT: Family = Family { name: "flat", scene: flat };
pub const QUADRICS: Family = Family { name: "quadrics", scene: quadrics };
pub const ROUND: Family = Family { name: "round", scene: round };
pub const INSIDE: Family = Family { name: "inside", scene: inside };
pub const PLACED: Family = Family { name: "placed", scene: placed };
pub const CELLS: Family = Family { name: "cells", scene: cells };
pub const BOXES: Family = Family { name: "boxes", scene: boxes };
pub const PICTURES: Family = Family { name: "pictures", scene: pictures };
pub const SHADERS: Family = Family { name: "shaders", scene: shaders };
pub const LAMPS: Family = Family { name: "lamps", scene: lamps };
pub const ORTHO: Family = Family { name: "ortho", scene: ortho };
pub const MESHES: Family = Family { name: "meshes", scene: meshes };
pub const MIXED: Family = Family { name: "mixed", scene: mixed };

/// Discs and boxes.
fn flat(seed: u64) -> Scene {
    of_shapes(seed, |d, scene, i| {
        if i % 2 == 0 {
            let disc = d.disc(LOW, HIGH);
            let wears = if d.chance(50) {
                let normal = super::draw::normal_of(&disc);
                d.checker(scene, normal, 0.2, 0.9)
            } else {
                d.material(scene, 60)
            };
            (disc, wears)
        } else {
            (d.cuboid(LOW, HIGH), d.material(scene, 60))
        }
    })
}

/// The quadrics, with caps and without.
fn quadrics(seed: u64) -> Scene {
    of_shapes(seed, |d, scene, _| (d.quadric(LOW, HIGH), d.material(scene, 60)))
}

/// Ellipsoids and tori.
fn round(seed: u64) -> Scene {
    of_shapes(seed, |d, scene, i| {
        let shape = if i % 2 == 0 { d.torus(LOW, HIGH) } else { d.ellipsoid(LOW, HIGH) };
        (shape, d.material(scene, 60))
    })
}

/// Solid checkers and stripes, on any shape.
fn cells(seed: u64) -> Scene {
    of_shapes(seed, |d, scene, _| {
        let shape = d.shape(LOW, HIGH);
        let wears = d.cells(scene, &shape);
        (shape, wears)
    })
}

/// Turned boxes and tins whose patterns begin in their faces: no rounding may speckle these.
fn boxes(seed: u64) -> Scene {
    let mut d = draw_of(seed);
    let mut scene = staged(&mut d);
    key_light(&mut d, &mut scene);
    for i in 0..d.int(2, 4) {
        let (low, high) = (Vec3::splat(-0.8), Vec3::splat(0.2));
        let axis = v3(0.0, 0.0, d.range(0.5, 2.0));
        let shape = match i % 2 {
            0 => d.cuboid(low, high),
            _ => {
                let (base, radius) = (d.point(low, high), d.range(0.4, 0.8));
                Shape::Cylinder { base, axis, radius, height: d.range(0.5, 1.2), caps: true }
            }
        };
        let even = scene.material(Vec3::splat(1.0), Vec3::ZERO, Vec3::ZERO);
        let odd = scene.material(Vec3::splat(4.0), Vec3::ZERO, Vec3::ZERO);
        let (Wears::Material(even), Wears::Material(odd)) = (even, odd) else { unreachable!() };
        let xdir = if i % 2 == 0 { v3(1.0, 0.0, 0.0) } else { axis };
        let wears = scene.pattern(if d.chance(50) {
            Pattern::Solid { even, odd, size: [0.33, 0.29, 0.37] }
        } else {
            Pattern::Stripes { even, odd, width: 0.27, xdir }
        });
        let handle = scene.surface(shape, wears);
        let motion = d.motion(LOW, HIGH);
        scene.thing(Of::Group(vec![handle]), motion);
    }
    scene
}

/// Pictures on any shape, as a whole and in tiles.
fn pictures(seed: u64) -> Scene {
    let name = format!("pictures-{seed}");
    let mut scene = of_shapes(seed, |d, scene, _| {
        let shape = d.shape(LOW, HIGH);
        let wears = d.textured(scene, &name, &shape);
        (shape, wears)
    });
    let mut d = draw_of(seed + 1000);
    let wall = Shape::Plane { point: v3(0.0, 0.0, -7.0), normal: v3(0.2, 0.1, 1.0) };
    let wears = d.textured(&mut scene, &name, &wall);
    scene.surface(wall, wears);
    scene
}

/// Meshes from files of each kind, in one material, in those of the file, in cells and in pictures;
/// and copies of them.
fn meshes(seed: u64) -> Scene {
    let name = format!("meshes-{seed}");
    let mut scene = of_shapes(seed, |d, scene, i| {
        let mesh = d.mesh(&format!("{name}-{i}"), LOW, HIGH);
        let (by_file, has_uvs) = (!mesh.materials.is_empty(), !mesh.uvs.is_empty());
        let shape = super::mesh::shape(mesh);
        let wears = if by_file && d.chance(60) {
            Wears::File
        } else if has_uvs && d.chance(40) {
            d.textured(scene, &name, &shape)
        } else if d.chance(30) {
            d.cells(scene, &shape)
        } else {
            d.material(scene, 50)
        };
        (shape, wears)
    });
    let mut d = draw_of(seed + 1000);
    let is_mesh = |i: &usize| matches!(scene.surfaces[*i].shape, Shape::Mesh { .. });
    let of: Vec<usize> = (0..scene.surfaces.len()).filter(is_mesh).collect();
    for _ in 0..d.int(0, 2) {
        let of = Handle::Surface(of[d.int(0, of.len() - 1)]);
        let motion = d.motion(v3(-1.5, -0.5, -1.5), v3(1.5, 1.0, 1.0));
        scene.thing(Of::Instance(of), motion);
    }
    scene
}

/// Shaders on any shape.
fn shaders(seed: u64) -> Scene {
    of_shapes(seed, |d, scene, _| (d.shape(LOW, HIGH), d.shaded(scene)))
}

/// Two to seven surfaces over a floor, one or two lights.
fn of_shapes(
    seed: u64,
    mut surface: impl FnMut(&mut Draw, &mut Scene, usize) -> (Shape, Wears),
) -> Scene {
    let mut d = draw_of(seed);
    let mut scene = staged(&mut d);
    for _ in 0..d.int(1, 2) {
        key_light(&mut d, &mut scene);
    }
    if d.chance(60) {
        floor(&mut d, &mut scene);
    }
    for i in 0..d.int(2, 7) {
        let (shape, wears) = surface(&mut d, &mut scene, i);
        scene.surface(shape, wears);
    }
    scene
}

/// The eye and the light inside of a closed or an open shell that mirrors, with things in it.
fn inside(seed: u64) -> Scene {
    let mut d = draw_of(seed);
    let eye = d.point(Vec3::splat(-0.5), Vec3::splat(0.5));
    let look_at = eye + d.vector(1.0);
    let mut scene = Scene::empty(super::families::WIDTH, super::families::HEIGHT, eye, look_at);
    let fov_degrees = d.range(50.0, 100.0);
    // Any view but along `up`.
    let up = (look_at - eye).cross(v3(0.3, 0.2, 0.9)).map(|x| d.round(x));
    scene.camera = Camera::LookAt { eye, look_at, up, fov_degrees };
    scene.settings.max_bounces = d.int(1, 5);
    let at = d.point(Vec3::splat(-0.8), Vec3::splat(0.8));
    let emissivity = d.colour(6.0, 25.0);
    scene.light(at, emissivity);
    let size = d.range(2.0, 3.5);
    let (o, caps) = (d.point(Vec3::splat(-0.2), Vec3::splat(0.2)), d.chance(60));
    let axis = d.axis();
    // So far back along the axis that the eye is in the middle.
    let back = (o - axis.unit() * size).map(|x| d.round(x));
    let height = d.round(2.0 * size);
    let shell = match seed % 7 {
        0 => Shape::Cylinder { base: back, axis, radius: size, height, caps },
        1 => Shape::Cone { apex: back, axis, radius: height, height, caps },
        2 => Shape::Paraboloid { vertex: back, axis, radius: height, height, caps },
        3 => Shape::Hyperboloid { center: o, axis, radius: height, waist: 2.0, height, caps },
        4 => Shape::Ellipsoid { center: o, radii: v3(size, d.range(1.5, 3.0), height) },
        5 => Shape::Cuboid { min: o - v3(size, height, 2.0), max: o + v3(height, size, 2.0) },
        _ => Shape::Torus {
            center: o + v3(size, 0.0, 0.0),
            axis: v3(0.0, 1.0, 0.0),
            major: size,
            minor: 1.7,
        },
    };
    let specular = d.specular(0.3, 0.9);
    let (ambient, diffuse) = (d.colour(0.0, 0.2), d.colour(0.1, 0.8));
    let wears = scene.material(ambient, diffuse, specular);
    scene.surface(shell, wears);
    for _ in 0..d.int(0, 2) {
        let core = d.sphere(v3(-1.4, -1.4, -1.4), v3(-0.9, 1.4, 1.4), [0.1, 0.35]);
        let wears = d.material(&mut scene, 40);
        scene.surface(core, wears);
    }
    scene
}

/// Groups and instances, nested, of any shapes.
fn placed(seed: u64) -> Scene {
    let mut d = draw_of(seed);
    let mut scene = staged(&mut d);
    key_light(&mut d, &mut scene);
    key_light(&mut d, &mut scene);
    if d.chance(60) {
        floor(&mut d, &mut scene);
    }
    place(&mut d, &mut scene, |d, scene, shape| {
        if super::shape::is_flat(shape) && d.chance(40) {
            d.checker(scene, super::draw::normal_of(shape), 0.2, 0.8)
        } else {
            d.material(scene, 50)
        }
    });
    scene
}

/// A group of two or three shapes around the origin, moved into the stage; copies of it, of a
/// member of it, of a copy, and a group of copies.
fn place(
    d: &mut Draw,
    scene: &mut Scene,
    mut wears: impl FnMut(&mut Draw, &mut Scene, &Shape) -> Wears,
) {
    let near = |d: &mut Draw| d.shape(Vec3::splat(-0.8), Vec3::splat(0.8));
    let mut members = Vec::new();
    for _ in 0..d.int(2, 3) {
        let shape = near(d);
        let wears = wears(d, scene, &shape);
        members.push(scene.surface(shape, wears));
    }
    if d.chance(20)
        && let Handle::Surface(i) = members[0]
    {
        scene.surfaces[i].visible = false;
    }
    let motion = d.motion(LOW, HIGH);
    let group = scene.thing(Of::Group(members.clone()), motion);
    // Of a group the copy has the group's own motion too: so it stays about there.
    let aside = |d: &mut Draw| d.motion(v3(-1.5, -0.5, -1.5), v3(1.5, 1.0, 1.0));
    if d.chance(60) {
        let motion = aside(d);
        let copy = scene.thing(Of::Instance(group), motion);
        if d.chance(40) {
            let motion = aside(d);
            scene.thing(Of::Instance(copy), motion);
        }
    }
    if d.chance(40) {
        let motion = d.motion(LOW, HIGH);
        scene.thing(Of::Instance(members[1]), motion);
    }
    // A prototype out of the picture, and a group of its copies in a group.
    let shape = near(d);
    let wears = wears(d, scene, &shape);
    let prototype = scene.surface(shape, wears);
    if d.chance(60)
        && let Handle::Surface(i) = prototype
    {
        scene.surfaces[i].visible = false;
    }
    let mut copies = Vec::new();
    for _ in 0..d.int(1, 4) {
        let motion = d.motion(v3(-2.0, 0.0, -2.0), v3(2.0, 1.5, 1.0));
        copies.push(scene.thing(Of::Instance(prototype), motion));
    }
    let inner = scene.thing(Of::Group(copies), Motion::NONE);
    let outer = d.motion(v3(-1.0, 0.5, -1.0), v3(1.0, 1.0, 0.5));
    let outer = scene.thing(Of::Group(vec![inner]), outer);
    if d.chance(10)
        && let Handle::Thing(i) = outer
    {
        scene.things[i].visible = false;
    }
}

/// Suns, projectors, falloffs.
fn lamps(seed: u64) -> Scene {
    let name = format!("lamps-{seed}");
    let mut d = draw_of(seed);
    let mut scene = staged(&mut d);
    for _ in 0..d.int(1, 4) {
        d.lamp(&mut scene, &name);
    }
    floor(&mut d, &mut scene);
    for _ in 0..d.int(1, 6) {
        let shape = d.shape(LOW, HIGH);
        let wears = d.material(&mut scene, 40);
        scene.surface(shape, wears);
    }
    scene
}

/// Parallel rays.
fn ortho(seed: u64) -> Scene {
    let mut scene = of_shapes(seed, |d, scene, _| (d.shape(LOW, HIGH), d.material(scene, 50)));
    parallel(&mut draw_of(seed + 1000), &mut scene);
    scene
}

fn parallel(d: &mut Draw, scene: &mut Scene) {
    if let Camera::LookAt { eye, look_at, up, .. } = scene.camera {
        scene.camera = Camera::Ortho { eye, look_at, up, height: d.range(2.0, 7.0) };
    }
}

/// Everything.
fn mixed(seed: u64) -> Scene {
    let name = format!("mixed-{seed}");
    let mut d = draw_of(seed);
    let mut scene = staged(&mut d);
    if d.chance(30) {
        parallel(&mut d, &mut scene);
    }
    key_light(&mut d, &mut scene);
    for _ in 0..d.int(0, 2) {
        d.lamp(&mut scene, &name);
    }
    let ground = Shape::Plane { point: Vec3::ZERO, normal: v3(0.0, 1.0, 0.0) };
    let ground_wears = d.wears(&mut scene, &name, &ground);
    scene.surface(ground, ground_wears);
    for _ in 0..d.int(1, 5) {
        let shape = d.shape(LOW, HIGH);
        let wears = d.wears(&mut scene, &name, &shape);
        scene.surface(shape, wears);
    }
    place(&mut d, &mut scene, |d, scene, shape| d.wears(scene, &name, shape));
    scene
}
