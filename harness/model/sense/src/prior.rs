//! The maps that planners receive at the start.

use crate::noise::Seed;
use crate::profile::{PriorElevation, PriorSemantics, Profile, Recogniser};
use vb_math::rng::Stream;
use vb_sdk::{GridFrame, HeightMap, LabelMap, Map};
use vb_world::World;

/// The maps that planners receive at the start; `None` for one that the profile omits.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PriorMaps {
    /// The heights of the ground, m.
    pub elevation: Option<HeightMap>,
    /// The terrain classes, by their labels.
    pub semantics: Option<LabelMap>,
    /// 1 where an obstacle covers any part of the sample's square, else 0.
    pub occupancy: Option<LabelMap>,
}

impl PriorMaps {
    /// The maps of a world, at its scale, with a profile's accuracy.
    #[must_use]
    pub fn new(profile: &Profile, world: &World, seed: &Seed) -> Self {
        let prior = &profile.data().prior;
        Self {
            elevation: prior.elevation.as_ref().map(|p| elevation(p, world, seed)),
            semantics: prior.semantics.as_ref().map(|p| semantics(p, world, seed)),
            occupancy: prior.occupancy.as_ref().map(|p| {
                let o = world.occupancy(p.resolution_m * world.scale);
                Map { frame: frame(o.rows, o.cols, o.resolution, o.origin), data: o.data }
            }),
        }
    }
}

fn frame(rows: usize, cols: usize, resolution: f64, origin: [f64; 2]) -> GridFrame {
    GridFrame { rows: rows as u32, cols: cols as u32, resolution, origin_x: origin[0], origin_y: origin[1] }
}

/// How many squares of a side cover a length: a hair less than the quotient, which rounding may have made too great.
fn squares(length: f64, side: f64) -> usize {
    ((length / side * (1.0 - 1e-12)).ceil() as usize).max(1)
}

fn elevation(prior: &PriorElevation, world: &World, seed: &Seed) -> HeightMap {
    let h = &world.heightfield;
    let corner = [-h.half_x(), -h.half_y()];
    let PriorElevation::Coarse { resolution_m, smoothing_m, error_std_m, error_correlation_m } = *prior
    else {
        return Map {
            frame: frame(h.rows(), h.cols(), h.resolution(), corner),
            data: h.heights().iter().map(|&z| z as f32).collect(),
        };
    };
    let resolution = resolution_m * world.scale;
    let nodes = |half: f64| squares(2.0 * half, resolution) + 1;
    let (rows, cols) = (nodes(h.half_y()), nodes(h.half_x()));
    let half = 0.5 * smoothing_m * world.scale;
    // Beyond the edge there is no ground to be averaged; the nearest counts instead.
    let height =
        |x: f64, y: f64| h.height(x.clamp(-h.half_x(), h.half_x()), y.clamp(-h.half_y(), h.half_y()));
    let steps = (half / h.resolution()).ceil() as i32;
    let mean = |x: f64, y: f64| {
        let (mut sum, mut count) = (0.0, 0.0);
        for i in -steps..=steps {
            for j in -steps..=steps {
                let off = |k: i32| if steps == 0 { 0.0 } else { half * f64::from(k) / f64::from(steps) };
                sum += height(x + off(i), y + off(j));
                count += 1.0;
            }
        }
        sum / count
    };
    let stream = seed.stream("prior", "elevation");
    let error = field(rows, cols, resolution_m / error_correlation_m, stream);
    let mut data = Vec::with_capacity(rows * cols);
    for row in 0..rows {
        for col in 0..cols {
            let (x, y) = (corner[0] + col as f64 * resolution, corner[1] + row as f64 * resolution);
            data.push((mean(x, y) + error_std_m * world.scale * error[row * cols + col]) as f32);
        }
    }
    Map { frame: frame(rows, cols, resolution, corner), data }
}

/// A random field of variance 1 whose correlation is exp(−(|dx| + |dy|)/L), on nodes at a distance of `step` correlation
/// lengths: a first-order Gauss–Markov process along both axes, with the same exact discretisation as in time.
fn field(rows: usize, cols: usize, step: f64, mut stream: Stream) -> Vec<f64> {
    let keep = vb_math::exp(-step);
    let fresh = (1.0 - keep * keep).sqrt();
    let mut values = vec![0.0; rows * cols];
    for row in 0..rows {
        // A row's own process, of variance 1 along the row, which then mixes with the row before.
        let mut along = 0.0;
        for col in 0..cols {
            let n = stream.normal(0.0, 1.0);
            along = if col == 0 { n } else { keep * along + fresh * n };
            let k = row * cols + col;
            values[k] = if row == 0 { along } else { keep * values[k - cols] + fresh * along };
        }
    }
    values
}

fn semantics(prior: &PriorSemantics, world: &World, seed: &Seed) -> LabelMap {
    let s = &world.semantics;
    let centre = |count: usize| -0.5 * (count as f64 - 1.0) * s.patch;
    let PriorSemantics::Coarse { resolution_m, confusions } = prior else {
        return Map {
            frame: frame(s.rows, s.cols, s.patch, [centre(s.cols), centre(s.rows)]),
            data: s.classes.iter().map(|c| c.label()).collect(),
        };
    };
    let h = &world.heightfield;
    let resolution = resolution_m * world.scale;
    let (rows, cols) = (squares(2.0 * h.half_y(), resolution), squares(2.0 * h.half_x(), resolution));
    let (recogniser, mut stream) = (Recogniser::new(confusions), seed.stream("prior", "semantics"));
    // Two looks at each patch along a side find the commonest class well enough.
    let looks = ((2.0 * resolution / s.patch).ceil() as usize).clamp(1, 64);
    let mut data = Vec::with_capacity(rows * cols);
    for row in 0..rows {
        for col in 0..cols {
            let mut votes = [0u32; 10];
            for i in 0..looks {
                for j in 0..looks {
                    let at = |k: usize, within: usize, half: f64| {
                        (k as f64 + (within as f64 + 0.5) / looks as f64) * resolution - half
                    };
                    let class = world.class_at(at(col, j, h.half_x()), at(row, i, h.half_y()));
                    votes[usize::from(class.label())] += 1;
                }
            }
            let most = (0..votes.len()).max_by_key(|&k| (votes[k], std::cmp::Reverse(k))).unwrap_or(0);
            data.push(recogniser.see(most as u8, stream.unit()));
        }
    }
    let origin = [0.5 * resolution - h.half_x(), 0.5 * resolution - h.half_y()];
    Map { frame: frame(rows, cols, resolution, origin), data }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_on_the_field_are_correlated_by_their_distance_and_its_variance_is_one() {
        let (rows, cols, step) = (400, 400, 0.25);
        let f = field(rows, cols, step, Stream::new(1, &["field"]));
        let product = |dr: usize, dc: usize| {
            let mut sum = 0.0;
            for r in 0..rows - dr {
                for c in 0..cols - dc {
                    sum += f[r * cols + c] * f[(r + dr) * cols + c + dc];
                }
            }
            sum / ((rows - dr) * (cols - dc)) as f64
        };
        // The correlations of a square of 100 × 100 correlation lengths, each of which has about (2/2)² independent values:
        // a standard error of √2/100 for the variance. Five of them.
        for (dr, dc) in [(0, 0), (0, 1), (1, 0), (4, 0), (0, 4), (4, 4)] {
            let expected = vb_math::exp(-step * (dr + dc) as f64);
            assert!((product(dr, dc) - expected).abs() < 0.07, "{dr} {dc}: {}", product(dr, dc));
        }
    }
}
