//! The learned models that planners have, by the vehicle that they were learned with.

use vb_sdk::nn::{Weights, WeightsError};

/// The weights of a vehicle.
struct Model {
    vehicle: &'static str,
    patch: &'static [u8],
    attention: &'static [u8],
}

macro_rules! models {
    ($first:literal $(, $more:literal)*) => {
        /// All models; the first is for vehicles that none is of.
        static MODELS: &[Model] = &[models!(@ $first) $(, models!(@ $more))*];
        /// What the metadata of a planner says whose networks see patches.
        pub const PATCH_MODELS: &str = concat!(models!(@ $first "") $(, "; ", models!(@ $more ""))*);
        /// What the metadata of a planner says whose networks pay attention.
        pub const ATTENTION_MODELS: &str =
            concat!(models!(@ $first "-attention") $(, "; ", models!(@ $more "-attention"))*);
    };
    (@ $vehicle:literal) => {
        Model {
            vehicle: $vehicle,
            patch: include_bytes!(concat!("../weights/", $vehicle, ".vbnn")),
            attention: include_bytes!(concat!("../weights/", $vehicle, "-attention.vbnn")),
        }
    };
    (@ $vehicle:literal $sight:literal) => { include_str!(concat!("../weights/", $vehicle, $sight, ".txt")) };
}

models!("hmmwv", "man5t", "verti4wheeler");

/// The weights for a vehicle, which see patches or pay attention: its own if there are any, else those of another, whose name they
/// have in the note `vehicle`.
///
/// # Errors
/// Returns an error if they can't be read, which is a mistake of whoever built the plugin.
pub(crate) fn weights(vehicle: &str, attention: bool) -> Result<Weights, WeightsError> {
    let model = MODELS.iter().find(|m| m.vehicle == vehicle).unwrap_or(&MODELS[0]);
    Weights::parse(if attention { model.attention } else { model.patch })
}
