//! Tyres: where a wheel meets the ground, and the forces there.
//!
//! A contact is found by the [`Envelope`] (or, with an obstacle, by the collision module), whatever the model. The model
//! gives the radial force of its depth and, through the [`Patch`], the forces in its plane; see `Tyre::react`.

mod brush;
mod envelope;
mod fiala;
mod patch;
#[cfg(test)]
mod rig;
mod rigid;
mod sample;
mod tmeasy;

use crate::V3;
use brush::Brush;
pub(crate) use envelope::Clearance;
pub use envelope::Envelope;
use fiala::Fiala;
pub use patch::Patch;
use patch::Slide;
use rigid::Rigid;
pub use sample::SteadyForce;
use tmeasy::Tmeasy;
use vb_vehicle::TyreSpec;

/// A wheel's contact with a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The point at which the force acts, in the world frame, m.
    pub point: V3,
    /// The unit normal out of the ground, in the world frame.
    pub normal: V3,
    /// The radial deflection, m, > 0.
    pub depth: f64,
}

/// How a wheel moves; world axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WheelMotion {
    /// Its centre, m.
    pub(crate) hub: V3,
    /// Of the centre, m/s.
    pub(crate) velocity: V3,
    /// Angular velocity of the wheel, its spin included.
    pub(crate) rotation: V3,
    /// Unit, to the left.
    pub(crate) axis: V3,
    /// About the axis, rad/s, positive rolling forward.
    pub(crate) spin: f64,
}

/// What a contact does to a wheel; world axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reaction {
    /// Normal force, N.
    pub(crate) load: f64,
    pub(crate) force: V3,
    /// About the hub, less what turns the wheel, N m.
    pub(crate) moment: V3,
    /// About the axle, N m.
    pub(crate) spin_moment: f64,
}

/// A tyre that is ready to be simulated or sampled.
#[derive(Clone, Debug)]
pub struct Tyre {
    envelope: Envelope,
    model: Model,
    damping: f64,
    rolling_share: f64,
}

#[derive(Clone, Debug)]
enum Model {
    Rigid(Rigid),
    Brush(Brush),
    Fiala(Fiala),
    Tmeasy(Box<Tmeasy>),
}

impl Tyre {
    #[must_use]
    pub fn new(spec: &TyreSpec) -> Self {
        // How much of the deflection a wheel rolls on less than its free radius: none of a hard one's, a third
        // (Rill: R_e = (2 R_0 + R_s)/3), all of Fiala's (Adams/Tire).
        let (model, rolling_share) = match spec {
            TyreSpec::Rigid(t) => (Model::Rigid(Rigid::new(t)), 0.0),
            TyreSpec::Brush(t) => (Model::Brush(Brush::new(t)), 1.0 / 3.0),
            TyreSpec::Fiala(t) => (Model::Fiala(Fiala::new(t)), 1.0),
            TyreSpec::Tmeasy(t) => (Model::Tmeasy(Box::new(Tmeasy::new(t))), 1.0 / 3.0),
        };
        Self {
            envelope: Envelope::new(spec.radius(), spec.width()),
            model,
            damping: spec.vertical_damping(),
            rolling_share,
        }
    }

    pub(crate) fn envelope(&self) -> &Envelope {
        &self.envelope
    }

    /// Greatest gap at which the tyre still feels the ground, m.
    pub(crate) fn reach(&self) -> f64 {
        if let Model::Rigid(m) = &self.model { m.reach() } else { 0.0 }
    }

    /// Damping along the contact's normal, N s/m, which the equations of motion take in implicitly.
    pub(crate) fn damping(&self) -> f64 {
        self.damping
    }

    /// The radial force of a deflection (m) at rest, N; both are ≥ 0.
    #[must_use]
    pub fn vertical_force(&self, deflection: f64) -> f64 {
        match &self.model {
            Model::Rigid(m) => m.stiffness * deflection,
            Model::Brush(m) => m.stiffness * deflection,
            Model::Fiala(m) => m.vertical(deflection),
            Model::Tmeasy(m) => m.vertical(deflection),
        }
    }

    /// Advances a contact by `dt` and returns its reaction on the wheel, if it presses at all.
    ///
    /// `friction`: coefficient of the ground alone.
    #[inline]
    pub(crate) fn react(
        &self,
        motion: &WheelMotion,
        contact: &Contact,
        friction: f64,
        patch: &mut Patch,
        dt: f64,
    ) -> Option<Reaction> {
        let n = contact.normal;
        // Ice without any friction would divide by zero.
        let friction = friction.max(1e-6);
        let mut depth = contact.depth;
        if let Model::Rigid(m) = &self.model
            && m.reach() > 0.0
        {
            let velocity = motion.velocity + motion.rotation.cross(&(contact.point - motion.hub));
            depth += m.lift((velocity - n * velocity.dot(&n)).norm(), friction);
        }
        let elastic = self.vertical_force(depth.max(0.0));
        // The damper does no more than the spring, so that contacts begin and end without a jump.
        let load = elastic - (self.damping * motion.velocity.dot(&n)).clamp(-elastic, elastic);
        if load <= 0.0 {
            *patch = Patch::default();
            return None;
        }
        // A contact at the wheel's side has no rolling direction; any one in its plane will do.
        let along = motion
            .axis
            .cross(&n)
            .try_normalize(0.05)
            .unwrap_or_else(|| n.cross(&V3::z()).try_normalize(1e-6).unwrap_or_else(V3::x));
        let across = n.cross(&along);
        let arm = contact.point - motion.hub;
        // The tread rolls on a radius between the loaded and the free one.
        let lever = arm.norm();
        let longer = (1.0 - self.rolling_share) * contact.depth;
        let rolling_arm = if lever > 0.0 { arm * ((lever + longer) / lever) } else { arm };
        let sliding = motion.velocity + motion.rotation.cross(&rolling_arm);
        let slide = Slide {
            sliding: [sliding.dot(&along), sliding.dot(&across)],
            rolling: (motion.axis.cross(&rolling_arm) * motion.spin).norm(),
            forward: motion.velocity.dot(&along).abs(),
            load,
            depth: contact.depth,
            friction,
        };
        let mut resistance = 0.0;
        let mut twist = V3::zeros();
        let plane = match &self.model {
            Model::Rigid(m) => m.advance(patch, &slide, dt),
            Model::Brush(m) => {
                let sign = (motion.spin * lever / 0.1).clamp(-1.0, 1.0);
                resistance = m.rolling_resistance * load * lever * sign;
                m.advance(patch, &slide, dt)
            }
            Model::Fiala(m) => {
                resistance = m.rolling_moment(load, slide.forward, motion.spin);
                let (force, aligning) = m.advance(patch, &slide, dt);
                twist = n * aligning;
                force
            }
            Model::Tmeasy(m) => {
                resistance = m.rolling_moment(load, motion.spin);
                let (force, aligning) = m.advance(patch, &slide, dt);
                let overturning = m.extra_overturning(contact.depth) * motion.axis.dot(&n);
                twist = n * aligning - along * overturning;
                force
            }
        };
        let tangential = along * plane[0] + across * plane[1];
        let force = tangential + n * load;
        let moment = arm.cross(&force) + twist;
        Some(Reaction {
            load,
            force,
            moment: moment - motion.axis * motion.axis.dot(&moment),
            // The pressure acts through the axle; only friction and rolling resistance turn the wheel.
            spin_moment: motion.axis.dot(&rolling_arm.cross(&tangential)) - resistance,
        })
    }
}
