//! Texture coordinates: what a mesh wears may ask for them, and its file may have none.

use crate::state::State;
use reflet_scene::program::{Coordinate, Op, Program};
use reflet_scene::{Key, Mapped, Mesh, Shader, Surface, Textured};
use std::sync::Arc;

impl State {
    /// Whether a mesh has the texture coordinates that what it wears asks for; the key at fault and
    /// why not. Any other surface has its own.
    pub fn check_uvs(&self, surface: Key) -> Result<(), (&'static str, String)> {
        let mesh = self.scene.get::<Mesh>(surface);
        let Some(mesh) = mesh.filter(|mesh| mesh.data.uvs.is_empty()) else { return Ok(()) };
        let whole = self.scene.get::<Surface>(surface).and_then(|surface| surface.material);
        let parts = mesh.worn.iter().map(|worn| (worn.material, "materials"));
        let worn: Vec<(Key, &str)> = match whole {
            Some(material) => vec![(material, "material")],
            None => parts.collect(),
        };
        for (material, key) in worn {
            if let Some(what) = self.asks_for_uvs(material) {
                let file = self.file_of(Arc::as_ptr(&mesh.data) as usize);
                return Err((
                    key,
                    format!(
                        "`{file}` has no texture coordinates, which {what} asks for: export the mesh with them (not in STL), or give it a material, a checker or stripes"
                    ),
                ));
            }
        }
        Ok(())
    }

    /// What about a material asks for texture coordinates.
    fn asks_for_uvs(&self, material: Key) -> Option<&'static str> {
        let scene = &self.scene;
        if scene.has::<Textured>(material) {
            return Some("`textured`");
        }
        if let Some(Mapped(maps)) = scene.get::<Mapped>(material) {
            return maps.all().next().map(|_| "a material with a texture");
        }
        let shader = scene.get::<Shader>(material)?;
        let reads = |program: &Arc<Program>| {
            let is_uv = |op: &Op| matches!(op, Op::Coordinate(Coordinate::U | Coordinate::V));
            program.ops.iter().any(is_uv)
        };
        let programs = [&shader.ambient, &shader.diffuse, &shader.specular];
        programs.into_iter().flatten().any(reads).then_some("`p.u` or `p.v` of its shader")
    }
}
