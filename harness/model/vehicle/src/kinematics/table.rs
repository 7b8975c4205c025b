//! Tables over travel and their interpolation: Catmull–Rom splines, whose derivatives are those of the very
//! interpolant, so that spring forces stay conservative (Catmull and Rom, A class of local interpolating splines, 1974).

use crate::V3;

/// Tabulated travels of a wheel that is guided independently.
pub(super) const TRAVELS: usize = 33;
/// Nodes added at each end, which carry the table on beyond it.
pub(super) const PAD: usize = 4;
pub(super) const NODES: usize = TRAVELS + 2 * PAD;
/// x, y of the hub; x and z of the axle's direction; two struts' lengths; angle of the anti-roll bar.
pub(super) const COLUMNS: usize = 7;
pub(super) type Row = [f64; COLUMNS];

/// The place of a wheel in the chassis frame, relative to the axle's reference point, with its change over the wheel's
/// travel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelPose {
    /// The wheel's centre, m.
    pub hub: V3,
    /// ∂hub/∂travel, m/m.
    pub hub_rate: V3,
    /// ∂²hub/∂travel², 1/m.
    pub hub_curvature: V3,
    /// ∂hub/∂command of the steering, m.
    pub hub_steer_rate: V3,
    /// The rotation of the upright over the command of the steering, its component across the axle, rad.
    pub steer_tilt_rate: V3,
    /// The direction of the wheel's axle, a unit vector to the left.
    pub axis: V3,
    /// The rotation of the upright over the travel, its component across the axle, rad/m.
    pub tilt_rate: V3,
    /// The lengths of the struts, m; for a torsion bar the arm's angle, rad, taken negative.
    pub struts: [f64; 2],
    /// ∂strut/∂travel, m/m (rad/m for a torsion bar): the motion ratios with their sign, negative where a strut
    /// shortens as the wheel rises.
    pub strut_rates: [f64; 2],
    /// The angle of this side's arm of the anti-roll bar, rad; the travel (m) where there is no such arm.
    pub bar: f64,
    /// ∂bar/∂travel, rad/m; m/m where there is no such arm.
    pub bar_rate: f64,
}

/// The solved linkage of one wheel over its travel and the steering command.
#[derive(Clone, Debug)]
pub struct CornerTable {
    side: f64,
    /// Travel of the first node.
    low: f64,
    per_step: f64,
    /// Height of the wheel centre at travel 0.
    z_design: f64,
    /// `[command][travel]`.
    rows: Vec<[Row; NODES]>,
}

/// Weights of four neighbouring nodes at the fraction `f` between the middle two: value, first and second derivative
/// per distance of nodes.
#[inline]
pub(super) fn weights(f: f64) -> [[f64; 4]; 3] {
    [
        [
            ((-0.5 * f + 1.0) * f - 0.5) * f,
            (1.5 * f - 2.5) * f * f + 1.0,
            ((-1.5 * f + 2.0) * f + 0.5) * f,
            (0.5 * f - 0.5) * f * f,
        ],
        [(-1.5 * f + 2.0) * f - 0.5, (4.5 * f - 5.0) * f, (-4.5 * f + 4.0) * f + 0.5, (1.5 * f - 1.0) * f],
        [-3.0 * f + 2.0, 9.0 * f - 5.0, -9.0 * f + 4.0, 3.0 * f - 1.0],
    ]
}

/// First of the four nodes for a position counted in nodes, and the fraction; positions beyond the nodes go on with
/// the polynomial of the outermost four.
#[inline]
pub(super) fn locate(position: f64, nodes: usize) -> (usize, f64) {
    let first = (position.max(1.0) as usize).min(nodes - 3);
    (first - 1, position - first as f64)
}

impl CornerTable {
    pub(super) fn new(low: f64, step: f64, z_design: f64, side: f64, columns: &[[Row; TRAVELS]]) -> Self {
        let rows = columns.iter().map(padded).collect();
        Self { side, low: low - step * PAD as f64, per_step: 1.0 / step, z_design, rows }
    }

    /// A wheel that can't move.
    pub(super) fn fixed(spindle: V3, side: f64) -> Self {
        let row = [spindle.x, spindle.y, 0.0, 0.0, 0.0, 0.0, 0.0];
        Self { side, low: 0.0, per_step: 1.0, z_design: spindle.z, rows: vec![[row; NODES]] }
    }

    /// The same linkage at the other side, for an axle that isn't steered or whose gear does to the right at a command
    /// what it does to the left at the opposite one.
    pub(super) fn mirrored(&self) -> Self {
        let rows = self.rows.iter().rev().copied().collect();
        Self { side: -self.side, rows, ..*self }
    }

    /// The wheel's pose at a travel (m, compression positive) and a steering command in [-1, 1].
    #[inline]
    #[must_use]
    pub fn at(&self, travel: f64, command: f64) -> WheelPose {
        let (first, f) = locate((travel - self.low) * self.per_step, NODES);
        let w = weights(f);
        let last = self.rows.len() - 1;
        let (v, d, dd, steer) = if last > 0 {
            let position = ((command + 1.0) * 0.5 * last as f64).clamp(0.0, last as f64);
            let k = (position as usize).min(last - 1);
            let g = position - k as f64;
            let (a, b) = (&self.rows[k][first..first + 4], &self.rows[k + 1][first..first + 4]);
            let steer = 0.5 * last as f64;
            // The spline is linear in its nodes: mix them first.
            let mut nodes = [[0.0; COLUMNS]; 4];
            let mut shift = [0.0; 4];
            for i in 0..4 {
                for c in 0..COLUMNS {
                    nodes[i][c] = a[i][c] + (b[i][c] - a[i][c]) * g;
                }
                for c in 0..4 {
                    shift[c] += w[0][i] * (b[i][c] - a[i][c]) * steer;
                }
            }
            let (v, d, dd) = spline(&nodes, &w);
            (v, d, dd, shift)
        } else {
            let nodes: &[Row; 4] = self.rows[0][first..first + 4].try_into().expect("four nodes");
            let (v, d, dd) = spline(nodes, &w);
            (v, d, dd, [0.0; 4])
        };
        let (s, per) = (self.side, self.per_step);
        let ay = (1.0 - v[2] * v[2] - v[3] * v[3]).sqrt();
        let ay_rate = -(v[2] * d[2] + v[3] * d[3]) / ay;
        let axis = V3::new(s * v[2], ay, s * v[3]);
        let axis_rate = V3::new(s * d[2], ay_rate, s * d[3]) * per;
        let ay_steer_rate = -(v[2] * steer[2] + v[3] * steer[3]) / ay;
        let axis_steer_rate = V3::new(s * steer[2], ay_steer_rate, s * steer[3]);
        WheelPose {
            hub: V3::new(v[0], s * v[1], self.z_design + travel),
            hub_rate: V3::new(d[0] * per, s * d[1] * per, 1.0),
            hub_curvature: V3::new(dd[0], s * dd[1], 0.0) * (per * per),
            hub_steer_rate: V3::new(steer[0], s * steer[1], 0.0),
            steer_tilt_rate: axis.cross(&axis_steer_rate),
            axis,
            tilt_rate: axis.cross(&axis_rate),
            struts: [v[4], v[5]],
            strut_rates: [d[4] * per, d[5] * per],
            bar: v[6],
            bar_rate: d[6] * per,
        }
    }
}

/// Values, first and (of the first two columns) second derivatives per distance of nodes.
#[inline]
fn spline(nodes: &[Row; 4], w: &[[f64; 4]; 3]) -> (Row, Row, [f64; 2]) {
    let (mut v, mut d, mut dd) = ([0.0; COLUMNS], [0.0; COLUMNS], [0.0; 2]);
    for (i, row) in nodes.iter().enumerate() {
        for c in 0..COLUMNS {
            v[c] += w[0][i] * row[c];
            d[c] += w[1][i] * row[c];
        }
        for c in 0..2 {
            dd[c] += w[2][i] * row[c];
        }
    }
    (v, d, dd)
}

/// Carries a column of nodes on beyond its ends: positions and directions come to rest within one node, lengths and
/// angles go on at the end's rate, since a spring that lost its rate would let go. The first node beyond continues the
/// parabola through the last three, which gives the end its slope to second order.
fn padded(column: &[Row; TRAVELS]) -> [Row; NODES] {
    let mut rows = [[0.0; COLUMNS]; NODES];
    rows[PAD..PAD + TRAVELS].copy_from_slice(column);
    for (first, inwards) in [(PAD, 1_isize), (PAD + TRAVELS - 1, -1)] {
        let end = |k: isize| column[(first - PAD).saturating_add_signed(inwards * k)];
        let (p0, p1, p2) = (end(0), end(1), end(2));
        for k in 1..=PAD {
            let node = first.saturating_add_signed(-inwards * k as isize);
            for c in 0..COLUMNS {
                let step = 2.0 * p0[c] - 3.0 * p1[c] + p2[c];
                rows[node][c] = p0[c] + step * if c < 4 { 1.0 } else { k as f64 };
            }
        }
    }
    rows
}

/// Tabulated travels of each wheel of a beam.
pub(super) const BEAM_TRAVELS: usize = 17;
pub(super) const BEAM_NODES: usize = BEAM_TRAVELS + 2 * PAD;
/// Displacement of the beam's middle; vector part of its rotation's quaternion.
pub(super) const BEAM_COLUMNS: usize = 6;
pub(super) type BeamRow = [f64; BEAM_COLUMNS];

/// A beam over the travels of its left and right wheel.
#[derive(Clone, Debug)]
pub(super) struct BeamTable {
    low: f64,
    per_step: f64,
    /// `[left][right]`.
    rows: Vec<[BeamRow; BEAM_NODES]>,
}

/// Values with first derivatives over both travels and the second derivative along the present motion.
pub(super) struct BeamPoint {
    pub(super) value: BeamRow,
    pub(super) rates: [BeamRow; 2],
    /// Σᵢⱼ ∂²/∂qᵢ∂qⱼ q̇ᵢ q̇ⱼ.
    pub(super) bend: BeamRow,
}

impl BeamTable {
    /// `nodes[left][right]`.
    pub(super) fn new(low: f64, step: f64, nodes: &[[BeamRow; BEAM_TRAVELS]; BEAM_TRAVELS]) -> Self {
        let mut rows = vec![[[0.0; BEAM_COLUMNS]; BEAM_NODES]; BEAM_NODES];
        // Straight on beyond the ends: first over the right travel, then over the left.
        let inner = |i: isize| i.clamp(0, BEAM_TRAVELS as isize - 1) as usize;
        let beyond = |i: isize| (i - inner(i) as isize) as f64;
        let back = |i: isize| inner(inner(i) as isize - beyond(i).signum() as isize);
        let across = |l: usize, r: isize, c: usize| {
            let (end, before) = (nodes[l][inner(r)][c], nodes[l][back(r)][c]);
            end + (end - before) * beyond(r).abs()
        };
        for (l, row) in rows.iter_mut().enumerate() {
            for (r, node) in row.iter_mut().enumerate() {
                let (l, r) = (l as isize - PAD as isize, r as isize - PAD as isize);
                for (c, value) in node.iter_mut().enumerate() {
                    let (end, before) = (across(inner(l), r, c), across(back(l), r, c));
                    *value = end + (end - before) * beyond(l).abs();
                }
            }
        }
        Self { low: low - step * PAD as f64, per_step: 1.0 / step, rows }
    }

    #[inline]
    pub(super) fn at(&self, travels: [f64; 2], rates: [f64; 2]) -> BeamPoint {
        let per = self.per_step;
        let place = |q: f64| locate((q - self.low) * per, BEAM_NODES);
        let ((l, fl), (r, fr)) = (place(travels[0]), place(travels[1]));
        let (wl, wr) = (weights(fl), weights(fr));
        let mut p = BeamPoint {
            value: [0.0; BEAM_COLUMNS],
            rates: [[0.0; BEAM_COLUMNS]; 2],
            bend: [0.0; BEAM_COLUMNS],
        };
        let (ll, lr, rr) = (rates[0] * rates[0], 2.0 * rates[0] * rates[1], rates[1] * rates[1]);
        let square = per * per;
        for (i, row) in self.rows[l..l + 4].iter().enumerate() {
            let mut over = [[0.0; BEAM_COLUMNS]; 3];
            for (j, node) in row[r..r + 4].iter().enumerate() {
                for (c, x) in node.iter().enumerate() {
                    over[0][c] += wr[0][j] * x;
                    over[1][c] += wr[1][j] * x;
                    over[2][c] += wr[2][j] * x;
                }
            }
            let [w, dw, ddw] = [wl[0][i], wl[1][i], wl[2][i]];
            let [value, slope, bend] = over;
            for c in 0..BEAM_COLUMNS {
                p.value[c] += w * value[c];
                p.rates[0][c] += dw * value[c] * per;
                p.rates[1][c] += w * slope[c] * per;
                p.bend[c] += (ddw * value[c] * ll + dw * slope[c] * lr + w * bend[c] * rr) * square;
            }
        }
        p
    }
}
