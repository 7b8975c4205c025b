//! A figure and its files.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use base64::Engine as _;
use vb_page::escape;

use crate::font::{FAMILY, Weight};
use crate::web_font;

/// What a browser calls the embedded font: no font of a machine has this name, so none is taken for it.
const EMBEDDED: &str = "Figure";

/// A drawing that stands for itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// What it is called, as text: in the files' metadata, and for those who don't see it.
    pub title: String,
    /// Width and height, points.
    pub size: [f64; 2],
    /// Width and height in the units of `body`.
    pub units: [f64; 2],
    /// The style sheet of `body`: rules of simple selectors without variables.
    pub style: String,
    /// What is drawn, as SVG.
    pub body: String,
}

impl Figure {
    /// The SVG file. Its texts are texts, so that they can be searched, changed and read aloud; the glyphs that they need are
    /// within as a font. Programs that don't read such fonts, such as Inkscape and office programs, take Liberation Sans, Arial or
    /// Helvetica, which are as wide to the thousandth.
    #[must_use]
    pub fn svg(&self) -> String {
        // All that occurs in the file, and what it writes otherwise; a few letters more than its texts have.
        let characters: BTreeSet<char> =
            self.body.chars().chain("<>&'\"".chars()).filter(|c| !c.is_control()).collect();
        let mut fonts = String::new();
        for weight in Weight::ALL {
            if let Some(font) = web_font::part(weight, &characters) {
                let data = base64::engine::general_purpose::STANDARD.encode(font);
                let _ = writeln!(
                    fonts,
                    "@font-face{{font-family:\"{EMBEDDED}\";font-weight:{};src:url(\"data:font/ttf;base64,{data}\") format(\"truetype\")}}",
                    weight.number()
                );
            }
        }
        self.document(&fonts)
    }

    /// The SVG with these font faces.
    pub(crate) fn document(&self, fonts: &str) -> String {
        let [width, height] = self.size;
        let [x, y] = self.units;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.2}pt\" height=\"{height:.2}pt\" viewBox=\"0 0 {x:.2} {y:.2}\" \
             role=\"img\" aria-label=\"{title}\">\n<title>{title}</title>\n<style>{fonts}\
             text{{font-family:\"{EMBEDDED}\",\"{FAMILY}\",Arial,Helvetica,sans-serif}}\n{}</style>\n\
             <rect width=\"{x:.2}\" height=\"{y:.2}\" fill=\"#fff\"/>\n{}\n</svg>\n",
            self.style,
            self.body,
            title = escape(&self.title),
        )
    }
}
