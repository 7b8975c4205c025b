//! Semantic patches in clusters, friction by class (as in the original's envs/gen-VertiBench.py).
//!
//! Unlike the original, which cuts deformable worlds into bands and mixed ones into rectangles to please its
//! simulator, every world keeps its clusters.

use super::params::{FrictionParams, GridParams, GroundParams, Normal};
use vb_math::rng::Stream;
use vb_world::{Semantics, SoilLevel, SoilLevels, Terrain, TerrainClass};

/// Largest numbers of rigid and of deformable clusters in a mixed world: all the classes there are.
const MIXED_LIMITS: [usize; 2] = [7, 3];

/// Draws of the centres of a world's clusters before giving up on patches of their own. The widest spread that the rules allow hits the
/// world once in 600 draws.
const DRAWS: usize = 1_000_000;

/// The clusters of a world found no patches of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NoPatch {
    pub(crate) clusters: usize,
    pub(crate) draws: usize,
}

pub(crate) fn semantics(
    grid: &GridParams,
    g: &GroundParams,
    ground: Terrain,
    levels: SoilLevels,
    rng: &mut Stream,
) -> Result<Semantics, NoPatch> {
    let classes = cluster_classes(g, ground, rng);
    let centres = centres(g, classes.len(), rng)?;
    let n = g.patches;
    let mut patches = Vec::with_capacity(n * n);
    let mut frictions = Vec::with_capacity(n * n);
    for row in 0..n {
        for col in 0..n {
            let distance2 = |c: &[usize; 2]| {
                let (dr, dc) = (row.abs_diff(c[0]), col.abs_diff(c[1]));
                dr * dr + dc * dc
            };
            // The first of equally near centres, as `min_by_key` returns it.
            let nearest = (0..centres.len()).min_by_key(|&k| distance2(&centres[k])).unwrap_or(0);
            let class = classes[nearest];
            let mu = friction(&g.friction, class, rng);
            patches.push(class);
            frictions.push(mu);
        }
    }
    let patch = (grid.nodes - 1) as f64 * grid.resolution / n as f64;
    // A class that isn't there has no level to keep.
    let kept = |class, level| if patches.contains(&class) { level } else { SoilLevel::default() };
    let soil = SoilLevels {
        mud: kept(TerrainClass::Mud, levels.mud),
        sand: kept(TerrainClass::Sand, levels.sand),
        snow: kept(TerrainClass::Snow, levels.snow),
    };
    Ok(Semantics { rows: n, cols: n, patch, classes: patches, friction: frictions, soil })
}

/// Levels of soil of the world at an index, whose elevation level is `index` modulo 3. They are dealt out among the
/// worlds of that level whose ground yields: soft, medium and hard go round the three classes, so that each of these
/// has each of them equally often, now one way round and now the other, so that all six ways to give them come up.
pub(crate) fn soil_levels(order: &[Terrain], index: usize) -> SoilLevels {
    let yields = |i: &usize| order[i % order.len()] != Terrain::Rigid;
    let dealt = (index % 3..index).step_by(3).filter(yields).count() + index % 3;
    let level = |class: usize| {
        let turn = if (dealt / 3).is_multiple_of(2) { class } else { 2 * class };
        SoilLevel::ALL[(dealt + turn) % 3]
    };
    SoilLevels { mud: level(0), sand: level(1), snow: level(2) }
}

/// Friction of a patch of a class, drawn; 0 where the ground yields.
pub(crate) fn friction(params: &FrictionParams, class: TerrainClass, rng: &mut Stream) -> f64 {
    params.get(class).map_or(0.0, |normal| drawn_friction(normal, params.clip, rng))
}

/// Friction of a patch, drawn from a normal distribution and clipped.
pub(crate) fn drawn_friction(normal: Normal, [low, high]: [f64; 2], rng: &mut Stream) -> f64 {
    let mu = rng.normal(normal.mean, normal.std).clamp(low, high);
    // Three decimals are plenty, and people read them. Rounding must not leave the clip.
    ((mu * 1000.0).round() / 1000.0).clamp(low, high)
}

/// One class a cluster, none twice.
fn cluster_classes(g: &GroundParams, ground: Terrain, rng: &mut Stream) -> Vec<TerrainClass> {
    let [low, high] = g.clusters.get(ground);
    let count = between(low, high, rng);
    let (rigid, deformable) = match ground {
        Terrain::Rigid => (count, 0),
        Terrain::Deformable => (0, count),
        Terrain::Mixed => {
            let rigid = between(1, count - 1, rng).min(MIXED_LIMITS[0]);
            (rigid, (count - rigid).min(MIXED_LIMITS[1]))
        }
    };
    let mut pick = |deformable: bool, n: usize| {
        let mut all: Vec<_> =
            TerrainClass::ALL.into_iter().filter(|c| c.is_deformable() == deformable).collect();
        rng.shuffle(&mut all);
        all.truncate(n);
        all
    };
    let mut classes = pick(false, rigid);
    classes.extend(pick(true, deformable));
    classes
}

/// Distinct patches, normally distributed about the middle.
fn centres(g: &GroundParams, count: usize, rng: &mut Stream) -> Result<Vec<[usize; 2]>, NoPatch> {
    let n = g.patches as f64;
    let (mean, std) = (0.5 * (n - 1.0), g.centre_spread * n);
    let mut centres = Vec::with_capacity(count);
    for _ in 0..DRAWS {
        if centres.len() == count {
            return Ok(centres);
        }
        let draw = [rng.normal(mean, std).trunc(), rng.normal(mean, std).trunc()];
        if draw.iter().any(|v| *v < 0.0 || *v >= n) {
            continue;
        }
        let centre = draw.map(|v| v as usize);
        if !centres.contains(&centre) {
            centres.push(centre);
        }
    }
    Err(NoPatch { clusters: count, draws: DRAWS })
}

/// Uniform in low..=high.
fn between(low: usize, high: usize, rng: &mut Stream) -> usize {
    low + rng.below((high - low + 1) as u64) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    #[test]
    fn each_class_of_soil_gets_each_level_equally_often_at_every_elevation() {
        let order = crate::generate::GeneratorParams::default().ground.order;
        let mut counts = BTreeMap::new();
        let mut ways = BTreeMap::new();
        for index in (0..900).filter(|i| order[i % order.len()] != Terrain::Rigid) {
            let soil = soil_levels(&order, index);
            for (class, level) in [("mud", soil.mud), ("sand", soil.sand), ("snow", soil.snow)] {
                *counts.entry((class, index % 3, level.name())).or_insert(0) += 1;
            }
            *ways.entry([soil.mud, soil.sand, soil.snow].map(SoilLevel::name)).or_insert(0) += 1;
        }
        assert_eq!(counts.len(), 27);
        assert!(counts.values().all(|n| (39..=41).contains(n)), "{counts:?}");
        assert_eq!(ways.len(), 6, "all orders of three levels: {ways:?}");
        assert!(ways.values().all(|n| (57..=63).contains(n)), "{ways:?}");
    }
}
