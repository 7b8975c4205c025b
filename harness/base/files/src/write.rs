//! Files that are there as a whole or not at all.

use std::fs::{self, File};
use std::io::{Error, ErrorKind, Result, Write as _};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile};

/// A new file under a temporary name next to its place, until [`NewFile::finish`] renames it. Dropped before, it leaves nothing.
#[derive(Debug)]
pub struct NewFile {
    file: NamedTempFile,
    place: PathBuf,
}

impl NewFile {
    /// Starts a file that will be at `place`, with the permissions of an ordinary file under the user's umask.
    ///
    /// # Errors
    /// Returns [`ErrorKind::AlreadyExists`] if a link, folder or device is at `place`: it is neither followed nor replaced. Returns
    /// other errors of the operating system, in particular if the folder is missing.
    pub fn at(place: &Path) -> Result<Self> {
        Self::start(place, 0o666)
    }

    /// Starts a file that only its owner may read.
    ///
    /// # Errors
    /// Returns the errors of [`NewFile::at`].
    pub fn private(place: &Path) -> Result<Self> {
        Self::start(place, 0o600)
    }

    #[cfg_attr(not(unix), expect(unused_variables, reason = "permissions of Unix"))]
    fn start(place: &Path, mode: u32) -> Result<Self> {
        match fs::symlink_metadata(place) {
            Ok(meta) if !meta.is_file() => {
                return Err(Error::new(
                    ErrorKind::AlreadyExists,
                    "a link, folder or device of that name is in the way",
                ));
            }
            Err(e) if e.kind() != ErrorKind::NotFound => return Err(e),
            _ => {}
        }
        let mut builder = Builder::new();
        builder.prefix(".").suffix(SUFFIX);
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(mode));
        Ok(Self { file: builder.tempfile_in(folder(place))?, place: place.to_owned() })
    }

    /// The temporary path, for programs that write or read the file by its name.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// The file, open for writing.
    pub fn as_file_mut(&mut self) -> &mut File {
        self.file.as_file_mut()
    }

    /// Makes the content durable and puts the file in its place, where it replaces an older file. Other hard links of the older file
    /// keep its content.
    ///
    /// # Errors
    /// Returns an error of the operating system; the older file is unchanged then.
    pub fn finish(self) -> Result<()> {
        durable(self.file.as_file().sync_all())?;
        self.file.persist(&self.place).map_err(|e| e.error)?;
        sync_dir(folder(&self.place));
        Ok(())
    }
}

/// The end of temporary names.
const SUFFIX: &str = ".tmp";

/// The folder of a file.
fn folder(file: &Path) -> &Path {
    file.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Writes a file as a whole or not at all, as [`NewFile::at`] does.
///
/// # Errors
/// Returns the errors of [`NewFile::at`] and [`NewFile::finish`].
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut file = NewFile::at(path)?;
    file.as_file_mut().write_all(bytes)?;
    file.finish()
}

/// Whether a killed process may have left a file of this name when it wrote another one.
#[must_use]
pub fn is_temporary(name: &str) -> bool {
    name.starts_with('.') && name.ends_with(SUFFIX)
}

/// The result of making a file durable. Some file systems (FUSE, SMB) report the operation as unsupported; this is no error.
///
/// # Errors
/// Returns all other errors.
pub fn durable(synced: Result<()>) -> Result<()> {
    match synced {
        Err(e) if matches!(e.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Ok(()),
        other => other,
    }
}

/// Makes renames and new files in a folder durable. Not all file systems can: an error is no failure.
pub fn sync_dir(dir: &Path) {
    if let Ok(dir) = File::open(dir) {
        let _ = dir.sync_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_there_as_a_whole_or_not_at_all() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.json");
        let names = || -> Vec<String> {
            let entries = fs::read_dir(dir.path()).unwrap();
            entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
        };
        write(&path, b"old").unwrap();
        let mut new = NewFile::at(&path).unwrap();
        new.as_file_mut().write_all(b"ha").unwrap();
        let other: Vec<String> = names().into_iter().filter(|name| name != "a.json").collect();
        assert!(other.len() == 1 && is_temporary(&other[0]), "{other:?}");
        assert_eq!(fs::read(&path).unwrap(), b"old");
        drop(new);
        assert_eq!((fs::read(&path).unwrap(), names()), (b"old".into(), vec!["a.json".to_owned()]));
        write(&path, b"new").unwrap();
        assert_eq!((fs::read(&path).unwrap(), names()), (b"new".into(), vec!["a.json".to_owned()]));
        assert_eq!(write(&dir.path().join("none/a"), b"").unwrap_err().kind(), ErrorKind::NotFound);
        assert!(!is_temporary("a.tmp") && !is_temporary(".a"));
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
        let mode = |name: &str| fs::metadata(at(name)).unwrap().permissions().mode() & 0o777;
        assert_eq!(mode("out") & 0o700, 0o600);
        NewFile::private(&at("secret")).unwrap().finish().unwrap();
        assert_eq!(mode("secret"), 0o600);
        symlink(at("precious"), at("link")).unwrap();
        assert!(write(&at("link"), b"new").unwrap_err().to_string().contains("in the way"));
        assert_eq!(fs::read(at("precious")).unwrap(), b"old");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 4, "no temporary file stays");
    }
}
