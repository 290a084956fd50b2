//! Textures that multiply a mesh file's material, as its maker gave them.

use crate::texture::{TexelFilter, Texture};
use std::sync::Arc;

/// What lies beyond an edge of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Wrap {
    /// The texture again.
    #[default]
    Repeat,
    /// The texture again, every other time mirrored.
    Mirror,
    /// Its last texels.
    Clamp,
}

/// Which texture coordinates of a mesh a map takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum UvSet {
    /// [`crate::MeshData::uvs`].
    #[default]
    First,
    /// [`crate::MeshData::second_uvs`].
    Second,
}

/// A texture, and how it lies on a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// The texture, shared between all that name the same one. Linear; of data (metalness) the
    /// samples as they are stored.
    pub image: Arc<Texture>,
    /// What lies between the middles of texels.
    pub filter: TexelFilter,
    /// What lies beyond the edges along u and v.
    pub wrap: [Wrap; 2],
    /// The texture coordinates that it takes.
    pub set: UvSet,
    /// The place in the texture, as rows of an affine function of u and v (v up).
    pub place: [[f64; 3]; 2],
}

impl Map {
    /// A texture that lies as the first texture coordinates say.
    pub fn new(image: Arc<Texture>) -> Map {
        Map {
            image,
            filter: TexelFilter::default(),
            wrap: [Wrap::default(); 2],
            set: UvSet::default(),
            place: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        }
    }

    /// Whether two are the same texture in the same place, so that one look serves for both.
    pub fn is_same(&self, other: &Map) -> bool {
        let lies = |m: &Map| (m.filter, m.wrap, m.set, m.place);
        Arc::ptr_eq(&self.image, &other.image) && lies(self) == lies(other)
    }
}

/// How the mirrored share of light varies from point to point.
#[derive(Clone, Debug, PartialEq, Default)]
pub enum Mirrored {
    /// It does not: diffuse and specular are as the material and its maps give them.
    #[default]
    AsGiven,
    /// Of what diffuse and specular are multiplied with, the share `s = metalness B (1 - roughness
    /// G)` counts for specular and the rest for diffuse, with the map's green G and blue B.
    Metal {
        /// Roughness in green, metalness in blue; not colours.
        map: Map,
        /// The factor of blue.
        metalness: f32,
        /// The factor of green.
        roughness: f32,
    },
    /// Diffuse is multiplied with 1 less the greatest of the specular map's three numbers times
    /// these.
    Specular([f32; 3]),
}

/// What multiplies a material's colours from point to point.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Maps {
    /// Multiplies ambient.
    pub ambient: Option<Map>,
    /// Multiplies diffuse.
    pub diffuse: Option<Map>,
    /// Multiplies specular.
    pub specular: Option<Map>,
    /// How the mirrored share varies.
    pub mirrored: Mirrored,
    /// Whether [`crate::MeshData::colours`] multiply ambient, diffuse and specular.
    pub by_vertex: [bool; 3],
}

impl Maps {
    /// Shared, or `None` if nothing varies from point to point.
    pub fn shared(self) -> Option<Arc<Maps>> {
        (self != Maps::default()).then(|| Arc::new(self))
    }

    /// The maps that there are.
    pub fn all(&self) -> impl Iterator<Item = &Map> {
        let metal = match &self.mirrored {
            Mirrored::Metal { map, .. } => Some(map),
            _ => None,
        };
        let colours = [&self.ambient, &self.diffuse, &self.specular];
        colours.into_iter().flatten().chain(metal)
    }
}

/// Of an entity with a [`crate::Material`] that stands for one of a mesh file: what multiplies it.
#[derive(Clone, Debug, PartialEq)]
pub struct Mapped(pub Arc<Maps>);
