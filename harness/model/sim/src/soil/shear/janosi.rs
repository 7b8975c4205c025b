//! Janosi and Hanamoto's shear.

use super::{Mobilised, ShearLaw, greater};
use crate::soil::table::{SATURATED, Saturation};
use fearless_simd::{Simd, f64x4, prelude::*};

/// Shear stress over shear displacement j: τ = (c + p tan φ)(1 − exp(−j/K)) (Janosi and Hanamoto; Wong, Theory of Ground
/// Vehicles, 4th ed. 2008, eq. 2.73).
///
/// It is the solution of dτ/dj = (s − τ)/K, with the strength s, under a displacement j in one direction. In this form it
/// is also defined where the direction changes: stress turns over a displacement of the order of K and shearing to and
/// fro takes work (the same equation is Dahl's model of friction, 1968), whereas a stress that depends on the
/// displacement alone would give all work back, as a spring would. The share τ/s is advanced by that equation and kept
/// as the displacement that it stands for: of the two, that is what rises evenly from station to station, so that it can
/// be moved through the footprint.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Janosi {
    inverse_modulus: f64,
    saturation: Saturation,
}

impl ShearLaw for Janosi {
    fn new(modulus: f64) -> Self {
        Self { inverse_modulus: 1.0 / modulus, saturation: Saturation::new() }
    }

    #[inline(always)]
    fn mobilise<S: Simd>(
        &self,
        simd: S,
        state: [f64x4<S>; 2],
        slip: [f64x4<S>; 2],
        speed: f64x4<S>,
        dt: f64,
    ) -> Mobilised<S> {
        let all = |x: f64| f64x4::splat(simd, x);
        let (zero, one, none) = (all(0.0), all(1.0), all(1e-15));
        let inverse = all(self.inverse_modulus);
        let size = (state[0] * state[0] + state[1] * state[1]).sqrt();
        let way = size * inverse;
        let fraction = self.saturation.at(simd, way);
        let scale = size.simd_gt(none).select(fraction / size, inverse);
        let per_speed = all(dt * self.inverse_modulus);
        let u = speed * per_speed;
        // (exp(u) − 1)/u by its series: where the terms left out matter, exp(−u) is as good as none.
        let series = one + u * (all(0.5) + u * (all(1.0 / 6.0) + u * all(1.0 / 24.0)));
        let keep = one / (one + u * series);
        let gain = per_speed * series;
        let mobilise = |k: usize| (state[k] * scale + slip[k] * gain) * keep;
        let mobilised = [mobilise(0), mobilise(1)];
        let level = (mobilised[0] * mobilised[0] + mobilised[1] * mobilised[1]).sqrt();
        // By differences, so that where nothing slips nothing drifts.
        let ways = |fraction: f64x4<S>| self.saturation.inverse(simd, fraction);
        let further = way + ways(level) - ways(fraction);
        let further = greater(further, zero);
        let further = further.simd_lt(all(SATURATED)).select(further, all(SATURATED));
        let per_share = level.simd_gt(none).select(further / level, one) / inverse;
        let after = [mobilised[0] * per_share, mobilised[1] * per_share];
        Mobilised { state: after, fraction: mobilised, level }
    }
}
