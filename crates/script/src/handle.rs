//! Handles: what makers return, and their properties.

use crate::state::{Shared, record_function};
use crate::table::Kind;
use crate::trouble::Fallible;
use reflet_scene::Key;
use rhai::{Dynamic, Engine, NativeCallContext};

/// What a script holds of an entity: its key and its kind, never the entity itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Handle {
    pub key: Key,
    pub kind: Kind,
    /// The frame call in which it was made; 0 is the script itself.
    pub epoch: u64,
}

/// Registers the type and one property for every key of the table.
pub(crate) fn register(engine: &mut Engine, state: &Shared) {
    engine.register_type_with_name::<Handle>("handle");
    let mut names: Vec<&'static str> =
        crate::nouns::FORMS.iter().flat_map(|f| f.keys()).map(|k| k.name).collect();
    names.sort_unstable();
    names.dedup();
    for name in names {
        let shared = state.clone();
        engine.register_get(name, move |handle: &mut Handle| -> Fallible<Dynamic> {
            shared.lock().get(*handle, name)
        });
        let shared = state.clone();
        engine.register_set(
            name,
            move |ctx: NativeCallContext, handle: &mut Handle, to: Dynamic| -> Fallible<()> {
                let to = record_function(&ctx, handle.kind.0, name, to)?;
                shared.lock().set(*handle, name, to, ctx.call_position())
            },
        );
    }
    // The fallback for names that no noun has.
    let shared = state.clone();
    engine.register_indexer_get(move |handle: &mut Handle, name: &str| -> Fallible<Dynamic> {
        shared.lock().get(*handle, name)
    });
    let shared = state.clone();
    engine.register_indexer_set(
        move |ctx: NativeCallContext,
              handle: &mut Handle,
              name: &str,
              to: Dynamic|
              -> Fallible<()> { shared.lock().set(*handle, name, to, ctx.call_position()) },
    );
    engine.register_fn("==", |a: Handle, b: Handle| a == b);
    engine.register_fn("!=", |a: Handle, b: Handle| a != b);
    engine.register_fn("to_string", |h: &mut Handle| h.kind.with_article());
    engine.register_fn("to_debug", |h: &mut Handle| h.kind.with_article());
}
