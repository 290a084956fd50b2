//! The loop: the stages in order on one screen, and the only state that outlives a frame.
//!
//! | room | holds |
//! | --- | --- |
//! | [`job`] | what is asked for |
//! | [`event`] | what is told while it is done |
//! | [`changed`] | what differs from the frame before, by name |
//! | [`run`] | the stages in order |
//! | [`engine`] | columns to pictures, tile by tile on all threads |
//! | `tile` | one tile of a batch of frames |
//! | `pictures` | the pictures under way |
//! | [`reuse`] | what differs between two frames, and so what is done again |
//! | [`output`] | pictures to files, while the next frame is traced |
//! | [`memory`] | what this machine has |

pub mod changed;
pub mod engine;
pub mod event;
pub mod job;
pub mod memory;
pub mod output;
mod pictures;
pub mod reuse;
pub mod run;
mod tile;

pub use changed::{Changed, Thing};
pub use engine::{Batch, Engine, EngineOptions};
pub use event::{Event, FrameReport, RenderError, Summary};
pub use job::{Draft, Job, Reuse};
pub use run::render;
