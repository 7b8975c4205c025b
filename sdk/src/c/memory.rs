//! Memory behind the pointers of C structs.

use std::any::Any;
use std::ffi::{CStr, CString, c_char};

/// Owns the memory behind the pointers of a lowered struct. It must outlive their use.
#[derive(Debug, Default)]
pub struct Arena {
    texts: Vec<CString>,
    blocks: Vec<Box<dyn Any>>,
}

impl Arena {
    /// Frees everything: its pointers become invalid.
    pub fn clear(&mut self) {
        self.texts.clear();
        self.blocks.clear();
    }

    /// A text for C, up to its first 0.
    pub fn text(&mut self, text: &str) -> *const c_char {
        let end = text.find('\0').unwrap_or(text.len());
        let text = CString::new(&text.as_bytes()[..end]).unwrap_or_default();
        let pointer = text.as_ptr();
        self.texts.push(text);
        pointer
    }

    /// The address of a value.
    pub(super) fn one<T: 'static>(&mut self, value: T) -> *const T {
        let value = Box::new(value);
        let pointer: *const T = &raw const *value;
        self.blocks.push(value);
        pointer
    }

    /// The address of the first value.
    pub(super) fn list<T: 'static>(&mut self, values: Vec<T>) -> *const T {
        let pointer = values.as_ptr();
        self.blocks.push(Box::new(values));
        pointer
    }
}

/// # Safety
/// The pointer refers to this number of values, or is null, or the number is 0.
pub(super) unsafe fn slice<'a, T>(pointer: *const T, len: usize) -> &'a [T] {
    if pointer.is_null() || len == 0 {
        return &[];
    }
    // SAFETY: by this function's own condition.
    unsafe { std::slice::from_raw_parts(pointer, len) }
}

/// # Safety
/// The pointer refers to a text that ends with 0, or is null.
pub(super) unsafe fn text(pointer: *const c_char) -> String {
    if pointer.is_null() {
        return String::new();
    }
    // SAFETY: by this function's own condition.
    unsafe { CStr::from_ptr(pointer) }.to_string_lossy().into_owned()
}
