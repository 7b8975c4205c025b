//! Vehicle dynamics: suspension, tyres, powertrain, contacts.
//!
//! The vehicle is a chassis with six degrees of freedom and one corner a wheel, each with a suspension travel and a
//! spin; two wheels on a solid axle share a beam. Corners and beams are eliminated from the equations of motion in the
//! manner of articulated bodies, so a step costs one 6 × 6 solve. State and integration are our own, in f64, with
//! symplectic Euler at a fixed step and linearly implicit dampers; rapier resolves contacts of the chassis hull with
//! ground and obstacles, and parry finds contacts of wheels with obstacles, only when something is near.
//!
//! Axes: world x east, y north, z up; body x forward, y left, z up (ISO 8855). SI units, radians.

mod collision;
mod dynamics;
mod error;
mod model;
mod monitor;
mod powertrain;
mod simulation;
mod soil;
mod spec;
mod state;
mod suspension;
mod track;
mod tyre;

pub use dynamics::WheelStand;
pub use error::SimError;
pub use model::VehicleModel;
pub use powertrain::DriveState;
pub use simulation::{SimOptions, Simulation, Start};
pub use soil::{Bulldozing, Classes, Levels, PressureDirection, SoilLaw, SoilSet, WheelBehaviour, WheelRig};
pub use spec::{
    AntiRoll, Axle, Beam, BrushTyre, Chassis, Converter, Damper, Differential, Dilation, DoubleWishbone,
    Driveline, DrivenAxle, Engine, FialaTyre, Gearbox, Governor, HardContact, KnuckleDrive, Knuckles,
    LeafAxle, Linkage, LockUp, Multilink, Part, PivotAxle, Powertrain, RigidMount, RigidTyre, Rod,
    SingleWishbone, SolidAxle, Spring, SteeredBy, Steering, SteeringGear, Stops, Strut, StrutStops,
    Suspension, TmeasyTyre, Torsion, TorsionArm, Tracks, TyreSpec, VehicleSpec,
};
pub use state::{Controls, VehicleState, WheelState};
pub use suspension::{AxleKinematics, LinkageError, Motion, Side, SteeringAxis, WheelPose, WheelSample};
pub use track::{Course, Disc, Span};
pub use tyre::{Contact, Envelope, Patch, SteadyForce, Tyre};

pub(crate) type V3 = nalgebra::Vector3<f64>;
pub(crate) type M3 = nalgebra::Matrix3<f64>;
pub(crate) type Quat = nalgebra::UnitQuaternion<f64>;

/// Standard gravity as the original uses it, m/s² (Chrono's default, ChSystem.cpp).
pub const GRAVITY: f64 = 9.81;
