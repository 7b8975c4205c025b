//! A robot description (URDF) of a vehicle from the brief of a planner.

use std::fmt::Write as _;

use vb_sdk::{DepthInfo, LidarInfo, Mount, Vehicle};

use crate::convert::frame;

/// The name of the joint of a wheel, which is also in joint states, e.g. `left_wheel_0_joint`: the side, and the axle from the front. Wheels are
/// numbered from front to back, left before right.
#[must_use]
pub fn wheel_joint(wheel: usize) -> String {
    let side = if wheel.is_multiple_of(2) { "left" } else { "right" };
    format!("{side}_wheel_{}_joint", wheel / 2)
}

/// The description: a box for the hull, wheels, and the frames of the sensors. Axles between the first and the last have equal distances.
/// A box has the size of the collision shape and its belly's height above the ground.
#[must_use]
pub fn description(vehicle: &Vehicle, lidar: Option<&LidarInfo>, depth: Option<&DepthInfo>) -> String {
    let Vehicle { length, width, height, wheelbase, track, wheel_radius, ground_clearance, .. } = *vehicle;
    let mut out = String::from("<?xml version=\"1.0\"?>\n");
    let _ = writeln!(out, "<robot name=\"{}\">", escaped(&vehicle.name));
    // The reference point is as high as the wheel centres.
    let (low, high) = (ground_clearance - wheel_radius, height - wheel_radius);
    let shape = format!(
        "<origin xyz=\"0 0 {}\"/><geometry><box size=\"{length} {width} {}\"/></geometry>",
        0.5 * (low + high),
        high - low
    );
    let _ = writeln!(
        out,
        "  <link name=\"{}\">\n    <visual>{shape}</visual>\n    <collision>{shape}</collision>\n  </link>",
        frame::BASE
    );
    let axles = (vehicle.wheels / 2).max(1);
    for wheel in 0..vehicle.wheels {
        let along = if axles > 1 { 0.5 - f64::from(wheel / 2) / f64::from(axles - 1) } else { 0.0 };
        let left = if wheel % 2 == 0 { 0.5 } else { -0.5 };
        let joint = wheel_joint(wheel as usize);
        let _ = writeln!(
            out,
            "  <link name=\"wheel_{wheel}\">\n    <visual><origin rpy=\"1.5707963267948966 0 0\"/><geometry><cylinder \
             radius=\"{wheel_radius}\" length=\"{}\"/></geometry></visual>\n  </link>\n  <joint name=\"{joint}\" \
             type=\"continuous\"><parent link=\"{}\"/><child link=\"wheel_{wheel}\"/><origin xyz=\"{} {} 0\"/><axis xyz=\"0 1 0\"/></joint>",
            0.5 * wheel_radius,
            frame::BASE,
            along * wheelbase,
            left * track,
        );
    }
    fixed(&mut out, frame::BASE, frame::IMU, &Mount::default());
    fixed(&mut out, frame::BASE, frame::GNSS, &Mount::default());
    if let Some(lidar) = lidar {
        fixed(&mut out, frame::BASE, frame::LIDAR, &lidar.mount);
    }
    if let Some(depth) = depth {
        fixed(&mut out, frame::BASE, frame::CAMERA, &depth.mount);
        let quarter = std::f64::consts::FRAC_PI_2;
        fixed(
            &mut out,
            frame::CAMERA,
            frame::OPTICAL,
            &Mount { roll: -quarter, yaw: -quarter, ..Mount::default() },
        );
    }
    out.push_str("</robot>\n");
    out
}

/// A frame that is fixed to another one.
fn fixed(out: &mut String, parent: &str, child: &str, mount: &Mount) {
    let Mount { position, roll, pitch, yaw } = mount;
    let _ = writeln!(
        out,
        "  <link name=\"{child}\"/>\n  <joint name=\"{child}_joint\" type=\"fixed\"><parent link=\"{parent}\"/><child \
         link=\"{child}\"/><origin xyz=\"{} {} {}\" rpy=\"{roll} {pitch} {yaw}\"/></joint>",
        position.x, position.y, position.z,
    );
}

/// A text within an attribute.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wheels_stand_on_the_axles_and_the_hull_between_belly_and_roof() {
        let vehicle = Vehicle {
            name: "a\"<b>".into(),
            length: 4.0,
            width: 2.0,
            height: 1.75,
            wheelbase: 3.0,
            track: 1.5,
            wheel_radius: 0.5,
            wheels: 4,
            ground_clearance: 0.25,
            ..Vehicle::default()
        };
        let text = description(&vehicle, Some(&LidarInfo::default()), None);
        assert!(text.contains("<robot name=\"a&quot;&lt;b>\">"), "{text}");
        // The belly is 0.25 m below the wheel centres and the roof 1.25 m above them.
        assert!(text.contains("<origin xyz=\"0 0 0.5\"/><geometry><box size=\"4 2 1.5\"/>"), "{text}");
        for wheel in ["1.5 0.75 0", "1.5 -0.75 0", "-1.5 0.75 0", "-1.5 -0.75 0"] {
            assert!(
                text.contains(&format!("<origin xyz=\"{wheel}\"/><axis xyz=\"0 1 0\"/>")),
                "{wheel}: {text}"
            );
        }
        assert!(text.contains("link=\"lidar_link\"") && !text.contains("camera_link"), "{text}");
    }
}
