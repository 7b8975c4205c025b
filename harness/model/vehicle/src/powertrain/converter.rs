//! The torque that a torque converter passes from the engine to its turbine.
//!
//! The impeller takes T = (ω_e/K(r))² with r = ω_t/ω_e, the turbine gives R(r)·T (characteristic curves as in Wong,
//! Theory of Ground Vehicles, 2008, section 3.3.2). When the turbine overruns the engine the two
//! change roles, and the stator runs free: R = 1. Tables end at r = 1 with a finite capacity; there the torque falls
//! to zero within the last two per cent, so that it changes its sign steadily.

use super::Converter;
use crate::table::interpolate;

/// Range of the speed ratio next to 1 in which the torque falls to zero. Ours: narrow beside the tables' spacing.
const SYNCHRONOUS: f64 = 0.02;
/// The torque between impeller and turbine, with its slopes and its multiplication.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ConverterTorque {
    /// The torque that is taken from the engine, N m; negative where the turbine drives the engine.
    pub torque: f64,
    /// ∂torque/∂(engine speed), N m s.
    pub by_engine: f64,
    /// −∂torque/∂(turbine speed), N m s.
    pub by_turbine: f64,
    /// The turbine's torque over the engine's.
    pub multiplied: f64,
}

impl Converter {
    /// 1/K² with the synchronous end, and its derivative.
    #[inline]
    fn coefficient(&self, r: f64) -> (f64, f64) {
        let (k, slope) = interpolate(&self.capacity, r);
        let (c, c_slope) = (1.0 / (k * k), -2.0 * slope / (k * k * k));
        let fade = (1.0 - r) / SYNCHRONOUS;
        if fade >= 1.0 { (c, c_slope) } else { (c * fade, c_slope * fade - c / SYNCHRONOUS) }
    }

    /// The torque at the speeds of engine and turbine (rad/s).
    #[inline]
    #[must_use]
    pub fn flow(&self, engine: f64, turbine: f64) -> ConverterTorque {
        if turbine <= engine {
            if engine <= 0.0 {
                return ConverterTorque { multiplied: 1.0, ..ConverterTorque::default() };
            }
            // A turbine that is driven backwards stalls the fluid.
            let r = (turbine / engine).max(0.0);
            let (c, slope) = self.coefficient(r);
            let slope = if turbine < 0.0 { 0.0 } else { slope };
            ConverterTorque {
                torque: c * engine * engine,
                by_engine: (2.0 * c * engine - slope * turbine).max(0.0),
                by_turbine: (-slope * engine).max(0.0),
                multiplied: interpolate(&self.torque_ratio, r).0,
            }
        } else {
            let (c, slope) = self.coefficient(engine / turbine);
            ConverterTorque {
                torque: -c * turbine * turbine,
                by_engine: (-slope * turbine).max(0.0),
                by_turbine: (2.0 * c * turbine - slope * engine).max(0.0),
                multiplied: 1.0,
            }
        }
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
