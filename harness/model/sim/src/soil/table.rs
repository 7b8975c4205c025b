//! Tables of the functions that a step asks for hundreds of times, four numbers at a time: pressure over sinkage, an
//! exponential and its inverse.

use fearless_simd::{Simd, f64x4, prelude::*, u64x4};

/// Segments an octave, as a number of bits.
const BITS: u32 = 6;
/// Smallest and largest argument as powers of two: a micrometre and 4 m.
const OCTAVES: [i32; 2] = [-20, 2];

/// A function of z in [1 µm, 4 m), linear within 64 segments an octave: for zⁿ with a relative error below
/// n|n−1|·3.1e-5; linear to zero below, constant above.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Curve {
    values: Vec<f64>,
}

impl Curve {
    pub(crate) fn new(of: impl Fn(f64) -> f64) -> Self {
        let segments = ((OCTAVES[1] - OCTAVES[0]) << BITS) as usize;
        let value = |k: usize| {
            let octave = OCTAVES[0] + (k >> BITS) as i32;
            let mantissa = 1.0 + (k & ((1 << BITS) - 1)) as f64 / f64::from(1 << BITS);
            of(mantissa * vb_math::pow(2.0, f64::from(octave)))
        };
        Self { values: (0..=segments).map(value).collect() }
    }

    #[inline(always)]
    pub(crate) fn at<S: Simd>(&self, simd: S, z: f64x4<S>) -> f64x4<S> {
        const FIRST: f64 = 1.0 / (1 << -OCTAVES[0]) as f64;
        let all = |x: f64| f64x4::splat(simd, x);
        let (zero, first) = (all(0.0), all(FIRST));
        let below = z.simd_lt(first);
        let last = self.values.last().copied().unwrap_or_default();
        let above = octaves(simd, &self.values, OCTAVES[0], below.select(first, z), last);
        let positive = z.simd_gt(zero).select(z, zero);
        below.select(positive * all(1.0 / FIRST) * all(self.values[0]), above)
    }
}

/// Between two entries of a table of segments of octaves from 2 to the power of `least` on; `beyond` past its end.
#[inline(always)]
fn octaves<S: Simd>(simd: S, table: &[f64], least: i32, x: f64x4<S>, beyond: f64) -> f64x4<S> {
    const SHIFT: u32 = 52 - BITS;
    let base = ((1023 + least) as u64) << BITS;
    let bits: u64x4<S> = x.bitcast();
    let [a, b, c, d] = *(bits >> SHIFT);
    // The mantissa's lower bits as a fraction of the segment.
    let mantissa = ((bits << BITS) & ((1 << 52) - 1)) | u64x4::splat(simd, 1.0_f64.to_bits());
    let within = mantissa.bitcast::<f64x4<S>>() - f64x4::splat(simd, 1.0);
    let index = |k: u64| k.wrapping_sub(base) as usize;
    between(simd, table, [index(a), index(b), index(c), index(d)], within, beyond)
}

/// The part `within` of the way from an entry of a table to the next; `beyond` where there are no such two.
#[inline(always)]
fn between<S: Simd>(
    simd: S,
    table: &[f64],
    [a, b, c, d]: [usize; 4],
    within: f64x4<S>,
    beyond: f64,
) -> f64x4<S> {
    let pair = |k: usize| match table.get(k..).and_then(|rest| rest.first_chunk()) {
        Some(&[from, to]) => [from, to],
        None => [beyond; 2],
    };
    let ([a, e], [b, f], [c, g], [d, h]) = (pair(a), pair(b), pair(c), pair(d));
    let (from, to): (f64x4<S>, f64x4<S>) = ([a, b, c, d].simd_into(simd), [e, f, g, h].simd_into(simd));
    from + (to - from) * within
}

/// 1 − exp(−x) for x in [0, 5], linear within steps of 1/64: error below 3.1e-5; constant above. And its inverse,
/// −ln(1 − s), linear within 64 segments an octave of 1 − s: error below 3.1e-5.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Saturation {
    values: Vec<f64>,
    inverse: Vec<f64>,
}

/// Where the table ends: exp(−5) is as good as none.
pub(crate) const SATURATED: f64 = 5.0;
/// The inverse's table begins at 1 − s = 2^−8, beyond the end of the other.
const LEAST: i32 = -8;

impl Saturation {
    pub(crate) fn new() -> Self {
        let steps = (64.0 * SATURATED) as usize;
        let rest = |k: usize| {
            let mantissa = 1.0 + (k & ((1 << BITS) - 1)) as f64 / f64::from(1 << BITS);
            mantissa * vb_math::pow(2.0, f64::from(LEAST + (k >> BITS) as i32))
        };
        Self {
            values: (0..=steps + 1).map(|k| 1.0 - vb_math::exp(-(k as f64) / 64.0)).collect(),
            inverse: (0..=(-LEAST as usize) << BITS).map(|k| -vb_math::ln(rest(k))).collect(),
        }
    }

    #[inline(always)]
    pub(crate) fn at<S: Simd>(&self, simd: S, x: f64x4<S>) -> f64x4<S> {
        // Added to a whole number below it, its lowest bits are the number's.
        const WHOLE: f64 = (1_u64 << 52) as f64;
        let all = |x: f64| f64x4::splat(simd, x);
        let (least, most) = (all(0.0), all(SATURATED));
        let x = x.simd_lt(least).select(least, x);
        let f = x.simd_gt(most).select(most, x) * all(64.0);
        let whole = f.trunc();
        let [a, b, c, d] = *(whole + all(WHOLE));
        let index = |k: f64| (k.to_bits() & 0xffff) as usize;
        between(simd, &self.values, [index(a), index(b), index(c), index(d)], f - whole, 1.0)
    }

    /// x of a value 1 − exp(−x): 0 for values up to 0, and where the table ends for those near 1.
    #[inline(always)]
    pub(crate) fn inverse<S: Simd>(&self, simd: S, value: f64x4<S>) -> f64x4<S> {
        const FIRST: f64 = 1.0 / (1 << -LEAST) as f64;
        let first = f64x4::splat(simd, FIRST);
        let rest = f64x4::splat(simd, 1.0) - value;
        octaves(simd, &self.inverse, LEAST, rest.simd_gt(first).select(rest, first), 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fearless_simd::{Level, dispatch};

    /// What one of four lanes has, whichever it is.
    fn one(of: impl Fn(&[f64; 4]) -> [f64; 4], x: f64) -> f64 {
        let lanes = of(&[0.25, x, 0.5, 1e-3]);
        let alone = of(&[x; 4]);
        assert!(alone.iter().all(|y| y.to_bits() == lanes[1].to_bits()), "{x}: {alone:?}, {lanes:?}");
        lanes[1]
    }

    fn power(table: &Curve, z: f64) -> f64 {
        one(|z| dispatch!(Level::new(), simd => *table.at(simd, (*z).simd_into(simd))), z)
    }

    fn saturation(table: &Saturation, x: f64) -> f64 {
        one(|x| dispatch!(Level::new(), simd => *table.at(simd, (*x).simd_into(simd))), x)
    }

    fn inverse(table: &Saturation, value: f64) -> f64 {
        one(|v| dispatch!(Level::new(), simd => *table.inverse(simd, (*v).simd_into(simd))), value)
    }

    #[test]
    fn the_tables_agree_with_the_functions() {
        for n in [0.13, 0.5, 0.793, 1.0, 1.1, 1.6, 3.0] {
            let table = Curve::new(|z| vb_math::pow(z, n));
            let mut z = 1e-6;
            while z < 3.9 {
                let exact = vb_math::pow(z, n);
                let bound = 1e-12 + 1.01 * n * (n - 1.0).abs() / 8.0 / 4096.0;
                assert!(
                    (power(&table, z) / exact - 1.0).abs() < bound,
                    "{z}^{n}: {} {exact}",
                    power(&table, z)
                );
                z *= 1.0137;
            }
            assert_eq!(power(&table, 0.0), 0.0);
            assert!(power(&table, 9.0).is_finite() && power(&table, f64::NAN).is_finite());
        }
        let table = Saturation::new();
        for k in 0..=5000 {
            let x = 1e-3 * f64::from(k);
            let value = 1.0 - vb_math::exp(-x);
            assert!((saturation(&table, x) - value).abs() < 3.1e-5, "{x}");
            assert!((inverse(&table, value) - x).abs() < 3.1e-5, "{x}: {}", inverse(&table, value));
        }
        assert_eq!((saturation(&table, 0.0), inverse(&table, 0.0), inverse(&table, -1.0)), (0.0, 0.0, 0.0));
        assert_eq!(saturation(&table, 70.0), saturation(&table, 5.0));
        assert!(inverse(&table, 1.0) > SATURATED && inverse(&table, f64::NAN).is_finite());
    }
}
