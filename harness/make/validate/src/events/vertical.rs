//! Up and down: bumps, drops, steps.

use crate::bench::Bench;
use crate::check::Expected;
use crate::event::{Event, Outcome, Place, Plot, Series, Vehicles};
use crate::grounds::{bump, flat, step};
use crate::pace::{COASTING, controls};
use crate::rig::{Drive, largest};
use vb_math::angle::degrees;
use vb_sim::SimError;
use vb_vehicle::{GRAVITY, TyreSpec, VehicleSpec};

pub(super) const BUMP: Event = Event {
    name: "bump",
    title: "Half-sine bump",
    about: "A bump 0.2 m high over the whole width, 1, 2 and 4 m long at 5 m/s and 2 m at 3 m/s, under the speed controller. \
            Vertical acceleration of the reference point as a mean over 50 ms.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: bumps,
};

/// Span of the mean, s.
const SPAN: f64 = 0.05;

/// One drive over a bump.
struct Crossing {
    /// x (m) and pitch (°) of the reference point.
    pitch: Vec<[f64; 2]>,
    /// x (m) and mean vertical acceleration (m/s²).
    acceleration: Vec<[f64; 2]>,
    /// Lowest and highest reference point, m.
    heights: [f64; 2],
    series: Series,
}

fn cross(bench: &Bench<'_>, length: f64, target: f64) -> Result<Crossing, SimError> {
    let pace = bench.pace;
    let window = (pace.time(SPAN) / bench.options.step).round().max(1.0) as usize;
    let case = format!("{}m-{}", pace.length_label(length), pace.speed_label(target));
    let mut d = Drive::new(bench, &case, &bump(length, 0.2, 0.9), -20.0, 0.0)?;
    let mut trace: Vec<[f64; 3]> = Vec::new();
    let mut heights = [f64::INFINITY, f64::NEG_INFINITY];
    d.run(
        30.0,
        |s| bench.pace.hold_speed(s, target, bench.pace.hold_line(s)),
        |s| {
            if s.position.x > pace.length(-4.0) {
                trace.push([s.position.x, (s.attitude * s.velocity_body).z, degrees(s.roll_pitch_yaw().1)]);
                heights = [heights[0].min(s.position.z), heights[1].max(s.position.z)];
            }
            s.position.x > pace.length(length + 8.0)
        },
    )?;
    let span = window as f64 * bench.options.step;
    let mean = |k: usize| [trace[k - window / 2][0], (trace[k][1] - trace[k - window][1]) / span];
    Ok(Crossing {
        acceleration: (window..trace.len()).map(mean).collect(),
        pitch: trace.iter().map(|p| [p[0], p[2]]).collect(),
        heights,
        series: d.finish(),
    })
}

fn lowest(points: &[[f64; 2]]) -> f64 {
    points.iter().map(|p| p[1]).fold(f64::INFINITY, f64::min)
}

fn highest(points: &[[f64; 2]]) -> f64 {
    points.iter().map(|p| p[1]).fold(f64::NEG_INFINITY, f64::max)
}

/// Highest mean acceleration (m/s²) and pitch (°) over the 2 m bump at 5 m/s.
pub(super) fn bump_peaks(bench: &Bench<'_>) -> Result<[f64; 2], SimError> {
    let c = cross(bench, 2.0, bench.pace.within_reach(5.0))?;
    Ok([highest(&c.acceleration), highest(&c.pitch)])
}

/// How many times as hard a hard tyre is made for the bump.
const HARDER: f64 = 4.0;

/// A vehicle on hard tyres with tyres that a bump hardly presses; none if its tyres aren't hard.
///
/// The stiffness of a hard tyre stands for none. At the edge of the bump it is pressed by 9 mm, by which the wheel's jump of
/// velocity is spread over 50 ms, the span of the means that are measured here.
fn harder(bench: &Bench<'_>) -> Option<VehicleSpec> {
    let mut spec = bench.spec.clone();
    match &mut spec.tyre {
        TyreSpec::Rigid(t) if t.dilation.is_none() && spec.tracks.is_none() => {
            t.vertical_stiffness *= HARDER;
            t.vertical_damping *= HARDER.sqrt();
            Some(spec)
        }
        _ => None,
    }
}

fn bumps(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let spec = harder(bench);
    let hard = spec.as_ref().map(|s| Bench::new(s, bench.soils, bench.options.step)).transpose()?;
    let as_it_is = bench;
    let bench = hard.as_ref().unwrap_or(bench);
    if hard.is_some() {
        o.note(format!("The hard tyres are {HARDER} times as stiff here, because the edge of the bump would deflect them by 9 mm otherwise."));
    }
    let x = "x of the reference point, m";
    let mut tilt = Plot::new("Pitch over the bump", x, "pitch, ° (nose down positive)");
    let mut shake = Plot::new("Vertical acceleration, mean over 50 ms", x, "acceleration, m/s²");
    for (length, target) in
        [(1.0, 5.0), (2.0, 5.0), (4.0, 5.0), (2.0, 3.0)].into_iter().filter(|c| bench.pace.reaches(c.1))
    {
        let (long, speed) = (bench.pace.length_label(length), bench.pace.speed_label(target));
        let label = format!("{long} m, {speed} m/s");
        let c = cross(bench, length, target)?;
        o.figure(format!("{label}: lowest acceleration"), lowest(&c.acceleration), "m/s²");
        o.figure(format!("{label}: highest acceleration"), highest(&c.acceleration), "m/s²");
        o.figure(format!("{label}: lowest pitch"), lowest(&c.pitch), "°");
        o.figure(format!("{label}: highest pitch"), highest(&c.pitch), "°");
        o.figure(format!("{label}: lowest reference height"), c.heights[0], "m");
        o.figure(format!("{label}: highest reference height"), c.heights[1], "m");
        if hard.is_some() {
            let soft = cross(as_it_is, length, target)?;
            let name = format!("{label}, tyres as hard as they are: lowest acceleration");
            o.figure(name, lowest(&soft.acceleration), "m/s²");
        }
        tilt.ours(label.clone(), c.pitch);
        shake.ours(label, c.acceleration);
        o.series.push(c.series);
    }
    o.plots.extend([tilt, shake]);
    Ok(o)
}

pub(super) const DROP: Event = Event {
    name: "drop",
    title: "Drop from 0.5 m",
    about: "Released level, with wheels at design height and 0.5 m above level ground, without commands.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: drop,
};

const CLEARANCE: f64 = 0.5;

fn drop(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let g = &bench.geometry;
    let mut d = Drive::new(bench, "drop", &flat(0.9), 0.0, 0.0)?;
    let lowest_rim = (0..g.corners.len())
        .map(|i| g.hub(i, 0.0, 0.0).z - g.corners[i].radius)
        .fold(f64::INFINITY, f64::min);
    let clearance = bench.pace.length(CLEARANCE);
    d.sim().rig().lift(clearance - lowest_rim);
    let start = d.state().position.z;
    let (mut touched, mut lowest, mut peak, mut highest) = (f64::NAN, f64::INFINITY, 0.0_f64, 0.0_f64);
    let begin = d.state().time;
    d.run(
        5.0,
        |_| COASTING,
        |s| {
            let sum: f64 = s.wheels.iter().map(|w| w.load).sum();
            if sum > 0.0 && touched.is_nan() {
                touched = s.time - begin;
            }
            peak = peak.max(sum);
            if s.position.z < lowest {
                lowest = s.position.z;
                highest = lowest;
            }
            highest = highest.max(s.position.z);
            false
        },
    )?;
    let fall = (2.0 * clearance / GRAVITY).sqrt();
    // A spring that rests below its design height, or hardly above it, pushes its wheel down to its range's end.
    let droop = bench.spec.axles.iter().enumerate().map(|(i, a)| {
        if g.rest[2 * i] < 0.05 * a.suspension.range[1] { -a.suspension.range[0] } else { 0.0 }
    });
    let droop = droop.fold(0.0, f64::max).min(0.9 * clearance);
    let sooner = (2.0 * (clearance - droop) / GRAVITY).sqrt();
    o.expect(
        "first contact",
        touched,
        "s",
        Expected::Between(0.95 * sooner, 1.05 * fall),
        "√(2 h / g), or less by as much as the springs, unloaded, push the wheels down",
    );
    o.figure("lowest reference height", lowest, "m");
    o.expect(
        "highest reference height after it",
        highest,
        "m",
        Expected::AtMost(start),
        "energy: it bounces no higher than it fell from",
    );
    o.figure("final reference height", d.state().position.z, "m");
    o.figure("greatest sum of wheel loads", peak, "N");
    let series = d.finish();
    let mut plot = Plot::new("Height of the reference point", "t, s", "height, m");
    plot.ours(
        "drop",
        series
            .pairs("t", "z")
            .into_iter()
            .filter(|p| p[0] - begin < 2.5)
            .map(|p| [p[0] - begin, p[1]])
            .collect(),
    );
    o.plots.push(plot);
    o.series.push(series);
    Ok(o)
}

pub(super) const STEP_CLIMB: Event = Event {
    name: "step-climb",
    title: "Vertical step",
    about: "A step of growing height at μ 0.9, approached from 6 m with the controller set to 2 m/s, without brake: the highest onto \
            which all wheels climb within 20 s.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: step_climb,
};

fn step_climb(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let g = &bench.geometry;
    let pace = bench.pace;
    let behind = -g.hub(g.corners.len() - 1, 0.0, 0.0).x;
    let mut best = None;
    let limit = largest(0.05, 1.2, 0.01, |height| {
        let mut d = Drive::new(
            bench,
            &format!("{height:.3}m"),
            &step(height, 0.9),
            -6.0 - behind / bench.spec.scale,
            0.0,
        )?;
        let up = |s: &vb_sim::VehicleState| s.position.x > behind + pace.length(0.6);
        let push = |s: &vb_sim::VehicleState| {
            controls(pace.hold_line(s), pace.hold_speed(s, 2.0, 0.0).throttle, 0.0)
        };
        let done = d.run(20.0, push, up)?;
        if done {
            best = Some(d.finish());
        }
        Ok(done)
    })?;
    let limit = pace.length(limit);
    o.figure("highest step climbed", limit, "m");
    let (expected, source) = if bench.spec.tracks.is_some() {
        let front = g.hub(0, 0.0, 0.0).z - g.hub(2, g.rest[2], 0.0).z + g.corners[2].radius;
        let reach = g.corners[0].radius;
        (
            Expected::Between(front - reach, front + reach),
            "up to where the belt rises in front it runs up any step; a wall is what its front wheel does not reach over",
        )
    } else {
        let wheels = if bench.spec.axles.iter().all(|a| a.driven) {
            Expected::Between(0.25 * g.radius, 2.0 * g.radius)
        } else {
            Expected::AtMost(2.0 * g.radius)
        };
        (
            wheels,
            "driven wheels all round climb a quarter of their radius; a diameter is a wall (Bekker 1969, ch. 2)",
        )
    };
    o.theory("highest step climbed", expected, source);
    if let Some(series) = best {
        let mut plot = Plot::new("Height of the reference point on the highest step", "x, m", "height, m");
        plot.ours(format!("{limit:.2} m"), series.pairs("x", "z"));
        o.plots.push(plot);
        o.series.push(series);
    }
    Ok(o)
}
