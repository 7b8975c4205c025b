//! A planner on Cyclone DDS, an independent implementation, and the same planner in Rust.

use std::path::Path;
use std::process::{Child, Command};

use vb_host::{External, ExternalLog, ExternalSession, FaultCause};
use vb_ros::{Actuator, Setpoint};
use vb_rosmsg::convert::{odometry, path};
use vb_rosmsg::messages::nav_msgs;
use vb_sdk::{Observation, Point2, Pose, Task, Vec3};

use crate::peer::{alone, domain, observation, options, plugin, start, task};

/// A Python with `cyclonedds`: that of `VB_PYTHON`, or that of the path, with the packages of `VB_PYTHON_LIBS`. Skips the test without.
pub(crate) fn python() -> Option<Command> {
    let program = std::env::var("VB_PYTHON").unwrap_or_else(|_| "python3".into());
    let command = || {
        let mut command = Command::new(&program);
        if let Some(folder) = std::env::var_os("VB_PYTHON_LIBS") {
            command.env("PYTHONPATH", folder);
        }
        command
    };
    let found = command().args(["-c", "import cyclonedds.domain"]).output();
    if found.is_ok_and(|output| output.status.success()) {
        return Some(command());
    }
    vb_testing::skip(format_args!(
        "{program} lacks cyclonedds (pip install cyclonedds, or set VB_PYTHON or VB_PYTHON_LIBS)"
    ));
    None
}

/// The planner in Python, ended with the test.
pub(crate) struct Planner(Child);

impl Planner {
    pub(crate) fn start(mut python: Command, arguments: &[&str]) -> Self {
        let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../examples/ros2/pure_pursuit.py");
        python.arg(script).args(["--domain", &domain().to_string(), "--seconds", "600"]).args(arguments);
        Self(python.spawn().unwrap())
    }
}

impl Drop for Planner {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The planner of `examples/ros2/pure_pursuit.py` in Rust, without a network. The order of all operations is that of the script.
#[derive(Debug)]
pub(crate) struct Twin;

impl External for Twin {
    fn start(&self, task: &Task, _: ExternalLog) -> Result<Box<dyn ExternalSession>, FaultCause> {
        Ok(Box::new(Pursuit {
            path: path(0, &task.path),
            nearest: 0,
            actuator: Actuator::new(&task.vehicle, task.control_period),
        }))
    }
}

#[derive(Debug)]
struct Pursuit {
    path: nav_msgs::Path,
    nearest: usize,
    actuator: Actuator,
}

impl Pursuit {
    fn offset(&self, k: usize, x: f64, y: f64) -> [f64; 2] {
        let place = &self.path.poses[k].pose.position;
        [place.x - x, place.y - y]
    }

    fn distance(&self, k: usize, x: f64, y: f64) -> f64 {
        let [dx, dy] = self.offset(k, x, y);
        dx * dx + dy * dy
    }
}

impl ExternalSession for Pursuit {
    fn step(&mut self, observation: &Observation) -> Result<vb_sdk::Command, FaultCause> {
        const SPEED: f64 = 3.0;
        const LOOK_AHEAD: f64 = 8.0;
        let pose = observation.pose.as_ref().unwrap();
        let message = odometry(0, pose);
        let (place, q) = (&message.pose.pose.position, &message.pose.pose.orientation);
        let last = self.path.poses.len() - 1;
        while self.nearest < last
            && self.distance(self.nearest + 1, place.x, place.y)
                <= self.distance(self.nearest, place.x, place.y)
        {
            self.nearest += 1;
        }
        let mut goal = self.nearest;
        while goal < last && self.distance(goal, place.x, place.y) < LOOK_AHEAD * LOOK_AHEAD {
            goal += 1;
        }
        let [dx, dy] = self.offset(goal, place.x, place.y);
        let (along, left) = (1.0 - 2.0 * (q.y * q.y + q.z * q.z), 2.0 * (q.x * q.y + q.w * q.z));
        let square = dx * dx + dy * dy;
        let curvature = if square > 0.0 { 2.0 * (along * dy - left * dx) / square } else { 0.0 };
        let setpoint = Setpoint::Velocity { linear: SPEED, angular: SPEED * curvature };
        Ok(self.actuator.follow(setpoint, pose.linear_velocity.x))
    }
}

#[test]
fn commands_over_cyclone_dds_are_those_of_the_planner_in_rust() {
    let _alone = alone();
    let Some(python) = python() else { return };
    let _planner = Planner::start(python, &[]);
    // A bend to the left, and a vehicle that drives beside it.
    let mut task = task("w001/t00");
    task.path = (0..=60).map(|k| Point2 { x: f64::from(k), y: 0.01 * f64::from(k * k) }).collect();
    let at = |step: u32| {
        let t = 0.1 * f64::from(step);
        let mut observation = Observation::of(Pose {
            position: Vec3 { x: 3.0 * t, y: 0.07 * t * t + 0.3, z: 1.0 + 0.1 * t },
            roll: 0.05 * t,
            pitch: -0.03 * t,
            yaw: 0.07 * t,
            linear_velocity: Vec3 { x: 2.0 + 0.05 * t, ..Vec3::default() },
            ..Pose::default()
        });
        observation.time = t;
        observation
    };
    let plugin = plugin(options());
    let mut session = plugin.start(&task, vb_host::LogSink::discard()).unwrap();
    let mut twin = Twin.start(&task, Box::new(|_, _| {})).unwrap();
    for step in 0..100 {
        let (found, wanted) = (session.step(&at(step)).unwrap(), twin.step(&at(step)).unwrap());
        assert_eq!(found, wanted, "step {step}");
        assert!(wanted.steering != 0.0 && wanted.throttle > 0.0, "{wanted:?}");
    }
}

#[test]
fn the_service_answers_cyclone_dds() {
    let _alone = alone();
    let Some(python) = python() else { return };
    let _planner = Planner::start(python, &["--step"]);
    let plugin = plugin(options());
    let mut session = start(&plugin).unwrap();
    let steering: Vec<f64> = (0..4).map(|step| session.step(&observation(step)).unwrap().steering).collect();
    assert!(steering.iter().all(|s| *s == steering[0]), "{steering:?}");
}
