//! Numbers as people read them.

use crate::check::Expected;

/// A measured or expected number: as many digits as tell values apart.
#[must_use]
pub fn number(v: f64) -> String {
    let digits = match v.abs() {
        a if a >= 1000.0 => 0,
        a if a >= 100.0 => 1,
        a if a >= 10.0 => 2,
        a if a >= 0.1 || a == 0.0 => 3,
        _ => 5,
    };
    let text = format!("{v:.digits$}");
    let zero = text.bytes().all(|b| b"-0.".contains(&b));
    if zero { "0".to_owned() } else { text.replace('-', "−") }
}

/// What was expected, as people write it.
#[must_use]
pub fn expected(e: Expected) -> String {
    match e {
        Expected::Within { value, tolerance } => format!("{} ± {}", number(value), number(tolerance)),
        Expected::AtLeast(low) => format!("≥ {}", number(low)),
        Expected::AtMost(high) => format!("≤ {}", number(high)),
        Expected::Between(low, high) => format!("{} … {}", number(low), number(high)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_tell_them_apart() {
        let shown = [24_461.8, 126.57, 12.461, 0.645, -0.0123, 0.0, 1e-9].map(number);
        assert_eq!(shown, ["24462", "126.6", "12.46", "0.645", "−0.01230", "0", "0"]);
        assert_eq!(expected(Expected::fraction(12.461, 0.05)), "12.46 ± 0.623");
        assert_eq!(expected(Expected::Between(1.0, 2.0)), "1.000 … 2.000");
    }
}
