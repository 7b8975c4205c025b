//! The terms that STYLE.md tells to avoid, in documents, help texts and docstrings.

use std::path::{Path, PathBuf};

use crate::root;
use crate::run::{Failure, step};

/// Documents, and folders with documents of an extension.
const PLACES: [(&str, &str); 10] = [
    ("README.md", "md"),
    ("ARCHITECTURE.md", "md"),
    ("CONTRIBUTING.md", "md"),
    ("SECURITY.md", "md"),
    ("docs", "md"),
    ("harness/python/README.md", "md"),
    ("sdk/python/README.md", "md"),
    ("harness/cli/src/args/snapshots", "snap"),
    ("harness/python/vertibench", "py"),
    ("sdk/python/src", "py"),
];
/// Terms with a meaning of their own that contain an avoided one.
const ALLOWED: [&str; 5] =
    ["at least", "least-squares", "least squares", "least significant", "least recently"];

/// An avoided term, in lower case, and what to write instead.
#[derive(Debug, PartialEq)]
struct Term {
    avoid: String,
    write: String,
}

/// Checks all documents.
pub(crate) fn check() -> Result<(), Failure> {
    step("checking terms");
    let style = read(&root().join("STYLE.md"))?;
    let terms = terms(&style);
    let mut files = Vec::new();
    for (place, extension) in PLACES {
        collect(&root().join(place), extension, &mut files)?;
    }
    files.sort();
    let mut found = Vec::new();
    for file in files {
        let text = read(&file)?;
        let name = file.strip_prefix(root()).unwrap_or(&file).display().to_string();
        let is_python = file.extension().is_some_and(|e| e == "py");
        let lines = if is_python { docstrings(&text) } else { prose(&text) };
        let mut before = String::new();
        for (line, text) in lines {
            for term in terms.iter().filter(|term| contains(&before, &text, &term.avoid)) {
                found.push(format!("{name}:{line}: {:?}: write {}", term.avoid, term.write));
            }
            before = text;
        }
    }
    if found.is_empty() {
        return Ok(());
    }
    Err(Failure::new(format!("STYLE.md avoids these terms:\n{}", found.join("\n"))))
}

fn read(file: &Path) -> Result<String, Failure> {
    std::fs::read_to_string(file).map_err(|e| Failure::new(format!("{}: {e}", file.display())))
}

/// A file, or the files of a folder and its folders with an extension.
fn collect(place: &Path, extension: &str, files: &mut Vec<PathBuf>) -> Result<(), Failure> {
    let wrong = |e: std::io::Error| Failure::new(format!("{}: {e}", place.display()));
    if place.is_dir() {
        for entry in std::fs::read_dir(place).map_err(wrong)? {
            collect(&entry.map_err(wrong)?.path(), extension, files)?;
        }
    } else if place.extension().is_some_and(|e| e == extension) {
        files.push(place.to_owned());
    }
    Ok(())
}

/// The terms of the table in STYLE.md. One that is followed by a context in brackets depends on it, and isn't checked.
fn terms(style: &str) -> Vec<Term> {
    let table = style.split_once("## Terms").map_or("", |(_, rest)| rest);
    let table = table.split_once("\n## ").map_or(table, |(table, _)| table);
    let rows =
        table.lines().filter_map(|line| line.strip_prefix("| ")?.strip_suffix(" |")?.split_once(" | "));
    rows.filter(|(avoid, _)| *avoid != "avoid" && !avoid.ends_with(')'))
        .flat_map(|(avoid, write)| {
            let terms = avoid.split([';', ',']).map(str::trim);
            terms.map(|term| Term { avoid: term.to_lowercase(), write: write.to_owned() })
        })
        .collect()
}

/// The lines of a text in lower case with their numbers, without blocks of code, code and links to other places.
fn prose(text: &str) -> Vec<(usize, String)> {
    let mut is_code = false;
    let mut lines = Vec::new();
    for (k, line) in text.lines().enumerate() {
        if line.trim_start().starts_with("```") {
            is_code = !is_code;
        } else if !is_code {
            let words: String = line.split('`').step_by(2).collect::<Vec<_>>().join("`");
            lines.push((k + 1, words.to_lowercase()));
        }
    }
    lines
}

/// The lines of a Python source that lie in docstrings, without the names of arguments that they begin with.
fn docstrings(text: &str) -> Vec<(usize, String)> {
    let mut is_inside = false;
    let mut lines = Vec::new();
    for (number, line) in prose(text) {
        let quotes = line.matches("\"\"\"").count();
        if is_inside || quotes > 0 {
            let named = line.split_once(": ").filter(|(name, _)| !name.trim().contains(' '));
            lines.push((number, named.map_or(line.as_str(), |(_, text)| text).to_owned()));
        }
        is_inside ^= quotes % 2 == 1;
    }
    lines
}

/// Whether a line has a term as whole words, after the line `before`.
fn contains(before: &str, line: &str, term: &str) -> bool {
    let is_word = |c: char| c.is_alphanumeric() || c == '_' || c == '-' || c == '/';
    // An allowed phrase may begin in the line before, or go on in the next.
    let last = before.split_whitespace().last().unwrap_or_default();
    let text = format!("{last} {line}");
    let first = text.len() - line.len();
    text.match_indices(term).filter(|(at, _)| *at >= first).any(|(at, _)| {
        let (before, after) = (&text[..at], &text[at + term.len()..]);
        let is_whole = !before.ends_with(is_word) && !after.starts_with(is_word);
        let is_allowed = ALLOWED.iter().any(|allowed| {
            let begin = allowed.find(term).and_then(|offset| at.checked_sub(offset));
            begin.and_then(|begin| text.get(begin..)).is_some_and(|rest| {
                rest.starts_with(allowed) || allowed.starts_with(rest) && rest.ends_with(term)
            })
        });
        is_whole && !is_allowed
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_come_from_the_table_without_those_that_depend_on_a_context() {
        let style = "## Terms\n\n| avoid | write |\n|---|---|\n| way, ways (of a vehicle) | path |\n| Greatest, least | maximum, minimum |\n\
                     | courses; a say | rollouts; weight |\n\n## Examples\n| no | more |\n";
        let found: Vec<String> = terms(style).into_iter().map(|t| t.avoid).collect();
        assert_eq!(found, ["greatest", "least", "courses", "a say"]);
        assert!(terms(&read(&root().join("STYLE.md")).unwrap()).len() > 30);
    }

    #[test]
    fn a_term_is_found_as_whole_words_outside_of_code() {
        let found = |text: &str, term: &str| -> Vec<usize> {
            prose(text).into_iter().filter(|(_, line)| contains("", line, term)).map(|(k, _)| k).collect()
        };
        let text = "The Least value\nat least one, the least-squares fit\n`least`\n```text\nleast\n```\nleastwise, un-least, least\nthe least\nsignificant";
        // In lines 7 and 8 it may be the first word of "least significant", which goes on in the next.
        assert_eq!(found(text, "least"), [1]);
        assert!(contains("of at", "most or least 3", "least") && !contains("of at", "least 2 m", "least"));
        assert_eq!(found("what can be done\nwhat can be donef", "can be done"), [1]);
    }

    #[test]
    fn of_python_only_docstrings_are_read() {
        let text = "least = 1\n\"\"\"The least.\"\"\"\ndef f():\n    \"\"\"A sum.\n\n    least: The least.\n    \"\"\"\n    least = 2\n";
        let found: Vec<usize> = docstrings(text)
            .into_iter()
            .filter(|(_, line)| contains("", line, "least"))
            .map(|(k, _)| k)
            .collect();
        assert_eq!(found, [2, 6]);
    }
}
