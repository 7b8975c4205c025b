//! Gears as planners, the simulation and samples have them.

use vb_record::Sample;

/// The gear that a sample says was commanded.
#[must_use]
pub fn commanded_gear(sample: &Sample) -> vb_sim::Gear {
    if sample.gear == Sample::REVERSE {
        vb_sim::Gear::Reverse
    } else if sample.gear == Sample::NEUTRAL {
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
