//! Windows of datasets: what happened in some seconds, and on which ground.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use hybrid::{DT, Terrain};
use vb_dataset::{Dataset, Episode, Header};
use vb_sdk::{HeightMap, Vehicle};
use vb_sense::{PriorMaps, Profile, Seed};
use vb_world::{World, geometry};

use crate::TrainError;

/// Steps of a window: 3 s at full scale.
pub const STEPS: usize = 15;
/// How far windows begin from each other, s at full scale.
const SPACING: f64 = 0.3;
/// A vehicle that comes nearer to an obstacle than this, in lengths of its own, may touch it: obstacles are not in the model.
const CLEAR: f64 = 0.55;
/// The time in which a vehicle that stands hardly moves, s at full scale.
const STAND: f64 = 2.0;
/// The step that frames make may differ from that of planners by this fraction of it: the model takes the difference into account.
const OFF: f64 = 0.1;
/// A vehicle moves if it is faster than this, in wheelbases a second.
const MOVING: f32 = 0.12;
/// A vehicle that tilts so far tips over, rad.
const TIPS: f64 = 0.7;
/// Beyond this tilt the vehicle is overturned and the model ends, rad.
const TILT: f64 = 1.0;

/// How the frames of datasets become steps of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    hz: u32,
    /// Frames of a step.
    stride: usize,
    /// The time that a second at full scale is for the vehicle, s (Froude's rule).
    root: f64,
}

impl Timing {
    /// The steps of datasets of a vehicle with so many frames a second: as long as those that planners take, as nearly as may be.
    ///
    /// # Errors
    /// Returns what is wrong if no whole number of frames makes such a step.
    pub fn new(hz: u32, vehicle: &Vehicle) -> Result<Self, String> {
        let root = vehicle.scale.sqrt();
        let step = f64::from(DT) * root;
        let frames = |hz: u32| (step * f64::from(hz)).round().max(1.0);
        let fits = |hz: u32| (frames(hz) / f64::from(hz) - step).abs() <= OFF * step;
        if !fits(hz) {
            // Frames are whole milliseconds apart.
            let better = (1..=1000).find(|hz| 1000 % hz == 0 && fits(*hz) && frames(*hz) >= 2.0);
            return Err(format!(
                "with {hz} frames a second no whole number of frames makes the step of {step:.4} s that planners take with this \
                 vehicle: explore with --hz {}",
                better.unwrap_or(1000)
            ));
        }
        Ok(Self { hz, stride: frames(hz) as usize, root })
    }

    /// The time of a step, s.
    #[must_use]
    pub fn step(&self) -> f32 {
        (self.stride as f64 / f64::from(self.hz)) as f32
    }

    /// The frames of a time at full scale.
    fn frames(&self, seconds: f64) -> usize {
        (seconds * self.root * f64::from(self.hz)).round() as usize
    }
}

/// The steps of a dataset of a vehicle, or why nothing can be trained on it.
fn timing(header: &Header, vehicle: &Vehicle) -> Result<Timing, String> {
    if header.of_a_suite {
        return Err("its worlds are those of a suite: nothing may be trained on it".into());
    }
    if header.vehicle.name != vehicle.name {
        return Err(format!("it is of the vehicle {}, and not of {}", header.vehicle.name, vehicle.name));
    }
    if !header.layout.speed {
        return Err("it is no exploration".into());
    }
    Timing::new(header.hz, vehicle)
}

/// What a frame has of the state and the command.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    /// m.
    pub x: f32,
    /// m.
    pub y: f32,
    /// rad.
    pub yaw: f32,
    /// rad.
    pub roll: f32,
    /// rad.
    pub pitch: f32,
    /// m/s.
    pub speed: f32,
    /// m/s, to the left.
    pub side: f32,
    /// rad/s.
    pub turn: f32,
    /// Of the wheels.
    pub steering: f32,
    /// The wheels' slip speed, m/s ([`hybrid::slip`]).
    pub slip: f32,
    /// Commands: steering, and speed in m/s.
    pub command: [f32; 2],
}

/// The distance between two places, m.
fn apart(a: Point, b: Point) -> f32 {
    vb_math::hypot(f64::from(a.x - b.x), f64::from(a.y - b.y)) as f32
}

/// Three seconds of driving.
#[derive(Clone, Debug)]
pub struct Window {
    /// The place of its world in [`Data::places`].
    pub place: usize,
    /// The states at the ends of the steps, the start first.
    pub points: Vec<Point>,
    /// Whether the vehicle hardly moves although it is commanded to.
    pub stands: bool,
}

/// A moment of driving, and what comes of it.
#[derive(Clone, Debug)]
pub struct Moment {
    /// The state, as a window without steps.
    pub window: Window,
    /// Whether the vehicle comes to a stand within [`hybrid::SOON`] although it is commanded to drive.
    pub stuck: bool,
    /// Whether it tips over within that time.
    pub over: bool,
}

/// A world, with the ground as the model sees it.
pub struct PlaceOf {
    /// The content hash of the world.
    pub hash: String,
    /// `rigid`, `deformable` or `mixed`.
    pub kind: vb_world::Terrain,
    pub heights: HeightMap,
    /// The ground of this map under the vehicle.
    pub terrain: Terrain,
}

/// All windows of a vehicle.
pub struct Data {
    /// How frames have become steps.
    pub timing: Timing,
    pub places: Vec<PlaceOf>,
    /// The windows, world by world in no order that matters.
    pub windows: Vec<Window>,
    /// Moments in which the vehicle moves.
    pub moments: Vec<Moment>,
    /// The hashes of the datasets' frames.
    pub hashes: Vec<String>,
}

impl Data {
    #[must_use]
    pub fn new(timing: Timing) -> Self {
        Self { timing, places: Vec::new(), windows: Vec::new(), moments: Vec::new(), hashes: Vec::new() }
    }

    /// Reads datasets of exploration.
    ///
    /// # Errors
    /// Returns an error if there is none, if one can't be read or lacks what models are trained on, or if they differ in their frames
    /// a second.
    pub fn of(dirs: &[PathBuf], vehicle: &Vehicle) -> Result<Self, TrainError> {
        let mut data: Option<Self> = None;
        for dir in dirs {
            let dataset = Dataset::open(dir)?;
            let unfit = |why: String| TrainError::Unfit { dir: dir.clone(), why };
            let timing = timing(dataset.header(), vehicle).map_err(unfit)?;
            let data = data.get_or_insert_with(|| Self::new(timing));
            if data.timing != timing {
                return Err(unfit(format!(
                    "it has {} frames a second, and the first dataset {}",
                    timing.hz, data.timing.hz
                )));
            }
            data.add(&dataset, dir, vehicle)?;
        }
        data.ok_or_else(|| TrainError::Unfit { dir: PathBuf::from("--data"), why: "names no dataset".into() })
    }

    fn add(&mut self, dataset: &Dataset, dir: &Path, vehicle: &Vehicle) -> Result<(), TrainError> {
        let header = dataset.header();
        let unfit = |why: String| TrainError::Unfit { dir: dir.to_owned(), why };
        let suite = dataset.worlds()?;
        let mut known: BTreeMap<String, (usize, Arc<World>)> = BTreeMap::new();
        for episode in dataset.episodes() {
            let episode = episode?;
            let id = &episode.info.world;
            if !known.contains_key(id) {
                let world = suite.load_world(id).map_err(vb_dataset::DatasetError::from)?;
                let world = world.at_scale(header.scale);
                let seed = Seed { run: 0, task: String::new() };
                let maps = PriorMaps::new(&Profile::oracle(), &world, &seed);
                let heights = maps.elevation.ok_or_else(|| unfit(format!("{id} has no heights")))?;
                let terrain = Terrain::new(&heights, maps.semantics.as_ref(), vehicle)
                    .ok_or_else(|| unfit(format!("{id} is too small")))?;
                known.insert(id.clone(), (self.places.len(), Arc::new(world)));
                let (hash, kind) = (episode.info.world_hash.clone(), episode.info.terrain);
                self.places.push(PlaceOf { hash, kind, heights, terrain });
            }
            let (place, world) = &known[id];
            self.cut(dataset, &episode, *place, world, vehicle);
        }
        self.hashes.push(dataset.frames_hash()?);
        Ok(())
    }

    /// Cuts an episode into windows.
    fn cut(&mut self, dataset: &Dataset, episode: &Episode, place: usize, world: &World, vehicle: &Vehicle) {
        let view = episode.view(dataset.features());
        let outlines: Vec<_> = world.obstacles.iter().map(vb_world::Obstacle::footprint).collect();
        let mut points = Vec::with_capacity(episode.frames);
        // Whether a window may have the frame.
        let mut fit = Vec::with_capacity(episode.frames);
        for k in 0..episode.frames {
            let (s, action, speed) = (view.state(k), view.row("action", k), view.row("action.speed", k));
            let near = outlines.iter().any(|o| {
                let far = (o[0][0] - s[0]).abs().max((o[0][1] - s[1]).abs()) > 12.0 * world.scale;
                !far && geometry::point_to_polygon([s[0], s[1]], o) < CLEAR * vehicle.length
            });
            let upright = s[3].abs().max(s[4].abs()) < TILT;
            fit.push(!near && upright && s[14] > 0.0 && speed[0] > 0.0);
            points.push(Point {
                x: s[0] as f32,
                y: s[1] as f32,
                yaw: s[5] as f32,
                roll: s[3] as f32,
                pitch: s[4] as f32,
                speed: s[6] as f32,
                side: s[7] as f32,
                turn: s[11] as f32,
                steering: s[12] as f32,
                slip: hybrid::slip(view.row("observation.wheels", k).chunks(2).map(|w| w[0]), s[6], vehicle)
                    as f32,
                command: [action[0] as f32, speed[0] as f32],
            });
        }
        self.watch(&points, &fit, place, vehicle);
        let stride = self.timing.stride;
        for first in (0..points.len()).step_by(self.timing.frames(SPACING)) {
            let last = first + STEPS * stride;
            if last >= points.len() {
                break;
            }
            if !fit[first..=last].iter().all(|f| *f) {
                continue;
            }
            let own: Vec<Point> = (first..=last).step_by(stride).map(|k| points[k]).collect();
            let (a, b) = (own[0], own[STEPS]);
            let stands = apart(a, b) < 0.15 * vehicle.wheelbase as f32;
            self.windows.push(Window { place, points: own, stands });
        }
    }

    /// Notes the moments of an episode in which the vehicle moves, and what comes of them.
    fn watch(&mut self, points: &[Point], fit: &[bool], place: usize, vehicle: &Vehicle) {
        let [soon, stand, spacing] =
            [f64::from(hybrid::SOON), STAND, SPACING].map(|seconds| self.timing.frames(seconds));
        let wheelbase = vehicle.wheelbase as f32;
        let stands = |k: usize| {
            let (a, b) = (points[k], points[(k + stand).min(points.len() - 1)]);
            k + stand < points.len() && a.command[1] > 0.0 && apart(a, b) < 0.1 * wheelbase
        };
        let tips = |k: usize| f64::from(points[k].roll.abs().max(points[k].pitch.abs())) > TIPS;
        for k in (0..points.len()).step_by(spacing) {
            let end = (k + soon).min(points.len());
            // What comes must be known: to the end of the time, or the end of the episode by tipping over.
            let over = (k..end).any(tips);
            let known = over || end + stand < points.len();
            if !fit[k] || !known || points[k].speed < MOVING * wheelbase {
                continue;
            }
            let window = Window { place, points: vec![points[k]], stands: false };
            self.moments.push(Moment { window, stuck: (k..end).any(stands), over });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of_scale(scale: f64) -> Vehicle {
        Vehicle { scale, ..Vehicle::default() }
    }

    #[test]
    fn at_full_scale_two_frames_of_a_tenth_are_the_step_of_planners_to_the_bit() {
        let timing = Timing::new(10, &of_scale(1.0)).unwrap();
        assert_eq!((timing.stride, timing.step().to_bits()), (2, DT.to_bits()));
        let frames = [SPACING, STAND, f64::from(hybrid::SOON)].map(|s| timing.frames(s));
        assert_eq!(frames, [3, 20, 15]);
    }

    #[test]
    fn at_another_scale_times_go_with_its_root_and_a_rate_that_does_not_fit_names_one_that_does() {
        let car = of_scale(0.1);
        let timing = Timing::new(50, &car).unwrap();
        assert_eq!(timing.stride, 3);
        // 2 s at full scale are 0.632 s, 31.6 frames of 0.02 s.
        assert_eq!(timing.frames(STAND), 32);
        let e = Timing::new(10, &car).unwrap_err();
        assert!(e.contains("0.0632 s") && e.ends_with("--hz 50"), "{e}");
    }
}
