//! The visible surfaces of a scene, by kind, and how a message names one.

use reflet_scene::{DVec3, Group, Key, Mesh, Plane, Quad, Scene, Sphere, Surface, Triangle};
use std::collections::HashSet;

/// The visible surfaces, each kind in the order of making.
#[derive(Default)]
pub struct Shapes {
    /// Spheres.
    pub spheres: Vec<(Key, Sphere)>,
    /// Infinite planes.
    pub planes: Vec<(Key, Plane)>,
    /// Parallelograms.
    pub quads: Vec<(Key, Quad)>,
    /// Single triangles.
    pub triangles: Vec<(Key, Triangle)>,
    /// Meshes.
    pub meshes: Vec<(Key, Mesh)>,
    /// How many visible surfaces are of other kinds, or moved by a group.
    pub others: u64,
    /// How many surfaces of all kinds are not visible.
    pub hidden: u64,
}

impl Shapes {
    /// The surfaces of a scene as it is now.
    pub fn of(scene: &Scene) -> Self {
        let mut shapes = Self::default();
        let groups = scene.keys().filter_map(|key| scene.get::<Group>(key));
        let grouped: HashSet<Key> = groups.flat_map(|g| g.members.to_vec()).collect();
        for key in scene.keys() {
            let Some(surface) = scene.get::<Surface>(key) else { continue };
            if !surface.visible {
                shapes.hidden += 1;
            } else if grouped.contains(&key) {
                shapes.others += 1;
            } else if let Some(sphere) = scene.get(key) {
                shapes.spheres.push((key, sphere));
            } else if let Some(plane) = scene.get(key) {
                shapes.planes.push((key, plane));
            } else if let Some(quad) = scene.get(key) {
                shapes.quads.push((key, quad));
            } else if let Some(triangle) = scene.get(key) {
                shapes.triangles.push((key, triangle));
            } else if let Some(mesh) = scene.get(key) {
                shapes.meshes.push((key, mesh));
            } else {
                shapes.others += 1;
            }
        }
        shapes
    }
}

/// Names of surfaces for messages: its kind, its number among its kind in the order of making, and
/// where it is.
pub struct Names {
    /// By key; 0 for what is no surface.
    numbers: Vec<u32>,
}

impl Names {
    /// Counts the surfaces of a scene, visible or not.
    pub fn of(scene: &Scene) -> Self {
        let mut counts = [0u32; 5];
        let number = |key| {
            let kind = [
                scene.has::<Sphere>(key),
                scene.has::<Plane>(key),
                scene.has::<Quad>(key),
                scene.has::<Triangle>(key),
                scene.has::<Mesh>(key),
            ];
            let kind = kind.into_iter().position(|it| it)?;
            counts[kind] += 1;
            Some(counts[kind])
        };
        Self { numbers: scene.keys().map(number).map(Option::unwrap_or_default).collect() }
    }

    /// The name of a surface.
    pub fn name(&self, scene: &Scene, key: Key) -> String {
        let n = self.numbers.get(key.index()).copied().unwrap_or_default();
        if let Some(s) = scene.get::<Sphere>(key) {
            format!("sphere {n} (center {}, radius {})", point(s.center), number(s.radius))
        } else if let Some(p) = scene.get::<Plane>(key) {
            format!("plane {n} (through {})", point(p.point))
        } else if let Some(q) = scene.get::<Quad>(key) {
            format!("quad {n} (corner {})", point(q.corner))
        } else if let Some(t) = scene.get::<Triangle>(key) {
            format!("triangle {n} (a {})", point(t.a))
        } else if let Some(m) = scene.get::<Mesh>(key) {
            format!("mesh {n} (translate {})", point(m.translate))
        } else {
            format!("surface {}", key.0)
        }
    }
}

/// The vertices of a mesh where it stands in the scene.
pub fn placed(mesh: &Mesh) -> Vec<DVec3> {
    let turns = mesh.rotate.to_array().map(|degrees| {
        let radians = degrees.to_radians();
        (libm::sin(radians), libm::cos(radians))
    });
    let place = |p: &[f32; 3]| {
        let mut p = [0, 1, 2].map(|i| f64::from(p[i]) * mesh.scale);
        for (axis, (sin, cos)) in turns.into_iter().enumerate() {
            let (j, k) = ((axis + 1) % 3, (axis + 2) % 3);
            (p[j], p[k]) = (cos * p[j] - sin * p[k], sin * p[j] + cos * p[k]);
        }
        DVec3::from_array(p) + mesh.translate
    };
    mesh.data.positions.iter().map(place).collect()
}

/// A point as a message shows it.
pub fn point(p: DVec3) -> String {
    let [x, y, z] = p.to_array().map(number);
    format!("[{x}, {y}, {z}]")
}

/// A number as a message shows it: at most six digits.
pub fn number(x: f64) -> String {
    if x == 0.0 {
        return "0".into();
    }
    let digits = 5 - libm::floor(libm::log10(x.abs())) as i32;
    if !(0..12).contains(&digits) {
        return format!("{x:.5e}");
    }
    let text = format!("{x:.*}", digits as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;
    use reflet_scene::MeshData;
    use std::sync::Arc;

    #[test]
    fn numbers_are_short() {
        for (x, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (-2.5, "-2.5"),
            (100_000.0, "100000"),
            (1.0 / 3.0, "0.333333"),
            (1e7, "1.00000e7"),
            (1e-9, "1.00000e-9"),
        ] {
            assert_eq!(number(x), text);
        }
    }

    #[test]
    fn a_mesh_is_scaled_then_turned_about_x_y_z_then_moved() {
        let data = MeshData { positions: vec![[0.0, 1.0, 0.0]], ..MeshData::default() };
        let mesh = Mesh {
            data: Arc::new(data),
            scale: 2.0,
            // y -> z about x, z -> x about y, x -> y about z.
            rotate: DVec3::splat(90.0),
            shading: reflet_scene::Shading::Smooth,
            worn: [].into(),
            translate: DVec3::new(10.0, 0.0, 0.0),
        };
        let at = placed(&mesh)[0];
        // Rounding of three quarter turns.
        assert!((at - DVec3::new(10.0, 2.0, 0.0)).length() < 1e-12, "{at}");
    }
}
