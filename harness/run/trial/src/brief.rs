//! The data that a planner is told about a task.

use vb_math::rng::Stream;
use vb_score::Rules;
use vb_sdk::{Param, Point2, Pose2};
use vb_sense::{Perception, PriorMaps, Profile, Seed};
use vb_vehicle::VehicleSpec;
use vb_world::{Task, World};

use crate::shape::StaticShape;

/// The vehicle as planners see it.
#[must_use]
pub fn planner_vehicle(spec: &VehicleSpec, shape: &StaticShape, scale: f64) -> vb_sdk::Vehicle {
    vb_sdk::Vehicle {
        name: spec.name.clone(),
        scale,
        mass: shape.mass,
        length: shape.length,
        width: shape.width,
        height: shape.height,
        wheelbase: shape.wheelbase,
        track: shape.track,
        wheel_radius: spec.tyre.radius(),
        wheels: 2 * spec.axles.len() as u32,
        ground_clearance: shape.ground_clearance,
        max_steer_angle: shape.max_steer_angle,
        max_steer_rate: spec.steering.rate,
        min_turn_radius: shape.min_turn_radius,
        effective_track: shape.skid.as_ref().map_or(0.0, |s| s.effective_track),
        turn_rate_in_place: shape.skid.as_ref().map_or(0.0, |s| s.in_place),
        max_speed: spec.max_speed,
        max_reverse_speed: shape.max_reverse_speed,
        direction_change_speed: spec.powertrain.gearbox.direction_change.speed,
        direction_change_time: spec.powertrain.gearbox.direction_change.latency,
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
    /// What is known of the world, and how well.
    pub(crate) profile: &'a Profile,
}

impl Terms<'_> {
    /// By what the random numbers of a task's perception are told apart.
    pub(crate) fn perception_seed(&self, world: &World, task: &Task) -> Seed {
        Seed { run: self.seed, task: world.task_id(task).to_string() }
    }

    /// What a planner is told about a task of a (scaled) world, in which its vehicle perceives by these sensors.
    pub(crate) fn brief(
        &self,
        world: &World,
        task: &Task,
        vehicle: vb_sdk::Vehicle,
        params: Vec<Param>,
        perception: &Perception,
    ) -> vb_sdk::Task {
        let h = &world.heightfield;
        let id = world.task_id(task).to_string();
        let PriorMaps { elevation, semantics, occupancy } =
            PriorMaps::new(self.profile, world, &self.perception_seed(world, task));
        vb_sdk::Task {
            time_limit: self.rules.time_limit(self.scale, vehicle.max_speed),
            vehicle,
            elevation,
            semantics,
            occupancy,
            half_extent: Point2 { x: h.half_x(), y: h.half_y() },
            path: task.path.iter().map(|p| Point2 { x: p[0], y: p[1] }).collect(),
            start: Pose2 { x: task.start.x, y: task.start.y, yaw: task.start.yaw },
            goal: Point2 { x: task.goal[0], y: task.goal[1] },
            goal_radius: self.rules.goal_radius(self.scale),
            control_period: self.control_period,
            seed: Stream::new(self.seed, &["planner", &id]).next_u64(),
            params,
            perception: self.profile.name().to_owned(),
            lidar: perception.lidar_info(),
            depth: perception.depth_info(),
            id,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::static_shape;
    use vb_math::tan;
    use vb_sim::SimOptions;
    use vb_vehicle::VehicleModel;

    #[test]
    fn the_hmmwv_is_told_by_its_published_figures() {
        let text = include_str!("../../../../tasks/vehicles/hmmwv.yaml");
        let spec = VehicleSpec::parse(text, "hmmwv.yaml").unwrap();
        let model = VehicleModel::new(spec.clone()).unwrap();
        let shape = static_shape(&model, SimOptions::default()).unwrap();
        let v = planner_vehicle(&spec, &shape, 1.0);
        // M998 of 2359 kg with 135 kg of driver and kit, wheelbase 3.302 m, track 1.819 m, ground clearance 0.41 m (OD1615), steering
        // stops at 34 to 36 deg of the inner wheel and less of the outer (TM 9-2320-280-20-2): 31.9 and 34.2 deg, 33.0 in the mean.
        assert!((v.mass - 2494.0).abs() < 0.1);
        assert!((v.wheelbase - 3.302).abs() < 1e-3 && (v.track - 1.8194).abs() < 1e-3);
        assert!((v.max_steer_angle.to_degrees() - 33.0).abs() < 0.2, "{}", v.max_steer_angle.to_degrees());
        assert!((v.ground_clearance - 0.41).abs() < 0.02, "{}", v.ground_clearance);
        // Ackermann: √((3.302 / tan 33.0°)² + 1.651²).
        assert!((v.min_turn_radius - 5.346).abs() < 0.03, "{}", v.min_turn_radius);
        assert_eq!(v.wheels, 4);
    }

    #[test]
    fn a_tracked_vehicle_is_told_by_how_it_turns() {
        let text = include_str!("../../../../tasks/vehicles/m113.yaml");
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

    #[test]
    fn a_skid_steered_robot_is_told_by_how_it_turns() {
        let text = include_str!("../../../../tasks/vehicles/husky.yaml");
        let spec = VehicleSpec::parse(text, "husky.yaml").unwrap();
        let model = VehicleModel::new(spec.clone()).unwrap();
        let v = planner_vehicle(&spec, &static_shape(&model, SimOptions::default()).unwrap(), 0.25);
        assert!((v.wheelbase - 0.512).abs() < 1e-3 && (v.track - 0.555).abs() < 1e-3);
        // The speeds of the sides differ by 1.04 of the mean at full command: on an effective track between the geometric one and
        // twice the controller's, 0.555 · 1.875 m.
        assert!(
            v.min_turn_radius > 0.555 / 1.04 && v.min_turn_radius < 2.0 * 0.555 * 1.875 / 1.04,
            "{}",
            v.min_turn_radius
        );
        assert!(v.max_steer_angle > 0.1 && v.max_reverse_speed > 0.9, "{v:?}");
        // Its controller counts on 1.875 times the track (Clearpath's control.yaml); as fast in place as wheels without slip on it at
        // most.
        assert!((v.effective_track / (0.555 * 1.875) - 1.0).abs() < 0.15, "{}", v.effective_track);
        assert!(v.turn_rate_in_place > 0.1 && v.turn_rate_in_place < 2.0 / 0.555, "{}", v.turn_rate_in_place);
        let text = include_str!("../../../../tasks/vehicles/hmmwv.yaml");
        let spec = VehicleSpec::parse(text, "hmmwv.yaml").unwrap();
        let model = VehicleModel::new(spec.clone()).unwrap();
        let v = planner_vehicle(&spec, &static_shape(&model, SimOptions::default()).unwrap(), 1.0);
        assert_eq!((v.effective_track, v.turn_rate_in_place), (0.0, 0.0));
    }
}
