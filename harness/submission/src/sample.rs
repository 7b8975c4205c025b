//! Which tasks are driven again.

use std::collections::BTreeSet;

use vb_math::rng::Stream;

/// `count` of `tasks` drawn by `seed` without replacement, and `always` beside them, which don't count.
pub(crate) fn draw(tasks: &[String], count: usize, seed: u64, always: &[String]) -> BTreeSet<String> {
    let always: BTreeSet<String> = always.iter().cloned().collect();
    let mut others: Vec<&String> = tasks.iter().filter(|t| !always.contains(*t)).collect();
    Stream::new(seed, &["verification"]).shuffle(&mut others);
    let drawn = others.into_iter().take(count).cloned();
    drawn.chain(always.iter().cloned()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_names_its_sample_and_traces_are_always_in_it() {
        let tasks: Vec<String> = (0..100).map(|k| format!("w001/t{k:02}")).collect();
        let always = [tasks[7].clone()];
        let of = |seed| draw(&tasks, 10, seed, &always);
        assert_eq!(of(1), of(1));
        assert_ne!(of(1), of(2));
        assert!(of(1).contains("w001/t07") && of(1).len() == 11);
        assert_eq!(draw(&tasks, 1000, 1, &always).len(), 100);
        assert_eq!(draw(&tasks, 0, 1, &always).len(), 1);
    }

    #[test]
    fn every_task_is_drawn_as_often_as_any_other() {
        let tasks: Vec<String> = (0..10).map(|k| format!("w001/t{k:02}")).collect();
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
