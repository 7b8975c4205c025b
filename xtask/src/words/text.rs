//! The texts of a source that users read, line by line.

/// A line of text in lower case, without code, and its number in the source.
pub(super) type Line = (usize, String);

/// The paragraphs of a document, without blocks of code and code.
pub(super) fn prose(text: &str) -> Vec<Line> {
    outside_code(text.lines().enumerate().map(|(k, line)| (k + 1, line.to_owned())))
}

/// The docstrings and comments of a Python source, without the names of arguments that lines begin with.
pub(super) fn python(text: &str) -> Vec<Line> {
    let mut is_inside = false;
    let mut lines = Vec::new();
    for (number, line) in prose(text) {
        let quotes = line.matches("\"\"\"").count();
        if is_inside || quotes > 0 {
            let named = line.split_once(": ").filter(|(name, _)| !name.trim().contains(' '));
            lines.push((number, named.map_or(line.as_str(), |(_, text)| text).to_owned()));
        } else if let Some(comment) = after_hash(&line) {
            lines.push((number, comment.to_owned()));
        }
        is_inside ^= quotes % 2 == 1;
    }
    lines
}

/// The comments of a YAML file or a shell script, and the values of YAML's descriptions.
pub(super) fn hashes(text: &str) -> Vec<Line> {
    let mut lines = Vec::new();
    for (number, line) in prose(text) {
        let comment = after_hash(&line);
        let value = &line[..line.len() - comment.map_or(0, str::len)];
        let described = ["description:", "about:", "unsound:"].iter().find_map(|key| value.split_once(key));
        let found = [described.map_or("", |(_, value)| value), comment.unwrap_or_default()].join(" ");
        if !found.trim().is_empty() {
            lines.push((number, found));
        }
    }
    lines
}

/// The comments of a source in C, C++, JavaScript or WIT.
pub(super) fn remarks(text: &str) -> Vec<Line> {
    let mut is_inside = false;
    let mut lines = Vec::new();
    for (k, line) in text.lines().enumerate() {
        let begins = line.find("/*");
        let found = if is_inside {
            Some(line)
        } else {
            begins.map(|at| &line[at + 2..]).or_else(|| line.split_once("//").map(|(_, comment)| comment))
        };
        is_inside = (is_inside || begins.is_some()) && !line.contains("*/");
        lines.extend(found.map(|line| (k + 1, line.trim_start_matches(['/', '*', '!']).to_owned())));
    }
    outside_code(lines.into_iter())
}

/// The cells of text of a Jupyter notebook, which is stored with a line of a cell on a line of its own.
pub(super) fn cells(text: &str) -> Vec<Line> {
    let mut is_text = false;
    let mut lines = Vec::new();
    for (k, line) in text.lines().enumerate() {
        let line = line.trim().trim_end_matches(',');
        if line.starts_with("\"cell_type\":") {
            is_text = line.ends_with("\"markdown\"");
        } else if is_text {
            lines.extend(serde_json::from_str::<String>(line).ok().map(|line| (k + 1, line)));
        }
    }
    outside_code(lines.into_iter())
}

/// The documentation of a Rust source, and its literals of more than one word.
pub(super) fn rust(text: &str) -> Vec<Line> {
    let mut found = outside_code(scan(text).into_iter().filter(|p| p.is_doc).map(|p| (p.line, p.text)));
    found.extend(literals(text));
    found.sort();
    found
}

/// The literals of more than one word of a Rust source: messages, and texts of pages.
pub(super) fn literals(text: &str) -> Vec<Line> {
    let literals = scan(text).into_iter().filter(|p| !p.is_doc && p.text.trim().contains(' '));
    literals.map(|p| (p.line, without_code(&p.text))).collect()
}

/// Lines in lower case, without blocks of code and code.
fn outside_code(lines: impl Iterator<Item = Line>) -> Vec<Line> {
    let mut is_code = false;
    let mut found = Vec::new();
    for (number, line) in lines {
        if line.trim_start().starts_with("```") {
            is_code = !is_code;
        } else if !is_code {
            found.push((number, without_code(&line)));
        }
    }
    found
}

/// A line in lower case without what stands between backticks.
fn without_code(line: &str) -> String {
    line.split('`').step_by(2).collect::<Vec<_>>().join("`").to_lowercase()
}

/// The text of a comment: a hash at the start of a line or after a blank begins it.
fn after_hash(line: &str) -> Option<&str> {
    line.match_indices('#')
        .find(|(at, _)| line[..*at].is_empty() || line[..*at].ends_with(' '))
        .map(|(at, _)| &line[at + 1..])
}

/// A line of documentation or a literal of a Rust source.
struct Piece {
    line: usize,
    is_doc: bool,
    text: String,
}

/// The documentation and the literals of a Rust source, without its tests and the reasons of attributes.
fn scan(text: &str) -> Vec<Piece> {
    let text = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let mut pieces = Vec::new();
    let (mut rest, mut line) = (text, 1);
    while let Some(first) = rest.chars().next() {
        let mut taken = first.len_utf8();
        if rest.starts_with("//") {
            let comment = rest.lines().next().unwrap_or_default();
            taken = comment.len();
            if comment.starts_with("///") || comment.starts_with("//!") {
                pieces.push(Piece { line, is_doc: true, text: comment[3..].to_owned() });
            }
        } else if rest.starts_with("/*") {
            taken = rest.find("*/").map_or(rest.len(), |at| at + 2);
        } else if let Some((begin, end, is_raw)) = quotes(rest) {
            let body = &rest[begin..];
            let length = if is_raw { body.find(&end).unwrap_or(body.len()) } else { closing(body) };
            let literal = &body[..length];
            let before = &text[..text.len() - rest.len()];
            if !before.trim_end().ends_with("reason =") {
                let text = if is_raw { literal.to_owned() } else { unescaped(literal) };
                pieces.push(Piece { line, is_doc: false, text: without_arguments(&text) });
            }
            taken = (begin + length + end.len()).min(rest.len());
        } else if first == '\'' {
            // A character, or a lifetime, which ends nowhere.
            let mut next = rest[1..].chars();
            taken = match (next.next(), next.next()) {
                (Some('\\'), _) => rest[3..].find('\'').map_or(rest.len(), |at| at + 4),
                (Some(inside), Some('\'')) => inside.len_utf8() + 2,
                _ => 1,
            };
        } else if first.is_alphanumeric() || first == '_' {
            taken = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        }
        line += rest[..taken].matches('\n').count();
        rest = &rest[taken..];
    }
    pieces
}

/// Where the literal that a text begins with has its first character, what ends it, and whether it is a raw one.
fn quotes(text: &str) -> Option<(usize, String, bool)> {
    let behind = text.trim_start_matches(['b', 'c']);
    let prefix = text.len() - behind.len();
    let raw = behind.strip_prefix('r').map(|raw| (raw, raw.len() - raw.trim_start_matches('#').len()));
    match raw {
        Some((raw, hashes)) if raw[hashes..].starts_with('"') => {
            Some((prefix + hashes + 2, format!("\"{}", "#".repeat(hashes)), true))
        }
        _ => (prefix < 2 && behind.starts_with('"')).then(|| (prefix + 1, "\"".to_owned(), false)),
    }
}

/// The length of a literal up to the quote that ends it.
fn closing(literal: &str) -> usize {
    let mut is_escaped = false;
    for (at, c) in literal.char_indices() {
        if c == '"' && !is_escaped {
            return at;
        }
        is_escaped = c == '\\' && !is_escaped;
    }
    literal.len()
}

/// A literal as one line: a backslash joins lines, and all other escapes are blanks.
fn unescaped(literal: &str) -> String {
    let mut text = String::new();
    let mut parts = literal.split('\\');
    text.push_str(parts.next().unwrap_or_default());
    for part in parts {
        match part.strip_prefix(['\n', '\r']) {
            Some(joined) => text.push_str(joined.trim_start()),
            None => text.extend(part.chars().enumerate().map(|(k, c)| if k == 0 { ' ' } else { c })),
        }
    }
    text
}

/// A text to be formatted with a digit for each of its arguments.
fn without_arguments(text: &str) -> String {
    let mut parts = text.split('{');
    let mut found = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        match part.split_once('}') {
            Some((_, behind)) => found.extend(["0", behind]),
            None => found.push_str(part),
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers of the lines of a text that have a word.
    fn with(lines: &[Line], word: &str) -> Vec<usize> {
        lines.iter().filter(|(_, line)| line.split_whitespace().any(|w| w == word)).map(|(k, _)| *k).collect()
    }

    #[test]
    fn documents_have_no_code() {
        assert_eq!(with(&prose("Here Least is\n`least`\n```text\nleast\n```\nleast"), "least"), [1, 6]);
    }

    #[test]
    fn of_python_docstrings_and_comments_are_read() {
        let text = "least = 1\n\"\"\"The least one.\"\"\"\ndef f():\n    \"\"\"A sum.\n\n    least: The least one.\n    \"\"\"\n    \
                    least = 2  # least or not\n";
        assert_eq!(with(&python(text), "least"), [2, 6, 8]);
    }

    #[test]
    fn of_yaml_comments_and_descriptions_are_read() {
        let text = "# least 1\nname: least\ndescription: the least\nuses: a#b least\nleast: 1  # the least\n";
        assert_eq!(with(&hashes(text), "least"), [1, 3, 5]);
    }

    #[test]
    fn of_c_and_wit_comments_are_read() {
        let text = "int least; // least of all\n/* the\n * least\n */\nint least;\n/// least\n";
        assert_eq!(with(&remarks(text), "least"), [1, 3, 6]);
    }

    #[test]
    fn of_notebooks_cells_of_text_are_read() {
        let text = "{\n \"cell_type\": \"markdown\",\n \"source\": [\n  \"The least\\n\",\n  \"one\"\n ]\n},\n{\n \
                    \"cell_type\": \"code\",\n \"source\": [\n  \"least = 1\"\n ]\n}\n";
        assert_eq!(with(&cells(text), "least"), [4]);
    }

    #[test]
    fn of_rust_documentation_and_literals_are_read() {
        let text = "//! The least\n// least\nfn least<'a>() -> char { f(\"least\", \"the \\\"least\\\" {least}\\n\"); '\"' }\n\
                    /// A `least`\nconst A: &str = r#\"one \"least\n\"#; /* \"a least\" */\nlet b = \"one \\\n  least\";\n\
                    #[allow(x, reason = \"the least\")]\n#[cfg(test)]\nmod tests { const C: &str = \"the least\"; }\n";
        assert_eq!(with(&rust(text), "least"), [1, 3, 7]);
        assert_eq!(literals(text)[0], (3, "the  least  0 ".to_owned()));
        assert_eq!(literals(text)[1].1, "one \"least\n");
        assert_eq!(literals(text).len(), 3);
    }
}
