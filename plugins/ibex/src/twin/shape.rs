//! Vehicle parameters. Planners receive size and mass; other values scale those of the HMMWV
//! (`tasks/vehicles/hmmwv.yaml`): lengths with wheelbase, track or wheel radius, forces with the weight, and times by
//! Froude scaling.

use vb_sdk::Vehicle;
use wide::f32x8;

use super::contact::Outline;
use super::vector::{V3, all};
use super::{GRAVITY, WHEELS};

/// The wheelbase at full scale, m: that of the HMMWV.
const FULL: f32 = 3.302;
/// The hull's underside. The belly (frame rails): front and rear ends in half wheelbases, half width in half tracks,
/// and height above the lowest point (differentials) in ground clearances (fitted on training worlds; 0.12 in the
/// drawing). The ends (bumpers) and sides (rocker panels): extent in half lengths and half tracks, and height above the
/// belly in ground clearances.
const BELLY: ([f32; 2], f32, f32) = ([0.73, -0.73], 0.46, 0.2);
const ENDS: (f32, f32) = (1.0, 0.34);
const SIDES: (f32, f32) = (1.10, 0.315);
/// Static deflection of a tyre, in radii.
const FLATTENED: f32 = 0.083;
/// Yaw rate relative to a bicycle with the mean wheel angle, fitted on training worlds.
const TURNS: f32 = 0.93;
/// Corners of the belly and of the lower edges of both ends, and midpoints of the belly's sides.
const HULL: usize = 10;
/// Planes of the hull's underside: belly, ends and sides.
const PLANES: usize = 5;

/// A plane of the hull's underside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    /// Slopes forward and to the left.
    pub(super) slopes: [f32; 2],
    /// Its height at the centre of mass, m.
    pub(super) height: f32,
    /// The unit vector into the hull, body axes.
    pub(super) normal: [f32; 3],
}

/// A vehicle. Values are SI, and pairs are for front and rear axle, unless stated otherwise.
#[derive(Clone, Debug)]
pub(super) struct Shape {
    pub(super) mass: f32,
    /// The centre of mass, relative to the reference point.
    pub(super) centre: [f32; 3],
    /// Moments of inertia, body axes.
    pub(super) inertia: [f32; 3],
    /// Half of the wheelbase and half of the track.
    half: [f32; 2],
    pub(super) radius: f32,
    /// Root of the length scale relative to the HMMWV, the factor of times.
    pub(super) root: f32,
    /// Static load of a wheel on flat terrain.
    pub(super) share: [f32; 2],
    /// Suspension travel at that load.
    pub(super) rest: [f32; 2],
    pub(super) spring: [f32; 2],
    /// In compression and in rebound.
    pub(super) damper: [[f32; 2]; 2],
    /// Travel at which the stops engage, their stiffness, and the maximum travel.
    pub(super) stop: f32,
    pub(super) stiff: f32,
    pub(super) travel: f32,
    /// Radial stiffness and damping of a tyre.
    pub(super) tyre: f32,
    pub(super) tyre_damper: f32,
    /// The circumference of a wheel.
    pub(super) outline: Outline,
    /// The moment of inertia of a wheel.
    pub(super) spin: f32,
    /// Steering angle of a bicycle with the vehicle's turning circle at full lock.
    pub(super) steer: f32,
    pub(super) steer_rate: f32,
    /// Duration of a change between forward and reverse, and the maximum speed at which it begins.
    pub(super) change: f32,
    pub(super) change_speed: f32,
    /// Weight times wheel radius, the unit of torques.
    pub(super) arm: f32,
    /// Maximum brake torque of a wheel.
    pub(super) brake: f32,
    /// Wheel torque per speed difference of 1 rad/s: between the axles, and between the sides. The step length does not
    /// allow stiffer locks.
    pub(super) clutch: [f32; 2],
    /// Contact stiffness of the hull.
    pub(super) hard: f32,
    /// Points of the hull, relative to the centre of mass, body axes.
    pub(super) hull: [[f32; 3]; HULL],
    /// The hull's underside: the maximum of these planes at each position.
    pub(super) under: [Plane; PLANES],
    /// Extent of the hull from the centre of mass: ahead, behind (negative) and to the side.
    pub(super) reach: [f32; 3],
}

impl Shape {
    /// Builds the vehicle with the hull lowered by `margin`, m at full scale.
    pub(super) fn of(v: &Vehicle, margin: f32) -> Self {
        let (mass, base, track) = (v.mass as f32, v.wheelbase as f32, v.track as f32);
        let (radius, clearance) = (v.wheel_radius as f32, v.ground_clearance as f32);
        let (size, half) = (base / FULL, [0.5 * base, 0.5 * track]);
        let root = size.sqrt();
        let centre = [0.014 * base, 0.0, 0.38 * radius];
        let weight = mass * GRAVITY;
        let (quarter, arm) = (weight / WHEELS as f32, weight * radius);
        let ahead = centre[0] / half[0];
        // Height of the belly at rest on flat terrain, with tyres deflected by 8 %, relative to the centre of mass.
        let bottom = (1.0 + BELLY.2) * clearance - (1.0 - FLATTENED) * radius - centre[2] - margin * size;
        let ([front, rear], side) = (BELLY.0.map(|x| x * half[0] - centre[0]), BELLY.1 * half[1]);
        let (end, wide) = (ENDS.0 * 0.5 * v.length as f32, SIDES.0 * half[1]);
        let (nose, tail) = (end - centre[0], -end - centre[0]);
        let (raised, high) = (ENDS.1 * clearance, SIDES.1 * clearance);
        let plane = |ahead: f32, left: f32, from: f32| {
            let unit = 1.0 / (1.0 + ahead * ahead + left * left).sqrt();
            Plane {
                slopes: [ahead, left],
                height: bottom - from,
                normal: [-ahead * unit, -left * unit, unit],
            }
        };
        let [a, b, c] = [raised / (nose - front), raised / (tail - rear), high / (wide - side)];
        let middle = 0.5 * (front + rear);
        let point = |i: usize| {
            let (x, z) = [(front, 0.0), (middle, 0.0), (rear, 0.0), (nose, raised), (tail, raised)][i / 2];
            [x, if i.is_multiple_of(2) { side } else { -side }, bottom + z]
        };
        Self {
            mass,
            centre,
            inertia: [0.176 * mass * track * track, 0.153 * mass * base * base, 0.188 * mass * base * base],
            half,
            radius,
            root,
            share: [quarter * (1.0 + ahead), quarter * (1.0 - ahead)],
            rest: [0.0; 2],
            spring: [quarter / (0.058 * base), quarter / (0.0265 * base)],
            damper: [[2.41, 1.33], [2.16, 0.877]].map(|axle| axle.map(|of| quarter / (of * root))),
            stop: 0.0327 * base,
            stiff: quarter / (0.004 * base),
            travel: 0.0474 * base,
            tyre: quarter / (FLATTENED * radius),
            tyre_damper: quarter / (3.06 * root),
            outline: Outline::new(),
            spin: 0.0143 * mass * radius * radius,
            steer: TURNS * v.max_steer_angle as f32,
            steer_rate: v.max_steer_rate as f32,
            change: (v.direction_change_time as f32).max(0.1 * root),
            change_speed: v.direction_change_speed as f32,
            arm,
            brake: 0.35 * arm,
            clutch: [0.0219 * arm, 0.0088 * arm],
            hard: weight / (0.02 * base),
            hull: std::array::from_fn(point),
            under: [
                plane(0.0, 0.0, 0.0),
                plane(a, 0.0, a * front),
                plane(b, 0.0, b * rear),
                plane(0.0, c, c * side),
                plane(0.0, -c, c * side),
            ],
            reach: [nose, tail, wide],
        }
    }

    /// The centre of a wheel at a suspension travel, relative to the centre of mass, body axes. Wheels are counted
    /// front to rear, left before right.
    pub(super) fn hub(&self, wheel: usize, travel: f32x8) -> V3 {
        let [a, b] = self.half;
        let x = if wheel < 2 { a } else { -a };
        let y = if wheel.is_multiple_of(2) { b } else { -b };
        V3::new(all(x - self.centre[0]), all(y), travel - all(self.centre[2]))
    }
}
