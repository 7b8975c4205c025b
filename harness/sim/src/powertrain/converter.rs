//! The engine behind a torque converter: a state of its own.
//!
//! The impeller takes T = (ω_e/K(r))² with r = ω_t/ω_e, the turbine gives R(r)·T (characteristic curves as in Wong,
//! Theory of Ground Vehicles, 2008, section 3.3.2). When the turbine overruns the engine the two
//! change roles, and the stator runs free: R = 1. Tables end at r = 1 with a finite capacity; there the torque falls
//! to zero within the last two per cent, so that it changes its sign steadily.

use super::Coupling;
use super::engine::Law;
use super::table::interpolate;
use crate::spec::{Converter, Engine};

/// Range of the speed ratio next to 1 in which the torque falls to zero. Ours: narrow beside the tables' spacing.
const SYNCHRONOUS: f64 = 0.02;
/// Drop of speed, of the idle speed, over which the governor opens the throttle fully. Ours: a droop of a few per
/// cent under the drag of engine and fluid.
const GOVERNOR_BAND: f64 = 0.1;
/// Slip at which the bridging clutch reaches its greatest torque, rad/s. Ours: below half a per cent of any speed at
/// which it closes, and steady at any step since it is implicit.
const LOCK_UP_SLIP: f64 = 0.5;

/// Torque between impeller and turbine, its slopes and how it is multiplied.
#[derive(Clone, Copy, Debug, Default)]
struct Flow {
    torque: f64,
    by_engine: f64,
    /// −∂torque/∂turbine.
    by_turbine: f64,
    multiplied: f64,
}

impl Converter {
    /// 1/K² with the synchronous end, and its derivative.
    fn coefficient(&self, r: f64) -> (f64, f64) {
        let (k, slope) = interpolate(&self.capacity, r);
        let (c, c_slope) = (1.0 / (k * k), -2.0 * slope / (k * k * k));
        let fade = (1.0 - r) / SYNCHRONOUS;
        if fade >= 1.0 { (c, c_slope) } else { (c * fade, c_slope * fade - c / SYNCHRONOUS) }
    }

    fn flow(&self, engine: f64, turbine: f64) -> Flow {
        if turbine <= engine {
            if engine <= 0.0 {
                return Flow { multiplied: 1.0, ..Flow::default() };
            }
            // A turbine that is driven backwards stalls the fluid.
            let r = (turbine / engine).max(0.0);
            let (c, slope) = self.coefficient(r);
            let slope = if turbine < 0.0 { 0.0 } else { slope };
            Flow {
                torque: c * engine * engine,
                by_engine: (2.0 * c * engine - slope * turbine).max(0.0),
                by_turbine: (-slope * engine).max(0.0),
                multiplied: interpolate(&self.torque_ratio, r).0,
            }
        } else {
            let (c, slope) = self.coefficient(engine / turbine);
            Flow {
                torque: -c * turbine * turbine,
                by_engine: (-slope * turbine).max(0.0),
                by_turbine: (2.0 * c * turbine - slope * engine).max(0.0),
                multiplied: 1.0,
            }
        }
    }
}

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
        let Law { torque, by_speed, by_throttle } = engine.law(self.speed, throttle);
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

    /// Ends the step in which the turbine's speed changed by `turbine_change` (rad/s).
    pub(super) fn finish(&mut self, turbine_change: f64) {
        self.speed = (self.speed + self.change[0] + self.change[1] * turbine_change).max(0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn converter() -> Converter {
        Converter {
            idle_speed: 80.0,
            capacity: vec![[0.0, 15.0], [0.5, 15.0], [0.75, 16.0], [0.9, 18.0], [1.0, 35.0]],
            torque_ratio: vec![[0.0, 2.0], [1.0, 1.0]],
            lock_up: None,
        }
    }

    #[test]
    fn the_torque_passes_steadily_through_zero_at_synchronous_speed() {
        let c = converter();
        let t = |turbine: f64| c.flow(200.0, turbine).torque;
        assert!(t(200.0 - 1e-6).abs() < 1e-4 && t(200.0).abs() < 1e-12 && t(200.0 + 1e-6).abs() < 1e-4);
        assert!(t(195.0) > 10.0 && t(205.0) < -10.0);
        // Beyond the last two per cent it is the table's: (200/26.5)² at a ratio of 0.95.
        assert!((t(190.0) - (200.0 / 26.5) * (200.0 / 26.5)).abs() < 1e-9);
    }

    #[test]
    fn the_slopes_are_those_of_the_torque() {
        let c = converter();
        let h = 1e-5;
        for (engine, turbine) in
            [(200.0, 120.0), (200.0, 170.0), (200.0, 198.0), (150.0, 190.0), (150.0, 151.0)]
        {
            let f = c.flow(engine, turbine);
            let by = |e: f64, t: f64| {
                (c.flow(engine + e, turbine + t).torque - c.flow(engine - e, turbine - t).torque) / (2.0 * h)
            };
            assert!((f.by_engine - by(h, 0.0)).abs() < 1e-4, "{engine} {turbine}");
            assert!((f.by_turbine + by(0.0, h)).abs() < 1e-4, "{engine} {turbine}");
        }
    }
}
