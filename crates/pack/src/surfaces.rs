//! Which primitives are one surface, and what it wears.

use crate::ids::{MaterialId, PrimId};
use crate::view::unit;
use reflet_scene::{Checker, DVec3, Key, Mesh};
use std::ops::Range;
use std::sync::Arc;

/// The cells of a pattern on one flat surface: cell (floor((p - origin).x / size\[0\]),
/// floor((p - origin).y / size\[1\])).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cells {
    /// The corner of cell (0, 0).
    pub origin: [f32; 3],
    /// The unit direction of the first coordinate.
    pub x: [f32; 3],
    /// The unit direction of the second coordinate.
    pub y: [f32; 3],
    /// The cells' lengths.
    pub size: [f32; 2],
}

impl Cells {
    /// The bits of all eleven numbers.
    pub fn bits(&self) -> [u32; 11] {
        let mut out = [0; 11];
        let all = self.origin.iter().chain(&self.x).chain(&self.y).chain(&self.size);
        for (o, v) in out.iter_mut().zip(all) {
            *o = v.to_bits();
        }
        out
    }

    /// The cells of `checker` on a surface with `origin` and `normal` (of any length).
    ///
    /// Where `xdir` is along the normal (which scripts are told is an error) or the surface is
    /// curved, any direction across the normal serves.
    pub(crate) fn new(checker: &Checker, origin: DVec3, normal: DVec3) -> Cells {
        let n = unit(normal);
        let flat = checker.xdir - n * checker.xdir.dot(n);
        let x = if flat.length() > 0.0 { unit(flat) } else { n.any_orthonormal_vector() };
        Cells {
            origin: origin.to_array().map(|v| v as f32),
            x: x.to_array().map(|v| v as f32),
            y: n.cross(x).to_array().map(|v| v as f32),
            size: checker.size.map(|v| v as f32),
        }
    }
}

/// What a surface wears.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paint {
    /// The material of even cells, or of all of it without a pattern.
    pub even: MaterialId,
    /// The material of odd cells; equal to `even` without a pattern.
    pub odd: MaterialId,
    /// The pattern's cells, if it has one.
    pub cells: Option<Cells>,
}

/// Surfaces in key order.
#[derive(Clone, Debug, Default)]
pub struct Surfaces {
    /// Whose row it is.
    pub key: Vec<Key>,
    /// What each wears.
    pub paint: Vec<Paint>,
    /// The first of its primitives; the last row's end is the number of primitives.
    pub first_prim: Vec<PrimId>,
    /// How many primitives it has: 1, or the triangles of a mesh.
    pub prims: Vec<u32>,
    /// Whether it is in the picture.
    pub visible: Vec<bool>,
    /// The placement, for those that are meshes.
    pub mesh: Vec<Option<Arc<Mesh>>>,
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

    /// The primitives of surface `i`.
    pub fn range(&self, i: usize) -> Range<usize> {
        let first = self.first_prim[i].index();
        first..first + self.prims[i] as usize
    }
}
