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
//! | [`provenance`] | what a file was made from, as it says itself |
//! | [`resume`] | which files stand, and which are made anew |
//! | [`mod@verify`] | a finished sequence, checked |
//! | [`tiles`], [`mod@merge`] | parts of one huge picture, and the whole |
//! | [`mod@join`] | frames on disk to a film |
//! | `writer` | the way to the thread that writes, and back |
//! | [`guard`] | what must not be written over |
//! | [`output`] | pictures to files, while the next frame is traced |
//! | [`memory`] | what this machine has |

pub mod changed;
pub mod engine;
pub mod event;
pub mod guard;
pub mod job;
pub mod join;
pub mod memory;
pub mod merge;
pub mod output;
mod pictures;
pub mod provenance;
pub mod resume;
pub mod reuse;
pub mod run;
mod tile;
pub mod tiles;
pub mod verify;
mod writer;

pub use changed::{Changed, Thing};
pub use engine::{Batch, Engine, EngineOptions};
pub use event::{Event, FrameReport, RenderError, Summary};
pub use guard::{Inputs, Refusal};
pub use job::{Draft, Job, Reuse};
pub use join::{JoinError, JoinEvent, JoinOptions, join};
pub use merge::{MergeError, Merged, merge};
pub use resume::{Resume, Standing};
pub use run::render;
pub use tiles::TileChoice;
pub use verify::{Checked, verify};
