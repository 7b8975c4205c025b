//! The forces along a vehicle's way in balance: what its engine gives at a steady speed through one gear, and what resists.
//! Independent of the simulator's powertrain: only the maps and tables of engine and converter are shared.

use crate::bench::Bench;
use crate::theory::{air, rolling_radius};

/// Steps of the bisections: each halves the range.
const HALVINGS: usize = 60;
/// Faster than any engine, rad/s, and than any vehicle, m/s.
const FASTEST_ENGINE: f64 = 2e4;
const FASTEST: f64 = 100.0;

/// A vehicle in its reverse gear. Speeds and forces are positive backwards.
pub(crate) struct Backwards<'a> {
    bench: &'a Bench<'a>,
    /// Speed of the driven wheels over that of the gearbox' input.
    ratio: f64,
    /// On which the driven wheels roll, or at which the belt runs around its sprocket, m.
    pub(crate) radius: f64,
}

impl<'a> Backwards<'a> {
    /// None for a vehicle without a reverse gear.
    pub(crate) fn new(bench: &'a Bench<'a>) -> Option<Self> {
        let spec = bench.spec;
        let line = &spec.powertrain.driveline;
        let final_drive =
            line.axles.iter().map(|a| a.final_drive).sum::<f64>() / line.axles.len().max(1) as f64;
        let radius = match &spec.tracks {
            None => rolling_radius(bench),
            Some(t) => {
                let sprocket = spec.axles.iter().find(|a| a.driven)?;
                spec.tyre_of(sprocket).radius() - 0.5 * t.thickness
            }
        };
        let ratio = -spec.powertrain.gearbox.reverse? * final_drive;
        Some(Self { bench, ratio, radius })
    }

    /// Speed of the engine when it turns with the gearbox, at a speed of the vehicle (m/s), rad/s.
    pub(crate) fn input(&self, speed: f64) -> f64 {
        speed / self.radius / self.ratio
    }

    /// Torque at the gearbox' input at which engine and converter are in balance, N m.
    fn torque(&self, input: f64, throttle: f64) -> f64 {
        let p = &self.bench.spec.powertrain;
        let Some(converter) = &p.converter else { return p.engine.torque(input, throttle) };
        // What the engine gives less what the impeller takes falls with the engine's speed.
        let engine = bisect(FASTEST_ENGINE, |engine| {
            p.engine.torque(engine, throttle) > converter.flow(engine, input).torque
        });
        match converter.lock_up {
            Some(l) if input >= l.release_speed && input >= l.speed_ratio * engine => {
                p.engine.torque(input, throttle)
            }
            _ => {
                let flow = converter.flow(engine, input);
                flow.multiplied * flow.torque
            }
        }
    }

    /// Force of the engine at the ground at a steady speed (m/s) and a throttle, N.
    pub(crate) fn drive(&self, speed: f64, throttle: f64) -> f64 {
        self.torque(self.input(speed), throttle) / self.ratio / self.radius
    }

    /// What resists on level ground, over the weight.
    pub(crate) fn rolling(&self, speed: f64) -> f64 {
        let spec = self.bench.spec;
        spec.tracks
            .as_ref()
            .map_or(spec.tyre.rolling_resistance(), |t| t.resistance[0] + t.resistance[1] * speed)
    }

    /// Greatest speed on level ground, m/s: that at which full throttle, as far as the governor leaves it, and resistance are
    /// in balance.
    pub(crate) fn top_speed(&self) -> f64 {
        let (spec, weight) = (self.bench.spec, self.bench.geometry.weight());
        bisect(FASTEST, |speed| {
            let throttle = spec.powertrain.governor.map_or(1.0, |g| g.ceiling(speed));
            self.drive(speed, throttle) > self.rolling(speed) * weight + air(spec, speed)
        })
    }

    /// Throttle at which it just starts on a grade (rad).
    pub(crate) fn throttle_on(&self, grade: f64) -> f64 {
        let (sin, cos) = vb_math::sin_cos(grade);
        let needed = self.bench.geometry.weight() * (sin + self.rolling(0.0) * cos);
        bisect(1.0, |throttle| self.drive(0.0, throttle) < needed)
    }
}

/// The value between 0 and `high` up to which `holds`, if it holds up to some value and no further.
fn bisect(high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, high);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if holds(middle) { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_vehicle::VehicleSpec;

    #[test]
    fn the_hmmwv_backs_at_the_engine_speed_at_which_its_map_balances_the_rolling_resistance() {
        let spec =
            VehicleSpec::parse(include_str!("../../../../tasks/vehicles/hmmwv-released.yaml"), "hmmwv.yaml")
                .unwrap();
        let spec = spec.with_tyre("brush").unwrap();
        let bench = Bench::new(&spec, &[], 1e-3).unwrap();
        let b = Backwards::new(&bench).unwrap();
        // 0.015 · 24 462 N · 0.462 m · 0.04 = 6.8 N m, on the line from (230.383, 1041.3) to (251.327, −271.2): 246.89 rad/s.
        assert!((b.input(b.top_speed()) - 246.89).abs() < 0.01, "{}", b.input(b.top_speed()));
        // At rest the map has 419.1 and −2.2 N m: 421.3 u − 2.2 = 24 462 (sin 12° + 0.015 cos 12°) · 0.462 · 0.04.
        assert!(
            (b.throttle_on(12_f64.to_radians()) - 0.2437).abs() < 1e-3,
            "{}",
            b.throttle_on(12_f64.to_radians())
        );
    }

    #[test]
    fn a_converter_at_stall_doubles_the_torque_of_the_engine() {
        let spec =
            VehicleSpec::parse(include_str!("../../../../tasks/vehicles/m113.yaml"), "m113.yaml").unwrap();
        let bench = Bench::new(&spec, &[], 1e-3).unwrap();
        let b = Backwards::new(&bench).unwrap();
        // (ω/7)² meets the line from (157.08, 603.34) to (209.44, 589.78) at 171.7 rad/s; the turbine gives twice that.
        let engine =
            |w: f64| 603.340745 - (603.340745 - 589.782526) / (209.43951 - 157.079633) * (w - 157.079633);
        let w = bisect(400.0, |w| engine(w) > w * w / 49.0);
        let expected = 2.0 * engine(w) / (0.151 * 0.2547) / b.radius;
        assert!((b.drive(0.0, 1.0) / expected - 1.0).abs() < 1e-9, "{} {expected}", b.drive(0.0, 1.0));
    }
}
