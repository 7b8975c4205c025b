//! Stands: balances, a heap, a plate and a single wheel.

use crate::{Bed, Bin, GRAVITY, Motion, Packing, PackingError, Quat, Settings, Shape, Tool, V3};
use vb_world::GranularMaterial;

/// Speed of the retreating wall over the square root of the mean radius, √m/s: less than half of √(2 g), which is
/// that of a grain that has fallen by its radius.
const RETREAT: f64 = 2.0;

/// Errors of the balances of momentum, energy and weight of a bed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balance {
    /// Error of the balance of momentum of grains and tool, relative to the impulse on the tool.
    pub momentum: f64,
    /// Error of the balance of angular momentum about the origin, relative to the angular impulse on the tool.
    pub angular_momentum: f64,
    /// Maximum rise of the total energy of a collapsing heap above its previous minimum, relative to the initial energy.
    pub energy_gain: f64,
    /// Minimum total energy of the heap, relative to the initial energy.
    pub energy_left: f64,
    /// Kinetic energy of the heap at the end, relative to the initial energy.
    pub energy_kinetic: f64,
    /// Load on the floor over the weight of the grains at rest. Walls are smooth, so they bear nothing.
    pub floor_load: f64,
}

/// Balances of a bin that is 16 mean radii long and wide and 8 deep: a wheel turns in free space among the grains for 0.2 s, their heap
/// collapses for 1.5 s when its walls are gone, and the grains rest on the floor for 0.3 s.
///
/// # Errors
/// Returns an error if the bin is too large for the grains, which it is not for valid materials.
pub fn balance(material: &GranularMaterial, seed: u64) -> Result<Balance, PackingError> {
    let r = material.mean_radius();
    let bin = Bin { length: 16.0 * r, width: 16.0 * r, depth: 8.0 * r };
    let packing = Packing::poured(material, bin, seed)?;
    let settings = Settings::default();

    let shape = Shape::Wheel { radius: 4.0 * r, width: 3.2 * r, shoulder: 0.8 * r };
    let mut free =
        Bed::new(&packing, material, vec![Tool { shape, friction: 0.7, stiffness: 2e5 }], settings);
    free.without_gravity();
    free.without_bin();
    let motion = Motion {
        position: V3::new(1.3 * r, -0.8 * r, 10.0 * r),
        rotation: Quat::from_axis_angle(&V3::x_axis(), 0.2),
        velocity: V3::zeros(),
        spin: V3::new(0.5, 4.0, -1.0),
    };
    let (mut impulse, mut moment) = (V3::zeros(), V3::zeros());
    for _ in 0..200 {
        let reaction = free.step(&[motion])[0];
        impulse += reaction.impulse;
        moment += reaction.moment + motion.position.cross(&reaction.impulse);
    }
    let [momentum, about_origin] = free.momentum();

    let mut heap = Bed::new(&packing, material, Vec::new(), settings);
    heap.open(f64::INFINITY);
    heap.step(&[]);
    let energy = |bed: &Bed| bed.kinetic_energy() + bed.potential_energy() + bed.elastic_energy();
    let first = energy(&heap);
    let (mut least, mut gain) = (first, 0.0_f64);
    for _ in 0..1500 {
        heap.step(&[]);
        let now = energy(&heap);
        gain = gain.max((now - least) / first);
        least = least.min(now);
    }

    let mut rest = Bed::new(&packing, material, Vec::new(), settings);
    let mut load = 0.0;
    for _ in 0..300 {
        rest.step(&[]);
        load += rest.floor_load() / 300.0;
    }
    Ok(Balance {
        momentum: (momentum + impulse).norm() / impulse.norm(),
        angular_momentum: (about_origin + moment).norm() / moment.norm(),
        energy_gain: gain,
        energy_left: least / first,
        energy_kinetic: heap.kinetic_energy() / first,
        floor_load: load / (rest.mass() * GRAVITY),
    })
}

/// Slope of the heap that is left behind a wall that moves away slowly, rad: a straight line through the surface between 30 and 80 %
/// of the height. The bin is 32 mean radii long, 20 wide and 20 deep.
///
/// # Errors
/// Returns an error if the bin is too large for the grains, which it is not for valid materials.
pub fn angle_of_repose(material: &GranularMaterial, seed: u64) -> Result<f64, PackingError> {
    let r = material.mean_radius();
    let bin = Bin { length: 32.0 * r, width: 20.0 * r, depth: 20.0 * r };
    let packing = Packing::poured(material, bin, seed)?;
    let settings = Settings::default();
    let mut bed = Bed::new(&packing, material, Vec::new(), settings);
    let pace = RETREAT * r.sqrt() * settings.step;
    let way = 2.0 * bin.depth;
    for _ in 0..(way / pace) as usize {
        bed.open(pace);
        bed.step(&[]);
    }
    // The highest grains of the strips of each column, and their mean.
    let strip = 2.5 * r;
    let columns = ((bin.length + way) / strip) as usize;
    let mut tops = vec![[0.0_f64; 8]; columns + 1];
    for grain in bed.grains() {
        let k = ((grain.position.x + 0.5 * bin.length) / strip).max(0.0) as usize;
        let across = ((grain.position.y + 0.5 * bin.width) / strip).clamp(0.0, 7.0) as usize;
        let top = &mut tops[k.min(columns)][across];
        *top = top.max(grain.position.z + grain.radius);
    }
    let heights: Vec<f64> = tops.iter().map(|column| column.iter().sum::<f64>() / 8.0).collect();
    let on_slope = |&(_, &z): &(usize, &f64)| z < 0.8 * heights[0] && z > 0.3 * heights[0];
    let slope: Vec<[f64; 2]> =
        heights.iter().enumerate().filter(on_slope).map(|(k, &z)| [k as f64 * strip, z]).collect();
    Ok(vb_math::atan2(-line(&slope)[1], 1.0))
}

/// The straight line of least squares through points: its value at 0 and its slope.
fn line(points: &[[f64; 2]]) -> [f64; 2] {
    let n = points.len() as f64;
    let mean = |k: usize| points.iter().map(|p| p[k]).sum::<f64>() / n;
    let (x, y) = (mean(0), mean(1));
    let (mut xx, mut xy) = (0.0, 0.0);
    for p in points {
        xx += (p[0] - x) * (p[0] - x);
        xy += (p[0] - x) * (p[1] - y);
    }
    [y - xy / xx * x, xy / xx]
}

/// Pressure under a square plate that is pressed into a bed at a constant speed.
///
/// `side`: of the plate, m. `speed`: m/s. Returns sinkage, m, and mean pressure, Pa, of each centimetre down to `depth`, m.
#[must_use]
pub fn plate(
    packing: &Packing,
    material: &GranularMaterial,
    side: f64,
    speed: f64,
    depth: f64,
) -> Vec<[f64; 2]> {
    let thickness = 0.1 * side;
    let shape = Shape::Box { half: V3::new(0.5 * side, 0.5 * side, 0.5 * thickness) };
    let plate = Tool { shape, friction: material.friction, stiffness: f64::INFINITY };
    let settings = Settings::default();
    let mut bed = Bed::new(packing, material, vec![plate], settings);
    let top = packing.bin.depth + 0.5 * thickness;
    let mut sinkage = 0.0;
    let steps = (0.01 / (speed * settings.step)).round().max(1.0) as usize;
    let centimetres = (depth / 0.01).round() as usize;
    (0..centimetres)
        .map(|_| {
            let (from, mut impulse) = (sinkage, 0.0);
            for _ in 0..steps {
                let motion = Motion {
                    position: V3::new(0.0, 0.0, top - sinkage),
                    rotation: Quat::identity(),
                    velocity: V3::new(0.0, 0.0, -speed),
                    spin: V3::zeros(),
                };
                impulse += bed.step(&[motion])[0].impulse.z;
                sinkage += speed * settings.step;
            }
            let force = impulse / (steps as f64 * settings.step);
            [0.5 * (from + sinkage), force / (side * side)]
        })
        .collect()
}

/// Modulus k, Pa/mⁿ, and exponent n of p = k zⁿ through points of sinkage, m, and pressure, Pa, and the share R² of the variance of ln p
/// that it explains.
#[must_use]
pub fn bekker(points: &[[f64; 2]]) -> (f64, f64, f64) {
    let logs: Vec<[f64; 2]> = points.iter().map(|[z, p]| [vb_math::ln(*z), vb_math::ln(*p)]).collect();
    let [k, n] = line(&logs);
    let mean = logs.iter().map(|p| p[1]).sum::<f64>() / logs.len() as f64;
    let square = |x: f64| x * x;
    let left: f64 = logs.iter().map(|p| square(p[1] - k - n * p[0])).sum();
    let all: f64 = logs.iter().map(|p| square(p[1] - mean)).sum();
    (vb_math::exp(k), n, 1.0 - left / all)
}

/// A rigid wheel on a bed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wheel {
    /// m.
    pub radius: f64,
    /// m.
    pub width: f64,
    /// Weight on the wheel, its own included, N.
    pub load: f64,
    /// Friction coefficient of its surface on the grains.
    pub friction: f64,
    /// Speed of its centre, m/s.
    pub speed: f64,
}

/// Traction and sinkage of a wheel at a slip, averaged over the second half of its path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Traction {
    /// Drawbar pull over load.
    pub pull: f64,
    /// Moment about the axle over load and radius: gross traction.
    pub gross: f64,
    /// Depth of the lowest point of the wheel below the bed, m.
    pub sinkage: f64,
}

/// The bed of [`Wheel::mean`]: long enough to average over stones.
const TRACK: Bin = Bin { length: 3.6, width: 0.9, depth: 0.3 };

impl Wheel {
    /// Mean and standard error of [`Self::drive`] over the beds of 3.6 × 0.9 × 0.3 m of six seeds.
    ///
    /// # Errors
    /// Returns an error if the bed is too small or too large for the grains.
    pub fn mean(
        &self,
        material: &GranularMaterial,
        slip: f64,
        settings: Settings,
    ) -> Result<[Traction; 2], PackingError> {
        let drive = |seed| {
            let run = self.drive(&Packing::tiled(material, TRACK, seed, settings)?, material, slip, settings);
            Ok([run.pull, run.gross, run.sinkage])
        };
        let runs = (1..=6).map(drive).collect::<Result<Vec<_>, PackingError>>()?;
        let n = runs.len() as f64;
        let traction =
            |value: &dyn Fn(usize) -> f64| Traction { pull: value(0), gross: value(1), sinkage: value(2) };
        let mean = |k: usize| runs.iter().map(|run| run[k]).sum::<f64>() / n;
        let error = |k: usize| {
            let squares = runs.iter().map(|run| (run[k] - mean(k)) * (run[k] - mean(k)));
            (squares.sum::<f64>() / (n * (n - 1.0))).sqrt()
        };
        Ok([traction(&mean), traction(&error)])
    }

    /// Drives the wheel along the bin at a constant speed and slip (1 − v/(ω r)); it is free to sink. It starts a radius from the
    /// first wall and ends a radius from the last.
    #[must_use]
    pub fn drive(
        &self,
        packing: &Packing,
        material: &GranularMaterial,
        slip: f64,
        settings: Settings,
    ) -> Traction {
        let shape = Shape::Wheel { radius: self.radius, width: self.width, shoulder: 0.1 * self.width };
        let tool = Tool { shape, friction: self.friction, stiffness: f64::INFINITY };
        let mut bed = Bed::new(packing, material, vec![tool], settings);
        let (dt, mass) = (settings.step, self.load / GRAVITY);
        let spin = self.speed / (self.radius * (1.0 - slip));
        let end = 0.5 * packing.bin.length - self.radius;
        let steps = (2.0 * end / (self.speed * dt)) as usize;
        let (mut z, mut velocity) = (packing.bin.depth + self.radius, 0.0);
        let (mut means, mut count) = (Traction { pull: 0.0, gross: 0.0, sinkage: 0.0 }, 0.0);
        for step in 0..steps {
            let time = step as f64 * dt;
            let motion = Motion {
                position: V3::new(self.speed * time - end, 0.0, z),
                rotation: Quat::from_axis_angle(&V3::y_axis(), spin * time),
                velocity: V3::new(self.speed, 0.0, velocity),
                spin: V3::new(0.0, spin, 0.0),
            };
            let reaction = bed.step(&[motion])[0];
            velocity += reaction.impulse.z / mass - GRAVITY * dt;
            z += velocity * dt;
            if 2 * step >= steps {
                means.pull += reaction.impulse.x / (dt * self.load);
                means.gross -= reaction.moment.y / (dt * self.load * self.radius);
                means.sinkage += packing.bin.depth + self.radius - z;
                count += 1.0;
            }
        }
        Traction { pull: means.pull / count, gross: means.gross / count, sinkage: means.sinkage / count }
    }
}
