//! The estimate of the vehicle's state.
//!
//! An estimated pose is dead reckoning: it begins at the true start and adds each true step of the position turned by the
//! error of the heading, so an error of the heading grows into one across the way. Heading and position also walk at random
//! with the way that is driven (Kelly, "Linearized error propagation in odometry", Int. J. Robotics Research 23, 2004, on how
//! errors of dead reckoning grow with the way). Roll and pitch are known from gravity and keep a bounded error.

use super::DT;
use crate::V3;
use crate::frame::{Frame, attitude, vec3};
use crate::noise::{GaussMarkov, RandomWalk, Seed, White};
use crate::profile::{PoseModel, PoseNoise};
use vb_math::angle::{radians, wrap};
use vb_sdk::Pose;
use vb_sim::VehicleState;

#[derive(Clone, Debug)]
struct Errors {
    heading: RandomWalk,
    walk: [RandomWalk; 3],
    /// What an error of the heading has made of the position, m.
    turned: V3,
    tilt: [GaussMarkov; 2],
    velocity: [White; 3],
    angular_velocity: [White; 3],
}

#[derive(Clone, Debug)]
pub(crate) struct Estimator {
    /// Samples between readings; none for a reading whenever the planner looks.
    every: Option<u64>,
    errors: Option<Errors>,
    /// The last two estimates, and where they say that the vehicle is.
    pose: Pose,
    frames: [Frame; 2],
    ready: Option<Pose>,
}

pub(crate) fn exact(state: &VehicleState) -> Pose {
    let (roll, pitch, yaw) = state.roll_pitch_yaw();
    Pose {
        position: vec3(&state.position),
        roll,
        pitch,
        yaw,
        linear_velocity: vec3(&state.velocity_body),
        angular_velocity: vec3(&state.angular_velocity_body),
    }
}

impl Errors {
    fn new(noise: &PoseNoise, scale: f64, seed: &Seed) -> Self {
        let stream = |part: &str| seed.stream("pose", part);
        // The same task at another scale takes as many vehicle lengths, and gathers the same error of the heading.
        let per_sqrt = 1.0 / scale.sqrt();
        let walk = |rate: f64, part: &str| RandomWalk::new(rate * scale * per_sqrt, 0.0, stream(part));
        let tilt = |part: &str| {
            GaussMarkov::new(radians(noise.tilt.std_deg), noise.tilt.correlation_s, DT, stream(part))
        };
        let white = |std: f64, what: &str| {
            ["x", "y", "z"].map(|axis| White::new(std, stream(&format!("{what} {axis}"))))
        };
        Self {
            heading: RandomWalk::new(noise.heading_walk_rad_per_sqrt_m * per_sqrt, 0.0, stream("heading")),
            walk: [
                walk(noise.position_walk_m_per_sqrt_m, "x"),
                walk(noise.position_walk_m_per_sqrt_m, "y"),
                walk(noise.height_walk_m_per_sqrt_m, "z"),
            ],
            turned: V3::zeros(),
            tilt: [tilt("roll"), tilt("pitch")],
            velocity: white(noise.velocity_std_m_per_s * scale.sqrt(), "velocity"),
            angular_velocity: white(noise.angular_velocity_std_rad_per_s, "angular velocity"),
        }
    }

    fn step(&mut self, before: &VehicleState, now: &VehicleState) -> Pose {
        let way = now.position - before.position;
        let (s, c) = vb_math::sin_cos(self.heading.value());
        self.turned += V3::new(c * way.x - s * way.y - way.x, s * way.x + c * way.y - way.y, 0.0);
        let length = way.norm();
        let heading = self.heading.step(length);
        let mut position = now.position + self.turned;
        let (mut velocity, mut rate) = (now.velocity_body, now.angular_velocity_body);
        for k in 0..3 {
            position[k] += self.walk[k].step(length);
            velocity[k] += self.velocity[k].step();
            rate[k] += self.angular_velocity[k].step();
        }
        let (roll, pitch, yaw) = now.roll_pitch_yaw();
        Pose {
            position: vec3(&position),
            roll: roll + self.tilt[0].step(),
            pitch: pitch + self.tilt[1].step(),
            yaw: wrap(yaw + heading),
            linear_velocity: vec3(&velocity),
            angular_velocity: vec3(&rate),
        }
    }
}

impl Estimator {
    pub(crate) fn new(model: &PoseModel, every: Option<u64>, scale: f64, seed: &Seed) -> Self {
        let errors = match model {
            PoseModel::Exact => None,
            PoseModel::Estimated(noise) => Some(Errors::new(noise, scale, seed)),
        };
        let nowhere = Frame { at: V3::zeros(), turn: crate::Quat::identity() };
        Self { every, errors, pose: Pose::default(), frames: [nowhere; 2], ready: None }
    }

    /// Whether a planner's reading takes no samples.
    pub(crate) fn is_idle(&self) -> bool {
        self.errors.is_none() && self.every.is_none()
    }

    /// Takes the state at sample `k` and the one before it.
    pub(crate) fn sample(&mut self, k: u64, before: &VehicleState, now: &VehicleState) {
        let frame = match &mut self.errors {
            None => {
                self.pose = exact(now);
                Frame::of(now)
            }
            Some(errors) => {
                let pose = errors.step(before, now);
                self.pose = pose;
                let p = pose.position;
                Frame { at: V3::new(p.x, p.y, p.z), turn: attitude(pose.roll, pose.pitch, pose.yaw) }
            }
        };
        self.frames = [if k == 0 { frame } else { self.frames[1] }, frame];
        if self.every.is_some_and(|n| k.is_multiple_of(n)) {
            self.ready = Some(self.pose);
        }
    }

    /// Where the vehicle is by the estimate, `share` of the way from the last sample to this one.
    pub(crate) fn frame(&self, share: f64) -> Frame {
        self.frames[0].towards(&self.frames[1], share)
    }

    /// The reading at a step of the planner, if there is a new one.
    pub(crate) fn read(&mut self, state: &VehicleState) -> Option<Pose> {
        if self.is_idle() {
            return Some(exact(state));
        }
        if self.every.is_none() { Some(self.pose) } else { self.ready.take() }
    }
}
