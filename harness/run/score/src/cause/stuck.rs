//! Why a vehicle doesn't get on.

use super::{Body, Cause, Diagnosis, GRAVITY, Moment, Site, TOUCH, meet};

/// The mean throttle below which the driver doesn't try.
const IDLE: f64 = 0.05;
/// The part of the weight from which the hull carries the vehicle.
const CARRIED: f64 = 0.25;
/// The part of its share of the weight below which a wheel hangs.
const HANGING: f64 = 0.1;
/// The part of the weight below which the two wheels of a diagonal are unloaded: a quarter of their share.
const UNLOADED: f64 = 0.125;
/// The sinkage over the radius from which a wheel is sunk.
const SUNK: f64 = 0.15;
/// The slip from which a wheel spins.
const SPINNING: f64 = 0.5;
/// The rise of the ground above the plane on which the vehicle stands, over the radius of a leading wheel, that is a wall to it.
/// A rigid wheel that is not driven needs a push of tan(arccos(1 − 0.7)) = 3.2 times its load there.
const WALL: f64 = 0.7;
/// The distance ahead of the centre of a leading wheel within which that counts, over its radius. Where the hull reaches farther it
/// counts if it is as steep.
const AHEAD: f64 = 1.2;
/// The tilt from which a vehicle may slide, rad (10°).
const SLOPE: f64 = 0.17;
/// The way downhill by which it slides, m at scale 1.
const SLID: f64 = 0.15;
/// The slope ahead from which it is steep, rad (15°).
const STEEP: f64 = 0.26;

pub(super) fn diagnose(moments: &[Moment], body: &Body, site: Site<'_>) -> Diagnosis {
    // The latter half: what it was up against, not how it came there.
    let moments = &moments[moments.len() / 2..];
    if moments.is_empty() {
        return Diagnosis::new(Cause::Other, "");
    }
    let stand = Stand { moments, body, site };
    let known = stand
        .not_driven()
        .or_else(|| stand.high_centred())
        .or_else(|| stand.against_obstacle())
        .or_else(|| stand.cross_axled())
        .or_else(|| stand.wheels_off_ground())
        .or_else(|| stand.against_wall())
        .or_else(|| stand.spinning_on_soil())
        .or_else(|| stand.too_steep())
        .or_else(|| stand.sliding())
        .or_else(|| stand.spinning_on_firm());
    known.unwrap_or_else(|| {
        let tilt = stand.mean(Moment::tilt).to_degrees();
        Diagnosis::new(Cause::Other, format!("no wheel spins, the vehicle is tilted by {tilt:.0}°"))
    })
}

/// A vehicle that doesn't get on.
struct Stand<'a> {
    moments: &'a [Moment],
    body: &'a Body,
    site: Site<'a>,
}

impl Stand<'_> {
    fn mean(&self, f: impl Fn(&Moment) -> f64) -> f64 {
        self.moments.iter().map(f).sum::<f64>() / self.moments.len() as f64
    }

    /// The number of wheels that all moments have.
    fn wheels(&self) -> usize {
        self.moments.iter().map(|m| m.wheels.len()).min().unwrap_or(0)
    }

    fn hangs(&self, wheel: usize) -> bool {
        let weight = self.body.mass * GRAVITY;
        self.mean(|m| m.wheels[wheel].load) < HANGING * weight / self.wheels() as f64
    }

    fn slip(&self, wheel: usize) -> f64 {
        self.mean(|m| m.slip(wheel, self.body))
    }

    fn spins(&self, wheel: usize) -> bool {
        self.slip(wheel) > SPINNING
    }

    fn not_driven(&self) -> Option<Diagnosis> {
        let throttle = self.mean(|m| m.throttle);
        (throttle < IDLE).then(|| {
            Diagnosis::new(Cause::NotDriven, format!("the mean throttle is {:.0} %", 100.0 * throttle))
        })
    }

    fn high_centred(&self) -> Option<Diagnosis> {
        let carried = self.mean(|m| m.on_hull(self.body));
        (carried > CARRIED).then(|| {
            Diagnosis::new(
                Cause::HighCentred,
                format!("the hull bears {:.0} % of the weight", 100.0 * carried),
            )
        })
    }

    fn against_obstacle(&self) -> Option<Diagnosis> {
        let touch = TOUCH * self.body.scale;
        let blocked = self.mean(|m| {
            let ahead = if m.reverse { [0.0, touch, 0.0] } else { [touch, 0.0, 0.0] };
            let outline = m.outline(self.body, ahead);
            f64::from(u8::from(self.site.obstacles.iter().any(|o| meet(&outline, o))))
        });
        (blocked > 0.5).then(|| {
            let way = if self.backwards() { "behind" } else { "ahead of" };
            Diagnosis::new(Cause::AgainstObstacle, format!("an obstacle is within {touch:.2} m {way} it"))
        })
    }

    /// Whether it tried to drive backwards for most of the time.
    fn backwards(&self) -> bool {
        self.mean(Moment::direction) < 0.0
    }

    /// The two wheels of a diagonal that bear next to nothing together, of which one spins, while the others bear.
    fn cross_axled(&self) -> Option<Diagnosis> {
        let wheels = self.wheels();
        let load = |w: usize| self.mean(|m| m.wheels[w].load) / (self.body.mass * GRAVITY);
        let hangs = |pair: &[usize; 2]| {
            pair.iter().map(|w| load(*w)).sum::<f64>() < UNLOADED && pair.iter().any(|w| self.spins(*w))
        };
        let pair = [[0, 3], [1, 2]].into_iter().find(|pair| wheels == 4 && hangs(pair))?;
        let [a, b] = pair.map(|w| name(w, wheels));
        let borne = 100.0 * (load(pair[0]) + load(pair[1]));
        let evidence = format!("the {a} and the {b} wheel bear {borne:.0} % of the weight, and spin");
        Some(Diagnosis::new(Cause::CrossAxled, evidence))
    }

    fn hanging(&self) -> Vec<usize> {
        (0..self.wheels()).filter(|w| self.hangs(*w)).collect()
    }

    fn wheels_off_ground(&self) -> Option<Diagnosis> {
        let hanging = self.hanging();
        (hanging.len() >= 2 && hanging.iter().any(|w| self.spins(*w))).then(|| {
            let evidence = format!("{} of {} wheels hang, and spin", hanging.len(), self.wheels());
            Diagnosis::new(Cause::WheelsOffGround, evidence)
        })
    }

    /// The greatest rise of the ground before a leading wheel above the plane on which the vehicle stands, m.
    fn rise(&self, m: &Moment) -> f64 {
        let (ahead, radius) = (m.direction(), self.body.wheel_radius);
        let foremost = self.body.wheels.iter().map(|w| ahead * w[0]).fold(f64::NEG_INFINITY, f64::max);
        let leading = self.body.wheels.iter().filter(|w| ahead * w[0] > foremost - radius);
        // A hull that reaches far beyond its wheels is stopped before they are.
        let overhang = if ahead > 0.0 { self.body.front } else { self.body.rear } - foremost;
        let reach = (AHEAD * radius).max(overhang + 0.5 * TOUCH * self.body.scale);
        let rise = |[x, y, z]: &[f64; 3]| {
            let above = |d: f64| {
                let [px, py, pz] = m.place([x + ahead * d, *y, z - radius]);
                self.site.ground.height(px, py) - pz
            };
            // The wheel may have sunk below its place at design, or stand in a rut.
            let foot = above(0.0).max(0.0);
            let rises = (1..=8).map(|k| reach * f64::from(k) / 8.0).map(|d| (d, above(d) - foot));
            rises.filter(|(d, rise)| *rise >= WALL / AHEAD * d).map(|(_, rise)| rise).fold(0.0, f64::max)
        };
        leading.map(rise).fold(0.0, f64::max)
    }

    fn against_wall(&self) -> Option<Diagnosis> {
        let rise = self.mean(|m| self.rise(m));
        (rise > WALL * self.body.wheel_radius).then(|| {
            let evidence = format!("the ground rises by {rise:.2} m before a leading wheel");
            Diagnosis::new(Cause::AgainstWall, evidence)
        })
    }

    fn spinning_on_soil(&self) -> Option<Diagnosis> {
        let wheels = self.wheels();
        let sinkage = |w: usize| self.mean(|m| m.wheels[w].sinkage);
        let sunk = (0..wheels).filter(|w| sinkage(*w) > SUNK * self.body.wheel_radius).count();
        let slipping = (0..wheels).filter(|w| self.spins(*w)).count();
        let on_soil = (0..wheels).filter(|w| sinkage(*w) > 0.0).count();
        let half = |n: usize| 2 * n >= wheels.max(1);
        (half(sunk) || (half(on_soil) && half(slipping))).then(|| {
            let deepest = (0..wheels).map(sinkage).fold(0.0, f64::max);
            let slip = (0..wheels).map(|w| self.slip(w)).fold(0.0, f64::max);
            let evidence = format!("sinkage of up to {deepest:.2} m, slip of up to {slip:.1}");
            Diagnosis::new(Cause::SpinningOnSoil, evidence)
        })
    }

    fn sliding(&self) -> Option<Diagnosis> {
        let (first, last) = (self.moments.first()?, self.moments.last()?);
        let down = first.position[2] - last.position[2];
        let tilt = self.mean(Moment::tilt);
        let moved = (0..2).map(|k| last.position[k] - first.position[k]).map(|d| d * d).sum::<f64>().sqrt();
        // On an even slope the way down is as long as the height over its sine.
        (tilt > SLOPE && moved > SLID * self.body.scale && down > 0.5 * moved * vb_math::sin(tilt)).then(
            || {
                let evidence = format!("it slid {moved:.2} m down a slope of {:.0}°", tilt.to_degrees());
                Diagnosis::new(Cause::Sliding, evidence)
            },
        )
    }

    fn too_steep(&self) -> Option<Diagnosis> {
        // Pitch is positive with the nose down.
        let climb = self.mean(|m| -m.direction() * m.pitch);
        (climb > STEEP).then(|| {
            let slip = (0..self.wheels()).map(|w| self.slip(w)).fold(0.0, f64::max);
            let evidence = format!("{:.0}° upwards, slip of up to {slip:.1}", climb.to_degrees());
            Diagnosis::new(Cause::TooSteep, evidence)
        })
    }

    fn spinning_on_firm(&self) -> Option<Diagnosis> {
        let wheels = self.wheels();
        let spinning: Vec<usize> = (0..wheels).filter(|w| self.spins(*w)).collect();
        let share = self.body.mass * GRAVITY / wheels as f64;
        let least =
            spinning.iter().map(|w| self.mean(|m| m.wheels[*w].load) / share).fold(f64::INFINITY, f64::min);
        (!spinning.is_empty()).then(|| {
            let evidence = format!(
                "{} of {wheels} wheels spin, of which one bears {:.0} % of its share of the weight",
                spinning.len(),
                100.0 * least
            );
            Diagnosis::new(Cause::SpinningOnFirm, evidence)
        })
    }
}

/// What a wheel is called.
fn name(wheel: usize, wheels: usize) -> String {
    let end = match wheel / 2 {
        0 => "front",
        axle if 2 * (axle + 1) == wheels => "rear",
        _ => "middle",
    };
    format!("{} {end}", if wheel.is_multiple_of(2) { "left" } else { "right" })
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::WheelMoment;
    use super::*;
    use vb_world::Heightfield;

    pub(in super::super) struct Size {
        pub(in super::super) half_width: f64,
    }

    pub(in super::super) const BODY: Size = Size { half_width: 1.1 };

    /// A vehicle of about the HMMWV's size.
    pub(in super::super) fn body() -> Body {
        let wheels = [[1.4, 0.9], [1.4, -0.9], [-1.4, 0.9], [-1.4, -0.9]].map(|[x, y]| [x, y, 0.0]).to_vec();
        let half_width = BODY.half_width;
        Body { mass: 2500.0, front: 2.4, rear: 2.4, half_width, wheels, wheel_radius: 0.47, scale: 1.0 }
    }

    const SHARE: f64 = 2500.0 * GRAVITY / 4.0;

    /// Ten seconds at rest with wheels of these loads (in shares of the weight), spins and sinkages, which stand on level
    /// ground.
    fn stands(wheels: [(f64, f64, f64); 4], pitch: f64, throttle: f64) -> Vec<Moment> {
        let wheels =
            wheels.map(|(load, spin, sinkage)| WheelMoment { load: load * SHARE, spin, sinkage }).to_vec();
        let at = |k| Moment {
            time: f64::from(k) * 0.1,
            position: [0.0, 0.0, 0.47],
            pitch,
            throttle,
            wheels: wheels.clone(),
            ..Moment::default()
        };
        (0..100).map(at).collect()
    }

    fn on(ground: &Heightfield, moments: &[Moment], obstacles: &[Vec<[f64; 2]>]) -> Diagnosis {
        super::super::diagnose(moments, &body(), Site { obstacles, ground }, false)
    }

    fn of(moments: &[Moment], obstacles: &[Vec<[f64; 2]>]) -> Cause {
        on(&Heightfield::flat(21, 21, 1.0, 0.0), moments, obstacles).cause
    }

    const FIRM: (f64, f64, f64) = (1.0, 0.0, 0.0);

    #[test]
    fn each_cause_is_known_by_what_it_is() {
        assert_eq!(of(&stands([FIRM; 4], 0.0, 0.0), &[]), Cause::NotDriven);
        assert_eq!(of(&stands([(0.6, 10.0, 0.0); 4], 0.0, 1.0), &[]), Cause::HighCentred);
        let (hangs, bears) = ((0.0, 20.0, 0.0), (2.0, 0.0, 0.0));
        assert_eq!(of(&stands([hangs, bears, bears, hangs], 0.0, 1.0), &[]), Cause::CrossAxled);
        assert_eq!(of(&stands([hangs, bears, hangs, bears], 0.0, 1.0), &[]), Cause::WheelsOffGround);
        assert_eq!(of(&stands([(1.0, 0.0, 0.2); 4], 0.0, 1.0), &[]), Cause::SpinningOnSoil);
        assert_eq!(of(&stands([(1.0, 10.0, 0.03); 4], 0.0, 1.0), &[]), Cause::SpinningOnSoil);
        // Nose up by 20°: the wheels carry the cosine of it.
        let climbs = stands([(0.94, 5.0, 0.0); 4], -0.35, 1.0);
        assert_eq!(of(&climbs, &[]), Cause::TooSteep);
        let light = (0.3, 20.0, 0.0);
        assert_eq!(of(&stands([light, bears, bears, light], 0.0, 1.0), &[]), Cause::SpinningOnFirm);
        assert_eq!(of(&stands([FIRM; 4], 0.0, 1.0), &[]), Cause::Other);
        assert_eq!(of(&[], &[]), Cause::Other);
    }

    #[test]
    fn the_evidence_has_the_figures() {
        let level = Heightfield::flat(21, 21, 1.0, 0.0);
        let told = |moments: &[Moment]| on(&level, moments, &[]).evidence;
        assert_eq!(told(&stands([(0.6, 10.0, 0.0); 4], 0.0, 1.0)), "the hull bears 40 % of the weight");
        let (hangs, bears) = ((0.0, 20.0, 0.0), (2.0, 0.0, 0.0));
        assert_eq!(
            told(&stands([bears, hangs, hangs, bears], 0.0, 1.0)),
            "the right front and the left rear wheel bear 0 % of the weight, and spin"
        );
        assert_eq!(
            told(&stands([(1.0, 10.0, 0.03); 4], 0.0, 1.0)),
            "sinkage of up to 0.03 m, slip of up to 1.0"
        );
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
    fn a_wall_stands_before_a_leading_wheel_in_the_direction_of_the_gear() {
        // Ground that rises by so much between 1.5 and 1.75 m ahead.
        let step = |rise: f64| {
            let heights = (0..81 * 81).map(|k| if k % 81 > 46 { rise } else { 0.0 }).collect();
            Heightfield::new(81, 81, 0.25, heights)
        };
        let forward = stands([FIRM; 4], 0.0, 1.0);
        let mut backward = forward.clone();
        backward.iter_mut().for_each(|m| m.reverse = true);
        // Of a radius of 0.47 m, 0.33 m are a wall.
        assert_eq!(on(&step(0.4), &forward, &[]).cause, Cause::AgainstWall);
        assert_eq!(on(&step(0.25), &forward, &[]).cause, Cause::Other);
        assert_eq!(on(&step(0.4), &backward, &[]).cause, Cause::Other);
    }

    #[test]
    fn it_slides_where_it_moves_downhill_on_a_slope() {
        // Rolled by 20°, and half a metre to the lower side in the last five seconds.
        let mut moments = stands([(0.94, 0.0, 0.0); 4], 0.0, 1.0);
        for (k, m) in moments.iter_mut().enumerate() {
            let way = 0.01 * k as f64;
            m.roll = 0.35;
            m.position = [0.0, -way * 0.94, 0.47 - way * 0.34];
        }
        assert_eq!(of(&moments, &[]), Cause::Sliding);
        // The same way on the level is not down.
        moments.iter_mut().for_each(|m| m.position[2] = 0.47);
        assert_eq!(of(&moments, &[]), Cause::Other);
    }

    #[test]
    fn how_it_came_there_does_not_count() {
        let mut moments = stands([FIRM; 4], 0.0, 1.0);
        moments[..40].iter_mut().for_each(|m| m.wheels.iter_mut().for_each(|w| w.load = 0.0));
        assert_eq!(of(&moments, &[]), Cause::Other);
    }
}
