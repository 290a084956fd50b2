//! Lights on surfaces, and the camera on a surface or inside a solid.

use super::findings::{Findings, Kind};
use super::flat::NEAR;
use super::shapes::{Shapes, placed, point};
use reflet_scene::{Camera, DVec3, Key, PointLight, Scene, Spotlight};

/// Points against surfaces: at most so many are looked at, a second's work.
const TESTS: usize = 100_000_000;

/// Finds lights on surfaces, and the camera where it hardly can be meant to be.
///
/// The inside of a mirrored ball is a legitimate place for a camera: it is a warning, no error.
pub fn find(scene: &Scene, shapes: &Shapes, name: &dyn Fn(Key) -> String, findings: &mut Findings) {
    let light = |key| {
        let at = scene.get::<PointLight>(key).map(|l| ("light", l.at));
        at.or_else(|| scene.get::<Spotlight>(key).map(|l| ("spotlight", l.at)))
    };
    let mut points: Vec<(Kind, String, DVec3)> = scene
        .keys()
        .filter_map(light)
        .map(|(what, at)| (Kind::LightOnSurface, format!("the {what} at {}", point(at)), at))
        .collect();
    let eye = scene.singletons.camera.and_then(|key| scene.get::<Camera>(key)).map(|c| match c {
        Camera::LookAt { eye, .. } | Camera::Parallel { eye, .. } => eye,
        Camera::Window { viewpoint, .. } => viewpoint,
    });
    if let Some(eye) = eye {
        inside(shapes, eye, name, findings);
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

fn inside(shapes: &Shapes, eye: DVec3, name: &dyn Fn(Key) -> String, findings: &mut Findings) {
    let mut add = |key| {
        let text = || format!("the camera at {} is inside {}", point(eye), name(key));
        findings.add(Kind::Camera, text);
    };
    for (key, s) in &shapes.spheres {
        if (eye - s.center).length() < s.radius * (1.0 - NEAR) {
            add(*key);
        }
    }
    for (key, mesh) in &shapes.meshes {
        let at = placed(mesh);
        let turns: f64 = mesh
            .data
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|i| at[i as usize] - eye);
                solid_angle(a, b, c)
            })
            .sum();
        // A closed mesh surrounds a point with 4 pi or with nothing; half says it for one that has
        // a hole, too.
        if turns.abs() > 2.0 * std::f64::consts::PI {
            add(*key);
        }
    }
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
    use reflet_scene::{Falloff, Mesh, MeshData, Plane, Quad, Shading, Sphere, Surface, Triangle};
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
        find(&scene, &Shapes::of(&scene), &|key| format!("#{}", key.0), &mut findings);
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
