//! The C header against the structs that the worker uses. Skipped where there is no C compiler.

#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a helper of a test may fail it")]

use std::mem::{offset_of, size_of};
use std::path::{Path, PathBuf};
use std::process::Command;

use vb_sdk::{GridFrame, Point2, Pose2, Vec3, Wheel};
use vb_worker::c_abi::*;

fn header_dir() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../sdk/c")
}

/// The output of a C program, or none where there is no compiler.
fn c_program(body: &str, compiler: &str, extension: &str) -> Option<String> {
    let dir = tempfile::tempdir().unwrap();
    let (source, program) = (dir.path().join(format!("p.{extension}")), dir.path().join("p"));
    let text = format!(
        "#include <stdio.h>\n#include \"vb_planner.h\"\n\
         VB_PLANNER_METADATA(\"p\", \"1\", \"a\", \"b\", \"0.1\", VB_PARAM(\"k\", \"1\", \"h\"));\n\
         int main(void) {{\n{body}\nreturn 0; }}\n"
    );
    std::fs::write(&source, text).unwrap();
    let mut command = Command::new(compiler);
    command.args(["-Wall", "-Wextra", "-Wpedantic", "-Werror", "-I"]).arg(header_dir());
    let built = command.arg("-o").arg(&program).arg(&source).output();
    let Ok(built) = built else {
        vb_testing::skip(format_args!("there is no `{compiler}`"));
        return None;
    };
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    Some(String::from_utf8(Command::new(program).output().unwrap().stdout).unwrap())
}

#[test]
fn structs_have_the_sizes_and_offsets_of_the_c_compiler() {
    let mut body = String::new();
    let mut expected = String::new();
    macro_rules! same {
        ($c:literal, $rust:ty: $($field:ident),*) => {
            body += &format!("printf(\"%s %zu\\n\", \"{0}\", sizeof({0}));\n", $c);
            expected += &format!("{} {}\n", $c, size_of::<$rust>());
            $(
                body += &format!("printf(\"%s %zu\\n\", \"{0}.{1}\", offsetof({0}, {1}));\n", $c, stringify!($field));
                expected += &format!("{}.{} {}\n", $c, stringify!($field), offset_of!($rust, $field));
            )*
        };
    }
    same!("vb_point2", Point2: x, y);
    same!("vb_pose2", Pose2: x, y, yaw);
    same!("vb_vec3", Vec3: x, y, z);
    same!("vb_wheel", Wheel: speed, deflection);
    same!("vb_grid_frame", GridFrame: rows, cols, resolution, origin_x, origin_y);
    same!("vb_heights", CHeights: frame, data);
    same!("vb_labels", CLabels: frame, data);
    same!("vb_param", CParam: key, value);
    same!("vb_vehicle", CVehicle: size, name, scale, mass, length, width, height, wheelbase, track, wheel_radius,
        wheels, ground_clearance, max_steer_angle, max_steer_rate, min_turn_radius, max_speed);
    same!("vb_task", CTask: size, id, vehicle, elevation, semantics, occupancy, path, path_len, start, goal,
        goal_radius, time_limit, control_period, seed, params, params_len);
    same!("vb_observation", CObservation: size, time, position, roll, pitch, yaw, linear_velocity, angular_velocity,
        wheels, wheels_len, last_steering, last_throttle, last_brake);
    same!("vb_series", CSeries: name, values, values_len);
    same!("vb_command", CCommand: size, steering, throttle, brake, debug, debug_len);
    same!("vb_error", CError: size, message);
    same!("vb_host", CHost: size, context, log);
    same!("vb_planner_functions", CFunctions: size, abi_major, abi_minor, init, step, free);
    if let Some(found) = c_program(&body, "cc", "c") {
        assert_eq!(found, expected);
    }
}

#[test]
fn constants_agree_and_the_header_compiles_as_c_and_cpp_without_a_warning() {
    let body = "printf(\"%d %d %d\\n\", VB_ABI_MAJOR, VB_ABI_MINOR, VB_ERROR_BYTES);";
    let expected = format!("{} {} {ERROR_BYTES}\n", ABI.0, ABI.1);
    assert_eq!(format!("{}.{}", ABI.0, ABI.1), vb_sdk::ABI_VERSION);
    for (compiler, extension) in [("cc", "c"), ("c++", "cpp")] {
        if let Some(found) = c_program(body, compiler, extension) {
            assert_eq!(found, expected, "{compiler}");
        }
    }
}

#[test]
fn the_metadata_macro_writes_what_the_harness_reads() {
    let body = "fwrite(vb_planner_metadata, 1, sizeof vb_planner_metadata - 1, stdout);";
    if let Some(text) = c_program(body, "cc", "c") {
        let metadata = vb_sdk::metadata::Metadata::parse(text.as_bytes()).unwrap();
        assert_eq!((metadata.name.as_str(), metadata.abi.as_str()), ("p", vb_sdk::ABI_VERSION));
        assert_eq!((metadata.control_period, metadata.params[0].key.as_str()), (0.1, "k"));
    }
}
