//! The oracle's own sanity for the later words: its roots against the definitions by dense sampling,
//! hand-computed values for the rest.

mod oracle;

use oracle::draw::{Draw, Rounding};
use oracle::families::Family;
use oracle::pattern::{Point, material};
use oracle::place::{Motion, shown};
use oracle::scene::{Camera, Falloff, Light, Of, Pattern, Scene, Shape, Sun};
use oracle::shape::{Part, own_normal, root, x_across};
use oracle::texture::{Edge, Filter, Slide, Texture, decoded};
use oracle::uv::uv;
use oracle::vec3::{Vec3, v3};
use oracle::view::picture;
use oracle::words;

const X: Vec3 = v3(1.0, 0.0, 0.0);
const Y: Vec3 = v3(0.0, 1.0, 0.0);
const Z: Vec3 = v3(0.0, 0.0, 1.0);

fn grey(x: f64) -> Vec3 {
    Vec3::splat(x)
}

fn near(got: Vec3, want: Vec3) {
    assert!((got - want).largest() <= 1e-13 * want.largest().max(1.0), "{got:?} is not {want:?}");
}

/// 0 on the curved part of a shape and of different signs on its two sides, as the shape is defined.
fn implicit(shape: &Shape, p: Vec3) -> f64 {
    let around = |o: Vec3, axis: Vec3| {
        let z = (p - o).dot(axis.unit());
        ((p - o - axis.unit() * z).length(), z)
    };
    match *shape {
        Shape::Cylinder { base, axis, radius, .. } => around(base, axis).0 - radius,
        Shape::Cone { apex, axis, radius, height, .. } => {
            let (rho, z) = around(apex, axis);
            rho - radius * z / height
        }
        Shape::Paraboloid { vertex, axis, radius, height, .. } => {
            let (rho, z) = around(vertex, axis);
            rho * rho - radius * radius * z / height
        }
        Shape::Hyperboloid { center, axis, radius, waist, height, .. } => {
            let (rho, z) = around(center, axis);
            let grown = (radius * radius - waist * waist) * z * z / (height * height);
            rho * rho - waist * waist - grown
        }
        Shape::Ellipsoid { center, radii } => {
            let q = (p - center).zip(radii, |x, r| x / r);
            q.dot(q) - 1.0
        }
        Shape::Torus { center, axis, major, minor } => {
            let (rho, z) = around(center, axis);
            (rho - major).powi(2) + z * z - minor * minor
        }
        _ => unreachable!("a flat shape"),
    }
}

/// The range of z, the way along the axis.
fn z_range(shape: &Shape, p: Vec3) -> bool {
    let (o, axis, low, high) = match *shape {
        Shape::Cylinder { base: o, axis, height, .. }
        | Shape::Cone { apex: o, axis, height, .. }
        | Shape::Paraboloid { vertex: o, axis, height, .. } => (o, axis, 0.0, height),
        Shape::Hyperboloid { center, axis, height, .. } => (center, axis, -height, height),
        _ => return true,
    };
    (low..=high).contains(&(p - o).dot(axis.unit()))
}

/// All places along a ray where the implicit function changes its sign, within the range.
fn sampled(shape: &Shape, base: Vec3, dir: Vec3) -> Vec<f64> {
    let at = |t: f64| implicit(shape, base + dir * t);
    const STEPS: usize = 4000;
    let step = 16.0 / STEPS as f64;
    let mut found = Vec::new();
    for i in 0..STEPS {
        // From a little beyond the origin: a ray that leaves the body starts at a root.
        let (mut low, mut high) = (1e-4 + i as f64 * step, 1e-4 + (i + 1) as f64 * step);
        if (at(low) < 0.0) == (at(high) < 0.0) {
            continue;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if (at(middle) < 0.0) == (at(low) < 0.0) {
                low = middle;
            } else {
                high = middle;
            }
        }
        if z_range(shape, base + dir * low) {
            found.push(low);
        }
    }
    found
}

/// The body's roots, each found as the nearest one from the root before.
#[test]
fn roots_are_where_the_definition_changes_its_sign() {
    let mut d = Draw::new(5, Rounding::Decimal);
    let (low, high) = (Vec3::splat(-0.5), Vec3::splat(0.5));
    let (mut met, mut several) = (0, 0);
    for i in 0..600 {
        let mut shape = match i % 3 {
            0 => d.torus(low, high),
            1 => d.ellipsoid(low, high),
            _ => d.quadric(low, high),
        };
        if let Shape::Cylinder { caps, .. }
        | Shape::Cone { caps, .. }
        | Shape::Paraboloid { caps, .. }
        | Shape::Hyperboloid { caps, .. } = &mut shape
        {
            *caps = false;
        }
        let mut base = d.vector(4.0);
        if let Shape::Torus { center, axis, .. } = shape
            && i % 2 == 0
        {
            // Through both sides of the tube.
            base = center + x_across(axis.unit(), X) * 4.0 + axis.unit() * d.range(-0.4, 0.4);
        }
        let dir = (d.point(low, high) - base).unit();
        let want = sampled(&shape, base, dir);
        let (mut got, mut from, mut leaves) = (Vec::new(), 0.0, None);
        while let Some((t, part)) = root(&shape, base + dir * from, dir, leaves) {
            from += t;
            got.push(from);
            leaves = Some(part);
            assert!(got.len() < 9, "{shape:?}: {got:?}");
        }
        // A grazing ray may meet twice between two samples.
        if got.len() != want.len() {
            let p = base + dir * got.first().or(want.first()).copied().expect("one of them");
            let cos = own_normal(&shape, Part::Body, p).dot(dir).abs();
            assert!(cos < 0.1, "{shape:?} from {base:?} along {dir:?}: {got:?}, sampled {want:?}");
            continue;
        }
        for (g, w) in got.iter().zip(&want) {
            assert!((g - w).abs() < 1e-7, "{shape:?}: {got:?}, sampled {want:?}");
        }
        met += usize::from(!got.is_empty());
        several += usize::from(got.len() > 2);
    }
    assert!(met > 300 && several > 20, "{met} met, {several} with more than two roots");
}

/// Across the body is where the implicit function grows most.
#[test]
fn normals_are_gradients() {
    let mut d = Draw::new(9, Rounding::Decimal);
    let (low, high) = (Vec3::splat(-0.5), Vec3::splat(0.5));
    let mut met = 0;
    for i in 0..200 {
        let shape = match i % 3 {
            0 => d.torus(low, high),
            1 => d.ellipsoid(low, high),
            _ => d.quadric(low, high),
        };
        let base = d.vector(4.0);
        let dir = (d.point(low, high) - base).unit();
        let Some((t, Part::Body)) = root(&shape, base, dir, None) else { continue };
        let p = base + dir * t;
        let slope = |e: Vec3| implicit(&shape, p + e * 1e-5) - implicit(&shape, p - e * 1e-5);
        let gradient = v3(slope(X), slope(Y), slope(Z)).unit();
        let off = (gradient - own_normal(&shape, Part::Body, p)).length();
        assert!(off < 1e-6, "{shape:?} at {p:?}: {off:.1e}");
        met += 1;
    }
    assert!(met > 100, "{met}");
}

#[test]
fn a_ray_that_leaves_meets_the_other_roots() {
    let tube = Shape::Cylinder { base: Vec3::ZERO, axis: Y, radius: 1.0, height: 4.0, caps: true };
    let from = v3(1.0, 1.0, 0.0);
    let leaves = Some(Part::Body);
    assert_eq!(root(&tube, from, -X, leaves), Some((2.0, Part::Body)));
    assert_eq!(root(&tube, from, X, leaves), None);
    // Up the wall: the cap, from below.
    let (t, part) = root(&tube, from, v3(-0.2, 3.0, 0.0), leaves).expect("the cap");
    assert_eq!((t, part), (1.0, Part::Flat(1)));
    // From the cap: not the cap again, but the other one, in units of the direction's own length.
    let cap = Some(Part::Flat(1));
    assert_eq!(root(&tube, v3(0.0, 4.0, 0.5), Y * -2.0, cap), Some((2.0, Part::Flat(0))));
    assert_eq!(root(&tube, v3(0.0, 4.0, 0.5), Y, cap), None);
    let ring = Shape::Torus { center: Vec3::ZERO, axis: Y, major: 2.0, minor: 0.5 };
    let (t, _) = root(&ring, v3(-1.5, 0.0, 0.0), X, leaves).expect("the other side of the hole");
    assert!((t - 3.0).abs() < 1e-12, "{t}");
    let (t, _) = root(&ring, v3(-1.5, 0.0, 0.0), -X, leaves).expect("the tube's own other side");
    assert!((t - 1.0).abs() < 1e-12, "{t}");
    let dice = Shape::Cuboid { min: grey(-1.0), max: grey(1.0) };
    assert_eq!(root(&dice, Z * -1.0, Z, Some(Part::Flat(4))), Some((2.0, Part::Flat(5))));
    assert_eq!(root(&dice, Z * -1.0, -Z, Some(Part::Flat(4))), None);
}

#[test]
fn coordinates_of_pictures() {
    let at = |shape: Shape, part: Part, p: Vec3| uv(&shape, part, p);
    let globe = Shape::Sphere { center: X, radius: 2.0 };
    // Longitude runs from +x toward -z, as a globe is printed, seen from outside to the right.
    assert_eq!(at(globe, Part::Body, v3(3.0, 0.0, 0.0)), (0.0, 0.5));
    assert_eq!(at(globe, Part::Body, v3(1.0, 0.0, -2.0)), (0.25, 0.5));
    assert_eq!(at(globe, Part::Body, v3(1.0, 2.0, 0.0)).1, 1.0);
    let tin = Shape::Cylinder { base: Vec3::ZERO, axis: Y, radius: 1.0, height: 4.0, caps: true };
    assert_eq!(at(tin, Part::Body, v3(0.0, 1.0, -1.0)), (0.25, 0.25));
    assert_eq!(at(tin, Part::Flat(1), v3(0.5, 4.0, 0.0)), (0.75, 0.5));
    // y is normal x x: on the top, toward -z.
    assert_eq!(at(tin, Part::Flat(1), v3(0.0, 4.0, -1.0)), (0.5, 1.0));
    let box_ = Shape::Cuboid { min: Vec3::ZERO, max: v3(2.0, 4.0, 8.0) };
    let p = v3(0.5, 1.0, 2.0);
    let faces = [0, 1, 2, 3, 4, 5].map(|face| at(box_, Part::Flat(face), p));
    let want = [(0.25, 0.25), (0.75, 0.25), (0.25, 0.25), (0.25, 0.75), (0.75, 0.25), (0.25, 0.25)];
    assert_eq!(faces, want);
    let ring = Shape::Torus { center: Vec3::ZERO, axis: Y, major: 2.0, minor: 0.5 };
    assert_eq!(at(ring, Part::Body, v3(2.5, 0.0, 0.0)), (0.0, 0.0));
    assert_eq!(at(ring, Part::Body, v3(0.0, 0.5, -2.0)), (0.25, 0.25));
    let quad = Shape::Quad { corner: Vec3::ZERO, u: X * 2.0, v: v3(1.0, 4.0, 0.0) };
    assert_eq!(at(quad, Part::Flat(0), v3(1.5, 2.0, 0.0)), (0.5, 0.5));
}

#[test]
fn texels_and_the_ways_between_them() {
    // Two columns, two rows: black and white above white and black.
    let texels = vec![[0; 3], [255; 3], [255; 3], [0; 3]];
    let t = Texture { file: String::new(), width: 2, height: 2, texels };
    let at = |s: f64, v: f64, filter, edge| t.at(s, v, filter, edge)[0];
    assert_eq!(at(0.1, 0.9, Filter::Nearest, Edge::Clamp), 0.0);
    assert_eq!(at(0.1, 0.1, Filter::Nearest, Edge::Clamp), 1.0);
    assert_eq!(at(0.25, 0.75, Filter::Bilinear, Edge::Clamp), 0.0);
    assert_eq!(at(0.5, 0.75, Filter::Bilinear, Edge::Clamp), 0.5);
    // At the left edge: the same texel again, or half of the one at the right.
    assert_eq!(at(0.0, 0.75, Filter::Bilinear, Edge::Clamp), 0.0);
    assert_eq!(at(0.0, 0.75, Filter::Bilinear, Edge::Wrap), 0.5);
    // Half of the way up the curve is about a fifth of the light.
    assert!((decoded(128) - 0.2158605).abs() < 1e-6 && decoded(255) == 1.0);
}

#[test]
fn motions_nest() {
    let m = Motion { translate: X, rotate: v3(0.0, 0.0, 90.0), scale: v3(2.0, 3.0, 1.0) };
    near(m.point_shown(v3(1.0, 0.0, 0.0)), v3(1.0, 2.0, 0.0));
    near(m.point_within(v3(1.0, 2.0, 0.0)), X);
    // About x, then y: y goes to z, then to x.
    let m = Motion { translate: Vec3::ZERO, rotate: v3(90.0, 90.0, 0.0), ..Motion::NONE };
    near(m.point_shown(Y), X);
    let ball = Shape::Sphere { center: X, radius: 1.0 };
    let mut s = Scene::empty(1, 1, Z, Vec3::ZERO);
    let matt = s.material(grey(1.0), Vec3::ZERO, Vec3::ZERO);
    let ball = s.surface(ball, matt);
    let moved = |x: f64| Motion { translate: X * x, ..Motion::NONE };
    let group = s.thing(Of::Group(vec![ball]), moved(10.0));
    let copy = s.thing(Of::Instance(group), moved(100.0));
    s.thing(Of::Instance(copy), moved(1000.0));
    // A member's copy knows nothing of the group.
    s.thing(Of::Instance(ball), moved(10000.0));
    let mut at: Vec<f64> = shown(&s)
        .iter()
        .map(|c| c.motions.iter().rev().fold(X, |p, m| m.point_shown(p))[0])
        .collect();
    at.sort_by(f64::total_cmp);
    assert_eq!(at, [11.0, 111.0, 1111.0, 10001.0]);
    s.things[0].visible = false;
    assert_eq!(shown(&s).len(), 3, "a prototype out of the picture");
    s.surfaces[0].visible = false;
    assert_eq!(shown(&s).len(), 1, "the flags of a group's members are its copies' too");
}

/// A wall in z = 0 that is seen at the origin from 2 before it, lit by `light`.
fn lit(light: Light) -> f64 {
    let mut s = Scene::empty(1, 1, Z * 2.0, Vec3::ZERO);
    let matt = s.material(Vec3::ZERO, grey(1.0), Vec3::ZERO);
    s.surface(Shape::Plane { point: Vec3::ZERO, normal: Z }, matt);
    s.lights.push(light);
    picture(&s).at(0, 0)[0] * 2.0
}

#[test]
fn falloffs() {
    let at = v3(3.0, 0.0, 4.0);
    let light = |falloff| Light { at, emissivity: grey(10.0), falloff, cone: None, slide: None };
    assert!((lit(light(Falloff::Inverse)) - 10.0 * 0.8 / 5.0).abs() < 1e-14);
    assert!((lit(light(Falloff::None)) - 10.0 * 0.8).abs() < 1e-14);
    assert!((lit(light(Falloff::Square)) - 10.0 * 0.8 / 25.0).abs() < 1e-14);
}

#[test]
fn a_sun_is_a_cosine() {
    let mut s = Scene::empty(1, 1, Z * 2.0, Vec3::ZERO);
    let matt = s.material(Vec3::ZERO, grey(1.0), Vec3::ZERO);
    s.surface(Shape::Plane { point: Vec3::ZERO, normal: Z }, matt);
    s.suns.push(Sun { direction: v3(-3.0, 0.0, -4.0), emissivity: grey(5.0) });
    near(picture(&s).at(0, 0), grey(5.0 * 0.8 / 2.0));
    s.surface(Shape::Sphere { center: v3(300.0, 0.0, 400.0), radius: 1.0 }, matt);
    near(picture(&s).at(0, 0), Vec3::ZERO);
}

#[test]
fn a_slide_is_upright_and_unmirrored() {
    // Four texels: red, green above blue, white. The projector stands at z = 4 and throws them on
    // the wall in z = 0, 8 wide at an angle of 45 degrees.
    let texels = vec![[255, 0, 0], [0, 255, 0], [0, 0, 255], [255; 3]];
    let texture = Texture { file: String::new(), width: 2, height: 2, texels };
    let slide = Slide { aim: Vec3::ZERO, up: Y, half_width_degrees: 45.0, texture: 0 };
    let seen = |x: f64, y: f64| {
        let p = v3(x, y, 0.0);
        let mut s = Scene::empty(1, 1, p + Z, p);
        let matt = s.material(Vec3::ZERO, grey(1.0), Vec3::ZERO);
        s.surface(Shape::Plane { point: Vec3::ZERO, normal: Z }, matt);
        s.textures.push(texture.clone());
        s.projector(Z * 4.0, slide, grey(1.0));
        picture(&s).at(0, 0).map(|c| if c > 0.0 { 1.0 } else { 0.0 })
    };
    assert_eq!([seen(-2.0, 2.0), seen(2.0, 2.0)], [X, Y]);
    assert_eq!([seen(-2.0, -2.0), seen(2.0, -2.0)], [Z, grey(1.0)]);
    assert_eq!([seen(-4.1, 0.5), seen(0.5, 4.1)], [Vec3::ZERO; 2]);
    assert_eq!([seen(-3.9, 0.5), seen(0.5, 3.9)], [X, Y]);
}

#[test]
fn parallel_rays_keep_their_distance() {
    // 4 high, 8 wide: pixels are 1 x 1, so a wall of 3 x 1 fills three of them at any distance.
    for z in [0.0, -50.0] {
        let mut s = Scene::empty(8, 4, Z, Vec3::ZERO);
        let (eye, look_at) = (Z, Vec3::ZERO);
        s.camera = Camera::Ortho { eye, look_at, up: Y, height: 4.0 };
        let glow = s.material(grey(1.0), Vec3::ZERO, Vec3::ZERO);
        let corner = v3(-2.0, 1.0, z);
        s.surface(Shape::Quad { corner, u: X * 3.0, v: Y }, glow);
        let lit: Vec<usize> = (0..32).filter(|i| picture(&s).pixels[*i] != Vec3::ZERO).collect();
        assert_eq!(lit, [2, 3, 4]);
        near(picture(&s).at(3, 0), grey(1.0 / (1.0 - z)));
    }
}

#[test]
fn cells_and_stripes() {
    let mut s = Scene::empty(1, 1, Z, Vec3::ZERO);
    s.material(grey(1.0), Vec3::ZERO, Vec3::ZERO);
    s.material(grey(2.0), Vec3::ZERO, Vec3::ZERO);
    let solid = s.pattern(Pattern::Solid { even: 0, odd: 1, size: [1.0, 0.5, 2.0] });
    let stripes =
        s.pattern(Pattern::Stripes { even: 0, odd: 1, width: 0.5, xdir: v3(0.0, 2.0, 0.0) });
    let ball = Shape::Sphere { center: grey(10.0), radius: 3.0 };
    s.surface(ball, solid);
    s.surface(ball, stripes);
    let seen = |surface: usize, q: Vec3| {
        let at = Point { p: grey(10.0) + q, part: Part::Body, facing: X };
        material(&s, surface, at).ambient[0]
    };
    assert_eq!(seen(0, v3(0.5, 0.2, 0.5)), 1.0);
    assert_eq!(seen(0, v3(-0.5, 0.2, 0.5)), 2.0);
    assert_eq!(seen(0, v3(-0.5, 0.7, 0.5)), 1.0);
    assert_eq!(seen(0, v3(-0.5, 0.7, -0.5)), 2.0);
    assert_eq!([seen(1, Y * 0.4), seen(1, Y * 0.6), seen(1, Y * -0.1)], [1.0, 2.0, 2.0]);
}

/// Every family shows something, and not the same thing: what the binary is held against is no
/// empty picture.
#[test]
fn families_show_what_they_are_about() {
    let all: [Family; 11] = [
        words::FLAT,
        words::QUADRICS,
        words::ROUND,
        words::INSIDE,
        words::PLACED,
        words::CELLS,
        words::PICTURES,
        words::SHADERS,
        words::LAMPS,
        words::ORTHO,
        words::MIXED,
    ];
    for family in all {
        let mut shares = Vec::new();
        for seed in 0..12 {
            let picture = picture(&(family.scene)(seed));
            assert!(picture.pixels.iter().all(|p| p.is_finite()), "{} {seed}", family.name);
            let bright = picture.pixels.iter().filter(|p| p.largest() > 0.02).count();
            shares.push(bright as f64 / picture.pixels.len() as f64);
        }
        shares.sort_by(f64::total_cmp);
        println!("{}: {shares:.2?}", family.name);
        assert!(shares[6] > 0.25, "{}: {shares:.2?} of the pixels are not dark", family.name);
    }
}
