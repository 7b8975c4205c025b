//! Why a picture can't be drawn.

#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    #[error("a picture of {width} × {height} pixels can't be drawn (each side can have 1 to {most} pixels)")]
    Size { width: u32, height: u32, most: u32 },
    #[error("a window of {0} m can't be drawn (its side must be a positive length)")]
    Window(
        /// The side asked for, m.
        f64,
    ),
    #[error("a line of sight that is vertical or isn't finite has no picture")]
    Sight,
    #[error("a vehicle at a pose that isn't finite can't be drawn")]
    Pose,
}
