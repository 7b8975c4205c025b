//! Where the wheels are and how they move, from the suspension's tables.

use super::{Corner, Guide, Vehicle};
use crate::{M3, V3};

impl Vehicle {
    /// Places every wheel for this step: all of [`super::Forces`] but the forces. `steer_rate` is the rate of the
    /// steering command, 1/s.
    pub(super) fn place_wheels(&mut self, turn: &M3, steer_rate: f64) {
        for (c, f) in self.corners.iter().zip(&mut self.forces) {
            f.force = V3::zeros();
            f.moment = V3::zeros();
            f.spin_moment = 0.0;
            f.inertia = M3::from_diagonal_element(c.mass);
            let (Guide::Table(table) | Guide::Mount(table)) = &c.guide else { continue };
            let command = if c.steered { self.steering } else { 0.0 };
            let pose = table.at(c.travel, command);
            f.arm = turn * (c.mount + pose.hub);
            f.axis = turn * pose.axis;
            f.tangent = turn * pose.hub_rate;
            f.tilt = turn * pose.tilt_rate;
            f.bend = turn * pose.hub_curvature * (c.travel_rate * c.travel_rate);
            f.struts = pose.struts;
            f.strut_rates = pose.strut_rates;
            f.bar = pose.bar;
            f.bar_rate = pose.bar_rate;
            f.velocity = self.v + self.w.cross(&f.arm) + f.tangent * c.travel_rate;
            f.rotation = self.w + f.tilt * c.travel_rate + f.axis * c.spin;
            if c.steered {
                f.velocity += turn * (pose.hub_steer_rate * steer_rate);
            }
        }
        for b in &mut self.beams {
            let pair = &self.corners[b.left..b.left + 2];
            let command = if pair[0].steered { self.steering } else { 0.0 };
            let rates = [pair[0].travel_rate, pair[1].travel_rate];
            let pose = b.kinematics.at([pair[0].travel, pair[1].travel], rates, command);
            for (i, (w, c)) in pose.wheels.iter().zip(pair).enumerate() {
                let f = &mut self.forces[b.left + i];
                f.arm = turn * (c.mount + w.hub);
                f.axis = turn * w.axis;
                f.tangent = turn * w.hub_rates[i];
                f.tilt = turn * w.tilt_rates[i];
                f.bend = turn * w.bend;
                f.struts = w.struts;
                let cross = turn * w.hub_rates[1 - i];
                let cross_tilt = turn * w.tilt_rates[1 - i];
                f.velocity = self.v
                    + self.w.cross(&f.arm)
                    + f.tangent * rates[i]
                    + cross * rates[1 - i]
                    + turn * (w.hub_steer_rate * steer_rate);
                f.rotation = self.w + f.tilt * rates[i] + cross_tilt * rates[1 - i] + f.axis * c.spin;
                b.cross[i] = cross;
                b.cross_tilt[i] = cross_tilt;
                b.strut_rates[i] = w.strut_rates;
            }
            b.arm = turn * (b.mount + pose.middle);
            b.tangents = pose.middle_rates.map(|r| turn * r);
            b.bend = turn * pose.middle_bend;
        }
    }

    /// Travels of a corner's axle, left and right.
    pub(super) fn travels(&self, c: &Corner) -> [f64; 2] {
        match c.guide {
            Guide::Beam(b) => [0, 1].map(|i| self.corners[self.beams[b].left + i].travel),
            _ => [c.travel; 2],
        }
    }

    /// Hub relative to the axle's reference point and direction of the axle in the chassis frame at travels of the
    /// axle's wheels and a steering command.
    pub(super) fn guided(&self, c: &Corner, travels: [f64; 2], command: f64) -> (V3, V3) {
        let i = c.side.index();
        match &c.guide {
            Guide::Table(table) | Guide::Mount(table) => {
                let p = table.at(travels[i], command);
                (p.hub, p.axis)
            }
            Guide::Beam(b) => {
                let w = self.beams[*b].kinematics.at(travels, [0.0; 2], command).wheels[i];
                (w.hub, w.axis)
            }
        }
    }
}
