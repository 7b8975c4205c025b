//! Ibex, a planner of this benchmark, not of the paper: searches the whole map with learned models and the shape of the vehicle,
//! samples rollouts of an internal forward model, and searches for recovery manoeuvres by simulation.
//!
//! It extends the traversability map of TNT ([`hybrid::Hybrid`]). Each extension has a parameter that disables it:
//! - The map includes the cost of hull contact, which the coarse patches of the networks do not resolve (`stance`).
//! - An internal forward model of the vehicle (`twin`) simulates and evaluates rollouts (`foresight`).
//! - A stuck vehicle reverses and retries with the manoeuvre of minimum simulated cost (`escape`), or, without the
//!   internal model, as in [`vb_sdk::recovery`].
//! - Places where the vehicle got stuck become more expensive, and the cost-to-go is recomputed.
//!
//! Without maps of the world, it drives the internal model along the global path on the local map (`scout`).
//!
//! `docs/planners.md` documents their effects.

mod escape;
mod foresight;
mod scout;
mod stance;
pub mod twin;

use hybrid::{Aim, Hybrid, Learned, Place, Prediction};
use vb_sdk::recovery::{Recovery, Settings};
use vb_sdk::{Command, Observation, Planner, PlannerError, Task, Vehicle, math};

use foresight::Foresight;
use scout::Scout;
use stance::Stances;

hybrid::export_sampling! {
    planner: Ibex,
    name: "ibex",
    about: "MPPI with simulated rollouts over a searched map, and a search for recovery manoeuvres",
    attention: false,
    samples: 256,
    params: {
        lookahead: 12.0 => "normalisation length of the path cost, m at full scale",
        steer_spread: 0.5 => "standard deviation of sampled steering, fraction of full lock",
        effective: 0.03 => "effective sample fraction that the temperature targets",
        goal: 2.0 => "weight of the path cost to the goal",
        tilt: 6.0 => "weight of roll and pitch above `roll` and `pitch`",
        stuck: 8.0 => "weight of the probability of getting stuck",
        over: 30.0 => "weight of the probability of tipping over",
        risk: 0.0 => "CVaR level of the hazard costs `stuck` and `over`, 0 to 0.99; 0: expected cost",
        guided: 0.3 => "fraction of rollouts sampled around a cost-to-go descent, up to 0.9",
        price_stuck: 25.0 => "added path cost per metre at a probability of 1 of getting stuck",
        price_over: 200.0 => "added path cost per metre at a probability of 1 of tipping over",
        price_slow: 1.0 => "added path cost per metre where the target speed is lost within 1 s",
        price_obstacle: 30.0 => "added path cost per metre in contact with an obstacle",
        price_hull: 10.0 => "added path cost per metre with the whole weight on the hull",
        price_tilt: 5.0 => "added path cost per metre for each 0.1 of tilt caused by hull contact, capped at 0.2",
        price_again: 20.0 => "added path cost per metre at a place where the vehicle got stuck before",
        foresight: 128 => "simulated rollouts per control period; 0: learned model only",
        clearance: 0.05 => "hull clearance margin in simulation, m at full scale",
        hull: 4.0 => "weight of the load on the hull in simulated rollouts",
        recover: 1 => "1: reverses and retries when stuck; 0: drives forward only",
    },
    without_maps: { local_map },
}

enum Ibex {
    /// For tasks with maps of the world.
    Searching(Box<Searching>),
    /// For tasks without them.
    Seeing(Box<Scout>),
}

/// The planner with maps.
struct Searching {
    hybrid: Hybrid,
    foresight: Option<Foresight>,
    /// Used without `foresight`.
    recovery: Option<Recovery>,
    vehicle: Vehicle,
    /// Cost of a place where the vehicle got stuck.
    again: f32,
    hurry: f64,
}

/// Tilt with the cost `price_tilt`, and the maximum multiple of that cost.
const TENTH: f32 = 0.1;
const MOST: f32 = 2.0;
/// Radius of increased cost around the front axle of a stuck vehicle, in wheelbases.
const REACH: f64 = 0.8;
/// Increase of the target speed per recovery attempt, as a fraction, and its maximum factor.
const BOOST: f64 = 0.4;
const BOOST_MOST: f64 = 2.0;

/// The factor of the target speed after another recovery.
fn hurried(hurry: f64) -> f64 {
    (hurry + BOOST).min(BOOST_MOST)
}

/// A parameter that must not be negative.
fn weight(task: &Task, key: &str) -> Result<f32, PlannerError> {
    match task.param_f64(key)? {
        value if value >= 0.0 => Ok(value as f32),
        value => Err(PlannerError::new(format!("parameter `{key}`: {value} is below 0"))),
    }
}

impl Planner for Ibex {
    fn init(task: &Task) -> Result<Self, PlannerError> {
        Ok(if scout::is_needed(task) {
            Self::Seeing(Box::new(Scout::new(task)?))
        } else {
            Self::Searching(Box::new(Searching::new(task)?))
        })
    }

    fn step(&mut self, o: &Observation) -> Result<Command, PlannerError> {
        match self {
            Self::Searching(planner) => planner.step(o),
            Self::Seeing(scout) => scout.step(o),
        }
    }
}

impl Searching {
    fn new(task: &Task) -> Result<Self, PlannerError> {
        let vehicle = task.vehicle.clone();
        let price = |key: &str| weight(task, &format!("price_{key}"));
        let (hull, tilt, again) = (price("hull")?, price("tilt")?, price("again")?);
        let heights = task.elevation()?;
        // The planner below reports maps of fewer than 2 x 2 samples.
        let surface = heights.frame.rows.min(heights.frame.cols) > 1;
        let stances = (surface && hull + tilt > 0.0).then(|| Stances::new(heights, &vehicle));
        let extra_cost = stances.map(|stances| {
            move |place: Place| {
                let stance = stances.at(place.row as usize, place.col as usize, place.heading);
                hull * stance.hull + tilt * (stance.tilt / TENTH).min(MOST)
            }
        });
        let prediction = Prediction { learned: Learned::All, attention: false };
        let hybrid = Hybrid::over(task, Aim::Traversability, prediction, extra_cost)?;
        let foresight = Foresight::new(task, heights, task.semantics.as_ref())?;
        let recovery = (foresight.is_none() && task.param_as::<u8>("recover")? != 0)
            .then(|| Recovery::new(task, Settings::default().scaled(vehicle.scale)));
        Ok(Self { hybrid, foresight, recovery, vehicle, again, hurry: 1.0 })
    }

    fn step(&mut self, o: &Observation) -> Result<Command, PlannerError> {
        let command = self.hybrid.step(o)?;
        if let Some(foresight) = &mut self.foresight {
            let (own, stuck) = foresight.step(o, self.hybrid.objective(), &self.hybrid)?;
            if stuck {
                self.was_stuck(o)?;
            }
            return Ok(Command { debug: command.debug, ..own });
        }
        let Some(recovery) = &mut self.recovery else { return Ok(command) };
        let attempts = recovery.attempts();
        let command = recovery.update(o, command);
        if recovery.attempts() > attempts {
            self.was_stuck(o)?;
        }
        Ok(command)
    }

    /// Increases the target speed, and re-plans with a higher cost at the current position.
    fn was_stuck(&mut self, o: &Observation) -> Result<(), PlannerError> {
        self.hurry = hurried(self.hurry);
        self.hybrid.hurry(self.hurry);
        if self.again > 0.0 {
            let pose = o.pose()?;
            let (sin, cos) = math::sin_cos(pose.yaw);
            let front = 0.5 * self.vehicle.wheelbase;
            let (x, y) = (pose.position.x + cos * front, pose.position.y + sin * front);
            let reach = REACH * self.vehicle.wheelbase;
            self.hybrid.avoid(|Place { at, .. }| {
                let near = 1.0 - math::hypot(at.x - x, at.y - y) / reach;
                self.again * near.max(0.0) as f32
            });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
