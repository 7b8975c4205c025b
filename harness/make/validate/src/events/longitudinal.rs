//! Along a straight line on level ground.

use crate::bench::Bench;
use crate::check::Expected;
use crate::event::{Event, Outcome, Place, Plot, Vehicles};
use crate::grounds::flat;
use crate::pace::{COASTING, controls, speed};
use crate::rig::{Drive, SAMPLE};
use crate::theory::PointMass;
use vb_sim::{Controls, Gear, SimError, VehicleState};
use vb_vehicle::GRAVITY;

pub(super) const ACCELERATION: Event = Event {
    name: "acceleration",
    title: "Acceleration and top speed",
    about: "Throttle step from rest on level ground, heading controlled by the pursuit law, 60 s (30 s at μ 0.5).",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: acceleration,
};

/// Source of figures from the maps.
const POINT_MASS: &str = "point mass on wheels without slip: engine map, gears, inertias, rolling resistance";

/// Gets to a speed (m/s) at no more than 0.3 of throttle, at which no wheel spins and every gear is used up, holds it for
/// 5 s, so that wheels and springs come to rest, and coasts down to it exactly.
fn reach(bench: &Bench<'_>, d: &mut Drive, speed: f64) -> Result<(), SimError> {
    let gentle = |s: &VehicleState| {
        let c = bench.pace.hold_speed(s, speed + 0.1, bench.pace.hold_line(s));
        controls(c.steering, c.throttle.min(0.3), c.brake)
    };
    d.run(60.0, gentle, |s| s.velocity_body.x >= bench.pace.speed(speed))?;
    d.hold(5.0, gentle)?;
    d.run(
        5.0,
        |s| controls(bench.pace.hold_line(s), 0.0, 0.0),
        |s| s.velocity_body.x <= bench.pace.speed(speed),
    )?;
    Ok(())
}

fn acceleration(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let mut whole = Plot::new("Speed after a throttle step", "t, s", "speed, m/s");
    let pace = bench.pace;
    let mut start = Plot::new("The first ten seconds", "t, s", "speed, m/s");
    for (throttle, friction, seconds) in
        [(1.0, 0.9, 60.0), (0.6, 0.9, 60.0), (0.3, 0.9, 60.0), (1.0, 0.5, 30.0)]
    {
        let case = format!("throttle {throttle:.1}, μ {friction:.1}");
        let mut d = Drive::new(
            bench,
            &format!("throttle-{throttle:.1}-mu-{friction:.1}"),
            &flat(friction),
            0.0,
            0.0,
        )?;
        let begin = d.state().time;
        let press = |s: &VehicleState| controls(bench.pace.hold_line(s), throttle, 0.0);
        for target in [5.0, 10.0, 15.0, 20.0, 30.0] {
            let rest = seconds - (d.state().time - begin);
            let reached = d.run(rest, press, |s| s.velocity_body.x >= pace.speed(target))?;
            let t = if reached { d.state().time - begin } else { f64::NAN };
            o.figure(format!("{case}: time to {} m/s", pace.speed_label(target)), t, "s");
        }
        d.hold(seconds - (d.state().time - begin), press)?;
        o.figure(format!("{case}: speed after {seconds} s"), speed(&d.state()), "m/s");
        let first = format!("{case}: time to {} m/s", pace.speed_label(5.0));
        let known = PointMass::knows(bench);
        // Some vehicles never drive so fast, or not with so little throttle.
        let fast = |mut p: PointMass| p.time_to(pace.speed(5.0), seconds, throttle).is_some();
        if pace.speed(5.0) < bench.spec.max_speed && (!known || fast(PointMass::new(bench, friction, 0.0))) {
            o.theory(
                first,
                Expected::AtLeast(pace.speed(5.0) / (friction * GRAVITY)),
                "friction: at least v / μ g with all-wheel drive",
            );
        }
        // Where the engine, not the grip, is the limit, its maps give the times: from rest with little throttle, with more
        // from the speed on at which the wheels have ceased to spin.
        let mut p = PointMass::new(bench, friction, 0.0);
        let spins = p.spins(throttle);
        let mut maps = std::collections::BTreeMap::new();
        for target in [5.0, 10.0, 15.0, 20.0] {
            if let Some(t) = p.time_to(pace.speed(target), seconds, throttle) {
                maps.insert(target as i32, t);
                if throttle < 0.5 && known && !spins {
                    let name = format!("{case}: time to {} m/s", pace.speed_label(target));
                    o.theory(name, Expected::fraction(t, 0.05), POINT_MASS);
                }
            }
        }
        p.drive_for(seconds, throttle, 0.0);
        if known {
            o.theory(
                format!("{case}: speed after {seconds} s"),
                Expected::fraction(p.speed, 0.05),
                POINT_MASS,
            );
        }
        let label = |v: f64| pace.speed_label(v);
        let measured = |v: f64| o.value(&format!("{case}: time to {} m/s", label(v))).unwrap_or(f64::NAN);
        let (name, span) = (
            format!("{case}: time from {} to {} m/s", label(10.0), label(20.0)),
            measured(20.0) - measured(10.0),
        );
        o.figure(name.clone(), span, "s");
        if let (Some(a), Some(b), true) = (maps.get(&10), maps.get(&20), known) {
            o.theory(name, Expected::fraction(b - a, 0.05), POINT_MASS);
        }
        let series = d.finish();
        let points = series.pairs("t", "vx");
        start.ours(case.clone(), points.iter().copied().filter(|p| p[0] <= 10.0).collect());
        whole.ours(case, points);
        o.series.push(series);
    }
    o.plots.extend([start, whole]);
    shifts(bench, &mut o)?;
    Ok(o)
}

/// By how much sooner the gearbox shifts up where it is asked what that changes.
const SOONER: f64 = 0.01;

/// What the shift points make of full throttle: how long the engine runs within 1 % of one, which it passes in a few hundredths of
/// a second on wheels that roll, and the times to speeds if it shifts up 1 % sooner.
///
/// Wheels that spin hold the engine where its torque is what their friction takes. Where that is just below a shift point, noise
/// in their loads decides whether it shifts, by which the HMMWV loses a fifth of its force.
fn shifts(bench: &Bench<'_>, o: &mut Outcome) -> Result<(), SimError> {
    let ups = &bench.spec.powertrain.gearbox.shift_up;
    if bench.spec.powertrain.gearbox.ratios.len() < 2 {
        return Ok(());
    }
    let case = "throttle 1.0, μ 0.9";
    let mut sooner = bench.spec.clone();
    sooner.powertrain.gearbox.shift_up.iter_mut().for_each(|up| *up *= 1.0 - SOONER);
    let (pace, world) = (bench.pace, flat(0.9));
    for (label, name, spec) in [
        (case.to_owned(), "throttle-1.0-shifts", bench.spec),
        (format!("{case}, shifting 1 % sooner"), "throttle-1.0-sooner", &sooner),
    ] {
        let mut d = Drive::with_spec(bench, spec, name, &world, 0.0, 0.0)?;
        let (begin, limit) = (d.state().time, pace.time(20.0));
        let press = |s: &VehicleState| controls(pace.hold_line(s), 1.0, 0.0);
        for target in [10.0, 15.0, 20.0] {
            let rest = limit - (d.state().time - begin);
            let reached = d.run(rest, press, |s| s.velocity_body.x >= pace.speed(target))?;
            let t = if reached { d.state().time - begin } else { f64::NAN };
            // As it is these are figures of the event already.
            if name.ends_with("sooner") {
                o.figure(format!("{label}: time to {} m/s", pace.speed_label(target)), t, "s");
            }
        }
        let series = d.finish();
        if spec.powertrain.gearbox.shift_up == *ups {
            let near = series.pairs("gear", "engine speed").into_iter().filter(|[gear, speed]| {
                let part = ups.get(*gear as usize - 1).map_or(0.0, |up| speed / up);
                (*gear as usize) < bench.spec.powertrain.gearbox.ratios.len()
                    && (1.0 - SOONER..=1.0).contains(&part)
            });
            let seconds = near.count() as f64 * SAMPLE;
            o.figure(format!("{label}: time within 1 % of a shift up"), seconds, "s");
        }
        o.series.push(series);
    }
    Ok(())
}

pub(super) const BRAKING: Event = Event {
    name: "braking",
    title: "Braking",
    about: "From 15, 8 and 4 m/s with full brakes, from 15 m/s with half and a quarter, and from 15 m/s at μ 0.5; throttle \
            closed, heading held.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: braking,
};

/// Time (s) to 10 m/s, or to what the vehicle can hold, with full throttle at μ 0.9.
pub(super) fn time_to_10(bench: &Bench<'_>) -> Result<f64, SimError> {
    let mut d = Drive::new(bench, "", &flat(0.9), 0.0, 0.0)?;
    d.run(
        30.0,
        |s| controls(bench.pace.hold_line(s), 1.0, 0.0),
        |s| s.velocity_body.x >= bench.pace.speed(bench.pace.within_reach(10.0)),
    )?;
    Ok(d.state().time)
}

/// Braking distance (m) from 15 m/s, or from what the vehicle can hold, at μ 0.9.
pub(super) fn braking_distance(bench: &Bench<'_>, pedal: f64) -> Result<f64, SimError> {
    Ok(brake(bench, &mut Outcome::default(), "", bench.pace.within_reach(15.0), pedal, 0.9)?.1)
}

/// One braking; returns (speed at its start, distance, time, greatest |pitch|) and adds its series.
fn brake(
    bench: &Bench<'_>,
    o: &mut Outcome,
    case: &str,
    from: f64,
    pedal: f64,
    friction: f64,
) -> Result<(f64, f64, f64, f64), SimError> {
    let mut d = Drive::new(bench, case, &flat(friction), 0.0, 0.0)?;
    reach(bench, &mut d, from)?;
    let a = d.state();
    let mut pitch: f64 = 0.0;
    d.run(
        30.0,
        |s| controls(bench.pace.hold_line(s), 0.0, pedal),
        |s| {
            pitch = pitch.max(s.roll_pitch_yaw().1.abs());
            s.velocity_body.x <= bench.pace.speed(0.01)
        },
    )?;
    let b = d.state();
    o.series.push(d.finish());
    Ok((a.velocity_body.x, (b.position - a.position).norm(), b.time - a.time, pitch))
}

fn braking(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let mut plot = Plot::new("Speed in braking", "t, s", "speed, m/s");
    let cases = [
        (15.0, 1.0, 0.9),
        (8.0, 1.0, 0.9),
        (4.0, 1.0, 0.9),
        (15.0, 0.5, 0.9),
        (15.0, 0.25, 0.9),
        (15.0, 1.0, 0.5),
    ];
    for (from, pedal, friction) in cases.into_iter().filter(|c| bench.pace.reaches(c.0)) {
        let speed = bench.pace.speed_label(from);
        let label = format!("{speed} m/s, brake {pedal}, μ {friction:.1}");
        let (v, distance, time, pitch) =
            brake(bench, &mut o, &format!("{speed}-brake-{pedal}-mu-{friction:.1}"), from, pedal, friction)?;
        o.figure(format!("{label}: distance"), distance, "m");
        o.figure(format!("{label}: time"), time, "s");
        o.figure(format!("{label}: greatest pitch"), pitch.to_degrees(), "°");
        let shortest = v * v / (2.0 * friction * GRAVITY);
        if pedal < 1.0 && PointMass::knows(bench) {
            let distance = PointMass::new(bench, friction, v).stop(pedal);
            o.theory(format!("{label}: distance"), Expected::fraction(distance, 0.05), POINT_MASS);
        } else if from >= 10.0 && locks(bench, pedal, friction) {
            let source = "friction: v² / 2 μ g with all wheels at the limit";
            o.theory(format!("{label}: distance"), Expected::fraction(shortest, 0.05), source);
        } else {
            // The tenth of a second in which brake, wheel and carcass build up their force is no small part of it.
            let source = "friction: no less than v² / 2 μ g";
            o.theory(format!("{label}: distance"), Expected::AtLeast(0.98 * shortest), source);
        }
        let series = o.series.last().map(|s| s.pairs("t", "vx")).unwrap_or_default();
        let begin = series.last().map_or(0.0, |p| p[0]) - time;
        plot.ours(
            label,
            series.into_iter().filter(|p| p[0] >= begin).map(|p| [p[0] - begin, p[1]]).collect(),
        );
    }
    o.plots.push(plot);
    Ok(o)
}

/// Whether the brakes at this pedal (0 to 1) lock the wheels: brake torque over radius beyond friction, with a half to spare for load
/// shift.
fn locks(bench: &Bench<'_>, pedal: f64, friction: f64) -> bool {
    let torque: f64 = bench.spec.axles.iter().map(|a| 2.0 * a.brake_torque).sum();
    bench.spec.axles.iter().all(|a| a.brake_torque > 0.0)
        && pedal * torque / bench.geometry.radius > 1.5 * friction * bench.geometry.weight()
}

pub(super) const COAST_DOWN: Event = Event {
    name: "coast-down",
    title: "Coast-down",
    about: "Throttle closed and brakes off from 15 and from 5 m/s until standstill, at most 90 s.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: coast_down,
};

fn coast_down(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let mut plot = Plot::new("Speed in coasting", "t, s", "speed, m/s");
    for from in [15.0, 5.0].into_iter().filter(|v| bench.pace.reaches(*v)) {
        let speed = bench.pace.speed_label(from);
        let mut d = Drive::new(bench, &speed, &flat(0.9), 0.0, 0.0)?;
        reach(bench, &mut d, from)?;
        let begin = d.state().time;
        let mut p = PointMass::new(bench, 0.9, d.state().velocity_body.x);
        let (mut slowest, mut previous, mut gained) = (f64::INFINITY, bench.pace.speed(from), 0.0_f64);
        let mut last = 0.0;
        for after in [2.0, 5.0, 10.0, 30.0, 90.0] {
            d.run(
                after - last,
                |s| controls(bench.pace.hold_line(s), 0.0, 0.0),
                |s| {
                    slowest = slowest.min(s.velocity_body.x);
                    // Gearshifts and the carcass may ripple: what counts is a gain over the lowest speed so far.
                    previous = previous.min(s.velocity_body.x);
                    gained = gained.max(s.velocity_body.x - previous);
                    false
                },
            )?;
            last = after;
            let name = format!("from {speed} m/s: speed after {after:.0} s");
            o.figure(name.clone(), d.state().velocity_body.x, "m/s");
            p.drive_for(after, 0.0, 0.0);
            if p.speed > bench.pace.speed(0.5) && PointMass::knows(bench) {
                o.theory(name, Expected::fraction(p.speed, 0.05), POINT_MASS);
            }
        }
        if bench.creeps() {
            o.note("Its engine idles against a converter: the vehicle does not come to rest without brakes.");
            o.series.push(d.finish());
            continue;
        }
        o.theory(
            format!("from {speed} m/s: speed after 90 s"),
            Expected::Within { value: 0.0, tolerance: 0.02 },
            "rolling resistance and engine drag stop the vehicle without a driving force",
        );
        o.expect(
            &format!("from {speed} m/s: lowest speed"),
            slowest,
            "m/s",
            Expected::AtLeast(-0.05),
            "a closed throttle does not drive backwards",
        );
        o.expect(
            &format!("from {speed} m/s: greatest gain of speed"),
            gained,
            "m/s",
            Expected::AtMost(0.05),
            "no driving force",
        );
        let series = d.finish();
        plot.ours(
            format!("from {speed} m/s"),
            series
                .pairs("t", "vx")
                .into_iter()
                .filter(|p| p[0] >= begin)
                .map(|p| [p[0] - begin, p[1]])
                .collect(),
        );
        o.series.push(series);
    }
    o.plots.push(plot);
    Ok(o)
}

pub(super) const ROLLING: Event = Event {
    name: "rolling",
    title: "Rolling without slip",
    about: "Coasting straight at 5 m/s in neutral: all wheels must roll without slip.",
    vehicles: Vehicles::Wheeled,
    place: Place::Rigid,
    run: rolling,
};

fn rolling(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let g = &bench.geometry;
    let mut d = Drive::new(bench, "coasting", &flat(0.9), 0.0, 0.0)?;
    let speed_at = bench.pace.within_reach(5.0);
    let at = |part: f64| bench.pace.speed(part * speed_at);
    let fast = |s: &VehicleState| s.velocity_body.x >= at(1.1);
    let hold = |s: &VehicleState| bench.pace.hold_speed(s, 1.16 * speed_at, bench.pace.hold_line(s));
    if !d.run(30.0, hold, fast)? {
        d.run(5.0, |s| controls(bench.pace.hold_line(s), 1.0, 0.0), fast)?;
    }
    // In neutral, since a motor may brake.
    let rolling = Controls { gear: Gear::Neutral, ..COASTING };
    d.run(5.0, |_| rolling, |s| s.velocity_body.x <= at(1.0))?;
    let s = d.state();
    let radii: Vec<f64> = s.wheels.iter().map(|w| speed(&s) / w.speed).collect();
    // Loaded over free radius, of the wheel that is loaded most.
    let loaded =
        (0..radii.len()).map(|i| g.hub_of(&s, i).z / g.corners[i].radius).fold(f64::INFINITY, f64::min);
    for (c, r) in g.corners.iter().zip(&radii) {
        o.expect(
            &format!("rolling radius {}", c.name),
            *r,
            "m",
            Expected::Between(c.radius * loaded * 0.998, c.radius * 1.002),
            "v / ω lies between the loaded and the free radius (Pacejka 2012, ch. 1), less 0.2 % of slip",
        );
    }
    let radii: Vec<f64> = radii.iter().zip(&g.corners).map(|(r, c)| r / c.radius).collect();
    let spread =
        radii.iter().copied().fold(0.0, f64::max) / radii.iter().copied().fold(f64::INFINITY, f64::min) - 1.0;
    // They roll on a radius a third of the deflection below the free one (Rill 2011, ch. 3), each by its own load.
    let sunk = s.wheels.iter().enumerate().map(|(i, w)| {
        let tyre = bench.spec.tyre_of(&bench.spec.axles[i / 2]);
        vb_sim::tyre::Tyre::new(tyre).deflection(w.load) / tyre.radius()
    });
    let (least, most) = sunk.fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
    let by_load = 100.0 * (most - least) / 3.0;
    o.expect(
        "spread of the rolling radii",
        100.0 * spread,
        "%",
        Expected::AtMost(0.4 + by_load),
        "no slip: radii as a function of load, and 0.4 %",
    );
    o.series.push(d.finish());
    Ok(o)
}
