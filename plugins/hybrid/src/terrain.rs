//! The terrain under a vehicle.

use vb_sdk::mppi::{Field, LANES, Lanes};
use vb_sdk::{GridFrame, HeightMap, LabelMap, Vehicle};

/// Number of terrain classes.
const CLASSES: usize = 10;
/// Points of the patch along the vehicle and across it.
const ALONG: usize = 10;
const ACROSS: usize = 5;
/// Size of a patch: heights, and the fraction of the wheels on each terrain class.
pub const PATCH: usize = ALONG * ACROSS + CLASSES;
/// Extent of the patch ahead of the reference point, in wheelbases.
const REACH: [f32; 2] = [-0.75, 1.25];
/// Half its width in tracks.
const HALF_WIDTH: f32 = 0.7;
/// Normalisation scale of heights, in wheelbases.
const HEIGHT: f32 = 0.1;

/// The terrain as sampled by a vehicle.
#[derive(Clone, Debug, PartialEq)]
pub struct Terrain {
    heights: Field,
    classes: Option<LabelMap>,
    wheelbase: f32,
    track: f32,
}

impl Terrain {
    /// The terrain of these maps for this vehicle; `None` if the elevation map has fewer than 2 × 2 samples. Without a
    /// class map, the class fractions are 0.
    #[must_use]
    pub fn new(heights: &HeightMap, classes: Option<&LabelMap>, vehicle: &Vehicle) -> Option<Self> {
        let mut values = heights.data.iter();
        // Samples are requested in storage order.
        let field = Field::new(heights.frame, |_, _| values.next().map_or(0.0, |v| f64::from(*v)))?;
        Some(Self {
            heights: field,
            classes: classes.cloned(),
            wheelbase: vehicle.wheelbase as f32,
            track: vehicle.track as f32,
        })
    }

    /// The heights at points of the body plane, m.
    fn at(&self, [x, y]: [&Lanes; 2], [cos, sin]: [&Lanes; 2], forward: f32, left: f32) -> Lanes {
        let px: Lanes = std::array::from_fn(|l| x[l] + forward * cos[l] - left * sin[l]);
        let py: Lanes = std::array::from_fn(|l| y[l] + forward * sin[l] + left * cos[l]);
        self.heights.at(&px, &py)
    }

    /// Wheelbase and track of the vehicle, m.
    #[must_use]
    pub fn size(&self) -> (f32, f32) {
        (self.wheelbase, self.track)
    }

    /// The terrain heights at positions, m.
    #[must_use]
    pub fn heights(&self, x: &Lanes, y: &Lanes) -> Lanes {
        self.heights.at(x, y)
    }

    /// The terrain class at a position, if there is a class map.
    #[must_use]
    pub fn class(&self, x: f32, y: f32) -> Option<usize> {
        self.classes.as_ref().map(|classes| usize::from(classes.nearest(f64::from(x), f64::from(y))))
    }

    /// The least-squares plane of the terrain under the four outer wheels: its height under the reference point (m),
    /// roll and pitch (rad; positive with the right side and the nose down).
    #[must_use]
    pub fn plane(&self, place: [&Lanes; 2], direction: [&Lanes; 2]) -> [Lanes; 3] {
        self.plane_of(|forward, left| self.at(place, direction, forward, left))
    }

    /// The plane of heights at points of the body plane.
    fn plane_of(&self, heights: impl Fn(f32, f32) -> Lanes) -> [Lanes; 3] {
        let (a, b) = (0.5 * self.wheelbase, 0.5 * self.track);
        let [fl, fr, rl, rr] = [(a, b), (a, -b), (-a, b), (-a, -b)].map(|(u, v)| heights(u, v));
        let (per_track, per_base) = (0.5 / self.track, 0.5 / self.wheelbase);
        let mut plane = [[0.0; LANES]; 3];
        for l in 0..LANES {
            let (front, rear) = (fl[l] + fr[l], rl[l] + rr[l]);
            let (rise, bank) = ((front - rear) * per_base, (fl[l] + rl[l] - fr[l] - rr[l]) * per_track);
            // Slope to angle: atan to the fifth order, with an error of 0.3 degrees at 30.
            plane[0][l] = 0.25 * (front + rear);
            plane[1][l] = bank * (1.0 - bank * bank * (1.0 / 3.0 - 0.2 * bank * bank));
            plane[2][l] = -rise * (1.0 - rise * rise * (1.0 / 3.0 - 0.2 * rise * rise));
        }
        plane
    }

    /// The patch around the vehicle: heights above the plane under its wheels in units of a tenth of a wheelbase, rear
    /// to front and right to left, then the fraction of the wheels on each terrain class.
    pub fn patch(&self, place: [&Lanes; 2], direction: [&Lanes; 2], patch: &mut [Lanes; PATCH]) {
        self.patch_of(|forward, left| self.at(place, direction, forward, left), place, direction, patch);
    }

    /// The patch of heights at points of the body plane.
    fn patch_of(
        &self,
        heights: impl Fn(f32, f32) -> Lanes,
        place: [&Lanes; 2],
        direction: [&Lanes; 2],
        patch: &mut [Lanes; PATCH],
    ) {
        let [z, roll, pitch] = self.plane_of(&heights);
        let unit = 1.0 / (HEIGHT * self.wheelbase);
        for i in 0..ALONG {
            let forward = self.wheelbase * (REACH[0] + (REACH[1] - REACH[0]) * i as f32 / (ALONG - 1) as f32);
            for j in 0..ACROSS {
                let left = self.track * HALF_WIDTH * (2.0 * j as f32 / (ACROSS - 1) as f32 - 1.0);
                let heights = heights(forward, left);
                patch[i * ACROSS + j] = std::array::from_fn(|l| {
                    // The plane, with small angles in place of tangents.
                    let plane = z[l] + left * roll[l] - forward * pitch[l];
                    ((heights[l] - plane) * unit).clamp(-4.0, 4.0)
                });
            }
        }
        let kinds = &mut patch[ALONG * ACROSS..];
        kinds.fill([0.0; LANES]);
        let (a, b) = (0.5 * self.wheelbase, 0.5 * self.track);
        for (u, v) in [(a, b), (a, -b), (-a, b), (-a, -b)] {
            for l in 0..LANES {
                let x = place[0][l] + u * direction[0][l] - v * direction[1][l];
                let y = place[1][l] + u * direction[1][l] + v * direction[0][l];
                if let Some(kind) = self.class(x, y).and_then(|class| kinds.get_mut(class)) {
                    kind[l] += 0.25;
                }
            }
        }
    }

    /// The patches at all nodes of the elevation map, for one heading. All nodes have the same offsets to their
    /// neighbours, so that rows of heights are read without interpolation of positions.
    pub(crate) fn patches<'a>(&'a self, nodes: &'a Nodes, [cos, sin]: [f32; 2]) -> Patches<'a> {
        Patches { terrain: self, nodes, cos, sin }
    }
}

/// The heights at the nodes of a map, row by row, with those of its edge repeated around it as far as patches extend.
pub(crate) struct Nodes {
    frame: GridFrame,
    heights: Vec<f32>,
    /// Padding nodes around the map.
    around: usize,
    /// Nodes per row with padding.
    width: usize,
    per_metre: f32,
}

impl Nodes {
    /// Pads the map for patches of this terrain.
    pub(crate) fn new(map: &HeightMap, terrain: &Terrain) -> Self {
        let frame = map.frame;
        let per_metre = (1.0 / frame.resolution) as f32;
        let reach = REACH[1] * terrain.wheelbase + HALF_WIDTH * terrain.track;
        let around = (reach * per_metre) as usize + 2;
        let (rows, cols) = (frame.rows as usize, frame.cols as usize);
        let (width, height) = (cols + 2 * around + LANES, rows + 2 * around);
        let inside = |k: usize, n: usize| k.saturating_sub(around).min(n - 1);
        let heights = (0..width * height)
            .map(|k| map.data[inside(k / width, rows) * cols + inside(k % width, cols)])
            .collect();
        Self { frame, heights, around, width, per_metre }
    }
}

/// Computes the patches of one heading.
pub(crate) struct Patches<'a> {
    terrain: &'a Terrain,
    nodes: &'a Nodes,
    cos: f32,
    sin: f32,
}

impl Patches<'_> {
    /// The patches at [`LANES`] nodes of a row, from a column on; those beyond the last column are unused.
    pub(crate) fn at(&self, row: usize, first: usize, patch: &mut [Lanes; PATCH]) {
        let nodes = self.nodes;
        let heights = |forward: f32, left: f32| -> Lanes {
            let around = nodes.around as f32;
            let c = (forward * self.cos - left * self.sin) * nodes.per_metre + around;
            let r = (forward * self.sin + left * self.cos) * nodes.per_metre + around;
            let (u, v) = (c - c.floor(), r - r.floor());
            let south = (row + r as usize) * nodes.width + first + c as usize;
            let south = &nodes.heights[south..south + nodes.width + LANES + 1];
            let north = &south[nodes.width..];
            std::array::from_fn(|l| {
                let low = south[l] + u * (south[l + 1] - south[l]);
                let high = north[l] + u * (north[l + 1] - north[l]);
                low + v * (high - low)
            })
        };
        let place = |l: usize| nodes.frame.position(row as u32, (first + l) as u32);
        let (x, y) = (std::array::from_fn(|l| place(l).0 as f32), std::array::from_fn(|l| place(l).1 as f32));
        let direction = [&[self.cos; LANES], &[self.sin; LANES]];
        self.terrain.patch_of(heights, [&x, &y], direction, patch);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_sdk::{GridFrame, Map};

    /// A plane that rises by 0.2 to the east and by 0.1 to the north, of gravel (4) in the east and mud (7) in the west.
    fn slope() -> Terrain {
        let frame = GridFrame { rows: 41, cols: 41, resolution: 1.0, origin_x: -20.0, origin_y: -20.0 };
        let height = |k: usize| 0.2 * (k % 41) as f32 + 0.1 * (k / 41) as f32;
        let class = |k: usize| if k % 41 > 20 { 4 } else { 7 };
        let heights = Map { frame, data: (0..41 * 41).map(height).collect() };
        let classes = Map { frame, data: (0..41 * 41).map(class).collect() };
        let vehicle = Vehicle { wheelbase: 3.0, track: 2.0, ..Vehicle::default() };
        Terrain::new(&heights, Some(&classes), &vehicle).unwrap()
    }

    #[test]
    fn a_slope_is_its_own_plane_and_its_patch_is_flat() {
        let terrain = slope();
        let (x, y) = ([3.3; LANES], [-2.6; LANES]);
        // Uphill to the east, the left side higher; to the north, uphill with the right side higher.
        for (cos, sin, roll, pitch) in [(1.0, 0.0, 0.1_f32, -0.2_f32), (0.0, 1.0, -0.2, -0.1)] {
            let direction = [&[cos; LANES], &[sin; LANES]];
            let plane = terrain.plane([&x, &y], direction);
            assert!((plane[0][0] - (0.2 * 23.3 + 0.1 * 17.4)).abs() < 1e-4, "{plane:?}");
            assert!((plane[1][0] - roll.atan()).abs() < 1e-3, "{plane:?}");
            assert!((plane[2][0] - pitch.atan()).abs() < 1e-3, "{plane:?}");
            let mut patch = [[0.0; LANES]; PATCH];
            terrain.patch([&x, &y], direction, &mut patch);
            assert!(patch[..ALONG * ACROSS].iter().all(|v| v[0].abs() < 0.15), "{patch:?}");
            let kinds: Vec<f32> = patch[ALONG * ACROSS..].iter().map(|v| v[0]).collect();
            assert_eq!((kinds[4], kinds.iter().sum::<f32>()), (1.0, 1.0));
        }
    }
}
