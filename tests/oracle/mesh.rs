//! Meshes: triangles one by one, normals and places in pictures between their corners, and the file
//! that says the same.

use super::draw::Draw;
use super::place::Motion;
use super::scene::{Material, Shape};
use super::shape::coordinates;
use super::vec3::{Vec3, v3};
use std::fmt::Write as _;
use std::path::Path;

/// Which file a mesh stands in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Format {
    Obj,
    Ply,
    Stl,
}

/// A mesh in its file, and where the script puts it.
#[derive(Clone, Debug)]
pub struct Mesh {
    pub file: String,
    pub format: Format,
    /// Numbers that f32 holds, as all in the file.
    pub positions: Vec<Vec3>,
    /// A unit vector a position; empty if the file has none.
    pub normals: Vec<Vec3>,
    /// A place in a picture a position; empty if the file has none.
    pub uvs: Vec<[f64; 2]>,
    pub triangles: Vec<[usize; 3]>,
    /// What triangle i wears is number i modulo their count; empty if the file has none.
    pub materials: Vec<Material>,
    pub place: Motion,
    pub smooth: bool,
}

/// The least height of a mirrored ray over a smooth mesh's triangle, as the manual has it.
const RISE: f64 = 1e-3;

impl Mesh {
    /// The corners of a triangle where the mesh stands.
    fn corners(&self, i: usize) -> [Vec3; 3] {
        self.triangles[i].map(|v| self.place.point_shown(self.positions[v]))
    }

    /// The way to each triangle that a ray meets.
    pub fn roots(&self, base: Vec3, dir: Vec3) -> Vec<(f64, usize)> {
        let met = |i: usize| {
            let [a, b, c] = self.corners(i);
            let n = (b - a).cross(c - a);
            let t = (a - base).dot(n) / dir.dot(n);
            let (s, r) = coordinates(base + dir * t - a, b - a, c - a);
            (t.is_finite() && s >= 0.0 && r >= 0.0 && s + r <= 1.0).then_some((t, i))
        };
        (0..self.triangles.len()).filter_map(met).collect()
    }

    /// The unit normal of a triangle.
    pub fn flat_normal(&self, i: usize) -> Vec3 {
        let [a, b, c] = self.corners(i);
        (b - a).cross(c - a).unit()
    }

    /// The weights of a triangle's corners at a point of it.
    fn weights(&self, i: usize, p: Vec3) -> [f64; 3] {
        let [a, b, c] = self.corners(i);
        let (s, r) = coordinates(p - a, b - a, c - a);
        [1.0 - s - r, s, r]
    }

    /// The file's normal at a point of a triangle, if the mesh is lit by it.
    pub fn smooth_normal(&self, i: usize, p: Vec3) -> Option<Vec3> {
        if !self.smooth || self.normals.is_empty() {
            return None;
        }
        let mut n = Vec3::ZERO;
        for (corner, weight) in self.triangles[i].iter().zip(self.weights(i, p)) {
            n += self.normals[*corner] * weight;
        }
        Some(self.place.normal_shown(n))
    }

    /// The way from a point of a triangle up to the surface that the normals describe. `shown` puts a
    /// point of the mesh, and a normal on the side that is seen, into the scene; there the point is
    /// `at` and the triangle's normal `facing`.
    pub fn lift(
        &self,
        (i, p): (usize, Vec3),
        shown: (impl Fn(Vec3) -> Vec3, impl Fn(Vec3) -> Vec3),
        (at, facing): (Vec3, Vec3),
    ) -> Vec3 {
        let mut lift = Vec3::ZERO;
        for (v, weight) in self.triangles[i].into_iter().zip(self.weights(i, p)) {
            let corner = shown.0(self.place.point_shown(self.positions[v]));
            let normal = shown.1(self.place.normal_shown(self.normals[v]));
            lift += normal * (weight * (corner - at).dot(normal).max(0.0));
        }
        if lift.dot(facing) > 0.0 { lift } else { Vec3::ZERO }
    }

    /// The place of a point of a triangle in a picture.
    pub fn uv(&self, i: usize, p: Vec3) -> (f64, f64) {
        let mut uv = (0.0, 0.0);
        for (corner, weight) in self.triangles[i].iter().zip(self.weights(i, p)) {
            let own = self.uvs[*corner];
            uv = (uv.0 + weight * own[0], uv.1 + weight * own[1]);
        }
        uv
    }

    /// What a triangle wears by the file.
    pub fn material(&self, i: usize) -> Material {
        self.materials[i % self.materials.len()]
    }

    /// Writes the file.
    pub fn write(&self, folder: &Path) {
        let write = |name: &str, text: &str| {
            std::fs::write(folder.join(name), text).expect("the mesh is written");
        };
        match self.format {
            Format::Obj => {
                write(&self.file, &self.obj());
                write(&self.library(), &self.mtl());
            }
            Format::Ply => write(&self.file, &self.ply()),
            Format::Stl => write(&self.file, &self.stl()),
        }
    }

    /// The name of the file of materials.
    fn library(&self) -> String {
        format!("{}.mtl", self.file)
    }

    fn obj(&self) -> String {
        let mut out = format!("mtllib {}\n", self.library());
        let mut rows = |word: &str, rows: &[Vec3]| {
            for v in rows {
                let _ = writeln!(out, "{word} {} {} {}", v[0], v[1], v[2]);
            }
        };
        rows("v", &self.positions);
        rows("vn", &self.normals);
        for [u, v] in &self.uvs {
            let _ = writeln!(out, "vt {u} {v}");
        }
        for (i, t) in self.triangles.iter().enumerate() {
            if !self.materials.is_empty() {
                let _ = writeln!(out, "usemtl m{}", i % self.materials.len());
            }
            let corner = |v: usize| match (self.uvs.is_empty(), self.normals.is_empty()) {
                (true, true) => format!("{v}"),
                (false, true) => format!("{v}/{v}"),
                (true, false) => format!("{v}//{v}"),
                (false, false) => format!("{v}/{v}/{v}"),
            };
            let [a, b, c] = t.map(|v| corner(v + 1));
            let _ = writeln!(out, "f {a} {b} {c}");
        }
        out
    }

    fn mtl(&self) -> String {
        let mut out = String::new();
        for (i, m) in self.materials.iter().enumerate() {
            let _ = writeln!(out, "newmtl m{i}");
            for (word, c) in [("Ka", m.ambient), ("Kd", m.diffuse), ("Ks", m.specular)] {
                let _ = writeln!(out, "{word} {} {} {}", c[0], c[1], c[2]);
            }
        }
        out
    }

    fn ply(&self) -> String {
        let mut out = format!("ply\nformat ascii 1.0\nelement vertex {}\n", self.positions.len());
        let columns: &[&str] = match (self.normals.is_empty(), self.uvs.is_empty()) {
            (true, true) => &["x", "y", "z"],
            (false, true) => &["x", "y", "z", "nx", "ny", "nz"],
            (true, false) => &["x", "y", "z", "u", "v"],
            (false, false) => &["x", "y", "z", "nx", "ny", "nz", "u", "v"],
        };
        columns.iter().for_each(|c| out += &format!("property float {c}\n"));
        let faces = self.triangles.len();
        out +=
            &format!("element face {faces}\nproperty list uchar int vertex_indices\nend_header\n");
        for (i, p) in self.positions.iter().enumerate() {
            let normal = self.normals.get(i).map(|n| n.0.to_vec()).unwrap_or_default();
            let uv = self.uvs.get(i).map(|uv| uv.to_vec()).unwrap_or_default();
            let row: Vec<String> =
                p.0.iter().chain(&normal).chain(&uv).map(|x| x.to_string()).collect();
            out += &(row.join(" ") + "\n");
        }
        for [a, b, c] in &self.triangles {
            let _ = writeln!(out, "3 {a} {b} {c}");
        }
        out
    }

    fn stl(&self) -> String {
        let mut out = String::from("solid of the test\n");
        for t in &self.triangles {
            out += "facet normal 0 0 0\nouter loop\n";
            for v in t.map(|v| self.positions[v]) {
                let _ = writeln!(out, "vertex {} {} {}", v[0], v[1], v[2]);
            }
            out += "endloop\nendfacet\n";
        }
        out + "endsolid\n"
    }
}

/// The direction `v` of a ray that a smooth mesh mirrors; where it would not rise over the triangle, the
/// one that rises by [`RISE`].
pub fn risen(v: Vec3, facing: Vec3) -> Vec3 {
    let height = v.dot(facing);
    if height < RISE { (v + facing * (RISE - height)).unit() } else { v }
}

/// `x` as f32 holds it.
fn single(x: f64) -> f64 {
    f64::from(x as f32)
}

fn singles(v: Vec3) -> Vec3 {
    v.map(single)
}

impl Draw {
    /// A dented ball of 32 triangles around the origin, in a file called `name`, somewhere in the
    /// stage.
    pub fn mesh(&mut self, name: &str, low: Vec3, high: Vec3) -> Mesh {
        let format = [Format::Obj, Format::Ply, Format::Stl][self.int(0, 2)];
        let (positions, triangles) = ball();
        let dents = self.range(0.0, 0.25);
        let positions: Vec<Vec3> = positions
            .into_iter()
            .map(|p| singles(p * (1.0 - self.range(0.0, 1.0) * dents)))
            .collect();
        let with = format != Format::Stl;
        let unit = |p: &Vec3| singles(p.unit());
        let normals =
            if with && self.chance(70) { positions.iter().map(unit).collect() } else { Vec::new() };
        let flat = |p: &Vec3| [single(0.5 + 0.45 * p[0]), single(0.5 + 0.45 * p[1])];
        let uvs = if with { positions.iter().map(flat).collect() } else { Vec::new() };
        let ending = ["obj", "ply", "stl"][format as usize];
        let size = self.range(0.5, 1.2);
        let place = Motion {
            translate: self.point(low, high),
            rotate: v3(self.range(0.0, 360.0), self.range(0.0, 360.0), self.range(0.0, 90.0)),
            scale: Vec3::splat(if self.chance(20) { -size } else { size }),
        };
        let materials = if format == Format::Obj {
            (0..self.int(1, 3))
                .map(|_| Material {
                    ambient: singles(self.colour(0.0, 0.1)),
                    diffuse: singles(self.colour(0.1, 0.9)),
                    specular: singles(self.specular(0.0, 0.8)),
                })
                .collect()
        } else {
            Vec::new()
        };
        let (file, smooth) = (format!("{name}.{ending}"), self.chance(75));
        Mesh { file, format, positions, normals, uvs, triangles, materials, place, smooth }
    }
}

/// The shape of a mesh. It is never given back: scenes are few, and shapes are small.
pub fn shape(mesh: Mesh) -> Shape {
    Shape::Mesh { mesh: Box::leak(Box::new(mesh)) }
}

/// An octahedron, each face cut in four, on the unit sphere.
fn ball() -> (Vec<Vec3>, Vec<[usize; 3]>) {
    let mut points: Vec<Vec3> = Vec::new();
    let mut triangles = Vec::new();
    let mut number = |p: Vec3| {
        let p = p.unit();
        points.iter().position(|q| (*q - p).length() < 1e-9).unwrap_or_else(|| {
            points.push(p);
            points.len() - 1
        })
    };
    for octant in 0..8 {
        let side = |k: usize| if octant >> k & 1 == 0 { 1.0 } else { -1.0 };
        let (x, y, z) = (v3(side(0), 0.0, 0.0), v3(0.0, side(1), 0.0), v3(0.0, 0.0, side(2)));
        let [a, b, c, ab, bc, ca] = [x, y, z, x + y, y + z, z + x].map(&mut number);
        triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    (points, triangles)
}
