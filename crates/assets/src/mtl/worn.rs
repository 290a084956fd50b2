//! What an OBJ mesh wears, of the materials that MTL files describe.
//!
//! - `illum` 0, 1 and 2 do not mirror (2 means a highlight); 3 and up do, by `Ks`, and so does a
//!   material without `illum`. With `illum` 0 `Ka` does not count.
//! - With the metalness `Pm` the share `s = Pm (1 - Pr)` of `Kd` is specular and the rest diffuse.
//! - `Ka` and `Ke` together are ambient.
//! - `Kd` is 1 where there is only its texture, and a material without any colour is the grey of no
//!   material.

use super::{Described, Image, KA, KD, KE, KS};
use crate::error::{AssetError, Cause, Fault};
use crate::format;
use crate::left_out::{Kind, LeftOut};
use crate::obj::Obj;
use crate::texture::{Budget, Encoding};
use reflet_scene::{Map, Maps, MeshData, MeshMaterial, Mirrored, Texture, Wrap};
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

const HIGHLIGHTS: Kind = Kind::new(
    "highlight left out (`Ks` with `illum` 0 to 2 does not mirror)",
    "highlights left out (`Ks` with `illum` 0 to 2 does not mirror)",
);
const MISSING: Kind =
    Kind::new("more of its materials' files not found", "more of its materials' files not found");
const UNWORN: Kind =
    Kind::new("more texture that cannot be worn", "more textures that cannot be worn");

const LEFT_OUT: Kind = Kind::new("more remark on textures", "more remarks on textures");

/// Bytes of files, by their paths relative to the mesh.
pub(crate) type Other<'a> = dyn FnMut(&str) -> Result<Vec<u8>, AssetError> + 'a;

/// Gives the materials that an OBJ file called `path` uses what its libraries say, and tells what is
/// left out.
///
/// # Errors
/// A library that is there and broken.
pub(crate) fn wear(
    path: &Path,
    obj: &mut Obj,
    other: &mut Other<'_>,
    budget: &Budget,
) -> Result<Vec<String>, AssetError> {
    let mut wearing = Wearing { has_uvs: !obj.data.uvs.is_empty(), ..Wearing::new(other, budget) };
    if !obj.data.materials.is_empty() {
        wearing.libraries(path, &obj.libraries)?;
        wearing.materials(&mut obj.data.materials);
    }
    by_vertex(&mut obj.data);
    let mut notes = wearing.notes;
    notes.extend(wearing.left_out.told());
    if !wearing.not_read.is_empty() {
        notes.push(format!("not read of its materials: {}", wearing.not_read.join(", ")));
    }
    Ok(notes)
}

/// Lets the colours of vertices multiply diffuse, and the share of it that is specular. What has no
/// colour but theirs is white.
pub(crate) fn by_vertex(data: &mut MeshData) {
    if data.colours.iter().all(|colour| *colour == [1.0; 3]) {
        data.colours = Vec::new();
        return;
    }
    if data.materials.is_empty() {
        data.materials.push(MeshMaterial::grey(""));
        data.triangle_materials = vec![0; data.triangles.len()];
    }
    for material in &mut data.materials {
        if *material == MeshMaterial::grey(material.name.clone()) {
            material.diffuse = [1.0; 3];
        }
        let mut maps = material.maps.as_deref().cloned().unwrap_or_default();
        maps.by_vertex = [false, true, false];
        material.maps = maps.shared();
    }
}

struct Wearing<'a, 'b> {
    other: &'a mut Other<'b>,
    /// The memory of all textures.
    budget: &'a Budget,
    has_uvs: bool,
    /// By name; of two of one name the first counts.
    known: HashMap<String, (Described, String)>,
    /// By path; `None` for what cannot be read.
    textures: HashMap<String, Option<Arc<Texture>>>,
    notes: Vec<String>,
    left_out: LeftOut,
    not_read: Vec<String>,
    /// Files that were not there.
    missing: u32,
}

/// So many things that cannot be worn are told by name.
const NAMED: usize = 3;

/// So many files that are not there are looked for: a small mesh can name very many.
const SOUGHT: u32 = 100;

impl<'a, 'b> Wearing<'a, 'b> {
    fn new(other: &'a mut Other<'b>, budget: &'a Budget) -> Self {
        Self {
            other,
            budget,
            has_uvs: false,
            known: HashMap::new(),
            textures: HashMap::new(),
            notes: Vec::new(),
            left_out: LeftOut::default(),
            not_read: Vec::new(),
            missing: 0,
        }
    }

    fn tell(&mut self, message: String, more: Kind) {
        match self.notes.len() < NAMED {
            true => self.notes.push(message),
            false => self.left_out.add(more, None),
        }
    }

    fn libraries(&mut self, path: &Path, lines: &[String]) -> Result<(), AssetError> {
        for line in lines {
            if self.missing > SOUGHT {
                self.left_out.add(MISSING, None);
                continue;
            }
            // A line is one name, or several without blanks in them.
            let whole = (self.other)(&slashed(line));
            let several = line.contains(char::is_whitespace)
                && whole.as_ref().is_err_and(|error| error.cause() == Cause::Missing);
            let names: Vec<&str> = match several {
                true => line.split_whitespace().collect(),
                false => vec![line],
            };
            let mut whole = Some(whole);
            for name in names {
                let name = slashed(name);
                let bytes = match whole.take().filter(|_| !several) {
                    Some(whole) => whole,
                    None => (self.other)(&name),
                };
                let (name, bytes) = match bytes {
                    Ok(bytes) => (name, Ok(bytes)),
                    Err(error) => self.beside(&name, error),
                };
                match bytes {
                    Ok(bytes) => self.library(path, &name, &bytes)?,
                    // Very many files name one that was left behind, on another machine.
                    Err(error) => {
                        let message =
                            format!("its materials in `{name}` are grey: {}", error.message());
                        self.tell(message, MISSING);
                    }
                }
            }
        }
        Ok(())
    }

    /// Looks for a file of another machine's folders by its last name alone.
    fn beside(&mut self, name: &str, error: AssetError) -> (String, Result<Vec<u8>, AssetError>) {
        self.missing += 1;
        let last = name.rsplit('/').next().unwrap_or_default();
        if last == name || last.is_empty() {
            return (name.to_owned(), Err(error));
        }
        match (self.other)(last) {
            Ok(bytes) => (last.to_owned(), Ok(bytes)),
            Err(_) => (name.to_owned(), Err(error)),
        }
    }

    fn library(&mut self, path: &Path, name: &str, bytes: &[u8]) -> Result<(), AssetError> {
        let place = path.with_file_name("").join(name);
        let broken = |fault: Fault| AssetError::broken(&place, fault);
        if let Some(what) = format::other_than("mtl", bytes).filter(|_| !bytes.is_empty()) {
            return Err(broken(Fault::file(format!("is {what}"))));
        }
        for described in super::parse(bytes).map_err(broken)? {
            let (name, of) = (described.name.clone(), name.to_owned());
            self.known.entry(name).or_insert((described, of));
        }
        Ok(())
    }

    fn materials(&mut self, materials: &mut [MeshMaterial]) {
        let mut unknown: Vec<String> = Vec::new();
        for material in materials.iter_mut() {
            match self.known.remove(&material.name) {
                Some((described, library)) => *material = self.material(described, &library),
                None if material.name.is_empty() => {}
                None => unknown.push(material.name.clone()),
            }
        }
        // Without any library that was told already.
        let is_told = self.missing > 0 && unknown.len() == materials.len();
        if let (Some(first), false) = (unknown.first(), is_told) {
            let count = match unknown.len() {
                1 => "1 material".to_owned(),
                n => format!("{n} materials"),
            };
            self.notes.push(format!("{count} not found and grey, the first `{first}`"));
        }
    }

    fn material(&mut self, described: Described, library: &str) -> MeshMaterial {
        let Described { name, colours, maps, illum, metalness, roughness, not_read } = described;
        for statement in not_read {
            if !self.not_read.contains(&statement) {
                self.not_read.push(statement);
            }
        }
        let grey = MeshMaterial::grey(name);
        let is_grey = colours.iter().all(Option::is_none) && maps.iter().all(Option::is_none);
        let [map_ambient, map_diffuse, map_specular, map_emitted] = maps;
        let has_image = map_diffuse.is_some();
        let diffuse = match colours[KD] {
            Some(diffuse) => diffuse,
            None if has_image => [1.0; 3],
            None if is_grey => grey.diffuse,
            None => [0.0; 3],
        };
        let is_lit = illum != Some(0);
        let around = colours[KA].filter(|_| is_lit).unwrap_or_default();
        let emitted = colours[KE].unwrap_or([f64::from(u8::from(map_emitted.is_some())); 3]);
        let mut worn = Maps::default();
        // One texture serves for both parts of ambient.
        let lights = emitted != [0.0; 3] && map_emitted.is_some();
        let ambient = if lights { emitted } else { [0, 1, 2].map(|k| around[k] + emitted[k]) };
        worn.ambient = match lights {
            true => self.map(map_emitted, library),
            false if around != [0.0; 3] && emitted == [0.0; 3] => self.map(map_ambient, library),
            false => None,
        };
        worn.diffuse = self.map(map_diffuse, library);
        let highlight = colours[KS].unwrap_or_default();
        let (diffuse, specular) = if let Some(metalness) = metalness {
            let share = metalness * (1.0 - roughness.unwrap_or(0.0));
            worn.specular.clone_from(&worn.diffuse);
            (diffuse.map(|part| part * (1.0 - share)), diffuse.map(|part| part * share))
        } else if illum.is_some_and(|illum| illum < 3) {
            if highlight != [0.0; 3] {
                self.left_out.add(HIGHLIGHTS, None);
            }
            (diffuse, [0.0; 3])
        } else {
            (diffuse, highlight)
        };
        if specular == [0.0; 3] {
            worn.specular = None;
        } else if metalness.is_none() {
            worn.specular = self.map(map_specular, library);
        }
        worn.mirrored = Mirrored::AsGiven;
        let ambient = if is_grey { grey.ambient } else { ambient };
        MeshMaterial { ambient, diffuse, specular, maps: worn.shared(), ..grey }
    }

    /// A texture as a mesh wears it.
    fn map(&mut self, image: Option<Image>, library: &str) -> Option<Map> {
        let Image { file, scale, offset, is_clamped } = image?;
        if !self.has_uvs {
            let message =
                format!("`{file}` is not worn: the mesh has no texture coordinates (`vt`)");
            if !self.notes.contains(&message) {
                self.tell(message, UNWORN);
            }
            return None;
        }
        let mut map = Map::new(self.texture(&file, library)?);
        map.place = [[scale[0], 0.0, offset[0]], [0.0, scale[1], offset[1]]];
        if is_clamped {
            map.wrap = [Wrap::Clamp; 2];
        }
        Some(map)
    }

    /// The texture of a file beside the library that names it, beside the mesh, or of the same last
    /// name there.
    fn texture(&mut self, file: &str, library: &str) -> Option<Arc<Texture>> {
        let name = slashed(file);
        let beside = match library.rsplit_once('/') {
            Some((folder, _)) => format!("{folder}/{name}"),
            None => name.clone(),
        };
        if let Some(known) = self.textures.get(&beside) {
            return known.clone();
        }
        if self.missing > SOUGHT {
            self.left_out.add(UNWORN, None);
            return None;
        }
        let found = match (self.other)(&beside) {
            Err(_) if beside != name => (self.other)(&name),
            found => found,
        };
        let (_, found) = match found {
            Ok(bytes) => (name, Ok(bytes)),
            Err(error) => self.beside(&beside, error),
        };
        let read =
            found.and_then(|bytes| self.budget.texture(Path::new(&beside), &bytes, Encoding::Told));
        let texture = match read {
            Ok(read) => {
                for note in &read.notes {
                    self.tell(format!("of the texture `{file}`: {note}"), LEFT_OUT);
                }
                Some(read.texture)
            }
            Err(error) => {
                let message = error.message();
                self.tell(format!("the texture `{file}` is not worn: {message}"), UNWORN);
                None
            }
        };
        self.textures.insert(beside, texture.clone());
        texture
    }
}

/// A path as programs on Windows write it, too.
fn slashed(path: &str) -> String {
    let path = path.trim_matches('"').replace('\\', "/");
    path.strip_prefix("./").unwrap_or(&path).to_owned()
}
