//! Arrays of which several threads write different rows.

use std::cell::UnsafeCell;

/// Rows of numbers, one for each environment, in one piece of memory that never moves.
///
/// Whoever is at work on environment `i` owns row `i`: [`crate::VectorEnv`] hands a row to a thread with the job, and has it
/// back when the thread says that the job is done, over locks, so that two never touch a row at the same time.
pub(crate) struct Rows<T> {
    data: Box<[UnsafeCell<T>]>,
    width: usize,
}

// SAFETY: rows are handed from thread to thread as said above; their numbers are plain data.
unsafe impl<T: Send> Sync for Rows<T> {}

impl<T: Copy + Default> Rows<T> {
    pub(crate) fn new(count: usize, width: usize) -> Self {
        Self { data: (0..count * width).map(|_| UnsafeCell::new(T::default())).collect(), width }
    }

    /// A row, to be written.
    ///
    /// # Safety
    /// Nobody else uses this row as long as what is returned lives.
    #[allow(clippy::mut_from_ref, reason = "that nobody else uses the row is the caller's promise")]
    pub(crate) unsafe fn row(&self, index: usize) -> &mut [T] {
        let cells = &self.data[index * self.width..(index + 1) * self.width];
        // SAFETY: the cells of a row are in one piece, and the caller promises that nobody else uses them.
        unsafe { std::slice::from_raw_parts_mut(cells.as_ptr().cast_mut().cast::<T>(), cells.len()) }
    }

    /// Where the first number lies. The memory stays in its place as long as this lives.
    pub(crate) fn pointer(&self) -> *mut T {
        self.data.as_ptr().cast_mut().cast::<T>()
    }

    pub(crate) fn width(&self) -> usize {
        self.width
    }
}
