//! Where the vehicle's parts are: what theory needs of a specification and a state.

use nalgebra::Vector3;
use vb_sim::VehicleState;
use vb_vehicle::{
    GRAVITY, VehicleModel,
    kinematics::{AxleKinematics, Side, WheelPose},
};

type V3 = Vector3<f64>;

/// One wheel.
#[derive(Clone, Debug)]
pub(crate) struct Corner {
    /// For columns and legends, e.g. `front left`.
    pub(crate) name: String,
    /// +1 left, −1 right.
    pub(crate) side: f64,
    /// Of its tyre, m.
    pub(crate) radius: f64,
    pub(crate) width: f64,
    pub(crate) axle: usize,
    pub(crate) mount: V3,
    /// With half of a beam, kg.
    pub(crate) mass: f64,
    pub(crate) spin_inertia: f64,
    steered: bool,
}

/// Masses and linkages of a vehicle.
#[derive(Clone, Debug)]
pub(crate) struct Geometry {
    pub(crate) axles: Vec<AxleKinematics>,
    pub(crate) corners: Vec<Corner>,
    pub(crate) chassis_mass: f64,
    pub(crate) chassis_com: V3,
    chassis_inertia: V3,
    pub(crate) hull: Vec<V3>,
    /// Of the vehicle's tyre, m; axles may have others.
    pub(crate) radius: f64,
    /// Travel of each wheel on level ground, m.
    pub(crate) rest: Vec<f64>,
    /// Whole mass, kg.
    pub(crate) mass: f64,
    /// Of the whole vehicle in the chassis frame, wheels at design height, m.
    pub(crate) com: V3,
}

impl Geometry {
    /// Of a vehicle whose wheels have these travels at rest, m.
    pub(crate) fn new(model: &VehicleModel, rest: Vec<f64>) -> Self {
        let spec = model.spec();
        let mut corners = Vec::new();
        for (i, axle) in spec.axles.iter().enumerate() {
            for (side, word) in [(1.0, "left"), (-1.0, "right")] {
                corners.push(Corner {
                    name: format!("{} {word}", axle.name),
                    side,
                    radius: spec.tyre_of(axle).radius(),
                    width: spec.tyre_of(axle).width(),
                    axle: i,
                    mount: V3::from(axle.position),
                    // A beam's own mass counts half to each wheel: it lies between them.
                    mass: axle.unsprung_mass + axle.suspension.linkage.beam().map_or(0.0, |b| 0.5 * b.mass),
                    spin_inertia: axle.spin_inertia,
                    steered: axle.steering.is_some(),
                });
            }
        }
        let chassis_com = V3::from(spec.chassis.com);
        let mut geometry = Self {
            axles: model.axles().to_vec(),
            corners,
            chassis_mass: spec.chassis.mass,
            chassis_com,
            chassis_inertia: V3::from(spec.chassis.inertia),
            hull: spec.chassis.hull.iter().flatten().map(|p| V3::from(*p)).collect(),
            radius: spec.tyre.radius(),
            rest,
            mass: 0.0,
            com: V3::zeros(),
        };
        geometry.mass = geometry.chassis_mass + geometry.corners.iter().map(|c| c.mass).sum::<f64>();
        let design = vec![0.0; geometry.corners.len()];
        geometry.com = geometry.com_at(&design);
        geometry
    }

    /// The weight, N.
    pub(crate) fn weight(&self) -> f64 {
        self.mass * GRAVITY
    }

    /// Pose of a wheel's upright relative to its axle's reference point.
    pub(crate) fn upright(&self, corner: usize, travel: f64, steering: f64) -> WheelPose {
        let c = &self.corners[corner];
        let side = if c.side > 0.0 { Side::Left } else { Side::Right };
        self.axles[c.axle].wheel(side, [travel; 2], if c.steered { steering } else { 0.0 })
    }

    pub(crate) fn is_steered(&self, corner: usize) -> bool {
        self.corners[corner].steered
    }

    /// Wheel centre in the chassis frame, m.
    pub(crate) fn hub(&self, corner: usize, travel: f64, steering: f64) -> V3 {
        self.corners[corner].mount + self.upright(corner, travel, steering).hub
    }

    /// Angle of a wheel seen from above, positive to the left, rad.
    pub(crate) fn wheel_angle(&self, corner: usize, travel: f64, steering: f64) -> f64 {
        let axis = self.upright(corner, travel, steering).axis;
        vb_math::atan2(-axis.x, axis.y)
    }

    /// Centre of mass of the whole vehicle in the chassis frame with these travels, m.
    pub(crate) fn com_at(&self, travels: &[f64]) -> V3 {
        let wheels = (0..self.corners.len()).map(|i| self.hub(i, travels[i], 0.0) * self.corners[i].mass);
        (self.chassis_com * self.chassis_mass + wheels.sum::<V3>()) / self.mass
    }

    /// Centre of mass of the whole vehicle in the world, m.
    pub(crate) fn com_of(&self, s: &VehicleState) -> V3 {
        let travels: Vec<f64> = s.wheels.iter().map(|w| w.deflection).collect();
        s.position + s.attitude * self.com_at(&travels)
    }

    /// Wheel centre in the world, m.
    pub(crate) fn hub_of(&self, s: &VehicleState, corner: usize) -> V3 {
        s.position + s.attitude * self.hub(corner, s.wheels[corner].deflection, s.steering)
    }

    /// Outer edge of the tyre's tread at hub height in the chassis frame, m.
    pub(crate) fn tyre_edge(&self, corner: usize, travel: f64, steering: f64) -> V3 {
        let (c, pose) = (&self.corners[corner], self.upright(corner, travel, steering));
        c.mount + pose.hub + pose.axis * (c.side * 0.5 * c.width)
    }

    /// The same in the world, m.
    pub(crate) fn tyre_edge_of(&self, s: &VehicleState, corner: usize) -> V3 {
        s.position + s.attitude * self.tyre_edge(corner, s.wheels[corner].deflection, s.steering)
    }

    /// Distance (m) of the centre line from the point about which the vehicle turns if its wheels roll without slip, with these
    /// travels (m), on the line about which it turns; none if no wheel is steered. Links that turn the wheels of the axles that
    /// aren't steered as the body rolls move that point; of steered axles that ask for different points the nearest counts.
    pub(crate) fn rolling_centre(&self, travels: &[f64], steering: f64) -> Option<f64> {
        let lefts = |steered: bool| {
            (0..self.corners.len()).step_by(2).filter(move |&i| self.is_steered(i) == steered)
        };
        let angle = |i: usize| {
            let c = &self.corners[i];
            let (side, left) = if c.side > 0.0 { (Side::Left, i) } else { (Side::Right, i - 1) };
            let command = if c.steered { steering } else { 0.0 };
            let axis = self.axles[c.axle].wheel(side, [travels[left], travels[left + 1]], command).axis;
            vb_math::atan2(-axis.x, axis.y)
        };
        let rear: Vec<f64> = lefts(false).map(|i| 0.5 * (angle(i) + angle(i + 1))).collect();
        let rear = if rear.is_empty() { 0.0 } else { rear.iter().sum::<f64>() / rear.len() as f64 };
        let cot = |i: usize| 1.0 / vb_math::tan(angle(i));
        let centres = lefts(true).filter_map(|i| {
            let ahead = self.hub(i, 0.0, 0.0).x - self.turning_line();
            let centre = ahead / (2.0 / (cot(i) + cot(i + 1)) - vb_math::tan(rear));
            // An axle on the line itself asks for no centre.
            (ahead.abs() > 1e-9).then_some(centre.abs())
        });
        centres.min_by(f64::total_cmp)
    }

    /// Points of the hull in the world, m.
    pub(crate) fn hull_of(&self, s: &VehicleState) -> Vec<V3> {
        self.hull.iter().map(|p| s.position + s.attitude * p).collect()
    }

    /// Kinetic energy (the chassis' and the wheels' motion as one, and the spins) and energy of height, J. The energy in
    /// springs and tyres isn't in it.
    pub(crate) fn mechanical_energy(&self, s: &VehicleState) -> f64 {
        let com = self.com_of(s);
        let arm = com - s.position;
        let v = s.attitude * s.velocity_body + (s.attitude * s.angular_velocity_body).cross(&arm);
        let turning =
            0.5 * s.angular_velocity_body.dot(&self.chassis_inertia.component_mul(&s.angular_velocity_body));
        let spins: f64 =
            self.corners.iter().zip(&s.wheels).map(|(c, w)| 0.5 * c.spin_inertia * w.speed * w.speed).sum();
        self.weight() * com.z + 0.5 * self.mass * v.norm_squared() + turning + spins
    }

    /// Moment of inertia about the long axis through the centre of mass of the whole vehicle, wheels at design height, kg m².
    pub(crate) fn roll_inertia(&self) -> f64 {
        let about = |mass: f64, at: V3| mass * (at - self.com).yz().norm_squared();
        let wheels = (0..self.corners.len()).map(|i| about(self.corners[i].mass, self.hub(i, 0.0, 0.0)));
        self.chassis_inertia.x + about(self.chassis_mass, self.chassis_com) + wheels.sum::<f64>()
    }

    /// Distance between the first and the last axle, wheels at design height, m.
    pub(crate) fn wheelbase(&self) -> f64 {
        self.hub(0, 0.0, 0.0).x - self.hub(self.corners.len() - 1, 0.0, 0.0).x
    }

    /// x of the line about which the vehicle turns without slip: the mean of the axles that aren't steered, or of all
    /// but the first if all are, m.
    pub(crate) fn turning_line(&self) -> f64 {
        let mean = |fixed: &dyn Fn(usize) -> bool| {
            let places: Vec<f64> = (0..self.corners.len())
                .step_by(2)
                .filter(|&i| fixed(i))
                .map(|i| self.hub(i, 0.0, 0.0).x)
                .collect();
            (!places.is_empty()).then(|| places.iter().sum::<f64>() / places.len() as f64)
        };
        mean(&|i| !self.is_steered(i)).or_else(|| mean(&|i| i > 0)).unwrap_or(0.0)
    }

    /// Smallest distance between the wheels of an axle, wheels at design height, m.
    pub(crate) fn track(&self) -> f64 {
        let at = |i: usize| self.hub(i, 0.0, 0.0).y;
        (0..self.corners.len()).step_by(2).map(|i| at(i) - at(i + 1)).fold(f64::INFINITY, f64::min)
    }
}
