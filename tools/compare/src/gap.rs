//! The gap under a sliding wheel in Chrono's records: what its contact solver does, seen.
//!
//! A record tells the pose of the vehicle, the places and speeds of its wheels and the force of the ground on each. A
//! wheel that rolls stands on the ground. One that slides stands above it by the solver's step times the friction
//! coefficient times the sliding speed (`vb_vehicle::tyre::Dilation`), up to the distance at which contacts are reported.

use std::fmt::Write as _;
use std::path::Path;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use vb_world::Heightfield;

use crate::CompareError;
use crate::reference::{RADIUS, Series, WHEELS};

/// Half the width of a wheel, m.
const HALF_WIDTH: f64 = 0.127;
/// Step of the recorded solver, s.
const STEP: f64 = 0.005;
/// Least force that counts as carrying, N.
const CARRIES: f64 = 1000.0;
/// Every so many rows of a record are looked at.
const EVERY: usize = 4;
/// Bounds of the sliding speeds that are put together, m/s.
const SPEEDS: [f64; 9] = [0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 12.0, 16.0, 50.0];

/// A wheel that carries, at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sample {
    /// Speed of the contact over the ground, m/s.
    sliding: f64,
    /// From the ground to the wheel, m; negative where it is pressed in.
    gap: f64,
    /// Tangential over normal force.
    friction: f64,
}

/// The point of a wheel that is nearest to the ground: its distance from it (m), the ground's normal, and where it is
/// from the hub (m). The axle is taken as the vehicle's own y axis: steering and camber move a wheel's lowest point
/// by little.
fn nearest(
    ground: &Heightfield,
    hub: &Vector3<f64>,
    attitude: &UnitQuaternion<f64>,
) -> (f64, Vector3<f64>, Vector3<f64>) {
    const POINTS: i32 = 120;
    let mut best = (f64::INFINITY, Vector3::z(), Vector3::zeros());
    for aside in [-HALF_WIDTH, 0.0, HALF_WIDTH] {
        for k in 0..POINTS {
            let (s, c) = vb_math::sin_cos(std::f64::consts::TAU * f64::from(k) / f64::from(POINTS));
            let arm = attitude * Vector3::new(RADIUS * c, aside, RADIUS * s);
            let rim = hub + arm;
            let at = ground.at(rim.x, rim.y);
            let normal = Vector3::new(-at.dzdx, -at.dzdy, 1.0).normalize();
            let gap = (rim.z - at.z) * normal.z;
            if gap < best.0 {
                best = (gap, normal, arm);
            }
        }
    }
    best
}

/// All wheels that carry in a record over this ground.
///
/// # Errors
/// If the record lacks a column.
pub(crate) fn samples(
    file: &Path,
    record: &Series,
    ground: &Heightfield,
) -> Result<Vec<Sample>, CompareError> {
    let column = |name: String| {
        let found = record.column(&name);
        found.ok_or_else(|| CompareError::reference(file, 1, format!("there is no column {name}")))
    };
    let columns = |names: [&str; 3], suffix: &str| -> Result<[usize; 3], CompareError> {
        let [a, b, c] = names.map(|n| column(format!("{n}{suffix}")));
        Ok([a?, b?, c?])
    };
    let (velocity, vector) = (columns(["vx", "vy", "vz"], "")?, columns(["qx", "qy", "qz"], "")?);
    let scalar = column("qw".to_owned())?;
    let mut wheels = Vec::new();
    for name in WHEELS {
        let places = (columns(["xw", "yw", "zw"], name)?, columns(["Fx", "Fy", "Fz"], name)?);
        wheels.push((places, column(format!("om{name}"))?));
    }
    let mut out = Vec::new();
    for row in record.rows.iter().step_by(EVERY) {
        let read = |[x, y, z]: [usize; 3]| Vector3::new(row[x], row[y], row[z]);
        let attitude = UnitQuaternion::from_quaternion(Quaternion::from_parts(row[scalar], read(vector)));
        for &((place, force), speed) in &wheels {
            let force = read(force);
            if force.norm() < CARRIES {
                continue;
            }
            let (gap, normal, arm) = nearest(ground, &read(place), &attitude);
            let slip = read(velocity) + (attitude * Vector3::y() * row[speed]).cross(&arm);
            let load = force.dot(&normal);
            if load <= 0.0 {
                continue;
            }
            let sliding = (slip - normal * slip.dot(&normal)).norm();
            out.push(Sample { sliding, gap, friction: (force - normal * load).norm() / load });
        }
    }
    Ok(out)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// The medians of gap and friction by sliding speed, beside step · μ · speed, as Markdown.
pub(crate) fn table(samples: &[Sample]) -> String {
    let mut out = String::from(
        "| sliding, m/s | wheels | gap, mm | 5 ms · μ · sliding, mm | μ, tangential over normal force |\n\
         |---|---|---|---|---|\n",
    );
    for bounds in SPEEDS.windows(2) {
        let within: Vec<&Sample> =
            samples.iter().filter(|s| (bounds[0]..bounds[1]).contains(&s.sliding)).collect();
        if within.is_empty() {
            continue;
        }
        let of = |value: fn(&Sample) -> f64| median(within.iter().map(|s| value(s)).collect());
        let _ = writeln!(
            out,
            "| {} to {} | {} | {:.0} | {:.0} | {:.2} |",
            bounds[0],
            bounds[1],
            within.len(),
            1e3 * of(|s| s.gap),
            1e3 * of(|s| STEP * s.friction * s.sliding),
            of(|s| s.friction),
        );
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "t,qw,qx,qy,qz,vx,vy,vz,omFL,omFR,omRL,omRR,xwFL,ywFL,zwFL,xwFR,ywFR,zwFR,xwRL,ywRL,zwRL,xwRR,\
                          ywRR,zwRR,FxFL,FyFL,FzFL,FxFR,FyFR,FzFR,FxRL,FyRL,FzRL,FxRR,FyRR,FzRR\n";

    #[test]
    fn a_wheel_that_spins_above_level_ground_shows_its_gap_and_its_sliding_speed() {
        // One wheel carries 5 kN, 40 mm above the ground, and spins at 30 rad/s where 2 m/s are driven.
        let row = "0,1,0,0,0,2,0,0,30,0,0,0,0,0,0.507,0,0,9,0,0,9,0,0,9,3000,0,5000,0,0,0,0,0,0,0,0,0\n";
        let record = Series::parse(Path::new("r.csv"), &format!("{HEADER}{row}")).unwrap();
        let ground = Heightfield::flat(5, 5, 1.0, 0.0);
        let found = samples(Path::new("r.csv"), &record, &ground).unwrap();
        assert_eq!(found.len(), 1);
        assert!((found[0].gap - 0.04).abs() < 1e-9, "{:?}", found[0]);
        assert!((found[0].sliding - (30.0 * 0.467 - 2.0)).abs() < 1e-9, "{:?}", found[0]);
        assert!((found[0].friction - 0.6).abs() < 1e-9);
        // 5 ms · 0.6 · 12.01 m/s = 36 mm.
        assert!(table(&found).ends_with("| 12 to 16 | 1 | 40 | 36 | 0.60 |\n"), "{}", table(&found));
    }

    #[test]
    fn a_record_without_a_column_is_named() {
        let record = Series::parse(Path::new("r.csv"), "t,qw\n0,1\n").unwrap();
        let message =
            samples(Path::new("r.csv"), &record, &Heightfield::flat(3, 3, 1.0, 0.0)).unwrap_err().to_string();
        assert!(message.contains("r.csv: line 1: there is no column vx"), "{message}");
    }
}
