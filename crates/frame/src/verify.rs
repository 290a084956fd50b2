//! A finished sequence, checked: which frames are what a render would make now.

use crate::event::RenderError;
use crate::job::Job;
use crate::provenance::{FilmHasher, Provenance};
use crate::resume::{self, Standing};
use crate::run;
use reflet_pack::SceneHasher;
use reflet_script::Stage;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

/// A file, checked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Checked {
    /// The frames in it: one, or all of a film.
    pub frames: Vec<u32>,
    /// The file.
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
    if job.target.format().is_film() {
        let standing = film(stage, job, cancel)?;
        let path = job.target.path_for(0);
        checked(Checked { frames: run::frames(stage, job), path, standing });
        return Ok(());
    }
    each(stage, job, cancel, &mut |frame, wanted| {
        let path = job.target.path_for(frame);
        let standing = resume::standing(&path, &wanted);
        checked(Checked { frames: vec![frame], path, standing });
    })
}

/// How the film that `job` makes is found. The script runs through all frames only if the film is
/// whole and of the right kind.
///
/// # Errors
/// Like [`verify`].
pub(crate) fn film(
    stage: &mut Stage,
    job: &Job,
    cancel: &AtomicBool,
) -> Result<Standing, RenderError> {
    let path = job.target.path_for(0);
    let texts = match resume::told(&path) {
        Ok(texts) => texts,
        Err(standing) => return Ok(standing),
    };
    let mut hasher = FilmHasher::default();
    let mut size = [0, 0];
    each(stage, job, cancel, &mut |_, wanted| {
        size = wanted.size();
        hasher.push(&wanted);
    })?;
    let fps = run::fps(stage)?;
    let wanted = hasher.film(run::film_settings(job, size, fps));
    Ok(wanted.differs(&texts).map_or(Standing::Stands, Standing::Stale))
}

/// Tells what each frame would be made from now.
fn each(
    stage: &mut Stage,
    job: &Job,
    cancel: &AtomicBool,
    tell: &mut dyn FnMut(u32, Provenance),
) -> Result<(), RenderError> {
    let mut packer = run::pack(stage, job)?;
    let tile = run::tile(&packer, job)?;
    let mut hasher = SceneHasher::default();
    for frame in run::frames(stage, job) {
        if cancel.load(Ordering::Relaxed) {
            return Err(RenderError::Cancelled);
        }
        stage.frame(frame).map_err(|error| run::script_error(Some(frame), error))?;
        let changes = stage.with_scene(|scene| packer.update(scene));
        let scene = hasher.hash(packer.columns(), &changes);
        let settings = run::settings(&packer, job, frame);
        tell(frame, Provenance::new(scene, settings, tile.as_ref()));
    }
    Ok(())
}
