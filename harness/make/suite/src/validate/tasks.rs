//! Starts, goals and paths.

use super::{Findings, Limits, Rule};
use crate::clearance::Footprints;
use vb_math::angle::{degrees, radians, turn};
use vb_math::{atan2, hypot, sin_cos};
use vb_world::{Part, Pose2, Task, World};

/// What rounding waypoints to millimetres may cost, m.
const ROUNDING: f64 = 2e-3;

pub(super) fn check(world: &World, footprints: &Footprints, limits: &Limits, findings: &mut Findings<'_>) {
    if world.tasks.is_empty() {
        findings.warn(Rule::Content, Part::Tasks, "tasks", "is empty: add tasks");
    }
    for (k, task) in world.tasks.iter().enumerate() {
        let task = Check { world, footprints, limits, task, name: format!("tasks[{k}] ({})", task.id) };
        task.ends(findings);
        task.distance(findings);
        task.waypoints(findings);
        task.tilt(findings);
        let same = |other: &&Task| (other.start, other.goal) == (task.task.start, task.task.goal);
        if let Some(twin) = world.tasks[..k].iter().find(same) {
            let problem = format!("has start and goal of {}: remove one of them", twin.id);
            findings.warn(Rule::Content, Part::Tasks, &task.name, &problem);
        }
    }
}

/// A place, to centimetres.
fn point(p: [f64; 2]) -> String {
    let [x, y] = p.map(|v| (v * 100.0).round() / 100.0 + 0.0);
    format!("[{x:.2}, {y:.2}]")
}

/// The task being checked.
struct Check<'a> {
    world: &'a World,
    footprints: &'a Footprints,
    limits: &'a Limits,
    task: &'a Task,
    name: String,
}

impl Check<'_> {
    fn ends(&self, findings: &mut Findings<'_>) {
        let path = &self.task.path;
        let mut legs = path.windows(2).filter(|w| w[0] != w[1]);
        let heading = |w: &[[f64; 2]]| atan2(w[1][1] - w[0][1], w[1][0] - w[0][0]);
        let start = self.task.start;
        let leaves = legs.next().map_or(start.yaw, heading);
        let arrives = legs.next_back().map_or(leaves, heading);
        let goal = Pose2 { x: self.task.goal[0], y: self.task.goal[1], yaw: arrives };
        for (end, pose) in [("start", start), ("goal", goal)] {
            self.stands(end, pose, findings);
        }
        self.holds(findings);
        let turned = degrees(turn(start.yaw, leaves).abs());
        if turned > 90.0 {
            let field = format!("{}.start.yaw", self.name);
            let problem =
                format!("faces {turned:.0}° away from the path's first segment: turn it towards the path");
            findings.warn(Rule::Ends, Part::Tasks, &field, &problem);
        }
    }

    /// Whether the vehicle fits where it starts or ends.
    fn stands(&self, end: &str, pose: Pose2, findings: &mut Findings<'_>) {
        let (vehicle, ground) = (&self.limits.vehicle, &self.world.heightfield);
        let (outline, field) = (vehicle.outline(pose), format!("{}.{end}", self.name));
        let at = point([pose.x, pose.y]);
        let mut error = |problem: String| findings.error(Rule::Ends, Part::Tasks, &field, &problem);
        if let Some(k) = self.footprints.hit(&outline) {
            error(format!(
                "at {at} a vehicle of {:.2} x {:.2} m touches obstacles[{k}]: move one of them",
                vehicle.length, vehicle.width
            ));
        }
        if let Some(corner) = outline.iter().find(|p| !ground.contains(p[0], p[1])) {
            error(format!(
                "at {at} a corner of the vehicle, {}, is outside the world: move it inwards",
                point(*corner)
            ));
        }
        let tilt = vehicle.tilt(ground, pose);
        let steep = |limit: f64| {
            format!(
                "at {at} the terrain under the vehicle is tilted by {tilt:.1}°, more than {limit}°: move it to flatter terrain"
            )
        };
        if tilt > self.limits.tilt {
            error(steep(self.limits.tilt));
        } else if tilt > self.limits.end_tilt {
            findings.warn(Rule::Ends, Part::Tasks, &field, &steep(self.limits.end_tilt));
        }
    }

    /// Whether friction holds the vehicle at rest at the start.
    fn holds(&self, findings: &mut Findings<'_>) {
        let Pose2 { x, y, .. } = self.task.start;
        if self.world.class_at(x, y).is_deformable() {
            return;
        }
        let tilt = self.limits.vehicle.tilt(&self.world.heightfield, self.task.start);
        let (s, c) = sin_cos(radians(tilt));
        let (needed, mu) = (s / c, self.world.friction_at(x, y));
        if needed > mu {
            let problem = format!(
                "a vehicle at rest slides off: a tilt of {tilt:.1}° with friction {mu:.2} needs {needed:.2}: \
                 move it to flatter terrain"
            );
            findings.warn(Rule::Ends, Part::Tasks, &format!("{}.start", self.name), &problem);
        }
    }

    /// Distance from obstacles and edges.
    fn distance(&self, findings: &mut Findings<'_>) {
        let (half, path) = (0.5 * self.limits.vehicle.width, &self.task.path);
        if let Some((k, near)) = self.footprints.closest(path) {
            let (field, distance) = (format!("{}.path[{k}]", self.name), near.distance);
            let obstacle = near.obstacle;
            if distance < half {
                let problem = format!(
                    "passes obstacles[{obstacle}] at {distance:.2} m, less than half the vehicle's width of {half:.2} m: re-plan it \
                     or move the obstacle"
                );
                findings.error(Rule::Path, Part::Tasks, &field, &problem);
            } else if distance < self.limits.clearance - ROUNDING {
                let problem = format!(
                    "passes obstacles[{obstacle}] at {distance:.2} m, less than {} m: re-plan it or move the obstacle",
                    self.limits.clearance
                );
                findings.warn(Rule::Path, Part::Tasks, &field, &problem);
            }
        }
        let ground = &self.world.heightfield;
        let beyond =
            |p: &[f64; 2]| p[0].abs() + half > ground.half_x() || p[1].abs() + half > ground.half_y();
        if let Some(k) = path.iter().position(beyond) {
            let problem = format!(
                "{} is closer to the world's edge than half the vehicle's width of {half:.2} m: move it further inwards",
                point(path[k])
            );
            findings.warn(Rule::Path, Part::Tasks, &format!("{}.path[{k}]", self.name), &problem);
        }
    }

    fn waypoints(&self, findings: &mut Findings<'_>) {
        let gaps = self.task.path.windows(2).map(|w| hypot(w[1][0] - w[0][0], w[1][1] - w[0][1]));
        let mut widest = (0, 0.0);
        for (k, gap) in gaps.enumerate() {
            if gap > widest.1 {
                widest = (k, gap);
            }
            if gap == 0.0 {
                let problem = format!("{} is a duplicate: remove it", point(self.task.path[k]));
                findings.warn(Rule::Path, Part::Tasks, &format!("{}.path[{k}]", self.name), &problem);
            }
        }
        if widest.1 > self.limits.spacing + ROUNDING {
            let problem = format!(
                "is {:.2} m from the next waypoint, more than {} m: put waypoints between",
                widest.1, self.limits.spacing
            );
            findings.warn(Rule::Path, Part::Tasks, &format!("{}.path[{}]", self.name, widest.0), &problem);
        }
    }

    /// The steepest place of the path for the vehicle that follows it, every half metre.
    fn tilt(&self, findings: &mut Findings<'_>) {
        const STEP: f64 = 0.5;
        let mut worst = (0, 0.0, [0.0; 2]);
        for (k, w) in self.task.path.windows(2).enumerate() {
            let [dx, dy] = [w[1][0] - w[0][0], w[1][1] - w[0][1]];
            let pieces = (hypot(dx, dy) / STEP).ceil().max(1.0);
            let yaw = atan2(dy, dx);
            for i in 0..pieces as usize {
                let t = i as f64 / pieces;
                let pose = Pose2 { x: w[0][0] + t * dx, y: w[0][1] + t * dy, yaw };
                let tilt = self.limits.vehicle.tilt(&self.world.heightfield, pose);
                if tilt > worst.1 {
                    worst = (k, tilt, [pose.x, pose.y]);
                }
            }
        }
        let (k, tilt, [x, y]) = worst;
        if tilt > self.limits.tilt {
            let problem = format!(
                "tilts the vehicle by {tilt:.1}° at [{x:.1}, {y:.1}], more than {}°: re-plan it around the slope",
                self.limits.tilt
            );
            findings.warn(Rule::Path, Part::Tasks, &format!("{}.path[{k}]", self.name), &problem);
        }
    }
}
