//! Wheels: springs and tyres.

use wide::f32x8;

use super::body::{Body, Push};
use super::contact::{Contact, Frame};
use super::shape::Shape;
use super::soil::sinks;
use super::vector::{V3, all, within};
use super::{GRAVITY, Twin};

/// Longitudinal and lateral slip stiffness per unit load, and relaxation lengths in radii, of the HMMWV's tyre.
const SLIP: [f32; 2] = [17.8, 7.4];
const RELAXATION: [f32; 2] = [0.5, 1.0];
/// Ratio of vehicle mass to the mass that the friction of one wheel moves.
const MOVED: f32 = 4.0;
/// Maximum lateral offset of a contact from the wheel's centre plane, in radii: the radius of gyration of the HMMWV's
/// tread width.
const STRIP: f32 = 0.157;
/// Lateral tread displacement of the front and rear wheels per suspension travel. The tread rotates about the instant
/// centre of the HMMWV's wishbones: rough terrain pushes wheels sideways, and lateral forces load springs.
const SCRUB: [f32; 2] = [0.34, 0.44];
/// Maximum load of a wheel, in vehicle weights.
const MOST: f32 = 5.0;
/// Rolling resistance, per unit load.
const ROLLING: f32 = 0.015;
/// Resistance of the front wheels, and that of the rear wheels in their ruts relative to it.
const RUTS: [f32; 2] = [1.0, 0.53];
/// Speed below which resistances fade out, m/s at full scale.
const SLOW: f32 = 0.3;

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Wheel {
    /// The suspension travel from the design position, m, positive in compression.
    pub(super) travel: f32x8,
    /// Angular velocity, rad/s.
    pub(super) spin: f32x8,
    /// Sinkage in soil, m.
    pub(super) sunk: f32x8,
    /// Deflection of the tread, longitudinal and lateral, m.
    pub(super) drag: [f32x8; 2],
    /// Lateral force on the tread, positive to the left, N.
    pub(super) side: f32x8,
    /// Friction coefficient of the terrain under it.
    pub(super) friction: f32x8,
    /// Sinkage under its static load, m.
    pub(super) depth: f32x8,
    /// Compaction resistance over load and root of the sinkage in diameters.
    pub(super) compaction: f32x8,
}

/// Inputs of a wheel in a step.
pub(super) struct Given {
    /// Forward and left directions.
    pub(super) directions: [V3; 2],
    /// Drive torque, N m.
    pub(super) torque: f32x8,
    /// Maximum brake torque, N m.
    pub(super) brakes: f32x8,
    /// Whether the contact is searched again; otherwise it is extrapolated from the motion.
    pub(super) looks: bool,
}

impl Twin {
    /// Adds the forces of a wheel to the body, and updates the wheel. Returns the change of spin without connected
    /// shafts, rad/s.
    pub(super) fn roll(
        &self,
        (i, w): (usize, &mut Wheel),
        contact: &mut Contact,
        body: &Body,
        given: &Given,
        (push, dt): (&mut Push, f32),
    ) -> f32x8 {
        let shape = &self.shape;
        let (zero, one, r) = (all(0.0), all(1.0), all(shape.radius));
        let rear = usize::from(i >= 2);
        let outward = all(if i.is_multiple_of(2) { SCRUB[rear] } else { -SCRUB[rear] });
        let ([ahead, axle], up) = (given.directions, body.axes.up);
        let at = body.axes.out(shape.hub(i, w.travel));
        let directions = [ahead, up, axle];
        if given.looks {
            *contact = self.meet(body.place + at, directions, w.sunk);
        }
        let frame = Frame::new(contact, directions);
        let leaves = (body.velocity + body.turning.cross(at)).dot(frame.normal);
        if !given.looks {
            contact.depth -= all(dt) * leaves;
        }
        let pressed = (contact.depth.max(zero), frame.cosine, leaves);
        let (load, change) = self.bear(rear, w, pressed, outward * w.side, dt);
        contact.depth -= change * frame.cosine;

        // Terrain that is inclined along the axle presses on the side of the tread.
        let beside = all(STRIP * STRIP) * contact.aside * r / (contact.depth / r).max(all(1e-4));
        let beside = within(beside, all(STRIP) * r);
        let arm = at + frame.radial * (contact.depth.max(zero) - r) + axle * beside;
        let v = body.velocity + body.turning.cross(arm);
        let (forward, aside) = (v.dot(frame.along), v.dot(frame.across) + outward * change * all(1.0 / dt));
        let torque = given.torque - within(w.spin * all(shape.spin / dt) + given.torque, given.brakes);
        let [drive, side] = self.tread(w, load, [forward, aside], torque, dt);
        w.side = side;

        let compaction = w.compaction * all(RUTS[rear]) * (w.sunk * all(0.5 / shape.radius)).max(zero).sqrt();
        let resistance = (compaction + all(ROLLING)) * load;
        let against = resistance * within(forward * all(1.0 / (SLOW * shape.root)), one);
        let sunk = sinks(w, load * all(1.0 / shape.share[rear]), dt / shape.root);
        contact.depth -= sunk - w.sunk;
        w.sunk = sunk;
        push.add(arm, frame.normal * load + frame.along * (drive - against) + frame.across * side);
        all(dt / shape.spin) * (torque - r * drive)
    }

    /// Load of a wheel at this tyre deflection (m), and change of its travel. The wheel is massless: spring, damper and
    /// stops balance the tyre and the additional force (N).
    fn bear(
        &self,
        rear: usize,
        w: &mut Wheel,
        (depth, cosine, leaves): (f32x8, f32x8, f32x8),
        besides: f32x8,
        dt: f32,
    ) -> (f32x8, f32x8) {
        let Shape { share, spring, damper, rest, stop, stiff, travel, tyre, tyre_damper, mass, .. } =
            self.shape;
        let zero = all(0.0);
        let beyond = (w.travel - all(stop)).max(zero) + (w.travel + all(stop)).min(zero);
        let sprung =
            all(share[rear]) + all(spring[rear]) * (w.travel - all(rest[rear])) + all(stiff) * beyond;
        let touches = depth.simd_gt(zero);
        let [elastic, damping] = [tyre, tyre_damper].map(|of| touches.select(all(of), zero));
        let hard = elastic + damping * all(1.0 / dt);
        let pressed = (elastic * depth - damping * leaves) * cosine - sprung + besides;
        let damper = pressed.simd_gt(zero).select(all(damper[rear][0] / dt), all(damper[rear][1] / dt));
        let stiffness = all(spring[rear]) + damper + beyond.simd_eq(zero).select(zero, all(stiff));
        let change = pressed / (stiffness + hard * cosine * cosine);
        let after = within(w.travel + change, all(travel));
        let changed = after - w.travel;
        w.travel = after;
        // The damper force does not exceed the spring force, so that contacts begin and end continuously.
        let springs = elastic * (depth - change * cosine).max(zero);
        let resists = damping * (leaves + change * cosine * all(1.0 / dt));
        let load = (springs - within(resists, springs)).min(all(MOST * GRAVITY * mass));
        (load, changed)
    }

    /// Longitudinal and lateral tread forces, N, at these sliding velocities (m/s): a brush model with relaxation
    /// (Pacejka, "Tire and Vehicle Dynamics", 2012, eq. 3.11 and 7.8), implicit in the response of wheel and vehicle to
    /// the force itself.
    fn tread(
        &self,
        w: &mut Wheel,
        load: f32x8,
        [forward, aside]: [f32x8; 2],
        torque: f32x8,
        dt: f32,
    ) -> [f32x8; 2] {
        let shape = &self.shape;
        let (zero, one, h, r) = (all(0.0), all(1.0), all(dt), all(shape.radius));
        let inertia = all(1.0 / shape.spin);
        let rolling = w.spin * r;
        let slip = [rolling + h * r * torque * inertia - forward, -aside];
        let light = all(MOVED / shape.mass);
        let moves = [r * r * inertia + light, light];
        let mut adhesion = [zero; 2];
        for k in 0..2 {
            let length = RELAXATION[k] * shape.radius;
            let stiffness = load * all(SLIP[k] / length);
            let kept = one / (one + h * rolling.abs() * all(1.0 / length));
            w.drag[k] = kept * (w.drag[k] + h * slip[k]) / (one + kept * h * h * moves[k] * stiffness);
            adhesion[k] = stiffness * w.drag[k];
        }
        let limit = w.friction * load + all(1e-3);
        let part = (adhesion[0] * adhesion[0] + adhesion[1] * adhesion[1]).sqrt() / limit;
        let slides = part.simd_gt(all(3.0));
        let kept = slides.select(all(3.0) / part, one);
        w.drag = w.drag.map(|d| d * kept);
        let share = one - part * (all(1.0 / 3.0) - part * all(1.0 / 27.0));
        let grip = slides.select(one / part, share);
        adhesion.map(|a| a * grip)
    }
}
