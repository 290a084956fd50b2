//! The world with its keys and its journal.

use crate::journal::{Noun, Old};
use crate::key::Key;
use crate::{Animation, Image, Settings};
use hecs::{DynamicBundle, Entity, World};

/// The entities of which a scene has at most one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Singletons {
    /// The entity with the [`Image`].
    pub image: Option<Key>,
    /// The entity with the [`Settings`].
    pub settings: Option<Key>,
    /// The entity with the [`crate::Camera`].
    pub camera: Option<Key>,
    /// The entity with the [`Animation`].
    pub animation: Option<Key>,
}

/// A scene: entities in a hecs world, in the order of their keys.
///
/// Until [`Scene::seal`] writes are plain. After it every write and every new entity is journaled,
/// [`Scene::rewind`] takes all of them back, and [`Scene::touched`] names them.
#[derive(Default)]
pub struct Scene {
    world: World,
    entities: Vec<Entity>,
    /// Which entities there is one of.
    pub singletons: Singletons,
    sealed: Option<u32>,
    journal: Vec<Old>,
}

impl Scene {
    /// An empty scene.
    pub fn new() -> Self {
        Self::default()
    }

    /// Makes an entity of `components`, with the next key.
    pub fn spawn(&mut self, components: impl DynamicBundle) -> Key {
        let key = Key(u32::try_from(self.entities.len()).expect("fewer than 2^32 entities"));
        self.entities.push(self.world.spawn(components));
        key
    }

    /// How many entities there are; their keys are `0..len`.
    pub fn len(&self) -> u32 {
        self.entities.len() as u32
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.entities.is_empty()
    }

    /// The keys of all entities, in order.
    pub fn keys(&self) -> impl ExactSizeIterator<Item = Key> + use<> {
        (0..self.len()).map(Key)
    }

    /// The component `C` of the entity, if it has one.
    pub fn get<C: Noun>(&self, key: Key) -> Option<C> {
        let entity = *self.entities.get(key.index())?;
        self.world.get::<&C>(entity).ok().map(|c| (*c).clone())
    }

    /// Whether the entity has a component `C`.
    pub fn has<C: Noun>(&self, key: Key) -> bool {
        self.entities.get(key.index()).is_some_and(|e| self.world.satisfies::<&C>(*e))
    }

    /// Writes the component `C` of an entity that has one; `false` if it has none.
    ///
    /// In a sealed scene the old value goes to the journal.
    pub fn set<C: Noun>(&mut self, key: Key, value: C) -> bool {
        let Some(entity) = self.entities.get(key.index()).copied() else { return false };
        let Ok(mut slot) = self.world.get::<&mut C>(entity) else { return false };
        let old = std::mem::replace(&mut *slot, value);
        drop(slot);
        if self.sealed.is_some() {
            self.journal.push(old.old(key));
        }
        true
    }

    pub(crate) fn overwrite<C: Noun>(&mut self, key: Key, value: C) {
        if let Ok(mut slot) = self.world.get::<&mut C>(self.entities[key.index()]) {
            *slot = value;
        }
    }

    /// The script has ended: from now on writes are journaled.
    pub fn seal(&mut self) {
        self.sealed = Some(self.len());
        self.journal.clear();
    }

    /// Whether [`Scene::seal`] was called.
    pub fn is_sealed(&self) -> bool {
        self.sealed.is_some()
    }

    /// How many entities the script itself made; those with later keys live for one frame.
    pub fn sealed_len(&self) -> u32 {
        self.sealed.unwrap_or(self.len())
    }

    /// Puts the scene back to what it was when it was sealed.
    pub fn rewind(&mut self) {
        let Some(base) = self.sealed else { return };
        for entity in self.entities.drain(base as usize..) {
            let _ = self.world.despawn(entity);
        }
        let journal = std::mem::take(&mut self.journal);
        for old in journal.into_iter().rev() {
            if old.key().0 < base {
                old.restore(self);
            }
        }
    }

    /// The keys of the script's own entities written since the scene was sealed or rewound,
    /// ascending, each once.
    pub fn touched(&self) -> Vec<Key> {
        let base = self.sealed_len();
        let mut keys: Vec<Key> = self.journal.iter().map(Old::key).filter(|k| k.0 < base).collect();
        keys.sort_unstable();
        keys.dedup();
        keys
    }

    /// The picture's size and samples, or the default.
    pub fn image(&self) -> Image {
        self.singletons.image.and_then(|k| self.get(k)).unwrap_or_default()
    }

    /// The settings, or the default.
    pub fn settings(&self) -> Settings {
        self.singletons.settings.and_then(|k| self.get(k)).unwrap_or_default()
    }

    /// The animation, or the default: one frame.
    pub fn animation(&self) -> Animation {
        self.singletons.animation.and_then(|k| self.get(k)).unwrap_or_default()
    }

    /// The hecs world, for `pack`, which reads it whole.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The entity of a key, for `pack`.
    pub fn entity(&self, key: Key) -> Option<Entity> {
        self.entities.get(key.index()).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DVec3, Material, Sphere};

    #[test]
    fn rewind_puts_back_values_and_drops_what_a_frame_made() {
        let mut scene = Scene::new();
        let ball = scene.spawn((Sphere { center: DVec3::ZERO, radius: 1.0 },));
        let paint = scene.spawn((Material::default(),));
        scene.seal();
        for _ in 0..3 {
            scene.set(ball, Sphere { center: DVec3::ONE, radius: 2.0 });
            scene.set(ball, Sphere { center: DVec3::X, radius: 3.0 });
            let made = scene.spawn((Material::GREY_MATT,));
            assert_eq!(made, Key(2));
            scene.set(made, Material::default());
            assert_eq!(scene.touched(), vec![ball]);
            scene.rewind();
            assert_eq!(scene.len(), 2);
            assert_eq!(scene.get::<Sphere>(ball).unwrap().radius, 1.0);
            assert!(scene.touched().is_empty());
        }
        assert!(!scene.set(paint, Sphere { center: DVec3::ZERO, radius: 1.0 }));
    }
}
