//! The embedded learned models, by the vehicle of their training data.

use vb_sdk::nn::{Weights, WeightsError};

/// The weights for a vehicle.
struct Model {
    vehicle: &'static str,
    patch: &'static [u8],
    attention: &'static [u8],
}

macro_rules! models {
    ($first:literal $(, $more:literal)*) => {
        /// All models; the first serves vehicles without their own model.
        static MODELS: &[Model] = &[models!(@ $first) $(, models!(@ $more))*];
        /// Model names in the metadata of planners with patch networks.
        pub const PATCH_MODELS: &str = concat!(models!(@ $first "") $(, "; ", models!(@ $more ""))*);
        /// Model names in the metadata of planners with attention.
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

/// The weights for a vehicle, with patch networks or attention: its own, or those of the default vehicle, named in the
/// note `vehicle`.
///
/// # Errors
/// Returns an error if the embedded weights are invalid.
pub(crate) fn weights(vehicle: &str, attention: bool) -> Result<Weights, WeightsError> {
    let model = MODELS.iter().find(|m| m.vehicle == vehicle).unwrap_or(&MODELS[0]);
    Weights::parse(if attention { model.attention } else { model.patch })
}
