//! Plates and single wheels on soil, against the closed forms of terramechanics.

use crate::bench::Bench;
use crate::check::Expected;
use crate::event::{Event, LineKind, Outcome, Place, Plot, Series, Vehicles};
use crate::rigid_wheel::{Carried, RigidWheel};
use vb_math::{exp, tan};
use vb_sim::{
    SimError,
    soil::{Bekker, PressureDirection, Sinkage, SlipSinkage, SoilLaw, WheelRig},
};

/// A soil as the closed forms know it: pressure normal to the rim, no damping, no heaps.
fn bare(law: &SoilLaw) -> SoilLaw {
    SoilLaw {
        pressure: PressureDirection::Radial,
        damping: 0.0,
        bulldozing: None,
        slip_sinkage: SlipSinkage::None,
        ..*law
    }
}

/// Every soil of every set, once, with a name and the name of its set.
fn soils<'a>(bench: &Bench<'a>) -> Vec<(String, &'a str, SoilLaw)> {
    let mut all: Vec<(String, &str, SoilLaw)> = Vec::new();
    for set in bench.soils {
        for (name, law) in &set.soils {
            let law = bare(law);
            if !all.iter().any(|(_, _, l)| *l == law) {
                all.push((format!("{name} ({})", set.name), &set.name, law));
            }
        }
    }
    all
}

pub(super) const PLATE: Event = Event {
    name: "plate",
    title: "Plate on soil",
    about: "Plates 0.1 and 0.3 m wide pressed into every soil: the law's pressure at ten depths against the formula of its sinkage.",
    vehicles: Vehicles::All,
    place: Place::Stand,
    run: plate,
};

fn plate(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let mut plot = Plot::new("Pressure under a plate 0.3 m wide", "sinkage, mm", "pressure, kPa");
    for (name, _, law) in soils(bench) {
        let mut worst = 0.0_f64;
        for breadth in [0.1, 0.3] {
            for k in 1..=10 {
                let p = 20e3 * f64::from(k);
                let z = law.sinkage.plate_sinkage(p, breadth);
                worst = worst.max((law.pressure(z, breadth) / p - 1.0).abs());
            }
        }
        let source = format!("{} at 20 to 200 kPa ({})", law.sinkage.formula(), law.sinkage.source());
        o.expect(&format!("{name}: greatest deviation"), 100.0 * worst, "%", Expected::AtMost(1.0), source);
        if plot.lines.len() < 8 {
            let points =
                (0..=40).map(|k| 0.0025 * f64::from(k)).map(|z| [1e3 * z, 1e-3 * law.pressure(z, 0.3)]);
            plot.ours(name, points.filter(|p| p[1] <= 300.0).collect());
        }
    }
    o.plots.push(plot);
    Ok(o)
}

/// The wheel of theory: the HMMWV's, W = 6369 N, b = 0.3175 m, D = 0.934 m.
const THE_WHEEL: RigidWheel =
    RigidWheel { radius: 0.467, breadth: 0.3175, load: 2597.0 * vb_vehicle::GRAVITY / 4.0 };
const LOAD: f64 = THE_WHEEL.load;

/// Where theory of a wheel's pressure is from.
const SMOOTH: &str =
    "Bekker's rigid wheel (Wong 2008, ch. 2) on soil that springs back along Wong's unloading line (ibid.)";

/// Greatest thrust of the wheel: A c + W tan φ (Mohr and Coulomb), N.
fn thrust(law: &SoilLaw, wheel: &Carried) -> f64 {
    THE_WHEEL.breadth * wheel.length * law.cohesion + LOAD * tan(law.friction_angle_deg.to_radians())
}

/// Drawbar pull over load at a slip (Janosi and Hanamoto 1961 over the contact's length).
fn drawbar(law: &SoilLaw, wheel: &Carried, slip: f64) -> f64 {
    let x = slip * wheel.length / law.shear_modulus;
    let mobilised = if x > 1e-9 { 1.0 - (1.0 - exp(-x)) / x } else { 0.0 };
    (thrust(law, wheel) * mobilised - wheel.resistance) / LOAD
}

/// Stations of a wheel's footprint on either side of the axle, their reach over the radius, and the gap under the axle over the
/// mean one (docs/physics.md, "Soil"; `vb_sim`'s footprint).
const STATIONS: (i32, f64, f64) = (10, 0.95, 0.35);

/// How far (m) the ground that a footprint's stations stand for may reach beyond the contact, which goes so far (m) to the front
/// and to the rear: a station stands for the ground up to half way to its neighbours, so half the gap in which the contact ends.
fn overhang(contact: [f64; 2]) -> f64 {
    let (count, extent, crowding) = STATIONS;
    let at = |k: i32| {
        let u = f64::from(k) / f64::from(count);
        extent * THE_WHEEL.radius * u * (crowding + (1.0 - crowding) * u * u)
    };
    let gap =
        |end: f64| (0..count).map(|k| [at(k), at(k + 1)]).find(|g| end < g[1]).map_or(0.0, |g| g[1] - g[0]);
    contact.map(gap).iter().sum::<f64>() / 2.0
}

/// By how much the ground on which adhesion acts is longer than the contact, on the soil and on soils of its strength that are 3
/// and 10 times as soft, in which the contact is long beside the gaps between stations: what is due to these goes with them.
fn stands_over(rig: &WheelRig, name: &str, law: &SoilLaw, o: &mut Outcome) {
    // Where adhesion is little beside friction, what its ground is can't be told.
    let friction = tan(law.friction_angle_deg.to_radians());
    if 0.1 * LOAD * friction > THE_WHEEL.breadth * 0.05 * law.cohesion {
        return;
    }
    for softer in [1.0, 3.0, 10.0] {
        let law = SoilLaw { sinkage: law.sinkage.softer(softer), ..*law };
        let run = rig.run(&law, 0.8, 1);
        let contact = THE_WHEEL.contact(&law, run.sinkage);
        let (length, stands) = (contact.iter().sum::<f64>(), overhang(contact));
        let adhesion = (run.drawbar + run.compaction - LOAD * friction) / (THE_WHEEL.breadth * law.cohesion);
        o.figure(format!("{name}, {softer} times as soft: length of contact"), 1e3 * length, "mm");
        o.expect(
            &format!("{name}, {softer} times as soft: excess of the length on which adhesion acts"),
            100.0 * (adhesion / length - 1.0),
            "%",
            Expected::AtMost(100.0 * stands / length),
            "no more than half a gap between the footprint's stations at either end of the contact",
        );
    }
}

/// Why theory says nothing of the thrust on this soil, if it doesn't.
fn deep(wheel: &Carried) -> Option<&'static str> {
    (wheel.sinkage > 0.4 * THE_WHEEL.radius)
        .then_some("the thrust theory assumes a sinkage that is small relative to the diameter")
}

fn rig(bench: &Bench<'_>) -> WheelRig {
    WheelRig {
        radius: THE_WHEEL.radius,
        width: THE_WHEEL.breadth,
        load: LOAD,
        speed: 1.0,
        step: bench.options.step,
        resolution: bench.options.soil_resolution,
    }
}

pub(super) const WHEEL: Event = Event {
    name: "wheel-on-soil",
    title: "Single wheel on soil",
    about: "A rigid wheel of the HMMWV's size in a soil bin on every soil: sinkage and compaction resistance of a smooth rim against \
            Bekker's law and Wong's unloading line, integrated over the rim, and drawbar pull of a rough one over slip. The theory of the \
            smooth rim is valid up to a sinkage of its radius, that of the pull up to a fifth of the diameter; beyond, it is shown \
            without a verdict, or omitted.",
    vehicles: Vehicles::Wheeled,
    place: Place::Stand,
    run: wheel,
};

const SLIPS: [f64; 6] = [0.0, 0.05, 0.1, 0.2, 0.4, 0.8];
/// Tolerances: a share, and what a share of a resistance near nothing would not allow, over the load.
const SHARE: f64 = 0.15;
const LEAST: f64 = 0.01;

fn wheel(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let rig = rig(bench);
    let mut plots: Vec<Plot> = Vec::new();
    let mut columns = vec![("slip".to_owned(), "")];
    let mut rows: Vec<Vec<f64>> = SLIPS.iter().map(|s| vec![*s]).collect();
    for (name, set, law) in soils(bench) {
        let runs: Vec<_> = SLIPS.iter().map(|&s| rig.run(&law, s, 1)).collect();
        // Theory of sinkage and resistance leaves shear on the rim out of the balance of forces.
        let smooth = rig.run(&SoilLaw { friction_angle_deg: 0.0, cohesion: 0.0, ..law }, 0.0, 1);
        let pull: Vec<f64> = runs.iter().map(|r| r.drawbar / LOAD).collect();
        let strongest = runs.iter().fold(runs[0], |best, r| if r.drawbar > best.drawbar { *r } else { best });
        let sinkage = format!("{name}: sinkage of a smooth wheel");
        let resistance = format!("{name}: compaction resistance of a smooth wheel / load");
        let greatest = format!("{name}: greatest drawbar pull / load");
        o.figure(&sinkage, 1e3 * smooth.sinkage, "mm");
        o.figure(&resistance, smooth.compaction / LOAD, "");
        o.figure(&greatest, pull.iter().copied().fold(f64::NEG_INFINITY, f64::max), "");
        columns.push((name.clone(), ""));
        rows.iter_mut().zip(&pull).for_each(|(row, p)| row.push(*p));
        let Some(wheel) = THE_WHEEL.on(&law) else {
            o.note(format!("{name}: the sinkage exceeds the radius, where no theory applies."));
            continue;
        };
        o.theory(sinkage, Expected::fraction(1e3 * wheel.sinkage, SHARE), SMOOTH);
        let expected = wheel.resistance / LOAD;
        let tolerance = (SHARE * expected).max(LEAST);
        o.theory(resistance, Expected::Within { value: expected, tolerance }, SMOOTH);
        let first = o.theory.len();
        let most = thrust(&law, &wheel) - wheel.resistance;
        // A difference of two terms that may be large beside it: the share is of the larger of it and the resistance.
        let tolerance = SHARE * most.abs().max(wheel.resistance) / LOAD;
        let expected = Expected::Within { value: most / LOAD, tolerance };
        o.theory(&greatest, expected, "(A c + W tan φ − Rc) / W (Wong 2008, ch. 2)");
        let contact = THE_WHEEL.contact(&law, strongest.sinkage);
        let adhesion = THE_WHEEL.breadth * law.cohesion * (contact.iter().sum::<f64>() + overhang(contact));
        o.theory(
            greatest,
            Expected::AtMost(tan(law.friction_angle_deg.to_radians()) + adhesion / LOAD),
            "Mohr and Coulomb: no more than tan φ + A c / W at any slip, A of the contact as deep as the wheel is and of half a gap between the footprint's stations at either end",
        );
        stands_over(&rig, &name, &law, &mut o);
        columns.push((format!("{name}, theory"), ""));
        rows.iter_mut().for_each(|row| row.push(drawbar(&law, &wheel, row[0])));
        if let Some(why) = deep(&wheel) {
            for e in &mut o.theory[first..] {
                e.unsound = Some(why.to_owned());
            }
            continue;
        }
        let title = format!("Drawbar pull over slip, soils of {set}");
        let at = plots.iter().position(|p| p.title == title).unwrap_or_else(|| {
            plots.push(Plot::new(&title, "slip", "drawbar pull / load"));
            plots.len() - 1
        });
        let measured = SLIPS.iter().zip(&pull).map(|(s, p)| [*s, *p]).collect();
        plots[at].ours(name.clone(), measured);
        let case = plots[at].lines.last().map_or(0, |l| l.case);
        let theory = (0..=40).map(|k| f64::from(k) / 50.0).map(|s| [s, drawbar(&law, &wheel, s)]).collect();
        plots[at].line(LineKind::Theory, case, format!("{name}, theory"), theory);
    }
    o.series.push(Series { name: "drawbar".to_owned(), columns, rows });
    o.plots = plots;
    Ok(o)
}

pub(super) const SECOND_PASS: Event = Event {
    name: "second-pass",
    title: "Second pass",
    about: "The same wheel at 20 % slip over fresh soil and again in its own rut: compacted soil deforms less.",
    vehicles: Vehicles::Wheeled,
    place: Place::Stand,
    run: second_pass,
};

/// Why trials of ruts say nothing of this soil, if they don't.
fn unlike_trials(law: &SoilLaw) -> Option<&'static str> {
    if matches!(law.sinkage, Sinkage::Bekker(Bekker { exponent, .. }) if exponent < 0.3) {
        return Some(
            "the trials used soils that become firmer under a rut; the pressure of this soil hardly increases with depth",
        );
    }
    match THE_WHEEL.on(law) {
        Some(w) if w.sinkage <= 0.4 * THE_WHEEL.radius => (2.0 * w.rebound > w.sinkage)
            .then_some("the elastic recovery of this firm soil exceeds its compaction, so no rut remains"),
        _ => Some("the trials used ruts that are shallow relative to the wheel"),
    }
}

fn second_pass(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let rig = rig(bench);
    for (name, _, law) in soils(bench) {
        let first = o.theory.len();
        let (one, two) = (rig.run(&law, 0.2, 1), rig.run(&law, 0.2, 2));
        o.figure(format!("{name}: rut after the first pass"), 1e3 * one.sinkage, "mm");
        o.expect(
            &format!("{name}: share of the first pass' sinkage that the second adds"),
            100.0 * (two.sinkage / one.sinkage - 1.0),
            "%",
            Expected::Between(0.0, 50.0),
            "repeated passes deepen a rut as z2 / z1 = 2^(1/a), a from 2 up (Abebe et al. 1989): up to 41 %, and a tenth",
        );
        o.expect(
            &format!("{name}: compaction resistance of the second pass / first"),
            if one.compaction > 0.0 { two.compaction / one.compaction } else { 0.0 },
            "",
            Expected::AtMost(1.0),
            "compacted soil is elastic up to its previous pressure",
        );
        if let Some(why) = unlike_trials(&law) {
            for e in &mut o.theory[first..] {
                e.unsound = Some(why.to_owned());
            }
        }
    }
    Ok(o)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stations_stand_for_no_more_ground_than_the_contact_and_half_a_gap_at_either_end() {
        let (count, extent, crowding) = STATIONS;
        let at = |k: i32| {
            let u = f64::from(k) / f64::from(count);
            extent * THE_WHEEL.radius * u * (crowding + (1.0 - crowding) * u * u)
        };
        for end in (1..40).map(|k| 0.01 * f64::from(k)) {
            let inside = (1 - count..count).filter(|&k| at(k).abs() <= end);
            let stand_for: f64 = inside.map(|k| 0.5 * (at(k + 1) - at(k - 1))).sum();
            let most = 2.0 * end + overhang([end, end]);
            assert!(stand_for <= most + 1e-12, "{end}: {stand_for} of {most}");
        }
        // 67 mm of heavy clay: five stations, which stand for 88 mm.
        assert!((0.0334 * 2.0 + overhang([0.0335, 0.0335]) - 0.0878).abs() < 1e-3);
    }
}
