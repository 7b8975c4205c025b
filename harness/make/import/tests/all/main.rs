//! Tests of conversions: small sets with values of our own, and Chrono's where the reference data are there.

#![allow(clippy::unwrap_used, reason = "a test that fails panics")]

mod chrono;
mod invalid;
mod shared;
mod urdf;
mod variants;

use std::fs;
use std::path::{Path, PathBuf};

/// Writes files below a folder.
fn write(folder: &Path, files: &[(&str, String)]) {
    for (name, text) in files {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
}

/// A four-wheeled set with these suspensions: front (steered), rear; and a steering subsystem.
fn set(folder: &Path, front: &str, rear: &str, steering: &str) -> PathBuf {
    let wheel =
        r#"{"Name": "w", "Type": "Wheel", "Template": "Wheel", "Mass": 10, "Inertia": [0.3, 0.5, 0.3]}"#;
    let brake = r#"{"Name": "b", "Type": "Brake", "Template": "BrakeSimple", "Maximum Torque": 2500}"#;
    let chassis = r#"{"Name": "c", "Type": "Chassis", "Template": "RigidChassis", "Components": [
        {"Centroidal Frame": {"Location": [-1.2, 0, 0.4], "Orientation": [1, 0, 0, 0]}, "Mass": 1200,
         "Moments of Inertia": [400, 1500, 1600], "Products of Inertia": [0, 0, 0], "Void": false}],
        "Contact": {"Materials": [{"Coefficient of Friction": 0.5}],
          "Shapes": [{"Type": "BOX", "Location": [-1.25, 0, 0.4], "Orientation": [1, 0, 0, 0], "Dimensions": [2.6, 0.8, 0.4], "Material Index": 0}]}}"#;
    let driveline = r#"{"Name": "d", "Type": "Driveline", "Template": "ShaftsDriveline2WD",
        "Shaft Direction": {"Motor Block": [1, 0, 0], "Axle": [0, 1, 0]},
        "Shaft Inertia": {"Driveshaft": 0.4, "Differential Box": 0.5}, "Gear Ratio": {"Conical Gear": -0.25}}"#;
    let engine = r#"{"Name": "e", "Type": "Engine", "Template": "EngineSimpleMap", "Maximal Engine Speed RPM": 5000,
        "Map Full Throttle": [[-100, 100], [1000, 180], [3000, 220], [5000, 180]],
        "Map Zero Throttle": [[-100, 0], [0, 0], [1000, -15], [5000, -40]]}"#;
    let transmission = r#"{"Name": "t", "Type": "Transmission", "Template": "AutomaticTransmissionSimpleMap", "Gear Box": {
        "Reverse Gear Ratio": -0.25, "Forward Gear Ratios": [0.3, 0.6, 1.0],
        "Shift Points Map RPM": [[1000, 4000], [1500, 4000], [1500, 4000]]}}"#;
    let tyre = r#"{"Name": "y", "Type": "Tire", "Template": "TMeasyTire", "Design": {"Unloaded Radius [m]": 0.35, "Mass [kg]": 12,
        "Inertia [kg.m2]": [0.6, 1.0, 0.6], "Width [m]": 0.24, "Rim Radius [m]": 0.2}, "Coefficient of Friction": 0.8,
        "Rolling Resistance Coefficient": 0.015, "Vehicle Type": "Passenger", "Maximum Bearing Capacity [N]": 8000}"#;
    let axle = |file: &str, x: f64, steered: bool| {
        format!(
            r#"{{"Suspension Input File": "own/{file}", "Suspension Location": [{x}, 0, 0], {}
            "Left Wheel Input File": "own/wheel.json", "Right Wheel Input File": "own/wheel.json",
            "Left Brake Input File": "own/brake.json", "Right Brake Input File": "own/brake.json"}}"#,
            if steered { "\"Steering Index\": 0," } else { "" }
        )
    };
    let vehicle = format!(
        r#"{{"Name": "Own car", "Type": "Vehicle", "Template": "WheeledVehicle", "Chassis": {{"Input File": "own/chassis.json"}},
        "Axles": [{}, {}], "Steering Subsystems": [{{"Input File": "own/steering.json", "Location": [0, 0, 0], "Orientation": [1, 0, 0, 0]}}],
        "Driveline": {{"Input File": "own/driveline.json", "Suspension Indexes": [1]}}}}"#,
        axle("front.json", 0.0, true),
        axle("rear.json", -2.5, false)
    );
    write(
        folder,
        &[
            ("own/wheel.json", wheel.to_owned()),
            ("own/brake.json", brake.to_owned()),
            ("own/chassis.json", chassis.to_owned()),
            ("own/driveline.json", driveline.to_owned()),
            ("own/engine.json", engine.to_owned()),
            ("own/transmission.json", transmission.to_owned()),
            ("own/tyre.json", tyre.to_owned()),
            ("own/steering.json", steering.to_owned()),
            ("own/front.json", front.to_owned()),
            ("own/rear.json", rear.to_owned()),
            ("own/car.json", vehicle),
        ],
    );
    folder.join("own/car.json")
}

const RACK: &str = r#"{"Name": "s", "Type": "Steering", "Template": "RackPinion",
    "Steering Link": {"Mass": 5, "COM": 0, "Inertia": [1, 1, 1], "Radius": 0.03, "Length": 0.9},
    "Pinion": {"Radius": 0.1, "Maximum Angle (deg)": 40}}"#;

const SPINDLE: &str = r#""Spindle": {"Mass": 8, "COM": [0, 0.75, 0], "Inertia": [0.1, 0.2, 0.1], "Radius": 0.1, "Width": 0.05}"#;
const AXLE: &str = r#""Axle": {"Inertia": 0.3}"#;
/// On a trailing or lower arm, below the chassis.
const SPRINGS: &str = r#""Spring": {"Location Chassis": [0, 0.55, 0.35], "Location Arm": [0, 0.6, -0.12], "Spring Coefficient": 60000, "Free Length": 0.56},
    "Shock": {"Location Chassis": [0, 0.5, 0.4], "Location Arm": [0, 0.6, -0.12], "Damping Coefficient": 5000}"#;

/// A double wishbone with values of our own.
fn wishbones() -> String {
    format!(
        r#"{{"Name": "f", "Type": "Suspension", "Template": "DoubleWishbone", {SPINDLE}, {AXLE}, {SPRINGS},
        "Upright": {{"Mass": 12, "COM": [0, 0.7, 0]}},
        "Upper Control Arm": {{"Mass": 4, "Location Chassis Front": [0.1, 0.35, 0.2], "Location Chassis Back": [-0.1, 0.35, 0.2], "Location Upright": [0, 0.65, 0.2]}},
        "Lower Control Arm": {{"Mass": 8, "Location Chassis Front": [0.2, 0.3, -0.1], "Location Chassis Back": [-0.2, 0.3, -0.1], "Location Upright": [0, 0.7, -0.12]}},
        "Tierod": {{"Location Chassis": [-0.15, 0.32, 0], "Location Upright": [-0.15, 0.67, 0]}}}}"#
    )
}
