//! Soil against published measurements: slip sinkage, shallow snow, and the vehicle cone index.

use crate::bench::Bench;
use crate::check::{Expectation, Expected, Kind};
use crate::event::{Event, Outcome, Place, Plot, Vehicles};
use crate::grounds::{flat, soil};
use crate::mobility_index::{CONE_INDEX, Wheeled};
use crate::rig::Drive;
use vb_sim::{
    SimError, SoilSet, VehicleState,
    soil::{Sinkage, Snow, SoilLaw, WheelRig},
};
use vb_world::TerrainClass;

/// The set whose soils are compared with measurements.
const SET: &str = "default";

/// The set, or a note that it is missing.
fn default_set<'a>(bench: &Bench<'a>, o: &mut Outcome) -> Option<&'a SoilSet> {
    let set = bench.soils.iter().find(|s| s.name == SET);
    if set.is_none() {
        o.note(format!("The soil set {SET} is missing: not run."));
    }
    set
}

pub(super) const SLIP: Event = Event {
    name: "slip-sinkage",
    title: "Slip sinkage on soil",
    about: "A rigid wheel of the HMMWV's size in a soil bin, on the sand and mud of the default soils: drawbar pull and sinkage over \
            slip. Slip sinkage is large in sand and small in clay.",
    vehicles: Vehicles::Wheeled,
    place: Place::Stand,
    run: slip,
};

/// Slips of a driven wheel.
const SLIPS: [f64; 10] = [0.03, 0.06, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.6, 0.95];

fn slip(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let Some(set) = default_set(bench, &mut o) else { return Ok(o) };
    let load = 2597.0 * vb_vehicle::GRAVITY / 4.0;
    let rig = WheelRig {
        radius: 0.467,
        width: 0.3175,
        load,
        speed: 1.0,
        step: bench.options.step,
        resolution: bench.options.soil_resolution,
    };
    let mut pulls = Plot::new("Drawbar pull over slip", "slip", "drawbar pull / load");
    let mut depths = Plot::new("Sinkage over slip", "slip", "sinkage, mm");
    for name in ["soft-sand", "medium-sand", "hard-sand", "soft-mud", "medium-mud", "hard-mud"] {
        let Some(law) = set.soils.get(name) else { continue };
        let runs = SLIPS.map(|s| rig.run(law, s, 1));
        let pull = runs.map(|r| r.drawbar / load);
        let best = (0..SLIPS.len()).fold(0, |best, k| if pull[k] > pull[best] { k } else { best });
        let (most, last) = (pull[best], pull[SLIPS.len() - 1]);
        o.figure(format!("{name}: slip at the greatest pull"), SLIPS[best], "");
        o.figure(format!("{name}: greatest pull / load"), most, "");
        if name == "soft-sand" {
            o.theory.push(Expectation {
                figure: format!("{name}: slip at the greatest pull"),
                expected: Expected::Between(0.15, 0.4),
                kind: Kind::Published,
                source: "wheels on dry sand pull most at a slip of 15 to 25 % (Freitag, Green and Melzer, WES TR M-70-2, \
                         1970), tyres up to 40 % (Lyasko 2010)"
                    .to_owned(),
                unsound: None,
            });
        }
        let change = last - most;
        let expected = match name {
            "soft-sand" => Expected::AtMost(-0.03),
            _ if name.ends_with("mud") => Expected::Between(-0.05, 0.0),
            _ => Expected::AtMost(0.0),
        };
        let source = "slip sinkage is strong in dry sand and weak in clay (Reece 1965)";
        o.published(&format!("{name}: pull at 95 % slip less the greatest"), change, "", expected, source);
        pulls.ours(name, SLIPS.into_iter().zip(pull).map(|(s, p)| [s, p]).collect());
        depths.ours(name, SLIPS.iter().zip(&runs).map(|(s, r)| [*s, 1e3 * r.sinkage]).collect());
    }
    o.plots.extend([pulls, depths]);
    Ok(o)
}

pub(super) const SNOW: Event = Event {
    name: "snow-wheel",
    title: "Wheel on shallow snow",
    about: "The wheel of CRREL's instrumented vehicle towed over soil that is snow of finite depth: sinkage, and motion resistance \
            over load. The rigid wheel has the chord of the deflected tyre.",
    vehicles: Vehicles::Wheeled,
    place: Place::Stand,
    run: snow,
};

/// Depth and density of the snow (m, kg/m³), sinkage (m) and resistance over load that were measured: CRREL TR-01-16,
/// table 11.
const MEASURED: [[f64; 4]; 6] = [
    [0.13, 160.0, 0.10, 0.05],
    [0.19, 170.0, 0.15, 0.08],
    [0.21, 220.0, 0.17, 0.10],
    [0.21, 220.0, 0.17, 0.12],
    [0.18, 220.0, 0.13, 0.05],
    [0.14, 110.0, 0.10, 0.02],
];

fn snow(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let Some(set) = default_set(bench, &mut o) else { return Ok(o) };
    let Some(base) = set.soils.get("medium-snow") else { return Ok(o) };
    let mut plot = Plot::new("Motion resistance over measured", "measured R/W", "R/W");
    let mut points = Vec::new();
    for (k, [depth, density, sinkage, resistance]) in MEASURED.into_iter().enumerate() {
        let law = SoilLaw { sinkage: Sinkage::Snow(Snow { depth, density }), ..*base };
        let run = crrel_wheel(bench, sinkage).run(&towed(law), 0.0, 1);
        let r = run.compaction / CRREL_LOAD;
        let name = format!("{}: {depth} m of {density} kg/m³", k + 1);
        o.figure(format!("{name}: sinkage"), 1e3 * run.sinkage, "mm");
        o.published(
            &format!("{name}: motion resistance / load"),
            r,
            "",
            Expected::Within { value: resistance, tolerance: 0.04 },
            "CRREL TR-01-16 (2001), table 11",
        );
        points.push([resistance, r]);
    }
    plot.ours("simulated", points);
    o.plots.push(plot);
    Ok(o)
}

/// Load of a front wheel of CRREL's instrumented vehicle, N (CRREL Report 95-7).
const CRREL_LOAD: f64 = 6800.0;

/// The front wheel of CRREL's instrumented vehicle: radius 0.38 m (TR-01-16); at 179 kPa it is 0.256 m wide and its
/// tyre deflects by 0.037 m (Report 95-7). A rigid wheel of the radius R (1 + δ/z) meets the snow along the chord of a
/// tyre that is deflected by δ: 2 R (z + δ) = 2 R' z.
fn crrel_wheel(bench: &Bench<'_>, sinkage: f64) -> WheelRig {
    WheelRig {
        radius: 0.38 * (1.0 + 0.037 / sinkage),
        width: 0.256,
        load: CRREL_LOAD,
        speed: 1.0,
        step: bench.options.step,
        resolution: bench.options.soil_resolution,
    }
}

/// The law without shear and damping: the table has the resistance of the snow's compaction alone.
fn towed(law: SoilLaw) -> SoilLaw {
    SoilLaw { cohesion: 0.0, friction_angle_deg: 0.0, damping: 0.0, ..law }
}

pub(super) const CONE: Event = Event {
    name: "vehicle-cone-index",
    title: "Vehicle cone index",
    about: "From a standstill at full throttle over level soil that is saturated clay: the vehicle passes a soil whose rating cone \
            index is 1.3 times its vehicle cone index VCI₁, and is immobilised in one of 0.7 times.",
    vehicles: Vehicles::Wheeled,
    place: Place::Soil,
    run: cone,
};

/// Cone resistance over the undrained cohesion of a clay: 8 to 25 in 407 tests of 62 clays, 10 to 18 as a rule (Mayne
/// and Peuchen, Cone Penetration Testing 2018, 423–429; Lunne, Robertson and Powell, Cone Penetration Testing in
/// Geotechnical Practice, 1997); the middle of the rule.
const CONE_FACTOR: f64 = 14.0;

/// The set's medium mud with the cohesion and the moduli of a rating cone index throughout, for all classes.
fn clay(set: &SoilSet, index: f64) -> Option<SoilSet> {
    let base = set.soils.get("medium-mud")?;
    let cohesion = index * CONE_INDEX / CONE_FACTOR;
    let law = SoilLaw { cohesion, sinkage: base.sinkage.softer(base.cohesion / cohesion), ..*base };
    let mut set = set.clone();
    set.soils.values_mut().for_each(|l| *l = law);
    Some(set)
}

/// Way that a vehicle must have made to have passed, full-size m: three of its lengths.
const PASSED: f64 = 15.0;

fn cone(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let Some(set) = default_set(bench, &mut o) else { return Ok(o) };
    let spec = bench.spec;
    if spec.scale != 1.0 || !spec.axles.iter().all(|a| a.driven) {
        o.note("The mobility index applies to full-size vehicles with all axles driven: not run.");
        return Ok(o);
    }
    let rest = Drive::new(bench, "rest", &flat(0.8), 0.0, 0.0)?.state();
    let lowest = bench.geometry.hull_of(&rest).iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
    let engine = &spec.powertrain.engine;
    let power = (1..=200).map(|k| 5.0 * f64::from(k)).map(|w| w * engine.torque(w, 1.0)).fold(0.0, f64::max);
    let corner = &bench.geometry.corners[0];
    let vehicle = Wheeled {
        weight: bench.geometry.weight(),
        axles: spec.axles.len(),
        tyres: bench.geometry.corners.len(),
        width: corner.width,
        radius: corner.radius,
        clearance: lowest,
        power,
        automatic: true,
    };
    let index = vehicle.one_pass();
    o.figure("mobility index", vehicle.mobility_index(), "");
    o.figure("vehicle cone index VCI₁", index, "psi");
    let source = "VCI₁ is the weakest soil that is passed once (Priddy and Willoughby 2006); cone resistance of clay 14 c";
    for (times, expected) in [(1.3, Expected::AtLeast(PASSED)), (0.7, Expected::AtMost(PASSED / 3.0))] {
        let Some(soils) = clay(set, times * index) else { continue };
        let case = format!("{times}-vci");
        let mut d = Drive::on_soil(bench, &soils, &case, &soil(TerrainClass::Mud, 120.0, 40.0, 0.0), -40.0)?;
        let from = d.state().position.x;
        let drive = |s: &VehicleState| crate::pace::controls(bench.pace.hold_line(s), 1.0, 0.0);
        d.run(20.0, drive, |s| s.position.x - from >= 2.0 * PASSED)?;
        let s = d.state();
        let sinkage = s.wheels.iter().map(|w| w.sinkage).sum::<f64>() / s.wheels.len() as f64;
        o.figure(format!("RCI {times} VCI₁: sinkage at the end"), 1e3 * sinkage, "mm");
        let name = format!("RCI {times} VCI₁: way in 20 s");
        o.published(&name, s.position.x - from, "m", expected, source);
        o.series.push(d.finish());
    }
    Ok(o)
}
