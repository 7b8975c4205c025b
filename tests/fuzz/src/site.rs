//! A folder of files of which an input replaces one.

use std::path::{Path, PathBuf};

use tempfile::TempDir;

/// Files in a folder in memory, where the system has such a place.
#[derive(Debug)]
pub(crate) struct Site {
    dir: TempDir,
    files: Vec<(PathBuf, Vec<u8>)>,
}

impl Site {
    pub(crate) fn new() -> Self {
        let memory = Path::new("/dev/shm");
        let dir = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() };
        Self { dir: dir.expect("a temporary folder"), files: Vec::new() }
    }

    pub(crate) fn path(&self) -> &Path {
        self.dir.path()
    }

    /// Takes these files, which already lie in the folder or are written now, as those to replace.
    pub(crate) fn with(mut self, files: Vec<(PathBuf, Vec<u8>)>) -> Self {
        for (name, bytes) in &files {
            self.write(name, bytes);
        }
        self.files = files;
        self
    }

    pub(crate) fn write(&self, name: &Path, bytes: &[u8]) {
        let path = self.dir.path().join(name);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).expect("a folder in the temporary folder");
        }
        std::fs::write(path, bytes).expect("a file in the temporary folder");
    }

    /// Puts the input in the place of the file that its first byte chooses, for the time of `act`.
    pub(crate) fn replacing(&self, data: &[u8], act: impl FnOnce(&Path)) {
        let Some((&kind, content)) = data.split_first() else { return };
        let (name, original) = &self.files[usize::from(kind) % self.files.len()];
        self.write(name, content);
        act(self.path());
        self.write(name, original);
    }

    /// The original files as inputs.
    pub(crate) fn seeds(&self) -> Vec<Vec<u8>> {
        self.files.iter().zip(0..).map(|((_, bytes), kind)| select(kind, bytes)).collect()
    }
}

/// An input that stands for one of several files.
pub(crate) fn select(kind: u8, content: &[u8]) -> Vec<u8> {
    [&[kind][..], content].concat()
}
