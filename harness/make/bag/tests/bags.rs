//! Bags whose drives follow from theory.
#![allow(clippy::unwrap_used, reason = "helpers of tests may panic")]

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use mcap::{WriteOptions, Writer};
use vb_bag::{BagError, Drive, Selection, Wheels, read};
use vb_rosmsg::convert::{header, odometry, seconds};
use vb_rosmsg::messages::geometry_msgs::{Twist, TwistStamped, Vector3};
use vb_rosmsg::messages::nav_msgs::Odometry;
use vb_rosmsg::messages::sensor_msgs::{Imu, JointState};
use vb_rosmsg::{Message, to_cdr};
use vb_sdk::{Pose, Vec3};
use vb_validate::Recording;

/// A drive on a circle: radius, m, and yaw rate, rad/s.
const CIRCLE: f64 = 5.0;
const RATE: f64 = 0.4;
const WHEELS: Wheels = Wheels { radius: 0.2, track: 0.5 };
/// Recorded times begin here, s; stamps as well.
const EPOCH: f64 = 1_700_000_000.0;

/// A bag that is written.
struct Bag {
    folder: tempfile::TempDir,
    writer: Writer<BufWriter<File>>,
    channels: BTreeMap<String, u16>,
}

impl Bag {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = BufWriter::new(File::create(folder.path().join("drive.mcap")).unwrap());
        let writer = WriteOptions::new().compression(None).profile("ros2").create(file).unwrap();
        Self { folder, writer, channels: BTreeMap::new() }
    }

    /// Writes a message that was recorded at a time, s.
    fn put<M: Message>(&mut self, topic: &str, time: f64, message: &M) {
        let id = *self.channels.entry(topic.to_owned()).or_insert_with(|| {
            let schema = self.writer.add_schema(M::NAME, "ros2msg", M::DEFINITION.as_bytes()).unwrap();
            self.writer.add_channel(schema, topic, "cdr", &BTreeMap::new()).unwrap()
        });
        let log_time = u64::try_from(seconds(EPOCH + time)).unwrap();
        let known =
            mcap::records::MessageHeader { channel_id: id, sequence: 0, log_time, publish_time: log_time };
        self.writer.write_to_known_channel(&known, &to_cdr(message).unwrap()).unwrap();
    }

    fn odometry(&mut self, topic: &str, time: f64, stamp: i64) {
        let [x, y, yaw] = place(time);
        let position = Vec3 { x, y, z: 0.3 };
        self.put(topic, time, &odometry(stamp, &Pose { position, yaw, ..Pose::default() }));
    }

    fn finish(mut self) -> (tempfile::TempDir, PathBuf) {
        self.writer.finish().unwrap();
        let path = self.folder.path().join("drive.mcap");
        (self.folder, path)
    }
}

/// The pose on the circle at a time: x and y, m, and yaw, rad.
fn place(time: f64) -> [f64; 3] {
    let yaw = RATE * time;
    let (sin, cos) = vb_math::sin_cos(yaw);
    [CIRCLE * sin, CIRCLE * (1.0 - cos), yaw]
}

fn now(time: f64) -> i64 {
    seconds(EPOCH + time)
}

fn twist(linear: f64, angular: f64) -> Twist {
    Twist {
        linear: Vector3 { x: linear, ..Vector3::default() },
        angular: Vector3 { z: angular, ..Vector3::default() },
    }
}

fn joints(time: f64, left: f64, right: f64) -> JointState {
    JointState {
        header: header(now(time), ""),
        name: ["front_left_wheel", "front_right_wheel"].map(str::to_owned).into(),
        velocity: vec![left, right],
        ..JointState::default()
    }
}

/// Times between 0 and `end` s at a frequency, Hz.
fn at(end: f64, frequency: f64) -> impl Iterator<Item = f64> {
    (0..=(end * frequency) as u32).map(move |k| f64::from(k) / frequency)
}

fn selection() -> Selection {
    Selection { window: 2.0, ..Selection::default() }
}

/// The rows of a drive: window, then time, left, right, x, y, yaw.
fn rows(drive: &Drive) -> Vec<(String, [f64; 6])> {
    let csv = drive.csv();
    // The recording can be replayed.
    Recording::parse(&csv, "drive.csv").unwrap();
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("window,time,left,right,x,y,yaw"));
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        (cells[0].to_owned(), std::array::from_fn(|k| cells[k + 1].parse().unwrap()))
    };
    lines.map(row).collect()
}

/// That a pose is on the circle at a time, m and rad.
fn on_circle(time: f64, pose: &[f64]) {
    let wanted = place(time);
    for (found, wanted) in pose.iter().zip(wanted) {
        // The sagitta of a chord of 50 ms is 0.4 mm.
        assert!((found - wanted).abs() < 1e-3, "{time} s: {pose:?}");
    }
}

#[test]
fn wheel_speeds_and_poses_are_those_of_the_drive() {
    let mut bag = Bag::new();
    for t in at(5.0, 20.0) {
        bag.odometry("/odom", t, now(t));
    }
    for t in at(5.0, 50.0) {
        bag.put("/joint_states", t, &joints(t, 1.0 + t, 2.0 + t));
        // Another joint state is no wheel speed, and commands count only without wheel speeds.
        let arm = JointState { name: vec!["arm".into()], velocity: vec![9.0], ..JointState::default() };
        bag.put("/arm", t, &arm);
        bag.put("/cmd_vel", t, &twist(9.0, 9.0));
    }
    let (_folder, path) = bag.finish();
    let drive = read(&path).unwrap().drive(&selection(), WHEELS).unwrap();
    assert_eq!((drive.odometry.as_str(), drive.speeds.as_str()), ("/odom", "/joint_states"));
    assert!(!drive.is_commanded && drive.gaps == 0 && (drive.duration - 5.0).abs() < 1e-6);
    let rows = rows(&drive);
    // Two windows of 2 s in 5 s, with a row each 50 ms and one at the end.
    assert_eq!((drive.windows(), rows.len()), (2, 82));
    assert_eq!((rows[40].0.as_str(), rows[41].0.as_str()), ("w0001", "w0002"));
    for (k, (_, [time, left, right, pose @ ..])) in rows.iter().enumerate() {
        let wanted = if k < 41 { 0.05 * k as f64 } else { 2.0 + 0.05 * (k - 41) as f64 };
        assert!((time - wanted).abs() < 1e-4, "{k}: {time}");
        assert!(
            (left - 1.0 - wanted).abs() < 1e-6 && (right - 2.0 - wanted).abs() < 1e-6,
            "{k}: {left} {right}"
        );
        on_circle(wanted, pose);
    }
}

#[test]
fn commands_become_speeds_of_wheels_that_roll_without_slip() {
    let mut bag = Bag::new();
    for t in at(4.0, 10.0) {
        bag.odometry("/odom", t, now(t));
        // From 2 s on, another velocity.
        let command = if t < 2.0 { twist(1.0, 0.8) } else { twist(0.5, 0.0) };
        bag.put("/cmd_vel", t, &TwistStamped { header: header(now(t), "base_link"), twist: command });
    }
    let (_folder, path) = bag.finish();
    let drive = read(&path).unwrap().drive(&selection(), WHEELS).unwrap();
    assert!(drive.is_commanded);
    for (_, [time, left, right, ..]) in rows(&drive) {
        // (1 ∓ 0.8 · 0.25) / 0.2 and 0.5 / 0.2; a command holds until the next.
        let wanted = if time < 1.999 { [4.0, 6.0] } else { [2.5, 2.5] };
        assert!(
            (left - wanted[0]).abs() < 1e-6 && (right - wanted[1]).abs() < 1e-6,
            "{time}: {left} {right}"
        );
    }
}

#[test]
fn the_heading_of_an_inertial_sensor_replaces_that_of_the_odometry_within_a_window() {
    let mut bag = Bag::new();
    for t in at(4.0, 20.0) {
        bag.odometry("/odom", t, now(t));
        bag.put("/joint_states", t, &joints(t, 1.0, 1.0));
    }
    for t in at(4.0, 100.0) {
        let mut imu = Imu { header: header(now(t), "imu_link"), ..Imu::default() };
        // The integral over 2 s is 0.1 · 2² / 2 = 0.2 rad, and 0.6 rad from 2 s to 4 s.
        imu.angular_velocity.z = 0.1 * t;
        bag.put("/imu/data", t, &imu);
    }
    let (_folder, path) = bag.finish();
    let bag = read(&path).unwrap();
    let drive = bag.drive(&Selection { imu: Some("/imu/data".into()), ..selection() }, WHEELS).unwrap();
    let rows = rows(&drive);
    let turned = |window: usize| rows[41 * window + 40].1[5] - rows[41 * window].1[5];
    assert!((turned(0) - 0.2).abs() < 1e-4 && (turned(1) - 0.6).abs() < 1e-4, "{} {}", turned(0), turned(1));
    // Each window begins with the heading of the odometry.
    assert!((rows[41].1[5] - RATE * 2.0).abs() < 1e-6);
}

#[test]
fn no_window_contains_a_pause() {
    let mut bag = Bag::new();
    // Odometry is missing from 3 s to 4.5 s.
    for t in at(9.0, 20.0).filter(|t| !(3.01..4.49).contains(t)) {
        bag.odometry("/odom", t, now(t));
    }
    for t in at(9.0, 20.0) {
        bag.put("/joint_states", t, &joints(t, 1.0, 1.0));
    }
    let (_folder, path) = bag.finish();
    let drive = read(&path).unwrap().drive(&selection(), WHEELS).unwrap();
    let rows = rows(&drive);
    let starts: Vec<f64> = rows.iter().step_by(41).map(|row| row.1[0]).collect();
    assert_eq!((drive.gaps, starts), (1, vec![0.0, 4.5, 6.5]));
    rows.iter().for_each(|(_, [time, _, _, pose @ ..])| {
        if *time < 7.8 {
            on_circle(*time, pose);
        }
    });
}

#[test]
fn without_stamps_the_times_of_recording_count() {
    let mut bag = Bag::new();
    for t in at(2.0, 20.0) {
        // The clock of the odometry is an hour ahead.
        bag.odometry("/odom", t, now(t + 3600.0));
        bag.put("/cmd_vel", t, &twist(1.0, 0.0));
    }
    let (_folder, path) = bag.finish();
    let drive = read(&path).unwrap().drive(&selection(), WHEELS).unwrap();
    assert_eq!(drive.windows(), 1);
    on_circle(1.0, &rows(&drive)[20].1[3..]);
}

#[test]
fn messages_without_numbers_are_skipped_and_counted() {
    let mut bag = Bag::new();
    for t in at(2.0, 20.0) {
        bag.odometry("/odom", t, now(t));
        bag.put("/joint_states", t, &joints(t, 1.0, 1.0));
    }
    bag.put("/joint_states", 1.01, &joints(1.01, f64::NAN, 1.0));
    bag.put("/odom", 1.01, &Odometry { header: header(now(1.01), "odom"), ..Odometry::default() });
    let (_folder, path) = bag.finish();
    let bag = read(&path).unwrap();
    // A default quaternion of Rust is 0, 0, 0, 0.
    assert_eq!(bag.skipped().collect::<Vec<_>>(), [("/joint_states", 1), ("/odom", 1)]);
    for (_, [time, left, _, pose @ ..]) in rows(&bag.drive(&selection(), WHEELS).unwrap()) {
        assert_eq!(left, 1.0);
        on_circle(time, &pose);
    }
}

#[test]
fn a_topic_that_is_missing_or_ambiguous_is_named() {
    let mut bag = Bag::new();
    for t in at(3.0, 20.0) {
        bag.odometry("/odom", t, now(t));
        bag.odometry("/odometry/filtered", t, now(t));
        bag.put("/joint_states", t, &joints(t, 1.0, 1.0));
    }
    let (_folder, path) = bag.finish();
    let bag = read(&path).unwrap();
    let says = |selection: Selection| bag.drive(&selection, WHEELS).unwrap_err().to_string();
    assert_eq!(
        says(selection()),
        "the bag has several topics of nav_msgs/msg/Odometry: /odom, /odometry/filtered; choose one with --odometry"
    );
    let odometry = Some("/odom".to_owned());
    assert_eq!(
        says(Selection { odometry: Some("/x".into()), ..selection() }),
        "--odometry /x: no topic of nav_msgs/msg/Odometry with this name; the bag has /odom, /odometry/filtered"
    );
    assert_eq!(
        says(Selection { odometry: odometry.clone(), imu: Some("/imu".into()), ..selection() }),
        "the bag has no messages of sensor_msgs/msg/Imu"
    );
    assert_eq!(
        says(Selection { odometry: odometry.clone(), window: 4.0, ..selection() }),
        "no window of 4 s: /odom and /joint_states overlap for 3.0 s, with 0 pauses longer than 0.5 s"
    );
    assert_eq!(
        says(Selection { odometry: odometry.clone(), window: 0.0, ..selection() }),
        "window 0 s: must lie in 0.2 to 600 s"
    );
    let drive = bag.drive(&Selection { odometry, ..selection() }, WHEELS).unwrap();
    assert_eq!(drive.windows(), 1);
}

#[test]
fn what_is_no_bag_is_refused_with_the_next_step() {
    let folder = tempfile::tempdir().unwrap();
    let says = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let e = read(&path).unwrap_err();
        let text = e.to_string();
        assert!(text.starts_with(&path.display().to_string()) && !text.contains('\n'), "{text}");
        text
    };
    assert!(says("a.db3", b"SQLite format 3\0....").contains("ros2 bag convert"));
    assert!(says("b.bag", b"#ROSBAG V2.0\n.......").contains("is a ROS 1 bag"));
    assert!(says("c.mcap", b"window,time,left,right").ends_with("is not an MCAP file"));
    assert!(says("d.mcap", b"").contains("is truncated"));
    assert!(matches!(read(&folder.path().join("none")), Err(BagError::Read { .. })));
    let empty = tempfile::tempdir().unwrap();
    assert!(read(empty.path()).unwrap_err().to_string().contains("contains no MCAP file"));
    std::fs::write(empty.path().join("x.db3"), b"").unwrap();
    assert!(read(empty.path()).unwrap_err().to_string().contains("SQLite"));

    // A bag that was cut, and one whose bytes changed.
    let mut bag = Bag::new();
    for t in at(3.0, 20.0) {
        bag.odometry("/odom", t, now(t));
    }
    let (_folder, path) = bag.finish();
    let bytes = std::fs::read(&path).unwrap();
    assert!(says("cut.mcap", &bytes[..bytes.len() / 2]).contains("mcap recover"));
    let mut seed = 1_u64;
    for _ in 0..300 {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mut damaged = bytes.clone();
        let place = (seed >> 33) as usize % damaged.len();
        damaged[place] ^= (seed >> 25) as u8 | 1;
        let path = folder.path().join("damaged.mcap");
        std::fs::write(&path, damaged).unwrap();
        // Either is right: nothing panics, and no message is longer than a line.
        if let Err(e) = read(&path) {
            assert!(!e.to_string().contains('\n'), "{e}");
        }
    }
}

#[test]
fn a_message_of_another_type_than_its_topic_is_named() {
    let mut bag = Bag::new();
    let schema = bag.writer.add_schema("nav_msgs/msg/Odometry", "ros2msg", b"").unwrap();
    let id = bag.writer.add_channel(schema, "/odom", "cdr", &BTreeMap::new()).unwrap();
    bag.channels.insert("/odom".into(), id);
    bag.put("/odom", 0.0, &twist(1.0, 0.0));
    let (_folder, path) = bag.finish();
    let e = read(&path).unwrap_err().to_string();
    assert!(e.contains("a message on /odom can't be decoded as nav_msgs/msg/Odometry: "), "{e}");
}

/// A bag that rosbags wrote, an independent implementation; skips the test without.
fn written_by_rosbags(folder: &Path, compression: &str) -> Option<PathBuf> {
    let program = std::env::var("VB_PYTHON").unwrap_or_else(|_| "python3".into());
    let python = || {
        let mut python = std::process::Command::new(&program);
        if let Some(libraries) = std::env::var_os("VB_PYTHON_LIBS") {
            python.env("PYTHONPATH", libraries);
        }
        python
    };
    let found = python().args(["-c", "import rosbags.rosbag2"]).output();
    if !found.is_ok_and(|output| output.status.success()) {
        vb_testing::skip(format_args!(
            "{program} lacks rosbags (pip install rosbags, or set VB_PYTHON or VB_PYTHON_LIBS)"
        ));
        return None;
    }
    let bag = folder.join(format!("bag-{compression}"));
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/write.py");
    let output = python().arg(script).arg(&bag).arg(compression).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(bag)
}

#[test]
fn bags_of_another_writer_are_read_with_and_without_compression() {
    let folder = tempfile::tempdir().unwrap();
    for compression in ["none", "zstd"] {
        let Some(path) = written_by_rosbags(folder.path(), compression) else { return };
        let drive = read(&path).unwrap().drive(&selection(), WHEELS).unwrap();
        let rows = rows(&drive);
        assert_eq!((drive.windows(), rows.len()), (2, 82), "{compression}");
        for (_, [time, left, right, pose @ ..]) in &rows {
            assert!((left - 3.0).abs() < 1e-6 && (right - 4.0).abs() < 1e-6, "{compression}: {left} {right}");
            on_circle(*time, pose);
        }
    }
}
