//! However often a mesh is in a scene, its triangles are stored once, or as good as once.

use glam::DVec3;
use reflet_pack::{Columns, Overrides, Packer, Sharing};
use reflet_scene::{Camera, Instance, Mesh, MeshData, Place, Scene, Shading, Surface};
use std::sync::Arc;

/// A flat net of 2 `n` x `n` triangles.
fn net(n: u32) -> Arc<MeshData> {
    let mut data = MeshData::default();
    for j in 0..=n {
        data.positions.extend((0..=n).map(|i| [i as f32, j as f32, 0.0]));
    }
    for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let at = |i, j| j * (n + 1) + i;
        data.triangles.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
        data.triangles.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
    }
    Arc::new(data)
}

/// A net of 2 x 100 x 100 triangles and so many instances of it.
fn packed(instances: u32, sharing: Sharing) -> Columns {
    let mut scene = Scene::new();
    let (eye, look_at, up) = (DVec3::Z, DVec3::ZERO, DVec3::Y);
    let camera = Camera::LookAt { eye, look_at, up, fov_degrees: 45.0 };
    scene.singletons.camera = Some(scene.spawn((camera,)));
    let mesh = Mesh {
        data: net(100),
        scale: 1.0,
        rotate: DVec3::ZERO,
        translate: DVec3::ZERO,
        shading: Shading::Smooth,
        worn: [].into(),
    };
    let of = scene.spawn((mesh, Surface { material: None, visible: true }));
    for i in 0..instances {
        let place = Place { translate: DVec3::Z * f64::from(i), ..Place::default() };
        scene.spawn((place, Instance { of }));
    }
    scene.seal();
    let packer = Packer::sharing(&scene, Overrides::default(), sharing).expect("a camera");
    packer.columns().clone()
}

const ONE: usize = 20_000;

#[test]
fn triangles_are_stored_once_however_many_instances_there_are() {
    let all = packed(1000, Sharing::Always);
    assert_eq!(all.geometry.triangles.normal.len(), ONE);
    assert_eq!(all.geometry.copies.len(), 1000);
    assert_eq!(all.geometry.prims(), 1001 * ONE as u32);
    // By itself a scene stores some more, since rays find those quicker: 262,144 at most.
    let own = packed(1000, Sharing::Auto);
    assert_eq!(own.geometry.triangles.normal.len(), 13 * ONE);
    assert_eq!(own.geometry.copies.len(), 1001 - 13);
    assert_eq!(own.geometry.prims(), all.geometry.prims());
}

#[test]
fn few_are_all_stored() {
    let few = packed(3, Sharing::Auto);
    assert_eq!((few.geometry.triangles.normal.len(), few.geometry.copies.len()), (4 * ONE, 0));
}
