//! Seeds of the fuzz targets and what mutation makes of them, with every test run.

/// Mutations of each seed.
const MUTATIONS: u64 = 300;

/// SplitMix64 (Steele, Lea, Flood 2014): the choice of mutations is the same in every run.
fn next(state: &mut u64) -> usize {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) as usize
}

fn mutate(seed: &[u8], random: &mut u64) -> Vec<u8> {
    /// Numbers and signs that readers stumble over.
    const TOKENS: [&[u8]; 12] = [
        b"-1",
        b"1e308",
        b"NaN",
        b".inf",
        b"0",
        b"99999999999999999999",
        b"\xff\xff\xff\xff",
        b"\0",
        b"[[[[[[[[",
        b"&a *a",
        b"../..",
        b"\xe2\x80\xae",
    ];
    let mut bytes = seed.to_vec();
    for _ in 0..1 + next(random) % 4 {
        let at = next(random) % bytes.len().max(1);
        match next(random) % 6 {
            0 => bytes.truncate(at),
            1 if at < bytes.len() => bytes[at] ^= 1 << (next(random) % 8),
            2 if at < bytes.len() => bytes[at] = next(random) as u8,
            3 => {
                let end = (at + next(random) % 64).min(bytes.len());
                let copy = bytes[at.min(end)..end].to_vec();
                let to = next(random) % (bytes.len() + 1);
                bytes.splice(to..to, copy);
            }
            4 => {
                let end = (at + next(random) % 16).min(bytes.len());
                bytes.drain(at.min(end)..end);
            }
            _ => {
                let token = TOKENS[next(random) % TOKENS.len()];
                let end = (at + token.len()).min(bytes.len());
                bytes.splice(at.min(end)..end, token.iter().copied());
            }
        }
    }
    // What the input stands for is not the reader's affair.
    if let (Some(kind), Some(first)) = (seed.first(), bytes.first_mut()) {
        *first = *kind;
    }
    bytes
}

#[test]
fn no_reader_panics_on_seeds_and_their_mutations() {
    for target in vb_fuzz::TARGETS {
        let mut random = 2025;
        for seed in (target.seeds)() {
            (target.run)(&seed);
            for _ in 0..MUTATIONS {
                (target.run)(&mutate(&seed, &mut random));
            }
        }
    }
}

/// Mutates the seeds of a target for a while, where no nightly compiler for libFuzzer is at hand: `VB_FUZZ_TARGET` names it (default:
/// all of them, one after the other), `VB_FUZZ_SECONDS` says how long (default: 60). An input that takes more than two seconds, or ends
/// the target, is left in `VB_FUZZ_KEEP` (default: the folder for temporary files).
#[test]
#[ignore = "runs as long as it is told to"]
#[allow(clippy::disallowed_methods, reason = "how long it runs reaches no score")]
fn mutations_of_seeds_for_a_while() {
    use std::time::{Duration, Instant};
    let var = |name: &str| std::env::var(name).ok();
    let seconds = var("VB_FUZZ_SECONDS").and_then(|s| s.parse().ok()).unwrap_or(60);
    let keep = var("VB_FUZZ_KEEP").map_or_else(std::env::temp_dir, std::path::PathBuf::from);
    let wanted = var("VB_FUZZ_TARGET");
    for target in vb_fuzz::TARGETS.iter().filter(|t| wanted.as_deref().is_none_or(|name| name == t.name)) {
        let seeds = (target.seeds)();
        let (begun, mut random, mut count) = (Instant::now(), u64::from(std::process::id()), 0_u64);
        let current = keep.join(format!("fuzz-{}-{}", target.name, std::process::id()));
        while begun.elapsed() < Duration::from_secs(seconds) {
            let mut input = seeds[next(&mut random) % seeds.len()].clone();
            for _ in 0..1 + next(&mut random) % 3 {
                input = mutate(&input, &mut random);
            }
            std::fs::write(&current, &input).expect("a place for the input");
            let at = Instant::now();
            (target.run)(&input);
            assert!(
                at.elapsed() < Duration::from_secs(2),
                "{} takes long: {}",
                target.name,
                current.display()
            );
            count += 1;
        }
        let _ = std::fs::remove_file(&current);
        eprintln!("{}: {count} inputs in {seconds} s", target.name);
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
