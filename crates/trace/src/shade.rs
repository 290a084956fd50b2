//! The second pass: nodes and today's colours to pixels, deepest level first.

use crate::grid::TileRect;
use crate::trees::{Level, Trees};
use fearless_simd::prelude::*;
use fearless_simd::{Level as SimdLevel, dispatch};
use reflet_accel::lanes::{F, LANES};
use reflet_pack::materials::{MaterialRow, Rgb};
use reflet_pack::{Attenuation, Columns, LightId};

/// Linear colours of one tile: planes of red, green and blue, rows of `edge` pixels.
#[derive(Clone, Debug, Default)]
pub struct TileColours {
    /// Red, green, blue.
    pub rgb: [Vec<f32>; 3],
}

/// What the second pass reads.
pub struct Shader<'a> {
    columns: &'a Columns,
    level: SimdLevel,
    emissivity: Vec<Rgb>,
}

/// Memory of one thread for the second pass.
#[derive(Default)]
pub struct ShadeScratch {
    /// The tile's materials of today; entry 0 is a miss.
    colours: Vec<MaterialRow>,
    /// What the mirrored rays of a level return.
    below: [Vec<f32>; 3],
    /// The level's own colours.
    own: [Vec<f32>; 3],
    sum: [Vec<f32>; 3],
}

impl<'a> Shader<'a> {
    /// A shader with the colours of `columns`.
    pub fn new(columns: &'a Columns, level: SimdLevel) -> Self {
        let lights = columns.lights.len() as u32;
        let emissivity = (0..lights).map(|i| columns.emissivity(LightId(i))).collect();
        Shader { columns, level, emissivity }
    }

    /// The colours of a tile of `edge` pixels a side: the mean over its samples' trees.
    pub fn shade(
        &self,
        samples: &[Trees],
        rect: TileRect,
        edge: u32,
        scratch: &mut ShadeScratch,
        out: &mut TileColours,
    ) {
        for (i, trees) in samples.iter().enumerate() {
            self.shade_sample(trees, scratch);
            for k in 0..3 {
                if i == 0 {
                    scratch.sum[k].clone_from(&scratch.own[k]);
                } else {
                    for (s, c) in scratch.sum[k].iter_mut().zip(&scratch.own[k]) {
                        *s += c;
                    }
                }
            }
        }
        let n = samples.len() as f32;
        let (w, edge) = (rect.width as usize, edge as usize);
        for k in 0..3 {
            out.rgb[k].clear();
            out.rgb[k].resize(edge * edge, 0.0);
            for y in 0..rect.height as usize {
                let row = &mut out.rgb[k][y * edge..][..w];
                for (o, s) in row.iter_mut().zip(&scratch.sum[k][y * w..]) {
                    *o = if samples.len() == 1 { *s } else { s / n };
                }
            }
        }
    }

    /// Leaves the colours of one sample in `scratch.own`.
    fn shade_sample(&self, trees: &Trees, scratch: &mut ShadeScratch) {
        let model = &self.columns.model;
        scratch.colours.clear();
        scratch.colours.push(MaterialRow { ambient: model.background, ..Default::default() });
        let today = trees.palette.iter().map(|s| *self.columns.material(s.material(self.columns)));
        scratch.colours.extend(today);
        let deepest = trees.levels.len().min(model.max_bounces as usize + 1);
        for depth in (0..deepest).rev() {
            let level = &trees.levels[depth];
            let len = level.len().next_multiple_of(LANES);
            for k in 0..3 {
                scratch.below[k].clear();
                scratch.below[k].resize(len, 0.0);
            }
            if let Some(child) = trees.levels[..deepest].get(depth + 1) {
                for (i, parent) in child.parent.iter().enumerate() {
                    let parent = usize::from(*parent);
                    if level.total[parent] <= model.max_path {
                        for k in 0..3 {
                            scratch.below[k][parent] = scratch.own[k][i];
                        }
                    }
                }
            }
            for k in 0..3 {
                scratch.own[k].resize(len, 0.0);
            }
            dispatch!(self.level, simd => self.shade_level(simd, level, scratch));
        }
    }

    #[inline(always)]
    fn shade_level<S: Simd>(&self, simd: S, level: &Level, scratch: &mut ShadeScratch) {
        let len = level.len();
        for first in (0..len).step_by(LANES) {
            let some = first..(first + LANES).min(len);
            let mut gathered = [[0.0; LANES]; 9];
            for (lane, slot) in level.slot[some.clone()].iter().enumerate() {
                let row = &scratch.colours[usize::from(*slot)];
                for k in 0..3 {
                    gathered[k][lane] = row.ambient[k];
                    gathered[3 + k][lane] = row.diffuse[k];
                    gathered[6 + k][lane] = row.specular[k];
                }
            }
            let column = |k: usize| F::from_slice(simd, &gathered[k]);
            let mut intensity = [column(0), column(1), column(2)];
            let diffuse = [column(3), column(4), column(5)];
            let specular = [column(6), column(7), column(8)];
            for (terms, emissivity) in level.light.iter().zip(&self.emissivity) {
                let term = load(simd, &terms[some.clone()], 0.0);
                for k in 0..3 {
                    let light = times(simd, diffuse[k] * F::splat(simd, emissivity[k]), term);
                    intensity[k] += light;
                }
            }
            if self.columns.model.attenuation == Attenuation::Inverse {
                let inverse = F::splat(simd, 1.0) / load(simd, &level.total[some.clone()], 1.0);
                for i in &mut intensity {
                    *i = times(simd, *i, inverse);
                }
            }
            for k in 0..3 {
                let below = F::from_slice(simd, &scratch.below[k][first..first + LANES]);
                let colour = intensity[k] + times(simd, specular[k], below);
                colour.store_slice(&mut scratch.own[k][first..first + LANES]);
            }
        }
    }
}

/// `a * b`, but 0 where either is exactly 0: a factor of 0 contributes nothing, whatever it would
/// multiply (0 times infinity is NaN).
#[inline(always)]
fn times<S: Simd>(simd: S, a: F<S>, b: F<S>) -> F<S> {
    let zero = F::splat(simd, 0.0);
    (a.simd_eq(zero) | b.simd_eq(zero)).select(zero, a * b)
}

/// Up to a whole set of lanes; `rest` fills the others.
#[inline(always)]
fn load<S: Simd>(simd: S, column: &[f32], rest: f32) -> F<S> {
    if column.len() == LANES {
        return F::from_slice(simd, column);
    }
    let mut lanes = [rest; LANES];
    lanes[..column.len()].copy_from_slice(column);
    F::from_slice(simd, &lanes)
}
