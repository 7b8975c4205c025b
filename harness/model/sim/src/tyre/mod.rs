//! Tyres: where a wheel meets the ground, and the forces there.
//!
//! A contact is found by the [`Envelope`] (or, with an obstacle, by the collision module), whatever the model. The model
//! gives the radial force of its depth and, through the [`Patch`], the forces in its plane; see `Tyre::react`. Each model
//! has a module here, declared by the list of models, `vb_vehicle::tyre_models!`.

mod envelope;
mod patch;
mod sample;
#[cfg(test)]
mod tests;

use crate::V3;
pub(crate) use envelope::Clearance;
pub use envelope::Envelope;
pub use patch::Patch;
use patch::{PlaneForce, Slide, Stance};
pub use sample::SteadyForce;
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

/// The forces of one tyre model.
trait TyreForce {
    /// Fraction of the deflection by which a wheel rolls on less than its free radius: none for a hard one, a third
    /// by Rill (R_e = (2 R_0 + R_s)/3), all of Fiala's (Adams/Tire).
    const ROLLING_SHARE: f64;

    /// The radial force of a deflection (m) at rest, N; both are ≥ 0.
    fn vertical(&self, deflection: f64) -> f64;

    /// Greatest gap at which the tyre still feels the ground, m.
    fn reach(&self) -> f64 {
        0.0
    }

    /// By how much a contact that slides at `speed` (m/s) on ground of a friction is lifted, m. It is asked for where
    /// `reach` isn't zero.
    fn lift(&self, speed: f64, friction: f64) -> f64 {
        let _ = (speed, friction);
        0.0
    }

    /// Advances the contact by `dt`.
    fn advance(&self, patch: &mut Patch, slide: &Slide, on: &Stance, dt: f64) -> PlaneForce;

    /// The force in the contact plane, longitudinal and lateral, N, and the aligning moment, N m, at a steady slip.
    fn steady(&self, slide: &Slide) -> ([f64; 2], f64);
}

macro_rules! models {
    ($($(#[$doc:meta])* $module:ident $variant:ident $data:ident,)*) => {
        $(mod $module;)*

        #[derive(Clone, Debug)]
        enum Model {
            $($variant($module::$variant),)*
        }

        impl Model {
            /// The model of a tyre and its [`TyreForce::ROLLING_SHARE`].
            fn new(spec: &TyreSpec) -> (Self, f64) {
                match spec {
                    $(TyreSpec::$variant(t) => {
                        (Self::$variant($module::$variant::new(t)), $module::$variant::ROLLING_SHARE)
                    })*
                }
            }

            fn vertical(&self, deflection: f64) -> f64 {
                match self { $(Self::$variant(m) => m.vertical(deflection),)* }
            }

            fn reach(&self) -> f64 {
                match self { $(Self::$variant(m) => m.reach(),)* }
            }

            fn lift(&self, speed: f64, friction: f64) -> f64 {
                match self { $(Self::$variant(m) => m.lift(speed, friction),)* }
            }

            #[inline]
            fn advance(&self, patch: &mut Patch, slide: &Slide, on: &Stance, dt: f64) -> PlaneForce {
                match self { $(Self::$variant(m) => m.advance(patch, slide, on, dt),)* }
            }

            fn steady(&self, slide: &Slide) -> ([f64; 2], f64) {
                match self { $(Self::$variant(m) => m.steady(slide),)* }
            }
        }
    };
}
vb_vehicle::tyre_models!(models);

impl Tyre {
    #[must_use]
    pub fn new(spec: &TyreSpec) -> Self {
        let (model, rolling_share) = Model::new(spec);
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
        self.model.reach()
    }

    /// Damping along the contact's normal, N s/m, which the equations of motion take in implicitly.
    pub(crate) fn damping(&self) -> f64 {
        self.damping
    }

    /// The radial force of a deflection (m) at rest, N; both are ≥ 0.
    #[must_use]
    pub fn vertical_force(&self, deflection: f64) -> f64 {
        self.model.vertical(deflection)
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
        if self.model.reach() > 0.0 {
            let velocity = motion.velocity + motion.rotation.cross(&(contact.point - motion.hub));
            depth += self.model.lift((velocity - n * velocity.dot(&n)).norm(), friction);
        }
        let elastic = self.vertical_force(depth.max(0.0));
        // The damper does no more than the spring, so that contacts begin and end without a jump.
        let load = elastic - vb_math::clamp(self.damping * motion.velocity.dot(&n), -elastic, elastic);
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
        let on = Stance { normal: n, along, axis: motion.axis, spin: motion.spin, lever };
        let plane = self.model.advance(patch, &slide, &on, dt);
        let tangential = along * plane.force[0] + across * plane.force[1];
        let force = tangential + n * load;
        let moment = arm.cross(&force) + plane.twist;
        Some(Reaction {
            load,
            force,
            moment: moment - motion.axis * motion.axis.dot(&moment),
            // The pressure acts through the axle; only friction and rolling resistance turn the wheel.
            spin_moment: motion.axis.dot(&rolling_arm.cross(&tangential)) - plane.resistance,
        })
    }
}
