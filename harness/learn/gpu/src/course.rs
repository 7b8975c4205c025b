//! What fleets drive: the tasks of a suite, with one vehicle.

use std::path::Path;

use vb_catalog::Catalog;
use vb_kernel::wire::{Place, Setting};
use vb_score::Rules;
use vb_trial::defaults::SOIL_RESOLUTION;
use vb_world::{Task, World};

use crate::Start;

#[derive(Debug, thiserror::Error)]
pub enum CourseError {
    #[error(transparent)]
    Catalog(#[from] vb_catalog::CatalogError),
    #[error(transparent)]
    Selector(#[from] vb_world::SelectorError),
    #[error(transparent)]
    Suite(#[from] vb_world::SuiteError),
    #[error(transparent)]
    Document(#[from] vb_files::DocumentError),
    #[error(transparent)]
    Trial(#[from] vb_trial::TrialError),
    #[error(
        "time_step: {0:?} s (must lie in 0.0001 to 0.005 s and divide 0.01 s, e.g. 0.001, the benchmark's, or 0.005)"
    )]
    TimeStep(f64),
    #[error("world {0} has granular beds, which GPU environments do not support: choose other tasks")]
    Beds(String),
}

/// Tasks of a suite with one vehicle, by the rules of the benchmark.
pub struct Course {
    /// The vehicle, its soils, and how it is stepped.
    pub setting: vb_trial::Setting,
    /// The worlds, at the vehicle's scale.
    pub worlds: Vec<World>,
    /// The tasks, each with the number of its world.
    pub tasks: Vec<(usize, Task)>,
}

impl Course {
    /// The tasks of this suite that a selector chooses, or all of them. Suite and vehicle are names or files, as for
    /// `vb-harness run`. The time step (s) is the benchmark's, [`TIME_STEP`](crate::TIME_STEP), or another one, whose states aren't the benchmark's.
    pub fn new(
        catalog: &Catalog,
        suite: &Path,
        tasks: Option<&str>,
        vehicle: &str,
        time_step: f64,
    ) -> Result<Self, CourseError> {
        if !vb_trial::is_time_step(time_step) {
            return Err(CourseError::TimeStep(time_step));
        }
        let suite = catalog.open_suite(Some(suite))?;
        let (vehicle, soils) = (catalog.vehicle(vehicle)?, catalog.soils("default", SOIL_RESOLUTION)?);
        let (rules, perception) = (Rules::resolve("paper")?, catalog.perception("oracle")?);
        let scale = vehicle.spec.scale;
        let setting = vb_trial::Setting::new(&vehicle, &soils, &rules, &perception, time_step, scale, 0)?;
        let (mut worlds, mut chosen) = (Vec::<World>::new(), Vec::new());
        for id in vb_catalog::select(&suite, tasks)? {
            let world = match worlds.iter().position(|world| world.id == id.world()) {
                Some(known) => known,
                None if suite.has_beds(id.world()) => return Err(CourseError::Beds(id.world().to_owned())),
                None => {
                    worlds.push(suite.load_world(id.world())?.at_scale(scale));
                    worlds.len() - 1
                }
            };
            chosen.extend(worlds[world].task(id.task()).map(|task| (world, task.clone())));
        }
        Ok(Self { setting, worlds, tasks: chosen })
    }

    /// What the kernels are told.
    #[must_use]
    pub fn sent(&self) -> Setting {
        Setting {
            vehicle: self.setting.model.spec().clone(),
            soils: self.setting.soils.clone(),
            options: self.setting.options,
            worlds: self.worlds.iter().map(Place::from).collect(),
        }
    }

    #[must_use]
    pub fn starts(&self) -> Vec<Start> {
        self.tasks.iter().map(|(world, task)| Start { world: *world, pose: task.start }).collect()
    }

    #[must_use]
    pub fn names(&self) -> Vec<String> {
        self.tasks.iter().map(|(world, task)| self.worlds[*world].task_id(task).to_string()).collect()
    }
}
