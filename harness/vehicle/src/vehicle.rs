//! A vehicle as data. The file format is `tasks/vehicles/*.yaml`; see there for a commented example.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use crate::VehicleError;
use crate::powertrain::Powertrain;
use crate::suspension::{SteeredBy, Steering, SteeringGear, Suspension};
use crate::tracks::Tracks;
use crate::tyre::TyreSpec;

/// A point of the chassis frame, or relative to an axle's reference point, m.
pub type Point = [f64; 3];

/// A vehicle on wheels or tracks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleSpec {
    /// Version of this format; 1.
    pub schema: u32,
    /// Short name.
    pub name: String,
    /// One line for people.
    pub description: String,
    /// Scale of the worlds that it is made for: 1 for a full-size vehicle, 1/6 and 1/10 for small cars. A length of the
    /// full-size world over the same length of this vehicle's world; masses and gravity are the vehicle's own.
    #[serde(default = "full_size")]
    pub scale: f64,
    /// Where it departs from the model that it was made from, a sentence each: for people.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub deviations: Vec<String>,
    /// Overall length, m.
    pub length: f64,
    /// Overall width, m.
    pub width: f64,
    /// Overall height, m.
    pub height: f64,
    /// Top speed on flat ground, m/s.
    pub max_speed: f64,
    /// The sprung body.
    pub chassis: Chassis,
    /// Front to back.
    pub axles: Vec<Axle>,
    /// The driver's steering.
    pub steering: Steering,
    /// Belts about the wheels of each side, if it is a tracked vehicle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tracks: Option<Tracks>,
    /// The tyre on all wheels, but for those of axles with a tyre of their own.
    pub tyre: TyreSpec,
    /// Tyres that may be fitted instead, by name; see [`VehicleSpec::with_tyre`].
    #[serde(default)]
    pub tyres: BTreeMap<String, TyreSpec>,
    /// Engine, gearbox and driveline.
    pub powertrain: Powertrain,
}

impl VehicleSpec {
    /// The same vehicle on another of its tyres, or on the one that it has by the name of that one's model.
    ///
    /// # Errors
    /// [`VehicleError::Invalid`], with the names that there are.
    pub fn with_tyre(mut self, name: &str) -> Result<Self, VehicleError> {
        fn fit(
            file: &str,
            field: String,
            tyre: &mut TyreSpec,
            others: &BTreeMap<String, TyreSpec>,
            name: &str,
        ) -> Result<(), VehicleError> {
            if let Some(other) = others.get(name) {
                *tyre = other.clone();
                return Ok(());
            }
            if name == tyre.model() {
                return Ok(());
            }
            let mut known: Vec<&str> = others.keys().map(String::as_str).collect();
            known.push(tyre.model());
            known.sort_unstable();
            let reason = format!("{name:?} is not among them; choose one of {}", known.join(", "));
            Err(VehicleError::Invalid { file: file.to_owned(), field, reason })
        }
        fit(&self.name, "tyres".to_owned(), &mut self.tyre, &self.tyres, name)?;
        for (i, axle) in self.axles.iter_mut().enumerate() {
            if let Some(tyre) = &mut axle.tyre {
                fit(&self.name, format!("axles[{i}].tyres"), tyre, &axle.tyres, name)?;
            }
        }
        Ok(self)
    }

    /// The tyre on the wheels of an axle.
    #[must_use]
    pub fn tyre_of<'a>(&'a self, axle: &'a Axle) -> &'a TyreSpec {
        axle.tyre.as_ref().unwrap_or(&self.tyre)
    }
}

/// The sprung body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chassis {
    /// kg.
    pub mass: f64,
    /// Centre of mass in the chassis frame, m.
    pub com: Point,
    /// Principal moments about the centre of mass along the chassis axes, kg m².
    pub inertia: [f64; 3],
    /// Friction coefficient of the hull.
    pub friction: f64,
    /// Resistance of the air, and of what else grows with speed, as points \[speed m/s, force N\]: linear between
    /// and constant beyond them, against the motion, at the centre of mass. None if empty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub resistance: Vec<[f64; 2]>,
    /// Whether the faces of its wheels bear it when it lies on them: for vehicles whose wheels stand out beyond the hull,
    /// since a tyre carries on its tread only.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub wheel_faces: bool,
    /// Whether soil doesn't stop the hull, which then touches rigid ground and obstacles alone: as in the original, whose
    /// soil is felt only within patches of 1.0 × 0.6 m about the wheels.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub hull_passes_soil: bool,
    /// Convex parts that touch ground and obstacles, as point clouds in the chassis frame, m.
    pub hull: Vec<Vec<Point>>,
}

/// An axle with a wheel at each side.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axle {
    /// Name for people.
    pub name: String,
    /// Reference point of the hardpoints in the chassis frame, m.
    pub position: Point,
    /// What steers its wheels, if anything does.
    #[serde(default)]
    pub steering: Option<SteeringGear>,
    /// Whether the engine drives it.
    pub driven: bool,
    /// Unsprung mass a wheel, a beam's own left out, kg.
    pub unsprung_mass: f64,
    /// Spin inertia a wheel, kg m².
    pub spin_inertia: f64,
    /// Greatest brake torque a wheel, N m.
    pub brake_torque: f64,
    /// How the wheels are guided.
    pub suspension: Suspension,
    /// The tyre on its two wheels, if it is another than the vehicle's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tyre: Option<TyreSpec>,
    /// The tyres that may be fitted to this axle instead, by name, where it has a tyre of its own.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub tyres: BTreeMap<String, TyreSpec>,
}

fn full_size() -> f64 {
    1.0
}

impl VehicleSpec {
    /// Mass of the whole vehicle, kg.
    #[must_use]
    pub fn total_mass(&self) -> f64 {
        let axle = |a: &Axle| 2.0 * a.unsprung_mass + a.suspension.linkage.beam().map_or(0.0, |b| b.mass);
        self.chassis.mass + self.axles.iter().map(axle).sum::<f64>()
    }

    /// Radius and width of every wheel, front to back, left before right, m; in a track without the belt around it.
    #[must_use]
    pub fn wheel_sizes(&self) -> Vec<[f64; 2]> {
        let belt = self.tracks.as_ref().map_or(0.0, |t| t.thickness);
        let size = |a: &Axle| [self.tyre_of(a).radius() - belt, self.tyre_of(a).width()];
        self.axles.iter().flat_map(|a| [size(a); 2]).collect()
    }

    /// Whether steering commands go to the driveline instead of the wheels.
    #[must_use]
    pub fn steers_by_driveline(&self) -> bool {
        self.steering.by == SteeredBy::Differential
    }
}
