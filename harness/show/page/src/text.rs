//! Text in pages.

/// Whether a character turns the direction of the text around it (Unicode's property `Bidi_Control`): texts of strangers would look
/// like others with it.
fn is_turning(c: char) -> bool {
    matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Text that is safe in HTML and SVG, between tags and in quoted attributes. Characters that XML can't hold (XML 1.0, production 2)
/// become the replacement character: a file of SVG with one of them would be none. So do those that turn the direction of writing.
#[must_use]
pub fn escape(text: &str) -> String {
    let held = |c: char| !matches!(c, '\0'..='\u{8}' | '\u{b}' | '\u{c}' | '\u{e}'..='\u{1f}' | '\u{fffe}' | '\u{ffff}');
    text.replace(|c| !held(c) || is_turning(c), "\u{fffd}")
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
        .replace('\'', "&#39;")
}

/// JSON that is safe within a script element: no tag or comment can begin or end in it, and no text turns the direction of writing.
#[must_use]
pub fn json<T: serde::Serialize>(value: &T) -> String {
    // What a page holds is lists of texts and numbers, which always convert; numbers that JSON lacks become null.
    let text = serde_json::to_string(value).unwrap_or_else(|_| "null".to_owned());
    text.replace(is_turning, "\u{fffd}")
        .replace('<', "\\u003c")
        .replace('\u{2028}', "\\u2028")
        .replace('\u{2029}', "\\u2029")
}

/// A number with so many digits behind the point and a minus sign as people write it.
#[must_use]
pub fn number(v: f64, digits: usize) -> String {
    let text = format!("{v:.digits$}");
    let zero = text.trim_start_matches('-').bytes().all(|b| matches!(b, b'0' | b'.'));
    if zero { text.trim_start_matches('-').to_owned() } else { text.replace('-', "−") }
}

/// A number with as many digits as tell measured values apart.
#[must_use]
pub fn rounded(v: f64) -> String {
    let digits = match v.abs() {
        a if a >= 1000.0 => 0,
        a if a >= 100.0 => 1,
        a if a >= 10.0 => 2,
        a if a >= 0.1 || a == 0.0 => 3,
        _ => 5,
    };
    let text = number(v, digits);
    if text.bytes().all(|b| matches!(b, b'0' | b'.')) { "0".to_owned() } else { text }
}

/// A difference: a [`number`] with a plus sign where it is greater than 0.
#[must_use]
pub fn signed(v: f64, digits: usize) -> String {
    let text = number(v, digits);
    let zero = text.bytes().all(|b| matches!(b, b'0' | b'.'));
    if zero || v < 0.0 { text } else { format!("+{text}") }
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
        assert_eq!(json(&["a\u{202e}b"]), "[\"a\u{fffd}b\"]");
    }

    #[test]
    fn text_is_escaped_and_has_no_character_that_xml_lacks() {
        assert_eq!(escape("a<b & \"c\"\n\t'd'>"), "a&lt;b &amp; &quot;c&quot;\n\t&#39;d&#39;&gt;");
        assert_eq!(escape("a\u{202e}b\u{2066}\u{200f}"), "a\u{fffd}b\u{fffd}\u{fffd}");
        assert_eq!(escape("\0\u{1}é\u{1b}[0m\u{ffff}"), "\u{fffd}\u{fffd}é\u{fffd}[0m\u{fffd}");
    }

    #[test]
    fn numbers_are_written_as_people_read_them() {
        assert_eq!((number(-1.25, 1).as_str(), number(-0.01, 1).as_str()), ("−1.2", "0.0"));
        assert_eq!(
            (signed(1.25, 1), signed(-1.25, 1), signed(0.01, 1)),
            ("+1.2".into(), "−1.2".into(), "0.0".into())
        );
        let shown = [24_461.8, 126.57, 12.461, 0.645, -0.0123, 0.0, 1e-9].map(rounded);
        assert_eq!(shown, ["24462", "126.6", "12.46", "0.645", "−0.01230", "0", "0"]);
        assert_eq!(grouped(1_234_567), "1\u{2009}234\u{2009}567");
        assert_eq!((p_value(0.000_4).as_str(), p_value(0.0412).as_str()), ("< 0.001", "0.041"));
    }
}
