//! Curricula over the tasks of a suite.

use std::path::Path;

use vb_env::curriculum::{Curriculum, Ending, Method, Spec};
use vb_world::{Selector, Suite, TaskId};

fn smoke() -> (Suite, Vec<TaskId>) {
    let suite =
        Suite::open(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tasks/smoke")).expect("the suite");
    let tasks = Selector::default().select(&suite).expect("tasks");
    (suite, tasks)
}

fn of(text: &str) -> Spec {
    Spec::parse(&format!("schema: 1\nname: mine\n{text}"), "mine.yaml").expect("a curriculum")
}

/// A curriculum over the first `tasks` tasks of the suite.
fn over(tasks: usize, text: &str, environments: usize) -> Curriculum {
    let (suite, all) = smoke();
    Curriculum::new(&of(text), &suite, &all[..tasks], environments, 7).expect("a curriculum")
}

fn end(curriculum: &mut Curriculum, environment: usize, task: usize, is_success: bool) {
    curriculum.report(&Ending { environment, task, is_success });
}

#[track_caller]
fn close(given: &[f64], wanted: &[f64]) {
    assert_eq!(given.len(), wanted.len());
    for (k, (given, wanted)) in given.iter().zip(wanted).enumerate() {
        assert!((given - wanted).abs() < 1e-12, "task {k}: {given} instead of {wanted}");
    }
}

const LEARNABILITY: &str = "kind: learnability\nexplore: 0.2\nkeep: 1\nkeep_level: 1\nprior: 0.001\n";
const REPLAY: &str = "kind: replay\nreplay: 0.5\nseen: 0.5\nkeep: 0\ntemperature: 1\nstaleness: 0\n";
/// Smoke's first three worlds are low, medium and high.
const MANUAL: &str =
    "kind: manual\nstages: [w001, w002, w003]\nwindow: 4\npromote: 0.75\ndemote: 0.25\nreview: 0.25\n";

#[test]
fn those_that_come_with_the_harness_can_be_used_with_training_worlds_of_all_kinds() {
    let (suite, tasks) = smoke();
    for (name, _) in Spec::BUILTIN {
        let spec = Spec::resolve(name).unwrap();
        assert_eq!(spec.name, *name);
        // The ten worlds of smoke haven't every kind of ground at every level, which stages by hand take.
        let made = Curriculum::new(&spec, &suite, &tasks, 2, 0);
        assert!(made.is_ok() || *name == "manual", "{name}");
    }
}

#[test]
fn the_manual_stages_have_each_task_of_the_default_suite_once() {
    let tasks = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tasks");
    let suite = Suite::open(tasks.join("vb-100")).unwrap();
    let Method::Manual(manual) = Spec::resolve("manual").unwrap().method else { panic!("it has stages") };
    let chosen = |stage: &Vec<Selector>| -> Vec<TaskId> {
        stage.iter().flat_map(|selector| selector.select(&suite).unwrap()).collect()
    };
    let stages: Vec<Vec<TaskId>> = manual.stages.iter().map(chosen).collect();
    // Of 34 low worlds 20 are rigid and 4 mixed; of 33 medium and 33 high worlds 20 are rigid and 3 mixed.
    assert_eq!(stages.iter().map(Vec::len).sum::<usize>(), 1000);
    assert_eq!((stages[2].len(), stages[6].len(), stages[7].len()), (100, 200, 130));
    let all: std::collections::BTreeSet<&TaskId> = stages.iter().flatten().collect();
    assert_eq!(all.len(), 1000);
}

#[test]
fn seed_and_environment_decide_what_is_drawn() {
    let draws = |seed: u64, environment: usize| -> Vec<usize> {
        let (suite, tasks) = smoke();
        let mut own = Curriculum::new(&of("kind: uniform\n"), &suite, &tasks, 3, seed).unwrap();
        (0..20).map(|_| own.draw(environment)).collect()
    };
    assert_eq!(draws(1, 0), draws(1, 0));
    assert_ne!(draws(1, 0), draws(1, 1));
    assert_ne!(draws(1, 0), draws(2, 0));
    // What one environment draws doesn't depend on how much another drew before.
    let mut own = over(100, "kind: uniform\n", 2);
    let first = own.draw(1);
    let mut other = over(100, "kind: uniform\n", 2);
    for _ in 0..5 {
        other.draw(0);
    }
    assert_eq!(other.draw(1), first);
}

#[test]
fn tasks_are_drawn_as_often_as_their_chances_say() {
    // Replay with tasks that are new, and with none.
    let cases = [(LEARNABILITY, 30), (REPLAY, 30), (REPLAY, 20), (MANUAL, 30), ("kind: uniform\n", 30)];
    for (text, tasks) in cases {
        let mut own = over(tasks, text, 1);
        for k in 0..20 {
            end(&mut own, 0, k, k % 3 == 0);
            end(&mut own, 0, k, k % 2 == 0);
            own.score(k, (k * 7 % 11) as f64);
        }
        let chances = own.chances();
        assert!((chances.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{text}: {chances:?}");
        let mut drawn = vec![0; chances.len()];
        const DRAWS: usize = 20_000;
        (0..DRAWS).for_each(|_| drawn[own.draw(0)] += 1);
        for (k, (chance, drawn)) in chances.iter().zip(drawn).enumerate() {
            // Five standard deviations of a binomial.
            let tolerance = 5.0 * (chance * (1.0 - chance) / DRAWS as f64).sqrt() + 1e-12;
            let share = f64::from(drawn) / DRAWS as f64;
            assert!((share - chance).abs() <= tolerance, "{text}: task {k}: {share} instead of {chance}");
        }
    }
}

#[test]
fn learnability_is_p_times_one_minus_p() {
    let mut own = over(4, LEARNABILITY, 2);
    // Done 1 of 2, 1 of 4, 0 of 40, 40 of 40 times, whichever environment drove them.
    for (task, successes, all) in [(0, 1, 2), (1, 1, 4), (2, 0, 40), (3, 40, 40)] {
        (0..all).for_each(|k| end(&mut own, k % 2, task, k < successes));
    }
    let chances = own.chances();
    // 1/4 and 3/16, and next to nothing for what is always or never done; 5 % for each by exploring.
    let wanted = [0.05 + 0.8 * 4.0 / 7.0, 0.05 + 0.8 * 3.0 / 7.0, 0.05, 0.05];
    for (given, wanted) in chances.iter().zip(wanted) {
        assert!((given - wanted).abs() < 1e-3, "{chances:?}");
    }
}

#[test]
fn an_outcome_counts_less_with_each_later_one() {
    let mut own = over(2, "kind: learnability\nexplore: 0\nkeep: 0.5\nkeep_level: 1\nprior: 0.001\n", 1);
    // Done, then not: 0.5 of 1.5, so that p(1 - p) is 2/9.
    end(&mut own, 0, 0, true);
    end(&mut own, 0, 0, false);
    end(&mut own, 0, 1, false);
    end(&mut own, 0, 1, true);
    end(&mut own, 0, 1, false);
    // Not done, done, not done: 0.5 of 1.75.
    let chances = own.chances();
    let wanted = (2.0 / 9.0) / (2.0 / 9.0 + (2.0 / 7.0) * (5.0 / 7.0));
    assert!((chances[0] - wanted).abs() < 1e-3, "{chances:?} instead of {wanted}");
}

#[test]
fn what_was_never_driven_is_judged_by_its_level() {
    // Worlds 1 and 2 differ in level; of world 1 all tasks but the last are always done, of world 2 half of them.
    let mut own = over(20, "kind: learnability\nexplore: 0\nkeep: 1\nkeep_level: 1\nprior: 1\n", 1);
    for task in 0..9 {
        (0..10).for_each(|_| end(&mut own, 0, task, true));
        (0..10).for_each(|k| end(&mut own, 0, 10 + task, k % 2 == 0));
    }
    let chances = own.chances();
    assert!(chances[19] > 10.0 * chances[9], "{} and {}", chances[19], chances[9]);
}

#[test]
fn an_environment_goes_up_and_down_on_its_own() {
    let mut own = over(30, MANUAL, 2);
    let stages = |own: &Curriculum| own.stages();
    // Three of four are 0.75: up. The other environment stays.
    for k in 0..4 {
        end(&mut own, 0, k, k < 3);
    }
    assert_eq!(stages(&own), [1, 0]);
    // Tasks of other stages don't count.
    (0..8).for_each(|k| end(&mut own, 0, k, true));
    assert_eq!(stages(&own), [1, 0]);
    // Two of four: it stays, and counting begins anew.
    (0..4).for_each(|k| end(&mut own, 0, 10 + k, k < 2));
    assert_eq!(stages(&own), [1, 0]);
    (0..3).for_each(|k| end(&mut own, 0, 10 + k, true));
    assert_eq!(stages(&own), [1, 0]);
    end(&mut own, 0, 13, true);
    assert_eq!(stages(&own), [2, 0]);
    // There is nothing above the last stage and nothing below the first.
    (0..8).for_each(|k| end(&mut own, 0, 20 + k, true));
    (0..8).for_each(|k| end(&mut own, 1, k, false));
    assert_eq!(stages(&own), [2, 0]);
    (0..4).for_each(|k| end(&mut own, 0, 20 + k, k < 1));
    assert_eq!(stages(&own), [1, 0]);
}

#[test]
fn earlier_stages_are_reviewed_and_later_ones_are_not_drawn() {
    let mut own = over(30, MANUAL, 1);
    (0..8).for_each(|k| end(&mut own, 0, if k < 4 { k } else { 10 + k }, true));
    let chances = own.chances();
    let stage = |k: usize| chances[10 * k..10 * (k + 1)].iter().sum::<f64>();
    close(&[stage(0), stage(1), stage(2)], &[0.125, 0.125, 0.75]);
    let at_first = over(30, MANUAL, 1).chances();
    close(&at_first, &[&[0.1; 10][..], &[0.0; 20]].concat());
}

#[test]
fn replay_ranks_scores_and_waits_until_enough_was_seen() {
    let mut own = over(4, REPLAY, 1);
    own.score(2, 5.0);
    end(&mut own, 0, 2, false);
    // One of four is less than half: only what is new.
    close(&own.chances(), &[1.0 / 3.0, 1.0 / 3.0, 0.0, 1.0 / 3.0]);
    own.score(0, 9.0);
    end(&mut own, 0, 0, true);
    // Half of the draws are again: ranks 1 and 2 with the weights 1 and 1/2.
    close(&own.chances(), &[0.5 * 2.0 / 3.0, 0.25, 0.5 / 3.0, 0.25]);
    own.score(1, 7.0);
    own.score(3, f64::NAN);
    own.score(3, 1.0);
    // Nothing new is left. The order of scores is 0, 1, 2, 3: weights 1, 1/2, 1/3, 1/4.
    let sum = 1.0 + 0.5 + 1.0 / 3.0 + 0.25;
    close(&own.chances(), &[1.0 / sum, 0.5 / sum, 1.0 / (3.0 * sum), 0.25 / sum]);
}

#[test]
fn replay_comes_back_to_what_was_not_driven_for_long() {
    let mut own = over(3, "kind: replay\nreplay: 1\nseen: 0\nkeep: 0\ntemperature: 1\nstaleness: 1\n", 1);
    (0..3).for_each(|task| {
        own.score(task, 1.0);
        end(&mut own, 0, task, true);
    });
    // Their last episodes were the first, second and third of three.
    close(&own.chances(), &[2.0 / 3.0, 1.0 / 3.0, 0.0]);
}

#[test]
fn it_goes_on_from_what_it_remembered() {
    for text in [LEARNABILITY, REPLAY, MANUAL, "kind: uniform\n"] {
        let mut own = over(30, text, 3);
        let drive = |own: &mut Curriculum, episodes: usize| -> Vec<usize> {
            (0..episodes)
                .map(|k| {
                    let task = own.draw(k % 3);
                    end(own, k % 3, task, !(task + k).is_multiple_of(3));
                    own.score(task, 1.0 / (task + 3) as f64);
                    task
                })
                .collect()
        };
        drive(&mut own, 60);
        let mut again = over(30, text, 3);
        again.restore(&own.state()).unwrap();
        assert_eq!(again.state(), own.state());
        assert_eq!(drive(&mut again, 60), drive(&mut own, 60), "{text}");
    }
}

#[test]
fn the_state_of_another_curriculum_is_refused() {
    let mut own = over(30, MANUAL, 3);
    let before = own.state();
    let others = [over(30, LEARNABILITY, 3).state(), over(30, MANUAL, 2).state(), "{}".into()];
    for other in others {
        assert!(own.restore(&other).unwrap_err().to_string().starts_with("curriculum: state: it "));
        assert_eq!(own.state(), before);
    }
    assert!(over(30, "kind: uniform\n", 3).restore(&over(30, "kind: uniform\n", 2).state()).is_err());
    // As many tasks, but others.
    for text in [LEARNABILITY, REPLAY, MANUAL, "kind: uniform\n"] {
        let (suite, all) = smoke();
        let other = Curriculum::new(&of(text), &suite, &all[1..31], 3, 7).expect("a curriculum");
        assert!(over(30, text, 3).restore(&other.state()).is_err(), "{text}");
    }
    let more = over(29, LEARNABILITY, 3).state();
    assert!(over(30, LEARNABILITY, 3).restore(&more).is_err());
}

/// A state is a text in a checkpoint, which anybody can have written: counts in it are added to and subtracted.
#[test]
fn a_state_with_counts_that_nobody_can_have_counted_is_refused() {
    let mut tried = 0;
    for text in [LEARNABILITY, REPLAY, MANUAL, "kind: uniform\n"] {
        let mut own = over(30, text, 3);
        own.report(&Ending { environment: 0, task: 0, is_success: true });
        let before: serde_json::Value = serde_json::from_str(&own.state()).unwrap();
        let method = before["method"].as_object().and_then(|m| m.keys().next().cloned()).unwrap_or_default();
        let places: &[(&str, serde_json::Value)] = match method.as_str() {
            "manual" => &[
                ("/places/0/stage", 99.into()),
                ("/places/0/episodes", u32::MAX.into()),
                ("/places/0/successes", u32::MAX.into()),
            ],
            "learnability" => &[
                ("/by_task/0/outcomes", 1e308.into()),
                ("/by_task/0/successes", 1e308.into()),
                ("/by_level/0/successes", (-1.0).into()),
            ],
            "replay" => &[("/episodes", u64::MAX.into()), ("/tasks/0/last", u64::MAX.into())],
            _ => &[],
        };
        let mut attack = |place: String, value: &serde_json::Value| {
            let mut state = before.clone();
            *state.pointer_mut(&place).unwrap_or_else(|| panic!("{place} in {before}")) = value.clone();
            assert!(own.restore(&state.to_string()).is_err(), "{place} = {value}");
            tried += 1;
        };
        attack("/drawn/0".into(), &u64::MAX.into());
        for (place, value) in places {
            attack(format!("/method/{method}{place}"), value);
        }
    }
    assert_eq!(tried, 12);
}

#[test]
fn flaws_are_told_with_file_field_and_value() {
    let told = |text: &str| {
        let read = Spec::parse(&format!("schema: 1\nname: mine\n{text}"), "mine.yaml");
        read.err().map_or_else(String::new, |e| e.to_string())
    };
    let changed = |from: &str, old: &str, new: &str| told(&from.replace(old, new));
    let cases = [
        (changed(LEARNABILITY, "explore: 0.2", "explore: 2"), "mine.yaml: explore: 2 must lie in 0 to 1"),
        (changed(LEARNABILITY, "prior: 0.001", ""), "mine.yaml: prior: it is missing"),
        (
            changed(REPLAY, "temperature: 1", "temperature: 0"),
            "mine.yaml: temperature: 0 must lie in 0.01 to 100",
        ),
        (changed(MANUAL, "window: 4", "window: 0"), "mine.yaml: window: 0 must lie in 1 to 1000"),
        (
            changed(MANUAL, "demote: 0.25", "demote: 0.8"),
            "mine.yaml: demote: 0.8 must be less than promote, 0.75",
        ),
        (changed(MANUAL, "w002", "elevation=steep"), "mine.yaml: stages[1]: task selector"),
        (changed(MANUAL, "[w001, w002, w003]", "[]"), "mine.yaml: stages: at least one stage is required"),
        (changed(MANUAL, "w002", "[]"), "mine.yaml: stages[1]: at least one selector is required"),
        (changed(MANUAL, "w002", "{a: b}"), "mine.yaml: stages[1]: want a selector, or a list of selectors"),
        (
            told("kind: uniform\nwindow: 3\n"),
            "mine.yaml: window: a curriculum of kind uniform has no such field",
        ),
        (told("kind: uniform\nlength: 3\n"), "mine.yaml: "),
        (told("kind: hard\n"), "mine.yaml: kind: \"hard\""),
    ];
    for (told, wanted) in cases {
        assert!(told.starts_with(wanted), "{told} instead of {wanted}");
    }
    let (suite, tasks) = smoke();
    let none = Curriculum::new(&of(MANUAL), &suite, &tasks[..10], 1, 0).unwrap_err().to_string();
    assert_eq!(none, "mine: stages[1]: it contains no task of the environment");
    let missing = Spec::resolve("nowhere.yaml").unwrap_err().to_string();
    assert!(missing.starts_with("cannot read curriculum nowhere.yaml: ") && missing.contains("learnability"));
}
