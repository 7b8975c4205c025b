//! A vehicle that is made ready for simulations.

use vb_files::{Document, DocumentError, Flaw};

use crate::VehicleSpec;
use crate::kinematics::AxleKinematics;

/// The maximum number of wheels that a vehicle can have.
pub const MAX_WHEELS: usize = 16;

/// A vehicle with its linkages solved, which takes a millisecond. Made once, it serves any number of simulations; their
/// vehicles and its clones share its tables.
#[derive(Clone, Debug)]
pub struct VehicleModel {
    spec: VehicleSpec,
    axles: Vec<AxleKinematics>,
}

impl VehicleModel {
    /// Solves the linkages of a vehicle.
    ///
    /// # Errors
    /// Returns an error for a vehicle with too many axles, or with a linkage that doesn't close.
    pub fn new(spec: VehicleSpec) -> Result<Self, DocumentError> {
        let invalid = |field: String, problem: String| {
            Flaw::new(field, problem).of(VehicleSpec::KIND, spec.name.clone())
        };
        if 2 * spec.axles.len() > MAX_WHEELS {
            return Err(invalid("axles".to_owned(), format!("more than {} axles", MAX_WHEELS / 2)));
        }
        let mut axles = Vec::with_capacity(spec.axles.len());
        for (i, axle) in spec.axles.iter().enumerate() {
            let solved = AxleKinematics::solve(axle)
                .map_err(|e| invalid(format!("axles[{i}].suspension.linkage"), e.to_string()))?;
            axles.push(solved);
        }
        Ok(Self { spec, axles })
    }

    /// The vehicle's data.
    #[must_use]
    pub fn spec(&self) -> &VehicleSpec {
        &self.spec
    }

    /// The solved linkages of the axles, from front to back.
    #[must_use]
    pub fn axles(&self) -> &[AxleKinematics] {
        &self.axles
    }
}
