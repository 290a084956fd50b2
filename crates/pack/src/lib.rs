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
//! | [`solids`] | of that, what is curved or round, each in coordinates of its own |
//! | [`copies`] | of that, meshes that stand in the scene once more |
//! | [`surfaces`] | which primitives are one surface, and what it wears |
//! | [`cells`] | the cells of patterns |
//! | [`tints`] | pictures and expressions |
//! | [`materials`] | colours of reflection |
//! | [`lights`] | where light comes from |
//! | [`view`] | eye, picture, settings |
//! | [`columns`] | all of them |
//! | `parts` | what a surface is made of, and how a primitive fills its row |
//! | `sources` | which surface a row shows, and through which groups and instances |
//! | [`sharing`] | which meshes are copies |
//! | `rows` | rows of surfaces and primitives |
//! | [`packer`] | the world into columns, whole or only the rows that a frame touched |
//! | [`changes`] | what differs between two frames, by bits |
//! | [`hash`] | a name for all that decides a picture |

pub mod bounds;
pub mod cells;
pub mod changes;
pub mod columns;
pub mod copies;
pub mod geometry;
pub mod hash;
pub mod ids;
pub mod lights;
pub mod materials;
pub mod packer;
mod parts;
mod rows;
pub mod sharing;
pub mod solids;
mod sources;
pub mod surfaces;
pub mod tints;
pub mod view;

pub use bounds::{Aabb, Volume};
pub use changes::{Changes, LightChange, MaterialChange, SurfaceChange};
pub use columns::Columns;
pub use copies::{MeshCopy, SharedMesh};
pub use geometry::{Geometry, SHAPE_KINDS, ShapeKind};
pub use hash::{SceneHash, SceneHasher};
pub use ids::{LightId, MaterialId, PrimId, Slot, SurfaceId};
pub use packer::{NoCamera, Overrides, Packer};
pub use reflet_scene::{Attenuation, Falloff, Key, MeshData, Spread, TransferCurve};
pub use sharing::Sharing;
pub use solids::{Form, Solid};
