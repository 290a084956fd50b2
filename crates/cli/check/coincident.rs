//! Surfaces that coincide: which of them a ray hits is not promised.

use super::findings::{Findings, Kind};
use super::flat::{Flats, NEAR, Piece, PlaneOf};
use super::shapes::{Shapes, placed};
use reflet_scene::{DVec3, Key, Mesh, Triangle};
use std::collections::HashMap;
use std::sync::Arc;

/// At most so many pairs of flat pieces are looked at: a second's work.
const TESTS: u64 = 10_000_000;

/// Finds coincident surfaces. `name` says in a message which surface a key is.
pub fn find(shapes: &Shapes, name: &dyn Fn(Key) -> String, findings: &mut Findings) {
    let pair = |findings: &mut Findings, a: Key, b: Key, how: &str| {
        findings.add(Kind::Coincident, || format!("{} and {} {how}", name(a), name(b)));
    };
    for (a, b) in equal_spheres(shapes) {
        pair(findings, a, b, "coincide");
    }
    for (a, b) in equal_meshes(shapes) {
        pair(findings, a, b, "coincide");
    }
    let mut flats = Flats::default();
    shapes.quads.iter().for_each(|(key, q)| flats.add(Piece::quad(*key, q)));
    shapes.triangles.iter().for_each(|(key, t)| flats.add(Piece::triangle(*key, t)));
    for (a, b) in flats.overlapping(TESTS) {
        pair(findings, a, b, "overlap in one plane");
    }
    let mut planes: HashMap<_, Key> = HashMap::new();
    for (key, plane) in &shapes.planes {
        let Some(plane) = PlaneOf::new(plane.point, plane.normal) else { continue };
        let first = *planes.entry(plane.key()).or_insert(*key);
        if first != *key {
            pair(findings, first, *key, "coincide");
            continue;
        }
        for piece in flats.near(&plane) {
            pair(findings, (*key).min(piece.key), (*key).max(piece.key), "lie in one plane");
        }
    }
    for (key, mesh) in &shapes.meshes {
        let copies = repeated_triangles(mesh);
        if copies > 0 {
            let text = || format!("{} holds {copies} of its triangles more than once", name(*key));
            findings.add(Kind::Coincident, text);
        }
        for other in touched_by(mesh, &flats, &planes) {
            pair(findings, (*key).min(other), (*key).max(other), "overlap in one plane");
        }
    }
}

/// Spheres that are one after rounding to `f32`, each with the first like it.
fn equal_spheres(shapes: &Shapes) -> Vec<(Key, Key)> {
    let mut first: HashMap<[u32; 4], Key> = HashMap::with_capacity(shapes.spheres.len());
    let bits = |x: f64| (x as f32 + 0.0).to_bits(); // -0 is 0
    let mut found = Vec::new();
    for (key, sphere) in &shapes.spheres {
        let [x, y, z] = sphere.center.to_array().map(bits);
        let before = *first.entry([x, y, z, bits(sphere.radius)]).or_insert(*key);
        if before != *key {
            found.push((before, *key));
        }
    }
    found
}

/// Meshes of one file in one place, each with the first like it.
fn equal_meshes(shapes: &Shapes) -> Vec<(Key, Key)> {
    let same = |a: &Mesh, b: &Mesh| {
        let place = a.scale == b.scale && a.rotate == b.rotate && a.translate == b.translate;
        place && Arc::ptr_eq(&a.data, &b.data)
    };
    let mut first: HashMap<[u64; 3], Vec<usize>> = HashMap::new();
    let mut found = Vec::new();
    for (i, (key, mesh)) in shapes.meshes.iter().enumerate() {
        let like = first.entry(mesh.translate.to_array().map(f64::to_bits)).or_default();
        match like.iter().find(|j| same(&shapes.meshes[**j].1, mesh)) {
            Some(j) => found.push((shapes.meshes[*j].0, *key)),
            None => like.push(i),
        }
    }
    found
}

/// How many triangles of a mesh have the same three corners as one before them.
fn repeated_triangles(mesh: &Mesh) -> u64 {
    let mut seen = std::collections::HashSet::with_capacity(mesh.data.triangles.len());
    let corners = |t: &[u32; 3]| {
        let mut corners = t.map(|i| mesh.data.positions[i as usize].map(|x| (x + 0.0).to_bits()));
        corners.sort_unstable();
        corners
    };
    mesh.data.triangles.iter().filter(|t| !seen.insert(corners(t))).count() as u64
}

/// The flat surfaces that a triangle of the mesh overlaps, ascending.
fn touched_by(
    mesh: &Mesh,
    flats: &Flats,
    planes: &HashMap<super::flat::PlaneKey, Key>,
) -> Vec<Key> {
    let mut found = Vec::new();
    if planes.is_empty() && flats.is_empty() {
        return found;
    }
    let at = placed(mesh);
    // A body that stands on a plane hides where they meet. By the plane, and the side that a
    // triangle in it shows, so that vertices are gone through but twice a plane.
    let mut standing: HashMap<(Key, bool), bool> = HashMap::new();
    let stands = |[a, b, c]: [DVec3; 3]| {
        let normal = (b - a).cross(c - a).normalize();
        let apart = |p: &DVec3| normal.dot(*p - a);
        let reach = at.iter().fold(0.0, |reach: f64, p| reach.max(p.abs().max_element()));
        let highest = at.iter().map(apart).fold(0.0, f64::max);
        let lowest = at.iter().map(apart).fold(0.0, f64::min);
        highest <= NEAR * reach && lowest < -NEAR * reach
    };
    for [a, b, c] in &mesh.data.triangles {
        let [a, b, c] = [a, b, c].map(|i| at[*i as usize]);
        let piece = Piece::triangle(Key(u32::MAX), &Triangle { a, b, c });
        let Some(plane) = piece.plane() else { continue };
        if let Some(key) = planes.get(&plane.key()) {
            let side = (b - a).cross(c - a).to_array().into_iter().find(|x| x.abs() > 0.0);
            let side = (*key, side.is_some_and(|x| x > 0.0));
            if !*standing.entry(side).or_insert_with(|| stands([a, b, c])) {
                found.push(*key);
            }
        }
        let near = flats.near(&plane).iter().take(1000);
        found.extend(near.filter(|other| piece.overlaps(other, &plane)).map(|other| other.key));
    }
    found.sort_unstable();
    found.dedup();
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use reflet_scene::{MeshData, Plane, Quad, Scene, Shading, Sphere, Surface};

    fn found(build: impl FnOnce(&mut Scene)) -> Vec<String> {
        let mut scene = Scene::new();
        build(&mut scene);
        let mut findings = Findings::default();
        find(&Shapes::of(&scene), &|key| format!("#{}", key.0), &mut findings);
        findings.texts()
    }

    fn surface() -> Surface {
        Surface { material: None, visible: true }
    }

    fn floor(y: f64) -> Plane {
        Plane { point: DVec3::new(1.0, y, 0.0), normal: DVec3::new(0.0, 2.0, 0.0) }
    }

    #[test]
    fn spheres_and_planes() {
        let ball = Sphere { center: DVec3::new(0.1, 0.0, 0.0), radius: 1.0 };
        let texts = found(|scene| {
            scene.spawn((ball, surface()));
            scene.spawn((Sphere { radius: 0.5, ..ball }, surface()));
            scene.spawn((Sphere { center: DVec3::new(0.1, -0.0, 1e-60), ..ball }, surface()));
            scene.spawn((ball, Surface { visible: false, ..surface() }));
            scene.spawn((floor(1.0), surface()));
            scene.spawn((floor(2.0), surface()));
            scene.spawn((Plane { normal: -DVec3::Y, ..floor(1.0) }, surface()));
        });
        assert_eq!(texts, ["#0 and #2 coincide", "#4 and #6 coincide"]);
    }

    #[test]
    fn a_quad_on_a_floor_and_one_above_it() {
        let quad = |y| Quad { corner: DVec3::new(0.0, y, 0.0), u: DVec3::X, v: DVec3::Z };
        let texts = found(|scene| {
            scene.spawn((quad(0.0), surface()));
            scene.spawn((floor(0.0), surface()));
            scene.spawn((quad(1e-3), surface()));
        });
        assert_eq!(texts, ["#0 and #1 lie in one plane"]);
    }

    #[test]
    fn a_body_may_stand_on_a_plane() {
        let data = Arc::new(MeshData {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]],
            triangles: vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]],
            ..MeshData::default()
        });
        let mesh = Mesh {
            data,
            scale: 2.0,
            rotate: DVec3::ZERO,
            translate: DVec3::new(3.0, 1.0, 0.0),
            shading: Shading::Smooth,
            worn: [].into(),
        };
        let texts = found(|scene| {
            scene.spawn((floor(1.0), surface()));
            scene.spawn((mesh, surface()));
        });
        assert_eq!(texts, [""; 0]);
    }

    #[test]
    fn meshes() {
        let data = Arc::new(MeshData {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]],
            // The first, in the plane, faces the body: no underside.
            triangles: vec![[0, 2, 1], [0, 1, 3], [1, 0, 2]],
            ..MeshData::default()
        });
        let mesh = Mesh {
            data,
            scale: 1.0,
            rotate: DVec3::ZERO,
            translate: DVec3::ZERO,
            shading: Shading::Smooth,
            worn: [].into(),
        };
        let texts = found(|scene| {
            scene.spawn((mesh.clone(), surface()));
            scene.spawn((mesh.clone(), surface()));
            scene.spawn((Mesh { translate: DVec3::Y, ..mesh.clone() }, surface()));
            scene.spawn((floor(0.0), surface()));
        });
        assert_eq!(
            texts,
            [
                "#0 and #1 coincide",
                "#0 holds 1 of its triangles more than once",
                "#0 and #3 overlap in one plane",
                "#1 holds 1 of its triangles more than once",
                "#1 and #3 overlap in one plane",
                "#2 holds 1 of its triangles more than once",
            ]
        );
    }
}
