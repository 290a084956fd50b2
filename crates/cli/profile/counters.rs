//! What the processor itself counts while rays are cast, where system and machine tell it: many
//! virtual machines have no such counters, and systems may keep them from users.

use crate::profile::cast::Question;
use reflet_accel::{Accel, Rays};
use serde_json::{Value, json};

/// Cycles, instructions, branches foretold wrongly, and reads that no cache served; `None` where
/// there is no counter.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counted(Option<[u64; 4]>);

const NAMES: [&str; 4] = ["cycles", "instructions", "branch_misses", "cache_misses"];

impl Counted {
    /// For people, a ray.
    pub fn text(self, rays: usize) -> String {
        let Some(counts) = self.0 else { return "not available here".into() };
        let [cycles, instructions, branches, caches] =
            counts.map(|n| n as f64 / rays.max(1) as f64);
        format!(
            "a ray: {cycles:.0} cycles, {instructions:.0} instructions, {branches:.2} mispredicted branches, {caches:.2} cache misses"
        )
    }

    /// For programs, a ray; null where there is no counter.
    pub fn json(self, rays: usize) -> Value {
        let Some(counts) = self.0 else { return Value::Null };
        let pairs = NAMES.into_iter().zip(counts.map(|n| n as f64 / rays.max(1) as f64));
        json!(pairs.map(|(name, n)| (name.to_owned(), n.into())).collect::<serde_json::Map<_, _>>())
    }
}

/// Casts `streams` once more on this thread, counted.
#[cfg(target_os = "linux")]
pub fn count(accel: &Accel, streams: &[Rays], question: Question) -> Counted {
    use perf_event::events::Hardware;
    use perf_event::{Builder, Group};
    use reflet_accel::{Hits, RayCounts, Scratch};
    let counted = || -> std::io::Result<[u64; 4]> {
        let mut group = Group::new()?;
        let mut counters = Vec::new();
        for event in [
            Hardware::CPU_CYCLES,
            Hardware::INSTRUCTIONS,
            Hardware::BRANCH_MISSES,
            Hardware::CACHE_MISSES,
        ] {
            counters.push(group.add(&Builder::new(event))?);
        }
        let (mut hits, mut occluded) = (Hits::default(), Vec::new());
        let (mut scratch, mut counts) = (Scratch::default(), RayCounts::default());
        group.enable()?;
        for rays in streams {
            match question {
                Question::Closest => accel.closest(rays, &mut hits, &mut scratch, &mut counts),
                Question::Any => accel.any(rays, &mut occluded, &mut scratch, &mut counts),
            }
        }
        group.disable()?;
        let read = group.read()?;
        let of = |i: usize| read.get(&counters[i]).map_or(0, |entry| entry.value());
        Ok([of(0), of(1), of(2), of(3)])
    };
    // Whatever is the matter: no counters.
    Counted(counted().ok().filter(|counts| counts[0] > 0))
}

/// There is no such counter.
#[cfg(not(target_os = "linux"))]
pub fn count(_: &Accel, _: &[Rays], _: Question) -> Counted {
    Counted::default()
}
