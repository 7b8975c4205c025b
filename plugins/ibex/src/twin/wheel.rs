//! What wheels do: springs, tyres, and the torque that turns them.

use wide::f32x8;

use super::body::{Body, Push};
use super::shape::Shape;
use super::soil::sinks;
use super::vector::{V3, all, within};
use super::{Controls, Twin, WHEELS};

/// Points of a wheel's circumference: how far ahead of its centre and below it they are, in radii.
const RIM: [(f32, f32); 5] =
    [(0.0, 1.0), (0.45, 0.893_03), (-0.45, 0.893_03), (0.82, 0.572_36), (-0.82, 0.572_36)];
/// Slip stiffness along and across, per unit load, and relaxation lengths in radii: those of the HMMWV's tyre.
const SLIP: [f32; 2] = [17.8, 7.4];
const RELAXATION: [f32; 2] = [0.5, 1.0];
/// The part of the vehicle that a wheel's friction moves is a quarter of it.
const MOVED: f32 = 4.0;
/// Rolling resistance, per unit load.
const ROLLING: f32 = 0.015;
/// The compaction of soil resists with this times the load and the root of the sinkage in diameters: 3/((n + 1)(3 − n)) with Bekker's
/// exponent n = 1.1 (Bekker, "Introduction to Terrain-Vehicle Systems", 1969). Rear wheels follow in ruts, which have half of it.
const COMPACTION: [f32; 2] = [0.75, 0.4];
/// The speed below which resistances end, m/s at full scale.
const SLOW: f32 = 0.3;

/// A wheel.
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
    /// The friction of the ground under it.
    pub(super) friction: f32x8,
    /// The depth to which it sinks under its share of the weight, m.
    pub(super) depth: f32x8,
}

/// Where a wheel meets the ground.
pub(super) struct Meeting {
    /// How deep the ground is in the undeformed wheel, along its radius, m; 0 where it doesn't touch.
    pub(super) depth: f32x8,
    /// Sine of the angle by which the middle of the overlap is ahead of the lowest point.
    ahead: f32x8,
}

impl Twin {
    /// Where a wheel that is sunk so deep meets the ground. Its centre, and the directions ahead and up in its plane.
    pub(super) fn meet(&self, hub: V3, [ahead, up]: [V3; 2], sunk: f32x8) -> Meeting {
        let radius = self.shape.radius;
        let (mut depth, mut sum, mut lever) = (all(0.0), all(0.0), all(0.0));
        for (u, down) in RIM {
            let rim = hub + ahead * all(u * radius) + up * all(-down * radius);
            let over = self.ground.height(rim.x, rim.y) - sunk - rim.z;
            // A slope that the rim lies on is as far away along the radius as is the ground below times the cosine. A wheel that points
            // up touches nothing: then it is the hull that lies on the ground.
            let along = over.max(all(0.0)) * up.z.max(all(0.0)) * all(down);
            depth = depth.max(along);
            sum += along;
            lever += along * all(u);
        }
        Meeting { depth, ahead: lever / sum.max(all(1e-6)) }
    }

    /// What the engine, the differentials and the brakes do: torques of the wheels, and the most that each brake resists with, N m.
    pub(super) fn torques(&self, wheels: &[Wheel; WHEELS], c: &Controls) -> ([f32x8; WHEELS], f32x8) {
        let Shape { torque: [rest, rise, most], power, drag, brake, clutch, .. } = self.shape;
        let spins = wheels.map(|w| w.spin);
        let [front, rear] = [(spins[0] + spins[1]) * all(0.5), (spins[2] + spins[3]) * all(0.5)];
        let mean = (front + rear) * all(0.5);
        let speed = mean.abs();
        let full = (all(rest) + speed * all(rise)).min(all(most)).min(all(power) / speed.max(all(0.1)));
        let throttle = c.pedal.max(all(0.0));
        let closed = within(mean * all(drag), all(drag));
        let drive = (throttle * full * c.way - (all(1.0) - throttle) * closed) * all(0.25);
        // Differentials are open but for some friction, which is in full from a difference of 1 rad/s on.
        let slips = |difference: f32x8, torque: f32| within(difference * all(torque), all(torque));
        let axles = slips(rear - front, clutch[0]);
        let torques = std::array::from_fn(|i| {
            let from_axle = if i < 2 { axles } else { -axles };
            drive + from_axle + slips(spins[i ^ 1] - spins[i], clutch[1])
        });
        (torques, (-c.pedal).max(all(0.0)) * all(brake))
    }

    /// The forces of a wheel with this torque on the body, of which the wheel keeps what it remembers.
    pub(super) fn roll(
        &self,
        i: usize,
        w: &mut Wheel,
        body: &Body,
        ([ahead, axle], torque, brakes): ([V3; 2], f32x8, f32x8),
        (push, dt): (&mut Push, f32),
    ) {
        let shape = &self.shape;
        let (zero, one, h, r) = (all(0.0), all(1.0), all(dt), all(shape.radius));
        let rear = usize::from(i >= 2);
        let up = body.axes.up;
        let at = body.axes.out(shape.hub(i, w.travel));
        let Meeting { depth, ahead: sine } = self.meet(body.place + at, [ahead, up], w.sunk);
        let cosine = (one - sine * sine).sqrt();
        let normal = up * cosine + ahead * -sine;
        let along = ahead * cosine + up * sine;
        // The wheel has no mass: spring, damper and stops balance the tyre.
        let beyond = (w.travel - all(shape.stop)).max(zero) + (w.travel + all(shape.stop)).min(zero);
        let spring = all(shape.share[rear])
            + all(shape.spring[rear]) * (w.travel - all(shape.rest[rear]))
            + all(shape.stiff) * beyond;
        let stiffness = all(shape.spring[rear] + shape.damper[rear] / dt)
            + beyond.simd_eq(zero).select(zero, all(shape.stiff));
        let tyre = depth.simd_gt(zero).select(all(shape.tyre), zero);
        let change = (tyre * cosine * depth - spring) / (stiffness + tyre * cosine * cosine);
        let most = all(5.0 * super::GRAVITY * shape.mass);
        let load = (tyre * (depth - change * cosine)).max(zero).min(most);
        w.travel = within(w.travel + change, all(shape.travel));
        // The tread: a brush with relaxation (Pacejka, "Tire and Vehicle Dynamics", 2012, eq. 3.11 and 7.8), implicit in what its own
        // force does to wheel and vehicle.
        let arm = at + normal * (depth - r);
        let v = body.velocity + body.turning.cross(arm);
        let (forward, aside) = (v.dot(along), v.dot(axle));
        let inertia = all(1.0 / shape.spin);
        let torque = torque - within(w.spin * all(shape.spin / dt) + torque, brakes);
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
        let [drive, side] = adhesion.map(|a| a * grip);
        w.spin += h * (torque - r * drive) * inertia;
        let compaction = all(COMPACTION[rear]) * (w.sunk * all(0.5 / shape.radius)).max(zero).sqrt();
        let resistance = (compaction + all(ROLLING)) * load;
        let against = resistance * within(forward * all(1.0 / (SLOW * shape.root)), one);
        w.sunk = sinks(w, load * all(1.0 / shape.share[rear]), dt / shape.root);
        push.add(arm, normal * load + along * (drive - against) + axle * side);
    }
}
