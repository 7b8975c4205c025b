//! Why a picture can't be drawn.

/// An error of a picture.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The picture has no pixels, or too many.
    #[error("a picture of {width} × {height} pixels can't be drawn (each side can have 1 to {most} pixels)")]
    Size {
        /// The number of columns asked for.
        width: u32,
        /// The number of rows asked for.
        height: u32,
        /// The greatest number that either may be.
        most: u32,
    },
    /// The window of a view from above has no extent.
    #[error("a window of {0} m can't be drawn (its side must be a positive length)")]
    Window(
        /// The side asked for, m.
        f64,
    ),
    /// The line of sight has no direction, or is vertical.
    #[error("a line of sight that is vertical or isn't finite has no picture")]
    Sight,
    /// The vehicle's place or attitude is not a finite number.
    #[error("a vehicle at a pose that isn't finite can't be drawn")]
    Pose,
}
