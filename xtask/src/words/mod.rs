//! The avoided terms of STYLE.md, in all texts that users read.

mod text;

use std::path::{Path, PathBuf};

use crate::root;
use crate::run::{Failure, step};
use text::{Line, cells, hashes, literals, prose, python, remarks, rust};

/// Extracts the lines of a file that are text for users.
type Reader = fn(&str) -> Vec<Line>;

/// Files, and folders with files of an extension, with what is read of them.
struct Place(&'static str, &'static str, Reader);

const PLACES: &[Place] = &[
    Place("README.md", "md", prose),
    Place("ARCHITECTURE.md", "md", prose),
    Place("CONTRIBUTING.md", "md", prose),
    Place("SECURITY.md", "md", prose),
    Place("docs", "md", prose),
    Place("harness/python/README.md", "md", prose),
    Place("sdk/python/README.md", "md", prose),
    Place("harness/cli/src/snapshots", "snap", prose),
    Place("harness/python/vertibench", "py", python),
    Place("sdk/python/src", "py", python),
    Place("sdk/python/examples", "py", python),
    Place("plugins", "rs", rust),
    Place("sdk/src", "rs", rust),
    Place("sdk/wit", "wit", remarks),
    Place("sdk/c", "h", remarks),
    Place("harness", "rs", literals),
    Place("harness/cli/templates", "md", prose),
    Place("harness/cli/templates", "yml", hashes),
    Place("examples", "md", prose),
    Place("examples", "rs", rust),
    Place("examples", "py", python),
    Place("examples", "c", remarks),
    Place("examples", "h", remarks),
    Place("examples", "cpp", remarks),
    Place("examples", "js", remarks),
    Place("examples", "sh", hashes),
    Place("examples", "yaml", hashes),
    Place("examples", "yml", hashes),
    Place("examples", "ipynb", cells),
    Place("tasks/released.yaml", "yaml", hashes),
    Place("tasks/curricula", "yaml", hashes),
    Place("tasks/exploration", "yaml", hashes),
    Place("tasks/generator", "yaml", hashes),
    Place("tasks/rewards", "yaml", hashes),
    Place("tasks/rules", "yaml", hashes),
    Place("tasks/training", "yaml", hashes),
    Place("tasks/validation", "yaml", hashes),
];
/// Folders and files without texts for users, or which another program writes.
const SKIPPED: [&str; 7] = ["tests", "tests.rs", "benches", "target", "node_modules", "gen", "build"];
/// Sources whose words are fixed: kernels keep a hash of some, and of others references use the names of figures.
const FIXED: [&str; 7] = [
    "harness/base",
    "harness/learn/kernel",
    "harness/model/granular",
    "harness/model/sim",
    "harness/model/vehicle",
    "harness/model/world",
    "harness/make/validate/src/events",
];
/// Phrases with a meaning of their own that contain an avoided term; in messages, a 0 stands for an argument.
const ALLOWED: [&str; 8] = [
    "at least",
    "least squares",
    "least significant",
    "least recently",
    "least common",
    "of course",
    "line of sight",
    // A field of policies' weights.
    "sight 0",
];
/// Avoided terms that the table has with a context in brackets, in phrases that are free of any other meaning.
const PHRASES: [(&str, &str); 9] = [
    ("a share of", "fraction"),
    ("as a share", "fraction"),
    ("length of way", "path length"),
    ("the way that", "trajectory, path"),
    ("have a say", "weight"),
    ("driven again", "re-run"),
    ("carried along", "included"),
    ("those who", "users, planner authors, organisers"),
    ("whoever", "users, planner authors, organisers"),
];
/// Irregular forms of words.
const IRREGULAR: [(&str, &str); 16] = [
    ("told", "tell"),
    ("foretold", "foretell"),
    ("foresaw", "foresee"),
    ("foreseen", "foresee"),
    ("got", "get"),
    ("gotten", "get"),
    ("came", "come"),
    ("drove", "drive"),
    ("driven", "drive"),
    ("does", "do"),
    ("did", "do"),
    ("done", "do"),
    ("is", "be"),
    ("are", "be"),
    ("was", "be"),
    ("were", "be"),
];

/// An avoided term, in lower case, and what to write instead.
#[derive(Debug, PartialEq)]
struct Term {
    avoid: String,
    write: String,
}

/// Checks all places.
pub(crate) fn check() -> Result<(), Failure> {
    step("checking terms");
    let found = findings()?;
    if found.is_empty() {
        return Ok(());
    }
    Err(Failure::new(format!("STYLE.md avoids these terms:\n{}", found.join("\n"))))
}

/// The avoided terms of all places.
fn findings() -> Result<Vec<String>, Failure> {
    let style = read(&root().join("STYLE.md"))?;
    let terms = terms(&style);
    let mut found = Vec::new();
    for Place(place, extension, lines) in PLACES {
        let mut files = Vec::new();
        collect(&root().join(place), extension, &mut files)?;
        if files.is_empty() {
            return Err(Failure::new(format!("{place} has no file of the extension {extension}")));
        }
        files.sort();
        for file in files {
            let name = file.strip_prefix(root()).unwrap_or(&file).display().to_string();
            let lines = lines(&read(&file)?);
            found.extend(
                avoided(&lines, &terms)
                    .map(|(line, term)| format!("{name}:{line}: {:?}: write {}", term.avoid, term.write)),
            );
        }
    }
    found.dedup();
    Ok(found)
}

/// The avoided terms in a text.
fn avoided<'a>(lines: &'a [Line], terms: &'a [Term]) -> impl Iterator<Item = (usize, &'a Term)> {
    lines.iter().enumerate().flat_map(move |(k, (number, line))| {
        // Of a source, lines that are not next to each other have nothing to do with each other.
        let before = k.checked_sub(1).map(|k| &lines[k]).filter(|(before, _)| before + 1 == *number);
        let before = before.map_or("", |(_, before)| before.as_str());
        let found = terms.iter().filter(move |term| contains(before, line, &term.avoid));
        found.map(move |term| (*number, term))
    })
}

fn read(file: &Path) -> Result<String, Failure> {
    std::fs::read_to_string(file).map_err(|e| Failure::new(format!("{}: {e}", file.display())))
}

/// A file, or the files of a folder and its folders with an extension.
fn collect(place: &Path, extension: &str, files: &mut Vec<PathBuf>) -> Result<(), Failure> {
    let wrong = |e: std::io::Error| Failure::new(format!("{}: {e}", place.display()));
    let is_fixed = FIXED.iter().any(|fixed| *place == root().join(fixed));
    let is_skipped = |name: &std::ffi::OsStr| {
        let is_hidden = name.to_string_lossy().starts_with('.') && name != ".github";
        is_hidden || SKIPPED.iter().any(|skipped| name == *skipped)
    };
    if is_fixed || place.is_symlink() {
        return Ok(());
    }
    if place.is_dir() {
        for entry in std::fs::read_dir(place).map_err(wrong)? {
            let entry = entry.map_err(wrong)?;
            if !is_skipped(&entry.file_name()) {
                collect(&entry.path(), extension, files)?;
            }
        }
    } else if place.extension().is_some_and(|e| e == extension) {
        files.push(place.to_owned());
    }
    Ok(())
}

/// The terms of the table in STYLE.md, and [`PHRASES`] of those that are followed by a context in brackets: whether
/// these are avoided depends on it.
fn terms(style: &str) -> Vec<Term> {
    let table = style.split_once("## Terms").map_or("", |(_, rest)| rest);
    let table = table.split_once("\n## ").map_or(table, |(table, _)| table);
    let rows =
        table.lines().filter_map(|line| line.strip_prefix("| ")?.strip_suffix(" |")?.split_once(" | "));
    let certain = rows.filter(|(avoid, _)| *avoid != "avoid" && !avoid.ends_with(')'));
    let listed =
        certain.flat_map(|(avoid, write)| avoid.split([';', ',']).map(move |term| (term.trim(), write)));
    listed
        .chain(PHRASES)
        .map(|(avoid, write)| Term { avoid: avoid.to_lowercase(), write: write.to_owned() })
        .collect()
}

/// A word of a text, and whether nothing but blanks stand between it and the one before.
#[derive(Clone, Copy)]
struct Word<'a> {
    text: &'a str,
    follows: bool,
}

/// The words of a text.
fn words(text: &str) -> Vec<Word<'_>> {
    let is_word = |c: char| c.is_alphanumeric() || "_-/'’".contains(c);
    let mut found = Vec::new();
    let mut rest = text;
    while let Some(at) = rest.find(is_word) {
        let follows = rest[..at].chars().all(char::is_whitespace);
        let length = rest[at..].find(|c: char| !is_word(c)).unwrap_or(rest.len() - at);
        found.push(Word { text: &rest[at..at + length], follows });
        rest = &rest[at + length..];
    }
    found
}

/// The common stem of all forms of a word.
fn stem(word: &str) -> &str {
    let known = IRREGULAR.iter().find(|(form, _)| *form == word);
    let word = known.map_or(word, |(_, known)| *known);
    let ending = ["ing", "ed", "es", "s"].iter().find(|ending| {
        let rest = word.strip_suffix(**ending).filter(|rest| rest.len() > 2 && !rest.ends_with('s'));
        rest.is_some_and(|rest| !(ending.starts_with('e') && rest.ends_with('e')))
    });
    let stem = ending.map_or(word, |ending| &word[..word.len() - ending.len()]);
    let stem = stem.strip_suffix('e').filter(|stem| stem.len() > 2).unwrap_or(stem);
    let mut last = stem.chars().rev();
    let is_doubled = last.next() == last.next() && stem.is_ascii() && !stem.ends_with(['l', 's', 'e']);
    if is_doubled { &stem[..stem.len() - 1] } else { stem }
}

/// Whether a line has a term in any form, maybe from the line `before` on.
fn contains(before: &str, line: &str, term: &str) -> bool {
    let term: Vec<&str> = words(term).into_iter().map(|word| word.text).collect();
    // A term or an allowed phrase may begin in the line before, and an allowed phrase may go on in the next.
    let mut text = words(before);
    text.drain(..text.len().saturating_sub(3));
    let first = text.len();
    text.extend(words(line));
    (0..text.len()).any(|at| {
        let end = at + term.len();
        let is_found = end > first
            && end <= text.len()
            && (at..end).all(|k| stem(text[k].text) == stem(term[k - at]))
            && (at + 1..end).all(|k| text[k].follows);
        is_found && !ALLOWED.iter().any(|allowed| is_within(&text, at, end, allowed))
    })
}

/// Whether the words from `at` to `end` are part of a phrase, which may go on beyond the text.
fn is_within(text: &[Word<'_>], at: usize, end: usize, phrase: &str) -> bool {
    let phrase: Vec<&str> = phrase.split(' ').collect();
    (end.saturating_sub(phrase.len())..=at).any(|begin| {
        let mut found = text[begin..].iter().zip(&phrase);
        found.len() > at - begin && found.all(|(word, wanted)| word.text == *wanted)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers of the lines of a source with an avoided term, as a place reads it.
    fn found(read: Reader, text: &str) -> Vec<usize> {
        let terms = terms(&super::read(&root().join("STYLE.md")).unwrap());
        let mut numbers: Vec<_> = avoided(&read(text), &terms).map(|(number, _)| number).collect();
        numbers.dedup();
        numbers
    }

    #[test]
    fn no_place_has_an_avoided_term() {
        assert_eq!(findings().unwrap(), [""; 0]);
    }

    #[test]
    fn terms_come_from_the_table_and_phrases_stand_for_those_that_depend_on_a_context() {
        let style = "## Terms\n\n| avoid | write |\n|---|---|\n| way, ways (of a vehicle) | path |\n| Greatest, least | maximum, minimum |\n\
                     | courses; a say | rollouts; weight |\n\n## Examples\n| no | more |\n";
        let found: Vec<String> = terms(style).into_iter().map(|t| t.avoid).collect();
        let (listed, phrases) = found.split_at(4);
        assert_eq!(listed, ["greatest", "least", "courses", "a say"]);
        assert_eq!(phrases, PHRASES.map(|(avoid, _)| avoid));
        assert!(terms(&super::read(&root().join("STYLE.md")).unwrap()).len() > 30);
    }

    #[test]
    fn a_term_is_found_as_whole_words_in_all_forms() {
        for (line, term, is_found) in [
            ("the least value", "least", true),
            ("at least one, the least-squares fit", "least", false),
            ("leastwise, un-least", "least", false),
            // It may be the first word of an allowed phrase, which goes on in the next line.
            ("the least", "least", false),
            ("the least common multiple", "least", false),
            ("the value was foretold", "foretells", true),
            ("it foresees what was foreseen", "foresees", true),
            ("the vehicle gets on", "gets on", true),
            ("it got on", "gets on", true),
            ("getting on", "gets on", true),
            ("it gets. On top", "gets on", false),
            ("it is priced", "price", true),
            ("a precise price-list", "price", false),
            ("what could be done", "can be done", false),
            ("what can be done", "can be done", true),
        ] {
            assert_eq!(contains("", line, term), is_found, "{line}: {term}");
        }
        assert!(contains("of at", "most or least 3", "least") && !contains("of at", "least 2 m", "least"));
        assert!(contains("it can", "be done", "can be done"));
    }

    #[test]
    fn each_kind_of_place_is_read() {
        let kinds: [(Reader, &str); 8] = [
            (prose, "The minimum.\nThe least value\n"),
            (python, "\"\"\"The minimum.\n\nThe least distance.\"\"\"\n"),
            (
                rust,
                "planner! { params: { a: 1 => \"minimum distance, m\",\n b: 2 => \"least distance, m\" } }\n",
            ),
            (rust, "/// The minimum distance.\npub fn least() {}\n/// The least distance.\n"),
            (
                literals,
                "/// The least distance.\nlet page = \"<p>The minimum distance\";\nlet page = \"<p>The least distance\";\n",
            ),
            (remarks, "/// The minimum distance.\nleast: f64, // the least distance\n"),
            (
                hashes,
                "description: The minimum distance.\nleast: 2  # the least distance\ndescription: The least distance.\n",
            ),
            (cells, "\"cell_type\": \"markdown\",\n\"The minimum\\n\",\n\"The least distance\"\n"),
        ];
        for (read, text) in kinds {
            let number = text.lines().count();
            assert!(found(read, text).contains(&number), "{text}");
            assert!(!found(read, text).contains(&1), "{text}");
        }
    }
}
