//! The engine behind a torque converter: a state of its own.
//!
//! What passes between impeller and turbine is the converter's ([`Converter::flow`]).

use super::Coupling;
use vb_vehicle::powertrain::{Converter, Engine, EngineTorque};

/// Drop of speed, of the idle speed, over which the governor opens the throttle fully. Ours: a droop of a few per
/// cent under the drag of engine and fluid.
const GOVERNOR_BAND: f64 = 0.1;
/// Slip at which the bridging clutch reaches its greatest torque, rad/s. Ours: below half a per cent of any speed at
/// which it closes, and steady at any step since it is implicit.
const LOCK_UP_SLIP: f64 = 0.5;

/// An engine that a converter leaves free to turn.
#[derive(Clone, Debug)]
pub(super) struct FreeEngine {
    converter: Converter,
    inertia: f64,
    /// rad/s.
    pub(super) speed: f64,
    pub(super) bridged: bool,
    /// Change of speed in this step: a constant and its change with that of the turbine.
    change: [f64; 2],
}

impl FreeEngine {
    pub(super) fn new(converter: &Converter, engine: &Engine) -> Self {
        Self {
            speed: converter.idle_speed,
            inertia: engine.inertia(),
            converter: converter.clone(),
            bridged: false,
            change: [0.0; 2],
        }
    }

    /// The throttle that driver and governor make together, and its slope over engine speed.
    fn throttle(&self, driver: f64) -> (f64, f64) {
        let band = GOVERNOR_BAND * self.converter.idle_speed;
        let governor = ((self.converter.idle_speed - self.speed) / band).min(1.0);
        if governor > driver {
            (governor, if governor < 1.0 { -1.0 / band } else { 0.0 })
        } else {
            (driver, 0.0)
        }
    }

    /// Torque of the turbine in the coming step, as far as it depends on the turbine's own change of speed.
    ///
    /// Engine and turbine are advanced linearly implicitly: with the impeller's torque T + a Δω_e − b Δω_t and the
    /// engine's E + E′ Δω_e, J Δω_e = Δt (E + E′ Δω_e − T − a Δω_e + b Δω_t) gives Δω_e as a linear function of
    /// Δω_t, and so the turbine's torque.
    pub(super) fn prepare(&mut self, engine: &Engine, driver: f64, turbine: f64, dt: f64) -> (Coupling, f64) {
        let (throttle, governing) = self.throttle(driver);
        let EngineTorque { torque, by_speed, by_throttle } = engine.torque_and_slopes(self.speed, throttle);
        let stiffening = (by_speed + by_throttle * governing).min(0.0);
        let fluid = self.converter.flow(self.speed, turbine);
        let (clutch, clutch_slope) = self.clutch(turbine);
        let (a, b) = (fluid.by_engine + clutch_slope, fluid.by_turbine + clutch_slope);
        let resisting = self.inertia + dt * (a - stiffening);
        self.change = [dt * (torque - fluid.torque - clutch) / resisting, dt * b / resisting];
        let passed = fluid.multiplied * fluid.by_engine + clutch_slope;
        let coupling = Coupling {
            torque: fluid.multiplied * fluid.torque + clutch + passed * self.change[0],
            drag: (fluid.multiplied * fluid.by_turbine + clutch_slope - passed * self.change[1]).max(0.0),
            inertia: 0.0,
        };
        (coupling, torque)
    }

    /// Torque of the bridging clutch and its slope over the slip, N m and N m s; opens and closes it.
    fn clutch(&mut self, turbine: f64) -> (f64, f64) {
        let Some(lock_up) = self.converter.lock_up else { return (0.0, 0.0) };
        if turbine < lock_up.release_speed {
            self.bridged = false;
        } else if turbine >= lock_up.speed_ratio * self.speed {
            self.bridged = true;
        }
        if !self.bridged {
            return (0.0, 0.0);
        }
        let slip = (self.speed - turbine) / LOCK_UP_SLIP;
        let slope = if slip.abs() < 1.0 { lock_up.torque / LOCK_UP_SLIP } else { 0.0 };
        (lock_up.torque * slip.clamp(-1.0, 1.0), slope)
    }

    /// Lets the engine turn alone for a step, with the turbine beside it: in neutral nothing holds the turbine back, so that
    /// the fluid passes no torque. Returns the torque of the engine, N m.
    pub(super) fn turn_alone(&mut self, engine: &Engine, driver: f64, dt: f64) -> f64 {
        self.bridged = false;
        let (throttle, governing) = self.throttle(driver);
        let EngineTorque { torque, by_speed, by_throttle } = engine.torque_and_slopes(self.speed, throttle);
        let stiffening = (by_speed + by_throttle * governing).min(0.0);
        self.speed = (self.speed + dt * torque / (self.inertia - dt * stiffening)).max(0.0);
        torque
    }

    /// Ends the step in which the turbine's speed changed by `turbine_change` (rad/s).
    pub(super) fn finish(&mut self, turbine_change: f64) {
        self.speed = (self.speed + self.change[0] + self.change[1] * turbine_change).max(0.0);
    }
}
