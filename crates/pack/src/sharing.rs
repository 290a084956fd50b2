//! Which meshes are stored triangle by triangle, and which as copies.

use crate::copies::SharedMesh;
use reflet_scene::MeshData;
use std::collections::HashMap;
use std::sync::Arc;

/// When the triangles of a mesh that is in the scene already are not stored once more. No picture
/// depends on it: a copy's triangles have the same bits, but rays look for them longer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sharing {
    /// While a scene has few triangles all are stored, since they cost little then.
    Auto,
    /// Never: all triangles are stored.
    Never,
    /// Always.
    Always,
}

/// Stored triangles cost about 200 bytes each; so many are a matter of 50 MB.
const FEW: usize = 1 << 18;

/// The meshes that a scene has so far, each by where its triangles are.
#[derive(Debug)]
pub(crate) struct Meshes {
    sharing: Sharing,
    /// By address: the first surface, and what copies of it share.
    seen: HashMap<usize, (usize, Option<Arc<SharedMesh>>)>,
}

impl Meshes {
    pub fn new(sharing: Sharing) -> Meshes {
        Meshes { sharing, seen: HashMap::new() }
    }

    /// What surface number `surface` shares with earlier ones, if it is to be a copy. So many
    /// triangles are `stored` by now.
    pub fn shared(
        &mut self,
        surface: usize,
        data: &Arc<MeshData>,
        stored: usize,
    ) -> Option<Arc<SharedMesh>> {
        let is_many = match self.sharing {
            Sharing::Auto => stored + data.triangles.len() > FEW,
            Sharing::Never => false,
            Sharing::Always => true,
        };
        let address = Arc::as_ptr(data) as usize;
        let (first, mesh) = self.seen.entry(address).or_insert((surface, None));
        let is_more_than_one = data.triangles.len() > 1;
        if *first == surface || !is_many || !is_more_than_one {
            return None;
        }
        Some(mesh.get_or_insert_with(|| Arc::new(SharedMesh::new(data.clone()))).clone())
    }

    /// Forgets surfaces from `surfaces` on.
    pub fn truncate(&mut self, surfaces: usize) {
        self.seen.retain(|_, (first, _)| *first < surfaces);
    }

    /// Forgets all, but how to share.
    pub fn clear(&mut self) {
        self.seen.clear();
    }
}
