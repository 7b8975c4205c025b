//! Writing whole files so that they are either there or not.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Write as _};
use std::path::{Path, PathBuf};

use crate::StoreError;

/// Writes a file under a temporary name, syncs it and renames it, so that no reader ever sees half of it, and what was
/// written before something else is there if that is.
pub(crate) fn write_atomic(path: &Path, bytes: &[u8]) -> Result<(), StoreError> {
    let tmp = temporary(path);
    let written = (|| {
        let mut file = File::create(&tmp).map_err(StoreError::io("create", &tmp))?;
        file.write_all(bytes).map_err(StoreError::io("write", &tmp))?;
        durable(file.sync_all()).map_err(StoreError::io("sync", &tmp))?;
        fs::rename(&tmp, path).map_err(StoreError::io("rename to", path))?;
        path.parent().map(sync_dir);
        Ok(())
    })();
    if written.is_err() {
        // The first error is the one to report; a temporary file left behind harms nobody.
        let _ = fs::remove_file(&tmp);
    }
    written
}

/// The result of making a file durable. Some file systems (FUSE, SMB) can't, and say that it is no operation of theirs: what was
/// written is as safe there as it gets.
pub(crate) fn durable(synced: io::Result<()>) -> io::Result<()> {
    match synced {
        Err(e) if matches!(e.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Ok(()),
        other => other,
    }
}

/// `.NAME.tmp` beside the file.
fn temporary(path: &Path) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!(".{name}.tmp"))
}

/// Whether a directory entry is a left-over of [`write_atomic`] in a killed process.
pub(crate) fn is_temporary(name: &str) -> bool {
    name.starts_with('.') && name.ends_with(".tmp")
}

/// Makes renames and new files in a directory durable. Not all file systems allow it: an error is no failure.
pub(crate) fn sync_dir(dir: &Path) {
    if let Ok(d) = File::open(dir) {
        let _ = d.sync_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole_and_leaves_no_temporary() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.json");
        write_atomic(&path, b"one").unwrap();
        write_atomic(&path, b"two").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_full_disk_is_a_typed_error_that_leaves_the_old_file_alone() {
        // /dev/full refuses every write with ENOSPC; the temporary name leads there.
        let full = Path::new("/dev/full");
        if !full.exists() {
            vb_testing::skip("no /dev/full on this system");
            return;
        }
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.json");
        write_atomic(&path, b"old").unwrap();
        std::os::unix::fs::symlink(full, temporary(&path)).unwrap();
        let e = write_atomic(&path, b"new").unwrap_err();
        assert!(e.is_disk_full(), "{e}");
        assert!(e.to_string().contains("--resume"), "{e}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
    }
}
