//! A replay as an MCAP file with Foxglove's schemas, for Foxglove and whatever reads them.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::sync::Arc;

use foxglove::messages::{
    Color, CylinderPrimitive, FrameTransform, FrameTransforms, KeyValuePair, LinePrimitive, Log, Odometry,
    Point3, Pose, SceneEntity, SceneEntityDeletion, SceneUpdate, SpherePrimitive, Timestamp,
    TriangleListPrimitive, line_primitive, log, scene_entity_deletion,
};
use foxglove::{Channel, ChannelBuilder, Context, McapWriteOptions, McapWriter};
use nalgebra::UnitQuaternion;
use serde_json::json;
use vb_world::World;

use crate::attitude::attitude;
use crate::debug::Lines;
use crate::messages::{WORLD, at, json_channel, pose, quaternion, vector};
use crate::scene::{Mesh, ground, obstacles, parts};
use crate::sensors_file::{write_grains, write_sensors};
use crate::{Replay, ReplayError, ReplayRun};

/// Height of lines above the ground, m.
const ABOVE: f64 = 0.15;

/// JSON Schema of the topic `state`.
const STATE_SCHEMA: &str = r#"{"title":"vb.State","type":"object","properties":{
"speed":{"type":"number","description":"m/s"},"roll":{"type":"number","description":"degrees, positive right side down"},
"pitch":{"type":"number","description":"degrees, positive nose down"},"yaw":{"type":"number","description":"degrees"},
"steering":{"type":"number"},"throttle":{"type":"number"},"brake":{"type":"number"}}}"#;
/// JSON Schema of the topic `planner`: values by the names of the planner's series.
const PLANNER_SCHEMA: &str =
    r#"{"title":"vb.Planner","type":"object","additionalProperties":{"type":"number"}}"#;

fn point(v: [f64; 3]) -> Point3 {
    Point3 { x: v[0], y: v[1], z: v[2] }
}

fn colour(rgb: [u8; 3], alpha: f64) -> Color {
    let [r, g, b] = rgb.map(|c| f64::from(c) / 255.0);
    Color { r, g, b, a: alpha }
}

/// The colours of runs that are shown together, in their order, red, green and blue in sRGB: those of the page
/// (`web/src/data.js`). Further runs begin with the first again.
pub const RUN_COLOURS: [[u8; 3]; 8] = [
    [42, 111, 179],
    [208, 122, 29],
    [44, 140, 90],
    [128, 87, 184],
    [192, 65, 43],
    [22, 138, 146],
    [138, 102, 54],
    [185, 72, 136],
];

/// Writes the replay. Time is that of the simulation, as if it had begun at the epoch. Topics: `/world` (ground, obstacles,
/// global path, start and goal), `/tf` (chassis and wheels), and of each run, `/runN` its vehicle (`vehicle`), odometry
/// (`odometry`), angles and commands (`state`), the grains of granular beds (`grains`), what its sensors measured (`lidar`, `depth`, `local_map`, `estimate`, `gnss`, `imu`), the
/// planner's lines (`plan`) and curves (`planner`), and the outcome (`outcome`). `path` is what the file is called in errors.
pub fn write_mcap(replay: &Replay, file: File, path: &Path) -> Result<(), ReplayError> {
    let fail = |detail: String| ReplayError::Mcap { path: path.to_owned(), detail };
    let context = Context::new();
    let options = McapWriteOptions::new().compression(None).library("vb-harness");
    let writer = McapWriter::with_options(options).context(&context);
    let handle = writer.create(BufWriter::new(file)).map_err(|e| fail(e.to_string()))?;

    let (stamp, start) = at(0.0);
    let world = ChannelBuilder::new("/world").context(&context).build::<SceneUpdate>();
    world.log_with_meta(&world_scene(replay, stamp), start);
    let tf = ChannelBuilder::new("/tf").context(&context).build::<FrameTransforms>();
    for (k, run) in replay.runs.iter().enumerate() {
        write_run(replay, run, k, &context, &tf).map_err(|e| fail(e.to_string()))?;
    }
    let mut file = handle.close().map_err(|e| fail(e.to_string()))?;
    std::io::Write::flush(&mut file).map_err(|e| fail(e.to_string()))
}

fn write_run(
    replay: &Replay,
    run: &ReplayRun,
    k: usize,
    context: &Arc<Context>,
    tf: &Channel<FrameTransforms>,
) -> Result<(), foxglove::FoxgloveError> {
    let frame = format!("run{k}");
    let vehicle = ChannelBuilder::new(format!("/{frame}/vehicle")).context(context).build::<SceneUpdate>();
    let odometry = ChannelBuilder::new(format!("/{frame}/odometry")).context(context).build::<Odometry>();
    let plan = ChannelBuilder::new(format!("/{frame}/plan")).context(context).build::<SceneUpdate>();
    let outcome = ChannelBuilder::new(format!("/{frame}/outcome")).context(context).build::<Log>();
    let state = json_channel(format!("/{frame}/state"), ("vb.State", STATE_SCHEMA), context)?;
    let planner = json_channel(format!("/{frame}/planner"), ("vb.Planner", PLANNER_SCHEMA), context)?;

    let (stamp, meta) = at(0.0);
    vehicle.log_with_meta(&vehicle_scene(run, k, &frame, stamp), meta);
    let m = &run.motion;
    for (i, f) in m.frames.iter().enumerate() {
        let (stamp, meta) = at(f.time);
        let q = attitude(f);
        let transform =
            |parent: &str, child: String, to: [f64; 3], turn: UnitQuaternion<f64>| FrameTransform {
                timestamp: Some(stamp),
                parent_frame_id: parent.to_owned(),
                child_frame_id: child,
                translation: Some(vector(to)),
                rotation: Some(quaternion(turn)),
            };
        let mut transforms = vec![transform(WORLD, frame.clone(), [f.x, f.y, f.z], q)];
        for (w, wheel) in m.wheel_frames[i * m.wheels..(i + 1) * m.wheels].iter().enumerate() {
            let axis = nalgebra::Vector3::from(wheel.axis);
            let steer = UnitQuaternion::rotation_between(&nalgebra::Vector3::y(), &axis).unwrap_or_default();
            let spin = UnitQuaternion::from_axis_angle(&nalgebra::Vector3::y_axis(), wheel.angle);
            transforms.push(transform(&frame, format!("{frame}/wheel{w}"), wheel.hub, steer * spin));
        }
        tf.log_with_meta(&FrameTransforms { transforms }, meta);
        let odometry_message = Odometry {
            timestamp: Some(stamp),
            frame_id: WORLD.into(),
            body_frame_id: frame.clone(),
            pose: Some(Pose { position: Some(vector([f.x, f.y, f.z])), orientation: Some(quaternion(q)) }),
            linear_velocity: Some(vector([f.vx, f.vy, f.vz])),
            angular_velocity: Some(vector([f.wx, f.wy, f.wz])),
            ..Odometry::default()
        };
        odometry.log_with_meta(&odometry_message, meta);
        let degrees = vb_math::angle::degrees;
        let message = json!({
            "speed": (f.vx * f.vx + f.vy * f.vy + f.vz * f.vz).sqrt(),
            "roll": degrees(f.roll), "pitch": degrees(f.pitch), "yaw": degrees(f.yaw),
            "steering": f.steering, "throttle": f.throttle, "brake": f.brake,
        });
        state.log_with_meta(message.to_string().as_bytes(), meta);
    }
    write_sensors(&run.sensed, &frame, context)?;
    write_grains(&m.grains, m.end(), &frame, context);
    for lines in run.series.lines() {
        let (stamp, meta) = at(lines.time);
        plan.log_with_meta(&plan_scene(replay, &lines, stamp), meta);
    }
    for (name, points) in run.series.curves() {
        for [time, value] in points {
            planner.log_with_meta(json!({ name: value }).to_string().as_bytes(), at(time).1);
        }
    }
    let (stamp, meta) = at(m.end());
    let success = run.record.outcome == vb_score::Outcome::Success;
    let message = Log {
        timestamp: Some(stamp),
        level: if success { log::Level::Info } else { log::Level::Warning } as i32,
        message: format!("{}: {}", run.record.outcome, run.record.explanation()),
        name: run.label.clone(),
        ..Log::default()
    };
    outcome.log_with_meta(&message, meta);
    Ok(())
}

/// An entity that stays.
fn entity(id: &str, frame: &str, stamp: Timestamp) -> SceneEntity {
    SceneEntity {
        timestamp: Some(stamp),
        frame_id: frame.into(),
        id: id.into(),
        frame_locked: true,
        ..SceneEntity::default()
    }
}

fn triangles(mesh: &Mesh, colour: Color) -> TriangleListPrimitive {
    TriangleListPrimitive {
        pose: Some(pose([0.0; 3])),
        points: mesh.points.iter().map(|p| point(*p)).collect(),
        color: Some(colour),
        colors: Vec::new(),
        indices: mesh.triangles.concat(),
    }
}

fn line(points: Vec<Point3>, thickness: f64, colour: Color) -> LinePrimitive {
    LinePrimitive {
        r#type: line_primitive::Type::LineStrip as i32,
        pose: Some(pose([0.0; 3])),
        thickness,
        points,
        color: Some(colour),
        ..LinePrimitive::default()
    }
}

/// A point above the ground.
fn above(world: &World, x: f64, y: f64) -> Point3 {
    point([x, y, world.heightfield.height(x, y) + ABOVE])
}

fn world_scene(replay: &Replay, stamp: Timestamp) -> SceneUpdate {
    let world = &replay.world;
    let (rows, cols, pitch, heights) = ground(world);
    let at = |r: usize, c: usize| {
        let (x, y) = (
            c as f64 * pitch[0] - world.heightfield.half_x(),
            r as f64 * pitch[1] - world.heightfield.half_y(),
        );
        [x, y, heights[r * cols + c]]
    };
    let mut surface =
        TriangleListPrimitive { pose: Some(pose([0.0; 3])), ..TriangleListPrimitive::default() };
    for r in 0..rows {
        for c in 0..cols {
            let p = at(r, c);
            surface.points.push(point(p));
            surface.colors.push(colour(world.class_at(p[0], p[1]).colour(), 1.0));
            if r + 1 < rows && c + 1 < cols {
                let i = (r * cols + c) as u32;
                let (e, n) = (i + 1, i + cols as u32);
                surface.indices.extend([i, e, n + 1, i, n + 1, n]);
            }
        }
    }
    let mut terrain = entity("ground", WORLD, stamp);
    terrain.triangles.push(surface);
    terrain.metadata = [
        ("suite", replay.suite.as_str()),
        ("world", world.id.as_str()),
        ("task", replay.task.id.as_str()),
        ("elevation", world.elevation.name()),
        ("terrain", world.terrain.name()),
        ("density", world.density.name()),
    ]
    .map(|(key, value)| KeyValuePair { key: key.into(), value: value.into() })
    .into();
    let mut things = entity("obstacles", WORLD, stamp);
    for (trunk, mesh) in obstacles(world) {
        things.triangles.push(triangles(&mesh, colour(if trunk { [92, 70, 48] } else { [96, 94, 92] }, 1.0)));
    }
    if !replay.has_goal {
        return SceneUpdate { deletions: Vec::new(), entities: vec![terrain, things] };
    }
    let mut path = entity("global path", WORLD, stamp);
    let points = replay.task.path.iter().map(|p| above(world, p[0], p[1])).collect();
    path.lines.push(line(points, 0.2, colour([255, 255, 255], 0.8)));
    let mut goal = entity("goal", WORLD, stamp);
    let [x, y] = replay.task.goal;
    let radius = replay.goal_radius.unwrap_or(1.0);
    let circle = (0..=64).map(|k| {
        let (s, c) = vb_math::sin_cos(f64::from(k) * std::f64::consts::TAU / 64.0);
        above(world, x + radius * c, y + radius * s)
    });
    goal.lines.push(line(circle.collect(), 0.25, colour([255, 210, 63], 1.0)));
    SceneUpdate { deletions: Vec::new(), entities: vec![terrain, things, path, goal] }
}

fn vehicle_scene(run: &ReplayRun, k: usize, frame: &str, stamp: Timestamp) -> SceneUpdate {
    let own = RUN_COLOURS[k % RUN_COLOURS.len()];
    let mut hull = entity("hull", frame, stamp);
    hull.triangles = parts(&run.vehicle).iter().map(|p| triangles(p, colour(own, 1.0))).collect();
    hull.metadata.push(KeyValuePair { key: "run".into(), value: run.label.clone() });
    let mut entities = vec![hull];
    // Wheels in a belt are drawn with it.
    let belt = run.vehicle.tracks.as_ref().map_or(0.0, |t| t.thickness);
    for (w, [radius, width]) in run.vehicle.wheel_sizes().into_iter().enumerate().take(run.motion.wheels) {
        let radius = radius + belt;
        let mut wheel = entity("wheel", &format!("{frame}/wheel{w}"), stamp);
        wheel.id = format!("wheel{w}");
        // Foxglove's cylinders stand along z, a wheel's axis is y.
        let turn = UnitQuaternion::from_axis_angle(&nalgebra::Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
        wheel.cylinders.push(CylinderPrimitive {
            pose: Some(Pose { position: Some(vector([0.0; 3])), orientation: Some(quaternion(turn)) }),
            size: Some(vector([2.0 * radius, 2.0 * radius, width])),
            bottom_scale: 1.0,
            top_scale: 1.0,
            color: Some(colour([40, 40, 42], 1.0)),
        });
        entities.push(wheel);
    }
    SceneUpdate { deletions: Vec::new(), entities }
}

/// The planner's lines of one name at one time, which replace those before.
fn plan_scene(replay: &Replay, lines: &Lines<'_>, stamp: Timestamp) -> SceneUpdate {
    let mut own = entity(lines.name, WORLD, stamp);
    for l in &lines.lines {
        let points: Vec<Point3> = l
            .iter()
            .map(|&(x, y, z)| match z {
                Some(z) => point([x, y, z]),
                None => above(&replay.world, x, y),
            })
            .collect();
        let paint = colour([64, 224, 208], 0.9);
        match &points[..] {
            // A place.
            [p] => own.spheres.push(SpherePrimitive {
                pose: Some(pose([p.x, p.y, p.z])),
                size: Some(vector([0.5; 3])),
                color: Some(paint),
            }),
            _ => own.lines.push(line(points, 0.08, paint)),
        }
    }
    let deletion = SceneEntityDeletion {
        timestamp: Some(stamp),
        r#type: scene_entity_deletion::Type::MatchingId as i32,
        id: lines.name.into(),
    };
    SceneUpdate { deletions: vec![deletion], entities: vec![own] }
}

#[cfg(test)]
mod tests {
    use super::RUN_COLOURS;

    #[test]
    fn runs_have_the_same_colours_on_the_page() {
        let hex: Vec<String> =
            RUN_COLOURS.iter().map(|[r, g, b]| format!("'#{r:02x}{g:02x}{b:02x}'")).collect();
        let page = include_str!("../web/src/data.js");
        assert!(page.contains(&format!("COLOURS = [{}]", hex.join(", "))), "{hex:?}");
    }
}
