//! What colours a surface from point to point: pictures, the maps of mesh files and expressions, and
//! the coordinates that they read.

use crate::cells::in_plane;
use crate::parts::{Anchor, Part};
use crate::solids::Form;
use glam::{DAffine3, DMat3, DVec3};
pub use reflet_scene::program;
pub use reflet_scene::{Map, Maps, Mirrored, TexelFilter, Texture, UvSet, Wrap};
use reflet_scene::{Mapping, Program, Shader, Textured};
use std::sync::Arc;

/// An affine function of a point of the scene.
pub type Row = [f64; 4];

/// What makes a surface's reflectivities differ from point to point.
#[derive(Clone, Debug)]
pub struct Tint {
    /// What it is.
    pub paint: TintPaint,
    /// The surface's coordinates u and v, one chart a primitive; none for a mesh, whose file has
    /// them.
    pub charts: Vec<Chart>,
    /// The way from the scene to the coordinates before groups and instances move the surface.
    pub local: [Row; 3],
    /// The same for normals, but for their length.
    pub turn: [[f64; 3]; 3],
}

/// A picture, maps or expressions.
#[derive(Clone, Debug)]
pub enum TintPaint {
    /// All three reflectivities are multiplied with a picture's texels.
    Texture {
        /// The picture.
        image: Arc<Texture>,
        /// What lies between the middles of texels.
        filter: TexelFilter,
        /// Where a point lies in a picture that is repeated, in its widths and heights; `None` where
        /// it lies once over u and v.
        tiles: Option<[Row; 2]>,
    },
    /// Each reflectivity is multiplied with what the maps of a mesh file say.
    Maps(Arc<Maps>),
    /// Ambient, diffuse and specular, where an expression stands in place of the material's.
    Programs([Option<Arc<Program>>; 3]),
}

/// How u and v follow from a point, by way of three affine functions x, y and z of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chart {
    /// x, y and z.
    pub local: [Row; 3],
    /// What becomes of them.
    pub kind: ChartKind,
}

/// What becomes of a chart's x, y and z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ChartKind {
    /// u = x, v = y.
    Flat,
    /// Longitude and latitude on the unit sphere, y up.
    Ball,
    /// The angle around z, and where z lies between two bounds.
    Around([f64; 2]),
    /// The angle around z, and that around a tube whose ring has this radius.
    Ring(f64),
}

impl Tint {
    pub(crate) fn textured(t: &Textured, site: &Site<'_>) -> Tint {
        let tiles = (t.mode == Mapping::Tile).then(|| {
            let axes = in_plane(t.xdir, site.anchor.normal.unwrap_or(DVec3::Y));
            let inverse = site.inverse();
            [0, 1].map(|k| {
                let axis = axes[k] / t.size[k];
                compose(axis, -axis.dot(site.anchor.origin), &inverse)
            })
        });
        let paint = TintPaint::Texture { image: t.image.clone(), filter: t.filter, tiles };
        Tint::new(paint, site)
    }

    pub(crate) fn mapped(maps: Arc<Maps>, site: &Site<'_>) -> Tint {
        Tint::new(TintPaint::Maps(maps), site)
    }

    pub(crate) fn shader(s: &Shader, site: &Site<'_>) -> Tint {
        let programs = [s.ambient.clone(), s.diffuse.clone(), s.specular.clone()];
        Tint::new(TintPaint::Programs(programs), site)
    }

    fn new(paint: TintPaint, site: &Site<'_>) -> Tint {
        let inverse = site.inverse();
        let m = site.to.map_or(DMat3::IDENTITY, |to| to.matrix3).transpose();
        let turn = [0, 1, 2].map(|k| [m.x_axis[k], m.y_axis[k], m.z_axis[k]]);
        let charts = site.parts.iter().map(|part| Chart::of(part, site, &inverse)).collect();
        Tint { paint, charts, local: rows(&inverse), turn }
    }

    /// All of it as bits; a picture is its address, since files are read once.
    pub fn bits(&self) -> Vec<u64> {
        self.bits_with(&|image| Arc::as_ptr(image) as u64)
    }

    /// All of it as bits that follow from its content alone, but for the texels of
    /// [`Tint::images`].
    pub(crate) fn content_bits(&self) -> Vec<u64> {
        self.bits_with(&|_| 0)
    }

    fn bits_with(&self, image_bits: &dyn Fn(&Arc<Texture>) -> u64) -> Vec<u64> {
        let mut bits = Vec::new();
        match &self.paint {
            TintPaint::Texture { image, filter, tiles } => {
                bits.extend([0, image_bits(image), *filter as u64]);
                bits.push(u64::from(tiles.is_some()));
                bits.extend(tiles.iter().flatten().flatten().map(|x| x.to_bits()));
            }
            TintPaint::Maps(maps) => map_bits(maps, image_bits, &mut bits),
            TintPaint::Programs(programs) => program_bits(programs, &mut bits),
        }
        self.place_bits(&mut bits);
        bits
    }

    /// The pictures that it reads.
    pub(crate) fn images(&self) -> Vec<&Arc<Texture>> {
        match &self.paint {
            TintPaint::Texture { image, .. } => vec![image],
            TintPaint::Maps(maps) => maps.all().map(|map| &map.image).collect(),
            TintPaint::Programs(_) => Vec::new(),
        }
    }

    fn place_bits(&self, bits: &mut Vec<u64>) {
        bits.extend(self.local.iter().flatten().map(|x| x.to_bits()));
        for chart in &self.charts {
            bits.extend(chart.local.iter().flatten().map(|x| x.to_bits()));
            let [kind, a, b] = match chart.kind {
                ChartKind::Flat => [0, 0, 0],
                ChartKind::Ball => [1, 0, 0],
                ChartKind::Around([low, high]) => [2, low.to_bits(), high.to_bits()],
                ChartKind::Ring(major) => [3, major.to_bits(), 0],
            };
            bits.extend([kind, a, b]);
        }
    }
}

fn program_bits(programs: &[Option<Arc<Program>>; 3], bits: &mut Vec<u64>) {
    bits.push(1);
    for program in programs {
        let own = program.as_ref().map_or(Vec::new(), |p| p.bits());
        bits.push(own.len() as u64);
        bits.extend(own.into_iter().map(u64::from));
    }
}

fn map_bits(maps: &Maps, image_bits: &dyn Fn(&Arc<Texture>) -> u64, bits: &mut Vec<u64>) {
    bits.push(2);
    bits.extend(maps.by_vertex.map(u64::from));
    bits.extend([&maps.ambient, &maps.diffuse, &maps.specular].map(|map| u64::from(map.is_some())));
    bits.extend(match &maps.mirrored {
        Mirrored::AsGiven => [0; 4],
        Mirrored::Metal { metalness, roughness, .. } => {
            [1, u64::from(metalness.to_bits()), u64::from(roughness.to_bits()), 0]
        }
        Mirrored::Specular([r, g, b]) => {
            let [r, g, b] = [r, g, b].map(|x| u64::from(x.to_bits()));
            [2, r, g, b]
        }
    });
    for map in maps.all() {
        let Map { image, filter, wrap, set, place } = map;
        bits.extend([image_bits(image), *filter as u64, *set as u64]);
        bits.extend(wrap.map(|wrap| wrap as u64));
        bits.extend(place.iter().flatten().map(|x| x.to_bits()));
    }
}

/// A surface where its pattern is to lie.
pub(crate) struct Site<'a> {
    pub anchor: Anchor,
    /// Its parts before groups and instances move them.
    pub parts: &'a [Part],
    /// How these move it.
    pub to: Option<&'a DAffine3>,
}

impl Site<'_> {
    fn inverse(&self) -> DAffine3 {
        self.to.map_or(DAffine3::IDENTITY, DAffine3::inverse)
    }
}

impl Chart {
    fn of(part: &Part, site: &Site<'_>, inverse: &DAffine3) -> Chart {
        let flat = |corner: DVec3, u: DVec3, v: DVec3| {
            let frame = DMat3::from_cols(u, v, u.cross(v));
            (DAffine3::from_mat3_translation(frame, corner).inverse(), ChartKind::Flat)
        };
        let (way, kind) = match *part {
            Part::Sphere { center, radius } => {
                let ball = DMat3::from_diagonal(DVec3::splat(radius));
                (DAffine3::from_mat3_translation(ball, center).inverse(), ChartKind::Ball)
            }
            Part::Plane { point, normal } => {
                let [x, y] = in_plane(DVec3::X, site.anchor.normal.unwrap_or(normal));
                flat(point, x, y)
            }
            Part::Quad { points: [corner, u, _, v], .. } => flat(corner, u - corner, v - corner),
            Part::Triangle { points: [a, b, c], .. } => flat(a, b - a, c - a),
            Part::Solid { form: Form::Disc, world } => {
                let m = world.matrix3;
                let corner = world.translation - m.x_axis - m.y_axis;
                flat(corner, 2.0 * m.x_axis, 2.0 * m.y_axis)
            }
            Part::Solid { form: Form::Revolved { z, .. }, world } => {
                let closed = z[0].is_infinite();
                (world.inverse(), if closed { ChartKind::Ball } else { ChartKind::Around(z) })
            }
            Part::Solid { form: Form::Torus { major, .. }, world } => {
                (world.inverse(), ChartKind::Ring(major))
            }
        };
        Chart { local: rows(&(way * *inverse)), kind }
    }
}

fn rows(way: &DAffine3) -> [Row; 3] {
    let (m, t) = (way.matrix3, way.translation);
    [0, 1, 2].map(|k| [m.x_axis[k], m.y_axis[k], m.z_axis[k], t[k]])
}

/// The function axis.q + offset of q = way(p), as one of p.
fn compose(axis: DVec3, offset: f64, way: &DAffine3) -> Row {
    let m = way.matrix3;
    [axis.dot(m.x_axis), axis.dot(m.y_axis), axis.dot(m.z_axis), axis.dot(way.translation) + offset]
}
