//! Ibex, a planner of our own: it searches the whole map with what it has learned of the ground and with the shape of the vehicle,
//! simulates before it drives, and where it is stuck it searches for a way out by simulation, too.
//!
//! It has the map of traversability of TNT ([`hybrid::Hybrid`]), and four things more, each of which has a parameter that turns it off:
//! - The map has the price of what the networks can't see well: a hull that bears the vehicle (`stance`).
//! - It has a simulation of the vehicle of its own (`twin`), through which it draws and weighs courses (`foresight`).
//! - A vehicle that doesn't get on backs out and comes again by the manoeuvre that ends best in the simulation (`escape`), or, without
//!   one, as [`vb_sdk::recovery`] does.
//! - Where it was stuck is dearer from then on, and the way to the goal is searched again.
//!
//! Where a task comes without maps of the world, there is nothing to search: the twin drives along the global path on what the vehicle
//! sees of the ground (`scout`).
//!
//! `docs/planners.md` tells what each of them is worth.

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
    about: "Searches the whole map, simulates courses before it drives one, and searches for a way out where it is stuck",
    attention: false,
    samples: 256,
    params: {
        lookahead: 12.0 => "length of way that the cost of the way is measured in, m at full scale",
        steer_spread: 0.5 => "standard deviation of drawn steering, of full steering",
        effective: 0.03 => "share of the courses that the temperature gives a say",
        goal: 2.0 => "weight of the cost of the way to the goal",
        tilt: 6.0 => "weight of roll and pitch",
        stuck: 8.0 => "weight of the probability of getting stuck",
        over: 30.0 => "weight of the probability of tipping over",
        risk: 0.0 => "level in [0, 0.99] of the conditional value at risk at which these two are priced; 0 prices what is to be expected",
        guided: 0.3 => "part of the courses that is drawn about a descent on the map of traversability, up to 0.9",
        price_stuck: 25.0 => "length of way, over its own, that a probability of one to get stuck is worth avoiding",
        price_over: 200.0 => "the same of a probability to tip over",
        price_slow: 1.0 => "the same of losing all speed within a second",
        price_obstacle: 30.0 => "the same of touching an obstacle",
        price_hull: 10.0 => "the same of a hull that bears the whole vehicle",
        price_tilt: 5.0 => "the same of a hull that tilts the vehicle by a tenth",
        price_again: 20.0 => "the same of a place where the vehicle was stuck before",
        foresight: 128 => "courses that are simulated every control period; 0 to drive by what is learned alone",
        clearance: 0.05 => "by how much lower than it is the hull is simulated, m at full scale",
        hull: 4.0 => "weight of a hull that bears the whole vehicle, where courses are simulated",
        recover: 1 => "whether it backs out where it is stuck; 0 for a planner that only drives forward",
    },
    without_maps: { local_map },
}

enum Ibex {
    /// Where the task has maps of the world.
    Searching(Box<Searching>),
    /// Where it hasn't.
    Seeing(Box<Scout>),
}

/// The planner with maps.
struct Searching {
    hybrid: Hybrid,
    foresight: Option<Foresight>,
    /// Without foresight.
    recovery: Option<Recovery>,
    vehicle: Vehicle,
    /// The price of a place where the vehicle was stuck.
    again: f32,
    hurry: f64,
}

/// The tilt that has its price once, and how often it has it at most.
const TENTH: f32 = 0.1;
const MOST: f32 = 2.0;
/// How far around a place where the vehicle was stuck the ground is dearer, in wheelbases. Its front wheels are the place.
const REACH: f64 = 0.8;
/// The share of the target speed by which it aims higher after each attempt to get free, and the most that it comes to.
const BOOST: f64 = 0.4;
const BOOST_MOST: f64 = 2.0;

/// How much a vehicle hurries that has been stuck once more, as a multiple of the target speed.
fn hurried(hurry: f64) -> f64 {
    (hurry + BOOST).min(BOOST_MOST)
}

/// The parameter of this name, which is 0 or above.
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
        // Of a map that is no surface, the planner below tells.
        let surface = heights.frame.rows.min(heights.frame.cols) > 1;
        let stances = (surface && hull + tilt > 0.0).then(|| Stances::new(heights, &vehicle));
        let dearer = stances.map(|stances| {
            move |place: Place| {
                let stance = stances.at(place.row as usize, place.col as usize, place.heading);
                hull * stance.hull + tilt * (stance.tilt / TENTH).min(MOST)
            }
        });
        let prediction = Prediction { learned: Learned::All, attention: false };
        let hybrid = Hybrid::over(task, Aim::Traversability, prediction, dearer)?;
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

    /// Hurries more, and plans a way round where it is.
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
