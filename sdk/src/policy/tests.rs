use super::*;
use crate::{GnssFix, ImuSample, Observation, Point2, Pose, Task, Vec3, Wheel, math};
use std::f64::consts::FRAC_PI_2;

fn seen(pose: Pose) -> Observation {
    Observation { pose: Some(pose), ..Observation::default() }
}

fn at(x: f64, y: f64, yaw: f64) -> Pose {
    Pose { position: Vec3 { x, y, z: 0.0 }, yaw, ..Pose::default() }
}

fn numbers(task: &Task, name: &str, observations: &[Observation]) -> Vec<f32> {
    let layout = Layout::new(&[name], Sight::default(), task).unwrap();
    let mut observer = Observer::new(task, &layout).unwrap();
    observations.iter().for_each(|o| observer.look(o));
    let part = &layout.parts()[0];
    let mut to = vec![f32::NAN; part.width()];
    observer.fill(task, part, Row::F32(&mut to));
    to
}

fn labels(task: &Task, name: &str, observation: &Observation) -> Vec<u8> {
    let layout = Layout::new(&[name], Sight::default(), task).unwrap();
    let mut observer = Observer::new(task, &layout).unwrap();
    observer.look(observation);
    let mut to = vec![77; layout.parts()[0].width()];
    observer.fill(task, &layout.parts()[0], Row::U8(&mut to));
    to
}

#[test]
fn points_are_seen_from_the_vehicle() {
    let task = example_task();
    // Heading north, 3 m along the path and 1 m to its left: the path goes off to the right.
    let o = seen(at(3.0, 1.0, FRAC_PI_2));
    let goal = numbers(&task, "goal", std::slice::from_ref(&o));
    assert!((goal[0] + 1.0).abs() < 1e-6 && (goal[1] + 17.0).abs() < 1e-6, "{goal:?}");
    let path = numbers(&task, "path", &[o]);
    assert_eq!(path.len(), 20);
    // The first is 2 m on, at x = 5; the tenth would be at 23 and is the goal.
    assert!((path[0] + 1.0).abs() < 1e-6 && (path[1] + 2.0).abs() < 1e-6, "{path:?}");
    assert!((path[18] + 1.0).abs() < 1e-6 && (path[19] + 17.0).abs() < 1e-6, "{path:?}");
}

#[test]
fn crops_turn_with_the_heading_and_start_at_the_rear_right() {
    let mut task = example_task();
    // z = 0.5 x, and rock east of x = 2 with an obstacle at (6, 0).
    let map = task.elevation.as_mut().unwrap();
    for (k, z) in map.data.iter_mut().enumerate() {
        *z = 0.5 * ((k % 65) as f32 - 32.0);
    }
    for (k, class) in task.semantics.as_mut().unwrap().data.iter_mut().enumerate() {
        *class = if (k % 65) as f32 - 32.0 > 2.0 { 5 } else { 3 };
    }
    task.occupancy.as_mut().unwrap().data[32 * 65 + 38] = 1;
    let o = seen(at(-1.0, 0.0, FRAC_PI_2));
    let height = numbers(&task, "height", std::slice::from_ref(&o));
    // Facing north, the right is the east: samples at 7.5 m to the right and to the left.
    assert!((height[0] - 0.5 * 7.5).abs() < 1e-5 && (height[15] + 0.5 * 7.5).abs() < 1e-5, "{height:?}");
    assert!((height[16 * 15] - height[0]).abs() < 1e-5, "{height:?}");
    let class = labels(&task, "class", &o);
    // Columns at x = 6.5, 5.5, …; the obstacle's square reaches from 5.5 to 6.5 and from −0.5 to 0.5.
    assert_eq!((class[0], class[5], class[15]), (5, 3, 3));
    assert!(class.contains(&10) && class.iter().filter(|c| **c == 10).count() <= 4, "{class:?}");
    let friction = numbers(&task, "friction", std::slice::from_ref(&o));
    assert_eq!((friction[0], friction[5]), (0.65, 0.36));
    // Beyond the world, at its western edge facing west.
    let edge = labels(&task, "class", &seen(at(-31.0, 0.0, std::f64::consts::PI)));
    assert_eq!((edge[0], edge[255]), (3, 255));
}

#[test]
fn what_was_not_measured_since_stays_as_it_was() {
    let task = example_task();
    let wheel = |spin| Wheel { spin, travel: 0.02 };
    let first = Observation { wheels: vec![wheel(3.0); 4], ..seen(at(0.0, 0.0, 0.0)) };
    let wheels = numbers(&task, "wheels", &[first.clone(), Observation::default()]);
    assert_eq!(wheels, [3.0, 0.02].repeat(4));
    let never = numbers(&task, "wheels", &[Observation::default()]);
    assert_eq!(never, [0.0; 8]);
    let fix = GnssFix { time: 0.0, position: Vec3 { x: 1.0, y: 2.0, z: 3.0 } };
    let with_fix = Observation { gnss: Some(fix), ..first };
    assert_eq!(numbers(&task, "gnss", &[with_fix, Observation::default()]), [1.0, 2.0, 3.0]);
}

#[test]
fn the_inertial_unit_is_told_by_its_mean() {
    let sample = |fx: f64, wz: f64| ImuSample {
        time: 0.0,
        specific_force: Vec3 { x: fx, y: 0.0, z: 9.81 },
        angular_velocity: Vec3 { x: 0.0, y: 0.0, z: wz },
    };
    let o = Observation { imu: vec![sample(1.0, 0.2), sample(3.0, 0.4)], ..Observation::default() };
    let imu = numbers(&example_task(), "imu", &[o]);
    assert_eq!(imu, [2.0, 0.0, 9.81, 0.0, 0.0, 0.3].map(|x: f64| x as f32));
}

#[test]
fn a_flat_observation_is_the_parts_of_numbers_by_their_usual_size_within_bounds() {
    let task = example_task();
    let layout = Layout::new(&["goal", "class", "pose"], Sight::default(), &task).unwrap();
    assert_eq!(layout.flat_width(), 6);
    let mut observer = Observer::new(&task, &layout).unwrap();
    observer.look(&seen(at(-400.0, 0.0, 0.0)));
    let mut flat = [f32::NAN; 6];
    observer.flat(&task, &layout, &mut flat);
    // The goal at 420 m by its usual 50 m is limited to 5; x at −400 by 60 m, to −5.
    assert_eq!(flat, [5.0, 0.0, -5.0, 0.0, 0.0, 0.0]);
    observer.look(&seen(at(-5.0, 10.0, 0.0)));
    observer.flat(&task, &layout, &mut flat);
    assert_eq!(flat[..2], [0.5, -0.2]);
}

#[test]
fn every_part_has_bounds_that_hold_its_numbers_or_says_what_is_missing() {
    let task = example_task();
    for kind in PARTS {
        match Layout::new(&[kind.name], Sight::default(), &task) {
            Ok(layout) => {
                let part = &layout.parts()[0];
                let innermost = *part.shape.last().unwrap();
                assert!(part.entries.len() == 1 || part.entries.len() == innermost, "{}", part.name);
                assert!(part.entries.iter().all(|e| e.low < e.high && e.usual > 0.0), "{}", part.name);
            }
            Err(e) => {
                let text = e.to_string();
                assert!(text.contains(kind.name) && text.contains("profile oracle"), "{text}");
            }
        }
    }
}

#[test]
fn layouts_refuse_what_makes_no_sense_and_say_what_there_is() {
    let task = example_task();
    let told = |names: &[&str], sight: Sight| Layout::new(names, sight, &task).unwrap_err().to_string();
    assert!(
        told(&["hight"], Sight::default()).contains("no part hight of an observation (parts: state, pose")
    );
    assert!(told(&["state", "state"], Sight::default()).contains("state of the observation is named twice"));
    assert!(told(&[], Sight::default()).contains("at least one part"));
    let sight = Sight { cells: 1, ..Sight::default() };
    assert_eq!(told(&["height"], sight), "sight: cells: 1 must lie in 2 to 256");
    let blind = Task { elevation: None, perception: "onboard".into(), ..example_task() };
    let e = Layout::new(&["height"], Sight::default(), &blind).unwrap_err().to_string();
    assert!(e.contains("height needs an elevation map, which the perception profile onboard"), "{e}");
}

#[test]
fn needs_are_the_sensors_of_the_parts_with_the_pose() {
    let names = |parts: &[&str]| Layout::needs(parts).iter().map(|n| n.sensor.name()).collect::<Vec<_>>();
    assert_eq!(names(&["state", "height"]), ["pose"]);
    assert_eq!(names(&["wheels", "depth", "depth_labels"]), ["pose", "wheel-odometry", "depth"]);
}

#[test]
fn actions_stand_for_speeds_or_pedals() {
    let task = example_task();
    let moving = |speed: f64| {
        let linear_velocity = Vec3 { x: speed, y: 0.0, z: 0.0 };
        seen(Pose { linear_velocity, ..Pose::default() })
    };
    // −2 to 6 m/s: −0.5 stands for 0 m/s, so at 1 m/s it brakes by 0.6.
    let kind = ActionKind::Speed { slowest: -2.0, fastest: 6.0 };
    let mut actuator = Actuator::new(kind, &task);
    let command = actuator.command(&[0.3, -0.5], &moving(1.0));
    assert!(
        command.steering == 0.3 && command.throttle == 0.0 && (command.brake - 0.6).abs() < 0.05,
        "{command:?}"
    );
    assert_eq!(actuator.command(&[0.0, -1.0], &moving(0.0)).gear, crate::Gear::Reverse);
    // The change of the steering is a fifth of the number, from what holds, and stays within the locks.
    let mut rate = Actuator::new(ActionKind::Rate { slowest: -2.0, fastest: 6.0 }, &task);
    for (last, number, wanted) in [(0.0, 1.0, 0.2), (0.5, -0.5, 0.4), (0.9, 1.0, 1.0), (-1.0, 7.0, -0.8)] {
        let o = Observation { last_steering: last, ..seen(at(0.0, 0.0, 0.0)) };
        let command = rate.command(&[number, 1.0], &o);
        assert!(
            (command.steering - wanted).abs() < 1e-12 && command.throttle > 0.0,
            "{last}, {number}: {command:?}"
        );
    }
    let mut pedals = Actuator::new(ActionKind::Pedals, &task);
    let command = pedals.command(&[2.0, 0.7, 0.1, 0.0], &moving(0.0));
    assert_eq!((command.steering, command.throttle, command.brake), (1.0, 0.7, 0.1));
    assert_eq!(command.gear, crate::Gear::Neutral);
    for (number, gear) in [(-1.0, crate::Gear::Reverse), (0.5, crate::Gear::Forward)] {
        assert_eq!(pedals.command(&[0.0, 0.0, 0.0, number], &moving(0.0)).gear, gear);
    }
}

#[test]
fn progress_along_the_path_is_what_is_left_of_it() {
    let task = Task { goal: Point2 { x: 25.0, y: 0.0 }, ..example_task() };
    let layout = Layout::new(&["goal"], Sight::default(), &task).unwrap();
    let mut observer = Observer::new(&task, &layout).unwrap();
    assert_eq!(observer.remaining(), 25.0);
    observer.look(&seen(at(5.0, 2.0, 0.0)));
    assert!((observer.remaining() - 20.0).abs() < 1e-9);
}

/// Weights of a policy that sees the goal and crops of two samples a side: one plane for height, one for obstacles, and a kernel
/// over the whole crop with a single output.
fn policy(notes: &[(&str, &str)]) -> crate::nn::Weights {
    use crate::nn::{Convolution, Layer, Shape, Weights};
    let mut all = vec![
        ("parts", "goal height class"),
        ("sight", "2 1 0 10 2"),
        ("labels", "10"),
        ("action", "speed 0 6"),
        ("control_hz", "10"),
    ];
    for (key, value) in notes {
        all.retain(|(k, _)| k != key);
        all.extend((*value != "missing").then_some((*key, *value)));
    }
    let own = Convolution { planes: 2, rows: 2, cols: 2, outputs: 1, kernel: 2, stride: 1, padding: 0 };
    let eyes = Layer {
        name: "eyes.0".into(),
        shape: Shape::Convolution(own),
        weights: vec![1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -8.0],
        bias: vec![0.25],
    };
    // The first output is what the eyes see; the second the goal forward.
    let head = Layer::dense("head.0", 3, vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0], vec![0.0, 0.5]);
    let notes = all.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    Weights { notes, layers: vec![eyes, head] }
}

#[test]
fn a_policy_sees_planes_first_and_answers_by_its_layers() {
    let weights = policy(&[]);
    let spec = PolicySpec::of(&weights).unwrap();
    let layout = Layout::new(&spec.parts, spec.sight, &example_task()).unwrap();
    let mut network = PolicyNetwork::new(&weights, &spec, &layout).unwrap();
    let mut act = |goal: [f32; 2], height: [f32; 4], class: [u8; 4]| {
        network.act(&[Numbers::F32(&goal), Numbers::F32(&height), Numbers::U8(&class)])
    };
    // 0.25 + 3 m / 2 m; 25 m / 50 m + 0.5.
    assert_eq!(act([25.0, 0.0], [3.0, 9.0, 9.0, 9.0], [3, 3, 10, 3]), [1.75, 1.0]);
    // Numbers are limited to 5. An obstacle at the last sample is worth -8, and what is below 0 leaks a tenth of it.
    let seen = act([-1000.0, 0.0], [1000.0, 0.0, 0.0, 0.0], [3, 3, 3, 10]);
    assert!((seen[0] + 0.275).abs() < 1e-6 && (seen[1] + 4.5).abs() < 1e-6, "{seen:?}");
}

#[test]
fn the_relief_of_heights_is_a_plane_behind_them_and_actions_may_be_squashed() {
    use crate::nn::{Convolution, Shape};
    let mut weights = policy(&[("relief", "8"), ("squash", "tanh")]);
    let own = Convolution { planes: 3, rows: 2, cols: 2, outputs: 1, kernel: 2, stride: 1, padding: 0 };
    weights.layers[0].shape = Shape::Convolution(own);
    // Of height, relief and obstacles, the relief of the first sample alone is looked at.
    weights.layers[0].weights = [[0.0; 4], [1.0, 0.0, 0.0, 0.0], [0.0; 4]].concat();
    let spec = PolicySpec::of(&weights).unwrap();
    assert_eq!((spec.relief, spec.is_squashed), (Some(8.0), true));
    let layout = Layout::new(&spec.parts, spec.sight, &example_task()).unwrap();
    let mut network = PolicyNetwork::new(&weights, &spec, &layout).unwrap();
    let mut act = |height: [f32; 4]| {
        network.act(&[Numbers::F32(&[0.0, 0.0]), Numbers::F32(&height), Numbers::U8(&[3; 4])])[0]
    };
    // Of the 25 places around the first sample 9 are itself, 6 and 6 its neighbours and 4 the last one.
    for (height, rise) in [([0.1, 0.0, 0.0, 0.0], 0.064), ([0.0, 0.1, 0.0, 0.0], -0.024), ([7.0; 4], 0.0)] {
        let wanted = math::tanh(0.25 + 8.0 * rise / 2.0);
        assert!((act(height) - wanted).abs() < 1e-6, "{height:?}: {} {wanted}", act(height));
    }
    // It is limited as all numbers are.
    assert!((act([9.0, 0.0, 0.0, 0.0]) - math::tanh(5.25)).abs() < 1e-6);
}

#[test]
fn a_policy_drives_as_its_action_says_and_refuses_what_makes_no_sense() {
    let task = example_task();
    let mut own = Trained::new(&policy(&[]), &task).unwrap();
    // The ground is flat, so the eyes see 0.25; the goal is 20 m ahead, which is 0.9 of the way from 0 to 6 m/s.
    let command = own.step(&task, &seen(at(0.0, 0.0, 0.0))).unwrap();
    assert!((command.steering - 0.25).abs() < 1e-6 && command.throttle > 0.0, "{command:?}");
    let mut actuator = Actuator::new(ActionKind::default(), &task);
    assert_eq!(command, actuator.command(&[0.25, f64::from(0.4_f32 + 0.5)], &seen(at(0.0, 0.0, 0.0))));
    let error = own.step(&task, &seen(at(f64::NAN, 0.0, 0.0))).unwrap_err().to_string();
    assert!(error.contains("not finite"), "{error}");
}

#[test]
fn weights_that_are_no_policy_are_refused_with_the_note_that_is_wrong() {
    let told = |notes: &[(&str, &str)]| match Trained::new(&policy(notes), &example_task()) {
        Ok(_) => "it is taken".to_owned(),
        Err(e) => e.to_string(),
    };
    for (key, value, wanted) in [
        ("parts", "missing", "weights: parts: the note is missing"),
        ("parts", "goal heights class", "no part heights"),
        ("parts", "goal height", "eyes turns 8 inputs"),
        ("parts", "height class", "head turns 3 inputs"),
        ("sight", "2 1 0 10", "weights: sight: \"2 1 0 10\" is not cells, resolution"),
        ("sight", "4 1 0 10 2", "eyes turns 8 inputs"),
        ("labels", "10 obstacle", "weights: labels: \"10 obstacle\" is not a list of labels"),
        ("labels", "9 10", "eyes turns 8 inputs"),
        ("action", "speed 6 0", "weights: action: \"speed 6 0\" is not"),
        ("action", "turn 0 6", "weights: action: \"turn 0 6\" is not"),
        ("action", "pedals", "head turns 3 inputs into 2 outputs, and not 3 into 4"),
        ("relief", "much", "weights: relief: \"much\" is not a number"),
        ("squash", "sigmoid", "weights: squash: \"sigmoid\" is not tanh"),
        ("control_hz", "20", "weights: control_hz: \"20\" is not 10"),
    ] {
        let told = told(&[(key, value)]);
        assert!(told.contains(wanted), "{key}: {value}: {told}");
    }
}
