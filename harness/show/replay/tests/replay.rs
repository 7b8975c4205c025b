//! Replays of a drive that the test itself makes, on soil that yields.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use foxglove::Decode as _;
use foxglove::messages::{FrameTransforms, Grid, Log, Odometry, PointCloud, RawImage, SceneUpdate};
use sha2::{Digest as _, Sha256};
use vb_record::{DebugEntry, Sample, TRACE_SCHEMA, Trace, TraceMeta, TraceMode, TraceRecorder, WheelSample};
use vb_replay::{
    Link, Links, Motion, PlannerSeries, Repeat, Replay, ReplayRun, Sensed, Sensors, Setting, page,
    write_mcap, write_ros2_mcap,
};
use vb_score::{Cause, Outcome, Rules, TaskRecord};
use vb_sdk::metadata::Need;
use vb_sense::{Perception, Profile, Readings, Seed, Truth};
use vb_sim::{Controls, SimOptions, Simulation, SoilSet, StateHash};
use vb_vehicle::{VehicleModel, VehicleSpec};
use vb_world::{Heightfield, Obstacle, ObstacleKind, Pose2, Task, TerrainClass, World};

const HOSTILE: &str = "</script><script>document.title='owned'</script><img src=x onerror=alert(1)>";

fn data(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tasks").join(file)
}

struct Drive {
    world: Arc<World>,
    task: Task,
    vehicle: VehicleModel,
    soils: SoilSet,
    trace: Trace,
    hash: String,
}

impl Drive {
    /// Four seconds on mud, full throttle in a bend from the first second on.
    fn new(mode: TraceMode) -> Self {
        let text = std::fs::read_to_string(data("vehicles/hmmwv.yaml")).unwrap();
        let vehicle = VehicleModel::new(VehicleSpec::parse(&text, "hmmwv").unwrap()).unwrap();
        let text = std::fs::read_to_string(data("soils/default.yaml")).unwrap();
        let soils = SoilSet::parse(&text, "default").unwrap();
        let mut world = World::uniform("w001", Heightfield::flat(65, 65, 1.0, 0.0), TerrainClass::Mud, 0.5);
        let kind = ObstacleKind::Boulder { size: [2.0, 2.0, 2.0], seed: 1 };
        world.obstacles.push(Obstacle { x: 20.0, y: 20.0, yaw: 0.3, buried: 1.0, kind });
        let start = Pose2 { x: -20.0, y: 0.0, yaw: 0.0 };
        let task = Task { id: "t00".into(), start, goal: [20.0, 0.0], path: vec![[-20.0, 0.0], [20.0, 0.0]] };
        let world = Arc::new(world);
        let mut sim = Simulation::new(world.clone(), &vehicle, &soils, start, SimOptions::default()).unwrap();
        let mut recorder = TraceRecorder::new(mode, 4);
        let mut hash = StateHash::default();
        let mut controls = Controls::default();
        for k in 0..=400 {
            if k > 0 {
                if (k - 1) % 10 == 0 {
                    let steering = if k > 100 { 0.1 + 0.001 * f64::from(k) } else { 0.0 };
                    controls = Controls { steering, throttle: 1.0, ..Controls::default() };
                }
                sim.advance(controls, 10).unwrap();
            }
            sim.visit_state(|x| hash.push(x));
            let state = sim.state();
            let (roll, pitch, yaw) = state.roll_pitch_yaw();
            let sample = Sample {
                time: state.time,
                x: state.position.x,
                y: state.position.y,
                z: state.position.z,
                roll,
                pitch,
                yaw,
                vx: state.velocity_body.x,
                steering: controls.steering,
                throttle: controls.throttle,
                ..Sample::default()
            };
            let wheels: Vec<WheelSample> = state
                .wheels
                .iter()
                .map(|w| WheelSample { speed: w.speed, deflection: w.deflection })
                .collect();
            recorder.push(&sample, &wheels);
        }
        let trace = recorder
            .finish(TraceMeta {
                schema: TRACE_SCHEMA,
                task: "w001/t00".parse().unwrap(),
                start: [start.x, start.y, start.yaw],
                goal: task.goal,
                goal_z: 0.0,
                half_extent: [32.0, 32.0],
                scale: 1.0,
                max_speed: 30.0,
                time_step: 0.001,
                sample_period: 0.01,
                mode,
            })
            .unwrap();
        Self { world, task, vehicle, soils, trace, hash: hash.hex() }
    }

    fn repeated(&self, hash: &str) -> Option<Motion> {
        let setting = Setting {
            world: &self.world,
            task: &self.task,
            vehicle: &self.vehicle,
            soils: &self.soils,
            options: SimOptions::default(),
        };
        Motion::repeated(&self.trace, &setting, None, hash).map(|(motion, _)| motion)
    }

    /// The sensors that it drives with here.
    fn perception(&self, profile: &str) -> Perception {
        let needs: Vec<Need> = ["pose", "lidar 10", "depth 5", "local-map 5", "gnss", "imu 50"]
            .map(|n| Need::parse(n).unwrap())
            .into();
        let profile = Profile::built_in(profile).unwrap();
        let seed = Seed { run: 3, task: "w001/t00".into() };
        let scene = Sensors::scene(&self.world);
        Perception::new(&profile, &needs, &scene, self.vehicle.spec(), &seed).unwrap()
    }

    /// What these sensors measure when the simulation is repeated.
    fn sensed(&self, profile: &str) -> Sensed {
        let setting = Setting {
            world: &self.world,
            task: &self.task,
            vehicle: &self.vehicle,
            soils: &self.soils,
            options: SimOptions::default(),
        };
        let sensors = Sensors { perception: self.perception(profile) };
        Motion::repeated(&self.trace, &setting, Some(sensors), &self.hash).unwrap().1
    }

    /// What a planner that looks ten times a second is told by them while it drives.
    fn told(&self, profile: &str) -> Vec<Readings> {
        let start = self.task.start;
        let mut sim =
            Simulation::new(self.world.clone(), &self.vehicle, &self.soils, start, SimOptions::default())
                .unwrap();
        let mut perception = self.perception(profile);
        let mut told = Vec::new();
        for k in 0..=400 {
            if k > 0 {
                // A sample has the command that was applied up to it, ten a second.
                let s = &self.trace.samples[usize::try_from((k + 9) / 10).unwrap()];
                let Sample { steering, throttle, .. } = *s;
                sim.advance(Controls { steering, throttle, ..Controls::default() }, 10).unwrap();
            }
            let state = sim.state();
            perception.sample(Truth { state: &state, ruts: Some(&sim) });
            if k % 10 == 0 {
                told.push(perception.read(&state));
            }
        }
        told
    }

    /// The simulation at its end.
    fn driven(&self) -> Simulation {
        let start = self.task.start;
        let mut sim =
            Simulation::new(self.world.clone(), &self.vehicle, &self.soils, start, SimOptions::default())
                .unwrap();
        for s in &self.trace.samples[1..] {
            let Sample { steering, throttle, .. } = *s;
            sim.advance(Controls { steering, throttle, ..Controls::default() }, 100).unwrap();
        }
        sim
    }

    fn replay(&self, label: &str) -> Replay {
        let record = TaskRecord {
            task: "w001/t00".parse().unwrap(),
            world: "w001".into(),
            elevation: self.world.elevation,
            terrain: self.world.terrain,
            density: self.world.density,
            outcome: Outcome::Stuck,
            three_way: Outcome::Stuck.three_way(false),
            flags: std::collections::BTreeMap::new(),
            departures: Vec::new(),
            reason: format!("it sank {label}"),
            cause: Some(Cause::SpinningOnSoil),
            evidence: format!("it dug {label}"),
            fault: Some(vb_sdk::fault::FaultCode::Panic),
            time_s: 4.0,
            state_hash: self.hash.clone(),
            sim_steps: 4000,
            planner_steps: 40,
            clamped: 0,
            fuel: None,
            metrics: None,
            ride: None,
            log: vec![label.into()],
            backtrace: Vec::new(),
        };
        let entry = |time, name: &str, values: &[f32]| DebugEntry {
            time,
            name: name.into(),
            values: values.to_vec(),
        };
        let series = PlannerSeries::new(vec![
            entry(0.0, "plan.xy", &[-20.0, 0.0, -10.0, 1.0, f32::NAN, f32::NAN, -20.0, 0.0, -10.0, -1.0]),
            entry(0.0, "plan.cost", &[1.0, 2.0]),
            entry(0.1, label, &[0.25]),
        ]);
        Replay {
            world: self.world.clone(),
            task: self.task.clone(),
            suite: label.into(),
            has_goal: true,
            goal_radius: Some(10.0),
            runs: vec![ReplayRun {
                label: label.into(),
                record,
                rules: Some(Rules::paper()),
                vehicle: Arc::new(self.vehicle.spec().clone()),
                motion: self.repeated(&self.hash).unwrap(),
                series,
                sensed: Sensed::default(),
            }],
        }
    }
}

#[test]
fn ten_samples_a_second_repeat_the_simulation_to_the_bit() {
    let drive = Drive::new(TraceMode::TenHz);
    assert_eq!(drive.trace.samples.len(), 41);
    let motion = drive.repeated(&drive.hash).expect("the same state hash");
    assert_eq!(motion.repeat, Repeat::Exact);
    assert_eq!(motion.frames.len(), 201, "fifty a second");
    for sample in &drive.trace.samples {
        let near = motion.frames.iter().find(|f| (f.time - sample.time).abs() < 1e-9).unwrap();
        assert_eq!((near.x.to_bits(), near.yaw.to_bits()), (sample.x.to_bits(), sample.yaw.to_bits()));
    }
    assert!(motion.ruts.len() > 100, "wheels leave ruts in mud: {}", motion.ruts.len());
    assert!(motion.ruts.is_sorted_by(|a, b| a.time <= b.time));
    assert!(drive.repeated("0000000000000000").is_none(), "another hash is another drive");
}

#[test]
fn ruts_end_as_the_simulation_leaves_them() {
    let drive = Drive::new(TraceMode::TenHz);
    let (motion, sim) = (drive.repeated(&drive.hash).unwrap(), drive.driven());
    assert_eq!(motion.soil_resolution, sim.soil_resolution());
    let cell = |at: [f64; 2]| at.map(|v| (v * 1000.0).round() as i64);
    // What is told last of a cell holds.
    let told: BTreeMap<[i64; 2], f64> = motion.ruts.iter().map(|r| (cell(r.at), r.change())).collect();
    let mut changed = 0;
    for (at, depth, raised) in sim.ruts() {
        let change = raised - depth;
        let shown = told.get(&cell(at)).copied().unwrap_or(0.0);
        assert!((shown - change).abs() < 0.005, "at {at:?}: {shown} m instead of {change} m");
        changed += usize::from(change.abs() >= 0.005);
    }
    assert!(changed > 100, "{changed}");
}

#[test]
fn wheels_are_told_with_load_slip_and_depth() {
    let drive = Drive::new(TraceMode::TenHz);
    let motion = drive.repeated(&drive.hash).unwrap();
    assert_eq!(motion.contacts.len(), motion.wheel_frames.len());
    let weight = drive.vehicle.spec().total_mass() * vb_vehicle::GRAVITY;
    // It stands at first: the ground bears it, and nothing turns.
    let first = &motion.contacts[..4];
    let load: f64 = first.iter().map(|c| c.load).sum();
    assert!((load / weight - 1.0).abs() < 0.01, "{load} N of {weight} N");
    // A millimetre a second is a hundredth of the slowest speed that slip refers to.
    assert!(first.iter().all(|c| c.slip.abs() < 0.02 && c.sinkage > 0.0), "{first:?}");
    // Full throttle on mud: all wheels are driven and spin, and no slip lies beyond what its definition allows.
    let after = &motion.contacts[4 * 50..4 * 100];
    assert!(after.iter().filter(|c| c.slip > 0.05).count() > after.len() / 2);
    assert!(motion.contacts.iter().all(|c| c.slip.abs() <= 2.0 && c.load >= 0.0));
    assert!(Motion::sampled(&drive.trace, Some(&drive.vehicle)).contacts.is_empty(), "samples don't tell");
}

/// The data of a page's script.
fn data_of(page: &str) -> serde_json::Value {
    let begin = page.find("id=\"data\">").unwrap() + "id=\"data\">".len();
    serde_json::from_str(&page[begin..begin + page[begin..].find("</script>").unwrap()]).unwrap()
}

#[test]
fn a_page_says_with_what_was_driven_and_by_which_rule_it_ended() {
    let data = data_of(&page(&Drive::new(TraceMode::TenHz).replay("pid"), &Links::default(), None));
    let facts = data["runs"][0]["facts"].as_array().unwrap();
    let said = |term: &str| facts.iter().find(|f| f[0] == term).map(|f| f[1].as_str().unwrap());
    assert_eq!(said("outcome"), Some("stuck"));
    assert_eq!(said("rule"), Some("moved less than 1 m within 10 s"));
    assert_eq!(said("reason"), Some("it sank pid"));
    assert_eq!((said("cause"), said("evidence")), (Some("spinning on soil"), Some("it dug pid")));
    assert_eq!(
        said("vehicle"),
        Some(
            "hmmwv: HMMWV M998, double wishbones all round, torque-biasing differentials, locked transfer case"
        )
    );
    assert_eq!(said("scale"), Some("1:1"));
    assert!(said("rules").unwrap().starts_with("paper: "));
    assert!(data["links"].as_object().unwrap().values().all(serde_json::Value::is_null), "it stands alone");
}

#[test]
fn replays_of_a_report_are_linked_in_their_order() {
    let tasks = ["w001/t00", "w001/t07", "w002/t01"].map(|t| t.parse().unwrap());
    let links = Links::of_report("index.html", &tasks);
    let link = |name: &str, href: &str| Some(Link { name: name.into(), href: href.into() });
    // As a browser takes them at replays/w001/t07.html.
    assert_eq!(links[1].report, link("report", "../../index.html#task=w001/t07"));
    assert_eq!(links[1].previous, link("w001/t00", "../w001/t00.html"));
    assert_eq!(links[1].next, link("w002/t01", "../w002/t01.html"));
    assert_eq!((&links[0].previous, &links[2].next), (&None, &None));
    assert!(Links::of_report("index.html", &[]).is_empty());
}

#[test]
fn a_drive_by_other_commands_is_not_taken_for_the_recorded_one() {
    let mut drive = Drive::new(TraceMode::TenHz);
    drive.trace.samples[20].throttle = 0.999;
    assert!(drive.repeated(&drive.hash.clone()).is_none());
}

#[test]
fn samples_alone_place_the_wheels_where_the_simulation_has_them() {
    let drive = Drive::new(TraceMode::Full);
    let exact = drive.repeated(&drive.hash).unwrap();
    let sampled = Motion::sampled(&drive.trace, Some(&drive.vehicle));
    assert_eq!((sampled.repeat, sampled.wheels, sampled.ruts.len()), (Repeat::Samples, 4, 0));
    assert_eq!(sampled.frames.len(), 401);
    for (k, frame) in exact.frames.iter().enumerate() {
        let other = 2 * k;
        assert_eq!(frame.time, sampled.frames[other].time);
        for w in 0..4 {
            let (a, b) = (exact.wheel_frames[4 * k + w], sampled.wheel_frames[4 * other + w]);
            for i in 0..3 {
                // The steering command is followed at a limited rate, which samples don't tell.
                assert!((a.hub[i] - b.hub[i]).abs() < 0.02, "wheel {w}: {a:?} {b:?}");
            }
            assert!((a.angle - b.angle).abs() < 1e-9);
        }
    }
    // Front wheels lie ahead of the rear ones, left ones to the left, and they have rolled forward.
    let last = &exact.wheel_frames[exact.wheel_frames.len() - 4..];
    assert!(last[0].hub[0] > last[2].hub[0] && last[0].hub[1] > last[1].hub[1]);
    assert!(last.iter().all(|w| w.axis[1] > 0.8 && w.angle > 1.0), "{last:?}");
}

#[test]
fn no_text_of_a_planner_becomes_markup() {
    let link = Some(Link { name: HOSTILE.into(), href: HOSTILE.into() });
    let links = Links { report: link.clone(), previous: link.clone(), next: link };
    let replay = Drive::new(TraceMode::TenHz).replay(HOSTILE);
    let beside = page(&replay, &links, Some("../replay.js"));
    let page = page(&replay, &links, None);
    assert_eq!(page.matches("<script").count(), 2, "its own");
    assert_eq!(page.matches("</script").count(), 2);
    assert!(!page.contains("<img") && page.contains("script-src 'sha256-"));
    // With its script beside it: the data, and the address.
    assert_eq!((beside.matches("<script").count(), beside.matches("</script").count()), (2, 2));
    assert!(
        !beside.contains("<img")
            && beside.contains("script-src 'nonce-")
            && beside.contains("src=\"../replay.js\"")
    );
    assert!(beside.contains("id=\"alone\"") && beside.len() + vb_replay::script().len() / 2 < page.len());
    assert!(!page.contains("http://") || page.matches("src=\"http").count() == 0, "no network");
}

#[test]
fn the_bundle_is_made_of_the_sources_beside_it() {
    let web = Path::new(env!("CARGO_MANIFEST_DIR")).join("web");
    let mut sources: Vec<PathBuf> = std::fs::read_dir(web.join("src"))
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.extension().is_some_and(|e| e == "js"))
        .collect();
    sources.sort();
    sources.push(web.join("package-lock.json"));
    let mut hash = Sha256::new();
    sources.iter().for_each(|p| hash.update(std::fs::read(p).unwrap()));
    let hash: String = hash.finalize().iter().map(|b| format!("{b:02x}")).collect();
    let bundle = std::fs::read_to_string(web.join("../assets/replay.min.js")).unwrap();
    let told = bundle.lines().next().unwrap();
    assert_eq!(
        told,
        format!("/* sources {hash} */"),
        "run `npm ci && npm run build` in harness/show/replay/web"
    );
    assert!(bundle.contains("The MIT License") && bundle.contains("three.js authors"));
    assert!(bundle.contains("fflate - fast JavaScript compression/decompression"));
}

#[test]
fn the_official_library_reads_the_mcap_file_back() {
    let drive = Drive::new(TraceMode::TenHz);
    let replay = drive.replay("pid");
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("t.mcap");
    write_mcap(&replay, std::fs::File::create(&path).unwrap(), &path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let mut topics: BTreeMap<String, Vec<(u64, Vec<u8>)>> = BTreeMap::new();
    let mut schemas = BTreeSet::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().unwrap();
        schemas.insert((schema.name.clone(), schema.encoding.clone()));
        topics
            .entry(message.channel.topic.clone())
            .or_default()
            .push((message.log_time, message.data.to_vec()));
    }
    let expected = [
        ("foxglove.FrameTransforms", "protobuf"),
        ("foxglove.Log", "protobuf"),
        ("foxglove.Odometry", "protobuf"),
        ("foxglove.SceneUpdate", "protobuf"),
        ("vb.Planner", "jsonschema"),
        ("vb.State", "jsonschema"),
    ];
    let expected: BTreeSet<_> = expected.map(|(n, e)| (n.to_owned(), e.to_owned())).into();
    assert_eq!(schemas, expected);
    let motion = &replay.runs[0].motion;
    for topic in ["/tf", "/run0/odometry", "/run0/state"] {
        assert_eq!(topics[topic].len(), motion.frames.len(), "{topic}");
    }
    let (last, frame) = (topics["/run0/odometry"].last().unwrap(), motion.frames.last().unwrap());
    assert_eq!(last.0, 4_000_000_000);
    let odometry = Odometry::decode(&last.1[..]).unwrap();
    let position = odometry.pose.unwrap().position.unwrap();
    assert_eq!((position.x, position.y, position.z), (frame.x, frame.y, frame.z));
    let tf = FrameTransforms::decode(&topics["/tf"][0].1[..]).unwrap();
    let children: Vec<&str> = tf.transforms.iter().map(|t| t.child_frame_id.as_str()).collect();
    assert_eq!(children, ["run0", "run0/wheel0", "run0/wheel1", "run0/wheel2", "run0/wheel3"]);
    let world = SceneUpdate::decode(&topics["/world"][0].1[..]).unwrap();
    let ids: Vec<&str> = world.entities.iter().map(|e| e.id.as_str()).collect();
    assert_eq!(ids, ["ground", "obstacles", "global path", "goal"]);
    assert_eq!(world.entities[0].triangles[0].points.len(), 65 * 65);
    assert_eq!(world.entities[1].triangles.len(), 1);
    let plan = SceneUpdate::decode(&topics["/run0/plan"][0].1[..]).unwrap();
    assert_eq!(plan.entities[0].lines.len(), 2, "two sampled lines");
    let log = Log::decode(&topics["/run0/outcome"][0].1[..]).unwrap();
    assert!(log.message.starts_with("stuck: "), "{}", log.message);
    let state: serde_json::Value = serde_json::from_slice(&topics["/run0/state"].last().unwrap().1).unwrap();
    assert_eq!(state["throttle"], 1.0);
}

#[test]
fn what_is_shown_of_the_sensors_is_what_the_planner_was_told() {
    let drive = Drive::new(TraceMode::TenHz);
    let (sensed, told) = (drive.sensed("onboard"), drive.told("onboard"));
    let all = |f: fn(&Readings) -> usize| told.iter().map(f).sum::<usize>();
    assert_eq!(sensed.scans, told.iter().filter_map(|r| r.lidar.clone()).collect::<Vec<_>>());
    assert_eq!(sensed.images, told.iter().filter_map(|r| r.depth.clone()).collect::<Vec<_>>());
    assert_eq!(sensed.imu.len(), all(|r| r.imu.len()));
    assert!(sensed.imu.iter().eq(told.iter().flat_map(|r| &r.imu)));
    assert!(sensed.fixes.iter().eq(told.iter().filter_map(|r| r.gnss.as_ref())));
    let (maps, own) = (told.iter().filter_map(|r| r.local_map.as_ref()), &sensed.maps);
    assert!(own.len() > 15 && own.len() == maps.clone().count());
    for (a, b) in own.iter().zip(maps) {
        let bits = |m: &vb_sdk::LocalMap| m.elevation.data.iter().map(|z| z.to_bits()).collect::<Vec<_>>();
        assert_eq!((a.time, bits(a), &a.occupancy), (b.time, bits(b), &b.occupancy));
    }
    // Four seconds at 10, 5 and 50 Hz.
    assert_eq!((sensed.scans.len(), sensed.images.len(), sensed.imu.len()), (40, 21, 200));
    assert!(!sensed.exact && drive.sensed("oracle").exact);
}

#[test]
fn point_clouds_images_and_maps_are_in_the_mcap_file_where_the_ground_is() {
    let drive = Drive::new(TraceMode::TenHz);
    let mut replay = drive.replay("pid");
    replay.runs[0].sensed = drive.sensed("oracle");
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("t.mcap");
    write_mcap(&replay, std::fs::File::create(&path).unwrap(), &path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let mut topics: BTreeMap<String, Vec<(u64, Vec<u8>)>> = BTreeMap::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        let message = message.unwrap();
        let own = topics.entry(message.channel.topic.clone()).or_default();
        own.push((message.log_time, message.data.to_vec()));
    }
    let times = |topic: &str| topics[topic].iter().map(|m| m.0).collect::<Vec<_>>();
    assert_eq!(times("/run0/lidar")[..2], [100_000_000, 200_000_000]);
    assert_eq!(times("/run0/depth/image"), times("/run0/depth/labels"));
    assert_eq!(times("/run0/estimate").len(), 41);
    // The vehicle has hardly moved yet: seen from its pose, the points lie on the level ground at 0, or on the boulder.
    let cloud = PointCloud::decode(&topics["/run0/lidar"][0].1[..]).unwrap();
    assert_eq!((cloud.frame_id.as_str(), cloud.point_stride), ("run0", 20));
    let start = &replay.runs[0].motion.frames[0];
    let about = |axis, angle| nalgebra::UnitQuaternion::from_axis_angle(&axis, angle);
    let turn = about(nalgebra::Vector3::z_axis(), start.yaw)
        * about(nalgebra::Vector3::y_axis(), start.pitch)
        * about(nalgebra::Vector3::x_axis(), start.roll);
    let mut on_ground = 0;
    for point in cloud.data.chunks_exact(20) {
        let at = |k: usize| f64::from(f32::from_le_bytes(point[4 * k..4 * k + 4].try_into().unwrap()));
        let p = turn * nalgebra::Vector3::new(at(0), at(1), at(2))
            + nalgebra::Vector3::new(start.x, start.y, start.z);
        let from_boulder = vb_math::hypot(p.x - 20.0, p.y - 20.0);
        if from_boulder > 3.0 {
            // The tenth of a second in which the vehicle begins to lean back, times the distance.
            let distance = vb_math::hypot(at(0), at(1));
            assert!(p.z.abs() < 0.02 + 0.006 * distance, "{} at {distance} m", p.z);
            on_ground += 1;
        }
    }
    assert!(on_ground > 3000, "{on_ground}");
    let image = RawImage::decode(&topics["/run0/depth/image"][0].1[..]).unwrap();
    assert_eq!((image.width, image.height, image.encoding.as_str()), (96, 64, "32FC1"));
    assert_eq!(image.data.len(), 4 * 96 * 64);
    let grid = Grid::decode(&topics["/run0/local_map"].last().unwrap().1[..]).unwrap();
    let cells: Vec<f32> =
        grid.data.chunks_exact(6).map(|c| f32::from_le_bytes(c[..4].try_into().unwrap())).collect();
    assert_eq!((grid.column_count, cells.len()), (80, 6400));
    let known: Vec<&f32> = cells.iter().filter(|z| z.is_finite()).collect();
    // Mud yields by decimetres under wheels, and nowhere else.
    assert!(known.len() > 1000 && known.iter().all(|z| z.abs() < 0.4));
    let level = known.iter().filter(|z| z.abs() < 0.02).count();
    assert!(level * 10 > known.len() * 8, "{level} of {}", known.len());
}

#[test]
fn a_page_of_many_scans_stays_small() {
    let drive = Drive::new(TraceMode::TenHz);
    let mut replay = drive.replay("pid");
    let mut sensed = drive.sensed("oracle");
    // Ten minutes of scans.
    let scans = sensed.scans.clone();
    for k in 1..150 {
        sensed.scans.extend(
            scans.iter().map(|s| vb_sdk::LidarScan { time: s.time + 4.0 * f64::from(k), ..s.clone() }),
        );
    }
    replay.runs[0].sensed = sensed;
    let page = page(&replay, &Links::default(), None);
    assert!(page.len() < 16 << 20, "{}", page.len());
    assert!(page.contains("\"scans_of\":6000"));
}

/// What libraries of others find in a bag; skips the test where they are missing.
fn read_by_others(bag: &std::path::Path) -> Option<serde_json::Value> {
    let program = std::env::var("VB_PYTHON").unwrap_or_else(|_| "python3".into());
    let python = || {
        let mut python = std::process::Command::new(&program);
        if let Some(folder) = std::env::var_os("VB_PYTHON_LIBS") {
            python.env("PYTHONPATH", folder);
        }
        python
    };
    let found = python().args(["-c", "import mcap.reader, rosbags.typesys"]).output();
    if !found.is_ok_and(|output| output.status.success()) {
        vb_testing::skip(format_args!(
            "{program} lacks mcap or rosbags (pip install mcap rosbags, or set VB_PYTHON or VB_PYTHON_LIBS)"
        ));
        return None;
    }
    let script = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bag.py");
    let told = python().arg(script).arg(bag).output().unwrap();
    assert!(told.status.success(), "{}", String::from_utf8_lossy(&told.stderr));
    Some(serde_json::from_slice(&told.stdout).unwrap())
}

#[test]
fn a_bag_has_messages_of_ros_2_that_libraries_of_others_read() {
    let drive = Drive::new(TraceMode::TenHz);
    let mut replay = drive.replay("pid");
    replay.runs[0].sensed = drive.sensed("onboard");
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("t.mcap");
    write_ros2_mcap(&replay, std::fs::File::create(&path).unwrap(), &path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for message in mcap::MessageStream::new(&bytes).unwrap() {
        *counts.entry(message.unwrap().channel.topic.clone()).or_default() += 1;
    }
    let motion = &replay.runs[0].motion;
    let n = motion.frames.len();
    for (topic, wanted) in [
        ("/tf", n),
        ("/ground_truth", n),
        ("/controls", n),
        ("/joint_states", n),
        ("/plan", 1),
        ("/points", 40),
        ("/imu/data", 200),
    ] {
        assert_eq!(counts.get(topic), Some(&wanted), "{topic}: {counts:?}");
    }
    let Some(told) = read_by_others(&path) else { return };
    assert_eq!(told["profile"], "ros2");
    for (topic, about) in told["topics"].as_object().unwrap() {
        assert_eq!(about["hash"], true, "{topic}: {about}");
        assert_eq!(about["count"], counts[topic], "{topic}");
    }
    let last = motion.frames.last().unwrap();
    let values = &told["values"];
    assert_eq!(values["position"], serde_json::json!([last.x, last.y, last.z]));
    assert_eq!((&values["time"], &values["stamp"]), (&4_000_000_000_u64.into(), &4_000_000_000_u64.into()));
    assert_eq!(values["child"], "base_link");
    let joints = ["left_wheel_0_joint", "right_wheel_0_joint", "left_wheel_1_joint", "right_wheel_1_joint"];
    assert_eq!(values["joints"], serde_json::json!(joints));
    // The speeds are those of the angles.
    let [drift, turned] = ["drift", "turned"].map(|name| values[name].as_f64().unwrap());
    assert!(drift < 1e-6 && turned > 1.0, "{values}");
    let info = replay.runs[0].sensed.lidar.unwrap();
    let wanted = serde_json::json!([
        info.rows,
        info.cols,
        20 * info.rows * info.cols,
        ["x", "y", "z", "time", "ring"]
    ]);
    assert_eq!(values["cloud"], wanted);
}

#[test]
fn topics_and_frames_of_several_runs_begin_with_the_run() {
    let drive = Drive::new(TraceMode::TenHz);
    let mut replay = drive.replay("pid");
    replay.runs.push(replay.runs[0].clone());
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("t.mcap");
    write_ros2_mcap(&replay, std::fs::File::create(&path).unwrap(), &path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let messages = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap);
    let topics: BTreeSet<String> = messages.map(|m| m.channel.topic.clone()).collect();
    let of_runs = ["controls", "ground_truth", "outcome"]
        .map(|name| [format!("/run0/{name}"), format!("/run1/{name}")]);
    assert!(of_runs.iter().flatten().all(|topic| topics.contains(topic)), "{topics:?}");
}
