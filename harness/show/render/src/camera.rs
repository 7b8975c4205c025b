//! Cameras: how points of the world come to places on the canvas.

use crate::V3;
use nalgebra::UnitQuaternion;
use vb_math::{angle::radians, hypot, tan};
use vb_world::{Heightfield, Obstacle, World};

/// From where the world is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum View {
    /// From behind and above the vehicle, along its heading. The camera stays level whatever the vehicle does; it rises
    /// where ground or obstacles would else be around it or between it and the vehicle.
    Chase,
    /// Straight down, with the north at the top of the picture and one scale everywhere.
    Top {
        /// The side of the square, m, that fits into the picture with the vehicle in its middle; `None` for the whole
        /// world.
        window: Option<f64>,
    },
    /// From a place of one's own, level, with the opening of [`View::Chase`].
    From(Sight),
}

/// A place to look from, and what is looked at; the one must not be straight above the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight {
    /// The place of the eye in the world, m.
    pub eye: [f64; 3],
    /// The point in the middle of the picture, m.
    pub at: [f64; 3],
}

/// The opening of the chase camera from top to bottom, degrees.
pub(crate) const OPENING: f64 = 48.0;
/// Places of the chase camera in lengths of the vehicle: behind its middle, and above it.
const BEHIND: f64 = 2.3;
const ABOVE: f64 = 0.95;
/// The point that it looks at, likewise: before the middle, and above it.
const LOOK: [f64; 2] = [0.8, 0.1];
/// Its least height above anything, in lengths of the vehicle.
const CLEAR: f64 = 0.25;
/// The distance of the nearest thing that it sees, in lengths of the vehicle.
const NEAR: f64 = 0.06;

/// How lengths across the line of sight become samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Lens {
    /// A pinhole: `focal` samples across for one metre across at a depth of one metre.
    Pinhole { focal: f64, near: f64 },
    /// Parallel rays: samples a metre.
    Parallel { scale: f64 },
}

/// A place on the canvas: samples to the right and down from its upper left corner, and the nearness, which is linear in
/// these and grows towards the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Spot {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) near: f64,
}

/// A camera with its canvas.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Camera {
    pub(crate) eye: V3,
    pub(crate) right: V3,
    pub(crate) up: V3,
    pub(crate) forward: V3,
    pub(crate) lens: Lens,
    /// The number of samples across and down.
    pub(crate) samples: [usize; 2],
}

impl Camera {
    /// A level pinhole camera that looks at a point, which is neither straight above nor straight below it. `opening`
    /// is the angle between the rays to the middles of the upper and the lower edge, rad.
    pub(crate) fn looking(eye: V3, at: V3, opening: f64, near: f64, samples: [usize; 2]) -> Self {
        let forward = (at - eye).normalize();
        let right = forward.cross(&V3::z()).normalize();
        let focal = 0.5 * samples[1] as f64 / tan(0.5 * opening);
        let lens = Lens::Pinhole { focal, near };
        Self { eye, right, up: right.cross(&forward), forward, lens, samples }
    }

    /// A camera with parallel rays along −z, north up, whose picture's middle is (x, y).
    pub(crate) fn above(eye: V3, scale: f64, samples: [usize; 2]) -> Self {
        let lens = Lens::Parallel { scale };
        Self { eye, right: V3::x(), up: V3::y(), forward: -V3::z(), lens, samples }
    }

    /// A point in the camera's own axes: to the right, up, and along the line of sight, m.
    #[inline]
    pub(crate) fn own(&self, p: &V3) -> V3 {
        let d = p - self.eye;
        V3::new(self.right.dot(&d), self.up.dot(&d), self.forward.dot(&d))
    }

    /// Where a point in the camera's own axes comes to lie on the canvas. Before a pinhole it must be.
    #[inline]
    pub(crate) fn spot(&self, own: &V3) -> Spot {
        let [cx, cy] = self.samples.map(|n| 0.5 * n as f64);
        match self.lens {
            Lens::Pinhole { focal, .. } => {
                let near = 1.0 / own.z;
                Spot { x: cx + focal * own.x * near, y: cy - focal * own.y * near, near }
            }
            Lens::Parallel { scale } => Spot { x: cx + scale * own.x, y: cy - scale * own.y, near: -own.z },
        }
    }

    /// Least depth of what is seen, m.
    #[inline]
    pub(crate) fn nearest(&self) -> f64 {
        match self.lens {
            Lens::Pinhole { near, .. } => near,
            Lens::Parallel { .. } => f64::NEG_INFINITY,
        }
    }

    /// Whether nothing of a sphere can be seen.
    pub(crate) fn misses(&self, centre: &V3, radius: f64) -> bool {
        let own = self.own(centre);
        let [hx, hy] = self.samples.map(|n| 0.5 * n as f64);
        match self.lens {
            Lens::Pinhole { focal, near } => {
                // Distances to the planes through the eye and the canvas' edges.
                let beyond = |across: f64, half: f64| {
                    (focal * across.abs() - half * own.z) / hypot(focal, half) > radius
                };
                own.z + radius < near || beyond(own.x, hx) || beyond(own.y, hy)
            }
            Lens::Parallel { scale } => {
                scale * (own.x.abs() - radius) > hx || scale * (own.y.abs() - radius) > hy
            }
        }
    }

    /// Samples for a metre across at a depth, m.
    pub(crate) fn samples_a_metre(&self, depth: f64) -> f64 {
        match self.lens {
            Lens::Pinhole { focal, near } => focal / depth.max(near),
            Lens::Parallel { scale } => scale,
        }
    }
}

/// The camera that looks along a line of sight, for a vehicle of this length, m.
pub(crate) fn along(sight: &Sight, length: f64, samples: [usize; 2]) -> Camera {
    Camera::looking(sight.eye.into(), sight.at.into(), radians(OPENING), NEAR * length, samples)
}

/// The line of sight from behind a vehicle with its middle here and of this length, m.
pub(crate) fn chase(world: &World, middle: &V3, attitude: &UnitQuaternion<f64>, length: f64) -> Sight {
    let nose = attitude * V3::x();
    let flat = hypot(nose.x, nose.y);
    // A vehicle on its nose or tail heads where its roof or floor looks.
    let heading = if flat > 0.2 { nose } else { -nose.z.signum() * (attitude * V3::z()) };
    let heading = V3::new(heading.x, heading.y, 0.0).try_normalize(1e-9).unwrap_or_else(V3::x);
    let mut eye = middle - BEHIND * length * heading + V3::z() * (ABOVE * length);
    let at = middle + LOOK[0] * length * heading + V3::z() * (LOOK[1] * length);
    let clear = CLEAR * length;
    eye.z = eye.z.max(top(world, eye.x, eye.y, clear) + clear);
    // The line of sight to the vehicle stays free too, all the higher above things the nearer they are to the camera.
    let target = middle + V3::z() * (0.15 * length);
    const STEPS: usize = 24;
    for k in 1..STEPS {
        let share = k as f64 / STEPS as f64;
        let p = target + (eye - target) * share;
        let needed = top(world, p.x, p.y, 0.0) + share * clear;
        if p.z < needed && share > 0.3 {
            eye.z = eye.z.max(target.z + (needed - target.z) / share);
        }
    }
    Sight { eye: eye.into(), at: at.into() }
}

/// The height of ground and obstacles within `reach` of a place, or more, m.
fn top(world: &World, x: f64, y: f64, reach: f64) -> f64 {
    let ground = highest(&world.heightfield, x, y, reach);
    let under = |o: &&Obstacle| {
        let [l, w, _] = o.size();
        hypot(x - o.x, y - o.y) < 0.5 * hypot(l, w) + reach
    };
    let roof = |o: &Obstacle| o.base_z(&world.heightfield) + o.size()[2] - o.buried;
    world.obstacles.iter().filter(under).map(roof).fold(ground, f64::max)
}

/// The height of the highest node of all cells that reach into the square of half side `reach` about a place, m; beyond
/// the edge that of the cells at the edge.
fn highest(field: &Heightfield, x: f64, y: f64, reach: f64) -> f64 {
    let nodes = |v: f64, half: f64, n: usize| {
        let at = |v: f64| ((v + half) / field.resolution()).clamp(0.0, (n - 1) as f64);
        at(v - reach) as usize..=at(v + reach).ceil() as usize
    };
    let cols = nodes(x, field.half_x(), field.cols());
    nodes(y, field.half_y(), field.rows())
        .flat_map(|row| cols.clone().map(move |col| field.node(row, col)))
        .fold(f64::NEG_INFINITY, f64::max)
}

/// The camera above the whole world, or above a window about a place.
pub(crate) fn top_down(
    field: &Heightfield,
    range: [f64; 2],
    position: &V3,
    window: Option<f64>,
    samples: [usize; 2],
) -> Camera {
    let [w, h] = samples.map(|n| n as f64);
    let high = range[1].max(position.z) + 1.0;
    match window {
        Some(side) => Camera::above(V3::new(position.x, position.y, high), w.min(h) / side, samples),
        None => {
            let scale = (w / (2.0 * field.half_x())).min(h / (2.0 * field.half_y()));
            Camera::above(V3::new(0.0, 0.0, high), scale, samples)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_comes_to_lie_where_the_pinhole_formula_says() {
        // Eye 2 m above the origin, looking north and level: east is to the right.
        let camera =
            Camera::looking(V3::new(0.0, 0.0, 2.0), V3::new(0.0, 5.0, 2.0), radians(90.0), 0.1, [640, 480]);
        // Opening of 90°: the focal length is half the height, 240 samples. 1 m right, 0.5 m up, at 4 m.
        let spot = camera.spot(&camera.own(&V3::new(1.0, 4.0, 2.5)));
        assert!((spot.x - (320.0 + 240.0 * 1.0 / 4.0)).abs() < 1e-9, "{spot:?}");
        assert!((spot.y - (240.0 - 240.0 * 0.5 / 4.0)).abs() < 1e-9, "{spot:?}");
        assert!((spot.near - 0.25).abs() < 1e-12);
    }

    #[test]
    fn north_is_up_and_east_is_right_from_above() {
        let field = Heightfield::flat(11, 21, 1.0, 0.0);
        let camera = top_down(&field, [0.0, 0.0], &V3::zeros(), None, [400, 400]);
        // 20 m wide: 20 samples a metre.
        let spot = camera.spot(&camera.own(&V3::new(3.0, 4.0, 0.0)));
        assert!((spot.x - 260.0).abs() < 1e-9 && (spot.y - 120.0).abs() < 1e-9, "{spot:?}");
        let about = top_down(&field, [0.0, 0.0], &V3::new(3.0, 4.0, 0.0), Some(8.0), [400, 200]);
        let spot = about.spot(&about.own(&V3::new(5.0, 4.0, 0.0)));
        assert!((spot.x - 250.0).abs() < 1e-9 && (spot.y - 100.0).abs() < 1e-9, "{spot:?}");
    }

    #[test]
    fn spheres_are_missed_only_beyond_the_edges() {
        let camera = Camera::looking(V3::zeros(), V3::x(), radians(90.0), 0.1, [480, 480]);
        // The edges' planes are at 45°.
        let at = |angle: f64| 10.0 * V3::new(vb_math::cos(radians(angle)), vb_math::sin(radians(angle)), 0.0);
        let off = 10.0 * vb_math::sin(radians(5.0));
        assert!(!camera.misses(&at(40.0), 0.01));
        assert!(camera.misses(&at(50.0), off - 0.01) && !camera.misses(&at(50.0), off + 0.01));
        assert!(
            camera.misses(&V3::new(-1.0, 0.0, 0.0), 1.0) && !camera.misses(&V3::new(-1.0, 0.0, 0.0), 1.2)
        );
    }

    #[test]
    fn the_chase_camera_is_above_everything_and_sees_the_vehicle() {
        let mut stream = vb_math::rng::Stream::new(3, &["chase"]);
        let n = 65;
        // Ground as rough as none that can be driven on: 6 m between neighbours.
        let heights = (0..n * n).map(|_| stream.uniform(0.0, 6.0)).collect();
        let mut world =
            World::uniform("w", Heightfield::new(n, n, 1.0, heights), vb_world::TerrainClass::Rock, 0.5);
        world.obstacles = (0..40)
            .map(|seed| Obstacle {
                x: stream.uniform(-30.0, 30.0),
                y: stream.uniform(-30.0, 30.0),
                yaw: 0.0,
                buried: 1.0,
                kind: vb_world::ObstacleKind::Boulder { size: [4.0, 4.0, 5.0], seed },
            })
            .collect();
        let field = &world.heightfield;
        let length = 4.7;
        for _ in 0..300 {
            let (x, y) = (stream.uniform(-31.0, 31.0), stream.uniform(-31.0, 31.0));
            let turn = UnitQuaternion::from_euler_angles(
                stream.uniform(-3.2, 3.2),
                stream.uniform(-1.6, 1.6),
                stream.uniform(-3.2, 3.2),
            );
            let middle = V3::new(x, y, field.height(x, y) + 1.0);
            let eye = V3::from(chase(&world, &middle, &turn, length).eye);
            let inside = |v: f64| v.clamp(-32.0, 32.0);
            let ground = field.height(inside(eye.x), inside(eye.y));
            assert!(eye.z >= ground + CLEAR * length - 1e-9, "{eye:?} {ground}");
            for o in &world.obstacles {
                let near = hypot(eye.x - o.x, eye.y - o.y) < 2.0;
                assert!(!near || eye.z > o.base_z(field) + 4.0, "{eye:?} {o:?}");
            }
            // The camera is behind: as far as it has to be, whatever the attitude.
            let away = hypot(eye.x - x, eye.y - y);
            assert!((away - BEHIND * length).abs() < 1e-9, "{away}");
        }
        // A wall of 5 m between the camera and a vehicle on level ground: it looks over it.
        let heights = (0..n * n).map(|i| if i % n == 26 { 5.0 } else { 0.0 }).collect();
        let world =
            World::uniform("w", Heightfield::new(n, n, 1.0, heights), vb_world::TerrainClass::Rock, 0.5);
        let middle = V3::new(0.0, 0.0, 1.0);
        let eye = V3::from(chase(&world, &middle, &UnitQuaternion::identity(), length).eye);
        // The wall is at x = -6, the eye at x = -10.8.
        let sight = middle.z + (eye.z - middle.z) * 6.0 / -eye.x;
        assert!(eye.x < -10.0 && sight > 4.0, "{eye:?} {sight}");
        // A peak behind the camera, as near as its clearance: it is above that too.
        let heights = (0..n * n).map(|i| if i == 32 * n + 20 { 20.0 } else { 0.0 }).collect();
        let field = Heightfield::new(n, n, 1.0, heights);
        let world = World::uniform("w", field, vb_world::TerrainClass::Rock, 0.5);
        let eye = V3::from(chase(&world, &middle, &UnitQuaternion::identity(), length).eye);
        assert!(eye.x < -10.8 && eye.z >= 20.0 + CLEAR * length, "{eye:?}");
    }
}
