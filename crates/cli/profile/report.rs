//! What is told: lines for people, an object a line for programs.

use crate::profile::cast::{self, Cast};
use crate::profile::counted::Spread;
use crate::profile::figures::Comparison;
use crate::profile::scene::{Frame, Kind, Measured};
use serde::Serialize;
use serde_json::{Value, json};
use std::fmt::Write;
use std::time::Duration;

/// Rays from a file, at one level on some threads.
#[derive(Default, Serialize)]
pub struct Line {
    pub hardware_per_ray: Value,
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

/// A line for programs; with comparisons, if there is something to compare with.
pub fn line(what: impl Serialize, compared: Option<&[Comparison]>) -> String {
    let mut line = serde_json::to_value(what).expect("numbers and names");
    if let Some(compared) = compared {
        line["against"] = json!(compared);
    }
    format!("{line}\n")
}

fn ms(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

fn median_ms(times: &[Duration]) -> f64 {
    ms(cast::median(times))
}

/// The stages before the tree.
pub fn stages(frame: &Frame) -> String {
    let mut text = String::new();
    for (name, time) in &frame.stages {
        let _ = writeln!(text, "{name:<16} {:>10.3} ms", ms(*time));
    }
    text
}

impl Kind {
    fn per_ray(&self, count: u64) -> f64 {
        count as f64 / self.rays.max(1) as f64
    }
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
    let [trace, shade] = [&m.trace, &m.shade].map(|times| median_ms(times));
    let share = |ms: f64| 100.0 * ms / (trace + shade).max(1e-6);
    let wall = median_ms(&m.wall);
    let _ = writeln!(text, "trace and shade  {wall:>10.3} ms on the wall; by the CPU clock:");
    let _ = writeln!(text, "  trace          {trace:>10.3} ms {:>5.1} %", share(trace));
    for kind in &m.kinds {
        let (cpu, wall) = (cast::median(&kind.cpu), cast::median(&kind.wall));
        let _ = writeln!(
            text,
            "    {:<12} {:>10.3} ms {:>5.1} %   {:>9} rays, {:>9} hit, {:>7.2} Mrays/s a core, {:>7.2} in all, {:>6.1} ns each",
            kind.name,
            ms(cpu),
            share(ms(cpu)),
            kind.rays,
            kind.hits,
            cast::speed(kind.rays, cpu),
            cast::speed(kind.rays, wall),
            kind.per_ray(cpu.as_nanos() as u64)
        );
    }
    let rays: usize = m.kinds.iter().map(|k| k.rays).sum();
    let cast: f64 = m.kinds.iter().map(|k| median_ms(&k.cpu)).sum();
    let rest = (trace - cast).max(0.0);
    let _ = writeln!(
        text,
        "    beside rays  {rest:>10.3} ms {:>5.1} %   {:.1} ns a ray",
        share(rest),
        rest * 1e6 / rays.max(1) as f64
    );
    let _ = writeln!(text, "  shade          {shade:>10.3} ms {:>5.1} %", share(shade));
    let encoded = m.encoded;
    let _ = writeln!(
        text,
        "encode           {:>10.3} ms on the wall   a PNG of {} bytes",
        ms(encoded.wall),
        encoded.bytes
    );
    text += &shares(frame, m);
    text += &counts(m);
    if let Some(saved) = &m.saved {
        let (fresh, kept) = (saved.fresh, saved.kept);
        let _ = writeln!(
            text,
            "re-use           {:>10.3} ms on the wall and {} rays after the frame before; {:.3} ms and {} rays from nothing",
            ms(kept.wall),
            kept.rays,
            ms(fresh.wall),
            fresh.rays
        );
        if let Some(why) = saved.why {
            let _ = writeln!(text, "                 nothing was kept: {why}");
        }
    }
    text
}

/// Which part of the frame each stage has, on the wall.
fn shares(frame: &Frame, m: &Measured) -> String {
    let own = frame.stages.iter().filter(|(name, _)| *name != "frame before");
    let mut stages: Vec<(&str, f64)> = own.map(|(name, time)| (*name, ms(*time))).collect();
    stages.push(("build", ms(m.build)));
    let wall = median_ms(&m.wall);
    let [trace, shade] = [&m.trace, &m.shade].map(|times| median_ms(times));
    stages.push(("trace", wall * trace / (trace + shade).max(1e-6)));
    stages.push(("shade", wall * shade / (trace + shade).max(1e-6)));
    stages.push(("encode", ms(m.encoded.wall)));
    let sum: f64 = stages.iter().map(|s| s.1).sum();
    let mut text = String::from("of all           ");
    for (i, (name, time)) in stages.iter().enumerate() {
        let comma = if i == 0 { "" } else { ", " };
        let _ = write!(
            text,
            "{comma}{} {:.1} %",
            name.replace(", ", " "),
            100.0 * time / sum.max(1e-6)
        );
    }
    text + "\n"
}

/// What was counted, for people.
fn counts(m: &Measured) -> String {
    let mut text =
        String::from("a ray              node visits   primitive tests   lanes in use\n");
    for kind in m.kinds.iter().filter(|kind| kind.rays > 0) {
        let _ = writeln!(
            text,
            "    {:<12} {:>13.2} {:>17.2} {:>12.1} %",
            kind.name,
            kind.per_ray(kind.work.nodes),
            kind.per_ray(kind.work.tests),
            100.0 * kind.work.occupancy()
        );
    }
    for kind in m.kinds.iter().filter(|kind| kind.rays > 0) {
        let _ = writeln!(text, "hardware, {:<10} {}", kind.name, kind.hardware.text(kind.rays));
    }
    text += "over tiles                 p50          p95          max\n";
    for (name, spread) in
        [("rays", m.tile_rays), ("visits, tests", m.tile_steps), ("CPU us", m.tile_us)]
    {
        let Spread { p50, p95, max } = spread;
        let _ = writeln!(text, "    {name:<13} {p50:>12.1} {p95:>12.1} {max:>12.1}");
    }
    text
}

fn spread(s: Spread) -> Value {
    json!({ "p50": s.p50, "p95": s.p95, "max": s.max })
}

/// A scene for programs.
pub fn scene_object(frame: &Frame, m: &Measured) -> Value {
    let mut stages = serde_json::Map::new();
    for (name, time) in &frame.stages {
        stages.insert(name.replace(", ", "_").replace(' ', "_") + "_ms", ms(*time).into());
    }
    let by_kind = |value: &dyn Fn(&Kind) -> Value| {
        let pairs = m.kinds.iter().map(|k| (k.name.to_owned(), value(k)));
        pairs.collect::<serde_json::Map<_, _>>()
    };
    let reuse = m.saved.map(|saved| {
        let way =
            |way: crate::profile::reuse::Way| json!({ "wall_ms": ms(way.wall), "rays": way.rays });
        json!({ "fresh": way(saved.fresh), "kept": way(saved.kept), "nothing_kept": saved.why })
    });
    json!({
        "isa": m.isa,
        "threads": m.threads,
        "primitives": frame.primitives(),
        "bytes_per_primitive": m.bytes as f64 / frame.primitives().max(1) as f64,
        "sah_cost": m.sah_cost,
        "stages": stages,
        "build_ms": ms(m.build),
        "trace_cpu_ms": median_ms(&m.trace),
        "shade_cpu_ms": median_ms(&m.shade),
        "wall_ms": median_ms(&m.wall),
        "rays": by_kind(&|k| k.rays.into()),
        "hits": by_kind(&|k| k.hits.into()),
        "cpu_ms": by_kind(&|k| median_ms(&k.cpu).into()),
        "mrays_per_s_per_core": by_kind(&|k| cast::speed(k.rays, cast::median(&k.cpu)).into()),
        "mrays_per_s": by_kind(&|k| cast::speed(k.rays, cast::median(&k.wall)).into()),
        "node_visits_per_ray": by_kind(&|k| k.per_ray(k.work.nodes).into()),
        "primitive_tests_per_ray": by_kind(&|k| k.per_ray(k.work.tests).into()),
        "lane_occupancy": by_kind(&|k| k.work.occupancy().into()),
        "tiles": {
            "rays": spread(m.tile_rays),
            "steps": spread(m.tile_steps),
            "cpu_us": spread(m.tile_us),
        },
        "encode_ms": ms(m.encoded.wall),
        "encode_bytes": m.encoded.bytes,
        "hardware_per_ray": by_kind(&|k| k.hardware.json(k.rays)),
        "reuse": reuse,
    })
}
