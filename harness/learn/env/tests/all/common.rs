//! Arenas, and a policy, for all tests.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use vb_catalog::Catalog;
use vb_env::{Arena, Env, EnvError, Options, Reset, Reward, Step};

pub(crate) fn catalog() -> Catalog {
    Catalog::at(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tasks"))
}

/// Tasks of the suite smoke: low ground that the policy does, and the others.
pub(crate) fn options() -> Options {
    Options {
        suite: Some(PathBuf::from("smoke")),
        tasks: Some("w001-w003".into()),
        observation: ["state", "path", "height", "class"].map(str::to_owned).to_vec(),
        reward: Reward::resolve("default").expect("a reward"),
        ..Options::default()
    }
}

pub(crate) fn arena(options: Options) -> Arc<Arena> {
    Arc::new(Arena::new(&catalog(), options, &mut || {}).expect("an arena"))
}

pub(crate) fn refused(options: Options) -> String {
    match Arena::new(&catalog(), options, &mut || {}) {
        Ok(_) => panic!("the options are taken"),
        Err(e) => e.to_string(),
    }
}

pub(crate) fn on(task: &str) -> Reset {
    Reset { seed: Some(3), task: Some(task.parse().expect("a task")), run_seed: Some(5) }
}

/// Steers to the third point of the path, 6 m ahead, at a speed of the command's.
pub(crate) fn pursue(path: &[f32], speed: f64) -> [f64; 2] {
    let (forward, left) = (f64::from(path[4]), f64::from(path[5]));
    [(1.5 * left / forward.abs().max(1.0)).clamp(-1.0, 1.0), speed]
}

pub(crate) fn path(env: &Env) -> Vec<f32> {
    part(env, 1)
}

pub(crate) fn part(env: &Env, index: usize) -> Vec<f32> {
    let mut to = vec![0.0; env.arena().layout().parts()[index].width()];
    env.observe(index, vb_sdk::policy::Row::F32(&mut to));
    to
}

/// Drives to the end, or for so many steps.
pub(crate) fn drive(env: &mut Env, most: usize) -> Result<Vec<Step>, EnvError> {
    let mut steps = Vec::new();
    while steps.len() < most {
        let step = env.step(&pursue(&path(env), 0.0))?;
        steps.push(step);
        if step.terminated || step.truncated {
            break;
        }
    }
    Ok(steps)
}
