//! The vehicle that events and characteristics are computed for.

use crate::course::NamedCourse;
use crate::geometry::Geometry;
use crate::pace::Pace;
use vb_sim::{SimError, SimOptions, SoilSet, VehicleState};
use vb_vehicle::{VehicleModel, VehicleSpec, powertrain::Differential};

/// A vehicle ready to be put through events.
#[derive(Clone, Debug)]
pub struct Bench<'a> {
    pub(crate) spec: &'a VehicleSpec,
    pub(crate) model: VehicleModel,
    pub(crate) soils: &'a [SoilSet],
    pub(crate) options: SimOptions,
    pub(crate) geometry: Geometry,
    pub(crate) pace: Pace,
    /// The vehicle as it stands on level ground.
    pub(crate) standing: VehicleState,
    /// The course of a file that takes the place of those of the events.
    pub(crate) course: Option<&'a NamedCourse>,
}

impl<'a> Bench<'a> {
    /// For a vehicle, the sets of soils to put it on and a step, s.
    ///
    /// # Errors
    /// [`SimError::Vehicle`] for a vehicle whose suspension doesn't close.
    pub fn new(spec: &'a VehicleSpec, soils: &'a [SoilSet], step: f64) -> Result<Self, SimError> {
        let options = SimOptions { step, ..SimOptions::default() };
        let model = VehicleModel::new(spec.clone())?;
        let rest = crate::grounds::at_rest(&model, options)?;
        let geometry = Geometry::new(&model, rest.wheels.iter().map(|w| w.deflection).collect());
        Ok(Self {
            spec,
            soils,
            options,
            geometry,
            pace: Pace::new(spec),
            model,
            standing: rest,
            course: None,
        })
    }

    /// The same with a course for the events `ride-course` and `half-round`.
    pub(crate) fn on_course(self, course: Option<&'a NamedCourse>) -> Self {
        Self { course, ..self }
    }

    /// Radius of the wheels on level ground and smallest distance between the wheels of an axle, m: those of the kinematics without slip in
    /// comparisons with recordings.
    #[must_use]
    pub fn radius_and_track(&self) -> [f64; 2] {
        [self.geometry.radius, self.geometry.track()]
    }

    /// Friction between the ground and the vehicle's tyres where it is the lesser of theirs; that of the ground for tyres whose
    /// forces scale with it.
    pub(crate) fn grip(&self, ground: f64) -> f64 {
        self.spec.tyre.coulomb_friction().map_or(ground, |own| own.min(ground))
    }

    /// Whether an engine that idles behind a converter drives the vehicle with nothing pressed.
    pub(crate) fn creeps(&self) -> bool {
        self.spec.powertrain.converter.is_some()
    }

    /// Whether a differential, or the motors of the sides, turn both wheels of an axle alike, by which its corners are those of no theory
    /// here.
    pub(crate) fn winds_up(&self) -> bool {
        let line = &self.spec.powertrain.driveline;
        line.axles.iter().any(|a| a.differential == Differential::Locked {}) || self.spec.skid.is_some()
    }

    pub(crate) fn at_resolution(&self, soil_resolution: f64) -> Self {
        Self { options: SimOptions { soil_resolution, ..self.options }, ..self.clone() }
    }

    pub(crate) fn at_step(&self, step: f64) -> Self {
        Self { options: SimOptions { step, ..self.options }, ..self.clone() }
    }
}
