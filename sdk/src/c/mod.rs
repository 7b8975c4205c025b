//! The C interface, declared for C and C++ in `sdk/c/vb_planner.h`: structs, and functions that use them.
//!
//! Native plugins of all languages are called through it. Rust plugins export the functions in a root module whose
//! layout `abi_stable` checks ([`crate::native`]), C plugins in the symbol [`ENTRY`].

#[rustfmt::skip]
mod layout;
mod memory;

use std::ffi::{c_char, c_void};

use abi_stable::StableAbi;

pub use layout::*;
pub use memory::Arena;

/// `VB_ABI_MAJOR` and `VB_ABI_MINOR`.
pub const ABI: (u32, u32) = (1, 0);
/// `VB_ERROR_BYTES`.
pub const ERROR_BYTES: usize = 1024;
/// The name of the symbol, for the dynamic loader.
pub const ENTRY: &[u8] = b"vb_planner_entry\0";
/// `VB_OK`.
pub const OK: i32 = 0;
/// `VB_FAILED`.
pub const FAILED: i32 = 1;
/// `VB_PANICKED`.
pub const PANICKED: i32 = 2;

/// `vb_error`: the text ends with 0.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
#[allow(missing_docs, reason = "described in the header")]
pub struct CError {
    pub message: [c_char; ERROR_BYTES],
}

impl Default for CError {
    fn default() -> Self {
        Self { message: [0; ERROR_BYTES] }
    }
}

impl CError {
    /// Stores a text, truncated to the buffer.
    pub fn set(&mut self, text: &str) {
        let mut end = text.len().min(ERROR_BYTES - 1);
        while !text.is_char_boundary(end) {
            end -= 1;
        }
        self.message = [0; ERROR_BYTES];
        for (to, from) in self.message.iter_mut().zip(text[..end].bytes()) {
            *to = c_char::from_ne_bytes([from]);
        }
    }

    /// The text; `None` if it is empty.
    #[must_use]
    pub fn get(&self) -> Option<String> {
        let bytes: Vec<u8> =
            self.message.iter().take_while(|c| **c != 0).map(|c| c.to_ne_bytes()[0]).collect();
        (!bytes.is_empty()).then(|| String::from_utf8_lossy(&bytes).into_owned())
    }
}

/// `vb_host`: the functions of the harness during a call.
#[repr(C)]
#[derive(Clone, Copy, Debug, StableAbi)]
#[allow(missing_docs, reason = "described in the header")]
pub struct CHost {
    pub context: *mut c_void,
    pub log: unsafe extern "C" fn(context: *mut c_void, level: u32, message: *const c_char),
}

/// `vb_planner_functions`.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
#[allow(missing_docs, reason = "described in the header")]
pub struct CFunctions {
    pub size: usize,
    pub abi_major: u32,
    pub abi_minor: u32,
    pub init: Option<unsafe extern "C" fn(*const CTask, *const CHost, *mut *mut c_void, *mut CError) -> i32>,
    pub step: Option<
        unsafe extern "C" fn(
            *mut c_void,
            *const CObservation,
            *const CHost,
            *mut CCommand,
            *mut CError,
        ) -> i32,
    >,
    pub free: Option<unsafe extern "C" fn(*mut c_void)>,
}

impl Default for CCommand {
    /// The default command: all zero, i.e. forward without throttle and brake.
    fn default() -> Self {
        Self { steering: 0.0, throttle: 0.0, brake: 0.0, gear: 0, debug: std::ptr::null(), debug_len: 0 }
    }
}
