//! The metadata of plugins, which are read before anything of a plugin is compiled or run.

use std::path::Path;

use vb_sdk::metadata::Metadata;

use crate::site::{Site, select};

/// What the section of a planner says.
const METADATA: &str = "abi: 1.0\nname: seed\nversion: 1.2.3\nauthors: A. Author <a@example.org>:B. Author\nabout: A \
                        seed\\nwith two lines\ncontrol-period: 0.1\nparam: speed\ndefault: 3.0\nhelp: target speed\n";

pub(crate) fn run(data: &[u8]) {
    thread_local!(static SITE: Site = Site::new());
    let Some((&kind, content)) = data.split_first() else { return };
    if kind % 2 == 0 {
        let _ = Metadata::parse(content);
    } else {
        SITE.with(|site| {
            site.write(Path::new("plugin"), content);
            let _ = vb_host::inspect(&site.path().join("plugin"));
        });
    }
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let section = custom_section("vb:planner", METADATA.as_bytes());
    let core = [&b"\0asm\x01\0\0\0"[..], &section, &custom_section("component-type:x", b"")].concat();
    let component = [&b"\0asm\x0d\0\x01\0"[..], &section].concat();
    vec![
        select(0, METADATA.as_bytes()),
        select(1, &core),
        select(1, &component),
        select(1, &elf(METADATA.as_bytes())),
    ]
}

/// A custom section of a WebAssembly binary, shorter than 16 KiB (core specification, §5.5.3).
fn custom_section(name: &str, content: &[u8]) -> Vec<u8> {
    let leb = |n: usize| [0x80 | (n & 0x7f) as u8, (n >> 7) as u8];
    let mut body = leb(name.len()).to_vec();
    body.extend(name.as_bytes());
    body.extend(content);
    [&[0][..], &leb(body.len()), &body].concat()
}

/// A 64-bit ELF library that holds nothing but the metadata (System V ABI, chapter 4).
fn elf(metadata: &[u8]) -> Vec<u8> {
    const HEADER: usize = 64;
    const SECTION: usize = 64;
    let names = b"\0.vb.planner\0.shstrtab\0";
    let machine: u16 = if cfg!(target_arch = "aarch64") { 183 } else { 62 };
    let mut bytes = b"\x7fELF\x02\x01\x01\0\0\0\0\0\0\0\0\0".to_vec();
    bytes.extend(3u16.to_le_bytes());
    bytes.extend(machine.to_le_bytes());
    bytes.extend(1u32.to_le_bytes());
    bytes.extend([0; 16]);
    bytes.extend((HEADER as u64).to_le_bytes());
    bytes.extend([0; 4]);
    for n in [HEADER, 0, 0, SECTION, 3, 2] {
        bytes.extend((n as u16).to_le_bytes());
    }
    let data = HEADER + 3 * SECTION;
    let section = |name: u32, kind: u32, offset: usize, size: usize| {
        let mut s = [name.to_le_bytes(), kind.to_le_bytes()].concat();
        for n in [0, 0, offset as u64, size as u64, 0, 1, 0] {
            s.extend(n.to_le_bytes());
        }
        s.resize(SECTION, 0);
        s
    };
    bytes.extend(section(0, 0, 0, 0));
    bytes.extend(section(1, 1, data, metadata.len()));
    bytes.extend(section(13, 3, data + metadata.len(), names.len()));
    bytes.extend(metadata);
    bytes.extend(names);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A seed that is refused at the door tests nothing behind it.
    #[test]
    fn the_seeds_are_plugins_whose_metadata_are_read() {
        let site = Site::new();
        for seed in &seeds()[1..] {
            site.write(Path::new("plugin"), &seed[1..]);
            let metadata = vb_host::inspect(&site.path().join("plugin")).expect("metadata");
            assert_eq!((metadata.name.as_str(), metadata.params.len()), ("seed", 1));
        }
    }
}
