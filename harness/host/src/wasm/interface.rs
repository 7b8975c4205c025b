//! The planner interface in each of its versions: what a component must export, and how it is called.

use vb_sdk::{Command, Observation, Task};
use vb_worker::v0_1::{command as from_v0_1, observation as to_v0_1_observation, task as to_v0_1_task};
use wasmtime::Store;
use wasmtime::component::{InstancePre, ResourceAny};

use super::session::State;
use super::{v0_1, v0_2};
use crate::abi::AbiVersion;

/// A component that has been checked for a version of the interface.
#[derive(Clone)]
pub(super) enum Pre {
    V0_1(v0_1::bindings::PlannerPluginPre<State>),
    V0_2(v0_2::bindings::PlannerPluginPre<State>),
}

impl Pre {
    /// Checks that a component exports what its version wants.
    pub(super) fn new(abi: AbiVersion, pre: InstancePre<State>) -> wasmtime::Result<Self> {
        Ok(match abi {
            AbiVersion::V0_1 => Self::V0_1(v0_1::bindings::PlannerPluginPre::new(pre)?),
            AbiVersion::V0_2 => Self::V0_2(v0_2::bindings::PlannerPluginPre::new(pre)?),
        })
    }
}

/// A task in the terms of a version.
pub(super) enum Brief {
    V0_1(Box<v0_1::bindings::vertibench::planner::types::Task>),
    V0_2(Box<v0_2::bindings::vertibench::planner::types::Task>),
}

impl Brief {
    pub(super) fn new(pre: &Pre, task: &Task) -> Self {
        match pre {
            Pre::V0_1(_) => Self::V0_1(Box::new(v0_1::convert::task(&to_v0_1_task(task)))),
            Pre::V0_2(_) => Self::V0_2(Box::new(task.into())),
        }
    }
}

/// An observation in the terms of a version.
pub(super) enum Sight {
    V0_1(Box<v0_1::bindings::vertibench::planner::types::Observation>),
    V0_2(Box<v0_2::bindings::vertibench::planner::types::Observation>),
}

/// An instance of a component, with its planner.
pub(super) enum Planner {
    V0_1(v0_1::bindings::PlannerPlugin, ResourceAny),
    V0_2(v0_2::bindings::PlannerPlugin, ResourceAny),
}

impl Planner {
    /// Makes an instance and calls `init`. The inner error is the planner's own.
    pub(super) fn init(
        pre: &Pre,
        store: &mut Store<State>,
        task: &Brief,
    ) -> wasmtime::Result<Result<Self, String>> {
        Ok(match (pre, task) {
            (Pre::V0_1(pre), Brief::V0_1(task)) => {
                let plugin = pre.instantiate(&mut *store)?;
                let planner = plugin.vertibench_planner_guest().planner().call_init(store, task)?;
                planner.map(|planner| Self::V0_1(plugin, planner))
            }
            (Pre::V0_2(pre), Brief::V0_2(task)) => {
                let plugin = pre.instantiate(&mut *store)?;
                let planner = plugin.vertibench_planner_guest().planner().call_init(store, task)?;
                planner.map(|planner| Self::V0_2(plugin, planner))
            }
            _ => wasmtime::bail!("the task is of another version than the plugin"),
        })
    }

    /// An observation in the terms of the planner's version.
    pub(super) fn sight(&self, observation: &Observation) -> Sight {
        match self {
            Self::V0_1(..) => {
                let observation = v0_1::convert::observation(&to_v0_1_observation(observation));
                Sight::V0_1(Box::new(observation))
            }
            Self::V0_2(..) => Sight::V0_2(Box::new(observation.into())),
        }
    }

    /// Calls `step`. The inner error is the planner's own.
    pub(super) fn step(
        &self,
        store: &mut Store<State>,
        sight: &Sight,
    ) -> wasmtime::Result<Result<Command, String>> {
        Ok(match (self, sight) {
            (Self::V0_1(plugin, planner), Sight::V0_1(sight)) => {
                let guest = plugin.vertibench_planner_guest();
                let command = guest.planner().call_step(store, *planner, sight)?;
                command.map(|command| from_v0_1(v0_1::convert::command(command)))
            }
            (Self::V0_2(plugin, planner), Sight::V0_2(sight)) => {
                let guest = plugin.vertibench_planner_guest();
                guest.planner().call_step(store, *planner, sight)?.map(Command::from)
            }
            _ => wasmtime::bail!("the observation is of another version than the plugin"),
        })
    }
}
