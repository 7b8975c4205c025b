//! The statistics of random processes against their parameters. Bounds are five standard errors of the estimates.

use crate::common::seed;
use vb_sense::noise::{GaussMarkov, Outage, RandomWalk, White, normal_quantile};

#[test]
fn the_quantile_is_the_inverse_of_the_normal_distribution() {
    for p in [1e-12, 1e-9, 1e-4, 0.01, 0.075, 0.3, 0.5, 0.6, 0.925, 0.99, 1.0 - 1e-6] {
        // Φ(x) = erfc(−x/√2)/2.
        let x = normal_quantile(p);
        let back = 0.5 * vb_math::erfc(-x / std::f64::consts::SQRT_2);
        // Seven digits of x are as many times x² fewer of a small probability.
        assert!((back - p).abs() < 2e-7 * (1.0 + x * x) * p.min(1.0 - p), "{p}: {x}, {back}");
    }
}

#[test]
fn white_noise_has_its_deviation_and_no_memory() {
    let n = 100_000;
    let mut w = White::new(0.3, seed(1, "t").stream("a", "b"));
    let x: Vec<f64> = (0..n).map(|_| w.step()).collect();
    let product =
        |lag: usize| x[lag..].iter().zip(&x).map(|(a, b)| a * b).sum::<f64>() / (n - lag) as f64 / 0.09;
    // Standard errors: √(2/n) and 1/√n.
    assert!((product(0) - 1.0).abs() < 5.0 * (2.0 / n as f64).sqrt(), "{}", product(0));
    assert!(product(1).abs() < 5.0 / (n as f64).sqrt(), "{}", product(1));
}

#[test]
fn a_gauss_markov_process_has_its_variance_and_forgets_in_its_correlation_time() {
    let (std, correlation, dt, n) = (2.0, 0.5, 0.01, 1_000_000);
    let mut g = GaussMarkov::new(std, correlation, dt, seed(1, "t").stream("a", "b"));
    let x: Vec<f64> = (0..n).map(|_| g.step()).collect();
    let product = |lag: usize| {
        x[lag..].iter().zip(&x).map(|(a, b)| a * b).sum::<f64>() / (n - lag) as f64 / (std * std)
    };
    // A time of T correlation times has T/2·2 independent values of a square: the standard error of the variance is
    // √(2·correlation/time) = 0.01.
    for (lag, expected) in
        [(0, 1.0), (25, vb_math::exp(-0.5)), (50, vb_math::exp(-1.0)), (100, vb_math::exp(-2.0))]
    {
        assert!((product(lag) - expected).abs() < 0.05, "{lag}: {}, expected {expected}", product(lag));
    }
    // It begins with its own spread, not at zero.
    let starts =
        (0..4000).map(|k| GaussMarkov::new(std, correlation, dt, seed(k, "t").stream("a", "b")).value());
    let spread = starts.map(|v| v * v).sum::<f64>() / 4000.0 / (std * std);
    assert!((spread - 1.0).abs() < 5.0 * (2.0_f64 / 4000.0).sqrt(), "{spread}");
}

#[test]
fn a_random_walk_spreads_with_the_root_of_the_way_however_the_way_is_cut() {
    let walks = 4000;
    let spread = |steps: &[f64], run: u64| {
        let end = |k: u64| {
            let mut w = RandomWalk::new(0.1, 5.0, seed(k + run, "t").stream("a", "b"));
            steps.iter().for_each(|s| {
                w.step(*s);
            });
            w.value() - 5.0
        };
        (0..walks).map(|k| end(k) * end(k)).sum::<f64>() / walks as f64
    };
    // 0.1² times 25 m of way.
    let bound = 5.0 * (2.0_f64 / walks as f64).sqrt();
    for (steps, run) in [(vec![25.0], 0), (vec![0.5; 50], 1 << 20), (vec![1.0, 0.0, 24.0], 1 << 21)] {
        assert!((spread(&steps, run) / 0.25 - 1.0).abs() < bound, "{steps:?}: {}", spread(&steps, run));
    }
}

#[test]
fn outages_begin_and_last_as_long_as_stated() {
    let (interval, duration, dt, n) = (8.0, 2.0, 0.01, 4_000_000);
    let mut o = Outage::new(interval, duration, dt, seed(1, "t").stream("a", "b"));
    assert!(!o.is_out());
    let (mut out, mut spells, mut before) = (0, 0, false);
    for _ in 0..n {
        let now = o.step();
        out += u32::from(now);
        spells += u32::from(now && !before);
        before = now;
    }
    // 40 000 s with about 4000 spells: 1.6 % is the standard error of their mean duration, and less of their number. Of
    // spells shorter than a sample some aren't seen, half a sample in 2 s, 0.25 %.
    let spells = f64::from(spells);
    assert!(
        (f64::from(out) * dt / spells / duration - 1.0).abs() < 0.08,
        "{} s",
        f64::from(out) * dt / spells
    );
    assert!((n as f64 * dt / spells / (interval + duration) - 1.0).abs() < 0.08, "{spells}");
}
