//! A vehicle as triangles: its hull, its wheels at their travel and steering, its belts.

use crate::solid::{Face, hull, sphere, turned, volume};
use crate::tracks::{Roller, belt};
use crate::{Colour, V3};
use nalgebra::UnitQuaternion;
use vb_sim::VehicleState;
use vb_vehicle::{VehicleModel, kinematics::Side};

/// The colours of a hull's parts: the largest one's, and those of the others in turn.
const BODY: Colour = [40, 92, 178];
const PARTS: [Colour; 2] = [[232, 236, 240], [198, 206, 214]];
const RUBBER: [Colour; 2] = [[38, 38, 41], [26, 26, 28]];
const RIM: Colour = [150, 153, 158];
const SPOKES: [Colour; 2] = [[92, 95, 100], [150, 153, 158]];
/// One spoke, by which one sees a wheel turn.
const FIRST_SPOKE: Colour = [240, 196, 60];
const AXLE: Colour = [70, 72, 76];
/// Sides of a wheel; spokes take two of them.
const SIDES: usize = 20;

#[derive(Clone, Debug)]
pub(crate) struct Vehicle {
    model: VehicleModel,
    /// In the frame of the chassis.
    body: Vec<Face>,
    /// Of each wheel, about its centre with the axle along y.
    wheels: Vec<Vec<Face>>,
    sizes: Vec<[f64; 2]>,
    /// The middle of the hull in the frame of the chassis, m.
    middle: V3,
    length: f64,
}

impl Vehicle {
    pub(crate) fn new(model: &VehicleModel) -> Self {
        let spec = model.spec();
        let mut parts: Vec<Vec<Face>> = spec
            .chassis
            .hull
            .iter()
            .map(|part| hull(&part.iter().map(|p| V3::from(*p)).collect::<Vec<_>>(), BODY))
            .collect();
        // The largest first; the order of equal ones stays.
        parts.sort_by(|a, b| volume(b).total_cmp(&volume(a)));
        for (k, part) in parts.iter_mut().enumerate().skip(1) {
            for face in part {
                face.colour = PARTS[(k - 1) % PARTS.len()];
            }
        }
        let body = parts.concat();
        let middle = sphere(body.iter()).0;
        let sizes = spec.wheel_sizes();
        let tracked = spec.tracks.is_some();
        let wheels = sizes.iter().map(|&[r, w]| wheel(r, w, tracked)).collect();
        Self { model: model.clone(), body, wheels, sizes, middle, length: spec.length }
    }

    /// Overall length, m.
    pub(crate) fn length(&self) -> f64 {
        self.length
    }

    /// The middle of the hull in the world, m.
    pub(crate) fn middle(&self, state: &VehicleState) -> V3 {
        state.position + state.attitude * self.middle
    }

    /// The faces in the world. `turned` are the angles by which the wheels have turned, rad; those that are not given
    /// are 0. The largest part of the body has this colour, if there is one.
    pub(crate) fn faces(&self, state: &VehicleState, turned_by: &[f64], colour: Option<Colour>) -> Vec<Face> {
        let spec = self.model.spec();
        let mut out = self.body.clone();
        if let Some(colour) = colour {
            for face in out.iter_mut().filter(|f| f.colour == BODY) {
                face.colour = colour;
            }
        }
        let mut rollers: [Vec<Roller>; 2] = [Vec::new(), Vec::new()];
        for (a, (axle, solved)) in spec.axles.iter().zip(self.model.axles()).enumerate() {
            let travel = |w: usize| state.wheels.get(w).map_or(0.0, |w| w.deflection);
            let travels = [travel(2 * a), travel(2 * a + 1)];
            let poses = [Side::Left, Side::Right].map(|side| {
                let pose = solved.wheel(side, travels, state.steering);
                // To the left whatever side it is on, so that a positive angle rolls forward.
                let axis = if pose.axis.y < 0.0 { -pose.axis } else { pose.axis };
                (V3::from(axle.position) + pose.hub, axis)
            });
            for (side, (hub, axis)) in poses.iter().enumerate() {
                let w = 2 * a + side;
                let lean = UnitQuaternion::rotation_between(&V3::y(), axis).unwrap_or_default();
                let angle = turned_by.get(w).copied().unwrap_or(0.0);
                let turn = lean * UnitQuaternion::from_axis_angle(&V3::y_axis(), angle);
                out.extend(self.wheels[w].iter().map(|f| f.placed(&turn, hub)));
                rollers[side].push(Roller { hub: *hub, radius: self.sizes[w][0] });
            }
            if spec.tracks.is_none() {
                out.extend(shaft(&poses[1].0, &poses[0].0, 0.13 * self.sizes[2 * a][0]));
            }
        }
        if let Some(tracks) = &spec.tracks {
            for (side, wheels) in rollers.iter().enumerate() {
                // The first road wheel tells how far the belt has moved.
                let rolled = turned_by.get(2 + side).map_or(0.0, |a| a * self.sizes[2 + side][0]);
                out.extend(belt(wheels, tracks.thickness, self.sizes[side][1], rolled));
            }
        }
        for face in &mut out {
            *face = face.placed(&state.attitude, &state.position);
        }
        out
    }

    /// A sphere around faces of the vehicle.
    pub(crate) fn sphere(faces: &[Face]) -> (V3, f64) {
        sphere(faces.iter())
    }
}

/// A wheel about its centre, its axle along y.
fn wheel(radius: f64, width: f64, in_track: bool) -> Vec<Face> {
    let (half, rim) = (0.5 * width, 0.62 * radius);
    let shoulder = if in_track { radius } else { 0.93 * radius };
    // Between the shoulders: the tread. The disc lies a little inside of the tyre.
    let outline = [
        [0.0, 0.72 * half],
        [rim, 0.8 * half],
        [1.06 * rim, half],
        [shoulder, half],
        [radius, 0.78 * half],
        [radius, -0.78 * half],
        [shoulder, -half],
        [1.06 * rim, -half],
        [rim, -0.8 * half],
        [0.0, -0.72 * half],
    ];
    turned(&outline, SIDES, |part, side| match part {
        0 | 8 if side / 2 == 0 => FIRST_SPOKE,
        0 | 8 => SPOKES[side / 2 % 2],
        1 | 7 => RIM,
        3..=5 => RUBBER[side % 2],
        _ => RUBBER[0],
    })
}

/// A thin shaft between two wheels.
fn shaft(from: &V3, to: &V3, radius: f64) -> Vec<Face> {
    let along = to - from;
    let Some(axis) = along.try_normalize(1e-9) else { return Vec::new() };
    let turn = UnitQuaternion::rotation_between(&V3::y(), &axis).unwrap_or_default();
    turned(&[[radius, along.norm()], [radius, 0.0]], 8, |_, _| AXLE)
        .iter()
        .map(|f| f.placed(&turn, from))
        .collect()
}
