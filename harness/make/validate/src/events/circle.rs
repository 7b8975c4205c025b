//! A circle of constant radius at growing speed.

use crate::bench::Bench;
use crate::check::Expected;
use crate::event::{Event, Outcome, Place, Plot, Vehicles};
use crate::grounds::flat;
use crate::rig::Drive;
use vb_math::angle::degrees;
use vb_math::{atan, exp};
use vb_sim::SimError;
use vb_vehicle::GRAVITY;

pub(super) const STEADY_CIRCLE: Event = Event {
    name: "steady-circle",
    title: "Steady circle of 30 m",
    about: "A left circle of 30 m radius at μ 0.9, from 2 m/s faster by 0.2 m/s² up to a lateral acceleration of 6 m/s² or to the \
            vehicle's top speed (ISO 4138, constant radius): the angle of the front wheels over the lateral acceleration, and its slope, the \
            understeer gradient.",
    vehicles: Vehicles::Steered,
    place: Place::Rigid,
    run: steady_circle,
};

/// Radius, m at full size.
const RADIUS: f64 = 30.0;
/// Speed from which it is driven, m/s, and its growth, m/s².
const FROM: f64 = 2.0;
const GROWTH: f64 = 0.2;
/// Lateral acceleration at which it ends, m/s².
const MOST: f64 = 6.0;
/// Time to come onto the circle, s.
const RUN_IN: f64 = 10.0;
/// Time for which the last speed is held, s: the speed follows its target with some delay.
const HOLD: f64 = 10.0;
/// Rate of the driver who turns the wheel while the path is too wide, 1/s. Ours: slow beside the vehicle's answer, fast beside the growth
/// of the speed.
const DRIVER: f64 = 0.3;
/// Time over which accelerations are smoothed, s.
const SMOOTHED: f64 = 0.5;
/// Lateral accelerations between which the understeer gradient is taken, m/s²: above parking speed, and below the tyres' limit.
const LINEAR: [f64; 2] = [0.5, 4.0];

fn steady_circle(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let (g, pace) = (&bench.geometry, bench.pace);
    let radius = pace.length(RADIUS);
    let step = bench.options.step;
    let mut d = Drive::new(bench, "left", &flat(0.9), 0.0, 0.0)?;
    let fastest = pace.within_reach((1.2 * MOST * RADIUS).sqrt());
    let seconds = RUN_IN + (fastest - FROM) / GROWTH + HOLD;
    let mut command = 0.0_f64;
    let smoothing = 1.0 - exp(-step / pace.time(SMOOTHED));
    let (mut lateral, mut angle, mut most) = (0.0, 0.0, 0.0_f64);
    let mut points: Vec<[f64; 2]> = Vec::new();
    d.run(
        pace.time(seconds),
        |s| {
            let curvature = s.angular_velocity_body.z / s.velocity_body.x.max(pace.speed(0.5));
            command += DRIVER * (1.0 - curvature * radius) * step / pace.time(1.0);
            command = command.clamp(-1.0, 1.0);
            let target = FROM + GROWTH * (s.time / pace.time(1.0) - RUN_IN).max(0.0);
            pace.hold_speed(s, target.min(fastest), command)
        },
        |s| {
            let front = [0, 1].map(|i| degrees(g.wheel_angle(i, s.wheels[i].deflection, s.steering)));
            lateral += smoothing * (s.angular_velocity_body.z * s.velocity_body.x - lateral);
            angle += smoothing * (0.5 * (front[0] + front[1]) - angle);
            if s.time > pace.time(RUN_IN) {
                points.push([lateral, angle]);
                most = most.max(lateral);
            }
            s.time > pace.time(RUN_IN) && (lateral >= MOST || s.roll_pitch_yaw().0.abs() > 0.6)
        },
    )?;
    o.figure("greatest lateral acceleration", most, "m/s²");
    let linear: Vec<[f64; 2]> =
        points.iter().filter(|p| p[0] >= LINEAR[0] && p[0] <= LINEAR[1]).copied().collect();
    if let Some([slope, at_rest]) = line(&linear) {
        o.figure("understeer gradient", slope * GRAVITY, "°/g");
        let name = "angle of the front wheels at no lateral acceleration";
        o.figure(name, at_rest, "°");
        if bench.spec.axles.len() == 2 && !bench.winds_up() {
            // The reference point is between the axles; the circle of the rear one is the leg of a right-angled triangle.
            let rear = (radius * radius - g.turning_line() * g.turning_line()).sqrt();
            o.theory(
                name,
                Expected::fraction(degrees(atan(g.wheelbase() / rear)), 0.08),
                "Ackermann: atan(L / R) without slip (Gillespie, ch. 6)",
            );
        }
    } else {
        o.note("The vehicle does not reach a lateral acceleration of 0.5 m/s².");
    }
    let mut plot =
        Plot::new("Angle of the front wheels on the circle", "lateral acceleration, m/s²", "angle, °");
    plot.ours("left", points.into_iter().step_by(100).collect());
    o.plots.push(plot);
    o.series.push(d.finish());
    Ok(o)
}

/// Slope and value at zero of the straight line with the least squares; none for less than two abscissas.
fn line(points: &[[f64; 2]]) -> Option<[f64; 2]> {
    let count = points.len() as f64;
    let mean = |k: usize| points.iter().map(|p| p[k]).sum::<f64>() / count;
    let (x, y) = (mean(0), mean(1));
    let spread: f64 = points.iter().map(|p| (p[0] - x) * (p[0] - x)).sum();
    let slope = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum::<f64>() / spread;
    (spread > 0.0).then_some([slope, y - slope * x])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_goes_through_points_of_a_line() {
        let points: Vec<[f64; 2]> = (0..5).map(|k| [f64::from(k), 3.0 - 0.5 * f64::from(k)]).collect();
        let [slope, at_zero] = line(&points).unwrap();
        assert!((slope + 0.5).abs() < 1e-12 && (at_zero - 3.0).abs() < 1e-12);
        assert!(line(&points[..1]).is_none() && line(&[]).is_none());
    }
}
