//! Recordings of real vehicles with skid steering: their wheels' speeds are replayed in simulation, and what the vehicle does is
//! compared with what the recording says, over the friction of the ground.

mod table;

use crate::bench::Bench;
use crate::error::ValidateError;
use crate::event::{Event, LineKind, Outcome, Place, Plot, Series, Vehicles};
use crate::grounds::flat;
use crate::pace::COASTING;
use crate::report::Report;
use crate::result::EventResult;
use std::collections::BTreeMap;
use std::path::Path;
use vb_files::{DocumentError, Flaw};
use vb_math::angle::{degrees, wrap};
use vb_math::{hypot, sin_cos};
use vb_sim::{SimError, Simulation, SoilSet};
use vb_vehicle::VehicleSpec;
use vb_world::Pose2;

/// The largest file that is read, bytes.
const LARGEST: u64 = 256 << 20;
/// Time for which the vehicle runs at a window's first speeds before it, s: a recording says nothing of what came before.
const RUN_IN: f64 = 1.0;
/// Interval at which the speeds of the wheels are set, s.
const SET: f64 = 0.01;
/// A window is steady if the standard deviations of the speeds lie below this part of their mean and this speed, rad/s.
const STEADY: [f64; 2] = [0.15, 0.05];
/// Kinematic yaw of a window between which it is a turn, rad: well above the noise of poses, and below half a revolution.
const TURN: [f64; 2] = [0.4, 2.8];
/// Kinematic yaw rate (rad/s) below which a window is straight, and the speed (m/s) that it then exceeds.
const STRAIGHT: [f64; 2] = [0.05, 0.3];

/// A moment of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sample {
    /// s.
    time: f64,
    /// Of the left and the right wheels, rad/s, positive forwards.
    sides: [f64; 2],
    /// East and north, m, and heading, rad, if the row has them.
    pose: Option<[f64; 3]>,
}

/// A part of a recording without interruption.
#[derive(Clone, Debug, PartialEq)]
struct Window {
    name: String,
    samples: Vec<Sample>,
}

/// What a vehicle did in a window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Motion {
    /// Change of heading, rad.
    yaw: f64,
    /// Distance between the first and the last place, m.
    distance: f64,
    /// Speed at right angles to the mean heading, m/s, positive to the left.
    lateral: f64,
}

impl Motion {
    /// Between two poses (x, y, m; yaw, rad) that lie `seconds` apart.
    fn between(from: [f64; 3], to: [f64; 3], seconds: f64) -> Self {
        let yaw = wrap(to[2] - from[2]);
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let (sin, cos) = sin_cos(from[2] + 0.5 * yaw);
        Self { yaw, distance: hypot(dx, dy), lateral: (dy * cos - dx * sin) / seconds }
    }
}

/// Windows of a recorded drive: speeds of the wheels and poses.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    name: String,
    windows: Vec<Window>,
    /// Windows that were left out, since a value is missing in them.
    incomplete: usize,
}

impl Recording {
    /// Reads a recording, a CSV file in one of two formats:
    ///
    /// - the columns window, time (s), left and right (rad/s), x and y (m) and yaw (rad) in any order. Rows of a window follow each
    ///   other; the first and the last have a pose.
    /// - a table of DRIVE (Baril et al. 2023, arXiv:2309.10718), a window in each row, with the columns `left_wheel_vel_K` and
    ///   `right_wheel_vel_K` (rad/s) of sample K at 20 Hz, and the poses `init_icp_…` at the first sample and `gt_icp_…` a sample
    ///   after the last. Windows with missing values are left out.
    ///
    /// Other columns are ignored.
    ///
    /// # Errors
    /// Returns an error that names line and column of what can't be read.
    pub fn load(path: &Path) -> Result<Self, DocumentError> {
        let file = path.display().to_string();
        let text = vb_files::read_text(path, LARGEST)
            .map_err(|e| Flaw::new("", e.to_string()).of("recording", file.clone()))?;
        Self::parse(&text, &file)
    }

    /// Reads the text of a recording.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn parse(text: &str, file: &str) -> Result<Self, DocumentError> {
        let (windows, incomplete) = table::read(text).map_err(|flaw| flaw.of("recording", file))?;
        let name = Path::new(file).file_stem().map_or(file.to_owned(), |s| s.to_string_lossy().into_owned());
        Ok(Self { name, windows, incomplete })
    }
}

impl Window {
    fn seconds(&self) -> f64 {
        self.samples[self.samples.len() - 1].time - self.samples[0].time
    }

    /// What the recording says.
    fn measured(&self) -> Motion {
        let pose = |s: &Sample| s.pose.unwrap_or_default();
        Motion::between(pose(&self.samples[0]), pose(&self.samples[self.samples.len() - 1]), self.seconds())
    }

    /// Speeds of the sides at a time since the beginning, linear between the rows, rad/s.
    fn sides(&self, time: f64) -> [f64; 2] {
        let t = self.samples[0].time + time;
        let next = self.samples.partition_point(|s| s.time <= t).clamp(1, self.samples.len() - 1);
        let (a, b) = (&self.samples[next - 1], &self.samples[next]);
        let part = ((t - a.time) / (b.time - a.time)).clamp(0.0, 1.0);
        [0, 1].map(|i| a.sides[i] + part * (b.sides[i] - a.sides[i]))
    }

    /// Mean speed and yaw rate of wheels of this radius and track (m) that roll without slip, m/s and rad/s, and whether the speeds
    /// are steady.
    fn kinematic(&self, radius: f64, track: f64) -> (f64, f64, bool) {
        let count = self.samples.len() as f64;
        let mean = |i: usize| self.samples.iter().map(|s| s.sides[i]).sum::<f64>() / count;
        let steady = |i: usize| {
            let size = self.samples.iter().map(|s| s.sides[i].abs()).sum::<f64>() / count;
            let variance =
                self.samples.iter().map(|s| (s.sides[i] - mean(i)) * (s.sides[i] - mean(i))).sum::<f64>();
            (variance / count).sqrt() < STEADY[0] * size + STEADY[1]
        };
        let (left, right) = (mean(0), mean(1));
        (0.5 * radius * (left + right), radius * (right - left) / track, steady(0) && steady(1))
    }

    /// What the vehicle does in simulation, from where it stands.
    fn simulated(&self, standing: &Simulation, step: f64) -> Result<Motion, SimError> {
        let mut sim = standing.clone();
        let steps = ((SET / step).round() as u64).max(1);
        let pose = |sim: &Simulation| {
            let s = sim.state();
            [s.position.x, s.position.y, s.roll_pitch_yaw().2]
        };
        let mut drive = |from: f64, to: f64| -> Result<[f64; 3], SimError> {
            let count = ((to - from) / (step * steps as f64)).round() as u64;
            for k in 0..count {
                let time = from + (k as f64 + 0.5) * step * steps as f64;
                sim.rig().turn_sides(Some(self.sides(time.max(0.0))));
                sim.advance(COASTING, steps)?;
            }
            Ok(pose(&sim))
        };
        let from = drive(-RUN_IN, 0.0)?;
        let to = drive(0.0, self.seconds())?;
        Ok(Motion::between(from, to, self.seconds()))
    }
}

/// The recording's entry in the report.
static COMPARISON: Event = Event {
    name: "recording",
    title: "Replay of recorded wheel speeds",
    about: "The wheels of each side turn at the recorded speeds on level rigid ground with each friction, after one second at the initial \
            speeds of the window. Turns are windows with steady speeds and a kinematic yaw of 0.4 to 2.8 rad.",
    vehicles: Vehicles::SkidSteered,
    place: Place::Rigid,
    run: |_| Ok(Outcome::default()),
};

/// Quartiles of numbers, linear between neighbours; not numbers if there are none.
fn quartiles(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    [0.25, 0.5, 0.75].map(|q| {
        let Some(last) = values.len().checked_sub(1) else { return f64::NAN };
        let at = q * last as f64;
        let low = at.floor() as usize;
        values[low] + (at - low as f64) * (values[(low + 1).min(last)] - values[low])
    })
}

/// A window as it is compared.
struct Case<'a> {
    window: &'a Window,
    /// Without slip: speed, m/s, and yaw, rad.
    speed: f64,
    yaw: f64,
    measured: Motion,
    /// For each friction.
    simulated: Vec<Motion>,
}

impl Case<'_> {
    fn turns(&self) -> bool {
        (TURN[0]..=TURN[1]).contains(&self.yaw.abs())
    }

    fn straight(&self) -> bool {
        let rate = self.yaw / self.window.seconds();
        rate.abs() < STRAIGHT[0] && self.speed.abs() > STRAIGHT[1]
    }
}

/// Replays a recording with a vehicle on level ground of each friction, with a step (s), and compares what both do.
///
/// # Errors
/// Returns an error for a vehicle without skid steering on wheels, and for one that can't be simulated.
pub fn replay(
    spec: &VehicleSpec,
    recording: &Recording,
    frictions: &[f64],
    step: f64,
) -> Result<Report, ValidateError> {
    if spec.skid.is_none() {
        let reason = "is missing: only skid-steered vehicles can replay recorded wheel speeds";
        return Err(Flaw::new("skid", reason).of("vehicle", spec.name.clone()).into());
    }
    let bench = Bench::new(spec, &[], step)?;
    let [radius, track] = bench.radius_and_track();
    let mut cases: Vec<Case<'_>> = Vec::new();
    for window in &recording.windows {
        let (speed, rate, steady) = window.kinematic(radius, track);
        let case = Case {
            window,
            speed,
            yaw: rate * window.seconds(),
            measured: window.measured(),
            simulated: Vec::new(),
        };
        if steady && (case.turns() || case.straight()) {
            cases.push(case);
        }
    }
    for &friction in frictions {
        let start = Pose2 { x: 0.0, y: 0.0, yaw: 0.0 };
        let standing =
            Simulation::new(flat(friction), &bench.model, &SoilSet::default(), start, bench.options)?;
        for case in &mut cases {
            case.simulated.push(case.window.simulated(&standing, step)?);
        }
    }
    let outcome = outcome(recording, &cases, frictions);
    let result =
        EventResult { event: &COMPARISON, outcome, failure: None, setups: Vec::new(), checks: Vec::new() };
    Ok(Report { vehicle: spec.clone(), step, setups: BTreeMap::new(), results: vec![result] })
}

/// A quantity that is compared: its name, unit, the windows that have it, and how it follows from a motion.
struct Quantity {
    name: &'static str,
    unit: &'static str,
    of: fn(&Case<'_>) -> bool,
    value: fn(&Case<'_>, &Motion) -> f64,
}

const QUANTITIES: [Quantity; 4] = [
    Quantity {
        name: "turns: yaw over that without slip",
        unit: "",
        of: |c| c.turns(),
        value: |c, m| m.yaw / c.yaw,
    },
    Quantity { name: "turns: lateral speed", unit: "m/s", of: |c| c.turns(), value: |_, m| m.lateral.abs() },
    Quantity { name: "turns: distance", unit: "m", of: |c| c.turns(), value: |_, m| m.distance },
    Quantity {
        name: "straight: distance over that without slip",
        unit: "",
        of: |c| c.straight(),
        value: |c, m| m.distance / (c.speed.abs() * c.window.seconds()),
    },
];

fn outcome(recording: &Recording, cases: &[Case<'_>], frictions: &[f64]) -> Outcome {
    let mut o = Outcome::default();
    let count = |of: fn(&Case<'_>) -> bool| cases.iter().filter(|c| of(c)).count();
    o.figure("windows in the recording", recording.windows.len() as f64, "");
    if recording.incomplete > 0 {
        o.figure("windows left out, with missing values", recording.incomplete as f64, "");
    }
    o.figure("windows that turn", count(|c| c.turns()) as f64, "");
    o.figure("windows straight ahead", count(|c| c.straight()) as f64, "");
    if cases.is_empty() {
        o.note("No window has steady speeds and turns or drives straight ahead, so there is no comparison.");
    }
    for q in &QUANTITIES {
        let with = || cases.iter().filter(|c| (q.of)(c));
        if with().next().is_none() {
            continue;
        }
        let mut plot = Plot::new(
            q.name,
            "friction",
            &format!("{}{}{}", q.name, if q.unit.is_empty() { "" } else { ", " }, q.unit),
        );
        let mut tell = |who: &str, values: [f64; 3]| {
            for (part, value) in ["lower quartile", "median", "upper quartile"].into_iter().zip(values) {
                o.figure(format!("{}, {who}: {part}", q.name), value, q.unit);
            }
            values
        };
        let measured = tell("recorded", quartiles(with().map(|c| (q.value)(c, &c.measured)).collect()));
        let mut lines = [Vec::new(), Vec::new(), Vec::new()];
        for (i, friction) in frictions.iter().enumerate() {
            let values = quartiles(with().map(|c| (q.value)(c, &c.simulated[i])).collect());
            tell(&format!("simulated at μ {friction}"), values);
            for (line, value) in lines.iter_mut().zip(values) {
                line.push([*friction, value]);
            }
        }
        let ends = [frictions[0], frictions[frictions.len() - 1]];
        for (case, (part, line)) in
            ["lower quartile", "median", "upper quartile"].into_iter().zip(lines).enumerate()
        {
            plot.line(LineKind::Ours, case, format!("simulated, {part}"), line);
            let level = ends.map(|x| [x, measured[case]]).to_vec();
            plot.line(LineKind::Reference, case, format!("recorded, {part}"), level);
        }
        o.plots.push(plot);
    }
    differences(&mut o, cases, frictions);
    distribution(&mut o, cases, frictions);
    o.series.push(table(cases, frictions));
    o
}

/// How far single windows are from the recording.
fn differences(o: &mut Outcome, cases: &[Case<'_>], frictions: &[f64]) {
    let turns: Vec<&Case<'_>> = cases.iter().filter(|c| c.turns()).collect();
    if turns.is_empty() {
        return;
    }
    for (i, friction) in frictions.iter().enumerate() {
        let root = |value: fn(&Motion) -> f64| {
            let of = |c: &&Case<'_>| {
                let apart = value(&c.simulated[i]) - value(&c.measured);
                apart * apart
            };
            (turns.iter().map(of).sum::<f64>() / turns.len() as f64).sqrt()
        };
        o.figure(format!("turns, μ {friction}: rms difference of yaw"), degrees(root(|m| m.yaw)), "°");
        o.figure(format!("turns, μ {friction}: rms difference of distance"), root(|m| m.distance), "m");
        o.figure(format!("turns, μ {friction}: rms difference of lateral speed"), root(|m| m.lateral), "m/s");
    }
}

/// The fraction of turns below a yaw ratio.
fn distribution(o: &mut Outcome, cases: &[Case<'_>], frictions: &[f64]) {
    let turns: Vec<&Case<'_>> = cases.iter().filter(|c| c.turns()).collect();
    if turns.is_empty() {
        return;
    }
    let mut plot = Plot::new(
        "Distribution of the yaw ratio",
        "yaw over that without slip",
        "fraction of the turns below",
    );
    let sorted = |value: &dyn Fn(&Case<'_>) -> f64| {
        let mut values: Vec<f64> = turns.iter().map(|c| value(c) / c.yaw).collect();
        values.sort_by(f64::total_cmp);
        let part = |i: usize| (i as f64 + 0.5) / values.len() as f64;
        values.iter().enumerate().map(|(i, v)| [*v, part(i)]).collect::<Vec<_>>()
    };
    for (i, friction) in frictions.iter().enumerate() {
        plot.line(LineKind::Ours, i, format!("simulated, μ {friction}"), sorted(&|c| c.simulated[i].yaw));
    }
    plot.line(LineKind::Reference, frictions.len(), "recorded", sorted(&|c| c.measured.yaw));
    o.plots.push(plot);
}

/// All windows that are compared.
fn table(cases: &[Case<'_>], frictions: &[f64]) -> Series {
    let mut columns: Vec<(String, &'static str)> = vec![
        ("number".to_owned(), ""),
        ("speed without slip".to_owned(), "m/s"),
        ("yaw without slip".to_owned(), "rad"),
    ];
    let who = std::iter::once("recorded".to_owned()).chain(frictions.iter().map(|f| format!("mu {f}")));
    for who in who {
        columns.push((format!("yaw {who}"), "rad"));
        columns.push((format!("distance {who}"), "m"));
        columns.push((format!("lateral {who}"), "m/s"));
    }
    let row = |(i, c): (usize, &Case<'_>)| {
        let motions = std::iter::once(&c.measured).chain(&c.simulated);
        let start = [i as f64, c.speed, c.yaw];
        start.into_iter().chain(motions.flat_map(|m| [m.yaw, m.distance, m.lateral])).collect()
    };
    Series { name: "windows".to_owned(), columns, rows: cases.iter().enumerate().map(row).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn husky() -> VehicleSpec {
        VehicleSpec::parse(include_str!("../../../../../tasks/vehicles/husky.yaml"), "husky.yaml").unwrap()
    }

    /// A turn of 2 s in which the recorded vehicle turns by 0.3 rad, and a straight window.
    const TEXT: &str = "window,time,left,right,x,y,yaw,note\n\
        a,0,1.0,3.0,0,0,0,\n\
        a,1,1.0,3.0,,,,\n\
        a,2,1.0,3.0,0.6,0.1,0.3,\n\
        b,10,3.0,3.0,5,5,1.0,\n\
        b,12,3.0,3.0,5.5,5.8,1.0,\n";

    #[test]
    fn recorded_windows_are_read_and_replayed() {
        let recording = Recording::parse(TEXT, "drive.csv").unwrap();
        assert_eq!((recording.name.as_str(), recording.windows.len()), ("drive", 2));
        let motion = recording.windows[0].measured();
        assert!((motion.yaw - 0.3).abs() < 1e-12 && (motion.distance - hypot(0.6, 0.1)).abs() < 1e-12);
        let report = replay(&husky(), &recording, &[0.3, 0.8], 1e-3).unwrap();
        let o = &report.results[0].outcome;
        assert_eq!(o.value("windows that turn"), Some(1.0));
        // 2 rad/s · 0.1651 m / 0.555 m · 2 s = 1.19 rad without slip.
        let recorded = o.value("turns: yaw over that without slip, recorded: median").unwrap();
        assert!((recorded - 0.3 / (2.0 * 2.0 * 0.1651 / 0.555)).abs() < 1e-9, "{recorded}");
        let ours = o.value("turns: yaw over that without slip, simulated at μ 0.8: median").unwrap();
        assert!(ours > 0.3 && ours < 1.0, "{ours}");
        // On rigid ground little slip is needed to roll.
        let straight =
            o.value("straight: distance over that without slip, simulated at μ 0.8: median").unwrap();
        assert!((0.97..=1.0).contains(&straight), "{straight}");
        assert!(report.page().contains("recorded, median"));
    }

    /// A table of DRIVE with windows of four samples: a turn of 0.2 s, one with a missing wheel speed, a straight one.
    fn drive(last: &str) -> String {
        let mut head = vec!["calib_step".to_owned()];
        let mut rows = [vec!["0".to_owned()], vec!["1".to_owned()], vec!["2".to_owned()]];
        let mut add = |name: String, values: [&str; 3]| {
            head.push(name);
            rows.iter_mut().zip(values).for_each(|(row, v)| row.push(v.to_owned()));
        };
        for (name, values) in [("x", ["0", "0", "5"]), ("y", ["0", "0", "5"]), ("yaw", ["3", "0", "1"])] {
            add(format!("init_icp_{name}"), values);
        }
        for k in 0..4 {
            add(format!("right_wheel_vel_{k}"), ["30.0", if k == 2 { "" } else { "3" }, "4"]);
            add(format!("left_wheel_vel_{k}"), ["10.0", "1", "4"]);
        }
        for (name, values) in [("x", ["0.6", "1", last]), ("y", ["0.1", "1", "5"]), ("yaw", ["-3", "0", "1"])]
        {
            add(format!("gt_icp_{name}"), values);
        }
        let lines: Vec<String> = std::iter::once(head).chain(rows).map(|row| row.join(",")).collect();
        lines.join("\n")
    }

    #[test]
    fn a_table_of_drive_is_read_with_a_window_in_each_row() {
        let recording = Recording::parse(&drive("5.2"), "husky/torch_ready_dataframe.csv").unwrap();
        assert_eq!((recording.windows.len(), recording.incomplete), (2, 1));
        let [turn, straight] = &recording.windows[..] else { unreachable!() };
        // Four samples at 20 Hz; the last pose is one sample later.
        assert!((turn.seconds() - 0.2).abs() < 1e-12);
        assert_eq!(turn.sides(0.12), [10.0, 30.0]);
        // From 3 rad over π to -3 rad.
        let motion = turn.measured();
        assert!((motion.yaw - (std::f64::consts::TAU - 6.0)).abs() < 1e-12, "{}", motion.yaw);
        assert!((motion.distance - hypot(0.6, 0.1)).abs() < 1e-12);
        assert!((straight.measured().distance - 0.2).abs() < 1e-12);
        let e = Recording::parse(&drive("far"), "t.csv").unwrap_err().to_string();
        assert_eq!(e, "t.csv: line 4, gt_icp_x: \"far\" is not a number");
        let e = Recording::parse(&drive("5").replace("gt_icp_yaw", "gt"), "t.csv").unwrap_err().to_string();
        assert_eq!(e, "t.csv: line 1: has no column gt_icp_yaw, which a table of DRIVE has");
        let e =
            Recording::parse(&drive("5").replace("right_wheel_vel_3", "r"), "t.csv").unwrap_err().to_string();
        assert_eq!(e, "t.csv: line 1: has no column right_wheel_vel_3, which a table of DRIVE has");
    }

    #[test]
    fn what_is_no_recording_is_refused_with_line_and_column() {
        let refused = |from: &str, to: &str, says: &str| {
            assert!(TEXT.contains(from), "{from}");
            let e = Recording::parse(&TEXT.replacen(from, to, 1), "drive.csv").unwrap_err().to_string();
            assert!(e.starts_with("drive.csv: ") && e.contains(says) && !e.contains('\n'), "{e}");
        };
        refused("left", "links", "line 1: has no column left; a recording has window, time, left");
        refused("a,1,1.0", "a,1,fast", "line 3, left: \"fast\" is not a number");
        refused("a,1,1.0", "a,0,1.0", "line 3, time: 0 must exceed that of the row before, 0");
        refused("b,12,3.0,3.0,5.5,5.8,1.0,", "b,12", "line 6, x: is missing");
        refused("5.5,5.8,1.0", ",,", "window b: has no pose in its first or in its last row");
        refused("5.5,5.8,1.0", "5.5,nan,1.0", "line 6, y: NaN must lie in");
        refused("a,1,1.0", "\"a\",\"1\",\"1.0x\"", "line 3, left: \"1.0x\" is not a number");
        let e = Recording::parse("window,time,left,right,x,y,yaw\n", "drive.csv").unwrap_err().to_string();
        assert_eq!(e, "drive.csv: file: has no rows");
        let hmmwv = include_str!("../../../../../tasks/vehicles/hmmwv.yaml");
        let spec = VehicleSpec::parse(hmmwv, "hmmwv.yaml").unwrap();
        let e = replay(&spec, &Recording::parse(TEXT, "d").unwrap(), &[0.5], 1e-3).unwrap_err().to_string();
        assert!(e.starts_with("hmmwv: skid: is missing"), "{e}");
    }
}
