//! Many environments do what each would do alone, on any number of threads.

use vb_env::{Arena, Autoreset, Env, EnvError, Pointer, Reset, VectorEnv};
use vb_sdk::policy::Row;
use vb_world::TaskId;

use crate::common::{arena, options, pursue};

const COUNT: usize = 5;

fn floats(pointer: Pointer, index: usize) -> Vec<f32> {
    match pointer {
        // SAFETY: nothing is at work while a test looks.
        Pointer::F32(at, width) => unsafe {
            std::slice::from_raw_parts(at.add(index * width), width).to_vec()
        },
        _ => panic!("no numbers of 32 bits"),
    }
}

fn number(pointer: Pointer, index: usize) -> f64 {
    match pointer {
        // SAFETY: as above.
        Pointer::F64(at, 1) => unsafe { *at.add(index) },
        _ => panic!("no number"),
    }
}

fn flag(pointer: Pointer, index: usize) -> bool {
    match pointer {
        // SAFETY: as above.
        Pointer::Bool(at, 1) => unsafe { *at.add(index) },
        _ => panic!("no flag"),
    }
}

fn seeds() -> Vec<(usize, Reset)> {
    (0..COUNT).map(|k| (k, Reset { seed: Some(10 + k as u64), ..Reset::default() })).collect()
}

fn wait(env: &mut VectorEnv, count: usize) -> Vec<vb_env::Arrival> {
    env.receive(count, &mut || true).expect("arrivals").expect("all of them")
}

/// Observations, reward and flags of environment 2 over many steps, and what it told.
type Story = Vec<(Vec<f32>, f64, bool, bool, Option<TaskId>, Option<String>)>;

fn story(threads: usize, autoreset: Autoreset, steps: usize) -> Story {
    let mut env = VectorEnv::new(arena(options()), COUNT, threads, autoreset, false).expect("environments");
    env.reset(seeds()).expect("episodes");
    wait(&mut env, COUNT);
    let all: Vec<usize> = (0..COUNT).collect();
    let mut told = Vec::new();
    for _ in 0..steps {
        let output = env.output();
        let action = |k: usize| pursue(&floats(output.observations()[1], k), 1.0);
        let actions: Vec<f64> = all.iter().flat_map(|k| action(*k)).collect();
        env.send(&all, &actions).expect("a step");
        let arrivals = wait(&mut env, COUNT);
        let own = arrivals.iter().find(|a| a.index == 2).expect("all arrive");
        let output = env.output();
        told.push((
            floats(output.observations()[0], 2),
            number(output.rewards(), 2),
            flag(output.terminated(), 2),
            flag(output.truncated(), 2),
            own.began.as_ref().map(|b| b.0.clone()),
            own.ended.as_ref().map(|r| r.state_hash.clone()),
        ));
    }
    told
}

#[test]
fn threads_change_nothing_and_each_does_what_it_would_do_alone() {
    let one = story(1, Autoreset::NextStep, 400);
    assert_eq!(one, story(3, Autoreset::NextStep, 400));
    // Alone: environment 2 has seed 12.
    let mut env = Env::new(arena(options()), 0);
    env.reset(&Reset { seed: Some(12), ..Reset::default() }).unwrap();
    let mut is_over = false;
    let mut episodes = 0;
    for (seen, reward, terminated, truncated, began, ended) in one {
        let (mut state, mut path) = (vec![0.0; 11], vec![0.0; 20]);
        if is_over {
            env.reset(&Reset::default()).unwrap();
            assert_eq!((reward, terminated, truncated, ended), (0.0, false, false, None));
            assert_eq!(began.as_ref(), env.task());
            is_over = false;
        } else {
            env.observe(1, Row::F32(&mut path));
            let step = env.step(&pursue(&path, 1.0)).unwrap();
            assert_eq!((reward, terminated, truncated), (step.reward, step.terminated, step.truncated));
            is_over = terminated || truncated;
            episodes += usize::from(is_over);
            assert_eq!(ended.as_ref(), env.record().map(|r| &r.state_hash));
        }
        env.observe(0, Row::F32(&mut state));
        assert_eq!(seen, state);
    }
    assert!(episodes >= 1, "the test wants an episode that ends");
}

#[test]
fn the_same_step_begins_the_next_episode_and_keeps_the_last_observation() {
    let next = story(2, Autoreset::NextStep, 400);
    let same = story(2, Autoreset::SameStep, 400);
    let end = next.iter().position(|s| s.2 || s.3).unwrap();
    assert_eq!(next[..end], same[..end]);
    // The step after the end of one is the first of the other's new episode.
    assert_eq!(same[end].0, next[end + 1].0);
    assert_eq!((&same[end].4, &same[end].5), (&next[end + 1].4, &next[end].5));
    assert_eq!((same[end].1, same[end].2), (next[end].1, next[end].2));
}

#[test]
fn without_autoreset_an_episode_that_has_ended_is_an_error_until_it_is_reset() {
    let mut env = VectorEnv::new(arena(options()), 1, 1, Autoreset::Disabled, true).unwrap();
    assert!(matches!(env.send(&[0], &[0.0, 0.0]), Err(EnvError::NoEpisode)));
    env.reset(vec![(0, Reset { seed: Some(1), ..Reset::default() })]).unwrap();
    wait(&mut env, 1);
    // Stands until it is stuck.
    loop {
        env.send(&[0], &[0.0, -1.0]).unwrap();
        if wait(&mut env, 1)[0].ended.is_some() {
            break;
        }
    }
    assert!(matches!(env.send(&[0], &[0.0, 0.0]), Err(EnvError::Ended(_))));
    assert_eq!(env.pending(), 0);
    env.reset(vec![(0, Reset::default())]).unwrap();
    assert!(wait(&mut env, 1)[0].began.is_some());
}

#[test]
fn what_is_wrong_is_told_before_anything_is_stepped() {
    let mut env = VectorEnv::new(arena(options()), 2, 2, Autoreset::NextStep, true).unwrap();
    assert!(matches!(env.receive(1, &mut || true), Err(EnvError::Nothing)));
    env.reset(vec![(0, Reset::default()), (1, Reset::default())]).unwrap();
    assert!(matches!(env.send(&[1], &[0.0, 0.0]), Err(EnvError::Pending(2))));
    wait(&mut env, 2);
    let told = |e: Result<(), EnvError>| e.unwrap_err().to_string();
    assert_eq!(told(env.send(&[2], &[0.0, 0.0])), "there is no environment 2: there are 2");
    assert_eq!(told(env.send(&[1, 1], &[0.0; 4])), "environment 1 is given twice");
    assert_eq!(
        told(env.reset(vec![(0, Reset::default()), (0, Reset::default())])),
        "environment 0 is given twice"
    );
    assert!(told(env.send(&[0, 1], &[0.0, 0.0])).contains("an action has 2 numbers"));
    assert!(told(env.send(&[0, 1], &[0.0, 0.0, 0.0, f64::INFINITY])).contains("action[1] (speed) is inf"));
    assert_eq!(env.pending(), 0);
    let of = |arena: &std::sync::Arc<Arena>, count, threads| {
        VectorEnv::new(arena.clone(), count, threads, Autoreset::NextStep, true).err().unwrap().to_string()
    };
    assert_eq!(of(env.arena(), 0, 1), "num_envs: 0: must lie in 1 to 65536");
    assert_eq!(of(env.arena(), 1, 0), "threads: 0: must lie in 1 to 1024");
}

#[test]
fn waiting_ends_when_it_is_not_wanted_and_goes_on_later() {
    let mut env = VectorEnv::new(arena(options()), COUNT, 1, Autoreset::NextStep, true).unwrap();
    env.reset(seeds()).unwrap();
    // Worlds are loaded, which takes longer than a look on most machines; where it doesn't, all is there at once.
    let mut looks = 0;
    let found = env.receive(COUNT, &mut || {
        looks += 1;
        false
    });
    if found.unwrap().is_none() {
        assert_eq!((looks, env.pending()), (1, COUNT));
        // Whoever waits for one alone does none of the work: the worker, whose place was taken, goes on.
        for _ in 0..COUNT {
            let mut looks = 0;
            let one = env.receive(1, &mut || {
                looks += 1;
                looks < 400
            });
            assert!(one.unwrap().is_some(), "nobody works");
        }
    }
    assert_eq!(env.pending(), 0);
}
