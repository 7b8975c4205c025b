//! The first stage of a step: where the wheels are and how they move, from the suspension's tables.

use super::design::{Design, Guide};
use super::state::{Body, Wheel};
use super::steering::Steering;
use crate::tyre::WheelMotion;
use crate::{M3, V3};

/// Where a wheel is in a step, and how it can move and does; world axes.
#[derive(Clone, Copy)]
pub(super) struct Placement {
    /// Hub relative to the centre of mass.
    pub(super) arm: V3,
    /// ∂hub/∂travel.
    pub(super) tangent: V3,
    /// Part of the hub's acceleration that comes from the bend of its path.
    pub(super) bend: V3,
    /// The rotation of the upright over the travel, rad/m.
    pub(super) tilt: V3,
    /// ∂hub/∂command of the steering and the rotation of the upright over it, rad; 0 for a wheel that isn't steered.
    pub(super) steer: V3,
    pub(super) steer_tilt: V3,
    /// The lengths of the struts, as in [`vb_vehicle::kinematics::WheelPose`].
    pub(super) struts: [f64; 2],
    /// ∂strut/∂travel. It is 0 for a wheel on a beam, for which [`BeamPlacement`] has it over both travels.
    pub(super) strut_rates: [f64; 2],
    /// The angle of this side's arm of the anti-roll bar, or what stands for it, and ∂bar/∂travel.
    pub(super) bar: f64,
    pub(super) bar_rate: f64,
    /// Its motion over the ground, that of the steering included.
    pub(super) motion: WheelMotion,
}

impl Placement {
    /// The content of a buffer that no step has filled yet.
    pub(super) const NOWHERE: Self = {
        const O: V3 = V3::new(0.0, 0.0, 0.0);
        Self {
            arm: O,
            tangent: O,
            bend: O,
            tilt: O,
            steer: O,
            steer_tilt: O,
            struts: [0.0; 2],
            strut_rates: [0.0; 2],
            bar: 0.0,
            bar_rate: 0.0,
            motion: WheelMotion { hub: O, velocity: O, rotation: O, axis: O, spin: 0.0 },
        }
    };
}

/// Where a beam is in a step, and how it moves with the travels of its wheels; world axes.
#[derive(Clone, Copy, Default)]
pub(super) struct BeamPlacement {
    /// The middle relative to the centre of mass.
    pub(super) arm: V3,
    /// ∂middle/∂travel, left and right.
    pub(super) tangents: [V3; 2],
    /// Part of the middle's acceleration that comes from the bend of its path.
    pub(super) bend: V3,
    /// ∂hub/∂(the other wheel's travel), and the same of the axle's rotation.
    pub(super) cross: [V3; 2],
    pub(super) cross_tilt: [V3; 2],
    /// `[wheel][strut][travel]`.
    pub(super) strut_rates: [[[f64; 2]; 2]; 2],
}

/// How the vehicle is placed and how it moves when a step begins. The stages that follow read this, and none changes it.
pub(super) struct Kinematics<'a> {
    pub(super) body: &'a Body,
    /// The rotation from body axes to world axes.
    pub(super) turn: M3,
    pub(super) wheels: &'a [Wheel],
    pub(super) placements: &'a [Placement],
    pub(super) beams: &'a [BeamPlacement],
}

impl<'a> Kinematics<'a> {
    /// Places the wheels and the beams of a vehicle. `placements` and `beams` are buffers for the result.
    pub(super) fn place(
        design: &Design,
        body: &'a Body,
        wheels: &'a [Wheel],
        steering: Steering,
        placements: &'a mut [Placement],
        beams: &'a mut [BeamPlacement],
    ) -> Self {
        let turn = *body.q.to_rotation_matrix().matrix();
        for ((c, w), place) in design.corners.iter().zip(wheels).zip(placements.iter_mut()) {
            let (Guide::Table(table) | Guide::Mount(table)) = &c.guide else { continue };
            let command = if c.steered { steering.command } else { 0.0 };
            let pose = table.at(w.travel, command);
            let arm = turn * (c.mount + pose.hub);
            let axis = turn * pose.axis;
            let tangent = turn * pose.hub_rate;
            let tilt = turn * pose.tilt_rate;
            let mut velocity = body.v_world + body.w_world.cross(&arm) + tangent * w.travel_rate;
            let mut rotation = body.w_world + tilt * w.travel_rate + axis * w.spin;
            let (mut steer, mut steer_tilt) = (V3::zeros(), V3::zeros());
            if c.steered {
                (steer, steer_tilt) = (turn * pose.hub_steer_rate, turn * pose.steer_tilt_rate);
                velocity += steer * steering.rate;
                rotation += steer_tilt * steering.rate;
            }
            *place = Placement {
                arm,
                tangent,
                bend: turn * pose.hub_curvature * (w.travel_rate * w.travel_rate),
                tilt,
                steer,
                steer_tilt,
                struts: pose.struts,
                strut_rates: pose.strut_rates,
                bar: pose.bar,
                bar_rate: pose.bar_rate,
                motion: WheelMotion { hub: body.x_world + arm, velocity, rotation, axis, spin: w.spin },
            };
        }
        for (b, beam) in design.beams.iter().zip(beams.iter_mut()) {
            let pair = b.left..b.left + 2;
            let (corners, wheels) = (&design.corners[pair.clone()], &wheels[pair.clone()]);
            let command = if corners[0].steered { steering.command } else { 0.0 };
            let rates = [wheels[0].travel_rate, wheels[1].travel_rate];
            let pose = b.kinematics.at([wheels[0].travel, wheels[1].travel], rates, command);
            let places = placements[pair].iter_mut();
            for (i, (((p, c), w), place)) in
                pose.wheels.iter().zip(corners).zip(wheels).zip(places).enumerate()
            {
                let arm = turn * (c.mount + p.hub);
                let axis = turn * p.axis;
                let tangent = turn * p.hub_rates[i];
                let tilt = turn * p.tilt_rates[i];
                let cross = turn * p.hub_rates[1 - i];
                let cross_tilt = turn * p.tilt_rates[1 - i];
                let (steer, steer_tilt) = (turn * p.hub_steer_rate, turn * p.steer_tilt_rate);
                let velocity = body.v_world
                    + body.w_world.cross(&arm)
                    + tangent * rates[i]
                    + cross * rates[1 - i]
                    + steer * steering.rate;
                let rotation = body.w_world
                    + tilt * rates[i]
                    + cross_tilt * rates[1 - i]
                    + steer_tilt * steering.rate
                    + axis * w.spin;
                *place = Placement {
                    arm,
                    tangent,
                    bend: turn * p.bend,
                    tilt,
                    steer,
                    steer_tilt,
                    struts: p.struts,
                    strut_rates: [0.0; 2],
                    bar: 0.0,
                    bar_rate: 0.0,
                    motion: WheelMotion { hub: body.x_world + arm, velocity, rotation, axis, spin: w.spin },
                };
                beam.cross[i] = cross;
                beam.cross_tilt[i] = cross_tilt;
                beam.strut_rates[i] = p.strut_rates;
            }
            beam.arm = turn * (b.mount + pose.middle);
            beam.tangents = pose.middle_rates.map(|r| turn * r);
            beam.bend = turn * pose.middle_bend;
        }
        Self { body, turn, wheels, placements, beams }
    }
}
