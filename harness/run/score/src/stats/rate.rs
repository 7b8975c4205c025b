//! The interval of a success rate: the one that terminal, summary, page and leaderboard show.

use super::bootstrap::{Interval, Ratio, bootstrap_ratio};
use super::wilson;

/// The seed of the resampling, so that the figures of the same tasks are always the same.
pub const BOOTSTRAP_SEED: u64 = 0;

/// The 95 % interval of a success rate, from the successes (`sum`) and tasks (`weight`) of each world.
///
/// Tasks of a world succeed and fail together, so worlds are drawn whole ([`bootstrap_ratio`]): an interval that takes tasks as
/// independent is too narrow, the more so the more tasks a world has. Where all tasks of all worlds succeed, or none, there is
/// nothing to draw from, and an interval without width would claim certainty: it is Wilson's then, with each world as one
/// trial. `None` with fewer than two worlds, which tell nothing of how worlds differ.
#[must_use]
pub fn success_interval(worlds: &[Ratio]) -> Option<Interval> {
    let interval = bootstrap_ratio(worlds, BOOTSTRAP_SEED, &["report", "success rate"])?;
    let count = worlds.iter().filter(|w| w.weight > 0.0).count() as u64;
    let successes = match interval.estimate {
        0.0 => 0,
        1.0 => count,
        _ => return Some(interval),
    };
    wilson(successes, count).map(|(low, high)| Interval { low, high, ..interval })
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_math::rng::Stream;

    /// Success rates of the tasks of worlds as in `vb-100`: in a third of the worlds nearly all succeed, in a third nearly
    /// none, the others lie between. Their mean is 0.5.
    const RATES: [f64; 10] = [0.0, 0.0, 0.05, 0.3, 0.5, 0.5, 0.7, 0.95, 1.0, 1.0];

    /// How often the interval of the rate by `of` holds the true rate, of `trials` suites of so many worlds of ten tasks.
    fn coverage(worlds: usize, trials: u64, of: impl Fn(&[Ratio]) -> Option<(f64, f64)>) -> f64 {
        let mut stream = Stream::new(7, &["coverage"]);
        let mut held = 0;
        for _ in 0..trials {
            let suite: Vec<Ratio> = (0..worlds)
                .map(|_| {
                    let rate = RATES[stream.below(10) as usize];
                    let sum = (0..10).filter(|_| stream.unit() < rate).count() as f64;
                    Ratio { sum, weight: 10.0 }
                })
                .collect();
            let (low, high) = of(&suite).unwrap();
            held += u64::from(low <= 0.5 && 0.5 <= high);
        }
        held as f64 / trials as f64
    }

    fn over_tasks(worlds: &[Ratio]) -> Option<(f64, f64)> {
        wilson(worlds.iter().map(|w| w.sum as u64).sum(), worlds.iter().map(|w| w.weight as u64).sum())
    }

    #[test]
    fn the_interval_holds_the_rate_about_as_often_as_it_says_and_one_over_tasks_does_not() {
        // The expectation is the definition of a 95 % interval; three standard errors are 2 points of 1000 trials and 4 of 300.
        let ours = |worlds: &[Ratio]| success_interval(worlds).map(|i| (i.low, i.high));
        let (ten, hundred) = (coverage(10, 1000, ours), coverage(100, 300, ours));
        let (ten_tasks, hundred_tasks) = (coverage(10, 1000, over_tasks), coverage(100, 1000, over_tasks));
        assert!((0.92..0.99).contains(&ten) && (0.91..0.99).contains(&hundred), "{ten} {hundred}");
        assert!(ten_tasks < 0.75 && hundred_tasks < 0.75, "{ten_tasks} {hundred_tasks}");
    }

    #[test]
    fn without_spread_each_world_is_one_trial_and_one_world_tells_nothing() {
        let worlds = [Ratio { sum: 0.0, weight: 10.0 }; 3];
        // Wilson's upper end without successes is z²/(n + z²), n = 3, z = 1.95996.
        let i = success_interval(&worlds).unwrap();
        assert_eq!((i.estimate, i.low), (0.0, 0.0));
        assert!((i.high - 3.841_458_8 / 6.841_458_8).abs() < 1e-7, "{i:?}");
        assert_eq!(success_interval(&worlds[..1]), None);
    }
}
