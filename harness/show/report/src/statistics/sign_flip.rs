//! Paired differences, by flipping the signs of whole worlds.

use vb_math::rng::Stream;

/// Most worlds that differ for which all choices of signs are gone through: half of 2¹⁸, as the other half mirrors it.
const EXACT: usize = 18;
/// Choices of signs that are drawn beyond: with the one observed a round number, so that the least p-value is 1 in 100 000.
const DRAWS: usize = 99_999;
/// Least number of them, for very many worlds.
const FEWEST: usize = 9_999;
/// Groups of worlds that are added up for one test at most: with very many worlds fewer draws do.
const SUMS: usize = 200_000_000;
/// Worlds whose signs are one byte.
const GROUP: usize = 8;

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignFlip {
    /// Number of worlds that differ: the others say nothing, whatever their sign.
    pub worlds: usize,
    /// Two-sided p-value; 1 if no world differs.
    pub p: f64,
}

/// The sign-flip test, Fisher's randomisation test of paired differences (Fisher 1935, section 21; Good 2005, section
/// 3.2.1; for means of differences that are not symmetric it holds in the limit, Romano 1990). `sums` has for each world the
/// sum of its tasks' differences, so whole worlds are flipped: how tasks of a world hang together does not matter.
///
/// The hypothesis is that both planners are the same to a world: what the one did there the other might as well have done. Then
/// the sign of each world's sum is a fair coin's, and the p-value is the share of all choices of signs whose total is as
/// far from 0 as the observed one. Up to 18 worlds that differ it is exact; beyond, 99 999 choices are drawn, and the observed one
/// counts among them (Phipson and Smyth 2010), so that the test never rejects more often than it says. `labels` name the
/// random stream.
#[must_use]
pub fn sign_flip(sums: &[f64], seed: u64, labels: &[&str]) -> SignFlip {
    let sums: Vec<f64> = sums.iter().copied().filter(|s| *s != 0.0 && s.is_finite()).collect();
    let total: f64 = sums.iter().sum();
    let size: f64 = sums.iter().map(|s| s.abs()).sum();
    let worlds = sums.len();
    if worlds == 0 {
        return SignFlip { worlds, p: 1.0 };
    }
    // Totals that are equal but for rounding are equal.
    let reaches = |t: f64| t.abs() >= total.abs() - 1e-9 * size;
    let p = if worlds <= EXACT {
        // The mirror of each choice is as far from 0, so the first sign can stay.
        let rest = signed(&sums[1..]);
        let choices = 1_u64 << (worlds - 1);
        let count =
            (0..choices).filter(|signs| reaches(sums[0] + flipped(&rest, &signs.to_le_bytes()))).count();
        count as f64 / choices as f64
    } else {
        let groups = signed(&sums);
        let draws = (SUMS / groups.len()).clamp(FEWEST, DRAWS);
        let mut stream = Stream::new(seed, labels);
        let mut signs = vec![0_u8; groups.len().next_multiple_of(8)];
        let mut count = 1;
        for _ in 0..draws {
            for word in signs.chunks_exact_mut(8) {
                word.copy_from_slice(&stream.next_u64().to_le_bytes());
            }
            count += usize::from(reaches(flipped(&groups, &signs)));
        }
        count as f64 / (draws + 1) as f64
    };
    SignFlip { worlds, p }
}

/// The total of each group of eight worlds under each choice of their signs, a set bit being a flip.
fn signed(sums: &[f64]) -> Vec<[f64; 256]> {
    let of = |group: &[f64], signs: usize| -> f64 {
        group.iter().enumerate().map(|(k, s)| if signs >> k & 1 == 1 { -s } else { *s }).sum()
    };
    sums.chunks(GROUP).map(|group| std::array::from_fn(|signs| of(group, signs))).collect()
}

fn flipped(groups: &[[f64; 256]], signs: &[u8]) -> f64 {
    groups.iter().zip(signs).map(|(group, signs)| group[usize::from(*signs)]).sum()
}

/// The least p-value that the test can have if this many worlds differ: that of all of them differing the same way.
#[must_use]
pub fn least_p(worlds: usize) -> f64 {
    // Beyond some hundred worlds it is no number any more, and no matter.
    (1..worlds.min(1000)).fold(1.0, |p, _| 0.5 * p)
}

/// How many worlds must differ for the test to be able to fall below `level` as one of a family of so many tests.
#[must_use]
pub fn worlds_needed(level: f64, tests: usize) -> usize {
    (1..1000).find(|n| tests.max(1) as f64 * least_p(*n) < level).unwrap_or(1000)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::{holm, mcnemar};

    #[test]
    fn the_exact_test_is_fishers_on_darwins_maize() {
        // Fisher 1935, section 21: of the 2¹⁵ choices of signs 863 have a total of 314 eighths of an inch or more, and as many
        // one of −314 or less: 1726 of 32 768.
        let d = [6, 8, 14, 16, 23, 24, 28, 29, 41, -48, 49, 56, 60, -67, 75].map(f64::from);
        let found = sign_flip(&d, 0, &[]);
        assert_eq!(found, SignFlip { worlds: 15, p: 1726.0 / 32_768.0 });
        // Worlds without a difference change nothing, nor does the unit or which planner is the first.
        let mut other: Vec<f64> = d.iter().map(|v| -0.1 * v).collect();
        other.extend([0.0; 40]);
        assert_eq!(sign_flip(&other, 0, &[]), found);
    }

    #[test]
    fn beyond_the_exact_ones_signs_are_drawn() {
        // Twenty worlds that each differ by 1: the total is 2k − 20 of a fair binomial k. Of 16 to 4, by the table of the
        // binomial distribution (n = 20, p = ½): 2 · P(X ≥ 16) = 2 · 0.005909.
        let d: Vec<f64> = (0..20).map(|k| if k < 16 { 1.0 } else { -1.0 }).collect();
        let p = sign_flip(&d, 0, &["test"]).p;
        assert!((p - 0.011_818).abs() < 4.0 * (0.0118_f64 / 99_999.0).sqrt(), "{p}");
        assert_eq!(p, sign_flip(&d, 0, &["test"]).p, "the same seed, the same bits");
        // All forty one way: none of the draws reaches that, and the observed one is still there.
        assert_eq!(sign_flip(&[1.0; 40], 0, &[]).p, 1e-5);
        assert_eq!(sign_flip(&[], 0, &[]), SignFlip { worlds: 0, p: 1.0 });
    }

    #[test]
    fn few_worlds_cannot_differ_for_certain() {
        // 2 · 2⁻ⁿ, and where it falls below 0.05 once and, for six or 45 tests, by Bonferroni.
        assert_eq!((least_p(0), least_p(1), least_p(5), least_p(6)), (1.0, 1.0, 0.0625, 0.03125));
        assert_eq!((worlds_needed(0.05, 1), worlds_needed(0.05, 6), worlds_needed(0.05, 45)), (6, 8, 11));
        for n in 1..=12 {
            assert_eq!(sign_flip(&vec![3.0; n], 0, &[]).p, least_p(n), "{n}");
        }
    }

    /// Successes of planners that are equally good over all, in one world of ten tasks: each has its own world rate, and they
    /// are dealt out at random. So tasks of a world hang together, also in what sets the planners apart.
    fn world(stream: &mut Stream, planners: usize) -> Vec<[bool; 10]> {
        let mut rates =
            [[0.05, 0.2, 0.9, 0.95], [0.4, 0.5, 0.6, 0.7], [0.0, 0.0, 0.3, 0.8]][stream.below(3) as usize];
        stream.shuffle(&mut rates);
        rates[..planners].iter().map(|rate| std::array::from_fn(|_| stream.unit() < *rate)).collect()
    }

    /// Sum of the differences between two planners in each world, and the p-value of McNemar's test over the tasks.
    fn compared(suite: &[Vec<[bool; 10]>], a: usize, b: usize) -> (Vec<f64>, f64) {
        let (mut only_a, mut only_b) = (0, 0);
        let sum = |world: &Vec<[bool; 10]>| {
            let one = |x: usize, y: usize| (0..10).filter(|t| world[x][*t] && !world[y][*t]).count() as u64;
            let (own_a, own_b) = (one(a, b), one(b, a));
            (only_a, only_b) = (only_a + own_a, only_b + own_b);
            own_b as f64 - own_a as f64
        };
        let sums = suite.iter().map(sum).collect();
        (sums, mcnemar(only_a, only_b))
    }

    #[test]
    fn false_alarms_are_as_rare_as_the_level_says_though_tasks_share_worlds() {
        // Of 1000 suites 50 are false alarms by the definition of a 5 % test; three standard errors are 21. Fewer are possible
        // where few worlds differ, as the test has few p-values then.
        let mut stream = Stream::new(7, &["false alarms"]);
        for worlds in [10, 40] {
            let (mut ours, mut over_tasks) = (0, 0);
            for _ in 0..1000 {
                let suite: Vec<_> = (0..worlds).map(|_| world(&mut stream, 2)).collect();
                let (sums, p) = compared(&suite, 0, 1);
                ours += u32::from(sign_flip(&sums, 0, &["test"]).p < 0.05);
                over_tasks += u32::from(p < 0.05);
            }
            assert!((20..=71).contains(&ours), "{worlds} worlds: {ours} of 1000");
            assert!(over_tasks > 150, "the test over tasks takes them for independent: {over_tasks} of 1000");
        }
    }

    #[test]
    fn a_family_of_six_pairs_has_a_false_alarm_in_one_report_of_twenty_at_most() {
        let mut stream = Stream::new(8, &["families"]);
        let mut alarms = 0;
        for _ in 0..400 {
            let suite: Vec<_> = (0..16).map(|_| world(&mut stream, 4)).collect();
            let pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
            let p = pairs.map(|(a, b)| sign_flip(&compared(&suite, a, b).0, 0, &["test"]).p);
            alarms += u32::from(holm(&p).iter().any(|p| *p < 0.05));
        }
        // Twenty by the level, and three standard errors of 4.4.
        assert!(alarms <= 33, "{alarms} of 400");
    }
}
