//! The last seconds of a drive, by which the cause of a failure is judged.

use std::collections::VecDeque;
use std::f64::consts::FRAC_PI_6;

use vb_record::Sample;
use vb_score::cause::{Body, Diagnosis, Moment, Site, WheelMoment, diagnose};
use vb_score::{Outcome, TaskScore};
use vb_sim::VehicleState;
use vb_vehicle::VehicleModel;
use vb_world::{Obstacle, World};

use crate::shape::{Reach, hubs};

/// The time between two moments, s.
const PERIOD: f64 = 0.1;
/// The time that is looked back at scale 1, s: that of the paper's stuck rule.
const WINDOW: f64 = 10.0;
/// The time before a vehicle leans by 30° of which moments are kept while it does, s at scale 1.
const BEFORE: f64 = 2.0;

/// The moments of the last seconds. Where the vehicle has tipped over, those of the seconds before are kept as well, however long
/// ago that was: it lies for a while until the rules decide.
#[derive(Clone, Debug)]
pub(crate) struct Recent {
    pace: f64,
    due: f64,
    moments: VecDeque<Moment>,
    tipping: Vec<Moment>,
}

impl Recent {
    /// Moments of a drive in a world of this scale.
    pub(crate) fn new(scale: f64) -> Self {
        // Times go with the root of lengths.
        Self { pace: scale.sqrt(), due: 0.0, moments: VecDeque::new(), tipping: Vec::new() }
    }

    /// Takes the state of a sample, if a moment is due.
    pub(crate) fn push(&mut self, state: &VehicleState, sample: &Sample) {
        // Times are sums of steps.
        if sample.time + 1e-6 < self.due {
            return;
        }
        self.due = sample.time + PERIOD;
        let moment = moment(state, sample);
        if moment.tilt() <= FRAC_PI_6 {
            self.tipping.clear();
        } else if self.tipping.is_empty() {
            let begin = moment.time - BEFORE * self.pace;
            self.tipping.extend(self.moments.iter().filter(|m| m.time >= begin).cloned());
            self.tipping.push(moment.clone());
        }
        self.moments.push_back(moment);
        let begin = sample.time - WINDOW * self.pace;
        while self.moments.front().is_some_and(|m| m.time < begin) {
            self.moments.pop_front();
        }
    }

    /// Why a trial failed; none if it did not roll over or get stuck.
    pub(crate) fn diagnose(
        &self,
        score: &TaskScore,
        vehicle: &VehicleModel,
        world: &World,
    ) -> Option<Diagnosis> {
        let rolled_over = match score.outcome {
            Outcome::Rollover => true,
            Outcome::Stuck => false,
            _ => return None,
        };
        let obstacles: Vec<_> = world.obstacles.iter().map(Obstacle::footprint).collect();
        let site = Site { obstacles: &obstacles, ground: &world.heightfield };
        let moments: Vec<Moment> = if rolled_over && !self.tipping.is_empty() {
            self.tipping.clone()
        } else {
            self.moments.iter().cloned().collect()
        };
        Some(diagnose(&moments, &body(vehicle, world.scale), site, rolled_over))
    }
}

/// A vehicle as judgements know it.
fn body(model: &VehicleModel, scale: f64) -> Body {
    let (spec, reach) = (model.spec(), Reach::of(model));
    Body {
        mass: spec.total_mass(),
        front: reach.high[0],
        rear: -reach.low[0],
        half_width: reach.high[1].max(-reach.low[1]),
        wheels: hubs(model).concat(),
        wheel_radius: spec.axles.first().map_or(0.0, |axle| spec.tyre_of(axle).radius()),
        scale,
    }
}

fn moment(state: &VehicleState, sample: &Sample) -> Moment {
    let wheels = state.wheels.iter();
    Moment {
        time: sample.time,
        position: [sample.x, sample.y, sample.z],
        roll: sample.roll,
        pitch: sample.pitch,
        yaw: sample.yaw,
        velocity: [sample.vx, sample.vy, sample.vz],
        yaw_rate: sample.wz,
        throttle: sample.throttle,
        reverse: sample.gear == Sample::REVERSE,
        wheels: wheels.map(|w| WheelMoment { spin: w.speed, load: w.load, sinkage: w.sinkage }).collect(),
    }
}
