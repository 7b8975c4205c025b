//! Contents that the Python package and the archives of releases share: tracked files, planners, the stripped program.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::plugins;
use crate::run::{Failure, output, step};

pub(crate) fn failure(path: &Path) -> impl Fn(std::io::Error) -> Failure + '_ {
    move |e| Failure::new(format!("{}: {e}", path.display()))
}

pub(crate) fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    std::fs::read(path).map_err(failure(path))
}

/// Returns the source files in a folder of the repository, relative to the repository: those that git doesn't ignore, or all
/// files in sources without git.
pub(crate) fn sources(folder: &str) -> Result<Vec<PathBuf>, Failure> {
    let root = crate::root();
    let mut files: Vec<PathBuf> = if root.join(".git").exists() {
        let mut git = Command::new("git");
        git.args(["ls-files", "--cached", "--others", "--exclude-standard", "--", folder]).current_dir(root);
        let list = output(git.stderr(Stdio::inherit())).ok_or_else(|| {
            Failure::new(format!("git can't list the files in {folder}: is git installed?"))
        })?;
        // A file that was deleted, but not yet in the index, is listed.
        list.lines().map(PathBuf::from).filter(|file| root.join(file).is_file()).collect()
    } else {
        let mut files = Vec::new();
        walk(&root.join(folder), &mut files)?;
        files.iter().filter_map(|file| file.strip_prefix(root).ok()).map(Path::to_owned).collect()
    };
    files.sort();
    Ok(files)
}

/// Documents in the archive of a release: pages and examples, and what they link to besides `tasks` and the SDK for Rust.
const DOCUMENTS: [&str; 16] = [
    "README.md",
    "ARCHITECTURE.md",
    "CHANGELOG.md",
    "CITATION.cff",
    "CODE_OF_CONDUCT.md",
    "CONTRIBUTING.md",
    "LICENSE-APACHE",
    "LICENSE-MIT",
    "SECURITY.md",
    "STYLE.md",
    "docs",
    "examples",
    "harness/python/Containerfile",
    "harness/python/README.md",
    "sdk/c",
    "sdk/python",
];

/// Returns the documents, relative to the repository.
pub(crate) fn documents() -> Result<Vec<PathBuf>, Failure> {
    let mut files = Vec::new();
    for place in DOCUMENTS {
        let found = sources(place)?;
        if found.is_empty() {
            return Err(Failure::new(format!("{place}: missing")));
        }
        files.extend(found);
    }
    Ok(files)
}

/// Returns the text of a page without links to files, which lead nowhere outside the repository: each becomes its label with the
/// path of the file.
pub(crate) fn without_links(text: &str) -> String {
    let mut is_code = false;
    let mut lines = Vec::new();
    for line in text.lines() {
        is_code ^= line.trim_start().starts_with("```");
        lines.push(if is_code { line.to_owned() } else { line_without_links(line) });
    }
    lines.join("\n") + "\n"
}

fn line_without_links(line: &str) -> String {
    let mut done = String::new();
    let mut rest = line;
    while let Some((before, target, after)) = next_link(rest) {
        let (text, label) = before.rsplit_once('[').unwrap_or((before, ""));
        let path = target.split('#').next().unwrap_or_default().trim_start_matches("../");
        done += &if target.contains("://") || target.starts_with('#') {
            format!("{before}]({target})")
        } else if label == path {
            format!("{text}{label}")
        } else {
            format!("{text}{label} (`{path}`)")
        };
        rest = after;
    }
    done + rest
}

/// Returns a line before and after the end of its first link, and the link's target.
fn next_link(line: &str) -> Option<(&str, &str, &str)> {
    let (before, rest) = line.split_once("](")?;
    let (target, after) = rest.split_once(')')?;
    Some((before, target, after))
}

fn walk(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), Failure> {
    for entry in std::fs::read_dir(folder).map_err(failure(folder))? {
        let path = entry.map_err(failure(folder))?.path();
        match path.is_dir() {
            true if path.ends_with("__pycache__") => {}
            true => walk(&path, files)?,
            false => files.push(path),
        }
    }
    Ok(())
}

/// Returns the files of the planners for users, as WASM.
pub(crate) fn planners() -> Result<Vec<PathBuf>, Failure> {
    let folder = crate::default_plugin_dir();
    Ok(plugins::to_drive_with()?.iter().map(|name| folder.join(format!("{name}.wasm"))).collect())
}

/// Returns the SDK for Rust as a folder of its own, with paths in it: the crate is the root of a workspace, from which it inherits what
/// it inherits from that of the repository, and which has the one crate that it needs.
pub(crate) fn sdk() -> Result<Vec<(PathBuf, Vec<u8>)>, Failure> {
    const MATH: &str = "harness/base/math";
    let root = crate::root();
    let mut files = Vec::new();
    for (from, to) in [("sdk/Cargo.toml", ""), ("sdk/src", ""), ("sdk/wit", ""), (MATH, "vb-math")] {
        let base = if from == MATH { MATH } else { "sdk" };
        for file in sources(from)? {
            let within = file.strip_prefix(base).unwrap_or(&file);
            // Their tests and benchmarks need more crates.
            if within.starts_with("src") || within.starts_with("wit") || within.ends_with("Cargo.toml") {
                files.push((Path::new(to).join(within), read(&root.join(&file))?));
            }
        }
    }
    let manifest = String::from_utf8_lossy(&read(&root.join("Cargo.toml"))?).into_owned();
    let inherited = manifest
        .split_once("[workspace.package]")
        .and_then(|(_, rest)| rest.split_once("[profile."))
        .map(|(inherited, _)| inherited.replace(MATH, "vb-math"))
        .ok_or_else(|| Failure::new("Cargo.toml: [workspace.package] or [profile.…] after it is missing"))?;
    let own = files.iter_mut().find(|(path, _)| path == Path::new("Cargo.toml"));
    let (_, own) = own.ok_or_else(|| Failure::new("sdk/Cargo.toml: missing"))?;
    own.extend_from_slice(
        format!("\n[workspace]\nresolver = \"3\"\nmembers = [\"vb-math\"]\n\n[workspace.package]{inherited}")
            .as_bytes(),
    );
    Ok(files)
}

/// Copies a program without its symbols, a fifth of its size. They remain if `strip` is missing or made for another processor.
pub(crate) fn copy_stripped(program: &Path, to: &Path) -> Result<(), Failure> {
    std::fs::copy(program, to).map_err(failure(program))?;
    let stripped = Command::new("strip").arg(to).stderr(Stdio::null()).status();
    if !stripped.is_ok_and(|status| status.success()) {
        step(&format!("note: {} keeps its symbols, because `strip` failed", program.display()));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sources_are_listed_without_ignored_files() {
        let files = sources("harness/python/vertibench").unwrap();
        assert!(files.contains(&PathBuf::from("harness/python/vertibench/__init__.py")));
        assert!(
            files.is_sorted() && !files.iter().any(|file| file.to_string_lossy().contains("__pycache__"))
        );
        let mut walked = Vec::new();
        walk(&crate::root().join("harness/python/vertibench"), &mut walked).unwrap();
        assert!(walked.len() >= files.len() && walked.iter().all(|file| file.is_file()));
    }

    /// Cargo resolves it where nothing else of the repository is.
    #[test]
    fn the_sdk_is_a_package_of_its_own() {
        let folder = crate::target_dir().join("tmp/sdk-alone");
        crate::run::remove(&folder).unwrap();
        for (path, content) in sdk().unwrap() {
            let file = folder.join(path);
            std::fs::create_dir_all(file.parent().unwrap()).unwrap();
            std::fs::write(&file, content).unwrap();
        }
        let mut cargo = Command::new(crate::run::cargo_program());
        cargo.args(["metadata", "--no-deps", "--format-version", "1"]).current_dir(&folder);
        let told = output(&mut cargo).unwrap();
        assert!(told.contains("vb-sdk") && told.contains("vb-math"), "{told}");
    }

    /// Files and folders to which the pages link, each with the page.
    fn linked(page: &Path) -> Vec<PathBuf> {
        let text = String::from_utf8(read(&crate::root().join(page)).unwrap()).unwrap();
        let mut is_code = false;
        let mut found = Vec::new();
        for line in text.lines() {
            is_code ^= line.trim_start().starts_with("```");
            let mut rest = if is_code { "" } else { line };
            while let Some((_, target, after)) = next_link(rest) {
                rest = after;
                let path = target.split('#').next().unwrap();
                if target.contains(':') || path.is_empty() {
                    continue;
                }
                let mut whole = page.parent().unwrap().to_owned();
                for part in Path::new(path).components() {
                    match part {
                        std::path::Component::ParentDir => assert!(whole.pop(), "{}: {path}", page.display()),
                        part => whole.push(part),
                    }
                }
                found.push(whole);
            }
        }
        found
    }

    #[test]
    fn pages_in_the_archive_lead_to_files_of_it() {
        let documents = documents().unwrap();
        let mut files = documents.clone();
        files.extend(sources("tasks").unwrap());
        files.extend(sdk().unwrap().into_iter().map(|(path, _)| Path::new("sdk").join(path)));
        // Pages for contributors lead to sources.
        let for_contributors = ["ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md", "STYLE.md"];
        let pages = documents.iter().filter(|file| {
            file.extension().is_some_and(|e| e == "md")
                && !for_contributors.iter().any(|f| file == &Path::new(f))
        });
        let mut count = 0;
        for page in pages {
            for target in linked(page) {
                count += 1;
                let is_there = files.iter().any(|file| file.starts_with(&target));
                assert!(is_there, "{}: {} is not in the archive", page.display(), target.display());
            }
        }
        assert!(count > 300, "{count}");
        assert!(files.contains(&PathBuf::from("docs/pictures/drive.gif")));
    }

    #[test]
    fn pages_for_package_indexes_have_no_relative_links() {
        assert_eq!(
            without_links(
                "[a](../../docs/a.md#b), [`c`](https://c.org) and\n[x/y.ipynb](../../x/y.ipynb)\n```sh\n[d](e)\n```"
            ),
            "a (`docs/a.md`), [`c`](https://c.org) and\nx/y.ipynb\n```sh\n[d](e)\n```\n"
        );
        let text = String::from_utf8(read(&crate::root().join("harness/python/README.md")).unwrap()).unwrap();
        let text = without_links(&text);
        assert!(text.contains("(`docs/results.md`)") && !text.contains("](../"), "{text}");
        // No label goes on in the next line.
        assert!(text.lines().all(|line| line.matches('[').count() == line.matches(']').count()), "{text}");
    }

    #[test]
    fn planners_for_tests_are_left_out() {
        let planners = planners().unwrap();
        let names: Vec<_> = planners.iter().map(|file| file.file_stem().unwrap().to_str().unwrap()).collect();
        assert!(
            ["pid", "eh", "mppi", "ibex", "expert", "pursuit"].iter().all(|name| names.contains(name)),
            "{names:?}"
        );
        assert!(
            !["faulty", "wild", "hybrid", "pursuit-c"].iter().any(|name| names.contains(name)),
            "{names:?}"
        );
    }
}
