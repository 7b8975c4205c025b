//! Skid steering on wheels: turning in place, the effective track, and what turning costs.

use crate::bench::Bench;
use crate::check::Expected;
use crate::event::{Event, LineKind, Outcome, Place, Plot, Vehicles};
use crate::grounds::flat;
use crate::pace::controls;
use crate::rig::Drive;
use vb_math::hypot;
use vb_sim::{SimError, VehicleState};
use vb_vehicle::VehicleSpec;
use vb_vehicle::skid::Skid;

/// Time to come to a steady turn, and time over which it is measured, s.
const SETTLE: f64 = 3.0;
const MEASURED: f64 = 2.0;

/// A steady turn.
#[derive(Default)]
struct Turn {
    /// Yaw rate, rad/s, positive to the left.
    yaw_rate: f64,
    /// Longitudinal velocity of the reference point in the body frame, m/s.
    forward: f64,
    /// Circumferential speeds of the left and the right wheels, m/s.
    sides: [f64; 2],
    /// Power of the motors, W.
    power: f64,
    /// Vertical load of each wheel, N.
    loads: Vec<f64>,
}

impl Turn {
    /// The distance of the sides at which wheels that roll without slip would turn the vehicle as fast, m.
    fn effective_track(&self) -> f64 {
        (self.sides[1] - self.sides[0]) / self.yaw_rate
    }

    /// The yaw rate over that of wheels that roll without slip on this track (m).
    fn ratio(&self, track: f64) -> f64 {
        track / self.effective_track()
    }

    /// The power that slip takes from wheels that slide everywhere at this friction, W: Σ μ N |slip velocity|.
    fn slip_power(&self, bench: &Bench<'_>, friction: f64) -> f64 {
        let g = &bench.geometry;
        let of = |i: usize| {
            let hub = g.hub(i, 0.0, 0.0);
            let along = self.forward - self.yaw_rate * hub.y - self.sides[i % 2];
            friction * self.loads[i] * hypot(along, self.yaw_rate * hub.x)
        };
        (0..g.corners.len()).map(of).sum()
    }

    /// The power that rolling and the friction of the motors take, W.
    fn rolling_power(&self, spec: &VehicleSpec) -> f64 {
        let (tyre, p) = (&spec.tyre, &spec.powertrain);
        let rolling: f64 = self
            .loads
            .iter()
            .enumerate()
            .map(|(i, load)| tyre.rolling_resistance() * load * self.sides[i % 2].abs())
            .sum();
        let gearing = 1.0 / (p.driveline.axles[0].final_drive * p.gearbox.ratios[0]);
        let friction = (-p.engine.torque(0.0, 0.0)).max(0.0);
        let motors: f64 = self.sides.iter().map(|v| 0.5 * friction * gearing * v.abs() / tyre.radius()).sum();
        rolling + motors
    }
}

/// Drives `d` with controls that depend on the state, and measures the turn that it comes to.
fn steady(
    bench: &Bench<'_>,
    mut d: Drive,
    control: impl Fn(&VehicleState) -> vb_sim::Controls,
    o: &mut Outcome,
) -> Result<Turn, SimError> {
    d.hold(SETTLE, &control)?;
    let mut turn = Turn { loads: vec![0.0; bench.geometry.corners.len()], ..Turn::default() };
    let mut count = 0.0;
    let steps = (MEASURED / bench.options.step).round() as u64;
    for _ in 0..steps {
        let s = d.state();
        d.sim().advance(control(&s), 1)?;
        count += 1.0;
        turn.yaw_rate += s.angular_velocity_body.z;
        turn.forward += s.velocity_body.x;
        turn.power += d.sim().drive().power;
        for (i, w) in s.wheels.iter().enumerate() {
            turn.sides[i % 2] += w.speed * bench.geometry.corners[i].radius / (0.5 * s.wheels.len() as f64);
            turn.loads[i] += w.load;
        }
    }
    for value in [&mut turn.yaw_rate, &mut turn.forward, &mut turn.power]
        .into_iter()
        .chain(&mut turn.sides)
        .chain(&mut turn.loads)
    {
        *value /= count;
    }
    o.series.push(d.finish());
    Ok(turn)
}

/// The effective track over the track of a vehicle that turns in place on wheels that all slide, each with a friction force
/// against its slip velocity: the speed of the sides at which the moments about the middle are in balance.
fn sliding(places: &[[f64; 2]], loads: &[f64]) -> f64 {
    let outer = places.iter().map(|p| p[1].abs()).fold(0.0, f64::max);
    // Moment of the ground at a yaw rate of 1 rad/s and a speed of the sides, m/s: it grows with the speed.
    let moment = |speed: f64| -> f64 {
        let of = |([x, y], load): (&[f64; 2], &f64)| {
            let along = speed - y.abs();
            load * (along * y.abs() - x * x) / hypot(along, *x).max(1e-12)
        };
        places.iter().zip(loads).map(of).sum()
    };
    let (mut low, mut high) = (0.0, 100.0 * outer);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if moment(middle) < 0.0 { low = middle } else { high = middle }
    }
    low / outer
}

/// The wheels' places relative to the middle, m.
fn places(bench: &Bench<'_>) -> Vec<[f64; 2]> {
    let g = &bench.geometry;
    (0..g.corners.len()).map(|i| g.hub(i, 0.0, 0.0)).map(|p| [p.x, p.y]).collect()
}

pub(super) const IN_PLACE: Event = Event {
    name: "turn-in-place",
    title: "Turning in place",
    about: "Full command without throttle on level ground at μ 0.2 to 0.8, to both sides: the yaw rate over that of wheels without \
            slip, and the power of the motors. And with 0.6 and 1.4 of the wheelbase at μ 0.6: the effective track over \
            the wheelbase.",
    vehicles: Vehicles::SkidSteered,
    place: Place::Rigid,
    run: in_place,
};

fn in_place(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    if matches!(bench.spec.skid, Some(Skid::Speed { at_rest, .. }) if at_rest == 0.0) {
        o.note("It turns only in motion (skid.at_rest is 0): not run.");
        return Ok(o);
    }
    let track = bench.geometry.track();
    let mut plot =
        Plot::new("Yaw rate over that without slip", "friction", "yaw rate over that without slip");
    let (mut ours, mut theory) = (Vec::new(), Vec::new());
    for (friction, steering) in [(0.2, 1.0), (0.4, 1.0), (0.6, 1.0), (0.6, -1.0), (0.8, 1.0)] {
        let side = if steering > 0.0 { "left" } else { "right" };
        let label = format!("μ {friction:.1}, {side}");
        let d = Drive::new(bench, &format!("{side}-{friction:.1}"), &flat(friction), 0.0, 0.0)?;
        let turn = steady(bench, d, |_| controls(steering, 0.0, 0.0), &mut o)?;
        o.expect(
            &format!("{label}: yaw rate"),
            turn.yaw_rate * steering,
            "rad/s",
            Expected::AtLeast(f64::MIN_POSITIVE),
            "it turns to the side of the command",
        );
        o.expect(
            &format!("{label}: yaw rate over that without slip"),
            turn.ratio(track),
            "",
            Expected::Between(0.0, 1.0),
            "slip only reduces the kinematic yaw rate, (v_right - v_left) / track",
        );
        let name = format!("{label}: effective track over track");
        let expected = sliding(&places(bench), &turn.loads);
        o.expect(
            &name,
            turn.effective_track() / track,
            "",
            Expected::fraction(expected, 0.15),
            "Coulomb friction against the slip of each wheel, moments in balance: 1 + (wheelbase / track)² on two axles, \
             whatever the friction (as Mandow et al. 2007 define the effective track)",
        );
        o.figure(format!("{label}: power of the motors"), turn.power, "W");
        o.theory(
            format!("{label}: power of the motors"),
            Expected::fraction(
                turn.slip_power(bench, bench.grip(friction)) + turn.rolling_power(bench.spec),
                0.15,
            ),
            "Σ μ N |slip| (Morales et al. 2009), with rolling resistance and the friction of the motors",
        );
        if steering > 0.0 {
            ours.push([friction, turn.ratio(track)]);
            theory.push([friction, 1.0 / expected]);
        }
    }
    plot.ours("simulated", ours);
    plot.line(LineKind::Theory, 0, "all wheels slide", theory);
    o.plots.push(plot);
    over_the_wheelbase(bench, &mut o)?;
    Ok(o)
}

/// The effective track of the vehicle with other wheelbases.
fn over_the_wheelbase(bench: &Bench<'_>, o: &mut Outcome) -> Result<(), SimError> {
    const FRICTION: f64 = 0.6;
    let track = bench.geometry.track();
    let mut plot =
        Plot::new("Effective track over the wheelbase", "wheelbase over track", "effective track over track");
    let (mut ours, mut theory) = (Vec::new(), Vec::new());
    for factor in [0.6, 1.0, 1.4] {
        let mut spec = bench.spec.clone();
        spec.axles.iter_mut().for_each(|a| a.position[0] *= factor);
        let other = Bench::new(&spec, bench.soils, bench.options.step)?;
        let d = Drive::new(&other, &format!("wheelbase-{factor:.1}"), &flat(FRICTION), 0.0, 0.0)?;
        let turn = steady(&other, d, |_| controls(1.0, 0.0, 0.0), o)?;
        let (base, expected) = (other.geometry.wheelbase() / track, sliding(&places(&other), &turn.loads));
        o.expect(
            &format!("{factor:.1} of the wheelbase: effective track over track"),
            turn.effective_track() / track,
            "",
            Expected::fraction(expected, 0.15),
            "Coulomb friction against the slip of each wheel, moments in balance",
        );
        ours.push([base, turn.effective_track() / track]);
        theory.push([base, expected]);
    }
    plot.ours("simulated", ours);
    plot.line(LineKind::Theory, 0, "all wheels slide", theory);
    o.plots.push(plot);
    Ok(())
}

pub(super) const TURNING: Event = Event {
    name: "skid-turning",
    title: "Turning by the speeds of the sides",
    about: "Commands of 0.1 to 1 at half of the top speed on level ground at μ 0.6, and three of them backwards: radius, effective \
            track, and the power of the motors, which increases with curvature.",
    vehicles: Vehicles::SkidSteered,
    place: Place::Rigid,
    run: turning,
};

fn turning(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    const FRICTION: f64 = 0.6;
    let mut o = Outcome::default();
    let (track, pace) = (bench.geometry.track(), bench.pace);
    let target = 0.5 * bench.spec.max_speed / pace.speed(1.0);
    let mut tracks = Plot::new("Effective track over the command", "command", "effective track over track");
    let mut powers = Plot::new("Power of the motors over the command", "command", "power, W");
    let (mut width, mut power) = (Vec::new(), Vec::new());
    let cases =
        [0.0, 0.1, 0.25, 0.5, 1.0].map(|s| (false, s)).into_iter().chain([0.25, 0.5, 1.0].map(|s| (true, s)));
    for (back, steering) in cases {
        let way = if back { "backwards, " } else { "" };
        let case = format!("{}steering-{steering}", if back { "backwards-" } else { "" });
        let label = format!("{way}steering {steering}");
        let d = Drive::new(bench, &case, &flat(FRICTION), 0.0, 0.0)?;
        let hold = |s: &VehicleState| match back {
            true => pace.hold_speed_back(s, target, steering),
            false => pace.hold_speed(s, target, steering),
        };
        let turn = steady(bench, d, hold, &mut o)?;
        o.figure(format!("{label}: power of the motors"), turn.power, "W");
        if !back {
            power.push([steering, turn.power]);
        }
        if steering == 0.0 {
            continue;
        }
        o.figure(format!("{label}: radius"), turn.forward / turn.yaw_rate, "m");
        o.theory(
            format!("{label}: radius"),
            Expected::AtLeast(f64::MIN_POSITIVE),
            "it turns to the same side both ways",
        );
        o.expect(
            &format!("{label}: effective track over track"),
            turn.effective_track() / track,
            "",
            Expected::Between(1.0, 1.15 * sliding(&places(bench), &turn.loads)),
            "between wheels that roll without slip and wheels that all slide, which turn in place",
        );
        if !back {
            width.push([steering, turn.effective_track() / track]);
        }
    }
    let grows = power.windows(2).all(|w| w[1][1] >= w[0][1]);
    o.expect(
        "power grows with the command (1: it does)",
        f64::from(u8::from(grows)),
        "",
        Expected::AtLeast(1.0),
        "tighter turns slip more (Morales et al. 2009; Dogru and Marques 2018)",
    );
    tracks.ours("simulated", width);
    powers.ours("simulated", power);
    o.plots.extend([tracks, powers]);
    Ok(o)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn on_two_axles_the_sliding_effective_track_is_in_closed_form() {
        for (a, b) in [(0.256, 0.2775), (0.131, 0.1878), (0.457, 0.568)] {
            let places = [[a, b], [a, -b], [-a, b], [-a, -b]];
            let found = sliding(&places, &[100.0; 4]);
            assert!((found - (1.0 + (a / b) * (a / b))).abs() < 1e-9, "{found}");
        }
        // Middle wheels neither slide aside nor resist: those in front and behind alone would make it 1 + (a/b)².
        let six = [[0.3, 0.3], [0.3, -0.3], [0.0, 0.3], [0.0, -0.3], [-0.3, 0.3], [-0.3, -0.3]];
        let found = sliding(&six, &[100.0; 6]);
        assert!(found > 1.0 && found < 2.0, "{found}");
    }
}
