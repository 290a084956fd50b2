//! What all formats end with: triangles that have an area, and normals of length one.

use reflet_scene::MeshData;

/// Leaves out triangles without area and tells how many they were; gives normals the length of one.
/// A normal of no length (or that is not finite) stays zero: the triangle's own counts there.
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

/// Whether the corners span an area: differences and products of `f32` values, taken in `f64`, are
/// exact unless the coordinates' magnitudes lie more than 2^28 apart.
fn has_area([a, b, c]: [[f32; 3]; 3]) -> bool {
    cross([a, b, c]).iter().any(|part| *part != 0.0)
}

fn cross([a, b, c]: [[f32; 3]; 3]) -> [f64; 3] {
    let edge = |p: [f32; 3]| [0, 1, 2].map(|i| f64::from(p[i]) - f64::from(a[i]));
    let (u, v) = (edge(b), edge(c));
    [0, 1, 2].map(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let (positive, negative) = (u[j] * v[k], u[k] * v[j]);
        if positive == negative { 0.0 } else { positive - negative }
    })
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
