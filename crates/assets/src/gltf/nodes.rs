//! Which meshes the scene of a file shows, and where: nodes, instances and skins.

use super::Trouble;
use super::container::File;
use super::json::{Instancing, Primitive};
use super::matrix::{IDENTITY, Matrix, columns, placed, times};

/// A mesh that a node shows.
pub(super) struct Shown {
    pub node: usize,
    pub mesh: usize,
    /// The transforms of the node and of those above it.
    pub matrix: Matrix,
}

/// The way that a primitive's vertices are moved by.
pub(super) enum Ways {
    /// All by the same.
    One(Matrix),
    /// By those of joints, weighted; what has no weights by the node's.
    Joints(Vec<Matrix>, Matrix),
}

/// The most triangles of a scene, where a file has not the bytes for more: three indices each.
const MOST_TRIANGLES: usize = 1 << 23;

/// The most triangles of any scene.
const MOST_OF_ALL: usize = 1 << 27;

impl File {
    /// The meshes of the default scene (else of the first, else of all nodes), in their order.
    pub fn shown(&self) -> Result<Vec<Shown>, Trouble> {
        let nodes = &self.root.nodes;
        let scene = self.root.scene.and_then(|scene| self.root.scenes.get(scene));
        let mut waiting: Vec<(usize, Matrix)> = match scene.or(self.root.scenes.first()) {
            Some(scene) => scene.nodes.iter().map(|node| (*node, IDENTITY)).collect(),
            None => self.roots().map(|node| (node, IDENTITY)).collect(),
        };
        waiting.reverse();
        let mut seen = vec![false; nodes.len()];
        let mut all = Vec::new();
        while let Some((index, above)) = waiting.pop() {
            let node = nodes
                .get(index)
                .ok_or_else(|| format!("node {index} is asked for, there are {}", nodes.len()))?;
            if std::mem::replace(&mut seen[index], true) {
                return Err(format!("node {index} has two parents, or is its own").into());
            }
            if node.extensions.visibility.as_ref().is_some_and(|v| !v.visible) {
                continue;
            }
            let matrix = times(&above, &node.own());
            if let Some(mesh) = node.mesh {
                if mesh >= self.root.meshes.len() {
                    let there = self.root.meshes.len();
                    return Err(format!("mesh {mesh} is asked for, there are {there}").into());
                }
                all.push(Shown { node: index, mesh, matrix });
            }
            waiting.extend(node.children.iter().rev().map(|child| (*child, matrix)));
        }
        Ok(all)
    }

    /// Nodes that are no node's child.
    fn roots(&self) -> impl Iterator<Item = usize> {
        let parents = self.parents();
        (0..parents.len()).filter(move |node| parents[*node].is_none())
    }

    fn parents(&self) -> Vec<Option<usize>> {
        let mut parents = vec![None; self.root.nodes.len()];
        for (parent, node) in self.root.nodes.iter().enumerate() {
            for child in &node.children {
                if let Some(slot) = parents.get_mut(*child) {
                    *slot = Some(parent);
                }
            }
        }
        parents
    }

    /// How many triangles the shown meshes have together, from counts alone; an error if they are too
    /// many to build.
    pub fn check_size(&self, shown: &[Shown]) -> Result<(), Trouble> {
        let most = MOST_TRIANGLES.max(self.bytes() / 3).min(MOST_OF_ALL);
        let mut all = 0_usize;
        for shown in shown {
            let primitives = &self.root.meshes[shown.mesh].primitives;
            let own: usize =
                primitives.iter().map(|p| self.triangles(p)).fold(0, usize::saturating_add);
            let instancing = &self.root.nodes[shown.node].extensions.instancing;
            let times = instancing.as_ref().map_or(1, |i| self.instance_count(i));
            all = all.saturating_add(own.saturating_mul(times));
        }
        if all > most {
            let message = format!(
                "its nodes show {all} triangles, and {most} are the most for a file of this size; \
                 show fewer, or place the mesh with `instance`"
            );
            return Err(message.into());
        }
        Ok(())
    }

    /// How many triangles a primitive has, from the counts of its accessors.
    fn triangles(&self, primitive: &Primitive) -> usize {
        let corners = match primitive.indices {
            Some(indices) => self.count(Some(indices)),
            None => self.count(primitive.attributes.position),
        };
        match primitive.mode.unwrap_or(4) {
            0..=3 => 0,
            5 | 6 => corners.saturating_sub(2),
            _ => corners / 3,
        }
    }

    fn instance_count(&self, instancing: &Instancing) -> usize {
        let attributes = &instancing.attributes;
        let given = [attributes.translation, attributes.rotation, attributes.scale];
        given.into_iter().flatten().map(|a| self.count(Some(a))).min().unwrap_or(1)
    }

    /// Where a shown mesh stands: once, or at each instance of its node.
    pub fn ways(&self, shown: &Shown) -> Result<Vec<Ways>, Trouble> {
        let node = &self.root.nodes[shown.node];
        if let Some(skin) = node.skin {
            return Ok(vec![Ways::Joints(self.joints(skin)?, shown.matrix)]);
        }
        let Some(instancing) = &node.extensions.instancing else {
            return Ok(vec![Ways::One(shown.matrix)]);
        };
        let given = &instancing.attributes;
        let read = |accessor: Option<usize>, name: &str, kind: &str| {
            accessor.map(|a| self.elements(a, name, &[kind])).transpose()
        };
        let translations = read(given.translation, "TRANSLATION", "VEC3")?;
        let rotations = read(given.rotation, "ROTATION", "VEC4")?;
        let scales = read(given.scale, "SCALE", "VEC3")?;
        let way = |i: usize| {
            let own = placed(
                translations.as_ref().map_or([0.0; 3], |t| t.get(i)),
                rotations.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |r| r.get(i)),
                scales.as_ref().map_or([1.0; 3], |s| s.get(i)),
            );
            Ways::One(times(&shown.matrix, &own))
        };
        Ok((0..self.instance_count(instancing)).map(way).collect())
    }

    /// What the joints of a skin do to vertices in its rest pose. The transform of the node that
    /// shows the mesh counts for nothing (3.7.3.3).
    fn joints(&self, skin: usize) -> Result<Vec<Matrix>, Trouble> {
        let skins = &self.root.skins;
        let skin = skins
            .get(skin)
            .ok_or_else(|| format!("skin {skin} is asked for, there are {}", skins.len()))?;
        let inverse = skin.inverse_bind_matrices;
        let inverse = inverse.map(|a| self.elements(a, "inverseBindMatrices", &["MAT4"]));
        let inverse = inverse.transpose()?;
        let parents = self.parents();
        let joint = |(i, joint): (usize, &usize)| -> Result<Matrix, Trouble> {
            let world = self.world(*joint, &parents)?;
            let bind = match &inverse {
                Some(inverse) if i < inverse.count => columns(&inverse.get(i)),
                _ => IDENTITY,
            };
            Ok(times(&world, &bind))
        };
        skin.joints.iter().enumerate().map(joint).collect()
    }

    /// The transform of a node and of those above it.
    fn world(&self, node: usize, parents: &[Option<usize>]) -> Result<Matrix, Trouble> {
        let mut way = IDENTITY;
        let mut above = Some(node);
        // A way up that is longer than there are nodes is a circle.
        for _ in 0..=parents.len() {
            let Some(index) = above else { return Ok(way) };
            let node =
                self.root.nodes.get(index).ok_or_else(|| {
                    format!("node {index} is asked for, there are {}", parents.len())
                })?;
            way = times(&node.own(), &way);
            above = parents[index];
        }
        Err(format!("node {node} is above itself").into())
    }
}
