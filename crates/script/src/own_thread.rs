//! A script's own thread: a large stack, watched from the caller's thread.

use crate::meter::{Meter, VALUES};
use std::fs::File;
use std::io::{Read, Seek};
use std::sync::Mutex;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Bytes of stack for a byte of values: nested ones are copied and dropped by recursion, and no
/// limit of Rhai's counts their depth. See [`VALUES`].
const STACK: u64 = 5;
/// The smallest stack: what Rhai's own limits on depth need.
const SMALLEST: u64 = 64 << 20;
/// The largest: only what a script touches is taken, but the addresses are.
const LARGEST: u64 = 6 << 30;
/// Addresses for all else, where they are bounded.
const ELSE: u64 = 192 << 20;
/// How often the script is looked at.
const LOOK: Duration = Duration::from_millis(5);
/// After this long the caller is told that the script still runs.
const PATIENCE: Duration = Duration::from_secs(2);

/// Why work on the script's own thread came to no end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Broken {
    /// The system gives no thread.
    NoThread,
    /// It panicked.
    Panicked,
}

/// Runs `work` on a thread of its own and waits for it.
///
/// While it runs, time and memory of the process are watched: a script that takes too much of
/// either is asked to stop through the meter. `carried` bytes of values are there already. `slow`
/// is called once if it takes long.
pub(crate) fn run<R: Send>(
    meter: &Meter,
    carried: u64,
    slow: impl FnOnce(),
    work: impl FnOnce() -> R + Send,
) -> Result<R, Broken> {
    // A spawn that fails drops the closure, so the work waits outside of it.
    let work = Mutex::new(Some(work));
    let wanted = memory(meter.max_memory());
    let done = std::thread::scope(|scope| {
        let (done, waiting) = channel::<Option<File>>();
        let mut stack = (wanted / VALUES * STACK).clamp(SMALLEST, LARGEST);
        let thread = loop {
            meter.begin(wanted.min(stack / STACK * VALUES), carried);
            let (done, work) = (done.clone(), &work);
            let spawned = std::thread::Builder::new()
                .name("script".into())
                .stack_size(usize::try_from(stack).unwrap_or(usize::MAX))
                .spawn_scoped(scope, move || {
                    let work = work.lock().ok().and_then(|mut work| work.take());
                    let _ = done.send(File::open("/proc/thread-self/schedstat").ok());
                    let made = work.map(|work| work());
                    // Dropped at the end, also of a panic: that is what the caller waits for.
                    drop(done);
                    made
                });
            match spawned {
                Ok(thread) => break thread,
                Err(_) if stack > SMALLEST => stack = (stack / 2).max(SMALLEST),
                Err(_) => return Err(Broken::NoThread),
            }
        };
        drop(done);
        let mut clock = waiting.recv().ok().flatten();
        let (started, before) = (Instant::now(), resident());
        let mut slow = Some(slow);
        while let Err(RecvTimeoutError::Timeout) = waiting.recv_timeout(LOOK) {
            let allowed = meter.max_memory().saturating_add(meter.files());
            if let (Some(before), Some(now)) = (before, resident())
                && now.saturating_sub(before) > allowed
            {
                meter.too_large();
            }
            let elapsed = started.elapsed();
            if elapsed > meter.time()
                && clock.as_mut().and_then(used).unwrap_or(elapsed) > meter.time()
            {
                meter.too_slow();
            }
            if elapsed > PATIENCE
                && let Some(slow) = slow.take()
            {
                slow();
            }
        }
        thread.join().ok().flatten().ok_or(Broken::Panicked)
    });
    // Work that never began may hold values that only a large stack can drop.
    if done.is_err() {
        std::mem::forget(work);
    }
    done
}

/// The processor time of a thread, from its file of statistics.
fn used(statistics: &mut File) -> Option<Duration> {
    let mut text = String::new();
    statistics.rewind().ok()?;
    statistics.read_to_string(&mut text).ok()?;
    text.split_whitespace().next()?.parse().ok().map(Duration::from_nanos)
}

/// The memory that a script may have, of `max`: where addresses are bounded (`ulimit -v`), less,
/// since its stack takes some, too.
fn memory(max: u64) -> u64 {
    let Some(limit) = address_limit() else { return max };
    let room = limit.saturating_sub(status("VmSize:").unwrap_or(0)).saturating_sub(ELSE);
    // A stack of 5/4 of it, and all of it.
    max.min(room / 9 * 4)
}

/// The bytes of addresses that the process may have, if they are bounded.
fn address_limit() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/limits").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// The bytes of memory that the process holds, where the system tells.
fn resident() -> Option<u64> {
    status("VmRSS:")
}

/// A number of bytes from the process's status.
fn status(name: &str) -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.split_whitespace().next()?.parse::<u64>().ok().map(|kilobytes| kilobytes << 10)
}
