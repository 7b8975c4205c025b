//! Driving in an event.

use crate::bench::Bench;
use crate::event::Series;
use std::sync::Arc;
use vb_math::angle::degrees;
use vb_sim::{Controls, SimError, Simulation, SoilSet, VehicleState};
use vb_vehicle::{VehicleModel, VehicleSpec};
use vb_world::{Pose2, World};

/// Time between two samples of a series, s.
pub(crate) const SAMPLE: f64 = 0.01;

/// A simulation being driven and recorded.
pub(crate) struct Drive {
    sim: Simulation,
    series: Series,
    /// Steps between two samples.
    every: u64,
}

impl Drive {
    /// The vehicle, settled with its brakes on at (x, 0) and a heading, rad. The world and x are full-size.
    pub(crate) fn new(
        bench: &Bench<'_>,
        case: &str,
        world: &Arc<World>,
        x: f64,
        yaw: f64,
    ) -> Result<Self, SimError> {
        Self::with(bench, &bench.model, &SoilSet::default(), case, world, x, yaw)
    }

    /// The same with another specification.
    pub(crate) fn with_spec(
        bench: &Bench<'_>,
        spec: &VehicleSpec,
        case: &str,
        world: &Arc<World>,
        x: f64,
        yaw: f64,
    ) -> Result<Self, SimError> {
        Self::with(bench, &VehicleModel::new(spec.clone())?, &SoilSet::default(), case, world, x, yaw)
    }

    /// The same on soil, heading along x.
    pub(crate) fn on_soil(
        bench: &Bench<'_>,
        soils: &SoilSet,
        case: &str,
        world: &Arc<World>,
        x: f64,
    ) -> Result<Self, SimError> {
        Self::with(bench, &bench.model, soils, case, world, x, 0.0)
    }

    fn with(
        bench: &Bench<'_>,
        model: &VehicleModel,
        soils: &SoilSet,
        case: &str,
        world: &Arc<World>,
        x: f64,
        yaw: f64,
    ) -> Result<Self, SimError> {
        let scale = bench.spec.scale;
        let world = Arc::new(World::clone(world).at_scale(scale));
        let start = Pose2 { x: x * scale, y: 0.0, yaw };
        let sim = Simulation::new(world, model, soils, start, bench.options)?;
        let mut columns: Vec<(String, &'static str)> = [
            ("t", "s"),
            ("x", "m"),
            ("y", "m"),
            ("z", "m"),
            ("roll", "°"),
            ("pitch", "°"),
            ("yaw", "°"),
            ("vx", "m/s"),
            ("vy", "m/s"),
            ("vz", "m/s"),
            ("yaw rate", "rad/s"),
            ("steering", ""),
            ("throttle", ""),
            ("brake", ""),
        ]
        .map(|(n, u)| (n.to_owned(), u))
        .to_vec();
        for c in &bench.geometry.corners {
            columns.push((format!("spin {}", c.name), "rad/s"));
            columns.push((format!("travel {}", c.name), "m"));
            columns.push((format!("load {}", c.name), "N"));
            columns.push((format!("sinkage {}", c.name), "m"));
        }
        columns.extend([("gear".to_owned(), ""), ("engine speed".to_owned(), "rad/s")]);
        let every = ((SAMPLE / bench.options.step).round() as u64).max(1);
        let series = Series { name: case.to_owned(), columns, rows: Vec::new() };
        Ok(Self { sim, series, every })
    }

    pub(crate) fn state(&self) -> VehicleState {
        self.sim.state()
    }

    /// The simulation, for what only it can do.
    pub(crate) fn sim(&mut self) -> &mut Simulation {
        &mut self.sim
    }

    /// Tilts gravity about the x axis: as if the ground had turned by `angle` (rad), its y axis downhill.
    pub(crate) fn tilt(&mut self, angle: f64) {
        let (s, c) = vb_math::sin_cos(angle);
        self.sim.rig().set_gravity([0.0, vb_vehicle::GRAVITY * s, -vb_vehicle::GRAVITY * c]);
    }

    fn record(&mut self, s: &VehicleState, c: Controls) {
        let (roll, pitch, yaw) = s.roll_pitch_yaw();
        let v = s.attitude * s.velocity_body;
        let mut row = vec![s.time, s.position.x, s.position.y, s.position.z];
        row.extend([roll, pitch, yaw].map(degrees));
        row.extend([
            s.velocity_body.x,
            s.velocity_body.y,
            v.z,
            s.angular_velocity_body.z,
            s.steering,
            c.throttle,
            c.brake,
        ]);
        row.extend(s.wheels.iter().flat_map(|w| [w.speed, w.deflection, w.load, w.sinkage]));
        let drive = self.sim.drive();
        row.extend([f64::from(drive.gear), drive.engine_speed]);
        self.series.rows.push(row);
    }

    /// Drives until `until` says so or `seconds` have passed; true if `until` did. Both see the state before each step.
    pub(crate) fn run(
        &mut self,
        seconds: f64,
        mut control: impl FnMut(&VehicleState) -> Controls,
        mut until: impl FnMut(&VehicleState) -> bool,
    ) -> Result<bool, SimError> {
        let end = self.sim.time() + seconds;
        loop {
            let s = self.sim.state();
            let c = control(&s);
            let done = until(&s);
            if done || self.sim.steps().is_multiple_of(self.every) {
                self.record(&s, c);
            }
            if done {
                return Ok(true);
            }
            if s.time >= end - 1e-9 {
                return Ok(false);
            }
            self.sim.advance(c, 1)?;
        }
    }

    /// Drives for `seconds`.
    pub(crate) fn hold(
        &mut self,
        seconds: f64,
        control: impl FnMut(&VehicleState) -> Controls,
    ) -> Result<(), SimError> {
        self.run(seconds, control, |_| false).map(|_| ())
    }

    /// The recorded series.
    pub(crate) fn finish(self) -> Series {
        self.series
    }
}

/// The largest value between `low` and `high` for which `holds`, to `resolution`, if it holds up to some value and no
/// further. `low` if it holds nowhere, `high` if everywhere.
pub(crate) fn largest(
    mut low: f64,
    mut high: f64,
    resolution: f64,
    mut holds: impl FnMut(f64) -> Result<bool, SimError>,
) -> Result<f64, SimError> {
    if !holds(low)? {
        return Ok(low);
    }
    if holds(high)? {
        return Ok(high);
    }
    while high - low > resolution {
        let middle = 0.5 * (low + high);
        if holds(middle)? { low = middle } else { high = middle }
    }
    Ok(low)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_search_ends_within_its_resolution_below_the_limit() {
        let limit = |l: f64| largest(0.0, 10.0, 0.01, |x| Ok(x <= l)).unwrap();
        assert!((3.99..=4.0).contains(&limit(4.0)));
        assert_eq!((limit(-1.0), limit(11.0)), (0.0, 10.0));
    }
}
