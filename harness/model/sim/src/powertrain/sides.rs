//! Skid steering on wheels: motors that turn the two sides at different speeds.
//!
//! A *unit* is what a pair of motors turns: all wheels of the two sides if those of a side turn together, else the wheels of an
//! axle. A motor's law is that of every engine ([`rigid`]), at the speed of its own side. The steering command moves a torque t
//! from the inner to the outer side: a torque of its own, or gain · (asked difference of the spins − difference after the
//! step). With Coulomb friction of motors and brakes, and with the motors' limits, the difference after the step is a
//! piecewise linear function of t that never falls, so that t is the only root of a rising function, found by bracketed secants
//! (Illinois; Dowell and Jarratt 1971).

use super::{Demand, Wheels, rigid};
use crate::state::Gear;
use vb_vehicle::{
    powertrain::{Differential, Engine, Powertrain},
    skid::Skid,
    table::interpolate,
};

/// Iterations at most; the root lies on a straight piece, where a secant hits it.
const MOST: usize = 60;
/// Torque to which t is found, of the greatest torque of a motor.
const CONVERGED: f64 = 1e-10;

/// The wheels that a pair of motors turns.
#[derive(Clone, Debug)]
struct Unit {
    /// The first of its axles, and how many there are.
    axles: std::ops::Range<usize>,
    /// Part of the torque of all motors.
    share: f64,
    /// Of all that turns at a side, about the axle, kg m².
    inertia: f64,
}

/// The motors of both sides.
#[derive(Clone, Debug)]
pub(super) struct Sides {
    units: Vec<Unit>,
    skid: Skid,
    /// Of the wheels, m.
    radius: f64,
    /// Speed of a motor over the spin of its wheels.
    gearing: f64,
    /// Speed of the gearbox' output shaft over the spin of the wheels.
    shaft: f64,
    /// Of each wheel, kg m².
    wheel_inertias: Vec<f64>,
    /// Prescribed speeds of the left and right wheels after each step, rad/s: a setting of the test rig, not part of the state.
    #[cfg(feature = "rig")]
    prescribed: Option<[f64; 2]>,
}

/// A side in one step.
#[derive(Clone, Copy, Debug, Default)]
struct Side {
    /// Momentum about the axle before the motors act, with the tyres' impulse, N m s.
    momentum: f64,
    /// Inertia with the implicit part of the motor's drag, kg m².
    inertia: f64,
    /// What the throttle asks for, N m.
    push: f64,
    /// Least and greatest torque of the motors, N m.
    limits: [f64; 2],
    /// Greatest impulse of friction and brakes, N m s.
    held: f64,
}

impl Side {
    /// The spin after a step of `dt` (s) with this torque of the motors.
    fn after(&self, torque: f64, dt: f64) -> f64 {
        let momentum = self.momentum + dt * torque;
        (momentum - vb_math::clamp(momentum, -self.held, self.held)) / self.inertia
    }
}

/// Torques of the motors of both sides if t moves from the left to the right: what the throttle asks for, shifted on both sides
/// alike as far as the limits ask for.
fn allocate(sides: &[Side; 2], t: f64) -> [f64; 2] {
    let wanted = [sides[0].push - t, sides[1].push + t];
    let room = |k: usize| {
        let [a, b] = [0, 1].map(|i| sides[i].limits[k] - wanted[i]);
        if k == 0 { a.max(b) } else { a.min(b) }
    };
    let (low, high) = (room(0), room(1));
    let shift = if low <= high { 0.0_f64.clamp(low, high) } else { 0.5 * (low + high) };
    [0, 1].map(|i| vb_math::clamp(wanted[i] + shift, sides[i].limits[0], sides[i].limits[1]))
}

/// What the motors did in a step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Done {
    /// Mean spin of the wheels after the step, rad/s.
    pub(super) spin: f64,
    /// Torque of all motors on the wheels, N m.
    pub(super) torque: f64,
    /// Work of the motors, J.
    pub(super) work: f64,
}

impl Sides {
    /// The motors of a vehicle whose axles have these wheels, of this radius (m).
    pub(super) fn new(skid: Skid, p: &Powertrain, wheel_inertias: &[f64], radius: f64) -> Self {
        let line = &p.driveline;
        let final_drive = line.axles.first().map_or(1.0, |a| a.final_drive);
        let gearing = 1.0 / (final_drive * p.gearbox.ratios.first().copied().unwrap_or(1.0));
        let shaft = 1.0 / final_drive;
        let common = 0.5 * (line.shaft_inertia * shaft * shaft + p.engine.inertia() * gearing * gearing);
        let unit = |axles: std::ops::Range<usize>| {
            let share: f64 = line.axles[axles.clone()].iter().map(|a| a.fraction).sum();
            let of = |i: usize| {
                let a = &line.axles[i];
                wheel_inertias[i] + 0.5 * (a.box_inertia + a.shaft_inertia * shaft * shaft)
            };
            let inertia = axles.clone().map(of).sum::<f64>() + share * common;
            Unit { axles, share, inertia }
        };
        let n = line.axles.len();
        let together = line.centre == Differential::Locked {};
        let units = if together { vec![unit(0..n)] } else { (0..n).map(|i| unit(i..i + 1)).collect() };
        let wheel_inertias = wheel_inertias.iter().flat_map(|i| [*i; 2]).collect();
        Self {
            units,
            skid,
            radius,
            gearing,
            shaft,
            wheel_inertias,
            #[cfg(feature = "rig")]
            prescribed: None,
        }
    }

    /// Makes the wheels of each side turn at these speeds from now on (rad/s), or lets the motors turn them again.
    #[cfg(feature = "rig")]
    pub(super) fn prescribe(&mut self, spins: Option<[f64; 2]>) {
        self.prescribed = spins;
    }

    /// The speeds at which a test rig makes the wheels of each side turn, rad/s; `None` where the motors turn them.
    #[cfg(feature = "rig")]
    fn prescribed(&self) -> Option<[f64; 2]> {
        self.prescribed
    }

    /// `None`: only a test rig prescribes speeds.
    #[cfg(not(feature = "rig"))]
    fn prescribed(&self) -> Option<[f64; 2]> {
        None
    }

    /// Mean spin of the wheels, rad/s.
    fn mean(spins: &[f64]) -> f64 {
        spins.iter().sum::<f64>() / spins.len() as f64
    }

    /// Speed of the gearbox' output shaft at a mean spin of the wheels, rad/s.
    pub(super) fn shaft_speed(&self, spin: f64) -> f64 {
        self.shaft * spin
    }

    /// Speed of the motors at a spin of the wheels, rad/s.
    pub(super) fn motor_speed(&self, spin: f64) -> f64 {
        self.gearing * spin
    }

    /// Energy of all that turns with the wheels, J.
    pub(super) fn energy(&self, spin: impl Fn(usize) -> f64) -> f64 {
        let of = |u: &Unit| {
            [0, 1]
                .map(|side| spin(2 * u.axles.start + side))
                .map(|w| 0.5 * u.inertia * w * w)
                .iter()
                .sum::<f64>()
        };
        self.units.iter().map(of).sum()
    }

    /// Advances the spins of all wheels by `dt` (s) with the motors in a direction.
    pub(super) fn advance(
        &self,
        engine: &Engine,
        direction: Gear,
        demand: &Demand,
        wheels: &mut Wheels<'_>,
        dt: f64,
    ) -> Done {
        let mut done = Done::default();
        let mean = Self::mean(wheels.spins);
        for unit in &self.units {
            let before = [0, 1].map(|side| wheels.spins[2 * unit.axles.start + side]);
            let wheels_of = |side: usize| unit.axles.clone().map(move |a| 2 * a + side);
            let moments = [0, 1].map(|side| wheels_of(side).map(|i| wheels.moments[i]).sum::<f64>());
            let after = if let Some(spins) = self.prescribed() {
                for side in [0, 1] {
                    let torque = unit.inertia * (spins[side] - before[side]) / dt - moments[side];
                    done.torque += torque;
                    done.work += dt * 0.5 * (before[side] + spins[side]) * torque;
                }
                spins
            } else {
                let sides = [0, 1].map(|side| {
                    let brakes: f64 = wheels_of(side).map(|i| wheels.brakes[i]).sum();
                    let inertia = unit.inertia;
                    let mut s = Side {
                        momentum: inertia * before[side] + dt * moments[side],
                        inertia,
                        ..Side::default()
                    };
                    s.held = dt * brakes;
                    self.motors(&mut s, unit.share, engine, direction, demand.throttle, before[side], dt);
                    s
                });
                let t = self.moved(&sides, unit.share, direction, demand.steering, mean, dt);
                let torques = if direction == Gear::Neutral { [0.0; 2] } else { allocate(&sides, t) };
                let after = [0, 1].map(|i| sides[i].after(torques[i], dt));
                for i in [0, 1] {
                    let dragged = (sides[i].inertia - unit.inertia) * (after[i] - before[i]) / dt;
                    done.torque += torques[i] - dragged;
                    done.work += dt * 0.5 * (before[i] + after[i]) * (torques[i] - dragged);
                }
                after
            };
            for (side, spin) in after.into_iter().enumerate() {
                for i in wheels_of(side) {
                    wheels.torques[i] =
                        self.wheel_inertias[i] * (spin - wheels.spins[i]) / dt - wheels.moments[i];
                    wheels.spins[i] = spin;
                }
            }
        }
        done.spin = Self::mean(wheels.spins);
        done
    }

    /// What the motors of a side that turns at a spin (rad/s) do and could do.
    #[allow(clippy::too_many_arguments, reason = "the state of a side, and what is asked of it")]
    fn motors(
        &self,
        side: &mut Side,
        share: f64,
        engine: &Engine,
        direction: Gear,
        throttle: f64,
        spin: f64,
        dt: f64,
    ) {
        let sign = match direction {
            Gear::Forward => 1.0,
            Gear::Reverse => -1.0,
            Gear::Neutral => return,
        };
        let part = 0.5 * share * self.gearing;
        let (law, friction, _) = rigid(engine, throttle, sign * self.gearing * spin);
        side.push = sign * part * law.torque;
        let drag = dt * part * self.gearing * law.drag;
        side.inertia += drag;
        // The drag's torque before the step is in the law's torque.
        side.momentum += drag * spin;
        side.held += dt * part * friction;
        let Engine::Electric { torque, .. } = engine else { return };
        let (stall, turning) = (torque[0][1], interpolate(torque, self.gearing * spin.abs()).0);
        let most = |forward: bool| part * if forward == (spin >= 0.0) { turning } else { stall };
        side.limits = [-most(false), most(true)];
    }

    /// The torque that the steering command moves from the left to the right motors of a unit, N m.
    fn moved(
        &self,
        sides: &[Side; 2],
        share: f64,
        direction: Gear,
        steering: f64,
        mean: f64,
        dt: f64,
    ) -> f64 {
        let command = if direction == Gear::Reverse { -steering } else { steering };
        let (gain, asked) = match self.skid {
            Skid::Torque { torque } => return share * command * torque,
            Skid::Speed { relative, at_rest, gain } => {
                (share * gain, command * (relative * mean.abs()).max(at_rest / self.radius))
            }
        };
        let error = |t: f64| {
            let [left, right] = allocate(sides, t);
            t - gain * (asked - (sides[1].after(right, dt) - sides[0].after(left, dt)))
        };
        let most = sides.iter().flat_map(|s| s.limits).map(f64::abs).fold(0.0, f64::max);
        let enough = CONVERGED * most;
        let (mut low, mut high) = (-2.0 * most, 2.0 * most);
        let (mut below, mut above) = (error(low), error(high));
        if below >= 0.0 || above <= 0.0 {
            return if below >= 0.0 { low } else { high };
        }
        let mut last = 0;
        let mut t = 0.0;
        for _ in 0..MOST {
            t = low - below * (high - low) / (above - below);
            let e = error(t);
            if e.abs() <= enough {
                break;
            }
            if e < 0.0 {
                (low, below) = (t, e);
                if last == -1 {
                    above *= 0.5;
                }
                last = -1;
            } else {
                (high, above) = (t, e);
                if last == 1 {
                    below *= 0.5;
                }
                last = 1;
            }
        }
        t
    }
}
