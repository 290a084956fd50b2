//! Groups and instances: makers that take things.

use crate::handle::Handle;
use crate::nouns::{GROUP, INSTANCE};
use crate::parse;
use crate::state::{Phase, Shared, State};
use crate::table::{Form, Kind, Role};
use crate::trouble::{Fallible, Trouble, trouble};
use crate::value::describe;
use reflet_scene::{Group, Instance, Key, Mesh, Place};
use rhai::{Array, Dynamic, Engine, Map, NativeCallContext, Position};
use std::collections::{BTreeMap, HashSet};

/// The most shapes that instances may show, a mesh counted once: each takes about 300 bytes, some
/// GB in all.
const MOST: u64 = 20_000_000;

/// The most triangles that instances of meshes may show. None of them is stored, but each has a
/// number.
const MOST_TRIANGLES: u64 = 2_000_000_000;

/// How much a thing shows.
#[derive(Clone, Copy, Default)]
struct Shown {
    /// Shapes, and meshes.
    shapes: u64,
    /// The meshes' triangles.
    triangles: u64,
}

impl Shown {
    /// Both together.
    fn and(self, other: Shown) -> Shown {
        Shown {
            shapes: self.shapes.saturating_add(other.shapes),
            triangles: self.triangles.saturating_add(other.triangles),
        }
    }

    /// `self` without what it has of `other`.
    fn less(self, other: Shown) -> Shown {
        Shown {
            shapes: self.shapes.saturating_sub(other.shapes),
            triangles: self.triangles.saturating_sub(other.triangles),
        }
    }
}

/// How deep groups and instances may be nested.
const DEEPEST: u32 = 256;

/// What is known of groups and instances.
#[derive(Default)]
pub(crate) struct Placed {
    /// The group that a thing is in, and the line where that was made.
    groups: BTreeMap<Key, (Key, usize)>,
    /// How much groups and instances show.
    shown: BTreeMap<Key, Shown>,
    /// How much all instances show.
    total: Shown,
    /// How deep each is nested; 0 for what is not in here.
    depth: BTreeMap<Key, u32>,
}

impl Placed {
    /// Forgets what was made from `first` on.
    pub fn truncate(&mut self, first: Key) {
        self.groups.retain(|_, (group, _)| *group < first);
        self.depth.split_off(&first);
        for (_, shown) in self.shown.split_off(&first) {
            self.total = self.total.less(shown);
        }
    }
}

impl State {
    /// `group([a, b], #{...})`.
    fn group(&mut self, given: &Array, map: &Map, call: Position) -> Fallible<Handle> {
        let mut members = Vec::with_capacity(given.len());
        let mut joined = HashSet::with_capacity(given.len());
        for (i, value) in given.iter().enumerate() {
            let key = self.thing(value).map_err(|what| {
                trouble(format!(
                    "`group` takes an array of surfaces, groups and instances, got {what} at {i}"
                ))
            })?;
            let of_script = self.scene.is_sealed() && key.0 < self.scene.sealed_len();
            if self.phase == Phase::Frame && of_script {
                return Err(trouble(format!(
                    "what the script made cannot join a group in a frame: make the group in the script, and move it here ({} at {i})",
                    describe(value)
                )));
            }
            if let Some((_, line)) = self.placed.groups.get(&key) {
                return Err(trouble(format!(
                    "{} at {i} is in the group of line {line} already: a thing is in one group at most; an instance of it can be in another",
                    describe(value)
                )));
            }
            if !joined.insert(key) {
                return Err(trouble(format!("{} at {i} is in the array twice", describe(value))));
            }
            members.push(key);
        }
        let shown = members.iter().map(|key| self.shown_by(*key));
        let shown = shown.fold(Shown::default(), Shown::and);
        let depth = self.depth_above(&members)?;
        let place = self.place(&GROUP, map, call)?;
        let group = Group { members: members.clone().into() };
        let key = self.scene.spawn((place, group));
        let line = call.line().unwrap_or_default();
        self.origins.note(key, line);
        self.placed.groups.extend(members.into_iter().map(|member| (member, (key, line))));
        self.placed.shown.insert(key, shown);
        self.placed.depth.insert(key, depth);
        Ok(self.handle(key, Kind(&GROUP)))
    }

    /// `instance(thing, #{...})`.
    fn instance(&mut self, thing: &Dynamic, map: &Map, call: Position) -> Fallible<Handle> {
        let of = self.thing(thing).map_err(|what| {
            trouble(format!("`instance` takes a surface, a group or an instance, got {what}"))
        })?;
        let shown = self.shown_by(of);
        let total = self.placed.total.and(shown);
        if total.shapes > MOST {
            return Err(trouble(format!(
                "the scene's instances would show more than {MOST} shapes: make fewer, or of less"
            )));
        }
        if total.triangles > MOST_TRIANGLES {
            return Err(trouble(format!(
                "the scene's instances would show more than {MOST_TRIANGLES} triangles: make fewer, or of a smaller mesh"
            )));
        }
        let depth = self.depth_above(&[of])?;
        let place = self.place(&INSTANCE, map, call)?;
        let key = self.scene.spawn((place, Instance { of }));
        self.origins.note(key, call.line().unwrap_or_default());
        self.placed.total = total;
        self.placed.shown.insert(key, shown);
        self.placed.depth.insert(key, depth);
        Ok(self.handle(key, Kind(&INSTANCE)))
    }

    fn place(
        &mut self,
        form: &'static Form<Place>,
        map: &Map,
        call: Position,
    ) -> Result<Place, Trouble> {
        let values = parse::values(self, form, map, call)?;
        let filled = form.fill(values);
        filled
            .map(|(place, _)| place)
            .map_err(|fault| Trouble::with_key(fault.property, fault.to_string()))
    }

    /// The key of what can be moved, or in words what was given instead.
    fn thing(&self, value: &Dynamic) -> Result<Key, String> {
        let Some(handle) = value.read_lock::<Handle>().map(|handle| *handle) else {
            return Err(describe(value));
        };
        let what = handle.kind.with_article();
        if self.alive(handle.key, handle.epoch, &what).is_err() {
            return Err(format!("{what} of an earlier frame"));
        }
        match handle.kind.0.role() {
            Role::Surface | Role::Group | Role::Instance => Ok(handle.key),
            _ => Err(what),
        }
    }

    /// How deep a group or an instance of these would be nested.
    fn depth_above(&self, things: &[Key]) -> Fallible<u32> {
        let depths = things.iter().filter_map(|key| self.placed.depth.get(key).copied());
        match depths.max().unwrap_or_default() + 1 {
            depth if depth <= DEEPEST => Ok(depth),
            _ => Err(trouble(format!(
                "groups and instances are nested more than {DEEPEST} deep: make them of what is inside"
            ))),
        }
    }

    /// How much a thing shows.
    fn shown_by(&self, key: Key) -> Shown {
        let own = || {
            let mesh = self.scene.get::<Mesh>(key);
            let triangles = mesh.map_or(0, |mesh| mesh.data.triangles.len() as u64);
            Shown { shapes: 1, triangles }
        };
        self.placed.shown.get(&key).copied().unwrap_or_else(own)
    }
}

/// Registers both makers, with and without a map.
pub(crate) fn register(engine: &mut Engine, state: &Shared) {
    let shared = state.clone();
    engine.register_fn(
        "group",
        move |ctx: NativeCallContext, members: Array| -> Fallible<Handle> {
            let mut state = shared.lock();
            let meter = state.meter.clone();
            meter.scene(|| state.group(&members, &Map::new(), ctx.call_position()))
        },
    );
    let shared = state.clone();
    engine.register_fn(
        "group",
        move |ctx: NativeCallContext, members: Array, map: Map| -> Fallible<Handle> {
            let mut state = shared.lock();
            let meter = state.meter.clone();
            meter.scene(|| state.group(&members, &map, ctx.call_position()))
        },
    );
    let shared = state.clone();
    engine.register_fn(
        "instance",
        move |ctx: NativeCallContext, thing: Dynamic| -> Fallible<Handle> {
            let mut state = shared.lock();
            let meter = state.meter.clone();
            meter.scene(|| state.instance(&thing, &Map::new(), ctx.call_position()))
        },
    );
    let shared = state.clone();
    engine.register_fn(
        "instance",
        move |ctx: NativeCallContext, thing: Dynamic, map: Map| -> Fallible<Handle> {
            let mut state = shared.lock();
            let meter = state.meter.clone();
            meter.scene(|| state.instance(&thing, &map, ctx.call_position()))
        },
    );
}
