//! Suspension linkages, solved once into tables over wheel travel and rack displacement.
//!
//! A double wishbone with ideal joints and massless arms leaves the upright one degree of freedom beside steering.
//! Six equations (five fixed lengths and the height of the spindle) in the six coordinates of the upright are
//! solved by Newton's method, going outwards from the design position. What the equations of motion need comes from
//! the tables by cubic Hermite interpolation over travel and linear interpolation over the rack, with derivatives
//! of the very interpolant, so that spring forces stay conservative.

mod linkage;

use crate::V3;
use crate::spec::Suspension;
use linkage::Linkage;
use nalgebra::UnitQuaternion;

/// Half the range of travel that is tabulated, m.
const HALF_RANGE: f64 = 0.16;
const TRAVELS: usize = 33;
const RACKS: usize = 9;
/// x, y of the hub; x and z of the axle's direction; strut length.
const VALUES: usize = 5;

type Row = [f64; VALUES];

/// Positions of a left wheel's upright over travel and rack displacement.
#[derive(Clone, Debug)]
pub struct SuspensionTable {
    /// Greatest rack displacement, m; 0 for an axle that isn't steered.
    rack_travel: f64,
    /// Height of the wheel centre at travel 0, relative to the axle's reference point, m.
    z_design: f64,
    /// `[rack][travel]`.
    rows: Vec<[Row; TRAVELS]>,
}

/// Where a wheel is, in the chassis frame relative to the axle's reference point, with its change over travel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CornerPose {
    /// Wheel centre, m.
    pub hub: V3,
    /// ∂hub/∂travel.
    pub hub_rate: V3,
    /// ∂hub/∂command of the steering, m.
    pub hub_steer_rate: V3,
    /// Direction of the axle, to the left.
    pub axis: V3,
    /// Rotation of the upright per travel, rad/m, its component across the axle.
    pub tilt_rate: V3,
    /// Length of the strut, m.
    pub strut: f64,
    /// ∂strut/∂travel; the motion ratio with its sign.
    pub strut_rate: f64,
}

impl SuspensionTable {
    /// Solves the linkage for all travels and, with `rack_travel` > 0, all rack positions.
    ///
    /// # Errors
    /// A text that tells where the linkage doesn't close.
    pub fn solve(suspension: &Suspension, rack_travel: f64) -> Result<Self, String> {
        let Suspension::DoubleWishbone { hardpoints, .. } = suspension;
        let linkage = Linkage::new(hardpoints);
        let racks = if rack_travel > 0.0 { RACKS } else { 1 };
        let design = (linkage.spindle, UnitQuaternion::identity());
        let mut rows = Vec::with_capacity(racks);
        for k in 0..racks {
            let rack =
                if racks == 1 { 0.0 } else { rack_travel * (2.0 * k as f64 / (racks - 1) as f64 - 1.0) };
            let locked = |travel: f64, rack: f64| {
                format!("the linkage does not close at travel {travel:.3} m, rack {rack:.4} m")
            };
            let mut centre = design;
            for part in 1..=8 {
                let r = rack * f64::from(part) / 8.0;
                centre = linkage.solve(0.0, r, centre).ok_or_else(|| locked(0.0, r))?;
            }
            let mut column = [[0.0; VALUES]; TRAVELS];
            let middle = TRAVELS / 2;
            column[middle] = linkage.row(centre);
            for direction in [-1.0, 1.0] {
                let mut pose = centre;
                for step in 1..=middle {
                    let travel = direction * HALF_RANGE * step as f64 / middle as f64;
                    pose = linkage.solve(travel, rack, pose).ok_or_else(|| locked(travel, rack))?;
                    let index = if direction < 0.0 { middle - step } else { middle + step };
                    column[index] = linkage.row(pose);
                }
            }
            if let Some(w) = column.windows(2).position(|w| w[1][4] >= w[0][4]) {
                let travel = HALF_RANGE * (w as f64 / middle as f64 - 1.0);
                return Err(format!("the strut does not shorten in compression at travel {travel:.3} m"));
            }
            rows.push(column);
        }
        Ok(Self { rack_travel, z_design: linkage.spindle.z, rows })
    }

    /// Pose of the left (`side` = 1) or right (−1) wheel at a travel (m, compression positive) and a steering
    /// command in [-1, 1]. Beyond the tabulated travel the linkage keeps its end position and moves up and down.
    #[must_use]
    pub fn at(&self, travel: f64, steering: f64, side: f64) -> CornerPose {
        // Command +1 moves the rack to the right; for the mirrored right wheel that is inwards instead of outwards.
        let rack = -steering * side;
        let (o, d, s) = if self.rack_travel > 0.0 {
            let position = ((rack + 1.0) * 0.5 * (RACKS - 1) as f64).clamp(0.0, (RACKS - 1) as f64);
            let k = (position as usize).min(RACKS - 2);
            let f = position - k as f64;
            let ((o0, d0), (o1, d1)) = (hermite(&self.rows[k], travel), hermite(&self.rows[k + 1], travel));
            let mix = |a: &Row, b: &Row| std::array::from_fn::<f64, VALUES, _>(|c| a[c] + (b[c] - a[c]) * f);
            // ∂/∂command for the left wheel: the rack moves by −1 per command.
            let slope = -0.5 * (RACKS - 1) as f64;
            (mix(&o0, &o1), mix(&d0, &d1), [(o1[0] - o0[0]) * slope * side, (o1[1] - o0[1]) * slope * side])
        } else {
            let (o, d) = hermite(&self.rows[0], travel);
            (o, d, [0.0; 2])
        };
        let ay = (1.0 - o[2] * o[2] - o[3] * o[3]).sqrt();
        let ay_rate = -(o[2] * d[2] + o[3] * d[3]) / ay;
        let axis = V3::new(side * o[2], ay, side * o[3]);
        let axis_rate = V3::new(side * d[2], ay_rate, side * d[3]);
        CornerPose {
            hub: V3::new(o[0], side * o[1], self.z_design + travel),
            hub_rate: V3::new(d[0], side * d[1], 1.0),
            hub_steer_rate: V3::new(s[0], side * s[1], 0.0),
            axis,
            tilt_rate: axis.cross(&axis_rate),
            strut: o[4],
            strut_rate: d[4],
        }
    }
}

/// Catmull–Rom interpolation over travel: values and derivatives; constant values beyond the ends.
#[inline]
fn hermite(rows: &[Row; TRAVELS], travel: f64) -> (Row, Row) {
    let step = 2.0 * HALF_RANGE / (TRAVELS - 1) as f64;
    let s = (travel + HALF_RANGE) / step;
    let last = (TRAVELS - 1) as f64;
    if !(0.0..=last).contains(&s) {
        let end = if s > 0.0 { rows[TRAVELS - 1] } else { rows[0] };
        // The strut goes on shortening at the end's rate: a spring that lost its rate there would let go.
        let (a, b) = if s > 0.0 { (TRAVELS - 2, TRAVELS - 1) } else { (0, 1) };
        let rate = (rows[b][4] - rows[a][4]) / step;
        let beyond = travel - if s > 0.0 { HALF_RANGE } else { -HALF_RANGE };
        return ([end[0], end[1], end[2], end[3], end[4] + rate * beyond], [0.0, 0.0, 0.0, 0.0, rate]);
    }
    let k = (s as usize).min(TRAVELS - 2);
    let f = s - k as f64;
    let (before, after) = (k.saturating_sub(1), (k + 2).min(TRAVELS - 1));
    let (mut value, mut rate) = ([0.0; VALUES], [0.0; VALUES]);
    for c in 0..VALUES {
        let (p0, p1) = (rows[k][c], rows[k + 1][c]);
        let m0 = (p1 - rows[before][c]) / (k + 1 - before) as f64;
        let m1 = (rows[after][c] - p0) / (after - k) as f64;
        let (a, b) = (2.0 * (p0 - p1) + m0 + m1, -3.0 * (p0 - p1) - 2.0 * m0 - m1);
        value[c] = ((a * f + b) * f + m0) * f + p0;
        rate[c] = ((3.0 * a * f + 2.0 * b) * f + m0) / step;
    }
    (value, rate)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::VehicleSpec;
    use vb_math::angle::degrees;
    use vb_math::{asin, atan2};

    fn tables() -> (SuspensionTable, SuspensionTable) {
        let v = VehicleSpec::parse(include_str!("../../../../tasks/vehicles/hmmwv.yaml"), "hmmwv").unwrap();
        let t = |i: usize, rack: f64| SuspensionTable::solve(&v.axles[i].suspension, rack).unwrap();
        (t(0, v.steering.rack_travel), t(1, 0.0))
    }

    /// (travel, strut length, toe deg left positive counter-clockwise, camber deg left positive top outward), from an
    /// independent solution of the same hardpoints: reference sheet vehicles/hmmwv.yaml, wheel_travel_table.
    #[test]
    fn strut_toe_and_camber_agree_with_the_independent_solution_of_the_reference_sheet() {
        let front = [
            (-0.16, 0.53622, -3.6302, -1.0468),
            (-0.08, 0.44857, -0.7234, 1.0882),
            (0.0, 0.37023, 0.0, 0.0),
            (0.08, 0.29402, 0.2605, -2.5356),
            (0.16, 0.218, 0.3759, -6.3026),
        ];
        let rear = [
            (-0.16, 0.51918, 2.0679, 1.4862),
            (-0.08, 0.43988, 0.3619, 1.9608),
            (0.0, 0.36823, 0.0, 0.0),
            (0.08, 0.29886, -0.1583, -3.2837),
            (0.16, 0.22999, -0.2997, -7.7921),
        ];
        let (f, r) = tables();
        for (table, sheet) in [(f, front), (r, rear)] {
            for (travel, strut, toe, camber) in sheet {
                let p = table.at(travel, 0.0, 1.0);
                assert!((p.strut - strut).abs() < 2e-5, "{travel}: strut {} {strut}", p.strut);
                let got = degrees(atan2(-p.axis.x, p.axis.y));
                assert!((got - toe).abs() < 2e-3, "{travel}: toe {got} {toe}");
                // The axle points to the left: camber with the top outward lowers its left end.
                let got = degrees(asin(-p.axis.z));
                assert!((got - camber).abs() < 2e-3, "{travel}: camber {got} {camber}");
            }
        }
    }

    /// Reference sheet: 21.178 deg left and 22.234 deg right at full left lock.
    #[test]
    fn full_lock_turns_the_wheels_by_the_angles_of_the_reference_sheet_and_mirrors_to_the_right() {
        let (f, _) = tables();
        let angle = |command: f64, side: f64| {
            let a = f.at(0.0, command, side).axis;
            degrees(atan2(-a.x, a.y))
        };
        assert!((angle(1.0, 1.0) - 21.178).abs() < 0.01, "{}", angle(1.0, 1.0));
        assert!((angle(1.0, -1.0) - 22.234).abs() < 0.01, "{}", angle(1.0, -1.0));
        assert!((angle(-1.0, 1.0) + 22.234).abs() < 0.01);
        assert!((angle(-1.0, -1.0) + 21.178).abs() < 0.01);
    }

    #[test]
    fn rates_are_the_derivatives_of_the_positions() {
        let (f, _) = tables();
        let h = 1e-6;
        for (travel, command, side) in [(0.031, 0.3, 1.0), (-0.077, -0.8, -1.0), (0.12, 0.1, 1.0)] {
            let at = |q: f64, s: f64| f.at(q, s, side);
            let p = at(travel, command);
            let (a, b) = (at(travel - h, command), at(travel + h, command));
            assert!(((b.hub - a.hub) / (2.0 * h) - p.hub_rate).norm() < 1e-6);
            assert!((b.strut - a.strut) / (2.0 * h) - p.strut_rate < 1e-6);
            let turn = p.axis.cross(&((b.axis - a.axis) / (2.0 * h)));
            assert!((turn - p.tilt_rate).norm() < 1e-5);
            let (a, b) = (at(travel, command - h), at(travel, command + h));
            assert!(((b.hub - a.hub) / (2.0 * h) - p.hub_steer_rate).norm() < 1e-5);
        }
    }
}
