//! A minimal policy of an environment of `vertibench.envs` as a planner.
//!
//! It observes the part `path` and returns the action `speed`, both from [`vb_sdk::policy`] as in the environment, so that its
//! commands are bit-identical to those there (`harness/python/tests/test_policy.py` compares them). A trained policy replaces
//! [`act`] by its network (`vb_sdk::nn`), and lists the parts of its training.

use vb_sdk::policy::{ActionKind, Actuator, Layout, Observer, Sight};
use vb_sdk::{Command, Observation, Planner, PlannerError, Task};

vb_sdk::export_planner! {
    planner: Policy,
    name: "policy",
    about: "A policy of an environment: steers to the path 6 m ahead",
    control_period: 0.1,
    params: { speed: 0.0 => "speed action, from -1 (0 m/s) to 1 (6 m/s)" },
    needs: { pose }
}

/// The planner.
pub struct Policy {
    task: Task,
    layout: Layout,
    observer: Observer,
    actuator: Actuator,
    speed: f64,
}

/// The action for an observation: steering, and the given speed.
#[must_use]
pub fn act(path: &[f32], speed: f64) -> [f64; 2] {
    // Metres forward and to the left of the third point, which is 6 m ahead along the path.
    let (forward, left) = (f64::from(path[4]), f64::from(path[5]));
    [(1.5 * left / forward.abs().max(1.0)).clamp(-1.0, 1.0), speed]
}

impl Planner for Policy {
    fn init(task: &Task) -> Result<Self, PlannerError> {
        let layout = Layout::new(&["path"], Sight::default(), task)?;
        Ok(Self {
            observer: Observer::new(task, &layout)?,
            actuator: Actuator::new(ActionKind::default(), task),
            speed: task.param_f64("speed")?,
            layout,
            task: task.clone(),
        })
    }

    fn step(&mut self, observation: &Observation) -> Result<Command, PlannerError> {
        self.observer.look(observation);
        let path = &self.layout.parts()[0];
        let mut numbers = vec![0.0; path.width()];
        self.observer.fill(&self.task, path, vb_sdk::policy::Row::F32(&mut numbers));
        Ok(self.actuator.command(&act(&numbers, self.speed), observation))
    }
}
