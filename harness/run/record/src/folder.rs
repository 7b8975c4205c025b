//! Folders that one process alone writes, and folders that are there as a whole or not at all.

use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::StoreError;

/// The lock of a folder whose files the lock itself is none of.
const LOCK: &str = ".lock";
/// Where the content of a folder is made.
const WORKSHOP: &str = ".making";
/// The content, in the workshop.
const CONTENT: &str = "content";

/// The lock of a folder, which is free again when this is dropped, or the process has ended.
#[derive(Debug)]
pub struct FolderLock {
    file: File,
    path: PathBuf,
}

impl Drop for FolderLock {
    fn drop(&mut self) {
        // Closing the file would unlock it too, but not while a child process, being started on another thread,
        // has a copy of the descriptor. Nothing is left to be done about an error here.
        let _ = self.file.unlock();
    }
}

impl FolderLock {
    /// Locks a folder by a hidden file in it, which is made if need be.
    ///
    /// # Errors
    /// Returns [`StoreError::Locked`] if another process holds the lock, or an error of the file system.
    pub fn take(dir: &Path) -> Result<Self, StoreError> {
        Self::by(dir, LOCK)
    }

    /// The same of a folder that must be empty, and is made if need be.
    ///
    /// # Errors
    /// Returns [`StoreError::NotEmpty`], [`StoreError::Locked`], or an error of the file system.
    pub fn take_empty(dir: &Path) -> Result<Self, StoreError> {
        Self::of_empty(dir, LOCK, |_| false)
    }

    /// Locks a folder by a file of this name in it, and refuses one that holds more than that and what is `ours`.
    pub(crate) fn of_empty(dir: &Path, name: &str, ours: impl Fn(&str) -> bool) -> Result<Self, StoreError> {
        fs::create_dir_all(dir).map_err(StoreError::io("make directory", dir))?;
        let ours = |entry: &str| entry == name || ours(entry);
        // A folder with a lock is one of ours: that it is in use says more than that it is not empty.
        if !dir.join(name).exists() {
            refuse_unless_empty(dir, ours)?;
        }
        let lock = Self::by(dir, name)?;
        refuse_unless_empty(dir, ours)?;
        Ok(lock)
    }

    /// Locks a folder by a file of this name in it.
    pub(crate) fn by(dir: &Path, name: &str) -> Result<Self, StoreError> {
        let path = dir.join(name);
        let file = OpenOptions::new()
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(StoreError::io("create", &path))?;
        match file.try_lock() {
            Ok(()) => Ok(Self { file, path }),
            Err(TryLockError::WouldBlock) => Err(StoreError::Locked(dir.to_owned())),
            // Some network file systems have no locks: better to run unprotected than not at all.
            Err(TryLockError::Error(e)) if has_no_locks(&e) => Ok(Self { file, path }),
            Err(TryLockError::Error(source)) => Err(StoreError::Io { action: "lock", path, source }),
        }
    }

    /// Removes the lock with its file, for a folder that is finished: who comes now finds it so.
    pub fn remove(self) {
        let path = self.path.clone();
        drop(self);
        // An empty hidden file that stays harms nobody.
        let _ = fs::remove_file(path);
    }
}

/// Whether an error of locking says that the file system has no locks: none at all, or, on a network file system whose lock service
/// doesn't run, none to be had (ENOLCK, which is 37 on Linux and 77 on macOS and the BSDs).
fn has_no_locks(e: &std::io::Error) -> bool {
    let none_to_be_had = if cfg!(target_os = "linux") { 37 } else { 77 };
    e.kind() == ErrorKind::Unsupported || (cfg!(unix) && e.raw_os_error() == Some(none_to_be_had))
}

/// A folder whose content is made within it, under a hidden name, and gets its place only when it is whole. Meanwhile the
/// folder is locked. What was made is removed if it is not finished.
///
/// It is made within the folder, not beside it, since the folder may be a disk of its own, or the working directory.
#[derive(Debug)]
pub struct NewFolder {
    out: PathBuf,
    /// Whether the folder wasn't there before.
    is_new: bool,
    lock: Option<FolderLock>,
}

impl Drop for NewFolder {
    fn drop(&mut self) {
        // Nothing is left to be done about errors here: what stays is hidden, and who makes the folder next removes it.
        let _ = fs::remove_dir_all(self.workshop());
        if let Some(lock) = self.lock.take() {
            lock.remove();
        }
        if self.is_new {
            // Fails where it has its content.
            let _ = fs::remove_dir(&self.out);
        }
    }
}

impl NewFolder {
    /// Begins the content of a folder, which must be empty or missing.
    ///
    /// # Errors
    /// Returns [`StoreError::Taken`], [`StoreError::Locked`], or an error of the file system.
    pub fn new(out: &Path) -> Result<Self, StoreError> {
        let is_new = !out.exists();
        // What a process that was killed left doesn't count.
        let lock = FolderLock::of_empty(out, LOCK, |name| name == WORKSHOP).map_err(|e| match e {
            StoreError::NotEmpty(dir) => StoreError::Taken(dir),
            e => e,
        })?;
        let folder = Self { out: out.to_owned(), is_new, lock: Some(lock) };
        let workshop = folder.workshop();
        match fs::remove_dir_all(&workshop) {
            Err(e) if e.kind() != ErrorKind::NotFound => return Err(StoreError::io("remove", &workshop)(e)),
            _ => {}
        }
        let dir = folder.dir();
        fs::create_dir_all(&dir).map_err(StoreError::io("make directory", &dir))?;
        Ok(folder)
    }

    /// A folder for what is needed on the way, and is removed in the end.
    #[must_use]
    pub fn workshop(&self) -> PathBuf {
        self.out.join(WORKSHOP)
    }

    /// Where the content is made, which is a folder in the workshop.
    #[must_use]
    pub fn dir(&self) -> PathBuf {
        self.workshop().join(CONTENT)
    }

    /// Puts the content in its place, the file `last` as the last: who looks for it finds all or nothing.
    ///
    /// # Errors
    /// Returns an error of the file system.
    pub fn finish(self, last: &str) -> Result<(), StoreError> {
        let dir = self.dir();
        let mut names = Vec::new();
        for entry in fs::read_dir(&dir).map_err(StoreError::io("read directory", &dir))? {
            names.push(entry.map_err(StoreError::io("read directory", &dir))?.file_name());
        }
        names.sort_by_key(|name| name == OsStr::new(last));
        for name in names {
            let to = self.out.join(&name);
            fs::rename(dir.join(&name), &to).map_err(StoreError::io("rename to", &to))?;
        }
        vb_files::sync_dir(&self.out);
        Ok(())
    }
}

/// Refuses a folder that holds something else than what is `ours`.
fn refuse_unless_empty(dir: &Path, ours: impl Fn(&str) -> bool) -> Result<(), StoreError> {
    for entry in fs::read_dir(dir).map_err(StoreError::io("read directory", dir))? {
        let name = entry.map_err(StoreError::io("read directory", dir))?.file_name();
        if !ours(&name.to_string_lossy()) {
            return Err(StoreError::NotEmpty(dir.to_owned()));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_there_as_a_whole_or_not_at_all_and_has_one_maker() {
        let tmp = tempfile::tempdir().unwrap();
        let out = tmp.path().join("out");
        for given in [false, true] {
            if given {
                fs::create_dir(&out).unwrap();
            }
            let given_up = NewFolder::new(&out).unwrap();
            fs::write(given_up.dir().join("index"), "half").unwrap();
            assert!(matches!(NewFolder::new(&out).unwrap_err(), StoreError::Locked(_)));
            assert!(given_up.dir().join("index").exists(), "the other's work is left alone");
            assert!(!out.join("index").exists());
            drop(given_up);
            assert_eq!(out.exists(), given);
            let made = NewFolder::new(&out).unwrap();
            fs::create_dir(made.dir().join("worlds")).unwrap();
            fs::write(made.dir().join("index"), "whole").unwrap();
            made.finish("index").unwrap();
            let mut names: Vec<_> = fs::read_dir(&out).unwrap().map(|e| e.unwrap().file_name()).collect();
            names.sort();
            assert_eq!(names, ["index", "worlds"]);
            assert!(matches!(NewFolder::new(&out).unwrap_err(), StoreError::Taken(_)));
            assert_eq!(fs::read_dir(&out).unwrap().count(), 2, "a folder that is refused is left as it was");
            fs::remove_dir_all(&out).unwrap();
        }
    }

    #[test]
    fn what_a_killed_process_left_does_not_count() {
        let tmp = tempfile::tempdir().unwrap();
        fs::write(tmp.path().join(LOCK), "").unwrap();
        fs::create_dir(tmp.path().join(WORKSHOP)).unwrap();
        fs::write(tmp.path().join(WORKSHOP).join("old"), "").unwrap();
        let folder = NewFolder::new(tmp.path()).unwrap();
        assert_eq!(fs::read_dir(folder.dir()).unwrap().count(), 0);
    }

    #[test]
    fn a_file_system_without_locks_is_used_unlocked() {
        let none = if cfg!(target_os = "linux") { 37 } else { 77 };
        assert!(has_no_locks(&ErrorKind::Unsupported.into()));
        assert_eq!(has_no_locks(&std::io::Error::from_raw_os_error(none)), cfg!(unix));
        assert!(!has_no_locks(&ErrorKind::PermissionDenied.into()));
    }
}
