//! Why a fleet can't be had, or can't go on.

use std::path::PathBuf;

use cudarc::driver::DriverError;

#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    #[error("a fleet has at least one vehicle and one task")]
    Empty,
    #[error("no GPU: CUDA's driver, libcuda, is not installed")]
    NoDriver,
    #[error("no GPU {wanted}; {found} GPUs are available, counted from 0")]
    NoDevice { wanted: usize, found: i32 },
    #[error(
        "kernels exist for GPUs of compute capability {known} and later ones of these generations; {name} has {major}.{minor}"
    )]
    Architecture { name: String, major: i32, minor: i32, known: String },
    #[error("{path}: {source}; build it with `cargo xtask kernel`")]
    Kernel { path: PathBuf, source: std::io::Error },
    #[error(
        "{path}: these kernels are built from other sources than this program, so their states would differ; rebuild them with `cargo xtask kernel`"
    )]
    OtherSources { path: PathBuf },
    #[error(
        "{vehicles} vehicles and {tasks} tasks need {needed} MB of the GPU's memory, of which {free} MB are free: use \
             fewer, or less memory"
    )]
    Memory {
        vehicles: usize,
        tasks: usize,
        /// MB that are needed.
        needed: u64,
        /// MB that are free.
        free: u64,
    },
    #[error(
        "the kernels can't use this setting: they are from another version than this program; rebuild them with `cargo xtask kernel`"
    )]
    Setting,
    #[error("the setting can't be sent: {0}")]
    Encode(String),
    #[error("{what} has {given} rows for {wanted} vehicles")]
    Length { what: &'static str, given: usize, wanted: usize },
    #[error("the controls of vehicle {vehicle} contain a number that is not finite")]
    Controls { vehicle: usize },
    #[error("task {task} of vehicle {vehicle} does not exist: there are {tasks} tasks, counted from 0")]
    Task { vehicle: usize, task: usize, tasks: usize },
    #[error(
        "{differ} of {of} vehicles have other states on this GPU than on the CPU: do not use this GPU, and report its \
             name and driver version"
    )]
    Differ { differ: usize, of: usize },
    #[error("{doing}: {message}{}", hint(message))]
    Cuda { doing: &'static str, message: String },
}

/// What is most likely wrong where a launch fails.
fn hint(message: &str) -> &'static str {
    if message.contains("LAUNCH_FAILED") {
        "; probably the vehicles exceeded the spare memory (`memory` in Python, `Options::spare_memory`). The fleet is lost"
    } else {
        ""
    }
}

/// What CUDA says, with what was being done.
pub(crate) fn cuda(doing: &'static str) -> impl Fn(DriverError) -> GpuError {
    move |error| {
        let name = error.error_name().ok().map(|name| name.to_string_lossy().into_owned());
        let text = error.error_string().ok().map(|text| text.to_string_lossy().into_owned());
        let message =
            format!("{} ({})", text.unwrap_or_default(), name.unwrap_or_else(|| format!("{:?}", error.0)));
        GpuError::Cuda { doing, message }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_say_what_to_do() {
        let launch =
            GpuError::Cuda { doing: "a step", message: "unspecified (CUDA_ERROR_LAUNCH_FAILED)".into() };
        assert!(launch.to_string().contains("spare_memory"), "{launch}");
        let memory = GpuError::Memory { vehicles: 9, tasks: 1, needed: 10, free: 5 };
        assert!(memory.to_string().contains("use fewer"), "{memory}");
    }
}
