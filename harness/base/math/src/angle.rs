//! Angles in radians.

use std::f64::consts::{PI, TAU};

/// The same direction in [-π, π).
#[inline]
#[must_use]
pub fn wrap(angle: f64) -> f64 {
    let a = (angle + PI) % TAU;
    let a = if a < 0.0 { a + TAU } else { a };
    // A tiny negative remainder plus 2π may round to 2π, which is the excluded end of the interval.
    if a >= TAU { -PI } else { a - PI }
}

/// The turn from direction `from` to direction `to`, in [-π, π), positive to the left.
#[inline]
#[must_use]
pub fn turn(from: f64, to: f64) -> f64 {
    wrap(to - from)
}

/// Degrees to radians.
#[inline]
#[must_use]
pub fn radians(degrees: f64) -> f64 {
    degrees * (PI / 180.0)
}

/// Radians to degrees.
#[inline]
#[must_use]
pub fn degrees(radians: f64) -> f64 {
    radians * (180.0 / PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrap_keeps_the_direction_and_lies_in_the_half_open_interval() {
        for k in -20..=20 {
            let a = 0.7 + f64::from(k) * TAU;
            assert!((wrap(a) - 0.7).abs() < 1e-12, "{a}");
        }
        assert_eq!(wrap(PI), -PI);
        assert_eq!(wrap(-PI), -PI);
        assert_eq!(wrap(3.0 * PI), -PI);
        // The double just below -π: its remainder is the smallest negative number there is here.
        let below = wrap(-PI - 4.5e-16);
        assert!((-PI..PI).contains(&below), "{below}");
    }

    #[test]
    fn turn_takes_the_short_way_round() {
        // From 170° to -170° it is 20° to the left.
        assert!((turn(radians(170.0), radians(-170.0)) - radians(20.0)).abs() < 1e-12);
        assert!((turn(radians(-170.0), radians(170.0)) + radians(20.0)).abs() < 1e-12);
    }

    #[test]
    fn degrees_and_radians_are_inverse() {
        assert!((radians(180.0) - PI).abs() < 1e-15);
        assert!((degrees(radians(33.0)) - 33.0).abs() < 1e-12);
    }
}
