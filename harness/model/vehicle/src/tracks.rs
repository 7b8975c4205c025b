//! The belts of a tracked vehicle as data.

use serde::{Deserialize, Serialize};

/// A belt about the wheels of each side.
///
/// The first and the last axle are the sprocket, which is the driven one of the two, and the idler, fixed to the chassis;
/// those between them are road wheels. Tyres are rigid and stand for the wheel with the belt around it: their radius reaches
/// to the belt's outer face, their width is the belt's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tracks {
    /// The thickness from the face on which the wheels roll to the face that meets the ground, m. The belt's pins are
    /// taken to lie in the middle.
    pub thickness: f64,
    /// The mass of one belt, kg: the inertia that it has when it moves around the wheels. The belt's weight is in the
    /// masses of chassis and axles.
    pub mass: f64,
    /// The tension at design height, N.
    pub tension: f64,
    /// The rise of the tension with the length of the way around the wheels, N/m: the stiffness of the belt and its
    /// tensioner.
    pub stiffness: f64,
    /// The rise of the tension with the rate of that length, N s/m.
    pub damping: f64,
    /// The friction of belt and wheels among themselves over the weight that they carry: its value at rest, and its
    /// growth with the speed, s/m.
    pub resistance: [f64; 2],
    /// The torque of the brake on the sprocket of the inner belt at full steering, N m.
    pub steering_torque: f64,
}
