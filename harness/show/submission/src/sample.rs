//! Which tasks are driven again.

use std::collections::BTreeSet;

use vb_math::rng::Stream;
use vb_world::TaskId;

/// `count` of `tasks` drawn by `seed` without replacement, and `always` beside them, which don't count.
pub(crate) fn draw(tasks: &[TaskId], count: usize, seed: u64, always: &[TaskId]) -> BTreeSet<TaskId> {
    let always: BTreeSet<TaskId> = always.iter().cloned().collect();
    let mut others: Vec<&TaskId> = tasks.iter().filter(|t| !always.contains(*t)).collect();
    Stream::new(seed, &["verification"]).shuffle(&mut others);
    let drawn = others.into_iter().take(count).cloned();
    drawn.chain(always.iter().cloned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tasks(count: usize) -> Vec<TaskId> {
        (0..count).map(|k| format!("w001/t{k:02}").parse().unwrap()).collect()
    }

    #[test]
    fn a_seed_names_its_sample_and_traces_are_always_in_it() {
        let tasks = tasks(100);
        let always = [tasks[7].clone()];
        let of = |seed| draw(&tasks, 10, seed, &always);
        assert_eq!(of(1), of(1));
        assert_ne!(of(1), of(2));
        assert!(of(1).contains("w001/t07") && of(1).len() == 11);
        assert_eq!(draw(&tasks, 1000, 1, &always).len(), 100);
        assert_eq!(draw(&tasks, 0, 1, &always).len(), 1);
    }

    #[test]
    fn the_documented_table_of_detection_is_the_hypergeometric_distribution() {
        // P(none of f forged tasks among n drawn of 1000) = Π (1000 − n − i) / (1000 − i), i = 0…f−1.
        let detected = |forged: u32, drawn: u32| {
            let escape: f64 = (0..forged)
                .map(|i| (1000.0 - f64::from(drawn) - f64::from(i)).max(0.0) / (1000.0 - f64::from(i)))
                .product();
            100.0 * (1.0 - escape)
        };
        let page = include_str!("../../../../docs/running-a-leaderboard.md");
        let mut rows =
            page.lines().skip_while(|l| !l.starts_with("| forged")).take_while(|l| l.starts_with('|'));
        let cells = |row: &str| -> Vec<String> {
            row.trim_matches('|').split('|').map(|c| c.trim().to_owned()).collect()
        };
        let drawn: Vec<u32> = cells(rows.next().unwrap())[1..].iter().map(|c| c.parse().unwrap()).collect();
        let mut checked = 0;
        for row in rows.skip(1) {
            let row = cells(row);
            let forged: u32 = row[0].parse().unwrap();
            for (text, n) in row[1..].iter().zip(&drawn) {
                assert_eq!(*text, format!("{:.1}", detected(forged, *n)), "{forged} forged, {n} drawn");
                checked += 1;
            }
        }
        assert_eq!(checked, 35);
        // Ten forged tasks of a thousand escape a sample of 50 in six of ten cases.
        assert!((detected(10, 50) - 40.0).abs() < 0.5);
    }

    #[test]
    fn every_task_is_drawn_as_often_as_any_other() {
        let tasks = tasks(10);
        let mut counts = [0; 10];
        for seed in 0..2000 {
            for task in draw(&tasks, 3, seed, &[]) {
                counts[tasks.iter().position(|t| *t == task).unwrap()] += 1;
            }
        }
        // Binomial: 2000 draws of probability 0.3, standard deviation 20.5; five of them.
        assert!(counts.iter().all(|c| (*c - 600i32).abs() < 103), "{counts:?}");
    }
}
