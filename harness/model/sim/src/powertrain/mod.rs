//! From throttle and brakes to the wheels' spins: engine, converter, gearbox, driveline.

mod converter;
mod driveline;
mod gearbox;
mod sides;

use crate::state::Gear;
use converter::FreeEngine;
pub(crate) use driveline::Wheels;
use driveline::{Driveline, Input};
use gearbox::Shifter;
use sides::Sides;
use vb_vehicle::{
    VehicleSpec,
    powertrain::{Engine, Powertrain},
    skid::Skid,
};

/// What an engine does at the input shaft of the gearbox in one step.
#[derive(Clone, Copy, Debug, Default)]
struct Coupling {
    /// N m.
    torque: f64,
    /// Fall of the torque with the shaft's speed, N m s.
    drag: f64,
    /// Inertia that turns with the shaft, kg m².
    inertia: f64,
}

/// The state of the engine and its shafts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DriveState {
    /// The gear: counted from 1 forwards, 0 in neutral and while a change of direction interrupts the torque, −1 in
    /// reverse.
    pub gear: i32,
    /// The speed of the engine, rad/s. One without a converter turns with the gearbox: it has no idle speed, and 0 stands
    /// for its speed in neutral, where nothing is known of it.
    pub engine_speed: f64,
    /// The torque of the engine, N m; negative when it drags.
    pub engine_torque: f64,
    /// The speed of the gearbox' output shaft, rad/s, positive when the vehicle rolls forward.
    pub shaft_speed: f64,
    /// The torque on the gearbox' output shaft, N m, positive when it pushes the vehicle forward.
    pub shaft_torque: f64,
    /// The power that engine and gearbox gave to the output shaft in the last step, W; negative when they drag. It is that of all
    /// motors where each side has its own.
    pub power: f64,
}

/// What the driver asks of a powertrain in one step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Demand {
    /// In [0, 1], after the governor.
    pub(crate) throttle: f64,
    pub(crate) gear: Gear,
    /// Speed of the vehicle over ground, positive forwards, m/s.
    pub(crate) speed: f64,
    /// The steering command, in [-1, 1], which only motors of the sides follow.
    pub(crate) steering: f64,
}

/// What a powertrain has to move.
pub(crate) struct Load<'a> {
    pub(crate) powertrain: &'a Powertrain,
    /// Of the whole vehicle, kg.
    pub(crate) mass: f64,
    /// Of the driven wheels, or of what drives the tracks, m.
    pub(crate) radius: f64,
    /// Pairs of wheels, front to back.
    pub(crate) pairs: Vec<Pair>,
    /// If the vehicle is steered by the speeds of its wheels.
    pub(crate) skid: Option<Skid>,
}

/// Two wheels, or two sprockets, on one axle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pair {
    /// Of one wheel about its axle with all that turns with it, kg m².
    pub(crate) inertia: f64,
    pub(crate) driven: bool,
}

impl<'a> Load<'a> {
    /// The wheels of a vehicle without tracks.
    pub(crate) fn wheels(v: &'a VehicleSpec) -> Self {
        let driven = v.axles.iter().find(|a| a.driven).map_or(&v.tyre, |a| v.tyre_of(a));
        Self {
            powertrain: &v.powertrain,
            mass: v.total_mass(),
            radius: driven.radius(),
            pairs: v.axles.iter().map(|a| Pair { inertia: a.spin_inertia, driven: a.driven }).collect(),
            skid: v.skid,
        }
    }
}

/// The whole powertrain with its state.
#[derive(Clone, Debug)]
pub(crate) struct Drive {
    engine: Engine,
    free: Option<FreeEngine>,
    shifter: Shifter,
    driveline: Driveline,
    /// The motors of the sides, in the place of engine and driveline.
    sides: Option<Box<Sides>>,
    /// The vehicle's inertia as the output shaft feels it, kg m².
    vehicle_inertia: f64,
    state: DriveState,
    /// That the output shaft has got from the gearbox since the start, J.
    work: f64,
}

impl Drive {
    pub(crate) fn new(load: &Load<'_>) -> Self {
        let p = load.powertrain;
        let driveline = Driveline::new(&p.driveline, &load.pairs);
        let lever = load.radius / driveline.reduction();
        let free = p.converter.as_ref().map(|c| FreeEngine::new(c, &p.engine));
        let engine_speed = free.as_ref().map_or(0.0, |f| f.speed);
        let sides = load.skid.map(|skid| {
            let inertias: Vec<f64> = load.pairs.iter().map(|pair| pair.inertia).collect();
            Box::new(Sides::new(skid, p, &inertias, load.radius))
        });
        Self {
            engine: p.engine.clone(),
            free,
            shifter: Shifter::new(&p.gearbox),
            driveline,
            sides,
            vehicle_inertia: load.mass * lever * lever,
            work: 0.0,
            state: DriveState { gear: 1, engine_speed, ..DriveState::default() },
        }
    }

    /// Puts in a direction and a forward gear, counted from 1, the highest there is at most; an engine that turns freely gets
    /// the speed, rad/s.
    #[cfg(feature = "rig")]
    pub(crate) fn engage(&mut self, direction: Gear, gear: usize, engine_speed: f64) {
        self.shifter.engage(direction, gear);
        if let Some(free) = &mut self.free {
            free.speed = engine_speed;
        }
    }

    pub(crate) fn gear(&self) -> Gear {
        self.shifter.direction()
    }

    pub(crate) fn state(&self) -> DriveState {
        self.state
    }

    /// Work that the output shaft has got from engine and gearbox since the start, J; drag takes from it.
    pub(crate) fn work(&self) -> f64 {
        self.work
    }

    /// Energy of all that turns from the output shaft to the wheels, J; `spin` gives those of the wheels, rad/s.
    pub(crate) fn energy(&self, spin: impl Fn(usize) -> f64) -> f64 {
        match &self.sides {
            Some(sides) => sides.energy(spin),
            None => self.driveline.energy(spin),
        }
    }

    /// All numbers that the next step depends on, beside the wheels' spins.
    pub(crate) fn inner_state(&self) -> impl Iterator<Item = f64> + '_ {
        let free = self.free.iter().flat_map(|f| [f.speed, f64::from(u8::from(f.bridged))]);
        self.shifter.inner_state().chain(free)
    }

    /// Advances the spins of all wheels, the engine and the gear by `dt`.
    pub(crate) fn advance(&mut self, demand: &Demand, wheels: &mut Wheels<'_>, dt: f64) {
        let pending = self.shifter.select(demand.gear, demand.speed, dt);
        // Until the direction is in that the driver asks for, the engine doesn't push in another.
        let throttle = if pending { 0.0 } else { demand.throttle };
        if self.sides.is_some() {
            self.turn_sides(&Demand { throttle, ..*demand }, wheels, dt);
            return;
        }
        let shaft = self.driveline.shaft_speed(wheels.spins);
        let ratio = self.shifter.ratio();
        let input = shaft / ratio;
        let neutral = self.shifter.direction() == Gear::Neutral;
        let interrupts = self.shifter.interrupts();
        // While a shift interrupts the torque the throttle is closed; in neutral nothing is shifted under load.
        let pressed = if interrupts && !neutral { 0.0 } else { throttle };
        let (coupling, friction, engine_torque) = match &mut self.free {
            Some(free) if neutral => (Coupling::default(), 0.0, free.turn_alone(&self.engine, pressed, dt)),
            Some(free) => {
                let (coupling, torque) = free.prepare(&self.engine, pressed, input, dt);
                (coupling, 0.0, torque)
            }
            None if neutral => (Coupling::default(), 0.0, 0.0),
            None => rigid(&self.engine, pressed, input),
        };
        let given = if interrupts {
            Input::default()
        } else {
            Input {
                torque: coupling.torque / ratio,
                // It opposes the motion whatever the sign of the ratio.
                friction: friction / ratio.abs(),
                drag: coupling.drag / (ratio * ratio),
                inertia: coupling.inertia / (ratio * ratio),
            }
        };
        let held = self.driveline.advance(given, wheels, dt);
        let after = self.driveline.shaft_speed(wheels.spins);
        if let Some(free) = &mut self.free
            && !neutral
        {
            free.finish((after - shaft) / ratio);
        }
        let torque = given.torque - given.drag * (after - shaft) - held;
        // What spins up the engine does not reach the shaft.
        let work = dt * 0.5 * (shaft + after) * (torque - given.inertia * (after - shaft) / dt);
        self.work += work;
        self.shifter.sense(torque - self.vehicle_inertia * (after - shaft) / dt, dt);
        let turning = if neutral { 0.0 } else { input.abs() };
        self.state = DriveState {
            gear: self.shifter.number(),
            engine_speed: self.free.as_ref().map_or(turning, |f| f.speed),
            engine_torque,
            shaft_speed: after,
            shaft_torque: torque,
            power: work / dt,
        };
        let engine = &self.engine;
        self.shifter.shift(input.abs(), |speed, r| engine.torque(speed, throttle) / r);
    }

    /// A step in which motors turn the sides.
    fn turn_sides(&mut self, demand: &Demand, wheels: &mut Wheels<'_>, dt: f64) {
        let Some(sides) = &self.sides else { return };
        let direction = self.shifter.direction();
        let done = sides.advance(&self.engine, direction, demand, wheels, dt);
        self.work += done.work;
        let motors = sides.motor_speed(done.spin).abs();
        let per_motor = if direction == Gear::Reverse { -1.0 } else { 1.0 } / sides.motor_speed(1.0);
        self.state = DriveState {
            gear: self.shifter.number(),
            engine_speed: if direction == Gear::Neutral { 0.0 } else { motors },
            engine_torque: done.torque * per_motor,
            shaft_speed: sides.shaft_speed(done.spin),
            shaft_torque: done.torque / sides.shaft_speed(1.0),
            power: done.work / dt,
        };
    }

    /// Makes the wheels of the left and the right side turn at these speeds (rad/s), or lets the motors turn them again. Returns
    /// whether the vehicle has motors for its sides.
    #[cfg(feature = "rig")]
    pub(crate) fn prescribe(&mut self, spins: Option<[f64; 2]>) -> bool {
        let Some(sides) = &mut self.sides else { return false };
        sides.prescribe(spins);
        true
    }
}

/// An engine that turns with the input shaft: coupling, greatest drag and torque, N m. The input speed is positive while the
/// vehicle moves in the direction of its gear.
///
/// It drives in that direction only; what is drag opposes the motion either way, and holds at rest. A shift brings it to the
/// new gear's speed at once, at the expense of its clutch and fuel: the vehicle feels no jerk.
fn rigid(engine: &Engine, throttle: f64, input: f64) -> (Coupling, f64, f64) {
    let law = engine.torque_and_slopes(input.abs(), throttle);
    let opposes = law.torque < 0.0 || input >= 0.0;
    let coupling = Coupling {
        torque: law.torque.max(0.0),
        drag: if opposes { (-law.by_speed).max(0.0) } else { 0.0 },
        inertia: engine.inertia(),
    };
    (coupling, (-law.torque).max(0.0), law.torque)
}

#[cfg(test)]
mod tests;
