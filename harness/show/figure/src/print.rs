//! Figures as PDF and PNG files.

use std::sync::{Arc, OnceLock};

use krilla::Document;
use krilla::geom::Size;
use krilla::metadata::Metadata;
use krilla::page::PageSettings;
use krilla_svg::{SurfaceExt as _, SvgSettings};
use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::fontdb::Database;
use resvg::usvg::{Options, Tree};

use crate::Figure;
use crate::font::{FAMILY, Weight};

/// Pixels of a picture at most.
const PIXELS: f64 = 200e6;
/// Points in an inch.
const POINTS: f64 = 72.0;

#[derive(Debug, thiserror::Error)]
pub enum FigureError {
    #[error(
        "figure `{title}` can't be read as SVG: {reason} (this is an error of the harness: please report it)"
    )]
    Svg { title: String, reason: String },
    #[error(
        "figure `{title}` cannot be converted to PDF: {reason} (this is an error of the harness: please report it)"
    )]
    Pdf { title: String, reason: String },
    #[error(
        "figure `{title}` cannot be converted to PNG: {reason} (choose a smaller width, or fewer dots per inch)"
    )]
    Png { title: String, reason: String },
}

impl Figure {
    fn tree(&self) -> Result<Tree, FigureError> {
        let options = Options { fontdb: database(), font_family: FAMILY.to_owned(), ..Options::default() };
        Tree::from_str(&self.document(""), &options)
            .map_err(|e| FigureError::Svg { title: self.title.clone(), reason: e.to_string() })
    }

    /// The PDF file: a page of the figure's size, with vectors and texts, and with the used part of the font.
    ///
    /// # Errors
    /// If the drawing is no SVG, or no PDF can be made of it.
    pub fn pdf(&self) -> Result<Vec<u8>, FigureError> {
        let failed = |reason: &str| FigureError::Pdf { title: self.title.clone(), reason: reason.to_owned() };
        let tree = self.tree()?;
        let [width, height] = self.size.map(|v| v as f32);
        let size = Size::from_wh(width, height).ok_or_else(|| failed("it has no size"))?;
        let settings = PageSettings::from_wh(width, height).ok_or_else(|| failed("it has no size"))?;
        let mut document = Document::new();
        document.set_metadata(
            Metadata::new().title(self.title.clone()).creator("Verti-Bench in Rust".to_owned()),
        );
        let mut page = document.start_page_with(settings);
        let mut surface = page.surface();
        surface.draw_svg(&tree, size, SvgSettings::default()).ok_or_else(|| failed("it can't be drawn"))?;
        surface.finish();
        page.finish();
        document.finish().map_err(|e| failed(&format!("{e:?}")))
    }

    /// The PNG file with so many dots per inch, which it says of itself, on white.
    ///
    /// # Errors
    /// If the drawing is no SVG, or the picture would have more than 200 million pixels.
    pub fn png(&self, dpi: f64) -> Result<Vec<u8>, FigureError> {
        let failed = |reason: String| FigureError::Png { title: self.title.clone(), reason };
        let tree = self.tree()?;
        let [width, height] = self.size.map(|v| (v / POINTS * dpi).round().max(1.0));
        if width * height > PIXELS {
            return Err(failed(format!("it would have {width} × {height} pixels")));
        }
        let mut picture =
            Pixmap::new(width as u32, height as u32).ok_or_else(|| failed("it has no size".into()))?;
        picture.fill(Color::WHITE);
        let own = tree.size();
        let scale = Transform::from_scale(width as f32 / own.width(), height as f32 / own.height());
        resvg::render(&tree, scale, &mut picture.as_mut());
        // The ground is opaque, so premultiplied colours are the colours.
        let dots: Vec<u8> = picture.pixels().iter().flat_map(|p| [p.red(), p.green(), p.blue()]).collect();
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, width as u32, height as u32);
        encoder.set_color(png::ColorType::Rgb);
        let per_metre = (dpi / 0.0254).round() as u32;
        encoder.set_pixel_dims(Some(png::PixelDimensions {
            xppu: per_metre,
            yppu: per_metre,
            unit: png::Unit::Meter,
        }));
        let mut writer = encoder.write_header().map_err(|e| failed(e.to_string()))?;
        writer.write_image_data(&dots).map_err(|e| failed(e.to_string()))?;
        writer.finish().map_err(|e| failed(e.to_string()))?;
        Ok(file)
    }
}

/// The font as those who draw look it up: no font of the machine is among them, since figures must be the same everywhere.
pub(crate) fn database() -> Arc<Database> {
    static FONTS: OnceLock<Arc<Database>> = OnceLock::new();
    let load = || {
        let mut fonts = Database::new();
        for weight in Weight::ALL {
            fonts.load_font_data(weight.data().to_vec());
        }
        Arc::new(fonts)
    };
    Arc::clone(FONTS.get_or_init(load))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(body: &str) -> Figure {
        Figure {
            title: "a < b".into(),
            size: [252.0, 126.0],
            units: [400.0, 200.0],
            style: ".x{font-size:12px;fill:#134d8a}.b{font-size:12px;font-weight:600}".into(),
            body: body.into(),
        }
    }

    const TEXTS: &str = "<text class=\"x\" x=\"10\" y=\"40\">&lt;script&gt; − é</text><text class=\"b\" x=\"10\" y=\"80\">Bold</text>";

    #[test]
    fn the_same_figure_gives_the_same_bytes() {
        let (a, b) = (figure(TEXTS), figure(TEXTS));
        assert_eq!(a.svg(), b.svg());
        assert_eq!(a.pdf().unwrap(), b.pdf().unwrap());
        assert_eq!(a.png(300.0).unwrap(), b.png(300.0).unwrap());
        let pdf = a.pdf().unwrap();
        let text = String::from_utf8_lossy(&pdf);
        assert!(!text.contains("CreationDate") && !text.contains("ModDate") && !text.contains("CreateDate"));
    }

    #[test]
    fn a_pdf_has_its_size_and_the_used_part_of_the_font() {
        let pdf = figure(TEXTS).pdf().unwrap();
        let text = String::from_utf8_lossy(&pdf);
        assert!(text.starts_with("%PDF-1."));
        assert!(text.contains("/MediaBox[0 0 252 126]"), "{text}");
        // Both weights, each as a subset (six letters and a plus sign before its name) whose file is within.
        for name in ["+LiberationSans/", "+LiberationSans-Bold/"] {
            assert!(text.contains(name), "{name}");
        }
        assert_eq!(text.matches("/FontFile2 ").count(), 2);
        assert_eq!(text.matches("/ToUnicode ").count(), 2, "its texts can be searched");
        assert!(pdf.len() < 40_000, "{} bytes", pdf.len());
    }

    #[test]
    fn a_picture_has_the_resolution_that_was_asked_for() {
        let file = figure(TEXTS).png(300.0).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
        // 3.5 by 1.75 inches.
        let info = reader.info();
        assert_eq!((info.width, info.height), (1050, 525));
        let dims = info.pixel_dims.unwrap();
        // 300 dots per inch of 25.4 mm.
        assert_eq!((dims.xppu, dims.unit), (11_811, png::Unit::Meter));
        let mut dots = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut dots).unwrap();
        assert_eq!(dots[..3], [255, 255, 255], "on white");
        assert!(dots.chunks(3).any(|d| d == [0x13, 0x4d, 0x8a]), "the texts are there");
        assert!(matches!(figure(TEXTS).png(30_000.0), Err(FigureError::Png { .. })));
    }

    #[test]
    fn an_svg_is_whole_without_other_files() {
        let svg = figure(TEXTS).svg();
        let options = Options { fontdb: database(), ..Options::default() };
        let tree = Tree::from_str(&svg, &options).unwrap();
        assert!((tree.size().width() - 252.0 * 96.0 / 72.0).abs() < 0.1);
        assert!(svg.contains("<title>a &lt; b</title>") && svg.contains("data:font/ttf;base64,"));
        assert!(!svg.contains("<script") && !svg.contains("http://www.w3.org/1999/xlink"));
        assert!(figure("<g>").tree().is_err(), "what is no SVG is refused");
    }
}
