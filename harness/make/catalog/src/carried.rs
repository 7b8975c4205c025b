//! The folder `tasks` as a program carries it within itself, so that it needs no other file.

use std::path::PathBuf;

use crate::CatalogError;

/// A packed folder `tasks` ([`vb_files::bundle`]).
#[derive(Clone, Copy)]
pub struct Carried {
    pub bundle: &'static [u8],
    /// Tells it from those of other versions: hexadecimal digits of its SHA-256.
    pub hash: &'static str,
}

impl std::fmt::Debug for Carried {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Carried({}, {} bytes)", self.hash, self.bundle.len())
    }
}

impl Carried {
    /// The folder in the user's data where it is unpacked; it is unpacked now if it wasn't before.
    pub(crate) fn unpacked(self) -> Result<PathBuf, CatalogError> {
        let data = crate::data_dir().ok_or(CatalogError::NoDataFolder)?;
        self.unpacked_in(data)
    }

    fn unpacked_in(self, data: PathBuf) -> Result<PathBuf, CatalogError> {
        let tasks = data.join(format!("tasks-{}", self.hash));
        if tasks.is_dir() {
            return Ok(tasks);
        }
        let failed = |source| CatalogError::Unpack { path: tasks.clone(), source };
        std::fs::create_dir_all(&data).map_err(failed)?;
        // Under another name and then renamed, so that it is whole if it is there.
        let unfinished = tempfile::Builder::new().prefix(".unpacking-").tempdir_in(&data).map_err(failed)?;
        let inner = unfinished.path().join("tasks");
        vb_files::bundle::unpack(self.bundle, &inner).map_err(failed)?;
        match std::fs::rename(&inner, &tasks) {
            // Another process may have been faster.
            Err(e) if !tasks.is_dir() => Err(failed(e)),
            _ => Ok(tasks),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_unpacked_once_and_whole() {
        let dir = tempfile::tempdir().unwrap();
        let (from, data) = (dir.path().join("tasks"), dir.path().join("deep/data"));
        std::fs::create_dir_all(from.join("vehicles")).unwrap();
        std::fs::write(from.join("vehicles/a.yaml"), "x").unwrap();
        let bundle: &'static [u8] = vb_files::bundle::pack(&from).unwrap().leak();
        let carried = Carried { bundle, hash: "0123" };
        let tasks = carried.unpacked_in(data.clone()).unwrap();
        assert_eq!(tasks, data.join("tasks-0123"));
        let file = tasks.join("vehicles/a.yaml");
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "x");
        // What is there is taken, and nothing else is left there.
        std::fs::write(&file, "y").unwrap();
        assert_eq!(carried.unpacked_in(data.clone()).unwrap(), tasks);
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "y");
        assert_eq!(std::fs::read_dir(&data).unwrap().count(), 1);
    }

    #[test]
    fn why_it_cannot_be_unpacked_is_told_with_the_place() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("file");
        std::fs::write(&file, "").unwrap();
        let carried = Carried { bundle: b"no bundle", hash: "0123" };
        for data in [file, dir.path().join("data")] {
            let e = carried.unpacked_in(data.clone()).unwrap_err().to_string();
            assert!(
                e.contains(&data.join("tasks-0123").display().to_string()) && e.contains("VB_DATA"),
                "{e}"
            );
            assert!(!data.join("tasks-0123").exists());
        }
    }
}
