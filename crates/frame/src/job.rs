//! What is asked for.

use crate::resume::Resume;
use crate::tiles::TileChoice;
use reflet_accel::Isa;
use reflet_film::{Compression, Dither, Target, VideoQuality};
use std::num::NonZeroUsize;

/// A render: which frames of a script, how, and where to.
#[derive(Clone, Debug)]
pub struct Job {
    /// The frames in the order in which they are made; all of the animation if `None`.
    pub frames: Option<Vec<u32>>,
    /// Width and height in pixels, in place of the script's.
    pub size: Option<[u32; 2]>,
    /// Whether this is a quick look.
    pub draft: Draft,
    /// Threads that trace; as many as the machine has if `None`.
    pub threads: Option<NonZeroUsize>,
    /// Which instructions the kernels use.
    pub isa: Isa,
    /// Whether frames build on the frame before.
    pub reuse: Reuse,
    /// Bytes that kept trees may take; a quarter of the free memory if `None`.
    pub cache_bytes: Option<u64>,
    /// Whether frames that stand are kept.
    pub resume: Resume,
    /// The part of the picture that is rendered; all of it if `None`.
    pub tile: Option<TileChoice>,
    /// How much time a smaller file is worth.
    pub compression: Compression,
    /// How a GIF stands for colours that its palette lacks.
    pub dither: Dither,
    /// How well ffmpeg encodes a film.
    pub quality: VideoQuality,
    /// Where the frames go.
    pub target: Target,
}

/// Whether a render is a quick look.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Draft {
    /// It is the real thing.
    #[default]
    No,
    /// A quarter of the width and height, and no more than 3 bounces.
    Yes,
}

impl Draft {
    /// The most bounces of a draft.
    pub const MAX_BOUNCES: u32 = 3;
    /// How many pixels of the picture a draft's pixel stands for, along each side.
    pub const SHRINK: u32 = 4;
}

/// Whether frames build on the frame before. The pictures do not depend on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Reuse {
    /// What cannot differ is kept.
    #[default]
    Keep,
    /// Every frame is made from scratch.
    Never,
}
