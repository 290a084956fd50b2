//! `on_frame`, and what a frame function is told.

use crate::names;
use crate::state::Shared;
use crate::trouble::{Fallible, trouble};
use crate::value::{describe, takes_one};
use reflet_scene::Animation;
#[allow(deprecated)] // "volatile", says Rhai of storing a context; its version is pinned.
use rhai::NativeCallContextStore;
use rhai::{Dynamic, Engine, EvalAltResult, FnPtr, NativeCallContext, Position};

/// A frame function: the closure, and the surroundings in which it was registered.
#[allow(deprecated)]
pub(crate) struct FrameFn {
    pub function: FnPtr,
    context: NativeCallContextStore,
}

#[allow(deprecated)]
impl FrameFn {
    /// Calls it in its surroundings: without them it would see no `global::NAME`.
    pub fn call(&self, engine: &Engine, moment: Moment) -> Result<(), Box<EvalAltResult>> {
        let context = self.context.create_context(engine);
        self.function.call_raw(&context, None, [Dynamic::from(moment)]).map(|_| ())
    }

    /// Where `on_frame` was called.
    pub fn place(&self) -> Position {
        self.context.pos
    }

    /// The function, and the values of the `global::NAME` constants that it sees.
    pub fn roots(&self) -> Vec<Dynamic> {
        let mut roots = vec![Dynamic::from(self.function.clone())];
        if let Some(constants) = &self.context.global.constants
            && let Ok(constants) = constants.read()
        {
            roots.extend(constants.values().cloned());
        }
        roots
    }
}

/// The moment that a frame shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moment {
    /// From 0.
    pub index: u32,
    pub animation: Animation,
}

/// The properties of a moment.
pub(crate) const PROPERTIES: &[(&str, &str)] = &[
    ("index", "the frame's number, 0 to frames - 1"),
    ("t", "index / (frames - 1), from 0 to 1; 0 if there is one frame"),
    ("phase", "index / frames, from 0 to below 1: what a loop needs"),
    ("time", "index / fps, in seconds"),
    ("frames", "the number of frames"),
    ("fps", "frames a second"),
];

impl Moment {
    fn get(self, name: &str) -> Fallible<Dynamic> {
        let Animation { frames, fps } = self.animation;
        let index = f64::from(self.index);
        Ok(match name {
            "index" => i64::from(self.index).into(),
            "t" if frames < 2 => 0.0.into(),
            "t" => (index / f64::from(frames - 1)).into(),
            "phase" => (index / f64::from(frames)).into(),
            "time" => (index / fps).into(),
            "frames" => i64::from(frames).into(),
            "fps" => fps.into(),
            _ => {
                let known: Vec<&str> = PROPERTIES.iter().map(|p| p.0).collect();
                return Err(trouble(format!(
                    "a frame has no `{name}`{}",
                    names::offer(name, "has", &known)
                )));
            }
        })
    }
}

/// Registers the type and `on_frame`.
#[allow(deprecated)]
pub(crate) fn register(engine: &mut Engine, state: &Shared) {
    engine.register_type_with_name::<Moment>("frame");
    for &(name, _) in PROPERTIES {
        engine.register_get(name, move |moment: &mut Moment| moment.get(name));
    }
    engine.register_indexer_get(|moment: &mut Moment, name: &str| moment.get(name));
    engine.register_indexer_set(|_: &mut Moment, name: &str, _: Dynamic| -> Fallible<()> {
        Err(trouble(format!("`{name}` of a frame cannot be written")))
    });
    let shared = state.clone();
    engine.register_fn(
        "on_frame",
        move |ctx: NativeCallContext, function: Dynamic| -> Fallible<()> {
            let mut state = shared.lock();
            state.script_only("on_frame")?;
            let words = describe(&function);
            let function = function.try_cast::<FnPtr>().ok_or_else(|| {
                trouble(format!("`on_frame` takes a function |f| {{ ... }}, got {words}"))
            })?;
            if !takes_one(&ctx, &function) {
                return Err(trouble(
                    "`on_frame` takes a function with one parameter: on_frame(|f| { ... })",
                ));
            }
            let context = ctx.store_data();
            state.frame_functions.push(FrameFn { function, context });
            Ok(())
        },
    );
}
