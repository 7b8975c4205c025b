//! The metadata of a plugin file, read without running it.

use std::io::Read as _;
use std::path::Path;

use object::{Architecture, Object as _, ObjectSection as _};
use vb_sdk::metadata::{ELF_SECTION, MACHO_SECTION, Metadata, WASM_SECTION};
use wasmparser::{BinaryReaderError, Encoding, Parser, Payload};

use crate::abi::{self, AbiVersion};
use crate::{Limits, LoadError, hint};
use vb_files::{one_line, printable};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Component,
    /// A core module that carries its component type, as the Rust compiler leaves it.
    CoreModule,
    Native,
}

/// A plugin file that has been read and recognised.
#[derive(Debug)]
pub(crate) struct PluginFile {
    pub(crate) bytes: Vec<u8>,
    pub(crate) format: Format,
    pub(crate) abi: AbiVersion,
    pub(crate) metadata: Metadata,
}

/// Reads a plugin's metadata. Nothing of the plugin is run or compiled.
///
/// # Errors
/// Returns an error if the file can't be read, is not a plugin, or speaks another version of the planner interface.
pub fn inspect(path: &Path) -> Result<Metadata, LoadError> {
    read(path, Limits::default().module_bytes).map(|file| file.metadata)
}

/// The names of what a WASM plugin imports, in their order: the interfaces of a component, or the modules of a core
/// module. The list is empty for a native library. Nothing of the plugin is run or compiled.
pub fn imports(path: &Path) -> Result<Vec<String>, LoadError> {
    let file = read(path, Limits::default().module_bytes)?;
    let mut names: Vec<String> = Vec::new();
    if file.format == Format::Native {
        return Ok(names);
    }
    let damaged = |e: BinaryReaderError| LoadError::Damaged { path: path.into(), reason: e.to_string() };
    let mut keep = |name: &str| {
        // What a core module exports for a component to be made of it has helpers that it imports.
        let name = one_line(name);
        if !name.starts_with("[export]") && !names.contains(&name) {
            names.push(name);
        }
    };
    let mut depth = 0u32;
    for payload in Parser::new(0).parse_all(&file.bytes) {
        match payload.map_err(damaged)? {
            Payload::Version { .. } => depth += 1,
            Payload::End(_) => depth -= 1,
            Payload::ComponentImportSection(section) if depth == 1 => {
                for import in section {
                    keep(import.map_err(damaged)?.name.name);
                }
            }
            Payload::ImportSection(section) if depth == 1 => {
                for import in section.into_imports() {
                    keep(import.map_err(damaged)?.module);
                }
            }
            _ => {}
        }
    }
    Ok(names)
}

/// Reads and recognises a plugin file of at most so many bytes.
pub(crate) fn read(path: &Path, limit: u64) -> Result<PluginFile, LoadError> {
    let io = |source: std::io::Error| match source.kind() {
        std::io::ErrorKind::NotFound => LoadError::NotFound { path: path.into() },
        _ => LoadError::Io { path: path.into(), source },
    };
    // Opening a pipe would wait for somebody to write into it.
    let kind = std::fs::metadata(path).map_err(io)?.file_type();
    if !kind.is_file() && !kind.is_dir() {
        return Err(io(std::io::Error::other("it is not a regular file")));
    }
    let file = std::fs::File::open(path).map_err(io)?;
    let found = file.metadata().map_err(io)?.len();
    let mut bytes = Vec::new();
    // The file may grow while it is read.
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > limit {
        let found = found.max(bytes.len() as u64);
        return Err(LoadError::TooLarge { path: path.into(), what: "bytes", found, limit });
    }
    let (format, text) = match bytes.get(..4) {
        _ if bytes.is_empty() => return Err(LoadError::Empty { path: path.into() }),
        Some(b"\0asm") => wasm_section(path, &bytes)?,
        Some(b"\x7fELF" | b"\xcf\xfa\xed\xfe") => (Format::Native, native_section(path, &bytes)?),
        _ => {
            let hint =
                hint::of_another_kind(path, &bytes).map_or_else(String::new, |hint| format!("; {hint}"));
            let reason = format!("it is neither WebAssembly nor a native library{hint}");
            return Err(LoadError::NotAPlugin { path: path.into(), reason });
        }
    };
    let text = text.ok_or_else(|| LoadError::NotAPlugin {
        path: path.into(),
        reason: format!("it contains no planner metadata; {}", hint::no_metadata(format == Format::Native)),
    })?;
    let too_large = |what, found, limit| LoadError::TooLarge { path: path.into(), what, found, limit };
    if text.len() as u64 > MAX_METADATA {
        return Err(too_large("bytes of metadata", text.len() as u64, MAX_METADATA));
    }
    // The version decides how the rest is to be read.
    let outside = |found: &str| {
        // Blanks at an end would not be seen.
        let quoted = if found.trim() == found { found.to_owned() } else { format!("\"{found}\"") };
        LoadError::AbiVersion { path: path.into(), found: one_line(&quoted) }
    };
    if let Some(found) = abi::stamp(&text).filter(|found| AbiVersion::find(found).is_none()) {
        return Err(outside(found));
    }
    let mut metadata =
        Metadata::parse(&text).map_err(|source| LoadError::Metadata { path: path.into(), source })?;
    for (what, text) in
        [("bytes of its name", &mut metadata.name), ("bytes of its version", &mut metadata.version)]
    {
        if text.len() as u64 > MAX_NAME {
            return Err(too_large(what, text.len() as u64, MAX_NAME));
        }
        // They stand in files, on pages and boards, and in names of folders.
        *text = printable(text);
    }
    let abi = AbiVersion::find(&metadata.abi).ok_or_else(|| outside(&metadata.abi))?;
    Ok(PluginFile { bytes, format, abi, metadata })
}

/// The most bytes of a plugin's metadata; that of the planners that come with the harness has some thousand.
const MAX_METADATA: u64 = 64 << 10;
/// The most bytes of a planner's name, of which folders are named, and of its version.
const MAX_NAME: u64 = 100;
/// Levels of components in components: toolchains make two or three, and the engine walks them recursively.
const MAX_DEPTH: u64 = 16;
/// Modules and components in a plugin: those of interpreted languages have dozens.
const MAX_NESTED: u64 = 1000;

type Found = (Format, Option<Vec<u8>>);

fn wasm_section(path: &Path, bytes: &[u8]) -> Result<Found, LoadError> {
    let (mut text, mut outermost, mut has_type) = (None, None, false);
    let (mut depth, mut nested) = (0u64, 0u64);
    let too_large = |what, found, limit| LoadError::TooLarge { path: path.into(), what, found, limit };
    // The walk goes into the modules nested in a component.
    for payload in Parser::new(0).parse_all(bytes) {
        match payload.map_err(|e| LoadError::Damaged { path: path.into(), reason: e.to_string() })? {
            Payload::Version { encoding, .. } => {
                outermost = outermost.or(Some(encoding));
                (depth, nested) = (depth + 1, nested + 1);
                if depth > MAX_DEPTH {
                    return Err(too_large("levels of nested components", depth, MAX_DEPTH));
                }
                if nested > MAX_NESTED {
                    return Err(too_large("modules and components inside", nested, MAX_NESTED));
                }
            }
            Payload::End(_) => depth = depth.saturating_sub(1),
            Payload::CustomSection(s) if s.name() == WASM_SECTION => text = Some(s.data().to_vec()),
            Payload::CustomSection(s) => has_type |= s.name().starts_with("component-type"),
            _ => {}
        }
    }
    match outermost {
        Some(Encoding::Component) => Ok((Format::Component, text)),
        _ if has_type => Ok((Format::CoreModule, text)),
        _ => {
            let reason = "it is a core WebAssembly module without the planner interface; export a planner with \
                          vb_sdk::export_planner!, or convert it to a component";
            Err(LoadError::NotAPlugin { path: path.into(), reason: reason.into() })
        }
    }
}

fn native_section(path: &Path, bytes: &[u8]) -> Result<Option<Vec<u8>>, LoadError> {
    let damaged = |e: object::Error| LoadError::Damaged { path: path.into(), reason: e.to_string() };
    let file = object::File::parse(bytes).map_err(damaged)?;
    let here = match std::env::consts::ARCH {
        "x86_64" => Some(Architecture::X86_64),
        "aarch64" => Some(Architecture::Aarch64),
        _ => None,
    };
    // The system's own message for this is that there is no such file.
    if here.is_some_and(|arch| arch != file.architecture()) {
        let reason =
            format!("it was built for {:?}, this machine is {}", file.architecture(), std::env::consts::ARCH);
        return Err(LoadError::Unloadable { path: path.into(), reason });
    }
    let section = file.section_by_name(ELF_SECTION).or_else(|| file.section_by_name(MACHO_SECTION));
    // Text from C ends with a 0, and linkers pad sections.
    let text = |data: &[u8]| data[..data.iter().rposition(|b| *b != 0).map_or(0, |i| i + 1)].to_vec();
    section.map(|s| s.data().map(text).map_err(damaged)).transpose()
}
