//! Elementary functions that give the same bits natively and as WASM, and angle helpers.
//!
//! `f64::sin` and its kin call the platform's own library, whose last bits differ; these come from the `libm`
//! crate, compiled into the planner.

use std::f64::consts::{PI, TAU};

macro_rules! unary {
    ($($(#[$doc:meta])* $name:ident => $f:ident;)*) => {
        $($(#[$doc])* #[inline] #[must_use] pub fn $name(x: f64) -> f64 { libm::$f(x) })*
    };
}

unary! {
    /// Sine of an angle in radians.
    sin => sin;
    /// Cosine of an angle in radians.
    cos => cos;
    /// Tangent of an angle in radians.
    tan => tan;
    /// Arc sine, in [-π/2, π/2]; NaN outside [-1, 1].
    asin => asin;
    /// Arc cosine, in [0, π]; NaN outside [-1, 1].
    acos => acos;
    /// Arc tangent, in (-π/2, π/2).
    atan => atan;
    /// Natural exponential.
    exp => exp;
    /// Natural logarithm.
    ln => log;
    /// Hyperbolic tangent.
    tanh => tanh;
}

/// Angle of the vector (x, y) from the x axis, radians, in [-π, π].
#[inline]
#[must_use]
pub fn atan2(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// Sine and cosine of an angle in radians.
#[inline]
#[must_use]
pub fn sin_cos(x: f64) -> (f64, f64) {
    libm::sincos(x)
}

/// `x` to the power `y`.
#[inline]
#[must_use]
pub fn pow(x: f64, y: f64) -> f64 {
    libm::pow(x, y)
}

/// Length of the vector (x, y) without undue overflow.
#[inline]
#[must_use]
pub fn hypot(x: f64, y: f64) -> f64 {
    libm::hypot(x, y)
}

/// The same direction in [-π, π).
#[inline]
#[must_use]
pub fn wrap(angle: f64) -> f64 {
    let a = (angle + PI) % TAU;
    let a = if a < 0.0 { a + TAU } else { a };
    // A tiny negative remainder plus 2π may round to 2π, which is the excluded end of the interval.
    if a >= TAU { -PI } else { a - PI }
}

/// The turn from direction `from` to direction `to`, radians, in [-π, π), positive to the left.
#[inline]
#[must_use]
pub fn turn(from: f64, to: f64) -> f64 {
    wrap(to - from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrap_keeps_the_direction_and_lies_in_the_half_open_interval() {
        for k in -20..=20 {
            assert!((wrap(0.7 + f64::from(k) * TAU) - 0.7).abs() < 1e-12);
        }
        assert_eq!(wrap(PI), -PI);
        assert_eq!(wrap(-PI), -PI);
        // The double just below -π: its remainder is the smallest negative number there is here.
        let below = wrap(-PI - 4.5e-16);
        assert!((-PI..PI).contains(&below), "{below}");
    }

    #[test]
    fn turn_takes_the_short_way_round() {
        // From 170° to -170° it is 20° to the left.
        let degree = PI / 180.0;
        assert!((turn(170.0 * degree, -170.0 * degree) - 20.0 * degree).abs() < 1e-12);
        assert!((turn(-170.0 * degree, 170.0 * degree) + 20.0 * degree).abs() < 1e-12);
    }
}
