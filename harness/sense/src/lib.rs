//! What a vehicle perceives.
pub mod rays;
pub(crate) type V3 = nalgebra::Vector3<f64>;
pub(crate) type Quat = nalgebra::UnitQuaternion<f64>;
