//! What is written over pictures.

use std::fmt::Write as _;

use vb_figure::{FigureError, Overlay, Weight, text_width};
use vb_page::{escape, number};
use vb_render::Size;

/// Rows of a panel for one row of a letter's em, and the least and the greatest size of letters, pixels.
const LINES: f64 = 32.0;
const SIZES: [f64; 2] = [10.0, 26.0];

/// What the caption says of a run at a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Said<'a> {
    pub(crate) label: &'a str,
    pub(crate) colour: [u8; 3],
    /// s
    pub(crate) time: f64,
    /// m/s
    pub(crate) speed: f64,
    /// Degrees.
    pub(crate) roll: f64,
    /// Degrees.
    pub(crate) pitch: f64,
    /// How the run ended, and whether it was a success, once it has ended.
    pub(crate) ended: Option<(&'a str, bool)>,
}

/// A text that is cut to a width in multiples of the letters' size.
fn cut(text: &str, weight: Weight, width: f64) -> String {
    if text_width(text, weight) <= width {
        return text.to_owned();
    }
    let mut kept = String::new();
    for c in text.chars() {
        kept.push(c);
        if text_width(&kept, weight) + text_width("…", weight) > width {
            kept.pop();
            break;
        }
    }
    format!("{}…", kept.trim_end())
}

/// Draws lines of text, each bold or not and of a class, on a dark ground in a corner of a panel, with a strip of this colour at its left
/// edge.
fn lines(
    lines: &[(String, Weight, &str)],
    size: Size,
    top: bool,
    strip: Option<[u8; 3]>,
) -> Result<Overlay, FigureError> {
    let [width, height] = [size.width, size.height].map(f64::from);
    let em = (height / LINES).clamp(SIZES[0], SIZES[1]).round();
    let (edge, pad, lead) = ((0.6 * em).round(), 0.5 * em, 1.35 * em);
    let room = (width - 2.0 * edge) / em - 1.0;
    let texts: Vec<(String, Weight, &str)> =
        lines.iter().map(|(text, weight, class)| (cut(text, *weight, room), *weight, *class)).collect();
    let widest = texts.iter().map(|(text, weight, _)| text_width(text, *weight)).fold(0.0, f64::max);
    let (w, h) = (widest * em + 2.0 * pad, lead * texts.len() as f64 + pad);
    let y = if top { edge } else { height - edge - h };
    let mut body = format!(
        "<rect class=\"ground\" x=\"{edge}\" y=\"{y:.2}\" width=\"{w:.2}\" height=\"{h:.2}\" rx=\"{:.2}\"/>",
        0.3 * em
    );
    if let Some([r, g, b]) = strip {
        let _ = write!(
            body,
            "<rect fill=\"rgb({r},{g},{b})\" x=\"{edge}\" y=\"{y:.2}\" width=\"{:.2}\" height=\"{h:.2}\"/>",
            0.3 * em
        );
    }
    for (k, (text, _, class)) in texts.iter().enumerate() {
        let (x, y) = (edge + pad, y + 0.5 * pad + lead * (k as f64 + 0.78));
        let _ = write!(body, "<text class=\"{class}\" x=\"{x:.2}\" y=\"{y:.2}\">{}</text>", escape(text));
    }
    let style = format!(
        ".ground{{fill:#0c0f14;fill-opacity:.66}}text{{font-size:{em}px;fill:#fff}}.name{{font-weight:700}}\
         .good{{fill:#7fe0a8;font-weight:700}}.bad{{fill:#ffab91;font-weight:700}}"
    );
    Overlay::new(&style, &body, [size.width, size.height])
}

/// The caption of a panel: the run, and how it goes or how it ended.
pub(crate) fn of_run(said: &Said<'_>, size: Size) -> Result<Overlay, FigureError> {
    let time = format!("{:.1} s", said.time);
    let second = match said.ended {
        Some((how, good)) => (format!("{how} after {time}"), Weight::Bold, if good { "good" } else { "bad" }),
        None => {
            let text = format!(
                "{time} · {:.1} m/s · roll {}° · pitch {}°",
                said.speed,
                number(said.roll, 0),
                number(said.pitch, 0)
            );
            (text, Weight::Regular, "")
        }
    };
    lines(&[(said.label.to_owned(), Weight::Bold, "name"), second], size, false, Some(said.colour))
}

/// The caption of the film, in the upper corner of its first panel.
pub(crate) fn of_film(title: &str, size: Size) -> Result<Overlay, FigureError> {
    lines(&[(title.to_owned(), Weight::Regular, "")], size, true, None)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_cut_to_their_room() {
        assert_eq!(cut("a planner", Weight::Bold, 20.0), "a planner");
        let short = cut("a planner with a very long name", Weight::Bold, 8.0);
        assert!(short.ends_with('…') && short.starts_with("a plan"), "{short}");
        assert!(text_width(&short, Weight::Bold) <= 8.0);
    }

    #[test]
    fn captions_fit_into_the_smallest_panel_and_foreign_text_is_text() {
        let said = Said {
            label: "<b>&\u{1}",
            colour: [208, 122, 29],
            time: 1.0,
            speed: 2.0,
            roll: 3.0,
            pitch: -4.0,
            ended: Some(("stuck: high-centred", false)),
        };
        for size in [Size { width: 64, height: 64 }, Size { width: 1280, height: 720 }] {
            of_run(&said, size).unwrap();
            of_film("vb-100 w001/t00 · hmmwv", size).unwrap();
        }
    }
}
