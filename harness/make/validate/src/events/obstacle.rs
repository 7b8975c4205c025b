//! A single wheel at steps, in corners, on facets and over a ridge, as a hard cylinder and on the vehicle's tyre.
//!
//! Statics: a driven wheel in front of a step or facet whose contact makes an angle θ with the vertical pushes itself up by
//! friction alone where tan θ ≤ μ; at the edge of a step of height h cos θ = 1 − h/r (Bekker, Theory of Land Locomotion, 1956,
//! part II). Where tan θ > μ it stays in the corner and spins, with friction in full on floor (N₁) and obstacle (N₂):
//! N₂ (sin θ − μ cos θ) = μ N₁ and N₁ + N₂ (cos θ + μ sin θ) = W, at a torque μ r (N₁ + N₂). With a push P at the hub the floor is
//! left where P = W tan(θ − atan μ).
//!
//! Impacts: a wheel that rolls at v onto an edge or facet and neither bounces nor slides there goes on in the one way that the
//! new contact leaves it, along (cos θ, sin θ), with what its momentum has of that way (Newton and Poisson with a restitution of
//! zero; Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts, 1996, ch. 8): with M along x and m along z that
//! move with the hub and k = J/r² it is u/v = (M cos θ + k) / (M cos² θ + m sin² θ + k). For M = m that is the balance
//! of angular momentum about the edge, 1 − (h/r) m/(m + k).

use crate::bench::Bench;
use crate::check::Expected;
use crate::event::{Event, Outcome, Place, Series, Vehicles};
use crate::rig::largest;
use vb_math::angle::{degrees, radians};
use vb_math::{acos, atan, cos, sin, tan};
use vb_sim::{SimError, WheelStand};
use vb_vehicle::{GRAVITY, TyreSpec, tyre::HardContact};
use vb_world::Heightfield;

pub(super) const OBSTACLES: Event = Event {
    name: "wheel-obstacles",
    title: "A wheel at steps, corners and ridges",
    about: "A front wheel on a stand, hard and as fitted, with the wheel's static load. Driven: the highest step and the \
            steepest facet that it climbs from rest, the torque at which it spins in a corner of floor and facet, the push that \
            lifts it up a facet of 80°. Free and hard: rolling down a facet, and the energy loss at steps, at a facet and \
            over a ridge.",
    vehicles: Vehicles::Wheeled,
    place: Place::Rigid,
    run: obstacles,
};

/// Nodes of the ground are this share of the wheel's radius apart: the face of a step as high as that is steeper than
/// the direction in which the wheel meets its edge.
const PITCH: f64 = 0.15;

/// A wheel that is let roll.
#[derive(Clone, Copy)]
struct Run {
    /// What moves with the hub along x and along z, kg.
    mass: [f64; 2],
    /// Over √(g r).
    speed: f64,
    /// Of its centre along x at first, and where it meets what it rolls onto, over the radius.
    from: f64,
    met: f64,
}

/// A wheel to be put on the stand.
#[derive(Clone, Copy)]
struct Wheel<'a> {
    tyre: &'a TyreSpec,
    radius: f64,
    /// Weight on it, N.
    load: f64,
    /// Mass of a wheel's share of the vehicle, and its own, kg.
    fraction: f64,
    own: f64,
    spin_inertia: f64,
    friction: f64,
    step: f64,
}

impl Wheel<'_> {
    /// √(g r), m/s: speeds of the cases are shares of it.
    fn pace(&self) -> f64 {
        (GRAVITY * self.radius).sqrt()
    }

    /// √(r/g), s.
    fn beat(&self) -> f64 {
        (self.radius / GRAVITY).sqrt()
    }

    /// Ground whose height (over the radius) depends on x (over the radius), with nodes at the multiples of [`PITCH`].
    fn ground(&self, height: impl Fn(f64) -> f64) -> Heightfield {
        let (rows, half) = (41, 60_i32);
        let line: Vec<f64> = (-half..=half).map(|c| self.radius * height(f64::from(c) * PITCH)).collect();
        let cols = line.len();
        let heights = (0..rows * cols).map(|i| line[i % cols]).collect();
        Heightfield::new(rows, cols, PITCH * self.radius, heights)
    }

    /// With these masses along x and z and its centre at a place over the radius.
    fn stand(&self, mass: [f64; 2], x: f64, z: f64) -> WheelStand {
        let mut stand = WheelStand::new(self.tyre, mass, self.spin_inertia, self.step);
        stand.hub.x = self.radius * x;
        stand.hub.z = self.radius * z;
        stand
    }

    /// Driven at a rim speed of `fraction` of √(g r) from rest at a place, pushed along x by `push` (N): until it has come to
    /// `goal` (over the radius) along x, or not in 12 √(r/g). Also the mean torque over its weight and radius in the second
    /// half of the time.
    fn drive(&self, ground: &Heightfield, friction: f64, at: [f64; 2], push: f64, goal: f64) -> (bool, f64) {
        let mut stand = self.stand([self.fraction; 2], at[0], at[1]);
        stand.spin = 0.2 * self.pace() / self.radius;
        let steps = (12.0 * self.beat() / self.step) as usize;
        let (mut torque, mut count) = (0.0, 0.0);
        for k in 0..steps {
            stand.advance(ground, friction, [push, -self.load], true);
            if stand.hub.x > goal * self.radius {
                return (true, f64::NAN);
            }
            if 2 * k > steps {
                torque -= stand.moment;
                count += 1.0;
            }
        }
        (false, torque / count / (self.load * self.radius))
    }

    /// Of motion and height, J.
    fn energy(&self, stand: &WheelStand, mass: [f64; 2]) -> f64 {
        0.5 * (mass[0] * stand.velocity.x * stand.velocity.x + mass[1] * stand.velocity.z * stand.velocity.z)
            + 0.5 * self.spin_inertia * stand.spin * stand.spin
            + self.weight(mass) * stand.hub.z
    }

    /// A stand that carries a share of the vehicle has its weight, a wheel alone its own, N.
    fn weight(&self, mass: [f64; 2]) -> f64 {
        GRAVITY * mass[0].max(mass[1])
    }

    /// Rolls freely until `end` says so of its centre over the radius and of the time over √(r/g) since it met what it
    /// rolls onto; the share of its energy of motion that is lost then, not a number if it never does.
    fn roll(
        &self,
        ground: &Heightfield,
        Run { mass, speed, from, met }: Run,
        end: impl Fn(f64, f64) -> bool,
        series: &mut Series,
    ) -> f64 {
        let tyre = vb_sim::tyre::Tyre::new(self.tyre);
        let weight = self.weight(mass);
        let mut stand = self.stand(mass, from, 1.0 - tyre.deflection(weight) / self.radius);
        stand.velocity.x = speed * self.pace();
        stand.spin = stand.velocity.x / self.radius;
        let first = self.energy(&stand, mass);
        let motion = first - weight * stand.hub.z;
        let mut since = 0.0;
        for k in 0..(30.0 * self.beat() / self.step) as usize {
            stand.advance(ground, self.friction, [0.0, -weight], false);
            let x = stand.hub.x / self.radius;
            if x > met {
                since += self.step / self.beat();
            }
            let lost = (first - self.energy(&stand, mass)) / motion;
            series.rows.push(vec![
                k as f64 * self.step,
                stand.hub.x,
                stand.hub.z,
                stand.velocity.x,
                stand.velocity.z,
                stand.spin,
                stand.load,
                lost,
            ]);
            if end(x, since) {
                return lost;
            }
        }
        f64::NAN
    }

    /// u/v of the impact whose contact makes an angle with the vertical, and the share of the energy that is lost.
    fn impact(&self, mass: [f64; 2], angle: f64) -> (f64, f64) {
        let k = self.spin_inertia / (self.radius * self.radius);
        let (s, c) = (sin(angle), cos(angle));
        let after = mass[0] * c * c + mass[1] * s * s + k;
        let kept = (mass[0] * c + k) / after;
        (kept, 1.0 - after * kept * kept / (mass[0] + k))
    }
}

fn obstacles(bench: &Bench<'_>) -> Result<Outcome, SimError> {
    let mut o = Outcome::default();
    let g = &bench.geometry;
    let axle = &bench.spec.axles[0];
    let fitted = bench.spec.tyre_of(axle);
    let hard = bench.spec.clone().with_tyre("rigid").ok();
    // Theory is of a cylinder, which has a contact with each facet that it touches.
    let hard = hard.map(|v| {
        let mut tyre = v.tyre_of(&v.axles[0]).clone();
        if let TyreSpec::Rigid(t) = &mut tyre {
            t.contact = HardContact::Facets;
        }
        tyre
    });
    let hard = hard.as_ref();
    let fraction = g.mass / g.corners.len() as f64;
    let wheel = |tyre| {
        let friction = bench.grip(0.9);
        let (radius, own) = (TyreSpec::radius(tyre), axle.unsprung_mass);
        let (load, spin_inertia, step) = (fraction * GRAVITY, axle.spin_inertia, bench.options.step);
        Wheel { tyre, radius, load, fraction, own, spin_inertia, friction, step }
    };
    if let Some(tyre) = hard {
        driven(&mut o, "hard", &wheel(tyre), 1.0)?;
        free(&mut o, &wheel(tyre));
    } else {
        o.note("The vehicle has no hard tyre, but the theory applies to cylinders.");
    }
    if fitted.coulomb_friction().is_none() {
        o.note(
            "The friction of the fitted tyre depends on slip, so statics with one coefficient does not apply.",
        );
    } else if hard.is_none() || !matches!(fitted, TyreSpec::Rigid(_)) {
        driven(&mut o, "as fitted", &wheel(fitted), 3.0)?;
    }
    Ok(o)
}

/// Driven cases. A tyre that yields is a circle only nearly: tolerances are those of a hard one times `loose`.
fn driven(o: &mut Outcome, kind: &str, w: &Wheel<'_>, loose: f64) -> Result<(), SimError> {
    for mu in [0.8, 0.5] {
        // The floor is left when the centre is a whole radius above it, on a tyre that the edge presses in by its share of the load.
        let level = 1.0 / (1.0_f64 + mu * mu).sqrt();
        let yields = vb_sim::tyre::Tyre::new(w.tyre).deflection(w.load * level) / w.radius;
        let step = |yields: f64| 1.0 - (1.0 - yields) * level;
        let theory = step(yields);
        let found = largest(0.5 * theory, 2.0 * theory, 0.015 * theory, |h| {
            let ground = w.ground(|x| if x > -1e-9 { h } else { 0.0 });
            Ok(w.drive(&ground, mu, [-(2.0 * h - h * h).sqrt(), 1.0], 0.0, 0.2).0)
        })?;
        // A tyre that is filled with air bears on as long a chord of its circle at an edge as on level ground, if all that
        // carries is the pressure of the air: d / (sin θ cos θ) = 2 √(2 r δ − δ²), with θ between the normals of edge and
        // floor, tan θ = μ. A carcass that carries yields less.
        let chord = 2.0 * (yields * (2.0 - yields)).sqrt();
        let expected = if loose > 1.0 {
            Expected::Between(0.95 * theory, 1.05 * step(chord * mu * level * level))
        } else {
            Expected::fraction(theory, 0.05)
        };
        o.expect(
            &format!("{kind}: highest step climbed over the radius, μ {mu:.1}"),
            found,
            "",
            expected,
            "statics: h/r = 1 − (1 − d/r) / √(1 + μ²), d the deflection at the edge, at most that of air alone",
        );
        let theory = degrees(atan(mu));
        let found = largest(theory - 6.0, theory + 6.0, 0.25, |angle| {
            let (ground, x) = w.corner(radians(angle));
            Ok(w.drive(&ground, mu, [x, 1.0], 0.0, x + 0.3).0)
        })?;
        o.expect(
            &format!("{kind}: steepest facet climbed, μ {mu:.1}"),
            found,
            "°",
            Expected::Within { value: theory, tolerance: loose },
            "statics: atan μ",
        );
    }
    let mu = 0.5;
    for angle in [60.0, 80.0] {
        let (ground, x) = w.corner(radians(angle));
        let (s, c) = (sin(radians(angle)), cos(radians(angle)));
        let floor = s - mu * c;
        let theory = mu * (floor + mu) / (floor + mu * (c + mu * s));
        let (_, torque) = w.drive(&ground, mu, [x, 1.0], 0.0, x + 0.3);
        o.expect(
            &format!(
                "{kind}: torque that spins it at a facet of {angle:.0}°, over weight and radius, μ {mu:.1}"
            ),
            torque,
            "",
            Expected::fraction(theory, 0.03 * loose),
            "statics: friction in full at floor and facet",
        );
    }
    let theory = tan(radians(80.0) - atan(mu));
    let (ground, x) = w.corner(radians(80.0));
    let found = largest(0.3 * theory, 1.5 * theory, 0.01 * theory, |push| {
        Ok(!w.drive(&ground, mu, [x, 1.0], push * w.load, x + 0.05).0)
    })?;
    o.expect(
        &format!("{kind}: push that lifts it up a facet of 80°, over weight, μ {mu:.1}"),
        found,
        "",
        Expected::fraction(theory, 0.05 * loose),
        "statics: tan(angle − atan μ)",
    );
    Ok(())
}

impl Wheel<'_> {
    /// A floor and from x = 0 on a facet at an angle (rad), and x over the radius of a wheel that touches both.
    fn corner(&self, angle: f64) -> (Heightfield, f64) {
        (self.ground(|x| x.max(0.0) * tan(angle)), -tan(0.5 * angle))
    }
}

/// A hard wheel that rolls freely.
fn free(o: &mut Outcome, w: &Wheel<'_>) {
    let series = |name: &str| {
        let columns = [("t", "s"), ("x", "m"), ("z", "m"), ("vx", "m/s"), ("vz", "m/s"), ("spin", "rad/s")];
        let columns = columns.into_iter().chain([("load", "N"), ("lost", "")]);
        Series {
            name: name.to_owned(),
            columns: columns.map(|(n, u)| (n.to_owned(), u)).collect(),
            rows: Vec::new(),
        }
    };
    let k = w.spin_inertia / (w.radius * w.radius);
    let alone = [w.own; 2];
    let lost = |o: &mut Outcome, name: &str, lost: f64, theory: f64, source: &str| {
        // A tenth of the loss, and a hundredth of the energy for what the contact's spring and bristle hold.
        let tolerance = 0.1 * theory + 0.01;
        o.expect(
            &format!("hard: energy lost {name}"),
            100.0 * lost,
            "%",
            Expected::Within { value: 100.0 * theory, tolerance: 100.0 * tolerance },
            source,
        );
    };
    let inelastic = "impact without bounce or slip: 1 − (M cos θ + k)² / ((M cos² θ + m sin² θ + k)(M + k))";
    for (label, mass) in [("wheel alone", alone), ("with its share of the vehicle", [w.fraction, w.own])] {
        for h in [0.15, 0.4] {
            let angle = acos(1.0 - h);
            let ground = w.ground(|x| if x > -1e-9 { h } else { 0.0 });
            let met = -sin(angle);
            let mut s = series(&format!("step-{h}-{}", label.replace(' ', "-")));
            let value = w.roll(
                &ground,
                Run { mass, speed: 0.7, from: met - 0.3, met },
                |_, since| since > 0.25,
                &mut s,
            );
            let (_, theory) = w.impact(mass, angle);
            lost(o, &format!("at a step of {h} radii, {label}"), value, theory, inelastic);
            o.series.push(s);
        }
    }
    let angle = radians(30.0);
    let (ground, met) = w.corner(angle);
    let mut s = series("facet-30");
    let value = w.roll(
        &ground,
        Run { mass: alone, speed: 0.7, from: met - 0.3, met },
        |_, since| since > 0.15,
        &mut s,
    );
    lost(o, "at a facet of 30°, wheel alone", value, w.impact(alone, angle).1, inelastic);
    o.series.push(s);
    // Up and down a ridge whose sides are six nodes long, slowly enough that it doesn't leave the ground at the top.
    let (side, angle) = (6.0 * PITCH, radians(20.0));
    let ground = w.ground(|x| (side - x.abs()).max(0.0) * tan(angle));
    let (kept, _) = w.impact(alone, angle);
    let speed = (2.6 * side * tan(angle) / (1.0 + k / w.own)).sqrt() / kept;
    let mut s = series("ridge");
    let end = side + 0.5;
    let value =
        w.roll(&ground, Run { mass: alone, speed, from: -side - 1.0, met: end }, |x, _| x > end, &mut s);
    let theory = 1.0 - kept * kept * kept * kept;
    lost(o, "over a ridge of 20°, wheel alone", value, theory, "an impact at either foot: 1 − (u/v)⁴");
    o.series.push(s);
    // Down a facet from rest, without loss.
    let angle = radians(20.0);
    let ground = w.ground(|x| -x * tan(angle));
    let mut stand = w.stand(alone, -5.0, 0.0);
    let deflection = vb_sim::tyre::Tyre::new(w.tyre).deflection(w.weight(alone) * cos(angle));
    stand.hub.z = (w.radius - deflection) / cos(angle) - stand.hub.x * tan(angle);
    let seconds = 4.0 * w.beat();
    for _ in 0..(seconds / w.step) as usize {
        stand.advance(&ground, w.friction, [0.0, -w.weight(alone)], false);
    }
    let rate = stand.velocity.norm() / seconds;
    let theory = GRAVITY * sin(angle) / (1.0 + k / w.own);
    o.expect(
        "hard: acceleration rolling down a facet of 20°",
        rate,
        "m/s²",
        Expected::fraction(theory, 0.02),
        "g sin / (1 + J/(m r²))",
    );
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_vehicle::VehicleSpec;

    #[test]
    fn an_impact_of_a_wheel_alone_keeps_its_angular_momentum_about_the_edge() {
        let text = include_str!("../../../../../tasks/vehicles/hmmwv.yaml");
        let spec = VehicleSpec::parse(text, "hmmwv.yaml").unwrap();
        let (radius, own, spin_inertia) = (0.5, 80.0, 6.0);
        let wheel = Wheel {
            tyre: &spec.tyre,
            radius,
            load: 6000.0,
            fraction: 600.0,
            own,
            spin_inertia,
            friction: 0.9,
            step: 1e-3,
        };
        for h in [0.1, 0.4, 0.9] {
            let (kept, lost) = wheel.impact([own; 2], acos(1.0 - h));
            let k = spin_inertia / (radius * radius);
            assert!((kept - (1.0 - h * own / (own + k))).abs() < 1e-12, "{kept}");
            assert!((lost - (1.0 - kept * kept)).abs() < 1e-12);
            // What can't move with the wheel along x costs nothing if the wheel itself weighs nothing.
            assert!(wheel.impact([1e9, 1e-3], acos(1.0 - h)).1 < 1e-5);
        }
    }
}
