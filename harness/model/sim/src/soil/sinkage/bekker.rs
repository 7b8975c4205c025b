//! Soil without a bottom.

use super::PressureSinkage;
use serde::{Deserialize, Serialize};
use vb_files::Flaw;
use vb_files::document::within;

/// Soil without a bottom: p = (k_c/b + k_φ) zⁿ with the smaller dimension b of the contact patch (Bekker's law as
/// restated by Wong, Theory of Ground Vehicles, 4th ed. 2008, eq. 2.61).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bekker {
    /// The frictional modulus k_φ, N/m^(n+2).
    pub k_phi: f64,
    /// The cohesive modulus k_c, N/m^(n+1).
    pub k_c: f64,
    /// The exponent n of the sinkage.
    pub exponent: f64,
}

impl PressureSinkage for Bekker {
    const FORMULA: &'static str = "p = (kc/b + kφ) zⁿ";
    const SOURCE: &'static str = "Wong 2008, eq. 2.61";

    fn moduli(&self) -> [f64; 2] {
        [self.k_phi, self.k_c]
    }

    fn shape(&self, sinkage: f64) -> f64 {
        vb_math::pow(sinkage, self.exponent)
    }

    fn plate_sinkage(&self, pressure: f64, breadth: f64) -> f64 {
        vb_math::pow(pressure / (self.k_c / breadth + self.k_phi), 1.0 / self.exponent)
    }

    fn softer(self, factor: f64) -> Self {
        Self { k_phi: self.k_phi / factor, k_c: self.k_c / factor, ..self }
    }

    fn check(&self) -> Result<(), Flaw> {
        within("k_phi", self.k_phi, 1e3, 1e9)?;
        within("k_c", self.k_c, 0.0, 1e8)?;
        within("exponent", self.exponent, 0.05, 3.0)
    }

    fn softest_unloading(&self) -> f64 {
        self.k_phi
    }
}
