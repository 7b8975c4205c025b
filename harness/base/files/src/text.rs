//! Text from strangers, made fit to be shown.

/// Long enough for any message meant to be read, characters.
const MAX: usize = 2000;

/// Whether a terminal or a reader may take the character for more or less than it shows: control characters,
/// invisible ones, and those that reorder the text around them (Unicode's bidirectional controls; see "Trojan
/// Source", CVE-2021-42574).
fn is_unprintable(c: char) -> bool {
    c.is_control()
        || matches!(c,
            '\u{00ad}' | '\u{034f}' | '\u{061c}' | '\u{115f}' | '\u{1160}' | '\u{17b4}' | '\u{17b5}'
            | '\u{180b}'..='\u{180f}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}'
            | '\u{2060}'..='\u{206f}' | '\u{3164}' | '\u{fe00}'..='\u{fe0f}' | '\u{feff}' | '\u{ffa0}'
            | '\u{fff0}'..='\u{fffb}' | '\u{1d173}'..='\u{1d17a}' | '\u{e0000}'..='\u{e0fff}')
}

/// Turns untrusted text into one printable line of at most 2000 characters; see [`cut_line`].
#[must_use]
pub fn one_line(text: &str) -> String {
    cut_line(text, MAX)
}

/// Turns untrusted text into one printable line: joins its lines, cuts after `most` characters (then with an ellipsis), and replaces
/// what a terminal might act on, or a reader can't see, by `U+FFFD`.
#[must_use]
pub fn cut_line(text: &str, most: usize) -> String {
    let mut line = text.lines().map(str::trim).filter(|l| !l.is_empty()).collect::<Vec<_>>().join(" ");
    if let Some((end, _)) = line.char_indices().nth(most) {
        line.truncate(end);
        line.push('…');
    }
    printable(&line)
}

/// Replaces what a terminal might act on, or a reader can't see, by `U+FFFD`. Line feeds and tabs stay.
#[must_use]
pub fn printable(text: &str) -> String {
    text.chars().map(|c| if is_unprintable(c) && c != '\n' && c != '\t' { '\u{fffd}' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planner_text_cannot_command_the_terminal() {
        assert_eq!(one_line("a:\n  b\r\n\n\u{1b}[2Jc"), "a: b \u{fffd}[2Jc");
        assert_eq!(one_line(&"x".repeat(5000)).chars().count(), 2001);
        assert_eq!((cut_line("äöü", 3).as_str(), cut_line("äöü", 2).as_str()), ("äöü", "äö…"));
        // C1 controls: the one-byte form of "ESC [".
        assert_eq!(one_line("\u{9b}2J"), "\u{fffd}2J");
    }

    #[test]
    fn planner_text_cannot_hide_or_reorder() {
        // Right-to-left override, zero-width space, isolates, byte-order mark, tags.
        for c in
            ['\u{202e}', '\u{200b}', '\u{2066}', '\u{2069}', '\u{feff}', '\u{e0041}', '\u{2028}', '\u{61c}']
        {
            assert_eq!(one_line(&format!("a{c}b")), "a\u{fffd}b", "{:x}", u32::from(c));
        }
        // Text in any script stays.
        assert_eq!(one_line("Größe 速度 שלום µ"), "Größe 速度 שלום µ");
        assert_eq!(printable("a\n\tb\r"), "a\n\tb\u{fffd}");
    }
}
