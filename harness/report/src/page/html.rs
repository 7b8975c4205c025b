//! Text for a page, and the frame of one: what pages of other crates share with the report's.

use base64::Engine as _;
use sha2::{Digest as _, Sha256};

const STYLE: &str = include_str!("page.css");

/// A script that sorts each `table.sortable` by a click on a column's head, but those of class `fixed`: by the `data-v` of its
/// cells, else by their text.
pub const SORTED_TABLES: &str = include_str!("tables.js");

/// A page that needs no other file: `head` (what comes before the content: title, navigation) and `main` are HTML, `title` is
/// text, `style` is added to the report's own, `script` is run at the end. A policy in the page lets the browser run no
/// other script, load nothing from elsewhere, and send nothing away, whatever foreign texts the page holds.
#[must_use]
pub fn document(title: &str, style: &str, head: &str, main: &str, script: &str) -> String {
    let own = base64::engine::general_purpose::STANDARD.encode(Sha256::digest(script.as_bytes()));
    let title = escape(title);
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" \
         content=\"width=device-width,initial-scale=1\"><meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; \
         img-src data:; style-src 'unsafe-inline'; script-src 'sha256-{own}'\"><title>{title}</title><style>{STYLE}{style}</style>\
         </head><body><header>{head}</header><main>{main}</main><script>{script}</script></body></html>\n"
    )
}

/// Text that is safe in HTML and SVG, between tags and in quoted attributes.
#[must_use]
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
        .replace('\'', "&#39;")
}

/// JSON that is safe within a script element: no tag or comment can begin or end in it.
#[must_use]
pub fn json<T: serde::Serialize>(value: &T) -> String {
    // What a page holds is lists of texts and numbers, which always convert; numbers that JSON lacks become null.
    let text = serde_json::to_string(value).unwrap_or_else(|_| "null".to_owned());
    text.replace('<', "\\u003c").replace('\u{2028}', "\\u2028").replace('\u{2029}', "\\u2029")
}

/// A number with so many digits behind the point and a minus sign as people write it.
#[must_use]
pub fn number(v: f64, digits: usize) -> String {
    let text = format!("{v:.digits$}");
    let zero = text.trim_start_matches('-').bytes().all(|b| matches!(b, b'0' | b'.'));
    if zero { text.trim_start_matches('-').to_owned() } else { text.replace('-', "−") }
}

/// A whole number with thin spaces between thousands.
#[must_use]
pub fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (k, c) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            out.push('\u{2009}');
        }
        out.push(c);
    }
    out
}

/// A p-value as it is printed.
#[must_use]
pub fn p_value(p: f64) -> String {
    if p < 0.001 { "< 0.001".to_owned() } else { format!("{p:.3}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_cannot_leave_its_script_element() {
        let text = json(&["</script><script>alert(1)</script>", "<!--", "\u{2028}"]);
        assert!(!text.contains('<') && !text.contains('\u{2028}'), "{text}");
        let back: Vec<String> = serde_json::from_str(&text).unwrap();
        assert_eq!(back[0], "</script><script>alert(1)</script>");
    }

    #[test]
    fn a_page_runs_its_own_script_only() {
        let page = document("<b>", "", "", "", "a()");
        // SHA-256 of `a()` by sha256sum, in base64.
        assert!(page.contains("script-src 'sha256-qVpDBgj7bpq5hMAcGp3AOc79J3Y1Z4HvySTwKrWDoy4='"), "{page}");
        assert!(page.contains("<title>&lt;b&gt;</title>"), "{page}");
    }

    #[test]
    fn numbers_are_written_as_people_read_them() {
        assert_eq!((number(-1.25, 1).as_str(), number(-0.01, 1).as_str()), ("−1.2", "0.0"));
        assert_eq!(grouped(1_234_567), "1\u{2009}234\u{2009}567");
        assert_eq!((p_value(0.000_4).as_str(), p_value(0.0412).as_str()), ("< 0.001", "0.041"));
    }
}
