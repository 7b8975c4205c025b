//! The vehicle on soil.

use crate::bench::Bench;
use crate::check::{Expectation, Expected, Kind};
use crate::event::{Event, LineKind, Outcome, Place, Plot, Vehicles};
use crate::grounds::soil;
use crate::pace::{COASTING, PARKED, controls};
use crate::rig::{Drive, largest};
use vb_math::angle::radians;
use vb_math::cos;
use vb_sim::{SimError, SoilSet, VehicleState};
use vb_world::TerrainClass;

/// The set with the soils and the law of the runs of Project Chrono.
const REFERENCE_SET: &str = "original";
const CLASSES: [TerrainClass; 3] = [TerrainClass::Snow, TerrainClass::Mud, TerrainClass::Sand];

/// The reference's soils, or a note that there are none.
fn reference_set<'a>(bench: &Bench<'a>, o: &mut Outcome) -> Option<&'a SoilSet> {
    let set = bench.soils.iter().find(|s| s.name == REFERENCE_SET);
    if set.is_none() {
        o.note(format!("The soil set {REFERENCE_SET} is missing: not run."));
    }
    set
}

/// Mean sinkage of the front and of the rear wheels, m; of a track's road wheels, which lie between its ends.
fn sinkage(bench: &Bench<'_>, s: &VehicleState) -> [f64; 2] {
    let mean = |w: &[vb_sim::WheelState]| w.iter().map(|w| w.sinkage).sum::<f64>() / w.len() as f64;
    let ends = if bench.spec.tracks.is_some() { 2 } else { 0 };
    let wheels = &s.wheels[ends..s.wheels.len() - ends];
    [mean(&wheels[..2]), mean(&wheels[wheels.len() - 2..])]
}

pub(super) const REST: Event = Event {
    name: "soil-rest",
    title: "Sinkage at rest",
    about: "The vehicle is placed on level soil for 5 s without commands; loads are means of the last second; soils of \
            the original.",
    vehicles: Vehicles::All,
    place: Place::Soil,
    run: rest,
};

fn rest(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let Some(set) = reference_set(bench, &mut o) else { return Ok(o) };
    for class in CLASSES {
        let mut d = Drive::on_soil(bench, set, class.name(), &soil(class, 40.0, 20.0, 0.0), 0.0)?;
        d.hold(4.0, |_| COASTING)?;
        // The mean of a second: with nothing pressed a vehicle may rock in its ruts by millimetres.
        let (mut total, mut steps) = (0.0, 0.0);
        d.hold(1.0, |s| {
            total += s.wheels.iter().map(|w| w.load).sum::<f64>();
            steps += 1.0;
            COASTING
        })?;
        let s = d.state();
        let [front, rear] = sinkage(bench, &s);
        let name = class.name();
        o.figure(format!("{name}: sinkage front"), 1e3 * front, "mm");
        o.figure(format!("{name}: sinkage rear"), 1e3 * rear, "mm");
        let sum = total / steps;
        let weight = bench.geometry.weight();
        let (expected, source) = if d.sim().contact_steps() > 0 {
            (
                Expected::Between(0.0, 1.01 * weight),
                "weight m g, less the load on the hull, which rests on the soil",
            )
        } else {
            (Expected::fraction(weight, 0.01), "weight m g")
        };
        o.expect(&format!("{name}: sum of wheel loads"), sum, "N", expected, source);
        o.series.push(d.finish());
    }
    Ok(o)
}

pub(super) const ACCELERATION: Event = Event {
    name: "soil-acceleration",
    title: "Acceleration on soil",
    about: "2 s at rest, then a throttle step for 10 s on level soil with heading control; soils of the original.",
    vehicles: Vehicles::All,
    place: Place::Soil,
    run: acceleration,
};

/// Speed (m/s) after 10 s of a throttle.
fn speed_after(
    bench: &Bench<'_>,
    set: &SoilSet,
    class: TerrainClass,
    throttle: f64,
) -> Result<(f64, Drive), SimError> {
    let case = format!("{}-{throttle:.1}", class.name());
    let mut d = Drive::on_soil(bench, set, &case, &soil(class, 300.0, 40.0, 0.0), -140.0)?;
    d.hold(2.0, |_| PARKED)?;
    d.hold(bench.pace.time(10.0), |s| controls(bench.pace.hold_line(s), throttle, 0.0))?;
    Ok((d.state().velocity_body.x, d))
}

fn acceleration(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let Some(set) = reference_set(bench, &mut o) else { return Ok(o) };
    for class in CLASSES {
        let mut plot = Plot::new(&format!("Speed on {}", class.name()), "t, s", "speed, m/s");
        for throttle in [0.3, 0.6, 1.0] {
            let (v, d) = speed_after(bench, set, class, throttle)?;
            let slip = {
                let s = d.state();
                let rim = s.wheels.iter().map(|w| w.speed).sum::<f64>() / s.wheels.len() as f64;
                1.0 - s.velocity_body.x / (rim * bench.geometry.radius)
            };
            o.figure(format!("{}, throttle {throttle:.1}: speed after 10 s", class.name()), v, "m/s");
            o.figure(format!("{}, throttle {throttle:.1}: slip after 10 s", class.name()), slip, "");
            let series = d.finish();
            let [from, to] = SPAN.map(|v| {
                let past = series.pairs("t", "vx").into_iter().find(|p| p[1] >= bench.pace.speed(v));
                past.map_or(f64::NAN, |p| p[0])
            });
            if from.is_finite() {
                let speeds = SPAN.map(|v| bench.pace.speed_label(v));
                let name = format!(
                    "{}, throttle {throttle:.1}: time from {} to {} m/s",
                    class.name(),
                    speeds[0],
                    speeds[1]
                );
                o.figure(name, to - from, "s");
            }
            let points =
                series.pairs("t", "vx").into_iter().filter(|p| p[0] >= 2.0).map(|p| [p[0] - 2.0, p[1]]);
            plot.ours(format!("throttle {throttle:.1}"), points.collect());
            o.series.push(series);
        }
        o.plots.push(plot);
        let stays = largest(0.1, 1.0, 0.005, |throttle| {
            Ok(speed_after(bench, set, class, throttle)?.0 < bench.pace.speed(MOVES))
        })?;
        o.figure(format!("{}: throttle above which it gets out of its hole", class.name()), stays, "");
    }
    Ok(o)
}

/// Speeds between which the time is taken, m/s of a full-size vehicle.
const SPAN: [f64; 2] = [10.0, 18.0];
/// Speed at which it has got out of the hole in which it stood, m/s of a full-size vehicle.
const MOVES: f64 = 0.2;

pub(super) const GRADE: Event = Event {
    name: "soil-grade",
    title: "Steepest grade on soil",
    about: "The original's 4 m/s controller and pursuit law, straight up slopes of soil: the steepest on which it covers 20 m \
            within 20 s and still moves up at 2 m/s; soils of the original.",
    vehicles: Vehicles::All,
    place: Place::Soil,
    run: grade,
};

/// Grades on which the reference was driven, °.
const GRADES: [f64; 9] = [5.0, 10.0, 15.0, 18.0, 20.0, 22.0, 25.0, 28.0, 30.0];

fn grade(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let Some(set) = reference_set(bench, &mut o) else { return Ok(o) };
    for class in CLASSES {
        let mut best = None;
        let limit = largest(2.0, 36.0, 0.5, |slope| {
            let angle = radians(slope);
            let ground = soil(class, 110.0, 60.0, angle);
            let mut d = Drive::on_soil(bench, set, &format!("{}-{slope:.1}", class.name()), &ground, -45.0)?;
            let along = |s: &VehicleState| s.position.x / cos(angle);
            let from = along(&d.state());
            let (time, far) = (bench.pace.time(20.0), bench.pace.length(60.0));
            let drive = |s: &VehicleState| bench.pace.hold_speed(s, 4.0, bench.pace.hold_line(s));
            d.run(time, drive, |s| (along(s) - from).abs() >= far)?;
            let s = d.state();
            let climbed = along(&s) - from >= bench.pace.length(20.0)
                && (s.attitude * s.velocity_body).x / cos(angle) >= bench.pace.speed(2.0);
            if climbed {
                best = Some(d.finish());
            }
            Ok(climbed)
        })?;
        o.figure(format!("{}: steepest grade", class.name()), limit, "°");
        let last = GRADES.into_iter().filter(|g| *g <= limit).fold(0.0, f64::max);
        o.figure(format!("{}: last grade of the reference's series climbed", class.name()), last, "°");
        o.series.extend(best);
    }
    Ok(o)
}

pub(super) const GRID: Event = Event {
    name: "soil-grid",
    title: "Convergence over the soil's grid",
    about: "Sinkage at rest and speed after 10 s at throttle 0.6, with soil cells of twice, \
            once, half and a quarter of the default size; soils of the original. The middle two must agree within 5 %.",
    vehicles: Vehicles::All,
    place: Place::Soil,
    run: grid,
};

fn grid(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let Some(set) = reference_set(bench, &mut o) else { return Ok(o) };
    let mut plot = Plot::new("Deviation from the finest grid", "resolution, m", "deviation, %");
    let resolution = bench.options.soil_resolution;
    let factors = [2.0, 1.0, 0.5, 0.25];
    for (case, class) in CLASSES.into_iter().enumerate() {
        let mut values = Vec::new();
        for factor in factors {
            let at = bench.at_resolution(factor * resolution);
            let mut d = Drive::on_soil(&at, set, "rest", &soil(class, 40.0, 20.0, 0.0), 0.0)?;
            d.hold(2.0, |_| PARKED)?;
            values.push([1e3 * sinkage(bench, &d.state())[0], speed_after(&at, set, class, 0.6)?.0]);
        }
        for (k, what) in ["sinkage at rest", "speed after 10 s"].into_iter().enumerate() {
            let name = format!("{}: change of {what} from cells half as wide", class.name());
            o.figure(name.clone(), 100.0 * (values[1][k] / values[2][k] - 1.0).abs(), "%");
            o.theory.push(Expectation {
                figure: name,
                expected: Expected::AtMost(5.0),
                kind: Kind::Convergence,
                source: format!("the same with cells of {} m", 0.5 * resolution),
                unsound: None,
            });
            let points = factors
                .iter()
                .zip(&values)
                .map(|(f, v)| [f * resolution, 100.0 * (v[k] / values[3][k] - 1.0)]);
            plot.line(LineKind::Ours, 2 * case + k, format!("{}, {what}", class.name()), points.collect());
        }
    }
    o.plots.push(plot);
    Ok(o)
}
