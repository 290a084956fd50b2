//! A script's own thread: a large stack, watched from the caller's thread.

use crate::engine::Meter;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// The stack, touched only as deep as a script goes.
const STACK: usize = 64 << 20;
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
    std::thread::scope(|scope| {
        let (done, waiting) = channel::<()>();
        let thread = std::thread::Builder::new()
            .name("script".into())
            .stack_size(STACK)
            .spawn_scoped(scope, move || {
                // Dropped at the end, also of a panic: that is what the caller waits for.
                let _done = done;
                work()
            })
            .ok()?;
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
        thread.join().ok()
    })
}

/// The bytes of memory that the process holds, where the system tells.
fn resident() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/statm").ok()?;
    let pages: u64 = text.split_whitespace().nth(1)?.parse().ok()?;
    Some(pages * 4096)
}
