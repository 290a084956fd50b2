//! Pixels to ray trees, and ray trees to colours: two passes that never mix.
//!
//! **Trace** ([`grow`]) makes the ray tree of a tile level by level: all camera rays, then all
//! their reflections, and so on, so that a level is one stream of rays. A node ([`trees`]) holds
//! what shading needs and no colour. **Shade** ([`shade`]) turns nodes and today's colours of
//! materials and lights into pixels, deepest level first. There is no third way to a pixel.
//!
//! | room | holds |
//! | --- | --- |
//! | [`grid`] | the picture in tiles |
//! | [`trees`] | nodes as columns, level by level |
//! | [`palette`] | the surfaces that a tile sees |
//! | [`camera`] | pixels to rays |
//! | [`interact`] | where a ray hit, how the surface lies there |
//! | `tint` | what pictures, maps and expressions say at hit points |
//! | `look_up` | texels of pictures |
//! | `smooth` | normals of meshes that are not those of their triangles |
//! | [`lighting`] | what each light gives, and whether it is seen |
//! | [`mirror`] | which nodes reflect, and where to |
//! | `stream` | the rays of a level on their way to becoming nodes |
//! | [`grow`] | these in turn: the first pass |
//! | [`edges`] | the pixels that are worth more samples |
//! | [`touch`] | the trees that a moved surface can have changed, made anew |
//! | [`capsule`] | chunks of segments, to be passed over together |
//! | `segment` | whether a segment of a tree meets a volume |
//! | [`colours`] | what only shading reads, for each frame of a batch |
//! | [`shade`] | the second pass |

pub mod camera;
pub mod capsule;
pub mod colours;
pub mod edges;
pub mod grid;
pub mod grow;
pub mod interact;
pub mod lighting;
mod look_up;
pub mod mirror;
pub mod palette;
mod segment;
pub mod shade;
mod smooth;
mod stream;
mod tint;
pub mod touch;
pub mod trees;

pub use colours::BatchColours;
pub use grid::{Grid, TileRect};
pub use grow::{PatternCells, Revision, TraceScratch, Tracer};
pub use shade::{Colour, ShadeScratch, Shader};
pub use stream::{RayTally, Recorded};
pub use touch::Moved;
pub use trees::{Points, Trees};
