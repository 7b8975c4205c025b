//! Gears as planners, the simulation, samples and numbers have them.

use vb_record::Sample;

/// The commanded gear of a number as [`Sample::gear`] has it.
#[must_use]
pub fn commanded_gear(number: f64) -> vb_sim::Gear {
    if number == Sample::REVERSE {
        vb_sim::Gear::Reverse
    } else if number == Sample::NEUTRAL {
        vb_sim::Gear::Neutral
    } else {
        vb_sim::Gear::Forward
    }
}

/// A planner's gear as the simulation has it.
#[must_use]
pub fn simulated_gear(gear: vb_sdk::Gear) -> vb_sim::Gear {
    match gear {
        vb_sdk::Gear::Forward => vb_sim::Gear::Forward,
        vb_sdk::Gear::Neutral => vb_sim::Gear::Neutral,
        vb_sdk::Gear::Reverse => vb_sim::Gear::Reverse,
    }
}

/// A gear of the simulation as planners have it.
#[must_use]
pub fn planner_gear(gear: vb_sim::Gear) -> vb_sdk::Gear {
    match gear {
        vb_sim::Gear::Forward => vb_sdk::Gear::Forward,
        vb_sim::Gear::Neutral => vb_sdk::Gear::Neutral,
        vb_sim::Gear::Reverse => vb_sdk::Gear::Reverse,
    }
}

/// A gear as a number: −1 is reverse, 0 neutral and 1 forward.
#[must_use]
pub fn gear_number(gear: vb_sim::Gear) -> f64 {
    match gear {
        vb_sim::Gear::Reverse => -1.0,
        vb_sim::Gear::Neutral => 0.0,
        vb_sim::Gear::Forward => 1.0,
    }
}

/// The gear whose [`gear_number`] is nearest; neutral for NaN.
#[must_use]
pub fn numbered_gear(number: f64) -> vb_sim::Gear {
    match number {
        n if n < -0.5 => vb_sim::Gear::Reverse,
        n if n > 0.5 => vb_sim::Gear::Forward,
        _ => vb_sim::Gear::Neutral,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gear_is_the_same_after_each_conversion_there_and_back() {
        for gear in [vb_sim::Gear::Reverse, vb_sim::Gear::Neutral, vb_sim::Gear::Forward] {
            assert_eq!(numbered_gear(gear_number(gear)), gear);
            assert_eq!(simulated_gear(planner_gear(gear)), gear);
        }
        assert_eq!(numbered_gear(f64::NAN), vb_sim::Gear::Neutral);
        assert_eq!([-0.9, 0.4, 7.0].map(|n| gear_number(numbered_gear(n))), [-1.0, 0.0, 1.0]);
    }
}
