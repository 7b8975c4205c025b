//! Ground and obstacles as the original's simulator builds them (its envs/terrain.py and envs/utils/asset_utils.py).

use super::config::{Config, Position};
use super::sections::rigid_sections;
use super::{ImportError, TREE_SIZE, invalid, rock_sizes};
use std::path::Path;
use vb_world::{Heightfield, Obstacle, ObstacleKind, Semantics, Terrain, TerrainClass};

/// Classes and friction of the ground that the simulator makes of the patches `described` by the labels of a world
/// of `side` × `side` pixels.
///
/// # Errors
/// Returns an error if a deformable class of a mixed world is not one rectangle: the simulator keeps one rectangle a
/// class and would leave a hole in place of the rest.
pub(crate) fn semantics(
    file: &Path,
    ground: Terrain,
    described: &Semantics,
    side: usize,
) -> Result<Semantics, ImportError> {
    match ground {
        Terrain::Deformable => Ok(bands(described, side)),
        Terrain::Rigid => Ok(sections(described)),
        Terrain::Mixed => {
            let yielding = TerrainClass::ALL.into_iter().filter(|c| c.is_deformable());
            match yielding.map(|class| check_rectangle(described, class)).find_map(Result::err) {
                Some(problem) => Err(invalid(file, "textures", problem)),
                None => Ok(sections(described)),
            }
        }
    }
}

/// The patches with the friction of their sections.
fn sections(described: &Semantics) -> Semantics {
    let n = described.rows;
    // Rows are counted from the north there, from the south here.
    let index = |(i, j): (usize, usize)| (n - 1 - i) * n + j;
    let from_north: Vec<_> = described.classes.chunks(n).rev().flatten().copied().collect();
    let mut friction = described.friction.clone();
    for section in rigid_sections(&from_north, n, described.patch as usize) {
        let mu = described.friction[index(section.friction_from)];
        section.patches().for_each(|patch| friction[index(patch)] = mu);
    }
    Semantics { friction, ..described.clone() }
}

/// A world of soil: the classes that occur, in alphabetical order, in bands of equal height from the north. Their
/// edges lie at whole pixels, counted from the north and rounded down, and the last band takes what is left; where
/// that does not fit the patches, these are made as small as a pixel.
fn bands(described: &Semantics, side: usize) -> Semantics {
    let mut classes = described.classes.clone();
    classes.sort_by_key(|c| c.name());
    classes.dedup();
    let height = side / classes.len();
    let pixels = described.patch as usize;
    let fits = (1..classes.len()).all(|band| (band * height).is_multiple_of(pixels));
    let patch = if fits { pixels } else { 1 };
    let n = (side - 1) / patch;
    let class_of = |row: usize| classes[(row * patch / height).min(classes.len() - 1)];
    Semantics {
        rows: n,
        cols: n,
        patch: patch as f64,
        classes: (0..n).rev().flat_map(|row| std::iter::repeat_n(class_of(row), n)).collect(),
        friction: vec![0.0; n * n],
        soil: described.soil,
    }
}

/// Checks that the patches of a class fill a rectangle, or that there are none.
fn check_rectangle(s: &Semantics, class: TerrainClass) -> Result<(), String> {
    let of_class: Vec<_> = (0..s.rows * s.cols).filter(|&k| s.classes[k] == class).collect();
    let span = |coordinate: fn(usize, usize) -> usize| {
        let low = of_class.iter().map(|&k| coordinate(k, s.cols)).min().unwrap_or(0);
        let high = of_class.iter().map(|&k| coordinate(k, s.cols) + 1).max().unwrap_or(0);
        high - low
    };
    let (height, width) = (span(|k, cols| k / cols), span(|k, cols| k % cols));
    if height * width == of_class.len() {
        return Ok(());
    }
    Err(format!(
        "the {} patches of {} do not fill a rectangle, as the simulator of a mixed world requires: import this world \
         with the ground as-described",
        of_class.len(),
        class.name()
    ))
}

/// The collision boxes: rocks, then trees, axis-parallel and centred at the stored position, wherever the ground is.
pub(crate) fn obstacles(
    file: &Path,
    config: &Config,
    ground: &Heightfield,
) -> Result<Vec<Obstacle>, ImportError> {
    let boxed = |p: &Position, size: [f64; 3]| Obstacle {
        x: p.x,
        y: p.y,
        yaw: 0.0,
        buried: 0.5 * size[2] - (p.z - ground.height(p.x, p.y)),
        kind: ObstacleKind::Box { size },
    };
    let rocks = rock_sizes(file, config)?;
    let rocks =
        rocks.into_iter().zip(&config.obstacles.rocks).map(|(size, rock)| boxed(&rock.position, size));
    let trees = config.obstacles.trees.iter().map(|tree| boxed(&tree.position, TREE_SIZE));
    Ok(rocks.chain(trees).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use TerrainClass::{Clay, Mud, Sand, Snow};
    use vb_world::SoilLevels;

    fn patches(n: usize, patch: f64, classes: Vec<TerrainClass>) -> Semantics {
        let friction = classes.iter().map(|c| if c.is_deformable() { 0.0 } else { 0.5 }).collect();
        Semantics { rows: n, cols: n, patch, classes, friction, soil: SoilLevels::default() }
    }

    #[test]
    fn soil_lies_in_bands_from_the_north_in_alphabetical_order() {
        // `combine_deformation` in envs/terrain.py: bands begin at y = 64 and end at 0 (two) or at 21 and -22 (three
        // classes).
        let of = |classes: &[TerrainClass]| {
            let all = (0..256).map(|k| classes[k % classes.len()]).collect();
            bands(&patches(16, 8.0, all), 129)
        };
        let one = of(&[Snow]);
        assert!(one.patch == 8.0 && one.classes.iter().all(|&c| c == Snow));
        let two = of(&[Snow, Mud]);
        assert_eq!((two.patch, two.class_at(3.0, 0.1), two.class_at(3.0, -0.1)), (8.0, Mud, Snow));
        let three = of(&[Snow, Mud, Sand]);
        assert_eq!((three.patch, three.rows, three.cols), (1.0, 128, 128));
        for (y, class) in
            [(63.0, Mud), (21.1, Mud), (20.9, Sand), (-21.9, Sand), (-22.1, Snow), (-63.0, Snow)]
        {
            assert_eq!(three.class_at(-5.0, y), class, "{y}");
        }
    }

    #[test]
    fn soil_in_a_mixed_world_must_be_a_rectangle() {
        let check =
            |classes| semantics(Path::new("config9_low.yaml"), Terrain::Mixed, &patches(3, 8.0, classes), 25);
        assert!(check(vec![Clay, Mud, Mud, Clay, Mud, Mud, Sand, Clay, Clay]).is_ok());
        let error = check(vec![Clay, Mud, Mud, Clay, Mud, Clay, Sand, Clay, Clay]).unwrap_err().to_string();
        assert!(error.contains("config9_low.yaml: textures: the 3 patches of mud"), "{error}");
        assert!(error.contains("as-described"), "{error}");
    }
}
