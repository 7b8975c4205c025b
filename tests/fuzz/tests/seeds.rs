//! Seeds of the fuzz targets and what mutation makes of them, with every test run.

/// Mutations of each seed.
const MUTATIONS: u64 = 300;

#[test]
fn no_reader_panics_on_seeds_and_their_mutations() {
    for target in vb_fuzz::TARGETS {
        let mut random = 2025;
        for seed in (target.seeds)() {
            (target.run)(&seed);
            for _ in 0..MUTATIONS {
                (target.run)(&vb_fuzz::mutate(&seed, &mut random));
            }
        }
    }
}

#[test]
fn every_target_has_its_program_under_libfuzzer() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/libfuzzer");
    let manifest = std::fs::read_to_string(format!("{folder}/Cargo.toml")).expect("a manifest");
    for target in vb_fuzz::TARGETS {
        let path = format!("fuzz_targets/{}.rs", target.name);
        assert!(manifest.contains(&format!("path = \"{path}\"")), "{path} is not in libfuzzer/Cargo.toml");
        let program = std::fs::read_to_string(format!("{folder}/{path}")).expect("a program");
        assert!(program.contains(&format!("target(\"{}\")", target.name)), "{path} runs another target");
    }
}
