//! Tracks: a belt about the wheels of each side.
//!
//! A belt doesn't stretch along its way but for its tensioner, so one speed moves all of it, and the wheels of a side turn
//! with it. On hard ground each wheel with the belt around it meets the ground as a wheel does, and between two wheels the
//! belt does ([`span`]); on soil it presses as a whole ([`soil`]). What pushes the belt along its way goes by its tension to
//! the sprocket, what pushes it inwards goes to the wheels.
//!
//! Tension: a massless belt gains what the ground's thrust is from wheel to wheel, T_j = T_{j−1} + F_j from the front to the
//! rear; its mean follows from the length of its way ([`Course`]). Each wheel is pulled by T_j e_j − T_{j−1} e_{j−1}, where e
//! points along a span towards the rear. Taken at the wheels' centres together with the sprocket's reaction on the hull
//! these forces have the moment of the thrust about every point, which is what the equations of motion need.

mod soil;
mod span;

use super::{Corner, Forces, Ground, Vehicle};
use crate::powertrain::{Load, Pair, Wheels};
use crate::soil::{Footprint, TRACK};
use crate::state::Controls;
use crate::track::{Course, Disc};
use crate::tyre::{Patch, Tyre};
use crate::{M3, V3};
use vb_vehicle::{TyreSpec, VehicleSpec, tracks::Tracks};

/// Width of the belt's contact with the ground that stands for it, over the belt's: strips at its radius of gyration.
const STRIP: f64 = 0.288_675_134_594_812_9;

/// One track with its state.
#[derive(Clone)]
pub(super) struct Track {
    /// Number of its foremost wheel; the others are every second from there.
    first: usize,
    /// Which of its wheels is the sprocket.
    sprocket: usize,
    data: Data,
    /// What a span that touches ground or obstacle is made of.
    belt: Tyre,
    width: f64,
    /// Length of the way at design height, m.
    design_length: f64,
    course: Course,
    // State.
    /// Of the belt along its way, m/s; positive when it drives forward.
    speed: f64,
    spans: Vec<Span>,
    /// Length of the way in the last step, m.
    length: f64,
    footprint: Footprint<TRACK>,
    /// To which wheels a station's force goes: the wheel in front, and the share of the one behind.
    fractions: [(usize, f64); TRACK],
    // Of this step.
    /// Forward force of ground and obstacles along the belt at each wheel, N.
    thrust: Vec<f64>,
    /// Distance of the track to the left of the centre of mass, m.
    aside: f64,
}

/// What doesn't change.
#[derive(Clone)]
struct Data {
    spec: Tracks,
    /// Radius of a wheel of the tyre by which spans are computed, its stiffness per depth, m and N/m.
    radius: f64,
    hardness: f64,
    /// Distance over which a wheel sheds the shear of its pads, m.
    spacing: f64,
    /// Mass of a metre of belt, kg/m.
    line_density: f64,
    /// Below the centre of mass, design height of the road wheels' centres, and middle of the track, m.
    middle: [f64; 2],
}

/// A part of the belt between two wheels.
#[derive(Clone, Default)]
struct Span {
    ground: Patch,
    obstacle: Patch,
    /// N, in the last step.
    tension: f64,
    /// How far soil presses its middle inwards, m, and how fast, m/s.
    sag: f64,
    sag_rate: f64,
    /// Points at which it is held against hard ground.
    points: usize,
}

/// Speed of a wheel of an axle over that of its outer face, in which it turns with a belt: a sprocket's teeth reach to the
/// middle of it, the others roll on its inner face. 1 where there is no belt.
pub(super) fn gearing(v: &VehicleSpec, axle: &vb_vehicle::Axle) -> f64 {
    let Some(t) = &v.tracks else { return 1.0 };
    let outer = v.tyre_of(axle).radius();
    outer / (outer - t.thickness * if axle.driven { 0.5 } else { 1.0 })
}

/// What a tracked vehicle's driveline moves: the two sprockets, each with all that turns with it.
pub(super) fn sprockets(v: &VehicleSpec) -> Option<Load<'_>> {
    let t = v.tracks.as_ref()?;
    let sprocket = v.axles.iter().find(|a| a.driven)?;
    let radius = v.tyre_of(sprocket).radius() - 0.5 * t.thickness;
    let mut inertia = sprocket.spin_inertia + t.mass * radius * radius;
    for a in v.axles.iter().filter(|a| !a.driven) {
        let ratio = radius / (v.tyre_of(a).radius() - t.thickness);
        inertia += a.spin_inertia * ratio * ratio;
    }
    let pairs = vec![Pair { inertia, driven: true }];
    Some(Load { powertrain: &v.powertrain, mass: v.total_mass(), radius, pairs })
}

impl Track {
    /// The track of a side (0 left, 1 right), if the vehicle has any; `hubs` are the centres of all wheels at design height
    /// relative to the centre of mass.
    pub(super) fn new(v: &VehicleSpec, side: usize, hubs: &[V3], soil_resolution: f64) -> Option<Self> {
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
        let spans = course.spans()[..count - 1]
            .iter()
            .map(|s| Span { tension: t.tension, points: points(s.length), ..Span::default() })
            .collect();
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
            belt: Tyre::new(&TyreSpec::Rigid(tyre.clone())),
            width: tyre.width,
            design_length: length,
            data: Data {
                spec: t.clone(),
                radius: tyre.radius,
                hardness: tyre.vertical_stiffness,
                spacing: tyre.relaxation_length,
                line_density: t.mass / length,
                middle: [middle, level],
            },
            speed: 0.0,
            length,
            footprint: Footprint::track(
                reach.map(|x| x - middle),
                // Whole tracks stand clear of the ground while one end of them still touches it.
                tyre.radius + 0.5 * (reach[1] - reach[0]),
                half,
                tyre.width,
                soil_resolution,
            ),
            fractions: [(0, 0.0); TRACK],
            thrust: vec![0.0; count],
            aside: hubs[side].y,
            spans,
            course,
        })
    }

    fn count(&self) -> usize {
        self.thrust.len()
    }

    /// Number of the vehicle's wheel that is this track's `j`th.
    fn wheel(&self, j: usize) -> usize {
        self.first + 2 * j
    }

    /// Radius at which the belt runs around the sprocket, m.
    fn pitch_radius(&self) -> f64 {
        self.course.discs()[self.sprocket].radius
    }

    /// Lays the belt around the wheels where they are.
    fn lay(&mut self, turn: &M3, forces: &[Forces]) {
        for j in 0..self.count() {
            let hub = turn.tr_mul(&forces[self.wheel(j)].arm);
            self.course.move_to(j, [hub.x, hub.z]);
        }
        self.course.lay();
    }

    /// A vector in the plane of the track, in world axes.
    fn in_world(turn: &M3, [forward, up]: [f64; 2]) -> V3 {
        turn.column(0) * forward + turn.column(2) * up
    }

    /// Takes what the pads are sheared along with the belt, from each wheel to the one over which they come next: pads stay on
    /// the ground where they were laid down until the last wheel has gone over them. The tyre of a wheel sheds its shear at
    /// that rate.
    fn carry_shear(&self, corners: &mut [Corner], dt: f64) {
        let part = dt * self.speed.abs() / self.data.spacing;
        let last = self.count() - 2;
        for i in 1..last {
            let (from, to) = if self.speed >= 0.0 { (last - i, last + 1 - i) } else { (i + 1, i) };
            let sheared = corners[self.wheel(from)].ground_patch.deflection;
            let patch = &mut corners[self.wheel(to)].ground_patch;
            for (deflection, more) in patch.deflection.iter_mut().zip(sheared) {
                *deflection += part * more;
            }
        }
    }

    /// Pulls the wheels with the belt's tension, once its contacts are known.
    fn pull(&mut self, turn: &M3, corners: &[Corner], forces: &mut [Forces], dt: f64) {
        let count = self.count();
        let outer = 0.5 * self.data.spec.thickness;
        for j in 0..count {
            let radius = self.course.discs()[j].radius + outer;
            self.thrust[j] -= forces[self.wheel(j)].spin_moment / radius;
        }
        let length = self.course.length() + self.bent();
        let rate = (length - self.length) / dt;
        self.length = length;
        let stretch =
            self.data.spec.stiffness * (length - self.design_length) + self.data.spec.damping * rate;
        let mean = (self.data.spec.tension + stretch).max(0.0);
        let total: f64 = self.thrust.iter().sum();
        // The slack side doesn't push.
        let slack = (mean - 0.5 * total).max(-total).max(0.0);
        let mut tension = slack;
        for j in 0..count {
            // Of the two sides of the sprocket the one whose tension is that of the first span, or of the last.
            let leads = self.sprocket == 0;
            let before = if j == 0 && leads { slack + total } else { tension };
            if j > 0 || !leads {
                tension += self.thrust[j];
            }
            let after = if j + 1 == count && !leads { slack } else { tension };
            let spans = self.course.spans();
            let e = [spans[(j + count - 1) % count].direction, spans[j].direction];
            let mut force = Self::in_world(turn, e[1]) * after - Self::in_world(turn, e[0]) * before;
            let turned = e[0][1] * e[1][0] - e[0][0] * e[1][1];
            if turned < 0.0 {
                // The belt bends over what lifts the wheel: it presses on that, and the wheel feels no more of it than
                // lies on it.
                let pressing = -turned * 0.5 * (before + after);
                let load = corners[self.wheel(j)].load;
                if pressing > load {
                    let inward = Self::in_world(turn, spans[j].outward());
                    force -= inward * (force.dot(&inward) * (1.0 - load / pressing));
                }
            }
            forces[self.wheel(j)].force += force;
            if j + 1 < count {
                self.spans[j].tension = after.max(0.0);
            }
        }
    }

    /// Numbers on which the next step depends, beside those of the wheels.
    pub(super) fn digest(&self) -> impl Iterator<Item = f64> + '_ {
        let spans = self.spans.iter().flat_map(|s| {
            let (g, o) = (s.ground.deflection, s.obstacle.deflection);
            [g[0], g[1], o[0], o[1], s.tension, s.sag, s.sag_rate]
        });
        [self.speed, self.length].into_iter().chain(spans).chain(self.footprint.digest())
    }

    /// At rest, without forces.
    pub(super) fn reset(&mut self) {
        self.speed = 0.0;
        self.length = self.design_length;
        for s in &mut self.spans {
            *s = Span { tension: self.data.spec.tension, points: s.points, ..Span::default() };
        }
    }

    /// Spin of the sprocket, rad/s.
    pub(super) fn sprocket_spin(&self) -> f64 {
        self.speed / self.pitch_radius()
    }
}

impl Vehicle {
    /// Before the forces on the wheels.
    pub(super) fn carry_shear(&mut self, dt: f64) {
        for t in &self.tracks {
            t.carry_shear(&mut self.corners, dt);
        }
    }

    /// Forces of ground, obstacles and tension on the belts, after those on the wheels.
    pub(super) fn track_forces(&mut self, ground: &mut Ground<'_>, turn: &M3, dt: f64) {
        let mut tracks = std::mem::take(&mut self.tracks);
        for t in &mut tracks {
            t.lay(turn, &self.forces);
            t.thrust.fill(0.0);
            let middle = V3::new(t.data.middle[0], t.aside, t.data.middle[1]);
            let at = self.x + turn * middle;
            let reach = 0.5 * (t.course.discs()[0].centre[0] - t.course.discs()[t.count() - 1].centre[0])
                + 2.0 * t.data.radius;
            let under = if ground.soil.is_empty() {
                crate::soil::Under::Rigid
            } else {
                ground.soil.under(at.x, at.y, reach)
            };
            self.touch_spans(t, ground, under, turn, dt);
            if !ground.soil.is_empty() {
                self.press_soil(t, ground, under, turn, dt);
            }
            t.pull(turn, &self.corners, &mut self.forces, dt);
        }
        self.tracks = tracks;
    }

    /// Advances the belts; returns the torque of driveline and brake on each sprocket, at its wheel's number.
    pub(super) fn spin_tracks(&mut self, controls: Controls, dt: f64) -> [f64; vb_vehicle::MAX_WHEELS] {
        let (mut spins, mut moments, mut brakes, mut torques) = ([0.0; 2], [0.0; 2], [0.0; 2], [0.0; 2]);
        // A positive command turns to the left: the left belt is the inner one.
        let inner = usize::from(self.steering < 0.0);
        for (i, t) in self.tracks.iter().enumerate() {
            let radius = t.pitch_radius();
            spins[i] = t.sprocket_spin();
            moments[i] = -radius * t.thrust.iter().sum::<f64>();
            let load: f64 = (0..t.count()).map(|j| self.corners[t.wheel(j)].load).sum();
            let [rest, growth] = t.data.spec.resistance;
            let friction = (rest + growth * t.speed.abs()) * load * radius;
            let brake = controls.brake * self.corners[t.wheel(t.sprocket)].brake_torque;
            let steering = if i == inner { self.steering.abs() * t.data.spec.steering_torque } else { 0.0 };
            brakes[i] = friction + brake + steering;
        }
        let mut wheels =
            Wheels { spins: &mut spins, moments: &moments, brakes: &brakes, torques: &mut torques };
        let demand = self.demand(&controls);
        self.drive.advance(&demand, &mut wheels, dt);
        let mut all = [0.0; vb_vehicle::MAX_WHEELS];
        for (i, t) in self.tracks.iter_mut().enumerate() {
            t.speed = spins[i] * t.pitch_radius();
            all[t.wheel(t.sprocket)] = torques[i];
            for j in 0..t.count() {
                let outer = t.course.discs()[j].radius + 0.5 * t.data.spec.thickness;
                self.corners[t.wheel(j)].spin = t.speed / outer;
            }
        }
        all
    }
}

#[cfg(test)]
mod tests;
