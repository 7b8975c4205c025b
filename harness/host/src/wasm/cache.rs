//! Compiled plugins on disk.
//!
//! A file is named after everything that its content depends on: the plugin, the engine with its configuration, and
//! this crate's version. It begins with a magic line and the SHA-256 of the rest, so a file that was cut short or
//! altered by accident is compiled anew. It is no protection against somebody who may write to the directory.

use std::hash::{Hash as _, Hasher as _};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use sha2::{Digest as _, Sha256};
use wasmtime::Engine;
use wasmtime::component::Component;

const MAGIC: &[u8] = b"vb-harness compiled plugin 1\n";
const DIGEST_BYTES: usize = 32;

/// One plugin's place in the cache.
#[derive(Debug)]
pub(super) struct Entry {
    dir: PathBuf,
    file: PathBuf,
}

pub(super) fn entry(dir: &Path, engine: &Engine, sha256: &str) -> Entry {
    let mut hasher = std::hash::DefaultHasher::new();
    engine.precompile_compatibility_hash().hash(&mut hasher);
    env!("CARGO_PKG_VERSION").hash(&mut hasher);
    let file = dir.join(format!("{sha256}-{:016x}.cwasm", hasher.finish()));
    Entry { dir: dir.to_owned(), file }
}

impl Entry {
    /// The compiled plugin, if a sound file is there.
    pub(super) fn load(&self, engine: &Engine) -> Option<Component> {
        if !only_owner_writes(&self.file) {
            return None;
        }
        let bytes = std::fs::read(&self.file).ok()?;
        let (digest, code) = bytes.strip_prefix(MAGIC)?.split_at_checked(DIGEST_BYTES)?;
        if Sha256::digest(code).as_slice() != digest {
            return None;
        }
        // SAFETY: the file lies in the user's own cache, nobody else may write to it, and its checksum is that of
        // the bytes which `store` wrote. wasmtime checks that its version and configuration fit.
        unsafe { Component::deserialize(engine, code) }.ok()
    }

    /// Keeps the compiled plugin for the next time. Failing is no error: it costs that time a compilation.
    pub(super) fn store(&self, component: &Component) {
        let _ = self.try_store(component);
    }

    fn try_store(&self, component: &Component) -> Result<(), Box<dyn std::error::Error>> {
        std::fs::create_dir_all(&self.dir)?;
        let code = component.serialize()?;
        // Renamed into place when it is whole, since other processes may be reading. Readable by its owner only.
        let mut file = tempfile::NamedTempFile::new_in(&self.dir)?;
        file.write_all(MAGIC)?;
        file.write_all(&Sha256::digest(&code))?;
        file.write_all(&code)?;
        file.persist(&self.file)?;
        Ok(())
    }
}

#[cfg(unix)]
fn only_owner_writes(file: &Path) -> bool {
    use std::os::unix::fs::PermissionsExt as _;
    std::fs::metadata(file).is_ok_and(|m| m.permissions().mode() & 0o022 == 0)
}

#[cfg(not(unix))]
fn only_owner_writes(_: &Path) -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_sound_file_is_taken_from_the_cache() {
        let dir = tempfile::tempdir().unwrap();
        let engine = super::super::engine::new().unwrap();
        let entry = entry(&dir.path().join("made/on/demand"), &engine, "abc");
        assert!(entry.load(&engine).is_none());
        // The smallest component: magic, component version, layer.
        entry.store(&Component::new(&engine, b"\0asm\x0d\0\x01\0").unwrap());
        assert!(entry.load(&engine).is_some());

        let sound = std::fs::read(&entry.file).unwrap();
        let mut flipped = sound.clone();
        *flipped.last_mut().unwrap() ^= 1;
        for damaged in [&sound[..sound.len() / 2], &sound[..40], &[], &flipped] {
            std::fs::write(&entry.file, damaged).unwrap();
            assert!(entry.load(&engine).is_none());
        }
        std::fs::write(&entry.file, &sound).unwrap();
        assert!(entry.load(&engine).is_some());
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_others_may_write_is_not_trusted() {
        use std::os::unix::fs::PermissionsExt as _;
        let dir = tempfile::tempdir().unwrap();
        let engine = super::super::engine::new().unwrap();
        let entry = entry(dir.path(), &engine, "abc");
        entry.store(&Component::new(&engine, b"\0asm\x0d\0\x01\0").unwrap());
        std::fs::set_permissions(&entry.file, std::fs::Permissions::from_mode(0o666)).unwrap();
        assert!(entry.load(&engine).is_none());
    }
}
