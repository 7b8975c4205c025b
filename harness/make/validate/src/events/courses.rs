//! Ride and shock over courses, as the NATO Reference Mobility Model rates vehicles: the speed at which the driver absorbs 6 W on
//! rough ground, and that at which the seat has a peak of 2.5 g at an obstacle (Ahlvin and Haley, NRMM Edition II, WES Technical
//! Report GL-92-11, 1992: ride and obstacle limits of the vehicle preprocessor VEHDYN).

use std::sync::Arc;

use vb_math::{exp, ln};
use vb_score::{POWER_LIMIT_W, RideMeter, RideStep, SHOCK_LIMIT_G};
use vb_sim::{SimError, Simulation, SoilSet};
use vb_terrain::Course;
use vb_world::{Pose2, World};

use crate::bench::Bench;
use crate::check::Expected;
use crate::course::{Ground, INCH, half_round, rms_course};
use crate::event::{Event, LineKind, Outcome, Place, Plot, Series, Vehicles};

pub(super) const RIDE: Event = Event {
    name: "ride-course",
    title: "Ride over RMS courses",
    about: "Courses of 91 m with an RMS of 1 and 4 inches, wavelengths above 60 ft removed, at constant speed: the speed at which the \
            driver absorbs 6 W of vertical vibration. Lengths of the courses scale with the vehicle.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: ride,
};

pub(super) const HALF_ROUND: Event = Event {
    name: "half-round",
    title: "Half rounds",
    about: "Half rounds of 12 and 24 inches across the course at constant speed: the speed at which the vertical acceleration of the seat, \
            below 30 Hz, has a peak of 2.5 g. Lengths of the obstacles scale with the vehicle.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: half_rounds,
};

/// Friction of the ground.
const FRICTION: f64 = 0.9;
/// The lowest speed, m/s at full size.
const LOWEST: f64 = 1.0;
/// The RMS (in) of each course, and the speed at which the search begins there, m/s at full size.
const COURSES: [(f64, f64); 2] = [(1.0, 7.0), (4.0, 3.0)];
/// The speed at which the search begins on a course of a file, m/s at full size.
const FIRST: f64 = 5.0;
/// The ratio of speeds that follow each other in a search.
const RATIO: f64 = 1.5;
/// The ratio of the two speeds between which the result is interpolated.
const RESOLUTION: f64 = 1.12;
/// The fraction of its top speed up to which a vehicle is driven.
const TOP: f64 = 0.95;
/// The level way at speed before the ground becomes uneven, s and m, and the time for which shock is measured behind it, s.
const LEAD: [f64; 2] = [2.0, 3.0];
const AFTER: f64 = 1.0;
/// The distance from the line at which the vehicle has left the course, m, and the cosine of the tilt at which it has overturned.
const ASTRAY: f64 = 2.5;
const UPRIGHT: f64 = 0.5;

/// A vehicle's passage over ground at one speed. Full-size.
#[derive(Clone, Copy, Debug)]
struct Pass {
    /// The mean speed over the uneven ground, m/s.
    speed: f64,
    /// The power that the driver absorbs there, W.
    power: f64,
    /// The peak of the seat's vertical acceleration there and shortly behind, g.
    peak: f64,
    /// Whether the hull touched the ground.
    touched: bool,
}

/// Which of the two measures is limited.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Measure {
    Power,
    Peak,
}

impl Measure {
    fn of(self, pass: &Pass) -> f64 {
        if self == Self::Power { pass.power } else { pass.peak }
    }

    fn limit(self) -> f64 {
        if self == Self::Power { POWER_LIMIT_W } else { SHOCK_LIMIT_G }
    }

    fn unit(self) -> &'static str {
        if self == Self::Power { "W" } else { "g" }
    }
}

/// Result of the search for a speed.
struct Found {
    /// The speed at the limit, m/s at full size; `None` if it lies outside the range that was driven, which `why` explains.
    speed: Option<f64>,
    why: String,
    /// All passages, by speed.
    passes: Vec<Pass>,
}

/// Ground at the scale of a vehicle.
struct Track<'a> {
    bench: &'a Bench<'a>,
    world: Arc<World>,
    /// Where it becomes uneven and where it ends to be, m at the scale of the vehicle.
    uneven: [f64; 2],
    /// The foremost and the rearmost point where the vehicle touches the ground, from its reference point, m.
    ends: [f64; 2],
}

impl<'a> Track<'a> {
    /// `None` for level ground.
    fn new(bench: &'a Bench<'a>, ground: &Ground) -> Option<Self> {
        let scale = bench.spec.scale;
        let uneven = ground.uneven?.map(|x| x * scale);
        let world = Arc::new(World::clone(&ground.world).at_scale(scale));
        let ends = bench.geometry.corners.iter().enumerate().fold(
            [f64::NEG_INFINITY, f64::INFINITY],
            |e, (i, c)| {
                let x = bench.geometry.hub(i, bench.geometry.rest[i], 0.0).x;
                [e[0].max(x + c.radius), e[1].min(x - c.radius)]
            },
        );
        Some(Self { bench, world, uneven, ends })
    }

    /// Drives over the ground at a full-size speed, m/s; `None` if the vehicle does not arrive.
    fn pass(&self, speed: f64) -> Result<Option<Pass>, SimError> {
        let Self { bench, uneven: [from, to], ends: [front, rear], .. } = *self;
        let (pace, spec, step) = (bench.pace, bench.spec, bench.options.step);
        let own = pace.speed(speed);
        let start = from - front - own * pace.time(LEAD[0]) - pace.length(LEAD[1]);
        let mut sim = Simulation::new(
            self.world.clone(),
            &bench.model,
            &SoilSet::default(),
            Pose2 { x: start, y: 0.0, yaw: 0.0 },
            bench.options,
        )?;
        // At speed from the first step on, in about the right gear.
        let mut state = sim.state();
        state.velocity_body.x = own;
        for (wheel, corner) in state.wheels.iter_mut().zip(&bench.geometry.corners) {
            wheel.speed = own / corner.radius;
        }
        let gears = spec.powertrain.gearbox.ratios.len();
        sim.rig().put(&state, (own / spec.max_speed * gears as f64).ceil() as usize);
        let mut meter = RideMeter::new(step, spec.scale);
        let seat = spec.seat();
        let mut last = sim.velocity_of(seat);
        let (mut entered, mut left, mut touched) = (None, None, false);
        let mut pass = Pass { speed: 0.0, power: 0.0, peak: 0.0, touched: false };
        let end = (to - start - rear) / (0.5 * own) + pace.time(10.0);
        loop {
            let s = sim.state();
            let inside = s.position.x + front >= from;
            if inside && entered.is_none() {
                entered = Some((s.time, s.position.x));
            }
            if let Some((time, x)) = entered
                && left.is_none()
                && s.position.x + rear > to
            {
                left = Some(s.time);
                pass.speed = (s.position.x - x) / (s.time - time) / pace.speed(1.0);
                pass.power = meter.ride().map_or(f64::NAN, |r| r.absorbed_power_w);
            }
            if left.is_some_and(|left| s.time - left >= pace.time(AFTER)) {
                pass.peak = meter.ride().map_or(f64::NAN, |r| r.seat_peak_z_g);
                pass.touched = touched;
                return Ok((pass.power.is_finite() && pass.peak.is_finite()).then_some(pass));
            }
            if s.time > end || s.position.y.abs() > pace.length(ASTRAY) || sim.upward() < UPRIGHT {
                return Ok(None);
            }
            let contacts = sim.contact_steps();
            sim.advance(pace.hold_speed(&s, speed, pace.hold_line(&s)), 1)?;
            let velocity = sim.velocity_of(seat);
            let change = [0, 1, 2].map(|k| (velocity[k] - last[k]) / step);
            last = velocity;
            if inside {
                let near = sim.contact_steps() != contacts;
                touched |= near;
                meter.push(&RideStep {
                    acceleration: sim.in_body_axes(change),
                    upward: sim.upward(),
                    loaded_wheels: sim.loaded_wheels(),
                    hull_is_free: !near,
                });
            }
        }
    }

    /// The speed at which a measure reaches its limit, looked for from `first` (m/s, full-size) on: upwards until it is reached, or
    /// downwards until it is not. Between two speeds that differ by a factor of [`RESOLUTION`] its logarithm is taken to be linear in
    /// that of the speed.
    fn search(&self, measure: Measure, first: f64) -> Result<Found, SimError> {
        let top = TOP * self.bench.spec.max_speed / self.bench.pace.speed(1.0);
        let mut passes: Vec<Pass> = Vec::new();
        let mut below: Option<(f64, Pass)> = None;
        // A passage that fails bounds the speed, too, but has no measure.
        let mut above: Option<(f64, Option<Pass>)> = None;
        let mut speed = first.min(top);
        loop {
            let pass = self.pass(speed)?;
            passes.extend(pass);
            match pass {
                Some(p) if measure.of(&p) < measure.limit() => below = Some((speed, p)),
                other => above = Some((speed, other)),
            }
            speed = match (below, above) {
                (Some((low, _)), Some((high, _))) if high / low > RESOLUTION => (low * high).sqrt(),
                (Some(_), Some(_)) => break,
                (Some((low, _)), None) if low >= top => break,
                (Some((low, _)), None) => (low * RATIO).min(top),
                (None, Some((high, _))) if high <= LOWEST => break,
                (None, Some((high, _))) => (high / RATIO).max(LOWEST),
                (None, None) => break,
            };
        }
        passes.sort_by(|a, b| a.speed.total_cmp(&b.speed));
        let said = |p: &Pass| format!("{:.2} {}", measure.of(p), measure.unit());
        let own = |speed: f64| self.bench.pace.speed(speed);
        let (speed, why) = match (below, above) {
            (Some((_, a)), Some((_, Some(b)))) => {
                let [za, zb] = [measure.of(&a), measure.of(&b)].map(|z| ln(z.max(1e-9)));
                let t = (ln(measure.limit()) - za) / (zb - za);
                (Some(exp(ln(a.speed) + t * (ln(b.speed) - ln(a.speed)))), String::new())
            }
            (Some((_, a)), Some((high, None))) => (
                None,
                format!(
                    "below the limit up to {:.2} m/s ({}), and leaves the course at {:.2} m/s",
                    own(a.speed),
                    said(&a),
                    own(high)
                ),
            ),
            (Some((_, a)), None) => {
                (None, format!("below the limit at its top speed: {} at {:.2} m/s", said(&a), own(a.speed)))
            }
            (None, Some((high, Some(b)))) => {
                (None, format!("above the limit at {:.2} m/s: {}", own(high), said(&b)))
            }
            (None, Some((high, None))) => (None, format!("does not cross it at {:.2} m/s", own(high))),
            (None, None) => (None, "was not run".to_owned()),
        };
        Ok(Found { speed, why, passes })
    }
}

/// The outcome of several searches, in the making.
struct Ride<'a> {
    bench: &'a Bench<'a>,
    measure: Measure,
    outcome: Outcome,
    plot: Plot,
}

impl<'a> Ride<'a> {
    fn new(bench: &'a Bench<'a>, measure: Measure) -> Self {
        let plot = match measure {
            Measure::Power => Plot::new("Absorbed power over speed", "speed, m/s", "absorbed power, W"),
            Measure::Peak => Plot::new(
                "Peak of the seat's acceleration over speed",
                "speed, m/s",
                "vertical acceleration, g",
            ),
        };
        Self { bench, measure, outcome: Outcome::default(), plot }
    }

    /// The full-size speed at the limit over a course, m/s; its figures take the label.
    fn over(&mut self, label: &str, ground: &Ground, first: f64) -> Result<Option<f64>, SimError> {
        let Some(track) = Track::new(self.bench, ground) else {
            self.outcome.note(format!("{label}: the course is level, so the speed is undefined."));
            return Ok(None);
        };
        let found = track.search(self.measure, first)?;
        let (limit, unit) = (self.measure.limit(), self.measure.unit());
        let pace = self.bench.pace;
        let name = format!("{label}: speed at {limit} {unit}");
        self.outcome.figure(name, found.speed.map_or(f64::NAN, |v| pace.speed(v)), "m/s");
        if !found.why.is_empty() {
            self.outcome.note(format!("{label}: {}.", found.why));
        }
        if let Some(slowest) = found.passes.first().filter(|p| p.touched) {
            let speed = pace.speed(slowest.speed);
            self.outcome.note(format!("{label}: the hull touches the ground at {speed:.2} m/s."));
        }
        let points = found.passes.iter().map(|p| [pace.speed(p.speed), self.measure.of(p)]).collect();
        self.plot.ours(label, points);
        self.outcome.series.push(Series {
            name: label
                .to_lowercase()
                .chars()
                .map(|c| if c.is_ascii_alphanumeric() || c == '.' { c } else { '-' })
                .collect(),
            columns: [("speed", "m/s"), ("absorbed power", "W"), ("peak", "g")]
                .map(|(n, u)| (n.to_owned(), u))
                .to_vec(),
            rows: found.passes.iter().map(|p| vec![pace.speed(p.speed), p.power, p.peak]).collect(),
        });
        Ok(found.speed)
    }

    fn finish(mut self) -> Outcome {
        let [from, to] = self.plot.span();
        if from < to {
            let limit = self.measure.limit();
            self.plot.line(LineKind::Theory, 0, "limit", vec![[from, limit], [to, limit]]);
            self.outcome.plots.push(self.plot);
        }
        if self.bench.spec.scale != 1.0 {
            self.outcome.note(format!(
                "Course lengths are {} of those in their names, as for all worlds of this vehicle.",
                self.bench.spec.scale
            ));
        }
        if self.bench.spec.chassis.seat.is_none() {
            self.outcome
                .note("The vehicle has no seat: measurements are at the centre of mass of its chassis.");
        }
        self.outcome
    }
}

impl Bench<'_> {
    /// A course as ground for this vehicle.
    fn ground(&self, course: &Course) -> Ground {
        Ground::new(course, self.spec.width / self.spec.scale, FRICTION)
    }
}

fn ride(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut ride = Ride::new(bench, Measure::Power);
    if let Some(named) = bench.course {
        let ground = bench.ground(&named.course);
        ride.outcome.figure(
            format!("{}: RMS without wavelengths above 60 ft", named.name),
            ground.rms / INCH,
            "in",
        );
        ride.over(&named.name, &ground, FIRST)?;
        straightened(&mut ride.outcome, named);
        return Ok(ride.finish());
    }
    let mut speeds = Vec::new();
    for (inches, first) in COURSES {
        let label = format!("RMS {inches} in");
        speeds.push(ride.over(&label, &bench.ground(&rms_course(inches * INCH)), first)?);
    }
    ordered(&mut ride.outcome, "speed over RMS 4 in over that over RMS 1 in", &speeds);
    Ok(ride.finish())
}

fn half_rounds(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut ride = Ride::new(bench, Measure::Peak);
    if let Some(named) = bench.course {
        ride.over(&named.name, &bench.ground(&named.course), LOWEST)?;
        straightened(&mut ride.outcome, named);
        return Ok(ride.finish());
    }
    let mut speeds = Vec::new();
    for inches in [12.0, 24.0] {
        let label = format!("half round {inches} in");
        let smallest = bench.geometry.corners.iter().map(|c| c.radius).fold(f64::INFINITY, f64::min);
        let height = bench.pace.length(inches * INCH);
        if bench.spec.tracks.is_none() && smallest < height {
            ride.outcome.note(format!(
                "{label}: omitted, because the wheel radius of {smallest:.3} m is below the obstacle height of {height:.3} m."
            ));
            continue;
        }
        speeds.push(ride.over(&label, &bench.ground(&half_round(inches * INCH)), LOWEST)?);
    }
    ordered(&mut ride.outcome, "speed over 24 in over that over 12 in", &speeds);
    Ok(ride.finish())
}

/// A rougher course or a higher obstacle allows no more speed.
fn ordered(outcome: &mut Outcome, name: &str, speeds: &[Option<f64>]) {
    if let [Some(smooth), Some(rough)] = speeds {
        outcome.expect(
            name,
            rough / smooth,
            "",
            Expected::AtMost(1.0),
            "higher obstacle of the same shape: no higher speed",
        );
    }
}

/// Adds the note that a course with turns was driven straightened.
fn straightened(outcome: &mut Outcome, named: &crate::course::NamedCourse) {
    let turn = named.course.turn().to_degrees();
    if turn > 0.05 {
        outcome.note(format!("{}: its reference line turns by {turn:.1}° and is straightened.", named.name));
    }
}
