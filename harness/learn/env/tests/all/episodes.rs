//! One environment: its episodes are those of the benchmark, and nothing but seed and actions decides them.

use std::sync::atomic::AtomicBool;

use vb_env::{Env, EnvError, Options, Reset, TERMS};
use vb_score::Outcome;
use vb_sdk::policy::{ActionKind, Actuator, Layout, Observer, Row, Sight};
use vb_sdk::{Command, Observation, Task};
use vb_trial::{Driver, DriverFault, Keep, Log, Place, Wants};

use crate::common::{arena, drive, on, options, part, pursue};

/// The policy as a planner that the benchmark drives.
#[derive(Default)]
struct Planner {
    parts: Option<(Task, Layout, Observer, Actuator)>,
}

impl Driver for Planner {
    fn name(&self) -> String {
        "the policy".into()
    }

    fn start(&mut self, brief: &Task, _: Log) -> Result<(), DriverFault> {
        let layout = Layout::new(&["path"], Sight::default(), brief).expect("a layout");
        let observer = Observer::new(brief, &layout).expect("an observer");
        let actuator = Actuator::new(ActionKind::default(), brief);
        self.parts = Some((brief.clone(), layout, observer, actuator));
        Ok(())
    }

    fn step(&mut self, observation: &Observation) -> Result<Command, DriverFault> {
        let (task, layout, observer, actuator) = self.parts.as_mut().expect("a trial starts its driver");
        observer.look(observation);
        let mut path = vec![0.0; 20];
        observer.fill(task, &layout.parts()[0], Row::F32(&mut path));
        Ok(actuator.command(&pursue(&path, 0.0), observation))
    }
}

#[test]
fn actions_out_of_range_are_counted_in_the_record() {
    let arena = arena(options());
    for (action, share) in [([3.0, 5.0], 1), ([1.0, -1.0], 0)] {
        let mut env = Env::new(arena.clone(), 0);
        env.reset(&on("w001/t00")).unwrap();
        while env.record().is_none() {
            env.step(&action).unwrap();
        }
        let record = env.record().unwrap();
        assert_eq!(record.clamped, share * record.planner_steps, "{action:?}");
    }
}

#[test]
fn settings_that_are_not_the_benchmark_s_are_in_the_record() {
    let record = |options: Options| {
        let mut env = Env::new(arena(options), 0);
        env.reset(&on("w001/t00")).unwrap();
        while env.record().is_none() {
            env.step(&[1.0, -1.0]).unwrap();
        }
        env.record().unwrap().departures.clone()
    };
    assert!(record(options()).is_empty());
    let other = Options { time_step: 0.005, rules: "release".into(), ..options() };
    assert_eq!(record(other), ["time step 5 ms", "rules release"]);
}

#[test]
fn a_policy_has_the_same_record_here_as_in_the_benchmark() {
    for perception in ["oracle", "degraded"] {
        let mut options = options();
        options.perception = perception.into();
        options.observation.retain(|part| part == "state" || part == "path");
        let arena = arena(options);
        for task in ["w001/t00", "w002/t01", "w003/t02"] {
            let mut env = Env::new(arena.clone(), 0);
            env.reset(&on(task)).unwrap();
            drive(&mut env, usize::MAX).unwrap();
            let (world, id) = task.split_once('/').unwrap();
            let mut setting = vb_trial::Setting::new(
                &crate::common::catalog().vehicle("hmmwv").unwrap(),
                &crate::common::catalog().soils("default", 0.1).unwrap(),
                &arena.setting().rules,
                &arena.setting().perception,
                0.001,
                1.0,
                5,
            )
            .unwrap();
            setting.seed = 5;
            let place = Place::load(arena.suite(), world, 1.0).unwrap();
            let wants = Wants {
                name: "the policy".into(),
                control_period: 0.1,
                needs: Layout::needs(&["path"]),
                params: Vec::new(),
            };
            let (target, keep) = (place.world.task(id).unwrap().clone(), Keep::default());
            let never = AtomicBool::new(false);
            let driven = setting
                .drive(&place, &target, &wants, &mut Planner::default(), &mut (), keep, &never)
                .unwrap()
                .unwrap();
            assert_eq!(env.record(), Some(&driven.record), "{perception} {task}");
        }
    }
}

#[test]
fn the_reward_is_the_sum_of_its_terms_and_the_way_counts_once() {
    let mut env = Env::new(arena(options()), 0);
    env.reset(&on("w001/t00")).unwrap();
    let length = {
        let brief = env.brief().unwrap();
        let mut points = brief.path.clone();
        points.push(brief.goal);
        points.windows(2).map(|w| vb_math::hypot(w[1].x - w[0].x, w[1].y - w[0].y)).sum::<f64>()
    };
    let steps = drive(&mut env, usize::MAX).unwrap();
    assert_eq!(env.record().unwrap().outcome, Outcome::Success, "the test wants a task that the policy does");
    let total = |name: &str| {
        let k = TERMS.iter().position(|t| t.name == name).unwrap();
        steps.iter().map(|s| s.terms[k]).sum::<f64>()
    };
    assert!(steps.iter().all(|s| (s.reward - s.terms.iter().sum::<f64>()).abs() < 1e-12));
    // tasks/rewards/default.yaml: 10 at the goal, −0.02 a second, 0.1 a metre; the goal is reached 10 m before its middle.
    assert_eq!(total("success"), 10.0);
    assert!((total("time") + 0.02 * env.record().unwrap().time_s).abs() < 1e-9);
    let gained = total("progress") / 0.1;
    assert!(gained < length && gained > length - 14.0, "{gained} m of {length} m");
    assert!(steps.last().unwrap().terminated && !steps.last().unwrap().truncated);
}

#[test]
fn the_limit_of_time_truncates() {
    let mut env = Env::new(arena(options()), 0);
    env.reset(&on("w001/t00")).unwrap();
    // 120 m at 1.8 m/s.
    let last = (0..).find_map(|_| {
        let step = env.step(&pursue(&part(&env, 1), -0.4)).unwrap();
        (step.terminated || step.truncated).then_some(step)
    });
    let record = env.record().unwrap();
    assert_eq!((record.outcome, record.time_s), (Outcome::Timeout, 60.0), "{}", record.reason);
    assert!(last.unwrap().truncated && !last.unwrap().terminated);
    assert!(matches!(env.step(&[0.0, 0.0]), Err(EnvError::Ended(_))));
}

#[test]
fn a_snapshot_goes_on_as_the_environment_did() {
    let mut env = Env::new(arena(options()), 0);
    env.reset(&on("w003/t02")).unwrap();
    drive(&mut env, 30).unwrap();
    let snapshot = env.snapshot();
    let (steps, seen) = (drive(&mut env, 50).unwrap(), part(&env, 0));
    let record = env.record().cloned();
    let mut other = Env::new(env.arena().clone(), 99);
    for env in [&mut env, &mut other] {
        env.restore(&snapshot).unwrap();
        assert_eq!(drive(env, 50).unwrap(), steps);
        assert_eq!((part(env, 0), env.record().cloned()), (seen.clone(), record.clone()));
    }
}

#[test]
fn a_snapshot_is_refused_by_an_environment_with_other_options_and_one_of_no_episode_by_all() {
    let mut env = Env::new(arena(options()), 0);
    assert!(matches!(env.restore(&env.snapshot()), Err(EnvError::NoEpisode)));
    env.reset(&on("w003/t02")).unwrap();
    let snapshot = env.snapshot();
    // Made anew in the same way.
    Env::new(arena(options()), 0).restore(&snapshot).unwrap();
    let others = [
        Options { vehicle: "gator".into(), ..options() },
        Options { tasks: Some("w001".into()), ..options() },
        Options { time_step: 0.002, ..options() },
    ];
    for options in others {
        let mut other = Env::new(arena(options), 0);
        assert!(matches!(other.restore(&snapshot), Err(EnvError::Unlike)));
        assert!(other.task().is_none());
    }
}

#[test]
fn a_snapshot_as_bytes_goes_on_as_the_environment_did() {
    let mut env = Env::new(arena(options()), 0);
    // A drawn task, and others after it, so that the stream of draws matters.
    env.reset(&Reset { seed: Some(4), ..Reset::default() }).unwrap();
    drive(&mut env, 30).unwrap();
    let bytes = env.snapshot().to_bytes().unwrap();
    let steps = drive(&mut env, 50).unwrap();
    let (seen, record) = (part(&env, 0), env.record().cloned());
    env.reset(&Reset::default()).unwrap();
    let next = (env.task().cloned(), env.run_seed());
    // A new arena and environment, as in another process.
    let mut other = Env::new(arena(options()), 99);
    other.restore_from(&bytes).unwrap();
    assert_eq!(other.snapshot().to_bytes().unwrap(), bytes);
    assert_eq!(drive(&mut other, 50).unwrap(), steps);
    assert_eq!((part(&other, 0), other.record().cloned()), (seen, record));
    other.reset(&Reset::default()).unwrap();
    assert_eq!((other.task().cloned(), other.run_seed()), next);
}

#[test]
fn forged_snapshots_are_refused_and_change_nothing() {
    let mut env = Env::new(arena(options()), 0);
    assert!(matches!(env.snapshot().to_bytes(), Err(EnvError::NoEpisode)));
    env.reset(&on("w003/t02")).unwrap();
    drive(&mut env, 5).unwrap();
    let bytes = env.snapshot().to_bytes().unwrap();
    let seen = part(&env, 0);
    for other in [Options { vehicle: "gator".into(), ..options() }, Options { control_hz: 20.0, ..options() }]
    {
        let told = Env::new(arena(other), 0).restore_from(&bytes);
        assert!(matches!(told, Err(EnvError::Unlike)));
    }
    let mut refused = |forged: &[u8]| {
        let told = env.restore_from(forged).expect_err("a forged state").to_string();
        assert_eq!(part(&env, 0), seen, "{told}");
        told
    };
    assert!(refused(b"").starts_with("the state can't be read: it is not a state"));
    assert!(refused(&vec![0; 17 << 20]).contains("at most 16777216 are allowed"));
    for end in 8..bytes.len() {
        refused(&bytes[..end]);
    }
    assert!(refused(&[&bytes[..], b"x"].concat()).contains("invalid bytes"));
    // With another byte it is refused, or leads to the same state: the stream of later tasks may stand anywhere, and the vehicle doesn't
    // feel every action (steering within its delay). The hashes of options and states and the task bear no change.
    let texts = "vbstate1".len() + 1 + 2 + 64 + 1 + "w003/t02".len();
    for k in 0..bytes.len() {
        let mut forged = bytes.clone();
        forged[k] ^= 0x55;
        if env.restore_from(&forged).is_ok() {
            assert!((texts..bytes.len() - 9).contains(&k), "byte {k}");
            assert_eq!(part(&env, 0), seen, "byte {k}");
            assert_eq!(env.snapshot().to_bytes().unwrap(), forged, "byte {k}");
        }
    }
    // An action that is no number, in the place of one that is.
    let mut forged = bytes.clone();
    let at = bytes.windows(9).position(|w| w[0] == 0xcb).expect("an action");
    forged[at + 1..at + 9].copy_from_slice(&f64::NAN.to_be_bytes());
    assert!(env.restore_from(&forged).expect_err("NaN").to_string().contains("action[0]"));
}

#[test]
fn a_drawn_task_that_cannot_be_begun_is_not_drawn_again_and_again() {
    // At a step of 5 ms a car of a tenth of the size can't be simulated on this soil.
    let small = Options { vehicle: "verti4wheeler".into(), time_step: 0.005, ..options() };
    let mut env = Env::new(arena(small), 0);
    let failed = |env: &mut Env, reset: &Reset| match env.reset(reset) {
        Ok(()) => None,
        Err(e) => Some((e.is_divergence(), e.to_string())),
    };
    let first =
        (0..50).find(|seed| failed(&mut env, &Reset { seed: Some(*seed), ..Reset::default() }).is_some());
    let seed = Reset { seed: first, ..Reset::default() };
    let (is_divergence, told) = failed(&mut env, &seed).expect("a start that can't be simulated");
    assert!(is_divergence && told.starts_with("w003/t"), "{told}");
    let next: Vec<_> = (0..20).map(|_| failed(&mut env, &Reset::default()).map(|(_, told)| told)).collect();
    assert!(next.iter().any(Option::is_none), "other tasks can be begun: {next:?}");
}

#[test]
fn seeds_decide_the_tasks_and_noise_is_that_of_the_run_seed() {
    let mut options = options();
    options.perception = "degraded".into();
    options.observation = vec!["state".into(), "pose".into()];
    let arena = arena(options);
    let episodes = |seed: u64| {
        let mut env = Env::new(arena.clone(), 0);
        let mut seen = Vec::new();
        for k in 0..6 {
            let seed = (k == 0).then_some(seed);
            env.reset(&vb_env::Reset { seed, ..vb_env::Reset::default() }).unwrap();
            env.step(&[0.1, 0.5]).unwrap();
            seen.push((env.task().unwrap().to_owned(), env.run_seed().unwrap(), part(&env, 1)));
        }
        seen
    };
    assert_eq!(episodes(1), episodes(1));
    let (one, two) = (episodes(1), episodes(2));
    assert_ne!(one, two);
    let tasks: std::collections::BTreeSet<_> = one.iter().chain(&two).map(|e| &e.0).collect();
    assert!(tasks.len() > 6, "12 draws of 30 tasks: {tasks:?}");
    // The same task with another noise is measured otherwise.
    let pose = |run_seed: u64| {
        let mut env = Env::new(arena.clone(), 0);
        env.reset(&vb_env::Reset { run_seed: Some(run_seed), ..on("w001/t00") }).unwrap();
        env.step(&[0.1, 0.5]).unwrap();
        part(&env, 1)
    };
    assert_eq!(pose(1), pose(1));
    assert_ne!(pose(1), pose(2));
}

#[test]
fn what_is_no_action_changes_nothing() {
    let mut env = Env::new(arena(options()), 0);
    assert!(matches!(env.step(&[0.0, 0.0]), Err(EnvError::NoEpisode)));
    env.reset(&on("w001/t00")).unwrap();
    let told = |e: Result<_, EnvError>| e.unwrap_err().to_string();
    assert_eq!(told(env.step(&[0.0])), "an action has 2 numbers (steering, speed), not 1");
    assert_eq!(told(env.step(&[0.0, f64::NAN])), "action[1] (speed) is NaN: give a finite number");
    let unknown = env.reset(&on("w009/t77")).unwrap_err().to_string();
    assert!(
        unknown.starts_with("there is no task w009/t77 among the 30 tasks") && unknown.contains("w001/t00")
    );
    assert_eq!(env.task().unwrap(), &"w001/t00");
    let steps = drive(&mut env, 20).unwrap();
    env.reset(&on("w001/t00")).unwrap();
    assert_eq!(drive(&mut env, 20).unwrap(), steps);
}
