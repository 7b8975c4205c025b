//! The steady characteristics of a tyre, for plots and checks.

use super::Tyre;
use super::patch::Slide;
use vb_math::tan;

/// The force and the moment of a tyre that rolls steadily, in ISO axes of the contact: x forward, y left, z up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SteadyForce {
    /// The longitudinal force F_x, N.
    pub longitudinal: f64,
    /// The lateral force F_y, N.
    pub lateral: f64,
    /// The aligning moment M_z, N m; zero for models without one.
    pub aligning: f64,
}

impl Tyre {
    /// The deflection at which the radial force is `load` (N, ≥ 0), m. It is at most the radius.
    #[must_use]
    pub fn deflection(&self, load: f64) -> f64 {
        let (mut low, mut high) = (0.0, self.envelope.radius());
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.vertical_force(middle) < load { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }

    /// The force and the moment of the tyre at a steady slip.
    ///
    /// `load` is the normal force, N. `slip` is the longitudinal slip κ = (ω R_e − v_x)/v_x, which is −1 for a locked
    /// wheel. `slip_angle` is α = atan(v_y/v_x), rad, less than a right angle in size. `friction` is the coefficient of
    /// the ground. The wheel is driven at 10 m/s, where no model's measures for standstill act. The result is zero
    /// where load or friction is not positive.
    #[must_use]
    pub fn steady_force(&self, load: f64, slip: f64, slip_angle: f64, friction: f64) -> SteadyForce {
        if load <= 0.0 || friction <= 0.0 {
            return SteadyForce::default();
        }
        let forward = 10.0;
        let sliding = [-slip * forward, tan(slip_angle) * forward];
        let s = Slide {
            sliding,
            rolling: ((1.0 + slip) * forward).abs(),
            forward,
            load,
            depth: self.deflection(load),
            friction,
        };
        let (force, aligning) = self.model.steady(&s);
        SteadyForce { longitudinal: force[0], lateral: force[1], aligning }
    }

    /// Samples for a plot: for each load (N), in their order, the steady forces over `points`, which are pairs of
    /// longitudinal slip and slip angle (rad); see [`Tyre::steady_force`].
    #[must_use]
    pub fn sample(&self, loads: &[f64], points: &[(f64, f64)], friction: f64) -> Vec<Vec<SteadyForce>> {
        let curve =
            |load: f64| points.iter().map(|&(k, a)| self.steady_force(load, k, a, friction)).collect();
        loads.iter().map(|&load| curve(load)).collect()
    }
}
