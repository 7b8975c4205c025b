//! Filters of second order for four signals at a time.

use vb_math::tan;

/// The number of signals that are filtered together: the accelerations along x, y and z, and the absorbed power.
pub(super) const LANES: usize = 4;

/// A value for each signal. Sums and products are those of single numbers, bit for bit.
pub(super) type Lanes = wide::f64x4;

/// A highest frequency of a filter, as a fraction of the sampling rate: the tangent of the bilinear transform has its pole at
/// 0.5. Filters above it end there.
const HIGHEST: f64 = 0.45;

/// An analogue section (b₀ + b₁ s + b₂ s²) / (a₀ + a₁ s + a₂ s²), s in rad/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Section {
    pub(super) numerator: [f64; 3],
    pub(super) denominator: [f64; 3],
    /// The frequency at which the digital section equals this one exactly, rad/s; 0 for low frequencies.
    pub(super) exact_at: f64,
}

impl Section {
    /// The section that changes nothing.
    pub(super) const IDENTITY: Self =
        Self { numerator: [1.0, 0.0, 0.0], denominator: [1.0, 0.0, 0.0], exact_at: 0.0 };

    /// The coefficients b₀, b₁, b₂, a₁, a₂ of the digital section with this time between two samples (s), by the bilinear transform
    /// s = k (1 − z⁻¹) / (1 + z⁻¹).
    fn digital(&self, step: f64) -> [f64; 5] {
        let k =
            if self.exact_at > 0.0 { self.exact_at / tan(0.5 * self.exact_at * step) } else { 2.0 / step };
        let at = |[c0, c1, c2]: [f64; 3]| {
            [c0 + c1 * k + c2 * k * k, 2.0 * (c0 - c2 * k * k), c0 - c1 * k + c2 * k * k]
        };
        let (b, a) = (at(self.numerator), at(self.denominator));
        [b[0] / a[0], b[1] / a[0], b[2] / a[0], a[1] / a[0], a[2] / a[0]]
    }
}

/// A frequency (Hz) that filters with this time between two samples (s) can have, in rad/s.
pub(super) fn angular(frequency: f64, step: f64) -> f64 {
    std::f64::consts::TAU * frequency.min(HIGHEST / step)
}

/// A digital section for each signal, in the second direct form, transposed.
#[derive(Clone, Debug)]
pub(super) struct Filter {
    coefficients: [Lanes; 5],
    state: [Lanes; 2],
}

impl Filter {
    /// These sections at rest, with this time between two samples, s.
    pub(super) fn new(sections: [Section; LANES], step: f64) -> Self {
        let sections = sections.map(|section| section.digital(step));
        let coefficients = [0, 1, 2, 3, 4].map(|k| Lanes::new(sections.map(|own| own[k])));
        Self { coefficients, state: [Lanes::ZERO; 2] }
    }

    /// The coefficients b₀, b₁, b₂, a₁, a₂ of a signal.
    #[cfg(test)]
    pub(super) fn coefficients(&self, lane: usize) -> [f64; 5] {
        self.coefficients.map(|c| c.to_array()[lane])
    }

    #[inline]
    pub(super) fn push(&mut self, x: Lanes) -> Lanes {
        let [b0, b1, b2, a1, a2] = self.coefficients;
        let y = b0 * x + self.state[0];
        self.state = [b1 * x - a1 * y + self.state[1], b2 * x - a2 * y];
        y
    }
}
