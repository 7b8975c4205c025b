//! Plugins that were built for a released version of the planner interface run for ever, and as they did then.

#![allow(clippy::unwrap_used, reason = "a helper of a test may fail it")]

mod transcript;

use std::path::{Path, PathBuf};

use transcript::Transcript;
use vb_host::{AbiVersion, Limits, Plugin, inspect};

/// The golden plugins of a version with their transcripts.
fn golden(version: AbiVersion) -> Vec<(PathBuf, Transcript)> {
    let folder =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/golden").join(format!("abi-{version}"));
    let files = std::fs::read_dir(folder).unwrap().map(|f| f.unwrap().path());
    let mut plugins: Vec<PathBuf> = files.filter(|f| f.extension().is_some_and(|e| e == "wasm")).collect();
    plugins.sort();
    let transcript = |file: &PathBuf| {
        let text = std::fs::read_to_string(file.with_extension("json")).unwrap();
        serde_json::from_str::<Transcript>(&text).unwrap()
    };
    plugins.iter().map(|file| (file.clone(), transcript(file))).collect()
}

/// Expected values: the commands that the planners gave when the version was current (tests/golden/README.md).
#[test]
fn a_golden_plugin_answers_what_it_answered_when_its_version_was_new_bit_for_bit() {
    for version in AbiVersion::SUPPORTED {
        for (file, transcript) in golden(*version) {
            assert_eq!(transcript.abi, version.name());
            assert_eq!(inspect(&file).unwrap().abi, version.name(), "{}", file.display());
            let plugin = Plugin::load(&file, &Limits::default(), None).unwrap();
            assert_eq!(plugin.abi(), *version);
            let recorded: Vec<_> = transcript.steps.iter().map(|s| s.answers.clone()).collect();
            assert_eq!(transcript.replay(&plugin), recorded, "{}", file.display());
        }
    }
}

/// A transcript in which nothing happens would prove nothing.
#[test]
fn the_transcripts_steer_both_ways_and_brake() {
    let number = |bits: &str| f64::from_bits(u64::from_str_radix(bits, 16).unwrap());
    for version in AbiVersion::SUPPORTED {
        for (file, transcript) in golden(*version) {
            let column = |i: usize| transcript.steps.iter().map(move |s| number(&s.answers[i]));
            assert!(column(0).any(|s| s > 0.1) && column(0).any(|s| s < -0.1), "{}", file.display());
            assert!(column(1).any(|t| t > 0.1), "{}", file.display());
            assert!(transcript.steps.len() >= 100, "{}", file.display());
        }
    }
}

/// Fixtures lie in the history of the repository for ever.
#[test]
fn the_golden_plugins_of_a_version_are_small() {
    for version in AbiVersion::SUPPORTED {
        let bytes: u64 = golden(*version).iter().map(|(file, _)| file.metadata().unwrap().len()).sum();
        assert!(bytes < 150_000, "ABI {version}: {bytes} bytes");
    }
}
