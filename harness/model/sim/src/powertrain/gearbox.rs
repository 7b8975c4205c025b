//! When an automatic gearbox shifts, and when it changes the direction.

use crate::state::Gear;
use vb_vehicle::powertrain::Gearbox;

/// A shift down must leave this part of the lower gear's shift-up speed free below it. Ours.
const HYSTERESIS: f64 = 0.05;
/// Time over which a load-sensing gearbox averages the load, s. Ours: above the period of the wheels' hop.
const SENSE_TIME: f64 = 0.3;

/// A gearbox and its gear.
#[derive(Clone, Debug)]
pub(super) struct Shifter {
    pub(super) spec: Gearbox,
    direction: Gear,
    /// The direction that is on its way in, and the time until it is, s. The gearbox is in neutral meanwhile.
    coming: Option<(Gear, f64)>,
    /// The forward gear, counted from 0: the one that is in, or in neutral the one that would be. 0 in reverse.
    pub(super) gear: usize,
    /// Time for which the torque stays interrupted, s.
    pub(super) interrupted: f64,
    /// Time until the next shift may happen, s.
    pub(super) wait: f64,
    /// Smoothed torque at the output less that which accelerates the vehicle, N m.
    pub(super) load: f64,
}

impl Shifter {
    pub(super) fn new(spec: &Gearbox) -> Self {
        Self {
            spec: spec.clone(),
            direction: Gear::Forward,
            coming: None,
            gear: 0,
            interrupted: 0.0,
            wait: 0.0,
            load: 0.0,
        }
    }

    pub(super) fn direction(&self) -> Gear {
        self.direction
    }

    /// Output speed over input speed; in neutral that of the forward gear that would be in.
    pub(super) fn ratio(&self) -> f64 {
        match (self.direction, self.spec.reverse) {
            (Gear::Reverse, Some(ratio)) => ratio,
            _ => self.spec.ratios[self.gear],
        }
    }

    /// The gear as a number, counted from 1 forwards, with 0 for neutral and −1 for reverse.
    pub(super) fn number(&self) -> i32 {
        match self.direction {
            Gear::Reverse => -1,
            Gear::Neutral => 0,
            Gear::Forward => self.gear as i32 + 1,
        }
    }

    pub(super) fn interrupts(&self) -> bool {
        self.interrupted > 0.0
    }

    /// Puts in a direction at once, and a forward gear, counted from 1; the highest there is at most.
    #[cfg(feature = "rig")]
    pub(super) fn engage(&mut self, direction: Gear, gear: usize) {
        self.direction = self.available(direction);
        self.coming = None;
        self.gear = if direction == Gear::Reverse { 0 } else { gear.clamp(1, self.spec.ratios.len()) - 1 };
    }

    /// A vehicle without a reverse gear has neutral in its place.
    fn available(&self, wanted: Gear) -> Gear {
        if wanted == Gear::Reverse && self.spec.reverse.is_none() { Gear::Neutral } else { wanted }
    }

    /// Follows what the driver asks for in a step of `dt` in which the vehicle has a speed over ground (m/s, positive
    /// forwards). Returns whether another direction is in than the one that is asked for.
    ///
    /// Neutral comes at once. A direction that is opposed to the motion, or to the direction that is in, waits until the
    /// vehicle is slow; then it takes the latency. A change that has begun is completed however the vehicle moves.
    #[inline]
    pub(super) fn select(&mut self, wanted: Gear, speed: f64, dt: f64) -> bool {
        let wanted = self.available(wanted);
        if wanted == self.direction {
            self.coming = None;
            return false;
        }
        self.change(wanted, speed, dt);
        wanted != self.direction
    }

    fn change(&mut self, wanted: Gear, speed: f64, dt: f64) {
        if wanted == Gear::Neutral {
            (self.direction, self.coming) = (Gear::Neutral, None);
            return;
        }
        let left = match self.coming {
            Some((to, left)) if to == wanted => left,
            _ => {
                let change = self.spec.direction_change;
                let against = if wanted == Gear::Forward { -speed } else { speed };
                let too_fast = match self.direction {
                    Gear::Neutral => against >= change.speed,
                    _ => speed.abs() >= change.speed,
                };
                if too_fast {
                    self.coming = None;
                    return;
                }
                change.latency
            }
        };
        // Half a step, so that rounding doesn't add one.
        if left > 0.5 * dt {
            (self.direction, self.coming) = (Gear::Neutral, Some((wanted, left - dt)));
        } else {
            (self.direction, self.coming) = (wanted, None);
            (self.interrupted, self.wait) = (0.0, 0.0);
        }
        if wanted == Gear::Reverse {
            self.gear = 0;
        }
    }

    /// Lets `dt` pass with a load torque at the output, N m.
    pub(super) fn sense(&mut self, load: f64, dt: f64) {
        self.interrupted = (self.interrupted - dt).max(0.0);
        self.wait = (self.wait - dt).max(0.0);
        self.load += (load - self.load) * dt / (SENSE_TIME + dt);
    }

    /// Shifts between the forward gears if the speed of the input shaft (rad/s) asks for it; `available` tells the torque
    /// at the output that another gear would give at an input speed, N m. In neutral it keeps the gear ready that the
    /// speed asks for. Reverse has one gear.
    pub(super) fn shift(&mut self, input: f64, available: impl Fn(f64, f64) -> f64) {
        if self.wait > 0.0 || self.interrupts() || self.direction == Gear::Reverse {
            return;
        }
        let g = &self.spec;
        let output = input * g.ratios[self.gear];
        if input > g.shift_up[self.gear] && self.gear + 1 < g.ratios.len() {
            let ratio = g.ratios[self.gear + 1];
            if g.load_sensing && available(output / ratio, ratio) < self.load {
                return;
            }
            self.gear += 1;
        } else if input < g.shift_down[self.gear]
            && self.gear > 0
            // Else the lower gear would shift up again at once.
            && output / g.ratios[self.gear - 1] < (1.0 - HYSTERESIS) * g.shift_up[self.gear - 1]
        {
            self.gear -= 1;
        } else {
            return;
        }
        self.interrupted = g.shift_time;
        self.wait = g.latency.max(g.shift_time);
    }

    /// All numbers on which the next step depends. Forward gears count from 0; reverse is −1, neutral −2, followed by the
    /// forward gear that would be in and by what is coming. A drive that never leaves the forward gears has four numbers.
    pub(super) fn inner_state(&self) -> impl Iterator<Item = f64> + '_ {
        let gear = match self.direction {
            Gear::Forward => self.gear as f64,
            Gear::Reverse => -1.0,
            Gear::Neutral => -2.0,
        };
        let ready = (self.direction == Gear::Neutral).then_some(self.gear as f64);
        let coming = self.coming.map(|(to, left)| [if to == Gear::Reverse { -1.0 } else { 1.0 }, left]);
        let timers = [gear, self.interrupted, self.wait, self.load];
        timers.into_iter().chain(ready).chain(coming.into_iter().flatten())
    }
}
