//! The wheels of a robot.

use super::tree::{Joint, Pose, Robot, Shape};
use crate::place::{Mass, length, scale, sub, turn};
use crate::{ImportError, Notes};
use vb_vehicle::{MAX_WHEELS, Point};

/// The width of a wheel over its radius where its shape is a ball.
const BALL: f64 = 0.6;
/// Poses of links, each with the joint that holds it.
pub(super) type Poses = [Option<(Pose, Option<usize>)>];

/// A wheel in the frame of the root link.
#[derive(Clone, Debug)]
pub(super) struct Wheel {
    pub(super) joint: String,
    pub(super) centre: Point,
    pub(super) radius: f64,
    pub(super) width: f64,
    pub(super) mass: f64,
    pub(super) spin: f64,
    /// Greatest steering angle, rad, if a joint steers it.
    pub(super) steers: Option<f64>,
    pub(super) effort: Option<f64>,
    pub(super) velocity: Option<f64>,
}

/// Whether a joint turns on and on, as wheels do.
pub(super) fn turns(j: &Joint) -> bool {
    let range = match j.limit {
        [Some(low), Some(high), ..] => high - low,
        _ => 0.0,
    };
    j.kind == "continuous" || (j.kind == "revolute" && range > 4.0 * std::f64::consts::PI)
}

/// The axis of a joint in the frame in which its child has this pose.
pub(super) fn axis(j: &Joint, pose: &Pose) -> Point {
    let axis = turn(&pose.axes, j.axis);
    scale(axis, 1.0 / length(axis).max(1e-12))
}

pub(super) fn descendants(robot: &Robot, root: usize) -> Vec<usize> {
    let mut out = vec![root];
    let mut k = 0;
    while k < out.len() {
        let link = out[k];
        out.extend(robot.joints.iter().filter(|j| j.parent == link).map(|j| j.child));
        k += 1;
    }
    out
}

/// The wheel on a joint: its size is that of the collision shapes that turn with it.
pub(super) fn wheel(
    robot: &Robot,
    poses: &Poses,
    joint: usize,
    file: &str,
    notes: &mut Notes,
) -> Result<Option<Wheel>, ImportError> {
    let j = &robot.joints[joint];
    let Some((hub, _)) = poses[j.child] else { return Ok(None) };
    let (mut mass, mut radius) = (Mass::default(), 0.0_f64);
    let (mut low, mut high, mut ball) = (f64::INFINITY, f64::NEG_INFINITY, true);
    let links: Vec<usize> = descendants(robot, j.child).into_iter().filter(|l| poses[*l].is_some()).collect();
    let drawn = links.iter().all(|l| robot.links[*l].shapes.is_empty());
    for l in links {
        let Some((pose, _)) = poses[l] else { continue };
        let link = &robot.links[l];
        if link.massive {
            mass = mass.plus(&link.mass.moved(pose.at, &pose.axes));
        }
        let shapes: &[Shape] = if drawn { &link.drawn } else { &link.shapes };
        for s in shapes {
            ball &= s.ball;
            for p in &s.points {
                let d = sub(pose.point(*p), hub.at);
                radius = radius.max(vb_math::hypot(d[0], d[2]));
                (low, high) = (low.min(d[1]), high.max(d[1]));
            }
        }
    }
    if radius <= 0.0 {
        notes.dropped(format!("joint {}: its link has no collision shape, so it is not a wheel", j.name));
        return Ok(None);
    }
    if drawn {
        notes.approximated(format!(
            "joint {}: the wheel's drawing is its shape, since it has no collision shape",
            j.name
        ));
    }
    let mut width = high - low;
    if ball {
        width = BALL * radius;
        notes.assumed(format!("joint {}: a wheel {width:.3} m wide, since its shape is a ball", j.name));
    }
    // The middle of the wheel may lie beside the joint.
    let mut centre = hub.at;
    centre[1] += 0.5 * (low + high);
    let inertia = if mass.mass > 0.0 { mass.central().1[1][1] } else { 0.0 };
    if mass.mass <= 0.0 {
        notes.assumed(format!("joint {}: a wheel of 1 kg, since its link has no mass", j.name));
        mass.mass = 1.0;
    }
    let solid_disc = 0.5 * mass.mass * radius * radius;
    let spin = if inertia > 0.0 { inertia } else { solid_disc };
    Ok(Some(Wheel {
        joint: j.name.clone(),
        centre,
        radius,
        width: width.max(0.05 * radius),
        mass: mass.mass,
        spin,
        steers: steers(robot, poses, joint, centre, radius, file, notes)?,
        effort: j.limit[2].filter(|x| *x > 0.0),
        velocity: j.limit[3].filter(|x| *x > 0.0),
    }))
}

/// The joint with an upright axis that carries a link, if there is one.
pub(super) fn steered(robot: &Robot, poses: &Poses, mut link: usize) -> Option<usize> {
    while let Some((pose, Some(k))) = poses[link] {
        let j = &robot.joints[k];
        if axis(j, &pose)[2].abs() > 0.8 && matches!(j.kind.as_str(), "revolute" | "continuous") {
            return Some(k);
        }
        link = j.parent;
    }
    None
}

/// The greatest steering angle of a wheel, rad, if a joint steers it. Casters are refused.
fn steers(
    robot: &Robot,
    poses: &Poses,
    wheel: usize,
    centre: Point,
    radius: f64,
    file: &str,
    notes: &mut Notes,
) -> Result<Option<f64>, ImportError> {
    let Some(k) = steered(robot, poses, robot.joints[wheel].parent) else { return Ok(None) };
    let j = &robot.joints[k];
    let limit = j.limit[0].into_iter().chain(j.limit[1]).map(f64::abs).fold(0.0, f64::max);
    let hinge = poses[j.child].map_or(centre, |(pose, _)| pose.at);
    let trail = (centre[0] - hinge[0]).abs();
    let named =
        [&j.name, &robot.joints[wheel].name].iter().any(|n| n.to_ascii_lowercase().contains("caster"));
    if named || (limit == 0.0 && trail > 0.1 * radius) {
        let problem =
            "a passive caster has no counterpart; convert a robot with driven or steered wheels only";
        return Err(ImportError::new(file, format!("joint {}", j.name), problem));
    }
    if limit == 0.0 {
        notes.assumed(format!("joint {}: steers by up to 0.5 rad, since it has no limit", j.name));
        return Ok(Some(0.5));
    }
    Ok(Some(limit.min(1.0)))
}

/// Wheels in pairs, from front to back, left before right.
pub(super) fn pair(mut wheels: Vec<Wheel>, file: &str) -> Result<Vec<[Wheel; 2]>, ImportError> {
    let mut out: Vec<[Wheel; 2]> = Vec::new();
    wheels.sort_by(|a, b| b.centre[0].total_cmp(&a.centre[0]));
    while let Some(k) = wheels.iter().position(|w| w.centre[1] > 0.0) {
        let left = wheels.remove(k);
        let near = 0.5 * left.radius;
        let partner = wheels.iter().position(|w| {
            let mirror = [left.centre[0], -left.centre[1], left.centre[2]];
            w.centre[1] < 0.0 && length(sub(w.centre, mirror)) < near
        });
        let Some(p) = partner else {
            let problem = format!(
                "no wheel stands opposite at ({:.3}, {:.3}) m; axles have two",
                left.centre[0], -left.centre[1]
            );
            return Err(ImportError::new(file, format!("joint {}", left.joint), problem));
        };
        let right = wheels.remove(p);
        out.push([left, right]);
    }
    if let Some(w) = wheels.first() {
        let problem = format!(
            "no wheel stands opposite at ({:.3}, {:.3}) m; axles have two",
            w.centre[0], -w.centre[1]
        );
        return Err(ImportError::new(file, format!("joint {}", w.joint), problem));
    }
    if !(2..=MAX_WHEELS / 2).contains(&out.len()) {
        let problem = format!(
            "{} axles; the simulator has vehicles with 2 to {} (casters have no counterpart)",
            out.len(),
            MAX_WHEELS / 2
        );
        return Err(ImportError::new(file, "", problem));
    }
    Ok(out)
}
