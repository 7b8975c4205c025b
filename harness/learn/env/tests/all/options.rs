//! Options: what makes no sense is told by its name and value, and no suite's world is trained on.

use std::path::PathBuf;

use vb_env::{Arena, Options};
use vb_sdk::policy::{ActionKind, Sight};

use crate::common::{catalog, options, refused};

#[test]
fn what_makes_no_sense_is_told_by_name_and_value() {
    let told = |change: fn(&mut Options)| {
        let mut o = options();
        change(&mut o);
        refused(o)
    };
    assert!(told(|o| o.control_hz = 30.0).starts_with("control_hz: 30: must be 100 over"));
    assert!(told(|o| o.control_hz = f64::NAN).starts_with("control_hz: NaN"));
    assert!(
        told(|o| o.observation = vec!["hights".into()])
            .starts_with("observation: hights: unknown part; parts: state,")
    );
    assert!(told(|o| o.observation.clear()).contains("at least one part"));
    assert!(
        told(|o| o.sight = Sight { cells: 0, ..Sight::default() })
            .contains("sight: cells: 0 must lie in 2 to 256")
    );
    let backwards = |o: &mut Options| o.action = ActionKind::Speed { slowest: 3.0, fastest: 1.0 };
    assert!(told(backwards).starts_with("speed_range: (3, 1): must be two speeds"));
    assert!(
        told(|o| o.vehicle = "tank".into()).starts_with("there is no vehicle tank (give a file, or one of:")
    );
    assert!(told(|o| o.suite = Some("vb-1000".into())).starts_with("there is no suite vb-1000"));
    assert!(told(|o| o.tasks = Some("w777".into())).contains("w777"));
    assert!(told(|o| o.scale = Some(-1.0)).contains("a scale of -1 is not in 0.01 to 10"));
    assert!(told(|o| o.perception = "psychic".into()).contains("there is no perception profile psychic"));
    assert!(told(|o| o.rules = "mine".into()).contains("mine"));
    let training = |seed: u64, worlds: u32| {
        refused(Options { suite: None, tasks: None, world_seed: seed, worlds, ..options() })
    };
    assert!(training(1, 1).contains("seed 1: training worlds need a seed from 7000 to 7999"));
    assert!(training(7000, 0).starts_with("worlds: 0: must lie in 1 to 1000"));
}

#[test]
fn a_world_of_a_suite_is_not_trained_on() {
    let cache = tempfile::tempdir().unwrap();
    let catalog = catalog().keeping_in(cache.path());
    let make = |options| Arena::new(&catalog, options, &mut || {});
    let train = |apart_from: Vec<PathBuf>| Options {
        suite: None,
        tasks: None,
        worlds: 1,
        world_seed: 7999,
        apart_from,
        ..options()
    };
    let made = make(train(Vec::new())).unwrap();
    assert_eq!(made.tasks().len(), 10);
    let hidden = made.suite().dir().to_owned();
    let told = make(train(vec![hidden])).err().unwrap().to_string();
    assert!(
        told.starts_with("w001 of the training worlds is world w001 of the evaluation suite training-7999"),
        "{told}"
    );
    assert!(catalog.suites().unwrap().len() >= 2);
}
