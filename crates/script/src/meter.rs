//! What a run of a script may take: operations, time and memory, looked at at every operation.

use crate::trouble::{Fallible, Trouble, ended};
use rhai::Dynamic;
use std::sync::atomic::{AtomicU8, AtomicU64, Ordering::Relaxed};
use std::time::Duration;

/// Tells how many bytes the process has allocated and not freed: the counter of a counting
/// allocator, which the program brings along.
pub type Heap = fn() -> u64;

/// Bytes that appear between two operations are copied values, and cost operations if they are
/// more than this.
const COPIED: u64 = 64 << 10;
/// The bytes that are copied in the time of an operation.
const COPIED_BY_ONE: u64 = 8;
/// A script's values may take one of so many parts of its memory. A value is copied in one
/// operation, and nested ones are dropped by recursion, which takes at most 2.5 times their bytes
/// of stack (measured: a link of a chain of closures 160 bytes and 360 of stack, an array in an
/// array 40 and 96): so the rest is what copying and dropping may need.
pub(crate) const VALUES: u64 = 4;
/// The time that goes with an operation: some more than most of them take.
const TIME: Duration = Duration::from_nanos(30);
/// The least time that a script has.
const LEAST_TIME: Duration = Duration::from_secs(10);

/// Why a run is to stop, as it is set from outside.
const GO_ON: u8 = 0;
const TOO_LARGE: u8 = 1;
const TOO_SLOW: u8 = 2;

/// Counts what one run of a script, or one frame, takes.
#[derive(Debug)]
pub(crate) struct Meter {
    max_operations: u64,
    max_memory: u64,
    heap: Option<Heap>,
    operations: AtomicU64,
    /// The memory of this run: less than `max_memory` where the system has less.
    memory: AtomicU64,
    /// The bytes at the start, without the values that the script left to its frames.
    start: AtomicU64,
    /// The bytes of things that were made since then.
    scene: AtomicU64,
    /// The bytes of files that were read since then.
    files: AtomicU64,
    /// The bytes at the last operation, and the most that there may be.
    last: AtomicU64,
    most: AtomicU64,
    stop: AtomicU8,
}

impl Meter {
    pub fn new(max_operations: u64, max_memory: u64, heap: Option<Heap>) -> Self {
        let zero = || AtomicU64::new(0);
        Self {
            max_operations,
            max_memory,
            heap,
            operations: zero(),
            memory: AtomicU64::new(max_memory),
            start: zero(),
            scene: zero(),
            files: zero(),
            last: zero(),
            most: AtomicU64::new(u64::MAX),
            stop: AtomicU8::new(GO_ON),
        }
    }

    /// Starts a run with `memory` bytes, of which `carried` are taken already.
    pub fn begin(&self, memory: u64, carried: u64) {
        let now = self.heap.map_or(0, |heap| heap());
        self.operations.store(0, Relaxed);
        self.memory.store(memory, Relaxed);
        self.start.store(now.saturating_sub(carried), Relaxed);
        self.last.store(now, Relaxed);
        self.scene.store(0, Relaxed);
        self.files.store(0, Relaxed);
        self.stop.store(GO_ON, Relaxed);
        self.bound();
    }

    /// The memory that may be used, before the system is asked.
    pub fn max_memory(&self) -> u64 {
        self.max_memory
    }

    /// The operations of this run so far.
    pub fn operations(&self) -> u64 {
        self.operations.load(Relaxed)
    }

    /// The processor time that goes with the operations allowed.
    pub fn time(&self) -> Duration {
        let time = u128::from(self.max_operations) * TIME.as_nanos();
        Duration::from_nanos(u64::try_from(time).unwrap_or(u64::MAX)).max(LEAST_TIME)
    }

    /// The bytes of files that this run has read.
    pub fn files(&self) -> u64 {
        self.files.load(Relaxed)
    }

    /// The bytes that the script's values take.
    pub fn values(&self) -> u64 {
        let known = [&self.start, &self.scene, &self.files].map(|n| n.load(Relaxed));
        let now = self.heap.map_or(0, |heap| heap());
        now.saturating_sub(known.iter().sum())
    }

    /// The most bytes that the script's values may take.
    fn values_allowed(&self) -> u64 {
        self.memory.load(Relaxed).saturating_sub(self.scene.load(Relaxed)) / VALUES
    }

    fn bound(&self) {
        let known = [&self.start, &self.scene, &self.files].map(|n| n.load(Relaxed));
        let most = if self.heap.is_some() {
            known.iter().sum::<u64>().saturating_add(self.values_allowed())
        } else {
            u64::MAX
        };
        self.most.store(most, Relaxed);
    }

    /// Asks the script to stop because the process has grown too large.
    pub fn too_large(&self) {
        self.stop.store(TOO_LARGE, Relaxed);
    }

    /// Asks the script to stop because it has run for too long.
    pub fn too_slow(&self) {
        self.stop.store(TOO_SLOW, Relaxed);
    }

    /// Whether the script was asked to stop.
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Relaxed) != GO_ON
    }

    /// Whether a script that is read fills the memory, or was asked to stop.
    pub fn is_full(&self) -> bool {
        self.is_stopped() || self.heap.is_some_and(|heap| heap() > self.most.load(Relaxed))
    }

    /// Counts one operation; what ends the script, if anything does.
    pub fn step(&self) -> Option<Dynamic> {
        // One thread runs the script: plain stores are enough, and cheaper than adding.
        let mut done = self.operations.load(Relaxed) + 1;
        if let Some(heap) = self.heap {
            let (now, last) = (heap(), self.last.load(Relaxed));
            self.last.store(now, Relaxed);
            if now > last + COPIED {
                done += (now - last) / COPIED_BY_ONE;
            }
            if now > self.most.load(Relaxed) {
                self.operations.store(done, Relaxed);
                return Some(Dynamic::from(self.memory_trouble()));
            }
        }
        self.operations.store(done, Relaxed);
        if done > self.max_operations || self.is_stopped() {
            return Some(Dynamic::from(self.stop_trouble()));
        }
        None
    }

    /// Charges work that a native function does beside its own operation: `steps` of 10 to 30 ns.
    pub fn work(&self, steps: usize) -> Fallible<()> {
        let done = self.operations.load(Relaxed) + steps as u64;
        self.operations.store(done, Relaxed);
        if done > self.max_operations || self.is_stopped() {
            return Err(ended(self.stop_trouble()));
        }
        Ok(())
    }

    /// An error if `bytes` more are more than the script may hold.
    pub fn room(&self, bytes: usize) -> Fallible<()> {
        let held = if self.heap.is_some() { self.values() } else { 0 };
        if held.saturating_add(bytes as u64) > self.values_allowed() {
            return Err(ended(self.memory_trouble()));
        }
        Ok(())
    }

    /// Makes things of the scene: their bytes are no values.
    pub fn scene<R>(&self, make: impl FnOnce() -> R) -> R {
        let Some(heap) = self.heap else { return make() };
        let (before, files) = (heap(), self.files());
        let made = make();
        let now = heap();
        self.last.store(now, Relaxed);
        let grown = now.saturating_sub(before).saturating_sub(self.files() - files);
        if grown > 0 {
            self.scene.store(self.scene.load(Relaxed) + grown, Relaxed);
            self.bound();
        }
        made
    }

    /// Reads a file: its bytes have bounds of their own.
    pub fn file<R>(&self, read: impl FnOnce() -> R) -> R {
        let Some(heap) = self.heap else { return read() };
        let before = heap();
        let made = read();
        let now = heap();
        self.last.store(now, Relaxed);
        self.files.store(self.files() + now.saturating_sub(before), Relaxed);
        self.bound();
        made
    }

    fn stop_trouble(&self) -> Trouble {
        let max = self.max_operations;
        if self.operations() > max {
            Trouble::new(format!(
                "more than {max} operations: a loop without an end? --max-operations allows more"
            ))
        } else if self.stop.load(Relaxed) == TOO_SLOW {
            Trouble::new(format!(
                "more than {} seconds, the time that goes with {max} operations: long strings or arrays that are searched or copied in a loop? --max-operations allows more",
                self.time().as_secs()
            ))
        } else {
            self.memory_trouble()
        }
    }

    /// What ends a script that fills the memory.
    pub fn memory_trouble(&self) -> Trouble {
        let (memory, max) = (self.memory.load(Relaxed), self.max_memory);
        let scene = self.scene.load(Relaxed);
        let whose = if scene > memory / 2 {
            format!("the script makes a scene of more than {}", size(memory))
        } else {
            format!(
                "the script holds too much memory: its strings, arrays and maps take more than {}, a quarter of the {} allowed (the rest is for copies)",
                size(self.values_allowed()),
                size(memory)
            )
        };
        Trouble::new(if memory < max {
            format!("{whose}; --max-memory allows {}, but the system not so much", size(max))
        } else {
            format!("{whose}; --max-memory allows more")
        })
    }
}

/// Bytes in words.
fn size(bytes: u64) -> String {
    if bytes >= 10 << 20 { format!("{} MiB", bytes >> 20) } else { format!("{} KiB", bytes >> 10) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicU64;

    static LIVE: AtomicU64 = AtomicU64::new(1000);

    #[test]
    fn values_scene_and_files_are_told_apart() {
        const MIB: u64 = 1 << 20;
        let meter = Meter::new(1_000_000_000, 64 * MIB, Some(|| LIVE.load(Relaxed)));
        let grow = |bytes| LIVE.fetch_add(bytes, Relaxed);
        meter.begin(64 * MIB, 0);
        meter.file(|| grow(500 * MIB));
        assert_eq!((meter.values(), meter.files()), (0, 500 * MIB));
        assert!(meter.step().is_none());
        // Things of the scene count, but not the file that one of them reads.
        meter.scene(|| meter.file(|| grow(MIB)));
        meter.scene(|| grow(32 * MIB));
        assert_eq!(meter.values_allowed(), 8 * MIB);
        assert!(meter.room(7 << 20).is_ok() && meter.room(9 << 20).is_err());
        grow(8 * MIB);
        assert!(meter.step().is_none());
        grow(1);
        assert!(meter.step().is_some());
        // What the script left counts in its frames, too.
        meter.begin(64 * MIB, 8 * MIB + 1);
        assert_eq!(meter.values(), 8 * MIB + 1);
        assert!(meter.step().is_none());
    }

    #[test]
    fn copies_cost_operations() {
        static LIVE: AtomicU64 = AtomicU64::new(0);
        let meter = Meter::new(1000, 1 << 30, Some(|| LIVE.load(Relaxed)));
        meter.begin(1 << 30, 0);
        assert!(meter.step().is_none());
        LIVE.store(COPIED + 1, Relaxed);
        assert!(meter.step().is_some());
        assert_eq!(meter.operations(), 2 + (COPIED + 1) / COPIED_BY_ONE);
    }
}
