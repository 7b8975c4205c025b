//! Why a vehicle tipped over.

use std::f64::consts::FRAC_PI_6;

use super::{Body, Cause, Diagnosis, GRAVITY, Moment, Site, TOUCH, meet};

/// The time before the vehicle leans by 30° whose moments tell why, s at scale 1.
const BEFORE: f64 = 1.0;
/// The lateral acceleration over that of gravity from which a turn is what tips the vehicle. A vehicle on a side slope
/// needs a tangent of about its half track over its height, which is near 1, so a third of it is a large part.
const LATERAL: f64 = 0.35;
/// The speed from which a leap or a blow tips the vehicle, m/s at scale 1.
const FAST: f64 = 4.0;
/// The distance beyond the wheels on the lower side within which the ground may fall away, m at scale 1.
const BEYOND: f64 = 1.0;
/// How much farther the ground falls there than it does under the vehicle where there is an edge, m at scale 1.
const DROP: f64 = 0.6;

pub(super) fn diagnose(moments: &[Moment], body: &Body, site: Site<'_>) -> Diagnosis {
    // It may have leant before and come back, so the onset is that of the last time.
    let upright = moments.iter().rposition(|m| m.tilt() <= FRAC_PI_6);
    let onset = upright.map_or(0, |k| (k + 1).min(moments.len().saturating_sub(1)));
    let Some(tipping) = moments.get(onset) else { return Diagnosis::new(Cause::Other, "") };
    let pace = body.scale.sqrt();
    let before = moments[..=onset].iter().filter(|m| m.time >= tipping.time - BEFORE * pace - 1e-9);
    let touch = TOUCH * body.scale;
    let touches = |m: &Moment| {
        let outline = m.outline(body, [touch; 3]);
        site.obstacles.iter().any(|o| meet(&outline, o))
    };
    let when = tipping.time;
    if before.clone().any(touches) {
        return Diagnosis::new(
            Cause::RolloverAtObstacle,
            format!("an obstacle was at its side at {when:.1} s"),
        );
    }
    let lean = Lean::of(tipping);
    let drop = before.clone().map(|m| lean.drop(m, body, site)).fold(0.0, f64::max);
    if drop > DROP * body.scale {
        let evidence = format!("the ground fell by {drop:.1} m more beyond the lower wheels at {when:.1} s");
        return Diagnosis::new(Cause::RolloverOverEdge, evidence);
    }
    let speed = before.clone().map(|m| m.velocity[0].abs()).fold(0.0, f64::max);
    let lateral = before.map(|m| (m.velocity[0] * m.yaw_rate).abs()).fold(0.0, f64::max) / GRAVITY;
    if lateral > LATERAL || speed > FAST * pace {
        let evidence = format!("{speed:.1} m/s and {lateral:.2} g sideways at {when:.1} s");
        return Diagnosis::new(Cause::RolloverAtSpeed, evidence);
    }
    let evidence = format!("at {speed:.1} m/s at {when:.1} s");
    let cause = if lean.along { Cause::RolloverEndOverEnd } else { Cause::RolloverOnSideSlope };
    Diagnosis::new(cause, evidence)
}

/// The direction in which a vehicle leans.
struct Lean {
    /// Whether it is that of the vehicle's length.
    along: bool,
    /// Towards the front or the left: 1; towards the rear or the right: -1.
    sign: f64,
}

impl Lean {
    fn of(m: &Moment) -> Self {
        // Positive pitch lowers the nose, positive roll the right side.
        if m.pitch.abs() > m.roll.abs() {
            Self { along: true, sign: m.pitch.signum() }
        } else {
            Self { along: false, sign: -m.roll.signum() }
        }
    }

    /// How much farther the ground falls beyond the wheels on the lower side than it does over the same distance under the
    /// vehicle, m; 0 where it doesn't.
    fn drop(&self, m: &Moment, body: &Body, site: Site<'_>) -> f64 {
        let across = |p: &[f64; 3]| self.sign * if self.along { p[0] } else { p[1] };
        let lowest = body.wheels.iter().map(across).fold(f64::NEG_INFINITY, f64::max);
        let highest = body.wheels.iter().map(across).fold(f64::INFINITY, f64::min);
        let reach = BEYOND * body.scale;
        // Level with the ground: a vehicle that leans by 90° stands above a line.
        let level = Moment { roll: 0.0, pitch: 0.0, ..m.clone() };
        let height = |p: [f64; 3], out: f64| {
            let out = self.sign * out;
            let [x, y, _] =
                level.place(if self.along { [p[0] + out, p[1], 0.0] } else { [p[0], p[1] + out, 0.0] });
            site.ground.height(x, y)
        };
        let on_lower_side = |p: &&[f64; 3]| across(p) > lowest - body.wheel_radius;
        let width = (lowest - highest).max(body.wheel_radius);
        let fall = |p: &[f64; 3]| {
            let here = height(*p, 0.0);
            let under = (height(*p, -width) - here) / width * reach;
            here - height(*p, reach) - under
        };
        body.wheels.iter().filter(on_lower_side).map(fall).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::super::stuck::tests::{BODY, body};
    use super::*;
    use vb_world::Heightfield;

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

    fn on(ground: &Heightfield, moments: &[Moment], obstacles: &[Vec<[f64; 2]>]) -> Cause {
        super::super::diagnose(moments, &body(), Site { obstacles, ground }, true).cause
    }

    fn of(moments: &[Moment], obstacles: &[Vec<[f64; 2]>]) -> Cause {
        on(&Heightfield::flat(21, 21, 1.0, 0.0), moments, obstacles)
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
        assert_eq!(BODY.half_width, 1.1);
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

    /// Ground whose height follows from the distance to the left of a vehicle that looks east, m.
    fn across(height: fn(f64) -> f64) -> Heightfield {
        let heights = (0..41 * 41).map(|k| height(f64::from(k / 41 - 20) * 0.5)).collect();
        Heightfield::new(41, 41, 0.5, heights)
    }

    #[test]
    fn an_edge_is_ground_that_falls_away_beyond_the_lower_wheels_and_a_slope_is_none() {
        let right = tips(1.5, 0.1, false);
        // The wheels on the right stand at -0.9 m.
        let edge = across(|y| if y < -1.2 { -2.0 } else { 0.0 });
        assert_eq!(on(&edge, &right, &[]), Cause::RolloverOverEdge);
        // Of the same edge on the other side, or two metres farther off, nothing comes.
        assert_eq!(
            on(&across(|y| if y > 1.2 { -2.0 } else { 0.0 }), &right, &[]),
            Cause::RolloverOnSideSlope
        );
        assert_eq!(
            on(&across(|y| if y < -3.2 { -2.0 } else { 0.0 }), &right, &[]),
            Cause::RolloverOnSideSlope
        );
        // An even slope of 45° falls by a metre in a metre, here as there.
        assert_eq!(on(&across(|y| y), &right, &[]), Cause::RolloverOnSideSlope);
        // Over its front, ahead of wheels at 1.4 m.
        let mut turned = tips(1.5, 0.0, true);
        turned.iter_mut().for_each(|m| {
            m.yaw = -std::f64::consts::FRAC_PI_2;
            m.position = [0.0, 0.5, 0.0];
        });
        assert_eq!(on(&edge, &turned, &[]), Cause::RolloverOverEdge);
    }
}
