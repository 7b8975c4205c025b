//! The smallest circle.

use crate::bench::Bench;
use crate::event::{Event, LineKind, Outcome, Place, Plot, Vehicles};
use crate::grounds::flat;
use crate::pace::speed;
use crate::rig::Drive;
use nalgebra::Vector3;
use vb_math::angle::degrees;
use vb_math::{hypot, tan};
use vb_sim::SimError;

pub(super) const TURNING_CIRCLE: Event = Event {
    name: "turning-circle",
    title: "Turning circle",
    about: "Full lock at 2 m/s: radius of the reference point, of the outermost tyre edge (curb to curb), of the middle \
            of the outer front wheel's tread and of the outermost point of the body (wall to wall), compared with that of wheels without slip.",
    vehicles: Vehicles::All,
    place: Place::Rigid,
    run: turning_circle,
};

fn turning_circle(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let g = &bench.geometry;
    let mut plot = Plot::map("Circle at full lock", "x, m", "y, m");
    let mut locks = Vec::new();
    for (side, steering) in [("left", 1.0), ("right", -1.0)] {
        let mut d = Drive::new(bench, side, &flat(0.9), 0.0, 0.0)?;
        d.hold(10.0, |s| bench.pace.hold_speed(s, 2.0, steering))?;
        let (mut centre, mut count) = (Vector3::zeros(), 0.0);
        let (mut path, mut curb, mut wall) = (0.0, 0.0, 0.0);
        d.run(
            10.0,
            |s| bench.pace.hold_speed(s, 2.0, steering),
            |s| {
                // The centre of turning: where the velocity field of the rigid body is zero.
                let v = s.attitude * s.velocity_body;
                centre += s.position + Vector3::new(-v.y, v.x, 0.0) / s.angular_velocity_body.z;
                path += speed(s) / s.angular_velocity_body.z.abs();
                count += 1.0;
                false
            },
        )?;
        centre /= count;
        path /= count;
        let from = |p: Vector3<f64>| hypot(p.x - centre.x, p.y - centre.y);
        let s = d.state();
        for i in 0..s.wheels.len() {
            curb = from(g.tyre_edge_of(&s, i)).max(curb);
        }
        for p in g.hull_of(&s) {
            wall = from(p).max(wall);
        }
        o.figure(format!("{side}: radius of the reference point"), path, "m");
        if bench.spec.tracks.is_none() {
            let front = from(g.hub_of(&s, 0)).max(from(g.hub_of(&s, 1)));
            o.figure(format!("{side}: radius of the outer front wheel"), front, "m");
            let middle = from(0.5 * (g.hub_of(&s, 0) + g.hub_of(&s, 1)));
            o.figure(format!("{side}: radius of the middle of the front axle"), middle, "m");
        }
        o.figure(format!("{side}: curb-to-curb radius"), curb, "m");
        o.figure(format!("{side}: wall-to-wall radius"), wall, "m");
        if let Some(centre) = g.rolling_centre(&g.rest, steering) {
            let rolling = rolling_curb(bench, steering, centre);
            let lock = g.rest.iter().enumerate().map(|(i, q)| degrees(g.wheel_angle(i, *q, steering)).abs());
            let lock = lock.fold(0.0, f64::max);
            o.figure(format!("{side}: greatest angle of a wheel"), lock, "°");
            if g.is_steered(0) {
                let mean =
                    0.5 * (g.wheel_angle(0, g.rest[0], steering) + g.wheel_angle(1, g.rest[1], steering));
                o.figure(format!("{side}: mean angle of the front wheels"), degrees(mean).abs(), "°");
            }
            o.figure(format!("{side}: curb-to-curb radius without slip"), rolling, "m");
            locks.push([lock, rolling]);
        }
        let series = d.finish();
        plot.ours(side, series.pairs("x", "y"));
        o.series.push(series);
    }
    o.plots.push(plot);
    if let Some(lock) = locks.first() {
        o.plots.push(over_the_lock(bench, *lock));
    }
    Ok(o)
}

/// Curb-to-curb radius (m) of wheels that roll without slip about a point on the line about which the vehicle turns, so far
/// (m) from its centre line.
fn rolling_curb(bench: &Bench<'_>, steering: f64, centre: f64) -> f64 {
    let g = &bench.geometry;
    let side = if steering > 0.0 { 1.0 } else { -1.0 };
    let edge = |i: usize| {
        let p = g.tyre_edge(i, g.rest[i], steering);
        hypot(p.x - g.turning_line(), p.y - side * centre)
    };
    (0..g.corners.len()).map(edge).fold(0.0, f64::max)
}

/// What the lock makes of the circle: the radius of the steering gear over its command, and that of wheels which all turn about
/// one centre (Ackermann), over the angle (°) of the wheel that turns most. It tells which angle a published circle asks for.
fn over_the_lock(bench: &Bench<'_>, full: [f64; 2]) -> Plot {
    let g = &bench.geometry;
    let mut plot = Plot::new(
        "Curb-to-curb radius over the lock",
        "greatest angle of a wheel, °",
        "curb-to-curb radius without slip, m",
    );
    let geared = (8..=20).filter_map(|k| {
        let command = f64::from(k) / 20.0;
        let angle = (0..g.corners.len()).map(|i| degrees(g.wheel_angle(i, g.rest[i], command)).abs());
        Some([angle.fold(0.0, f64::max), rolling_curb(bench, command, g.rolling_centre(&g.rest, command)?)])
    });
    plot.ours("by its steering gear, up to full lock", geared.collect());
    // The inner wheel turns most, the outer one of the same axle has its edge farthest out.
    let front = (0..g.corners.len()).find(|&i| g.is_steered(i)).unwrap_or(0);
    let (ahead, aside) = (g.hub(front, 0.0, 0.0).x - g.turning_line(), 0.5 * g.track());
    let ideal = |angle: f64| {
        let outer = hypot(ahead, ahead / tan(angle.to_radians()) + 2.0 * aside);
        [angle, outer + 0.5 * g.corners[front].width]
    };
    let angles = (0..=40).map(|k| 0.4 * full[0] + f64::from(k) * 0.025 * (45.0 - 0.4 * full[0]));
    plot.line(LineKind::Theory, 0, "all wheels about one centre", angles.map(ideal).collect());
    plot
}
