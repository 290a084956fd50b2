//! A finished sequence, checked: which frames are what a render would make now.

use crate::event::RenderError;
use crate::job::Job;
use crate::provenance::Provenance;
use crate::resume::{self, Standing};
use crate::run;
use reflet_pack::SceneHasher;
use reflet_script::Stage;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

/// A frame's file, checked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Checked {
    /// Which frame.
    pub frame: u32,
    /// Its file.
    pub path: PathBuf,
    /// How it is found.
    pub standing: Standing,
}

/// Checks the files of the frames of `job`, and tells of each in order. No ray is cast.
///
/// # Errors
/// The script is wrong at a frame, or `cancel` was set.
pub fn verify(
    stage: &mut Stage,
    job: &Job,
    cancel: &AtomicBool,
    checked: &mut dyn FnMut(Checked),
) -> Result<(), RenderError> {
    let animation = stage.with_scene(|scene| scene.animation());
    let frames = job.frames.clone().unwrap_or_else(|| (0..animation.frames).collect());
    let mut packer = run::pack(stage, job)?;
    let tile = run::tile(&packer, job)?;
    let mut hasher = SceneHasher::default();
    for frame in frames {
        if cancel.load(Ordering::Relaxed) {
            return Err(RenderError::Cancelled);
        }
        stage.frame(frame).map_err(|error| run::script_error(Some(frame), error))?;
        let changes = stage.with_scene(|scene| packer.update(scene));
        let scene = hasher.hash(packer.columns(), &changes);
        let settings = run::settings(&packer, job, frame);
        let wanted = Provenance::new(scene, settings, tile.as_ref());
        let path = job.target.path_for(frame);
        let standing = resume::standing(&path, &wanted);
        checked(Checked { frame, path, standing });
    }
    Ok(())
}
