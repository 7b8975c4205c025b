//! A wheel on a test stand: the contacts and forces of the vehicle's own step without a vehicle.

use super::facets::FacetPatches;
use crate::collision::WheelShape;
use crate::tyre::{Clearance, Patch, Tyre, WheelMotion};
use crate::{M3, V3};
use vb_vehicle::TyreSpec;
use vb_world::Heightfield;

/// A wheel whose axle keeps its direction along y and that moves in the plane of x and z, on rigid ground.
#[derive(Clone)]
pub struct WheelStand {
    tyre: Tyre,
    shape: WheelShape,
    mass: V3,
    spin_inertia: f64,
    step: f64,
    clearance: Clearance,
    facets: FacetPatches,
    patch: Patch,
    /// The centre of the wheel, m.
    pub hub: V3,
    /// The velocity of the centre, m/s.
    pub velocity: V3,
    /// The spin, rad/s, positive when rolling along x.
    pub spin: f64,
    /// The sum of the contacts' normal forces in the last step, N.
    pub load: f64,
    /// The moment of the contacts about the axle in the last step, N m. What resists a wheel that is driven along x is
    /// negative.
    pub moment: f64,
}

impl WheelStand {
    /// A wheel at rest with its centre at the origin. `mass` is what moves with the hub along x and along z, kg; the
    /// two differ where a spring lets the wheel rise without the vehicle. `spin_inertia` is in kg m², and `step` is the
    /// time step, s.
    #[must_use]
    pub fn new(tyre: &TyreSpec, mass: [f64; 2], spin_inertia: f64, step: f64) -> Self {
        Self {
            tyre: Tyre::new(tyre),
            shape: WheelShape::new(tyre),
            mass: V3::new(mass[0], mass[0], mass[1]),
            spin_inertia,
            step,
            clearance: Clearance::default(),
            facets: FacetPatches::default(),
            patch: Patch::default(),
            hub: V3::zeros(),
            velocity: V3::zeros(),
            spin: 0.0,
            load: 0.0,
            moment: 0.0,
        }
    }

    /// Advances the wheel by one step under a force along x and z at the hub (N), which includes the weight, on ground
    /// of this friction coefficient. A wheel that is `held` keeps its spin whatever torque it takes; otherwise it turns
    /// freely.
    pub fn advance(&mut self, ground: &Heightfield, friction: f64, force: [f64; 2], held: bool) {
        let axis = V3::y();
        let motion = WheelMotion {
            hub: self.hub,
            velocity: self.velocity,
            rotation: axis * self.spin,
            axis,
            spin: self.spin,
        };
        let (mut sum, mut inertia) = (V3::new(force[0], 0.0, force[1]), M3::from_diagonal(&self.mass));
        (self.load, self.moment) = (0.0, 0.0);
        let mut feel = |tyre: &Tyre, contact: &crate::tyre::Contact, patch: &mut Patch| {
            if let Some(r) = tyre.react(&motion, contact, friction, patch, self.step) {
                sum += r.force;
                self.load += r.load;
                self.moment += r.spin_moment;
                inertia += contact.normal * contact.normal.transpose() * (self.step * tyre.damping());
            }
        };
        let hard = self.shape.hard();
        let facets = hard.and_then(|w| w.facets(ground, &motion.hub, &axis, self.tyre.reach()));
        if let Some(facets) = facets {
            let before = std::mem::take(&mut self.facets);
            for (facet, contact) in facets.iter() {
                let mut patch = before.before(*facet, &contact.normal);
                feel(&self.tyre, contact, &mut patch);
                self.facets.push(*facet, contact.normal, patch);
            }
        } else {
            let envelope = self.tyre.envelope();
            let found = envelope.query_where(ground, &motion.hub, &axis, &mut self.clearance, |_, _| 1.0);
            match found {
                Some(contact) => feel(&self.tyre, &contact, &mut self.patch),
                None => self.patch = Patch::default(),
            }
        }
        let change = inertia.cholesky().map_or(V3::zeros(), |m| m.solve(&sum)) * self.step;
        self.velocity += V3::new(change.x, 0.0, change.z);
        if !held {
            self.spin += self.moment / self.spin_inertia * self.step;
        }
        self.hub += self.velocity * self.step;
    }
}
