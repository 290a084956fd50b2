//! A script's own thread: a large stack, watched from the caller's thread.

use crate::engine::Meter;
use std::sync::Mutex;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// The stacks to try, largest first; only what a script touches is taken.
///
/// A chain of closures, or arrays in arrays, is dropped and copied by recursion, and no limit of
/// Rhai's counts its links. Per link it takes at most 360 bytes of stack and at least 160 bytes of
/// heap (measured), so a stack of more than twice the memory allowed cannot overflow first.
const STACKS: [usize; 4] = [6 << 30, 2 << 30, 512 << 20, 64 << 20];
/// After this long the caller is told that the script still runs.
const PATIENCE: Duration = Duration::from_secs(2);

/// Runs `work` on a thread of its own and waits for it; `None` if it panicked or had no thread.
///
/// While it runs, the memory of the process is watched: a script that makes it grow by more than
/// `max_memory` bytes is asked to stop through the meter. `slow` is called once if it takes long.
pub(crate) fn run<R: Send>(
    meter: &Meter,
    max_memory: u64,
    slow: impl FnOnce(),
    work: impl FnOnce() -> R + Send,
) -> Option<R> {
    meter.operations.store(0, Ordering::Relaxed);
    meter.too_large.store(false, Ordering::Relaxed);
    // A spawn that fails drops the closure, so the work waits outside of it.
    let work = Mutex::new(Some(work));
    std::thread::scope(|scope| {
        let (done, waiting) = channel::<()>();
        let thread = STACKS.iter().find_map(|stack| {
            let (done, work) = (done.clone(), &work);
            std::thread::Builder::new()
                .name("script".into())
                .stack_size(*stack)
                .spawn_scoped(scope, move || {
                    // Dropped at the end, also of a panic: that is what the caller waits for.
                    let _done = done;
                    let work = work.lock().ok().and_then(|mut work| work.take());
                    work.map(|work| work())
                })
                .ok()
        })?;
        drop(done);
        let started = Instant::now();
        let before = resident();
        let mut slow = Some(slow);
        while waiting.recv_timeout(Duration::from_millis(5)) == Err(RecvTimeoutError::Timeout) {
            if let (Some(before), Some(now)) = (before, resident())
                && now.saturating_sub(before) > max_memory
            {
                meter.too_large.store(true, Ordering::Relaxed);
            }
            if started.elapsed() > PATIENCE
                && let Some(slow) = slow.take()
            {
                slow();
            }
        }
        thread.join().ok().flatten()
    })
}

/// The bytes of memory that the process holds, where the system tells.
fn resident() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/statm").ok()?;
    let pages: u64 = text.split_whitespace().nth(1)?.parse().ok()?;
    Some(pages * 4096)
}
