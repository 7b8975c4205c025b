//! What is shown: the world, and the runs of one of its tasks.

use std::sync::Arc;

use nalgebra::{Rotation3, Vector3};
use rapier3d_f64::parry;
use serde_json::{Value, json};
use vb_score::{Rules, TaskRecord};
use vb_vehicle::{GRAVITY, VehicleSpec};
use vb_world::{ObstacleKind, SoilLevel, Task, TaskId, TerrainClass, World};

use crate::attitude::attitude;
use crate::debug::PlannerSeries;
use crate::facts::facts;
use crate::linkage::carriers;
use crate::motion::{Motion, Repeat, Rut};
use crate::packed::{TIME, packed, steps};
use crate::sensed::Sensed;

/// Nodes along a side of the ground as drawn; a finer one is thinned.
const NODES: usize = 513;

#[derive(Clone, Debug)]
pub struct ReplayRun {
    pub label: String,
    /// The line of tasks.jsonl.
    pub record: TaskRecord,
    /// The rules by which the task was judged; none where they are unknown.
    pub rules: Option<Rules>,
    pub vehicle: Arc<VehicleSpec>,
    pub motion: Motion,
    /// What the planner sent.
    pub series: PlannerSeries,
    /// What the sensors measured; nothing where the simulation can't be repeated.
    pub sensed: Sensed,
}

/// A task with its runs.
#[derive(Clone, Debug)]
pub struct Replay {
    /// The world, scaled as it was simulated.
    pub world: Arc<World>,
    pub task: Task,
    pub suite: String,
    /// Whether the task has a goal: an exploration has none, and its task's goal is where it began.
    pub has_goal: bool,
    /// Distance from the goal in the plane within which the task is a success by the first run's rules, m, if they have one.
    pub goal_radius: Option<f64>,
    /// The runs, at least one; the first is the one that is followed.
    pub runs: Vec<ReplayRun>,
}

/// Triangles of a convex body.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Mesh {
    /// m.
    pub(crate) points: Vec<[f64; 3]>,
    /// Counter-clockwise from outside.
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The hull of points; none if they lie in a plane.
    pub(crate) fn hull(points: &[[f64; 3]]) -> Option<Self> {
        let given: Vec<parry::math::Vector> =
            points.iter().map(|p| parry::math::Vector::new(p[0], p[1], p[2])).collect();
        let (points, triangles) = parry::transformation::try_convex_hull(&given).ok()?;
        Some(Self { points: points.iter().map(|p| [p.x, p.y, p.z]).collect(), triangles })
    }

    /// Turned about z and moved.
    fn placed(mut self, yaw: f64, to: [f64; 3]) -> Self {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), yaw);
        for p in &mut self.points {
            *p = (turn * Vector3::from(*p) + Vector3::from(to)).into();
        }
        self
    }
}

/// Meshes for the page, as `unpackMeshes` of `web/src/packed.js` reads them: of each the numbers of its points and triangles, and one
/// after the other the points, to the nearest multiple of `unit` (m), and the triangles, as numbers of the mesh's own points.
fn meshes<'a>(all: impl Iterator<Item = &'a Mesh> + Clone, unit: f64) -> Value {
    let counts = all.clone().map(|m| [m.points.len() as f64, m.triangles.len() as f64]);
    let points = all.clone().flat_map(|m| m.points.iter().copied());
    let triangles = all.flat_map(|m| m.triangles.iter().map(|t| t.map(f64::from)));
    json!({
        "counts": packed(counts, [1.0; 2]),
        "points": packed(points, [unit; 3]),
        "triangles": packed(triangles, [1.0; 3]),
    })
}

/// An obstacle where it stands.
pub(crate) fn obstacles(world: &World) -> Vec<(bool, Mesh)> {
    let mesh = |o: &vb_world::Obstacle| {
        let trunk = matches!(o.kind, ObstacleKind::Trunk { .. });
        Some((trunk, Mesh::hull(&o.hull())?.placed(o.yaw, [o.x, o.y, o.base_z(&world.heightfield)])))
    };
    world.obstacles.iter().filter_map(mesh).collect()
}

/// The convex parts of a vehicle's hull, in the frame of its chassis.
pub(crate) fn parts(vehicle: &VehicleSpec) -> Vec<Mesh> {
    vehicle.chassis.hull.iter().filter_map(|part| Mesh::hull(part)).collect()
}

/// The colour of a label of the depth camera, sRGB.
pub(crate) fn label_colour(label: u8) -> [u8; 3] {
    match TerrainClass::from_label(label) {
        Some(class) => class.colour(),
        // An obstacle; nothing.
        None if label == 10 => [192, 65, 43],
        None => [0, 0, 0],
    }
}

fn round(v: f64, per_unit: f64) -> f64 {
    (v * per_unit).round() / per_unit
}

/// The ground thinned to what is drawn: rows, columns, resolution (m) along x and y, heights.
pub(crate) fn ground(world: &World) -> (usize, usize, [f64; 2], Vec<f64>) {
    let h = &world.heightfield;
    let stride = |n: usize| (n - 1).div_ceil(NODES - 1).max(1);
    let (sr, sc) = (stride(h.rows()), stride(h.cols()));
    // The last row and column are always drawn: the spacing is even, heights are asked for in between if need be.
    let (rows, cols) = ((h.rows() - 1).div_ceil(sr) + 1, (h.cols() - 1).div_ceil(sc) + 1);
    let resolution = [2.0 * h.half_x() / (cols - 1) as f64, 2.0 * h.half_y() / (rows - 1) as f64];
    let mut heights = Vec::with_capacity(rows * cols);
    for r in 0..rows {
        for c in 0..cols {
            heights
                .push(h.height(c as f64 * resolution[0] - h.half_x(), r as f64 * resolution[1] - h.half_y()));
        }
    }
    (rows, cols, resolution, heights)
}

/// The granular beds: corners, the heights of floor and ground there, m, and the colour of the grains.
fn beds(world: &World) -> Vec<Value> {
    let bed = |bed: &vb_world::GranularBed| {
        let top = world.heightfield.height(bed.x, bed.y);
        json!({"corners": bed.corners(), "heights": [top - bed.depth, top], "colour": bed.material.class.colour()})
    };
    world.beds.iter().map(bed).collect()
}

impl Replay {
    /// The name of the task in its suite.
    #[must_use]
    pub fn id(&self) -> TaskId {
        self.world.task_id(&self.task)
    }

    /// Everything as JSON for the page's script.
    pub(crate) fn json(&self) -> Value {
        let world = &self.world;
        let h = &world.heightfield;
        let (rows, cols, resolution, heights) = ground(world);
        let s = &world.semantics;
        let classes: Vec<Value> = TerrainClass::ALL
            .iter()
            .map(|c| {
                let soil = s.soil.of(*c).map(SoilLevel::name);
                json!({"name": c.name(), "colour": c.colour(), "soil": soil, "there": s.classes.contains(c)})
            })
            .collect();
        let task = &self.task;
        let point = |p: &[f64; 2]| [round(p[0], 1e3), round(p[1], 1e3)];
        let length = unit_of_length(world);
        let obstacles = obstacles(world);
        let bodies = |trunk: bool| meshes(obstacles.iter().filter(|o| o.0 == trunk).map(|o| &o.1), length);
        json!({
            "suite": self.suite,
            "task": self.id(),
            "labels": [world.elevation.name(), world.terrain.name(), world.density.name()],
            "scale": world.scale,
            "ground": {
                "rows": rows,
                "cols": cols,
                "resolution": resolution,
                "half": [h.half_x(), h.half_y()],
                "heights": packed(heights.into_iter().map(|z| [z]), [length]),
            },
            "semantics": {
                "rows": s.rows,
                "cols": s.cols,
                "patch": s.patch,
                "labels": s.classes.iter().map(|c| char::from(b'0' + c.label())).collect::<String>(),
                "classes": classes,
            },
            "beds": beds(world),
            "stones": bodies(false),
            "trunks": bodies(true),
            "start": [task.start.x, task.start.y, task.start.yaw],
            "goal": self.has_goal.then_some(task.goal),
            "radius": self.goal_radius,
            "path": task.path.iter().map(point).collect::<Vec<_>>(),
            "runs": self.runs.iter().map(|r| run(r, world)).collect::<Vec<_>>(),
        })
    }
}

fn vehicle(spec: &VehicleSpec, unit: f64) -> Value {
    json!({
        "name": spec.name,
        "parts": meshes(parts(spec).iter(), unit),
        "wheels": spec.wheel_sizes(),
        "axles": spec.axles.iter().map(|a| &a.name).collect::<Vec<_>>(),
        "carriers": carriers(spec),
        "belt": spec.tracks.as_ref().map(|t| t.thickness),
        "length": spec.length,
    })
}

/// A task with its vehicle, for a page in which somebody drives: what a replay has, without runs.
#[must_use]
pub fn live_scene(
    world: &Arc<World>,
    task: &Task,
    suite: &str,
    goal_radius: f64,
    spec: &VehicleSpec,
) -> Value {
    let (world, task) = (world.clone(), task.clone());
    let (goal_radius, unit) = (Some(goal_radius), unit_of_length(&world));
    let mut scene =
        Replay { world, task, suite: suite.to_owned(), has_goal: true, goal_radius, runs: Vec::new() }.json();
    scene["vehicle"] = vehicle(spec, unit);
    scene
}

/// The height of a change of the ground that is one on the page, m.
const RUT: f64 = 1e-3;

/// Ruts for the page: when how many of them are told, and of each the number of its cell from the west and from the south, and
/// by how much the ground is higher there.
fn ruts(m: &Motion, world: &World) -> Value {
    let side = m.soil_resolution;
    let half = [world.heightfield.half_x(), world.heightfield.half_y()];
    let cell = |rut: &Rut, axis: usize| (rut.at[axis] + half[axis]) / side - 0.5;
    let ruts = m.ruts.iter().map(|r| [cell(r, 0), cell(r, 1), r.change()]);
    json!({"side": side, "steps": steps(m.ruts.iter().map(|rut| rut.time)), "cells": packed(ruts, [1.0, 1.0, RUT])})
}

/// Units of what wheels and ground do to each other on the page: the share of the weight, the slip, the depth in m.
const CONTACT: [f64; 3] = [1e-3, 1e-2, 1e-4];
/// Unit of places on the page, m at scale 1; less than one sees.
const LENGTH: f64 = 2e-4;
/// The same in a world of any scale: finer where all is smaller.
fn unit_of_length(world: &World) -> f64 {
    LENGTH * world.scale.min(1.0)
}
/// Unit of the parts of quaternions and of unit vectors: a millimetre at the end of 50 m.
const DIRECTION: f64 = 2e-5;
/// Unit of the wheels' angles, rad.
const ANGLE: f64 = 1e-3;
/// Units of speed (m/s), of roll and pitch (degrees), and of the commands.
const SIGNALS: [f64; 6] = [1e-3, 1e-2, 1e-2, 1e-3, 1e-3, 1e-3];

fn run(run: &ReplayRun, world: &World) -> Value {
    let m = &run.motion;
    let r = &run.record;
    let length = unit_of_length(world);
    let poses = m.frames.iter().map(|f| {
        let q = attitude(f);
        [f.x, f.y, f.z, q.i, q.j, q.k, q.w]
    });
    let signals = m.frames.iter().map(|f| {
        let speed = (f.vx * f.vx + f.vy * f.vy + f.vz * f.vz).sqrt();
        let degrees = vb_math::angle::degrees;
        [speed, degrees(f.roll), degrees(f.pitch), f.steering, f.throttle, f.brake]
    });
    // Each wheel by itself: it departs little from where it just was, but much from the others.
    let wheel = |k: usize| {
        let frames = m.wheel_frames.iter().skip(k).step_by(m.wheels.max(1)).map(|w| {
            let ([a, b, c], [d, e, f]) = (w.hub, w.axis);
            [a, b, c, d, e, f, w.angle]
        });
        packed(frames, [length, length, length, DIRECTION, DIRECTION, DIRECTION, ANGLE])
    };
    let wheels: Vec<Value> = (0..m.wheels).map(wheel).collect();
    let spec = &run.vehicle;
    let weight = spec.total_mass() * GRAVITY;
    let contact = |k: usize| {
        let frames = m.contacts.iter().skip(k).step_by(m.wheels.max(1));
        packed(frames.map(|c| [c.load / weight, c.slip, c.sinkage]), CONTACT)
    };
    let contact: Option<Vec<Value>> = (!m.contacts.is_empty()).then(|| (0..m.wheels).map(contact).collect());
    json!({
        "label": run.label,
        "outcome": r.outcome.name().replace('_', " "),
        "success": r.outcome == vb_score::Outcome::Success,
        "reason": r.explanation(),
        "facts": facts(run, world.scale),
        "log": r.log,
        "time": r.time_s,
        "exact": m.repeat == Repeat::Exact,
        "times": packed(m.frames.iter().map(|f| [f.time]), [TIME]),
        "poses": packed(poses, [length, length, length, DIRECTION, DIRECTION, DIRECTION, DIRECTION]),
        "signals": packed(signals, SIGNALS),
        "wheel_count": m.wheels,
        "wheels": wheels,
        "ruts": ruts(m, world),
        "grains": m.grains.json(length),
        "contact": contact,
        "vehicle": vehicle(spec, length),
        "series": run.series.json(),
        "sensed": run.sensed.json(&m.frames),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_are_told_one_after_the_other_with_their_own_corners() {
        let tetrahedron = |at: f64| {
            let points = [[at, 0.0, 0.0], [at + 1.0, 0.0, 0.0], [at, 1.0, 0.0], [at, 0.0, 1.000_04]];
            Mesh { points: points.to_vec(), triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]] }
        };
        let told = meshes([tetrahedron(0.0), tetrahedron(5.0)].iter(), 1e-3);
        assert_eq!(told["counts"], packed([[4.0, 4.0]; 2].into_iter(), [1.0; 2]));
        let corners = [[0.0, 2.0, 1.0], [0.0, 1.0, 3.0], [1.0, 2.0, 3.0], [2.0, 0.0, 3.0]].repeat(2);
        assert_eq!(told["triangles"], packed(corners.into_iter(), [1.0; 3]));
        // To the millimetre that was asked for.
        let points =
            [0.0, 5.0].map(|at| [[at, 0.0, 0.0], [at + 1.0, 0.0, 0.0], [at, 1.0, 0.0], [at, 0.0, 1.0]]);
        assert_eq!(told["points"], packed(points.concat().into_iter(), [1e-3; 3]));
    }
}
