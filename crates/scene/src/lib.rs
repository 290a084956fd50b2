//! The nouns of a scene: components in a [`hecs`] world, each entity with a stable [`Key`].
//!
//! Scripts write these components, `pack` reads them. Nothing here knows a ray. All numbers are
//! `f64` as the script gave them; `pack` rounds once to `f32`.
//!
//! | room | holds |
//! | --- | --- |
//! | [`key`] | identity and order of making |
//! | [`shape`] | sphere, plane, quad, triangle, disc, cuboid |
//! | [`quadric`] | cylinder, cone, paraboloid, hyperboloid, ellipsoid, torus |
//! | [`place`] | groups, instances, and where they put things |
//! | [`mesh`] | indexed triangles and their placement |
//! | [`material`] | reflectivities, checker, and which surface wears what |
//! | [`texture`] | pictures that surfaces wear |
//! | [`maps`] | textures that multiply a mesh file's material |
//! | [`program`] | reflectivities as expressions |
//! | [`light`] | point light, spotlight, sun and projector |
//! | [`camera`] | the two views |
//! | [`settings`] | picture, settings of the model, animation |
//! | [`random`] | seeded streams of numbers |
//! | [`fault`] | what is wrong with a noun, by key |
//! | [`journal`] | old values, so that a frame can be undone |
//! | [`scene`] | the world with its keys and its journal |

pub mod camera;
pub mod fault;
pub mod journal;
pub mod key;
pub mod light;
pub mod maps;
pub mod material;
pub mod mesh;
pub mod place;
pub mod program;
pub mod quadric;
pub mod random;
pub mod scene;
pub mod settings;
pub mod shape;
pub mod texture;

pub use camera::Camera;
pub use fault::Fault;
pub use glam::DVec3;
pub use journal::Noun;
pub use key::Key;
pub use light::{Falloff, PointLight, Projector, Spotlight, Sun};
pub use maps::{Map, Mapped, Maps, Mirrored, UvSet, Wrap};
pub use material::{Checker, Material, Stripes, Surface, Tiles};
pub use mesh::{Mesh, MeshData, MeshMaterial, Shading, Worn};
pub use place::{Group, Instance, Place};
pub use program::{Program, Shader};
pub use quadric::{Caps, Cone, Cylinder, Ellipsoid, Hyperboloid, Paraboloid, Torus};
pub use random::RandomStream;
pub use scene::{Scene, Singletons};
pub use settings::{Animation, Attenuation, Filter, Image, Settings, Spread, TransferCurve};
pub use shape::{Cuboid, Disc, Plane, Quad, Sphere, Triangle};
pub use texture::{Mapping, TexelFilter, Texture, Textured};
