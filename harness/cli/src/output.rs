//! Writing to stdout, stderr and files. A reader that went away is no error: results are on disk. Any other failure of stdout is one –
//! whoever sends results to a file must not believe that they are there – and the program ends with it.

use std::fs::File;
use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use clap::ColorChoice;
use serde::Serialize;
use vb_files::NewFile;
use vb_record::RunReader;
use vb_score::Outcome;

use crate::args::{ForceArgs, GlobalArgs};
use crate::error::CliError;

/// Why stdout could not be written, the first time that it couldn't.
static FAILURE: OnceLock<String> = OnceLock::new();

/// How much is said; everything but details before the options are known.
static SAID: OnceLock<GlobalArgs> = OnceLock::new();

/// Says as much as the user wants, in the colours that they want.
pub(crate) fn set_up(options: GlobalArgs) {
    let _ = SAID.set(options);
    // Where it is auto, the library looks at the terminal and at `NO_COLOR`.
    let colours = match options.color {
        ColorChoice::Auto => return,
        ColorChoice::Always => true,
        ColorChoice::Never => false,
    };
    console::set_colors_enabled(colours);
    console::set_colors_enabled_stderr(colours);
}

/// Whether neither progress nor hints are wanted.
pub(crate) fn is_quiet() -> bool {
    SAID.get().is_some_and(|options| options.quiet)
}

/// Whether details are wanted.
pub(crate) fn is_verbose() -> bool {
    SAID.get().is_some_and(|options| options.verbose)
}

/// Text to stdout.
pub(crate) fn text(text: &str) {
    let mut out = std::io::stdout().lock();
    check(out.write_all(text.as_bytes()).and_then(|()| out.flush()));
}

/// Remembers a failure of stdout.
pub(crate) fn check(written: std::io::Result<()>) {
    if let Err(e) = written
        && e.kind() != ErrorKind::BrokenPipe
    {
        let _ = FAILURE.set(e.to_string());
    }
}

/// The error that stdout could not be written, if so.
pub(crate) fn failure() -> Option<CliError> {
    let why = FAILURE.get()?;
    Some(CliError::output(format!(
        "cannot write to the standard output: {why} (free some space, or redirect it)"
    )))
}

/// The number of columns of the terminal that stdout goes to; none for files and pipes, which have no end of a line.
pub(crate) fn width() -> Option<usize> {
    let out = console::Term::stdout();
    // Less than this is no width to write for.
    out.is_term().then(|| out.size_checked()).flatten().map(|(_, columns)| usize::from(columns).max(40))
}

/// An outcome in its colour, if stderr is a terminal that has colours and nobody asked for none (`NO_COLOR`), or the user asks for
/// colours.
pub(crate) fn coloured(outcome: Outcome) -> console::StyledObject<&'static str> {
    let style = console::Style::new().for_stderr();
    let style = match outcome {
        Outcome::Success => style.green(),
        Outcome::Rollover => style.red(),
        Outcome::Stuck => style.yellow(),
        Outcome::Timeout | Outcome::OutOfBounds => style.cyan(),
        Outcome::PlannerError | Outcome::SimError | Outcome::HostError => style.magenta().bold(),
    };
    style.apply_to(outcome.name())
}

/// One JSON object on a line of stdout.
pub(crate) fn json<T: Serialize>(value: &T) {
    match serde_json::to_string(value) {
        Ok(line) => text(&(line + "\n")),
        Err(e) => say(&format!("cannot encode a message: {e}")),
    }
}

/// Writes a file whole or not at all.
pub(crate) fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<(), CliError> {
    whole(path, |file| file.write_all(content.as_ref()).map_err(|e| unwritten(path, &e)))
}

/// Lets somebody write a file, which is there as a whole or not at all: what was there before stays until then. A pipe or a device
/// gets its content as it comes.
pub(crate) fn whole(
    path: &Path,
    make: impl FnOnce(&mut File) -> Result<(), CliError>,
) -> Result<(), CliError> {
    let failed = |e: std::io::Error| unwritten(path, &e);
    match Destination::of(path).map_err(failed)? {
        Destination::Stream(mut file) => make(&mut file),
        Destination::File(mut new) => {
            make(new.as_file_mut())?;
            new.finish().map_err(failed)
        }
    }
}

/// Looks whether [`whole`] can write a file, before the work for it is done.
///
/// # Errors
/// Returns the error that writing it would end in.
pub(crate) fn must_be_writable(path: &Path) -> Result<(), CliError> {
    // A pipe that is opened and closed again has ended for its reader, and without a reader it can't be opened.
    if is_stream(path) {
        return Ok(());
    }
    Destination::of(path).map(drop).map_err(|e| unwritten(path, &e))
}

/// The same of [`vb_files::write`], which follows no links, for a stranger may have made them.
///
/// # Errors
/// Returns the error that writing it would end in.
pub(crate) fn must_be_replaceable(path: &Path) -> Result<(), CliError> {
    NewFile::at(path).map(drop).map_err(|e| unwritten(path, &e))
}

/// Where the content of a file goes at first.
enum Destination {
    /// Into what can't be replaced.
    Stream(File),
    /// Into a file beside it, which is then given its place.
    File(NewFile),
}

impl Destination {
    fn of(path: &Path) -> std::io::Result<Self> {
        let place = match std::fs::metadata(path) {
            Ok(there) if !there.is_file() => {
                return std::fs::OpenOptions::new().write(true).open(path).map(Self::Stream);
            }
            // What a link leads to is meant, not the link.
            Ok(_) => std::fs::canonicalize(path)?,
            Err(_) => path.to_owned(),
        };
        NewFile::at(&place).map(Self::File)
    }
}

/// Refuses to write files over those of the runs that they are made of, and over each other.
pub(crate) fn must_spare(files: &[&Path], runs: &[PathBuf]) -> Result<(), CliError> {
    // A file that isn't there yet has its folder's place.
    let place = |path: &Path| {
        std::fs::canonicalize(path).ok().or_else(|| {
            let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
            Some(std::fs::canonicalize(folder).ok()?.join(path.file_name()?))
        })
    };
    let places: Vec<_> = files.iter().map(|file| place(file)).collect();
    for (k, own) in places.iter().enumerate() {
        let Some(own) = own else { continue };
        if places[..k].iter().any(|other| other.as_ref() == Some(own)) && !is_stream(own) {
            return Err(CliError::usage(format!("{}: two outputs have this path", files[k].display())));
        }
        if let Some(run) = runs.iter().find(|run| place(run).is_some_and(|dir| RunReader::owns(&dir, own))) {
            return Err(CliError::usage(format!(
                "{} is a file of the run {} and would be overwritten (give another file)",
                files[k].display(),
                run.display()
            )));
        }
    }
    Ok(())
}

/// Refuses to replace a file of an earlier call, unless the user wants it. A pipe or a device is not replaced.
pub(crate) fn must_not_replace(file: &Path, force: ForceArgs) -> Result<(), CliError> {
    if force.force || !file.exists() || is_stream(file) {
        return Ok(());
    }
    Err(CliError::output(format!(
        "{} already exists (choose another place, or replace it with --force)",
        file.display()
    )))
}

/// Refuses a folder that is not empty, unless the user wants it all the same.
pub(crate) fn must_be_empty(folder: &Path, force: ForceArgs) -> Result<(), CliError> {
    if force.force || is_free(folder) {
        return Ok(());
    }
    Err(CliError::output(format!(
        "output directory {} is not empty (choose another, or replace files in it with --force)",
        folder.display()
    )))
}

/// Whether no folder with content is there. What else is wrong with the place is found when it is written to.
pub(crate) fn is_free(folder: &Path) -> bool {
    !folder.read_dir().is_ok_and(|mut entries| entries.next().is_some())
}

/// Whether it is a pipe or a device, to which more than one may write.
fn is_stream(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|there| !there.is_file() && !there.is_dir())
}

/// Makes a folder, and those that it is in.
pub(crate) fn create_dir(path: &Path) -> Result<(), CliError> {
    std::fs::create_dir_all(path).map_err(|e| unwritten(path, &e))
}

/// Why a file or a folder isn't there.
pub(crate) fn unwritten(path: &Path, e: &std::io::Error) -> CliError {
    CliError::output(format!("cannot write {}: {e}", path.display()))
}

/// A line of progress, or a hint, to stderr, unless the user wants none.
pub(crate) fn note(line: &str) {
    if !is_quiet() {
        say(line);
    }
}

/// A line of progress with the outcome of a task in its colour, between two texts.
pub(crate) fn note_outcome(before: &str, outcome: Outcome, after: &str) {
    if !is_quiet() {
        let [before, after] = [before, after].map(vb_files::printable);
        let _ = writeln!(std::io::stderr(), "{before}{}{after}", coloured(outcome));
    }
}

/// A line to stderr: a warning, or where a result is. Paths and texts of strangers in it can't command the terminal.
pub(crate) fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{}", vb_files::printable(line));
}

/// A path as a shell takes it for one word.
pub(crate) fn word(path: &Path) -> String {
    let text = path.to_string_lossy();
    shlex::try_quote(&text).map_or_else(|_| text.to_string(), std::borrow::Cow::into_owned)
}

/// The one line that tells why a command failed.
pub(crate) fn error(e: &CliError) {
    say(&format!("error: {e}"));
}

/// Rows of cells as text with aligned columns: to the left, two spaces between.
pub(crate) fn columns(rows: &[Vec<String>]) -> String {
    let count = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |c: usize| rows.iter().filter_map(|r| r.get(c)).map(|s| s.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..count).map(width).collect();
    let mut out = String::new();
    for row in rows {
        let mut line = String::new();
        for (cell, width) in row.iter().zip(&widths) {
            line += cell;
            line += &" ".repeat(width + 2 - cell.chars().count());
        }
        out += line.trim_end();
        out.push('\n');
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_there_as_a_whole_or_as_it_was_before() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.csv");
        write(&path, "one").unwrap();
        let e = whole(&path, |file| {
            file.write_all(b"half").unwrap();
            Err(CliError::output("the disk is full"))
        });
        assert_eq!(e.unwrap_err().to_string(), "the disk is full");
        assert_eq!(std::fs::read(&path).unwrap(), b"one");
        must_be_writable(&path).unwrap();
        write(&path, "two").unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"two");
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1, "no temporary file stays");
        let e = write(&dir.path().join("gone/a.csv"), "x").unwrap_err().to_string();
        assert!(e.contains("cannot write") && e.contains("gone/a.csv"), "{e}");
        assert!(must_be_writable(dir.path()).is_err() && must_be_replaceable(dir.path()).is_err());
    }

    #[test]
    fn a_file_is_replaced_only_with_force() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.csv");
        let [kept, forced] = [false, true].map(|force| ForceArgs { force });
        must_not_replace(&path, kept).unwrap();
        write(&path, "one").unwrap();
        let e = must_not_replace(&path, kept).unwrap_err();
        assert_eq!(e.code(), crate::error::OUTPUT);
        assert!(e.to_string().contains("a.csv already exists") && e.to_string().contains("--force"), "{e}");
        must_not_replace(&path, forced).unwrap();
        #[cfg(unix)]
        must_not_replace(Path::new("/dev/null"), kept).unwrap();
    }

    #[cfg(unix)]
    #[test]
    fn a_link_is_followed_and_a_device_gets_its_content() {
        let dir = tempfile::tempdir().unwrap();
        let [file, link] = ["file", "link"].map(|name| dir.path().join(name));
        write(&file, "one").unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write(&link, "two").unwrap();
        assert_eq!(std::fs::read(&file).unwrap(), b"two");
        assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
        must_be_writable(&link).unwrap();
        assert!(must_be_replaceable(&link).unwrap_err().to_string().contains("in the way"));
        must_be_writable(Path::new("/dev/null")).unwrap();
        // Nobody reads this one yet, so that opening it would wait for ever.
        let pipe = dir.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        must_be_writable(&pipe).unwrap();
        write(Path::new("/dev/null"), "x").unwrap();
    }

    #[test]
    fn files_of_runs_and_other_outputs_are_spared() {
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        std::fs::create_dir_all(at("run/traces/w001")).unwrap();
        std::fs::write(at("run/tasks.jsonl"), "").unwrap();
        let spared = |files: &[PathBuf]| {
            let files: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
            must_spare(&files, &[at("run")])
        };
        spared(&[at("a.csv"), at("run/a.csv"), at("run/index.html"), at("gone/a.csv")]).unwrap();
        let files =
            ["run/tasks.jsonl", "run/run.json", "run/../run/tasks.jsonl", "run/traces/w001/t00.parquet"];
        for file in files {
            let e = spared(&[at("a.csv"), at(file)]).unwrap_err().to_string();
            assert!(e.contains(file) && e.contains("is a file of the run"), "{e}");
        }
        let e = spared(&[at("a.csv"), at("run/../a.csv")]).unwrap_err().to_string();
        assert!(e.contains("two outputs have this path"), "{e}");
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(at("run/tasks.jsonl"), at("link")).unwrap();
            assert!(spared(&[at("link")]).unwrap_err().to_string().contains("is a file of the run"));
            spared(&["/dev/null".into(), "/dev/null".into()]).unwrap();
        }
    }
}
