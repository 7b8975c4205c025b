//! A drawing that is laid over a picture.

use resvg::tiny_skia::{IntRect, NonZeroRect, Pixmap, Transform};
use resvg::usvg::{Options, Tree};

use crate::font::FAMILY;
use crate::print::{FigureError, database};

/// A drawing on clear ground, such as the caption of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlay {
    /// The part of the drawing that isn't clear.
    pixels: Pixmap,
    /// Where the upper left corner of this part lies in the drawing.
    corner: [usize; 2],
}

impl Overlay {
    /// Draws SVG elements, whose unit is a pixel, on clear ground of so many columns and rows. `style` is a style sheet of simple
    /// selectors; texts are in Liberation Sans.
    ///
    /// # Errors
    /// Returns an error if `body` is no SVG, or if there are no pixels.
    pub fn new(style: &str, body: &str, [width, height]: [u32; 2]) -> Result<Self, FigureError> {
        let failed = |reason: String| FigureError::Svg { title: "caption".to_owned(), reason };
        let document = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\"><style>text{{font-family:\"{FAMILY}\"}}{style}</style>\
             {body}</svg>"
        );
        let options = Options { fontdb: database(), font_family: FAMILY.to_owned(), ..Options::default() };
        let tree = Tree::from_str(&document, &options).map_err(|e| failed(e.to_string()))?;
        let mut pixels = Pixmap::new(width, height).ok_or_else(|| failed("it has no size".to_owned()))?;
        resvg::render(&tree, Transform::identity(), &mut pixels.as_mut());
        // A caption covers little of a frame: only that is kept, and laid over each time. It is drawn in its place, not where the part
        // begins, so that rounding is the same for every part.
        let covered = covered(tree.root().abs_layer_bounding_box(), [width, height]);
        let part = covered.and_then(|part| Some((pixels.clone_rect(part)?, [part.left(), part.top()])));
        let (pixels, corner) = part.unwrap_or((pixels, [0, 0]));
        Ok(Self { pixels, corner: corner.map(|v| usize::try_from(v).unwrap_or(0)) })
    }

    /// Lays the drawing over a picture of rows of red, green and blue from the top, `columns` pixels wide, with its upper left corner
    /// at (x, y). What reaches beyond the picture is left out.
    pub fn lay_over(&self, picture: &mut [u8], columns: usize, [x, y]: [usize; 2]) {
        let own = self.pixels.width() as usize;
        let [x, y] = [x + self.corner[0], y + self.corner[1]];
        let rows = picture.chunks_exact_mut(3 * columns.max(1)).skip(y);
        for (row, source) in rows.zip(self.pixels.pixels().chunks_exact(own)) {
            for (dot, over) in row.chunks_exact_mut(3).skip(x).zip(source) {
                // Colours of the drawing are multiplied by their opacity already.
                let rest = 255 - u32::from(over.alpha());
                for (under, own) in dot.iter_mut().zip([over.red(), over.green(), over.blue()]) {
                    let sum = u32::from(own) + (u32::from(*under) * rest + 127) / 255;
                    *under = sum.min(255) as u8;
                }
            }
        }
    }
}

/// The pixels within `size` that a drawing with this bounding box can touch: those at its edge are covered in part, and lines of no
/// width have one.
fn covered(drawn: NonZeroRect, size: [u32; 2]) -> Option<IntRect> {
    let range = |from: f32, to: f32, most: u32| {
        let most = i64::from(most);
        let from = (from.floor() as i64 - 1).clamp(0, most - 1);
        (from, (to.ceil() as i64 + 1).clamp(from + 1, most))
    };
    let (left, right) = range(drawn.left(), drawn.right(), size[0]);
    let (top, bottom) = range(drawn.top(), drawn.bottom(), size[1]);
    let [left, top, right, bottom] = [left, top, right, bottom].map(i32::try_from);
    IntRect::from_ltrb(left.ok()?, top.ok()?, right.ok()?, bottom.ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_covered_is_kept_and_nothing_of_it_is_lost() {
        // Letters that reach beyond their advance, below the line and above capitals; a stroke; what lies half outside.
        let bodies = [
            "<text x=\"30.3\" y=\"40.7\">ÅjfQ</text>",
            "<rect x=\"20.5\" y=\"9\" width=\"30\" height=\"11.25\" stroke=\"#f00\" stroke-width=\"3\"/><text x=\"2\" y=\"60\">g</text>",
            "<g transform=\"rotate(30)\"><text x=\"50\" y=\"10\">…</text></g>",
            "<text x=\"-7\" y=\"4\">gap</text>",
            "<text x=\"104\" y=\"83\">gap</text>",
            "<rect x=\"300\" y=\"300\" width=\"5\" height=\"5\"/>",
            "",
        ];
        let blank = "<rect width=\"120\" height=\"80\" fill=\"#fff\" fill-opacity=\"0\"/>";
        for body in bodies {
            let drawn = |body: &str| Overlay::new("text{font-size:24px}", body, [120, 80]).unwrap();
            // With something clear all over it, all of it is kept.
            let (part, whole) = (drawn(body), drawn(&format!("{blank}{body}")));
            assert_eq!((whole.pixels.width(), whole.pixels.height()), (120, 80));
            assert!(part.pixels.width() < 120 && part.pixels.height() < 80, "{body}");
            let [mut a, mut b] = [vec![200; 150 * 100 * 3], vec![200; 150 * 100 * 3]];
            part.lay_over(&mut a, 150, [10, 5]);
            whole.lay_over(&mut b, 150, [10, 5]);
            assert!(a == b, "{body}");
        }
    }

    #[test]
    fn opacity_mixes_drawing_and_picture() {
        // Two columns of white at 50 and 100 %, one that stays clear.
        let body = "<rect width=\"1\" height=\"1\" class=\"w\" opacity=\"0.5\"/><rect x=\"1\" width=\"1\" height=\"1\" class=\"w\"/>";
        let overlay = Overlay::new(".w{fill:#fff}", body, [3, 1]).unwrap();
        let mut picture = vec![100; 2 * 4 * 3];
        overlay.lay_over(&mut picture, 4, [1, 1]);
        assert_eq!(picture[..15], [100; 15], "above and left of it nothing changes");
        // (100 + 255) / 2, and white.
        assert!(picture[15..18].iter().all(|v| (177..=178).contains(v)), "{:?}", &picture[15..18]);
        assert_eq!(picture[18..], [255, 255, 255, 100, 100, 100]);
        // Beyond the edges it is cut off.
        overlay.lay_over(&mut picture, 4, [3, 1]);
        overlay.lay_over(&mut picture, 4, [9, 9]);
    }

    #[test]
    fn texts_are_drawn_without_fonts_of_the_machine() {
        let overlay =
            Overlay::new("text{fill:#000;font-size:20px}", "<text x=\"2\" y=\"20\">Il</text>", [40, 26])
                .unwrap();
        let mut picture = vec![255; 40 * 26 * 3];
        overlay.lay_over(&mut picture, 40, [0, 0]);
        let dark = picture.chunks(3).filter(|p| p[0] < 128).count();
        // Two strokes about 14 pixels high and 2 wide.
        assert!((40..=90).contains(&dark), "{dark}");
        assert!(Overlay::new("", "<text", [4, 4]).is_err() && Overlay::new("", "", [0, 4]).is_err());
    }
}
