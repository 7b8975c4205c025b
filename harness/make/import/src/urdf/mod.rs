//! Robots as URDF, with xacro expanded: wheels on continuous joints, everything else one body.

mod expr;
mod tree;
mod wheel;
mod xacro;
mod xml;

use crate::chrono::{Draft, build, to_the_left, travels};
use crate::hull::{outermost, solid};
use crate::place::Mass;
use crate::{ImportError, Imported, Notes, Options};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use tree::{Pose, Robot};
use vb_vehicle::powertrain::{
    Differential, DirectionChange, Driveline, DrivenAxle, Engine, Gearbox, Powertrain,
};
use vb_vehicle::skid::Skid;
use vb_vehicle::suspension::{
    Damper, DoubleWishbone, Linkage, Part, RigidMount, Spring, SteeredBy, Steering, SteeringGear, Strut,
    Suspension,
};
use vb_vehicle::tyre::BrushTyre;
use vb_vehicle::{Axle, GRAVITY, Point, TyreSpec, VehicleSpec};
use wheel::{Poses, Wheel, axis, descendants, pair, steered, turns, wheel};
use xml::Element;

/// Parts of the hull; more become one part.
const PARTS: usize = 32;
/// Top speed of robots whose joints have no limit of velocity, m/s.
const SPEED: f64 = 2.0;
/// Speed beyond which a limit of velocity limits nothing, m/s, as simulators' files have it.
const FASTEST: f64 = 100.0;
/// The force of a motor, over the robot's weight, beyond which a limit of effort limits nothing.
const STRONGEST: f64 = 20.0;

/// Converts a URDF or xacro file.
///
/// # Errors
/// Returns an error if the file is malformed or describes no vehicle that the simulator has.
pub fn import(file: &Path, text: &str, options: &Options) -> Result<Imported, ImportError> {
    let mut notes = Notes::default();
    let name = file.display().to_string();
    let root = Element::parse(text.trim_start_matches('\u{feff}'), &name)?;
    let root = xacro::expand(file, &root, options, &mut notes)?;
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    for c in root.children.iter().filter(|c| !matches!(c.name.as_str(), "link" | "joint")) {
        *kinds.entry(c.name.as_str()).or_default() += 1;
    }
    for (kind, count) in kinds {
        notes.dropped(format!("<{kind}>, {count} of them"));
    }
    sideways(&root, &name, &mut notes)?;
    let motors = actuated(&root);
    let robot = tree::read(&root, file, options.data.as_deref(), &mut notes)?;
    let robot_name = root.get("name").unwrap_or("robot").to_owned();
    let spec = convert(&robot, robot_name, &name, &motors, options, &mut notes)?;
    let mut imported = Imported { spec, notes, source: format!("the robot description {name}") };
    crate::chrono::deviations(&mut imported);
    Ok(imported)
}

/// Refuses robots on mecanum or omni wheels as far as names and plugins tell.
fn sideways(root: &Element, file: &str, notes: &mut Notes) -> Result<(), ImportError> {
    let texts = root.attributes.iter().map(|(_, v)| v).chain([&root.text]);
    for text in texts {
        let lower = text.to_ascii_lowercase();
        if ["mecanum", "omni_wheel", "omniwheel"].iter().any(|w| lower.contains(w)) {
            let problem = format!(
                "<{}>: {text:?}: wheels that roll sideways have no counterpart; convert a robot with plain wheels",
                root.name
            );
            return Err(ImportError::new(file, root.at(), problem));
        }
        if ["planar_move", "force_based_move"].iter().any(|w| lower.contains(w)) {
            notes.dropped(format!("the plugin {text:?}, which moves the robot in all directions; here its wheels are plain wheels"));
        }
    }
    root.children.iter().try_for_each(|c| sideways(c, file, notes))
}

/// The joints with a motor, as transmissions of ROS 1 and 2 name them.
fn actuated(root: &Element) -> BTreeSet<String> {
    let first = root.named("transmission").flat_map(|t| t.named("joint"));
    let second = root.named("ros2_control").flat_map(|t| t.named("joint"));
    let second = second.filter(|j| j.child("command_interface").is_some());
    first.chain(second).filter_map(|j| j.get("name")).map(str::to_owned).collect()
}

/// The pose of the root link in a frame with x forward. Wheels with axes along x belong to a robot that drives along y, to the
/// side on which its steered wheels are.
fn facing(robot: &Robot, notes: &mut Notes) -> Pose {
    let poses = poses(robot, Pose::ORIGIN);
    let (mut along, mut across) = (Vec::new(), 0_usize);
    for j in robot.joints.iter().filter(|j| turns(j)) {
        let Some((pose, _)) = poses[j.child] else { continue };
        let a = axis(j, &pose);
        across += usize::from(a[1].abs() > 0.7);
        if a[0].abs() > 0.7 && !robot.links[j.child].shapes.is_empty() {
            along.push((pose.at[1], steered(robot, &poses, j.parent).is_some()));
        }
    }
    if along.len() <= across || along.len() < 4 {
        return Pose::ORIGIN;
    }
    let mean = along.iter().map(|w| w.0).sum::<f64>() / along.len() as f64;
    let ahead: f64 = along.iter().filter(|w| w.1).map(|w| w.0 - mean).sum();
    let sign = if ahead < 0.0 { -1.0 } else { 1.0 };
    notes.chosen(format!(
        "the robot drives along {}y, since its wheels turn about x; it is turned to drive along x",
        if sign < 0.0 { "-" } else { "+" }
    ));
    Pose { at: [0.0; 3], axes: [[0.0, sign, 0.0], [-sign, 0.0, 0.0], [0.0, 0.0, 1.0]] }
}

/// Poses of all links in the frame of the root's pose, and for each the joint that holds it.
fn poses(robot: &Robot, root: Pose) -> Vec<Option<(Pose, Option<usize>)>> {
    let mut out: Vec<Option<(Pose, Option<usize>)>> = vec![None; robot.links.len()];
    out[robot.root] = Some((root, None));
    // A robot is a tree, so every pass places a generation.
    for _ in 0..robot.links.len() {
        let mut changed = false;
        for (k, j) in robot.joints.iter().enumerate() {
            if let (Some((parent, _)), None) = (out[j.parent], out[j.child]) {
                out[j.child] = Some((parent.of(&j.pose), Some(k)));
                changed = true;
            }
        }
        if !changed {
            break;
        }
    }
    out
}

fn convert(
    robot: &Robot,
    name: String,
    file: &str,
    motor: &BTreeSet<String>,
    options: &Options,
    notes: &mut Notes,
) -> Result<VehicleSpec, ImportError> {
    let poses = poses(robot, facing(robot, notes));
    let mut wheels = Vec::new();
    let mut within = vec![None; robot.links.len()];
    for (k, j) in robot.joints.iter().enumerate() {
        if !turns(j) {
            continue;
        }
        let Some((pose, _)) = poses[j.child] else { continue };
        let axis = axis(j, &pose);
        if axis[1].abs() < 0.7 {
            if axis[2].abs() < 0.7 {
                notes.dropped(format!(
                    "joint {}: continuous, but its axis does not lie across the robot; it is taken as fixed",
                    j.name
                ));
            }
            continue;
        }
        let Some(wheel) = wheel(robot, &poses, k, file, notes)? else { continue };
        for l in descendants(robot, j.child) {
            within[l] = Some(wheels.len());
        }
        wheels.push(wheel);
    }
    if wheels.is_empty() {
        let problem = "no wheels: no continuous joint has an axis across the robot and a link with a collision shape; give wheels \
                       joints of type=\"continuous\" with an axis along y and a cylinder";
        return Err(ImportError::new(file, "", problem));
    }
    for j in &robot.joints {
        if !matches!(j.kind.as_str(), "fixed" | "continuous")
            && poses[j.child].is_some()
            && within[j.child].is_none()
        {
            notes.approximated(format!(
                "joint {}: {}, but everything between the wheels is one body",
                j.name, j.kind
            ));
        }
    }
    let (sprung, hull) = body(robot, &poses, &within, file)?;
    let pairs = pair(wheels, file)?;
    let total = sprung.mass + pairs.iter().map(|p| p[0].mass + p[1].mass).sum::<f64>();
    let load = total * GRAVITY / (2 * pairs.len()) as f64;
    let is_steered = pairs.iter().flatten().any(|w| w.steers.is_some());
    let mut axles: Vec<Axle> =
        pairs.iter().enumerate().map(|(i, p)| axle(i, pairs.len(), p, load, notes)).collect();
    let moved: Vec<bool> = pairs.iter().map(|p| p.iter().any(|w| motor.contains(&w.joint))).collect();
    if is_steered && moved.contains(&true) {
        axles.iter_mut().zip(moved).for_each(|(a, moved)| a.driven = moved);
    } else {
        notes.assumed("motors drive all axles");
    }
    let tyres: Vec<TyreSpec> = pairs.iter().map(|p| TyreSpec::Brush(tyre(&p[0], load, is_steered))).collect();
    notes.assumed("tyres: a brush with a friction of 0.9 and 5 % of deflection at rest; set them from data of the robot's tyres");
    notes.assumed("steering.rate: 2 per second");
    let first = pairs[0][0].centre;
    let last = pairs[pairs.len() - 1][0].centre;
    let z = pairs.iter().map(|p| p[0].centre[2]).sum::<f64>() / pairs.len() as f64;
    let origin = [0.5 * (first[0] + last[0]), 0.0, z];
    let driven: Vec<&[Wheel; 2]> =
        pairs.iter().zip(&axles).filter(|(_, a)| a.driven).map(|(p, _)| p).collect();
    let powertrain = motors(&driven, total, notes);
    let skid = if is_steered { None } else { skid(&powertrain, pairs[0][0].radius, notes) };
    let by = if is_steered { SteeredBy::Wheels } else { SteeredBy::Differential };
    let draft = Draft {
        name,
        sprung,
        seat: None,
        hull,
        friction: None,
        axles,
        tyres,
        steering: Steering { rate: 2.0, force: None, torque: None, by },
        tracks: None,
        skid,
        powertrain,
    };
    let mut spec = build(draft, origin, options, notes)?;
    for k in 0..spec.axles.len() {
        let radius = spec.tyre_of(&spec.axles[k]).radius();
        travels(&mut spec.axles[k], radius, load, notes)?;
    }
    to_the_left(&mut spec, notes);
    Ok(spec)
}

/// The skid steering of a robot whose wheels no joint steers. URDF has no data of it.
fn skid(powertrain: &Powertrain, radius: f64, notes: &mut Notes) -> Option<Skid> {
    let Engine::Electric { torque, .. } = &powertrain.engine else { return None };
    let (torque, speed) = (torque.first()?[1], powertrain.governor.as_ref()?.speed);
    notes.assumed(
        "skid: no joint steers a wheel, so the sides turn at different speeds: at full command by the mean speed, and by half of the top \
         speed in place; set them from the limits of the robot's controller. Rollers of mecanum wheels, which URDF does not have, are none here",
    );
    let at_rest = 0.5 * speed;
    // A side's share of the torque for a twentieth of the difference in place.
    let gain = 0.5 * torque / (0.05 * at_rest / radius);
    Some(Skid::Speed { relative: 1.0, at_rest, gain })
}

/// The body of all links that turn with no wheel, and its convex parts.
fn body(
    robot: &Robot,
    poses: &Poses,
    within: &[Option<usize>],
    file: &str,
) -> Result<(Mass, Vec<Vec<Point>>), ImportError> {
    let mut mass = Mass::default();
    let mut hull: Vec<Vec<Point>> = Vec::new();
    for (l, link) in robot.links.iter().enumerate() {
        let (Some((pose, _)), None) = (poses[l], within[l]) else { continue };
        if link.massive {
            mass = mass.plus(&link.mass.moved(pose.at, &pose.axes));
        }
        for s in &link.shapes {
            let points: Vec<Point> = s.points.iter().map(|p| pose.point(*p)).collect();
            if solid(&points) {
                hull.push(points);
            }
        }
    }
    if mass.mass <= 0.0 {
        return Err(ImportError::new(
            file,
            "",
            "no link but the wheels has a mass; give the body an <inertial>",
        ));
    }
    if hull.len() > PARTS {
        hull = vec![outermost(&hull.concat())];
    }
    Ok((mass, hull))
}

/// The tyre of a wheel. Where the sides turn at different speeds, all wheels slide: the stiffness is then the same in both
/// directions, so that the friction opposes the slip.
fn tyre(w: &Wheel, load: f64, is_steered: bool) -> BrushTyre {
    let (slip_stiffness, along) = if is_steered { ([17.8, 7.4], 0.5) } else { ([12.0, 12.0], 1.0) };
    let vertical_stiffness = load / (0.05 * w.radius);
    BrushTyre {
        radius: w.radius,
        width: w.width,
        friction: 0.9,
        vertical_stiffness,
        vertical_damping: 0.2 * (vertical_stiffness * load / GRAVITY).sqrt(),
        slip_stiffness,
        relaxation_length: [along * w.radius, w.radius],
        damping_ratio: 0.25,
        rolling_resistance: 0.015,
    }
}

/// The axle of two wheels: fixed to the body, or on short wishbones if a joint steers them.
fn axle(index: usize, count: usize, [left, right]: &[Wheel; 2], load: f64, notes: &mut Notes) -> Axle {
    let r = left.radius;
    let y = 0.5 * (left.centre[1] - right.centre[1]);
    let (suspension, steering) = match left.steers.or(right.steers) {
        None => (
            Suspension {
                linkage: Linkage::Rigid(RigidMount { spindle: [0.0, y, 0.0] }),
                range: [0.0; 2],
                struts: Vec::new(),
                stops: None,
                anti_roll: None,
            },
            None,
        ),
        Some(angle) => {
            notes.approximated(format!(
                "joint {}: steered wheels stand on short wishbones with springs that give way by 5 % of the radius, since vehicles steer \
                 by tie rods",
                left.joint
            ));
            (
                wishbones(y, r, load),
                Some(SteeringGear::RackAndPinion { travel: 0.5 * r * vb_math::sin_cos(angle).0 }),
            )
        }
    };
    let torque = 0.9 * load * r;
    notes.assumed(format!("brake_torque: {torque:.3} N m a wheel, enough to lock it"));
    Axle {
        name: match (index, count) {
            (0, _) => "front".to_owned(),
            (k, n) if k + 1 == n => "rear".to_owned(),
            (k, _) => format!("axle{}", k + 1),
        },
        position: [left.centre[0], 0.0, left.centre[2]],
        steering,
        driven: true,
        unsprung_mass: 0.5 * (left.mass + right.mass),
        spin_inertia: 0.5 * (left.spin + right.spin),
        brake_torque: torque,
        suspension,
        tyre: None,
        tyres: BTreeMap::new(),
    }
}

/// Wishbones of a size that follows from wheel and track, with the tie rods behind.
fn wishbones(y: f64, r: f64, load: f64) -> Suspension {
    let arm = (0.6 * y).min(1.5 * r);
    let (outer, inner) = (y - 0.2 * r, y - 0.2 * r - arm);
    let rise = 0.4 * r;
    let at = |x: f64, y: f64, z: f64| [x, y, z];
    let linkage = DoubleWishbone {
        spindle: [0.0, y, 0.0],
        upper_arm_front: at(0.3 * r, inner, rise),
        upper_arm_rear: at(-0.3 * r, inner, rise),
        upper_ball_joint: at(0.0, outer, rise),
        lower_arm_front: at(0.3 * r, inner, -rise),
        lower_arm_rear: at(-0.3 * r, inner, -rise),
        lower_ball_joint: at(0.0, outer, -rise),
        tie_rod_inner: at(-0.5 * r, inner, 0.0),
        tie_rod_outer: at(-0.5 * r, outer, 0.0),
    };
    let stiffness = load / (0.05 * r);
    let tall = 1.5 * r;
    Suspension {
        linkage: Linkage::DoubleWishbone(linkage),
        range: [0.0; 2],
        struts: vec![Strut {
            chassis: at(0.0, outer, -rise + tall),
            end: at(0.0, outer, -rise),
            part: Part::Upright,
            spring: Some(Spring::Linear { stiffness, free_length: tall + load / stiffness, preload: 0.0 }),
            damper: Some(Damper::Linear { coefficient: 0.6 * (stiffness * load / GRAVITY).sqrt() }),
            stops: None,
        }],
        stops: None,
        anti_roll: None,
    }
}

/// Electric motors on all axles, from the limits of the joints.
fn motors(pairs: &[&[Wheel; 2]], total: f64, notes: &mut Notes) -> Powertrain {
    let radius = pairs[0][0].radius;
    let all = || pairs.iter().copied().flatten();
    let velocity = all().filter_map(|w| w.velocity).fold(f64::INFINITY, f64::min);
    let velocity = if velocity * radius < FASTEST {
        velocity
    } else {
        notes.assumed(format!(
            "top speed of {SPEED} m/s, since no wheel's joint has a limit of velocity below {FASTEST} m/s"
        ));
        SPEED / radius
    };
    let effort: f64 = all().filter_map(|w| w.effort).sum();
    let weight = total * GRAVITY * radius;
    let torque = if effort > 0.0 && effort < STRONGEST * weight {
        effort
    } else {
        notes.assumed(format!(
            "motors push with up to 0.6 of the weight, since the wheels' joints have no limits of effort below {STRONGEST} times the weight"
        ));
        0.6 * weight
    };
    notes.approximated("one electric motor drives all driven wheels by open differentials; its torque falls to none at 1.5 times the top speed");
    let fraction = 1.0 / pairs.len() as f64;
    let axle = DrivenAxle {
        fraction,
        final_drive: 1.0,
        shaft_inertia: 0.0,
        box_inertia: 0.0,
        differential: Differential::Open {},
    };
    let inertia = all().map(|w| w.spin).sum::<f64>() * 0.1;
    Powertrain {
        engine: Engine::Electric {
            torque: vec![[0.0, torque], [1.5 * velocity, 0.0]],
            regeneration: 1.0,
            friction: 0.0,
            voltage: Vec::new(),
            inertia,
        },
        converter: None,
        gearbox: Gearbox {
            ratios: vec![1.0],
            reverse: Some(-1.0),
            direction_change: DirectionChange { speed: 0.1, latency: 0.05 },
            shift_down: vec![0.0],
            shift_up: vec![10.0 * velocity],
            shift_time: 0.0,
            latency: 0.0,
            load_sensing: false,
        },
        driveline: Driveline {
            shaft_inertia: 0.0,
            centre: Differential::Open {},
            axles: vec![axle; pairs.len()],
        },
        governor: Some(vb_vehicle::powertrain::Governor {
            speed: velocity * radius,
            band: 0.1 * velocity * radius,
        }),
    }
}
