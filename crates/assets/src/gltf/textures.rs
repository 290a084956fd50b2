//! The textures that materials name: pictures inside or beside the file, decoded once each.

use super::Trouble;
use super::container::{File, Other, load};
use super::json::{Sampler, TextureInfo};
use crate::texture::{Budget, Encoding};
use reflet_scene::{Map, TexelFilter, Texture, UvSet, Wrap};
use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

/// What a picture's samples are.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Samples {
    /// Colours, by the curve of sRGB.
    Colours,
    /// Numbers as they are.
    Data,
}

/// The pictures of a file, read as they are asked for.
pub(super) struct Textures<'a> {
    file: &'a File,
    other: Other<'a>,
    /// By image; `None` if it cannot be read.
    known: HashMap<(usize, Samples), Option<Arc<Texture>>>,
    /// The memory of all textures.
    budget: &'a Budget,
    /// What is wrong with those that cannot be read.
    pub unread: Vec<String>,
}

impl<'a> Textures<'a> {
    pub fn new(file: &'a File, other: Other<'a>, budget: &'a Budget) -> Self {
        Textures { file, other, known: HashMap::new(), budget, unread: Vec::new() }
    }

    /// The map that a material names; `None` if there is none or it cannot be read.
    pub fn map(&mut self, info: Option<&TextureInfo>, samples: Samples) -> Read {
        let Some(info) = info else { return Read::None };
        let file = self.file;
        let Some(texture) = file.root.textures.get(info.index) else {
            let there = file.root.textures.len();
            self.tell(format!("texture {} is asked for, there are {there}", info.index));
            return Read::Unread;
        };
        let transform = info.extensions.transform.as_ref();
        let set = match transform.and_then(|t| t.tex_coord).unwrap_or(info.tex_coord) {
            0 => UvSet::First,
            1 => UvSet::Second,
            set => {
                self.tell(format!("a texture takes TEXCOORD_{set}, and 0 and 1 are read"));
                return Read::Unread;
            }
        };
        let others = &texture.extensions;
        let others = [&others.webp, &others.avif, &others.basisu, &others.dds];
        let others = others.into_iter().flatten().filter_map(|other| other.source);
        let sources: Vec<usize> = texture.source.into_iter().chain(others).collect();
        let Some(image) = self.first_read(&sources, samples) else { return Read::Unread };
        let none = Sampler::default();
        let sampler = texture.sampler.and_then(|i| file.root.samplers.get(i)).unwrap_or(&none);
        const NEAREST: u32 = 9728;
        let nearest = sampler.mag_filter == Some(NEAREST);
        let wrap = |wrap| match wrap {
            Some(33071) => Wrap::Clamp,
            Some(33648) => Wrap::Mirror,
            _ => Wrap::Repeat,
        };
        Read::Map(Map {
            image,
            filter: if nearest { TexelFilter::Nearest } else { TexelFilter::Bilinear },
            wrap: [wrap(sampler.wrap_s), wrap(sampler.wrap_t)],
            set,
            place: transform.map_or([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], |t| {
                place(t.offset, t.rotation, t.scale)
            }),
        })
    }

    /// The first of several pictures of one texture that can be read.
    fn first_read(&mut self, sources: &[usize], samples: Samples) -> Option<Arc<Texture>> {
        let mut faults = Vec::new();
        for image in sources {
            match self.image(*image, samples) {
                Ok(Some(texture)) => return Some(texture),
                Ok(None) => {}
                Err(fault) => faults.push(fault),
            }
        }
        if sources.is_empty() {
            faults.push("it names no picture".to_owned());
        }
        if let Some(fault) = faults.into_iter().next() {
            self.tell(fault);
        }
        None
    }

    /// A picture; `None` if it could not be read before.
    fn image(&mut self, index: usize, samples: Samples) -> Result<Option<Arc<Texture>>, String> {
        if let Some(known) = self.known.get(&(index, samples)) {
            return Ok(known.clone());
        }
        let read = self.decode(index, samples);
        self.known.insert((index, samples), read.as_ref().ok().cloned());
        read.map(Some)
    }

    fn decode(&mut self, index: usize, samples: Samples) -> Result<Arc<Texture>, String> {
        let file = self.file;
        let image = file.root.images.get(index);
        let image = image.ok_or_else(|| format!("there is no image {index}"))?;
        let named = match &image.uri {
            Some(uri) if !uri.starts_with("data:") => format!("`{uri}`"),
            _ => format!("image {index}"),
        };
        let about = |why: &str| format!("{named}: {why}");
        let loaded;
        let bytes = match (&image.uri, image.buffer_view) {
            (Some(uri), _) => {
                loaded = load(uri, self.other).map_err(|trouble| about(trouble.message()))?;
                &loaded[..]
            }
            (None, Some(view)) => file.view(view).map_err(|trouble| about(trouble.message()))?.0,
            (None, None) => return Err(about("holds nothing")),
        };
        let encoding = match samples {
            Samples::Colours => Encoding::Srgb,
            Samples::Data => Encoding::Linear,
        };
        let read = self.budget.texture(Path::new(&named), bytes, encoding);
        Ok(read.map_err(|error| about(error.message()))?.texture)
    }

    fn tell(&mut self, what: String) {
        if !self.unread.contains(&what) {
            self.unread.push(what);
        }
    }
}

/// What came of a material's texture.
pub(super) enum Read {
    /// It names none.
    None,
    /// It is there.
    Map(Map),
    /// It names one that cannot be read.
    Unread,
}

impl Read {
    pub fn map(self) -> Option<Map> {
        match self {
            Read::Map(map) => Some(map),
            _ => None,
        }
    }

    pub fn is_unread(&self) -> bool {
        matches!(self, Read::Unread)
    }
}

impl Trouble {
    fn message(&self) -> &str {
        match self {
            Trouble::Said(message) => message,
            Trouble::Other(error) => error.message(),
        }
    }
}

/// KHR_texture_transform, which moves places with v down, for places with v up.
fn place(offset: [f64; 2], rotation: f64, [su, sv]: [f64; 2]) -> [[f64; 3]; 2] {
    let (sin, cos) = (libm::sin(rotation), libm::cos(rotation));
    // u' = a u + b v + c and v' = d u + e v + f, by translation * rotation * scale.
    let (a, b, c) = (cos * su, sin * sv, offset[0]);
    let (d, e, f) = (-sin * su, cos * sv, offset[1]);
    // With v = 1 - w, and of v' again what is left to 1.
    [[a, -b, b + c], [-d, e, 1.0 - e - f]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_texture_transform_turns_as_its_extension_says() {
        // The extension's own matrices: column vectors, v down.
        let (offset, rotation, scale) = ([0.25, 0.5], 0.7, [2.0, 3.0]);
        let [u, v] = [0.3, 0.1];
        let (sin, cos) = (libm::sin(rotation), libm::cos(rotation));
        let [x, y] = [u * scale[0], v * scale[1]];
        let down = [cos * x + sin * y + offset[0], -sin * x + cos * y + offset[1]];
        let up = place(offset, rotation, scale).map(|r| r[0] * u + r[1] * (1.0 - v) + r[2]);
        // Sums of numbers below 4, in another order.
        assert!((up[0] - down[0]).abs() < 1e-14 && (up[1] - (1.0 - down[1])).abs() < 1e-14);
    }
}
