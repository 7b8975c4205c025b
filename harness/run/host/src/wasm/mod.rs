//! WASM plugins, run by wasmtime.

mod cache;
pub(crate) mod compile;
mod engine;
mod guest_world;
mod interface;
mod session;
mod state;
mod v1_0;
mod wasi;

use std::path::Path;

use vb_sdk::Task;
use wasi_preview1_component_adapter_provider::{
    WASI_SNAPSHOT_PREVIEW1_ADAPTER_NAME, WASI_SNAPSHOT_PREVIEW1_REACTOR_ADAPTER,
};
use wasmtime::Engine;
use wasmtime::component::types::ComponentItem;
use wasmtime::component::{Component, Linker};

use crate::abi::AbiVersion;
use crate::fault::FaultCause;
use crate::inspect::PluginFile;
use crate::{Limits, LoadError, LogSink};
use vb_files::one_line;

use compile::Refusal;
use interface::Pre;
pub(crate) use session::WasmSession;

/// A compiled and linked plugin, ready to be instantiated.
#[derive(Clone)]
pub(crate) struct WasmPlugin {
    engine: Engine,
    pre: Pre,
}

impl std::fmt::Debug for WasmPlugin {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("WasmPlugin")
    }
}

impl WasmPlugin {
    pub(crate) fn load(
        path: &Path,
        file: &PluginFile,
        sha256: &str,
        limits: &Limits,
        cache_dir: Option<&Path>,
        compiler: Option<&Path>,
    ) -> Result<Self, LoadError> {
        let unloadable = |e: wasmtime::Error| LoadError::Unloadable {
            path: path.into(),
            reason: one_line(&format!("{e:#}")),
        };
        let not_a_plugin = |e: wasmtime::Error| LoadError::NotAPlugin {
            path: path.into(),
            reason: one_line(&format!("{e:#}")),
        };
        let engine = engine::new(limits).map_err(|e| not_the_planners(path, &e))?;
        let cache = cache_dir.map(|dir| cache::entry(dir, &engine, sha256));
        let component = match cache.as_ref().and_then(|entry| entry.load(&engine)) {
            Some(component) => component,
            None => {
                let code = compile::compile(path, file, &engine, limits, compiler)?;
                if let Some(entry) = &cache {
                    entry.store(&code);
                }
                // SAFETY: it comes from this harness's compiler, through memory or a pipe that nobody else has, and
                // not from a file.
                unsafe { Component::deserialize(&engine, &code) }.map_err(|e| not_the_planners(path, &e))?
            }
        };
        if limits.wasm_watchdog {
            engine::watch(&engine).map_err(|e| not_the_planners(path, &e.into()))?;
        }
        let imports = forbidden_imports(&component, &engine, file.abi);
        if !imports.is_empty() {
            return Err(LoadError::ForbiddenImports { path: path.into(), imports });
        }
        let mut linker = Linker::new(&engine);
        session::add_host_functions(&mut linker, file.abi).map_err(unloadable)?;
        wasi::add_to_linker(&mut linker, &component, &engine).map_err(unloadable)?;
        let pre = linker.instantiate_pre(&component).map_err(unloadable)?;
        let pre = Pre::new(pre).map_err(not_a_plugin)?;
        Ok(Self { engine, pre })
    }

    pub(crate) fn start(
        &self,
        task: &Task,
        log: LogSink,
        limits: &Limits,
    ) -> Result<WasmSession, FaultCause> {
        WasmSession::start(&self.engine, &self.pre, task, log, limits)
    }
}

/// What the component wants from outside beyond the planner interface. An instance that holds nothing but types asks
/// for nothing.
fn forbidden_imports(component: &Component, engine: &Engine, abi: AbiVersion) -> Vec<String> {
    let only_types = |item: &ComponentItem| match item {
        ComponentItem::ComponentInstance(instance) => {
            instance.exports(engine).all(|(_, export)| matches!(export.ty, ComponentItem::Type(_)))
        }
        ComponentItem::Type(_) => true,
        _ => false,
    };
    component
        .component_type()
        .imports(engine)
        .filter(|(name, import)| {
            *name != abi.host_interface() && wasi::interface(name).is_none() && !only_types(&import.ty)
        })
        .map(|(name, _)| one_line(name))
        .collect()
}

/// The engine can't be set up: the machine refuses it something.
fn not_the_planners(path: &Path, error: &wasmtime::Error) -> LoadError {
    let message = one_line(&format!("{error:#}"));
    LoadError::Faulty { path: path.into(), cause: FaultCause::Machine { message } }
}

/// A component from a core module that carries its component type in a custom section. A module for `wasm32-wasip1`
/// gets the adapter from that interface to WASI 0.2.
fn componentize(module: &[u8]) -> Result<Vec<u8>, Refusal> {
    wit_component::ComponentEncoder::default()
        .validate(true)
        .module(module)
        .and_then(|encoder| {
            if imports_preview1(module) {
                encoder.adapter(WASI_SNAPSHOT_PREVIEW1_ADAPTER_NAME, WASI_SNAPSHOT_PREVIEW1_REACTOR_ADAPTER)
            } else {
                Ok(encoder)
            }
        })
        .and_then(|mut encoder| encoder.encode())
        .map_err(|e| {
            let imports = foreign_imports(module);
            if !imports.is_empty() {
                return Refusal::ForbiddenImports(imports);
            }
            Refusal::NotAPlugin(one_line(&format!("it cannot be converted to a component: {e:#}")))
        })
}

/// Whether the operating system caused an error of the engine. A planner has no way to: it makes no system calls.
fn is_of_the_system(error: &wasmtime::Error) -> bool {
    crate::system::is_refusal(error.root_cause())
}

/// What a core module imports that no interface can name, e.g. from `env` or what tools for browsers ask for, as
/// `MODULE.NAME`.
fn foreign_imports(module: &[u8]) -> Vec<String> {
    let mut names: Vec<String> = core_imports(module)
        .into_iter()
        .filter(|(module, _)| !module.contains([':', '$']) && *module != WASI_SNAPSHOT_PREVIEW1_ADAPTER_NAME)
        .map(|(module, name)| one_line(&format!("{module}.{name}")))
        .collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// Whether a core module imports anything of WASI's first preview.
fn imports_preview1(module: &[u8]) -> bool {
    core_imports(module).iter().any(|(module, _)| *module == WASI_SNAPSHOT_PREVIEW1_ADAPTER_NAME)
}

/// What a core module imports: a module and a name in it. What is no module is told by the encoder.
fn core_imports(module: &[u8]) -> Vec<(&str, &str)> {
    use wasmparser::{Parser, Payload};
    let sections = Parser::new(0).parse_all(module).filter_map(|payload| match payload {
        Ok(Payload::ImportSection(section)) => Some(section),
        _ => None,
    });
    sections
        .flat_map(|section| section.into_imports().flatten().map(|import| (import.module, import.name)))
        .collect()
}
