//! Variants of sets: key names and file types of Chrono's older versions, files that the vehicle's file names, dual wheels.

use super::{AXLE, RACK, SPINDLE, set, wishbones};
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use vb_import::{Imported, Kind, Options, import};
use vb_vehicle::powertrain::Engine;
use vb_vehicle::suspension::{KnuckleDrive, Linkage, SteeringGear};
use vb_vehicle::{GRAVITY, TyreSpec};

/// The car of the small set in a folder of its own.
struct Car {
    folder: TempDir,
    car: PathBuf,
}

impl Car {
    fn new(front: &str, rear: &str, steering: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let car = set(folder.path(), front, rear, steering);
        Self { folder, car }
    }

    fn plain() -> Self {
        Self::new(&wishbones(), &wishbones(), RACK)
    }

    fn own(&self, name: &str) -> PathBuf {
        self.folder.path().join("own").join(name)
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        std::fs::write(self.own(name), text).unwrap();
        self.own(name)
    }

    fn remove(&self, names: &[&str]) {
        names.iter().for_each(|n| std::fs::remove_file(self.own(n)).unwrap());
    }

    fn replace(&self, name: &str, from: &str, to: &str) {
        let text = std::fs::read_to_string(self.own(name)).unwrap();
        assert!(text.contains(from), "{name}: {from}");
        std::fs::write(self.own(name), text.replace(from, to)).unwrap();
    }

    fn import(&self) -> Imported {
        self.with(&Options::default())
    }

    fn with(&self, options: &Options) -> Imported {
        import(&self.car, options).unwrap_or_else(|e| panic!("{e}"))
    }

    fn tyre(&self, text: &str) -> Imported {
        let tyre = self.write("other.json", text);
        self.with(&Options { tyres: vec![tyre], ..Options::default() })
    }
}

fn says(i: &Imported, kind: Kind, what: &str) -> bool {
    i.notes.of(kind).any(|n| n.text.contains(what))
}

fn near(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-6 * b.abs().max(1.0), "{a} {b}");
}

#[test]
fn powertrains_of_chrono_8_are_engine_and_transmission() {
    let of = |text: &str| {
        let car = Car::plain();
        car.remove(&["engine.json", "transmission.json"]);
        car.write("powertrain.json", text);
        car.import()
    };
    let p = of(r#"{"Name": "p", "Type": "Powertrain", "Template": "SimplePowertrain", "Forward Gear Ratio": 0.3, "Reverse Gear Ratio": -0.2,
        "Maximum Engine Torque": 300, "Maximum Engine Speed": 600}"#)
    .spec
    .powertrain;
    // The torque falls in a straight line to none at the greatest speed.
    near(p.engine.torque(0.0, 1.0), 300.0);
    near(p.engine.torque(300.0, 1.0), 150.0);
    assert_eq!((p.gearbox.ratios, p.gearbox.reverse), (vec![0.3], Some(-0.2)));

    let cvt = r#"{"Name": "p", "Type": "Powertrain", "Template": "SimpleCVTPowertrain", "Forward Gear Ratio": 0.3, "Reverse Gear Ratio": -0.3,
        "Maximum Engine Torque": 300, "Maximum Engine Power": 60000, "Maximum Engine Speed": 700}"#;
    let Engine::Simple { torque, power, max_speed, .. } = of(cvt).spec.powertrain.engine else { panic!() };
    assert_eq!([torque, power, max_speed], [300.0, 60e3, 700.0]);
    let i = of(&cvt.replace(", \"Maximum Engine Speed\": 700", ""));
    assert!(says(&i, Kind::Assumed, "a maximum engine speed of 2000 rad/s"));

    let i = of(
        r#"{"Name": "p", "Type": "Powertrain", "Template": "SimpleMapPowertrain", "Engine": {"Maximal Engine Speed RPM": 5000,
        "Map Full Throttle": [[-100, 100], [1000, 180], [5000, 150]], "Map Zero Throttle": [[0, 0], [5000, -40]]},
        "Transmission": {"Reverse Gear Ratio": -0.25, "Forward Gear Ratios": [0.3, 0.6], "Shift Points Map RPM": [[1000, 4000], [1500, 4100], [1600, 4200]]}}"#,
    );
    let p = &i.spec.powertrain;
    near(p.engine.torque(1000.0 * std::f64::consts::PI / 30.0, 1.0), 180.0);
    assert_eq!((p.gearbox.ratios.len(), p.gearbox.shift_up.len()), (2, 2));
    assert!(says(&i, Kind::NoCounterpart, "the pairs after the first 2"));

    let p = of(r#"{"Name": "p", "Type": "Powertrain", "Template": "ShaftsPowertrain", "Engine": {"Motor Block Inertia": 10, "Crankshaft Inertia": 1.1,
        "Torque Map": [[-100, 150], [1000, 250], [5000, -100]], "Losses Map": [[0, 0], [1000, -10], [5000, -30]]},
        "Transmission": {"Input Shaft Inertia": 0.3, "Output Shaft Inertia": 0.5, "Reverse Gear Ratio": -0.1, "Forward Gear Ratios": [0.2, 0.4],
        "Upshift RPM": 2500, "Downshift RPM": 1200, "Shift Latency": 0.5},
        "Torque Converter": {"Capacity Factor Map": [[0, 15], [1, 35]], "Torque Ratio Map": [[0, 2], [1, 1]]}}"#)
    .spec
    .powertrain;
    near(p.engine.torque(1000.0 * std::f64::consts::PI / 30.0, 1.0), 240.0);
    near(p.engine.inertia(), 1.1);
    near(p.driveline.shaft_inertia, 0.4 + 0.5);
    assert!(p.converter.is_some() && p.gearbox.latency == 0.5);

    let car = Car::plain();
    car.replace("transmission.json", "[1000, 4000], [1500, 4000], [1500, 4000]", "[1000, 4000]");
    let e = import(&car.car, &Options::default()).unwrap_err().to_string();
    assert!(e.contains("Shift Points Map RPM: 1 pairs for 3 gears"), "{e}");
}

#[test]
fn files_that_the_vehicle_names_are_used() {
    let car = Car::plain();
    let second = |from: &str, to: &str, a: &str, b: &str| {
        let text = std::fs::read_to_string(car.own(from)).unwrap();
        car.write(to, &text.replace(a, b));
    };
    second("engine.json", "z_engine.json", "[3000, 220]", "[3000, 230]");
    second("transmission.json", "z_transmission.json", "[0.3, 0.6, 1.0]", "[0.31, 0.6, 1.0]");
    second("tyre.json", "z_tyre.json", "0.35", "0.37");
    car.replace(
        "car.json",
        "\"Type\": \"Vehicle\"",
        r#""Powertrain": {"Engine Input File": "own/z_engine.json", "Transmission Input File": "own/z_transmission.json"}, "Type": "Vehicle""#,
    );
    car.replace(
        "car.json",
        "\"Suspension Location\"",
        "\"Tire Input File\": \"own/z_tyre.json\", \"Suspension Location\"",
    );
    let check = |i: &Imported, name: &str| {
        let p = &i.spec.powertrain;
        near(p.engine.torque(100.0 * std::f64::consts::PI, 1.0), 230.0);
        assert_eq!((p.gearbox.ratios[0], i.spec.tyre.radius(), i.spec.name.as_str()), (0.31, 0.37, name));
        assert!(!i.notes.of(Kind::Chosen).any(|n| n.text.contains("does not name")));
    };
    check(&car.import(), "own_car");
    // What the user gives counts.
    let engine = car.own("engine.json");
    let i = car.with(&Options { engine: Some(engine), ..Options::default() });
    near(i.spec.powertrain.engine.torque(100.0 * std::f64::consts::PI, 1.0), 220.0);
    // SynChrono's file names the vehicle's.
    let whole = car.write(
        "whole.json",
        r#"{"Name": "w", "Type": "Vehicle", "Template": "WheeledVehicle", "Vehicle": {"Input File": "own/car.json", "Chassis Visualization Type": "Mesh"},
        "Powertrain": {"Input File": "own/powertrain.json"}, "Tire": {"Input File": "own/z_tyre.json"}}"#,
    );
    car.write(
        "powertrain.json",
        r#"{"Type": "Powertrain", "Template": "SimplePowertrain", "Forward Gear Ratio": 0.3, "Reverse Gear Ratio": -0.2,
        "Maximum Engine Torque": 300, "Maximum Engine Speed": 600}"#,
    );
    let i = import(&whole, &Options::default()).unwrap_or_else(|e| panic!("{e}"));
    near(i.spec.powertrain.engine.torque(0.0, 1.0), 300.0);
    assert_eq!((i.spec.axles.len(), i.spec.powertrain.gearbox.ratios.as_slice()), (2, &[0.3][..]));
}

#[test]
fn angles_of_steering_have_three_names() {
    for key in ["Maximum Angle", "Maximum Angle Degrees", "Maximum Angle (deg)"] {
        let car = Car::new(&wishbones(), &wishbones(), &RACK.replace("Maximum Angle (deg)", key));
        let Some(SteeringGear::RackAndPinion { travel }) = car.import().spec.axles[0].steering else {
            panic!()
        };
        near(travel.abs(), 0.1 * 40.0_f64.to_radians());
    }
}

#[test]
fn twin_wheels_are_one_with_twice_the_forces() {
    let car = Car::plain();
    let one = car.import().spec;
    let text = std::fs::read_to_string(&car.car).unwrap();
    let (front, rear) = text.split_at(text.rfind("\"Left Wheel").unwrap());
    let rear = rear.replace(
        r#""Left Wheel Input File": "own/wheel.json", "Right Wheel Input File": "own/wheel.json""#,
        r#""Wheel Separation": 0.3, "Left Inside Wheel Input File": "own/wheel.json", "Right Inside Wheel Input File": "own/wheel.json",
        "Left Outside Wheel Input File": "own/wheel.json", "Right Outside Wheel Input File": "own/wheel.json""#,
    );
    std::fs::write(&car.car, format!("{front}{rear}")).unwrap();
    let i = car.import();
    let rear = &i.spec.axles[1];
    // A wheel of 10 kg and a tyre of 12 kg more, and their 0.5 and 1 kg m².
    near(rear.unsprung_mass, one.axles[1].unsprung_mass + 22.0);
    near(rear.spin_inertia, one.axles[1].spin_inertia + 1.5);
    let (TyreSpec::Tmeasy(t), TyreSpec::Tmeasy(u)) = (i.spec.tyre_of(rear), &one.tyre) else { panic!() };
    near(t.width, u.width + 0.3);
    for (a, b) in [
        (t.pn, u.pn),
        (t.vertical_stiffness, u.vertical_stiffness),
        (t.fym[1], u.fym[1]),
        (t.dfx0[0], u.dfx0[0]),
    ] {
        near(a, 2.0 * b);
    }
    assert_eq!(t.sym, u.sym);
    assert!(says(&i, Kind::Approximated, "dual wheels") && !says(&i, Kind::NoCounterpart, "Outside"));
}

#[test]
fn a_simple_driveline_without_torque_at_an_end_drives_the_other() {
    for (front, driven) in [("0", [false, true]), ("1", [true, false]), ("0.4", [true, true])] {
        let car = Car::plain();
        car.replace("car.json", "\"Suspension Indexes\": [1]", "\"Suspension Indexes\": [0, 1]");
        car.write(
            "driveline.json",
            &format!(
                r#"{{"Type": "Driveline", "Template": "SimpleDriveline", "Front Torque Fraction": {front}, "Front Differential Max Bias": 2,
                "Rear Differential Max Bias": 3, "Front Conical Gear Ratio": 0.3, "Rear Conical Gear Ratio": 0.3}}"#
            ),
        );
        let s = car.import().spec;
        assert_eq!(s.axles.iter().map(|a| a.driven).collect::<Vec<_>>(), driven);
        assert_eq!(s.powertrain.driveline.axles.len(), driven.iter().filter(|d| **d).count());
    }
}

#[test]
fn a_steering_index_of_minus_one_steers_nothing() {
    let car = Car::plain();
    car.replace(
        "car.json",
        "\"Suspension Location\": [-2.5",
        "\"Steering Index\": -1, \"Suspension Location\": [-2.5",
    );
    assert!(car.import().spec.axles[1].steering.is_none());
}

fn dion(connector: &str, fields: &str, template: &str) -> String {
    format!(
        r#"{{"Name": "r", "Type": "Suspension", "Template": "{template}", {SPINDLE}, {AXLE}, {fields}
        "Axle Tube": {{"Mass": 60, "COM": [0, 0, 0], "Inertia": [10, 0.3, 10], "Radius": 0.05, "{connector}": [0.9, 0, 0]}},
        "Watt Mechanism": {{"Center Link Mass": 5, "Side Link Mass": 3, "Location Left Link to Chassis": [-0.2, -0.4, 0.2],
        "Location Right Link to Chassis": [-0.2, 0.4, 0.1]}},
        "Spring": {{"Location Chassis": [0, 0.5, 0.4], "Location Axle": [0, 0.5, 0.05], "Spring Coefficient": 50000, "Free Length": 0.42}},
        "Shock": {{"Location Chassis": [0.1, 0.45, 0.4], "Location Axle": [0.1, 0.5, 0.05], "Damping Coefficient": 4000}}}}"#
    )
}

#[test]
fn the_connector_of_a_de_dion_tube_has_two_names_and_its_watt_linkage_a_mass() {
    for key in ["Location Connector", "Location Connector Chassis"] {
        let i = Car::new(&wishbones(), &dion(key, "", "DeDionAxle"), RACK).import();
        let Linkage::SolidAxle(l) = &i.spec.axles[1].suspension.linkage else { panic!() };
        // 60 kg of the tube, the centre link and half of two side links.
        near(l.beam.mass, 60.0 + 5.0 + 3.0);
        assert!(!says(&i, Kind::NoCounterpart, "Center Link Mass"));
    }
}

/// The simulator's drag link turns the left knuckle. One of the right knuckle is mirrored with its steering arm.
#[test]
fn a_drag_link_to_the_right_knuckle_is_mirrored_with_its_arm() {
    let arm = r#"{"Name": "s", "Type": "Steering", "Template": "RotaryArm", "Pitman Arm": {"Mass": 4, "Inertia": [1, 1, 1], "Radius": 0.03,
        "Axis of Rotation": [0, 1, 0], "Point of Rotation": [0.6, -0.5, 0.4], "Point to Draglink": [0.6, -0.5, 0.2], "Maximum Angle (deg)": 6}}"#;
    let fields = r#""Knuckle": {"Mass": 9, "COM": [0, 0.68, 0], "Location Lower": [0, 0.69, -0.1], "Location Upper": [0, 0.67, 0.1],
        "Location Draglink": [0, -0.5, 0.2]}, "Tierod": {"Mass": 4, "Location Knuckle": [-0.15, 0.6, 0.1]},
        "Draglink": {"Mass": 4, "Location Chassis": [0.6, -0.5, 0.2]},"#;
    let i = Car::new(&dion("Location Connector", fields, "ToeBarDeDionAxle"), &wishbones(), arm).import();
    let axle = &i.spec.axles[0];
    let k = axle.suspension.linkage.knuckles().unwrap();
    assert_eq!(k.drag_link_inner, [0.6, 0.5, 0.2]);
    let KnuckleDrive::Toebar { drag_link_outer } = k.by else { panic!() };
    assert_eq!(drag_link_outer, [0.0, 0.5, 0.2]);
    let Some(SteeringGear::RotaryArm { pivot, .. }) = axle.steering else { panic!() };
    assert_eq!(pivot, [0.6, 0.5, 0.4]);
    assert!(says(&i, Kind::Approximated, "mirrored"));
}

#[test]
fn tyres_without_a_mass_have_it_in_the_wheel() {
    let car = Car::plain();
    let i = car.tyre(
        r#"{"Type": "Tire", "Template": "FialaTire", "Fiala Parameters": {"Unloaded Radius": 0.35, "Width": 0.2, "Vertical Stiffness": 200000,
        "CSLIP": 90000, "CALPHA": 40000, "UMIN": 0.6, "UMAX": 0.9, "X Relaxation Length": 0.2, "Y Relaxation Length": 0.4}}"#,
    );
    // Spindle 0.2, shaft 0.3, wheel 0.5.
    near(i.spec.axles[0].spin_inertia, 1.0);
    assert!(says(&i, Kind::Assumed, "in those of the wheel"));
    let i = car.tyre(
        r#"{"Type": "Tire", "Template": "RigidTire", "Radius": 0.35, "Width": 0.2, "Mass": 12, "Inertia": [1, 2, 1], "Coefficient of Friction": 0.7}"#,
    );
    assert!(matches!(i.spec.tyre, TyreSpec::Rigid(ref t) if t.friction == 0.7));
}

/// The weight on a wheel.
fn load(i: &Imported) -> f64 {
    i.spec.total_mass() * GRAVITY / 4.0
}

#[test]
fn a_magic_formula_in_the_tyres_own_file_is_read() {
    let car = Car::plain();
    for template in ["MFTire", "Pac02Tire"] {
        let i = car.tyre(&format!(
            r#"{{"Type": "Tire", "Template": "{template}", "Mass": 12, "Inertia": [1, 2, 1], "Coefficient of Friction": 0.8, "Use Mode": 3,
            "Dimension": {{"Unloaded Radius": 0.36, "Width": 0.24, "Rim Radius": 0.2}},
            "Vertical": {{"Vertical Stiffness": 220000, "Vertical Damping": 500, "Nominal Wheel Load": 4000}}, "Scaling Factors": {{"LKX": 1.5, "LMUX": 1}},
            "Longitudinal Coefficients": {{"PDX1": 1.1, "PDX2": 0, "PKX1": 20, "PKX2": 0, "PKX3": 0}},
            "Lateral Coefficients": {{"PDY1": 0.9, "PDY2": 0, "PKY1": -14, "PKY2": 2}}, "Rolling Coefficients": {{"QSY1": 0.012}}}}"#
        ));
        let TyreSpec::Brush(t) = &i.spec.tyre else { panic!("{:?}", i.spec.tyre) };
        // Without slopes over the load: 1.5 PKX1, and the mean of PDX1 and PDY1.
        near(t.slip_stiffness[0], 30.0);
        near(t.friction, 1.0);
        near(t.rolling_resistance, 0.012);
        assert_eq!((t.radius, t.width, t.vertical_stiffness), (0.36, 0.24, 220e3));
    }
}

#[test]
fn tmsimple_has_its_maximum_where_its_formula_has_it() {
    let text = r#"{"Type": "Tire", "Template": "TMsimpleTire", "Design": {"Unloaded Radius [m]": 0.35, "Mass [kg]": 12, "Inertia [kg.m2]": [1, 2, 1],
        "Width [m]": 0.2, "Rim Radius [m]": 0.2}, "Coefficient of Friction": 0.8, "Rolling Resistance Coefficient": 0.01, "Parameters": {
        "Vertical": {"Nominal Vertical Force [N]": 4000, "Vertical Tire Stiffness [N/m]": 200000, "Vertical Tire Damping [Ns/m]": 900},
        "Longitudinal": {"Initial Slopes dFx/dsx [N]": [80000, 150000], "Maximum Fx Load [N]": [4000, 8000], "Sliding Fx Load [N]": [2000, 4000]},
        "Lateral": {"Initial Slopes dFy/dsy [N]": [60000, 110000], "Maximum Fy Load [N]": [4000, 7800], "Sliding Fy Load [N]": [3700, 7000]}}}"#;
    let car = Car::plain();
    let TyreSpec::Tmeasy(t) = car.tyre(text).spec.tyre else { panic!() };
    assert_eq!(
        (t.pn, t.vertical_stiffness, t.dfx0, t.fxm, t.fxs),
        (4e3, 2e5, [8e4, 15e4], [4e3, 8e3], [2e3, 4e3])
    );
    // Sliding at half of the maximum: B = 5/6 π, and sin(B (1 - exp(-s / A))) is 1 where exp(-s / A) = 2/5.
    let a = 4000.0 * 5.0 / 6.0 * std::f64::consts::PI / 80e3;
    // ln(5/2).
    near(t.sxm[0], a * 0.916_290_731_874_155);
    assert!(t.sxs[0] > t.sxm[0]);
    let curve = text.replace(
        "\"Vertical Tire Stiffness [N/m]\": 200000",
        "\"Tire Spring Curve Data\": [[0, 0], [0.02, 3000], [0.04, 7000]]",
    );
    let TyreSpec::Tmeasy(t) = car.tyre(&curve).spec.tyre else { panic!() };
    // 4 kN at 25 mm.
    near(t.vertical_stiffness, 160e3);
    // Without parameters, they follow from the load: half of 8 kN is the nominal one.
    let start = text.find(", \"Parameters\"").unwrap();
    let guess =
        format!("{}, \"Maximum Bearing Capacity [N]\": 8000, \"Vehicle Type\": \"Truck\"}}", &text[..start]);
    let TyreSpec::Tmeasy(t) = car.tyre(&guess).spec.tyre else { panic!() };
    near(t.pn, 4000.0);
    // Chrono's generator for truck tyres: 7.4013 times the nominal load.
    near(t.dfy0[0], 7.4013 * 4000.0);
    let e = text.replace("\"Sliding Fx Load [N]\": [2000", "\"Sliding Fx Load [N]\": [9000");
    let tyre = car.write("other.json", &e);
    let e = import(&car.car, &Options { tyres: vec![tyre], ..Options::default() }).unwrap_err().to_string();
    assert!(e.contains("Parameters/Longitudinal: slope 80000, maximum 4000 and sliding force 9000"), "{e}");
}

#[test]
fn the_magic_formula_of_1989_has_its_slopes_and_peaks() {
    let i = Car::plain().tyre(
        r#"{"Type": "Tire", "Template": "Pac89Tire", "Mass": 12, "Inertia": [1, 2, 1], "Coefficient of Friction": 0.8,
        "Design Parameters": {"Unloaded Radius": 0.35, "Width": 0.2, "Vertical Damping": 500, "Rolling Resistance": 0.01,
        "Vertical Curve Data": [[0, 0], [0.1, 20000]]},
        "Lateral Coefficients": {"a1": 0, "a2": 900, "a3": 1200, "a4": 5}, "Longitudinal Coefficients": {"b1": 0, "b2": 1100, "b3": 0, "b4": 180, "b5": 0}}"#,
    );
    let TyreSpec::Brush(t) = &i.spec.tyre else { panic!() };
    let load = load(&i);
    let x = 0.001 * load / 5.0;
    // sin(2 atan x) = 2 x / (1 + x²), per degree; and 100 percent of b4 per kN.
    near(t.slip_stiffness[1], 1200.0 * 2.0 * x / (1.0 + x * x) * 180.0 / std::f64::consts::PI / load);
    near(t.slip_stiffness[0], 18.0);
    near(t.friction, 1.0);
    near(t.vertical_stiffness, 200e3);
}

/// A tracked set with three road wheels. `road` and `idler` are files.
fn tracked(folder: &Path, road: &str, idler: &str) -> PathBuf {
    let wheel = |kind: &str| {
        format!(
            r#"{{"Name": "w", "Type": "{kind}", "Template": "DoubleTrackWheel", "Wheel": {{"Radius": 0.3, "Width": 0.2, "Mass": 30, "Inertia": [1, 2, 1]}}}}"#
        )
    };
    let at = |x: f64| {
        format!(r#"{{"Input File": "own/road.json", "Has Shock": true, "Location": [{x}, 0, -0.3]}}"#)
    };
    let assembly = format!(
        r#"{{"Name": "a", "Type": "TrackAssembly", "Template": "TrackAssemblySinglePin", "Sprocket": {{"Input File": "own/sprocket.json", "Location": [0, 0, 0]}},
        "Brake": {{"Input File": "own/brake.json"}}, "Idler": {{"Input File": "own/idler.json", "Location": [-4, 0, 0]}},
        "Suspension Subsystems": [{}, {}, {}], "Rollers": [{{"Input File": "own/roller.json", "Location": [-2, 0, 0.2]}}],
        "Track Shoes": {{"Input File": "own/shoe.json", "Number Shoes": 60}}}}"#,
        at(-1.0),
        at(-2.0),
        at(-3.0)
    );
    let files = [
        ("own/wheel.json", wheel("TrackWheel")),
        ("own/roller.json", wheel("Roller").replace("\"Wheel\": {", "\"Roller\": {")),
        ("own/road.json", road.to_owned()),
        ("own/idler.json", idler.to_owned()),
        ("own/a.json", assembly),
        ("own/brake.json", r#"{"Name": "b", "Type": "TrackBrake", "Template": "TrackBrakeSimple", "Maximum Torque": 9000}"#.to_owned()),
        (
            "own/sprocket.json",
            r#"{"Name": "s", "Type": "Sprocket", "Template": "SprocketSinglePin", "Gear Mass": 40, "Gear Inertia": [1, 2, 1], "Axle Inertia": 0.4,
            "Profile": {"Assembly Radius": 0.25}}"#
                .to_owned(),
        ),
        (
            "own/shoe.json",
            r#"{"Name": "s", "Type": "TrackShoe", "Template": "TrackShoeSinglePin", "Shoe": {"Height": 0.06, "Pitch": 0.15, "Mass": 10, "Width": 0.4}}"#
                .to_owned(),
        ),
        (
            "own/chassis.json",
            r#"{"Name": "c", "Type": "Chassis", "Template": "RigidChassis", "Components": [{"Centroidal Frame": {"Location": [-2, 0, 0.3]},
            "Mass": 9000, "Moments of Inertia": [5000, 12000, 14000]}]}"#
                .to_owned(),
        ),
        ("own/line.json", r#"{"Name": "d", "Type": "TrackDriveline", "Template": "SimpleTrackDriveline", "Differential Max Bias": 1}"#.to_owned()),
        (
            "own/powertrain.json",
            r#"{"Name": "p", "Type": "Powertrain", "Template": "SimpleCVTPowertrain", "Forward Gear Ratio": 0.2, "Reverse Gear Ratio": -0.2,
            "Maximum Engine Torque": 2000, "Maximum Engine Power": 200000, "Maximum Engine Speed": 500}"#
                .to_owned(),
        ),
        (
            "own/tank.json",
            r#"{"Name": "tank", "Type": "Vehicle", "Template": "TrackedVehicle", "Chassis": {"Input File": "own/chassis.json"},
            "Track Assemblies": [{"Input File": "own/a.json", "Offset": 1.2}, {"Input File": "own/a.json", "Offset": -1.2}],
            "Driveline": {"Input File": "own/line.json"}}"#
                .to_owned(),
        ),
    ];
    super::write(folder, &files);
    folder.join("own/tank.json")
}

const ROAD: &str = r#"{"Name": "r", "Type": "TrackSuspension", "Template": "RotationalDamperSuspension", "Road Wheel Input File": "own/wheel.json",
    "Suspension Arm": {"Mass": 50, "COM": [0.2, -0.1, 0.05], "Location Chassis": [0.4, -0.1, 0.1], "Location Wheel": [0, -0.1, 0]},
    "Torsional Spring": {"Free Angle": 0, "Spring Constant": 40000, "Damping Coefficient": 300, "Preload": -9000},
    "Damper": {"Curve Data": [[-2, -3000], [-1, -2000], [0, 0], [1, 2000], [2, 3000]]}}"#;
const IDLER: &str = r#"{"Name": "i", "Type": "Idler", "Template": "DistanceIdler", "Idler Wheel Input File": "own/wheel.json",
    "Carrier": {"Mass": 10, "Location Wheel": [0.1, 0, 0.05], "Location Chassis": [0, -0.1, 0.1]},
    "Tensioner": {"Location Carrier": [0, -0.1, -0.1], "Location Arm": [-0.2, -0.1, 0.1], "Extension time": 0.3, "Extension distance": 0.3}}"#;

/// Stiffness, damping and preload of the torsion bar of the first road wheel.
fn torsion(i: &Imported) -> [f64; 3] {
    let t = i.spec.axles.iter().find_map(|a| a.suspension.linkage.torsion()).unwrap();
    [t.stiffness, t.damping, t.preload]
}

#[test]
fn rotary_dampers_and_distance_idlers_are_read() {
    let dir = tempfile::tempdir().unwrap();
    let i = import(&tracked(dir.path(), ROAD, IDLER), &Options::default()).unwrap_or_else(|e| panic!("{e}"));
    // The steepest slope is 2000 N m s/rad.
    assert_eq!(torsion(&i), [40e3, 2300.0, 9e3]);
    assert!(says(&i, Kind::Approximated, "rotary damper is linear"));
    assert!(says(&i, Kind::NoCounterpart, "own/idler.json: Tensioner"));
    let [front, idler] = [0, 4].map(|k| i.spec.axles[k].position);
    // The idler's wheel stands 0.1 m before the idler's place, 3.9 m behind the sprocket, and 0.05 m above it.
    near(front[0] - idler[0], 3.9);
    near(idler[2] - front[2], 0.05);

    let bar = ROAD.replace(
        r#""Free Angle": 0, "Spring Constant": 40000, "Damping Coefficient": 300, "Preload": -9000"#,
        r#""Free Angle": -0.2, "Spring Curve Data": [[-1, -50000], [0, 0], [1, 50000]], "Damping Curve Data": [[-1, -400], [1, 400]]"#,
    );
    let i = import(&tracked(dir.path(), &bar, IDLER), &Options::default()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(torsion(&i), [50e3, 2400.0, 10e3]);
}

#[test]
fn track_files_of_chrono_6_are_read() {
    let dir = tempfile::tempdir().unwrap();
    let new =
        import(&tracked(dir.path(), ROAD, IDLER), &Options::default()).unwrap_or_else(|e| panic!("{e}"));
    let road = ROAD
        .replace("\"TrackSuspension\"", "\"RoadWheelAssembly\"")
        .replace("RotationalDamperSuspension", "RotationalDamperRWAssembly");
    let idler = IDLER.replace(
        "\"Idler Wheel Input File\": \"own/wheel.json\"",
        r#""Wheel": {"Radius": 0.3, "Width": 0.2, "Mass": 30, "Inertia": [1, 2, 1]}"#,
    );
    let old =
        import(&tracked(dir.path(), &road, &idler), &Options::default()).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(torsion(&old), torsion(&new));
    for (a, b) in old.spec.axles.iter().zip(&new.spec.axles) {
        assert_eq!(
            (a.position, a.unsprung_mass, a.spin_inertia),
            (b.position, b.unsprung_mass, b.spin_inertia)
        );
    }
}

#[test]
fn empty_tables_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let bar = ROAD.replace("\"Spring Constant\": 40000", "\"Spring Curve Data\": []");
    let e = import(&tracked(dir.path(), &bar, IDLER), &Options::default()).unwrap_err().to_string();
    assert!(e.contains("own/road.json: Torsional Spring/Spring Curve Data: has no points"), "{e}");
}

/// The crank's arm to the tie rod is parallel to the knuckle's and as long: the knuckle turns as the crank does.
#[test]
fn a_solid_axle_with_a_bell_crank_beside_the_middle_turns_as_the_crank() {
    let axle = |tie: f64| {
        format!(
            r#"{{"Name": "r", "Type": "Suspension", "Template": "SolidAxle", {SPINDLE}, {AXLE},
            "Knuckle": {{"Mass": 9, "Location Lower": [0, 0.68, -0.1], "Location Upper": [0, 0.68, 0.1]}},
            "Axle Tube": {{"Mass": 60, "COM": [0, 0, 0], "Inertia": [10, 0.3, 10], "Radius": 0.05}},
            "Upper Link": {{"Mass": 3, "Location Chassis": [0.5, 0.2, 0.15], "Location Axle": [0, 0.45, 0.15]}},
            "Lower Link": {{"Mass": 3, "Location Chassis": [0.7, 0.4, -0.1], "Location Axle": [0.05, 0.45, -0.1]}},
            "Tierod": {{"Mass": 4, "Location Knuckle": [-0.2, 0.64, 0]}}, "Draglink": {{"Mass": 4, "Location Chassis": [0.6, 0.4, 0], "Location Bell Crank": [0, 0.4, 0]}},
            "Bell Crank": {{"Mass": 5, "Location Axle": [0, 0.3, 0], "Location Tierod": [{tie}, 0.3, 0]}},
            "Spring": {{"Location Chassis": [0, 0.5, 0.4], "Location Axle": [0, 0.5, 0.05], "Spring Coefficient": 50000, "Free Length": 0.42}},
            "Shock": {{"Location Chassis": [0.1, 0.45, 0.4], "Location Axle": [0.1, 0.5, 0.05], "Damping Coefficient": 4000}}}}"#
        )
    };
    let arm = r#"{"Name": "s", "Type": "Steering", "Template": "RotaryArm", "Pitman Arm": {"Mass": 4, "Inertia": [1, 1, 1], "Radius": 0.03,
        "Axis of Rotation": [0, 1, 0], "Point of Rotation": [0.6, 0.4, 0.2], "Point to Draglink": [0.6, 0.4, 0], "Maximum Angle (deg)": 10}}"#;
    for (tie, lever) in [(-0.2, 0.1), (-0.1, 0.2)] {
        let i = Car::new(&axle(tie), &wishbones(), arm).import();
        let k = i.spec.axles[0].suspension.linkage.knuckles().unwrap();
        let KnuckleDrive::Toebar { drag_link_outer } = k.by else { panic!() };
        // The crank's lever of 0.1 m across, at the kingpin, times the ratio of the arms; the drag link is 0.6 m long.
        near(drag_link_outer[1], 0.68 + lever);
        near(k.drag_link_inner[0] - drag_link_outer[0], 0.6);
        assert_eq!(k.drag_link_inner[1], drag_link_outer[1]);
    }
    let car = Car::new(&axle(0.2), &wishbones(), arm);
    let e = import(&car.car, &Options::default()).unwrap_err().to_string();
    assert!(e.contains("own/front.json: Bell Crank: its arm to the tie rod"), "{e}");
}

#[test]
fn a_gear_that_asks_for_more_than_the_linkage_gives_is_reduced() {
    // A rack that travels by 0.21 m at knuckles with arms of 0.15 m.
    let rack = RACK.replace("\"Radius\": 0.1", "\"Radius\": 0.3");
    let i = Car::new(&wishbones(), &wishbones(), &rack).import();
    let Some(SteeringGear::RackAndPinion { travel }) = i.spec.axles[0].steering else { panic!() };
    assert!(travel.abs() < 0.2 && travel.abs() > 0.08, "{travel}");
    assert!(says(&i, Kind::Approximated, "of its maximum angle, the limit of the linkage"));
}
