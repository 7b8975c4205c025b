//! What the trials of a run have in common, and how each is made of it.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use vb_record::{DataHeader, LogMode, TraceMode};
use vb_score::{Conditions, Rules, StartRule};
use vb_sdk::Param;
use vb_sdk::metadata::Need;
use vb_sense::rays::Scene;
use vb_sense::{Perception, Profile};
use vb_sim::{SAMPLE_PERIOD, SimOptions, SoilSet, Soils, Start, Surroundings};
use vb_vehicle::{SCALES, Vehicle, VehicleModel};
use vb_world::{Suite, SuiteError, Task, World};

use crate::brief::{Terms, planner_vehicle};
use crate::driver::{Driver, Witness};
use crate::shape::static_shape;
use crate::{Trial, TrialError, TrialResult};

/// A world, and what sensors see of it.
#[derive(Clone)]
pub struct Place {
    /// The world, scaled.
    pub world: Arc<World>,
    /// The world as vehicles run into it.
    pub surroundings: Surroundings,
    /// The world as sensors see it.
    pub scene: Arc<Scene>,
}

impl Place {
    /// A world as a place; lengths are multiplied by the scale.
    #[must_use]
    pub fn new(world: World, scale: f64) -> Self {
        let world = Arc::new(world.at_scale(scale));
        Self { surroundings: world.clone().into(), scene: Arc::new(Scene::new(world.clone())), world }
    }

    /// A world of a suite.
    ///
    /// # Errors
    /// Returns an error if the world can't be read or isn't the one that the suite's index states.
    pub fn load(suite: &Suite, world: &str, scale: f64) -> Result<Self, SuiteError> {
        Ok(Self::new(suite.load_world(world)?, scale))
    }
}

/// Whether trials can have this time step, s: it lies in 0.1 to 5 ms, and the time between two samples is a whole number of steps.
#[must_use]
pub fn is_time_step(step: f64) -> bool {
    vb_record::is_time_step(step, SAMPLE_PERIOD)
}

/// Everything but place, task and driver that decides the result of a trial.
pub struct Setting {
    /// The vehicle, with its linkages solved.
    pub model: VehicleModel,
    /// The vehicle as drivers are told of it.
    pub vehicle: vb_sdk::Vehicle,
    /// The soils of deformable ground.
    pub soils: SoilSet,
    pub rules: Rules,
    /// The settings by which the simulation is stepped.
    pub options: SimOptions,
    /// What is known of the world, and how well.
    pub perception: Profile,
    /// The factor on every length of the worlds.
    pub scale: f64,
    /// The seed of all that is random.
    pub seed: u64,
    /// The settings that aren't the benchmark's, in words ([`Conditions::departures`]).
    pub departures: Vec<String>,
}

/// What a driver asks for.
#[derive(Clone, Debug)]
pub struct Wants {
    /// The name of the driver, for messages.
    pub name: String,
    /// The time between its steps, s.
    pub control_period: f64,
    /// The sensors that it needs.
    pub needs: Vec<Need>,
    /// Its parameters.
    pub params: Vec<Param>,
}

/// What is kept of a trial.
#[derive(Clone, Copy, Debug, Default)]
pub struct Keep {
    /// The samples of the trace.
    pub trace: TraceMode,
    /// Whether the record has the planner's log.
    pub logs: LogMode,
}

/// The way in which the simulator starts a trial under a rule, in a world of this scale.
#[must_use]
pub fn start(rule: StartRule, scale: f64) -> Start {
    match rule {
        StartRule::Settled => Start::Settled,
        StartRule::Dropped { height_m, raster_stretch } => {
            Start::Dropped { height: height_m * scale, stretch: raster_stretch }
        }
    }
}

impl Setting {
    /// A setting; `time_step` is that of the simulation, s.
    ///
    /// # Errors
    /// Returns an error if no world has such a scale, or the vehicle can't be simulated.
    pub fn new(
        vehicle: &Vehicle,
        soils: &Soils,
        rules: &Rules,
        perception: &Profile,
        time_step: f64,
        scale: f64,
        seed: u64,
    ) -> Result<Self, TrialError> {
        if !SCALES.contains(&scale) {
            return Err(TrialError::Scale(scale));
        }
        let options = SimOptions {
            step: time_step,
            soil_resolution: soils.resolution,
            start: start(rules.start, scale),
            ..SimOptions::default()
        };
        let conditions = Conditions {
            vehicle: DataHeader { name: vehicle.spec.name.clone(), hash: vehicle.hash.clone() },
            scale,
            time_step,
            soils: DataHeader { name: soils.set.name.clone(), hash: soils.hash.clone() },
            soil_resolution: soils.resolution,
            ..Conditions::standard().clone()
        };
        let departures = conditions.under(rules).departures();
        let model = VehicleModel::new(vehicle.spec.clone())?;
        let shape = static_shape(&model, options)?;
        let vehicle = planner_vehicle(model.spec(), &shape, scale);
        let (soils, rules, perception) = (soils.set.clone(), rules.clone(), perception.clone());
        Ok(Self { model, vehicle, soils, rules, options, perception, scale, seed, departures })
    }

    /// Checks that the vehicle can drive over the granular beds of a world, which is as it is stored, at scale 1.
    ///
    /// # Errors
    /// Returns an error if grains are larger than its wheels.
    pub fn check_beds(&self, world: &World) -> Result<(), TrialError> {
        let spec = self.model.spec();
        let radii = spec.axles.iter().map(|axle| spec.tyre_of(axle).radius());
        Ok(vb_sim::check_grains(world, radii.fold(f64::INFINITY, f64::min) / self.scale)?)
    }

    /// The sensors of a task's vehicle, and what its driver is told.
    ///
    /// # Errors
    /// Returns an error if the perception profile doesn't offer what the driver asks for.
    pub fn brief(
        &self,
        place: &Place,
        task: &Task,
        wants: &Wants,
    ) -> Result<(Perception, vb_sdk::Task), TrialError> {
        self.brief_in(place, task, wants, self.seed)
    }

    /// As [`Self::brief`], in a run with this seed instead of the setting's own.
    ///
    /// # Errors
    /// Returns an error if the perception profile doesn't offer what the driver asks for.
    pub fn brief_in(
        &self,
        place: &Place,
        task: &Task,
        wants: &Wants,
        seed: u64,
    ) -> Result<(Perception, vb_sdk::Task), TrialError> {
        let terms = self.terms(wants, seed);
        let perception = self.perception(place, task, wants, seed)?;
        let brief = terms.brief(&place.world, task, self.vehicle.clone(), wants.params.clone(), &perception);
        Ok((perception, brief))
    }

    /// The sensors of a task's vehicle, in a run with this seed instead of the setting's own.
    ///
    /// # Errors
    /// Returns an error if the perception profile doesn't offer what the driver asks for.
    pub fn perception(
        &self,
        place: &Place,
        task: &Task,
        wants: &Wants,
        seed: u64,
    ) -> Result<Perception, TrialError> {
        let seed = self.terms(wants, seed).perception_seed(&place.world, task);
        Perception::new(&self.perception, &wants.needs, &place.scene, self.model.spec(), &seed)
            .map_err(|source| TrialError::Perception { planner: wants.name.clone(), source })
    }

    fn terms(&self, wants: &Wants, seed: u64) -> Terms<'_> {
        Terms {
            rules: &self.rules,
            scale: self.scale,
            control_period: wants.control_period,
            seed,
            profile: &self.perception,
        }
    }

    /// A task of a place as a trial, of which its driver is told this.
    #[must_use]
    pub fn trial<'a>(
        &'a self,
        place: &'a Place,
        task: &'a Task,
        brief: &'a vb_sdk::Task,
        keep: Keep,
    ) -> Trial<'a> {
        Trial {
            surroundings: &place.surroundings,
            task,
            brief,
            vehicle: &self.model,
            soils: &self.soils,
            options: self.options,
            rules: &self.rules,
            trace: keep.trace,
            logs: keep.logs,
            departures: &self.departures,
        }
    }

    /// Lets a driver drive a task; `None` if `cancel` was set before the end came.
    ///
    /// # Errors
    /// Returns an error if the perception profile doesn't offer what the driver asks for.
    #[allow(clippy::too_many_arguments, reason = "each is a role of its own in a trial")]
    pub fn drive(
        &self,
        place: &Place,
        task: &Task,
        wants: &Wants,
        driver: &mut dyn Driver,
        witness: &mut dyn Witness,
        keep: Keep,
        cancel: &AtomicBool,
    ) -> Result<Option<TrialResult>, TrialError> {
        let (perception, brief) = self.brief(place, task, wants)?;
        let trial = self.trial(place, task, &brief, keep);
        Ok(trial.run(driver, perception, witness, cancel))
    }
}
