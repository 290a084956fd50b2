//! The second pass: nodes and the colours of one or more frames to pixels, deepest level first.
//!
//! A node's colour is its local colour (what the surface gives off and scatters) plus its specular
//! reflectivity times the colour of its mirrored ray. Local colours are kept from frame to frame of
//! a batch and made anew only on surfaces whose part of them changed, so a frame in which specular
//! reflectivities change costs one product a mirrored ray.

use crate::colours::{BatchColours, FrameSettings, MaterialsByFrame};
use crate::grid::TileRect;
use crate::palette::Slot;
use crate::tint::Combine;
use crate::trees::{Level, Trees};
use fearless_simd::prelude::*;
use fearless_simd::{Level as SimdLevel, dispatch, f32x4};
use reflet_pack::materials::MaterialRow;
use reflet_pack::{Attenuation, Columns};

/// A linear colour: red, green, blue, and a fourth number that means nothing.
pub type Colour = [f32; 4];

/// What the second pass reads.
pub struct Shader<'a> {
    columns: &'a Columns,
    batch: &'a BatchColours,
    materials: MaterialsByFrame,
    level: SimdLevel,
}

/// Memory of one thread for the second pass, and what it counted.
#[derive(Default)]
pub struct ShadeScratch {
    /// Nodes whose local colour was computed.
    pub local_nodes: u64,
    /// Products of a reflectivity and a mirrored ray's colour.
    pub mirrored_nodes: u64,
    table: SlotTable,
    /// Where each level begins in `local` and `own`.
    starts: Vec<usize>,
    local: Vec<Colour>,
    own: Vec<Colour>,
    frames: Vec<FrameSum>,
    samples: u32,
    /// How many samples each pixel has, where that differs.
    counts: Vec<u32>,
    /// A finished tile.
    tile: Vec<Colour>,
}

/// A tile in one frame: the sum over the samples added so far.
#[derive(Clone, Debug, Default)]
struct FrameSum {
    sum: Vec<Colour>,
    /// Whether it differs from the batch's frame before.
    recoloured: bool,
}

/// The colours of a tile's slots in one frame; slot 0 is a miss.
#[derive(Default)]
struct SlotTable {
    /// Which of the batch's changing materials each slot wears, if any.
    changing: Vec<Option<u32>>,
    ambient: Vec<Colour>,
    specular: Vec<Colour>,
    /// Diffuse reflectivity times emissivity: a row of lights a slot.
    lit: Vec<Colour>,
    /// Slots whose nodes need their local colour again.
    stale: Vec<bool>,
    lights: usize,
    /// How each slot's tint changes its colours.
    tints: Vec<Combine>,
    /// Intensities of lights.
    emissivity: Vec<Colour>,
}

/// What of a tile's colours differs from the frame before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Differs {
    Nothing,
    Specular,
    Local,
}

impl<'a> Shader<'a> {
    /// A shader of the frames of `batch`, whose trees were made for `columns`.
    pub fn new(columns: &'a Columns, batch: &'a BatchColours, level: SimdLevel) -> Self {
        Shader { columns, batch, materials: MaterialsByFrame::new(batch), level }
    }

    /// Whether any but the first frame may differ from the one before it where `trees` are seen.
    pub fn recolours(&self, trees: &Trees) -> bool {
        let settings = |f: usize| self.batch.settings(f);
        (1..self.batch.len()).any(|f| settings(f) != settings(f - 1))
            || trees.palette.iter().any(|s| self.materials.find(s.material(self.columns)).is_some())
    }

    /// Starts the mean over a tile's samples.
    pub fn begin(&self, scratch: &mut ShadeScratch) {
        scratch.samples = 0;
        scratch.counts.clear();
        scratch.frames.resize_with(self.batch.len(), FrameSum::default);
        for frame in &mut scratch.frames {
            frame.recoloured = false;
        }
    }

    /// Adds the colours of one sample's trees in all frames. Samples are added in their order.
    pub fn add(&self, trees: &Trees, scratch: &mut ShadeScratch) {
        self.shade(trees, scratch, |own, sum, samples| {
            if samples == 0 {
                sum.clear();
                sum.extend_from_slice(own);
            } else {
                for (sum, own) in sum.iter_mut().zip(own) {
                    sum.iter_mut().zip(own).for_each(|(s, c)| *s += c);
                }
            }
        });
    }

    /// Adds the colours of some of a sample's trees: pairs of a row and the pixel, of so many, that
    /// it is a sample of.
    pub fn add_at(
        &self,
        trees: &Trees,
        (rows, pixels): (impl Iterator<Item = (u16, u16)> + Clone, usize),
        scratch: &mut ShadeScratch,
    ) {
        scratch.counts.resize(pixels, 0);
        for (_, pixel) in rows.clone() {
            scratch.counts[usize::from(pixel)] += 1;
        }
        self.shade(trees, scratch, |own, sum, samples| {
            if samples == 0 {
                sum.clear();
                sum.resize(pixels, Colour::default());
            }
            for (row, pixel) in rows.clone() {
                let own = &own[usize::from(row)];
                sum[usize::from(pixel)].iter_mut().zip(own).for_each(|(s, c)| *s += c);
            }
        });
    }

    /// Computes the colours of trees in all frames, and hands them on with the sum so far and the
    /// number of samples in it.
    fn shade(
        &self,
        trees: &Trees,
        scratch: &mut ShadeScratch,
        add: impl Fn(&[Colour], &mut Vec<Colour>, u32),
    ) {
        let deepest = trees.levels.len().min(self.columns.model.max_bounces as usize + 1);
        let levels = &trees.levels[..deepest];
        scratch.starts.clear();
        scratch.starts.push(0);
        for level in levels {
            scratch.starts.push(scratch.starts.last().unwrap_or(&0) + level.len());
        }
        let nodes = *scratch.starts.last().unwrap_or(&0);
        scratch.local.resize(nodes, Colour::default());
        scratch.own.resize(nodes, Colour::default());

        for frame in 0..self.batch.len() {
            let differs = scratch.table.follow(self, trees, frame);
            if differs == Differs::Local {
                let inverse = self.batch.settings(frame).attenuation == Attenuation::Inverse;
                let attenuation = if inverse { Attenuation::Inverse } else { Attenuation::None };
                dispatch!(self.level, simd => local(simd, levels, attenuation, scratch));
            }
            if differs > Differs::Nothing {
                scratch.frames[frame].recoloured = true;
                let max_path = self.columns.model.max_path;
                dispatch!(self.level, simd => mirrored(simd, levels, max_path, scratch));
            }
            let pixels = levels.first().map_or(0, Level::len);
            add(&scratch.own[..pixels], &mut scratch.frames[frame].sum, scratch.samples);
        }
        scratch.samples += 1;
    }

    /// Whether a frame of the batch, not the first, differs here from the one before.
    pub fn is_recoloured(&self, frame: usize, scratch: &ShadeScratch) -> bool {
        scratch.frames[frame].recoloured
    }

    /// Ends the mean: colours of a tile of `edge` pixels a side, row by row, of which `rect` is in
    /// the picture; black elsewhere.
    pub fn finish<'s>(
        &self,
        frame: usize,
        (rect, edge): (TileRect, u32),
        scratch: &'s mut ShadeScratch,
    ) -> &'s [Colour] {
        let ShadeScratch { frames, samples, counts, tile, .. } = scratch;
        let sum = &frames[frame].sum;
        let (w, edge) = (rect.width as usize, edge as usize);
        // One sample is its own mean: s / 1 is s.
        if *samples == 1 && sum.len() == edge * edge {
            return sum;
        }
        tile.clear();
        tile.resize(edge * edge, Colour::default());
        for (y, (out, sum)) in tile.chunks_mut(edge).zip(sum.chunks(w)).enumerate() {
            for (x, (out, sum)) in out.iter_mut().zip(sum).enumerate() {
                let n = counts.get(y * w + x).unwrap_or(samples);
                for (o, s) in out.iter_mut().zip(sum) {
                    *o = s / *n as f32;
                }
            }
        }
        tile
    }
}

impl SlotTable {
    /// Makes the table that of a frame: wholly for the first of a batch, else what differs.
    fn follow(&mut self, shader: &Shader<'_>, trees: &Trees, frame: usize) -> Differs {
        let settings = shader.batch.settings(frame);
        if frame == 0 {
            self.start(shader, trees);
        }
        let all = frame == 0 || shader.batch.settings(frame - 1) != settings;
        let mut differs = if all { Differs::Local } else { Differs::Nothing };
        if all {
            self.ambient[0] = colour(settings.background);
        }
        self.stale.fill(all);
        self.emissivity.clear();
        self.emissivity.extend(settings.emissivity.iter().map(|e| colour(*e)));
        for (i, slot) in trees.palette.iter().enumerate() {
            let row = match self.changing[i] {
                Some(c) => shader.materials.row(frame, c),
                None if all => shader.columns.material(slot.material(shader.columns)),
                None => continue,
            };
            differs = differs.max(self.set(i + 1, row, settings, all));
        }
        differs
    }

    fn start(&mut self, shader: &Shader<'_>, trees: &Trees) {
        let slots = trees.palette.len() + 1;
        self.lights = shader.columns.lights.len();
        for (column, rows) in [
            (&mut self.ambient, slots),
            (&mut self.specular, slots),
            (&mut self.lit, slots * self.lights),
        ] {
            column.clear();
            column.resize(rows, Colour::default());
        }
        self.stale.resize(slots, true);
        let tint = |s: &Slot| Combine::of(shader.columns.paint(s.surface).tint.as_deref());
        self.tints.clear();
        self.tints.push(Combine::Nothing);
        self.tints.extend(trees.palette.iter().map(tint));
        self.changing.clear();
        let find = |s: &Slot| shader.materials.find(s.material(shader.columns));
        self.changing.extend(trees.palette.iter().map(find));
    }

    /// Gives a slot the colours of `row` and tells what was different.
    fn set(&mut self, slot: usize, row: &MaterialRow, s: &FrameSettings, all: bool) -> Differs {
        let mut differs = Differs::Nothing;
        let specular = colour(row.specular);
        if bits(&self.specular[slot]) != bits(&specular) {
            self.specular[slot] = specular;
            differs = Differs::Specular;
        }
        let mut stale = all;
        let mut put = |place: &mut Colour, new: Colour| {
            stale |= bits(place) != bits(&new);
            *place = new;
        };
        put(&mut self.ambient[slot], colour(row.ambient));
        let lit = &mut self.lit[slot * self.lights..][..self.lights];
        for (place, emissivity) in lit.iter_mut().zip(&s.emissivity) {
            let [r, g, b] = row.diffuse;
            put(place, colour([r * emissivity[0], g * emissivity[1], b * emissivity[2]]));
        }
        self.stale[slot] = stale;
        if stale { Differs::Local } else { differs }
    }
}

fn colour([r, g, b]: [f32; 3]) -> Colour {
    [r, g, b, 0.0]
}

fn bits(c: &Colour) -> [u32; 4] {
    c.map(f32::to_bits)
}

/// Local colours of the nodes on stale slots, into `scratch.local`.
#[inline(always)]
fn local<S: Simd>(simd: S, levels: &[Level], attenuation: Attenuation, scratch: &mut ShadeScratch) {
    let table = &scratch.table;
    // 0 times a finite number is 0 without a look at it.
    let finite = table.lit.iter().flatten().all(|x| x.is_finite());
    let zero = f32x4::splat(simd, 0.0);
    for (level, start) in levels.iter().zip(&scratch.starts) {
        let out = &mut scratch.local[*start..start + level.len()];
        for (row, (out, slot)) in out.iter_mut().zip(&level.slot).enumerate() {
            let slot = usize::from(*slot);
            if !table.stale[slot] {
                continue;
            }
            scratch.local_nodes += 1;
            let mut c = f32x4::from_slice(simd, &table.ambient[slot]);
            let lit = &table.lit[slot * table.lights..][..table.lights];
            if table.tints[slot] == Combine::Nothing {
                for (lit, terms) in lit.iter().zip(&level.light) {
                    let lit = f32x4::from_slice(simd, lit);
                    let term = f32x4::splat(simd, terms[row]);
                    c += if finite { lit * term } else { times(simd, lit, term) };
                }
            } else {
                c = tinted(simd, table, slot, (level, row));
            }
            if attenuation == Attenuation::Inverse {
                c = times(simd, c, f32x4::splat(simd, 1.0 / level.total[row]));
            }
            // Never -0: what is added below may be +0 or nothing at all.
            (c + zero).store_slice(out);
        }
    }
}

/// What the surface of a tinted node gives off and scatters.
#[inline(always)]
fn tinted<S: Simd>(
    simd: S,
    table: &SlotTable,
    slot: usize,
    (level, row): (&Level, usize),
) -> f32x4<S> {
    let own = f32x4::from_slice(simd, &table.ambient[slot]);
    let mut c = match table.tints[slot] {
        Combine::Nothing | Combine::Instead([false, ..]) => own,
        Combine::Times | Combine::Each => times(simd, own, tint(simd, level, row, 0)),
        Combine::Instead([true, ..]) => tint(simd, level, row, 0),
    };
    let lights = slot * table.lights..(slot + 1) * table.lights;
    for (i, (lit, terms)) in table.lit[lights].iter().zip(&level.light).enumerate() {
        let lit = f32x4::from_slice(simd, lit);
        let lit = match table.tints[slot] {
            Combine::Nothing | Combine::Instead([_, false, _]) => lit,
            Combine::Times => times(simd, lit, tint(simd, level, row, 0)),
            Combine::Each => times(simd, lit, tint(simd, level, row, 3)),
            Combine::Instead([_, true, _]) => times(
                simd,
                tint(simd, level, row, 3),
                f32x4::from_slice(simd, &table.emissivity[i]),
            ),
        };
        c += times(simd, lit, f32x4::splat(simd, terms[row]));
    }
    c
}

/// Three columns of a node's tint.
#[inline(always)]
fn tint<S: Simd>(simd: S, level: &Level, row: usize, first: usize) -> f32x4<S> {
    let [r, g, b] = [&level.tint[first], &level.tint[first + 1], &level.tint[first + 2]];
    f32x4::from_slice(simd, &[r[row], g[row], b[row], 0.0])
}

/// Colours of all nodes, deepest level first, into `scratch.own`.
#[inline(always)]
fn mirrored<S: Simd>(simd: S, levels: &[Level], max_path: f32, scratch: &mut ShadeScratch) {
    scratch.own.copy_from_slice(&scratch.local);
    let (specular, tints) = (&scratch.table.specular, &scratch.table.tints);
    for depth in (1..levels.len()).rev() {
        let (parents, children) = scratch.own.split_at_mut(scratch.starts[depth]);
        let parents = &mut parents[scratch.starts[depth - 1]..];
        let above = &levels[depth - 1];
        scratch.mirrored_nodes += levels[depth].len() as u64;
        let slots = &above.slot[..parents.len()];
        let totals = &above.total[..parents.len()];
        for (child, parent) in children.iter().zip(&levels[depth].parent) {
            let parent = usize::from(*parent);
            if totals[parent] <= max_path {
                let slot = usize::from(slots[parent]);
                let mut reflectivity = specular[slot];
                if tints[slot] != Combine::Nothing {
                    let [r, g, b, _] = reflectivity;
                    reflectivity = colour(tints[slot].specular([r, g, b], above, parent));
                }
                let below = f32x4::from_slice(simd, child);
                let own = f32x4::from_slice(simd, &parents[parent]);
                let colour = own + times(simd, f32x4::from_slice(simd, &reflectivity), below);
                colour.store_slice(&mut parents[parent]);
            }
        }
    }
}

/// `a * b`, but 0 where either is exactly 0: a factor of 0 contributes nothing, whatever it would
/// multiply (0 times infinity is NaN).
#[inline(always)]
fn times<S: Simd>(simd: S, a: f32x4<S>, b: f32x4<S>) -> f32x4<S> {
    let zero = f32x4::splat(simd, 0.0);
    (a.simd_eq(zero) | b.simd_eq(zero)).select(zero, a * b)
}
