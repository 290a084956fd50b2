//! Meshes among the random scenes: one in two materials, and copies of it.

use super::Dice;
use glam::DVec3;
use reflet_scene::{
    Instance, Key, Map, Mapped, Maps, Material, Mesh, MeshData, MeshMaterial, Mirrored, Place,
    Scene, Shading, Surface, Texture, Worn,
};
use std::sync::Arc;

/// The mesh, and its copies' places.
pub struct Meshes {
    pub mesh: Key,
    pub places: Vec<Key>,
}

/// A ball of so many triangles a row, in two materials, with normals and places in a texture.
fn file(rows: u32) -> Arc<MeshData> {
    let columns = 2 * rows;
    let mut data = MeshData::default();
    for j in 0..=rows {
        for i in 0..=columns {
            let (u, v) = (f64::from(i) / f64::from(columns), f64::from(j) / f64::from(rows));
            let (round, up) = (u * std::f64::consts::TAU, v * std::f64::consts::PI);
            let n = DVec3::new(up.sin() * round.cos(), -up.cos(), up.sin() * round.sin());
            data.positions.push((n * 0.5).to_array().map(|x| x as f32));
            data.normals.push(n.to_array().map(|x| x as f32));
            data.uvs.push([u as f32, v as f32]);
            data.colours.push([u as f32, 1.0, v as f32]);
        }
    }
    for j in 0..rows {
        for i in 0..columns {
            let at = |i: u32, j: u32| j * (columns + 1) + i;
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            data.triangles.extend([[a, b, c], [a, c, d]]);
            data.triangle_materials.extend([(i / 2) % 2; 2]);
        }
    }
    data.materials = vec![MeshMaterial::grey("even"), MeshMaterial::grey("odd")];
    Arc::new(data)
}

fn worn(dice: &mut Dice, materials: &[Key]) -> Arc<[Worn]> {
    let worn = ["even", "odd"].map(|name| (name.to_owned(), dice.pick(materials)));
    worn.into_iter().map(|(name, material)| Worn { name, material }).collect()
}

/// A material with maps, as a file gives it: what mirrors differs from point to point.
fn mapped(scene: &mut Scene) -> Key {
    let texels = (0..16).map(|i: u32| [0.3, (i % 4) as f32 / 4.0, (i % 3) as f32 / 2.0]).collect();
    let image = Arc::new(Texture { width: 4, height: 4, texels });
    let map = Map::new(image);
    let maps = Maps {
        diffuse: Some(map.clone()),
        mirrored: Mirrored::Metal { map, metalness: 1.0, roughness: 0.5 },
        by_vertex: [false, true, true],
        ..Maps::default()
    };
    let colours = Material { specular: DVec3::splat(0.7), ..Material::GREY_MATT };
    scene.spawn((colours, Mapped(Arc::new(maps))))
}

/// Puts them into a scene.
pub fn spawn(scene: &mut Scene, dice: &mut Dice, materials: &[Key]) -> Meshes {
    let shading = [Shading::Smooth, Shading::Faceted][dice.below(2)];
    let (mut worn, textured) = (worn(dice, materials).to_vec(), mapped(scene));
    worn[1].material = textured;
    let worn = worn.into();
    let (data, rotate) = (file(3), DVec3::new(20.0, 0.0, 90.0));
    let mesh = Mesh { data, scale: 1.0, rotate, translate: dice.point(1.5), shading, worn };
    let mesh = scene.spawn((mesh, Surface { material: None, visible: true }));
    let places = (0..2).map(|_| {
        let scale = DVec3::new(1.0, dice.range(0.5, 1.5), -1.0);
        let place = Place { scale, translate: dice.point(2.0), ..Place::default() };
        scene.spawn((place, Instance { of: mesh }))
    });
    Meshes { mesh, places: places.collect() }
}

/// Edits the mesh, and with it all of its copies.
pub fn edit(kind: usize, scene: &mut Scene, dice: &mut Dice, (key, materials): (Key, &[Key])) {
    let mut mesh: Mesh = scene.get(key).expect("a mesh");
    let mut surface: Surface = scene.get(key).expect("a surface");
    match kind {
        0 => {
            mesh.translate += dice.point(0.3);
            mesh.rotate.y += 30.0;
        }
        1 => mesh.worn = worn(dice, materials),
        2 => surface.material = [None, Some(dice.pick(materials))][dice.below(2)],
        _ => mesh.data = file(2 + dice.below(3) as u32),
    }
    scene.set(key, mesh);
    scene.set(key, surface);
}
