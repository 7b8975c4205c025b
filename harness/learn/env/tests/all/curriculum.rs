//! A curriculum chooses the tasks of many environments, whatever the threads do.

use vb_env::curriculum::Spec;
use vb_env::{Autoreset, EnvError, Pointer, Reset, VectorEnv};

use crate::common::{arena, options, pursue};

const COUNT: usize = 4;

/// Smoke's first three worlds, from which an environment moves on with each episode that ends at the goal.
fn spec() -> Spec {
    let text = "schema: 1\nname: worlds\nkind: manual\nstages: [w001, w002, w003]\nwindow: 1\npromote: 1\ndemote: -1\nreview: 0.3\n";
    Spec::parse(text, "worlds.yaml").expect("a curriculum")
}

fn path(env: &VectorEnv, index: usize) -> Vec<f32> {
    match env.output().observations()[1] {
        // SAFETY: nothing is at work while a test looks.
        Pointer::F32(at, width) => unsafe {
            std::slice::from_raw_parts(at.add(index * width), width).to_vec()
        },
        _ => panic!("no numbers of 32 bits"),
    }
}

fn following(threads: usize, autoreset: Autoreset) -> VectorEnv {
    let mut env = VectorEnv::new(arena(options()), COUNT, threads, autoreset, false).expect("environments");
    env.follow(&spec(), 3).expect("a curriculum");
    env.reset((0..COUNT).map(|k| (k, Reset { seed: Some(k as u64), ..Reset::default() })).collect())
        .expect("episodes");
    env
}

/// Drives on; what each environment began, and what it ended with.
fn drive(env: &mut VectorEnv, steps: usize, told: &mut Vec<(usize, String)>) {
    let all: Vec<usize> = (0..COUNT).collect();
    for _ in 0..steps {
        let actions: Vec<f64> = all.iter().flat_map(|k| pursue(&path(env, *k), 1.0)).collect();
        env.send(&all, &actions).expect("a step");
        listen(env, told);
    }
}

fn listen(env: &mut VectorEnv, told: &mut Vec<(usize, String)>) {
    let mut arrivals = env.receive(COUNT, &mut || true).expect("arrivals").expect("all of them");
    arrivals.sort_by_key(|a| a.index);
    for arrival in arrivals {
        told.extend(
            arrival
                .ended
                .map(|record| (arrival.index, format!("{}: {}", record.task, record.outcome.name()))),
        );
        told.extend(arrival.began.map(|(task, _)| (arrival.index, task.to_string())));
    }
}

fn story(threads: usize, autoreset: Autoreset) -> Vec<(usize, String)> {
    let mut env = following(threads, autoreset);
    let mut told = Vec::new();
    listen(&mut env, &mut told);
    drive(&mut env, 500, &mut told);
    told
}

#[test]
fn what_is_driven_next_depends_on_how_episodes_ended_and_not_on_threads() {
    for autoreset in [Autoreset::SameStep, Autoreset::NextStep] {
        let one = story(1, autoreset);
        assert_eq!(one, story(3, autoreset));
        // All begin in the first world; whoever came to its goal moves on with the episode after the next, which was chosen before.
        assert!(one[..COUNT].iter().all(|(_, task)| task.starts_with("w001/")), "{one:?}");
        let tasks = |k: usize| one.iter().filter(move |(index, told)| *index == k && !told.contains(':'));
        let ends =
            |k: usize| one.iter().filter(move |(index, told)| *index == k && told.contains(": success"));
        let moved = (0..COUNT).filter(|k| tasks(*k).any(|(_, task)| !task.starts_with("w001/")));
        assert!(moved.clone().count() > 0, "{one:?}");
        assert!(moved.clone().all(|k| ends(k).count() > 0), "{one:?}");
    }
}

#[test]
fn it_goes_on_from_what_the_curriculum_remembered() {
    let begun = |again: bool| {
        let mut env = following(2, Autoreset::SameStep);
        let mut told = Vec::new();
        listen(&mut env, &mut told);
        drive(&mut env, 300, &mut told);
        let state = env.curriculum().expect("one").state();
        if again {
            env = following(1, Autoreset::SameStep);
            listen(&mut env, &mut Vec::new());
        }
        env.restore_curriculum(&state).expect("its own state");
        env.reset((0..COUNT).map(|k| (k, Reset { seed: Some(k as u64), ..Reset::default() })).collect())
            .expect("episodes");
        told.clear();
        listen(&mut env, &mut told);
        drive(&mut env, 300, &mut told);
        (told, env.curriculum().expect("one").state())
    };
    assert_eq!(begun(true), begun(false));
}

#[test]
fn a_task_that_is_named_is_driven_and_the_chosen_one_waits() {
    let mut env = following(1, Autoreset::Disabled);
    let mut told = Vec::new();
    listen(&mut env, &mut told);
    let reset = |task: Option<&str>| {
        vec![(0, Reset { task: task.map(|t| t.parse().expect("a task")), ..Reset::default() })]
    };
    let mut begin = |task| {
        env.reset(reset(task)).expect("an episode");
        let arrivals = env.receive(1, &mut || true).expect("arrivals").expect("one");
        arrivals[0].began.clone().expect("it began").0
    };
    assert_eq!(begin(Some("w003/t05")), "w003/t05");
    let chosen = begin(None);
    assert!(chosen.world() == "w001", "{chosen}");
}

#[test]
fn what_is_wrong_is_told() {
    let mut env = following(1, Autoreset::SameStep);
    assert!(matches!(env.follow(&spec(), 0), Err(EnvError::Pending(COUNT))));
    assert!(matches!(env.restore_curriculum("{}"), Err(EnvError::Pending(COUNT))));
    listen(&mut env, &mut Vec::new());
    let state = env.curriculum().expect("one").state();
    assert!(env.restore_curriculum("{}").unwrap_err().to_string().starts_with("curriculum: state: "));
    assert_eq!(env.curriculum().expect("one").state(), state);
    assert!(matches!(env.score(&"w099/t00".parse().expect("a task"), 1.0), Err(EnvError::NoTask { .. })));
}
