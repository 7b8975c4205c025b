//! A folder as one compressed value, which a program carries within itself.
//!
//! It is a zlib stream of entries, in the order of their names: the length of the file's path below the folder (32 bits, least
//! significant byte first), the path with `/` between its parts, the length of the content likewise, and the content.

use std::fs;
use std::io::{Cursor, Error, ErrorKind, Read, Result, Write as _};
use std::path::{Component, Path};

use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;

/// Packs the regular files of a folder and of those in it; files and folders whose names begin with a dot are left out.
///
/// # Errors
/// If something can't be read, has a name that is no UTF-8, or is no regular file.
pub fn pack(folder: &Path) -> Result<Vec<u8>> {
    let mut names = Vec::new();
    list(folder, "", &mut names)?;
    names.sort();
    let mut out = ZlibEncoder::new(Vec::new(), Compression::best());
    for name in names {
        let content = crate::read(&folder.join(&name), crate::DATA)
            .map_err(|e| Error::new(e.kind(), format!("{}: {e}", folder.join(&name).display())))?;
        for part in [name.as_bytes(), &content] {
            let length = u32::try_from(part.len()).map_err(Error::other)?;
            out.write_all(&length.to_le_bytes())?;
            out.write_all(part)?;
        }
    }
    out.finish()
}

/// Writes the files of a bundle below a folder that is new or empty.
///
/// # Errors
/// If it is no whole bundle, or one whose paths lead out of the folder, and if something can't be written.
pub fn unpack(bundle: &[u8], folder: &Path) -> Result<()> {
    let mut content = Vec::new();
    ZlibDecoder::new(bundle).take(crate::DATA).read_to_end(&mut content)?;
    let mut rest = Cursor::new(content);
    while rest.position() < rest.get_ref().len() as u64 {
        let name = String::from_utf8(part(&mut rest)?).map_err(|e| Error::new(ErrorKind::InvalidData, e))?;
        let path = Path::new(&name);
        if !path.components().all(|part| matches!(part, Component::Normal(_))) {
            return Err(Error::new(ErrorKind::InvalidData, format!("{name}: leads out of the folder")));
        }
        let path = folder.join(path);
        fs::create_dir_all(path.parent().unwrap_or(folder))?;
        fs::write(path, part(&mut rest)?)?;
    }
    Ok(())
}

fn part(rest: &mut impl Read) -> Result<Vec<u8>> {
    let mut length = [0; 4];
    rest.read_exact(&mut length)?;
    let length = u64::from(u32::from_le_bytes(length));
    let mut bytes = Vec::new();
    rest.take(length).read_to_end(&mut bytes)?;
    if (bytes.len() as u64) < length {
        return Err(Error::new(ErrorKind::UnexpectedEof, "the bundle is cut off"));
    }
    Ok(bytes)
}

fn list(folder: &Path, prefix: &str, names: &mut Vec<String>) -> Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let no_text =
            || Error::new(ErrorKind::InvalidData, format!("{}: no UTF-8 name", entry.path().display()));
        let name = entry.file_name().into_string().map_err(|_| no_text())?;
        if name.starts_with('.') {
            continue;
        }
        if entry.file_type()?.is_dir() {
            list(&entry.path(), &format!("{prefix}{name}/"), names)?;
        } else {
            names.push(format!("{prefix}{name}"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_comes_out_as_it_went_in() {
        let dir = tempfile::tempdir().unwrap();
        let (from, to) = (dir.path().join("from"), dir.path().join("to"));
        fs::create_dir_all(from.join("b/c")).unwrap();
        fs::create_dir_all(from.join(".hidden")).unwrap();
        for (name, content) in
            [("a", &b"1"[..]), ("b/c/empty", b""), ("b/zeros", &[0; 70_000]), (".hidden/x", b"no")]
        {
            fs::write(from.join(name), content).unwrap();
        }
        let bundle = pack(&from).unwrap();
        assert!(bundle.len() < 1000, "{}", bundle.len());
        assert_eq!(pack(&from).unwrap(), bundle);
        unpack(&bundle, &to).unwrap();
        for name in ["a", "b/c/empty", "b/zeros"] {
            assert_eq!(fs::read(to.join(name)).unwrap(), fs::read(from.join(name)).unwrap(), "{name}");
        }
        assert!(!to.join(".hidden").exists());
    }

    #[test]
    fn what_is_cut_off_or_leads_elsewhere_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let bundle = |entries: &[u8]| {
            let mut out = ZlibEncoder::new(Vec::new(), Compression::fast());
            out.write_all(entries).unwrap();
            out.finish().unwrap()
        };
        let out = dir.path().join("in");
        for (entries, reason) in [
            (&b"\x04\0\0\0../a\x01\0\0\0x"[..], "leads out"),
            (b"\x02\0\0\0/a\x01\0\0\0x", "leads out"),
            (b"\x01\0\0\0a\x09\0\0\0x", "cut off"),
            (b"\x01\0\0\0a", "failed to fill"),
        ] {
            let e = unpack(&bundle(entries), &out).unwrap_err().to_string();
            assert!(e.contains(reason), "{e}");
        }
        assert!(!dir.path().join("a").exists());
        assert!(unpack(b"no zlib", &out).is_err());
    }
}
