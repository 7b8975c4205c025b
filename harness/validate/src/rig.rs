//! Ground made for events, and driving on it.

use crate::event::{Bench, Series};
use std::sync::Arc;
use vb_math::angle::{degrees, wrap};
use vb_math::{atan2, hypot, sin, tan};
use vb_sim::{Controls, SimError, SimOptions, Simulation, SoilSet, VehicleState};
use vb_vehicle::{VehicleModel, VehicleSpec};
use vb_world::{Heightfield, Pose2, TerrainClass, World};

/// A world of one friction value over the given heights.
fn world(heightfield: Heightfield, friction: f64) -> Arc<World> {
    Arc::new(World::uniform("rig", heightfield, TerrainClass::Concrete, friction))
}

/// Level ground. The plane goes on beyond its edges, so its size doesn't matter.
pub(crate) fn flat(friction: f64) -> Arc<World> {
    plane(0.0, friction)
}

/// A plane that rises along x by an angle, rad.
pub(crate) fn plane(angle: f64, friction: f64) -> Arc<World> {
    let slope = tan(angle);
    let (rows, cols, resolution) = (5, 5, 10.0);
    let heights = (0..rows * cols).map(|i| slope * resolution * (i % cols) as f64).collect();
    world(Heightfield::new(rows, cols, resolution, heights), friction)
}

/// A strip of soil along x that rises by an angle, rad. Soil has an end, unlike rigid planes: `length` × `width` m.
pub(crate) fn soil(class: TerrainClass, length: f64, width: f64, angle: f64) -> Arc<World> {
    let slope = tan(angle);
    Arc::new(World::uniform("rig", heights(length, width, 1.0, |x| slope * x), class, 0.0))
}

/// Heights that depend on x alone, over `length` × `width` m, nodes `resolution` apart.
pub(crate) fn profile(
    length: f64,
    width: f64,
    resolution: f64,
    friction: f64,
    height: impl Fn(f64) -> f64,
) -> Arc<World> {
    world(heights(length, width, resolution, height), friction)
}

/// Level ground with two frictions: one to the left of the line y = 0, where y > 0, and one to the right.
pub(crate) fn split(left: f64, right: f64) -> Arc<World> {
    let mut world = World::uniform("rig", Heightfield::flat(5, 5, 10.0, 0.0), TerrainClass::Concrete, left);
    let s = &mut world.semantics;
    (s.rows, s.classes, s.friction) = (2, vec![TerrainClass::Concrete; 2], vec![right, left]);
    Arc::new(world)
}

/// Heights that depend on x and y, over `length` × `width` m, nodes `resolution` apart.
pub(crate) fn relief(
    length: f64,
    width: f64,
    resolution: f64,
    friction: f64,
    height: impl Fn(f64, f64) -> f64,
) -> Arc<World> {
    let (rows, cols) =
        ((width / resolution).round() as usize + 1, (length / resolution).round() as usize + 1);
    let place = |k: usize, count: usize| (k as f64 - 0.5 * (count - 1) as f64) * resolution;
    let heights = (0..rows * cols).map(|i| height(place(i % cols, cols), place(i / cols, rows))).collect();
    world(Heightfield::new(rows, cols, resolution, heights), friction)
}

fn heights(length: f64, width: f64, resolution: f64, height: impl Fn(f64) -> f64) -> Heightfield {
    let (rows, cols) =
        ((width / resolution).round() as usize + 1, (length / resolution).round() as usize + 1);
    let line: Vec<f64> =
        (0..cols).map(|c| height((c as f64 - 0.5 * (cols - 1) as f64) * resolution)).collect();
    let heights = (0..rows * cols).map(|i| line[i % cols]).collect();
    Heightfield::new(rows, cols, resolution, heights)
}

/// A half-sine bump over the whole width from x = 0 to `length`, `height` high, 0.05 m resolution (the reference's mesh).
pub(crate) fn bump(length: f64, height: f64, friction: f64) -> Arc<World> {
    profile(24.0, 6.0, 0.05, friction, |x| {
        if x > 0.0 && x < length { height * sin(std::f64::consts::PI * x / length) } else { 0.0 }
    })
}

/// A step up at x = 0. Its face leans by one node distance, 4 cm.
pub(crate) fn step(height: f64, friction: f64) -> Arc<World> {
    profile(4.0, 6.0, 0.04, friction, |x| if x > 0.02 { height } else { 0.0 })
}

/// What the driver wants.
pub(crate) fn controls(steering: f64, throttle: f64, brake: f64) -> Controls {
    Controls {
        steering: steering.clamp(-1.0, 1.0),
        throttle: throttle.clamp(0.0, 1.0),
        brake: brake.clamp(0.0, 1.0),
    }
}

/// Brakes on, no throttle, wheels straight.
pub(crate) const PARKED: Controls = Controls { steering: 0.0, throttle: 0.0, brake: 1.0 };
/// Nothing pressed, wheels straight.
pub(crate) const COASTING: Controls = Controls { steering: 0.0, throttle: 0.0, brake: 0.0 };

/// How the lengths, speeds and times of an event carry over to a vehicle of another scale: lengths with the scale, speeds
/// and times with its square root, by which gravity and so accelerations stay what they are (Froude's rule). Events are
/// written for a full-size vehicle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    scale: f64,
    root: f64,
    /// Top speed of the vehicle, m/s.
    top: f64,
}

impl Pace {
    pub(crate) fn new(spec: &VehicleSpec) -> Self {
        Self { scale: spec.scale, root: spec.scale.sqrt(), top: spec.max_speed }
    }

    pub(crate) fn length(self, full_size: f64) -> f64 {
        full_size * self.scale
    }

    pub(crate) fn speed(self, full_size: f64) -> f64 {
        full_size * self.root
    }

    pub(crate) fn time(self, full_size: f64) -> f64 {
        full_size * self.root
    }

    /// Whether the vehicle can drive at a full-size speed and have something left to control it with.
    pub(crate) fn reaches(self, full_size: f64) -> bool {
        self.speed(full_size) <= 0.9 * self.top
    }

    /// A full-size speed, or the one that the vehicle can hold if it is less.
    pub(crate) fn within_reach(self, full_size: f64) -> f64 {
        full_size.min(0.75 * self.top / self.root)
    }

    /// A full-size speed as this vehicle drives it, for labels.
    pub(crate) fn speed_label(self, full_size: f64) -> String {
        label(full_size, self.speed(full_size))
    }

    /// A full-size length as this vehicle meets it, for labels.
    pub(crate) fn length_label(self, full_size: f64) -> String {
        label(full_size, self.length(full_size))
    }

    /// The original's speed controller: the error of the speed (gain 1) is the throttle, or negative the brake
    /// (`compute_throttle` in its systems/PID/PID.py). The target is a full-size speed.
    pub(crate) fn hold_speed(self, s: &VehicleState, target: f64, steering: f64) -> Controls {
        let e = target - s.velocity.x / self.root;
        controls(steering, e, -e)
    }

    /// The original's pursuit law along the line y = 0: the steering command is the angle (rad) to a point 10 m ahead.
    pub(crate) fn hold_line(self, s: &VehicleState) -> f64 {
        let (_, _, yaw) = s.roll_pitch_yaw();
        wrap(atan2(-s.position.y, self.length(10.0)) - yaw).clamp(-1.0, 1.0)
    }

    /// The same along the line x = 0, heading to larger y.
    pub(crate) fn hold_line_across(self, s: &VehicleState) -> f64 {
        let (_, _, yaw) = s.roll_pitch_yaw();
        wrap(atan2(self.length(10.0), -s.position.x) - yaw).clamp(-1.0, 1.0)
    }
}

fn label(full_size: f64, scaled: f64) -> String {
    if (scaled - scaled.round()).abs() < 1e-9 || scaled == full_size {
        format!("{scaled:.0}")
    } else {
        format!("{scaled:.2}")
    }
}

/// Speed over ground, m/s.
pub(crate) fn speed(s: &VehicleState) -> f64 {
    hypot(s.velocity.x, s.velocity.y)
}

/// The vehicle as it stands on level ground of its scale.
pub(crate) fn at_rest(model: &VehicleModel, options: SimOptions) -> Result<VehicleState, SimError> {
    let level = Arc::new(flat(0.9).scaled(model.spec().scale));
    let start = Pose2 { x: 0.0, y: 0.0, yaw: 0.0 };
    Ok(Simulation::new(level, model, &SoilSet::default(), start, options)?.state())
}

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
        let world = if scale == 1.0 { world.clone() } else { Arc::new(world.scaled(scale)) };
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

    /// The state now.
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
        self.sim.set_gravity([0.0, vb_vehicle::GRAVITY * s, -vb_vehicle::GRAVITY * c]);
    }

    fn record(&mut self, s: &VehicleState, c: Controls) {
        let (roll, pitch, yaw) = s.roll_pitch_yaw();
        let v = s.attitude * s.velocity;
        let mut row = vec![s.time, s.position.x, s.position.y, s.position.z];
        row.extend([roll, pitch, yaw].map(degrees));
        row.extend([s.velocity.x, s.velocity.y, v.z, s.angular_velocity.z, s.steering, c.throttle, c.brake]);
        row.extend(s.wheels.iter().flat_map(|w| [w.speed, w.deflection, w.load, w.sinkage]));
        let drive = self.sim.drive();
        row.extend([drive.gear as f64, drive.engine_speed]);
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

    #[test]
    fn the_ground_has_the_shape_asked_for() {
        let w = plane(0.3, 0.5);
        let rise = w.heightfield.height(100.0, 3.0) - w.heightfield.height(0.0, -50.0);
        assert!((rise / 100.0 - tan(0.3)).abs() < 1e-12, "{rise}");
        let b = bump(2.0, 0.2, 0.9);
        assert!((b.heightfield.height(1.0, 0.3) - 0.2).abs() < 1e-12);
        assert_eq!([b.heightfield.height(-5.0, 0.0), b.heightfield.height(2.5, 0.0)], [0.0, 0.0]);
        let s = step(0.3, 0.9);
        assert_eq!([s.heightfield.height(0.0, 0.0), s.heightfield.height(0.04, 0.0)], [0.0, 0.3]);
        assert_eq!([s.heightfield.height(-99.0, 9.0), s.heightfield.height(99.0, 9.0)], [0.0, 0.3]);
    }
}
