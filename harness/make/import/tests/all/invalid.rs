//! Sources that make no sense: one line each, with file, place and next step.

use super::{RACK, set, wishbones};
use vb_import::{Options, import};

/// The message for a set in which a text of a file is replaced.
fn refused(file: &str, from: &str, to: &str) -> String {
    let dir = tempfile::tempdir().unwrap();
    let car = set(dir.path(), &wishbones(), &wishbones(), RACK);
    let path = dir.path().join(file);
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "{file}: {from}");
    std::fs::write(&path, text.replacen(from, to, 1)).unwrap();
    let e = import(&car, &Options::default()).expect_err(from).to_string();
    assert!(!e.contains('\n'), "{e}");
    e
}

#[test]
fn messages_name_file_place_and_next_step() {
    for (file, from, to, says) in [
        (
            "own/front.json",
            "\"Mass\": 8,",
            "\"Mass\": \"heavy\",",
            "own/front.json: Spindle/Mass: \"heavy\" is not a number",
        ),
        ("own/front.json", "\"Mass\": 8,", "\"Mass\": ,", "own/front.json: line 1: invalid JSON"),
        (
            "own/front.json",
            "[0, 0.75, 0]",
            "[0, 0.75]",
            "own/front.json: Spindle/COM: 2 numbers, but 3 are expected",
        ),
        ("own/front.json", "[0, 0.75, 0]", "[0, -0.75, 0]", "points are those of the left side"),
        ("own/front.json", "\"Spindle\"", "\"Spindel\"", "own/front.json: \"Spindle\" is missing"),
        (
            "own/front.json",
            "\"Suspension\"",
            "\"Wheel\"",
            "own/front.json: Type: \"Wheel\", but \"Suspension\" is expected here",
        ),
        (
            "own/front.json",
            "\"DoubleWishbone\"",
            "\"HendricksonPRIMAXX\"",
            "own/front.json: no counterpart of the template",
        ),
        (
            "own/car.json",
            "own/front.json",
            "own/none.json",
            "own/car.json: Axles[0]/Suspension Input File: refers to \"own/none.json\"",
        ),
        ("own/car.json", "own/front.json", "own/../../x.json", "leaves the folder of the set"),
        // A loop of references has a file of another type than expected.
        (
            "own/car.json",
            "own/front.json",
            "own/car.json",
            "own/car.json: Type: \"Vehicle\", but \"Suspension\" is expected here",
        ),
        (
            "own/car.json",
            "\"Suspension Indexes\": [1]",
            "\"Suspension Indexes\": [0, 1]",
            "own/driveline.json: drives 1 axles",
        ),
        (
            "own/car.json",
            "\"Suspension Indexes\": [1]",
            "\"Suspension Indexes\": [7]",
            "axle 7 does not exist; there are 2",
        ),
        (
            "own/car.json",
            "\"Steering Index\": 0",
            "\"Steering Index\": 3",
            "steering subsystem 3 does not exist",
        ),
        ("own/car.json", "\"Type\": \"Vehicle\"", "\"Type\": \"Wheel\"", "is a part of a vehicle"),
        ("own/car.json", "\"WheeledVehicle\"", "\"Hovercraft\"", "has no counterpart"),
        ("own/car.json", "[-2.5, 0, 0]", "[-2500, 0, 0]", "not SI units"),
        ("own/chassis.json", "\"Mass\": 1200", "\"Mass\": -1200", "the mass must be positive"),
        ("own/engine.json", "\"Engine\"", "\"Motor\"", "--engine"),
        ("own/tyre.json", "\"Tire\"", "\"Tyre\"", "--tyre"),
        ("own/tyre.json", "TMeasyTire", "ANCFTire", "--tyre"),
        ("own/front.json", "[0, 0.65, 0.2]", "[0, 0.35, 0.2]", "does not close"),
    ] {
        let e = refused(file, from, to);
        assert!(e.contains(says), "{from} → {to}: {e}");
    }
}

#[test]
fn foreign_files_are_called_what_they_are() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("f");
    for (text, says) in [
        ("", "neither JSON of Project Chrono nor URDF"),
        ("steps: [1]", "neither JSON of Project Chrono nor URDF"),
        ("{\"a\": 1}", "\"Type\" is missing"),
        ("{\"a\": 1", "invalid JSON"),
        ("<sdf/>", "URDF starts with <robot>"),
        ("<robot", "invalid XML"),
        ("{\"Type\": \"Vehicle\"}", "\"Template\" is missing"),
        ("{\"Type\": \"Vehicle\", \"Template\": \"WheeledVehicle\"}", "\"Chassis\" is missing"),
    ] {
        std::fs::write(&file, text).unwrap();
        let e = import(&file, &Options::default()).unwrap_err().to_string();
        assert!(e.contains(says) && !e.contains('\n'), "{text}: {e}");
    }
    assert!(import(&dir.path().join("none"), &Options::default()).is_err());
    assert!(import(dir.path(), &Options::default()).is_err());
    std::fs::write(&file, vec![b' '; 5 << 20]).unwrap();
    assert!(import(&file, &Options::default()).unwrap_err().to_string().contains("larger than"));
}
