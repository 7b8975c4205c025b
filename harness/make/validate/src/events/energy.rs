//! What nature conserves.

use crate::bench::Bench;
use crate::check::Expected;
use crate::event::{Event, LineKind, Outcome, Place, Plot, Vehicles};
use crate::grounds::{flat, profile};
use crate::pace::{COASTING, PARKED};
use crate::rig::Drive;
use vb_math::cos;
use vb_sim::SimError;
use vb_vehicle::GRAVITY;

pub(super) const FREE_FALL: Event = Event {
    name: "free-fall",
    title: "Free fall",
    about: "Released 5 m above the ground for 0.8 s, with wheels moving on their springs: the centre of mass is in free fall.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: free_fall,
};

fn free_fall(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let g = &bench.geometry;
    let mut d = Drive::new(bench, "fall", &flat(0.9), 0.0, 0.0)?;
    d.sim().rig().lift(bench.pace.length(5.0));
    let (begin, from) = (d.state().time, g.com_of(&d.state()));
    let seconds = bench.pace.time(0.8);
    let (mut worst, mut aside, mut points) = (0.0_f64, 0.0_f64, Vec::new());
    d.run(
        seconds,
        |_| COASTING,
        |s| {
            let t = s.time - begin;
            let p = g.com_of(s) - from;
            worst = worst.max((p.z + 0.5 * GRAVITY * t * t).abs());
            aside = aside.max(vb_math::hypot(p.x, p.y));
            points.push([t, p.z]);
            false
        },
    )?;
    // Symplectic Euler falls ½ g t dt too far.
    let own = 0.5 * GRAVITY * seconds * bench.options.step;
    o.expect(
        "deviation from ½ g t²",
        1e3 * worst,
        "mm",
        Expected::AtMost(2e3 * own),
        "½ g t², within twice the error ½ g t dt of symplectic Euler",
    );
    o.expect("sideways", 1e3 * aside, "mm", Expected::AtMost(1.0), "no force acts sideways");
    let mut plot = Plot::new("Height of the centre of mass", "t, s", "height lost, m");
    let theory = points.iter().step_by(20).map(|p| [p[0], -0.5 * GRAVITY * p[0] * p[0]]).collect();
    plot.line(LineKind::Ours, 0, "simulated", points);
    plot.line(LineKind::Theory, 0, "½ g t²", theory);
    o.plots.push(plot);
    o.series.push(d.finish());
    Ok(o)
}

pub(super) const ENERGY: Event = Event {
    name: "energy",
    title: "Energy never increases",
    about: "Released on the side of a valley 3 m deep without commands, for 40 s: it oscillates, and the sum of kinetic and \
            potential energy must not increase.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: energy,
};

fn energy(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    if bench.creeps() {
        o.note("Its engine idles against a converter and accelerates the vehicle: not run.");
        return Ok(o);
    }
    let g = &bench.geometry;
    let (depth, length) = (3.0, 60.0);
    let ground =
        profile(80.0, 12.0, 0.5, 0.9, |x| 0.5 * depth * (1.0 - cos(2.0 * std::f64::consts::PI * x / length)));
    let mut d = Drive::new(bench, "valley", &ground, -20.0, 0.0)?;
    d.hold(1.0, |_| PARKED)?;
    let begin = d.state().time;
    let first = g.mechanical_energy(&d.state());
    let bottom = {
        let flat = Drive::new(bench, "bottom", &ground, 0.0, 0.0)?;
        g.mechanical_energy(&flat.state())
    };
    let (mut gain, mut lowest, mut rise) = (f64::NEG_INFINITY, first, 0.0_f64);
    let mut points = Vec::new();
    d.run(
        40.0,
        |_| COASTING,
        |s| {
            let e = g.mechanical_energy(s);
            gain = gain.max(e - first);
            // What springs and tyres give back shows as ripple; a growth would add up.
            lowest = lowest.min(e);
            rise = rise.max(e - lowest);
            points.push([s.time - begin, (e - bottom) / 1e3]);
            false
        },
    )?;
    let swing = first - bottom;
    o.figure("energy at the start above the bottom", swing / 1e3, "kJ");
    o.expect(
        "greatest excess over the start",
        100.0 * gain / swing,
        "%",
        Expected::AtMost(1.0),
        "conservation: 1 % for the energy in springs and tyres, which is not included",
    );
    o.expect(
        "greatest rise after any instant",
        100.0 * rise / swing,
        "%",
        Expected::AtMost(2.0),
        "conservation: 2 % for the energy stored in springs and tyres",
    );
    let mut plot = Plot::new("Mechanical energy above the valley's bottom", "t, s", "energy, kJ");
    plot.ours("kinetic and potential", points.into_iter().step_by(10).collect());
    o.plots.push(plot);
    o.series.push(d.finish());
    Ok(o)
}
