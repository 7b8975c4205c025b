//! Why a vehicle doesn't get on.

use super::{Body, Cause, GRAVITY, Moment, TOUCH, meet};

/// The mean throttle below which the driver doesn't try.
const IDLE: f64 = 0.05;
/// The part of the weight from which the hull carries the vehicle.
const CARRIED: f64 = 0.25;
/// The part of its share of the weight below which a wheel hangs.
const HANGING: f64 = 0.1;
/// The sinkage over the radius from which a wheel is sunk.
const SUNK: f64 = 0.15;
/// The slip ratio from which a wheel spins.
const SPINNING: f64 = 0.5;
/// The slope ahead from which it is steep, rad (15°).
const STEEP: f64 = 0.26;

pub(super) fn cause(moments: &[Moment], body: &Body, obstacles: &[Vec<[f64; 2]>]) -> Cause {
    // The latter half: what it was up against, not how it came there.
    let moments = &moments[moments.len() / 2..];
    let mean = |f: &dyn Fn(&Moment) -> f64| moments.iter().map(f).sum::<f64>() / moments.len() as f64;
    if moments.is_empty() {
        return Cause::Other;
    }
    if mean(&|m| m.throttle) < IDLE {
        return Cause::NotDriven;
    }
    let weight = body.mass * GRAVITY;
    // What the wheels don't carry of the weight's part across the vehicle's plane.
    let carried = mean(&|m| {
        let loads: f64 = m.wheels.iter().map(|w| w.load).sum();
        1.0 - loads / (weight * vb_math::cos(m.tilt()).max(0.1))
    });
    if carried > CARRIED {
        return Cause::HighCentred;
    }
    let touch = TOUCH * body.scale;
    let blocked = mean(&|m| {
        let ahead = if m.reverse { [0.0, touch, 0.0] } else { [touch, 0.0, 0.0] };
        let outline = m.outline(body, ahead);
        f64::from(u8::from(obstacles.iter().any(|o| meet(&outline, o))))
    });
    if blocked > 0.5 {
        return Cause::AgainstObstacle;
    }
    let wheels = moments.iter().map(|m| m.wheels.len()).min().unwrap_or(0);
    let hangs = |w: usize| mean(&|m| m.wheels[w].load) < HANGING * weight / wheels as f64;
    let slip = |m: &Moment, w: usize| {
        let rim = m.wheels[w].spin * body.wheel_radius;
        // By the larger of the two speeds, so that it lies within ±1; a wheel at rest has none.
        let fastest = rim.abs().max(m.velocity[0].abs()).max(0.1 * body.scale.sqrt());
        (rim - m.velocity[0]).abs() / fastest
    };
    let spins = |w: usize| mean(&|m| slip(m, w)) > SPINNING;
    let hanging: Vec<usize> = (0..wheels).filter(|w| hangs(*w)).collect();
    if hanging.len() >= 2 && hanging.iter().any(|w| spins(*w)) {
        return Cause::WheelsOffGround;
    }
    let sunk = (0..wheels).filter(|w| mean(&|m| m.wheels[*w].sinkage) > SUNK * body.wheel_radius).count();
    let slipping = (0..wheels).filter(|w| spins(*w)).count();
    let on_soil = (0..wheels).filter(|w| mean(&|m| m.wheels[*w].sinkage) > 0.0).count();
    if 2 * sunk >= wheels.max(1) || (2 * on_soil >= wheels.max(1) && 2 * slipping >= wheels.max(1)) {
        return Cause::SpinningOnSoil;
    }
    // Pitch is positive with the nose down.
    let climb = mean(&|m| if m.reverse { m.pitch } else { -m.pitch });
    if climb > STEEP {
        return Cause::TooSteep;
    }
    if !hanging.is_empty() && hanging.iter().any(|w| spins(*w)) {
        return Cause::WheelsOffGround;
    }
    Cause::Other
}

#[cfg(test)]
mod tests {
    use super::super::{WheelMoment, cause};
    use super::*;

    const BODY: Body = Body { mass: 2500.0, length: 4.8, width: 2.2, wheel_radius: 0.47, scale: 1.0 };
    const SHARE: f64 = 2500.0 * GRAVITY / 4.0;

    /// Ten seconds at rest with wheels of these loads (in shares of the weight), spins and sinkages.
    fn stands(wheels: [(f64, f64, f64); 4], pitch: f64, throttle: f64) -> Vec<Moment> {
        let wheels =
            wheels.map(|(load, spin, sinkage)| WheelMoment { load: load * SHARE, spin, sinkage }).to_vec();
        let at = |k| Moment {
            time: f64::from(k) * 0.1,
            pitch,
            throttle,
            wheels: wheels.clone(),
            ..Moment::default()
        };
        (0..100).map(at).collect()
    }

    fn of(moments: &[Moment], obstacles: &[Vec<[f64; 2]>]) -> Cause {
        cause(moments, &BODY, obstacles, false)
    }

    const FIRM: (f64, f64, f64) = (1.0, 0.0, 0.0);

    #[test]
    fn each_cause_is_known_by_what_it_is() {
        assert_eq!(of(&stands([FIRM; 4], 0.0, 0.0), &[]), Cause::NotDriven);
        assert_eq!(of(&stands([(0.6, 10.0, 0.0); 4], 0.0, 1.0), &[]), Cause::HighCentred);
        // The left front and the right rear wheel hang and spin.
        let diagonal = [(0.0, 20.0, 0.0), (2.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.0, 20.0, 0.0)];
        assert_eq!(of(&stands(diagonal, 0.0, 1.0), &[]), Cause::WheelsOffGround);
        assert_eq!(of(&stands([(1.0, 0.0, 0.2); 4], 0.0, 1.0), &[]), Cause::SpinningOnSoil);
        assert_eq!(of(&stands([(1.0, 10.0, 0.03); 4], 0.0, 1.0), &[]), Cause::SpinningOnSoil);
        // Nose up by 20°: the wheels carry the cosine of it.
        let climbs = stands([(0.94, 5.0, 0.0); 4], -0.35, 1.0);
        assert_eq!(of(&climbs, &[]), Cause::TooSteep);
        assert_eq!(of(&stands([FIRM; 4], 0.0, 1.0), &[]), Cause::Other);
        assert_eq!(of(&[], &[]), Cause::Other);
    }

    #[test]
    fn an_obstacle_blocks_ahead_in_the_direction_of_the_gear() {
        let at = |x: f64| vec![vec![[x, -0.5], [x + 1.0, -0.5], [x + 1.0, 0.5], [x, 0.5]]];
        let forward = stands([FIRM; 4], 0.0, 1.0);
        let mut backward = forward.clone();
        backward.iter_mut().for_each(|m| m.reverse = true);
        // The front is at 2.4 m, the rear at -2.4 m.
        assert_eq!(of(&forward, &at(2.6)), Cause::AgainstObstacle);
        assert_eq!(of(&forward, &at(2.8)), Cause::Other);
        assert_eq!(of(&backward, &at(2.6)), Cause::Other);
        assert_eq!(of(&backward, &at(-3.6)), Cause::AgainstObstacle);
    }

    #[test]
    fn how_it_came_there_does_not_count() {
        let mut moments = stands([FIRM; 4], 0.0, 1.0);
        moments[..40].iter_mut().for_each(|m| m.wheels.iter_mut().for_each(|w| w.load = 0.0));
        assert_eq!(of(&moments, &[]), Cause::Other);
    }
}
