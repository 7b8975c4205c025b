//! `imports`: the plugin asks for nothing that planners don't get. Those that do aren't loaded at all, so this check
//! shows what is asked for.

use vb_host::{Plugin, PluginKind, SandboxReport};

use super::Kit;
use super::report::Check;

const NAME: &str = "imports";

pub(super) fn check(kit: &Kit<'_>, plugin: &Plugin) -> Check {
    match (plugin.kind(), kit.file) {
        (PluginKind::Wasm, Some(file)) => match vb_host::imports(file) {
            Ok(imports) if imports.is_empty() => Check::pass(NAME, "none"),
            Ok(imports) => Check::pass(NAME, imports.join(", ")),
            // It has been loaded a moment ago.
            Err(e) => Check::fail(NAME, e.to_string(), "do not change the file during the check"),
        },
        (PluginKind::Native, _) => {
            let missing = plugin.sandbox().map(SandboxReport::missing).unwrap_or_default();
            if missing.is_empty() {
                Check::pass(NAME, "a sandboxed process: denied at run time")
            } else {
                let detail = format!("this system cannot sandbox it with {}", missing.join(", "));
                Check::warn(NAME, detail, "check it on another system")
            }
        }
        _ => Check::skip(NAME, "a planner of this kind has all permissions of its user"),
    }
}
