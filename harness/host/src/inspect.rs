//! What a plugin file says of itself, read without running it.

use std::path::Path;

use object::{Architecture, Object as _, ObjectSection as _};
use vb_sdk::ABI_VERSION;
use vb_sdk::metadata::{ELF_SECTION, MACHO_SECTION, Metadata, WASM_SECTION};
use wasmparser::{Encoding, Parser, Payload};

use crate::LoadError;

/// What a plugin is made of.
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
    pub(crate) metadata: Metadata,
}

/// Reads a plugin's metadata. Nothing of the plugin is run or compiled.
///
/// # Errors
/// If the file can't be read, is no plugin, or speaks another version of the planner interface.
pub fn inspect(path: &Path) -> Result<Metadata, LoadError> {
    read(path).map(|file| file.metadata)
}

pub(crate) fn read(path: &Path) -> Result<PluginFile, LoadError> {
    let bytes = std::fs::read(path).map_err(|source| match source.kind() {
        std::io::ErrorKind::NotFound => LoadError::NotFound { path: path.into() },
        _ => LoadError::Io { path: path.into(), source },
    })?;
    let (format, text) = match bytes.get(..4) {
        _ if bytes.is_empty() => return Err(LoadError::Empty { path: path.into() }),
        Some(b"\0asm") => wasm_section(path, &bytes)?,
        Some(b"\x7fELF" | b"\xcf\xfa\xed\xfe") => (Format::Native, native_section(path, &bytes)?),
        _ => {
            let reason = "it is neither WebAssembly nor a native library".to_owned();
            return Err(LoadError::NotAPlugin { path: path.into(), reason });
        }
    };
    let text = text.ok_or_else(|| LoadError::NotAPlugin {
        path: path.into(),
        reason: "it carries no planner metadata; planners are exported by vb_sdk::export_planner!".into(),
    })?;
    let metadata =
        Metadata::parse(&text).map_err(|source| LoadError::Metadata { path: path.into(), source })?;
    if metadata.abi != ABI_VERSION {
        return Err(LoadError::AbiVersion { path: path.into(), found: metadata.abi, supported: ABI_VERSION });
    }
    Ok(PluginFile { bytes, format, metadata })
}

type Found = (Format, Option<Vec<u8>>);

fn wasm_section(path: &Path, bytes: &[u8]) -> Result<Found, LoadError> {
    let (mut text, mut outermost, mut has_type) = (None, None, false);
    // The walk goes into the modules nested in a component.
    for payload in Parser::new(0).parse_all(bytes) {
        match payload.map_err(|e| LoadError::Damaged { path: path.into(), reason: e.to_string() })? {
            Payload::Version { encoding, .. } => outermost = outermost.or(Some(encoding)),
            Payload::CustomSection(s) if s.name() == WASM_SECTION => text = Some(s.data().to_vec()),
            Payload::CustomSection(s) => has_type |= s.name().starts_with("component-type"),
            _ => {}
        }
    }
    match outermost {
        Some(Encoding::Component) => Ok((Format::Component, text)),
        _ if has_type => Ok((Format::CoreModule, text)),
        _ => {
            let reason = "it is a core WebAssembly module without the planner interface; export a planner by \
                          vb_sdk::export_planner!, or turn it into a component";
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
    section.map(|s| s.data().map(<[u8]>::to_vec).map_err(damaged)).transpose()
}
