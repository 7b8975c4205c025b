//! Where a vehicle comes to rest on wheels that stand at different heights: its springs, stops and anti-roll bars in balance
//! with the weight, by Newton's method. Independent of the simulator's equations of motion: of its tables only the lengths
//! of struts over travel are used.

use crate::bench::Bench;
use nalgebra::{DMatrix, DVector, UnitQuaternion, Vector3};
use vb_sim::tyre::Tyre;
use vb_vehicle::{
    TyreSpec,
    kinematics::Side,
    suspension::{AntiRoll, Linkage, Spring, StrutStops},
};

/// A vehicle at rest.
#[derive(Clone, Debug)]
pub(crate) struct Standing {
    /// Normal forces of the ground, N; 0 of a wheel that hangs.
    pub(crate) loads: Vec<f64>,
    /// Travels, m, positive in compression.
    pub(crate) travels: Vec<f64>,
    /// Positive right side down, rad.
    pub(crate) roll: f64,
}

/// Springs and stops of one line of action.
type Element = (Option<Spring>, Option<StrutStops>);

/// Statics of a vehicle on vertical forces alone, as on ground that is level under each wheel and doesn't resist sideways.
pub(crate) struct Statics<'a> {
    bench: &'a Bench<'a>,
    tyres: Vec<Tyre>,
    /// Of each axle.
    elements: Vec<Vec<Element>>,
}

/// Parts in which the heights grow from level ground to what is asked for: Newton's method starts each from the last.
const PARTS: u32 = 40;
/// Inclination of a hard wheel at which it stands on its edge, rad: little enough, and not none, for which Newton's method has no slope.
const ON_EDGE: f64 = 0.02;
const ITERATIONS: usize = 60;
/// Steps in which the ground rises until a wheel lifts.
const LIFTS: u32 = 150;
/// Residual, over the weight, that counts as balance.
const BALANCED: f64 = 1e-9;

impl<'a> Statics<'a> {
    /// None for a vehicle with an axle that turns about a pin, or with tracks: its wheels aren't sprung one by one.
    pub(crate) fn new(bench: &'a Bench<'a>) -> Option<Self> {
        let spec = bench.spec;
        let pinned = |l: &Linkage| matches!(l, Linkage::PivotAxle(_));
        if spec.tracks.is_some() || spec.axles.iter().any(|a| pinned(&a.suspension.linkage)) {
            return None;
        }
        Some(Self::springs(bench))
    }

    /// Springs and tyres of any vehicle, for [`push`](Self::push) and [`foot`](Self::foot) alone.
    pub(crate) fn springs(bench: &'a Bench<'a>) -> Self {
        let spec = bench.spec;
        let elements = spec.axles.iter().map(|a| {
            let torsion = match &a.suspension.linkage {
                Linkage::TorsionArm(t) => t.torsion,
                _ => None,
            };
            let torsion = torsion.map(|t| {
                (Some(Spring::Linear { stiffness: t.stiffness, free_length: 0.0, preload: t.preload }), None)
            });
            let struts = a.suspension.struts.iter().map(|s| (s.spring.clone(), s.stops.clone()));
            torsion.into_iter().chain(struts).collect()
        });
        let tyres = spec.axles.iter().flat_map(|a| [Tyre::new(spec.tyre_of(a)), Tyre::new(spec.tyre_of(a))]);
        Self { bench, tyres: tyres.collect(), elements: elements.collect() }
    }

    /// The height (m) at which the first of the other wheels lifts as the ground rises under the wheels in `raised`; none where
    /// no wheel lifts up to `most` (m) or no balance is found. A wheel has lifted that bears less than a hundredth of the mean load.
    pub(crate) fn lifts(&self, raised: &[usize], most: f64) -> Option<f64> {
        let count = self.bench.geometry.corners.len();
        let light = 0.01 * self.bench.geometry.weight() / count as f64;
        let mut u = self.balance(&vec![0.0; count], self.start())?;
        let step = most / f64::from(LIFTS);
        // The least load of the last two steps: between and just beyond them it falls in a line.
        let mut last = [f64::NAN; 2];
        for k in 1..=LIFTS {
            let height = step * f64::from(k);
            let ground: Vec<f64> =
                (0..count).map(|i| if raised.contains(&i) { height } else { 0.0 }).collect();
            let Some(balanced) = self.balance(&ground, u) else {
                // On two wheels alone a vehicle has no balance to find.
                let further = (last[1] - light) / (last[0] - last[1]);
                return (0.0..=2.0).contains(&further).then_some(height + (further - 1.0) * step);
            };
            u = balanced;
            let least = self.residual(&ground, &u).1.into_iter().fold(f64::INFINITY, f64::min);
            if least < light {
                let back = if last[1].is_nan() { 0.0 } else { (light - least) / (last[1] - least) };
                return Some(height - back * step);
            }
            last = [last[1], least];
        }
        None
    }

    /// Where Newton's method starts on level ground.
    fn start(&self) -> DVector<f64> {
        let g = &self.bench.geometry;
        let count = g.corners.len();
        // Height of the reference point, roll, pitch, travels.
        let mut u = DVector::zeros(3 + count);
        u[0] = g.corners[0].radius
            - g.hub(0, g.rest[0], 0.0).z
            - self.tyres[0].deflection(g.weight() / count as f64);
        u.rows_mut(3, count).copy_from_slice(&g.rest);
        u
    }

    /// At rest with the ground at these heights (m) under the wheels; none where no balance is found.
    pub(crate) fn at(&self, ground: &[f64]) -> Option<Standing> {
        let mut u = self.start();
        for part in 0..=PARTS {
            let fraction = f64::from(part) / f64::from(PARTS);
            let heights: Vec<f64> = ground.iter().map(|h| h * fraction).collect();
            u = self.balance(&heights, u)?;
        }
        let (_, loads) = self.residual(ground, &u);
        Some(Standing { loads, travels: u.iter().skip(3).copied().collect(), roll: u[1] })
    }

    fn balance(&self, ground: &[f64], mut u: DVector<f64>) -> Option<DVector<f64>> {
        let n = u.len();
        for _ in 0..ITERATIONS {
            let (r, _) = self.residual(ground, &u);
            if r.norm() < BALANCED {
                return Some(u);
            }
            let mut slope = DMatrix::zeros(n, n);
            for k in 0..n {
                let h = 1e-7 * self.bench.spec.scale;
                let (mut above, mut below) = (u.clone(), u.clone());
                above[k] += h;
                below[k] -= h;
                let change = self.residual(ground, &above).0 - self.residual(ground, &below).0;
                slope.set_column(k, &(change / (2.0 * h)));
            }
            let step = slope.lu().solve(&r)?;
            // The loads have corners where wheels lift and stops begin: no step that makes the balance worse, while there is one.
            let better = |fraction: f64| self.residual(ground, &(&u - &step * fraction)).0.norm() < r.norm();
            let fraction =
                [1.0, 0.5, 0.25, 0.1, 0.03, 0.01].into_iter().find(|s| better(*s)).unwrap_or(0.003);
            u -= step * fraction;
        }
        None
    }

    /// What is out of balance, over the weight: vertical force and moments of the whole, forces of each wheel; and the loads, N.
    fn residual(&self, ground: &[f64], u: &DVector<f64>) -> (DVector<f64>, Vec<f64>) {
        let g = &self.bench.geometry;
        let count = g.corners.len();
        let travels: Vec<f64> = u.iter().skip(3).copied().collect();
        let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), u[2])
            * UnitQuaternion::from_axis_angle(&Vector3::x_axis(), u[1]);
        let com = turn * g.com_at(&travels);
        let (mut r, mut loads) = (DVector::zeros(u.len()), Vec::with_capacity(count));
        r[0] = -g.weight();
        for (i, level) in ground.iter().enumerate() {
            let mut load = 0.0;
            for (aside, fraction) in self.strips(i, &travels, &turn) {
                let foot = self.foot(i, aside, &travels, &turn);
                let depth = (level - u[0] - foot.z).max(0.0);
                let part = fraction * self.tyres[i].vertical_force(depth);
                r[0] += part;
                r[1] += part * (foot.y - com.y) / g.track();
                r[2] += part * (foot.x - com.x) / g.wheelbase();
                load += part;
            }
            loads.push(load);
        }
        let h = 1e-6 * self.bench.spec.scale;
        for i in 0..count {
            let linkage = &self.bench.spec.axles[i / 2].suspension.linkage;
            if matches!(linkage, Linkage::Rigid(_)) {
                r[3 + i] = travels[i] / g.radius * g.weight();
                continue;
            }
            let (mut above, mut below) = (travels.clone(), travels.clone());
            above[i] += h;
            below[i] -= h;
            let rises = |of: &dyn Fn(&[f64]) -> f64| (of(&above) - of(&below)) / (2.0 * h);
            let axle = 2 * (i / 2);
            let mut work = 0.0;
            for (j, level) in ground.iter().enumerate().skip(axle).take(2) {
                for (aside, fraction) in self.strips(j, &travels, &turn) {
                    let depth = level - u[0] - self.foot(j, aside, &travels, &turn).z;
                    let part = fraction * self.tyres[j].vertical_force(depth.max(0.0));
                    work += part * rises(&|q: &[f64]| self.foot(j, aside, q, &turn).z);
                }
            }
            let weight = g.weight() * rises(&|q: &[f64]| (turn * g.com_at(q)).z);
            r[3 + i] = work - weight - self.push(i, &travels);
        }
        (r / g.weight(), loads)
    }

    /// Direction of a wheel's axle, to the left, and its centre relative to the reference point, world axes, m.
    fn wheel(
        &self,
        wheel: usize,
        travels: &[f64],
        turn: &UnitQuaternion<f64>,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let g = &self.bench.geometry;
        let axle = 2 * (wheel / 2);
        let side = if wheel == axle { Side::Left } else { Side::Right };
        let pose = g.axles[wheel / 2].wheel(side, [travels[axle], travels[axle + 1]], 0.0);
        (turn * pose.axis, turn * (g.corners[wheel].mount + pose.hub))
    }

    /// Circles of a wheel that bear it: how far each lies to the left of its middle (m), and its share of the stiffness. A
    /// hard wheel that leans stands on its edge; the width of a soft one presses evenly, as two circles a radius of gyration from its
    /// middle do (Rill, Road Vehicle Dynamics, 2012, ch. 3).
    fn strips(&self, wheel: usize, travels: &[f64], turn: &UnitQuaternion<f64>) -> Vec<(f64, f64)> {
        let width = self.bench.geometry.corners[wheel].width;
        let axle = &self.bench.spec.axles[wheel / 2];
        if matches!(self.bench.spec.tyre_of(axle), TyreSpec::Rigid(_)) {
            let (axis, _) = self.wheel(wheel, travels, turn);
            vec![(-0.5 * width * (axis.z / ON_EDGE).clamp(-1.0, 1.0), 1.0)]
        } else {
            let strip = width / 12.0_f64.sqrt();
            vec![(strip, 0.5), (-strip, 0.5)]
        }
    }

    /// Lowest point of a wheel's circle `aside` of its middle (m), relative to the reference point, world axes, m.
    pub(crate) fn foot(
        &self,
        wheel: usize,
        aside: f64,
        travels: &[f64],
        turn: &UnitQuaternion<f64>,
    ) -> Vector3<f64> {
        let (axis, hub) = self.wheel(wheel, travels, turn);
        let down = axis * axis.z - Vector3::z();
        hub + axis * aside + down.normalize() * self.bench.geometry.corners[wheel].radius
    }

    /// Force with which springs, stops and bar push a wheel down: the work that they take in over its travel, N.
    pub(crate) fn push(&self, wheel: usize, travels: &[f64]) -> f64 {
        let axle = wheel / 2;
        let suspension = &self.bench.spec.axles[axle].suspension;
        let kinematics = &self.bench.geometry.axles[axle];
        let at = |shift: f64| {
            let mut q = [travels[2 * axle], travels[2 * axle + 1]];
            q[wheel % 2] += shift;
            [Side::Left, Side::Right].map(|s| kinematics.wheel(s, q, 0.0))
        };
        let h = 1e-6 * self.bench.spec.scale;
        let (below, now, above) = (at(-h), at(0.0), at(h));
        let mut force = suspension.stops.as_ref().map_or(0.0, |s| s.force(travels[wheel]));
        for side in 0..2 {
            for (k, (spring, stops)) in self.elements[axle].iter().enumerate() {
                let length = now[side].struts[k];
                let apart = spring.as_ref().map_or(0.0, |s| s.force(length))
                    + stops.as_ref().map_or(0.0, |s| s.force(length));
                force += apart * (below[side].struts[k] - above[side].struts[k]) / (2.0 * h);
            }
        }
        if let Some(AntiRoll::Travel { stiffness } | AntiRoll::Bar { stiffness, .. }) = suspension.anti_roll {
            let twist = |p: &[vb_vehicle::kinematics::WheelPose; 2]| p[0].bar - p[1].bar;
            force += stiffness * twist(&now) * (twist(&above) - twist(&below)) / (2.0 * h);
        }
        force
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_vehicle::VehicleSpec;

    #[test]
    fn loads_bear_the_weight_at_its_place_and_depend_on_differences_of_height_alone() {
        let text = include_str!("../../../../tasks/vehicles/hmmwv.yaml");
        let spec = VehicleSpec::parse(text, "hmmwv.yaml").unwrap();
        let bench = Bench::new(&spec, &[], 1e-3).unwrap();
        let statics = Statics::new(&bench).unwrap();
        let weight = bench.geometry.weight();
        let level = statics.at(&[0.0; 4]).unwrap();
        assert!((level.loads.iter().sum::<f64>() / weight - 1.0).abs() < 1e-6);
        assert!((level.loads[0] - level.loads[1]).abs() < 1e-6 * weight && level.roll.abs() < 1e-6);
        let higher = statics.at(&[0.3; 4]).unwrap();
        let same = |a: &Standing, b: &Standing| {
            a.loads.iter().zip(&b.loads).all(|(a, b)| (a - b).abs() < 1e-6 * weight)
        };
        assert!(same(&level, &higher));
        // Little enough that all wheels bear: what one side of an axle gains the other loses, and the other axle as much.
        let twisted = statics.at(&[0.02, 0.0, 0.0, 0.02]).unwrap();
        let gained: Vec<f64> = twisted.loads.iter().zip(&level.loads).map(|(a, b)| a - b).collect();
        assert!(gained[0] > 0.0 && gained[3] > 0.0 && gained.iter().sum::<f64>().abs() < 1e-6 * weight);
        assert!((gained[0] + gained[1]).abs() < 0.01 * gained[0], "{gained:?}");
        assert!((gained[0] - gained[3]).abs() < 0.05 * gained[0], "{gained:?}");
    }
}
