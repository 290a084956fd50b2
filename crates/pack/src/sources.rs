//! Where the rows of surfaces come from: a surface by itself, or once more through an instance, each
//! put into the scene by the places above it.

use crate::parts::affine;
use glam::DAffine3;
use reflet_scene::{Group, Instance, Key, Place, Scene, Surface};
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// A place on the way from a surface to the scene, from the inside out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Step {
    pub place: Key,
    pub flag: Flag,
}

/// Whether a thing's own `visible` counts: a prototype may be hidden where only its copies are to
/// be seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flag {
    Counts,
    Ignored,
}

/// The surface that a row shows, and its way into the scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Source {
    pub surface: Key,
    pub flag: Flag,
    /// Empty for most.
    pub steps: Arc<[Step]>,
    /// Of a mesh that has several materials, the number of that which the row is of; the first row
    /// has the mesh's primitives.
    pub material: u32,
}

/// By row of surfaces: where it comes from.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sources(BTreeMap<usize, Source>);

impl Sources {
    /// Notes where the row of an entity comes from. Most are the entity itself, and take no room.
    pub fn note(&mut self, row: usize, key: Key, source: Source) {
        if source != Source::itself(key) {
            self.0.insert(row, source);
        }
    }

    /// Where the row of an entity comes from.
    pub fn of(&self, row: usize, key: Key) -> Source {
        self.0.get(&row).cloned().unwrap_or_else(|| Source::itself(key))
    }

    /// Forgets rows from `rows` on.
    pub fn truncate(&mut self, rows: usize) {
        self.0.split_off(&rows);
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.0.clear();
    }
}

/// The groups that things are in.
#[derive(Clone, Debug, Default)]
pub(crate) struct Parents(HashMap<Key, Key>);

impl Parents {
    /// Notes the members of a group.
    pub fn note(&mut self, key: Key, group: &Group) {
        self.0.extend(group.members.iter().map(|member| (*member, key)));
    }

    /// Forgets groups from `first` on.
    pub fn truncate(&mut self, first: u32) {
        self.0.retain(|_, group| group.0 < first);
    }

    /// The groups around a thing, from the inside out.
    fn around(&self, key: Key) -> impl Iterator<Item = Step> + '_ {
        let up = move |key: &Key| self.0.get(key).copied();
        std::iter::successors(up(&key), up).map(|place| Step { place, flag: Flag::Counts })
    }
}

/// What an entity shows, if it shows anything: itself, or all of what it is an instance of.
pub(crate) fn sources(scene: &Scene, parents: &Parents, key: Key) -> Vec<Source> {
    let mut out = Vec::new();
    if scene.has::<Surface>(key) {
        let steps = parents.around(key).collect();
        out.push(Source { surface: key, flag: Flag::Counts, steps, material: 0 });
    } else if scene.has::<Instance>(key) {
        let mut way = Vec::new();
        expand(scene, (key, Flag::Counts), &mut way, &mut out);
        let above: Vec<Step> = parents.around(key).collect();
        for source in &mut out {
            source.steps = source.steps.iter().chain(&above).copied().collect();
        }
    }
    out
}

/// Appends all that a thing shows. `way` is the way down to it, from the outside in.
fn expand(scene: &Scene, (thing, flag): (Key, Flag), way: &mut Vec<Step>, out: &mut Vec<Source>) {
    if scene.has::<Surface>(thing) {
        let steps = way.iter().rev().copied().collect();
        out.push(Source { surface: thing, flag, steps, material: 0 });
        return;
    }
    way.push(Step { place: thing, flag });
    if let Some(Instance { of }) = scene.get(thing) {
        expand(scene, (of, Flag::Ignored), way, out);
    } else if let Some(group) = scene.get::<Group>(thing) {
        for member in group.members.iter() {
            expand(scene, (*member, Flag::Counts), way, out);
        }
    }
    way.pop();
}

impl Source {
    /// An entity that shows itself, where it is.
    fn itself(key: Key) -> Source {
        Source { surface: key, flag: Flag::Counts, steps: Arc::default(), material: 0 }
    }

    /// How the places of now put it into the scene; `None` where nothing moves it.
    pub fn affine(&self, scene: &Scene) -> Option<DAffine3> {
        let mut all: Option<DAffine3> = None;
        for step in self.steps.iter() {
            let own = affine(&scene.get::<Place>(step.place).unwrap_or_default());
            all = Some(all.map_or(own, |inner| own * inner));
        }
        all
    }

    /// Whether it is in the picture.
    pub fn is_visible(&self, scene: &Scene) -> bool {
        let own = scene.get::<Surface>(self.surface).is_some_and(|s| s.visible);
        let above = |step: &Step| {
            step.flag == Flag::Ignored
                || scene.get::<Place>(step.place).is_some_and(|place| place.visible)
        };
        (self.flag == Flag::Ignored || own) && self.steps.iter().all(above)
    }
}
