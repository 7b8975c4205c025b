//! One run in a frame.

use std::sync::Arc;

use crate::{ReplayRun, attitude};
use vb_math::{angle::degrees, hypot};
use vb_render::{Moment, Painter, RenderError, Sight, Size, View};
use vb_score::Outcome;
use vb_sim::{Gear, VehicleState, WheelState};
use vb_world::World;

use crate::film::caption::Said;
use crate::film::ruts::Ruts;
use crate::film::{Camera, V3, camera};
use crate::grains::Grains;

/// The side of the square that the camera above the vehicle sees, in lengths of the vehicle.
const WINDOW: f64 = 9.0;

/// What panels share.
pub(crate) struct Stage {
    pub(crate) goal: [f64; 2],
    pub(crate) goal_radius: f64,
    pub(crate) path: Vec<[f64; 2]>,
}

/// One run as it is filmed.
pub(crate) struct Panel {
    label: String,
    outcome: Outcome,
    /// The outcome in words, with the cause of a failure.
    ended: String,
    painter: Arc<Painter>,
    /// The states of the frames, at least one, in the order of time.
    states: Vec<VehicleState>,
    /// The angles by which the wheels have turned, rad; so many for each state as it has wheels.
    turned: Vec<f64>,
    /// Roll and pitch of each state, rad.
    leans: Vec<[f64; 2]>,
    /// The line of sight of each state; empty unless the camera follows the vehicle.
    sights: Vec<Sight>,
    trail: Vec<[f64; 3]>,
    ruts: Ruts,
    grains: Grains,
    view: View,
    colour: [u8; 3],
}

/// Between which states a moment lies: the one before it, the one after it, and how far it is from the one to the other, in [0, 1].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Between(usize, usize, f64);

impl Between {
    fn of(self, at: impl Fn(usize) -> f64) -> f64 {
        let Self(a, b, share) = self;
        at(a) + share * (at(b) - at(a))
    }

    fn point(self, at: impl Fn(usize) -> V3) -> V3 {
        let Self(a, b, share) = self;
        at(a) + share * (at(b) - at(a))
    }
}

impl Panel {
    /// Prepares a run with at least one frame. `painter` draws its vehicle, of this length in m, in the world.
    pub(crate) fn new(
        run: &ReplayRun,
        world: &World,
        painter: Arc<Painter>,
        length: f64,
        from: Camera,
        colour: [u8; 3],
    ) -> Self {
        let motion = &run.motion;
        let wheels = motion.wheels;
        let states: Vec<VehicleState> = motion
            .frames
            .iter()
            .zip(&motion.steering)
            .enumerate()
            .map(|(k, (s, steering))| VehicleState {
                time: s.time,
                position: V3::new(s.x, s.y, s.z),
                attitude: attitude(s),
                velocity_body: V3::new(s.vx, s.vy, s.vz),
                angular_velocity_body: V3::new(s.wx, s.wy, s.wz),
                wheels: motion.wheel_frames[k * wheels..(k + 1) * wheels]
                    .iter()
                    .map(|w| WheelState { deflection: w.travel, ..WheelState::default() })
                    .collect(),
                steering: *steering,
                gear: Gear::Forward,
                engine_speed: 0.0,
            })
            .collect();
        let (sights, view) = match from {
            Camera::Chase => (camera::chase(&painter, &states, world.scale.sqrt()), View::Chase),
            Camera::Top => (Vec::new(), View::Top { window: Some(WINDOW * length) }),
            Camera::Map => (Vec::new(), View::Top { window: None }),
        };
        let outcome = run.record.outcome;
        let mut ended = outcome.name().replace('_', " ");
        if let Some(cause) = run.record.cause {
            ended = format!("{ended}: {}", cause.title());
        }
        Self {
            label: run.label.clone(),
            outcome,
            ended,
            trail: states.iter().map(|s| s.position.into()).collect(),
            turned: motion.wheel_frames.iter().map(|w| w.angle).collect(),
            leans: motion.frames.iter().map(|f| [f.roll, f.pitch]).collect(),
            ruts: Ruts::new(motion, world),
            grains: motion.grains.clone(),
            painter,
            states,
            sights,
            view,
            colour,
        }
    }

    /// The time of the last frame, s.
    pub(crate) fn end(&self) -> f64 {
        self.states[self.states.len() - 1].time
    }

    /// The states about a moment; at and after the end the last one.
    fn between(&self, time: f64) -> Between {
        let last = self.states.len() - 1;
        let after = self.states.partition_point(|s| s.time <= time);
        let Some(k) = after.checked_sub(1) else { return Between(0, 0, 0.0) };
        if k == last {
            return Between(last, last, 0.0);
        }
        let (a, b) = (self.states[k].time, self.states[k + 1].time);
        Between(k, k + 1, (time - a) / (b - a))
    }

    /// The state at a moment, and the angles by which the wheels have turned until then, rad.
    fn state(&self, between: Between) -> (VehicleState, Vec<f64>) {
        let Between(a, b, share) = between;
        let states = &self.states;
        let wheels = states[a].wheels.len();
        let turned = (0..wheels).map(|w| between.of(|k| self.turned[k * wheels + w])).collect();
        let state = VehicleState {
            time: between.of(|k| states[k].time),
            position: between.point(|k| states[k].position),
            // Between frames that are a fiftieth of a second apart this is as good as a turn at an even rate.
            attitude: states[a].attitude.nlerp(&states[b].attitude, share),
            velocity_body: between.point(|k| states[k].velocity_body),
            angular_velocity_body: between.point(|k| states[k].angular_velocity_body),
            wheels: (0..wheels)
                .map(|w| WheelState {
                    deflection: between.of(|k| states[k].wheels[w].deflection),
                    ..WheelState::default()
                })
                .collect(),
            steering: between.of(|k| states[k].steering),
            ..states[a].clone()
        };
        (state, turned)
    }

    pub(crate) fn picture(&self, stage: &Stage, time: f64, size: Size) -> Result<Vec<u8>, RenderError> {
        let between = self.between(time);
        let (state, turned) = self.state(between);
        let view = match self.sights.get(between.0) {
            None => self.view,
            Some(_) => {
                let at = |of: &dyn Fn(&Sight) -> [f64; 3]| -> [f64; 3] {
                    between.point(|k| V3::from(of(&self.sights[k]))).into()
                };
                View::From(Sight { eye: at(&|s| s.eye), at: at(&|s| s.at) })
            }
        };
        let mut trail = self.trail[..=between.0].to_vec();
        trail.push(state.position.into());
        let change = |x: f64, y: f64| self.ruts.change(time, x, y);
        let grains = self.grains.at(time);
        let moment = Moment {
            state: &state,
            turned: &turned,
            goal: stage.goal,
            goal_radius: stage.goal_radius,
            path: &stage.path,
            trail: &trail,
            change: (!self.ruts.is_empty()).then_some(&change),
            grains: &grains,
            colour: Some(self.colour),
        };
        self.painter.picture(view, size, &moment)
    }

    pub(crate) fn said(&self, time: f64) -> Said<'_> {
        let between = self.between(time);
        let Between(a, ..) = between;
        let [roll, pitch] = self.leans[a];
        let velocity = between.point(|k| self.states[k].velocity_body);
        Said {
            label: &self.label,
            colour: self.colour,
            time: time.min(self.end()),
            speed: hypot(hypot(velocity.x, velocity.y), velocity.z),
            roll: degrees(roll),
            pitch: degrees(pitch),
            ended: (time >= self.end()).then_some((self.ended.as_str(), self.outcome == Outcome::Success)),
        }
    }
}
