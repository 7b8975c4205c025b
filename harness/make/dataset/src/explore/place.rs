//! Places where episodes of exploration start.

use vb_math::rng::Stream;
use vb_math::{atan, sin_cos};
use vb_world::Pose2;

use super::StartDraws;
use crate::feature::Ground;

/// Places that are drawn before it is given up.
const DRAWS: usize = 2000;

/// A pose for a vehicle of this length and width (m, those of the world as simulated) that the rules allow; `None` if there
/// seems to be none.
pub(crate) fn random_start(
    rules: &StartDraws,
    ground: &Ground,
    [length, width]: [f64; 2],
    random: &mut Stream,
) -> Option<Pose2> {
    let (world, field) = (&ground.world, &ground.world.heightfield);
    let edge = (rules.edge_m * world.scale).max(length);
    let steepest = rules.tilt_deg.to_radians();
    (0..DRAWS).find_map(|_| {
        let x = random.uniform(edge - field.half_x(), field.half_x() - edge);
        let y = random.uniform(edge - field.half_y(), field.half_y() - edge);
        let yaw = random.uniform(-std::f64::consts::PI, std::f64::consts::PI);
        let reach = 0.5 * vb_math::hypot(length, width);
        if ground.clearance([x, y]) < reach + rules.clearance_m * world.scale {
            return None;
        }
        let (sin, cos) = sin_cos(yaw);
        let at = |forward: f64, left: f64| {
            field.height(x + cos * forward - sin * left, y + sin * forward + cos * left)
        };
        let (l, w) = (0.5 * length, 0.5 * width);
        let [fl, fr, rl, rr] = [at(l, w), at(l, -w), at(-l, w), at(-l, -w)];
        let along = (fl + fr - rl - rr) / (2.0 * length);
        let across = (fl + rl - fr - rr) / (2.0 * width);
        (atan(vb_math::hypot(along, across)) <= steepest).then_some(Pose2 { x, y, yaw })
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use vb_world::{Heightfield, Obstacle, ObstacleKind, TerrainClass, World};

    const RULES: StartDraws = StartDraws { tilt_deg: 20.0, clearance_m: 1.0, edge_m: 8.0 };

    fn ground(slope: f64, obstacles: Vec<Obstacle>) -> Ground {
        let n = 65;
        let heights = (0..n * n).map(|k| slope * (k % n) as f64).collect();
        let field = Heightfield::new(n, n, 1.0, heights);
        let mut world = World::uniform("w", field, TerrainClass::Dirt, 0.8);
        world.obstacles = obstacles;
        Ground::new(Arc::new(world))
    }

    #[test]
    fn starts_keep_clear_of_the_edge_and_of_obstacles() {
        let box_ = ObstacleKind::Box { size: [20.0, 20.0, 2.0] };
        let obstacle = Obstacle { x: 0.0, y: 0.0, yaw: 0.0, buried: 0.0, kind: box_ };
        let g = ground(0.0, vec![obstacle]);
        for k in 0..200 {
            let p = random_start(&RULES, &g, [4.0, 2.0], &mut Stream::new(k, &["test"])).unwrap();
            assert!(p.x.abs() <= 24.0 && p.y.abs() <= 24.0, "{p:?}");
            // Half the diagonal of 4 m by 2 m, and 1 m more, from the box.
            let from_box = vb_math::hypot((p.x.abs() - 10.0).max(0.0), (p.y.abs() - 10.0).max(0.0));
            assert!(from_box >= 1.0 + 5f64.sqrt(), "{p:?}");
        }
    }

    #[test]
    fn no_start_is_on_ground_that_is_too_steep() {
        let on = |degrees: f64| {
            let g = ground(vb_math::tan(degrees.to_radians()), vec![]);
            random_start(&RULES, &g, [4.0, 2.0], &mut Stream::new(1, &["test"])).is_some()
        };
        assert!(on(19.9) && !on(20.1));
    }
}
