//! Colours of reflection, one row a material.

use crate::ids::MaterialId;
use reflet_scene::{Key, Material};

/// A linear colour: red, green, blue.
pub type Rgb = [f32; 3];

/// Materials as rows of nine numbers; row 0 is [`Material::GREY_MATT`], which surfaces without a
/// material wear. A row is read whole at each look-up, so rows are kept together.
#[derive(Clone, Debug, Default)]
pub struct Materials {
    /// The rows.
    pub rows: Vec<MaterialRow>,
    /// Whose row each is; none of row 0.
    pub key: Vec<Option<Key>>,
}

/// The three reflectivities of a material.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct MaterialRow {
    /// Light given off.
    pub ambient: Rgb,
    /// Share scattered.
    pub diffuse: Rgb,
    /// Share mirrored.
    pub specular: Rgb,
}

impl MaterialRow {
    /// The bits of all nine numbers.
    pub fn bits(&self) -> [u32; 9] {
        let mut out = [0; 9];
        for (o, x) in
            out.iter_mut().zip(self.ambient.iter().chain(&self.diffuse).chain(&self.specular))
        {
            *o = x.to_bits();
        }
        out
    }

    /// Whether a ray is cast from surfaces that wear it.
    #[inline]
    pub fn is_specular(&self) -> bool {
        self.specular.iter().any(|s| *s != 0.0)
    }

    /// Which of its specular red, green and blue are other than 0: what a texture leaves of them
    /// decides where rays are cast.
    pub(crate) fn specular_channels(&self) -> [bool; 3] {
        self.specular.map(|s| s != 0.0)
    }
}

impl From<Material> for MaterialRow {
    fn from(m: Material) -> Self {
        Self {
            ambient: m.ambient.to_array().map(|x| x as f32),
            diffuse: m.diffuse.to_array().map(|x| x as f32),
            specular: m.specular.to_array().map(|x| x as f32),
        }
    }
}

impl Materials {
    /// The row of surfaces without a material.
    pub const GREY_MATT: MaterialId = MaterialId(0);

    pub(crate) fn push(&mut self, key: Option<Key>, material: Material) {
        self.rows.push(material.into());
        self.key.push(key);
    }

    pub(crate) fn truncate(&mut self, n: usize) {
        self.rows.truncate(n);
        self.key.truncate(n);
    }

    /// The row of `id`.
    #[inline]
    pub fn get(&self, id: MaterialId) -> &MaterialRow {
        &self.rows[id.index()]
    }
}
