//! `reflet profile`: how fast rays are, by the CPU clock of the threads that trace them.
//!
//! | room | holds |
//! | --- | --- |
//! | [`npy`] | NumPy's array files |
//! | [`inputs`] | primitives and rays from files |
//! | [`cast`] | rays cast at primitives |

pub mod cast;
pub mod inputs;
pub mod npy;

use crate::console::print;
use crate::exit::Failure;
use crate::meant::Tell;
use cast::{Measured, Question};
use inputs::Primitives;
use reflet_accel::Isa;
use serde::Serialize;
use std::fmt::Write;
use std::path::PathBuf;

/// Rays from a file cast at primitives from files.
pub struct Bench {
    /// The primitives.
    pub primitives: Primitives,
    /// The rays.
    pub rays: PathBuf,
    /// What is asked of them.
    pub question: Question,
    /// Where the answers go.
    pub hits: Option<PathBuf>,
    /// Which levels.
    pub isas: Vec<Isa>,
    /// How many threads, one measurement each.
    pub threads: Vec<usize>,
    /// How often.
    pub repeat: usize,
    /// Whom the result is told to.
    pub tell: Tell,
}

/// The object that `--json` prints for each level and number of threads.
#[derive(Serialize)]
struct Line {
    mrays_per_s_per_core: f64,
    mrays_per_s_per_core_min: f64,
    mrays_per_s_per_core_max: f64,
    mrays_per_s: f64,
    rays: usize,
    hits: usize,
    isa: &'static str,
    threads: usize,
    repeat: usize,
    build_ms: f64,
    primitives: usize,
    bytes_per_primitive: f64,
    sah_cost: f32,
}

/// Measures, and tells what was measured.
///
/// # Errors
/// Inputs that cannot be read, an output that cannot be written, levels that this machine lacks.
pub fn bench(bench: &Bench) -> Result<(), Failure> {
    let geometry = bench.primitives.read()?;
    let one = bench.threads.iter().all(|n| *n == 1);
    // Alone, a thread takes all rays as one stream; several share out parts.
    let parts = if one { 1 } else { 8 * bench.threads.iter().max().copied().unwrap_or(1) };
    let streams = inputs::rays(&bench.rays, parts)?;
    let mut table = String::from(
        "level    threads   Mrays/s a core (min, max)      Mrays/s    build ms         rays         hits\n",
    );
    for isa in &bench.isas {
        for threads in &bench.threads {
            let how = (*isa, *threads, bench.repeat);
            let measured = cast::measure(&geometry, &streams, bench.question, how)?;
            if let Some(path) = &bench.hits {
                let descr = "[('t', '<f4'), ('prim', '<u4')]";
                let shape = format!("({},)", measured.rays);
                npy::write(path, descr, &shape, &measured.rows(&streams))?;
            }
            let line = line(&measured, geometry.len(), bench.repeat);
            match bench.tell {
                Tell::Programs => {
                    let text = serde_json::to_string(&line).expect("numbers and names");
                    print(text + "\n")?;
                }
                Tell::People | Tell::Scheduler => row(&mut table, &line),
            }
        }
    }
    if bench.tell != Tell::Programs {
        print(table)?;
    }
    Ok(())
}

fn line(measured: &Measured, primitives: usize, repeat: usize) -> Line {
    let [min, median, max] = measured.mrays_per_s(&measured.cpu);
    Line {
        mrays_per_s_per_core: median,
        mrays_per_s_per_core_min: min,
        mrays_per_s_per_core_max: max,
        mrays_per_s: measured.mrays_per_s(&measured.wall)[1],
        rays: measured.rays,
        hits: measured.hits,
        isa: measured.isa,
        threads: measured.threads,
        repeat,
        build_ms: measured.build.as_secs_f64() * 1e3,
        primitives,
        bytes_per_primitive: measured.bytes as f64 / primitives.max(1) as f64,
        sah_cost: measured.sah_cost,
    }
}

fn row(table: &mut String, l: &Line) {
    let spread = format!("({:.2}, {:.2})", l.mrays_per_s_per_core_min, l.mrays_per_s_per_core_max);
    let _ = writeln!(
        table,
        "{:<8} {:>7} {:>9.2} {:<18} {:>12.2} {:>11.1} {:>12} {:>12}",
        l.isa, l.threads, l.mrays_per_s_per_core, spread, l.mrays_per_s, l.build_ms, l.rays, l.hits
    );
}
