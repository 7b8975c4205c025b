//! Many numbers in little text: what moves smoothly is told by how it departs from going on as before.

use std::io::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::DeflateEncoder;
use serde_json::{Value, json};

/// Unit of times, s.
pub(crate) const TIME: f64 = 1e-4;

/// Rows of numbers for the page's script (`web/src/packed.js`), each number to the nearest multiple of its column's unit; what is no
/// number is 0. It is a list: the number of rows, the order of the prediction, the units, and the numbers in base64.
///
/// These are column after column, in units, each less what its predecessors in the column lead to expect: 0 (order 0), the same
/// again (1), or as much more as the last time (2). The order is the one that gives the shortest text. Of the differences, the
/// bits go from seven to a byte, the lowest first, with the sign as the lowest bit, and all together through DEFLATE (RFC 1951).
pub(crate) fn packed<const COLUMNS: usize>(
    rows: impl Iterator<Item = [f64; COLUMNS]>,
    units: [f64; COLUMNS],
) -> Value {
    let rows: Vec<[i64; COLUMNS]> =
        rows.map(|row| std::array::from_fn(|c| (row[c] / units[c]).round() as i64)).collect();
    let all = (0..=2).map(|order| (order, deflated(&differences(&rows, order))));
    let (order, bytes) = all.min_by_key(|(_, bytes)| bytes.len()).unwrap_or_default();
    json!([rows.len(), order, units.to_vec(), STANDARD.encode(bytes)])
}

/// Events in the order of time for the page: each time (s) with the number of events then.
pub(crate) fn steps(times: impl Iterator<Item = f64>) -> Value {
    let mut steps: Vec<[f64; 2]> = Vec::new();
    for at in times {
        match steps.last_mut() {
            Some([time, count]) if *time == at => *count += 1.0,
            _ => steps.push([at, 1.0]),
        }
    }
    packed(steps.into_iter(), [TIME, 1.0])
}

/// The differences from a prediction of this order as bytes.
fn differences<const COLUMNS: usize>(rows: &[[i64; COLUMNS]], order: i32) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(2 * COLUMNS * rows.len());
    for column in 0..COLUMNS {
        let [mut last, mut before] = [0_i64; 2];
        for row in rows {
            let expected = match order {
                0 => 0,
                1 => last,
                _ => last.wrapping_mul(2).wrapping_sub(before),
            };
            let difference = row[column].wrapping_sub(expected);
            // 0, -1, 1, -2, … as 0, 1, 2, 3, …
            let mut rest = (difference.wrapping_shl(1) ^ (difference >> 63)) as u64;
            while rest > 0x7f {
                bytes.push(rest as u8 | 0x80);
                rest >>= 7;
            }
            bytes.push(rest as u8);
            (before, last) = (last, row[column]);
        }
    }
    bytes
}

fn deflated(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::best());
    // Writing into memory does not fail.
    let _ = encoder.write_all(bytes);
    encoder.finish().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_goes_on_as_before_costs_nothing_and_the_order_follows_the_numbers() {
        // By hand: 5 m/s at 50 frames a second in millimetres. Of order 2 all but the first two differences are 0; zigzag of 100 is
        // 200, which takes two bytes of seven bits: 0xc8 and 1.
        let rows: Vec<[i64; 1]> = (0..5).map(|k| [100 * k]).collect();
        assert_eq!(differences(&rows, 2), [0, 0xc8, 1, 0, 0, 0]);
        assert_eq!(differences(&rows, 1), [0, 0xc8, 1, 0xc8, 1, 0xc8, 1, 0xc8, 1]);
        assert_eq!(differences(&[[-1], [1], [-2]], 0), [1, 2, 3]);
        let order = |value: fn(f64) -> f64| {
            packed((0..200).map(|k| [value(f64::from(k))]), [1.0])[1].as_i64().unwrap()
        };
        let spikes = |t: f64| if t % 17.0 == 3.0 { t * t % 60.0 } else { 0.0 };
        let steps = |t: f64| 60.0 * (t * t / 900.0).floor();
        assert_eq!((order(spikes), order(steps), order(|t| t * t)), (0, 1, 2));
    }

    #[test]
    fn numbers_are_rounded_to_their_units_and_what_is_none_is_nothing() {
        let same = packed([[0.123_44, f64::NAN]].into_iter(), [1e-3, 1.0]);
        assert_eq!(same, packed([[0.123, 0.0]].into_iter(), [1e-3, 1.0]));
        assert_eq!((&same[0], &same[2]), (&json!(1), &json!([1e-3, 1.0])));
        assert_eq!(packed(std::iter::empty::<[f64; 1]>(), [1.0])[0], 0);
    }
}
