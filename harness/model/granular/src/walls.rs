//! Floor and walls of a bin.

use crate::V3;
use crate::contact::{Law, Surface};
use crate::packing::Bin;

/// Floor and walls, which may be moved or taken away.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Walls {
    bin: Bin,
    /// How far the wall towards +x has been moved outwards, m.
    pub(crate) opening: f64,
    /// How many of them there are.
    pub(crate) count: u8,
}

impl Walls {
    /// The number of the floor; the walls towards −x, +x, −y and +y follow.
    pub(crate) const FLOOR: u8 = 0;

    pub(crate) fn new(bin: Bin) -> Self {
        Self { bin, opening: 0.0, count: 5 }
    }

    /// The distance of a point from a wall, m, and the wall's normal into the bin.
    pub(crate) fn distance(&self, wall: u8, x: &V3) -> (f64, V3) {
        let (length, width) = (0.5 * self.bin.length, 0.5 * self.bin.width);
        match wall {
            Self::FLOOR => (x.z, V3::z()),
            1 => (x.x + length, V3::x()),
            2 => (length + self.opening - x.x, -V3::x()),
            3 => (x.y + width, V3::y()),
            _ => (width - x.y, -V3::y()),
        }
    }

    /// A wall as a point above it meets it: the floor is like the grains, the walls are smooth.
    pub(crate) fn surface(&self, wall: u8, x: &V3, law: &Law) -> Surface {
        let (distance, normal) = self.distance(wall, x);
        let smooth = Law { friction: 0.0, rolling_resistance: 0.0, cohesion: 0.0, ..*law };
        let law = if wall == Self::FLOOR { *law } else { smooth };
        Surface { distance, normal, velocity: V3::zeros(), spin: V3::zeros(), law }
    }
}
