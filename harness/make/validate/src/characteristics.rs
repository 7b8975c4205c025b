//! What the file of a vehicle says about its ride, roll, articulation and shape, without driving it.
//!
//! The definitions are those of Gillespie, Fundamentals of Vehicle Dynamics (1992), ch. 5 and 6, and of SAE J1100, SAE J695 and
//! SAE J670; docs/custom-vehicle.md has them. Rates and motion ratios are those of the solved linkages at the travels at which
//! the vehicle stands on level ground.

use nalgebra::{UnitQuaternion, Vector3};
use serde::Serialize;
use std::f64::consts::PI;
use vb_math::angle::degrees;
use vb_math::{asin, atan2, hypot};
use vb_sim::tyre::Tyre;
use vb_vehicle::{
    GRAVITY, VehicleSpec,
    kinematics::{Side, elements},
    suspension::Linkage,
};

use crate::bench::Bench;
use crate::statics::Statics;

/// Speed of a wheel at which dampers are measured at full size, m/s. Ours: the greatest of a wheel that moves by 25 mm to each side
/// at 1.3 Hz, the ride of a truck. It matters for dampers that are not linear.
const DAMPED_AT: f64 = 0.2;
/// The mass (kg) above which a vehicle has to ride as one: below it are robots and karts.
const HEAVY: f64 = 500.0;
/// The ride frequency (Hz) above which a vehicle is too stiff. Cars ride at 1 to 1.5 Hz, trucks at up to 2 Hz (Gillespie, ch. 5).
const STIFF: f64 = 2.5;
/// The damping ratio above which a suspension is overdamped. Cars and trucks have 0.2 to 0.4 (Gillespie, ch. 5).
const OVERDAMPED: f64 = 0.8;
/// The roll gradient (°/g) below which a vehicle leans too little. Cars and trucks have 3 to 7 °/g (Gillespie, ch. 6).
const UPRIGHT: f64 = 2.0;
/// The articulation over the wheelbase below which wheels lift too soon. A ramp of 20° (the ramp travel index, RTI) lifts such a vehicle
/// at an index of 290, which is that of a road car.
const RIGID: f64 = 0.1;

/// Parts in which an edge of the hull is looked at.
const EDGE: u32 = 20;

/// The ride of one sprung axle, for each of its wheels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ride {
    /// The sprung mass that one wheel carries, kg.
    pub sprung_mass_kg: f64,
    /// The shortening of the first spring per rise of the wheel; none for torsion bars, which turn.
    pub motion_ratio: Option<f64>,
    /// The stiffness of springs and stops at the wheel in heave, N/m.
    pub wheel_rate_n_per_m: f64,
    /// The natural frequency of the sprung mass on the wheel rate, Hz. The tyre is taken to be hard.
    pub ride_frequency_hz: f64,
    /// The natural frequency of the sprung mass on the wheel rate and the tyre in series, Hz.
    pub frequency_with_tyre_hz: f64,
    /// The damping at the wheel over the critical one of the sprung mass on the wheel rate, in compression (jounce) and in rebound.
    pub damping_ratio: [f64; 2],
}

#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AxleCharacteristics {
    pub name: String,
    /// Its ride; none for wheels that are fixed to the chassis, or that bear nothing.
    pub ride: Option<Ride>,
    /// The height of its roll centre above ground, m; 0 for wheels fixed to the chassis.
    pub roll_centre_height_m: f64,
}

/// What the file of a vehicle says about it, standing on level ground. SI units, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Characteristics {
    /// The mass of the vehicle, kg.
    #[serde(skip)]
    mass: f64,
    /// The distance between the first and the last axle, m.
    #[serde(skip)]
    wheelbase: f64,
    /// The axles, front to back.
    pub axles: Vec<AxleCharacteristics>,
    /// The roll of the body over the ground per lateral acceleration, on suspensions and tyres, °/g; none for a body that its springs
    /// don't hold upright.
    pub roll_gradient_deg_per_g: Option<f64>,
    /// The height of the ground under one front wheel at which another wheel lifts, m; none where statics finds none.
    pub articulation_m: Option<f64>,
    /// The height of blocks under a front wheel and the rear one diagonally across from it at which another wheel lifts, m.
    pub diagonal_articulation_m: Option<f64>,
    /// The height above ground of the lowest point of the hull, m; none without a hull.
    pub ground_clearance_m: Option<f64>,
    /// The angle of approach, °: of the steepest ramp that the front tyres meet before the hull does, at most 90.
    pub approach_angle_deg: f64,
    /// The angle of departure, °, the same behind.
    pub departure_angle_deg: f64,
    /// The ramp break-over angle, °: between two planes that meet under the hull and touch the tyres of neighbouring axles; none on
    /// tracks, or where the hull is not in their way.
    pub break_over_angle_deg: Option<f64>,
    /// The radius of the circle of the outer front wheel's middle at full lock, wheels rolling without slip, m; none for a vehicle that
    /// no wheel steers. Of both locks the wider.
    pub outer_front_wheel_radius_m: Option<f64>,
}

/// A disc in side view.
#[derive(Clone, Copy)]
struct Disc {
    x: f64,
    z: f64,
    radius: f64,
}

/// The slope (rad) of the line through a point ahead of a disc that touches the disc from below; none for a point within the disc, and a
/// right angle or more for one above it. `[ahead, above]` is where the point is from the disc's centre, m.
fn tangent([ahead, above]: [f64; 2], radius: f64) -> Option<f64> {
    let distance = hypot(ahead, above);
    (distance > radius).then(|| atan2(above, ahead) + asin(radius / distance))
}

/// The steepest ramp (rad) that discs touch before any of the points does: `forward` is +1 ahead and −1 behind.
fn ramp(discs: &[Disc], points: &[Vector3<f64>], forward: f64) -> f64 {
    let limit = |p: &Vector3<f64>| {
        // A point is clear of the ramp as long as one disc keeps it off.
        let clear = |d: &Disc| {
            let ahead = forward * (p.x - d.x);
            if ahead <= 0.0 { PI } else { tangent([ahead, p.z - d.z], d.radius).unwrap_or(PI) }
        };
        discs.iter().map(clear).fold(0.0, f64::max)
    };
    points.iter().map(limit).fold(0.5 * PI, f64::min)
}

/// The ramp break-over angle (rad) between two discs.
fn break_over(front: Disc, rear: Disc, points: &[Vector3<f64>]) -> Option<f64> {
    let down = |p: &Vector3<f64>, d: Disc| {
        // The plane falls from the point and passes under the disc.
        let (away, above) = ((d.x - p.x).abs(), d.z - p.z);
        let distance = hypot(away, above);
        (distance > d.radius).then(|| asin(d.radius / distance) - atan2(above, away))
    };
    let between = points.iter().filter(|p| p.x < front.x && p.x > rear.x);
    between.filter_map(|p| Some(down(p, front)? + down(p, rear)?)).filter(|a| *a < PI).min_by(f64::total_cmp)
}

/// How the wheels stand on level ground.
struct Rest {
    /// N.
    loads: Vec<f64>,
    /// m, positive in compression.
    travels: Vec<f64>,
}

impl Rest {
    /// By statics, which knows no brakes that hold wheels apart; as the simulation settles where statics knows nothing of the vehicle.
    fn of(bench: &Bench<'_>, statics: Option<&Statics<'_>>) -> Self {
        let level = vec![0.0; bench.geometry.corners.len()];
        match statics.and_then(|s| s.at(&level)) {
            Some(s) => Self { loads: s.loads, travels: s.travels },
            None => Self {
                loads: bench.standing.wheels.iter().map(|w| w.load).collect(),
                travels: bench.geometry.rest.clone(),
            },
        }
    }

    /// The mean load of the wheels of an axle, N.
    fn load(&self, axle: usize) -> f64 {
        mean(axle, |i| self.loads[i])
    }
}

impl Bench<'_> {
    #[must_use]
    pub fn characteristics(&self) -> Characteristics {
        Characteristics::new(self)
    }
}

impl Characteristics {
    pub(crate) fn new(bench: &Bench<'_>) -> Self {
        let (g, spec, s) = (&bench.geometry, bench.spec, &bench.standing);
        let hull = g.hull_of(s);
        let lowest = hull.iter().map(|p| p.z).min_by(f64::total_cmp);
        let discs = discs(bench);
        let under = under(bench);
        let pairs = || discs.windows(2).filter_map(|d| break_over(d[0], d[1], &under));
        let break_over = if spec.tracks.is_some() { None } else { pairs().min_by(f64::total_cmp) };
        let wheelbase = g.wheelbase();
        let statics = Statics::new(bench);
        let last = g.corners.len() - 1;
        let lifts = |raised: &[usize]| statics.as_ref()?.lifts(raised, 0.5 * wheelbase);
        let rest = Rest::of(bench, statics.as_ref());
        let springs = Statics::springs(bench);
        let ride: Vec<Option<Ride>> =
            (0..spec.axles.len()).map(|a| ride(bench, &springs, &rest, a)).collect();
        let roll: Vec<Roll> = (0..spec.axles.len()).map(|a| Roll::new(bench, &springs, &rest, a)).collect();
        let axles = spec.axles.iter().zip(ride).zip(&roll).map(|((a, ride), roll)| AxleCharacteristics {
            name: a.name.clone(),
            ride,
            roll_centre_height_m: roll.centre,
        });
        Self {
            mass: g.mass,
            wheelbase,
            axles: axles.collect(),
            roll_gradient_deg_per_g: roll_gradient(bench, &rest, &roll),
            articulation_m: lifts(&[0]),
            diagonal_articulation_m: lifts(&[0, last]),
            ground_clearance_m: lowest,
            approach_angle_deg: degrees(ramp(&discs, &hull, 1.0)),
            departure_angle_deg: degrees(ramp(&discs, &hull, -1.0)),
            break_over_angle_deg: break_over.map(degrees),
            outer_front_wheel_radius_m: outer_front_radius(bench),
        }
    }

    #[must_use]
    pub fn articulation_over_wheelbase(&self) -> Option<f64> {
        Some(self.articulation_m? / self.wheelbase)
    }

    /// Warnings about values that no vehicle of this mass has, a sentence each: what, how much, what is usual, and which fields of the
    /// file make it. Light vehicles get none.
    #[must_use]
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.mass <= HEAVY {
            return warnings;
        }
        for (i, a) in self.axles.iter().enumerate() {
            let Some(ride) = a.ride else { continue };
            let field = format!("axles[{i}].suspension");
            if ride.ride_frequency_hz > STIFF {
                warnings.push(format!(
                    "{field}: axle {} has a ride frequency of {:.2} Hz (wheel rate {:.1} kN/m, {:.0} kg of sprung mass on a wheel); \
                     more than {STIFF} Hz is stiffer than usual for this mass. Check spring rates and strut \
                     positions",
                    a.name,
                    ride.ride_frequency_hz,
                    1e-3 * ride.wheel_rate_n_per_m,
                    ride.sprung_mass_kg
                ));
            }
            let [jounce, rebound] = ride.damping_ratio;
            let mean = 0.5 * (jounce + rebound);
            if mean > OVERDAMPED {
                warnings.push(format!(
                    "{field}: axle {} has a damping ratio of {mean:.2} ({jounce:.2} in jounce, {rebound:.2} in rebound); more than \
                     {OVERDAMPED} is overdamped. Check dampers and strut positions",
                    a.name
                ));
            }
        }
        if let Some(gradient) = self.roll_gradient_deg_per_g.filter(|r| *r < UPRIGHT) {
            warnings.push(format!(
                "axles: the roll gradient is {gradient:.2} °/g; less than {UPRIGHT} °/g is stiffer in roll than usual for this \
                 mass. Check springs, anti-roll bars and the height of chassis.com"
            ));
        }
        if let (Some(height), Some(over)) = (self.articulation_m, self.articulation_over_wheelbase())
            && over < RIGID
        {
            warnings.push(format!(
                "axles: a wheel lifts when the terrain under one front wheel is {height:.3} m higher, {over:.3} of the wheelbase; less \
                 than {RIGID} is little articulation for a vehicle off the road. Check springs, stops and anti-roll bars"
            ));
        }
        warnings
    }
}

/// The wheels of the left side as they stand, front to back: those on the ground with their loaded radius, those of tracks with the belt.
fn discs(bench: &Bench<'_>) -> Vec<Disc> {
    let (g, s) = (&bench.geometry, &bench.standing);
    let disc = |i: usize| {
        let hub = g.hub_of(s, i);
        let radius = if s.wheels[i].load > 0.0 { hub.z } else { g.corners[i].radius };
        Disc { x: hub.x, z: hub.z, radius }
    };
    (0..g.corners.len()).step_by(2).map(disc).collect()
}

/// Points on the edges of the hull's convex parts in the world: a flat belly meets a crest between its corners.
fn under(bench: &Bench<'_>) -> Vec<Vector3<f64>> {
    let s = &bench.standing;
    let mut points = Vec::new();
    for part in &bench.spec.chassis.hull {
        let part: Vec<Vector3<f64>> =
            part.iter().map(|p| s.position + s.attitude * Vector3::from(*p)).collect();
        for (i, a) in part.iter().enumerate() {
            for b in &part[i + 1..] {
                points.extend((0..=EDGE).map(|k| a.lerp(b, f64::from(k) / f64::from(EDGE))));
            }
        }
    }
    points
}

/// The mean of both wheels of an axle.
fn mean(axle: usize, of: impl Fn(usize) -> f64) -> f64 {
    0.5 * (of(2 * axle) + of(2 * axle + 1))
}

/// The sprung mass on a wheel of an axle, kg.
fn sprung_mass(bench: &Bench<'_>, rest: &Rest, axle: usize) -> f64 {
    rest.load(axle) / GRAVITY - mean(axle, |i| bench.geometry.corners[i].mass)
}

/// The stiffness of a tyre of an axle under its load, N/m.
fn tyre_rate(bench: &Bench<'_>, rest: &Rest, axle: usize) -> f64 {
    let tyre = Tyre::new(bench.spec.tyre_of(&bench.spec.axles[axle]));
    let deflection = tyre.deflection(rest.load(axle));
    let h = 1e-5 * bench.spec.scale;
    (tyre.vertical_force(deflection + h) - tyre.vertical_force(deflection - h)) / (2.0 * h)
}

/// Whether the wheels of an axle move on springs.
fn sprung(spec: &VehicleSpec, axle: usize) -> bool {
    !matches!(spec.axles[axle].suspension.linkage, Linkage::Rigid(_) | Linkage::PivotAxle(_))
}

fn ride(bench: &Bench<'_>, springs: &Statics<'_>, rest: &Rest, axle: usize) -> Option<Ride> {
    let (g, spec) = (&bench.geometry, bench.spec);
    let mass = sprung_mass(bench, rest, axle);
    if !sprung(spec, axle) || mass <= 0.0 {
        return None;
    }
    let h = 1e-5 * spec.scale;
    let push = |shift: f64| {
        let mut q = rest.travels.clone();
        q[2 * axle] += shift;
        q[2 * axle + 1] += shift;
        mean(axle, |i| springs.push(i, &q))
    };
    let rate = (push(h) - push(-h)) / (2.0 * h);
    let suspension = &spec.axles[axle].suspension;
    let elements = elements(suspension);
    let lengths = |shift: f64| {
        let q = [rest.travels[2 * axle] + shift, rest.travels[2 * axle + 1] + shift];
        g.axles[axle].wheel(Side::Left, q, 0.0).struts
    };
    let (below, above) = (lengths(-h), lengths(h));
    let ratio = |k: usize| (below[k] - above[k]) / (2.0 * h);
    let speed = bench.pace.speed(DAMPED_AT);
    // In jounce the struts shorten.
    let damping = |wheel: f64| -> f64 {
        elements.iter().enumerate().map(|(k, e)| e.resistance(-ratio(k) * wheel) * ratio(k) * ratio(k)).sum()
    };
    let critical = 2.0 * (rate * mass).sqrt();
    let frequency = |rate: f64| (rate / mass).sqrt() / (2.0 * PI);
    let tyre = tyre_rate(bench, rest, axle);
    let torsion = usize::from(suspension.linkage.torsion().is_some());
    let spring = suspension.struts.iter().position(|s| s.spring.is_some());
    (rate > 0.0).then(|| Ride {
        sprung_mass_kg: mass,
        motion_ratio: spring.map(|k| ratio(k + torsion)),
        wheel_rate_n_per_m: rate,
        ride_frequency_hz: frequency(rate),
        frequency_with_tyre_hz: frequency(rate * tyre / (rate + tyre)),
        damping_ratio: [damping(speed) / critical, damping(-speed) / critical],
    })
}

/// What an axle does when the body rolls.
struct Roll {
    /// Weight of the sprung and the unsprung mass on it, N.
    weights: [f64; 2],
    /// Stiffness of the suspension, N m/rad; infinite for wheels fixed to the chassis.
    suspension: f64,
    /// Stiffness of the tyres, N m/rad.
    tyres: f64,
    /// Height of the roll centre above ground, m.
    centre: f64,
    /// Height of the wheels' centres above ground, m.
    hub: f64,
}

impl Roll {
    fn new(bench: &Bench<'_>, springs: &Statics<'_>, rest: &Rest, axle: usize) -> Self {
        let (g, s) = (&bench.geometry, &bench.standing);
        let track = g.hub(2 * axle, 0.0, 0.0).y - g.hub(2 * axle + 1, 0.0, 0.0).y;
        let fixed = matches!(bench.spec.axles[axle].suspension.linkage, Linkage::Rigid(_));
        let h = 1e-5 * bench.spec.scale;
        let level = UnitQuaternion::identity();
        let at = |shift: f64| {
            let mut q = rest.travels.clone();
            q[2 * axle] += shift;
            q[2 * axle + 1] -= shift;
            let foot = |i: usize| springs.foot(i, 0.0, &q, &level).y;
            // A wheel's push against the body's roll, and how far the feet move to the left.
            [0.5 * (springs.push(2 * axle, &q) - springs.push(2 * axle + 1, &q)), mean(axle, foot)]
        };
        let (below, above) = (at(-h), at(h));
        let per_travel = |k: usize| (above[k] - below[k]) / (2.0 * h);
        let weight = |mass: f64| 2.0 * mass * GRAVITY;
        Self {
            weights: [weight(sprung_mass(bench, rest, axle)), weight(mean(axle, |i| g.corners[i].mass))],
            // A roll by φ moves the wheels by ± φ t/2.
            suspension: if fixed { f64::INFINITY } else { 0.5 * per_travel(0) * track * track },
            tyres: 0.5 * tyre_rate(bench, rest, axle) * track * track,
            centre: if fixed { 0.0 } else { 0.5 * per_travel(1) * track },
            hub: mean(axle, |i| g.hub_of(s, i).z),
        }
    }
}

/// The roll of the body over the ground per lateral acceleration, °/g: suspension and tyres of each axle in series, the sprung mass above
/// the roll axis, and the axles' own share through roll centres and unsprung masses (Gillespie, ch. 6, with tyres).
fn roll_gradient(bench: &Bench<'_>, rest: &Rest, roll: &[Roll]) -> Option<f64> {
    let (g, s) = (&bench.geometry, &bench.standing);
    let on_ground: Vec<&Roll> = roll
        .iter()
        .enumerate()
        .filter(|(a, _)| rest.load(*a) > 0.01 * g.weight() / g.corners.len() as f64)
        .map(|(_, r)| r)
        .collect();
    let weight = g.chassis_mass * GRAVITY;
    let total: f64 = on_ground.iter().map(|r| r.weights[0]).sum();
    let axis = on_ground.iter().map(|r| r.weights[0] * r.centre).sum::<f64>() / total;
    let arm = (s.position + s.attitude * g.chassis_com).z - axis;
    let (mut moment, mut stiffness) = (weight * arm, -weight * arm);
    for r in on_ground {
        // The part of a moment at the axle that its tyres' roll hands on to the body.
        let part = if r.suspension.is_finite() { r.suspension / (r.suspension + r.tyres) } else { 1.0 };
        moment += part * (r.weights[0] * r.centre + r.weights[1] * r.hub);
        stiffness += part * r.tyres;
    }
    (stiffness > 0.0).then(|| degrees(moment / stiffness))
}

/// The radius of the circle of the outer front wheel's middle without slip, m.
fn outer_front_radius(bench: &Bench<'_>) -> Option<f64> {
    let g = &bench.geometry;
    if bench.spec.tracks.is_some() {
        return None;
    }
    let radius = |steering: f64| {
        let centre = steering * g.rolling_centre(&g.rest, steering)?;
        let wheel = |i: usize| {
            let p = g.hub(i, g.rest[i], steering);
            hypot(p.x - g.turning_line(), p.y - centre)
        };
        Some(wheel(0).max(wheel(1)))
    };
    Some(radius(1.0)?.max(radius(-1.0)?))
}

#[cfg(test)]
mod tests;
