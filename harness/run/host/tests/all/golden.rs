//! Plugins that were built for a released version of the planner interface run for ever, and as they did then.

#![allow(clippy::unwrap_used, reason = "a helper of a test may fail it")]

mod transcript;

use std::path::{Path, PathBuf};

use transcript::{Transcript, number};
use vb_host::{AbiVersion, Limits, Plugin, ProcessOptions, inspect};

/// The golden plugins of a version that this machine can run, with their transcripts.
fn golden(version: AbiVersion) -> Vec<(PathBuf, Transcript)> {
    let folder =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tests/golden").join(format!("abi-{version}"));
    let files = std::fs::read_dir(folder).unwrap().map(|f| f.unwrap().path());
    let here = format!("-{}-{}.so", std::env::consts::ARCH, std::env::consts::OS);
    let runs_here = |f: &PathBuf| {
        let name = f.to_string_lossy();
        name.ends_with(".wasm") || name.ends_with(&here)
    };
    let mut plugins: Vec<PathBuf> = files.filter(runs_here).collect();
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
    let worker = option_env!("CARGO_BIN_EXE_vb-worker").map(PathBuf::from);
    let options = ProcessOptions { worker, ..ProcessOptions::default() };
    for version in AbiVersion::SUPPORTED {
        for (file, transcript) in golden(*version) {
            assert_eq!(transcript.abi, version.name());
            assert_eq!(inspect(&file).unwrap().abi, version.name(), "{}", file.display());
            let plugin = Plugin::load_with(&file, &Limits::default(), None, &options).unwrap();
            assert_eq!(plugin.abi(), *version);
            for (i, (now, step)) in transcript.replay(&plugin).iter().zip(&transcript.steps).enumerate() {
                let off = |k: usize| (number(&now[k]) - number(&step.answers[k])).abs();
                let near = (0..3).all(|k| off(k) <= transcript.tolerance);
                let same = *now == step.answers || (transcript.tolerance > 0.0 && near);
                assert!(same, "{}, step {i}: {now:?}, recorded {:?}", file.display(), step.answers);
            }
        }
    }
}

/// A transcript in which nothing happens would prove nothing.
#[test]
fn the_transcripts_steer_both_ways_and_brake() {
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
        assert!(bytes < 800_000, "ABI {version}: {bytes} bytes");
    }
}
