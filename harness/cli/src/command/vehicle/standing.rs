//! A vehicle as it stands on level ground: what tables and pictures are made from.

use std::sync::Arc;

use vb_sim::{
    SimError, SimOptions, Simulation, SoilSet, VehicleState,
    track::{Course, Disc},
};
use vb_trial::{StaticShape, static_shape};
use vb_vehicle::{VehicleModel, VehicleSpec, kinematics::Side};
use vb_world::{Heightfield, Pose2, TerrainClass, World};

type Point = [f64; 3];
type V3 = nalgebra::Vector3<f64>;

/// A wheel in place, in the world: x ahead, y to the left, z above the ground, m.
pub(super) struct Wheel {
    pub(super) centre: Point,
    /// Unit, to the left.
    pub(super) axis: Point,
    pub(super) radius: f64,
    pub(super) width: f64,
}

/// A vehicle that stands on level ground with its reference point above the origin.
pub(super) struct Standing {
    pub(super) spec: VehicleSpec,
    pub(super) shape: StaticShape,
    pub(super) state: VehicleState,
    pub(super) wheels: Vec<Wheel>,
    /// Rods and arms of the linkages, as lines.
    pub(super) links: Vec<[Point; 2]>,
    /// Springs and dampers, as lines.
    pub(super) struts: Vec<[Point; 2]>,
    /// Outlines of the belts of a tracked vehicle: outer face and inner face.
    pub(super) belts: Vec<[Vec<Point>; 2]>,
    /// Points of the convex parts of the hull.
    pub(super) hull: Vec<Vec<Point>>,
}

impl Standing {
    pub(super) fn new(spec: VehicleSpec) -> Result<Self, SimError> {
        let options = SimOptions::default();
        let model = VehicleModel::new(spec.clone())?;
        let shape = static_shape(&model, options)?;
        let side = 4.0 * spec.length.max(spec.scale);
        let level =
            World::uniform("level", Heightfield::flat(3, 3, 0.5 * side, 0.0), TerrainClass::Concrete, 0.8);
        let start = Pose2 { x: 0.0, y: 0.0, yaw: 0.0 };
        let state = Simulation::new(Arc::new(level), &model, &SoilSet::default(), start, options)?.state();
        let place = |p: Point| -> Point { (state.position + state.attitude * vector(p)).into() };
        let turn = |p: Point| -> Point { (state.attitude * vector(p)).into() };
        let (mut wheels, mut links, mut struts) = (Vec::new(), Vec::new(), Vec::new());
        let sizes = spec.wheel_sizes();
        let mut hubs: [Vec<Point>; 2] = [Vec::new(), Vec::new()];
        for (i, (axle, solved)) in spec.axles.iter().zip(model.axles()).enumerate() {
            let sizes = &sizes[2 * i..2 * i + 2];
            let travels = [0, 1].map(|k| state.wheels[2 * i + k].deflection);
            for (k, (side, sign)) in [(Side::Left, 1.0), (Side::Right, -1.0)].into_iter().enumerate() {
                let pose = solved.wheel(side, travels, 0.0);
                let design = solved.wheel(side, [0.0; 2], 0.0);
                let hub: Point = pose.hub.into();
                wheels.push(Wheel {
                    centre: place(add(axle.position, hub)),
                    axis: turn(pose.axis.into()),
                    radius: sizes[k][0],
                    width: sizes[k][1],
                });
                hubs[k].push(add(axle.position, hub));
                // What moves with the wheel is drawn as far from its design position as the wheel itself is.
                let moved: Point = (pose.hub - design.hub).into();
                let fixed = |p: Point| place(add(axle.position, [p[0], sign * p[1], p[2]]));
                let carried = |p: Point| place(add(add(axle.position, [p[0], sign * p[1], p[2]]), moved));
                links.extend(axle.suspension.linkage.rods().into_iter().map(|[a, b]| [fixed(a), carried(b)]));
                struts.extend(axle.suspension.struts.iter().map(|s| [fixed(s.chassis), carried(s.end)]));
            }
        }
        let hull = spec.chassis.hull.iter().map(|part| part.iter().map(|p| place(*p)).collect()).collect();
        let belts = spec.tracks.iter().flat_map(|t| {
            hubs.iter().flat_map(|hubs| {
                let width = sizes[0][1];
                let radius = |j: usize| sizes[2 * j][0] + 0.5 * t.thickness;
                let disc = |(j, h): (usize, &Point)| Disc { centre: [h[0], h[2]], radius: radius(j) };
                let course = Course::around(&hubs.iter().enumerate().map(disc).collect::<Vec<_>>());
                let faces = [0.5 * t.thickness, -0.5 * t.thickness];
                [-0.5 * width, 0.5 * width].map(|side| {
                    let y = hubs[0][1] + side;
                    faces.map(|f| course.outline(f, 12).into_iter().map(|[x, z]| place([x, y, z])).collect())
                })
            })
        });
        let belts = belts.collect();
        Ok(Self { spec, shape, state, wheels, links, struts, belts, hull })
    }
}

fn vector(p: Point) -> V3 {
    V3::from(p)
}

fn add(a: Point, b: Point) -> Point {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
