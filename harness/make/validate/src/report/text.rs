//! Expectations as people read them.

use crate::check::Expected;
use vb_page::rounded;

/// What was expected, as people write it.
#[must_use]
pub fn expected(e: Expected) -> String {
    match e {
        Expected::Within { value, tolerance } => format!("{} ± {}", rounded(value), rounded(tolerance)),
        Expected::AtLeast(low) => format!("≥ {}", rounded(low)),
        Expected::AtMost(high) => format!("≤ {}", rounded(high)),
        Expected::Between(low, high) => format!("{} … {}", rounded(low), rounded(high)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expectations_have_the_digits_that_tell_them_apart() {
        assert_eq!(expected(Expected::fraction(12.461, 0.05)), "12.46 ± 0.623");
        assert_eq!(expected(Expected::Between(1.0, 2.0)), "1.000 … 2.000");
    }
}
