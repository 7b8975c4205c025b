//! The vehicle cone index: the weakest fine-grained soil that a wheeled vehicle passes once, from its data alone.

use vb_math::pow;
use vb_vehicle::GRAVITY;

/// Pascal in a unit of the cone index, which is a pound a square inch.
pub(crate) const CONE_INDEX: f64 = 6894.757;
/// Kilograms in a pound, and metres in an inch.
const POUND: f64 = 0.45359237;
const INCH: f64 = 0.0254;

/// What the mobility index is made of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wheeled {
    /// Weight, N.
    pub(crate) weight: f64,
    pub(crate) axles: usize,
    pub(crate) tyres: usize,
    /// Nominal width and unloaded radius of the tyres, m.
    pub(crate) width: f64,
    pub(crate) radius: f64,
    /// Ground clearance, m.
    pub(crate) clearance: f64,
    /// Power of the engine, W.
    pub(crate) power: f64,
    pub(crate) automatic: bool,
}

impl Wheeled {
    /// The mobility index of an all-wheel-drive vehicle without chains (US Army, TM 5-330, and NRMM; Wong, Theory of
    /// Ground Vehicles, 4th ed. 2008, ch. 2.5): (contact pressure factor · weight factor / (tyre factor · grouser factor)
    /// + wheel load factor − clearance factor) · engine factor · transmission factor.
    pub(crate) fn mobility_index(&self) -> f64 {
        let pounds = self.weight / GRAVITY / POUND;
        let (width, radius) = (self.width / INCH, self.radius / INCH);
        let pressure = pounds / (width * radius * self.tyres as f64);
        // Thousands of pounds an axle.
        let load = pounds / 1000.0 / self.axles as f64;
        let weight = match load {
            x if x < 2.0 => 0.553 * x,
            x if x < 13.5 => 0.033 * x + 1.05,
            x if x < 20.0 => 0.142 * x - 0.42,
            x => 0.278 * x - 3.115,
        };
        let tyre = (10.0 + width) / 100.0;
        let clearance = self.clearance / INCH / 10.0;
        // At least 10 hp a ton of 2000 lb.
        let strong = self.power / 745.7 / (pounds / 2000.0) >= 10.0;
        let engine = if strong { 1.0 } else { 1.05 };
        let transmission = if self.automatic { 1.0 } else { 1.05 };
        (pressure * weight / tyre + 0.5 * load - clearance) * engine * transmission
    }

    /// The rating cone index below which the vehicle does not pass once, at the tyre deflection of 15 % of the section
    /// height for which the index is defined (Priddy and Willoughby, Journal of Terramechanics 43, 2006, 85–96).
    pub(crate) fn one_pass(&self) -> f64 {
        let mi = self.mobility_index();
        if mi <= 115.0 { 11.48 + 0.2 * mi - 39.2 / (mi + 3.74) } else { 4.1 * pow(mi, 0.446) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_index_of_a_light_truck_is_the_sum_that_the_formula_makes_by_hand() {
        let truck = Wheeled {
            weight: 5500.0 * POUND * GRAVITY,
            axles: 2,
            tyres: 4,
            width: 12.5 * INCH,
            radius: 18.4 * INCH,
            clearance: 16.0 * INCH,
            power: 150.0 * 745.7,
            automatic: true,
        };
        // 5500 / (12.5 · 18.4 · 4) = 5.978; 0.033 · 2.75 + 1.05 = 1.1408; (10 + 12.5)/100 = 0.225.
        let mi = 5.978_3 * 1.140_75 / 0.225 + 1.375 - 1.6;
        assert!((truck.mobility_index() - mi).abs() < 1e-3, "{}", truck.mobility_index());
        assert!((truck.one_pass() - (11.48 + 0.2 * mi - 39.2 / (mi + 3.74))).abs() < 1e-3);
        let weak = Wheeled { power: 20.0 * 745.7, automatic: false, ..truck };
        assert!((weak.mobility_index() / truck.mobility_index() - 1.05 * 1.05).abs() < 1e-9);
    }
}
