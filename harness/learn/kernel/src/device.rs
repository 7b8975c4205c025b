//! The kernels' entry points, and what the standard library needs of an operating system beside memory.

use core::arch::nvptx;

use crate::fleet::{self, Fleet};

/// The number of this thread in its launch.
fn number() -> usize {
    // SAFETY: these only read registers.
    unsafe { (nvptx::_block_idx_x() * nvptx::_block_dim_x() + nvptx::_thread_idx_x()) as usize }
}

/// [`crate::SOURCES`], for whoever looks into the kernels' file.
#[used]
#[unsafe(no_mangle)]
static VB_SOURCES: [u8; crate::SOURCES.len()] = *crate::SOURCES.as_bytes().first_chunk().unwrap();

/// A kernel of a function of [`fleet`], for the first `threads` threads.
macro_rules! kernel {
    ($name:ident, $function:ident $(, $turn:ident)?) => {
        /// # Safety
        /// As for the function.
        #[unsafe(no_mangle)]
        pub unsafe extern "ptx-kernel" fn $name(fleet: *const Fleet, threads: u64 $(, $turn: u64)?) {
            let number = number();
            if (number as u64) < threads {
                // SAFETY: as the caller promises.
                unsafe { fleet::$function(&*fleet, number $(, $turn as usize)?) }
            }
        }
    };
}

/// # Safety
/// As for [`fleet::prepare`].
#[unsafe(no_mangle)]
pub unsafe extern "ptx-kernel" fn vb_prepare(fleet: *const Fleet) {
    // SAFETY: as the caller promises.
    unsafe { fleet::prepare(&*fleet) }
}

kernel!(vb_start, start);
kernel!(vb_reset, reset);
kernel!(vb_drive, drive, turn);
kernel!(vb_look, look, turn);
kernel!(vb_collide, collide, turn);
kernel!(vb_observe, observe);

/// The end of a thread, and with it of the whole launch: there is nobody who could be told more.
#[unsafe(no_mangle)]
extern "C" fn sys_panic(_: *const u8, _: usize) -> ! {
    // SAFETY: it ends the launch.
    unsafe { nvptx::trap() }
}

/// As `sys_panic`.
#[unsafe(no_mangle)]
extern "C" fn sys_halt() {
    // SAFETY: it ends the launch.
    unsafe { nvptx::trap() }
}

/// Nothing is random here.
#[unsafe(no_mangle)]
extern "C" fn sys_rand(_: *mut u32, _: usize) {}

/// Nothing is printed.
#[unsafe(no_mangle)]
extern "C" fn sys_write(_: u32, _: *const u8, _: usize) {}

/// Nothing is read.
#[unsafe(no_mangle)]
extern "C" fn sys_read(_: u32, _: *mut u8, _: usize) -> usize {
    0
}

/// There is no environment.
#[unsafe(no_mangle)]
extern "C" fn sys_getenv(_: *mut u32, _: usize, _: *const u8, _: usize) -> usize {
    usize::MAX
}

/// There are no arguments.
#[unsafe(no_mangle)]
extern "C" fn sys_argc() -> usize {
    0
}

/// There are no arguments.
#[unsafe(no_mangle)]
extern "C" fn sys_argv(_: *mut u32, _: usize, _: usize) -> usize {
    0
}

/// All memory is the allocator's.
#[unsafe(no_mangle)]
extern "C" fn sys_alloc_aligned(_: usize, _: usize) -> *mut u8 {
    std::ptr::null_mut()
}

/// Compares bytes.
///
/// # Safety
/// Both have as many.
#[unsafe(no_mangle)]
unsafe extern "C" fn memcmp(a: *const u8, b: *const u8, count: usize) -> i32 {
    for k in 0..count {
        // SAFETY: as the caller promises. Volatile, since the compiler would make a call of this function out of it.
        let (a, b) = unsafe { (a.add(k).read_volatile(), b.add(k).read_volatile()) };
        if a != b {
            return i32::from(a) - i32::from(b);
        }
    }
    0
}

/// Elementary functions of the platform, which libraries ask for where it makes no difference: `libm`'s.
macro_rules! elementary {
    ($($name:ident $single:ident),*) => {$(
        #[unsafe(no_mangle)]
        extern "C" fn $name(x: f64) -> f64 {
            libm::$name(x)
        }

        #[unsafe(no_mangle)]
        extern "C" fn $single(x: f32) -> f32 {
            libm::$single(x)
        }
    )*};
}

elementary!(sin sinf, cos cosf, exp expf, exp2 exp2f, log logf, log2 log2f, log10 log10f, acos acosf);

#[unsafe(no_mangle)]
extern "C" fn pow(x: f64, y: f64) -> f64 {
    libm::pow(x, y)
}

#[unsafe(no_mangle)]
extern "C" fn powf(x: f32, y: f32) -> f32 {
    libm::powf(x, y)
}
