//! From where a film is shot.

use vb_render::{Painter, Sight};
use vb_sim::VehicleState;

use crate::V3;

/// From where a film is shot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Camera {
    /// From behind and above the vehicle, which the camera follows smoothly.
    #[default]
    Chase,
    /// From straight above the vehicle, with the north at the top.
    Top,
    /// The whole world from above, with the north at the top.
    Map,
}

/// The time about a moment over which the way of the chase camera is averaged, s before and after it, in a world of full size: it takes
/// the jolts of the vehicle out and keeps its turns.
const SMOOTH: f64 = 0.7;

/// The lines of sight of a chase camera for a vehicle in these states, which are in the order of time. `pace` is the square root of
/// the world's scale, by which times shrink.
///
/// Each is the average about its moment, which lies in the middle whatever the moment, so the camera lags behind
/// nothing. The height of the eye is the greatest of its surroundings before it is averaged: then the average is nowhere lower than
/// what keeps ground and obstacles out of sight.
pub(crate) fn chase(painter: &Painter, states: &[VehicleState], pace: f64) -> Vec<Sight> {
    let given: Vec<Sight> = states.iter().map(|s| painter.chase(s)).collect();
    let times: Vec<f64> = states.iter().map(|s| s.time).collect();
    let reach = |k: usize| {
        let ends = (times[k] - times[0]).min(times[times.len() - 1] - times[k]);
        window(&times, k, ends.min(SMOOTH * pace))
    };
    let whole = |k: usize| window(&times, k, SMOOTH * pace);
    let high: Vec<f64> =
        (0..given.len()).map(|k| given[whole(k)].iter().map(|s| s.eye[2]).fold(f64::NEG_INFINITY, f64::max)).collect();
    (0..given.len())
        .map(|k| {
            let about = reach(k);
            let n = about.len() as f64;
            let mean = |of: &dyn Fn(usize) -> [f64; 3]| -> V3 {
                about.clone().map(|j| V3::from(of(j))).sum::<V3>() / n
            };
            let eye = mean(&|j| [given[j].eye[0], given[j].eye[1], high[j]]);
            Sight { eye: eye.into(), at: mean(&|j| given[j].at).into() }
        })
        .collect()
}

/// The moments within `reach` of moment `k`, itself among them.
fn window(times: &[f64], k: usize, reach: f64) -> std::ops::Range<usize> {
    // A little more, so that equal distances to both sides are equal.
    let (least, most) = (times[k] - reach - 1e-9, times[k] + reach + 1e-9);
    times.partition_point(|t| *t < least)..times.partition_point(|t| *t <= most)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_even_about_their_moment() {
        let times: Vec<f64> = (0..11).map(|k| 0.1 * f64::from(k)).collect();
        assert_eq!(window(&times, 5, 0.3), 2..9);
        assert_eq!(window(&times, 0, 0.0), 0..1);
        assert_eq!(window(&times, 9, 0.1), 8..11);
    }
}
