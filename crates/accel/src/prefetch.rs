//! Asking for memory before it is needed. The one file with `unsafe`.

/// Asks for a row, all of its cache lines. Nothing but time depends on it.
#[allow(unsafe_code)]
#[inline(always)]
pub fn prefetch<T>(rows: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    if let Some(row) = rows.get(index) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        const LINE: usize = 64;
        let first = std::ptr::from_ref(row).cast::<i8>();
        for at in (0..size_of::<T>()).step_by(LINE) {
            // SAFETY: the address lies within `row`; a prefetch reads nothing that could be seen,
            // and SSE is part of every x86-64.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(first.wrapping_add(at)) };
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (rows, index);
}
