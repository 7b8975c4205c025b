//! Detects lack of progress, reverses along the track and retries.
//!
//! [`Recovery`] is a filter between a planner and the vehicle: it receives every observation with the planner's
//! command, and returns the command to apply. While the vehicle makes progress, it returns the planner's command
//! unchanged.
//!
//! The rules end a task if the vehicle is within 1 m of its position 10 s before (docs/scoring.md). A recovery must
//! therefore not return to its positions of 10 s before: neither while reversing, nor on returning to the obstacle. The
//! helper stores the positions of that window and limits the reversing distance accordingly. Repeated attempts at the
//! same obstacle reach the limit eventually, unless the vehicle has moved 1 m to the side. There is thus time for one
//! or two attempts at a place, which start early and are short.

use std::collections::VecDeque;

use crate::speed::SpeedController;
use crate::{Command, Gear, Observation, Point2, Pose, Task, Vehicle, math};

/// The settings of [`Recovery`]. [`Settings::default`] applies to a full-scale vehicle, [`Settings::scaled`] to a
/// smaller vehicle.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The displacement that counts as progress, m.
    pub progress: f64,
    /// The time without progress, while the planner commands motion, after which the vehicle is stuck, s.
    pub patience: f64,
    /// The wheels spin if the vehicle's speed is below this fraction of the tread speed, in [0, 1].
    pub grip: f64,
    /// The factor by which the time limit without progress elapses faster while the wheels spin, 1 or more. The
    /// remaining time must suffice for a start from rest with spinning wheels over the distance `progress`.
    pub haste: f64,
    /// The reversing distance of the first attempt, m.
    pub back: f64,
    /// The increase of the reversing distance per further attempt, m.
    pub back_more: f64,
    /// The maximum reversing distance, m.
    pub back_most: f64,
    /// The speed in reverse, m/s, positive.
    pub back_speed: f64,
    /// The look-ahead distance on the vehicle's own track in reverse, m.
    pub lookahead: f64,
    /// The speed of the retry, m/s.
    pub run_up: f64,
    /// The steering offset of the first section of a retry, in [0, 1]. It leads to another path: to the left after odd
    /// attempts, to the right after even attempts.
    pub offset: f64,
    /// The distance past the place where the vehicle was stuck at which an attempt has succeeded, m.
    pub clear: f64,
    /// The distance from the place where the vehicle was stuck at which the attempt counter resets, m.
    pub forget: f64,
    /// The time without progress in reverse after which the vehicle drives forward, s. It also elapses faster with
    /// spinning wheels.
    pub back_patience: f64,
    /// The amplitude of steering oscillations of an immobile vehicle, in [0, 1]: wheels in a rut find new grip.
    pub swing: f64,
    /// The duration of an oscillation to one side, s.
    pub swing_time: f64,
    /// The duration of steering oscillations in forward gear after reversing failed, before reverse is tried again, s.
    pub swing_on: f64,
    /// The minimum distance of the rear from the edge of the world, m.
    pub margin: f64,
    /// The window of the stuck rule, s.
    pub window: f64,
    /// The minimum distance from earlier positions, m: that of the stuck rule, with a margin for prediction errors.
    pub apart: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            progress: 0.5,
            patience: 2.0,
            grip: 0.3,
            haste: 2.0,
            back: 4.0,
            back_more: 2.0,
            back_most: 12.0,
            back_speed: 2.5,
            lookahead: 4.0,
            run_up: 5.0,
            offset: 0.5,
            clear: 3.0,
            forget: 10.0,
            back_patience: 3.0,
            swing: 0.7,
            swing_time: 0.8,
            swing_on: 1.6,
            margin: 1.0,
            window: 10.0,
            apart: 1.4,
        }
    }
}

impl Settings {
    /// Scales the settings to a vehicle ([`Vehicle::scale`]) with Froude scaling, like the rules of a task: lengths
    /// scale with the scale, times and speeds with its square root.
    #[must_use]
    pub fn scaled(&self, scale: f64) -> Self {
        let root = scale.sqrt();
        Self {
            progress: self.progress * scale,
            patience: self.patience * root,
            back: self.back * scale,
            back_more: self.back_more * scale,
            back_most: self.back_most * scale,
            back_speed: self.back_speed * root,
            lookahead: self.lookahead * scale,
            run_up: self.run_up * root,
            clear: self.clear * scale,
            forget: self.forget * scale,
            back_patience: self.back_patience * root,
            swing_time: self.swing_time * root,
            swing_on: self.swing_on * root,
            margin: self.margin * scale,
            window: self.window * root,
            apart: self.apart * scale,
            ..self.clone()
        }
    }
}

/// The state of [`Recovery`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The planner drives.
    Drive,
    /// The vehicle stops, changes to reverse and reverses.
    Back,
    /// The vehicle changes to forward and retries on another path at the retry speed: the planner's steering with an
    /// offset, without its throttle and brake.
    Again,
}

/// A position of the vehicle.
#[derive(Clone, Copy, Debug)]
struct Mark {
    time: f64,
    x: f64,
    y: f64,
}

/// Capacity of the position history.
const MARKS: usize = 128;
/// Capacity of the track, and points per look-ahead distance.
const TRACK: usize = 64;
const PER_LOOKAHEAD: f64 = 8.0;
/// Step and horizon of predictions while reversing, as fractions of the stuck rule's window.
const AHEAD: f64 = 0.02;
const SOON: f64 = 0.08;
/// A change of direction has failed after its specified time plus this fraction of the window.
const LATE: f64 = 0.3;
/// The fraction of the time limit in reverse after which the wheels oscillate.
const STILL: f64 = 0.15;
/// The fraction of the return path with a steering offset.
const ASIDE: f64 = 0.6;

/// Detects a stuck vehicle, reverses along its track and retries.
///
/// It needs the pose in every step, and uses the wheel speeds if available. It does not intervene if the planner
/// reverses or stands. A vehicle without a reverse gear, or one that cannot reverse, oscillates its front wheels
/// instead.
#[derive(Clone, Debug)]
pub struct Recovery {
    settings: Settings,
    vehicle: Vehicle,
    half_extent: Point2,
    speed: SpeedController,
    phase: Phase,
    attempts: u32,
    /// Positions in the window of the stuck rule, oldest first.
    history: VecDeque<Mark>,
    /// The track up to the current position.
    track: VecDeque<Point2>,
    last: Option<Mark>,
    /// The position of the last progress, and the time with commanded motion since then, s.
    anchor: Point2,
    waited: f64,
    /// Time and position of the start of the phase, and the distance driven since, m.
    since: Mark,
    gone: f64,
    /// The position where the vehicle was stuck, and the length of the return path, m.
    blocked: Point2,
    approach: f64,
    /// Whether the steering oscillates during the retry, because reversing failed.
    swings: bool,
}

impl Recovery {
    /// Creates a helper for a task.
    #[must_use]
    pub fn new(task: &Task, settings: Settings) -> Self {
        let start = Mark { time: 0.0, x: task.start.x, y: task.start.y };
        Self {
            speed: SpeedController::new(1.0 / task.vehicle.scale.sqrt(), 0.0),
            settings,
            vehicle: task.vehicle.clone(),
            half_extent: task.half_extent,
            phase: Phase::Drive,
            attempts: 0,
            history: VecDeque::with_capacity(MARKS),
            track: VecDeque::with_capacity(TRACK),
            last: None,
            anchor: Point2 { x: start.x, y: start.y },
            waited: 0.0,
            since: start,
            gone: 0.0,
            blocked: Point2 { x: start.x, y: start.y },
            approach: 0.0,
            swings: false,
        }
    }

    /// The current phase.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// The number of attempts at the current or last place where the vehicle was stuck; 0 after leaving it.
    #[must_use]
    pub fn attempts(&self) -> u32 {
        self.attempts
    }

    /// The current or last place where the vehicle was stuck; absent after leaving it. Planners can re-plan around it.
    #[must_use]
    pub fn blocked(&self) -> Option<Point2> {
        (self.attempts > 0).then_some(self.blocked)
    }

    /// Returns the command to apply in place of `wanted`, the planner's command. It must be called in every step.
    pub fn update(&mut self, o: &Observation, wanted: Command) -> Command {
        let Some(pose) = o.pose.filter(|p| is_finite(p) && o.time.is_finite()) else { return wanted };
        let now = Mark { time: o.time, x: pose.position.x, y: pose.position.y };
        let (dt, moved) = match self.last {
            Some(l) if l.time <= now.time => {
                ((now.time - l.time).min(0.1 * self.settings.window), math::hypot(now.x - l.x, now.y - l.y))
            }
            _ => {
                self.history.clear();
                self.track.clear();
                (0.0, 0.0)
            }
        };
        self.last = Some(now);
        self.gone += moved;
        self.remember(now, &pose, o.gear);
        if self.phase == Phase::Drive && (wanted.gear != Gear::Forward || o.gear == Gear::Reverse) {
            self.get_on(now);
            return wanted;
        }
        if math::hypot(now.x - self.anchor.x, now.y - self.anchor.y) > self.settings.progress {
            self.get_on(now);
        }
        let wheels = self.wheel_speed(o);
        let spinning = pose.linear_velocity.x.abs() < self.settings.grip * wheels
            && wheels > self.settings.progress / self.settings.patience;
        self.waited += if wanted.throttle > 0.0 || self.phase != Phase::Drive {
            if spinning { self.settings.haste * dt } else { dt }
        } else {
            0.0
        };
        match self.phase {
            Phase::Drive => {
                let from = math::hypot(now.x - self.blocked.x, now.y - self.blocked.y);
                if from > self.settings.forget {
                    self.attempts = 0;
                }
                if self.waited <= self.settings.patience {
                    return wanted;
                }
                self.attempt(now);
            }
            Phase::Back => {
                if o.gear != Gear::Reverse {
                    self.waited = 0.0;
                }
                if self.has_backed(now, &pose, o.gear) {
                    self.come_again(now);
                }
            }
            Phase::Again => {
                if o.gear != Gear::Forward {
                    self.waited = 0.0;
                }
                if self.waited > self.settings.patience && !self.swings_on(now) {
                    self.attempt(now);
                } else if self.gone > self.approach + self.settings.clear {
                    self.enter(Phase::Drive, now);
                    return wanted;
                }
            }
        }
        match self.phase {
            Phase::Drive => wanted,
            Phase::Back => self.backward(now, &pose, o.gear, dt),
            Phase::Again => self.forward(now, &pose, o.gear, wanted, dt),
        }
    }

    /// Starts the next attempt: reverses, or oscillates the wheels without a reverse gear.
    fn attempt(&mut self, now: Mark) {
        self.attempts = self.attempts.saturating_add(1);
        self.blocked = Point2 { x: now.x, y: now.y };
        if self.vehicle.max_reverse_speed > 0.0 {
            self.enter(Phase::Back, now);
        } else {
            self.come_again(now);
        }
    }

    fn come_again(&mut self, now: Mark) {
        self.approach = math::hypot(now.x - self.blocked.x, now.y - self.blocked.y);
        self.swings = self.approach < 2.0 * self.settings.progress;
        self.enter(Phase::Again, now);
    }

    fn enter(&mut self, phase: Phase, now: Mark) {
        self.phase = phase;
        self.since = now;
        self.gone = 0.0;
        self.get_on(now);
    }

    fn get_on(&mut self, now: Mark) {
        self.anchor = Point2 { x: now.x, y: now.y };
        self.waited = 0.0;
    }

    /// Whether a vehicle with oscillating wheels continues: always without a reverse gear.
    fn swings_on(&self, now: Mark) -> bool {
        let time = self.vehicle.direction_change_time + self.settings.swing_on;
        self.swings && (self.vehicle.max_reverse_speed <= 0.0 || now.time - self.since.time < time)
    }

    /// The steering of the oscillation: initially to the left after odd attempts.
    fn swing(&self, now: Mark) -> f64 {
        let swings = ((now.time - self.since.time) / self.settings.swing_time).max(0.0) as u64;
        if swings.is_multiple_of(2) {
            self.side() * self.settings.swing
        } else {
            -self.side() * self.settings.swing
        }
    }

    /// The side of this attempt: 1 to the left, -1 to the right.
    fn side(&self) -> f64 {
        if self.attempts % 2 == 1 { 1.0 } else { -1.0 }
    }

    /// Whether to change to forward.
    fn has_backed(&self, now: Mark, pose: &Pose, gear: Gear) -> bool {
        let s = &self.settings;
        if gear != Gear::Reverse {
            // The gear change has failed.
            return now.time - self.since.time > self.vehicle.direction_change_time + LATE * s.window;
        }
        if self.waited > s.back_patience {
            return true;
        }
        let (sin, cos) = math::sin_cos(pose.yaw);
        let rear = 0.5 * self.vehicle.length + s.margin;
        let out = |at: f64, towards: f64, half: f64| at.abs() > half && at * towards > 0.0;
        if out(now.x - cos * rear, -cos, self.half_extent.x)
            || out(now.y - sin * rear, -sin, self.half_extent.y)
        {
            return true;
        }
        let back = math::hypot(now.x - self.blocked.x, now.y - self.blocked.y);
        if back < 2.0 * s.progress {
            return false;
        }
        let most = s.back_most.max(s.back);
        let enough = (s.back + s.back_more * f64::from(self.attempts.saturating_sub(1))).min(most);
        if back >= most
            || self.meets_itself(now, |t| self.on_the_way(now, back, back + s.back_speed * t), SOON)
        {
            return true;
        }
        // Time to change gear, to return, and to detect and reverse again.
        let change = self.vehicle.direction_change_time + 0.05 * s.window;
        let there = change + back / (0.7 * s.run_up);
        let stay = there + s.patience + self.vehicle.direction_change_time + s.apart / s.back_speed;
        back >= enough
            && !self.meets_itself(
                now,
                |t| {
                    let to = ((t - change) / (there - change)).clamp(0.0, 1.0);
                    self.on_the_way(now, back, back * (1.0 - to))
                },
                stay / s.window,
            )
    }

    /// The position at a distance from the place where the vehicle was stuck, on the line to the current position
    /// `back` metres away, m.
    fn on_the_way(&self, now: Mark, back: f64, distance: f64) -> (f64, f64) {
        let k = distance / back;
        (self.blocked.x + k * (now.x - self.blocked.x), self.blocked.y + k * (now.y - self.blocked.y))
    }

    /// Whether a predicted path, as position over time, approaches the vehicle's positions one window before, within
    /// this fraction of the window from now.
    fn meets_itself(&self, now: Mark, course: impl Fn(f64) -> (f64, f64), share: f64) -> bool {
        let s = &self.settings;
        let steps = (share.min(1.0) / AHEAD) as u32;
        (1..=steps).any(|i| {
            let t = f64::from(i) * AHEAD * s.window;
            let (x, y) = course(t);
            self.place_at(now.time + t - s.window)
                .is_some_and(|(px, py)| math::hypot(x - px, y - py) < s.apart)
        })
    }

    /// The vehicle's position at a time, if known.
    fn place_at(&self, time: f64) -> Option<(f64, f64)> {
        let i = self.history.partition_point(|m| m.time < time);
        let (a, b) = (self.history.get(i.checked_sub(1)?)?, self.history.get(i)?);
        let k = (time - a.time) / (b.time - a.time);
        Some((a.x + k * (b.x - a.x), a.y + k * (b.y - a.y)))
    }

    fn remember(&mut self, now: Mark, pose: &Pose, gear: Gear) {
        let s = &self.settings;
        // Positions at regular times. The margin aligns them with whole multiples of a control period.
        let spacing = s.window / (MARKS - 2) as f64;
        if self.history.back().is_none_or(|m| now.time - m.time > spacing) {
            if self.history.len() == MARKS {
                self.history.pop_front();
            }
            self.history.push_back(now);
        }
        let spacing = s.lookahead / PER_LOOKAHEAD;
        if gear == Gear::Reverse {
            // Track points that the vehicle has passed in reverse are removed.
            while self.track.back().is_some_and(|p| seen_from(pose, *p).0 > -0.5 * spacing) {
                self.track.pop_back();
            }
        } else if self.track.back().is_none_or(|p| math::hypot(now.x - p.x, now.y - p.y) > spacing) {
            if self.track.len() == TRACK {
                self.track.pop_front();
            }
            self.track.push_back(Point2 { x: now.x, y: now.y });
        }
    }

    /// The absolute mean tread speed of the wheels, m/s; 0 without wheels.
    fn wheel_speed(&self, o: &Observation) -> f64 {
        let sum: f64 = o.wheels.iter().map(|w| w.spin).filter(|s| s.is_finite()).sum();
        if o.wheels.is_empty() {
            0.0
        } else {
            (sum / o.wheels.len() as f64 * self.vehicle.wheel_radius).abs()
        }
    }

    /// Reverses along the track after the change to reverse; before it, brakes, because the gearbox changes at rest.
    fn backward(&mut self, now: Mark, pose: &Pose, gear: Gear, dt: f64) -> Command {
        let s = &self.settings;
        let goal = self
            .track
            .iter()
            .rev()
            .map(|p| seen_from(pose, *p))
            .take_while(|(x, _)| *x < 0.0)
            .find(|(x, y)| math::hypot(*x, *y) >= s.lookahead);
        // The circle through a point behind the vehicle, tangent to the vehicle's axis, is the same for both directions
        // of travel, and so is the steering. Without a track the vehicle reverses straight.
        let pursuit = goal.map_or(0.0, |(x, y)| {
            math::atan(2.0 * self.vehicle.wheelbase * y / (x * x + y * y)) / self.vehicle.max_steer_angle
        });
        let aside = if self.waited > STILL * s.back_patience { self.swing(now) } else { 0.0 };
        let steering = pursuit + aside;
        let steering = if steering.is_finite() { steering.clamp(-1.0, 1.0) } else { 0.0 };
        let target = s.back_speed.min(self.vehicle.max_reverse_speed);
        let (throttle, brake) = match gear {
            Gear::Reverse => self.speed.update(target, -pose.linear_velocity.x, dt),
            _ => (0.0, 1.0),
        };
        Command { steering, throttle, brake, gear: Gear::Reverse, ..Command::default() }
    }

    /// Retries with the planner's steering plus an offset, at the retry speed. It brakes until a forward gear is
    /// engaged.
    fn forward(&mut self, now: Mark, pose: &Pose, gear: Gear, wanted: Command, dt: f64) -> Command {
        let s = &self.settings;
        let aside = if self.swings {
            self.swing(now)
        } else if self.gone < ASIDE * self.approach {
            self.side() * s.offset
        } else {
            0.0
        };
        let steering = (wanted.steering + aside).clamp(-1.0, 1.0);
        let (throttle, brake) = match gear {
            Gear::Forward => self.speed.update(s.run_up, pose.linear_velocity.x, dt),
            _ => (0.0, 1.0),
        };
        Command { steering, throttle, brake, gear: Gear::Forward, ..wanted }
    }
}

/// A point in vehicle axes: forward, left, m.
fn seen_from(pose: &Pose, p: Point2) -> (f64, f64) {
    let (sin, cos) = math::sin_cos(pose.yaw);
    let (dx, dy) = (p.x - pose.position.x, p.y - pose.position.y);
    (cos * dx + sin * dy, cos * dy - sin * dx)
}

fn is_finite(p: &Pose) -> bool {
    [p.position.x, p.position.y, p.yaw, p.linear_velocity.x].iter().all(|v| v.is_finite())
}

#[cfg(test)]
mod tests;
