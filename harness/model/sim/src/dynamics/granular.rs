//! Wheels, belts and hull among the grains of granular beds: their motions, and the beds' forces on them.

use super::contact::Forces;
use super::design::Design;
use super::kinematics::Kinematics;
use super::state::Belt;
use super::track::Laid;
use crate::granular::Beds;
use crate::tyre::Tyre;
use crate::{V3, turn_to_axle};
use vb_granular::{Motion, Reaction, Shape, Tool};
use vb_vehicle::{GRAVITY, VehicleSpec};

/// Radius of a tyre's shoulders over its width.
const SHOULDER: f64 = 0.15;
/// Friction coefficient of rubber on stone: tyres on dry concrete reach 0.8 to 0.9 (Wong, Theory of Ground Vehicles, 2008, table 1.3).
const RUBBER: f64 = 0.8;

/// A force, N, and a moment, N m, world axes.
#[derive(Clone, Copy, Default)]
pub(super) struct Wrench {
    pub(super) force: V3,
    pub(super) moment: V3,
}

/// The bodies of a vehicle that meet grains of a radius (m): its wheels, the spans of its belts, and the parts of its hull.
pub(super) fn tools(design: &Design, spec: &VehicleSpec, grain: f64) -> Vec<Tool> {
    let load = design.composite().0 * GRAVITY / design.corners.len() as f64;
    let wheels = design.corners.iter().map(|corner| {
        let tyre = &design.tyres[corner.tyre];
        let (radius, width) = (tyre.envelope().radius(), 2.0 * tyre.envelope().half_width());
        let friction = if design.tracks.is_empty() { RUBBER } else { spec.chassis.friction };
        Tool {
            shape: Shape::Wheel { radius, width, shoulder: (SHOULDER * width).min(0.5 * radius) },
            friction,
            stiffness: stiffness(tyre, load, width, grain),
        }
    });
    let spans = design.tracks.iter().flat_map(|track| {
        let spans = &track.course.spans()[..track.count() - 1];
        spans.iter().map(|span| {
            let half = 0.5 * V3::new(span.length, track.width, track.spec.thickness);
            Tool { shape: Shape::Box { half }, friction: spec.chassis.friction, stiffness: f64::INFINITY }
        })
    });
    let com = V3::from(spec.chassis.com);
    let hull = spec.chassis.hull.iter().filter_map(|part| {
        let points: Vec<[f64; 3]> = part.iter().map(|p| (V3::from(*p) - com).into()).collect();
        let shape = Shape::convex(&points)?;
        Some(Tool { shape, friction: spec.chassis.friction, stiffness: f64::INFINITY })
    });
    wheels.chain(spans).chain(hull).collect()
}

/// Stiffness of a tyre under a grain, N/m: the tyre is a bed of springs (Winkler), so a grain meets as much of the stiffness on a flat
/// surface at the design load as it covers of the contact area there, a rectangle of the tyre's width and the length of the chord.
fn stiffness(tyre: &Tyre, load: f64, width: f64, grain: f64) -> f64 {
    let radius = tyre.envelope().radius();
    let (mut low, mut high) = (0.0, 0.5 * radius);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if tyre.vertical_force(middle) < load { low = middle } else { high = middle }
    }
    let length = 2.0 * (high * (2.0 * radius - high)).sqrt();
    load / high * (4.0 * grain * grain / (width * length)).min(1.0)
}

/// Advances the beds by a step, adds their forces to those on the wheels and tells `laid`, which is how the belts lay in the last step,
/// those on the belts. It returns what they do to the hull, about the chassis' centre of mass; nothing in a world without beds.
pub(super) fn press(
    design: &Design,
    kinematics: &Kinematics<'_>,
    beds: &mut Beds,
    belts: &[Belt],
    laid: &mut [Laid],
    forces: &mut [Forces],
    dt: f64,
) -> Option<Wrench> {
    if beds.is_empty() {
        return None;
    }
    let Kinematics { body, placements, .. } = kinematics;
    let mut motions: Vec<Motion> = Vec::with_capacity(beds.bodies());
    motions.extend(placements.iter().map(|place| {
        let m = &place.motion;
        Motion { position: m.hub, rotation: turn_to_axle(&m.axis), velocity: m.velocity, spin: m.rotation }
    }));
    for ((track, belt), laid) in design.tracks.iter().zip(belts).zip(&*laid) {
        motions.extend((0..track.count() - 1).map(|j| laid.span_motion(track, belt, kinematics, j)));
    }
    let hull =
        Motion { position: body.x_world, rotation: body.q, velocity: body.v_world, spin: body.w_world };
    let spans = motions.len() - placements.len();
    motions.resize(beds.bodies(), hull);
    let reactions = beds.step(&motions);
    let wrench = |r: &Reaction| Wrench { force: r.impulse / dt, moment: r.moment / dt };
    let (on_wheels, others) = reactions.split_at(placements.len());
    let (on_spans, on_hull) = others.split_at(spans);
    let places = laid.iter_mut().flat_map(|laid| &mut laid.grains);
    places.zip(on_spans).for_each(|(place, reaction)| *place = wrench(reaction));
    for ((place, total), reaction) in placements.iter().zip(forces.iter_mut()).zip(on_wheels) {
        let Wrench { force, moment } = wrench(reaction);
        let axis = place.motion.axis;
        let about_axle = axis.dot(&moment);
        total.force += force;
        total.moment += moment - axis * about_axle;
        total.spin_moment += about_axle;
        total.load += force.dot(&V3::z()).max(0.0);
    }
    let sum = |of: fn(&Reaction) -> V3| on_hull.iter().map(of).sum::<V3>() / dt;
    let hull = Wrench { force: sum(|r| r.impulse), moment: sum(|r| r.moment) };
    for ((place, total), corner) in placements.iter().zip(forces).zip(&design.corners) {
        let m = &place.motion;
        if let Some(surface) = beds.surface(m.hub.x, m.hub.y) {
            let reach = design.envelope(corner).radius() * (1.0 - m.axis.z * m.axis.z).max(0.0).sqrt();
            total.sinkage = (surface - m.hub.z + reach).max(0.0);
        }
    }
    Some(hull)
}
