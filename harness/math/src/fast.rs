//! Power and exponential by polynomials: several times faster than the `libm` crate's, good to nine digits, and of
//! additions, multiplications and bit operations alone, so as deterministic.

/// log₂ x for finite x > 0; relative error of the result's exponential below 1e-9.
#[inline]
fn log2(x: f64) -> f64 {
    let bits = x.to_bits();
    // Split so that the mantissa lies in [√½, √2).
    let shifted = bits.wrapping_sub(0x3fe6_a09e_667f_3bcd);
    let exponent = (shifted as i64) >> 52;
    let m = f64::from_bits(bits.wrapping_sub((exponent as u64) << 52));
    // log m = 2 artanh((m−1)/(m+1)); |t| < 0.1716, the first term left out is 2t¹³/13 < 2e-11.
    let t = (m - 1.0) / (m + 1.0);
    let s = t * t;
    let series = 1.0 + s * (1.0 / 3.0 + s * (0.2 + s * (1.0 / 7.0 + s * (1.0 / 9.0 + s * (1.0 / 11.0)))));
    exponent as f64 + (2.0 * std::f64::consts::LOG2_E) * t * series
}

/// 2ˣ, with x clamped to [-1000, 1000].
#[inline]
fn exp2(x: f64) -> f64 {
    let x = x.clamp(-1000.0, 1000.0);
    let whole = (x + if x >= 0.0 { 0.5 } else { -0.5 }) as i64;
    let r = (x - whole as f64) * std::f64::consts::LN_2;
    // |r| < 0.3466: Taylor's series, the first term left out is r⁹/9! < 2e-10.
    let p = 1.0
        + r * (1.0
            + r * (1.0 / 2.0
                + r * (1.0 / 6.0
                    + r * (1.0 / 24.0
                        + r * (1.0 / 120.0 + r * (1.0 / 720.0 + r * (1.0 / 5040.0 + r / 40320.0)))))));
    f64::from_bits(((whole + 1023) as u64) << 52) * p
}

/// `x` to the power `y` for x ≥ 0 (0 for x below 1e-300); relative error below 1e-8 for results between 1e-60 and
/// 1e60.
#[inline]
#[must_use]
pub fn fast_pow(x: f64, y: f64) -> f64 {
    if x < 1e-300 {
        return 0.0;
    }
    exp2(y * log2(x))
}

/// Natural exponential; relative error below 1e-9 for |x| < 100.
#[inline]
#[must_use]
pub fn fast_exp(x: f64) -> f64 {
    exp2(x * std::f64::consts::LOG2_E)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_and_exponentials_agree_with_libm() {
        let mut x = 1e-7;
        while x < 1e4 {
            for y in [0.13, 0.5, 0.793, 1.0, 1.1, 1.6, 2.0] {
                let exact = libm::pow(x, y);
                assert!((fast_pow(x, y) / exact - 1.0).abs() < 1e-8, "{x}^{y}");
            }
            x *= 1.0137;
        }
        for k in -10_000..=2000 {
            let x = 0.01 * f64::from(k);
            assert!((fast_exp(x) / libm::exp(x) - 1.0).abs() < 1e-9, "exp {x}");
        }
        assert_eq!(fast_pow(0.0, 1.1), 0.0);
        assert_eq!(fast_exp(0.0), 1.0);
    }
}
