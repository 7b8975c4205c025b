//! Motion of the grains of granular beds in a repeated simulation.

use serde_json::{Value, json};
use vb_sim::Simulation;
use vb_world::World;

use crate::packed::{packed, steps};

/// Displacement from which a move of a grain is stored, in radii.
const MOVED: f64 = 0.1;
/// Grains that never moved and are deeper than this below the ground are left out, in radii: others hide them.
const HIDDEN: f64 = 3.0;
/// Maximum number of stored moves; a crossing of 10 m of gravel has about ten thousand.
const MOST: usize = 2_000_000;

/// The grains that can be seen, and their moves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grains {
    /// The radius of each grain, m.
    pub radii: Vec<f64>,
    /// The centre of each grain at the start, m.
    pub start: Vec<[f64; 3]>,
    /// In the order of time.
    pub moves: Vec<GrainMove>,
}

/// A grain that is somewhere else.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrainMove {
    /// s.
    pub time: f64,
    /// The number of the grain.
    pub grain: u32,
    /// Its centre, m.
    pub to: [f64; 3],
}

impl Grains {
    /// The grains of a simulation as they are now.
    pub(crate) fn of(sim: &Simulation) -> Self {
        let (start, radii) = sim.grains().unzip();
        Self { radii, start, moves: Vec::new() }
    }

    /// Takes note of which grains are elsewhere than `told`, which is brought up to date.
    pub(crate) fn look(&mut self, sim: &Simulation, told: &mut [[f64; 3]]) {
        let time = sim.time();
        for (grain, ((at, radius), told)) in sim.grains().zip(told).enumerate() {
            let way = [0, 1, 2].map(|k| at[k] - told[k]);
            let moved = way.iter().map(|w| w * w).sum::<f64>() > (MOVED * radius) * (MOVED * radius);
            if moved && self.moves.len() < MOST {
                *told = at;
                self.moves.push(GrainMove { time, grain: grain as u32, to: at });
            }
        }
    }

    /// Without the grains that nobody can see.
    pub(crate) fn seen(self, world: &World) -> Self {
        let mut keep: Vec<bool> = self
            .start
            .iter()
            .zip(&self.radii)
            .map(|(at, radius)| {
                let top = world.heightfield.height(at[0], at[1]);
                top - at[2] - radius < HIDDEN * radius
            })
            .collect();
        self.moves.iter().for_each(|m| keep[m.grain as usize] = true);
        let mut numbers = vec![0; keep.len()];
        let mut kept = Self::default();
        for (k, _) in keep.iter().enumerate().filter(|(_, keep)| **keep) {
            numbers[k] = kept.radii.len() as u32;
            kept.radii.push(self.radii[k]);
            kept.start.push(self.start[k]);
        }
        kept.moves =
            self.moves.iter().map(|m| GrainMove { grain: numbers[m.grain as usize], ..*m }).collect();
        kept
    }

    /// Centres (m) and radii (m) at a time.
    pub(crate) fn at(&self, time: f64) -> Vec<([f64; 3], f64)> {
        let mut grains: Vec<([f64; 3], f64)> =
            self.start.iter().copied().zip(self.radii.iter().copied()).collect();
        let until = self.moves.partition_point(|m| m.time <= time);
        for m in &self.moves[..until] {
            grains[m.grain as usize].0 = m.to;
        }
        grains
    }

    /// JSON for the page, lengths as multiples of `unit` (m): radii, initial positions, and moves with their times.
    pub(crate) fn json(&self, unit: f64) -> Value {
        let moves = self.moves.iter().map(|m| [f64::from(m.grain), m.to[0], m.to[1], m.to[2]]);
        json!({
            "radii": packed(self.radii.iter().map(|r| [*r]), [unit]),
            "start": packed(self.start.iter().copied(), [unit; 3]),
            "steps": steps(self.moves.iter().map(|m| m.time)),
            "moves": packed(moves, [1.0, unit, unit, unit]),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grains_are_where_they_were_told_last_and_hidden_ones_are_left_out() {
        let world = World::uniform(
            "w",
            vb_world::Heightfield::flat(3, 3, 1.0, 1.0),
            vb_world::TerrainClass::Gravel,
            0.5,
        );
        let start = vec![[0.0, 0.0, 0.96], [0.1, 0.0, 0.7], [0.2, 0.0, 0.7]];
        let moves = vec![
            GrainMove { time: 1.0, grain: 2, to: [0.2, 0.1, 0.8] },
            GrainMove { time: 2.0, grain: 2, to: [0.2, 0.2, 0.9] },
        ];
        let grains = Grains { radii: vec![0.04, 0.03, 0.035], start, moves }.seen(&world);
        assert_eq!(grains.radii, [0.04, 0.035], "the second is deep and never moved");
        assert_eq!(grains.at(0.5), [([0.0, 0.0, 0.96], 0.04), ([0.2, 0.0, 0.7], 0.035)]);
        assert_eq!(grains.at(1.0)[1].0, [0.2, 0.1, 0.8]);
        assert_eq!(grains.at(9.0)[1].0, [0.2, 0.2, 0.9]);
    }
}
