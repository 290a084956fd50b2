//! The cells of patterns that alternate between two materials.

use crate::parts::{Anchor, across};
use crate::view::unit;
use glam::{DAffine3, DVec3};
use reflet_scene::material::{Checker, Stripes, Tiles};

/// The cells of a pattern on one surface: for each of its directions, floor((p - origin).axis /
/// size). One direction makes stripes, two tile a flat surface, three fill space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cells {
    /// The corner of cell 0.
    pub origin: [f32; 3],
    /// The directions; of unit length unless an instance scales them. Those that are not in use are
    /// zero.
    pub axes: [[f32; 3]; 3],
    /// The cells' lengths; 1 along a direction that is not in use.
    pub size: [f32; 3],
}

impl Cells {
    /// The bits of all numbers.
    pub fn bits(&self) -> [u32; 15] {
        let mut out = [0; 15];
        let all = self.origin.iter().chain(self.axes.iter().flatten()).chain(&self.size);
        for (o, v) in out.iter_mut().zip(all) {
            *o = v.to_bits();
        }
        out
    }

    /// The cells of `checker`.
    ///
    /// Where `xdir` is along the normal (which scripts are told is an error) any direction across the
    /// normal serves.
    pub(crate) fn checker(checker: &Checker, anchor: &Anchor) -> Wide {
        match checker.size {
            Tiles::Flat(size) => {
                let [x, y] = in_plane(checker.xdir, anchor.normal.unwrap_or(DVec3::Y));
                let axes = [x, y, DVec3::ZERO];
                Wide { origin: anchor.origin, axes, size: [size[0], size[1], 1.0] }
            }
            Tiles::Solid(size) => {
                Wide { origin: anchor.origin, axes: [DVec3::X, DVec3::Y, DVec3::Z], size }
            }
        }
    }

    /// The cells of `stripes`.
    pub(crate) fn stripes(stripes: &Stripes, anchor: &Anchor) -> Wide {
        let x = match anchor.normal {
            Some(normal) => in_plane(stripes.xdir, normal)[0],
            None => unit(stripes.xdir),
        };
        let axes = [x, DVec3::ZERO, DVec3::ZERO];
        Wide { origin: anchor.origin, axes, size: [stripes.width, 1.0, 1.0] }
    }
}

/// The two unit directions of patterns on a flat surface.
pub(crate) fn in_plane(xdir: DVec3, normal: DVec3) -> [DVec3; 2] {
    let n = unit(normal);
    let x = across(xdir, n).unwrap_or_else(|| n.any_orthonormal_vector());
    [x, n.cross(x)]
}

/// [`Cells`] before they are rounded.
pub(crate) struct Wide {
    origin: DVec3,
    axes: [DVec3; 3],
    size: [f64; 3],
}

impl Wide {
    /// The cells as `to` moves the surface that they are on.
    pub fn moved(&self, to: &DAffine3) -> Wide {
        let turn = to.matrix3.inverse().transpose();
        Wide {
            origin: to.transform_point3(self.origin),
            axes: self.axes.map(|axis| turn * axis),
            size: self.size,
        }
    }

    pub fn rounded(&self) -> Cells {
        let f32s = |v: DVec3| v.to_array().map(|x| x as f32);
        Cells {
            origin: f32s(self.origin),
            axes: self.axes.map(f32s),
            size: self.size.map(|s| s as f32),
        }
    }
}
