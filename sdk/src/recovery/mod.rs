//! Getting a stuck vehicle free: noticing that it doesn't get on, backing out along its own track, and coming again.
//!
//! [`Recovery`] stands between a planner and the vehicle. It is given every observation with the command that the
//! planner would send, and returns the command to send. While the vehicle gets on, that is the planner's own, bit for
//! bit.
//!
//! The rules end a task whose vehicle is less than 1 m from where it was 10 s before (docs/scoring.md), so a vehicle that
//! backs out and comes again must not meet its own past: neither where it backs over the place at which it was 10 s
//! before, nor where it comes back to the obstacle 10 s after it first stood there. The helper keeps the positions of that
//! time, and chooses how far it backs by them. It can't avoid its past for ever: what lies 10 s behind comes up to the
//! obstacle as the vehicle did, and a vehicle that is still before the obstacle then must be 1 m to the side. So
//! there is time for one attempt or two at a place, and they begin early and are short.

use std::collections::VecDeque;

use crate::speed::SpeedController;
use crate::{Command, Gear, Observation, Point2, Pose, Task, Vehicle, math};

/// What [`Recovery`] goes by. [`Settings::default`] has the values for a vehicle of full size, and
/// [`Settings::scaled`] those for a smaller one.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// A vehicle that has come this far from where it was gets on, m.
    pub progress: f64,
    /// The time that a vehicle may want to move without getting on, s.
    pub patience: f64,
    /// The wheels spin if the vehicle has less than this share of their speed, in [0, 1].
    pub grip: f64,
    /// How many times faster the patience ends while the wheels spin, 1 or more. What is left must suffice for a start
    /// from rest with spinning wheels over the distance `progress`.
    pub haste: f64,
    /// The distance by which the first attempt backs, m.
    pub back: f64,
    /// The distance by which each further attempt backs more, m.
    pub back_more: f64,
    /// The greatest distance by which an attempt backs, m.
    pub back_most: f64,
    /// The speed in reverse, m/s, positive.
    pub back_speed: f64,
    /// The distance of the point of the own track that is steered to in reverse, m.
    pub lookahead: f64,
    /// The speed to which a vehicle is driven as it comes again, m/s.
    pub run_up: f64,
    /// The steering command that is added on the first part of the way as a vehicle comes again, in [0, 1]. It brings
    /// the vehicle onto another line: to the left after the odd attempts, to the right after the even ones.
    pub offset: f64,
    /// An attempt has succeeded when the vehicle is this far past the place where it was stuck, m.
    pub clear: f64,
    /// The distance from the place where the vehicle was stuck at which the attempts are counted anew, m.
    pub forget: f64,
    /// The time for which a vehicle in reverse may want to move without getting on before it is driven forward, s. The
    /// haste of spinning wheels holds for it, too.
    pub back_patience: f64,
    /// The steering command by which a vehicle that can't move swings its wheels to both sides, in [0, 1]: wheels in a
    /// rut find another hold.
    pub swing: f64,
    /// The time for which it swings to one side, s.
    pub swing_time: f64,
    /// The time for which a vehicle that couldn't back out swings while it is driven forward, before it tries reverse
    /// again, s.
    pub swing_on: f64,
    /// The distance that the rear keeps from the edge of the world, m.
    pub margin: f64,
    /// The time after which the rules compare positions, s.
    pub window: f64,
    /// The distance by which the positions are kept different, m: what the rules want, and some for errors of the
    /// prediction.
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
    /// The settings for a vehicle of this scale ([`Vehicle::scale`]) by Froude's rule, as the rules of a task are scaled
    /// themselves: lengths are multiplied by the scale, times and speeds by its square root.
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

/// What [`Recovery`] is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The planner drives.
    Drive,
    /// The vehicle stops, changes into reverse and backs out.
    Back,
    /// The vehicle changes into forward and comes again, on another line and with a run-up: it steers as the planner
    /// wants with an offset, and doesn't heed the planner's throttle and brake.
    Again,
}

/// A position of the vehicle.
#[derive(Clone, Copy, Debug)]
struct Mark {
    time: f64,
    x: f64,
    y: f64,
}

/// Positions in the history.
const MARKS: usize = 128;
/// Points of the track, and how many of them lie in a lookahead.
const TRACK: usize = 64;
const PER_LOOKAHEAD: f64 = 8.0;
/// The step of a prediction and its horizon while backing, as a share of the rules' window.
const AHEAD: f64 = 0.02;
const SOON: f64 = 0.08;
/// A change of direction that takes longer than the vehicle's time for it by this share of the window has failed.
const LATE: f64 = 0.3;
/// The share of the patience in reverse after which a vehicle swings its wheels.
const STILL: f64 = 0.15;
/// The share of the way back to the obstacle on which a vehicle steers to the side.
const ASIDE: f64 = 0.6;

/// Notices a stuck vehicle, backs it out along its own track and drives it on again.
///
/// It needs the pose in every step, and makes use of the wheels' speeds if there are any. A planner that drives in
/// reverse or stands by its own choice is left alone. A vehicle without a reverse gear swings its front wheels to both
/// sides instead, and so does one that can't move backwards either.
#[derive(Clone, Debug)]
pub struct Recovery {
    settings: Settings,
    vehicle: Vehicle,
    half_extent: Point2,
    speed: SpeedController,
    phase: Phase,
    attempts: u32,
    /// Where and when the vehicle was seen at each time of the rules' window, oldest first.
    history: VecDeque<Mark>,
    /// The way on which it came, up to where it is.
    track: VecDeque<Point2>,
    last: Option<Mark>,
    /// Where it was last seen to get on, and for how long it has wanted to move since, s.
    anchor: Point2,
    waited: f64,
    /// When the phase began, where, and the length of the way since, m.
    since: Mark,
    gone: f64,
    /// Where the vehicle was stuck, and the length of the way there when it comes again, m.
    blocked: Point2,
    approach: f64,
    /// Whether it moves its steering from side to side as it comes again, because it couldn't back out.
    swings: bool,
}

impl Recovery {
    /// A helper for a task.
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

    /// What it is doing.
    #[must_use]
    pub fn phase(&self) -> Phase {
        self.phase
    }

    /// The number of attempts at the place where the vehicle is or was last stuck; 0 when it has left it behind.
    #[must_use]
    pub fn attempts(&self) -> u32 {
        self.attempts
    }

    /// The place where the vehicle is or was last stuck; absent when it has left it behind. A planner may want to plan a
    /// way round it.
    #[must_use]
    pub fn blocked(&self) -> Option<Point2> {
        (self.attempts > 0).then_some(self.blocked)
    }

    /// The command to send in place of `wanted`, the planner's. It must be called in every step.
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

    /// Backs out for the next time, or swings if the vehicle can't.
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

    /// Whether a vehicle that swings goes on with that: always without a reverse gear.
    fn swings_on(&self, now: Mark) -> bool {
        let time = self.vehicle.direction_change_time + self.settings.swing_on;
        self.swings && (self.vehicle.max_reverse_speed <= 0.0 || now.time - self.since.time < time)
    }

    /// The steering of the wheels' swings: to the left at first after odd attempts.
    fn swing(&self, now: Mark) -> f64 {
        let swings = ((now.time - self.since.time) / self.settings.swing_time).max(0.0) as u64;
        if swings.is_multiple_of(2) {
            self.side() * self.settings.swing
        } else {
            -self.side() * self.settings.swing
        }
    }

    /// The side to which this attempt goes: 1 to the left, -1 to the right.
    fn side(&self) -> f64 {
        if self.attempts % 2 == 1 { 1.0 } else { -1.0 }
    }

    /// Whether it is time to go forward again.
    fn has_backed(&self, now: Mark, pose: &Pose, gear: Gear) -> bool {
        let s = &self.settings;
        if gear != Gear::Reverse {
            // A gear that doesn't come in never will.
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
        // Time to change, to get there, and to notice that it is stuck again and back off.
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

    /// The place on the line from where the vehicle was stuck, `back` metres away, at a distance from there, m.
    fn on_the_way(&self, now: Mark, back: f64, distance: f64) -> (f64, f64) {
        let k = distance / back;
        (self.blocked.x + k * (now.x - self.blocked.x), self.blocked.y + k * (now.y - self.blocked.y))
    }

    /// Whether a course, which gives the place after so many seconds, comes close to where the vehicle was a window
    /// before, within a share of the window from now.
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

    /// Where the vehicle was at a time, if that is known.
    fn place_at(&self, time: f64) -> Option<(f64, f64)> {
        let i = self.history.partition_point(|m| m.time < time);
        let (a, b) = (self.history.get(i.checked_sub(1)?)?, self.history.get(i)?);
        let k = (time - a.time) / (b.time - a.time);
        Some((a.x + k * (b.x - a.x), a.y + k * (b.y - a.y)))
    }

    fn remember(&mut self, now: Mark, pose: &Pose, gear: Gear) {
        let s = &self.settings;
        // Positions at regular times. The margin keeps marks at whole multiples of a control period.
        let spacing = s.window / (MARKS - 2) as f64;
        if self.history.back().is_none_or(|m| now.time - m.time > spacing) {
            if self.history.len() == MARKS {
                self.history.pop_front();
            }
            self.history.push_back(now);
        }
        let spacing = s.lookahead / PER_LOOKAHEAD;
        if gear == Gear::Reverse {
            // What was backed over is no longer behind the vehicle.
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

    /// The mean speed of the wheels' treads without its sign, m/s; 0 without wheels.
    fn wheel_speed(&self, o: &Observation) -> f64 {
        let sum: f64 = o.wheels.iter().map(|w| w.spin).filter(|s| s.is_finite()).sum();
        if o.wheels.is_empty() {
            0.0
        } else {
            (sum / o.wheels.len() as f64 * self.vehicle.wheel_radius).abs()
        }
    }

    /// Backs along the track, once reverse is in; until then it brakes, since a gearbox changes at rest.
    fn backward(&mut self, now: Mark, pose: &Pose, gear: Gear, dt: f64) -> Command {
        let s = &self.settings;
        let goal = self
            .track
            .iter()
            .rev()
            .map(|p| seen_from(pose, *p))
            .take_while(|(x, _)| *x < 0.0)
            .find(|(x, y)| math::hypot(*x, *y) >= s.lookahead);
        // The circle through a point behind the vehicle that touches the vehicle's axis is the same for both directions
        // of travel, and so is the steering. Without a track the vehicle backs straight.
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

    /// Comes again as the planner steers, but on another line and with a run-up. It brakes until a forward gear is in.
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

/// A point in the axes of the vehicle: forward, left, m.
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
