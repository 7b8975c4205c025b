//! The drive of a bag, cut into windows.

use std::fmt::Write as _;

use vb_math::angle::wrap;

use crate::BagError;
use crate::topic::{Bag, Entry, Series};

/// Interval of the rows, s.
const INTERVAL: f64 = 0.05;
/// A window has no pause in a topic that is longer than this, s: odometry and wheel speeds come at 10 Hz or more, and the drive controllers of
/// ros2_controllers stop after 0.5 s without a command (`cmd_vel_timeout`).
const GAP: f64 = 0.5;
/// Durations that windows may have, s.
const DURATIONS: std::ops::RangeInclusive<f64> = 0.2..=600.0;
/// Maximum number of rows.
const ROWS: usize = 10_000_000;

/// The topics of a drive, and the duration of its windows.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// Topic of the poses (`nav_msgs/msg/Odometry`); the only one of the bag if absent.
    pub odometry: Option<String>,
    /// Topic of the wheel speeds (`sensor_msgs/msg/JointState`) or of the velocity commands (`geometry_msgs/msg/Twist`, `TwistStamped`). If
    /// absent, the only one with wheel speeds, or else the only one with commands.
    pub speeds: Option<String>,
    /// Topic of an inertial sensor (`sensor_msgs/msg/Imu`, z axis up), from whose yaw rate the heading within a window follows. If absent, the
    /// heading is that of the odometry.
    pub imu: Option<String>,
    /// Duration of a window, s.
    pub window: f64,
}

/// The wheels of a vehicle whose commands were recorded.
#[derive(Clone, Copy, Debug)]
pub struct Wheels {
    /// Radius, m.
    pub radius: f64,
    /// Distance between the left and the right wheels, m.
    pub track: f64,
}

/// A row of a window.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Row {
    /// Since the first message of the drive, s.
    time: f64,
    /// Speeds of the left and the right wheels, rad/s.
    sides: [f64; 2],
    /// x and y, m, and yaw, rad.
    pose: [f64; 3],
}

/// A drive: windows with wheel speeds and poses.
#[derive(Clone, Debug)]
pub struct Drive {
    /// Topic of the poses.
    pub odometry: String,
    /// Topic of the wheel speeds or commands.
    pub speeds: String,
    /// Whether the wheel speeds follow from commands.
    pub is_commanded: bool,
    /// Topic of the inertial sensor that gave the heading, if any.
    pub imu: Option<String>,
    /// Time between the first and the last moment at which all topics have messages, s.
    pub duration: f64,
    /// Number of pauses of a topic that are longer than half a second; no window contains one.
    pub gaps: usize,
    windows: Vec<Vec<Row>>,
}

/// A topic over time.
struct Track<const N: usize> {
    /// s, increasing.
    times: Vec<f64>,
    values: Vec<[f64; N]>,
}

impl Bag {
    /// The drive of a selection. `wheels` are used for commands only: left and right wheels that roll without slip turn at (v ∓ ω b/2)/r at the
    /// speed v and the yaw rate ω, with the radius r and the track b.
    ///
    /// # Errors
    /// Returns an error if a topic is missing or ambiguous, or if no window lies between the gaps.
    pub fn drive(&self, selection: &Selection, wheels: Wheels) -> Result<Drive, BagError> {
        if !DURATIONS.contains(&selection.window) {
            let (least, most) = (DURATIONS.start(), DURATIONS.end());
            return Err(BagError::Windows(format!(
                "window {} s: must lie in {least} to {most} s",
                selection.window
            )));
        }
        let (odometry, poses) = self.select(
            "odometry",
            selection.odometry.as_deref(),
            &["nav_msgs/msg/Odometry"],
            |s| match s {
                Series::Pose(all) => Some(all),
                _ => None,
            },
        )?;
        let (speeds, is_commanded, sides) = self.speeds(selection.speeds.as_deref())?;
        let imu = match &selection.imu {
            None => None,
            Some(topic) => Some(self.select("imu", Some(topic), &["sensor_msgs/msg/Imu"], |s| match s {
                Series::Rate(all) => Some(all),
                _ => None,
            })?),
        };
        let rates = imu.map_or(&[][..], |(_, all)| all);
        let stamped = is_stamped(poses) && is_stamped(sides) && is_stamped(rates);
        let first = |all: i64, time: i64| all.min(time);
        let start = times(poses, stamped)
            .chain(times(sides, stamped))
            .chain(times(rates, stamped))
            .fold(i64::MAX, first);
        let mut poses = Track::new(poses, stamped, start);
        // The heading goes on over ±π.
        for k in 1..poses.values.len() {
            let before = poses.values[k - 1][2];
            poses.values[k][2] = before + wrap(poses.values[k][2] - before);
        }
        let mut sides = Track::new(sides, stamped, start);
        if is_commanded {
            for value in &mut sides.values {
                let [v, turn] = [value[0], 0.5 * value[1] * wheels.track];
                *value = [(v - turn) / wheels.radius, (v + turn) / wheels.radius];
            }
        }
        let headings = (!rates.is_empty()).then(|| Track::new(rates, stamped, start).integral());
        let parts = Parts { poses, sides, headings, is_commanded };
        let (duration, gaps, windows) = parts.windows(selection.window)?;
        if windows.is_empty() {
            return Err(BagError::Windows(format!(
                "no window of {} s: {odometry} and {speeds} overlap for {duration:.1} s, with {gaps} pauses longer than {GAP} s",
                selection.window
            )));
        }
        Ok(Drive {
            odometry: odometry.to_owned(),
            speeds: speeds.to_owned(),
            is_commanded,
            imu: imu.map(|(topic, _)| topic.to_owned()),
            duration,
            gaps,
            windows,
        })
    }

    /// The topic with wheel speeds, or else with commands.
    fn speeds(&self, wanted: Option<&str>) -> Result<(&str, bool, &[Entry<2>]), BagError> {
        fn joints(series: &Series) -> Option<&Vec<Entry<2>>> {
            match series {
                Series::Joints(all) => Some(all),
                _ => None,
            }
        }
        fn commands(series: &Series) -> Option<&Vec<Entry<2>>> {
            match series {
                Series::Commands(all) => Some(all),
                _ => None,
            }
        }
        let has_joints = match wanted {
            Some(topic) => self.topics.get(topic).is_some_and(|series| joints(series).is_some()),
            None => self.topics.values().any(|series| joints(series).is_some()),
        };
        if has_joints {
            let (topic, all) = self.select("speeds", wanted, &["sensor_msgs/msg/JointState"], joints)?;
            return Ok((topic, false, all));
        }
        let kinds = [
            "sensor_msgs/msg/JointState with velocities of joints named left and right",
            "geometry_msgs/msg/Twist",
            "TwistStamped",
        ];
        let (topic, all) = self.select("speeds", wanted, &kinds, commands)?;
        Ok((topic, true, all))
    }

    /// The topic with this name, or the only one of its kind.
    fn select<T>(
        &self,
        option: &str,
        wanted: Option<&str>,
        kinds: &[&str],
        of: impl Fn(&Series) -> Option<&T>,
    ) -> Result<(&str, &T), BagError> {
        let found: Vec<(&str, &T)> =
            self.topics.iter().filter_map(|(name, series)| Some((name.as_str(), of(series)?))).collect();
        let names = || found.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
        let kinds = kinds.join(" or ");
        match (wanted, &found[..]) {
            (None, [one]) => Ok(*one),
            (_, []) => Err(BagError::Topic(format!("the bag has no messages of {kinds}"))),
            (None, _) => Err(BagError::Topic(format!(
                "the bag has several topics of {kinds}: {}; choose one with --{option}",
                names()
            ))),
            (Some(topic), _) => found.iter().copied().find(|(name, _)| *name == topic).ok_or_else(|| {
                BagError::Topic(format!(
                    "--{option} {topic}: no topic of {kinds} with this name; the bag has {}",
                    names()
                ))
            }),
        }
    }
}

fn is_stamped<const N: usize>(entries: &[Entry<N>]) -> bool {
    entries.iter().all(|entry| entry.stamp.is_some())
}

/// Times of messages, ns: of their headers if all topics have them, else those at which they were recorded.
fn times<const N: usize>(entries: &[Entry<N>], stamped: bool) -> impl Iterator<Item = i64> {
    entries.iter().map(move |entry| entry.stamp.filter(|_| stamped).unwrap_or(entry.recorded))
}

impl<const N: usize> Track<N> {
    /// In the order of time; of several messages with the same time, the last.
    fn new(entries: &[Entry<N>], stamped: bool, start: i64) -> Self {
        let mut all: Vec<(i64, [f64; N])> =
            times(entries, stamped).zip(entries.iter().map(|e| e.values)).collect();
        all.sort_by_key(|(time, _)| *time);
        let mut track = Self { times: Vec::with_capacity(all.len()), values: Vec::with_capacity(all.len()) };
        for (time, value) in all {
            let time = (i128::from(time) - i128::from(start)) as f64 * 1e-9;
            if track.times.last() == Some(&time) {
                track.values.pop();
                track.times.pop();
            }
            track.times.push(time);
            track.values.push(value);
        }
        track
    }

    fn ends(&self) -> [f64; 2] {
        match (self.times.first(), self.times.last()) {
            (Some(first), Some(last)) => [*first, *last],
            _ => [f64::INFINITY, f64::NEG_INFINITY],
        }
    }

    /// Pauses longer than [`GAP`].
    fn gaps(&self) -> impl Iterator<Item = [f64; 2]> {
        self.times.windows(2).map(|pair| [pair[0], pair[1]]).filter(|[from, to]| to - from > GAP)
    }

    /// The values at a time between the ends: linear between messages, or those of the last message.
    fn at(&self, time: f64, holds: bool) -> [f64; N] {
        let next = self.times.partition_point(|t| *t <= time);
        let before = next.saturating_sub(1);
        let (a, b) = (self.values[before], self.values[next.min(self.values.len() - 1)]);
        let (from, to) = (self.times[before], self.times[next.min(self.times.len() - 1)]);
        if holds || to <= from {
            return a;
        }
        let part = (time - from) / (to - from);
        std::array::from_fn(|k| a[k] + part * (b[k] - a[k]))
    }

    /// The integral over time from the first message, by the trapezoidal rule.
    fn integral(self) -> Self {
        let mut sum = [0.0; N];
        let mut values = Vec::with_capacity(self.values.len());
        for (k, now) in self.values.iter().enumerate() {
            if let Some(before) = k.checked_sub(1) {
                let step = self.times[k] - self.times[before];
                sum = std::array::from_fn(|i| sum[i] + 0.5 * step * (self.values[before][i] + now[i]));
            }
            values.push(sum);
        }
        Self { values, ..self }
    }
}

/// The measured series from which windows are cut.
struct Parts {
    poses: Track<3>,
    sides: Track<2>,
    /// Heading by the inertial sensor since its first message, rad.
    headings: Option<Track<1>>,
    is_commanded: bool,
}

impl Parts {
    /// The duration in which all topics have messages, s, the number of gaps in it, and the windows between them.
    fn windows(&self, window: f64) -> Result<(f64, usize, Vec<Vec<Row>>), BagError> {
        let ends =
            [Some(self.poses.ends()), Some(self.sides.ends()), self.headings.as_ref().map(Track::ends)];
        let [start, end] = ends
            .into_iter()
            .flatten()
            .fold([f64::NEG_INFINITY, f64::INFINITY], |[from, to], [first, last]| {
                [from.max(first), to.min(last)]
            });
        let duration = (end - start).max(0.0);
        let mut gaps: Vec<[f64; 2]> = self.poses.gaps().chain(self.sides.gaps()).collect();
        gaps.extend(self.headings.iter().flat_map(Track::gaps));
        gaps.retain(|[from, to]| *from < end && *to > start);
        gaps.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let intervals = (window / INTERVAL).ceil().max(1.0) as usize;
        if duration / window * (intervals + 1) as f64 > ROWS as f64 {
            return Err(BagError::Windows(format!(
                "the drive lasts {duration:.0} s, which is too long; cut the bag into parts"
            )));
        }
        let mut windows = Vec::new();
        let mut from = start;
        // The end of the gaps that began before the window ends.
        let mut clear = start;
        let mut ahead = gaps.iter().peekable();
        while from + window <= end + 1e-9 {
            let to = from + window;
            while let Some(gap) = ahead.next_if(|gap| gap[0] < to) {
                clear = clear.max(gap[1]);
            }
            if clear > from {
                from = clear;
                continue;
            }
            windows.push(
                (0..=intervals)
                    .map(|k| self.row(from, from + window * k as f64 / intervals as f64))
                    .collect(),
            );
            from = to;
        }
        Ok((duration, gaps.len(), windows))
    }

    /// The row at a time in the window that begins at `from`, s.
    fn row(&self, from: f64, time: f64) -> Row {
        let mut pose = self.poses.at(time, false);
        if let Some(headings) = &self.headings {
            pose[2] =
                self.poses.at(from, false)[2] + headings.at(time, false)[0] - headings.at(from, false)[0];
        }
        pose[2] = wrap(pose[2]);
        Row { time, sides: self.sides.at(time, self.is_commanded), pose }
    }
}

impl Drive {
    /// Number of windows.
    #[must_use]
    pub fn windows(&self) -> usize {
        self.windows.len()
    }

    /// The recording as CSV with the columns window, time (s), left and right (rad/s), x and y (m) and yaw (rad).
    #[must_use]
    pub fn csv(&self) -> String {
        let mut out = String::from("window,time,left,right,x,y,yaw\n");
        for (k, rows) in self.windows.iter().enumerate() {
            for Row { time, sides: [left, right], pose: [x, y, yaw] } in rows {
                let _ = writeln!(out, "w{:04},{time:.4},{left:.6},{right:.6},{x:.6},{y:.6},{yaw:.6}", k + 1);
            }
        }
        out
    }
}
