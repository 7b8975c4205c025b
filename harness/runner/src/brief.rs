//! What a planner is told about a task.

use std::sync::Arc;
use vb_math::rng::Stream;
use vb_math::{atan2, tan};
use vb_score::Rules;
use vb_sdk::{GridFrame, Map, Param, Point2, Pose2};
use vb_sim::{Side, SimError, SimOptions, Simulation, SoilSet, Start, VehicleModel, VehicleSpec};
use vb_world::{Heightfield, Task, TerrainClass, World};

/// Side of the occupancy map's squares in the full-size world, m.
const OCCUPANCY_RESOLUTION: f64 = 0.5;

/// How a vehicle stands on level ground, and how far its wheels turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StaticShape {
    /// Height of the lowest point of the hull above ground, m.
    pub ground_clearance: f64,
    /// Distance between the first and the last axle, m.
    pub wheelbase: f64,
    /// Distance between the wheels of the first axle, m.
    pub track: f64,
    /// Mean angle of the first axle's wheels at steering command 1, rad.
    pub max_steer_angle: f64,
    /// Distance from the first axle to the line about which the vehicle turns without slip, and of that line from the
    /// reference point, m.
    pub turning: [f64; 2],
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
    let state = Simulation::new(Arc::new(world), model, &SoilSet::default(), start, options)?.state();
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
    let (first, last) = (hubs[0], hubs[hubs.len() - 1]);
    // Two axles: the line of the rear one, half a wheelbase behind the reference point. More: the middle of those that
    // are not steered.
    let fixed: Vec<f64> =
        spec.axles.iter().zip(&hubs).filter(|(a, _)| a.steering.is_none()).map(|(_, h)| h.0).collect();
    let turning = if hubs.len() > 2 && !fixed.is_empty() {
        let line = fixed.iter().sum::<f64>() / fixed.len() as f64;
        [first.0 - line, line.abs()]
    } else {
        [first.0 - last.0, 0.5 * (first.0 - last.0)]
    };
    Ok(StaticShape {
        ground_clearance: if lowest.is_finite() { state.position.z + lowest } else { 0.0 },
        wheelbase: first.0 - last.0,
        track: first.1,
        max_steer_angle: first.2,
        turning,
        mass: spec.total_mass(),
    })
}

/// The vehicle as planners see it.
#[must_use]
pub fn planner_vehicle(spec: &VehicleSpec, shape: &StaticShape, scale: f64) -> vb_sdk::Vehicle {
    // The turning circle of the reference point, which lies between the axles, without slip.
    let [base, ahead] = shape.turning;
    let rear = base / tan(shape.max_steer_angle);
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
        min_turn_radius: (rear * rear + ahead * ahead).sqrt(),
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
}
