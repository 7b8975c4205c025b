//! The vehicle as a point mass on wheels that don't slip: what its maps, masses and friction alone make of a drive along
//! a line. Independent of the simulator's equations of motion.

use crate::bench::Bench;
use vb_sim::tyre::Tyre;
use vb_vehicle::VehicleSpec;

/// A drive along a line.
pub(crate) struct PointMass<'a> {
    bench: &'a Bench<'a>,
    friction: f64,
    /// Rolling resistance over load.
    rolling: f64,
    final_drive: f64,
    /// Mass with all that turns, kg.
    inertia: f64,
    /// m.
    radius: f64,
    gear: usize,
    /// m/s.
    pub(crate) speed: f64,
    /// s.
    pub(crate) time: f64,
    /// m.
    pub(crate) distance: f64,
}

/// Step of the integration, s.
const STEP: f64 = 1e-3;
/// How far below its shift up (a share) a gearbox that shifts down must leave the engine, or it would go to and fro between
/// two gears.
const CLEAR: f64 = 0.05;

/// Radius on which the driven wheels roll, m: a third of the deflection below the free one (Rill 2011, ch. 3).
pub(crate) fn rolling_radius(bench: &Bench<'_>) -> f64 {
    let (spec, g) = (bench.spec, &bench.geometry);
    let tyre = spec.axles.iter().find(|a| a.driven).map_or(&spec.tyre, |a| spec.tyre_of(a));
    let deflection = Tyre::new(tyre).deflection(g.weight() / g.corners.len() as f64);
    let driven = spec.axles.iter().position(|a| a.driven).unwrap_or(0);
    g.corners[2 * driven].radius - deflection / 3.0
}

/// Resistance of the air, which grows with speed (m/s), N.
pub(crate) fn air(spec: &VehicleSpec, speed: f64) -> f64 {
    let points = &spec.chassis.resistance;
    if points.is_empty() { 0.0 } else { vb_vehicle::table::interpolate(points, speed).0 }
}

impl<'a> PointMass<'a> {
    /// Rolling at a speed, in the gear that an upward shift from the lowest would have reached.
    pub(crate) fn new(bench: &'a Bench<'a>, friction: f64, speed: f64) -> Self {
        let (spec, g) = (bench.spec, &bench.geometry);
        let radius = rolling_radius(bench);
        let wheels: f64 = g.corners.iter().map(|c| c.spin_inertia).sum();
        let line = &spec.powertrain.driveline;
        let final_drive =
            line.axles.iter().map(|a| a.final_drive).sum::<f64>() / line.axles.len().max(1) as f64;
        let axles: f64 = line
            .axles
            .iter()
            .map(|a| a.box_inertia + a.shaft_inertia / (a.final_drive * a.final_drive))
            .sum();
        let turning = wheels + axles + line.shaft_inertia / (final_drive * final_drive);
        let inertia = g.mass + turning / (radius * radius);
        let mut p = Self {
            bench,
            friction: bench.grip(friction),
            rolling: spec.tyre.rolling_resistance(),
            final_drive,
            inertia,
            radius,
            gear: 0,
            speed,
            time: 0.0,
            distance: 0.0,
        };
        for _ in 0..spec.powertrain.gearbox.ratios.len() {
            p.shift();
        }
        p
    }

    /// Whether the engine turns with the wheels, as this model has it: a converter is not in it.
    pub(crate) fn knows(bench: &Bench<'_>) -> bool {
        bench.spec.powertrain.converter.is_none()
    }

    /// Whether the driven wheels would spin at rest with a throttle. On fewer than all axles the load of those counts.
    pub(crate) fn spins(&self, throttle: f64) -> bool {
        let p = &self.bench.spec.powertrain;
        let torque = p.engine.torque(0.0, throttle) / p.gearbox.ratios[0] / self.final_drive;
        let driven = self.bench.spec.axles.iter().filter(|a| a.driven).count() as f64
            / self.bench.spec.axles.len() as f64;
        torque / self.radius > self.friction * self.bench.geometry.weight() * driven
    }

    fn engine_speed(&self) -> f64 {
        let p = &self.bench.spec.powertrain;
        self.speed.abs() / self.radius / self.final_drive / p.gearbox.ratios[self.gear]
    }

    fn shift(&mut self) {
        let g = &self.bench.spec.powertrain.gearbox;
        let engine = self.engine_speed();
        if engine > g.shift_up[self.gear] && self.gear + 1 < g.ratios.len() {
            self.gear += 1;
        } else if engine < g.shift_down[self.gear]
            && self.gear > 0
            && engine * g.ratios[self.gear] / g.ratios[self.gear - 1]
                < (1.0 - CLEAR) * g.shift_up[self.gear - 1]
        {
            self.gear -= 1;
        }
    }

    /// One step with throttle and brake in [0, 1].
    fn step(&mut self, throttle: f64, brake: f64) {
        let (spec, g) = (self.bench.spec, &self.bench.geometry);
        let p = &spec.powertrain;
        let throttle = p.governor.map_or(throttle, |v| throttle.min(v.ceiling(self.speed)));
        let torque =
            p.engine.torque(self.engine_speed(), throttle) / p.gearbox.ratios[self.gear] / self.final_drive;
        let brakes: f64 = spec.axles.iter().map(|a| 2.0 * a.brake_torque).sum::<f64>() * brake;
        let limit = self.friction * g.weight();
        let force = ((torque - brakes) / self.radius - self.rolling * g.weight() - air(spec, self.speed))
            .clamp(-limit, limit);
        // At the limit the wheels' inertia doesn't travel with the mass: they spin or stand.
        let inertia = if force.abs() >= limit { g.mass } else { self.inertia };
        self.speed += STEP * force / inertia;
        self.distance += STEP * self.speed;
        self.time += STEP;
        self.shift();
    }

    /// Drives until `seconds` have passed since the start, or to a standstill.
    pub(crate) fn drive_for(&mut self, seconds: f64, throttle: f64, brake: f64) {
        while self.time < seconds && (self.speed > 0.0 || throttle > 0.0) {
            self.step(throttle, brake);
        }
        self.speed = self.speed.max(0.0);
    }

    /// Time (s) at which a speed is reached from below, if it is within `seconds`.
    pub(crate) fn time_to(&mut self, speed: f64, seconds: f64, throttle: f64) -> Option<f64> {
        while self.speed < speed {
            if self.time >= seconds {
                return None;
            }
            self.step(throttle, 0.0);
        }
        Some(self.time)
    }

    /// Distance (m) to a standstill.
    pub(crate) fn stop(&mut self, brake: f64) -> f64 {
        while self.speed > 0.0 && self.time < 100.0 {
            self.step(0.0, brake);
        }
        self.distance
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_vehicle::GRAVITY;

    #[test]
    fn it_coasts_down_through_its_gears_and_never_up_again() {
        // Of the FED-Alpha a shift down at its shift point would take the engine beyond that of the shift up.
        let spec =
            VehicleSpec::parse(include_str!("../../../../tasks/vehicles/feda.yaml"), "feda.yaml").unwrap();
        let bench = Bench::new(&spec, &[], 1e-3).unwrap();
        let mut p = PointMass::new(&bench, 0.9, 5.0);
        let mut gear = p.gear;
        while p.speed > 0.5 {
            p.drive_for(p.time + STEP, 0.0, 0.0);
            assert!(p.gear <= gear, "from {gear} to {} at {} m/s", p.gear, p.speed);
            gear = p.gear;
        }
        assert_eq!(gear, 0);
    }

    #[test]
    fn at_the_friction_limit_it_stops_in_v_squared_over_two_mu_g_and_starts_with_mu_g() {
        let spec =
            VehicleSpec::parse(include_str!("../../../../tasks/vehicles/hmmwv-released.yaml"), "hmmwv.yaml")
                .unwrap();
        let spec = spec.with_tyre("brush").unwrap();
        let bench = Bench::new(&spec, &[], 1e-3).unwrap();
        let stop = PointMass::new(&bench, 0.5, 15.0).stop(1.0);
        assert!((stop / (225.0 / (2.0 * 0.5 * GRAVITY)) - 1.0).abs() < 2e-3, "{stop} m");
        // 38 kN m of torque at the wheels in first gear are far beyond the grip at μ 0.3.
        let t = PointMass::new(&bench, 0.3, 0.0).time_to(2.0, 10.0, 1.0).unwrap();
        assert!((t / (2.0 / (0.3 * GRAVITY)) - 1.0).abs() < 2e-3, "{t} s");
    }
}
