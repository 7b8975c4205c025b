//! A sheet on which drawings are laid out, from above to below.

use std::fmt::Write as _;

use vb_figure::{Figure, Weight, text_width};
use vb_page::escape;

use super::Paper;
use crate::drawing::{Drawing, TEXT, file_style, series};

/// Between drawings beside each other, and below each other.
const GAP: f64 = 14.0;
/// Space around the whole.
const EDGE: f64 = 3.0;

/// What is drawn so far, in units of drawings.
pub(super) struct Sheet {
    pub(super) width: f64,
    /// How far down it is full.
    pub(super) y: f64,
    /// What is on it, as SVG.
    pub(super) body: String,
    /// Points of a unit.
    scale: f64,
}

impl Sheet {
    /// A sheet of this width in inches, with the title that the paper wants on its figures.
    pub(super) fn new(paper: &Paper, inches: f64, title: Option<&str>) -> Self {
        let scale = paper.font_pt / TEXT;
        let mut sheet = Self { width: inches * 72.0 / scale, y: EDGE, body: String::new(), scale };
        if let Some(title) = title {
            sheet.title(title);
        }
        sheet
    }

    /// The title, on as many lines as it needs.
    fn title(&mut self, title: &str) {
        let size = 14.0;
        let fits = |line: &str| size * text_width(line, Weight::Bold) <= self.width - 2.0 * EDGE;
        let mut lines: Vec<String> = vec![String::new()];
        for word in title.split_whitespace() {
            let Some(last) = lines.last_mut() else { break };
            let longer = if last.is_empty() { word.to_owned() } else { format!("{last} {word}") };
            if last.is_empty() || fits(&longer) {
                *last = longer;
            } else {
                lines.push(word.to_owned());
            }
        }
        for line in lines {
            self.y += 16.0;
            self.text("title", [0.5 * self.width, self.y], "middle", &line);
        }
        self.y += 10.0;
    }

    pub(super) fn text(&mut self, class: &str, [x, y]: [f64; 2], anchor: &str, text: &str) {
        let _ = write!(
            self.body,
            "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>",
            escape(text)
        );
    }

    /// A text that is read upwards, with its middle at `at`.
    pub(super) fn upright(&mut self, class: &str, [x, y]: [f64; 2], text: &str) {
        let _ = write!(
            self.body,
            "<text class=\"{class}\" transform=\"translate({x:.1} {y:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            escape(text)
        );
    }

    /// The names of runs with how they look, from `x` on.
    pub(super) fn legend(&mut self, labels: &[&str], x: f64) {
        let height = series::draw_legend(&mut self.body, labels, [x, self.y], self.width - x - EDGE);
        self.y += height + 6.0;
    }

    /// The width of each of so many drawings beside each other.
    pub(super) fn share(&self, columns: usize) -> f64 {
        (self.width - GAP * (columns as f64 - 1.0)) / columns as f64
    }

    /// As many columns as have at least this width, but no more than `most`.
    pub(super) fn columns(&self, least: f64, most: usize) -> usize {
        (((self.width + GAP) / (least + GAP)) as usize).clamp(1, most)
    }

    /// Drawings in so many columns, each under its name.
    pub(super) fn drawings(&mut self, drawings: &[Drawing], columns: usize) {
        for (k, row) in drawings.chunks(columns).enumerate() {
            if k > 0 {
                self.y += GAP;
            }
            let mut below = self.y;
            let mut x = 0.0;
            for drawing in row {
                let name = capitalised(&drawing.title);
                self.text("heading", [x + 0.5 * drawing.width, self.y + 12.0], "middle", &name);
                self.place(drawing, [x, self.y + 17.0]);
                below = below.max(self.y + 17.0 + drawing.height);
                x += drawing.width + GAP;
            }
            self.y = below;
        }
    }

    /// A drawing with its upper left corner at `at`.
    pub(super) fn place(&mut self, drawing: &Drawing, [x, y]: [f64; 2]) {
        let _ = write!(self.body, "<g transform=\"translate({x:.1} {y:.1})\">{}</g>", drawing.body);
    }

    pub(super) fn finish(self, title: String) -> Figure {
        let height = self.y + EDGE;
        Figure {
            title,
            size: [self.width * self.scale, height * self.scale],
            units: [self.width, height],
            style: file_style(include_str!("print.css")),
            body: self.body,
        }
    }
}

/// With a capital letter in front, if it begins with a letter.
fn capitalised(text: &str) -> String {
    let mut rest = text.chars();
    rest.next().map_or_else(String::new, |first| first.to_uppercase().chain(rest).collect())
}
