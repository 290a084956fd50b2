//! Rhai writes the nouns: scene scripts to a [`reflet_scene::Scene`], once and then frame by frame.
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use reflet_script::{Options, Source, Stage};
//!
//! let text = "
//!     camera(#{ eye: [0, 2, 8], look_at: [0, 1, 0] });
//!     light(#{ at: [4, 6, 3], emissivity: 30 });
//!     let chrome = material(#{ diffuse: 0.2 });
//!     sphere(#{ center: [0, 1, 0], radius: 1, material: chrome });
//!     animation(#{ frames: 5 });
//!     on_frame(|f| { chrome.specular = f.t; });
//! ";
//! let source = Source { path: "chrome.rhai".into(), text: text.into() };
//! let mut stage = Stage::load(source, &Options::default())?;
//! stage.frame(3)?;
//! assert_eq!(stage.with_scene(|scene| scene.touched().len()), 1);
//! # Ok(()) }
//! ```
//!
//! This crate is the only one that names rhai. Its rooms, from the outside in:
//!
//! | room | holds |
//! | --- | --- |
//! | `source` | from bytes to text |
//! | `stage` | a script that has run once, and its frames |
//! | `own_thread`, `meter` | the thread it runs on, the watch over it, and what it may take |
//! | `engine`, `guard` | what of Rhai scripts can reach, and its limits |
//! | `nouns`, `shapes`, `table` | the one table of makers and keys; a new shape is one entry |
//! | `parse`, `state`, `handle` | from maps to nouns, from handles to properties |
//! | `placed` | groups and instances |
//! | `wardrobe` | the materials of mesh files |
//! | `uvs` | whether a mesh has the texture coordinates that it is asked for |
//! | `origins` | where each thing was made, so that it can be named |
//! | `time`, `capture`, `mutation` | frames, and putting captured variables back |
//! | `escape` | closures that outlive their turn of a loop |
//! | `operators`, `vec3`, `maths`, `angles`, `helpers`, `random`, `params` | what scripts calculate with |
//! | `symbolic` | shader functions, recorded |
//! | `trouble`, `locate`, `error`, `names`, `habits`, `messages` | what is wrong, where, what was meant, and how it is shown |
//! | [`reference`](mod@reference) | the language as data |
//!
//! What follows is the manual of the language.
//!
#![doc = include_str!("../MANUAL.md")]

mod angles;
mod capture;
mod engine;
mod error;
mod escape;
mod guard;
mod habits;
mod handle;
mod helpers;
mod locate;
mod maths;
mod messages;
mod meter;
mod mutation;
mod names;
mod nouns;
mod operators;
mod origins;
mod own_thread;
mod params;
mod parse;
mod placed;
mod random;
pub mod reference;
mod shapes;
mod source;
mod stage;
mod state;
mod symbolic;
mod table;
mod time;
mod trouble;
mod uvs;
mod value;
mod vec3;
mod wardrobe;

pub use engine::Printer;
pub use error::{ErrorKind, Note, Place, ScriptError};
pub use meter::Heap;
pub use params::{Domain, Parameter, Setting};
pub use reference::reference;
pub use source::Source;
pub use stage::{Options, Stage, Told, Warning};
