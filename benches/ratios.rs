//! Rays a second beside other kernels, in one run and on one thread: a table of ratios.
//!
//! `obvhs` is compiled in. Embree joins in if `REFLET_EMBREE` names its library (benches/README.md
//! says where to get one): a small program is compiled that opens it. Rays and scenes are made here,
//! or read from the folder `REFLET_WORKLOADS`.

#[path = "peers/rows.rs"]
mod rows;

use cpu_time::{ProcessTime, ThreadTime};
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh};
use obvhs::ray::{Ray, RayHit};
use obvhs::{Boundable, BvhBuildParams, aabb::Aabb, triangle::Triangle};
use reflet_accel::{Accel, HitCode, Hits, Isa, RayCounts, Rays, Scratch, Structure};
use reflet_pack::Geometry;
use rows::{Shapes, Workload};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// What one kernel gives: Mrays/s, and how many rays hit.
type Figure = (f64, usize);

const ROUNDS: usize = 4;

/// The median but for the first round, which finds its memory.
fn speed(rays: usize, mut round: impl FnMut() -> (Duration, usize)) -> Figure {
    let mut hits = 0;
    let mut times: Vec<Duration> = (0..ROUNDS)
        .map(|_| {
            let (time, count) = round();
            hits = count;
            time
        })
        .skip(1)
        .collect();
    times.sort_unstable();
    (rays as f64 * 1e-6 / times[times.len() / 2].as_secs_f64(), hits)
}

/// Mprims/s of the better of two builds, the first of which finds its memory.
fn build<T>(prims: usize, make: impl Fn() -> T) -> (f64, T) {
    let once = || {
        let start = ProcessTime::now();
        let made = make();
        (start.elapsed(), made)
    };
    let (first, (second, made)) = (once().0, once());
    (prims as f64 * 1e-6 / first.min(second).as_secs_f64(), made)
}

fn ours(work: &Workload) -> (f64, Vec<Figure>) {
    let mut g = Geometry::default();
    match &work.shapes {
        Shapes::Spheres(rows) => rows.iter().for_each(|[x, y, z, r]| {
            g.push_sphere([*x, *y, *z], *r);
        }),
        Shapes::Triangles(..) => work.shapes.triangles().for_each(|t| {
            g.push_triangle(t);
        }),
    }
    let level = Isa::Auto.level().expect("always");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    let make = || pool.install(|| Accel::build(&g, level, Structure::Auto));
    let (build, accel) = build(g.len(), make);
    let kind = |(name, rows): &(String, Vec<[f32; 8]>)| {
        let mut rays = Rays::default();
        for [ox, oy, oz, t_min, dx, dy, dz, t_max] in rows.iter().copied() {
            rays.push([ox, oy, oz], [dx, dy, dz], t_max, HitCode::NONE);
            let i = rays.len() - 1;
            rays.t_min[i] = t_min;
        }
        rays.pad();
        let (mut hits, mut occluded) = (Hits::default(), Vec::new());
        let (mut scratch, mut counts) = (Scratch::default(), RayCounts::default());
        speed(rays.len(), || {
            let start = ThreadTime::now();
            if name == "shadow" {
                accel.any(&rays, &mut occluded, &mut scratch, &mut counts);
                (start.elapsed(), occluded.iter().filter(|o| **o).count())
            } else {
                accel.closest(&rays, &mut hits, &mut scratch, &mut counts);
                let codes = hits.code[..rays.len()].iter();
                (start.elapsed(), codes.filter(|c| !c.is_none()).count())
            }
        })
    };
    (build, work.kinds.iter().map(kind).collect())
}

#[derive(Clone)]
struct Ball([f32; 4]);

impl Boundable for Ball {
    fn aabb(&self) -> Aabb {
        let [x, y, z, r] = self.0;
        Aabb::new([x - r, y - r, z - r].into(), [x + r, y + r, z + r].into())
    }
}

impl Ball {
    fn intersect(&self, ray: &Ray) -> f32 {
        let [x, y, z, r] = self.0;
        let l = -(ray.origin - glam::Vec3A::new(x, y, z));
        let b = l.dot(ray.direction);
        let across = l - b * ray.direction;
        let disc = r * r - across.dot(across);
        if disc < 0.0 {
            return f32::INFINITY;
        }
        let root = disc.sqrt();
        let t = if b - root > ray.tmin { b - root } else { b + root };
        if t > ray.tmin { t } else { f32::INFINITY }
    }
}

fn obvhs(work: &Workload) -> (f64, Vec<Figure>) {
    let params = BvhBuildParams::medium_build();
    match &work.shapes {
        Shapes::Spheres(rows) => {
            let balls: Vec<Ball> = rows.iter().map(|row| Ball(*row)).collect();
            let make = || build_cwbvh(&balls, params, &mut Duration::default());
            let (build, bvh) = build(balls.len(), make);
            let own: Vec<Ball> =
                bvh.primitive_indices.iter().map(|i| balls[*i as usize].clone()).collect();
            (build, cast(&bvh, work, |ray, i| own[i].intersect(ray)))
        }
        Shapes::Triangles(..) => {
            let faces: Vec<Triangle> = (work.shapes.triangles())
                .map(|[a, b, c]| Triangle { v0: a.into(), v1: b.into(), v2: c.into() })
                .collect();
            let make = || build_cwbvh(&faces, params, &mut Duration::default());
            let (build, bvh) = build(faces.len(), make);
            let own: Vec<Triangle> =
                bvh.primitive_indices.iter().map(|i| faces[*i as usize]).collect();
            (build, cast(&bvh, work, |ray, i| own[i].intersect(ray)))
        }
    }
}

fn cast(bvh: &CwBvh, work: &Workload, test: impl Fn(&Ray, usize) -> f32) -> Vec<Figure> {
    let kind = |(name, rows): &(String, Vec<[f32; 8]>)| {
        let rays: Vec<Ray> = rows
            .iter()
            .map(|[ox, oy, oz, from, dx, dy, dz, to]| {
                Ray::new([*ox, *oy, *oz].into(), [*dx, *dy, *dz].into(), *from, *to)
            })
            .collect();
        let is_any = name == "shadow";
        speed(rays.len(), || {
            let start = ThreadTime::now();
            let mut hits = 0;
            for ray in &rays {
                hits += usize::from(if is_any {
                    !bvh.ray_traverse_miss(*ray, &test)
                } else {
                    bvh.ray_traverse(*ray, &mut RayHit::none(), &test)
                });
            }
            (start.elapsed(), hits)
        })
    };
    work.kinds.iter().map(kind).collect()
}

/// The program that opens Embree, and the library.
fn embree_program(folder: &Path) -> Option<(PathBuf, PathBuf)> {
    let Some(library) = std::env::var_os("REFLET_EMBREE").map(PathBuf::from) else {
        eprintln!("Embree is skipped: REFLET_EMBREE names no library (see benches/README.md)");
        return None;
    };
    let (program, source) = (folder.join("embree"), "benches/peers/embree.cpp");
    let mut compiler = Command::new(std::env::var_os("CXX").unwrap_or_else(|| "c++".into()));
    compiler.args(["-O2", "-std=c++17", source, "-ldl", "-o"]).arg(&program);
    let compiled = compiler.current_dir(env!("CARGO_MANIFEST_DIR")).status();
    if !compiled.is_ok_and(|status| status.success()) {
        eprintln!("Embree is skipped: {compiler:?} failed");
        return None;
    }
    Some((program, library))
}

fn embree(
    (program, library): &(PathBuf, PathBuf),
    folder: &Path,
    work: &Workload,
) -> Option<(f64, Vec<Figure>)> {
    let kind = work.write(folder);
    let mut command = Command::new(program);
    command.arg(library).arg(folder).arg(kind).args(work.kinds.iter().map(|k| &k.0));
    let out = command.output().ok().filter(|out| out.status.success());
    let Some(out) = out else {
        eprintln!("Embree is skipped: {command:?} failed");
        return None;
    };
    let text = String::from_utf8_lossy(&out.stdout).into_owned();
    let figure = |line: &str| {
        let words: Vec<&str> = line.splitn(4, ' ').collect();
        let figure = (words.get(1)?.parse().ok()?, words.get(2)?.parse().ok()?);
        eprintln!("  Embree, {}: best with {}", words[0], words.get(3)?);
        Some(figure)
    };
    let mut figures = text.lines().filter_map(figure);
    let build = figures.next()?.0;
    Some((build, figures.collect()))
}

fn main() {
    let folder = tempfile::tempdir().expect("a folder");
    let program = embree_program(folder.path());
    let mut table = String::new();
    for work in rows::workloads() {
        eprintln!("{}", work.name);
        let (build, own) = ours(&work);
        let mut peers = vec![("obvhs", obvhs(&work))];
        if let Some(figures) = program.as_ref().and_then(|p| embree(p, folder.path(), &work)) {
            peers.push(("Embree", figures));
        }
        table += &format!("{:<16} {:<9}{:>9.2} Mprims/s", work.name, "build", build);
        for (name, (theirs, _)) in &peers {
            table += &format!("   {name} {theirs:.2}, ratio {:.2}", build / theirs);
        }
        table.push('\n');
        for (i, (kind, _)) in work.kinds.iter().enumerate() {
            let (mrays, hits) = own[i];
            table += &format!("{:<16} {kind:<9}{mrays:>9.2} Mrays/s ", work.name);
            for (name, (_, figures)) in &peers {
                let Some((theirs, found)) = figures.get(i) else { continue };
                table += &format!("   {name} {theirs:.2}, ratio {:.2}", mrays / theirs);
                // Not the same work, then.
                if found.abs_diff(hits) * 1000 > hits.max(1000) {
                    table += &format!(" ({found} hits against {hits})");
                }
            }
            table.push('\n');
        }
    }
    println!("{table}");
}
