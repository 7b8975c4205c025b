//! Straight up planes of growing steepness.

use crate::bench::Bench;
use crate::check::Expected;
use crate::event::{Event, Outcome, Place, Plot, Series, Vehicles};
use crate::grounds::plane;
use crate::pace::{PARKED, controls, speed};
use crate::rig::{Drive, largest};
use vb_math::angle::{degrees, radians};
use vb_math::atan;
use vb_sim::{Controls, SimError, VehicleState};

/// How a slope is driven.
#[derive(Clone, Copy, PartialEq)]
enum Driver {
    /// The original's 4 m/s controller.
    Held,
    /// All the throttle there is, after 3 s of brakes.
    Full,
}

impl Driver {
    fn controls(self, bench: &Bench<'_>, s: &VehicleState) -> Controls {
        match self {
            Self::Held => bench.pace.hold_speed(s, 4.0, bench.pace.hold_line(s)),
            Self::Full => controls(bench.pace.hold_line(s), 1.0, 0.0),
        }
    }
}

/// Progress along the slope (m) and whether it counts as climbed, by the rules of the reference runs: 20 m within 20 s
/// under the controller; with full throttle more than 5 m within 12 s, and still moving up at the end.
fn climb(bench: &Bench<'_>, driver: Driver, slope: f64, friction: f64) -> Result<(bool, Series), SimError> {
    let angle = radians(slope);
    let mut d =
        Drive::new(bench, &format!("{slope:.2}-mu-{friction:.1}"), &plane(angle, friction), 0.0, 0.0)?;
    let along = |s: &VehicleState| s.position.x / vb_math::cos(angle);
    let climbed = match driver {
        Driver::Held => {
            let from = along(&d.state());
            let (time, goal) = (bench.pace.time(20.0), bench.pace.length(20.0));
            d.run(time, |s| driver.controls(bench, s), |s| (along(s) - from).abs() >= goal)?;
            along(&d.state()) - from >= goal
        }
        Driver::Full => {
            d.hold(3.0, |_| PARKED)?;
            let from = along(&d.state());
            let (time, far) = (bench.pace.time(12.0), bench.pace.length(150.0));
            d.run(time, |s| driver.controls(bench, s), |s| (along(s) - from).abs() >= far)?;
            let s = d.state();
            along(&s) - from > bench.pace.length(5.0)
                && (s.attitude * s.velocity_body).x > bench.pace.speed(0.3)
        }
    };
    Ok((climbed, d.finish()))
}

/// The steepest plane that is climbed, °, to a quarter of a degree.
fn steepest(bench: &Bench<'_>, o: &mut Outcome, driver: Driver, friction: f64) -> Result<f64, SimError> {
    let mut best = None;
    let limit = largest(2.0, 46.0, 0.25, |slope| {
        let (climbed, series) = climb(bench, driver, slope, friction)?;
        if climbed {
            best = Some(series);
        }
        Ok(climbed)
    })?;
    o.series.extend(best);
    Ok(limit)
}

/// Theory: no wheel can push with more than μ times its load, so the climb ends at atan μ at the latest.
pub(super) fn friction_bound(o: &mut Outcome, figure: String, friction: f64) {
    let bound = degrees(atan(friction)) + 0.5;
    o.theory(figure, Expected::AtMost(bound), "friction: atan μ, plus 0.5° for the momentum it starts with");
}

pub(super) const GRADE_HELD: Event = Event {
    name: "grade-controller",
    title: "Steepest grade under the speed controller",
    about: "The original's 4 m/s controller and pursuit law, straight up planes: the steepest on which it covers 20 m within \
            20 s.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: grade_held,
};

fn grade_held(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let mut plot = Plot::new("Speed on the steepest grade climbed", "t, s", "speed, m/s");
    for friction in [0.9, 0.5, 0.3] {
        let name = format!("μ {friction:.1}: steepest grade");
        let limit = steepest(bench, &mut o, Driver::Held, friction)?;
        o.figure(name.clone(), limit, "°");
        friction_bound(&mut o, name, friction);
        // The reference knows even degrees only.
        o.figure(format!("μ {friction:.1}: last even degree climbed"), 2.0 * (0.5 * limit).floor(), "°");
        if let Some(s) = o.series.last() {
            plot.ours(format!("μ {friction:.1}, {limit:.1}°"), s.pairs("t", "vx"));
        }
    }
    o.plots.push(plot);
    Ok(o)
}

pub(super) const GRADE_FULL: Event = Event {
    name: "grade-full-throttle",
    title: "Steepest grade with full throttle",
    about: "3 s with brakes, then full throttle for 12 s with heading control: the steepest plane on which it covers 5 m and still \
            climbs at the end. Spinning wheels have less grip.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: grade_full,
};

fn grade_full(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let mut plot = Plot::new("Speed on the steepest grade climbed", "t, s", "speed, m/s");
    for friction in [0.9, 0.5] {
        let name = format!("μ {friction:.1}: steepest grade");
        let limit = steepest(bench, &mut o, Driver::Full, friction)?;
        o.figure(name.clone(), limit, "°");
        friction_bound(&mut o, name, friction);
        if let Some(s) = o.series.last() {
            plot.ours(format!("μ {friction:.1}, {limit:.1}°"), s.pairs("t", "vx"));
        }
    }
    o.plots.push(plot);
    Ok(o)
}

pub(super) const GRADE_PUBLISHED: Event = Event {
    name: "grade-60-percent",
    title: "60 % grade",
    about: "The grade of the data sheet (60 %, 31°) at μ 0.8 under the 4 m/s controller for 15 s.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: grade_published,
};

fn grade_published(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let mut d = Drive::new(bench, "60-percent", &plane(atan(0.6), 0.8), 0.0, 0.0)?;
    d.hold(15.0, |s| Driver::Held.controls(bench, s))?;
    let s = d.state();
    let up = if s.velocity_body.x > 0.0 { speed(&s) } else { -speed(&s) };
    o.figure("speed after 15 s", up, "m/s");
    let series = d.finish();
    let mut plot = Plot::new("Speed on 60 %", "t, s", "speed, m/s");
    plot.ours("μ 0.8", series.pairs("t", "vx"));
    o.plots.push(plot);
    o.series.push(series);
    Ok(o)
}
