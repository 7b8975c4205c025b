//! Granular beds: the material, a single wheel of the vehicle, and the vehicle.

use crate::bench::Bench;
use crate::check::{Expectation, Expected, Kind};
use crate::event::{Event, Outcome, Place, Plot, Vehicles};
use crate::grounds::bed;
use crate::pace::{PARKED, controls};
use crate::rig::Drive;
use vb_granular::rig::{Traction, Wheel, angle_of_repose, balance, bekker, plate};
use vb_granular::{Bin, MaterialFile, Packing, PackingError, Settings};
use vb_math::angle::degrees;
use vb_sim::SimError;
use vb_vehicle::GRAVITY;
use vb_world::GranularMaterial;

fn gravel() -> GranularMaterial {
    MaterialFile::resolve("gravel").expect("a material that comes with the program").grains
}

fn unfilled(source: PackingError) -> SimError {
    SimError::Bed { world: "rig".into(), source }
}

pub(super) const MATERIAL: Event = Event {
    name: "grains",
    title: "Grains in a bin",
    about: "Grains of gravel: momentum of grains and a turning wheel, energy of a collapsing heap, load on the floor, filled \
            fraction, angle of repose of a heap, and pressure under a plate, as of soil. Identical for all vehicles.",
    vehicles: Vehicles::All,
    place: Place::Stand,
    run: grains,
};

fn grains(_: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let gravel = gravel();
    let b = balance(&gravel, 1).map_err(unfilled)?;
    let exact = Expected::AtMost(1e-3);
    let source = "impulses on grains and wheel are equal and opposite";
    o.expect("error of momentum", 1e6 * b.momentum, "ppm", exact, source);
    o.expect("error of angular momentum", 1e6 * b.angular_momentum, "ppm", exact, source);
    let source = "friction and damping only dissipate energy; the integration error is up to 100 ppm";
    o.expect("rise of energy", 1e6 * b.energy_gain, "ppm", Expected::AtMost(100.0), source);
    o.expect("load on the floor / weight", b.floor_load, "", Expected::fraction(1.0, 0.01), "statics");

    let r = gravel.mean_radius();
    let deep = Bin { length: 36.0 * r, width: 36.0 * r, depth: 16.0 * r };
    let packing = Packing::poured(&gravel, deep, 1).map_err(unfilled)?;
    let source = "random packings of spheres: Jerkins et al. 2008, Scott and Kilgour 1969; smooth walls reduce it by 0.02";
    let filled = packing.fraction_below(12.0 * r);
    o.published("filled fraction", filled, "", Expected::Between(0.53, 0.64), source);

    let angle = degrees(angle_of_repose(&gravel, 1).map_err(unfilled)?);
    let source = "natural gravel 25 to 30°, crushed stone 45° (Glover, Pocket Ref, 1995)";
    o.published("angle of repose", angle, "°", Expected::Between(25.0, 45.0), source);

    let pressures = plate(&packing, &gravel, 8.0 * r, 0.2, 3.0 * r);
    let (_, n, r2) = bekker(&pressures[1..]);
    let source = "Bekker's law holds under plates (Wong 2008, ch. 2)";
    o.published("R² of p = k zⁿ", r2, "", Expected::AtLeast(0.9), source);
    o.figure("exponent n of p = k zⁿ", n, "");
    let mut plot = Plot::new("Pressure under a plate", "sinkage, mm", "pressure, kPa");
    plot.ours("gravel", pressures.iter().map(|[z, p]| [1e3 * z, 1e-3 * p]).collect());
    o.plots.push(plot);
    Ok(o)
}

/// Radius of the wheel for which `gravel` is, m: for others its grains are larger or smaller in proportion.
const RADIUS: f64 = 0.47;
/// Load over g r³ from which the wheel digs where it slips, kg/m³: about twice the density of gravel.
const DIGS: f64 = 3200.0;
/// Slips of the wheel; the first is towed.
const SLIPS: [f64; 7] = [-0.1, 0.05, 0.2, 0.3, 0.4, 0.8, 0.95];

pub(super) const WHEEL: Event = Event {
    name: "grains-wheel",
    title: "Wheel on grains",
    about: "The front wheel of the vehicle with its load, rigid, on a bed of gravel with grains scaled to the wheel: drawbar pull \
            and sinkage over slip, as on soil.",
    vehicles: Vehicles::Wheeled,
    place: Place::Stand,
    run: wheel,
};

fn wheel(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let corner = &bench.geometry.corners[0];
    let scale = corner.radius / RADIUS;
    let gravel = gravel();
    let gravel = GranularMaterial { radius: gravel.radius.map(|r| scale * r), ..gravel };
    let bin = Bin {
        length: 7.7 * corner.radius,
        width: corner.width + 1.4 * corner.radius,
        depth: 0.64 * corner.radius,
    };
    let packing = Packing::poured(&gravel, bin, 1).map_err(unfilled)?;
    let load = bench.standing.wheels[0].load;
    let wheel =
        Wheel { radius: corner.radius, width: corner.width, load, friction: 0.8, speed: scale.sqrt() };
    // As in worlds of another scale: the stiffness of a contact over its length in proportion to the weight.
    let default = Settings::default();
    let settings =
        Settings { stiffness: default.stiffness * scale * scale, reach: 0.6 * corner.radius, ..default };
    let runs = SLIPS.map(|slip| wheel.drive(&packing, &gravel, slip, settings));
    let [towed, slow, fifth, .., last] = runs;
    let mean = |at: fn(f64) -> bool, value: fn(&Traction) -> f64| {
        let at = SLIPS.iter().zip(&runs).filter(|(slip, _)| at(**slip)).map(|(_, run)| value(run));
        let values: Vec<f64> = at.collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    let source = "a towed wheel is a resistance (Wong 2008, ch. 2)";
    o.expect("pull / load, towed at −10 %", towed.pull, "", Expected::AtMost(0.0), source);
    // Stones make the pull at one slip uncertain by about 0.03, so its greatest value is looked for in means.
    let at_middle: fn(f64) -> bool = |slip| (0.15..=0.4).contains(&slip);
    let middle = mean(at_middle, |run| run.pull);
    let after = mean(|slip| slip > 0.4, |run| run.pull);
    o.figure("pull / load at 5 % slip", slow.pull, "");
    o.figure("mean pull / load at 20 to 40 % slip", middle, "");
    o.figure("mean pull / load at 80 and 95 % slip", after, "");
    let source = "wheels on dry sand pull most at a slip of 15 to 25 % (Freitag, Green and Melzer, WES TR M-70-2, 1970), tyres up to 40 % \
                  (Lyasko 2010)";
    let (before, beyond) = (middle - slow.pull, middle - after);
    o.published(
        "pull / load at 20 to 40 % slip above that at 5 %",
        before,
        "",
        Expected::AtLeast(0.0),
        source,
    );
    let digs = load > DIGS * GRAVITY * corner.radius * corner.radius * corner.radius;
    let figure = "pull / load at 20 to 40 % slip above that at 80 and 95 %";
    o.figure(figure, beyond, "");
    o.theory.push(Expectation {
        figure: figure.into(),
        expected: Expected::AtLeast(0.0),
        kind: Kind::Published,
        source: source.into(),
        unsound: (!digs).then(|| {
            "the published wheels have a load at which slip causes sinkage; this wheel has less".into()
        }),
    });
    let gross = mean(at_middle, |run| run.gross);
    let source = "tyres on gravel 0.6 (Wong 2008, table 1.3)";
    let expected = Expected::Within { value: 0.6, tolerance: 0.2 };
    o.published("gross traction / load at 20 to 40 % slip", gross, "", expected, source);
    let source = "friction between wheel and grains, 0.8, and interlocking stones in front of it";
    o.expect("gross traction / load at 95 % slip", last.gross, "", Expected::AtMost(0.9), source);
    let source = "slip sinkage (Reece 1965)";
    let dug = 1e3 * (last.sinkage - slow.sinkage);
    o.published("sinkage at 95 % slip less that at 5 %", dug, "mm", Expected::AtLeast(0.0), source);

    let finer = Settings { step: 0.5 * settings.step, ..settings };
    let change = (wheel.drive(&packing, &gravel, SLIPS[2], finer).pull - fifth.pull).abs();
    o.figure("change of pull / load at 20 % slip at half the step", change, "");
    o.theory.push(Expectation {
        figure: "change of pull / load at 20 % slip at half the step".into(),
        expected: Expected::AtMost(0.05),
        kind: Kind::Convergence,
        source: "the same at half the step".into(),
        unsound: None,
    });

    let over = |value: fn(&Traction) -> f64| {
        SLIPS.into_iter().zip(&runs).map(|(slip, run)| [slip, value(run)]).collect()
    };
    let mut pulls = Plot::new("Traction over slip", "slip", "force / load");
    pulls.ours("drawbar pull", over(|run| run.pull));
    pulls.ours("gross traction", over(|run| run.gross));
    let mut depths = Plot::new("Sinkage over slip", "slip", "sinkage, mm");
    depths.ours("sinkage", over(|run| 1e3 * run.sinkage));
    o.plots.extend([pulls, depths]);
    Ok(o)
}

pub(super) const VEHICLE: Event = Event {
    name: "grains-bed",
    title: "Vehicle on a granular bed",
    about: "The vehicle stands on a bed of gravel 0.2 m deep with brakes for 1 s, then half throttle for 1.2 s. Grains are \
            simulated bodies, unlike soil.",
    vehicles: Vehicles::All,
    place: Place::Soil,
    run: vehicle,
};

fn vehicle(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let gravel = gravel();
    let scale = bench.spec.scale;
    let smallest = bench.geometry.corners.iter().map(|c| c.radius).fold(f64::INFINITY, f64::min);
    if gravel.radius[1] * scale > smallest {
        o.note("Its wheels are smaller than grains of gravel: not run.");
        return Ok(o);
    }
    let mounts = || bench.geometry.corners.iter().map(|c| c.mount / scale);
    let rear = mounts().map(|m| m.x).fold(f64::INFINITY, f64::min);
    let front = mounts().map(|m| m.x).fold(f64::NEG_INFINITY, f64::max);
    let beside = mounts().map(|m| m.y).fold(0.0, f64::max);
    // A metre behind and two ahead of the wheels.
    let length = (front - rear + 3.0).ceil();
    let world = bed(&gravel, length, (2.0 * beside + 2.0).ceil(), 0.2);
    let mut d = Drive::new(bench, "gravel", &world, 1.0 - 0.5 * length - rear, 0.0)?;
    d.hold(bench.pace.time(0.6), |_| PARKED)?;
    let (mut total, mut steps) = (0.0, 0.0);
    d.hold(bench.pace.time(0.4), |s| {
        total += s.wheels.iter().map(|w| w.load).sum::<f64>();
        steps += 1.0;
        PARKED
    })?;
    let weight = bench.geometry.weight();
    let tolerance = if bench.spec.tracks.is_some() { 0.05 } else { 0.02 };
    let loads = Expected::fraction(weight, tolerance);
    o.expect("sum of wheel loads", total / steps, "N", loads, "weight m g");
    let rest = d.state();
    // Unlike the sinkage of wheels, this is there for belts, too.
    let sunk = |height: f64| 1e3 * (bench.standing.position.z - height);
    o.figure("lower than on rigid ground at rest", sunk(rest.position.z), "mm");
    let time = bench.pace.time(1.2);
    d.hold(time, |s| controls(bench.pace.hold_line(s), 0.5, 0.0))?;
    let s = d.state();
    let gained = s.velocity_body.x - rest.velocity_body.x;
    let source =
        "friction 0.8 between wheels and grains, and interlocking stones in front of them: Δv ≤ 0.9 g t";
    o.expect("speed after 1.2 s", gained, "m/s", Expected::Between(0.0, 0.9 * GRAVITY * time), source);
    o.figure("lower than on rigid ground after 1.2 s", sunk(s.position.z), "mm");
    o.series.push(d.finish());
    Ok(o)
}
