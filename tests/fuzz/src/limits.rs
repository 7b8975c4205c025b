//! The limits that users give to planners by `--limits`.

use vb_host::Limits;

/// Reads a file as the harness does. Limits that are accepted can be written down and read again.
pub(crate) fn run(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let Ok(limits) = vb_files::yaml::parse::<Limits>(text) else { return };
    if limits.validate().is_ok() {
        assert_eq!(vb_files::yaml::parse::<Limits>(&written(&limits)).as_ref(), Ok(&limits));
    }
}

fn written(limits: &Limits) -> String {
    let line = |(name, value): (&str, u64)| match name {
        "wasm_watchdog" => format!("{name}: {}\n", value == 1),
        _ => format!("{name}: {value}\n"),
    };
    limits.named().into_iter().map(line).collect()
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let all = Limits { wasm_watchdog: true, ..Limits::default() };
    vec![
        written(&all).into_bytes(),
        b"# Half of the memory\nmemory_bytes: 134217728\nfuel_per_step: 500_000_000\n".to_vec(),
        b"{stack_bytes: 0x100000, watchdog_ms: 1000, wasm_watchdog: true}".to_vec(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A seed that is refused at the door tests nothing behind it.
    #[test]
    fn the_seeds_are_limits_that_can_be_kept() {
        for seed in seeds() {
            let text = String::from_utf8(seed).expect("text");
            let limits: Limits = vb_files::yaml::parse(&text).expect("limits");
            limits.validate().expect("limits that can be kept");
            assert_ne!(limits, Limits::default());
        }
    }
}
