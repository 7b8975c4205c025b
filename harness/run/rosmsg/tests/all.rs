//! Promises on definitions, type hashes and encoding.
#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

use std::path::Path;

use vb_rosmsg::idl::Definitions;
use vb_rosmsg::messages::{geometry_msgs, nav_msgs, rosgraph_msgs, sensor_msgs, std_msgs};
use vb_rosmsg::{Array, CdrError, Message, from_cdr, to_cdr};

/// Type hashes. That of `std_msgs/msg/String` is the published example of REP 2016. All others are those of ROS 2 Jazzy as `rosbags`
/// 0.11.9 computes them from its own definitions, and for `ackermann_msgs` and `grid_map_msgs` from theirs.
const HASHES: [(&str, &str); 37] = [
    ("ackermann_msgs/msg/AckermannDrive", "acf287a224a947dd1b0b87d6d76cdb73f497b0237b8fc73be2173b2ebbb82c99"),
    (
        "ackermann_msgs/msg/AckermannDriveStamped",
        "48ca7612a08d3bb72744fd98b71b7cf2ea24c6ad50fa4e1aa0bbad963c90d8cf",
    ),
    ("builtin_interfaces/msg/Time", "b106235e25a4c5ed35098aa0a61a3ee9c9b18d197f398b0e4206cea9acf9c197"),
    ("geometry_msgs/msg/Point", "6963084842a9b04494d6b2941d11444708d892da2f4b09843b9c43f42a7f6881"),
    ("geometry_msgs/msg/Pose", "d501954e9476cea2996984e812054b68026ae0bfae789d9a10b23daf35cc90fa"),
    ("geometry_msgs/msg/PoseStamped", "10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8"),
    (
        "geometry_msgs/msg/PoseWithCovariance",
        "9a7c0fd234b7f45c6098745ecccd773ca1085670e64107135397aee31c02e1bb",
    ),
    ("geometry_msgs/msg/Quaternion", "8a765f66778c8ff7c8ab94afcc590a2ed5325a1d9a076ffff38fbce36f458684"),
    ("geometry_msgs/msg/Transform", "beb83fbe698636351461f6f35d1abb20010c43d55374d81bd041f1ba2581fddc"),
    (
        "geometry_msgs/msg/TransformStamped",
        "0a241f87d04668d94099cbb5ba11691d5ad32c2f29682e4eb5653424bd275206",
    ),
    ("geometry_msgs/msg/Twist", "9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"),
    ("geometry_msgs/msg/TwistStamped", "5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64"),
    (
        "geometry_msgs/msg/TwistWithCovariance",
        "49f574f033f095d8b6cd1beaca5ca7925e296e84af1716d16c89d38b059c8c18",
    ),
    ("geometry_msgs/msg/Vector3", "cc12fe83e4c02719f1ce8070bfd14aecd40f75a96696a67a2a1f37f7dbb0765d"),
    ("grid_map_msgs/msg/GridMap", "343b0e72887541beda6b035cc053f2d6fffaad9d6dcb2773c15a808dfca31fde"),
    ("grid_map_msgs/msg/GridMapInfo", "0a36d6b5bc9af8463d1d5a5008ef9fcac0c1373ba090f80c3594e47cc565b745"),
    ("nav_msgs/msg/MapMetaData", "2772d4b2000ef2b35dbaeb80fd3946c1369f817fb4f75677d916d27c17d763c8"),
    ("nav_msgs/msg/OccupancyGrid", "8d348150c12913a31ee0ec170fbf25089e4745d17035792a1ba94d6f0bc0cfc7"),
    ("nav_msgs/msg/Odometry", "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0"),
    ("nav_msgs/msg/Path", "1957a5bb3cee5da65c4e52e52b65a93df227efce4c20f8458b36e73066ca334b"),
    ("rosgraph_msgs/msg/Clock", "692f7a66e93a3c83e71765d033b60349ba68023a8c689a79e48078bcb5c58564"),
    ("sensor_msgs/msg/CameraInfo", "b3dfd68ff46c9d56c80fd3bd4ed22c7a4ddce8c8348f2f59c299e73118e7e275"),
    ("sensor_msgs/msg/Image", "d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47"),
    ("sensor_msgs/msg/Imu", "7d9a00ff131080897a5ec7e26e315954b8eae3353c3f995c55faf71574000b5b"),
    ("sensor_msgs/msg/JointState", "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"),
    ("sensor_msgs/msg/NavSatFix", "62223ab3fe210a15976021da7afddc9e200dc9ec75231c1b6a557fc598a65404"),
    ("sensor_msgs/msg/NavSatStatus", "d1ed3befa628e09571bd273b888ba1c1fd187c9a5e0006b385d7e5e9095a3204"),
    ("sensor_msgs/msg/PointCloud2", "9198cabf7da3796ae6fe19c4cb3bdd3525492988c70522628af5daa124bae2b5"),
    ("sensor_msgs/msg/PointField", "5c6a4750728c2bcfbbf7037225b20b02d4429634732146b742dee1726637ef01"),
    ("sensor_msgs/msg/RegionOfInterest", "ad16bcba5f9131dcdba6fbded19f726f5440e3c513b4fb586dd3027eeed8abb1"),
    ("std_msgs/msg/Float32MultiArray", "0599f6f85b4bfca379873a0b4375a0aca022156bd2d7021275d116ed1fa8bfe0"),
    ("std_msgs/msg/Header", "f49fb3ae2cf070f793645ff749683ac6b06203e41c891e17701b1cb597ce6a01"),
    ("std_msgs/msg/Int8", "26525065a403d972cb672f0777e333f0c799ad444ae5fcd79e43d1e73bd0f440"),
    ("std_msgs/msg/MultiArrayDimension", "5e773a60a4c7fc8a54985f307c7837aa2994252a126c301957a24e31282c9cbe"),
    ("std_msgs/msg/MultiArrayLayout", "4c66e6f78e740ac103a94cf63259f968e48c617e7699e829b63c21a5cb50dac6"),
    ("std_msgs/msg/String", "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"),
    ("tf2_msgs/msg/TFMessage", "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"),
];

fn definitions() -> Definitions {
    Definitions::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("msg")).unwrap()
}

#[test]
fn type_hashes_are_those_of_ros_2_jazzy() {
    let all = definitions();
    let found: Vec<(String, String)> =
        all.names().map(|name| (name.to_owned(), all.hash(name).unwrap())).collect();
    let wanted: Vec<(String, String)> =
        HASHES.iter().map(|(name, digits)| ((*name).to_owned(), format!("RIHS01_{digits}"))).collect();
    assert_eq!(found, wanted);
    assert_eq!(<geometry_msgs::Twist as Message>::HASH, format!("RIHS01_{}", HASHES[10].1));
}

#[test]
fn the_types_are_generated_from_the_definitions() {
    let wanted = definitions().rust().unwrap();
    assert!(
        include_str!("../src/messages.rs") == wanted,
        "src/messages.rs is out of date: cargo run --package vb-rosmsg --example generate"
    );
}

#[test]
fn a_definition_has_those_of_the_types_that_it_names() {
    let text = <geometry_msgs::TwistStamped as Message>::DEFINITION;
    let line = "=".repeat(80);
    let parts: Vec<&str> = text.split(&format!("{line}\n")).collect();
    assert_eq!(parts[0], "std_msgs/Header header\ngeometry_msgs/Twist twist\n");
    assert_eq!(parts[1], "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n");
    assert_eq!(parts.len(), 5);
}

/// Bytes written by hand from the rules of CDR (CORBA 3.4, 9.3): numbers lie at multiples of their size from the end of the header, texts
/// have their length with the final 0, sequences their number of elements.
#[test]
fn messages_are_encoded_as_cdr() {
    let clock = rosgraph_msgs::Clock { clock: vb_rosmsg::convert::ros_time(1_500_000_000) };
    let bytes = [0, 1, 0, 0, 1, 0, 0, 0, 0x00, 0x65, 0xcd, 0x1d];
    assert_eq!(to_cdr(&clock).unwrap(), bytes);
    assert_eq!(from_cdr::<rosgraph_msgs::Clock>(&bytes).unwrap(), clock);
    let big = [0, 0, 0, 0, 0, 0, 0, 1, 0x1d, 0xcd, 0x65, 0x00];
    assert_eq!(from_cdr::<rosgraph_msgs::Clock>(&big).unwrap(), clock);

    let text = std_msgs::String { data: "abc".into() };
    assert_eq!(to_cdr(&text).unwrap(), [0, 1, 0, 0, 4, 0, 0, 0, b'a', b'b', b'c', 0]);

    // Seconds, nanoseconds, length 2 and "m\0", two bytes to the next multiple of 4, then height and width.
    let image = sensor_msgs::Image {
        header: vb_rosmsg::convert::header(0, "m"),
        height: 2,
        data: vec![7, 8],
        ..Default::default()
    };
    let bytes = to_cdr(&image).unwrap();
    assert_eq!(bytes[4..24], [0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, b'm', 0, 0, 0, 2, 0, 0, 0]);
    assert_eq!(bytes[bytes.len() - 6..], [2, 0, 0, 0, 7, 8]);
    assert_eq!(from_cdr::<sensor_msgs::Image>(&bytes).unwrap(), image);
}

#[test]
fn arrays_have_no_length_and_come_back() {
    let mut odometry = nav_msgs::Odometry::default();
    odometry.pose.covariance = Array([0.25; 36]);
    odometry.twist.twist.angular.z = -1.5;
    let bytes = to_cdr(&odometry).unwrap();
    // Header of CDR, time, two empty texts of 5 bytes with 3 of padding, 7 + 36 + 6 + 36 numbers of 8 bytes from a multiple of 8.
    assert_eq!(bytes.len(), 4 + 8 + 2 * 8 + 85 * 8);
    assert_eq!(from_cdr::<nav_msgs::Odometry>(&bytes).unwrap(), odometry);
}

#[test]
fn bytes_that_are_no_message_are_refused() {
    let read = |bytes: &[u8]| from_cdr::<geometry_msgs::TwistStamped>(bytes).unwrap_err();
    assert_eq!(read(&[0, 1]), CdrError::Short(2));
    assert_eq!(read(&[0, 7, 0, 0, 1]), CdrError::Encoding(0, 7));
    assert!(matches!(read(&[0, 1, 0, 0, 1]), CdrError::Malformed(_)));
    // A text that claims four gigabytes.
    let huge = [0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255, b'a'];
    assert!(matches!(read(&huge), CdrError::Malformed(_)));
    let sequence = [0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255];
    assert!(from_cdr::<nav_msgs::Path>(&sequence).is_err());
}
