//! Why a picture can't be drawn.

#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    #[error(
        "a picture of {width} × {height} pixels cannot be rendered (each side can have 1 to {most} pixels)"
    )]
    Size { width: u32, height: u32, most: u32 },
    #[error("a window of {0} m cannot be rendered (its side must be a positive length)")]
    Window(
        /// The side asked for, m.
        f64,
    ),
    #[error("a vertical or non-finite line of sight cannot be rendered")]
    Sight,
    #[error("a vehicle with a non-finite pose cannot be rendered")]
    Pose,
}
