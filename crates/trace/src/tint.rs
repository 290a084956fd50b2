//! What pictures, maps and expressions say at hit points: columns of factors and colours beside the
//! nodes.
//!
//! Expressions run in lanes, eight hit points at a time, step by step. What has no exact answer (sine,
//! cosine, arc cosine) comes from `libm`, so that the numbers are the same everywhere.

use crate::interact::Interactions;
use crate::look_up::{self, look_up};
use crate::smooth;
use crate::trees::Level;
use fearless_simd::prelude::*;
use reflet_accel::HitCode;
use reflet_accel::lanes::{F, LANES, abs, greater, lesser};
use reflet_pack::tints::program::{Binary, Op, Program, Unary};
use reflet_pack::tints::{
    Chart, ChartKind, Map, Maps, Mirrored, Row, Tint, TintPaint, UvSet, Wrap,
};
use reflet_pack::{Columns, MeshData, PrimId};
use std::f64::consts::{PI, TAU};

/// Memory of one thread for expressions.
#[derive(Default)]
pub(crate) struct TintScratch {
    /// The inputs of eight points, by coordinate.
    inputs: [[f32; LANES]; 8],
    /// The results of all steps.
    steps: Vec<[f32; LANES]>,
    /// Rows of nodes on one tinted surface.
    rows: Vec<u32>,
}

/// Writes the tints of nodes from row `first` of `columns_out` on, whose points are those of
/// `points`, in the same order. Columns of nodes without a tint hold 1.
#[inline(always)]
pub(crate) fn fill<S: Simd>(
    simd: S,
    columns: &Columns,
    (points, codes): (&Interactions, &[HitCode]),
    (out, first): (&mut [Vec<f32>], usize),
    scratch: &mut TintScratch,
) {
    let surface_of = |row: usize| codes[row].prim().map(|prim| columns.surface_of(prim));
    let tint_of = |row: usize| surface_of(row).and_then(|s| columns.paint(s).tint.as_deref());
    out.iter_mut().for_each(|column| column[first..first + codes.len()].fill(1.0));
    let mut row = 0;
    while row < codes.len() {
        let Some(tint) = tint_of(row) else {
            row += 1;
            continue;
        };
        // As far as the surface stays the same: neighbours mostly lie on one.
        let surface = surface_of(row);
        scratch.rows.clear();
        while row < codes.len() && scratch.rows.len() < LANES {
            if surface_of(row) == surface {
                scratch.rows.push(row as u32);
            } else if tint_of(row).is_some() {
                break;
            }
            row += 1;
        }
        let rows = std::mem::take(&mut scratch.rows);
        let site = Site { columns, points, codes };
        match &tint.paint {
            TintPaint::Texture { image, filter, tiles } => {
                for row in rows.iter().map(|row| *row as usize) {
                    let (st, wrap) = match tiles {
                        Some(tiles) => (tiles.map(|t| affine(&t, site.point(row))), Wrap::Repeat),
                        // A mesh's own places may run beyond the picture: it repeats there.
                        None if tint.charts.is_empty() => (site.uv(tint, row), Wrap::Repeat),
                        None => (site.uv(tint, row), Wrap::Clamp),
                    };
                    let texel = look_up(image, st, *filter, [wrap; 2]);
                    for (k, column) in out.iter_mut().enumerate() {
                        column[first + row] = texel[k % 3];
                    }
                }
            }
            TintPaint::Maps(maps) => {
                for row in rows.iter().map(|row| *row as usize) {
                    let factors = site.factors(tint, maps, row);
                    for (column, factor) in out.iter_mut().zip(factors.as_flattened()) {
                        column[first + row] = *factor;
                    }
                }
            }
            TintPaint::Programs(programs) => {
                site.inputs(tint, &rows, &mut scratch.inputs);
                for (k, program) in programs.iter().enumerate() {
                    let Some(program) = program else { continue };
                    run(simd, program, &scratch.inputs, &mut scratch.steps);
                    for (channel, step) in program.colour.iter().enumerate() {
                        let result = &scratch.steps[*step as usize];
                        for (row, x) in rows.iter().zip(result) {
                            out[3 * k + channel][first + *row as usize] = *x;
                        }
                    }
                }
            }
        }
        scratch.rows = rows;
    }
}

/// Where tints are looked up.
struct Site<'a> {
    columns: &'a Columns,
    points: &'a Interactions,
    codes: &'a [HitCode],
}

impl Site<'_> {
    fn point(&self, row: usize) -> [f64; 3] {
        [0, 1, 2].map(|k| f64::from(self.points.p[k][row]))
    }

    fn prim(&self, row: usize) -> PrimId {
        self.codes[row].prim().unwrap_or(PrimId(0))
    }

    fn uv(&self, tint: &Tint, row: usize) -> [f64; 2] {
        let prim = self.prim(row);
        let surface = self.columns.surface_of(prim);
        let first = self.columns.surfaces.range(surface.index()).start;
        match tint.charts.get(prim.index() - first) {
            Some(chart) => uv(chart, self.point(row)),
            None => self.file_uv(surface.index(), prim, row).unwrap_or_default(),
        }
    }

    /// The corners of a mesh's triangle, as vertices, and their weights at a point of it.
    fn corners(&self, surface: usize, prim: PrimId, row: usize) -> Option<Corners<'_>> {
        let data = &self.columns.surfaces.mesh[surface].as_ref()?.data;
        let first = self.columns.surfaces.range(surface).start;
        let vertices = *data.triangles.get(prim.index() - first)?;
        let points = self.columns.geometry.triangle(prim)?;
        let p = [0, 1, 2].map(|k| self.points.p[k][row]);
        Some(Corners { data, vertices, weights: smooth::weights(points, p) })
    }

    /// The place that a mesh's file gives a point in a texture.
    fn file_uv(&self, surface: usize, prim: PrimId, row: usize) -> Option<[f64; 2]> {
        let corners = self.corners(surface, prim, row)?;
        corners.mean(&corners.data.uvs)
    }

    /// What a file's maps say at a point: factors of ambient, diffuse and specular.
    fn factors(&self, tint: &Tint, maps: &Maps, row: usize) -> [[f32; 3]; 3] {
        let prim = self.prim(row);
        let surface = self.columns.surface_of(prim).index();
        let corners = self.corners(surface, prim, row);
        let uvs = match &corners {
            Some(corners) => [&corners.data.uvs, &corners.data.second_uvs]
                .map(|uvs| corners.mean(uvs).unwrap_or_default()),
            None => [self.uv(tint, row); 2],
        };
        let sample = |map: &Map| {
            let [u, v] = match map.set {
                UvSet::First => uvs[0],
                UvSet::Second => uvs[1],
            };
            let st = map.place.map(|r| r[0] * u + r[1] * v + r[2]);
            look_up(&map.image, st, map.filter, map.wrap)
        };
        let texel = |map: &Option<Map>| map.as_ref().map_or([1.0; 3], sample);
        let ambient = texel(&maps.ambient);
        let mut diffuse = texel(&maps.diffuse);
        // A base colour is one texture for both.
        let mut specular = match (&maps.diffuse, &maps.specular) {
            (Some(base), Some(specular)) if base.is_same(specular) => diffuse,
            _ => texel(&maps.specular),
        };
        match &maps.mirrored {
            Mirrored::AsGiven => {}
            Mirrored::Metal { map, metalness, roughness } => {
                let [_, green, blue] = sample(map);
                let share = metalness * blue * (1.0 - roughness * green);
                diffuse = diffuse.map(|x| x * (1.0 - share));
                specular = specular.map(|x| x * share);
            }
            Mirrored::Specular(factor) => {
                let most = look_up::product(specular, *factor).into_iter().fold(0.0, greatest);
                diffuse = diffuse.map(|x| x * (1.0 - most));
            }
        }
        let colour = corners.and_then(|corners| corners.mean(&corners.data.colours));
        let colour = colour.map(|colour| colour.map(|x| x as f32));
        let mut factors = [ambient, diffuse, specular];
        for (factor, by_vertex) in factors.iter_mut().zip(maps.by_vertex) {
            if let Some(colour) = colour.filter(|_| by_vertex) {
                *factor = look_up::product(*factor, colour);
            }
        }
        factors
    }

    /// The inputs of an expression at some rows; zeros in lanes that are left.
    fn inputs(&self, tint: &Tint, rows: &[u32], inputs: &mut [[f32; LANES]; 8]) {
        *inputs = [[0.0; LANES]; 8];
        for (lane, row) in rows.iter().map(|row| *row as usize).enumerate() {
            let p = tint.local.map(|r| affine(&r, self.point(row)) as f32);
            let [u, v] = self.uv(tint, row).map(|x| x as f32);
            let n = [0, 1, 2].map(|k| f64::from(self.points.n[k][row]));
            let n = tint.turn.map(|r| r[0] * n[0] + r[1] * n[1] + r[2] * n[2]);
            let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
            let [nx, ny, nz] = n.map(|x| (x / length) as f32);
            for (input, x) in inputs.iter_mut().zip([p[0], p[1], p[2], u, v, nx, ny, nz]) {
                input[lane] = x;
            }
        }
    }
}

/// Where on a triangle of a mesh a point lies.
struct Corners<'a> {
    data: &'a MeshData,
    vertices: [u32; 3],
    weights: [f64; 3],
}

impl Corners<'_> {
    /// The mean of a column of vertices by the corners' weights.
    fn mean<const N: usize>(&self, column: &[[f32; N]]) -> Option<[f64; N]> {
        let mut mean = [0.0; N];
        for (vertex, weight) in self.vertices.iter().zip(self.weights) {
            let own = column.get(*vertex as usize)?;
            for (sum, x) in mean.iter_mut().zip(own) {
                *sum += weight * f64::from(*x);
            }
        }
        Some(mean)
    }
}

fn greatest(a: f32, b: f32) -> f32 {
    if b > a { b } else { a }
}

fn affine(row: &Row, p: [f64; 3]) -> f64 {
    row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3]
}

/// A surface's own coordinates of a point of the scene.
fn uv(chart: &Chart, p: [f64; 3]) -> [f64; 2] {
    let [x, y, z] = chart.local.map(|row| affine(&row, p));
    let turn = |y: f64, x: f64| {
        let turns = libm::atan2(y, x) / TAU;
        if turns < 0.0 { turns + 1.0 } else { turns }
    };
    match chart.kind {
        ChartKind::Flat => [x, y],
        ChartKind::Ball => [turn(-z, x), 0.5 + libm::asin(y.clamp(-1.0, 1.0)) / PI],
        ChartKind::Around([low, high]) => [turn(y, x), (z - low) / (high - low)],
        ChartKind::Ring(major) => [turn(y, x), turn(z, (x * x + y * y).sqrt() - major)],
    }
}

/// Runs a program on eight points.
#[inline(always)]
fn run<S: Simd>(
    simd: S,
    program: &Program,
    inputs: &[[f32; LANES]; 8],
    steps: &mut Vec<[f32; LANES]>,
) {
    steps.clear();
    for op in &program.ops {
        let result = match *op {
            Op::Constant(x) => [x; LANES],
            Op::Coordinate(c) => inputs[c as usize],
            Op::Unary(function, a) => unary(simd, function, &steps[a as usize]),
            Op::Binary(function, a, b) => {
                binary(simd, function, [&steps[a as usize], &steps[b as usize]])
            }
            Op::Noise(at) => {
                let [x, y, z] = at.map(|step| steps[step as usize]);
                let mut out = [0.0; LANES];
                for (lane, out) in out.iter_mut().enumerate() {
                    *out = noise([x[lane], y[lane], z[lane]]);
                }
                out
            }
        };
        steps.push(result);
    }
}

#[inline(always)]
fn unary<S: Simd>(simd: S, function: Unary, x: &[f32; LANES]) -> [f32; LANES] {
    let lanes = F::from_slice(simd, x);
    let mut out = *x;
    match function {
        Unary::Negate => (F::splat(simd, 0.0) - lanes).store_slice(&mut out),
        Unary::Abs => abs(lanes).store_slice(&mut out),
        Unary::Sqrt => lanes.sqrt().store_slice(&mut out),
        // Exact everywhere.
        Unary::Floor => each(&mut out, f32::floor),
        Unary::Sin => each(&mut out, libm::sinf),
        Unary::Cos => each(&mut out, libm::cosf),
        Unary::Acos => each(&mut out, libm::acosf),
    }
    out
}

fn each(lanes: &mut [f32; LANES], f: fn(f32) -> f32) {
    lanes.iter_mut().for_each(|x| *x = f(*x));
}

#[inline(always)]
fn binary<S: Simd>(simd: S, function: Binary, [a, b]: [&[f32; LANES]; 2]) -> [f32; LANES] {
    let (a, b) = (F::from_slice(simd, a), F::from_slice(simd, b));
    let (zero, one) = (F::splat(simd, 0.0), F::splat(simd, 1.0));
    let result = match function {
        Binary::Add => a + b,
        Binary::Subtract => a - b,
        Binary::Multiply => a * b,
        Binary::Divide => a / b,
        Binary::Min => lesser(simd, a, b),
        Binary::Max => greater(simd, a, b),
        Binary::Step => b.simd_ge(a).select(one, zero),
    };
    let mut out = [0.0; LANES];
    result.store_slice(&mut out);
    out
}

/// Gradient noise (Perlin, "Improving Noise", SIGGRAPH 2002), its permutation in place of a table by
/// an integer hash (Wellons' lowbias32, 2018). From -1 to 1, and 0 at whole coordinates.
fn noise(p: [f32; 3]) -> f32 {
    let floor = p.map(f32::floor);
    // Beyond the whole numbers that f32 tells apart there is nothing between.
    if !floor.iter().all(|x| x.abs() < 16_777_216.0) {
        return 0.0;
    }
    let cell = floor.map(|x| x as i32 as u32);
    let f = [p[0] - floor[0], p[1] - floor[1], p[2] - floor[2]];
    let fade = |t: f32| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let [u, v, w] = f.map(fade);
    let corner = |i: u32, j: u32, k: u32| {
        let at = |n: usize, o: u32| cell[n].wrapping_add(o);
        let h = hash(hash(hash(at(0, i)).wrapping_add(at(1, j))).wrapping_add(at(2, k)));
        let d = [f[0] - i as f32, f[1] - j as f32, f[2] - k as f32];
        // One of the twelve edges of a cube, four of them twice.
        let a = if h & 15 < 8 { d[0] } else { d[1] };
        let b = match h & 15 {
            0..=3 => d[1],
            12 | 14 => d[0],
            _ => d[2],
        };
        (if h & 1 == 0 { a } else { -a }) + (if h & 2 == 0 { b } else { -b })
    };
    let mix = |a: f32, b: f32, t: f32| a + t * (b - a);
    let along = |j, k| mix(corner(0, j, k), corner(1, j, k), u);
    let plane = |k| mix(along(0, k), along(1, k), v);
    mix(plane(0), plane(1), w)
}

fn hash(x: u32) -> u32 {
    let x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    let x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// How a surface's tint changes its material.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Combine {
    /// Not at all.
    #[default]
    Nothing,
    /// All reflectivities are multiplied with columns 0 to 2.
    Times,
    /// Ambient, diffuse and specular are multiplied with columns 0 to 2, 3 to 5 and 6 to 8.
    Each,
    /// Ambient, diffuse and specular, where marked, are columns 0 to 2, 3 to 5 and 6 to 8.
    Instead([bool; 3]),
}

impl Combine {
    pub fn of(tint: Option<&Tint>) -> Combine {
        match tint.map(|tint| &tint.paint) {
            None => Combine::Nothing,
            Some(TintPaint::Texture { .. }) => Combine::Times,
            Some(TintPaint::Maps(_)) => Combine::Each,
            Some(TintPaint::Programs(programs)) => {
                Combine::Instead([0, 1, 2].map(|k| programs[k].is_some()))
            }
        }
    }

    /// The specular reflectivity of a node.
    pub fn specular(self, own: [f32; 3], level: &Level, row: usize) -> [f32; 3] {
        let at = |k: usize| level.tint[k][row];
        match self {
            Combine::Times => [0, 1, 2].map(|k| own[k] * at(k)),
            Combine::Each => [0, 1, 2].map(|k| own[k] * at(6 + k)),
            Combine::Instead([_, _, true]) => [at(6), at(7), at(8)],
            _ => own,
        }
    }

    /// Whether a node casts a mirrored ray. Of a product each factor counts: it may round to 0 for
    /// one colour of the material and not for another, and kept trees would not know.
    pub fn is_specular(self, own: [f32; 3], level: &Level, row: usize) -> bool {
        let unit = own.map(|x| if x == 0.0 { 0.0 } else { 1.0 });
        self.specular(unit, level, row).iter().any(|s| *s != 0.0)
    }
}
