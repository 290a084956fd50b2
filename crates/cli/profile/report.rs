//! What is told: lines for people, an object a line for programs.

use crate::profile::cast::{self, Cast};
use crate::profile::scene::{Frame, Measured};
use serde::Serialize;
use std::fmt::Write;
use std::time::Duration;

/// Rays from a file, at one level on some threads.
#[derive(Default, Serialize)]
pub struct Line {
    pub mrays_per_s_per_core: f64,
    pub mrays_per_s_per_core_min: f64,
    pub mrays_per_s_per_core_max: f64,
    pub mrays_per_s: f64,
    pub rays: usize,
    pub hits: usize,
    pub isa: &'static str,
    pub threads: usize,
    pub repeat: usize,
    pub build_ms: f64,
    pub primitives: usize,
    pub bytes_per_primitive: f64,
    pub sah_cost: f32,
}

impl Line {
    /// The speeds of some rays.
    pub fn of(rays: usize, cast: &Cast) -> Line {
        let extreme = |t: Option<&Duration>| t.map_or(0.0, |t| cast::speed(rays, *t));
        Line {
            mrays_per_s_per_core: cast::speed(rays, cast::median(&cast.cpu)),
            mrays_per_s_per_core_min: extreme(cast.cpu.iter().max()),
            mrays_per_s_per_core_max: extreme(cast.cpu.iter().min()),
            mrays_per_s: cast::speed(rays, cast::median(&cast.wall)),
            ..Line::default()
        }
    }
}

/// What stands above [`files_row`]s.
pub const FILES_HEAD: &str = "level    threads   Mrays/s a core (min, max)      Mrays/s    build ms         rays         hits\n";

/// A line for people.
pub fn files_row(l: &Line) -> String {
    let spread = format!("({:.2}, {:.2})", l.mrays_per_s_per_core_min, l.mrays_per_s_per_core_max);
    format!(
        "{:<8} {:>7} {:>9.2} {:<18} {:>12.2} {:>11.1} {:>12} {:>12}\n",
        l.isa, l.threads, l.mrays_per_s_per_core, spread, l.mrays_per_s, l.build_ms, l.rays, l.hits
    )
}

/// A line for programs.
pub fn files_line(line: &Line) -> String {
    serde_json::to_string(line).expect("numbers and names") + "\n"
}

fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// The stages before the tree.
pub fn stages(frame: &Frame) -> String {
    let mut text = String::new();
    for (name, time) in &frame.stages {
        let _ = writeln!(text, "{name:<16} {:>10.3} ms", ms(*time));
    }
    text
}

/// A scene for people.
pub fn scene_table(frame: &Frame, m: &Measured) -> String {
    let mut text = format!("\n{}, {} thread(s)\n", m.isa, m.threads);
    let bytes = m.bytes as f64 / frame.primitives().max(1) as f64;
    let _ = writeln!(
        text,
        "build            {:>10.3} ms   {} primitives, {bytes:.0} bytes each, SAH cost {:.1}",
        ms(m.build),
        frame.primitives(),
        m.sah_cost
    );
    let both = (m.trace + m.shade).as_secs_f64().max(1e-9);
    let share = |time: Duration| 100.0 * time.as_secs_f64() / both;
    let _ =
        writeln!(text, "trace and shade  {:>10.3} ms on the wall; by the CPU clock:", ms(m.wall));
    let _ = writeln!(text, "  trace          {:>10.3} ms {:>5.1} %", ms(m.trace), share(m.trace));
    for kind in &m.kinds {
        let _ = writeln!(
            text,
            "    {:<12} {:>10.3} ms {:>5.1} %   {:>9} rays, {:>9} hit, {:>7.2} Mrays/s a core, {:>7.2} in all, {:>6.1} ns each",
            kind.name,
            ms(kind.cpu),
            share(kind.cpu),
            kind.rays,
            kind.hits,
            cast::speed(kind.rays, kind.cpu),
            cast::speed(kind.rays, kind.wall),
            kind.cpu.as_nanos() as f64 / kind.rays.max(1) as f64
        );
    }
    let rays: usize = m.kinds.iter().map(|k| k.rays).sum();
    let cast: Duration = m.kinds.iter().map(|k| k.cpu).sum();
    let rest = m.trace.saturating_sub(cast);
    let _ = writeln!(
        text,
        "    beside rays  {:>10.3} ms {:>5.1} %   {:.1} ns a ray",
        ms(rest),
        share(rest),
        rest.as_nanos() as f64 / rays.max(1) as f64
    );
    let _ = writeln!(text, "  shade          {:>10.3} ms {:>5.1} %", ms(m.shade), share(m.shade));
    text
}

/// A scene for programs.
pub fn scene_line(frame: &Frame, m: &Measured) -> String {
    let mut stages = serde_json::Map::new();
    for (name, time) in &frame.stages {
        stages.insert(name.replace(", ", "_") + "_ms", ms(*time).into());
    }
    let by_kind = |value: &dyn Fn(&crate::profile::scene::Kind) -> serde_json::Value| {
        let pairs = m.kinds.iter().map(|k| (k.name.to_owned(), value(k)));
        pairs.collect::<serde_json::Map<_, _>>()
    };
    let line = serde_json::json!({
        "isa": m.isa,
        "threads": m.threads,
        "primitives": frame.primitives(),
        "bytes_per_primitive": m.bytes as f64 / frame.primitives().max(1) as f64,
        "sah_cost": m.sah_cost,
        "stages": stages,
        "build_ms": ms(m.build),
        "trace_cpu_ms": ms(m.trace),
        "shade_cpu_ms": ms(m.shade),
        "wall_ms": ms(m.wall),
        "rays": by_kind(&|k| k.rays.into()),
        "hits": by_kind(&|k| k.hits.into()),
        "cpu_ms": by_kind(&|k| ms(k.cpu).into()),
        "mrays_per_s_per_core": by_kind(&|k| cast::speed(k.rays, k.cpu).into()),
        "mrays_per_s": by_kind(&|k| cast::speed(k.rays, k.wall).into()),
    });
    format!("{line}\n")
}
