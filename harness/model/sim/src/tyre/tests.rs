//! Tests of the tyres on a wheel of its own: hub mass, spin inertia, an axle that keeps its direction.

use super::{Patch, Tyre, WheelMotion};
use crate::V3;
use vb_vehicle::GRAVITY;
use vb_vehicle::{TyreSpec, VehicleSpec};
use vb_world::Heightfield;

/// The HMMWV's tyres, by name.
fn tyres() -> Vec<(String, TyreSpec)> {
    let v =
        VehicleSpec::parse(include_str!("../../../../../tasks/vehicles/hmmwv.yaml"), "hmmwv.yaml").unwrap();
    let mut all: Vec<_> = v.tyres.into_iter().collect();
    all.push((v.tyre.model().to_owned(), v.tyre));
    all
}

fn tyre(name: &str) -> TyreSpec {
    tyres().into_iter().find(|(n, _)| n == name).unwrap().1
}

struct Rig {
    tyre: Tyre,
    mass: f64,
    inertia: f64,
    axis: V3,
    hub: V3,
    velocity: V3,
    spin: f64,
    patch: Patch,
    load: f64,
    spin_moment: f64,
    locked: bool,
    dt: f64,
}

impl Rig {
    /// A quarter of an HMMWV on one wheel, 623 kg and 8.7 kg m², heading along x, as deep in its tyre as it weighs on
    /// level ground of height 0.
    fn new(spec: &TyreSpec) -> Self {
        let tyre = Tyre::new(spec);
        let mass = 623.0;
        let height = spec.radius() - tyre.deflection(mass * GRAVITY);
        Self {
            tyre,
            mass,
            inertia: 8.7143,
            axis: V3::y(),
            hub: V3::new(0.0, 0.0, height),
            velocity: V3::zeros(),
            spin: 0.0,
            patch: Patch::default(),
            load: 0.0,
            spin_moment: 0.0,
            locked: false,
            dt: 1e-3,
        }
    }

    /// One step under `push` (N) beside gravity and `torque` (N m) about the axle: the equations of the vehicle's own
    /// step, the damping along the normal implicit.
    fn step(&mut self, ground: &Heightfield, friction: f64, push: V3, torque: f64) {
        let motion = WheelMotion {
            hub: self.hub,
            velocity: self.velocity,
            rotation: self.axis * self.spin,
            axis: self.axis,
            spin: self.spin,
        };
        let mut force = push - V3::z() * (self.mass * GRAVITY);
        let mut inertia = crate::M3::from_diagonal_element(self.mass);
        (self.load, self.spin_moment) = (0.0, 0.0);
        match self.tyre.envelope().query(ground, &self.hub, &self.axis) {
            Some(c) => {
                if let Some(r) = self.tyre.react(&motion, &c, friction, &mut self.patch, self.dt) {
                    force += r.force;
                    (self.load, self.spin_moment) = (r.load, r.spin_moment);
                    inertia += c.normal * c.normal.transpose() * (self.dt * self.tyre.damping());
                }
            }
            None => self.patch = Patch::default(),
        }
        self.velocity += inertia.cholesky().unwrap().solve(&force) * self.dt;
        self.spin += (self.spin_moment + torque) / self.inertia * self.dt;
        if self.locked {
            self.spin = 0.0;
        }
        self.hub += self.velocity * self.dt;
    }

    /// Locked, as deep as it weighs on a grade of so many degrees.
    fn parked(spec: &TyreSpec, slope: f64) -> Self {
        let mut rig = Self::new(spec);
        let cos = vb_math::cos(slope.to_radians());
        rig.hub.z = (spec.radius() - rig.tyre.deflection(rig.mass * GRAVITY * cos)) / cos;
        rig.locked = true;
        rig
    }

    fn rolling(spec: &TyreSpec, speed: f64) -> Self {
        let mut rig = Self::new(spec);
        rig.velocity.x = speed;
        rig.spin = speed / spec.radius();
        rig
    }

    /// Of motion, height and the radial spring, J; without what the carcass stores in the contact plane.
    fn energy(&self, ground: &Heightfield) -> f64 {
        let depth = self.tyre.envelope().query(ground, &self.hub, &self.axis).map_or(0.0, |c| c.depth);
        let mean = |k: i32| self.tyre.vertical_force(depth * (f64::from(k) + 0.5) / 50.0) / 50.0;
        0.5 * self.mass * self.velocity.norm_squared()
            + 0.5 * self.inertia * self.spin * self.spin
            + self.mass * GRAVITY * self.hub.z
            + (0..50).map(mean).sum::<f64>() * depth
    }
}

fn flat() -> Heightfield {
    Heightfield::flat(1001, 11, 1.0, 0.0)
}

/// A plane that rises along x by `degrees`, 200 m long.
fn grade(degrees: f64) -> Heightfield {
    let slope = vb_math::tan(degrees.to_radians());
    Heightfield::new(11, 201, 1.0, (0..11 * 201).map(|i| slope * (f64::from(i % 201) - 100.0)).collect())
}

/// Along y, so that the heightfield may be long in one direction only.
fn road() -> Heightfield {
    Heightfield::flat(11, 1001, 1.0, 0.0)
}

#[test]
fn these_tests_have_a_tyre_of_every_model() {
    let tested: std::collections::BTreeSet<_> = tyres().iter().map(|(_, spec)| spec.model()).collect();
    assert_eq!(tested, TyreSpec::MODELS.iter().copied().collect());
}

#[test]
fn a_twin_tyre_gives_twice_the_forces_of_one() {
    for (name, spec) in tyres() {
        let mut both = spec.clone();
        both.make_twin(0.3);
        assert!((both.width() - spec.width() - 0.3).abs() < 1e-12, "{name}: {}", both.width());
        assert_eq!(both.vertical_damping(), 2.0 * spec.vertical_damping(), "{name}");
        let (one, both) = (Tyre::new(&spec), Tyre::new(&both));
        let load = 6000.0;
        for depth in [0.01, 0.05] {
            let forces = [one.vertical_force(depth), both.vertical_force(depth)];
            assert!((forces[1] / forces[0] - 2.0).abs() < 1e-9, "{name}: {forces:?} at {depth} m");
        }
        for (slip, angle) in [(0.02, 0.0), (0.0, 0.03), (0.3, 0.2)] {
            let [a, b] = [(&one, load), (&both, 2.0 * load)]
                .map(|(tyre, load)| tyre.steady_force(load, slip, angle, 0.8))
                .map(|f| [f.longitudinal, f.lateral]);
            let off = (0..2).map(|k| (b[k] - 2.0 * a[k]).abs()).fold(0.0, f64::max);
            assert!(off < 1e-6 * load, "{name}: {a:?} and {b:?} at {slip}, {angle}");
        }
    }
}

#[test]
fn a_free_wheel_rolls_on_its_effective_radius() {
    // Hard: the free radius. Rill: R_0 − d/3. Adams/Tire's Fiala: R_0 − d.
    for (name, fraction) in [("rigid", 0.0), ("brush", 1.0 / 3.0), ("tmeasy", 1.0 / 3.0), ("fiala", 1.0)] {
        let spec = tyre(name);
        let mut rig = Rig::rolling(&spec, 5.0);
        let ground = road();
        for _ in 0..3000 {
            rig.step(&ground, 0.8, V3::zeros(), 0.0);
        }
        let depth = rig.tyre.deflection(rig.load);
        let radius = rig.velocity.x / rig.spin;
        let expected = spec.radius() - fraction * depth;
        // Rolling resistance takes a slip of 0.015 load over a stiffness of tens of loads.
        assert!((radius / expected - 1.0).abs() < 1e-3, "{name}: {radius} {expected}");
        assert!((rig.load - rig.mass * GRAVITY).abs() < 1.0, "{name}: {}", rig.load);
    }
}

#[test]
fn a_hard_wheel_with_dilation_stands_on_a_gap_of_step_friction_and_sliding_speed() {
    // Anitescu 2006: gap = step · μ · sliding speed. Here 2 cm up and spinning at 20 rad/s.
    let TyreSpec::Rigid(mut spec) = tyre("rigid") else { panic!("rigid") };
    spec.dilation = Some(vb_vehicle::tyre::Dilation { step: 0.005, reach: 0.06 });
    let hard = Tyre::new(&TyreSpec::Rigid(spec.clone()));
    let load = |tyre: &Tyre, spin: f64, gap: f64| {
        let axis = V3::y();
        let hub = V3::new(0.0, 0.0, spec.radius + gap);
        let motion = WheelMotion { hub, velocity: V3::zeros(), rotation: axis * spin, axis, spin };
        let contact = super::Contact { point: V3::zeros(), normal: V3::z(), depth: -gap };
        let reaction = tyre.react(&motion, &contact, 0.6, &mut Patch::default(), 1e-3);
        reaction.map_or(0.0, |r| r.load)
    };
    let lift = 0.005 * 0.6 * 20.0 * (spec.radius + 0.02);
    let expected = spec.vertical_stiffness * (lift - 0.02);
    assert!((load(&hard, 20.0, 0.02) / expected - 1.0).abs() < 1e-9, "{}", load(&hard, 20.0, 0.02));
    // It lets go where the gap is as large, and a wheel that doesn't slide feels nothing above the ground.
    assert_eq!((load(&hard, 20.0, 0.0301), load(&hard, 0.0, 0.001)), (0.0, 0.0));
    // The same tyre without it.
    spec.dilation = None;
    let plain = Tyre::new(&TyreSpec::Rigid(spec.clone()));
    assert_eq!((plain.reach(), load(&plain, 20.0, 0.001)), (0.0, 0.0));
}

#[test]
fn a_locked_wheel_stops_within_the_distance_that_sliding_friction_allows() {
    // v²/(2 μ g). TMeasy slides with F_xS at its load, scaled by μ/μ_0 (sheet: 3954.57 N at pn 8562.83 N, 7252.54 N at
    // 2 pn); Fiala with μ_min · μ/μ_0 at a slip of one.
    let mu = 0.6;
    let q = 623.0 * GRAVITY / 8562.82661;
    let sliding = q * (2.0 * 3954.57021 - 0.5 * 7252.54288 - (3954.57021 - 0.5 * 7252.54288) * q);
    for (name, friction) in [
        ("rigid", mu),
        ("brush", mu),
        ("fiala", 0.5568 * mu / 0.8),
        ("tmeasy", mu / 0.8 * sliding / (623.0 * GRAVITY)),
    ] {
        let mut rig = Rig::rolling(&tyre(name), 15.0);
        rig.locked = true;
        let ground = road();
        while rig.velocity.x > 0.0 {
            rig.step(&ground, mu, V3::zeros(), 0.0);
            assert!(rig.hub.x < 200.0);
        }
        let expected = 15.0 * 15.0 / (2.0 * friction * GRAVITY);
        // Rising friction in the last half metre a second and the carcass' deflection are worth centimetres.
        assert!((rig.hub.x - expected).abs() < 0.1 + 0.005 * expected, "{name}: {} {expected}", rig.hub.x);
    }
}

#[test]
fn a_braked_wheel_stands_below_its_friction_angle_and_slides_above() {
    // atan of the greatest friction: μ itself where friction is Coulomb's; μ_max μ/μ_0 for Fiala; F_xM/load for TMeasy
    // at the load of the slope (sheet: 7703.55 N at pn, 13315.4 N at 2 pn).
    let mu: f64 = 0.5;
    let tmeasy = |angle: f64| {
        let load = 623.0 * GRAVITY * vb_math::cos(angle);
        let q = load / 8562.82661;
        mu / 0.8 * q * (2.0 * 7703.54696 - 0.5 * 13315.3666 - (7703.54696 - 0.5 * 13315.3666) * q) / load
    };
    for (name, spec) in tyres() {
        let angle = vb_math::atan(match name.as_str() {
            "fiala" => 0.9835 * mu / 0.8,
            "tmeasy" => tmeasy(tmeasy(0.5)),
            _ => mu,
        })
        .to_degrees();
        for (slope, holds) in [(0.5 * angle, true), (angle - 0.5, true), (angle + 0.5, false)] {
            let ground = grade(slope);
            let mut rig = Rig::parked(&spec, slope);
            // Settled on better ground first: the jolt of a start would count as a push.
            for k in 0..8000 {
                rig.step(&ground, if k < 3000 { 2.0 } else { mu }, V3::zeros(), 0.0);
            }
            let from = rig.hub;
            let seconds = if holds { 60 } else { 5 };
            for _ in 0..seconds * 1000 {
                rig.step(&ground, mu, V3::zeros(), 0.0);
            }
            let moved = (rig.hub - from).norm();
            if holds {
                assert!(moved < 1e-3, "{name}, {slope} of {angle} deg: {moved} m in 60 s");
            } else {
                assert!(moved > 0.1, "{name}, {slope} of {angle} deg: {moved} m in 5 s");
            }
        }
    }
}

#[test]
fn a_parked_wheel_that_is_shaken_does_not_walk() {
    // 8 degrees of slope and a push of a tenth of the weight to and fro, along and across: half of what friction bears.
    // At 3 Hz, at which none of the tyres bounces.
    for (name, spec) in tyres() {
        let ground = grade(8.0);
        let mut rig = Rig::parked(&spec, 8.0);
        let weight = rig.mass * GRAVITY;
        let mut from = V3::zeros();
        for k in 0..63_000 {
            let swing = 0.1 * weight * vb_math::sin(6.0 * std::f64::consts::PI * 1e-3 * f64::from(k));
            // Over whole periods the mean place.
            if k == 3000 {
                from = rig.hub;
            }
            rig.step(&ground, 0.5, V3::new(swing, 0.3 * swing, 0.0), 0.0);
        }
        let moved = (rig.hub - from).norm();
        assert!(moved < 1e-3, "{name}: {moved} m in 60 s");
    }
}

#[test]
fn without_friction_a_wheel_is_only_carried() {
    for (name, spec) in tyres() {
        let mut rig = Rig::rolling(&spec, 3.0);
        rig.spin = 0.0;
        let ground = road();
        for _ in 0..2000 {
            rig.step(&ground, 0.0, V3::zeros(), 0.0);
        }
        assert!((rig.load - rig.mass * GRAVITY).abs() < 1.0 && (rig.velocity.x - 3.0).abs() < 1e-4, "{name}");
    }
}

#[test]
fn across_a_slope_it_stands_as_well() {
    for (name, spec) in tyres() {
        let ground = grade(15.0);
        let mut rig = Rig::parked(&spec, 15.0);
        rig.axis = V3::new(-1.0, 0.0, -vb_math::tan(15.0_f64.to_radians())).normalize();
        for _ in 0..3000 {
            rig.step(&ground, 0.5, V3::zeros(), 0.0);
        }
        let from = rig.hub;
        for _ in 0..60_000 {
            rig.step(&ground, 0.5, V3::zeros(), 0.0);
        }
        assert!((rig.hub - from).norm() < 1e-3, "{name}: {} m in 60 s", (rig.hub - from).norm());
    }
}

/// What a deflected carcass may give back, J: no more than the friction force over the deflection at which the softest
/// one here slides, the brush's lateral one: ¾ μ F_z · 3 μ F_z/(7.4 F_z/0.467 m) at 0.8 of 6.1 kN.
const STORED: f64 = 600.0;

#[test]
fn a_bouncing_rolling_wheel_never_gains_energy() {
    // Dropped from 0.3 m with spin, drift and speed that don't match; the step's own error is of the order of the step.
    for (name, spec) in tyres() {
        let ground = road();
        let mut rig = Rig::rolling(&spec, 8.0);
        rig.hub.z += 0.3;
        rig.spin = 5.0;
        rig.velocity.y = 0.5;
        let first = rig.energy(&ground);
        let (mut least, mut greatest_rise): (f64, f64) = (first, 0.0);
        for _ in 0..10_000 {
            rig.step(&ground, 0.7, V3::zeros(), 0.0);
            let now = rig.energy(&ground);
            greatest_rise = greatest_rise.max(now - least);
            least = least.min(now);
        }
        assert!(
            greatest_rise < 0.005 * first + 0.5 * STORED,
            "{name}: it gains {greatest_rise} of {first} J"
        );
        assert!(rig.energy(&ground) < 0.95 * first, "{name}: it dissipates");
    }
}

#[test]
fn after_one_relaxation_length_the_lateral_force_has_63_percent() {
    // Relaxation length: slope at zero slip over the carcass' stiffness; Fiala c_alpha/c_y, TMeasy dF_y0(F_z)/c_y.
    for (name, length) in [("fiala", 50_000.0 / 107_000.0), ("tmeasy", 0.0), ("brush", 0.467), ("rigid", 0.1)]
    {
        let spec = tyre(name);
        let tyre = Tyre::new(&spec);
        let load = 6000.0;
        let length = if name == "tmeasy" {
            let q: f64 = load / 8562.82661;
            let slope = q * (2.0 * 63376.0486 - 0.5 * 117319.287 - (63376.0486 - 0.5 * 117319.287) * q);
            slope / 136_000.0
        } else {
            length
        };
        // Rolling at 0.5 m/s along x with a slip angle of 0.05 degrees from t = 0 on.
        let (speed, angle, dt) = (0.5, 0.05_f64.to_radians(), 1e-3);
        let depth = tyre.deflection(load);
        let contact = super::Contact { point: V3::zeros(), normal: V3::z(), depth };
        let rolling = (spec.radius() - tyre.rolling_share * depth).recip() * speed;
        let motion = WheelMotion {
            hub: V3::new(0.0, 0.0, spec.radius() - depth),
            velocity: V3::new(speed, speed * vb_math::tan(angle), 0.0),
            rotation: V3::y() * rolling,
            axis: V3::y(),
            spin: rolling,
        };
        let mut patch = Patch::default();
        let force = |patch: &mut Patch| tyre.react(&motion, &contact, 0.8, patch, dt).unwrap().force.y;
        let steps = (length / speed / dt).round() as usize;
        let mut f = 0.0;
        for _ in 0..steps {
            f = force(&mut patch);
        }
        let end = tyre.steady_force(load, 0.0, angle, 0.8).lateral;
        // The carcass' damper adds to its length what is d/c times the speed: some per cent.
        assert!((f / end - 0.632).abs() < 0.03, "{name}: {} after {length} m", f / end);
        for _ in 0..steps * 20 {
            f = force(&mut patch);
        }
        assert!((f / end - 1.0).abs() < 1e-3, "{name}: settles at {f} N, curve {end} N");
    }
}

#[test]
fn nothing_diverges_between_spinning_at_rest_and_locked_at_forty_metres_a_second() {
    let ground = flat();
    let ground_x = road();
    for (name, spec) in tyres() {
        for (speed, spin, locked) in [
            (0.0, 100.0, false),
            (40.0, 0.0, true),
            (40.0, 0.0, false),
            (40.0, 85.0, false),
            (0.5, -50.0, false),
        ] {
            for (drift, ground) in [(0.0, &ground_x), (10.0, &ground)] {
                let mut rig = Rig::new(&spec);
                rig.velocity = V3::new(speed, drift, 0.0);
                rig.spin = spin;
                rig.locked = locked;
                let first = rig.energy(ground);
                let mut least = first;
                for k in 0..4000 {
                    rig.step(ground, 0.8, V3::zeros(), 0.0);
                    // Friction is at most 0.8, or Fiala's 0.98 on ground as good as the tables': times load and radius.
                    assert!(rig.spin_moment.abs() <= 0.5 * rig.load, "{name}: {} N m", rig.spin_moment);
                    let now = rig.energy(ground);
                    assert!(
                        now < least + 0.005 * first + STORED,
                        "{name} {speed} {spin} {drift}: {now} J after {least} J in step {k}"
                    );
                    least = least.min(now);
                }
            }
        }
    }
}
