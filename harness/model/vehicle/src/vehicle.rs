//! A vehicle as data. The file format is that of `tasks/vehicles/*.yaml`; see there for a commented example.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use crate::powertrain::Powertrain;
use crate::skid::Skid;
use crate::suspension::{Steering, SteeringGear, Suspension};
use crate::tracks::Tracks;
use crate::tyre::TyreSpec;
use vb_files::{Document as _, DocumentError, Flaw, Schema};

/// A point in the chassis frame, or relative to an axle's reference point, in chassis axes, m.
pub type Point = [f64; 3];

/// A vehicle and the hash of its file, by which runs are told apart.
#[derive(Clone, Debug)]
pub struct Vehicle {
    /// The vehicle's data.
    pub spec: VehicleSpec,
    /// SHA-256 of the vehicle's file (hex).
    pub hash: String,
}

/// A vehicle on wheels or tracks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VehicleSpec {
    /// Version of the format.
    pub schema: Schema<1>,
    /// The short name of the vehicle.
    pub name: String,
    /// A description in one line, for people.
    pub description: String,
    /// The scale of the worlds that the vehicle is made for: a length of such a world over the same length of the
    /// full-size world, so 1 for a full-size vehicle and 1/6 or 1/10 for small cars. Masses and gravity are the
    /// vehicle's own.
    #[serde(default = "full_size")]
    pub scale: f64,
    /// The deviations from the model that the vehicle was made from, a sentence each, for people.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub deviations: Vec<String>,
    /// The overall length, m.
    pub length: f64,
    /// The overall width, m.
    pub width: f64,
    /// The overall height, m.
    pub height: f64,
    /// The top speed on flat ground, m/s.
    pub max_speed: f64,
    /// The sprung body.
    pub chassis: Chassis,
    /// The axles, from front to back.
    pub axles: Vec<Axle>,
    /// The driver's steering.
    pub steering: Steering,
    /// The belts about the wheels of each side, if it is a tracked vehicle.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tracks: Option<Tracks>,
    /// The skid steering, if it is a vehicle on wheels that is steered by the speeds of its sides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skid: Option<Skid>,
    /// The tyre on all wheels, but for those of axles with a tyre of their own.
    pub tyre: TyreSpec,
    /// The tyres that may be fitted instead, by name; see [`VehicleSpec::with_tyre`].
    #[serde(default)]
    pub tyres: BTreeMap<String, TyreSpec>,
    /// The engine, the gearbox and the driveline.
    pub powertrain: Powertrain,
}

impl VehicleSpec {
    /// The same vehicle on another of its tyres. `name` is that of one of [`tyres`](Self::tyres), or the model's name
    /// of the tyre that it has.
    ///
    /// # Errors
    /// Returns an error that lists the names that there are, if the vehicle, or an axle with a tyre
    /// of its own, has no tyre of this name.
    pub fn with_tyre(mut self, name: &str) -> Result<Self, DocumentError> {
        fn fit(
            file: &str,
            field: String,
            tyre: &mut TyreSpec,
            others: &BTreeMap<String, TyreSpec>,
            name: &str,
        ) -> Result<(), DocumentError> {
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
            Err(Flaw::new(field, reason).of(VehicleSpec::KIND, file))
        }
        fit(&self.name, "tyres".to_owned(), &mut self.tyre, &self.tyres, name)?;
        for (i, axle) in self.axles.iter_mut().enumerate() {
            if let Some(tyre) = &mut axle.tyre {
                fit(&self.name, format!("axles[{i}].tyres"), tyre, &axle.tyres, name)?;
            }
        }
        Ok(self)
    }

    /// The tyre on the wheels of this axle.
    #[must_use]
    pub fn tyre_of<'a>(&'a self, axle: &'a Axle) -> &'a TyreSpec {
        axle.tyre.as_ref().unwrap_or(&self.tyre)
    }
}

/// The sprung body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Chassis {
    /// The mass of the sprung body, kg.
    pub mass: f64,
    /// The centre of mass in the chassis frame, m.
    pub com: Point,
    /// The principal moments of inertia about the centre of mass, along the chassis axes x, y, z, kg m².
    pub inertia: [f64; 3],
    /// The place of the driver's seat in the chassis frame, m, where shock and ride are measured. If it is left out, they are
    /// measured at the centre of mass of the chassis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seat: Option<Point>,
    /// The friction coefficient of the hull.
    pub friction: f64,
    /// The resistance of the air, and of what else grows with the speed, against the motion at the centre of mass, as
    /// points \[speed m/s, force N\]: linear between them and constant beyond. There is none if the list is empty.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub resistance: Vec<[f64; 2]>,
    /// Whether the faces of the wheels bear the vehicle when it lies on them: for vehicles whose wheels stand out
    /// beyond the hull, since a tyre carries on its tread only.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub wheel_faces: bool,
    /// Whether the hull passes through soil, so that it touches rigid ground and obstacles alone: as in the original,
    /// whose soil is felt only within patches of 1.0 × 0.6 m about the wheels.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub hull_passes_soil: bool,
    /// The convex parts of the hull that touch ground and obstacles, as point clouds in the chassis frame, m.
    pub hull: Vec<Vec<Point>>,
}

/// An axle with a wheel at each side.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axle {
    /// The name of the axle, for people.
    pub name: String,
    /// The reference point of the axle's hardpoints in the chassis frame, m.
    pub position: Point,
    /// The gear that steers the wheels of the axle, if anything does.
    #[serde(default)]
    pub steering: Option<SteeringGear>,
    /// Whether the engine drives the axle.
    pub driven: bool,
    /// The unsprung mass of each wheel, without the mass of a beam, kg.
    pub unsprung_mass: f64,
    /// The spin inertia of each wheel, kg m².
    pub spin_inertia: f64,
    /// The maximum brake torque of each wheel, N m.
    pub brake_torque: f64,
    /// The suspension, which guides the wheels.
    pub suspension: Suspension,
    /// The tyre on the axle's two wheels, if it is another than the vehicle's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tyre: Option<TyreSpec>,
    /// The tyres that may be fitted to this axle instead, by name, if it has a tyre of its own.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub tyres: BTreeMap<String, TyreSpec>,
}

fn full_size() -> f64 {
    1.0
}

impl VehicleSpec {
    /// The mass of the whole vehicle, kg.
    #[must_use]
    pub fn total_mass(&self) -> f64 {
        let axle = |a: &Axle| 2.0 * a.unsprung_mass + a.suspension.linkage.beam().map_or(0.0, |b| b.mass);
        self.chassis.mass + self.axles.iter().map(axle).sum::<f64>()
    }

    /// The place at which shock and ride are measured, in the chassis frame, m: the driver's seat, or else the centre of mass of the
    /// chassis.
    #[must_use]
    pub fn seat(&self) -> Point {
        self.chassis.seat.unwrap_or(self.chassis.com)
    }

    /// The radius and the width of every wheel, front to back, left before right, m; those of a track without the belt
    /// around it.
    #[must_use]
    pub fn wheel_sizes(&self) -> Vec<[f64; 2]> {
        let belt = self.tracks.as_ref().map_or(0.0, |t| t.thickness);
        let size = |a: &Axle| [self.tyre_of(a).radius() - belt, self.tyre_of(a).width()];
        self.axles.iter().flat_map(|a| [size(a); 2]).collect()
    }
}
