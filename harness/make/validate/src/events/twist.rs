//! Wheels at different heights, and with different grip.

use crate::bench::Bench;
use crate::check::Expected;
use crate::event::{Event, LineKind, Outcome, Place, Plot, Vehicles};
use crate::grounds::{relief, split};
use crate::pace::{PARKED, controls};
use crate::rig::{Drive, largest};
use crate::statics::Statics;
use std::sync::Arc;
use vb_math::angle::degrees;
use vb_sim::{SimError, VehicleState, tyre::Tyre};
use vb_vehicle::powertrain::Differential;
use vb_world::World;

pub(super) const TWIST: Event = Event {
    name: "twist",
    title: "Twist: wheels on blocks",
    about: "At rest with a front wheel and the rear one diagonally across from it on blocks of 0.1, 0.2 and 0.3 m, with one \
            front wheel and with all left wheels on 0.2 m: loads, travels and roll compared with statics. The height at which the diagonal \
            lifts a wheel.",
    vehicles: Vehicles::Wheeled,
    place: Place::Rigid,
    run: twist,
};

/// Little enough that tyres are not held sideways as springs move them, which statics on vertical forces doesn't know.
const SLIPPERY: f64 = 0.02;
/// Time in which springs and tyres come to rest, s.
const SETTLE: f64 = 4.0;

/// Which wheels stand on blocks.
#[derive(Clone, Copy, PartialEq)]
enum Raised {
    Diagonal,
    One,
    Left,
}

impl Raised {
    fn label(self) -> &'static str {
        match self {
            Self::Diagonal => "diagonal",
            Self::One => "one wheel",
            Self::Left => "left side",
        }
    }

    /// Whether a wheel is among them: numbers from the front, left before right.
    fn has(self, wheel: usize, count: usize) -> bool {
        match self {
            Self::Diagonal => wheel == 0 || wheel == count - 1,
            Self::One => wheel == 0,
            Self::Left => wheel.is_multiple_of(2),
        }
    }

    /// Heights under the wheels.
    fn heights(self, bench: &Bench<'_>, height: f64) -> Vec<f64> {
        let count = bench.geometry.corners.len();
        (0..count).map(|i| if self.has(i, count) { height } else { 0.0 }).collect()
    }

    /// Full-size ground with blocks of a full-size height under them.
    fn ground(self, bench: &Bench<'_>, height: f64) -> Arc<World> {
        let g = &bench.geometry;
        let count = g.corners.len();
        let place = |i: usize| g.hub(i, g.rest[i], 0.0).x / bench.spec.scale;
        let between = |a: usize, b: usize| 0.5 * (place(a) + place(b));
        relief(14.0, 6.0, 0.1, SLIPPERY, |x, y| {
            let front = x > between(0, 2);
            let rear = x < between(count - 4, count - 2);
            let on = match self {
                Self::Diagonal => (front && y > 0.05) || (rear && y < -0.05),
                Self::One => front && y > 0.05,
                Self::Left => y > 0.05,
            };
            if on { height } else { 0.0 }
        })
    }

    fn rest(self, bench: &Bench<'_>, height: f64) -> Result<(VehicleState, Drive), SimError> {
        let case = format!("{}-{height:.3}m", self.label().replace(' ', "-"));
        let mut d = Drive::new(bench, &case, &self.ground(bench, height), 0.0, 0.0)?;
        d.hold(bench.pace.time(SETTLE), |_| PARKED)?;
        Ok((d.state(), d))
    }
}

fn twist(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let g = &bench.geometry;
    let Some(statics) = Statics::new(bench) else {
        o.note("An axle rotates about a pin, but the statics here assumes wheels on springs.");
        return Ok(o);
    };
    let mean = g.weight() / g.corners.len() as f64;
    let mut plot = Plot::new("Wheel loads over the height of diagonal blocks", "height, m", "load, N");
    let (mut ours, mut theory) = (vec![Vec::new(); g.corners.len()], vec![Vec::new(); g.corners.len()]);
    let cases = [
        (Raised::Diagonal, 0.1),
        (Raised::Diagonal, 0.2),
        (Raised::Diagonal, 0.3),
        (Raised::One, 0.2),
        (Raised::Left, 0.2),
    ];
    for (raised, full_size) in cases {
        let height = bench.pace.length(full_size);
        let label = match bench.spec.scale {
            1.0 => format!("{}, {full_size:.1} m", raised.label()),
            _ => format!("{}, {:.1} mm", raised.label(), 1e3 * height),
        };
        let (s, d) = raised.rest(bench, full_size)?;
        let Some(at) = statics.at(&raised.heights(bench, height)) else {
            o.note(format!("{label}: statics has no equilibrium"));
            continue;
        };
        let most =
            |off: &dyn Fn(usize) -> f64| (0..g.corners.len()).map(|i| off(i).abs()).fold(0.0, f64::max);
        o.expect(
            &format!("{label}: greatest deviation of a load over the mean load"),
            100.0 * most(&|i| s.wheels[i].load - at.loads[i]) / mean,
            "%",
            Expected::AtMost(5.0),
            "statics of springs, stops, bars and tyres",
        );
        o.expect(
            &format!("{label}: greatest deviation of a travel"),
            1e3 * most(&|i| s.wheels[i].deflection - at.travels[i]),
            "mm",
            Expected::AtMost(bench.pace.length(5.0)),
            "statics of springs, stops, bars and tyres",
        );
        let roll = format!("{label}: roll");
        o.figure(roll.clone(), degrees(s.roll_pitch_yaw().0), "°");
        // On two wheels alone it balances on the width of their treads, hard ones anywhere between their edges.
        if at.loads.iter().filter(|l| **l > 0.05 * mean).count() > 2 {
            let value = degrees(at.roll);
            let expected = Expected::Within { value, tolerance: 0.2 + 0.03 * value.abs() };
            o.theory(roll, expected, "statics of springs, stops, bars and tyres");
        }
        for ((c, w), line) in g.corners.iter().zip(&s.wheels).zip(&mut ours) {
            o.figure(format!("{label}: load {}", c.name), w.load, "N");
            if raised == Raised::Diagonal {
                line.push([height, w.load]);
            }
        }
        o.series.push(d.finish());
    }
    for k in 0..=30 {
        let height = bench.pace.length(0.01 * f64::from(k));
        if let Some(at) = statics.at(&Raised::Diagonal.heights(bench, height)) {
            (0..g.corners.len()).for_each(|i| theory[i].push([height, at.loads[i]]));
        }
    }
    for (i, (ours, theory)) in ours.into_iter().zip(theory).enumerate() {
        plot.line(LineKind::Ours, i, g.corners[i].name.clone(), ours);
        plot.line(LineKind::Theory, i, format!("{}, statics", g.corners[i].name), theory);
    }
    o.plots.push(plot);
    lifts(bench, &statics, &mut o)?;
    Ok(o)
}

/// The height of diagonal blocks at which a wheel lifts.
fn lifts(bench: &Bench<'_>, statics: &Statics<'_>, o: &mut Outcome) -> Result<(), SimError> {
    // A hundredth of the mean load, not none: what a wheel bears just before it lifts depends on the last millimetre.
    let light = 0.01 * bench.geometry.weight() / bench.geometry.corners.len() as f64;
    let least = |loads: &mut dyn Iterator<Item = f64>| loads.fold(f64::INFINITY, f64::min) > light;
    let most = 1.0;
    let expected = largest(0.0, most, 0.001, |full_size| {
        let at = statics.at(&Raised::Diagonal.heights(bench, bench.pace.length(full_size)));
        Ok(at.is_some_and(|a| least(&mut a.loads.into_iter())))
    })?;
    if expected >= most {
        o.note("Statics: a block of 1 m does not lift a wheel.");
        return Ok(());
    }
    let found = largest(0.5 * expected, 1.5 * expected, 0.01 * expected, |full_size| {
        let (s, _) = Raised::Diagonal.rest(bench, full_size)?;
        Ok(least(&mut s.wheels.iter().map(|w| w.load)))
    })?;
    o.expect(
        "diagonal: height at which a wheel lifts",
        bench.pace.length(found),
        "m",
        Expected::fraction(bench.pace.length(expected), 0.05),
        "statics of springs, stops, bars and tyres",
    );
    Ok(())
}

pub(super) const SPLIT_GRIP: Event = Event {
    name: "split-grip",
    title: "Pull with one wheel of each axle without grip",
    about: "Throttle 0.5 on level ground with μ 0.01 under the left wheels, practically without grip, and 0.9 under the right: the mean \
            pull from 1 s to 2 s compared with the torque that the differentials transmit. The same with throttle 1 and μ 0.1 on the left, and the torque of \
            the gripping wheels over that of the spinning wheels: the torque bias of the differentials.",
    vehicles: Vehicles::Wheeled,
    place: Place::Rigid,
    run: split_grip,
};

/// Friction under the left wheels as good as hanging, and that of ice, with the throttle that spins them: the label of the second is in
/// the names of its figures.
const LEFT: [(&str, f64, f64); 2] = [("", 0.01, 0.5), ("μ 0.1: ", 0.1, 1.0)];
/// Friction under the right wheels.
const RIGHT: f64 = 0.9;

fn split_grip(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    if bench.spec.tyre.coulomb_friction().is_none() {
        o.note("The friction of the tyre depends on slip: not run.");
        return Ok(o);
    }
    for (label, ice, throttle) in LEFT {
        pull(bench, &mut o, label, ice, throttle)?;
    }
    Ok(o)
}

fn pull(bench: &Bench<'_>, o: &mut Outcome, label: &str, ice: f64, throttle: f64) -> Result<(), SimError> {
    let (g, spec) = (&bench.geometry, bench.spec);
    let resistance = spec.tyre.rolling_resistance();
    let mut d = Drive::new(bench, &format!("split-{ice}"), &split(ice, RIGHT), 0.0, 0.0)?;
    let push = |_: &VehicleState| controls(0.0, throttle, 0.0);
    d.hold(bench.pace.time(1.0), push)?;
    let first = d.state();
    let (mut loads, mut count) = (vec![0.0; g.corners.len()], 0.0);
    let (mut slower, mut spun) = (true, true);
    d.run(bench.pace.time(1.0), push, |s| {
        count += 1.0;
        for (i, w) in s.wheels.iter().enumerate() {
            loads[i] += w.load;
            slower &= i % 2 == 0 || !spec.axles[i / 2].driven || s.wheels[i - 1].speed > w.speed;
            let rim = w.speed * g.corners[i].radius;
            spun &= i % 2 == 1 || !spec.axles[i / 2].driven || rim > 1.05 * s.velocity_body.x;
        }
        false
    })?;
    let last = d.state();
    let seconds = last.time - first.time;
    let along = |s: &VehicleState| s.velocity_body.x;
    let pull = g.mass * (along(&last) - along(&first)) / seconds;
    o.figure(format!("{label}pull"), pull, "N");
    o.series.push(d.finish());
    let rate = |i: usize| (last.wheels[i].speed - first.wheels[i].speed) / seconds;
    // Force beside that of the torques which the differentials pass, that force, and the torques of both sides.
    let (mut beside, mut passes, mut spinning, mut radii) = (0.0, 0.0, 0.0, 0.0);
    let mut driven = 0;
    for (a, axle) in spec.axles.iter().enumerate() {
        let [left, right] = [2 * a, 2 * a + 1];
        let load = |i: usize| loads[i] / count;
        let tyre = Tyre::new(spec.tyre_of(axle));
        // Rolling on a radius a third of the deflection below the free one, but for a hard tyre (Rill 2011, ch. 3).
        let soft = f64::from(u8::from(resistance > 0.0));
        let radius = |i: usize| g.corners[i].radius - soft * tyre.deflection(load(i)) / 3.0;
        let inertia = |i: usize| g.corners[i].spin_inertia * rate(i);
        let rolling = |i: usize| resistance * load(i) * radius(i);
        if !axle.driven {
            beside -= [left, right].map(|i| (rolling(i) + inertia(i)) / radius(i)).iter().sum::<f64>();
            continue;
        }
        let slides = ice * load(left);
        // Torque of the wheel that spins, and so of the one that grips.
        let free = inertia(left) + rolling(left) + slides * radius(left);
        let passed = match spec.powertrain.driveline.axles[driven].differential {
            Differential::Open {} => free,
            Differential::Clutch { torque } => free + 2.0 * torque,
            Differential::LimitedSlip { bias, preload } => bias * free + (bias + 1.0) * preload,
            Differential::Locked {} => f64::NAN,
        };
        driven += 1;
        beside += slides - (rolling(right) + inertia(right)) / radius(right);
        passes += passed / radius(right);
        spinning += free;
        radii += radius(right);
    }
    let expected = beside + passes;
    if bench.winds_up() {
        o.note(format!("{label}a locked differential transmits up to the grip limit."));
    } else if slower && spun {
        o.theory(
            format!("{label}pull"),
            Expected::Within { value: expected, tolerance: 0.05 * expected.abs() + 0.002 * g.weight() },
            "torque of the wheel that spins, and twice the clutch's or the bias' share, over the radius",
        );
        // Torque of the wheels with grip over that of those that spin, by the measured pull.
        let gripping = (pull - beside) * radii / f64::from(u32::try_from(driven).unwrap_or(1));
        o.figure(format!("{label}torque ratio"), gripping / spinning, "");
    } else {
        o.note(format!("{label}some wheels without grip do not spin, because the differentials hold."));
    }
    Ok(())
}
