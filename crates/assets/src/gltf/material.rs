//! Materials: metalness and roughness, or specular and glossiness, to ambient, diffuse and specular.
//!
//! Of the base colour the share that a smooth metal mirrors, `metalness (1 - roughness)`, is
//! specular, and the rest diffuse; what is emitted is ambient. What a rough metal would mirror in
//! all directions it scatters, and the faint mirror image on plastics is left out. With specular and
//! glossiness, `specular * glossiness` is specular, and diffuse is what the brightest specular number
//! leaves of it, as the extension has it.

use super::json::{self, MetalRough, SpecularGlossiness};
use super::textures::{Read, Samples, Textures};
use reflet_scene::{Maps, MeshMaterial, Mirrored};

type Rgb = [f64; 3];

/// What of a material is left out, by names.
pub(super) fn left_out(material: &json::Material) -> Vec<&'static str> {
    let glossiness = &material.extensions.specular_glossiness;
    let is_glossy = glossiness.as_ref().is_some_and(|g| g.specular_glossiness_texture.is_some());
    let is_clear = material.alpha_mode.as_ref().is_some_and(|mode| mode != "OPAQUE");
    let all = [
        (material.normal_texture.is_some(), "normal maps"),
        (material.occlusion_texture.is_some(), "occlusion maps"),
        (is_clear, "opacity"),
        (is_glossy, "glossiness of textures"),
    ];
    all.into_iter().filter(|(is_there, _)| *is_there).map(|(_, name)| name).collect()
}

/// What a material becomes in the model; `coloured` if vertices that wear it have colours.
pub(super) fn read(
    name: String,
    material: &json::Material,
    coloured: bool,
    textures: &mut Textures<'_>,
) -> MeshMaterial {
    let mut maps = Maps::default();
    let own = &material.extensions;
    let strength = own.emissive.as_ref().map_or(1.0, |e| e.emissive_strength);
    let mut ambient = material.emissive_factor.map(|part| part * strength);
    let emits = ambient != [0.0; 3];
    match textures.map(material.emissive_texture.as_ref().filter(|_| emits), Samples::Colours) {
        // A factor of 1 where the texture is black nearly everywhere.
        Read::Unread => ambient = [0.0; 3],
        read => maps.ambient = read.map(),
    }
    let default = MetalRough::default();
    let metal = material.pbr_metallic_roughness.as_ref().unwrap_or(&default);
    let (diffuse, specular) = match &own.specular_glossiness {
        _ if own.unlit.is_some() => {
            let map = textures.map(metal.base_color_texture.as_ref(), Samples::Colours);
            maps.ambient = map.map();
            maps.by_vertex = [coloured, false, false];
            let [r, g, b, _] = metal.base_color_factor;
            ambient = [r, g, b];
            ([0.0; 3], [0.0; 3])
        }
        Some(gloss) => glossy(gloss, &mut maps, textures),
        None => metallic(metal, &mut maps, textures),
    };
    if own.unlit.is_none() {
        maps.by_vertex = [false, coloured, coloured && specular != [0.0; 3]];
    }
    if specular == [0.0; 3] && maps.mirrored == Mirrored::AsGiven {
        maps.specular = None;
    }
    // Factors may be beyond what the model takes, as an emission of 1e39 is.
    const MOST: f64 = f32::MAX as f64;
    let within = |colour: Rgb| colour.map(|x| x.clamp(-MOST, MOST));
    let [ambient, diffuse, specular] = [ambient, diffuse, specular].map(within);
    MeshMaterial { name, ambient, diffuse, specular, maps: maps.shared() }
}

fn metallic(metal: &MetalRough, maps: &mut Maps, textures: &mut Textures<'_>) -> (Rgb, Rgb) {
    let [r, g, b, _] = metal.base_color_factor;
    let base = [r, g, b];
    let colour = textures.map(metal.base_color_texture.as_ref(), Samples::Colours).map();
    (maps.diffuse, maps.specular) = (colour.clone(), colour);
    let mirrors = metal.metallic_factor != 0.0;
    // A texture that would say nothing of metal need not be read.
    let shares = metal.metallic_roughness_texture.as_ref().filter(|_| mirrors);
    match textures.map(shares, Samples::Data) {
        Read::Map(map) => {
            let (metalness, roughness) = (metal.metallic_factor, metal.roughness_factor);
            let (metalness, roughness) = (metalness as f32, roughness as f32);
            maps.mirrored = Mirrored::Metal { map, metalness, roughness };
            (base, base)
        }
        Read::None => {
            let share = metal.metallic_factor * (1.0 - metal.roughness_factor);
            (base.map(|part| part * (1.0 - share)), base.map(|part| part * share))
        }
        // Few things are metal all over whose file says where they are.
        Read::Unread => (base, [0.0; 3]),
    }
}

fn glossy(gloss: &SpecularGlossiness, maps: &mut Maps, textures: &mut Textures<'_>) -> (Rgb, Rgb) {
    let [r, g, b, _] = gloss.diffuse_factor;
    let diffuse = [r, g, b];
    maps.diffuse = textures.map(gloss.diffuse_texture.as_ref(), Samples::Colours).map();
    let read = textures.map(gloss.specular_glossiness_texture.as_ref(), Samples::Colours);
    if read.is_unread() {
        return (diffuse, [0.0; 3]);
    }
    maps.specular = read.map();
    let specular = gloss.specular_factor;
    let mirrored = specular.map(|part| part * gloss.glossiness_factor);
    if maps.specular.is_some() {
        maps.mirrored = Mirrored::Specular(specular.map(|part| part as f32));
        return (diffuse, mirrored);
    }
    let left = 1.0 - specular.into_iter().fold(0.0, f64::max);
    (diffuse.map(|part| part * left), mirrored)
}
