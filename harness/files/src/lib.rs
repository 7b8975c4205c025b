//! Files that a user or a stranger names: read within bounds, written whole, told apart by their hash.
//!
//! A named pipe would hang whoever opens it, `/dev/zero` never ends, and a document of gigabytes fills the memory before anybody
//! can say that it makes no sense. So only regular files are read (links to such are fine), up to a limit that the caller states.

pub mod bundle;
pub mod document;
mod hash;
mod text;
pub mod yaml;

pub use document::{Document, DocumentError, Flaw, Schema};
pub use hash::{Hash, sha256};
use std::fs::{self, File};
use std::io::{Error, ErrorKind, Read as _, Result, Write as _};
use std::path::Path;
pub use text::{one_line, printable};

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

/// Writes a file whole: under a new name beside it, which is then renamed. So no reader sees half of it, and what else is linked
/// to an older file of that name stays as it is. A link or device of that name is refused, not followed or replaced.
///
/// # Errors
/// If something else than a regular file is in the way, or the operating system refuses.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    match fs::symlink_metadata(path) {
        Ok(meta) if !meta.is_file() => {
            return Err(Error::new(
                ErrorKind::AlreadyExists,
                "a link, folder or device of that name is in the way",
            ));
        }
        Err(e) if e.kind() != ErrorKind::NotFound => return Err(e),
        _ => {}
    }
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".").suffix(".tmp");
    // Temporary files are for their owner alone; this one becomes an ordinary file, as the user's umask has it.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(parent)?;
    file.write_all(bytes)?;
    match file.as_file().sync_all() {
        // Some file systems can't make a file durable, and say that it is no operation of theirs.
        Err(e) if matches!(e.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => {}
        other => other?,
    }
    file.persist(path).map_err(|e| e.error)?;
    Ok(())
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

    #[cfg(unix)]
    #[test]
    fn a_file_is_replaced_not_written_through_its_links() {
        use std::os::unix::fs::{PermissionsExt as _, symlink};
        let dir = tempfile::tempdir().unwrap();
        let at = |name: &str| dir.path().join(name);
        fs::write(at("precious"), "old").unwrap();
        fs::hard_link(at("precious"), at("out")).unwrap();
        write(&at("out"), b"new").unwrap();
        assert_eq!(
            (fs::read(at("precious")).unwrap(), fs::read(at("out")).unwrap()),
            (b"old".into(), b"new".into())
        );
        assert_eq!(fs::metadata(at("out")).unwrap().permissions().mode() & 0o700, 0o600);
        symlink(at("precious"), at("link")).unwrap();
        assert!(write(&at("link"), b"new").unwrap_err().to_string().contains("in the way"));
        assert_eq!(fs::read(at("precious")).unwrap(), b"old");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 3, "no temporary file stays");
    }
}
