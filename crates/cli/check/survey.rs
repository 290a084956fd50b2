//! How much of what a scene holds.

use super::shapes::{Shapes, placed, point};
use reflet_pack::{Aabb, Overrides, Packer};
use reflet_scene::{
    Checker, DVec3, Instance, Material, PointLight, Projector, Scene, Shader, Spotlight, Stripes,
    Sun, Textured,
};
use std::fmt;

/// Counts by kind, and the box around everything that has an end.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Survey {
    /// Visible spheres.
    pub spheres: u64,
    /// Visible planes.
    pub planes: u64,
    /// Visible quads.
    pub quads: u64,
    /// Visible triangles, those of meshes apart.
    pub triangles: u64,
    /// Visible meshes.
    pub meshes: u64,
    /// Triangles of visible meshes.
    pub mesh_triangles: u64,
    /// Surfaces that are not visible.
    pub hidden: u64,
    /// Visible curved shapes, boxes, discs, and whatever a group moves.
    pub others: u64,
    /// Materials.
    pub materials: u64,
    /// Materials that mirror: a specular value is not 0.
    pub mirrors: u64,
    /// Checkers.
    pub checkers: u64,
    /// Stripes.
    pub stripes: u64,
    /// Textures.
    pub textures: u64,
    /// Shaders.
    pub shaders: u64,
    /// Instances.
    pub instances: u64,
    /// Point lights.
    pub point_lights: u64,
    /// Spotlights.
    pub spotlights: u64,
    /// Suns.
    pub suns: u64,
    /// Projectors.
    pub projectors: u64,
    /// The least and the greatest corner of all visible surfaces but planes.
    pub bounds: Option<(DVec3, DVec3)>,
}

impl Survey {
    /// What the scene holds as it is now.
    pub fn of(scene: &Scene, shapes: &Shapes) -> Self {
        let mut survey = Self {
            spheres: shapes.spheres.len() as u64,
            planes: shapes.planes.len() as u64,
            quads: shapes.quads.len() as u64,
            triangles: shapes.triangles.len() as u64,
            meshes: shapes.meshes.len() as u64,
            mesh_triangles: shapes.meshes.iter().map(|(_, m)| m.data.triangles.len() as u64).sum(),
            others: shapes.others,
            hidden: shapes.hidden,
            ..Self::default()
        };
        for key in scene.keys() {
            if let Some(material) = scene.get::<Material>(key) {
                survey.materials += 1;
                survey.mirrors += u64::from(material.specular != DVec3::ZERO);
            }
            survey.checkers += u64::from(scene.has::<Checker>(key));
            survey.stripes += u64::from(scene.has::<Stripes>(key));
            survey.textures += u64::from(scene.has::<Textured>(key));
            survey.shaders += u64::from(scene.has::<Shader>(key));
            survey.instances += u64::from(scene.has::<Instance>(key));
            survey.point_lights += u64::from(scene.has::<PointLight>(key));
            survey.spotlights += u64::from(scene.has::<Spotlight>(key));
            survey.suns += u64::from(scene.has::<Sun>(key));
            survey.projectors += u64::from(scene.has::<Projector>(key));
        }
        survey.enclose(shapes);
        if survey.others + survey.instances > 0 {
            survey.bounds = packed_bounds(scene);
        }
        survey
    }

    fn enclose(&mut self, shapes: &Shapes) {
        for (_, s) in &shapes.spheres {
            self.include(s.center - DVec3::splat(s.radius));
            self.include(s.center + DVec3::splat(s.radius));
        }
        for (_, q) in &shapes.quads {
            [q.corner, q.corner + q.u, q.corner + q.v, q.corner + q.u + q.v]
                .into_iter()
                .for_each(|p| self.include(p));
        }
        for (_, t) in &shapes.triangles {
            [t.a, t.b, t.c].into_iter().for_each(|p| self.include(p));
        }
        for (_, mesh) in &shapes.meshes {
            let at = placed(mesh);
            let corners = mesh.data.triangles.iter().flatten();
            corners.for_each(|i| self.include(at[*i as usize]));
        }
    }

    fn include(&mut self, p: DVec3) {
        let (least, greatest) = self.bounds.unwrap_or((p, p));
        self.bounds = Some((least.min(p), greatest.max(p)));
    }

    /// All visible surfaces, each triangle of a mesh counted.
    pub fn primitives(&self) -> u64 {
        self.spheres + self.planes + self.quads + self.triangles + self.mesh_triangles + self.others
    }
}

/// The corners of the box around all that is visible, but for planes; as packed, so a little larger.
fn packed_bounds(scene: &Scene) -> Option<(DVec3, DVec3)> {
    let packer = Packer::new(scene, Overrides::default()).ok()?;
    let boxes = packer.columns().geometry.bounds.iter();
    let all = boxes.filter(|b| b.lo[0].is_finite()).fold(Aabb::EMPTY, |all, b| all.union(b));
    let wide = |p: [f32; 3]| DVec3::from_array(p.map(f64::from));
    (!all.is_empty()).then(|| (wide(all.lo), wide(all.hi)))
}

impl fmt::Display for Survey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut surfaces = list(&[
            (self.spheres, "sphere"),
            (self.planes, "plane"),
            (self.quads, "quad"),
            (self.triangles, "triangle"),
            (self.others, "other shape"),
            (self.instances, "instance"),
        ]);
        if self.meshes > 0 {
            let triangles = counted(self.mesh_triangles, "triangle");
            let meshes = counted_as(self.meshes, "mesh", "meshes");
            surfaces = join(surfaces, format!("{meshes} of {triangles}"));
        }
        if self.hidden > 0 {
            surfaces = join(surfaces, format!("{} not visible", self.hidden));
        }
        writeln!(f, "surfaces    {}", or_none(surfaces))?;
        let bounds = match self.bounds {
            Some((least, greatest)) => format!("{} to {}", point(least), point(greatest)),
            None => "none".into(),
        };
        let planes = if self.planes > 0 { ", planes without end" } else { "" };
        writeln!(f, "bounds      {bounds}{planes}")?;
        let lights = list(&[
            (self.point_lights, "point light"),
            (self.spotlights, "spotlight"),
            (self.suns, "sun"),
            (self.projectors, "projector"),
        ]);
        writeln!(f, "lights      {}", or_none(lights))?;
        let mut materials = list(&[
            (self.materials, "material"),
            (self.checkers, "checker"),
            (self.stripes, "stripes pattern"),
            (self.textures, "texture"),
            (self.shaders, "shader"),
        ]);
        if self.mirrors > 0 {
            materials = join(materials, format!("{} of them mirroring", self.mirrors));
        }
        writeln!(f, "materials   {}", or_none(materials))
    }
}

/// A rough measure of the memory, in bytes, that an 8-bit render takes; measured on Linux with a
/// million spheres and with a picture of 32 million pixels.
pub fn memory(scene: &Scene, shapes: &Shapes, survey: &Survey) -> u64 {
    /// The program itself and its threads.
    const PROGRAM: u64 = 12_000_000;
    /// An entity in the world.
    const ENTITY: u64 = 150;
    /// A primitive's rows in the columns and its share of the tree, while that is built.
    const PRIMITIVE: u64 = 230;
    /// A picture and its rows as the encoder keeps them.
    const STILL: u64 = 6;
    /// In an animation three pictures are under way.
    const ANIMATION: u64 = 12;
    let image = scene.image();
    let pixels = u64::from(image.width) * u64::from(image.height);
    let pixel = if scene.animation().frames > 1 { ANIMATION } else { STILL };
    let meshes = shapes.meshes.iter().map(|(_, mesh)| &mesh.data);
    let vertices: usize = meshes.map(|data| data.positions.len() + data.triangles.len()).sum();
    PROGRAM
        + u64::from(scene.len()) * ENTITY
        + survey.primitives() * PRIMITIVE
        + vertices as u64 * 12
        + pixels * pixel
}

/// `1 sphere`, `2 spheres`.
pub fn counted(n: u64, noun: &str) -> String {
    counted_as(n, noun, &format!("{noun}s"))
}

fn counted_as(n: u64, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

fn list(parts: &[(u64, &str)]) -> String {
    let there: Vec<_> =
        parts.iter().filter(|(n, _)| *n > 0).map(|(n, noun)| counted(*n, noun)).collect();
    there.join(", ")
}

fn join(before: String, more: String) -> String {
    if before.is_empty() { more } else { format!("{before}, {more}") }
}

fn or_none(text: String) -> String {
    if text.is_empty() { "none".into() } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;
    use reflet_scene::{Falloff, Plane, Sphere, Surface};

    #[test]
    fn a_survey_reads_like_a_table() {
        let mut scene = Scene::new();
        let seen = Surface { material: None, visible: true };
        scene.spawn((Sphere { center: DVec3::new(0.0, 1.0, 0.0), radius: 1.0 }, seen));
        scene.spawn((Sphere { center: DVec3::ZERO, radius: 0.5 }, seen));
        scene.spawn((Plane { point: DVec3::ZERO, normal: DVec3::Y }, seen));
        scene.spawn((
            Sphere { center: DVec3::ZERO, radius: 9.0 },
            Surface { visible: false, ..seen },
        ));
        scene.spawn((Material { specular: DVec3::X, ..Material::default() },));
        scene.spawn((Material::default(),));
        scene.spawn((PointLight {
            at: DVec3::ONE,
            emissivity: DVec3::ONE,
            falloff: Falloff::Inverse,
        },));
        let survey = Survey::of(&scene, &Shapes::of(&scene));
        assert_eq!(
            survey.to_string(),
            "surfaces    2 spheres, 1 plane, 1 not visible\n\
             bounds      [-1, -0.5, -1] to [1, 2, 1], planes without end\n\
             lights      1 point light\n\
             materials   2 materials, 1 of them mirroring\n"
        );
        assert_eq!(survey.primitives(), 3);
    }
}
