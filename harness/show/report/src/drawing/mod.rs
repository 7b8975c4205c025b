//! The figures of a report: each is drawn here, once, for the page and for the files of a paper.
//!
//! A drawing is SVG whose styles are classes. Its texts have 12 units (11 at axes), so whoever shows it chooses its width in these
//! units, and with it how large the texts are in it: the page a fixed one, a file the one that gives its texts their size in
//! points.

mod causes;
mod distribution;
mod forest;
mod levels;
mod profile;
mod robustness;
pub(crate) mod series;

pub(crate) use causes::causes;
pub(crate) use distribution::{Quantity, Scale, distribution};
pub(crate) use forest::forest;
pub(crate) use levels::{Beside, NAMES, level_frame, levels, panel, top};
pub(crate) use profile::profile;
pub(crate) use robustness::robustness;

use std::fmt::Write as _;

use vb_figure::{Weight, text_width};
use vb_page::plot::Frame;
use vb_page::{PLOT_STYLE, TABLE_STYLE, escape, print_style};

/// The style of drawings beyond that of plots.
pub(crate) const DRAWING_STYLE: &str = include_str!("drawing.css");
/// The style of pages.
pub(crate) const PAGE_STYLE: &str = include_str!("page.css");
/// Units of most texts.
pub(crate) const TEXT: f64 = 12.0;
/// Width of a figure on the page, in units.
pub(crate) const PAGE_FIGURE: f64 = 460.0;

/// The style of drawings in files of their own, with these rules beside.
pub(crate) fn file_style(rules: &str) -> String {
    print_style(&[PLOT_STYLE, DRAWING_STYLE, rules], &[TABLE_STYLE, PAGE_STYLE])
}

/// What is drawn, in units of its own from (0, 0) to (`width`, `height`).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Drawing {
    /// What it is called, as text.
    pub(crate) title: String,
    /// What stands small behind the title on the page: a unit.
    pub(crate) note: &'static str,
    pub(crate) width: f64,
    pub(crate) height: f64,
    /// What is drawn, as SVG.
    pub(crate) body: String,
}

impl Drawing {
    /// A drawing in a frame.
    fn new(title: impl Into<String>, frame: &Frame, body: String) -> Self {
        Self { title: title.into(), note: "", width: frame.width, height: frame.height, body }
    }

    /// The drawing as a figure of the page.
    pub(crate) fn show(&self, s: &mut String) {
        let title = escape(&self.title);
        let note = if self.note.is_empty() {
            String::new()
        } else {
            format!(" <small>{}</small>", escape(self.note))
        };
        let _ = write!(
            s,
            "<figure><figcaption>{title}{note}</figcaption><svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{title}\">{}</svg></figure>",
            self.width, self.height, self.body
        );
    }
}

/// How much wider than in the font of files a text may be: pages are shown in the machine's own font.
const SLACK: f64 = 1.12;

/// Units that a text of this size takes on one line, on the page too.
pub(crate) fn width(text: &str, size: f64) -> f64 {
    SLACK * size * text_width(text, Weight::Regular)
}

/// Foreign text on one line, cut with an ellipsis so that it takes so many units at most.
pub(crate) fn fit(text: &str, size: f64, most: f64) -> String {
    let line = crate::runs::one_line(text, 200);
    if width(&line, size) <= most {
        return line;
    }
    let room = most - width("…", size);
    let mut end = 0;
    let mut taken = 0.0;
    for (at, c) in line.char_indices() {
        taken += width(c.encode_utf8(&mut [0; 4]), size);
        if taken > room {
            break;
        }
        end = at + c.len_utf8();
    }
    format!("{}…", line[..end].trim_end())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_cut_where_their_room_ends() {
        // Helvetica's a is 0.556 em wide, and its ellipsis 1 em.
        assert_eq!(fit("aaaa", 10.0, 22.3 * SLACK), "aaaa");
        assert_eq!(fit("aaaaa", 10.0, 22.3 * SLACK), "aa…");
        assert_eq!(fit("a\u{202e}\nb", 10.0, 100.0), "a\u{fffd} b");
        assert_eq!(fit("abc", 10.0, 1.0), "…");
    }

    #[test]
    fn the_style_of_files_has_no_variables() {
        let style = file_style("");
        assert!(!style.contains("var(") && !style.contains('@'), "{style}");
    }
}
