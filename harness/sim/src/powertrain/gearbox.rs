//! When an automatic gearbox shifts.

use vb_vehicle::powertrain::Gearbox;

/// A shift down must leave this part of the lower gear's shift-up speed free below it. Ours.
const HYSTERESIS: f64 = 0.05;
/// Time over which a load-sensing gearbox averages the load, s. Ours: above the period of the wheels' hop.
const SENSE_TIME: f64 = 0.3;

/// A gearbox and its gear.
#[derive(Clone, Debug)]
pub(super) struct Shifter {
    pub(super) spec: Gearbox,
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
        Self { spec: spec.clone(), gear: 0, interrupted: 0.0, wait: 0.0, load: 0.0 }
    }

    pub(super) fn ratio(&self) -> f64 {
        self.spec.ratios[self.gear]
    }

    pub(super) fn interrupts(&self) -> bool {
        self.interrupted > 0.0
    }

    /// Lets `dt` pass with a load torque at the output, N m.
    pub(super) fn sense(&mut self, load: f64, dt: f64) {
        self.interrupted = (self.interrupted - dt).max(0.0);
        self.wait = (self.wait - dt).max(0.0);
        self.load += (load - self.load) * dt / (SENSE_TIME + dt);
    }

    /// Shifts if the speed of the input shaft (rad/s) asks for it; `available` tells the torque at the output that
    /// another gear would give at an input speed, N m.
    pub(super) fn shift(&mut self, input: f64, available: impl Fn(f64, f64) -> f64) {
        if self.wait > 0.0 || self.interrupts() {
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
}
