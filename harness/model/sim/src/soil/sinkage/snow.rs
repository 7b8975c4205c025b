//! Snow of finite depth.

use super::PressureSinkage;
use serde::{Deserialize, Serialize};
use vb_files::Flaw;
use vb_files::document::within;

/// Snow over firm ground, compacted in place: a sinkage z in snow of depth h and density ρ₀ gives the density
/// ρ = ρ₀/(1 − z/h) (Richmond, CRREL Report 95-7, 1995: z = h (1 − ρ₀/ρ_f)), and `compaction_pressure` gives the
/// pressure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Snow {
    /// The depth h of the undisturbed snow, m.
    pub depth: f64,
    /// The density ρ₀ of the undisturbed snow, kg/m³.
    pub density: f64,
}

/// Density of compacted snow at the pressure [`COMPACTION_PRESSURE`], kg/m³.
const COMPACTION_DENSITY: f64 = 575.0;
/// Pressure at [`COMPACTION_DENSITY`], Pa, and the increase of density over which the pressure rises by the factor e,
/// kg/m³: the least-squares line of ln p over density through the table of CRREL Report 95-7, which has the final
/// densities 500, 550, 600 and 650 kg/m³ for greatest pressures up to 210, 350 and 700 kPa and above. Each density is
/// taken at the geometric mean of its range, 102, 271, 495 and 990 kPa. The first range begins at the 50 kPa of the
/// M113 (CRREL Report 95-1 has the first density for it), the last ends at twice its beginning, as the one before (ours).
const COMPACTION_PRESSURE: f64 = 341.0e3;
const COMPACTION_SCALE: f64 = 67.4;
/// Greatest pressure of that table that is bounded, Pa: at higher ones, which only impacts reach, not the compacted snow on
/// firm ground yields but the tyre.
const FIRM_PRESSURE: f64 = 700.0e3;
/// Stiffness from there on, Pa/m: that of tyres, 100 to 400 kN/m, over a contact of 0.1 to 0.2 m² (ours).
const FIRM_STIFFNESS: f64 = 2.0e6;

/// The pressure (Pa) that compacts snow to a density, kg/m³.
fn compaction_pressure(density: f64) -> f64 {
    COMPACTION_PRESSURE * vb_math::exp((density - COMPACTION_DENSITY) / COMPACTION_SCALE)
}

impl PressureSinkage for Snow {
    const FORMULA: &'static str = "z = h (1 − ρ0/ρf), ρf over p";
    const SOURCE: &'static str = "CRREL Report 95-7";

    fn shape(&self, sinkage: f64) -> f64 {
        let Self { depth, density } = *self;
        // The density at which the pressure is [`FIRM_PRESSURE`].
        let firm = COMPACTION_DENSITY + COMPACTION_SCALE * vb_math::ln(FIRM_PRESSURE / COMPACTION_PRESSURE);
        let end = depth * (1.0 - density / firm).max(0.0);
        let compacted = density / (1.0 - sinkage.min(end) / depth);
        compaction_pressure(compacted) - compaction_pressure(density)
            + FIRM_STIFFNESS * (sinkage - end).max(0.0)
    }

    /// The density under the plate is that at which the pressure is that of compaction from the undisturbed density on.
    /// It is of pressures below [`FIRM_PRESSURE`].
    fn plate_sinkage(&self, pressure: f64, _: f64) -> f64 {
        let all = pressure + compaction_pressure(self.density);
        let compacted = COMPACTION_DENSITY + COMPACTION_SCALE * vb_math::ln(all / COMPACTION_PRESSURE);
        self.depth * (1.0 - self.density / compacted)
    }

    fn check(&self) -> Result<(), Flaw> {
        within("depth", self.depth, 0.01, 3.0)?;
        within("density", self.density, 50.0, 600.0)
    }

    /// The slope of loading at the pressure of a heavy wheel, 350 kPa: dp/dz = p ρ²/(ρ₀ h · scale).
    fn softest_unloading(&self) -> f64 {
        350e3 * 577.0 * 577.0 / (self.density * self.depth * COMPACTION_SCALE)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Sinkage;
    use super::*;

    /// CRREL Report 95-7: z = h (1 − ρ₀/ρ_f), ρ_f by steps of the greatest pressure.
    #[test]
    fn snow_sinks_as_far_as_its_final_density_at_each_pressure_allows() {
        for (depth, density) in [(0.13, 160.0), (0.21, 220.0), (0.35, 150.0), (0.12, 300.0)] {
            let snow = Sinkage::Snow(Snow { depth, density });
            for (kpa, compacted) in [(150.0, 500.0), (280.0, 550.0), (500.0, 600.0)] {
                let z = depth * (1.0 - density / compacted);
                let wanted = |f: f64| depth * (1.0 - density / (compacted + f));
                let (mut low, mut high) = (0.0, depth);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if snow.pressure(middle, 0.3) < 1e3 * kpa { low = middle } else { high = middle }
                }
                // Half a step of density to either side: the law rises smoothly through the steps.
                assert!(
                    low > wanted(-25.0) && low < wanted(25.0),
                    "{depth} m of {density} kg/m³ at {kpa} kPa: {low} m, CRREL {z}"
                );
            }
            assert_eq!(snow.pressure(0.0, 0.3), 0.0);
            // 50 kN on 0.1 m² go 0.1 m deeper at most, as a soft tyre does.
            let end = depth * (1.0 - density / 623.5);
            assert!(snow.pressure(end + 0.1, 0.3) - snow.pressure(end, 0.3) < 0.5e6);
            assert!((snow.pressure(end, 0.3) / 700e3 - 1.0).abs() < 0.05);
        }
    }
}
