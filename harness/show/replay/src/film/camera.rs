//! From where a film is shot.

use vb_render::{Painter, Sight};
use vb_sim::VehicleState;

use crate::film::V3;

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
    let high: Vec<f64> = (0..given.len())
        .map(|k| given[whole(k)].iter().map(|s| s.eye[2]).fold(f64::NEG_INFINITY, f64::max))
        .collect();
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
    use std::sync::Arc;
    use vb_sim::Gear;
    use vb_vehicle::{VehicleModel, VehicleSpec};
    use vb_world::{Heightfield, TerrainClass, World};

    #[test]
    fn the_camera_takes_jolts_out_and_keeps_clear_of_the_ground() {
        let file =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../tasks/vehicles/hmmwv.yaml");
        let spec = VehicleSpec::parse(&std::fs::read_to_string(file).unwrap(), "hmmwv").unwrap();
        let model = VehicleModel::new(spec).unwrap();
        // A ridge behind which the eye must rise.
        let heights = (0..61 * 61).map(|k| if k % 61 == 25 { 6.0 } else { 0.0 }).collect();
        let world = World::uniform("w", Heightfield::new(61, 61, 1.0, heights), TerrainClass::Rock, 0.5);
        let painter = Painter::new(&Arc::new(world), &model);
        // East at 5 m/s, with a heading that jolts by 0.1 rad to either side, frame by frame.
        let states: Vec<VehicleState> = (0..200)
            .map(|k| {
                let time = 0.02 * f64::from(k);
                let yaw = if k % 2 == 0 { 0.1 } else { -0.1 };
                VehicleState {
                    time,
                    position: V3::new(-10.0 + 5.0 * time, 0.0, 1.0),
                    attitude: nalgebra::UnitQuaternion::from_axis_angle(&V3::z_axis(), yaw),
                    velocity_body: V3::x() * 5.0,
                    angular_velocity_body: V3::zeros(),
                    wheels: Vec::new(),
                    steering: 0.0,
                    gear: Gear::Forward,
                    engine_speed: 0.0,
                }
            })
            .collect();
        let sights = chase(&painter, &states, 1.0);
        let jolt =
            |at: &dyn Fn(usize) -> f64| (50..150).map(|k| (at(k) - at(k - 1)).abs()).fold(0.0, f64::max);
        let given: Vec<Sight> = states.iter().map(|s| painter.chase(s)).collect();
        let (before, after) = (jolt(&|k| given[k].eye[1]), jolt(&|k| sights[k].eye[1]));
        assert!(before > 1.5 && after < 0.05, "sideways steps of {before} m become {after} m");
        for (k, (sight, raw)) in sights.iter().zip(&given).enumerate() {
            assert!(sight.eye[2] >= raw.eye[2] - 1e-9, "{k}: {sight:?} {raw:?}");
        }
        // At the ends there is nothing before or after: the camera stands where it would.
        assert_eq!((sights[0].at, sights[199].at), (given[0].at, given[199].at));
    }

    #[test]
    fn windows_are_even_about_their_moment() {
        let times: Vec<f64> = (0..11).map(|k| 0.1 * f64::from(k)).collect();
        assert_eq!(window(&times, 5, 0.3), 2..9);
        assert_eq!(window(&times, 0, 0.0), 0..1);
        assert_eq!(window(&times, 9, 0.1), 8..11);
    }
}
