//! What a frame's picture takes on its way to a file in memory.

use crate::exit::{Exit, Failure};
use crate::profile::cast;
use crate::profile::renderer::Renderer;
use crate::profile::scene::Frame;
use reflet_accel::Isa;
use reflet_film::{Format, StillOptions, encode_still};
use std::time::{Duration, Instant};

/// A PNG as `render` writes it unless told otherwise.
#[derive(Clone, Copy, Debug, Default)]
pub struct Encoded {
    /// The median time on the wall.
    pub wall: Duration,
    /// The size of the file.
    pub bytes: usize,
}

/// Renders the frame once and encodes its picture `repeat` times.
///
/// # Errors
/// The threads or the memory cannot be had, or the machine lacks the instructions.
pub fn measure(frame: &Frame, isa: Isa, threads: usize, repeat: usize) -> Result<Encoded, Failure> {
    let mut renderer = Renderer::new(&frame.columns, isa, threads)?;
    renderer.render(&frame.columns, None);
    let (mut times, mut bytes) = (Vec::new(), 0);
    for round in 0..=repeat {
        let start = Instant::now();
        let options = StillOptions::default();
        let encode = || encode_still(renderer.picture(), Format::Png, &options, None);
        let encoded = renderer.engine.pool().install(encode);
        bytes = encoded.map_err(|e| Failure::new(Exit::Failed, e.to_string()))?.len();
        // The first round finds its memory.
        if round > 0 {
            times.push(start.elapsed());
        }
    }
    Ok(Encoded { wall: cast::median(&times), bytes })
}
