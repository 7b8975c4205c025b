//! `vb-harness plugin stamp`: writes the metadata of a planner into its WASM file.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args};
use vb_files::NewFile;
use vb_sdk::metadata::WASM_SECTION;
use wasm_encoder::{CustomSection, Section as _};
use wasmparser::{BinaryReader, Parser, Payload};

use super::meta;
use crate::error::CliError;
use crate::output;

#[derive(Debug, Args)]
#[command(group(ArgGroup::new("place").required(true)))]
pub(crate) struct StampArgs {
    /// Planner: a WASM component, or a core module built with wit-bindgen
    #[arg(value_name = "FILE")]
    pub(crate) file: PathBuf,
    /// Metadata as YAML: name, version, authors, about, control_period, params, needs, needs_without_maps, models
    #[arg(long, value_name = "FILE")]
    pub(crate) meta: PathBuf,
    /// Output file
    #[arg(short, long, value_name = "FILE", group = "place")]
    pub(crate) out: Option<PathBuf>,
    /// Change FILE itself
    #[arg(long, group = "place")]
    pub(crate) in_place: bool,
}

/// Bytes of the header of a module or component: magic number and version.
const HEADER: usize = 8;
/// The id of a custom section, in modules and components.
const CUSTOM: u8 = 0;

/// Adds the section, or replaces the one that an earlier call added.
pub(crate) fn stamp(args: &StampArgs) -> Result<(), CliError> {
    let metadata = meta::read(&args.meta)?;
    let file = &args.file;
    let input = |problem: String| CliError::input(format!("{}: {problem}", file.display()));
    let bytes =
        vb_files::read(file, vb_files::DATA).map_err(|e| input(format!("can't read the plugin: {e}")))?;
    let stamped = with_section(&bytes, metadata.to_text().as_bytes()).map_err(input)?;
    // Else in place: clap demands one of both.
    let out = args.out.as_deref().unwrap_or(file);
    replace(out, &stamped)?;
    output::say(&format!(
        "{}: {} {}, planner ABI {}",
        out.display(),
        metadata.name,
        metadata.version,
        metadata.abi
    ));
    Ok(())
}

/// The module or component with this text as its metadata.
fn with_section(bytes: &[u8], text: &[u8]) -> Result<Vec<u8>, String> {
    let header = bytes.get(..HEADER).filter(|h| h.starts_with(b"\0asm"));
    let header = header.ok_or("it is not WebAssembly; only WASM planners are stamped")?;
    let damaged = |e: wasmparser::BinaryReaderError| format!("the plugin is truncated or damaged: {e}");
    let mut out = header.to_vec();
    let mut rest = BinaryReader::new(&bytes[HEADER..], HEADER);
    while !rest.eof() {
        let start = rest.original_position();
        let id = rest.read_u8().map_err(damaged)?;
        let size = rest.read_var_u32().map_err(damaged)?;
        let content = rest.read_bytes(size as usize).map_err(damaged)?;
        let is_ours = id == CUSTOM
            && BinaryReader::new(content, 0).read_string().is_ok_and(|name| name == WASM_SECTION);
        if !is_ours {
            out.extend_from_slice(&bytes[start..rest.original_position()]);
        }
    }
    for payload in Parser::new(0).parse_all(&out) {
        if let Payload::CustomSection(section) = payload.map_err(damaged)?
            && section.name() == WASM_SECTION
        {
            return Err("a module inside it already contains metadata from vb_sdk::export_planner!; \
                        change it there"
                .into());
        }
    }
    CustomSection { name: WASM_SECTION.into(), data: text.into() }.append_to(&mut out);
    Ok(out)
}

/// Writes a file at once, after the harness has read its metadata as it does before a run.
fn replace(out: &Path, bytes: &[u8]) -> Result<(), CliError> {
    let failed =
        |e: std::io::Error| CliError::output(format!("{}: can't write the plugin: {e}", out.display()));
    let mut new = NewFile::at(out).map_err(failed)?;
    new.as_file_mut().write_all(bytes).map_err(failed)?;
    vb_host::inspect(new.path()).map_err(|e| {
        let message = e.to_string();
        let reason = message.strip_prefix(&format!("{}: ", new.path().display())).unwrap_or(&message);
        CliError::input(format!("{}: {reason}", out.display()))
    })?;
    new.finish().map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_sdk::metadata::Metadata;

    const META: &str = "name: a\nversion: '1'\ncontrol_period: 0.1\n";
    const MODULE: &[u8] = b"\0asm\x01\0\0\0";
    const COMPONENT: &[u8] = b"\0asm\x0d\0\x01\0";

    fn section(name: &str, data: &[u8]) -> Vec<u8> {
        let mut out = Vec::new();
        CustomSection { name: name.into(), data: data.into() }.append_to(&mut out);
        out
    }

    /// A core module inside a component: section 1.
    fn nested(module: &[u8]) -> Vec<u8> {
        let mut out = COMPONENT.to_vec();
        out.extend([1, u8::try_from(module.len()).unwrap()]);
        out.extend(module);
        out
    }

    #[test]
    fn a_section_is_added_at_the_end_and_an_older_one_replaced() {
        let other = section("producers", b"x");
        for start in [MODULE, COMPONENT] {
            let file = [start, &other].concat();
            let once = with_section(&file, b"one").unwrap();
            assert_eq!(once, [&file[..], &section(WASM_SECTION, b"one")].concat());
            let twice = with_section(&[&once[..], &other].concat(), b"two").unwrap();
            assert_eq!(twice, [&file[..], &other, &section(WASM_SECTION, b"two")].concat());
        }
    }

    #[test]
    fn metadata_inside_a_component_are_left_to_who_wrote_them() {
        let plain = nested(MODULE);
        assert!(with_section(&plain, b"x").unwrap().starts_with(&plain));
        let macro_made = nested(&[MODULE, &section(WASM_SECTION, b"x")].concat());
        assert!(with_section(&macro_made, b"x").unwrap_err().contains("export_planner!"));
    }

    #[test]
    fn what_is_no_webassembly_or_damaged_is_refused() {
        assert!(with_section(b"", b"x").unwrap_err().contains("not WebAssembly"));
        assert!(with_section(b"\x7fELF....", b"x").unwrap_err().contains("not WebAssembly"));
        let cut = [MODULE, &section("producers", b"12345")[..4]].concat();
        assert!(with_section(&cut, b"x").unwrap_err().contains("damaged"));
    }

    fn stamped(file: &[u8], meta: &str) -> (Result<(), String>, Vec<u8>) {
        let dir = tempfile::tempdir().unwrap();
        let path = |name: &str| dir.path().join(name);
        std::fs::write(path("p.wasm"), file).unwrap();
        std::fs::write(path("meta.yaml"), meta).unwrap();
        let args = StampArgs { file: path("p.wasm"), meta: path("meta.yaml"), out: None, in_place: true };
        let result = stamp(&args).map_err(|e| e.to_string());
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 2, "nothing else is left in the folder");
        (result, std::fs::read(path("p.wasm")).unwrap())
    }

    #[test]
    fn a_stamped_file_is_one_that_the_harness_reads_and_any_other_stays_as_it_was() {
        let (result, file) = stamped(COMPONENT, META);
        result.unwrap();
        let text = file.strip_prefix(COMPONENT).unwrap();
        let at = text.windows(5).position(|w| w == b"abi: ").unwrap();
        assert_eq!(Metadata::parse(&text[at..]).unwrap().name, "a");
        // A core module without the interface is no planner, whatever it is stamped with.
        let (result, file) = stamped(MODULE, META);
        assert!(result.unwrap_err().contains("p.wasm: not a planner plugin"));
        assert_eq!(file, MODULE);
        let (result, file) = stamped(COMPONENT, "name: A B\n");
        assert!(result.unwrap_err().contains("meta.yaml: "));
        assert_eq!(file, COMPONENT);
    }
}
