//! What differs from the frame before, by name.

use reflet_pack::materials::MaterialRow;
use reflet_pack::{Changes, Columns, LightChange, LightId, SurfaceId, Volume};
use reflet_scene::Key;
use reflet_script::Stage;

/// What differs from the frame before.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Changed {
    /// The first of them.
    pub things: Vec<Thing>,
    /// How many there are in all.
    pub count: usize,
}

/// One thing that changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Thing {
    /// Its name: what made it, and where.
    pub name: String,
    /// How it differs.
    pub how: &'static str,
}

/// No more than this many are named.
const NAMED: usize = 8;

impl Changed {
    /// Names the things of `changes`, which led to `columns`.
    pub(crate) fn of(changes: &Changes, columns: &Columns, stage: &Stage) -> Changed {
        let mut changed = Changed::default();
        let mut tell = |key: Option<Key>, else_name: &str, how: &'static str| {
            changed.count += 1;
            if changed.things.len() < NAMED {
                let name = key.map_or_else(|| else_name.to_owned(), |key| stage.name_of(key));
                changed.things.push(Thing { name, how });
            }
        };
        if changes.rebuilt {
            tell(None, "surfaces", "consist of other primitives");
        }
        if changes.view {
            tell(None, "camera", "moved");
        }
        if changes.samples {
            tell(None, "image", "samples");
        }
        if changes.model {
            tell(None, "settings", "changed");
        }
        let surface = |id: SurfaceId| columns.surfaces.key.get(id.index()).copied();
        for change in &changes.surfaces {
            let how = match (&change.old, &change.new) {
                (Volume::Nothing, _) => "appeared",
                (_, Volume::Nothing) => "vanished",
                _ => "moved",
            };
            tell(surface(change.surface), "surface", how);
        }
        for change in &changes.lights {
            let (id, how) = match *change {
                LightChange::Emissivity(id) => (id, "emissivity"),
                LightChange::Place(id) => (id, "moved"),
                LightChange::Added(id) => (id, "appeared"),
                LightChange::Removed(id) => (id, "vanished"),
            };
            let key = |id: LightId| columns.lights.key.get(id.index()).copied();
            tell(key(id), "light", how);
        }
        for id in &changes.patterns {
            tell(surface(*id), "surface", "another pattern");
        }
        for id in &changes.repainted {
            tell(surface(*id), "surface", "another material");
        }
        for change in &changes.materials {
            let casts = |m: &Option<MaterialRow>| m.is_some_and(|row| row.is_specular());
            let begins = casts(&change.new) && !casts(&change.old);
            let how = if begins { "reflects from now on" } else { "colours" };
            let key = columns.materials.key.get(change.material.index()).copied().flatten();
            tell(key, "material", how);
        }
        changed
    }
}
