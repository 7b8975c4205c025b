//! The reasons why a bag is no recording.

use std::path::PathBuf;

/// The reason why a bag can't be read or contains no recording.
#[derive(Debug, thiserror::Error)]
pub enum BagError {
    /// The file or folder can't be read.
    #[error("{path}: {source}", path = .path.display())]
    Read {
        /// The file or folder.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The file is no MCAP file, or a damaged one.
    #[error("{path}: {problem}", path = .path.display())]
    Format {
        /// The file or folder.
        path: PathBuf,
        /// The problem, with the next step.
        problem: String,
    },
    /// A message can't be decoded.
    #[error("{path}: a message on {topic} can't be decoded as {kind}: {problem}", path = .path.display())]
    Message {
        /// The file.
        path: PathBuf,
        /// The topic of the message.
        topic: String,
        /// The type of the message.
        kind: &'static str,
        /// The problem.
        problem: String,
    },
    /// The bag has no topic of a kind, or several.
    #[error("{0}")]
    Topic(String),
    /// The drive has no window without a gap.
    #[error("{0}")]
    Windows(String),
}
