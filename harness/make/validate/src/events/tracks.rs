//! What tracks do that wheels don't: turning by drag, pulling along their whole length, bridging trenches.

use crate::bench::Bench;
use crate::check::Expected;
use crate::event::{Event, LineKind, Outcome, Place, Plot, Vehicles};
use crate::grounds::{flat, profile, soil};
use crate::pace::controls;
use crate::rig::{Drive, largest};
use vb_math::{exp, pow, tan};
use vb_sim::{
    SimError, SoilSet, VehicleState,
    soil::{Bekker, PressureDirection, Sinkage, SlipSinkage, SoilLaw},
};
use vb_vehicle::tracks::Tracks;
use vb_world::TerrainClass;

/// Friction of the ground on which it turns.
const GROUND: f64 = 0.8;

/// What the theories need of a track.
struct Track<'a> {
    data: &'a Tracks,
    /// Distance of the belts' middles, width, and length of ground that the road wheels stand for, m.
    gauge: f64,
    width: f64,
    length: f64,
    /// At which the belt runs around the sprocket, m.
    pitch_radius: f64,
    /// On that ground.
    friction: f64,
    /// Number of the first road wheel on the left, and its radius, m.
    wheel: usize,
    wheel_radius: f64,
}

impl<'a> Track<'a> {
    fn of(bench: &Bench<'a>) -> Option<Self> {
        let (spec, g) = (bench.spec, &bench.geometry);
        let data = spec.tracks.as_ref()?;
        let sprocket = spec.axles.iter().position(|a| a.driven)?;
        let x = |axle: usize| g.hub(2 * axle, 0.0, 0.0).x;
        let last = spec.axles.len() - 2;
        // Each wheel stands for the ground up to half the way to its neighbours.
        let between = (x(1) - x(last)) / (last - 1) as f64;
        Some(Self {
            data,
            gauge: g.track(),
            width: spec.tyre.width(),
            length: x(1) - x(last) + between,
            pitch_radius: g.corners[2 * sprocket].radius - 0.5 * data.thickness,
            friction: bench.grip(GROUND),
            wheel: 2,
            wheel_radius: g.corners[2].radius - data.thickness,
        })
    }

    /// Speed of the left belt, m/s.
    fn belt(&self, s: &VehicleState) -> f64 {
        s.wheels[self.wheel].speed * self.wheel_radius
    }
}

pub(super) const TURNING: Event = Event {
    name: "skid-steer",
    title: "Turning against the drag of the tracks",
    about: "Steering commands from 0.1 to 1 at 3 m/s on level ground, 15 s, and three of them backwards at 2 m/s: radius, and the \
            resisting moment of the ground, from the steering brake.",
    vehicles: Vehicles::Tracked,
    place: Place::Rigid,
    run: turning,
};

fn turning(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let Some(t) = Track::of(bench) else { return Ok(o) };
    let mut plot = Plot::new("Resistance to turning", "radius, m", "moment over μ W L/4");
    let (mut ours, mut trials) = (Vec::new(), Vec::new());
    let backwards = bench.spec.powertrain.gearbox.reverse.map(|_| [0.3, 0.5, 1.0]);
    let cases = [0.1, 0.2, 0.3, 0.4, 0.5, 1.0].map(|steering| (false, steering));
    for (back, steering) in cases.into_iter().chain(backwards.into_iter().flatten().map(|s| (true, s))) {
        let way = if back { "backwards, " } else { "" };
        let file = if back { "backwards-" } else { "" };
        let mut d = Drive::new(bench, &format!("{file}steering-{steering}"), &flat(GROUND), 0.0, 0.0)?;
        d.hold(15.0, |s| match back {
            true => bench.pace.hold_speed_back(s, 2.0, steering),
            false => bench.pace.hold_speed(s, 3.0, steering),
        })?;
        let s = d.state();
        let radius = s.velocity_body.x / s.angular_velocity_body.z;
        let label = format!("{way}steering {steering}: radius");
        o.figure(&label, radius, "m");
        if steering < 1.0 {
            let moment = 0.5 * t.gauge * steering * t.data.steering_torque / t.pitch_radius;
            let fraction = moment / (0.25 * t.friction * bench.geometry.weight() * t.length);
            let expected = 1.0 / (0.925 + 0.15 * radius / t.gauge);
            o.expect(
                &format!("{way}steering {steering}: moment over μ W L/4"),
                fraction,
                "",
                Expected::fraction(expected, 0.3),
                "Nikitin's formula from trials, 1/(0.925 + 0.15 R/B) (Wong 2008, ch. 6)",
            );
            if !back {
                ours.push([radius, fraction]);
                trials.push([radius, expected]);
            }
        } else {
            o.theory(label, Expected::Between(0.5 * t.gauge, t.gauge), "about the locked inner belt");
            o.expect(
                &format!("{way}steering 1: speed of the inner belt"),
                t.belt(&s).abs(),
                "m/s",
                Expected::AtMost(0.01),
                "its brake holds it",
            );
        }
        o.series.push(d.finish());
    }
    plot.ours("simulated", ours);
    plot.line(LineKind::Theory, 0, "Nikitin".to_owned(), trials);
    o.plots.push(plot);
    Ok(o)
}

pub(super) const PULL: Event = Event {
    name: "track-pull",
    title: "Drawbar pull",
    about: "The vehicle pulls loads of growing weight over level soil, dry sand, sandy loam and LETE sand of Wong's table with pressure \
            normal to the belt: slip over pull, and the maximum pull, compared with the closed form of a track with uniform pressure.",
    vehicles: Vehicles::Tracked,
    place: Place::Soil,
    run: pull,
};

/// Soils of the set `wong` that bear a vehicle of this kind.
const SOILS: [&str; 3] = ["dry-sand", "sandy-loam", "lete-sand"];

/// Slip, and sinkage of the deepest wheel (m), at a pull of a share of the weight; none where it stops.
fn pulled(
    bench: &Bench<'_>,
    t: &Track<'_>,
    set: &SoilSet,
    fraction: f64,
) -> Result<Option<(f64, f64)>, SimError> {
    let world = soil(TerrainClass::Sand, 300.0, 60.0, 0.0);
    let mut d = Drive::on_soil(bench, set, "pull", &world, -100.0)?;
    let (mut slip, mut sinkage, mut count) = (0.0, 0.0_f64, 0.0);
    for k in 0..150 {
        // A load behind it that pulls as its own weight does on a slope.
        let pull = fraction * (f64::from(k) / 50.0).min(1.0);
        d.sim().rig().set_gravity([-pull * vb_vehicle::GRAVITY, 0.0, -vb_vehicle::GRAVITY]);
        d.hold(0.1, |s| bench.pace.hold_speed(s, 2.0, 0.0))?;
        let s = d.state();
        if k >= 100 {
            slip += 1.0 - s.velocity_body.x / t.belt(&s);
            sinkage = s.wheels.iter().map(|w| w.sinkage).fold(sinkage, f64::max);
            count += 1.0;
        }
    }
    let slip = slip / count;
    Ok((slip < 0.8 && d.state().velocity_body.x > 0.05).then_some((slip, sinkage)))
}

fn pull(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let Some(t) = Track::of(bench) else { return Ok(o) };
    let Some(wong) = bench.soils.iter().find(|s| s.name == "wong") else {
        o.note("The soil set wong is missing: not run.");
        return Ok(o);
    };
    let weight = bench.geometry.weight();
    let mut plot = Plot::new("Pull over slip", "slip", "pull over weight");
    for name in SOILS {
        let Some(law) = wong.soils.get(name) else { continue };
        let law = SoilLaw {
            pressure: PressureDirection::Radial,
            damping: 1e3,
            bulldozing: None,
            elastic_stiffness: 4e8,
            slip_sinkage: SlipSinkage::None,
            ..*law
        };
        let mut set = wong.clone();
        set.soils.values_mut().for_each(|l| *l = law);
        let resistance = |z: f64| {
            let Sinkage::Bekker(Bekker { k_phi, k_c, exponent: n }) = law.sinkage else { return f64::NAN };
            2.0 * t.width * (k_c / t.width + k_phi) * pow(z, n + 1.0) / (n + 1.0) / weight
        };
        let most = 2.0 * t.width * t.length * law.cohesion / weight
            + tan(vb_math::angle::radians(law.friction_angle_deg));
        // A bent belt is longer than the ground under it: that is none of the soil's slip.
        let free = pulled(bench, &t, &set, 0.0)?.map_or(f64::NAN, |p| p.0);
        let (mut points, mut deepest) = (Vec::new(), 0.0);
        let greatest = largest(0.0, 0.8, 0.02, |fraction| {
            let at = pulled(bench, &t, &set, fraction)?;
            if let Some((slip, sinkage)) = at {
                points.push([slip - free, fraction]);
                deepest = sinkage;
            }
            Ok(at.is_some())
        })?;
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        o.figure(format!("{name}: sinkage at the greatest pull"), 1e3 * deepest, "mm");
        o.expect(
            &format!("{name}: greatest pull over weight"),
            greatest,
            "",
            Expected::fraction(most - resistance(deepest), 0.15),
            "A c/W + tan φ, less the resistance of its rut, 2 b ∫ p dz (Bekker 1969; Wong 2008, ch. 2)",
        );
        let curve = (1..=40).map(|k| 0.01 * f64::from(k)).map(|i| {
            let way = i * t.length / law.shear_modulus;
            [i, most * (1.0 - (1.0 - exp(-way)) / way) - resistance(deepest)]
        });
        plot.ours(name, points.into_iter().filter(|p| p[0] <= 0.4).collect());
        let case = plot.lines.last().map_or(0, |l| l.case);
        plot.line(LineKind::Theory, case, format!("{name}, closed form"), curve.collect());
    }
    o.plots.push(plot);
    Ok(o)
}

pub(super) const TRENCH: Event = Event {
    name: "trench",
    title: "Trench",
    about: "A trench of growing width, 3 m deep, at μ 0.8, crossed at 2 m/s: the widest that it bridges.",
    vehicles: Vehicles::Tracked,
    place: Place::Rigid,
    run: trench,
};

fn trench(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let Some(_) = Track::of(bench) else { return Ok(o) };
    let (mut best, pace) = (None, bench.pace);
    let widest = largest(0.5, 4.0, 0.05, |width| {
        let world = profile(12.0, 6.0, 0.05, 0.8, |x| if x > 0.0 && x < width { -3.0 } else { 0.0 });
        let mut d = Drive::new(bench, &format!("{width:.2}m"), &world, -8.0, 0.0)?;
        let push = |s: &VehicleState| controls(pace.hold_line(s), pace.hold_speed(s, 2.0, 0.0).throttle, 0.0);
        let over = |s: &VehicleState| s.position.x > pace.length(width) + bench.spec.length;
        let done = d.run(20.0, push, over)?;
        if done {
            best = Some(d.finish());
        }
        Ok(done)
    })?;
    o.figure("widest trench", pace.length(widest), "m");
    if let Some(series) = best {
        let mut plot = Plot::new("Height of the reference point over the widest trench", "x, m", "height, m");
        plot.ours(format!("{widest:.2} m"), series.pairs("x", "z"));
        o.plots.push(plot);
        o.series.push(series);
    }
    Ok(o)
}
