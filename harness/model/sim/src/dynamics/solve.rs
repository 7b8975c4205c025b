//! The stage of a step that eliminates the corners and solves for the accelerations.

use super::beam::eliminate;
use super::contact::Forces;
use super::design::{Design, Guide};
use super::drive::Driven;
use super::granular::Wrench;
use super::kinematics::Kinematics;
use super::state::Body;
use crate::{M3, V3};
use vb_vehicle::MAX_WHEELS;
use vb_vehicle::table::interpolate;

/// What a step adds to the velocities: the accelerations times its length.
pub(super) struct Increments {
    /// Of the chassis' centre of mass, m/s, world axes.
    pub(super) velocity: V3,
    /// Of the chassis, rad/s, world axes.
    pub(super) angular_velocity: V3,
    /// Of all wheels, m/s.
    pub(super) travel_rates: [f64; MAX_WHEELS],
}

/// Solves [A C; Cᵀ L] (α, a) = (moment, force) by Cholesky's decomposition; not a number where the matrix isn't positive
/// definite. It is for every finite state; if it isn't, the state isn't finite, which the caller reports.
///
/// Written out since nalgebra's own goes through views of a size that is known when it runs, which takes several times as
/// long. The order of operations is the same.
#[inline]
fn accelerations(angular: &M3, coupling: &M3, linear: &M3, moment: &V3, force: &V3) -> (V3, V3) {
    const N: usize = 6;
    // Lower triangle, column by column.
    let mut l = [[0.0; N]; N];
    for j in 0..3 {
        for i in 0..3 {
            l[j][i] = angular[(i, j)];
            l[j][3 + i] = coupling[(j, i)];
            l[3 + j][3 + i] = linear[(i, j)];
        }
    }
    let mut b = [moment.x, moment.y, moment.z, force.x, force.y, force.z];
    for j in 0..N {
        for k in 0..j {
            let column = l[k];
            let factor = -column[j];
            for (value, x) in l[j][j..].iter_mut().zip(&column[j..]) {
                *value += factor * x;
            }
        }
        let diagonal = l[j][j];
        if diagonal.is_nan() || diagonal <= 0.0 {
            return (V3::repeat(f64::NAN), V3::repeat(f64::NAN));
        }
        let root = diagonal.sqrt();
        l[j][j] = root;
        for value in &mut l[j][j + 1..] {
            *value /= root;
        }
    }
    for i in 0..N {
        b[i] /= l[i][i];
        for k in i + 1..N {
            b[k] += -b[i] * l[i][k];
        }
    }
    for i in (0..N).rev() {
        let mut sum = 0.0;
        for k in i + 1..N {
            sum += l[i][k] * b[k];
        }
        b[i] = (b[i] - sum) / l[i][i];
    }
    (V3::new(b[0], b[1], b[2]), V3::new(b[3], b[4], b[5]))
}

/// Resistance of the air, N, world axes.
fn air(design: &Design, body: &Body) -> V3 {
    let speed = body.v_world.norm();
    if design.resistance.is_empty() || speed <= 0.0 {
        return V3::zeros();
    }
    // A table that starts above zero must not push a vehicle at rest.
    let force = interpolate(&design.resistance, speed).0 * (speed / 0.1).min(1.0);
    body.v_world * (-force / speed)
}

/// Velocity increments in a step of `dt` (s) under the forces on wheels and hull, the driveline's torques and gravity (world axes,
/// m/s²).
pub(super) fn solve(
    design: &Design,
    kinematics: &Kinematics<'_>,
    forces: &[Forces],
    on_hull: Option<Wrench>,
    driven: &Driven,
    gravity: &V3,
    dt: f64,
) -> Increments {
    let Kinematics { body, turn, wheels, placements, .. } = kinematics;
    let inertia = turn * M3::from_diagonal(&design.inertia) * turn.transpose();
    let mut angular = inertia;
    let mut coupling = M3::zeros();
    let mut linear = M3::from_diagonal_element(design.mass);
    let mut moment = -body.w_world.cross(&(inertia * body.w_world));
    let mut force = gravity * design.mass + air(design, body);
    if let Some(on_hull) = on_hull {
        moment += on_hull.moment;
        force += on_hull.force;
    }
    // Per corner: M t, tᵀMt with the dampers' implicit part, right-hand side.
    let mut reduced = [(V3::zeros(), 0.0, 0.0); MAX_WHEELS];
    // What anti-roll bars add: force along the travel, implicit damping.
    let mut twisted = [(0.0, 0.0); MAX_WHEELS];
    for bar in &design.bars {
        let pair = [bar.left, bar.left + 1];
        let [l, r] = pair.map(|i| (&wheels[i], &placements[i]));
        let rate = l.1.bar_rate * l.0.travel_rate - r.1.bar_rate * r.0.travel_rate;
        let torque = bar.stiffness * (l.1.bar - r.1.bar) + bar.damping * rate;
        for (i, sign) in pair.into_iter().zip([1.0, -1.0]) {
            let ratio = placements[i].bar_rate;
            twisted[i] = (-sign * torque * ratio, bar.damping * ratio * ratio);
        }
    }
    let corners = design.corners.iter().zip(*wheels).zip(*placements).zip(forces);
    for (i, (((c, wheel), p), f)) in corners.enumerate() {
        // The driveline reacts on the chassis; a spinning wheel resists being turned.
        let axis = p.motion.axis;
        let gyroscopic = body.w_world.cross(&(axis * (c.spin_inertia * driven.spins[i])));
        moment += f.moment - axis * driven.torques[i] - gyroscopic;
        if let Guide::Beam(_) = c.guide {
            continue;
        }
        if let Guide::Mount(_) = c.guide {
            let bias = body.w_world.cross(&body.w_world.cross(&p.arm));
            let passed = f.force + gravity * c.mass - f.inertia * bias;
            let s = p.arm.cross_matrix();
            let sm = s * f.inertia;
            angular -= sm * s;
            coupling += sm;
            linear += f.inertia;
            force += passed;
            moment += p.arm.cross(&passed);
            continue;
        }
        let (mut along, mut damping) = twisted[i];
        for (k, strut) in c.struts.iter().enumerate().take(2) {
            let ratio = p.strut_rates[k];
            let resistance = strut.resistance(ratio * wheel.travel_rate) * ratio * ratio;
            along += strut.force(p.struts[k]) * ratio - resistance * wheel.travel_rate;
            damping += resistance;
        }
        if let Some(stops) = &c.stops {
            along -= stops.force(wheel.travel);
        }
        let bias = body.w_world.cross(&body.w_world.cross(&p.arm))
            + body.w_world.cross(&p.tangent) * (2.0 * wheel.travel_rate)
            + p.bend;
        let applied = f.force + gravity * c.mass;
        let mt = f.inertia * p.tangent;
        let d = mt.dot(&p.tangent) + dt * damping;
        let rhs = p.tangent.dot(&applied) + p.tilt.dot(&f.moment) + along - mt.dot(&bias);
        let articulated = f.inertia - mt * mt.transpose() / d;
        let passed = applied - f.inertia * bias - mt * (rhs / d);
        let s = p.arm.cross_matrix();
        let sm = s * articulated;
        angular -= sm * s;
        coupling += sm;
        linear += articulated;
        force += passed;
        moment += p.arm.cross(&passed);
        reduced[i] = (mt, d, rhs);
    }
    let mut beams = [None; MAX_WHEELS / 2];
    for (i, kept) in (0..design.beams.len()).zip(&mut beams) {
        let (p, remembered) = eliminate(design, i, kinematics, forces, gravity, dt);
        angular += p.angular;
        coupling += p.coupling;
        linear += p.linear;
        moment += p.moment;
        force += p.force;
        *kept = Some(remembered);
    }
    let (alpha, acceleration) = accelerations(&angular, &coupling, &linear, &moment, &force);
    let mut travel_rates = [0.0; MAX_WHEELS];
    for (i, (c, p)) in design.corners.iter().zip(*placements).enumerate() {
        if !matches!(c.guide, Guide::Table(_)) {
            continue;
        }
        let (mt, d, rhs) = reduced[i];
        let hub = acceleration + alpha.cross(&p.arm);
        travel_rates[i] = dt * (rhs - mt.dot(&hub)) / d;
    }
    for (b, kept) in design.beams.iter().zip(&beams) {
        let Some(kept) = kept else { continue };
        let travels = kept.travels(&alpha, &acceleration);
        travel_rates[b.left] = dt * travels[0];
        travel_rates[b.left + 1] = dt * travels[1];
    }
    Increments { velocity: acceleration * dt, angular_velocity: alpha * dt, travel_rates }
}
