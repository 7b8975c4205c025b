//! The depth camera: a pinhole with square pixels, which measures depths along its axis by two views, so that the error
//! grows with the depth squared (Gallup et al., "Variable baseline/resolution stereo", CVPR 2008).

use super::{DT, Return, View};
use crate::V3;
use crate::frame::Frame;
use crate::mount::{self, Bodywork};
use crate::noise::{Seed, uniform_and_normal};
use crate::profile::{DepthModel, OBSTACLE, Recogniser, UNKNOWN};
use crate::rays::{Hit, Surface};
use vb_math::angle::radians;
use vb_math::rng::Stream;
use vb_sdk::{DepthImage, DepthInfo};
use vb_world::World;

#[derive(Clone, Debug)]
pub(crate) struct Depth {
    info: DepthInfo,
    /// Where the sensor is in the body frame.
    place: Frame,
    /// Samples from one image to the next.
    every: u64,
    /// Standard deviation of a depth over the depth squared, 1/m.
    error: f64,
    dropout: f64,
    recogniser: Recogniser,
    /// One draw for each pixel, whether or not it hits.
    depths: Stream,
    labels: Stream,
    /// Pixels in a unit of the tangent.
    focal: f64,
    /// For each pixel, in the order of an image, whether the vehicle itself is in its way.
    hidden: Vec<bool>,
    image: Option<DepthImage>,
}

impl Depth {
    pub(crate) fn new(model: &DepthModel, every: u64, body: &Bodywork, scale: f64, seed: &Seed) -> Self {
        let info = DepthInfo {
            period: every as f64 * DT,
            rows: model.rows,
            cols: model.cols,
            field_of_view: radians(model.field_of_view_deg),
            min_depth: model.min_depth_m * scale,
            max_depth: model.max_depth_m * scale,
            labels: model.labels,
            mount: body.mount(&model.mount, scale),
        };
        let place = mount::frame(&info.mount);
        let mut camera = Self {
            place,
            every,
            error: model.error_per_m / scale,
            dropout: model.dropout,
            recogniser: Recogniser::new(&model.confusions),
            depths: seed.stream("depth", "pixels"),
            labels: seed.stream("depth", "labels"),
            focal: 0.5 * f64::from(info.cols) / vb_math::tan(0.5 * info.field_of_view),
            hidden: Vec::new(),
            image: None,
            info,
        };
        for row in 0..info.rows {
            for col in 0..info.cols {
                let pixel = camera.pixel(row, col);
                let reach = info.max_depth * pixel.norm();
                camera.hidden.push(body.hides(&place.at, &(place.turn * pixel.normalize()), reach));
            }
        }
        camera
    }

    pub(crate) fn info(&self) -> &DepthInfo {
        &self.info
    }

    /// The place of a pixel in the sensor's frame at the depth 1 m.
    fn pixel(&self, row: u32, col: u32) -> V3 {
        let off = |count: u32, k: u32| (0.5 * f64::from(count) - (f64::from(k) + 0.5)) / self.focal;
        V3::new(1.0, off(self.info.cols, col), off(self.info.rows, row))
    }

    /// Takes an image at sample `k` if one is due, and tells `each` of what it has measured.
    pub(crate) fn sample(
        &mut self,
        k: u64,
        vehicle: &Frame,
        time: f64,
        view: View<'_>,
        mut each: impl FnMut(Return),
    ) {
        if !k.is_multiple_of(self.every) {
            return;
        }
        let (rows, cols) = (self.info.rows, self.info.cols);
        let count = rows as usize * cols as usize;
        let mut image = DepthImage {
            time,
            depths: vec![0.0; count],
            labels: if self.info.labels { vec![UNKNOWN; count] } else { Vec::new() },
        };
        let sensor = vehicle.then(&self.place);
        let turn = sensor.turn.to_rotation_matrix();
        let noisy = self.error > 0.0 || self.dropout > 0.0;
        for col in 0..cols {
            // The pixels of a column lie in the plane of the camera's up axis and any of them.
            let middle = self.pixel(0, col);
            let normal = (turn * V3::new(-middle.y, 1.0, 0.0)).normalize();
            let reach = self.info.max_depth * self.pixel(0, col).norm().max(self.pixel(rows - 1, col).norm());
            let mut fan = view.scene.fan(&sensor.at, &normal, &(turn * V3::x()), reach);
            // From below, which is the fastest.
            for row in (0..rows).rev() {
                let (u, n) = if noisy { uniform_and_normal(&mut self.depths) } else { (1.0, 0.0) };
                let chance = if self.info.labels { self.labels.unit() } else { 1.0 };
                let index = (row * cols + col) as usize;
                if self.hidden[index] || u < self.dropout {
                    continue;
                }
                let pixel = self.pixel(row, col);
                let length = pixel.norm();
                let direction = turn * (pixel / length);
                let Some(hit) = fan.cast(&direction, view.ruts) else { continue };
                let truth = hit.distance / length;
                let depth = truth + self.error * truth * truth * n;
                let measured = |d: f64| d >= self.info.min_depth && d <= self.info.max_depth;
                if !measured(truth) || !measured(depth) {
                    continue;
                }
                image.depths[index] = depth as f32;
                let label = self.info.labels.then(|| {
                    let at = sensor.at + direction * hit.distance;
                    self.recogniser.see(class(view.scene.world(), &at, &hit), chance)
                });
                if let Some(label) = label {
                    image.labels[index] = label;
                }
                each(Return {
                    at: self.place.point(&(pixel * depth)),
                    share: 1.0,
                    obstacle: hit.surface != Surface::Ground,
                    label,
                });
            }
        }
        self.image = Some(image);
    }

    /// The last image since the last call, if there is one.
    pub(crate) fn take(&mut self) -> Option<DepthImage> {
        self.image.take()
    }
}

/// The label of what was hit.
fn class(world: &World, at: &V3, hit: &Hit) -> u8 {
    match hit.surface {
        Surface::Ground => world.class_at(at.x, at.y).label(),
        Surface::Obstacle(_) => OBSTACLE,
    }
}
