//! What a planner perceives in a trial.

use crate::error::SenseError;
use crate::frame::Frame;
use crate::mount::Bodywork;
use crate::noise::Seed;
use crate::profile::{Profile, ProfileData};
use crate::rays::{Ruts, Scene};
use crate::sensors::depth::Depth;
use crate::sensors::gnss::Gnss;
use crate::sensors::imu::Imu;
use crate::sensors::lidar::Lidar;
use crate::sensors::local_map::Mapper;
use crate::sensors::pose::Estimator;
use crate::sensors::wheels::Wheels;
use crate::sensors::{SAMPLE_RATE, View};
use std::cell::LazyCell;
use std::collections::BTreeMap;
use std::sync::Arc;
use vb_sdk::metadata::{Need, Sensor, is_rate};
use vb_sdk::{DepthImage, DepthInfo, GnssFix, ImuSample, LidarInfo, LidarScan, LocalMap, Pose, Wheel};
use vb_sim::VehicleState;
use vb_vehicle::VehicleSpec;

#[derive(Clone, Copy)]
pub struct Truth<'a> {
    pub state: &'a VehicleState,
    /// The ruts on soft soil, from a [`vb_sim::Simulation`]; `None` if there are none.
    pub ruts: Option<&'a dyn Ruts>,
}

/// What the sensors have measured since the last reading, as an observation has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Readings {
    /// The estimate of the vehicle's state.
    pub pose: Option<Pose>,
    /// The wheels, from front to back, left before right; empty if there is no new reading.
    pub wheels: Vec<Wheel>,
    /// The measurements of the inertial measurement unit, oldest first.
    pub imu: Vec<ImuSample>,
    /// The last GNSS position.
    pub gnss: Option<GnssFix>,
    /// The last turn of the lidar.
    pub lidar: Option<LidarScan>,
    /// The last image of the depth camera.
    pub depth: Option<DepthImage>,
    pub local_map: Option<LocalMap>,
}

/// A sensor that scans the surroundings, and whom for: one of the planner's and one of the map's are two if they have
/// different rates, so that what the planner asks for doesn't change the map.
#[derive(Clone)]
struct Scanner<S> {
    sensor: S,
    for_planner: bool,
    for_map: bool,
}

/// The sensors of a vehicle in a trial.
///
/// Only what the planner asks for is computed, and it costs nothing else: with exact pose and wheels alone,
/// [`Perception::sample`] returns at once.
#[derive(Clone)]
pub struct Perception {
    scene: Arc<Scene>,
    idle: bool,
    /// Samples so far.
    samples: u64,
    before: Option<VehicleState>,
    /// Present for the planner or for the map.
    pose: Option<Estimator>,
    tells_pose: bool,
    wheels: Option<Wheels>,
    imu: Option<Imu>,
    gnss: Option<Gnss>,
    lidars: Vec<Scanner<Lidar>>,
    depths: Vec<Scanner<Depth>>,
    map: Option<Mapper>,
}

/// What a profile offers of a sensor.
fn offered(p: &ProfileData, sensor: Sensor) -> Option<f64> {
    match sensor {
        Sensor::Pose => p.pose.as_ref().map(|_| SAMPLE_RATE),
        Sensor::WheelOdometry => p.wheel_odometry.as_ref().map(|_| SAMPLE_RATE),
        Sensor::Imu => p.imu.as_ref().map(|m| m.rate_hz),
        Sensor::Gnss => p.gnss.as_ref().map(|m| m.rate_hz),
        Sensor::Lidar => p.lidar.as_ref().map(|m| m.rate_hz),
        Sensor::Depth => p.depth.as_ref().map(|m| m.rate_hz),
        Sensor::LocalMap => p.local_map.as_ref().map(|m| m.rate_hz),
    }
}

/// The number of samples from one reading to the next at a rate, Hz.
fn period(rate: f64) -> u64 {
    (SAMPLE_RATE / rate).round() as u64
}

/// The number of samples between readings that a need asks for; `None` if it leaves that open.
fn asked(profile: &Profile, need: &Need) -> Result<Option<u64>, SenseError> {
    let p = profile.data();
    let Some(most) = offered(p, need.sensor) else {
        let there = Sensor::ALL.iter().filter(|s| offered(p, **s).is_some()).map(|s| s.name());
        let there = there.collect::<Vec<_>>().join(", ");
        let offered = if there.is_empty() { "nothing".to_owned() } else { there };
        return Err(SenseError::NotOffered { profile: p.name.clone(), sensor: need.sensor, offered });
    };
    match need.rate {
        None => Ok(None),
        Some(rate) if rate <= most && is_rate(rate) => Ok(Some(period(rate))),
        Some(rate) => {
            let usual = [100.0, 50.0, 25.0, 20.0, 10.0, 5.0, 4.0, 2.0, 1.0];
            let mut possible: Vec<f64> = usual.into_iter().filter(|r| *r <= most).collect();
            if !possible.contains(&most) {
                possible.insert(0, most);
            }
            let possible = possible.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
            Err(SenseError::Rate { profile: p.name.clone(), sensor: need.sensor, rate, possible })
        }
    }
}

/// Checks whether a profile offers what a planner needs, before any world is loaded.
///
/// # Errors
/// Returns [`SenseError::NotOffered`] and [`SenseError::Rate`] as [`Perception::new`] does.
pub fn check_needs(profile: &Profile, needs: &[Need]) -> Result<(), SenseError> {
    let needs = if needs.is_empty() { Need::DEFAULT } else { needs };
    needs.iter().try_for_each(|need| asked(profile, need).map(drop))
}

impl Perception {
    /// The sensors of a vehicle in a scene, of which the planner gets those that it needs. A planner that declares no need
    /// gets [`Need::DEFAULT`].
    ///
    /// # Errors
    /// Returns [`SenseError::NotOffered`] and [`SenseError::Rate`] for a need that the profile can't meet.
    pub fn new(
        profile: &Profile,
        needs: &[Need],
        scene: &Arc<Scene>,
        vehicle: &VehicleSpec,
        seed: &Seed,
    ) -> Result<Self, SenseError> {
        let p = profile.data();
        let scale = scene.world().scale;
        let needs = if needs.is_empty() { Need::DEFAULT } else { needs };
        let mut every = BTreeMap::new();
        for need in needs {
            every.insert(need.sensor, asked(profile, need)?);
        }
        // For each sensor that is asked for, the samples between readings; with the profile's rate if that is left open.
        let open = |sensor: Sensor| every.get(&sensor).copied();
        let fixed = |sensor: Sensor, rate: f64| open(sensor).map(|n| n.unwrap_or(period(rate)));
        let with_map = open(Sensor::LocalMap).is_some();
        // Made for what looks around only.
        let body = LazyCell::new(|| Bodywork::of(vehicle));
        let scanners = |own: Option<u64>, rate: f64| -> Vec<(u64, bool, bool)> {
            let map = with_map.then_some(period(rate));
            let mut all: Vec<(u64, bool, bool)> = own.map(|n| (n, true, map == own)).into_iter().collect();
            all.extend(map.filter(|_| map != own).map(|n| (n, false, true)));
            all
        };
        let mut lidars = Vec::new();
        if let Some(model) = &p.lidar {
            for (n, for_planner, for_map) in scanners(fixed(Sensor::Lidar, model.rate_hz), model.rate_hz) {
                let sensor = Lidar::new(model, n, &body, scale, seed);
                lidars.push(Scanner { sensor, for_planner, for_map });
            }
        }
        let mut depths = Vec::new();
        if let Some(model) = &p.depth {
            for (n, for_planner, for_map) in scanners(fixed(Sensor::Depth, model.rate_hz), model.rate_hz) {
                let sensor = Depth::new(model, n, &body, scale, seed);
                depths.push(Scanner { sensor, for_planner, for_map });
            }
        }
        let tells_pose = open(Sensor::Pose).is_some();
        let pose = p.pose.as_ref().filter(|_| tells_pose || with_map);
        let pose = pose.map(|m| Estimator::new(m, open(Sensor::Pose).flatten(), scale, seed));
        let wheels = open(Sensor::WheelOdometry).zip(p.wheel_odometry.as_ref());
        let wheels = wheels.map(|(n, m)| Wheels::new(m, n, scale, seed));
        let imu = p.imu.as_ref().and_then(|m| Some(Imu::new(m, fixed(Sensor::Imu, m.rate_hz)?, seed)));
        let gnss =
            p.gnss.as_ref().and_then(|m| Some(Gnss::new(m, fixed(Sensor::Gnss, m.rate_hz)?, scale, seed)));
        let map = p.local_map.as_ref();
        let map = map.and_then(|m| Some(Mapper::new(m, fixed(Sensor::LocalMap, m.rate_hz)?, scale)));
        let idle = pose.as_ref().is_none_or(Estimator::is_idle)
            && wheels.as_ref().is_none_or(Wheels::is_idle)
            && imu.is_none()
            && gnss.is_none()
            && lidars.is_empty()
            && depths.is_empty();
        Ok(Self {
            scene: scene.clone(),
            idle,
            samples: 0,
            before: None,
            pose,
            tells_pose,
            wheels,
            imu,
            gnss,
            lidars,
            depths,
            map,
        })
    }

    /// Tells whether samples change nothing, so that the caller need not even make the truth for them.
    #[must_use]
    pub fn is_idle(&self) -> bool {
        self.idle
    }

    /// The lidar, if the planner asks for it.
    #[must_use]
    pub fn lidar_info(&self) -> Option<LidarInfo> {
        self.lidars.iter().find(|s| s.for_planner).map(|s| *s.sensor.info())
    }

    /// The depth camera, if the planner asks for it.
    #[must_use]
    pub fn depth_info(&self) -> Option<DepthInfo> {
        self.depths.iter().find(|s| s.for_planner).map(|s| *s.sensor.info())
    }

    /// Takes the truth at a sample: at the start, and then every 10 ms of simulated time.
    pub fn sample(&mut self, truth: Truth<'_>) {
        if self.idle {
            return;
        }
        let (k, now) = (self.samples, truth.state);
        self.samples += 1;
        let before = self.before.take();
        let last = before.as_ref().unwrap_or(now);
        if let Some(pose) = &mut self.pose {
            pose.sample(k, last, now);
        }
        if let Some(wheels) = &mut self.wheels {
            wheels.sample(k, last, now);
        }
        if let Some(imu) = self.imu.as_mut().filter(|_| k > 0) {
            imu.sample(last, now);
        }
        if let Some(gnss) = &mut self.gnss {
            gnss.sample(k, now);
        }
        self.scan(k, (&Frame::of(last), &Frame::of(now)), truth);
        self.before = Some(now.clone());
    }

    /// What looks at the surroundings.
    fn scan(&mut self, k: u64, (last, now): (&Frame, &Frame), truth: Truth<'_>) {
        let Self { scene, pose, map, lidars, depths, .. } = self;
        let ruts = truth.ruts.filter(|_| !scene.world().is_rigid());
        let view = View { scene, ruts };
        let time = truth.state.time;
        let mut map = map.as_mut().zip(pose.as_ref());
        if let Some((map, pose)) = &mut map {
            map.move_to(&pose.frame(1.0).at);
        }
        for Scanner { sensor, for_map, .. } in lidars {
            let mut map = map.as_mut().filter(|_| *for_map);
            // The estimate at the time of a column, of which all beams are measured at once.
            let mut column = None;
            sensor.sample(k, (last, now), time, view, |hit| {
                if let Some((map, pose)) = &mut map {
                    let vehicle = match column {
                        Some((share, frame)) if share == hit.share => frame,
                        _ => pose.frame(hit.share),
                    };
                    column = Some((hit.share, vehicle));
                    map.add(&hit, &vehicle);
                }
            });
        }
        for Scanner { sensor, for_map, .. } in depths {
            let mut map = map.as_mut().filter(|_| *for_map);
            let vehicle = map.as_ref().map_or(*now, |(_, pose)| pose.frame(1.0));
            sensor.sample(k, now, time, view, |hit| {
                if let Some((map, _)) = &mut map {
                    map.add(&hit, &vehicle);
                }
            });
        }
        if let Some((map, _)) = &mut map {
            map.finish(k, time);
        }
    }

    /// What was measured since the last reading, at a step of the planner. `state` is the vehicle's state now, for what is
    /// exact and has no rate.
    pub fn read(&mut self, state: &VehicleState) -> Readings {
        let tells_pose = self.tells_pose;
        Readings {
            pose: self.pose.as_mut().filter(|_| tells_pose).and_then(|p| p.read(state)),
            wheels: self.wheels.as_mut().map(|w| w.read(state)).unwrap_or_default(),
            imu: self.imu.as_mut().map(Imu::take).unwrap_or_default(),
            gnss: self.gnss.as_mut().and_then(Gnss::take),
            lidar: self.lidars.iter_mut().find(|s| s.for_planner).and_then(|s| s.sensor.take()),
            depth: self.depths.iter_mut().find(|s| s.for_planner).and_then(|s| s.sensor.take()),
            local_map: self.map.as_mut().and_then(Mapper::take),
        }
    }
}
