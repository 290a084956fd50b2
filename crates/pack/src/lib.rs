//! World to columns: structure of arrays sorted by key, and what differs between two of them.
//!
//! `f64` nouns are rounded once to `f32` here; what is derived from them (unit normals, boxes, the
//! camera's frame, cosines) is computed in `f64` first. After this crate nothing knows hecs.
//!
//! | room | holds |
//! | --- | --- |
//! | [`ids`] | indices as types |
//! | [`bounds`] | outward-rounded boxes |
//! | [`geometry`] | what rays are intersected with |
//! | [`surfaces`] | which primitives are one surface, and what it wears |
//! | [`materials`] | colours of reflection |
//! | [`lights`] | where light comes from |
//! | [`view`] | eye, picture, settings |
//! | [`columns`] | all of them |
//! | `rows` | rows of surfaces and primitives, and how a shape fills them |
//! | [`packer`] | the world into columns, whole or only the rows that a frame touched |
//! | [`changes`] | what differs between two frames, by bits |
//! | [`hash`] | a name for all that decides a picture |

pub mod bounds;
pub mod changes;
pub mod columns;
pub mod geometry;
pub mod hash;
pub mod ids;
pub mod lights;
pub mod materials;
pub mod packer;
mod rows;
pub mod surfaces;
pub mod view;

pub use bounds::{Aabb, Volume};
pub use changes::{Changes, LightChange, MaterialChange, SurfaceChange};
pub use columns::Columns;
pub use geometry::{Geometry, ShapeKind};
pub use hash::{SceneHash, SceneHasher};
pub use ids::{LightId, MaterialId, PrimId, SurfaceId};
pub use packer::{NoCamera, Overrides, Packer};
pub use reflet_scene::{Attenuation, Key, TransferCurve};
