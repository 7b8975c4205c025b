//! Tipping over and lying on flank and roof.

use super::slopes::{TIP_FRICTION, sticky, stiff};
use crate::bench::Bench;
use crate::check::{Expectation, Expected, Kind};
use crate::event::{Event, Outcome, Place, Plot, Vehicles};
use crate::grounds::{flat, relief};
use crate::pace::{PARKED, controls};
use crate::rig::{Drive, largest};
use nalgebra::{UnitQuaternion, Vector3};
use std::f64::consts::{FRAC_PI_2, PI};
use vb_math::angle::{degrees, radians};
use vb_math::{atan, cos, sin, tan};
use vb_sim::{SimError, VehicleState};
use vb_vehicle::{GRAVITY, TyreSpec, VehicleSpec, kinematics::Motion};

pub(super) const TIP_OVER: Event = Event {
    name: "tip-over",
    title: "Tipping over",
    about: "With non-sliding tyres: the lateral speed at which sudden grip trips the vehicle, as a block \
            on hard wheels and unchanged; the side slope at which it tips in motion; the lateral acceleration at which \
            the inner wheels lift on a circle. With its own tyres: a steering step and a fishhook at up to 15 m/s, at μ 0.9 and with \
            too little grip to lift wheels.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: tip_over,
};

/// A rigid block on wheels that hold: what its masses say of tipping.
struct Block {
    mass: f64,
    /// Moment of inertia about the long axis through the centre of mass, kg m².
    inertia: f64,
    /// Height of the centre of mass, m.
    height: f64,
    /// Half of the track, between the middles of the treads and their outer edges, m.
    reach: [f64; 2],
}

impl Block {
    fn new(bench: &Bench<'_>) -> Result<Self, SimError> {
        let g = &bench.geometry;
        let s = crate::grounds::at_rest(&bench.model, bench.options)?;
        let (half, width) = (0.5 * g.track(), 0.5 * g.corners[0].width);
        Ok(Self {
            mass: g.mass,
            inertia: g.roll_inertia(),
            height: g.com_of(&s).z,
            reach: [half, half + width],
        })
    }

    /// Angle of a slope on which it tips over its wheels' middle, rad.
    fn angle(&self) -> f64 {
        atan(self.reach[0] / self.height)
    }

    /// Rise of the centre of mass until it stands over a point so far aside (m), m.
    fn rise(&self, reach: f64) -> f64 {
        vb_math::hypot(self.height, reach) - self.height
    }

    /// Sideways speed whose energy lifts the centre of mass over that point: what it takes if nothing is lost, m/s.
    fn energy_speed(&self, reach: f64) -> f64 {
        (2.0 * GRAVITY * self.rise(reach)).sqrt()
    }

    /// The same where the wheels stop at once: m v h is the angular momentum with which it turns about them, and the rest of
    /// the energy is lost (the critical sliding velocity of D. P. Jones, SAE 730165; Cooperrider et al., SAE 900366), m/s.
    fn trip_speed(&self, reach: f64) -> f64 {
        let about = self.inertia + self.mass * (self.height * self.height + reach * reach);
        (2.0 * GRAVITY * self.rise(reach) * about / self.mass).sqrt() / self.height
    }

    /// Friction that holds the wheels during the impact: horizontal over vertical impulse.
    fn holding(&self, reach: f64) -> f64 {
        (self.inertia / self.mass + reach * reach) / (self.height * reach)
    }
}

fn tip_over(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let block = Block::new(bench)?;
    o.figure("static stability factor", block.reach[0] / block.height, "");
    trips(bench, &block, &mut o)?;
    slope_in_motion(bench, &block, &mut o)?;
    if bench.spec.tracks.is_none() {
        circle(bench, &block, &mut o)?;
        for (manoeuvre, reverses) in [("step of the steering", false), ("fishhook", true)] {
            manoeuvres(bench, &block, manoeuvre, reverses, &mut o)?;
        }
    }
    Ok(o)
}

/// The lowest sideways speed from which the vehicle of a bench goes over, m/s.
fn trip(bench: &Bench<'_>, case: &str, block: &Block, o: &mut Outcome) -> Result<f64, SimError> {
    // Past the angle at which its centre of mass stands over the outer edge.
    let over = atan(block.reach[1] / block.height) + 0.1;
    let (low, high) = (0.5 * block.energy_speed(block.reach[0]), 1.5 * block.trip_speed(block.reach[1]));
    let mut last = None;
    let found = largest(low, high, 0.0025 * high, |speed| {
        let mut d = Drive::new(bench, case, &flat(TIP_FRICTION), 0.0, 0.0)?;
        d.sim().rig().throw([0.0, speed, 0.0]);
        let gone = match d.run(bench.pace.time(4.0), |_| PARKED, |s| s.roll_pitch_yaw().0.abs() > over) {
            Err(SimError::Diverged { time, what, .. }) => {
                o.note(format!("{case}: at {speed:.2} m/s the simulation diverges at {time:.2} s, which counts as tipping over: {what}"));
                true
            }
            other => other?,
        };
        if !gone {
            last = Some(d);
        }
        Ok(!gone)
    })?;
    o.series.extend(last.map(Drive::finish));
    Ok(found)
}

fn trips(bench: &Bench<'_>, block: &Block, o: &mut Outcome) -> Result<(), SimError> {
    let fraction = bench.geometry.mass / bench.geometry.corners.len() as f64;
    let hard = stiff(&hard(bench.spec, fraction));
    let rigid = Bench::new(&hard, bench.soils, bench.options.step)?;
    let theory = Block::new(&rigid)?;
    if theory.holding(theory.reach[0]) < TIP_FRICTION {
        let found = trip(&rigid, "trip-block", &theory, o)?;
        let [low, high] = theory.reach.map(|r| theory.trip_speed(r));
        o.expect(
            "speed that trips it, as a block",
            found,
            "m/s",
            Expected::Between(0.95 * low, 1.05 * high),
            "critical sliding velocity √(2 g I₀ (√(h² + b²) − h) / (m h²)), b from the middles of the treads to their outer edges",
        );
    } else {
        o.note("As a block it would need more friction to trip than its tyres have.");
    }
    let sticky = sticky(bench.spec);
    let sticky = Bench::new(&sticky, bench.soils, bench.options.step)?;
    let found = trip(&sticky, "trip", block, o)?;
    // Springs that take the impact lose less than a block does, and let the body lean out.
    let leaning = block.height * tan(block.angle() - radians(10.0));
    o.expect(
        "speed that trips it, as it is",
        found,
        "m/s",
        Expected::Between(block.energy_speed(leaning), 1.05 * block.trip_speed(block.reach[1])),
        "between energy alone, leaning out by 10°, and a block's critical sliding velocity",
    );
    Ok(())
}

/// On its hard tyre, as the cylinder that theory knows, where it has one. Theory's impact has no bounce, neither up nor aside, so
/// both dampings are at least critical for a wheel's share of the mass (kg): a tyre that springs back sideways trips the vehicle
/// by up to twice the impulse.
fn hard(spec: &VehicleSpec, fraction: f64) -> VehicleSpec {
    let mut spec = spec.clone().with_tyre("rigid").unwrap_or_else(|_| spec.clone());
    if let TyreSpec::Rigid(t) = &mut spec.tyre {
        t.dilation = None;
        let critical = |stiffness: f64| 2.0 * (stiffness * fraction).sqrt();
        t.vertical_damping = t.vertical_damping.max(critical(t.vertical_stiffness));
        t.tangential_damping = t.tangential_damping.max(critical(t.tangential_stiffness));
    }
    spec
}

fn slope_in_motion(bench: &Bench<'_>, block: &Block, o: &mut Outcome) -> Result<(), SimError> {
    let rigid = degrees(block.angle());
    let target = bench.pace.within_reach(3.0);
    let world = flat(TIP_FRICTION);
    let mut d = Drive::with_spec(bench, &sticky(bench.spec), "slope-in-motion", &world, 0.0, 0.0)?;
    let drive = |s: &VehicleState| bench.pace.hold_speed(s, target, bench.pace.hold_line(s));
    d.hold(bench.pace.time(3.0), drive)?;
    let (mut angle, mut carried, mut points) = (0.0, f64::NAN, Vec::new());
    while angle < rigid + 8.0 {
        angle += if angle < rigid - 20.0 { 0.05 } else { 0.01 };
        d.tilt(radians(angle));
        let fell = d.run(0.01, drive, |s| s.roll_pitch_yaw().0.abs() > 0.6)?;
        let upper: f64 = d.state().wheels.iter().skip(1).step_by(2).map(|w| w.load).sum();
        if upper > 0.0 {
            carried = angle;
        }
        points.push([angle, upper / bench.geometry.weight()]);
        if fell {
            break;
        }
    }
    o.expect(
        "slope at which it tips in motion",
        carried,
        "°",
        Expected::Between(rigid - 10.0, degrees(atan(block.reach[1] / block.height)) + 0.5),
        "as on the tilt table: below the rigid body's atan(b/h), b to the treads' outer edges, since springs and tyres let the body lean out",
    );
    let mut plot =
        Plot::new("Load on the upper wheels along a side slope", "slope, °", "sum of loads / weight");
    plot.ours("driving", points);
    o.plots.push(plot);
    o.series.push(d.finish());
    Ok(())
}

fn circle(bench: &Bench<'_>, block: &Block, o: &mut Outcome) -> Result<(), SimError> {
    let world = flat(TIP_FRICTION);
    let mut d = Drive::with_spec(bench, &sticky(bench.spec), "circle", &world, 0.0, 0.0)?;
    let window = (bench.pace.time(0.5) / bench.options.step) as usize;
    let begin = d.state().time;
    let (mut lateral, mut airborne) = (Vec::new(), 0.0);
    // From 1 m/s on 0.4 m/s faster each second: steady but for a tenth of the acceleration that tips it.
    let lifted = d.run(
        bench.pace.time(60.0),
        |s| {
            let seconds = (s.time - begin) / bench.pace.time(1.0);
            bench.pace.hold_speed(s, 1.0 + 0.4 * seconds, 0.6)
        },
        |s| {
            lateral.push(s.angular_velocity_body.z * s.velocity_body.x);
            // It turns to the left: the inner wheels are those of even numbers.
            let inner: f64 = s.wheels.iter().step_by(2).map(|w| w.load).sum();
            airborne = if inner > 0.0 { 0.0 } else { airborne + bench.options.step };
            airborne > bench.pace.time(0.1)
        },
    )?;
    let from = lateral.len().saturating_sub(window);
    let mean = lateral[from..].iter().sum::<f64>() / (lateral.len() - from) as f64;
    if lifted {
        let low = GRAVITY * tan(block.angle() - radians(10.0));
        o.expect(
            "lateral acceleration at which it lifts its inner wheels",
            mean,
            "m/s²",
            Expected::Between(low, 1.03 * GRAVITY * block.reach[1] / block.height),
            "equivalence: g tan of the angle at which it tips, between 10° below atan(track / 2 h) and the treads' outer edges",
        );
    } else {
        o.figure("greatest lateral acceleration without lifting inner wheels", mean, "m/s²");
        o.note("It cannot corner fast enough to lift its inner wheels.");
    }
    o.series.push(d.finish());
    Ok(())
}

/// A step of the steering, or one that is reversed as the roll ends, at the grip of a road and at half of what lifts wheels.
fn manoeuvres(
    bench: &Bench<'_>,
    block: &Block,
    name: &str,
    reverses: bool,
    o: &mut Outcome,
) -> Result<(), SimError> {
    let target = bench.pace.within_reach(15.0);
    // Of an undamped spring a step makes twice the deflection; and springs let the body lean out.
    let little = 0.45 * tan(block.angle() - radians(10.0));
    for (label, friction) in [("μ 0.9".to_owned(), 0.9), (format!("μ {little:.2}"), little)] {
        let case =
            format!("{}-{}", name.replace(' ', "-"), if friction == 0.9 { "road" } else { "little-grip" });
        let mut d = Drive::new(bench, &case, &flat(friction), 0.0, 0.0)?;
        let (pace, g) = (bench.pace, &bench.geometry);
        d.run(
            pace.time(40.0),
            |s| pace.hold_speed(s, target + 0.3, pace.hold_line(s)),
            |s| s.velocity_body.x > pace.speed(target),
        )?;
        let begin = d.state().time;
        let window = (pace.time(0.2) / bench.options.step) as usize;
        let (mut speeds, mut roll, mut lateral, mut lifted) = (Vec::new(), 0.0_f64, 0.0_f64, 0.0_f64);
        let (mut airborne, mut reversed) = (0.0, f64::INFINITY);
        d.run(
            pace.time(5.0),
            |s| {
                let since = s.time - begin;
                if reverses && since > pace.time(0.5) && s.angular_velocity_body.x <= 0.0 {
                    reversed = since.min(reversed);
                }
                controls(if since > reversed { -1.0 } else { 1.0 }, 0.0, 0.0)
            },
            |s| {
                let arm = s.attitude.inverse() * (g.com_of(s) - s.position);
                let velocity = s.attitude * (s.velocity_body + s.angular_velocity_body.cross(&arm));
                speeds.push(velocity);
                if let Some(k) = speeds.len().checked_sub(window + 1) {
                    let change = velocity - speeds[k];
                    let mean = vb_math::hypot(change.x, change.y) / (window as f64 * bench.options.step);
                    // On the wheels of one side it rises and falls, by which they bear more and less than the weight.
                    if lifted == 0.0 {
                        lateral = lateral.max(mean);
                    }
                }
                roll = roll.max(s.roll_pitch_yaw().0.abs());
                let side = |first: usize| s.wheels.iter().skip(first).step_by(2).all(|w| w.load <= 0.0);
                airborne = if side(0) || side(1) { airborne + bench.options.step } else { 0.0 };
                lifted = lifted.max(airborne);
                false
            },
        )?;
        let what = if friction == 0.9 { format!("{name}, μ 0.9") } else { format!("{name}, little grip") };
        if friction != 0.9 {
            o.figure(format!("{what}: friction ({label})"), friction, "");
        }
        o.expect(
            &format!("{what}: greatest acceleration over ground, mean over 0.2 s"),
            lateral,
            "m/s²",
            Expected::AtMost(1.05 * bench.grip(friction) * GRAVITY),
            "friction: no more than μ g, and a twentieth for loads that vary",
        );
        o.figure(format!("{what}: greatest roll"), degrees(roll), "°");
        let source = "statics: μ is below 0.45 of what tips it, so that not even twice the roll of a steady corner does";
        let name = format!("{what}: longest time on the wheels of one side");
        o.figure(name.clone(), lifted, "s");
        if friction != 0.9 {
            o.theory(name, Expected::AtMost(0.0), source);
        }
        o.series.push(d.finish());
    }
    Ok(())
}

pub(super) const OVERTURNED: Event = Event {
    name: "overturned",
    title: "On flank and roof",
    about: "Released 5 cm above level ground at μ 0.5, on its right side and on its roof: final pose, roll \
            rate and energy, also at half the time step, and sliding distance on its roof from 5 m/s. Over a boulder under the left wheels at 5 m/s: \
            maximum roll at the time step and at half of it.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: overturned,
};

/// Friction on which it lies.
const LYING: f64 = 0.5;

/// Points with which it may touch the ground in the chassis frame: hull, and faces of wheels that bear it.
fn outline(bench: &Bench<'_>) -> Vec<Vector3<f64>> {
    let g = &bench.geometry;
    let mut points = g.hull.clone();
    for (i, c) in g.corners.iter().enumerate() {
        let hub = g.hub(i, 0.0, 0.0);
        let out = Vector3::y() * (c.side * 0.5 * c.width);
        points.extend((0..24).map(|k| {
            let at = PI * f64::from(k) / 12.0;
            hub + out + Vector3::new(cos(at), 0.0, sin(at)) * c.radius
        }));
    }
    points
}

fn turned(roll: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_axis_angle(&Vector3::x_axis(), roll)
}

/// Height of the centre of mass over the lowest point at a roll (rad), m.
fn height(bench: &Bench<'_>, points: &[Vector3<f64>], roll: f64) -> f64 {
    let turn = turned(roll);
    let com = turn * bench.geometry.com;
    points.iter().map(|p| com.z - (turn * p).z).fold(f64::NEG_INFINITY, f64::max)
}

/// Where it comes to rest if it rolls down from a roll without momentum: the next roll at which its centre of mass is lowest, rad.
fn rests(bench: &Bench<'_>, points: &[Vector3<f64>], mut roll: f64) -> f64 {
    let step = 1e-3;
    let h = |roll: f64| height(bench, points, roll);
    let sign = if h(roll + step) < h(roll) { step } else { -step };
    while h(roll + sign) < h(roll) {
        roll += sign;
    }
    roll
}

/// Put down at a roll with its lowest point so high (full-size m) above the ground.
fn lay(bench: &Bench<'_>, case: &str, roll: f64, clearance: f64) -> Result<Drive, SimError> {
    let points = outline(bench);
    let mut d = Drive::new(bench, case, &flat(LYING), 0.0, 0.0)?;
    let turn = turned(roll);
    let lowest = points.iter().map(|p| (turn * (p - bench.geometry.chassis_com)).z);
    let lowest = lowest.fold(f64::INFINITY, f64::min);
    d.sim().rig().overturn(roll, bench.pace.length(clearance) - lowest);
    Ok(d)
}

/// What springs hold under the weight at their rates at design height, J.
fn held_by_springs(bench: &Bench<'_>) -> f64 {
    let load = bench.geometry.weight() / bench.geometry.corners.len() as f64;
    let axles = bench.spec.axles.iter().zip(bench.model.axles());
    let rates = axles.filter(|(a, _)| !a.suspension.struts.is_empty()).filter_map(|(a, kinematics)| {
        let samples = kinematics.sample(&a.suspension, Motion::Parallel, 3, 1);
        samples.get(1).map(|s| s.wheel_rate)
    });
    rates.filter(|k| *k > 0.0).map(|k| load * load / k).sum()
}

/// Rolls (rad) each hundredth of a second (of the full-size vehicle) of the first second after it was put down with its lowest
/// point so high (full-size m) above the ground.
fn fall(bench: &Bench<'_>, roll: f64, clearance: f64) -> Result<Vec<f64>, SimError> {
    let mut d = lay(bench, "fall", roll, clearance)?;
    let mut rolls = Vec::new();
    for _ in 0..100 {
        d.hold(bench.pace.time(0.01), |_| PARKED)?;
        rolls.push(d.state().roll_pitch_yaw().0);
    }
    Ok(rolls)
}

fn convergence(o: &mut Outcome, name: &str, value: f64, unit: &'static str, most: f64, bench: &Bench<'_>) {
    o.figure(name, value, unit);
    o.theory.push(Expectation {
        figure: name.to_owned(),
        expected: Expected::AtMost(most),
        kind: Kind::Convergence,
        source: format!("the same at {} ms", 0.5e3 * bench.options.step),
        unsound: None,
    });
}

fn overturned(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let g = &bench.geometry;
    let pace = bench.pace;
    let points = outline(bench);
    let mut plot = Plot::new("Roll of the overturned vehicle", "t, s", "roll, °");
    for (label, roll) in [("flank", FRAC_PI_2), ("roof", PI)] {
        let mut d = lay(bench, label, roll, 0.05)?;
        let begin = d.state().time;
        let put = d.state();
        let (first, high) = (g.mechanical_energy(&put), g.com_of(&put).z);
        let (mut excess, mut rate, mut lowest) = (f64::NEG_INFINITY, 0.0_f64, high);
        let mut trace = Vec::new();
        let lies = d.run(
            pace.time(10.0),
            |_| PARKED,
            |s| {
                excess = excess.max(g.mechanical_energy(s) - first);
                rate = rate.max(s.angular_velocity_body.x.abs());
                lowest = lowest.min(g.com_of(s).z);
                trace.push([s.time - begin, degrees(s.roll_pitch_yaw().0).rem_euclid(360.0)]);
                false
            },
        );
        let diverged = match lies {
            Err(SimError::Diverged { time, what, .. }) => {
                o.note(format!("{label}: the simulation diverges at {time:.2} s: {what}"));
                true
            }
            other => other?,
        };
        let s = d.state();
        o.expect(
            &format!(
                "{label}: greatest excess of energy over the weight and the height of the centre of mass"
            ),
            100.0 * excess / (g.weight() * high),
            "%",
            Expected::AtMost(1.0 + 100.0 * held_by_springs(bench) / (g.weight() * high)),
            "conservation: 1 %, and F²/2k of every wheel for what its spring holds as it is put down",
        );
        o.expect(
            &format!("{label}: greatest roll rate"),
            rate,
            "rad/s",
            Expected::AtMost(
                (2.0 * g.weight() * (high - lowest) / g.roll_inertia()).sqrt() * 1.02 + 0.02 / pace.time(1.0),
            ),
            "energy: √(2 m g Δz / I) of the height that it loses",
        );
        if diverged {
            o.series.push(d.finish());
            continue;
        }
        o.expect(
            &format!("{label}: speed after 10 s"),
            s.velocity_body.norm(),
            "m/s",
            Expected::AtMost(pace.speed(0.02)),
            "at rest",
        );
        let end = degrees(s.roll_pitch_yaw().0).rem_euclid(360.0);
        o.expect(
            &format!("{label}: roll at the end"),
            end,
            "°",
            Expected::Within {
                value: degrees(rests(bench, &points, roll)).rem_euclid(360.0),
                tolerance: 10.0,
            },
            "statics: the next roll at which hull and wheels hold the centre of mass lowest",
        );
        plot.ours(label, trace.into_iter().step_by(10).collect());
        o.series.push(d.finish());
        let half = bench.at_step(0.5 * bench.options.step);
        let from = roll - 0.3;
        let ours = fall(bench, from, 0.3)?;
        let apart = |other: &[f64]| {
            let apart = ours.iter().zip(other).map(|(a, b)| vb_math::angle::wrap(a - b).abs());
            degrees(apart.fold(0.0, f64::max))
        };
        // How much the impacts of that second make of a difference that nobody would measure.
        let mut moved = 0.0_f64;
        for height in [0.299, 0.301] {
            moved = moved.max(apart(&fall(bench, from, height)?));
        }
        o.figure(format!("{label}: change of the roll if it falls from 1/300 higher or lower"), moved, "°");
        let apart = apart(&fall(&half, from, 0.3)?);
        convergence(
            &mut o,
            &format!(
                "{label}: change of the roll at half the step, first second of a fall of 0.3 m onto an edge"
            ),
            apart,
            "°",
            2.0,
            bench,
        );
    }
    o.plots.push(plot);
    slide(bench, &mut o)?;
    boulder(bench, &mut o)?;
    Ok(o)
}

/// Sliding on the roof.
fn slide(bench: &Bench<'_>, o: &mut Outcome) -> Result<(), SimError> {
    let pace = bench.pace;
    let mut d = lay(bench, "slide", PI, 0.02)?;
    d.hold(pace.time(6.0), |_| PARKED)?;
    let up = d.state().attitude * Vector3::z();
    if up.z > -0.7 {
        o.note("It does not stay on its roof, so it does not slide on it.");
        return Ok(());
    }
    let (speed, friction) = (pace.speed(5.0), LYING.min(bench.spec.chassis.friction));
    // It stays on its roof while friction's moment is less than that of the weight about the roof's front edge.
    let points = outline(bench);
    let top = points.iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
    let edge = points
        .iter()
        .filter(|p| p.z > top - pace.length(0.01))
        .map(|p| p.x)
        .fold(f64::NEG_INFINITY, f64::max);
    let com = bench.geometry.com;
    if edge - com.x < 1.1 * friction * (top - com.z) {
        o.note("Friction would tip it over the front edge of its roof, so it does not slide on it.");
        return Ok(());
    }
    let from = bench.geometry.com_of(&d.state());
    d.sim().rig().throw([speed, 0.0, 0.0]);
    d.run(pace.time(6.0), |_| PARKED, |s| s.velocity_body.norm() < pace.speed(0.01))?;
    let way = (bench.geometry.com_of(&d.state()) - from).norm();
    o.expect(
        "roof: way of a slide from 5 m/s",
        way,
        "m",
        Expected::fraction(speed * speed / (2.0 * friction * GRAVITY), 0.05),
        "v² / 2 μ g",
    );
    o.series.push(d.finish());
    Ok(())
}

/// A boulder under the wheels of the left side, 0.3 m high.
fn boulder(bench: &Bench<'_>, o: &mut Outcome) -> Result<(), SimError> {
    let pace = bench.pace;
    let target = pace.within_reach(5.0);
    let world =
        relief(40.0, 8.0, 0.1, 0.9, |x, y| if x.abs() < 0.5 && y > 0.15 { 0.3 * cos(PI * x) } else { 0.0 });
    let cross = |bench: &Bench<'_>| -> Result<(f64, Drive), SimError> {
        let mut d = Drive::new(bench, "boulder", &world, -15.0, 0.0)?;
        let mut roll = 0.0_f64;
        d.run(
            pace.time(20.0),
            |s| pace.hold_speed(s, target, pace.hold_line(s)),
            |s| {
                roll = roll.max(s.roll_pitch_yaw().0.abs());
                s.position.x > pace.length(12.0)
            },
        )?;
        Ok((degrees(roll), d))
    };
    let (roll, d) = cross(bench)?;
    let (half, _) = cross(&bench.at_step(0.5 * bench.options.step))?;
    o.figure("boulder: greatest roll", roll, "°");
    convergence(
        o,
        "boulder: change of the greatest roll at half the step",
        (roll - half).abs(),
        "°",
        0.5,
        bench,
    );
    o.series.push(d.finish());
    Ok(())
}
