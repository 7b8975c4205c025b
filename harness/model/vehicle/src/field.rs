//! Checks of single fields of a vehicle file.

use vb_files::Flaw;

/// The largest number that a vehicle file may have, in whatever unit: a spring of 1e9 N/m gives a micrometre under a tonne. Squares
/// and products of larger ones leave the range in which a simulation can compute.
pub(crate) const LARGEST: f64 = 1e9;
/// The smallest number above zero where zero makes no sense, for the same reason: one over it is [`LARGEST`].
pub(crate) const SMALLEST: f64 = 1e-9;

/// Checks of single fields, for messages with the field's path.
pub(crate) struct Check;

impl Check {
    pub(crate) fn fail<T>(&self, field: &str, reason: String) -> Result<T, Flaw> {
        Err(Flaw::new(field, reason))
    }

    pub(crate) fn positive(&self, field: &str, value: f64) -> Result<(), Flaw> {
        if (SMALLEST..=LARGEST).contains(&value) {
            return Ok(());
        }
        if value.is_finite() && value > 0.0 {
            return self.beyond(field, value);
        }
        self.fail(field, format!("{value} must be a positive number"))
    }

    pub(crate) fn not_negative(&self, field: &str, value: f64) -> Result<(), Flaw> {
        if (0.0..=LARGEST).contains(&value) {
            return Ok(());
        }
        if value.is_finite() && value > 0.0 {
            return self.beyond(field, value);
        }
        self.fail(field, format!("{value} must be zero or a positive number"))
    }

    pub(crate) fn finite(&self, field: &str, values: &[f64]) -> Result<(), Flaw> {
        match values.iter().find(|v| !(-LARGEST..=LARGEST).contains(*v)) {
            None => Ok(()),
            Some(v) if v.is_finite() => self.beyond(field, *v),
            Some(v) => self.fail(field, format!("{v} is not a number to compute with")),
        }
    }

    pub(crate) fn beyond<T>(&self, field: &str, value: f64) -> Result<T, Flaw> {
        let reason = format!(
            "{value:e} is what no vehicle has (give a size from {SMALLEST:e} to {LARGEST:e}, in SI units)"
        );
        self.fail(field, reason)
    }

    pub(crate) fn all_positive(&self, at: &str, fields: &[(&str, f64)]) -> Result<(), Flaw> {
        fields.iter().try_for_each(|(field, value)| self.positive(&format!("{at}.{field}"), *value))
    }

    /// Both values of fields that are pairs.
    pub(crate) fn pairs_positive(&self, at: &str, fields: &[(&str, [f64; 2])]) -> Result<(), Flaw> {
        for (field, pair) in fields {
            for (i, value) in pair.iter().enumerate() {
                self.positive(&format!("{at}.{field}[{i}]"), *value)?;
            }
        }
        Ok(())
    }

    /// Both values of a damping, which may be zero.
    pub(crate) fn damping_pair(&self, at: &str, field: &str, pair: [f64; 2]) -> Result<(), Flaw> {
        (0..2).try_for_each(|i| self.not_negative(&format!("{at}.{field}[{i}]"), pair[i]))
    }
}
