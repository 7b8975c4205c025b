//! Fleets of simulations on a GPU: loads the kernels of `vb-kernel` and launches them.
//!
//! A [`Fleet`] has vehicles of one kind, each in one of its worlds, which are stepped together. Their states are those that a
//! CPU computes, bit for bit. CUDA is loaded when it is needed, so that a program with this library runs without it too.

mod code;
mod course;
mod drive;
mod error;
mod fleet;

pub use course::{Course, CourseError};
pub use drive::{CONTROL_PERIOD, Drive, same};
pub use error::GpuError;
pub use fleet::{Arrays, Fleet, Options, Start};
pub use vb_kernel::SOURCES;
pub use vb_kernel::fleet::{DIVERGED, FAULTS, FINE, NO_CONTROLS, NO_START, NO_TASK, STATE};
pub use vb_kernel::wire::{Place, Setting};
pub use vb_trial::defaults::TIME_STEP;

/// Whether CUDA's driver is installed here, so that there may be a GPU.
#[must_use]
pub fn is_there() -> bool {
    // SAFETY: it opens NVIDIA's library and closes it again.
    unsafe { cudarc::driver::sys::is_culib_present() }
}
