//! A decoder's panic is an error, and panics elsewhere are told as ever. In a file of its own, since a
//! process has one hook.

use reflet_assets::shield::shielded;
use std::sync::atomic::{AtomicUsize, Ordering};

#[test]
fn only_panics_within_a_shield_are_silent() {
    static TOLD: AtomicUsize = AtomicUsize::new(0);
    std::panic::set_hook(Box::new(|_| {
        TOLD.fetch_add(1, Ordering::Relaxed);
    }));
    assert!(shielded(|| -> () { panic!("within") }).is_err());
    assert_eq!(TOLD.load(Ordering::Relaxed), 0);
    // Another thread is within none, even while this one is.
    let other = || std::thread::spawn(|| panic!("outside")).join().is_err();
    assert_eq!(shielded(other), Ok(true));
    assert_eq!(TOLD.load(Ordering::Relaxed), 1);
    assert!(std::panic::catch_unwind(|| panic!("after")).is_err());
    assert_eq!(TOLD.load(Ordering::Relaxed), 2);
}
