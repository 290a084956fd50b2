//! Polygons as files list them, until all vertices are known.

use crate::left_out::{CROSSED, LeftOut, NOT_FINITE};
use crate::polygon::{Cut, triangulate};

/// Polygons of three corners and more, one after the other.
#[derive(Debug)]
pub(crate) struct Faces<C> {
    corners: Vec<C>,
    /// Where each one ends in `corners`.
    ends: Vec<u32>,
}

impl<C> Default for Faces<C> {
    fn default() -> Self {
        Self { corners: Vec::new(), ends: Vec::new() }
    }
}

impl<C: Copy> Faces<C> {
    /// Makes room.
    pub fn reserve(&mut self, faces: usize) {
        self.corners.reserve(3 * faces);
        self.ends.reserve(faces);
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// The corners of all.
    pub fn corners(&self) -> &[C] {
        &self.corners
    }

    /// The corners of each.
    pub fn iter(&self) -> impl Iterator<Item = &[C]> {
        let starts = std::iter::once(&0).chain(&self.ends);
        starts.zip(&self.ends).map(|(start, end)| &self.corners[*start as usize..*end as usize])
    }

    /// One more corner of the polygon that [`Self::close`] ends.
    pub fn push(&mut self, corner: C) {
        self.corners.push(corner);
    }

    /// Ends a polygon, and tells whether it is one: it is left out if it has fewer than three
    /// corners.
    pub fn close(&mut self) -> bool {
        let start = self.ends.last().map_or(0, |end| *end as usize);
        let is_one = self.corners.len() - start >= 3;
        if is_one {
            // Every corner takes two bytes of a file of at most 4 GiB.
            self.ends.push(self.corners.len() as u32);
        } else {
            self.corners.truncate(start);
        }
        is_one
    }

    /// Gives the triangles of all of them, each with the number of its polygon.
    pub fn triangles(
        &self,
        position: impl Fn(C) -> [f32; 3],
        left_out: &mut LeftOut,
        mut emit: impl FnMut(usize, [C; 3]),
    ) {
        let mut places = Vec::new();
        for (number, corners) in self.iter().enumerate() {
            places.clear();
            places.extend(corners.iter().map(|corner| position(*corner)));
            if !places.iter().flatten().all(|x| x.is_finite()) {
                left_out.add(NOT_FINITE, None);
                continue;
            }
            let mut emit = |triangle: [usize; 3]| emit(number, triangle.map(|i| corners[i]));
            if triangulate(&places, &mut emit) == Cut::Crossed {
                left_out.add(CROSSED, None);
            }
        }
    }
}
