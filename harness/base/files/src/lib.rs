//! Files that a user or a stranger names: read within bounds, written whole, told apart by their hash.
//!
//! A named pipe would hang whoever opens it, `/dev/zero` never ends, and a document of gigabytes fills the memory before anybody
//! can say that it makes no sense. So only regular files are read (links to such are fine), up to a limit that the caller states.
//!
//! Every crate of the harness can depend on this one, so it also has the lock of a mutex that a panic does not poison ([`lock`]).

pub mod bundle;
mod decoding;
pub mod document;
mod flaw;
mod hash;
mod lock;
mod text;
mod write;
pub mod yaml;

pub use decoding::{decoding, panic_text};
pub use document::{Document, Schema};
pub use flaw::{DocumentError, Flaw};
pub use hash::{Hash, sha256};
pub use lock::lock;
pub use text::{cut_line, one_line, printable};
pub use write::{NewFile, durable, is_temporary, sync_dir, write};

use std::fs::{self, File};
use std::io::{Error, ErrorKind, Read as _, Result};
use std::path::Path;

/// The most that is read of a document that people write or look at – a vehicle, rules, a suite's index – in bytes. The largest
/// that comes with the harness has 65 KB.
pub const DOCUMENT: u64 = 16 << 20;

/// The most that is read of a file of data – a raster, a plugin, a model – in bytes.
pub const DATA: u64 = 1 << 30;

/// Opens a file for reading if it is a regular one.
///
/// # Errors
/// If it is something else, or the operating system refuses.
pub fn open(path: &Path) -> Result<File> {
    if fs::metadata(path)?.is_file() {
        return File::open(path);
    }
    Err(Error::new(ErrorKind::InvalidInput, "it is no regular file"))
}

/// The content of a regular file of at most `limit` bytes.
///
/// # Errors
/// As [`open`], and if the file is larger.
pub fn read(path: &Path, limit: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    // The file may grow while it is read, so its stated size is not what bounds it.
    open(path)?.take(limit.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        let problem = format!("it is larger than {limit} bytes, the most that is read of such a file");
        return Err(Error::new(ErrorKind::InvalidData, problem));
    }
    Ok(bytes)
}

/// The same as text.
///
/// # Errors
/// As [`read`], and if it is no UTF-8.
pub fn read_text(path: &Path, limit: u64) -> Result<String> {
    String::from_utf8(read(path, limit)?)
        .map_err(|_| Error::new(ErrorKind::InvalidData, "it is no UTF-8 text"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_up_to_its_limit_and_refused_beyond() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        fs::write(&path, "12345").unwrap();
        assert_eq!(read(&path, 5).unwrap(), b"12345");
        let e = read(&path, 4).unwrap_err().to_string();
        assert!(e.contains("larger than 4 bytes"), "{e}");
        fs::write(&path, [0xff]).unwrap();
        assert!(read_text(&path, 5).unwrap_err().to_string().contains("UTF-8"));
        assert_eq!(read(&dir.path().join("b"), 5).unwrap_err().kind(), ErrorKind::NotFound);
    }

    #[cfg(unix)]
    #[test]
    fn what_never_ends_is_refused_at_once_and_links_to_files_are_fine() {
        use std::os::unix::fs::symlink;
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        symlink("/dev/zero", at("zero")).unwrap();
        assert!(std::process::Command::new("mkfifo").arg(at("fifo")).status().unwrap().success());
        for path in [at("zero"), at("fifo"), dir.path().to_owned()] {
            let e = read(&path, 5).unwrap_err().to_string();
            assert!(e.contains("no regular file"), "{}: {e}", path.display());
        }
        fs::write(at("a"), "x").unwrap();
        symlink(at("a"), at("link")).unwrap();
        assert_eq!(read(&at("link"), 5).unwrap(), b"x");
    }
}
