//! What of a vehicle stays as it is while it drives: masses, places, linkages, tyres.
//!
//! Nothing in a step writes here, so that any number of vehicles of one kind can share it.

mod beam;
mod servo;
mod track;

pub(crate) use beam::Beam;
pub(crate) use servo::Servo;
pub(crate) use track::{Track, gearing, sprockets};

use crate::V3;
use crate::collision::WheelShape;
use crate::tyre::{Envelope, Tyre};
use std::sync::Arc;
use vb_vehicle::kinematics::{AxleKinematics, CornerTable, Element, Side, elements, moves};
use vb_vehicle::{
    VehicleSpec,
    powertrain::Governor,
    suspension::{AntiRoll, Stops},
};

/// A vehicle without its state.
#[derive(Clone)]
pub(crate) struct Design {
    /// Of the chassis alone, kg.
    pub(crate) mass: f64,
    /// Principal moments of inertia of the chassis alone, kg m².
    pub(crate) inertia: V3,
    /// Resistance of the air over the speed, N over m/s.
    pub(crate) resistance: Vec<[f64; 2]>,
    /// How fast the steering command follows the driver's, 1/s.
    pub(crate) steering_rate: f64,
    /// The limit of the steering gears; none if their force is unlimited.
    pub(crate) servo: Option<Servo>,
    pub(crate) governor: Option<Governor>,
    /// The vehicle's reference point relative to the chassis' centre of mass, body axes.
    pub(crate) reference: V3,
    /// The vehicle's tyre first, then those of axles with their own.
    pub(crate) tyres: Vec<Tyre>,
    /// The outline of each tyre, by which it meets obstacles.
    pub(crate) shapes: Vec<WheelShape>,
    /// Front to back, left before right.
    pub(crate) corners: Vec<Corner>,
    pub(crate) beams: Vec<Beam>,
    pub(crate) bars: Vec<Bar>,
    /// Left and right, or none.
    pub(crate) tracks: Vec<Track>,
    /// The distance from the chassis' centre of mass within which wheels and belts lie at design height, m.
    pub(crate) bound: f64,
}

/// One wheel with its suspension.
#[derive(Clone)]
pub(crate) struct Corner {
    pub(crate) guide: Guide,
    pub(crate) side: Side,
    /// Number of its tyre.
    pub(crate) tyre: usize,
    /// The axle's reference point relative to the chassis' centre of mass, body axes.
    pub(crate) mount: V3,
    pub(crate) mass: f64,
    pub(crate) spin_inertia: f64,
    /// Speed of the wheel over its spin: more than 1 within a belt, whose outer face has the spin.
    pub(crate) gearing: f64,
    pub(crate) brake_torque: f64,
    pub(crate) steered: bool,
    /// Springs and dampers in the order of the tables.
    pub(crate) struts: Vec<Element>,
    pub(crate) stops: Option<Stops>,
}

#[derive(Clone)]
pub(crate) enum Guide {
    /// A linkage of its own.
    Table(Arc<CornerTable>),
    /// Fixed to the chassis.
    Mount(Arc<CornerTable>),
    /// The beam of this number.
    Beam(usize),
}

/// A bar between two wheels that are guided independently, of which the left one has this number.
#[derive(Clone, Copy)]
pub(crate) struct Bar {
    pub(crate) left: usize,
    pub(crate) stiffness: f64,
    pub(crate) damping: f64,
}

impl Design {
    pub(crate) fn new(spec: &VehicleSpec, axles: &[AxleKinematics]) -> Self {
        let com = V3::from(spec.chassis.com);
        let mut design = Self {
            mass: spec.chassis.mass,
            inertia: V3::from(spec.chassis.inertia),
            resistance: spec.chassis.resistance.clone(),
            steering_rate: spec.steering.rate,
            servo: None,
            governor: spec.powertrain.governor,
            reference: -com,
            tyres: vec![Tyre::new(&spec.tyre)],
            shapes: vec![WheelShape::new(&spec.tyre)],
            corners: Vec::new(),
            beams: Vec::new(),
            bars: Vec::new(),
            tracks: Vec::new(),
            bound: 0.0,
        };
        for (i, (axle, kinematics)) in spec.axles.iter().zip(axles).enumerate() {
            let suspension = &axle.suspension;
            let mount = V3::from(axle.position) - com;
            let tyre = axle.tyre.as_ref().map_or(0, |tyre| {
                design.tyres.push(Tyre::new(tyre));
                design.shapes.push(WheelShape::new(tyre));
                design.tyres.len() - 1
            });
            let (stiffness, damping) = match suspension.anti_roll {
                Some(AntiRoll::Travel { stiffness }) => (stiffness, 0.0),
                Some(AntiRoll::Bar { stiffness, damping, .. }) => (stiffness, damping),
                None => (0.0, 0.0),
            };
            if let (Some(kinematics), Some(beam)) = (kinematics.beam(), suspension.linkage.beam()) {
                let linkage = &suspension.linkage;
                design.beams.push(Beam::new(kinematics, beam, 2 * i, mount, linkage, stiffness));
            } else if stiffness > 0.0 {
                design.bars.push(Bar { left: 2 * i, stiffness, damping });
            }
            for side in [Side::Left, Side::Right] {
                let guide = match kinematics.corner(side) {
                    Some(table) if moves(&suspension.linkage) => Guide::Table(table),
                    Some(table) => Guide::Mount(table),
                    None => Guide::Beam(design.beams.len() - 1),
                };
                design.corners.push(Corner {
                    guide,
                    side,
                    tyre,
                    mount,
                    mass: axle.unsprung_mass,
                    spin_inertia: axle.spin_inertia,
                    gearing: gearing(spec, axle),
                    brake_torque: axle.brake_torque,
                    steered: axle.steering.is_some(),
                    struts: elements(suspension),
                    stops: suspension.stops.clone(),
                });
            }
        }
        design.servo = Servo::new(spec, &design.steered_inertias());
        let hubs: Vec<V3> = design.corners.iter().map(|c| design.hub(c)).collect();
        design.tracks = (0..2).filter_map(|side| Track::new(spec, side, &hubs)).collect();
        // A belt is no farther from its wheels than its width.
        let belt = design.tracks.first().map_or(0.0, |track| 0.5 * track.width);
        let farthest = hubs
            .iter()
            .zip(&design.corners)
            .map(|(hub, c)| hub.norm() + design.shapes[c.tyre].bound() + belt);
        design.bound = farthest.fold(0.0, f64::max);
        design
    }

    /// The inertia of each axle's steered wheels against a change of the steering command, at design height and straight
    /// ahead, kg m². Across its axle a wheel counts as a thin disc, with half of its moment of inertia about the axle.
    fn steered_inertias(&self) -> Vec<f64> {
        let one = |c: &Corner| {
            let i = c.side.index();
            let (hub, tilt) = match &c.guide {
                Guide::Table(table) | Guide::Mount(table) => {
                    let p = table.at(0.0, 0.0);
                    (p.hub_steer_rate, p.steer_tilt_rate)
                }
                Guide::Beam(b) => {
                    let w = self.beams[*b].kinematics.at([0.0; 2], [0.0; 2], 0.0).wheels[i];
                    (w.hub_steer_rate, w.steer_tilt_rate)
                }
            };
            c.mass * hub.norm_squared() + 0.5 * c.spin_inertia * tilt.norm_squared()
        };
        self.corners.chunks(2).map(|axle| axle.iter().map(one).sum()).collect()
    }

    /// The centre of a corner's wheel at design height relative to the chassis' centre of mass, body axes.
    fn hub(&self, c: &Corner) -> V3 {
        c.mount + self.guided(c, [0.0; 2], 0.0).0
    }

    /// Hub relative to the axle's reference point and direction of the axle in the chassis frame at travels of the
    /// axle's wheels and a steering command.
    pub(crate) fn guided(&self, c: &Corner, travels: [f64; 2], command: f64) -> (V3, V3) {
        let i = c.side.index();
        match &c.guide {
            Guide::Table(table) | Guide::Mount(table) => {
                let p = table.at(travels[i], command);
                (p.hub, p.axis)
            }
            Guide::Beam(b) => {
                let w = self.beams[*b].kinematics.at(travels, [0.0; 2], command).wheels[i];
                (w.hub, w.axis)
            }
        }
    }

    /// Mass, moments of inertia and centre of mass of the whole vehicle at design height, relative to the chassis'
    /// centre of mass.
    pub(crate) fn composite(&self) -> (f64, V3, V3) {
        let wheels = self.corners.iter().map(|c| (c.mass, self.hub(c)));
        let beams = self.beams.iter().map(|b| (b.mass, b.mount + b.middle()));
        let parts: Vec<(f64, V3)> = wheels.chain(beams).collect();
        let mass = self.mass + parts.iter().map(|p| p.0).sum::<f64>();
        let com = parts.iter().map(|(m, r)| r * *m).sum::<V3>() / mass;
        let about =
            |m: f64, r: V3| V3::new(r.y * r.y + r.z * r.z, r.x * r.x + r.z * r.z, r.x * r.x + r.y * r.y) * m;
        let inertia =
            self.inertia + about(self.mass, -com) + parts.iter().map(|&(m, r)| about(m, r - com)).sum::<V3>();
        (mass, inertia, com)
    }

    pub(crate) fn envelope(&self, c: &Corner) -> &Envelope {
        self.tyres[c.tyre].envelope()
    }
}
