//! The tasks of the checks, ready to be driven.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use vb_host::Plugin;
use vb_record::{LogMode, TraceMode};
use vb_score::{Outcome, Rules, TaskRecord};
use vb_sdk::Param;
use vb_sense::rays::Scene;
use vb_sense::{Perception, Profile};
use vb_sim::{SimOptions, SoilSet};
use vb_vehicle::VehicleModel;
use vb_world::World;

use super::{Kit, KitError};
use crate::brief::{Terms, planner_vehicle};
use crate::run::{check_control_period, check_perception};
use crate::shape::static_shape;
use crate::{RunError, Trial};

/// How many tasks are driven at most.
const TASKS: usize = 3;

pub(super) struct Course<'a> {
    tasks: Vec<(Arc<Scene>, Arc<World>, vb_world::Task)>,
    model: VehicleModel,
    vehicle: vb_sdk::Vehicle,
    soils: &'a SoilSet,
    rules: &'a Rules,
    options: SimOptions,
    perception: Profile,
}

impl<'a> Course<'a> {
    pub(super) fn new(kit: &Kit<'a>) -> Result<Self, RunError> {
        let options = SimOptions { soil_resolution: kit.soils.resolution, ..SimOptions::default() };
        let mut tasks = Vec::new();
        for wanted in kit.tasks.iter().take(TASKS) {
            kit.suite.verify_world(&wanted.world)?;
            let world = Arc::new(kit.suite.load_world(&wanted.world)?);
            if let Some(task) = world.task(&wanted.task).cloned() {
                tasks.push((Arc::new(Scene::new(world.clone())), world, task));
            }
        }
        if tasks.is_empty() {
            return Err(RunError::NoTasks);
        }
        let model = VehicleModel::new(kit.vehicle.spec.clone())?;
        let shape = static_shape(&model, options)?;
        let vehicle = planner_vehicle(model.spec(), &shape, 1.0);
        let perception = Profile::oracle();
        Ok(Self { tasks, model, vehicle, soils: &kit.soils.set, rules: kit.rules, options, perception })
    }

    /// Whether a planner can be called at the rate that it wants, and gets what it asks for.
    pub(super) fn fits(&self, plugin: &Plugin) -> Result<(), RunError> {
        check_perception(plugin, &self.perception)?;
        check_control_period(plugin.metadata(), self.options)
    }

    /// The sensors of a task's vehicle, and what a planner is told; where there are fewer tasks, of the last.
    fn setting(
        &self,
        task: usize,
        plugin: &Plugin,
        params: &[Param],
    ) -> Result<(Perception, vb_sdk::Task), RunError> {
        let (scene, world, task) = &self.tasks[task.min(self.tasks.len() - 1)];
        let metadata = plugin.metadata();
        let terms = Terms {
            rules: self.rules,
            scale: 1.0,
            control_period: metadata.control_period,
            seed: 0,
            profile: &self.perception,
        };
        let seed = terms.perception_seed(world, task);
        let perception =
            Perception::new(&self.perception, &metadata.sensors(true), scene, self.model.spec(), &seed)
                .map_err(|source| RunError::Perception { planner: metadata.name.clone(), source })?;
        let brief = terms.brief(world, task, self.vehicle.clone(), params.to_vec(), &perception);
        Ok((perception, brief))
    }

    /// How many tasks there are.
    pub(super) fn len(&self) -> usize {
        self.tasks.len()
    }

    /// What a planner is told of a task; where there are fewer, of the last.
    pub(super) fn brief(
        &self,
        task: usize,
        plugin: &Plugin,
        params: &[Param],
    ) -> Result<vb_sdk::Task, RunError> {
        self.setting(task, plugin, params).map(|(_, brief)| brief)
    }

    /// Drives a task to its end; where there are fewer, the last.
    pub(super) fn drive(
        &self,
        task: usize,
        plugin: &Plugin,
        params: &[Param],
        cancel: &AtomicBool,
    ) -> Result<TaskRecord, KitError> {
        let (perception, brief) = self.setting(task, plugin, params)?;
        let (_, world, task) = &self.tasks[task.min(self.tasks.len() - 1)];
        let trial = Trial {
            world,
            task,
            brief: &brief,
            plugin,
            vehicle: &self.model,
            soils: self.soils,
            options: self.options,
            rules: self.rules,
            trace: TraceMode::None,
            logs: LogMode::default(),
        };
        let record = trial.run(perception, cancel).ok_or(KitError::Cancelled)?.record;
        match record.outcome {
            Outcome::HostError => Err(KitError::Host(record.reason)),
            _ => Ok(record),
        }
    }
}
