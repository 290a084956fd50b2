//! Flat surfaces that lie in one plane and overlap.

use reflet_scene::{DVec3, Key, Quad, Triangle};
use std::collections::HashMap;

/// How near is the same, relative to the size of what is compared: well above the rounding of a
/// script's own arithmetic, well below what a scene means to hold apart.
pub const NEAR: f64 = 1e-6;

/// A plane as a key of a map: unit normal (its first part that is not 0 is positive) and distance
/// from the origin, on a grid. The grid's offset keeps round numbers away from its lines; two planes
/// that an unlucky line parts are missed, which costs a warning and nothing else.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PlaneKey([i64; 5]);

/// A plane with a unit normal; `None` if the normal is zero or not finite.
#[derive(Clone, Copy, Debug)]
pub struct PlaneOf {
    normal: DVec3,
    distance: f64,
}

impl PlaneOf {
    /// The plane through a point across a normal of any length.
    pub fn new(point: DVec3, normal: DVec3) -> Option<Self> {
        let length = normal.length();
        if !(length > 0.0 && length.is_finite()) {
            return None;
        }
        let mut normal = normal / length;
        let first = normal.to_array().into_iter().find(|x| x.abs() > NEAR)?;
        if first < 0.0 {
            normal = -normal;
        }
        Some(Self { normal, distance: normal.dot(point) })
    }

    /// Where the plane stands on the grid.
    pub fn key(&self) -> PlaneKey {
        let cell = |x: f64| libm::floor(x * 1e5 + 0.37) as i64;
        let size = self.distance.abs().max(1.0);
        let power = libm::ceil(libm::log2(size) - 1e-4);
        let [x, y, z] = self.normal.to_array().map(cell);
        PlaneKey([x, y, z, cell(self.distance / libm::exp2(power)), power as i64])
    }

    /// How far a point is from the plane.
    pub fn distance_of(&self, p: DVec3) -> f64 {
        (self.normal.dot(p) - self.distance).abs()
    }

    /// The two axes that show the plane best: the normal's greatest part is left out.
    fn axes(&self) -> (usize, usize) {
        let n = self.normal.abs().to_array();
        let greatest = (0..3).max_by(|a, b| n[*a].total_cmp(&n[*b])).unwrap_or(2);
        ((greatest + 1) % 3, (greatest + 2) % 3)
    }
}

/// A convex flat piece: a quad, or a triangle (whose last corner then comes twice).
#[derive(Clone, Copy, Debug)]
pub struct Piece {
    /// Whose it is.
    pub key: Key,
    /// Its corners, in order around it.
    pub corners: [DVec3; 4],
}

impl Piece {
    /// The piece that a quad is.
    pub fn quad(key: Key, q: &Quad) -> Self {
        Self { key, corners: [q.corner, q.corner + q.u, q.corner + q.u + q.v, q.corner + q.v] }
    }

    /// The piece that a triangle is.
    pub fn triangle(key: Key, t: &Triangle) -> Self {
        Self { key, corners: [t.a, t.b, t.c, t.c] }
    }

    /// The plane that it lies in.
    pub fn plane(&self) -> Option<PlaneOf> {
        let [a, b, c, _] = self.corners;
        PlaneOf::new(a, (b - a).cross(c - a))
    }

    fn size(&self) -> f64 {
        let [a, ..] = self.corners;
        self.corners.iter().map(|p| (*p - a).abs().max_element()).fold(0.0, f64::max)
    }

    /// Whether it shares an area with another piece; meeting along an edge is none.
    pub fn overlaps(&self, other: &Piece, plane: &PlaneOf) -> bool {
        let size = self.size().max(other.size());
        let farthest = other.corners.iter().map(|p| p.abs().max_element()).fold(size, f64::max);
        // Far from the origin, what differs less than `f32` tells apart is the same.
        let apart = NEAR * size + f64::from(f32::EPSILON) * farthest;
        if other.corners.iter().any(|p| plane.distance_of(*p) > apart) {
            return false;
        }
        let (i, j) = plane.axes();
        let flat = |piece: &Piece| piece.corners.map(|p| [p[i], p[j]]);
        let (a, b) = (flat(self), flat(other));
        // Two convex shapes are apart if they are apart across an edge of one of them.
        let edges = |p: [[f64; 2]; 4]| (0..4).map(move |k| (p[k], p[(k + 1) % 4]));
        edges(a).chain(edges(b)).all(|(p, q)| {
            let (x, y) = (p[1] - q[1], q[0] - p[0]);
            let length = libm::hypot(x, y);
            if length == 0.0 {
                return true;
            }
            let along = |s: [[f64; 2]; 4]| {
                let t = s.map(|p| (p[0] * x + p[1] * y) / length);
                (t.into_iter().fold(f64::MAX, f64::min), t.into_iter().fold(f64::MIN, f64::max))
            };
            let ((a0, a1), (b0, b1)) = (along(a), along(b));
            a1.min(b1) - a0.max(b0) > apart
        })
    }
}

/// The flat pieces of a scene, by plane.
#[derive(Default)]
pub struct Flats {
    groups: HashMap<PlaneKey, Vec<Piece>>,
}

impl Flats {
    /// Adds a piece.
    pub fn add(&mut self, piece: Piece) {
        if let Some(plane) = piece.plane() {
            self.groups.entry(plane.key()).or_default().push(piece);
        }
    }

    /// Whether there is no piece.
    pub fn is_empty(&self) -> bool {
        self.groups.is_empty()
    }

    /// The pieces that may lie in the plane.
    pub fn near(&self, plane: &PlaneOf) -> &[Piece] {
        self.groups.get(&plane.key()).map_or(&[], Vec::as_slice)
    }

    /// Pairs that overlap, the piece made first in front, sorted. At most `tests` pairs are looked
    /// at.
    pub fn overlapping(&mut self, mut tests: u64) -> Vec<(Key, Key)> {
        let mut found = Vec::new();
        for group in self.groups.values_mut().filter(|g| g.len() > 1) {
            let Some(plane) = group[0].plane() else { continue };
            let (axis, _) = plane.axes();
            let least = |p: &Piece| p.corners.iter().map(|c| c[axis]).fold(f64::MAX, f64::min);
            group.sort_by(|a, b| least(a).total_cmp(&least(b)));
            for (n, a) in group.iter().enumerate() {
                let end = a.corners.iter().map(|c| c[axis]).fold(f64::MIN, f64::max);
                let Some(plane) = a.plane() else { continue };
                for b in group[n + 1..].iter().take_while(|b| least(b) < end) {
                    if tests == 0 {
                        break;
                    }
                    tests -= 1;
                    if a.overlaps(b, &plane) {
                        found.push((a.key.min(b.key), a.key.max(b.key)));
                    }
                }
            }
        }
        found.sort_unstable();
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quad(x: f64, y: f64, z: f64, w: f64, h: f64) -> Quad {
        let corner = DVec3::new(x, y, z);
        Quad { corner, u: DVec3::new(w, 0.0, 0.0), v: DVec3::new(0.0, h, 0.0) }
    }

    fn pairs(quads: &[Quad]) -> Vec<(Key, Key)> {
        let mut flats = Flats::default();
        for (i, q) in quads.iter().enumerate() {
            flats.add(Piece::quad(Key(i as u32), q));
        }
        flats.overlapping(1000)
    }

    #[test]
    fn overlap_is_an_area() {
        let a = quad(0.0, 0.0, 1.0, 2.0, 1.0);
        assert_eq!(pairs(&[a, quad(1.0, 0.0, 1.0, 2.0, 1.0)]), [(Key(0), Key(1))]);
        assert_eq!(pairs(&[a, a]), [(Key(0), Key(1))], "exact copies");
        assert_eq!(pairs(&[a, quad(0.5, 0.25, 1.0, 0.1, 0.1)]), [(Key(0), Key(1))], "inside");
        assert_eq!(pairs(&[a, quad(2.0, 0.0, 1.0, 2.0, 1.0)]), [], "a common edge");
        assert_eq!(pairs(&[a, quad(1.0, 0.0, 1.1, 2.0, 1.0)]), [], "another plane");
        assert_eq!(pairs(&[a, quad(0.0, 1.5, 1.0, 2.0, 1.0)]), [], "apart");
    }

    #[test]
    fn turned_over_is_the_same_plane() {
        let a = quad(0.0, 0.0, -3.0, 2.0, 1.0);
        let back = Quad { corner: a.corner, u: a.v, v: a.u };
        assert_eq!(pairs(&[a, back]), [(Key(0), Key(1))]);
    }

    #[test]
    fn oblique_planes_survive_their_rounding() {
        // The same oblique plane from corners that were computed differently.
        let n = DVec3::new(0.3, -0.7, 0.2).normalize();
        let u = n.any_orthonormal_vector();
        let v = n.cross(u);
        for distance in [0.0, 0.1, 1.0, 2.0, 1000.0 / 3.0, 1e6] {
            let at = |s: f64, t: f64| n * distance + u * s + v * t;
            let a = Quad { corner: at(0.0, 0.0), u: u * 2.0, v };
            let b = Quad { corner: at(1.1, 0.3), u, v: (v + u) / 3.0 };
            assert_eq!(pairs(&[a, b]), [(Key(0), Key(1))], "{distance}");
        }
    }

    #[test]
    fn a_triangle_beside_the_diagonal_is_apart() {
        let (a, b, c, d) = (DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y);
        let mut flats = Flats::default();
        flats.add(Piece::triangle(Key(0), &Triangle { a, b, c }));
        flats.add(Piece::triangle(Key(1), &Triangle { a, b: c, c: d }));
        assert_eq!(flats.overlapping(1000), []);
        flats.add(Piece::triangle(Key(2), &Triangle { a, b, c: d }));
        assert_eq!(flats.overlapping(1000), [(Key(0), Key(2)), (Key(1), Key(2))]);
    }
}
