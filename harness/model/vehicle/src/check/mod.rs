//! Reading a vehicle file and refusing what no vehicle can be.

mod control;
mod load;
mod powertrain;
mod skid;
mod suspension;
mod tracks;
mod tyre;

use crate::SCALES;
use crate::VehicleSpec;
use crate::field::Check;
use parry3d_f64::math::Vector;
use parry3d_f64::shape::SharedShape;
use vb_files::document::{self, Document};
use vb_files::{DocumentError, Flaw};

impl Document for VehicleSpec {
    type File = Self;
    const KIND: &'static str = "vehicle";
    const FIELDS: &'static str = "docs/custom-vehicle.md";

    fn from_file(spec: Self) -> Result<Self, Flaw> {
        Check.vehicle(&spec)?;
        Ok(spec)
    }

    fn parse(text: &str, file: &str) -> Result<Self, DocumentError> {
        if let Some(foreign) = foreign(text) {
            let problem = format!(
                "{foreign}, which is no vehicle file (vehicle import FILE makes one of it: docs/custom-vehicle.md)"
            );
            return Err(Flaw::new("format", problem).of(Self::KIND, file));
        }
        document::parse(text, file)
    }
}

vb_files::document!(VehicleSpec);

/// What the file of another program's vehicle is, if it is one.
fn foreign(text: &str) -> Option<&'static str> {
    let text = text.trim_start_matches('\u{feff}').trim_start();
    if text.starts_with('<') {
        return Some("an XML file, such as URDF, SDF or MJCF");
    }
    let chrono = text.starts_with('{') && text.contains("\"Name\"") && text.contains("\"Type\"");
    chrono.then_some("a JSON file of Project Chrono")
}

impl Check {
    fn vehicle(&self, v: &VehicleSpec) -> Result<(), Flaw> {
        if v.name.is_empty() || !v.name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-' || c == '_') {
            return self.fail("name", format!("{:?} must be letters, digits, - and _", v.name));
        }
        for (field, value) in
            [("length", v.length), ("width", v.width), ("height", v.height), ("max_speed", v.max_speed)]
        {
            self.positive(field, value)?;
        }
        if !SCALES.contains(&v.scale) {
            let (least, most) = (SCALES.start(), SCALES.end());
            return self.fail("scale", format!("{} must lie in {least} to {most}", v.scale));
        }
        self.chassis(v)?;
        if v.axles.len() < 2 {
            return self.fail("axles", format!("{} given, at least 2 needed", v.axles.len()));
        }
        if !v.axles.is_sorted_by(|a, b| a.position[0] > b.position[0]) {
            return self.fail("axles", "must be listed front to back, at different positions".to_owned());
        }
        if !v.axles.iter().any(|a| a.driven) {
            return self.fail("axles", "none is driven".to_owned());
        }
        let axles = (0..v.axles.len()).map(|i| self.axle(v, i)).collect::<Result<Vec<_>, Flaw>>()?;
        self.carries(v, &axles)?;
        self.can_steer(v, &axles)?;
        self.steering(v)?;
        self.steered_by(v)?;
        self.tyres(v)?;
        self.tracks(v)?;
        self.skid(v)?;
        self.powertrain(v)?;
        self.can_brake(v)?;
        self.can_drive(v)
    }

    fn chassis(&self, v: &VehicleSpec) -> Result<(), Flaw> {
        let c = &v.chassis;
        self.positive("chassis.mass", c.mass)?;
        self.finite("chassis.com", &c.com)?;
        // Twice the box of the vehicle's size about the reference point: nothing of a vehicle lies farther away.
        let within = |field: &str, point: &[f64; 3]| {
            let most = [v.length, v.width, 2.0 * v.height];
            let Some(k) = (0..3).find(|&k| point[k].abs() > most[k]) else { return Ok(()) };
            let reason = format!("{} must lie in -{} to {}", point[k], most[k], most[k]);
            self.fail(&format!("{field}[{k}]"), reason)
        };
        if let Some(seat) = &c.seat {
            self.finite("chassis.seat", seat)?;
            within("chassis.seat", seat)?;
        }
        for (i, &value) in c.inertia.iter().enumerate() {
            self.positive(&format!("chassis.inertia[{i}]"), value)?;
            let others = c.inertia.iter().sum::<f64>() - value;
            if value > others {
                let reason =
                    format!("{value} exceeds the sum of the other two moments ({others}); no body has that");
                return self.fail(&format!("chassis.inertia[{i}]"), reason);
            }
        }
        self.not_negative("chassis.friction", c.friction)?;
        if !c.resistance.is_empty() {
            self.table("chassis.resistance", &c.resistance)?;
            for (i, p) in c.resistance.iter().enumerate() {
                self.not_negative(&format!("chassis.resistance[{i}][0]"), p[0])?;
                self.not_negative(&format!("chassis.resistance[{i}][1]"), p[1])?;
            }
        }
        for (i, part) in c.hull.iter().enumerate() {
            let field = format!("chassis.hull[{i}]");
            for (j, point) in part.iter().enumerate() {
                self.finite(&field, point)?;
                within(&format!("{field}[{j}]"), point)?;
            }
            let points: Vec<_> = part.iter().map(|p| Vector::new(p[0], p[1], p[2])).collect();
            if SharedShape::convex_hull(&points).is_none() {
                return self.fail(&field, format!("{} points do not span a volume", part.len()));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HMMWV: &str = include_str!("../../../../../tasks/vehicles/hmmwv-released.yaml");

    fn broken(from: &str, to: &str) -> String {
        assert!(HMMWV.contains(from), "{from}");
        VehicleSpec::parse(&HMMWV.replacen(from, to, 1), "car.yaml").unwrap_err().to_string()
    }

    #[test]
    fn the_shipped_vehicle_is_valid() {
        VehicleSpec::parse(HMMWV, "hmmwv.yaml").unwrap();
    }

    #[test]
    fn files_of_other_programs_are_called_what_they_are() {
        for (text, what) in [
            ("<?xml version=\"1.0\"?>\n<robot name=\"husky\"/>", "XML file"),
            ("{\n \"Name\": \"HMMWV\", \"Type\": \"Vehicle\"}", "Project Chrono"),
        ] {
            let e = VehicleSpec::parse(text, "car").unwrap_err().to_string();
            assert!(e.starts_with("car: format: ") && e.contains(what) && !e.contains('\n'), "{e}");
        }
    }

    #[test]
    fn messages_name_file_field_value_and_reason() {
        let e = broken("mass: 2095.592", "mass: -3.0");
        assert_eq!(e, "car.yaml: chassis.mass: -3 must be a positive number");
        let e = broken("schema: 1\n", "schema: 1\nscale: 0.001\n");
        assert_eq!(e, "car.yaml: scale: 0.001 must lie in 0.01 to 10");
        let e = broken("inertia: [1078.52, 2955.66, 3570.2]", "inertia: [1078.52, 2955.66, 9570.2]");
        assert!(e.starts_with("car.yaml: chassis.inertia[2]: 9570.2 exceeds the sum"), "{e}");
        let e = broken("stiffness: 167070.939", "stiffness: 0");
        assert!(e.starts_with("car.yaml: axles[0].suspension.struts[0].spring.stiffness: 0 must"), "{e}");
        let e = broken("shift_down: [104.719755, ", "shift_down: [");
        assert!(e.contains("powertrain.gearbox: 6 ratios, 5 shift_down"), "{e}");
    }

    #[test]
    fn a_wrong_type_or_an_unknown_field_is_told_with_field_value_and_line() {
        let e = broken("radius: 0.467", "radius: wide");
        assert!(
            e.contains("car.yaml: tyre.radius: \"wide\"") && e.contains("line ") && !e.contains('\n'),
            "{e}"
        );
        let e = broken("width: 0.254", "breadth: 0.254");
        assert!(e.contains("breadth"), "{e}");
    }

    #[test]
    fn a_tyre_says_what_its_model_lacks_and_what_no_tyre_can_be() {
        let broken = |from: &str, to: &str| {
            let all = include_str!("../../../../../tasks/vehicles/hmmwv.yaml");
            assert!(all.contains(from), "{from}");
            VehicleSpec::parse(&all.replacen(from, to, 1), "car.yaml").unwrap_err().to_string()
        };
        let e = broken("model: fiala", "model: slick");
        assert!(e.contains("tyres.fiala.model") && e.contains("slick") && e.contains("tmeasy"), "{e}");
        let e = broken("    model: rigid\n    radius: 0.467\n", "    radius: 0.467\n    model: rigid\n");
        assert!(e.contains("tyres.rigid") && e.contains("first key is `model:"), "{e}");
        let e = broken("    c_slip: 193929\n", "");
        assert!(e.contains("tyres.fiala") && e.contains("c_slip"), "{e}");
        let e = broken("pn_max: 29969.8931", "pn_max: heavy");
        assert!(e.contains("tyres.tmeasy.pn_max") && e.contains("heavy") && e.contains("line "), "{e}");
        let e = broken("mu_min: 0.5568", "mu_min: 1.2");
        assert_eq!(e, "car.yaml: tyres.fiala.mu_min: 1.2 exceeds mu_max (0.9835); friction falls with slip");
        let e = broken("[0.1, 58000]", "[0.1, 28000]");
        assert!(e.starts_with("car.yaml: tyres.fiala.vertical_map[2]: [0.1, 28000.0] must exceed"), "{e}");
        let e = broken("rim_radius: 0.20955", "rim_radius: 0.5");
        assert_eq!(e, "car.yaml: tyres.tmeasy.rim_radius: 0.5 must be less than the radius (0.4699)");
        let e = broken("fxs: [3954.57021, 7252.54288]", "fxs: [3954.57021, 17252.54288]");
        assert!(e.starts_with("car.yaml: tyres.tmeasy.fxs[1]: 17252.54288"), "{e}");
        let e = broken("sxs: [0.66667, 0.66667]", "sxs: [0.1, 0.66667]");
        assert!(e.starts_with("car.yaml: tyres.tmeasy.sxs[0]: 0.1 must exceed the slip"), "{e}");
        let e = broken("tangential_stiffness: 4.0e6", "tangential_stiffness: 0");
        assert_eq!(e, "car.yaml: tyres.rigid.tangential_stiffness: 0 must be a positive number");
        let e = broken(
            "relaxation_length: 0.1\n",
            "relaxation_length: 0.1\n    dilation: {step: 0.005, reach: 0.06}\n",
        );
        assert!(e.starts_with("car.yaml: tyres.rigid.dilation: given, but contact is not facets"), "{e}");
        let facets = "relaxation_length: 0.1\n    contact: facets\n    dilation: {step: 0.005, reach: 0.6}\n";
        let e = broken("relaxation_length: 0.1\n", facets);
        assert_eq!(e, "car.yaml: tyres.rigid.dilation.reach: 0.6 is more than the tyre's radius, 0.467");
    }

    #[test]
    fn hardpoints_that_lock_are_refused_with_the_travel_at_which_they_do() {
        let e = broken(
            "upper_arm_front: [-0.048006, 0.44577, 0.244602]",
            "upper_arm_front: [-0.048006, 0.70, 0.244602]",
        );
        assert!(e.contains("axles[0].suspension.linkage") && e.contains("travel"), "{e}");
    }
}
