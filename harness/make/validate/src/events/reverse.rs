//! Backwards, and from forward to backwards.

use super::grades::friction_bound;
use crate::bench::Bench;
use crate::check::Expected;
use crate::event::{Event, Outcome, Place, Plot, Vehicles};
use crate::grounds::{flat, plane};
use crate::pace::{PARKED, controls, reverse, speed};
use crate::rig::{Drive, SAMPLE, largest};
use crate::traction::Backwards;
use std::f64::consts::PI;
use vb_math::angle::{degrees, radians};
use vb_sim::{Controls, Gear, SimError, VehicleState};
use vb_vehicle::GRAVITY;
use vb_vehicle::powertrain::Differential;

/// Said of a vehicle of which none of these events says anything.
const NONE: &str = "The vehicle has no reverse gear: not run.";

pub(super) const SPEED: Event = Event {
    name: "reverse-speed",
    title: "Top speed in reverse",
    about: "Full throttle in reverse on level ground at μ 0.9 with line control, 30 s: the speed, and the speed of the engine through \
            the reverse gear.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: top_speed,
};

fn top_speed(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let Some(theory) = Backwards::new(bench) else {
        o.note(NONE);
        return Ok(o);
    };
    let mut d = Drive::new(bench, "full-throttle", &flat(0.9), 0.0, PI)?;
    d.hold(30.0, |s| reverse(bench.pace.hold_line_back(s), 1.0, 0.0))?;
    let s = d.state();
    o.expect(
        "speed after 30 s",
        -s.velocity_body.x,
        "m/s",
        Expected::fraction(theory.top_speed(), 0.02),
        "balance of the engine's maps through the reverse gear and rolling resistance",
    );
    if bench.spec.powertrain.converter.is_none() {
        let turning = theory.input(-s.velocity_body.x);
        o.expect(
            "engine speed",
            s.engine_speed,
            "rad/s",
            Expected::fraction(turning, 0.01),
            "v / (reverse ratio · final drive · rolling radius), a third of the deflection below the free one (Rill 2011, ch. 3)",
        );
    }
    let series = d.finish();
    let mut plot = Plot::new("Speed after a throttle step in reverse", "t, s", "speed, m/s");
    plot.ours("throttle 1.0, μ 0.9", series.pairs("t", "vx"));
    o.plots.push(plot);
    o.series.push(series);
    Ok(o)
}

pub(super) const GRADE: Event = Event {
    name: "reverse-grade",
    title: "Steepest grade in reverse",
    about: "Rear uphill at μ 0.9. The throttle at which the force balance just allows a start on 12°, for 3 s against the \
            brakes and then without: the steepest plane on which it starts uphill. And full throttle for 12 s after 3 s with \
            brakes: the steepest plane on which it covers 5 m and still climbs at the end.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: grade,
};

/// The grade for which the throttle is chosen, °: wheels grip on it, and engines behind a converter turn faster than they idle.
const CHOSEN: f64 = 12.0;

fn grade(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let Some(theory) = Backwards::new(bench) else {
        o.note(NONE);
        return Ok(o);
    };
    let (friction, pace) = (0.9, bench.pace);
    let steer = |s: &VehicleState| pace.hold_line_back(s);
    let throttle = theory.throttle_on(radians(CHOSEN));
    o.figure(format!("throttle that starts it on {CHOSEN}° by the balance of forces"), throttle, "");
    let mut best = None;
    let limit = largest(CHOSEN - 8.0, CHOSEN + 8.0, 0.05, |slope| {
        let ground = plane(radians(slope), friction);
        let mut d = Drive::new(bench, &format!("start-{slope:.2}"), &ground, 0.0, PI)?;
        d.hold(3.0, |s| reverse(steer(s), throttle, 1.0))?;
        d.hold(3.0, |s| reverse(steer(s), throttle, 0.0))?;
        let up = d.state().velocity_body.x < -pace.speed(0.02);
        if up {
            best = Some(d.finish());
        }
        Ok(up)
    })?;
    // The resistance of tyres grows from none at rest to all of it at 0.1 m/s, which decides whether it starts to creep.
    let (sin, cos) = vb_math::sin_cos(radians(CHOSEN));
    let creeping = match bench.spec.tracks {
        None => degrees(vb_math::asin(sin + theory.rolling(0.0) * cos)),
        Some(_) => CHOSEN,
    };
    o.expect(
        &format!("steepest start at the throttle for {CHOSEN}°"),
        limit,
        "°",
        Expected::Between(CHOSEN - 0.5, creeping + 0.5),
        "T(0, throttle) / (ratios · radius) = W (sin + f cos), the converter at stall; without f of tyres at rest; and 0.5°",
    );
    o.series.extend(best.take());
    let mut plot = Plot::new("Speed on the steepest grade climbed in reverse", "t, s", "speed, m/s");
    let name = format!("μ {friction:.1}: steepest grade");
    let limit = largest(2.0, 46.0, 0.25, |slope| {
        let angle = radians(slope);
        let mut d = Drive::new(bench, &format!("full-{slope:.2}"), &plane(angle, friction), 0.0, PI)?;
        d.hold(3.0, |s| reverse(steer(s), 0.0, 1.0))?;
        let along = |s: &VehicleState| s.position.x / vb_math::cos(angle);
        let from = along(&d.state());
        let far = pace.length(150.0);
        d.run(pace.time(12.0), |s| reverse(steer(s), 1.0, 0.0), |s| along(s) - from >= far)?;
        let s = d.state();
        let climbed =
            along(&s) - from > pace.length(5.0) && (s.attitude * s.velocity_body).x > pace.speed(0.3);
        if climbed {
            best = Some(d.finish());
        }
        Ok(climbed)
    })?;
    o.figure(name.clone(), limit, "°");
    friction_bound(&mut o, name, friction);
    if let Some(series) = best {
        plot.ours(format!("μ {friction:.1}, {limit:.1}°"), series.pairs("t", "vx"));
        o.series.push(series);
    }
    o.plots.push(plot);
    Ok(o)
}

pub(super) const TURNING: Event = Event {
    name: "reverse-turning",
    title: "Turning backwards",
    about: "Half and full lock to the left at 1 m/s, forwards and backwards: radius of the reference point, positive to the left.",
    vehicles: Vehicles::Steered,
    place: Place::Rigid,
    run: turning,
};

fn turning(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    if Backwards::new(bench).is_none() {
        o.note(NONE);
        return Ok(o);
    }
    let pace = bench.pace;
    let mut plot = Plot::map("Circles forwards and backwards", "x, m", "y, m");
    for steering in [0.5, 1.0] {
        let mut circle = |way: &str, hold: &dyn Fn(&VehicleState) -> Controls| -> Result<f64, SimError> {
            let mut d = Drive::new(bench, &format!("{way}-{steering}"), &flat(0.9), 0.0, 0.0)?;
            d.hold(10.0, hold)?;
            let (mut path, mut heading) = (0.0, 0.0);
            d.run(10.0, hold, |s| {
                path += speed(s).copysign(s.velocity_body.x);
                heading += s.angular_velocity_body.z;
                false
            })?;
            let series = d.finish();
            plot.ours(format!("{way}, steering {steering}"), series.pairs("x", "y"));
            o.series.push(series);
            Ok(path / heading)
        };
        let ahead = circle("forwards", &|s| pace.hold_speed(s, 1.0, steering))?;
        let back = circle("backwards", &|s| pace.hold_speed_back(s, 1.0, steering))?;
        o.figure(format!("steering {steering}: radius forwards"), ahead, "m");
        // Wheels, or axles, that turn alike slip and resist the turn. The steered axle pushes sideways against that, which
        // loads its outer wheel forwards and its inner one backwards, and those point to different centres.
        let centre_locked = bench.spec.powertrain.driveline.centre == Differential::Locked {};
        let (expected, source) = if bench.winds_up() || centre_locked {
            (Expected::AtLeast(f64::MIN_POSITIVE), "it turns to the same side in both directions")
        } else {
            (
                Expected::fraction(ahead, 0.03),
                "wheels without slip roll about the same centre in both directions",
            )
        };
        o.expect(&format!("steering {steering}: radius backwards"), back, "m", expected, source);
    }
    o.plots.push(plot);
    Ok(o)
}

pub(super) const CHANGE: Event = Event {
    name: "direction-change",
    title: "Change of direction",
    about: "At rest with brakes on: the time from the command to torque at the gearbox' output, to reverse and back. From 3 m/s, \
            reverse with full throttle, for half a second without brakes and then with a third of them. And neutral with full \
            throttle at 3 m/s.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: change,
};

fn change(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    if Backwards::new(bench).is_none() {
        o.note(NONE);
        return Ok(o);
    }
    from_rest(bench, &mut o)?;
    at_speed(bench, &mut o)?;
    Ok(o)
}

/// The time that a change takes, both ways.
fn from_rest(bench: &Bench<'_>, o: &mut Outcome) -> Result<(), SimError> {
    let (step, latency) = (bench.options.step, bench.spec.powertrain.gearbox.direction_change.latency);
    let mut d = Drive::new(bench, "rest", &flat(0.9), 0.0, 0.0)?;
    d.hold(1.0, |_| PARKED)?;
    for (name, gear, sign) in [("to reverse", Gear::Reverse, -1.0), ("to forward", Gear::Forward, 1.0)] {
        let begin = d.state().time;
        let press = Controls { gear, ..controls(0.0, 0.3, 1.0) };
        d.run(latency + 1.0, |_| press, |s| s.gear == gear)?;
        let time = d.state().time - begin;
        let torque = sign * d.sim().drive().shaft_torque;
        o.expect(
            &format!("{name}: time to torque"),
            time,
            "s",
            // It pushes in the step at whose end the gear shows.
            Expected::Within { value: latency + step, tolerance: 0.5 * step },
            "the latency in the vehicle file, and a step",
        );
        o.expect(
            &format!("{name}: torque in its direction then"),
            torque,
            "N m",
            Expected::AtLeast(f64::MIN_POSITIVE),
            "the engine drives in the direction of the gear",
        );
        d.hold(0.5, |_| press)?;
    }
    o.series.push(d.finish());
    Ok(())
}

/// That a change waits for the brakes, and neutral for nothing.
fn at_speed(bench: &Bench<'_>, o: &mut Outcome) -> Result<(), SimError> {
    let pace = bench.pace;
    let limit = bench.spec.powertrain.gearbox.direction_change.speed;
    let target = pace.within_reach(3.0);
    let reach = |case: &str| -> Result<Drive, SimError> {
        let mut d = Drive::new(bench, case, &flat(0.9), 0.0, 0.0)?;
        let gentle = |s: &VehicleState| {
            let c = pace.hold_speed(s, 1.2 * target, pace.hold_line(s));
            controls(c.steering, c.throttle.min(0.3), c.brake)
        };
        d.run(30.0, gentle, |s| s.velocity_body.x >= pace.speed(target))?;
        // What the last push has strained gives it back.
        d.hold(pace.time(0.3), |s| controls(pace.hold_line(s), 0.0, 0.0))?;
        Ok(d)
    };
    let mut d = reach("waiting")?;
    let (mut slowest, mut gained) = (d.state().velocity_body.x, 0.0_f64);
    let left = d.run(
        pace.time(0.5),
        |s| reverse(pace.hold_line(s), 1.0, 0.0),
        |s| {
            slowest = slowest.min(s.velocity_body.x);
            gained = gained.max(s.velocity_body.x - slowest);
            s.gear != Gear::Forward
        },
    )?;
    let waited = if left { d.state().velocity_body.x } else { f64::INFINITY };
    o.expect(
        "greatest gain of speed while reverse waits",
        gained,
        "m/s",
        Expected::AtMost(pace.speed(0.02)),
        "the throttle is closed while a change of direction is pending",
    );
    let mut last = waited.min(d.state().velocity_body.x);
    d.run(
        30.0,
        |s| reverse(pace.hold_line(s), 1.0, 1.0 / 3.0),
        |s| {
            if s.gear == Gear::Forward {
                last = s.velocity_body.x;
            }
            s.gear != Gear::Forward
        },
    )?;
    o.expect(
        "speed at which forward is let go",
        last,
        "m/s",
        Expected::Between((0.9 * limit).min(limit - GRAVITY * SAMPLE), limit),
        "below the speed in the vehicle file, immediately: within a sample at a deceleration of 1 g, or 10 %",
    );
    let begin = d.state().time;
    d.run(10.0, |s| reverse(pace.hold_line(s), 1.0, 1.0 / 3.0), |s| s.gear == Gear::Reverse)?;
    let latency = bench.spec.powertrain.gearbox.direction_change.latency;
    o.expect(
        "time without torque in between",
        d.state().time - begin,
        "s",
        Expected::Within { value: latency, tolerance: 1.5 * bench.options.step },
        "the latency in the vehicle file",
    );
    d.hold(pace.time(3.0), |s| reverse(pace.hold_line(s), 0.3, 0.0))?;
    o.expect(
        "speed 3 s after",
        d.state().velocity_body.x,
        "m/s",
        Expected::AtMost(-pace.speed(0.1)),
        "it drives backwards",
    );
    let series = d.finish();
    let mut plot = Plot::new("From forward to backwards", "t, s", "speed, m/s");
    plot.ours("reverse commanded at speed", series.pairs("t", "vx"));
    o.plots.push(plot);
    o.series.push(series);
    let mut d = reach("neutral")?;
    d.hold(bench.options.step, |_| Controls { gear: Gear::Neutral, ..controls(0.0, 1.0, 0.0) })?;
    o.expect(
        "torque a step after the command for neutral",
        d.sim().drive().shaft_torque,
        "N m",
        Expected::Within { value: 0.0, tolerance: 0.0 },
        "neutral uncouples the engine immediately at any speed",
    );
    o.series.push(d.finish());
    Ok(())
}
