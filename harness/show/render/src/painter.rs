//! What draws pictures.

use crate::camera::{Lens, Sight, View, along, chase, top_down};
use crate::canvas::{Canvas, Triangles};
use crate::error::RenderError;
use crate::grains;
use crate::ground::Ground;
use crate::light::Shadow;
use crate::marks::Marks;
use crate::pixel::{Change, Grain, Look};
use crate::solid::{Face, hull, sphere};
use crate::texture::Texture;
use crate::vehicle::Vehicle;
use crate::{Colour, V3};
use nalgebra::UnitQuaternion;
use std::sync::{Arc, Mutex};
use vb_files::lock;
use vb_math::{atan2, hypot};
use vb_sim::VehicleState;
use vb_vehicle::VehicleModel;
use vb_world::{Obstacle, ObstacleKind, World};

const BOULDER: Colour = [128, 124, 118];
const TRUNK: Colour = [112, 82, 54];
const BOX: Colour = [176, 160, 138];

/// Samples of a pixel across and down.
const SAMPLES: usize = 2;
/// A vehicle that is shorter than this from above, in pixels, is shown as an arrow.
const SMALL: f64 = 12.0;

/// The size of a picture in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    pub width: u32,
    pub height: u32,
}

impl Size {
    /// The greatest number of columns, and of rows, that a picture can have.
    pub const MAX: u32 = 4096;

    /// The number of bytes of a picture of this size: three for each pixel.
    #[must_use]
    pub fn bytes(self) -> usize {
        3 * self.width as usize * self.height as usize
    }

    fn check(self) -> Result<(), RenderError> {
        let fits = |n: u32| (1..=Self::MAX).contains(&n);
        if fits(self.width) && fits(self.height) {
            return Ok(());
        }
        Err(RenderError::Size { width: self.width, height: self.height, most: Self::MAX })
    }
}

/// What is drawn into the world at one instant.
#[derive(Clone, Copy)]
pub struct Moment<'a> {
    pub state: &'a VehicleState,
    /// The angles by which the wheels have turned since the start, rad, positive when rolling forward; in the order of
    /// the state's wheels. Wheels without an angle stand still.
    pub turned: &'a [f64],
    /// The goal (x, y) in the world, m.
    pub goal: [f64; 2],
    /// The radius of the ring on the ground around the goal, m; there is no ring if it isn't positive.
    pub goal_radius: f64,
    /// The planned path in the world as points (x, y), m; a line on the ground.
    pub path: &'a [[f64; 2]],
    /// The places (x, y, z) in the world where the vehicle has been, m; a line on the ground below them.
    pub trail: &'a [[f64; 3]],
    /// The change of the ground by ruts and heaps, which darken and brighten it, if it is known.
    pub change: Option<&'a Change<'a>>,
    /// The grains of granular beds: centres and radii in the world, m. Without any, beds look like the ground around them.
    pub grains: &'a [([f64; 3], f64)],
    /// The colour of the vehicle's bodywork and of the trail, red, green and blue in sRGB: that of the run, where several are shown. If
    /// it is left out, they are blue.
    pub colour: Option<[u8; 3]>,
}

/// Draws pictures of one world with one vehicle in it. It can be shared by threads.
#[derive(Clone, Debug)]
pub struct Painter {
    world: Arc<World>,
    range: [f64; 2],
    texture: Texture,
    ground: Ground,
    obstacles: Vec<Body>,
    vehicle: Vehicle,
    grain: Grain,
    /// Memory of canvases that are drawn, one for each thread that has drawn.
    spare: Arc<Mutex<Vec<Triangles>>>,
}

/// An obstacle where it stands, with a sphere around it.
#[derive(Clone, Debug)]
struct Body {
    faces: Vec<Face>,
    centre: V3,
    radius: f64,
}

fn obstacle(o: &Obstacle, world: &World) -> Vec<Face> {
    let colour = match o.kind {
        ObstacleKind::Boulder { .. } => BOULDER,
        ObstacleKind::Trunk { .. } => TRUNK,
        ObstacleKind::Box { .. } => BOX,
    };
    let points: Vec<V3> = o.hull().into_iter().map(V3::from).collect();
    let turn = UnitQuaternion::from_axis_angle(&V3::z_axis(), o.yaw);
    let to = V3::new(o.x, o.y, o.base_z(&world.heightfield));
    hull(&points, colour).iter().map(|f| f.placed(&turn, &to)).collect()
}

impl Painter {
    /// Prepares what stays as it is: the ground's colours with light and shadow, and the solids of obstacles and vehicle.
    /// The world is drawn at the scale that it has (see [`World::scaled`]).
    #[must_use]
    pub fn new(world: &Arc<World>, vehicle: &VehicleModel) -> Self {
        let obstacles: Vec<Vec<Face>> = world.obstacles.iter().map(|o| obstacle(o, world)).collect();
        let texture = Texture::of(world, &obstacles);
        let body = |faces: Vec<Face>| {
            let (centre, radius) = sphere(faces.iter());
            Body { faces, centre, radius }
        };
        let (low, high) = world.heightfield.range();
        Self {
            range: [low, high],
            texture,
            ground: Ground::new(&world.heightfield),
            obstacles: obstacles.into_iter().map(body).collect(),
            vehicle: Vehicle::new(vehicle),
            grain: Grain::new(),
            spare: Arc::default(),
            world: world.clone(),
        }
    }

    /// The line of sight of [`View::Chase`] for a vehicle in this state, from which a film makes a camera that moves smoothly.
    #[must_use]
    pub fn chase(&self, state: &VehicleState) -> Sight {
        chase(&self.world, &self.vehicle.middle(state), &state.attitude, self.vehicle.length())
    }

    /// The picture of a moment: red, green and blue in sRGB of each pixel, a byte each, row by row from the top and from
    /// left to right within a row. Points of path, trail and goal that are not finite are left out.
    ///
    /// # Errors
    /// Returns [`RenderError::Size`] if a side has no pixels or more than [`Size::MAX`], [`RenderError::Window`] if the
    /// window of [`View::Top`] is not a positive number, [`RenderError::Sight`] if the line of sight of [`View::From`] is
    /// vertical or not finite, and [`RenderError::Pose`] if the vehicle's position or attitude
    /// is not finite.
    pub fn picture(&self, view: View, size: Size, moment: &Moment<'_>) -> Result<Vec<u8>, RenderError> {
        self.drawn(view, size, moment, true)
    }

    /// The picture, with its ground coloured eight pixels at a time or one by one.
    fn drawn(
        &self,
        view: View,
        size: Size,
        moment: &Moment<'_>,
        together: bool,
    ) -> Result<Vec<u8>, RenderError> {
        size.check()?;
        if let View::Top { window: Some(side) } = view
            && !(side.is_finite() && side > 0.0)
        {
            return Err(RenderError::Window(side));
        }
        if let View::From(Sight { eye, at }) = view
            && !(eye.iter().chain(&at).all(|v| v.is_finite()) && hypot(eye[0] - at[0], eye[1] - at[1]) > 0.0)
        {
            return Err(RenderError::Sight);
        }
        let state = moment.state;
        if !state.position.iter().chain(state.attitude.coords.iter()).all(|v| v.is_finite()) {
            return Err(RenderError::Pose);
        }
        let samples = [size.width, size.height].map(|n| SAMPLES * n as usize);
        let (field, unit, length) = (&self.world.heightfield, self.world.scale, self.vehicle.length());
        let camera = match view {
            View::Chase => along(&self.chase(state), length, samples),
            View::From(sight) => along(&sight, length, samples),
            View::Top { window } => top_down(field, self.range, &state.position, window, samples),
        };
        let triangles = lock(&self.spare).pop().unwrap_or_default();
        let mut canvas = Canvas::reusing(triangles, camera);
        let beds = if moment.grains.is_empty() { &[][..] } else { &self.world.beds[..] };
        self.ground.draw(&mut canvas, field, beds);
        if !beds.is_empty() {
            grains::draw(&mut canvas, &self.world, moment.grains);
        }
        if matches!(camera.lens, Lens::Pinhole { .. }) {
            Ground::surround(&mut canvas, field, unit);
        }
        for body in self.obstacles.iter().filter(|b| !camera.misses(&b.centre, b.radius)) {
            for face in &body.faces {
                face.draw(&mut canvas);
            }
        }
        let vehicle = self.vehicle.faces(state, moment.turned, moment.colour);
        for face in &vehicle {
            face.draw(&mut canvas);
        }
        let pixel = match camera.lens {
            Lens::Parallel { scale } => Some(SAMPLES as f64 / scale),
            Lens::Pinhole { .. } => None,
        };
        let marks = Marks { field, unit, pixel };
        marks.beacon(&mut canvas, moment.goal);
        marks.path(&mut canvas, moment.path);
        marks.trail(&mut canvas, moment.trail, moment.colour);
        marks.ring(&mut canvas, moment.goal, moment.goal_radius);
        if let Some(pixel) = pixel.filter(|p| length < SMALL * p) {
            let nose = state.attitude * V3::x();
            // Above all that is there.
            let at = V3::new(state.position.x, state.position.y, camera.eye.z - 0.95);
            marks.arrow(&mut canvas, &at, atan2(nose.y, nose.x), SMALL * pixel, moment.colour);
        }
        let (centre, radius) = Vehicle::sphere(&vehicle);
        let drop = centre.z - self.range[0];
        let shadow = Shadow::of(centre, radius, drop, vehicle.iter().map(|f| &f.corners));
        let look = Look {
            texture: &self.texture,
            grain: &self.grain,
            unit: unit as f32,
            shadow: &shadow,
            change: moment.change,
        };
        let picture = look.develop(&canvas, SAMPLES, together);
        lock(&self.spare).push(canvas.into_triangles());
        Ok(picture)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vb_math::rng::Stream;
    use vb_sim::Gear;
    use vb_vehicle::VehicleSpec;
    use vb_world::{Heightfield, TerrainClass};

    #[test]
    fn ground_coloured_together_looks_like_ground_coloured_one_by_one() {
        let text = include_str!("../../../../tasks/vehicles/hmmwv.yaml");
        let model = VehicleModel::new(VehicleSpec::parse(text, "hmmwv").unwrap()).unwrap();
        let mut stream = Stream::new(7, &["hills"]);
        let heights = (0..65 * 65).map(|_| stream.uniform(0.0, 0.6)).collect();
        let world = World::uniform("w", Heightfield::new(65, 65, 1.0, heights), TerrainClass::Mud, 0.5);
        let painter = Painter::new(&Arc::new(world), &model);
        let state = VehicleState {
            time: 1.0,
            position: V3::new(-5.0, 2.0, 1.2),
            attitude: UnitQuaternion::from_axis_angle(&V3::z_axis(), 0.3),
            velocity_body: V3::zeros(),
            angular_velocity_body: V3::zeros(),
            wheels: Vec::new(),
            steering: 0.0,
            gear: Gear::Forward,
            engine_speed: 0.0,
        };
        // A rut of 10 cm about a line, a path and a trail over it.
        let change = |_: f64, y: f64| ((y - 2.0).abs() < 0.4).then_some(-0.1);
        let moment = Moment {
            state: &state,
            turned: &[],
            goal: [20.0, 5.0],
            goal_radius: 3.0,
            path: &[[-10.0, 0.0], [10.0, 4.0]],
            trail: &[[-15.0, 2.0, 0.5], [-5.0, 2.0, 0.5]],
            change: Some(&change),
            grains: &[],
            colour: None,
        };
        let size = Size { width: 203, height: 120 };
        for view in [View::Chase, View::Top { window: None }, View::Top { window: Some(20.0) }] {
            let [a, b] = [true, false].map(|together| painter.drawn(view, size, &moment, together).unwrap());
            let off = |most: u8| a.iter().zip(&b).filter(|(a, b)| a.abs_diff(**b) > most).count();
            let mean = a.iter().zip(&b).map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / a.len() as f64;
            if view == View::Chase {
                // Every second place is looked up, so the edge of a rut is a pixel wide, and the finest noise is smoother.
                assert!(mean < 2.0 && off(40) < a.len() / 200, "{mean}, {} far off", off(40));
            } else {
                // Rounding alone.
                assert!(mean < 0.5 && off(2) < a.len() / 100 && off(40) == 0, "{view:?}: {mean}, {}", off(2));
            }
        }
    }
}
