//! The program's allocator: the system's, and a count of the bytes that are taken.

use cap::Cap;
use std::alloc::System;

#[global_allocator]
static HEAP: Cap<System> = Cap::new(System, usize::MAX);

/// The bytes that are allocated now.
pub fn allocated() -> u64 {
    HEAP.allocated() as u64
}
