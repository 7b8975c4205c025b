//! Text for a page.

/// Text that is safe in HTML and SVG, between tags and in quoted attributes.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
        .replace('\'', "&#39;")
}

/// A number with so many digits behind the point and a minus sign as people write it.
pub(super) fn number(v: f64, digits: usize) -> String {
    format!("{v:.digits$}").replace('-', "−")
}
