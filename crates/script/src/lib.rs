//! Rhai writes the nouns.

mod capture;
mod engine;
mod error;
mod guard;
mod handle;
mod helpers;
mod locate;
mod maths;
mod mutation;
mod names;
mod nouns;
mod own_thread;
mod params;
mod parse;
mod random;
pub mod reference;
mod stage;
mod state;
mod table;
mod time;
mod trouble;
mod value;
mod vec3;

pub use error::{ErrorKind, Note, Place, ScriptError};
pub use params::Parameter;
pub use reference::reference;
pub use stage::{Options, Source, Stage, Warning};
