//! The analogue filters of the meter, as published.

use std::f64::consts::SQRT_2;

use super::filter::{LANES, Section, angular};

/// The pounds-force times feet per second in a watt are 1/1.356, which the model has as K₁; K₀ = 4.35370 is its mass in slug, for
/// accelerations in ft/s². With metres, K₀ K₁ is this: W s⁴/m² (1 ft = 0.3048 m).
pub(super) const ABSORBED_POWER: f64 = 1.356 * 4.353_70 / (0.3048 * 0.3048);

/// The filter whose mean squared output is the absorbed power over [`ABSORBED_POWER`] for vertical acceleration (Pradko and Lee
/// 1966), as sections [b₁, b₂, a₁, a₂] of (1 + b₁ s + b₂ s²) / (1 + a₁ s + a₂ s²). The model says the power of a
/// sine of frequency ω as K₀ K₁ a² (F₁F₄ − F₂F₃) / (ω (F₃² + F₄²)), with polynomials F of ω. The sections are its roots: those in
/// the left half-plane of the numerator and of the denominator over s² = −ω². A test compares them with the polynomials.
pub(super) const PRADKO_LEE: [[f64; 4]; LANES] = [
    [
        0.081_591_081_677_084_76,
        0.003_425_567_952_752_919_5,
        0.017_573_077_369_291_167,
        0.000_688_125_076_408_605_7,
    ],
    [
        0.011_851_896_926_250_84,
        0.000_376_039_189_745_451_9,
        0.031_417_063_857_054_71,
        0.000_276_837_493_035_112_6,
    ],
    [
        0.009_708_692_920_893_538,
        0.000_114_351_801_611_327_37,
        0.011_590_905_674_145_864,
        0.000_202_695_830_598_457_6,
    ],
    [0.0, 0.0, 0.054_848_953_099_508_3, 0.0],
];

/// The gain of [`PRADKO_LEE`] at frequency 0: the root of (F₁F₄ − F₂F₃) / ω there, 0.11543 − 0.10543.
pub(super) const PRADKO_LEE_GAIN: f64 = 0.1;

/// The bandwidth of the peak, Hz: ours. A hull without elasticity that strikes rock stops within one step, and the
/// peak without a filter would measure the step. 30 Hz is above all modes of body and wheels (1 to 15 Hz).
pub(super) const PEAK_BANDWIDTH: f64 = 30.0;

/// The four stages of the weighting: W_d for x and y, W_k for z (ISO 2631-1:1997, annex A, table A.1), and the absorbed power of z.
pub(super) fn stages(step: f64) -> [[Section; LANES]; 4] {
    let high_pass = {
        let w = angular(0.4, step);
        Section { numerator: [0.0, 0.0, 1.0], denominator: [w * w, SQRT_2 * w, 1.0], exact_at: w }
    };
    let low_pass = low_pass(100.0, step);
    // Proportional to acceleration at low frequency, to velocity at high frequency.
    let transition = |frequency: f64| {
        let w = angular(frequency, step);
        Section {
            numerator: [1.0, 1.0 / w, 0.0],
            denominator: [1.0, 1.0 / (0.63 * w), 1.0 / (w * w)],
            exact_at: w,
        }
    };
    let upward_step = {
        let (w5, w6) = (angular(2.37, step), angular(3.35, step));
        let ratio = (w5 / w6) * (w5 / w6);
        Section {
            numerator: [ratio, ratio / (0.91 * w5), ratio / (w5 * w5)],
            denominator: [1.0, 1.0 / (0.91 * w6), 1.0 / (w6 * w6)],
            exact_at: w6,
        }
    };
    let power = PRADKO_LEE.map(|[b1, b2, a1, a2]| Section {
        numerator: [1.0, b1, b2],
        denominator: [1.0, a1, a2],
        exact_at: 0.0,
    });
    let horizontal = transition(2.0);
    [
        [high_pass, high_pass, high_pass, power[0]],
        [low_pass, low_pass, low_pass, power[1]],
        [horizontal, horizontal, transition(12.5), power[2]],
        [Section::IDENTITY, Section::IDENTITY, upward_step, power[3]],
    ]
}

/// A low-pass filter of Butterworth's second order up to this frequency, Hz.
pub(super) fn low_pass(frequency: f64, step: f64) -> Section {
    let w = angular(frequency, step);
    Section { numerator: [w * w, 0.0, 0.0], denominator: [w * w, SQRT_2 * w, 1.0], exact_at: w }
}
