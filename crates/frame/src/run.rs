//! The stages in order.

use crate::engine::{Engine, EngineOptions, nanoseconds};
use crate::event::{Event, FrameReport, RenderError, Summary};
use crate::job::{Draft, Job, Reuse};
use crate::memory;
use crate::output::{FilmInfo, Finished, Output};
use reflet_film::{Fps, Layout, Picture, SampleKind, Transfer, TransferTable};
use reflet_pack::{Columns, Overrides, Packer, TransferCurve};
use reflet_script::{ScriptError, Stage};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel, sync_channel};
use std::thread;
use std::time::Instant;

/// How many pictures are under way: one traced, one that waits, one written.
const PICTURES: usize = 3;

/// Renders the frames of `job`. Frames are written in order; when the job ends early, those before
/// stand, and nothing else of it stays.
///
/// `cancel` may be set at any time: the job ends within a tile.
pub fn render(
    stage: &mut Stage,
    job: &Job,
    cancel: &AtomicBool,
    events: &mut dyn FnMut(Event<'_>),
) -> Result<Summary, RenderError> {
    for warning in stage.warnings() {
        events(Event::Warning(&warning.to_string()));
    }

    let animation = stage.with_scene(|scene| scene.animation());
    let frames = job.frames.clone().unwrap_or_else(|| (0..animation.frames).collect());
    let cache_bytes =
        job.cache_bytes.or_else(|| memory::available().map(|a| a / 4)).unwrap_or(1 << 30);
    let options = EngineOptions {
        threads: job.threads,
        isa: job.isa,
        // Nothing builds on the last frame.
        reuse: if frames.len() > 1 { job.reuse } else { Reuse::Never },
        cache_bytes,
        ..Default::default()
    };
    let mut engine = Engine::new(options).map_err(RenderError::Other)?;
    let mut packer = pack(stage, job)?;
    let size = packer.columns().view.size;
    let kind = job.target.format().sample_kind();
    let mut pictures = Pictures::new(&engine, packer.columns(), kind)?;
    let fps = Fps::from_f64(animation.fps).map_err(|e| RenderError::Other(e.to_string()))?;
    let info = FilmInfo { size, fps, frames: frames.len() as u32 };

    let begin = Instant::now();
    let mut summary =
        Summary { isa: engine.isa(), threads: engine.threads(), ..Summary::default() };
    events(Event::Started {
        frames: frames.len(),
        size,
        isa: engine.isa(),
        threads: engine.threads(),
    });
    let pool = engine.pool();
    let first = frames.first().copied().unwrap_or(0);
    let mut output = Output::open(job.target.clone(), job.compression, info, &pool)
        .map_err(|(path, error)| RenderError::Output { frame: first, path, error })?;

    let result = thread::scope(|scope| {
        let (finished, to_write) = sync_channel::<Finished>(1);
        let (report, written) = channel::<Result<Finished, RenderError>>();
        let output = &mut output;
        scope.spawn(move || {
            for mut frame in to_write {
                let result = output.write(&mut frame).map(|()| frame);
                let failed = result.is_err();
                if report.send(result).is_err() || failed {
                    return;
                }
            }
        });

        let mut table = None;
        let mut frame_by_frame = || {
            for (i, frame) in frames.iter().copied().enumerate() {
                pictures.reclaim(&written, &mut summary, events)?;
                if cancel.load(Ordering::Relaxed) {
                    return Err(RenderError::Cancelled);
                }
                let mut timer = Instant::now();
                let mut lap = || nanoseconds(std::mem::replace(&mut timer, Instant::now()));
                // script
                stage.frame(frame).map_err(|error| script_error(Some(frame), error))?;
                let script_ns = lap();
                // pack, diff
                let changes = stage.with_scene(|scene| packer.update(scene));
                let pack_ns = lap();
                // accelerate, trace, shade
                let columns = packer.columns();
                let table = transfer(&mut table, columns.model.transfer, kind);
                let mut picture = pictures.take(&written, &mut summary, events)?;
                let changes = (i > 0).then_some(&changes);
                let work = engine
                    .render(columns, changes, table, &mut picture, cancel)
                    .map_err(|_| RenderError::Cancelled)?;
                // film, file
                let report = FrameReport {
                    frame,
                    script_ns,
                    pack_ns,
                    build_ns: work.build_ns,
                    trace_ns: work.trace_ns,
                    rays: work.rays,
                    accel_rays: work.counts.closest + work.counts.any,
                    retraced_pixels: work.retraced_pixels,
                    replayed_nodes: work.replayed_nodes,
                    kept_bytes: work.kept_bytes,
                    ..FrameReport::default()
                };
                if finished.send(Finished { picture, report }).is_err() {
                    break; // the writer has failed: its error is on the way
                }
            }
            Ok(())
        };
        let result = frame_by_frame();
        // Whatever ended the loop, the frames before are written.
        drop(finished);
        result.and(pictures.drain(&written, &mut summary, events))
    });
    // Files of frames that were written stand, whatever ended the job.
    match result {
        Ok(()) => output.finish(frames.last().copied().unwrap_or(0))?,
        Err(error) => {
            if !job.target.format().is_film() {
                let _ = output.finish(0);
            }
            return Err(error);
        }
    }
    summary.elapsed_ns = nanoseconds(begin);
    Ok(summary)
}

/// Packs the scene as the script left it.
fn pack(stage: &Stage, job: &Job) -> Result<Packer, RenderError> {
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

fn script_error(frame: Option<u32>, error: ScriptError) -> RenderError {
    RenderError::Script { frame, error: Box::new(error) }
}

fn transfer(
    table: &mut Option<TransferTable>,
    curve: TransferCurve,
    kind: SampleKind,
) -> &TransferTable {
    let transfer = match curve {
        TransferCurve::Srgb => Transfer::Srgb,
        TransferCurve::Linear => Transfer::Linear,
    };
    if table.as_ref().is_none_or(|t| t.transfer() != transfer) {
        *table = None;
    }
    table.get_or_insert_with(|| TransferTable::new(transfer, kind))
}

/// The pictures under way, used again and again.
struct Pictures {
    layout: Layout,
    kind: SampleKind,
    spare: Vec<Picture>,
    left: usize,
}

type Written = Receiver<Result<Finished, RenderError>>;

impl Pictures {
    fn new(engine: &Engine, columns: &Columns, kind: SampleKind) -> Result<Self, RenderError> {
        let [width, height] = columns.view.size;
        let edge = engine.grid(columns).edge;
        let layout =
            Layout::try_new(width, height, edge).map_err(|e| RenderError::Other(e.to_string()))?;
        let bytes = layout.len() as u64 * kind.bytes() as u64;
        // Beside a picture stand its rows as the encoder keeps them, and the file.
        let (least, usual) = (bytes.saturating_mul(3), bytes.saturating_mul(2 + PICTURES as u64));
        let available = memory::available().unwrap_or(u64::MAX);
        if least > available {
            return Err(RenderError::Memory { needed: least, available });
        }
        let left = if usual > available / 2 { 1 } else { PICTURES };
        let first = Picture::try_new(layout, kind)
            .map_err(|e| RenderError::Memory { needed: e.bytes as u64, available })?;
        Ok(Pictures { layout, kind, spare: vec![first], left: left - 1 })
    }

    /// A picture to trace into; waits for one if all are under way.
    fn take(
        &mut self,
        written: &Written,
        summary: &mut Summary,
        events: &mut dyn FnMut(Event<'_>),
    ) -> Result<Picture, RenderError> {
        loop {
            if let Some(picture) = self.spare.pop() {
                return Ok(picture);
            }
            if self.left > 0 {
                if let Ok(picture) = Picture::try_new(self.layout, self.kind) {
                    self.left -= 1;
                    return Ok(picture);
                }
                self.left = 0;
            }
            match written.recv() {
                Ok(frame) => self.count(frame?, summary, events),
                Err(_) => return Err(RenderError::Other("the writer has stopped".to_owned())),
            }
        }
    }

    /// Takes back what has been written by now.
    fn reclaim(
        &mut self,
        written: &Written,
        summary: &mut Summary,
        events: &mut dyn FnMut(Event<'_>),
    ) -> Result<(), RenderError> {
        while let Ok(frame) = written.try_recv() {
            self.count(frame?, summary, events);
        }
        Ok(())
    }

    /// Waits until all is written.
    fn drain(
        &mut self,
        written: &Written,
        summary: &mut Summary,
        events: &mut dyn FnMut(Event<'_>),
    ) -> Result<(), RenderError> {
        while let Ok(frame) = written.recv() {
            self.count(frame?, summary, events);
        }
        Ok(())
    }

    fn count(&mut self, frame: Finished, summary: &mut Summary, events: &mut dyn FnMut(Event<'_>)) {
        let r = &frame.report;
        summary.frames += 1;
        summary.rays += r.rays;
        summary.bytes += r.bytes;
        summary.trace_ns += r.trace_ns;
        events(Event::Frame(r));
        self.spare.push(frame.picture);
    }
}
