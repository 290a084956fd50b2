//! The stages in order.

use crate::changed::Changed;
use crate::engine::{Batch, Engine, EngineOptions, Work, nanoseconds};
use crate::event::{Event, Events, FrameReport, RenderError, Summary};
use crate::guard::Inputs;
use crate::job::{Draft, Job, Reuse};
use crate::memory;
use crate::output::{FilmInfo, Finished, Output};
use crate::pictures::Pictures;
use crate::provenance::{FileSettings, FilmSettings, Provenance};
use crate::resume::{self, Resume, Standing};
use crate::tiles::Tile;
use crate::verify;
use crate::writer::Writer;
use reflet_film::{Fps, Layout, SampleKind, Transfer, TransferTable};
use reflet_pack::{Changes, Filter, Overrides, Packer, SceneHasher, TransferCurve};
use reflet_script::{ScriptError, Stage};
use reflet_trace::BatchColours;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::thread;
use std::time::Instant;

/// Renders the frames of `job`. Frames are written in order; when the job ends early, those before
/// stand, and nothing else of it stays.
///
/// `cancel` may be set at any time: the job ends within a tile.
pub fn render(
    stage: &mut Stage,
    job: &Job,
    cancel: &AtomicBool,
    events: &mut (dyn FnMut(Event<'_>) + Send),
) -> Result<Summary, RenderError> {
    let events = &Events::to(events);
    for warning in stage.warnings() {
        events.tell(Event::Warning(&warning.to_string()));
    }

    let frames = frames(stage, job);
    let inputs = stage.inputs();
    let refused = RenderError::Refused;
    Inputs::of(&inputs).spare_by(&job.target, &frames).map_err(refused)?;
    let film = job.target.format().is_film();
    if film && !job.target.is_stdout() && job.resume == Resume::Keep {
        let path = &job.target.path_for(0);
        match verify::film(stage, job, cancel)? {
            Standing::Stands => {
                sweep(job, &frames, events)?;
                events.tell(Event::FilmKept { path, frames: frames.len() });
                return Ok(Summary { kept: frames.len() as u64, ..Summary::default() });
            }
            standing => events.tell(Event::FilmAgain { path, standing: &standing }),
        }
    }
    let cache_bytes =
        job.cache_bytes.or_else(|| memory::available().map(|a| a / 4)).unwrap_or(1 << 30);
    // Nothing builds on the last frame.
    let reuse = if frames.len() > 1 { job.reuse } else { Reuse::Never };
    let packer = pack(stage, job)?;
    let tile = tile(&packer, job)?;
    let size = tile.map_or(packer.columns().view.size, |tile| tile.size);
    let origin = tile.map_or([0, 0], |tile| tile.origin);
    let options = EngineOptions {
        threads: job.threads,
        isa: job.isa,
        reuse,
        origin,
        ..EngineOptions::default()
    };
    let mut engine = Engine::new(options).map_err(RenderError::Other)?;
    let kind = job.target.format().sample_kind();
    let edge = engine.grid(packer.columns()).edge;
    let layout =
        Layout::try_new(size[0], size[1], edge).map_err(|e| RenderError::Other(e.to_string()))?;
    let ahead = if reuse == Reuse::Never { 1 } else { frames.len() };
    let pictures = Pictures::new(layout, kind, ahead, cache_bytes)?;
    engine.set_tree_budget(cache_bytes.saturating_sub(pictures.bytes()));
    let settings = film_settings(job, size, fps(stage)?);
    let transfer = curve(packer.columns().model.transfer);
    let info = FilmInfo { settings, frames: frames.len() as u32, transfer };

    let begin = Instant::now();
    let (isa, threads) = (engine.isa(), engine.threads());
    events.tell(Event::Started { frames: frames.len(), size, isa, threads });
    let pool = engine.pool();
    if job.resume == Resume::Keep {
        sweep(job, &frames, events)?;
    }
    let output = Output::open(job.target.clone(), info, &pool);
    let mut output = output.map_err(|failed| at_first(&frames, failed))?;
    output.warnings().iter().for_each(|warning| events.tell(Event::Warning(warning)));

    let result = thread::scope(|scope| {
        let (finished, to_write) = channel::<Finished>();
        let (report, written) = channel::<Result<Finished, RenderError>>();
        let output = &mut output;
        let write = move || {
            for mut frame in to_write {
                let result = output.write(&mut frame).map(|()| frame);
                // Told at once, even if the script is busy with a frame that comes later.
                if let Ok(frame) = &result {
                    events.tell(Event::Frame(&frame.report));
                }
                let failed = result.is_err();
                if report.send(result).is_err() || failed {
                    return;
                }
            }
        };
        thread::Builder::new()
            .name("write".into())
            .spawn_scoped(scope, write)
            .map_err(|e| RenderError::Other(format!("cannot start a thread: {e}")))?;
        let summary = Summary { isa, threads, ..Summary::default() };
        let writer = Writer { finished, written, under_way: 0, summary, events };
        let hasher = SceneHasher::default();
        let run = Run {
            job,
            engine,
            packer,
            hasher,
            tile,
            pictures,
            table: None,
            kind,
            writer,
            cancel,
            inputs: inputs.len(),
        };
        run.frames(stage, &frames)
    });
    // Files of frames that were written stand, whatever ended the job.
    match result {
        Ok(mut summary) => {
            let ended = output.finish(&frames)?;
            summary.bytes = ended.film.unwrap_or(summary.bytes);
            if ended.stood {
                summary.remade = summary.frames;
            }
            summary.elapsed_ns = nanoseconds(begin);
            Ok(summary)
        }
        Err(error) => {
            if !film {
                let _ = output.finish(&[]);
            }
            Err(error)
        }
    }
}

/// A job under way: all that outlives a frame.
struct Run<'a, 'e> {
    job: &'a Job,
    engine: Engine,
    packer: Packer,
    hasher: SceneHasher,
    tile: Option<Tile>,
    pictures: Pictures,
    table: Option<TransferTable>,
    kind: SampleKind,
    writer: Writer<'e>,
    cancel: &'a AtomicBool,
    /// Files that were read so far.
    inputs: usize,
}

/// A frame that was packed and waits to be shaded.
struct Waiting {
    report: FrameReport,
    provenance: Option<Provenance>,
    fate: Fate,
}

/// What becomes of a frame once it is shaded.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Fate {
    Written,
    /// Its file stands. It is shaded only because frames that waited share their columns with it.
    Dropped,
}

/// Frames that were packed and wait to be shaded together: their ray trees are the same.
#[derive(Default)]
struct Pending {
    frames: Vec<Waiting>,
    /// What differs between the last frame shaded and the first of these; `None` at the very first,
    /// and after frames that were kept.
    changes: Option<Changes>,
    colours: BatchColours,
}

/// Colours that wait take no more bytes than this: with very many materials, batches are short.
const MOST_COLOURS: u64 = 64 << 20;

impl Pending {
    fn holds(&self, frames: usize) -> bool {
        self.frames.len() >= frames || self.colours.bytes() > MOST_COLOURS
    }
}

impl Run<'_, '_> {
    fn frames(mut self, stage: &mut Stage, frames: &[u32]) -> Result<Summary, RenderError> {
        let result = self.frame_by_frame(stage, frames);
        // Whatever ended the loop, the frames before are written.
        result.and(self.writer.finish())
    }

    fn frame_by_frame(&mut self, stage: &mut Stage, frames: &[u32]) -> Result<(), RenderError> {
        let mut pending = Pending::default();
        // The first picture is soon there; a script that fails at a frame has lost little.
        let mut batch = 1;
        // Whether the frame packed before was shaded, or waits to be.
        let mut follows = false;
        for frame in frames.iter().copied() {
            self.writer.reclaim(&mut self.pictures)?;
            if self.cancel.load(Ordering::Relaxed) {
                return Err(RenderError::Cancelled);
            }
            let mut timer = Instant::now();
            let mut lap = || nanoseconds(std::mem::replace(&mut timer, Instant::now()));
            // script
            if let Err(error) = stage.frame(frame) {
                self.shade(&mut pending)?; // the frames before it stand
                return Err(script_error(Some(frame), error));
            }
            self.spare_new_inputs(stage, frames)?;
            let script_ns = lap();
            let joins = stage.with_scene(|scene| self.packer.only_recolours(scene));
            if !pending.frames.is_empty() && !joins {
                self.shade(&mut pending)?;
                lap();
            }
            // pack, diff
            let changes = stage.with_scene(|scene| self.packer.update(scene));
            let provenance = self.provenance(frame, &changes);
            let fate = match self.stands(frame, provenance.as_ref()) {
                true => Fate::Dropped,
                false => Fate::Written,
            };
            if fate == Fate::Dropped && pending.frames.is_empty() {
                follows = false;
                continue;
            }
            pending.colours.push(self.packer.columns(), &changes);
            let pack_ns = lap();
            let changed = match follows {
                true => Changed::of(&changes, self.packer.columns(), stage),
                false => Changed::default(),
            };
            let report = FrameReport { frame, changed, script_ns, pack_ns, ..Default::default() };
            pending.frames.push(Waiting { report, provenance, fate });
            if pending.frames.len() == 1 {
                pending.changes = follows.then_some(changes);
            }
            follows = true;
            if fate == Fate::Dropped || pending.holds(batch) {
                self.shade(&mut pending)?;
                batch = (2 * batch).min(self.pictures.longest_batch());
            }
        }
        match pending.frames.is_empty() {
            true => Ok(()),
            false => self.shade(&mut pending),
        }
    }

    /// Looks at files that a frame was the first to read.
    fn spare_new_inputs(&mut self, stage: &Stage, frames: &[u32]) -> Result<(), RenderError> {
        let inputs = stage.inputs();
        let new = inputs.get(self.inputs..).filter(|new| !new.is_empty());
        self.inputs = inputs.len();
        new.map_or(Ok(()), |new| Inputs::of(new).spare_by(&self.job.target, frames))
            .map_err(RenderError::Refused)
    }

    /// What the file of a frame is made from; `changes` are those of the last packing. The standard
    /// output says nothing of the kind.
    fn provenance(&mut self, frame: u32, changes: &Changes) -> Option<Provenance> {
        let target = &self.job.target;
        if target.is_stdout() {
            return None;
        }
        let scene = self.hasher.hash(self.packer.columns(), changes);
        Some(Provenance::new(scene, settings(&self.packer, self.job, frame), self.tile.as_ref()))
    }

    /// Whether the job keeps the file of a frame.
    fn stands(&mut self, frame: u32, wanted: Option<&Provenance>) -> bool {
        let (Resume::Keep, Some(wanted)) = (self.job.resume, wanted) else { return false };
        if self.job.target.format().is_film() {
            return false; // it stands as a whole or not at all
        }
        let path = self.job.target.path_for(frame);
        let standing = resume::standing(&path, wanted);
        let stands = standing == Standing::Stands;
        if stands {
            self.writer.summary.kept += 1;
            self.writer.events.tell(Event::Kept { frame, path: &path });
        } else {
            self.writer.events.tell(Event::Again { frame, path: &path, standing: &standing });
        }
        stands
    }

    /// Accelerate, trace, shade; then film and file on another thread.
    fn shade(&mut self, pending: &mut Pending) -> Result<(), RenderError> {
        let Pending { frames, changes, colours } = std::mem::take(pending);
        let mut pictures = Vec::new();
        while pictures.len() < frames.len() {
            pictures.push(self.writer.take(&mut self.pictures)?);
        }
        let columns = self.packer.columns();
        let curve = curve(columns.model.transfer);
        let table = transfer(&mut self.table, columns.model.transfer, self.kind);
        let last = self.pictures.last();
        let batch = Batch {
            columns,
            changes: changes.as_ref(),
            colours: &colours,
            table,
            last: last.as_deref(),
        };
        let work = self.engine.render(batch, &mut pictures, self.cancel);
        let work = work.map_err(|_| RenderError::Cancelled)?;
        let shaded = frames.into_iter().zip(pictures);
        for (i, (waiting, picture)) in shaded.enumerate() {
            let Waiting { report, provenance, fate } = waiting;
            let picture = Arc::new(picture);
            self.pictures.set_last(&picture);
            if fate == Fate::Dropped {
                self.pictures.give_back(picture);
                continue;
            }
            let report = told(report, &work, i);
            self.writer.write(Finished { picture, report, provenance, transfer: curve });
        }
        Ok(())
    }
}

/// The report of the `i`-th frame of a batch. What was done once for all of them counts as the
/// first one's; their time is shared out equally.
fn told(report: FrameReport, work: &Work, i: usize) -> FrameReport {
    let frames = work.shaded_tiles.len() as u64;
    let report = FrameReport {
        batch: frames as u32,
        trace_ns: work.trace_ns / frames,
        shaded_tiles: work.shaded_tiles[i],
        tiles: work.tiles,
        kept_bytes: work.kept_bytes,
        ..report
    };
    if i > 0 {
        return report;
    }
    FrameReport {
        fresh: work.fresh,
        build_ns: work.build_ns,
        rays: work.rays,
        accel_rays: work.counts.closest + work.counts.any,
        retraced_pixels: work.retraced_pixels,
        replayed_nodes: work.replayed_nodes,
        tested_segments: work.tested_segments,
        deepened_nodes: work.deepened_nodes,
        ..report
    }
}

/// What decides the bytes of a frame's file beside its scene.
pub(crate) fn settings(packer: &Packer, job: &Job, frame: u32) -> FileSettings {
    let columns = packer.columns();
    FileSettings {
        frame,
        size: columns.view.size,
        samples: columns.samples,
        filter: if columns.samples > 1 { columns.view.filter } else { Filter::Box },
        format: job.target.format(),
        compression: job.compression,
        transfer: curve(columns.model.transfer),
    }
}

/// What decides the bytes of a film beside its frames.
pub(crate) fn film_settings(job: &Job, size: [u32; 2], fps: Fps) -> FilmSettings {
    FilmSettings {
        size,
        fps,
        format: job.target.format(),
        compression: job.compression,
        dither: job.dither,
        quality: job.quality,
    }
}

/// The part of the picture that is asked for.
pub(crate) fn tile(packer: &Packer, job: &Job) -> Result<Option<Tile>, RenderError> {
    let columns = packer.columns();
    let tile = job.tile.map(|choice| choice.of(columns.view.size, columns.model.transfer));
    tile.transpose().map_err(RenderError::Usage)
}

/// The frames of a job, in order.
pub(crate) fn frames(stage: &Stage, job: &Job) -> Vec<u32> {
    let all = || (0..stage.with_scene(|scene| scene.animation().frames)).collect();
    job.frames.clone().unwrap_or_else(all)
}

/// The rate of the script's animation.
pub(crate) fn fps(stage: &Stage) -> Result<Fps, RenderError> {
    let fps = stage.with_scene(|scene| scene.animation().fps);
    Fps::from_f64(fps).map_err(|e| RenderError::Other(e.to_string()))
}

fn at_first(frames: &[u32], (path, error): (PathBuf, std::io::Error)) -> RenderError {
    RenderError::Output { frame: frames.first().copied().unwrap_or(0), path, error }
}

/// Removes what killed processes left, and tells of it.
fn sweep(job: &Job, frames: &[u32], events: &Events<'_>) -> Result<(), RenderError> {
    let swept = resume::sweep(&job.target, frames).map_err(|failed| at_first(frames, failed))?;
    swept.iter().for_each(|stray| events.tell(Event::Swept(stray)));
    Ok(())
}

/// Packs the scene as the script left it.
pub(crate) fn pack(stage: &Stage, job: &Job) -> Result<Packer, RenderError> {
    let packed = stage.with_scene(|scene| {
        let image = scene.image();
        let mut size = job.size.unwrap_or([image.width, image.height]);
        let mut max_bounces = None;
        if job.draft == Draft::Yes {
            size = size.map(|edge| (edge / Draft::SHRINK).max(1));
            max_bounces = Some(Draft::MAX_BOUNCES);
        }
        Packer::new(scene, Overrides { size: Some(size), max_bounces })
    });
    packed.map_err(|e| RenderError::Other(e.to_string()))
}

pub(crate) fn script_error(frame: Option<u32>, error: ScriptError) -> RenderError {
    RenderError::Script { frame, error: Box::new(error) }
}

/// The curve that a scene names.
pub(crate) fn curve(curve: TransferCurve) -> Transfer {
    match curve {
        TransferCurve::Srgb => Transfer::Srgb,
        TransferCurve::Linear => Transfer::Linear,
    }
}

fn transfer(
    table: &mut Option<TransferTable>,
    curve: TransferCurve,
    kind: SampleKind,
) -> &TransferTable {
    let transfer = self::curve(curve);
    if table.as_ref().is_none_or(|t| t.transfer() != transfer) {
        *table = None;
    }
    table.get_or_insert_with(|| TransferTable::new(transfer, kind))
}
