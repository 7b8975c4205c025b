//! Planning on the local map, for tasks without maps of the world.
//!
//! Without maps, neither the search nor the networks apply. The internal forward model drives along the global path on
//! the terrain and around the obstacles of the local map.

use hybrid::{Objective, Weights};
use vb_sdk::mppi::Field;
use vb_sdk::path::{Follower, Path};
use vb_sdk::{
    Command, GridFrame, HeightMap, LocalMap, Map, Observation, PlannerError, Pose, Task, Vehicle, math,
};

use crate::foresight::{Foresight, Proposal};

/// Assumed height of unknown terrain below the reference point, in wheel radii.
const HEIGHT: f64 = 1.2;

/// The planner without maps.
pub(crate) struct Scout {
    foresight: Foresight,
    follower: Follower,
    lookahead: f64,
    objective: Objective,
    /// The target speed without increase, m/s.
    target: f32,
    hurry: f64,
    vehicle: Vehicle,
    /// The corners of the world.
    edges: [(f64, f64); 2],
    /// Whether a local map has been received.
    sees: bool,
}

/// A circular arc at constant speed.
struct Pursuit {
    steering: f64,
    speed: f64,
}

impl Proposal for Pursuit {
    fn planned(&self, _: f64) -> [f64; 2] {
        [self.steering, self.speed]
    }
}

impl Scout {
    pub(crate) fn new(task: &Task) -> Result<Self, PlannerError> {
        let vehicle = &task.vehicle;
        let scale = vehicle.scale;
        let positive = |key| task.param_positive(key);
        let weight = |key| crate::weight(task, key);
        let level = level(task.half_extent.x.min(task.half_extent.y));
        let foresight = Foresight::new(task, &level, None)?.ok_or_else(|| {
            PlannerError::new("parameter `foresight`: 0 is not possible for a task without an occupancy map")
        })?;
        let (lookahead, target) = (positive("lookahead")? * scale, positive("speed")? * scale.sqrt());
        let (margin, radius) = (positive("margin")? * scale, 0.5 * vehicle.width);
        let edges = [(-task.half_extent.x, -task.half_extent.y), (task.half_extent.x, task.half_extent.y)];
        let nothing = Map { frame: level.frame, data: vec![255; level.data.len()] };
        let clearance = Field::around(&nothing, edges[0], edges[1], radius + margin)
            .ok_or_else(|| PlannerError::new("the world has no size"))?;
        let objective = Objective {
            values: None,
            goal: [0.0; 2],
            per_lookahead: (1.0 / lookahead) as f32,
            target: target as f32,
            steps: 1.0,
            weights: Weights {
                goal: weight("goal")?,
                obstacle: weight("obstacle")?,
                pace: weight("pace")?,
                effort: weight("effort")?,
                tilt: weight("tilt")?,
                stuck: 0.0,
                over: 0.0,
                caution: 1.0,
            },
            axle: (0.5 * vehicle.wheelbase) as f32,
            radius: radius as f32,
            margin: margin as f32,
            comfort: [positive("roll")?.to_radians() as f32, positive("pitch")?.to_radians() as f32],
            clearance,
        };
        Ok(Self {
            foresight,
            follower: Follower::new(Path::new(&task.path)?, 2.0 * lookahead),
            lookahead,
            target: objective.target,
            hurry: 1.0,
            objective,
            vehicle: vehicle.clone(),
            edges,
            sees: false,
        })
    }

    pub(crate) fn step(&mut self, o: &Observation) -> Result<Command, PlannerError> {
        let pose = o.pose()?;
        if let Some(seen) = &o.local_map {
            self.see(seen, pose);
        }
        if !self.sees {
            // It waits for the first local map.
            return Ok(Command::default());
        }
        self.follower.update(pose.position.x, pose.position.y);
        let goal = self.follower.look_ahead(self.lookahead);
        self.objective.goal = [goal.x as f32, goal.y as f32];
        let (dx, dy) = (goal.x - pose.position.x, goal.y - pose.position.y);
        let (sin, cos) = math::sin_cos(pose.yaw);
        let (ahead, aside) = (cos * dx + sin * dy, cos * dy - sin * dx);
        // The circle through the vehicle and the point, tangent to its heading (Coulter, 1992).
        let curvature = 2.0 * aside / (ahead * ahead + aside * aside).max(1e-6);
        let steering = (curvature * self.vehicle.min_turn_radius).clamp(-1.0, 1.0);
        let pursuit = Pursuit { steering, speed: f64::from(self.objective.target) };
        let (command, stuck) = self.foresight.step(o, &self.objective, &pursuit)?;
        if stuck {
            self.hurry = crate::hurried(self.hurry);
            self.objective.target = (f64::from(self.target) * self.hurry) as f32;
        }
        Ok(command)
    }

    /// Takes terrain and obstacles from the local map.
    fn see(&mut self, seen: &LocalMap, pose: &Pose) {
        let frame = seen.elevation.frame;
        if frame.rows.min(frame.cols) < 2 || seen.elevation.data.len() != (frame.rows * frame.cols) as usize {
            return;
        }
        let ground = pose.position.z - HEIGHT * self.vehicle.wheel_radius;
        let heights = filled(&seen.elevation, ground as f32);
        let kinds = Some(&seen.semantics).filter(|kinds| !kinds.data.is_empty());
        self.foresight.see(&heights, kinds, &self.vehicle);
        let reach = f64::from(self.objective.radius + self.objective.margin);
        if let Some(clearance) = Field::around(&seen.occupancy, self.edges[0], self.edges[1], reach) {
            self.objective.clearance = clearance;
        }
        self.sees = true;
    }
}

/// A flat square around the origin with this half side, of 2 x 2 samples.
fn level(half: f64) -> HeightMap {
    let frame = GridFrame { rows: 2, cols: 2, resolution: 2.0 * half, origin_x: -half, origin_y: -half };
    Map { frame, data: vec![0.0; 4] }
}

/// Fills unknown heights with the nearest known height, or with `otherwise` if all are unknown.
fn filled(map: &HeightMap, otherwise: f32) -> HeightMap {
    let (rows, cols) = (map.frame.rows as usize, map.frame.cols as usize);
    let mut data = map.data.clone();
    let mut edge: Vec<usize> = (0..data.len()).filter(|k| data[*k].is_finite()).collect();
    if edge.is_empty() {
        data.fill(otherwise);
    }
    while !edge.is_empty() {
        let mut next = Vec::new();
        for k in edge {
            let (row, col) = (k / cols, k % cols);
            let neighbours = [
                (row > 0).then(|| k - cols),
                (row + 1 < rows).then(|| k + cols),
                (col > 0).then(|| k - 1),
                (col + 1 < cols).then(|| k + 1),
            ];
            for neighbour in neighbours.into_iter().flatten() {
                if !data[neighbour].is_finite() {
                    data[neighbour] = data[k];
                    next.push(neighbour);
                }
            }
        }
        edge = next;
    }
    Map { frame: map.frame, data }
}

/// Whether a task lacks a map that the search needs.
pub(crate) fn is_needed(task: &Task) -> bool {
    task.elevation.is_none() || task.occupancy.is_none()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_seen_is_as_high_as_the_nearest_ground_that_was() {
        let frame = GridFrame { rows: 3, cols: 4, resolution: 1.0, origin_x: 0.0, origin_y: 0.0 };
        let no = f32::NAN;
        let data = vec![1.0, no, no, 5.0, no, no, no, no, no, no, no, 7.0];
        let all = filled(&Map { frame, data }, 0.0).data;
        assert_eq!(all[..4], [1.0, 1.0, 5.0, 5.0]);
        assert_eq!(all[8..], [1.0, 7.0, 7.0, 7.0]);
        let nothing = filled(&Map { frame, data: vec![no; 12] }, 3.0);
        assert_eq!(nothing.data, [3.0; 12]);
    }
}
