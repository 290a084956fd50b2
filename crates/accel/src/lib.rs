//! Columns and rays to hits: SIMD kernels and a wide bounding volume hierarchy.
//!
//! # What a hit is
//!
//! A ray hits a primitive if the primitive's kernel ([`kernels`]) passes **and** the ray passes the
//! primitive's own outward-rounded box by the one slab routine ([`slab`]); its t is the greater of
//! the kernel's t and the box's entry. The closest hit is the least t; a tie goes to the lower
//! [`PrimId`]. [`brute`] says the same in plain scalar code.
//!
//! Boxes of inner nodes contain the boxes of what is below, and IEEE rounding is monotone, so a
//! node whose entry lies beyond the best t so far can be left out: no hit and no tie is lost. That
//! makes the answer independent of the tree, of the order of traversal and of the SIMD level.
//!
//! Every kernel is one sequence of IEEE operations: multiply and add apart, true division and
//! square root, compares and selects in place of min and max.
//!
//! | room | holds |
//! | --- | --- |
//! | [`isa`] | which instructions are used |
//! | [`rays`] | streams of rays, and what they hit |
//! | [`lanes`] | a ray as every kernel sees it |
//! | [`slab`] | the box test |
//! | [`kernels`] | one test a shape |
//! | [`solid`] | that of curved shapes, in `f64`, scalar |
//! | [`solids`] | the same in lanes |
//! | [`brute`] | the definition, scalar |
//! | [`blocks`] | primitives in lanes |
//! | [`tree`] | nodes of eight boxes |
//! | [`build`] | the tree by binned surface area |
//! | [`items`] | boxes as it sorts them |
//! | [`bins`] | where it cuts a branch in two |
//! | [`copies`] | meshes that stand in the scene once more |
//! | [`through`] | one ray through one of them |
//! | [`flights`] | single rays, many at once |
//! | [`entry_points`] | where in the tree those of a bundle set out |
//! | [`stacks`] | what they have still to visit |
//! | [`order`] | a node's children in the order of a ray |
//! | [`prefetch`] | memory asked for early |
//! | [`count`] | what a cast takes, counted |
//! | [`bundle`] | rays that run together |
//! | [`frusta`] | the frusta that hold them |
//! | [`tile`] | a bundle through the list and the tree |
//! | [`todo`](mod@todo) | what it has still to visit |
//! | [`refit`] | primitives that moved |
//! | [`regroup`] | shadow rays in the order in which their light sees them |
//! | [`stream`] | streams to bundles and single rays |
//! | [`known`] | rays in lanes against what they are known to hit |
//! | [`accel`] | all of it behind two calls |

pub mod accel;
pub mod bins;
pub mod blocks;
pub mod brute;
pub mod build;
pub mod bundle;
pub mod copies;
pub mod count;
pub mod entry_points;
pub mod flights;
pub mod frusta;
pub mod isa;
pub mod items;
pub mod kernels;
pub mod known;
pub mod lanes;
pub mod order;
pub mod prefetch;
pub mod rays;
pub mod refit;
pub mod regroup;
pub mod slab;
pub mod solid;
pub mod solids;
pub mod stacks;
pub mod stream;
pub mod through;
pub mod tile;
pub mod todo;
pub mod tree;

pub use accel::{Accel, Scratch, Structure};
pub use build::Quality;
pub use count::Work;
pub use isa::{Isa, IsaError};
pub use rays::{HitCode, Hits, Question, RayCounts, Rays};
pub use refit::Refit;
pub use reflet_pack::{PrimId, Slot};
pub use stream::Way;
