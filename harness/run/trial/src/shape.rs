//! The size and the steering of a vehicle as it stands on level ground, measured from what is simulated of it.

use std::sync::Arc;

use vb_math::{atan2, tan};
use vb_sim::{Controls, Gear, SimError, SimOptions, Simulation, SoilSet, Start, VehicleState};
use vb_vehicle::{VehicleModel, VehicleSpec, kinematics::Side, suspension::SteeredBy};
use vb_world::{Heightfield, TerrainClass, World};

/// The dimensions of a vehicle that stands on level ground, and how far its wheels turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StaticShape {
    /// The distance from the foremost to the rearmost point of what collides, hull and wheels, m.
    pub length: f64,
    /// Twice the distance from the centre line to the outermost point of what collides, hull and the tyres' outer faces
    /// with the wheels straight ahead, m. Mirrors and whatever else touches nothing are left out.
    pub width: f64,
    /// The height above ground of the topmost point of what collides, m.
    pub height: f64,
    /// The height above ground of the lowest point of the hull, m.
    pub ground_clearance: f64,
    /// The distance between the first and the last axle, or between the outermost road wheels of a track, m.
    pub wheelbase: f64,
    /// The distance between the wheels of the first axle, m.
    pub track: f64,
    /// The mean angle of the first axle's wheels at steering command 1 or −1, rad, whichever is smaller. For a vehicle on tracks or with
    /// skid steering it is that of a bicycle of its wheelbase which answers small commands by the same curvature.
    pub max_steer_angle: f64,
    /// The radius of the reference point's circle at steering command 1, m: the circle without slip, or that on which a
    /// vehicle on tracks or with skid steering turns while it drives.
    pub min_turn_radius: f64,
    /// How a vehicle with skid steering on wheels turns; none for others.
    pub skid: Option<SkidShape>,
    /// The speed after ten seconds of full throttle in reverse, m/s; 0 for a vehicle without a reverse gear.
    pub max_reverse_speed: f64,
    /// The mass of the whole vehicle, kg.
    pub mass: f64,
}

/// How a vehicle with skid steering on wheels turns at steering command 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkidShape {
    /// The distance of the sides at which wheels without slip would turn the vehicle as fast while it drives, m.
    pub effective_track: f64,
    /// The yaw rate without throttle, in place, rad/s.
    pub in_place: f64,
}

/// Lets the vehicle settle on level ground and measures it.
///
/// # Errors
/// Returns an error if the vehicle can't be simulated.
pub fn static_shape(model: &VehicleModel, options: SimOptions) -> Result<StaticShape, SimError> {
    let spec = model.spec();
    let side = 4.0 * spec.length.max(1.0);
    let level = Heightfield::flat(3, 3, side / 2.0, 0.0);
    let world = World::uniform("level", level, TerrainClass::Concrete, 0.8);
    let start = vb_world::Pose2 { x: 0.0, y: 0.0, yaw: 0.0 };
    let options = SimOptions { start: Start::Settled, ..options };
    let standing = Simulation::new(Arc::new(world), model, &SoilSet::default(), start, options)?;
    let state = standing.state();
    let lowest = spec.chassis.hull.iter().flatten().map(|p| p[2]).fold(f64::INFINITY, f64::min);
    let reach = Reach::of(model);
    let [length, width] = [reach.high[0] - reach.low[0], 2.0 * reach.high[1].max(-reach.low[1])];
    let height = state.position.z + reach.high[2];
    // How far ahead each axle's wheels are, and how far apart.
    let axles: Vec<[f64; 2]> =
        hubs(model).iter().map(|[left, right]| [left[0], left[1] - right[1]]).collect();
    let mass = spec.total_mass();
    let period = (PERIOD / options.step).round() as u64;
    let max_reverse_speed = backwards(&standing, period)?;
    let ground_clearance = if lowest.is_finite() { state.position.z + lowest } else { 0.0 };
    if spec.steering.by == SteeredBy::Differential {
        let road = if spec.tracks.is_some() { &axles[1..axles.len() - 1] } else { &axles[..] };
        let (first, last) = (road[0], road[road.len() - 1]);
        let wheelbase = first[0] - last[0];
        let speed = SKID_SPEED.min(SKID_FRACTION * spec.max_speed);
        let curvature = |command: f64| {
            Ok::<f64, SimError>(curvature(&skid_steer(&standing, command, speed, period)?.state()))
        };
        let skid = match spec.skid {
            Some(_) => Some(SkidShape {
                effective_track: effective_track(spec, &skid_steer(&standing, 1.0, speed, period)?.state()),
                in_place: skid_steer(&standing, 1.0, 0.0, period)?.state().angular_velocity_body.z,
            }),
            None => None,
        };
        return Ok(StaticShape {
            length,
            width,
            height,
            ground_clearance,
            wheelbase,
            track: first[1],
            max_steer_angle: atan2(curvature(SMALL_COMMAND)? / SMALL_COMMAND * wheelbase, 1.0),
            min_turn_radius: 1.0 / curvature(1.0)?,
            skid,
            max_reverse_speed,
            mass,
        });
    }
    let (first, last) = (axles[0], axles[axles.len() - 1]);
    let steered = steering_angle(model);
    // Two axles: the line of the rear one, half a wheelbase behind the reference point. More: the middle of those that
    // are not steered.
    let fixed: Vec<f64> =
        spec.axles.iter().zip(&axles).filter(|(a, _)| a.steering.is_none()).map(|(_, h)| h[0]).collect();
    let [base, ahead] = if axles.len() > 2 && !fixed.is_empty() {
        let line = fixed.iter().sum::<f64>() / fixed.len() as f64;
        [first[0] - line, line.abs()]
    } else {
        [first[0] - last[0], 0.5 * (first[0] - last[0])]
    };
    // The turning circle of the reference point, which lies between the axles, without slip.
    let rear = base / tan(steered);
    Ok(StaticShape {
        length,
        width,
        height,
        ground_clearance,
        wheelbase: first[0] - last[0],
        track: first[1],
        max_steer_angle: steered,
        min_turn_radius: (rear * rear + ahead * ahead).sqrt(),
        skid: None,
        max_reverse_speed,
        mass,
    })
}

/// The time for which controls are held where the vehicle is driven to be measured, s: a whole number of all time steps.
const PERIOD: f64 = 0.01;

/// The command by which the answer to small ones of a vehicle that is steered by its driveline is measured.
const SMALL_COMMAND: f64 = 0.2;

/// The speed at which a vehicle that is steered by its driveline is measured, m/s, and its greatest fraction of the top speed.
const SKID_SPEED: f64 = 3.0;
const SKID_FRACTION: f64 = 0.9;

/// A vehicle that is steered by its driveline, after it was driven on level ground for eight seconds at a steering command and a
/// speed (m/s), with `period` steps in [`PERIOD`]. At speed 0 nothing is pressed.
fn skid_steer(standing: &Simulation, steering: f64, speed: f64, period: u64) -> Result<Simulation, SimError> {
    let mut sim = standing.clone();
    for _ in 0..800 {
        let e = if speed > 0.0 { speed - sim.state().velocity_body.x } else { 0.0 };
        let (throttle, brake) = (e.clamp(0.0, 1.0), (-e).clamp(0.0, 1.0));
        let controls = Controls { steering, throttle, brake, ..Controls::default() };
        sim.advance(controls, period)?;
    }
    Ok(sim)
}

/// The curvature of the way, 1/m.
fn curvature(s: &VehicleState) -> f64 {
    s.angular_velocity_body.z / s.velocity_body.x
}

/// The distance of the sides at which wheels without slip would turn the vehicle as fast, m.
fn effective_track(spec: &VehicleSpec, s: &VehicleState) -> f64 {
    let side = |k: usize| {
        let wheels = s.wheels.iter().skip(k).step_by(2);
        wheels.map(|w| w.speed).sum::<f64>() / spec.axles.len() as f64 * spec.tyre.radius()
    };
    (side(1) - side(0)) / s.angular_velocity_body.z
}

/// The speed backwards after ten seconds of full throttle on level ground, m/s, with `period` steps in [`PERIOD`].
fn backwards(standing: &Simulation, period: u64) -> Result<f64, SimError> {
    let mut sim = standing.clone();
    let controls = Controls { throttle: 1.0, gear: Gear::Reverse, ..Controls::default() };
    for _ in 0..1000 {
        sim.advance(controls, period)?;
    }
    Ok((-sim.state().velocity_body.x).max(0.0))
}

/// The mean angle of the first axle's wheels at steering command 1 or −1, rad, whichever turns them less; 0 without an axle.
fn steering_angle(model: &VehicleModel) -> f64 {
    let Some(first) = model.axles().first() else { return 0.0 };
    let angle = |side: Side, command: f64| {
        let axis = first.wheel(side, [0.0; 2], command).axis;
        atan2(-axis.x, axis.y)
    };
    let lock = |command: f64| 0.5 * (angle(Side::Left, command) + angle(Side::Right, command));
    lock(1.0).min(-lock(-1.0))
}

/// The centres of each axle's left and right wheel in the chassis frame at the design position, straight ahead, front to back, m.
pub(crate) fn hubs(model: &VehicleModel) -> Vec<[[f64; 3]; 2]> {
    let axles = model.spec().axles.iter().zip(model.axles());
    axles
        .map(|(axle, solved)| {
            [Side::Left, Side::Right].map(|side| {
                let hub = solved.wheel(side, [0.0; 2], 0.0).hub;
                [0, 1, 2].map(|k| axle.position[k] + hub[k])
            })
        })
        .collect()
}

/// Least and greatest coordinates of what collides, in the chassis frame, m: the hull, and the wheels straight ahead at
/// design height.
pub(crate) struct Reach {
    pub(crate) low: [f64; 3],
    pub(crate) high: [f64; 3],
}

impl Reach {
    pub(crate) fn of(model: &VehicleModel) -> Self {
        let spec = model.spec();
        let mut reach = Self { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] };
        for point in spec.chassis.hull.iter().flatten() {
            reach.include(*point, [0.0; 3]);
        }
        for (axle, solved) in spec.axles.iter().zip(model.axles()) {
            let tyre = spec.tyre_of(axle);
            for side in [Side::Left, Side::Right] {
                let pose = solved.wheel(side, [0.0; 2], 0.0);
                let along = |k: usize| pose.axis[k].abs().min(1.0);
                // A cylinder reaches as far along a direction as its half width and its radius do together.
                let half = [0, 1, 2].map(|k| {
                    let across = (1.0 - along(k) * along(k)).sqrt();
                    0.5 * tyre.width() * along(k) + tyre.radius() * across
                });
                reach.include([0, 1, 2].map(|k| axle.position[k] + pose.hub[k]), half);
            }
        }
        reach
    }

    /// Makes room for a box about a point.
    fn include(&mut self, middle: [f64; 3], half: [f64; 3]) {
        for k in 0..3 {
            self.low[k] = self.low[k].min(middle[k] - half[k]);
            self.high[k] = self.high[k].max(middle[k] + half[k]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vehicle_is_as_large_as_its_hull_and_the_outer_faces_of_its_tyres() {
        // Length and width by hand from the points of the hulls, and from spindles and tyres: twice the spindle's distance
        // from the centre line and half the tyre's width, or an axle's place and the tyre's radius.
        let expected = [
            // Hull x -2.45..2.21, y +-1.05; tyres 2 (0.909701 + 0.15875). Mirrors: 2.564.
            ("hmmwv", 4.66, 2.1369),
            // Hull from x -2.2, front tyres to 0.97 + 0.28575; rear tyres 2 (0.62 + 0.1524).
            ("gator", 3.45575, 1.5448),
            // Tyres 2 (0.97663 + 0.1675); hull 2.25.
            ("feda", 4.92, 2.28826),
            ("m113", 5.3975, 2.686),
            ("man5t", 7.49, 2.46),
            ("man7t", 7.94, 2.46),
            ("man10t", 9.71, 2.46),
            // Hull from x -0.325, front tyres to 0.23262 + 0.085; tyres 2 (0.16599 + 0.04275), hull 0.156.
            ("artcar", 0.64262, 0.41748),
            // Tyres 2 (0.1 + 0.0205); hull 0.2.
            ("verti4wheeler", 0.49, 0.241),
            // Tyres 2 (0.2775 + 0.05715), the hull 0.9874 long.
            ("husky", 0.9874, 0.6693),
            // Wheels 2 (0.131 + 0.098) and 2 (0.187795 + 0.02).
            ("jackal", 0.458, 0.41559),
            // Fenders of 1.52; tyres 2 (0.56821 + 0.125).
            ("warthog", 1.52, 1.38642),
        ];
        for (name, length, width) in expected {
            let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
                .join(format!("../../../tasks/vehicles/{name}.yaml"));
            let spec = VehicleSpec::load(&file).unwrap();
            let scale = spec.scale;
            let model = VehicleModel::new(spec).unwrap();
            let shape = static_shape(&model, SimOptions::default()).unwrap();
            // Camber and toe turn a tyre by up to a degree.
            let near = |a: f64, b: f64| (a - b).abs() < 0.01 * scale;
            assert!(near(shape.length, length) && near(shape.width, width), "{name}: {shape:?}");
        }
    }

    #[test]
    fn what_is_measured_hardly_depends_on_the_time_step() {
        for name in ["hmmwv", "m113"] {
            let file = format!("{}/../../../tasks/vehicles/{name}.yaml", env!("CARGO_MANIFEST_DIR"));
            let model = VehicleModel::new(VehicleSpec::load(file.as_ref()).unwrap()).unwrap();
            let at = |step: f64| static_shape(&model, SimOptions { step, ..SimOptions::default() }).unwrap();
            let [fine, coarse] = [at(0.2e-3), at(1e-3)];
            let near = |a: f64, b: f64| (a - b).abs() < 0.02 * b;
            assert!(near(fine.max_reverse_speed, coarse.max_reverse_speed), "{name}: {fine:?}, {coarse:?}");
            assert!(near(fine.max_steer_angle, coarse.max_steer_angle), "{name}: {fine:?}, {coarse:?}");
        }
    }

    #[test]
    fn the_hmmwv_is_as_high_as_its_data_sheet_says() {
        let text = include_str!("../../../../tasks/vehicles/hmmwv.yaml");
        let model = VehicleModel::new(VehicleSpec::parse(text, "hmmwv.yaml").unwrap()).unwrap();
        let shape = static_shape(&model, SimOptions::default()).unwrap();
        // AM General's data sheet of the M998A1: 72 in, 1.83 m.
        assert!((shape.height - 1.83).abs() < 0.03, "{}", shape.height);
    }
}
