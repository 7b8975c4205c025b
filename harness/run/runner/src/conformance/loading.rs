//! `loads`: the harness can make planners of the file.

use vb_host::{Blame, FaultCode, LoadError, Plugin, PluginKind};

use super::KitError;
use super::report::Check;

const NAME: &str = "loads";
/// What can't be told of a plugin that doesn't load, in the order of the checks.
const REST: [&str; 8] =
    ["stamp", "imports", "tasks", "determinism", "hygiene", "budget", "probes", "start-up"];

pub(super) fn loaded(plugin: &Plugin) -> Check {
    let kind = match plugin.kind() {
        PluginKind::Wasm => "as WebAssembly",
        PluginKind::Native => "as a native library",
        PluginKind::Command => {
            return Check::warn(
                NAME,
                "as a command, which is not sandboxed",
                "results of commands are not eligible for ranking; build for WASM for that",
            );
        }
        PluginKind::Recording => "as the recorded commands of a run",
        PluginKind::Ros => {
            return Check::warn(
                NAME,
                "as a ROS 2 node, which is not sandboxed",
                "results of ROS 2 nodes are not eligible for ranking; build for WASM for that",
            );
        }
    };
    Check::pass(NAME, kind)
}

/// The checks of a plugin that can't be loaded: the one that it breaks fails, the others can't be told.
pub(super) fn refused(error: LoadError) -> Result<Vec<Check>, KitError> {
    let code = error.code();
    if code.blame() != Blame::Planner || matches!(code, FaultCode::NotFound | FaultCode::Unreadable) {
        return Err(KitError::Load(error));
    }
    let broken = match code {
        FaultCode::AbiMismatch | FaultCode::Metadata => "stamp",
        FaultCode::ImportDenied => "imports",
        _ => NAME,
    };
    let check = |name: &'static str| {
        if name == broken {
            Check::fail(name, format!("{error} ({code})"), "see docs/abi.md for the plugin format")
        } else {
            Check::skip(name, "the plugin can't be loaded")
        }
    };
    Ok([NAME].into_iter().chain(REST).map(check).collect())
}

/// The checks of a plugin that was loaded once, but not a second time, from the tasks on.
pub(super) fn not_again(error: LoadError) -> Result<Vec<Check>, KitError> {
    if error.code().blame() != Blame::Planner {
        return Err(KitError::Load(error));
    }
    let check = |name: &'static str| {
        if name == "determinism" {
            let detail = format!("the first load succeeded, the second failed: {error} ({})", error.code());
            Check::fail(name, detail, "loading must depend only on the file")
        } else {
            Check::skip(name, "the plugin can't be loaded again")
        }
    };
    Ok(REST.into_iter().skip_while(|name| *name != "tasks").map(check).collect())
}

#[cfg(test)]
mod tests {
    use super::super::report::Verdict;
    use super::*;

    fn failing(error: LoadError) -> Vec<&'static str> {
        let checks = refused(error).unwrap();
        assert_eq!(checks.len(), 9);
        checks.into_iter().filter(|c| c.verdict == Verdict::Fail).map(|c| c.name).collect()
    }

    #[test]
    fn a_refusal_fails_the_check_that_it_is_about_and_no_other() {
        let path = || "x.wasm".into();
        assert_eq!(failing(LoadError::Empty { path: path() }), ["loads"]);
        assert_eq!(failing(LoadError::AbiVersion { path: path(), found: "0.9".into() }), ["stamp"]);
        let imports = vec!["wasi:http/outgoing-handler@0.2.0".to_owned()];
        assert_eq!(failing(LoadError::ForbiddenImports { path: path(), imports }), ["imports"]);
    }

    #[test]
    fn a_plugin_that_loads_by_chance_is_not_deterministic() {
        let checks = not_again(LoadError::Empty { path: "x.so".into() }).unwrap();
        let named = checks.iter().map(|c| (c.name, c.verdict)).collect::<Vec<_>>();
        assert_eq!(named[..2], [("tasks", Verdict::Skip), ("determinism", Verdict::Fail)]);
        assert!(named.len() == 6 && named[2..].iter().all(|(_, verdict)| *verdict == Verdict::Skip));
    }

    #[test]
    fn a_plugin_that_isnt_there_is_no_planner_that_fails() {
        assert!(matches!(refused(LoadError::NotFound { path: "x".into() }), Err(KitError::Load(_))));
        let cause = vb_host::FaultCause::Machine { message: "no memory".into() };
        assert!(matches!(refused(LoadError::Faulty { path: "x".into(), cause }), Err(KitError::Load(_))));
    }
}
