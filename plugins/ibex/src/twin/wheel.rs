//! What wheels do: springs and tyres.

use wide::f32x8;

use super::body::{Body, Push};
use super::contact::{Contact, Frame};
use super::shape::Shape;
use super::soil::sinks;
use super::vector::{V3, all, within};
use super::{GRAVITY, Twin};

/// Slip stiffness along and across, per unit load, and relaxation lengths in radii: those of the HMMWV's tyre.
const SLIP: [f32; 2] = [17.8, 7.4];
const RELAXATION: [f32; 2] = [0.5, 1.0];
/// The part of the vehicle that a wheel's friction moves is a quarter of it.
const MOVED: f32 = 4.0;
/// How far a contact lies beside the wheel's middle at most, in radii: the radius of gyration of the HMMWV's tread across.
const STRIP: f32 = 0.157;
/// How far the tread of the front and of the rear wheels moves outwards as a wheel rises, per travel. It turns about the point where the
/// lines through the HMMWV's wishbones meet: so rough ground pushes wheels aside, and forces across press on springs.
const SCRUB: [f32; 2] = [0.34, 0.44];
/// Weights of the vehicle that a wheel bears at most.
const MOST: f32 = 5.0;
/// Rolling resistance, per unit load.
const ROLLING: f32 = 0.015;
/// Rear wheels follow in ruts, which resist with this part of what the front wheels overcome.
const RUTS: [f32; 2] = [1.0, 0.53];
/// The speed below which resistances end, m/s at full scale.
const SLOW: f32 = 0.3;

#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Wheel {
    /// The suspension travel from the design position, m, positive in compression.
    pub(super) travel: f32x8,
    /// rad/s.
    pub(super) spin: f32x8,
    /// How deep it has sunk into soil, m.
    pub(super) sunk: f32x8,
    /// How far the tread is dragged over the ground, along and across, m.
    pub(super) drag: [f32x8; 2],
    /// The force on the tread to the left, N.
    pub(super) side: f32x8,
    /// The friction of the ground under it.
    pub(super) friction: f32x8,
    /// The depth to which it sinks under its share of the weight, m.
    pub(super) depth: f32x8,
    /// What resists as that ground is compacted, over the load and the root of the sinkage in diameters.
    pub(super) compaction: f32x8,
}

/// What a wheel is given in a step.
pub(super) struct Given {
    /// Ahead and to the left.
    pub(super) directions: [V3; 2],
    /// N m.
    pub(super) torque: f32x8,
    /// The most that the brake resists with, N m.
    pub(super) brakes: f32x8,
    /// Whether the contact is looked up anew. Else it is where the motion has brought it since.
    pub(super) looks: bool,
}

impl Twin {
    /// The forces of a wheel on the body; the wheel keeps what it remembers. By how much it spins up if nothing turns with it, rad/s.
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

        // Ground that is inclined along the axle presses on the tread's side.
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

    /// The load of a wheel whose tyre is deflected so deep (m), and by how much its travel changes. The wheel has no mass: spring, damper
    /// and stops balance the tyre, and what presses on them besides (N).
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
        // The damper does no more than the spring, so that contacts begin and end without a jump.
        let springs = elastic * (depth - change * cosine).max(zero);
        let resists = damping * (leaves + change * cosine * all(1.0 / dt));
        let load = (springs - within(resists, springs)).min(all(MOST * GRAVITY * mass));
        (load, changed)
    }

    /// The forces of the tread along and across, N, where it moves over the ground with these speeds (m/s): a brush with relaxation
    /// (Pacejka, "Tire and Vehicle Dynamics", 2012, eq. 3.11 and 7.8), implicit in what its own force does to wheel and vehicle.
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
