//! Shapes and rays as rows that any kernel can be fed with.

use reflet_accel::{Accel, HitCode, Hits, Isa, RayCounts, Rays, Scratch, Structure};
use reflet_pack::Geometry;
use std::fs;
use std::path::Path;

/// Primitives of one kind.
pub enum Shapes {
    /// Centre and radius.
    Spheres(Vec<[f32; 4]>),
    /// Corners, and three of them a triangle.
    Triangles(Vec<[f32; 3]>, Vec<[u32; 3]>),
}

impl Shapes {
    /// The corners of each triangle; none of spheres.
    pub fn triangles(&self) -> Box<dyn Iterator<Item = [[f32; 3]; 3]> + '_> {
        match self {
            Shapes::Spheres(_) => Box::new(std::iter::empty()),
            Shapes::Triangles(at, rows) => {
                Box::new(rows.iter().map(|row| row.map(|i| at[i as usize])))
            }
        }
    }
}

/// A scene, and rays by kind: origin, tmin, unit direction, tmax.
pub struct Workload {
    pub name: String,
    pub shapes: Shapes,
    pub kinds: Vec<(String, Vec<[f32; 8]>)>,
}

const KINDS: [&str; 4] = ["primary", "mirror", "shadow", "random"];

/// Those of the folder that `REFLET_WORKLOADS` names, or some made here.
pub fn workloads() -> Vec<Workload> {
    match std::env::var("REFLET_WORKLOADS") {
        Ok(folder) => read(Path::new(&folder)),
        Err(_) => [("spheres-64", 64), ("spheres-100k", 100_000)]
            .map(|(name, count)| Workload::of(name, spheres(count)))
            .into_iter()
            .chain([Workload::of("triangles-500k", bumpy(8))])
            .collect(),
    }
}

impl Workload {
    /// As raw files; gives what the primitives are called.
    pub fn write(&self, folder: &Path) -> &'static str {
        let put = |name: &str, bytes: Vec<u8>| {
            fs::write(folder.join(name), bytes).expect("room for the rays");
        };
        for (kind, rows) in &self.kinds {
            put(
                &format!("{kind}.f32"),
                rows.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect(),
            );
        }
        match &self.shapes {
            Shapes::Spheres(rows) => {
                put(
                    "prims.f32",
                    rows.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect(),
                );
                "spheres"
            }
            Shapes::Triangles(at, rows) => {
                put("verts.f32", at.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect());
                put("tris.u32", rows.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect());
                "triangles"
            }
        }
    }

    /// Makes rays: tiles of 8 x 8 pixels from one eye, what they mirror, what of it looks at a
    /// light, and rays from anywhere to anywhere.
    fn of(name: &str, shapes: Shapes) -> Workload {
        let mut g = Geometry::default();
        match &shapes {
            Shapes::Spheres(rows) => rows.iter().for_each(|[x, y, z, r]| {
                g.push_sphere([*x, *y, *z], *r);
            }),
            Shapes::Triangles(..) => shapes.triangles().for_each(|t| {
                g.push_triangle(t);
            }),
        }
        const EDGE: u32 = 512;
        let (eye, light) = ([0.3, 0.4, 3.0], [2.0, 3.0, 2.5]);
        let mut primary = Vec::new();
        for i in 0..EDGE * EDGE {
            let (tile, within) = (i / 64, i % 64);
            let x = tile % (EDGE / 8) * 8 + within % 8;
            let y = tile / (EDGE / 8) * 8 + within / 8;
            let across = |k: u32| ((k as f32 + 0.5) / EDGE as f32 - 0.5) * 0.9;
            primary.push(row(eye, unit([across(x), -across(y), -1.0]), f32::INFINITY));
        }
        let mut rays = Rays::default();
        for r in &primary {
            rays.push([r[0], r[1], r[2]], [r[4], r[5], r[6]], r[7], HitCode::NONE);
        }
        rays.pad();
        let accel = Accel::build(&g, Isa::Auto.level().expect("always"), Structure::Auto);
        let mut hits = Hits::default();
        accel.closest(&rays, &mut hits, &mut Scratch::default(), &mut RayCounts::default());
        let corners: Vec<_> = shapes.triangles().collect();
        let (mut mirror, mut shadow) = (Vec::new(), Vec::new());
        for (i, r) in primary.iter().enumerate() {
            let Some(prim) = hits.code[i].prim() else { continue };
            let d = [r[4], r[5], r[6]];
            let p = [0, 1, 2].map(|k| r[k] + hits.t[i] * d[k]);
            let n = match &shapes {
                Shapes::Spheres(rows) => unit(sub(
                    p,
                    [rows[prim.index()][0], rows[prim.index()][1], rows[prim.index()][2]],
                )),
                Shapes::Triangles(..) => {
                    let [a, b, c] = corners[prim.index()];
                    unit(cross(sub(b, a), sub(c, a)))
                }
            };
            let n = if dot(n, d) > 0.0 { n.map(|x| -x) } else { n };
            let away = dot(n, d);
            mirror.push(row(p, unit([0, 1, 2].map(|k| d[k] - 2.0 * away * n[k])), f32::INFINITY));
            let way = sub(light, p);
            if dot(way, n) > 0.0 {
                shadow.push(row(p, unit(way), dot(way, way).sqrt()));
            }
        }
        let mut dice = Dice(9);
        let random = (0..1 << 18).map(|_| row(dice.point(), unit(dice.point()), f32::INFINITY));
        let all = [primary, mirror, shadow, random.collect()];
        let kinds = KINDS.map(str::to_owned).into_iter().zip(all).collect();
        Workload { name: name.to_owned(), shapes, kinds }
    }
}

/// A ray that starts a little off where it leaves.
fn row(o: [f32; 3], d: [f32; 3], end: f32) -> [f32; 8] {
    [o[0], o[1], o[2], 1e-4, d[0], d[1], d[2], end]
}

/// Numbers that are the same on every machine.
struct Dice(u64);

impl Dice {
    /// -1..1.
    fn float(&mut self) -> f32 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 23) as f32 - 1.0
    }

    fn point(&mut self) -> [f32; 3] {
        [self.float(), self.float(), self.float()]
    }
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    let length = dot(v, v).sqrt().max(1e-20);
    v.map(|x| x / length)
}

/// Spheres in a cube, which fill about the same part of it whatever their number.
fn spheres(count: usize) -> Shapes {
    let (mut dice, size) = (Dice(1), 0.6 / (count as f32).cbrt());
    let sphere = |_| {
        let [x, y, z] = dice.point();
        [x, y, z, size * (0.75 + 0.25 * dice.float())]
    };
    Shapes::Spheres((0..count).map(sphere).collect())
}

/// An octahedron whose faces are split `depth` times, pushed out to a ball with bumps.
fn bumpy(depth: u32) -> Shapes {
    let edge = 1u32 << depth;
    let (mut at, mut rows) = (Vec::new(), Vec::new());
    for face in 0..8u32 {
        let sign = |bit: u32| if face >> bit & 1 == 0 { 1.0f32 } else { -1.0 };
        let first = at.len() as u32;
        for i in 0..=edge {
            for j in 0..=edge - i {
                let [u, v] = [i, j].map(|k| k as f32 / edge as f32);
                let d = unit([sign(0) * u, sign(1) * v, sign(2) * (1.0 - u - v)]);
                let high =
                    1.0 + 0.03 * (20.0 * d[0]).sin() * (17.0 * d[1]).sin() * (23.0 * d[2]).cos();
                at.push(d.map(|x| x * high));
            }
        }
        // Row i holds edge - i + 1 points.
        let place = |i: u32, j: u32| first + i * (edge + 1) - i * (i.max(1) - 1) / 2 + j;
        for i in 0..edge {
            for j in 0..edge - i {
                rows.push([place(i, j), place(i + 1, j), place(i, j + 1)]);
                if j + 1 < edge - i {
                    rows.push([place(i + 1, j), place(i + 1, j + 1), place(i, j + 1)]);
                }
            }
        }
    }
    Shapes::Triangles(at, rows)
}

/// Every scene of a folder: NAME.spheres.npy, or NAME.verts.npy and NAME.tris.npy, and
/// NAME.KIND.rays.npy.
fn read(folder: &Path) -> Vec<Workload> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .expect("REFLET_WORKLOADS names a folder")
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter_map(|name| Some(name.strip_suffix(".primary.rays.npy")?.to_owned()))
        .collect();
    names.sort();
    let scene = |name: String| {
        let file = |part: &str| words(&folder.join(format!("{name}.{part}.npy")));
        let floats = |words: Vec<u32>| words.into_iter().map(f32::from_bits).collect::<Vec<_>>();
        let shapes = match file("spheres") {
            Some(words) => Shapes::Spheres(floats(words).as_chunks().0.to_vec()),
            None => {
                let [at, rows] = ["verts", "tris"].map(|part| file(part).expect("an array"));
                Shapes::Triangles(floats(at).as_chunks().0.to_vec(), rows.as_chunks().0.to_vec())
            }
        };
        let rays = |kind: &str| {
            let rows = floats(file(&format!("{kind}.rays")).expect("an array"));
            (kind.to_owned(), rows.as_chunks().0.to_vec())
        };
        let kinds = KINDS.iter().map(|kind| rays(kind)).collect();
        Workload { name, shapes, kinds }
    };
    names.into_iter().map(scene).collect()
}

/// The numbers of an array file, by their bits.
fn words(path: &Path) -> Option<Vec<u32>> {
    let bytes = fs::read(path).ok()?;
    let header = usize::from(u16::from_le_bytes([*bytes.get(8)?, *bytes.get(9)?]));
    let body = bytes.get(10 + header..)?;
    Some(body.chunks_exact(4).map(|c| u32::from_le_bytes([c[0], c[1], c[2], c[3]])).collect())
}
