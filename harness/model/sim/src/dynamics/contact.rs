//! The second stage of a step: forces of ground and obstacles on the wheels.

use super::design::Design;
use super::ground::Ground;
use super::kinematics::Kinematics;
use super::state::Contacts;
use crate::collision::{Facets, OBSTACLE_FRICTION, WheelShape};
use crate::soil::{SoilGround, Under};
use crate::tyre::{Contact, Patch, Reaction, Tyre, WheelMotion};
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
    for (((corner, place), contacts), forces) in wheels.zip(forces) {
        *forces = Forces::none(corner.mass);
        let (tyre, shape) = (&design.tyres[corner.tyre], &design.shapes[corner.tyre]);
        Touch { tyre, shape, motion: &place.motion, ground, contacts, forces, dt }.touch();
    }
}

/// The generalised force of ground and obstacles on the steering command, N m.
pub(super) fn steering_load(design: &Design, kinematics: &Kinematics<'_>, forces: &[Forces]) -> f64 {
    let steered =
        design.corners.iter().zip(kinematics.placements).zip(forces).filter(|((c, _), _)| c.steered);
    steered.map(|((_, p), f)| p.steer.dot(&f.force) + p.steer_tilt.dot(&f.moment)).sum()
}

/// One wheel that touches ground and obstacles in a step.
struct Touch<'a, 'g> {
    tyre: &'a Tyre,
    shape: &'a WheelShape,
    motion: &'a WheelMotion,
    ground: &'a mut Ground<'g>,
    contacts: &'a mut Contacts,
    /// To which the reactions are added.
    forces: &'a mut Forces,
    dt: f64,
}

impl Touch<'_, '_> {
    fn touch(&mut self) {
        let hub = &self.motion.hub;
        let under = self.ground.under(hub.x, hub.y, self.reach());
        let facets = self.facets(under);
        let contact = if let Some(facets) = &facets {
            self.press_facets(facets, under);
            None
        } else {
            self.contacts.facets.clear();
            self.envelop(under)
        };
        let mut limited = self.press_ground(contact, under);
        self.press_soil(under);
        limited |= self.press_obstacles();
        self.contacts.held += u64::from(limited);
    }

    /// The radius of the wheel, m.
    fn reach(&self) -> f64 {
        self.tyre.envelope().radius()
    }

    /// The friction coefficient of the ground at a point.
    fn friction(&self, under: Under, x: f64, y: f64) -> f64 {
        match under {
            Under::Mixed => self.ground.semantics.rigid_friction_around(x, y, self.reach()),
            _ => self.ground.semantics.friction_at(x, y),
        }
    }

    /// The facets that a hard wheel touches; none of another wheel, nor of one that stands on a track's belt.
    fn facets(&self, under: Under) -> Option<Facets> {
        match (under, self.shape.hard()) {
            (Under::Rigid | Under::Mixed, Some(wheel)) if self.contacts.footprint.is_some() => {
                wheel.facets(self.ground.heightfield, &self.motion.hub, &self.motion.axis, self.tyre.reach())
            }
            _ => None,
        }
    }

    /// The contact of the whole outline with rigid ground.
    fn envelop(&mut self, under: Under) -> Option<Contact> {
        let (envelope, WheelMotion { hub, axis, .. }) = (self.tyre.envelope(), self.motion);
        let (heightfield, clearance) = (self.ground.heightfield, &mut self.contacts.clearance);
        match under {
            Under::Rigid => envelope.query_where(heightfield, hub, axis, clearance, |_, _| 1.0),
            Under::Soil(_) | Under::Granular => None,
            Under::Mixed => {
                let soil = &self.ground.soil;
                envelope.query_where(heightfield, hub, axis, clearance, |x, y| rigid(soil, x, y))
            }
        }
    }

    fn press_facets(&mut self, facets: &Facets, under: Under) {
        let before = self.contacts.facets;
        self.contacts.facets.clear();
        for (facet, contact) in facets.iter() {
            let (x, y) = (contact.point.x, contact.point.y);
            let fraction = if under == Under::Mixed { rigid(self.ground.soil, x, y) } else { 1.0 };
            if fraction <= 0.0 {
                continue;
            }
            let mut patch = before.before(*facet, &contact.normal);
            self.react(contact, self.friction(under, x, y), &mut patch, fraction);
            self.contacts.facets.push(*facet, contact.normal, patch);
        }
    }

    /// Presses the contact with the ground, if there is one; whether its depth was limited.
    fn press_ground(&mut self, contact: Option<Contact>, under: Under) -> bool {
        let Some(contact) = contact else {
            self.contacts.ground = Patch::default();
            self.contacts.ground_depth = 0.0;
            return false;
        };
        let reach = self.reach();
        let (contact, limited) = self.motion.held(&contact, &mut self.contacts.ground_depth, reach, self.dt);
        let mut patch = self.contacts.ground;
        self.react(&contact, self.friction(under, contact.point.x, contact.point.y), &mut patch, 1.0);
        self.contacts.ground = patch;
        limited
    }

    fn press_soil(&mut self, under: Under) {
        let ground = &mut *self.ground;
        if ground.soil.has_soil()
            && let Some(footprint) = &mut self.contacts.footprint
            && let Some(s) = footprint.step(ground.soil, ground.heightfield, under, self.motion, self.dt)
        {
            let (f, axis) = (&mut *self.forces, &self.motion.axis);
            let about_axle = axis.dot(&s.moment);
            f.force += s.force;
            f.moment += s.moment - axis * about_axle;
            f.spin_moment += about_axle;
            f.inertia += s.inertia;
            f.load += s.load;
            f.sinkage = s.sinkage;
        }
    }

    /// Presses the contacts with obstacles; whether a depth was limited.
    fn press_obstacles(&mut self) -> bool {
        let mut limited = false;
        if self.ground.obstacles.any_near() || !self.contacts.obstacles.is_empty() {
            let before = std::mem::take(&mut self.contacts.obstacles);
            let found = self.ground.obstacles.wheel_contacts(self.shape, &self.motion.hub, &self.motion.axis);
            for found in found.into_iter().flatten() {
                let mut own = before.before(&found);
                let (contact, held) = self.motion.held(&found.contact, &mut own.depth, self.reach(), self.dt);
                limited |= held;
                self.react(&contact, OBSTACLE_FRICTION, &mut own.patch, 1.0);
                self.contacts.obstacles.push(own);
            }
        }
        limited
    }

    /// Adds the tyre's reaction at a contact, of which rigid ground has a fraction.
    #[inline]
    fn react(&mut self, contact: &Contact, friction: f64, patch: &mut Patch, fraction: f64) {
        if let Some(r) = self.tyre.react(self.motion, contact, friction, patch, self.dt) {
            self.forces.add(&r, &contact.normal, self.dt * self.tyre.damping(), fraction);
        }
    }
}

/// The fraction of a load at a point that rigid ground carries.
fn rigid(soil: &SoilGround, x: f64, y: f64) -> f64 {
    1.0 - soil.fraction(x, y, soil.blend)
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
