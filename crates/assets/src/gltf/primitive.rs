//! A primitive's vertices and triangles, put where a node shows them.

use super::Trouble;
use super::accessor::Elements;
use super::container::File;
use super::json::{Attributes, Primitive};
use super::matrix::{IDENTITY, Matrix, cofactors, mirrors, moved};
use super::nodes::Ways;
use crate::finish::unit;
use reflet_scene::MeshData;

/// A primitive, as far as it is the same wherever it is shown.
pub(super) struct Vertices<'a> {
    positions: Elements<'a>,
    normals: Option<Elements<'a>>,
    uvs: [Option<Elements<'a>>; 2],
    colours: Option<Elements<'a>>,
    skin: Vec<[Elements<'a>; 2]>,
    /// Weights of morph targets, with positions and normals that they add.
    morphs: Vec<(f64, [Option<Elements<'a>>; 2])>,
    /// The elements that triangles have corners at, ascending.
    used: Vec<u32>,
    /// Corners, as places in `used`.
    triangles: Vec<[u32; 3]>,
    /// Triangles left out because a corner is not there.
    pub broken: u64,
}

/// Whether a primitive is of points or lines.
pub(super) fn is_passed_over(primitive: &Primitive) -> bool {
    matches!(primitive.mode, Some(0..=3))
}

impl File {
    /// Reads a primitive; `weights` are those of its morph targets.
    pub fn vertices<'a>(
        &'a self,
        primitive: &Primitive,
        weights: &[f64],
    ) -> Result<Vertices<'a>, Trouble> {
        let Attributes { position, normal, texcoord_0, texcoord_1, color_0, .. } =
            primitive.attributes;
        let position = position.ok_or("it has no positions")?;
        let positions = self.elements(position, "POSITION", &["VEC3"])?;
        let count = positions.count;
        let read = |accessor: Option<usize>,
                    name: &str,
                    kinds: &[&str]|
         -> Result<Option<Elements<'a>>, Trouble> {
            let Some(accessor) = accessor else { return Ok(None) };
            let elements = self.elements(accessor, name, kinds)?;
            if elements.count != count {
                let other = elements.count;
                return Err(format!("{name} has {other} elements, and POSITION {count}").into());
            }
            Ok(Some(elements))
        };
        let mut skin = Vec::new();
        let given = &primitive.attributes;
        for (joints, weights) in
            [(given.joints_0, given.weights_0), (given.joints_1, given.weights_1)]
        {
            let joints = read(joints, "JOINTS", &["VEC4"])?;
            let weights = read(weights, "WEIGHTS", &["VEC4"])?;
            skin.extend(joints.zip(weights).map(|(joints, weights)| [joints, weights]));
        }
        let mut morphs = Vec::new();
        for (target, weight) in primitive.targets.iter().zip(weights) {
            if *weight != 0.0 {
                let positions = read(target.position, "POSITION of a target", &["VEC3"])?;
                let normals = read(target.normal, "NORMAL of a target", &["VEC3"])?;
                morphs.push((*weight, [positions, normals]));
            }
        }
        let uvs = [
            read(texcoord_0, "TEXCOORD_0", &["VEC2"])?,
            read(texcoord_1, "TEXCOORD_1", &["VEC2"])?,
        ];
        let (triangles, broken) = self.triangles_of(primitive, count)?;
        let mut vertices = Vertices {
            normals: read(normal, "NORMAL", &["VEC3"])?,
            uvs,
            colours: read(color_0, "COLOR_0", &["VEC3", "VEC4"])?.filter(Elements::is_real),
            positions,
            skin,
            morphs,
            used: Vec::new(),
            triangles,
            broken,
        };
        vertices.number(count);
        Ok(vertices)
    }

    /// The triangles that a primitive's indices make, as elements of its accessors, and how many have
    /// a corner that is not there.
    fn triangles_of(
        &self,
        primitive: &Primitive,
        count: usize,
    ) -> Result<(Vec<[u32; 3]>, u64), Trouble> {
        let indices: Vec<u32> = match primitive.indices {
            None => (0..count as u32).collect(),
            Some(accessor) => {
                let elements = self.elements(accessor, "indices", &["SCALAR"])?;
                if !elements.is_whole() {
                    return Err("its indices are of numbers that are not read".into());
                }
                (0..elements.count).map(|i| elements.index(i)).collect()
            }
        };
        let mut all: Vec<[u32; 3]> = match primitive.mode {
            Some(5) => {
                let turn = |(i, w): (usize, &[u32])| match i % 2 {
                    0 => [w[0], w[1], w[2]],
                    _ => [w[1], w[0], w[2]],
                };
                indices.windows(3).enumerate().map(turn).collect()
            }
            Some(6) => {
                let first = indices.first().copied().unwrap_or(0);
                let rest = indices.get(1..).unwrap_or_default();
                rest.windows(2).map(|w| [first, w[0], w[1]]).collect()
            }
            None | Some(4) => indices.as_chunks::<3>().0.to_vec(),
            Some(mode) => return Err(format!("{mode} is no mode of primitives").into()),
        };
        let before = all.len();
        all.retain(|corners| corners.iter().all(|corner| (*corner as usize) < count));
        let broken = before - all.len();
        Ok((all, broken as u64))
    }
}

impl Vertices<'_> {
    /// Finds the elements that are used, of `count`, and lets triangles be of their places.
    fn number(&mut self, count: usize) {
        let corners = self.triangles.as_flattened();
        // Many primitives may take few elements each of very many.
        if count <= 8 * corners.len() {
            let mut is_used = vec![false; count];
            corners.iter().for_each(|corner| is_used[*corner as usize] = true);
            let used = is_used.iter().enumerate().filter(|(_, used)| **used);
            self.used = used.map(|(i, _)| i as u32).collect();
        } else {
            self.used = corners.to_vec();
            self.used.sort_unstable();
            self.used.dedup();
        }
        if self.used.len() == count {
            return;
        }
        let used = &self.used;
        for corner in self.triangles.as_flattened_mut() {
            *corner = used.partition_point(|element| element < corner) as u32;
        }
    }

    /// Whether it has texture coordinates of a set.
    pub fn has_uvs(&self, set: usize) -> bool {
        self.uvs[set].is_some()
    }

    /// Appends it to a mesh, moved; tells how many triangles came and how many were left out because
    /// a corner is not finite.
    pub fn append(&self, ways: &Ways, data: &mut MeshData) -> Result<[u64; 2], Trouble> {
        let base = data.positions.len();
        let mut is_far = vec![false; self.used.len()];
        self.fill(data, base);
        let one = match ways {
            Ways::One(matrix) => Some(matrix),
            Ways::Joints(_, node) if self.skin.is_empty() => Some(node),
            Ways::Joints(..) => None,
        };
        let one = one.map(|matrix| (*matrix, cofactors(matrix)));
        let mirrored = one.as_ref().is_some_and(|(matrix, turn)| mirrors(matrix, turn));
        let sign = if mirrored { -1.0 } else { 1.0 };
        for (row, element) in self.used.iter().map(|element| *element as usize).enumerate() {
            let mut position: [f64; 3] = self.positions.get(element);
            let mut normal: Option<[f64; 3]> = self.normals.as_ref().map(|n| n.get(element));
            for (weight, [positions, normals]) in &self.morphs {
                add(&mut position, *weight, positions, element);
                if let Some(normal) = &mut normal {
                    add(normal, *weight, normals, element);
                }
            }
            let (matrix, turn) = match (one, ways) {
                (None, Ways::Joints(joints, _)) => {
                    let matrix = self.blend(joints, element);
                    (matrix, cofactors(&matrix))
                }
                (one, _) => one.unwrap_or_else(|| (IDENTITY, cofactors(&IDENTITY))),
            };
            let place = moved(&matrix, position).map(|x| x as f32);
            if place.iter().all(|x| x.is_finite()) {
                data.positions.push(place);
            } else {
                is_far[row] = true;
                data.positions.push([0.0; 3]);
            }
            if let Some(n) = normal {
                let turned =
                    [0, 1, 2].map(|r| sign * (0..3).map(|k| turn[k][r] * n[k]).sum::<f64>());
                data.normals[base + row] = unit(turned).unwrap_or_default();
            }
        }
        let mut far = 0;
        for [a, b, c] in &self.triangles {
            if [a, b, c].into_iter().any(|corner| is_far[*corner as usize]) {
                far += 1;
                continue;
            }
            let triangle = if mirrored { [a, c, b] } else { [a, b, c] };
            data.triangles.push(triangle.map(|corner| corner + base as u32));
        }
        Ok([self.triangles.len() as u64 - far, far])
    }

    /// Appends what no place changes: columns that this primitive lacks and others have get what
    /// stands for nothing.
    fn fill(&self, data: &mut MeshData, base: usize) {
        let rows = base + self.used.len();
        let finite = |x: f64| if (x as f32).is_finite() { x as f32 } else { 0.0 };
        if self.normals.is_some() || !data.normals.is_empty() {
            data.normals.resize(rows, [0.0; 3]);
        }
        for (column, own) in [&mut data.uvs, &mut data.second_uvs].into_iter().zip(&self.uvs) {
            if own.is_some() || !column.is_empty() {
                column.resize(rows, [0.0; 2]);
            }
            let Some(own) = own else { continue };
            for (to, element) in column[base..].iter_mut().zip(&self.used) {
                // In glTF v goes down.
                let [u, v] = own.get(*element as usize);
                *to = [finite(u), finite(f64::from(1.0 - v as f32))];
            }
        }
        if self.colours.is_some() || !data.colours.is_empty() {
            data.colours.resize(rows, [1.0; 3]);
        }
        if let Some(own) = &self.colours {
            for (to, element) in data.colours[base..].iter_mut().zip(&self.used) {
                *to = own.get(*element as usize).map(finite);
            }
        }
    }

    /// The mean of a vertex's joints by their weights.
    fn blend(&self, joints: &[Matrix], element: usize) -> Matrix {
        let (mut sum, mut all) = ([[0.0; 4]; 4], 0.0);
        for [numbers, weights] in &self.skin {
            let numbers: [f64; 4] = numbers.get(element);
            let weights: [f64; 4] = weights.get(element);
            for (number, weight) in numbers.into_iter().zip(weights) {
                let Some(joint) = joints.get(number as usize).filter(|_| weight != 0.0) else {
                    continue;
                };
                all += weight;
                for (sum, x) in sum.as_flattened_mut().iter_mut().zip(joint.as_flattened()) {
                    *sum += weight * x;
                }
            }
        }
        if all == 0.0 {
            // No joint moves it.
            return joints.first().copied().unwrap_or(IDENTITY);
        }
        sum.map(|column| column.map(|x| x / all))
    }
}

fn add(to: &mut [f64; 3], weight: f64, from: &Option<Elements<'_>>, element: usize) {
    if let Some(from) = from {
        for (to, x) in to.iter_mut().zip(from.get::<3>(element)) {
            *to += weight * x;
        }
    }
}
