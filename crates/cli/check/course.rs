//! What is known only of all frames together: lights and materials that stay 0, a picture that
//! stays empty, and frames that stay the same.

use super::colours::emissivity;
use super::findings::{Findings, Kind};
use super::sight::{Empty, GRID, Sight};
use reflet_pack::{Overrides, Packer, SceneHash};
use reflet_scene::{DVec3, Key, Material, Scene, Surface};
use reflet_script::Stage;
use std::collections::BTreeSet;

/// The frames so far.
pub struct Course {
    packer: Packer,
    first: Option<SceneHash>,
    frames: u32,
    /// Whether some frame differs from the first.
    moves: bool,
    /// Why nothing was in view so far, if so.
    empty: Option<Empty>,
    /// Lights, and materials that are worn, which were 0 so far.
    dark: BTreeSet<Key>,
    /// Those that were not.
    lit: BTreeSet<Key>,
}

impl Course {
    /// The frames of a scene; `None` if it has no camera.
    pub fn of(scene: &Scene) -> Option<Course> {
        let packer = Packer::new(scene, Overrides::default()).ok()?;
        let (dark, lit) = Default::default();
        Some(Course { packer, first: None, frames: 0, moves: false, empty: None, dark, lit })
    }

    /// The last frame's columns.
    pub fn columns(&self) -> &reflet_pack::Columns {
        self.packer.columns()
    }

    /// A frame.
    pub fn take(&mut self, scene: &Scene) {
        self.packer.update(scene);
        let hash = reflet_pack::SceneHasher::of(self.packer.columns());
        self.moves |= self.first.get_or_insert(hash) != &hash;
        if self.frames == 0 || self.empty.is_some() {
            self.empty = Sight::new(self.packer.columns()).and_then(|mut sight| sight.empty());
        }
        self.frames += 1;
        for key in scene.keys() {
            if let Some(emissivity) = emissivity(scene, key) {
                self.light(key, emissivity);
            }
            let surface = scene.get::<Surface>(key).filter(|surface| surface.visible);
            let Some(worn) = surface.and_then(|surface| surface.material) else { continue };
            if let Some(m) = scene.get::<Material>(worn) {
                self.light(worn, m.ambient.abs() + m.diffuse.abs() + m.specular.abs());
            }
        }
    }

    fn light(&mut self, key: Key, colour: DVec3) {
        if colour != DVec3::ZERO {
            self.dark.remove(&key);
            self.lit.insert(key);
        } else if !self.lit.contains(&key) {
            self.dark.insert(key);
        }
    }

    /// Whether frames that were not looked at could change what is found.
    pub fn open(&self) -> bool {
        !self.moves || self.empty.is_some() || !self.dark.is_empty()
    }

    /// What was found. `frames` is how many the animation has.
    pub fn tell(&self, stage: &Stage, frames: u32, findings: &mut Findings) {
        let course = match (frames, self.frames) {
            (1, _) => String::new(),
            (all, looked) if all == looked => format!(" in all {all} frames"),
            (all, looked) => format!(" in {looked} of {all} frames"),
        };
        for key in &self.dark {
            let name = stage.name_of(*key);
            let what = if stage.with_scene(|scene| scene.has::<Material>(*key)) {
                "is all 0, so that what wears it is black"
            } else {
                "has emissivity 0 and lights nothing"
            };
            findings.add(Kind::Dark, || format!("{name} {what}{course}"));
        }
        if let Some(empty) = self.empty {
            let why = match empty {
                Empty::NoSurface => "there is no visible surface".into(),
                Empty::Behind => "all surfaces lie behind the camera; look the other way".into(),
                Empty::Beside => format!(
                    "of {}x{} rays from the camera none hits a surface; look_at a surface",
                    GRID[0], GRID[1]
                ),
            };
            findings.add(Kind::View, || format!("nothing is in view{course}: {why}"));
        }
        let (moved_by, animated) = (
            stage.has_frame_functions(),
            stage.with_scene(|scene| scene.singletons.animation.is_some()),
        );
        if moved_by && !animated {
            findings.add(Kind::Frames, || {
                "there is an on_frame and no animation, so the scene is a still; write \
                 animation(#{ frames: 120, fps: 24 })"
                    .into()
            });
        } else if frames > 1 && !moved_by {
            findings.add(Kind::Frames, || {
                format!(
                    "the animation has {frames} frames and no on_frame, so they are all the same \
                     picture; write on_frame(|f| {{ ... }}), or leave animation out"
                )
            });
        } else if frames > 1 && !self.moves && frames == self.frames {
            findings.add(Kind::Frames, || {
                format!("on_frame changes nothing: all {frames} frames are the same picture")
            });
        }
    }
}
