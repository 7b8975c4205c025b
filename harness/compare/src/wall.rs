//! At a wall: how much speed the vehicle loses there, from the very state in which Chrono's came.
//!
//! A record holds the second or more in which Project Chrono's vehicle meets the wall of a pit or a ditch, at 200 Hz. The
//! recorded vehicle of ours is put into the state of its first row and driven with the recorded commands. What is compared
//! is the greatest loss of forward speed within a tenth of a second; records of the same wall with other settings of
//! Chrono's solver tell how much of it is the solver's.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use vb_sim::{
    Controls, Side, SimError, SimOptions, Simulation, SoilSet, VehicleModel, VehicleState, WheelState,
};
use vb_world::{Pose2, World};

use crate::CompareError;
use crate::reference::{RADIUS, Series, WHEELS, files};

/// Over which the loss is taken, s.
const WITHIN: f64 = 0.1;

/// The greatest loss of speed in a record or a run, m/s: from one speed to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Loss {
    from: f64,
    to: f64,
}

impl Loss {
    /// In forward speeds (m/s) that are `period` (s) apart; none if there are too few.
    fn greatest(speeds: &[f64], period: f64) -> Option<Self> {
        let apart = (WITHIN / period).round() as usize;
        let pairs = speeds.iter().zip(speeds.iter().skip(apart));
        pairs.map(|(&from, &to)| Self { from, to }).max_by(|a, b| a.lost().total_cmp(&b.lost()))
    }

    fn lost(&self) -> f64 {
        self.from - self.to
    }
}

/// A wall in a record: name of the file, Chrono's loss and ours.
pub(crate) struct Wall {
    name: String,
    chrono: Loss,
    ours: Loss,
}

/// Columns of a record by name.
struct Columns<'a> {
    file: &'a Path,
    record: &'a Series,
}

impl Columns<'_> {
    fn one(&self, row: &[f64], name: &str) -> Result<f64, CompareError> {
        let found = self.record.column(name);
        let missing = || CompareError::reference(self.file, 1, format!("there is no column {name}"));
        found.map(|c| row[c]).ok_or_else(missing)
    }

    fn three(&self, row: &[f64], names: [&str; 3]) -> Result<Vector3<f64>, CompareError> {
        let [x, y, z] = names.map(|name| self.one(row, name));
        Ok(Vector3::new(x?, y?, z?))
    }

    /// The state of the vehicle in a row. Travels are those at which the wheels are as high above the chassis frame's
    /// origin as in the record.
    fn state(&self, row: &[f64], model: &VehicleModel) -> Result<VehicleState, CompareError> {
        let vector = self.three(row, ["qx", "qy", "qz"])?;
        let attitude = UnitQuaternion::from_quaternion(Quaternion::from_parts(self.one(row, "qw")?, vector));
        let position = self.three(row, ["x", "y", "z"])?;
        let steering = self.one(row, "steering")?;
        let mut wheels = Vec::new();
        for (k, name) in WHEELS.iter().enumerate() {
            let place = ["xw", "yw", "zw"].map(|c| format!("{c}{name}"));
            let hub = self.three(row, [&place[0], &place[1], &place[2]])?;
            let height = (attitude.inverse() * (hub - position)).z - model.spec().axles[k / 2].position[2];
            let side = if k % 2 == 0 { Side::Left } else { Side::Right };
            let axle = &model.axles()[k / 2];
            let (mut low, mut high) = (-0.5, 0.5);
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                let lower = axle.wheel(side, [middle; 2], 0.0).hub.z < height;
                if lower { low = middle } else { high = middle }
            }
            wheels.push(WheelState {
                speed: self.one(row, &format!("om{name}"))?,
                deflection: low,
                ..WheelState::default()
            });
        }
        Ok(VehicleState {
            time: 0.0,
            position,
            attitude,
            velocity: attitude.inverse() * self.three(row, ["vx", "vy", "vz"])?,
            rates: self.three(row, ["wx", "wy", "wz"])?,
            wheels,
            steering,
        })
    }
}

/// Drives a record's commands from its first state.
fn drive(
    file: &Path,
    record: &Series,
    world: &World,
    model: &VehicleModel,
    soils: &SoilSet,
) -> Result<(Loss, Loss), CompareError> {
    let columns = Columns { file, record };
    let failed = |source: SimError| CompareError::Simulation { file: file.into(), source };
    let few = || CompareError::reference(file, 1, "the record is shorter than 0.1 s");
    let [first, second, ..] = record.rows.as_slice() else { return Err(few()) };
    let period = columns.one(second, "t")? - columns.one(first, "t")?;
    let start = Pose2 { x: columns.one(first, "x")?, y: columns.one(first, "y")?, yaw: 0.0 };
    let options = SimOptions { settle_time: 0.01, ..SimOptions::default() };
    let mut sim = Simulation::new(Arc::new(world.clone()), model, soils, start, options).map_err(failed)?;
    sim.put(&columns.state(first, model)?, columns.one(first, "gear")? as usize);
    let steps = ((period / options.step).round() as u64).max(1);
    let (mut chrono, mut ours) = (Vec::new(), Vec::new());
    for row in &record.rows {
        chrono.push(columns.one(row, "vfwd")?);
        ours.push(sim.state().velocity.x);
        if std::env::var_os("DBG").is_some_and(|d| file.to_string_lossy().contains(&*d.to_string_lossy())) {
            let s = sim.state();
            let (r, p, yw) = s.roll_pitch_yaw();
            let w: Vec<String> = s
                .wheels
                .iter()
                .map(|w| format!("{:.2}/{:.0}/{:.3}", w.speed, w.load, w.deflection))
                .collect();
            println!(
                "O {:.3} x {:.3} {:.3} {:.3} v {:.3} rpy {r:.3} {p:.3} {yw:.3} w {}",
                columns.one(row, "t")?,
                s.position.x,
                s.position.y,
                s.position.z,
                s.velocity.x,
                w.join(" ")
            );
            let c = |n: &str| columns.one(row, n).unwrap();
            let mut w = String::new();
            let cs = columns.state(row, model)?;
            for (k, n) in WHEELS.iter().enumerate() {
                let f = Vector3::new(c(&format!("Fx{n}")), c(&format!("Fy{n}")), c(&format!("Fz{n}")));
                w += &format!("{:.2}/{:.0}/{:.3} ", c(&format!("om{n}")), f.norm(), cs.wheels[k].deflection);
            }
            println!(
                "C {:.3} x {:.3} {:.3} {:.3} v {:.3} rpy {:.3} {:.3} {:.3} w {w} n {} thr {} br {} g {}",
                c("t"),
                c("x"),
                c("y"),
                c("z"),
                c("vfwd"),
                c("roll"),
                c("pitch"),
                c("yaw"),
                c("ncontacts"),
                c("throttle"),
                c("braking"),
                c("gear")
            );
        }
        let controls = Controls {
            steering: columns.one(row, "steering")?,
            throttle: columns.one(row, "throttle")?,
            brake: columns.one(row, "braking")?,
        };
        sim.advance(controls, steps).map_err(failed)?;
    }
    let greatest = |speeds: &[f64]| Loss::greatest(speeds, period).ok_or_else(few);
    Ok((greatest(&chrono)?, greatest(&ours)?))
}

/// How far the wheels of a record's first state are from standing on this ground, in the mean, m.
fn off_the_ground(columns: &Columns<'_>, row: &[f64], world: &World) -> Result<f64, CompareError> {
    let mut sum = 0.0;
    for name in WHEELS {
        let place = ["xw", "yw", "zw"].map(|c| format!("{c}{name}"));
        let hub = columns.three(row, [&place[0], &place[1], &place[2]])?;
        sum += hub.z - RADIUS - world.heightfield.height(hub.x, hub.y);
    }
    Ok((sum / WHEELS.len() as f64).abs())
}

/// All walls in a folder of records over the worlds that are there. A record is named `wWORLD_VARIANT.csv`, or
/// `wWORLDPAIR_VARIANT.csv` with a pair of one digit; of both readings the one counts in whose world its wheels stand on the
/// ground.
pub(crate) fn walls(
    dir: &Path,
    worlds: &BTreeMap<u32, World>,
    model: &VehicleModel,
    soils: &SoilSet,
) -> Result<Vec<Wall>, CompareError> {
    let mut walls = Vec::new();
    for file in files(dir, "csv")? {
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let digits: String = name.chars().skip(1).take_while(char::is_ascii_digit).collect();
        let number: u32 = digits.parse().unwrap_or_default();
        let record = Series::read(&file)?;
        let Some(first) = record.rows.first() else { continue };
        let columns = Columns { file: &file, record: &record };
        let mut nearest: Option<(f64, &World)> = None;
        for world in [number, number / 10].iter().filter_map(|n| worlds.get(n)) {
            let off = off_the_ground(&columns, first, world)?;
            if nearest.is_none_or(|(least, _)| off < least) {
                nearest = Some((off, world));
            }
        }
        let Some((_, world)) = nearest else { continue };
        let (chrono, ours) = drive(&file, &record, world, model, soils)?;
        walls.push(Wall { name, chrono, ours });
    }
    Ok(walls)
}

/// As Markdown.
pub(crate) fn table(walls: &[Wall]) -> String {
    let mut out = String::from(
        "| record | Chrono loses, m/s | ours | ours over Chrono's |\n\
         |---|---|---|---|\n",
    );
    for w in walls {
        let told = |l: &Loss| format!("{:.2} ({:.2} → {:.2})", l.lost(), l.from, l.to);
        let _ = writeln!(
            out,
            "| {} | {} | {} | {:.2} |",
            w.name,
            told(&w.chrono),
            told(&w.ours),
            w.ours.lost() / w.chrono.lost()
        );
    }
    out
}
