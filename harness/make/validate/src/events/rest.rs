//! Standing still.

use crate::bench::Bench;
use crate::check::Expected;
use crate::event::{Event, Outcome, Place, Plot, Vehicles};
use crate::grounds::{flat, plane};
use crate::pace::{COASTING, PARKED as BRAKES};
use crate::rig::Drive;
use vb_math::angle::{degrees, radians};
use vb_sim::SimError;

pub(super) const STATIC: Event = Event {
    name: "static",
    title: "Wheel loads and ride height",
    about: "The vehicle stands on level ground with brakes for 5 s after settling.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: standing,
};

fn standing(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let g = &bench.geometry;
    let mut d = Drive::new(bench, "level", &flat(0.9), 0.0, 0.0)?;
    d.hold(5.0, |_| BRAKES)?;
    let s = d.state();
    let sum: f64 = s.wheels.iter().map(|w| w.load).sum();
    o.expect("sum of wheel loads", sum, "N", Expected::fraction(g.weight(), 1e-3), "weight m g");
    for (c, w) in g.corners.iter().zip(&s.wheels) {
        o.figure(format!("load {}", c.name), w.load, "N");
    }
    let com = g.com_of(&s);
    let weighted = |f: fn(&nalgebra::Vector3<f64>) -> f64| {
        let at = |i: usize| f(&g.hub_of(&s, i)) * s.wheels[i].load;
        (0..s.wheels.len()).map(at).sum::<f64>() / sum
    };
    let source = "moments about the centre of mass: Σ Fz x = 0";
    let ahead = 1e3 * (weighted(|h| h.x) - com.x);
    o.expect(
        "resultant of the loads ahead of the centre of mass",
        ahead,
        "mm",
        Expected::Within { value: 0.0, tolerance: bench.pace.length(5.0) },
        source,
    );
    let beside = 1e3 * (weighted(|h| h.y) - com.y);
    o.expect(
        "resultant of the loads left of the centre of mass",
        beside,
        "mm",
        Expected::Within { value: 0.0, tolerance: bench.pace.length(5.0) },
        source,
    );
    let (roll, pitch, _) = s.roll_pitch_yaw();
    o.figure("height of the reference point", s.position.z, "m");
    o.figure("pitch", degrees(pitch), "°");
    let one_sided = bench.spec.axles.iter().any(|a| a.suspension.linkage.knuckles().is_some());
    let (tolerance, source) = if one_sided {
        (0.2, "symmetry, except for a drag link on one side, which steers as the axle settles")
    } else {
        (0.05, "symmetry")
    };
    o.expect("roll", degrees(roll), "°", Expected::Within { value: 0.0, tolerance }, source);
    for (c, w) in g.corners.iter().zip(&s.wheels) {
        o.figure(format!("travel {}", c.name), 1e3 * w.deflection, "mm");
    }
    o.series.push(d.finish());
    Ok(o)
}

pub(super) const PARKED: Event = Event {
    name: "parked",
    title: "Rest for 60 s",
    about: "With brakes up, across and down a slope of 20° at μ 0.9 and of 10° at μ 0.5, and without commands on level \
            ground. After settling for 5 s with brakes and for 65 s without commands, it must not move for 60 s.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: parked,
};

fn parked(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let mut plot = Plot::new("Creep at rest", "t, s", "distance from where it stood, mm");
    let cases = [
        ("20° up, μ 0.9, braked", "up-20", 20.0, 0.9, 0.0, BRAKES),
        ("20° across, μ 0.9, braked", "across-20", 20.0, 0.9, 90.0, BRAKES),
        ("20° down, μ 0.9, braked", "down-20", 20.0, 0.9, 180.0, BRAKES),
        ("10° up, μ 0.5, braked", "up-10", 10.0, 0.5, 0.0, BRAKES),
        ("10° across, μ 0.5, braked", "across-10", 10.0, 0.5, 90.0, BRAKES),
        ("level, nothing pressed", "level", 0.0, 0.9, 0.0, COASTING),
    ];
    for (label, case, slope, friction, yaw, controls) in cases {
        let mut d = Drive::new(bench, case, &plane(radians(slope), friction), 0.0, radians(yaw))?;
        // Tyres that were strained sideways as the vehicle settled roll on by a relaxation length when the brakes let go.
        let settle = if controls == COASTING { 65.0 } else { 5.0 };
        if controls == COASTING && bench.creeps() {
            o.note("Its engine idles against a converter, so it does not stand without commands.");
            continue;
        }
        d.hold(settle, |_| controls)?;
        let from = d.state();
        d.hold(60.0, |_| controls)?;
        let moved = 1e3 * (d.state().position - from.position).norm();
        // What no friction of the engine holds creeps on the smoothed corner of rolling resistance at rest.
        let free = controls == COASTING && bench.spec.powertrain.engine.torque(0.0, 0.0) >= 0.0;
        let (most, source) = if free {
            (bench.pace.length(20.0), "only rolling resistance holds it: limit of creep")
        } else {
            (1.0, "statics: tan of the slope is below μ, so friction holds")
        };
        o.expect(&format!("moved in 60 s, {label}"), moved, "mm", Expected::AtMost(most), source);
        let series = d.finish();
        let at = |r: &Vec<f64>| {
            let d = [r[1] - from.position.x, r[2] - from.position.y, r[3] - from.position.z];
            [r[0], 1e3 * (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt()]
        };
        plot.ours(label, series.rows.iter().skip(500).map(at).collect());
        o.series.push(series);
    }
    o.plots.push(plot);
    Ok(o)
}
