//! The tasks of the checks, ready to be driven.

use std::sync::atomic::AtomicBool;

use vb_host::Plugin;
use vb_record::{LogMode, TraceMode};
use vb_score::{Outcome, TaskRecord};
use vb_sdk::Param;
use vb_sense::Profile;

use super::{Kit, KitError};
use vb_trial::defaults::TIME_STEP;
use vb_trial::{Keep, Place, Setting, Wants};

use crate::run::{check_control_period, check_perception};
use crate::{PluginDriver, RunError, wants};

/// How many tasks are driven at most.
const TASKS: usize = 3;

pub(super) struct Course {
    tasks: Vec<(Place, vb_world::Task)>,
    setting: Setting,
}

impl Course {
    pub(super) fn new(kit: &Kit<'_>) -> Result<Self, RunError> {
        let mut tasks = Vec::new();
        for wanted in kit.tasks.iter().take(TASKS) {
            kit.suite.verify_world(wanted.world())?;
            let place = Place::load(kit.suite, wanted.world(), 1.0)?;
            if let Some(task) = place.world.task(wanted.task()).cloned() {
                tasks.push((place, task));
            }
        }
        if tasks.is_empty() {
            return Err(RunError::NoTasks);
        }
        let perception = Profile::oracle();
        let setting = Setting::new(kit.vehicle, kit.soils, kit.rules, &perception, TIME_STEP, 1.0, 0)?;
        Ok(Self { tasks, setting })
    }

    /// Whether a planner can be called at the rate that it wants, and gets what it asks for.
    pub(super) fn fits(&self, plugin: &Plugin) -> Result<(), RunError> {
        check_perception(plugin, &self.setting.perception)?;
        check_control_period(plugin.metadata(), TIME_STEP)
    }

    /// How many tasks there are.
    pub(super) fn len(&self) -> usize {
        self.tasks.len()
    }

    fn wants(&self, plugin: &Plugin, params: &[Param]) -> Wants {
        wants(plugin, &self.setting.perception, params.to_vec())
    }

    /// What a planner is told of a task; where there are fewer, of the last.
    pub(super) fn brief(
        &self,
        task: usize,
        plugin: &Plugin,
        params: &[Param],
    ) -> Result<vb_sdk::Task, RunError> {
        let (place, task) = &self.tasks[task.min(self.tasks.len() - 1)];
        Ok(self.setting.brief(place, task, &self.wants(plugin, params))?.1)
    }

    /// Drives a task to its end; where there are fewer, the last.
    pub(super) fn drive(
        &self,
        task: usize,
        plugin: &Plugin,
        params: &[Param],
        cancel: &AtomicBool,
    ) -> Result<TaskRecord, KitError> {
        let (place, task) = &self.tasks[task.min(self.tasks.len() - 1)];
        let (wants, mut driver) = (self.wants(plugin, params), PluginDriver::new(plugin));
        let keep = Keep { trace: TraceMode::None, logs: LogMode::default() };
        let driven = self
            .setting
            .drive(place, task, &wants, &mut driver, &mut (), keep, cancel)
            .map_err(RunError::from)?;
        let record = driven.ok_or(KitError::Cancelled)?.record;
        match record.outcome {
            Outcome::HostError => Err(KitError::Host(record.reason)),
            _ => Ok(record),
        }
    }
}
