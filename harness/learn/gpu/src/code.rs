//! The kernels' machine code: which file is for a GPU, and whether it is of this program.

use std::io::{Error, ErrorKind, Read as _};
use std::path::Path;

use lzma_rust2::XzReader;
use vb_kernel::SOURCES;

use crate::GpuError;

/// The compute capabilities that kernels are made for (`cargo xtask kernel`). Each is also for later GPUs of its generation.
const CAPABILITIES: [(i32, i32); 4] = [(8, 0), (9, 0), (10, 0), (12, 0)];
/// What files of xz begin with.
const XZ: &[u8] = &[0xfd, b'7', b'z', b'X', b'Z', 0];
/// The most that a file may have once it is unpacked, bytes.
const LIMIT: u64 = 512 << 20;
/// The part of [`SOURCES`] that all kernels have.
const ANY_SOURCES: &str = "vb-kernel of ";

/// A GPU, as far as kernels are chosen by it.
pub(crate) struct Gpu {
    pub(crate) name: String,
    pub(crate) capability: (i32, i32),
}

impl Gpu {
    /// The capability of the kernels that it runs.
    fn runs(&self) -> Result<(i32, i32), GpuError> {
        let (major, minor) = self.capability;
        let suits = |c: &&(i32, i32)| c.0 == major && c.1 <= minor;
        CAPABILITIES.iter().find(suits).copied().ok_or_else(|| {
            let known: Vec<_> =
                CAPABILITIES.iter().map(|(major, minor)| format!("{major}.{minor}")).collect();
            GpuError::Architecture { name: self.name.clone(), major, minor, known: known.join(", ") }
        })
    }
}

/// The code for a GPU: of this file, or of that for it in this folder.
pub(crate) fn read(place: &Path, gpu: &Gpu) -> Result<Vec<u8>, GpuError> {
    let (major, minor) = gpu.runs()?;
    let path = if place.is_dir() {
        place.join(format!("vb-kernel-sm_{major}{minor}.cubin.xz"))
    } else {
        place.to_owned()
    };
    let unreadable = |source| GpuError::Kernel { path: path.clone(), source };
    let code = unpacked(std::fs::read(&path).map_err(unreadable)?).map_err(unreadable)?;
    if contains(&code, SOURCES) {
        Ok(code)
    } else if contains(&code, ANY_SOURCES) {
        Err(GpuError::OtherSources { path })
    } else {
        Err(unreadable(Error::new(ErrorKind::InvalidData, "it contains no kernels of this simulator")))
    }
}

/// The bytes of a file, which may be packed.
fn unpacked(bytes: Vec<u8>) -> std::io::Result<Vec<u8>> {
    if !bytes.starts_with(XZ) {
        return Ok(bytes);
    }
    let mut code = Vec::new();
    XzReader::new(bytes.as_slice(), false).take(LIMIT + 1).read_to_end(&mut code)?;
    if code.len() as u64 > LIMIT {
        return Err(Error::new(ErrorKind::FileTooLarge, format!("it has more than {LIMIT} bytes")));
    }
    Ok(code)
}

fn contains(bytes: &[u8], text: &str) -> bool {
    bytes.windows(text.len()).any(|part| part == text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gpu(major: i32, minor: i32) -> Gpu {
        Gpu { name: "a GPU".into(), capability: (major, minor) }
    }

    /// A folder with a file of this content for GPUs of capability 9.0.
    fn folder(content: &[u8]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("vb-kernel-sm_90.cubin.xz"), content).unwrap();
        folder
    }

    #[test]
    fn a_gpu_runs_kernels_of_its_generation_that_are_no_later_than_it() {
        // CUDA C++ Programming Guide, "Binary compatibility".
        let runs = |major, minor| gpu(major, minor).runs().ok();
        assert_eq!(runs(8, 0), Some((8, 0)));
        assert_eq!(runs(8, 9), Some((8, 0)));
        assert_eq!(runs(9, 0), Some((9, 0)));
        assert_eq!(runs(12, 1), Some((12, 0)));
        assert_eq!(runs(7, 5), None);
        assert_eq!(runs(11, 0), None);
        let told = gpu(7, 5).runs().unwrap_err().to_string();
        assert!(told.contains("a GPU has 7.5") && told.contains("8.0, 9.0"), "{told}");
    }

    #[test]
    fn kernels_of_other_sources_are_refused() {
        let code = |sources: &str| format!("\x7fELF {sources} and more").into_bytes();
        let own = folder(&code(SOURCES));
        assert_eq!(read(own.path(), &gpu(9, 0)).unwrap(), code(SOURCES));
        let file = own.path().join("vb-kernel-sm_90.cubin.xz");
        assert_eq!(read(&file, &gpu(8, 0)).unwrap(), code(SOURCES), "who names a file means it");

        let other = folder(&code("vb-kernel of 0123456789abcdef\n"));
        let told = read(other.path(), &gpu(9, 0)).unwrap_err().to_string();
        assert!(told.contains("vb-kernel-sm_90") && told.contains("cargo xtask kernel"), "{told}");
        let told = read(folder(b"\x7fELF").path(), &gpu(9, 0)).unwrap_err().to_string();
        assert!(told.contains("no kernels"), "{told}");
        let told = read(own.path(), &gpu(8, 6)).unwrap_err().to_string();
        assert!(told.contains("vb-kernel-sm_80.cubin.xz"), "{told}");
    }

    #[test]
    fn packed_kernels_are_unpacked() {
        use lzma_rust2::{XzOptions, XzWriter};
        use std::io::Write as _;
        let code = [SOURCES.as_bytes(), &[7; 100_000]].concat();
        let mut packed = XzWriter::new(Vec::new(), XzOptions::default()).unwrap();
        packed.write_all(&code).unwrap();
        let packed = packed.finish().unwrap();
        assert!(packed.len() < 1000);
        assert_eq!(read(folder(&packed).path(), &gpu(9, 0)).unwrap(), code);
        let cut = folder(&packed[..packed.len() / 2]);
        assert!(matches!(read(cut.path(), &gpu(9, 0)), Err(GpuError::Kernel { .. })));
    }
}
