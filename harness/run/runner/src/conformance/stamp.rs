//! `stamp`: what the plugin says of itself, readable without running it, is of use to the harness and its users.

use vb_files::one_line;
use vb_host::{AbiVersion, Metadata, Plugin};
use vb_sdk::metadata::is_name;

use super::report::Check;

const NAME: &str = "stamp";

pub(super) fn check(plugin: &Plugin) -> Check {
    judge(plugin.metadata(), plugin.abi())
}

fn judge(m: &Metadata, abi: AbiVersion) -> Check {
    let who = format!("{} {}, ABI {abi}", one_line(&m.name), one_line(&m.version));
    if let Some(fault) = fault(m) {
        return Check::fail(
            NAME,
            format!("{who}: {fault}"),
            "correct it in export_planner!, or in planner.yaml",
        );
    }
    let lacks = lacks(m);
    if !lacks.is_empty() {
        let detail = format!("{who}: it lacks {}", lacks.join(", "));
        return Check::warn(NAME, detail, "users and results show these texts");
    }
    Check::pass(NAME, who)
}

/// What harness or users can't work with.
fn fault(m: &Metadata) -> Option<String> {
    if !is_name(&m.name) {
        return Some("its name may contain only a-z, 0-9, - and _".into());
    }
    if m.version.trim().is_empty() {
        return Some("it has no version, which identifies results".into());
    }
    let unfit = |c: char| c.is_control() || c.is_whitespace() || c == '=';
    if let Some(p) = m.params.iter().find(|p| p.key.is_empty() || p.key.contains(unfit)) {
        return Some(format!("the parameter `{}` can't be set by --param", one_line(&p.key)));
    }
    let twice = |(i, p): (usize, &vb_host::ParamSpec)| m.params[..i].iter().any(|q| q.key == p.key);
    m.params
        .iter()
        .enumerate()
        .find(|(i, p)| twice((*i, p)))
        .map(|(_, p)| format!("the parameter `{}` is declared twice", one_line(&p.key)))
}

fn lacks(m: &Metadata) -> Vec<String> {
    let mut lacks = Vec::new();
    if m.about.trim().is_empty() {
        lacks.push("a one-sentence description (about)".to_owned());
    }
    if m.authors.is_empty() {
        lacks.push("authors".to_owned());
    }
    let silent = m.params.iter().filter(|p| p.help.trim().is_empty());
    lacks.extend(silent.map(|p| format!("help for the parameter {}", one_line(&p.key))));
    lacks
}

#[cfg(test)]
mod tests {
    use super::super::report::Verdict;
    use super::*;
    use vb_host::ParamSpec;

    fn sound() -> Metadata {
        let param = |key: &str| ParamSpec { key: key.into(), default: "1".into(), help: "m/s".into() };
        Metadata {
            abi: "1.0".into(),
            name: "fox".into(),
            version: "1.0.0".into(),
            authors: vec!["A".into()],
            about: "Drives".into(),
            control_period: 0.1,
            params: vec![param("speed"), param("ahead")],
            needs: Vec::new(),
            needs_without_maps: Vec::new(),
            models: Vec::new(),
        }
    }

    fn verdict(change: impl Fn(&mut Metadata)) -> (Verdict, String) {
        let mut m = sound();
        change(&mut m);
        let check = judge(&m, AbiVersion::NEWEST);
        (check.verdict, check.detail)
    }

    #[test]
    fn metadata_that_nobody_can_use_fail_and_sparse_ones_warn() {
        assert_eq!(verdict(|_| {}), (Verdict::Pass, "fox 1.0.0, ABI 1.0".into()));
        for broken in [
            (|m| m.name = "The Fox".into()) as fn(&mut Metadata),
            |m| m.version = " ".into(),
            |m| m.params[1].key = "a=b".into(),
            |m| m.params[1].key = "speed".into(),
        ] {
            assert_eq!(verdict(broken).0, Verdict::Fail);
        }
        for (sparse, word) in [
            ((|m| m.about.clear()) as fn(&mut Metadata), "about"),
            (|m| m.authors.clear(), "authors"),
            (|m| m.params[1].help.clear(), "parameter ahead"),
        ] {
            let (found, detail) = verdict(sparse);
            assert!(found == Verdict::Warn && detail.contains(word), "{detail}");
        }
    }
}
