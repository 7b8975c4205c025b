//! Power and exponential by short polynomials: several times faster than the `libm` crate's, good to six digits, and
//! of additions, multiplications and bit operations alone, so just as deterministic.

/// Adding this rounds a number below 2⁵¹ to an integer and leaves that in the low bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// log₂ x for finite x > 0, to 1e-7.
#[inline]
fn log2(x: f64) -> f64 {
    let bits = x.to_bits();
    // Split so that the mantissa lies in [√½, √2).
    let shifted = bits.wrapping_sub(0x3fe6_a09e_667f_3bcd);
    let exponent = (shifted as i64) >> 52;
    let m = f64::from_bits(bits.wrapping_sub((exponent as u64) << 52));
    // log m = 2 artanh((m−1)/(m+1)) with |t| < 0.1716; the first term left out is 2t⁹/9 < 3e-8.
    let t = (m - 1.0) / (m + 1.0);
    let s = t * t;
    let series = (1.0 + s * (1.0 / 3.0)) + (s * s) * (0.2 + s * (1.0 / 7.0));
    exponent as f64 + (2.0 * std::f64::consts::LOG2_E) * t * series
}

/// 2ˣ for |x| < 1000.
#[inline]
fn exp2(x: f64) -> f64 {
    let rounded = x + ROUND;
    let r = (x - (rounded - ROUND)) * std::f64::consts::LN_2;
    // |r| < 0.3466: Taylor's series, the first term left out is r⁷/7! < 2e-7.
    let s = r * r;
    let p = (1.0 + r)
        + s * ((0.5 + r * (1.0 / 6.0)) + s * ((1.0 / 24.0 + r * (1.0 / 120.0)) + s * (1.0 / 720.0)));
    // The low bits of `rounded` are the integer; those that don't fit are shifted out.
    f64::from_bits(rounded.to_bits().wrapping_add(1023) << 52) * p
}

/// `x` to the power `y` for x ≥ 0 (0 below 1e-60) and |y| ≤ 4; relative error below 1e-6 for results between 1e-60
/// and 1e60.
#[inline]
#[must_use]
pub fn fast_pow(x: f64, y: f64) -> f64 {
    if x < 1e-60 {
        return 0.0;
    }
    exp2(y * log2(x))
}

/// Natural exponential for |x| ≤ 600, the nearest of these outside; relative error below 1e-6.
#[inline]
#[must_use]
pub fn fast_exp(x: f64) -> f64 {
    exp2(x.clamp(-600.0, 600.0) * std::f64::consts::LOG2_E)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_and_exponentials_agree_with_libm_to_six_digits() {
        let mut x = 1e-7;
        while x < 1e4 {
            for y in [0.13, 0.5, 0.793, 1.0, 1.1, 1.6, 2.0] {
                let exact = libm::pow(x, y);
                assert!((fast_pow(x, y) / exact - 1.0).abs() < 1e-6, "{x}^{y}");
            }
            x *= 1.0137;
        }
        for k in -10_000..=2000 {
            let x = 0.01 * f64::from(k);
            assert!((fast_exp(x) / libm::exp(x) - 1.0).abs() < 1e-6, "exp {x}");
        }
        assert_eq!(fast_pow(0.0, 1.1), 0.0);
        assert_eq!(fast_exp(0.0), 1.0);
        assert!(fast_exp(-1e9) < 1e-200 && fast_exp(1e9).is_finite());
    }
}
