//! Tables of the functions that a step asks for hundreds of times: a power, an exponential and its inverse.

/// Segments an octave, as a number of bits.
const BITS: u32 = 6;
/// Smallest and largest argument as powers of two: a micrometre and 4 m.
const OCTAVES: [i32; 2] = [-20, 2];

/// z^n for z in [1 µm, 4 m), linear within 64 segments an octave: relative error below n|n−1|·3.1e-5; linear to zero
/// below, constant above.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Power {
    values: Vec<f64>,
}

impl Power {
    pub(crate) fn new(n: f64) -> Self {
        let segments = ((OCTAVES[1] - OCTAVES[0]) << BITS) as usize;
        let value = |k: usize| {
            let octave = OCTAVES[0] + (k >> BITS) as i32;
            let mantissa = 1.0 + (k & ((1 << BITS) - 1)) as f64 / f64::from(1 << BITS);
            vb_math::pow(mantissa * vb_math::pow(2.0, f64::from(octave)), n)
        };
        Self { values: (0..=segments).map(value).collect() }
    }

    #[inline]
    pub(crate) fn at(&self, z: f64) -> f64 {
        const SHIFT: u32 = 52 - BITS;
        const BASE: u64 = ((1023 + OCTAVES[0]) as u64) << BITS;
        const FIRST: f64 = 1.0 / (1 << -OCTAVES[0]) as f64;
        if z < FIRST {
            return self.values[0] * (z * (1.0 / FIRST)).max(0.0);
        }
        let bits = z.to_bits();
        let index = ((bits >> SHIFT) - BASE) as usize;
        let Some([a, b]) = self.values.get(index..index + 2) else {
            return self.values.last().copied().unwrap_or_default();
        };
        // The mantissa's lower bits as a fraction of the segment.
        let within = f64::from_bits((bits << BITS & ((1 << 52) - 1)) | 1.0_f64.to_bits()) - 1.0;
        a + (b - a) * within
    }
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

    #[inline]
    pub(crate) fn at(&self, x: f64) -> f64 {
        let f = x.clamp(0.0, SATURATED) * 64.0;
        let k = f as u32;
        let Some([a, b]) = self.values.get(k as usize..k as usize + 2) else { return 1.0 };
        a + (b - a) * (f - f64::from(k))
    }

    /// x of a value 1 − exp(−x): 0 for values up to 0, and where the table ends for those near 1.
    #[inline]
    pub(crate) fn inverse(&self, value: f64) -> f64 {
        const SHIFT: u32 = 52 - BITS;
        const BASE: u64 = ((1023 + LEAST) as u64) << BITS;
        const FIRST: f64 = 1.0 / (1 << -LEAST) as f64;
        let bits = (1.0 - value).max(FIRST).to_bits();
        let index = ((bits >> SHIFT) - BASE) as usize;
        let Some([a, b]) = self.inverse.get(index..index + 2) else { return 0.0 };
        let within = f64::from_bits((bits << BITS & ((1 << 52) - 1)) | 1.0_f64.to_bits()) - 1.0;
        a + (b - a) * within
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_agree_with_the_functions() {
        for n in [0.13, 0.5, 0.793, 1.0, 1.1, 1.6, 3.0] {
            let table = Power::new(n);
            let mut z = 1e-6;
            while z < 3.9 {
                let exact = vb_math::pow(z, n);
                let bound = 1e-12 + 1.01 * n * (n - 1.0).abs() / 8.0 / 4096.0;
                assert!((table.at(z) / exact - 1.0).abs() < bound, "{z}^{n}: {} {exact}", table.at(z));
                z *= 1.0137;
            }
            assert_eq!(table.at(0.0), 0.0);
            assert!(table.at(9.0).is_finite() && table.at(f64::NAN).is_finite());
        }
        let table = Saturation::new();
        for k in 0..=5000 {
            let x = 1e-3 * f64::from(k);
            let value = 1.0 - vb_math::exp(-x);
            assert!((table.at(x) - value).abs() < 3.1e-5, "{x}");
            assert!((table.inverse(value) - x).abs() < 3.1e-5, "{x}: {}", table.inverse(value));
        }
        assert_eq!((table.at(0.0), table.inverse(0.0), table.inverse(-1.0)), (0.0, 0.0, 0.0));
        assert_eq!(table.at(70.0), table.at(5.0));
        assert!(table.inverse(1.0) > SATURATED && table.inverse(f64::NAN).is_finite());
    }
}
