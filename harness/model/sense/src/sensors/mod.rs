//! The sensors. Each takes the true state every 10 ms and says what it measures.

pub(crate) mod depth;
pub(crate) mod gnss;
pub(crate) mod imu;
pub(crate) mod lidar;
pub(crate) mod local_map;
pub(crate) mod pose;
pub(crate) mod wheels;

use crate::V3;
use crate::rays::{Ruts, Scene};
use std::sync::Arc;

/// The time between samples, s.
pub(crate) const DT: f64 = 0.01;
/// The number of samples in a second.
pub(crate) const SAMPLE_RATE: f64 = 100.0;

/// What rays are cast through.
#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    pub(crate) scene: &'a Arc<Scene>,
    pub(crate) ruts: Option<&'a dyn Ruts>,
}

/// A place that a ray of a sensor has measured.
pub(crate) struct Return {
    /// In the body frame of the vehicle at the time of the measurement, m.
    pub(crate) at: V3,
    /// How far the measurement is between the last sample, 0, and this one, 1.
    pub(crate) share: f64,
    /// Whether an obstacle was hit.
    pub(crate) obstacle: bool,
    /// The class that was recognised, if any.
    pub(crate) label: Option<u8>,
}
