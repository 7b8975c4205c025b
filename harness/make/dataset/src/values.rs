//! Which values frames can have.

use std::ops::Range;

use vb_world::TerrainClass;

use crate::feature::{Feature, Values};

/// The greatest number that a frame may have, whatever its unit: no quantity of a vehicle, from the load of a wheel (N) to the
/// speed of its engine (rad/s), comes near it.
const MOST: f64 = 1e9;
/// The ranges of steering, throttle, brake and gear in `action` and `action.applied`.
const CONTROLS: [[f64; 2]; 4] = [[-1.0, 1.0], [0.0, 1.0], [0.0, 1.0], [-1.0, 1.0]];
/// The range of roll, pitch and yaw, rad: single precision rounds π up.
const TURN: f64 = std::f64::consts::PI + 1e-3;

/// The first value that no frame can have: the feature, the value, the frame, counted from the first of `rows`, and what is allowed.
/// `rows` are those of an episode.
pub(crate) fn flaw(features: &[Feature], columns: &[Values], rows: Range<usize>) -> Option<String> {
    features.iter().zip(columns).find_map(|(feature, values)| {
        of_kind(feature, values, rows.clone()).or_else(|| impossible(feature, values, rows.clone()))
    })
}

/// The first value that a feature of this kind can't have.
fn of_kind(feature: &Feature, values: &Values, rows: Range<usize>) -> Option<String> {
    let within = |entry: usize, [low, high]: [f64; 2]| {
        let value = |row: &usize| values.number(row * feature.width() + entry);
        let at = rows.clone().find(|row| value(row) < low || value(row) > high)?;
        let (name, v) = (&feature.names[entry], shown(value(&at)));
        Some(format!("{} {name}: {v} of frame {} must lie in {low} to {high}", feature.name, at - rows.start))
    };
    match feature.name {
        "action" | "action.applied" => {
            CONTROLS.into_iter().enumerate().find_map(|(entry, range)| within(entry, range))
        }
        "observation.state" | "truth.state" => (3..6).find_map(|entry| within(entry, [-TURN, TURN])),
        "next.done" => {
            let done = |row: &usize| values.number(*row) != f64::from(u8::from(row + 1 == rows.end));
            let at = rows.clone().find(done)?;
            Some(format!("next.done of frame {} is wrong", at - rows.start))
        }
        "truth.ground" => {
            let known = 0.0..TerrainClass::ALL.len() as f64;
            let at = rows.clone().find(|row| !known.contains(&values.number(*row)))?;
            let v = shown(values.number(at));
            Some(format!("{}: {v} of frame {} is not a terrain class", feature.name, at - rows.start))
        }
        _ => None,
    }
}

/// The first value that is not finite, or greater than any quantity of a vehicle.
fn impossible(feature: &Feature, values: &Values, rows: Range<usize>) -> Option<String> {
    let width = feature.width();
    let own = rows.start * width..rows.end * width;
    let most = MOST as f32;
    let at = match values {
        // A number that is none is not below anything.
        Values::F32(v) => v[own.clone()].iter().position(|v| !(-most..=most).contains(v))?,
        Values::I64(v) => v[own.clone()].iter().position(|v| v.unsigned_abs() > MOST as u64)?,
        Values::U8(_) | Values::Bool(_) => return None,
    };
    let (v, frame) = (values.number(own.start + at), at / width);
    if !v.is_finite() {
        return Some(format!("{} of frame {frame} is not finite", feature.name));
    }
    Some(format!("{}: {} of frame {frame} must lie in {:e} to {MOST:e}", feature.name, shown(v), -MOST))
}

/// A number for a message: with an exponent only if it would be long without.
pub(crate) fn shown(v: f64) -> String {
    if v == 0.0 || (1e-3..1e6).contains(&v.abs()) { v.to_string() } else { format!("{v:e}") }
}
