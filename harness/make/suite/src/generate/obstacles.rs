//! Boulders and trees: how many, where and how large (as in the original's envs/utils/asset_utils.py).

use super::params::ObstacleParams;
use vb_math::rng::Stream;
use vb_world::{Density, Obstacle, ObstacleKind};

/// Boulders, then trees, each drawn uniformly and kept if it is far enough from the others and from every start and
/// goal. Distances are in plan. An error is the index of the obstacle that found no place.
pub(crate) fn obstacles(
    o: &ObstacleParams,
    density: Density,
    ends: &[[[f64; 2]; 2]],
    rng: &mut Stream,
) -> Result<Vec<Obstacle>, usize> {
    let millimetres = |v: f64| (v * 1000.0).round() / 1000.0;
    let boulders = o.boulders.get(density);
    let mut out: Vec<Obstacle> = Vec::new();
    for index in 0..boulders + o.trees.get(density) {
        let kind = if index < boulders {
            let scale = rng.uniform(o.boulder_scale[0], o.boulder_scale[1]);
            let size = o
                .boulder_size
                .map(|l| millimetres(l * scale * rng.uniform(o.boulder_stretch[0], o.boulder_stretch[1])));
            // A shape's name of at most ten digits is enough for shapes that differ, and can be read.
            ObstacleKind::Boulder { size, seed: rng.below(1 << 32) }
        } else {
            let mut draw = |[low, high]: [f64; 2]| millimetres(rng.uniform(low, high));
            ObstacleKind::Trunk { radius: draw(o.trunk_radius), height: draw(o.trunk_height) }
        };
        let yaw = millimetres(rng.uniform(-std::f64::consts::PI, std::f64::consts::PI));
        let free = |p: [f64; 2]| {
            let far = |q: [f64; 2], least| vb_math::hypot(p[0] - q[0], p[1] - q[1]) >= least;
            ends.iter().flatten().all(|&q| far(q, o.task_clearance))
                && out.iter().all(|other| far([other.x, other.y], o.spacing))
        };
        let place = (0..o.attempts)
            .map(|_| [0; 2].map(|_| millimetres(rng.uniform(-o.extent, o.extent))))
            .find(|&p| free(p))
            .ok_or(index)?;
        let mut obstacle = Obstacle { x: place[0], y: place[1], yaw, buried: 0.0, kind };
        obstacle.buried = millimetres(o.buried * obstacle.size()[2]);
        out.push(obstacle);
    }
    Ok(out)
}
