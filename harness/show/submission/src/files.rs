//! Files that strangers wrote: bounded, without links, with plain names.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufRead as _, BufReader, Read as _};
use std::ops::ControlFlow;
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;
use vb_files::Hash;
pub(crate) use vb_files::sha256;

use crate::SubmissionError;

pub(crate) const MANIFEST: &str = "submission.json";
/// The verdict's name: it is the verifier's, not the entrant's.
pub(crate) const VERDICT: &str = "verification.json";
/// Scores on a hidden suite, which the owner puts beside.
pub(crate) const HOLDOUT: &str = "holdout.json";
pub(crate) const RUN: &str = "run";
pub(crate) const REPORT: &str = "report.html";

/// Most bytes of a JSON document; the manifest of a million tasks is half of it.
pub(crate) const DOCUMENT: u64 = 256 << 20;
/// Most bytes of a small JSON document.
pub(crate) const SMALL: u64 = 1 << 20;
/// Most bytes of the report.
pub(crate) const PAGE: u64 = 64 << 20;
/// Most bytes of a line of `tasks.jsonl`: a planner's log is bounded to far less.
pub(crate) const LINE: u64 = 1 << 20;
/// Most bytes of a trace.
pub(crate) const TRACE: u64 = 64 << 20;
/// Most bytes of a file with a planner's own series; longer ones are left out of submissions.
pub(crate) const SERIES: u64 = 8 << 20;
/// Most bytes of any file.
const FILE: u64 = 4 << 30;
/// Most files in a submission.
const FILES: usize = 200;
/// Deepest folder: `run/traces/WORLD/TASK.parquet`.
const DEPTH: usize = 4;

/// The most bytes of a submission's file, by its name.
pub(crate) fn limit(name: &str) -> u64 {
    match name {
        REPORT => PAGE,
        _ if name.ends_with("/run.json") => SMALL,
        _ if name.ends_with("/summary.json") => DOCUMENT,
        _ if name.ends_with(".debug.parquet") => SERIES,
        _ if name.ends_with(".parquet") => TRACE,
        _ => FILE,
    }
}

/// The length of a JSON object's text without the value of its member `name`, bytes. Of what is no JSON it is anything.
pub(crate) fn length_without(text: &[u8], name: &str) -> usize {
    let (mut depth, mut in_text, mut escaped) = (0_usize, false, false);
    // The last text at depth 1, the name of the member whose value is read, and where that began.
    let (mut begun, mut last, mut open) = (0, &text[..0], None);
    let mut without = text.len();
    for (at, byte) in text.iter().enumerate() {
        if in_text {
            match byte {
                _ if escaped => escaped = false,
                b'\\' => escaped = true,
                b'"' => {
                    in_text = false;
                    if depth == 1 {
                        last = &text[begun..at];
                    }
                }
                _ => {}
            }
            continue;
        }
        match byte {
            b'"' => (in_text, begun) = (true, at + 1),
            b'{' | b'[' => depth += 1,
            b':' if depth == 1 && last == name.as_bytes() => open = open.or(Some(at)),
            b',' | b'}' | b']' => {
                if depth == 1
                    && let Some(from) = open.take()
                {
                    without -= at - from;
                    last = &text[..0];
                }
                if *byte != b',' {
                    depth = depth.saturating_sub(1);
                }
            }
            _ => {}
        }
    }
    without
}

/// Names of all files below `dir` with `/` between folders, and their sizes in bytes.
pub(crate) fn list(dir: &Path) -> Result<BTreeMap<String, u64>, SubmissionError> {
    let mut found = BTreeMap::new();
    let mut open = vec![(dir.to_owned(), String::new(), 1)];
    while let Some((folder, prefix, depth)) = open.pop() {
        for entry in fs::read_dir(&folder).map_err(SubmissionError::read(&folder))? {
            let entry = entry.map_err(SubmissionError::read(&folder))?;
            let path = entry.path();
            let refuse = |what| Err(SubmissionError::Unsafe { path: path.clone(), what });
            let name = entry.file_name();
            let Some(name) = name.to_str().filter(|n| is_plain(n)) else {
                return refuse("its name contains characters other than letters, digits, '-', '_' and '.'");
            };
            // Of the entry itself: a link is not followed.
            let meta = fs::symlink_metadata(&path).map_err(SubmissionError::read(&path))?;
            let full = format!("{prefix}{name}");
            if meta.is_dir() {
                if depth == DEPTH {
                    return refuse("the folder is nested too deeply");
                }
                open.push((path, format!("{full}/"), depth + 1));
            } else if !meta.is_file() {
                return refuse("it is neither a file nor a folder");
            } else if meta.len() > FILE {
                return Err(SubmissionError::TooLarge { path, what: "the size in bytes", limit: FILE });
            } else {
                found.insert(full, meta.len());
            }
            if found.len() + open.len() > FILES {
                return Err(SubmissionError::TooLarge {
                    path: dir.to_owned(),
                    what: "the number of files",
                    limit: FILES as u64,
                });
            }
        }
    }
    Ok(found)
}

/// Whether a name is safe on every system and in every address.
pub(crate) fn is_plain(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    !name.is_empty() && name.len() <= 120 && !name.starts_with('.') && name.chars().all(plain)
}

/// The bytes of a file of at most `limit` bytes, which is no link.
pub(crate) fn read(path: &Path, limit: u64) -> Result<Vec<u8>, SubmissionError> {
    let meta = fs::symlink_metadata(path).map_err(SubmissionError::read(path))?;
    if !meta.is_file() {
        return Err(SubmissionError::Unsafe {
            path: path.to_owned(),
            what: "it is neither a file nor a folder",
        });
    }
    if meta.len() > limit {
        return Err(SubmissionError::TooLarge { path: path.to_owned(), what: "the size in bytes", limit });
    }
    vb_files::read(path, limit).map_err(SubmissionError::read(path))
}

/// A JSON document with a number `schema`, which is one of `1..=newest`, and whose text passes a `check`.
pub(crate) fn read_json<T: DeserializeOwned>(
    path: &Path,
    limit: u64,
    newest: u32,
    check: impl FnOnce(&[u8]) -> Result<(), SubmissionError>,
) -> Result<(T, Vec<u8>), SubmissionError> {
    #[derive(serde::Deserialize)]
    struct Version {
        schema: u64,
    }
    let bytes = read(path, limit)?;
    let version: Version = serde_json::from_slice(&bytes).map_err(|e| SubmissionError::damaged(path, e))?;
    if !(1..=u64::from(newest)).contains(&version.schema) {
        return Err(SubmissionError::Schema {
            path: path.to_owned(),
            found: version.schema,
            supported: newest,
        });
    }
    check(&bytes)?;
    let value = serde_json::from_slice(&bytes).map_err(|e| SubmissionError::damaged(path, e))?;
    Ok((value, bytes))
}

/// A JSON document as it is written.
pub(crate) fn pretty<T: Serialize>(path: &Path, value: &T) -> Result<Vec<u8>, SubmissionError> {
    let mut bytes = serde_json::to_vec_pretty(value).map_err(|e| SubmissionError::damaged(path, e))?;
    bytes.push(b'\n');
    Ok(bytes)
}

/// Writes a file as a whole or not at all, and makes its folder before.
pub(crate) fn write(path: &Path, bytes: &[u8]) -> Result<(), SubmissionError> {
    let folder = path.parent().unwrap_or(Path::new("."));
    fs::create_dir_all(folder).map_err(SubmissionError::write(folder))?;
    vb_files::write(path, bytes).map_err(SubmissionError::write(path))
}

/// A directory that is new or empty.
pub(crate) fn empty_dir(dir: &Path) -> Result<(), SubmissionError> {
    fs::create_dir_all(dir).map_err(SubmissionError::write(dir))?;
    let mut entries = fs::read_dir(dir).map_err(SubmissionError::write(dir))?;
    if entries.next().is_some() { Err(SubmissionError::NotEmpty(dir.to_owned())) } else { Ok(()) }
}

/// The SHA-256 of a regular file, hexadecimal.
pub fn sha256_file(path: &Path) -> Result<String, SubmissionError> {
    let mut file = BufReader::new(vb_files::open(path).map_err(SubmissionError::read(path))?);
    let mut hasher = Hash::new();
    loop {
        let chunk = file.fill_buf().map_err(SubmissionError::read(path))?;
        if chunk.is_empty() {
            return Ok(hasher.hex());
        }
        hasher.update(chunk);
        let read = chunk.len();
        file.consume(read);
    }
}

/// Hands over the lines of a file, none of more than [`LINE`] bytes, without what ends them; each with whether it was ended. It stops
/// where `take` breaks off.
pub(crate) fn each_line(
    path: &Path,
    mut take: impl FnMut(usize, &[u8], bool) -> Result<ControlFlow<()>, SubmissionError>,
) -> Result<(), SubmissionError> {
    let mut file = BufReader::new(File::open(path).map_err(SubmissionError::read(path))?);
    let mut line = Vec::new();
    for number in 1.. {
        line.clear();
        (&mut file).take(LINE + 1).read_until(b'\n', &mut line).map_err(SubmissionError::read(path))?;
        if line.is_empty() {
            break;
        }
        if line.len() as u64 > LINE {
            return Err(SubmissionError::TooLarge {
                path: path.to_owned(),
                what: "the length of a line in bytes",
                limit: LINE,
            });
        }
        let ended = line.last() == Some(&b'\n');
        if ended {
            line.pop();
        }
        if take(number, &line, ended)?.is_break() {
            break;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_huge_line_is_refused_before_it_is_in_memory() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("tasks.jsonl");
        // A file without content on disk: 1 GiB of zeros and no end of a line.
        File::create(&path).unwrap().set_len(1 << 30).unwrap();
        let e = each_line(&path, |_, _, _| Ok(ControlFlow::Continue(()))).unwrap_err().to_string();
        assert!(e.contains("the length of a line in bytes exceeds 1048576"), "{e}");
    }

    #[test]
    fn links_odd_names_and_crowds_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir_all(dir.path().join("run/traces")).unwrap();
        fs::write(dir.path().join("run/run.json"), "{}").unwrap();
        assert_eq!(list(dir.path()).unwrap(), BTreeMap::from([("run/run.json".to_owned(), 2)]));
        #[cfg(unix)]
        {
            let link = dir.path().join("run/tasks.jsonl");
            std::os::unix::fs::symlink("/etc/passwd", &link).unwrap();
            let e = list(dir.path()).unwrap_err().to_string();
            assert!(e.contains("tasks.jsonl: it is neither a file nor a folder"), "{e}");
            assert!(read(&link, 1 << 20).is_err(), "a link is not followed");
            fs::remove_file(link).unwrap();
        }
        fs::write(dir.path().join("a b"), "").unwrap();
        assert!(list(dir.path()).is_err());
        fs::remove_file(dir.path().join("a b")).unwrap();
        for k in 0..FILES {
            fs::write(dir.path().join(k.to_string()), "").unwrap();
        }
        assert!(list(dir.path()).unwrap_err().to_string().contains("the number of files exceeds 200"));
    }

    #[test]
    fn a_member_is_measured_by_its_text() {
        for (text, without) in [
            (r#"{"a": 1, "tasks": {"x": [1, "}"]}, "b": 2}"#, r#"{"a": 1, "tasks", "b": 2}"#),
            (r#"{"tasks":"a,\"b}"}"#, r#"{"tasks"}"#),
            (r#"{"a": {"tasks": [1, 2, 3]}}"#, r#"{"a": {"tasks": [1, 2, 3]}}"#),
            (r#"{"a": "tasks", "b": [1, 2]}"#, r#"{"a": "tasks", "b": [1, 2]}"#),
            ("[]]]", "[]]]"),
            ("", ""),
        ] {
            assert_eq!(length_without(text.as_bytes(), "tasks"), without.len(), "{text}");
        }
    }

    #[test]
    fn newer_documents_are_refused_with_their_version() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.json");
        fs::write(&path, "{\"schema\": 3, \"unknown\": 1}").unwrap();
        let e = read_json::<serde_json::Value>(&path, SMALL, 2, |_| Ok(())).unwrap_err().to_string();
        assert!(e.contains("schema 3 is not supported; this version reads up to 2"), "{e}");
        assert!(
            read_json::<serde_json::Value>(&path, 10, 3, |_| Ok(()))
                .unwrap_err()
                .to_string()
                .contains("exceeds 10")
        );
    }
}
