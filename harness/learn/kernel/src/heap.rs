//! Memory of one simulation: a heap of its own, so that no thread of a GPU waits for another's.
//!
//! A GPU's own `malloc` serves all threads from one heap, one after another. Heaps begin small, so that many fit; one that is
//! full takes chunks from a [`Pool`] that all share.

use std::alloc::Layout;
use std::sync::atomic::{AtomicU64, Ordering};

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
    /// The address of the [`Pool`], and of the chunk that was taken from it last; 0 for none.
    pool: u64,
    chunk: u64,
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
    /// Makes an empty heap of `size` bytes at this address. What a heap that was there before had of the pool goes back.
    ///
    /// # Safety
    /// The memory is aligned to 128 bytes, larger than the head, zero or a heap, and nobody's else as long as the heap is used;
    /// the pool stays as long as it.
    pub unsafe fn place(at: *mut u8, size: u64, pool: *const Pool) {
        let start = at as u64;
        let (next, end) = (start + size_of::<Self>() as u64, start + size);
        let empty = Self { next, end, pool: pool as u64, chunk: 0, free: [[0; CLASSES]; 2] };
        let heap = at.cast::<Self>();
        // SAFETY: as the caller promises; of zeros, there is no chunk.
        unsafe {
            let mut chunk = (*heap).chunk as *mut Chunk;
            while let Some(Chunk { before, size }) = chunk.as_ref().copied() {
                (*pool).give(chunk.cast(), size as usize);
                chunk = before as *mut Chunk;
            }
            heap.write(empty);
        }
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
        let align = if wide { WIDE.max(layout.align() as u64) } else { 16 };
        if size > self.end.saturating_sub(self.next.next_multiple_of(align)) && !self.grow(size + align) {
            return std::ptr::null_mut();
        }
        let at = self.next.next_multiple_of(align);
        self.next = at + size;
        at as *mut u8
    }

    /// Takes a chunk from the pool with room for this many bytes; says whether there was one.
    #[inline(never)]
    fn grow(&mut self, room: u64) -> bool {
        // SAFETY: the pool stays as long as the heap.
        let Some(pool) = (unsafe { (self.pool as *const Pool).as_ref() }) else { return false };
        let Some((at, size)) = pool.take(room + size_of::<Chunk>() as u64) else { return false };
        let chunk = at as u64;
        // SAFETY: the chunk is this heap's alone.
        unsafe { at.cast::<Chunk>().write(Chunk { before: self.chunk, size: size as u64 }) };
        self.chunk = chunk;
        self.next = chunk + size_of::<Chunk>() as u64;
        self.end = chunk + (CHUNK << size);
        true
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

/// The smallest chunk of a pool, bytes; each size is twice the one before.
const CHUNK: u64 = 64 << 10;
/// Sizes of chunks, up to 2 GB.
const SIZES: usize = 16;

/// What a heap's chunk begins with.
#[repr(C)]
#[derive(Clone, Copy)]
struct Chunk {
    /// The chunk that the heap took before this one, 0 for the first.
    before: u64,
    /// Its size, as a number of doublings.
    size: u64,
}

/// Chunks of memory, for heaps that are full.
#[repr(C)]
#[derive(Debug)]
pub struct Pool {
    start: u64,
    end: u64,
    /// Where what was never given out begins.
    next: AtomicU64,
    /// The first free chunk of each size: in the lower half its place, counted in the smallest chunks from 1 on, or 0; in the
    /// upper half the number of changes, by which a thread sees that another was faster. A free chunk begins with the place of
    /// the next one.
    free: [AtomicU64; SIZES],
}

impl Pool {
    /// A pool of the memory from `start` on.
    #[must_use]
    pub fn new(start: u64, bytes: u64) -> Self {
        Self { start, end: start + bytes, next: AtomicU64::new(start), free: Default::default() }
    }

    /// A chunk of at least this many bytes, and its size as a number of doublings.
    fn take(&self, bytes: u64) -> Option<(*mut u8, usize)> {
        let size = bytes.div_ceil(CHUNK).next_power_of_two().ilog2() as usize;
        let free = self.free.get(size)?;
        let mut head = free.load(Ordering::Acquire);
        while head as u32 != 0 {
            let chunk = (self.start + (u64::from(head as u32) - 1) * CHUNK) as *mut u8;
            // SAFETY: it was free a moment ago. If it is no more, what is read isn't used.
            let after = unsafe { chunk.cast::<u32>().read_volatile() };
            let changed = ((head >> 32) + 1) << 32 | u64::from(after);
            match free.compare_exchange(head, changed, Ordering::AcqRel, Ordering::Acquire) {
                Ok(_) => return Some((chunk, size)),
                Err(other) => head = other,
            }
        }
        let wanted = CHUNK << size;
        let mut next = self.next.load(Ordering::Relaxed);
        while wanted <= self.end - next {
            match self.next.compare_exchange(next, next + wanted, Ordering::Relaxed, Ordering::Relaxed) {
                Ok(_) => return Some((next as *mut u8, size)),
                Err(other) => next = other,
            }
        }
        None
    }

    /// Takes a chunk back.
    ///
    /// # Safety
    /// The pool has given it out, with this size, and nobody uses it any more.
    unsafe fn give(&self, chunk: *mut u8, size: usize) {
        let place = (chunk as u64 - self.start) / CHUNK + 1;
        let free = &self.free[size];
        let mut head = free.load(Ordering::Relaxed);
        loop {
            // SAFETY: as the caller promises.
            unsafe { chunk.cast::<u32>().write_volatile(head as u32) };
            let changed = ((head >> 32) + 1) << 32 | place;
            match free.compare_exchange(head, changed, Ordering::AcqRel, Ordering::Relaxed) {
                Ok(_) => return,
                Err(other) => head = other,
            }
        }
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
            memory.write_bytes(0, 1 << 20);
            Heap::place(memory, 1 << 20, std::ptr::null());
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

    /// Memory of this many bytes, all zero.
    fn memory(bytes: u64) -> Vec<[u128; 8]> {
        vec![[0; 8]; bytes as usize / 128 + 1]
    }

    #[test]
    fn full_heaps_take_chunks_and_give_them_back() {
        let mut spare = memory(16 * CHUNK);
        let pool = Pool::new(spare.as_mut_ptr() as u64, 16 * CHUNK);
        let mut own = memory(4096);
        let place = own.as_mut_ptr().cast::<u8>();
        let block = Layout::from_size_align(3000, 8).unwrap();
        let large = Layout::from_size_align(3 * CHUNK as usize, 8).unwrap();
        for _ in 0..50 {
            // SAFETY: it is this test's own, large enough, and zero or a heap.
            let heap = unsafe {
                Heap::place(place, 4096, &pool);
                &mut *place.cast::<Heap>()
            };
            // Four chunks together hold the large block and 21 others, as each of the other twelve does. The heap's own memory
            // has no room after its head.
            assert!(!heap.alloc(large).is_null());
            let count = (0..).take_while(|_| !heap.alloc(block).is_null()).count();
            assert_eq!(count, 13 * 21);
        }
    }

    #[test]
    fn threads_never_hold_the_same_chunk() {
        let mut spare = memory(64 * CHUNK);
        let start = spare.as_mut_ptr() as u64;
        let pool = Pool::new(start, 64 * CHUNK);
        std::thread::scope(|scope| {
            for thread in 0..4_u64 {
                let pool = &pool;
                scope.spawn(move || {
                    let mut random = Stream::new(thread, &["pool"]);
                    let mut held: Vec<(u64, usize)> = Vec::new();
                    for _ in 0..20_000 {
                        if held.len() > 5 || (!held.is_empty() && random.below(2) == 0) {
                            let (at, size) = held.swap_remove(random.below(held.len() as u64) as usize);
                            let mark = (at + 64) as *mut u64;
                            // SAFETY: the chunk is this thread's until it is given back.
                            unsafe {
                                assert_eq!(mark.read_volatile(), thread, "another thread has written here");
                                pool.give(at as *mut u8, size);
                            }
                            continue;
                        }
                        let Some((chunk, size)) = pool.take(1 + random.below(2 * CHUNK)) else { continue };
                        // SAFETY: the chunk is this thread's now.
                        unsafe { chunk.add(64).cast::<u64>().write_volatile(thread) };
                        held.push((chunk as u64, size));
                    }
                });
            }
        });
        let free: u64 = std::iter::from_fn(|| pool.take(1)).count() as u64;
        assert!(free > 0 && free <= 64, "{free}");
    }
}
