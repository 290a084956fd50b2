//! What the machine is told about memory: rows before they are needed, and large pages. The one file
//! with `unsafe`. Nothing but time depends on any of it.

use crate::blocks::Blocks;
use crate::tree::{Child, Tree};
use reflet_pack::ShapeKind;
use std::mem::MaybeUninit;

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

/// Where the rows of each kind of child are.
pub struct Ahead {
    kinds: [Rows; Child::KINDS],
}

/// Where rows are, how far apart, and of which kind: that of a node has many numbers, of which this
/// is the least.
#[derive(Clone, Copy)]
struct Rows {
    first: usize,
    size: u32,
    kind: u32,
}

impl Ahead {
    /// For the children of a tree's nodes.
    pub fn of(tree: &Tree, blocks: &Blocks) -> Ahead {
        fn rows<T>(rows: &[T], kind: usize) -> Rows {
            Rows { first: rows.as_ptr().addr(), size: size_of::<T>() as u32, kind: kind as u32 }
        }
        let mut kinds = [rows(&tree.nodes, 0); Child::KINDS];
        for shape in ShapeKind::ALL {
            let kind = Child::block(shape, 0).kind();
            kinds[kind] = match shape {
                ShapeKind::Sphere => rows(&blocks.spheres.blocks, kind),
                ShapeKind::Plane => rows(&blocks.planes.blocks, kind),
                ShapeKind::Quad => rows(&blocks.quads.blocks, kind),
                ShapeKind::Triangle => rows(&blocks.triangles.blocks, kind),
                ShapeKind::Solid => rows(&blocks.solids.blocks, kind),
                ShapeKind::Copy => rows(&blocks.copies, kind),
            };
        }
        kinds[Child::NONE.kind()] = rows(&tree.nodes, Child::NONE.kind());
        Ahead { kinds }
    }

    /// Asks for a child, or for most of it: as many cache lines whatever it is, so that nothing
    /// need be predicted. Gives its kind, one number for all nodes.
    #[allow(unsafe_code)]
    #[inline(always)]
    pub fn ask_for(&self, child: Child) -> usize {
        let rows = &self.kinds[child.kind() % Child::KINDS];
        #[cfg(target_arch = "x86_64")]
        {
            use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
            let row = rows.first.wrapping_add(child.index().wrapping_mul(rows.size as usize));
            for line in 0..4 {
                let at = std::ptr::without_provenance::<i8>(row.wrapping_add(64 * line));
                // SAFETY: a prefetch may be given any address, and SSE is part of every x86-64.
                unsafe { _mm_prefetch::<_MM_HINT_T0>(at) };
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = (rows.first, rows.size);
        rows.kind as usize
    }
}

/// Asks for pages of 2 MiB under what is written into `room` for the first time, where the system
/// has them: rays that find their way through hundreds of megabytes else wait for page tables, too.
#[allow(unsafe_code)]
pub fn prefer_large_pages<T>(room: &mut [MaybeUninit<T>]) {
    #[cfg(target_os = "linux")]
    {
        const PAGE: usize = 2 << 20;
        let size = size_of_val(room);
        let first = room.as_mut_ptr().cast::<u8>();
        let skip = first.addr().next_multiple_of(PAGE) - first.addr();
        let whole = size.saturating_sub(skip) / PAGE * PAGE;
        if whole > 0 {
            // SAFETY: the range lies within `room`, which is borrowed mutably; the advice changes
            // none of its bytes. A system that cannot follow it says so, and that is all.
            unsafe { libc::madvise(first.add(skip).cast(), whole, libc::MADV_HUGEPAGE) };
        }
    }
    #[cfg(not(target_os = "linux"))]
    let _ = room;
}
