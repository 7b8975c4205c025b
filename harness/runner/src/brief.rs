//! What a planner is told about a task.

use std::sync::Arc;
use vb_math::rng::Stream;
use vb_math::{atan2, tan};
use vb_score::Rules;
use vb_sdk::{GridFrame, Map, Param, Point2, Pose2};
use vb_sim::{Controls, Side, SimError, SimOptions, Simulation, SoilSet, Start, VehicleModel, VehicleSpec};
use vb_world::{Heightfield, Task, TerrainClass, World};

/// Side of the occupancy map's squares in the full-size world, m.
const OCCUPANCY_RESOLUTION: f64 = 0.5;

/// How a vehicle stands on level ground, and how far its wheels turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StaticShape {
    /// Height of the lowest point of the hull above ground, m.
    pub ground_clearance: f64,
    /// Distance between the first and the last axle, or between the outermost road wheels of a track, m.
    pub wheelbase: f64,
    /// Distance between the wheels of the first axle, m.
    pub track: f64,
    /// Mean angle of the first axle's wheels at steering command 1, rad. Of a tracked vehicle that of a bicycle of its
    /// wheelbase which answers small commands by the same curvature.
    pub max_steer_angle: f64,
    /// Radius of the reference point's circle at steering command 1, m: without slip, or that on which a tracked vehicle
    /// turns.
    pub min_turn_radius: f64,
    /// Mass, all included, kg.
    pub mass: f64,
}

/// Lets the vehicle settle on level ground and measures it.
///
/// # Errors
/// If the vehicle can't be simulated.
pub fn static_shape(model: &VehicleModel, options: SimOptions) -> Result<StaticShape, SimError> {
    let spec = model.spec();
    let side = 4.0 * spec.length.max(1.0);
    let level = Heightfield::flat(3, 3, side / 2.0, 0.0);
    let world = World::uniform("level", level, TerrainClass::Concrete, 0.8);
    let start = vb_world::Pose2 { x: 0.0, y: 0.0, yaw: 0.0 };
    let options = SimOptions { start: Start::Settled, ..options };
    let standing = Simulation::new(Arc::new(world), model, &SoilSet::default(), start, options)?;
    let state = standing.state();
    let lowest = spec.chassis.hull.iter().flatten().map(|p| p[2]).fold(f64::INFINITY, f64::min);
    let mut hubs = Vec::new();
    for (axle, solved) in spec.axles.iter().zip(model.axles()) {
        let at = |command: f64, side: Side| solved.wheel(side, [0.0; 2], command);
        let angle = |side: Side| {
            let axis = at(1.0, side).axis;
            atan2(-axis.x, axis.y)
        };
        let (left, right) = (at(0.0, Side::Left).hub, at(0.0, Side::Right).hub);
        hubs.push((
            axle.position[0] + left.x,
            left.y - right.y,
            0.5 * (angle(Side::Left) + angle(Side::Right)),
        ));
    }
    let mass = spec.total_mass();
    let ground_clearance = if lowest.is_finite() { state.position.z + lowest } else { 0.0 };
    if spec.tracks.is_some() {
        let (first, last) = (hubs[1], hubs[hubs.len() - 2]);
        let wheelbase = first.0 - last.0;
        let curvature = |command: f64| skid_steer(&standing, command);
        return Ok(StaticShape {
            ground_clearance,
            wheelbase,
            track: first.1,
            max_steer_angle: atan2(curvature(SMALL_COMMAND)? / SMALL_COMMAND * wheelbase, 1.0),
            min_turn_radius: 1.0 / curvature(1.0)?,
            mass,
        });
    }
    let (first, last) = (hubs[0], hubs[hubs.len() - 1]);
    // Two axles: the line of the rear one, half a wheelbase behind the reference point. More: the middle of those that
    // are not steered.
    let fixed: Vec<f64> =
        spec.axles.iter().zip(&hubs).filter(|(a, _)| a.steering.is_none()).map(|(_, h)| h.0).collect();
    let [base, ahead] = if hubs.len() > 2 && !fixed.is_empty() {
        let line = fixed.iter().sum::<f64>() / fixed.len() as f64;
        [first.0 - line, line.abs()]
    } else {
        [first.0 - last.0, 0.5 * (first.0 - last.0)]
    };
    // The turning circle of the reference point, which lies between the axles, without slip.
    let rear = base / tan(first.2);
    Ok(StaticShape {
        ground_clearance,
        wheelbase: first.0 - last.0,
        track: first.1,
        max_steer_angle: first.2,
        min_turn_radius: (rear * rear + ahead * ahead).sqrt(),
        mass,
    })
}

/// The command by which a tracked vehicle's answer to small ones is measured.
const SMALL_COMMAND: f64 = 0.2;

/// Curvature of a tracked vehicle's way at a steering command, 1/m: driven on level ground for eight seconds at 3 m/s.
fn skid_steer(standing: &Simulation, steering: f64) -> Result<f64, SimError> {
    let mut sim = standing.clone();
    let period = 10;
    for _ in 0..800 {
        let e = 3.0 - sim.state().velocity.x;
        let controls = Controls { steering, throttle: e.clamp(0.0, 1.0), brake: (-e).clamp(0.0, 1.0) };
        sim.advance(controls, period)?;
    }
    let s = sim.state();
    Ok(s.rates.z / s.velocity.x)
}

/// The vehicle as planners see it.
#[must_use]
pub fn planner_vehicle(spec: &VehicleSpec, shape: &StaticShape, scale: f64) -> vb_sdk::Vehicle {
    vb_sdk::Vehicle {
        name: spec.name.clone(),
        scale,
        mass: shape.mass,
        length: spec.length,
        width: spec.width,
        height: spec.height,
        wheelbase: shape.wheelbase,
        track: shape.track,
        wheel_radius: spec.tyre.radius(),
        wheels: 2 * spec.axles.len() as u32,
        ground_clearance: shape.ground_clearance,
        max_steer_angle: shape.max_steer_angle,
        max_steer_rate: spec.steering.rate,
        min_turn_radius: shape.min_turn_radius,
        max_speed: spec.max_speed,
    }
}

/// What a planner is told about a task of a (scaled) world, but for what the run decides: the caller fills in
/// `goal_radius`, `time_limit`, `control_period` and `seed`.
#[must_use]
pub fn planner_task(
    world: &World,
    task: &Task,
    vehicle: vb_sdk::Vehicle,
    params: Vec<Param>,
) -> vb_sdk::Task {
    let h = &world.heightfield;
    let s = &world.semantics;
    let occupancy = world.occupancy(OCCUPANCY_RESOLUTION * world.scale);
    let frame = |rows: usize, cols: usize, resolution: f64, origin: [f64; 2]| GridFrame {
        rows: rows as u32,
        cols: cols as u32,
        resolution,
        origin_x: origin[0],
        origin_y: origin[1],
    };
    let centre = |count: usize| -0.5 * (count as f64 - 1.0) * s.patch;
    vb_sdk::Task {
        id: format!("{}/{}", world.id, task.id),
        vehicle,
        elevation: Map {
            frame: frame(h.rows(), h.cols(), h.pitch(), [-h.half_x(), -h.half_y()]),
            data: h.heights().iter().map(|&z| z as f32).collect(),
        },
        semantics: Map {
            frame: frame(s.rows, s.cols, s.patch, [centre(s.cols), centre(s.rows)]),
            data: s.classes.iter().map(|c| c.label()).collect(),
        },
        occupancy: Map {
            frame: frame(occupancy.rows, occupancy.cols, occupancy.resolution, occupancy.origin),
            data: occupancy.data,
        },
        path: task.path.iter().map(|p| Point2 { x: p[0], y: p[1] }).collect(),
        start: Pose2 { x: task.start.x, y: task.start.y, yaw: task.start.yaw },
        goal: Point2 { x: task.goal[0], y: task.goal[1] },
        params,
        ..vb_sdk::Task::default()
    }
}

/// What a run decides of a task.
pub(crate) struct Terms<'a> {
    pub(crate) rules: &'a Rules,
    /// Factor on every length of the world.
    pub(crate) scale: f64,
    /// s.
    pub(crate) control_period: f64,
    /// The run's seed.
    pub(crate) seed: u64,
}

impl Terms<'_> {
    /// The brief with all that the planner is told.
    pub(crate) fn applied_to(&self, brief: vb_sdk::Task) -> vb_sdk::Task {
        vb_sdk::Task {
            goal_radius: self.rules.goal_radius(self.scale),
            time_limit: self.rules.time_limit(self.scale),
            control_period: self.control_period,
            seed: Stream::new(self.seed, &["planner", &brief.id]).next_u64(),
            ..brief
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hmmwv_is_told_by_its_published_figures() {
        let text = include_str!("../../../tasks/vehicles/hmmwv.yaml");
        let spec = VehicleSpec::parse(text, "hmmwv.yaml").unwrap();
        let model = VehicleModel::new(spec.clone()).unwrap();
        let shape = static_shape(&model, SimOptions::default()).unwrap();
        let v = planner_vehicle(&spec, &shape, 1.0);
        // Reference sheet: 2493.56 kg, wheelbase 3.302 m, track 1.819 m, wheel angles 21.18 and 22.23 deg at full
        // lock; AM General's data sheet: ground clearance 0.41 m.
        assert!((v.mass - 2493.56).abs() < 0.01);
        assert!((v.wheelbase - 3.302).abs() < 1e-3 && (v.track - 1.8194).abs() < 1e-3);
        assert!((v.max_steer_angle.to_degrees() - 21.706).abs() < 0.01);
        assert!((v.ground_clearance - 0.41).abs() < 0.02, "{}", v.ground_clearance);
        // Ackermann: √((3.302 / tan 21.706°)² + 1.651²).
        assert!((v.min_turn_radius - 8.458).abs() < 0.01, "{}", v.min_turn_radius);
        assert_eq!(v.wheels, 4);
    }

    #[test]
    fn a_tracked_vehicle_is_told_by_how_it_turns() {
        let text = include_str!("../../../tasks/vehicles/m113.yaml");
        let spec = VehicleSpec::parse(text, "m113.yaml").unwrap();
        let model = VehicleModel::new(spec.clone()).unwrap();
        let v = planner_vehicle(&spec, &static_shape(&model, SimOptions::default()).unwrap(), 1.0);
        // Reference sheet: ground contact 2.667 m, gauge 2.159 m. Nikitin's formula gives 8 m of radius for each unit of
        // command (vb-sim's tests of tracks).
        assert!((v.wheelbase - 2.667).abs() < 1e-3 && (v.track - 2.159).abs() < 1e-3);
        let radius = v.wheelbase / tan(v.max_steer_angle);
        assert!((6.0..10.0).contains(&radius), "{radius} m");
        // About the inner belt, which it drags along a little.
        assert!(v.min_turn_radius > 0.5 * v.track && v.min_turn_radius < v.track, "{}", v.min_turn_radius);
        assert_eq!(v.wheels, 14);
    }
}
