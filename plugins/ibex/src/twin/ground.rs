//! Terrain for wheels and hull: the triangles of the elevation map, and the assumed properties of each terrain class.

use vb_sdk::mppi::LANES;
use vb_sdk::{HeightMap, LabelMap, Vehicle};
use wide::f32x8;

use super::vector::all;

/// Properties of a terrain class. Maps contain classes, not properties.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Kind {
    pub(super) friction: f32,
    /// Sinkage of an HMMWV wheel under its static load, as a fraction of its radius.
    pub(super) sinkage: f32,
    /// Compaction resistance over load and root of the sinkage in diameters.
    pub(super) compaction: f32,
}

impl Kind {
    const fn firm(friction: f32) -> Self {
        Self { friction, sinkage: 0.0, compaction: 0.0 }
    }
}

/// Indexed by the class numbers of maps. Friction is the class mean (`tasks/generator/default.yaml`). Deformable
/// classes are the soil of medium level (`tasks/soils/default.yaml`) under an HMMWV wheel
/// (`vehicle test hmmwv --event wheel-on-soil`): maximum drawbar pull plus resistance, less a fifth for slip; sinkage; and one and a half times its
/// resistance. The last two factors were fitted on training worlds. Other levels are estimated during the task.
const KINDS: [Kind; 10] = [
    Kind::firm(0.60),
    Kind::firm(0.85),
    Kind::firm(0.60),
    Kind::firm(0.36),
    Kind::firm(0.55),
    Kind::firm(0.65),
    Kind::firm(0.45),
    Kind { friction: 0.31, sinkage: 0.139, compaction: 1.34 },
    Kind { friction: 0.50, sinkage: 0.139, compaction: 1.02 },
    Kind { friction: 0.316, sinkage: 0.33, compaction: 0.44 },
];
/// Assumed class of unknown terrain: gravel.
const UNKNOWN: usize = 4;
/// Bounds of the estimated sinkage relative to [`KINDS`].
const DEEPER: [f32; 2] = [0.15, 4.0];
/// Minimum spacing of the nodes checked under the hull: vehicle length divided by this number.
const NODES: f64 = 5.0;

#[derive(Clone, Debug)]
pub(super) struct Ground {
    heights: Vec<f32>,
    cols: usize,
    resolution: f32,
    per_metre: f32,
    origin: [f32; 2],
    /// End of the last cell, in cells.
    end: [f32; 2],
    kinds: Option<LabelMap>,
    /// Estimated sinkage relative to [`KINDS`], by class.
    deeper: [f32; KINDS.len()],
    /// Rows and columns of the nodes under a vehicle, and the stride between them.
    around: usize,
    stride: usize,
    /// Maximum height under a vehicle whose nodes begin at this node.
    highest: Vec<f32>,
}

impl Ground {
    /// The terrain of these maps; the elevation map has at least 2 × 2 samples.
    pub(super) fn new(map: &HeightMap, kinds: Option<&LabelMap>, vehicle: &Vehicle) -> Self {
        let frame = map.frame;
        let (rows, cols) = (frame.rows as usize, frame.cols as usize);
        let stride = ((vehicle.length / (NODES * frame.resolution)) as usize).max(1);
        let least = rows.min(cols);
        // As many nodes as span the vehicle in any direction, limited by the map.
        let wanted = (vehicle.length / (stride as f64 * frame.resolution)) as usize + 2;
        let around = wanted.min((least - 1) / stride + 1);
        let reach = (around - 1) * stride + 1;
        // Along rows first, then along columns.
        let greatest = |values: &[f32], step: usize, at: usize, left: usize| {
            (0..reach.min(left)).map(|k| values[at + k * step]).fold(f32::NEG_INFINITY, f32::max)
        };
        let along: Vec<f32> = (0..rows * cols).map(|k| greatest(&map.data, 1, k, cols - k % cols)).collect();
        let highest = (0..rows * cols).map(|k| greatest(&along, cols, k, rows - k / cols)).collect();
        Self {
            heights: map.data.clone(),
            cols,
            resolution: frame.resolution as f32,
            per_metre: (1.0 / frame.resolution) as f32,
            origin: [frame.origin_x as f32, frame.origin_y as f32],
            // A thousandth less, so that a position on the edge is in the last cell.
            end: [cols as f32 - 1.001, rows as f32 - 1.001],
            kinds: kinds.cloned(),
            deeper: [1.0; KINDS.len()],
            around,
            stride,
            highest,
        }
    }

    /// The terrain of other maps with the same estimates.
    pub(super) fn of(&self, map: &HeightMap, kinds: Option<&LabelMap>, vehicle: &Vehicle) -> Self {
        Self { deeper: self.deeper, ..Self::new(map, kinds, vehicle) }
    }

    /// The corner heights of the cells at these positions (south-west, south-east, north-west, north-east), and the
    /// positions within the cells. Outside the map, those of the edge.
    fn cell(&self, x: f32x8, y: f32x8) -> ([f32x8; 4], [f32x8; 2]) {
        let place = |v: f32x8, k: usize| {
            let cells = (v - all(self.origin[k])) * all(self.per_metre);
            cells.max(all(0.0)).min(all(self.end[k]))
        };
        let (c, r) = (place(x, 0), place(y, 1));
        let (cols, rows) = (c.to_array(), r.to_array());
        let (mut corners, mut low) = ([[0.0; LANES]; 4], [[0.0; LANES]; 2]);
        for l in 0..LANES {
            // NaN becomes 0.
            let (col, row) = (cols[l] as i32, rows[l] as i32);
            (low[0][l], low[1][l]) = (col as f32, row as f32);
            let i = row as usize * self.cols + col as usize;
            let around = &self.heights[i..i + self.cols + 2];
            corners[0][l] = around[0];
            corners[1][l] = around[1];
            corners[2][l] = around[self.cols];
            corners[3][l] = around[self.cols + 1];
        }
        (corners.map(f32x8::from), [c - f32x8::from(low[0]), r - f32x8::from(low[1])])
    }

    /// The heights at these positions (m), and the slopes towards the east and the north.
    #[inline]
    pub(super) fn surface(&self, x: f32x8, y: f32x8) -> [f32x8; 3] {
        let ([a, b, c, d], [u, v]) = self.cell(x, y);
        // Each cell is cut into two triangles from the south-west to the north-east, as in `HeightMap::ground`.
        let north = v.simd_ge(u);
        let (east, up) = (north.select(d - c, b - a), north.select(c - a, d - b));
        let per_metre = all(self.per_metre);
        [a + u * east + v * up, east * per_metre, up * per_metre]
    }

    /// The first node under vehicles at these positions.
    fn first(&self, x: f32x8, y: f32x8) -> [[usize; LANES]; 2] {
        let before = ((self.around / 2).max(1) - 1) * self.stride;
        let nodes = [self.end[0] as usize + 2, self.end[1] as usize + 2];
        let first = |v: f32, k: usize| {
            let cell = ((v - self.origin[k]) * self.per_metre).max(0.0) as usize;
            cell.saturating_sub(before).min(nodes[k] - (self.around - 1) * self.stride - 1)
        };
        let (x, y) = (x.to_array(), y.to_array());
        [std::array::from_fn(|l| first(x[l], 0)), std::array::from_fn(|l| first(y[l], 1))]
    }

    /// The maximum heights under vehicles at these positions, m.
    pub(super) fn highest(&self, x: f32x8, y: f32x8) -> f32x8 {
        let [col, row] = self.first(x, y);
        let highest: [f32; LANES] = std::array::from_fn(|l| self.highest[row[l] * self.cols + col[l]]);
        f32x8::from(highest)
    }

    /// Visits the nodes under vehicles at these positions: x, y and height, m.
    #[inline]
    pub(super) fn nodes(&self, x: f32x8, y: f32x8, mut see: impl FnMut([f32x8; 3])) {
        let [col, row] = self.first(x, y);
        let [west, south] = [(&col, 0), (&row, 1)].map(|(first, k)| {
            f32x8::from(first.map(|v| v as f32)) * all(self.resolution) + all(self.origin[k])
        });
        let step = self.stride as f32 * self.resolution;
        for j in 0..self.around {
            let y = south + all(j as f32 * step);
            let starts: [usize; LANES] =
                std::array::from_fn(|l| (row[l] + j * self.stride) * self.cols + col[l]);
            for i in 0..self.around {
                let z = starts.map(|start| self.heights[start + i * self.stride]);
                see([west + all(i as f32 * step), y, f32x8::from(z)]);
            }
        }
    }

    /// The class number at a position.
    fn label(&self, x: f32, y: f32) -> usize {
        let told = self.kinds.as_ref().map(|kinds| usize::from(kinds.nearest(f64::from(x), f64::from(y))));
        told.filter(|label| *label < KINDS.len()).unwrap_or(UNKNOWN)
    }

    /// The properties at a position, with the current depth estimate.
    pub(super) fn kind(&self, x: f32, y: f32) -> Kind {
        let label = self.label(x, y);
        Kind { sinkage: KINDS[label].sinkage * self.deeper[label], ..KINDS[label] }
    }

    /// Multiplies the estimated depth of the class at a position by a factor.
    pub(super) fn deepen(&mut self, x: f32, y: f32, factor: f32) {
        let deeper = &mut self.deeper[self.label(x, y)];
        *deeper = (*deeper * factor).clamp(DEEPER[0], DEEPER[1]);
    }
}
