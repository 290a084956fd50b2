//! What is told while a job is done, and how it can fail.

use crate::changed::Changed;
use reflet_script::ScriptError;
use reflet_trace::RayTally;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

/// Something that happened.
#[derive(Debug)]
pub enum Event<'a> {
    /// The script has run and the first frame begins.
    Started {
        /// How many frames will be made.
        frames: usize,
        /// Width and height in pixels.
        size: [u32; 2],
        /// The instructions in use.
        isa: &'static str,
        /// Threads that trace.
        threads: usize,
    },
    /// Something that the user may want to mend.
    Warning(&'a str),
    /// A killed process left this file under a temporary name; it was removed.
    Swept(&'a std::path::Path),
    /// A frame's file stands and was kept.
    Kept {
        /// Which frame.
        frame: u32,
        /// Its file.
        path: &'a std::path::Path,
    },
    /// A frame's file does not stand, and is made again.
    Again {
        /// Which frame.
        frame: u32,
        /// Its file.
        path: &'a std::path::Path,
        /// Why.
        standing: &'a crate::resume::Standing,
    },
    /// The film stands and was kept, with all of its frames.
    FilmKept {
        /// Its file.
        path: &'a std::path::Path,
        /// Its frames.
        frames: usize,
    },
    /// The film does not stand, and is made again.
    FilmAgain {
        /// Its file.
        path: &'a std::path::Path,
        /// Why.
        standing: &'a crate::resume::Standing,
    },
    /// A frame is on disk.
    Frame(&'a FrameReport),
}

/// Who is told of events, from whatever thread: one event at a time.
pub(crate) struct Events<'e>(Mutex<&'e mut (dyn FnMut(Event<'_>) + Send)>);

impl<'e> Events<'e> {
    pub fn to(told: &'e mut (dyn FnMut(Event<'_>) + Send)) -> Self {
        Events(Mutex::new(told))
    }

    pub fn tell(&self, event: Event<'_>) {
        (self.0.lock().unwrap_or_else(PoisonError::into_inner))(event);
    }
}

/// What a frame took.
#[derive(Clone, Debug, Default)]
pub struct FrameReport {
    /// Which frame.
    pub frame: u32,
    /// Its file; `None` for the standard output.
    pub path: Option<PathBuf>,
    /// Time of the script's frame function, in nanoseconds, like all times here.
    pub script_ns: u64,
    /// Time of packing and comparing.
    pub pack_ns: u64,
    /// Time of building what rays are intersected with.
    pub build_ns: u64,
    /// Time of tracing and shading; the time of a batch is shared out equally.
    pub trace_ns: u64,
    /// Time of encoding and writing; it overlaps with the frames after.
    pub encode_ns: u64,
    /// What differs from the frame before.
    pub changed: Changed,
    /// Why all trees were made from scratch, if they were.
    pub fresh: Option<&'static str>,
    /// Rays cast.
    pub rays: RayTally,
    /// Rays as `accel` counted them: closest hits and shadows.
    pub accel_rays: u64,
    /// Pixels of which at least one tree was made from its root.
    pub retraced_pixels: u64,
    /// Nodes of kept trees whose point was found again without a ray.
    pub replayed_nodes: u64,
    /// Segments of kept trees that were held against the bounds of what moved.
    pub tested_segments: u64,
    /// Nodes that kept trees grew by, below their leaves.
    pub deepened_nodes: u64,
    /// Tiles that were shaded; the others were copied from the frame before.
    pub shaded_tiles: u64,
    /// Tiles in all.
    pub tiles: u64,
    /// Frames that were shaded together with this one, itself among them.
    pub batch: u32,
    /// Bytes of trees kept for the next frame.
    pub kept_bytes: u64,
    /// Bytes written.
    pub bytes: u64,
    /// Bands of rows that were encoded.
    pub bands_encoded: u64,
    /// Bands of rows whose bytes were kept.
    pub bands_kept: u64,
    /// Whether the file that it took the place of was the same already.
    pub stood: bool,
}

impl FrameReport {
    /// The time of all stages of this frame, in nanoseconds.
    pub fn elapsed_ns(&self) -> u64 {
        self.script_ns + self.pack_ns + self.build_ns + self.trace_ns + self.encode_ns
    }
}

/// What a whole job took.
#[derive(Clone, Debug, Default)]
pub struct Summary {
    /// Frames made.
    pub frames: u64,
    /// Frames whose files were kept.
    pub kept: u64,
    /// Frames made although their files could have been kept.
    pub remade: u64,
    /// Wall time from the first frame's begin to the last one's end, in nanoseconds.
    pub elapsed_ns: u64,
    /// Time that all threads together spent tracing and shading, in nanoseconds of wall time.
    pub trace_ns: u64,
    /// Rays cast.
    pub rays: RayTally,
    /// Bytes written.
    pub bytes: u64,
    /// Frames of which no tree was made from its root.
    pub frames_without_retrace: u64,
    /// Rays that were not cast, since the trees of frames before served: for each frame, as many as
    /// the last one cast of which all trees were made from scratch.
    pub rays_saved: u64,
    /// Tiles that were copied from the frame before, and all tiles.
    pub tiles_copied: [u64; 2],
    /// Bands of rows whose bytes were kept, and all bands.
    pub bands_kept: [u64; 2],
    /// Rays of the last frame of which all trees were made from scratch.
    pub fresh_rays: u64,
    /// The instructions in use.
    pub isa: &'static str,
    /// Threads that traced.
    pub threads: usize,
}

impl Summary {
    /// Adds a frame.
    pub(crate) fn count(&mut self, frame: &FrameReport) {
        self.frames += 1;
        self.remade += u64::from(frame.stood);
        self.rays += frame.rays;
        self.bytes += frame.bytes;
        self.trace_ns += frame.trace_ns;
        self.frames_without_retrace += u64::from(frame.retraced_pixels == 0);
        if frame.fresh.is_some() {
            self.fresh_rays = frame.rays.total();
        }
        self.rays_saved += self.fresh_rays.saturating_sub(frame.rays.total());
        self.tiles_copied[0] += frame.tiles - frame.shaded_tiles;
        self.tiles_copied[1] += frame.tiles;
        self.bands_kept[0] += frame.bands_kept;
        self.bands_kept[1] += frame.bands_kept + frame.bands_encoded;
    }
}

/// Why a job ended early. Frames before it are on disk.
#[derive(Debug)]
pub enum RenderError {
    /// The script is wrong, at a frame or before.
    Script {
        /// The frame, if it was in a frame function.
        frame: Option<u32>,
        /// What is wrong.
        error: Box<ScriptError>,
    },
    /// A file could not be written.
    Output {
        /// The frame that it was for.
        frame: u32,
        /// Which file.
        path: PathBuf,
        /// What the system said.
        error: std::io::Error,
    },
    /// An output is an input, or another program's file: it would be lost.
    Refused(crate::guard::Refusal),
    /// The picture is too large for this machine.
    Memory {
        /// Bytes that are needed.
        needed: u64,
        /// Bytes that can be had.
        available: u64,
    },
    /// The job was told to stop.
    Cancelled,
    /// What was asked for does not fit the scene.
    Usage(String),
    /// The threads could not be started, or something else that is none of the above.
    Other(String),
}

impl std::fmt::Display for RenderError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            RenderError::Script { frame: Some(frame), error } => {
                write!(f, "frame {frame}: {error}")
            }
            RenderError::Script { frame: None, error } => write!(f, "{error}"),
            RenderError::Output { frame, path, error } => {
                write!(f, "frame {frame}: {}: {error}", path.display())
            }
            RenderError::Refused(refusal) => write!(f, "{refusal}"),
            RenderError::Memory { needed, available } => write!(
                f,
                "a picture of this size needs {} MiB of memory and {} MiB are free; make it smaller",
                needed >> 20,
                available >> 20
            ),
            RenderError::Cancelled => f.write_str("stopped"),
            RenderError::Usage(message) | RenderError::Other(message) => f.write_str(message),
        }
    }
}

impl std::error::Error for RenderError {}
