//! What all formats end with: triangles that have an area, and normals of length one.

use crate::polygon::area;
use reflet_scene::MeshData;

/// Leaves out triangles without area and tells how many they were; gives normals the length of one.
/// A normal that is not finite becomes that of the triangles around it; one of no length stays zero:
/// the triangle's own counts there.
pub(crate) fn finish(data: &mut MeshData) -> u64 {
    let MeshData { positions, triangles, triangle_materials, .. } = data;
    let before = triangles.len();
    let has_area: Vec<bool> = triangles
        .iter()
        .map(|triangle| has_area(triangle.map(|vertex| positions[vertex as usize])))
        .collect();
    if has_area.contains(&false) {
        let mut kept = has_area.iter();
        triangles.retain(|_| kept.next() == Some(&true));
        let mut kept = has_area.iter();
        triangle_materials.retain(|_| kept.next() == Some(&true));
    }
    let without_area = (before - triangles.len()) as u64;
    mend(data);
    for normal in &mut data.normals {
        *normal = unit(normal.map(f64::from)).unwrap_or_default();
    }
    if data.normals.iter().all(|normal| *normal == [0.0; 3]) {
        data.normals = Vec::new();
    }
    let MeshData { positions, triangles, normals, uvs, second_uvs, colours, .. } = data;
    positions.shrink_to_fit();
    triangles.shrink_to_fit();
    normals.shrink_to_fit();
    uvs.shrink_to_fit();
    second_uvs.shrink_to_fit();
    colours.shrink_to_fit();
    data.triangle_materials.shrink_to_fit();
    without_area
}

fn has_area(corners: [[f32; 3]; 3]) -> bool {
    area(corners).iter().any(|part| *part != 0.0)
}

/// Gives what is not finite a value: vertices that no triangle has any place, normals that of the
/// triangles around.
fn mend(data: &mut MeshData) {
    let MeshData { positions, triangles, normals, .. } = data;
    let is_finite = |v: &[f32; 3]| v.iter().all(|x| x.is_finite());
    positions.iter_mut().filter(|place| !is_finite(place)).for_each(|place| *place = [0.0; 3]);
    if normals.iter().all(is_finite) {
        return;
    }
    let mut around = vec![[0.0; 3]; normals.len()];
    for triangle in triangles {
        let area = area(triangle.map(|vertex| positions[vertex as usize]));
        for vertex in triangle.iter().map(|vertex| *vertex as usize) {
            around[vertex] = [0, 1, 2].map(|k| around[vertex][k] + area[k]);
        }
    }
    for (normal, around) in normals.iter_mut().zip(around) {
        if !is_finite(normal) {
            *normal = unit(around).unwrap_or_default();
        }
    }
}

/// The vector of length one in this direction, if it has one.
pub(crate) fn unit(v: [f64; 3]) -> Option<[f32; 3]> {
    // Scaled first, so that no square overflows or vanishes.
    let most = v.iter().fold(0.0, |most: f64, part| most.max(part.abs()));
    if most == 0.0 || !most.is_finite() {
        return None;
    }
    let v = v.map(|part| part / most);
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    Some(v.map(|part| (part / length) as f32))
}
