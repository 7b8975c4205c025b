//! Memory of one simulation: a heap of its own, so that no thread of a GPU waits for another's.
//!
//! A GPU's own `malloc` serves all threads from one heap, one after another.

use std::alloc::Layout;

/// Sizes of blocks, four to each doubling from 64 bytes to 1 GB.
const CLASSES: usize = 96;
/// Alignment of the blocks that more than 16 bytes are asked for.
const WIDE: u64 = 128;

/// A heap: its head, at the beginning of the memory that it gives out.
#[repr(C)]
#[derive(Debug)]
pub struct Heap {
    /// Where what was never given out begins, and where it ends.
    next: u64,
    end: u64,
    /// The first free block of each size, of those aligned to 16 bytes and of those aligned to [`WIDE`]; each holds the
    /// address of the next one, the last one 0.
    free: [[u64; CLASSES]; 2],
}

/// The class of a block of this size, and the size of its blocks.
fn class(size: usize) -> (usize, u64) {
    let size = size.max(64) as u64;
    let step = 1 << ((size - 1).ilog2() - 2);
    let rounded = size.next_multiple_of(step);
    let top = rounded.ilog2();
    let quarter = (rounded >> (top - 2)) & 3;
    (((top - 6) * 4) as usize + quarter as usize, rounded)
}

impl Heap {
    /// Makes an empty heap of `size` bytes at this address.
    ///
    /// # Safety
    /// The memory is aligned to 128 bytes, larger than the head, and nobody's else as long as the heap is used.
    pub unsafe fn place(at: *mut u8, size: u64) {
        let start = at as u64;
        let empty =
            Self { next: start + size_of::<Self>() as u64, end: start + size, free: [[0; CLASSES]; 2] };
        // SAFETY: as the caller promises.
        unsafe { at.cast::<Self>().write(empty) }
    }

    /// A block for this layout; null if there is no more memory.
    pub fn alloc(&mut self, layout: Layout) -> *mut u8 {
        let (class, size) = class(layout.size());
        let wide = layout.align() > 16;
        let Some(first) = self.free[usize::from(wide)].get_mut(class) else {
            return std::ptr::null_mut();
        };
        if *first != 0 {
            let block = *first as *mut u64;
            // SAFETY: a free block begins with the address of the next one.
            *first = unsafe { block.read() };
            return block.cast();
        }
        let at = self.next.next_multiple_of(if wide { WIDE.max(layout.align() as u64) } else { 16 });
        if size > self.end.saturating_sub(at) {
            return std::ptr::null_mut();
        }
        self.next = at + size;
        at as *mut u8
    }

    /// Takes a block back.
    ///
    /// # Safety
    /// The heap has given it out for this layout, and nobody uses it any more.
    pub unsafe fn free(&mut self, block: *mut u8, layout: Layout) {
        let (class, _) = class(layout.size());
        let first = &mut self.free[usize::from(layout.align() > 16)][class];
        // SAFETY: as the caller promises; the smallest block has room for an address.
        unsafe { block.cast::<u64>().write(*first) };
        *first = block as u64;
    }

    /// Whether a block for this layout has room for `size` bytes, and isn't larger than one for as many.
    #[must_use]
    pub fn fits(layout: Layout, size: usize) -> bool {
        class(layout.size()).0 == class(size).0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_math::rng::Stream;

    #[test]
    fn blocks_are_large_enough_and_at_most_a_quarter_larger() {
        let mut before = (0, 0);
        for size in 1..100_000 {
            let (class, block) = class(size);
            assert!(block >= size as u64, "{size}");
            assert!(block <= 64 || block < size as u64 + size as u64 / 4 + 1, "{size}: {block}");
            assert!(class == before.0 && block == before.1 || class == before.0 + 1 || size == 1, "{size}");
            before = (class, block);
        }
        assert!(class(1 << 29).0 < CLASSES);
    }

    #[test]
    fn blocks_dont_overlap_and_come_back() {
        let layout = Layout::from_size_align(1 << 20, 4096).unwrap();
        // SAFETY: the layout isn't empty.
        let memory = unsafe { std::alloc::alloc(layout) };
        // SAFETY: it is this test's own, and large enough.
        let heap = unsafe {
            Heap::place(memory, 1 << 20);
            &mut *memory.cast::<Heap>()
        };
        let mut random = Stream::new(3, &["heap"]);
        let mut held: Vec<(usize, Layout)> = Vec::new();
        let mut refused = 0;
        for _ in 0..20_000 {
            if random.below(5) < 2 && !held.is_empty() {
                let (at, layout) = held.swap_remove(random.below(held.len() as u64) as usize);
                // SAFETY: it was given out for this layout, and is forgotten here.
                unsafe { heap.free(at as *mut u8, layout) };
                continue;
            }
            let align = 1 << random.below(8);
            let layout = Layout::from_size_align(1 + random.below(5000) as usize, align).unwrap();
            let at = heap.alloc(layout) as usize;
            if at == 0 {
                refused += 1;
                continue;
            }
            assert_eq!(at % align, 0);
            assert!(
                at >= memory as usize + size_of::<Heap>()
                    && at + layout.size() <= memory as usize + (1 << 20)
            );
            for (other, held) in &held {
                assert!(at + layout.size() <= *other || *other + held.size() <= at, "blocks overlap");
            }
            held.push((at, layout));
        }
        assert!(refused > 0 && held.len() > 50, "{refused}, {}", held.len());
        // SAFETY: it was given out for this layout.
        unsafe { std::alloc::dealloc(memory, layout) };
    }
}
