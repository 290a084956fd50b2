//! All policy of re-use: what differs between two frames, and so what is done again.
//!
//! | what changed, by bits | what is done again |
//! | --- | --- |
//! | colours of materials or lights, settings that only shading reads | shading |
//! | a material began to reflect, more bounces, a longer path | levels below the nodes concerned |
//! | a light's place | its terms |
//! | a pattern's cells | the cells of nodes, and levels below |
//! | a surface | trees with a segment that touches its old or new box |
//! | eye, picture size, samples, filter, the number or kind of primitives | all |

use reflet_pack::{Changes, Columns, LightChange, LightId, MaterialId, SurfaceId, Volume};
use reflet_trace::{Grid, Moved, PatternCells, Revision, Trees};

/// What is done with the trees kept of the frame before.
#[derive(Debug)]
pub enum Plan {
    /// All trees are made from scratch, and why.
    Fresh(&'static str),
    /// They are brought up to date.
    Keep(Box<Keep>),
}

/// What of kept trees is done again.
#[derive(Debug, Default)]
pub struct Keep {
    /// Surfaces that moved; trees that they touch are made anew.
    pub moved: Option<Moved>,
    /// Light terms and cells.
    pub revision: Revision,
    woken: Vec<MaterialId>,
    /// Materials that cast a mirrored ray in one of the two frames only, ascending.
    toggled: Vec<MaterialId>,
    repainted: Vec<SurfaceId>,
    limits_grew: bool,
    limits_differ: bool,
    /// Materials whose numbers changed, ascending.
    recoloured: Vec<MaterialId>,
    /// Whether colours changed in which any node takes part.
    relit: bool,
}

/// What a set of kept trees was made for. Trees made for other limits may lack levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MadeFor {
    grid: Grid,
    surfaces: usize,
    prims: u32,
    tint_channels: usize,
    max_bounces: u32,
    max_path: f32,
}

impl MadeFor {
    /// What the trees of `columns` in `grid` are made for.
    pub fn of(columns: &Columns, grid: Grid) -> MadeFor {
        MadeFor {
            grid,
            surfaces: columns.surfaces.len(),
            prims: columns.geometry.prims(),
            tint_channels: columns.surfaces.tint_channels(),
            max_bounces: columns.model.max_bounces,
            max_path: columns.model.max_path,
        }
    }
}

/// More boxes than this touch so much that looking costs more than tracing.
const MOST_MOVED: usize = 24;

/// What has no volume of its own, in both frames.
const NOWHERE: (Volume, Volume) = (Volume::Nothing, Volume::Nothing);

impl Plan {
    /// What to do with trees made for `old` when the scene is now made for `new`.
    pub fn of(changes: &Changes, old: &MadeFor, new: &MadeFor) -> Plan {
        if changes.rebuilt {
            return Plan::Fresh("a surface consists of other primitives");
        }
        // A script cannot write the filter in a frame, so whoever reads this moved the camera.
        if changes.view || old.grid != new.grid {
            return Plan::Fresh("the camera moved");
        }
        if old.surfaces != new.surfaces || old.prims != new.prims {
            return Plan::Fresh("there are more or fewer surfaces");
        }
        if changes.samples {
            return Plan::Fresh("samples lie elsewhere");
        }
        if old.tint_channels != new.tint_channels {
            return Plan::Fresh("there are textures or shaders now, or none any more");
        }
        // The materials of one mesh are surfaces of one volume.
        let moved = changes.surfaces.iter();
        if moved.filter(|c| (c.old, c.new) != NOWHERE).count() > MOST_MOVED {
            return Plan::Fresh("very many surfaces moved");
        }
        let mut keep = Keep {
            woken: changes.woken.clone(),
            repainted: changes.repainted.clone(),
            toggled: changes.toggled().collect(),
            limits_differ: (new.max_bounces, new.max_path) != (old.max_bounces, old.max_path),
            limits_grew: new.max_bounces > old.max_bounces || new.max_path > old.max_path,
            recoloured: changes.materials.iter().map(|c| c.material).collect(),
            relit: changes.model || !changes.lights.is_empty(),
            ..Keep::default()
        };
        if !changes.surfaces.is_empty() {
            let seen = |v: &Volume| (*v != Volume::Nothing).then_some(*v);
            keep.moved = Some(Moved {
                surfaces: changes.surfaces.iter().map(|c| c.surface).collect(),
                old: changes.surfaces.iter().filter_map(|c| seen(&c.old)).collect(),
                new: changes.surfaces.iter().filter_map(|c| seen(&c.new)).collect(),
            });
        }
        if !changes.patterns.is_empty() {
            keep.revision.cells = PatternCells::Again;
        }
        keep.revision.relight = changes.lights.iter().filter_map(relit).collect();
        Plan::Keep(Box::new(keep))
    }
}

fn relit(change: &LightChange) -> Option<LightId> {
    match change {
        LightChange::Place(id) | LightChange::Added(id) | LightChange::Removed(id) => Some(*id),
        LightChange::Emissivity(_) => None,
    }
}

impl Keep {
    /// Whether every tree is walked again, for its light terms or cells.
    pub fn revises(&self) -> bool {
        !self.revision.relight.is_empty() || self.revision.cells == PatternCells::Again
    }

    /// Whether trees with this palette may lack levels now: a look at their nodes tells.
    pub fn may_deepen(&self, trees: &Trees, columns: &Columns) -> bool {
        let awake = |slot: &reflet_trace::palette::Slot| {
            self.woken.binary_search(&slot.material(columns)).is_ok()
                || self.repainted.binary_search(&slot.surface).is_ok()
        };
        self.limits_grew || trees.palette.iter().any(awake)
    }

    /// Whether nodes of trees with this palette may reflect now and did not before, or the reverse.
    pub fn toggles(&self, trees: &Trees, columns: &Columns) -> bool {
        let toggled = |slot: &reflet_trace::palette::Slot| {
            self.toggled.binary_search(&slot.material(columns)).is_ok()
                || self.repainted.binary_search(&slot.surface).is_ok()
        };
        self.limits_differ || trees.palette.iter().any(toggled)
    }

    /// Whether trees with this palette may have other colours now, even if they stayed as they are.
    pub fn recolours(&self, trees: &Trees, columns: &Columns) -> bool {
        let differs = |slot: &reflet_trace::palette::Slot| {
            self.recoloured.binary_search(&slot.material(columns)).is_ok()
                || self.repainted.binary_search(&slot.surface).is_ok()
        };
        self.relit || trees.palette.iter().any(differs)
    }
}
