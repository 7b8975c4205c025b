//! Compiled plugins on disk.
//!
//! A file is named after everything that its content depends on: the plugin, the engine with its version and
//! configuration, the version of what is changed in a plugin before it is compiled, and this crate's version. It holds
//! machine code, which is run without further checks, so it is only taken if this user's harness wrote it: the file begins
//! with a keyed hash (HMAC-SHA256) over its name and content.
//! The key is random, made once for each user, and lies beside the files, readable by its owner only.
//!
//! What that protects from: files cut short, altered or swapped, be it by accident or by somebody who may write to the
//! directory but not read the key (a shared directory, a restored backup, a cache carried by CI). Directory, key and
//! files that belong to somebody else or that others may write to are not used at all. What it can't protect from:
//! somebody who runs programs as this user. They could replace the harness itself.
//!
//! Any number of processes may use the directory. Files are renamed into place when they are whole. The least
//! recently used go when there are too many bytes.

use std::fs::{File, Metadata};
use std::hash::{Hash as _, Hasher as _};
use std::io::{Error, Write as _};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use hmac::{Hmac, KeyInit as _, Mac as _};
use sha2::Sha256;
use vb_files::NewFile;
use wasmtime::Engine;
use wasmtime::component::Component;

const MAGIC: &[u8] = b"vb-harness compiled plugin 2\n";
const MAC_BYTES: usize = 32;
/// The block of SHA-256, which is the key's natural size in HMAC (RFC 2104, section 2).
const KEY_BYTES: usize = 64;
const KEY_FILE: &str = "cache.key";
const SUFFIX: &str = ".cwasm";
/// Size of all files together above which the least recently used are deleted. A planner in Rust takes 0.3 MB, one in
/// Python 35 MB.
const MAX_BYTES: u64 = 512 << 20;

/// One plugin's place in the cache.
#[derive(Debug)]
pub(super) struct Entry {
    dir: PathBuf,
    name: String,
    max_bytes: u64,
}

pub(super) fn entry(dir: &Path, engine: &Engine, sha256: &str) -> Entry {
    let mut hasher = std::hash::DefaultHasher::new();
    // wasmtime's version, the target and all settings that change the code.
    engine.precompile_compatibility_hash().hash(&mut hasher);
    vb_nan::VERSION.hash(&mut hasher);
    env!("CARGO_PKG_VERSION").hash(&mut hasher);
    let name = format!("{sha256}-{:016x}{SUFFIX}", hasher.finish());
    Entry { dir: dir.to_owned(), name, max_bytes: MAX_BYTES }
}

impl Entry {
    /// The compiled plugin, if a sound file of this user's is there.
    pub(super) fn load(&self, engine: &Engine) -> Option<Component> {
        let key = read_key(&self.dir)?;
        let file = vb_files::open(&self.path()).ok()?;
        if !is_own(&file.metadata().ok()?, &std::fs::symlink_metadata(&self.dir).ok()?) {
            return None;
        }
        let bytes = read(&file, self.max_bytes)?;
        let (mac, code) = bytes.strip_prefix(MAGIC)?.split_at_checked(MAC_BYTES)?;
        // Compares in constant time.
        self.mac(&key, code).verify_slice(mac).ok()?;
        // The time of the last use, for `prune`. Failing means no more than that the file goes earlier.
        let _ = file.set_modified(now());
        // SAFETY: the keyed hash shows that the bytes are those that `store` wrote for this plugin and engine, and they
        // are in this process's memory now. wasmtime checks that its version and configuration fit.
        unsafe { Component::deserialize(engine, code) }.ok()
    }

    /// Keeps the compiled plugin for the next time. Failing is no error: it costs that time a compilation.
    pub(super) fn store(&self, code: &[u8]) {
        let _ = self.try_store(code);
    }

    fn try_store(&self, code: &[u8]) -> Result<(), Box<dyn std::error::Error>> {
        make_dir(&self.dir)?;
        let key = match read_key(&self.dir) {
            Some(key) => key,
            None => make_key(&self.dir)?,
        };
        // As a whole, since other processes may be reading.
        let mut new = NewFile::private(&self.path())?;
        let file = new.as_file_mut();
        file.write_all(MAGIC)?;
        file.write_all(&self.mac(&key, code).finalize().into_bytes())?;
        file.write_all(code)?;
        new.finish()?;
        self.prune()?;
        Ok(())
    }

    fn path(&self) -> PathBuf {
        self.dir.join(&self.name)
    }

    /// Over the name too: a file under another plugin's name is as bad as one with other content.
    fn mac(&self, key: &[u8; KEY_BYTES], code: &[u8]) -> Hmac<Sha256> {
        let mut mac = Hmac::<Sha256>::new(&(*key).into());
        mac.update(self.name.as_bytes());
        mac.update(&[0]);
        mac.update(code);
        mac
    }

    /// Deletes the least recently used files until what is left is small enough, but never this one.
    fn prune(&self) -> Result<(), Error> {
        let mut files = Vec::new();
        for entry in std::fs::read_dir(&self.dir)? {
            let entry = entry?;
            let name = entry.file_name();
            if name.to_string_lossy().ends_with(SUFFIX)
                && name != *self.name
                && let Ok(meta) = entry.metadata()
            {
                files.push((meta.modified().unwrap_or(SystemTime::UNIX_EPOCH), entry.path(), meta.len()));
            }
        }
        files.sort();
        let mut total = std::fs::metadata(self.path())?.len() + files.iter().map(|f| f.2).sum::<u64>();
        for (_, path, len) in files {
            if total <= self.max_bytes {
                break;
            }
            // Another process may have deleted it already.
            let _ = std::fs::remove_file(path);
            total -= len;
        }
        Ok(())
    }
}

/// What is in a file, if it is no more than `most` bytes.
fn read(file: &File, most: u64) -> Option<Vec<u8>> {
    use std::io::Read as _;
    if file.metadata().ok()?.len() > most {
        return None;
    }
    let mut bytes = Vec::new();
    file.take(most).read_to_end(&mut bytes).ok()?;
    Some(bytes)
}

/// The user's key, if it is there, whole, and nobody else's.
fn read_key(dir: &Path) -> Option<[u8; KEY_BYTES]> {
    let dir_meta = std::fs::symlink_metadata(dir).ok()?;
    // A pipe of that name would wait for ever.
    let file = vb_files::open(&dir.join(KEY_FILE)).ok()?;
    let meta = file.metadata().ok()?;
    if !is_users_dir(dir, &dir_meta) || !is_own(&meta, &dir_meta) || !is_secret(&meta) {
        return None;
    }
    read(&file, KEY_BYTES as u64)?.try_into().ok()
}

/// Makes the key; if another process was faster, takes its key.
fn make_key(dir: &Path) -> Result<[u8; KEY_BYTES], Box<dyn std::error::Error>> {
    let meta = std::fs::symlink_metadata(dir)?;
    if !is_users_dir(dir, &meta) {
        return Err("the directory belongs to another user, or is writable for others".into());
    }
    let mut key = [0; KEY_BYTES];
    getrandom::fill(&mut key).map_err(|e| e.to_string())?;
    let mut file = tempfile::NamedTempFile::new_in(dir)?;
    file.write_all(&key)?;
    let path = dir.join(KEY_FILE);
    if let Err(error) = file.persist_noclobber(&path) {
        if let Some(key) = read_key(dir) {
            return Ok(key);
        }
        // One that is there but can't be trusted is replaced, and with it all that it signed.
        error.file.persist(&path)?;
    }
    Ok(key)
}

#[cfg(unix)]
fn make_dir(dir: &Path) -> Result<(), Error> {
    use std::os::unix::fs::DirBuilderExt as _;
    std::fs::DirBuilder::new().recursive(true).mode(0o700).create(dir)
}

#[cfg(not(unix))]
fn make_dir(dir: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(dir)
}

/// Whether it is a directory of this user's to which nobody else may write.
#[cfg(unix)]
fn is_users_dir(dir: &Path, meta: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    // A file made by this process belongs to its user.
    let user = || tempfile::tempfile_in(dir).and_then(|f| f.metadata()).map(|m| m.uid());
    meta.is_dir() && meta.mode() & 0o022 == 0 && user().is_ok_and(|user| user == meta.uid())
}

/// Whether the file belongs to the directory's owner, and nobody else may write to it.
#[cfg(unix)]
fn is_own(file: &Metadata, dir: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    file.is_file() && file.uid() == dir.uid() && file.mode() & 0o022 == 0
}

/// Whether only its owner can read the file.
#[cfg(unix)]
fn is_secret(file: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    file.mode() & 0o077 == 0
}

#[cfg(not(unix))]
fn is_users_dir(_: &Path, meta: &Metadata) -> bool {
    meta.is_dir()
}

#[cfg(not(unix))]
fn is_own(file: &Metadata, _: &Metadata) -> bool {
    file.is_file()
}

#[cfg(not(unix))]
fn is_secret(_: &Metadata) -> bool {
    true
}

#[allow(clippy::disallowed_methods, reason = "orders files by use: nothing of it reaches a score")]
fn now() -> SystemTime {
    SystemTime::now()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limits;

    fn engine() -> Engine {
        super::super::engine::new(&Limits::default()).unwrap()
    }

    /// The smallest component: magic, component version, layer.
    fn component(engine: &Engine) -> Vec<u8> {
        engine.precompile_component(b"\0asm\x0d\0\x01\0").unwrap()
    }

    #[cfg(unix)]
    fn set_mode(path: &Path, mode: u32) {
        use std::os::unix::fs::PermissionsExt as _;
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).unwrap();
    }

    #[test]
    fn only_a_sound_file_is_taken_from_the_cache() {
        let dir = tempfile::tempdir().unwrap();
        let engine = engine();
        let entry = entry(&dir.path().join("made/on/demand"), &engine, "abc");
        assert!(entry.load(&engine).is_none());
        entry.store(&component(&engine));
        assert!(entry.load(&engine).is_some());

        let sound = std::fs::read(entry.path()).unwrap();
        let mut flipped = sound.clone();
        *flipped.last_mut().unwrap() ^= 1;
        for damaged in [&sound[..sound.len() / 2], &sound[..40], &[], &flipped] {
            std::fs::write(entry.path(), damaged).unwrap();
            assert!(entry.load(&engine).is_none());
        }
        std::fs::write(entry.path(), &sound).unwrap();
        assert!(entry.load(&engine).is_some());
    }

    #[test]
    fn a_file_that_another_key_signed_or_of_another_name_is_not_taken() {
        let (ours, theirs) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let engine = engine();
        let [a, b] = [ours.path(), theirs.path()].map(|dir| entry(dir, &engine, "abc"));
        a.store(&component(&engine));
        b.store(&component(&engine));
        let forged = std::fs::read(b.path()).unwrap();
        std::fs::write(a.path(), forged).unwrap();
        assert!(a.load(&engine).is_none());
        // Whole and signed, but another plugin's.
        a.store(&component(&engine));
        let other = entry(ours.path(), &engine, "def");
        std::fs::copy(a.path(), other.path()).unwrap();
        assert!(other.load(&engine).is_none() && a.load(&engine).is_some());
    }

    /// Who opens a pipe waits for somebody to write into it; who reads a file of a tebibyte has no memory left.
    #[cfg(unix)]
    #[test]
    fn pipes_and_endless_files_are_not_taken() {
        let dir = tempfile::tempdir().unwrap();
        let engine = engine();
        let entry = entry(&dir.path().join("cache"), &engine, "abc");
        entry.store(&component(&engine));
        let fifo = |path: &Path| {
            std::fs::remove_file(path).unwrap();
            assert!(std::process::Command::new("mkfifo").arg(path).status().unwrap().success());
        };
        fifo(&entry.path());
        assert!(entry.load(&engine).is_none());
        std::fs::remove_file(entry.path()).unwrap();
        entry.store(&component(&engine));
        assert!(entry.load(&engine).is_some());
        std::fs::OpenOptions::new().write(true).open(entry.path()).unwrap().set_len(1 << 40).unwrap();
        assert!(entry.load(&engine).is_none());
        fifo(&entry.dir.join(KEY_FILE));
        assert!(entry.load(&engine).is_none());
        // Another key takes its place.
        entry.store(&component(&engine));
        assert!(entry.load(&engine).is_some());
    }

    #[cfg(unix)]
    #[test]
    fn what_others_may_write_or_read_the_key_of_is_not_trusted() {
        let dir = tempfile::tempdir().unwrap();
        let engine = engine();
        let entry = entry(&dir.path().join("cache"), &engine, "abc");
        entry.store(&component(&engine));
        for (path, bad, good) in [
            (entry.path(), 0o666, 0o600),
            (entry.dir.clone(), 0o777, 0o700),
            (entry.dir.join(KEY_FILE), 0o644, 0o600),
        ] {
            set_mode(&path, bad);
            assert!(entry.load(&engine).is_none(), "{}", path.display());
            set_mode(&path, good);
            assert!(entry.load(&engine).is_some(), "{}", path.display());
        }
        // Nothing is written to a directory of everybody's.
        let shared = super::entry(&dir.path().join("shared"), &engine, "abc");
        std::fs::create_dir(&shared.dir).unwrap();
        set_mode(&shared.dir, 0o777);
        shared.store(&component(&engine));
        assert_eq!(std::fs::read_dir(&shared.dir).unwrap().count(), 0);
    }

    #[test]
    fn a_damaged_key_is_replaced_and_what_it_signed_compiled_anew() {
        let dir = tempfile::tempdir().unwrap();
        let engine = engine();
        let entry = entry(dir.path(), &engine, "abc");
        entry.store(&component(&engine));
        std::fs::write(dir.path().join(KEY_FILE), b"short").unwrap();
        assert!(entry.load(&engine).is_none());
        entry.store(&component(&engine));
        assert!(entry.load(&engine).is_some());
    }

    #[test]
    fn writers_at_the_same_time_leave_a_sound_file() {
        let dir = tempfile::tempdir().unwrap();
        let engine = engine();
        let component = component(&engine);
        let entry = entry(dir.path(), &engine, "abc");
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    entry.store(&component);
                    assert!(entry.load(&engine).is_some());
                });
            }
        });
        // The file and the key, and nothing left over.
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 2);
    }

    #[test]
    fn the_least_recently_used_files_go() {
        let dir = tempfile::tempdir().unwrap();
        let engine = engine();
        let component = component(&engine);
        let mut entries = ["a", "b", "c"].map(|name| entry(dir.path(), &engine, name));
        for (age, entry) in [300, 200, 100].into_iter().zip(&entries) {
            entry.store(&component);
            let file = File::options().write(true).open(entry.path()).unwrap();
            file.set_modified(now() - std::time::Duration::from_secs(age)).unwrap();
        }
        // Using it makes the oldest the newest.
        assert!(entries[0].load(&engine).is_some());
        let size = std::fs::metadata(entries[0].path()).unwrap().len();
        entries[2].max_bytes = 2 * size + size / 2;
        entries[2].store(&component);
        assert_eq!(entries.map(|e| e.path().exists()), [true, false, true]);
    }
}
