//! The second stage of a step: forces of ground and obstacles on the wheels.

use super::design::Design;
use super::ground::Ground;
use super::kinematics::Kinematics;
use super::state::Contacts;
use crate::collision::OBSTACLE_FRICTION;
use crate::soil::Under;
use crate::tyre::{Contact, Patch, Reaction, WheelMotion};
use crate::{M3, V3};

/// How fast a contact may deepen over the speeds at which the wheel approaches the ground there and passes it: more than
/// any smooth ground does to a rolling wheel. Along a contact's true normal it would be 1 and 0.
const DEEPENING: [f64; 2] = [2.0, 0.5];
/// How fast it may deepen under a wheel at rest, in radii of the wheel, 1/s.
const CREEP: f64 = 0.1;
/// Cosine of the angle between a wheel's axle and a contact's normal from which on the wheel lies on its flank.
const FLANK: f64 = 0.9;
/// How fast a wheel on its flank may leave the ground before its contact has to become as much less, in radii of the
/// wheel, 1/s: faster than it comes out of a hollow by its own springs.
const THROW: f64 = 8.0;

/// What acts on a wheel in a step, world axes.
#[derive(Clone, Copy, Default)]
pub(super) struct Forces {
    /// Of all contacts, and of a belt, N.
    pub(super) force: V3,
    /// Its moment about the hub, less what spins the wheel, N m.
    pub(super) moment: V3,
    /// The moment about the axle, N m.
    pub(super) spin_moment: f64,
    /// Mass of the hub and the implicit damping of the contacts, kg.
    pub(super) inertia: M3,
    /// The normal force of ground and obstacles, N.
    pub(super) load: f64,
    /// Greatest depth of the wheel below undisturbed soil, m.
    pub(super) sinkage: f64,
}

impl Forces {
    /// Nothing acts on a wheel of this mass, kg.
    pub(super) fn none(mass: f64) -> Self {
        Self {
            force: V3::zeros(),
            moment: V3::zeros(),
            spin_moment: 0.0,
            inertia: M3::from_diagonal_element(mass),
            load: 0.0,
            sinkage: 0.0,
        }
    }

    /// Adds the reaction of one contact, whose damping adds `damped` (kg) along the normal.
    ///
    /// `fraction`, 0 to 1, is how much of the ground there is rigid. It takes its part of the whole reaction and not of the
    /// depth, since a hard wheel that slides feels the ground across a small gap too, which a smaller depth would close.
    fn add(&mut self, r: &Reaction, normal: &V3, damped: f64, fraction: f64) {
        self.force += r.force * fraction;
        self.moment += r.moment * fraction;
        self.spin_moment += r.spin_moment * fraction;
        self.inertia += normal * normal.transpose() * (damped * fraction);
        self.load += r.load * fraction;
    }
}

/// Forces of ground and obstacles on all wheels, into `forces`. What the contacts remember is brought up to this step, and
/// so is the soil under them.
pub(super) fn touch_wheels(
    design: &Design,
    kinematics: &Kinematics<'_>,
    ground: &mut Ground<'_>,
    contacts: &mut [Contacts],
    forces: &mut [Forces],
    dt: f64,
) {
    let wheels = design.corners.iter().zip(kinematics.placements).zip(contacts);
    for (((corner, place), contacts), f) in wheels.zip(forces) {
        *f = Forces::none(corner.mass);
        touch(design, corner.tyre, &place.motion, ground, contacts, f, dt);
    }
}

/// Adds the forces of ground and obstacles on one wheel, whose tyre has this number, to `f`.
fn touch(
    design: &Design,
    tyre: usize,
    motion: &WheelMotion,
    ground: &mut Ground<'_>,
    contacts: &mut Contacts,
    f: &mut Forces,
    dt: f64,
) {
    let (hub, axis) = (&motion.hub, &motion.axis);
    let (tyre, shape) = (&design.tyres[tyre], &design.shapes[tyre]);
    let damped = dt * tyre.damping();
    let envelope = tyre.envelope();
    let reach = envelope.radius();
    let under = ground.under(hub.x, hub.y, reach);
    let mut limited = false;
    let friction = |x, y| match under {
        Under::Mixed => ground.semantics.rigid_friction_around(x, y, reach),
        _ => ground.semantics.friction_at(x, y),
    };
    let rigid = |x, y| 1.0 - ground.soil.fraction(x, y, ground.soil.blend);
    let facets = match (&under, shape.hard()) {
        // A track's wheels stand on its belt.
        (Under::Rigid | Under::Mixed, Some(wheel)) if contacts.footprint.is_some() => {
            wheel.facets(ground.heightfield, hub, axis, tyre.reach())
        }
        _ => None,
    };
    if facets.is_none() {
        contacts.facets.clear();
    }
    let contact = match under {
        Under::Rigid | Under::Mixed if let Some(facets) = &facets => {
            let before = contacts.facets;
            contacts.facets.clear();
            for (facet, contact) in facets.iter() {
                let (x, y) = (contact.point.x, contact.point.y);
                let fraction = if under == Under::Mixed { rigid(x, y) } else { 1.0 };
                if fraction <= 0.0 {
                    continue;
                }
                let mut patch = before.before(*facet, &contact.normal);
                if let Some(r) = tyre.react(motion, contact, friction(x, y), &mut patch, dt) {
                    f.add(&r, &contact.normal, damped, fraction);
                }
                contacts.facets.push(*facet, contact.normal, patch);
            }
            None
        }
        Under::Rigid => {
            envelope.query_where(ground.heightfield, hub, axis, &mut contacts.clearance, |_, _| 1.0)
        }
        Under::Soil(_) => None,
        Under::Mixed => envelope.query_where(ground.heightfield, hub, axis, &mut contacts.clearance, rigid),
    };
    if let Some(contact) = contact {
        let (contact, held) = motion.held(&contact, &mut contacts.ground_depth, reach, dt);
        limited |= held;
        let friction = friction(contact.point.x, contact.point.y);
        if let Some(r) = tyre.react(motion, &contact, friction, &mut contacts.ground, dt) {
            f.add(&r, &contact.normal, damped, 1.0);
        }
    } else {
        contacts.ground = Patch::default();
        contacts.ground_depth = 0.0;
    }
    if !ground.soil.is_empty()
        && let Some(footprint) = &mut contacts.footprint
        && let Some(s) = footprint.step(ground.soil, ground.heightfield, under, motion, dt)
    {
        let about_axle = axis.dot(&s.moment);
        f.force += s.force;
        f.moment += s.moment - axis * about_axle;
        f.spin_moment += about_axle;
        f.inertia += s.inertia;
        f.load += s.load;
        f.sinkage = s.sinkage;
    }
    if ground.obstacles.any_near() || !contacts.obstacles.is_empty() {
        let before = std::mem::take(&mut contacts.obstacles);
        for found in ground.obstacles.wheel_contacts(shape, hub, axis).into_iter().flatten() {
            let mut own = before.before(&found);
            let (contact, held) = motion.held(&found.contact, &mut own.depth, reach, dt);
            limited |= held;
            if let Some(r) = tyre.react(motion, &contact, OBSTACLE_FRICTION, &mut own.patch, dt) {
                f.add(&r, &contact.normal, damped, 1.0);
            }
            contacts.obstacles.push(own);
        }
    }
    contacts.held += u64::from(limited);
}

impl WheelMotion {
    /// The contact, no deeper than the wheel's motion can have made it since it was `before` (m) deep `dt` (s) ago, and
    /// whether it would have been deeper.
    ///
    /// Heights and radii tell how deep a wheel is, but not how it got there. Where a wheel lies on its flank in a hollow,
    /// or stands with one side in a wall, what counts as its lowest point may change from one side to the other, and a wheel
    /// that was suddenly half a metre deep would throw the vehicle with energy that nothing supplied. It is let out slowly
    /// instead. A small wheel on its flank that moves about in a hollow may even so be found as deep at each step as it has
    /// just been thrown out: from some speed on, the depth becomes less as the wheel leaves.
    pub(super) fn held(&self, contact: &Contact, before: &mut f64, radius: f64, dt: f64) -> (Contact, bool) {
        let turning = self.rotation - self.axis * self.spin;
        let velocity = self.velocity + turning.cross(&(contact.point - self.hub));
        let approach = -velocity.dot(&contact.normal);
        let passing = (velocity + contact.normal * approach).norm();
        let thrown = approach < -THROW * radius && self.axis.dot(&contact.normal).abs() > FLANK;
        let along = if thrown { approach } else { DEEPENING[0] * approach.max(0.0) };
        let deepest = *before + dt * (along + DEEPENING[1] * passing + CREEP * radius);
        *before = contact.depth.min(deepest.max(0.0));
        (Contact { depth: *before, ..*contact }, *before < contact.depth)
    }
}
