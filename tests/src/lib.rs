//! What the end-to-end tests share: finding the built binary and the planners, running commands, reading results.
//!
//! The tests drive what `cargo xtask test` builds, as a user does: the release binary (and the one of the tests' own
//! profile, to compare), and the planner files. What is missing is an error, not a reason to skip a test: without the
//! program, one message ends all tests. Only the reference data beside the repository may be missing.

// Helpers of tests panic as tests do.
#![allow(clippy::unwrap_used, clippy::missing_panics_doc)]

mod browser;
mod mini;

use std::collections::BTreeMap;
use std::ffi::OsStr;
use std::fs;
use std::io::{BufRead as _, BufReader, Lines, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, ExitStatus, Output, Stdio};

use parquet::file::reader::{FileReader as _, SerializedFileReader};
use parquet::record::{Field, Row};
use serde_json::Value;

pub use browser::{Browser, Picture};
pub use mini::Mini;

/// The repository.
#[must_use]
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap()
}

/// The folder of cargo's profile that this test was built with, `TARGET/debug` as a rule.
fn profile_dir() -> PathBuf {
    let exe = std::env::current_exe().unwrap();
    exe.ancestors().nth(2).unwrap().to_owned()
}

fn target_dir() -> PathBuf {
    profile_dir().parent().unwrap().to_owned()
}

fn built(path: PathBuf) -> PathBuf {
    assert!(path.is_file(), "{} is missing: run `cargo xtask test`", path.display());
    path
}

/// The harness as users build it. In a checkout where it has not been built, a message ends the tests, since each of them
/// would fail alike.
#[must_use]
pub fn release_harness() -> PathBuf {
    let path = target_dir().join("release").join(format!("vb-harness{}", std::env::consts::EXE_SUFFIX));
    if !path.is_file() {
        // Not by a macro, whose output would be captured.
        let _ = writeln!(
            std::io::stderr(),
            "error: the end-to-end tests drive {}, which is missing (run `cargo xtask test`, which builds all that they need)",
            path.display()
        );
        std::process::exit(1);
    }
    path
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PluginKind {
    Wasm,
    Native,
}

/// The file of a planner of this repository.
#[must_use]
pub fn plugin(name: &str, plugin_kind: PluginKind) -> PathBuf {
    use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
    let dir = std::env::var_os("VB_PLUGINS").map_or_else(|| target_dir().join("plugins"), PathBuf::from);
    let file = match plugin_kind {
        PluginKind::Wasm => format!("{name}.wasm"),
        // Libraries are called by the name of their crate.
        PluginKind::Native => format!("{DLL_PREFIX}{}{DLL_SUFFIX}", name.replace('-', "_")),
    };
    // Commands run in folders of their own.
    std::path::absolute(built(dir.join(file))).unwrap()
}

/// `pid.wasm`.
#[must_use]
pub fn pid() -> PathBuf {
    plugin("pid", PluginKind::Wasm)
}

/// A folder in which commands run and leave their files; it is removed in the end.
#[derive(Debug)]
pub struct Bench {
    dir: tempfile::TempDir,
    harness: PathBuf,
}

impl Default for Bench {
    fn default() -> Self {
        Self { dir: tempfile::tempdir().unwrap(), harness: release_harness() }
    }
}

impl Bench {
    /// With the release harness.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Where a file in the folder lies.
    #[must_use]
    pub fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.dir.path().join(name)
    }

    /// A file in the folder, with its parents.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, content).unwrap();
    }

    /// A command of the harness, to be run in the folder with the tasks of this repository.
    #[must_use]
    pub fn command<S: AsRef<OsStr>>(&self, args: &[S]) -> Command {
        self.command_of(&self.harness, args)
    }

    /// The same of another program.
    #[must_use]
    pub fn command_of<S: AsRef<OsStr>>(&self, program: &Path, args: &[S]) -> Command {
        let mut command = Command::new(program);
        command.args(args).current_dir(self.dir.path()).stdin(Stdio::null());
        command.env("VB_TASKS", root().join("tasks"));
        // One cache for all tests: each planner is compiled once.
        command.env("VB_CACHE", target_dir().join("tmp/vb-cache"));
        command
    }

    /// Runs a command to its end.
    pub fn run<S: AsRef<OsStr>>(&self, args: &[S]) -> Done {
        Done::of(&mut self.command(args))
    }

    /// The standard output of a command that must succeed.
    pub fn ok<S: AsRef<OsStr>>(&self, args: &[S]) -> String {
        self.run(args).ok()
    }

    /// Starts a run with `--message-format json` that can be watched.
    pub fn watch<S: AsRef<OsStr>>(&self, args: &[S]) -> Watched {
        let mut command = self.command(args);
        command.args(["--message-format", "json"]);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let messages = BufReader::new(child.stdout.take().unwrap()).lines();
        Watched { child, messages }
    }

    /// The records of a run by the names of their tasks.
    #[must_use]
    pub fn records(&self, run: &str) -> BTreeMap<String, Value> {
        let text = fs::read_to_string(self.path(run).join("tasks.jsonl")).unwrap();
        let records = text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
        let named: Vec<_> = records.map(|r| (r["task"].as_str().unwrap().to_owned(), r)).collect();
        let count = named.len();
        let map: BTreeMap<_, _> = named.into_iter().collect();
        assert_eq!(map.len(), count, "a task is recorded twice in {run}");
        map
    }

    #[must_use]
    pub fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&fs::read(self.path(name)).unwrap()).unwrap()
    }

    /// All files below a folder with their bytes.
    #[must_use]
    pub fn files(&self, name: &str) -> BTreeMap<PathBuf, Vec<u8>> {
        let top = self.path(name);
        let mut found = BTreeMap::new();
        let mut open = vec![top.clone()];
        while let Some(dir) = open.pop() {
            for path in fs::read_dir(dir).unwrap().map(|e| e.unwrap().path()) {
                if path.is_dir() {
                    open.push(path);
                } else {
                    found.insert(path.strip_prefix(&top).unwrap().to_owned(), fs::read(&path).unwrap());
                }
            }
        }
        found
    }

    /// These columns of a Parquet file, row by row.
    #[must_use]
    pub fn columns(&self, name: &str, wanted: &[&str]) -> Vec<Vec<Value>> {
        let file = fs::File::open(self.path(name)).unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        let of = |row: &Row, wanted: &str| {
            let found = row.get_column_iter().find(|(name, _)| *name == wanted);
            value(found.unwrap_or_else(|| panic!("{name} has no column {wanted}")).1)
        };
        let row = |row: Row| wanted.iter().map(|name| of(&row, name)).collect();
        reader.get_row_iter(None).unwrap().map(|r| row(r.unwrap())).collect()
    }

    /// The rows of a Parquet file as objects by the names of the columns, read as any user reads them.
    #[must_use]
    pub fn parquet(&self, name: &str) -> Vec<Value> {
        let file = fs::File::open(self.path(name)).unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        let object =
            |row: Row| row.get_column_iter().map(|(name, field)| (name.clone(), value(field))).collect();
        reader.get_row_iter(None).unwrap().map(|row| object(row.unwrap())).collect()
    }
}

fn value(field: &Field) -> Value {
    match field {
        Field::Double(x) => (*x).into(),
        Field::Float(x) => (*x).into(),
        Field::Int(x) => (*x).into(),
        Field::Long(x) => (*x).into(),
        Field::Str(x) => x.as_str().into(),
        other => panic!("no test reads a field such as {other:?}"),
    }
}

/// A command that has ended.
#[derive(Debug)]
pub struct Done {
    /// Command line, for messages.
    what: String,
    pub status: ExitStatus,
    pub stdout: String,
    pub stderr: String,
}

impl Done {
    /// Runs a command to its end.
    pub fn of(command: &mut Command) -> Self {
        let Output { status, stdout, stderr } = command.output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Self { what: format!("{command:?}"), status, stdout: text(stdout), stderr: text(stderr) }
    }

    /// Its standard output; it must have succeeded.
    #[must_use]
    pub fn ok(self) -> String {
        assert_eq!(self.status.code(), Some(0), "{}: {}", self.what, self.stderr);
        self.stdout
    }

    /// The line that tells why it failed. It must have ended with this exit code, with just one such line, the last,
    /// and without a panic.
    #[must_use]
    pub fn error(self, code: i32) -> String {
        let Self { what, status, stderr, .. } = self;
        assert_eq!(status.code(), Some(code), "{what}: {stderr}");
        assert!(!stderr.contains("panicked"), "{what}: {stderr}");
        let errors: Vec<&str> = stderr.lines().filter(|l| l.starts_with("error:")).collect();
        assert_eq!(errors.len(), 1, "{what}: {stderr}");
        assert_eq!(stderr.lines().last(), Some(errors[0]), "{what}: nothing comes after the error: {stderr}");
        errors[0].to_owned()
    }
}

/// A run that is going on.
#[derive(Debug)]
pub struct Watched {
    child: Child,
    messages: Lines<BufReader<ChildStdout>>,
}

impl Watched {
    /// Waits until it has told this event once more.
    pub fn until(&mut self, event: &str) -> Value {
        for line in self.messages.by_ref() {
            let message: Value = serde_json::from_str(&line.unwrap()).unwrap();
            if message["event"] == event {
                return message;
            }
        }
        panic!("it ended without another event {event}");
    }

    /// Ends it without warning.
    pub fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Sends it the signal of Ctrl-C and waits for its end.
    #[cfg(unix)]
    pub fn interrupt(self) -> Done {
        let Self { child, messages } = self;
        let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
        assert!(sent.success());
        let stdout = messages.map(|line| line.unwrap() + "\n").collect();
        let Output { status, stderr, .. } = child.wait_with_output().unwrap();
        Done { what: "interrupted run".into(), status, stdout, stderr: String::from_utf8(stderr).unwrap() }
    }
}

pub fn copy_dir(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for path in fs::read_dir(from).unwrap().map(|e| e.unwrap().path()) {
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy_dir(&path, &target);
        } else {
            fs::copy(&path, &target).unwrap();
        }
    }
}
