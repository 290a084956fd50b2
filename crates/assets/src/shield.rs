//! A decoder's panic is the fault of its file.
//!
//! Decoders of others meet files of strangers. What they did not foresee must be one message with the
//! file's name: no trace on stderr, and no thread ended.

use std::cell::{Cell, RefCell};
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

thread_local! {
    /// How many shields this thread is within.
    static WITHIN: Cell<u32> = const { Cell::new(0) };
    /// What the last panic within one said.
    static SAID: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Runs `work`; if it panics, what it said, on one line.
///
/// The process has one panic hook. Ours is put before the one that is there, once, and passes on
/// every panic of a thread that is within no shield.
///
/// # Errors
/// `work` panicked.
pub fn shielded<R>(work: impl FnOnce() -> R) -> Result<R, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if WITHIN.get() == 0 {
                return before(info);
            }
            let payload = info.payload();
            let said = payload.downcast_ref::<&str>().copied();
            let said = said.or_else(|| payload.downcast_ref::<String>().map(String::as_str));
            let said = said.unwrap_or("no reason given");
            SAID.set(said.replace(char::is_control, " "));
        }));
    });
    WITHIN.set(WITHIN.get() + 1);
    // What `work` leaves half done is its own, and dropped.
    let result = panic::catch_unwind(AssertUnwindSafe(work));
    WITHIN.set(WITHIN.get() - 1);
    result.map_err(|_| SAID.take())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_what_it_said() {
        assert_eq!(shielded(|| 7), Ok(7));
        let inner = || shielded(|| -> u8 { panic!("two\nlines") });
        assert_eq!(inner(), Err("two lines".to_owned()));
        assert_eq!(shielded(|| inner().is_err()), Ok(true));
        assert_eq!(WITHIN.get(), 0);
    }
}
