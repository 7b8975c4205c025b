//! Ground made for events.

use std::sync::Arc;
use vb_math::{sin, tan};
use vb_sim::{SimError, SimOptions, Simulation, SoilSet, VehicleState};
use vb_vehicle::VehicleModel;
use vb_world::{GranularBed, GranularMaterial, Heightfield, Pose2, Semantics, TerrainClass, World};

/// A world of one friction value over the given heights.
fn world(heightfield: Heightfield, friction: f64) -> Arc<World> {
    Arc::new(World::uniform("rig", heightfield, TerrainClass::Concrete, friction))
}

/// Level ground. The plane goes on beyond its edges, so its size doesn't matter.
pub(crate) fn flat(friction: f64) -> Arc<World> {
    plane(0.0, friction)
}

/// A plane that rises along x by an angle, rad.
pub(crate) fn plane(angle: f64, friction: f64) -> Arc<World> {
    let slope = tan(angle);
    let (rows, cols, resolution) = (5, 5, 10.0);
    let heights = (0..rows * cols).map(|i| slope * resolution * (i % cols) as f64).collect();
    world(Heightfield::new(rows, cols, resolution, heights), friction)
}

/// A strip of soil along x that rises by an angle, rad. Soil has an end, unlike rigid planes: `length` × `width` m.
pub(crate) fn soil(class: TerrainClass, length: f64, width: f64, angle: f64) -> Arc<World> {
    let slope = tan(angle);
    Arc::new(World::uniform("rig", heights(length, width, 1.0, |x| slope * x), class, 0.0))
}

/// Heights that depend on x alone, over `length` × `width` m, nodes `resolution` apart.
pub(crate) fn profile(
    length: f64,
    width: f64,
    resolution: f64,
    friction: f64,
    height: impl Fn(f64) -> f64,
) -> Arc<World> {
    world(heights(length, width, resolution, height), friction)
}

/// Level ground with two frictions: one to the left of the line y = 0, where y > 0, and one to the right.
pub(crate) fn split(left: f64, right: f64) -> Arc<World> {
    let mut world = World::uniform("rig", Heightfield::flat(5, 5, 10.0, 0.0), TerrainClass::Concrete, left);
    let s = &mut world.semantics;
    (s.rows, s.classes, s.friction) = (2, vec![TerrainClass::Concrete; 2], vec![right, left]);
    Arc::new(world)
}

/// Heights that depend on x and y, over `length` × `width` m, nodes `resolution` apart.
pub(crate) fn relief(
    length: f64,
    width: f64,
    resolution: f64,
    friction: f64,
    height: impl Fn(f64, f64) -> f64,
) -> Arc<World> {
    let (rows, cols) =
        ((width / resolution).round() as usize + 1, (length / resolution).round() as usize + 1);
    let place = |k: usize, count: usize| (k as f64 - 0.5 * (count - 1) as f64) * resolution;
    let heights = (0..rows * cols).map(|i| height(place(i % cols, cols), place(i / cols, rows))).collect();
    world(Heightfield::new(rows, cols, resolution, heights), friction)
}

/// Level ground with a bed of grains of `length` × `width` × `depth` m in its middle: whole metres of length and width, so that its edges
/// lie on borders of patches.
pub(crate) fn bed(material: &GranularMaterial, length: f64, width: f64, depth: f64) -> Arc<World> {
    // The ground goes on beyond its edges, its patches too.
    let (half_x, half_y) = (length as usize, width as usize);
    let bed = GranularBed {
        name: material.class.name().into(),
        material: material.clone(),
        x: 0.0,
        y: 0.0,
        length,
        width,
        depth,
        seed: 1,
    };
    let (rows, cols) = (4 * half_y, 4 * half_x);
    let middle = |k: usize, count: usize| 0.5 * (k as f64 - 0.5 * (count - 1) as f64);
    let within = |k: usize| bed.contains(middle(k % cols, cols), middle(k / cols, rows));
    let classes = (0..rows * cols).map(|k| if within(k) { material.class } else { TerrainClass::Concrete });
    let ground = Heightfield::flat(2 * half_y + 1, 2 * half_x + 1, 1.0, 0.0);
    let mut world = World::uniform("rig", ground, TerrainClass::Concrete, 0.9);
    world.semantics = Semantics {
        rows,
        cols,
        patch: 0.5,
        classes: classes.collect(),
        friction: vec![0.9; rows * cols],
        soil: world.semantics.soil,
    };
    world.beds.push(bed);
    Arc::new(world)
}

fn heights(length: f64, width: f64, resolution: f64, height: impl Fn(f64) -> f64) -> Heightfield {
    let (rows, cols) =
        ((width / resolution).round() as usize + 1, (length / resolution).round() as usize + 1);
    let line: Vec<f64> =
        (0..cols).map(|c| height((c as f64 - 0.5 * (cols - 1) as f64) * resolution)).collect();
    let heights = (0..rows * cols).map(|i| line[i % cols]).collect();
    Heightfield::new(rows, cols, resolution, heights)
}

/// A half-sine bump over the whole width from x = 0 to `length`, `height` high, 0.05 m resolution (the reference's mesh).
pub(crate) fn bump(length: f64, height: f64, friction: f64) -> Arc<World> {
    profile(24.0, 6.0, 0.05, friction, |x| {
        if x > 0.0 && x < length { height * sin(std::f64::consts::PI * x / length) } else { 0.0 }
    })
}

/// A step up at x = 0. Its face leans by one node distance, 4 cm.
pub(crate) fn step(height: f64, friction: f64) -> Arc<World> {
    profile(4.0, 6.0, 0.04, friction, |x| if x > 0.02 { height } else { 0.0 })
}

/// The vehicle as it stands on level ground of its scale.
pub(crate) fn at_rest(model: &VehicleModel, options: SimOptions) -> Result<VehicleState, SimError> {
    let level = Arc::new(flat(0.9).scaled(model.spec().scale));
    let start = Pose2 { x: 0.0, y: 0.0, yaw: 0.0 };
    Ok(Simulation::new(level, model, &SoilSet::default(), start, options)?.state())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ground_has_the_shape_asked_for() {
        let w = plane(0.3, 0.5);
        let rise = w.heightfield.height(100.0, 3.0) - w.heightfield.height(0.0, -50.0);
        assert!((rise / 100.0 - tan(0.3)).abs() < 1e-12, "{rise}");
        let b = bump(2.0, 0.2, 0.9);
        assert!((b.heightfield.height(1.0, 0.3) - 0.2).abs() < 1e-12);
        assert_eq!([b.heightfield.height(-5.0, 0.0), b.heightfield.height(2.5, 0.0)], [0.0, 0.0]);
        let s = step(0.3, 0.9);
        assert_eq!([s.heightfield.height(0.0, 0.0), s.heightfield.height(0.04, 0.0)], [0.0, 0.3]);
        assert_eq!([s.heightfield.height(-99.0, 9.0), s.heightfield.height(99.0, 9.0)], [0.0, 0.3]);
    }
}
