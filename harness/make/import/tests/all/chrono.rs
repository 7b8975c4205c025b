//! Sets of Project Chrono with values of our own.

use super::{AXLE, RACK, SPINDLE, SPRINGS, set, wishbones};
use vb_import::{Imported, Kind, Options, import};
use vb_vehicle::powertrain::{Differential, Engine};
use vb_vehicle::suspension::{Linkage, Part, SteeringGear};
use vb_vehicle::{TyreSpec, VehicleSpec};

fn convert(front: &str, rear: &str, steering: &str) -> Imported {
    let dir = tempfile::tempdir().unwrap();
    import(&set(dir.path(), front, rear, steering), &Options::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn rear(template: &str, fields: &str) -> String {
    format!(r#"{{"Name": "r", "Type": "Suspension", "Template": "{template}", {SPINDLE}, {AXLE}, {fields}}}"#)
}

const TUBE: &str = r#""Axle Tube": {"Mass": 60, "COM": [0, 0, 0], "Inertia": [10, 0.3, 10], "Radius": 0.05"#;
const COILS: &str = r#""Spring": {"Location Chassis": [0, 0.5, 0.4], "Location Axle": [0, 0.5, 0.05], "Spring Coefficient": 50000, "Free Length": 0.42},
    "Shock": {"Location Chassis": [0.1, 0.45, 0.4], "Location Axle": [0.1, 0.5, 0.05], "Damping Coefficient": 4000,
              "Degressivity Compression": 3, "Degressivity Expansion": 1}"#;
const KNUCKLE: &str = r#""Knuckle": {"Mass": 9, "COM": [0, 0.68, 0], "Location Lower": [0, 0.69, -0.1], "Location Upper": [0, 0.67, 0.1]"#;

#[test]
fn values_of_a_set_stand_in_the_vehicle() {
    let i = convert(&wishbones(), &wishbones(), RACK);
    let s = &i.spec;
    assert_eq!((s.name.as_str(), s.axles.len(), s.scale), ("own_car", 2, 1.0));
    // The origin moves to the middle of the wheels.
    assert!((s.axles[0].position[0] - 1.25).abs() < 1e-9 && (s.axles[1].position[0] + 1.25).abs() < 1e-9);
    let Linkage::DoubleWishbone(l) = &s.axles[0].suspension.linkage else {
        panic!("{:?}", s.axles[0].suspension.linkage)
    };
    assert_eq!(l.lower_ball_joint, [0.0, 0.7, -0.12]);
    // Spindle 8, upright 12, half of the arms 6, wheel 10, tyre 12.
    assert!((s.axles[0].unsprung_mass - 48.0).abs() < 1e-9);
    // Chassis 1200, link of the steering 5, half of four arms 4 × (2 + 4).
    assert!((s.chassis.mass - 1229.0).abs() < 1e-9, "{}", s.chassis.mass);
    // Spindle 0.2, shaft 0.3, wheel 0.5, tyre 1.
    assert!((s.axles[0].spin_inertia - 2.0).abs() < 1e-9);
    assert_eq!(s.axles.iter().map(|a| a.driven).collect::<Vec<_>>(), [false, true]);
    let Some(SteeringGear::RackAndPinion { travel }) = s.axles[0].steering else { panic!() };
    assert!((travel.abs() - 0.1 * 40.0_f64.to_radians()).abs() < 1e-8);
    assert_eq!(s.chassis.friction, 0.5);
    assert_eq!(s.chassis.hull.len(), 1);
    let line = &s.powertrain.driveline;
    assert_eq!(
        (line.axles[0].final_drive, line.axles[0].differential),
        (0.25, Differential::Clutch { torque: 100.0 })
    );
    let Engine::Map { full_throttle, .. } = &s.powertrain.engine else { panic!() };
    assert!(full_throttle[0][0] == 0.0 && full_throttle.last().unwrap()[1] < 0.0, "{full_throttle:?}");
    assert!(matches!(s.tyre, TyreSpec::Tmeasy(_)));
    // What has no counterpart is listed with its file and place.
    let listed = |what: &str| i.notes.of(Kind::NoCounterpart).any(|n| n.text.contains(what));
    assert!(
        listed("own/front.json: Spindle: Radius, Width")
            && listed("own/steering.json: Steering Link: Inertia, Length, Radius")
    );
    assert!(i.file().contains("Values of the source without a counterpart"));
    assert_eq!(<VehicleSpec as vb_files::Document>::parse(&i.file(), "x").unwrap().axles.len(), 2);
}

#[test]
fn every_template_of_independent_suspensions_has_its_linkage() {
    let upright = r#""Upright": {"Mass": 12, "COM": [0, 0.7, 0]}"#;
    let tie = r#""Tierod": {"Location Chassis": [-0.15, 0.32, 0], "Location Upright": [-0.15, 0.67, 0]}"#;
    let multilink = rear(
        "MultiLink",
        &format!(
            r#"{upright}, {tie},
            "Upper Arm": {{"Mass": 3, "Location Chassis Front": [0.1, 0.35, 0.2], "Location Chassis Back": [-0.1, 0.35, 0.2], "Location Upright": [0, 0.65, 0.2]}},
            "Lateral": {{"Mass": 2, "Location Chassis": [0, 0.3, -0.1], "Location Upright": [0, 0.7, -0.12]}},
            "Trailing Link": {{"Mass": 3, "Location Chassis": [0.6, 0.6, -0.05], "Location Upright": [0.05, 0.68, -0.12]}},
            "Spring": {{"Location Chassis": [0.2, 0.6, 0.35], "Location Link": [0.2, 0.66, -0.1], "Spring Coefficient": 110000, "Free Length": 0.53}},
            "Shock": {{"Location Chassis": [0.2, 0.6, 0.4], "Location Link": [0.15, 0.66, -0.11], "Damping Coefficient": 8000}}"#
        ),
    );
    let strut = rear(
        "MacPhersonStrut",
        &format!(
            r#"{upright}, {tie}, "Strut": {{"Mass": 4, "Inertia": [1, 1, 1], "Radius": 0.05}},
            "Control Arm": {{"Mass": 4, "Location Chassis Front": [0.2, 0.3, -0.1], "Location Chassis Back": [-0.2, 0.3, -0.1], "Location Upright": [0, 0.7, -0.12]}},
            "Spring": {{"Location Chassis": [-0.02, 0.58, 0.55], "Location Upright": [0, 0.65, 0.1], "Spring Coefficient": 30000, "Free Length": 0.6}},
            "Shock": {{"Location Chassis": [-0.02, 0.58, 0.55], "Location Upright": [0, 0.65, 0.1], "Damping Coefficient": 2500}}"#
        ),
    );
    let single = rear(
        "SingleWishbone",
        &format!(
            r#"{upright}, {tie}, "Control Arm": {{"Mass": 4, "Location Chassis": [0, 0.3, -0.05], "Location Upright": [0, 0.7, -0.05]}},
            "Shock": {{"Location Chassis": [0, 0.5, 0.35], "Location Arm": [0, 0.6, -0.05], "Spring Coefficient": 60000, "Free Length": 0.48, "Damping Coefficient": 5000}}"#
        ),
    );
    let reduced = wishbones()
        .replace("\"DoubleWishbone\"", "\"DoubleWishboneReduced\"")
        .replace("Location Arm", "Location Upright");
    let trailing = rear(
        "ThreeLinkIRS",
        &format!(
            r#"{SPRINGS}, "Trailing Arm": {{"Mass": 8, "Location Chassis": [0.8, 0.6, 0.05], "Location Spindle": [0, 0.7, 0]}},
            "Upper Link": {{"Mass": 1, "Location Chassis": [-0.05, 0.2, 0.12], "Location Arm": [-0.05, 0.68, 0.1], "Universal Joint Axis": [1, 0, 0]}},
            "Lower Link": {{"Mass": 1, "Location Chassis": [-0.05, 0.2, -0.1], "Location Arm": [-0.05, 0.68, -0.1], "Universal Joint Axis": [1, 0, 0]}}"#
        ),
    );
    let semi = rear(
        "SemiTrailingArm",
        &format!(
            r#"{SPRINGS}, "Trailing Arm": {{"Mass": 8, "Location Chassis Outer": [0.5, 0.65, 0], "Location Chassis Inner": [0.4, 0.3, 0], "Location Spindle": [0, 0.7, 0]}}"#
        ),
    );
    let rigid =
        format!(r#"{{"Name": "r", "Type": "Suspension", "Template": "RigidSuspension", {SPINDLE}, {AXLE}}}"#);
    for (text, kind, part) in [
        (&multilink, "five rods", Some(Part::Upright)),
        (&strut, "five rods", Some(Part::Upright)),
        (&single, "single wishbone", Some(Part::Arm)),
        (&reduced, "double wishbone", Some(Part::Upright)),
        (&trailing, "five rods", Some(Part::Upright)),
        (&semi, "torsion arm", Some(Part::Arm)),
        (&rigid, "rigid", None),
    ] {
        let i = convert(&wishbones(), text, RACK);
        let s = &i.spec.axles[1].suspension;
        assert_eq!(s.linkage.kind(), kind, "{text}");
        assert_eq!(s.struts.first().map(|s| s.part), part, "{text}");
    }
    // Steered ones.
    for text in [&multilink, &strut, &single] {
        assert!(convert(text, &wishbones(), RACK).spec.axles[0].steering.is_some());
    }
}

#[test]
fn every_template_of_beams_has_its_linkage() {
    let link = |name: &str, z: f64| {
        format!(
            r#""{name}": {{"Mass": 3, "Location Chassis": [0.7, 0.4, {z}], "Location Axle": [0.05, 0.45, {z}]}}"#
        )
    };
    let three = format!(
        r#"{TUBE}}}, {COILS}, "Triangular Link": {{"Mass": 6, "Location Chassis": [-0.6, 0.3, 0.15], "Location Axle": [0, 0, 0.2]}}, {}"#,
        link("Longitudinal Link", -0.08)
    );
    let leaf = format!(r#"{TUBE}}}, {COILS}"#);
    let sae = format!(
        r#"{TUBE}}}, "Auxiliary Spring": {{"Location Chassis": [0, 0.5, 0.3], "Location Axle": [0, 0.5, 0.05], "Spring Coefficient": 0, "Free Length": 0.2}},
        "Shock": {{"Location Chassis": [0.1, 0.45, 0.4], "Location Axle": [0.1, 0.5, 0.05], "Damping Coefficient": 4000}},
        "Leafspring": {{"Location Front Hanger": [0.6, 0.5, 0.1], "Location Clamp A": [0.05, 0.5, 0.07], "Location Clamp B": [-0.05, 0.5, 0.07],
        "Vertical Stiffness": 60000, "Vertical Preload Force": 3000, "Frontleaf": {{"Mass": 3}}, "Rearleaf": {{"Mass": 3}}}}"#
    );
    let pipe = format!(
        r#"{TUBE}, "Location Connector Chassis": [0.9, 0, 0]}}, {COILS},
        "Panhard Rod": {{"Mass": 4, "Location Connector Chassis": [-0.1, 0.5, 0], "Location Connector Axle": [-0.1, -0.5, 0]}}"#
    );
    let panhard = format!(
        r#"{TUBE}}}, {COILS}, "Panhard Rod": {{"Mass": 4, "Location Chassis": [-0.1, 0.5, 0], "Location Axle": [-0.1, -0.5, 0]}},
        "Anti Roll Bar": {{"Mass": 5, "Location Chassis": [0.4, 0.4, 0], "Location Axle": [0, 0.4, 0], "Rotational Stiffness": 1000, "Rotational Damping": 10}}"#
    );
    let dion = format!(r#"{TUBE}, "Location Connector": [0.9, 0, 0]}}, {COILS}"#);
    for (template, fields, kind) in [
        ("SolidThreeLinkAxle", &three, "solid axle on rods"),
        ("LeafspringAxle", &leaf, "solid axle on leaf springs"),
        ("SAELeafspringAxle", &sae, "solid axle on leaf springs"),
        ("PushPipeAxle", &pipe, "solid axle on rods"),
        ("RigidPanhardAxle", &panhard, "solid axle on rods"),
        ("DeDionAxle", &dion, "solid axle on rods"),
    ] {
        let i = convert(&wishbones(), &rear(template, fields), RACK);
        assert_eq!(i.spec.axles[1].suspension.linkage.kind(), kind, "{template}");
    }
    let pinned = rear(
        "RigidPinnedAxle",
        r#""Tube": {"Mass": 60, "COM": [0, 0, 0], "Inertia": [10, 0.3, 10], "Radius": 0.05, "Pin Location": [0, 0, 0.1]}"#,
    );
    assert_eq!(convert(&wishbones(), &pinned, RACK).spec.axles[1].suspension.linkage.kind(), "pivoting axle");

    // Steered beams: a toe bar with a drag link from a rotary arm, and bell cranks.
    let arm = r#"{"Name": "s", "Type": "Steering", "Template": "RotaryArm", "Pitman Arm": {"Mass": 4, "Inertia": [1, 1, 1], "Radius": 0.03,
        "Axis of Rotation": [0, 1, 0], "Point of Rotation": [0.6, 0.5, 0.4], "Point to Draglink": [0.6, 0.5, 0.2], "Maximum Angle (deg)": 6}}"#;
    let toe = format!(
        r#"{leaf}, {KNUCKLE}, "Location Draglink": [0, 0.5, 0.2]}}, "Tierod": {{"Mass": 4, "Location Knuckle": [-0.15, 0.6, 0.1]}},
        "Draglink": {{"Mass": 4, "Location Chassis": [0.6, 0.5, 0.2]}}"#
    );
    let i = convert(&rear("ToeBarLeafspringAxle", &toe), &wishbones(), arm);
    assert!(i.spec.axles[0].suspension.linkage.knuckles().is_some());
    let crank = r#"{"Name": "s", "Type": "Steering", "Template": "RotaryArm", "Pitman Arm": {"Mass": 4, "Inertia": [1, 1, 1], "Radius": 0.03,
        "Axis of Rotation": [0, 0, 1], "Point of Rotation": [0.7, -0.25, 0.15], "Point to Draglink": [0.7, 0, 0.15], "Maximum Angle (deg)": 6}}"#;
    let bell = format!(
        r#"{three}, {KNUCKLE}, "Location Tierod": [-0.2, 0.62, 0.15]}}, "Tierod": {{"Mass": 4}},
        "Bellcrank": {{"Mass": 5, "Inertia": [1, 1, 1], "Location Axle": [0, 0, 0.15], "Location Tierod": [-0.22, 0.04, 0.15]}},
        "Draglink": {{"Mass": 4, "Location Steering": [0.7, 0, 0.15], "Location Bellcrank": [0.05, 0.22, 0.15]}}"#
    );
    convert(&rear("SolidBellcrankThreeLinkAxle", &bell), &wishbones(), crank);
    let solid = format!(
        r#"{TUBE}}}, {COILS}, {}, {}, {KNUCKLE}}}, "Tierod": {{"Mass": 4, "Location Knuckle": [-0.2, 0.62, 0.15]}},
        "Bell Crank": {{"Mass": 5, "Inertia": [1, 1, 1], "Location Axle": [0, 0, 0.15], "Location Tierod": [-0.22, 0.0, 0.15]}},
        "Draglink": {{"Mass": 4, "Location Chassis": [0.7, 0, 0.15], "Location Bell Crank": [0.05, 0.22, 0.15]}}"#,
        link("Lower Link", -0.1),
        r#""Upper Link": {"Mass": 3, "Location Chassis": [0.5, 0.2, 0.15], "Location Axle": [0.0, 0.45, 0.15]}"#
    );
    convert(&rear("SolidAxle", &solid), &wishbones(), crank);
}

#[test]
fn engines_transmissions_drivelines_and_tyres_of_all_templates_are_read() {
    let dir = tempfile::tempdir().unwrap();
    let car = set(dir.path(), &wishbones(), &wishbones(), RACK);
    let own = dir.path().join("own");
    let file = |name: &str, text: &str| {
        let path = own.join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let simple = file(
        "e1.json",
        r#"{"Type": "Engine", "Template": "EngineSimple", "Maximum Engine Torque": 200, "Maximum Engine Power": 60000, "Maximum Engine Speed": 500}"#,
    );
    let shafts = file(
        "e2.json",
        r#"{"Type": "Engine", "Template": "EngineShafts", "Motor Block Inertia": 10, "Motorshaft Inertia": 0.8,
        "Torque Map": [[-100, 150], [1000, 250], [4000, 240], [5000, -100]], "Losses Map": [[0, 0], [1000, -10], [5000, -30]]}"#,
    );
    let automatic = file(
        "t1.json",
        r#"{"Type": "Transmission", "Template": "AutomaticTransmissionShafts", "Transmission Block Inertia": 10, "Input Shaft Inertia": 0.3,
        "Motorshaft Inertia": 0.4, "Driveshaft Inertia": 0.5,
        "Torque Converter": {"Capacity Factor Map": [[0, 12], [0.8, 14], [1, 30]], "Torque Ratio Map": [[0, 2], [0.8, 1.1], [1, 1]]},
        "Gear Box": {"Forward Gear Ratios": [0.3, 0.6, 1.0], "Reverse Gear Ratio": -0.2, "Upshift RPM": 3000, "Downshift RPM": 1200, "Shift Latency": 0.5}}"#,
    );
    let variable = file(
        "t2.json",
        r#"{"Type": "Transmission", "Template": "AutomaticTransmissionSimpleCVT", "Gear Box": {"Efficiency": 0.9,
        "Minimum Gear Ratio": 0.2, "Maximum Gear Ratio": 1.2, "Driveshaft Speed Begin": 20, "Driveshaft Speed End": 200}}"#,
    );
    let manual = file(
        "t3.json",
        r#"{"Type": "Transmission", "Template": "ManualTransmissionShafts", "Transmission Block Inertia": 10, "Input Shaft Inertia": 0.3,
        "Motorshaft Inertia": 0.4, "Driveshaft Inertia": 0.5, "Gear Box": {"Forward Gear Ratios": [0.3, 0.6, 1.0], "Reverse Gear Ratio": -0.2}}"#,
    );
    let of = |engine: &std::path::Path, transmission: &std::path::Path| {
        let options = Options {
            engine: Some(engine.to_owned()),
            transmission: Some(transmission.to_owned()),
            ..Options::default()
        };
        import(&car, &options).unwrap_or_else(|e| panic!("{e}")).spec.powertrain
    };
    let p = of(&shafts, &automatic);
    assert!((p.engine.inertia() - 1.2).abs() < 1e-12 && p.converter.is_some() && p.gearbox.latency == 0.5);
    // The torque map with its losses at 1000 rpm: 250 - 10.
    assert!((p.engine.torque(1000.0 * std::f64::consts::PI / 30.0, 1.0) - 240.0).abs() < 1e-6);
    assert!((p.driveline.shaft_inertia - 0.9).abs() < 1e-12);
    let p = of(&simple, &variable);
    assert_eq!(p.gearbox.ratios.len(), 6);
    assert!((p.gearbox.ratios[5] - 1.2).abs() < 1e-9);
    assert_eq!(of(&simple, &manual).gearbox.shift_time, 0.3);

    for (line, axles, centre) in [
        (
            r#"{"Type": "Driveline", "Template": "ShaftsDriveline4WD", "Shaft Inertia": {"Driveshaft": 0.5, "Front Driveshaft": 0.4, "Rear Driveshaft": 0.3,
            "Central Differential Box": 0.6, "Front Differential Box": 0.6, "Rear Differential Box": 0.6},
            "Gear Ratio": {"Front Conical Gear": 0.2, "Rear Conical Gear": 0.25, "Central Differential": -1.0}, "Central Differential Locking Limit": 50}"#,
            [0.2, 0.25],
            Differential::Clutch { torque: 50.0 },
        ),
        (
            r#"{"Type": "Driveline", "Template": "SimpleDriveline", "Front Torque Fraction": 0.4, "Front Differential Max Bias": 2,
            "Rear Differential Max Bias": 3, "Front Conical Gear Ratio": 0.3, "Rear Conical Gear Ratio": 0.3}"#,
            [0.3, 0.3],
            Differential::Open {},
        ),
        (
            r#"{"Type": "Driveline", "Template": "SimpleDrivelineXWD", "Differential Max Bias": 2}"#,
            [1.0, 1.0],
            Differential::Open {},
        ),
    ] {
        file("driveline.json", line);
        let text = std::fs::read_to_string(&car)
            .unwrap()
            .replace("\"Suspension Indexes\": [1]", "\"Suspension Indexes\": [0, 1]");
        std::fs::write(&car, text).unwrap();
        let line =
            import(&car, &Options::default()).unwrap_or_else(|e| panic!("{e}")).spec.powertrain.driveline;
        assert_eq!(line.axles.iter().map(|a| a.final_drive).collect::<Vec<_>>(), axles);
        assert_eq!(line.centre, centre);
    }

    file(
        "t.tir",
        "[UNITS]\nLENGTH = 'meter'\n[DIM]\nUNLOADED_RADIUS = 0.36\nWIDTH = 0.24\nFNOMIN = 4000\nVERTICAL_STIFFNESS = 220000\nVERTICAL_DAMPING = 500\n\
        PKX1 = 20\nPKY1 = -14\nPKY2 = 2\nPDX1 = 1.1\nPDY1 = 1.0\n",
    );
    for (text, model) in [
        (
            r#"{"Type": "Tire", "Template": "RigidTire", "Radius": 0.35, "Width": 0.2, "Mass": 12, "Inertia": [1, 2, 1], "Contact Material": {"Coefficient of Friction": 0.9}}"#,
            "rigid",
        ),
        (
            r#"{"Type": "Tire", "Template": "FialaTire", "Mass": 12, "Inertia": [1, 2, 1], "Coefficient of Friction": 0.8, "Fiala Parameters": {
            "Unloaded Radius": 0.35, "Width": 0.2, "Vertical Stiffness": 200000, "Vertical Damping": 500, "Rolling Resistance": 0.01, "CSLIP": 90000,
            "CALPHA": 40000, "UMIN": 0.6, "UMAX": 0.9, "X Relaxation Length": 0.2, "Y Relaxation Length": 0.4}}"#,
            "fiala",
        ),
        (
            r#"{"Type": "Tire", "Template": "Pac02Tire", "Mass": 12, "Inertia": [1, 2, 1], "TIR Specification File": "own/t.tir", "Coefficient of Friction": 0.8}"#,
            "brush",
        ),
        (
            r#"{"Type": "Tire", "Template": "TMeasyTire", "Design": {"Unloaded Radius [m]": 0.35, "Mass [kg]": 12, "Inertia [kg.m2]": [1, 2, 1],
            "Width [m]": 0.2, "Rim Radius [m]": 0.2}, "Coefficient of Friction": 0.8, "Rolling Resistance Coefficients": [0.01, 0.012], "Parameters": {
            "Tire Load": {"Nominal Vertical Force [N]": 4000, "Maximum Vertical Force [N]": 14000},
            "Tire Stiffness": {"Longitudinal [N/m]": 160000, "Lateral [N/m]": 120000, "Vertical [N/m]": [180000, 190000]},
            "Tire Damping": {"Longitudinal [Ns/m]": 500, "Lateral [Ns/m]": 500, "Vertical [Ns/m]": 500}, "Dynamic Radius Weighting Coefficients": [0.4, 0.8],
            "Longitudinal": {"Initial Slopes dFx/dsx [N]": [80000, 150000], "Maximum Fx Load [N]": [4200, 8000], "Sliding Fx Load [N]": [3800, 7200],
              "Slip sx at Maximum Fx": [0.12, 0.13], "Slip sx where sliding begins": [0.5, 0.5]},
            "Lateral": {"Initial Slopes dFy/dsy [N]": [60000, 110000], "Maximum Fy Load [N]": [4000, 7800], "Sliding Fy Load [N]": [3700, 7000],
              "Slip sy at Maximum Fy": [0.2, 0.22], "Slip sy where sliding begins": [0.6, 0.6]},
            "Aligning": {"Normalized Trail at Zero Slip sy": [0.17, 0.18], "Slip sy where Trail Changes Sign": [0.2, 0.2], "Slip sy where Trail Tends to Zero": [0.5, 0.5]}}}"#,
            "tmeasy",
        ),
    ] {
        let tyre = file("other.json", text);
        let options = Options { tyres: vec![tyre], ..Options::default() };
        let i = import(&car, &options).unwrap_or_else(|e| panic!("{model}: {e}"));
        assert_eq!(i.spec.tyre.model(), model);
        if let TyreSpec::Tmeasy(t) = &i.spec.tyre {
            // a1² = 2·180² − 190², a2 = (190² − 180²) / (4·4 kN).
            assert!(
                (t.vertical_stiffness - (2.0 * 180e3_f64 * 180e3 - 190e3_f64 * 190e3).sqrt()).abs() < 1.0
            );
            assert_eq!(t.carcass_stiffness, [160e3, 120e3]);
        }
    }
}
