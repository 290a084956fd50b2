//! Which primitives are one surface, and what it wears.

pub use crate::cells::Cells;
use crate::ids::{MaterialId, PrimId};
use crate::tints::{Tint, TintPaint};
use reflet_scene::{Key, Mesh};
use std::ops::Range;
use std::sync::Arc;

/// What a surface wears.
#[derive(Clone, Debug)]
pub struct Paint {
    /// The material of even cells, or of all of it without a pattern.
    pub even: MaterialId,
    /// The material of odd cells; equal to `even` without a pattern.
    pub odd: MaterialId,
    /// The pattern's cells, if it has one.
    pub cells: Option<Box<Cells>>,
    /// What makes its reflectivities differ from point to point.
    pub tint: Option<Arc<Tint>>,
}

impl Paint {
    /// The same material everywhere.
    pub(crate) fn plain(material: MaterialId) -> Paint {
        Paint { even: material, odd: material, cells: None, tint: None }
    }
}

/// Surfaces in key order.
#[derive(Clone, Debug, Default)]
pub struct Surfaces {
    /// Whose row it is; that of an instance shows another's shape.
    pub key: Vec<Key>,
    /// What each wears.
    pub paint: Vec<Paint>,
    /// The first of its primitives; of a mesh's further material, the mesh's first.
    pub first_prim: Vec<PrimId>,
    /// How many primitives it has: mostly 1; the faces and caps of a shape, the triangles of a mesh.
    /// The row of a mesh's first material counts them all, those of further ones count none.
    pub prims: Vec<u32>,
    /// Whether it is in the picture.
    pub visible: Vec<bool>,
    /// The placement, for those that are meshes.
    pub mesh: Vec<Option<Arc<Mesh>>>,
    /// For meshes, the bits of the way that groups and instances move them on, if they do.
    pub moved_by: Vec<Option<Box<[u64; 12]>>>,
    /// For meshes that are lit by their file's normals, the turn of these, but for their length.
    pub smooth: Vec<Option<Box<[[f64; 3]; 3]>>>,
    /// How many wear a texture.
    textured: usize,
    /// How many wear expressions, or maps.
    shaded: usize,
    /// How many are smooth.
    smooth_count: usize,
}

impl Surfaces {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.key.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.key.is_empty()
    }

    /// Gives surface `i` what it wears.
    pub(crate) fn set_paint(&mut self, i: usize, paint: Paint) {
        let old = std::mem::replace(&mut self.paint[i], paint);
        self.count_tint(&old, usize::wrapping_sub);
        let new = self.paint[i].clone();
        self.count_tint(&new, usize::wrapping_add);
    }

    pub(crate) fn count_tint(&mut self, paint: &Paint, count: fn(usize, usize) -> usize) {
        match paint.tint.as_ref().map(|tint| &tint.paint) {
            None => {}
            Some(TintPaint::Texture { .. }) => self.textured = count(self.textured, 1),
            Some(TintPaint::Maps(_) | TintPaint::Programs(_)) => {
                self.shaded = count(self.shaded, 1);
            }
        }
    }

    pub(crate) fn set_smooth(&mut self, i: usize, turn: Option<[[f64; 3]; 3]>) {
        self.smooth_count -= usize::from(self.smooth[i].is_some());
        self.smooth_count += usize::from(turn.is_some());
        self.smooth[i] = turn.map(Box::new);
    }

    pub(crate) fn truncate_smooth(&mut self, n: usize) {
        let gone = self.smooth.split_off(n.min(self.smooth.len()));
        self.smooth_count -= gone.iter().filter(|turn| turn.is_some()).count();
    }

    /// Whether any is lit by normals of its own.
    pub fn any_smooth(&self) -> bool {
        self.smooth_count > 0
    }

    /// The numbers that a point's tint has: 0, 3 for a texel, 9 for three colours.
    pub fn tint_channels(&self) -> usize {
        match (self.textured, self.shaded) {
            (0, 0) => 0,
            (_, 0) => 3,
            _ => 9,
        }
    }

    /// The primitives of surface `i`.
    pub fn range(&self, i: usize) -> Range<usize> {
        let first = self.first_prim[i].index();
        first..first + self.prims[i] as usize
    }
}
