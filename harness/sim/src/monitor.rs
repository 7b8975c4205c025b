//! Whether a simulation makes energy from nothing.
//!
//! What is watched is the kinetic energy and the energy of height less the work of the engine. Friction, dampers, brakes
//! and yielding soil only take from it. Springs, tyres and the hull's contacts hold some of it and give it back within
//! some tenths of a second, so it is held against the greatest value between half a second and a second ago. What they
//! hold for longer, the work of the steering and errors of the integration are small: for all of them together the
//! energy that lifts the vehicle by the radius of a wheel is allowed. Energy that grows steadily, or faster, is found while
//! the state still tells where it comes from; what explodes between two looks is left to the checks for numbers that aren't
//! finite.

/// Time between two looks, s.
pub(crate) const PERIOD: f64 = 0.01;
/// Looks that are remembered, and how many of the oldest a new one is held against: a second and half of it.
const KEPT: usize = 100;
const OLD: usize = KEPT / 2;

/// Watches a vehicle's balance of energy. It only reads: a simulation goes on alike with and without it.
#[derive(Clone)]
pub(crate) struct EnergyMonitor {
    /// A ring of the last balances, J.
    kept: [f64; KEPT],
    /// Where the next one goes, and how many there are.
    next: usize,
    count: usize,
    /// J.
    allowed: f64,
    /// Greatest rise so far, J.
    surplus: f64,
}

impl EnergyMonitor {
    /// With a rise (J) that is allowed.
    pub(crate) fn new(allowed: f64) -> Self {
        Self { kept: [0.0; KEPT], next: 0, count: 0, allowed, surplus: 0.0 }
    }

    /// Forgets what was before: the state was changed from outside.
    pub(crate) fn forget(&mut self) {
        (self.next, self.count) = (0, 0);
    }

    /// Takes the balance [`PERIOD`] after the last one, J.
    pub(crate) fn push(&mut self, balance: f64) {
        let oldest = (self.next + KEPT - self.count) % KEPT;
        let held_against = (0..self.count.min(OLD))
            .map(|k| self.kept[(oldest + k) % KEPT])
            .fold(f64::NEG_INFINITY, f64::max);
        if self.count > 0 {
            self.surplus = self.surplus.max(balance - held_against);
        }
        self.kept[self.next] = balance;
        self.next = (self.next + 1) % KEPT;
        self.count = (self.count + 1).min(KEPT);
    }

    /// Greatest rise so far that nothing supplied, J.
    pub(crate) fn surplus(&self) -> f64 {
        self.surplus
    }

    /// Whether more energy appeared than is allowed.
    pub(crate) fn exceeded(&self) -> bool {
        self.surplus > self.allowed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_returns_within_half_a_second_is_no_surplus_and_what_grows_is() {
        // A vehicle that lands on its springs and is thrown back: for 0.4 s 5 kJ are in them.
        let mut m = EnergyMonitor::new(100.0);
        for k in 0..300 {
            m.push(if (100..140).contains(&k) { 1000.0 } else { 6000.0 });
        }
        assert_eq!(m.surplus(), 0.0);
        // 1 kW from nowhere is half a kilojoule in half a second.
        let mut m = EnergyMonitor::new(400.0);
        for k in 0..300 {
            m.push(10.0 * f64::from(k));
        }
        assert!(m.exceeded() && (m.surplus() - 500.0).abs() < 20.0, "{}", m.surplus());
    }

    #[test]
    fn what_was_before_a_change_from_outside_is_forgotten() {
        let mut m = EnergyMonitor::new(100.0);
        m.push(0.0);
        m.forget();
        m.push(1e6);
        m.push(1e6);
        assert!(!m.exceeded());
    }
}
