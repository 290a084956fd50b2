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
    /// The sum over the samples added so far.
    sum: [Vec<f32>; 3],
    samples: u32,
}

impl<'a> Shader<'a> {
    /// A shader with the colours of `columns`.
    pub fn new(columns: &'a Columns, level: SimdLevel) -> Self {
        let lights = columns.lights.len() as u32;
        let emissivity = (0..lights).map(|i| columns.emissivity(LightId(i))).collect();
        Shader { columns, level, emissivity }
    }

    /// Starts the mean over a tile's samples.
    pub fn begin(&self, scratch: &mut ShadeScratch) {
        scratch.samples = 0;
    }

    /// Adds the colours of one sample's trees. Samples are added in their order.
    pub fn add(&self, trees: &Trees, scratch: &mut ShadeScratch) {
        self.shade_sample(trees, scratch);
        for (sum, own) in scratch.sum.iter_mut().zip(&scratch.own) {
            if scratch.samples == 0 {
                sum.clone_from(own);
            } else {
                sum.iter_mut().zip(own).for_each(|(s, c)| *s += c);
            }
        }
        scratch.samples += 1;
    }

    /// Ends the mean: colours of a tile of `edge` pixels a side, of which `rect` is in the picture.
    pub fn finish(&self, rect: TileRect, edge: u32, scratch: &ShadeScratch, out: &mut TileColours) {
        let n = scratch.samples as f32;
        let (w, edge) = (rect.width as usize, edge as usize);
        for (plane, sum) in out.rgb.iter_mut().zip(&scratch.sum) {
            plane.clear();
            plane.resize(edge * edge, 0.0);
            for y in 0..rect.height as usize {
                for (o, s) in plane[y * edge..][..w].iter_mut().zip(&sum[y * w..]) {
                    // One sample is its own mean: s / 1 is s.
                    *o = s / n;
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
