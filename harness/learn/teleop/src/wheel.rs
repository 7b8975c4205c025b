//! The person's inputs, which the page sets and the driver reads.

use std::sync::{Arc, Mutex};

use vb_files::lock;
use vb_sdk::Command;

/// Inputs of the person: steering, throttle, brake and gear.
#[derive(Clone, Debug, Default)]
pub struct Wheel(Arc<Mutex<Command>>);

impl Wheel {
    /// Sets the inputs; values that are not finite become 0.
    pub fn set(&self, command: Command) {
        let number = |v: f64| if v.is_finite() { v } else { 0.0 };
        let (steering, throttle, brake) =
            (number(command.steering), number(command.throttle), number(command.brake));
        let mut held = lock(&self.0);
        *held = Command { steering, throttle, brake, ..command };
    }

    pub(crate) fn get(&self) -> Command {
        lock(&self.0).clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_moves_nothing() {
        let wheel = Wheel::default();
        wheel.set(Command { steering: f64::NAN, throttle: f64::INFINITY, brake: 0.5, ..Command::default() });
        assert_eq!((wheel.get().steering, wheel.get().throttle, wheel.get().brake), (0.0, 0.0, 0.5));
    }
}
