//! `reflet profile`: how fast rays are, by the CPU clock of the threads that trace them.
//!
//! | room | holds |
//! | --- | --- |
//! | [`npy`] | NumPy's array files |
//! | [`inputs`] | primitives and rays from files |
//! | [`cast`] | rays cast at primitives |
//! | [`scene`] | one frame of a scene |
//! | [`report`] | what is told |

pub mod cast;
pub mod inputs;
pub mod npy;
mod report;
pub mod scene;

use crate::console::print;
use crate::exit::Failure;
use crate::meant::{Script, Tell};
use cast::Question;
use inputs::Primitives;
use reflet_accel::{Accel, Isa, Rays, Structure};
use std::path::PathBuf;
use std::time::Instant;

/// What is measured.
pub enum Subject {
    /// Rays from a file, cast at primitives from files.
    Files {
        /// The primitives.
        primitives: Primitives,
        /// The rays.
        rays: PathBuf,
        /// What is asked of them.
        question: Question,
        /// Where the answers go.
        hits: Option<PathBuf>,
    },
    /// A frame of a scene.
    Scene(Script, u32),
}

/// What is measured, and how.
pub struct Profile {
    /// What is measured.
    pub subject: Subject,
    /// Which levels.
    pub isas: Vec<Isa>,
    /// How many threads, one measurement each.
    pub threads: Vec<usize>,
    /// How often.
    pub repeat: usize,
    /// Whom the result is told to.
    pub tell: Tell,
}

/// Measures, and tells what was measured.
///
/// # Errors
/// Inputs that cannot be read, an output that cannot be written, levels that this machine lacks.
pub fn run(profile: &Profile) -> Result<(), Failure> {
    match &profile.subject {
        Subject::Files { primitives, rays, question, hits } => {
            files(profile, primitives, rays, *question, hits.as_ref())
        }
        Subject::Scene(script, frame) => {
            let frame = scene::load(script, *frame)?;
            if profile.tell == Tell::People {
                print(report::stages(&frame))?;
            }
            profile.each(|isa, threads| {
                let measured = frame.measure(isa, threads, profile.repeat)?;
                print(match profile.tell {
                    Tell::Programs => report::scene_line(&frame, &measured),
                    Tell::People | Tell::Scheduler => report::scene_table(&frame, &measured),
                })
            })
        }
    }
}

impl Profile {
    fn each(&self, mut run: impl FnMut(Isa, usize) -> Result<(), Failure>) -> Result<(), Failure> {
        self.isas
            .iter()
            .try_for_each(|isa| self.threads.iter().try_for_each(|threads| run(*isa, *threads)))
    }
}

fn files(
    profile: &Profile,
    primitives: &Primitives,
    rays: &std::path::Path,
    question: Question,
    hits: Option<&PathBuf>,
) -> Result<(), Failure> {
    let geometry = primitives.read()?;
    let most = profile.threads.iter().max().copied().unwrap_or(1);
    // Alone, a thread takes all rays as one stream; several share out parts.
    let streams = inputs::rays(rays, if most == 1 { 1 } else { 8 * most })?;
    if profile.tell == Tell::People {
        print(report::FILES_HEAD)?;
    }
    profile.each(|isa, threads| {
        let level = isa.level().map_err(|e| Failure::usage(format!("--isa: {e}")))?;
        let pool = cast::pool(threads)?;
        let start = Instant::now();
        let accel = pool.install(|| Accel::build(&geometry, level, Structure::Auto));
        let build = start.elapsed();
        let done = cast::cast(&accel, &pool, &streams, question, profile.repeat);
        let count: usize = streams.iter().map(Rays::len).sum();
        if let Some(path) = hits {
            let descr = "[('t', '<f4'), ('prim', '<u4')]";
            npy::write(path, descr, &format!("({count},)"), &done.rows(&streams))?;
        }
        let line = report::Line {
            rays: count,
            hits: done.hits(&streams),
            isa: isa.resolved().name(),
            threads,
            repeat: profile.repeat,
            build_ms: build.as_secs_f64() * 1e3,
            primitives: geometry.len(),
            bytes_per_primitive: accel.bytes() as f64 / geometry.len().max(1) as f64,
            sah_cost: accel.sah_cost(),
            ..report::Line::of(count, &done)
        };
        print(match profile.tell {
            Tell::Programs => report::files_line(&line),
            Tell::People | Tell::Scheduler => report::files_row(&line),
        })
    })
}
