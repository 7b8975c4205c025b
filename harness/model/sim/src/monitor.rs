//! Whether a simulation makes energy from nothing.
//!
//! The balance is the kinetic energy and the energy of height less the work of engine and steering. Friction, dampers,
//! brakes and yielding soil only take from it. Springs, tyres and the hull's contacts hold some of it and give it back within
//! some tenths of a second, so the balance is followed by its maximum over the last half second: a bounce does not lower
//! this envelope. Each rise of the envelope goes into a bucket that leaks at a bounded power. What springs hold for longer
//! than half a second and errors of the integration may fill the bucket up to its size; what pumps energy steadily, by however
//! little more than the leak, overflows it. What explodes between two looks is left to the checks for numbers that aren't
//! finite.

/// Time between two looks, s.
pub(crate) const PERIOD: f64 = 0.01;
/// Looks over which the maximum is taken: half a second.
const KEPT: usize = 50;
/// Power of the leak over the weight of the vehicle times √(g r), the speed scale of a wheel of radius r: 0.5 kW for the
/// HMMWV, a hundredth of it lifted at 2 cm/s. Ours; more than the errors of its honest drives, and less than any propulsion.
const LEAK: f64 = 0.01;

/// Watches a vehicle's balance of energy. It only reads: a simulation goes on alike with and without it.
#[derive(Clone)]
pub(crate) struct EnergyMonitor {
    /// A ring of the last balances, J.
    kept: [f64; KEPT],
    /// Where the next one goes, and how many there are.
    next: usize,
    count: usize,
    /// The size of the bucket, J.
    allowed: f64,
    /// What leaks between two looks, J.
    leak: f64,
    /// The level of the bucket, J.
    level: f64,
    /// The maximum of the level so far, J.
    surplus: f64,
}

impl EnergyMonitor {
    /// The monitor of a vehicle with this weight (N) and this radius (m) of a wheel. The bucket holds the energy that lifts
    /// the vehicle by that radius.
    pub(crate) fn new([weight, radius]: [f64; 2]) -> Self {
        let speed = (vb_vehicle::GRAVITY * radius).sqrt();
        Self {
            kept: [0.0; KEPT],
            next: 0,
            count: 0,
            allowed: weight * radius,
            leak: LEAK * weight * speed * PERIOD,
            level: 0.0,
            surplus: 0.0,
        }
    }

    /// Forgets the balances before: the state was changed from outside. What is in the bucket stays there.
    pub(crate) fn forget(&mut self) {
        (self.next, self.count) = (0, 0);
    }

    /// The maximum of the balances that are kept, J.
    fn envelope(&self) -> f64 {
        self.kept[..self.count].iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// Takes the balance [`PERIOD`] after the last one, J.
    pub(crate) fn push(&mut self, balance: f64) {
        let before = self.envelope();
        self.kept[self.next] = balance;
        self.next = (self.next + 1) % KEPT;
        self.count = (self.count + 1).min(KEPT);
        if before.is_finite() {
            self.level = (self.level + self.envelope() - before - self.leak).max(0.0);
            self.surplus = self.surplus.max(self.level);
        }
    }

    /// The maximum of the energy so far that nothing supplied, J.
    pub(crate) fn surplus(&self) -> f64 {
        self.surplus
    }

    /// The size of the bucket, J.
    pub(crate) fn allowed(&self) -> f64 {
        self.allowed
    }

    /// Whether more energy appeared than is allowed.
    pub(crate) fn exceeded(&self) -> bool {
        self.surplus > self.allowed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The HMMWV: 24.5 kN on wheels of 0.467 m: 11.4 kJ and 0.52 kW.
    fn hmmwv() -> EnergyMonitor {
        EnergyMonitor::new([24_462.0, 0.467])
    }

    #[test]
    fn what_returns_within_half_a_second_is_no_surplus() {
        // A vehicle that lands on its springs and is thrown back: for 0.4 s 5 kJ are in them.
        let mut m = hmmwv();
        for k in 0..300 {
            m.push(if (100..140).contains(&k) { 1000.0 } else { 6000.0 });
        }
        assert_eq!(m.surplus(), 0.0);
    }

    #[test]
    fn steady_pumping_above_the_leak_is_found_and_below_it_is_not() {
        let after = |power: f64, hops: bool| {
            let mut m = hmmwv();
            for k in 0..6000 {
                let t = PERIOD * f64::from(k);
                // In hops, energy comes once in 0.7 s.
                m.push(power * if hops { (t / 0.7).floor() * 0.7 } else { t });
            }
            m
        };
        // A minute of 1 kW, which never lifts it by its wheel's radius within a second.
        for hops in [false, true] {
            let m = after(1000.0, hops);
            assert!(m.exceeded(), "{} J", m.surplus());
            assert!((m.surplus() / (60.0 * 476.5) - 1.0).abs() < 0.05, "{} J", m.surplus());
            assert!(!after(400.0, hops).exceeded());
        }
    }

    #[test]
    fn the_allowance_refills() {
        // 6 kJ twice, 20 s apart, is allowed; 1 s apart it isn't.
        let twice = |apart: i32| {
            let mut m = hmmwv();
            for k in 0..3000 {
                m.push(
                    6000.0 * (f64::from(u8::from(k >= 500)) + f64::from(u8::from(k >= 500 + 100 * apart))),
                );
            }
            m.exceeded()
        };
        assert!(twice(1) && !twice(20));
    }

    #[test]
    fn vehicles_of_all_sizes_are_treated_alike() {
        // Froude scaling at a tenth: weight 10⁻³, energies 10⁻⁴, times 10⁻½.
        let [full, small] = [[24_462.0, 0.467], [24.462, 0.0467]].map(EnergyMonitor::new);
        assert!((small.allowed / full.allowed / 1e-4 - 1.0).abs() < 1e-9);
        assert!((small.leak / full.leak / (1e-4 * 10.0_f64.sqrt()) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn what_was_before_a_change_from_outside_is_forgotten() {
        let mut m = hmmwv();
        m.push(0.0);
        m.forget();
        m.push(1e6);
        m.push(1e6);
        assert!(!m.exceeded());
    }
}
