//! The smallest circle.

use crate::event::{Bench, Event, Outcome, Plot};
use crate::rig::{Drive, flat, speed};
use nalgebra::Vector3;
use vb_math::hypot;
use vb_sim::SimError;

pub(super) const TURNING_CIRCLE: Event = Event {
    name: "turning-circle",
    title: "Turning circle",
    about: "Full lock at 2 m/s: radius of the reference point, of the outermost tyre edge (curb to curb) and of the \
            outermost point of the body (wall to wall).",
    run: turning_circle,
};

fn turning_circle(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let g = &bench.geometry;
    let mut plot = Plot::map("Circle at full lock", "x, m", "y, m");
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
                let v = s.attitude * s.velocity;
                centre += s.position + Vector3::new(-v.y, v.x, 0.0) / s.rates.z;
                path += speed(s) / s.rates.z.abs();
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
        o.figure(format!("{side}: curb-to-curb radius"), curb, "m");
        o.figure(format!("{side}: wall-to-wall radius"), wall, "m");
        let series = d.finish();
        plot.ours(side, series.pairs("x", "y"));
        o.series.push(series);
    }
    o.plots.push(plot);
    Ok(o)
}
