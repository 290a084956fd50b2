//! The nouns of a scene: components in a [`hecs`] world, each entity with a stable [`Key`].
//!
//! Scripts write these components, `pack` reads them. Nothing here knows a ray. All numbers are
//! `f64` as the script gave them; `pack` rounds once to `f32`.
//!
//! | room | holds |
//! | --- | --- |
//! | [`key`] | identity and order of making |
//! | [`shape`] | sphere, plane, quad, triangle |
//! | [`mesh`] | indexed triangles and their placement |
//! | [`texture`] | pictures that surfaces wear |
//! | [`material`] | reflectivities, checker, and which surface wears what |
//! | [`light`] | point light and spotlight |
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
pub mod material;
pub mod mesh;
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
pub use light::{PointLight, Spotlight};
pub use material::{Checker, Material, Surface};
pub use mesh::{Mesh, MeshData, MeshMaterial};
pub use random::RandomStream;
pub use scene::{Scene, Singletons};
pub use settings::{Animation, Attenuation, Image, Settings, TransferCurve};
pub use shape::{Plane, Quad, Sphere, Triangle};
pub use texture::Texture;
