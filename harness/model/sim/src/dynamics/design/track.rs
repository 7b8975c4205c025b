//! What a track is: its wheels, its belt's way at design height, and what the belt is made of.

use crate::V3;
use crate::powertrain::{Load, Pair};
use crate::track::{Course, Disc};
use crate::tyre::Tyre;
use vb_vehicle::{Axle, TyreSpec, VehicleSpec, tracks::Tracks};

/// One track without its state.
#[derive(Clone)]
pub(crate) struct Track {
    /// Number of its foremost wheel; the others are every second from there.
    pub(crate) first: usize,
    /// Which of its wheels is the sprocket.
    pub(crate) sprocket: usize,
    pub(crate) spec: Tracks,
    /// The way of the belt at design height.
    pub(crate) course: Course,
    /// Its length, m.
    pub(crate) length: f64,
    /// Points at which each span between two wheels is held against hard ground.
    pub(crate) points: Vec<usize>,
    /// What a span that touches ground or obstacle is made of.
    pub(crate) belt: Tyre,
    pub(crate) width: f64,
    /// Radius of a wheel of the tyre by which spans are computed, m.
    pub(crate) radius: f64,
    /// The stiffness per depth of that tyre, N/m.
    pub(crate) hardness: f64,
    /// Distance over which a wheel sheds the shear of its pads, m.
    pub(crate) spacing: f64,
    /// Mass of a metre of belt, kg/m.
    pub(crate) line_density: f64,
    /// Forward of the centre of mass, the middle of the track, and above it, the road wheels' centres, both at design
    /// height, m.
    pub(crate) middle: [f64; 2],
    /// Distance of the track to the left of the centre of mass, m.
    pub(crate) aside: f64,
    /// From where to where the belt may touch soil, forward of the middle, m.
    pub(crate) reach: [f64; 2],
    /// Height of the middle above the ground up to which it may do so, m.
    pub(crate) near: f64,
}

/// Speed of a wheel of an axle over that of its outer face, in which it turns with a belt: a sprocket's teeth reach to the
/// middle of it, the others roll on its inner face. 1 where there is no belt.
pub(crate) fn gearing(v: &VehicleSpec, axle: &Axle) -> f64 {
    let Some(t) = &v.tracks else { return 1.0 };
    let outer = v.tyre_of(axle).radius();
    outer / (outer - t.thickness * if axle.driven { 0.5 } else { 1.0 })
}

/// What a tracked vehicle's driveline moves: the two sprockets, each with all that turns with it.
pub(crate) fn sprockets(v: &VehicleSpec) -> Option<Load<'_>> {
    let t = v.tracks.as_ref()?;
    let sprocket = v.axles.iter().find(|a| a.driven)?;
    let radius = v.tyre_of(sprocket).radius() - 0.5 * t.thickness;
    let mut inertia = sprocket.spin_inertia + t.mass * radius * radius;
    for a in v.axles.iter().filter(|a| !a.driven) {
        let ratio = radius / (v.tyre_of(a).radius() - t.thickness);
        inertia += a.spin_inertia * ratio * ratio;
    }
    let pairs = vec![Pair { inertia, driven: true }];
    Some(Load { powertrain: &v.powertrain, mass: v.total_mass(), radius, pairs, skid: None })
}

impl Track {
    /// The track of a side (0 left, 1 right), if the vehicle has any; `hubs` are the centres of all wheels at design height
    /// relative to the centre of mass.
    pub(crate) fn new(v: &VehicleSpec, side: usize, hubs: &[V3]) -> Option<Self> {
        let t = v.tracks.as_ref()?;
        let count = v.axles.len();
        let discs: Vec<Disc> = (0..count)
            .map(|j| {
                let hub = hubs[2 * j + side];
                let radius = v.tyre_of(&v.axles[j]).radius() - 0.5 * t.thickness;
                Disc { centre: [hub.x, hub.z], radius }
            })
            .collect();
        let course = Course::around(&discs);
        let TyreSpec::Rigid(tyre) = v.tyre_of(&v.axles[1]) else { return None };
        // A point every two thicknesses of the belt or so.
        let points = |length: f64| ((length / (2.0 * t.thickness)) as usize).clamp(2, 8);
        let (front, rear) = (&discs[0], &discs[count - 1]);
        let middle = 0.5 * (front.centre[0] + rear.centre[0]);
        let level = discs[1].centre[1];
        let half = 0.5 * t.thickness;
        let reach =
            [rear.centre[0] - 0.9 * (rear.radius + half), front.centre[0] + 0.9 * (front.radius + half)];
        let length = course.length();
        Some(Self {
            first: side,
            sprocket: if v.axles[0].driven { 0 } else { count - 1 },
            spec: t.clone(),
            length,
            points: course.spans()[..count - 1].iter().map(|s| points(s.length)).collect(),
            belt: Tyre::new(&TyreSpec::Rigid(tyre.clone())),
            width: tyre.width,
            radius: tyre.radius,
            hardness: tyre.vertical_stiffness,
            spacing: tyre.relaxation_length,
            line_density: t.mass / length,
            middle: [middle, level],
            aside: hubs[side].y,
            reach: reach.map(|x| x - middle),
            // Whole tracks stand clear of the ground while one end of them still touches it.
            near: tyre.radius + 0.5 * (reach[1] - reach[0]),
            course,
        })
    }

    pub(crate) fn count(&self) -> usize {
        self.course.discs().len()
    }

    /// Number of the vehicle's wheel that is this track's `j`th.
    pub(crate) fn wheel(&self, j: usize) -> usize {
        self.first + 2 * j
    }

    /// Radius at which the belt runs around the sprocket, m.
    pub(crate) fn pitch_radius(&self) -> f64 {
        self.course.discs()[self.sprocket].radius
    }

    /// Radius of the belt's outer face around the `j`th wheel, m.
    pub(crate) fn outer_radius(&self, j: usize) -> f64 {
        self.course.discs()[j].radius + 0.5 * self.spec.thickness
    }

    /// The spin of the sprocket at a speed of the belt (m/s), rad/s.
    pub(crate) fn sprocket_spin(&self, speed: f64) -> f64 {
        speed / self.pitch_radius()
    }
}
