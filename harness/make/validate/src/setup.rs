//! The set-up in which the runs of a reference were made, where it is not that of the vehicle under test.

use crate::check::Kind;
use serde::Deserialize;
use vb_files::Flaw;
use vb_vehicle::{VehicleSpec, powertrain::Differential};

/// A vehicle in the set-up of a reference. It starts from the vehicle as its file has it, whatever tyre is put on for the
/// test, since the reference's runs were made with one set-up.
#[derive(Clone, Debug, PartialEq)]
pub struct Setup {
    /// What it departs in from the vehicle as it is, and why: for people.
    pub about: String,
    /// The vehicle on rigid ground.
    pub ground: VehicleSpec,
    /// The vehicle on soil.
    pub soil: VehicleSpec,
}

/// A set-up as a file gives it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Entry {
    about: String,
    tyre: Option<String>,
    /// The centre differential, of vehicles whose transfer case has a choice.
    centre: Option<Differential>,
    /// As [`vb_vehicle::Chassis::resistance`], on rigid ground: that of the runs comes from their contact with it.
    resistance: Option<Vec<[f64; 2]>>,
    /// Width of the tyres on soil, m.
    soil_width: Option<f64>,
}

impl Entry {
    /// The set-up of a vehicle, or the field that is at fault and why.
    pub(crate) fn setup(self, vehicle: &VehicleSpec) -> Result<Setup, Flaw> {
        let mut soil = vehicle.clone();
        if let Some(name) = &self.tyre {
            soil = soil.with_tyre(name).map_err(|e| Flaw::new("tyre", e.problem))?;
        }
        if let Some(centre) = self.centre {
            soil.powertrain.driveline.centre = centre;
        }
        let mut ground = soil.clone();
        if let Some(table) = self.resistance {
            resistance(&table)?;
            ground.chassis.resistance = table;
        }
        if let Some(width) = self.soil_width {
            if !(width.is_finite() && width > 0.0) {
                return Err(Flaw::must_be("soil_width", width, "a positive number"));
            }
            soil.tyre.set_width(width);
            soil.axles.iter_mut().filter_map(|a| a.tyre.as_mut()).for_each(|t| t.set_width(width));
        }
        Ok(Setup { about: self.about, ground, soil })
    }
}

/// Refuses a table of resistances that no vehicle file may have.
fn resistance(table: &[[f64; 2]]) -> Result<(), Flaw> {
    if table.is_empty() {
        return Err(Flaw::new("resistance", "needs at least one point [speed, force]"));
    }
    for (i, point) in table.iter().enumerate() {
        for (k, value) in point.iter().enumerate() {
            if !(value.is_finite() && *value >= 0.0) {
                let field = format!("resistance[{i}][{k}]");
                return Err(Flaw::must_be(field, value, "zero or a positive number"));
            }
        }
        if i > 0 && point[0] <= table[i - 1][0] {
            let reason = format!("speeds must increase, but {} follows {}", point[0], table[i - 1][0]);
            return Err(Flaw::new(format!("resistance[{i}][0]"), reason));
        }
    }
    Ok(())
}

/// Why references of a kind can have no set-up, if they can't.
pub(crate) fn refused(kind: Kind) -> Option<String> {
    matches!(kind, Kind::Theory | Kind::Convergence).then(|| {
        format!(
            "{} is compared with the unchanged vehicle; only {} and {} have a set-up",
            kind.name(),
            Kind::Published.name(),
            Kind::Chrono.name()
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vehicle() -> VehicleSpec {
        VehicleSpec::parse(include_str!("../../../../tasks/vehicles/hmmwv.yaml"), "hmmwv.yaml").unwrap()
    }

    fn read(fields: &str) -> Result<Setup, String> {
        let entry: Entry =
            vb_files::yaml::parse(&format!("{{about: a, {fields}}}")).map_err(|e| e.to_string())?;
        entry.setup(&vehicle()).map_err(|e| e.to_string())
    }

    #[test]
    fn the_resistance_is_of_rigid_ground_and_the_width_of_soil() {
        let setup = read("tyre: rigid, resistance: [[0, 0], [5, 186.0]], soil_width: 0.3").unwrap();
        let size = |v: &VehicleSpec| (v.tyre.model(), v.tyre.width());
        assert_eq!((size(&setup.ground), size(&setup.soil)), (("rigid", 0.254), ("rigid", 0.3)));
        assert_eq!(setup.ground.chassis.resistance, [[0.0, 0.0], [5.0, 186.0]]);
        assert!(setup.soil.chassis.resistance.is_empty());
    }

    #[test]
    fn the_centre_differential_is_that_of_the_setup() {
        assert_eq!(vehicle().powertrain.driveline.centre, Differential::Locked {});
        let setup = read("centre: {type: open}").unwrap();
        for v in [&setup.ground, &setup.soil] {
            assert_eq!(v.powertrain.driveline.centre, Differential::Open {});
        }
    }

    #[test]
    fn a_setup_changes_nothing_that_it_does_not_state() {
        let setup = read("").unwrap();
        assert!(setup.ground == vehicle() && setup.soil == vehicle());
        let mut wide = vehicle();
        wide.axles[1].tyre = Some(wide.tyre.clone());
        let entry: Entry = vb_files::yaml::parse("{about: a, soil_width: 0.3}").unwrap();
        let setup = entry.setup(&wide).unwrap();
        assert_eq!(setup.soil.wheel_sizes(), [[0.467, 0.3]; 4], "axles with tyres of their own, too");
        assert!(setup.ground == wide);
    }

    #[test]
    fn what_the_vehicle_lacks_and_what_is_no_number_is_refused_with_field_and_value() {
        for (fields, says) in [
            ("tyre: square", "tyre: \"square\" is not among them; choose one of brush, fiala, rigid, tmeasy"),
            ("centre: {type: viscous}", "centre"),
            ("soil_width: -0.3", "soil_width: -0.3 must be a positive number"),
            ("soil_width: .nan", "soil_width: NaN must be a positive number"),
            ("resistance: []", "resistance: needs at least one point"),
            ("resistance: [[0, 0], [5, -1]]", "resistance[1][1]: -1 must be zero or a positive number"),
            ("resistance: [[0, .inf]]", "resistance[0][1]: inf must be zero or a positive number"),
            ("resistance: [[5, 0], [5, 1]]", "resistance[1][0]: speeds must increase, but 5 follows 5"),
            ("width: 0.3", "width"),
        ] {
            let error = read(fields).unwrap_err();
            assert!(error.contains(says), "{fields}: {error}");
        }
    }
}
