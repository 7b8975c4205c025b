//! Rust errors as exceptions of the package.

use pyo3::prelude::*;
use vb_env::EnvError;

/// Returns the exception for an error: a class of `vertibench._errors`, with the same text.
pub(crate) fn exception(py: Python<'_>, error: &EnvError) -> PyErr {
    let class = match error {
        EnvError::ActionLength { .. } | EnvError::Action { .. } => "ActionError",
        EnvError::NoEpisode | EnvError::Ended(_) | EnvError::Pending(_) | EnvError::Nothing => "EpisodeError",
        // The options are valid: other tasks can be begun.
        error if error.is_divergence() => "EpisodeError",
        EnvError::TaskId(_) | EnvError::NoTask { .. } | EnvError::NoEnv { .. } => "UnknownError",
        EnvError::Panic(_) => "PanicError",
        _ => "OptionError",
    };
    named(py, class, &error.to_string())
}

/// Returns an exception of the package, by the name of its class.
pub(crate) fn named(py: Python<'_>, class: &str, message: &str) -> PyErr {
    // Messages of libraries may have several lines.
    let message = vb_files::one_line(message);
    let made = py
        .import("vertibench._errors")
        .and_then(|errors| errors.getattr(class))
        .and_then(|class| class.call1((message,)));
    match made {
        Ok(value) => PyErr::from_value(value),
        Err(error) => error,
    }
}

/// Calls a function without Python's lock. A panic becomes an error, because it must not end the interpreter.
pub(crate) fn guarded<T: Send>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, EnvError> + Send,
) -> PyResult<T> {
    py.detach(|| vb_env::guarded(work)).map_err(|e| exception(py, &e))
}
