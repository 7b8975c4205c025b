//! Figures for papers: a drawing with its style and its font as an SVG, a PDF and a PNG file that need nothing else.
//!
//! A [`Figure`] is drawn once, as SVG whose styles are classes, and the other formats are made from it: PDF by krilla, PNG by
//! resvg, both with the feature `print`. The font is Liberation Sans, which has the widths of Helvetica and Arial, as journals want them; its licence (SIL OFL
//! 1.1) lies beside it. An [`Overlay`] is a drawing with the same font that is laid over a picture. The same figure always gives the same bytes: nothing holds a date, or an identifier that is drawn.

mod figure;
mod font;
#[cfg(feature = "print")]
mod overlay;
#[cfg(feature = "print")]
mod print;
mod web_font;

pub use figure::Figure;
pub use font::{Weight, text_width};
#[cfg(feature = "print")]
pub use overlay::Overlay;
#[cfg(feature = "print")]
pub use print::FigureError;
