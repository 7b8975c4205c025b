//! Runs a target on mutations of its seeds, where there is no nightly compiler for libFuzzer:
//! `cargo run --release --package vb-fuzz --example mutate -- TARGET SECONDS`, or with a file instead of the seconds on that input alone.
//!
//! An input that takes more than two seconds, or ends the target, is left in the folder for temporary files.

use std::time::{Duration, Instant};

/// The longest that one input may take.
const LONGEST: Duration = Duration::from_secs(2);

#[allow(clippy::disallowed_methods, reason = "how long it runs reaches no score")]
fn main() {
    let mut args = std::env::args().skip(1);
    let (name, what) = (args.next(), args.next());
    let target = vb_fuzz::TARGETS.iter().find(|t| Some(t.name) == name.as_deref());
    let input = what.as_ref().and_then(|file| std::fs::read(file).ok());
    if let (Some(target), Some(input)) = (target, input) {
        let at = Instant::now();
        (target.run)(&input);
        eprintln!("{}: {:?}", target.name, at.elapsed());
        return;
    }
    let (Some(target), Some(seconds)) = (target, what.and_then(|text| text.parse().ok())) else {
        let names: Vec<&str> = vb_fuzz::TARGETS.iter().map(|t| t.name).collect();
        eprintln!("usage: mutate TARGET SECONDS|FILE; there are {}", names.join(", "));
        std::process::exit(2);
    };
    let seeds = (target.seeds)();
    let current = std::env::temp_dir().join(format!("fuzz-{}-{}", target.name, std::process::id()));
    let (begun, mut random, mut count) = (Instant::now(), u64::from(std::process::id()), 0_u64);
    while begun.elapsed() < Duration::from_secs(seconds) {
        let mut input = seeds[vb_fuzz::next(&mut random) % seeds.len()].clone();
        for _ in 0..1 + vb_fuzz::next(&mut random) % 3 {
            input = vb_fuzz::mutate(&input, &mut random);
        }
        std::fs::write(&current, &input).expect("a place for the input");
        let at = Instant::now();
        (target.run)(&input);
        assert!(at.elapsed() < LONGEST, "{} takes long: {}", target.name, current.display());
        count += 1;
    }
    let _ = std::fs::remove_file(&current);
    eprintln!("{}: {count} inputs in {seconds} s", target.name);
}
