//! Calls of a component that exports the planner interface.
//!
//! The window holds one version at present. For an older one, [`Pre`] and [`Planner`] become enums over the versions, with bindings and
//! generated conversions in a module next to [`super::v1_0`] (docs/abi.md).

use vb_sdk::Command;
use wasmtime::Store;
use wasmtime::component::{InstancePre, ResourceAny};

use super::state::State;
use super::v1_0::bindings::vertibench::planner::types;
use super::v1_0::bindings::{PlannerPlugin, PlannerPluginPre};

/// A component whose exports have been checked.
#[derive(Clone)]
pub(super) struct Pre(PlannerPluginPre<State>);

impl Pre {
    /// Checks that a component exports the interface.
    pub(super) fn new(pre: InstancePre<State>) -> wasmtime::Result<Self> {
        PlannerPluginPre::new(pre).map(Self)
    }
}

/// An instance of a component, with its planner.
pub(super) struct Planner {
    plugin: PlannerPlugin,
    planner: ResourceAny,
}

impl Planner {
    /// Makes an instance and calls `init`. The inner error is the planner's own.
    pub(super) fn init(
        pre: &Pre,
        store: &mut Store<State>,
        task: &types::Task,
    ) -> wasmtime::Result<Result<Self, String>> {
        let plugin = pre.0.instantiate(&mut *store)?;
        let planner = plugin.vertibench_planner_guest().planner().call_init(store, task)?;
        Ok(planner.map(|planner| Self { plugin, planner }))
    }

    /// Calls `step`. The inner error is the planner's own.
    pub(super) fn step(
        &self,
        store: &mut Store<State>,
        observation: &types::Observation,
    ) -> wasmtime::Result<Result<Command, String>> {
        let guest = self.plugin.vertibench_planner_guest();
        Ok(guest.planner().call_step(store, self.planner, observation)?.map(Command::from))
    }
}
