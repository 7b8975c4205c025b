//! Recovery: simulates manoeuvres that reverse and retry in the internal forward model, and drives the best.

use std::collections::VecDeque;

use vb_sdk::mppi::{Cost, LANES, Lanes, Model};
use vb_sdk::{Gear, Observation, PlannerError, Task, math};

use crate::foresight::{DT, Price, lanes};
use crate::twin::{State, Twin};

/// Duration of a manoeuvre, in rollout steps.
const STEPS: usize = 75;
/// The speed in reverse, m/s at full scale.
const BACK_SPEED: f64 = -2.5;
/// Durations of reversing, s at full scale; manoeuvres without reversing have 0.
const BACK: [f64; 3] = [1.7, 2.6, 3.8];
/// Steering in reverse, and steering and speed (m/s at full scale) of the retry.
const BACK_STEERING: [f64; 4] = [-0.8, -0.3, 0.3, 0.8];
const AGAIN: ([f64; 3], [f64; 2]) = ([-0.45, 0.0, 0.45], [4.0, 6.5]);
/// Steering and speed of manoeuvres without reversing.
const ON: ([f64; 5], [f64; 3]) = ([-0.7, -0.35, 0.0, 0.35, 0.7], [3.0, 5.0, 8.0]);
/// Time for which rollouts are sampled around a manoeuvre after reversing, s at full scale.
const HEEDED: f64 = 2.5;
/// Minimum displacement that counts as progress (m at full scale), and the time without progress after which the
/// vehicle is stuck (s).
const PROGRESS: f64 = 0.5;
const PATIENCE: f64 = 1.5;
/// Minimum distance from a failed recovery at which the vehicle is elsewhere, m at full scale.
const HERE: f64 = 2.0;
/// Window of the stuck rule, s, and its displacement of 1 m with a margin for errors, m, at full scale.
const WINDOW: f64 = 10.0;
const APART: f64 = 1.2;
/// Cost of a rollout step that would trigger the stuck rule.
const MET: f32 = 1.0;

/// A manoeuvre. Times and speeds are at full scale.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Manoeuvre {
    /// Duration of reversing, s.
    back: f64,
    back_steering: f64,
    steering: f64,
    /// Speed after reversing, m/s.
    speed: f64,
}

impl Manoeuvre {
    /// All candidates.
    fn all(has_reverse: bool) -> Vec<Self> {
        let on = ON.0.iter().flat_map(|steering| {
            ON.1.iter().map(|speed| Self {
                back: 0.0,
                back_steering: 0.0,
                steering: *steering,
                speed: *speed,
            })
        });
        let mut all: Vec<Self> = on.collect();
        for back in BACK.iter().filter(|_| has_reverse) {
            for back_steering in BACK_STEERING {
                for steering in AGAIN.0 {
                    for speed in AGAIN.1 {
                        all.push(Self { back: *back, back_steering, steering, speed });
                    }
                }
            }
        }
        all
    }

    fn backs(&self) -> bool {
        self.back > 0.0
    }

    /// Steering and speed at a time after its start.
    fn at(&self, time: f64) -> [f64; 2] {
        if time < self.back { [self.back_steering, BACK_SPEED] } else { [self.steering, self.speed] }
    }
}

/// The command of a manoeuvre.
pub(crate) struct Wanted {
    /// Steering and speed, m/s.
    pub(crate) command: [f64; 2],
    /// Whether the manoeuvre is reversing, which is never interrupted.
    pub(crate) is_backing: bool,
}

/// Detects a stuck vehicle and searches for a recovery manoeuvre.
pub(crate) struct Escape {
    manoeuvres: Vec<Manoeuvre>,
    /// The current manoeuvre and its start time, s.
    driven: Option<(Manoeuvre, f64)>,
    /// Positions in the window of the stuck rule, one per control period.
    history: VecDeque<[f64; 2]>,
    /// Position of the last progress, and the time since then, s.
    anchor: [f64; 2],
    waited: f64,
    /// Position of the last recovery, and whether it reversed.
    failed: Option<([f64; 2], bool)>,
    scale: f64,
    root: f64,
    period: f64,
}

impl Escape {
    pub(crate) fn new(task: &Task) -> Self {
        let scale = task.vehicle.scale;
        Self {
            manoeuvres: Manoeuvre::all(task.vehicle.max_reverse_speed > 0.0),
            driven: None,
            history: VecDeque::new(),
            anchor: [task.start.x, task.start.y],
            waited: 0.0,
            failed: None,
            scale,
            root: scale.sqrt(),
            period: task.control_period,
        }
    }

    /// The command of the current manoeuvre, if there is one, and whether the vehicle has just been detected as stuck.
    pub(crate) fn update(
        &mut self,
        o: &Observation,
        twin: &Twin,
        price: &Price<'_>,
        start: &State,
    ) -> Result<(Option<Wanted>, bool), PlannerError> {
        let p = o.pose()?.position;
        let place = [p.x, p.y];
        self.history.push_back(place);
        if self.history.len() as f64 * self.period > WINDOW * self.root + self.period {
            self.history.pop_front();
        }
        if math::hypot(p.x - self.anchor[0], p.y - self.anchor[1]) > PROGRESS * self.scale {
            (self.anchor, self.waited) = (place, 0.0);
        }
        // A gear change prevents progress.
        self.waited += if o.gear == Gear::Forward { self.period } else { 0.0 };
        let time = |since: f64| (o.time - since) / self.root;
        self.driven = self.driven.filter(|(m, since)| time(*since) < m.back + HEEDED);
        let is_backing = |driven: &Option<(Manoeuvre, f64)>| {
            driven.as_ref().is_some_and(|(m, since)| time(*since) < m.back)
        };
        let stuck = self.waited > PATIENCE * self.root && !is_backing(&self.driven);
        if stuck {
            // A manoeuvre type that just failed here is not repeated, whatever the model predicts.
            let near = |at: &[f64; 2]| math::hypot(p.x - at[0], p.y - at[1]) < HERE * self.scale;
            let failed = self.failed.filter(|(at, _)| near(at)).map(|(_, backed)| backed);
            let found = self.search(twin, price, start, failed);
            self.driven = Some((found, o.time));
            self.failed = Some((place, found.backs()));
            (self.anchor, self.waited) = (place, 0.0);
        }
        let wanted = self.driven.as_ref().map(|(m, since)| {
            let [steering, speed] = m.at(time(*since));
            Wanted { command: [steering, speed * self.root], is_backing: is_backing(&self.driven) }
        });
        Ok((wanted, stuck))
    }

    /// The manoeuvre of minimum cost: without reversing after a failed reversal, with reversing after the opposite, or
    /// of all.
    fn search(&self, twin: &Twin, price: &Price<'_>, start: &State, failed: Option<bool>) -> Manoeuvre {
        let price = price.over(STEPS);
        let others: Vec<Manoeuvre> =
            self.manoeuvres.iter().copied().filter(|m| failed != Some(m.backs())).collect();
        let tried = if others.is_empty() { &self.manoeuvres } else { &others };
        let mut best = (f32::INFINITY, tried[0]);
        for block in tried.chunks(LANES) {
            let of = |l: usize| block[l.min(block.len() - 1)];
            let mut s = start.clone();
            let mut costs = [0.0; LANES];
            for k in 0..STEPS {
                let now = |c: usize, unit: f64| lanes(|l| unit * of(l).at(DT * k as f64)[c]);
                let command: [Lanes; 2] = [now(0, 1.0), now(1, self.root)];
                twin.step(&mut s, &command, (DT * self.root) as f32);
                let running = price.running(&s, &command, k);
                let met = self.before(DT * self.root * (k + 1) as f64);
                for l in 0..LANES {
                    let meets = met.is_some_and(|[x, y]| {
                        math::hypot(f64::from(s.x[l]) - x, f64::from(s.y[l]) - y) < APART * self.scale
                    });
                    costs[l] += running[l] + if meets { MET } else { 0.0 };
                }
            }
            let end = price.terminal(&s);
            for (l, manoeuvre) in block.iter().enumerate() {
                let cost = costs[l] + end[l];
                if cost < best.0 {
                    best = (cost, *manoeuvre);
                }
            }
        }
        best.1
    }

    /// The vehicle's position one rule window before a time so many seconds ahead, if known.
    fn before(&self, time: f64) -> Option<[f64; 2]> {
        let ago = ((WINDOW * self.root - time) / self.period) as usize;
        self.history.len().checked_sub(ago + 1).and_then(|i| self.history.get(i)).copied()
    }
}
