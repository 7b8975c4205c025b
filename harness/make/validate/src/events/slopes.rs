//! Across slopes.

use crate::bench::Bench;
use crate::check::Expected;
use crate::event::{Event, Outcome, Place, Plot, Vehicles};
use crate::grounds::{flat, plane};
use crate::pace::PARKED;
use crate::rig::Drive;
use std::f64::consts::FRAC_PI_2;
use vb_math::angle::{degrees, radians};
use vb_math::atan;
use vb_sim::{SimError, VehicleState};
use vb_vehicle::{
    VehicleSpec,
    suspension::{Linkage, RigidMount, Suspension},
};

pub(super) const SIDE_SLOPE: Event = Event {
    name: "side-slope",
    title: "40 % side slope",
    about: "Across the side slope of the data sheet (40 %, 21.8°) at μ 0.8: standing with brakes for 10 s, and driving along \
            it at 4 m/s for 15 s with the pursuit law: downhill drift in the last 30 m.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: side_slope,
};

fn side_slope(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let ground = plane(atan(0.4), 0.8);
    let mut d = Drive::new(bench, "standing", &ground, 0.0, FRAC_PI_2)?;
    d.hold(2.0, |_| PARKED)?;
    let from = d.state().position;
    d.hold(10.0, |_| PARKED)?;
    o.expect(
        "standing: moved in 10 s",
        1e3 * (d.state().position - from).norm(),
        "mm",
        Expected::AtMost(1.0),
        "statics: 0.4 < μ",
    );
    o.series.push(d.finish());
    let mut d = Drive::new(bench, "driving", &ground, 0.0, FRAC_PI_2)?;
    let (mut off, mut roll) = (0.0_f64, 0.0_f64);
    let downhill = |s: &VehicleState| -s.position.x / vb_math::cos(atan(0.4));
    let mut path = Vec::new();
    d.run(
        15.0,
        |s| bench.pace.hold_speed(s, 4.0, bench.pace.hold_line_across(s)),
        |s| {
            off = off.max(downhill(s).abs());
            path.push([s.position.y, downhill(s)]);
            roll = roll.max(s.roll_pitch_yaw().0.abs());
            false
        },
    )?;
    let s = d.state();
    // The pursuit law holds a line that lies as far downhill as its crab angle needs; what counts is that it holds one.
    let late = path.get(path.len() * 2 / 3).map_or(f64::NAN, |p| p[1]);
    let before = path.iter().rfind(|p| p[0] <= s.position.y - bench.pace.length(30.0));
    o.figure("driving: farthest off the line", off, "m");
    o.figure("driving: sliding downhill in the last 5 s", downhill(&s) - late, "m");
    o.figure("driving: drift in 30 m", downhill(&s) - before.map_or(f64::NAN, |p| p[1]), "m");
    o.figure("driving: greatest roll", degrees(roll), "°");
    o.figure("driving: speed at the end", s.velocity_body.x, "m/s");
    let series = d.finish();
    let mut plot = Plot::map("Path along the side slope", "along the slope, m", "downhill, m");
    plot.ours("μ 0.8", series.rows.iter().map(|r| [r[2], -r[1]]).collect());
    o.plots.push(plot);
    o.series.push(series);
    Ok(o)
}

pub(super) const TILT_TABLE: Event = Event {
    name: "tilt-table",
    title: "Tilt table",
    about: "With brakes, gravity rotates about the longitudinal axis: to the angle at which the vehicle slides (μ 0.9 and 0.5), and with \
            non-sliding tyres to the angle at which it tips, unchanged and on hard tyres with wheels fixed to the chassis.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: tilt_table,
};

/// Sideways speed that counts as sliding, m/s: reached within a second of the limit, and above any motion of springs
/// and tyres at this rate of tilt.
const SLIDING: f64 = 0.02;

/// Sideways speed of the vehicle at the height of the ground, m/s: a body that leans out about its wheels has none there.
fn sliding(s: &VehicleState) -> f64 {
    ((s.attitude * s.velocity_body).y + (s.attitude * s.angular_velocity_body).x * s.position.z).abs()
}

fn tilt_table(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let mut slide = Plot::new("Sideways speed on the tilt table", "tilt, °", "speed, m/s");
    let tips = {
        let s = crate::grounds::at_rest(&bench.model, bench.options)?;
        degrees(atan(0.5 * bench.geometry.track() / bench.geometry.com_of(&s).z))
    };
    for friction in [0.9, 0.5] {
        let limit = degrees(atan(bench.grip(friction)));
        let mut d = Drive::new(bench, &format!("slide-mu-{friction:.1}"), &flat(friction), 0.0, 0.0)?;
        let mut angle = 0.0;
        let mut found = f64::NAN;
        let mut points = Vec::new();
        // 5 degrees a second up to 4 degrees below the limit, then a quarter.
        while angle < limit + 4.0 {
            angle += if angle < limit - 4.0 { 0.05 } else { 0.0025 };
            d.tilt(radians(angle));
            let slid = d.run(0.01, |_| PARKED, |s| angle > limit - 3.5 && sliding(s) > SLIDING)?;
            points.push([angle, sliding(&d.state())]);
            if slid {
                found = angle;
                break;
            }
        }
        let name = format!("slide angle, μ {friction:.1}");
        o.figure(name.clone(), found, "°");
        // Tall vehicles tip first, and lean out as they come near to it.
        if limit < tips - 8.0 {
            o.theory(name, Expected::Within { value: limit, tolerance: 0.5 }, "atan μ");
        }
        slide.ours(format!("μ {friction:.1}"), points);
        o.series.push(d.finish());
    }
    let g = &bench.geometry;
    let mut lean = Plot::new("Load on the upper wheels", "tilt, °", "sum of loads / weight");
    for (label, spec) in
        [("as it is", sticky(bench.spec)), ("without springs", stiff(&on_hard_tyres(bench.spec)))]
    {
        let mut d = Drive::with_spec(
            bench,
            &spec,
            &format!("tip-{}", label.replace(' ', "-")),
            &flat(TIP_FRICTION),
            0.0,
            0.0,
        )?;
        let s = d.state();
        let height = g.com_of(&s).z;
        let rigid = degrees(atan(0.5 * g.track() / height));
        let outermost = degrees(atan((0.5 * g.track() + 0.5 * g.corners[0].width) / height));
        let (mut angle, mut carried, mut points) = (0.0, 0.0, Vec::new());
        while angle < rigid + 8.0 {
            angle += if angle < rigid - 20.0 { 0.05 } else { 0.005 };
            d.tilt(radians(angle));
            let fell = d.run(0.01, |_| PARKED, |s| s.roll_pitch_yaw().0.abs() > 0.6)?;
            // The table's low side is that of +y, the left.
            let upper: f64 = d.state().wheels.iter().skip(1).step_by(2).map(|w| w.load).sum();
            if upper > 0.0 {
                carried = angle;
            }
            points.push([angle, upper / g.weight()]);
            if fell {
                break;
            }
        }
        let name = format!("tip angle, {label}");
        o.figure(name.clone(), carried, "°");
        o.figure(format!("height of the centre of mass, {label}"), height, "m");
        if label == "without springs" {
            o.theory(
                name,
                Expected::Between(rigid - 1.0, outermost + 0.5),
                "rigid body: atan(b / h), b from the middles of the treads, on which it stands level, to their outer edges, onto which hard treads lean",
            );
        } else {
            o.theory(
                name,
                Expected::Between(rigid - 10.0, outermost + 0.5),
                "springs and tyres let the body lean out from the rigid body's atan(b / h), b to the treads' outer edges, on which the load comes to stand",
            );
        }
        lean.ours(label, points);
        o.series.push(d.finish());
    }
    o.plots.extend([slide, lean]);
    Ok(o)
}

/// Friction with which no vehicle slides before it tips.
pub(super) const TIP_FRICTION: f64 = 4.0;

/// The vehicle with tyres that have this friction. Fiala's and TMeasy take the ground's by themselves.
pub(super) fn sticky(spec: &VehicleSpec) -> VehicleSpec {
    let mut spec = spec.clone();
    let own = spec.axles.iter_mut().filter_map(|a| a.tyre.as_mut());
    for tyre in own.chain(std::iter::once(&mut spec.tyre)) {
        tyre.set_coulomb_friction(TIP_FRICTION);
    }
    spec
}

/// The vehicle on its hard tyres, if it has some: the theory of a rigid body has no tyres that give way.
fn on_hard_tyres(spec: &VehicleSpec) -> VehicleSpec {
    spec.clone().with_tyre("rigid").unwrap_or_else(|_| spec.clone())
}

/// The vehicle with its wheels fixed to the chassis at design height.
pub(super) fn stiff(spec: &VehicleSpec) -> VehicleSpec {
    let mut spec = sticky(spec);
    for axle in &mut spec.axles {
        let spindle = axle.suspension.linkage.spindle();
        // What a beam weighs is that of its wheels now: they are no longer on it.
        axle.unsprung_mass += axle.suspension.linkage.beam().map_or(0.0, |b| 0.5 * b.mass);
        axle.steering = None;
        axle.suspension = Suspension {
            linkage: Linkage::Rigid(RigidMount { spindle }),
            range: [0.0; 2],
            struts: Vec::new(),
            stops: None,
            anti_roll: None,
        };
    }
    spec
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vehicle_without_springs_weighs_what_it_does_with_them() {
        for text in [
            include_str!("../../../../../tasks/vehicles/man5t.yaml"),
            include_str!("../../../../../tasks/vehicles/hmmwv.yaml"),
        ] {
            let spec = VehicleSpec::parse(text, "vehicle.yaml").unwrap();
            let mass = |spec: &VehicleSpec| Bench::new(spec, &[], 1e-3).unwrap().geometry.mass;
            assert!((mass(&stiff(&spec)) - mass(&spec)).abs() < 1e-9, "{}", spec.name);
        }
    }
}
