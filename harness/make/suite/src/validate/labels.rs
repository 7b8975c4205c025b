//! Labels against what the world is.

use super::{Findings, Rule};
use crate::generate::GeneratorParams;
use crate::level::spread;
use crate::statistics::WorldStatistics;
use vb_world::{Density, Elevation, Part, World};

/// How far the spread of heights, by which the slopes are as they are, may be from that of its level, as a factor. Worlds of the original stay within 1.35 of
/// their level's mean (docs/worlds.md), and neighbouring levels lie 1.7 to 1.9 apart.
const SPREAD: f64 = 1.6;

/// A density's number of obstacles holds for a world of this area, m².
const AREA: f64 = 128.0 * 128.0;

pub(super) fn check(world: &World, rules: &GeneratorParams, findings: &mut Findings<'_>) {
    let figures = WorldStatistics::of(world);
    let std = spread(&world.heightfield);
    // A level may have the relief of the paper's recipe, or one that is calibrated by mobility.
    let paper = GeneratorParams::paper().elevation.std.get(world.elevation);
    let own = rules.elevation.std.get(world.elevation);
    let (least, most) = (paper.min(own), paper.max(own));
    // The lowest level has no lower bound, and the highest no upper one.
    let too_flat = world.elevation != Elevation::Low && std < least / SPREAD;
    let too_steep = world.elevation != Elevation::High && std > most * SPREAD;
    let usual = if too_flat { least } else { most };
    if too_flat || too_steep {
        let word = if too_flat { "flat" } else { "rugged" };
        let problem = format!(
            "{} is unusual for slopes that correspond to a height standard deviation of {std:.3} m (usual: {usual} m): too {word}; use another \
             level or scale the heights",
            world.elevation.name()
        );
        findings.warn(Rule::Labels, Part::World, "elevation", &problem);
    }
    let usual = |d: Density| (rules.obstacles.boulders.get(d) + rules.obstacles.trees.get(d)) as f64;
    let area = figures.extent[0] * figures.extent[1];
    let here = world.obstacles.len() as f64 * AREA / area;
    // Nearest in proportion: 11 obstacles are as far from 22 as 44 are. None at all are the fewest.
    let off = |d: Density| (here.max(1.0) / usual(d).max(1.0)).max(usual(d).max(1.0) / here.max(1.0));
    let fits = Density::ALL.into_iter().all(|d| off(world.density) <= off(d));
    if !fits {
        let problem = format!(
            "{} is unusual for {} obstacles, which correspond to {here:.0} on 128 x 128 m (usual: {}): use another density or change \
             their number",
            world.density.name(),
            world.obstacles.len(),
            usual(world.density)
        );
        findings.warn(Rule::Labels, Part::World, "density", &problem);
    }
}
