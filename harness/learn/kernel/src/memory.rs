//! The memory of the threads of a GPU: each takes it from a heap of its own.

use std::alloc::{GlobalAlloc, Layout};

use crate::heap::Heap;

unsafe extern "C" {
    /// Where this thread notes its heap: in memory that its block has to itself (`xtask/src/kernel/words.ll`).
    safe fn vb_slot() -> *mut *mut Heap;
}

/// From now on this thread takes memory from this heap.
pub(crate) fn enter(heap: *mut Heap) {
    // SAFETY: each thread has its own place.
    unsafe { vb_slot().write(heap) }
}

/// The heap of this thread.
fn heap() -> &'static mut Heap {
    // SAFETY: each thread has its own place, in which [`enter`] has put a heap.
    unsafe { &mut **vb_slot() }
}

struct Memory;

#[global_allocator]
static MEMORY: Memory = Memory;

// SAFETY: a heap's blocks are apart from each other, and each thread has a heap of its own.
unsafe impl GlobalAlloc for Memory {
    #[inline(never)]
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        heap().alloc(layout)
    }

    #[inline(never)]
    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        // SAFETY: as this function's caller promises.
        unsafe { heap().free(block, layout) }
    }

    #[inline(never)]
    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        if Heap::fits(layout, size) {
            return block;
        }
        // SAFETY: as this function's caller promises.
        unsafe {
            let larger = heap().alloc(Layout::from_size_align_unchecked(size, layout.align()));
            if !larger.is_null() {
                std::ptr::copy_nonoverlapping(block, larger, layout.size().min(size));
                heap().free(block, layout);
            }
            larger
        }
    }
}
