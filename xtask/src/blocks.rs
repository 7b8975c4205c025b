//! Generated blocks of documents: what lies between the marks of a block is replaced, all else stays.

use std::path::Path;

use crate::run::{Failure, step};

/// Puts blocks, of which each has a name and a text, in their places in a document. Blocks without a place there are left out.
pub(crate) fn write(document: &Path, task: &str, blocks: &[(String, String)]) -> Result<(), Failure> {
    let wrong = |e: &dyn std::fmt::Display| Failure::new(format!("{}: {e}", document.display()));
    let mut text = std::fs::read_to_string(document).map_err(|e| wrong(&e))?;
    let mut found = 0;
    for (name, block) in blocks {
        if let Some(changed) = replaced(&text, task, name, block) {
            text = changed;
            found += 1;
        }
    }
    step(&format!("{}: {found} tables", document.display()));
    std::fs::write(document, text).map_err(|e| wrong(&e))
}

/// The text with another block between the marks of this name, if it has them.
fn replaced(text: &str, task: &str, name: &str, block: &str) -> Option<String> {
    let (begin, end) =
        (format!("<!-- made: {name} (by cargo xtask {task}) -->\n"), format!("<!-- end of {name} -->"));
    let (before, rest) = text.split_once(&begin)?;
    let (_, after) = rest.split_once(&end)?;
    Some(format!("{before}{begin}\n{block}\n{end}{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_is_replaced_between_its_marks_alone() {
        let text = "a\n<!-- made: t (by cargo xtask results) -->\nold\n<!-- end of t -->\nb\n";
        let new = replaced(text, "results", "t", "| new |\n").unwrap();
        assert_eq!(new, "a\n<!-- made: t (by cargo xtask results) -->\n\n| new |\n\n<!-- end of t -->\nb\n");
        assert_eq!(replaced(&new, "results", "t", "| new |\n").unwrap(), new);
        assert_eq!((replaced(text, "results", "u", ""), replaced(text, "fields", "t", "")), (None, None));
    }
}
