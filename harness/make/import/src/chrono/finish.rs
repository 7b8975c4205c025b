//! From parts to a vehicle: the frame, the travels, what a source does not give.

use super::parts::Parts;
use super::powertrain::{power, top_speed};
use crate::hull::{block, solid};
use crate::place::{Mass, add, sub};
use crate::{ImportError, Imported, Kind, Notes, Options};
use std::collections::BTreeMap;
use vb_vehicle::kinematics::{AxleKinematics, Side};
use vb_vehicle::powertrain::Powertrain;
use vb_vehicle::suspension::{
    AntiRoll, KnuckleDrive, Knuckles, Linkage, Steering, SteeringGear, Stops, Suspension,
};
use vb_vehicle::tracks::Tracks;
use vb_vehicle::{Axle, Chassis, GRAVITY, Point, TyreSpec, VehicleSpec};

/// The travel over which a linkage is solved, over the wheel's radius, if it closes so far.
const TRAVEL: f64 = 0.35;
/// Parts of the steering gear's travel that are tried, the first one for which the linkage closes.
const GEAR: &[f64] = &[1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4];
/// Distance beyond which the reference point of an axle moves to its wheels, m.
const NEAR: f64 = 0.25;
/// Rolling resistance with which the engine's power ends the top speed.
const ROLLING: f64 = 0.03;
/// The length of the vehicles for which full-size worlds are made, m.
pub(crate) const FULL_SIZE: f64 = 3.8;

/// A vehicle in the source's frame.
pub(crate) struct Draft {
    pub(crate) name: String,
    pub(crate) sprung: Mass,
    pub(crate) seat: Option<Point>,
    pub(crate) hull: Vec<Vec<Point>>,
    pub(crate) friction: Option<f64>,
    pub(crate) axles: Vec<Axle>,
    pub(crate) tyres: Vec<TyreSpec>,
    pub(crate) steering: Steering,
    pub(crate) tracks: Option<Tracks>,
    pub(crate) skid: Option<vb_vehicle::skid::Skid>,
    pub(crate) powertrain: Powertrain,
}

/// A suspension without range and stops, which [`wheeled`] adds.
pub(crate) fn sprung(parts: Parts) -> Suspension {
    Suspension {
        linkage: parts.linkage,
        range: [0.0; 2],
        struts: parts.struts,
        stops: None,
        anti_roll: parts.anti_roll,
    }
}

/// Moves all points of an axle against its reference point.
fn refer(axle: &mut Axle, d: Point) {
    let m = |p: &mut Point| *p = sub(*p, d);
    // Points of the left side: a sideways move would not be mirrored, so there is none.
    let knuckles = |k: &mut Option<Knuckles>| {
        let Some(k) = k else { return };
        [&mut k.kingpin_lower, &mut k.kingpin_upper, &mut k.tie_rod, &mut k.drag_link_inner]
            .into_iter()
            .for_each(m);
        match &mut k.by {
            KnuckleDrive::Toebar { drag_link_outer } => m(drag_link_outer),
            KnuckleDrive::Bellcrank { pivot, drag_link_outer, tie_rod_left, tie_rod_right, .. } => {
                [pivot, drag_link_outer, tie_rod_left, tie_rod_right].into_iter().for_each(m);
            }
        }
    };
    let s = &mut axle.suspension;
    match &mut s.linkage {
        Linkage::DoubleWishbone(l) => [
            &mut l.spindle,
            &mut l.upper_arm_front,
            &mut l.upper_arm_rear,
            &mut l.upper_ball_joint,
            &mut l.lower_arm_front,
            &mut l.lower_arm_rear,
            &mut l.lower_ball_joint,
            &mut l.tie_rod_inner,
            &mut l.tie_rod_outer,
        ]
        .into_iter()
        .for_each(m),
        Linkage::SingleWishbone(l) => [
            &mut l.spindle,
            &mut l.arm_front,
            &mut l.arm_rear,
            &mut l.kingpin_lower,
            &mut l.kingpin_upper,
            &mut l.tie_rod_inner,
            &mut l.tie_rod_outer,
        ]
        .into_iter()
        .for_each(m),
        Linkage::Multilink(l) => {
            [&mut l.spindle, &mut l.tie_rod_inner, &mut l.tie_rod_outer].into_iter().for_each(m);
            l.links.iter_mut().flat_map(|r| [&mut r.chassis, &mut r.carrier]).for_each(m);
        }
        Linkage::TorsionArm(l) => [&mut l.spindle, &mut l.pivot].into_iter().for_each(m),
        Linkage::SolidAxle(l) => {
            m(&mut l.spindle);
            l.links
                .iter_mut()
                .chain(&mut l.single_links)
                .flat_map(|r| [&mut r.chassis, &mut r.carrier])
                .for_each(m);
            knuckles(&mut l.knuckles);
        }
        Linkage::LeafAxle(l) => {
            [&mut l.spindle, &mut l.seat, &mut l.eye].into_iter().for_each(m);
            knuckles(&mut l.knuckles);
        }
        Linkage::PivotAxle(l) => {
            m(&mut l.spindle);
            l.pin_height -= d[2];
            knuckles(&mut l.knuckles);
        }
        Linkage::Rigid(l) => m(&mut l.spindle),
    }
    s.struts.iter_mut().flat_map(|s| [&mut s.chassis, &mut s.end]).for_each(m);
    if let Some(AntiRoll::Bar { pivot, arm_end, link_end, .. }) = &mut s.anti_roll {
        [pivot, arm_end, link_end].into_iter().for_each(m);
    }
    match &mut axle.steering {
        Some(SteeringGear::PitmanArm { pivot, arm_end, idler_pivot, idler_end, .. }) => {
            [pivot, arm_end, idler_pivot, idler_end].into_iter().for_each(m);
        }
        Some(SteeringGear::RotaryArm { pivot, .. }) => m(pivot),
        Some(SteeringGear::RackAndPinion { .. }) | None => {}
    }
    axle.position = add(axle.position, d);
}

fn hub(a: &Axle) -> Point {
    add(a.position, a.suspension.linkage.spindle())
}

/// A vehicle on wheels.
pub(crate) fn wheeled(
    mut draft: Draft,
    options: &Options,
    notes: &mut Notes,
) -> Result<VehicleSpec, ImportError> {
    let sorted = draft.axles.is_sorted_by(|a, b| a.position[0] > b.position[0]);
    for a in &mut draft.axles {
        let [x, _, z] = a.suspension.linkage.spindle();
        if !sorted || x.abs() > NEAR || z.abs() > NEAR {
            refer(a, [x, 0.0, z]);
        }
    }
    let (first, last) = (hub(&draft.axles[0]), hub(&draft.axles[draft.axles.len() - 1]));
    let z = draft.axles.iter().map(|a| hub(a)[2]).sum::<f64>() / draft.axles.len() as f64;
    let origin = [0.5 * (first[0] + last[0]), 0.0, z];
    let radius = draft.tyres[0].radius();
    units(&draft, first[0] - last[0], radius)?;
    let mut spec = build(draft, origin, options, notes)?;
    let load = load(&spec);
    for k in 0..spec.axles.len() {
        let radius = spec.tyre_of(&spec.axles[k]).radius();
        travels(&mut spec.axles[k], radius, load, notes)?;
    }
    to_the_left(&mut spec, notes);
    Ok(spec)
}

/// Rejects vehicles whose dimensions are not in SI units.
fn units(draft: &Draft, wheelbase: f64, radius: f64) -> Result<(), ImportError> {
    let mass = draft.sprung.mass;
    if wheelbase > 50.0 || radius > 5.0 || mass > 5e5 {
        let problem = format!(
            "a wheelbase of {wheelbase} m, a wheel radius of {radius} m and {mass} kg: these are not SI units; convert lengths to m and \
             masses to kg"
        );
        return Err(ImportError::new(&draft.name, "", problem));
    }
    Ok(())
}

fn load(spec: &VehicleSpec) -> f64 {
    let wheels = (2 * spec.axles.len()) as f64;
    spec.total_mass() * GRAVITY / wheels
}

/// The vehicle in a frame with its origin at a place of the source's.
pub(crate) fn build(
    draft: Draft,
    origin: Point,
    options: &Options,
    notes: &mut Notes,
) -> Result<VehicleSpec, ImportError> {
    let (com, inertia) = draft.sprung.central();
    let products = [inertia[0][1], inertia[0][2], inertia[1][2]];
    if products.iter().any(|p| p.abs() > 1e-9) {
        let [xy, xz, yz] = products;
        notes.dropped(format!("products of inertia of the sprung body, {xy:.4}, {xz:.4} and {yz:.4} kg m²"));
    }
    let mut moments = [inertia[0][0], inertia[1][1], inertia[2][2]];
    for k in 0..3 {
        let most = 0.999 * (moments.iter().sum::<f64>() - moments[k]);
        if moments[k] > most {
            notes.approximated(format!(
                "chassis.inertia[{k}]: {most:.2} kg m² instead of {:.2}, because no moment of inertia exceeds the sum of the other two",
                moments[k]
            ));
            moments[k] = most;
        }
    }
    let mut axles = draft.axles;
    axles.iter_mut().for_each(|a| a.position = sub(a.position, origin));
    let mut hull: Vec<Vec<Point>> =
        draft.hull.iter().map(|part| part.iter().map(|p| sub(*p, origin)).collect()).collect();
    hull.retain(|p| solid(p));
    if hull.is_empty() {
        hull = vec![plate(&axles, &draft.tyres)];
        notes.assumed("chassis.hull: a block between the wheels, because the source has no collision shapes; replace it by the vehicle's hull");
    }
    let friction = draft.friction.unwrap_or_else(|| {
        notes.assumed("chassis.friction: 0.4 (steel on rock fill, NAVFAC Design Manual 7.02, 1986)");
        0.4
    });
    let (low, high) = extent(&hull, &axles, &draft.tyres);
    let [length, width, height] = sub(high, low);
    let scale = options.scale.unwrap_or_else(|| {
        let scale = scale(length);
        if scale < 1.0 {
            notes.chosen(format!(
                "scale {scale:.4}, from the length of {length:.3} m; another one with --scale"
            ));
        }
        scale
    });
    let common =
        draft.tyres.last().cloned().ok_or_else(|| ImportError::new(&draft.name, "", "has no tyres"))?;
    for (a, t) in axles.iter_mut().zip(&draft.tyres) {
        a.tyre = (*t != common).then(|| t.clone());
    }
    let name = options.name.clone().unwrap_or_else(|| short(&draft.name));
    let seat = draft.seat.map(|s| sub(s, origin));
    let mut spec = VehicleSpec {
        schema: vb_files::Schema,
        name,
        description: format!("{}, imported", draft.name),
        scale,
        deviations: Vec::new(),
        length,
        width,
        height,
        max_speed: 0.0,
        chassis: Chassis {
            mass: draft.sprung.mass,
            com: sub(com, origin),
            inertia: moments,
            seat,
            friction,
            resistance: Vec::new(),
            wheel_faces: draft.tracks.is_none(),
            hull_passes_soil: false,
            hull,
        },
        axles,
        steering: draft.steering,
        tracks: draft.tracks,
        skid: draft.skid,
        tyre: common,
        tyres: BTreeMap::new(),
        powertrain: draft.powertrain,
    };
    if let Some(s) = &mut spec.chassis.seat {
        let most = [length, width, 2.0 * height];
        if (0..3).any(|k| s[k].abs() > most[k]) {
            notes.dropped(format!("the driver's position {s:?}, which is outside the vehicle"));
            spec.chassis.seat = None;
        }
    }
    spec.max_speed = fastest(&spec, notes);
    Ok(spec)
}

/// The scale of the worlds for a vehicle of this length: 1 over a whole number.
pub(crate) fn scale(length: f64) -> f64 {
    if length > 0.65 * FULL_SIZE { 1.0 } else { 1.0 / (FULL_SIZE / length).round().clamp(1.0, 100.0) }
}

/// A name of letters, digits and `_`.
pub(crate) fn short(name: &str) -> String {
    let mut out = String::new();
    for c in name.chars().take(40) {
        match c {
            c if c.is_ascii_alphanumeric() => out.push(c.to_ascii_lowercase()),
            _ if out.ends_with('_') || out.is_empty() => {}
            _ => out.push('_'),
        }
    }
    let out = out.trim_end_matches('_');
    if out.is_empty() { "vehicle".to_owned() } else { out.to_owned() }
}

/// A block between the wheels: what a vehicle without collision shapes gets.
fn plate(axles: &[Axle], tyres: &[TyreSpec]) -> Vec<Point> {
    let (first, last) = (hub(&axles[0]), hub(&axles[axles.len() - 1]));
    let radius = tyres.iter().map(TyreSpec::radius).fold(0.0, f64::max);
    let inner =
        axles.iter().zip(tyres).map(|(a, t)| hub(a)[1] - 0.5 * t.width()).fold(f64::INFINITY, f64::min);
    let size = [first[0] - last[0] + radius, 2.0 * (0.9 * inner).max(0.1 * radius), 2.0 * radius];
    let centre = [0.5 * (first[0] + last[0]), 0.0, 0.9 * radius];
    block(size).iter().map(|p| add(centre, *p)).collect()
}

/// The corners of the box around hull and wheels.
fn extent(hull: &[Vec<Point>], axles: &[Axle], tyres: &[TyreSpec]) -> (Point, Point) {
    let wheels = axles.iter().zip(tyres).flat_map(|(a, t)| {
        let [x, y, z] = hub(a);
        let (r, w) = (t.radius(), y + 0.5 * t.width());
        [[x - r, -w, z - r], [x + r, w, z + r]]
    });
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for p in hull.iter().flatten().copied().chain(wheels) {
        for k in 0..3 {
            low[k] = low[k].min(p[k]);
            high[k] = high[k].max(p[k]);
        }
    }
    (low, high)
}

/// The top speed: of the engine in its highest gear, or where rolling takes all of its power.
fn fastest(spec: &VehicleSpec, notes: &mut Notes) -> f64 {
    let p = &spec.powertrain;
    let gear = p.gearbox.ratios.last().copied().unwrap_or(1.0);
    let drive = p.driveline.axles.first().map_or(1.0, |a| a.final_drive);
    let driven = spec.axles.iter().find(|a| a.driven).unwrap_or(&spec.axles[0]);
    let geared = top_speed(&p.engine) * gear * drive * spec.tyre_of(driven).radius();
    let powered = power(&p.engine) / (ROLLING * spec.total_mass() * GRAVITY);
    let governed = p.governor.as_ref().map_or(f64::INFINITY, |g| g.speed);
    let speed = geared.min(powered).min(governed).max(0.1);
    let by = if governed <= speed {
        "that of the governor"
    } else if geared <= powered {
        "the engine's top speed in the highest gear"
    } else {
        "the engine's power against 3 % of the weight"
    };
    notes.assumed(format!("max_speed: {speed:.1} m/s, {by}"));
    speed
}

/// The range of travel for which the linkage closes, and stops at the wheel near its ends.
pub(crate) fn travels(axle: &mut Axle, radius: f64, load: f64, notes: &mut Notes) -> Result<(), ImportError> {
    if matches!(axle.suspension.linkage, Linkage::Rigid(_)) {
        return Ok(());
    }
    let gear = axle.steering.clone();
    let mut last = None;
    for part in GEAR {
        axle.steering.clone_from(&gear);
        axle.steering.iter_mut().for_each(|g| super::steering::scale(g, *part));
        let mut reach = TRAVEL * radius;
        for _ in 0..12 {
            axle.suspension.range = [-reach, reach];
            match AxleKinematics::solve(axle) {
                Ok(_) => {
                    stops(axle, reach, radius, load, notes);
                    if *part < 1.0 {
                        notes.approximated(format!(
                            "axle {}: its steering gear turns by {:.0} % of its maximum angle, the limit of the linkage",
                            axle.name,
                            100.0 * part
                        ));
                    }
                    return Ok(());
                }
                Err(e) => last = last.or(Some(e.to_string())),
            }
            reach *= 0.8;
        }
        if gear.is_none() {
            break;
        }
    }
    let problem = format!("{}; correct the points in its suspension's file", last.unwrap_or_default());
    Err(ImportError::new(format!("axle {}", axle.name), "", problem))
}

/// Stops at the wheel near the ends of its travel.
fn stops(axle: &mut Axle, reach: f64, radius: f64, load: f64, notes: &mut Notes) {
    let stop = 0.85 * reach;
    let stiffness = 5.0 * load / (0.1 * radius);
    axle.suspension.stops = Some(Stops { jounce: stop, rebound: -stop, stiffness, table: Vec::new() });
    notes.assumed(format!(
        "axle {}: travels of {:.0} mm up and down and stops 15 % before, because the source has no travel limits",
        axle.name,
        1000.0 * reach
    ));
}

/// Turns the steering gears such that a positive command steers to the left.
pub(crate) fn to_the_left(spec: &mut VehicleSpec, notes: &mut Notes) {
    let count = spec.axles.len();
    let Some(k) = spec.axles.iter().position(|a| a.steering.is_some()) else { return };
    let Ok(solved) = AxleKinematics::solve(&spec.axles[k]) else { return };
    let heading = |command: f64| {
        let axis = solved.wheel(Side::Left, [0.0; 2], command).axis;
        vb_math::atan2(-axis[0], axis[1])
    };
    let left = heading(1.0) - heading(0.0);
    // The last of several axles steers to the left by turning its wheels to the right.
    let wanted = if count > 1 && k + 1 == count { -1.0 } else { 1.0 };
    if left * wanted < 0.0 {
        for gear in spec.axles.iter_mut().filter_map(|a| a.steering.as_mut()) {
            super::steering::scale(gear, -1.0);
        }
        notes.chosen("steering gears are reversed, so that command +1 steers to the left");
    }
}

/// Puts approximations and assumptions into the vehicle's own list.
pub(crate) fn deviations(imported: &mut Imported) {
    let texts = [Kind::Approximated, Kind::Assumed]
        .into_iter()
        .flat_map(|k| imported.notes.of(k))
        .map(ToString::to_string);
    imported.spec.deviations = texts.collect();
}
