//! Elementary functions from the `libm` crate: the same code, hence the same bits, on every platform.

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
    /// Complementary error function, 2/√π ∫ₓ^∞ exp(−t²) dt.
    erfc => erfc;
    /// Natural logarithm of |Γ(x)|.
    ln_gamma => lgamma;
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

/// `x` within `low` and `high`, as [`f64::clamp`], but `x` itself where a bound is not a number, instead of a panic: a simulation that
/// diverges is reported as such when its state is checked.
#[inline]
#[must_use]
pub fn clamp(x: f64, low: f64, high: f64) -> f64 {
    if low <= high { x.clamp(low, high) } else { x }
}
