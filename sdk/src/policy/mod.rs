//! Observations and actions of a learned policy as arrays.
//!
//! A policy is trained in an environment and runs as a plugin. Both must use identical observations and actions, so
//! both use this module: environments and plugins fill observations with an [`Observer`] and convert actions to
//! commands with an [`Actuator`]. An observer uses only data of the planner interface ([`Task`](crate::Task),
//! [`Observation`](crate::Observation)).
//!
//! ```
//! use vb_sdk::policy::{ActionKind, Actuator, Layout, Observer, Sight};
//! # let task = vb_sdk::policy::example_task();
//! let layout = Layout::new(&["state", "path", "height"], Sight::default(), &task)?;
//! let mut observer = Observer::new(&task, &layout)?;
//! let mut actuator = Actuator::new(ActionKind::default(), &task);
//! # let observation = vb_sdk::Observation { pose: Some(Default::default()), ..Default::default() };
//! // At each step:
//! observer.look(&observation);
//! let mut inputs = vec![0.0; layout.flat_width()];
//! observer.flat(&task, &layout, &mut inputs);
//! let action = [0.1, 0.5]; // the policy's answer
//! let command = actuator.command(&action, &observation);
//! # assert!(command.throttle > 0.0);
//! # Ok::<(), vb_sdk::PlannerError>(())
//! ```
//!
//! A policy with networks in a weights file ([`crate::nn`]) needs only [`Trained`].

mod action;
mod export;
mod layout;
mod observer;
#[cfg(test)]
mod tests;
mod trained;

pub use action::{ActionKind, Actuator, Dimension, STEERING_STEP};
pub use layout::{Dtype, Entry, Kind, Layout, PARTS, Part, Sight};
pub use observer::{Observer, Row};
pub use trained::{Numbers, PolicyNetwork, PolicySpec, Trained};

/// A task on flat grass with a straight path of 20 m to the east, for examples and tests.
#[doc(hidden)]
#[must_use]
pub fn example_task() -> crate::Task {
    use crate::{GridFrame, Map, Point2, Task, Vehicle};
    let frame = GridFrame { rows: 65, cols: 65, resolution: 1.0, origin_x: -32.0, origin_y: -32.0 };
    let flat = |value: u8| Map { frame, data: vec![value; 65 * 65] };
    Task {
        id: "w000/t00".into(),
        vehicle: Vehicle { scale: 1.0, wheels: 4, max_speed: 20.0, ..Vehicle::default() },
        elevation: Some(Map { frame, data: vec![0.0; 65 * 65] }),
        semantics: Some(flat(3)),
        occupancy: Some(flat(0)),
        half_extent: Point2 { x: 32.0, y: 32.0 },
        path: vec![Point2 { x: 0.0, y: 0.0 }, Point2 { x: 20.0, y: 0.0 }],
        goal: Point2 { x: 20.0, y: 0.0 },
        goal_radius: 4.0,
        time_limit: 60.0,
        control_period: 0.1,
        perception: "oracle".into(),
        ..Task::default()
    }
}
