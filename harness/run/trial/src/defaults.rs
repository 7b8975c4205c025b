//! Default settings of trials, for the command line, sweeps and environments.

/// The vehicle.
pub const VEHICLE: &str = "hmmwv";
/// The soil set.
pub const SOILS: &str = "default";
/// The rule profile.
pub const RULES: &str = "paper";
/// The perception profile.
pub const PERCEPTION: &str = "oracle";
/// The time step of the simulation, s.
pub const TIME_STEP: f64 = 0.001;
/// The side of the cells in which soil remembers ruts, at scale 1, m.
pub const SOIL_RESOLUTION: f64 = 0.1;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_are_those_of_the_simulator_and_name_what_is_built_in() {
        let options = vb_sim::SimOptions::default();
        assert_eq!((options.step, options.soil_resolution), (TIME_STEP, SOIL_RESOLUTION));
        assert_eq!(PERCEPTION, vb_sense::profile::ORACLE);
        assert_eq!(vb_score::Rules::resolve(RULES).unwrap(), vb_score::Rules::paper());
    }
}
