//! Cornering on level ground.

use crate::bench::Bench;
use crate::check::Expected;
use crate::event::{Event, LineKind, Outcome, Place, Plot, Vehicles};
use crate::grounds::flat;
use crate::pace::{PARKED, speed};
use crate::rig::Drive;
use vb_math::angle::degrees;
use vb_math::{atan, hypot};
use vb_sim::{SimError, VehicleState};
use vb_vehicle::GRAVITY;

pub(super) const CORNERING: Event = Event {
    name: "cornering",
    title: "Constant steering",
    about: "Fixed steering from rest to 4 m/s under the speed controller, 20 s; means of the last 10 s. Also to the right, at \
            μ 0.5, at 2 and at 8 m/s.",
    vehicles: Vehicles::Steered,
    place: Place::Rigid,
    run: cornering,
};

/// Means over the last seconds of a drive.
#[derive(Default)]
struct Means {
    count: f64,
    yaw_rate: f64,
    speed: f64,
    roll: f64,
    lateral: f64,
    /// Velocity of the reference point forward and to the left, m/s.
    velocity: [f64; 2],
    /// Of each wheel, m.
    travels: Vec<f64>,
}

impl Means {
    fn add(&mut self, s: &VehicleState) {
        self.count += 1.0;
        self.yaw_rate += s.angular_velocity_body.z;
        self.speed += speed(s);
        self.roll += degrees(s.roll_pitch_yaw().0);
        self.lateral += s.angular_velocity_body.z * s.velocity_body.x;
        self.velocity[0] += s.velocity_body.x;
        self.velocity[1] += s.velocity_body.y;
        self.travels.resize(s.wheels.len(), 0.0);
        self.travels.iter_mut().zip(&s.wheels).for_each(|(sum, w)| *sum += w.deflection);
    }

    /// Mean travels of the wheels, m.
    fn travels(&self) -> Vec<f64> {
        self.travels.iter().map(|sum| self.of(*sum)).collect()
    }

    /// Velocity to the left (m/s) of the point of the centre line so far (m) in front of the reference point.
    fn aside(&self, ahead: f64) -> f64 {
        self.of(self.velocity[1]) + self.of(self.yaw_rate) * ahead
    }

    fn of(&self, sum: f64) -> f64 {
        sum / self.count
    }
}

/// Radius (m) of the path of the reference point if the wheels roll without slip about one centre, with these travels (m).
fn kinematic_radius(bench: &Bench<'_>, travels: &[f64], steering: f64) -> f64 {
    let g = &bench.geometry;
    let Some(to_rear_axle) = g.rolling_centre(travels, steering) else { return f64::INFINITY };
    hypot(to_rear_axle, g.turning_line())
}

/// Steady means of a drive with fixed steering, a target speed and a friction; and the drive.
fn steady(bench: &Bench<'_>, steering: f64, target: f64, friction: f64) -> Result<(Means, Drive), SimError> {
    let speed = bench.pace.speed_label(target);
    let case = format!("steering-{steering}-{speed}-mu-{friction:.1}");
    let mut d = Drive::new(bench, &case, &flat(friction), 0.0, 0.0)?;
    let drive = |s: &VehicleState| bench.pace.hold_speed(s, target, steering);
    d.hold(10.0, drive)?;
    let mut m = Means::default();
    d.run(10.0, drive, |s| {
        m.add(s);
        false
    })?;
    Ok((m, d))
}

/// Radius (m) of the path of the reference point at 4 m/s and μ 0.9.
pub(super) fn radius(bench: &Bench<'_>, steering: f64) -> Result<f64, SimError> {
    let m = steady(bench, steering, 4.0, 0.9)?.0;
    Ok((m.speed / m.yaw_rate).abs())
}

/// What each end of the vehicle does to its radius: how fast the axles that aren't steered move sideways, towards the centre
/// of the circle, and the radius on which the steered axle's direction would lead it if they didn't.
fn directions(bench: &Bench<'_>, m: &Means, steering: f64, label: &str, o: &mut Outcome) {
    let g = &bench.geometry;
    let Some(front) = (0..g.corners.len()).find(|&i| g.is_steered(i)) else { return };
    let (ahead, behind) = (g.hub(front, 0.0, 0.0).x, g.turning_line());
    let side = if steering > 0.0 { 1.0 } else { -1.0 };
    o.figure(format!("{label}: sideways speed of the rear"), 1e3 * side * m.aside(behind), "mm/s");
    let slope = (m.aside(ahead) / m.of(m.velocity[0])).abs();
    let radius = hypot((ahead - behind) / slope, behind);
    o.figure(format!("{label}: radius by the direction of the front"), radius, "m");
}

fn cornering(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let mut plot = Plot::map("Paths", "x, m", "y, m");
    let cases = [
        (0.25, 4.0, 0.9),
        (0.5, 4.0, 0.9),
        (-0.5, 4.0, 0.9),
        (1.0, 4.0, 0.9),
        (0.5, 4.0, 0.5),
        (0.5, 2.0, 0.9),
        (0.25, 8.0, 0.9),
    ];
    for (steering, target, friction) in cases.into_iter().filter(|c| bench.pace.reaches(c.1)) {
        let speed = bench.pace.speed_label(target);
        let label = format!("steering {steering}, {speed} m/s, μ {friction:.1}");
        let (m, d) = steady(bench, steering, target, friction)?;
        let radius = (m.of(m.speed) / m.of(m.yaw_rate)).abs();
        o.figure(format!("{label}: radius"), radius, "m");
        o.figure(format!("{label}: yaw rate"), m.of(m.yaw_rate), "rad/s");
        o.figure(format!("{label}: lateral acceleration"), m.of(m.lateral), "m/s²");
        o.figure(format!("{label}: roll"), m.of(m.roll), "°");
        directions(bench, &m, steering, &label, &mut o);
        o.theory(
            format!("{label}: radius"),
            Expected::AtLeast(0.97 * kinematic_radius(bench, &m.travels(), steering)),
            "wheels that roll without slip about one centre, as the links turn them in the corner; slip angles only widen it",
        );
        let a = m.of(m.lateral);
        if bench.winds_up() {
            let series = d.finish();
            if friction == 0.9 && target == 4.0 {
                plot.ours(format!("steering {steering}"), series.pairs("x", "y"));
            }
            o.series.push(series);
            continue;
        }
        o.theory(
            format!("{label}: roll"),
            if a > 0.0 { Expected::AtLeast(0.0) } else { Expected::AtMost(0.0) },
            "the body rolls outwards, because its centre of mass is above the ground",
        );
        let series = d.finish();
        if friction == 0.9 && target == 4.0 {
            plot.ours(format!("steering {steering}"), series.pairs("x", "y"));
        }
        o.series.push(series);
    }
    o.plots.push(plot);
    Ok(o)
}

pub(super) const STEP_STEER: Event = Event {
    name: "step-steer",
    title: "Step steer at 8 m/s",
    about: "Straight at 8 m/s for 9 s, then a step of the steering command; speed controller on.",
    vehicles: Vehicles::Steered,
    place: Place::Rigid,
    run: step_steer,
};

fn step_steer(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let target = bench.pace.within_reach(8.0);
    let mut yaw = Plot::new("Yaw rate after the step", "t, s", "yaw rate, rad/s");
    let mut lean = Plot::new("Roll after the step", "t, s", "roll, °");
    for steering in [0.25, 0.5, 1.0] {
        let label = format!("steering {steering}");
        let mut d = Drive::new(bench, &format!("steering-{steering}"), &flat(0.9), 0.0, 0.0)?;
        d.hold(9.0, |s| bench.pace.hold_speed(s, target, bench.pace.hold_line(s)))?;
        let begin = d.state().time;
        let (mut rates, mut roll, mut m) = (Vec::new(), 0.0_f64, Means::default());
        d.run(
            5.0,
            |s| bench.pace.hold_speed(s, target, steering),
            |s| {
                rates.push([s.time - begin, s.angular_velocity_body.z]);
                if s.time - begin > 3.0 {
                    m.add(s);
                }
                roll = roll.max(s.roll_pitch_yaw().0.abs());
                false
            },
        )?;
        let last: Vec<f64> = rates.iter().filter(|r| r[0] > 3.0).map(|r| r[1]).collect();
        let steady = last.iter().sum::<f64>() / last.len() as f64;
        let peak = rates.iter().map(|r| r[1]).fold(0.0, f64::max);
        let rise = rates.iter().find(|r| r[1] >= 0.9 * steady).map_or(f64::NAN, |r| r[0]);
        o.figure(format!("{label}: steady yaw rate"), steady, "rad/s");
        o.figure(format!("{label}: peak yaw rate"), peak, "rad/s");
        o.figure(format!("{label}: time to 90 %"), rise, "s");
        o.figure(format!("{label}: greatest roll"), degrees(roll), "°");
        o.theory(
            format!("{label}: steady yaw rate"),
            Expected::AtMost(1.03 * bench.pace.speed(target) / kinematic_radius(bench, &m.travels(), steering)),
            "v / R with wheels that roll without slip, as the links turn them in the corner; slip angles only lower it",
        );
        let series = d.finish();
        let after = |name: &str| {
            let points = series.pairs("t", name).into_iter().filter(|p| p[0] >= begin);
            points.map(|p| [p[0] - begin, p[1]]).collect::<Vec<_>>()
        };
        yaw.ours(label.clone(), after("yaw rate"));
        lean.ours(label, after("roll"));
        o.series.push(series);
    }
    o.plots.extend([yaw, lean]);
    Ok(o)
}

pub(super) const BODY_ROLL: Event = Event {
    name: "body-roll",
    title: "Body roll in a corner and on a tilt table",
    about: "Steady corners at 8 m/s, and the vehicle standing on a table tilted until gravity has the same component along \
            the table: according to the equivalence principle the body must roll by the same angle.",
    vehicles: Vehicles::Steered,
    place: Place::Rigid,
    run: body_roll,
};

/// The roll of the gentlest corner per lateral acceleration, °/g, beside that of springs and tyres.
fn gentle_roll(bench: &Bench<'_>, o: &mut Outcome, gradient: f64) {
    o.figure("roll gradient", gradient, "°/g");
    if let Some(expected) = bench.characteristics().roll_gradient_deg_per_g {
        o.theory(
            "roll gradient",
            Expected::fraction(expected, 0.15),
            "W h / (K - W h) of suspensions and tyres in series (Gillespie, ch. 6)",
        );
    }
}

fn body_roll(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let target = bench.pace.within_reach(8.0);
    let mut plot = Plot::new("Roll over lateral acceleration", "lateral acceleration, m/s²", "roll, °");
    let (mut corner, mut table) = (vec![[0.0, 0.0]], vec![[0.0, 0.0]]);
    for steering in [0.15, 0.25, 0.35, 0.5] {
        let mut d = Drive::new(bench, &format!("corner-{steering}"), &flat(0.9), 0.0, 0.0)?;
        d.hold(15.0, |s| bench.pace.hold_speed(s, target, steering))?;
        let mut m = Means::default();
        d.run(
            5.0,
            |s| bench.pace.hold_speed(s, target, steering),
            |s| {
                m.add(s);
                false
            },
        )?;
        let lateral = m.of(m.lateral);
        corner.push([lateral, m.of(m.roll)]);
        o.series.push(d.finish());
        // In a left corner the body leans to the right; the table leans the vehicle to its left.
        let mut d = Drive::new(bench, &format!("table-{steering}"), &flat(0.9), 0.0, 0.0)?;
        let upright = degrees(d.state().roll_pitch_yaw().0);
        let angle = atan(lateral / GRAVITY);
        for k in 1..=400 {
            d.tilt(angle * f64::from(k) / 400.0);
            d.hold(0.01, |_| PARKED)?;
        }
        d.hold(2.0, |_| PARKED)?;
        let lean = upright - degrees(d.state().roll_pitch_yaw().0);
        // On the table the load is smaller by the cosine, so springs and tyres see a / g = tan of the angle, as in the corner,
        // at a weight of m g cos: the lean is that of the corner but for this factor.
        let lean = lean / vb_math::cos(angle);
        table.push([lateral, lean]);
        o.series.push(d.finish());
        let name = format!("steering {steering}: roll in the corner");
        o.figure(format!("steering {steering}: lateral acceleration"), lateral, "m/s²");
        o.figure(format!("steering {steering}: roll on the table"), lean, "°");
        if table.len() == 2 {
            gentle_roll(bench, &mut o, lean * GRAVITY / lateral);
        }
        o.figure(name.clone(), m.of(m.roll), "°");
        // Locked differentials push the sides of the vehicle against each other, and so its links up and down.
        if !bench.winds_up() {
            let source = "equivalence: the roll on a table tilted by atan(a/g), over cos";
            o.theory(name, Expected::fraction(lean, 0.15), source);
        }
    }
    plot.line(LineKind::Ours, 0, "in the corner", corner);
    plot.line(LineKind::Theory, 0, "on the tilt table", table);
    o.plots.push(plot);
    Ok(o)
}
