//! Lights on surfaces, and the camera on a surface or inside a solid.

use super::findings::{Findings, Kind};
use super::flat::NEAR;
use super::shapes::{Shapes, placed, point};
use reflet_scene::{DVec3, Key, Material, PointLight, Projector, Scene, Spotlight, Surface};

/// Points against surfaces: at most so many are looked at, a second's work.
const TESTS: usize = 100_000_000;

/// The lights that have a place: their keys, what they are, and where.
pub fn lights(scene: &Scene) -> impl Iterator<Item = (Key, &'static str, DVec3)> + '_ {
    scene.keys().filter_map(|key| {
        let point = || scene.get::<PointLight>(key).map(|l| ("light", l.at));
        let spot = || scene.get::<Spotlight>(key).map(|l| ("spotlight", l.at));
        let projector = || scene.get::<Projector>(key).map(|l| ("projector", l.at));
        let (what, at) = point().or_else(spot).or_else(projector)?;
        Some((key, what, at))
    })
}

/// Finds lights on surfaces, and the camera where it hardly can be meant to be. `middles` says where
/// surfaces are. Tells whether the camera is in a solid that it hardly is meant to be in.
pub fn find(
    scene: &Scene,
    shapes: &Shapes,
    middles: &[(Key, DVec3)],
    name: &dyn Fn(Key) -> String,
    findings: &mut Findings,
) -> bool {
    let mut astray = false;
    let light = |(_, what, at)| (Kind::LightOnSurface, format!("the {what} at {}", point(at)), at);
    let mut points: Vec<(Kind, String, DVec3)> = lights(scene).map(light).collect();
    if let Some(eye) = super::eye(scene) {
        for key in solids_around(scene, shapes, middles, eye) {
            astray = true;
            let text = || format!("the camera at {} is inside {}", point(eye), name(key));
            findings.add(Kind::Camera, text);
        }
        points.insert(0, (Kind::Camera, format!("the camera at {}", point(eye)), eye));
    }
    let surfaces = shapes.spheres.len() + shapes.planes.len() + shapes.quads.len();
    let triangles: usize = shapes.meshes.iter().map(|(_, m)| m.data.triangles.len()).sum();
    points.truncate((TESTS / (surfaces + shapes.triangles.len() + triangles).max(1)).max(1));
    for (kind, what, at) in points {
        for key in touching(shapes, at) {
            findings.add(kind, || format!("{what} lies on {}", name(key)));
        }
    }
    astray
}

/// The surfaces that a point lies on, within [`NEAR`] of the greatest length at hand.
fn touching(shapes: &Shapes, at: DVec3) -> Vec<Key> {
    let mut found = Vec::new();
    let reach = at.abs().max_element();
    let near = |distance: f64, size: f64| distance <= NEAR * size.max(reach);
    for (key, s) in &shapes.spheres {
        let size = s.radius.max(s.center.abs().max_element());
        if near(((at - s.center).length() - s.radius).abs(), size) {
            found.push(*key);
        }
    }
    for (key, p) in &shapes.planes {
        let distance = (at - p.point).dot(p.normal).abs() / p.normal.length();
        if near(distance, p.point.abs().max_element()) {
            found.push(*key);
        }
    }
    for (key, q) in &shapes.quads {
        if near(
            from_piece(at, q.corner, q.u, q.v, |s, t| s <= 1.0 && t <= 1.0),
            extent(q.corner, q.u, q.v),
        ) {
            found.push(*key);
        }
    }
    for (key, t) in &shapes.triangles {
        let (u, v) = (t.b - t.a, t.c - t.a);
        if near(from_piece(at, t.a, u, v, |s, t| s + t <= 1.0), extent(t.a, u, v)) {
            found.push(*key);
        }
    }
    for (key, mesh) in &shapes.meshes {
        let placed = placed(mesh);
        let on = mesh.data.triangles.iter().any(|t| {
            let [a, b, c] = t.map(|i| placed[i as usize]);
            near(from_piece(at, a, b - a, c - a, |s, t| s + t <= 1.0), extent(a, b - a, c - a))
        });
        if on {
            found.push(*key);
        }
    }
    found
}

fn extent(a: DVec3, u: DVec3, v: DVec3) -> f64 {
    a.abs().max_element().max(u.abs().max_element()).max(v.abs().max_element())
}

/// How far `at` is from the plane of a piece `a + s u + t v`; infinite beside the piece.
fn from_piece(at: DVec3, a: DVec3, u: DVec3, v: DVec3, within: impl Fn(f64, f64) -> bool) -> f64 {
    let n = u.cross(v);
    let area = n.length_squared();
    let p = at - a;
    let (s, t) = (p.cross(v).dot(n) / area, u.cross(p).dot(n) / area);
    if s >= 0.0 && t >= 0.0 && within(s, t) {
        p.dot(n).abs() / libm::sqrt(area)
    } else {
        f64::INFINITY
    }
}

/// The solids that the camera is in and hardly is meant to be in.
///
/// A sky, a room or a mirrored ball holds more than the camera: other surfaces, or lights. One that
/// is alone in the scene is meant if it is seen without light from elsewhere.
fn solids_around(scene: &Scene, shapes: &Shapes, middles: &[(Key, DVec3)], eye: DVec3) -> Vec<Key> {
    let planes = shapes.planes.iter().map(|(key, plane)| (*key, plane.point));
    let others: Vec<(Key, DVec3)> = middles.iter().copied().chain(planes).collect();
    // Of others at most `most` are looked at.
    let meant = |key: Key, most: usize, holds: &dyn Fn(DVec3) -> bool| {
        let mut others = others.iter().filter(|(other, _)| *other != key).take(most).peekable();
        let alone = others.peek().is_none();
        let shows = || {
            let worn = scene.get::<Surface>(key).and_then(|surface| surface.material);
            let plain = worn.map_or(Some(Material::default()), |key| scene.get::<Material>(key));
            plain.is_none_or(|m| m.ambient != DVec3::ZERO || m.specular != DVec3::ZERO)
        };
        lights(scene).any(|(.., at)| holds(at))
            || others.any(|(_, middle)| holds(*middle))
            || alone && shows()
    };
    let mut found = Vec::new();
    for (key, s) in &shapes.spheres {
        let holds = |at: DVec3| (at - s.center).length() < s.radius * (1.0 - NEAR);
        if holds(eye) && !meant(*key, TESTS, &holds) {
            found.push(*key);
        }
    }
    for (key, mesh) in &shapes.meshes {
        let placed = placed(mesh);
        // A closed mesh surrounds a point with 4 pi or with nothing; half says it for one that has
        // a hole, too.
        let holds = |at: DVec3| {
            let corners = mesh.data.triangles.iter().map(|t| t.map(|i| placed[i as usize] - at));
            let turns: f64 = corners.map(|[a, b, c]| solid_angle(a, b, c)).sum();
            turns.abs() > 2.0 * std::f64::consts::PI
        };
        let most = TESTS / mesh.data.triangles.len().max(1);
        if holds(eye) && !meant(*key, most, &holds) {
            found.push(*key);
        }
    }
    found
}

/// The solid angle, with sign, that a triangle takes seen from the origin (van Oosterom and
/// Strackee, "The solid angle of a plane triangle", IEEE Trans. Biomed. Eng., 1983).
fn solid_angle(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * libm::atan2(a.dot(b.cross(c)), below)
}

#[cfg(test)]
mod tests {
    use super::*;
    use reflet_scene::{Camera, Falloff, Mesh, MeshData, Plane, Quad, Shading, Sphere, Triangle};
    use std::sync::Arc;

    fn surface() -> Surface {
        Surface { material: None, visible: true }
    }

    fn found(eye: DVec3, lights: &[DVec3], build: impl FnOnce(&mut Scene)) -> Vec<String> {
        let mut scene = Scene::new();
        build(&mut scene);
        for at in lights {
            scene.spawn((PointLight {
                at: *at,
                emissivity: DVec3::ONE,
                falloff: Falloff::Inverse,
            },));
        }
        let camera = Camera::LookAt { eye, look_at: DVec3::ONE, up: DVec3::Y, fov_degrees: 45.0 };
        scene.singletons.camera = Some(scene.spawn((camera,)));
        let mut findings = Findings::default();
        let packer = reflet_pack::Packer::new(&scene, Default::default()).unwrap();
        let middles: Vec<_> = super::super::sight::middles(packer.columns()).collect();
        find(&scene, &Shapes::of(&scene), &middles, &|key| format!("#{}", key.0), &mut findings);
        findings.texts()
    }

    const FAR: DVec3 = DVec3::new(7.0, 8.0, 9.0);

    #[test]
    fn lights_on_every_shape_and_beside_it() {
        let v = DVec3::new;
        let lights = [
            v(0.6, 0.8, 0.0),   // on the sphere
            v(0.0, 0.5, 0.0),   // within it
            v(50.0, -1.0, 3.0), // on the plane
            v(5.0, 5.5, 0.5),   // on the quad
            v(5.0, 6.5, 0.5),   // beside it
            v(5.0, 5.5, 10.2),  // on the triangle
            v(5.0, 5.9, 10.9),  // beside it
        ];
        let texts = found(FAR, &lights, |scene| {
            scene.spawn((Sphere { center: DVec3::ZERO, radius: 1.0 }, surface()));
            scene.spawn((Plane { point: v(0.0, -1.0, 0.0), normal: DVec3::Y * 3.0 }, surface()));
            scene.spawn((Quad { corner: v(5.0, 5.0, 0.0), u: DVec3::Y, v: DVec3::Z }, surface()));
            let (a, b, c) = (v(5.0, 5.0, 10.0), v(5.0, 6.0, 10.0), v(5.0, 5.0, 11.0));
            scene.spawn((Triangle { a, b, c }, surface()));
        });
        assert_eq!(
            texts,
            [
                "the light at [0.6, 0.8, 0] lies on #0",
                "the light at [50, -1, 3] lies on #1",
                "the light at [5, 5.5, 0.5] lies on #2",
                "the light at [5, 5.5, 10.2] lies on #3",
            ]
        );
    }

    #[test]
    fn the_camera_inside_a_ball_and_on_it() {
        let ball = Sphere { center: DVec3::X, radius: 2.0 };
        let texts = |eye| found(eye, &[], |scene| _ = scene.spawn((ball, surface())));
        assert_eq!(texts(DVec3::ZERO), ["the camera at [0, 0, 0] is inside #0"]);
        assert_eq!(texts(DVec3::X * 3.0), ["the camera at [3, 0, 0] lies on #0"]);
        assert_eq!(texts(DVec3::X * 3.1).len(), 0);
    }

    #[test]
    fn the_camera_inside_a_mesh() {
        let data = Arc::new(MeshData {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
            ..MeshData::default()
        });
        let mesh = Mesh {
            data,
            scale: 10.0,
            rotate: DVec3::ZERO,
            translate: DVec3::ZERO,
            shading: Shading::Smooth,
            worn: [].into(),
        };
        let texts = |eye| found(eye, &[], |scene| _ = scene.spawn((mesh.clone(), surface())));
        assert_eq!(texts(DVec3::ONE), ["the camera at [1, 1, 1] is inside #0"]);
        assert_eq!(texts(DVec3::splat(4.0)).len(), 0);
        assert_eq!(texts(DVec3::splat(-0.1)).len(), 0);
    }
}
