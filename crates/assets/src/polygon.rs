//! Polygons to triangles.
//!
//! A fan from the first corner where each of its triangles faces the polygon's way, as in every
//! convex polygon; otherwise ears are clipped (G. H. Meisters, "Polygons Have Ears", American
//! Mathematical Monthly, 1975; D. Eberly, "Triangulation by Ear Clipping", 2002) in the plane across
//! the polygon's area vector. What lies in an ear is looked for in a k-d tree of the corners that are
//! not convex, and the number of its nodes that are visited is bounded by the number of corners.

use std::collections::VecDeque;

/// How a polygon became triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cut {
    /// Its triangles cover it.
    Whole,
    /// Its edges cross one another, so that what it covers is undefined.
    Crossed,
}

/// Calls `push` with the triangles of a polygon, each as three places in `corners`, which are finite
/// and at least three.
pub(crate) fn triangulate(corners: &[[f32; 3]], push: &mut dyn FnMut([usize; 3])) -> Cut {
    let n = corners.len();
    let spanned = |i: usize| area([corners[0], corners[i], corners[i + 1]]);
    let whole =
        (1..n - 1).map(spanned).fold([0.0; 3], |sum, part| [0, 1, 2].map(|k| sum[k] + part[k]));
    // Without an area the fan's triangles have none, or cancel out.
    if n == 3 || whole == [0.0; 3] || (1..n - 1).all(|i| dot(spanned(i), whole) > 0.0) {
        (1..n - 1).for_each(|i| push([0, i, i + 1]));
        return Cut::Whole;
    }
    Ears::new(corners, whole).clip(push)
}

/// Twice the area of a triangle, along its normal. Differences and products of `f32` values are exact
/// in `f64` unless the coordinates' magnitudes lie more than 2^28 apart.
pub(crate) fn area([a, b, c]: [[f32; 3]; 3]) -> [f64; 3] {
    let edge = |p: [f32; 3]| [0, 1, 2].map(|k| f64::from(p[k]) - f64::from(a[k]));
    cross(edge(b), edge(c))
}

fn cross(u: [f64; 3], v: [f64; 3]) -> [f64; 3] {
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

fn dot(u: [f64; 3], v: [f64; 3]) -> f64 {
    u[0] * v[0] + u[1] * v[1] + u[2] * v[2]
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    // Scaled first, so that no square overflows or vanishes.
    let most = v.iter().fold(0.0, |most: f64, part| most.max(part.abs()));
    let v = v.map(|part| part / most);
    let length = dot(v, v).sqrt();
    v.map(|part| part / length)
}

type Point = [f64; 2];

/// Twice the signed area of a triangle, positive if it is counter-clockwise.
fn turn(a: Point, b: Point, c: Point) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// What lies in an ear and forbids to clip it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Test {
    /// A corner within it or on its border.
    Closed,
    /// A corner within it: for polygons that touch themselves.
    Open,
}

/// A polygon of which ears are clipped.
struct Ears {
    points: Vec<Point>,
    /// The neighbours of each corner that is left.
    before: Vec<u32>,
    after: Vec<u32>,
    is_left: Vec<bool>,
    left: usize,
    /// How far a turn can be off by rounding, over the length of its edges.
    rounding: f64,
    blockers: Blockers,
    /// Corners with another neighbour than before.
    changed: Vec<u32>,
    /// Corners that may be ears.
    waiting: VecDeque<u32>,
}

impl Ears {
    fn new(corners: &[[f32; 3]], whole: [f64; 3]) -> Self {
        let normal = unit(whole);
        let least = (0..3).min_by(|i, j| normal[*i].abs().total_cmp(&normal[*j].abs()));
        let mut axis = [0.0; 3];
        axis[least.unwrap_or(0)] = 1.0;
        let right = unit(cross(axis, normal));
        let up = cross(normal, right);
        let points: Vec<Point> = corners
            .iter()
            .map(|corner| {
                let way = [0, 1, 2].map(|k| f64::from(corner[k]) - f64::from(corners[0][k]));
                [dot(way, right), dot(way, up)]
            })
            .collect();
        let far = points.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
        let n = points.len() as u32;
        let mut ears = Ears {
            // Each coordinate is off by a few units in the last place of the farthest.
            rounding: far * 4.0 * f64::EPSILON,
            before: (0..n).map(|i| i.checked_sub(1).unwrap_or(n - 1)).collect(),
            after: (1..=n).map(|i| i % n).collect(),
            is_left: vec![true; points.len()],
            left: points.len(),
            blockers: Blockers::default(),
            changed: (0..n).collect(),
            waiting: VecDeque::new(),
            points,
        };
        ears.settle();
        ears.waiting = (0..n).filter(|i| ears.is_left[*i as usize]).collect();
        let not_convex = ears.waiting.iter().copied().filter(|i| ears.bend(*i) <= 0.0).collect();
        ears.blockers = Blockers::new(&ears.points, not_convex, corners.len());
        ears
    }

    fn ear(&self, i: u32) -> [u32; 3] {
        [self.before[i as usize], i, self.after[i as usize]]
    }

    fn places(&self, ear: [u32; 3]) -> [Point; 3] {
        ear.map(|i| self.points[i as usize])
    }

    /// Positive at a convex corner, negative at a reflex one, 0 on a straight line.
    fn bend(&self, i: u32) -> f64 {
        let [a, b, c] = self.places(self.ear(i));
        let bend = turn(a, b, c);
        let length = |p: Point, q: Point| (p[0] - q[0]).abs() + (p[1] - q[1]).abs();
        if bend.abs() <= self.rounding * (length(a, b) + length(b, c)) { 0.0 } else { bend }
    }

    /// Whether the way turns back at a corner, or does not go on: corners at one place.
    fn is_spike(&self, i: u32) -> bool {
        let [a, b, c] = self.places(self.ear(i));
        (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]) <= 0.0
    }

    /// Takes a corner out.
    fn drop(&mut self, i: u32) {
        self.unlink(i);
        self.settle();
    }

    fn unlink(&mut self, i: u32) {
        let [a, _, c] = self.ear(i);
        self.after[a as usize] = c;
        self.before[c as usize] = a;
        self.is_left[i as usize] = false;
        self.left -= 1;
        self.blockers.remove(i);
        self.changed.extend([c, a]);
    }

    /// Looks once more at corners that changed. Where the way turns back there is nothing to cover.
    fn settle(&mut self) {
        while let Some(i) = self.changed.pop() {
            if !self.is_left[i as usize] {
                continue;
            }
            let bend = self.bend(i);
            if bend == 0.0 && self.left > 3 && self.is_spike(i) {
                self.unlink(i);
                continue;
            }
            if bend > 0.0 {
                self.blockers.remove(i);
            }
            self.waiting.push_back(i);
        }
    }

    fn clip(mut self, push: &mut dyn FnMut([usize; 3])) -> Cut {
        let mut cut = Cut::Whole;
        let mut test = Test::Closed;
        let mut push = |ear: [u32; 3]| push(ear.map(|i| i as usize));
        let mut at = 0_u32;
        while self.left > 3 {
            if let Some(i) = self.waiting.pop_front() {
                if !self.is_left[i as usize] {
                    continue;
                }
                let ear = self.ear(i);
                if self.bend(i) > 0.0 && !self.blockers.within(&self.points, self.places(ear), test)
                {
                    push(ear);
                    self.drop(i);
                }
            } else if test == Test::Closed {
                test = Test::Open;
                self.waiting = (0..self.points.len() as u32).collect();
            } else {
                // Every polygon whose edges do not cross has an ear.
                cut = Cut::Crossed;
                let n = self.points.len() as u32;
                while at < n && !(self.is_left[at as usize] && self.bend(at) > 0.0) {
                    at += 1;
                }
                if at == n {
                    return cut;
                }
                push(self.ear(at));
                self.drop(at);
            }
        }
        if let Some(last) = self.is_left.iter().position(|left| *left).map(|i| i as u32)
            && self.left == 3
            && self.bend(last) > 0.0
        {
            push(self.ear(last));
        }
        cut
    }
}

/// Corners that are not convex, which alone can lie in an ear, in a k-d tree. None is added: a corner
/// that is convex stays so while ears are clipped.
#[derive(Default)]
struct Blockers {
    nodes: Vec<Node>,
    /// Corners in the order of the leaves.
    order: Vec<u32>,
    /// The place in `order` of each corner; `NONE` for those that are not, or no longer, in it.
    place: Vec<u32>,
    /// How many nodes may still be visited.
    budget: u64,
}

struct Node {
    low: Point,
    high: Point,
    /// Its part of `order`.
    range: [u32; 2],
    /// How many of these are left.
    left: u32,
    /// Its first child; the other one follows it. A leaf has 0.
    children: u32,
}

const NONE: u32 = u32::MAX;

/// Corners in a leaf.
const LEAF: u32 = 8;

/// Nodes that may be visited for each corner. Polygons that mean something take about twenty.
const VISITS: u64 = 300;

impl Blockers {
    fn new(points: &[Point], order: Vec<u32>, corners: usize) -> Self {
        let budget = VISITS * corners as u64;
        let mut blockers = Blockers { nodes: Vec::new(), order, place: Vec::new(), budget };
        let count = blockers.order.len() as u32;
        blockers.nodes.push(Node::new(points, &blockers.order, [0, count]));
        let mut at = 0;
        while let Some(node) = blockers.nodes.get_mut(at) {
            let [first, end] = node.range;
            at += 1;
            if end - first <= LEAF {
                continue;
            }
            let axis = usize::from(node.high[1] - node.low[1] > node.high[0] - node.low[0]);
            let middle = first + (end - first) / 2;
            let part = &mut blockers.order[first as usize..end as usize];
            part.select_nth_unstable_by((middle - first) as usize, |i, j| {
                points[*i as usize][axis].total_cmp(&points[*j as usize][axis])
            });
            blockers.nodes[at - 1].children = blockers.nodes.len() as u32;
            for range in [[first, middle], [middle, end]] {
                blockers.nodes.push(Node::new(points, &blockers.order, range));
            }
        }
        blockers.place = vec![NONE; points.len()];
        for (place, corner) in blockers.order.iter().enumerate() {
            blockers.place[*corner as usize] = place as u32;
        }
        blockers
    }

    fn remove(&mut self, corner: u32) {
        let Some(place) = self.place.get_mut(corner as usize) else { return };
        let place = std::mem::replace(place, NONE);
        if place == NONE {
            return;
        }
        let mut at = 0;
        loop {
            let node = &mut self.nodes[at];
            node.left -= 1;
            if node.children == 0 {
                return;
            }
            at = node.children as usize;
            at += usize::from(place >= self.nodes[at + 1].range[0]);
        }
    }

    /// Whether one lies in a counter-clockwise triangle, beside those at its corners.
    fn within(&mut self, points: &[Point], triangle: [Point; 3], test: Test) -> bool {
        let [a, b, c] = triangle;
        let low = [0, 1].map(|k| a[k].min(b[k]).min(c[k]));
        let high = [0, 1].map(|k| a[k].max(b[k]).max(c[k]));
        let sides = |p: Point| [turn(a, b, p), turn(b, c, p), turn(c, a, p)];
        let mut stack = vec![0_u32];
        while let Some(at) = stack.pop() {
            let node = &self.nodes[at as usize];
            let apart = (0..2).any(|k| node.low[k] > high[k] || node.high[k] < low[k]);
            if node.left == 0 || apart {
                continue;
            }
            if self.budget == 0 {
                return false;
            }
            self.budget -= 1;
            if node.children != 0 {
                let [l, h] = [node.low, node.high];
                let box_sides = [l, [h[0], l[1]], h, [l[0], h[1]]].map(sides);
                if box_sides.iter().flatten().all(|side| *side > 0.0) {
                    return true;
                }
                // Beyond one side as a whole.
                if (0..3).any(|k| box_sides.iter().all(|sides| sides[k] < 0.0)) {
                    continue;
                }
                stack.extend([node.children, node.children + 1]);
                continue;
            }
            let [first, end] = node.range;
            for corner in &self.order[first as usize..end as usize] {
                let p = points[*corner as usize];
                let is_left = self.place[*corner as usize] != NONE;
                let within = |side: f64| side > 0.0 || side == 0.0 && test == Test::Closed;
                if is_left && !triangle.contains(&p) && sides(p).into_iter().all(within) {
                    return true;
                }
            }
        }
        false
    }
}

impl Node {
    fn new(points: &[Point], order: &[u32], range: [u32; 2]) -> Self {
        let [first, end] = range;
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for corner in &order[first as usize..end as usize] {
            let p = points[*corner as usize];
            low = [0, 1].map(|k| low[k].min(p[k]));
            high = [0, 1].map(|k| high[k].max(p[k]));
        }
        Node { low, high, range, left: end - first, children: 0 }
    }
}

#[cfg(test)]
mod tests;
