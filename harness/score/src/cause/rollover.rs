//! Why a vehicle tipped over.

use std::f64::consts::FRAC_PI_6;

use super::{Body, Cause, GRAVITY, Moment, TOUCH, meet};

/// The time before the vehicle leans by 30° whose moments tell why, s at scale 1.
const BEFORE: f64 = 1.0;
/// The lateral acceleration over that of gravity from which a turn is what tips the vehicle. A vehicle on a side slope
/// needs a tangent of about its half track over its height, which is near 1, so a third of it is a large part.
const LATERAL: f64 = 0.35;
/// The speed from which a leap or a blow tips the vehicle, m/s at scale 1.
const FAST: f64 = 4.0;

pub(super) fn cause(moments: &[Moment], body: &Body, obstacles: &[Vec<[f64; 2]>]) -> Cause {
    // It may have leant before and come back, so the onset is that of the last time.
    let upright = moments.iter().rposition(|m| m.tilt() <= FRAC_PI_6);
    let onset = upright.map_or(0, |k| (k + 1).min(moments.len().saturating_sub(1)));
    let Some(tipping) = moments.get(onset) else { return Cause::Other };
    let pace = body.scale.sqrt();
    let before = moments[..=onset].iter().filter(|m| m.time >= tipping.time - BEFORE * pace - 1e-9);
    let touch = TOUCH * body.scale;
    let touches = |m: &Moment| {
        let outline = m.outline(body, [touch; 3]);
        obstacles.iter().any(|o| meet(&outline, o))
    };
    if before.clone().any(touches) {
        return Cause::RolloverAtObstacle;
    }
    let speed = before.clone().map(|m| m.velocity[0].abs()).fold(0.0, f64::max);
    let lateral = before.map(|m| (m.velocity[0] * m.yaw_rate).abs()).fold(0.0, f64::max);
    if lateral > LATERAL * GRAVITY || speed > FAST * pace {
        return Cause::RolloverAtSpeed;
    }
    if tipping.pitch.abs() > tipping.roll.abs() {
        Cause::RolloverEndOverEnd
    } else {
        Cause::RolloverOnSideSlope
    }
}

#[cfg(test)]
mod tests {
    use super::super::cause;
    use super::*;

    const BODY: Body = Body { mass: 2500.0, length: 4.8, width: 2.2, wheel_radius: 0.47, scale: 1.0 };

    /// A vehicle that leans by 60° a second from the second second on, at a speed and a yaw rate.
    fn tips(speed: f64, yaw_rate: f64, end_over_end: bool) -> Vec<Moment> {
        (0..40)
            .map(|k| {
                let time = f64::from(k) * 0.1;
                let lean = (time - 2.0).max(0.0);
                let (roll, pitch) = if end_over_end { (0.0, lean) } else { (lean, 0.0) };
                let velocity = [speed, 0.0, 0.0];
                Moment { time, roll, pitch, velocity, yaw_rate, ..Moment::default() }
            })
            .collect()
    }

    fn of(moments: &[Moment], obstacles: &[Vec<[f64; 2]>]) -> Cause {
        cause(moments, &BODY, obstacles, true)
    }

    #[test]
    fn slow_vehicles_tip_over_on_slopes_and_fast_ones_by_their_speed() {
        assert_eq!(of(&tips(1.5, 0.1, false), &[]), Cause::RolloverOnSideSlope);
        assert_eq!(of(&tips(1.5, 0.1, true), &[]), Cause::RolloverEndOverEnd);
        assert_eq!(of(&tips(6.0, 0.0, false), &[]), Cause::RolloverAtSpeed);
        // 3.5 m/s · 1.2 rad/s = 0.43 g.
        assert_eq!(of(&tips(3.5, 1.2, false), &[]), Cause::RolloverAtSpeed);
    }

    #[test]
    fn an_obstacle_beside_the_vehicle_is_the_cause_and_one_farther_off_is_not() {
        let obstacle = |y: f64| vec![[-1.0, y], [1.0, y], [1.0, y + 1.0], [-1.0, y + 1.0]];
        // The vehicle's side is at 1.1 m.
        assert_eq!(of(&tips(1.5, 0.1, false), &[obstacle(1.3)]), Cause::RolloverAtObstacle);
        assert_eq!(of(&tips(1.5, 0.1, false), &[obstacle(1.6)]), Cause::RolloverOnSideSlope);
    }

    #[test]
    fn what_happened_on_the_way_before_does_not_count() {
        // Fast until three seconds before it tips.
        let mut moments = tips(1.0, 0.0, false);
        moments.iter_mut().filter(|m| m.time < 0.5).for_each(|m| m.velocity[0] = 8.0);
        assert_eq!(of(&moments, &[]), Cause::RolloverOnSideSlope);
    }
}
