//! Chrono's own sets and Clearpath's robots, where the reference data are there.

use std::path::PathBuf;
use vb_import::{Imported, Options, import};
use vb_vehicle::suspension::{Damper, Linkage};
use vb_vehicle::{TyreSpec, VehicleSpec};

fn chrono(file: &str) -> Option<Imported> {
    let file = vb_testing::shared(&format!("cases/chrono/json/{file}"))?;
    Some(import(&file, &Options::default()).unwrap_or_else(|e| panic!("{e}")))
}

fn shipped(name: &str) -> VehicleSpec {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../tasks/vehicles").join(name);
    <VehicleSpec as vb_files::Document>::load(&path).unwrap()
}

fn near(a: &[f64], b: &[f64], by: f64) {
    assert!(a.len() == b.len() && a.iter().zip(b).all(|(x, y)| (x - y).abs() <= by), "{a:?} {b:?}");
}

/// Chrono's files round the points of the shipped vehicle, which has more digits of the same source, to some millimetres.
#[test]
fn the_hmmwv_has_the_shipped_vehicles_values_where_both_are_chronos() {
    let Some(i) = chrono("hmmwv/vehicle/HMMWV_Vehicle_4WD.json") else { return };
    let ours = shipped("hmmwv.yaml");
    for (a, b) in i.spec.axles.iter().zip(&ours.axles) {
        let (Linkage::DoubleWishbone(x), Linkage::DoubleWishbone(y)) =
            (&a.suspension.linkage, &b.suspension.linkage)
        else {
            panic!("{:?}", a.suspension.linkage)
        };
        for (p, q) in [
            (x.spindle, y.spindle),
            (x.upper_arm_front, y.upper_arm_front),
            (x.upper_arm_rear, y.upper_arm_rear),
            (x.upper_ball_joint, y.upper_ball_joint),
            (x.lower_arm_front, y.lower_arm_front),
            (x.lower_arm_rear, y.lower_arm_rear),
            (x.lower_ball_joint, y.lower_ball_joint),
            (x.tie_rod_inner, y.tie_rod_inner),
            (x.tie_rod_outer, y.tie_rod_outer),
        ] {
            near(&p, &q, 0.003);
        }
        // Chrono's link has no mass for its tie rods here: 3 kg less.
        near(&[a.unsprung_mass], &[b.unsprung_mass], 3.01);
        near(&[a.spin_inertia], &[b.spin_inertia], 1e-3);
        near(&[a.brake_torque], &[b.brake_torque], 0.0);
        for (s, t) in a.suspension.struts.iter().zip(&b.suspension.struts) {
            near(&s.chassis, &t.chassis, 0.003);
            near(&s.end, &t.end, 0.003);
        }
        assert!(matches!(a.suspension.struts[1].damper, Some(Damper::Linear { .. })));
    }
    // The chassis is Chrono's with half of the arms.
    near(&i.spec.chassis.com, &ours.chassis.com, 0.03);
    for (x, y) in i.spec.chassis.inertia.iter().zip(&ours.chassis.inertia) {
        assert!((x / y - 1.0).abs() < 0.08, "{x} {y}");
    }
    let (TyreSpec::Tmeasy(t), Some(TyreSpec::Tmeasy(u))) = (&i.spec.tyre, ours.tyres.get("tmeasy")) else {
        panic!()
    };
    // Shapes of the curves; the file's load index gives another nominal load than the shipped vehicle has.
    near(&t.sxm, &u.sxm, 1e-9);
    near(&t.sys, &u.sys, 1e-9);
    near(&[t.dfx0[0] / t.pn, t.fym[1] / t.pn], &[u.dfx0[0] / u.pn, u.fym[1] / u.pn], 1e-4);
}

#[test]
fn every_vehicle_of_the_sets_is_converted_and_says_what_it_lacks() {
    for file in [
        "hmmwv/vehicle/HMMWV_Vehicle.json",
        "hmmwv/vehicle/HMMWV_Vehicle_4WD.json",
        "hmmwv/vehicle/HMMWV_Vehicle_mapShock.json",
        "hmmwv/vehicle/HMMWV_Vehicle_bushings.json",
        "gator/json/Gator_Vehicle.json",
        "Polaris/Polaris.json",
        "uaz/vehicle/UAZBUS_Vehicle.json",
        "uaz/vehicle/UAZBUS_VehicleT.json",
        "uaz/vehicle/UAZBUS_SAEVehicle.json",
        "uaz/vehicle/UAZ469_Vehicle.json",
        "M113/vehicle/M113_Vehicle_SinglePin.json",
        "M113/vehicle/M113_Vehicle_DoublePin_BDS.json",
        "M113/vehicle/M113_Vehicle_BandBushing.json",
    ] {
        let Some(i) = chrono(file) else { return };
        assert!(i.notes.iter().count() > 5, "{file}");
        let again = <VehicleSpec as vb_files::Document>::parse(&i.file(), file).unwrap();
        assert_eq!(again.axles.len(), i.spec.axles.len());
    }
    let Some(path) = vb_testing::shared("cases/chrono/json/hmmwv/vehicle/HMMWV_Vehicle_replica.json") else {
        return;
    };
    let e = import(&path, &Options::default()).unwrap_err().to_string();
    assert!(e.contains("GenericWheeledSuspension"), "{e}");
}

#[test]
fn every_other_file_of_the_sets_is_refused_in_one_line() {
    let Some(root) = vb_testing::shared("cases/chrono") else { return };
    let mut folders = vec![root];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if let Err(e) = import(&path, &Options::default()) {
                let e = e.to_string();
                assert!(!e.contains('\n') && e.len() > 20, "{e}");
            }
        }
    }
}

#[test]
fn robots_of_clearpath_turn_by_the_speeds_of_their_sides() {
    for (file, arguments) in [
        ("husky/husky_description/urdf/husky.urdf.xacro", &[][..]),
        ("jackal/jackal_description/urdf/jackal.urdf.xacro", &[]),
    ] {
        let Some(path) = vb_testing::shared(&format!("cases/urdf/{file}")) else { return };
        let options = Options { arguments: arguments.to_vec(), ..Options::default() };
        let spec = import(&path, &options).unwrap().spec;
        assert!(spec.skid.is_some() && spec.axles.len() == 2, "{file}");
    }
}
