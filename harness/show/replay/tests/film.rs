//! Films of a drive that the test itself makes up: straight over flat ground.

// Helpers of tests may unwrap as tests do.
#![allow(clippy::unwrap_used)]

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use nalgebra::Vector3;
use vb_record::Sample;
use vb_render::{Moment, Painter, Size, View};
use vb_replay::film::{Camera, Course, Film, FilmError, Schedule, Style, write_picture, write_video};
use vb_replay::{Motion, PlannerSeries, Repeat, Replay, ReplayRun, Rut, Sensed, WheelFrame};
use vb_score::{Outcome, TaskRecord};
use vb_sim::{Gear, VehicleState, WheelState};
use vb_vehicle::{VehicleModel, VehicleSpec};
use vb_world::{Heightfield, Pose2, Task, TerrainClass, World};

const SIZE: Size = Size { width: 200, height: 120 };

fn spec() -> VehicleSpec {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tasks/vehicles/hmmwv.yaml");
    VehicleSpec::parse(&std::fs::read_to_string(file).unwrap(), "hmmwv").unwrap()
}

/// The sample at a time of a vehicle that drives east at this speed.
fn sample(time: f64, speed: f64) -> Sample {
    Sample { time, x: -10.0 + speed * time, z: 0.6, vx: speed, ..Sample::default() }
}

/// A run of two seconds, fifty frames a second, with a rut beside the vehicle from one second on.
fn run(label: &str, speed: f64, outcome: Outcome) -> ReplayRun {
    let frames: Vec<Sample> = (0..=100).map(|k| sample(0.02 * f64::from(k), speed)).collect();
    let wheel =
        |k: usize| WheelFrame { angle: 0.02 * speed * k as f64, travel: 0.01, ..WheelFrame::default() };
    let motion = Motion {
        repeat: Repeat::Exact,
        steering: vec![0.2; frames.len()],
        wheels: 4,
        wheel_frames: (0..frames.len()).flat_map(|k| [wheel(k); 4]).collect(),
        contacts: Vec::new(),
        // A metre wide, since a pixel from above is a third of that.
        ruts: (0..800)
            .map(|k| {
                let at = [-9.975 + 0.05 * f64::from(k % 40), 2.025 + 0.05 * f64::from(k / 40)];
                Rut { time: 1.0, at, depth: 0.2, raised: 0.0 }
            })
            .collect(),
        soil_resolution: 0.05,
        grains: vb_replay::Grains::default(),
        frames,
    };
    let record = TaskRecord {
        task: "w001/t00".parse().unwrap(),
        world: "w001".into(),
        outcome,
        three_way: outcome.three_way(false),
        flags: std::collections::BTreeMap::new(),
        ..blank()
    };
    ReplayRun {
        label: label.into(),
        record,
        rules: None,
        vehicle: Arc::new(spec()),
        motion,
        series: PlannerSeries::new(Vec::new()),
        sensed: Sensed::default(),
    }
}

fn blank() -> TaskRecord {
    let world = world();
    TaskRecord {
        task: "w001/t00".parse().unwrap(),
        world: String::new(),
        elevation: world.elevation,
        terrain: world.terrain,
        density: world.density,
        outcome: Outcome::Success,
        three_way: Outcome::Success.three_way(false),
        flags: std::collections::BTreeMap::new(),
        departures: Vec::new(),
        reason: String::new(),
        cause: None,
        evidence: String::new(),
        fault: None,
        time_s: 2.0,
        state_hash: String::new(),
        sim_steps: 0,
        planner_steps: 0,
        clamped: 0,
        fuel: None,
        metrics: None,
        ride: None,
        log: Vec::new(),
        backtrace: Vec::new(),
    }
}

fn world() -> World {
    World::uniform("w001", Heightfield::flat(41, 41, 1.0, 0.0), TerrainClass::Mud, 0.5)
}

fn replay(runs: Vec<ReplayRun>) -> Replay {
    let start = Pose2 { x: -10.0, y: 0.0, yaw: 0.0 };
    Replay {
        world: Arc::new(world()),
        task: Task { id: "t00".into(), start, goal: [12.0, 0.0], path: vec![[-10.0, 0.0], [12.0, 0.0]] },
        suite: "a suite".into(),
        has_goal: true,
        goal_radius: Some(5.0),
        runs,
    }
}

fn style(camera: Camera) -> Style {
    Style { camera, size: SIZE, captions: false }
}

fn film(runs: Vec<ReplayRun>, style: Style) -> Film {
    Film::new(&replay(runs), style).unwrap()
}

/// The part of a frame that a panel of this size fills.
fn part(frame: &[u8], [x, y]: [usize; 2], size: Size) -> Vec<u8> {
    let (w, h) = (3 * size.width as usize, size.height as usize);
    frame
        .chunks_exact(3 * SIZE.width as usize)
        .skip(y)
        .take(h)
        .flat_map(|row| row[3 * x..3 * x + w].to_vec())
        .collect()
}

#[test]
fn a_frame_is_the_painter_s_picture_of_the_moment() {
    let film = film(vec![run("pid", 4.0, Outcome::Success)], style(Camera::Map));
    let model = VehicleModel::new(spec()).unwrap();
    let painter = Painter::new(&Arc::new(world()), &model);
    // Half-way between two frames, before there is a rut: at a steady speed what lies between is known.
    let time = 0.51;
    let s = sample(time, 4.0);
    let state = VehicleState {
        time,
        position: Vector3::new(s.x, s.y, s.z),
        attitude: nalgebra::UnitQuaternion::identity(),
        velocity_body: Vector3::new(4.0, 0.0, 0.0),
        angular_velocity_body: Vector3::zeros(),
        wheels: vec![WheelState { deflection: 0.01, ..WheelState::default() }; 4],
        steering: 0.2,
        gear: Gear::Forward,
        engine_speed: 0.0,
    };
    let mut trail: Vec<[f64; 3]> = (0..=25)
        .map(|k| {
            let s = sample(0.02 * f64::from(k), 4.0);
            [s.x, s.y, s.z]
        })
        .collect();
    trail.push([s.x, s.y, s.z]);
    let moment = Moment {
        state: &state,
        turned: &[2.04; 4],
        goal: [12.0, 0.0],
        goal_radius: 5.0,
        path: &[[-10.0, 0.0], [12.0, 0.0]],
        trail: &trail,
        change: Some(&|_, _| None),
        grains: &[],
        colour: Some(vb_replay::RUN_COLOURS[0]),
    };
    let wanted = painter.picture(View::Top { window: None }, SIZE, &moment).unwrap();
    let frame = film.frame(time).unwrap();
    let differ = frame.iter().zip(&wanted).filter(|(a, b)| a.abs_diff(**b) > 1).count();
    assert_eq!(differ, 0, "{differ} of {} values differ", wanted.len());
}

#[test]
fn ruts_are_seen_from_when_they_were_dug() {
    let film = film(vec![run("pid", 0.0, Outcome::Stuck)], style(Camera::Top));
    let [before, after] = [0.98, 1.0].map(|t| film.frame(t).unwrap());
    assert!(before != after, "the vehicle stands, and the rut comes");
    assert!(after == film.frame(2.0).unwrap());
}

#[test]
fn runs_stand_beside_each_other_and_stay_as_they_ended() {
    let (fast, slow) = (run("fast", 8.0, Outcome::Success), run("slow", 1.0, Outcome::Stuck));
    let both = film(vec![fast.clone(), slow.clone()], style(Camera::Chase));
    let size = Size { width: 99, height: 120 };
    let alone = |run| film(vec![run], Style { size, ..style(Camera::Chase) }).frame(1.3).unwrap();
    let frame = both.frame(1.3).unwrap();
    assert!(part(&frame, [0, 0], size) == alone(fast));
    // The second has its own place and colour, whoever is the first.
    let other = film(vec![run("other", 3.0, Outcome::Success), slow.clone()], style(Camera::Chase));
    let second = part(&frame, [101, 0], size);
    assert!(second == part(&other.frame(1.3).unwrap(), [101, 0], size) && second != alone(slow));
    assert!(both.frame(both.end()).unwrap() == both.frame(77.0).unwrap());
}

#[test]
fn captions_say_what_was_driven_and_how_it_ended() {
    let runs = || vec![run("pid", 4.0, Outcome::Stuck)];
    let plain = film(runs(), style(Camera::Top));
    let told = film(runs(), Style { captions: true, ..style(Camera::Top) });
    let changed = |time: f64| -> Vec<usize> {
        let (a, b) = (plain.frame(time).unwrap(), told.frame(time).unwrap());
        a.chunks(3).zip(b.chunks(3)).enumerate().filter(|(_, (a, b))| a != b).map(|(k, _)| k).collect()
    };
    // In the upper and in the lower left corner, and nowhere in the middle.
    let pixels = changed(1.0);
    let row = |k: usize| k / SIZE.width as usize;
    assert!(pixels.iter().any(|k| row(*k) < 20) && pixels.iter().any(|k| row(*k) > 100));
    assert!(!pixels.iter().any(|k| (40..70).contains(&row(*k))), "the vehicle is not covered");
    assert!(told.frame(1.98).unwrap() != told.frame(2.0).unwrap(), "the outcome is told at the end");
}

#[test]
fn a_picture_s_file_has_the_pixels_of_its_frame() {
    let dir = tempfile::tempdir().unwrap();
    let film = film(vec![run("pid", 4.0, Outcome::Success)], style(Camera::Chase));
    let path = dir.path().join("a.png");
    write_picture(&film, 1.5, &path).unwrap();
    let mut reader =
        png::Decoder::new(std::io::BufReader::new(File::open(&path).unwrap())).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!((info.width, info.height), (SIZE.width, SIZE.height));
    assert!(pixels == film.frame(1.5).unwrap());
    assert!(matches!(write_picture(&film, 2.5, &path), Err(FilmError::Time { .. })));
}

#[test]
fn a_gif_lasts_as_long_as_the_drive_and_looks_like_it() {
    let dir = tempfile::tempdir().unwrap();
    let film = film(vec![run("pid", 4.0, Outcome::Success)], style(Camera::Map));
    let course = Course { from: None, to: None, speed: 1.0, fps: 30.0 };
    let schedule = Schedule::new(course, film.end()).unwrap();
    let files = [1, 2, 5].map(|threads| {
        let path = dir.path().join(format!("{threads}.gif"));
        write_video(&film, &schedule, &path, threads, &mut |_| {}).unwrap();
        std::fs::read(&path).unwrap()
    });
    assert!(files[0] == files[1] && files[0] == files[2], "threads change nothing");
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(&files[0][..]).unwrap();
    let mut canvas = vec![0_u8; 4 * (SIZE.width * SIZE.height) as usize];
    let mut hundredths = 0;
    let mut at_one_second = None;
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        for (k, dot) in frame.buffer.chunks(4).enumerate().filter(|(_, dot)| dot[3] > 0) {
            let (w, x, y) = (usize::from(frame.width), usize::from(frame.left), usize::from(frame.top));
            let at = 4 * ((y + k / w) * SIZE.width as usize + x + k % w);
            canvas[at..at + 4].copy_from_slice(dot);
        }
        if hundredths == 100 {
            at_one_second = Some(canvas.clone());
        }
        hundredths += u32::from(frame.delay);
    }
    // Two seconds, the end held for one, and the last frame, which stays for one and a half.
    assert_eq!(hundredths, 450);
    let wanted = film.frame(1.0).unwrap();
    let shown = at_one_second.expect("a frame begins at one second");
    let off = |a: u8, b: u8| f64::from(a.abs_diff(b));
    let sum: f64 =
        shown.chunks(4).zip(wanted.chunks(3)).flat_map(|(s, w)| (0..3).map(move |k| off(s[k], w[k]))).sum();
    let mean = sum / wanted.len() as f64;
    assert!(mean < 4.0, "colours are off by {mean:.2} of 255 in the mean");
}

#[test]
fn what_cannot_be_filmed_is_said() {
    let of = |run| Film::new(&replay(vec![run]), style(Camera::Chase)).err().map(|e| e.to_string()).unwrap();
    let mut empty = run("pid", 1.0, Outcome::Stuck);
    empty.motion.frames.clear();
    assert!(of(empty).contains("run pid: task w001/t00 cannot be rendered: its trace has no samples"));
    let mut other = run("pid", 1.0, Outcome::Stuck);
    other.motion.wheels = 6;
    assert!(of(other).contains("other wheels than the trace"));
    let many = vec![run("pid", 1.0, Outcome::Stuck); 13];
    let error = Film::new(&replay(many), style(Camera::Chase)).err().unwrap();
    assert_eq!(error.to_string(), "13 runs are too many for one picture (give at most 12)");
}
