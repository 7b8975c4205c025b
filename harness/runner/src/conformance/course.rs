//! The tasks of the checks, ready to be driven.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use vb_host::Plugin;
use vb_record::{LogMode, TraceMode};
use vb_score::{Outcome, Rules, TaskRecord};
use vb_sdk::Param;
use vb_sim::{SimOptions, SoilSet};
use vb_vehicle::VehicleModel;
use vb_world::World;

use super::{Kit, KitError};
use crate::brief::{Terms, planner_task, planner_vehicle};
use crate::run::check_control_period;
use crate::shape::static_shape;
use crate::{RunError, Trial};

/// How many tasks are driven at most.
const TASKS: usize = 3;

pub(super) struct Course<'a> {
    tasks: Vec<(Arc<World>, vb_world::Task)>,
    model: VehicleModel,
    vehicle: vb_sdk::Vehicle,
    soils: &'a SoilSet,
    rules: &'a Rules,
    options: SimOptions,
}

impl<'a> Course<'a> {
    pub(super) fn new(kit: &Kit<'a>) -> Result<Self, RunError> {
        let options = SimOptions { soil_resolution: kit.soils.resolution, ..SimOptions::default() };
        let mut tasks = Vec::new();
        for wanted in kit.tasks.iter().take(TASKS) {
            kit.suite.verify_world(&wanted.world)?;
            let world = Arc::new(kit.suite.load_world(&wanted.world)?);
            if let Some(task) = world.task(&wanted.task).cloned() {
                tasks.push((world, task));
            }
        }
        if tasks.is_empty() {
            return Err(RunError::NoTasks);
        }
        let model = VehicleModel::new(kit.vehicle.spec.clone())?;
        let shape = static_shape(&model, options)?;
        let vehicle = planner_vehicle(model.spec(), &shape, 1.0);
        Ok(Self { tasks, model, vehicle, soils: &kit.soils.set, rules: kit.rules, options })
    }

    /// Whether a planner can be called at the rate that it wants.
    pub(super) fn fits(&self, plugin: &Plugin) -> Result<(), RunError> {
        check_control_period(plugin.metadata(), self.options)
    }

    /// How many tasks there are.
    pub(super) fn len(&self) -> usize {
        self.tasks.len()
    }

    /// What a planner is told of a task; where there are fewer, of the last.
    pub(super) fn brief(&self, task: usize, plugin: &Plugin, params: &[Param]) -> vb_sdk::Task {
        let (world, task) = &self.tasks[task.min(self.tasks.len() - 1)];
        let brief = planner_task(world, task, self.vehicle.clone(), params.to_vec());
        let control_period = plugin.metadata().control_period;
        Terms { rules: self.rules, scale: 1.0, control_period, seed: 0 }.applied_to(brief)
    }

    /// Drives a task to its end; where there are fewer, the last.
    pub(super) fn drive(
        &self,
        task: usize,
        plugin: &Plugin,
        params: &[Param],
        cancel: &AtomicBool,
    ) -> Result<TaskRecord, KitError> {
        let brief = self.brief(task, plugin, params);
        let (world, task) = &self.tasks[task.min(self.tasks.len() - 1)];
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
        let record = trial.run(cancel).ok_or(KitError::Cancelled)?.record;
        match record.outcome {
            Outcome::HostError => Err(KitError::Host(record.reason)),
            _ => Ok(record),
        }
    }
}
