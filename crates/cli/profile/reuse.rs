//! What re-use saves: a frame after the frame before it, and the same frame from nothing.

use crate::exit::Failure;
use crate::profile::cast;
use crate::profile::renderer::Renderer;
use crate::profile::scene::Frame;
use reflet_accel::Isa;
use reflet_frame::engine::Work;
use std::time::Duration;

/// One way to a frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct Way {
    /// Tree, rays and colours on the wall, the median.
    pub wall: Duration,
    /// Rays cast.
    pub rays: u64,
}

/// Both ways to one frame.
#[derive(Clone, Copy, Debug)]
pub struct Saved {
    /// From nothing.
    pub fresh: Way,
    /// With what the frame before left.
    pub kept: Way,
    /// Why nothing was kept, if so.
    pub why: Option<&'static str>,
}

/// Renders the frame `repeat` times both ways; `None` if no frame is before it.
///
/// # Errors
/// The threads or the memory cannot be had, or the machine lacks the instructions.
pub fn measure(
    frame: &Frame,
    isa: Isa,
    threads: usize,
    repeat: usize,
) -> Result<Option<Saved>, Failure> {
    let Some((before, changes)) = &frame.before else { return Ok(None) };
    let columns = &frame.columns;
    let mut renderer = Renderer::new(columns, isa, threads)?;
    let (mut times, mut works) = ([Vec::new(), Vec::new()], [Work::default(), Work::default()]);
    for round in 0..=repeat {
        let fresh = renderer.render(columns, None);
        renderer.render(before, None);
        let kept = renderer.render(columns, Some(changes));
        for (k, (time, work)) in [fresh, kept].into_iter().enumerate() {
            // The first round finds its memory, and learns what is worth keeping.
            if round > 0 {
                times[k].push(time);
                works[k] = work;
            }
        }
    }
    let way = |k: usize| Way { wall: cast::median(&times[k]), rays: works[k].rays.total() };
    Ok(Some(Saved { fresh: way(0), kept: way(1), why: works[1].fresh }))
}
