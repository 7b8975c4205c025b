//! What a GPU runs: many simulations at a time, a thread for each.
//!
//! The simulator is compiled for the GPU as it is, with rapier and parry, and all its arithmetic is that of the CPU: no
//! operations are fused, and elementary functions are those of `libm`. So a simulation there has the same state hash as one
//! here, bit for bit. `cargo xtask kernel` builds the kernels, and `vb-gpu` loads and launches them.
//!
//! [`fleet`] is what the kernels do, as plain functions of the number of a thread, which tests call one after another.
//! [`wire`] is what is sent to the GPU, and [`heap`] the memory of each simulation there.

#![cfg_attr(target_arch = "nvptx64", feature(abi_ptx, stdarch_nvptx))]

#[cfg(target_arch = "nvptx64")]
mod device;
pub mod fleet;
pub mod heap;
#[cfg(target_arch = "nvptx64")]
mod memory;
pub mod wire;

/// What tells of which sources kernels are. It stands in their file, so that a program finds there whether they are of its own: others
/// would drive otherwise than it.
pub const SOURCES: &str = concat!("vb-kernel of ", env!("VB_KERNEL_SOURCES"), "\n");
