//! The materials of a mesh's file, as a script sees them: by name.

use crate::handle::Handle;
use crate::names;
use crate::nouns::MATERIAL;
use crate::parse;
use crate::state::{Shared, State};
use crate::table::{Kind, Value};
use crate::trouble::{Fallible, Trouble, trouble};
use reflet_scene::{Key, Mesh, Worn};
use rhai::{Array, Dynamic, Engine, ImmutableString, NativeCallContext, Position};

/// What the property `materials` of a mesh reads as.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Wardrobe(pub Handle);

impl State {
    /// The mesh whose materials they are.
    fn dressed(&self, of: Wardrobe) -> Fallible<Mesh> {
        self.alive(of.0.key, of.0.epoch, "the mesh of these materials")?;
        Ok(self.scene.get::<Mesh>(of.0.key).unwrap_or_else(|| unreachable!("only meshes have any")))
    }

    /// What stands for a material.
    fn worn(&self, of: Wardrobe, name: &str) -> Fallible<Key> {
        let mesh = self.dressed(of)?;
        match mesh.worn_by(name) {
            Some(material) => Ok(material),
            None => {
                let known: Vec<&str> =
                    mesh.data.materials.iter().map(|own| &own.name[..]).collect();
                let offer = names::offer(name, "has", &known);
                Err(trouble(format!("the mesh's file has no material `{name}`{offer}")))
            }
        }
    }

    /// Puts a material in the place of one.
    fn wear(&mut self, of: Wardrobe, name: &str, to: &Dynamic, place: Position) -> Fallible<()> {
        let before = self.worn(of, name)?;
        let material = parse::one_worn(self, of.0.kind, to, place)?;
        // `car.materials.paint.diffuse = 1` writes the same material back.
        if material != before {
            let mut mesh = self.dressed(of)?;
            mesh.wear(vec![Worn { name: name.to_owned(), material }]);
            self.scene.set(of.0.key, mesh);
            self.note_written(of.0.key, of.0.kind, place);
        }
        Ok(())
    }

    /// Names and materials, in the order of the file.
    fn all_worn(&self, of: Wardrobe) -> Fallible<Vec<(ImmutableString, Handle)>> {
        let mesh = self.dressed(of)?;
        let names = mesh.data.materials.iter().enumerate();
        let handle = |key| self.handle(key, Kind(&MATERIAL));
        let worn = names.filter_map(|(i, own)| {
            mesh.worn_for(i).map(|key| (own.name.as_str().into(), handle(key)))
        });
        Ok(worn.collect())
    }
}

/// Registers the type.
pub(crate) fn register(engine: &mut Engine, state: &Shared) {
    engine.register_type_with_name::<Wardrobe>("materials of a mesh");
    let shared = state.clone();
    engine.register_indexer_get(move |of: &mut Wardrobe, name: &str| -> Fallible<Handle> {
        let state = shared.lock();
        state.worn(*of, name).map(|key| state.handle(key, Kind(&MATERIAL)))
    });
    let shared = state.clone();
    engine.register_indexer_set(
        move |ctx: NativeCallContext, of: &mut Wardrobe, name: &str, to: Dynamic| -> Fallible<()> {
            shared.lock().wear(*of, name, &to, ctx.call_position())
        },
    );
    let shared = state.clone();
    engine.register_fn("keys", move |of: &mut Wardrobe| -> Fallible<Array> {
        Ok(shared.lock().all_worn(*of)?.into_iter().map(|(name, _)| name.into()).collect())
    });
    let shared = state.clone();
    engine.register_fn("values", move |of: &mut Wardrobe| -> Fallible<Array> {
        let worn = shared.lock().all_worn(*of)?;
        Ok(worn.into_iter().map(|(_, handle)| Dynamic::from(handle)).collect())
    });
    let shared = state.clone();
    engine.register_fn("len", move |of: &mut Wardrobe| -> Fallible<i64> {
        Ok(shared.lock().all_worn(*of)?.len() as i64)
    });
}

/// What is written to `materials`: others for some of the file's.
pub(crate) fn given(
    state: &mut State,
    kind: Kind,
    given: &Dynamic,
    call: Position,
) -> Option<Result<Value, Trouble>> {
    if let Some(Wardrobe(of)) = given.read_lock::<Wardrobe>().map(|worn| *worn) {
        let worn = state.scene.get::<Mesh>(of.key).map(|mesh| mesh.worn.to_vec());
        return Some(Ok(Value::Wardrobe(worn.unwrap_or_default())));
    }
    let map = given.as_map_ref().ok()?;
    let one = |(name, value): (&rhai::Identifier, &Dynamic)| {
        let material = parse::one_worn(state, kind, value, call)?;
        Ok(Worn { name: name.to_string(), material })
    };
    Some(map.iter().map(one).collect::<Result<Vec<Worn>, _>>().map(Value::Wardrobe))
}
